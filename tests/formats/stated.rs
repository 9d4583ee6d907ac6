//! What a file states beside its points: which pieces VMTK cut from one line and one branch, and where blood comes from. Pieces and trees
//! are drawn by hand.

use std::fmt::Write;
use std::path::Path;

use crate::command::willis;
use willis::internals::flow::{Boundary, FoundOutlets, Given};
use willis::internals::formats::{Content, ReadOptions, read, read_bytes};
use willis::internals::network::{Condition, Network, RadiusRule, Role, fragments};

/// A piece of a line as `vmtkbranchextractor` writes it: points in mm with a radius each, and its ids.
#[derive(Clone)]
struct Piece {
    points: Vec<([f64; 3], f64)>,
    centerline: i32,
    tract: i32,
    group: i32,
}

/// A VTP file in which no piece shares a point with another one.
fn vtp(pieces: &[Piece], with_ids: bool) -> String {
    let (mut at, mut radii, mut ends) = (String::new(), String::new(), String::new());
    let mut count = 0;
    for piece in pieces {
        for ([x, y, z], r) in &piece.points {
            write!(at, "{x} {y} {z} ").unwrap();
            write!(radii, "{r} ").unwrap();
        }
        count += piece.points.len();
        write!(ends, "{count} ").unwrap();
    }
    let points: Vec<String> = (0..count).map(|n| n.to_string()).collect();
    let array = |kind: &str, name: &str, values: &str| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"1\" format=\"ascii\">{values}</DataArray>")
    };
    let ids = |name: &str, id: fn(&Piece) -> i32| {
        array("Int32", name, &pieces.iter().map(|piece| id(piece).to_string()).collect::<Vec<_>>().join(" "))
    };
    let ids = [ids("CenterlineIds", |p| p.centerline), ids("TractIds", |p| p.tract), ids("GroupIds", |p| p.group)].concat();
    format!(
        "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\"><PolyData><Piece \
         NumberOfPoints=\"{count}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\"><PointData>{}\
         </PointData><CellData>{}</CellData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{at}\
         </DataArray></Points><Lines>{}{}</Lines></Piece></PolyData></VTKFile>",
        pieces.len(),
        array("Float64", "MaximumInscribedSphereRadius", &radii),
        if with_ids { &ids } else { "" },
        array("Int64", "connectivity", &points.join(" ")),
        array("Int64", "offsets", &ends),
    )
}

/// The network of a file, and the notes of its reader.
fn network(name: &str, text: &str) -> (Network, Vec<String>) {
    let document = read_bytes(Path::new(name), text.as_bytes(), &ReadOptions::default()).unwrap();
    let made = document.content.into_network(RadiusRule::Mean, None).unwrap();
    (made.network, document.notes)
}

fn millimetres(network: &Network) -> f64 {
    network.vessels().map(|(_, v)| v.length * 1e3).sum()
}

fn inlets(network: &Network, given: &[Given]) -> Vec<String> {
    let boundary = Boundary::resolve(network, given, FoundOutlets::Ground).unwrap();
    let rows = (0..network.node_count()).filter(|node| boundary.roles[*node] == Role::Inlet);
    rows.map(|node| network.node(node).id.clone()).collect()
}

fn length(points: &[([f64; 3], f64)]) -> f64 {
    let step = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
    points.windows(2).map(|pair| step(pair[0].0, pair[1].0)).sum()
}

/// Points of one radius from a place to another one, in steps of 1 mm or less.
fn straight(from: [f64; 3], to: [f64; 3], radius: f64) -> Vec<([f64; 3], f64)> {
    let steps = length(&[(from, 0.0), (to, 0.0)]).ceil();
    let at = |n: usize| [0, 1, 2].map(|i| from[i] + (to[i] - from[i]) * n as f64 / steps);
    (0..=steps as usize).map(|n| (at(n), radius)).collect()
}

