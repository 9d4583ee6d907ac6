//! Writers against our readers, bit for bit, and against NetworkX, igraph, SciPy and VTK; readers against broken files.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use std::io::Cursor;
use std::path::Path;

use crate::peers::python;
use willis::internals::formats::{
    Column, Content, ReadOptions, Values, graph_columns, read, read_csv_edges, read_csv_nodes, read_graphml, read_swc, read_vtp,
    write_csv, write_graphml, write_npy, write_npz, write_swc, write_vtp,
};
use willis::internals::network::units::{Scale, metres, millimetres, pascals};
use willis::internals::network::{
    Condition, ConditionFrom, Evidence, Network, Node, Origin, PathPoint, RadiusRule, Role, Vessel, contract, cycles,
};

fn mm() -> Scale {
    Scale::default()
}

/// Four nodes, a ring, a parallel vessel, a self-loop and a path; positions that millimetres cannot hold exactly.
fn network() -> Network {
    let mut network = Network::new();
    for (n, p) in [[0.0, 0.0, 0.0], [0.1, 0.0, 0.3], [1.0 / 3.0, 0.7, 1e-7], [2.0, 1e-3, -5.0]].into_iter().enumerate() {
        network.add_node(Node {
            also: Vec::new(),
            id: format!("n <{n}> & \"é\""),
            position: Some(p.map(metres)),
            radius: Some(metres(0.1 + n as f64 / 7.0)),
            label: if n == 2 { "L, \"M1\"".into() } else { String::new() },
            role: [Some(Role::Inlet), Some(Role::Inner), Some(Role::Inner), Some(Role::Outlet)][n],
            condition: [Some(Condition::Pressure(pascals(93.1))), None, None, Some(Condition::Pressure(0.0))][n],
            condition_from: [ConditionFrom::Landmark, ConditionFrom::Statement, ConditionFrom::Statement, ConditionFrom::FreeEnd]
                [n],
            at_border: false,
            is_source: false,
            root_score: None,
            windkessel: None,
        });
    }
    let end = |network: &Network, n: usize| PathPoint {
        position: network.node(n).position.unwrap(),
        radius: network.node(n).radius.unwrap(),
        id: None,
    };
    let bend = PathPoint { position: [0.05, 0.07, 0.11].map(metres), radius: metres(0.123_456_789), id: None };
    let along = Vessel::along(vec![end(&network, 0), bend, end(&network, 1)], RadiusRule::Mean);
    network.add_vessel([0, 1], along);
    let straight = |length: f64, radius: f64, origin| Vessel {
        length: metres(length),
        radius: metres(radius),
        resistance: None,
        label: String::new(),
        origin,
        prior: 0.3,
        certain: false,
        evidence: None,
        kept: None,
        wall: None,
        path: Vec::new(),
    };
    network.add_vessel([1, 2], straight(1.1, 0.7 / 3.0, Origin::Observed));
    network.add_vessel([2, 1], straight(1.3, 0.2, Origin::Candidate));
    network.add_vessel([2, 3], straight(7.7, 0.9, Origin::Observed));
    network.add_vessel([3, 0], straight(5.5, 0.3, Origin::Candidate));
    network.add_vessel([2, 2], straight(0.5, 0.3, Origin::Candidate));
    network
}

fn node_columns(network: &Network) -> Vec<Column> {
    let axis = |a: usize| Values::Real(network.nodes().map(|n| millimetres(n.position.unwrap()[a])).collect());
    let pressure = network.nodes().map(|n| match n.condition {
        Some(Condition::Pressure(p)) => willis::internals::network::units::mmhg(p),
        _ => f64::NAN,
    });
    vec![
        Column { name: "node".into(), values: Values::Integer((0..network.node_count() as i64).collect()) },
        Column { name: "id".into(), values: Values::Text(network.nodes().map(|n| n.id.clone()).collect()) },
        Column { name: "x_mm".into(), values: axis(0) },
        Column { name: "y_mm".into(), values: axis(1) },
        Column { name: "z_mm".into(), values: axis(2) },
        Column {
            name: "radius_mm".into(),
            values: Values::Real(network.nodes().map(|n| millimetres(n.radius.unwrap())).collect()),
        },
        Column { name: "label".into(), values: Values::Text(network.nodes().map(|n| n.label.clone()).collect()) },
        Column { name: "role".into(), values: Values::Text(network.nodes().map(|n| n.role.unwrap().name()).collect()) },
        Column { name: "pressure_mmHg".into(), values: Values::Real(pressure.collect()) },
        Column {
            name: "found".into(),
            values: Values::Text(network.nodes().map(|n| n.condition_from.name().to_owned()).collect()),
        },
    ]
}

