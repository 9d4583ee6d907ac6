//! Womersley's theory of one tube: what a length of it resists, and what its wall takes up, at one frequency. A stretch of vessel is a
//! two-port: admittances between its ends and from each end to the ground, joined end to end.
//!
//! Per length, at the angular frequency ω (Womersley 1955; as a line of impedances Olufsen 1999, Alastruey et al. 2007):
//! Z' = iωρ/(A (1 - F10)) = 8µ/(πr⁴)/G and Y' = iωC'/(1 + iωφ), with C' = dA/dP and φ of a Kelvin-Voigt wall. Signals are Re c e^{iωt}.

use std::f64::consts::PI;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::flow::poiseuille::resistance;

/// The profile by which flow meets friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Friction {
    /// Womersley's: it follows from the frequency.
    #[default]
    Womersley,
    /// A parabola at every frequency, as most one-dimensional codes have it: Z' = 8µ/(πr⁴) + iωρ/A.
    Parabolic,
}

/// What flows, and how walls creep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluid {
    /// µ, Pa s.
    pub viscosity: f64,
    /// ρ, kg/m³.
    pub density: f64,
    /// The profile of the flow.
    pub friction: Friction,
    /// φ of the wall, s; 0 of an elastic one.
    pub wall_viscosity: f64,
}

/// A tube of one radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TubeSegment {
    /// l, m.
    pub length: f64,
    /// r, m.
    pub radius: f64,
    /// C' = dA/dP, m²/Pa; 0 of a rigid wall.
    pub compliance: f64,
    /// What a stated resistance has more than Poiseuille's, Pa s/m⁴; it adds to Z' at every frequency.
    pub excess: f64,
}

/// Above this α the Bessel functions are their asymptotic series.
const FAR: f64 = 1e4;

/// G = (1 - F10)/(iα²/8) at the Womersley number α = r √(ωρ/µ); 1 at rest.
///
/// G = s₁s₂ with the continued fraction sₙ = 1/(1 + iα² sₙ₊₁/(4n(n+1))) of Bessel functions' ratios, from its end: without
/// cancellation at any α. From n = 1.5 α + 12 on, further terms change no digit.
///
/// Far above, where these are too many, F10 = (2/x)(1 - 1/(2x) - 1/(8x²)), x = α√i: what is left out is below 10⁻¹² of it.
pub fn viscous(alpha: f64) -> Complex64 {
    let square = Complex64::new(0.0, alpha * alpha);
    if alpha > FAR {
        let x = Complex64::cis(PI / 4.0) * alpha;
        let f10 = (Complex64::ONE - x.inv() * 0.5 - (x * x).inv() * 0.125) * 2.0 / x;
        return (Complex64::ONE - f10) * 8.0 / square;
    }
    let mut s = Complex64::ONE;
    for n in (2..=(1.5 * alpha) as u32 + 12).rev() {
        s = (Complex64::ONE + square * s / f64::from(4 * n * (n + 1))).inv();
    }
    s * (Complex64::ONE + square * s / 8.0).inv()
}

/// The Womersley number α = r √(ωρ/µ).
pub fn womersley_number(fluid: &Fluid, frequency: f64, radius: f64) -> f64 {
    radius * (frequency * fluid.density / fluid.viscosity).sqrt()
}

impl TubeSegment {
    /// Z' (Pa s/m⁴) and Y' (m²/(Pa s)) at the angular frequency ω, 1/s.
    pub fn line(&self, fluid: &Fluid, frequency: f64) -> (Complex64, Complex64) {
        let friction = resistance(1.0, self.radius, fluid.viscosity);
        let z = match fluid.friction {
            Friction::Womersley => viscous(womersley_number(fluid, frequency, self.radius)).inv() * friction,
            Friction::Parabolic => Complex64::new(friction, frequency * fluid.density / (PI * self.radius * self.radius)),
        };
        let wall = Complex64::new(0.0, frequency * self.compliance) / Complex64::new(1.0, frequency * fluid.wall_viscosity);
        (z + self.excess, wall)
    }

    /// c₀ = √(A/(ρC')), the speed of a wave without viscosity, m/s; infinite in a rigid tube.
    pub fn wave_speed(&self, fluid: &Fluid) -> f64 {
        (PI * self.radius * self.radius / (fluid.density * self.compliance)).sqrt()
    }

    /// ω/Im γ, the speed at which a wave of the angular frequency ω moves, m/s; γ = √(Z'Y').
    pub fn phase_speed(&self, fluid: &Fluid, frequency: f64) -> f64 {
        let (z, y) = self.line(fluid, frequency);
        frequency / (z * y).sqrt().im
    }

    /// The wall shear stress (Pa) of a flow amplitude q (m³/s): (r/2) Z' F10 q with F10 = 1 - (iα²/8) G; 4µq/(πr³) at rest.
    pub fn wall_shear(radius: f64, fluid: &Fluid, frequency: f64, q: Complex64) -> Complex64 {
        let friction = q * (radius / 2.0 * resistance(1.0, radius, fluid.viscosity));
        match fluid.friction {
            Friction::Parabolic => friction,
            Friction::Womersley => {
                let alpha = womersley_number(fluid, frequency, radius);
                let g = viscous(alpha);
                friction * (g.inv() - Complex64::new(0.0, alpha * alpha / 8.0))
            }
        }
    }
}

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
        // A vessel of one radius, the usual one, is a line as a whole: its halves differ in nothing but their length.
        if let ([first], [last]) = (halves[0].as_slice(), halves[1].as_slice())
            && *last == (TubeSegment { length: last.length, ..*first })
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
