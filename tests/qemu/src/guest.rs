//! QEMU, or another emulator, as a child process, the pipes of the rig, and a look into the guest's memory.
#![allow(
    clippy::disallowed_methods,
    reason = "a child process that hangs is ended by the wall clock"
)]

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;
use std::time::{Duration, Instant as Wall};

use nix::fcntl::{FcntlArg, OFlag, fcntl};
use nix::sys::stat::Mode;
use nix::unistd::mkfifo;
use palpate_image::rig::{ANSWERS, HEAD, Head, Kind, Outcome, QUESTIONS};

/// How long a guest may think about its next question, by the wall: a busy machine is patient.
const PATIENCE: Duration = Duration::from_secs(60);
/// How long a guest in real time lives at the most, so that no test waits for ever on one that only goes on asking.
const LIFE: Duration = Duration::from_secs(180);

/// A machine, and what emulates it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Its name, which is that of the image's folder as well.
    pub name: &'static str,
    /// The emulator's program.
    pub program: &'static str,
    /// The target that its images are built for.
    pub target: &'static str,
    /// Its arguments.
    pub arguments: &'static [&'static str],
    /// Further arguments: environment variables that name files.
    pub beside: &'static [&'static str],
    /// Its network card on a user network; `PORT` stands for the host's port.
    pub card: &'static [&'static str],
    /// Nanoseconds per instruction, as a power of two.
    pub shift: u32,
    /// Nanoseconds per count of the clock that the image measures with.
    pub tick_ns: u64,
    /// Where its memory begins, and how much of it an image is linked to.
    pub memory: (u32, usize),
}

impl Machine {
    /// Whether QEMU is its program.
    pub fn is_qemu(&self) -> bool {
        self.program.starts_with("qemu")
    }
}

/// How time passes, and whether there is a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Network {
    /// By instructions; a rest takes none of the host's time. The rig has all datagrams.
    Rig,
    /// By instructions as well, but a rest takes as long as it says; this UDP port of the host is the unit's.
    Udp(u16),
}

/// A running guest; it ends with this value.
#[derive(Debug)]
pub struct Guest {
    machine: Machine,
    child: Child,
    folder: PathBuf,
    questions: Receiver<(Head, Vec<u8>)>,
    answers: File,
    /// When a guest in real time has lived long enough.
    ends: Option<Wall>,
}

/// Numbers the folders of this process.
static FOLDERS: AtomicU32 = AtomicU32::new(0);

