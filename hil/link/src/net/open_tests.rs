//! Tests of `open.rs`.

use super::*;

#[test]
fn plain_text_stays_on_this_machine_unless_that_is_wanted() {
    for local in [
        "127.0.0.1:7450",
        "127.9.9.9:1",
        "[::1]:7450",
        "localhost:7450",
    ] {
        assert!(checked("--listen", local, false).is_ok(), "{local}");
    }
    for away in [
        "0.0.0.0:7450",
        "10.0.0.1:7450",
        "[::]:7450",
        "192.168.1.5:1",
    ] {
        let refused = checked("--connect", away, false);
        assert!(matches!(refused, Err(NetError::Plain { .. })), "{away}");
        assert!(checked("--connect", away, true).is_ok(), "{away}");
    }
    for wrong in [
        "",
        "7450",
        "host",
        ":7450",
        "host:",
        "host:99999",
        "tcp/1.2.3.4:x",
    ] {
        let refused = checked("--listen", wrong, true);
        assert!(matches!(refused, Err(NetError::Address { .. })), "{wrong}");
    }
}

#[test]
fn zenoh_takes_the_settings() {
    let listen = ["tcp/127.0.0.1:0".to_owned()];
    let settings = settings(Mode::Router.word(false), &listen, &[]);
    let config = Config::from_json5(&settings.to_string()).unwrap();
    assert_eq!(config.get_json("transport/link/tx/lease").unwrap(), "1000");
    assert_eq!(
        config
            .get_json("transport/link/rx/max_message_size")
            .unwrap(),
        "1048576"
    );
    assert_eq!(
        config.get_json("scouting/multicast/enabled").unwrap(),
        "false"
    );
}

#[test]
fn a_second_session_connects_as_the_first_and_listens_nowhere() {
    let at = |listen: &[&str], connect: &[&str]| At {
        listen: listen.iter().map(|&a| a.into()).collect(),
        connect: connect.iter().map(|&a| a.into()).collect(),
        plain: true,
        ..At::default()
    };
    let beside = at(&["0.0.0.0:1"], &["robot:4"]).beside();
    assert!(beside.listen.is_empty() && beside.plain);
    assert_eq!(beside.connect, ["robot:4"]);
    // Where it would have nobody to connect to, or no packets to lose, there is none.
    assert!(at(&[], &["10.0.0.1:4"]).leaves_machine());
    for here in [
        at(&["0.0.0.0:1"], &[]),
        at(&[], &["127.0.0.1:4"]),
        at(&[], &[]),
    ] {
        assert!(!here.leaves_machine(), "{here:?}");
    }
    let relayed = At {
        relay: Some("10.0.0.1:4".into()),
        ..At::default()
    };
    assert!(relayed.leaves_machine());
}
