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
    let output = willis(here.path(), &["skeleton", "m.npy", "--spacing", "0.5", "-o", "m.graphml"]);
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("NumPy mask, mm: 2 fragments, 4 vessels"), "{said}");
    assert!(said.contains("a mask of 50 x 40 x 12 voxels of 0.5 x 0.5 x 0.5 mm"), "{said}");
    let output = willis(here.path(), &["infer", "m.npy", "--spacing", "0.5", "-o", "out"]);
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("topology  1 component"), "{said}");
    // Slicer keeps positions in LPS: x and y turn.
    let output = willis(here.path(), &["skeleton", "m.npy", "--spacing", "0.5", "-o", "m.mrk.json"]);
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
    let cases = [("1,2,3", "--box 1,2,3: expected six numbers"), ("0,0,0,1,0,1", "--box 0,0,0,1,0,1: expected the least x,y,z")];
    for (given, wanted) in cases {
        let output = willis(here.path(), &["infer", "a.swc", "-o", "o", "--box", given]);
        assert!(output.status.code() == Some(2) && stderr(&output).contains(wanted), "{}", stderr(&output));
    }
}
