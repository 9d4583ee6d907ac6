//! Amira's SpatialGraph: files written by hand as Amira's manual describes them, text and binary, and what willis writes.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use crate::peers::{case, converted, network_of, positions, read_first, sizes, truncated};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use willis::internals::formats::convert::Target;
use willis::internals::formats::{Format, ReadOptions, read};
use willis::internals::network::Network;
use willis::{LengthUnit, Scale};

/// A fork of three edges as numbers: each array with its declaration and its values.
const ARRAYS: [(&str, &str, &[f64]); 6] = [
    ("VERTEX", "float[3] VertexCoordinates", &[0., 0., 0., 1000., 0., 0., 2000., 500., 0., 2000., -500., 0.]),
    ("EDGE", "int[2] EdgeConnectivity", &[0., 1., 1., 2., 1., 3.]),
    ("EDGE", "int NumEdgePoints", &[3., 2., 2.]),
    (
        "POINT",
        "float[3] EdgePointCoordinates",
        &[0., 0., 0., 500., 40., 0., 1000., 0., 0., 1000., 0., 0., 2000., 500., 0., 1000., 0., 0., 2000., -500., 0.],
    ),
    ("POINT", "float thickness", &[200., 200., 200., 200., 200., 200., 200.]),
    ("EDGE", "int Sides", &[2., 1., 0.]),
];

/// How the numbers of a file are stored.
#[derive(Clone, Copy, PartialEq)]
enum Storage {
    Text,
    Little,
    Big,
    Zip,
    Runs,
}

fn header(first: &str, places: &[String]) -> String {
    let mut text = format!(
        "# {first}\n\n\ndefine VERTEX 4\ndefine EDGE 3\ndefine POINT 7\n\nParameters {{\n    Units {{\n        Coordinates \"µm\"\n    }}\n    \
         Sides {{\n        Left {{\n            Color 1 0 0,\n            Id 1\n        }}\n        \"L-ICA, C1\" {{ Color 0 0 1, Id 2 }}\n        \
         Id 0,\n        Color 0 0 0\n    }}\n    ContentType \"HxSpatialGraph\"\n}}\n\n"
    );
    for ((of, what, _), place) in ARRAYS.iter().zip(places) {
        writeln!(text, "{of} {{ {what} }} {place}").unwrap();
    }
    text + "\n# Data section follows\n"
}

fn file(storage: Storage) -> Vec<u8> {
    let first = match storage {
        Storage::Text => "Avizo 3D ASCII 3.0",
        Storage::Big => "AmiraMesh 3D BINARY 2.0",
        _ => "AmiraMesh BINARY-LITTLE-ENDIAN 3.0",
    };
    let (mut places, mut data) = (Vec::new(), Vec::new());
    for (row, (_, what, values)) in ARRAYS.iter().enumerate() {
        let stored = |value: &f64| {
            let bytes = if what.starts_with("float") { (*value as f32).to_le_bytes() } else { (*value as i32).to_le_bytes() };
            if storage == Storage::Big { bytes.into_iter().rev().collect::<Vec<u8>>() } else { bytes.to_vec() }
        };
        let plain: Vec<u8> = values.iter().flat_map(stored).collect();
        let (place, bytes) = match storage {
            Storage::Text => {
                (format!("@{}", row + 1), (values.iter().map(f64::to_string).collect::<Vec<_>>().join("\n") + "\n").into_bytes())
            }
            Storage::Little | Storage::Big => (format!("@{}", row + 1), plain),
            Storage::Zip => {
                let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
                packed.write_all(&plain).unwrap();
                let packed = packed.finish().unwrap();
                (format!("@{}(HxZip,{})", row + 1, packed.len()), packed)
            }
            Storage::Runs => {
                // One run of as many equal bytes as there are, then up to three bytes as they are.
                let (mut packed, mut rest) = (Vec::new(), plain.as_slice());
                while !rest.is_empty() {
                    let run = rest.iter().take(127).take_while(|byte| **byte == rest[0]).count();
                    packed.extend([run as u8, rest[0]]);
                    rest = &rest[run..];
                    let few = rest.len().min(3);
                    packed.push(128 + few as u8);
                    packed.extend(&rest[..few]);
                    rest = &rest[few..];
                }
                (format!("@{}(HxByteRLE,{})", row + 1, packed.len()), packed)
            }
        };
        places.push(place);
        data.extend([format!("@{}\n", row + 1).into_bytes(), bytes, b"\n".to_vec()].concat());
    }
    [header(first, &places).into_bytes(), data].concat()
}

