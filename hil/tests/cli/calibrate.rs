//! `hil calibrate`: a band for a bench, and what is said where it does not hold.

use serde_json::Value;

use super::{Folder, Said, hil_in, refused_with};

/// Few draws: percentiles of no worth, in no time.
const FEW: [&str; 5] = ["calibrate", "--draws", "10", "--most", "10"];

fn few(folder: &Folder, more: &[&str]) -> Said {
    hil_in(&folder.0, &[&FEW, more].concat())
}

/// The default bench under another name, with what stands in `band` as its band.
fn bench(folder: &Folder, name: &str, band: &str) {
    let own = palpate_fixtures::bench("emulated").unwrap();
    let text = own
        .replace("name = \"emulated\"", &format!("name = {name:?}"))
        .replace("band = \"emulated\"", &format!("band = {band:?}"));
    folder.write("mine.toml", &text);
}

/// The felt part of a run's summary.
fn felt(folder: &Folder, more: &[&str]) -> Value {
    let said = hil_in(
        &folder.0,
        &[&["run", "sphere-circle", "--json"], more].concat(),
    );
    let summary: Value = serde_json::from_str(&said.out).unwrap_or_else(|e| {
        panic!("{e}: {}{}", said.out, said.err);
    });
    summary["felt"].clone()
}

#[test]
fn a_band_is_written_once_and_read_by_every_run() {
    let folder = Folder::new("calibrate");
    bench(&folder, "mine", "emulated");
    let said = few(&folder, &["mine.toml", "--out", "band.toml"]);
    let message = "mine.toml:6: band: expected a band of bench `mine`; `hil calibrate mine.toml --out FILE` makes one, found \"emulated\", one of bench `emulated`";
    assert!(said.err.contains(message), "{}", said.err);

    // A bench that names no band is calibrated, and says how.
    let own = folder.text("mine.toml");
    folder.write("mine.toml", &own.replace("band = \"emulated\"\n", ""));
    let none = felt(&folder, &["--bench", "mine.toml"]);
    assert_eq!(
        (&none["band"], &none["no_band"]),
        (
            &Value::Null,
            &Value::from(
                "not computed: hil calibrate mine.toml --out FILE, then band = \"FILE\" in the bench"
            )
        )
    );
    let said = few(&folder, &["mine.toml", "--out", "band.toml", "--json"]);
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    let told: Value = serde_json::from_str(&said.out).unwrap();
    folder.write(
        "mine.toml",
        &own.replace("band = \"emulated\"", "band = \"band.toml\""),
    );
    let shown = felt(&folder, &["--bench", "mine.toml"]);
    assert_eq!(shown["no_band"], Value::Null);
    let (band, after) = (&shown["band"], &told["posterior"]["after"]);
    for key in ["level_db", "error_mm"] {
        for n in 0..3 {
            let [shown, told] = [band, after].map(|of| of[key][n].as_f64().unwrap());
            assert!((shown - told).abs() <= 0.005, "{key}: {shown} and {told}");
        }
    }
    assert_eq!((&band["draws"], &band["seed"]), (&10.into(), &1.into()));

    // The same draws make the same file, by whatever number of cores.
    let first = folder.text("band.toml");
    let again = few(
        &folder,
        &["mine.toml", "--out", "band.toml", "-j", "1", "-q"],
    );
    assert_eq!((again.status, again.out.as_str()), (Some(0), ""));
    assert_eq!(folder.text("band.toml"), first);

    // A comment changes nothing, a value does.
    folder.write(
        "mine.toml",
        &format!("# Mine.\n{}", folder.text("mine.toml")),
    );
    assert_eq!(
        felt(&folder, &["--bench", "mine.toml"])["no_band"],
        Value::Null
    );
    let set = [
        "--bench",
        "mine.toml",
        "--set",
        "bench.drive.current_ma=900",
    ];
    assert_eq!(
        felt(&folder, &set)["no_band"],
        "not computed: band.toml is of other values; hil calibrate mine.toml --set drive.current_ma=900 --out band.toml makes it anew"
    );
}

#[test]
fn a_changed_bench_runs_without_its_band_and_says_so() {
    let folder = Folder::new("stale");
    let run = [
        "run",
        "sphere-circle",
        "--set",
        "bench.drive.current_ma=900",
    ];
    let said = hil_in(&folder.0, &run);
    assert!(said.out.contains("; band not computed\n"), "{}", said.out);
    let said = hil_in(&folder.0, &[&run[..], &["--long"]].concat());
    let words = "felt band       not computed: fixtures/bands/emulated.toml is of other values; hil calibrate emulated --set drive.current_ma=900 --out FILE makes it anew";
    assert!(said.out.contains(words), "{}", said.out);
}

#[test]
fn files_that_cannot_be_and_benches_of_several_displays_are_refused() {
    let folder = Folder::new("calibrate-bad");
    let change = |from: &str, to: &str| {
        let text = palpate_fixtures::band("emulated").unwrap();
        let line = text.lines().find(|line| line.starts_with(from)).unwrap();
        folder.write("band.toml", &text.replace(line, to));
        bench(&folder, "emulated", "band.toml");
        let said = hil_in(&folder.0, &["run", "--bench", "mine.toml"]);
        assert_eq!(said.status, Some(2), "{}", said.err);
        said.err
    };
    let said = change("name", "name = \"thesis\"");
    assert!(
        said.contains("mine.toml:6: band: expected a band of bench `emulated`; `hil calibrate mine.toml --out FILE` makes one, found \"band.toml\", one of bench `thesis`"),
        "{said}"
    );
    let said = change("level_db", "level_db = [1.0, -1.0, 2.0]");
    assert!(
        said.contains(
            "level_db: expected values at 5, 50 and 95 %, the lowest first, found [1.0, -1.0, 2.0]"
        ),
        "{said}"
    );
    let said = change("felt", "felt = 60.0");
    assert!(
        said.contains("felt: expected a number from 0 to 1, found 60.0"),
        "{said}"
    );

    let file = |name: &str, text: &str| folder.write(name, text).display().to_string();
    let row = "name = \"a\"\ndescription = \"a\"\n[[row]]\nquantity = \"strain\"\nvalue = 1.0\ntolerance = [0.1, 0.1]\n";
    let evidence = file("unit.toml", &format!("{row}source = \"a\"\n"));
    let words = "unit.toml:3: row[0].unit: expected \"%\", the unit of strain, found nothing";
    refused_with(&["calibrate", "--evidence", &evidence], &[words]);
    let evidence = file("source.toml", &format!("{row}unit = \"%\"\n"));
    let words = "source.toml:3: row[0].source: expected the publication or measurement that the value comes from, found nothing";
    refused_with(&["calibrate", "--evidence", &evidence], &[words]);
    let priors = palpate_fixtures::priors("default").unwrap();
    let turned = file("priors.toml", &priors.replace("[35, 55]", "[55, 35]"));
    let words = "priors.toml:11: prior.r_start.uniform: expected the lower end first: more than 55 behind it, found [55, 35]";
    refused_with(&["calibrate", "--priors", &turned], &[words]);

    let several = "displays: expected one display: only `hil run` and `hil test` drive several, found 10 displays";
    refused_with(&["calibrate", "ten-fingers"], &[several]);
}
