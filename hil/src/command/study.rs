//! `hil study`: studies with people.

use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

use palpate_files::{BenchKind, Loaded, Protocol, load_protocol};
use palpate_records::digest::short_digest;
use palpate_records::table::{as_csv, plain};
use palpate_run::Failure;
use palpate_study::{
    About, Analysis, Line, Person, Played, Record, Reply, Resumed, Said, Session, Step, Stimulus,
    Uptime, VERSION, analyse,
};

use super::devices::bench;
use super::new;
use super::study_simulate::simulated;
use crate::cli::{AnalyseArgs, NewKind, StudyAction, StudyRunArgs};
use crate::study::{
    Answers, Conducting, Dose, Ended, Folder, Player, SessionClock, Stimuli, Writing, conduct,
    growth, page, planned, uptime, wearer,
};
use palpate_live::clock;
use palpate_live::output::{note, print, print_json};
use palpate_live::real::{refuse_latched, watch};
use palpate_live::serve::Desk;

/// Time that pages have to take in the end of a session.
const LAST: Duration = Duration::from_millis(300);

/// Runs the action of `hil study`.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn study(action: StudyAction) -> Result<(), Failure> {
    match action {
        StudyAction::New(args) => new(&NewKind::Protocol(args)),
        StudyAction::Run(args) => run(&args),
        StudyAction::Analyse(args) => analysed(&args),
        StudyAction::Simulate(args) => simulated(&args),
    }
}

/// A protocol on a bench, and the dose of a participant's session at its strongest.
fn prepared(args: &StudyRunArgs) -> Result<(Stimuli, Session, Dose), Failure> {
    let protocol = load_protocol(&args.protocol)?;
    let on = &args.on;
    let bench = bench(on.bench.as_deref(), &on.can, &on.i2c)?;
    if args.simulated && bench.value.is_hardware() {
        return Err(Failure::Input(format!(
            "--simulated: expected an emulated bench, found `{}`: a simulated person wears no hardware",
            bench.value.name
        )));
    }
    if let Some(real) = bench
        .value
        .real
        .as_ref()
        .filter(|_| bench.value.is_hardware())
    {
        refuse_latched(&watch(&bench.value, real))?;
    }
    let session = Session::new(protocol.value.clone(), args.participant, on.seed);
    let stimuli = Stimuli::new(protocol, bench)?;
    let dose = planned(&stimuli, &session)?;
    Ok((stimuli, session, dose))
}

fn run(args: &StudyRunArgs) -> Result<(), Failure> {
    let (stimuli, mut session, mut dose) = prepared(args)?;
    if args.dose {
        print(|out| dose.write(out))?;
        return dose.check();
    }
    dose.check()?;
    let folder = Folder::make(&args.out, stimuli.protocol())?;
    let mut writing = folder.participant(args.participant, args.resume)?;
    let uptime = uptime();
    let about = about(args, &stimuli, &dose, &uptime)?;
    if let Some(record) = &writing.record
        && let Some(difference) = record.about.differs(&about)
    {
        return Err(Failure::Input(format!("--resume: {difference}")));
    }
    let desk = match args.simulated {
        true => {
            dose.known.growth = growth(&stimuli)?;
            None
        }
        false => Some(Desk::open(args.at)?),
    };
    let mut player = Player::new(stimuli, dose.rehearsals, args.on.seed, desk.clone());
    let at_ms = match writing.record.is_some() {
        true => resume(&mut session, &mut player, &mut writing, &uptime)?,
        false => {
            writing.add(Line::Session(about))?;
            0
        }
    };
    let answers = match &desk {
        Some(desk) => {
            note(&format!("participant: {}", desk.url));
            note(&format!("experimenter: {}", desk.experimenter_url));
            Answers::Page(desk)
        }
        None => {
            let (number, seed) = (args.participant, args.on.seed);
            let person = Person::new(session.protocol(), number, seed, &dose.known);
            Answers::Person(Box::new(person))
        }
    };
    let ended = conduct(Conducting {
        session,
        writing,
        player,
        answers,
        dose: dose.share,
        clock: SessionClock::new(at_ms, &uptime),
        known: dose.known,
        begun: false,
    });
    if let Some(desk) = &desk {
        // Pages have a moment to take in how it ended.
        let _ = desk.hear(LAST);
    }
    told(args, &ended?)
}

