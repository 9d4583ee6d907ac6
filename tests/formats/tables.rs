//! Tables of nodes and edges: Voreen's, VesselVio's and willis's own, against what is written in them by hand, pandas and igraph.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use crate::peers::{courses, network_of, positions, python, read_first, sizes, truncated};
use willis::internals::formats::{
    Content, Format, ReadOptions, graph_columns, number, read_csv_edges, read_csv_nodes, read_graphml, unit_check,
    write_csv_graph, write_graphml, write_vesselvio, write_voreen,
};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::{LengthUnit, Scale, metres, millimetres, pascals};
use willis::internals::network::{Condition, Network, Node, Origin, PathPoint, RadiusRule, Role, Vessel};
use willis::internals::phantom::{cerebral, circle_of_willis};
use willis::write;

const VOREEN_NODES: &str = "id;pos_x;pos_y;pos_z;degree;isAtSampleBorder
0;0;0;0;1;1
7;10;0;0;3;0
8;20;5;0;1;0
9;20;-5;0.5;1;1
";
/// Areas 4π and π/4; the others are marked invalid.
const VOREEN_EDGES: &str = "id;node1id;node2id;length;distance;curveness;volume;avgCrossSection;minRadiusAvg;minRadiusStd;\
avgRadiusAvg;avgRadiusStd;maxRadiusAvg;maxRadiusStd;roundnessAvg;roundnessStd;node1_degree;node2_degree;num_voxels;hasNodeAtSampleBorder
0;0;7;10.5;10;1.05;131;12.566370614359172;1;0;9;0;3;0;0.6;0.1;1;3;9;1
1;7;8;11.25;11.1803;1.006;9;-1;-1;-1;1.5;-1;-1;-1;-1;-1;3;1;0;0
2;9;7;-1;11.2;-1;9;0.7853981633974483;-1;-1;-1;-1;-1;-1;-1;-1;1;3;0;0
";

fn mm() -> ReadOptions {
    ReadOptions::default()
}

fn optional() -> ReadOptions {
    ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() }
}

#[test]
fn voreen_is_read_from_either_table_under_the_names_it_has() {
    let names = [
        ("a_nodes.csv", "a_edges.csv"),
        ("nodes.csv", "edges.csv"),
        ("vertices.csv", "edges.csv"),
        ("1_nodes_b.csv", "1_edges_b.csv"),
    ];
    for (nodes, edges) in names {
        for given in [nodes, edges] {
            let mut files = vec![(nodes, VOREEN_NODES.as_bytes()), (edges, VOREEN_EDGES.as_bytes())];
            files.sort_by_key(|(name, _)| *name != given);
            let document = read_first(&files, &mm()).unwrap();
            assert_eq!(document.format, Format::Voreen);
            assert!(matches!(document.content, Content::Vessels(_)));
            let other =
                if given == nodes { format!("edges are those of {edges}") } else { format!("nodes are those of {nodes}") };
            let notes = [
                "the radius of 2 edges is sqrt(avgCrossSection/π)",
                "the radius of 1 edge is avgRadiusAvg, since the cross-section is missing",
                "1 edge without a valid length: took the distance between the nodes",
                &other,
            ];
            assert_eq!(document.notes, notes);
            let network = network_of(document);
            assert!(network.vessels().all(|(_, v)| v.origin == Origin::Observed));
            assert_eq!(network.nodes().map(|n| n.id.as_str()).collect::<Vec<_>>(), ["0", "7", "8", "9"]);
            assert_eq!(positions(&network), [[0.0; 3], [10.0, 0.0, 0.0], [20.0, 5.0, 0.0], [20.0, -5.0, 0.5]]);
            let none = String::new;
            let expected = [([0, 1], none(), 10.5, 2.0), ([1, 2], none(), 11.25, 1.5), ([3, 1], none(), 125.25_f64.sqrt(), 0.5)];
            for (found, expected) in sizes(&network).iter().zip(&expected) {
                assert!(found.0 == expected.0 && (found.2 - expected.2).abs() < 1e-12 && (found.3 - expected.3).abs() < 1e-12);
            }
        }
    }
    let um =
        ReadOptions { scale: Scale { unit: willis::internals::network::units::LengthUnit::Micrometre, spacing: None }, ..mm() };
    let files = [("edges.csv", VOREEN_EDGES.as_bytes()), ("nodes.csv", VOREEN_NODES.as_bytes())];
    let network = network_of(read_first(&files, &um).unwrap());
    assert!((network.vessel(0).radius - 2e-6).abs() < 1e-18 && (network.vessel(0).length - 10.5e-6).abs() < 1e-18);
}

