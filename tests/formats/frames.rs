//! The frame of coordinates: a mask of a line away from the middle, written in every format and read back, gives the same positions in
//! the patient; by VTK, NetworkX and NumPy too.

use std::fs::{create_dir, write};
use std::path::Path;

use crate::peers::{FILES, converted, python};
use willis::internals::formats::convert::Target;
use willis::internals::formats::{ReadOptions, read};
use willis::internals::network::units::millimetres;
use willis::internals::network::{Frame, Network, RadiusRule};

/// A bar of 1 x 1 x 0.5 mm voxels whose first axis runs to the patient's left, by the matrix of ITK's LPS: the middles of its ends are
/// 12, 20, 30 and 22, 20, 30 in LPS, -12, -20, 30 and -22, -20, 30 in RAS.
fn bar() -> Vec<u8> {
    let head = "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 10 18 29\n\
                ElementSpacing = 1 1 0.5\nDimSize = 15 5 5\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
    let voxel = |n: usize| u8::from((2..13).contains(&(n % 15)) && n / 15 % 5 == 2 && n / 75 == 2);
    [head.as_bytes(), &(0..375).map(voxel).collect::<Vec<u8>>()].concat()
}

/// The middles of the last voxels of the bar in RAS, mm.
const ENDS: [[f64; 3]; 2] = [[-22.0, -20.0, 30.0], [-12.0, -20.0, 30.0]];

fn network(path: &Path) -> Network {
    let document = read(path, &ReadOptions::default()).expect("read");
    document.content.into_network(RadiusRule::Mean, None).expect("a network").network
}

fn put(network: &Network, word: &str, path: &Path) {
    for (path, bytes) in converted(network, &Target::new(path, Some(word)).expect("a target")) {
        write(path, bytes).expect("written");
    }
}

/// The positions of the nodes, mm, sorted, rounded to a nanometre.
fn ends(network: &Network) -> Vec<[f64; 3]> {
    let at = |x: f64| (millimetres(x) * 1e6).round() / 1e6;
    let mut ends: Vec<[f64; 3]> = network.nodes().map(|node| node.position.expect("a position").map(at)).collect();
    ends.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    ends
}

/// The formats that state a frame, and the one in which each is.
const STATED: [(&str, Frame); 7] = [
    ("swc", Frame::Ras),
    ("vtp", Frame::Ras),
    ("vtk", Frame::Ras),
    ("graphml", Frame::Ras),
    ("npz", Frame::Ras),
    ("markups", Frame::Lps),
    ("tre", Frame::Lps),
];

#[test]
fn a_mask_has_the_same_positions_in_the_patient_in_every_format() {
    let here = tempfile::tempdir().expect("a folder");
    let mask = here.path().join("m.mha");
    write(&mask, bar()).expect("written");
    let drawn = network(&mask);
    assert_eq!((drawn.frame, ends(&drawn)), (Frame::Ras, ENDS.to_vec()));
    for (word, file) in FILES {
        let folder = here.path().join(word);
        create_dir(&folder).expect("a folder");
        put(&drawn, word, &folder.join(file));
        let again = network(&folder.join(file));
        let stated = STATED.iter().find(|(known, _)| *known == word).map_or(Frame::Unknown, |(_, frame)| *frame);
        assert_eq!(again.frame, stated, "{word}");
        let patient = again.in_frame(Frame::Ras);
        assert_eq!(ends(&patient), ENDS.to_vec(), "{word}");
        // From there into each format that states its frame, and back.
        for (other, name) in FILES.iter().filter(|(other, _)| stated.is_known() && STATED.iter().any(|(word, _)| word == other)) {
            let path = folder.join(format!("again-{name}"));
            put(&again, other, &path);
            let twice = network(&path);
            assert!(twice.frame.is_known() && ends(&twice.in_frame(Frame::Ras)) == ENDS, "{word} to {other}");
        }
    }
    // Nothing is turned where the frame is not known.
    let mut unknown = drawn.clone();
    unknown.frame = Frame::Unknown;
    let path = here.path().join("unknown.mrk.json");
    put(&unknown, "markups", &path);
    assert_eq!(ends(&network(&path)), ENDS.to_vec());
}

