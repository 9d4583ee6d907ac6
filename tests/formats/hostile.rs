//! Inputs made to harm: each is refused in one clear line or gives the right answer, and no output carries a formula.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use std::fmt::Write as _;
use std::io::Write as _;

use crate::command::{folder, stderr, willis};
use crate::peers;
use crate::peers::{document, network_of, read_first};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use willis::internals::formats::tables::reader::TableReader;
use willis::internals::formats::{
    Column, Content, ReadOptions, read_csv_edges, read_csv_nodes, read_prior_npy, write_csv, write_csv_graph,
};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::Scale;
use willis::internals::network::{Network, Origin};

fn refused(name: &str, content: &[u8]) -> String {
    document(name, content).err().unwrap_or_else(|| panic!("{name} is read"))
}

#[test]
fn entities_are_refused_with_their_line() {
    let mut lol = String::from("<?xml version=\"1.0\"?>\n<!DOCTYPE lolz [<!ENTITY lol \"lol\">");
    (1..10).for_each(|n| write!(lol, "<!ENTITY lol{n} \"{}\">", format!("&lol{};", n - 1).repeat(10)).unwrap());
    lol += "]>\n<graphml><graph><node id=\"&lol9;\"/></graph></graphml>";
    assert_eq!(
        refused("g.graphml", lol.as_bytes()),
        "g.graphml:2: a document type with declarations of its own; expected no entities but those of XML itself"
    );
    let text = b"<graphml>\n<key id=\"k\" attr.name=\"label\"/><graph><node id=\"a\"><data key=\"k\">&foo;</data></node></graph></graphml>";
    assert_eq!(refused("g.graphml", text), "g.graphml:2: the entity &foo;; expected no entities but those of XML itself");
    let found = refused("g.graphml", b"<graphml><graph>\n<node id=\"&foo;\"/></graph></graphml>");
    assert!(found.starts_with("g.graphml:2: attribute id: ") && found.ends_with("but those of XML itself"), "{found}");
    // A document type without declarations is not fetched, the five entities and characters by number stand.
    let text = "<!DOCTYPE graphml SYSTEM \"http://example.org/graphml.dtd\">\n<graphml><graph><node id=\"a&amp;b&#x20AC;\"/></graph></graphml>";
    assert_eq!(network_of(document("g.graphml", text.as_bytes()).unwrap()).node(0).id, "a&b\u{20ac}");
}

#[test]
fn depth_and_breadth_are_bounded() {
    let deep = format!("<graphml>{}", "<a>".repeat(1_000_000));
    assert_eq!(refused("g.graphml", deep.as_bytes()), "g.graphml:1: more than 256 elements within one another; expected fewer");
    let mut wide = String::from("<graphml ");
    (0..100_000).for_each(|n| write!(wide, "a{n}=\"\" ").unwrap());
    wide += "></graphml>";
    assert_eq!(refused("g.graphml", wide.as_bytes()), "g.graphml:1: an element with more than 256 attributes; expected fewer");
    let json = format!("{{\"markups\":[{{\"controlPoints\":{}", "[".repeat(1_000_000));
    assert!(refused("m.mrk.json", json.as_bytes()).starts_with("m.mrk.json:1: column "));
}

#[test]
fn a_chain_of_a_million_points_is_one_vessel_and_a_cycle_is_named() {
    let mut chain = String::new();
    for id in (1..=1_000_000_u32).rev() {
        let parent = if id == 1 { -1 } else { i64::from(id) - 1 };
        writeln!(chain, "{id} 1 {} 0 0 1 {parent}", f64::from(id) / 8.0).unwrap();
    }
    let network = network_of(document("a.swc", chain.as_bytes()).unwrap());
    assert_eq!((network.node_count(), network.vessel_count()), (2, 1));
    assert!((network.vessel(0).length / (999_999e-3 / 8.0) - 1.0).abs() < 1e-9);
    let cycle = b"1 1 0 0 0 1 3\n2 1 1 0 0 1 1\n3 1 2 0 0 1 2\n";
    assert!(refused("a.swc", cycle).starts_with("a.swc:1: point 1 is its own ancestor; expected a tree"));
}

