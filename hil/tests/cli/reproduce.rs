//! `hil reproduce`: rows by name, their text, JSON and page.

use super::*;

#[test]
fn a_row_is_made_alone_and_counted() {
    // A whole name is one row, whatever else begins so.
    assert!(good(&["reproduce", "eq-4.1"]).contains("1 row:"));
    let text = good(&["reproduce", "eq-5.2"]);
    for words in ["eq-5.2  agrees", "alone: hil reproduce eq-5.2", "1 row:"] {
        assert!(text.contains(words), "{text}");
    }
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
}

#[test]
fn a_beginning_stands_for_all_rows_with_it() {
    let folder = Folder::new("reproduce");
    let page = folder.path("thesis.html").display().to_string();
    let text = good(&["reproduce", "claim-5.4-p", "--json", "--html", &page]);
    let rows: serde_json::Value = serde_json::from_str(&text).unwrap();
    let ids: Vec<_> = rows.as_array().unwrap().iter().map(|r| &r["id"]).collect();
    assert_eq!(ids, ["claim-5.4-power", "claim-5.4-pwm"]);
    assert_eq!(rows[1]["mark"], "differs");
    assert!(rows[1]["cause"].as_str().unwrap().contains("196.89"));
    let page = folder.text("thesis.html");
    assert!(page.contains("claim-5.4-pwm") && page.contains("The thesis, reproduced"));
}

/// Panels of figures 3.4 to 3.6: three scales of real textures, the map of z1 and z2, ratings over both, three controls.
#[test]
fn figures_of_chapter_3_have_all_panels() {
    let folder = Folder::new("panels");
    let page = folder.path("thesis.html").display().to_string();
    good(&["reproduce", "fig-3.4", "fig-3.5", "--html", &page, "-q"]);
    let page = folder.text("thesis.html");
    let sections: Vec<&str> = page.split("<section id=").skip(1).collect();
    let panels = |id: &str| {
        let own = sections
            .iter()
            .find(|s| s.starts_with(&format!("\"{id}\"")));
        own.map_or(0, |section| section.matches("<svg").count())
    };
    let found = [
        "fig-3.4",
        "fig-3.5-A",
        "fig-3.5-B",
        "fig-3.5-C",
        "fig-3.5-D",
    ]
    .map(panels);
    assert_eq!(found, [3, 1, 1, 1, 3]);
    for label in [
        ">z1<",
        ">z2<",
        ">f_PWM [Hz]<",
        ">handkerchief<",
        "hardness rated",
    ] {
        assert!(page.contains(label), "{label}");
    }
    assert!(!page.contains("NaN"));
}

#[test]
fn an_unknown_row_is_refused_with_the_names_of_all() {
    refused_with(
        &["reproduce", "eq-5.22"],
        &["`eq-5.22`", "eq-5.2", "fig-4.5-A"],
    );
}
