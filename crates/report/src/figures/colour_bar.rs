//! The bar that says which colour is which value.

use super::axis::TickLabel;
use super::sheet::{Mark, Sheet};

/// The width of a bar, points.
const WIDTH: f64 = 12.0;
/// From a bar to the middle of its upright name, points.
const NAME: f64 = 48.0;

/// Draws a bar from its upper left corner with ticks at shares of the scale, and its name at the right.
pub fn colour_bar(
    sheet: &mut Sheet,
    [left, top]: [f64; 2],
    height: f64,
    ticks: impl IntoIterator<Item = (f64, TickLabel)>,
    name: &str,
) {
    sheet.marks.push(Mark::Map([[left, top], [left + WIDTH, top + height]]));
    sheet.frame([left, top], [WIDTH, height]);
    for (share, label) in ticks {
        sheet.tick_right([left + WIDTH, top + (1.0 - share) * height], &label);
    }
    sheet.upright(name, [left + NAME, top + height / 2.0]);
}