#[test]
fn voreen_edges_without_a_radius_need_the_default() {
    let edges = VOREEN_EDGES.replace("0.7853981633974483", "-1");
    let files = [("a_edges.csv", edges.as_bytes()), ("a_nodes.csv", VOREEN_NODES.as_bytes())];
    let said = read_first(&files, &mm()).unwrap_err();
    let accepted = "expected a positive avgCrossSection or avgRadiusAvg, or give `default_radius`";
    assert_eq!(said, format!("a_edges.csv:4: edge 2: no valid radius; {accepted}"));
    let network = network_of(read_first(&files, &optional()).unwrap());
    assert!(network.vessel(2).radius.is_nan() && network.vessel(1).radius == metres(1.5));
    // The command fills it in.
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let run = |more: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_willis"));
        let arguments = ["candidates", "a_nodes.csv", "-o", "graph.graphml"];
        command.current_dir(folder.path()).args(arguments).args(more).output().unwrap()
    };
    assert_eq!(run(&[]).status.code(), Some(2));
    let output = run(&["--default-radius", "0.25mm"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let graph =
        read_graphml(&std::fs::read(folder.path().join("graph.graphml")).unwrap()[..], &ReadOptions::default()).unwrap().0;
    let radius = |row| millimetres(graph.vessel(row).radius);
    assert!(radius(2) == 0.25 && radius(1) == 1.5, "{} {}", radius(1), radius(2));
}

#[test]
fn the_header_tells_rows_from_names() {
    // The ids are not the rows; VesselVio goes by rows.
    let vertices = "id,X,Y,Z\n2,0,0,0\n1,0,0,1\n0,0,0,3\n";
    let edges = "Source ID,Target ID,radius_avg,length,label\n0,1,0.5,1.5,M1\n2,1,0.25,,\n";
    let document = read_first(&[("edges.csv", edges.as_bytes()), ("vertices.csv", vertices.as_bytes())], &mm()).unwrap();
    assert_eq!(document.format, Format::VesselVio);
    let notes = [
        "edges refer to vertices by row, as VesselVio's do",
        "1 edge without length: took the distance between the vertices",
        "nodes are those of vertices.csv",
    ];
    assert_eq!(document.notes, notes);
    let network = network_of(document);
    assert_eq!(sizes(&network), [([0, 1], "M1".into(), 1.5, 0.5), ([2, 1], String::new(), 2.0, 0.25)]);
    // source and target are names, where the nodes have names, and rows where they have none.
    let plain = edges.replace("Source ID,Target ID", "source,target").replace("radius_avg", "radius");
    let document = read_first(&[("edges.csv", plain.as_bytes()), ("vertices.csv", vertices.as_bytes())], &mm()).unwrap();
    assert_eq!(document.format, Format::Csv);
    assert_eq!(network_of(document).ends(0), [2, 1]);
    let nameless = vertices.replace("id,", "").replace("\n2,", "\n").replace("\n1,", "\n").replacen("\n0,0,0,3", "\n0,0,3", 1);
    for files in [
        [("x_edges.csv", plain.as_bytes()), ("x_vertices.csv", nameless.as_bytes())],
        [("x_vertices.csv", nameless.as_bytes()), ("x_edges.csv", plain.as_bytes())],
    ] {
        let document = read_first(&files, &mm()).unwrap();
        assert_eq!(document.format, Format::VesselVio);
        assert_eq!(network_of(document).ends(0), [0, 1]);
    }
}

#[test]
fn vertices_with_radii_are_centerlines() {
    let vertices = "X;Y;Z;radius\n0;0;0;1\n1;0;0;2\n2;0;0;3\n3;1;0;3\n3;-1;0;3\n";
    let edges = "Source ID;Target ID\n0;1\n1;2\n2;3\n4;2.0\n";
    let files = [("edges.csv", edges.as_bytes()), ("vertices.csv", vertices.as_bytes())];
    let document = read_first(&files, &mm()).unwrap();
    assert!(matches!(document.content, Content::Centerlines(_)));
    let network = network_of(document);
    assert_eq!((network.node_count(), network.vessel_count()), (4, 3));
    assert_eq!(courses(&network)[0].2, [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 2.0], [2.0, 0.0, 0.0, 3.0]]);
    let said =
        read_first(&[("edges.csv", edges.as_bytes()), ("vertices.csv", vertices.replace("radius", "r").as_bytes())], &mm());
    let accepted = "expected radius_avg here or radius with the vertices, or give `default_radius`";
    assert_eq!(said.unwrap_err(), format!("edges.csv:1: no radius; {accepted}"));
}

