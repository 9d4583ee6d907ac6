//! Masks of phantoms: volumes and contacts against hand values, breaks against the components of the mask, the skeleton against the
//! anatomy, the file against nibabel.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::command::{folder, stderr, willis};
use crate::peers::python;
use crate::refused::{contents, refused};
use petgraph::unionfind::UnionFind;
use willis::internals::formats::{Format, ReadOptions, write_nifti};
use willis::internals::masks::{Cavities, Mask, RadiusFrom, trace};
use willis::internals::network::{Network, Node, PathPoint, RadiusRule, Vessel};
use willis::internals::phantom::{Anatomy, MaskTruth, Recipe, Scan, draw_mask};
use willis::internals::support::geometry::{Point, distance, lerp};

/// Straight vessels of a radius between two places each, mm; those that end at one place share a node.
fn straight(vessels: &[(Point, Point, f64)]) -> Network {
    let mut network = Network::new();
    for (a, b, radius) in vessels {
        let ends = [a, b].map(|at| {
            let position = Some(at.map(|x| x * 1e-3));
            let known = (0..network.node_count()).find(|row| network.node(*row).position == position);
            known.unwrap_or_else(|| {
                let id = network.node_count().to_string();
                network.add_node(Node { id, position, ..Node::default() })
            })
        });
        let path = [a, b].map(|at| PathPoint { position: at.map(|x| x * 1e-3), radius: radius * 1e-3, id: None });
        network.add_vessel(ends, Vessel::along(path.to_vec(), RadiusRule::Mean));
    }
    network
}

fn anatomy(kind: Anatomy) -> Network {
    kind.network(&Recipe::default()).expect("anatomy")
}

fn count(mask: &Mask) -> usize {
    mask.classes.iter().filter(|class| **class > 0).count()
}

/// The volume of a cylinder, whatever its direction, with and without blur: half the signal lies at its wall.
#[test]
fn a_drawn_tube_has_the_volume_of_its_cylinder() {
    let sharp = Scan { slow: 0.0, field: 0.0, noise: 0.0, threshold: 0.5, veins: 0.0, ..Scan::default() };
    // Along an axis every layer of voxels has the same share of the circle: slanting tubes have the mean of all shares.
    for (end, radius) in [([3.0, -2.0, 30.0], 2.0), ([17.0, 9.0, 23.0], 2.0), ([-20.0, 11.0, 7.0], 1.2)] {
        let network = straight(&[([0.0; 3], end, radius)]);
        let truth = std::f64::consts::PI * radius * radius * distance([0.0; 3], end);
        for scan in [None, Some(&sharp)] {
            let (mask, _) = draw_mask(&network, 0.25e-3, scan).expect("a mask");
            let volume = count(&mask) as f64 * mask.voxel_volume();
            assert!((volume / truth - 1.0).abs() < 0.02, "{end:?} {scan:?}: {volume} {truth}");
        }
    }
}

/// Two tubes that cross at a right angle above (0, 0): they touch where the space between their walls is less than a voxel.
#[test]
fn vessels_touch_where_their_walls_meet() {
    let crossing = |apart: f64| {
        let a = ([-15.0, 0.0, 0.0], [15.0, 0.0, 0.0], 1.5);
        let b = ([0.0, -15.0, apart], [0.0, 15.0, apart], 1.0);
        draw_mask(&straight(&[a, b]), 0.5e-3, None).expect("a mask").1
    };
    for apart in [2.2, 2.45] {
        let truth = crossing(apart);
        assert_eq!((truth.contacts.len(), truth.breaks.len()), (1, 0), "{apart}");
        let contact = &truth.contacts[0];
        assert_eq!(contact.vessels, [0, 1]);
        assert!(distance(contact.position_mm, [0.0, 0.0, 1.35]) < 1.0, "{:?}", contact.position_mm);
    }
    assert!(crossing(4.0).contacts.is_empty());
    // Joined vessels touch at their junction, which is no contact.
    let middle = [0.0; 3];
    let fork = [([-15.0, 0.0, 0.0], middle, 1.5), (middle, [15.0, 3.0, 0.0], 1.0), (middle, [13.0, -9.0, 2.0], 1.2)];
    let truth = draw_mask(&straight(&fork), 0.5e-3, None).expect("a mask").1;
    assert!(truth.contacts.is_empty(), "{:?}", truth.contacts);
}

