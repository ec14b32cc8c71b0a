//! Columns of a table: those that a recording must hold, and those of a file that are taken.

use super::dialect::Writing;
use super::layout::SensorLayout;
use super::order::{Group, groups, is_computed, listed};
use super::recipe_plan::RecipePlan;
use super::taken::{Chosen, TIMES, Taken, Turns, Wrong, shown};

/// Columns that a recording of taxels must hold: `taxels` times `axes` of them, `txl1_x,txl1_y,txl1_z,...` (`_z`
/// alone for one axis).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns {
    /// Taxels per row.
    pub taxels: usize,
    /// Axes of a taxel, 1 or 3.
    pub axes: u8,
    /// The layout that asks for the columns, for messages.
    pub layout: String,
}

impl Columns {
    /// One module's readings.
    #[must_use]
    pub fn of_module(layout: &SensorLayout, module: usize) -> Option<Self> {
        Some(Self {
            taxels: layout.modules.get(module)?.readings(),
            axes: layout.axes,
            layout: layout.name.clone(),
        })
    }

    /// The whole skin's readings, module after module.
    #[must_use]
    pub fn of_skin(layout: &SensorLayout) -> Self {
        Self {
            taxels: layout.readings(),
            axes: layout.axes,
            layout: layout.name.clone(),
        }
    }

    /// Number of columns.
    #[must_use]
    pub fn count(&self) -> usize {
        self.taxels * usize::from(self.axes)
    }

    /// The name of a column, counted without the time.
    #[must_use]
    pub fn name(&self, index: usize) -> String {
        let axes = usize::from(self.axes);
        let axis = if axes == 1 {
            "z"
        } else {
            ["x", "y", "z"][index % 3]
        };
        format!("txl{}_{axis}", index / axes + 1)
    }

    fn expected(&self) -> String {
        let Self {
            taxels,
            axes,
            layout,
        } = self;
        format!(
            "{} taxel columns ({taxels} taxels of {axes} axes in layout `{layout}`)",
            self.count()
        )
    }
}

