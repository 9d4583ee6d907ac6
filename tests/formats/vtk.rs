//! VTK's legacy and XML PolyData: files typed by hand or written by VTK, ours read by VTK, broken ones. VTK is the judge.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use std::f64::consts::PI;
use std::path::Path;

use crate::peers::python;
use willis::error::Fault;
use willis::internals::formats::{
    Column, Content, ReadOptions, Values, graph_columns, read, read_vtk, read_vtp, write_swc, write_vtk, write_vtp,
};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::{Scale, metres};
use willis::internals::network::{Network, Node, Origin, PathPoint, RadiusRule, Vessel, contract, fragments};

/// Names of the links and radii (mm) of the points, in their order.
fn names(lines: &Centerlines) -> Vec<&str> {
    (0..lines.links.len()).map(|link| lines.labels.of(link)).collect()
}

/// Two lines and a vertex cell, with every kind of array beside those that count.
const OLD: &str = "# vtk DataFile Version 3.0
a title that may say POINTS 7
ascii
dataset PolyData
field FieldData 1
made%20by 1 1 string
a person

points 5 float
0 0 0  1 0 0
2 0 0  3 0 0 9 9 nan
vertices 1 2 1 4
lines 2 7
3 3 1 0
2 1 2
cell_data 3
scalars label int 1
lookup_table default
7 8 9
point_data 5
lookup_table colours 1
0 0 0 1
vectors v float
1 2 3 1 2 3 1 2 3 1 2 3 1 2 3
normals n float
1 2 3 1 2 3 1 2 3 1 2 3 1 2 3
color_scalars c 2
0 0 0 0 0 0 0 0 0 0
texture_coordinates t 2 float
0 0 0 0 0 0 0 0 0 0
Field more 2
a%20name 2 5 double
0 0 0 0 0 0 0 0 0 0
METADATA
INFORMATION 1
NAME L2_NORM_RANGE LOCATION vtkDataArray
DATA 2 0 1

Radius 1 5 float
1 2 3 4 5
";

fn old(from: &str, to: &str) -> Result<(Centerlines, Vec<String>), Fault> {
    assert!(OLD.contains(from), "{from}");
    read_vtk(OLD.replacen(from, to, 1).as_bytes(), &ReadOptions::default())
}

#[test]
fn a_file_typed_by_hand_is_read() {
    let (lines, notes) = old("", "").unwrap();
    assert_eq!(lines.ids, [3, 1, 0, 2]);
    assert_eq!(lines.links, [[0, 1], [1, 2], [1, 3]]);
    assert_eq!(lines.radii, [4.0, 2.0, 1.0, 3.0].map(metres));
    // The first value belongs to the vertex.
    assert_eq!(names(&lines), ["8", "8", "9"]);
    assert_eq!(notes, ["1 vertex cells are ignored"]);
    let new = "LINES 3 5\nOFFSETS vtktypeint64\n0 3 5\nCONNECTIVITY vtktypeint64\n3 1 0 1 2\n";
    let later = "vertices 2 1 OFFSETS vtktypeint64 0 1 CONNECTIVITY vtktypeint64 4";
    assert_eq!(old("lines 2 7\n3 3 1 0\n2 1 2\n", new).unwrap().0, lines);
    assert_eq!(old("vertices 1 2 1 4\n", &format!("{later}\n")).unwrap().0, lines);
    let crlf = OLD.replace('\n', "\r\n");
    assert_eq!(read_vtk(crlf.as_bytes(), &ReadOptions::default()).unwrap().0, lines);
    let mixed = OLD.replacen('\n', "\r\n", 9);
    assert_eq!(read_vtk(mixed.as_bytes(), &ReadOptions::default()).unwrap().0, lines);
}

