//! What is measured of vessels: closed forms (line, cone, circle, helix, a bifurcation), trees by hand, and what must change nothing.

use std::f64::consts::PI;
use std::fmt::Write as _;

use willis::internals::masks::{Cavities, Mask, RadiusFrom, trace};
use willis::internals::morphometry::{MeasureContext, MeasuredVessel, Morphometry, Region, Smoothing};
use willis::internals::network::{Network, RadiusRule, Role, contract};
use willis::{ReadOptions, read_bytes};

/// Lines of SWC: points in mm, a radius each, and the number of the point from which a line begins.
#[derive(Default)]
struct Swc {
    text: String,
    points: usize,
}

impl Swc {
    /// Adds a line, and gives the number of its last point.
    fn line(&mut self, points: impl IntoIterator<Item = ([f64; 3], f64)>, from: Option<usize>) -> usize {
        let mut parent = from.map_or(-1, |from| from as i64);
        for ([x, y, z], radius) in points {
            self.points += 1;
            writeln!(self.text, "{} 0 {x:.12} {y:.12} {z:.12} {radius:.12} {parent}", self.points).expect("text");
            parent = self.points as i64;
        }
        self.points
    }

    fn network(&self) -> Network {
        read_bytes("drawn.swc".as_ref(), self.text.as_bytes(), &ReadOptions::default()).expect("SWC").network
    }
}

/// Points at a parameter from 0 to 1, in so many steps.
fn curve(steps: usize, at: impl Fn(f64) -> ([f64; 3], f64)) -> Vec<([f64; 3], f64)> {
    (0..=steps).map(|i| at(i as f64 / steps as f64)).collect()
}

/// Blood enters at the node with this id.
fn measured(network: &Network, inlet: &str) -> Morphometry {
    let role = |node: usize| if network.node(node).id == inlet { Role::Inlet } else { Role::Inner };
    Morphometry::of(network, role, Smoothing::default(), MeasureContext::default())
}

fn one(points: Vec<([f64; 3], f64)>) -> Morphometry {
    let mut swc = Swc::default();
    swc.line(points, None);
    measured(&swc.network(), "1")
}

fn close(got: f64, wanted: f64, within: f64, what: &str) {
    assert!((got - wanted).abs() <= within * wanted.abs(), "{what}: {got} for {wanted}");
}

const MM: f64 = 1e-3;

#[test]
fn a_cone_has_its_volume_surface_and_taper() {
    for steps in [1, 7, 100] {
        let cone = one(curve(steps, |t| ([30.0 * t, 40.0 * t, 0.0], 2.0 - t)));
        let [vessel] = &*cone.vessels else { panic!("one vessel") };
        let shape = vessel.shape;
        close(vessel.line.length, 50.0 * MM, 1e-9, "length");
        close(shape.chord, 50.0 * MM, 1e-9, "chord");
        close(shape.radius, 1.5 * MM, 1e-9, "radius");
        close(shape.least_radius, 1.0 * MM, 1e-9, "least radius");
        close(shape.taper, 1.0 / 50.0, 1e-6, "taper");
        close(shape.volume, PI / 3.0 * 50.0 * (4.0 + 2.0 + 1.0) * MM.powi(3), 1e-9, "volume");
        close(shape.surface, PI * 3.0 * 50.0_f64.hypot(1.0) * MM.powi(2), 1e-9, "surface");
        close(shape.distance_metric, 1.0, 1e-9, "distance metric");
        close(shape.inflection_count_metric, 1.0, 1e-9, "no inflection");
        assert!(shape.curvature * MM < 1e-6 && shape.torsion == 0.0, "{shape:?}");
    }
}

