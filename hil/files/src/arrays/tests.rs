//! Tests of arrays in files.

use super::*;

fn npy(descr: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn text(stored: Vec<Stored>, count: usize, rest_rows: usize) -> Result<String, String> {
    let mut array = chosen("f.npy".into(), stored, count, rest_rows).map_err(|e| e.to_string())?;
    let mut text = Vec::new();
    while array.add(&mut text).map_err(|e| e.to_string())? {}
    Ok(String::from_utf8(text).unwrap())
}

fn read(bytes: &[u8], count: usize) -> Result<String, String> {
    let stored = numpy::array(bytes).map_err(|(e, f)| format!("{e}: {f}"))?;
    text(vec![stored], count, 0)
}

#[test]
fn every_type_of_number_and_both_orders() {
    let of = |descr: &str, data: &[u8]| read(&npy(descr, "False", "(2, 2)", data), 2).unwrap();
    let same = "1,2\n300,4\n";
    let all = [1.0, 2.0, 300.0, 4.0_f64];
    let each =
        |bytes: &dyn Fn(f64) -> Vec<u8>| all.iter().flat_map(|v| bytes(*v)).collect::<Vec<u8>>();
    assert_eq!(of("<f8", &each(&|v| v.to_le_bytes().to_vec())), same);
    assert_eq!(of(">f8", &each(&|v| v.to_be_bytes().to_vec())), same);
    assert_eq!(
        of("<f4", &each(&|v| (v as f32).to_le_bytes().to_vec())),
        same
    );
    assert_eq!(
        of("<i2", &each(&|v| (v as i16).to_le_bytes().to_vec())),
        same
    );
    assert_eq!(
        of(">u4", &each(&|v| (v as u32).to_be_bytes().to_vec())),
        same
    );
    assert_eq!(
        of("<i8", &each(&|v| (v as i64).to_le_bytes().to_vec())),
        same
    );
    assert_eq!(of("|u1", &[1, 2, 3, 255]), "1,2\n3,255\n");
    assert_eq!(of("|i1", &[1, 2, 3, 255]), "1,2\n3,-1\n");
    // 1, 2, 300 and 4 in half precision.
    assert_eq!(of("<f2", &[0, 0x3c, 0, 0x40, 0xb0, 0x5c, 0, 0x44]), same);
    let fortran = read(&npy("|u1", "True", "(2, 2)", &[1, 3, 2, 4]), 2);
    assert_eq!(fortran.unwrap(), "1,2\n3,4\n");
}

#[test]
fn dimensions_are_frames_taxels_and_axes() {
    let data: Vec<u8> = (0..12).collect();
    let of = |shape: &str, count| read(&npy("|u1", "False", shape, &data), count);
    assert_eq!(of("(2, 2, 3)", 6).unwrap(), "0,1,2,3,4,5\n6,7,8,9,10,11\n");
    // Axes before taxels become taxel by taxel.
    assert_eq!(of("(2, 3, 2)", 6).unwrap(), "0,2,4,1,3,5\n6,8,10,7,9,11\n");
    assert_eq!(of("(6, 2)", 6).unwrap(), "0,2,4,6,8,10\n1,3,5,7,9,11\n");
    for (shape, said) in [
        ("(5, 2)", "[5, 2]"),
        ("(12,)", "[12]"),
        ("(3, 4)", "[3, 4]"),
    ] {
        let error = of(shape, 9).unwrap_err();
        assert!(
            error.starts_with("f.npy: expected an array of frames x 9"),
            "{error}"
        );
        assert!(error.contains(said), "{error}");
    }
}

fn floats(values: &[f64], frames: usize) -> Vec<Stored> {
    vec![Stored {
        name: String::new(),
        shape: vec![frames, values.len() / frames],
        is_fortran: false,
        values: values.to_vec(),
    }]
}

/// `numpy.save` writes raw counts as floats as well: they are no compensated values.
#[test]
fn readings_are_compensated_where_columns_rest_at_zero() {
    let raw = text(floats(&[33000.0, 32999.0, 33001.0, 32998.0], 2), 2, 3);
    assert_eq!(raw.unwrap(), "33000,32999\n33001,32998\n");
    let compensated = text(floats(&[0.0, 0.0, 50.4, 0.0], 2), 2, 1);
    assert_eq!(compensated.unwrap(), "0,0\n0,0\n50,0\n");
    // Values in another unit stay what they are: reading them asks for a gain.
    let newtons = text(floats(&[0.0, 0.1, 1.5, 0.2], 2), 2, 0);
    assert_eq!(newtons.unwrap(), "0,0.1\n1.5,0.2\n");
}

#[test]
fn times_of_an_archive_stand_beside_its_readings() {
    let mut stored = floats(&[1.0, 2.0, 3.0, 4.0], 2);
    stored[0].name = "raw".into();
    stored.push(Stored {
        name: "t".into(),
        shape: vec![2],
        is_fortran: false,
        values: vec![0.5, 0.51],
    });
    let table = text(stored, 2, 0).unwrap();
    assert_eq!(table, "time,raw_0,raw_1\n0.5,1,2\n0.51,3,4\n");
    let mut two = floats(&[1.0, 2.0], 1);
    two.extend(floats(&[1.0, 2.0], 1));
    assert!(text(two, 2, 0).unwrap_err().contains("expected one array"));
}

fn archive(name: &str, data: &[u8]) -> Vec<u8> {
    let number = |n: usize| (n as u32).to_le_bytes();
    let short = |n: usize| (n as u16).to_le_bytes();
    let mut bytes = b"PK\x03\x04".to_vec();
    bytes.extend([0; 22]);
    bytes.extend([short(name.len()), short(0)].concat());
    bytes.extend(name.as_bytes());
    bytes.extend(data);
    let directory = bytes.len();
    bytes.extend(b"PK\x01\x02");
    bytes.extend([0; 16]);
    bytes.extend([number(data.len()), number(data.len())].concat());
    bytes.extend(short(name.len()));
    bytes.extend([0; 16]);
    bytes.extend(name.as_bytes());
    let length = bytes.len() - directory;
    bytes.extend(b"PK\x05\x06");
    bytes.extend([0; 4]);
    bytes.extend([short(1), short(1)].concat());
    bytes.extend([number(length), number(directory)].concat());
    bytes.extend([0; 2]);
    bytes
}

#[test]
fn an_archive_holds_arrays_and_other_things() {
    let bytes = archive("raw.npy", &npy("|u1", "False", "(1, 2)", &[1, 2]));
    let stored = numpy::archive(&bytes).unwrap();
    assert_eq!(
        (stored[0].name.as_str(), &stored[0].shape),
        ("raw", &vec![1, 2])
    );
    assert!(
        numpy::archive(&archive("raw.txt", b"hello"))
            .unwrap()
            .is_empty()
    );
    for end in 0..bytes.len() {
        // A part of a file is an error or less, and never a panic.
        let _ = numpy::archive(&bytes[..end]);
    }
}

fn matlab(name: &str, values: &[f64]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0".to_vec();
    bytes.resize(124, b' ');
    bytes.extend(b"\x00\x01IM");
    let element = |kind: u32, data: &[u8]| {
        let mut all = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        all.extend(data);
        all.resize(all.len().next_multiple_of(8), 0);
        all
    };
    let sizes = [2_i32.to_le_bytes(), (values.len() as i32 / 2).to_le_bytes()].concat();
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let matrix = [
        element(6, &[6, 0, 0, 0, 0, 0, 0, 0]),
        element(5, &sizes),
        element(1, name.as_bytes()),
        element(9, &data),
    ];
    bytes.extend(element(14, &matrix.concat()));
    bytes
}

#[test]
fn matlab_holds_columns_one_after_the_other() {
    let bytes = matlab("counts", &[1.0, 3.0, 2.0, 4.0]);
    let stored = matlab::arrays(&bytes).unwrap();
    assert_eq!(stored[0].name, "counts");
    assert_eq!(text(stored, 2, 0).unwrap(), "1,2\n3,4\n");
    for end in 0..bytes.len() {
        let _ = matlab::arrays(&bytes[..end]);
    }
    let big = bytes[..126]
        .iter()
        .chain(b"MI")
        .copied()
        .collect::<Vec<_>>();
    assert!(matlab::arrays(&big).is_err());
}