/// The number of 26-connected components, by union of neighbours.
fn components(mask: &Mask) -> usize {
    let [x, y, _] = mask.shape;
    let rows: Vec<usize> = (0..mask.classes.len()).filter(|row| mask.classes[*row] > 0).collect();
    let mut joined = UnionFind::<usize>::new(rows.len());
    let mut parts = rows.len();
    for (n, row) in rows.iter().enumerate() {
        for step in [1, x - 1, x, x + 1, x * y - x - 1, x * y - x, x * y - x + 1, x * y - 1, x * y, x * y + 1]
            .into_iter()
            .chain([x * y + x - 1, x * y + x, x * y + x + 1])
        {
            if let Ok(m) = rows.binary_search(&(row + step)) {
                parts -= usize::from(joined.union(n, m));
            }
        }
    }
    parts
}

/// The voxel in which a place lies.
fn row(mask: &Mask, place: Point) -> usize {
    let at = [0, 1, 2].map(|axis| ((place[axis] - mask.affine[axis][3]) / mask.affine[axis][axis]).round() as usize);
    (at[2] * mask.shape[1] + at[1]) * mask.shape[0] + at[0]
}

/// Sets the voxels of a straight line.
fn join(mask: &mut Mask, ends: [Point; 2]) {
    for step in 0..=1000 {
        let at = row(mask, lerp(ends[0], ends[1], f64::from(step) / 1000.0));
        mask.classes[at] = 1;
    }
}

fn scans(kind: Anatomy, seeds: std::ops::Range<u64>, check: impl Fn(&Network, Mask, MaskTruth)) {
    let network = anatomy(kind);
    for seed in seeds {
        let scan = Scan { seed, veins: 0.0, ..Scan::default() };
        let (mask, truth) = draw_mask(&network, 0.7e-3, Some(&scan)).expect("a mask");
        check(&network, mask, truth);
    }
}

/// A tree falls into one piece more with every break. Where the two ends of every break are joined, one piece is left.
#[test]
fn breaks_are_where_the_mask_falls_apart() {
    let total = std::cell::Cell::new(0);
    for kind in [Anatomy::Tree, Anatomy::Cerebral] {
        scans(kind, 0..4, |_, mut mask, truth| {
            for gap in &truth.breaks {
                let tube = &truth.tubes[gap.vessel];
                let inside = tube
                    .arc()
                    .into_iter()
                    .zip(&tube.stations)
                    .filter(|(arc, _)| (gap.from_mm + 1e-6..gap.to_mm - 1e-6).contains(arc));
                assert!(inside.clone().all(|(_, at)| mask.classes[row(&mask, *at)] == 0), "{gap:?}");
                assert!(inside.count() > 0 && gap.ends_mm.iter().all(|at| mask.classes[row(&mask, *at)] == 1), "{gap:?}");
            }
            let found = components(&mask);
            if kind == Anatomy::Tree && truth.contacts.is_empty() {
                assert_eq!(found, truth.breaks.len() + 1);
            }
            truth.breaks.iter().for_each(|gap| join(&mut mask, gap.ends_mm));
            assert_eq!(components(&mask), 1, "{:?}", truth.breaks);
            total.set(total.get() + truth.breaks.len());
        });
    }
    assert!(total.get() >= 8, "{} breaks", total.get());
}