/// Two vessels with a course, which share a junction with a third; a parallel pair; figures that no decimal holds.
fn curved() -> Network {
    let mut network = Network::new();
    let at = [[0.0, 0.0, 0.0], [1.0 / 3.0, 0.1, 2.0], [5.0, 0.7, 1e-7], [5.5, -3.0, 1.0]];
    let radius = [0.7, 1.0 / 7.0, 0.3, 0.21];
    for (row, p) in at.iter().enumerate() {
        let (position, radius) = (Some(p.map(metres)), Some(metres(radius[row])));
        network.add_node(Node { id: row.to_string(), position, radius, ..Node::default() });
    }
    let mut add = |[a, b]: [usize; 2], inner: &[[f64; 4]], label: &str| {
        let end = |n: usize| PathPoint { position: at[n].map(metres), radius: metres(radius[n]), id: None };
        let point = |p: &[f64; 4]| PathPoint { position: [p[0], p[1], p[2]].map(metres), radius: metres(p[3]), id: None };
        let path = [end(a)].into_iter().chain(inner.iter().map(point)).chain([end(b)]).collect();
        network.add_vessel([a, b], Vessel { label: label.to_owned(), ..Vessel::along(path, RadiusRule::Mean) });
    };
    add([0, 1], &[[0.1, 0.05, 1.0, 0.6]], "L, \"M1\"; é");
    add([1, 2], &[[3.0, 0.0, 0.1, 0.3], [4.0, 0.1, 0.1, 0.2]], "");
    add([1, 2], &[[3.0, 2.0, 0.1, 0.1]], "b");
    add([2, 3], &[], "");
    network
}

/// Vessels of which only ends, length and radius are known: a parallel one and a self-loop among them.
fn straight() -> Network {
    let mut network = curved();
    let mut ends: Vec<_> = network.vessels().map(|(ends, v)| (ends, v.clone())).collect();
    ends.push(([3, 3], ends[0].1.clone()));
    network = network.subgraph(|_| false).0;
    for (row, (ends, vessel)) in ends.into_iter().enumerate() {
        let (length, radius) = (metres(7.0 + row as f64 / 3.0), metres(0.1 + row as f64 / 7.0));
        network.add_vessel(ends, Vessel { length, radius, path: Vec::new(), ..vessel });
    }
    network
}

/// The vessels keep the points of a network without paths: only their lengths and radii.
fn same_sizes(found: &Network, expected: &Network) {
    assert_eq!(positions(found), positions(expected));
    assert_eq!(sizes(found), sizes(expected));
}

#[test]
fn what_voreen_s_writer_writes_is_read_back_and_read_by_pandas() {
    for network in [curved(), straight()] {
        let (mut nodes, mut edges) = (Vec::new(), Vec::new());
        write_voreen(&mut nodes, &mut edges, &network).unwrap();
        let document = read_first(&[("a_edges.csv", &edges), ("a_nodes.csv", &nodes)], &mm()).unwrap();
        same_sizes(&network_of(document), &network);
        let folder = tempfile::tempdir().unwrap();
        let paths = ["nodes.csv", "edges.csv"].map(|name| folder.path().join(name));
        std::fs::write(&paths[0], &nodes).unwrap();
        std::fs::write(&paths[1], &edges).unwrap();
        let script = "
import sys, numpy as np, pandas as pd
n, e = (pd.read_csv(p, sep=';') for p in sys.argv[1:])
assert list(n) == 'id;pos_x;pos_y;pos_z;degree;isAtSampleBorder'.split(';')
assert list(e)[:20] == '''id;node1id;node2id;length;distance;curveness;volume;avgCrossSection;minRadiusAvg;minRadiusStd;avgRadiusAvg;\
avgRadiusStd;maxRadiusAvg;maxRadiusStd;roundnessAvg;roundnessStd;node1_degree;node2_degree;num_voxels;hasNodeAtSampleBorder'''.split(';')
assert list(e)[20:] == ['label'] and e.label[0] == 'L, \"M1\"; é'
ends = e[['node1id', 'node2id']].to_numpy()
degree = np.bincount(ends.ravel(), minlength=len(n))
assert (n.degree == degree).all() and (e.node1_degree == degree[ends[:, 0]]).all() and (n.isAtSampleBorder == -1).all()
p = n[['pos_x', 'pos_y', 'pos_z']].to_numpy()
assert np.allclose(e.distance, np.linalg.norm(p[ends[:, 0]] - p[ends[:, 1]], axis=1))
assert np.allclose(e.avgCrossSection, np.pi * e.avgRadiusAvg**2) and np.allclose(e.volume, e.avgCrossSection * e.length)
open_ = ends[:, 0] != ends[:, 1]
assert np.allclose(e.curveness[open_], (e.length / e.distance)[open_]) and (e.curveness[~open_] == -1).all()
assert (e[['minRadiusAvg', 'num_voxels', 'hasNodeAtSampleBorder']] == -1).all(axis=None)
";
        python(script, &[&paths[0], &paths[1]]);
    }
}

