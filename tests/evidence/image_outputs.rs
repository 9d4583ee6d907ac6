//! What comes out beside an image: the small pictures on the page; and probabilities in place of an image.

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use willis::internals::candidates::features::Extraction;
use willis::internals::masks::strips::{ACROSS, ALONG, Strip};
use willis::internals::masks::{Appearance, Image, Scene, View};

use crate::command::{folder, stderr, willis};
use crate::images::{drawn, ripple, scan, written};
use crate::joins::{straight, vessels};

fn infer(here: &Path, out: &str, more: &[&str]) {
    let done = willis(here, &[&["infer", "scan.nii.gz", "-o", out, "-n", "1"], more].concat());
    assert!(done.status.success(), "{}", stderr(&done));
}

fn edges(here: &Path, out: &str) -> Vec<u8> {
    fs::read(here.join(out).join("edges.csv")).expect("a table")
}

/// The data of a page.
fn page(here: &Path, out: &str) -> Value {
    let page = fs::read_to_string(here.join(out).join("report.html")).expect("a page");
    let data = page.split("id=\"data\"").nth(1).and_then(|rest| rest.split_once('>')).expect("data").1;
    serde_json::from_str(data.split("</script>").next().expect("an end")).expect("JSON")
}

#[test]
fn the_page_has_pictures_of_doubtful_vessels_and_nothing_else_of_the_image() {
    let here = folder();
    scan(here.path());
    infer(here.path(), "plain", &[]);
    infer(here.path(), "with", &["--image", "image.nii"]);
    assert_eq!(page(here.path(), "plain")["image_cuts"]["of"], Value::Array(Vec::new()));
    let data = page(here.path(), "with");
    let cuts = data["image_cuts"]["of"].as_array().expect("a list");
    assert!(!cuts.is_empty() && cuts.len() <= 200, "{}", cuts.len());
    let mut table = csv::Reader::from_path(here.path().join("with/edges.csv")).expect("a table");
    let header = table.headers().expect("names").clone();
    let column = |name: &str| header.iter().position(|other| other == name).expect("a column");
    let rows: Vec<(String, f64)> = table
        .records()
        .map(|row| row.expect("a row"))
        .map(|row| (row[column("origin")].to_owned(), row[column("probability")].parse().unwrap_or(f64::NAN)))
        .collect();
    let is_doubtful = |p: f64| (0.02..=0.98).contains(&p);
    for cut in cuts {
        let (origin, p) = &rows[cut["vessel"].as_u64().expect("a row") as usize];
        assert!(origin != "observed" && is_doubtful(*p), "{origin} {p}");
        let pixels = STANDARD.decode(cut["pixels"].as_str().expect("text")).expect("base64");
        assert_eq!(pixels.len(), ACROSS * (ALONG + 2 * ACROSS));
    }
    // Contacts may have no length, and then no course to look along.
    let doubtful = |kind: &str| rows.iter().filter(|(origin, p)| origin == kind && is_doubtful(*p)).count();
    let shown = |kind: &str| cuts.iter().filter(|cut| rows[cut["vessel"].as_u64().unwrap_or(0) as usize].0 == kind).count();
    assert!(shown("candidate") == doubtful("candidate") && shown("contact") <= doubtful("contact"));
    let names: Vec<String> = fs::read_dir(here.path().join("with"))
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    assert!(names.iter().all(|name| !name.contains(".nii")), "{names:?}");
}

