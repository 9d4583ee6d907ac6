//! Joins on skeletons: points at one step, courses, the file of the model, the choice of the model, and the same answer for any spacing.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::command::{folder, stderr, willis};
use crate::refused::refused;
use willis::internals::candidates::features::Extraction;
use willis::internals::candidates::joins::features::{EndCourse, join_feature_names};
use willis::internals::candidates::joins::model::JoinModel;
use willis::internals::candidates::resample::{CenterlineKind, Resampled, step_of};
use willis::internals::network::{Network, Node, PathPoint, RadiusRule, Vessel};
use willis::internals::support::boosted_trees::RegressionTree;
use willis::internals::support::geometry::{Point, distance};

/// A network of separate vessels, each through points (mm) of a radius (mm).
pub fn vessels(lines: &[(Vec<Point>, f64)]) -> Network {
    let mut network = Network::new();
    for (points, radius) in lines {
        let path: Vec<PathPoint> =
            points.iter().map(|p| PathPoint { position: p.map(|x| x / 1e3), radius: radius / 1e3, id: None }).collect();
        let ends = [path[0], path[path.len() - 1]].map(|p| {
            let id = network.node_count().to_string();
            network.add_node(Node { id, position: Some(p.position), radius: Some(p.radius), ..Node::default() })
        });
        network.add_vessel(ends, Vessel::along(path, RadiusRule::Mean));
    }
    network
}

pub fn straight(from: Point, to: Point, steps: usize) -> Vec<Point> {
    (0..=steps).map(|i| [0, 1, 2].map(|k| from[k] + (to[k] - from[k]) * i as f64 / steps as f64)).collect()
}

#[test]
fn the_step_is_set_by_the_thin_quarter_of_the_length_and_not_by_the_points() {
    // 30 mm of radius 0.5 and 70 mm of radius 2: a quarter of 100 mm lies within the thin vessel.
    for steps in [1, 10, 500] {
        let network = vessels(&[
            (straight([0.0; 3], [30.0, 0.0, 0.0], steps), 0.5),
            (straight([0.0, 9.0, 0.0], [70.0, 9.0, 0.0], 3 * steps), 2.0),
        ]);
        assert!((step_of(&network, CenterlineKind::Skeleton) / (0.5e-3 * 2.0_f64.sqrt()) - 1.0).abs() < 1e-9, "{steps}");
    }
    // With 20 mm of the thin one a quarter reaches into the wide one.
    let network =
        vessels(&[(straight([0.0; 3], [20.0, 0.0, 0.0], 9), 0.5), (straight([0.0, 9.0, 0.0], [80.0, 9.0, 0.0], 9), 2.0)]);
    assert!((step_of(&network, CenterlineKind::Skeleton) / (2e-3 * 2.0_f64.sqrt()) - 1.0).abs() < 1e-9);
}

#[test]
fn the_step_of_a_tracing_is_set_by_the_volume_of_its_vessels() {
    // π 2² 70 mm³ and π 0.5² 30 mm³ are 903.2 mm³, a cube of 9.666 mm.
    let [thin, wide] = [(straight([0.0; 3], [30.0, 0.0, 0.0], 3), 0.5), (straight([0.0, 9.0, 0.0], [70.0, 9.0, 0.0], 3), 2.0)];
    let side = (std::f64::consts::PI * (4.0 * 70.0 + 0.25 * 30.0)).cbrt();
    let step = |lines: &[(Vec<Point>, f64)]| step_of(&vessels(lines), CenterlineKind::Tracing);
    assert!((step(&[thin.clone(), wide.clone()]) / (side / 30.0 * 1e-3) - 1.0).abs() < 1e-9);
    // One short wide vessel: a quarter of its radius. A long thin one: twice its radius.
    assert!((step(&[(straight([0.0; 3], [6.0, 0.0, 0.0], 3), 3.0)]) / 0.75e-3 - 1.0).abs() < 1e-9);
    assert!((step(&[(straight([0.0; 3], [2000.0, 0.0, 0.0], 3), 0.02)]) / 0.04e-3 - 1.0).abs() < 1e-9);
}

