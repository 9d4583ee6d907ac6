//! What is drawn of a simulation: the flow of each vessel as bars, whose blood every outlet gets, and the flow of arteries over a cycle.

use super::axis::{LinearRange, TickLabel, decimals};
use super::figure::Figure;
use super::sheet::{
    Align, HAIR, LEGEND_AT, LegendKey, NAME_BELOW, NAME_LEFT, POINTS_PER_INCH, SMALL, Sheet, TEXT, TICK, fitting, room,
};
use super::{GRID, INK, PERTURBED, Rgb, UNPERTURBED};
use willis_core::support::ties::largest_first;
use willis_io::output::names::{FLOW_PICTURE, TERRITORY_PICTURE, WAVEFORM_PICTURE};

/// Width of a figure of bars, points.
const WIDTH: f64 = 6.8 * POINTS_PER_INCH;
/// Above the bars with and without a legend, points.
const TOP: [f64; 2] = [50.0, 31.0];
/// Below the bars, points.
const BOTTOM: f64 = 46.0;
/// Thickness of a bar of a flow, and of one of blood by inlet, points.
const BAR: [f64; 2] = [8.0, 9.0];
/// Between the bars of two vessels, or outlets, points.
const GAP: f64 = 7.0;
/// Space for a flow at the end of its bar, and for a time, points.
const ROOM: [f64; 2] = [40.0, 52.0];
/// The largest width of a vessel's name, points. Longer names are cut.
const NAME: f64 = 170.0;
/// The largest number of vessels, or outlets, shown.
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
    let mut shown = largest_first(flows, |flow| flow.rank());
    shown.truncate(MOST);
    let pair = flows.iter().any(|f| f.perturbed.is_some());
    let title = match (flows.len(), pair) {
        (n, _) if n > MOST => format!("Flow in the {MOST} vessels of largest flow{}", if pair { " or change" } else { "" }),
        _ => "Flow in the vessels".to_owned(),
    };
    let each = GAP + if pair { 2.0 * BAR[0] } else { BAR[0] };
    let top = if pair { TOP[0] } else { TOP[1] };
    let bottom = top + each * shown.len() as f64;
    let names: Vec<String> = shown.iter().map(|flow| fitting(&flow.name, NAME, TEXT)).collect();
    let left = names.iter().map(|name| room(name, TEXT)).fold(0.0, f64::max) + 22.0;
    let right = WIDTH - 14.0;
    let both = || shown.iter().flat_map(|f| [Some(f.along().0), f.along().1]).flatten();
    let (low, high) = (both().fold(0.0, f64::min), both().fold(0.0, f64::max));
    let range = LinearRange { low, high: if high > low { high } else { NO_FLOW } };
    let first = left + if low < 0.0 { ROOM[0] } else { 0.0 };
    let x = |flow: f64| first + (right - ROOM[0] - first) * range.share(flow);
    let mut sheet = Sheet::default();
    sheet.ticks_below([top, bottom], range.ticks(7).into_iter().map(|tick| (x(tick.at), tick.label)));
    sheet.line([[left, bottom], [right, bottom]], HAIR, INK, 1.0);
    let name = if pair { "flow along its unperturbed direction (mL/min)" } else { "flow (mL/min)" };
    sheet.plain(name, [f64::midpoint(left, right), bottom + TICK + NAME_BELOW], Align::Middle);
    sheet.title(&title, left);
    if pair {
        let keys = [("unperturbed", LegendKey::Box, UNPERTURBED), ("perturbed", LegendKey::Box, PERTURBED)];
        sheet.legend(left, &keys);
    }
    for (row, (flow, name)) in shown.iter().zip(names).enumerate() {
        let above = top + GAP / 2.0 + each * row as f64;
        sheet.plain(&name, [left - 8.0, above + (each - GAP) / 2.0], Align::End);
        let (before, after) = flow.along();
        for (above, flow, rgb) in [(above, Some(before), UNPERTURBED), (above + BAR[0], after, PERTURBED)] {
            let Some(flow) = flow else { continue };
            let (zero, end) = (x(0.0), x(flow));
            sheet.rectangle([zero.min(end), above], [(end - zero).abs(), BAR[0]], rgb);
            let (at, align) = if flow < 0.0 { (end - 3.0, Align::End) } else { (end + 3.0, Align::Begin) };
            sheet.small(&figure(flow), [at, above + BAR[0] / 2.0], align);
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
    TickLabel::plain(format!("{sign}{size:.*}", decimals(size)))
}

/// Height of the lines of the legend of inlets, and the entries in each.
const LEGEND: f64 = 15.0;
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
    let mut rows = largest_first(0..outlets.len(), |row| outlets[*row].flow);
    rows.truncate(MOST);
    rows.sort_unstable();
    let shown: Vec<&OutletSupply> = rows.into_iter().map(|row| &outlets[row]).collect();
    let which = if outlets.len() > MOST { format!("the {MOST} outlets of largest flow") } else { "every outlet".to_owned() };
    let height = |outlet: &OutletSupply| GAP + BAR[1] * outlet.states.len() as f64;
    let top = TOP[1] + LEGEND * inlets.len().div_ceil(IN_A_LINE) as f64;
    let bottom = top + shown.iter().map(|outlet| height(outlet)).sum::<f64>();
    let names: Vec<String> = shown.iter().map(|outlet| fitting(&outlet.name, WIDTH / 3.0, TEXT)).collect();
    let left = names.iter().map(|name| room(name, TEXT)).fold(0.0, f64::max) + 22.0;
    let right = WIDTH - 14.0 - ROOM[1];
    let x = |share: f64| left + (right - left) * share;
    let mut sheet = Sheet::default();
    sheet.title(&format!("Blood of {which}, by inlet"), left);
    // The colours of the inlets, between the title and the bars.
    let step = (WIDTH - left - 14.0) / IN_A_LINE as f64;
    for (at, (name, rgb)) in inlets.iter().enumerate() {
        let (line, place) = ((at / IN_A_LINE) as f64, (at % IN_A_LINE) as f64);
        let name = fitting(name, step - 28.0, TEXT);
        sheet.key([left + step * place, LEGEND_AT + LEGEND * line], &name, LegendKey::Box, *rgb);
    }
    let ticks = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| (x(share), TickLabel::plain(format!("{:.0}", 100.0 * share))));
    sheet.ticks_below([top, bottom], ticks);
    sheet.line([[left, bottom], [right, bottom]], HAIR, INK, 1.0);
    let pair = shown.iter().any(|outlet| outlet.states.len() > 1);
    let name = if pair { "share of the blood (%), as it is above, perturbed below" } else { "share of the blood (%)" };
    sheet.plain(name, [f64::midpoint(left, right), bottom + TICK + NAME_BELOW], Align::Middle);
    let mut above = top;
    for (outlet, name) in shown.into_iter().zip(names) {
        sheet.plain(&name, [left - 8.0, above + height(outlet) / 2.0], Align::End);
        for (at, state) in outlet.states.iter().enumerate() {
            let place = above + GAP / 2.0 + BAR[1] * at as f64;
            let Some((shares, time)) = state else {
                sheet.small(&TickLabel::plain("no blood"), [left + 3.0, place + BAR[1] / 2.0], Align::Begin);
                continue;
            };
            let mut from = 0.0;
            for (share, (_, rgb)) in shares.iter().zip(inlets) {
                sheet.rectangle([x(from), place], [x(*share) - left, BAR[1] - 1.0], *rgb);
                from += share;
            }
            sheet.small(&TickLabel::plain(format!("{time:.0} ms")), [right + 4.0, place + BAR[1] / 2.0], Align::Begin);
        }
        above += height(outlet);
    }
    Figure::new(TERRITORY_PICTURE, [WIDTH, bottom + BOTTOM], sheet)
}

