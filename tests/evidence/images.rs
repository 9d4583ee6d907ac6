//! The image beside a mask: candidates are looked at in it, in any unit, and an image of something else changes nothing.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use willis::internals::candidates::joins::image::ways::cheapest_path;
use willis::internals::formats::{ReadOptions, read_image, write_nifti_image};
use willis::internals::masks::{Appearance, Image, Picture, Scene, View};
use willis::internals::network::{Frame, Origin};
use willis::internals::support::geometry::{Point, distance};
use willis::{InferOptions, candidates, read};

use crate::command::{folder, stderr, willis};
use crate::contacts::mirrored;
use crate::extracted::extracted;
use crate::joins::{straight, vessels};
use crate::refused::refused;

/// A broken tree as a mask, and its image.
pub fn scan(here: &Path) -> (PathBuf, Image) {
    let made = willis(here, &["phantom", "tree", "--break", "--spacing", "0.7mm", "-o", "scan.nii.gz", "--image", "image.nii"]);
    assert!(made.status.success(), "{}", stderr(&made));
    let image = read_image(&here.join("image.nii"), &ReadOptions::default(), Frame::Unknown).expect("an image").0;
    (here.join("scan.nii.gz"), image)
}

/// The probability of each candidate, by the ids of its ends.
fn probabilities(mask: &Path, image: Option<PathBuf>) -> BTreeMap<[String; 2], f64> {
    let input = read(mask, &ReadOptions::default()).expect("a mask");
    let graph = candidates(&input, &InferOptions { image, ..InferOptions::default() }).expect("candidates");
    let of = graph.vessels().filter(|(_, vessel)| vessel.origin == Origin::Candidate);
    of.map(|(ends, vessel)| (ends.map(|end| graph.node(end).id.clone()), vessel.evidence().expect("evidence").probability))
        .collect()
}

/// The image with other values, in a file of its own.
pub fn written(here: &Path, name: &str, image: &Image) -> PathBuf {
    let path = here.join(name);
    write_nifti_image(fs::File::create(&path).expect("a file"), image, false).expect("written");
    path
}

fn largest_change(a: &BTreeMap<[String; 2], f64>, b: &BTreeMap<[String; 2], f64>) -> f64 {
    let keys = a.keys().chain(b.keys());
    let change = |key| (a.get(key).unwrap_or(&0.0) - b.get(key).unwrap_or(&0.0)).abs();
    keys.map(change).fold(0.0, f64::max)
}

/// A value of the image in another one, given the place along the first axis from -0.5 to 0.5.
type Change = fn(f64, f32) -> f32;

#[test]
fn unit_window_and_bias_field_change_no_probability_and_the_image_does() {
    let here = folder();
    let (mask, image) = scan(here.path());
    let [plain, with] = [None, Some(here.path().join("image.nii"))].map(|image| probabilities(&mask, image));
    assert!(plain.len() > 50 && largest_change(&plain, &with) > 0.2, "{}", largest_change(&plain, &with));
    let across = |row: usize| (row % image.shape[0]) as f64 / image.shape[0] as f64 - 0.5;
    let changed: [(&str, Change); 4] = [
        ("three times", |_, x| 3.0 * x),
        ("shifted", |_, x| 500.0 + 200.0 * x),
        ("dark", |_, x| 4.0 - x),
        ("bias", |across, x| ((50.0 + 100.0 * f64::from(x)) * (1.0 + 0.3 * across)) as f32),
    ];
    for (name, change) in changed {
        let values = image.values.iter().enumerate().map(|(row, x)| change(across(row), *x)).collect();
        let path = written(here.path(), "changed.nii", &Image { values, ..image.clone() });
        let other = probabilities(&mask, Some(path));
        let moved = largest_change(&with, &other);
        // A gain that differs by 2 % between the ends of a gap moves a feature past the threshold of a tree now and then.
        if name == "bias" {
            let few = with.iter().filter(|(key, p)| (*p - other.get(*key).unwrap_or(&0.0)).abs() > 0.05).count();
            assert!(few * 50 <= with.len() && moved <= 0.1, "{name}: {few} of {}, {moved}", with.len());
        } else {
            assert!(moved <= 0.05, "{name}: {moved}");
        }
    }
}

