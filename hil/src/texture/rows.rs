//! Raw rows from CSV: any number of columns, any numbers that are finite.

use std::path::Path;

use palpate_files::FileError;

/// A recording: as many values a row as the model has features.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    features: usize,
    values: Vec<f32>,
    lines: Vec<u64>,
}

/// Columns that say when, not what.
const TIMES: [&str; 3] = ["time_us", "timestamp", "time"];

/// Taxel, from 0, and axis of a column that is called `txl1_x`.
pub(crate) fn taxel(column: &str) -> Option<(usize, usize)> {
    let (taxel, axis) = column.strip_prefix("txl")?.split_once('_')?;
    let taxel = taxel.parse::<usize>().ok()?.checked_sub(1)?;
    Some((taxel, ["x", "y", "z"].iter().position(|a| *a == axis)?))
}

impl Rows {
    /// Reads a file. `names` are the columns to take; where it is empty, or the file has no header, all columns
    /// but times are taken, and there must be `features` of them.
    ///
    /// # Errors
    /// A file that cannot be read, a column that is missing, a value that is no finite number: with line and column.
    pub fn read(path: &Path, features: usize, names: &[String]) -> Result<Self, FileError> {
        let label = path.display().to_string();
        let file = std::fs::File::open(path)
            .map_err(|e| FileError::whole(&label, "a readable file", e.to_string()))?;
        Self::parse(&label, file, features, names)
    }

    fn parse(
        label: &str,
        input: impl std::io::Read,
        features: usize,
        names: &[String],
    ) -> Result<Self, FileError> {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(input);
        let mut record = csv::StringRecord::new();
        let mut taken: Option<Vec<usize>> = None;
        let mut rows = Self {
            features,
            values: Vec::new(),
            lines: Vec::new(),
        };
        loop {
            let more = reader
                .read_record(&mut record)
                .map_err(|e| FileError::whole(label, "readable CSV", e.to_string()))?;
            if !more {
                break;
            }
            let line = record.position().map_or(1, csv::Position::line);
            let wrong = |column: Option<usize>, expected: String, found: &str| FileError {
                line: usize::try_from(line).ok(),
                key: column.map(|c| format!("column {}", c + 1)),
                ..FileError::whole(label, expected, found)
            };
            let columns = match &taken {
                Some(columns) => columns,
                None => {
                    let header = record.iter().any(|field| field.parse::<f32>().is_err());
                    let columns = columns(&record, header, features, names)
                        .map_err(|(expected, found)| wrong(None, expected, &found))?;
                    let columns = taken.insert(columns);
                    if header {
                        continue;
                    }
                    columns
                }
            };
            for &column in columns {
                let field = record.get(column).unwrap_or("nothing");
                match field.parse::<f32>() {
                    Ok(value) if value.is_finite() => rows.values.push(value),
                    _ => return Err(wrong(Some(column), "a finite number".into(), field)),
                }
            }
            rows.lines.push(line);
        }
        if rows.lines.is_empty() {
            return Err(FileError::whole(label, "at least one row", "none"));
        }
        Ok(rows)
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.lines.len()
    }

    /// The rows, first to last.
    pub fn iter(&self) -> impl Iterator<Item = &[f32]> {
        self.values.chunks_exact(self.features)
    }

    /// The line of the file that row `index` stands in; 0 beyond the last.
    pub fn line(&self, index: usize) -> u64 {
        self.lines.get(index).copied().unwrap_or(0)
    }
}

/// The columns to take; or what was expected and what was found.
fn columns(
    first: &csv::StringRecord,
    header: bool,
    features: usize,
    names: &[String],
) -> Result<Vec<usize>, (String, String)> {
    let named: Vec<_> = names
        .iter()
        .map(|name| first.iter().position(|field| field == name))
        .collect();
    if header && !named.is_empty() && named.iter().any(Option::is_some) {
        let missing = named.iter().zip(names).find(|(place, _)| place.is_none());
        return match missing {
            Some((_, name)) => Err((format!("a column {name}"), "none of that name".into())),
            None => Ok(named.into_iter().flatten().collect()),
        };
    }
    let taken: Vec<usize> = (0..first.len())
        .filter(|&c| !(header && TIMES.contains(&&first[c])))
        .collect();
    if taken.len() == features {
        return Ok(taken);
    }
    let expected = if names.is_empty() {
        format!("{features} columns beside times")
    } else {
        format!(
            "the model's columns ({}, ..), or {features} beside times",
            names[0]
        )
    };
    Err((expected, taken.len().to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, features: usize, names: &[&str]) -> Result<Rows, String> {
        let names: Vec<_> = names.iter().map(|n| (*n).to_owned()).collect();
        Rows::parse("f.csv", text.as_bytes(), features, &names).map_err(|e| e.to_string())
    }

    #[test]
    fn columns_are_taken_by_name_or_by_number() {
        let named = read("time_us,c,b,a\n5,1,2,3\n6,4,5,6.5\n", 2, &["a", "b"]).unwrap();
        assert_eq!(named.iter().collect::<Vec<_>>(), [[3.0, 2.0], [6.5, 5.0]]);
        assert_eq!((named.count(), named.line(1), named.line(2)), (2, 3, 0));
        let counted = read("time_us, x, y\n5, 1, 2\n", 2, &["a", "b"]).unwrap();
        assert_eq!(counted.iter().collect::<Vec<_>>(), [[1.0, 2.0]]);
        let bare = read("1,2\n3,4\n", 2, &["a", "b"]).unwrap();
        assert_eq!(bare.iter().count(), 2);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line_and_column() {
        for (text, message) in [
            (
                "a,b\n1,2\n3,nan\n",
                "f.csv:3: column 2: expected a finite number, found nan",
            ),
            (
                "a,b\n1,2\n3\n",
                "f.csv:3: column 2: expected a finite number, found nothing",
            ),
            (
                "a,b\n1,1e99\n",
                "f.csv:2: column 2: expected a finite number, found 1e99",
            ),
            (
                "a,c\n1,2\n",
                "f.csv:1: expected a column b, found none of that name",
            ),
            (
                "p,q,r\n1,2,3\n",
                "f.csv:1: expected the model's columns (a, ..), or 2 beside times, found 3",
            ),
            ("a,b\n", "f.csv: expected at least one row, found none"),
            ("", "f.csv: expected at least one row, found none"),
        ] {
            assert_eq!(read(text, 2, &["a", "b"]).unwrap_err(), message);
        }
    }
}