#[test]
fn circles_and_helices_have_their_curvature_and_torsion_at_any_spacing() {
    for spacing in [0.25, 0.5, 1.0] {
        let turn = 1.5 * PI;
        let circle =
            one(curve((8.0 * turn / spacing) as usize, |t| ([8.0 * (turn * t).cos(), 8.0 * (turn * t).sin(), 0.0], 1.0)));
        let shape = circle.vessels[0].shape;
        close(shape.curvature * MM, 1.0 / 8.0, 0.01, "curvature of a circle");
        close(shape.sum_of_angles_metric * MM, 1.0 / 8.0, 0.01, "sum of angles of a circle");
        close(shape.distance_metric, 8.0 * turn / (8.0 * 2.0_f64.sqrt()), 0.01, "distance metric of a circle");

        let (a, b) = (5.0_f64, 2.0_f64);
        let square = a * a + b * b;
        let turn = 60.0 / square.sqrt();
        let helix = one(curve((60.0 / spacing) as usize, |t| ([a * (turn * t).cos(), a * (turn * t).sin(), b * turn * t], 0.6)));
        let shape = helix.vessels[0].shape;
        close(helix.vessels[0].line.length, 60.0 * MM, 0.01, "length of a helix");
        close(shape.curvature * MM, a / square, 0.01, "curvature of a helix");
        // The third derivative of a fit of fourth degree.
        close(shape.torsion * MM, b / square, 0.03, "torsion of a helix");
        close(shape.sum_of_angles_metric * MM, 1.0 / square.sqrt(), 0.01, "sum of angles of a helix");
        close(shape.inflection_count_metric, shape.distance_metric, 1e-12, "a helix has no inflection");
    }
}

#[test]
fn a_sine_bends_the_other_way_at_each_zero_between_its_ends() {
    for steps in [40, 160] {
        let sine = one(curve(steps, |t| ([40.0 * t, 5.0 * (4.0 * PI * t).sin(), 0.0], 0.6)));
        let shape = sine.vessels[0].shape;
        close(shape.inflection_count_metric / shape.distance_metric, 4.0, 1e-9, "inflections and one");
        assert_eq!(shape.torsion, 0.0);
    }
}

/// A trunk along x, and two children at these angles (degrees) in the plane of x and y, or lifted out of it.
fn fork(radii: [f64; 3], angles: [f64; 2], lifted: f64, spacing: f64) -> Morphometry {
    let mut swc = Swc::default();
    let end = swc.line(curve((30.0 / spacing) as usize, |t| ([30.0 * t, 0.0, 0.0], radii[0])), None);
    for (angle, radius) in angles.into_iter().zip(&radii[1..]) {
        let (angle, up) = (f64::to_radians(angle), f64::to_radians(lifted));
        let to = [angle.cos() * up.cos(), angle.sin() * up.cos(), up.sin()];
        let child =
            curve((25.0 / spacing) as usize, |t| ([30.0 + 25.0 * t * to[0], 25.0 * t * to[1], 25.0 * t * to[2]], *radius));
        swc.line(child.into_iter().skip(1), Some(end));
    }
    measured(&swc.network(), "1")
}

#[test]
fn a_fork_has_its_angles_and_the_exponent_of_murray() {
    for (k, spacing) in [(2.0, 0.1), (2.7, 0.5), (3.0, 0.5), (3.0, 1.0), (2.7, 2.5)] {
        let narrow = (2.0_f64.powf(k) - 1.7_f64.powf(k)).powf(1.0 / k);
        let found = fork([2.0, 1.7, narrow], [40.0, -30.0], 0.0, spacing);
        let [fork] = &*found.bifurcations else { panic!("one bifurcation") };
        close(fork.angle.to_degrees(), 70.0, 1e-6, "angle");
        close(fork.bends[0].to_degrees(), 40.0, 1e-6, "bend of the wider child");
        close(fork.bends[1].to_degrees(), 30.0, 1e-6, "bend of the narrower child");
        assert!(fork.elevation.abs() < 1e-6, "flat: {}", fork.elevation);
        close(fork.murray.expect("an exponent"), k, 1e-6, "Murray's exponent");
        close(fork.asymmetry, narrow / 1.7, 1e-6, "asymmetry");
        close(fork.area_ratio, (1.7 * 1.7 + narrow * narrow) / 4.0, 1e-6, "area ratio");
    }
    let wide = fork([1.0, 1.0, 0.5], [40.0, -30.0], 0.0, 0.5);
    assert_eq!(wide.bifurcations[0].murray, None, "no exponent fits a child as wide as the parent");
    // As wide but for rounding in double and in single precision, and narrower.
    for (radius, has_exponent) in [("1.9999999999999996", false), ("1.9999998", false), ("1.999998", true)] {
        let found = of_edges(&format!("a,b,10,2\nb,c,10,{radius}\nb,d,10,0.73\n"), "");
        let exponent = found.bifurcations[0].murray;
        assert_eq!(exponent.is_some(), has_exponent, "{radius}: {exponent:?}");
        if let Some(k) = exponent {
            close(0.999_999_f64.powf(k) + 0.365_f64.powf(k), 1.0, 1e-9, "Murray's law");
        }
    }
    // Both children 20 degrees above the x-y plane, 45 to either side: the plane through them holds x only lifted by atan(tan 20 / cos 45).
    let lifted = fork([2.0, 1.5, 1.4], [45.0, -45.0], 20.0, 0.5);
    let wanted = (20.0_f64.to_radians().tan() / 45.0_f64.to_radians().cos()).atan().to_degrees();
    close(lifted.bifurcations[0].elevation.to_degrees(), wanted, 1e-6, "elevation");
}

