//! The rule for a skin's rest as it was before it became a state.

use palpate_core::contact::{Compressor, Settings};
use palpate_core::skin::{Axes, RelativeFrame};
use palpate_core::units::{Duration, Point};

use super::{Frame, Skin};

/// The first contact of every frame by the rule of before: the mean of fifty rows, one threshold for begin and end, untouched taxels followed within 5 s, and
/// everything anew after a silence of a second. Taxels at an end of their range are left out.
pub fn before(skin: &Skin, frames: &[Frame]) -> Vec<Option<Point>> {
    const ROWS: usize = 50;
    let n = frames[0].counts.len();
    let mut compressor = Compressor::new(&skin.layout, Settings::default()).unwrap();
    let mut relative = RelativeFrame::new(&skin.layout);
    let (mut sums, mut squares) = (vec![[0.0f64; 3]; n], vec![0.0f64; n]);
    let (mut seen, mut since, mut last) = (0, 0, frames[0].at);
    let mut found = Vec::new();
    for (k, frame) in frames.iter().enumerate() {
        if frame.at.since(last) > Duration::from_millis(1000) {
            (seen, since) = (0, k);
            sums.fill([0.0; 3]);
        }
        let share = frame.at.since(last).as_secs_f64();
        let share = share / (share + 5.0);
        last = frame.at;
        if seen < ROWS {
            for i in 0..n {
                for axis in 0..3 {
                    let now = f64::from(frame.counts[i][axis]);
                    sums[i][axis] += now / ROWS as f64;
                    if since == 0 && seen > 0 {
                        let step = now - f64::from(frames[k - 1].counts[i][axis]);
                        squares[i] += step * step / (2 * (ROWS - 1)) as f64;
                    }
                }
            }
            seen += 1;
            found.push(None);
            continue;
        }
        let mut differences = vec![[0.0f32; 3]; n];
        for i in 0..n {
            let threshold = f64::from(skin.floor) + 6.0 * squares[i].sqrt();
            let away = [0, 1, 2].map(|a| f64::from(frame.counts[i][a]) - sums[i][a]);
            let size = away.iter().map(|d| d * d).sum::<f64>().sqrt();
            if frame.counts[i][2] == 0 || frame.counts[i][2] == u16::MAX {
                continue;
            }
            differences[i] = away.map(|d| (d / threshold) as f32);
            if size <= threshold {
                (0..3).for_each(|a| sums[i][a] += share * away[a]);
            }
        }
        relative.load(&differences, Axes::XYZ, 1.0).unwrap();
        let contacts = compressor.compress(&relative).unwrap();
        found.push(contacts.first().map(|c| c.place));
    }
    found
}