/// A trunk of 20 mm, a bifurcation of 2 mm and two branches of 19.7 mm; `shift` moves the second branch along the first axis.
fn fork(shift: f64) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (centerline, side) in [8.0, -8.0].into_iter().enumerate() {
        let shift = shift * centerline as f64;
        let ways = [
            ([0.0; 3], [20.0, 0.0, 0.0]),
            ([20.0, 0.0, 0.0], [22.0, 0.0, 0.0]),
            ([22.0 + shift, 0.0, 0.0], [40.0 + shift, side, 0.0]),
        ];
        for (tract, (from, to)) in ways.into_iter().enumerate() {
            let (centerline, tract) = (centerline as i32, tract as i32);
            let group = if tract == 2 { 2 + centerline } else { tract };
            pieces.push(Piece { points: straight(from, to, 1.5), centerline, tract, group });
        }
    }
    pieces
}

/// The length of the fork by hand: 22 mm and twice the hypotenuse of 18 and 8.
fn of_fork() -> f64 {
    22.0 + 2.0 * 388.0_f64.sqrt()
}

#[test]
fn pieces_that_ids_join_are_one_line_over_a_gap_of_micrometres() {
    for shift in [0.0, 8.5e-4, 0.5] {
        let (found, notes) = network("a.vtp", &vtp(&fork(shift), true));
        assert_eq!((found.vessel_count(), fragments(&found, |_, _| true).count), (3, 1), "{shift}: {notes:?}");
        assert!((millimetres(&found) - of_fork() - shift).abs() < 1e-6, "{shift}: {}", millimetres(&found));
        assert!(notes[0].starts_with("6 pieces are 2 lines by their CenterlineIds and TractIds"), "{notes:?}");
        let closed = if shift == 0.0 {
            None
        } else {
            Some(format!("1 gap between them closed, of {shift:.*} mm", if shift < 0.1 { 5 } else { 2 }))
        };
        assert!(closed.is_none_or(|closed| notes[0].contains(&closed)), "{notes:?}");
    }
}

#[test]
fn a_gap_wider_than_the_step_and_the_radius_stays_and_is_said() {
    let (found, notes) = network("a.vtp", &vtp(&fork(3.0), true));
    assert_eq!((found.vessel_count(), fragments(&found, |_, _| true).count), (2, 2));
    assert!((millimetres(&found) - of_fork()).abs() < 1e-6, "{}", millimetres(&found));
    assert!(notes[0].starts_with("6 pieces are 2 lines") && notes[0].contains("1 gap of up to 3.0 mm left open"), "{notes:?}");
    // A gap between copies of what the other line connects parts nothing.
    let mut pieces = fork(0.0);
    pieces[3].points.truncate(18);
    let (found, notes) = network("a.vtp", &vtp(&pieces, true));
    assert_eq!((found.vessel_count(), fragments(&found, |_, _| true).count), (3, 1));
    assert!(!notes[0].contains("gap"), "{notes:?}");
    // The same gap in the line that comes first: the second one shows that its pieces follow each other.
    let mut pieces = fork(0.0);
    pieces[0].points.truncate(18);
    let (found, notes) = network("a.vtp", &vtp(&pieces, true));
    assert_eq!((found.vessel_count(), fragments(&found, |_, _| true).count), (3, 1));
    assert!((millimetres(&found) - of_fork()).abs() < 1e-6, "{}", millimetres(&found));
    assert!(!notes[0].contains("gap"), "{notes:?}");
}