/// Panels in a row, and the most that are shown.
const IN_A_ROW: usize = 4;
const MOST_PANELS: usize = 24;
/// The size of a panel's axes, points, and of what is left of, above and below them.
const PANEL: [f64; 2] = [104.0, 70.0];
const LEFT: f64 = 40.0;
const ABOVE: f64 = 36.0;
const BELOW: f64 = 24.0;
/// Above the panels: the title and the legend; below them: the name of the axis, points.
const AROUND: [f64; 2] = [42.0, 20.0];
/// Left of the panels, and right of them, where figures above the last one may go on.
const MARGIN: f64 = 12.0;
const RIGHT: f64 = 34.0;
const LINE: f64 = 1.2;
/// Less flow is none, mL/min.
const NONE: f64 = 1e-3;

/// The flow of one artery.
#[derive(Debug, Clone, PartialEq)]
pub struct ArteryWaveform {
    /// Its name.
    pub name: String,
    /// Whether it has a label of its own; those come first.
    pub is_named: bool,
    /// Before and, where there is one, after a perturbation: the flow at even times of a period (mL/min), its mean, and its pulsatility index.
    pub states: Vec<(Vec<f64>, f64, f64)>,
}

/// Draws the flow of up to 24 arteries over a period of `period` s: named ones first, then those of the largest mean flow.
pub fn waveform_panels(arteries: &[ArteryWaveform], period: f64) -> Figure {
    let mean_flow = |row: &usize| arteries[*row].states.iter().map(|(_, mean, _)| mean.abs()).fold(0.0, f64::max);
    let mut rows = largest_first(0..arteries.len(), mean_flow);
    rows.sort_by_key(|row| !arteries[*row].is_named);
    rows.truncate(MOST_PANELS);
    rows.sort_unstable();
    let shown: Vec<&ArteryWaveform> = rows.iter().map(|row| &arteries[*row]).collect();
    let some = (arteries.len() > MOST_PANELS).then(|| format!(" in {MOST_PANELS} of {} vessels", arteries.len()));
    let lines = shown.len().div_ceil(IN_A_ROW).max(1) as f64;
    let width = MARGIN + IN_A_ROW as f64 * (LEFT + PANEL[0]) + RIGHT;
    let height = AROUND[0] + lines * (ABOVE + PANEL[1] + BELOW) + AROUND[1];
    let (mut sheet, count) = (Sheet::default(), shown.len());
    sheet.title(&format!("Flow over a cycle{}", some.unwrap_or_default()), MARGIN + LEFT);
    if shown.iter().any(|artery| artery.states.len() > 1) {
        let keys = [("as it is", LegendKey::Line(LINE), UNPERTURBED), ("perturbed", LegendKey::Line(LINE), PERTURBED)];
        sheet.legend(MARGIN + LEFT, &keys);
    }
    for (at, artery) in shown.into_iter().enumerate() {
        let left = MARGIN + (at % IN_A_ROW) as f64 * (LEFT + PANEL[0]) + LEFT;
        let top = AROUND[0] + (at / IN_A_ROW) as f64 * (ABOVE + PANEL[1] + BELOW) + ABOVE;
        panel(&mut sheet, artery, period, [left, top]);
        if at % IN_A_ROW == 0 {
            sheet.upright("flow (mL/min)", [NAME_LEFT, top + PANEL[1] / 2.0]);
        }
        if at + IN_A_ROW >= count {
            sheet.plain("time (s)", [left + PANEL[0] / 2.0, top + PANEL[1] + TICK + NAME_BELOW], Align::Middle);
        }
    }
    Figure::new(WAVEFORM_PICTURE, [width, height], sheet)
}

