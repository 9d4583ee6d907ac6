//! The prior: weights as files, and what they make of fragments, solved by hand.

use crate::extracted::extracted;
use willis::internals::candidates::features::{FEATURES, ROOT_FEATURES};
use willis::internals::candidates::model::{
    CLOSURE_FEATURES, Calibration, Fold, HeldOutScores, PassWeights, Usual, Weights, posterior,
};
use willis::internals::candidates::search::{SearchOptions, search};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::{Network, RadiusRule, contract};
use willis::internals::support::model_provenance::ModelProvenance;

/// Straight tubes along x, a point a millimetre: from, to (mm), radius (mm).
fn tubes(tubes: &[(u32, u32, f64)]) -> Network {
    let mut lines = Centerlines::default();
    for (from, to, radius) in tubes {
        for x in *from..=*to {
            let point = lines.points.len() as u32;
            lines.add_point([f64::from(x) * 1e-3, 0.0, 0.0], radius * 1e-3, u64::from(point) + 1, 0);
            if x > *from {
                lines.add_link([point - 1, point], "");
            }
        }
    }
    contract(&lines, RadiusRule::Mean, None).expect("vessels").network
}

/// Weights of one pass that are zero but for those named.
fn weights(bridge: &[(&str, f64)], root: &[(&str, f64)]) -> Weights {
    let fill = |names: Vec<&str>, given: &[(&str, f64)]| {
        assert!(given.iter().all(|(name, _)| names.contains(name)));
        names.iter().map(|n| given.iter().find(|(name, _)| name == n).map_or(0.0, |(_, w)| *w)).collect()
    };
    let pass = PassWeights {
        candidate: fill(FEATURES.iter().map(|(n, _)| *n).collect(), bridge),
        root: fill(ROOT_FEATURES.iter().map(|(n, _)| *n).collect(), root),
    };
    Weights {
        passes: vec![pass],
        calibration: [0.0, 1.0, 0.0],
        of_input: [0.0; 3],
        usual: None,
        closure: Vec::new(),
        provenance: ModelProvenance::default(),
        figures: Vec::new(),
        folds: Vec::new(),
    }
}

/// Two fragments in a line: no hanging, one on the other, or the other way round, so Z = v² + v Σ w. A bridge weighs exp(-d/D) by
/// a weight of -1 on d/D, at most 10, a root 3 by ln 3 on the constant; D = 2r + h.
#[test]
fn two_fragments_in_a_line_as_by_hand() {
    let network = tubes(&[(0, 20, 1.0), (24, 44, 1.0)]);
    let extraction = extracted(&network, &[]).expect("positions");
    let bridges = search(&extraction, &SearchOptions::default()).unwrap();
    let found = posterior(&extraction, &bridges, &weights(&[("gap", -1.0)], &[("one", 3_f64.ln())])).expect("weights");
    let weight = |row: usize| {
        let ends = [extraction.ends[found.table.candidates[row].end].point, found.table.candidates[row].point]
            .map(|p| extraction.position[p][0]);
        (-((ends[0] - ends[1]).abs() * 1e3 / 3.0).min(10.0)).exp()
    };
    let rows = 0..found.table.candidates.len();
    let total = 9.0 + 3.0 * rows.clone().map(weight).sum::<f64>();
    let facing = |row: &usize| (weight(*row) - (-4.0_f64 / 3.0).exp()).abs() < 1e-9;
    assert_eq!(rows.clone().filter(facing).count(), 2, "the facing ends see each other");
    for row in rows.clone() {
        let same: f64 = rows.clone().filter(|r| found.table.pairs.of[*r] == found.table.pairs.of[row]).map(weight).sum();
        assert!((found.marginals.edges[row] - 3.0 * weight(row) / total).abs() < 1e-12);
        assert!((found.probability[row] - 3.0 * same / total).abs() < 1e-11, "one probability for both directions");
    }
    let calibrated = Weights { calibration: [1.0, 2.0, 0.0], ..weights(&[("gap", -1.0)], &[("one", 3_f64.ln())]) };
    let again = posterior(&extraction, &bridges, &calibrated).expect("weights");
    assert_eq!(again.marginals, found.marginals);
    for (p, q) in found.probability.iter().zip(&again.probability) {
        assert!((q / (1.0 - q) - 1_f64.exp() * (p / (1.0 - p)).powi(2)).abs() < 1e-9);
    }
    // A of the two fragments hang on the other one, and few are few: m = ln((A + 1)/(3 - A)), s = 10/12.
    let moved = Weights { of_input: [0.5, -1.0, 2.0], ..calibrated };
    let again = posterior(&extraction, &bridges, &moved).expect("weights");
    let hanging = (total - 9.0) / total;
    let (m, s) = (((hanging + 1.0) / (3.0 - hanging)).ln(), 10.0 / 12.0);
    for (p, q) in found.probability.iter().zip(&again.probability) {
        let odds = (1.0 + 0.5 * m - s + 2.0 * m * s).exp() * (p / (1.0 - p)).powi(2);
        assert!((q / (1.0 - q) / odds - 1.0).abs() < 1e-9);
    }
}

