//! Landmarks as people set them: by the files of 3D Slicer that its documentation shows, names that the field uses, and frames turned by
//! hand.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use willis::error::Place;
use willis::internals::circle_of_willis::Artery::{A1, A2, AComm, Ba, Ica, M1, P1, P2, PComm, ThirdA2, Va};
use willis::internals::circle_of_willis::BodySide::{Left as L, Right as R};
use willis::internals::circle_of_willis::{Artery, identify_landmarks};
use willis::internals::formats::{LandmarkFormat, ListedLandmark, MarkedPoint, read_landmarks, write_landmarks};
use willis::internals::network::Frame;
use willis::internals::network::units::{Scale, metres};

use crate::command::{folder, stderr, willis};

/// As Slicer 5.6 writes a point list, with a point that is not set and another markup, in RAS.
const MARKUPS: &str = r#"{
    "@schema": "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#",
    "markups": [
        {
            "type": "Line", "coordinateSystem": "LPS", "controlPoints": [ { "id": "1", "label": "L-1", "position": [0, 0, 0] } ]
        },
        {
            "type": "Fiducial",
            "coordinateSystem": "RAS",
            "coordinateUnits": "mm",
            "locked": false,
            "fixedNumberOfControlPoints": false,
            "labelFormat": "%N-%d",
            "lastUsedControlPointNumber": 3,
            "controlPoints": [
                { "id": "1", "label": "left ICA", "description": "", "associatedNodeID": "", "position": [-20.5, 1.25, -60.0],
                  "orientation": [-1.0, -0.0, -0.0, -0.0, -1.0, -0.0, 0.0, 0.0, 1.0], "selected": true, "locked": false,
                  "visibility": true, "positionStatus": "defined" },
                { "id": "2", "label": "R M1", "position": [0.0, 0.0, 0.0], "positionStatus": "undefined" },
                { "id": "3", "label": "ICA-T L", "position": [-10.0, 6.0, 0.0], "positionStatus": "defined" }
            ],
            "measurements": [],
            "display": { "visibility": false, "opacity": 1.0 }
        }
    ]
}"#;

fn read(text: &str) -> Result<(Vec<ListedLandmark>, Frame, Vec<String>), String> {
    let list = read_landmarks(text.as_bytes(), &Scale::default());
    list.map(|list| (list.landmarks, list.frame, list.notes)).map_err(|fault| fault.in_file(Path::new("m")).to_string())
}

fn at(landmark: &ListedLandmark) -> (&str, [f64; 3]) {
    (&landmark.label, landmark.position.map(|x| (x * 1e3 * 1e6).round() / 1e6))
}

#[test]
fn point_lists_of_slicer_are_read_in_their_frame() {
    let (landmarks, frame, notes) = read(MARKUPS).expect("landmarks");
    assert_eq!(frame, Frame::Ras);
    let found: Vec<_> = landmarks.iter().map(at).collect();
    assert_eq!(found, [("left ICA", [-20.5, 1.25, -60.0]), ("ICA-T L", [-10.0, 6.0, 0.0])]);
    assert_eq!(landmarks[1].place, Place::Item("control point 2".into()));
    assert_eq!(notes, ["landmarks without a defined position, left out: 1"]);
    let (lps, frame, _) = read(&MARKUPS.replace("\"RAS\"", "\"LPS\"")).expect("landmarks");
    assert_eq!((at(&lps[0]).1, frame), ([-20.5, 1.25, -60.0], Frame::Lps));
    // Without a word on it the schema means LPS; micrometres are its other unit.
    let bare = MARKUPS.replace("\"coordinateSystem\": \"RAS\",", "").replace("\"mm\"", "[\"um\", \"UCUM\", \"micrometer\"]");
    assert_eq!(at(&read(&bare).expect("landmarks").0[0]).1, [-0.0205, 0.00125, -0.06]);
}

