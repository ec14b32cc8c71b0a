//! A bench: a folder with adapters, a file of the bench, a folder of stops, and pages that say what goes wrong.

use std::ffi::CString;
use std::fs::{self, File};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use nix::time::{ClockId, clock_gettime};
use palpate_tests::fake_bench::{
    AdapterPage, ClockPage, FOLDER, MAJOR, Mapped, Mode, NODE_MODE, Page, ScarcePage,
};

use crate::feed::Feed;
use crate::run::{Run, Said};

/// The address of the chip on each adapter.
const CHIP: u8 = 0x40;
/// A wire that is no longer reachable, or whose run is dead, is off this long after it can be.
pub const OFF_MS: f64 = 50.0;
/// How often what happens on a bench is looked at.
const LOOK: Duration = Duration::from_micros(200);

/// One bench at a time: two would make each other late.
static TURN: Mutex<()> = Mutex::new(());

/// Runs a test on a bench of so many adapters, or says why it cannot. A bench on which the guard stopped for a late turn
/// has learnt how slow this machine is and nothing else: then it is set up anew, twice.
pub fn on_bench(adapters: usize, test: impl Fn(&Bench)) {
    tried(3, adapters, test);
}

/// Runs a test once on a bench of so many adapters: one that says itself what a slow machine changes.
pub fn once_on_bench(adapters: usize, test: impl Fn(&Bench)) {
    tried(1, adapters, test);
}

fn tried(tries: u32, adapters: usize, test: impl Fn(&Bench)) {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Err(why) = preloading() {
        assert!(
            std::env::var("PALPATE_BENCH").as_deref() != Ok("required"),
            "the bench is required: {why}"
        );
        eprintln!("SKIPPED bench: {why}");
        return;
    }
    for attempt in 1.. {
        let bench = Bench::new(adapters);
        let done = catch_unwind(AssertUnwindSafe(|| test(&bench)));
        let Err(failed) = done else {
            return;
        };
        if attempt == tries || !bench.was_too_slow() {
            resume_unwind(failed);
        }
        eprintln!("this machine was too slow: late-tick; once more");
    }
}

/// The library, which cargo builds beside the program.
fn library() -> Result<PathBuf, String> {
    let folder = Path::new(env!("CARGO_BIN_EXE_hil")).parent().unwrap();
    let library = folder.join("examples/libfake_bench.so");
    match library.is_file() {
        true => Ok(library),
        false => Err(format!(
            "{} is not there; make it with `cargo build --profile test -p palpate-tests --example fake_bench`",
            library.display()
        )),
    }
}

/// Whether the program sees a bench that is preloaded under it, or why not.
fn preloading() -> Result<(), String> {
    static PROBED: OnceLock<Result<(), String>> = OnceLock::new();
    let probe = || {
        library()?;
        let bench = Bench::new(1);
        let said = bench.off(&["--i2c", &bench.node(0).display().to_string()]);
        match bench.adapters[0].transfers.load(Ordering::Acquire) {
            0 => Err(format!(
                "the program does not see what is preloaded: {said:?}"
            )),
            _ => Ok(()),
        }
    };
    PROBED.get_or_init(probe).clone()
}

/// The time by which the record is dated.
pub fn now_ns() -> u64 {
    nanoseconds(ClockId::CLOCK_MONOTONIC_RAW)
}

/// A true clock, nanoseconds.
pub fn nanoseconds(clock: ClockId) -> u64 {
    let now = clock_gettime(clock).unwrap();
    now.tv_sec() as u64 * 1_000_000_000 + now.tv_nsec() as u64
}

/// Looks until something is so, for `limit` at most; whether it is.
pub fn is_soon(limit: Duration, so: impl Fn() -> bool) -> bool {
    let begun = Instant::now();
    loop {
        if so() {
            return true;
        }
        if begun.elapsed() > limit {
            return false;
        }
        thread::sleep(LOOK);
    }
}

/// Measures how late this machine wakes who sleeps for a millisecond.
struct Metronome {
    over: Arc<AtomicBool>,
    worst_us: Arc<AtomicU64>,
    thread: Option<JoinHandle<()>>,
}

