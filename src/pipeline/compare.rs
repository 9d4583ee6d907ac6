//! Two groups of subjects compared in what was measured of them, with the doubt about their topologies.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use serde::{Deserialize, Serialize};

use super::Measurement;
use willis_core::error::{Error, Result};
use willis_core::support::comparison::{GroupDifference, compare, drawn_by_weight, holm, quartiles};
use willis_core::support::in_order;
use willis_core::support::suggestions::did_you_mean;
use willis_io::formats::Column;
use willis_report::NamedFigures;

/// So many times a plausible topology is drawn for each subject.
const IMPUTATIONS: usize = 20;

/// How groups are compared.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ComparisonOptions {
    /// The measures that are compared, by their columns in subjects.csv; all without any.
    pub measures: Vec<String>,
    /// The seed of topologies and permutations.
    pub seed: u64,
}

/// The two groups among the values that subjects have, in the order of their names, and of each subject whether it is in the first; none for one
/// without a value.
///
/// # Errors
///
/// More or fewer than two groups, or one of a single subject.
pub fn two_groups(column: &str, values: &[&str]) -> Result<([String; 2], Vec<Option<bool>>)> {
    let mut names: Vec<&str> = values.iter().copied().filter(|value| !value.is_empty()).collect();
    names.sort_unstable();
    names.dedup();
    let refused =
        |why: String| Err(Error::parameter("compare", column, format!("expected two groups of two subjects at least, {why}")));
    let [first, second] = *names else {
        let shown: Vec<&str> = names.iter().copied().take(4).collect();
        let more = if names.len() > shown.len() { ", ..." } else { "" };
        return refused(format!("found {}: {}{more}", names.len(), shown.join(", ")));
    };
    for name in [first, second] {
        if values.iter().filter(|value| **value == name).count() < 2 {
            return refused(format!("found one of {column} {name}"));
        }
    }
    let of = values.iter().map(|value| (!value.is_empty()).then(|| *value == first)).collect();
    Ok(([first.to_owned(), second.to_owned()], of))
}

/// The columns of comparison.csv: how the subjects of two groups differ in each measure. `subjects` are those measured, each with whether it is in
/// the first group.
///
/// # Errors
///
/// A measure that no subject has.
pub fn compare_groups(
    groups: &[String; 2],
    subjects: &[(&Measurement, bool)],
    options: &ComparisonOptions,
) -> Result<Vec<Column>> {
    let names = measures(subjects, &options.measures)?;
    let first: Vec<bool> = subjects.iter().map(|(_, first)| *first).collect();
    let tables: Vec<Vec<HashMap<&str, f64>>> = subjects
        .iter()
        .enumerate()
        .map(|(at, (found, _))| imputed(found, options.seed, at).into_iter().map(by_name).collect())
        .collect();
    let kept: Vec<HashMap<&str, f64>> = subjects.iter().map(|(found, _)| by_name(&found.figures)).collect();
    let of = |table: &HashMap<&str, f64>, name: &str| table.get(name).copied().unwrap_or(f64::NAN);
    let differences = in_order(&names, |_, name| {
        let imputations: Vec<Vec<f64>> =
            (0..IMPUTATIONS).map(|draw| tables.iter().map(|subject| of(&subject[draw], name)).collect()).collect();
        compare(&imputations, &first, options.seed)
    });
    let found: Vec<(&Cow<'_, str>, GroupDifference)> =
        names.iter().zip(differences).filter_map(|(name, d)| Some((name, d?))).collect();
    let corrected = holm(&found.iter().map(|(_, d)| d.p).collect::<Vec<_>>());
    let spread = |name: &str, group: bool| {
        quartiles(kept.iter().zip(&first).filter(|(_, is)| **is == group).map(|(table, _)| of(table, name)))
    };
    let spreads: Vec<[(usize, [f64; 3]); 2]> =
        found.iter().map(|(name, _)| [true, false].map(|group| spread(name, group))).collect();
    let mut columns = vec![Column::text("measure", found.iter().map(|(name, _)| name.to_string()))];
    for (side, (letter, name)) in ["a", "b"].into_iter().zip(groups).enumerate() {
        columns.push(Column::text(format!("group_{letter}"), found.iter().map(|_| name.clone())));
        columns.push(Column::whole(format!("n_{letter}"), spreads.iter().map(|of| of[side].0)));
        for (at, what) in ["quartile_1", "median", "quartile_3"].into_iter().enumerate() {
            columns.push(Column::real(format!("{what}_{letter}"), spreads.iter().map(|of| of[side].1[at])));
        }
    }
    let real = |name, of: fn(&GroupDifference) -> f64| Column::real(name, found.iter().map(move |(_, d)| of(d)));
    columns.extend([
        real("cliffs_delta", |d| d.delta),
        real("delta_low", |d| d.interval[0]),
        real("delta_high", |d| d.interval[1]),
        real("doubt_share", |d| d.doubt),
        real("p", |d| d.p),
        Column::real("p_holm", corrected.into_iter()),
    ]);
    Ok(columns)
}

fn by_name(figures: &NamedFigures) -> HashMap<&str, f64> {
    figures.iter().map(|(name, x)| (&**name, *x)).collect()
}

/// The measures that are wanted, of those that any subject has.
fn measures<'a>(subjects: &[(&'a Measurement, bool)], wanted: &[String]) -> Result<Vec<Cow<'a, str>>> {
    let mut known = HashSet::new();
    let all = subjects.iter().flat_map(|(found, _)| &found.figures).map(|(name, _)| Cow::Borrowed(&**name));
    let all: Vec<Cow<'a, str>> = all.filter(|name| known.insert(name.clone())).collect();
    if let Some(missing) = wanted.iter().find(|name| !all.iter().any(|known| *known == **name)) {
        let meant = did_you_mean(missing, all.iter().map(|name| &**name));
        let accepted = format!("{meant}expected columns of subjects.csv that are measured");
        return Err(Error::parameter("measures", format!("\"{missing}\""), accepted));
    }
    Ok(all.into_iter().filter(|name| wanted.is_empty() || wanted.iter().any(|wanted| **wanted == **name)).collect())
}

/// The figures of topologies that are drawn by their weights; without doubt those that are kept, every time. `number` is that of the subject.
fn imputed(found: &Measurement, seed: u64, number: usize) -> Vec<&NamedFigures> {
    let weights: Vec<f64> = found.plausible.iter().map(|(_, weight)| *weight).collect();
    let drawn = drawn_by_weight(&weights, IMPUTATIONS, seed, number as u64);
    if drawn.is_empty() {
        return vec![&found.figures; IMPUTATIONS];
    }
    drawn.into_iter().map(|at| &found.plausible[at].0).collect()
}
