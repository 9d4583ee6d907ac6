//! The pictures as SVG: read back with an XML parser, against places worked out by hand and against the PNG of the same figure.

use crate::command;
use base64::Engine;
use roxmltree::{Document, Node};
use willis::internals::report::figures::{
    ArteryWaveform, Boxes, CutLine, DrawnVessel, Figure, Histogram, Histograms, LikelihoodMatrix, NodeBlock, OutletSupply, Panel,
    Projection, Ring, VesselFlow, colour, convergence, flow_bars, heat_map, hypertension, modulation, summary, supply_bars,
    waveform_panels,
};
use willis::internals::sampling::Weight;
use willis::internals::support::gamma::Gamma;

const KEPT: &str = "#0072b2";
const PRUNED: &str = "#d55e00";
const INK: &str = "#1a1a1a";
/// Points from the page's corner to that of the axes of the convergence, and to their other corner.
const AXES: [[f64; 2]; 2] = [[62.0, 50.0], [440.0, 284.0]];

fn heat(nodes: usize, entries: &[(u32, u32, f64)]) -> Figure {
    heat_map(&LikelihoodMatrix { nodes, entries, ..LikelihoodMatrix::default() }, Weight::Resilience)
}

fn bars(flows: &[(&str, f64, Option<f64>)]) -> Figure {
    let flow = |(name, unperturbed, perturbed): &(&str, f64, Option<f64>)| VesselFlow {
        name: (*name).to_owned(),
        unperturbed: *unperturbed,
        perturbed: *perturbed,
    };
    flow_bars(&flows.iter().map(flow).collect::<Vec<_>>())
}

/// One of each kind.
fn figures() -> Vec<Figure> {
    let boxes = Boxes { each: [-2.0, -1.0, 0.0, 1.0, 2.0], whole: [-1.0, -0.5, 0.0, 0.5, 1.0] };
    let panel = |name: &str| Panel { name: name.to_owned(), unchanged: 0.0, boxes: vec![boxes] };
    let one = Histogram { heading: "u".into(), density: vec![0.5, 0.5], fit: Some(Gamma { shape: 2.0, scale: 0.5 }) };
    vec![
        heat(3, &[(0, 1, 3.0), (1, 2, 700.0)]),
        heat(3, &[]),
        convergence(
            &[10, 20],
            &[vec![1.0, 2.0], vec![0.0, 3.0]],
            (CutLine::Threshold, &[2.0, 2.0]),
            &[true, false],
            Weight::Resilience,
        ),
        bars(&[("L-M1", -20.0, Some(10.0)), ("R-M1", 10.0, None)]),
        modulation(&["0\u{2013}0.2".to_owned()], &["p", "q", "r"].map(panel)),
        hypertension(&Histograms { edges: vec![0.0, 1.0, 2.0], threshold: 1.5, classes: vec![one] }),
    ]
}

/// The places that a path goes through and its control points, in points.
fn places(d: &str) -> Vec<[f64; 2]> {
    let spaced: String = d
        .chars()
        .flat_map(|c| match c {
            'a'..='z' | 'A'..='Z' => vec![' ', c, ' '],
            '-' => vec![' ', '-'],
            other => vec![other],
        })
        .collect();
    let (mut at, mut out, mut command, mut numbers) = ([0.0, 0.0], Vec::new(), ' ', Vec::new());
    for word in spaced.split_whitespace() {
        let Ok(number) = word.parse::<f64>() else {
            command = word.chars().next().expect("a letter");
            assert!(numbers.is_empty(), "{d}");
            continue;
        };
        numbers.push(number / 100.0);
        let wanted = match command {
            'H' | 'V' => 1,
            'q' => 4,
            'c' => 6,
            _ => 2,
        };
        if numbers.len() < wanted {
            continue;
        }
        let from = if command.is_ascii_uppercase() { [0.0, 0.0] } else { at };
        match command {
            'H' => at[0] = numbers[0],
            'V' => at[1] = numbers[0],
            _ => {
                for pair in numbers.chunks_exact(2) {
                    out.push([from[0] + pair[0], from[1] + pair[1]]);
                }
                at = out.pop().expect("an end");
            }
        }
        out.push(at);
        numbers.clear();
    }
    out
}