impl Metronome {
    fn start() -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let worst_us = Arc::new(AtomicU64::new(0));
        let (ended, worst) = (Arc::clone(&over), Arc::clone(&worst_us));
        let beat = Duration::from_millis(1);
        let thread = thread::spawn(move || {
            while !ended.load(Ordering::Relaxed) {
                let begun = Instant::now();
                thread::sleep(beat);
                let late = begun.elapsed().saturating_sub(beat);
                worst.fetch_max(late.as_micros() as u64, Ordering::Relaxed);
            }
        });
        Self {
            over,
            worst_us,
            thread: Some(thread),
        }
    }
}

impl Drop for Metronome {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        let _ = self.thread.take().unwrap().join();
    }
}

/// A bench under a test.
pub struct Bench {
    folder: PathBuf,
    /// Its adapters.
    pub adapters: Vec<Mapped<AdapterPage>>,
    /// The clocks of the program.
    pub clock: Mapped<ClockPage>,
    /// What the program lacks.
    pub scarce: Mapped<ScarcePage>,
    metronome: Metronome,
    started: AtomicU32,
    /// Processes that a test may have left.
    left: Mutex<Vec<u32>>,
}

impl Bench {
    fn new(adapters: usize) -> Self {
        static MADE: AtomicU32 = AtomicU32::new(0);
        let number = MADE.fetch_add(1, Ordering::Relaxed);
        let name = format!("hil-bench-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().canonicalize().unwrap().join(name);
        fs::create_dir_all(folder.join("state")).unwrap();
        let adapter = |n: usize| {
            plug(&folder, n, &format!("port-{n}"));
            let page: Mapped<AdapterPage> = mapped(&folder.join(format!("i2c-{n}.state")));
            page.put(&[CHIP]);
            page
        };
        let bench = Self {
            adapters: (0..adapters).map(adapter).collect(),
            clock: mapped(&folder.join("clock.state")),
            scarce: mapped(&folder.join("scarce.state")),
            metronome: Metronome::start(),
            started: AtomicU32::new(0),
            left: Mutex::default(),
            folder,
        };
        fs::write(bench.path("bench.toml"), bench.text()).unwrap();
        bench
    }

    /// A file of the bench's folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// An adapter's node.
    pub fn node(&self, adapter: usize) -> PathBuf {
        self.path(&format!("i2c-{adapter}"))
    }

    /// Plugs an adapter in at this port, as the kernel's adapter of that number.
    pub fn plug(&self, number: usize, port: &str) {
        plug(&self.folder, number, port);
    }

    /// Unplugs what is the kernel's adapter of this number.
    pub fn unplug(&self, number: usize) {
        fs::remove_file(self.node(number)).unwrap();
        let entry = self.path(&format!("sys/dev/char/{MAJOR}:{number}/device"));
        fs::remove_dir_all(entry.canonicalize().unwrap()).unwrap();
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    /// The bench's file: eight wires, spread over the adapters.
    fn text(&self) -> String {
        let nodes: Vec<_> = (0..self.adapters.len()).map(|n| self.node(n)).collect();
        self.text_on(&nodes)
    }

    /// The same on adapters by these names.
    pub fn text_on(&self, nodes: &[PathBuf]) -> String {
        let count = nodes.len();
        let mut text = format!(
            "name = \"fake\"\ndescription = \"chips of a fake bench\"\nkind = \"real\"\ndisplay = \"thimble-8\"\nlimits = \"default\"\n\
             wire = {{ kind = \"final-75um\", alloy = \"low\" }}\n\
             [real]\ncan = [\"lo\"]\ni2c = {nodes:?}\n\
             [drive]\ncurrent_ma = 1970.0\nsupply_limit_ma = 4000.0\npwm_hz = 200.0\nhot_pass = false\n"
        );
        for wire in 0..8 {
            let bus = wire * count / 8;
            text += &format!("[[outputs]]\nbus = {bus}\nboard = {CHIP:#x}\nchannel = {wire}\n");
        }
        text
    }

    /// The program with the library under it.
    pub fn program(&self, program: &Path, arguments: &[&str]) -> Command {
        let mut command = Command::new(program);
        command
            .args(arguments)
            .current_dir(&self.folder)
            .env("LD_PRELOAD", library().unwrap())
            .env(FOLDER, &self.folder)
            .env("PALPATE_STATE", self.path("state"))
            .stdin(Stdio::null());
        command
    }

    /// Starts a command of the program; its output goes to files of the folder.
    pub fn start(&self, arguments: &[&str]) -> Run<'_> {
        self.start_with(Path::new(env!("CARGO_BIN_EXE_hil")), arguments, None)
    }

    /// The same by another name of the program, or with another standard error.
    pub fn start_with(&self, program: &Path, arguments: &[&str], err: Option<Stdio>) -> Run<'_> {
        let number = self.started.fetch_add(1, Ordering::Relaxed);
        let file = |name: &str| {
            let path = self.path(&format!("{name}-{number}"));
            (File::create(&path).unwrap(), path)
        };
        let ((out, out_path), (err_file, err_path)) = (file("out"), file("err"));
        let mut command = self.program(program, arguments);
        command.stdout(out);
        command.stderr(err.unwrap_or_else(|| err_file.into()));
        let child = command.spawn().unwrap();
        self.leave(child.id());
        Run::new(self, child, out_path, err_path)
    }