/// e⁷⁰ cannot be: log weights end at ±25.
#[test]
fn log_weights_are_cut() {
    let network = tubes(&[(0, 20, 1.0), (24, 44, 1.0)]);
    let extraction = extracted(&network, &[]).expect("positions");
    let bridges = search(&extraction, &SearchOptions::default()).unwrap();
    let found = posterior(&extraction, &bridges, &weights(&[("is_end", 70.0)], &[("one", -70.0)])).expect("weights");
    assert!(found.forests.log_roots().iter().all(|w| *w == -25.0));
    assert!(found.forests.edges().iter().all(|b| [0.0, 25.0].contains(&b.log_weight)));
}

/// Numbers that a decimal notation with few digits would lose.
fn odd() -> Weights {
    let figures = HeldOutScores {
        of: "a \"set\"\\of\u{7f}".into(),
        cases: 3,
        subjects: 2,
        average_precision: Some(1.0 / 3.0),
        calibration_error: None,
        log_likelihood: -12.5,
    };
    let pass = |number: usize| PassWeights {
        candidate: PassWeights::candidate_features(number)
            .enumerate()
            .map(|(i, _)| (i as f64 + 0.1).sin() * 10_f64.powi(i as i32 % 9 - 6))
            .collect(),
        root: PassWeights::root_features().enumerate().map(|(i, _)| -(i as f64) / 7.0).collect(),
    };
    Weights {
        passes: (0..3).map(pass).collect(),
        calibration: [0.1, 1.0 + f64::EPSILON, -1e-300],
        of_input: [0.5, -0.25, 3.0],
        usual: Some(Usual([[3.0, 250.0], [0.1, 1.0 / 3.0], [0.7, 2.0], [0.0, 0.6]])),
        closure: (0..CLOSURE_FEATURES.len()).map(|i| 0.3 * i as f64 - 1.0).collect(),
        provenance: ModelProvenance {
            cases: 3,
            subjects: 2,
            made_by: "willis train 'a\tb' -o \"w\"".into(),
            held_out: vec!["A".into(), "B".into()],
        },
        figures: vec![figures.clone()],
        folds: vec![Fold { held_out: vec!["C".into()], figures: vec![figures.clone(), figures] }, Fold::default()],
    }
}

fn written(weights: &Weights) -> String {
    let mut out = Vec::new();
    weights.write(&mut out).expect("memory");
    String::from_utf8(out).expect("text")
}

#[test]
fn weights_are_read_back_to_the_last_bit() {
    let weights = odd();
    assert_eq!(Weights::read(&written(&weights)), Ok(weights));
}

#[test]
fn the_shipped_weights_are_whole() {
    let shipped = Weights::shipped().expect("the file in the program");
    assert!(shipped.provenance.cases > 0 && !shipped.provenance.made_by.is_empty());
    // Near, straight and end to end is more probable than far, bent and sideways.
    let at = |name: &str| FEATURES.iter().position(|(n, _)| *n == name).expect(name);
    assert!(shipped.passes[0].candidate[at("is_end")] > 0.0);
    assert!(Calibration(shipped.calibration).apply(0.9) > Calibration(shipped.calibration).apply(0.1));
}

