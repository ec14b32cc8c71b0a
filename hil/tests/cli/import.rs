//! `hil import`: from a maker's file to contacts in two commands.

use super::*;

/// A recording of one module under its maker's names, by text order.
fn recording(folder: &Folder) -> String {
    let mut order: Vec<usize> = (0..48).collect();
    order.sort_by_key(|c| c.to_string());
    let names: Vec<String> = order.iter().map(|c| format!("ch{c}")).collect();
    let mut text = format!("Time (ms);{}\n", names.join(";"));
    for row in 0..60 {
        let counts = contacts::pad(row, 0);
        let values: Vec<String> = order.iter().map(|c| counts[*c].to_string()).collect();
        text += &format!("{};{}\n", row * 10, values.join(";"));
    }
    folder.write("press.csv", &text).display().to_string()
}

#[test]
fn a_makers_file_becomes_contacts_in_two_commands() {
    let folder = Folder::new("import");
    let file = recording(&folder);
    let recipe = folder.path("proposed.toml").display().to_string();
    let said = hil(&["import", &file, "--out", &recipe]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    for part in [
        "49 columns between semicolons",
        "column \"Time (ms)\", milliseconds",
        "by their numbers and not as they stand",
        "100.0 rows per second: 60 rows in 0.590 s",
        "the first 20 rows",
        "the skin is `uskin-4x4`",
        "(--layout)",
        "pad: `@` is",
        "Frames of pad",
    ] {
        let text = said.out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(part), "no `{part}` in: {}", said.out);
    }
    assert!(
        said.out.lines().all(|line| line.chars().count() <= 80),
        "{}",
        said.out
    );
    let own = contacts::recording(&folder, 60);
    let expected = good(&["contacts", &own, "--layout", "uskin-4x4", "--rate", "100"]);
    assert_eq!(good(&["contacts", &recipe]), expected);
    assert_eq!(hil(&["check", &recipe]).status, Some(0));
    // Its first line leads an editor to the schema.
    let text = fs::read_to_string(&recipe).unwrap();
    let schema = text.lines().next().unwrap().strip_prefix("#:schema ");
    assert!(folder.path(schema.unwrap()).is_file(), "{text}");
    // Without a file for it, the recipe stands on standard output.
    let shown = hil(&["import", &file]);
    assert!(
        shown.out.ends_with(&fs::read_to_string(&recipe).unwrap()),
        "{}",
        shown.out
    );
    refused_with(
        &["import", &file, "--out", &recipe],
        &["--force overwrites it"],
    );
    assert_eq!(
        hil(&["import", &file, "--out", &recipe, "--force"]).status,
        Some(0)
    );
    let narrow = folder
        .write("narrow.csv", "a1,a2\n1,2\n1,2\n")
        .display()
        .to_string();
    refused_with(&["import", &narrow], &["hil new layout", "2 of `a#`"]);
}