#[test]
fn points_lie_on_the_path_at_equal_distances_and_know_their_places() {
    // A right angle: 3 mm along x, 4 mm along y, of radius 1: five steps of 1.4 mm.
    let corner = vec![[0.0; 3], [3.0, 0.0, 0.0], [3.0, 4.0, 0.0]];
    let network = vessels(&[(corner, 1.0)]);
    let resampled = Resampled::new(&network, CenterlineKind::Skeleton);
    let path = &resampled.network.vessel(0).path;
    let truth = [[0.0, 0.0], [1.4, 0.0], [2.8, 0.0], [3.0, 1.2], [3.0, 2.6], [3.0, 4.0]];
    assert_eq!(path.len(), truth.len());
    for (n, (point, [x, y])) in path.iter().zip(truth).enumerate() {
        assert!(distance(point.position, [x / 1e3, y / 1e3, 0.0]) < 1e-12, "{n}: {:?}", point.position);
        let place = resampled.places[0][n];
        assert!(distance(place.on(&network.vessel(0).path).position, point.position) < 1e-15);
    }
    // The third place is 0.2 mm before the corner, the fourth behind it.
    assert_eq!([resampled.places[0][2].point, resampled.places[0][3].point], [0, 1]);
}

#[test]
fn a_course_knows_direction_and_curvature() {
    // A quarter of a circle of 20 mm in the plane, from (20, 0) to (0, 20), and of radius 0.5; its free end is left along -y.
    let arc: Vec<Point> =
        (0..=200).map(|i| f64::from(i) / 200.0 * FRAC_PI_2).map(|a| [20.0 * a.cos(), 20.0 * a.sin(), 0.0]).collect();
    let resampled = Resampled::new(&vessels(&[(arc, 0.5)]), CenterlineKind::Skeleton);
    let extraction = Extraction::new(&resampled.network, &[], resampled.step).expect("positions");
    let course = EndCourse::new(&extraction, 0);
    // It is fitted over 16 spacings and 6 radii; the chord of so long an arc turns by half of its angle from the tangent at the end.
    let half = 0.5 * (16.0 * resampled.step * 1e3 + 3.0) / 20.0;
    let off = |direction: Point| direction[0].atan2(-direction[1]);
    assert!(
        course.tip_direction[2].abs() < 1e-12 && (0.0..0.9 * half).contains(&off(course.tip_direction)),
        "{:?}",
        course.tip_direction
    );
    // The longer the stretch, the further its direction turns.
    let turns = course.directions.map(off);
    assert!(turns.windows(2).all(|w| 0.0 < w[0] && w[0] < w[1]) && turns[3] > half, "{turns:?} {half}");
    // Less than half of 1/20 mm, towards the centre: the ridge takes some.
    let bend = course.curvature[0] * 1e-3;
    assert!((-0.5 / 20.0..0.0).contains(&bend), "{bend}");
    assert!(course.length == course.first_run && (course.far_radius / course.tip_radius - 1.0).abs() < 1e-12);
}

#[test]
fn a_model_is_read_as_it_was_written_and_faults_are_named() {
    let shipped = JoinModel::shipped().expect("the model that ships");
    let mut bytes = Vec::new();
    shipped.write(&mut bytes).expect("memory");
    let text = String::from_utf8(bytes).expect("text");
    assert_eq!(JoinModel::read(&text).expect("a model"), *shipped);
    let wrong = |from: &str, to: &str, words: &[&str]| {
        let fault = JoinModel::read(&text.replacen(from, to, 1)).expect_err(from);
        let fault = fault.in_file(Path::new("model.toml")).to_string();
        for word in words {
            assert!(fault.contains(word), "{word}: {fault}");
        }
    };
    wrong("\"log_gap\"", "\"log_gasp\"", &["features", "\"log_gasp\"", "did you mean \"log_gap\""]);
    wrong("kind = \"skeleton\"", "kind = \"skeletons\"", &["model.toml:10: ", "\"skeletons\"", "\"skeleton\""]);
    wrong("trees = [\n    \"", "trees = [\n    \"9999<0 1 2\",\n    \"", &["pass 1 tree 1", "feature 9999"]);
    wrong("trees = [\n    \"", "trees = [\n    \"1<0 1\",\n    \"", &["do not match", "3<0.25 -0.1 0.2"]);
    wrong("calibration = [", "calibration = [nan, ", &["expected"]);
    assert_eq!(join_feature_names().len(), join_feature_names().iter().collect::<std::collections::BTreeSet<_>>().len());
}

/// The kept candidates of a run: the middle of each, in units of 0.1 mm, in order.
fn kept(folder: &Path) -> Vec<[i64; 3]> {
    let table = fs::read_to_string(folder.join("edges.csv")).expect("a table");
    let mut rows = table.lines();
    let columns: Vec<&str> = rows.next().expect("a heading").split(',').collect();
    let column = |name: &str| columns.iter().position(|c| *c == name).unwrap_or_else(|| panic!("{name}: {columns:?}"));
    let [origin, kept] = [column("origin"), column("kept")];
    let ends = ["ax_mm", "ay_mm", "az_mm", "bx_mm", "by_mm", "bz_mm"].map(column);
    let mut found: Vec<[i64; 3]> = rows
        .map(|row| row.split(',').collect::<Vec<_>>())
        .filter(|row| row[origin] == "candidate" && row[kept] == "1")
        .map(|row| {
            let at = |k: usize| row[ends[k]].parse::<f64>().expect("a number");
            [0, 1, 2].map(|k| (5.0 * (at(k) + at(k + 3))).round() as i64)
        })
        .collect();
    found.sort_unstable();
    found
}