#[test]
fn what_vesselvio_s_writer_writes_is_read_back_and_loads_as_vesselvio_loads() {
    let written = |network: &Network| {
        let (mut vertices, mut edges) = (Vec::new(), Vec::new());
        write_vesselvio(&mut vertices, &mut edges, network).unwrap();
        (vertices, edges)
    };
    let (vertices, edges) = written(&curved());
    let found = network_of(read_first(&[("edges.csv", &edges), ("vertices.csv", &vertices)], &mm()).unwrap());
    assert_eq!(positions(&found), positions(&curved()));
    assert_eq!(courses(&found)[..3], courses(&curved())[..3]);
    let (branch_vertices, branch_edges) = written(&straight());
    let files = [("edges.csv", &branch_edges[..]), ("vertices.csv", &branch_vertices[..])];
    same_sizes(&network_of(read_first(&files, &mm()).unwrap()), &straight());
    let folder = tempfile::tempdir().unwrap();
    let files = [("v", vertices), ("e", edges), ("bv", branch_vertices), ("be", branch_edges)];
    let paths = files.map(|(name, bytes)| {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        folder.path().join(name)
    });
    // The columns that VesselVio's graph_io takes under its default names.
    let script = "
import sys, pandas, igraph as ig, numpy as np
def load(v, e, keys):
    v, e = pandas.read_csv(v, delimiter=','), pandas.read_csv(e, delimiter=',')
    g = ig.Graph(); g.add_vertices(len(v)); g.vs['at'] = np.stack([v['Z'], v['Y'], v['X']], axis=1)
    g.add_edges(np.stack([e['Source ID'], e['Target ID']], axis=1))
    for k in keys: g.es[k] = e[k]
    return g, v, e
g, v, e = load(sys.argv[1], sys.argv[2], [])
assert (v['radius'] > 0).all() and g.degree() == [1, 3, 3, 1, 2, 2, 2, 2], g.degree()
g, v, e = load(sys.argv[3], sys.argv[4], ['radius_avg', 'length', 'tortuosity', 'volume', 'surface_area'])
assert g.degree() == [1, 3, 3, 3] and np.allclose(g.es['volume'], np.pi * e.radius_avg**2 * e.length)
assert np.allclose(e.surface_area, 2 * np.pi * e.radius_avg * e.length)
";
    python(script, &[&paths[0], &paths[1], &paths[2], &paths[3]]);
}

#[test]
fn two_vessels_that_points_cannot_tell_apart_are_refused() {
    let mut network = curved();
    network.add_vessel([3, 2], Vessel { path: Vec::new(), ..network.vessel(3).clone() });
    network.vessel_mut(3).path.clear();
    let said = write_vesselvio(Vec::new(), Vec::new(), &network).unwrap_err().to_string();
    assert!(said.starts_with("vessel 4 (3 - 2) has no points of its own"), "{said}");
    network.node_mut(0).position = None;
    assert_eq!(write_voreen(Vec::new(), Vec::new(), &network).unwrap_err().to_string(), "node 0 has no position");
}

#[test]
fn the_tables_of_a_graph_keep_all_that_graphml_keeps() {
    let mut network = curved();
    for (row, vessel) in straight().vessels().map(|(_, v)| v.clone()).enumerate() {
        network.add_vessel([row % 4, 3], Vessel { origin: Origin::Candidate, prior: 0.3, certain: row == 1, ..vessel });
    }
    network.vessel_mut(5).resistance = Some(1e9);
    network.node_mut(0).id = "a,\"b\"".into();
    network.node_mut(0).role = Some(Role::Inlet);
    network.node_mut(0).condition = Some(Condition::Pressure(pascals(93.1)));
    network.node_mut(3).role = Some(Role::Outlet);
    network.node_mut(3).condition = Some(Condition::Resistance { resistance: 1e9, venous: pascals(5.0) }.as_stored());
    let (mut nodes, mut edges, mut graphml) = (Vec::new(), Vec::new(), Vec::new());
    write_csv_graph(&mut nodes, &mut edges, &network).unwrap();
    let (node_columns, vessel_columns) = graph_columns(&network);
    write_graphml(&mut graphml, &network, &node_columns, &vessel_columns).unwrap();
    let table = read_csv_nodes(&nodes[..], &Scale::default()).unwrap();
    let by_tables = read_csv_edges(&edges[..], Some(table), &ReadOptions::default()).unwrap().0;
    let by_graphml = read_graphml(&graphml[..], &ReadOptions::default()).unwrap().0;
    for found in [by_tables, by_graphml] {
        for (found, expected) in found.nodes().zip(network.nodes()) {
            let inner = Node { role: found.role.filter(|r| *r != Role::Inner), ..found.clone() };
            assert_eq!(inner, *expected);
        }
        assert_eq!(found.vessels().collect::<Vec<_>>(), network.vessels().collect::<Vec<_>>());
    }
}

