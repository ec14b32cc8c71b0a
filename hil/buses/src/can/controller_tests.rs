//! Tests of `controller.rs`.

use proptest::prelude::*;

use super::*;

const NESTED: u16 = 1 << 15;

/// A link's attributes as the kernel sends them for a controller: others before and between those that count.
fn link(state: u32) -> Vec<u8> {
    let mut timing = 1_000_000_u32.to_ne_bytes().to_vec();
    timing.extend(875_u32.to_ne_bytes());
    let mut data = attribute(libc::IFLA_CAN_CLOCK as u16, &80_000_000_u32.to_ne_bytes());
    data.extend(attribute(CAN_BITTIMING, &timing));
    data.extend(attribute(CAN_STATE, &state.to_ne_bytes()));
    data.extend(attribute(CAN_RESTART_MS, &100_u32.to_ne_bytes()));
    let mut info = attribute(libc::IFLA_INFO_KIND, b"can\0");
    info.extend(attribute(libc::IFLA_INFO_DATA | NESTED, &data));
    let mut link = attribute(libc::IFLA_IFNAME, b"can0\0");
    link.extend(attribute(libc::IFLA_LINKINFO | NESTED, &info));
    link.extend(attribute(libc::IFLA_MTU, &16_u32.to_ne_bytes()));
    link
}

#[test]
fn facts_are_read_behind_and_between_others() {
    let controller = Controller::read(&link(3));
    assert_eq!(
        controller,
        Controller {
            bitrate: Some(1_000_000),
            state: Some(CanState::BusOff),
            restart_ms: Some(100),
        }
    );
    assert_eq!(Controller::read(&link(6)).state, None);
}

#[test]
fn a_restart_is_the_message_of_iproute2() {
    // Attributes of `ip link set can0 type can restart`, as strace shows them.
    let sent: [u16; 12] = [24, 18, 7, 1, 0x6163, 0x006E, 12, 2, 8, 7, 1, 0];
    let sent: Vec<u8> = sent.iter().flat_map(|half| half.to_le_bytes()).collect();
    assert_eq!(restarting(), sent);
}

#[test]
fn the_kernel_answers() {
    assert_eq!(Controller::ask("lo"), Ok(Controller::default()));
    assert_eq!(Controller::ask("no-such-can"), Err(Errno::ENODEV));
    let refused = restart("lo");
    assert!(
        matches!(refused, Err(Errno::EOPNOTSUPP | Errno::EPERM)),
        "{refused:?}"
    );
}

proptest! {
    #[test]
    fn a_reply_that_is_cut_or_broken_is_read_without_panic(
        cut in 0_usize..96,
        at in 0_usize..96,
        byte in any::<u8>(),
    ) {
        let mut link = link(1);
        let at = at % link.len();
        link[at] = byte;
        link.truncate(cut);
        let read = Controller::read(&link);
        prop_assert!(read.state.is_none_or(|state| state as u32 <= 5));
    }
}