/// First and last x, first and last y.
fn bounds(places: &[[f64; 2]]) -> [[f64; 2]; 2] {
    [0, 1].map(|axis| {
        places.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| [low.min(p[axis]), high.max(p[axis])])
    })
}

fn paths<'a>(svg: &'a Document<'_>, attribute: &str, value: &str) -> Vec<Node<'a, 'a>> {
    svg.descendants()
        .filter(|n| n.has_tag_name(("http://www.w3.org/2000/svg", "path")) && n.attribute(attribute) == Some(value))
        .collect()
}

/// A text of a figure: what it says, and the box that it takes in a font whose letters are .56 of their size wide on average, as those of DejaVu Sans, in
/// points.
fn texts(svg: &Document<'_>) -> Vec<(String, [[f64; 2]; 2])> {
    let all = svg.descendants().filter(|n| n.has_tag_name(("http://www.w3.org/2000/svg", "text")));
    let measured = all.map(|text| {
        let number = |name| text.attribute(name).and_then(|t| t.parse::<f64>().ok()).expect("a number") / 100.0;
        let words: String = text.descendants().filter_map(|n| if n.is_text() { n.text() } else { None }).collect();
        let (at, size) = ([number("x"), number("y")], number("font-size"));
        let long = 0.56 * size * words.chars().count() as f64;
        let back = match text.attribute("text-anchor") {
            None => 0.0,
            Some("middle") => long / 2.0,
            Some("end") => long,
            other => panic!("{other:?}"),
        };
        let (along, across) = ([-back, long - back], [-0.75 * size, 0.25 * size]);
        let sides = match text.attribute("transform") {
            None => [along.map(|by| at[0] + by), across.map(|by| at[1] + by)],
            Some(turn) => {
                assert_eq!(turn, format!("rotate(-90 {} {})", at[0] * 100.0, at[1] * 100.0));
                [across.map(|by| at[0] + by), along.map(|by| at[1] - by)]
            }
        };
        (words, sides.map(|[a, b]| [a.min(b), a.max(b)]))
    });
    measured.collect()
}

fn said(svg: &Document<'_>, words: &str) -> usize {
    texts(svg).iter().filter(|(text, _)| text == words).count()
}

fn d(path: &Node<'_, '_>) -> Vec<[f64; 2]> {
    places(path.attribute("d").expect("a path"))
}

/// The boxes of a colour, which a path has several of.
fn boxes(svg: &Document<'_>, rgb: [u8; 3]) -> Vec<[[f64; 2]; 2]> {
    let [r, g, b] = rgb;
    let all = paths(svg, "fill", &format!("#{r:02x}{g:02x}{b:02x}"));
    let each = all.iter().flat_map(|path| path.attribute("d").expect("a path").split_inclusive('z'));
    each.map(|one| bounds(&places(one))).collect()
}

fn near(got: [f64; 2], want: [f64; 2], within: f64) {
    assert!((got[0] - want[0]).abs() <= within && (got[1] - want[1]).abs() <= within, "{got:?} is not {want:?}");
}

/// The pixels of a PNG: its width, its height, red, green and blue.
fn pixels(file: &[u8]) -> (usize, usize, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("a PNG header");
    let mut rgb = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut rgb).expect("an image");
    (info.width as usize, info.height as usize, rgb)
}

