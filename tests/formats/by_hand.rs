//! Readers against small files typed by hand: what they hold, and one test for each kind of fault.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use std::path::Path;

use willis::internals::formats::{
    Content, Document, Format, ReadOptions, read, read_csv_edges, read_csv_nodes, read_graphml, read_swc, read_vtp,
};
use willis::internals::network::units::{LengthUnit, Scale, metres, pascals};
use willis::internals::network::{Condition, Network, Origin};

fn mm() -> Scale {
    Scale::default()
}

fn document(name: &str, content: &[u8]) -> Result<Document, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    read(&path, &ReadOptions::default()).map_err(|e| e.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

fn graph(content: &str) -> Result<(Network, Vec<String>), String> {
    read_graphml(content.as_bytes(), &ReadOptions::default()).map_err(|f| f.in_file(Path::new("g")).to_string())
}

fn swc(content: &str) -> Result<(willis::internals::network::centerlines::Centerlines, Vec<String>), String> {
    read_swc(content.as_bytes(), &mm()).map_err(|f| f.in_file(Path::new("s")).to_string())
}

/// A GraphML file with these attributes on nodes a (0 0 0), b (3 4 0), and one edge between them.
fn small(node_a: &[(&str, &str)], edge: &[(&str, &str)]) -> String {
    let mut keys = std::collections::BTreeSet::new();
    let mut data = |pairs: &[(&str, &str)], on: &str| {
        let mut out = String::new();
        for (name, value) in pairs {
            keys.insert(format!("<key id=\"{on}{name}\" for=\"{on}\" attr.name=\"{name}\" attr.type=\"string\"/>"));
            out.extend(["<data key=\"", on, name, "\">", value, "</data>"]);
        }
        out
    };
    let a = data(&[&[("x_mm", "0"), ("y_mm", "0"), ("z_mm", "0")], node_a].concat(), "node");
    let b = data(&[("x_mm", "3"), ("y_mm", "4"), ("z_mm", "0")], "node");
    let e = data(edge, "edge");
    let keys = keys.into_iter().collect::<Vec<_>>().join("\n");
    let nodes = format!("<node id=\"a\">{a}</node>\n<node id=\"b\">{b}</node>");
    format!("<graphml>\n{keys}\n<graph>\n{nodes}\n<edge source=\"a\" target=\"b\">{e}</edge>\n</graph></graphml>")
}

#[test]
fn swc_in_any_order_with_tabs_comments_and_several_roots() {
    let text =
        "\u{feff}# header\r\n3\t2 0 0 2   0.5 2\r\n\r\n0 1 0 0 0 0 -1 # root\r\n2.0 2 0 0 1 0 0.0 extra\n# x\n7 1 5 5 5 -1 -1\n";
    let (lines, notes) = swc(text).unwrap();
    assert_eq!(lines.ids, [3, 0, 2, 7]);
    assert_eq!(lines.links, [[2, 0], [1, 2]]);
    assert_eq!(lines.strand, [0, 0, 0, 1]);
    assert_eq!(lines.points[0], [0.0, 0.0, metres(2.0)]);
    assert!(lines.radii[0] == metres(0.5) && lines.radii[1..].iter().all(|r| r.is_nan()));
    assert_eq!(notes, ["line 5 and perhaps others have 8 columns; those after the seventh are ignored"]);
    // Headers as CNIC and NeuroMorpho have them.
    let head =
        |scale: &str, offset: &str| format!("# SCALE {scale}\n# OFFSET {offset}\n# SHRINKAGE_CORRECTION 1.5\n1 0 0 0 0 1 -1\n");
    assert_eq!(swc(&head("1.0 1.0 1.0", "0 0.0 0")).unwrap().1, [""; 0]);
    let (lines, notes) = swc(&head("0.5 0.5 2.0", "0 0 -3")).unwrap();
    assert!(lines.radii == [metres(1.0)] && notes.len() == 2, "{notes:?}");
    assert!(
        notes[0].starts_with("line 1: SCALE 0.5 0.5 2.0 is not applied") && notes[1].starts_with("line 2: OFFSET"),
        "{notes:?}"
    );
}

#[test]
fn swc_faults_name_line_and_value() {
    for (text, message) in [
        ("# c\n1 0 0 0 -1\n", "s:2: 5 columns; expected 7 (id type x y z radius parent)"),
        ("1 0 0 zero 0 1 -1\n", "s:1: y \"zero\"; expected a number"),
        ("1 0 0 0 inf 1 -1\n", "s:1: z inf; expected a finite number"),
        ("1 0 0 0 nan 1 -1\n", "s:1: z NaN; expected a finite number"),
        ("1 0 0 0 0 wide -1\n", "s:1: radius \"wide\"; expected a number"),
        ("1.5 0 0 0 0 1 -1\n", "s:1: id \"1.5\"; expected a whole number"),
        ("-4 0 0 0 0 1 -1\n", "s:1: id -4 is negative; expected a whole number from 0 on"),
        ("1 0 0 0 0 1 -1\n\n1 0 0 0 0 1 -1\n", "s:3: id 1 is that of line 1 too; expected every id once"),
        ("1 0 0 0 0 1 9\n", "s:1: parent 9 does not exist; expected the id of a point, or -1"),
        (
            "1 0 0 0 0 1 1\n",
            "s:1: point 1 is its own ancestor; expected a tree; links that close loops go into the file of `loops`",
        ),
        (
            "1 0 0 0 0 1 -1\n2 0 0 0 0 1 3\n3 0 0 0 0 1 2\n",
            "s:2: point 2 is its own ancestor; expected a tree; links that close loops go into the file of `loops`",
        ),
        ("# nothing\n", "s: no points; expected lines of 7 columns (id type x y z radius parent)"),
    ] {
        assert_eq!(swc(text).unwrap_err(), message);
    }
}

#[test]
fn loops_link_points_and_their_faults_name_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let (path, loops) = (folder.path().join("a.swc"), folder.path().join("l.csv"));
    std::fs::write(&path, "1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n3 0 1 1 0 1 2\n").unwrap();
    let mut options = ReadOptions { loops: Some(loops.clone()), ..ReadOptions::default() };
    for text in ["id_a,id_b\n1,3\n", "1, 3 # one", "id_a;id_b\r\n\"1\";3\r\n", "# one\n\nnote\tB\tA\nx\t3\t1\n", "1\t3\n"] {
        std::fs::write(&loops, text).unwrap();
        let Content::Centerlines(lines) = read(&path, &options).unwrap().content else { panic!() };
        assert_eq!(lines.links, [[0, 1], [1, 2], [0, 2]]);
    }
    // A link that is there, or comes twice, is no further one.
    std::fs::write(&loops, "id_a,id_b\n2,1\n1,3\n3,1\n").unwrap();
    let document = read(&path, &options).unwrap();
    let Content::Centerlines(lines) = &document.content else { panic!() };
    assert_eq!(lines.links, [[0, 1], [1, 2], [0, 2]]);
    assert!(document.notes.iter().any(|note| note.starts_with("1 link added from ")), "{:?}", document.notes);
    for (text, message) in [
        ("id_a,id_b\n1,9\n", "l.csv:2: point 9 does not exist; expected two point ids (id_a,id_b)"),
        ("1,x\n", "l.csv:1: \"x\"; expected two point ids (id_a,id_b)"),
        ("1\n", "l.csv:1: \"1\"; expected two point ids (id_a,id_b)"),
        ("a,b\n# same\n\n2,2\n", "l.csv:4: point 2 twice; expected two different points"),
    ] {
        std::fs::write(&loops, text).unwrap();
        assert!(read(&path, &options).unwrap_err().to_string().ends_with(message));
    }
    let ready = folder.path().join("g.graphml");
    std::fs::write(&ready, small(&[], &[("radius_mm", "1")])).unwrap();
    assert!(read(&ready, &options).unwrap_err().to_string().starts_with("loops "));
    options.loops = Some(folder.path().join("absent"));
    assert!(read(&path, &options).unwrap_err().to_string().contains("absent: cannot be read"));
}

