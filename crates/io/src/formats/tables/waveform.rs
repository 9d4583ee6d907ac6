//! Reads one period of a pressure or a flow: a table with `time_s` and `pressure_mmHg` or `flow_mL_per_min`.

use super::reader::{TableReader, columns};
use willis_core::error::Fault;
use willis_core::network::units::{cubic_metres_per_second, pascals};
use willis_core::network::waveform::{Quantity, Waveform};

const PRESSURE: &str = "pressure_mmHg";
const FLOW: &str = "flow_mL_per_min";

/// Reads a waveform, and what a person should know about it; other columns are left alone. Times that fall by no more than a mean step
/// between rows are put in order.
///
/// # Errors
///
/// No column of times; both a pressure and a flow, or neither; fewer than two rows; a time that falls by more; a number that is not finite.
pub fn read_waveform(bytes: &[u8]) -> Result<(Waveform, Option<String>), Fault> {
    let mut rows = TableReader::open(bytes)?;
    let time = rows.column(&["time_s"], "the time of each row")?;
    let quantity = match (rows.find(&[PRESSURE]), rows.find(&[FLOW])) {
        (Some(_), Some(_)) => {
            let found = format!("both {PRESSURE} and {FLOW}");
            return Err(Fault::line(rows.header_line(), found, "expected one of them: an inlet has a pressure or a flow"));
        }
        (Some(column), None) => (Quantity::Pressure, column),
        (None, Some(column)) => (Quantity::Flow, column),
        (None, None) => {
            let accepted = format!("expected a column {PRESSURE} or {FLOW}");
            return Err(Fault::line(rows.header_line(), columns(rows.header()), accepted));
        }
    };
    let (quantity, column) = quantity;
    // The line, the time and the value of each row.
    let mut read: Vec<(usize, f64, f64)> = Vec::new();
    while let Some(row) = rows.row()? {
        let (t, x) = (row.finite(time)?, row.finite(column)?);
        let value = match quantity {
            Quantity::Pressure => pascals(x),
            Quantity::Flow => cubic_metres_per_second(x),
        };
        read.push((row.line, t, value));
    }
    let step = match read.as_slice() {
        [(_, first, _), .., (_, last, _)] => (last - first) / (read.len() - 1) as f64,
        _ => 0.0,
    };
    let falls: Vec<&[(usize, f64, f64)]> = read.windows(2).filter(|pair| pair[1].1 < pair[0].1).collect();
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