/// The lines of an SWC file with points every so many mm.
fn respaced(text: &str, step: f64) -> String {
    let rows: Vec<Vec<f64>> = text
        .lines()
        .filter(|line| !line.starts_with('#') && !line.trim().is_empty())
        .map(|line| line.split_whitespace().map(|word| word.parse().expect("a number")).collect())
        .collect();
    let of_id: std::collections::HashMap<i64, &Vec<f64>> = rows.iter().map(|row| (row[0] as i64, row)).collect();
    let mut next = rows.iter().map(|row| row[0] as i64).max().unwrap_or(0);
    let mut out = String::new();
    for row in &rows {
        let mut parent = row[6] as i64;
        if let Some(from) = of_id.get(&parent) {
            let length = (2..5).map(|k| (row[k] - from[k]).powi(2)).sum::<f64>().sqrt();
            let pieces = (length / step).ceil().max(1.0) as i64;
            for piece in 1..pieces {
                let share = piece as f64 / pieces as f64;
                let [x, y, z, r] = [2, 3, 4, 5].map(|k| from[k] + share * (row[k] - from[k]));
                next += 1;
                writeln!(out, "{next} 0 {x} {y} {z} {r} {parent}").expect("memory");
                parent = next;
            }
        }
        writeln!(out, "{} 0 {} {} {} {} {parent}", row[0], row[2], row[3], row[4], row[5]).expect("memory");
    }
    out
}

