//! Tests of `hardware.rs`.

use super::*;

/// A tree of sysfs with these folders; gone with the value.
struct Tree(PathBuf);

impl Tree {
    fn new(name: &str, folders: &[&str]) -> Self {
        let root = std::env::temp_dir().join(format!("palpate-sys-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&root);
        for folder in folders {
            fs::create_dir_all(root.join(folder)).unwrap();
        }
        Self(root)
    }

    /// What lasts of a folder's path below the root.
    fn lasting(&self, folder: &str) -> String {
        let whole = lasting(&self.0.join(folder)).unwrap();
        let root = lasting(&self.0).unwrap();
        whole[root.len() + 1..].to_owned()
    }
}

impl Drop for Tree {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const PORT: &str = "pci0000:00/0000:00:14.0/usb1/1-2.3/1-2.3:1.2";

#[test]
fn an_adapter_that_is_plugged_in_again_is_the_same() {
    let first = format!("{PORT}/0003:04D8:00DD.0007/i2c-5");
    let before = Tree::new("before", &[&first]).lasting(&first);
    assert_eq!(
        before,
        "pci0000:00/0000:00:14.0/usb#0/#-2.3/#-2.3:1.2/0003:04D8:00DD.#0/i2c-#0"
    );
    // At another start the USB bus is another one too.
    let again = "pci0000:00/0000:00:14.0/usb3/3-2.3/3-2.3:1.2/0003:04D8:00DD.0019/i2c-12";
    assert_eq!(Tree::new("after", &[again]).lasting(again), before);
    // Another port is another adapter.
    let other = "pci0000:00/0000:00:14.0/usb1/1-2.4/1-2.4:1.2/0003:04D8:00DD.0007/i2c-5";
    assert_ne!(Tree::new("other", &[other]).lasting(other), before);
}

#[test]
fn adapters_of_one_parent_are_told_apart_whatever_their_numbers() {
    let at = |n: u32| format!("platform/mux/i2c-{n}");
    let [first, second] = [at(9), at(11)];
    let tree = Tree::new("siblings", &[&first, &second, "platform/mux/i2c-dev"]);
    assert_eq!(tree.lasting(&first), "platform/mux/i2c-#0");
    assert_eq!(tree.lasting(&second), "platform/mux/i2c-#1");
}

#[test]
fn a_virtual_adapter_is_the_one_that_it_is() {
    let path = "/sys/devices/virtual/misc/uhid/0003:04D8:00DD.0002/i2c-1";
    assert_eq!(lasting(Path::new(path)).unwrap(), path);
}

#[test]
fn what_sysfs_does_not_know_is_refused_with_a_sentence() {
    for node in ["/dev/palpate-none", "/proc/version"] {
        let refused = Hardware::adapter(Path::new(node)).unwrap_err().to_string();
        assert!(
            refused.starts_with(node) && refused.contains("/sys has behind it"),
            "{refused}"
        );
    }
}

#[test]
fn a_unit_is_its_key_at_any_address() {
    let unit = Hardware::unit("127.0.0.1:4817", &[9; 32]);
    assert!(unit.is(&Hardware::unit("[::ffff:127.0.0.1]:4817", &[9; 32])));
    assert!(!unit.is(&Hardware::unit("127.0.0.1:4817", &[8; 32])));
    assert_eq!(unit.to_string(), "unit 127.0.0.1:4817");
    assert!(!unit.file().contains("0909"), "a name tells no key");
}
