//! Figures on the pages: the lines that a page shows of what a command prints, compared with what it prints today.

/// Lines of a command's output that a page shows. `...` alone on a line leaves lines out.
pub struct Shown {
    /// Index of the first of these lines in the page.
    pub first: usize,
    pub lines: Vec<String>,
    /// Blanks before each of them, in a list.
    pub indent: usize,
    /// Lines before and after these may be left out without `...`.
    pub is_part: bool,
}

/// A line with `#` for each number, and one blank for several: the shape that it keeps when its figures change.
fn shape(line: &str) -> String {
    let mut shape = String::new();
    for c in line.chars() {
        let c = match c {
            '0'..='9' | '.' | '-' | '+' => '#',
            c => c,
        };
        if !((c == '#' || c == ' ') && shape.ends_with(c)) {
            shape.push(c);
        }
    }
    shape.replace(" #", "#").replace("# ", "#")
}

/// A line up to the time that the computer took.
fn timeless(line: &str) -> String {
    let timed = [
        " emulated in ",
        " s in ",
        "time per frame",
        " s  path error",
    ];
    let head = timed.iter().find_map(|words| line.split_once(words));
    let head =
        head.map(|(head, _)| head.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.'));
    head.unwrap_or(line).trim_end().to_owned()
}

impl Shown {
    /// Today's lines: each stretch between two `...` is found in the output, in its order, by `key`.
    fn found(&self, output: &[String], key: fn(&str) -> String) -> Option<Vec<String>> {
        let keys: Vec<String> = output.iter().map(|line| key(line)).collect();
        let (mut lines, mut from) = (Vec::new(), 0);
        for (number, stretch) in self.lines.split(|line| line == "...").enumerate() {
            if number > 0 {
                lines.push("...".to_owned());
            }
            if stretch.is_empty() {
                continue;
            }
            let wanted: Vec<String> = stretch.iter().map(|line| key(line)).collect();
            let windows = keys.windows(wanted.len()).enumerate().skip(from);
            let at = windows
                .filter(|(at, _)| number > 0 || *at == 0 || self.is_part)
                .find(|(_, window)| *window == wanted.as_slice())
                .map(|(at, _)| at)?;
            from = at + stretch.len();
            lines.extend_from_slice(&output[at..from]);
        }
        let is_open = self.is_part || self.lines.last().is_some_and(|line| line == "...");
        (is_open || from == output.len()).then_some(lines)
    }

    /// Tells whether a command prints what the page shows.
    pub fn is_true(&self, output: &[String]) -> bool {
        self.found(output, timeless).is_some()
    }

    /// Lines that the page would show today; `None` where other words than its figures differ.
    pub fn today(&self, output: &[String]) -> Option<Vec<String>> {
        self.found(output, shape)
    }
}
