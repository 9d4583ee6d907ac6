//! Writers of tubes, markups, points and SWC labels against our readers, bit for bit, and against Python; readers against broken files.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use std::path::Path;
use std::process::Command;

use crate::peers::{document, python};
use willis::internals::formats::{
    Format, ReadOptions, read_markups, read_points, read_swc, read_tre, write_centerlines_swc, write_markups, write_points,
    write_swc, write_tre,
};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::{Scale, metres, millimetres};
use willis::internals::network::{Network, Node, PathPoint, RadiusRule, Role, Vessel, contract, cycles, fragments};

fn mm() -> Scale {
    Scale::default()
}

fn network_of(mut lines: Centerlines) -> Network {
    lines.weld(1e-6);
    contract(&lines, RadiusRule::Mean, None).unwrap().network
}

/// Every vessel as its label and its points with their radii, in the lesser of its two senses; sorted.
fn shape(network: &Network) -> Vec<(String, Vec<[u64; 4]>)> {
    let mut vessels: Vec<_> = network
        .vessels()
        .map(|(_, vessel)| {
            let bits = |p: &PathPoint| [p.position[0], p.position[1], p.position[2], p.radius].map(|x| (x + 0.0).to_bits());
            let path: Vec<_> = vessel.path.iter().map(bits).collect();
            let back = path.iter().rev().copied().collect();
            (vessel.label.clone(), path.min(back))
        })
        .collect();
    vessels.sort();
    vessels
}

/// A triangle with a parallel vessel, a ring, two ends, one of them the inlet, and a vessel apart; positions and radii that
/// decimal fractions do not hold.
fn network() -> Network {
    let mut network = Network::new();
    let at = |k: f64| [k.sin() * 31.0 / 3.0, k.cos() * 17.0 / 7.0, k * 0.1].map(metres);
    for n in 0..7 {
        network.add_node(Node {
            id: n.to_string(),
            position: Some(at(f64::from(n) * 1.3)),
            radius: Some(metres(0.3 + f64::from(n) / 7.0)),
            role: (n == 4).then_some(Role::Inlet),
            ..Node::default()
        });
    }
    let labels = ["L-ICA", "3", "007", "a = b; \"c\", é # d", "", "ring", "16", "par"];
    for (row, ends) in [[0, 1], [1, 2], [2, 3], [3, 1], [3, 4], [2, 2], [5, 6], [1, 2]].into_iter().enumerate() {
        let end = |n: usize| PathPoint {
            position: network.node(n).position.unwrap(),
            radius: network.node(n).radius.unwrap(),
            id: None,
        };
        let bend = |k: usize| {
            let k = (row * 10 + k) as f64;
            PathPoint { position: [k.cos() * 5.0, k.sin() * 3.0, k / 9.0].map(metres), radius: metres(0.1 + k / 77.0), id: None }
        };
        let path = vec![end(ends[0]), bend(1), bend(2), end(ends[1])];
        network.add_vessel(ends, Vessel { label: labels[row].into(), ..Vessel::along(path, RadiusRule::Mean) });
    }
    network
}

#[test]
fn labels_of_swc_survive_a_round_trip() {
    let (forest, _) = network().subgraph(|row| !matches!(row, 1 | 3 | 5));
    let mut bytes = Vec::new();
    write_swc(&mut bytes, &forest).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let header: Vec<&str> = text.lines().filter(|l| l.starts_with("# label")).collect();
    assert_eq!(header, ["# label 16 16", "# label 17 L-ICA", "# label 18 007", "# label 19 par"]);
    let (lines, _) = read_swc(text.as_bytes(), &mm()).unwrap();
    // Point by point, too; what closes a loop goes into another file.
    let mut bytes = Vec::new();
    assert!(write_centerlines_swc(&mut bytes, &lines).unwrap().is_empty());
    assert_eq!(read_swc(&bytes[..], &mm()).unwrap().0, lines);
    let again = contract(&lines, RadiusRule::Mean, None).unwrap().network;
    // Nodes 1 to 3 have degree two now: a run has the name of its longest part.
    assert_eq!((again.vessel_count(), again.vessels().filter(|(_, v)| v.label == "16").count()), (2, 1));
    let kept: std::collections::BTreeSet<&str> = (0..lines.links.len()).map(|row| lines.labels.of(row)).collect();
    assert_eq!(kept.into_iter().collect::<Vec<_>>(), ["", "007", "16", "L-ICA", "par"]);
}

