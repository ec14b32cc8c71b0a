//! Tests of frames in blocks of lines and in files of their own.

use std::path::PathBuf;

use super::super::{Columns, Rows, Take, Timing};
use super::*;

/// A folder that goes with the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("palpate-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).unwrap();
    }
}

/// Times and values of all rows, and the notes.
type Read = (Vec<u64>, Vec<Vec<u16>>, String);

fn read(path: &Path, taxels: usize, rate_hz: Option<f64>) -> Result<Read, FileError> {
    let columns = Columns {
        taxels,
        axes: 1,
        layout: "mat".into(),
    };
    let timing = Timing {
        rate_hz,
        ..Timing::default()
    };
    let mut rows = Rows::open(path, Take::Taxels(&columns), Some(&timing))?;
    let (mut times, mut all, mut row) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(at) = rows.advance(&mut row)? {
        times.push(at.time_us);
        all.push(row.clone());
    }
    Ok((times, all, rows.notes().join("\n")))
}

const MOVIE: &str = "DATA_TYPE MOVIE\nVERSION I-Scan 7.60\nROWS 2\nCOLS 3\nSECONDS_PER_FRAME 0.025\nUNITS Raw\n\
                     START_FRAME 1\nEND_FRAME 2\nASCII_DATA @@\n\nFrame 1\n1,2,B\n4,5,6\n\nFrame 2\n7,8,B\n10,11,12\n\n@@\n";

#[test]
fn tekscan_movies_have_times_and_cells_without_a_sensor() {
    let folder = Folder::new("tekscan");
    for text in [MOVIE.to_owned(), MOVIE.replace('\n', "\r\n")] {
        let path = folder.write("movie.asf", &text);
        let (times, rows, notes) = read(&path, 5, None).unwrap();
        assert_eq!(times, [0, 25_000]);
        assert_eq!(rows, [[1, 2, 4, 5, 6], [7, 8, 10, 11, 12]]);
        assert!(notes.contains("0.025 s from frame to frame"), "{notes}");
    }
}

#[test]
fn matrices_stand_between_blank_lines_remarks_and_numbers_of_frames() {
    let folder = Folder::new("matrices");
    for text in [
        "1 2\n3 4\n5 6\n\n7 8\n9 10\n11 12\n",
        "# Array shape: (2, 3, 2)\n1.0 2.0\n3.0 4.0\n5.0 6.0\n# New slice\n7.0 8.0\n9.0 10.0\n11.0 12.0\n# New slice\n",
        "Frame 1,\n1,2,\n3,4,\n5,6,\nFrame 2,\n7,8,\n9,10,\n11,12,\n",
        "1;2\n3;4\n5;6\n\n\n7;8\n9;10\n11;12",
    ] {
        let path = folder.write("frames.txt", text);
        let (times, rows, notes) = read(&path, 6, Some(50.0)).unwrap();
        assert_eq!(times, [0, 20_000]);
        let expected = [[1, 2, 3, 4, 5, 6], [7, 8, 9, 10, 11, 12]];
        assert_eq!(rows, expected, "{text}");
        assert!(notes.contains("its 3 lines of 2 numbers"), "{notes}");
    }
}

#[test]
fn tables_with_blank_lines_stay_tables() {
    let folder = Folder::new("tables");
    let path = folder.write("rows.txt", "1 2\n3 4\n\n5 6\n7 8\n");
    let (_, rows, _) = read(&path, 2, Some(50.0)).unwrap();
    assert_eq!(rows, [[1, 2], [3, 4], [5, 6], [7, 8]]);
}

#[test]
fn files_of_a_folder_are_frames_in_the_order_of_their_numbers() {
    let folder = Folder::new("folder");
    for frame in [10, 2, 1] {
        folder.write(
            &format!("frame_{frame}.csv"),
            &format!("{frame},0\n0,{frame}\n"),
        );
    }
    let (times, rows, notes) = read(&folder.0, 4, Some(100.0)).unwrap();
    assert_eq!(times, [0, 10_000, 20_000]);
    assert_eq!(rows, [[1, 0, 0, 1], [2, 0, 0, 2], [10, 0, 0, 10]]);
    assert!(notes.contains("each of 3 files"), "{notes}");
}

#[test]
fn broken_frames_are_named_by_their_lines() {
    let folder = Folder::new("broken");
    for (text, expected) in [
        (
            MOVIE.replace("7,8,B\n", ""),
            "movie.asf:17: expected 2 lines of a frame, found 1",
        ),
        (
            MOVIE.replace("7,8", "7"),
            "movie.asf:16: expected 3 numbers as in the first line, found 2",
        ),
        (
            MOVIE.replace("7,8", "7,eight"),
            "movie.asf:16: column 2: expected a number, found `eight`",
        ),
        (
            MOVIE.replace("10,11,12\n\n@@\n", ""),
            "movie.asf: expected 2 lines of a frame, found 1",
        ),
    ] {
        let path = folder.write("movie.asf", &text);
        let error = read(&path, 5, None).unwrap_err().to_string();
        assert!(error.ends_with(expected), "{error}");
    }
    let empty = folder.0.join("empty");
    std::fs::create_dir_all(&empty).unwrap();
    let error = read(&empty, 5, None).unwrap_err().to_string();
    assert!(error.contains("a file for each frame"), "{error}");
}
