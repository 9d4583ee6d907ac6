//! The fit: against hand solutions, against SciPy on the same features, against the scorer of the benchmark.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{folder, stderr, willis};
use willis::internals::candidates::model::HeldOutScores;
use willis::internals::training::minimise::calibrate_in_order;
use willis::internals::training::minimise::minimise;
use willis::internals::training::{
    CandidateExample, Case, Example as _, FittedPass, Folds, Match, Objective, TrainParams, average_precision, calibrate,
    calibration_error, case_weights, fit, fold_of, goes_without_inlets,
};
use willis::internals::training::{Model, read_cases};

/// Broken trees as case folders `data/a0`, `data/a1`, ...
fn trees(here: &Path, count: usize) -> PathBuf {
    for seed in 0..count {
        let case = here.join(format!("data/a{seed}"));
        fs::create_dir_all(&case).expect("a folder");
        let output = case.join("fragments.swc").display().to_string();
        let made = willis(here, &["phantom", "tree", "--break", "--seed", &seed.to_string(), "-o", &output]);
        assert!(made.status.success(), "{}", stderr(&made));
    }
    here.join("data")
}

/// Two tubes in a line, 4 mm apart, and the truth in a word of JSON.
fn two_tubes(case: &Path, truth: &str) {
    fs::create_dir_all(case).expect("a folder");
    let mut swc = String::new();
    for x in 0..21 {
        let _ = writeln!(swc, "{} 0 {x} 0 0 1 {}", x + 1, if x == 0 { -1 } else { x });
    }
    for x in 0..21 {
        let _ = writeln!(swc, "{} 0 {} 0 0 1 {}", x + 22, x + 24, if x == 0 { -1 } else { x + 21 });
    }
    fs::write(case.join("fragments.swc"), swc).expect("a file");
    fs::write(case.join("truth.json"), truth).expect("a file");
}

fn cases(folder: &Path) -> Vec<Case> {
    read_cases(&[folder.to_owned()], Model::Tracing).expect("cases").cases
}

