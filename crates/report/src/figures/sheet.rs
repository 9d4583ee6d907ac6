//! The sheet that a figure is drawn on, in points: lines, boxes, text, ticks, legends and colour bars, in the style and the font of all figures.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, GlyphId, OutlineCurve, Point};
use tiny_skia::{Path, PathBuilder};

use super::axis::TickLabel;
use super::{GRID, INK, Rgb};

/// Places and lengths on a page are in points.
pub const POINTS_PER_INCH: f64 = 72.0;
/// Height of text, points.
pub const TEXT: f64 = 10.0;
/// Height of numbers at marks and of names in tight places, points.
pub const SMALL: f64 = 8.0;
/// Height of a title, points.
pub const TITLE: f64 = 12.0;
/// Height of the middle of a title, points.
const TITLE_AT: f64 = 15.0;
/// Height of the middle of a legend, points.
pub const LEGEND_AT: f64 = 36.0;
/// Width of axes and ticks, points.
pub const HAIR: f64 = 0.6;
/// Width of a curve, and of one that matters most, points.
pub const CURVE: f64 = 1.0;
/// The line that everything else is compared with, points.
pub const BOLD: f64 = 1.8;
/// Lengths of a dash and of the gap after it, points.
pub const DASH: [f32; 2] = [4.0, 3.0];
/// Length of a tick, points.
pub const TICK: f64 = 4.0;
/// The name of the axis below stands so far below its ticks, points.
pub const NAME_BELOW: f64 = 25.0;
/// The middle of the upright name of an axis, points from the left edge.
pub const NAME_LEFT: f64 = 9.0;

/// More letters than fit, even narrow ones.
const MOST_LETTERS: usize = 200;

/// A font that stands in for that of the bitmaps is so much wider at the most.
const WIDER: f64 = 1.16;

/// The room that a text needs in any of the fonts, points.
pub fn room(text: &str, height: f64) -> f64 {
    WIDER * width(text, height)
}

/// A name without its middle where it needs more room than `most` points.
pub fn fitting(name: &str, most: f64, height: f64) -> String {
    let letters: Vec<char> = name.chars().collect();
    let shortened = |kept: usize| {
        let (first, last) = (&letters[..kept.div_ceil(2)], &letters[letters.len() - kept / 2..]);
        first.iter().chain(&['\u{2026}']).chain(last).collect::<String>()
    };
    let whole = (letters.len() <= MOST_LETTERS).then(|| name.to_owned());
    let shorter = (0..letters.len().min(MOST_LETTERS)).rev().map(shortened);
    whole.into_iter().chain(shorter).find(|cut| room(cut, height) <= most).unwrap_or_else(|| shortened(0))
}

/// Height of the digits as a share of the text's.
const DIGIT: f64 = 0.6;
/// Height of an exponent as a share of the text's.
pub const EXPONENT: f64 = 0.72;
/// How far an exponent is raised, as a share of the text's height.
pub const LIFT: f64 = 0.3;
/// Size of the key of a legend, the space before its text, and between two entries, points.
const KEY: [f64; 2] = [18.0, 8.0];
const SPACE: f64 = 5.0;
const APART: f64 = 18.0;
/// The width of a colour bar, and from it to the middle of its upright name, points.
const BAR: [f64; 2] = [12.0, 48.0];
/// Space for a number left of its tick, and for one below it, points.
const ASIDE: f64 = 3.0;
const BELOW: f64 = 7.0;

/// A place on the page, points from its upper left corner.
pub type SheetPlace = [f64; 2];

/// Which point of the text is at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Its beginning.
    Begin,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// What a legend shows of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LegendKey {
    /// A line of a width in points.
    Line(f64),
    /// A dashed line of a width in points.
    Dashes(f64),
    /// A filled box.
    Box,
}

/// The key of the line that everything else is compared with.
pub const REFERENCE: (LegendKey, Rgb) = (LegendKey::Dashes(1.2), INK);

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineStyle {
    /// Without a break.
    Solid,
    /// In dashes of 4 points with gaps of 3.
    Dashed,
    /// With round ends.
    Tube,
}

/// A box of a colour, by its upper left and lower right corner.
pub type FilledBox = ([SheetPlace; 2], Rgb);

/// One thing on the sheet.
#[derive(Debug)]
pub enum Mark {
    /// Boxes with sharp edges, later ones over earlier ones; the first of several holds all others.
    Boxes(Vec<FilledBox>),
    /// A box with the colour map from bottom to top, by its corners.
    Map([SheetPlace; 2]),
    /// A line of a width in points, and its opacity in (0, 1].
    Line(Path, LineStyle, f64, Rgb, f64),
    /// Text, by its outline, where letters of it have one, and by what it says: with which point of its base line at its place, how high
    /// it is from the lowest descender to the highest ascender in points, and whether it runs upwards.
    Text { outline: Option<Path>, label: TickLabel, place: SheetPlace, height: f64, align: Align, is_upright: bool },
}

/// A sheet whose unit is the point (1/72 inch).
#[derive(Debug, Default)]
pub struct Sheet {
    /// What is on it, from bottom to top.
    pub marks: Vec<Mark>,
}

