//! Tests of `proposal.rs`.

use super::super::recipe::Recipe;
use super::super::source::Source;
use super::*;

fn proposed(name: &str, table: &str, layout: Option<&str>) -> Result<Proposal, String> {
    let folder = std::env::temp_dir().join(format!("palpate-proposal-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, table).unwrap();
    let proposal = propose(&path, name, layout, &Timing::default());
    std::fs::remove_file(&path).unwrap();
    proposal.map_err(|e| e.to_string())
}

/// A heading and three rows: the columns of `before`, then 48 named by number.
fn table(before: [&str; 4], name: impl Fn(usize) -> String, separator: &str) -> String {
    let line = |row: usize, of: &dyn Fn(usize) -> String| {
        let fields: Vec<String> = (0..48).map(of).collect();
        [
            &[before[row]][..],
            &fields.iter().map(String::as_str).collect::<Vec<_>>(),
        ]
        .concat()
        .join(separator)
    };
    let rows: Vec<String> = (1..4)
        .map(|row| line(row, &|c| (40_000 + c + row % 2).to_string()))
        .collect();
    format!("{}\n{}\n", line(0, &name), rows.join("\n"))
}

fn says(proposal: &Proposal, part: &str) -> bool {
    let mut understood = proposal.understood.iter();
    let mut assumed = proposal.assumed.iter();
    understood.any(|(_, text)| text.contains(part)) || assumed.any(|a| a.what.contains(part))
}

#[test]
fn a_table_with_names_is_understood() {
    let names = |c: usize| format!("raw_{}{}", ["x", "y", "z"][c / 16], c % 16);
    let text = table(["Time (ms)", "0", "10", "20"], names, ";");
    let proposal = proposed("Press 1.csv", &text, None).unwrap();
    let recipe = Recipe::read(&Source::new("p.toml", &*proposal.text)).unwrap();
    assert_eq!(
        (recipe.name.as_str(), recipe.layout.as_str()),
        ("press-1", "uskin-4x4")
    );
    assert_eq!(recipe.time.unwrap().column, "Time (ms)");
    assert_eq!(recipe.modules[0].prefix.as_deref(), Some("raw_"));
    for part in [
        "49 columns between semicolons",
        "by their numbers and not as they stand",
        "the skin is `uskin-4x4`",
    ] {
        assert!(says(&proposal, part), "{part}: {proposal:#?}");
    }
    assert!(!says(&proposal, "rows per second"), "{proposal:#?}");
}

#[test]
fn what_a_table_leaves_open_is_assumed() {
    let bare = table(["", "", "", ""], |c| (40_000 + c).to_string(), " ");
    let proposal = proposed("bare.txt", &bare, None).unwrap();
    let recipe = Recipe::read(&Source::new("p.toml", &*proposal.text)).unwrap();
    assert_eq!(
        (recipe.rate_hz, recipe.modules[0].first_column),
        (Some(100.0), Some(1))
    );
    for part in [
        "100 rows per second, as nothing says",
        "stand in the layout's order",
    ] {
        assert!(says(&proposal, part), "{part}: {proposal:#?}");
    }
    // Names that hold more than their numbers say: the columns are listed.
    let both = |c: usize| {
        if c < 24 {
            format!("a{c}")
        } else {
            format!("b{c}")
        }
    };
    let text = table(["t", "0.0", "0.01", "0.02"], both, ",");
    assert!(
        proposed("both.csv", &text, Some("uskin-4x4"))
            .unwrap_err()
            .contains("24 of `a#`, 24 of `b#`")
    );
    let other = proposed("other.csv", &text, Some("tactile-brush-4x3")).unwrap_err();
    assert!(
        other.contains("the columns of layout `tactile-brush-4x3`"),
        "{other}"
    );
    let narrow = proposed("narrow.csv", "a1,a2\n1,2\n1,2\n", None).unwrap_err();
    assert!(
        narrow.contains("hil new layout") && narrow.contains("2 of `a#`"),
        "{narrow}"
    );
}

#[test]
fn values_in_a_unit_have_a_gain() {
    let text =
        table(["t", "0.0", "0.01", "0.02"], |c| format!("f{c} [N]"), ",").replace(",400", ",0.400");
    let proposal = proposed("newtons.csv", &text, None).unwrap();
    let recipe = Recipe::read(&Source::new("p.toml", &*proposal.text)).unwrap();
    assert_eq!(recipe.unit.as_deref(), Some("N"));
    assert!(recipe.gain.unwrap() >= 1000.0, "{}", proposal.text);
    assert!(says(&proposal, "by the noise of the first rows"));
    assert!(
        says(&proposal, "times count seconds, by their numbers"),
        "{proposal:#?}"
    );
}