/// With all weights zero every explanation of n bridges between two fragments is as probable as another: one where both stand alone
/// and n where one hangs, k of them as they should.
#[test]
fn at_zero_weights_explanations_are_counted() {
    let here = folder();
    two_tubes(&here.path().join("data/line"), r#"{"inlets": [1], "breaks": [{"ids": [21, 22]}]}"#);
    let cases = cases(&here.path().join("data"));
    let example = CandidateExample::new(&cases[0], true).expect("bridges");
    let n = example.table.candidates.len();
    // Within two spacings of either loose end there are three points.
    let point =
        |row: usize| [example.extraction.ends[example.table.candidates[row].end].point, example.table.candidates[row].point];
    let at = |row: usize| point(row).map(|p| (example.extraction.position[p][0] * 1e3).round() as i32);
    let k = (0..n).filter(|row| at(*row)[0] == 24 && (18..=20).contains(&at(*row)[1])).count();
    assert_eq!(example.allowed, (0..n).map(|row| at(row)[0] == 24 && (18..=20).contains(&at(row)[1])).collect::<Vec<_>>());
    assert!(k > 0 && n > k);
    assert_eq!((cases[0].truth.needed(), example.reached()), (1, 1));
    let (examples, designs) = ([&example], [std::borrow::Cow::Borrowed(&example.table.features)]);
    let objective = Objective::new(&examples, &designs, 0.01);
    let zeros = vec![0.0; example.table.features.ncols() + example.table.root_features.ncols()];
    let (value, slope) = objective.at(&zeros);
    assert!((value - ((n + 1) as f64 / k as f64).ln()).abs() < 1e-12, "{value}");
    // The gradient is the slope of the objective.
    for row in 0..zeros.len() {
        let moved = |by: f64| {
            let mut y = zeros.clone();
            y[row] = by;
            objective.at(&y).0
        };
        assert!((slope[row] - (moved(1e-5) - moved(-1e-5)) / 2e-5).abs() < 1e-6, "feature {row}");
    }
}

/// Three of four links found, one of them twice, two wrong: by hand (1/1 + 2/3 + 3/5)/4; the second bridge of a link is passed over.
#[test]
fn average_precision_as_by_hand() {
    let right = |link, a, b| Some(Match { connection: link, pieces: [a, b] });
    let ranked = vec![
        (0.9, right(0, 0, 1)),
        (0.8, right(0, 1, 0)),
        (0.7, None),
        (0.6, right(1, 0, 1)),
        (0.5, None),
        (0.4, right(1, 2, 0)),
        (0.3, right(1, 2, 1)),
    ];
    assert!((average_precision(ranked, 4) - (1.0 + 2.0 / 3.0 + 3.0 / 5.0) / 4.0).abs() < 1e-15);
    // Tied: one right and one wrong share a threshold.
    assert_eq!(average_precision(vec![(0.5, None), (0.5, right(0, 0, 1))], 1), 0.5);
    assert_eq!(average_precision(Vec::new(), 3), 0.0);
    // Bins .1-.2 with |.15 - .5| and .9-1 with |.92 - 1|; .96 and .05 leave no doubt.
    let links = [(0.15, true), (0.15, false), (0.92, true), (0.96, false), (0.05, true)];
    let error = calibration_error(links.into_iter()).expect("doubt");
    assert!((error - (0.7 + 0.08) / 3.0).abs() < 1e-15, "{error}");
    assert_eq!(calibration_error([(0.99, true)].into_iter()), None);
}

/// Three tubes of which each belongs to the next in a ring: the likelihood takes no circle.
#[test]
fn a_circle_of_right_bridges_is_opened() {
    let here = folder();
    let mut swc = String::new();
    for (tube, id) in (0..3).map(|tube| (tube, tube * 13 + 1)) {
        let angle = |x: i32| f64::from(tube * 17 + x) / 51.0 * std::f64::consts::TAU;
        for x in 0..13 {
            let (sin, cos) = angle(x).sin_cos();
            let _ = writeln!(swc, "{} 0 {} {} 0 1 {}", id + x, 10.0 * cos, 10.0 * sin, if x == 0 { -1 } else { id + x - 1 });
        }
    }
    let case = here.path().join("data/ring");
    fs::create_dir_all(&case).expect("a folder");
    fs::write(case.join("fragments.swc"), &swc).expect("a file");
    let rows: Vec<Vec<f64>> =
        swc.lines().map(|l| l.split(' ').map(|x| x.parse().expect("a number")).collect::<Vec<f64>>()).collect();
    let nodes: Vec<String> = rows.iter().map(|r| format!("[{},{},{},1]", r[2], r[3], r[4])).collect();
    let link =
        |parent: u32, child: u32| format!(r#"[{{"role":"parent","allowed":[{parent}]}},{{"role":"child","allowed":[{child}]}}]"#);
    let links = [link(13, 14), link(26, 27), link(39, 1)].join(",");
    let truth = format!(r#"{{"subject":"S","voxel_mm":0.5,"nodes":[{}],"links":[{links}]}}"#, nodes.join(","));
    fs::write(case.join("truth.json"), truth).expect("a file");
    let cases = cases(&here.path().join("data"));
    assert_eq!((cases[0].subject.as_str(), cases[0].name.as_str()), ("S", "ring"));
    let example = CandidateExample::new(&cases[0], true).expect("bridges");
    assert_eq!((cases[0].truth.needed(), example.reached()), (3, 3));
    let hang: Vec<[usize; 2]> =
        (0..example.allowed.len()).filter(|r| example.allowed[*r]).map(|r| example.table.fragments[r]).collect();
    assert_eq!(hang.len(), 2, "{hang:?}");
    let (objective, ok) = (Vec::from([&example]), std::cell::Cell::new(false));
    let params = TrainParams { iterations: vec![200], ..TrainParams::default() };
    fit(&objective, &[], &params, &mut |step: &FittedPass| {
        ok.set(step.objective[1] > 0.0 && step.objective[1] < step.objective[0]);
    })
    .expect("weights");
    assert!(ok.get(), "a probability above one");
}

#[test]
fn subjects_keep_together_and_every_fold_gets_some() {
    let names: Vec<String> = (0..300).map(|n| format!("S{n}")).collect();
    let mut count = [0; 3];
    for name in &names {
        count[fold_of(name, 3)] += 1;
    }
    assert!(count.iter().all(|n| (70..130).contains(n)), "{count:?}");
    assert!(names.iter().all(|n| fold_of(n, 1) == 0));
    // Of few subjects as well, whose hashes leave folds empty: with s1 to s6 one of three.
    for subjects in 2..12 {
        let cases: Vec<Case> = (1..=subjects).map(|n| Case { subject: format!("s{n}"), ..Case::default() }).collect();
        for count in 2..=subjects {
            let folds = Folds::new(&cases, count).expect("folds");
            let taken: BTreeSet<usize> = cases.iter().map(|case| folds.of(&case.subject)).collect();
            assert_eq!(taken, (0..count).collect(), "{subjects}");
        }
    }
}

/// One gap of 4 mm between two tubes with points a millimetre apart, told several times and from either side; what lies nearer to an inlet is the parent,
/// whichever file names the inlet.
#[test]
fn a_connection_is_one_however_it_is_told() {
    let here = folder();
    let gap = r#""breaks": [{"ids": [21, 22]}]"#;
    let of = |name: &str, truth: &str, more: &[(&str, &str)]| {
        let case = here.path().join(name).join("line");
        two_tubes(&case, truth);
        if truth.is_empty() {
            fs::remove_file(case.join("truth.json")).expect("a file");
        }
        for (name, text) in more {
            fs::write(case.join(name), text).expect("a file");
        }
        read_cases(&[here.path().join(name)], Model::Tracing).map(|found| found.cases)
    };
    let links = |rows: &str| format!("ax_mm,ay_mm,az_mm,bx_mm,by_mm,bz_mm\n{rows}");
    let several = links("20,0,0,24,0,0\n24,0,0,20,0,0\n20,0,0,24,0,0\n19.8,0,0,24.2,0,0\n");
    for (name, truth, more) in
        [("once", format!("{{{gap}}}"), vec![]), ("several", String::new(), vec![("links.csv", several.as_str())])]
    {
        let cases = of(name, &truth, &more).expect("cases");
        let example = CandidateExample::new(&cases[0], true).expect("bridges");
        assert_eq!((cases[0].truth.needed(), example.reached()), (1, 1), "{name}");
    }
    let inlet = [("inlets.csv", "x_mm,y_mm,z_mm\n44,0,0\n")];
    let told = [
        of("none", &format!("{{{gap}}}"), &[]),
        of("there", &format!("{{\"inlets\": [42], {gap}}}"), &[]),
        of("beside", &format!("{{{gap}}}"), &inlet),
    ];
    let [none, there, beside] = told.map(|cases| cases.expect("cases")[0].truth.clone());
    assert!(there == beside && there != none);
    let nowhere = links("20,0,0,20.1,0,0\n");
    let why = of("point", "", &[("links.csv", nowhere.as_str())]).expect_err("no connection").to_string();
    assert!(why.contains("links.csv:2: both ends are at one point"), "{why}");
}

/// Trained on some trees, other trees of the same kind are told far better than by chance.
#[test]
fn what_was_learnt_holds_on_other_trees() {
    let here = folder();
    let cases = cases(&trees(here.path(), 12));
    let params = TrainParams { iterations: vec![40], ..TrainParams::default() };
    let known = cases[..8].iter();
    let examples: Vec<CandidateExample> = known
        .map(|case| CandidateExample::new(case, !goes_without_inlets(case, params.without_inlets)).expect("positions"))
        .collect();
    let weights = fit(&examples.iter().collect::<Vec<_>>(), &[], &params, &mut |_| ()).expect("weights");
    assert_eq!((weights.provenance.cases, weights.provenance.subjects), (8, 8));
    let judged: Vec<CandidateExample> = cases[8..].iter().map(|c| CandidateExample::new(c, true).expect("bridges")).collect();
    let answers: Vec<_> = judged.iter().flat_map(|e| e.judge(&weights).expect("features")).collect();
    let of: Vec<_> = judged.iter().zip(&answers).collect();
    let HeldOutScores { average_precision, cases, .. } = CandidateExample::scores(&of)[0].clone();
    assert!(cases == 4 && average_precision.expect("links") > 0.6, "{average_precision:?}");
}

/// The python with its packages, or a line that says why not.
fn python() -> Option<String> {
    let python = std::env::var("WILLIS_PYTHON").ok();
    if python.is_none() {
        eprintln!("skipped: WILLIS_PYTHON names no Python with tests/requirements.txt");
    }
    python
}

fn run(python: &str, script: &str, arguments: &[&str]) -> Vec<Vec<f64>> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/training").join(script);
    let output = Command::new(python).arg(script).args(arguments).output().expect("runs");
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).expect("text");
    text.lines().map(|l| l.split_whitespace().map(|x| x.parse().expect("a number")).collect()).collect()
}

fn table<'a>(rows: impl IntoIterator<Item = Vec<f64>> + 'a) -> String {
    rows.into_iter().map(|r| r.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(",") + "\n").collect()
}

