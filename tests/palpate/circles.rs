//! No circle between the files of a crate but parent and child, and none between its folders. Reads `use` and paths
//! as text: what a macro or a re-export hides is not seen.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A module's path below its crate: `["contact", "kmeans"]`; the crate's root is empty.
type Module = Vec<String>;

/// Crates of the workspace with source below `src`.
const CRATES: [&str; 16] = [
    "core",
    "core/unit",
    "emulators",
    "fixtures",
    "hil",
    "hil/buses",
    "hil/capture",
    "hil/files",
    "hil/link",
    "hil/live",
    "hil/python",
    "hil/records",
    "hil/run",
    "hil/texture",
    "hil/texture/train",
    "tests/bench",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every file below `folder` that is no test, with its module.
fn modules(folder: &Path) -> BTreeMap<Module, String> {
    let mut found = BTreeMap::new();
    let mut pending = vec![(folder.to_path_buf(), Module::new())];
    while let Some((folder, module)) = pending.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            if name.contains("test") {
                continue;
            }
            let mut below = module.clone();
            if path.is_dir() {
                below.push(name);
                pending.push((path, below));
            } else if path.extension().is_some_and(|e| e == "rs") {
                if !["mod", "lib", "main"].contains(&&*name) {
                    below.push(name);
                }
                found.insert(below, code(&fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found
}

/// A file without comments and without its tests, which stand last.
fn code(text: &str) -> String {
    let text = text.split("\n#[cfg(test)]").next().unwrap();
    let line = |l: &str| l.split("//").next().unwrap().to_owned();
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

/// The paths of a `use` tree: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn expand(tree: &str) -> Vec<String> {
    let Some(open) = tree.find('{') else {
        return vec![tree.to_owned()];
    };
    let (head, mut rest) = (&tree[..open], &tree[open + 1..]);
    rest = rest.rsplit_once('}').map_or(rest, |r| r.0);
    let (mut parts, mut depth, mut part) = (Vec::new(), 0, String::new());
    for c in rest.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(std::mem::take(&mut part));
                continue;
            }
            _ => {}
        }
        part.push(c);
    }
    parts.push(part);
    let parts = parts.iter().filter(|p| !p.is_empty());
    parts.flat_map(|p| expand(&format!("{head}{p}"))).collect()
}

/// Every path in the code that starts at the crate, a parent or the module itself.
fn paths(code: &str) -> Vec<String> {
    let mut all = Vec::new();
    let mut rest = code;
    while let Some(at) = ["crate::", "super::", "self::"]
        .iter()
        .filter_map(|start| rest.find(start))
        .min()
    {
        let before = rest[..at].chars().next_back().unwrap_or(' ');
        let from = &rest[at..];
        // A tree ends with its statement, a path in the middle of code where the path ends.
        let is_use = rest[..at].trim_end().ends_with("use");
        let end = if is_use {
            from.find(';').unwrap_or(from.len())
        } else {
            let ends = |c: char| !(c.is_alphanumeric() || c == '_' || c == ':');
            from.find(ends).unwrap_or(from.len())
        };
        // An indented `use super` stands in a module within the file, whose parent is the file.
        let line = rest[..at].rsplit('\n').next().unwrap_or_default();
        let is_inner = is_use && line.starts_with(' ') && from.starts_with("super");
        if !(is_inner || before.is_alphanumeric() || before == '_' || before == ':') {
            let tree: String = from[..end].split_whitespace().collect();
            all.extend(expand(&tree));
        }
        rest = &rest[at + end.max(1)..];
    }
    all
}

/// The file that a path in `module` leads to.
fn resolve(module: &[String], path: &str, files: &BTreeMap<Module, String>) -> Option<Module> {
    let mut at = module.to_vec();
    let mut segments = path.split("::").peekable();
    match segments.next()? {
        "crate" => at.clear(),
        "super" => drop(at.pop()),
        _ => {}
    }
    while segments.peek() == Some(&"super") {
        segments.next();
        at.pop();
    }
    for segment in segments {
        at.push(segment.to_owned());
        if !files.contains_key(&at) {
            at.pop();
            break;
        }
    }
    files.contains_key(&at).then_some(at)
}

/// Whether one is the other's parent, at any distance.
fn related(a: &[String], b: &[String]) -> bool {
    a.starts_with(b) || b.starts_with(a)
}

type Graph = BTreeMap<String, BTreeSet<String>>;

/// A circle of a graph, if it has one: its members.
fn circle(graph: &Graph) -> Option<Vec<String>> {
    let reach = |from: &String| {
        let (mut seen, mut pending) = (BTreeSet::new(), vec![from]);
        while let Some(node) = pending.pop() {
            for next in graph.get(node).into_iter().flatten() {
                if seen.insert(next) {
                    pending.push(next);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&String, _> = graph.keys().map(|n| (n, reach(n))).collect();
    let first = reached.iter().find(|(n, seen)| seen.contains(*n))?;
    let back = |n: &&&String| reached.get(**n).is_some_and(|s| s.contains(first.0));
    Some(first.1.iter().filter(back).map(|n| (*n).clone()).collect())
}

fn circles(name: &str) -> Vec<String> {
    let files = modules(&root().join(name).join("src"));
    let (mut between_files, mut between_folders) = (Graph::new(), Graph::new());
    for (module, code) in &files {
        for path in paths(code) {
            let Some(other) = resolve(module, &path, &files) else {
                continue;
            };
            if !related(module, &other) {
                let edges = between_files.entry(module.join("::")).or_default();
                edges.insert(other.join("::"));
            }
            if let (Some(a), Some(b)) = (module.first(), other.first())
                && a != b
            {
                between_folders
                    .entry(a.clone())
                    .or_default()
                    .insert(b.clone());
            }
        }
    }
    let told = |graph: &Graph, what: &str| {
        circle(graph).map(|c| format!("{name}: {what}: {}", c.join(", ")))
    };
    let files = told(&between_files, "files");
    files
        .into_iter()
        .chain(told(&between_folders, "folders"))
        .collect()
}

#[test]
fn files_and_folders_of_a_crate_form_no_circle() {
    let crates = CRATES
        .iter()
        .filter(|c| root().join(c).join("src").exists());
    let found: Vec<String> = crates.flat_map(|c| circles(c)).collect();
    assert!(found.is_empty(), "circles:\n  {}", found.join("\n  "));
}

#[test]
fn circles_are_found() {
    assert_eq!(expand("a::{b,c::{d,e}}"), ["a::b", "a::c::d", "a::c::e"]);
    let text = "use super::x::{Y, z::W};\nfn f() { crate::q::r(1); my_crate::no(); }";
    assert_eq!(
        paths(text),
        ["super::x::Y", "super::x::z::W", "crate::q::r"]
    );
    let edge = |a: &str, b: &str| (a.to_owned(), BTreeSet::from([b.to_owned()]));
    let round = Graph::from([edge("a", "b"), edge("b", "c"), edge("c", "b")]);
    assert_eq!(circle(&round).unwrap(), ["b", "c"]);
    assert!(circle(&Graph::from([edge("a", "b"), edge("b", "c")])).is_none());
}