    /// Returns when no program of the bench is left.
    #[track_caller]
    pub fn wait_until_alone(&self) {
        let is_process = |name: &str| {
            name.parse()
                .is_ok_and(|id| crate::run::runs(&self.folder, id))
        };
        let is_alone = || {
            let mut entries = fs::read_dir("/proc").unwrap().flatten();
            !entries.any(|entry| entry.file_name().to_str().is_some_and(is_process))
        };
        let limit = Duration::from_secs(8);
        assert!(is_soon(limit, is_alone), "a program of the bench goes on");
    }

    /// Starts a run of a skin that is touched, for at most so many seconds.
    pub fn run(&self, length_s: f64) -> Run<'_> {
        self.start(&Self::run_words(&self.scene(length_s)))
    }

    /// The words that start it.
    pub fn run_words(scene: &str) -> [&str; 5] {
        ["run", scene, "--bench", "bench.toml", "--quiet"]
    }

    /// Writes a scene of that length; its name.
    pub fn scene(&self, length_s: f64) -> String {
        let name = format!("scene-{length_s}.toml");
        fs::write(self.path(&name), crate::feed::scene(length_s)).unwrap();
        name
    }

    /// Touches the skin, from when the run listens until what is returned is dropped.
    pub fn feed(&self) -> Feed {
        Feed::start(self.path("lo.rx"), 4)
    }

    /// Switches off by `hil off`, to its end.
    pub fn off(&self, arguments: &[&str]) -> Said {
        self.start(&[&["off"], arguments].concat())
            .finish(Duration::from_secs(20))
    }

    /// Says what every adapter does from now on.
    pub fn set_mode(&self, mode: Mode) {
        self.adapters.iter().for_each(|page| page.set_mode(mode));
    }

    /// Whether any channel is on.
    pub fn is_on(&self) -> bool {
        self.adapters.iter().any(|page| is_on(page))
    }

    /// The longest time for which one channel was on in one go, milliseconds; one that is on still counts until now.
    pub fn longest_on(&self) -> f64 {
        self.longest_on_since(0)
    }

    /// The same of what was on after a moment, and only what of it came after.
    pub fn longest_on_since(&self, from_ns: u64) -> f64 {
        let now = now_ns();
        let mut longest = 0;
        for page in &self.adapters {
            let record = page.record().unwrap();
            let chips = record[0].widths.len();
            for (chip, channel) in (0..chips).flat_map(|n| (0..16).map(move |c| (n, c))) {
                let mut since = None;
                for change in &record {
                    match (change.widths[chip][channel] != 0, since) {
                        (true, None) => since = Some(change.at_ns),
                        (false, Some(on)) => {
                            longest = longest.max(change.at_ns.saturating_sub(from_ns.max(on)));
                            since = None;
                        }
                        _ => {}
                    }
                }
                if let Some(on) = since {
                    longest = longest.max(now.saturating_sub(from_ns.max(on)));
                }
            }
        }
        longest as f64 * 1e-6
    }

    /// How late this machine was during the test, milliseconds: by so much a limit in real time may be passed.
    pub fn lateness(&self) -> f64 {
        self.metronome.worst_us.load(Ordering::Relaxed) as f64 * 1e-3
    }

    /// The worst lateness since the last call, milliseconds.
    pub fn take_lateness(&self) -> f64 {
        self.metronome.worst_us.swap(0, Ordering::Relaxed) as f64 * 1e-3
    }

    /// Asserts that nothing is on, and that no channel was on for longer than `limit_ms` in one go after a moment.
    #[track_caller]
    pub fn assert_off_within(&self, limit_ms: f64, from_ns: u64) {
        let (longest, late) = (self.longest_on_since(from_ns), self.lateness());
        assert!(
            !self.is_on(),
            "still on after {longest:.1} ms, at most {limit_ms:.0} ms allowed"
        );
        assert!(
            longest <= limit_ms + late,
            "on for {longest:.1} ms, at most {limit_ms:.0} ms allowed, machine late by {late:.1} ms"
        );
    }

    /// What the stops say that are latched, one file after the other.
    pub fn latched(&self) -> String {
        let records = self.records().into_iter().map(|(_, text)| text);
        records.filter(|t| t.contains("state=stopped")).collect()
    }

    /// The records of all hardware, and their files.
    pub fn records(&self) -> Vec<(PathBuf, String)> {
        let entries = fs::read_dir(self.path("state")).unwrap();
        let files = entries.map(|entry| entry.unwrap().path());
        let files = files.filter(|path| path.extension().is_some_and(|e| e == "stop"));
        let text = |path: &Path| String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
        let read = |path: PathBuf| (path.clone(), text(&path));
        files.map(read).collect()
    }

    /// The files of the locks of its hardware. What they are called is the program's own business: they name the folder.
    pub fn locks(&self) -> Vec<PathBuf> {
        let own = self.folder.display().to_string();
        let folders = ["/run/lock", "/tmp"].into_iter();
        let entries = folders.flat_map(|folder| fs::read_dir(folder).into_iter().flatten());
        let files = entries.flatten().filter(|entry| {
            let name = entry.file_name();
            name.to_string_lossy().starts_with("palpate-")
        });
        let is_own = |path: &PathBuf| fs::read_to_string(path).is_ok_and(|t| t.contains(&own));
        files.map(|entry| entry.path()).filter(is_own).collect()
    }

    /// A process that is to be gone when the test is over.
    pub fn leave(&self, process: u32) {
        self.left.lock().unwrap().push(process);
    }

    fn was_too_slow(&self) -> bool {
        let said = |path: PathBuf| fs::read_to_string(path).is_ok_and(|t| t.contains("late-tick"));
        let files = fs::read_dir(&self.folder).unwrap();
        files.into_iter().any(|entry| said(entry.unwrap().path()))
            || self.latched().contains("late-tick")
    }
}

