//! ITK tubes: scenes typed by hand with the coordinates that ITK gave for them, files of ITK, faults.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use std::path::Path;

use crate::command::{stderr, willis};
use crate::peers::{document, shared};
use willis::internals::formats::{Content, Format, ReadOptions, read, read_tre};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::{LengthUnit, Scale, millimetres};
use willis::internals::network::{Network, RadiusRule, contract, fragments};

fn tre(text: &str) -> Result<(Centerlines, Vec<String>), String> {
    read_tre(text.as_bytes(), &ReadOptions::default()).map_err(|f| f.in_file(Path::new("t")).to_string())
}

fn network_of(mut lines: Centerlines) -> Network {
    lines.weld(1e-6);
    contract(&lines, RadiusRule::Mean, None).unwrap().network
}

/// Positions in mm and radii in mm.
fn in_mm(lines: &Centerlines) -> Vec<[f64; 4]> {
    lines.points.iter().zip(&lines.radii).map(|(p, r)| [p[0], p[1], p[2], *r].map(millimetres)).collect()
}

/// Coordinates that ITK 5.4.7 gave for this scene: it multiplies by ElementSpacing (the radius by the first number), and a point
/// x of a group lies at `TransformMatrix` x + `Offset`, whatever the centre of rotation: (1,0,0) at (11,24,37).
const SCENE: &str = "\
ObjectType = Scene
NDims = 3
NObjects = 4
ObjectType = Group
NDims = 3
ID = 7
TransformMatrix = 1 2 3 4 5 6 7 8 10
Offset = 10 20 30
CenterOfRotation = 1 2 3
EndGroup =
ObjectType = Tube
ObjectSubType = Vessel
NDims = 3
ID = 3
Name = left A1
ElementSpacing = 2 3 4
PointDim = x y z r
NPoints = 3
Points =
0.5 0 0 0.5
1 2 3 0.25
1 2 4 0.6
ObjectType = Tube
ObjectSubType = DTI
NDims = 3
ID = 2
ParentID = 9
PointDim = tx R z y x id
NPoints = 1
Points =
9 0.5 3 2 1 5
ObjectType = Group
ID = 9
ParentID = 9000
TransformMatrix = 0 1 0 -1 0 0 0 0 1
Offset = 0 0 5
EndGroup =
";

#[test]
fn tubes_lie_where_itk_puts_them() {
    let (lines, notes) = tre(SCENE).unwrap();
    let group = |p: [f64; 3]| {
        [
            p[0] + 2.0 * p[1] + 3.0 * p[2] + 10.0,
            4.0 * p[0] + 5.0 * p[1] + 6.0 * p[2] + 20.0,
            7.0 * p[0] + 8.0 * p[1] + 10.0 * p[2] + 30.0,
        ]
    };
    assert_eq!(group([1.0, 0.0, 0.0]), [11.0, 24.0, 37.0]);
    // Spacing, then the group; the second tube (1, 2, 3) turns to (2, -1, 8), and so does its group's point.
    let expected = [group([1.0, 0.0, 0.0]), group([2.0, 6.0, 12.0]), group([2.0, 6.0, 16.0]), group([2.0, -1.0, 8.0])];
    for (found, expected) in in_mm(&lines).iter().zip(expected) {
        for axis in 0..3 {
            assert!((found[axis] - expected[axis]).abs() < 1e-12 * expected[axis].abs(), "{found:?} {expected:?}");
        }
    }
    // |det| = 3: lengths change by its cube root.
    for (row, radius) in [1.0, 0.5, 1.2, 0.5].into_iter().enumerate() {
        assert!((millimetres(lines.radii[row]) - radius * 3_f64.cbrt()).abs() < 1e-12);
    }
    assert_eq!((lines.links.clone(), lines.labels.of(1), lines.strand), (vec![[0, 1], [1, 2]], "left A1", vec![1, 1, 1, 2]));
    assert!(notes.is_empty());
}

/// Two tubes of 5 points along x and one that hangs on the first.
fn family(child: &str) -> String {
    let rows = |y: i32| (0..5).map(|x| format!("{x} {y} 0 1\n")).collect::<Vec<_>>().concat();
    let tube = |id: u32, fields: &str, rows: &str| {
        format!("ObjectType = Tube\nID = {id}\n{fields}PointDim = x y z r\nNPoints = {}\nPoints =\n{rows}", rows.lines().count())
    };
    let child = tube(5, child, "2.2 3 0 0.5\n2.2 2 0 0.5\n2.2 0.5 0 0.5\n");
    tube(4, "", &rows(0)) + &child + &tube(6, "", &rows(9))
}

