//! The sheet that a figure is drawn on: lines, boxes, text and ticks in points, which are then drawn as a bitmap or as SVG.

use tiny_skia::{Path, PathBuilder};

use super::axis::TickLabel;
use super::colour::{GRID, INK, Rgb};
use super::font;
use super::style::{HAIR, TEXT, TICK, TITLE, TITLE_AT};

/// Height of the digits as a share of the text's.
const DIGIT: f64 = 0.6;
/// Height of an exponent as a share of the text's.
pub const EXPONENT: f64 = 0.72;
/// How far an exponent is raised, as a share of the text's height.
pub const LIFT: f64 = 0.3;
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

/// The direction of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextDirection {
    /// From left to right.
    Right,
    /// Upwards.
    Up,
}

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
    /// Text, by its outline, where letters of it have one, and by its words.
    Text(Option<Path>, Words),
}

/// The words of a text, where they stand and how.
#[derive(Debug)]
pub struct Words {
    /// What it says.
    pub label: TickLabel,
    /// The point of its base line that `align` says.
    pub place: SheetPlace,
    /// From the lowest descender to the highest ascender, points.
    pub height: f64,
    /// Which point that is.
    pub align: Align,
    /// Where it runs.
    pub run: TextDirection,
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

    /// A line along `path` with round corners and ends, `width` points wide.
    pub fn tube(&mut self, path: impl IntoIterator<Item = SheetPlace>, width: f64, rgb: Rgb) {
        self.stroke(path, LineStyle::Tube, width, rgb, 1.0);
    }

    /// A dashed line along `path`.
    pub fn dashed(&mut self, path: impl IntoIterator<Item = SheetPlace>, width: f64, rgb: Rgb) {
        self.stroke(path, LineStyle::Dashed, width, rgb, 1.0);
    }

    fn stroke(&mut self, path: impl IntoIterator<Item = SheetPlace>, line: LineStyle, width: f64, rgb: Rgb, opacity: f64) {
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
        self.text(&TickLabel::plain(text), [x, TITLE_AT], TITLE, Align::Begin, TextDirection::Right);
    }

    /// Plain text.
    pub fn plain(&mut self, text: &str, place: SheetPlace, align: Align) {
        self.text(&TickLabel::plain(text), place, TEXT, align, TextDirection::Right);
    }

    /// Plain text that runs upwards, around `place`.
    pub fn upright(&mut self, text: &str, place: SheetPlace) {
        self.text(&TickLabel::plain(text), place, TEXT, Align::Middle, TextDirection::Up);
    }

    /// A tick left of an axis, and its text.
    pub fn tick_left(&mut self, [x, y]: SheetPlace, label: &TickLabel, height: f64) {
        self.line([[x - TICK, y], [x, y]], HAIR, INK, 1.0);
        self.text(label, [x - TICK - ASIDE, y], height, Align::End, TextDirection::Right);
    }

    /// A tick right of an axis, and its text.
    pub fn tick_right(&mut self, [x, y]: SheetPlace, label: &TickLabel) {
        self.line([[x, y], [x + TICK, y]], HAIR, INK, 1.0);
        self.text(label, [x + TICK + ASIDE, y], TEXT, Align::Begin, TextDirection::Right);
    }

    /// A tick below an axis, and its text.
    pub fn tick_below(&mut self, [x, y]: SheetPlace, label: &TickLabel, height: f64) {
        self.line([[x, y], [x, y + TICK]], HAIR, INK, 1.0);
        self.text(label, [x, y + TICK + BELOW], height, Align::Middle, TextDirection::Right);
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

    /// Text whose digits are centred on `place` across its direction.
    pub fn text(&mut self, label: &TickLabel, place: SheetPlace, height: f64, align: Align, run: TextDirection) {
        if label.text.trim().is_empty() {
            return;
        }
        let widths = [font::width(&label.text, height), font::width(&label.exponent, height * EXPONENT)];
        let back = match align {
            Align::Begin => 0.0,
            Align::Middle => f64::midpoint(widths[0], widths[1]),
            Align::End => widths[0] + widths[1],
        };
        let base = height * DIGIT / 2.0;
        let mut outline = PathBuilder::new();
        for (text, size, along, across) in
            [(&label.text, height, -back, base), (&label.exponent, height * EXPONENT, widths[0] - back, base - height * LIFT)]
        {
            let at = |[x, y]: [f64; 2]| match run {
                TextDirection::Right => [place[0] + along + x, place[1] + across + y],
                TextDirection::Up => [place[0] + across + y, place[1] - along - x],
            };
            if let Some(path) = font::outline(text, size, at) {
                outline.push_path(&path);
            }
        }
        let place = match run {
            TextDirection::Right => [place[0], place[1] + base],
            TextDirection::Up => [place[0] + base, place[1]],
        };
        let words = Words { label: label.clone(), place, height, align, run };
        self.marks.push(Mark::Text(outline.finish(), words));
    }
}
