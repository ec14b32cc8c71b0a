//! A sensor board: reads the taxels of its modules on its own clock and sends them, one frame per taxel as uSkin boards
//! do, or two per triangle as the iCub's.
//!
//! Bus face: data frames out, start and stop commands in. Physical face: its modules, which are touched before it has them.

use palpate_core::codec::can::CanFrame;
use palpate_core::codec::mtb;
use palpate_core::codec::uskin::{self, ALL_BOARDS, COMMAND_ID, Message, Reading, Wiring};
use palpate_core::skin::Protocol;

use crate::sensor::EmulatedModule;
use crate::sensor::can::{CanSegment, Filter, NodeConfig, NodeId, Order};
use crate::time::Nanos;

/// Behaviour of a board when a scan is due and frames of the
/// last one have not left. The real boards' answer is unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Overload {
    /// The board skips the tick: the next scan starts at the first tick of its clock after the last frame has left.
    /// Boards that tick together then share an overloaded bus evenly.
    #[default]
    Wait,
    /// Every scan replaces what still waits; waiting frames go by identifier, as from mailboxes, so
    /// high identifiers starve.
    Overwrite,
}

/// Settings of a board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardConfig {
    /// Number c of the board on the bus, 0 ..= 15.
    pub address: u8,
    /// Protocol of the board. An MTB board has one module, sends from power-on and takes no commands.
    pub protocol: Protocol,
    /// Wiring of a uSkin board's taxels.
    pub wiring: Wiring,
    /// Nominal scans per second, Hz.
    pub scan_hz: f64,
    /// Error of its clock, parts per million: positive is fast.
    pub drift_ppm: f64,
    /// Delay of its first scan after power-on or a start command.
    pub phase: Nanos,
    /// Sends from power-on without being asked.
    pub autostart: bool,
    /// Behaviour when the bus is too slow.
    pub overload: Overload,
    /// Time between the moments at which successive chips' frames are ready, from the start of the
    /// scan. With 0 a scan's frames are ready together.
    pub chip_gap: Nanos,
}

impl Default for BoardConfig {
    /// A uSkin board, number 0, a flat module, 100 Hz, waits for its commands and for the bus.
    fn default() -> Self {
        Self {
            address: 0,
            protocol: Protocol::Uskin,
            wiring: Wiring::FLAT,
            scan_hz: 100.0,
            drift_ppm: 0.0,
            phase: Nanos::ZERO,
            autostart: false,
            overload: Overload::Wait,
            chip_gap: Nanos::ZERO,
        }
    }
}

impl BoardConfig {
    fn sends_by_itself(&self) -> bool {
        self.autostart || self.protocol == Protocol::Mtb
    }
}

/// Reasons for which a board cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BoardError {
    /// The address or a place of the wiring does not fit its field of an identifier.
    #[error("board address does not fit its identifiers")]
    Address,
    /// The number of modules, or of taxels in one, is not what the wiring says.
    #[error("modules and taxels do not match the board's wiring")]
    Wiring,
    /// The scan rate is not a positive number.
    #[error("scan rate must be positive")]
    Rate,
}

/// A frame of a scan: module, first taxel in it, chip group, identifier.
type Slot = (usize, usize, u64, u16);

/// The frames of a scan in the order in which they go, without the taxels that are not read.
fn wire_order(config: &BoardConfig, modules: &[EmulatedModule]) -> Result<Vec<Slot>, BoardError> {
    if config.protocol == Protocol::Mtb {
        return triangles(config, modules);
    }
    let wiring = config.wiring;
    let mut order = Vec::new();
    for place in (0..).map_while(|n| wiring.nth(n)) {
        let (module, taxel) = wiring.taxel(place).ok_or(BoardError::Wiring)?;
        let id = uskin::id(config.address, place);
        let module = usize::from(module);
        let unread = |m: &EmulatedModule| m.config().unread.contains(&taxel);
        if modules.get(module).is_some_and(unread) {
            continue;
        }
        let group = module * usize::from(wiring.columns()) + usize::from(place.chip % 8);
        order.push((module, taxel, group as u64, id.ok_or(BoardError::Address)?));
    }
    Ok(order)
}