/// Bytes that are the active scalars, as VTK 9.6 writes them: as text shares of 255, else as they are.
#[test]
fn radii_that_are_bytes_are_read() {
    let head = |kind: &str| format!("# vtk DataFile Version 3.0\nt\n{kind}\nDATASET POLYDATA\nPOINTS 3 float\n").into_bytes();
    let lines = |points: &[u8], cells: &[u8], radii: &[u8], kind: &str| {
        let parts: [&[u8]; 7] =
            [&head(kind), points, b"\nLINES 1 4\n", cells, b"\nPOINT_DATA 3\nCOLOR_SCALARS Radius 1\n", radii, b"\n"];
        read_vtk(&parts.concat(), &ReadOptions::default()).unwrap().0
    };
    let text = lines(b"0 0 0 10 0 0 20 0 0", b"3 0 1 2", b"0.00784314 0.0117647 0.784314", "ASCII");
    let points: Vec<u8> = [0.0_f32, 0.0, 0.0, 10.0, 0.0, 0.0, 20.0, 0.0, 0.0].into_iter().flat_map(f32::to_be_bytes).collect();
    let cells: Vec<u8> = [3_i32, 0, 1, 2].into_iter().flat_map(i32::to_be_bytes).collect();
    let binary = lines(&points, &cells, &[2, 3, 200], "BINARY");
    assert_eq!(text.radii, [2.0, 3.0, 200.0].map(metres));
    assert_eq!(binary, text);
}

#[test]
fn every_fault_has_its_place_and_one_line() {
    let named = "v: no point array MaximumInscribedSphereRadius, Radius, radius; there are \"v\", \"n\", \"c\", \"t\", \"a name\", \"Width\" and the cell arrays \
                 \"label\"; name one with `radius_array`, or give `default_radius`";
    for (from, to, message) in [
        ("ascii", "text", "v:3: the head of the file: \"text\"; expected ASCII or BINARY"),
        ("PolyData", "STRUCTURED_GRID", "v:4: the head of the file: dataset STRUCTURED_GRID; expected DATASET POLYDATA"),
        ("# vtk DataFile Version", "# vtk File", "v:1: \"# vtk File 3.0\"; expected # vtk DataFile Version 2.0 to 5.1"),
        ("points 5", "points many", "v:9: POINTS: \"many\"; expected the number of points, a count up to 67108864"),
        ("points 5", "points 99999999", "v:9: POINTS: \"99999999\"; expected the number of points, a count up to 67108864"),
        (
            "points 5 float",
            "points 5 quad",
            "v:9: POINTS: type \"quad\"; expected bit, char, short, int, long, float or double, or string",
        ),
        ("9 9 nan", "9 nine nan", "v:11: POINTS: \"nine\"; expected a number"),
        ("lines 2 7", "lines 2 6", "v:15: LINES: cell 1 has 2 points; expected 2 cells in 6 entries"),
        ("lines 2 7", "lines 9 7", "v:15: LINES: cell 2 is missing; expected 9 cells in 7 entries"),
        ("3 3 1 0", "3 3 1 7", "v: line 0: point 7; expected a point from 0 to 4"),
        ("3 3 1 0", "3 3 1 4", "v: point 4: coordinates 9 9 NaN; expected finite numbers"),
        ("3 3 1 0", "3 3 1 0.5", "v:14: LINES: \"0.5\"; expected a whole number"),
        ("cell_data 3", "cell_data 2", "v:16: CELL_DATA: 2 values; expected 3, one for each of the cells"),
        ("point_data 5", "point_data 4", "v:20: POINT_DATA: 4 values; expected 5, one for each of the points"),
        ("Radius 1 5", "Radius 1 4", "v:39: array \"Radius\": 4 values; expected 5"),
        ("1 2 3 4 5\n", "1 2 3 4", "v:40: array \"Radius\": 4 values; expected 5"),
        ("1 2 3 4 5\n", "1 2 3 4 five", "v:40: array \"Radius\": \"five\"; expected a number"),
        ("Radius 1 5", "Width 1 5", named),
        (
            "normals",
            "abnormals",
            "v:25: keyword: \"ABNORMALS\"; expected POINTS, VERTICES, LINES, POLYGONS, TRIANGLE_STRIPS, POINT_DATA, CELL_DATA or an array",
        ),
        ("lookup_table default\n", "", "v:18: SCALARS \"label\": \"7\"; expected LOOKUP_TABLE"),
        (
            "lines 2 7\n3 3 1 0\n2 1 2",
            "polygons 2 7\n3 3 1 0\n2 1 2",
            "v: a surface of 2 polygons, not centerlines; expected LINES",
        ),
        (
            "lines 2 7\n3 3 1 0\n2 1 2\ncell_data 3\nscalars label int 1\nlookup_table default\n7 8 9\n",
            "",
            "v: no lines; expected LINES",
        ),
    ] {
        let found = old(from, to).expect_err(to).in_file(Path::new("v")).to_string();
        assert_eq!(found, message);
    }
    let named = ReadOptions { radius_array: Some("v".into()), ..ReadOptions::default() };
    let found = read_vtk(OLD.as_bytes(), &named).expect_err("vectors").in_file(Path::new("v")).to_string();
    assert_eq!(found, "v: array \"v\" of texts or vectors; expected one number for each point or line");
    let vertex = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n0 0 0\nVERTICES 1 2\n1 0\n";
    let found = read_vtk(vertex.as_bytes(), &ReadOptions::default()).expect_err("no lines").in_file(Path::new("v"));
    assert_eq!(found.to_string(), "v: no lines; expected LINES");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vtk");
    let said = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let found = read(&path, &ReadOptions::default());
        found.map(|document| document.format.name()).map_err(|e| e.to_string().replace(&path.display().to_string(), "v"))
    };
    let wide: Vec<u8> = [0xff, 0xfe].into_iter().chain(OLD.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    assert_eq!(said(&wide).unwrap_err(), "v: the text is UTF-16; expected UTF-8; save the file as UTF-8");
    assert!(said(b"").unwrap_err().starts_with("v: the file is empty; expected "));
    assert_eq!(said(&[b"\xef\xbb\xbf", OLD.as_bytes()].concat()), Ok("VTK legacy"));
}