/// The example of Slicer's documentation, with its other spellings of the frame, the columns of version 5 that have no name, commas
/// within quotes, and the order of columns of Slicer 3.
#[test]
fn fcsv_is_read_by_its_comments() {
    let head = |system: &str| {
        format!(
            "# Markups fiducial file version = 4.13\n# CoordinateSystem = {system}\n\
             # columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
        )
    };
    let rows = "0,-19.9,13.5,29.25,0,0,0,1,1,1,0,L-ICA,,\n1,-7.5,-76,17.5,0,0,0,1,1,1,0,\"A1, A2 left\",a remark,\n";
    for (system, frame) in [("LPS", Frame::Lps), ("1", Frame::Lps), ("RAS", Frame::Ras), ("0", Frame::Ras)] {
        let (landmarks, found, notes) = read(&(head(system) + rows)).expect("landmarks");
        assert_eq!((found, notes.len()), (frame, 0));
        let found: Vec<_> = landmarks.iter().map(at).collect();
        assert_eq!(found, [("L-ICA", [-19.9, 13.5, 29.25]), ("A1, A2 left", [-7.5, -76.0, 17.5])]);
        assert_eq!([&landmarks[0].place, &landmarks[1].place], [&Place::Line(4), &Place::Line(5)]);
    }
    let five = head("LPS") + "1,1,2,3,0,0,0,1,1,1,0,BA,,,2,0\n2,0,0,0,0,0,0,1,1,1,0,L-M1,,,0,0\n";
    let (landmarks, _, notes) = read(&five).expect("landmarks");
    assert_eq!((landmarks.len(), notes.len()), (1, 1));
    let three = "# Fiducial List file /tmp/F.fcsv\r\n# columns = label,x,y,z,sel,vis\r\nBA,1,2,3,1,1\r\n";
    let (landmarks, frame, _) = read(three).expect("landmarks");
    assert_eq!((at(&landmarks[0]), frame), (("BA", [1.0, 2.0, 3.0]), Frame::Ras));
    // As Windows saves text, the names of the columns in the first line, in the second, or not at all.
    let names = "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n";
    let [first, second] = [format!("{names}# version 4.13\n"), format!("# version 4.13\n{names}")];
    for comments in [first.as_str(), second.as_str(), "# Markups fiducial file version = 4.13\n# version\n"] {
        let (landmarks, ..) = read(&format!("\u{feff}{comments}1,1,2,3,0,0,0,1,1,1,0,BA,,\n")).expect("landmarks");
        assert_eq!((at(&landmarks[0]), &landmarks[0].place), (("BA", [1.0, 2.0, 3.0]), &Place::Line(3)), "{comments}");
    }
    // Slicer's own table of control points.
    let table = "label,l,p,s,defined,selected,visible,locked,description\nBA,1,2,3,1,1,1,0,\nL-M1,0,0,0,0,1,1,0,\n";
    let (landmarks, frame, notes) = read(table).expect("landmarks");
    assert_eq!((at(&landmarks[0]), landmarks.len(), frame, notes.len()), (("BA", [1.0, 2.0, 3.0]), 1, Frame::Lps, 1));
}

