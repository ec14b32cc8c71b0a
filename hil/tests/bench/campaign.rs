//! Faults drawn at random, one to three at once, at a random moment of a run that drives: of the bus, an adapter, a process, a
//! thread, memory, a descriptor, the disk, the terminal, the clock, a signal. No wire is on for longer than it can be helped,
//! and no run in which one was on for too long says that all was well.
//!
//! `PALPATE_FAULTS` says how many are drawn, `PALPATE_SEED` which.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use nix::fcntl::{FcntlArg, OFlag, fcntl};
use nix::libc;
use nix::sys::signal::Signal;
use palpate_tests::fake_bench::{GUARDIAN, Mode};

use crate::rig::{Bench, OFF_MS, is_soon, now_ns, on_bench};
use crate::run::{Run, freeze, signal};

/// Draws of `cargo test`.
const FEW: u64 = 6;
/// The burst limit of the bench, and what may come on top within the guard's own count: a PWM period and the bus.
pub const BURST_MS: f64 = 50.0 + 8.0;
/// What a run is given to end.
const END: Duration = Duration::from_secs(9);

/// SplitMix64.
pub struct Draws(pub u64);

impl Draws {
    /// Draws a number below a limit.
    pub fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % limit
    }

    /// Draws one of these.
    pub fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u64) as usize]
    }

    /// Draws a time between two, milliseconds.
    pub fn ms(&mut self, least: u64, most: u64) -> Duration {
        Duration::from_millis(least + self.below(most - least))
    }
}

/// What fails.
#[derive(Clone, Copy, Debug)]
enum Fault {
    /// Every adapter answers with an error for a while.
    Bus(i32, Duration),
    /// One adapter does not answer for a while.
    Adapter(Duration),
    /// The run gets a signal that ends or stops it.
    Process(Signal),
    /// The guardian gets one.
    Guardian(Signal),
    /// The guardian gets no thread.
    Thread,
    /// The guardian gets no memory.
    Memory,
    /// The guardian gets no descriptor.
    Descriptor,
    /// The guardian's disk hangs for a while, or fails for good.
    Disk(Option<i32>),
    /// Standard error takes nothing.
    Terminal,
    /// Both processes stand still for a while, and the clock with them or not.
    Clock(bool, Duration),
    /// The run gets a signal that means something to others.
    Signal(Signal),
}

impl Fault {
    fn draw(draws: &mut Draws) -> Self {
        match draws.below(11) {
            0 => Self::Bus(
                draws.pick(&[
                    libc::ENXIO,
                    libc::EIO,
                    libc::EREMOTEIO,
                    libc::ETIMEDOUT,
                    libc::ENODEV,
                ]),
                draws.ms(5, 700),
            ),
            1 => Self::Adapter(draws.ms(5, 700)),
            2 => Self::Process(draws.pick(&[
                Signal::SIGKILL,
                Signal::SIGABRT,
                Signal::SIGSEGV,
                Signal::SIGSTOP,
                Signal::SIGTERM,
                Signal::SIGINT,
                Signal::SIGHUP,
            ])),
            3 => Self::Guardian(draws.pick(&[Signal::SIGKILL, Signal::SIGTERM, Signal::SIGSTOP])),
            4 => Self::Thread,
            5 => Self::Memory,
            6 => Self::Descriptor,
            7 => Self::Disk(draws.pick(&[
                None,
                Some(libc::ENOSPC),
                Some(libc::EIO),
                Some(libc::EROFS),
            ])),
            8 => Self::Terminal,
            9 => Self::Clock(draws.below(2) == 0, draws.ms(150, 600)),
            _ => Self::Signal(draws.pick(&[
                Signal::SIGUSR2,
                Signal::SIGPIPE,
                Signal::SIGXFSZ,
                Signal::SIGWINCH,
                Signal::SIGTTOU,
            ])),
        }
    }

