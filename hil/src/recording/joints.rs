//! Joint angles beside taxels: the columns `joint_NAME` of recorded CSV, degrees.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use palpate_files::{
    FileError, Format, JOINT, Joint, MOST_DEG, Rows, Take, Timing, format_of, is_stream, open,
};

/// Most angles that are held: ten joints for an hour at 28 Hz.
const MOST: usize = 1 << 20;
/// A header is looked at so far: a million taxels have one of 40 MB.
const MOST_HEADER: u64 = 64 << 20;

/// The joints that recordings carry, each from its own first row on; none where no file has any.
///
/// # Errors
/// A row that is none, an angle beyond a turn, a joint in two files, more angles than are held.
pub fn read_joints(paths: &[PathBuf], timing: &Timing) -> Result<Vec<Joint>, FileError> {
    let mut joints: Vec<Joint> = Vec::new();
    for path in paths {
        if !has_joints(path) {
            continue;
        }
        for joint in of_file(path, timing)? {
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

/// Whether a file that can be read twice is CSV with such a column.
fn has_joints(path: &Path) -> bool {
    if is_stream(path) || !matches!(format_of(path), None | Some(Format::Csv)) {
        return false;
    }
    let Ok(file) = open(path, "a recording") else {
        return false; // reading it will say why
    };
    let mut first = Vec::new();
    let read = BufReader::new(file.take(MOST_HEADER)).read_until(b'\n', &mut first);
    let first = String::from_utf8_lossy(&first);
    read.is_ok() && first.split(',').any(|name| name.trim().starts_with(JOINT))
}

fn of_file(path: &Path, timing: &Timing) -> Result<Vec<Joint>, FileError> {
    let take = Take::Prefixed {
        prefix: JOINT,
        without: &[],
    };
    let mut rows = Rows::open(path, take, Some(timing))?;
    let named = rows.names().map(|name| Joint {
        name: name.strip_prefix(JOINT).unwrap_or(name).to_owned(),
        points_s_deg: Vec::new(),
    });
    let mut joints: Vec<Joint> = named.collect();
    let (mut row, mut first): (Vec<f32>, _) = (Vec::new(), None);
    while let Some(at) = rows.advance(&mut row)? {
        if rows.count() * joints.len() > MOST {
            return Err(rows.too_long(at.line));
        }
        let t_s = (at.time_us - *first.get_or_insert(at.time_us)) as f64 * 1e-6;
        for (joint, deg) in joints.iter_mut().zip(&row) {
            let deg = f64::from(*deg);
            if deg.abs() > MOST_DEG {
                return Err(FileError {
                    path: path.display().to_string(),
                    line: Some(at.line),
                    key: Some(format!("column {JOINT}{}", joint.name)),
                    expected: format!("an angle of {MOST_DEG} degrees at most, either way"),
                    found: deg.to_string(),
                });
            }
            // Of two rows at one time the later one counts.
            match joint.points_s_deg.last_mut().filter(|[t, _]| *t >= t_s) {
                Some(last) => last[1] = deg,
                None => joint.points_s_deg.push([t_s, deg]),
            }
        }
    }
    Ok(joints)
}

#[cfg(test)]
#[path = "joints_tests.rs"]
mod tests;