impl Guest {
    /// Starts an image.
    ///
    /// # Errors
    /// When QEMU or its pipes cannot be had.
    pub fn start(machine: Machine, image: &Path, network: Network) -> io::Result<Self> {
        let number = FOLDERS.fetch_add(1, Ordering::Relaxed);
        let name = format!("palpate-qemu-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir(&folder)?;
        let pipe = |name: &std::ffi::CStr| -> io::Result<File> {
            let path = folder.join(name.to_string_lossy().as_ref());
            mkfifo(&path, Mode::S_IRWXU)?;
            // For both directions: such an open never waits for the other end.
            OpenOptions::new().read(true).write(true).open(path)
        };
        let (mut asked, answers) = (pipe(QUESTIONS)?, pipe(ANSWERS)?);
        fcntl(&answers, FcntlArg::F_SETFL(OFlag::O_NONBLOCK))?;
        let mut command = Command::new(machine.program);
        command
            .args(machine.arguments)
            .args(machine.beside.iter().map(|name| beside(name)));
        if machine.is_qemu() {
            qemu(&mut command, &machine, network);
        }
        command
            .arg(image)
            .current_dir(&folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::null());
        let child = command.spawn().map_err(|e| {
            let program = machine.program;
            io::Error::new(
                e.kind(),
                format!("{program}: {e}; expected it to be installed, as ci/unit does"),
            )
        })?;
        let (sender, questions) = sync_channel(1);
        // It ends with its first failure, or with the receiver.
        thread::spawn(move || while read(&mut asked).is_ok_and(|q| sender.send(q).is_ok()) {});
        Ok(Self {
            machine,
            child,
            folder,
            questions,
            answers,
            ends: matches!(network, Network::Udp(_)).then(|| Wall::now() + LIFE),
        })
    }

    /// What it runs on.
    pub const fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Its next question; `None` if it ended, says nothing for a minute, or has lived for three minutes in real time.
    pub fn question(&mut self) -> Option<(Head, Vec<u8>)> {
        let left = self
            .ends
            .map(|end| end.saturating_duration_since(Wall::now()));
        let patience = left.map_or(PATIENCE, |left| left.min(PATIENCE));
        let question = self.questions.recv_timeout(patience).ok()?;
        if question.0.kind() == Some(Kind::Boot) {
            // An answer that a reset kept the guest from reading is none to its first question.
            let mut old = [0; 4096];
            while self.answers.read(&mut old).is_ok_and(|length| length > 0) {}
        }
        Some(question)
    }

    /// Answers the question.
    ///
    /// # Errors
    /// When QEMU is gone.
    pub fn answer(&mut self, ns: u64, outcome: Outcome, bytes: &[u8]) -> io::Result<()> {
        let head = Head {
            ns,
            what: outcome as u8,
            argument: 0,
            length: bytes.len() as u16, // a datagram at most
        };
        let mut whole = head.bytes().to_vec();
        whole.extend(bytes);
        self.answers.write_all(&whole)
    }

    /// Wakes QEMU's thread for everything but the guest, as a busy machine does at any time.
    ///
    /// # Errors
    /// When QEMU is gone.
    pub fn disturb(&mut self) -> io::Result<()> {
        let monitor = self.child.stdin.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        monitor.write_all(b"\n")
    }

    /// Asks QEMU to write the guest's memory down; it does so when the guest runs on. See [`Self::memory`].
    ///
    /// # Errors
    /// When QEMU is gone.
    pub fn save_memory(&mut self) -> io::Result<()> {
        let (from, length) = self.machine.memory;
        let monitor = self.child.stdin.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        writeln!(monitor, "pmemsave {from} {length} memory")?;
        monitor.flush()
    }

    /// The guest's memory, once it is written down.
    pub fn memory(&self) -> Option<Vec<u8>> {
        let memory = std::fs::read(self.folder.join("memory")).ok()?;
        (memory.len() == self.machine.memory.1).then_some(memory)
    }
}

/// A file that the environment names.
fn beside(name: &str) -> std::ffi::OsString {
    std::env::var_os(name).unwrap_or_default()
}

/// What QEMU is told of each machine.
fn qemu(command: &mut Command, machine: &Machine, network: Network) {
    let port = |argument: &&str, port: u16| argument.replace("PORT", &port.to_string());
    // In real time the guest waits for the host's clock: it counts instructions that take less time here, and a clock that
    // runs ahead while it works, by 10 % and more, is none that a host can plan by.
    let (card, sleep) = match network {
        Network::Rig => (vec!["-nic".into(), "none".into()], ",sleep=off"),
        Network::Udp(number) => (
            machine.card.iter().map(|a| port(a, number)).collect(),
            ",align=on",
        ),
    };
    let count = format!("shift={}{sleep}", machine.shift);
    command
        .args(["-display", "none", "-monitor", "stdio", "-serial", "null"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(card)
        // By the host's clock alone, a host that stands still would make the watchdog bite.
        .args(["-icount", &count])
        .arg("-kernel");
}

/// A question, with what follows it.
fn read(pipe: &mut File) -> io::Result<(Head, Vec<u8>)> {
    let mut head = [0; HEAD];
    pipe.read_exact(&mut head)?;
    let head = Head::read(&head);
    let mut bytes = vec![0; head.length.into()];
    pipe.read_exact(&mut bytes)?;
    Ok((head, bytes))
}

impl Drop for Guest {
    fn drop(&mut self) {
        // Nothing can be done about a child that will not die.
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