    const fn kind(self) -> &'static str {
        match self {
            Self::Bus(..) => "bus",
            Self::Adapter(_) => "adapter",
            Self::Process(_) | Self::Guardian(_) => "process",
            Self::Thread => "thread",
            Self::Memory => "memory",
            Self::Descriptor => "descriptor",
            Self::Disk(_) => "disk",
            Self::Terminal => "terminal",
            Self::Clock(..) => "clock",
            Self::Signal(_) => "signal",
        }
    }

    /// Whether it takes one of the two processes that can switch off out of the way.
    const fn takes(self) -> Option<bool> {
        match self {
            Self::Process(_) => Some(true),
            Self::Guardian(_) => Some(false),
            _ => None,
        }
    }
}

/// Faults that leave one of run and guardian in its place: of both, nothing but hardware switches off.
fn drawn(draws: &mut Draws) -> Vec<Fault> {
    let mut faults: Vec<Fault> = Vec::new();
    for _ in 0..=draws.below(3) {
        let fault = Fault::draw(draws);
        let taken = faults.iter().find_map(|fault| fault.takes());
        let is_new = faults.iter().all(|other| other.kind() != fault.kind());
        // A guardian that lacks what it does not need lives; what dies instead of the run leaves nobody.
        if is_new && (taken.is_none() || fault.takes().is_none()) {
            faults.push(fault);
        }
    }
    faults
}

/// Strikes; how long the wires could not be reached by anybody, at most.
fn strike(
    bench: &Bench,
    run: &Run<'_>,
    adapter: usize,
    faults: &[Fault],
    draws: &mut Draws,
) -> Duration {
    let began = Instant::now();
    let mut unreachable = Duration::ZERO;
    let mut ends: Vec<Duration> = Vec::new();
    // What is lacking lacks before anything happens.
    let mut faults = faults.to_vec();
    faults.sort_by_key(|fault| match fault {
        Fault::Bus(..) | Fault::Adapter(_) => 1,
        Fault::Process(_) | Fault::Guardian(_) | Fault::Signal(_) => 2,
        Fault::Clock(..) => 3,
        _ => 0,
    });
    for fault in faults {
        std::thread::sleep(Duration::from_micros(draws.below(3000)));
        match fault {
            Fault::Bus(errno, span) => {
                bench.set_mode(Mode::Fails(errno as u16));
                ends.push(began.elapsed() + span);
            }
            Fault::Adapter(span) => {
                bench.adapters[adapter].set_mode(Mode::Hangs);
                ends.push(began.elapsed() + span);
            }
            Fault::Process(which) => run.signal(which),
            Fault::Guardian(which) => signal(run.guardian(), which),
            Fault::Signal(which) => run.signal(which),
            Fault::Thread => bench.scarce.threads.store(GUARDIAN, Ordering::Release),
            Fault::Memory => bench.scarce.memory.store(GUARDIAN, Ordering::Release),
            Fault::Descriptor => bench.scarce.descriptors.store(GUARDIAN, Ordering::Release),
            Fault::Disk(None) => bench.scarce.disk_hangs.store(GUARDIAN, Ordering::Release),
            Fault::Disk(Some(errno)) => {
                bench
                    .scarce
                    .disk_errno
                    .store(errno as u32, Ordering::Release);
                bench.scarce.disk_fails.store(GUARDIAN, Ordering::Release);
            }
            Fault::Terminal => {}
            Fault::Clock(stops, span) => {
                let frozen = Instant::now();
                freeze(&[run.id(), run.guardian()], span, || {
                    if stops {
                        let lost = frozen.elapsed().as_nanos() as i64;
                        bench.clock.lost_ns.store(lost, Ordering::Release);
                    }
                });
                unreachable += frozen.elapsed();
            }
        }
    }
    if let Some(end) = ends.into_iter().max() {
        std::thread::sleep(end.saturating_sub(began.elapsed()));
        bench.set_mode(Mode::Works);
        unreachable += began.elapsed();
    }
    unreachable
}

