//! Tests of `certificates.rs`.

use super::*;

fn wanted(name: &str) -> Member {
    Member {
        name: name.into(),
        publishes: vec![format!("{name}/*/*")],
        feels: Vec::new(),
        watches: false,
        relays: false,
    }
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("palpate-link-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    folder
}

#[test]
fn keys_of_a_lab_are_read_again_and_grow() {
    let lab = folder("lab");
    Lab::make(&lab, &[wanted("r1")], Duration::days(30)).unwrap();
    let authority = fs::read(lab.join(AUTHORITY)).unwrap();
    let access = Lab::make(&lab, &[wanted("r2")], Duration::days(30)).unwrap();
    assert_eq!(access.members.len(), 2);
    assert_eq!(
        fs::read(lab.join(AUTHORITY)).unwrap(),
        authority,
        "the authority stays"
    );
    for name in ["r1", "r2"] {
        let member = Lab::member(&lab.join(name)).unwrap();
        assert_eq!(member.name, name);
        assert_eq!(member.access, access, "every folder has the whole list");
        assert!(!lab.join(name).join(AUTHORITY_KEY).exists());
        use std::os::unix::fs::PermissionsExt as _;
        let mode = fs::metadata(lab.join(name).join(KEY))
            .unwrap()
            .permissions()
            .mode();
        assert_eq!(mode & 0o077, 0, "a key is its owner's");
    }
    fs::remove_dir_all(&lab).unwrap();
}

#[test]
fn a_key_that_is_made_again_is_its_owner_s_whatever_was_there() {
    use std::io::Read as _;
    use std::os::unix::fs::PermissionsExt as _;
    let lab = folder("again");
    Lab::make(&lab, &[wanted("r1")], Duration::days(30)).unwrap();
    let key = lab.join("r1").join(KEY);
    fs::set_permissions(&key, fs::Permissions::from_mode(0o644)).unwrap();
    let mut open = fs::File::open(&key).unwrap();
    let old = fs::read_to_string(&key).unwrap();
    Lab::make(&lab, &[wanted("r1")], Duration::days(30)).unwrap();
    let mode = fs::metadata(&key).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
    assert_ne!(fs::read_to_string(&key).unwrap(), old);
    // Who has the old file open reads the old key.
    let mut seen = String::new();
    open.read_to_string(&mut seen).unwrap();
    assert_eq!(seen, old);
    fs::remove_dir_all(&lab).unwrap();
}

#[test]
fn expired_and_foreign_certificates_are_told() {
    let (lab, other) = (folder("own"), folder("other"));
    Lab::make(&lab, &[wanted("r1")], Duration::days(-1)).unwrap();
    let expired = Lab::member(&lab.join("r1")).unwrap_err();
    assert!(
        matches!(&expired, LabError::Time { name, .. } if name == "r1"),
        "{expired}"
    );
    Lab::make(&lab, &[wanted("r1")], Duration::days(30)).unwrap();
    Lab::make(&other, &[wanted("r1")], Duration::days(30)).unwrap();
    fs::copy(
        other.join("r1").join(CERTIFICATE),
        lab.join("r1").join(CERTIFICATE),
    )
    .unwrap();
    let foreign = Lab::member(&lab.join("r1")).unwrap_err();
    assert!(matches!(&foreign, LabError::Foreign { .. }), "{foreign}");
    fs::write(lab.join("r1").join(CERTIFICATE), "no certificate").unwrap();
    let none = Lab::member(&lab.join("r1")).unwrap_err();
    assert!(matches!(&none, LabError::Content { .. }), "{none}");
    fs::remove_dir_all(&lab).unwrap();
    fs::remove_dir_all(&other).unwrap();
    let gone = Lab::member(&lab.join("r1")).unwrap_err();
    assert!(matches!(&gone, LabError::File { .. }), "{gone}");
}