/// Whether any channel of an adapter is on.
pub fn is_on(page: &AdapterPage) -> bool {
    page.state().is_on()
}

/// Makes an adapter's node, and its place in sysfs: the device of this number at a port.
fn plug(folder: &Path, number: usize, port: &str) {
    let node = folder.join(format!("i2c-{number}"));
    File::create(&node).unwrap().set_len(number as u64).unwrap();
    fs::set_permissions(&node, fs::Permissions::from_mode(NODE_MODE)).unwrap();
    let device = folder.join(format!("sys/devices/{port}/i2c-{number}"));
    fs::create_dir_all(&device).unwrap();
    let entry = folder.join(format!("sys/dev/char/{MAJOR}:{number}"));
    fs::create_dir_all(&entry).unwrap();
    symlink(&device, entry.join("device")).unwrap();
}

fn mapped<T: Page>(path: &Path) -> Mapped<T> {
    File::create(path).unwrap();
    // A program of another user is on the same bench.
    fs::set_permissions(path, fs::Permissions::from_mode(0o666)).unwrap();
    let path = CString::new(path.as_os_str().as_bytes()).unwrap();
    Mapped::open(&path).unwrap()
}

impl Drop for Bench {
    fn drop(&mut self) {
        for process in self.left.get_mut().unwrap_or_else(PoisonError::into_inner) {
            if crate::run::runs(&self.folder, *process) {
                crate::run::signal(*process, nix::sys::signal::SIGKILL);
            }
        }
        for lock in self.locks() {
            let _ = fs::remove_file(lock);
        }
        let _ = fs::remove_dir_all(&self.folder);
    }
}
