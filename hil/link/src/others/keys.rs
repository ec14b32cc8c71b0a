//! `palpate-link keys`: a lab's certificates and access list.

use palpate_live::output::print;
use palpate_run::Failure;

use crate::cli::KeysArgs;
use crate::name::Name;
use crate::net::{Lab, Member};

/// Writes into a member what its kind may do, with the fingers that were named.
type Grant = fn(&mut Member, Option<Vec<String>>);

/// A name, and fingers after `=`.
fn split(option: &str, text: &str) -> Result<(String, Option<Vec<String>>), Failure> {
    let (name, fingers) = match text.split_once('=') {
        Some((name, fingers)) => (name, Some(fingers.split(',').map(str::to_owned).collect())),
        None => (text, None),
    };
    let name: Name = name
        .parse()
        .map_err(|e| Failure::Input(format!("{option} {text}: {e}")))?;
    Ok((name.to_string(), fingers))
}

/// Runs it.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &KeysArgs) -> Result<(), Failure> {
    let kinds: [(&str, &[String], Grant); 4] = [
        ("--robot", &args.robot, |robot, fingers| {
            let own = vec![format!("{}/*/*", robot.name)];
            robot.publishes = fingers.unwrap_or(own);
        }),
        ("--wearer", &args.wearer, |wearer, fingers| {
            wearer.feels = fingers.unwrap_or_else(|| vec!["*/*/*".into()]);
        }),
        ("--relay", &args.relay, |relay, _| relay.relays = true),
        ("--watcher", &args.watcher, |watcher, _| {
            watcher.watches = true;
        }),
    ];
    let mut wanted = Vec::new();
    for (option, texts, grant) in kinds {
        for text in texts {
            let (name, fingers) = split(option, text)?;
            let mut member = Member {
                name,
                ..Member::default()
            };
            grant(&mut member, fingers);
            wanted.push(member);
        }
    }
    if wanted.is_empty() {
        return Err(Failure::Input(
            "expected someone to make keys for: --robot, --wearer, --relay or --watcher NAME"
                .into(),
        ));
    }
    let access = Lab::make(&args.folder, &wanted, time::Duration::days(args.days));
    let access = access.map_err(|e| Failure::Input(e.to_string()))?;
    print(|out| {
        for one in &wanted {
            let folder = args.folder.join(&one.name);
            let name = &one.name;
            writeln!(out, "{name}: copy {} to its machine", folder.display())?;
        }
        let others = access.members.len() - wanted.len();
        if others > 0 {
            writeln!(
                out,
                "the access list changed: copy {} into the folders of the other {others} too, and start their programs anew",
                args.folder.join("access.toml").display()
            )?;
        }
        Ok(())
    })
}