/// Five lines along a trunk, each of which leaves at a bifurcation of its own but the last. They drift half a radius apart in the last
/// 5 mm before the bifurcation and leave the tube around the others at its end, 3 mm on. Also the length by `GroupIds` in mm: of each
/// group the mean of its pieces.
fn drifting() -> (Vec<Piece>, f64) {
    const STRETCH: f64 = 20.0;
    const BIFURCATION: f64 = 3.0;
    let mut pieces: Vec<Piece> = Vec::new();
    for centerline in 0..5 {
        let mut tract = 0;
        let mut add = |points: Vec<([f64; 3], f64)>, group: i32| {
            pieces.push(Piece { points, centerline, tract, group });
            tract += 1;
        };
        for fork in 0..=centerline.min(4) {
            let (start, radius) = (f64::from(fork) * (STRETCH + BIFURCATION), 1.5 - 0.15 * f64::from(fork));
            let side = if fork % 2 == 0 { 1.0 } else { -1.0 };
            let leaves = fork == centerline && fork < 4;
            let beside = |s: f64| {
                let share = match s {
                    s if s < STRETCH - 5.0 => 0.0,
                    s if s < STRETCH => 0.5 * ((s - STRETCH + 5.0) / 5.0),
                    s => 0.5 + 0.5 * (s - STRETCH) / BIFURCATION,
                };
                if leaves { side * share * radius } else { 0.0 }
            };
            let way = |from: f64, to: f64| -> Vec<([f64; 3], f64)> {
                let steps = ((to - from) / 0.25).round() as usize;
                let at = |n: usize| from + 0.25 * n as f64;
                (0..=steps).map(|n| ([start + at(n), beside(at(n)), 0.0], radius)).collect()
            };
            add(way(0.0, STRETCH), 3 * fork);
            if fork < 4 {
                add(way(STRETCH, STRETCH + BIFURCATION), 3 * fork + 1);
            }
            if leaves {
                let from = [start + STRETCH + BIFURCATION, side * radius, 0.0];
                add(straight(from, [from[0] + 12.0, from[1] + side * 9.0, 0.0], 0.8 * radius), 3 * fork + 2);
            }
        }
    }
    let mut groups = std::collections::BTreeMap::new();
    for piece in &pieces {
        groups.entry(piece.group).or_insert_with(Vec::new).push(length(&piece.points));
    }
    let by_groups = groups.values().map(|all| all.iter().sum::<f64>() / all.len() as f64).sum();
    (pieces, by_groups)
}

#[test]
fn what_lines_share_by_their_groups_is_counted_once() {
    let (mut pieces, by_groups) = drifting();
    for round in 0..2 {
        let (found, notes) = network("a.vtp", &vtp(&pieces, true));
        assert_eq!((found.vessel_count(), fragments(&found, |_, _| true).count), (9, 1), "{notes:?}");
        // At each of four bifurcations some radius more, from the axis to the branch that is hung on there.
        let more = millimetres(&found) / by_groups - 1.0;
        assert!((-0.01..0.035).contains(&more), "{} by groups {by_groups}", millimetres(&found));
        assert!(
            notes[0].starts_with("33 pieces are 5 lines") && notes[0].contains("those of one GroupIds are one vessel"),
            "{notes:?}"
        );
        assert_eq!(inlets(&found, &[]).len(), 1, "round {round}");
        pieces.reverse();
    }
}

#[test]
fn lines_that_meet_and_three_that_part_have_one_junction() {
    // The fork backwards: two lines come from two places and go on as one. Their directions state no one source.
    let mut pieces = fork(0.0);
    for piece in &mut pieces {
        piece.points.reverse();
        piece.tract = 2 - piece.tract;
    }
    let (found, notes) = network("a.vtp", &vtp(&pieces, true));
    assert_eq!((found.vessel_count(), found.node_count(), fragments(&found, |_, _| true).count), (3, 4, 1), "{notes:?}");
    assert!((millimetres(&found) - of_fork()).abs() < 1e-6, "{}", millimetres(&found));
    assert!((0..4).all(|node| !found.node(node).is_source));
    // Three branches that leave the bifurcation half a radius from its end, in three directions.
    let mut pieces = fork(0.0);
    let again: Vec<Piece> = pieces[..3].iter().map(|piece| Piece { centerline: 2, ..piece.clone() }).collect();
    pieces.extend(again);
    for (row, [y, z]) in [(2, [0.75, 0.0]), (5, [-0.75, 0.0]), (8, [0.0, 0.75])] {
        pieces[row].points = straight([22.0, y, z], [40.0, 12.0 * y, 12.0 * z], 1.2);
    }
    pieces[8].group = 4;
    let (found, notes) = network("a.vtp", &vtp(&pieces, true));
    assert_eq!((found.vessel_count(), found.node_count(), fragments(&found, |_, _| true).count), (4, 5, 1), "{notes:?}");
    let branch = (18.0_f64.powi(2) + 8.25_f64.powi(2)).sqrt() + 0.75;
    assert!((millimetres(&found) - 22.0 - 3.0 * branch).abs() < 0.01, "{}", millimetres(&found));
}

