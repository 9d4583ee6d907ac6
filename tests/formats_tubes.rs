//! ITK tubes, Slicer markups, CSV of points and labels of SWC: files typed by hand, files of ITK, round trips, broken files.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use std::path::{Path, PathBuf};
use std::process::Command;

use willis::centerline::Centerlines;
use willis::formats::{
    Content, Document, Format, RadiusArray, ReadOptions, read, read_markups, read_points, read_swc, read_tre,
    write_centerlines_swc, write_markups, write_points, write_swc, write_tre,
};
use willis::network::{Network, Node, PathPoint, RadiusRule, Role, Vessel, contract, cycles, fragments};
use willis::units::{LengthUnit, Scale, metres, millimetres};

fn mm() -> Scale {
    Scale::default()
}

fn tre(text: &str) -> Result<(Centerlines, Vec<String>), String> {
    read_tre(text.as_bytes(), &mm(), false).map_err(|f| f.in_file(Path::new("t")).to_string())
}

fn markups(text: &str) -> Result<(Centerlines, Vec<String>), String> {
    read_markups(text.as_bytes(), &mm(), RadiusArray::Usual).map_err(|f| f.in_file(Path::new("m")).to_string())
}

fn points(text: &str) -> Result<(Centerlines, Vec<String>), String> {
    read_points(text.as_bytes(), &mm(), false).map_err(|f| f.in_file(Path::new("p")).to_string())
}

fn document(name: &str, content: &[u8]) -> Result<Document, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    read(&path, &ReadOptions::default()).map_err(|e| e.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name);
    if !path.exists() {
        eprintln!("skipped: no {name} beside the package");
    }
    path.exists().then_some(path)
}

/// Runs a script with a python that has the peers' packages; `None` where there is none.
fn python(script: &str, arguments: &[&Path]) -> Option<String> {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no python");
        return None;
    };
    let output = Command::new(python).arg("-c").arg(script).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap().trim().to_owned())
}

fn network_of(mut lines: Centerlines) -> Network {
    lines.weld(1e-6);
    contract(&lines, RadiusRule::Mean, None).unwrap().network
}

/// Positions in mm and radii in mm.
fn in_mm(lines: &Centerlines) -> Vec<[f64; 4]> {
    lines.points.iter().zip(&lines.radii).map(|(p, r)| [p[0], p[1], p[2], *r].map(millimetres)).collect()
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
    let rows = |y: i32| (0..5).map(|x| format!("{x} {y} 0 1\n")).collect::<String>();
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
    assert_eq!((lines.links.len(), notes), (10, vec!["tubes whose parent is not there, read as roots: 1".to_owned()]));
    let (_, notes) = tre(&family("").replace("ID = 6", "ID = 4")).unwrap();
    assert_eq!(notes, ["objects with the ID of one before them, to which its children belong: 1"]);
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
        let (found, notes) = read_tre(&bytes, &mm(), false).unwrap();
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
        (tube("", "1 2 3 1\n"), "t:3: tube 1: no NPoints before its Points; expected how many there are"),
        (
            tube("PointDim = x z r\nNPoints = 1\n", "1 2 3\n"),
            "t:3: PointDim \"x z r\"; expected the names of the columns, x, y, z and r among them",
        ),
        (
            tube("PointDim = x y z\nNPoints = 1\n", "1 2 3\n"),
            "t:3: tube 1 has no radius; expected a column r in PointDim, or give --default-radius",
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
            "t:4: ElementType MET_CHAR; expected MET_FLOAT or MET_DOUBLE",
        ),
        (
            tube("BinaryData = True\nCompressedData = True\nNPoints = 9\n", "abc"),
            "t:6: tube 1: CompressedData = True; expected points without compression",
        ),
        (tube("DistanceUnits = inch\nNPoints = 1\n", "1 2 3 1\n"), "t:3: DistanceUnits inch; expected um, mm or cm"),
        (family("ParentID = 4\nParentPoint = 5\n"), "t:14: ParentPoint 5; expected 0 to 4: tube 4 has 5 points"),
    ] {
        assert_eq!(tre(&text).unwrap_err(), message);
    }
    let mixed = family("").replacen('\n', "\r\n", 7);
    assert_eq!(tre(&mixed).unwrap(), tre(&family("")).unwrap());
    let marked = [b"\xef\xbb\xbf", family("").as_bytes()].concat();
    assert_eq!(document("a.tre", &marked).unwrap().format, Format::Tre);
    let wide: Vec<u8> = [0xfeff].into_iter().chain(family("").encode_utf16()).flat_map(u16::to_le_bytes).collect();
    assert_eq!(document("a.tre", &wide).unwrap_err(), "a.tre: the text is UTF-16; expected UTF-8; save it so");
}

