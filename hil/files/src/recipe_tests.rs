//! Tests of recipes: what cannot be in one, and what their plans make of recordings.

use super::super::layout::{LayoutFile, SensorLayout};
use super::super::reading::Text;
use super::super::recipe_plan::RecipePlan;
use super::super::{Rows, Take, Timing};
use super::*;

const HEAD: &str =
    "kind = \"recording\"\nname = \"r\"\ndescription = \"A recipe.\"\nlayout = \"pads\"\n";
const TWO: &str =
    "[[modules]]\nname = \"left\"\nprefix = \"l\"\n[[modules]]\nname = \"right\"\nprefix = \"r\"\n";

/// Two modules of 2 x 3 taxels.
fn pads(axes: u8) -> SensorLayout {
    let grid = "grid = { rows = 2, columns = 3, pitch_mm = 1.0 }";
    let text = format!(
        "kind = \"sensor\"\nname = \"pads\"\ndescription = \"Pads.\"\naxes = {axes}\n\
         [[modules]]\nname = \"left\"\n{grid}\n[[modules]]\nname = \"right\"\n{grid}\n"
    );
    match LayoutFile::read(&Source::new("pads.toml", text)).unwrap() {
        LayoutFile::Sensor(layout) => layout,
        LayoutFile::Display(_) => panic!("a display"),
    }
}

fn one(axes: u8) -> SensorLayout {
    let mut layout = pads(axes);
    layout.modules.truncate(1);
    layout
}

fn planned(text: &str, layout: &SensorLayout) -> Result<RecipePlan, String> {
    let source = Source::new("r.toml", format!("{HEAD}{text}"));
    let recipe = Recipe::read(&source).map_err(|e| e.to_string())?;
    RecipePlan::new(&recipe, &source, layout).map_err(|e| e.to_string())
}

/// The rows of a table by a recipe, and what is said of it.
fn read(
    recipe: &str,
    layout: &SensorLayout,
    table: &str,
) -> Result<(Vec<Vec<u16>>, Vec<String>), String> {
    let plan = planned(recipe, layout)?;
    let source = Source::new("r.toml", format!("{HEAD}{recipe}"));
    let recipe = Recipe::read(&source).unwrap();
    let timing = Timing {
        column: recipe.clock(),
        rate_hz: recipe.rate_hz,
        ..Timing::default()
    };
    let text = Text::new("t.csv", table.as_bytes(), 1 << 16);
    let mut rows =
        Rows::over(text, Take::Recipe(&plan), Some(&timing)).map_err(|e| e.to_string())?;
    let (mut all, mut row) = (Vec::new(), Vec::new());
    while let Some(at) = rows.advance(&mut row).map_err(|e| e.to_string())? {
        let mut with_time = vec![u16::try_from(at.time_us / 1000).unwrap()];
        with_time.extend(&row);
        all.push(with_time);
    }
    Ok((all, rows.notes()))
}

fn rows(recipe: &str, layout: &SensorLayout, table: &str) -> Vec<Vec<u16>> {
    read(recipe, layout, table).unwrap().0
}

