//! The pictures: read back with a PNG decoder, and compared with what the numbers demand.

use proptest::prelude::{Just, Strategy, prop_assert, prop_oneof, proptest};
use willis::internals::modulation::BINS;
use willis::internals::report::figures::axis::{LinearRange, LogRange, Tick, TickLabel, count_ticks};
use willis::internals::report::figures::{
    Boxes, CoursePoint, CutLine, DEFAULT_DPI, DrawnVessel, Histogram, Histograms, LikelihoodMatrix, Panel, Projection,
    VesselFlow, ZERO, colour, convergence, flow_bars, heat_map, hypertension, modulation, orders, smoothed, summary,
};
use willis::internals::report::modulation::bins_in_one;
use willis::internals::sampling::Weight;
use willis::internals::support::gamma::Gamma;

struct Picture {
    size: [usize; 2],
    per_metre: u32,
    rgb: Vec<u8>,
}

impl Picture {
    fn read(file: &[u8]) -> Self {
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("a PNG header");
        let mut rgb = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut rgb).expect("an image");
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        let per_metre = reader.info().pixel_dims.expect("a resolution").xppu;
        Self { size: [info.width as usize, info.height as usize], per_metre, rgb }
    }

    fn at(&self, x: usize, y: usize) -> [u8; 3] {
        let start = (y * self.size[0] + x) * 3;
        [self.rgb[start], self.rgb[start + 1], self.rgb[start + 2]]
    }

    /// The places of a colour left of the colour bar.
    fn places(&self, rgb: [u8; 3]) -> Vec<[usize; 2]> {
        let places = (0..self.size[1]).flat_map(|y| (0..self.size[0] * 82 / 100).map(move |x| [x, y]));
        places.filter(|[x, y]| self.at(*x, *y) == rgb).collect()
    }

    fn count(&self, rgb: [u8; 3]) -> usize {
        self.rgb.chunks_exact(3).filter(|pixel| *pixel == rgb).count()
    }
}

const KEPT: [u8; 3] = [0x00, 0x72, 0xb2];

fn map(nodes: usize, entries: &[(u32, u32, f64)]) -> Picture {
    Picture::read(
        &heat_map(&LikelihoodMatrix { nodes, entries, ..LikelihoodMatrix::default() }, Weight::Resilience)
            .png(DEFAULT_DPI)
            .expect("a heat map"),
    )
}

/// The smallest box around places: first and last x, first and last y.
fn bounds(places: &[[usize; 2]]) -> [[usize; 2]; 2] {
    [0, 1].map(|axis| {
        let along = || places.iter().map(|p| p[axis]);
        [along().min().expect("a place"), along().max().expect("a place")]
    })
}

#[test]
fn the_size_and_the_resolution_follow_the_dpi() {
    for dpi in [36, 72, 150, 301, 600] {
        let heat = Picture::read(
            &heat_map(&LikelihoodMatrix { nodes: 2, entries: &[(0, 1, 1.0)], ..LikelihoodMatrix::default() }, Weight::Resilience)
                .png(dpi)
                .expect("a heat map"),
        );
        let curves = convergence(&[1, 2], &[vec![1.0, 2.0]], (CutLine::Threshold, &[1.5, 1.5]), &[true], Weight::Resilience)
            .png(dpi)
            .expect("a plot");
        let curves = Picture::read(&curves);
        let inches = |length: f64| (length * f64::from(dpi)).round() as usize;
        assert_eq!(heat.size, [inches(6.4), inches(5.6)]);
        assert_eq!(curves.size, [inches(6.4), inches(4.6)]);
        assert_eq!(heat.per_metre, (f64::from(dpi) / 0.0254).round() as u32);
    }
    for dpi in [0, 35, 1201, u32::MAX] {
        let error = heat_map(&LikelihoodMatrix { nodes: 2, ..LikelihoodMatrix::default() }, Weight::Resilience)
            .png(dpi)
            .expect_err("out of range")
            .to_string();
        assert!(error.contains(&dpi.to_string()) && error.contains("from 36 to 1200"), "{error}");
        assert!(convergence(&[], &[], (CutLine::Threshold, &[]), &[], Weight::Resilience).png(dpi).is_err());
    }
}