#[test]
fn tubes_state_their_unit() {
    let text = "ObjectType = Tube\nDistanceUnits = um\nNPoints = 1\nPoints =\n1000 0 0 500\n";
    assert_eq!(in_mm(&tre(text).unwrap().0), [[1.0, 0.0, 0.0, 0.5]]);
    let voxels = Scale { unit: LengthUnit::Voxel, spacing: Some([2.0; 3]) };
    assert_eq!(in_mm(&read_tre(text.as_bytes(), &voxels, false).unwrap().0), [[2000.0, 0.0, 0.0, 1000.0]]);
}

/// As SlicerVMTK's ExtractCenterline leaves curves, and what else a person may put in the file.
const CURVES: &str = r#"{"@schema": "x", "markups": [
{"type": "Curve", "name": "L-M1", "coordinateSystem": "LPS", "coordinateUnits": "mm", "controlPoints": [
 {"id": "1", "label": "a", "position": [1.0, 2.0, 3.0], "orientation": [1,0,0,0,1,0,0,0,1], "positionStatus": "defined"},
 {"position": [0,0,0], "positionStatus": "undefined"},
 {"position": [2.0, 2.0, 3.5]}],
 "measurements": [{"name": "length", "value": 7.5}, {"name": "Radius", "units": "mm", "controlPointValues": [0.5, 9, null]}]},
{"type": "ClosedCurve", "coordinateSystem": "RAS", "coordinateUnits": ["um", "UCUM", "micrometer"], "controlPoints": [
 {"position": [-2000, -2000, 3500]}, {"position": [0, 0, 0]}, {"position": [0, 1, 0]}],
 "measurements": [{"name": "radius", "controlPointValues": [1000, 2000, 3000]}]},
{"type": "Fiducial", "controlPoints": [{"position": [0,0,0]}]}
]}"#;

#[test]
fn curves_are_read_in_lps_and_mm() {
    let (lines, notes) = markups(CURVES).unwrap();
    let found = in_mm(&lines);
    assert_eq!(found[0], [1.0, 2.0, 3.0, 0.5]);
    assert!(found[1][..3] == [2.0, 2.0, 3.5] && found[1][3].is_nan());
    assert_eq!(found[2..], [[2.0, 2.0, 3.5, 1.0], [0.0, 0.0, 0.0, 2.0], [0.0, -0.001, 0.0, 3.0]]);
    assert_eq!(lines.links, [[0, 1], [2, 3], [3, 4], [4, 2]]);
    assert_eq!([lines.labels.of(0), lines.labels.of(1)], ["L-M1", ""]);
    assert_eq!(
        notes,
        [
            "markups in RAS, whose x and y changed sign because positions are kept in LPS: 1",
            "control points without a defined position, left out: 1",
            "markups that are no curves, left out: 1"
        ]
    );
    assert_eq!(document("a.json", CURVES.as_bytes()).unwrap().format, Format::Markups);
    // The two curves meet at (2, 2, 3.5): a vessel that hangs on a ring.
    let network = network_of(lines);
    assert_eq!((network.vessel_count(), cycles(&network), fragments(&network, |_, _| true).count), (2, 1, 1));
}