#[test]
fn every_figure_is_well_formed_and_refers_to_nothing_outside() {
    for figure in figures() {
        let text = figure.svg().expect("an SVG");
        assert_eq!(text, figure.svg().expect("an SVG"), "the same bytes again");
        let svg = Document::parse(&text).expect("well-formed");
        let root = svg.root_element();
        let (width, height, _) = pixels(&figure.png(72).expect("a PNG"));
        let points =
            |name| root.attribute(name).and_then(|t| t.strip_suffix("pt")).and_then(|t| t.parse().ok()).unwrap_or(f64::NAN);
        near([points("width"), points("height")], [width as f64, height as f64], 0.5);
        for node in root.descendants().filter(Node::is_element) {
            let tag = node.tag_name().name();
            assert!(["svg", "path", "linearGradient", "stop", "image", "text", "tspan", "style"].contains(&tag), "{tag}");
            if tag == "text" {
                // Any reader has a font of the last name.
                assert!(node.attribute("font-family").is_some_and(|fonts| fonts.ends_with(", sans-serif")));
                assert!(node.descendants().any(|n| n.is_text()));
            }
            assert!(!node.has_attribute("aria-label") || tag == "svg", "words are text");
            for attribute in node.attributes() {
                let value = attribute.value();
                match attribute.name() {
                    "href" => assert!(value.starts_with("data:image/png;base64,")),
                    "id" => assert!(value.starts_with(figure.name())),
                    _ => assert!(!value.contains("//") && (!value.contains("url(") || value.starts_with("url(#")), "{value}"),
                }
            }
            if tag == "path" {
                let all = d(&node);
                let [[left, right], [top, bottom]] = bounds(&all);
                assert!(
                    left >= 0.0 && top >= 0.0 && right <= points("width") && bottom <= points("height"),
                    "{all:?} off the page"
                );
            }
        }
    }
}

/// Of 100, 10 and 1 W/m³ over two decades with 4 % of air at each end, 100 lies at (2 + 0.08)/2.16 of the height; 10 of 20 samples
/// lie at 10/(20 · 1.02) of the width.
#[test]
fn there_is_a_curve_a_series_through_the_places_worked_out_by_hand() {
    let series = [vec![100.0, 100.0], vec![1.0, 1.0], vec![10.0, 1.0]];
    let figure = convergence(&[10, 20], &series, (CutLine::Threshold, &[10.0, 10.0]), &[true, false, false], Weight::Resilience);
    let text = figure.svg().expect("an SVG");
    let svg = Document::parse(&text).expect("well-formed");
    // Those of the legend are above the axes.
    let curves = |rgb| -> Vec<_> { paths(&svg, "stroke", rgb).iter().map(d).filter(|p| p[0][1] > AXES[0][1]).collect() };
    let [kept, pruned] = [curves(KEPT), curves(PRUNED)];
    assert_eq!((kept.len(), pruned.len()), (1, 2));
    let [[left, top], [right, bottom]] = AXES;
    let x = |n: f64| left + (right - left) * n / (20.0 * 1.02);
    let y = |log: f64| bottom - (bottom - top) * (log + 0.08) / 2.16;
    for (curve, logs) in [(&kept[0], [2.0, 2.0]), (&pruned[0], [0.0, 0.0]), (&pruned[1], [1.0, 0.0])] {
        assert_eq!(curve.len(), 2);
        near(curve[0], [x(10.0), y(logs[0])], 0.0051);
        near(curve[1], [x(20.0), y(logs[1])], 0.0051);
    }
    // The PNG has the same curve there and nowhere near.
    let dpi = 300;
    let (width, _, rgb) = pixels(&figure.png(dpi).expect("a PNG"));
    let blue = |[x, y]: [f64; 2]| {
        let [x, y] = [x, y].map(|points| (points * f64::from(dpi) / 72.0) as usize);
        let pixel = &rgb[3 * (y * width + x)..][..3];
        i32::from(pixel[2]) - i32::from(pixel[0]) > 60
    };
    let middle = x(15.0);
    assert!(blue([middle, y(2.0)]) && !blue([middle, y(2.0) - 2.0]) && !blue([middle, y(2.0) + 2.0]));
}