#[test]
fn the_format_is_decided_by_content_then_ending() {
    let graphml = small(&[], &[("radius_mm", "1")]);
    let dispatch = |name: &str, text: &str| document(name, text.as_bytes()).map(|d| d.format);
    assert_eq!(dispatch("a.swc", &graphml), Ok(Format::GraphMl));
    assert_eq!(dispatch("a.txt", "# c\n1 0 0 0 0 1 -1\n"), Ok(Format::Swc));
    assert_eq!(dispatch("a.CSV", "source,target,length_mm,radius_mm\n1,2,3,4\n"), Ok(Format::Csv));
    assert_eq!(dispatch("a.txt", "source,target,length_mm,radius_mm\n1,2,3,4\n"), Ok(Format::Csv));
    let accepted = "expected SWC, VTP, VTK PolyData, GraphML, CSV, TRE, 3D Slicer markups, NPZ, Amira, VTrails MAT, or a mask: NIfTI, MetaImage, NRRD, TIFF, NPY";
    for (text, found) in [
        ("", "the file is empty"),
        (" \n", "the file is empty"),
        ("hello", "the format is not known"),
        ("<svg/>", "XML with the root element <svg>"),
        ("<VTKFile type=\"ImageData\"/>", "a VTKFile of another type than PolyData"),
    ] {
        assert_eq!(document("a.swx", text.as_bytes()).unwrap_err(), format!("a.swx: {found}; {accepted}"));
    }
    // The digest by coreutils sha256sum.
    let digest = "550d55921b6d3251379923495275e0d569ad193c8ce1c232efcddb15770b65f0";
    assert_eq!(document("a.swc", b"1 0 0 0 0 1 -1\n").unwrap().sha256, digest);
    assert!(document("a.swc", b"").is_err());
}