/// A tree: the trunk forks into a vessel without children and one that forks again.
///
/// ```text
/// 1 ----- + ----- leaf
///          \----- + --- leaf
///                  \--- leaf
/// ```
#[test]
fn a_tree_has_its_generations_and_orders() {
    let mut swc = Swc::default();
    let straight = |from: [f64; 3], to: [f64; 3], radius: f64| {
        curve(20, move |t| (std::array::from_fn(|k| from[k] + t * (to[k] - from[k])), radius))
    };
    let root = swc.line(straight([0.0; 3], [20.0, 0.0, 0.0], 2.0), None);
    swc.line(straight([20.0, 0.0, 0.0], [40.0, 10.0, 0.0], 1.0).into_iter().skip(1), Some(root));
    let fork = swc.line(straight([20.0, 0.0, 0.0], [40.0, -10.0, 0.0], 1.5).into_iter().skip(1), Some(root));
    swc.line(straight([40.0, -10.0, 0.0], [60.0, -5.0, 0.0], 0.9).into_iter().skip(1), Some(fork));
    swc.line(straight([40.0, -10.0, 0.0], [60.0, -15.0, 0.0], 0.9).into_iter().skip(1), Some(fork));
    let found = measured(&swc.network(), "1");
    let by_radius = |radius: f64| {
        let near = |v: &&MeasuredVessel| (v.line.end_radius(true) / MM - radius).abs() < 0.05;
        found.vessels.iter().find(near).unwrap_or_else(|| panic!("{radius}"))
    };
    let orders = |radius: f64| {
        let vessel = by_radius(radius);
        (vessel.generation, vessel.strahler)
    };
    assert_eq!(orders(2.0), (Some(0), Some(2)));
    assert_eq!(orders(1.0), (Some(1), Some(1)));
    assert_eq!(orders(1.5), (Some(1), Some(2)), "two children of order 1");
    assert_eq!(orders(0.9), (Some(2), Some(1)));
    let whole = found.network;
    assert_eq!((whole.vessels, whole.bifurcations, whole.ends, whole.parts, whole.loops), (5, 2, 4, 1, 0));
    let branch = 500.0_f64.sqrt();
    close(whole.whole.length, (20.0 + 2.0 * branch + 2.0 * 425.0_f64.sqrt()) * MM, 1e-9, "length");
    close(whole.whole.most_from_inlet, (20.0 + branch + 425.0_f64.sqrt()) * MM, 1e-9, "the longest way");
    assert_eq!(found.ends.iter().filter(|end| end.from_inlet == 0.0).count(), 1, "the inlet is an end");
}

/// Half of a cone lies in a half-space of a stated volume: its length and volume there are those of the frustum.
#[test]
fn densities_are_of_what_lies_in_the_region() {
    let mut swc = Swc::default();
    swc.line(curve(7, |t| ([40.0 * t, 0.0, 0.0], 2.0 - t)), None);
    let region = Region { volume: 1e-5, step: 0.05 * MM, holds: Box::new(|place| place[0] < 20.0 * MM) };
    let around = MeasureContext { region: Some(&region), ..MeasureContext::default() };
    let whole = Morphometry::of(&swc.network(), |_| Role::Inner, Smoothing::default(), around).network;
    let [length, volume, of] = whole.in_region.expect("a region");
    close(length, 20.0 * MM / 1e-5, 1e-2, "length density");
    close(volume, PI / 3.0 * 20.0 * (4.0 + 3.0 + 2.25) * MM.powi(3) / 1e-5, 1e-2, "volume density");
    close(of, 1e-5, 1e-12, "volume of the region");
}