#[test]
fn any_delimiter_mark_and_line_end_is_taken() {
    let nodes = "node,x,y,z,radius\na,0,0,0,1\nb,3,4,0,2\n";
    let edges = "node_a,node_b,label\na,b,M1\n";
    let read = |edges: &[u8], nodes: &[u8]| network_of(read_first(&[("edges.csv", edges), ("nodes.csv", nodes)], &mm()).unwrap());
    let plain = read(edges.as_bytes(), nodes.as_bytes());
    assert_eq!(sizes(&plain), [([0, 1], "M1".to_owned(), 5.0, 1.0)]);
    let variants: [fn(&str) -> String; 9] = [
        |t| t.replace(',', ";"),
        |t| t.replace(',', "\t"),
        |t| format!("\u{feff}{t}"),
        |t| t.replace('\n', "\r\n"),
        |t| t.replacen('\n', "\r\n", 2),
        |t| format!("# made by hand\n\n{t}"),
        |t| t.trim_end().replace(',', " , "),
        |t| t.replace('\n', "\r"),
        |t| format!("# one; two; three; four\n\n{t}").replace('\n', "\r"),
    ];
    for variant in variants {
        assert_eq!(sizes(&read(variant(edges).as_bytes(), variant(nodes).as_bytes())), sizes(&plain), "{}", variant(edges));
    }
}

/// Zero and less mean that nothing was measured, as in the tables of Voreen and VesselVio; points that an edge has come first.
#[test]
fn the_default_radius_is_for_edges_whose_radius_is_not_positive() {
    let options = ReadOptions { default_radius: Some(5e-4), ..ReadOptions::default() };
    let edges = "node_a,node_b,length_mm,radius_mm,points\n0,1,4,1,\n1,2,3,0,\n1,3,3,-1,\n2,3,1,,\n0,3,2,-1,0 0 0 2;2 0 0 2\n";
    let document = read_first(&[("a.csv", edges.as_bytes())], &options).unwrap();
    let built = document.content.into_network(RadiusRule::Mean, options.default_radius).unwrap();
    let radii: Vec<f64> = sizes(&built.network).into_iter().map(|(.., radius)| radius).collect();
    assert!(radii.iter().zip([1.0, 0.5, 0.5, 0.5, 2.0]).all(|(found, wanted)| (found - wanted).abs() < 1e-12), "{radii:?}");
    assert_eq!(radii.len(), 5);
    assert_eq!(built.notes, ["3 vessels without any radius: took `default_radius`, 0.5 mm"]);
    let refused = read_first(&[("a.csv", edges.as_bytes())], &ReadOptions::default()).unwrap_err();
    assert_eq!(refused, "a.csv:3: edge 1 (1 - 2): radius_mm 0; expected a positive number, or give `default_radius`");
}

/// By hand: from 0,0,0 to 4,0,8 in voxels of .5 x .5 x 1 mm are 2 mm and 8 mm, whatever the length in voxels is.
#[test]
fn a_length_in_voxels_of_unequal_sides_is_that_of_the_course() {
    let scale = Scale { unit: LengthUnit::Voxel, spacing: Some([0.5, 0.5, 1.0]) };
    let nodes = read_csv_nodes(b"node,x,y,z\n0,0,0,0\n1,4,0,8\n", &scale).unwrap();
    let options = ReadOptions { scale, ..ReadOptions::default() };
    let table = b"node_a,node_b,radius,length\n0,1,2,10\n";
    let (network, notes) = read_csv_edges(table, Some(nodes), &options).unwrap();
    assert!((millimetres(network.vessel(0).length) - 68_f64.sqrt()).abs() < 1e-12, "{notes:?}");
}

