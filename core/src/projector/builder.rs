//! The loop, and its output half, from a layout and a display: defaults are those of `hil run`.

use alloc::boxed::Box;

use crate::contact::{Scope, Settings};
use crate::guard::{Guard, HARD, Limits, Plant, WornWire};
use crate::illusion::{
    AHEAD, Calibration, CalibrationError, Display, Drive, Illusion, Map, ModelSettings, Planned,
    Rect, Sharing, build, inverse,
};
use crate::render::{CADENCE, Pattern, RenderSettings, Response, Style};
use crate::schedule::{Share, Timing};
use crate::skin::{BaselineSettings, HealthSettings, Layout, Module};
use crate::units::{Duration, Milliamps, Point, Prescale};

use super::texture::TexturePlan;
use super::{Output, OutputSettings, Plan, PlanError, Projector, SensingPlan, View};

/// The bench that `hil run` emulates by default, `fixtures/benches/emulated.toml`: thin wires of 8 mm at 1.2 A. Three pulses
/// at this PRE_SCALE are a vibration, and carry the energy that a moving contact needs.
const THIN_8MM: Plant = Plant {
    prescale: Prescale::new(92),
    wire_milliohm: 4871,
    peak: Milliamps(1200),
    bus: Duration::ZERO,
};
/// The default bench's wires on a finger of 33 C, for the guard's rows of heat.
const WORN_THIN: WornWire = WornWire {
    diameter_nm: 50_000,
    length_um: 8_000,
    rest_mc: 33_000,
};

/// Settings from which an [`Output`] is built.
#[derive(Debug)]
#[must_use]
pub struct OutputBuilder {
    display: Display,
    plant: Option<Plant>,
    worn: Option<WornWire>,
    limits: Limits,
    response: Option<Response>,
    style: Style,
    published: Option<(Box<dyn Illusion>, Timing)>,
    sharing: Sharing,
    calibration: Option<Calibration>,
    strokes: Box<[Planned]>,
    drive: Drive,
}

impl From<Display> for OutputBuilder {
    /// An output with the default of every setting.
    fn from(display: Display) -> Self {
        Self {
            display,
            plant: None,
            worn: None,
            limits: HARD,
            response: None,
            style: Style::default(),
            published: None,
            sharing: Sharing::default(),
            calibration: None,
            strokes: Box::default(),
            drive: Drive::default(),
        }
    }
}

impl Output {
    /// An output half on a display. Defaults are those of `hil run`: the renderer chooses pulses every 117 ms, for thin
    /// wires of 8 mm at 1.2 A.
    pub fn builder(display: Display) -> OutputBuilder {
        display.into()
    }
}

impl OutputBuilder {
    /// The hardware behind the outputs: the guard counts heat with it, and its PRE_SCALE spaces the pulses. Unless stated
    /// these are wires of 4.871 Ohm at 1.2 A, and PRE_SCALE 92.
    pub const fn plant(mut self, plant: Plant) -> Self {
        self.plant = Some(plant);
        self
    }

    /// Wire and finger, for the guard's rows of heat. Unless stated these are wires of 50 um and 8 mm on a finger of 33 C, or
    /// for a stated plant wires of 5 mm, which warm the finger more.
    pub const fn worn(mut self, worn: WornWire) -> Self {
        self.worn = Some(worn);
        self
    }

    /// Limits, [`HARD`] unless stated, which no row can loosen.
    pub const fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// Amplitudes by width in ticks of the plant's PRE_SCALE, by which the renderer finds widths. Unless stated these are
    /// [`Response::thin_8mm`], or for a stated plant [`Response::linear`].
    pub fn response(mut self, response: Response) -> Self {
        self.response = Some(response);
        self
    }

    /// Vibration or taps of the renderer, a vibration unless stated.
    pub const fn style(mut self, style: Style) -> Self {
        self.style = style;
        self
    }

    /// A published law in place of the renderer, with its stimulus duration and onset asynchrony.
    pub fn illusion(mut self, law: Box<dyn Illusion>, timing: Timing) -> Self {
        self.published = Some((law, timing));
        self
    }

    /// Sets the rule by which several contacts share wires; the strongest has them unless stated.
    pub const fn sharing(mut self, sharing: Sharing) -> Self {
        self.sharing = sharing;
        self
    }

    /// Sets this person's calibration by wire; all wires are alike unless stated.
    pub fn calibration(mut self, calibration: Calibration) -> Self {
        self.calibration = Some(calibration);
        self
    }

    /// Strokes that are known beforehand; while one runs, live targets wait.
    pub fn strokes(mut self, strokes: Box<[Planned]>) -> Self {
        self.strokes = strokes;
        self
    }

    /// Activation to duty of a published law, and weights of levels: [`Drive::default`] unless stated.
    pub const fn drive(mut self, drive: Drive) -> Self {
        self.drive = drive;
        self
    }

    /// Builds the output half; the last time that it allocates.
    ///
    /// # Errors
    /// [`PlanError`] for what does not fit the display.
    pub fn build(self) -> Result<Output, PlanError> {
        let (display, settings, guard) = self.parts()?;
        if settings.calibration.len() != display.wires().len() {
            return Err(PlanError::Calibration(CalibrationError::Count));
        }
        Ok(Output::new(display, settings, guard))
    }

