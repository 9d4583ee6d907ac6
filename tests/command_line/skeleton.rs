//! `willis skeleton`, and `infer` on a mask: a NumPy mask drawn here.

use std::fs;
use std::path::Path;

use crate::command::{folder, stderr, willis};

/// A tube of radius 2 along x from 5 to 45, one along y that leaves it at x = 25, and a gap of 5 voxels in the first.
fn draw(path: &Path) {
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    let head = "{'descr': '|u1', 'fortran_order': True, 'shape': (50, 40, 12), }";
    bytes.extend(format!("{head:117}\n").bytes());
    for n in 0..50 * 40 * 12 {
        let [x, y, z] = [n % 50, n / 50 % 40, n / 2000].map(f64::from);
        let first = (5.0..=45.0).contains(&x) && (y - 8.0).hypot(z - 6.0) <= 2.0 && !(32.0..37.0).contains(&x);
        let second = (8.0..=36.0).contains(&y) && (x - 20.0).hypot(z - 6.0) <= 1.5;
        bytes.push(u8::from(first || second));
    }
    fs::write(path, bytes).expect("written");
}

#[test]
fn a_mask_becomes_lines_and_an_answer() {
    let here = folder();
    draw(&here.path().join("m.npy"));
    let output = willis(here.path(), &["skeleton", "m.npy", "--spacing", "0.5", "-o", "m.graphml", "--json"]);
    let said = stderr(&output);
    // The line that repeats it has an output.
    let record: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(record["command"], "willis skeleton m.npy --spacing 0.5 -o again.graphml");
    assert!(output.status.success() && said.contains("NumPy mask, mm: 2 fragments, 4 vessels"), "{said}");
    assert!(said.contains("a mask of 50 x 40 x 12 voxels of 0.5 x 0.5 x 0.5 mm"), "{said}");
    let output = willis(here.path(), &["infer", "m.npy", "--spacing", "0.5", "-o", "out"]);
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("topology  1 component"), "{said}");
    // Slicer keeps positions in LPS: x and y turn.
    let output = willis(here.path(), &["skeleton", "m.npy", "--spacing", "0.5", "--frame", "RAS", "-o", "m.mrk.json"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let positions = |name: &str| {
        let text = fs::read_to_string(here.path().join(name)).expect("written");
        let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let curves = value["markups"].as_array().expect("curves").clone();
        let points = curves.iter().flat_map(|curve| curve["controlPoints"].as_array().expect("points").clone());
        points.map(|point| [0, 1, 2].map(|axis| point["position"][axis].as_f64().expect("mm"))).collect::<Vec<_>>()
    };
    let points = positions("m.mrk.json");
    assert!(points.iter().all(|[x, y, z]| (-22.8..=-2.2).contains(x) && (-18.3..=-2.5).contains(y) && (2.0..4.0).contains(z)));
}

#[test]
fn options_of_masks_go_with_masks() {
    let here = folder();
    draw(&here.path().join("m.npy"));
    fs::write(here.path().join("a.swc"), "1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n3 0 2 0 0 1 2\n").expect("written");
    let refused = |arguments: &[&str], wanted: &str| {
        let output = willis(here.path(), arguments);
        let said = stderr(&output);
        assert!(output.status.code() == Some(2) && said.lines().count() == 1 && said.contains(wanted), "{arguments:?}: {said}");
        assert!(!here.path().join("o.swc").exists());
    };
    refused(&["convert", "a.swc", "o.swc", "--level", "0.5"], "--level 0.5: goes with a mask");
    refused(&["convert", "a.swc", "o.swc", "--radius-from", "distance"], "--radius-from distance: goes with a mask");
    refused(&["skeleton", "a.swc", "-o", "o.swc"], "a.swc: a file of SWC; expected a mask");
    refused(&["skeleton", "m.npy", "-o", "o.swc"], "expected --spacing SX,SY,SZ, in mm");
    refused(&["skeleton", "m.npy", "--spacing", "0", "-o", "o.swc"], "--spacing 0: expected one or three positive numbers");
    refused(&["skeleton", "m.npy", "--spacing", "1", "--level", "nan", "-o", "o.swc"], "--level NaN: expected a finite number");
    refused(&["skeleton", "m.npy", "--spacing", "1", "--level", "2", "-o", "o.swc"], "an empty mask; expected a lower --level");
}

/// Two pieces of one vessel whose gap is bridged; with a box whose face runs through the gap they end at it, and are not.
#[test]
fn nothing_is_joined_where_vessels_leave_the_image() {
    let here = folder();
    let piece = |first: u32, from: u32| {
        let line = |n: u32| {
            let parent = if n == 0 { "-1".to_owned() } else { (first + n - 1).to_string() };
            format!("{} 0 {} 0 0 1 {parent}\n", first + n, from + n)
        };
        (0..15).map(line).collect::<String>()
    };
    fs::write(here.path().join("a.swc"), piece(1, 0) + &piece(101, 17)).expect("written");
    let run = |more: &[&str]| {
        let output = willis(here.path(), &[&["infer", "a.swc", "-o", "out", "--force"], more].concat());
        let said = stderr(&output);
        assert!(output.status.success(), "{said}");
        let nodes = fs::read_to_string(here.path().join("out/nodes.csv")).expect("nodes");
        (said, nodes)
    };
    assert!(run(&[]).0.contains("topology  1 component"));
    let (said, _) = run(&["--box", "-5,-5,-5,14.5,5,5"]);
    assert!(said.contains("3 free ends at the border of the image's box") && said.contains("topology  2 components"), "{said}");
    // The last point is at 31 mm.
    let beside = ("131,0,0,140,9,9", "--box: no vessel lies in it, the nearest 100.0 mm away; expected that of the image");
    let cases =
        [beside, ("1,2,3", "--box 1,2,3: expected six numbers"), ("0,0,0,1,0,1", "--box 0,0,0,1,0,1: expected the least x,y,z")];
    for (given, wanted) in cases {
        let output = willis(here.path(), &["infer", "a.swc", "-o", "o", "--box", given]);
        assert!(output.status.code() == Some(2) && stderr(&output).contains(wanted), "{}", stderr(&output));
    }
}

/// Ends are those of what was observed, with its radii: of a graph that is taken as observed every edge, of a ready one no candidate. By hand:
/// a is half a mm from its face, c too; b is 4 mm from its own, and only the candidate is so wide.
#[test]
fn ends_at_the_border_are_those_of_observed_vessels() {
    let here = folder();
    let key = |name: &str, of: &str| format!("<key id=\"{name}\" for=\"{of}\" attr.name=\"{name}\" attr.type=\"string\"/>");
    let keys = ["x_mm", "y_mm", "z_mm"].map(|name| key(name, "node")).concat()
        + &["radius_mm", "length_mm", "origin"].map(|name| key(name, "edge")).concat();
    let data = |name: &str, value: &str| format!("<data key=\"{name}\">{value}</data>");
    let node =
        |id: &str, x: &str| format!("<node id=\"{id}\">{}{}{}</node>", data("x_mm", x), data("y_mm", "0"), data("z_mm", "0"));
    let edge = |a: &str, b: &str, radius: &str, origin: &str| {
        let figures = data("radius_mm", radius) + &data("length_mm", "10") + &data("origin", origin);
        format!("<edge source=\"{a}\" target=\"{b}\">{figures}</edge>")
    };
    let nodes = node("a", "0") + &node("b", "10") + &node("c", "20");
    let edges = edge("a", "b", "1", "observed") + &edge("b", "c", "5", "candidate");
    fs::write(here.path().join("g.graphml"), format!("<graphml>{keys}<graph>{nodes}{edges}</graph></graphml>")).expect("written");
    let said = |more: &[&str]| {
        let output = willis(here.path(), &[&["candidates", "g.graphml", "-o", "out.graphml", "--force"], more].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    assert!(said(&["--observed", "--box=-0.5,-9,-9,20.5,9,9"]).contains("2 free ends at the border"));
    assert!(said(&["--box=-0.5,-9,-9,14,9,9"]).contains("1 free end at the border"));
}

/// Four broken vessels and a branch in a box, indices to class.
fn is_vessel([x, y, z]: [i64; 3]) -> bool {
    if !(0..60).contains(&x) || !(0..44).contains(&y) || !(0..24).contains(&z) {
        return false;
    }
    let [x, y, z] = [x, y, z].map(|n| n as f64);
    let along_x = |cy: f64, cz: f64, r: f64, gap: f64| {
        (4.0..=55.0).contains(&x) && (y - cy - 0.05 * x).hypot(z - cz) <= r && !(gap..gap + 4.0).contains(&x)
    };
    let branch = (9.0..=38.0).contains(&y) && (x - 20.0).hypot(z - 7.0) <= 1.5 && !(20.0..23.0).contains(&y);
    along_x(7.0, 7.0, 2.2, 33.0) || along_x(18.0, 15.0, 1.7, 24.0) || along_x(30.0, 8.0, 1.9, 40.0) || branch
}

/// Where a file keeps a voxel: its axes in another order and direction, and a margin of background on all sides.
#[derive(Clone, Copy)]
struct Storage {
    order: [usize; 3],
    flipped: [bool; 3],
    margin: i64,
}

impl Storage {
    fn shape(self) -> [i64; 3] {
        self.order.map(|axis| [60, 44, 24][axis] + 2 * self.margin)
    }

    /// The voxels, the first axis fastest, and millimetres from them in RAS: voxels of 0.5 x 0.5 x 0.6 mm.
    fn draw(self) -> (Vec<u8>, [[f64; 4]; 3]) {
        let shape = self.shape();
        let mut affine = [[0.0; 4]; 3];
        for (axis, row) in affine.iter_mut().enumerate() {
            row[3] = -0.5 * self.margin as f64 * [1.0, 1.0, 1.2][axis];
        }
        for (axis, of) in self.order.into_iter().enumerate() {
            let step = [0.5, 0.5, 0.6][of];
            affine[of][axis] = if self.flipped[axis] { -step } else { step };
            affine[of][3] += if self.flipped[axis] { step * (shape[axis] - 1) as f64 } else { 0.0 };
        }
        let voxel = |n: i64| {
            let stored = [n % shape[0], n / shape[0] % shape[1], n / (shape[0] * shape[1])];
            let mut at = [0; 3];
            for axis in 0..3 {
                let index = if self.flipped[axis] { shape[axis] - 1 - stored[axis] } else { stored[axis] };
                at[self.order[axis]] = index - self.margin;
            }
            u8::from(is_vessel(at))
        };
        ((0..shape.iter().product()).map(voxel).collect(), affine)
    }

    fn nifti(self) -> Vec<u8> {
        let (voxels, affine) = self.draw();
        let mut bytes = vec![0; 352];
        let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
        put(0, &348_i32.to_le_bytes());
        for (n, length) in [3, self.shape()[0], self.shape()[1], self.shape()[2]].into_iter().enumerate() {
            put(40 + 2 * n, &(length as i16).to_le_bytes());
        }
        put(70, &2_i16.to_le_bytes());
        put(108, &352.0_f32.to_le_bytes());
        put(254, &1_i16.to_le_bytes());
        for (n, x) in affine.iter().flatten().enumerate() {
            put(280 + 4 * n, &(*x as f32).to_le_bytes());
        }
        put(344, b"n+1\0");
        [bytes, voxels].concat()
    }

    fn metaimage(self) -> Vec<u8> {
        let (voxels, affine) = self.draw();
        let words = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        let spacing = [0, 1, 2].map(|axis| affine.iter().map(|row| row[axis].abs()).sum::<f64>());
        // ITK's frame has x to the left and y backward.
        let turn = [-1.0, -1.0, 1.0];
        let mut directions = Vec::new();
        for axis in 0..3 {
            let cosine = |(row, turn): (&[f64; 4], f64)| if row[axis] == 0.0 { 0.0 } else { turn * row[axis].signum() };
            directions.extend(affine.iter().zip(turn).map(cosine));
        }
        let origin = [0, 1, 2].map(|row| turn[row] * affine[row][3]);
        let head = format!(
            "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = {}\nOffset = {}\nElementSpacing = {}\nDimSize = {}\n\
             ElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
            words(&directions),
            words(&origin),
            words(&spacing),
            words(&self.shape().map(|n| n as f64)),
        );
        [head.as_bytes(), &voxels].concat()
    }

    fn numpy(self) -> Vec<u8> {
        let (voxels, _) = self.draw();
        let [x, y, z] = self.shape();
        let head = format!("{{'descr': '|u1', 'fortran_order': True, 'shape': ({x}, {y}, {z}), }}");
        [b"\x93NUMPY\x01\x00\x76\x00".as_slice(), format!("{head:117}\n").as_bytes(), &voxels].concat()
    }
}

/// The candidates by place, hundredths of mm, and whether each is kept.
fn decisions(here: &Path, name: &str, more: &[&str]) -> Vec<(Vec<[i64; 3]>, bool)> {
    let output = willis(here, &[&["infer", name, "-o", "out", "--force", "-q"], more].concat());
    assert!(output.status.success(), "{name}: {}", stderr(&output));
    let table = |name: &str| {
        let text = fs::read_to_string(here.join("out").join(name)).expect("a table");
        let mut rows = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let names = rows.next().expect("names");
        (names, rows.collect::<Vec<_>>())
    };
    let (names, rows) = table("edges.csv");
    let column = |wanted: &str| names.iter().position(|name| name == wanted).unwrap_or_else(|| panic!("{wanted} in {names:?}"));
    let ends = [["ax_mm", "ay_mm", "az_mm"], ["bx_mm", "by_mm", "bz_mm"]].map(|names| names.map(column));
    let (origin, kept) = (column("origin"), column("kept"));
    let candidates = rows.iter().filter(|row| row[origin] == "candidate");
    let mut all: Vec<(Vec<[i64; 3]>, bool)> = candidates
        .map(|row| {
            let mut at =
                ends.map(|columns| columns.map(|n| (row[n].parse::<f64>().expect("mm") * 100.0).round() as i64)).to_vec();
            at.sort_unstable();
            (at, row[kept] == "1")
        })
        .collect();
    all.sort_unstable();
    all
}

#[test]
fn decisions_do_not_depend_on_how_the_mask_is_stored() {
    let here = folder();
    let plain = Storage { order: [0, 1, 2], flipped: [false; 3], margin: 0 };
    let put = |name: &str, bytes: Vec<u8>| fs::write(here.path().join(name), bytes).expect("written");
    put("m.nii", plain.nifti());
    let truth = decisions(here.path(), "m.nii", &[]);
    let kept = truth.iter().filter(|(_, kept)| *kept).count();
    assert!(kept >= 3 && kept < truth.len(), "{kept} of {}", truth.len());
    for (order, flipped, margin) in [
        ([0, 1, 2], [true, true, false], 0),
        ([2, 0, 1], [false; 3], 0),
        ([1, 0, 2], [true, false, true], 3),
        ([2, 1, 0], [true; 3], 7),
    ] {
        let storage = Storage { order, flipped, margin };
        put("m.nii", storage.nifti());
        assert!(decisions(here.path(), "m.nii", &[]) == truth, "NIfTI {order:?} {flipped:?} {margin}");
        put("m.mha", storage.metaimage());
        assert!(decisions(here.path(), "m.mha", &[]) == truth, "MetaImage {order:?} {flipped:?} {margin}");
    }
    put("m.npy", plain.numpy());
    assert!(decisions(here.path(), "m.npy", &["--spacing", "0.5,0.5,0.6"]) == truth, "NumPy");
}

#[test]
fn a_bad_mask_is_one_line_and_nothing_is_written() {
    let here = folder();
    let plain = Storage { order: [0, 1, 2], flipped: [false; 3], margin: 0 };
    let nifti = plain.nifti();
    let with = |at: usize, value: &[u8]| {
        let mut bytes = nifti.clone();
        bytes[at..at + value.len()].copy_from_slice(value);
        bytes
    };
    let mut grey = nifti.clone();
    grey[352..].iter_mut().enumerate().for_each(|(n, voxel)| *voxel = (n % 200) as u8);
    let huge = [60_i16, 30_000, 30_000].map(i16::to_le_bytes).concat();
    let cases: [(&str, Vec<u8>, &str); 7] = [
        ("empty", [&nifti[..352], &vec![0; nifti.len() - 352]].concat(), "an empty mask"),
        ("image", grey, "looks like an image, not a mask: 199 values; give --level"),
        ("cut", nifti[..5000].to_vec(), "is the file cut off?"),
        ("huge", with(42, &huge), "expected at most"),
        ("infinite", with(280, &f32::INFINITY.to_le_bytes()), "expected a positive spacing along every axis"),
        ("singular", with(280, &[0; 4]), "expected a positive spacing along every axis"),
        ("two", with(40, &[4, 0, 60, 0, 44, 0, 12, 0, 2, 0]), "expected three dimensions; take one volume"),
    ];
    for (name, bytes, wanted) in cases {
        let file = format!("{name}.nii");
        fs::write(here.path().join(&file), bytes).expect("written");
        for command in [["skeleton", &file, "-o", "o.swc"], ["infer", &file, "-o", "o"]] {
            let output = willis(here.path(), &command);
            let said = stderr(&output);
            assert!(output.status.code() == Some(2) && said.lines().count() == 1 && said.contains(wanted), "{command:?}: {said}");
            assert!(!here.path().join(command[3]).exists(), "{command:?}");
        }
    }
}
