//! A peer: weighted K-means as textbooks write it. One structure per point, f64, k-means++ anew in every frame,
//! memory anew in every frame, iteration until no point changes its cluster.

/// A point with its weight and cluster.
#[derive(Clone, Copy)]
struct Member {
    x: f64,
    y: f64,
    w: f64,
    cluster: usize,
}

/// xorshift64, to draw seeds.
pub struct Draw(pub u64);

impl Draw {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn distance2(a: (f64, f64), m: &Member) -> f64 {
    (a.0 - m.x) * (a.0 - m.x) + (a.1 - m.y) * (a.1 - m.y)
}

/// Seeds by k-means++.
fn seeds(members: &[Member], k: usize, draw: &mut Draw) -> Vec<(f64, f64)> {
    let mut centroids: Vec<(f64, f64)> = Vec::new();
    while centroids.len() < k {
        let mass: Vec<f64> = members
            .iter()
            .map(|m| {
                let d = centroids.iter().map(|c| distance2(*c, m));
                m.w * if centroids.is_empty() {
                    1.0
                } else {
                    d.fold(f64::INFINITY, f64::min)
                }
            })
            .collect();
        let mut left = draw.uniform() * mass.iter().sum::<f64>();
        let mut chosen = members.len() - 1;
        for (i, m) in mass.iter().enumerate() {
            left -= m;
            if left < 0.0 {
                chosen = i;
                break;
            }
        }
        centroids.push((members[chosen].x, members[chosen].y));
    }
    centroids
}

/// Centroids of points, each `(x, y, w)`: from `start`, or seeded where there is none. None for no points.
pub fn kmeans(
    points: &[(f32, f32, f32)],
    k: usize,
    start: Option<&[(f64, f64)]>,
    draw: &mut Draw,
) -> Vec<(f64, f64)> {
    if points.is_empty() {
        return Vec::new();
    }
    let mut members: Vec<Member> = points
        .iter()
        .map(|&(x, y, w)| Member {
            x: f64::from(x),
            y: f64::from(y),
            w: f64::from(w),
            cluster: usize::MAX,
        })
        .collect();
    let mut centroids = match start {
        Some(start) => start.to_vec(),
        None => seeds(&members, k, draw),
    };
    for _ in 0..300 {
        let mut changed = false;
        for m in &mut members {
            let mut best = (f64::INFINITY, 0);
            for (c, place) in centroids.iter().enumerate() {
                let d = distance2(*place, m).sqrt();
                if d < best.0 {
                    best = (d, c);
                }
            }
            changed |= m.cluster != best.1;
            m.cluster = best.1;
        }
        if !changed {
            break;
        }
        for (c, place) in centroids.iter_mut().enumerate() {
            let mine: Vec<&Member> = members.iter().filter(|m| m.cluster == c).collect();
            let w: f64 = mine.iter().map(|m| m.w).sum();
            if w > 0.0 {
                *place = (
                    mine.iter().map(|m| m.w * m.x).sum::<f64>() / w,
                    mine.iter().map(|m| m.w * m.y).sum::<f64>() / w,
                );
            }
        }
    }
    centroids
}
