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
fn shells_can_read_their_completions() {
    for (shell, word) in [
        ("bash", "complete -F"),
        ("zsh", "#compdef hil"),
        ("fish", "complete -c hil"),
    ] {
        let script = good(&["completions", shell]);
        assert!(script.contains(word), "{shell}");
        for option in ["replay", "export", "illusion"] {
            assert!(script.contains(option), "{shell}: {option}");
        }
        assert!(
            !script.contains("heartbeat-ms"),
            "{shell}: the guardian is internal"
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
    refused_with(&["man", "rum"], &["did you mean `run`?", "doctor"]);
}