/// A landmark that nobody has confirmed is not selected in 3D Slicer, and does not count, however Slicer saves its list: as markups, as
/// `.fcsv` or as a table.
#[test]
fn landmarks_that_are_not_selected_do_not_count_in_any_format_of_slicer() {
    let fcsv = "# Markups fiducial file version = 4.13\n# CoordinateSystem = LPS\n\
                # columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n\
                1,1,2,3,0,0,0,1,1,1,0,BA,,,2,0\n2,4,5,6,0,0,0,1,1,0,0,L-P1,,,2,0\n";
    let table = "label,l,p,s,defined,selected,visible,locked,description\nBA,1,2,3,1,1,1,0,\nL-P1,4,5,6,1,0,1,0,\n";
    let point = |label: &str, position: [f64; 3], probability: f64| MarkedPoint {
        probability: Some(probability),
        ..MarkedPoint::new(label, position.map(metres))
    };
    let points = [point("BA", [1.0, 2.0, 3.0], 0.75), point("L-P1", [4.0, 5.0, 6.0], 0.25)];
    let written = [LandmarkFormat::Csv, LandmarkFormat::Markups, LandmarkFormat::Fcsv].map(|format| {
        let mut bytes = Vec::new();
        write_landmarks(&mut bytes, format, Frame::Lps, &points).expect("written");
        String::from_utf8(bytes).expect("text")
    });
    for text in [fcsv, table].into_iter().chain(written.iter().map(String::as_str)) {
        let (landmarks, _, notes) = read(text).expect("landmarks");
        assert_eq!(landmarks.iter().map(at).collect::<Vec<_>>(), [("BA", [1.0, 2.0, 3.0])], "{text}");
        assert_eq!(notes, ["doubtful landmarks that nobody has confirmed, left out: 1"], "{text}");
    }
}

#[test]
fn damaged_point_lists_are_refused_with_their_place() {
    let head = "# Markups fiducial file version = 4.13\n# CoordinateSystem = LPS\n# columns = id,x,y,z,label\n";
    for (text, message) in [
        (
            MARKUPS.replace("\"Fiducial\"", "\"Curve\""),
            "m: markups of type Line, Curve; expected a point list (markups of type Fiducial)",
        ),
        (MARKUPS.replace("\"RAS\"", "\"IJK\""), "m: markup 1 \"\": coordinateSystem IJK; expected LPS or RAS"),
        (
            MARKUPS.replace("[-10.0, 6.0, 0.0]", "[-10.0, null, 0.0]"),
            "m: control point 2: no position; expected three finite numbers",
        ),
        (
            "{\"markups\": [{\"type\": \"Fiducial\"}]}".into(),
            "m: no landmark; expected a row or a control point for every landmark",
        ),
        (head.replace("LPS", "IJK") + "1,1,2,3,BA\n", "m:2: CoordinateSystem IJK; expected LPS, RAS, 0 or 1"),
        (head.to_owned() + "1,1,2,3,BA\n2,1,x,3,L-M1\n", "m:5: y \"x\"; expected a number"),
        (head.replace(",label", ""), "m:3: columns id,x,y,z; expected an .fcsv file of 3D Slicer: a column label"),
        (head.to_owned(), "m: no landmark; expected a row or a control point for every landmark"),
    ] {
        assert_eq!(read(&text).expect_err("refused"), message);
    }
}

/// What is written comes back, from every format; the files of Slicer are in LPS whatever the network is in.
#[test]
fn landmarks_make_a_round_trip() {
    let points = vec![
        MarkedPoint { probability: Some(0.875), ..MarkedPoint::new("L-ICA/L-M1/L-A1", [-10.125, 6.5, 0.0].map(metres)) },
        MarkedPoint {
            description: "a \"remark\", with a comma".into(),
            ..MarkedPoint::new("BA", [0.1 + 0.2, -1e-7, 1e3 / 3.0].map(metres))
        },
    ];
    for format in [LandmarkFormat::Csv, LandmarkFormat::Markups, LandmarkFormat::Fcsv] {
        for frame in [Frame::Ras, Frame::Lps, Frame::Unknown] {
            let mut bytes = Vec::new();
            write_landmarks(&mut bytes, format, frame, &points).expect("written");
            let text = String::from_utf8(bytes).expect("text");
            let (landmarks, found, _) = read(&text).expect("landmarks");
            assert_eq!(found, if format == LandmarkFormat::Csv { Frame::Unknown } else { Frame::Lps });
            for (landmark, point) in landmarks.iter().zip(&points) {
                let back = found.turn(frame, landmark.position);
                let close = (0..3).all(|k| (back[k] - point.position[k]).abs() <= 1e-15);
                assert!(landmark.label == point.label && close, "{format:?} {frame:?}: {landmark:?}");
            }
            assert_eq!(landmarks.len(), points.len());
            let hints: [&str; 2] = match format {
                LandmarkFormat::Csv => ["label,x_mm,y_mm,z_mm,probability,description\n", ",0.875,"],
                _ => ["probability 0.875", "remark"],
            };
            assert!(hints.iter().all(|hint| text.contains(hint)), "{text}");
        }
    }
    // Required by the schema of markups 1.0.3, and its words: type, coordinateSystem, coordinateUnits, positionStatus.
    let mut bytes = Vec::new();
    write_landmarks(&mut bytes, LandmarkFormat::Markups, Frame::Ras, &points).expect("written");
    let json: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
    assert!(json["@schema"].as_str().expect("a URL").ends_with("markups-schema-v1.0.3.json#"));
    let markup = &json["markups"][0];
    assert_eq!([&markup["type"], &markup["coordinateSystem"], &markup["coordinateUnits"]], ["Fiducial", "LPS", "mm"]);
    let point = &markup["controlPoints"][0];
    assert_eq!([&point["id"], &point["label"], &point["positionStatus"]], ["1", "L-ICA/L-M1/L-A1", "defined"]);
    assert_eq!(point["position"], serde_json::json!([10.125, -6.5, 0]));
}

