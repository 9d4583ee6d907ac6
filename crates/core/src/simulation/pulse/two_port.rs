//! A stretch of vessel as a two-port: admittances between its ends and from each end to the ground, joined end to end.

use num_complex::Complex64;

use super::womersley::{Fluid, TubeSegment};

/// Q_a = y_s (P_a - P_b) + y_a P_a flows in at the first end, Q_b = y_s (P_a - P_b) - y_b P_b out at the second; m³/(Pa s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoPort {
    /// y_s.
    pub series: Complex64,
    /// y_a and y_b.
    pub shunts: [Complex64; 2],
}

/// Below this |x| the functions of x = γl are 1 to the last digit but for a term in x².
const SMALL: f64 = 1e-4;
/// Above this Re x e^{-x} is nothing beside 1.
const LARGE: f64 = 40.0;

/// x/sinh x and tanh(x/2)/(x/2). Both are made of sinh x/2 and cosh x/2, so that near x = πi, where a line without friction is half a wave and
/// both are infinite, their ratio keeps its digits: one over 1 + cosh x.
fn over_sinh_and_tanh_over(x: Complex64) -> [Complex64; 2] {
    let half = x / 2.0;
    if x.norm() < SMALL {
        [Complex64::ONE - x * x / 6.0, Complex64::ONE - x * x / 12.0]
    } else if x.re > LARGE {
        [x * 2.0 * (-x).exp(), half.inv()]
    } else {
        let (sinh, cosh) = (half.sinh(), half.cosh());
        [half / (sinh * cosh), sinh / (cosh * half)]
    }
}

impl TwoPort {
    /// What conducts nothing.
    pub const CLOSED: Self = Self { series: Complex64::ZERO, shunts: [Complex64::ZERO; 2] };

    /// A length l of a line of Z' and Y' (the π circuit): y_s = (1/(Z'l)) x/sinh x, y_a = y_b = (Y'l/2) tanh(x/2)/(x/2), x = l√(Z'Y').
    /// Both are even in x, so that it does not matter which root is taken.
    pub fn of_line((z, y): (Complex64, Complex64), length: f64) -> Self {
        let (z, y) = (z * length, y * length);
        let x = (z * y).sqrt();
        let [series, shunt] = over_sinh_and_tanh_over(x);
        Self { series: series / z, shunts: [y / 2.0 * shunt; 2] }
    }

    /// This one with another behind it. The node between is eliminated, so nothing is subtracted.
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        let between = self.shunts[1] + next.shunts[0];
        let all = self.series + next.series + between;
        let share = |own: Complex64| own / all;
        Self {
            series: self.series * share(next.series),
            shunts: [self.shunts[0] + between * share(self.series), next.shunts[1] + between * share(next.series)],
        }
    }
}

/// A vessel cut in the middle: what it is as a whole, and its two halves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Halved {
    /// The whole vessel.
    pub whole: TwoPort,
    /// From the first node to the middle, and from there to the second.
    pub halves: [TwoPort; 2],
}

impl Halved {
    /// A vessel of segments, those before and those behind its middle. One that is closed has none.
    pub fn of(halves: &[Vec<TubeSegment>; 2], fluid: &Fluid, frequency: f64) -> Self {
        // A vessel of one radius, the usual one, is a line as a whole.
        if let ([first], [last]) = (halves[0].as_slice(), halves[1].as_slice())
            && first.is_like(last)
        {
            let line = first.line(fluid, frequency);
            let half = TwoPort::of_line(line, first.length);
            return Self { whole: TwoPort::of_line(line, first.length + last.length), halves: [half; 2] };
        }
        let joined = |segments: &[TubeSegment]| {
            let each = segments.iter().map(|segment| TwoPort::of_line(segment.line(fluid, frequency), segment.length));
            each.reduce(TwoPort::then).unwrap_or(TwoPort::CLOSED)
        };
        let halves = [joined(&halves[0]), joined(&halves[1])];
        let open = halves.iter().all(|half| half.series != Complex64::ZERO);
        Self { whole: if open { halves[0].then(halves[1]) } else { TwoPort::CLOSED }, halves }
    }

    /// The flow in at the first end and out at the second.
    pub fn end_flows(&self, [a, b]: [Complex64; 2]) -> [Complex64; 2] {
        let through = self.whole.series * (a - b);
        [through + self.whole.shunts[0] * a, through - self.whole.shunts[1] * b]
    }

    /// The pressure in the middle, and the flow there.
    pub fn middle(&self, [a, b]: [Complex64; 2]) -> (Complex64, Complex64) {
        let [first, last] = self.halves;
        let pressure = (first.series * a + last.series * b) / (first.series + last.series + first.shunts[1] + last.shunts[0]);
        (pressure, first.series * (a - pressure) - first.shunts[1] * pressure)
    }
}