#[test]
fn graphml_keys_defaults_and_booleans() {
    let text = r#"<graphml><key id="d" for="all" attr.name="label" attr.type="string"><default>none</default></key>
<key id="r" for="edge" attr.name="radius_mm" attr.type="double"><default>0.5</default></key>
<key id="l" for="edge" attr.name="length" attr.type="float"/><key id="c" for="edge" attr.name="certain" attr.type="boolean"/>
<key id="y" for="node" yfiles.type="nodegraphics"/>
<graph edgedefault="directed"><data key="d">graph</data><edge source="b" target="a"><data key="c">True</data><data key="l">2</data></edge>
<edge source="a" target="a"><data key="l">1</data><data key="d">x &amp; y</data></edge><edge source="a" target="b"><data key="l">3</data></edge>
<node id="a"><data key="y"><b/></data></node><node id="b"><data key="d">B</data></node><data key="d">late</data></graph></graphml>"#;
    let scale = Scale { unit: LengthUnit::Centimetre, spacing: None };
    let (g, notes) = read_graphml(text.as_bytes(), &ReadOptions { scale, ..ReadOptions::default() }).unwrap();
    assert_eq!(g.nodes().map(|n| n.label.as_str()).collect::<Vec<_>>(), ["none", "B"]);
    let vessels: Vec<_> = g.vessels().map(|(e, v)| (e, v.length, v.radius, v.certain, v.label.as_str())).collect();
    let r = metres(0.5);
    assert_eq!(
        vessels,
        [
            ([1, 0], metres(20.0), r, true, "none"),
            ([0, 0], metres(10.0), r, false, "x & y"),
            ([0, 1], metres(30.0), r, false, "none")
        ]
    );
    assert_eq!(notes.len(), 2);
    assert!(notes[0].starts_with("no edge has an origin") && notes[1].contains("directed"));
}