/// Beyond the artery of a territory all vessels are its own, up to none that a way enters first by another.
#[test]
fn what_lies_beyond_an_artery_is_its_territory() {
    let mut swc = Swc::default();
    let straight =
        |from: [f64; 3], to: [f64; 3]| curve(10, move |t| (std::array::from_fn(|k| from[k] + t * (to[k] - from[k])), 1.0));
    let root = swc.line(straight([0.0; 3], [20.0, 0.0, 0.0]), None);
    let one = swc.line(straight([20.0, 0.0, 0.0], [40.0, 10.0, 0.0]).into_iter().skip(1), Some(root));
    swc.line(straight([20.0, 0.0, 0.0], [40.0, -10.0, 0.0]).into_iter().skip(1), Some(root));
    swc.line(straight([40.0, 10.0, 0.0], [60.0, 15.0, 0.0]).into_iter().skip(1), Some(one));
    swc.line(straight([40.0, 10.0, 0.0], [60.0, 5.0, 0.0]).into_iter().skip(1), Some(one));
    let network = swc.network();
    let ends_at = |row: usize, y: f64| {
        network.ends(row).iter().any(|n| network.node(*n).position.is_some_and(|p| (p[1] - y * MM).abs() < 1e-9))
    };
    let territory: Vec<Option<usize>> = (0..network.vessel_count())
        .map(|row| if ends_at(row, 10.0) && ends_at(row, 0.0) { Some(0) } else { ends_at(row, 15.0).then_some(1) })
        .collect();
    let role = |node: usize| if network.node(node).id == "1" { Role::Inlet } else { Role::Inner };
    let around = MeasureContext { territory: &territory, region: None };
    let found = Morphometry::of(&network, role, Smoothing::default(), around);
    let own = found.network.territories;
    let [side, twig] = [500.0_f64, 425.0].map(f64::sqrt);
    assert_eq!(own.keys().copied().collect::<Vec<_>>(), [0], "the way to the second enters the first before");
    close(own[&0].length, (side + 2.0 * twig) * MM, 1e-9, "length");
    close(own[&0].most_from_inlet, (20.0 + side + twig) * MM, 1e-9, "the longest way");
    let mean = (side * (20.0 + side / 2.0) + 2.0 * twig * (20.0 + side + twig / 2.0)) / (side + 2.0 * twig);
    close(own[&0].mean_from_inlet, mean * MM, 1e-9, "the mean way");
}

/// A vessel of no length at a bifurcation has no direction, and is no reason to end.
#[test]
fn a_vessel_of_no_length_is_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    put("edges.csv", "node_a,node_b,length_mm,radius_mm\n0,1,10,1\n1,2,0.001,1\n1,3,10,0.5\n");
    put("nodes.csv", "node,x_mm,y_mm,z_mm\n0,0,0,0\n1,10,0,0\n2,10,0,0\n3,20,0,0\n");
    let network = willis::read(&folder.path().join("edges.csv"), &ReadOptions::default()).expect("a graph").network;
    let found = measured(&network, "0");
    assert_eq!((found.vessels.len(), found.bifurcations.len()), (3, 1));
    assert!(found.bifurcations[0].angle.is_nan());
}

/// What is measured of edges in mm, with a table of nodes beside it unless that is empty; blood enters at `a`.
fn of_edges(edges: &str, nodes: &str) -> Morphometry {
    let folder = tempfile::tempdir().expect("a folder");
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    put("edges.csv", &format!("node_a,node_b,length_mm,radius_mm\n{edges}"));
    if !nodes.is_empty() {
        put("nodes.csv", &format!("node,x_mm,y_mm,z_mm\n{nodes}"));
    }
    measured(&willis::read(&folder.path().join("edges.csv"), &ReadOptions::default()).expect("a graph").network, "a")
}

#[test]
fn a_vessel_that_no_inlet_reaches_has_no_probability_of_blood() {
    let found = of_edges("a,b,10,1\nc,d,10,1\n", "");
    let reached: Vec<(Option<usize>, f64)> = found.vessels.iter().map(|v| (v.generation, v.probability)).collect();
    assert!(matches!(reached[..], [(Some(0), 1.0), (None, p)] if p.is_nan()), "{reached:?}");
}

