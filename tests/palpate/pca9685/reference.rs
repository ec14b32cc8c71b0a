//! A second model of the chip, written from the document for tests alone, and in another way: a flat
//! register file, one step a tick, nothing skipped, a set/reset output a channel. Slow and plain.
//!
//! It knows one message at a time and the end-of-low and immediate update models. Its clock does not change
//! while it runs.

use palpate_emulators::display::pca9685::{Pin, UpdateModel};

/// What one message is to the chip.
#[derive(Clone, Copy, PartialEq)]
enum Phase {
    Deaf,
    Pointer,
    Store,
    Fetch,
    Call,
    Reset,
}

pub struct Reference {
    pub reg: [u8; 256],
    own: u8,
    updates: UpdateModel,
    oscillator: u64,
    phase: Phase,
    pointer: u8,
    /// Registers written and not yet taken over.
    dirty: [bool; 256],
    /// What was taken over last: the four registers of each channel.
    taken: [[u8; 4]; 16],
    /// What the outputs work with.
    used: [[u8; 4]; 16],
    waiting: [bool; 16],
    blank: [bool; 16],
    /// Full on has begun.
    begun: [bool; 16],
    running: bool,
    stop_after_cycle: bool,
    pub oe: bool,
    count: u64,
    /// The prescale the running counter was started with.
    pre: u64,
    /// Time of the next tick: whole nanoseconds, and the part of one in 1 / oscillator.
    next: (u64, u64),
    /// The counter starts here.
    begins: Option<u64>,
    stable: u64,
    pub now: u64,
    pins: [Pin; 16],
    pub edges: Vec<(u64, u8, Pin)>,
}

const SLEEP: u8 = 0x10;
const RESTART: u8 = 0x80;

impl Reference {
    pub fn new(own: u8, oscillator: u64, updates: UpdateModel) -> Self {
        let mut me = Self {
            reg: [0; 256],
            own,
            updates,
            oscillator,
            phase: Phase::Deaf,
            pointer: 0,
            dirty: [false; 256],
            taken: [[0, 0, 0, 0x10]; 16],
            used: [[0, 0, 0, 0x10]; 16],
            waiting: [false; 16],
            blank: [false; 16],
            begun: [false; 16],
            running: false,
            stop_after_cycle: false,
            oe: false,
            count: 0,
            pre: 30,
            next: (0, 0),
            begins: None,
            stable: 0,
            now: 0,
            pins: [Pin::Low; 16],
            edges: Vec::new(),
        };
        me.defaults();
        me
    }

    fn defaults(&mut self) {
        self.reg = [0; 256];
        self.reg[..6].copy_from_slice(&[0x11, 0x04, 0xE2, 0xE4, 0xE8, 0xE0]);
        self.reg[0xFE] = 0x1E;
        self.phase = Phase::Deaf;
        self.pointer = 0;
        self.unload();
        self.running = false;
        self.begins = None;
        self.stop_after_cycle = false;
    }

    /// The LED registers as after reset.
    fn unload(&mut self) {
        for n in 0..16 {
            self.reg[6 + 4 * n..10 + 4 * n].copy_from_slice(&[0, 0, 0, 0x10]);
        }
        self.dirty = [false; 256];
        self.taken = [[0, 0, 0, 0x10]; 16];
        self.used = self.taken;
        self.waiting = [false; 16];
        self.blank = [false; 16];
    }

    pub fn power_cycle(&mut self, t: u64) {
        self.pass(t);
        self.show(|_| Pin::HighZ);
        self.defaults();
        self.outputs();
    }

    pub fn set_oe(&mut self, t: u64, high: bool) {
        self.pass(t);
        self.oe = high;
        self.outputs();
    }

    /// One tick at a time up to `t`.
    pub fn pass(&mut self, t: u64) {
        loop {
            if self.running && self.due() <= t {
                self.now = self.due();
                self.tick();
            } else if let Some(at) = self.begins.filter(|&at| !self.running && at <= t) {
                self.now = self.now.max(at);
                self.begin();
            } else {
                break;
            }
            self.outputs();
        }
        self.now = self.now.max(t);
    }

    /// The nanosecond at which the next tick has come.
    fn due(&self) -> u64 {
        self.next.0 + u64::from(self.next.1 > 0)
    }

    /// Adds a tick's length to the time of the next one: a division with remainder, carried on.
    fn ahead(&mut self) {
        let span = (self.pre + 1) * 1_000_000_000;
        let part = self.next.1 + span % self.oscillator;
        self.next.0 += span / self.oscillator + part / self.oscillator;
        self.next.1 = part % self.oscillator;
    }

    fn tick(&mut self) {
        self.ahead();
        self.count = (self.count + 1) % 4096;
        if self.count == 0 {
            self.cycle_ends();
        }
        self.begin_full_on();
    }

