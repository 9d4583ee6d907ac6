//! Cavities and loops that a segmenter leaves in a mask: what is noise goes, what is a vessel stays. Truth: the drawings, and SciPy's count.

use std::fs;

use crate::command::{folder, stderr, willis};
use crate::draw::Draw;
use crate::masks::{graph, has_cavity, lumps, mask, spaced};
use crate::peers::python;
use willis::internals::masks::{Cavities, Mask, RadiusFrom, trace};

/// Independent cycles of the lines of a mask.
fn cycles(mask: &Mask) -> i64 {
    let mut mask = mask.clone();
    mask.fill_cavities();
    graph(&trace(&mask, RadiusFrom::Area, Cavities::Fill).expect("lines").lines).1
}

/// A ring in a plane: the radii of the ring and of its vessel, mm, in voxels of a size.
fn ring(around: f64, radius: f64, voxel: f64) -> Mask {
    let half = around + radius + 3.0 * voxel;
    let shape = [half, half, radius + 3.0 * voxel].map(|half| (2.0 * half / voxel).ceil() as usize);
    spaced(shape, [voxel; 3], |at| {
        let [x, y, z] = [0, 1, 2].map(|axis| (at[axis] as f64 + 0.5 - shape[axis] as f64 / 2.0) * voxel);
        (x.hypot(y) - around).hypot(z) <= radius
    })
}

#[test]
fn a_ring_that_is_wider_than_its_vessel_stays_and_a_pinhole_goes() {
    for voxel in [0.25, 0.4, 0.5, 0.8] {
        for around in [3.0, 4.0, 6.0] {
            assert_eq!(cycles(&ring(around, 1.0, voxel)), 1, "a ring of {around} mm in voxels of {voxel} mm");
        }
        assert_eq!(cycles(&ring(1.3, 1.0, voxel)), 0, "a hole of 0.3 mm in voxels of {voxel} mm");
    }
}

#[test]
fn holes_within_a_vessel_and_rungs_between_two_make_no_loops() {
    let mut draw = Draw::new(3);
    // A vessel of 6 x 6 voxels with ways of one voxel through it.
    let through: Vec<usize> = (0..6).map(|n| 6 + 7 * n + draw.below(3)).collect();
    let pierced = mask([60, 12, 12], |[x, y, z]| {
        (3..57).contains(&x) && (3..9).contains(&y) && (3..9).contains(&z) && !(through.contains(&x) && y == 5)
    });
    assert_eq!(graph(&trace(&pierced, RadiusFrom::Area, Cavities::Keep).expect("lines").lines).1, 6, "as drawn");
    assert_eq!(cycles(&pierced), 0);
    // Two vessels one voxel apart that touch in eight places.
    let touching: Vec<usize> = (0..8).map(|n| 6 + 6 * n + draw.below(2)).collect();
    let pair = mask([60, 16, 12], |[x, y, z]| {
        (3..57).contains(&x)
            && (3..9).contains(&z)
            && ((3..7).contains(&y) || (8..12).contains(&y) || y == 7 && (5..7).contains(&z) && touching.contains(&x))
    });
    assert_eq!(graph(&trace(&pair, RadiusFrom::Area, Cavities::Keep).expect("lines").lines).1, 7, "as drawn");
    let lines = trace(&pair, RadiusFrom::Area, Cavities::Fill).expect("lines").lines;
    assert_eq!(graph(&lines), (1, 0));
    // Both are there along all of their length.
    for y in [4.5_f64, 9.5] {
        let near = lines.points.iter().filter(|p| (p[1] * 1e3 - y).abs() < 1.6);
        let (low, high) = near.fold((f64::MAX, f64::MIN), |(low, high), p| (low.min(p[0] * 1e3), high.max(p[0] * 1e3)));
        assert!(low < 8.0 && high > 51.0, "{y}: {low} to {high}");
    }
}

