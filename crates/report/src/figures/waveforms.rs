//! The flow of arteries over a cycle, a panel each, with mean and pulsatility index above, as ultrasound shows them.

use super::axis::{LinearRange, TickLabel};
use super::colour::{GRID, INK, PERTURBED, UNPERTURBED};
use super::figure::Figure;
use super::legend::{self, LegendKey};
use super::sheet::{Align, Sheet, TextDirection};
use super::style::{self, HAIR, NAME_BELOW, NAME_LEFT, SMALL, TEXT, TICK};
use willis_io::output::names::WAVEFORM_PICTURE;

/// Panels in a row, and the most that are shown.
const IN_A_ROW: usize = 4;
const MOST: usize = 24;
/// The size of a panel's axes, points, and of what is left of, above and below them.
const PANEL: [f64; 2] = [104.0, 70.0];
const LEFT: f64 = 40.0;
const ABOVE: f64 = 36.0;
const BELOW: f64 = 24.0;
/// Above the panels: the title and the legend; below them: the name of the axis, points.
const TOP: f64 = 42.0;
const BOTTOM: f64 = 20.0;
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
    let mut rows: Vec<usize> = (0..arteries.len()).collect();
    let flow = |row: usize| arteries[row].states.iter().map(|(_, mean, _)| mean.abs()).fold(0.0, f64::max) as f32;
    rows.sort_by(|a, b| arteries[*b].is_named.cmp(&arteries[*a].is_named).then(flow(*b).total_cmp(&flow(*a))));
    rows.truncate(MOST);
    rows.sort_unstable();
    let shown: Vec<&ArteryWaveform> = rows.iter().map(|row| &arteries[*row]).collect();
    let some = (arteries.len() > MOST).then(|| format!(" in {MOST} of {} vessels", arteries.len()));
    let title = format!("Flow over a cycle{}", some.unwrap_or_default());
    let lines = shown.len().div_ceil(IN_A_ROW).max(1) as f64;
    let width = MARGIN + IN_A_ROW as f64 * (LEFT + PANEL[0]) + RIGHT;
    let height = TOP + lines * (ABOVE + PANEL[1] + BELOW) + BOTTOM;
    let (mut sheet, count) = (Sheet::default(), shown.len());
    sheet.title(&title, MARGIN + LEFT);
    if shown.iter().any(|artery| artery.states.len() > 1) {
        let keys = [("as it is", LegendKey::Line(LINE), UNPERTURBED), ("perturbed", LegendKey::Line(LINE), PERTURBED)];
        legend::legend(&mut sheet, MARGIN + LEFT, &keys);
    }
    for (at, artery) in shown.into_iter().enumerate() {
        let left = MARGIN + (at % IN_A_ROW) as f64 * (LEFT + PANEL[0]) + LEFT;
        let top = TOP + (at / IN_A_ROW) as f64 * (ABOVE + PANEL[1] + BELOW) + ABOVE;
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
    sheet.plain(&style::fitting(&artery.name, PANEL[0] + LEFT - 8.0, TEXT), [left, top - 23.0], Align::Begin);
    let figures = artery.states.iter().map(|(_, mean, index)| {
        let index = if index.is_finite() { format!("{index:.2}") } else { "-".to_owned() };
        (format!("{:.0}", mean + 0.0).replace('-', "\u{2212}"), index)
    });
    let (means, indices): (Vec<String>, Vec<String>) = figures.unzip();
    // The font of the pictures has no arrow.
    let text = format!("mean {}; PI {}", means.join(" to "), indices.join(" to "));
    sheet.text(&TickLabel::plain(text), [left, top - 10.0], SMALL, Align::Begin, TextDirection::Right);
    let is_none = values().all(|flow| flow.abs() < NONE);
    let Some(range) = LinearRange::of(values().chain(if is_none { [-1.0, 1.0] } else { [0.0; 2] })) else { return };
    let y = |flow: f64| bottom - PANEL[1] * range.share(flow);
    for tick in range.ticks(4) {
        let at = y(tick.at);
        sheet.line([[left, at], [right, at]], HAIR, if tick.at == 0.0 { INK } else { GRID }, 1.0);
        sheet.text(&tick.label, [left - 3.0, at], SMALL, Align::End, TextDirection::Right);
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
