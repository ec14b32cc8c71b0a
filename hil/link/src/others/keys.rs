//! `palpate-link keys`: a lab's certificates and access list.

use palpate_live::output::print;
use palpate_run::Failure;

use crate::cli::KeysArgs;
use crate::name::Name;
use crate::net::{Lab, Member};

/// A name, and fingers after `=`.
fn split(
    option: &str,
    text: &str,
    without: impl Fn(&str) -> String,
) -> Result<(String, Vec<String>), Failure> {
    let (name, fingers) = match text.split_once('=') {
        Some((name, fingers)) => (name, fingers.split(',').map(str::to_owned).collect()),
        None => (text, vec![without(text)]),
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
    let member = |name: String| Member {
        name,
        publishes: Vec::new(),
        feels: Vec::new(),
        watches: false,
        relays: false,
    };
    let mut wanted = Vec::new();
    for text in &args.robot {
        let (name, publishes) = split("--robot", text, |name| format!("{name}/*/*"))?;
        wanted.push(Member {
            publishes,
            ..member(name)
        });
    }
    for text in &args.wearer {
        let (name, feels) = split("--wearer", text, |_| "*/*/*".into())?;
        wanted.push(Member {
            feels,
            ..member(name)
        });
    }
    for text in &args.relay {
        let (name, _) = split("--relay", text, |_| String::new())?;
        wanted.push(Member {
            relays: true,
            ..member(name)
        });
    }
    for text in &args.watcher {
        let (name, _) = split("--watcher", text, |_| String::new())?;
        wanted.push(Member {
            watches: true,
            ..member(name)
        });
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