/// The hot cells of nodes 1 and 3 of 5 lie at (3, 1) and (1, 3): together they span the middle 3 x 3 cells.
#[test]
fn the_hottest_cell_has_the_top_colour_and_a_zero_the_background() {
    let entries = [(3, 1, 1e6), (0, 1, 1e3), (3, 4, 1.0), (0, 4, 0.0)];
    let picture = map(5, &entries);
    let hot = picture.places(colour(1.0));
    let [[left, right], [top, bottom]] = bounds(&hot);
    let cell = (right + 1 - left) / 3;
    assert_eq!(right + 1 - left, bottom + 1 - top);
    assert!(hot.len().abs_diff(2 * cell * cell) <= 5 * cell, "two whole squares of one colour, to a pixel");
    let middle = |row: usize, column: usize| picture.at(left + (2 * column - 1) * cell / 2, top + (2 * row - 1) * cell / 2);
    for (row, column, share) in [(1, 3, 1.0), (3, 1, 1.0), (3, 4, 0.0), (1, 2, f64::NAN), (2, 2, f64::NAN), (3, 3, f64::NAN)] {
        assert_eq!(middle(row, column), if share.is_nan() { ZERO } else { colour(share) }, "({row}, {column})");
    }
    let half = picture.places(colour(0.5));
    assert!(half.len() > (cell - 1) * (cell - 1), "10³ is half way from 1 to 10⁶");
}

#[test]
fn parallel_vessels_add_up_and_either_order_of_nodes_is_the_same() {
    let once = heat_map(
        &LikelihoodMatrix { nodes: 4, entries: &[(0, 1, 3.0), (2, 3, 700.0)], ..LikelihoodMatrix::default() },
        Weight::Resilience,
    )
    .png(100)
    .expect("a heat map");
    let parts = [(2, 3, 350.0), (1, 0, 3.0), (3, 2, 350.0)];
    assert_eq!(
        once,
        heat_map(&LikelihoodMatrix { nodes: 4, entries: &parts, ..LikelihoodMatrix::default() }, Weight::Resilience)
            .png(100)
            .expect("a heat map")
    );
}

#[test]
fn one_vessel_among_forty_thousand_nodes_is_seen_and_the_largest_wins_a_pixel() {
    let mut entries = vec![(20_000, 30_000, 1e9)];
    entries.extend((1..50).map(|k| (20_000 + k % 7, 30_000 + k, 1.0)));
    let picture = map(40_000, &entries);
    let hot = picture.places(colour(1.0));
    assert!((2 * 16..=2 * 25).contains(&hot.len()), "two marks of two points, 4 x 4 or 5 x 5 pixels");
    let [[left, right], [top, bottom]] = bounds(&hot);
    assert_eq!(right - left, bottom - top, "symmetric");
}

#[test]
fn every_cell_of_a_full_matrix_is_painted_whatever_the_number_of_nodes() {
    for nodes in [1_u32, 2, 3, 7, 60, 165, 166, 300, 663, 700] {
        let entries: Vec<_> = (0..nodes).flat_map(|a| (a..nodes).map(move |b| (a, b, 5.0))).collect();
        let picture = map(nodes as usize, &entries);
        let hot = picture.places(colour(1.0));
        let [[left, right], [top, bottom]] = bounds(&hot);
        assert_eq!(hot.len(), (right + 1 - left) * (bottom + 1 - top), "{nodes} nodes: no hole");
        assert!((655..=663).contains(&(right + 1 - left)), "{nodes} nodes fill the axes");
    }
}

