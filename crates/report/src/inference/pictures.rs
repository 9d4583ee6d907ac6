//! The pictures of an inference: the run at a glance, the likelihood matrix, the convergence of its entries.

use std::fmt::Write as _;
use std::path::Path;

use super::outcome::Outcome;
use super::questions::Question;
use crate::figures::convergence::{CutLine, convergence};
use crate::figures::figure::Figure;
use crate::figures::heat_map::{LikelihoodMatrix, heat_map};
use crate::figures::summary::{DrawnVessel, MOST_RINGS, Projection, Ring, summary as summary_picture};
use crate::node_blocks::node_blocks;
use crate::page::{PagePicture, scene};
use willis_core::decision::{DecidingFigure, Keep, threshold};
use willis_core::error::Result;
use willis_core::network::units::millimetres;
use willis_core::network::{Frame, Origin};
use willis_core::sampling::{Likelihood, Snapshot};
use willis_core::support::geometry::Point;

/// The largest network that gets the picture of the whole run.
const OVERVIEW_LIMIT: usize = 5_000;

/// The run in one picture, where the vessels have places and are not too many to be seen.
pub fn overview(outcome: &Outcome<'_>, asked: &[Question], name: &str) -> Option<Figure> {
    let (network, answer) = (outcome.network, outcome.answer);
    let scene = scene(network, outcome.boundary).ok().filter(|_| network.vessel_count() <= OVERVIEW_LIMIT)?;
    let drawn = network.vessels().zip(scene.vessels).enumerate().map(|(row, ((_, vessel), course))| DrawnVessel {
        course,
        probability: vessel.evidence().map(|evidence| evidence.probability),
        certain: !outcome.result.uncertain[row],
        kept: answer.kept[row],
    });
    let ring = |number, place: Point| Ring { place: place.map(millimetres), number };
    let rings: Vec<Ring> = if asked.is_empty() {
        answer.undecided.iter().map(|row| ring(None, network.middle_of(network.ends(*row), network.vessel(*row)))).collect()
    } else {
        asked.iter().zip(1..).map(|(one, number)| ring(Some(number), one.at)).collect()
    };
    let of = |origin: Origin| network.vessels().zip(&answer.kept).filter(move |((_, v), _)| v.origin == origin);
    let kept = of(Origin::Candidate).filter(|(_, kept)| **kept).count();
    let mut words = format!("{kept} of {} possible connections kept", of(Origin::Candidate).count());
    if outcome.contacts() > 0 {
        let _ = write!(words, ", {} of {} contacts cut", outcome.cuts().count(), outcome.contacts());
    }
    if let Some(expected) = outcome.expected {
        let _ = write!(words, "; {:.1} expected wrong, {:.1} missed", expected.wrong, expected.missed);
    }
    let ringed = match rings.len() {
        0 => String::new(),
        n if n > MOST_RINGS => format!(" (rings around the first {MOST_RINGS})"),
        _ => " (rings)".to_owned(),
    };
    let open = answer.undecided.len();
    let persons = match asked.len() {
        0 => format!("{open} undecided{ringed}"),
        1 => format!("{open} undecided; 1 question for a person{ringed}"),
        n => format!("{open} undecided; {n} questions for a person, numbered as in the list{ringed}"),
    };
    Some(summary_picture(name, [&words, &persons], drawn.collect(), &rings, &views(outcome)))
}

/// Whether what names call left lies where x is less than at what they call right; false without names of both.
fn left_is_low(outcome: &Outcome<'_>) -> bool {
    let [mut left, mut right] = [(0.0, 0.0); 2];
    let network = outcome.network;
    let labels = network.vessels().enumerate().map(|(row, (_, vessel))| (row, vessel.label.as_str()));
    for (row, name) in labels.chain(outcome.arteries.iter().map(|(row, name)| (*row, name.as_str()))) {
        let side = if name.starts_with("L-") { &mut left } else { &mut right };
        if name.starts_with("L-") || name.starts_with("R-") {
            let x = network.middle_of(network.ends(row), network.vessel(row))[0];
            *side = (side.0 + x, side.1 + 1.0);
        }
    }
    left.1 > 0.0 && right.1 > 0.0 && left.0 / left.1 < right.0 / right.1
}