#[test]
fn markups_faults_name_the_markup_and_the_value() {
    let curve = |rest: &str| format!("{{\"markups\": [{{\"type\": \"Curve\", \"name\": \"c\", {rest}}}]}}");
    let one = "\"controlPoints\": [{\"position\": [1,2,3]}]";
    for (text, message) in [
        ("{\"a\": 1}".into(), "m: JSON without \"markups\"; expected 3D Slicer markups"),
        ("{\"markups\": []}".into(), "m: no markups; expected markups of type Curve, ClosedCurve or Line"),
        (
            "{\"markups\": [{\"type\": \"Fiducial\", \"controlPoints\": [{\"position\": [1,2,3]}]}]}".into(),
            "m: markups of type Fiducial, which are landmarks and no centerlines; expected markups of type Curve, ClosedCurve or Line",
        ),
        ("{\"markups\": [".into(), "m:1: column 13: EOF while parsing a list; expected JSON of 3D Slicer markups"),
        (
            curve("\"controlPoints\": [{\"position\": [1,NaN,3]}]"),
            "m:1: column 79: expected value; expected JSON of 3D Slicer markups",
        ),
        (
            curve("\"controlPoints\": 3"),
            "m:1: column 62: invalid type: integer `3`, expected a sequence; expected JSON of 3D Slicer markups",
        ),
        (
            curve(
                "\"controlPoints\": [{\"position\": [1,2]}], \"measurements\": [{\"name\": \"Radius\", \"controlPointValues\": [1]}]",
            ),
            "m: markup 0 \"c\": control point 0 without a position; expected three finite numbers",
        ),
        (
            curve(one),
            "m: markup 0 \"c\": no radius; expected a measurement Radius with a value for each control point, or give --default-radius",
        ),
        (
            curve(&format!("{one}, \"measurements\": [{{\"name\": \"Radius\", \"controlPointValues\": [1, 2]}}]")),
            "m: markup 0 \"c\": 2 values of Radius for 1 points; expected one for each control point",
        ),
        (curve(&format!("{one}, \"coordinateSystem\": \"IJK\"")), "m: markup 0 \"c\": coordinateSystem IJK; expected LPS or RAS"),
        (
            curve(&format!("{one}, \"coordinateUnits\": \"inch\"")),
            "m: markup 0 \"c\": coordinateUnits inch; expected mm, um, cm or m",
        ),
        (
            curve("\"controlPoints\": []"),
            "m: markup 0 \"c\": no radius; expected a measurement Radius with a value for each control point, or give --default-radius",
        ),
    ] {
        assert_eq!(markups(&text).unwrap_err(), message);
    }
    let bare = curve(one);
    let read = |radius| read_markups(bare.as_bytes(), &mm(), radius);
    assert!(read(RadiusArray::Optional).unwrap().0.radii[0].is_nan());
    assert_eq!(
        read(RadiusArray::Named("thickness")).unwrap_err().in_file(Path::new("m")).to_string(),
        "m: markup 0 \"c\": no measurement thickness at its control points; expected it, as --radius-array says"
    );
    let wide: Vec<u8> = [0xfeff].into_iter().chain(CURVES.encode_utf16()).flat_map(u16::to_be_bytes).collect();
    assert_eq!(document("a.mrk.json", &wide).unwrap_err(), "a.mrk.json: the text is UTF-16; expected UTF-8; save it so");
    let marked = [b"\xef\xbb\xbf", CURVES.replacen('\n', "\r\n", 5).as_bytes()].concat();
    assert_eq!(document("a.mrk.json", &marked).unwrap().format, Format::Markups);
}

#[test]
fn points_in_any_order_of_columns_and_rows() {
    let expected =
        points("fragment,x,y,z,radius,label\n1,0,0,0,1,\n1,1,0,0,2,BA\n2,5,0,0,,\n2,6,0,0,3,\"a, b\"\n1,2,0,0,3,BA\n").unwrap().0;
    assert_eq!(expected.links, [[0, 1], [2, 3], [1, 4]]);
    assert_eq!([expected.labels.of(0), expected.labels.of(1), expected.labels.of(2)], ["BA", "a, b", "BA"]);
    assert!(expected.radii[2].is_nan() && expected.strand == [0, 0, 1, 1, 0]);
    let other = "Label\tradius_mm\tz_mm\ty_mm\tx_mm\tFragment\tnote\n\t1\t0\t0\t0\t1\t\r\nBA\t2\t0\t0\t1\t1\tq\n\n\t\t0\t0\t5\t2\t\na, b\t3\t0\t0\t6\t2\t\nBA\t3\t0\t0\t2\t1\t";
    let found = points(other).unwrap().0;
    assert_eq!((&found.points, &found.links, &found.labels), (&expected.points, &expected.links, &expected.labels));
    let numbered = points("id;fragment;x;y;z;r\n7;a;0;0;0;1\n3;a;1;0;0;1\n").unwrap().0;
    assert_eq!((numbered.ids, numbered.links), (vec![7, 3], vec![[0, 1]]));
    let named = document("a.txt", "\u{feff}fragment,x,y,z,radius\nBA,0,0,0,1\nBA,1,0,0,1\n".as_bytes()).unwrap();
    assert_eq!((named.format, named.notes.len()), (Format::Points, 0));
}

