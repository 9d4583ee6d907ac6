//! Cavities and specks that a segmenter leaves in a mask: what is noise goes, what is a vessel stays. Truth: the drawings, and SciPy's count.

use std::cell::RefCell;
use std::fs;

use crate::command::{folder, stderr, willis};
use crate::draw::Draw;
use crate::masks::{graph, has_cavity, lumps, mask};
use crate::peers::python;
use willis::internals::masks::{Cavities, RadiusFrom, trace, why_no_centerlines, why_no_vessels};

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

/// Parts shorter than they are wide are left out and counted, those that are longer stay.
#[test]
fn specks_are_left_out_and_told() {
    let drawn = mask([60, 40, 20], |[x, y, z]| {
        let tube = (4..56).contains(&x) && (y as f64 - 10.0).hypot(z as f64 - 10.0) < 3.5;
        let ball = [x as f64 - 30.0, y as f64 - 28.0, z as f64 - 10.0].iter().map(|d| d * d).sum::<f64>() < 16.0;
        let short = (6..24).contains(&x) && (y as f64 - 28.0).hypot(z as f64 - 10.0) < 2.0;
        tube || ball || short
    });
    let traced = trace(&drawn, RadiusFrom::Area, Cavities::Fill).expect("lines");
    assert_eq!((graph(&traced.lines).0, traced.specks), (2, 1), "the ball is no vessel");
    assert!(trace(&drawn, RadiusFrom::Area, Cavities::Keep).is_some_and(|all| graph(&all.lines).0 + all.specks == 3));
    // A single voxel has no line, whose length is 0, not -0.
    let dotted = mask([60, 40, 20], |at| drawn.classes[at[0] + 60 * (at[1] + 40 * at[2])] > 0 && at[1] < 20 || at == [1, 38, 1]);
    let traced = trace(&dotted, RadiusFrom::Area, Cavities::Fill).expect("lines");
    assert_eq!((traced.specks, traced.speck_length.to_bits()), (1, 0));
}

/// A part that is longer than wide, but not by much, and far from all others keeps its line; nothing joins it, and no blood leaves there.
#[test]
fn a_short_part_far_off_is_neither_joined_nor_an_outlet() {
    let here = folder();
    let drawn = mask([70, 40, 20], |[x, y, z]| {
        let tube = (4..66).contains(&x) && (y as f64 - 8.0).hypot(z as f64 - 10.0) < 3.5;
        tube || ((30..36).contains(&x) && (27..30).contains(&y) && (10..12).contains(&z))
    });
    let header = "ObjectType = Image\nNDims = 3\nDimSize = 70 40 20\nElementSpacing = 0.5 0.5 0.5\nElementType = MET_UCHAR\nElementDataFile = m.raw\n";
    fs::write(here.path().join("m.mhd"), header).expect("written");
    fs::write(here.path().join("m.raw"), &drawn.classes).expect("written");
    let done = willis(here.path(), &["infer", "m.mhd", "-o", "out"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let run: serde_json::Value =
        serde_json::from_slice(&fs::read(here.path().join("out/run.json")).expect("read")).expect("JSON");
    let (observed, candidates) = (&run["counts"]["observed"], &run["counts"]["candidates"]);
    let ends = run["boundary_conditions"].as_array().map(Vec::len);
    assert_eq!((observed.as_u64(), candidates.as_u64(), ends), (Some(2), Some(0), Some(2)), "{}", run["counts"]);
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

/// Noise, solid bodies and sponges are refused before they take time, thin and dense vessels are not.
#[test]
fn what_can_be_no_vessels_is_refused() {
    let draw = RefCell::new(Draw::new(5));
    for share in [0.05, 0.3, 0.5, 0.8] {
        let noise = mask([96; 3], |_| draw.borrow_mut().within(0.0, 1.0) < share);
        assert!(why_no_vessels(&noise).is_some_and(|why| why.starts_with("noise: ")), "{share}");
    }
    assert!(why_no_vessels(&mask([96; 3], |at| at.iter().sum::<usize>() % 2 == 0)).is_some());
    // An image whose background is inside: turned round, or cut at too low a level.
    for full in [mask([64; 3], |_| true), mask([64; 3], |[x, y, _]| x.abs_diff(32) > 4 || y.abs_diff(32) > 4)] {
        assert!(why_no_vessels(&full).is_some_and(|why| why.starts_with("too full: ")));
    }
    let body = mask([164; 3], |at| at.iter().all(|x| (1..163).contains(x)));
    assert!(why_no_vessels(&body).is_some_and(|why| why.starts_with("a solid body: ")));
    // A small body, a wide vessel, a bundle of vessels of two voxels, and a lattice of vessels.
    let is_bar = |at: [usize; 3]| at.iter().filter(|x| **x % 8 < 2).count() > 1;
    for vessels in [
        mask([96; 3], |at| at.iter().all(|x| (1..95).contains(x))),
        mask([164; 3], |[x, y, _]| x.abs_diff(82).pow(2) + y.abs_diff(82).pow(2) < 2500),
        mask([96; 3], |[x, y, _]| x % 6 < 2 && y % 6 < 2),
        mask([96; 3], is_bar),
    ] {
        assert_eq!(why_no_vessels(&vessels), None);
    }
    // Three branches and two loops to each of its nodes.
    let lattice = trace(&mask([104; 3], is_bar), RadiusFrom::Area, Cavities::Keep).expect("lines").lines;
    let said = why_no_centerlines(&lattice).expect("a sponge");
    assert!(said.starts_with("a sponge: ") && said.ends_with(&format!("with {} loops", graph(&lattice).1)), "{said}");
}