fn vessel_columns(network: &Network) -> Vec<Column> {
    let real = |f: &dyn Fn(&Vessel) -> f64| Values::Real(network.vessels().map(|(_, v)| f(v)).collect());
    vec![
        Column { name: "node_a".into(), values: Values::Integer(network.vessels().map(|(e, _)| e[0] as i64).collect()) },
        Column { name: "node_b".into(), values: Values::Integer(network.vessels().map(|(e, _)| e[1] as i64).collect()) },
        Column { name: "length_mm".into(), values: real(&|v| millimetres(v.length)) },
        Column { name: "radius_mm".into(), values: real(&|v| millimetres(v.radius)) },
        Column { name: "prior".into(), values: real(&|v| v.prior) },
        Column { name: "origin".into(), values: Values::Text(network.vessels().map(|(_, v)| v.origin.name()).collect()) },
        Column {
            name: "likelihood".into(),
            values: Values::Real((0..network.vessel_count()).map(|r| [f64::NAN, f64::INFINITY, 1e-300][r % 3]).collect()),
        },
    ]
}

fn assert_same(a: &Network, b: &Network, with_paths: bool) {
    assert!(a.nodes().eq(b.nodes()), "{:?}\n{:?}", a.nodes().collect::<Vec<_>>(), b.nodes().collect::<Vec<_>>());
    assert_eq!(a.vessel_count(), b.vessel_count());
    for ((ends, v), (other, w)) in a.vessels().zip(b.vessels()) {
        assert_eq!(ends, other);
        let path = if with_paths { v.path.clone() } else { Vec::new() };
        assert_eq!(&Vessel { path, ..v.clone() }, w);
    }
}

#[test]
fn graphml_written_and_read_again_is_the_same_to_the_last_bit() {
    let network = network();
    let mut bytes = Vec::new();
    write_graphml(&mut bytes, &network, &node_columns(&network), &vessel_columns(&network)).unwrap();
    let (again, notes) = read_graphml(&bytes[..], &ReadOptions::default()).unwrap();
    assert_same(&network, &again, true);
    assert!(notes.is_empty());
    let short = [Column { name: "prior".into(), values: Values::Real(vec![1.0]) }];
    assert!(write_graphml(Vec::new(), &network, &[], &short).is_err());
}

/// Programs that hold undirected graphs write the ends of an edge in either order; all that belongs to an end goes with it. And what a run kept is
/// told again.
#[test]
fn graphml_with_its_ends_swapped_is_the_same_to_the_last_bit() {
    let mut network = network();
    for row in [0, 2, 5] {
        let vessel = network.vessel_mut(row);
        let evidence = Evidence { attached: [0.2, 0.4], continuation_odds: [3.0, 0.5], ..Evidence::undirected(0.6) };
        (vessel.evidence, vessel.kept) = (Some(Box::new(evidence)), Some(row != 2));
    }
    let (nodes, vessels) = graph_columns(&network);
    let mut bytes = Vec::new();
    write_graphml(&mut bytes, &network, &nodes, &vessels).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let swapped = text.replace(" source=", " was=").replace(" target=", " source=").replace(" was=", " target=");
    for text in [&text, &swapped] {
        let (again, notes) = read_graphml(text.as_bytes(), &ReadOptions::default()).unwrap();
        assert_same(&network, &again, true);
        assert!(notes.is_empty(), "{notes:?}");
    }
    // A node that was moved, at one end of its points.
    let moved = text.replacen(">0.3</data>", ">9.5</data>", 1);
    assert_ne!(moved, text);
    let found = read_graphml(moved.as_bytes(), &ReadOptions::default()).unwrap_err().in_file(Path::new("g")).to_string();
    let said = "lies at 0.1 0 9.5 and its end of points at 0.1 0 0.3; expected points from node to node, or none";
    assert!(found.ends_with(said), "{found}");
    // A candidate whose node was moved by hand too.
    let beside = moved.replace(">observed</data>", ">candidate</data>");
    assert!(
        read_graphml(beside.as_bytes(), &ReadOptions::default()).unwrap_err().in_file(Path::new("g")).to_string().ends_with(said)
    );
}