#[test]
fn what_is_written_is_read_again_to_the_last_bit() {
    let network = network();
    let (mut tubes, mut curves, mut table) = (Vec::new(), Vec::new(), Vec::new());
    write_tre(&mut tubes, &network).unwrap();
    write_markups(&mut curves, &network).unwrap();
    write_points(&mut table, &network).unwrap();
    for lines in [
        read_tre(&tubes, &ReadOptions::default()).unwrap().0,
        read_markups(&curves, &ReadOptions::default()).unwrap().0,
        read_points(&table[..], &ReadOptions::default()).unwrap().0,
    ] {
        let again = network_of(lines);
        assert_eq!((again.node_count(), cycles(&again), fragments(&again, |_, _| true).count), (7, 3, 2));
        assert_eq!(shape(&again), shape(&network));
    }
    for (name, bytes, format) in
        [("a.tre", &tubes, Format::Tre), ("a.json", &curves, Format::Markups), ("a.csv", &table, Format::Points)]
    {
        let document = document(name, bytes).unwrap();
        assert_eq!((document.format, document.notes.len()), (format, 0));
    }
}

/// The tubes begin at their parents: the inlet is the only root of its part.
#[test]
fn tubes_hang_together_from_the_inlet() {
    let mut bytes = Vec::new();
    write_tre(&mut bytes, &network()).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let objects: Vec<&str> = text.split("ObjectType = ").skip(3).collect();
    let field = |object: &str, key: &str| {
        let line = object.lines().find_map(|l| l.strip_prefix(key).and_then(|l| l.trim_start().strip_prefix("= ")))?;
        Some(line.to_owned())
    };
    let rows = |object: &str| -> Vec<String> {
        object.lines().skip_while(|l| !l.starts_with("Points")).skip(1).map(str::to_owned).collect()
    };
    let mut roots = Vec::new();
    for object in &objects {
        let Some(parent) = field(object, "ParentID") else {
            roots.push(field(object, "ID").unwrap());
            assert_eq!(field(object, "Root").unwrap(), "True");
            continue;
        };
        let parent = objects[parent.parse::<usize>().unwrap() - 1];
        let at: usize = field(object, "ParentPoint").unwrap().parse().unwrap();
        assert_eq!(rows(parent)[at], rows(object)[0]);
    }
    assert_eq!(roots, ["5", "7"]);
    let inlet = millimetres(network().node(4).position.unwrap()[0]).to_string();
    assert!(rows(objects[4])[0].starts_with(&inlet));
}

/// TRE is parsed by a few lines of Python: ITK itself is a download of 230 MB. Its reader, 5.4.7, gives the same numbers as float32,
/// the same names, parents and parent points.
const READERS: &str = r#"
import sys, json
import numpy as np, pandas as pd

folder = sys.argv[1]
table = pd.read_csv(f"{folder}/a.csv", keep_default_na=False, dtype={"label": str}, float_precision="round_trip")
assert list(table.columns) == ["fragment", "x_mm", "y_mm", "z_mm", "radius_mm", "label"]
fragments = [(f.label.iloc[0], f[["x_mm", "y_mm", "z_mm", "radius_mm"]].to_numpy(float)) for _, f in table.groupby("fragment")]

with open(f"{folder}/a.json", encoding="utf-8") as file:
    markups = json.load(file)["markups"]
assert all(m["type"] == "Curve" and m["coordinateSystem"] == "LPS" and m["coordinateUnits"] == "mm" for m in markups)
curves = []
for m in markups:
    radius = next(x["controlPointValues"] for x in m["measurements"] if x["name"] == "Radius")
    curves.append((m["name"], np.c_[[p["position"] for p in m["controlPoints"]], radius]))

tubes, fields, rows = [], {}, None
for line in open(f"{folder}/a.tre", encoding="utf-8").read().splitlines() + ["ObjectType = End"]:
    if rows is not None and "=" not in line:
        rows.append([float(word) for word in line.split()])
        continue
    key, value = line.split("=", 1)
    if key.strip() == "ObjectType":
        if rows is not None:
            assert int(fields["NPoints"]) == len(rows) and fields["PointDim"] == "x y z r"
            tubes.append((fields, np.array(rows)))
        fields, rows = {}, None
    fields[key.strip()] = value.strip()
    if key.strip() == "Points":
        rows = []