/// The title begins, stands on its line and has the height in the PNG that it has in the SVG, to a point. A capital is .7 of the size.
#[test]
fn text_is_where_the_png_has_it() {
    let figure = heat(5, &[(0, 1, 1.0)]);
    let text = figure.svg().expect("an SVG");
    let svg = Document::parse(&text).expect("well-formed");
    let words = texts(&svg);
    let of = |name: &str| words.iter().filter(|(text, _)| text == name).map(|(_, sides)| *sides).collect::<Vec<_>>();
    let [[[left, _], [top, bottom]]] = of("Likelihood matrix (5 nodes)")[..] else { panic!("one title") };
    let (width, _, rgb) = pixels(&figure.png(720).expect("a PNG"));
    let dark = |i: &usize| rgb[3 * i] < 128;
    let ink: Vec<[f64; 2]> =
        (0..width * 300).filter(dark).map(|i| [(i % width) as f64 / 10.0, (i / width) as f64 / 10.0]).collect();
    let ink = bounds(&ink);
    near([ink[0][0], ink[1][0]], [left, top], 1.5);
    assert!((ink[1][1] - bottom).abs() < 1.5, "{ink:?}");
    let upwards = of("node").iter().filter(|[x, y]| y[1] - y[0] > x[1] - x[0]).count();
    assert_eq!(upwards, 1, "one of the two names of axes runs upwards");
}

/// Nothing is cut off at an edge of a page, whatever the names, in fonts wider than that of the bitmaps too.
#[test]
fn every_word_is_inside_the_page() {
    let long = "a-name-that-nobody-would-give-to-a-vessel_".repeat(6);
    let supply = |name: &str| OutletSupply { name: name.to_owned(), flow: 1.0, states: vec![Some((vec![0.5, 0.5], 2345.0)); 2] };
    let wave = |name: &str| ArteryWaveform {
        name: name.to_owned(),
        is_named: true,
        states: vec![(vec![123.0, -45.0, 67.0], 123.4, 12.34); 2],
    };
    let inlets = ["x", &*long].map(|name| (name.to_owned(), [0, 114, 178]));
    let view = |name| Projection { name, right: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0], edges: ["R", "L"] };
    let vessel = DrawnVessel { course: vec![[0.0; 4], [9.0, 9.0, 9.0, 1.0]], probability: None, certain: true, kept: true };
    let block = |nodes: [usize; 2]| NodeBlock { name: long.clone(), nodes: nodes.to_vec() };
    let matrix = LikelihoodMatrix {
        nodes: 4,
        entries: &[(2, 0, 1.0), (1, 3, 10.0)],
        uncertain: &[],
        blocks: &[block([2, 0]), block([1, 3])],
    };
    let mut all = figures();
    all.extend([
        bars(&[(&long, -20.0, Some(10.0))]),
        supply_bars(&[supply(&long), supply("y")], &inlets),
        waveform_panels(&[wave(&long), wave("y"), wave("z"), wave("w"), wave(&long)], 1.0),
        summary(&long, [&long, &long], vec![vessel], &[], &[view("front"), view("left side")]),
        heat_map(&matrix, Weight::Resilience),
        convergence(
            &[10],
            &vec![vec![1.0]; 200_000],
            (CutLine::Median, &[1.0]),
            &[vec![true; 100_000], vec![false; 100_000]].concat(),
            Weight::Resilience,
        ),
    ]);
    for figure in all {
        let text = figure.svg().expect("an SVG");
        let svg = Document::parse(&text).expect("well-formed");
        let size =
            svg.root_element().attribute("viewBox").expect("a size").split(' ').map(|n| n.parse::<f64>().expect("a number"));
        let size: Vec<f64> = size.map(|units| units / 100.0).collect();
        let words = texts(&svg);
        assert!(!words.is_empty());
        for (words, [x, y]) in words {
            let inside = x[0] >= 0.0 && y[0] >= 0.0 && x[1] <= size[2] && y[1] <= size[3];
            assert!(inside, "{}: {words} at {x:?}, {y:?} of {size:?}", figure.name());
        }
    }
}