/// Selections of a table's columns.
#[derive(Clone, Copy, Debug)]
pub enum Take<'a> {
    /// All columns of a recording of taxels, under their own names.
    Taxels(&'a Columns),
    /// A number of columns whose names begin with a prefix, in the order of the numbers in the names; without numbers
    /// in the order of the file.
    Counted(&'a str, usize),
    /// The features of a model by their names. Where it names none, or the file has no header: all columns but
    /// times, of which there must be `count`.
    Features {
        /// The columns' names.
        names: &'a [String],
        /// Number of columns.
        count: usize,
    },
    /// Columns of a recording of taxels as its recipe says.
    Recipe(&'a RecipePlan),
    /// Columns of a header whose names begin with a prefix, without those of some taxels.
    Prefixed {
        /// Beginning of the names.
        prefix: &'a str,
        /// Taxels left out: the part of a name before its first underscore.
        without: &'a [String],
    },
}

/// Beginning of the name of a joint's column.
pub const JOINT: &str = "joint_";

impl Take<'_> {
    /// Number of columns there must be; none where that follows from the file.
    pub(super) fn count(self) -> Option<usize> {
        match self {
            Self::Taxels(columns) => Some(columns.count()),
            Self::Counted(_, count) | Self::Features { count, .. } => Some(count),
            Self::Recipe(_) | Self::Prefixed { .. } => None,
        }
    }

    /// Separator and decimal mark of the text, as far as they are known.
    pub(super) fn writing(self) -> Writing {
        match self {
            Self::Recipe(plan) => plan.writing,
            _ => Writing::default(),
        }
    }

    /// Lines of a frame, where a recipe states them.
    pub(super) fn frame_lines(self) -> Option<usize> {
        match self {
            Self::Recipe(plan) => plan.frame_lines,
            _ => None,
        }
    }

    /// The sensors whose rows take turns.
    pub(super) fn turns(self, first: &[&str], header: bool) -> Result<Option<Turns>, Wrong> {
        match self {
            Self::Recipe(plan) => plan.turns(first, header),
            _ => Ok(None),
        }
    }

    /// Chooses the columns by the fields of the first line, with a remark on the choice; `times` are the columns of
    /// times.
    pub(super) fn choose(
        self,
        first: &[&str],
        header: bool,
        times: &[usize],
    ) -> Result<Chosen, Wrong> {
        match self {
            Self::Taxels(columns) => taxels(first, header, columns, times),
            Self::Recipe(plan) => Ok((plan.columns(first, header, times)?, None)),
            Self::Counted(prefix, count) if header => counted(first, prefix, count),
            _ => Ok((self.in_order(first, header)?, None)),
        }
    }

    fn in_order(self, first: &[&str], header: bool) -> Result<Vec<Taken>, Wrong> {
        let called = |place: usize| {
            let name = if header { first[place] } else { "" };
            Taken::new(place, name.to_owned())
        };
        let beginning = |prefix: &str, wanted: &dyn Fn(&str) -> bool| -> Vec<Taken> {
            let fits = |c: &usize| header && first[*c].starts_with(prefix) && wanted(first[*c]);
            (0..first.len()).filter(fits).map(called).collect()
        };
        match self {
            Self::Taxels(_) | Self::Recipe(_) => Ok(Vec::new()),
            Self::Counted(prefix, count) => {
                let taken = beginning(prefix, &|_| true);
                if taken.len() == count {
                    return Ok(taken);
                }
                let expected = format!("{count} columns {prefix}* (--columns)");
                Err((None, expected, taken.len().to_string()))
            }
            Self::Prefixed { prefix, without } => {
                let wanted = |name: &str| {
                    let taxel = name.split('_').next();
                    !without.iter().any(|t| taxel == Some(t))
                };
                let taken = beginning(prefix, &wanted);
                let missing = || {
                    (
                        None,
                        format!("columns {prefix}*"),
                        "none of that name".into(),
                    )
                };
                (!taken.is_empty()).then_some(taken).ok_or_else(missing)
            }
            Self::Features { names, count } => {
                let place = |name: &String| first.iter().position(|field| field == name);
                if header && names.iter().any(|name| place(name).is_some()) {
                    let missing =
                        |name| (None, format!("a column {name}"), "none of that name".into());
                    let named = |name| place(name).map(called).ok_or_else(|| missing(name));
                    return names.iter().map(named).collect();
                }
                let is_time = |c: usize| header && TIMES.contains(&first[c]);
                let taken: Vec<_> = (0..first.len())
                    .filter(|&c| !is_time(c))
                    .map(called)
                    .collect();
                if taken.len() == count {
                    return Ok(taken);
                }
                let expected = match names {
                    [] => format!("{count} columns beside times"),
                    [name, ..] => {
                        format!("the model's columns ({name}, ..), or {count} beside times")
                    }
                };
                Err((None, expected, taken.len().to_string()))
            }
        }
    }
}

/// The columns of a recording of taxels.
fn taxels(
    first: &[&str],
    header: bool,
    columns: &Columns,
    times: &[usize],
) -> Result<Chosen, Wrong> {
    let wrong = match own(first, columns, times) {
        Ok(taken) => return Ok((taken, None)),
        Err(wrong) => wrong,
    };
    let count = columns.count();
    if header {
        let is_value = |place: &usize| !times.contains(place) && !first[*place].starts_with(JOINT);
        let places: Vec<usize> = (0..first.len()).filter(is_value).collect();
        let found = numbered(first, &places, columns)?;
        return found.ok_or_else(|| alone(first, &places, columns).unwrap_or(wrong));
    }
    let before = first
        .len()
        .checked_sub(count)
        .filter(|before| *before <= MOST_BEFORE);
    let Some(before) = before else {
        return Err((None, columns.expected(), first.len().to_string()));
    };
    let taken = (before..first.len())
        .enumerate()
        .map(|(index, place)| Taken::new(place, columns.name(index)));
    let note = format!(
        "no heading: {} columns are `{}`, `{}` and so on, in the layout's order",
        if before == 0 { "all" } else { "the last" },
        columns.name(0),
        columns.name(1)
    );
    Ok((taken.collect(), Some(note)))
}

/// The error of a file that has one axis of a layout of three.
fn alone(first: &[&str], places: &[usize], columns: &Columns) -> Option<Wrong> {
    let all = groups(places.iter().map(|place| (*place, first[*place])));
    let one = all
        .iter()
        .find(|group| group.places.len() == columns.taxels)?;
    let found = format!("{} of one axis, `{}`", columns.taxels, one.pattern);
    let expected = format!("{}, or a layout of one axis (--layout)", columns.expected());
    (columns.axes == 3).then_some((None, expected, found))
}

/// Columns under the layout's own names in their order, with no others but times and joints.
fn own(first: &[&str], columns: &Columns, times: &[usize]) -> Result<Vec<Taken>, Wrong> {
    let places = (0..first.len()).filter(|place| !times.contains(place));
    let mut taken = Vec::new();
    for (index, place) in places.enumerate() {
        if index == columns.count() {
            break;
        }
        let name = columns.name(index);
        if first[place] != name {
            let key = format!("column {}", place + 1);
            let hint = if index == 0 {
                " (--columns PREFIX and --time COLUMN:UNIT read other headers)"
            } else {
                ""
            };
            return Err((
                Some(key),
                format!("the header `{name}`{hint}"),
                shown(first[place]),
            ));
        }
        taken.push(Taken::new(place, name));
    }
    let joints = first.iter().filter(|name| name.starts_with(JOINT)).count();
    let found = first.len() - times.len() - joints;
    if found != columns.count() {
        return Err((None, columns.expected(), found.to_string()));
    }
    Ok(taken)
}

/// Most columns before the values of a table without a heading: a number and a time.
pub(super) const MOST_BEFORE: usize = 2;

/// Columns in the order of the numbers in their names; none where names have no numbers.
fn numbered(first: &[&str], places: &[usize], columns: &Columns) -> Result<Option<Chosen>, Wrong> {
    let count = columns.count();
    let all = groups(places.iter().map(|place| (*place, first[*place])));
    let is_of_axes = |group: &&Group| columns.axes == 3 || !group.has_axes;
    let mut fit: Vec<&Group> = all.iter().filter(is_of_axes).collect();
    let is_whole = |group: &&Group| group.places.len() == count;
    if fit.iter().any(is_whole) {
        fit.retain(is_whole);
        if fit.len() > 1 {
            fit.retain(|group| !is_computed(&group.pattern));
        }
        if fit.len() != 1 {
            let expected = format!("one group of {count} columns (--columns PREFIX chooses)");
            let found: Vec<&Group> = all.iter().filter(is_whole).collect();
            return Err((None, expected, listed(&found)));
        }
    } else {
        // Modules stand side by side, each with as many columns.
        let most = fit
            .iter()
            .map(|group| group.places.len())
            .max()
            .unwrap_or(0);
        fit.retain(|group| group.places.len() == most);
        if fit.len() < 2 || most * fit.len() != count {
            return Ok(None);
        }
    }
    let taken = fit
        .iter()
        .flat_map(|group| &group.places)
        .map(|place| Taken::new(*place, first[*place].to_owned()));
    Ok(Some((taken.collect(), Some(told(&fit, columns)))))
}

/// Describes the order that columns were put in.
fn told(groups: &[&Group], columns: &Columns) -> String {
    let patterns: Vec<String> = groups.iter().map(|g| format!("`{}`", g.pattern)).collect();
    let mut text = format!(
        "columns {} are the readings, in the order of the numbers in their names",
        patterns.join(", then ")
    );
    if groups.iter().any(|group| group.is_mended()) {
        text += ", which is not that of the file";
    }
    if columns.axes == 3 && groups.iter().any(|group| !group.has_axes) {
        text += "; x, y and z of a taxel are taken to stand side by side";
    }
    text
}

/// Columns by a prefix, in the order of the numbers in their names.
fn counted(first: &[&str], prefix: &str, count: usize) -> Result<Chosen, Wrong> {
    let taken = Take::Counted(prefix, count).in_order(first, true)?;
    let all = groups(taken.iter().map(|t| (t.place, first[t.place])));
    let [group] = all.as_slice() else {
        return Ok((taken, None));
    };
    if group.places.len() != count || !group.is_mended() {
        return Ok((taken, None));
    }
    let mended = group
        .places
        .iter()
        .map(|place| Taken::new(*place, first[*place].to_owned()));
    let note = format!(
        "columns `{}` are taken in the order of the numbers in their names, which is not that of the file",
        group.pattern
    );
    Ok((mended.collect(), Some(note)))
}
