//! Rates of rows and models under `hil texture encode`.

use palpate_tests::seeded::Seeded;

use super::texture::ground;
use super::*;

#[test]
fn a_model_is_refused_at_another_rate_than_it_was_trained_on() {
    let (folder, _, rows) = ground("texture-rate");
    let about = [("rate_hz", "50".to_owned())];
    let model = Seeded::new(3, &[5, 8, 3], 20, 1.0).file_with(&about);
    let path = folder.path("slow.safetensors");
    fs::write(&path, model.unwrap()).unwrap();
    let path = path.display().to_string();
    let encode = [
        "texture", "encode", &path, &rows, "--soa-ms", "58.5", "--rate",
    ];
    refused_with(
        &[&encode[..], &["100"]].concat(),
        &["slow.safetensors", "rate_hz", "50 Hz", "100 Hz"],
    );
    // What the rows say of themselves outweighs the option.
    refused_with(
        &[&encode[..], &["50"]].concat(),
        &["rows.csv", "50 Hz, as --rate says", "100.0 Hz"],
    );
    let plain = ["texture", "encode", &path, &rows];
    refused_with(&plain, &["rate_hz", "50 Hz", "100 Hz", "--any-rate"]);
    let forced = hil(&[&plain[..], &["--any-rate"]].concat());
    assert_eq!(forced.status, Some(0), "{}", forced.err);
    assert!(
        forced.err.contains("EXTRAPOLATED: rows at 100.0 Hz"),
        "{}",
        forced.err
    );
    // Rows without times are at the rate that is said.
    let text = folder.text("rows.csv");
    let without = text.lines().filter_map(|line| line.split_once(','));
    let without: String = without.map(|(_, rest)| format!("{rest}\n")).collect();
    let timeless = folder.write("timeless.csv", &without).display().to_string();
    let encode = ["texture", "encode", &path, &timeless, "--rate"];
    good(&[&encode[..], &["50"]].concat());
    refused_with(&[&encode[..], &["100"]].concat(), &["50 Hz", "100 Hz"]);
}