#[test]
fn a_child_hangs_on_its_parent() {
    // By number: its first point, whatever is nearer. Without: its nearer end at the nearest point.
    for (fields, link) in [
        ("ParentID = 4\nParentPoint = 3\nName = twig\n", [3, 5]),
        ("ParentID = 4\nParentPoint = -1\nName = twig\n", [2, 7]),
        ("ParentID = 4\nName = twig\n", [2, 7]),
    ] {
        let (lines, notes) = tre(&family(fields)).unwrap();
        assert_eq!((lines.links.last(), notes.len()), (Some(&link), 0));
        assert_eq!(lines.labels.of(lines.links.len() - 1), "twig");
        let network = network_of(lines);
        assert_eq!((network.vessel_count(), fragments(&network, |_, _| true).count), (4, 2));
        let labels: Vec<&str> = network.vessels().map(|(_, v)| v.label.as_str()).collect();
        assert_eq!(labels.iter().filter(|l| **l == "twig").count(), 1);
    }
    let (lines, notes) = tre(&family("ParentID = 77\n")).unwrap();
    assert_eq!((lines.links.len(), notes), (10, vec!["tubes whose parent is missing, read as roots: 1".to_owned()]));
    let (_, notes) = tre(&family("").replace("ID = 6", "ID = 4")).unwrap();
    assert_eq!(notes, ["objects that repeat the ID of an earlier object, which keeps the children: 1"]);
}

#[test]
fn the_files_of_itk_keep_their_parents() {
    let Some(folder) = shared("formats") else { return };
    let open = |name: &str| {
        let document = read(&folder.join(name), &ReadOptions::default()).unwrap();
        let Content::Centerlines(lines) = document.content else { panic!() };
        (document.format, lines)
    };
    let (format, apart) = open("tubes-ascii.tre");
    assert_eq!((format, in_mm(&apart)[3]), (Format::Tre, [4.0, 0.5, 1.0, 1.5]));
    let apart = network_of(apart);
    assert_eq!((apart.vessel_count(), fragments(&apart, |_, _| true).count), (2, 2));
    // (4 0.5 1) - (5 0.5 1), then its child (8 0.5 1) - (9 0.5 1): one vessel of 5 mm.
    let (_, text) = open("tubes-children-ascii.tre");
    assert_eq!(text, open("tubes-children-binary.tre").1);
    let family = network_of(text);
    assert_eq!(family.vessel_count(), 1);
    assert!((millimetres(family.vessel(0).length) - 5.0).abs() < 1e-12);
}

#[test]
fn binary_points_are_those_of_the_text() {
    let rows: [[f64; 5]; 3] = [[7.0, 0.5, 1.25, -2.0, 0.75], [8.0, 1.5, 1.25, -2.5, 0.5], [9.0, 2.5, 10.0, 13.0, 0.0]];
    let head = "ObjectType = Tube\nNDims = 3\nID = 1\nName = BA\nPointDim = id x y z r\nNPoints = 3\n";
    let text = rows.map(|row| row.map(|x| x.to_string()).join(" ") + "\n").concat();
    let expected = tre(&format!("{head}Points =\n{text}")).unwrap().0;
    assert_eq!((&expected.ids[..], in_mm(&expected)[1]), (&[7, 8, 9][..], [1.5, 1.25, -2.5, 0.5]));
    assert!(expected.radii[2].is_nan());
    for (big, double) in [(false, false), (true, false), (false, true), (true, true)] {
        let order = if big { "True" } else { "False" };
        let kind = if double { "ElementType = MET_DOUBLE\n" } else { "" };
        let mut bytes = format!("{head}BinaryData = True\nBinaryDataByteOrderMSB = {order}\n{kind}Points = \n").into_bytes();
        for x in rows.as_flattened() {
            match (big, double) {
                (false, false) => bytes.extend((*x as f32).to_le_bytes()),
                (true, false) => bytes.extend((*x as f32).to_be_bytes()),
                (false, true) => bytes.extend(x.to_le_bytes()),
                (true, true) => bytes.extend(x.to_be_bytes()),
            }
        }
        bytes.extend(b"\nObjectType = Surface\nNPoints = 1\nPoints =\n1 2 3\n");
        let (found, notes) = read_tre(&bytes, &ReadOptions::default()).unwrap();
        assert_eq!(in_mm(&found)[..2], in_mm(&expected)[..2]);
        assert_eq!((found.links, found.ids, notes.len()), (expected.links.clone(), expected.ids.clone(), 1));
    }
}