/// Two cylinders in a row are one vessel, however the file turns and orders them, and with or without positions.
#[test]
fn pieces_of_two_widths_keep_both() {
    let nodes = "a,0,0,0\nb,10,0,0\nc,20,0,0\n";
    for (edges, nodes) in [
        ("a,b,10,1\nb,c,10,0.5\n", nodes),
        ("c,b,10,0.5\nb,a,10,1\n", nodes),
        ("b,a,10,1\nb,c,10,0.5\n", nodes),
        ("a,b,10,1\nb,c,10,0.5\n", ""),
        ("c,b,10,0.5\nb,a,10,1\n", ""),
    ] {
        let found = of_edges(edges, nodes);
        let [vessel] = &*found.vessels else { panic!("one vessel") };
        close(vessel.line.length, 20.0 * MM, 1e-9, "length");
        close(vessel.shape.volume, PI * (10.0 * 1.0 + 10.0 * 0.25) * MM.powi(3), 1e-9, "volume");
        close(vessel.shape.surface, 2.0 * PI * (10.0 * 1.0 + 10.0 * 0.5) * MM.powi(2), 1e-9, "surface");
        close(vessel.shape.radius, 0.75 * MM, 1e-9, "radius");
        close(vessel.shape.least_radius, 0.5 * MM, 1e-9, "least radius");
        // By least squares a step by h in the middle of a length l has the slope 3 h/(2 l).
        close(vessel.shape.taper, 1.5 * 0.5 / 20.0, 1e-9, "taper");
        close(found.network.whole.volume, vessel.shape.volume, 1e-12, "volume of the whole");
        for end in &found.ends {
            close(end.radius, if end.from_inlet == 0.0 { 1.0 } else { 0.5 } * MM, 1e-9, "an end");
        }
        assert_eq!(vessel.shape.chord.is_nan(), nodes.is_empty());
    }
}

/// A place that stands twice in a line, as where a contact was cut, says nothing of its course.
#[test]
fn a_point_in_the_place_of_another_bends_nothing() {
    let shape = |edges: &str, nodes: &str| of_edges(edges, nodes).vessels[0].shape;
    let [lengths, nodes] = ["a,b,1,0.6\nb,c,1.25,0.6\nc,d,0.75,0.6\n", "a,0,0,0\nb,1,0,0\nc,1.75,1,0\nd,2.5,1,0\n"];
    let once = shape(lengths, nodes);
    for (edges, place) in [
        ("a,b,1,0.6\nb,c,1.25,0.6\nc,e,0.04,0.6\ne,d,0.75,0.6\n", "1.75,1,0"),
        ("a,b,1,0.6\nb,c,1.25,0.6\nc,e,1e-13,0.6\ne,d,0.75,0.6\n", "1.7500000000001,1,0"),
        ("a,e,1e-13,0.6\ne,b,1,0.6\nb,c,1.25,0.6\nc,d,0.75,0.6\n", "1e-13,0,0"),
    ] {
        let twice = shape(edges, &format!("{nodes}e,{place}\n"));
        close(twice.curvature, once.curvature, 1e-9, edges);
        close(twice.sum_of_angles_metric, once.sum_of_angles_metric, 1e-9, edges);
        assert!((twice.inflection_count_metric - once.inflection_count_metric).abs() < 0.1, "{edges}");
    }
    let straight =
        shape("a,b,1,0.4\nb,c,1e-13,0.4\nc,d,0.9,0.4\n", "a,0,0,0\nb,0.3,0.4,0\nc,0.30000000000002,0.4,0\nd,0.9,1.2,0\n");
    assert!(straight.curvature * MM < 1e-6 && straight.torsion == 0.0, "{straight:?}");
}

/// Radii and lengths need no positions.
#[test]
fn a_graph_without_positions_has_its_volume_and_its_exponent_of_murray() {
    let found = of_edges("a,b,10,1\nb,c,10,0.8\nb,d,10,0.5\n", "");
    close(found.network.whole.volume, PI * 10.0 * (1.0 + 0.64 + 0.25) * MM.powi(3), 1e-9, "volume");
    close(found.network.whole.radius, 2.3 / 3.0 * MM, 1e-9, "mean radius");
    let [bifurcation] = &*found.bifurcations else { panic!("one bifurcation") };
    for (radius, wanted) in bifurcation.radii.into_iter().zip([1.0, 0.8, 0.5]) {
        close(radius, wanted * MM, 1e-9, "radius at the bifurcation");
    }
    let k = bifurcation.murray.expect("an exponent");
    close(0.8_f64.powf(k) + 0.5_f64.powf(k), 1.0, 1e-9, "Murray's law");
    assert!(bifurcation.angle.is_nan() && found.vessels[0].shape.curvature.is_nan() && found.network.boxed.is_nan());
    assert!(found.vessels.iter().all(|vessel| vessel.shape.taper.abs() < 1e-12));
    assert!(found.vessels.iter().all(|vessel| vessel.shape.taper.to_bits() != (-0.0_f64).to_bits()), "a table would say -0");
}