#[test]
fn conditions_follow_roles() {
    let on_a = |pairs: &[(&str, &str)]| graph(&small(pairs, &[("radius_mm", "1")])).unwrap().0.node(0).condition;
    assert_eq!(on_a(&[("pressure_mmHg", "80")]), Some(Condition::Pressure(pascals(80.0))));
    assert_eq!(on_a(&[("pressure_mmHg", "80"), ("role", "inner")]), None);
    assert_eq!(on_a(&[("pressure_mmHg", "80"), ("role", "inlet")]), Some(Condition::Pressure(pascals(80.0))));
    assert_eq!(on_a(&[("role", "inlet")]), Some(Condition::Pressure(pascals(100.0))));
    assert_eq!(on_a(&[("role", "outlet")]), Some(Condition::Pressure(0.0)));
    assert_eq!(on_a(&[("pressure_mmHg", "nan")]), None);
    let resistance = willis::internals::network::units::pascal_seconds_per_cubic_metre(3.0);
    assert_eq!(
        on_a(&[("role", "outlet"), ("pressure_mmHg", "80"), ("resistance_mmHg_s_per_mL", "3"), ("venous_pressure_mmHg", "5")]),
        Some(Condition::Resistance { resistance, venous: pascals(5.0) })
    );
    let flow = willis::internals::network::units::cubic_metres_per_second(60.0);
    assert_eq!(on_a(&[("flow_mL_per_min", "60"), ("pressure_mmHg", "80")]), Some(Condition::Flow(flow)));
}

#[test]
fn lengths_radii_and_paths_are_completed() {
    let edge = |pairs: &[(&str, &str)]| graph(&small(&[], pairs)).map(|(g, _)| g.vessel(0).clone());
    assert_eq!(edge(&[("radius_mm", "1")]).unwrap().length, metres(5.0));
    let v = edge(&[("points", "3 4 0 1;0 0 0 2")]).unwrap();
    assert_eq!(v.path.first().map(|p| p.position), Some([0.0; 3]), "turned to run from the first node");
    assert!((v.length - 0.005).abs() < 1e-15 && (v.radius - 0.0015).abs() < 1e-15);
    assert_eq!(v.origin, Origin::Candidate);
    // The nodes are 5 mm apart.
    let is_told = |mm| {
        let (_, notes) = graph(&small(&[], &[("radius_mm", "1"), ("length_mm", mm)])).unwrap();
        notes.iter().any(|note| note.starts_with("1 edge shorter than the distance"))
    };
    assert_eq!(["0.5", "4.99", "5", "50"].map(is_told), [true, false, false, false]);
}

#[test]
fn graph_faults_name_the_item_the_value_and_the_accepted_form() {
    let e = "edge 0 (a - b): ";
    for (node, edge, message) in [
        (vec![], vec![("radius_mm", "0")], format!("{e}radius_mm 0; expected a positive number, or give `default_radius`")),
        (vec![], vec![("radius", "inf")], format!("{e}radius inf; expected a finite number")),
        (vec![], vec![("radius_mm", "x")], format!("{e}radius_mm \"x\"; expected a number")),
        (
            vec![],
            vec![],
            format!("{e}no radius_mm; expected radius_mm on the edge, or on both of its nodes, or `default_radius`"),
        ),
        (vec![], vec![("radius_mm", "1"), ("length_mm", "-2")], format!("{e}length_mm -2; expected a positive number")),
        (vec![], vec![("radius_mm", "1"), ("length_mm", "0")], format!("{e}length_mm 0; expected a positive number")),
        (vec![], vec![("radius_mm", "1"), ("prior", "1.2")], format!("{e}prior 1.2; expected a number from 0 to 1")),
        (
            vec![],
            vec![("radius_mm", "1"), ("origin", "seen")],
            format!("{e}origin \"seen\"; expected observed, candidate or contact"),
        ),
        (vec![], vec![("radius_mm", "1"), ("certain", "yes")], format!("{e}certain \"yes\"; expected true or false")),
        (
            vec![],
            vec![("points", "0 0 0 1;3 4 0 -1")],
            format!("{e}points: point 1 \"3 4 0 -1\"; expected x y z r in mm, r positive"),
        ),
        (
            vec![],
            vec![("points", "0 0 0 1")],
            format!("{e}points \"0 0 0 1\"; expected two or more different points x y z r;x y z r"),
        ),
        (vec![("found", "yes")], vec![], "node a: found \"yes\"; expected true, false or landmark".into()),
        (vec![("role", "source")], vec![], "node a: role \"source\"; expected inlet, outlet or inner".into()),
        (vec![("pressure_mmHg", "inf")], vec![], "node a: pressure_mmHg inf; expected a finite number".into()),
        (
            vec![("resistance_mmHg_s_per_mL", "0")],
            vec![],
            "node a: resistance_mmHg_s_per_mL 0; expected a positive number".into(),
        ),
        (
            vec![("resistance_mmHg_s_per_mL", "1"), ("flow_mL_per_min", "1")],
            vec![],
            "node a: resistance_mmHg_s_per_mL and flow_mL_per_min; expected one condition".into(),
        ),
    ] {
        let text = small(&node, &edge);
        let tag = if message.starts_with("node") { "<node id=\"a\"" } else { "<edge" };
        let line = text.lines().position(|l| l.starts_with(tag)).unwrap() + 1;
        assert_eq!(graph(&text).unwrap_err(), format!("g:{line}: {message}"));
    }
}