/// The spellings of TopCoW, iCafe, COSTA, papers and of people in a hurry.
#[test]
fn customary_names_are_understood() {
    let meaning = |label: &str| {
        let listed = ListedLandmark { place: Place::File, label: label.into(), position: [0.0; 3] };
        identify_landmarks(vec![listed]).map(|found| (found[0].arteries.clone(), found[0].meet)).map_err(|fault| fault.accepted)
    };
    let ends: [(Artery, &[&str]); 10] = [
        (
            Ica(L),
            &[
                "L-ICA",
                "left ICA",
                "ICA-L",
                "ICA_L",
                "lICA",
                "LICA",
                "ICA left",
                "Left internal carotid artery",
                "ICA (L)",
                "left ICA inlet",
                "L-ICA I",
                "leftInternalCarotidArtery",
                "left carotid",
            ],
        ),
        (M1(R), &["R-M1", "right M1", "MCA-M1 R", "M1_R", "rM1", "R M2", "R-M1 outlet"]),
        (A2(L), &["L-A2", "left A2", "A2 L", "L-ACA A2", "Left anterior cerebral artery A2", "L-A2 end"]),
        (P2(R), &["R-P2", "right P2", "P2-R", "PCA P2 right"]),
        (Ba, &["BA", "basilar", "Basilar artery", "BasilarArtery", "basilar inlet"]),
        (Va(L), &["L-VA", "left vertebral", "VA_L", "Vertebral artery (left)", "left V4 vertebral"]),
        (ThirdA2, &["3rd-A2", "third A2"]),
        (Artery::Aca(R), &["R-ACA", "right anterior cerebral artery"]),
        (Artery::Mca(R), &["R-MCA", "right middle cerebral artery"]),
        (Artery::Pca(L), &["L-PCA", "PCA left"]),
    ];
    for (artery, labels) in ends {
        for label in labels {
            assert_eq!(meaning(label), Ok((vec![artery], false)), "{label}");
        }
    }
    let forks: [(&[Artery], &[&str]); 10] = [
        (
            &[Ica(L), M1(L), A1(L)],
            &[
                "L-ICA/L-M1/L-A1",
                "ICA/M1/A1 L",
                "ICA-T L",
                "Left internal carotid artery terminus",
                "left ICA bifurcation",
                "L-ICA terminus",
                "ICA tip left",
                "carotid T left",
                "L-M1 origin",
                "A1 origin left",
            ],
        ),
        (&[A1(R), A2(R)], &["A1/A2 R", "R-A1/R-A2", "right A1-A2 junction", "A1-A2 R", "A1+A2 right", "A2 origin R"]),
        (&[A1(L), A2(L), AComm], &["L-A1/L-A2/AComm", "A1/A2/ACoA L", "left A1 & A2 & ACoA", "A1/A2/AcomA left"]),
        (&[M1(L)], &["M1-M2 bifurcation left", "L-M1/L-M2", "M1/M2 L", "left MCA bifurcation"]),
        (&[P1(R), P2(R)], &["P1/P2 R", "R-P1/R-P2", "P1-P2 junction right"]),
        (&[P1(R), P2(R), PComm(R)], &["R-P1/R-P2/R-PComm", "P1/P2/PCoA right", "P1/P2/PComA R"]),
        (
            &[P1(L), P1(R), Ba],
            &["BA tip", "basilar tip", "BA-T", "basilar apex", "BA/L-P1/R-P1", "basilar bifurcation", "BA/P1 L/P1 R"],
        ),
        (&[Ica(R), PComm(R)], &["R-ICA/R-PComm", "PComm origin right", "ICA/PcomA R", "PCOM/ICA R"]),
        (&[Ba, Va(L), Va(R)], &["L-VA/R-VA/BA", "VBJ", "vertebrobasilar junction", "BA origin"]),
        (&[A2(L), AComm], &["A2/AComm left"]),
    ];
    for (arteries, labels) in forks {
        let mut arteries = arteries.to_vec();
        arteries.sort_unstable();
        for label in labels {
            assert_eq!(meaning(label), Ok((arteries.clone(), true)), "{label}");
        }
    }
    for wrong in
        ["F-1", "", "left", "ophthalmic L", "AComm", "L-A1", "PComA L", "A1/A2", "left right ICA", "external carotid left", "tip"]
    {
        assert!(meaning(wrong).expect_err(wrong).contains("expected an inlet"), "{wrong}");
    }
    assert!(meaning("L-ICA/L-MM1").expect_err("a hint").contains("did you mean \"L-M1\"?"));
}

