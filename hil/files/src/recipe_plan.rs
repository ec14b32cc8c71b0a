//! A recipe held against its layout: which columns become which readings of the skin.

use super::dialect::Writing;
use super::error::FileError;
use super::gain::Gain;
use super::layout::SensorLayout;
use super::module::SkinModule;
use super::order::{Group, groups, is_computed, listed, number_in};
use super::recipe::{ColumnOrder, Recipe, RecipeModule};
use super::source::Source;
use super::taken::{Taken, Turns, Wrong, numbered, shown};

/// A recipe for the modules of a layout.
#[derive(Debug, Clone, PartialEq)]
pub struct RecipePlan {
    /// Separator and decimal mark of the recording, as far as the recipe states them.
    pub(super) writing: Writing,
    /// Lines of a frame; none: as blank lines, remarks and files part them.
    pub(super) frame_lines: Option<usize>,
    /// The column that names the sensor of a row.
    sensor_column: Option<String>,
    /// Modules in the order of the layout.
    modules: Vec<Planned>,
    axes: usize,
}

/// Way to the columns of a module.
#[derive(Debug, Clone, PartialEq)]
enum Found {
    Prefix(String),
    Names(Vec<String>),
    /// The first of them, from 0.
    From(usize),
}

/// A module whose columns are to be found.
#[derive(Debug, Clone, PartialEq)]
struct Planned {
    /// Table of the module in the recipe.
    key: String,
    found: Found,
    order: ColumnOrder,
    without: Vec<u64>,
    /// The file's reading for each of the layout's, and `true` where it counts the other way.
    readings: Vec<(usize, bool)>,
    gain: Option<Gain>,
    sensor: Option<String>,
}

impl RecipePlan {
    /// Holds a recipe against the layout it is for.
    ///
    /// # Errors
    /// Names the line and key of a module that the layout does not have, or that cannot be turned so.
    pub fn new(recipe: &Recipe, source: &Source, layout: &SensorLayout) -> Result<Self, FileError> {
        let names: Vec<&str> = layout.modules.iter().map(|m| m.name.as_str()).collect();
        let mut modules: Vec<Option<Planned>> = vec![None; layout.modules.len()];
        for (index, module) in recipe.modules.iter().enumerate() {
            let key = format!("modules[{index}]");
            let place = match &module.name {
                None => (index < modules.len()).then_some(index),
                Some(name) => names.iter().position(|known| known == name),
            };
            let place = place
                .filter(|place| modules[*place].is_none())
                .ok_or_else(|| {
                    let expected = format!(
                        "each module of layout `{}` once ({})",
                        layout.name,
                        names.join(", ")
                    );
                    match &module.name {
                        Some(_) => source.bad(&format!("{key}.name"), expected),
                        None => source.bad_found(&key, expected, "another one"),
                    }
                })?;
            let readings =
                readings(module, &layout.modules[place], layout.axes).ok_or_else(|| {
                    let expected =
                        "0: a module that is turned or mirrored has a `grid` in the layout";
                    source.bad(&format!("{key}.turned_deg"), expected)
                })?;
            modules[place] = Some(Planned {
                found: match (&module.prefix, &module.columns, module.first_column) {
                    (Some(prefix), ..) => Found::Prefix(prefix.clone()),
                    (None, Some(names), _) => Found::Names(names.clone()),
                    (None, None, first) => Found::From(first.unwrap_or(1) - 1),
                },
                key,
                order: module.order,
                without: module.without.clone(),
                readings,
                gain: recipe.gain(module),
                sensor: module.sensor.clone(),
            });
        }
        if let Some(missing) = modules.iter().position(Option::is_none) {
            let expected = format!(
                "each module of layout `{}` once ({})",
                layout.name,
                names.join(", ")
            );
            return Err(source.bad_found(
                "modules",
                expected,
                format!("none for `{}`", names[missing]),
            ));
        }
        Ok(Self {
            writing: recipe.writing(),
            frame_lines: recipe.lines_per_frame,
            sensor_column: recipe.sensor_column.clone(),
            modules: modules.into_iter().flatten().collect(),
            axes: usize::from(layout.axes),
        })
    }

    /// Readings of the skin.
    #[must_use]
    pub fn count(&self) -> usize {
        self.modules.iter().map(|m| m.readings.len()).sum()
    }

    /// The columns of all modules, in the order of the layout's readings.
    pub(super) fn columns(
        &self,
        first: &[&str],
        header: bool,
        times: &[usize],
    ) -> Result<Vec<Taken>, Wrong> {
        let turns = self.turns(first, header)?;
        let sensor = turns.map(|turns| turns.place);
        let mut all = Vec::new();
        for module in &self.modules {
            let is_other = |place: usize| times.contains(&place) || sensor == Some(place);
            let own = module.columns(first, header, &is_other, self.axes)?;
            all.extend(module.readings.iter().map(|(reading, is_opposite)| {
                let place = own[*reading];
                let name = if header { first[place] } else { "" };
                Taken {
                    gain: module.gain.map(|gain| gain.turned(*is_opposite)),
                    is_opposite: *is_opposite && module.gain.is_none(),
                    ..Taken::new(place, name.to_owned())
                }
            }));
        }
        Ok(all)
    }

    /// The sensors whose rows take turns; none where each row has all of them.
    pub(super) fn turns(&self, first: &[&str], header: bool) -> Result<Option<Turns>, Wrong> {
        let Some(column) = &self.sensor_column else {
            return Ok(None);
        };
        let place = match header {
            true => first.iter().position(|name| name == column),
            false => numbered(column).filter(|place| *place < first.len()),
        };
        let place = place.ok_or_else(|| {
            let expected = format!("a column `{column}` (sensor_column)");
            (None, expected, shown(&first.join(", ")))
        })?;
        let sensors = self.modules.iter();
        let sensors = sensors.map(|m| (m.sensor.clone().unwrap_or_default(), m.readings.len()));
        Ok(Some(Turns {
            place,
            sensors: sensors.collect(),
        }))
    }
}