fn network(name: &str, bytes: &[u8]) -> Network {
    network_of(read_first(&[(name, bytes)], &ReadOptions::default()).unwrap())
}

#[test]
fn text_and_binary_files_give_the_same_fork() {
    for storage in [Storage::Text, Storage::Little, Storage::Big, Storage::Zip, Storage::Runs] {
        let bytes = file(storage);
        let document = read_first(&[("a.am", &bytes)], &ReadOptions::default()).unwrap();
        assert_eq!(document.format, Format::Amira);
        let network = network_of(document);
        let mut found = positions(&network);
        found.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let expected = [[0., 0., 0.], [1., 0., 0.], [2., -0.5, 0.], [2., 0.5, 0.]];
        for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((a - b).abs() < 1e-9, "{found:?}");
        }
        // By hand: a bend of 40 in the middle of 1000, and the hypotenuse of 1000 and 500.
        let mut all: Vec<_> = sizes(&network).into_iter().map(|(_, label, length, radius)| (label, length, radius)).collect();
        all.sort_by(|a, b| a.0.cmp(&b.0));
        let straight = 1.25_f64.sqrt();
        let expected = [("", straight), ("L-ICA, C1", 2.0 * 0.5_f64.hypot(0.04)), ("Left", straight)];
        assert_eq!(all.len(), 3);
        for ((label, length, radius), (name, wanted)) in all.into_iter().zip(expected) {
            assert!(label == name && (length - wanted).abs() < 1e-6 && (radius - 0.2).abs() < 1e-6, "{label} {length} {radius}");
        }
    }
    let Some(small) = case("small.am") else { return };
    let network = network_of(read(&small, &ReadOptions::default()).unwrap());
    assert_eq!((network.node_count(), network.vessel_count()), (4, 3));
    let longest = network.vessels().map(|(_, vessel)| vessel.length).fold(0.0, f64::max);
    assert!((longest - 1e-3 * 1.25_f64.sqrt()).abs() < 1e-9, "{longest}");
}

/// Each edge as wide as it states, not as the mean of those that meet at the vertex.
#[test]
fn edges_are_as_wide_as_they_state() {
    let text = String::from_utf8(file(Storage::Text)).unwrap();
    let text = text.replace("POINT { float thickness }", "EDGE { float MeanRadius }");
    let text = text.replace(&"200\n".repeat(7), "200\n100\n50\n");
    let found = sizes(&network("a.am", text.as_bytes()));
    let mut found: Vec<(&str, f64)> =
        found.iter().map(|(_, label, _, radius)| (&**label, (1e9 * radius).round() / 1e9)).collect();
    found.sort_by(|a, b| a.0.cmp(b.0));
    assert_eq!(found, [("", 0.05), ("L-ICA, C1", 0.2), ("Left", 0.1)]);
}