#[test]
fn a_wrong_name_or_number_is_named() {
    let good = written(&odd());
    let fails = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        let fault = Weights::read(&good.replacen(from, to, 1)).expect_err(to);
        let said = fault.in_file("w.toml".as_ref()).to_string();
        assert!(!said.contains('\n'), "{said}");
        said
    };
    let line = |name: &str| good.lines().find(|l| l.starts_with(&format!("{name} = "))).expect(name).to_owned();
    let gap = line("gap");
    let says = |said: String, words: &[&str]| assert!(words.iter().all(|w| said.contains(w)), "{said}");
    says(fails(&gap, "gapp = 1.0"), &["w.toml: pass 1 bridge", "gap;"]);
    says(fails(&gap, &format!("{gap}\ngapp = 1.0")), &["pass 1 bridge", "\"gapp\"", "did you mean \"gap\"?"]);
    says(fails(&gap, &format!("{gap}\n{gap}")), &["w.toml:", "duplicate key"]);
    says(fails(&gap, "gap = nan"), &["pass 1 bridge gap NaN"]);
    says(fails(&gap, "gap = 1e9"), &["pass 1 bridge gap 1000000000"]);
    says(fails(&gap, "gap = \"wide\""), &["w.toml:", "wide"]);
    says(fails(&line("one"), "two = 1.0"), &["pass 1 root", "one"]);
    says(fails("calibration = [0.1,", "calibration = [inf,"), &["calibration inf"]);
    says(fails("calibration = [0.1,", "calibration = ["), &["w.toml:"]);
    says(fails("[provenance]", "[origin]"), &["origin"]);
    says(Weights::read("calibration = [0.0, 1.0, 0.0]\npass = []").expect_err("no pass").found, &["no pass"]);
    says(Weights::read("\u{1}").expect_err("not TOML").found, &[]);
}

#[test]
fn weights_of_other_features_are_no_panic() {
    let network = tubes(&[(0, 20, 1.0), (24, 44, 1.0)]);
    let extraction = extracted(&network, &[]).expect("positions");
    let bridges = search(&extraction, &SearchOptions::default()).unwrap();
    let mut short = weights(&[], &[]);
    short.passes[0].candidate.pop();
    let said = posterior(&extraction, &bridges, &short).expect_err("too few").to_string();
    assert!(said.starts_with("pass 1 bridge has ") && said.ends_with(&format!("expected {}", FEATURES.len())), "{said}");
    short.passes.clear();
    assert!(posterior(&extraction, &bridges, &short).is_err());
}

#[test]
fn odds_are_raised_to_the_slope_of_their_side() {
    let map = Calibration([0.0, 2.0, -1.0]);
    // Odds 4 become 16; odds 1/4 keep a slope of 2 - 1 = 1.
    assert!((map.apply(0.8) - 16.0 / 17.0).abs() < 1e-15 && (map.apply(0.2) - 0.2).abs() < 1e-15);
    assert_eq!([map.apply(0.0), map.apply(0.5)], [0.0, 0.5]);
    assert!(map.apply(1.0) <= 1.0 && map.apply(1.0) > 1.0 - 1e-12);
}

fn usual(fragments: f64, variation: f64) -> Usual {
    Usual([fragments, 2.0, 1.5, variation].map(|x| [x; 2]))
}

#[test]
fn what_no_case_had_is_told_with_its_figure_and_the_range() {
    let seen = usual(3.0, 0.1).with(usual(250.0, 0.3));
    assert_eq!(usual(3.0, 0.3).unlike(seen), None);
    let told = usual(1204.0, 0.2).unlike(seen).expect("a note");
    assert!(told.contains("1204 fragments (there 3 to 250)") && !told.contains("variation"), "{told}");
    assert!(usual(9.0, 0.05).unlike(seen).expect("a note").contains("0.05 variation of the radius (there 0.10 to 0.30)"));
}