#[test]
fn what_cannot_be_is_named_with_its_line() {
    let cases = [
        (
            "rate_hz = 0.0\n",
            "r.toml:5: rate_hz: expected a number from 0.1",
        ),
        (
            "rate_hz = 9.0\ntime = { column = \"t\", unit = \"s\" }\n",
            "rate or a column of times",
        ),
        (
            "time = { column = \"t\", unit = \"h\" }\n",
            "r.toml:5: time.unit",
        ),
        ("delimiter = \"pipe\"\n", "`semicolon`"),
        (
            "unit = \"N\"\n",
            "modules[0].gain: expected counts per unit",
        ),
        (
            "gain = 0.0\n",
            "gain: expected counts per unit, other than 0",
        ),
        ("hello = 1\n", "the unknown key `hello`"),
    ];
    for (line, expected) in cases {
        let said = planned(&format!("{line}{TWO}"), &pads(3)).unwrap_err();
        assert!(said.contains(expected), "{line}: {said}");
    }
    let modules = [
        (
            "name = \"left\"\n",
            "r.toml:5: modules[0].prefix: expected prefix, columns or first_column",
        ),
        (
            "prefix = \"a\"\nfirst_column = 1\n",
            "one of prefix, columns and first_column",
        ),
        ("columns = [\"a\"]\norder = \"file\"\n", "no order"),
        ("columns = [\"a\"]\nwithout = [1]\n", "leaves out"),
        (
            "prefix = \"a\"\nturned_deg = 45\n",
            "r.toml:7: modules[0].turned_deg: expected 0, 90, 180 or 270",
        ),
        ("prefix = \"a\"\nsensor = \"1\"\n", "sensor_column"),
        ("prefix = \"a\"\noffset = 1.0\n", "a gain beside it"),
        (
            "prefix = \"a\"\nname = \"middle\"\n",
            "each module of layout `pads` once (left)",
        ),
    ];
    for (table, expected) in modules {
        let said = planned(&format!("[[modules]]\n{table}"), &one(3)).unwrap_err();
        assert!(said.contains(expected), "{table}: {said}");
    }
    let said = planned("[[modules]]\nprefix = \"a\"\n", &pads(3)).unwrap_err();
    assert!(said.contains("none for `right`"), "{said}");
    let twice = TWO.replace("right", "left");
    assert!(
        planned(&twice, &pads(3))
            .unwrap_err()
            .contains("modules[1].name")
    );
    let mut points = one(1);
    points.modules[0].points_mm = Some(vec![[0.0, 0.0], [1.0, 0.0]]);
    points.modules[0].grid = None;
    let said = planned("[[modules]]\nprefix = \"a\"\nmirrored = true\n", &points).unwrap_err();
    assert!(
        said.contains("a module that is turned or mirrored has a `grid`"),
        "{said}"
    );
}

#[test]
fn modules_by_their_prefixes_stand_in_the_order_of_the_layout() {
    // Taxel 3 of the right one is not in the layout, and 10 stands before 2 in the file.
    let table = "ms,r10,r1,r2,r3,r4,r5,r6,l1,l2,l3,l4,l5,l6\n5,10,1,2,3,4,5,6,21,22,23,24,25,26\n";
    let recipe = "time = { column = \"ms\", unit = \"ms\" }\n[[modules]]\nname = \"right\"\nprefix = \"r\"\nwithout = [3]\n\
                  [[modules]]\nname = \"left\"\nprefix = \"l\"\n";
    let expected = vec![5, 21, 22, 23, 24, 25, 26, 1, 2, 4, 5, 6, 10];
    assert_eq!(rows(recipe, &pads(1), table), [expected]);
    let said = read(&recipe.replace("[3]", "[]"), &pads(1), table).unwrap_err();
    assert!(
        said.contains("one group of 6 columns (modules[0] of the recipe), found 7 of `r#`"),
        "{said}"
    );
}

#[test]
fn a_table_without_a_heading_is_read_by_places() {
    let recipe = "time = { column = \"2\", unit = \"s\" }\ndelimiter = \"blanks\"\ndecimal_comma = true\n\
                  [[modules]]\nfirst_column = 3\norder = \"axes-first\"\n";
    let row: Vec<String> = (0..18).map(|n| format!("{n},0")).collect();
    let table = format!("7 0,25 {}\n8 0,5 {}\n", row.join(" "), row.join(" "));
    let found = rows(recipe, &one(3), &table);
    assert_eq!(found.len(), 2);
    assert_eq!(found[0][..7], [250, 0, 6, 12, 1, 7, 13]);
    let named =
        "rate_hz = 100.0\n[[modules]]\ncolumns = [\"f\", \"e\", \"d\", \"c\", \"b\", \"a\"]\n";
    let table = "a,b,c,d,e,f\n1,2,3,4,5,6\n1,2,3,4,5,7\n";
    let expected = [vec![0, 6, 5, 4, 3, 2, 1], vec![10, 7, 5, 4, 3, 2, 1]];
    assert_eq!(rows(named, &one(1), table), expected);
}

