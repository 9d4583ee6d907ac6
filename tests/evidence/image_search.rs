//! What the image adds where shape ends: vessels met far round a corner, and the dip between two lumens that touch.

use willis::internals::candidates::joins::image::ways::Ahead;
use willis::internals::candidates::search::{SearchOptions, search};
use willis::internals::contacts::{Basis, branches::Branches, features::pairs_among, pair_features};
use willis::internals::masks::scene::Bits;
use willis::internals::masks::{Appearance, Field, Foreground, Image, Mask, Picture, ScanCenterlines, Scene, View};
use willis::internals::network::{Network, Node, PathPoint, RadiusRule, Vessel, metres};
use willis::internals::support::geometry::{Point, distance, norm};

use crate::extracted::extracted;
use crate::images::{drawn, ripple};
use crate::joins::{straight, vessels};

#[test]
fn a_vessel_round_a_corner_is_met_and_no_other_lumen_is_passed() {
    // Two vessels side by side, 12 mm apart, that the image joins by half a circle beyond their ends.
    let turn = |n: i32| std::f64::consts::PI * f64::from(n) / 200.0;
    let arc: Vec<Point> = (0..=200).map(|n| [20.0 + 6.0 * turn(n).sin(), 21.0 - 6.0 * turn(n).cos(), 15.0]).collect();
    let ends = [arc[0], arc[200]];
    let lines = ends.map(|end| (straight([2.0, end[1], 15.0], end, 30), 0.6));
    let on_lines: Vec<Point> = lines.iter().flat_map(|(points, _)| straight(points[0], points[30], 300)).collect();
    let image = drawn([61, 81, 61], |p| {
        let near = arc.iter().chain(&on_lines).map(|q| distance(*q, p)).fold(f64::INFINITY, f64::min);
        ripple(p) + (-0.5 * (near / 0.6).powi(2)).exp()
    });
    let met = |lines: &[(Vec<Point>, f64)]| {
        let extraction = extracted(&vessels(lines), &[]).expect("points");
        let view = View { image: image.clone(), appearance: Appearance::Auto };
        let scene = Scene::new(&extraction.centerlines(), view).expect("it shows the vessels");
        let ahead = Ahead::new(&scene, &extraction);
        let place = |point: usize| extraction.position[point].map(|x| 1e3 * x);
        let from = extraction.ends.iter().position(|end| distance(place(end.point), ends[0]) < 1e-6).expect("an end");
        let met: Vec<(Point, Vec<Point>)> =
            ahead.met[from].iter().map(|met| (place(met.point), met.path.iter().map(|p| p.map(|x| 1e3 * x)).collect())).collect();
        let found = search(&extraction, &SearchOptions::default()).expect("candidates");
        let known = found.iter().any(|c| c.end == from && distance(place(c.point), ends[1]) < 1.0);
        let is_new =
            ahead.candidates(&extraction, &found).iter().any(|(c, _)| c.end == from && distance(place(c.point), ends[1]) < 1.0);
        (met, known || is_new)
    };
    let (of_two, is_candidate) = met(&lines);
    let (point, path) = of_two.first().expect("a vessel");
    assert!(distance(*point, ends[1]) < 1e-6 && is_candidate, "{point:?}");
    let off = |p: &Point| arc.iter().map(|q| distance(*q, *p)).fold(f64::INFINITY, f64::min);
    let most = path.iter().map(off).fold(0.0, f64::max);
    assert!(most < 0.7, "{most} mm from the half circle");
    let length: f64 = path.windows(2).map(|w| distance(w[0], w[1])).sum();
    assert!((length / (6.0 * std::f64::consts::PI) - 1.0).abs() < 0.1, "{length} mm");

    // A third vessel across the half circle is met first; the way on does not lead through it.
    let third = (straight([26.0, 21.0, 5.0], [26.0, 21.0, 25.0], 30), 0.6);
    let (of_three, _) = met(&[lines[0].clone(), lines[1].clone(), third]);
    let (point, _) = of_three.first().expect("a vessel");
    assert!(distance(*point, [26.0, 21.0, 15.0]) < 1.0, "{point:?}");
    for (_, path) in of_three.iter().filter(|(point, _)| distance(*point, ends[1]) < 1.0) {
        let nearest = path.iter().map(|p| (p[0] - 26.0).hypot(p[1] - 21.0)).fold(f64::INFINITY, f64::min);
        assert!(nearest > 0.6, "{nearest} mm from the axis");
    }
}

