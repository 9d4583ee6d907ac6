//! The flows of a simulation as horizontal bars: the flow of each vessel before and after a perturbation.

use super::axis::{LinearRange, TickLabel};
use super::colour::{INK, PERTURBED, UNPERTURBED};
use super::figure::Figure;
use super::legend::{self, LegendKey};
use super::sheet::{Align, Sheet, TextDirection};
use super::style::{self, HAIR, NAME_BELOW, POINTS_PER_INCH, SMALL, TEXT, TICK};
use willis_io::output::names::FLOW_PICTURE;

const WIDTH: f64 = 6.8 * POINTS_PER_INCH;
/// Above the bars with and without a legend, points.
const TOP: [f64; 2] = [50.0, 31.0];
/// Below the bars, points.
const BOTTOM: f64 = 46.0;
/// Thickness of a bar, points.
const BAR: f64 = 8.0;
/// Between the bars of two vessels, points.
const GAP: f64 = 7.0;
/// Space for a number at the end of a bar, points.
const ROOM: f64 = 40.0;
/// The largest width of a vessel's name, points. Longer names are cut.
const NAME: f64 = 170.0;
/// The largest number of vessels shown.
const MOST: usize = 40;
/// The range of the axis where no blood flows, mL/min.
const NO_FLOW: f64 = 1.0;

/// The flow of one vessel, mL/min.
#[derive(Debug, Clone, PartialEq)]
pub struct VesselFlow {
    /// The name of the vessel.
    pub name: String,
    /// Q in the unperturbed network.
    pub unperturbed: f64,
    /// Q in the perturbed network, if there is one; positive in the same direction.
    pub perturbed: Option<f64>,
}

impl VesselFlow {
    /// The flows, positive in the direction of the flow before the perturbation; if that is zero, after it.
    fn along(&self) -> (f64, Option<f64>) {
        let first = if self.unperturbed == 0.0 { self.perturbed.unwrap_or(0.0) } else { self.unperturbed };
        let sign = if first < 0.0 { -1.0 } else { 1.0 };
        // Adding zero leaves no negative zero.
        (sign * self.unperturbed + 0.0, self.perturbed.map(|q| sign * q + 0.0))
    }

    /// The rank of the vessel in the picture: its largest flow or its change of flow.
    fn rank(&self) -> f64 {
        let after = self.perturbed.unwrap_or(self.unperturbed);
        self.unperturbed.abs().max(after.abs()).max((after - self.unperturbed).abs())
    }
}

/// Draws the flow (mL/min) of the up to 40 vessels of largest flow or change of flow, the largest on top, 6.8 inches
/// wide.
///
/// A flow is positive in its direction in the unperturbed network, so that only reversed flows lie left of zero.
pub fn flow_bars(flows: &[VesselFlow]) -> Figure {
    let mut shown: Vec<&VesselFlow> = flows.iter().collect();
    // In single precision, so that rounding does not change the order of equal flows.
    shown.sort_by(|a, b| (b.rank() as f32).total_cmp(&(a.rank() as f32)));
    shown.truncate(MOST);
    let pair = flows.iter().any(|f| f.perturbed.is_some());
    let title = match (flows.len(), pair) {
        (n, _) if n > MOST => format!("Flow in the {MOST} vessels of largest flow{}", if pair { " or change" } else { "" }),
        _ => "Flow in the vessels".to_owned(),
    };
    let each = GAP + if pair { 2.0 * BAR } else { BAR };
    let top = if pair { TOP[0] } else { TOP[1] };
    let bottom = top + each * shown.len() as f64;
    let names: Vec<String> = shown.iter().map(|flow| style::fitting(&flow.name, NAME, TEXT)).collect();
    let left = names.iter().map(|name| style::room(name, TEXT)).fold(0.0, f64::max) + 22.0;
    let right = WIDTH - 14.0;
    let both = || shown.iter().flat_map(|f| [Some(f.along().0), f.along().1]).flatten();
    let (low, high) = (both().fold(0.0, f64::min), both().fold(0.0, f64::max));
    let range = LinearRange { low, high: if high > low { high } else { NO_FLOW } };
    let first = left + if low < 0.0 { ROOM } else { 0.0 };
    let x = |flow: f64| first + (right - ROOM - first) * range.share(flow);
    let mut sheet = Sheet::default();
    sheet.ticks_below([top, bottom], range.ticks(7).into_iter().map(|tick| (x(tick.at), tick.label)));
    sheet.line([[left, bottom], [right, bottom]], HAIR, INK, 1.0);
    let name = if pair { "flow along its unperturbed direction (mL/min)" } else { "flow (mL/min)" };
    sheet.plain(name, [f64::midpoint(left, right), bottom + TICK + NAME_BELOW], Align::Middle);
    sheet.title(&title, left);
    if pair {
        let keys = [("unperturbed", LegendKey::Box, UNPERTURBED), ("perturbed", LegendKey::Box, PERTURBED)];
        legend::legend(&mut sheet, left, &keys);
    }
    for (row, (flow, name)) in shown.iter().zip(names).enumerate() {
        let above = top + GAP / 2.0 + each * row as f64;
        sheet.plain(&name, [left - 8.0, above + (each - GAP) / 2.0], Align::End);
        let (before, after) = flow.along();
        for (above, flow, rgb) in [(above, Some(before), UNPERTURBED), (above + BAR, after, PERTURBED)] {
            let Some(flow) = flow else { continue };
            let (zero, end) = (x(0.0), x(flow));
            sheet.rectangle([zero.min(end), above], [(end - zero).abs(), BAR], rgb);
            let (at, align) = if flow < 0.0 { (end - 3.0, Align::End) } else { (end + 3.0, Align::Begin) };
            sheet.text(&figure(flow), [at, above + BAR / 2.0], SMALL, align, TextDirection::Right);
        }
    }
    sheet.line([[x(0.0), top], [x(0.0), bottom]], HAIR, INK, 1.0);
    Figure::new(FLOW_PICTURE, [WIDTH, bottom + BOTTOM], sheet)
}

/// A flow with at least three significant digits, or two as a power of ten.
fn figure(flow: f64) -> TickLabel {
    let sign = if flow < 0.0 { "\u{2212}" } else { "" };
    let size = flow.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        let text = format!("{size:.1e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return TickLabel { text: format!("{sign}{digits}\u{b7}10"), exponent: exponent.replace('-', "\u{2212}") };
    }
    let decimals = if size == 0.0 { 0 } else { (2.0 - size.log10().floor()).max(0.0) as usize };
    TickLabel::plain(format!("{sign}{size:.decimals$}"))
}
