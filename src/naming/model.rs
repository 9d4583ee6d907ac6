//! A model that names arteries: the atlas, which pieces are false, which segments are there; and its file.

use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use super::atlas::{Atlas, AtlasData, Counts, Piece};
use super::pieces::PIECE_FEATURES;
use super::presence::{KINDS, PRESENCE_FEATURES};
use super::states::{LABELS, NOWHERE, STATES, State, StateTables, bins_of, first_state, label_of, name_of, side_of};
use crate::circle_of_willis::Side;
use crate::error::{Fault, Result};
use crate::support::statistics::sigmoid;
use crate::support::tree_provenance::TreeProvenance;

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
    /// The share of the segments of the ring whose presence is right, by names alone and with plausible topologies ...
    pub presence_right: [f64; 2],
    /// ... and of the cases with all of them right.
    pub exact: [f64; 2],
}

/// A logistic regression: the constant, then the slopes.
pub type Logistic = Vec<f64>;

/// A model that names arteries.
#[derive(Debug, Clone)]
pub struct NamingModel {
    /// Where it comes from.
    pub provenance: TreeProvenance<NamingScores>,
    /// The atlas.
    pub atlas: Atlas,
    /// Per pass, whether a piece is false. The second pass has the logarithm of what the first one said as its last feature.
    pub false_pieces: [Logistic; 2],
    /// Per kind of segment, whether it is there.
    pub presence: [Logistic; KINDS],
    /// The same with the log odds of the plausible topologies as one more feature, the last.
    pub presence_with_topology: [Logistic; KINDS],
    /// Per kind of segment the share of the cases that have it.
    pub share: [f64; KINDS],
}

/// The place of the log odds of the plausible topologies among the weights of `presence_with_topology`.
pub const TOPOLOGY_FEATURE: usize = 1 + PRESENCE_FEATURES;

