//! The house rules that no compiler checks: who may depend on whom, who may know the time, what a
//! file may weigh, which links must lead somewhere.

use std::fs;
use std::path::{Path, PathBuf};

pub(super) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .canonicalize()
        .unwrap()
}

/// Every file of the tree below `folder` with one of these endings, without build output and what was fetched.
fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(folder) = pending.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                if !["target", ".git", ".venv", "out", "node_modules"].contains(&name.as_str()) {
                    pending.push(path);
                }
            } else if endings.iter().any(|e| name.ends_with(e)) {
                found.push(path);
            }
        }
    }
    found.sort();
    assert!(
        !found.is_empty(),
        "nothing found below {}",
        folder.display()
    );
    found
}

pub fn complain(rule: &str, offences: Vec<String>) {
    assert!(offences.is_empty(), "{rule}:\n  {}", offences.join("\n  "));
}

/// Lines of code that contain one of the words, as `file:line: text`, comments left out.
pub fn lines_with(folder: &str, words: &[&str]) -> Vec<String> {
    let mut hits = Vec::new();
    for path in files(&root().join(folder), &[".rs"]) {
        for (number, line) in fs::read_to_string(&path).unwrap().lines().enumerate() {
            let code = line.split("//").next().unwrap();
            if words.iter().any(|w| code.contains(w)) {
                hits.push(format!(
                    "{}:{}: {}",
                    path.display(),
                    number + 1,
                    line.trim()
                ));
            }
        }
    }
    hits
}

#[test]
fn dependencies_run_one_way() {
    let allowed: &[(&str, &[&str])] = &[
        ("core", &[]),
        ("core/nostd", &["core"]),
        ("core/unit", &["core"]),
        ("core/unit/images/shared", &["core", "unit"]),
        ("emulators", &["core", "unit"]),
        ("fixtures", &[]),
        ("hil/files", &["core", "fixtures"]),
        ("hil/records", &["core"]),
        ("hil/buses", &["core", "emulators"]),
        ("hil/run", &["core", "emulators", "files", "records"]),
        ("hil/capture", &["core", "files", "records", "run"]),
        ("hil/study", &["core", "files"]),
        (
            "hil/texture",
            &["core", "emulators", "files", "records", "run"],
        ),
        (
            "hil/texture/train",
            &["core", "emulators", "files", "texture"],
        ),
        (
            "hil/live",
            &[
                "buses",
                "core",
                "emulators",
                "files",
                "records",
                "run",
                "study",
                "unit",
            ],
        ),
        (
            "hil",
            &[
                "buses",
                "capture",
                "core",
                "emulators",
                "files",
                "fixtures",
                "live",
                "records",
                "run",
                "study",
                "texture",
            ],
        ),
        ("hil/web", &["core", "files", "fixtures", "records", "run"]),
        (
            "hil/link",
            &["buses", "core", "files", "hil", "live", "records", "run"],
        ),
        (
            "hil/python",
            &[
                "core",
                "emulators",
                "files",
                "hil",
                "live",
                "records",
                "run",
            ],
        ),
    ];
    let mut offences = Vec::new();
    for (package, may_use) in allowed {
        let manifest = fs::read_to_string(root().join(package).join("Cargo.toml")).unwrap();
        let dependencies = manifest.split("[dependencies]").nth(1).unwrap_or_default();
        let dependencies = dependencies.split("\n[").next().unwrap();
        for line in dependencies.lines() {
            let Some(rest) = line.strip_prefix("palpate-") else {
                continue;
            };
            let name = rest.split(['.', ' ', '=']).next().unwrap();
            if !may_use.contains(&name) {
                offences.push(format!("{package} uses palpate-{name}"));
            }
        }
    }
    complain(
        "dependencies run core <- emulators <- run <- live <- hil <- python, and never sideways",
        offences,
    );
}

#[test]
fn only_the_emulators_write_what_the_guard_only_observed() {
    let mut offences = Vec::new();
    for folder in ["core", "hil", "tests/bench", "tests/lab"] {
        offences.extend(lines_with(folder, &["Observed> for", "Actuators<U> for"]));
    }
    offences.retain(|hit| !hit.contains("_tests.rs:"));
    complain(
        "an observed update goes to emulated registers and to nothing else",
        offences,
    );
}

/// What makes a room impure. A length of time is no clock.
const RUN_BANNED: [&str; 8] = [
    "Instant::now",
    "SystemTime",
    "std::thread",
    "std::fs",
    "std::net",
    "std::env",
    "std::process",
    "std::io::std",
];