#[test]
fn areas_come_before_radii_and_spheres_stand_in() {
    let with = |arrays: &str| old("Field more 2", arrays).unwrap();
    let area = "1 5 double\n3.141592653589793 0 nan 12.566370614359172 1\n";
    let (lines, notes) = with(&format!("Field more 3\nCenterlineSectionArea {area}"));
    assert_eq!(lines.radii, [2.0, 2.0, 1.0, 3.0].map(metres));
    let said = "radius from the areas of point array \"CenterlineSectionArea\": r = sqrt(a / pi); at 2 points without one from point array \"Radius\"";
    assert_eq!(notes[1], said);
    let (lines, _) = with(&format!("Field more 4\nCenterlineSectionClosed 1 5 int 1 1 1 0 1\nCenterlineSectionArea {area}"));
    assert_eq!(lines.radii, [4.0, 2.0, 1.0, 3.0].map(metres), "a section that is not closed has no area");
    // Named, in another unit: the area is in its square.
    let text = OLD.replace("Radius", "lumen_AREA");
    let scale = Scale { unit: willis::internals::network::units::LengthUnit::Centimetre, spacing: None };
    let (lines, notes) =
        read_vtk(text.as_bytes(), &ReadOptions { scale, radius_array: Some("lumen_AREA".into()), ..ReadOptions::default() })
            .unwrap();
    assert!((lines.radii[0] - 0.01 * (4.0 / PI).sqrt()).abs() < 1e-17);
    assert_eq!(notes[1], "radius from the areas of point array \"lumen_AREA\": r = sqrt(a / pi)");
    let unknown = read_vtk(OLD.as_bytes(), &ReadOptions { radius_array: Some("Area".into()), ..ReadOptions::default() })
        .unwrap_err()
        .in_file(Path::new("v"));
    assert_eq!(
        unknown.to_string(),
        "v: no point array \"Area\"; there are \"v\", \"n\", \"c\", \"t\", \"a name\", \"Radius\" and the cell arrays \"label\""
    );
}

