//! Names from geometry on the tracings of patients whose arteries are labelled (skipped where they are absent): the truth is the table of vessels
//! beside each tracing, and that names do not depend on the frame and the pose. Of the drawn circle, the phantom knows where its arteries end.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::command::{folder, stderr, willis as command};
use crate::refused::refused;
use willis::internals::circle_of_willis::{Artery, BodySide};
use willis::internals::naming::algebra::{UNIT, full, inverse, product, rotation, rotation_vector, times, trace_of_product};
use willis::internals::naming::atlas::{
    ArteryLabel, Atlas, BA, LABELS, NOWHERE, OTHER, STATES, StateTables, all_states, artery_of, first_state, label_named,
    label_of, mirrored, name_of, state_at,
};
use willis::internals::naming::belief::NamingForest;
use willis::internals::naming::emission::{Pose, Search, Single};
use willis::internals::naming::nodes::Bridge;
use willis::internals::naming::presence::ways;
use willis::internals::naming::{NamingModel, NamingModels, Nodes};
use willis::internals::network::{Frame, Network, Origin, RadiusRule, Vessel, fragments};
use willis::internals::support::arc_lengths::{arc_lengths, in_direction};
use willis::internals::support::geometry::distance;
use willis::{InferOptions, Input, ReadOptions, Silent, label, read};

