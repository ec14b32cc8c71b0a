//! The command line itself: help, completions, man pages.

use super::*;

#[test]
fn help_of_a_command_has_two_spellings() {
    for name in ["run", "check", "test"] {
        assert_eq!(good(&["help", name]), good(&[name, "--help"]));
    }
    assert!(good(&["help"]).contains("completions"));
    refused_with(&["help", "rum"], &["rum"]);
}

#[test]
fn help_shows_commands_in_groups_with_examples() {
    let help = good(&["--help"]);
    let place = |text: &str| help.find(text).unwrap_or_else(|| panic!("{text}: {help}"));
    assert!(place("Run:") < place("  sweep ") && place("  sweep ") < place("Hardware:"));
    assert!(place("Examples:") < place("hil run sphere-circle --serve"));
    assert!(good(&["sweep", "-h"]).contains("illusion.soa_ms=100..130:10"));
}

#[test]
fn shells_can_read_their_completions() {
    for (shell, word) in [
        ("bash", "complete -o"),
        ("zsh", "#compdef hil"),
        ("fish", "complete --"),
    ] {
        let script = good(&["completions", shell]);
        assert!(
            script.contains(word) && script.contains("HIL_COMPLETE"),
            "{shell}: {script}"
        );
        // Where the shell is there, it says itself whether it can read the script.
        let folder = Folder::new(&format!("completions-{shell}"));
        let file = folder.write("script", &script);
        if let Ok(read) = Command::new(shell).arg("-n").arg(&file).output() {
            assert!(
                read.status.success(),
                "{}",
                String::from_utf8_lossy(&read.stderr)
            );
        }
    }
    refused_with(&["completions", "csh"], &["bash", "zsh", "fish"]);
}

/// What the script of a shell asks for, and what it hears: the last word is the one that is completed.
#[test]
fn names_files_laws_and_keys_are_completed() {
    let folder = Folder::new("completed");
    let scene = palpate_fixtures::scene("idle").unwrap();
    folder.write("my-scene.toml", scene);
    for (line, some, none) in [
        ("ru", "run", "review"),
        ("run sphere-al", "sphere-along", "idle"),
        ("run my", "my-scene.toml", "idle"),
        ("run --bench em", "emulated", "thesis"),
        ("run -b th", "thesis", "emulated"),
        ("run --illusion ph", "phantom", "inverse"),
        (
            "run --set illusion.so",
            "illusion.soa_ms=",
            "illusion.beta=",
        ),
        (
            "run --set bench.drive.cu",
            "bench.drive.current_ma=",
            "illusion.beta=",
        ),
        ("study run wea", "wearer", "roughness"),
        ("man stu", "study", "run"),
        ("run --interes", "", "guardian"),
        ("", "sweep", "guardian"),
    ] {
        let words: Vec<&str> = std::iter::once("hil").chain(line.split(' ')).collect();
        let mut asked = command(&["--"], &folder.0);
        asked.args(&words).envs([
            ("HIL_COMPLETE", "bash"),
            ("_CLAP_IFS", "\n"),
            ("_CLAP_COMPLETE_INDEX", &(words.len() - 1).to_string()),
        ]);
        let said = Said::from(asked.output().unwrap());
        let all: Vec<&str> = said.out.lines().map(str::trim).collect();
        assert!(some.is_empty() || all.contains(&some), "{line}: {all:?}");
        assert!(!all.contains(&none), "{line}: {all:?}");
    }
}

#[test]
fn man_pages() {
    let page = good(&["man"]);
    assert!(
        page.contains(".TH hil 1") && page.contains("doctor"),
        "{page}"
    );
    assert!(!page.contains("guardian"), "{page}");
    let run = good(&["man", "run"]);
    assert!(
        run.contains(".TH hil-run 1") && run.contains("\\-\\-replay"),
        "{run}"
    );
    let below = good(&["man", "study", "run"]);
    assert!(
        below.contains(".TH hil-study-run 1") && below.contains("\\-\\-participant"),
        "{below}"
    );
    refused_with(&["man", "rum"], &["did you mean `run`?", "doctor"]);
    refused_with(&["man", "run", "idle"], &["nothing behind `hil run`"]);
}