#[test]
fn radii_and_numbers_of_cells_as_the_circle_of_willis_program_writes_them() {
    let text = "# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 2 0 0 3 0 0\n\
                LINES 3 9\n2 0 1 2 1 2 2 2 3\nCELL_DATA 3\nFIELD FieldData 3\nlabels 1 3 int\n1 2 13\n\
                ce_radius 1 3 double\n2 nan nan\nmis_radius 1 3 double\n1 1 1\n";
    let (lines, notes) = read_vtk(text.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(names(&lines), ["BA", "R-PCA", "13"]);
    // 0 is the background of every segmentation, and no class: of this program and of others.
    for radii in ["ce_radius", "Radius"] {
        let text = text.replace("\n1 2 13\n", "\n0 -3 13\n").replace("ce_radius", radii).replace("mis_radius", "other");
        let (lines, _) = read_vtk(text.as_bytes(), &ReadOptions::default()).unwrap();
        assert_eq!(names(&lines), ["", "-3", "13"], "{radii}");
    }
    assert_eq!(lines.radii, [2.0, 2.0, 1.0, 1.0].map(metres));
    assert!(notes[0].starts_with("radius from cell array \"ce_radius\"; at 2 points without one from cell array \"mis_radius\""));
}

/// By hand: two cells of 1 and 3 mm make one vessel, (1 · 1 + 3 · 4)/4 mm wide; each branch is as wide as its own cell, not as the mean of those
/// that meet.
#[test]
fn vessels_are_as_wide_as_their_own_cells() {
    let text = "# vtk DataFile Version 4.2\nt\nASCII\nDATASET POLYDATA\nPOINTS 5 float\n0 0 0 1 0 0 4 0 0 4 1 0 4 -2 0\n\
                LINES 4 12\n2 0 1 2 1 2 2 2 3 2 2 4\nCELL_DATA 4\nFIELD FieldData 1\nRadius 1 4 double\n1 4 0.5 0.25\n";
    let (lines, _) = read_vtk(text.as_bytes(), &ReadOptions::default()).unwrap();
    let found = contract(&lines, RadiusRule::Mean, None).unwrap().network;
    let radii: Vec<f64> = found.vessels().map(|(_, vessel)| (1e12 * vessel.radius).round()).collect();
    assert_eq!(radii, [3.25e9, 0.5e9, 0.25e9]);
}

/// A junction, a ring at it and a path; positions that millimetres cannot hold exactly.
fn network() -> Network {
    let mut network = Network::new();
    for (n, p) in [[0.0, 0.0, 0.0], [0.1, 0.0, 0.3], [1.0 / 3.0, 0.7, 1e-7], [2.0, 1e-3, -5.0]].into_iter().enumerate() {
        let radius = Some(metres(0.1 + n as f64 / 7.0));
        network.add_node(Node { id: n.to_string(), position: Some(p.map(metres)), radius, ..Node::default() });
    }
    let end =
        |n: usize| PathPoint { position: network.node(n).position.unwrap(), radius: network.node(n).radius.unwrap(), id: None };
    let bend = |x: f64| PathPoint { position: [x, 0.07, 0.11].map(metres), radius: metres(0.1 + x / 7.0), id: None };
    let paths = [
        ([0, 1], vec![end(0), bend(0.05), bend(0.06), end(1)], "L <M1> & \"é\" %"),
        ([1, 2], vec![end(1), end(2)], ""),
        ([1, 3], vec![end(1), bend(3.3), end(3)], "BA"),
        ([2, 2], vec![end(2), bend(5.0), bend(6.0), bend(7.0), end(2)], "ring"),
    ];
    for (ends, path, label) in paths {
        network.add_vessel(ends, Vessel { label: label.to_owned(), ..Vessel::along(path, RadiusRule::Mean) });
    }
    network
}

fn columns(network: &Network) -> Vec<Column> {
    let of = |f: fn(&Vessel) -> f64| Values::Real(network.vessels().map(|(_, v)| f(v)).collect());
    vec![
        Column { name: "label".into(), values: Values::Text(network.vessels().map(|(_, v)| v.label.clone()).collect()) },
        Column { name: "length_mm".into(), values: of(|v| v.length * 1e3) },
        Column { name: "likelihood".into(), values: Values::Real(vec![0.0, f64::NAN, 1e-300, f64::INFINITY]) },
        Column { name: "edge".into(), values: Values::Integer((0..4).collect()) },
        Column { name: "large".into(), values: Values::Integer(vec![1 << 40, 0, -5, 2]) },
    ]
}

/// What makes a vessel the same one: its ends, label and points.
fn vessels(network: &Network) -> Vec<String> {
    let at = |n: usize| format!("{:?} {:?}", network.node(n).position, network.node(n).radius);
    let row = |([a, b], v): ([usize; 2], &Vessel)| {
        let path: Vec<_> = v.path.iter().map(|p| (p.position, p.radius)).collect();
        format!("{} {} {:?} {path:?}", at(a), at(b), v.label)
    };
    let mut rows: Vec<String> = network.vessels().map(row).collect();
    rows.sort();
    rows
}

#[test]
fn what_is_written_comes_back_to_the_last_bit() {
    let network = network();
    let mut files = [Vec::new(), Vec::new()];
    write_vtk(&mut files[0], &network, &columns(&network)).unwrap();
    write_vtp(&mut files[1], &network, &columns(&network)).unwrap();
    for (n, file) in files.iter().enumerate() {
        let (mut lines, notes) =
            if n < 1 { read_vtk(file, &ReadOptions::default()) } else { read_vtp(file, &ReadOptions::default()) }.unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        lines.weld(1e-9);
        let again = contract(&lines, RadiusRule::Mean, None).unwrap().network;
        assert_eq!(again.node_count(), 4);
        assert_eq!(vessels(&again), vessels(&network), "file {n}");
    }
}

/// Two vessels that cross, cut apart: each has a junction of its own at the place of the crossing. What willis writes says so. A contact between
/// the two, which has no length as a line, makes them one.
#[test]
fn vessels_that_were_cut_apart_stay_apart() {
    let mut network = Network::new();
    for (id, at) in
        [[0.0; 3], [0.0; 3], [-9.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, -8.0, 0.0], [0.0, 8.0, 0.0]].into_iter().enumerate()
    {
        network.add_node(Node {
            id: id.to_string(),
            position: Some(at.map(metres)),
            radius: Some(metres(0.5)),
            ..Node::default()
        });
    }
    for ends in [[0, 2], [3, 0], [1, 4], [5, 1]] {
        let path = ends.map(|node| PathPoint { position: network.node(node).position.unwrap(), radius: metres(0.5), id: None });
        network.add_vessel(ends, Vessel::along(path.to_vec(), RadiusRule::Mean));
    }
    let mut joined = network.clone();
    joined.add_vessel([0, 1], Vessel::new(metres(0.025), metres(0.5), Origin::Contact));
    let [apart, one] = [&network, &joined].map(|network| graph_columns(network).1);
    let folder = tempfile::tempdir().unwrap();
    let cases = [(&network, &apart[..], (2, 2)), (&network, &[][..], (1, 4)), (&joined, &one[..], (1, 4))];
    for (network, columns, found) in cases {
        let names = if columns.is_empty() { &["a.vtk", "a.vtp"][..] } else { &["a.vtk", "a.vtp", "a.swc"] };
        for name in names {
            let (path, mut bytes) = (folder.path().join(name), Vec::new());
            match *name {
                "a.vtk" => write_vtk(&mut bytes, network, columns).unwrap(),
                "a.vtp" => write_vtp(&mut bytes, network, columns).unwrap(),
                _ => assert_eq!(write_swc(&mut bytes, network).unwrap(), [[0; 2]; 0]),
            }
            std::fs::write(&path, bytes).unwrap();
            let read = willis::read(&path, &ReadOptions::default()).unwrap().network;
            assert_eq!((fragments(&read, |_, _| true).count, read.vessel_count()), found, "{name}");
        }
    }
}

#[test]
fn vtk_reads_what_is_written() {
    let network = network();
    let folder = tempfile::tempdir().unwrap();
    write_vtk(std::fs::File::create(folder.path().join("a.vtk")).unwrap(), &network, &columns(&network)).unwrap();
    write_vtp(std::fs::File::create(folder.path().join("c.vtp")).unwrap(), &network, &columns(&network)).unwrap();
    write_vtk(std::fs::File::create(folder.path().join("d.vtk")).unwrap(), &network, &[]).unwrap();
    let script = r#"
import sys, vtk, math
for name in ("a.vtk", "c.vtp", "d.vtk"):
    r = vtk.vtkPolyDataReader() if name.endswith("k") else vtk.vtkXMLPolyDataReader()
    r.SetFileName(sys.argv[1] + "/" + name); r.Update(); p = r.GetOutput(); c = p.GetCellData()
    assert (p.GetNumberOfPoints(), p.GetNumberOfLines(), p.GetNumberOfCells()) == (10, 4, 4), name
    assert p.GetPoints().GetDataType() == vtk.VTK_DOUBLE and p.GetPoint(2) == (1 / 3, 0.7, 1e-7), p.GetPoint(2)
    radius = p.GetPointData().GetArray("MaximumInscribedSphereRadius")
    assert radius.GetValue(3) == 0.1 + 3 / 7, radius.GetValue(3)
    ring = p.GetCell(3).GetPointIds()
    assert [ring.GetId(i) for i in range(ring.GetNumberOfIds())] == [2, 7, 8, 9, 2]
    if name == "d.vtk": continue
    label = c.GetAbstractArray("label")
    assert [label.GetValue(i) for i in range(4)] == ['L <M1> & "é" %', "", "BA", "ring"], name
    number = lambda a: [c.GetArray(a).GetTuple1(i) for i in range(4)]
    a, b, d, e = number("likelihood")
    assert a == 0 and math.isnan(b) and d == 1e-300 and e == math.inf, number("likelihood")
    assert number("edge") == [0, 1, 2, 3] and number("large") == [2.0 ** 40, 0, -5, 2]
print("read")
"#;
    if let Some(said) = python(script, &[folder.path()]) {
        assert_eq!(said, "read");
    }
}

/// One geometry with texts, blanks in names, a vertex cell and arrays of every type, in every encoding that VTK has.
const WRITE: &str = r#"
import sys, vtk
p = vtk.vtkPolyData(); points = vtk.vtkPoints(); points.SetDataTypeToDouble()
for i in range(5): points.InsertNextPoint(i, 0.1 * i * i, 1 / 3)
p.SetPoints(points); lines, verts, faces = vtk.vtkCellArray(), vtk.vtkCellArray(), vtk.vtkCellArray()
for cell in ([0, 1, 2], [2, 3], [2, 4]): lines.InsertNextCell(len(cell), cell)
verts.InsertNextCell(1, [3]); faces.InsertNextCell(3, [0, 1, 2])
p.SetVerts(verts); p.SetLines(lines); p.SetPolys(faces)
def add(data, kind, name, values):
    a = kind(); a.SetName(name); [a.InsertNextValue(v) for v in values]; data.AddArray(a); return a
for n, kind in enumerate((vtk.vtkBitArray, vtk.vtkIdTypeArray, vtk.vtkLongLongArray, vtk.vtkUnsignedCharArray, vtk.vtkShortArray, vtk.vtkUnsignedLongArray)):
    add(p.GetPointData(), kind, f"other {n}", [i % 2 for i in range(5)]); add(p.GetCellData(), kind, f"other {n}", [1] * 5)
v = add(p.GetPointData(), vtk.vtkFloatArray, "v", range(15)); v.SetNumberOfComponents(3); p.GetPointData().SetNormals(v)
add(p.GetPointData(), vtk.vtkStringArray, "words", ["a b", "", "%", "é\n", '"'])
p.GetPointData().SetScalars(add(p.GetPointData(), vtk.vtkDoubleArray, "Radius", [1, 2, float("nan"), 0.1, 5]))
add(p.GetCellData(), vtk.vtkStringArray, "Vessel Name", ["vertex", 'L <M1> & é "q" %20', "", "x" * 70, "face"])
add(p.GetFieldData(), vtk.vtkStringArray, "LINES 3 4", ["CELL_DATA 3\nPOINTS"])
n = 0
for version in (42, 51):
    for binary in (0, 1):
        w = vtk.vtkPolyDataWriter(); w.SetInputData(p); w.SetFileName(f"{sys.argv[1]}/{n}.vtk"); w.SetFileVersion(version)
        (w.SetFileTypeToASCII, w.SetFileTypeToBinary)[binary](); assert w.Write() == 1; n += 1
for mode in range(3):
    for zlib in (0, 1):
        w = vtk.vtkXMLPolyDataWriter(); w.SetInputData(p); w.SetFileName(f"{sys.argv[1]}/{n}.vtp")
        (w.SetDataModeToAscii, w.SetDataModeToBinary, w.SetDataModeToAppended)[mode]()
        w.SetCompressorTypeToZLib() if zlib else w.SetCompressorTypeToNone()
        assert w.Write() == 1; n += 1
print(n)
"#;

#[test]
fn what_vtk_writes_is_read_in_every_encoding() {
    let folder = tempfile::tempdir().unwrap();
    let Some(count) = python(WRITE, &[folder.path()]) else { return };
    assert_eq!(count, "10");
    for n in 0..10 {
        let path = folder.path().join(format!("{n}.{}", if n < 4 { "vtk" } else { "vtp" }));
        let document = read(&path, &ReadOptions::default()).unwrap();
        let Content::Centerlines(lines) = document.content else { panic!() };
        assert_eq!(lines.links, [[0, 1], [1, 2], [2, 3], [2, 4]], "{n}");
        let first = "L <M1> & é \"q\" %20";
        assert_eq!(names(&lines), [first, first, "", &"x".repeat(70)], "{n}");
        assert!(lines.radii[2].is_nan());
        assert_eq!([0, 1, 3, 4].map(|p| lines.radii[p]), [1.0, 2.0, 0.1, 5.0].map(metres), "{n}");
        // In digits VTK keeps six of them.
        let place = metres(0.1 * 9.0);
        assert!((lines.points[3][1] - place).abs() < 1e-6 * place);
        assert!(n % 2 == 0 || n > 3 || lines.points[3][1] == metres(0.1 * 3.0 * 3.0));
        assert_eq!(document.notes, ["1 vertex cells are ignored", "1 polygons are ignored"]);
        // Cut anywhere it is an answer or one line.
        let bytes = std::fs::read(&path).unwrap();
        for end in 0..bytes.len() {
            let cut = &bytes[..end];
            let found = if n < 4 { read_vtk(cut, &ReadOptions::default()) } else { read_vtp(cut, &ReadOptions::default()) };
            if let Err(fault) = found {
                assert!(!fault.in_file(Path::new("v")).to_string().contains('\n'));
            }
        }
    }
}

/// Two lines that share a point, as the specification has them in binary: big-endian numbers, texts after their lengths.
fn binary() -> Vec<u8> {
    let reals = |values: &[f64]| values.iter().flat_map(|x| x.to_be_bytes()).collect::<Vec<u8>>();
    let wholes = |values: &[i32]| values.iter().flat_map(|x| x.to_be_bytes()).collect::<Vec<u8>>();
    let long = "x".repeat(70);
    [
        b"# vtk DataFile Version 4.2\nby hand\nBINARY\nDATASET POLYDATA\nPOINTS 4 double\n".to_vec(),
        reals(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 3.0, 0.0]),
        b"\nLINES 2 7\n".to_vec(),
        wholes(&[3, 0, 1, 2, 2, 1, 3]),
        b"\nCELL_DATA 2\nFIELD FieldData 2\nlabel 1 2 string\n\xc2BA\x80\x46".to_vec(),
        long.into_bytes(),
        b"\nrow 1 2 int\n".to_vec(),
        wholes(&[0, 1]),
        b"\nPOINT_DATA 4\nFIELD FieldData 1\nMaximumInscribedSphereRadius 1 4 double\n".to_vec(),
        reals(&[0.5, 0.6, 0.7, 0.8]),
        b"\n".to_vec(),
    ]
    .concat()
}