#[test]
fn graphml_takes_the_names_of_other_programs() {
    let graph = |keys: &str, a: &str, b: &str, edge: &str| {
        let text = format!(
            "<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">{keys}<graph edgedefault=\"undirected\"><node id=\"n0\">{a}</node>\
             <node id=\"n1\">{b}</node><edge source=\"n0\" target=\"n1\">{edge}</edge></graph></graphml>"
        );
        read_graphml(text.as_bytes(), &ReadOptions::default()).map_err(|e| format!("{}; {}", e.found, e.accepted))
    };
    let key = |id: &str, on: &str| format!("<key id=\"{id}\" for=\"{on}\" attr.name=\"{id}\" attr.type=\"string\"/>");
    let pos = |text: &str| format!("<data key=\"pos\">{text}</data>");
    let sized = |name: &str, value: &str| {
        let keys = key("pos", "node") + &key(name, "edge");
        graph(&keys, &pos("[0, 0, 0]"), &pos("0x0p+0, 0x1.8p+1, 0x1p+2"), &format!("<data key=\"{name}\">{value}</data>"))
    };
    for (name, value, note) in [
        ("radius_avg", "2", "radius_avg"),
        ("avgRadiusAvg", "0x1p+1", "avgRadiusAvg"),
        ("diameter", "4", "half of diameter"),
        ("d", "4", "half of d"),
        ("r", "2", "r"),
        ("avgCrossSection", "12.566370614359172", "sqrt(avgCrossSection/π)"),
    ] {
        let (network, notes) = sized(name, value).unwrap();
        assert_eq!(sizes(&network), [([0, 1], String::new(), 5.0, 2.0)], "{name}");
        assert!(notes.contains(&format!("the radius of 1 edge is {note}")), "{notes:?}");
    }
    let accepted = "expected a positive number, or give `default_radius`";
    assert_eq!(sized("avgRadiusAvg", "-1").unwrap_err(), format!("edge 0 (n0 - n1): avgRadiusAvg -1; {accepted}"));
    let accepted = "expected radius_mm on the edge, or on both of its nodes, or `default_radius`";
    assert_eq!(sized("r", "red").unwrap_err(), format!("edge 0 (n0 - n1): no radius_mm; {accepted}"));
    let keys = key("pos", "node");
    let said = graph(&keys, &pos("1 2 x"), "", "").unwrap_err();
    assert_eq!(said, "node n0: pos \"1 2 x\"; expected three finite numbers");
    let keys = key("pos_x", "node") + &key("pos_y", "node") + &key("pos_z", "node") + &key("radius", "edge");
    let at = |x: f64| format!("<data key=\"pos_x\">{x}</data><data key=\"pos_y\">0</data><data key=\"pos_z\">0</data>");
    let network = graph(&keys, &at(0.0), &at(2.0), "<data key=\"radius\">1</data>").unwrap().0;
    assert_eq!(sizes(&network), [([0, 1], String::new(), 2.0, 1.0)]);
}

