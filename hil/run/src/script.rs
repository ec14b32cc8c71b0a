//! A scene's faults as they come and go: each is done to the emulated hardware at its time, counted, and reported.

use palpate_core::skin::Layout;
use palpate_core::units::{Duration, Instant};
use palpate_emulators::display::amplifier::AmplifierFault;
use palpate_emulators::display::i2c::fault::{I2cFaultKind, I2cFaults};
use palpate_emulators::display::pca9685::Oscillator;
use palpate_emulators::sensor::board::SensorBoard;
use palpate_emulators::sensor::can::faults::Rates;
use palpate_emulators::sensor::can::{CanSegment, ErrorClass};
use palpate_emulators::sensor::rig::SkinBus;
use palpate_records::trace::Event;
use serde::Serialize;

use super::effects::{
    Faultable, counter, i2c_kind, on_chip, on_converter, on_module, on_motor, rules,
};
use palpate_files::{Drive, Fault, FaultKind};

/// Duration of a momentary fault where the scene does not say: a reboot, a bus-off host.
const MOMENT: Duration = Duration::from_millis(100);

/// A fault of a run, for its summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultReport {
    /// Kind of the fault.
    pub kind: &'static str,
    /// Kind and target in words.
    pub what: String,
    /// Time at which the fault began, seconds.
    pub at_s: f64,
    /// Time at which the fault ended; `None`: with the run.
    pub until_s: Option<f64>,
    /// Frames, transfers or chips it hit.
    pub count: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Waiting,
    On,
    Over,
}

#[derive(Debug)]
struct Entry {
    fault: Fault,
    from: Instant,
    until: Option<Instant>,
    state: State,
    /// The kind's counter when the fault began, then the count of its hits.
    base: u64,
    count: u64,
}

/// A scene's faults.
#[derive(Debug)]
pub struct Script {
    entries: Vec<Entry>,
    layout: Layout,
}

fn instant(seconds: f64) -> Instant {
    Instant::from_micros((seconds * 1e6).round() as u64)
}