#[test]
fn the_frames_that_3d_slicer_and_itk_state_are_read() {
    let here = tempfile::tempdir().expect("a folder");
    let of = |name: &str, text: &str| {
        let path = here.path().join(name);
        write(&path, text).expect("written");
        let document = read(&path, &ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() }).expect("read");
        document.content.into_network(RadiusRule::Mean, Some(1e-3)).expect("a network").network.frame
    };
    let vtk = |title: &str| {
        format!("# vtk DataFile Version 4.2\n{title}\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n0 0 0 1 0 0\nLINES 1 3\n2 0 1\n")
    };
    assert_eq!(of("a.vtk", &vtk("3D Slicer output. SPACE=RAS")), Frame::Ras);
    assert_eq!(of("b.vtk", &vtk("3D Slicer output. SPACE=LPS")), Frame::Lps);
    assert_eq!(of("c.vtk", &vtk("vtk output")), Frame::Unknown);
    // As VTK keeps the array of a VTP, in both versions of its cells; that of the points is another.
    let cells = ["4.2\n", "5.1\n"].map(|version| {
        let lines = "LINES 2 2\nOFFSETS vtktypeint64\n0 2\nCONNECTIVITY vtktypeint64\n0 1\n";
        let lines = if version == "4.2\n" { "LINES 1 3\n2 0 1\n" } else { lines };
        (version, format!("POINTS 2 float\n0 0 0 1 0 0\n{lines}"))
    });
    for (version, cells) in cells {
        let head = format!("# vtk DataFile Version {version}vtk output\nASCII\nDATASET POLYDATA\n");
        let space = |word: &str, count: u32| {
            format!("FIELD FieldData 1\nSPACE 1 {count} string\n{}\n", [word].repeat(count as usize).join("\n"))
        };
        assert_eq!(of("d.vtk", &(head.clone() + &space("LPS", 1) + &cells)), Frame::Lps);
        assert_eq!(of("e.vtk", &(head.clone() + &space("RAS", 1) + &cells)), Frame::Ras);
        assert_eq!(of("f.vtk", &(head + &cells + "POINT_DATA 2\n" + &space("RAS", 2))), Frame::Unknown);
    }
    let vtp = |fields: &str| {
        format!(
            "<VTKFile type=\"PolyData\"><PolyData>{fields}<Piece NumberOfPoints=\"2\" NumberOfLines=\"1\"><Points>\
             <DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0</DataArray></Points><Lines>\
             <DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1</DataArray>\
             <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">2</DataArray></Lines></Piece></PolyData></VTKFile>"
        )
    };
    let space =
        "<FieldData><Array type=\"String\" Name=\"SPACE\" NumberOfTuples=\"1\" format=\"ascii\">76 80 83 0</Array></FieldData>";
    assert_eq!(of("a.vtp", &vtp(space)), Frame::Lps);
    assert_eq!(of("b.vtp", &vtp("")), Frame::Unknown);
    let tube = |orientation: &str| {
        format!(
            "ObjectType = Scene\nNDims = 3\nNObjects = 1\nObjectType = Tube\nNDims = 3\nID = 1\n{orientation}\
             PointDim = x y z r\nNPoints = 2\nPoints = \n0 0 0 1\n1 0 0 1\n"
        )
    };
    assert_eq!(of("a.tre", &tube("AnatomicalOrientation = RAI\n")), Frame::Lps);
    assert_eq!(of("b.tre", &tube("AnatomicalOrientation = LPI\n")), Frame::Ras);
    assert_eq!(of("c.tre", &tube("")), Frame::Unknown);
    assert_eq!(of("a.swc", "# SPACE=LPS\n1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n"), Frame::Lps);
    assert_eq!(of("b.swc", "1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n"), Frame::Unknown);
    let curve = |system: &str| {
        let points = "\"controlPoints\": [{\"position\": [0, 0, 0]}, {\"position\": [1, 0, 0]}]";
        format!("{{\"markups\": [{{\"type\": \"Curve\", {system}{points}}}]}}")
    };
    assert_eq!(of("a.json", &curve("\"coordinateSystem\": \"RAS\", ")), Frame::Lps);
    assert_eq!(of("b.json", &curve("\"coordinateSystem\": \"LPS\", ")), Frame::Lps);
    assert_eq!(of("c.json", &curve("")), Frame::Unknown);
}