#[test]
fn every_malformed_table_is_one_clear_line() {
    let voreen =
        |edges: &str, nodes: &str| read_first(&[("edges.csv", edges.as_bytes()), ("nodes.csv", nodes.as_bytes())], &mm());
    let (nodes, edges) = (VOREEN_NODES, VOREEN_EDGES);
    let vesselvio = |edges: &str| {
        let vertices = b"X,Y,Z\n0,0,0\n0,0,1\n";
        read_first(&[("edges.csv", edges.as_bytes()), ("vertices.csv", vertices)], &mm())
    };
    let alone = |name: &str, text: &str| read_first(&[(name, text.as_bytes())], &mm());
    let utf16: Vec<u8> = "\u{feff}id;pos_x".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let headless = edges.replace("avgCrossSection", "area").replace("avgRadiusAvg", "mean");
    let some = "columns id,node1id,node2id,length,distance,curveness,volume,area and 12 more";
    let cases = [
        (
            voreen(edges, &nodes.replace("20;5;0", "20;5,5;0")),
            "nodes.csv:4: pos_y \"5,5\"; expected a decimal point, not a comma",
        ),
        (voreen(edges, &nodes.replace("20;5;0", "20;nan;0")), "nodes.csv:4: pos_y \"nan\"; expected a finite number"),
        (voreen(edges, &nodes.replace("\n8;", "\n7;")), "nodes.csv:4: id 7 comes twice; expected every node once"),
        (
            voreen(edges, &nodes.replace("id;", "name;")),
            "nodes.csv:1: columns name,pos_x,pos_y,pos_z,degree,isAtSampleBorder; \
          expected Voreen's table of nodes: a column id",
        ),
        (
            voreen(edges, &nodes.replace("9;20;-5;0.5;1;1\n", "")),
            "edges.csv:4: edge 2: node 9 is not in the table of nodes; expected an id of that table",
        ),
        (voreen(edges, &nodes.replace("10;0;0;3;0", "10;0;0")), "nodes.csv:3: 4 columns; expected 6, as in the header"),
        (
            voreen(&edges.replace("9;7;-1", "7;7;-1").replace("0;0;7;10.5", "0;0;7;ten"), nodes),
            "edges.csv:2: length \"ten\"; expected a number",
        ),
        (voreen(edges.lines().next().unwrap(), nodes), "edges.csv: no edges; expected a row for every edge"),
        (
            voreen(&headless, nodes),
            &format!("edges.csv:1: {some}; expected Voreen's table of edges: a column avgCrossSection or avgRadiusAvg"),
        ),
        (
            alone("edges.csv", edges),
            "edges.csv: no table of nodes beside it; expected two tables, with \"nodes\" for \"edges\" in its name, or nodes.csv and edges.csv",
        ),
        (
            alone("nodes.csv", nodes),
            "nodes.csv: no table of edges beside it; expected two tables, with \"nodes\" for \"edges\" in its name, or nodes.csv and edges.csv",
        ),
        (
            read_first(&[("edges.csv", edges.as_bytes()), ("nodes.csv", &utf16)], &mm()),
            "nodes.csv: the text is UTF-16; expected UTF-8; save the file as UTF-8",
        ),
        (
            read_first(&[("edges.csv", edges.as_bytes()), ("nodes.csv", b"")], &mm()),
            "nodes.csv: the table is empty; expected a header and rows",
        ),
        (
            vesselvio("Source ID,Target ID,radius_avg\n0,2,1\n"),
            "edges.csv:2: edge 0: Target ID \"2\"; expected a row of the vertices, 0 to 1",
        ),
        (vesselvio("Source ID,Target ID,radius_avg\n0,x,1\n"), "edges.csv:2: Target ID \"x\"; expected a number"),
        (
            vesselvio("Source ID,Target ID,radius_avg\n0,1,0\n"),
            "edges.csv:2: edge 0: radius_avg \"0\"; expected a positive number, or give `default_radius`",
        ),
        (
            vesselvio("Source ID,Target ID,radius_avg,length\n0,1,1,0\n"),
            "edges.csv:2: edge 0: no positive length; expected a positive length or different places",
        ),
        (vesselvio("Source ID,Target ID,radius_avg\n"), "edges.csv: no edges; expected a row for every edge"),
        (
            vesselvio("Source ID,Source ID,Target ID\n"),
            "edges.csv:1: column \"Source ID\" comes twice; expected every column once",
        ),
        (
            alone("a.csv", "node_a;node_b;length;radius\na;b;1,5;1\n"),
            "a.csv:2: edge 0 (a - b): length \"1,5\"; expected a decimal point, not a comma",
        ),
        (
            alone("a.csv", "a,b,c,d,e,f,g,h,i\n"),
            "a.csv:1: columns a,b,c,d,e,f,g,h and 1 more; expected a table of edges with columns node_a,node_b or source,target",
        ),
    ];
    let like = alone("a.csv", "edge,node_a,node_b,length_mm,mean_radius_mm\r\n0,a,b,1,2\r\n").unwrap_err();
    let accepted = "expected radius_mm on the edge, or on both of its nodes, or `default_radius`";
    assert_eq!(like, format!("a.csv:2: edge 0 (a - b): no radius_mm but mean_radius_mm; {accepted}"));
    let nodes_alone = alone("nodes.csv", "node,id,x_mm\na,a,1\n").unwrap_err();
    let accepted = "these are nodes; give the table of edges, with columns node_a,node_b or source,target";
    assert_eq!(nodes_alone, format!("nodes.csv:1: columns node,id,x_mm; {accepted}"));
    let commented = alone("nodes.csv", "# of a patient\n\nnode,id,x_mm\na,a,1\n").unwrap_err();
    assert_eq!(commented, format!("nodes.csv:3: columns node,id,x_mm; {accepted}"));
    for (read, expected) in cases {
        assert_eq!(read.expect_err(expected).as_str(), expected);
    }
}

#[test]
fn a_table_cut_anywhere_never_panics() {
    let (nodes, edges) = (("a_nodes.csv", VOREEN_NODES.as_bytes()), ("a_edges.csv", VOREEN_EDGES.as_bytes()));
    assert!(truncated(&[edges, nodes], 1, &mm()) > 0);
    assert!(truncated(&[nodes, edges], 1, &mm()) > 0);
    let (mut vertices, mut edges) = (Vec::new(), Vec::new());
    write_vesselvio(&mut vertices, &mut edges, &curved()).unwrap();
    assert!(truncated(&[("edges.csv", &edges), ("vertices.csv", &vertices)], 1, &mm()) > 0);
    assert!(truncated(&[("vertices.csv", &vertices), ("edges.csv", &edges)], 1, &mm()) > 0);
}