/// Ends the command by the end of a session, in words and a status.
fn told(args: &StudyRunArgs, ended: &Ended) -> Result<(), Failure> {
    let (n, out) = (args.participant, args.out.display());
    match ended {
        Ended::Done => {
            print(|w| writeln!(w, "participant {n}: done; next: hil study analyse {out}"))
        }
        Ended::Declined => {
            print(|w| writeln!(w, "participant {n}: did not agree; nothing was played"))
        }
        Ended::Stopped(text) => Err(Failure::Guard(format!(
            "participant {n}: {text}; --resume goes on with the session"
        ))),
        Ended::Signal(name) => Err(Failure::Stopped(format!(
            "participant {n}: stopped by {name}; --resume goes on with the session"
        ))),
    }
}

fn about(
    args: &StudyRunArgs,
    stimuli: &Stimuli,
    dose: &Dose,
    uptime: &Uptime,
) -> Result<About, Failure> {
    let protocol: &Loaded<Protocol> = stimuli.protocol();
    let setup = stimuli.setup(&Stimulus::Silence)?;
    let bench = &setup.bench.value;
    let now_us = clock::unix_us();
    Ok(About {
        version: VERSION,
        palpate: env!("CARGO_PKG_VERSION").into(),
        protocol: protocol.value.name.clone(),
        protocol_digest: short_digest(&protocol.source.values()),
        participant: args.participant,
        seed: args.on.seed,
        bench: bench.name.clone(),
        source: match bench.kind {
            BenchKind::Emulated => "emulated".into(),
            BenchKind::Real => "real".into(),
        },
        limits_digest: short_digest(&setup.limits.source.values()),
        wires_mm: stimuli.wires_mm().to_vec(),
        began: clock::date(now_us),
        began_unix_ms: now_us / 1000,
        uptime: uptime.clone(),
        simulated: args.simulated,
        dose_planned: dose.share,
    })
}

/// Takes up a session and a bench where the record leaves them. The stimulus that was about to be played when the
/// program ended counts as played, and its trial is void. Returns the session's time at this uptime, ms.
fn resume(
    session: &mut Session,
    player: &mut Player,
    writing: &mut Writing,
    uptime: &Uptime,
) -> Result<u64, Failure> {
    let Some(record) = &writing.record else {
        return Ok(0);
    };
    let resumed = record.resumed(session.protocol().clone());
    *session = resumed.map_err(|e| Failure::Input(format!("--resume: {e}")))?;
    let (now_ms, open) = (record.now_ms(uptime), record.open());
    let played = record.replies().filter_map(|said| said.trial.as_ref());
    let played = played.flat_map(|played| &played.intervals);
    player.remember(played.chain(&open).chain(record.passes()))?;
    writing.add(Line::Resumed(Resumed {
        at_ms: writing.stamp(now_ms),
        palpate: env!("CARGO_PKG_VERSION").into(),
        uptime: uptime.clone(),
    }))?;
    if let Step::Trial(trial) = session.step()
        && !open.is_empty()
    {
        let trial = Played {
            intervals: open,
            ..Played::new(trial)
        };
        let reply = Reply::Void("the program ended".into());
        let taken = session.take(&reply);
        taken.map_err(|e| Failure::Input(format!("--resume: {e}")))?;
        writing.add(Line::Reply(Said {
            at_ms: writing.stamp(now_ms),
            reply,
            trial: Some(trial),
        }))?;
    }
    Ok(now_ms)
}

/// Analysis of a folder's records.
fn answered(dir: &Path, protocol: &Protocol, records: &[Record]) -> Result<Analysis, Failure> {
    if records.is_empty() {
        return Err(Failure::Input(format!(
            "{}: expected a participant's record, found none",
            dir.display()
        )));
    }
    analyse(protocol, records).map_err(|e| Failure::Input(format!("{}: {e}", dir.display())))
}

