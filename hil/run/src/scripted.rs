//! A scene's presses on one module: touches that move, surfaces that are stroked, contacts whose surface rubs.

use palpate_core::contact::Scope;
use palpate_core::units::Point;
use palpate_emulators::sensor::surface::{Habits, Rub, SurfaceStroke, SurfaceStrokes};
use palpate_emulators::sensor::{Press, Touches};
use palpate_emulators::time::Nanos;

use crate::fingers::Fingers;
use crate::plan::surface;
use palpate_files::{Felt, PathKind, Setup, TextureEntry, Touch, TouchPoint};

/// Scenes' strokes are others than those that models are trained on, which count from 0.
const FIRST_STROKE: u32 = 1000;
/// Step of the travels' tables, s.
const STEP_S: f64 = 1e-3;

/// A touch whose surface is textured.
struct Rubbing {
    rub: Rub,
    start_s: f64,
    /// Millimetres gone since the start at every step.
    travel: Vec<f64>,
}

impl Rubbing {
    fn new(rub: Rub, touch: &Touch) -> Self {
        let steps = ((touch.end_s - touch.start_s) / STEP_S) as usize;
        let at = |step: usize| touch.at(touch.start_s + step as f64 * STEP_S);
        let mut travel = vec![0.0];
        for step in 0..steps {
            let way = at(step).zip(at(step + 1));
            let way = way.map_or(0.0, |(a, b)| libm::hypot(b.x_mm - a.x_mm, b.y_mm - a.y_mm));
            travel.push(travel[step] + way);
        }
        Self {
            rub,
            start_s: touch.start_s,
            travel,
        }
    }

    /// Millimetres gone and mm/s at `t_s` of the scene.
    fn progress(&self, t_s: f64) -> (f64, f64) {
        let steps = ((t_s - self.start_s) / STEP_S).max(0.0);
        let index = (steps as usize).min(self.travel.len().saturating_sub(2));
        let from = self.travel[index];
        let way = self.travel.get(index + 1).map_or(0.0, |to| to - from);
        (from + (steps - index as f64).min(1.0) * way, way / STEP_S)
    }
}

/// Texture of a module and the surface that strokes it, with the number of the first stroke, so that no two fingers'
/// strokes are alike.
fn stroked(setup: &Setup, module: usize) -> Option<(u32, Option<&Felt>, Option<&TextureEntry>)> {
    if setup.fingers.is_empty() {
        let scene = &setup.scene.value;
        let felt = scene.texture.as_ref();
        let felt = felt.filter(|felt| felt.module.unwrap_or(scene.drives) == module)?;
        let entry = setup.texture.as_ref().and_then(|t| t.surface.as_ref());
        return Some((0, Some(felt), entry));
    }
    let fingers = (0..).zip(&setup.fingers);
    let mut textures = fingers.filter_map(|(n, f)| Some((n, f.texture.as_ref()?)));
    let (finger, (felt, stroked)) = textures.find(|(_, (felt, _))| felt.module == Some(module))?;
    let first = finger * FIRST_STROKE;
    Some((first, Some(felt), stroked.surface.as_ref()))
}

/// A scene on one module.
pub(super) struct Scripted {
    touches: Vec<(Touch, Option<Rubbing>)>,
    /// Offsets from the module's millimetres to those of each touch.
    offsets: Vec<[f64; 2]>,
    /// Fingers that join them, and how far each module's millimetres are from those of this one.
    fingers: Option<(Fingers, Vec<Option<[f64; 2]>>)>,
    strokes: SurfaceStrokes,
    /// Span after which everything begins anew.
    repeat: Option<Nanos>,
}