#[test]
fn units_and_radii_are_those_of_the_options_where_the_file_says_otherwise() {
    let text = String::from_utf8(file(Storage::Text)).unwrap();
    let with = |from: &str, to: &str, options: &ReadOptions| {
        assert!(text.contains(from));
        read_first(&[("a.am", text.replacen(from, to, 1).as_bytes())], options)
    };
    let longest = |found: Network| found.vessels().map(|(_, v)| v.length).fold(0.0, f64::max);
    let mm = with("µm", "mm", &ReadOptions::default()).unwrap();
    assert!((longest(network_of(mm)) - 1.25_f64.sqrt()).abs() < 1e-9);
    let cm = ReadOptions { scale: Scale { unit: LengthUnit::Centimetre, spacing: None }, ..ReadOptions::default() };
    assert!((longest(network_of(with("x", "x", &cm).unwrap())) - 10.0 * 1.25_f64.sqrt()).abs() < 1e-8);
    let said = with("µm", "lightyear", &ReadOptions::default()).unwrap_err();
    assert!(said.contains("Coordinates \"lightyear\"; expected mm, um, cm or m, or give `units`"), "{said}");
    let moved =
        with("    Units {", "    TransformationMatrix 1 0 0 0 0 1 0 0 0 0 1 0 5 0 0 1,\n    Units {", &ReadOptions::default())
            .unwrap();
    assert!(moved.notes.iter().any(|note| note.contains("TransformationMatrix is not applied")), "{:?}", moved.notes);
    // A radius by another name.
    let said = with("float thickness", "float Size", &ReadOptions::default()).unwrap_err();
    assert!(said.contains("no thickness among") && said.contains("`radius_array`"), "{said}");
    let named = ReadOptions { radius_array: Some("size".into()), ..ReadOptions::default() };
    assert!((sizes(&network_of(with("float thickness", "float Size", &named).unwrap()))[0].3 - 0.2).abs() < 1e-9);
    let optional = ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() };
    assert!(with("float thickness", "float Size", &optional).is_ok());
}

/// By hand: up by 0.8, along by 10 and down by 0.8, whatever the unit. A network of capillaries is a few µm wide; its points are no vertices.
#[test]
fn what_is_one_place_does_not_depend_on_the_unit() {
    let file = "# AmiraMesh 3D ASCII 2.0\n\ndefine VERTEX 2\ndefine EDGE 1\ndefine POINT 4\n\nParameters {\n    Units {\n        \
                Coordinates \"mm\"\n    }\n    ContentType \"HxSpatialGraph\"\n}\n\nVERTEX { float[3] VertexCoordinates } @1\n\
                EDGE { int[2] EdgeConnectivity } @2\nEDGE { int NumEdgePoints } @3\nPOINT { float[3] EdgePointCoordinates } @4\n\
                POINT { float thickness } @5\n\n@1\n0 0 0\n10 0 0\n@2\n0 1\n@3\n4\n@4\n0 0.8 0\n3 0.8 0\n6 0.8 0\n10 0.8 0\n@5\n2 2 2 2\n";
    for (unit, mm) in [("mm", 1.0), ("um", 1e-3), ("m", 1e3)] {
        let network = network("a.am", file.replace("\"mm\"", &format!("\"{unit}\"")).as_bytes());
        assert!((sizes(&network)[0].2 / mm - 11.6).abs() < 1e-9, "{unit}: {:?}", sizes(&network));
    }
}

/// Through the front door, which asks whether the options go with the format.
#[test]
fn the_array_of_radii_can_be_named() {
    let here = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| {
        let path = here.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let options = ReadOptions { radius_array: Some("size".into()), ..ReadOptions::default() };
    let text = String::from_utf8(file(Storage::Text)).unwrap().replacen("float thickness", "float Size", 1);
    let named = willis::read(&put("a.am", text.as_bytes()), &options).unwrap().network;
    assert_eq!(sizes(&named), sizes(&network("a.am", &file(Storage::Text))));
    let said = willis::read(&put("a.swc", b"1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n"), &options).unwrap_err().to_string();
    let known = "goes with VTP, VTK legacy, Slicer markups and Amira SpatialGraph; SWC has one radius for each point";
    assert!(said.ends_with(known), "{said}");
}

#[test]
fn what_is_written_is_read_again() {
    let start = network("a.am", &file(Storage::Little));
    let target = Target::new(Path::new("b.am"), None).unwrap();
    assert_eq!(target.format, Format::Amira);
    let written = converted(&start, &target).remove(0).1;
    let text = String::from_utf8(written.clone()).unwrap();
    for line in
        ["define VERTEX 4", "define EDGE 3", "Coordinates \"mm\"", "\"L-ICA, C1\" {", "Left {", "POINT { float thickness } @5"]
    {
        assert!(text.lines().any(|found| found.trim() == line), "{line}\n{text}");
    }
    assert_eq!(sizes(&network("b.am", &written)), sizes(&start));
    assert_eq!(positions(&network("b.am", &written)), positions(&start));
}

/// The bytes between the places of a text.
fn split<'a>(bytes: &'a [u8], text: &[u8]) -> Vec<&'a [u8]> {
    match bytes.windows(text.len()).position(|part| part == text) {
        None => vec![bytes],
        Some(at) => [vec![&bytes[..at]], split(&bytes[at + text.len()..], text)].concat(),
    }
}