/// A carotid with M1 and A1 to A2, and beside it an M1 that ends 8 mm before its landmark: x to the right, y forward.
fn circle(frame: &str, flip: f64) -> String {
    let mut swc = frame.to_owned();
    let mut id = 0;
    let mut add = |[x, y, z]: [f64; 3], parent: usize| {
        id += 1;
        let parent = if parent == 0 { "-1".to_owned() } else { parent.to_string() };
        writeln!(swc, "{id} 0 {} {} {z} 1 {parent}", flip * x, flip * y).expect("written");
        id
    };
    let mut line = |from: usize, a: [f64; 3], b: [f64; 3]| {
        let mut last = from;
        for step in usize::from(from > 0)..=20 {
            last = add([0, 1, 2].map(|k| a[k] + step as f64 / 20.0 * (b[k] - a[k])), last);
        }
        last
    };
    let (inlet, fork, middle, a2) = ([-20.0, 0.0, -60.0], [-10.0, 6.0, 0.0], [-60.0, 6.0, 10.0], [-4.0, 40.0, 40.0]);
    let top = line(0, inlet, fork);
    line(top, fork, middle);
    line(top, fork, a2);
    swc
}

fn fiducials(system: &str, points: &[(&str, [f64; 3])]) -> String {
    let points: Vec<_> = points.iter().map(|(label, at)| serde_json::json!({ "label": label, "position": at })).collect();
    serde_json::json!({ "markups": [{ "type": "Fiducial", "coordinateSystem": system, "controlPoints": points }] }).to_string()
}

const RAS: [(&str, [f64; 3]); 3] =
    [("left ICA", [-20.0, 0.0, -61.0]), ("M1 left", [-61.0, 6.0, 10.0]), ("A2 L", [-4.0, 41.0, 40.0])];