#[test]
fn tre_faults_name_line_and_value() {
    let tube = |head: &str, rows: &str| format!("ObjectType = Tube\nID = 1\n{head}Points =\n{rows}");
    let dims = "PointDim = x y z r\n";
    for (text, message) in [
        (tube("NPoints = 2\n", "1 2 3 1\n"), "t:4: tube 1: 1 points, NPoints says 2; expected them all; is the file cut off?"),
        (tube("NPoints = 1\n", "1 2 3 1\n2 2 3 1\n"), "t:6: \"2 2 3 1\"; expected a line Key = value"),
        (tube("NPoints = 1\n", "1 2 3\n"), "t:5: 3 columns; expected x y z r"),
        (tube(&format!("{dims}NPoints = 1\n"), "1 2 3 4 5\n"), "t:6: 5 columns; expected 4, as in PointDim"),
        (tube("NPoints = 1\n", "1 nan 3 1\n"), "t:5: y NaN; expected a finite number"),
        (tube("NPoints = 1\n", "1 two 3 1\n"), "t:5: \"two\"; expected a number"),
        (tube("NPoints = many\n", ""), "t:3: NPoints \"many\"; expected a whole number"),
        (tube("NPoints = -1\n", ""), "t:3: NPoints \"-1\"; expected a whole number from 0 on"),
        (tube("", "1 2 3 1\n"), "t:3: tube 1: no NPoints before its Points; expected how many there are"),
        (
            tube("PointDim = x z r\nNPoints = 1\n", "1 2 3\n"),
            "t:3: PointDim \"x z r\"; expected the names of the columns, x, y, z and r among them",
        ),
        (
            tube("PointDim = x y z\nNPoints = 1\n", "1 2 3\n"),
            "t:3: tube 1 has no radius; expected a column r in PointDim, or give `default_radius`",
        ),
        (tube("NPoints = 0\n", ""), "t: no points in any tube; expected objects of type Tube with points"),
        (
            "ObjectType = Scene\nNObjects = 2\nObjectType = Group\nEndGroup =\n".into(),
            "t:2: NObjects = 2, but 1 are there; expected as many objects as are stated; is the file cut off?",
        ),
        (
            "ObjectType = Tube\nNDims = 3\n".into(),
            "t:1: a tube without Points; expected PointDim, NPoints and Points; is the file cut off?",
        ),
        (tube("ElementSpacing = 1 1\nNPoints = 1\n", "1 2 3 1\n"), "t:3: ElementSpacing \"1 1\"; expected 3 finite numbers"),
        (tube("ElementSpacing = 1 0 1\nNPoints = 1\n", "1 2 3 1\n"), "t:3: ElementSpacing \"1 0 1\"; expected positive numbers"),
        ("ObjectType = Tu\n".into(), "t:1: ObjectType \"Tu\"; expected Scene, Group, Tube or another type of MetaIO"),
        (
            tube("TransformMatrix = 1 0 0 0 1 0 0 0 0\nNPoints = 1\n", "1 2 3 1\n"),
            "t:3: TransformMatrix \"1 0 0 0 1 0 0 0 0\"; expected one that can be inverted",
        ),
        (
            tube("Orientation = 1 0 0 0 0 0 0 0 1\nNPoints = 1\n", "1 2 3 1\n"),
            "t:3: Orientation \"1 0 0 0 0 0 0 0 1\"; expected one that can be inverted",
        ),
        (
            tube("ParentID = 1\nNPoints = 1\n", "1 2 3 1\n"),
            "t:1: tube 1 is its own ancestor; expected ParentID to lead to a root",
        ),
        (
            tube("BinaryData = True\nNPoints = 9\n", "abc"),
            "t:5: tube 1: 3 bytes of points, 9 points need 144; expected them all; is the file cut off?",
        ),
        (
            tube("BinaryData = True\nNPoints = 9223372036854775807\n", "abc"),
            "t:5: tube 1: 3 bytes of points, 9223372036854775807 points need 18446744073709551615; expected them all; is the file cut off?",
        ),
        (
            tube("BinaryData = True\nElementType = MET_CHAR\nNPoints = 9\n", "abc"),
            "t:4: ElementType \"MET_CHAR\"; expected MET_FLOAT or MET_DOUBLE",
        ),
        (
            tube("BinaryData = True\nCompressedData = True\nNPoints = 9\n", "abc"),
            "t:6: tube 1: CompressedData = True; expected points without compression",
        ),
        (tube("DistanceUnits = inch\nNPoints = 1\n", "1 2 3 1\n"), "t:3: DistanceUnits inch; expected mm, um, cm or m"),
        (family("ParentID = 4\nParentPoint = 5\n"), "t:14: ParentPoint 5; expected 0 to 4: tube 4 has 5 points"),
    ] {
        assert_eq!(tre(&text).unwrap_err(), message);
    }
    let mixed = family("").replacen('\n', "\r\n", 7);
    assert_eq!(tre(&mixed).unwrap(), tre(&family("")).unwrap());
    let marked = [b"\xef\xbb\xbf", family("").as_bytes()].concat();
    assert_eq!(document("a.tre", &marked).unwrap().format, Format::Tre);
    let wide: Vec<u8> = [0xfeff].into_iter().chain(family("").encode_utf16()).flat_map(u16::to_le_bytes).collect();
    assert_eq!(document("a.tre", &wide).unwrap_err(), "a.tre: the text is UTF-16; expected UTF-8; save the file as UTF-8");
}

