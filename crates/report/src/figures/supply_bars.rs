//! Whose blood every outlet gets: a bar an outlet, divided by inlet, with the mean time since entry beside it.

use super::axis::TickLabel;
use super::colour::{INK, Rgb};
use super::figure::Figure;
use super::legend::{self, LegendKey};
use super::sheet::{Align, Sheet, TextDirection};
use super::style::{self, HAIR, LEGEND_AT, NAME_BELOW, POINTS_PER_INCH, SMALL, TEXT, TICK};
use willis_io::output::names::TERRITORY_PICTURE;

const WIDTH: f64 = 6.8 * POINTS_PER_INCH;
/// Above the bars, points: the title, and lines of the legend of this height.
const TOP: f64 = 31.0;
const LEGEND: f64 = 15.0;
/// Below the bars, points.
const BOTTOM: f64 = 46.0;
/// Thickness of a bar, and space between the bars of two outlets, points.
const BAR: f64 = 9.0;
const GAP: f64 = 7.0;
/// For the time at the end of a bar, points.
const ROOM: f64 = 52.0;
/// The largest number of outlets shown, and of entries in a line of the legend.
const MOST: usize = 40;
const IN_A_LINE: usize = 4;

/// The blood of one outlet.
#[derive(Debug, Clone, PartialEq)]
pub struct OutletSupply {
    /// The name of the outlet.
    pub name: String,
    /// The flow by which outlets are ranked, mL/min.
    pub flow: f64,
    /// Before and, where there is one, after a perturbation: the share from each inlet, and the mean time since entry in ms; `None` where
    /// no blood comes.
    pub states: Vec<Option<(Vec<f64>, f64)>>,
}

/// Draws the up to 40 outlets of largest flow, in the order given, 6.8 inches wide; `inlets` have names and colours.
pub fn supply_bars(outlets: &[OutletSupply], inlets: &[(String, Rgb)]) -> Figure {
    let mut rows: Vec<usize> = (0..outlets.len()).collect();
    // In single precision, so that rounding does not change the order of equal flows.
    rows.sort_by(|a, b| (outlets[*b].flow as f32).total_cmp(&(outlets[*a].flow as f32)));
    rows.truncate(MOST);
    rows.sort_unstable();
    let shown: Vec<&OutletSupply> = rows.into_iter().map(|row| &outlets[row]).collect();
    let which = if outlets.len() > MOST { format!("the {MOST} outlets of largest flow") } else { "every outlet".to_owned() };
    let title = format!("Blood of {which}, by inlet");
    let height = |outlet: &OutletSupply| GAP + BAR * outlet.states.len() as f64;
    let top = TOP + LEGEND * inlets.len().div_ceil(IN_A_LINE) as f64;
    let bottom = top + shown.iter().map(|outlet| height(outlet)).sum::<f64>();
    let names: Vec<String> = shown.iter().map(|outlet| style::fitting(&outlet.name, WIDTH / 3.0, TEXT)).collect();
    let left = names.iter().map(|name| style::room(name, TEXT)).fold(0.0, f64::max) + 22.0;
    let right = WIDTH - 14.0 - ROOM;
    let x = |share: f64| left + (right - left) * share;
    let mut sheet = Sheet::default();
    sheet.title(&title, left);
    // The colours of the inlets, between the title and the bars.
    let step = (WIDTH - left - 14.0) / IN_A_LINE as f64;
    for (at, (name, rgb)) in inlets.iter().enumerate() {
        let (line, place) = ((at / IN_A_LINE) as f64, (at % IN_A_LINE) as f64);
        let name = style::fitting(name, step - 28.0, TEXT);
        legend::key(&mut sheet, [left + step * place, LEGEND_AT + LEGEND * line], &name, LegendKey::Box, *rgb);
    }
    let ticks = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| (x(share), TickLabel::plain(format!("{:.0}", 100.0 * share))));
    sheet.ticks_below([top, bottom], ticks);
    sheet.line([[left, bottom], [right, bottom]], HAIR, INK, 1.0);
    let pair = shown.iter().any(|outlet| outlet.states.len() > 1);
    let name = if pair { "share of the blood (%), as it is above, perturbed below" } else { "share of the blood (%)" };
    sheet.plain(name, [f64::midpoint(left, right), bottom + TICK + NAME_BELOW], Align::Middle);
    let mut above = top;
    for (outlet, name) in shown.into_iter().zip(names) {
        let small = |text: String, sheet: &mut Sheet, place| {
            sheet.text(&TickLabel::plain(text), place, SMALL, Align::Begin, TextDirection::Right);
        };
        sheet.plain(&name, [left - 8.0, above + height(outlet) / 2.0], Align::End);
        for (at, state) in outlet.states.iter().enumerate() {
            let place = above + GAP / 2.0 + BAR * at as f64;
            let Some((shares, time)) = state else {
                small("no blood".to_owned(), &mut sheet, [left + 3.0, place + BAR / 2.0]);
                continue;
            };
            let mut from = 0.0;
            for (share, (_, rgb)) in shares.iter().zip(inlets) {
                sheet.rectangle([x(from), place], [x(*share) - left, BAR - 1.0], *rgb);
                from += share;
            }
            small(format!("{time:.0} ms"), &mut sheet, [right + 4.0, place + BAR / 2.0]);
        }
        above += height(outlet);
    }
    Figure::new(TERRITORY_PICTURE, [WIDTH, bottom + BOTTOM], sheet)
}