/// From the front and from the patient's left as radiologists see it, where it is known which way that is.
fn views(outcome: &Outcome<'_>) -> [Projection; 2] {
    let view = |name, right, up, edges| Projection { name, right, up, edges };
    let up = [0.0, 0.0, 1.0];
    match outcome.network.frame {
        Frame::Ras => [view("front", [-1.0, 0.0, 0.0], up, ["R", "L"]), view("left side", [0.0, -1.0, 0.0], up, ["A", "P"])],
        Frame::Lps => [view("front", [1.0, 0.0, 0.0], up, ["R", "L"]), view("left side", [0.0, 1.0, 0.0], up, ["A", "P"])],
        // The patient's left is on the right of the page, where names say which side it is.
        Frame::Unknown if left_is_low(outcome) => {
            [view("along y", [-1.0, 0.0, 0.0], up, ["x", ""]), view("along x", [0.0, 1.0, 0.0], up, ["", "y"])]
        }
        Frame::Unknown => [view("along y", [1.0, 0.0, 0.0], up, ["", "x"]), view("along x", [0.0, 1.0, 0.0], up, ["", "y"])],
    }
}

/// Draws the pictures of the likelihood into a folder and returns them for the page.
///
/// # Errors
///
/// A file that cannot be written.
pub fn pictures(folder: &Path, outcome: &Outcome<'_>, dpi: u32) -> Result<Vec<PagePicture>> {
    let (network, result) = (outcome.network, outcome.result);
    let open = network.vessels().zip(&result.likelihood).zip(&result.uncertain).filter(|((([a, b], _), _), _)| a != b);
    let (entries, uncertain): (Vec<_>, Vec<bool>) =
        open.map(|((([a, b], _), likelihood), uncertain)| ((a as u32, b as u32, *likelihood), *uncertain)).unzip();
    let blocks = node_blocks(network, outcome.boundary);
    let matrix = LikelihoodMatrix { nodes: network.node_count(), entries: &entries, uncertain: &uncertain, blocks: &blocks };
    let matrix = heat_map(&matrix, outcome.sampling.weight);
    let says = "The likelihood over all pairs of nodes on a logarithmic scale of colour; light grey is zero. The nodes are in order of the \
                inlet that feeds them along observed vessels, or of their fragment. A second matrix has the uncertain vessels alone.";
    let matrix = PagePicture::write("Likelihood matrix", says, &matrix, folder, dpi)?;

    let samples: Vec<u64> = result.trace.iter().map(|s| s.samples).collect();
    let uncertain: Vec<usize> = (0..result.uncertain.len()).filter(|row| result.uncertain[*row]).collect();
    let mean = |at: usize| result.trace.iter().map(|s| s.likelihood[at] / s.samples as f64).collect();
    let series: Vec<Vec<f64>> = (0..uncertain.len()).map(mean).collect();
    let of_likelihood = outcome.rule.figure() == DecidingFigure::Likelihood;
    let (cut, rule) = if of_likelihood { (CutLine::Threshold, outcome.rule) } else { (CutLine::Median, Keep::Median) };
    let cuts: Vec<f64> = result.trace.iter().map(|s| running_threshold(rule, result.samples, &uncertain, s)).collect();
    let kept: Vec<bool> = uncertain.iter().map(|row| outcome.answer.kept[*row]).collect();
    let traces = convergence(&samples, &series, (cut, &cuts), &kept, outcome.sampling.weight);
    let says = match cut {
        _ if cuts.iter().all(|cut| cut.is_nan()) => {
            "The mean contribution per sample of every uncertain vessel against the number of samples; \
             lines that are still moving at the right end call for more samples."
        }
        CutLine::Threshold => {
            "The mean contribution per sample of every uncertain vessel against the number of samples, and the threshold; \
             lines that are still moving at the right end call for more samples."
        }
        CutLine::Median => {
            "The mean contribution per sample of every uncertain vessel against the number of samples, and their median, above which \
             lies topology-median; lines that are still moving at the right end call for more samples."
        }
    };
    Ok(vec![matrix, PagePicture::write("Convergence", says, &traces, folder, dpi)?])
}

/// The threshold of a rule on L/n that the samples so far would give; NaN where there is none. `samples`: of the whole run.
fn running_threshold(rule: Keep, samples: u64, uncertain: &[usize], snapshot: &Snapshot) -> f64 {
    if let Keep::Value(x) = rule {
        return x / samples as f64;
    }
    let so_far = Likelihood {
        likelihood: snapshot.likelihood.clone(),
        std_error: vec![0.0; uncertain.len()],
        frequency: vec![0.0; uncertain.len()],
        uncertain: vec![true; uncertain.len()],
        network_resilience: 0.0,
        perfused: 1.0,
        residual: 0.0,
        samples: 1,
        trace: Vec::new(),
    };
    threshold(rule, &so_far).map_or(f64::NAN, |cut| cut / snapshot.samples as f64)
}
