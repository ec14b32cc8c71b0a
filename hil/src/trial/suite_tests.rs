//! Folders are known by what their files say.

use super::*;
use std::fs;

#[test]
fn a_folder_gives_its_scenes_and_benches_in_order_and_skips_what_is_none() {
    let folder = std::env::temp_dir().join(format!("palpate-suite-{}", std::process::id()));
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    let scene = |name| palpate_fixtures::scene(name).unwrap();
    write("b/two.toml", scene("sphere-circle"));
    write("a.toml", scene("sphere-along"));
    write("target/skipped.toml", scene("idle"));
    write(".hidden/skipped.toml", scene("idle"));
    write(
        "bench.toml",
        "name = \"mine\"\ndescription = \"mine\"\ndrive.current_ma = 900\n",
    );
    write("quarantine.toml", "");
    write("notes.txt", "name = 1");
    std::os::unix::fs::symlink(&folder, folder.join("b/circle")).unwrap();
    let target = folder.display().to_string();
    let suite = Suite::collect(std::slice::from_ref(&target), None).unwrap();
    let names: Vec<&str> = suite
        .members
        .iter()
        .map(|m| m.scene.value.name.as_str())
        .collect();
    assert_eq!(names, ["sphere-along", "sphere-circle"]);
    assert_eq!(suite.benches, [folder.join("bench.toml")]);
    assert_eq!(suite.quarantine, Some(folder.join("quarantine.toml")));
    let some = Suite::collect(std::slice::from_ref(&target), Some("circle")).unwrap();
    assert_eq!(some.members.len(), 1);
    write("c.toml", "lenght = \n");
    fs::create_dir_all(folder.join("goldens")).unwrap();
    let suite = Suite::collect(&[target], None).unwrap();
    assert_eq!(suite.members.len(), 2, "one that is wrong stops no other");
    let [(path, why)] = suite.broken.as_slice() else {
        panic!("{:?}", suite.broken)
    };
    assert!(path.ends_with("c.toml") && why.contains("c.toml"), "{why}");
    assert_eq!(suite.goldens, [folder.join("goldens")]);
    assert_eq!(suite.scenes.len(), 3);
    assert!(suite.whole);
    let gone = Suite::collect(&["no/such/folder".to_owned()], None);
    let gone = gone.unwrap_err().to_string();
    assert!(gone.contains("no such file or folder"), "{gone}");
    fs::remove_dir_all(&folder).unwrap();
}