impl Sheet {
    /// A line along `path`, `width` points wide, `opacity` in (0, 1].
    pub fn line(&mut self, path: impl IntoIterator<Item = SheetPlace>, width: f64, rgb: Rgb, opacity: f64) {
        self.stroke(path, LineStyle::Solid, width, rgb, opacity);
    }

    /// A dashed line along `path`.
    pub fn dashed(&mut self, path: impl IntoIterator<Item = SheetPlace>, width: f64, rgb: Rgb) {
        self.stroke(path, LineStyle::Dashed, width, rgb, 1.0);
    }

    /// A line along `path` in a style.
    pub fn stroke(&mut self, path: impl IntoIterator<Item = SheetPlace>, line: LineStyle, width: f64, rgb: Rgb, opacity: f64) {
        let mut along = PathBuilder::new();
        for [x, y] in path.into_iter().map(|place| place.map(|c| c as f32)) {
            if along.is_empty() { along.move_to(x, y) } else { along.line_to(x, y) }
        }
        self.marks.extend(along.finish().map(|path| Mark::Line(path, line, width, rgb, opacity)));
    }

    /// Fills a rectangle of a corner and size (width, height).
    pub fn rectangle(&mut self, corner: SheetPlace, size: [f64; 2], rgb: Rgb) {
        self.marks.push(Mark::Boxes(vec![([corner, [corner[0] + size[0], corner[1] + size[1]]], rgb)]));
    }

    /// The outline of a rectangle of a corner and size (width, height).
    pub fn frame(&mut self, [left, top]: SheetPlace, [width, height]: [f64; 2]) {
        let rectangle = tiny_skia::Rect::from_xywh(left as f32, top as f32, width as f32, height as f32);
        self.marks.extend(rectangle.map(|of| Mark::Line(PathBuilder::from_rect(of), LineStyle::Solid, HAIR, INK, 1.0)));
    }

    /// The title of a figure, from `x`, the left edge of its axes.
    pub fn title(&mut self, text: &str, x: f64) {
        self.text(&TickLabel::plain(text), [x, TITLE_AT], TITLE, Align::Begin, false);
    }

    /// Plain text.
    pub fn plain(&mut self, text: &str, place: SheetPlace, align: Align) {
        self.text(&TickLabel::plain(text), place, TEXT, align, false);
    }

    /// Plain text that runs upwards, around `place`.
    pub fn upright(&mut self, text: &str, place: SheetPlace) {
        self.text(&TickLabel::plain(text), place, TEXT, Align::Middle, true);
    }

    /// A number at a mark, or another text in a tight place.
    pub fn small(&mut self, label: &TickLabel, place: SheetPlace, align: Align) {
        self.text(label, place, SMALL, align, false);
    }

    /// One entry of a legend, with the left and middle of its key at a place; returns its width.
    pub fn key(&mut self, [x, y]: SheetPlace, text: &str, key: LegendKey, rgb: Rgb) -> f64 {
        let ends = [[x, y], [x + KEY[0], y]];
        match key {
            LegendKey::Line(width) => self.line(ends, width.max(1.5), rgb, 1.0),
            LegendKey::Dashes(width) => self.dashed(ends, width, rgb),
            LegendKey::Box => self.rectangle([x, y - KEY[1] / 2.0], KEY, rgb),
        }
        self.plain(text, [x + KEY[0] + SPACE, y], Align::Begin);
        KEY[0] + SPACE + width(text, TEXT)
    }

    /// A legend in a row below the title, from the left edge of the axes.
    pub fn legend(&mut self, left: f64, entries: &[(&str, LegendKey, Rgb)]) {
        let mut x = left;
        for (text, kind, rgb) in entries {
            x += self.key([x, LEGEND_AT], text, *kind, *rgb) + APART;
        }
    }

    /// A colour bar from its upper left corner with ticks at shares of the scale, and its name at the right.
    pub fn colour_bar(&mut self, at: SheetPlace, height: f64, ticks: impl IntoIterator<Item = (f64, TickLabel)>, name: &str) {
        let ([left, top], right) = (at, at[0] + BAR[0]);
        self.marks.push(Mark::Map([[left, top], [right, top + height]]));
        self.frame([left, top], [BAR[0], height]);
        for (share, label) in ticks {
            let y = top + (1.0 - share) * height;
            self.line([[right, y], [right + TICK, y]], HAIR, INK, 1.0);
            self.text(&label, [right + TICK + ASIDE, y], TEXT, Align::Begin, false);
        }
        self.upright(name, [left + BAR[1], top + height / 2.0]);
    }

    /// A tick left of an axis, and its text.
    pub fn tick_left(&mut self, [x, y]: SheetPlace, label: &TickLabel, height: f64) {
        self.line([[x - TICK, y], [x, y]], HAIR, INK, 1.0);
        self.text(label, [x - TICK - ASIDE, y], height, Align::End, false);
    }

