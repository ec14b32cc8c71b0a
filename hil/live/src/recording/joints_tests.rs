//! Tests of `joints.rs`.

use super::*;

fn read(name: &str, text: &str) -> Result<Vec<Joint>, FileError> {
    let path = std::env::temp_dir().join(format!("palpate-{}-{name}.csv", std::process::id()));
    std::fs::write(&path, text).unwrap();
    let joints = read_joints(std::slice::from_ref(&path), &Timing::default());
    std::fs::remove_file(&path).unwrap();
    joints
}

#[test]
fn joints_stand_beside_taxels() {
    let text = "time_us,txl1_z,joint_mcp,joint_pip\n1000,7,11,0\n501000,8,20,1\n";
    let [mcp, pip] = read("beside", text).unwrap().try_into().unwrap();
    assert_eq!((&*mcp.name, &*pip.name), ("mcp", "pip"));
    assert_eq!(
        format!("{:?}", mcp.points_s_deg),
        "[[0.0, 11.0], [0.5, 20.0]]"
    );
    assert!((pip.at(0.25) - 0.5).abs() < 1e-9 && (mcp.at(9.0) - 20.0).abs() < 1e-9);
    assert!(read("none", "time_us,txl1_z\n0,7\n").unwrap().is_empty());
}

#[test]
fn what_is_no_angle_is_refused() {
    for (name, value, expected) in [
        ("nan", "NaN", "a finite number"),
        ("word", "bent", "a finite number"),
        ("turn", "361", "360 degrees at most"),
        ("huge", "1e300", "a finite number"),
    ] {
        let text = format!("time_us,txl1_z,joint_mcp\n0,7,1\n10,7,{value}\n");
        let error = read(name, &text).unwrap_err().to_string();
        assert!(
            error.contains(expected) && error.contains("joint_mcp"),
            "{error}"
        );
    }
}