#[test]
fn a_module_is_turned_and_mirrored_with_its_axes() {
    let table = "a0,a1,a2,a3,a4,a5\n0,1,2,3,4,5\n";
    let of = |how: &str| {
        let recipe = format!("rate_hz = 9.0\n[[modules]]\nprefix = \"a\"\n{how}");
        rows(&recipe, &one(1), table)[0][1..].to_vec()
    };
    // The maker's picture is 0 1 2 / 3 4 5; a quarter makes it three rows of two.
    assert_eq!(of("turned_deg = 180\n"), [5, 4, 3, 2, 1, 0]);
    assert_eq!(of("mirrored = true\n"), [2, 1, 0, 5, 4, 3]);
    assert_eq!(
        of("mirrored = true\nturned_deg = 180\n"),
        [3, 4, 5, 0, 1, 2]
    );
    // Here it is 0 1 / 2 3 / 4 5, and the layout has two rows of three.
    assert_eq!(of("turned_deg = 90\n"), [1, 3, 5, 0, 2, 4]);
    assert_eq!(of("turned_deg = 270\n"), [4, 2, 0, 5, 3, 1]);
    let names: Vec<String> = (0..6)
        .flat_map(|t| ["x", "y", "z"].map(|a| format!("{a}{t}")))
        .collect();
    let values: Vec<String> = (0..18)
        .map(|n| (1000 * (n % 3 + 1) + n / 3).to_string())
        .collect();
    let table = format!("{}\n{}\n", names.join(","), values.join(","));
    let recipe = "rate_hz = 9.0\n[[modules]]\nprefix = \"\"\nturned_deg = 90\n";
    // A maker's x is the layout's y, and its y points against the layout's x.
    let found = rows(recipe, &one(3), &table);
    assert_eq!(found[0][1..4], [65_535 - 2001, 1001, 3001]);
    // With a gain the value has its sign.
    let found = rows(
        &recipe.replace("[[", "gain = 2.0\noffset = 30000.0\n[["),
        &one(3),
        &table,
    );
    assert_eq!(found[0][1..4], [30_000 - 4002, 32_002, 36_002]);
}

#[test]
fn sensors_that_take_turns_make_rows_of_the_skin() {
    let recipe = "sensor_column = \"id\"\ntime = { column = \"t\", unit = \"ms\" }\n\
                  [[modules]]\nname = \"right\"\nprefix = \"a\"\nsensor = \"B\"\ngain = 10.0\n\
                  [[modules]]\nname = \"left\"\nprefix = \"a\"\nsensor = \"A\"\n";
    let row = |t: u32, id: &str, first: u32| {
        let values: Vec<String> = (first..first + 6).map(|n| n.to_string()).collect();
        format!("{t},{id},{}\n", values.join(","))
    };
    let head = "t,id,a0,a1,a2,a3,a4,a5\n";
    let table = [
        row(1, "B", 20),
        row(2, "A", 10),
        row(3, "C", 0),
        row(4, "A", 11),
        row(5, "A", 12),
        row(6, "B", 21),
        row(7, "B", 22),
    ];
    let (found, notes) = read(recipe, &pads(1), &(head.to_owned() + &table.concat())).unwrap();
    assert_eq!(found.len(), 2);
    assert_eq!(found[0][..8], [2, 10, 11, 12, 13, 14, 15, 200]);
    assert_eq!(found[1][..8], [6, 12, 13, 14, 15, 16, 17, 210]);
    let said = notes.join("\n");
    for part in [
        "1 rows of other sensors",
        "1 rows were replaced",
        "the last rows are not of all sensors",
    ] {
        assert!(said.contains(part), "{said}");
    }
    let alone = read(recipe, &pads(1), &(head.to_owned() + &row(1, "B", 20))).unwrap_err();
    assert!(
        alone.contains("a row of each sensor (A, B) in column 2"),
        "{alone}"
    );
}
