//! Slicer markups, CSV of points and labels of SWC: files typed by hand, one test for each kind of fault.

// Equal means equal to the last bit here.
#![allow(clippy::float_cmp)]

use std::path::Path;

use crate::peers::document;
use willis::internals::formats::{Format, ReadOptions, read_markups, read_points, read_swc};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::centerlines::pairs_within;
use willis::internals::network::units::{LengthUnit, Scale, metres, millimetres};
use willis::internals::network::{Network, RadiusRule, contract, cycles, fragments};
use willis::internals::support::geometry::{Point, distance};

fn mm() -> Scale {
    Scale::default()
}

fn markups(text: &str) -> Result<(Centerlines, Vec<String>), String> {
    read_markups(text.as_bytes(), &ReadOptions::default()).map_err(|f| f.in_file(Path::new("m")).to_string())
}

fn points(text: &str) -> Result<(Centerlines, Vec<String>), String> {
    read_points(text.as_bytes(), &ReadOptions::default()).map_err(|f| f.in_file(Path::new("p")).to_string())
}

fn network_of(mut lines: Centerlines) -> Network {
    lines.weld(1e-6);
    contract(&lines, RadiusRule::Mean, None).unwrap().network
}

/// Positions in mm and radii in mm.
fn in_mm(lines: &Centerlines) -> Vec<[f64; 4]> {
    lines.points.iter().zip(&lines.radii).map(|(p, r)| [p[0], p[1], p[2], *r].map(millimetres)).collect()
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

/// A curve that a person has created and not drawn has no points, and needs no radii.
#[test]
fn a_curve_without_points_does_not_stop_the_others() {
    let empty = r#"{"type": "Curve", "name": "C", "controlPoints": [], "measurements": [{"name": "length", "enabled": true}]}"#;
    let (lines, notes) = markups(&CURVES.replace("\"markups\": [", &format!("\"markups\": [{empty},"))).unwrap();
    let (others, expected) = markups(CURVES).unwrap();
    assert_eq!((in_mm(&lines).len(), lines.links, notes), (in_mm(&others).len(), others.links, expected));
}

/// The place of a point that is not set yet is none, and a curve that Slicer resampled keeps the radii of its old points.
#[test]
fn a_curve_that_is_being_drawn_or_was_resampled_has_a_way_on() {
    let text = r#"{"markups": [{"type": "Curve", "controlPoints": [{"position": [1,2,3]}, {"position": [1,2,5]},
        {"position": [9,9,9], "positionStatus": "preview"}, {"position": [8,8,8], "positionStatus": "missing"}],
        "measurements": [{"name": "Radius", "controlPointValues": [1, 2, 1, 2, 1]}]}]}"#;
    assert!(markups(text).is_err_and(|said| said.contains("5 values of Radius for 4 points") && said.contains("default_radius")));
    let options = ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() };
    let (lines, notes) = read_markups(text.as_bytes(), &options).expect("a curve");
    assert_eq!((lines.points.len(), lines.links.len()), (2, 1));
    assert_eq!(notes, ["control points without a defined position, left out: 2"]);
}

/// By hand: a radius of .1 cm on a curve in mm is 1 mm; without a unit of its own it is in that of the curve.
#[test]
fn the_radius_of_markups_has_the_unit_that_it_states() {
    let text = r#"{"markups": [{"type": "Curve", "controlPoints": [{"position": [1,2,3]}, {"position": [1,2,5]}],
        "measurements": [{"name": "Radius", "units": "cm", "controlPointValues": [0.1, 0.2]}]}]}"#;
    assert_eq!(markups(text).unwrap().0.radii, [1.0, 2.0].map(metres));
    assert_eq!(markups(&text.replace("cm", "")).unwrap().0.radii, [0.1, 0.2].map(metres));
    let said = markups(&text.replace("cm", "mm2")).unwrap_err();
    assert_eq!(said, "m: markup 0 \"\": units of Radius mm2; expected mm, um, cm or m");
}