#[test]
fn a_binary_file_is_read() {
    let (lines, notes) = read_vtk(&binary(), &ReadOptions::default()).unwrap();
    assert_eq!((lines.points.len(), lines.links.len(), notes.len()), (4, 3, 0), "{notes:?}");
    assert_eq!(lines.radii, [0.5, 0.6, 0.7, 0.8].map(metres));
    assert_eq!(lines.points[3], [1.0, 3.0, 0.0].map(metres));
    let labels: Vec<&str> = (0..3).map(|link| lines.labels.of(link)).collect();
    assert_eq!(labels, ["BA", "BA", &"x".repeat(70)]);
}

#[test]
fn a_file_cut_or_spoiled_anywhere_never_panics() {
    let network = network();
    let mut files = vec![OLD.as_bytes().to_vec(), binary(), Vec::new()];
    write_vtk(&mut files[2], &network, &columns(&network)).unwrap();
    for file in &files {
        for at in 0..file.len() {
            let mut spoiled = file.clone();
            for byte in [0xff, b'9', b'-', b' ', b'\n'] {
                spoiled[at] = byte;
                drop(read_vtk(&spoiled, &ReadOptions::default()));
            }
            if let Err(fault) = read_vtk(&file[..at], &ReadOptions::default()) {
                assert!(!fault.in_file(Path::new("v")).to_string().contains('\n'));
            }
        }
    }
}