#[test]
fn an_image_with_other_voxels_says_the_same() {
    let here = folder();
    let (mask, image) = scan(here.path());
    let with = probabilities(&mask, Some(here.path().join("image.nii")));
    // Voxels of 0.5 mm, with the last axis first.
    let far = |axis: usize| (image.shape[axis] - 1) as f64 * 0.7;
    let corner = image.affine.map(|row| row[3] / 1e3);
    let whole = [corner, [0, 1, 2].map(|k| corner[k] + far(k) / 1e3)];
    let picture = Picture::of(image.clone(), whole, 0.0).expect("the whole image");
    let shape = [2, 1, 0].map(|axis| (far(axis) / 0.5) as usize);
    let mut values = Vec::new();
    for x in 0..shape[2] {
        for y in 0..shape[1] {
            for z in 0..shape[0] {
                let place = [x, y, z].map(|n| n as f64 * 0.5e-3);
                values.push(picture.value([0, 1, 2].map(|k| corner[k] + place[k])).expect("inside") as f32);
            }
        }
    }
    let [x, y, z] = image.affine.map(|row| row[3]);
    let affine = [[0.0, 0.0, 0.5, x], [0.0, 0.5, 0.0, y], [0.5, 0.0, 0.0, z]];
    let path = written(here.path(), "fine.nii", &Image { shape, values, affine });
    let other = probabilities(&mask, Some(path));
    let moved: Vec<f64> = with.iter().map(|(key, p)| (p - other.get(key).unwrap_or(&0.0)).abs()).collect();
    let share = moved.iter().filter(|x| **x <= 0.05).count() as f64 / moved.len() as f64;
    assert!(share >= 0.95, "{share}: {moved:?}");
}

#[test]
fn an_image_with_more_noise_than_the_model_knows_is_told() {
    let here = folder();
    let (_, image) = scan(here.path());
    let said = |amplitude: f32| {
        let noise = |row: usize| (share_of(row) - 0.5) * amplitude;
        let values = image.values.iter().enumerate().map(|(row, x)| x + noise(row)).collect();
        written(here.path(), "noisy.nii", &Image { values, ..image.clone() });
        let done = willis(here.path(), &["infer", "scan.nii.gz", "--image", "noisy.nii", "-o", "out", "-n", "1", "--force"]);
        assert!(done.status.success(), "{}", stderr(&done));
        stderr(&done)
    };
    let told = "noisy.nii: the noise is 0.";
    assert!(!said(0.5).contains(told), "{}", said(0.5));
    let loud = said(4.0);
    assert!(loud.contains(told) && loud.contains("less sure") && !loud.contains("does not show"), "{loud}");
}

