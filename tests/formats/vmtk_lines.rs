//! Lines that VMTK traces each for itself, from a source to every outlet: made-up anatomies with known vessels and lengths, VMTK's own
//! files, and lines that run close together and must stay apart.

use std::fmt::Write;
use std::path::Path;

use crate::draw::Draw;
use willis::internals::formats::{Content, ReadOptions, read, read_vtk};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::{Network, RadiusRule, contract, fragments};

/// Points in mm with a radius each.
type Line = Vec<([f64; 3], f64)>;

/// A legacy file in which no line shares a point with another one.
fn file(lines: &[Line]) -> String {
    let points: Vec<&([f64; 3], f64)> = lines.iter().flatten().collect();
    let mut text = format!("# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS {} double\n", points.len());
    for ([x, y, z], _) in &points {
        writeln!(text, "{x} {y} {z}").unwrap();
    }
    writeln!(text, "LINES {} {}", lines.len(), points.len() + lines.len()).unwrap();
    let mut next = 0;
    for line in lines {
        let ids: Vec<String> = (next..next + line.len()).map(|p| p.to_string()).collect();
        writeln!(text, "{} {}", ids.len(), ids.join(" ")).unwrap();
        next += line.len();
    }
    writeln!(text, "POINT_DATA {0}\nFIELD F 1\nMaximumInscribedSphereRadius 1 {0} double", points.len()).unwrap();
    for (_, r) in &points {
        writeln!(text, "{r}").unwrap();
    }
    text
}

fn network(mut lines: Centerlines) -> Network {
    lines.weld(1e-6);
    contract(&lines, RadiusRule::Mean, None).unwrap().network
}

fn vessels(lines: &[Line]) -> (Network, Vec<String>) {
    let (found, notes) = read_vtk(file(lines).as_bytes(), &ReadOptions::default()).unwrap();
    (network(found), notes)
}

fn millimetres(network: &Network) -> f64 {
    network.vessels().map(|(_, v)| v.length * 1e3).sum()
}

fn along(from: [f64; 3], to: [f64; 3], radius: f64, points: usize) -> Line {
    let at = |n: usize| [0, 1, 2].map(|i| from[i] + (to[i] - from[i]) * n as f64 / (points - 1) as f64);
    (0..points).map(|n| (at(n), radius)).collect()
}

fn joined(parts: &[&Line]) -> Line {
    let mut out: Line = parts[0].clone();
    parts[1..].iter().for_each(|part| out.extend(&part[1..]));
    out
}

/// A trunk of 60 mm with five branches on alternate sides and the end of the trunk as sixth outlet: 11 vessels.
fn comb() -> (Vec<Line>, f64) {
    let height = |n: usize| 10.0 * n as f64;
    let trunk: Vec<Line> =
        (0..6).map(|n| along([0.0, 0.0, height(n)], [0.0, 0.0, height(n + 1)], 2.0 - 0.1 * n as f64, 41)).collect();
    let mut lines = Vec::new();
    for n in 1..6 {
        let side = if n % 2 == 0 { 12.0 } else { -12.0 };
        let branch = along([0.0, 0.0, height(n)], [side, 3.0, height(n) + 8.0], 1.0, 41);
        let mut parts: Vec<&Line> = trunk[..n].iter().collect();
        parts.push(&branch);
        lines.push(joined(&parts));
    }
    lines.push(joined(&trunk.iter().collect::<Vec<_>>()));
    (lines, 60.0 + 5.0 * (12.0_f64.powi(2) + 9.0 + 64.0).sqrt())
}

fn shaken(line: &Line, share: f64, draw: &mut Draw) -> Line {
    line.iter().map(|(p, r)| (p.map(|x| x + share * r * draw.within(-1.0, 1.0)), *r)).collect()
}

fn resampled(line: &Line, step: f64) -> Line {
    let gap = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
    let mut out = vec![line[0]];
    let mut due = step;
    for pair in line.windows(2) {
        let (length, mut done) = (gap(pair[0].0, pair[1].0), 0.0);
        while due <= length - done {
            done += due;
            due = step;
            out.push(([0, 1, 2].map(|i| pair[0].0[i] + (pair[1].0[i] - pair[0].0[i]) * done / length), pair[0].1));
        }
        due -= length - done;
    }
    out.push(line[line.len() - 1]);
    out
}