#[test]
fn graphml_structure_faults_are_one_line_with_a_place() {
    let wrap = |inner: &str| format!("<graphml><key id=\"x\" attr.name=\"x\"/>\n<graph>\n{inner}\n</graph></graphml>");
    for (text, message) in [
        (wrap("<node id=\"a\"/><node id=\"a\"/>"), "g:3: node a: the id comes twice; expected every node id once"),
        (wrap("<node/>"), "g:3: node 0 has no id; expected an id"),
        (
            wrap("<node id=\"a\"/>\n<edge source=\"a\" target=\"q\"/>"),
            "g:4: edge 0: target \"q\" does not exist; expected the id of a node",
        ),
        (wrap("<node id=\"a\"/><edge source=\"a\"/>"), "g:3: edge 0 has no target; expected the id of a node"),
        (
            wrap("<node id=\"a\"><data key=\"k\">1</data></node>"),
            "g:3: key \"k\" is not declared; expected the id of a <key> element",
        ),
        (wrap("<node id=\"a\"><graph/></node>"), "g:3: a <graph> within the graph; expected only nodes and edges"),
        (wrap("<hyperedge/>"), "g:3: a <hyperedge> within the graph; expected only nodes and edges"),
        (wrap("<node id=\"a\"><port name=\"p\"/></node>"), "g:3: a <port> within the graph; expected only nodes and edges"),
        (wrap("<node id=\"a\"><data key=\"x\">1</data></node>"), "g:3: node a: no y; expected all of x, y, z or none"),
        (wrap(""), "g: the graph has no nodes; expected <node> elements"),
        ("<graphml/>".into(), "g: 0 graphs; expected one <graph> in <graphml>"),
        ("<graphml><key/></graphml>".into(), "g:1: a <key> has no id; expected an id"),
    ] {
        assert_eq!(graph(&text).unwrap_err(), message);
    }
    let cut = graph("<graphml>\n<graph><node id=\"a\">").unwrap_err();
    assert!(cut.starts_with("g:2: not well-formed XML: ") && !cut.contains('\n'), "{cut}");
    let coincident = small(&[], &[("radius_mm", "1")]).replace(">3<", ">0<").replace(">4<", ">0<");
    assert!(graph(&coincident).unwrap_err().ends_with("no length_mm and both nodes in one place; expected length_mm"));
}

#[test]
fn csv_edges_alone_make_their_nodes() {
    let text = "node_a,node_b,ax_mm,ay_mm,az_mm,bx_mm,by_mm,bz_mm,radius_mm\nq,p,0,0,0,3,4,0,1\np,r,3,4,0,3,4,1,2\n";
    let (g, _) = read_csv_edges(text.as_bytes(), None, &ReadOptions::default()).unwrap();
    assert_eq!(g.nodes().map(|n| n.id.as_str()).collect::<Vec<_>>(), ["q", "p", "r"]);
    assert_eq!(g.node(1).position, Some([0.003, 0.004, 0.0]));
    assert_eq!(g.vessel(1).length, metres(1.0));
}