assert len(fragments) == len(curves) == len(tubes) == 8
for (label, a), (name, b), (fields, c) in zip(fragments, curves, tubes):
    assert label == name == fields.get("Name", "")
    assert (a == b).all() and ((c == a).all() or (c == a[::-1]).all())
print("\n".join(label for label, _ in fragments))
"#;

#[test]
fn python_reads_what_is_written() {
    let network = network();
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| std::fs::File::create(folder.path().join(name)).unwrap();
    write_tre(file("a.tre"), &network).unwrap();
    write_markups(file("a.json"), &network).unwrap();
    write_points(file("a.csv"), &network).unwrap();
    if let Some(labels) = python(READERS, &[folder.path()]) {
        let expected: Vec<&str> = network.vessels().map(|(_, v)| v.label.as_str()).collect();
        assert_eq!(labels.lines().collect::<Vec<_>>(), expected);
    }
}

#[test]
fn broken_files_never_panic() {
    let network = network();
    let (mut tubes, mut curves, mut table) = (Vec::new(), Vec::new(), Vec::new());
    write_tre(&mut tubes, &network).unwrap();
    write_markups(&mut curves, &network).unwrap();
    write_points(&mut table, &network).unwrap();
    let binary =
        [b"ObjectType = Tube\nBinaryData = True\nPointDim = x y z r\nNPoints = 3\nPoints = \n" as &[u8], &[64; 48]].concat();
    let check = |bytes: &[u8]| {
        let faults = [
            read_tre(bytes, &ReadOptions::default()).err(),
            read_markups(bytes, &ReadOptions::default()).err(),
            read_points(bytes, &ReadOptions::default()).err(),
            read_swc(bytes, &mm()).err(),
        ];
        for fault in faults.into_iter().flatten() {
            assert_eq!(fault.in_file(Path::new("x")).to_string().lines().count(), 1);
        }
    };
    for whole in [&tubes, &curves, &table, &binary] {
        for cut in 0..whole.len() {
            check(&whole[..cut]);
        }
        for at in (0..whole.len()).step_by(3) {
            for byte in [0, b'\n', b'=', b'9', b'-', 0xff] {
                let mut bytes = whole.clone();
                bytes[at] = byte;
                check(&bytes);
            }
        }
    }
    for cut in 0..tubes.len() - 1 {
        // Cut in the last line the number may be another one, shorter; everywhere else the counts do not fit.
        let inside = tubes[cut..tubes.len() - 1].contains(&b'\n');
        assert!(!inside || read_tre(&tubes[..cut], &ReadOptions::default()).is_err(), "cut at {cut}");
    }
}

/// A labelled vessel with a gap beside it: what infer splits keeps its name.
#[test]
fn labels_reach_the_table_of_edges_on_both_sides_of_a_split() {
    let folder = tempfile::tempdir().unwrap();
    let trunk = (0..41).map(|x| format!("trunk,{x},0,0,1.5,L-M1\n"));
    let twig = (3..20).map(|y| format!("twig,20,{y},0,0.7,L-M2\n"));
    let rows: Vec<String> = ["fragment,x,y,z,radius,label\n".to_owned()].into_iter().chain(trunk).chain(twig).collect();
    std::fs::write(folder.path().join("a.csv"), rows.concat()).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_willis"));
    let output = command.current_dir(folder.path()).args(["infer", "a.csv", "-o", "out", "-q"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut rows = csv::Reader::from_path(folder.path().join("out/edges.csv")).unwrap();
    let column = |rows: &mut csv::Reader<_>, name: &str| rows.headers().unwrap().iter().position(|h| h == name).unwrap();
    let (label, origin) = (column(&mut rows, "label"), column(&mut rows, "origin"));
    let rows: Vec<_> = rows.records().map(Result::unwrap).collect();
    let count = |name: &str| rows.iter().filter(|r| &r[origin] == "observed" && &r[label] == name).count();
    assert!(count("L-M1") >= 2, "the trunk is not split");
    assert_eq!((count("L-M2"), count("")), (1, 0));
    assert!(rows.iter().filter(|r| &r[origin] == "candidate").all(|r| r[label].is_empty()));
}