#[test]
fn what_is_no_usable_graph_is_refused_in_one_line() {
    let text = String::from_utf8(file(Storage::Text)).unwrap();
    let swap = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1).into_bytes()
    };
    let binary = file(Storage::Little);
    let zip = file(Storage::Zip);
    // In all places, and the packed bytes as they are.
    let zip_with = |from: &str, to: &str| split(&zip, from.as_bytes()).join(to.as_bytes());
    let bomb = |count: &str| zip_with("define POINT 7", &format!("define POINT {count}"));
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        (
            "image.am",
            swap("HxSpatialGraph", "HxUniformScalarField3"),
            "an Amira file of HxUniformScalarField3; expected a SpatialGraph",
        ),
        ("storage.am", swap("ASCII", "MORSE"), "storage.am:1: \"# Avizo 3D MORSE 3.0\"; expected ASCII, BINARY"),
        ("header.am", text.as_bytes()[..300].to_vec(), "no section @1 after the header"),
        ("less.am", swap("@5\n200\n", "@5\n"), "thickness (@5): 6 of 7 numbers; expected all of them"),
        ("word.am", swap("@5\n200\n", "@5\ntwo\n"), "thickness (@5): \"two\"; expected a number"),
        ("vertex.am", swap("@2\n0\n1\n", "@2\n0\n4\n"), "edge 0: vertex 4; expected one of 4, from 0"),
        ("minus.am", swap("@2\n0\n1\n", "@2\n-1\n1\n"), "edge 0: vertex -1"),
        ("points.am", swap("@3\n3\n", "@3\n4\n"), "NumEdgePoints: 8 in all; expected as many as there are points, 7"),
        ("nan.am", swap("@1\n0\n", "@1\nnan\n"), "VertexCoordinates: row 0 is [NaN, 0.0, 0.0]; expected finite numbers"),
        ("many.am", swap("define POINT 7", "define POINT 99999999999999"), "expected"),
        ("none.am", swap("define POINT 7", "define POINT x"), "none.am:6: \"define POINT x\"; expected a whole number"),
        ("kind.am", swap("float thickness", "complex thickness"), "expected float, int or another type of number"),
        ("wide.am", swap("int[2]", "int[3]"), "EdgeConnectivity has 3 numbers each; expected 2 numbers each"),
        ("twice.am", swap("\n@5\n", "\n@4\n"), "section @4 twice"),
        (
            "cut.am",
            binary[..binary.len() - 20].to_vec(),
            "section @5: 25 of 28 bytes; expected all of them; is the file cut off?",
        ),
        ("bomb.am", bomb("99999999999"), "EdgePointCoordinates (@4): more than"),
        ("short.am", bomb("9"), "EdgePointCoordinates (@4): 21 of 27 numbers"),
        ("pack.am", zip_with("HxZip", "HxNew"), "packed as HxNew"),
        ("deep.am", swap("Units {", &"Units {".repeat(99)), "more than 32 groups within one another"),
    ];
    for (name, bytes, wanted) in cases {
        let said = read_first(&[(name, &bytes)], &ReadOptions::default()).map(|_| ()).expect_err(name);
        assert!(said.contains(wanted) && said.starts_with(name) && !said.contains('\n'), "{said}");
    }
    truncated(&[("a.am", &file(Storage::Text))], 7, &ReadOptions::default());
    truncated(&[("a.am", &binary)], 7, &ReadOptions::default());
    truncated(&[("a.am", &zip)], 7, &ReadOptions::default());
}