/// A number from 0 to 1 that looks random, the same for the same row.
fn share_of(row: usize) -> f32 {
    let mixed = (row as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((mixed ^ (mixed >> 32)) >> 40) as f32 / (1_u32 << 24) as f32
}

#[test]
fn an_image_of_something_else_is_told_and_changes_nothing() {
    let here = folder();
    let (_, image) = scan(here.path());
    let infer = |out: &str, more: &[&str]| {
        let done = willis(here.path(), &[&["infer", "scan.nii.gz", "-o", out, "-n", "1", "--dpi", "36"], more].concat());
        assert!(done.status.success(), "{}", stderr(&done));
        (fs::read(here.path().join(out).join("edges.csv")).expect("a table"), stderr(&done))
    };
    let (plain, _) = infer("plain", &[]);
    let (with, said) = infer("with", &["--image", "image.nii"]);
    assert!(plain != with && !said.contains("does not show"), "{said}");
    let record = fs::read_to_string(here.path().join("with/run.json")).expect("a record");
    let record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
    assert_eq!(record["parameters"]["image"]["path"], "image.nii");
    assert!(record["parameters"]["image"]["unused"].is_null());

    let shifted = |mm: f64| Image { affine: image.affine.map(|[a, b, c, d]| [a, b, c, d + mm]), ..image.clone() };
    let turned: Vec<f32> = image.values.iter().rev().copied().collect();
    let wrong = [
        ("constant", Image { values: vec![1.0; image.values.len()], ..image.clone() }),
        ("ten-mm", shifted(10.0)),
        ("far", shifted(1000.0)),
        ("turned", Image { values: turned, ..image.clone() }),
    ];
    for (name, other) in wrong {
        written(here.path(), "wrong.nii", &other);
        let (edges, said) = infer(name, &["--image", "wrong.nii"]);
        assert!(said.contains("wrong.nii does not show the vessels"), "{name}: {said}");
        assert!(edges == plain, "{name}");
    }
    let (edges, said) = infer("sign", &["--image", "image.nii", "--vessels", "dark"]);
    assert!(edges == plain && said.contains("does not show the vessels"), "{said}");
    // The same header with numbers of 32 bits, none of which is one.
    let mut bytes = fs::read(here.path().join("image.nii")).expect("a file")[..352].to_vec();
    bytes[70..72].copy_from_slice(&16_i16.to_le_bytes());
    bytes[72..74].copy_from_slice(&32_i16.to_le_bytes());
    bytes.extend(f32::NAN.to_le_bytes().repeat(image.values.len()));
    fs::write(here.path().join("nan.nii"), bytes).expect("a file");
    let (edges, said) = infer("nan", &["--image", "nan.nii"]);
    assert!(edges == plain && said.contains("it has no values where they are"), "{said}");
}

/// The same lines in LPS: the image, which is in RAS, shows them as well.
#[test]
fn an_image_shows_lines_of_the_other_frame() {
    let here = folder();
    scan(here.path());
    assert!(willis(here.path(), &["skeleton", "scan.nii.gz", "-o", "ras.swc"]).status.success());
    let lines = fs::read_to_string(here.path().join("ras.swc")).expect("lines");
    fs::write(here.path().join("lps.swc"), mirrored(&lines)).expect("written");
    let vessels = |lines: &str, out: &str| {
        let words = ["infer", lines, "-o", out, "--prior", "weights:skeleton", "--image", "image.nii", "-n", "1", "--dpi", "36"];
        let done = willis(here.path(), &words);
        assert!(done.status.success() && !stderr(&done).contains("does not show the vessels"), "{}", stderr(&done));
        fs::read_to_string(here.path().join(out).join("edges.csv")).expect("a table").lines().count()
    };
    // What is measured goes by blocks from another corner.
    let [ras, lps] = [vessels("ras.swc", "ras"), vessels("lps.swc", "lps")];
    assert!(ras.abs_diff(lps) * 50 < ras, "{ras} {lps}");
}

#[test]
fn an_image_that_cannot_be_looked_at_is_refused() {
    let lines = fs::read(crate::command::data("broken-circle-of-willis.swc")).expect("a file");
    let files: &[(&str, &[u8])] = &[("a.swc", &lines), ("a.nii", b"no image")];
    refused(files, &["infer", "a.swc", "-o", "out", "--image", "a.nii"], &["--image", "a.nii", "weights:skeleton"]);
    let skeleton = ["infer", "a.swc", "-o", "out", "--prior", "weights:skeleton", "--image", "a.nii"];
    refused(files, &skeleton, &["a.nii"]);
    refused(files, &["infer", "a.swc", "-o", "out", "--vessels", "dark"], &["--image"]);
    refused(&[], &["phantom", "tree", "-o", "a.swc", "--image", "b.nii"], &["--image", ".nii.gz"]);
    refused(&[], &["phantom", "tree", "-o", "a.nii", "--image", "./a.nii"], &["--image ./a.nii", "another file"]);
}

#[test]
fn the_threshold_of_a_phantom_was_drawn_in_its_image() {
    let here = folder();
    let (mask, image) = scan(here.path());
    let mask = willis::internals::formats::read_mask(&mask, &ReadOptions::default(), Frame::Unknown).expect("a mask");
    assert_eq!(mask.shape, image.shape);
    // Of the voxels of vessels only filled holes are below all others; of the background only small specks are above it.
    let values = |class: u8| image.values.iter().zip(&mask.classes).filter(move |(_, c)| **c == class).map(|(x, _)| *x);
    let mut inside: Vec<f32> = values(1).collect();
    inside.sort_by(f32::total_cmp);
    let threshold = inside[inside.len() / 50];
    let above = values(0).filter(|x| *x > threshold).count();
    assert!(above * 20 < inside.len(), "{above} of {}", inside.len());
}

/// A texture without a direction, by the place (mm), so that there is a noise to measure.
pub fn ripple(p: Point) -> f64 {
    0.02 * ((2.1 * p[0]).sin() + (1.7 * p[1] + 1.0).sin() + (1.9 * p[2] + 2.0).sin())
}

/// An image of voxels of 0.5 mm from the origin, by the value at each place (mm).
pub fn drawn(shape: [usize; 3], value: impl Fn(Point) -> f64) -> Image {
    let mut values = Vec::new();
    for z in 0..shape[2] {
        for y in 0..shape[1] {
            for x in 0..shape[0] {
                values.push(value([x, y, z].map(|n| n as f64 * 0.5)) as f32);
            }
        }
    }
    Image { shape, values, affine: [[0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0]] }
}

/// Flattened with voxels of 0.5 mm, which make no whole number of blocks along any axis: which end of an axis the file begins with changes no
/// value at any place.
#[test]
fn the_direction_of_the_axes_in_the_file_changes_no_value() {
    let shape = [37, 41, 29];
    let plain = drawn(shape, |p| ripple(p) + 0.3 * ripple(p.map(|x| 0.1 * x)));
    let flat = |image: Image| {
        let mut picture = Picture::of(image, [[0.0; 3], [0.1; 3]], 0.4e-3).expect("the whole image");
        picture.flatten(1.7e-3, |_| true);
        picture
    };
    let expected = flat(plain.clone());
    for axis in 0..3 {
        let far = shape[axis] - 1;
        let mut affine = plain.affine;
        affine[axis][axis] = -0.5;
        affine[axis][3] = 0.5 * far as f64;
        let mut values = Vec::new();
        for row in 0..plain.values.len() {
            let mut at = [row % shape[0], row / shape[0] % shape[1], row / (shape[0] * shape[1])];
            at[axis] = far - at[axis];
            values.push(plain.values[(at[2] * shape[1] + at[1]) * shape[0] + at[0]]);
        }
        let turned = flat(Image { shape, values, affine });
        for n in 0..200 {
            let place = [0.7e-3, 1.1e-3, 1.3e-3].map(|step| step * f64::from(n) % 14e-3);
            assert_eq!(turned.value(place), expected.value(place), "axis {axis}, {place:?}");
        }
    }
}

#[test]
fn the_cheapest_path_follows_a_bent_vessel_and_is_straight_where_there_is_none() {
    // Two vessels along x with a gap of 12 mm, in which the image shows an arc 3 mm high.
    let course = |x: f64| if (24.0..=36.0).contains(&x) { 3.0 * (1.0 - ((x - 30.0) / 6.0).powi(2)) } else { 0.0 };
    let arc: Vec<Point> = (0..=1200).map(|n| f64::from(n) * 0.05).map(|x| [x, 15.0 + course(x), 15.0]).collect();
    let bright = |p: Point, upto: &dyn Fn(f64) -> bool| {
        let near = arc.iter().filter(|q| upto(q[0])).map(|q| distance(*q, p)).fold(f64::INFINITY, f64::min);
        ripple(p) + (-0.5 * (near / 0.6).powi(2)).exp()
    };
    let whole = drawn([121, 61, 61], |p| bright(p, &|_| true));
    let gap = drawn([121, 61, 61], |p| bright(p, &|x| !(24.0..=36.0).contains(&x)));
    let lines =
        [(straight([0.0, 15.0, 15.0], [24.0, 15.0, 15.0], 30), 0.6), (straight([36.0, 15.0, 15.0], [60.0, 15.0, 15.0], 30), 0.6)];
    let network = vessels(&lines);
    let extraction = extracted(&network, &[]).expect("points");
    let [mut costs, mut highest] = [[0.0; 2]; 2];
    for (n, image) in [&whole, &gap].into_iter().enumerate() {
        let scene = Scene::new(&extraction.centerlines(), View { image: image.clone(), appearance: Appearance::Auto })
            .expect("it shows the vessels");
        let ends = [[0.024, 0.015, 0.015], [0.036, 0.015, 0.015]];
        let level = scene.level(ends[0]);
        let path = cheapest_path(&scene, ends, [1e-3; 2], [level.background, scene.typical], extraction.spacing).expect("a path");
        costs[n] = path.cost;
        highest[n] = path.points.iter().map(|p| (p[1] - 0.015) * 1e3).fold(0.0, f64::max);
        if n == 0 {
            // Nowhere is it further than a voxel from the arc.
            let off = |p: &Point| arc.iter().map(|q| distance(*q, p.map(|x| 1e3 * x))).fold(f64::INFINITY, f64::min);
            let most = path.points.iter().map(off).fold(0.0, f64::max);
            assert!(most < 0.5, "{most} mm");
        }
    }
    assert!((highest[0] - 3.0).abs() < 0.5, "{highest:?}");
    assert!(costs[0] * 5.0 < costs[1], "{costs:?}");
}
