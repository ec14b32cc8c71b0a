//! Percentiles and effective sample sizes of weights that are known.

use palpate_files::Quantity;

use super::*;

fn drawn(level_db: f64, log_weight: f64) -> Drawn {
    let mut values = [None; Quantity::ALL.len()];
    values[Quantity::Strain as usize] = Some(if level_db < 0.0 { 0.2 } else { 2.0 });
    Drawn {
        draw: Draw {
            is_taut: false,
            values,
            log_weight: 0.0,
        },
        log_weights: vec![log_weight, 0.0],
        level_db,
        error_mm: -level_db,
    }
}

#[test]
fn weights_move_percentiles_and_cost_draws() {
    let all: Vec<Drawn> = (0..1000)
        .map(|n| {
            let level = f64::from(n) / 50.0 - 10.0;
            drawn(level, if level < 0.0 { -700.0 } else { -800.0 })
        })
        .collect();
    let of = Posterior::new(&all);
    assert!((of.before.level_db[1]).abs() < 0.05 && (of.before.felt - 0.5).abs() < 0.002);
    // Weights of e^-100 and of numbers without an exponent count by their ratios.
    assert!((of.effective - 500.0).abs() < 1e-6, "{}", of.effective);
    assert!((of.effective_of_rows[0] - 500.0).abs() < 1e-6);
    assert!((of.effective_of_rows[1] - 1000.0).abs() < 1e-6);
    let [low, half, high] = of.after.level_db;
    assert!((low + 9.5).abs() < 0.03 && (half + 5.0).abs() < 0.03 && (high + 0.5).abs() < 0.03);
    assert!(of.after.felt < 1e-12 && of.after.error_mm[1] > 4.9);
    assert!((of.kinds_after.loose[0] - 1.0).abs() < 1e-12);
    assert!((of.kinds_before.loose[2] - 0.5).abs() < 1e-12);
}

#[test]
fn no_draws_and_weights_of_nothing_are_no_numbers() {
    let none = Posterior::new(&[]);
    assert!(none.effective == 0.0 && none.after.level_db.iter().all(|db| *db == 0.0));
    let nothing = Posterior::new(&[drawn(1.0, f64::NEG_INFINITY), drawn(2.0, f64::NEG_INFINITY)]);
    assert!(nothing.effective == 0.0 && nothing.after.felt == 0.0);
}