/// Voxels beside millimetres: the second are what counts.
#[test]
fn points_in_millimetres_come_before_others() {
    let text = "fragment,x,y,z,radius,x_mm,y_mm,z_mm,radius_mm\n0,0,0,0,9,0,0,0,1\n0,20,0,0,9,10,0,0,2\n";
    let (lines, _) = read_points(text.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!((lines.points[1], &lines.radii[..]), ([10.0, 0.0, 0.0].map(metres), &[1.0, 2.0].map(metres)[..]));
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
            "m: markup 0 \"c\": no radius; expected a measurement Radius with a value for each control point, or give `default_radius`",
        ),
        (
            curve(&format!("{one}, \"measurements\": [{{\"name\": \"Radius\", \"controlPointValues\": [1, 2]}}]")),
            "m: markup 0 \"c\": 2 values of Radius for 1 points; expected one for each control point, or give `default_radius`",
        ),
        (curve(&format!("{one}, \"coordinateSystem\": \"IJK\"")), "m: markup 0 \"c\": coordinateSystem IJK; expected LPS or RAS"),
        (
            curve(&format!("{one}, \"coordinateUnits\": \"inch\"")),
            "m: markup 0 \"c\": coordinateUnits inch; expected mm, um, cm or m",
        ),
        (curve("\"controlPoints\": []"), "m: curves without points; expected control points"),
    ] {
        assert_eq!(markups(&text).unwrap_err(), message);
    }
    let bare = curve(one);
    let optional = ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() };
    assert!(read_markups(bare.as_bytes(), &optional).unwrap().0.radii[0].is_nan());
    let named = ReadOptions { radius_array: Some("thickness".into()), ..ReadOptions::default() };
    assert_eq!(
        read_markups(bare.as_bytes(), &named).unwrap_err().in_file(Path::new("m")).to_string(),
        "m: markup 0 \"c\": no measurement thickness at its control points; expected the one that `radius_array` names"
    );
    let wide: Vec<u8> = [0xfeff].into_iter().chain(CURVES.encode_utf16()).flat_map(u16::to_be_bytes).collect();
    assert_eq!(
        document("a.mrk.json", &wide).unwrap_err(),
        "a.mrk.json: the text is UTF-16; expected UTF-8; save the file as UTF-8"
    );
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
    let columns = "expected a header with columns fragment,x,y,z,radius (or x_mm and so on, in mm); label and id are optional";
    for (text, message) in [
        ("fragment,x,y,radius\n1,0,0,1\n".into(), format!("p:1: columns fragment,x,y,radius; {columns}")),
        ("fragment,x,y,z\n1,0,0,1\n".into(), "p:1: no column radius; expected one, or give `default_radius`".into()),
        ("fragment,x,y,z,x\n".into(), "p:1: column \"x\" comes twice; expected every column once".into()),
        (head.into(), "p: no points; expected a row for every point".into()),
        (format!("{head}1,0,0,zero,1\n"), "p:2: z \"zero\"; expected a number".into()),
        (format!("{head}1,0,NaN,0,1\n"), "p:2: y \"NaN\"; expected a finite number".into()),
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
    assert_eq!(document("a.csv", &wide).unwrap_err(), "a.csv: the text is UTF-16; expected UTF-8; save the file as UTF-8");
    assert_eq!(document("a.csv", b"fragment,x,y\n").unwrap_err(), format!("a.csv:1: columns fragment,x,y; {columns}"));
    assert!(
        read_points(
            "fragment,x,y,z\n1,0,0,0\n".as_bytes(),
            &ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() }
        )
        .unwrap()
        .0
        .radii[0]
            .is_nan()
    );
}

