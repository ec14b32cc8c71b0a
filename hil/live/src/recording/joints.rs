//! Joint angles beside taxels, degrees: the columns `joint_NAME` of recorded CSV, the topics `/joints/NAME` of MCAP.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use palpate_files::{
    FileError, Format, JOINT, Joint, MOST_DEG, Rows, Take, Timing, format_of, holds_frames,
    is_stream, open, open_unpacked,
};
use palpate_records::mcap::{McapReader, Unreadable};

use super::pass::zero_of;

/// Most angles that are held: ten joints for an hour at 28 Hz.
const MOST: usize = 1 << 20;
/// Bytes of a header that are looked at: a million taxels have one of 40 MB.
const MOST_HEADER: u64 = 64 << 20;

/// The joints that recordings carry; none where no file has any. Those of CSV begin with the first row of their file.
///
/// # Errors
/// A row that is none, an angle beyond a turn, a joint in two files, more angles than are held.
pub fn read_joints(paths: &[PathBuf], timing: &Timing) -> Result<Vec<Joint>, FileError> {
    let mut joints: Vec<Joint> = Vec::new();
    for path in paths {
        let of_file = match format_of(path) {
            _ if is_stream(path) => Vec::new(),
            Some(Format::Mcap) if holds_frames(path) => of_mcap(path)?,
            None | Some(Format::Csv) if has_joints(path) => of_csv(path, timing)?,
            _ => Vec::new(),
        };
        for joint in of_file {
            if joints.iter().any(|j| j.name == joint.name) {
                let label = path.display().to_string();
                let found = format!("`{JOINT}{}` in two", joint.name);
                return Err(FileError::whole(label, "each joint in one file", found));
            }
            joints.push(joint);
        }
    }
    Ok(joints)
}

/// Tells whether a CSV file has columns of joints.
fn has_joints(path: &Path) -> bool {
    let Ok(file) = open(path, "a recording") else {
        return false; // reading it will say why
    };
    let mut first = Vec::new();
    let read = BufReader::new(file.take(MOST_HEADER)).read_until(b'\n', &mut first);
    let first = String::from_utf8_lossy(&first);
    read.is_ok() && first.split(',').any(|name| name.trim().starts_with(JOINT))
}

/// Joints of a recording of buses, from the same zero as its frames.
fn of_mcap(path: &Path) -> Result<Vec<Joint>, FileError> {
    let label = path.display().to_string();
    let refused = |e: Unreadable| FileError::whole(&label, e.expected, e.found);
    let file = open_unpacked(path, "a recording")?;
    let mut reader = McapReader::new(file).map_err(refused)?;
    let mut first: Option<u64> = None;
    while let Some(frame) = reader.advance().map_err(refused)? {
        let us = frame.at.as_micros();
        first = Some(first.map_or(us, |first| first.min(us)));
    }
    let zero_us = zero_of(first.unwrap_or(0));
    let mut joints = Vec::new();
    for (name, angles) in reader.into_read().map_err(refused)?.joints {
        let mut joint = Joint {
            name,
            points_s_deg: Vec::new(),
            press: None,
        };
        for (t_ns, deg) in angles {
            let t_s = (t_ns / 1000).saturating_sub(zero_us) as f64 * 1e-6;
            add(&mut joint, [t_s, deg]).map_err(|found| {
                let expected = format!("an angle of {MOST_DEG} degrees at most, either way");
                FileError::whole(
                    &label,
                    expected,
                    format!("{found} of joint `{}`", joint.name),
                )
            })?;
        }
        joints.push(joint);
    }
    Ok(joints)
}

/// Adds an angle; of two at one time the later one counts.
///
/// # Errors
/// The angle, where it is beyond a turn.
fn add(joint: &mut Joint, [t_s, deg]: [f64; 2]) -> Result<(), f64> {
    if deg.abs() > MOST_DEG {
        return Err(deg);
    }
    match joint.points_s_deg.last_mut().filter(|[t, _]| *t >= t_s) {
        Some(last) => last[1] = deg,
        None => joint.points_s_deg.push([t_s, deg]),
    }
    Ok(())
}

fn of_csv(path: &Path, timing: &Timing) -> Result<Vec<Joint>, FileError> {
    let take = Take::Prefixed {
        prefix: JOINT,
        without: &[],
    };
    let mut rows = Rows::open(path, take, Some(timing))?;
    let named = rows.names().map(|name| Joint {
        name: name.strip_prefix(JOINT).unwrap_or(name).to_owned(),
        points_s_deg: Vec::new(),
        press: None,
    });
    let mut joints: Vec<Joint> = named.collect();
    let (mut row, mut first): (Vec<f32>, _) = (Vec::new(), None);
    while let Some(at) = rows.advance(&mut row)? {
        if rows.count() * joints.len() > MOST {
            return Err(rows.too_long(at.line));
        }
        let t_s = (at.time_us - *first.get_or_insert(at.time_us)) as f64 * 1e-6;
        for (joint, deg) in joints.iter_mut().zip(&row) {
            add(joint, [t_s, f64::from(*deg)]).map_err(|found| FileError {
                path: path.display().to_string(),
                line: Some(at.line),
                key: Some(format!("column {JOINT}{}", joint.name)),
                expected: format!("an angle of {MOST_DEG} degrees at most, either way"),
                found: found.to_string(),
            })?;
        }
    }
    Ok(joints)
}

#[cfg(test)]
#[path = "joints_tests.rs"]
mod tests;