    /// A tick below an axis, and its text.
    pub fn tick_below(&mut self, [x, y]: SheetPlace, label: &TickLabel, height: f64) {
        self.line([[x, y], [x, y + TICK]], HAIR, INK, 1.0);
        self.text(label, [x, y + TICK + BELOW], height, Align::Middle, false);
    }

    /// Ticks at heights left of the axes, with grid lines between `left` and `right`.
    pub fn ticks_left(&mut self, [left, right]: [f64; 2], ticks: impl IntoIterator<Item = (f64, TickLabel)>) {
        for (y, label) in ticks {
            self.line([[left, y], [right, y]], HAIR, GRID, 1.0);
            self.tick_left([left, y], &label, TEXT);
        }
    }

    /// Ticks below the axes, with grid lines between `top` and `bottom`.
    pub fn ticks_below(&mut self, [top, bottom]: [f64; 2], ticks: impl IntoIterator<Item = (f64, TickLabel)>) {
        for (x, label) in ticks {
            self.line([[x, top], [x, bottom]], HAIR, GRID, 1.0);
            self.tick_below([x, bottom], &label, TEXT);
        }
    }

    /// Text whose digits are centred on a place across its direction.
    fn text(&mut self, label: &TickLabel, [left, top]: SheetPlace, height: f64, align: Align, is_upright: bool) {
        if label.text.trim().is_empty() {
            return;
        }
        let widths = [width(&label.text, height), width(&label.exponent, height * EXPONENT)];
        let back = match align {
            Align::Begin => 0.0,
            Align::Middle => f64::midpoint(widths[0], widths[1]),
            Align::End => widths[0] + widths[1],
        };
        let base = height * DIGIT / 2.0;
        let mut letters = PathBuilder::new();
        for (text, size, along, across) in
            [(&label.text, height, -back, base), (&label.exponent, height * EXPONENT, widths[0] - back, base - height * LIFT)]
        {
            let at = |[x, y]: [f64; 2]| {
                if is_upright { [left + across + y, top - along - x] } else { [left + along + x, top + across + y] }
            };
            if let Some(path) = outline(text, size, at) {
                letters.push_path(&path);
            }
        }
        let place = if is_upright { [left + base, top] } else { [left, top + base] };
        self.marks.push(Mark::Text { outline: letters.finish(), label: label.clone(), place, height, align, is_upright });
    }
}

/// The embedded font, whose letters are outlines in bitmaps, which need no installed font.
static FONT: LazyLock<FontRef<'static>> =
    LazyLock::new(|| FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).expect("the font is part of the program"));

/// Each letter of a text of a size with its place along the base line, then the end; and the scale of the font. The size is from the
/// lowest descender of the font to its highest ascender.
fn letters(text: &str, size: f64) -> (Vec<(GlyphId, f64)>, f64, f64) {
    let scale = size / f64::from(FONT.height_unscaled());
    let (mut all, mut along) = (Vec::new(), 0.0);
    for letter in text.chars() {
        let glyph = FONT.glyph_id(letter);
        along += all.last().map_or(0.0, |(before, _)| f64::from(FONT.kern_unscaled(*before, glyph)) * scale);
        all.push((glyph, along));
        along += f64::from(FONT.h_advance_unscaled(glyph)) * scale;
    }
    (all, along, scale)
}

/// The size that programs call that of text of a size: the side of its em square.
pub fn em(size: f64) -> f64 {
    size * f64::from(FONT.units_per_em().unwrap_or(1.0) / FONT.height_unscaled())
}

/// The width of a line of text of a size.
fn width(text: &str, size: f64) -> f64 {
    letters(text, size).1
}

/// The outline of a line of text of a size. `at` places its points, which are (x, y) from the beginning of the base line, with y
/// downwards. `None` where nothing is to be drawn.
fn outline(text: &str, size: f64, at: impl Fn([f64; 2]) -> [f64; 2]) -> Option<Path> {
    let (letters, _, scale) = letters(text, size);
    let mut path = PathBuilder::new();
    for (glyph, along) in letters {
        let place = |p: Point| at([along + f64::from(p.x) * scale, -f64::from(p.y) * scale]).map(|c| c as f32);
        let mut end = None;
        for curve in FONT.outline(glyph).into_iter().flat_map(|outline| outline.curves) {
            let (OutlineCurve::Line(start, _) | OutlineCurve::Quad(start, ..) | OutlineCurve::Cubic(start, ..)) = curve;
            if end != Some(start) {
                let [x, y] = place(start);
                path.move_to(x, y);
            }
            let (last, places) = match curve {
                OutlineCurve::Line(_, b) => (b, vec![b]),
                OutlineCurve::Quad(_, b, c) => (c, vec![b, c]),
                OutlineCurve::Cubic(_, b, c, d) => (d, vec![b, c, d]),
            };
            match places.into_iter().map(place).collect::<Vec<_>>()[..] {
                [[x, y]] => path.line_to(x, y),
                [[a, b], [x, y]] => path.quad_to(a, b, x, y),
                [[a, b], [c, d], [x, y]] => path.cubic_to(a, b, c, d, x, y),
                _ => {}
            }
            end = Some(last);
        }
    }
    path.finish()
}