    fn begin_full_on(&mut self) {
        for n in 0..16 {
            if full_on(self.used[n]) && on(self.used[n]) as u64 == self.count && !self.blank[n] {
                self.begun[n] = true;
            }
        }
    }

    fn cycle_ends(&mut self) {
        for n in 0..16 {
            let u = self.used[n];
            let wraps = u[3] & 0x10 == 0 && u[1] & 0x10 == 0 && on(u) > off(u);
            if self.waiting[n] && wraps && !self.blank[n] {
                self.blank[n] = true;
                continue;
            }
            self.blank[n] = false;
            if self.waiting[n] {
                self.waiting[n] = false;
                self.load(n);
            }
        }
        if self.stop_after_cycle {
            self.stop_after_cycle = false;
            self.running = false;
            if self.wanted() {
                self.reg[0] |= RESTART;
            } else if self.reg[0] & SLEEP != 0 {
                self.unload();
            }
        } else if self.nothing_left() {
            self.running = false;
        }
    }

    fn load(&mut self, n: usize) {
        let stays = full_on(self.used[n]) && self.begun[n];
        self.used[n] = self.taken[n];
        self.begun[n] = full_on(self.used[n]) && stays;
    }

    fn wanted(&self) -> bool {
        self.taken.iter().any(|r| r[3] & 0x10 == 0)
    }

    fn nothing_left(&self) -> bool {
        (0..16).all(|n| self.used[n][3] & 0x10 != 0 && !self.waiting[n] && !self.blank[n])
    }

    fn perhaps_begin(&mut self) {
        let asleep = self.reg[0] & (SLEEP | RESTART) != 0;
        if !asleep && !self.running && self.wanted() {
            self.begins = Some(self.now.max(self.stable));
            if self.stable <= self.now {
                self.begin();
            }
        }
    }

    fn begin(&mut self) {
        self.begins = None;
        if !self.wanted() {
            return;
        }
        self.running = true;
        self.count = 0;
        self.pre = u64::from(self.reg[0xFE]);
        self.next = (self.now, 0);
        self.ahead();
        self.used = self.taken;
        self.waiting = [false; 16];
        self.blank = [false; 16];
        self.begun = [false; 16];
        self.begin_full_on();
    }

    fn outputs(&mut self) {
        let (mode2, oe) = (self.reg[1], self.oe);
        let totem = mode2 & 4 != 0;
        let mut levels = [false; 16];
        if self.running {
            for (n, level) in levels.iter_mut().enumerate() {
                let (u, c) = (self.used[n], self.count as u16);
                *level = if self.blank[n] || u[3] & 0x10 != 0 {
                    false
                } else if full_on(u) {
                    self.begun[n]
                } else {
                    // Inside the pulse if fewer than its width of ticks have passed since ON.
                    (c + 4096 - on(u)) % 4096 < (off(u) + 4096 - on(u)) % 4096
                };
            }
        }
        self.show(|n| match (oe, totem) {
            (true, _) if mode2 & 2 != 0 => Pin::HighZ,
            (true, _) if mode2 & 1 == 0 => Pin::Low,
            (true, true) => Pin::High,
            (true, false) => Pin::HighZ,
            (false, _) if levels[n] == (mode2 & 0x10 != 0) => Pin::Low,
            (false, true) => Pin::High,
            (false, false) => Pin::HighZ,
        });
    }

    fn show(&mut self, pin: impl Fn(usize) -> Pin) {
        for n in 0..16 {
            if self.pins[n] != pin(n) {
                self.pins[n] = pin(n);
                self.edges.push((self.now, n as u8, pin(n)));
            }
        }
    }

    pub fn start(&mut self, t: u64, address: u8, read: bool) -> bool {
        self.pass(t);
        let mode1 = self.reg[0];
        let mine = address == self.own
            || (mode1 & 8 != 0 && self.reg[2] / 2 == address)
            || (mode1 & 4 != 0 && self.reg[3] / 2 == address)
            || (mode1 & 2 != 0 && self.reg[4] / 2 == address)
            || (mode1 & 1 != 0 && self.reg[5] / 2 == address);
        self.phase = match (address, read) {
            (0, false) => Phase::Call,
            (_, true) if mine => Phase::Fetch,
            (_, false) if mine => Phase::Pointer,
            _ => Phase::Deaf,
        };
        self.phase != Phase::Deaf
    }

    pub fn write(&mut self, t: u64, byte: u8) -> bool {
        self.pass(t);
        self.phase = match self.phase {
            Phase::Pointer if !(0x46..0xFA).contains(&byte) => {
                self.pointer = byte;
                Phase::Store
            }
            Phase::Store => {
                self.store(self.pointer, byte);
                self.step();
                Phase::Store
            }
            Phase::Call if byte == 6 => Phase::Reset,
            _ => Phase::Deaf,
        };
        self.phase != Phase::Deaf
    }