/// Three rings in a row along x, seen from y: number 1 is left of 2, which is left of 3, each beside its ring; the 31st is not drawn. Without numbers there
/// are rings alone.
#[test]
fn rings_have_the_numbers_of_the_list() {
    let view = || Projection { name: "", right: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0], edges: ["", ""] };
    let course = vec![[0.0, 0.0, 0.0, 0.1], [60.0, 0.0, 0.0, 0.1]];
    let vessel = DrawnVessel { course, probability: None, certain: true, kept: true };
    let drawn = |rings: &[Ring]| summary("", ["", ""], vec![vessel.clone()], rings, &[view(), view()]).svg().expect("an SVG");
    let at = |x: f64, number| Ring { place: [x, 0.0, 0.0], number };
    let text = drawn(&[at(10.0, Some(1)), at(30.0, Some(2)), at(50.0, Some(3))]);
    let svg = Document::parse(&text).expect("well-formed");
    let rings: Vec<_> =
        paths(&svg, "stroke", INK).iter().map(d).filter(|places| places.len() == 37).map(|p| bounds(&p)).collect();
    assert_eq!(rings.len(), 6, "three in each view");
    let middle = |[x, y]: [[f64; 2]; 2]| [f64::midpoint(x[0], x[1]), f64::midpoint(y[0], y[1])];
    for (which, ring) in rings.iter().take(3).map(|sides| middle(*sides)).enumerate() {
        let numbers = texts(&svg).into_iter().filter(|(text, _)| *text == (which + 1).to_string());
        let near = numbers.filter(|(_, sides)| (middle(*sides)[0] - ring[0]).hypot(middle(*sides)[1] - ring[1]) < 14.0);
        assert_eq!(near.count(), 1, "{} beside its ring", which + 1);
    }
    let many: Vec<Ring> = (1..=40).map(|k| at(f64::from(k), Some(k as usize))).collect();
    let text = drawn(&many);
    let svg = Document::parse(&text).expect("well-formed");
    assert_eq!((said(&svg, "30"), said(&svg, "31")), (2, 0));
    let text = drawn(&[at(10.0, None)]);
    let svg = Document::parse(&text).expect("well-formed");
    assert!(texts(&svg).iter().all(|(words, _)| words.parse::<f64>().is_err() || ["0", "0.5", "1"].contains(&&**words)));
}

/// A side of 318 points and five nodes: 63.6 points a cell, from the corner (54, 34).
#[test]
fn the_cells_of_a_matrix_are_where_they_belong() {
    let text = heat(5, &[(3, 1, 1e6), (0, 4, 1.0)]).svg().expect("an SVG");
    let svg = Document::parse(&text).expect("well-formed");
    let hot = boxes(&svg, colour(1.0));
    let at = |node: f64, corner: f64| [corner + 63.6 * node, corner + 63.6 * (node + 1.0)];
    for (row, column) in [(1.0, 3.0), (3.0, 1.0)] {
        assert!(hot.iter().any(|[x, y]| {
            let [want_x, want_y] = [at(column, 54.0), at(row, 34.0)];
            (0..2).all(|i| (x[i] - want_x[i]).abs() < 0.006 && (y[i] - want_y[i]).abs() < 0.006)
        }));
    }
    assert_eq!(hot.len(), 2);
}

/// Blocks {2, 0} and {1, 3}: node 2 is in row 0, 0 in 1, 1 in 2 and 3 in 3, each of 318/4 points. The uncertain vessel joins 0 and 1; the second
/// matrix has these two alone, each of 318/2 points, 92 + 318 points to the right.
#[test]
fn a_matrix_has_its_nodes_in_blocks_and_the_uncertain_vessels_beside_it() {
    let block = |name: &str, nodes: [usize; 2]| NodeBlock { name: name.into(), nodes: nodes.to_vec() };
    let blocks = [block("inlet a", [2, 0]), block("inlet b", [1, 3])];
    let matrix = LikelihoodMatrix {
        nodes: 4,
        entries: &[(2, 0, 1.0), (1, 3, 10.0), (0, 1, 1e6)],
        uncertain: &[false, false, true],
        blocks: &blocks,
    };
    let text = heat_map(&matrix, Weight::Resilience).svg().expect("an SVG");
    let svg = Document::parse(&text).expect("well-formed");
    let mut hot = boxes(&svg, colour(1.0));
    hot.sort_by(|a, b| a[0][0].total_cmp(&b[0][0]));
    let left = hot.iter().map(|[x, _]| x[0]).collect::<Vec<_>>();
    let [cell, wide] = [318.0 / 4.0, 318.0 / 2.0];
    let second = 2.0 * 92.0 + 318.0;
    for (got, want) in left.iter().zip([92.0 + cell, 92.0 + 2.0 * cell, second, second + wide]) {
        assert!((got - want).abs() < 0.006, "{left:?}");
    }
    assert_eq!(left.len(), 4);
    for (name, times) in [("inlet a", 2), ("inlet b", 2), ("Likelihood matrix (4 nodes)", 1), ("Uncertain vessels (2 nodes)", 1)]
    {
        assert_eq!(said(&svg, name), times, "{name}");
    }
}