#[test]
fn the_skeleton_of_a_clean_mask_is_the_anatomy() {
    let network = anatomy(Anatomy::Cerebral);
    let (mask, truth) = draw_mask(&network, 0.5e-3, None).expect("a mask");
    assert!(truth.breaks.is_empty() && truth.contacts.is_empty() && truth.lost.is_empty());
    let lines = trace(&mask, RadiusFrom::Area, Cavities::Fill).expect("lines").lines;
    let mut joined = UnionFind::<u32>::new(lines.points.len());
    let united = lines.links.iter().filter(|[a, b]| joined.union(*a, *b)).count();
    assert_eq!(lines.points.len() - united, 1, "components");
    assert_eq!(lines.links.len() - united, 1, "loops");
    let stations: Vec<(Point, f64)> =
        truth.tubes.iter().flat_map(|tube| tube.stations.iter().copied().zip(tube.radii.iter().copied())).collect();
    let nodes: Vec<(Point, f64)> = network
        .nodes()
        .map(|node| (node.position.expect("a place").map(|x| x * 1e3), node.radius.expect("wide") * 1e3))
        .collect();
    let mut along = 0;
    for point in &lines.points {
        let at = point.map(|x| x * 1e3);
        let (away, radius) = stations
            .iter()
            .map(|(place, radius)| (distance(at, *place), *radius))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("stations");
        // In the lumen of a junction the lines of several vessels go over into one.
        let is_at_junction = nodes.iter().any(|(place, radius)| distance(at, *place) < 2.0 * radius + 1.0);
        along += usize::from(!is_at_junction);
        // Elsewhere they are within a voxel of the axis.
        assert!(away < if is_at_junction { radius } else { 0.6 }, "{at:?}: {away}");
    }
    assert!(along > lines.points.len() / 2, "{along}");
    // Thinning takes the ends of vessels.
    let degree = network.degrees(|_| true);
    let is_end = |place: Point| nodes.iter().zip(&degree).any(|((at, _), n)| *n == 1 && distance(*at, place) < 5.0);
    for (place, radius) in stations.iter().filter(|(place, _)| !is_end(*place)) {
        let nearest = lines.points.iter().map(|point| distance(point.map(|x| x * 1e3), *place)).fold(f64::MAX, f64::min);
        assert!(nearest < radius + 1.0, "{place:?}: {nearest}");
    }
}