#[test]
fn csv_written_and_read_again_is_the_same_to_the_last_bit() {
    let network = network();
    let folder = tempfile::tempdir().unwrap();
    for (edges, nodes) in [("edges.csv", "nodes.csv"), ("my-edges.csv", "my-nodes.csv"), ("graph.csv", "nodes.csv")] {
        let (edges, nodes) = (folder.path().join(edges), folder.path().join(nodes));
        write_csv(std::fs::File::create(&nodes).unwrap(), &node_columns(&network)).unwrap();
        write_csv(std::fs::File::create(&edges).unwrap(), &vessel_columns(&network)).unwrap();
        let document = read(&edges, &ReadOptions::default()).unwrap();
        let Content::Graph(again) = document.content else { panic!() };
        assert_same(&network, &again, false);
        assert_eq!(document.notes, [format!("nodes are those of {}", nodes.display())]);
    }
}

#[test]
fn swc_written_and_read_again_is_the_same_to_the_last_bit() {
    let network = network();
    assert_eq!(write_swc(Vec::new(), &network).unwrap().len(), willis::internals::network::cycles(&network));
    let (forest, _) = network.subgraph(|row| row == 0 || row == 3);
    let mut bytes = Vec::new();
    write_swc(&mut bytes, &forest).unwrap();
    let (lines, _) = read_swc(&bytes[..], &mm()).unwrap();
    let again = contract(&lines, RadiusRule::Mean, None).unwrap().network;
    assert_eq!((again.node_count(), again.vessel_count(), cycles(&again)), (4, 2, 0));
    assert_eq!(again.vessel(0).length.to_bits(), forest.vessel(0).length.to_bits());
    for row in 0..4 {
        assert_eq!((again.node(row).position, again.node(row).radius), (forest.node(row).position, forest.node(row).radius));
    }
    assert!(String::from_utf8(bytes).unwrap().lines().nth(2).unwrap().ends_with(" -1"));
}

#[test]
fn vtp_written_and_read_again_is_the_same_to_the_last_bit() {
    let network = network();
    let (simple, _) = network.subgraph(|row| matches!(row, 0 | 1 | 3 | 4));
    let mut bytes = Vec::new();
    write_vtp(&mut bytes, &simple, &vessel_columns(&simple)).unwrap();
    let (mut lines, notes) = read_vtp(&bytes, &ReadOptions::default()).unwrap();
    assert_eq!((lines.points.len(), lines.links.len(), notes.len()), (5, 5, 0));
    assert_eq!(lines.weld(1e-9), 0);
    for (row, id) in lines.ids.iter().enumerate().filter(|(_, id)| **id < 4) {
        let node = simple.node(*id as usize);
        assert_eq!((Some(lines.points[row]), Some(lines.radii[row])), (node.position, node.radius));
    }
    assert!(lines.radii.contains(&metres(0.123_456_789)));
}