#[test]
fn points_in_one_place_are_welded_without_a_pair_for_each_two() {
    // 50,000 fragments from one place to places of their own.
    let mut lines = Centerlines::default();
    for n in 0..50_000_u32 {
        let common = lines.add_point([1.0; 3], 1e-3, u64::from(2 * n), n);
        let own = lines.add_point([2.0, f64::from(n), 0.0], 1e-3, u64::from(2 * n) + 1, n);
        lines.add_link([common, own], "");
    }
    assert_eq!(lines.weld(1e-9), 49_999);
    assert_eq!((lines.points.len(), lines.links.len()), (50_001, 50_000));
    // One strand that comes back to a place has its loops there, but for free ends, which meet.
    let mut lines = Centerlines::default();
    for (n, x) in [0.0, 1.0, 2.0, 1.0, 0.0].into_iter().enumerate() {
        lines.add_point([x, 0.0, 0.0], 1e-3, n as u64, 7);
    }
    (1..5).for_each(|n| lines.add_link([n - 1, n], ""));
    assert_eq!((lines.weld(1e-9), lines.points.len()), (1, 4));
}

#[test]
fn coordinates_beyond_all_sense_are_refused_by_name() {
    for x in ["1e300", "-1e156", "1e13"] {
        let text = format!("1 1 0 0 0 1 -1\n2 1 {x} 0 0 1 1\n");
        let found = refused("a.swc", text.as_bytes());
        assert!(found.starts_with("a.swc: point 2: coordinate ") && found.ends_with("; expected one within 1e12 mm"), "{found}");
    }
}

/// A VTP file of one line with so many points, all at zero, deflated.
fn zeros(points: usize) -> Vec<u8> {
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    let block = vec![0; 24 * 1024];
    (0..points / 1024).for_each(|_| packed.write_all(&block).unwrap());
    let packed = packed.finish().unwrap();
    let header: Vec<u8> = [1, 24 * points as u64, 0, packed.len() as u64].iter().flat_map(|word| word.to_le_bytes()).collect();
    let array = STANDARD.encode(header) + &STANDARD.encode(packed);
    format!(
        "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"><PolyData>\
         <Piece NumberOfPoints=\"{points}\" NumberOfLines=\"1\"><Points><DataArray type=\"Float64\" Name=\"Points\" format=\"binary\">\
         {array}</DataArray></Points></Piece></PolyData></VTKFile>"
    )
    .into_bytes()
}

#[test]
fn what_a_file_unpacks_to_is_bounded() {
    // 192 MiB out of 200 KiB; the whole gibibyte takes the same way.
    assert_eq!(
        refused("a.vtp", &zeros(8 << 20)),
        "a.vtp: array \"Points\" of Points: more than 64.0 MiB unpacked; expected centerlines, which do not compress to a hundredth"
    );
    let options = ReadOptions { max_input: 1_000_000, ..ReadOptions::default() };
    assert_eq!(
        read_first(&[("a.vtp", &zeros(1 << 16))], &options).unwrap_err(),
        "a.vtp: array \"Points\" of Points: more than 1000000 bytes unpacked; `max_input` allows more"
    );
    let options = ReadOptions { max_input: 10, ..ReadOptions::default() };
    assert_eq!(
        read_first(&[("a.swc", b"1 1 0 0 0 1 -1\n")], &options).unwrap_err(),
        "a.swc: 15 bytes; expected at most 10 bytes; `max_input` allows more"
    );
}

#[test]
fn tables_carry_no_formulas_and_bring_every_label_back() {
    let labels =
        ["=HYPERLINK(\"http://example.org\")", "+cmd|' /C calc'!A0", "@SUM(A1)", "-1+1", "'=1", "''=1", "＝1+1", "'n", "M1"];
    let mut edges = String::from("node_a,node_b,length_mm,radius_mm,label\n");
    for (n, label) in labels.iter().enumerate() {
        writeln!(edges, "{n},{},1,1,\"'{}\"", n + 1, label.replace('"', "\"\"")).unwrap();
    }
    let (mut network, _) = read_csv_edges(edges.as_bytes(), None, &ReadOptions::default()).unwrap();
    labels.iter().enumerate().for_each(|(row, label)| network.vessel_mut(row).label = (*label).to_owned());
    let (mut nodes, mut edges) = (Vec::new(), Vec::new());
    write_csv_graph(&mut nodes, &mut edges, &network).unwrap();
    let mut table = csv::Reader::from_reader(&edges[..]);
    for field in table.records().flat_map(|row| row.unwrap().iter().map(str::to_owned).collect::<Vec<_>>()) {
        assert!(
            !field.starts_with(['=', '+', '@', '\t', '\r', '＝']) && (!field.starts_with('-') || field.parse::<f64>().is_ok()),
            "{field}"
        );
    }
    let table = read_csv_nodes(&nodes[..], &Scale::default()).unwrap();
    let (again, _) = read_csv_edges(&edges[..], Some(table), &ReadOptions::default()).unwrap();
    let found: Vec<&str> = again.vessels().map(|(_, vessel)| vessel.label.as_str()).collect();
    assert_eq!(found, labels);
    // What a manifest calls a column goes into the header of a table.
    let mut table = Vec::new();
    write_csv(&mut table, &[Column::text("=1+1", ["a"].into_iter()), Column::text("age", ["3"].into_iter())]).unwrap();
    assert_eq!(String::from_utf8_lossy(&table), "'=1+1,age\na,3\n");
    assert_eq!(TableReader::ragged(&table).unwrap().find(&["=1+1"]), Some(0));
    let pair: [(&str, &[u8]); 2] = [("edges.csv", &edges), ("nodes.csv", &nodes)];
    assert!(matches!(read_first(&pair, &ReadOptions::default()).map(|d| d.content), Ok(Content::Graph(_))));
}