#[test]
fn only_hil_knows_the_time_the_files_and_the_net() {
    let banned = [
        "std::time",
        "std::thread",
        "std::fs",
        "std::net",
        "std::env",
        "std::process",
    ];
    let mut offences = lines_with("emulators/src", &banned);
    offences.extend(lines_with("hil/records/src", &banned[..4]));
    offences.extend(lines_with("hil/run/src", &RUN_BANNED));
    offences.extend(lines_with("hil/link/src/judge", &RUN_BANNED));
    offences.extend(lines_with("core/src", &["std::", "println!"]));
    offences.retain(|line| !in_tests(line));
    complain(
        "core and emulators take time as an argument and do no I/O",
        offences,
    );
}

#[test]
fn core_and_emulators_use_the_same_mathematics_everywhere() {
    // Platform math differs in its last digit between machines; libm does not. Square roots and
    // rounding are exact by IEEE 754 and stay allowed.
    let platform = [
        ".sin()", ".cos()", ".tan()", ".exp()", ".ln()", ".log2()", ".powf(", ".powi(", ".log10()",
        ".hypot(",
    ];
    let mut offences = lines_with("core/src", &platform);
    offences.extend(lines_with("emulators/src", &platform));
    offences.extend(lines_with("hil/run/src", &platform));
    offences.retain(|line| !in_tests(line));
    complain("libm instead of the platform's math", offences);
}

/// Whether a `file:line:` hit lies in a test module, the last part of a file by convention.
fn in_tests(hit: &str) -> bool {
    let mut parts = hit.splitn(3, ':');
    let (path, line) = (
        parts.next().unwrap(),
        parts.next().unwrap().parse::<usize>().unwrap(),
    );
    let text = fs::read_to_string(path).unwrap();
    let tests = text
        .lines()
        .position(|l| l.starts_with("#[cfg(test)]"))
        .unwrap_or(usize::MAX);
    line > tests || path.ends_with("tests.rs") || path.contains("_tests/")
}

#[test]
fn files_can_be_held_in_ones_head_and_say_what_they_are() {
    let mut offences = Vec::new();
    for path in files(&root(), &[".rs"]) {
        let text = fs::read_to_string(&path).unwrap();
        let count = text.lines().count();
        if count > 500 {
            offences.push(format!("{}: {count} lines, at most 500", path.display()));
        }
        if !text.starts_with("//!") {
            offences.push(format!(
                "{}: does not begin by saying what belongs in it (//!)",
                path.display()
            ));
        }
    }
    complain("house rules for files", offences);
}

/// Rust files that ship: no test in their path. Benchmarks count, wherever they lie.
pub(super) fn production() -> Vec<PathBuf> {
    let ships = |path: &PathBuf| {
        let path = path.strip_prefix(root()).unwrap().to_string_lossy();
        !path.contains("test") || (path.starts_with("tests/bench/") && !path[6..].contains("test"))
    };
    files(&root(), &[".rs"]).into_iter().filter(ships).collect()
}

/// Whether a function begins on a line, after any words that may stand before `fn`.
fn is_function(line: &str) -> bool {
    let mut rest = line.trim_start();
    loop {
        if rest.starts_with("fn ") {
            return true;
        }
        let (word, more) = rest.split_once(' ').unwrap_or((rest, ""));
        let before = ["pub", "const", "async", "unsafe", "extern"].contains(&word)
            || (word.starts_with('"') && word.ends_with('"'));
        rest = match rest.strip_prefix("pub(") {
            Some(scope) => scope.split_once(") ").map_or("", |s| s.1),
            None if before => more.trim_start(),
            None => return false,
        };
    }
}

/// Every function of a text as rustfmt writes it: its first line, from 1, and how many it has. Declarations have none.
fn functions(text: &str) -> Vec<(usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let indent = |line: &str| line.len() - line.trim_start().len();
    let mut found = Vec::new();
    for (first, line) in lines.iter().enumerate().filter(|(_, l)| is_function(l)) {
        // A signature and a body end at the indentation that they begin with.
        let level = indent(line);
        let mut same = (first..lines.len()).filter(|&n| indent(lines[n]) == level);
        let ends = |n: &usize| [';', '{', '}'].iter().any(|c| lines[*n].ends_with(*c));
        let Some(signed) = same.find(ends) else {
            continue;
        };
        let last = match lines[signed].chars().last() {
            Some('{') => same.find(|&n| lines[n].trim_start() == "}"),
            Some('}') => Some(signed),
            _ => None,
        };
        found.extend(last.map(|last| (first + 1, last - first + 1)));
    }
    found
}

