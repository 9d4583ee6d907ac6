//! A model that names arteries: the atlas, which pieces are false, which segments are there; and its file.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use super::atlas::{
    Atlas, AtlasData, AtlasPiece, AtlasState, LABELS, NOWHERE, STATES, StatePair, StateTables, StatesOfArms, artery_of, bins_of,
    first_state, label_named, name_of,
};
use super::pieces::PIECE_FEATURES;
use super::presence::{KINDS, PRESENCE_FEATURES};
use crate::circle_of_willis::{Artery, BodySide};
use willis_core::error::{Fault, Result, ensure};
use willis_core::support::toml_text::{parse, write};
use willis_core::support::{model_provenance::ModelProvenance, statistics::sigmoid};

/// How well names were found for subjects that were held out.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamingScores {
    /// The level of damage.
    pub of: String,
    /// How many cases.
    pub cases: usize,
    /// The mean share of the length that has the right name, false pieces apart.
    pub length_right: f64,
    /// The same with M1 and M2 as one.
    pub length_right_mca: f64,
    /// The share of the segments of the ring whose presence is right ...
    pub presence_right: f64,
    /// ... and of the cases with all of them right.
    pub exact: f64,
}

/// A logistic regression: the constant, then the slopes.
pub type Logistic = Vec<f64>;

/// A model that names arteries.
#[derive(Debug, Clone)]
pub struct NamingModel {
    /// Where it comes from.
    pub provenance: ModelProvenance,
    /// How well such models did.
    pub figures: Vec<NamingScores>,
    /// The atlas.
    pub atlas: Atlas,
    /// Per pass, whether a piece is false. The second pass has the logarithm of what the first one said as its last feature.
    pub false_pieces: [Logistic; 2],
    /// Per kind of segment, whether it is there; the last feature is the log odds of the plausible topologies.
    pub presence: [Logistic; KINDS],
    /// Per kind of segment the share of the cases that have it.
    pub share: [f64; KINDS],
}

/// The place of the log odds of the plausible topologies among the weights of `presence`.
pub const TOPOLOGY_FEATURE: usize = 1 + PRESENCE_FEATURES;

