//! Tests of `datagrams.rs`.

use super::*;

#[test]
fn an_address_may_leave_its_port_out() {
    let local = |port| SocketAddr::from((Ipv4Addr::LOCALHOST, port));
    assert_eq!(address("127.0.0.1"), Ok(local(PORT)));
    assert_eq!(address("127.0.0.1:99"), Ok(local(99)));
    assert_eq!(address("[::1]:99"), Ok((Ipv6Addr::LOCALHOST, 99).into()));
    assert_eq!(address("::1"), Ok((Ipv6Addr::LOCALHOST, PORT).into()));
    for bad in ["", ":", "127.0.0.1:", "127.0.0.1:70000", "a b:1"] {
        let said = address(bad).unwrap_err();
        assert!(said.contains("expected ADDRESS"), "{said}");
    }
}

#[test]
fn a_closed_port_is_told_from_a_silent_one() {
    let silent = Datagrams::listen((Ipv4Addr::LOCALHOST, 0).into()).unwrap();
    let there = silent.here().unwrap();
    let patience = Duration::from_millis(100);
    assert!(!is_closed(there, b"knock", patience));
    let mut buffer = [0; 8];
    assert_eq!(silent.receive(&mut buffer).map(|(n, _)| n), Some(5));
    drop(silent);
    assert!(is_closed(there, b"knock", patience));
}