#[test]
fn optimum_and_calibration_are_those_of_scipy() {
    let Some(python) = python() else { return };
    let here = folder();
    let cases = cases(&trees(here.path(), 5));
    let measured: Vec<CandidateExample> = cases.iter().map(|c| CandidateExample::new(c, true).expect("bridges")).collect();
    let examples: Vec<&CandidateExample> = measured.iter().collect();
    let params = TrainParams { iterations: vec![3000], ..TrainParams::default() };
    let mut least = f64::NAN;
    let weights = fit(&examples, &[], &params, &mut |step| least = step.objective[1]).expect("weights");
    let put = |name: &str, text: String| fs::write(here.path().join(name), text).expect("a file");
    for (k, e) in examples.iter().enumerate() {
        let bridges = (0..e.table.candidates.len()).map(|row| {
            let [child, parent] = e.table.fragments[row];
            let head = [child as f64, parent as f64, f64::from(u8::from(e.allowed[row]))];
            head.into_iter().chain(e.table.features.row(row).to_vec()).collect()
        });
        put(&format!("{k}.bridges.csv"), table(bridges));
        put(&format!("{k}.roots.csv"), table(e.table.root_features.rows().into_iter().map(|r| r.to_vec())));
    }
    put("weights.csv", table(case_weights(&examples).into_iter().map(|w| vec![w])));
    put("ours.csv", table(weights.passes[0].candidate.iter().chain(&weights.passes[0].root).map(|w| vec![*w])));
    // Probabilities on both sides of one half, right more often than they say.
    let links: Vec<(f64, bool, f64)> = (0..400)
        .map(|i| {
            let p = (f64::from(i) + 0.5) / 400.0;
            (p, f64::from(i * 7919 % 400) / 400.0 < p.sqrt(), 1.0 + f64::from(i % 3))
        })
        .collect();
    put("links.csv", table(links.iter().map(|(p, right, w)| vec![*p, f64::from(u8::from(*right)), *w])));
    let found = run(&python, "optimum.py", &[&here.path().display().to_string(), &params.l2.to_string()]);
    let [scipys, ours_by_scipy] = found[0][..] else { panic!("{found:?}") };
    assert!((ours_by_scipy - least).abs() < 1e-9, "the same objective: {ours_by_scipy} {least}");
    assert!(least < scipys + 1e-6 && least > 0.0, "{least} {scipys}");
    let (ours, []) = calibrate(links.into_iter().map(|(p, right, weight)| (p, [], right, weight)));
    for (a, b) in ours.iter().zip(&found[1]) {
        assert!((a - b).abs() < 1e-4 * b.abs().max(1.0), "{ours:?} {:?}", found[1]);
    }
}