    pub fn read(&mut self, t: u64) -> u8 {
        self.pass(t);
        if self.phase != Phase::Fetch {
            return 0xFF;
        }
        let byte = self.reg[usize::from(self.pointer)];
        self.step();
        byte
    }

    pub fn stop(&mut self, t: u64) {
        self.pass(t);
        if self.phase == Phase::Reset {
            self.defaults();
        } else {
            self.phase = Phase::Deaf;
            if self.reg[1] & 8 == 0 {
                self.take(false);
            }
        }
        self.outputs();
    }

    fn step(&mut self) {
        if self.reg[0] & 0x20 != 0 {
            let next = u16::from(self.pointer) + 1;
            self.pointer = if next == 0x46 || next >= 0xFF {
                0
            } else {
                next as u8
            };
        }
    }

    fn store(&mut self, address: u8, v: u8) {
        match address {
            0 => self.mode1(v),
            1 => self.reg[1] = v & 0x1F,
            2..=5 => self.reg[usize::from(address)] = v & !1,
            6..=0x45 => self.led(usize::from(address), v),
            0xFA..=0xFD => {
                (0..16).for_each(|n| self.led(6 + 4 * n + usize::from(address - 0xFA), v))
            }
            0xFE if self.reg[0] & SLEEP != 0 => self.reg[0xFE] = if v < 3 { 3 } else { v },
            _ => {}
        }
        if self.reg[1] & 8 != 0 {
            self.take(true);
        }
        self.outputs();
    }

    fn led(&mut self, address: usize, v: u8) {
        // ON_H and OFF_H are the odd ones.
        self.reg[address] = if address % 2 == 1 { v & 0x1F } else { v };
        self.dirty[address] = true;
    }

    /// Takes over channels with a new register, or with four of them.
    fn take(&mut self, all_four: bool) {
        let mut any = false;
        for n in 0..16 {
            let at = 6 + 4 * n;
            let new = self.dirty[at..at + 4].iter().filter(|d| **d).count();
            if new == 0 || (all_four && new < 4) {
                continue;
            }
            any = true;
            self.dirty[at..at + 4].fill(false);
            self.taken[n].copy_from_slice(&self.reg[at..at + 4]);
            if self.running && self.updates == UpdateModel::EndOfLow {
                self.waiting[n] = true;
            } else if self.running {
                self.load(n);
            }
        }
        if !any {
            return;
        }
        if self.running {
            self.begin_full_on_where_immediate();
        }
        let paused = self.reg[0] & RESTART != 0;
        let was_stopping = self.stop_after_cycle && self.reg[0] & SLEEP == 0;
        self.reg[0] &= !RESTART;
        if paused || was_stopping {
            self.stop_after_cycle = false;
            self.running = self.running && !was_stopping;
        }
        self.perhaps_begin();
        if self.running && !self.stop_after_cycle && self.nothing_left() {
            self.running = false;
        }
    }

    fn begin_full_on_where_immediate(&mut self) {
        if self.updates == UpdateModel::Immediate {
            self.begin_full_on();
        }
    }

    fn mode1(&mut self, v: u8) {
        let (old, sleep) = (self.reg[0], v & SLEEP != 0);
        let external = if old & v & SLEEP != 0 { v & 0x40 } else { 0 };
        self.reg[0] = (old & (RESTART | 0x40)) | external | (v & 0x3F);
        if sleep && old & SLEEP == 0 {
            self.begins = None;
            if self.running {
                self.stop_after_cycle = true;
            } else if old & RESTART == 0 {
                if self.wanted() {
                    self.reg[0] |= RESTART;
                } else {
                    self.unload();
                }
            }
        }
        if !sleep && old & SLEEP != 0 {
            self.stable = self.now + 500_000;
            self.perhaps_begin();
        }
        let pending = self.reg[0] & RESTART != 0 || self.stop_after_cycle;
        if v & RESTART != 0 && !sleep && pending && self.now >= self.stable {
            self.reg[0] &= !RESTART;
            if self.stop_after_cycle {
                self.stop_after_cycle = false;
                self.running = false;
            }
            self.perhaps_begin();
        }
    }
}

fn on(r: [u8; 4]) -> u16 {
    u16::from(r[1] & 0x0F) << 8 | u16::from(r[0])
}

fn off(r: [u8; 4]) -> u16 {
    u16::from(r[3] & 0x0F) << 8 | u16::from(r[2])
}

fn full_on(r: [u8; 4]) -> bool {
    r[1] & 0x10 != 0 && r[3] & 0x10 == 0
}