#[test]
fn the_map_darkens_steadily_and_takes_anything() {
    let luminance = |[r, g, b]: [u8; 3]| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
    for k in 0..100 {
        assert!(luminance(colour(f64::from(k + 1) / 100.0)) < luminance(colour(f64::from(k) / 100.0)));
    }
    assert_eq!((colour(-1.0), colour(f64::NAN), colour(7.0)), (colour(0.0), colour(0.0), colour(1.0)));
}

#[test]
fn the_same_numbers_give_the_same_bytes_on_any_thread() {
    let entries: Vec<_> = (0..900).map(|k| (k % 300, (k * 7 + 1) % 300, 1.7_f64.powi(k as i32 % 40))).collect();
    let series: Vec<Vec<f64>> = (1..40).map(|k| (1..9).map(|n| f64::from(k * k) / f64::from(n)).collect()).collect();
    let kept: Vec<bool> = (0..series.len()).map(|k| k > 20).collect();
    let samples: Vec<u64> = (1..9).collect();
    let both = || {
        let heat =
            heat_map(&LikelihoodMatrix { nodes: 300, entries: &entries, ..LikelihoodMatrix::default() }, Weight::Resilience)
                .png(110)
                .expect("a heat map");
        (
            heat,
            convergence(&samples, &series, (CutLine::Threshold, &[3.0; 8]), &kept, Weight::Resilience).png(110).expect("a plot"),
        )
    };
    let first = both();
    std::thread::scope(|scope| {
        for other in [scope.spawn(both), scope.spawn(both)] {
            assert!(other.join().expect("a thread") == first);
        }
    });
}

#[test]
fn nothing_to_draw_is_a_picture_that_says_so() {
    for nodes in [0, 1, 3] {
        let picture = map(nodes, &[]);
        assert_eq!(picture.count(colour(1.0)), 0);
        assert!(picture.count(ZERO) > picture.size[0] * picture.size[1] / 3);
    }
    let blank = |samples: &[u64], series: &[Vec<f64>], threshold: &[f64], kept: &[bool]| {
        convergence(samples, series, (CutLine::Threshold, threshold), kept, Weight::Resilience).png(DEFAULT_DPI).expect("a plot")
    };
    let no_edge = blank(&[10, 20], &[], &[f64::NAN, f64::NAN], &[]);
    let no_checkpoint = blank(&[], &[vec![]], &[], &[true]);
    let no_value = blank(&[10], &[vec![0.0]], &[0.0], &[true]);
    for picture in [&no_edge, &no_checkpoint, &no_value] {
        assert_eq!(Picture::read(picture).count(KEPT), 0, "no legend either");
    }
    assert!(no_edge != no_checkpoint && no_checkpoint != no_value && no_edge != no_value);
}

/// Two edges, one far above the threshold and one far below it.
#[test]
fn kept_edges_are_blue_and_pruned_ones_vermilion() {
    for checkpoints in [1, 20] {
        let samples: Vec<u64> = (1..=checkpoints as u64).collect();
        let series = [vec![50.0; checkpoints], vec![0.5; checkpoints]];
        for kept in [[true, false], [false, true], [true, true]] {
            let file = convergence(&samples, &series, (CutLine::Threshold, &vec![5.0; checkpoints]), &kept, Weight::Resilience)
                .png(DEFAULT_DPI)
                .expect("a plot");
            let picture = Picture::read(&file);
            // Below the legend; the threshold is half way.
            for (rows, kept) in [(110..300, kept[0]), (400..590, kept[1])] {
                let pixels = || rows.clone().flat_map(|y| (0..picture.size[0]).map(move |x| (x, y)));
                let more =
                    |a: usize, b: usize| pixels().any(|(x, y)| picture.at(x, y)[a] > picture.at(x, y)[b].saturating_add(90));
                assert_eq!((more(2, 0), more(0, 2)), (kept, !kept));
            }
        }
    }
}

