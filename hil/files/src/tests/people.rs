//! Bad persons and wearers, and what is said about them.

use super::super::*;
use super::bad_toml::check;

#[test]
fn people_have_thresholds_and_wearers_begin_below_full_scale() {
    check(
        palpate_fixtures::person("typical").unwrap(),
        PersonFile::read,
        &[
            (
                "low = 0.3",
                "low = -0.3",
                "f.toml:8: vibration.threshold_um.low: expected a number from 0.001 to 1000 um, found -0.3",
            ),
            (
                "value = 0.6",
                "value = -0.6",
                "f.toml:8: vibration.threshold_um.value: expected a number from 0.3 to 1.2 um, found -0.6",
            ),
            (
                "high = 15.0",
                "high = nan",
                "f.toml:14: flutter.threshold_um.high: expected a finite number, found nan",
            ),
            (
                "value = 0.7",
                "value = 0.0",
                "f.toml:11: vibration.growth.value: expected a number from 0.5 to 0.9, found 0.0",
            ),
            (
                "area_cm2 = 0.0048",
                "area_cm2 = 0.0",
                "f.toml:9: vibration.area_cm2: expected a number from 0.00001 to 10 cm2, found 0.0",
            ),
            (
                "area_cm2 = 0.0048",
                "",
                "f.toml:10: vibration.summation: expected no exponent, or area_cm2 beside it: the area for which the threshold holds, found 0.5",
            ),
            (
                "summation = 0.5",
                "summation = nan",
                "f.toml:10: vibration.summation: expected a finite number, found nan",
            ),
            (
                "[flutter]",
                "[np2]\nthreshold_um = { value = 1.5, low = 2.0, high = 3.0 }\n[flutter]",
                "f.toml:14: np2.threshold_um.value: expected a number from 2 to 3 um, found 1.5",
            ),
            (
                "value = 5.0,",
                "value = 5.0, area_cm2 = 0.1,",
                "f.toml:14: flutter.threshold_um.area_cm2: expected one of the keys `value`, `low`, `high`, found the unknown key `area_cm2`",
            ),
            (
                "[flutter]",
                "[flutter]\narea_cm2 = 0.1",
                "f.toml:14: flutter.area_cm2: expected no area: this channel does not add up over it, found 0.1",
            ),
        ],
    );
    check(
        palpate_fixtures::wearer("example-8").unwrap(),
        Wearer::read,
        &[
            (
                "gain = [1.0,",
                "gain = [1.5,",
                "f.toml:4: gain[0]: expected a number from 0.01 to 1 of full scale, found 1.5",
            ),
            (
                "threshold = [0.1,",
                "threshold = [1.0,",
                "f.toml:5: threshold[0]: expected from 0 to below the wire's full scale, its gain of 1, found 1.0",
            ),
            (
                "gain = [1.0, 1.0,",
                "gain = [1.0,",
                "f.toml:5: threshold: expected 7 thresholds, one a gain, found 8",
            ),
            (
                "gain =",
                "vibration_um = 0.0\ngain =",
                "f.toml:4: vibration_um: expected a number from 0.001 to 1000 um, found 0.0",
            ),
            (
                "gain =",
                "flutter_um = nan\ngain =",
                "f.toml:4: flutter_um: expected a finite number, found nan",
            ),
        ],
    );
}