/// P = 1/(1 + e^-z) of a logistic regression.
pub fn logistic_probability(weights: &[f64], features: &[f64]) -> f64 {
    sigmoid(weights[0] + weights[1..].iter().zip(features).map(|(w, x)| w * x).sum::<f64>())
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NamingFile {
    format: String,
    other_radius: [f64; 2],
    centroid: [f64; 3],
    false_pieces: [Vec<f64>; 2],
    presence: [Vec<f64>; KINDS],
    share: [f64; KINDS],
    within_branches: Vec<(String, String, f64)>,
    at_junctions: Vec<(String, String, f64)>,
    bifurcations: Vec<(String, String, String, String, f64)>,
    #[serde(default)]
    provenance: ModelProvenance,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    figures: Vec<NamingScores>,
    states: Vec<StateRow>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StateRow {
    name: String,
    mean: [f64; 3],
    covariance: [f64; 6],
    direction: [f64; 6],
    log_radius: [f64; 2],
    length: f64,
}

const HEADING: &str = "\
# Names of the arteries of the Circle of Willis: lengths in mm, positions in RAS about the middle of the carotid bifurcations.
# false_pieces: whether a piece is false: a constant and the weights of its features, for the first and the second pass.
# presence: whether an A1, AComm, PComm, P1 is there; the last feature is the log odds of the plausible topologies.
# within_branches, at_junctions: neighbours within a branch, and those of which one is a junction: how often they were seen.
# bifurcations: the three arms of a bifurcation, its middle, and how often it was seen.
# figures: how well such models did on subjects that were held out.
";
const FORMAT: &str = "willis artery names 3";

impl NamingModel {
    /// The probability that a piece is false, from its features, and in the second pass from the logarithm of what the first one said.
    pub fn is_false(&self, features: &[f64; PIECE_FEATURES], before: Option<f64>) -> f64 {
        let mut x = features.to_vec();
        x.extend(before);
        logistic_probability(&self.false_pieces[usize::from(before.is_some())], &x)
    }

    /// Reads a model.
    ///
    /// # Errors
    ///
    /// Not the TOML of a model; a state that is missing, unknown or no distribution; another number of weights; what is no number.
    pub fn read(text: &str) -> Result<Self, Fault> {
        let file: NamingFile = parse(text, "expected a model as `willis train --model labels` writes it")?;
        let wrong = |what: String, accepted: &str| Fault::item(what, "is wrong", accepted.to_owned());
        let is_format = file.format == FORMAT;
        ensure(is_format, || wrong(format!("format \"{}\"", file.format), &format!("expected \"{FORMAT}\"")))?;
        let lengths = |what: &str, rows: &[Vec<f64>], expected: &dyn Fn(usize) -> usize| {
            let bad = rows.iter().enumerate().find(|(k, row)| row.len() != expected(*k) || row.iter().any(|w| !w.is_finite()));
            bad.map_or(Ok(()), |(k, _)| Err(wrong(format!("{what} {k}"), &format!("expected {} numbers", expected(k)))))
        };
        lengths("false_pieces", &file.false_pieces, &|k| 1 + PIECE_FEATURES + k)?;
        lengths("presence", &file.presence, &|_| 2 + PRESENCE_FEATURES)?;
        let tables = StateTables::default();
        let of = |name: &str| state_of(name).ok_or_else(|| wrong(format!("state \"{name}\""), "expected such as \"L-ICA 0\""));
        let counted = |n: f64, of: String| {
            if (0.0..1e9).contains(&n) { Ok(n) } else { Err(wrong(format!("count of {of}"), "expected a number from 0 on")) }
        };
        let mut pieces: Vec<Option<AtlasPiece>> = vec![None; NOWHERE];
        let mut length = vec![0.0; STATES];
        for row in &file.states {
            let state = of(&row.name)?;
            let too_long = || wrong(format!("length {} of state \"{}\"", row.length, row.name), "expected mm from 0 on");
            ensure((0.0..1e9).contains(&row.length), too_long)?;
            length[state] = row.length;
            length[tables.mirrored[state]] = row.length;
            if state == NOWHERE {
                continue;
            }
            let (mean, covariance, direction, [log_radius, radius_spread]) =
                (row.mean, row.covariance, row.direction, row.log_radius);
            let mut numbers = mean.iter().chain(&covariance).chain(&direction).chain(&row.log_radius);
            let are_positive = is_positive(&covariance) && is_positive(&direction) && radius_spread > 0.0;
            let accepted = "expected positive definite matrices and a positive spread";
            let are_right = numbers.all(|x| x.abs() < 1e9) && are_positive;
            ensure(are_right, || wrong(format!("state \"{}\"", row.name), accepted))?;
            let piece = AtlasPiece { mean, covariance, direction, log_radius, radius_spread };
            pieces[tables.mirrored[state]] = Some(mirrored(&piece));
            pieces[state] = Some(piece);
        }
        if let Some(state) = pieces.iter().position(Option::is_none) {
            let accepted = "expected one row for every state of the left side and the middle";
            return Err(wrong(format!("state \"{}\"", state_name(state, &tables)), accepted));
        }
        let pairs = |rows: &[(String, String, f64)]| -> Result<BTreeMap<StatePair, f64>, Fault> {
            let mut all = BTreeMap::new();
            for (a, b, n) in rows {
                let n = counted(*n, format!("\"{a}\" and \"{b}\""))?;
                all.extend(tables.alike(of(a)?, of(b)?).map(|pair| (pair, n)));
            }
            Ok(all)
        };
        let neighbours = [pairs(&file.within_branches)?, pairs(&file.at_junctions)?];
        let mut bifurcations = Vec::new();
        for (a, b, c, middle, n) in &file.bifurcations {
            let n = counted(*n, format!("a bifurcation at \"{middle}\""))?;
            let (mut arms, middle) = ([of(a)?, of(b)?, of(c)?], of(middle)?);
            arms.sort_unstable();
            bifurcations.extend([((arms, middle), n), (tables.mirrored_bifurcation((arms, middle)), n)]);
        }
        let accepted = "expected a positive spread, and shares between 0 and 1";
        let are_shares = file.share.iter().all(|s| *s > 0.0 && *s < 1.0);
        ensure(file.other_radius[1] > 0.0 && are_shares, || wrong("other_radius or share".into(), accepted))?;
        let are_small = file.other_radius.iter().chain(&file.centroid).all(|x| x.abs() < 1e9);
        ensure(are_small, || wrong("other_radius or centroid".into(), "expected numbers below 1e9"))?;
        let NamingFile { other_radius, centroid, false_pieces, presence, share, provenance, figures, .. } = file;
        let pieces = pieces.into_iter().flatten().collect();
        let atlas = Atlas::new(AtlasData { pieces, other_radius, centroid, length, neighbours, bifurcations });
        Ok(Self { provenance, figures, atlas, false_pieces, presence, share })
    }

    /// Writes the model: of states that have a mirror image only the left one.
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write(&self, out: impl Write) -> io::Result<()> {
        let (AtlasData { pieces, other_radius, centroid, length, .. }, tables) = (&self.atlas.data, &self.atlas.tables);
        let name = |state: AtlasState| state_name(state, tables);
        let pairs = |counts: &BTreeMap<StatePair, f64>| {
            let is_first = |pair: &StatePair| tables.alike(pair.0, pair.1).iter().all(|other| pair <= other);
            counts.iter().filter(|(pair, _)| is_first(pair)).map(|((a, b), n)| (name(*a), name(*b), *n)).collect()
        };
        let mut bifurcations = BTreeMap::new();
        for (own, n) in &self.atlas.data.bifurcations {
            let other = tables.mirrored_bifurcation(*own);
            if *own <= other {
                // A bifurcation that is its own mirror image stands for both.
                *bifurcations.entry(*own).or_insert(0.0) += if *own == other { 0.5 * n } else { *n };
            }
        }
        let bifurcation = |((arms, middle), n): (StatesOfArms, f64)| {
            let [a, b, c] = arms.map(name);
            (a, b, c, name(middle), n)
        };
        let row = |state: AtlasState| {
            let piece = pieces.get(state).copied().unwrap_or_default();
            StateRow {
                name: name(state),
                mean: rounded(piece.mean, 4),
                covariance: rounded(piece.covariance, 5),
                direction: rounded(piece.direction, 6),
                log_radius: rounded([piece.log_radius, piece.radius_spread], 5),
                length: rounded([length.get(state).copied().unwrap_or(0.0)], 2)[0],
            }
        };
        let logistic = |weights: &Logistic| weights.iter().map(|w| rounded([*w], 6)[0]).collect::<Logistic>();
        let [within_branches, at_junctions] = self.atlas.data.neighbours.each_ref().map(pairs);
        let figures = self.figures.iter().map(|of| {
            let shares = [of.length_right, of.length_right_mca, of.presence_right, of.exact];
            let [length_right, length_right_mca, presence_right, exact] = rounded(shares, 4);
            NamingScores { length_right, length_right_mca, presence_right, exact, ..of.clone() }
        });
        let is_listed = |state: &AtlasState| artery_of(tables.label[*state]).and_then(Artery::side) != Some(BodySide::Right);
        let file = NamingFile {
            format: FORMAT.to_owned(),
            other_radius: rounded(*other_radius, 6),
            centroid: rounded(*centroid, 4),
            false_pieces: self.false_pieces.each_ref().map(logistic),
            presence: self.presence.each_ref().map(logistic),
            share: rounded(self.share, 6),
            within_branches,
            at_junctions,
            bifurcations: bifurcations.into_iter().map(bifurcation).collect(),
            provenance: self.provenance.clone(),
            figures: figures.collect(),
            states: (0..STATES).filter(is_listed).map(row).collect(),
        };
        write(out, HEADING, false, &file)
    }
}

/// `L-ICA 0`.
fn state_name(state: AtlasState, tables: &StateTables) -> String {
    format!("{} {}", name_of(tables.label[state]), tables.bin[state])
}

fn state_of(name: &str) -> Option<AtlasState> {
    let (label, bin) = name.rsplit_once(' ')?;
    let (label, bin): (usize, usize) = (label_named(label)?, bin.parse().ok()?);
    (label < LABELS && bin < bins_of(label)).then(|| first_state(label) + bin)
}

/// The piece on the other side; one in the middle is made symmetric by the caller's data.
fn mirrored(piece: &AtlasPiece) -> AtlasPiece {
    let flip = |s: &[f64; 6]| [s[0], s[1], s[2], -s[3], -s[4], s[5]];
    AtlasPiece {
        mean: [-piece.mean[0], piece.mean[1], piece.mean[2]],
        covariance: flip(&piece.covariance),
        direction: flip(&piece.direction),
        ..*piece
    }
}

/// Whether a symmetric matrix is positive definite, by its leading minors.
fn is_positive(s: &[f64; 6]) -> bool {
    let [a, b, _, d, ..] = *s;
    a > 0.0 && a * b > d * d && super::algebra::inverse(s).1.is_finite()
}

/// Numbers as they are with so many digits behind the point.
fn rounded<const N: usize>(values: [f64; N], digits: usize) -> [f64; N] {
    values.map(|x| format!("{x:.digits$}").parse().unwrap_or(x))
}
