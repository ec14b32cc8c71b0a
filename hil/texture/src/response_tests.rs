//! Correlations and spans of coordinates whose answer is known.

use super::*;

fn column(name: &str, count: usize) -> Vec<f64> {
    let mut stream = RandomStream::new(3, name);
    (0..count).map(|_| stream.normal()).collect()
}

#[test]
fn a_partial_correlation_leaves_out_what_comes_by_way_of_another_property() {
    // y follows c alone; a follows c as well, so y goes with a only by way of c.
    let (noise, c) = (column("noise", 2000), column("c", 2000));
    let with = |other: &[f64], share: f64| -> Vec<f64> {
        c.iter().zip(other).map(|(c, o)| c + share * o).collect()
    };
    let (a, y) = (with(&column("a", 2000), 0.5), with(&noise, 0.5));
    let whole = spearman(&a, &y);
    assert!(whole > 0.7, "{whole}");
    let columns = [y, a, c.clone(), column("b", 2000), column("d", 2000)];
    let held = each_held(&columns);
    let sure = 3.0 / 2000f64.sqrt();
    assert!(held[0].abs() < 2.0 * sure, "{held:?}");
    assert!(held[1] > 0.6, "{held:?}");
    assert!(held[2].abs() < sure && held[3].abs() < sure, "{held:?}");
    // The same with the matrix's inverse, worked out by hand for one property held.
    let ranks = vec![
        vec![1.0, 0.6, 0.5],
        vec![0.6, 1.0, 0.8],
        vec![0.5, 0.8, 1.0],
    ];
    let expected = (0.6 - 0.5 * 0.8) / ((1.0 - 0.25) * (1.0 - 0.64f64)).sqrt();
    assert!((partial(&ranks, (0, 1), &[2]) - expected).abs() < 1e-12);
}

#[test]
fn a_coordinate_that_tells_one_property_answers_that_one_alone() {
    let asked = conditions();
    assert_eq!(asked.len(), FACTORS * 3 * VALUES as usize);
    let tells = |of: &dyn Fn(&Condition) -> f64| -> Vec<f64> { asked.iter().map(of).collect() };
    // Stiffness, by ratios; and against speed, weaker.
    let values = tells(&|c| c.surface.stiffness_n_per_mm.ln() - 0.1 * c.habits.speed_mm_s.ln());
    let found = Coordinate {
        number: 1,
        sign: 1,
        stands_for: "",
        answers: answers(&asked, &values),
        partial: None,
    };
    assert_eq!(found.own(), Factor::Stiffness);
    for factor in Factor::ALL {
        let (rank, crosstalk) = match factor {
            Factor::Stiffness => (1.0, 1.0),
            Factor::Speed => (-1.0, 0.1 * 4f64.ln() / 100f64.ln()),
            _ => (0.0, 0.0),
        };
        let answer = found.answer(factor);
        assert!((answer.rank - rank).abs() < 1e-9, "{factor:?} {answer:?}");
        let off = found.crosstalk(factor).unwrap() - crosstalk;
        assert!(off.abs() < 1e-9, "{factor:?} {off}");
    }
}

#[test]
fn a_spread_is_the_median_of_all_seeds_between_the_least_and_the_largest() {
    // The second factor moves the coordinate by this share of what its own does.
    let seed = |shares: f64| {
        let answer = |span: f64| Answer { rank: 1.0, span };
        let mut answers = [answer(0.0); FACTORS];
        (answers[0], answers[1]) = (answer(0.8), answer(0.8 * shares));
        vec![Coordinate {
            number: 1,
            sign: 1,
            stands_for: "roughness",
            answers,
            partial: None,
        }]
    };
    let all = [0.5, 0.2, 0.9, 0.4].map(seed);
    let [relief, other] = [Factor::ALL[0], Factor::ALL[1]];
    assert_eq!(relief, Factor::Relief);
    let found = spread(&all, 0, other).unwrap();
    let near = |value: f64, wanted: f64| assert!((value - wanted).abs() < 1e-12, "{found:?}");
    near(found.median, 0.45);
    near(found.least, 0.2);
    near(found.largest, 0.9);
    let odd = spread(&all[..3], 0, other).unwrap();
    assert!((odd.median - 0.5).abs() < 1e-12, "{odd:?}");
    assert_eq!(spread(&all, 1, other), None);
    assert_eq!(spread(&[], 0, other), None);
}
