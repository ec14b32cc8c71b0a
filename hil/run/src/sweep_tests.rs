//! The order of a grid, and rows that depend on nothing but their key.

use super::*;

fn axis(key: &str, values: &[&str]) -> Axis {
    Axis {
        key: key.into(),
        values: values.iter().map(|v| (*v).to_owned()).collect(),
    }
}

#[test]
fn the_first_axis_moves_slowest_and_what_is_there_twice_is_refused() {
    let grid = Grid::new(
        vec![axis("b", &["1", "2"]), axis("a", &["x", "y", "z"])],
        vec![3, 1],
    )
    .unwrap();
    let values = |n| grid.set(n).into_values().collect::<Vec<_>>().join("");
    // By key, so `a` is said first.
    let all: Vec<String> = (0..grid.combinations()).map(values).collect();
    assert_eq!(all, ["x1", "y1", "z1", "x2", "y2", "z2"]);
    for (axes, seeds, word) in [
        (
            vec![axis("a", &["1"]), axis("a", &["2"])],
            vec![1],
            "found a again",
        ),
        (vec![axis("a", &["1", "1"])], vec![1], "found 1 again"),
        (
            vec![axis("a", &["0.02", "x", "0.020"])],
            vec![1],
            "--set a: expected each once, found 0.02 as 0.020 again",
        ),
        (vec![], vec![4, 5, 4], "found 4 again"),
        (vec![axis("a", &[])], vec![1], "found 0"),
        (vec![], vec![], "found 0"),
    ] {
        let error = Grid::new(axes, seeds).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn a_row_is_its_keys_alone() {
    let base = Setup::load("sphere-along", "emulated").unwrap();
    let variant = |set: &[(&str, &str)]| {
        let set = set.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned()));
        Variant::new(&base, set.collect())
    };
    let short = variant(&[("length_s", "2"), ("illusion.soa_ms", "100")]).unwrap();
    let row = short.row(7, &mut ()).unwrap();
    assert_eq!(row, short.row(7, &mut ()).unwrap());
    assert_eq!((row.key.seed, row.key.scene.as_str()), (7, "sphere-along"));
    // Values in place of a file's own are in the key, and leave the digest of the files.
    let plain = variant(&[]).unwrap();
    assert_eq!(plain.key(7).digest, row.key.digest);
    assert_ne!(plain.key(7), row.key);
    // Another file is another digest.
    let other = variant(&[("bench.wire.kind", "first-100um")]).unwrap();
    assert_ne!(other.key(7).digest, plain.key(7).digest);
    let error = variant(&[("illusion.shap", "3")]).unwrap_err().to_string();
    assert!(error.contains("did you mean `shape`"), "{error}");
    assert!(variant(&[("bench.kind", "real")]).is_err());
}