/// Refuses to hold simulated people against themselves: those of one protocol, number and seed are the same people.
fn independent(own: &[Record], others: &[Record], beside: &Path) -> Result<(), Failure> {
    let same = |a: &Record, b: &Record| {
        let person = |r: &Record| (r.about.protocol.clone(), r.about.participant, r.about.seed);
        a.about.simulated && b.about.simulated && person(a) == person(b)
    };
    let both = own.iter().filter(|a| others.iter().any(|b| same(a, b)));
    let both: Vec<String> = both.map(|r| r.about.participant.to_string()).collect();
    match both.is_empty() {
        true => Ok(()),
        false => Err(Failure::Input(format!(
            "--beside {}: expected other people, found simulated participants of the same protocol, number and seed: {}; `hil study run --seed` draws others",
            beside.display(),
            both.join(", ")
        ))),
    }
}

fn analysed(args: &AnalyseArgs) -> Result<(), Failure> {
    let (folder, protocol) = Folder::open(&args.dir)?;
    let records = folder.records()?;
    let mut analysis = answered(&args.dir, &protocol, &records)?;
    if let Some(other) = &args.beside {
        let (folder, their) = Folder::open(other)?;
        let their_records = folder.records()?;
        let found = answered(other, &their, &their_records)?;
        // Two studies of one protocol are told apart by their folders.
        let dirs = [other, &args.dir].map(|dir| dir.display().to_string());
        let names = match found.protocol == analysis.protocol {
            true => (dirs[0].as_str(), dirs[1].as_str()),
            false => (found.protocol.as_str(), protocol.name.as_str()),
        };
        independent(&records, &their_records, other)?;
        if !analysis.compare_ratings(&found, names) {
            return Err(Failure::Input(format!(
                "--beside {}: expected ratings of a condition and a scale that {} has as well, found none in common",
                other.display(),
                args.dir.display()
            )));
        }
    }
    let mut written = vec![folder.write("index.html", &page(&analysis))?];
    for table in palpate_study::tables(&analysis) {
        let rows = table.rows.iter();
        let rows = rows.map(|cells| Vec::from_iter(cells.iter().map(|cell| plain(cell))));
        let text = format!("{}\n{}", table.head, as_csv(rows));
        written.push(folder.write(table.file, &text)?);
    }
    let wires = records
        .first()
        .map_or(0, |record| record.about.wires_mm.len());
    for participant in &analysis.participants {
        if let Some(text) = wearer(&protocol, participant, wires) {
            let name = format!("participant-{}.toml", participant.number);
            written.push(folder.write(&name, &text)?);
        }
    }
    if args.json {
        return print_json(&analysis);
    }
    print(|out| {
        summary(&analysis, out)?;
        written
            .iter()
            .try_for_each(|path| writeln!(out, "  wrote {}", path.display()))
    })
}

fn summary(of: &Analysis, out: &mut dyn Write) -> io::Result<()> {
    let who = if of.simulated {
        "simulated people"
    } else {
        "people"
    };
    writeln!(out, "{}: {} {who}", of.protocol, of.participants.len())?;
    for c in &of.comparisons {
        let says = c.says_nothing().unwrap_or_else(|| {
            let r = &c.effect;
            format!(
                "U {:.1}, p {:.4}, r {:.2} [{:.2}, {:.2}]",
                c.u, c.p, r.value, r.low, r.high
            )
        });
        let [first, second] = c.medians;
        writeln!(
            out,
            "  {}: {} {first:.2}, {} {second:.2}; {says}",
            plain(&c.of),
            plain(&c.first),
            plain(&c.second)
        )?;
    }
    for d in &of.drawings {
        if let (Some(rmse), Some(frechet)) = (&d.rmse_mm, &d.frechet_mm) {
            writeln!(
                out,
                "  {}: {} drawings, RMSE {:.2} mm, Frechet {:.2} mm, {:.2} breaks each",
                plain(&d.condition),
                d.drawings,
                rmse.value,
                frechet.value,
                d.breaks
            )?;
        }
    }
    for c in &of.choices {
        if let Some(part) = &c.part {
            let says = c.says_nothing().unwrap_or_else(|| format!("p {:.4}", c.p));
            let [value, low, high] = [part.value, part.low, part.high].map(|v| 100.0 * v);
            writeln!(
                out,
                "  {} over {}: {value:.0} % [{low:.0}, {high:.0}], {says}",
                plain(&c.pair[1]),
                plain(&c.pair[0])
            )?;
        }
    }
    if let Some(off) = &of.localisation_mm {
        writeln!(
            out,
            "  felt {:.1} mm [{:.1}, {:.1}] from the wire",
            off.value, off.low, off.high
        )?;
    }
    Ok(())
}
