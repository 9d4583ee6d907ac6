//! Numbers as programs write them, decimal or hexadecimal as C prints them (graph-tool does), and as notes count things.

use super::rows::Row;
use crate::error::Fault;
use crate::network::units::Scale;
use crate::support::geometry::Point;

/// The number that a text is, or what is accepted in its place.
pub(crate) fn number(text: &str) -> Result<f64, &'static str> {
    if let Some(x) = text.parse().ok().or_else(|| hexadecimal(text)) {
        return Ok(x);
    }
    match text.replacen(',', ".", 1).parse::<f64>() {
        Ok(_) if text.contains(',') => Err("expected a decimal point, not a comma"),
        _ => Err("expected a number"),
    }
}

/// So many things: "1 edge", "2 edges".
pub(crate) fn counted(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

/// `[-]0xH.HHHp[+-]D`: the significand in hexadecimal digits, times a power of two.
fn hexadecimal(text: &str) -> Option<f64> {
    let (sign, text) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"))?;
    let (significand, exponent) = digits.split_once(['p', 'P'])?;
    let (whole, fraction) = significand.split_once('.').unwrap_or((significand, ""));
    let all = format!("{whole}{fraction}");
    let plain = all.bytes().all(|b| b.is_ascii_hexdigit()) && all.len() <= 15;
    let value = if plain { u64::from_str_radix(&all, 16).ok()? } else { return None };
    let power = exponent.parse::<i32>().ok().filter(|e| e.abs() < 5000)? - 4 * fraction.len() as i32;
    // In two steps, so that no power on the way leaves the range.
    Some(sign * value as f64 * 2_f64.powi(power / 2) * 2_f64.powi(power - power / 2))
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn decimal_and_hexadecimal_numbers_are_read_and_commas_named() {
        // Python: (10.875).hex(), (-0.1).hex(), (2**-1074).hex(), sys.float_info.max.hex(), (0.0).hex()
        assert_eq!(number("0x1.5c00000000000p+3"), Ok(10.875));
        assert_eq!(number("-0x1.999999999999ap-4"), Ok(-0.1));
        assert_eq!(number("0x0.0000000000001p-1022"), Ok(5e-324));
        assert_eq!(number("0x1.fffffffffffffp+1023"), Ok(f64::MAX));
        assert_eq!(number("0x0.0p+0"), Ok(0.0));
        assert_eq!(number("1.5e-3"), Ok(1.5e-3));
        assert_eq!(number("1,5"), Err("expected a decimal point, not a comma"));
        for wrong in ["", "abc", "1,5,2", "0x", "0x1.8", "0xp1", "0x1p99999", "0x11111111111111111p0", "0x1.8p+-3"] {
            assert_eq!(number(wrong), Err("expected a number"), "{wrong}");
        }
    }
}

impl Row<'_> {
    /// The length in a column, m; NaN for an empty one.
    pub(crate) fn length(&self, column: usize, scale: &Scale) -> Result<f64, Fault> {
        Ok(self.scale(column, scale).length(self.real(column)?))
    }

    /// The finite position in three columns, m.
    pub(crate) fn point(&self, columns: [usize; 3], scale: &Scale) -> Result<Point, Fault> {
        let position = self.position(columns)?;
        Ok([0, 1, 2].map(|axis| self.scale(columns[axis], scale).position(position)[axis]))
    }

    fn scale(&self, column: usize, scale: &Scale) -> Scale {
        if self.name(column).to_ascii_lowercase().ends_with("_mm") { Scale::default() } else { *scale }
    }
}
