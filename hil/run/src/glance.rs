//! A run at a glance: eight lines of 80 columns, the verdict last.

use std::io::{self, Write};

use palpate_records::model;
use palpate_records::verdict::{COLUMNS, Verdict};

use crate::summary::Summary;

impl Summary {
    /// Writes eight lines of 80 columns, or all figures if `long`, then the `written` files and the verdict.
    ///
    /// Each further reason has its own line. `colored` adds a terminal's colours.
    ///
    /// # Errors
    /// Errors of the stream.
    pub fn write(
        &self,
        out: &mut dyn Write,
        (long, colored): (bool, bool),
        written: &[String],
    ) -> io::Result<()> {
        if long {
            self.write_long(out)?;
        } else {
            writeln!(out, "{}", fitted(&self.heading()))?;
            for (name, value) in self.glance() {
                writeln!(out, "{}", fitted(&format!("  {name:<16}{value}")))?;
            }
            if let Some(unknown) = self.texture.as_ref().and_then(|t| t.unknown()) {
                writeln!(out, "{}", fitted(&format!("  {:<16}{unknown}", "texture")))?;
            }
        }
        for path in written {
            writeln!(out, "  {:<16}{path}", "wrote")?;
        }
        let columns = if long { usize::MAX } else { COLUMNS };
        self.conclusion.write_last(out, columns, colored)
    }

    fn heading(&self) -> String {
        let Self { scene, bench, .. } = self;
        let length = match self.source.is_emulated() {
            true => format!("{:.1} s emulated in {:.2} s", self.sim_s, self.wall_s),
            false => format!("{:.1} s on hardware", self.sim_s),
        };
        format!("{scene} on {bench}, seed {}: {length}", self.seed)
    }

    fn glance(&self) -> [(&'static str, String); 6] {
        let session = match self.stimuli {
            0 if self.motors.is_some() => "- (no motor was driven)".to_owned(),
            0 => "- (no wire was driven)".to_owned(),
            _ => self.session_words(),
        };
        [
            ("path error", self.path_words()),
            ("felt", self.felt_words()),
            ("felt error", self.felt_error_words()),
            match &self.motors {
                Some(motors) => ("motors", motors.short()),
                None => ("hottest skin", self.skin_words()),
            },
            match &self.motors {
                Some(motors) if self.stimuli > 0 => ("exposure", motors.words()),
                _ => ("longest session", session),
            },
            ("next", self.next().to_owned()),
        ]
    }

    /// Path error, with the pitch of the taxels as a scale.
    fn path_words(&self) -> String {
        let error = match &self.path_error_mm {
            Some(e) => format!("{:.2} mm RMSE, {:.2} at most", e.rmse, e.max),
            None => "- (no true path known)".to_owned(),
        };
        let pitch = self.pitch_mm.map_or_else(String::new, |mm| match mm {
            ..1.0 => format!("; pitch {mm:.2} mm"),
            _ => format!("; pitch {mm:.1} mm"),
        });
        let off = match self.onsets.off_percent() {
            None | Some(0) => String::new(),
            Some(percent) => format!("; {percent} % off pad"),
        };
        format!("{error}{pitch}{off}")
    }

    /// Share of onsets that were felt, their level, and its spread over the unmeasured quantities.
    fn felt_words(&self) -> String {
        let meant = self.onsets.meant;
        let Some(percent) = self.onsets.felt_percent() else {
            return match self.onsets.felt {
                Some(_) => "- (nothing was to be felt)".to_owned(),
                None => "- (no person is emulated)".to_owned(),
            };
        };
        let s = if meant == 1 { "" } else { "s" };
        let level = self.felt.level_db.as_ref();
        let level = level.map_or_else(String::new, |l| format!(", {:+.1} dB", l.median));
        let skin = self.felt.skin_um.as_ref();
        let skin = skin.map_or_else(String::new, |um| format!(", {:.1} um", um.median));
        let band = self.felt.band.as_ref().map_or_else(String::new, |band| {
            let [low, _, high] = band.level_db;
            format!("; band {low:+.1} to {high:+.1} dB")
        });
        let none = self.felt.no_band.as_ref();
        let none = none.map_or("", |_| "; band not computed");
        format!("{percent} % of {meant} onset{s}{level}{skin}{band}{none}")
    }

    fn felt_error_words(&self) -> String {
        let felt = &self.felt_error_mm;
        let Some(all) = &felt.everywhere else {
            return "- (nothing felt on a known path)".to_owned();
        };
        let inside = match (felt.rmse, felt.onsets) {
            (Some(rmse), n) => format!("{rmse:.2} over {n} inside the wires"),
            (None, _) => "no onset inside the wires".to_owned(),
        };
        format!("{:.2} mm RMSE over all {}, {inside}", all.rmse, all.onsets)
    }

    /// Advice on the next step.
    fn next(&self) -> &'static str {
        match self.conclusion.verdict {
            Verdict::BeyondTheModel
                if self.hottest_wire_c.is_some_and(|c| c <= model::WIRE_C)
                    && self.hottest_skin_c.is_some_and(|c| c <= model::TISSUE_C) =>
            {
                "the wires pull themselves straight: docs/wire.md, then mount.sag_um"
            }
            Verdict::BeyondTheModel => {
                "a person would be burnt: docs/faults.md, then drive and faults"
            }
            Verdict::LimitExceeded => "--html run.html shows when; docs/guard.md has every row",
            Verdict::Failed => "`hil doctor` finds what does not answer",
            Verdict::Stopped => "`hil doctor` shows what is stopped; else run it again",
            Verdict::Incomplete => "`hil doctor` asks every board; docs/bench.md",
            Verdict::NotFelt if self.onsets.unfound == self.onsets.meant => {
                "press harder, or lower threshold_margin: docs/files/scene.md"
            }
            Verdict::NotFelt if self.limiter_events > 0 => {
                "--html run.html shows each limit met; try --illusion inverse"
            }
            Verdict::NotFelt => "--long has levels and limits, docs/felt.md what they hang on",
            Verdict::OffThePad => "move the touches, or [map]: docs/files/scene.md",
            Verdict::Ok => "--html run.html plays it; --long has every figure",
        }
    }
}

/// A line of at most 80 columns; a longer one loses its middle.
fn fitted(line: &str) -> String {
    let count = line.chars().count();
    if count <= COLUMNS {
        return line.to_owned();
    }
    let kept = COLUMNS - 3;
    let head: String = line.chars().take(kept / 2).collect();
    let tail: String = line.chars().skip(count - kept.div_ceil(2)).collect();
    format!("{head}...{tail}")
}

#[cfg(test)]
#[path = "glance_tests.rs"]
mod tests;
