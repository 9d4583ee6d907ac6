//! What comes out beside an image: the cubes on the page; and probabilities in place of an image.

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use willis::internals::masks::cubes::{ImageCube, SIDE, STEP};
use willis::internals::masks::{Appearance, Image, Scene, View};

use crate::command::{folder, stderr, willis};
use crate::extracted::extracted;
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
fn the_page_has_the_image_around_doubtful_vessels_and_nothing_else_of_it() {
    let here = folder();
    let (_, image) = scan(here.path());
    infer(here.path(), "plain", &[]);
    infer(here.path(), "with", &["--image", "image.nii"]);
    assert_eq!(page(here.path(), "plain")["image_places"]["of"], Value::Array(Vec::new()));
    let data = page(here.path(), "with");
    let places = data["image_places"]["of"].as_array().expect("a list");
    assert!(!places.is_empty() && places.len() <= 50, "{}", places.len());
    let mut table = csv::Reader::from_path(here.path().join("with/edges.csv")).expect("a table");
    let header = table.headers().expect("names").clone();
    let column = |name: &str| header.iter().position(|other| other == name).expect("a column");
    let rows: Vec<(String, f64)> = table
        .records()
        .map(|row| row.expect("a row"))
        .map(|row| (row[column("origin")].to_owned(), row[column("probability")].parse().unwrap_or(f64::NAN)))
        .collect();
    // Another number of them is the first of these, or more; the page grows by what is said.
    let few =
        willis(here.path(), &["infer", "scan.nii.gz", "--image", "image.nii", "--image-places", "1", "-o", "few", "-n", "1"]);
    assert!(stderr(&few).contains("the page holds the image at 1 of the doubtful places: 0.1 MB"), "{}", stderr(&few));
    let first = page(here.path(), "few");
    let first = first["image_places"]["of"].as_array().expect("a list");
    assert_eq!((first.len(), &first[0]["samples"]), (1, &places[0]["samples"]));
    assert!(places.len() > 1 && edges(here.path(), "few") == edges(here.path(), "with"));
    infer(here.path(), "more", &["--image", "image.nii", "--image-places", "5000"]);
    assert!(page(here.path(), "more")["image_places"]["of"].as_array().expect("a list").len() >= places.len());
    let refused = willis(here.path(), &["infer", "scan.nii.gz", "--image-places", "3", "-o", "no"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("goes with --image or --probability"), "{}", stderr(&refused));
    let is_doubtful = |row: &usize| (0.02..=0.98).contains(&rows[*row].1) && rows[*row].0 != "observed";
    let mut shown = Vec::new();
    for place in places {
        let vessels = place["vessels"].as_array().expect("rows").iter().map(|row| row.as_u64().expect("a row") as usize);
        shown.extend(vessels);
        // The image itself at the nearest voxel goes up and down with it (Pearson), where the cube lies in the image.
        let number = |key: &str, at: usize| place[key][at].as_f64().expect("a number");
        let samples = STANDARD.decode(place["samples"].as_str().expect("text")).expect("base64");
        assert_eq!(samples.len(), SIDE * SIDE * SIDE);
        let voxel = |n: usize| {
            let at = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)];
            let index = [0, 1, 2].map(|k| {
                let place = number("centre", k) + 1e3 * (at[k] as f64 - 19.5) * STEP;
                ((place - image.affine[k][3]) / image.affine[k][k]).round()
            });
            let inside = (0..3).all(|k| index[k] >= 0.0 && index[k] < image.shape[k] as f64);
            inside.then(|| index.map(|x| x as usize)).map(|[x, y, z]| image.values[x + image.shape[0] * (y + image.shape[1] * z)])
        };
        let pairs = samples.iter().enumerate().filter(|(_, sample)| **sample > 0);
        let pairs: Vec<[f64; 2]> = pairs.filter_map(|(n, sample)| Some([f64::from(*sample), f64::from(voxel(n)?)])).collect();
        let mean = [0, 1].map(|k| pairs.iter().map(|pair| pair[k]).sum::<f64>() / pairs.len() as f64);
        let moment = |a: usize, b: usize| pairs.iter().map(|pair| (pair[a] - mean[a]) * (pair[b] - mean[b])).sum::<f64>();
        let correlation = moment(0, 1) / (moment(0, 0) * moment(1, 1)).sqrt();
        assert!(pairs.len() > 10_000 && correlation > 0.6, "{} {correlation}", pairs.len());
    }
    shown.sort_unstable();
    let doubtful: Vec<usize> = (0..rows.len()).filter(is_doubtful).collect();
    assert!(places.len() == 50 || shown == doubtful, "{shown:?} {doubtful:?}");
    let names: Vec<String> = fs::read_dir(here.path().join("with"))
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    assert!(names.iter().all(|name| !name.contains(".nii")), "{names:?}");
}

#[test]
fn a_cube_shows_a_vessel_where_it_is_and_as_bright_or_dark_as_it_is() {
    // A straight vessel along x at y = 20 mm, z = 20 mm, and a second one far off.
    let near = |p: [f64; 3]| {
        let vessel = |y: f64, z: f64| (-0.5 * ((p[1] - y).powi(2) + (p[2] - z).powi(2)) / 0.49).exp();
        vessel(20.0, 20.0) + vessel(4.0, 4.0)
    };
    let bright = drawn([45, 45, 41], |p| ripple(p) + near(p));
    let dark = drawn([45, 45, 41], |p| ripple(p) - near(p));
    let lines = [straight([2.0, 20.0, 20.0], [38.0, 20.0, 20.0], 80), straight([2.0, 4.0, 4.0], [38.0, 4.0, 4.0], 80)];
    let extraction = extracted(&vessels(&lines.map(|line| (line, 0.7))), &[]).expect("points");
    for (image, appearance) in [(bright, Appearance::Bright), (dark, Appearance::Dark)] {
        let Ok(scene) = Scene::new(&extraction.centerlines(), View { image, appearance }) else { panic!("not shown") };
        let cube = ImageCube::new(&scene, [0.0203, 0.0203, 0.0203]).expect("a cube");
        // y = 20 mm lies half a sample below the middle.
        let at = |y: usize| f64::from(cube.samples[20 + SIDE * (y + SIDE * 19)]);
        let value = |sample: f64| cube.held[0] + (sample - 1.0) / 254.0 * (cube.held[1] - cube.held[0]);
        let share = |y: usize| (value(at(y)) - cube.shown[0]) / (cube.shown[1] - cube.shown[0]);
        let (inside, outside) = if cube.is_dark { (0.25, 0.75) } else { (0.75, 0.25) };
        assert_eq!(cube.is_dark, appearance == Appearance::Dark);
        assert!((share(19) - inside).abs() < 0.12 && (share(12) - outside).abs() < 0.12, "{} {}", share(19), share(12));
        assert_eq!(ImageCube::new(&scene, [1.0; 3]), None);
    }
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
