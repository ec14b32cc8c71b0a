//! Where each field lies, for ends that are not written in Rust: `fixtures/link/palpate_link.h` is made from these tables.
//!
//! The codec reads and writes in sequence and needs no offset.

/// A field of a header or of a body. Integers are little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name, lower case.
    pub name: &'static str,
    /// Bytes before it.
    pub at: usize,
    /// Bytes of each element.
    pub bytes: usize,
    /// Elements, one after the other.
    pub count: usize,
    /// What it says, with its unit.
    pub what: &'static str,
}

impl Field {
    const fn new(name: &'static str, at: usize, bytes: usize, what: &'static str) -> Self {
        let count = 1;
        Self {
            name,
            at,
            bytes,
            count,
            what,
        }
    }

    /// A value for each of sixteen boards.
    const fn by_board(self) -> Self {
        Self { count: 16, ..self }
    }

    /// Bytes before what follows.
    pub const fn end(&self) -> usize {
        self.at + self.bytes * self.count
    }
}

/// The clear header.
pub const HEADER_FIELDS: [Field; 6] = [
    Field::new("magic", 0, 2, "\"PU\""),
    Field::new("version", 2, 1, "version of the link"),
    Field::new("kind", 3, 1, "what the datagram is"),
    Field::new("host", 4, 8, "the host's number"),
    Field::new("unit", 12, 8, "the unit's number; 0 in a knock"),
    Field::new(
        "sequence",
        20,
        8,
        "of the sender, from 1; the top bit is the unit's",
    ),
];

/// The fixed part of a command.
pub const COMMAND_FIELDS: [Field; 7] = [
    Field::new(
        "reading",
        0,
        8,
        "when the newest reading was received, us; 0 without one",
    ),
    Field::new("base", 8, 8, "the earliest onset in the plan, us"),
    Field::new("stops", 16, 4, "stops that the host takes for over"),
    Field::new("request", 20, 1, "what is done beside the plan"),
    Field::new("stimuli", 21, 1, "how many follow"),
    Field::new(
        "face",
        22,
        2,
        "what the face of a Peltier module shall become, millidegrees C; 0 switches it off",
    ),
    Field::new(
        "ceiling",
        24,
        2,
        "the warmest that it may, by the host's guard, millidegrees C",
    ),
];

/// Each stimulus of a command.
pub const PLANNED_FIELDS: [Field; 4] = [
    Field::new("place", 0, 1, "board x 16 + channel"),
    Field::new(
        "pulse",
        1,
        3,
        "width in ticks + 4096 x current in mA; width 0 ends what the channel does, current 0 is the amplifier's most",
    ),
    Field::new("onset", 4, 3, "after the base, us"),
    Field::new("length", 7, 3, "us"),
];

/// A status.
pub const STATUS_FIELDS: [Field; 19] = [
    Field::new("now", 0, 8, "the unit's clock, us"),
    Field::new("echo", 8, 8, "sequence of the newest command taken"),
    Field::new("taken", 16, 8, "when it was taken, us"),
    Field::new("state", 24, 1, "whether it drives"),
    Field::new("stops", 25, 4, "so far"),
    Field::new("applied", 29, 4, "stimuli begun"),
    Field::new("limited", 33, 4, "of them, changed or refused by the guard"),
    Field::new("reasons", 37, 2, "why, a bit each"),
    Field::new("dropped", 39, 4, "stimuli left out"),
    Field::new("late", 43, 4, "the latest beginning after its time, us"),
    Field::new("refused", 47, 4, "datagrams refused"),
    Field::new(
        "skin",
        51,
        4,
        "tissue at 0.1 mm, the most predicted, millidegrees C",
    ),
    Field::new("phase", 55, 2, "of each board's chip in its period, us").by_board(),
    Field::new(
        "face",
        87,
        2,
        "of a Peltier module, millidegrees C; 0 where no sensor tells it",
    ),
    Field::new(
        "face_warmest",
        89,
        2,
        "that it can be, millidegrees C; 0 without a module",
    ),
    Field::new(
        "face_aim",
        91,
        2,
        "millidegrees C; 0 where nothing is aimed at",
    ),
    Field::new("sink", 93, 2, "millidegrees C; 0 where no sensor tells it"),
    Field::new(
        "module_current",
        95,
        2,
        "mA, signed; positive cools the face",
    ),
    Field::new(
        "module_reason",
        97,
        1,
        "why that is not what its control asked for; 0 where it is",
    ),
];

/// A hello.
pub const HELLO_FIELDS: [Field; 29] = [
    Field::new("now", 0, 8, "the unit's clock, us"),
    Field::new("flags", 8, 1, "a bit each"),
    Field::new("state", 9, 1, "whether it drives"),
    Field::new("stops", 10, 4, "so far"),
    Field::new("prescale", 14, 1, "PRE_SCALE of the chips"),
    Field::new("clock", 15, 4, "nominal, of the chips, Hz"),
    Field::new("tolerance", 19, 4, "of that clock, ppm"),
    Field::new("wire", 23, 4, "a wire with its leads, milliohms"),
    Field::new("current", 27, 4, "of a pulse, mA"),
    Field::new(
        "bus",
        31,
        4,
        "how long other displays may hold a board up, us",
    ),
    Field::new("pulse_limit", 35, 8, "ns"),
    Field::new("burst_limit", 43, 8, "us"),
    Field::new("burst_energy_limit", 51, 8, "nJ"),
    Field::new("wire_1s_limit", 59, 8, "mean over 1 s, uW"),
    Field::new("wire_10s_limit", 67, 8, "mean over 10 s, uW"),
    Field::new("fingertip_1s_limit", 75, 8, "mean over 1 s, uW"),
    Field::new("fingertip_60s_limit", 83, 8, "mean over 60 s, uW"),
    Field::new("hand_60s_limit", 91, 8, "mean over 60 s, uW"),
    Field::new("skin_mean_limit", 99, 8, "millidegrees C"),
    Field::new("skin_peak_limit", 107, 8, "millidegrees C"),
    Field::new("skin_deep_limit", 115, 8, "millidegrees C"),
    Field::new("dose_omega_limit", 123, 8, "ppm"),
    Field::new("dose_cem43_limit", 131, 8, "ms"),
    Field::new("stale_limit", 139, 8, "us"),
    Field::new("supply_limit", 147, 8, "mA"),
    Field::new("wires", 155, 2, "channels with a wire, a bit each").by_board(),
    Field::new(
        "full_scale",
        187,
        4,
        "most that a current is set to, mA; 0 where none is set",
    ),
    Field::new(
        "current_gain",
        191,
        4,
        "how much more may flow, ppm of what was set",
    ),
    Field::new("current_offset", 195, 4, "and how much beside that, mA"),
];
