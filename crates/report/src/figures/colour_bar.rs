//! The bar that says which colour is which value.

use super::axis::Label;
use super::canvas::{Align, Run, Sheet};
use super::colour::{INK, MAP, colour};
use super::style::{HAIR, TEXT, TICK};
use willis_core::error::Result;

/// The width of a bar, points.
const WIDTH: f64 = 12.0;
/// From a bar to the middle of its upright name, points.
const NAME: f64 = 48.0;

/// Draws a bar from its upper left corner with ticks at shares of the scale, and its name at the right.
pub fn colour_bar(
    sheet: &mut Sheet<'_>,
    corner: [f64; 2],
    height: f64,
    ticks: impl IntoIterator<Item = (f64, Label)>,
    name: &str,
) -> Result<()> {
    let [left, top] = corner.map(|p| sheet.pixels(p));
    let [wide, high] = [WIDTH, height].map(|p| sheet.pixels(p));
    let drawn = sheet.ramp([left, top], [wide, high], &MAP)?;
    for y in 0..if drawn { 0 } else { high } {
        let share = 1.0 - y as f64 / (high - 1).max(1) as f64;
        sheet.fill([left, top + y], [wide, 1], colour(share))?;
    }
    let [left, top, width, height] = [left, top, wide, high].map(|p| sheet.points(p));
    sheet.frame([left, top], [width, height])?;
    let right = left + width;
    for (share, label) in ticks {
        let y = top + (1.0 - share) * height;
        sheet.line([[right, y], [right + TICK, y]], HAIR, INK, 1.0)?;
        sheet.text(&label, [right + TICK + 3.0, y], TEXT, Align::Begin, Run::Right)?;
    }
    sheet.upright(name, [left + NAME, top + height / 2.0])
}