impl Planned {
    /// The places of the module's columns, in the order in which its maker counts.
    fn columns(
        &self,
        first: &[&str],
        header: bool,
        is_other: &dyn Fn(usize) -> bool,
        axes: usize,
    ) -> Result<Vec<usize>, Wrong> {
        let count = self.readings.len();
        let wrong = |expected: String, found: String| {
            (
                None,
                format!("{expected} ({} of the recipe)", self.key),
                found,
            )
        };
        let candidates: Vec<usize> = match &self.found {
            Found::Names(names) => {
                let place = |name: &String| {
                    let place = first.iter().position(|field| header && field == name);
                    place.ok_or_else(|| {
                        wrong(format!("a column `{name}`"), "none of that name".into())
                    })
                };
                let places: Vec<usize> = names.iter().map(place).collect::<Result<_, _>>()?;
                return match places.len() == count {
                    true => Ok(places),
                    false => Err(wrong(format!("{count} columns"), places.len().to_string())),
                };
            }
            Found::Prefix(prefix) => (0..first.len())
                .filter(|&c| header && first[c].starts_with(prefix.as_str()) && !is_other(c))
                .collect(),
            Found::From(begin) => (*begin..first.len())
                .take(count + self.without.len() * axes)
                .collect(),
        };
        let left_out = |(at, place): &(usize, usize)| {
            let number = if header {
                number_in(first[*place])
            } else {
                None
            };
            self.without.contains(&number.unwrap_or((at / axes) as u64))
        };
        let kept = candidates
            .iter()
            .copied()
            .enumerate()
            .filter(|c| !left_out(c));
        let kept: Vec<usize> = kept.map(|(_, place)| place).collect();
        let by_numbers = self.order == ColumnOrder::Numbers && header;
        if by_numbers && let Some(sorted) = self.sorted(first, &kept, axes).transpose() {
            return sorted.map_err(|(expected, found)| wrong(expected, found));
        }
        if kept.len() != count {
            return Err(wrong(format!("{count} columns"), kept.len().to_string()));
        }
        if self.order != ColumnOrder::AxesFirst {
            return Ok(kept);
        }
        let taxels = count / axes;
        Ok((0..count)
            .map(|n| kept[n % axes * taxels + n / axes])
            .collect())
    }

    /// Columns in the order of the numbers in their names; none where they have no numbers.
    fn sorted(
        &self,
        first: &[&str],
        kept: &[usize],
        axes: usize,
    ) -> Result<Option<Vec<usize>>, (String, String)> {
        let count = self.readings.len();
        let all = groups(kept.iter().map(|place| (*place, first[*place])));
        if all.is_empty() {
            return Ok(None);
        }
        let fits = |group: &&Group| group.places.len() == count && (axes == 3 || !group.has_axes);
        let mut fit: Vec<&Group> = all.iter().filter(fits).collect();
        if fit.len() > 1 {
            fit.retain(|group| !is_computed(&group.pattern));
        }
        match fit.as_slice() {
            [group] => Ok(Some(group.places.clone())),
            _ => {
                let found = listed(&all.iter().collect::<Vec<_>>());
                Err((format!("one group of {count} columns"), found))
            }
        }
    }
}

/// The maker's reading for each of a module's, and `true` where it counts the other way. None where a module that is
/// turned is no grid.
fn readings(recipe: &RecipeModule, module: &SkinModule, axes: u8) -> Option<Vec<(usize, bool)>> {
    let axes = usize::from(axes);
    if recipe.turned_deg == 0 && !recipe.mirrored {
        return Some((0..module.readings() * axes).map(|n| (n, false)).collect());
    }
    module.grid?;
    // The maker's direction of the layout's x and y: each a row of a rotation and a mirror.
    let (cos, sin) = match recipe.turned_deg {
        90 => (0, 1),
        180 => (-1, 0),
        270 => (0, -1),
        _ => (1, 0),
    };
    let mirror = if recipe.mirrored { -1 } else { 1 };
    // Layout (x, y) = turn * mirror * maker (x, y).
    let x_from = [cos * mirror, -sin];
    let y_from = [sin * mirror, cos];
    let taxels: Vec<[f64; 2]> = module
        .taxels()
        .iter()
        .filter(|taxel| taxel.active)
        .map(|taxel| {
            let along =
                |of: usize| taxel.x_mm * f64::from(x_from[of]) + taxel.y_mm * f64::from(y_from[of]);
            [along(0), along(1)]
        })
        .collect();
    // A maker counts from the top left, row by row. Micrometres compare exactly.
    let um = |mm: f64| libm::round(mm * 1e3) as i64;
    let mut order: Vec<usize> = (0..taxels.len()).collect();
    order.sort_by_key(|&n| (-um(taxels[n][1]), um(taxels[n][0])));
    let mut all = vec![(0, false); taxels.len() * axes];
    for (own, &taxel) in order.iter().enumerate() {
        for axis in 0..axes {
            let (from, is_opposite) = match (axes, axis) {
                (3, 0) => source_of(x_from),
                (3, 1) => source_of(y_from),
                _ => (axis, false),
            };
            all[taxel * axes + axis] = (own * axes + from, is_opposite);
        }
    }
    Some(all)
}

/// The axis that a row of a rotation takes, and whether it does so the other way.
const fn source_of(row: [i32; 2]) -> (usize, bool) {
    match row {
        [0, y] => (1, y < 0),
        [x, _] => (0, x < 0),
    }
}