#[test]
fn zeros_huge_ranges_and_single_checkpoints_are_drawn() {
    let (tiny, huge) = (f64::MIN_POSITIVE, f64::MAX);
    for series in [vec![0.0, tiny, huge], vec![0.0; 3], vec![huge; 3], vec![tiny / 1e3; 3]] {
        Picture::read(
            &convergence(
                &[1, 2, u64::MAX],
                std::slice::from_ref(&series),
                (CutLine::Threshold, &[0.0, f64::NAN, 1.0]),
                &[true],
                Weight::Resilience,
            )
            .png(72)
            .expect("a plot"),
        );
        let entries: Vec<_> = (0..).zip(&series).map(|(k, v)| (k, 0, *v)).collect();
        map(3, &entries);
    }
    map(2, &[(0, 1, huge), (1, 0, huge)]);
}

#[test]
fn thousands_of_edges_are_drawn() {
    let samples: Vec<u64> = (1..=50).map(|n| n * 20).collect();
    let row = |k: u32| (0..50).map(|n| f64::from(k) * (1.0 + 0.3 * f64::from(n * k % 11) / f64::from(n + 1))).collect();
    let series: Vec<Vec<f64>> = (0..4000).map(row).collect();
    let kept: Vec<bool> = (0..4000).map(|k| k > 2000).collect();
    Picture::read(
        &convergence(&samples, &series, (CutLine::Threshold, &[2000.0; 50]), &kept, Weight::Resilience)
            .png(DEFAULT_DPI)
            .expect("a plot"),
    );
}

const PERTURBED: [u8; 3] = [0xe6, 0x9f, 0x00];

fn bars(flows: &[(f64, Option<f64>)]) -> Picture {
    let flow = |(row, (unperturbed, perturbed)): (usize, &(f64, Option<f64>))| VesselFlow {
        name: format!("vessel {row}"),
        unperturbed: *unperturbed,
        perturbed: *perturbed,
    };
    let flows: Vec<VesselFlow> = flows.iter().enumerate().map(flow).collect();
    Picture::read(&flow_bars(&flows).png(DEFAULT_DPI).expect("bars"))
}

