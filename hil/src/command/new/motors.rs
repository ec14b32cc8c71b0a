//! A new bench of motors.

use palpate_files::BenchHaptics;
use palpate_run::Failure;

use super::{filled, float, heading, listed, quoted};
use crate::cli::{NewBench, NewMotors};

const MOTORS: &str = include_str!("motors.toml");

/// File of a bench of so many motors on a display.
///
/// # Errors
/// [`Failure::Input`] for voice coils on a real bench.
pub(super) fn bench(
    args: &NewBench,
    kind: NewMotors,
    (display, count): (&str, usize),
) -> Result<String, Failure> {
    let real = !args.can.is_empty();
    let (name, what) = match kind {
        NewMotors::Lra => ("lra", "Linear resonant actuators of our own"),
        NewMotors::Erm => ("erm", "Rotating motors of our own"),
        NewMotors::VoiceCoil if real => {
            let text = "--motors voice-coil: expected neither --can nor --i2c: a sound card drives voice coils, and `hil` opens none";
            return Err(Failure::Input(text.into()));
        }
        NewMotors::VoiceCoil => {
            let shipped = palpate_fixtures::bench("voice-coil-8").unwrap_or_default();
            let (_, haptics) = shipped.split_once("[haptics]").unwrap_or_default();
            let head = heading(&args.file, "docs/vibration.md", "Voice coils of our own")?;
            let display = quoted(display);
            return Ok(format!("{head}display = {display}\n\n[haptics]{haptics}"));
        }
    };
    let usual = BenchHaptics::default();
    let driver = |n: usize| {
        format!(
            "\n    {{ switch = {:#04x}, channel = {} }},",
            0x70 + n / 8,
            n % 8
        )
    };
    let drivers: String = (0..count).map(driver).collect();
    let values = [
        ("kind", quoted(name)),
        ("rated_v", float(usual.rated_v)),
        ("full_v", float(usual.full_v)),
        ("overdrive_v", float(usual.overdrive_v)),
        ("resonance_hz", float(usual.resonance_hz)),
        ("ohm", float(usual.ohm)),
        ("travel_um", float(usual.travel_um)),
        ("calibration", format!("{:?}", usual.calibration)),
    ];
    // A real bench states its motors, default or not.
    let stated = |key: &str| real || key == "kind";
    let values = values.each_ref().map(|(key, value)| {
        let default = if stated(key) { "" } else { value.as_str() };
        (*key, value.clone(), default)
    });
    let own = match real {
        true => {
            let i2c = args.i2c.iter().map(|path| path.display().to_string());
            format!("can = {}\ni2c = {}", listed(&args.can), listed(i2c))
        }
        false => String::new(),
    };
    let mut text = filled(MOTORS, &values).replace("{display}", &quoted(display));
    for (part, lines) in [
        ("kind = \"real\"\n", String::new()),
        (
            "\n[real] # docs/vibration.md#on-hardware; before a person wears it: docs/safety.md\n{own}\n",
            own,
        ),
        ("drivers = {drivers}\n", format!("[{drivers}\n]")),
    ] {
        let with = part.replace("{own}", &lines).replace("{drivers}", &lines);
        text = text.replace(part, if real { &with } else { "" });
    }
    Ok(heading(&args.file, "docs/vibration.md", what)? + &text)
}
