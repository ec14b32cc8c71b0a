//! Recordings are read as they were written, from both kinds of folder; what is no recording is refused with its place.

use std::fs;

use super::*;

/// A folder that is gone after the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("palpate-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.0.join(name), content).unwrap();
    }

    fn read(&self, without: &[&str]) -> Result<Recordings, String> {
        let without: Vec<_> = without.iter().map(|t| (*t).to_owned()).collect();
        Recordings::read(&self.0, "txl", &without).map_err(|e| e.to_string())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn tables_are_read_by_the_names_of_columns_and_files() {
    let folder = Folder::new("tables");
    folder.write("b_1.csv", "time,txl1_x,txl2_x\n1,3,4\n2, 5 ,6.5\n");
    folder.write("a_b_2.csv", "time,txl1_x,txl2_x\n1,7,8\n");
    folder.write(
        "ratings.csv",
        "label,trained,hardness,roughness,friction\na,true,1,2,3.5\n",
    );
    let all = folder.read(&[]).unwrap();
    assert_eq!(all.columns, ["txl1_x", "txl2_x"]);
    assert_eq!(all.labels(), ["a", "b"]);
    assert_eq!(
        (all.all[0].name.as_str(), all.rows(&all.all[1])),
        ("a_b_2", 2)
    );
    assert_eq!(all.all[1].values, [3.0, 4.0, 5.0, 6.5]);
    let some = folder.read(&["txl1"]).unwrap();
    assert_eq!(
        (some.columns.len(), some.all[1].values.clone()),
        (1, vec![4.0, 6.5])
    );
    let known = LabelFacts::read(&folder.0).unwrap();
    let rating = &known.ratings[0];
    assert!(rating.trained && rating.label == "a" && rating.friction > 3.4);
    assert!(known.materials.is_empty());

    folder.write("c_1.csv", "time,txl1_x,txl2_x\n1,3,4\n2,NaN,6\n");
    let said = folder.read(&[]).unwrap_err();
    assert!(
        said.contains("c_1.csv:3: column 2 (txl1_x): expected a finite number, found `NaN`"),
        "{said}"
    );
    folder.write("c_1.csv", "txl1_x\n1\n");
    assert!(
        folder
            .read(&[])
            .unwrap_err()
            .contains("columns of the files before")
    );
    assert!(folder.read(&["txl1", "txl2"]).is_err());
}

#[test]
fn materials_say_what_may_be_trained_on_and_over_which_range() {
    let folder = Folder::new("materials");
    let table = |relief: &str| {
        format!(
            "label,trained,stiffness_n_per_mm,relief_um,wavelength_mm,octaves,friction\n\
             a,true,2,{relief},1,1,0.4\nb,false,90,300,1,1,1.4\nc,true,8,50,1,1,0.8\n"
        )
    };
    folder.write("materials.csv", table("20"));
    let known = LabelFacts::read(&folder.0).unwrap();
    let may = ["a", "b", "c", "d"].map(|label| known.may_train(label));
    assert_eq!(may, [true, false, true, true]);
    let ranges = Material::PROPERTIES.map(|of| Material::range(&known.materials, of));
    assert_eq!(ranges, [[20.0, 50.0], [0.4, 0.8], [2.0, 8.0]]);
    folder.write("materials.csv", table("NaN"));
    let said = LabelFacts::read(&folder.0).unwrap_err().to_string();
    assert!(said.contains("materials.csv: a: expected relief"), "{said}");
}

/// A NumPy file of version 1.
fn npy(kind: &str, order: &str, values: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': (2,), }}\n");
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(values);
    file
}

#[test]
fn slides_of_the_icub_set_become_rows_over_time() {
    let folder = Folder::new("slides");
    let [columns, steps, rows] = ICUB;
    let count = columns * steps * rows;
    let values: Vec<u8> = (0..2 * count)
        .flat_map(|i| (i as f32).to_le_bytes())
        .collect();
    let labels: Vec<u8> = [7i64, 12].iter().flat_map(|l| l.to_le_bytes()).collect();
    folder.write("icub_3.npy", npy("<f4", "False", &values));
    folder.write("labels_3.npy", npy("<i8", "False", &labels));
    let all = folder.read(&[]).unwrap();
    assert_eq!(all.labels(), ["material07", "material12"]);
    assert_eq!(
        (all.all[1].name.as_str(), all.columns.len()),
        ("icub_3_001", 60)
    );
    assert_eq!(all.rows(&all.all[1]), 75);
    let mut bad = values.clone();
    bad[28..32].copy_from_slice(&f32::NAN.to_le_bytes());
    folder.write("icub_3.npy", npy("<f4", "False", &bad));
    let said = folder.read(&[]).unwrap_err();
    assert!(
        said.contains("icub_3.npy: number 7: expected finite readings, found NaN"),
        "{said}"
    );
    folder.write("icub_3.npy", npy("<f4", "False", &values));
    // second slide, step 4, column 2, row 5
    let place = (2 * steps + 4) * rows + 5;
    assert_eq!(all.columns[2 * rows + 5], "column2_row5");
    let read = all.all[1].values[4 * 60 + 2 * rows + 5];
    assert!((read - (count + place) as f32).abs() < 1e-3, "{read}");

    folder.write("labels_3.npy", npy("<i8", "False", &labels[..8]));
    assert!(
        folder
            .read(&[])
            .unwrap_err()
            .contains("expected 2 labels, found 1")
    );
    for wrong in [
        npy("<f8", "False", &values),
        npy("<f4", "True", &values),
        b"NUMPY".to_vec(),
    ] {
        folder.write("icub_3.npy", wrong);
        assert!(
            folder
                .read(&[])
                .unwrap_err()
                .contains("of '<f4' in C order")
        );
    }
}

/// A folder of recordings of real sensors; none, and said so, where it is not at hand.
fn real(name: &str) -> Option<PathBuf> {
    let data = std::env::var_os("PALPATE_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let found = Some(data.join(name)).filter(|folder| folder.is_dir());
    if found.is_none() {
        println!("skipped: no recordings");
    }
    found
}

#[test]
fn both_real_sets_are_read_as_a_whole() {
    if let Some(folder) = real("fabric_slide") {
        let all = Recordings::read(&folder, "channel", &[]).unwrap();
        assert_eq!(
            (all.all.len(), all.columns.len(), all.labels().len()),
            (72, 16, 7)
        );
        assert!(all.all.iter().all(|r| all.rows(r) > 1000));
    }
    if let Some(folder) = real("icub_texture") {
        let all = Recordings::read(&folder, "", &[]).unwrap();
        assert_eq!(
            (all.all.len(), all.columns.len(), all.labels().len()),
            (800, 60, 20)
        );
        // Read in the order of the file's header, readings would jump about.
        let steps = all
            .all
            .iter()
            .flat_map(|r| r.values.iter().zip(&r.values[60..]));
        let changes: Vec<f64> = steps.map(|(a, b)| f64::from((b - a).abs())).collect();
        let mean = changes.iter().sum::<f64>() / changes.len() as f64;
        assert!(mean > 0.1 && mean < 1.0, "{mean}");
    }
}