#[test]
fn numbers_of_groups_that_mean_something_else_lose_no_vessel() {
    let mut pieces = fork(0.0);
    for piece in &mut pieces {
        piece.group = 0;
    }
    let (found, _) = network("a.vtp", &vtp(&pieces, true));
    assert_eq!((found.vessel_count(), fragments(&found, |_, _| true).count), (3, 1));
    assert!((millimetres(&found) - of_fork()).abs() < 1e-6, "{}", millimetres(&found));
}

#[test]
fn the_point_where_all_lines_of_vmtk_start_is_the_inlet() {
    // Radii are equal: without the direction two ends would be inlets.
    let cut = vtp(&fork(0.0), true);
    let whole: Vec<Piece> = fork(0.0)
        .chunks(3)
        .map(|line| Piece { points: line.iter().flat_map(|piece| piece.points.clone()).collect(), ..line[0].clone() })
        .collect();
    for text in [&cut, &vtp(&whole, false)] {
        let (found, notes) = network("a.vtp", text);
        assert_eq!((found.vessel_count(), inlets(&found, &[])), (3, vec!["0".to_owned()]), "{notes:?}");
        // What a person states comes first.
        let degree = found.degrees(|_| true);
        let end = (0..found.node_count()).rev().find(|node| degree[*node] == 1).unwrap();
        let given = Given { node: end, role: Role::Inlet, condition: Condition::INLET };
        assert_eq!(inlets(&found, &[given]), [found.node(end).id.clone()]);
    }
    // As `vmtkcenterlinemerge` writes them: every group once.
    let merged: Vec<Piece> =
        fork(0.0).into_iter().enumerate().filter(|(n, _)| ![3, 4].contains(n)).map(|(_, piece)| piece).collect();
    let (found, notes) = network("a.vtp", &vtp(&merged, true));
    assert_eq!((found.vessel_count(), inlets(&found, &[])), (3, vec!["0".to_owned()]), "{notes:?}");
    // Lines from two places state nothing.
    let mut two = whole.clone();
    two[1].points.reverse();
    let (found, _) = network("a.vtp", &vtp(&two, false));
    assert_eq!(inlets(&found, &[]).len(), 2);
}

/// A tree of three vessels in SWC, its root with the first radius, its other ends with the others.
fn swc(radii: [f64; 3]) -> String {
    let [root, left, right] = radii;
    let mut text = format!("1 0 0 0 40 {root} -1\n2 0 0 0 35 {root} 1\n3 0 0 0 30 {root} 2\n4 0 0 0 25 {root} 3\n");
    for (first, side, radius) in [(5, 5.0, left), (8, -5.0, right)] {
        for n in 0..3 {
            let parent = if n == 0 { 4 } else { first + n - 1 };
            let (y, z) = (side * f64::from(n + 1), 20.0 - 5.0 * f64::from(n));
            writeln!(text, "{} 0 0 {y} {z} {radius} {parent}", first + n).unwrap();
        }
    }
    text
}