/// Whatever the frames of the two files, the landmarks lie where they were set: turned where both files say so, and by the distance to
/// the vessels where only the landmarks do.
#[test]
fn landmarks_are_turned_to_the_frame_of_the_input() {
    let here = folder();
    let turned = RAS.map(|(label, [x, y, z])| (label, [-x, -y, z]));
    for (name, system, points) in [("ras", "RAS", RAS), ("lps", "LPS", turned)] {
        fs::write(here.path().join(format!("{name}.mrk.json")), fiducials(system, &points)).expect("written");
    }
    for (name, header, flip) in [("a", "# SPACE=RAS\n", 1.0), ("b", "# SPACE=LPS\n", -1.0), ("c", "", 1.0), ("d", "", -1.0)] {
        fs::write(here.path().join(format!("{name}.swc")), circle(header, flip)).expect("written");
        for system in ["ras", "lps"] {
            let (input, marks, out) = (format!("{name}.swc"), format!("{system}.mrk.json"), format!("{name}-{system}"));
            let output = willis(here.path(), &["classify", &input, "-o", &out, "--landmarks", &marks]);
            let said = stderr(&output);
            assert_eq!(output.status.code(), Some(0), "{said}");
            assert!(said.contains("M1 left at node 41, 1.000 mm away"), "{said}");
            let frame = if flip > 0.0 { "RAS" } else { "LPS" };
            if header.is_empty() {
                let told =
                    format!("the input states no frame: it is taken as {frame}, in which they lie 1.0 mm from the vessels");
                assert!(said.contains(&told), "{said}");
            } else {
                let is_turned = said.contains(&format!("to {frame}, the frame of the input"));
                assert_eq!(is_turned, system != frame.to_lowercase(), "{said}");
            }
        }
    }
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).expect("a file")).expect("JSON")
}

