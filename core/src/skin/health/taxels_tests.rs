//! Many taxels in one go against taxel by taxel.

use super::*;
use crate::random::RandomStream;
use crate::skin::Module;
use crate::units::Duration;

#[test]
fn what_is_seen_in_one_go_is_what_every_taxel_shows() {
    for axes in [1, 3] {
        let pad = Module::grid("pad", 3, 11, 1.0).unwrap();
        let mut active = [true; 33];
        (active[4], active[30]) = (false, false);
        let pad = pad.with_axes(axes).unwrap().with_active(&active).unwrap();
        let l = Layout::single(pad).unwrap();
        let settings = HealthSettings {
            frozen_after: Duration::from_millis(80),
            ..HealthSettings::default()
        };
        let mut fast = Taxels::new(&l, settings);
        let mut slow = fast.clone();
        let (mut s, mut r) = (Scan::new(&l), RandomStream::new(9, "health"));
        let (mut row, mut together) = ([[500u16; 3]; 33], 0);
        for frame in 0..20_000u64 {
            for (counts, active) in row.iter_mut().zip(active) {
                match r.next_u64() % 10_000 {
                    0 => counts[2] = [0, 1, u16::MAX, 40_000][frame as usize % 4],
                    1..4_000 => {}
                    _ => *counts = [900, 1000, 1100].map(|c| c + (r.next_u64() % 3) as u16),
                }
                if axes == 1 || !active {
                    (counts[0], counts[1]) = (0, 0);
                }
                counts[2] *= u16::from(active);
            }
            let at = Instant::from_micros(10_000 * frame);
            s.load(at, &row).unwrap();
            let said = fast.observe(&s, 0);
            together += usize::from(fast.modules[0].at == at);
            slow.learn(&s, 0);
            let steady = slow.compare(&s, 0);
            let each = slow.observe_each(&s, 0);
            assert_eq!(said.any, each.any, "frame {frame}");
            assert_eq!(said.well, each.well && steady, "frame {frame}");
            for i in 0..33 {
                assert_eq!(
                    fast.received(i),
                    slow.received(i),
                    "frame {frame}, taxel {i}"
                );
                assert_eq!(fast.changes(i), slow.changes(i), "frame {frame}, taxel {i}");
                assert_eq!(
                    fast.changed_at(i),
                    slow.changed_at(i),
                    "frame {frame}, taxel {i}"
                );
                assert_eq!(
                    fast.has_jumped(i),
                    slow.has_jumped(i),
                    "frame {frame}, taxel {i}"
                );
                assert_eq!(
                    fast.is_jumping(i),
                    slow.is_jumping(i),
                    "frame {frame}, taxel {i}"
                );
                assert_eq!(
                    fast.is_at_an_end(i),
                    slow.is_at_an_end(i),
                    "frame {frame}, taxel {i}"
                );
            }
        }
        assert!(together > 5_000, "{together} of 20000 in one go");
    }
}