impl Scripted {
    /// Presses of `setup`'s scene on a module whose silicone has a time constant of `lag_s`.
    pub(super) fn new(
        setup: &Setup,
        module: usize,
        seed: u64,
        lag_s: f64,
        repeat: Option<Nanos>,
        fingers: Option<&Fingers>,
    ) -> Self {
        let scene = &setup.scene.value;
        let (first, felt, entry) = stroked(setup, module).unwrap_or_default();
        let textured = felt.zip(entry.map(surface));
        let rub = |number: u32, touch: &Touch| {
            let number = first + number;
            let (felt, texture) = textured.as_ref()?;
            // A touch by hand has no surface.
            let rubs = felt.rubs && touch.path.kind != PathKind::Hand;
            rubs.then(|| Rubbing::new(Rub::new(texture, (seed, number), lag_s), touch))
        };
        // One skin is pressed as one: a touch beside a module presses it too.
        let whole = scene.compression.scope == Scope::Skin;
        let modules = &setup.sensor.value.modules;
        let between = |from: usize| {
            let ([x, y], [u, v]) = (modules.get(from)?.place_mm, modules.get(module)?.place_mm);
            Some([x - u, y - v])
        };
        let touches = || {
            let all = scene.touches.iter();
            all.filter(move |t| whole || t.module == module)
        };
        let offsets = touches().map(|t| between(t.module).unwrap_or_default());
        let reaches = |from: usize| (whole || from == module).then(|| between(from)).flatten();
        let reached = || (0..modules.len()).map(reaches).collect();
        let stroke = |(number, &start_s): (u32, &f64)| {
            let (felt, texture) = textured.as_ref()?;
            let span = (Nanos((start_s * 1e9).round() as u64), felt.stroke_s);
            let number = first + FIRST_STROKE + number;
            let habits = Habits::default();
            Some(SurfaceStroke::new(
                texture,
                &habits,
                (seed, number),
                span,
                lag_s,
            ))
        };
        let starts = felt.iter().flat_map(|felt| &felt.strokes_s);
        Self {
            offsets: offsets.collect(),
            fingers: fingers.map(|fingers| (fingers.clone(), reached())),
            touches: (0..)
                .zip(touches())
                .map(|(n, touch)| (touch.clone(), rub(n, touch)))
                .collect(),
            strokes: SurfaceStrokes((0..).zip(starts).filter_map(stroke).collect()),
            repeat,
        }
    }

    fn at(&self, now: Nanos) -> Nanos {
        self.repeat.map_or(now, |span| Nanos(now.0 % span.0.max(1)))
    }
}

/// A touch as a press of a module whose millimetres lie `offset` away, with the force that a relief adds.
fn pressed(point: &TouchPoint, [x, y]: [f64; 2], more: f64) -> Press {
    Press {
        at: Point::new((point.x_mm + x) as f32, (point.y_mm + y) as f32),
        // a contact that the relief lifts off carries nothing
        force_n: if point.force_n > 0.0 {
            (point.force_n + more).max(0.0)
        } else {
            point.force_n
        },
        diameter_mm: point.diameter_mm,
    }
}

impl Touches for Scripted {
    fn touches(&self, now: Nanos, out: &mut Vec<Press>) {
        let now = self.at(now);
        let t_s = now.as_secs_f64();
        let press = |((touch, rubbing), offset): (&(Touch, Option<Rubbing>), &[f64; 2])| {
            let point = touch.at(t_s)?;
            let more = rubbing.as_ref().map_or(0.0, |r| {
                let (travel, speed) = r.progress(t_s);
                r.rub.force(travel, speed)
            });
            Some(pressed(&point, *offset, more))
        };
        out.extend(self.touches.iter().zip(&self.offsets).filter_map(press));
        if let Some((fingers, reached)) = &self.fingers {
            fingers.each(|touch| {
                let offset = reached.get(touch.module).copied().flatten();
                let here = offset.zip(touch.at(t_s));
                out.extend(here.map(|(offset, point)| pressed(&point, offset, 0.0)));
            });
        }
        self.strokes.touches(now, out);
    }

    /// Drag of the first contact that rubs, which takes the skin along; without one, drag of the stroke.
    fn drag(&self, now: Nanos) -> [f64; 2] {
        let now = self.at(now);
        let t_s = now.as_secs_f64();
        let rubbed = self.touches.iter().find_map(|(touch, rubbing)| {
            let (rubbing, here) = (rubbing.as_ref()?, touch.at(t_s)?);
            let next = touch.at(t_s + STEP_S)?;
            let (dx, dy) = (next.x_mm - here.x_mm, next.y_mm - here.y_mm);
            let way = libm::hypot(dx, dy);
            let (travel, speed) = rubbing.progress(t_s);
            // At rest the skin stays as it was dragged, of which there is no measurement: nothing.
            let drag = if way > 0.0 {
                rubbing.rub.drag(travel, speed) / way
            } else {
                0.0
            };
            Some([drag * dx, drag * dy])
        });
        rubbed.unwrap_or_else(|| self.strokes.drag(now))
    }
}
