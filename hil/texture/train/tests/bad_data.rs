//! The program on data that are none: one line with file and place, and no model.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// A folder of ten strokes over two materials.
struct Data(PathBuf);

impl Data {
    fn new(name: &str) -> Self {
        let folder = format!("palpate-train-{name}-{}", std::process::id());
        let folder = std::env::temp_dir().join(folder);
        fs::create_dir_all(&folder).unwrap();
        let data = Self(folder);
        for number in 0..10 {
            data.write(
                &format!("{}_{number}.csv", ["a", "b"][number % 2]),
                &rows("7"),
            );
        }
        data.write("materials.csv", &materials("20"));
        data
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }

    /// What the program says, which refuses.
    fn refused(&self, more: &[&str]) -> String {
        let mut command = Command::new(env!("CARGO_BIN_EXE_palpate-train"));
        let model = self.0.join("m.safetensors");
        command
            .arg(&self.0)
            .arg("--model")
            .arg(&model)
            .args(["--window", "10"])
            .args(more);
        let said = command.output().unwrap();
        let error = String::from_utf8(said.stderr).unwrap();
        assert_eq!(said.status.code(), Some(2), "{error}");
        assert!(!error.contains("panicked") && !model.exists(), "{error}");
        error
    }
}

impl Drop for Data {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Readings of one taxel; one of them is this.
fn rows(one: &str) -> String {
    let row = |n: usize| {
        format!(
            "{n},{}\n",
            if n == 4 {
                one.to_owned()
            } else {
                (n % 3).to_string()
            }
        )
    };
    "txl1_x,txl1_y\n".to_owned() + &(0..20).map(row).collect::<String>()
}

fn materials(relief: &str) -> String {
    format!(
        "label,trained,stiffness_n_per_mm,relief_um,wavelength_mm,octaves,friction\n\
         a,true,2,{relief},1,1,0.4\nb,true,8,50,1,1,0.8\n"
    )
}

#[test]
fn a_reading_that_is_no_number_is_named_by_file_row_and_column() {
    let data = Data::new("nan-reading");
    data.write("b_3.csv", &rows("NaN"));
    let said = data.refused(&[]);
    assert!(
        said.contains("b_3.csv:6") && said.contains("column 2"),
        "{said}"
    );
}

#[test]
fn a_material_that_is_no_number_is_named_by_its_label() {
    let data = Data::new("nan-material");
    data.write("materials.csv", &materials("NaN"));
    let said = data.refused(&["--heads", "1"]);
    assert!(said.contains("materials.csv: a: expected relief"), "{said}");
}

#[test]
fn heads_without_materials_and_readings_of_unknown_materials_are_named() {
    let data = Data::new("no-material");
    data.write("c_0.csv", &rows("1"));
    let said = data.refused(&["--heads", "1"]);
    assert!(said.contains("expected a row for c"), "{said}");
    fs::remove_file(data.0.join("materials.csv")).unwrap();
    let said = data.refused(&["--heads", "1"]);
    assert!(said.contains("expected a materials.csv"), "{said}");
    let said = data.refused(&["--along"]);
    assert!(said.contains("--along: expected --heads"), "{said}");
}
