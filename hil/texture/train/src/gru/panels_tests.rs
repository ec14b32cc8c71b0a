//! Products in panels are those of the definition, on wide vectors and plain ones.

use super::*;

#[test]
fn products_are_those_of_the_definition() {
    for (rows, depth, columns) in [(1, 3, 9), (5, 9, 3), (8, 96, 288), (7, 20, 33)] {
        let value = |i: usize| ((i * 37 + 11) % 19) as f32 - 9.0;
        let left: Vec<f32> = (0..rows * depth).map(value).collect();
        let matrix: Vec<f32> = (0..depth * columns).map(value).collect();
        let flipped: Vec<f32> = (0..columns * depth)
            .map(|i| matrix[(i % depth) * columns + i / depth])
            .collect();
        for vectors in [Vectors::widest(), Vectors::plain()] {
            let mut out = vec![1.0; rows * columns];
            Panels::new(&matrix, columns).add(&left, &mut out, vectors);
            let mut again = vec![1.0; rows * columns];
            Panels::transposed(&flipped, depth).add(&left, &mut again, vectors);
            for (i, &sum) in out.iter().enumerate() {
                let (r, c) = (i / columns, i % columns);
                let sum_of: f32 = (0..depth)
                    .map(|k| left[r * depth + k] * matrix[k * columns + c])
                    .sum();
                // whole numbers below 2^24: every order of summing gives the same
                assert_eq!((sum, again[i]), (sum_of + 1.0, sum_of + 1.0));
            }
        }
    }
}