/// Slots of an MTB board: both halves of every triangle, thermal pads included.
fn triangles(config: &BoardConfig, modules: &[EmulatedModule]) -> Result<Vec<Slot>, BoardError> {
    let taxels = modules.first().map_or(0, |m| m.config().taxels.len());
    let halves = |triangle: usize| {
        let first = triangle * mtb::TAXELS;
        let id = mtb::id(config.address, triangle as u8); // at most 16
        [first, first + mtb::FIRST_HALF].map(|taxel| Some((0, taxel, triangle as u64, id?)))
    };
    let slots = (0..taxels.div_ceil(mtb::TAXELS)).flat_map(halves);
    slots.collect::<Option<_>>().ok_or(BoardError::Address)
}

/// The half of a triangle that begins with `taxel`. Places beyond the module's last taxel send nothing of theirs: 0.
fn half(board: u8, taxel: usize, readings: &[Reading]) -> Option<CanFrame> {
    let triangle = taxel / mtb::TAXELS;
    let count = |place| readings.get(triangle * mtb::TAXELS + place);
    let taxels = std::array::from_fn(|place| count(place).map_or(0, |r| r.z.min(255) as u8));
    let [first, second] = mtb::halves(&taxels);
    let message = mtb::Message {
        board,
        triangle: triangle as u8, // at most 16
        half: if taxel.is_multiple_of(mtb::TAXELS) {
            first
        } else {
            second
        },
    };
    message.encode()
}

/// A sensor board with its modules.
pub struct SensorBoard {
    config: BoardConfig,
    node: NodeId,
    modules: Vec<EmulatedModule>,
    order: Vec<Slot>,
    readings: Vec<Vec<Reading>>,
    sending: bool,
    powered: bool,
    /// Start of the clock, and its ticks since then.
    origin: Nanos,
    ticks: u64,
    period_ns: f64,
    /// Frames of the present scan handed to the controller.
    handed: usize,
    scan_start: Nanos,
    scans: u64,
    skipped: u64,
}

impl SensorBoard {
    /// A board with its modules, connected to `segment` and powered at its present time.
    pub fn new(
        config: BoardConfig,
        modules: Vec<EmulatedModule>,
        segment: &mut CanSegment,
    ) -> Result<Self, BoardError> {
        let wiring = config.wiring;
        let taxels = |m: &EmulatedModule| m.config().taxels.len();
        let fits = match config.protocol {
            Protocol::Uskin => {
                modules.len() == usize::from(wiring.modules())
                    && modules.iter().all(|m| taxels(m) == wiring.taxels())
            }
            Protocol::Mtb => {
                modules.len() == 1 && modules.iter().all(|m| taxels(m) <= mtb::MOST_TAXELS)
            }
        };
        if !fits {
            return Err(BoardError::Wiring);
        }
        if !(config.scan_hz.is_finite() && config.scan_hz > 0.0 && config.drift_ppm > -1e6) {
            return Err(BoardError::Rate);
        }
        if config.address > 15 {
            return Err(BoardError::Address);
        }
        let order = wire_order(&config, &modules)?;
        let command = |board: u8| COMMAND_ID | u16::from(board);
        let node = segment.attach(NodeConfig {
            order: match config.overload {
                Overload::Wait => Order::Fifo,
                Overload::Overwrite => Order::Priority,
            },
            transmit_limit: order.len(),
            receive_limit: 8,
            filter: Filter::Wake([command(config.address), command(ALL_BOARDS)]),
            restart_after: Some(Nanos::from_micros(100_000)),
        });
        let mut board = Self {
            node,
            readings: vec![Vec::new(); modules.len()],
            modules,
            sending: config.sends_by_itself(),
            powered: true,
            origin: Nanos::ZERO,
            ticks: 0,
            period_ns: 1e9 / (config.scan_hz * (1.0 + config.drift_ppm * 1e-6)),
            handed: order.len(),
            order,
            scan_start: Nanos::ZERO,
            scans: 0,
            skipped: 0,
            config,
        };
        board.start_clock(segment.now());
        Ok(board)
    }

    /// Settings that the board was built from.
    pub const fn config(&self) -> &BoardConfig {
        &self.config
    }

    /// The board's controller on the segment.
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// The board's modules.
    pub fn modules(&self) -> &[EmulatedModule] {
        &self.modules
    }

    /// Tells whether the board sends.
    pub const fn sending(&self) -> bool {
        self.sending
    }

    /// Scans taken, and ticks skipped because frames were still waiting.
    pub const fn scans(&self) -> (u64, u64) {
        (self.scans, self.skipped)
    }

    /// Cuts the board's power: what it wanted to send is gone.
    pub fn power_off(&mut self, segment: &mut CanSegment) {
        segment.clear(self.node);
        (self.powered, self.sending, self.handed) = (false, false, self.order.len());
    }