fn patients() -> Vec<PathBuf> {
    let shared = std::env::var_os("WILLIS_SHARED_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    let folder = shared.join("insist-cow");
    let Ok(entries) = fs::read_dir(&folder) else {
        println!("skipped: there is no {}", folder.display());
        return Vec::new();
    };
    let mut found: Vec<PathBuf> =
        entries.flatten().map(|e| e.path().join("tracing_ves_TH_XX_X.swc")).filter(|p| p.is_file()).collect();
    found.sort();
    found
}

fn tracing(path: &Path) -> Input {
    let spacing = fs::read_to_string(path.with_file_name("Image_info.txt")).expect("info");
    let spacing = spacing.lines().find_map(|line| line.trim().strip_prefix("Voxel spacing:")).expect("spacing");
    let mm: f64 = spacing.split_whitespace().next().expect("a number").parse().expect("a number");
    let scale = willis::Scale { unit: willis::LengthUnit::Voxel, spacing: Some([mm; 3]) };
    read(path, &ReadOptions { scale, ..ReadOptions::default() }).expect("a tracing")
}

/// The network without labels, its positions turned.
fn turned(network: &Network, turn: impl Fn([f64; 3]) -> [f64; 3]) -> Network {
    let mut network = network.clone();
    for row in 0..network.node_count() {
        let node = network.node_mut(row);
        node.position = node.position.map(&turn);
    }
    for row in 0..network.vessel_count() {
        let vessel = network.vessel_mut(row);
        vessel.label.clear();
        for point in &mut vessel.path {
            point.position = turn(point.position);
        }
    }
    network
}

/// The share of the length of named vessels (mm) that has the name of the table, M2 and M3 being M1 there.
fn right(network: &Network, of: &BTreeMap<usize, String>) -> f64 {
    let (mut right, mut all) = (0.0, 0.0);
    for (row, (_, vessel)) in network.vessels().enumerate().filter(|(_, (_, v))| v.origin == Origin::Observed) {
        let Some(said) = of.get(&row).filter(|_| !vessel.label.is_empty()) else { continue };
        let one = |name: &str| name.replace("M2", "M1").replace("M3", "M1");
        all += vessel.length;
        right += if one(said) == one(&vessel.label) { vessel.length } else { 0.0 };
    }
    right / all
}

/// The name of most of each vessel.
fn names(network: &Network) -> BTreeMap<usize, String> {
    names_by(&NamingModels::shipped().expect("models"), network)
}

fn names_by(models: &NamingModels, network: &Network) -> BTreeMap<usize, String> {
    let names = models.name(network).expect("names");
    let mut sums: BTreeMap<usize, [f64; LABELS]> = BTreeMap::new();
    for n in 0..names.nodes.len() {
        let sum = sums.entry(names.nodes.place[n].vessel).or_insert([0.0; LABELS]);
        (0..LABELS).for_each(|label| sum[label] += names.labels[n][label] * names.nodes.weight[n]);
    }
    let best = |sum: &[f64; LABELS]| (0..LABELS).fold(0, |best, label| if sum[label] > sum[best] { label } else { best });
    sums.iter().map(|(vessel, sum)| (*vessel, name_of(best(sum)))).collect()
}

#[test]
fn names_are_those_of_the_table_in_every_frame_and_pose() {
    for path in patients().iter().take(4) {
        let whole = tracing(path).network;
        let plain = names(&turned(&whole, |p| p));
        assert!(right(&whole, &plain) > 0.85, "{}: {}", path.display(), right(&whole, &plain));
        // The file is in LPS; half a turn about the vertical axis makes it RAS.
        let mut ras = turned(&whole, |[x, y, z]| [-x, -y, z]);
        assert_eq!(names(&ras), plain, "{}", path.display());
        ras.frame = Frame::Ras;
        assert_eq!(names(&ras), plain, "{}", path.display());
        let (s, c) = 15_f64.to_radians().sin_cos();
        let tilted = names(&turned(&whole, |[x, y, z]| [x + 0.1, c * y - s * z - 0.2, s * y + c * z]));
        assert!(right(&whole, &tilted) > 0.85, "{} tilted", path.display());
        // Left and right come from the axes.
        let mirrored = names(&turned(&whole, |[x, y, z]| [-x, y, z]));
        let other = |name: &String| match name.split_at_checked(2) {
            Some(("L-", rest)) => format!("R-{rest}"),
            Some(("R-", rest)) => format!("L-{rest}"),
            _ => name.clone(),
        };
        let same = plain.iter().filter(|(vessel, name)| mirrored.get(vessel) == Some(&other(name))).count();
        assert!(10 * same >= 9 * plain.len(), "{}: {same} of {}", path.display(), plain.len());
    }
}

/// Labelled vessels together are as long as those of the input, and landmarks lie on them.
#[test]
fn nothing_of_a_tracing_is_lost_by_its_labels() {
    for path in patients().iter().take(2) {
        let input = tracing(path);
        let long = |network: &Network| network.vessels().map(|(_, vessel)| vessel.length).sum::<f64>();
        let before = long(&input.network);
        let found = label(input, &InferOptions::default(), &mut Silent).expect("labels");
        assert!((long(&found.network) / before - 1.0).abs() < 1e-6, "{} {before}", long(&found.network));
        assert!(found.network.vessels().filter(|(_, vessel)| !vessel.label.is_empty()).count() > 8);
        assert!(found.probability.iter().flatten().all(|p| (0.0..=1.0).contains(p)));
        assert!(!found.landmarks.is_empty());
    }
}

/// The circle that the phantom draws, whole, read by a rule for radii.
fn drawn(radius_rule: RadiusRule) -> Input {
    let here = folder();
    let output = command(here.path(), &["phantom", "cerebral", "-o", "whole.swc"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    read(&here.path().join("whole.swc"), &ReadOptions { radius_rule, ..ReadOptions::default() }).expect("a circle")
}

/// What a graph states of its vessels is theirs when they have names, be they divided by names or not: lengths that are not those of straight
/// lines, and resistances. Where nothing says which vessels are observed, all are there.
#[test]
fn what_a_graph_states_is_kept_under_its_names() {
    for origin in [Origin::Observed, Origin::Candidate] {
        let mut stated = drawn(RadiusRule::Mean).network;
        for row in 0..stated.vessel_count() {
            let vessel = stated.vessel_mut(row);
            (vessel.resistance, vessel.origin) = (Some(1e9 + 1e7 * row as f64), origin);
            vessel.path.clear();
            vessel.label.clear();
        }
        let found = label(Input::from_network(stated.clone()), &InferOptions::default(), &mut Silent).expect("labels").network;
        assert!(found.vessel_count() >= stated.vessel_count() && found.vessels().any(|(_, vessel)| vessel.label == "L-A1"));
        let figures: [fn(&Vessel) -> f64; 2] = [|vessel| vessel.length, |vessel| vessel.resistance.unwrap_or(0.0)];
        for of in figures {
            let [before, after] = [&stated, &found].map(|network| network.vessels().map(|(_, v)| of(v)).sum::<f64>());
            assert!((after / before - 1.0).abs() < 1e-9, "{origin:?}: {before} {after}");
        }
    }
}

/// The rule of radii is that of the whole program, eq. 1 or Poiseuille's law along the points, also of vessels that names divide.
#[test]
fn labelled_vessels_have_radii_by_the_rule_that_was_asked_for() {
    for rule in [RadiusRule::Mean, RadiusRule::Effective] {
        let found = label(drawn(rule), &InferOptions::default(), &mut Silent).expect("labels").network;
        for (_, vessel) in found.vessels() {
            assert!((vessel.radius / rule.radius(&vessel.path) - 1.0).abs() < 1e-9, "{rule:?}: {vessel:?}");
        }
    }
}

/// A vessel changes its name twice between two points that are far apart: each name has the length that the table of names gives it, to
/// some mm, for that has a row a millimetre.
#[test]
fn names_divide_a_vessel_between_its_points() {
    let here = folder();
    let output = command(here.path(), &["phantom", "cerebral", "--without", "L-P1,R-PComm", "-o", "a.swc"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = fs::read_to_string(here.path().join("a.swc")).expect("read");
    // Without the names of the arteries, which would divide it.
    let nameless: Vec<&str> = text.lines().filter(|line| !line.starts_with("# label")).collect();
    fs::write(here.path().join("a.swc"), nameless.join("\n")).expect("written");
    let mut sparse = read(&here.path().join("a.swc"), &ReadOptions::default()).expect("a circle").network;
    // From where the vertebral arteries meet one vessel is the basilar artery, 29 mm, R-P1, 5 mm, and R-P2. Between 20 and 45 mm it has no point.
    let begins = |at: [f64; 3]| distance(at, [0.0, -0.017, 0.172]) < 1e-4;
    let is_it = |vessel: &Vessel| (0.11..0.13).contains(&vessel.length) && vessel.path.iter().any(|point| begins(point.position));
    let row = sparse.vessels().position(|(_, vessel)| is_it(vessel)).expect("a vessel");
    let vessel = sparse.vessel_mut(row);
    let forward = begins(vessel.path[0].position);
    let mut path = in_direction(vessel.path.clone(), forward);
    let mut arc = arc_lengths(path.iter().map(|point| point.position)).into_iter();
    path.retain(|_| arc.next().is_some_and(|along| !(0.02..0.045).contains(&along)));
    *vessel = Vessel::along(in_direction(path, forward), RadiusRule::Mean);
    let found = label(Input::from_network(sparse), &InferOptions::default(), &mut Silent).expect("labels");
    let (mut told, mut drawn) = (BTreeMap::new(), BTreeMap::new());
    for (name, length) in found.names.best().iter().zip(&found.names.nodes.weight) {
        *told.entry(if *name == OTHER { String::new() } else { name_of(*name) }).or_insert(0.0) += length;
    }
    for (_, vessel) in found.network.vessels() {
        *drawn.entry(vessel.label.clone()).or_insert(0.0) += 1e3 * vessel.length;
    }
    assert!(told.contains_key("R-P1") && told.contains_key("R-P2"));
    for (name, length) in told {
        let drawn = drawn.get(&name).copied().unwrap_or(0.0);
        assert!(f64::abs(length - drawn) < 4.0, "{name}: {length} and {drawn} mm");
    }
}

/// Where a name changes there is a new node, with an id that no node of the input has.
#[test]
fn no_id_comes_twice_where_names_divide_a_vessel() {
    let mut input = drawn(RadiusRule::Mean);
    let labelled = |input: &Input| label(input.clone(), &InferOptions::default(), &mut Silent).expect("labels").network;
    let new = labelled(&input).nodes().find(|node| node.id.contains('~')).expect("a new node").id.clone();
    let free = (0..input.network.node_count()).find(|row| !new.starts_with(&input.network.node(*row).id)).expect("a node");
    input.network.node_mut(free).id = new;
    let found = labelled(&input);
    let ids: BTreeSet<&str> = found.nodes().map(|node| node.id.as_str()).collect();
    assert_eq!(ids.len(), found.node_count());
}

/// The topology that a run kept has as many parts with names as without: what connects them is there.
#[test]
fn connections_that_were_kept_are_there_under_names() {
    let here = folder();
    let run = |arguments: &[&str]| {
        let output = command(here.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    };
    run(&["phantom", "cerebral", "--break", "--seed", "3", "-o", "a.swc"]);
    run(&["infer", "a.swc", "-n", "20", "-o", "run"]);
    run(&["label", "run/topology.graphml", "-o", "named.graphml"]);
    let graph = |file: &str| read(&here.path().join(file), &ReadOptions::default()).expect("a graph").network;
    let (kept, named) = (graph("run/topology.graphml"), graph("named.graphml"));
    assert!(kept.vessels().any(|(_, vessel)| vessel.origin == Origin::Candidate));
    assert_eq!(fragments(&named, |_, _| true).count, fragments(&kept, |_, _| true).count);
}

/// A wrong exponent or a wrong unit makes vessels that no head has: no name, for which there is no memory, but a message that says so.
#[test]
fn endless_vessels_are_not_named() {
    let far: &[u8] = b"1 2 0 0 0 1 -1\n2 2 0 0 10 1 1\n3 2 0 0 1e9 1 2\n";
    refused(&[("far.swc", far)], &["label", "far.swc", "-o", "a.graphml"], &["far.swc", "no arteries of a circle", "in mm"]);
    let arguments = ["classify", "far.swc", "--landmarks", "auto", "-o", "out"];
    refused(&[("far.swc", far)], &arguments, &["far.swc", "no arteries of a circle", "in mm"]);
}

/// A segment has one probability: `label` says of each what `classify` says, whole and broken; also whether enough is seen to say it.
#[test]
fn label_and_classify_say_the_same_of_each_segment() {
    let here = folder();
    let run = |arguments: &[&str]| {
        let output = command(here.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    };
    let circles: [&[&str]; 2] = [&[], &["--without", "L-A1", "--break", "--seed", "3001"]];
    for circle in circles {
        run(&[&["phantom", "cerebral", "-o", "a.swc", "--force"], circle].concat());
        run(&["label", "a.swc", "-o", "named.graphml", "--force"]);
        run(&["classify", "a.swc", "--landmarks", "auto", "-o", "classified", "--force"]);
        let told = fs::read_to_string(here.path().join("classified/phenotype.json")).expect("a phenotype");
        let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
        let table = fs::read_to_string(here.path().join("named.segments.csv")).expect("segments");
        for line in table.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            assert_eq!(cells[1].parse().ok(), told["probabilities"]["segments"][cells[0]].as_f64(), "{line}");
            let not_seen = told["probabilities"]["not_seen"].as_array().expect("a list");
            assert_eq!(cells[3] == "1", not_seen.iter().any(|segment| segment == cells[0]), "{line} {not_seen:?}");
        }
    }
}

/// A brain is named by the atlas of patients, and as if there were no other: of a brain each atlas names another part.
#[test]
fn a_whole_brain_is_named_by_the_atlas_of_patients() {
    let shared = std::env::var_os("WILLIS_SHARED_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    let Ok(entries) = fs::read_dir(shared.join("brava/vtp")) else {
        println!("skipped: there is no {}", shared.join("brava/vtp").display());
        return;
    };
    let mut brains: Vec<PathBuf> =
        entries.flatten().map(|e| e.path()).filter(|p| p.to_string_lossy().ends_with(".vtp")).collect();
    brains.sort();
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/models/src/naming/arteries.toml"))
        .expect("a model");
    let patients = NamingModels::one(NamingModel::read(&text).expect("a model"));
    assert!(brains.len() > 10);
    for path in brains.iter().step_by(9) {
        let brain = read(path, &ReadOptions::default()).expect("a brain").network;
        assert_eq!(names(&brain), names_by(&patients, &brain), "{}", path.display());
        // In the axes of LPS, with nothing said of the frame, front and back tell it.
        let mut other = turned(&brain, |p| [-p[0], -p[1], p[2]]);
        other.frame = Frame::Unknown;
        let found = NamingModels::shipped().expect("models").name(&other).expect("names").bearings.frame;
        let own = if brain.frame.is_known() { brain.frame } else { Frame::Ras };
        assert_eq!(found, if own == Frame::Ras { Frame::Lps } else { Frame::Ras }, "{}", path.display());
    }
}

/// Real masks with the sagittal sinus, which is thicker than the circle: the names of the carotids lie where one sees the carotids in pictures of
/// the masks. They lay 25 mm behind them, or nowhere.
#[test]
fn sinuses_do_not_draw_the_names_away() {
    let masks = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/kdxf-masks");
    if !masks.is_dir() {
        return println!("skipped: there is no {}", masks.display());
    }
    for (name, seen) in [("002", -98.0), ("004", -100.0), ("008", -101.0)] {
        let head = read(&masks.join(format!("KDXF_{name}.nii.gz")), &ReadOptions::default()).expect("a mask").network;
        let names = NamingModels::shipped().expect("models").name(&head).expect("names");
        let is_carotid = |label: ArteryLabel| matches!(artery_of(label), Some(Artery::Ica(_)));
        let carotids = names.nodes.at.iter().zip(names.best()).filter(|(_, label)| is_carotid(*label));
        let carotids: Vec<[f64; 3]> = carotids.map(|(at, _)| *at).collect();
        let [y, z] = [1, 2].map(|k| carotids.iter().map(|at| at[k]).sum::<f64>() / carotids.len() as f64);
        // In front of the basilar artery, in the lowest fifth of the image.
        assert!((y - seen).abs() < 10.0 && z < 20.0, "KDXF_{name}: at y {y:.0} mm, z {z:.0} mm, seen at y {seen} mm");
    }
}

/// Positions by label of a table of landmarks.
fn places(path: &Path) -> BTreeMap<String, [f64; 3]> {
    let text = fs::read_to_string(path).expect("landmarks");
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[0].to_owned(), [1, 2, 3].map(|k: usize| cells[k].parse().expect("a number")))
    };
    text.lines().skip(1).map(row).collect()
}

/// The atlas of patients does not know the drawn circle, which has one of its own: broken with seeds that it was not fitted to, its
/// arteries end where the phantom says, and its segments are there or not.
#[test]
fn the_drawn_circle_is_named() {
    let here = folder();
    let run = |arguments: &[&str]| {
        let output = command(here.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    };
    let (mut near, mut ends, mut right, mut segments) = (0, 0, 0, 0);
    for (seed, lacks) in [("3000", ""), ("3001", "L-A1"), ("3002", "R-PComm"), ("3003", "AComm")] {
        let without: &[&str] = if lacks.is_empty() { &[] } else { &["--without", lacks] };
        run(&[&["phantom", "cerebral", "--break", "--seed", seed, "-o", "a.swc", "--force"], without].concat());
        let truth = places(&here.path().join("a.landmarks.csv"));
        run(&["label", "a.swc", "-o", "named.graphml", "--force"]);
        let found = places(&here.path().join("named.landmarks.csv"));
        for (label, at) in truth.iter().filter(|(label, _)| !label.ends_with("P2")) {
            let said = found.get(label.trim_end_matches(" I"));
            ends += 1;
            // A free end is shortened by the damage.
            near += usize::from(said.is_some_and(|said| willis::internals::support::geometry::distance(*said, *at) < 12.0));
        }
        let table = fs::read_to_string(here.path().join("named.segments.csv")).expect("segments");
        for line in table.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            segments += 1;
            right += usize::from((cells[1].parse::<f64>().expect("a number") > 0.5) == (cells[0] != lacks));
        }
    }
    assert_eq!(segments, 28);
    assert!(right >= 26 && 10 * near >= 8 * ends, "{right} of 28 segments, {near} of {ends} ends");
}

/// What lies on the midline is at 0 in the frame of the file, which is written without a sign.
#[test]
fn no_place_on_the_midline_has_a_sign() {
    let here = folder();
    let run = |arguments: &[&str]| assert_eq!(command(here.path(), arguments).status.code(), Some(0));
    run(&["phantom", "cerebral", "-o", "ras.swc"]);
    run(&["convert", "ras.swc", "lps.mrk.json"]);
    run(&["label", "lps.mrk.json", "-o", "named.graphml"]);
    for file in ["named.names.csv", "named.landmarks.csv"] {
        let table = fs::read_to_string(here.path().join(file)).expect("a table");
        let words: Vec<&str> = table.split([',', '\n']).collect();
        assert!(words.contains(&"0") && !words.contains(&"-0"), "{file}");
    }
}

/// A segment of which nothing is seen, nor of what lies at its ends, is out of view if it would lie outside all that is seen; else it is missing.
#[test]
fn a_segment_out_of_view_is_not_put_down_as_missing() {
    let here = folder();
    let output = command(here.path(), &["phantom", "cerebral", "-o", "whole.swc"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = fs::read_to_string(here.path().join("whole.swc")).expect("a phantom");
    let name_of_kind: BTreeMap<&str, &str> =
        text.lines().filter_map(|line| line.strip_prefix("# label ")).filter_map(|label| label.split_once(' ')).collect();
    let models = NamingModels::shipped().expect("models");
    let presence = |lacks: &dyn Fn(&str) -> bool| {
        // The points of the arteries that are left; a point whose parent is gone begins a piece.
        let rows: Vec<Vec<&str>> =
            text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split_whitespace().collect()).collect();
        let kept: Vec<&Vec<&str>> = rows.iter().filter(|row| !lacks(name_of_kind.get(row[1]).copied().unwrap_or(""))).collect();
        let ids: Vec<&str> = kept.iter().map(|row| row[0]).collect();
        let lines: Vec<String> = kept
            .iter()
            .map(|row| {
                let parent = if ids.contains(&row[6]) { row[6] } else { "-1" };
                format!("{} 0 {} {} {} {} {parent}", row[0], row[2], row[3], row[4], row[5])
            })
            .collect();
        let path = here.path().join("part.swc");
        fs::write(&path, lines.join("\n")).expect("written");
        let mut network = read(&path, &ReadOptions::default()).expect("a network").network;
        network.frame = Frame::Ras;
        let names = models.name(&network).expect("names");
        let circle = names.circle(models.of(&names));
        let table = willis::internals::circle_of_willis::VariantFrequencies::published().expect("a table");
        let prior = willis::internals::naming::CirclePrior { frequencies: table, is_own: false, unseen: 0.0 };
        (circle.is_in_view, circle.presence(&[0.5; 7], &prior))
    };
    // The carotid of the left side and all that hangs on it: L-A1, the first segment, would lie between vessels that are seen.
    let anterior = |name: &str| ["L-ICA", "L-M1", "L-A1", "L-A2", "L-PComm"].iter().any(|artery| name.starts_with(artery));
    let (in_view, p) = presence(&anterior);
    assert!(in_view[0] && p[0] < 0.5, "{in_view:?} {p:?}");
    // All of the left side: nothing shows that the image reached there.
    let (in_view, p) = presence(&|name| name.starts_with("L-"));
    assert!(!in_view[0] && p[0] > 0.5, "{in_view:?} {p:?}");
}

/// The atlas of patients.
fn atlas() -> Atlas {
    NamingModel::read(include_str!("../../crates/models/src/naming/arteries.toml")).expect("reads").atlas
}

#[test]
fn a_rotation_and_its_vector_belong_together() {
    for v in [[0.3, -0.2, 0.9], [0.0, 0.0, 3.1], [2.0, 2.0, -1.0], [1e-9, 0.0, 0.0]] {
        let r = rotation(v);
        let back = rotation_vector(&r);
        let r2 = rotation(back);
        for i in 0..3 {
            for j in 0..3 {
                assert!((r[i][j] - r2[i][j]).abs() < 1e-9, "{v:?} {back:?}");
            }
        }
    }
    // A quarter turn about z takes x to y.
    let y = times(&rotation([0.0, 0.0, std::f64::consts::FRAC_PI_2]), [1.0, 0.0, 0.0]);
    assert!(y[0].abs() < 1e-15 && (y[1] - 1.0).abs() < 1e-15);
}

#[test]
fn a_matrix_times_its_inverse_is_one() {
    let s = [4.0, 3.0, 5.0, 1.0, -0.5, 0.25];
    let (inverted, log) = inverse(&s);
    let one = product(&full(&s), &full(&inverted));
    for i in 0..3 {
        for j in 0..3 {
            assert!((one[i][j] - UNIT[i][j]).abs() < 1e-14);
        }
    }
    // By the rule of Sarrus.
    let determinant: f64 = 4.0 * 3.0 * 5.0 + 2.0 * (1.0 * 0.25 * -0.5) - (-0.5 * -0.5 * 3.0 + 0.25 * 0.25 * 4.0 + 5.0);
    assert!((log - determinant.ln()).abs() < 1e-14);
    assert!((trace_of_product(&s, &inverted) - 3.0).abs() < 1e-14);
}

#[test]
fn states_run_along_the_arteries_and_have_mirror_images() {
    let tables = StateTables::default();
    assert_eq!((tables.label.len(), tables.label[NOWHERE]), (STATES, OTHER));
    for state in 0..STATES {
        let other = tables.mirrored[state];
        assert_eq!((tables.mirrored[other], tables.bin[other]), (state, tables.bin[state]));
    }
    assert_eq!(label_named("R-PComm"), Some(label_of(Artery::PComm(BodySide::Right))));
    assert_eq!(name_of(mirrored(label_of(Artery::M2(BodySide::Left)))), "R-M2");
    assert_eq!(state_at(BA, 9.0), first_state(BA) + 2);
    assert_eq!(state_at(label_of(Artery::AComm), 90.0), first_state(label_of(Artery::AComm)));
    assert_eq!(tables.step(first_state(BA), -1), None);
}

/// A carotid, a gap of 4 mm and an A2, in a row: the way over the gap, and none without it.
#[test]
fn a_gap_is_crossed_as_far_as_it_is_believed() {
    let certain = |label: ArteryLabel| {
        let mut p = [0.0; LABELS];
        p[label] = 1.0;
        p
    };
    let (ica, a1, a2) =
        (label_of(Artery::Ica(BodySide::Left)), label_of(Artery::A1(BodySide::Left)), label_of(Artery::A2(BodySide::Left)));
    let labels = [ica, a1, a1, a2, OTHER].map(certain);
    let nodes = Nodes {
        at: [0.0, 1.0, 5.0, 6.0, 90.0].map(|x| [x, 0.0, 0.0]).to_vec(),
        log_radius: vec![0.0; 5],
        weight: vec![1.0; 5],
        links: vec![[0, 1], [2, 3]],
        neighbours: vec![vec![1], vec![0], vec![3], vec![2], vec![]],
        bridges: vec![Bridge { nodes: [1, 2], gap: 4.0, probability: 0.5, vessel: 2 }],
        ..Nodes::default()
    };
    let way = ways(&nodes, &labels, &[3.0])[0];
    // Two steps of 1 mm, and a candidate of odds 3.
    assert!((way.cost - (2.0 * 0.05 - 2.0 * 0.75_f64.ln())).abs() < 1e-12, "{way:?}");
    assert_eq!((way.gap, way.diameters, way.named), (4.0, 2.0, 2.0));
    // Without it nothing is reached, and every node is improbable at one end.
    assert!((way.observed - (2.0 * -(1e-3_f64.ln()))).abs() < 1e-12, "{way:?}");
}

/// The same by logarithms, as the names themselves are found.
#[test]
fn probabilities_are_those_of_the_log_likelihoods() {
    let atlas = atlas();
    let nodes = Nodes {
        at: vec![[0.0; 3], [10.0, -4.0, 7.0], [-60.0, 90.0, 20.0]],
        direction: vec![[0.5, 0.3, 0.2, 0.1, 0.0, -0.1], [0.1, 0.1, 0.8, 0.05, 0.02, 0.0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]],
        log_radius: vec![0.1, -0.4, 0.9],
        neighbours: vec![Vec::new(); 3],
        ..Nodes::default()
    };
    let (subset, states) = ([0, 1, 2], all_states());
    let case = Search::new(&nodes, &atlas, &[1.0; 3], &[], 0.0);
    let pose = Pose { turn: rotation([0.2, -0.1, 0.3]), shift: [3.0, -2.0, 5.0], log_scale: 0.05 };
    for (tau, parts) in [(7.0, [1.0, 1.0, 0.5]), (0.0, [1.0; 3])] {
        let precisions = atlas.widened(tau);
        let logs = case.emission(&case.fit(&pose, &precisions), parts);
        let weights: Vec<f64> = logs.iter().zip(atlas.prior.iter().cycle()).map(|(e, p)| e.exp() * p).collect();
        let sums: Vec<f64> = weights.chunks(STATES).map(|row| row.iter().sum()).collect();
        let sum: f64 = sums.iter().map(|sum| sum.ln()).sum();
        let single = Single::new(&case, [&subset, &states], parts[2]);
        let (found, log) = single.probabilities(&pose, &single.places(&precisions));
        assert!((log - sum).abs() < 1e-9, "{log} {sum}");
        assert!(found.iter().zip(&weights).enumerate().all(|(k, (a, b))| (a - b / sums[k / STATES]).abs() < 1e-12));
    }
}

/// Three nodes in a row, the last behind a gap: the marginals are those of all 113³ assignments.
#[test]
fn beliefs_are_those_of_all_assignments() {
    let atlas = atlas();
    let mut nodes = Nodes {
        at: vec![[0.0; 3], [1.0, 0.0, 0.0], [4.0, 0.0, 0.0]],
        links: vec![[0, 1]],
        neighbours: vec![vec![1], vec![0], vec![]],
        ..Nodes::default()
    };
    nodes.bridges.push(Bridge { nodes: [1, 2], gap: 4.0, probability: 0.7, vessel: 0 });
    let log_likelihood: Vec<f64> = (0..3 * STATES).map(|k| (0.37 * k as f64).sin() * 2.0).collect();
    let found = NamingForest::of(&nodes, &[0]).beliefs(&atlas, &log_likelihood);
    let own = |n: usize, s: usize| log_likelihood[n * STATES + s].exp() * atlas.prior[s];
    let sum_of_last: f64 = (0..STATES).map(|c| own(2, c)).sum();
    let mut expected = vec![0.0; 3 * STATES];
    // The gap's factor is relative to what the far side says by itself: p B + (1 - p), with messages that sum to one.
    for a in 0..STATES {
        for b in 0..STATES {
            let pair = own(0, a) * own(1, b) * atlas.pairs[0][a * STATES + b];
            let mut onward = vec![0.0; STATES];
            for (c, to) in onward.iter_mut().enumerate() {
                *to = pair * 0.7 * own(2, c) / sum_of_last * atlas.gaps[1][b * STATES + c];
            }
            let joined: f64 = onward.iter().sum();
            expected[a] += joined + 0.3 * pair;
            expected[STATES + b] += joined + 0.3 * pair;
        }
    }
    for n in 0..2 {
        let row = &mut expected[n * STATES..(n + 1) * STATES];
        let sum: f64 = row.iter().sum();
        for (s, p) in row.iter().enumerate() {
            assert!((found.states[n * STATES + s] - p / sum).abs() < 1e-9, "node {n}, state {s}");
        }
    }
    assert!(found.bridge_ratio[0].is_some_and(|ratio| ratio > 0.0));

    // No node in some states: the sum over all assignments without them, in which the far side is what it says by itself.
    let total = |allowed: &dyn Fn(usize) -> bool| -> f64 {
        let states = || (0..STATES).filter(|state| allowed(*state));
        let far: f64 = states().map(|c| own(2, c)).sum();
        let mut sum = 0.0;
        for a in states() {
            for b in states() {
                let pair = own(0, a) * own(1, b) * atlas.pairs[0][a * STATES + b];
                let joined: f64 = states().map(|c| own(2, c) * atlas.gaps[1][b * STATES + c]).sum();
                sum += pair * (0.7 * joined + 0.3 * far);
            }
        }
        sum
    };
    let lists = [0..12, 50..55, 112..113];
    let lists_of = lists.iter().collect::<Vec<_>>();
    let evidence = NamingForest::of(&nodes, &[0]).evidence(&atlas, &log_likelihood, &found, &lists_of);
    for (states, found) in lists.iter().zip(evidence) {
        let expected = (total(&|_| true) / total(&|state| !states.contains(&state))).ln();
        assert!((found - expected).abs() < 1e-9 && expected > 0.0, "{states:?}: {found}, not {expected}");
    }
}

/// Beyond a junction, a name that only the root may have is missing where the root has another. At other nodes the two differ: kinds of
/// bifurcations that were never seen are not weighted alike up and down the forest.
#[test]
fn evidence_at_the_root_agrees_with_beliefs() {
    let atlas = atlas();
    let nodes = Nodes {
        at: vec![[0.0; 3], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 2.0, 0.0]],
        links: vec![[0, 1], [0, 2], [0, 3], [3, 4]],
        neighbours: vec![vec![1, 2, 3], vec![0], vec![0], vec![0, 4], vec![3]],
        ..Nodes::default()
    };
    let forest = NamingForest::of(&nodes, &[]);
    let (root, own) = (forest.order[0], 0..12);
    for at_root in [-3.0, 0.0, 8.0] {
        let mut log_likelihood: Vec<f64> = (0..5 * STATES).map(|k| (0.37 * k as f64).sin() * 2.0).collect();
        for node in 0..5 {
            log_likelihood[node * STATES..][own.clone()].fill(if node == root { at_root } else { -200.0 });
        }
        let beliefs = forest.beliefs(&atlas, &log_likelihood);
        let belief: f64 = beliefs.states[root * STATES..][own.clone()].iter().sum();
        let (found, expected) = (forest.evidence(&atlas, &log_likelihood, &beliefs, &[&own])[0], -(1.0 - belief).ln());
        assert!((found - expected).abs() < 1e-9 && expected > 1e-6, "{at_root}: {found}, not {expected}");
    }
}