#[test]
fn tubes_state_their_unit() {
    let text = "ObjectType = Tube\nDistanceUnits = um\nNPoints = 1\nPoints =\n1000 0 0 500\n";
    assert_eq!(in_mm(&tre(text).unwrap().0), [[1.0, 0.0, 0.0, 0.5]]);
    let voxels = Scale { unit: LengthUnit::Voxel, spacing: Some([2.0; 3]) };
    assert_eq!(
        in_mm(&read_tre(text.as_bytes(), &ReadOptions { scale: voxels, ..ReadOptions::default() }).unwrap().0),
        [[2000.0, 0.0, 0.0, 1000.0]]
    );
}

/// What is said of a file that states its unit, as it stands in the file: radii of 9,000 µm are no vessel's, but not for being mm.
#[test]
fn the_unit_that_a_file_states_is_the_one_that_is_told() {
    let here = tempfile::tempdir().unwrap();
    let radius = "\"measurements\": [{\"name\": \"Radius\", \"controlPointValues\": [9000, 9000]}]";
    let points = "\"controlPoints\": [{\"position\": [0, 0, 0]}, {\"position\": [20000, 0, 0]}]";
    let amira = "# AmiraMesh 3D ASCII 2.0\n\ndefine VERTEX 2\ndefine EDGE 1\ndefine POINT 2\n\nParameters {\n    Units {\n        \
                 Coordinates \"um\"\n    }\n    ContentType \"HxSpatialGraph\"\n}\n\nVERTEX { float[3] VertexCoordinates } @1\n\
                 EDGE { int[2] EdgeConnectivity } @2\nEDGE { int NumEdgePoints } @3\nPOINT { float[3] EdgePointCoordinates } @4\n\
                 POINT { float thickness } @5\n\n@1\n0 0 0\n20000 0 0\n@2\n0 1\n@3\n2\n@4\n0 0 0\n20000 0 0\n@5\n9000 9000\n";
    for (name, text, given, told) in [
        (
            "a.tre",
            "ObjectType = Tube\nDistanceUnits = um\nNPoints = 2\nPoints =\n0 0 0 9000\n20000 0 0 9000\n".to_owned(),
            None,
            "um",
        ),
        ("b.tre", "ObjectType = Tube\nNPoints = 2\nPoints =\n0 0 0 9\n20 0 0 9\n".to_owned(), None, "mm assumed"),
        ("b.tre", "ObjectType = Tube\nNPoints = 2\nPoints =\n0 0 0 0.9\n2 0 0 0.9\n".to_owned(), Some("cm"), "cm"),
        (
            "a.mrk.json",
            format!("{{\"markups\": [{{\"type\": \"Line\", \"coordinateUnits\": [\"um\", \"UCUM\"], {points}, {radius}}}]}}"),
            None,
            "um",
        ),
        ("a.am", amira.to_owned(), None, "um"),
    ] {
        std::fs::write(here.path().join(name), text).unwrap();
        let units = given.iter().flat_map(|unit| ["--units", unit]);
        let arguments: Vec<&str> = ["convert", name, "c.csv", "--json", "--force"].into_iter().chain(units).collect();
        let done = willis(here.path(), &arguments);
        let said = stderr(&done);
        assert!(done.status.success() && said.contains(&format!(", {told}: 1 ")), "{said}");
        let unit = &told[..2];
        assert!(
            said.contains(&format!("the median radius is 9.000 mm and the extent 20.000 mm, with lengths in {unit}")),
            "{said}"
        );
        let record: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!(record["input"]["units"], unit);
    }
}

/// A group that is only moved turns nothing: what it does not state of its matrix is the identity.
#[test]
fn a_group_with_an_offset_alone_moves_its_tubes() {
    let scene = "ObjectType = Group\nNDims = 3\nID = 1\nOffset = 10 20 30\nEndGroup =\nObjectType = Tube\nNDims = 3\nID = 2\n\
                 ParentID = 1\nPointDim = x y z r\nNPoints = 2\nPoints =\n1 2 3 0.5\n4 6 9 0.5\n";
    let (lines, _) = tre(scene).unwrap();
    assert_eq!(in_mm(&lines), [[11.0, 22.0, 33.0, 0.5], [14.0, 26.0, 39.0, 0.5]]);
}