#[test]
fn right_links_are_those_of_the_benchmark() {
    let Some(python) = python() else { return };
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    if !shared.join("gapbench/score.py").exists() {
        eprintln!("skipped: no {}", shared.display());
        return;
    }
    let here = folder();
    let (shared, out) = (shared.display().to_string(), here.path().display().to_string());
    run(&python, "marks.py", &[&shared, &out, "BG0002", "BG06", "INSIST_0027", "INSIST_0038"]);
    let cases = read_cases(&[here.path().join("brava"), here.path().join("ring")], Model::Tracing).expect("cases").cases;
    assert_eq!(cases.len(), 4);
    let (mut pairs, mut ours) = (String::new(), Vec::new());
    for case in &cases {
        let e = CandidateExample::new(case, true).expect("bridges");
        for bridge in &e.table.candidates {
            let ends = [e.extraction.ends[bridge.end].point, bridge.point];
            let at: Vec<String> = ends.iter().flat_map(|p| e.extraction.position[*p]).map(|x| (x * 1e3).to_string()).collect();
            let _ = writeln!(pairs, "{}/{},{}", case.data_set, case.name, at.join(","));
            ours.push(case.truth.matching(ends[0], ends[1]));
        }
    }
    fs::write(here.path().join("pairs.csv"), pairs).expect("a file");
    let needed = run(&python, "marks.py", &[&shared, &out]);
    assert_eq!(needed[0], cases.iter().map(|c| c.truth.needed() as f64).collect::<Vec<_>>());
    let marks = fs::read_to_string(here.path().join("marks.csv")).expect("a table");
    let theirs: Vec<Vec<i32>> = marks.lines().map(|l| l.split(',').map(|x| x.parse().expect("a number")).collect()).collect();
    assert_eq!(theirs.len(), ours.len());
    assert!(ours.iter().flatten().count() > 100);
    for (ours, theirs) in ours.iter().zip(&theirs) {
        let ours = ours.map_or([-1; 3], |r| [r.connection, r.pieces[0], r.pieces[1]].map(|x| x as i32));
        assert_eq!(ours.to_vec(), *theirs);
    }
}