impl Script {
    /// The faults of a scene on a skin of this layout.
    pub fn new<'a>(faults: impl IntoIterator<Item = &'a Fault>, layout: &Layout) -> Self {
        let entry = |fault: &Fault| {
            let at = instant(fault.at_s);
            let until = fault.until_s.map(instant);
            let (from, until) = match fault.kind {
                FaultKind::LateStart => (Instant::ZERO, Some(at)),
                FaultKind::BoardReboot | FaultKind::BusOff => {
                    (at, Some(until.unwrap_or(at + MOMENT)))
                }
                _ => (at, until),
            };
            Entry {
                fault: fault.clone(),
                from,
                until,
                state: State::Waiting,
                base: 0,
                count: 0,
            }
        };
        Self {
            entries: faults.into_iter().map(entry).collect(),
            layout: layout.clone(),
        }
    }

    /// Time at which the next fault begins or ends.
    pub fn next(&self) -> Instant {
        let next = |e: &Entry| match e.state {
            State::Waiting => Some(e.from),
            State::On => e.until,
            State::Over => None,
        };
        let times = self.entries.iter().filter_map(next);
        times.min().unwrap_or(Instant::FAR_FUTURE)
    }

    /// Lets faults begin and end that are due at `now`; with `last` those that are on end, and no other begins.
    pub fn step(
        &mut self,
        now: Instant,
        last: bool,
        bench: &mut Faultable<'_>,
        events: &mut Vec<Event>,
    ) {
        if last {
            for n in 0..self.entries.len() {
                if self.entries[n].state == State::On {
                    self.close(n, now, bench, events);
                }
            }
            return;
        }
        if self.next() > now {
            return;
        }
        for n in 0..self.entries.len() {
            let (from, until, state) = {
                let e = &self.entries[n];
                (e.from, e.until, e.state)
            };
            if state == State::Waiting && from <= now {
                self.entries[n].state = State::On;
                self.entries[n].base = counter(&self.entries[n].fault, bench);
                self.change(n, true, now, bench);
                let text = format!("fault: {}", self.entries[n].fault.words());
                events.push(Event::note(now, text));
            }
            if self.entries[n].state == State::On && until.is_some_and(|t| t <= now) {
                self.change(n, false, now, bench);
                self.close(n, now, bench, events);
            }
        }
        self.set_layers(bench);
    }

    /// Reports of all faults.
    pub fn report(&self) -> Vec<FaultReport> {
        let report = |e: &Entry| FaultReport {
            kind: e.fault.kind.name(),
            what: e.fault.words(),
            at_s: e.fault.at_s,
            until_s: e.fault.until_s,
            count: e.count,
        };
        self.entries.iter().map(report).collect()
    }

    fn close(&mut self, n: usize, now: Instant, bench: &Faultable<'_>, events: &mut Vec<Event>) {
        let e = &mut self.entries[n];
        e.state = State::Over;
        let hits = counter(&e.fault, bench).saturating_sub(e.base);
        e.count = e.count.max(hits);
        let text = format!("fault over: {}, count {}", e.fault.words(), e.count);
        events.push(Event::note(now, text));
    }

    /// The bus of a module and its board's place there.
    fn board(&self, module: usize) -> Option<(usize, usize, u8)> {
        let modules = self.layout.modules();
        let address = modules.get(module)?.address()?;
        let before = modules[..module].iter().filter_map(|m| m.address());
        let place = before.filter(|a| a.bus == address.bus).count();
        Some((usize::from(address.bus), place, address.board))
    }

    /// Does the single acts of a fault to the hardware, as it begins and as it ends.
    fn change(&mut self, n: usize, begins: bool, now: Instant, bench: &mut Faultable<'_>) {
        let fault = self.entries[n].fault.clone();
        let board = fault.module.and_then(|m| self.board(m));
        let with = fault.with.and_then(|m| self.board(m));
        let drive = bench
            .display
            .as_ref()
            .map_or_else(Drive::default, |d| d.drive);
        let mut once = begins;
        match (fault.kind, board) {
            (FaultKind::BoardReboot | FaultKind::LateStart, Some(place)) => {
                on_board(bench, place, &mut |board, segment| match begins {
                    true => board.power_off(segment),
                    false => board.power_on(segment),
                });
            }
            (FaultKind::ClockDrift, Some(place)) => {
                let ppm = fault.ppm.filter(|_| begins).unwrap_or(0.0);
                on_board(bench, place, &mut |board, _| board.set_drift(ppm));
            }
            (FaultKind::SameAddress, Some(place)) => {
                let address = with.filter(|_| begins).map_or(place.2, |w| w.2);
                // A number of the layout always has identifiers.
                on_board(bench, place, &mut |board, _| {
                    let _ = board.set_address(address);
                });
            }
            (FaultKind::BusOff, Some(place)) if begins => {
                on_board(bench, place, &mut |board, segment| {
                    segment.force_bus_off(board.node());
                });
            }
            (FaultKind::BusOff, None) => host_off(bench, &fault, begins),
            (FaultKind::ErrorFrames, _) if begins => error_frames(bench, &fault),
            (FaultKind::AmplifierStuckOn | FaultKind::OpenWire, _) => {
                let defect = match fault.kind {
                    FaultKind::OpenWire => AmplifierFault::OpenWire,
                    _ => AmplifierFault::StuckOn,
                };
                if let Some(display) = &mut bench.display
                    && let Some(wire) = fault.wire.and_then(|w| display.place.own_wire(w))
                    && let Some(worn) = &mut display.worn
                {
                    worn.set_fault(wire, begins.then_some(defect));
                }
            }
            (FaultKind::BrownOut, _) if begins => {
                on_chip(bench, fault.board, now, &mut |chip, at| {
                    chip.power_cycle(at)
                });
            }
            (FaultKind::Oscillator, _) => {
                let factor = fault.factor.filter(|_| begins);
                let factor = factor.unwrap_or(drive.oscillator);
                on_chip(bench, fault.board, now, &mut |chip, at| {
                    chip.set_oscillator(at, Oscillator::from_factor(factor));
                });
            }
            (FaultKind::ClockStopped, _) => {
                let hz = if begins { 0 } else { drive.external_hz() };
                on_chip(bench, fault.board, now, &mut |chip, at| {
                    chip.set_external_clock(at, hz);
                });
            }
            (FaultKind::LinkOutage | FaultKind::LinkRough, _) => {
                let unit = bench.display.as_mut().and_then(|d| d.unit.as_deref_mut());
                once = begins && unit.is_some();
                if let Some(unit) = unit {
                    match fault.kind {
                        FaultKind::LinkRough => unit.set_rough(begins),
                        _ => unit.set_cut(begins),
                    }
                }
            }
            (kind, _) if kind.is_of_converters() => on_converter(bench, &fault, now, begins),
            (kind, _) if kind.is_of_motors() => on_motor(bench, &fault, now, begins),
            (kind, _) if kind.is_of_heat() => once = on_module(bench, kind, begins),
            (kind, _) => {
                once = false;
                if let Some(kind) = i2c_kind(kind).filter(|_| fault.rate.is_none()) {
                    self.strike(kind, begins, bench);
                }
            }
        }
        self.entries[n].count += u64::from(once);
    }

    /// Lets a fault of the actuator bus strike the next transfer; a stuck bus stays until it ends.
    fn strike(&self, kind: I2cFaultKind, begins: bool, bench: &mut Faultable<'_>) {
        self.set_layers(bench);
        let Some(display) = &bench.display else {
            return;
        };
        display.i2c.with(|layer| match (begins, kind) {
            (true, _) => layer.strike(kind),
            (false, I2cFaultKind::StuckBus) => layer.free(),
            (false, _) => {}
        });
    }

    /// Sets dice and rules of both layers to the faults that are on.
    fn set_layers(&self, bench: &mut Faultable<'_>) {
        let on = || {
            self.entries
                .iter()
                .filter(|e| e.state == State::On)
                .map(|e| &e.fault)
        };
        let rate = |kind: FaultKind| {
            let rates = on().filter(|f| f.kind == kind).filter_map(|f| f.rate);
            rates.sum::<f64>().min(1.0)
        };
        let ms = |ms: Option<f64>| ms.map_or(0, |ms| (ms * 1e6).round() as u64);
        let mut dice = I2cFaults {
            stuck_for: u32::MAX,
            ..I2cFaults::default()
        };
        for fault in on() {
            if let Some(kind) = i2c_kind(fault.kind) {
                dice.probability[kind as usize] += fault.rate.unwrap_or(0.0);
                dice.stretch_ns = dice.stretch_ns.max(ms(fault.stretch_ms));
            }
        }
        if let Some(display) = &bench.display {
            display.i2c.with(|layer| layer.set_faults(dice));
        }
        let late = on().map(|f| ms(f.late_ms)).max().unwrap_or(0);
        let rates = Rates {
            lost: rate(FaultKind::FramesLost),
            duplicated: rate(FaultKind::FramesDuplicated),
            late: rate(FaultKind::FramesLate),
            late_by: Duration::from_micros(late / 1000),
            corrupted: rate(FaultKind::FramesCorrupted),
            short: rate(FaultKind::FramesShort),
        };
        let all = on().flat_map(|f| rules(&self.layout, f)).collect();
        if let Some(skin) = bench.skin.as_mut() {
            skin.set_rates(rates);
            skin.set_rules(all);
        }
    }
}