    /// Powers the board up again. It forgets that it was started, unless it starts by itself.
    pub fn power_on(&mut self, segment: &CanSegment) {
        self.powered = true;
        self.sending = self.config.sends_by_itself();
        self.start_clock(segment.now());
    }

    /// Lets the board's clock run fast or slow by `ppm` from its present tick on.
    pub fn set_drift(&mut self, ppm: f64) {
        let rate = self.config.scan_hz * (1.0 + ppm * 1e-6);
        if rate.is_finite() && rate > 0.0 {
            self.origin = self.tick(self.ticks);
            self.ticks = 0;
            self.period_ns = 1e9 / rate;
            self.config.drift_ppm = ppm;
        }
    }

    /// Gives the board another number, as a mistake in the field would; its commands stay where they were.
    ///
    /// # Errors
    /// [`BoardError::Address`] for a number that its identifiers have no room for; nothing has changed then.
    pub fn set_address(&mut self, address: u8) -> Result<(), BoardError> {
        let config = BoardConfig {
            address,
            ..self.config
        };
        self.order = wire_order(&config, &self.modules)?;
        self.config = config;
        Ok(())
    }

    /// Time at which the board acts next of its own accord.
    pub fn next_event(&self) -> Nanos {
        if self.handed < self.order.len() {
            return self.ready(self.handed);
        }
        if self.sending {
            self.tick(self.ticks)
        } else {
            Nanos::MAX
        }
    }

    /// Acts at `segment.now()`, if it is time. Calls too early do nothing.
    pub fn act(&mut self, segment: &mut CanSegment) {
        let now = segment.now();
        while self.next_event() <= now {
            if self.handed < self.order.len() {
                self.hand_over(segment);
            } else {
                self.ticks += 1;
                if self.config.overload == Overload::Wait && segment.pending(self.node) > 0 {
                    self.skipped += 1;
                } else {
                    self.scan(now);
                }
            }
        }
    }

    /// Takes the commands that have arrived.
    pub fn obey(&mut self, segment: &mut CanSegment) {
        while let Some((at, frame)) = segment.receive(self.node) {
            let Ok(Message::Command(command)) = uskin::decode(&frame) else {
                continue; // data of another board under one of our command identifiers
            };
            let obeys = self.config.protocol == Protocol::Uskin;
            if !self.powered || !obeys || !command.is_for(self.config.address) {
                continue;
            }
            if command.start && !self.sending {
                self.start_clock(at);
            }
            self.sending = command.start;
        }
    }

    /// Starts the scan clock at `now`; the first tick comes after the phase.
    fn start_clock(&mut self, now: Nanos) {
        self.origin = now + self.config.phase;
        self.ticks = 0;
    }

    /// Time of tick `n` of the board's clock, free of accumulated rounding.
    fn tick(&self, n: u64) -> Nanos {
        self.origin + Nanos(libm::rint(n as f64 * self.period_ns) as u64)
    }

    /// Time at which frame `n` of the present scan is ready.
    fn ready(&self, n: usize) -> Nanos {
        let group = self.order.get(n).map_or(0, |entry| entry.2);
        self.scan_start + Nanos(group.saturating_mul(self.config.chip_gap.0))
    }

    fn scan(&mut self, now: Nanos) {
        for (module, readings) in self.modules.iter_mut().zip(&mut self.readings) {
            module.sample(now, readings);
        }
        self.scan_start = now;
        self.handed = 0;
        self.scans += 1;
    }

    /// Gives the next frame to the controller. A full or bus-off controller loses it.
    fn hand_over(&mut self, segment: &mut CanSegment) {
        let Some(&(module, taxel, _, id)) = self.order.get(self.handed) else {
            return;
        };
        self.handed += 1;
        let readings = self.readings.get(module).map_or(&[][..], Vec::as_slice);
        let frame: Option<CanFrame> = match self.config.protocol {
            Protocol::Uskin => {
                let reading = readings.get(taxel).copied();
                uskin::data_frame(id, reading.unwrap_or_default())
            }
            Protocol::Mtb => half(self.config.address, taxel, readings),
        };
        if let Some(frame) = frame {
            let _lost_when_full = match self.config.overload {
                Overload::Wait => segment.send(self.node, &frame),
                Overload::Overwrite => segment.replace(self.node, &frame),
            };
        }
    }
}