/// Rosenbrock's valley in 10 dimensions has its floor, 0, at (1, ..., 1).
#[test]
fn the_floor_of_rosenbrocks_valley_is_found() {
    let valley = |x: &[f64]| {
        let value = x.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum();
        let mut gradient = vec![0.0; x.len()];
        for (i, w) in x.windows(2).enumerate() {
            let t = w[1] - w[0] * w[0];
            gradient[i] += -400.0 * t * w[0] - 2.0 * (1.0 - w[0]);
            gradient[i + 1] += 200.0 * t;
        }
        (value, gradient)
    };
    let start: Vec<f64> = (0..10).map(|i| if i % 2 == 0 { -1.2 } else { 1.0 }).collect();
    let found = minimise(start.clone(), 500, &valley);
    assert!(found.value < 1e-8 && found.point.iter().all(|x| (x - 1.0).abs() < 1e-3), "{found:?}");
    let few = minimise(start.clone(), 3, &valley);
    assert!(few.value < valley(&start).0 && few.evaluations < found.evaluations);
}

#[test]
fn a_function_without_a_number_leaves_the_start() {
    let start = vec![1.0, 2.0];
    let found = minimise(start.clone(), 10, &|x| (f64::NAN, vec![f64::NAN; x.len()]));
    assert_eq!(found.point, start);
}

/// So many pairs of this probability, of which so many are right.
fn pairs(p: f64, count: usize, right: usize) -> impl Iterator<Item = (f64, bool)> {
    (0..count).map(move |n| (p, n < right))
}

#[test]
fn a_calibration_gives_the_shares_that_were_found_and_keeps_the_order() {
    // Odds 1/4 are found to be 1, odds 1 to be 4: a = ln 4, b = 1.
    let found = calibrate_in_order(&pairs(0.2, 100, 50).chain(pairs(0.5, 100, 80)).collect::<Vec<_>>()).expect("two shares");
    assert!((found[0] - 4.0_f64.ln()).abs() < 1e-3 && (found[1] - 1.0).abs() < 1e-3, "{found:?}");
    // What would turn the order round says nothing: all have the share of all.
    let turned = calibrate_in_order(&pairs(0.2, 100, 80).chain(pairs(0.5, 100, 40)).collect::<Vec<_>>()).expect("two shares");
    assert!((turned[0] - 1.5_f64.ln()).abs() < 1e-3 && turned[1].abs() < 1e-12, "{turned:?}");
    assert_eq!(calibrate_in_order(&[]), None);
}