/// The outlets that landmarks name are stated, with the resistance that they would have been found with: without these landmarks the
/// numbers are the same, but they are found.
#[test]
fn landmarks_of_outlets_state_them() {
    let here = folder();
    fs::write(here.path().join("a.swc"), circle("", 1.0)).expect("written");
    fs::write(here.path().join("inlet.json"), fiducials("RAS", &RAS[..1])).expect("written");
    fs::write(here.path().join("one.json"), fiducials("RAS", &RAS[..2])).expect("written");
    let conditions = |name: &str, more: &[&str]| {
        let marks = format!("{name}.json");
        let out = format!("{name}{}", more.len());
        let output = willis(here.path(), &[&["infer", "a.swc", "-o", &out, "--landmarks", &marks, "-n", "64"], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let record = json(&here.path().join(out).join("run.json"));
        let list = record["boundary_conditions"].as_array().expect("a list").clone();
        list.into_iter().map(|mut condition| (condition["found"].take(), condition)).collect::<Vec<_>>()
    };
    for more in [&[][..], &["--outlets", "ground"]] {
        let (found, stated) = (conditions("inlet", more), conditions("one", more));
        let flags =
            |list: &[(serde_json::Value, serde_json::Value)]| list.iter().map(|(found, _)| found == true).collect::<Vec<_>>();
        assert_eq!((flags(&found), flags(&stated)), (vec![false, true, true], vec![false, false, true]));
        let same = found.iter().zip(&stated).all(|(a, b)| a.1 == b.1);
        assert!(same, "{found:?} {stated:?}");
    }
}

/// What a landmark that is far from any end is taken for is said.
#[test]
fn landmarks_far_from_any_end_are_told() {
    let here = folder();
    fs::write(here.path().join("a.swc"), circle("", 1.0)).expect("written");
    let said = |label: &str, at: [f64; 3], out: &str| {
        fs::write(here.path().join("l.json"), fiducials("RAS", &[RAS[0], (label, at)])).expect("written");
        let output = willis(here.path(), &["infer", "a.swc", "-o", out, "--landmarks", "l.json", "-n", "64"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let record = json(&here.path().join(out).join("run.json"));
        let found = record["boundary_conditions"].as_array().expect("a list").iter().filter(|c| c["found"] == true).count();
        (stderr(&output), found)
    };
    // On M1, 8 mm before its end.
    let (told, found) = said("L-M1", [-52.2, 6.0, 8.4], "on");
    assert!(
        told.contains("L-M1 names an outlet, but the nearest free end, node 41, is 8.0 mm away: the vessel is taken to run on"),
        "{told}"
    );
    assert_eq!(found, 2);
    // Beyond its end.
    let (told, found) = said("L-M1", [-70.0, 6.0, 10.0], "beyond");
    assert!(told.contains("is 10.0 mm away: it is taken for that end, and what lies between is not seen"), "{told}");
    assert_eq!(found, 1);
    // At the junction.
    let (told, found) = said("L-M1", [-10.0, 6.0, 0.5], "junction");
    assert!(
        told.contains("L-M1 names an outlet, but the vessel runs on at node 21, which is no free end: no outlet is stated there"),
        "{told}"
    );
    assert_eq!(found, 2);
    // Of several subjects it is one note, without its figures and with every word of it.
    let renumbered = |line: &str| match line.split(' ').collect::<Vec<_>>()[..] {
        [id, kind, x, y, z, radius, parent] if !line.starts_with('#') => {
            let other = |id: &str| id.parse::<i32>().map_or(-1, |id| if id > 0 { id + 100 } else { id });
            format!("{} {kind} {x} {y} {z} {radius} {}\n", other(id), other(parent))
        }
        _ => format!("{line}\n"),
    };
    fs::write(here.path().join("b.swc"), circle("", 1.0).lines().map(renumbered).collect::<String>()).expect("written");
    let output = willis(here.path(), &["infer", "a.swc", "b.swc", "-o", "both", "--landmarks", "l.json", "-n", "64"]);
    let told = stderr(&output);
    assert!(told.contains("but the vessel runs on at node …, which is no free end") && told.contains("(2 subjects)"), "{told}");
}

/// The folder of a run answers from anywhere, without the file of landmarks; an edited copy is refused.
#[test]
fn a_run_keeps_its_landmarks() {
    let here = folder();
    fs::write(here.path().join("a.swc"), circle("", 1.0)).expect("written");
    fs::write(here.path().join("l.mrk.json"), fiducials("RAS", &RAS)).expect("written");
    let output = willis(here.path(), &["infer", "a.swc", "-o", "run", "--landmarks", "l.mrk.json", "-n", "64"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let there = here.path().join("elsewhere");
    fs::create_dir(&there).expect("a folder");
    fs::rename(here.path().join("run"), there.join("moved")).expect("moved");
    for file in ["a.swc", "l.mrk.json"] {
        fs::remove_file(here.path().join(file)).expect("removed");
    }
    let output = willis(&there, &["classify", "moved", "-o", "again"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(json(&there.join("again/phenotype.json")), json(&there.join("moved/phenotype.json")));
    let copy = there.join("moved/landmarks.mrk.json");
    let text = fs::read_to_string(&copy).expect("a copy").replace("-61.0", "-59.0");
    fs::write(&copy, text).expect("written");
    let output = willis(&there, &["classify", "moved", "-o", "edited"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("not the landmarks that the run was made with"), "{}", stderr(&output));
}

/// The 26 patients, whose vessels iCafe's table names: `--labels icafe` answers as names do, and P1 and P2 of one patient, whose left and
/// right the table has exchanged, are told, and of no other.
#[test]
fn the_patients_of_icafe_are_classified_by_either_word() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/insist-cow");
    if !data.is_dir() {
        println!("skipped: {} is not there", data.display());
        return;
    }
    let here = folder();
    let pattern = data.join("*/tracing*.swc").display().to_string();
    for scheme in ["names", "icafe"] {
        let arguments = ["classify", &pattern, "-o", scheme, "--labels", scheme, "--units", "voxel", "--spacing", "auto"];
        let output = willis(here.path(), &arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    }
    let mut told = Vec::new();
    for entry in fs::read_dir(&data).expect("a folder").flatten().filter(|entry| entry.path().is_dir()) {
        let name = entry.file_name().to_string_lossy().into_owned();
        let file = |scheme: &str, file: &str| json(&here.path().join(scheme).join(&name).join(file));
        assert_eq!(file("names", "phenotype.json"), file("icafe", "phenotype.json"), "{name}");
        assert_eq!(file("icafe", "run.json")["parameters"]["arteries"], "icafe");
        let notes = file("names", "run.json")["notes"].to_string();
        if let Some(at) = notes.find(" lie on the other side than the carotids:") {
            told.push((name, notes[..at].rsplit('"').next().unwrap_or_default().to_owned()));
        }
    }
    assert_eq!(told, [("INSIST_0021".to_owned(), "L-P1, R-P1, L-P2, R-P2".to_owned())]);
}

/// A mirrored file that states no frame looks like any other: by its axes left would be right. A person's landmarks say which side is which, and
/// are followed: every segment has the probability that it has in the file that is not mirrored.
#[test]
fn landmarks_of_a_mirrored_file_say_which_side_is_which() {
    let here = folder();
    let run = |arguments: &[&str]| {
        let output = willis(here.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stderr(&output)
    };
    run(&["phantom", "cerebral", "--without", "L-P1", "--break", "--seed", "3", "--spacing", "1mm", "-o", "as-it-is.swc", "-q"]);
    let mirrored = |text: &str, at: usize, separator: char| -> String {
        let of = |line: &str| {
            let mut fields: Vec<String> = line.split(separator).map(str::to_owned).collect();
            if let Some(x) = fields.get(at).and_then(|field| field.parse::<f64>().ok()) {
                fields[at] = (-x).to_string();
            }
            fields.join(&separator.to_string())
        };
        text.lines().filter(|line| !line.starts_with("# SPACE")).map(|line| of(line) + "\n").collect()
    };
    for (file, at, separator) in [(".swc", 2, ' '), (".landmarks.csv", 1, ',')] {
        let text = fs::read_to_string(here.path().join(format!("as-it-is{file}"))).expect("a file");
        fs::write(here.path().join(format!("mirrored{file}")), mirrored(&text, at, separator)).expect("written");
    }
    let [straight, other] = ["as-it-is", "mirrored"].map(|name| {
        let said =
            run(&["infer", &format!("{name}.swc"), "--landmarks", &format!("{name}.landmarks.csv"), "-n", "256", "-o", name]);
        assert_eq!(said.contains("left and right are as the landmarks say"), name == "mirrored", "{said}");
        json(&here.path().join(name).join("phenotype.json"))
    });
    assert_eq!(other["variant"], straight["variant"]);
    assert_eq!(straight["segments"]["L-P1"], false);
    let segments = straight["probabilities"]["segments"].as_object().expect("segments");
    for (segment, p) in segments {
        let q = other["probabilities"]["segments"][segment].as_f64().expect("a probability");
        assert!((q - p.as_f64().expect("a probability")).abs() < 0.02, "{segment}: {p} and {q}");
    }
}

/// What landmarks name holds in the files of a run as it does in the run: its graph gives the same answer, and its folder says the same of supply.
#[test]
fn a_run_with_landmarks_is_read_again_as_it_was() {
    let here = folder();
    for words in [
        &["phantom", "cerebral", "--break", "--seed", "5", "-o", "a.swc"][..],
        &["infer", "a.swc", "--landmarks", "a.landmarks.csv", "-o", "run", "-n", "64"],
        &["infer", "run/candidates.graphml", "-o", "again", "-n", "64"],
        &["classify", "run", "-o", "classified"],
    ] {
        let output = willis(here.path(), words);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    }
    let file = |name: &str| fs::read_to_string(here.path().join(name)).expect("a table");
    assert!(file("run/nodes.csv").contains(",landmark\n"));
    assert_eq!(file("run/edges.csv"), file("again/edges.csv"));
    assert_eq!(file("run/supply.csv"), file("classified/supply.csv"));
}