#[test]
fn between_two_lumens_that_touch_the_image_has_a_dip() {
    // Two vessels cross 1.9 mm above one another, so near that a threshold makes them one; the skeleton meets halfway.
    let (gap, middle) = (1.9, 12.0);
    let profile = |d: f64| (-0.5 * (d / 0.6).powi(2)).exp();
    let value = |p: Point| {
        let first = (p[1] - middle).hypot(p[2] - middle);
        let second = (p[0] - middle).hypot(p[2] - middle - gap);
        profile(first) + profile(second)
    };
    let image = drawn([49, 49, 53], |p| ripple(p) + value(p));
    let classes = image.values.iter().map(|x| u8::from(*x > 0.35)).collect();
    let Image { shape, affine, .. } = image.clone();
    let mask = Mask::new(shape, classes, affine);
    let field = Field::of(&Foreground::of(&mask).expect("vessels"));
    let up = middle + 0.5 * gap;
    let ends = [[2.0, middle, middle], [22.0, middle, middle], [middle, 2.0, middle + gap], [middle, 22.0, middle + gap]];
    let near = [[9.0, middle, middle], [15.0, middle, middle], [middle, 9.0, middle + gap], [middle, 15.0, middle + gap]];
    let mut network = Network::new();
    let node = |network: &mut Network, p: Point| {
        let id = network.node_count().to_string();
        network.add_node(Node { id, position: Some(p.map(|x| x / 1e3)), radius: Some(8e-4), ..Node::default() })
    };
    let centre = node(&mut network, [middle, middle, up]);
    for (end, near) in ends.into_iter().zip(near) {
        let far = node(&mut network, end);
        let points = [straight([middle, middle, up], near, 6), straight(near, end, 14)[1..].to_vec()].concat();
        let path = points.iter().map(|p| PathPoint { position: p.map(|x| x / 1e3), radius: 8e-4, id: None }).collect();
        network.add_vessel([centre, far], Vessel::along(path, RadiusRule::Mean));
    }
    let extraction = extracted(&network, &[]).expect("points");
    let scene =
        Scene::new(&extraction.centerlines(), View { image, appearance: Appearance::Auto }).expect("it shows the vessels");
    // The image is averaged with a Gaussian of half a step. On an axis the other vessel adds a little, halfway both are as bright.
    let wide = 0.36 + (0.5e3 * extraction.spacing).powi(2);
    let of_both = |d: f64, e: f64| (-0.5 * d * d / wide).exp() + (-0.5 * e * e / wide).exp();
    let halfway = of_both(0.5 * gap, 0.5 * gap) / of_both(0.0, gap);
    assert!(halfway < 0.8, "{halfway}");
    let branches = Branches::new(&network);
    let features = pair_features(&branches, Some(&field), Some(&scene));
    let names = Basis::Image.feature_names();
    assert_eq!(features.dim(), (6, names.len()));
    let column = |name: &str| names.iter().position(|other| other == name).expect("a feature");
    // The branches were added in the order of their ends: the first two are one vessel, and so are the last two.
    let cluster = &branches.clusters[0];
    let vessel = |end: usize| cluster.ends[end].branch / 2;
    for (row, pair) in pairs_among(cluster.ends.len()).enumerate() {
        let of = |name: &str| f64::from(features[[row, column(name)]]);
        let is_one = vessel(pair[0]) == vessel(pair[1]);
        let (saddle, dip) = (of("image_saddle"), of("image_dip"));
        let expected = if is_one { 1.0 } else { halfway };
        assert!((saddle - expected).abs() < 0.1, "{pair:?}: saddle {saddle}");
        assert!(if is_one { dip < 0.1 } else { dip > 0.15 }, "{pair:?}: dip {dip}");
        assert!(of("image_ratio") < 0.1, "both are as bright");
    }
}

#[test]
fn lumens_are_the_voxels_near_points() {
    // Voxels of 0.5 x 0.7 x 0.9 mm, the axes turned and one of them oblique.
    let affine = [[0.0, 0.7, 0.1, -4.0], [-0.5, 0.0, 0.0, 3.0], [0.0, 0.0, 0.9, 1.0]];
    let shape = [70, 13, 11];
    let image = Image { shape, values: vec![1.0; shape.iter().product()], affine };
    let picture = Picture::of(image, [[-1.0; 3], [1.0; 3]], 1e-6).expect("the box is in the image");
    let position = [[0.1e-3, -8e-3, 4e-3], [-3e-3, -20e-3, 8e-3], [2.03e-3, 2.01e-3, 1.04e-3], [40e-3, 0.0, 0.0]];
    let radius = [1.1e-3, 2.6e-3, 0.9e-3, 1e-3];
    let e = ScanCenterlines { position: &position, radius: &radius, lines: &[], spacing: 1e-3 };
    let bits = Bits::around(&picture, &e, 0.2e-3);
    let mut inside = 0;
    for z in 0..shape[2] {
        for y in 0..shape[1] {
            for x in 0..shape[0] {
                let index = [x, y, z].map(|index| index as f64);
                let at = affine.map(|row| metres(row[3] + (0..3).map(|axis| row[axis] * index[axis]).sum::<f64>()));
                let apart = |p: &Point| [0, 1, 2].map(|k| p[k] - at[k]);
                let near = position.iter().zip(&radius).any(|(p, r)| norm(apart(p)) <= r + 0.2e-3);
                let row = picture.row(picture.index(at).map(|index| index.round() as usize));
                assert_eq!(bits.has(row), near, "{x} {y} {z}");
                inside += usize::from(near);
            }
        }
    }
    assert!((50..1000).contains(&inside), "{inside}");
}
