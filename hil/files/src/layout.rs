//! Layouts: places of a skin's taxels or a display's wires. Millimetres, x right, y up, row 0 on top.

use serde::Deserialize;

use super::error::FileError;
use super::module::{SkinModule, places};
use super::pace::USUAL_BITRATE;
use super::resolve::{FileKind, resolve_from};
use super::seam::LayoutSeam;
use super::settings::bounds;
use super::source::Source;
use super::transducer::Transducer;

/// Outer diameter of the eyelets that hold a wire at both ends (thesis 5.2.2).
const EYELET_MM: f64 = 0.76;

/// A layout of either kind.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(untagged))]
pub enum LayoutFile {
    /// Taxels.
    Sensor(SensorLayout),
    /// Wires.
    Display(DisplayLayout),
}

/// The only kind a [`SensorLayout`] may state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub(super) enum SensorTag {
    Sensor,
}

/// The only kind a [`DisplayLayout`] may state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub(super) enum DisplayTag {
    Display,
}

/// A skin: modules of taxels.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SensorLayout {
    #[allow(dead_code, reason = "checked by its type")]
    kind: SensorTag,
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The skin, in a sentence.
    pub description: String,
    /// The part that is an assumption; reports flag it.
    pub assumed: Option<String>,
    /// The principle by which its taxels measure.
    #[serde(default = "magnetic")]
    pub transducer: Transducer,
    /// Axes of a taxel, 1 (normal only) or 3.
    #[serde(default = "three")]
    pub axes: u8,
    /// Bits per second of its CAN buses.
    #[serde(default = "usual_bitrate")]
    pub bitrate: u32,
    /// The image that all modules together make, where they make one; cells without a taxel read as faulty.
    pub image: Option<ImageSize>,
    /// Modules of the skin; readings come in their order.
    pub modules: Vec<SkinModule>,
    /// Edges at which modules join; between modules that none join, distances go over the plane.
    #[serde(default)]
    pub seams: Vec<LayoutSeam>,
}

const fn magnetic() -> Transducer {
    Transducer::Magnetic
}

const fn three() -> u8 {
    3
}

const fn usual_bitrate() -> u32 {
    USUAL_BITRATE
}

/// Rows and columns of an image of taxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ImageSize {
    /// Number of rows, from top to bottom.
    pub rows: usize,
    /// Number of columns, from left to right.
    pub columns: usize,
}

/// A worn display: wires on skin.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DisplayLayout {
    #[allow(dead_code, reason = "checked by its type")]
    kind: DisplayTag,
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The display, in a sentence.
    pub description: String,
    /// The part that is an assumption; reports flag it.
    pub assumed: Option<String>,
    /// The actuator spacings Dx and Dy of the phantom sensation, mm.
    pub spacing_mm: [f64; 2],
    /// The surface that was unrolled; left out: flat.
    pub surface: Option<FingerSurface>,
    /// Centres of the wires on the unrolled surface, mm, in the order of the bench's outputs.
    pub wires_mm: Vec<[f64; 2]>,
}

/// A finger: a cylinder whose end is a half sphere.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FingerSurface {
    /// Diameter of cylinder and tip, mm.
    pub diameter_mm: f64,
    /// The y at which the cylinder ends and the tip begins, mm.
    pub tip_mm: f64,
}

impl SensorLayout {
    /// Number of taxels that are read, over all modules.
    #[must_use]
    pub fn readings(&self) -> usize {
        self.modules.iter().map(SkinModule::readings).sum()
    }