/// Found by fuzzing: the parser of NumPy's headers took time that doubled with every bracket.
#[test]
fn a_numpy_header_of_brackets_is_refused_at_once() {
    let header = format!("{{'descr': '<f8', {:<101}", "[".repeat(48));
    let file = [&b"\x93NUMPY\x01\x00\x76\x00"[..], header.as_bytes(), b"\n"].concat();
    let fault = read_prior_npy(&file, &mut Network::new()).unwrap_err();
    assert_eq!(fault.found, "not a NumPy array");
}

/// A run on a file of its own: refused with status 2 in one line that ends so, and nothing is written.
fn run_refused(name: &str, content: &[u8], arguments: &[&str], ending: &str) {
    let here = folder();
    std::fs::write(here.path().join(name), content).unwrap();
    let output = willis(here.path(), &[&["infer", name, "-o", "out", "-q"], arguments].concat());
    let said = stderr(&output);
    assert_eq!((output.status.code(), said.lines().count()), (Some(2), 1), "{said}");
    assert!(said.trim_end().ends_with(ending), "{said}");
    assert_eq!(std::fs::read_dir(here.path()).unwrap().count(), 1, "something is left behind");
}

#[test]
fn a_gibibyte_of_zeros_is_refused_before_it_is_unpacked() {
    let bomb = zeros((1 << 30) / 24 / 1024 * 1024);
    assert!(bomb.len() < 2 << 20, "{} bytes", bomb.len());
    let ending = "MiB unpacked; expected centerlines, which do not compress to a hundredth";
    run_refused("a.vtp", &bomb, &[], ending);
}

#[test]
fn points_in_one_place_are_answered_or_refused_at_once() {
    // A chain of points in one place is no vessel.
    let mut chain = String::new();
    (1..=100_000).for_each(|id| writeln!(chain, "{id} 1 1 2 3 1 {}", if id == 1 { -1 } else { id - 1 }).unwrap());
    run_refused("a.swc", chain.as_bytes(), &[], "no vessel; expected centerlines with at least two linked points, or edges");
    // Fragments that all lie in one another are one vessel; those that all leave from one place, or nearly, meet there.
    let (mut same, mut star, mut near) = (String::new(), String::new(), String::new());
    for n in 0..50_000_u32 {
        let (a, b, turn) = (2 * n + 1, 2 * n + 2, f64::from(n) * 1e-4);
        writeln!(same, "{a} 1 0 0 0 1 -1\n{b} 1 9 0 0 1 {a}").unwrap();
        writeln!(star, "{a} 1 0 0 0 1 -1\n{b} 1 {} {} 0 1 {a}", 9.0 * turn.cos(), 9.0 * turn.sin()).unwrap();
        let off = f64::from(n % 211) * 1e-8;
        writeln!(
            near,
            "{a} 1 {off} {} {} 1 -1\n{b} 1 {} {} 0 1 {a}",
            f64::from(n) * 1e-10,
            off / 2.0,
            9.0 * turn.cos(),
            9.0 * turn.sin()
        )
        .unwrap();
    }
    let hub = "node 1 where 50000 vessels meet: candidates need junctions of at most 1000";
    run_refused("a.swc", star.as_bytes(), &[], hub);
    run_refused("a.swc", near.as_bytes(), &[], hub);
    let network = network_of(document("a.swc", same.as_bytes()).unwrap());
    assert_eq!((network.node_count(), network.vessel_count()), (2, 1));
}

#[test]
fn one_coordinate_far_off_welds_what_its_tolerance_covers() {
    // The box is 1e9 mm wide, so that all other points lie within a millionth of it.
    let mut lines = Centerlines::default();
    for n in 0..100_000_u32 {
        let at = [f64::from(n % 317), f64::from(n % 211), f64::from(n)].map(|x| x * 1e-4);
        lines.add_point(at, 1e-3, u64::from(n), n);
    }
    lines.add_point([1e9, 0.0, 0.0], 1e-3, 100_000, 100_000);
    assert_eq!(lines.weld(1e-6), 99_999);
    // Two crowds in each other's reach are one, two beyond it are two.
    for (apart, left) in [(0.9, 1), (1.1, 2)] {
        let mut lines = Centerlines::default();
        for n in 0..64_u32 {
            let middle = f64::from(n % 2) * apart;
            lines.add_point([middle + f64::from(n) * 1e-9, 0.0, 0.0], 1e-3, u64::from(n), n);
        }
        let reach = 1.0 / lines.points.iter().map(|p| p[0]).fold(0.0, f64::max);
        assert_eq!(lines.weld(reach), 64 - left, "{apart}");
    }
}