/// Below the legend: two vessels of -200 and 100 mL/min, of which the second turns round to half its flow. The first bar is
/// twice as long as the second, both to the right; of the perturbed ones the first is as long as the second unperturbed
/// one, and the second goes half as far to the left.
#[test]
fn bars_are_as_long_as_their_flows_and_only_a_reversed_one_goes_left() {
    let picture = bars(&[(-200.0, Some(-100.0)), (100.0, Some(-50.0))]);
    let [width, height] = picture.size;
    let below = |rgb| -> Vec<[usize; 2]> {
        let places = (height * 35 / 100..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        places.filter(|[x, y]| picture.at(*x, *y) == rgb).collect()
    };
    let split = |places: Vec<[usize; 2]>| {
        let [_, [top, bottom]] = bounds(&places);
        let (upper, lower): (Vec<_>, Vec<_>) = places.into_iter().partition(|[_, y]| *y < usize::midpoint(top, bottom));
        [bounds(&upper)[0], bounds(&lower)[0]]
    };
    let [first, second] = split(below(KEPT));
    let [first_after, second_after] = split(below(PERTURBED));
    let near = |a: usize, b: usize| assert!(a.abs_diff(b) <= 5, "{a} and {b}");
    let length = |[left, right]: [usize; 2]| right - left;
    near(first[0], second[0]);
    near(length(first), 2 * length(second));
    near(length(first_after), length(second));
    near(second_after[1], second[0]);
    near(2 * length(second_after), length(second));
}

#[test]
fn forty_vessels_at_the_most_are_shown_and_none_is_no_fault() {
    let many: Vec<(f64, Option<f64>)> = (1..=50).map(|q| (f64::from(q), None)).collect();
    assert_eq!(bars(&many).size, bars(&many[..40]).size);
    assert!(bars(&many).size[1] > bars(&many[..39]).size[1]);
    bars(&[]);
    bars(&[(0.0, None)]);
    bars(&[(0.0, Some(0.0))]);
    bars(&[(1e-12, None), (3e-13, None)]);
    bars(&[(f64::NAN, None), (f64::INFINITY, None), (1.0, None)]);
}

const EACH: [u8; 3] = [0x56, 0xb4, 0xe9];
const WHOLE: [u8; 3] = [0xe6, 0x9f, 0x00];

/// A box is filled from its first to its third quartile: twice the spread, twice the colour, in either box of a class. No figures,
/// no box.
#[test]
fn a_box_is_as_high_as_its_quartiles_are_apart() {
    let boxes = |half: f64, whole: f64| Boxes { each: [-10.0, -half, 0.0, half, 10.0], whole: [-10.0, -whole, 0.0, whole, 10.0] };
    let panel = |boxes: Boxes| Panel { name: "change".into(), unchanged: 0.0, boxes: vec![boxes] };
    let drawn = |b: Boxes| {
        let panels = [panel(b), panel(b), panel(b)];
        let picture = modulation(&["0\u{2013}0.2".to_owned()], &panels).png(DEFAULT_DPI).expect("a picture");
        let picture = Picture::read(&picture);
        [EACH, WHOLE].map(|rgb| picture.count(rgb) as f64)
    };
    // The outline and the bar of the median take the same from every box.
    let [[two, four], [_, eight]] = [drawn(boxes(2.0, 4.0)), drawn(boxes(4.0, 8.0))];
    assert!(((eight - four) / (four - two) - 2.0).abs() < 0.05, "{two} {four} {eight}");
    let none = drawn(boxes(f64::NAN, f64::NAN));
    assert!(none[0] == none[1] && none[0] < two / 20.0);
}

/// Bars hold as much colour as density; a page grows with its classes; no force is said in words.
#[test]
fn a_histogram_is_as_large_as_its_density() {
    let one = |density: Vec<f64>| Histogram { heading: "u".into(), density, fit: None };
    let drawn = |classes: Vec<Histogram>, edges: &[f64]| {
        let histograms = Histograms { edges: edges.to_vec(), threshold: 3.5, classes };
        Picture::read(&hypertension(&histograms).png(DEFAULT_DPI).expect("a picture"))
    };
    let edges = [0.0, 1.0, 2.0, 3.0, 4.0];
    let single = drawn(vec![one(vec![0.4, 0.2, 0.2, 0.2])], &edges);
    let half = drawn(vec![one(vec![0.4, 0.05, 0.05, 0.0])], &edges);
    let legend = drawn(vec![one(vec![0.0; 4])], &edges).count(EACH);
    let areas = [&single, &half].map(|picture| (picture.count(EACH) - legend) as f64);
    assert!((areas[1] / areas[0] - 0.5).abs() < 0.03, "{areas:?}");
    let curve = Histogram { fit: Some(Gamma { shape: 0.7, scale: 2.0 }), ..one(vec![0.25; 4]) };
    let double = drawn(vec![curve.clone(), curve], &edges);
    assert!(double.size[1] > single.size[1] + 100);
    assert!(drawn(vec![one(Vec::new())], &[]).count([0x1a; 3]) > 50);
}

/// A vessel that turns back on itself in a plane: nothing is drawn further off than its radius, however sharp its corners.
#[test]
fn a_thick_vessel_has_no_spikes_at_its_corners() {
    let course = (0..9).map(|i| [f64::from(i % 2) * 40.0, 0.0, f64::from(i) * 2.0, 1.0]).collect();
    let vessel = DrawnVessel { course, probability: None, certain: true, kept: true };
    let view = || Projection { name: "", right: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0], edges: ["", ""] };
    let picture = summary("", ["", ""], vec![vessel], &[], &[view(), view()]);
    let picture = Picture::read(&picture.png(DEFAULT_DPI).expect("a picture"));
    let inside = |x: usize| (14.0..=198.0).contains(&(x as f64 * 72.0 / 150.0)) || x * 72 > 206 * 150;
    let page = |y: usize| (64..254).contains(&(y * 72 / 150));
    let dirty = |x: usize, y: usize| page(y) && !inside(x) && picture.at(x, y) != [255; 3];
    assert!((0..picture.size[1]).all(|y| (0..picture.size[0]).all(|x| !dirty(x, y))), "ink beside the panel");
    let grey = picture.rgb.chunks_exact(3).filter(|p| p[0] < 0xe0 && p[0] > 0x70).count();
    assert!(grey > 1000, "the vessel itself is there: {grey}");
}

