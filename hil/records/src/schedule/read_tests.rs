//! Tests of `read.rs`.

use super::*;
use crate::schedule::write_schedule;
use crate::synthetic;

#[test]
fn what_a_header_says_beside_a_trace_is_told() {
    let mut out = Vec::new();
    write_schedule(&synthetic::empty(), &mut out).unwrap();
    let good = String::from_utf8(out).unwrap();
    let said = |text: &str| header_pieces(text).unwrap().join(", ");
    let plain = "version 2, clock of the chip, other keys none";
    assert_eq!(said(&good), plain);
    let with = |text: &str| good.replacen("\"pre_scale\"", &format!("{text},\"pre_scale\""), 1);
    let period = with("\"clock_hz\":25000000,\"clock_ppm\":50");
    assert!(
        said(&period).contains("clock 25000000 Hz within 50 ppm"),
        "{period}"
    );
    let [one, other] = ["1", "2"].map(|value| said(&with(&format!("\"later\":{value}"))));
    assert!(
        one.contains("other keys later ") && one != other,
        "{one}, {other}"
    );
}

#[test]
fn damage_is_named_by_its_line() {
    let mut trace = synthetic::empty();
    let all_off = |t_us, cause| {
        Event::AllOff(event::AllOff {
            t_us,
            board: 0,
            cause,
        })
    };
    trace.events = vec![all_off(0, "start"), all_off(10, "end")];
    let mut out = Vec::new();
    write_schedule(&trace, &mut out).unwrap();
    let good = String::from_utf8(out).unwrap();
    let damaged = |text: &str| read_schedule(text, |_| Vec::new()).err();
    assert_eq!(damaged(&good), None);
    let pulses = r#"{"t_us":20,"board":0,"channel":1,"pulses":7,"on":0,"off":5,"period":5079040,"until_us":35020,"requested":5}"#;
    assert_eq!(damaged(&format!("{good}{pulses}")), None);
    let cut = pulses.replace(
        ",\"requested\"",
        ",\"requested_until_us\":70000,\"requested\"",
    );
    let read = read_schedule(&format!("{good}{cut}"), |_| Vec::new()).unwrap();
    let Some(Event::Schedule(entry)) = read.events.last() else {
        panic!("{:?}", read.events);
    };
    let counts = [entry.pulses(5_079_040), entry.requested_pulses(5_079_040)];
    assert_eq!(counts, [7, 14]);
    let mut again = Vec::new();
    write_schedule(&read, &mut again).unwrap();
    assert!(
        String::from_utf8(again)
            .unwrap()
            .contains("\"requested_until_us\":70000")
    );
    let before = good.replace("\"version\":2", "\"version\":1");
    assert_eq!(damaged(&before), None);
    let entry =
        r#"{"t_us":20,"board":0,"channel":1,"on":0,"off":5000,"until_us":30,"requested":1}"#;
    let reason = r#"{"t_us":20,"board":0,"channel":1,"on":0,"off":5,"until_us":30,"requested":1,"reason":"tea"}"#;
    for (text, line, word) in [
        (String::new(), 1, "empty line"),
        ("{}".to_owned(), 1, "header"),
        (
            good.replace("\"version\":2", "\"version\":9"),
            1,
            "version 9",
        ),
        (good.replace("\"start\"", "\"tea\""), 2, "a cause: start"),
        (
            format!("{good}{{\"t_us\":0,\"board\":0,\"pre_scale\":3}}"),
            4,
            "sorted",
        ),
        (format!("{good}\n"), 4, "a record"),
        (format!("{good}{{\"t_us\":-1}}"), 4, "a record"),
        (format!("{good}{{\"t_us\":20,\"board\":0}}"), 4, "a record"),
        (format!("{good}{entry}"), 4, "4096 ticks"),
        (format!("{good}{reason}"), 4, "a reason"),
        (
            good.replace("\"period_ns\":5079040", "\"period_ns\":0"),
            1,
            "period_ns 5079040",
        ),
        (
            good.replace("\"pre_scale\":30", "\"pre_scale\":30,\"clock_hz\":0"),
            1,
            "clock_hz from 1 to 50000000",
        ),
        (
            good.replace("\"pre_scale\":30", "\"pre_scale\":30,\"clock_hz\":16000000"),
            1,
            "period_ns 7936000, as pre_scale 30 makes it",
        ),
        (
            good.replace("\"pre_scale\":30", "\"pre_scale\":2"),
            1,
            "from 3 to 255",
        ),
        (
            good.replace("\"soa_us\":", "\"soa_us\":99999999"),
            1,
            "two days",
        ),
        (
            good.replace("\"t_us\":10", "\"t_us\":999999999999999"),
            3,
            "two days",
        ),
        (
            format!(
                "{good}{}",
                entry.replace("5000", "5").replace(":30,", ":3,")
            ),
            4,
            "until_us",
        ),
        (
            format!("{good}{}", pulses.replace("\"pulses\":7", "\"pulses\":8")),
            4,
            "pulses 7, as",
        ),
        (
            format!("{good}{}", cut.replace("70000", "35019")),
            4,
            "a requested_until_us from",
        ),
        (
            format!("{good}{}", pulses.replace("5079040", "0")),
            4,
            "a period above 0",
        ),
        (
            format!("{good}{}", pulses.replace("5079040", "5079041")),
            4,
            "period 5079040, as the header says",
        ),
        (
            format!(
                "{good}{}",
                pulses.replace("\"requested\"", "\"asked\":1,\"requested\"")
            ),
            4,
            "unknown field `asked`",
        ),
        (
            good.replace("emulated", "simulated"),
            1,
            "a source: emulated",
        ),
        (
            format!("{good}{}", entry.replace("\"channel\":1", "\"channel\":16")),
            4,
            "0 to 15",
        ),
    ] {
        let damage = damaged(&text).unwrap();
        assert_eq!(damage.line, line, "{damage}");
        assert!(damage.to_string().contains(word), "{word}: {damage}");
    }
}