    fn check(&self, source: &Source) -> Result<(), FileError> {
        source.heading(&self.name, &self.description)?;
        if !matches!(self.axes, 1 | 3) {
            return Err(source.bad("axes", "1 or 3"));
        }
        let single = matches!(self.transducer, Transducer::Capacitive | Transducer::Camera);
        if single && self.axes != 1 {
            return Err(source.bad("axes", "1: such taxels measure the normal axis alone"));
        }
        if self.transducer == Transducer::Cells && self.axes != 3 {
            return Err(source.bad("axes", "3: a cell's three modalities"));
        }
        if !(10_000..=1_000_000).contains(&self.bitrate) {
            return Err(source.bad("bitrate", "10000 to 1000000 bits per second, as CAN has"));
        }
        if self.modules.is_empty() {
            return Err(source.bad("modules", "at least one module"));
        }
        if let Some(image) = self.image {
            bounds!(source, "image", image; rows: 1..=4096; columns: 1..=4096)?;
        }
        let mut cells = std::collections::BTreeSet::new();
        for (index, module) in self.modules.iter().enumerate() {
            let key = format!("modules[{index}]");
            module.check(source, &key, self.transducer)?;
            if module.image.is_some() != self.image.is_some() {
                let expected = "an image for the layout and for every module, or for none";
                return Err(source.bad(&format!("{key}.image"), expected));
            }
            let (rows, columns) = self.image.map_or((0, 0), |size| (size.rows, size.columns));
            for (row, column) in module.taxels().iter().filter_map(|taxel| taxel.image) {
                if row >= rows || column >= columns || !cells.insert((row, column)) {
                    let expected = format!("free cells inside the {rows}x{columns} image");
                    return Err(source.bad(&format!("{key}.image"), expected));
                }
            }
        }
        self.shared_board().map_or(Ok(()), |(module, position)| {
            let key = format!("modules[{module}].boards[{position}]");
            Err(source.bad(&key, "an address of its own on its bus"))
        })
    }

    /// The first board whose address is another one's on its bus: its module and its place there.
    pub(super) fn shared_board(&self) -> Option<(usize, usize)> {
        let mut seen = std::collections::BTreeSet::new();
        let of_module = |(index, module): (usize, &SkinModule)| {
            let shared = |board: &u8| !seen.insert((module.bus, *board));
            Some((index, module.boards.iter().position(shared)?))
        };
        self.modules.iter().enumerate().find_map(of_module)
    }
}

impl LayoutFile {
    /// Reads and checks a layout of either kind.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        match source.peek("kind")?.as_deref() {
            Some("sensor") => {
                let mut layout: SensorLayout = source.read()?;
                layout.check(source)?;
                layout.modules = layout
                    .modules
                    .into_iter()
                    .flat_map(SkinModule::copies)
                    .collect();
                for (n, seam) in layout.seams.iter().enumerate() {
                    seam.check(&layout.modules, source, &format!("seams[{n}]"))?;
                }
                Ok(Self::Sensor(layout))
            }
            Some("display") => {
                let layout: DisplayLayout = source.read()?;
                layout.check(source)?;
                Ok(Self::Display(layout))
            }
            _ => Err(source.bad("kind", "\"sensor\" or \"display\"")),
        }
    }
}

impl DisplayLayout {
    /// The display that `key` of another file names.
    pub(super) fn named(
        name: &str,
        referrer: &Source,
        key: &str,
    ) -> Result<(Self, Source), FileError> {
        let source = resolve_from(FileKind::Layout, name, referrer, key)?;
        let LayoutFile::Display(display) = LayoutFile::read(&source)? else {
            let expected = "a layout of kind \"display\"";
            return Err(referrer.bad_found(key, expected, format!("the sensor `{name}`")));
        };
        Ok((display, source))
    }

    fn check(&self, source: &Source) -> Result<(), FileError> {
        source.heading(&self.name, &self.description)?;
        bounds!(source, "", self; spacing_mm: 0.1..=1e3, "mm")?;
        if let Some(surface) = self.surface {
            bounds!(source, "surface", surface;
                diameter_mm: 1.0..=1e3, "mm";
                tip_mm: -1e3..=1e3, "mm")?;
        }
        places(source, "wires_mm", &self.wires_mm, 1..=256)?;
        self.check_overlap(source)
    }

    /// Checks that no two wires are closer than their eyelets are wide.
    fn check_overlap(&self, source: &Source) -> Result<(), FileError> {
        for (index, [x, y]) in self.wires_mm.iter().enumerate() {
            let near = |[u, v]: &[f64; 2]| libm::hypot(x - u, y - v) < EYELET_MM;
            if let Some(first) = self.wires_mm[..index].iter().position(near) {
                let expected =
                    format!("at least {EYELET_MM} mm to every other wire, number {first} overlaps");
                return Err(source.bad(&format!("wires_mm[{index}]"), expected));
            }
        }
        Ok(())
    }
}