#[test]
fn tables_hold_numbers_that_come_back() {
    let mut bytes = Vec::new();
    let columns = [
        Column { name: "a".into(), values: Values::Real(vec![1.0, f64::NAN, f64::NEG_INFINITY, 0.1 + 0.2, 1e-300, -1e22]) },
        Column { name: "b".into(), values: Values::Integer(vec![1, 2, 3, 4, 5, -6]) },
        Column { name: "c".into(), values: Values::Text(["", "x,y", "\"q\"", "é", "", "l\nm"].into_iter().collect()) },
    ];
    write_csv(&mut bytes, &columns).unwrap();
    let expected = "a,b,c\n1,1,\n,2,\"x,y\"\n-inf,3,\"\"\"q\"\"\"\n0.30000000000000004,4,é\n1e-300,5,\n-1e22,-6,\"l\nm\"\n";
    assert_eq!(String::from_utf8(bytes).unwrap(), expected);
    let uneven = [
        Column { name: "a".into(), values: Values::Integer(vec![]) },
        Column { name: "b".into(), values: Values::Integer(vec![1]) },
    ];
    assert!(write_csv(Vec::new(), &uneven).is_err());
}

#[test]
fn matrices_refuse_entries_outside_and_repeat_their_bytes() {
    assert!(write_npz(Cursor::new(Vec::new()), 2, &[(0, 2, 1.0)]).is_err());
    assert!(write_npy(Vec::new(), 2, &[(2, 0, 1.0)]).is_err());
    let written = || {
        let mut out = Cursor::new(Vec::new());
        write_npz(&mut out, 3, &[(0, 1, 0.1), (0, 1, 0.2)]).unwrap();
        out.into_inner()
    };
    assert_eq!(written(), written());
}

#[test]
fn python_reads_what_is_written() {
    let network = network();
    let folder = tempfile::tempdir().unwrap();
    let create = |name: &str| std::fs::File::create(folder.path().join(name)).unwrap();
    write_graphml(create("g.graphml"), &network, &node_columns(&network), &vessel_columns(&network)).unwrap();
    write_vtp(create("t.vtp"), &network, &vessel_columns(&network)).unwrap();
    let entries = [(0, 1, 0.1), (1, 0, 0.2), (2, 2, 4.0), (0, 1, 0.3), (3, 0, 1e-300)];
    write_npz(create("l.npz"), 5, &entries).unwrap();
    write_npy(create("l.npy"), 5, &entries).unwrap();
    let script = r#"
import sys, math, numpy, scipy.sparse, networkx, igraph, vtk
d = sys.argv[1]
g = networkx.read_graphml(d + '/g.graphml')
assert g.number_of_nodes() == 4 and g.number_of_edges() == 6 and g.is_multigraph() and not g.is_directed()
n = g.nodes['n <2> & "é"']
assert n['x_mm'] == 1/3 and n['label'] == 'L, "M1"' and n['node'] == 2 and 'pressure_mmHg' not in n
e = list(g.edges(data=True)); assert 'points' in e[0][2] and any(x[2].get('likelihood') == math.inf for x in e)
networkx.write_graphml(g, d + '/nx.graphml')
i = igraph.Graph.Read_GraphML(d + '/g.graphml')
assert i.vcount() == 4 and i.ecount() == 6 and i.vs[2]['x_mm'] == 1/3 and i.es[1]['likelihood'] == math.inf
i.write_graphml(d + '/ig.graphml')
r = vtk.vtkXMLPolyDataReader(); r.SetFileName(d + '/t.vtp'); r.Update(); p = r.GetOutput()
assert p.GetNumberOfLines() == 6 and p.GetNumberOfPoints() == 5 and p.GetCell(0).GetNumberOfPoints() == 3
assert p.GetPoint(2) == (1/3, 0.7, 1e-7), p.GetPoint(2)
assert p.GetPointData().GetArray('MaximumInscribedSphereRadius').GetValue(1) == 0.1 + 1/7
c = p.GetCellData(); assert c.GetNumberOfArrays() == 7
assert [c.GetAbstractArray('origin').GetValue(k) for k in range(6)] == ['observed', 'observed', 'candidate', 'observed', 'candidate', 'candidate']
assert c.GetArray('node_a').GetValue(3) == 2 and c.GetArray('length_mm').GetValue(1) == 1.1
m = scipy.sparse.load_npz(d + '/l.npz'); a = numpy.load(d + '/l.npy')
assert m.format == 'csr' and m.has_sorted_indices and m.has_canonical_format and m.shape == (5, 5) and m.indices.dtype == numpy.int32
assert (m.toarray() == a).all() and (a == a.T).all() and a.flags['C_CONTIGUOUS'] and a.dtype == numpy.float64
assert a[0, 1] == (0.1 + 0.2) + 0.3 and a[2, 2] == 4 and a[3, 0] == 1e-300 and m.nnz == 5
print('ok')
"#;
    if python(script, &[folder.path()]).as_deref() == Some("ok") {
        for name in ["nx.graphml", "ig.graphml"] {
            let Content::Graph(again) = read(&folder.path().join(name), &ReadOptions::default()).unwrap().content else {
                panic!()
            };
            assert_eq!((again.node_count(), again.vessel_count(), cycles(&again)), (4, 6, 3), "{name}");
            let mut lengths: Vec<f64> = again.vessels().map(|(_, v)| v.length).collect();
            let mut expected: Vec<f64> = network.vessels().map(|(_, v)| v.length).collect();
            lengths.sort_by(f64::total_cmp);
            expected.sort_by(f64::total_cmp);
            for (found, expected) in lengths.iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-13, "{name}");
            }
        }
    }
}