#[test]
fn csv_faults_name_the_line() {
    let nodes = || read_csv_nodes("node,id\n0,a\n1,b\n".as_bytes(), &mm()).unwrap();
    for (text, message) in [
        ("a,b\n1,2\n", "c:1: columns a,b; expected a table of edges with columns node_a,node_b or source,target"),
        ("node_a,node_b\n", "c: no edges; expected a row for every edge"),
        ("node_a,node_b\n0,1,2\n", "c:2: 3 columns; expected 2, as in the header"),
        ("node_a,node_b,node_a\n0,1,2\n", "c:1: column \"node_a\" comes twice; expected every column once"),
        ("node_a,node_b\n0,a\n", "c:2: edge 0: node_b a is not in the table of nodes; expected a name of its column node"),
        ("node_a,node_b\n0,\n", "c:2: edge 0: no node_b; expected the name of a node"),
        (
            "node_a,node_b,length_mm,radius_mm\n0,1,1,1\n1,0,1,-1\n",
            "c:3: edge 1 (b - a): radius_mm -1; expected a positive number, or give `default_radius`",
        ),
        (
            "node_a,node_b,radius_mm\n0,1,1\n",
            "c:2: edge 0 (a - b): no length_mm; expected length_mm, or the positions of both nodes",
        ),
    ] {
        let fault = read_csv_edges(text.as_bytes(), Some(nodes()), &ReadOptions::default()).unwrap_err();
        assert_eq!(fault.in_file(Path::new("c")).to_string(), message);
    }
    for (text, message) in [
        ("x_mm\n1\n", "c:1: columns x_mm; expected a column node or id"),
        ("node\n1\n1\n", "c:3: node 1 comes twice; expected every node once"),
        ("node,id\n1,a\n2,a\n", "c:3: node a: the id comes twice; expected every node id once"),
        ("node,x_mm\n1,7\n", "c:2: node 1: no y_mm; expected all of x_mm, y_mm, z_mm or none"),
    ] {
        assert_eq!(read_csv_nodes(text.as_bytes(), &mm()).unwrap_err().in_file(Path::new("c")).to_string(), message);
    }
}

/// A piece of two lines in ascii, with a hook to spoil it.
fn ascii_vtp(from: &str, to: &str) -> String {
    let text = r#"<VTKFile type="PolyData" byte_order="LittleEndian"><PolyData><Piece NumberOfPoints="5" NumberOfLines="2" NumberOfPolys="0">
<PointData><DataArray type="Float32" Name="Radius " format="ascii">1 2 3 4 5</DataArray></PointData>
<Points><DataArray type="Float64" Name="Points" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 2 0 0 3 0 0 9 9 nan</DataArray></Points>
<Lines><DataArray type="Int64" Name="connectivity" format="ascii">3 1 0 1 2</DataArray><DataArray type="Int32" Name="offsets" format="ascii">3 5</DataArray></Lines>
</Piece></PolyData></VTKFile>"#;
    assert!(text.contains(from));
    text.replacen(from, to, 1)
}