/// Where blood comes from two sides, each point of a ring is reached by the shorter way.
#[test]
fn a_ring_has_a_loop_and_no_end() {
    let steps = 100;
    let mut swc = Swc::default();
    let turn = |t: f64| ([10.0 * (2.0 * PI * t).cos(), 10.0 * (2.0 * PI * t).sin(), 0.0], 1.0);
    let last = swc.line(curve(steps, turn).into_iter().take(steps), None);
    // SWC cannot close it: the last point goes back to where the first lies.
    swc.line([turn(0.0)], Some(last));
    let whole = measured(&swc.network(), "none").network;
    assert_eq!((whole.vessels, whole.bifurcations, whole.ends, whole.parts, whole.loops), (1, 0, 0, 1, 1));
    close(whole.whole.length, 2.0 * PI * 10.0 * MM, 0.001, "length");
    assert!(whole.whole.most_from_inlet.is_nan(), "nothing says where blood enters");
}

/// Where two ways meet within a vessel its farthest place lies, not at an end.
#[test]
fn the_longest_way_ends_where_two_ways_meet() {
    let mut swc = Swc::default();
    swc.line(curve(10, |t| ([40.0 * t, 0.0, 0.0], 1.0)), None);
    let both = |_| Role::Inlet;
    let whole = Morphometry::of(&swc.network(), both, Smoothing::default(), MeasureContext::default()).network.whole;
    close(whole.mean_from_inlet, 10.0 * MM, 1e-9, "half of a half");
    close(whole.most_from_inlet, 20.0 * MM, 1e-9, "the middle");
    // A trunk of 30 mm, then a loop of 50 and 70 mm: the farthest place is 60 mm along it either way.
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("edges.csv"), "node_a,node_b,length_mm,radius_mm\n0,1,30,1\n1,2,50,1\n2,1,70,1\n")
        .expect("written");
    let network = willis::read(&folder.path().join("edges.csv"), &ReadOptions::default()).expect("a graph").network;
    let whole = measured(&network, "0").network;
    assert_eq!(whole.loops, 1);
    close(whole.whole.most_from_inlet, 90.0 * MM, 1e-9, "the far side of the loop");
    close(whole.whole.mean_from_inlet, (30.0 * 15.0 + 120.0 * 60.0) / 150.0 * MM, 1e-9, "the mean");
}

/// A line fills one dimension, a dense grid of lines in a plane two.
#[test]
fn boxes_count_the_dimension() {
    let line = one(curve(500, |t| ([37.0 * t, 23.0 * t, 11.0 * t], 1.0))).network;
    close(line.box_dimension, 1.0, 0.05, "a line");
    let mut swc = Swc::default();
    for row in 0..65 {
        swc.line(curve(64, |t| ([64.0 * t, f64::from(row), 0.0], 0.2)), None);
    }
    close(measured(&swc.network(), "1").network.box_dimension, 2.0, 0.02, "a plane");
}