/// Cuts and spoils valid files at many places: every reader must answer, whatever it answers.
#[test]
fn broken_files_never_panic() {
    let network = network();
    let mut files: Vec<(&str, Vec<u8>)> = Vec::new();
    let mut graphml = Vec::new();
    write_graphml(&mut graphml, &network, &node_columns(&network), &vessel_columns(&network)).unwrap();
    files.push(("graphml", graphml));
    let mut vtp = Vec::new();
    write_vtp(&mut vtp, &network, &vessel_columns(&network)).unwrap();
    files.push(("vtp", vtp));
    let ascii = br#"<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="2" NumberOfLines="1"><PointData>
<DataArray type="Float32" Name="Radius" format="ascii">1 2</DataArray></PointData><Points>
<DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0</DataArray></Points><Lines>
<DataArray type="Int64" Name="connectivity" format="ascii">1 0</DataArray><DataArray type="Int8" Name="offsets" format="ascii">2
</DataArray></Lines></Piece></PolyData></VTKFile>"#;
    assert!(read_vtp(ascii, &ReadOptions::default()).is_ok());
    files.push(("vtp", ascii.to_vec()));
    let (forest, _) = network.subgraph(|row| row == 0 || row == 3);
    let mut swc = Vec::new();
    write_swc(&mut swc, &forest).unwrap();
    files.push(("swc", swc));
    let mut csv = Vec::new();
    write_csv(&mut csv, &vessel_columns(&network)).unwrap();
    files.push(("csv", csv));
    for name in ["formats/y-xml-appended.vtp", "formats/y-vmtknetworkextraction.vtp", "brava/vtp/BG0002_ColorCoded.CNG.vtp"] {
        match std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name)) {
            Ok(bytes) => files.push(("vtp", bytes)),
            Err(_) => eprintln!("skipped: no {name} beside the package"),
        }
    }
    let feed = |kind: &str, bytes: &[u8]| match kind {
        "graphml" => drop(read_graphml(bytes, &ReadOptions::default())),
        "vtp" => drop(read_vtp(bytes, &ReadOptions::default())),
        "swc" => drop(read_swc(bytes, &mm())),
        _ => {
            drop(read_csv_nodes(bytes, &mm()));
            drop(read_csv_edges(bytes, None, &ReadOptions::default()));
        }
    };
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for (kind, bytes) in &files {
        let rounds = if bytes.len() > 20_000 { 150 } else { 1500 };
        for _ in 0..rounds {
            feed(kind, &bytes[..random(bytes.len())]);
            let mut spoiled = bytes.clone();
            for _ in 0..=random(3) {
                let at = random(spoiled.len());
                match random(4) {
                    0 => spoiled[at] = random(256) as u8,
                    1 => spoiled[at] = b"0123456789-.e\"<>/= ,;"[random(21)],
                    2 => drop(spoiled.remove(at)),
                    _ => spoiled.insert(at, b"9A0/"[random(4)]),
                }
            }
            feed(kind, &spoiled);
        }
    }
}