/// The most probable forest does not ask L: the line is the median of L, dashed, with the legend of what it is; and where nothing is
/// uncertain, a sentence says so.
#[test]
fn the_median_is_dashed_and_nothing_uncertain_is_a_sentence() {
    let series = [vec![100.0, 100.0], vec![1.0, 1.0]];
    let figure = convergence(&[10, 20], &series, (CutLine::Median, &[10.0, 10.0]), &[true, false], Weight::Resilience);
    let text = figure.svg().expect("an SVG");
    let svg = Document::parse(&text).expect("well-formed");
    let [_, [right, _]] = AXES;
    let dashed = paths(&svg, "stroke-dasharray", "400 300").iter().map(d).collect::<Vec<_>>();
    let [median, _] = &dashed[..] else { panic!("the median and its key: {dashed:?}") };
    let middle = AXES[1][1] - (AXES[1][1] - AXES[0][1]) / 2.0;
    let length = (right - AXES[0][0]) / (20.0 * 1.02) * 10.0;
    near([median[0][1], median[1][1]], [middle; 2], 0.011);
    assert!((median[1][0] - median[0][0] - length).abs() < 0.011, "{median:?}");
    assert_eq!(said(&svg, "median of L (not the rule)"), 1);
    let none = convergence(&[10], &[], (CutLine::Median, &[f64::NAN]), &[], Weight::Resilience).svg();
    let none = none.expect("an SVG");
    assert!(none.contains("Every vessel is certain") && !none.contains("stroke"), "no axes around nothing");
}

#[test]
fn a_large_matrix_is_one_small_image() {
    let entries: Vec<_> = (0..20_000).map(|k| (k % 5000, (k * 13 + 7) % 5000, 1.0 + f64::from(k % 50))).collect();
    let text = heat(5000, &entries).svg().expect("an SVG");
    assert!(text.len() < 1_000_000, "{} bytes", text.len());
    let svg = Document::parse(&text).expect("well-formed");
    let images: Vec<_> = svg.descendants().filter(|n| n.tag_name().name() == "image").collect();
    assert_eq!(images.len(), 1);
    let data = images[0]
        .attribute(("http://www.w3.org/1999/xlink", "href"))
        .and_then(|h| h.strip_prefix("data:image/png;base64,"))
        .expect("data");
    let (width, height, rgb) = pixels(&base64::engine::general_purpose::STANDARD.decode(data).expect("base64"));
    assert_eq!(width, height);
    let share = |wanted: [u8; 3]| rgb.chunks_exact(3).filter(|p| *p == wanted).count() as f64 / (width * height) as f64;
    assert!(share(colour(1.0)) > 0.0 && share(colour(0.0)) > 0.0);
    let transposed = (0..width * height).all(|i| rgb[3 * i..][..3] == rgb[3 * (i % width * width + i / width)..][..3]);
    assert!(transposed, "symmetric");
    // The axes around it are those of any other matrix.
    let frames = paths(&svg, "stroke", INK).iter().map(|p| bounds(&d(p))).filter(|[x, _]| x[1] - x[0] > 300.0).count();
    assert_eq!(frames, 1);
}

