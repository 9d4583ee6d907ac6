//! How far runs with different occlusion probabilities agree.

use crate::formats::Column;
use crate::inference::Answer;

/// The columns of agreement.csv: per pair of occlusion probabilities how many uncertain vessels are decided alike, and of
/// how many.
pub fn agreement(decisions: &[(f64, Answer)], uncertain: &[bool]) -> Vec<Column> {
    let pairs: Vec<(usize, usize)> = (0..decisions.len()).flat_map(|i| (i + 1..decisions.len()).map(move |j| (i, j))).collect();
    let same = |(i, j): &(usize, usize)| {
        let (a, b) = (&decisions[*i].1.kept, &decisions[*j].1.kept);
        a.iter().zip(b).zip(uncertain).filter(|((a, b), uncertain)| **uncertain && a == b).count()
    };
    let uncertain_count = uncertain.iter().filter(|u| **u).count();
    vec![
        Column::real("epsilon_a", pairs.iter().map(|(i, _)| decisions[*i].0)),
        Column::real("epsilon_b", pairs.iter().map(|(_, j)| decisions[*j].0)),
        Column::whole("decided_alike", pairs.iter().map(same)),
        Column::whole("uncertain", pairs.iter().map(|_| uncertain_count)),
    ]
}