const PEERS: &str = r#"
import json, sys
import networkx as nx, nibabel as nib, numpy as np
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
from vtkmodules.vtkIOLegacy import vtkPolyDataReader
at = lambda name: f"{sys.argv[1]}/{name}"
image = nib.load(at("m.nii"))
voxels = np.argwhere(np.asarray(image.dataobj) > 0)
middle = (image.affine @ [*voxels.mean(axis=0), 1])[:3]
graph = nx.read_graphml(at("m.graphml"))
assert graph.graph["frame"] == "RAS", graph.graph
xyz = lambda node: [float(node[f"{axis}_mm"]) for axis in "xyz"]
found = {"graphml": np.mean([xyz(node) for _, node in graph.nodes(data=True)], axis=0)}
reader = vtkXMLPolyDataReader(); reader.SetFileName(at("m.vtp")); reader.Update(); poly = reader.GetOutput()
space = poly.GetFieldData().GetAbstractArray("SPACE")
assert space.GetNumberOfValues() == 1 and space.GetValue(0) == "RAS"
box = poly.GetBounds(); found["vtp"] = [(box[2 * k] + box[2 * k + 1]) / 2 for k in range(3)]
reader = vtkPolyDataReader(); reader.SetFileName(at("m.vtk")); reader.Update()
assert "SPACE=RAS" in reader.GetHeader()
box = reader.GetOutput().GetBounds(); found["vtk"] = [(box[2 * k] + box[2 * k + 1]) / 2 for k in range(3)]
arrays = np.load(at("m.npz")); assert list(arrays["frame"]) == ["RAS"]
found["npz"] = (arrays["coords"].min(axis=0) + arrays["coords"].max(axis=0)) / 2
curve = json.load(open(at("m.mrk.json")))["markups"][0]; assert curve["coordinateSystem"] == "LPS"
p = np.array([point["position"] for point in curve["controlPoints"]])
found["markups"] = (p.min(axis=0) + p.max(axis=0)) / 2 * [-1, -1, 1]
for name, point in found.items():
    assert np.allclose(point, middle, atol=1e-3), (name, point, middle)
print(len(found))
"#;

#[test]
fn other_programs_find_the_line_where_nibabel_has_it() {
    let here = tempfile::tempdir().expect("a folder");
    // A plain NIfTI-1: sform with axes along -y, x and z.
    let mut bytes = vec![0_u8; 352];
    let mut field = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    field(0, &348_i32.to_le_bytes());
    for (n, length) in [3_i16, 15, 5, 5].iter().enumerate() {
        field(40 + 2 * n, &length.to_le_bytes());
    }
    field(70, &2_i16.to_le_bytes());
    field(72, &8_i16.to_le_bytes());
    for (n, length) in [1.0_f32, 1.0, 1.0, 0.5].iter().enumerate() {
        field(76 + 4 * n, &length.to_le_bytes());
    }
    field(108, &352.0_f32.to_le_bytes());
    field(123, &[2]);
    field(254, &1_i16.to_le_bytes());
    let rows: [[f32; 4]; 3] = [[0.0, 1.0, 0.0, -40.0], [-1.0, 0.0, 0.0, 25.0], [0.0, 0.0, 0.5, 12.0]];
    for (n, x) in rows.iter().flatten().enumerate() {
        field(280 + 4 * n, &x.to_le_bytes());
    }
    field(344, b"n+1\0");
    let voxels = bar();
    bytes.extend_from_slice(&voxels[voxels.len() - 375..]);
    let mask = here.path().join("m.nii");
    write(&mask, bytes).expect("written");
    let drawn = network(&mask);
    for (word, name) in
        [("graphml", "m.graphml"), ("vtp", "m.vtp"), ("vtk", "m.vtk"), ("npz", "m.npz"), ("markups", "m.mrk.json")]
    {
        put(&drawn, word, &here.path().join(name));
    }
    let Some(said) = python(PEERS, &[here.path()]) else { return };
    assert_eq!(said, "5");
}

/// A label may be any text; only a comment that names none states the frame.
#[test]
fn a_label_of_swc_states_no_frame() {
    let here = tempfile::tempdir().expect("a folder");
    let path = here.path().join("a.swc");
    for (comment, frame) in [("# label 16 SPACE=LPS", Frame::Unknown), ("# mm; SPACE=LPS", Frame::Lps)] {
        write(&path, format!("{comment}\n1 0 0 0 0 1 -1\n2 16 1 0 0 1 1\n")).expect("written");
        assert_eq!(network(&path).frame, frame, "{comment}");
    }
}
