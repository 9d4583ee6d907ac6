//! How often a classification is right: each segment of the circle, and whole variants, balanced over those that occur.

use std::collections::BTreeMap;

use willis_io::formats::Column;
use willis_models::circle_of_willis::RING;

/// Which segments of [`RING`] are there.
pub type Segments = [bool; 7];

/// The segments of the front, those of the back, and all: L-A1, R-A1, AComm, then P1 and PComm.
const PARTS: [(&str, std::ops::Range<usize>); 3] = [("anterior", 0..3), ("posterior", 3..7), ("circle", 0..7)];

/// The columns of accuracy.csv, of pairs of what is true and what was found: a row for each segment, then for the variants of each part of the circle.
///
/// The balanced accuracy of a segment is the mean of sensitivity and specificity. That of a part is the mean, over the variants that are true of any subject, of the share
/// of their subjects in whom every segment of the part is right: the variant-balanced accuracy of TopCoW (Yang et al. 2023, arXiv:2312.17670).
pub fn accuracy_columns(pairs: &[(Segments, Segments)]) -> Vec<Column> {
    let share = |part: usize, of: usize| if of > 0 { part as f64 / of as f64 } else { f64::NAN };
    let mean = |of: &[f64]| {
        let known: Vec<f64> = of.iter().copied().filter(|x| x.is_finite()).collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    let segments = RING.iter().enumerate().map(|(at, artery)| {
        let count = |truth: bool, found: bool| pairs.iter().filter(|(t, f)| (t[at], f[at]) == (truth, found)).count();
        let [hit, missed, invented, absent] =
            [(true, true), (true, false), (false, true), (false, false)].map(|(t, f)| count(t, f));
        let rates = [share(hit, hit + missed), share(absent, absent + invented)];
        (artery.to_string(), 1, Some(([hit, missed, invented, absent], rates)), share(hit + absent, pairs.len()), mean(&rates))
    });
    let parts = PARTS.into_iter().map(|(name, of)| {
        let mut variants: BTreeMap<&[bool], [usize; 2]> = BTreeMap::new();
        for (truth, found) in pairs {
            let counts = variants.entry(&truth[of.clone()]).or_default();
            counts[0] += usize::from(truth[of.clone()] == found[of.clone()]);
            counts[1] += 1;
        }
        let right: usize = variants.values().map(|[right, _]| right).sum();
        let each: Vec<f64> = variants.values().map(|[right, all]| share(*right, *all)).collect();
        (name.to_owned(), variants.len(), None, share(right, pairs.len()), mean(&each))
    });
    let rows: Vec<_> = segments.chain(parts).collect();
    let counted =
        |name, at: usize| Column::real(name, rows.iter().map(move |row| row.2.map_or(f64::NAN, |(counts, _)| counts[at] as f64)));
    let rate = |name, at: usize| Column::real(name, rows.iter().map(move |row| row.2.map_or(f64::NAN, |(_, rates)| rates[at])));
    vec![
        Column::text("what", rows.iter().map(|row| row.0.clone())),
        Column::whole("subjects", rows.iter().map(|_| pairs.len())),
        Column::real("variants", rows.iter().map(|row| if row.2.is_some() { f64::NAN } else { row.1 as f64 })),
        counted("there_found", 0),
        counted("there_missed", 1),
        counted("absent_found", 2),
        counted("absent_missed", 3),
        rate("sensitivity", 0),
        rate("specificity", 1),
        Column::real("accuracy", rows.iter().map(|row| row.3)),
        Column::real("balanced_accuracy", rows.iter().map(|row| row.4)),
    ]
}