#[test]
fn a_seed_gives_the_same_files_at_any_thread_count_and_another_seed_others() {
    let here = folder();
    let mut files = Vec::new();
    for (folder, seed, threads) in [("a", "3", "1"), ("b", "3", "3"), ("c", "4", "1")] {
        fs::create_dir(here.path().join(folder)).expect("made");
        let name = format!("{folder}/scan.nii.gz");
        let arguments =
            ["phantom", "cerebral", "--break", "--seed", seed, "--spacing", "1", "--threads", threads, "-o", &name, "-q"];
        let output = willis(here.path(), &arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        files.push(contents(&here.path().join(folder)));
    }
    let names: Vec<&Path> = files[0].iter().map(|(name, _)| name.as_path()).collect();
    assert_eq!(names, ["scan.landmarks.csv", "scan.nii.gz", "scan.truth.json"].map(Path::new));
    assert_eq!(files[0], files[1]);
    assert!(files[0][1] != files[2][1] && files[0][2] != files[2][2]);
    let truth: serde_json::Value = serde_json::from_slice(&files[0][2].1).expect("JSON");
    let keys: BTreeSet<&str> = truth.as_object().expect("an object").keys().map(String::as_str).collect();
    let documented =
        ["vessels", "lost_vessels", "spurious_vessels", "voxel_mm", "inlets_mm", "breaks", "contacts", "centerlines"];
    assert_eq!(keys, BTreeSet::from(documented));
    assert_eq!(truth["vessels"].as_array().map(Vec::len), truth["centerlines"].as_array().map(Vec::len));
}

const NIBABEL: &str = r#"
import sys, hashlib, numpy as np, nibabel as nib
for path in sys.argv[1:]:
    image = nib.load(path)
    data = np.asanyarray(image.dataobj)
    assert data.dtype == np.uint8 and image.header.get_xyzt_units()[0] == "mm" and image.get_sform(coded=True)[1] == 1
    q, code = image.get_qform(coded=True)
    assert code == 0 or np.allclose(q, image.affine, atol=1e-4)
    zooms = " ".join(repr(float(x)) for x in image.header.get_zooms())
    print(*data.shape, zooms, *[repr(float(x)) for x in image.affine[:3].ravel()], hashlib.sha256(data.tobytes(order="F")).hexdigest())
"#;

#[test]
fn our_reader_and_nibabel_read_what_is_written() {
    let folder = folder();
    let (straight, _) = draw_mask(&anatomy(Anatomy::Cerebral), 1.1e-3, None).expect("a mask");
    let turned = [[0.0, -0.5, 0.125, 10.0], [0.75, 0.0, 0.25, -20.5], [0.0, 0.25, 1.5, 30.25]];
    let oblique = Mask::new([2, 3, 4], (0..24).map(|n| u8::from(n % 5 == 0) * 7).collect(), turned);
    let masks = [("a.nii.gz", &straight), ("a.nii", &straight), ("b.nii.gz", &oblique), ("b.nii", &oblique)];
    let mut paths = Vec::new();
    for (name, mask) in masks {
        let mut bytes = Vec::new();
        write_nifti(&mut bytes, mask, name.contains("gz")).expect("written");
        let found = Format::Nifti.read_mask(Path::new(name), &bytes, &ReadOptions::default()).expect("read");
        assert_eq!((found.shape, found.affine, &found.classes), (mask.shape, mask.affine, &mask.classes), "{name}");
        fs::write(folder.path().join(name), bytes).expect("written");
        paths.push(folder.path().join(name));
    }
    let long = Mask::new([40_000, 1, 1], vec![1; 40_000], turned);
    assert!(write_nifti(Vec::new(), &long, false).expect_err("too long").to_string().contains("40000 voxels along an axis"));
    let paths: Vec<&Path> = paths.iter().map(std::path::PathBuf::as_path).collect();
    let Some(said) = python(NIBABEL, &paths) else { return };
    for (line, (name, mask)) in said.lines().zip(masks) {
        let words: Vec<&str> = line.split(' ').collect();
        let numbers: Vec<f64> = words[..18].iter().map(|word| word.parse().expect("a number")).collect();
        assert_eq!(numbers[..3], mask.shape.map(|n| n as f64), "{name}");
        assert!(numbers[3..6].iter().zip(mask.spacing()).all(|(a, b)| (a - b).abs() < 1e-6), "{name}");
        assert_eq!(numbers[6..], *mask.affine.as_flattened(), "{name}");
        assert_eq!(words[18], willis::internals::formats::checksum(&mask.classes), "{name}");
    }
    assert_eq!(said.lines().count(), 4);
}

#[test]
fn masks_that_cannot_be_are_refused() {
    let cases: [(&[&str], &[&str]); 6] = [
        (&["cerebral", "-o", "a.mha"], &["a.mha", ".nii.gz or .nii for a mask", ".graphml"]),
        (&["cerebral", "-o", "a.gz"], &["a.gz", ".nii.gz"]),
        (&["cerebral", "-o", "a.nii.gz", "--spacing", "0.01"], &["--spacing 0.01", "too small", "at most 268435456 voxels"]),
        (&["cerebral", "-o", "a.nii.gz", "--spacing", "0.00001"], &["--spacing 0.00001", "expected 0.0001 to 100 mm"]),
        (&["cerebral", "-o", "a.nii", "--spacing", "1m"], &["--spacing 1000 mm", "expected 0.0001 to 100 mm"]),
        (&["cerebral", "-o", "a.nii", "--seed", "1"], &["--seed 1", "always the same"]),
    ];
    for (arguments, words) in cases {
        refused(&[], &[&["phantom"], arguments].concat(), words);
    }
    for standing in ["a.nii.gz", "a.truth.json", "a.landmarks.csv"] {
        let arguments = ["phantom", "cerebral", "--break", "--spacing", "2", "-o", "a.nii.gz"];
        refused(&[(standing, b"precious")], &arguments, &[standing, "--force"]);
    }
    let network = anatomy(Anatomy::Cerebral);
    let nothing = Scan { slow: 10.0, ..Scan::default() };
    assert!(draw_mask(&network, 1e-3, Some(&nothing)).unwrap_err().to_string().contains("leaves no vessel in the mask"));
}