/// A tube with one voxel missing is the same one vessel; with `--cavities keep` it is what thinning makes of a closed surface.
#[test]
fn a_missing_voxel_is_filled_and_told() {
    let here = folder();
    let shape = [24, 24, 44];
    let voxels = |hole: bool| -> String {
        let is = |[x, y, z]: [usize; 3]| {
            let inside = (x as f64 - 11.5).hypot(y as f64 - 11.5) < 4.0 && (4..40).contains(&z);
            inside && !(hole && [x, y, z] == [11, 12, 22])
        };
        let header = format!(
            "ObjectType = Image\nNDims = 3\nDimSize = 24 24 44\nElementSpacing = 0.5 0.5 0.5\nElementType = MET_UCHAR\nElementDataFile = {hole}.raw\n"
        );
        let bytes: Vec<u8> = mask(shape, is).classes;
        fs::write(here.path().join(format!("{hole}.raw")), bytes).expect("written");
        header
    };
    for hole in [false, true] {
        fs::write(here.path().join(format!("{hole}.mhd")), voxels(hole)).expect("written");
    }
    let vessels = |arguments: &[&str]| {
        let done = willis(here.path(), &[&["skeleton", "--force"], arguments].concat());
        let said = stderr(&done);
        assert!(done.status.success(), "{said}");
        let count = fs::read_to_string(here.path().join("out.csv")).expect("a table").lines().count() - 1;
        (count, said)
    };
    let whole = vessels(&["false.mhd", "-o", "out.csv"]);
    let holed = vessels(&["true.mhd", "-o", "out.csv"]);
    assert_eq!((whole.0, holed.0), (1, 1));
    assert!(!whole.1.contains("filled") && holed.1.contains("1 cavity of 1 voxel filled"), "{}", holed.1);
    assert!(vessels(&["true.mhd", "-o", "out.csv", "--cavities", "keep"]).0 > 20);
}

#[test]
fn what_is_filled_takes_the_class_of_its_wall_and_nothing_else_changes() {
    let mut filled = 0;
    for seed in 0..200 {
        let mut before = lumps(seed);
        for (n, class) in before.classes.iter_mut().enumerate() {
            *class *= 1 + (n / 3 % 2) as u8;
        }
        let mut after = before.clone();
        let found = after.fill_cavities();
        let changed = before.classes.iter().zip(&after.classes).filter(|(a, b)| a != b).count();
        assert!(
            before.classes.iter().zip(&after.classes).all(|(a, b)| a == b || (*a == 0 && (1..=2).contains(b))),
            "seed {seed}"
        );
        assert!(!has_cavity(&after), "seed {seed}");
        assert_eq!((found.voxels, found.cavities > 0), (changed, has_cavity(&before)), "seed {seed}");
        filled += found.cavities;
    }
    assert!(filled > 40, "{filled}");
    let mut shell =
        mask([40, 40, 40], |p| (12.0..14.0).contains(&p.map(|x| (x as f64 - 20.0).powi(2)).iter().sum::<f64>().sqrt()));
    assert_eq!(shell.fill_cavities().wide, 1, "a ball of which only the wall is segmented");
}

/// SciPy fills the same voxels (`binary_fill_holes`) and counts as many cavities.
#[test]
fn scipy_fills_the_same() {
    for seed in 0..20 {
        let mut mask = lumps(500 + seed);
        let before = mask.classes.clone();
        let found = mask.fill_cavities();
        let text = |classes: &[u8]| classes.iter().map(u8::to_string).collect::<Vec<_>>().join(",");
        let script = format!(
            "import numpy as np\nfrom scipy import ndimage as n\na=np.array([{}],bool).reshape({:?},order='F')\nb=np.array([{}],bool).reshape(a.shape,order='F')\n\
             f=n.binary_fill_holes(a)\nassert (f==b).all()\nassert n.label(f&~a)[1]=={}\n",
            text(&before),
            mask.shape,
            text(&mask.classes),
            found.cavities
        );
        if python(&script, &[]).is_none() {
            return;
        }
    }
}