#[test]
fn the_spacing_of_points_changes_no_decision() {
    let here = folder();
    let run = |arguments: &[&str]| {
        let done = willis(here.path(), arguments);
        assert!(done.status.success(), "{}", stderr(&done));
    };
    run(&["phantom", "tree", "--break", "--seed", "3", "-o", "tree.swc"]);
    let infer = |input: &str, output: &str, prior: &str| {
        run(&["infer", input, "-o", output, "--prior", prior, "-n", "1", "--force"]);
        kept(&here.path().join(output))
    };
    let text = fs::read_to_string(here.path().join("tree.swc")).expect("a file");
    for prior in ["weights:skeleton", "weights:tracing", "weights:tubes"] {
        let truth = infer("tree.swc", "whole", prior);
        assert!(truth.len() > 1, "{prior}: {truth:?}");
        for (name, step) in [("dense", 0.05), ("finer", 0.2)] {
            fs::write(here.path().join(format!("{name}.swc")), respaced(&text, step)).expect("a file");
            let found = infer(&format!("{name}.swc"), name, prior);
            assert_eq!(found.len(), truth.len(), "{prior}, {name}");
            for (a, b) in found.iter().zip(&truth) {
                assert!((0..3).all(|k| (a[k] - b[k]).abs() <= 1), "{prior}, {name}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn what_the_input_is_chooses_the_model() {
    let here = folder();
    let prior = |arguments: &[&str]| {
        let all = [&["infer"], arguments, &["-o", "out", "--force", "-n", "1"]].concat();
        let done = willis(here.path(), &all);
        assert!(done.status.success(), "{}", stderr(&done));
        let run = fs::read_to_string(here.path().join("out/run.json")).expect("a record");
        let run: serde_json::Value = serde_json::from_str(&run).expect("JSON");
        let run = &run["parameters"];
        (run["prior"].as_str().expect("a word").to_owned(), run["keep"].to_string())
    };
    for kind in ["fragments.swc", "scan.nii.gz"] {
        let made = willis(here.path(), &["phantom", "cerebral", "--break", "-o", kind]);
        assert!(made.status.success(), "{}", stderr(&made));
    }
    let tracing = "weights:tracing";
    assert_eq!(prior(&["fragments.swc"]).0, tracing);
    let (chosen, keep) = prior(&["scan.nii.gz"]);
    assert!(chosen == "weights:skeleton" && keep.contains("reconnect"), "{chosen} {keep}");
    let (_, keep) = prior(&["scan.nii.gz", "--cut", "never"]);
    assert!(keep.contains("best-first"), "{keep}");
    assert_eq!(prior(&["scan.nii.gz", "--prior", tracing]).0, tracing);
    assert_eq!(prior(&["fragments.swc", "--prior", "weights:auto"]).0, tracing);
    // A ladder of six rungs has five loops, more than arteries have; one of five has four.
    for (rungs, model) in [(6, "weights:skeleton"), (5, tracing)] {
        let mut swc = String::new();
        for rung in 0..rungs {
            let x = 4.0 * f64::from(rung);
            let parent = |id: i32| if rung > 0 { id - 2 } else { -1 };
            let id = 2 * rung + 1;
            writeln!(swc, "{id} 0 {x} 0 0 0.5 {}\n{} 0 {x} 5 0 0.5 {}", parent(id), id + 1, parent(id + 1)).expect("memory");
        }
        let mut loops = String::from("a,b\n");
        (0..rungs).for_each(|rung| writeln!(loops, "{},{}", 2 * rung + 1, 2 * rung + 2).expect("memory"));
        fs::write(here.path().join("ladder.swc"), swc).expect("a file");
        fs::write(here.path().join("ladder.loops.csv"), loops).expect("a file");
        assert_eq!(
            prior(&["ladder.swc", "--loops", "ladder.loops.csv", "--inlet", "3", "--outlet", "8"]).0,
            model,
            "{rungs} rungs"
        );
    }
    let swc = fs::read(here.path().join("fragments.swc")).expect("a file");
    let misspelt = ["infer", "fragments.swc", "-o", "no", "--prior", "weights:skelton"];
    refused(&[("fragments.swc", &swc)], &misspelt, &["weights:skeleton"]);
}

/// A vessel along x and branches along y, each from so many mm beside its axis, as separate lines.
fn drawn(offset: f64) -> String {
    let mut swc = String::new();
    let mut id = 0;
    let mut line = |from: [f64; 2], to: [f64; 2], radius: f64| {
        for step in 0..=40 {
            let [x, y] = [0, 1].map(|k| from[k] + (to[k] - from[k]) * f64::from(step) / 40.0);
            id += 1;
            writeln!(swc, "{id} 0 {x} {y} 0 {radius} {}", if step > 0 { id - 1 } else { -1 }).expect("memory");
        }
    };
    line([0.0, 0.0], [60.0, 0.0], 1.5);
    for branch in 0..5 {
        let (x, side) = (10.0 + 9.0 * f64::from(branch), f64::from(1 - 2 * (branch % 2)));
        line([x, side * offset], [x, side * 20.0], 0.8);
    }
    swc
}

#[test]
fn vessels_that_begin_inside_another_are_attached_to_its_axis() {
    let here = folder();
    let prior_of = |offset: f64| {
        fs::write(here.path().join("tubes.swc"), drawn(offset)).expect("a file");
        let done = willis(here.path(), &["infer", "tubes.swc", "-o", "out", "--force", "-n", "1"]);
        assert!(done.status.success(), "{}", stderr(&done));
        let run = fs::read_to_string(here.path().join("out/run.json")).expect("a record");
        let run: serde_json::Value = serde_json::from_str(&run).expect("JSON");
        run["parameters"]["prior"].as_str().expect("a word").to_owned()
    };
    // 0.7 mm from the axis of a vessel of 1.5 mm.
    assert_eq!(prior_of(0.7), "weights:tubes");
    let middles = kept(&here.path().join("out"));
    assert_eq!(middles.len(), 5, "{middles:?}");
    for (branch, middle) in middles.iter().enumerate() {
        let x = 100 + 90 * branch as i64;
        assert!((middle[0] - x).abs() <= 5 && middle[1].abs() <= 5, "{middles:?}");
    }
    // Outside it is a gap, as in a tracing.
    assert_eq!(prior_of(2.0), "weights:tracing");
}

#[test]
fn a_row_goes_left_below_the_value_of_a_split() {
    let tree = RegressionTree::try_from("1<0.5 0<-2 1 2 3".to_owned()).unwrap();
    let value = |row: [f32; 2]| tree.value(&row);
    assert_eq!([value([-3.0, 0.0]), value([-2.0, 0.0]), value([-3.0, 0.5])], [1.0, 2.0, 3.0]);
    assert_eq!(String::from(tree.clone()), "1<0.5 0<-2 1 2 3");
    for wrong in ["", "1<0.5 1", "1 2", "1<x 1 2", "nan", "-1<0 1 2"] {
        assert!(RegressionTree::try_from(wrong.to_owned()).is_err(), "{wrong}");
    }
    assert!(RegressionTree::try_from("0<0 ".repeat(100)).is_err());
}