/// Works on a sensor bus, where one is emulated.
fn on_bus(bench: &mut Faultable<'_>, bus: usize, work: &mut dyn FnMut(&mut SkinBus)) {
    if let Some(skin) = bench.skin.as_mut() {
        skin.inner_mut().with(|buses| buses.get_mut(bus).map(work));
    }
}

/// Works on a board and its segment, by its bus and its place there, where the bus is emulated.
fn on_board(
    bench: &mut Faultable<'_>,
    (bus, place, _): (usize, usize, u8),
    work: &mut dyn FnMut(&mut SensorBoard, &mut CanSegment),
) {
    on_bus(bench, bus, &mut |b| b.disturb(place, &mut *work));
}

/// Takes the host's controller off its bus, or puts it back.
fn host_off(bench: &mut Faultable<'_>, fault: &Fault, begins: bool) {
    on_bus(bench, fault.bus.map_or(0, usize::from), &mut |b| {
        let host = b.host();
        if begins {
            b.segment_mut().force_bus_off(host);
        } else {
            b.segment_mut().restart(host);
        }
    });
}

/// Puts error frames of all classes on a sensor bus.
fn error_frames(bench: &mut Faultable<'_>, fault: &Fault) {
    let classes = [
        ErrorClass::Bit,
        ErrorClass::Stuff,
        ErrorClass::Crc,
        ErrorClass::Form,
    ];
    let count = fault.count.unwrap_or(1) as usize;
    on_bus(bench, fault.bus.map_or(0, usize::from), &mut |b| {
        let errors = classes.iter().cycle().take(count);
        errors.for_each(|&error| b.segment_mut().inject(error));
    });
}
