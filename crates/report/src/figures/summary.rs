//! A run in one picture: the vessels from two sides with their courses smoothed, the candidates by their probability, and the counts.

use super::axis::TickLabel;
use super::figure::Figure;
use super::sheet::{Align, LEGEND_AT, LineStyle, POINTS_PER_INCH, SMALL, Sheet, SheetPlace, TEXT, TITLE, fitting};
use super::{DEPTHS, INK, PAPER, Rgb, colour, mixed};

const PAGE: [f64; 2] = [6.4 * POINTS_PER_INCH, 4.1 * POINTS_PER_INCH];
/// Left edge of each panel, their top, and their width and height, points.
const LEFT: [f64; 2] = [14.0, 206.0];
const TOP: f64 = 60.0;
const SIZE: [f64; 2] = [184.0, 204.0];
/// Upper left corner of the colour bar, and its height, points.
const BAR: [f64; 2] = [404.0, 90.0];
const BAR_HEIGHT: f64 = 144.0;
/// The left edge, the top, the width and the height of the first view with what is under it, points.
pub const FRONT: [f64; 4] = [LEFT[0], TOP, SIZE[0], SIZE[1] + 12.0];
/// The scale bar stands so far above the lower edge of its panel, points.
const FOOT: f64 = 8.0;
/// The thinnest vessel, and the thinnest connection that was kept, points.
const THIN: [f64; 2] = [0.45, 1.8];
/// The width of a connection that was left out as a share of its diameter, and how far its colour is that of the page.
const LEFT_OUT: [f64; 2] = [0.4, 0.3];
/// The radius of a ring, its width, and how far its number stands from its middle, points.
const RING: [f64; 3] = [6.0, 0.8, 11.5];
/// More rings are not drawn.
pub const MOST_RINGS: usize = 30;

/// So many steps of a course are drawn in one line, as wide as the vessel is on average.
const TOGETHER: usize = 6;

/// A vessel of the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnVessel {
    /// x, y, z and radius along it, mm.
    pub course: Vec<[f64; 4]>,
    /// The probability of one that is uncertain, in [0, 1]; `None` for one that is not, or of which none is known.
    pub probability: Option<f64>,
    /// Whether it is certain.
    pub certain: bool,
    /// Whether it is kept.
    pub kept: bool,
}

/// A ring around what a person should look at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// x, y and z of its middle, mm.
    pub place: [f64; 3],
    /// What number it has on the list, where it is on one.
    pub number: Option<usize>,
}