    fn parts(self) -> Result<(Display, OutputSettings, Guard), PlanError> {
        let display = self.display;
        let plant = self.plant.unwrap_or(THIN_8MM);
        let worn = self.worn.unwrap_or(match self.plant {
            Some(_) => WornWire::default(),
            None => WORN_THIN,
        });
        let guard = Guard::new(self.limits, plant, display.wires(), worn)?;
        let even = || Calibration::even(display.wires().len());
        let calibration = self.calibration.unwrap_or_else(even);
        let (illusion, timing, render) = match self.published {
            Some((law, timing)) => (law, timing, None),
            None => {
                let pattern = Pattern::on(plant.prescale, CADENCE)?;
                let response = match (self.response, self.plant) {
                    (Some(response), _) => response,
                    (None, Some(_)) => Response::linear(guard.widest()),
                    (None, None) => Response::thin_8mm(guard.widest()),
                };
                let settings = ModelSettings::default();
                let render = RenderSettings {
                    law: inverse(&display, &settings)?,
                    style: self.style,
                    pattern,
                    full: response.full(),
                    texture: response.full(),
                    response,
                    woven: Box::default(),
                    sharing: self.sharing,
                    calibration: calibration.clone(),
                };
                (build(&display, &settings)?, pattern.timing(), Some(render))
            }
        };
        let settings = OutputSettings {
            timing,
            illusion,
            sharing: self.sharing,
            calibration,
            strokes: self.strokes,
            drive: self.drive,
            share: Share::width(plant.peak),
            render,
        };
        Ok((display, settings, guard))
    }
}

/// Settings from which a [`Projector`] is built.
#[derive(Debug)]
#[must_use]
pub struct Builder {
    sensing: SensingPlan,
    output: OutputBuilder,
    drives: u16,
    area: Option<Rect>,
    texture: Option<TexturePlan>,
}

impl Projector {
    /// A loop from a skin to a display. Defaults are those of `hil run`. Where the output half is to differ, its own
    /// builder stands in the place of the display.
    pub fn builder(layout: Layout, output: impl Into<OutputBuilder>) -> Builder {
        Builder {
            sensing: SensingPlan {
                layout,
                baseline: BaselineSettings::default(),
                compression: Settings::default(),
                health: HealthSettings::default(),
            },
            output: output.into(),
            drives: 0,
            area: None,
            texture: None,
        }
    }
}

impl Builder {
    /// Reference, threshold and faulty taxels, [`BaselineSettings::default`] unless stated.
    pub const fn baseline(mut self, settings: BaselineSettings) -> Self {
        self.sensing.baseline = settings;
        self
    }

    /// Contacts and levels, [`Settings::default`] unless stated.
    pub fn compression(mut self, settings: Settings) -> Self {
        self.sensing.compression = settings;
        self
    }

    /// Sets the rules by which a taxel counts as ill, [`HealthSettings::default`] unless stated.
    pub const fn health(mut self, settings: HealthSettings) -> Self {
        self.sensing.health = settings;
        self
    }

    /// The module that drives the display; the first unless stated.
    pub const fn drives(mut self, module: u16) -> Self {
        self.drives = module;
        self
    }

    /// The part of the skin that fills the display, sensor mm; [`sensor_area`] unless stated.
    pub const fn area(mut self, area: Rect) -> Self {
        self.area = Some(area);
        self
    }

    /// A texture that is felt; none unless stated.
    pub fn texture(mut self, texture: TexturePlan) -> Self {
        self.texture = Some(texture);
        self
    }

    /// Builds the loop; the last time that it allocates.
    ///
    /// # Errors
    /// [`PlanError`] for what does not fit together.
    pub fn build(self) -> Result<Projector, PlanError> {
        let (display, output, guard) = self.output.parts()?;
        let scope = self.sensing.compression.scope;
        let whole = sensor_area(&self.sensing.layout, usize::from(self.drives), scope);
        let map = match self.sensing.layout.modules().get(usize::from(self.drives)) {
            Some(_) => Map::new(whole, self.area, display.bounds())?,
            None => return Err(PlanError::NoSuchModule(self.sensing.layout.modules().len())),
        };
        Projector::new(Plan {
            sensing: self.sensing,
            drives: self.drives,
            view: View::fixed(map),
            ahead: AHEAD,
            display,
            output,
            texture: self.texture,
            guard,
        })
    }
}

/// The rectangle around what drives the display, sensor mm: the driving module's taxels, or the whole skin's.
pub fn sensor_area(layout: &Layout, drives: usize, scope: Scope) -> Rect {
    let modules = layout.modules().iter();
    let placed = |m: &Module, origin: Point| {
        let shifted = |p: &Point| Point::new(p.x + origin.x, p.y + origin.y);
        Rect::around(m.points().iter().map(shifted))
    };
    match scope {
        Scope::Skin => {
            let corners = modules.flat_map(|m| {
                let Rect { min, max } = placed(m, m.origin());
                [min, max]
            });
            Rect::around(corners)
        }
        Scope::Module => {
            let driving = modules.skip(drives).take(1);
            let points = driving.flat_map(|m| m.points().iter().copied());
            Rect::around(points)
        }
    }
}

#[cfg(test)]
#[path = "builder_tests.rs"]
mod tests;