/// How a file divides, orders and spaces its points changes no figure by more than spacing does.
#[test]
fn dividing_turning_and_resampling_change_little() {
    let at = |t: f64| ([30.0 * t, 4.0 * (5.0 * t).sin(), 3.0 * (4.0 * t).cos()], 1.2 - 0.4 * t);
    let whole = one(curve(200, at));
    let figures = |found: &Morphometry| {
        let shape = found.vessels[0].shape;
        [
            found.vessels[0].line.length,
            shape.radius,
            shape.volume,
            shape.surface,
            shape.distance_metric,
            shape.inflection_count_metric,
            shape.curvature,
            shape.torsion,
            shape.sum_of_angles_metric,
            // It has the sign of where blood comes from.
            shape.taper.abs(),
            shape.least_radius,
        ]
    };
    let wanted = figures(&whole);
    let same = |found: &Morphometry, within: f64, what: &str| {
        assert_eq!(found.vessels.len(), 1, "{what}");
        for (got, wanted) in figures(found).into_iter().zip(wanted) {
            close(got, wanted, within, what);
        }
    };
    same(&one(curve(100, at)), 0.01, "every other point");
    same(&one(curve(700, at)), 0.01, "more points");
    same(&one(curve(200, |t| at(1.0 - t))), 1e-9, "turned");
    let backward = curve(200, |t| at(1.0 - t));
    let mut swc = Swc::default();
    swc.line(backward, None);
    let unfed = Morphometry::of(&swc.network(), |_| Role::Inner, Smoothing::default(), MeasureContext::default());
    same(&unfed, 1e-9, "turned, and no inlet");
    assert!(unfed.vessels[0].shape.taper > 0.0, "from the wider end on");
    // The same points as vessels of a graph, one for every ten of them, every other one turned.
    let points = curve(200, at);
    let mut graph = String::from("node_a,node_b,length_mm,radius_mm,points\n");
    let mut nodes = String::from("node,x_mm,y_mm,z_mm\n");
    for (i, part) in points.chunks(10).take(20).enumerate() {
        let part: Vec<_> = part.iter().copied().chain([points[10 * i + 10]]).collect();
        let length: f64 = part.windows(2).map(|p| (0..3).map(|k| (p[0].0[k] - p[1].0[k]).powi(2)).sum::<f64>().sqrt()).sum();
        let mut listed: Vec<String> = part.iter().map(|([x, y, z], r)| format!("{x:.12} {y:.12} {z:.12} {r:.12}")).collect();
        let mut ends = [i, i + 1];
        if i % 2 == 1 {
            listed.reverse();
            ends.reverse();
        }
        writeln!(graph, "{},{},{length:.12},1,{}", ends[0], ends[1], listed.join(";")).expect("text");
    }
    for (i, ([x, y, z], _)) in points.iter().step_by(10).enumerate() {
        writeln!(nodes, "{i},{x:.12},{y:.12},{z:.12}").expect("text");
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("edges.csv"), graph).expect("written");
    std::fs::write(folder.path().join("nodes.csv"), nodes).expect("written");
    let divided = willis::read(&folder.path().join("edges.csv"), &ReadOptions::default()).expect("a graph").network;
    assert_eq!(divided.vessel_count(), 20);
    same(&measured(&divided, "0"), 1e-6, "divided");
}

/// More points on the same broken line, as a tracing in voxels is one, are the same line.
#[test]
fn points_between_the_points_of_a_jagged_line_change_little() {
    // Off a helix by up to 0.3 mm, in a pattern without a period.
    let off = |i: usize, k: usize| 0.3 * (37.0 * i as f64 + 11.0 * (i * i) as f64 + 2.0 * k as f64).sin();
    let helix = |t: f64| ([5.0 * (8.0 * t).cos(), 5.0 * (8.0 * t).sin(), 20.0 * t], 1.2 - 0.4 * t);
    let mut jagged = curve(50, helix);
    for (i, (point, radius)) in jagged.iter_mut().enumerate() {
        (0..3).for_each(|k| point[k] += off(i, k));
        *radius += 0.3 * off(i, 3);
    }
    let between = |parts: usize| {
        let mut points = vec![jagged[0]];
        for pair in jagged.windows(2) {
            for part in 1..=parts {
                let at = |a: f64, b: f64| a + (b - a) * part as f64 / parts as f64;
                points.push((std::array::from_fn(|k| at(pair[0].0[k], pair[1].0[k])), at(pair[0].1, pair[1].1)));
            }
        }
        one(points).vessels[0].shape
    };
    let wanted = between(1);
    for parts in [2, 3, 10] {
        let got = between(parts);
        close(got.curvature, wanted.curvature, 0.01, "curvature");
        close(got.torsion, wanted.torsion, 0.01, "torsion");
        close(got.sum_of_angles_metric, wanted.sum_of_angles_metric, 0.01, "sum of angles");
        close(got.inflection_count_metric, wanted.inflection_count_metric, 0.01, "inflections");
        close(got.taper, wanted.taper, 0.01, "taper");
    }
}