#[test]
fn bars_are_in_proportion_and_any_name_can_be_written() {
    let name = "a<b>&\"c\u{1}'";
    let text = bars(&[(name, 200.0, Some(-100.0)), ("R-M1", 50.0, Some(50.0))]).svg().expect("an SVG");
    let svg = Document::parse(&text).expect("well-formed");
    let widths = |rgb| -> Vec<f64> {
        // Below the legend.
        let all = paths(&svg, "fill", rgb).into_iter().map(|p| bounds(&d(&p))).filter(|[_, y]| y[0] > 45.0);
        all.map(|[x, _]| x[1] - x[0]).collect()
    };
    let ([before, small], [after, _]) =
        (widths(KEPT)[..].try_into().expect("two"), widths("#e69f00")[..].try_into().expect("two"));
    assert!((before - 4.0 * small).abs() < 0.05 && (before - 2.0 * after).abs() < 0.05, "{before} {small} {after}");
    assert_eq!(said(&svg, "a<b>&\"c\u{fffd}'"), 1);
}

/// The median of an odd number of likelihoods is one of them: the threshold of a run ends where that vessel's curve ends.
#[test]
fn the_threshold_of_a_run_ends_in_the_middle_of_the_vessels() {
    let here = command::folder();
    let input = command::data("broken-circle-of-willis.swc");
    let run = command::willis(here.path(), &["infer", &input, "--keep", "median", "-n", "500", "-o", "out"]);
    assert!(run.status.success(), "{}", command::stderr(&run));
    let file = |name: &str| std::fs::read_to_string(here.path().join("out").join(name)).expect("a file of the run");
    let text = file("convergence.svg");
    let svg = Document::parse(&text).expect("well-formed");
    let ends = |rgb| -> Vec<f64> {
        let curves = paths(&svg, "stroke", rgb).into_iter().map(|path| d(&path)).filter(|p| p.len() > 2 && p[0][1] > AXES[0][1]);
        curves.map(|curve| curve[curve.len() - 1][1]).collect()
    };
    // Uncertain and above zero: the columns `probability` and `likelihood` of edges.csv.
    let table = file("edges.csv");
    let [head, rows @ ..] = &table.lines().map(|line| line.split(',').collect()).collect::<Vec<Vec<&str>>>()[..] else {
        panic!("no rows")
    };
    let column = |name: &str| head.iter().position(|h| *h == name).expect("a column");
    let (likelihood, probability) = (column("likelihood"), column("probability"));
    let positive = rows.iter().filter(|row| !row[probability].is_empty() && row[likelihood] != "0").count();
    let mut vessels = [ends(KEPT), ends(PRUNED)].concat();
    vessels.sort_by(f64::total_cmp);
    let [threshold] = ends(INK)[..] else { panic!("one threshold") };
    // Of an even number it is between the two in the middle.
    let [low, high] = [vessels[(positive - 1) / 2], vessels[positive / 2]];
    assert!((low - 0.011..high + 0.011).contains(&threshold), "{threshold} for {low} to {high} of {vessels:?}");
    assert!(vessels[0] < threshold - 1.0 && vessels[positive - 1] > threshold + 1.0, "the curves spread");
}

/// L counts samples under `--weight count`; then no picture may call it a power per volume.
#[test]
fn the_unit_is_that_of_what_the_likelihood_adds_up() {
    let said = |weight| {
        let heat = heat_map(&LikelihoodMatrix { nodes: 2, entries: &[(0, 1, 3.0)], ..LikelihoodMatrix::default() }, weight).svg();
        let curves = convergence(&[10], &[vec![1.0]], (CutLine::Threshold, &[2.0]), &[true], weight).svg();
        heat.expect("an SVG") + &curves.expect("an SVG")
    };
    let (resilience, count) = (said(Weight::Resilience), said(Weight::Count));
    assert!(resilience.contains(">L (W/m³)<") && resilience.contains("L/n (W/m³)<"));
    assert!(count.contains(">L (samples)<") && count.contains(">share of samples L/n<") && !count.contains("W/m"));
}