/// P = 1/(1 + e^-z) of a logistic regression.
pub fn logistic_probability(weights: &[f64], features: &[f64]) -> f64 {
    sigmoid(weights[0] + weights[1..].iter().zip(features).map(|(w, x)| w * x).sum::<f64>())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    #[serde(default)]
    provenance: TreeProvenance<NamingScores>,
    #[serde(default)]
    figures: Vec<NamingScores>,
    other_radius: [f64; 2],
    centroid: [f64; 3],
    false_pieces: [Vec<f64>; 2],
    presence: [Vec<f64>; KINDS],
    presence_with_topology: [Vec<f64>; KINDS],
    share: [f64; KINDS],
    states: Vec<StateRow>,
    within_branches: Vec<(String, String, f64)>,
    at_junctions: Vec<(String, String, f64)>,
    bifurcations: Vec<(String, String, String, String, f64)>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StateRow {
    name: String,
    mean: [f64; 3],
    covariance: [f64; 6],
    direction: [f64; 6],
    log_radius: [f64; 2],
    length: f64,
}

impl StateRow {
    /// Whether its numbers are those of distributions.
    fn is_distribution(&self) -> bool {
        let mut numbers = self.mean.iter().chain(&self.covariance).chain(&self.direction).chain(&self.log_radius);
        numbers.all(|x| x.abs() < 1e9)
            && is_positive(&self.covariance)
            && is_positive(&self.direction)
            && self.log_radius[1] > 0.0
    }
}

const FORMAT: &str = "willis artery names 2";
const ACCEPTED: &str = "expected a model as `willis train --model labels` writes it";

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
    /// Not the TOML of a model; a state that is missing, unknown or no distribution; another number of weights.
    pub fn read(text: &str) -> Result<Self, Fault> {
        let file: File = toml::from_str(text).map_err(|e| {
            let line = e.span().map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count());
            Fault::line(line, e.message().to_owned(), ACCEPTED)
        })?;
        let wrong = |what: String, accepted: &str| Fault::item(what, "is wrong", accepted.to_owned());
        if file.format != FORMAT {
            return Err(wrong(format!("format \"{}\"", file.format), &format!("expected \"{FORMAT}\"")));
        }
        let lengths = |what: &str, rows: &[Vec<f64>], expected: &dyn Fn(usize) -> usize| {
            let bad = rows.iter().enumerate().find(|(k, row)| row.len() != expected(*k) || row.iter().any(|w| !w.is_finite()));
            bad.map_or(Ok(()), |(k, _)| Err(wrong(format!("{what} {k}"), &format!("expected {} numbers", expected(k)))))
        };
        lengths("false_pieces", &file.false_pieces, &|k| 1 + PIECE_FEATURES + k)?;
        lengths("presence", &file.presence, &|_| 1 + PRESENCE_FEATURES)?;
        lengths("presence_with_topology", &file.presence_with_topology, &|_| 2 + PRESENCE_FEATURES)?;
        let tables = StateTables::new();
        let mut pieces: Vec<Option<Piece>> = vec![None; NOWHERE];
        let mut length = vec![0.0; STATES];
        for row in &file.states {
            let state =
                state_of(&row.name).ok_or_else(|| wrong(format!("state \"{}\"", row.name), "expected such as \"L-ICA 0\""))?;
            length[state] = row.length;
            length[tables.mirrored[state]] = row.length;
            if state == NOWHERE {
                continue;
            }
            let piece = Piece {
                mean: row.mean,
                covariance: row.covariance,
                direction: row.direction,
                log_radius: row.log_radius[0],
                radius_spread: row.log_radius[1],
            };
            if !row.is_distribution() {
                let accepted = "expected positive definite matrices and a positive spread";
                return Err(wrong(format!("state \"{}\"", row.name), accepted));
            }
            pieces[tables.mirrored[state]] = Some(mirrored(&piece));
            pieces[state] = Some(piece);
        }
        let missing = pieces.iter().position(Option::is_none);
        if let Some(state) = missing {
            return Err(wrong(
                format!("state \"{}\"", state_name(state, &tables)),
                "expected one row for every state of the left side and the middle",
            ));
        }
        let of = |name: &str| state_of(name).ok_or_else(|| wrong(format!("state \"{name}\""), "expected such as \"L-ICA 0\""));
        let pairs = |rows: &[(String, String, f64)]| -> Result<Vec<(State, State, f64)>, Fault> {
            let mut all = std::collections::BTreeMap::new();
            for (a, b, n) in rows {
                if !(*n >= 0.0 && *n < 1e9) {
                    return Err(wrong(format!("count of \"{a}\" and \"{b}\""), "expected a number from 0 on"));
                }
                let (a, b) = (of(a)?, of(b)?);
                let (ma, mb) = (tables.mirrored[a], tables.mirrored[b]);
                for pair in [(a, b), (b, a), (ma, mb), (mb, ma)] {
                    all.insert(pair, *n);
                }
            }
            Ok(all.into_iter().map(|((a, b), n)| (a, b, n)).collect())
        };
        let neighbours = [pairs(&file.within_branches)?, pairs(&file.at_junctions)?];
        let mut bifurcations = Vec::new();
        for (a, b, c, middle, n) in &file.bifurcations {
            if !(*n >= 0.0 && *n < 1e9) {
                return Err(wrong(format!("count of a bifurcation at \"{middle}\""), "expected a number from 0 on"));
            }
            let (mut arms, middle) = ([of(a)?, of(b)?, of(c)?], of(middle)?);
            arms.sort_unstable();
            bifurcations.push((arms, middle, *n));
            let mut arms = arms.map(|s| tables.mirrored[s]);
            arms.sort_unstable();
            bifurcations.push((arms, tables.mirrored[middle], *n));
        }
        if !(file.other_radius[1] > 0.0 && file.share.iter().all(|s| *s > 0.0 && *s < 1.0)) {
            return Err(wrong("other_radius or share".into(), "expected a positive spread, and shares between 0 and 1"));
        }
        let data = AtlasData {
            pieces: pieces.into_iter().flatten().collect(),
            other_radius: file.other_radius,
            centroid: file.centroid,
            counts: Counts { length, neighbours, bifurcations },
        };
        let mut provenance = file.provenance;
        provenance.figures = file.figures;
        Ok(Self {
            provenance,
            atlas: Atlas::new(data),
            false_pieces: file.false_pieces,
            presence: file.presence,
            presence_with_topology: file.presence_with_topology,
            share: file.share,
        })
    }

    /// Writes the model: of states that have a mirror image only the left one.
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write(&self, mut out: &mut dyn Write) -> io::Result<()> {
        let (data, tables) = (&self.atlas.data, &self.atlas.tables);
        let name = |state: State| state_name(state, tables);
        writeln!(
            out,
            "# Names of the arteries of the Circle of Willis: lengths in mm, positions in RAS about the middle of the carotid bifurcations."
        )?;
        writeln!(out, "format = \"{FORMAT}\"")?;
        writeln!(out, "other_radius = {}", numbers(&data.other_radius, 6))?;
        writeln!(out, "centroid = {}", numbers(&data.centroid, 4))?;
        writeln!(
            out,
            "# Whether a piece is false: a constant and the weights of its features, for the first and the second pass."
        )?;
        writeln!(out, "false_pieces = [{}]", self.false_pieces.iter().map(|w| numbers(w, 6)).collect::<Vec<_>>().join(", "))?;
        writeln!(out, "# Whether an A1, AComm, PComm, P1 is there.")?;
        writeln!(out, "presence = [{}]", self.presence.iter().map(|w| numbers(w, 6)).collect::<Vec<_>>().join(", "))?;
        writeln!(out, "# The same, with the log odds of the plausible topologies as the last feature.")?;
        let with: Vec<String> = self.presence_with_topology.iter().map(|w| numbers(w, 6)).collect();
        writeln!(out, "presence_with_topology = [{}]", with.join(", "))?;
        writeln!(out, "share = {}", numbers(&self.share, 6))?;
        let (counts, half) = (&data.counts, |state: State| side_of(tables.label[state]) != Some(Side::Right));
        writeln!(out, "# Neighbours within a branch, and those of which one is a junction: how often they were seen.")?;
        for (key, list) in ["within_branches", "at_junctions"].iter().zip(&counts.neighbours) {
            writeln!(out, "{key} = [")?;
            for (a, b, n) in list {
                let (ma, mb) = (tables.mirrored[*a], tables.mirrored[*b]);
                if [(*b, *a), (ma, mb), (mb, ma)].iter().all(|other| (*a, *b) <= *other) {
                    writeln!(out, "    [\"{}\", \"{}\", {}],", name(*a), name(*b), *n)?;
                }
            }
            writeln!(out, "]")?;
        }
        writeln!(out, "# The three arms of a bifurcation, its middle, and how often it was seen.\nbifurcations = [")?;
        for (arms, middle, n) in &counts.bifurcations {
            let mut other = arms.map(|s| tables.mirrored[s]);
            other.sort_unstable();
            let other = (other, tables.mirrored[*middle]);
            if (*arms, *middle) <= other {
                let [a, b, c] = arms.map(name);
                // A bifurcation that is its own mirror image stands for both.
                let n = if (*arms, *middle) == other { 0.5 * n } else { *n };
                writeln!(out, "    [\"{a}\", \"{b}\", \"{c}\", \"{}\", {n}],", name(*middle))?;
            }
        }
        writeln!(out, "]")?;
        self.provenance.write(&mut out, "# How well such models did on subjects that were held out.", |of, out| {
            writeln!(out, "of = \"{}\"\ncases = {}", of.of, of.cases)?;
            writeln!(out, "length_right = {:.4}\nlength_right_mca = {:.4}", of.length_right, of.length_right_mca)?;
            writeln!(out, "presence_right = {}\nexact = {}", numbers(&of.presence_right, 4), numbers(&of.exact, 4))
        })?;
        for state in (0..STATES).filter(|state| half(*state)) {
            let (mean, covariance, direction, log_radius) = match data.pieces.get(state) {
                Some(p) => (p.mean, p.covariance, p.direction, [p.log_radius, p.radius_spread]),
                None => ([0.0; 3], [0.0; 6], [0.0; 6], [0.0; 2]),
            };
            writeln!(out, "\n[[states]]\nname = \"{}\"\nmean = {}", name(state), numbers(&mean, 4))?;
            writeln!(out, "covariance = {}\ndirection = {}", numbers(&covariance, 5), numbers(&direction, 6))?;
            writeln!(out, "log_radius = {}\nlength = {:.2}", numbers(&log_radius, 5), counts.length.get(state).unwrap_or(&0.0))?;
        }
        Ok(())
    }
}

/// `L-ICA 0`.
fn state_name(state: State, tables: &StateTables) -> String {
    format!("{} {}", name_of(tables.label[state]), tables.bin[state])
}

fn state_of(name: &str) -> Option<State> {
    let (label, bin) = name.rsplit_once(' ')?;
    let (label, bin): (usize, usize) = (label_of(label)?, bin.parse().ok()?);
    (label < LABELS && bin < bins_of(label)).then(|| first_state(label) + bin)
}

/// The piece on the other side; one in the middle is made symmetric by the caller's data.
fn mirrored(piece: &Piece) -> Piece {
    let flip = |s: &[f64; 6]| [s[0], s[1], s[2], -s[3], -s[4], s[5]];
    Piece {
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

fn numbers(values: &[f64], digits: usize) -> String {
    let each: Vec<String> = values
        .iter()
        .map(|x| {
            let text = format!("{x:.digits$}");
            let short = text.trim_end_matches('0');
            if short.ends_with('.') { format!("{short}0") } else { short.to_owned() }
        })
        .collect();
    format!("[{}]", each.join(", "))
}
