//! Cohen's kappa: how far two readers agree beyond what chance would do.
//!
//! κ = (p_o - p_e)/(1 - p_e), where p_o is the share of questions that both answered alike, and p_e = Σ p_i. p_.i the share that chance would give by how often each
//! reader gives each answer (Cohen 1960, doi:10.1177/001316446002000104). Its variance for many questions is that of Fleiss, Cohen and Everitt (1969,
//! doi:10.1037/h0028106).

use super::comparison::Z;

/// How far two readers agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CohenKappa {
    /// Questions that both answered.
    pub count: usize,
    /// How many of them alike.
    pub alike: usize,
    /// Kappa; not a number without a question, or where both only ever gave one and the same answer.
    pub kappa: f64,
    /// Its interval of 95 % for many questions, within [-1, 1].
    pub interval: [f64; 2],
}

/// Kappa of pairs of answers, each one of `0..answers`.
pub fn cohen_kappa(pairs: &[[usize; 2]], answers: usize) -> CohenKappa {
    let n = pairs.len() as f64;
    let mut table = vec![vec![0.0; answers]; answers];
    let mut margins = vec![[0.0; 2]; answers];
    for [a, b] in pairs {
        table[*a][*b] += 1.0 / n;
        margins[*a][0] += 1.0 / n;
        margins[*b][1] += 1.0 / n;
    }
    let alike = pairs.iter().filter(|[a, b]| a == b).count();
    let (observed, chance) = (alike as f64 / n, margins.iter().map(|[a, b]| a * b).sum::<f64>());
    // Sums of shares are not quite 1.
    let beyond = if margins.iter().any(|of| of.iter().all(|share| *share > 1.0 - 0.5 / n)) { 0.0 } else { 1.0 - chance };
    let kappa = if beyond > 0.0 { (observed - chance) / beyond } else { f64::NAN };
    let mut variance = -(observed * chance - 2.0 * chance + observed).powi(2);
    for (i, row) in table.iter().enumerate() {
        for (j, share) in row.iter().enumerate() {
            variance += if i == j {
                share * (beyond - (margins[i][0] + margins[i][1]) * (1.0 - observed)).powi(2)
            } else {
                share * ((1.0 - observed) * (margins[i][1] + margins[j][0])).powi(2)
            };
        }
    }
    // Of readers who always agree it is zero but for rounding.
    let variance = if alike == pairs.len() { 0.0 } else { variance.max(0.0) };
    let error = (variance / n).sqrt() / (beyond * beyond);
    CohenKappa { count: pairs.len(), alike, kappa, interval: [-Z, Z].map(|z| (kappa + z * error).clamp(-1.0, 1.0)) }
}