/// Two pairs of tables in one folder stay two; a pair that was torn apart is refused or told.
#[test]
fn tables_written_side_by_side_keep_their_own_nodes() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let networks = [1e-3, 3e-3].map(|size| cerebral(&circle_of_willis(size)));
    let networks = [networks[0].clone(), scaled(&networks[1], 300.0)];
    for (network, name) in networks.iter().zip(["A.csv", "B.csv"]) {
        write(network, &place(name), None, true).unwrap();
    }
    let mut names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["A.csv", "A.nodes.csv", "B.csv", "B.nodes.csv"]);
    let options = ReadOptions::default();
    for (network, name) in networks.iter().zip(["A.csv", "B.csv"]) {
        let read = willis::read(&place(name), &options).unwrap();
        assert_eq!(
            read.network.nodes().map(|n| n.position).collect::<Vec<_>>(),
            network.nodes().map(|n| n.position).collect::<Vec<_>>()
        );
        assert!(!read.provenance.notes.iter().any(|note| note.contains("is not as it was")), "{:?}", read.provenance.notes);
    }
    // The nodes of another network of as many nodes.
    std::fs::copy(place("B.nodes.csv"), place("A.nodes.csv")).unwrap();
    let said = willis::read(&place("A.csv"), &options).unwrap_err().to_string();
    assert!(said.contains("A.csv:2: edge 0: node") && said.contains("expected the table of nodes of this network"), "{said}");
    // The nodes of this network, changed by hand.
    write(&networks[0], &place("A.csv"), None, true).unwrap();
    let nodes = std::fs::read_to_string(place("A.nodes.csv")).unwrap();
    std::fs::write(place("A.nodes.csv"), format!("{nodes}\n")).unwrap();
    let notes = willis::read(&place("A.csv"), &options).unwrap().provenance.notes;
    assert!(notes.iter().any(|note| note.contains("is not as it was when")), "{notes:?}");
    // A table of nodes under the name that others use.
    std::fs::rename(place("A.nodes.csv"), place("nodes.csv")).unwrap();
    assert!(willis::read(&place("A.csv"), &options).is_ok());
}

/// A network with every position and length so many times as large.
fn scaled(network: &Network, by: f64) -> Network {
    let mut larger = Network::new();
    for node in network.nodes() {
        larger.add_node(Node { position: node.position.map(|p| p.map(|x| by * x)), ..node.clone() });
    }
    for (ends, vessel) in network.vessels() {
        larger.add_vessel(ends, Vessel { length: by * vessel.length, path: Vec::new(), ..vessel.clone() });
    }
    larger
}

#[test]
fn decimal_and_hexadecimal_numbers_are_read_and_commas_named() {
    // Python: (10.875).hex(), (-0.1).hex(), (2**-1074).hex(), sys.float_info.max.hex(), (0.0).hex()
    assert_eq!(number("0x1.5c00000000000p+3"), Ok(10.875));
    assert_eq!(number("-0x1.999999999999ap-4"), Ok(-0.1));
    assert_eq!(number("0x0.0000000000001p-1022"), Ok(5e-324));
    assert_eq!(number("0x1.fffffffffffffp+1023"), Ok(f64::MAX));
    assert_eq!(number("0x0.0p+0"), Ok(0.0));
    assert_eq!(number("1.5e-3"), Ok(1.5e-3));
    assert_eq!(number("1,5"), Err("expected a decimal point, not a comma"));
    for wrong in ["", "abc", "1,5,2", "0x", "0x1.8", "0xp1", "0x1p99999", "0x11111111111111111p0", "0x1.8p+-3"] {
        assert_eq!(number(wrong), Err("expected a number"), "{wrong}");
    }
}

/// Points of a spiral with the given radii, in mm, taken as `unit`.
fn notes(unit: LengthUnit, place: impl Fn(f64) -> f64, radius: impl Fn(usize) -> f64) -> String {
    let scale = Scale { unit, spacing: None };
    let mut lines = Centerlines::default();
    for i in 0..20 {
        let t = i as f64;
        let position = scale.position([place(7.3 * t.sin()), place(7.3 * t.cos()), place(t * 1.1)]);
        lines.add_point(position, scale.length(radius(i)), i as u64, 0);
    }
    unit_check(&Content::Centerlines(lines), &scale, false).join("\n")
}

#[test]
fn vessels_in_millimetres_pass_and_other_units_are_named() {
    let mm = |i: usize| 1.2 + 0.013 * i as f64;
    assert_eq!(notes(LengthUnit::Millimetre, |x| x, mm), "");
    let voxel = notes(LengthUnit::Millimetre, |x| x, |i| 4.1 * mm(i));
    assert!(voxel.contains("perhaps they are um or voxels"), "{voxel}");
    let cm = notes(LengthUnit::Millimetre, |x| 0.2 * x, |i| 0.05 * mm(i));
    assert!(cm.contains("give `units=cm`"), "{cm}");
    assert!(notes(LengthUnit::Metre, |x| x, mm).contains("perhaps they are mm or voxels"));
    assert!(notes(LengthUnit::Millimetre, f64::round, mm).contains("whole or half numbers"));
    let distance_transform = notes(LengthUnit::Millimetre, |x| x, |i| ((1 + i % 3) as f64).sqrt());
    assert!(distance_transform.contains("distance transform"), "{distance_transform}");
    assert_eq!(notes(LengthUnit::Millimetre, |x| x, |_| 1.0), "", "one radius for all proves nothing");
    assert_eq!(notes(LengthUnit::Millimetre, |x| x, |i| 0.003 + 1e-5 * i as f64), "", "capillaries, whose squares are nearly 0");
}