#[test]
fn a_shared_trunk_is_there_once() {
    let (lines, truth) = comb();
    let mut draw = Draw::new(7);
    let mut cases: Vec<(String, Vec<Line>, f64)> = vec![("as it is".into(), lines.clone(), 0.02)];
    for share in [1e-3, 1e-2, 5e-2] {
        let shaken = lines.iter().map(|line| shaken(line, share, &mut draw)).collect();
        cases.push((format!("moved by {share} radii"), shaken, if share > 0.02 { 0.15 } else { 0.03 }));
    }
    let again = lines.iter().enumerate().map(|(n, line)| resampled(line, 0.3 + 0.07 * n as f64)).collect();
    cases.push(("of different steps".into(), again, 0.03));
    let coarse = lines.iter().map(|line| resampled(line, 2.3)).collect();
    cases.push(("in steps longer than the radius".into(), coarse, 0.05));
    let mut turned = lines.clone();
    turned.iter_mut().step_by(2).for_each(|line| line.reverse());
    turned.rotate_left(2);
    cases.push(("some backwards, in another order".into(), turned, 0.02));
    for (name, lines, tolerance) in cases {
        let (found, notes) = vessels(&lines);
        assert_eq!((found.vessel_count(), fragments(&found, |_, _| true).count), (11, 1), "{name}");
        assert!((millimetres(&found) / truth - 1.0).abs() < tolerance, "{name}: {} of {truth}", millimetres(&found));
        assert!(notes[0].starts_with("5 of 6 lines run together with others, over 1"), "{name}: {notes:?}");
        let widest = found.vessels().map(|(_, v)| v.radius * 1e3).fold(0.0, f64::max);
        assert!((widest - 2.0).abs() < 0.02, "{name}: {widest}");
    }
}

#[test]
fn lines_of_a_second_source_and_a_trifurcation() {
    // Two sources join at the origin, three outlets part at z = 20.
    let sources = [[-9.0, 0.0, -12.0], [9.0, 0.0, -12.0]].map(|s| along(s, [0.0; 3], 1.5, 61));
    let middle = along([0.0; 3], [0.0, 0.0, 20.0], 2.0, 81);
    let ends = [[-12.0, 0.0, 34.0], [0.0, 12.0, 34.0], [12.0, -2.0, 34.0]];
    let outlets = ends.map(|end| along([0.0, 0.0, 20.0], end, 1.2, 71));
    let mut lines: Vec<Line> =
        sources.iter().flat_map(|s| outlets.iter().map(|o| joined(&[s, &middle, o])).collect::<Vec<_>>()).collect();
    let length = |line: &Line| millimetres(&vessels(std::slice::from_ref(line)).0);
    let truth: f64 = sources.iter().chain([&middle]).chain(&outlets).map(length).sum();
    let mut draw = Draw::new(1);
    for round in 0..6 {
        draw.shuffle(&mut lines);
        let moved: Vec<Line> = lines.iter().map(|line| shaken(line, 0.005 * f64::from(round), &mut draw)).collect();
        let (found, _) = vessels(&moved);
        assert_eq!((found.vessel_count(), found.node_count(), fragments(&found, |_, _| true).count), (6, 7, 1), "round {round}");
        assert!((millimetres(&found) / truth - 1.0).abs() < 0.05, "round {round}");
    }
}

#[test]
fn lines_that_only_run_close_stay_apart() {
    let straight = along([0.0; 3], [0.0, 0.0, 40.0], 2.0, 201);
    let beside = |shift: [f64; 3]| straight.iter().map(|(p, r)| ([0, 1, 2].map(|i| p[i] + shift[i]), *r)).collect::<Line>();
    let mut back = beside([0.6, 0.0, 0.3]);
    back.reverse();
    let across = along([-20.0, 0.01, 20.0], [20.0, 0.01, 20.0], 2.0, 201);
    let fork = along([0.0; 3], [13.7, 0.0, 37.6], 2.0, 201);
    // Up, over and down again 0.3 radii beside itself; an outlet leaves the way down.
    let turn = joined(&[
        &straight,
        &along([0.0, 0.0, 40.0], [0.6, 0.0, 40.0], 2.0, 4),
        &along([0.6, 0.0, 40.0], [0.6, 0.0, 0.0], 2.0, 201),
    ]);
    let leaves = joined(&[&turn[..306].to_vec(), &along(turn[305].0, [0.6, 20.0, turn[305].0[2]], 2.0, 101)]);
    for (name, lines, count, length) in [
        ("0.3 radii apart", vec![straight.clone(), beside([0.6, 0.0, 0.0])], 2, 80.0),
        ("0.3 radii apart, backwards", vec![straight.clone(), back], 2, 80.0),
        ("crossing", vec![straight.clone(), across], 2, 80.0),
        ("20 degrees from one source", vec![straight.clone(), fork], 1, 80.0),
        ("a way back beside the way there", vec![turn.clone()], 1, 80.6),
        ("an outlet of the way back", vec![turn, leaves], 3, 100.6),
    ] {
        let (found, _) = vessels(&lines);
        assert_eq!(found.vessel_count(), count, "{name}");
        assert!((millimetres(&found) - length).abs() < 1.0, "{name}: {}", millimetres(&found));
    }
}