#[test]
fn points_faults_name_line_and_value() {
    let head = "fragment,x,y,z,radius\n";
    let columns = "expected a header with columns fragment,x,y,z,radius (or x_mm and so on); label and id are optional";
    for (text, message) in [
        ("fragment,x,y,radius\n1,0,0,1\n".into(), format!("p:1: columns fragment,x,y,radius; {columns}")),
        ("fragment,x,y,z\n1,0,0,1\n".into(), "p:1: no column radius; expected one, or give --default-radius".into()),
        ("fragment,x,y,z,x_mm\n".into(), "p:1: column \"x_mm\" comes twice; expected every column once".into()),
        (head.into(), "p: no points; expected a row for every point".into()),
        (format!("{head}1,0,0,zero,1\n"), "p:2: z \"zero\"; expected a number".into()),
        (format!("{head}1,0,NaN,0,1\n"), "p:2: y NaN; expected a finite number".into()),
        (format!("{head}1,0,0,0,wide\n"), "p:2: radius \"wide\"; expected a number".into()),
        (format!("{head}1,0,0,0,1\n,0,0,0,1\n"), "p:3: no fragment; expected the name or number of the polyline".into()),
        ("fragment,x,y,z,r\r\n1,0,0,0,1\r\n\r\n1,0,0,q,1\r\n".into(), "p:4: z \"q\"; expected a number".into()),
        (format!("{head}1,0,0\n"), "p:2: 3 columns; expected 5, as in the header".into()),
        ("fragment,x,y,z,r,id\n1,0,0,0,1,a\n".into(), "p:2: id \"a\"; expected a whole number from 0 on".into()),
        (
            "fragment,x,y,z,r,id\n1,0,0,0,1,4\n1,0,0,1,1,4\n".into(),
            "p:3: id 4 is that of line 2 too; expected every id once".into(),
        ),
    ] {
        assert_eq!(points(&text).unwrap_err(), message);
    }
    let wide: Vec<u8> = [0xfeff].into_iter().chain(head.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    assert_eq!(document("a.csv", &wide).unwrap_err(), "a.csv: the text is UTF-16; expected UTF-8; save it so");
    assert_eq!(document("a.csv", b"fragment,x,y\n").unwrap_err(), format!("a.csv:1: columns fragment,x,y; {columns}"));
    assert!(read_points("fragment,x,y,z\n1,0,0,0\n".as_bytes(), &mm(), true).unwrap().0.radii[0].is_nan());
}

#[test]
fn types_of_swc_are_labels() {
    let labels = |text: &str| {
        let lines = read_swc(text.as_bytes(), &mm()).unwrap().0;
        (0..lines.links.len()).map(|row| lines.labels.of(row).to_owned()).collect::<Vec<_>>()
    };
    let body = "1 9 0 0 0 1 -1\n2 2 1 0 0 1 1\n3 0 2 0 0 1 2\n4 3.0 3 0 0 1 3\n5 3 4 0 0 1 4\n";
    assert_eq!(labels(body), ["2", "", "3", "3"]);
    assert_eq!(
        labels(&format!("# label 3 R-P1\n#label x y\n# label 2\n{body}#  label 2  Ba silaris \n")),
        ["Ba silaris", "", "R-P1", "R-P1"]
    );
    // All the same say nothing, unless they are named.
    let same = "1 1 0 0 0 1 -1\n2 3 1 0 0 1 1\n3 3 2 0 0 1 2\n";
    assert_eq!(labels(same), ["", ""]);
    assert_eq!(labels(&format!("# label 3 BA\n{same}")), ["BA", "BA"]);
    // Landmarks at the ends of trees say nothing of vessels.
    assert_eq!(labels("1 4 0 0 0 1 -1\n2 0 1 0 0 1 1\n3 6 2 0 0 1 2\n"), ["", ""]);
    assert_eq!(labels("1 4 0 0 0 1 -1\n2 6 1 0 0 1 1\n3 7 2 0 0 1 1\n"), ["6", "7"]);
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
        read_tre(&tubes, &mm(), false).unwrap().0,
        read_markups(&curves, &mm(), RadiusArray::Usual).unwrap().0,
        read_points(&table[..], &mm(), false).unwrap().0,
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
    if let Some(folder) = std::env::var_os("WILLIS_KEEP") {
        for (name, bytes) in [("a.tre", &tubes), ("a.json", &curves), ("a.csv", &table)] {
            std::fs::write(Path::new(&folder).join(name), bytes).unwrap();
        }
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
            read_tre(bytes, &mm(), false).err(),
            read_markups(bytes, &mm(), RadiusArray::Usual).err(),
            read_points(bytes, &mm(), false).err(),
            read_swc(bytes, &mm()).err(),
        ];
        for fault in faults.into_iter().flatten() {
            assert_eq!(fault.in_file(Path::new("x")).to_string().lines().count(), 1);
        }
    };
    for whole in [&tubes, &curves, &table, &binary, &SCENE.as_bytes().to_vec(), &CURVES.as_bytes().to_vec()] {
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
        assert!(!inside || read_tre(&tubes[..cut], &mm(), false).is_err(), "cut at {cut}");
    }
}

/// A labelled vessel with a gap beside it: what infer splits keeps its name.
#[test]
fn labels_reach_the_table_of_edges_on_both_sides_of_a_split() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("fragment,x,y,z,radius,label\n");
    for x in 0..41 {
        text += &format!("trunk,{x},0,0,1.5,L-M1\n");
    }
    for y in 3..20 {
        text += &format!("twig,20,{y},0,0.7,L-M2\n");
    }
    std::fs::write(folder.path().join("a.csv"), text).unwrap();
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