#[test]
fn ticks_are_a_few_round_numbers() {
    let read = |low, high, most| {
        let text = |t: Tick| match t.label.exponent.as_str() {
            "" => t.label.text,
            exponent => format!("{}^{exponent}", t.label.text),
        };
        LinearRange { low, high }.ticks(most).into_iter().map(text).collect::<Vec<_>>()
    };
    assert_eq!(read(0.0, 1.0, 6), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    assert_eq!(read(-3.2, 1.1, 6), ["\u{2212}3", "\u{2212}2", "\u{2212}1", "0", "1"]);
    assert_eq!(read(0.0, 4200.0, 6), ["0", "1000", "2000", "3000", "4000"]);
    assert_eq!(read(-120.0, 230.0, 6), ["\u{2212}100", "0", "100", "200"]);
    assert_eq!(read(0.0, 0.04, 7), ["0", "0.01", "0.02", "0.03", "0.04"]);
    assert_eq!(read(0.0, 5e-7, 6)[..2], ["0", "1\u{b7}10^\u{2212}7"]);
    assert_eq!(read(0.0, 2e-310, 6), [""; 0]);
    assert_eq!(read(0.0, f64::INFINITY, 6), [""; 0]);
    assert_eq!(LinearRange::of([f64::NAN]), None);
    assert!(LinearRange::of([2.0, 2.0]).is_some_and(|r| r.low < 2.0 && r.high > 2.0));
}

fn read(ticks: &[Tick]) -> Vec<String> {
    let text = |label: &TickLabel| match label.exponent.as_str() {
        "" => label.text.clone(),
        exponent => format!("{}^{exponent}", label.text),
    };
    ticks.iter().map(|tick| text(&tick.label)).collect()
}

#[test]
fn counts_are_a_few_round_numbers() {
    assert_eq!(read(&count_ticks(0, 6)), ["0"]);
    assert_eq!(read(&count_ticks(4, 6)), ["0", "1", "2", "3", "4"]);
    assert_eq!(read(&count_ticks(59, 6)), ["0", "10", "20", "30", "40", "50"]);
    assert_eq!(read(&count_ticks(29_999, 6)), ["0", "5000", "10,000", "15,000", "20,000", "25,000"]);
    assert_eq!(read(&count_ticks(2_000_000, 6))[3..], ["1,500,000", "2,000,000"]);
    assert!(count_ticks(u64::MAX, 6).len() <= 7);
}

#[test]
fn a_wide_range_has_powers_of_ten_and_a_narrow_one_steps_of_1_2_5() {
    let ticks = |low: f64, high: f64| read(&LogRange::of([low, high, 0.0]).expect("positive values").ticks());
    assert_eq!(ticks(0.5, 2e3), ["10^0", "10^1", "10^2", "10^3"]);
    assert_eq!(ticks(3.0, 70.0), ["5", "10", "20", "50"]);
    assert_eq!(ticks(7.0, 7.0), ["1", "2", "5"]);
    assert_eq!(ticks(0.02, 0.3), ["0.02", "0.05", "0.1", "0.2"]);
    assert_eq!(ticks(3e8, 3e8), ["5\u{b7}10^7", "10^8", "2\u{b7}10^8"]);
    assert!(ticks(f64::MIN_POSITIVE, f64::MAX).len() <= 10);
}

#[test]
fn what_is_twelve_decades_below_the_largest_is_left_out() {
    let range = LogRange::of([1e-20, 1e3]).expect("positive values");
    assert!(range.clipped && range.share(1e-20) < 0.0 && range.share(1e3) >= 1.0);
    assert_eq!(range.low.to_bits(), (-9.0_f64).to_bits());
    assert_eq!(LogRange::of([0.0]), None);
}
/// Any number a double can be.
fn any() -> impl Strategy<Value = f64> {
    prop_oneof![
        any_double(),
        Just(0.0),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
        Just(5e-324),
        Just(f64::INFINITY),
        Just(f64::NAN)
    ]
}

fn any_double() -> impl Strategy<Value = f64> {
    proptest::num::f64::ANY
}

proptest! {
    #[test]
    fn ticks_of_any_values_are_few_and_lie_on_the_axis(a in any(), b in any(), most in 2_usize..12) {
        if let Some(range) = LinearRange::of([a, b]) {
            let ticks = range.ticks(most);
            prop_assert!(ticks.len() <= most);
            prop_assert!(ticks.iter().all(|t| (-1e-6..=1.0 + 1e-6).contains(&range.share(t.at))));
        }
        // As figures make them: from zero to a quantity.
        let from_zero = LinearRange { low: 0.0, high: a }.ticks(most).len();
        prop_assert!(from_zero <= most);
        if let Some(range) = LogRange::of([a, b]) {
            let ticks = range.ticks();
            prop_assert!((1..=14).contains(&ticks.len()), "{}", ticks.len());
            prop_assert!(ticks.iter().all(|t| (-1e-6..=1.0 + 1e-6).contains(&range.share_of_log(t.at))));
        }
    }

    #[test]
    fn ticks_of_counts_are_few(last in proptest::num::u64::ANY, most in 2_usize..12) {
        prop_assert!(count_ticks(last, most).len() <= most + 1);
    }
}

/// By hand: a straight vessel of one radius stays as it is; on a long one of radii 1 and 3 in turn every inner radius is near 2, and
/// the ends stay in place; a corner of a thick vessel moves half way, that of a thin one by 0.3 radii.
#[test]
fn noise_goes_and_what_is_even_stays() {
    let even: Vec<CoursePoint> = (0..5).map(|i| [f64::from(i), 0.0, 0.0, 0.5]).collect();
    for (a, b) in smoothed(&even).iter().zip(&even) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} {b:?}");
    }
    let noisy: Vec<CoursePoint> = (0..101).map(|i| [f64::from(i), 0.0, 0.0, f64::from(1 + 2 * (i % 2))]).collect();
    let calm = smoothed(&noisy);
    assert!(calm.iter().all(|p| (p[3] - 2.0).abs() < 0.1));
    assert_eq!((&calm[0][..3], &calm[100][..3]), (&noisy[0][..3], &noisy[100][..3]));
    let corner = |radius| smoothed(&[[0.0, 0.0, 0.0, radius], [1.0, 1.0, 0.0, radius], [2.0, 0.0, 0.0, radius]])[1][1];
    assert!((corner(10.0) - 0.5).abs() < 1e-12 && (corner(0.1) - 0.97).abs() < 1e-12);
    assert_eq!(smoothed(&even[..2]), even[..2]);
    assert!(smoothed(&[]).is_empty());
}

/// 2 n^⅓ is 2, 5.4, 12.6 and 43.1, and 50 is divided by 1, 2, 5, 10, 25 and 50.
#[test]
fn a_picture_has_as_many_bins_as_its_vessels_carry() {
    assert_eq!([1, 20, 250, 10_000, 100_000].map(|vessels| BINS / bins_in_one(vessels)), [2, 10, 25, 50, 50]);
}

/// A source s with a long branch (a, b, c) and a short one (d): the short one comes first. The second source has e alone.
#[test]
fn smaller_branches_come_first() {
    let [s, a, b, c, d, t, e] = [0, 1, 2, 3, 4, 5, 6];
    let visited = [s, t, a, d, e, b, c];
    let before = [None, None, Some(s), Some(s), Some(t), Some(a), Some(b)];
    assert_eq!(orders(&[s, t], &visited, &before, 7), [vec![s, d, a, b, c], vec![t, e]]);
}
