//! How far runs with different occlusion probabilities agree.

use crate::formats::{Column, Values};
use crate::inference::Answer;

/// The columns of agreement.csv: per pair of occlusion probabilities how many vessels on trial are decided alike, and of
/// how many.
pub fn agreement(decisions: &[(f64, Answer)], uncertain: &[bool]) -> Vec<Column> {
    let pairs: Vec<(usize, usize)> = (0..decisions.len()).flat_map(|i| (i + 1..decisions.len()).map(move |j| (i, j))).collect();
    let same = |(i, j): &(usize, usize)| {
        let (a, b) = (&decisions[*i].1.kept, &decisions[*j].1.kept);
        a.iter().zip(b).zip(uncertain).filter(|((a, b), uncertain)| **uncertain && a == b).count()
    };
    let real = |name, values: Vec<f64>| Column { name, values: Values::Real(values) };
    vec![
        real("epsilon_a", pairs.iter().map(|(i, _)| decisions[*i].0).collect()),
        real("epsilon_b", pairs.iter().map(|(_, j)| decisions[*j].0).collect()),
        Column { name: "decided_alike", values: Values::Integer(pairs.iter().map(|p| same(p) as i64).collect()) },
        Column {
            name: "on_trial",
            values: Values::Integer(pairs.iter().map(|_| uncertain.iter().filter(|u| **u).count() as i64).collect()),
        },
    ]
}