/// A view: which way is right and which way is up on the page, and what each is called.
#[derive(Debug, Clone, PartialEq)]
pub struct Projection {
    /// What it is called.
    pub name: &'static str,
    /// The direction to the right of the page.
    pub right: [f64; 3],
    /// The direction up the page.
    pub up: [f64; 3],
    /// What stands at its left and right edge.
    pub edges: [&'static str; 2],
}

/// Draws a run in one picture, 6.4 by 4.1 inches: what was found in two lines of words, and two views on one scale. Certain vessels are grey,
/// darker where they are nearer; the others are coloured by probability, from 0 to 1, those that are left out thinner and paler. The first 30 rings
/// are drawn, with their numbers. Radii and courses are smoothed along each vessel, for display only.
pub fn summary(title: &str, words: [&str; 2], mut vessels: Vec<DrawnVessel>, rings: &[Ring], views: &[Projection; 2]) -> Figure {
    for vessel in &mut vessels {
        vessel.course = smoothed(&vessel.course);
    }
    let rings = &rings[..rings.len().min(MOST_RINGS)];
    let mut sheet = Sheet::default();
    let wide = PAGE[0] - 2.0 * LEFT[0];
    sheet.title(&fitting(title, wide, TITLE), LEFT[0]);
    for (line, below) in words.iter().zip([-3.0, 10.0]) {
        sheet.plain(&fitting(line, wide, TEXT), [LEFT[0], LEGEND_AT + below], Align::Begin);
    }
    let boxes = [0, 1].map(|at| extent(&vessels, &views[at]));
    // One scale for both views, points a millimetre.
    let fits = |[[west, east], [south, north]]: [[f64; 2]; 2]| {
        (SIZE[0] / (east - west).max(1e-9)).min((SIZE[1] - 14.0) / (north - south).max(1e-9))
    };
    let scale = 0.94 * fits(boxes[0]).min(fits(boxes[1]));
    for (at, view) in views.iter().enumerate() {
        let [[west, east], [south, north]] = boxes[at];
        let middle = [f64::midpoint(west, east), f64::midpoint(south, north)];
        let centre = [LEFT[at] + SIZE[0] / 2.0, TOP + (SIZE[1] - 14.0) / 2.0 + 12.0];
        let place = |p: &[f64; 4]| {
            let [x, y] = seen(p, view);
            [centre[0] + scale * (x - middle[0]), centre[1] - scale * (y - middle[1])]
        };
        for one in pieces(&vessels, view, scale, place) {
            sheet.stroke(one.path, LineStyle::Tube, one.width, one.rgb, 1.0);
        }
        let centres: Vec<SheetPlace> = rings.iter().map(|Ring { place: [x, y, z], .. }| place(&[*x, *y, *z, 0.0])).collect();
        ringed(&mut sheet, &centres, rings);
        sheet.plain(view.name, [centre[0], TOP + 5.0], Align::Middle);
        for (text, x) in view.edges.iter().zip([LEFT[at] + 4.0, LEFT[at] + SIZE[0] - 4.0]) {
            sheet.plain(text, [x, centre[1]], Align::Middle);
        }
    }
    // The scale bar.
    let widest = 60.0 / scale;
    let ten = 10_f64.powf(widest.log10().floor());
    let length = [5.0, 2.0, 1.0].map(|m| m * ten).into_iter().find(|length| *length <= widest).unwrap_or(ten);
    let (x, y) = (LEFT[0], TOP + SIZE[1] + FOOT);
    sheet.line([[x, y], [x + scale * length, y]], 1.2, INK, 1.0);
    sheet.plain(&format!("{length} mm"), [x + scale * length + 5.0, y], Align::Begin);
    let ticks = [0.0, 0.5, 1.0].map(|share: f64| (share, TickLabel::plain(share.to_string())));
    sheet.colour_bar(BAR, BAR_HEIGHT, ticks, "probability");
    Figure::new(willis_io::output::names::SUMMARY_PICTURE, PAGE, sheet)
}

/// A piece of a vessel on the page: how near it is, its course, and how it is drawn.
struct DrawnPiece {
    near: f64,
    path: Vec<SheetPlace>,
    width: f64,
    rgb: Rgb,
}

/// Draws rings around places of the page, each with its number where fewest other rings and numbers are.
fn ringed(sheet: &mut Sheet, centres: &[SheetPlace], rings: &[Ring]) {
    let away = |[x, y]: SheetPlace, by: f64, turns: f64| {
        let (sin, cos) = (std::f64::consts::TAU * turns).sin_cos();
        [x + by * cos, y - by * sin]
    };
    for centre in centres {
        sheet.line((0..=36).map(|k| away(*centre, RING[0], f64::from(k) / 36.0)), RING[1], INK, 1.0);
    }
    let mut numbers: Vec<SheetPlace> = Vec::new();
    for (centre, ring) in centres.iter().zip(rings) {
        let Some(number) = ring.number else { continue };
        let crowd = |at: &SheetPlace| {
            let near = |other: &&SheetPlace, by: f64| (at[0] - other[0]).hypot(at[1] - other[1]) < by;
            centres.iter().filter(|other| near(other, RING[0] + 4.0)).count()
                + numbers.iter().filter(|other| near(other, SMALL)).count()
        };
        let around = [1, 3, 5, 7, 0, 2, 4, 6].map(|eighths| away(*centre, RING[2], f64::from(eighths) / 8.0));
        if let Some(at) = around.into_iter().min_by_key(crowd) {
            sheet.small(&TickLabel::plain(number.to_string()), at, Align::Middle);
            numbers.push(at);
        }
    }
}

/// The extent of the vessels in a view, mm; that of a point where there is none.
fn extent(vessels: &[DrawnVessel], view: &Projection) -> [[f64; 2]; 2] {
    let none = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    let points = vessels.iter().flat_map(|vessel| &vessel.course);
    let found = points.fold(none, |range, p| {
        let at = seen(p, view);
        [0, 1].map(|axis| [range[axis][0].min(at[axis] - p[3]), range[axis][1].max(at[axis] + p[3])])
    });
    if found[0][0] <= found[0][1] { found } else { [[-1.0, 1.0]; 2] }
}

fn seen(p: &[f64; 4], view: &Projection) -> [f64; 2] {
    [&view.right, &view.up].map(|way| (0..3).map(|axis| way[axis] * p[axis]).sum())
}

/// The pieces of all vessels from far to near; those that are uncertain come last, so that nothing hides them.
fn pieces(vessels: &[DrawnVessel], view: &Projection, scale: f64, place: impl Fn(&[f64; 4]) -> [f64; 2]) -> Vec<DrawnPiece> {
    let back = willis_core::support::geometry::cross(view.right, view.up);
    let depth = |p: &[f64; 4]| (0..3).map(|axis| back[axis] * p[axis]).sum::<f64>();
    let certain = || vessels.iter().filter(|vessel| vessel.certain).flat_map(|vessel| &vessel.course).map(&depth);
    let [far, near] = [certain().fold(f64::INFINITY, f64::min), certain().fold(f64::NEG_INFINITY, f64::max)];
    let mut all = Vec::new();
    for vessel in vessels {
        let (order, thin) = match (vessel.certain, vessel.kept) {
            (true, _) => (0.0, THIN[0]),
            (false, false) => (1e6, THIN[0]),
            (false, true) => (2e6, THIN[1]),
        };
        let left_out = !vessel.certain && !vessel.kept;
        let share = if left_out { LEFT_OUT[0] } else { 1.0 };
        let own = vessel.probability.map_or(INK, colour);
        let own = if left_out { mixed(own, PAPER, LEFT_OUT[1]) } else { own };
        // A piece begins where the one before it ends.
        let last = vessel.course.len().saturating_sub(1);
        all.extend((0..last).step_by(TOGETHER).map(|first| {
            let part = &vessel.course[first..=(first + TOGETHER).min(last)];
            let mean = |of: &dyn Fn(&[f64; 4]) -> f64| part.iter().map(of).sum::<f64>() / part.len() as f64;
            let at = mean(&depth);
            let share_near = ((at - far) / (near - far).max(1e-9)).clamp(0.0, 1.0);
            let width = (2.0 * share * scale * mean(&|p| p[3])).max(thin);
            let rgb = if vessel.certain { mixed(DEPTHS[0], DEPTHS[1], share_near) } else { own };
            DrawnPiece { near: order + at, path: part.iter().map(&place).collect(), width, rgb }
        }));
    }
    all.sort_by(|a, b| a.near.total_cmp(&b.near));
    all
}

/// x, y, z and radius, mm.
pub type CoursePoint = [f64; 4];

/// Radii are averaged over so many radii to either side, as on the page.
const REACH: f64 = 6.0;
/// An inner point moves at most so many radii.
const MOST: f64 = 0.3;

/// The course with the mean of its piecewise linear radius over 6 mean radii to either side of each point, by the trapezoid rule, and
/// with each inner point half way nearer to the line between its neighbours, by at most 0.3 radii. The ends stay where they are.
pub fn smoothed(course: &[CoursePoint]) -> Vec<CoursePoint> {
    let last = course.len().saturating_sub(1);
    let mut along = vec![0.0];
    let mut sum = vec![0.0];
    for pair in course.windows(2) {
        let step = distance(&pair[0], &pair[1]);
        let at = along.len() - 1;
        sum.push(sum[at] + step * f64::midpoint(pair[0][3], pair[1][3]));
        along.push(along[at] + step);
    }
    let length = along[along.len() - 1];
    if course.len() < 3 || length <= 0.0 {
        return course.to_vec();
    }
    let mean = sum[last] / length;
    // The integral of the radius from the beginning to s.
    let integral = |s: f64| {
        let low = along.partition_point(|at| *at <= s).saturating_sub(1).min(last - 1);
        let (part, whole) = (s - along[low], (along[low + 1] - along[low]).max(f64::MIN_POSITIVE));
        let radius = course[low][3] + (course[low + 1][3] - course[low][3]) * part / whole;
        sum[low] + part * f64::midpoint(course[low][3], radius)
    };
    let radius = |s: f64| {
        let [from, to] = [(s - REACH * mean).max(0.0), (s + REACH * mean).min(length)];
        if to > from { (integral(to) - integral(from)) / (to - from) } else { mean }
    };
    let point = |at: usize| {
        let ([x, y, z, _], radius) = (course[at], radius(along[at]));
        let [x, y, z] = if at == 0 || at == last { [x, y, z] } else { calmed(course, &along, at, MOST * radius) };
        [x, y, z, radius]
    };
    (0..=last).map(point).collect()
}

/// The inner point `at`, moved by at most `most`.
fn calmed(course: &[CoursePoint], along: &[f64], at: usize, most: f64) -> [f64; 3] {
    let (before, place, after) = (&course[at - 1], &course[at], &course[at + 1]);
    let share = (along[at] - along[at - 1]) / (along[at + 1] - along[at - 1]).max(f64::MIN_POSITIVE);
    let moved: [f64; 3] = std::array::from_fn(|axis| 0.5 * (before[axis] + share * (after[axis] - before[axis]) - place[axis]));
    let by = moved.iter().map(|x| x * x).sum::<f64>().sqrt();
    let part = if by > most { most / by } else { 1.0 };
    std::array::from_fn(|axis| place[axis] + part * moved[axis])
}

fn distance(a: &CoursePoint, b: &CoursePoint) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}
