//! Reads one period of a pressure or a flow: a table with `time_s` and `pressure_mmHg` or `flow_mL_per_min`, or an inlet file of openBF.

use willis_core::error::Fault;
use willis_core::network::units::{cubic_metres_per_second, pascals};
use willis_core::network::waveform::{Quantity, Waveform};

const PRESSURE: &str = "pressure_mmHg";
const FLOW: &str = "flow_mL_per_min";

/// The line, the time and the value of a row, in SI units.
type TimedValue = (usize, f64, f64);

/// Reads a waveform, and what a person should know about it; other columns are left alone. Times that fall by no more than a mean step
/// between rows are put in order.
///
/// # Errors
///
/// No column of times; both a pressure and a flow, or neither; fewer than two rows; a time that falls by more; a number that is not finite.
pub fn read_waveform(bytes: &[u8]) -> Result<(Waveform, Option<String>), Fault> {
    inlet_of_openbf(bytes).map_or_else(|| read_table(bytes), |(quantity, rows)| in_order(quantity, rows))
}

/// The rows of an inlet file of openBF, which has no header: a time and a flow in m³/s, or a pressure in Pa. No heart gives 1 m³/s, and
/// no pressure stays below 1 Pa.
fn inlet_of_openbf(bytes: &[u8]) -> Option<(Quantity, Vec<TimedValue>)> {
    let mut rows = Vec::new();
    for (row, line) in std::str::from_utf8(bytes).ok()?.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let numbers: Option<Vec<f64>> =
            line.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let [t, x] = numbers?[..] else { return None };
        rows.push((row + 1, t, x));
    }
    let is_flow = rows.iter().all(|(_, _, x)| x.abs() < 1.0);
    (!rows.is_empty()).then_some((if is_flow { Quantity::Flow } else { Quantity::Pressure }, rows))
}

fn read_table(bytes: &[u8]) -> Result<(Waveform, Option<String>), Fault> {
    let mut rows = super::reader::TableReader::open(bytes)?;
    let time = rows.column(&["time_s"], "the time of each row")?;
    let (quantity, column) = match (rows.find(&[PRESSURE]), rows.find(&[FLOW])) {
        (Some(_), Some(_)) => {
            let found = format!("both {PRESSURE} and {FLOW}");
            return Err(Fault::line(rows.header_line, found, "expected one of them: an inlet has a pressure or a flow"));
        }
        (Some(column), None) => (Quantity::Pressure, column),
        (None, Some(column)) => (Quantity::Flow, column),
        (None, None) => {
            let accepted = format!("expected a column {PRESSURE} or {FLOW}");
            return Err(Fault::line(rows.header_line, super::reader::columns(&rows.header), accepted));
        }
    };
    let mut read = Vec::new();
    while let Some(row) = rows.row()? {
        let (t, x) = (row.finite(time)?, row.finite(column)?);
        let value = if quantity == Quantity::Pressure { pascals(x) } else { cubic_metres_per_second(x) };
        read.push((row.line, t, value));
    }
    in_order(quantity, read)
}

/// The waveform of rows whose times may fall a little.
fn in_order(quantity: Quantity, mut read: Vec<TimedValue>) -> Result<(Waveform, Option<String>), Fault> {
    let step = if let [(_, first, _), .., (_, last, _)] = read[..] { (last - first) / (read.len() - 1) as f64 } else { 0.0 };
    let falls: Vec<&[TimedValue]> = read.windows(2).filter(|pair| pair[1].1 < pair[0].1).collect();
    if let Some([(_, before, _), (line, t, _)]) = falls.iter().copied().find(|pair| pair[0].1 - pair[1].1 > step) {
        return Err(Fault::line(*line, format!("time_s {t} after {before}"), "expected times that never fall"));
    }
    let note = falls.first().map(|pair| {
        let by = falls.iter().map(|pair| pair[0].1 - pair[1].1).fold(0.0, f64::max);
        format!("line {}: times that fall, by {by:.2e} s at most, are put in order", pair[1].0)
    });
    read.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (times, values): (Vec<f64>, Vec<f64>) = read.into_iter().map(|(_, t, value)| (t, value)).unzip();
    if times.len() < 2 || times[0] == times[times.len() - 1] {
        let found = if times.len() == 1 { "one row".to_owned() } else { format!("{} rows at one time", times.len()) };
        return Err(Fault::file(found, "expected two or more rows over one period"));
    }
    Ok((Waveform { quantity, times, values }, note))
}