/// A column called `_mm` is in mm whatever the unit of the others, axis by axis.
#[test]
fn columns_in_mm_are_not_scaled_by_the_unit() {
    let voxels = Scale { unit: LengthUnit::Voxel, spacing: Some([0.5, 0.25, 2.0]) };
    let read = |text: &str| {
        let lines = read_points(text.as_bytes(), &ReadOptions { scale: voxels, ..ReadOptions::default() }).unwrap().0;
        (lines.points[1].map(millimetres), millimetres(lines.radii[1]))
    };
    assert_eq!(read("fragment,x_mm,y_mm,z_mm,radius_mm\n1,0,0,0,1\n1,2,4,8,1\n"), ([2.0, 4.0, 8.0], 1.0));
    assert_eq!(read("fragment,x,y,z,radius\n1,0,0,0,1\n1,2,4,8,1\n"), ([1.0, 1.0, 16.0], 0.25));
    assert_eq!(read("fragment,x,y,Z_MM,r_mm\n1,0,0,0,1\n1,2,4,8,1\n"), ([1.0, 1.0, 8.0], 1.0));
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

fn line(strands: &[&[Point]]) -> Centerlines {
    let mut c = Centerlines::default();
    for (s, points) in strands.iter().enumerate() {
        for (i, p) in points.iter().enumerate() {
            let row = c.add_point(*p, 1.0, c.points.len() as u64, s as u32);
            if i > 0 {
                c.add_link([row - 1, row], ["", "a", "b"][s]);
            }
        }
    }
    c
}

#[test]
fn polylines_that_share_coordinates_share_a_point() {
    let mut c = line(&[&[[0.0; 3], [1.0, 0.0, 0.0]], &[[1.0, 1e-8, 0.0], [2.0, 0.0, 0.0]]]);
    assert_eq!(c.weld(1e-6), 1);
    assert_eq!(c.links, [[0, 1], [1, 2]]);
    assert_eq!([c.labels.of(0), c.labels.of(1)], ["", "a"]);
}

/// The label of a stretch that is drawn twice is lost in no order.
#[test]
fn of_two_lines_on_each_other_the_one_with_a_label_gives_it() {
    let line: [Point; 2] = [[0.0; 3], [1.0, 0.0, 0.0]];
    for strands in [["", "a"], ["a", ""], ["a", "b"]] {
        let mut lines = Centerlines::default();
        for (strand, label) in (0..).zip(strands) {
            let ends = line.map(|point| lines.add_point(point, 1.0, lines.points.len() as u64, strand));
            lines.add_link(ends, label);
        }
        assert_eq!(lines.weld(1e-6), 2);
        assert_eq!((lines.links.len(), lines.labels.of(0)), (1, "a"), "{strands:?}");
    }
}

#[test]
fn a_line_that_touches_itself_midway_stays_open_and_a_closed_one_becomes_a_ring() {
    let touch = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
    assert_eq!(line(&[&touch]).weld(1e-6), 0);
    let ring = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0; 3]];
    let mut c = line(&[&ring]);
    assert_eq!(c.weld(1e-6), 1);
    assert_eq!(c.links.len(), 3);
}

/// A ring of 22 m: from 1 to 3 m by the side of 1 m, and back by 10, 1 and 10 m, wherever it begins.
#[test]
fn missing_radii_go_round_the_end_of_a_ring() {
    let ring = [([0.0; 3], f64::NAN), ([10.0, 0.0, 0.0], 1.0), ([10.0, 1.0, 0.0], 3.0), ([0.0, 1.0, 0.0], f64::NAN)];
    for begins in 0..4 {
        let mut lines = Centerlines::default();
        for at in (0..5).map(|step| (begins + step) % 4) {
            let point = lines.add_point(ring[at].0, ring[at].1, at as u64, 0);
            if point > 0 {
                lines.add_link([point - 1, point], "");
            }
        }
        let network = network_of(lines);
        let path = &network.vessel(0).path;
        assert_eq!(path.len(), 5);
        for point in path {
            let radius = [3.0 - 2.0 * 11.0 / 21.0, 1.0, 3.0, 3.0 - 2.0 * 10.0 / 21.0][point.id.expect("its number") as usize];
            assert!((point.radius - radius).abs() < 1e-12, "{begins}: {point:?} for {radius}");
        }
    }
}

#[test]
fn the_grid_finds_the_pairs_that_brute_force_finds() {
    let points: Vec<Point> =
        (0..300).map(|i| [f64::from(i * 37 % 101), f64::from(i * 53 % 97), f64::from(i * 71 % 89)].map(|x| x * 0.1)).collect();
    let mut expected = Vec::new();
    for b in 0..points.len() {
        expected.extend((0..b).filter(|a| distance(points[*a], points[b]) <= 1.3).map(|a| (a, b)));
    }
    assert!(expected.len() > 50);
    let pairs = |points: &[Point]| {
        let mut pairs = Vec::new();
        pairs_within(points, 1.3, &mut |a, b| pairs.push((a, b)));
        pairs.sort_by_key(|(a, b)| (*b, *a));
        pairs
    };
    assert_eq!(pairs(&points), expected);
    // The same far away, where coordinates are whole 1/64ths: a margin of the grid's cells.
    let far: Vec<Point> = points.iter().map(|p| p.map(|x| (x * 64.0).round() / 64.0 - 1e14)).collect();
    let mut expected = Vec::new();
    for b in 0..far.len() {
        expected.extend((0..b).filter(|a| distance(far[*a], far[b]) <= 1.3).map(|a| (a, b)));
    }
    assert!(expected.len() > 50);
    assert_eq!(pairs(&far), expected);
}
