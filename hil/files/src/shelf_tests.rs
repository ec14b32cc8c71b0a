//! Tests of `shelf.rs`.

use super::*;

#[test]
fn everything_built_in_has_a_sentence() {
    for kind in FileKind::ALL {
        let all = built_in(kind);
        assert_eq!(all.len(), kind.names().len());
        for one in all {
            assert!(!one.description.is_empty(), "{} {}", kind.name(), one.name);
        }
    }
    let laws = illusions();
    assert!(laws.iter().any(|law| law.name == "balanced"), "{laws:?}");
    let core = palpate_core::illusion::IllusionModel::Nearest.name();
    assert!(laws.iter().any(|law| law.name == core));
}

#[test]
fn a_folder_lists_its_settings_files_alone() {
    let folder = std::env::temp_dir().join(format!("palpate-shelf-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let heading = "name = \"a\"\ndescription = \"mine\"\n";
    for (name, text) in [
        ("b.toml", format!("{heading}drive.current_ma = 900\n")),
        ("a.toml", format!("{heading}length_s = 2\n")),
        ("Cargo.toml", "[package]\nname = \"a\"\n".to_owned()),
        ("broken.toml", "name = [".to_owned()),
        ("notes.txt", format!("{heading}length_s = 2\n")),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    std::fs::create_dir_all(folder.join("more")).unwrap();
    std::fs::copy(folder.join("a.toml"), folder.join("more/c.toml")).unwrap();
    let found = |depth| -> Vec<(&str, String)> {
        let name = |l: Listed| {
            l.file
                .unwrap()
                .strip_prefix(&folder)
                .unwrap()
                .display()
                .to_string()
        };
        let all = of_folder(&folder, depth).into_iter();
        all.map(|l| (l.kind, name(l))).collect()
    };
    let (a, b) = (
        ("scene", "a.toml".to_owned()),
        ("bench", "b.toml".to_owned()),
    );
    let below = ("scene", "more/c.toml".to_owned());
    assert_eq!(found(0), [a.clone(), b.clone()]);
    assert_eq!(found(1), [a, b, below]);
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(of_folder(Path::new("/no/such/folder"), 1), []);
}