/// What becomes of the run once nothing is wrong any more: it ends by itself, or in order.
fn settle(bench: &Bench, run: &Run<'_>) {
    is_soon(Duration::from_millis(400), || !bench.latched().is_empty());
    for lack in [
        &bench.scarce.threads,
        &bench.scarce.memory,
        &bench.scarce.descriptors,
        &bench.scarce.disk_hangs,
        &bench.scarce.disk_fails,
    ] {
        lack.store(0, Ordering::Release);
    }
    run.signal(Signal::SIGCONT);
    run.signal(Signal::SIGTERM);
    signal(run.guardian(), Signal::SIGCONT);
}

/// One draw; how long a wire was on, and how long it was allowed to be.
fn play(seed: u64, kinds: &mut BTreeMap<&'static str, u64>) -> [f64; 2] {
    let mut measured = [0.0; 2];
    let found = std::sync::Mutex::new(Vec::new());
    on_bench(1 + (seed % 2) as usize, |bench| {
        let mut draws = Draws(seed.wrapping_mul(0x2545_F491_4F6C_DD1D));
        let faults = drawn(&mut draws);
        let _feed = bench.feed();
        let full = faults.iter().any(|fault| matches!(fault, Fault::Terminal));
        let (reader, mut writer) = std::io::pipe().unwrap();
        if full {
            fcntl(&writer, FcntlArg::F_SETFL(OFlag::O_NONBLOCK)).unwrap();
            while writer.write(&[b'x'; 512]).is_ok() {}
            fcntl(&writer, FcntlArg::F_SETFL(OFlag::empty())).unwrap();
        }
        let scene = bench.scene(30.0);
        let words = Bench::run_words(&scene);
        let program = Path::new(env!("CARGO_BIN_EXE_hil"));
        let run = bench.start_with(program, &words, full.then(|| Stdio::from(writer)));
        let adapter = run.wait_for_burst();
        std::thread::sleep(Duration::from_micros(draws.below(80_000)));
        let unreachable = strike(bench, &run, adapter, &faults, &mut draws);
        is_soon(Duration::from_secs(1), || !bench.is_on());
        settle(bench, &run);
        // Whoever waits for the terminal goes on.
        drop(reader);
        let said = run.finish(END);
        let (on, late) = (bench.longest_on(), bench.lateness());
        let allowed = BURST_MS + OFF_MS + unreachable.as_secs_f64() * 1e3;
        let about = format!(
            "PALPATE_SEED={seed}: {faults:?}: on for {on:.1} ms of {allowed:.1}, machine late by {late:.1}, {said:?}, latched {:?}",
            bench.latched()
        );
        assert!(!bench.is_on(), "left on: {about}");
        assert!(on <= allowed + late, "on for too long: {about}");
        let exceeded = on > BURST_MS + late;
        assert!(!exceeded || said.status != Some(0), "all was well: {about}");
        found.lock().unwrap().push((
            faults.iter().map(|fault| fault.kind()).collect::<Vec<_>>(),
            [on, allowed],
        ));
    });
    if let Some((drawn, figures)) = found.into_inner().unwrap().pop() {
        drawn
            .into_iter()
            .for_each(|kind| *kinds.entry(kind).or_default() += 1);
        measured = figures;
    }
    measured
}

/// The number that a variable of the environment has, or another where it is not set.
pub fn number(name: &str, other: u64) -> u64 {
    std::env::var(name).map_or(other, |n| n.parse().unwrap())
}

#[test]
fn drawn_faults_keep_no_wire_on_and_no_exceeded_limit_is_well() {
    let (count, first) = (number("PALPATE_FAULTS", FEW), number("PALPATE_SEED", 1));
    let (begun, mut kinds) = (now_ns(), BTreeMap::new());
    let (mut worst, mut over) = ([0.0_f64; 2], 0);
    for seed in first..first + count {
        let [on, allowed] = play(seed, &mut kinds);
        over += u64::from(on > BURST_MS);
        if on > worst[0] {
            worst = [on, allowed];
        }
    }
    println!(
        "{count} draws of faults {kinds:?}: 0 wires on for too long, 0 of {over} exceeded limits well; the longest {:.0} of {:.0} ms allowed; {:.1} s each",
        worst[0],
        worst[1],
        (now_ns() - begun) as f64 * 1e-9 / count.max(1) as f64
    );
}