#[test]
fn a_comb_of_twigs_is_answered() {
    let mut comb = String::new();
    (0..20_000).for_each(|n| writeln!(comb, "{} 1 {n} 0 0 1 {}", n + 1, if n == 0 { -1 } else { n }).unwrap());
    (0..20_000).for_each(|n| writeln!(comb, "{} 1 {n} 3 0 0.3 {}", 20_001 + n, n + 1).unwrap());
    let here = folder();
    std::fs::write(here.path().join("comb.swc"), comb).unwrap();
    let output = willis(here.path(), &["candidates", "comb.swc", "-o", "comb.graphml"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let graph = network_of(
        peers::read_first(&[("c.graphml", &std::fs::read(here.path().join("comb.graphml")).unwrap())], &ReadOptions::default())
            .unwrap(),
    );
    // The spine's first and last points and twigs are a vessel each of two links.
    assert!(graph.vessels().filter(|(_, v)| v.origin == Origin::Observed).count() >= 39_997);
}

#[test]
fn radii_beyond_arithmetic_are_refused_by_the_vessel() {
    let none = "no valid radius on any of its 2 points; expected a positive radius, or give --default-radius";
    for (radius, why) in [("1e-310", "expected a resilience that a double can hold"), ("5e-324", none)] {
        let text = format!("1 1 0 0 0 {radius} -1\n2 1 1 0 0 {radius} 1\n3 1 2 0 0 {radius} 2\n4 1 2 1 0 {radius} 2\n");
        let here = folder();
        std::fs::write(here.path().join("a.swc"), &text).unwrap();
        let output = willis(here.path(), &["infer", "a.swc", "-o", "out", "-q"]);
        let said = stderr(&output);
        assert_eq!((output.status.code(), said.lines().count()), (Some(2), 1), "{said}");
        assert!(said.trim_end().ends_with(why) && said.len() < 200, "{said}");
    }
}

/// Found by reading: a table of no columns and 2^60 rows holds no values, and room was made for its rows.
#[test]
fn counts_without_values_take_no_room() {
    let array = |descr: &str, shape: &str| {
        let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
        [&b"\x93NUMPY\x01\x00\x76\x00"[..], format!("{header:<117}\n").as_bytes()].concat()
    };
    let skeleton = |coords: Vec<u8>, labels: Option<Vec<u8>>| {
        let mut file = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        let members = [("coords", coords), ("edges", array("<i8", "(0, 2)")), ("radii", array("<f8", "(0,)"))];
        for (name, bytes) in members.into_iter().chain(labels.map(|labels| ("labels", labels))) {
            file.start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default()).unwrap();
            file.write_all(&bytes).unwrap();
        }
        file.finish().unwrap().into_inner()
    };
    let found = refused("a.npz", &skeleton(array("<f8", "(1152921504606846976, 0)"), None));
    assert!(found.contains("array coords: shape (1152921504606846976, 0); expected a row of 3 for each"), "{found}");
    let found = refused("a.npz", &skeleton(array("<f8", "(0, 3)"), Some(array("<U0", "(100000000,)"))));
    assert!(found.contains("unpacked"), "{found}");
}

#[test]
fn files_beside_the_input_are_bounded_and_text() {
    let here = folder();
    std::fs::write(here.path().join("a.swc"), "1 1 0 0 0 1 -1\n2 1 9 0 0 1 1\n").unwrap();
    std::fs::write(here.path().join("bc.csv"), b"node,kind\n\xff\xfe,inlet\n").unwrap();
    let output = willis(here.path(), &["infer", "a.swc", "--bc", "bc.csv", "-o", "out", "-q"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(stderr(&output), "willis: bc.csv:2: column 1 is not UTF-8; expected UTF-8 text\n");
    // A file of three gibibytes that takes no place on the disk.
    std::fs::File::create(here.path().join("bc.csv")).unwrap().set_len(3 << 30).unwrap();
    let output = willis(here.path(), &["infer", "a.swc", "--bc", "bc.csv", "-o", "out", "-q"]);
    assert_eq!(stderr(&output), "willis: bc.csv: 3.0 GiB; expected at most 2.0 GiB\n");
}
