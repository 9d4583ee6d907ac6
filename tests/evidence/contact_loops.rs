//! Loops around holes that are narrower than the vessels: opened where two vessels touch twice or one is pierced, and a ring that is wider
//! than its vessel stays. Truth: the drawings.

use willis::internals::contacts::model::ContactModel;
use willis::internals::contacts::with_contacts;
use willis::internals::masks::{Cavities, Field, Mask, RadiusFrom, trace};
use willis::internals::network::{Origin, RadiusRule, contract, fragments};

/// A mask of cubic voxels of a side (mm) in a box around the origin with these half lengths (mm).
fn drawn(half: [f64; 3], voxel: f64, is_vessel: impl Fn([f64; 3]) -> bool) -> Mask {
    let shape = half.map(|half| (2.0 * half / voxel).ceil() as usize + 6);
    let at = |row: usize| {
        let index = [row % shape[0], row / shape[0] % shape[1], row / (shape[0] * shape[1])];
        [0, 1, 2].map(|axis| (index[axis] as f64 + 0.5 - shape[axis] as f64 / 2.0) * voxel)
    };
    let classes = (0..shape.iter().product()).map(|row| u8::from(is_vessel(at(row)))).collect();
    Mask::new(shape, classes, [[voxel, 0.0, 0.0, 0.0], [0.0, voxel, 0.0, 0.0], [0.0, 0.0, voxel, 0.0]])
}

/// Independent cycles of the lines of a mask, as they are and with contacts opened.
fn loops(mask: &Mask) -> [usize; 2] {
    let traced = trace(mask, RadiusFrom::Area, Cavities::Fill).expect("lines");
    let network = contract(&traced.lines, RadiusRule::Mean, None).expect("vessels").network;
    let field = Field::of(&traced.lumen);
    let (opened, _) = with_contacts(&network, Some(&field), None, &ContactModel::shipped().expect("a model"));
    let observed = |network: &willis::Network| {
        let vessels = network.vessels().filter(|(_, vessel)| vessel.origin == Origin::Observed).count();
        vessels + fragments(network, |_, vessel| vessel.origin == Origin::Observed).count - network.node_count()
    };
    [observed(&network), observed(&opened.graph)]
}

/// A ring with two vessels that lead to it, mm.
fn ring(around: f64, radius: f64, voxel: f64) -> Mask {
    drawn([around + 12.0, around + radius, radius], voxel, |[x, y, z]| {
        let on_ring = (x.hypot(y) - around).hypot(z) <= radius;
        let stem = x.abs() > around && y.hypot(z) <= radius;
        on_ring || stem
    })
}

#[test]
fn a_ring_that_is_wider_than_its_vessel_stays() {
    for voxel in [0.25, 0.4, 0.5, 0.8] {
        for around in [3.0, 4.0, 6.0] {
            assert_eq!(loops(&ring(around, 1.0, voxel))[1], 1, "a ring of {around} mm in voxels of {voxel} mm");
        }
    }
}

#[test]
fn a_hole_that_is_narrower_than_the_vessel_around_it_makes_no_loop() {
    for voxel in [0.25, 0.4] {
        assert_eq!(loops(&ring(1.5, 1.0, voxel)), [1, 0], "voxels of {voxel} mm");
    }
    // A vessel 3 mm wide with ways of one voxel through it.
    let pierced = drawn([20.0, 1.5, 1.5], 0.5, |[x, y, z]| {
        let hole = (-4..=4).any(|n| (x - 4.0 * f64::from(n)).abs() < 0.26) && y.abs() < 0.26;
        y.abs() < 1.5 && z.abs() < 1.5 && !hole
    });
    let [before, after] = loops(&pierced);
    assert!(before >= 8 && after == 0, "{before} {after}");
}

#[test]
fn two_vessels_that_touch_in_eight_places_are_apart() {
    let touching = drawn([25.0, 3.0, 1.0], 0.5, |[x, y, z]| {
        let tube = |middle: f64| (y - middle).hypot(z) <= 1.0;
        let touch = (0..8).any(|n| (x + 21.0 - 6.0 * f64::from(n)).abs() < 0.5) && y.abs() < 1.0 && z.abs() < 0.6;
        tube(-1.5) || tube(1.5) || touch
    });
    let [before, after] = loops(&touching);
    assert!(before >= 6 && after == 0, "{before} {after}");
}