#[test]
fn the_root_of_one_tree_that_narrows_from_it_is_the_inlet() {
    let of = |text: &str| inlets(&network("a.swc", text).0, &[]);
    assert_eq!(of(&swc([2.0, 1.5, 1.4])), ["1"]);
    // A second point where the root lies, in whichever row, is the root: rows may come in any order.
    let (again, tree) = ("20 0 0 0 40 2 1\n", swc([2.0, 1.5, 1.4]).replace("2 0 0 0 35 2 1\n", "2 0 0 0 35 2 20\n"));
    assert_eq!((of(&format!("{again}{tree}")), of(&format!("{tree}{again}"))), (vec!["20".to_owned()], vec!["1".to_owned()]));
    // The same tree without a direction has two inlets, by width.
    assert_eq!(of(&swc([1.5, 2.0, 1.4])), ["1", "7"]);
    // Widths are the same within 5 %: nothing falls from the root.
    assert_eq!(of(&swc([2.0, 1.95, 1.4])), ["1", "7"]);
    // Two trees: a fragmented tracing.
    let two = swc([2.0, 1.5, 1.4]) + "20 0 60 0 40 1.8 -1\n21 0 60 0 35 1.8 20\n22 0 60 0 20 1.8 21\n";
    assert!(of(&two).len() > 1);
    // A carotid, a narrow vessel, and the next carotid, which is narrower than the first: an arc of the circle, with two inlets.
    let arc = swc([2.0, 1.0, 0.9])
        + "11 0 0 20 10 1.8 7\n12 0 0 25 10 1.8 11\n13 0 0 30 10 1.8 12\n14 0 0 35 10 1.8 13\n\
                                      15 0 0 15 5 0.9 7\n16 0 0 15 0 0.9 15\n17 0 0 15 -5 0.9 16\n";
    assert_eq!(of(&arc), ["1", "14"]);
    // A root between two vessels is no end.
    let between = "1 0 0 0 0 2 -1\n2 0 9 0 0 1.5 1\n3 0 18 0 0 1.5 2\n4 0 -9 0 0 1.4 1\n5 0 -18 0 0 1.4 4\n";
    assert!(!of(between).contains(&"1".to_owned()));
}

#[test]
fn a_run_says_that_the_file_states_its_source() {
    let here = tempfile::tempdir().unwrap();
    for (name, text, says) in [
        ("stated.swc", swc([2.0, 1.5, 1.4]), "1 node, the source that the file states: 1 (100 mmHg)"),
        ("not.swc", swc([1.5, 2.0, 1.4]), "2 nodes, found at free ends: 1 (100 mmHg), 7 (100 mmHg)"),
    ] {
        std::fs::write(here.path().join(name), text).unwrap();
        let ran = willis(here.path(), &["infer", name, "-n", "64", "-o", &format!("{name}.run")]);
        let said = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert!(ran.status.success() && said.contains(says), "{said}");
        let page = std::fs::read_to_string(here.path().join(format!("{name}.run/report.html"))).unwrap();
        assert_eq!(page.contains("Nobody stated where blood enters"), name == "not.swc");
    }
}

#[test]
fn made_files_with_and_without_a_gap_agree() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/cases-in");
    if !folder.join("tracts_gap.vtp").exists() {
        eprintln!("skipped: no {} beside the package", folder.display());
        return;
    }
    for name in ["tracts_gap.vtp", "tracts_nogap.vtp"] {
        let document = read(&folder.join(name), &ReadOptions::default()).unwrap();
        assert!(matches!(document.content, Content::Centerlines(_)) && document.notes[0].starts_with("6 pieces are 2 lines"));
        let found = document.content.into_network(RadiusRule::Mean, None).unwrap().network;
        assert_eq!((found.vessel_count(), fragments(&found, |_, _| true).count), (3, 1), "{name}");
        assert!((millimetres(&found) - of_fork()).abs() < 0.01, "{name}: {}", millimetres(&found));
        assert_eq!(inlets(&found, &[]), ["0"], "{name}");
    }
}