#[test]
fn vtp_follows_connectivity_and_drops_unused_points() {
    let (lines, _) = read_vtp(ascii_vtp("", "").as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(lines.ids, [3, 1, 0, 2]);
    assert_eq!(lines.links, [[0, 1], [1, 2], [1, 3]]);
    // The two lines share point 1: they are one tree.
    assert_eq!(lines.strand, [0, 0, 0, 0]);
    assert_eq!(lines.radii, [4.0, 2.0, 1.0, 3.0].map(metres));
}

#[test]
fn vtp_faults_name_the_array_and_the_value() {
    for (from, to, message) in [
        (
            "Radius ",
            "Width",
            "v: no point array MaximumInscribedSphereRadius, Radius, radius; there are \"Width\"; name one with `radius_array`, or give `default_radius`",
        ),
        ("3 1 0 1 2", "3 1 7 1 2", "v: line 0: point 7; expected a point from 0 to 4"),
        ("3 1 0 1 2", "3 1 -1 1 2", "v: line 0: point -1; expected a point from 0 to 4"),
        ("3 1 0 1 2", "3 1 4 1 2", "v: point 4: coordinates 9 9 NaN; expected finite numbers"),
        ("3 1 0 1 2", "3 1 0 1", "v: array \"connectivity\" of Lines: 4 values; expected 5"),
        ("3 1 0 1 2", "3 1 0 1 2.5", "v: array \"connectivity\" of Lines: value \"2.5\"; expected 5 numbers of type Int64"),
        (">3 5<", ">6 5<", "v: line 0: offset 6 after 0; expected rising offsets"),
        (">3 5<", ">3 99999999999<", "v: offsets of <Lines>: the last is 99999999999; expected a count up to 67108864"),
        (">1 2 3 4 5<", ">1 2 3 4<", "v: array \"Radius\" of PointData: 4 values; expected 5"),
        (
            "Float32",
            "Float16",
            "v: array \"Radius\" of PointData: type \"Float16\"; expected Int8 to Int64, UInt8 to UInt64, Float32 or Float64",
        ),
        (
            "NumberOfLines=\"2\" NumberOfPolys=\"0\"",
            "NumberOfPolys=\"7\"",
            "v: a surface of 7 polygons, not centerlines; expected polylines in <Lines>",
        ),
        ("NumberOfLines=\"2\"", "", "v: no lines; expected polylines in <Lines>"),
        ("NumberOfPoints=\"5\"", "NumberOfPoints=\"5e99\"", "v: Piece: NumberOfPoints \"5e99\"; expected a count up to 67108864"),
        ("LittleEndian", "Middle", "v: byte_order \"Middle\"; expected LittleEndian or BigEndian"),
        ("byte_order", "header_type=\"UInt16\" byte_order", "v: header_type \"UInt16\"; expected UInt32 or UInt64"),
        ("\"ascii\">1 2 3 4 5", "\"binary\">!!!!AAAA", "v: array \"Radius\" of PointData: not base64: "),
        (
            "\"ascii\">1 2 3 4 5",
            "\"binary\">FAAAAAAA",
            "v: array \"Radius\" of PointData: 6 bytes where 24 should be; expected 5 values of 4 bytes",
        ),
        (
            "\"ascii\">1 2 3 4 5",
            "\"binary\">/////w==",
            "v: array \"Radius\" of PointData: 0 bytes where 20 should be; expected 5 values of 4 bytes",
        ),
        (
            "\"ascii\">1 2 3 4 5",
            "\"appended\" offset=\"3\">",
            "v: array \"Radius\" of PointData: offset \"3\"; expected a place in the <AppendedData>",
        ),
        ("</Piece>", "", "v:5: not well-formed XML: "),
        (
            "</PolyData></VTKFile>",
            "</PolyData><AppendedData encoding=\"raw\">_",
            "v: AppendedData: the file ends within it; expected a complete file",
        ),
    ] {
        let found =
            read_vtp(ascii_vtp(from, to).as_bytes(), &ReadOptions::default()).unwrap_err().in_file(Path::new("v")).to_string();
        assert!(found.starts_with(message) && !found.contains('\n'), "{found}\n{message}");
    }
    let named =
        read_vtp(ascii_vtp("", "").as_bytes(), &ReadOptions { radius_array: Some("Area".into()), ..ReadOptions::default() })
            .unwrap_err()
            .in_file(Path::new("v"));
    assert_eq!(named.to_string(), "v: no point array \"Area\"; there are \"Radius\"");
    assert!(
        read_vtp(
            ascii_vtp("Radius ", " Width").as_bytes(),
            &ReadOptions { radius_array: Some("Width ".into()), ..ReadOptions::default() }
        )
        .is_ok()
    );
    let (bare, _) = read_vtp(
        ascii_vtp("Radius ", " Width").as_bytes(),
        &ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() },
    )
    .unwrap();
    assert!(bare.radii.iter().all(|r| r.is_nan()));
}