fn panel(sheet: &mut Sheet, artery: &ArteryWaveform, period: f64, [left, top]: [f64; 2]) {
    let (right, bottom) = (left + PANEL[0], top + PANEL[1]);
    let values = || artery.states.iter().flat_map(|(flow, ..)| flow.iter().copied());
    sheet.plain(&fitting(&artery.name, PANEL[0] + LEFT - 8.0, TEXT), [left, top - 23.0], Align::Begin);
    let figures = artery.states.iter().map(|(_, mean, index)| {
        let index = if index.is_finite() { format!("{index:.2}") } else { "-".to_owned() };
        (format!("{:.0}", mean + 0.0).replace('-', "\u{2212}"), index)
    });
    let (means, indices): (Vec<String>, Vec<String>) = figures.unzip();
    // The font of the pictures has no arrow.
    let text = format!("mean {}; PI {}", means.join(" to "), indices.join(" to "));
    sheet.small(&TickLabel::plain(text), [left, top - 10.0], Align::Begin);
    let is_none = values().all(|flow| flow.abs() < NONE);
    let Some(range) = LinearRange::of(values().chain(if is_none { [-1.0, 1.0] } else { [0.0; 2] })) else { return };
    let y = |flow: f64| bottom - PANEL[1] * range.share(flow);
    for tick in range.ticks(4) {
        let at = y(tick.at);
        sheet.line([[left, at], [right, at]], HAIR, if tick.at == 0.0 { INK } else { GRID }, 1.0);
        sheet.small(&tick.label, [left - 3.0, at], Align::End);
    }
    sheet.line([[left, top], [left, bottom], [right, bottom]], HAIR, INK, 1.0);
    for share in [0.0, 0.5, 1.0] {
        sheet.tick_below([left + PANEL[0] * share, bottom], &TickLabel::plain(format!("{:.2}", period * share)), SMALL);
    }
    for ((flow, ..), rgb) in artery.states.iter().zip([UNPERTURBED, PERTURBED]) {
        let point = |at: usize| [left + PANEL[0] * at as f64 / flow.len() as f64, y(flow[at % flow.len()])];
        sheet.line((0..=flow.len()).map(point), LINE, rgb, 1.0);
    }
}