/// The vessel that thinning makes of a tube of this radius (mm) around a curve, in voxels of these sizes (mm).
fn of_voxels(curve: &[[f64; 3]], radius: f64, voxel: [f64; 3]) -> Morphometry {
    let low: [f64; 3] =
        std::array::from_fn(|k| curve.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min) - radius - 2.0 * voxel[k]);
    let high: [f64; 3] =
        std::array::from_fn(|k| curve.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max) + radius + 2.0 * voxel[k]);
    let shape: [usize; 3] = std::array::from_fn(|k| ((high[k] - low[k]) / voxel[k]).ceil() as usize);
    let mut classes = vec![0; shape.iter().product()];
    let reach = (radius / voxel.into_iter().fold(f64::INFINITY, f64::min)).ceil() as i64 + 1;
    for p in curve {
        let middle: [i64; 3] = std::array::from_fn(|k| ((p[k] - low[k]) / voxel[k]).round() as i64);
        for n in 0..(2 * reach + 1).pow(3) {
            let side = 2 * reach + 1;
            let at: [i64; 3] = std::array::from_fn(|k| middle[k] + n / side.pow(k as u32) % side - reach);
            let off: f64 = (0..3).map(|k| (low[k] + voxel[k] * at[k] as f64 - p[k]).powi(2)).sum();
            if off <= radius * radius && (0..3).all(|k| at[k] >= 0 && (at[k] as usize) < shape[k]) {
                let [x, y, z] = at.map(|x| x as usize);
                classes[x + shape[0] * (y + shape[1] * z)] = 1;
            }
        }
    }
    let affine = std::array::from_fn(|k| {
        std::array::from_fn(|j| {
            if j == k {
                voxel[k]
            } else if j == 3 {
                low[k]
            } else {
                0.0
            }
        })
    });
    let traced = trace(&Mask::new(shape, classes, affine), RadiusFrom::Area, Cavities::Fill).expect("a vessel");
    measured(&contract(&traced.lines, RadiusRule::Mean, None).expect("a network").network, "none")
}

/// Voxels make staircases, over which bends are smoothed: curvature is that of the curve, and what a straight tube has is no bend.
#[test]
fn voxels_bend_no_vessel() {
    for (voxel, radius) in [(0.3, 0.6), (0.5, 1.0), (0.8, 2.0)] {
        let along =
            |steps: usize, at: &dyn Fn(f64) -> [f64; 3]| (0..=steps).map(|i| at(i as f64 / steps as f64)).collect::<Vec<_>>();
        let found = of_voxels(&helix(), radius, [voxel; 3]);
        let [vessel] = &*found.vessels else { panic!("{voxel}: {} vessels", found.vessels.len()) };
        close(vessel.shape.radius, radius * MM, 0.05, "radius");
        close(vessel.line.length, 60.0 * MM, 0.06, "length");
        close(vessel.shape.curvature * MM, 5.0 / 29.0, 0.06, "curvature");
        let straight = along(1000, &|t| [32.0 * t, 20.0 * t, 13.2 * t]);
        let shape = of_voxels(&straight, radius, [voxel; 3]).vessels[0].shape;
        close(shape.distance_metric, 1.0, 0.01, "distance metric");
        // Less than what counts as a bend, a quarter of a radian within a smoothing length of six radii.
        assert!(shape.curvature * 6.0 * radius * MM < 0.25, "{voxel}: {shape:?}");
    }
}

/// A helix of 60 mm around z, whose curvature is 5/29 a mm.
fn helix() -> Vec<[f64; 3]> {
    let turn = 60.0 / 29.0_f64.sqrt();
    (0..=1500).map(|i| turn * f64::from(i) / 1500.0).map(|t| [5.0 * t.cos(), 5.0 * t.sin(), 2.0 * t]).collect()
}

/// A tilted ring of 20 mm: in slices thicker than voxels are wide, steps are longer than what is smoothed of a thin vessel, as docs/src/measure.md says.
#[test]
fn thick_slices_bend_thin_vessels() {
    let turn = |i: i32| 2.0 * PI * f64::from(i) / 4000.0;
    let ring: Vec<[f64; 3]> = (0..4000).map(|i| [20.0 * turn(i).cos(), 16.0 * turn(i).sin(), 12.0 * turn(i).sin()]).collect();
    let off = |radius, voxel| {
        let found = of_voxels(&ring, radius, voxel);
        let longest = found.vessels.iter().max_by(|a, b| a.line.length.total_cmp(&b.line.length)).expect("a vessel");
        longest.shape.curvature * 20.0 * MM - 1.0
    };
    let cubic = [1.0, 2.5].map(|radius| off(radius, [0.5; 3]));
    assert!(cubic.iter().all(|off| off.abs() < 0.07), "{cubic:?}");
    let thick = [1.0, 2.5].map(|radius| off(radius, [0.4, 0.4, 1.0]));
    assert!((0.2..0.5).contains(&thick[0]) && thick[1].abs() < 0.15, "{thick:?}");
}

/// A circle as narrow as a vessel can bend: three of its radii.
#[test]
fn a_narrow_bend_keeps_its_curvature() {
    let turn = 1.5 * PI;
    let circle = one(curve(200, |t| ([3.0 * (turn * t).cos(), 3.0 * (turn * t).sin(), 0.0], 1.0)));
    close(circle.vessels[0].shape.curvature * MM, 1.0 / 3.0, 0.02, "curvature");
}