#[test]
fn functions_are_found_whatever_stands_before_them() {
    let body = "        step();\n".repeat(80);
    for before in [
        "",
        "pub ",
        "pub(crate) ",
        "pub(in crate::guard) const ",
        "async ",
        "pub const unsafe ",
        "unsafe extern \"C\" ",
    ] {
        let plain = format!("    {before}fn long() {{\n{body}    }}\n");
        assert_eq!(functions(&plain), [(1, 82)], "{before}");
        let wide = format!(
            "    {before}fn long<T>(\n        t: T,\n    ) -> T\n    where\n        T: Copy,\n    {{\n{body}    }}\n"
        );
        assert_eq!(functions(&wide), [(1, 87)], "{before}");
    }
    let short =
        "    fn declared(&self) -> [u8; 2];\n    fn on_one_line() {}\n    let fn_like = 1;\n";
    let all = format!("trait T {{\n{short}    fn long() {{\n{body}    }}\n}}\n");
    assert_eq!(functions(&all), [(3, 1), (5, 82)]);
}

#[test]
fn long_functions_stay_few() {
    let mut long = Vec::new();
    for path in production() {
        let text = fs::read_to_string(&path).unwrap();
        let over = functions(&text).into_iter().filter(|f| f.1 > 80);
        long.extend(over.map(|(line, _)| format!("{}:{line}", path.display())));
    }
    let most = 10;
    assert!(
        long.len() <= most,
        "functions over 80 lines, at most {most}:\n  {}",
        long.join("\n  ")
    );
}

#[test]
fn documents_that_rust_names_are_in_the_tree() {
    let documents = files(&root(), &[".md"]);
    let names: Vec<String> = documents
        .iter()
        .map(|p| p.file_name().unwrap().to_string_lossy().into_owned())
        .collect();
    let mut offences = Vec::new();
    for path in files(&root(), &[".rs"]) {
        for (number, line) in fs::read_to_string(&path).unwrap().lines().enumerate() {
            let comment = line.split_once("//").map_or("", |l| l.1);
            let is_name = |c: char| c.is_alphanumeric() || "._-".contains(c);
            for word in comment.split(|c| !is_name(c)) {
                let word = word.trim_end_matches('.');
                let named = word.strip_suffix(".md").is_some_and(|w| !w.is_empty());
                if named && !names.iter().any(|n| n == word) {
                    offences.push(format!("{}:{}: {word}", path.display(), number + 1));
                }
            }
        }
    }
    complain("documents that are not here", offences);
}

#[test]
fn nothing_is_left_open() {
    let words = [
        concat!("TO", "DO"),
        concat!("FIX", "ME"),
        concat!("#[ign", "ore"),
    ];
    let mut offences = Vec::new();
    for path in files(&root(), &[".rs", ".md", ".toml"]) {
        let text = fs::read_to_string(&path).unwrap();
        for (number, line) in text.lines().enumerate() {
            if words.iter().any(|w| line.contains(w)) {
                offences.push(format!(
                    "{}:{}: {}",
                    path.display(),
                    number + 1,
                    line.trim()
                ));
            }
        }
    }
    complain("open ends belong in an issue", offences);
}

#[test]
fn no_merge_is_left_half_done() {
    let marks = [concat!("<<<<", "<<< "), concat!(">>>>", ">>> ")];
    let mut offences = Vec::new();
    // Scripts have no ending; what is no text has no lines.
    for path in files(&root(), &[""]) {
        let text = fs::read_to_string(&path).unwrap_or_default();
        if text.lines().any(|l| marks.iter().any(|m| l.starts_with(m))) {
            offences.push(path.display().to_string());
        }
    }
    complain("marks of a merge", offences);
}

#[test]
fn links_lead_somewhere() {
    let mut offences = Vec::new();
    for path in files(&root(), &[".md"]) {
        let text = fs::read_to_string(&path).unwrap();
        for link in text
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split(')').next())
        {
            let target = link.split('#').next().unwrap();
            if target.is_empty() || target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            if !path.parent().unwrap().join(target).exists() {
                offences.push(format!("{}: {link}", path.display()));
            }
        }
    }
    complain("relative links in Markdown", offences);
}

#[test]
fn the_log_of_hazards_has_the_tests_of_the_bench() {
    let log = fs::read_to_string(root().join("docs/hazards.toml")).unwrap();
    let of_bench = [
        "bench/guardian_faults.rs",
        "bench/names.rs",
        "bench/overrun.rs",
        "bench/unseen_time.rs",
        "bench/ledger.rs",
        "bench/off.rs",
        "bench/campaign.rs",
        "bench/sequences.rs",
        "tests/namespaces.rs",
    ];
    let mut offences = Vec::new();
    for path in files(&root().join("hil"), &[".rs"]) {
        if !of_bench.iter().any(|name| path.ends_with(name)) {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        for (at, _) in text.match_indices("#[test]") {
            let (_, after) = text[at..].split_once("fn ").unwrap();
            let name = after.split('(').next().unwrap();
            if !log.contains(&format!("::{name}\"")) {
                offences.push(format!("{}: {name}", path.display()));
            }
        }
    }
    complain("tests of hazards that docs/hazards.toml lacks", offences);
}
