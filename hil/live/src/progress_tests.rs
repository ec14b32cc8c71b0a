//! How far a file has been read.

use super::*;
use std::io::{Read, Write};

#[test]
fn the_system_knows_how_far_a_file_was_read() {
    let path = std::env::temp_dir().join(format!("palpate-progress-{}", std::process::id()));
    fs::File::create(&path)
        .unwrap()
        .write_all(&[0; 5000])
        .unwrap();
    let path = fs::canonicalize(path).unwrap();
    assert_eq!(position(&path), None);
    let mut file = fs::File::open(&path).unwrap();
    file.read_exact(&mut [0; 1234]).unwrap();
    assert_eq!(position(&path), Some(1234));
    fs::remove_file(&path).unwrap();
}