#[test]
fn a_network_that_knows_its_nodes_is_left_alone() {
    // Two daughters in one direction on a voxel grid: the file shares the point, so it knows what it says.
    let text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 4 0 0 1.6 0 0 2 5 0\n\
                LINES 2 7\n2 0 1 3 0 2 3\nPOINT_DATA 4\nSCALARS Radius float\nLOOKUP_TABLE default\n1 1 1 1\n";
    let (lines, notes) = read_vtk(text.as_bytes(), &ReadOptions::default()).unwrap();
    assert!(notes.is_empty());
    assert_eq!(lines.links, [[0, 1], [0, 2], [2, 3]]);
}

#[test]
fn one_long_link_upon_another_is_no_trunk() {
    // Coordinates are repeated at the node, no point is shared; the second line sets out along the first one.
    let first = along([0.0; 3], [10.0, 0.0, 0.0], 0.6, 6);
    let second = vec![([0.0; 3], 0.6), ([2.5, 0.05, 0.0], 0.6), ([3.0, 3.0, 0.0], 0.6), ([3.0, 8.0, 0.0], 0.6)];
    let (lines, notes) = read_vtk(file(&[first, second]).as_bytes(), &ReadOptions::default()).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(lines.links.len(), 8);
}

#[test]
fn a_loose_end_beside_another_one_stays_in_a_network() {
    // The third line starts 0.3 radii from the junction that the first two share and runs beside the second one.
    let text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 5 float\n0 0 0 4 0 0 9 0 0 4.2 0.2 0 9 0.05 0\n\
                LINES 3 9\n2 0 1 2 1 2 2 3 4\nPOINT_DATA 5\nSCALARS Radius float\nLOOKUP_TABLE default\n1 1 1 1 1\n";
    let (lines, notes) = read_vtk(text.as_bytes(), &ReadOptions::default()).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(lines.links, [[0, 1], [1, 2], [3, 4]]);
}

#[test]
fn a_triangle_of_long_links_keeps_its_three_sides() {
    let corner = [[0.0; 3], [10.0, 0.0, 0.0], [5.0, 8.0, 0.0]];
    let side = |a: usize, b: usize| along(corner[a], corner[b], 1.0, 2);
    let (found, notes) = vessels(&[side(0, 1), side(1, 2), side(2, 0)]);
    assert!(notes.is_empty(), "{notes:?}");
    assert!((millimetres(&found) - 10.0 - 2.0 * 89.0_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn the_y_is_three_vessels_in_all_nine_files() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/formats");
    if !folder.exists() {
        eprintln!("skipped: no {} beside the package", folder.display());
        return;
    }
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().path()).collect();
    files.retain(|f| f.file_name().unwrap().to_string_lossy().starts_with("y-"));
    files.sort();
    assert_eq!(files.len(), 9);
    for file in files {
        let document = read(&file, &ReadOptions::default()).unwrap();
        let Content::Centerlines(lines) = document.content else { panic!() };
        let found = network(lines);
        let name = file.file_name().unwrap().to_string_lossy();
        assert_eq!((found.node_count(), found.vessel_count()), (4, 3), "{name}");
        // By VTK: 26.06 mm in the merged branches; the network goes on to the caps of the tube, 31.15 mm.
        let truth = if name == "y-vmtknetworkextraction.vtp" { 31.15 } else { 26.06 };
        assert!((millimetres(&found) / truth - 1.0).abs() < 0.05, "{name}: {}", millimetres(&found));
        let mut radii: Vec<f64> = found.vessels().map(|(_, v)| v.radius * 1e3).collect();
        radii.sort_by(f64::total_cmp);
        for (radius, truth) in radii.iter().zip([1.4, 1.5, 2.0]) {
            assert!((radius / truth - 1.0).abs() < 0.05, "{name}: {radii:?}");
        }
    }
}