#[test]
fn a_straightened_picture_shows_a_bent_vessel_as_a_straight_one() {
    // A quarter of a circle of 12 mm; black-blood images show the same vessel dark.
    let turn = |n: i32| std::f64::consts::FRAC_PI_2 * f64::from(n) / 60.0;
    let arc: Vec<[f64; 3]> = (0..=60).map(|n| [6.0 + 12.0 * turn(n).cos(), 6.0 + 12.0 * turn(n).sin(), 10.0]).collect();
    let near = |p: [f64; 3]| {
        // A second, straight one lies far off.
        let second = (-0.5 * ((p[1] - 2.0).powi(2) + (p[2] - 2.0).powi(2)) / 0.49).exp();
        let (off, inner) = ((p[0] - 6.0).hypot(p[1] - 6.0) - 12.0, p[0] >= 6.0 && p[1] >= 6.0);
        second + if inner { (-0.5 * (off.powi(2) + (p[2] - 10.0).powi(2)) / 0.49).exp() } else { 0.0 }
    };
    let bright = drawn([45, 45, 41], |p| ripple(p) + near(p));
    let dark = drawn([45, 45, 41], |p| ripple(p) - near(p));
    let network = vessels(&[(arc.clone(), 0.7), (straight([1.0, 2.0, 2.0], [20.0, 2.0, 2.0], 40), 0.7)]);
    let extraction = Extraction::new(&network, &[]).expect("points");
    for (image, appearance, inside) in [(bright, Appearance::Bright, 191), (dark, Appearance::Dark, 64)] {
        let Ok(scene) = Scene::new(&extraction.centerlines(), View { image, appearance }) else { panic!("not shown") };
        let path: Vec<[f64; 3]> = arc[12..=48].iter().map(|p| p.map(|x| x / 1e3)).collect();
        let strip = Strip::new(&scene, &path, 0.7e-3).expect("pictures");
        let pixel = |row: usize, column: usize| i32::from(strip.pixels[row * ALONG + column]);
        for column in 0..ALONG {
            let middle = pixel(ACROSS / 2, column);
            assert!((middle - inside).abs() < 30, "{appearance:?} {column}: {middle}");
            // The background is a quarter of the way from black to white, or from white to black.
            let background = if inside > 128 { 64 } else { 191 };
            assert!((pixel(0, column) - background).abs() < 30, "{appearance:?} {column}: {}", pixel(0, column));
        }
        let across = &strip.pixels[ACROSS * ALONG..][..ACROSS * ACROSS];
        let middle = i32::from(across[ACROSS * ACROSS / 2]);
        assert!((middle - inside).abs() < 30, "{middle}");
    }
    // Points in one place have no course.
    let scene = Scene::new(
        &extraction.centerlines(),
        View { image: drawn([45, 45, 41], |p| ripple(p) + near(p)), appearance: Appearance::Bright },
    );
    let scene = scene.map_err(|why| why.to_string()).expect("it shows the vessels");
    assert_eq!(Strip::new(&scene, &[[0.0; 3], [0.0; 3]], 1e-3), None);
    assert_eq!(Strip::new(&scene, &[], 1e-3), None);
}

#[test]
fn probabilities_are_looked_at_in_place_of_an_image_and_may_be_the_only_input() {
    let here = folder();
    let (_, image) = scan(here.path());
    // What a segmenter would say: certain far from its threshold.
    let mut sorted = image.values.clone();
    sorted.sort_by(f32::total_cmp);
    let (low, high) = (sorted[sorted.len() / 2], sorted[sorted.len() - 200]);
    let share = |x: f32| 1.0 / (1.0 + (-12.0 * ((x - low) / (high - low) - 0.4)).exp());
    let map = Image { values: image.values.iter().map(|x| share(*x)).collect(), ..image.clone() };
    written(here.path(), "p.nii", &map);
    infer(here.path(), "plain", &[]);
    infer(here.path(), "with", &["--probability", "p.nii"]);
    assert!(edges(here.path(), "plain") != edges(here.path(), "with"));
    let record: Value = serde_json::from_slice(&fs::read(here.path().join("with/run.json")).expect("a record")).expect("JSON");
    let record = &record["parameters"]["image"];
    assert!(record["path"] == "p.nii" && record["probabilities"] == true && record["unused"].is_null(), "{record}");

    let alone = ["infer", "p.nii", "--level", "0.5", "--probability", "p.nii", "-o", "alone", "-n", "1"];
    let done = willis(here.path(), &alone);
    assert!(done.status.success() && here.path().join("alone/edges.csv").exists(), "{}", stderr(&done));

    let refused = |more: &[&str], said: &[&str]| {
        let done = willis(here.path(), &[&["infer", "scan.nii.gz", "-o", "no"], more].concat());
        let all = stderr(&done);
        assert!(done.status.code() == Some(2) && said.iter().all(|part| all.contains(part)), "{all}");
        assert!(!here.path().join("no").exists());
    };
    written(here.path(), "three.nii", &Image { values: map.values.iter().map(|x| 3.0 * x).collect(), ..map.clone() });
    refused(&["--probability", "three.nii"], &["three.nii", "a voxel", "expected probabilities from 0 to 1"]);
    refused(&["--probability", "p.nii", "--image", "image.nii"], &["--probability", "--image"]);
    refused(&["--probability", "p.nii", "--vessels", "dark"], &["--probability", "--vessels"]);
}
