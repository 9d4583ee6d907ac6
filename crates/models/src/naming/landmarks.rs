//! Where named arteries meet and end: the landmarks that a person would click.

use std::collections::BTreeMap;

use super::atlas::Atlas;
use super::emission::Pose;
use super::nodes::Nodes;
use super::states::{ArteryLabel, BA, LABELS, OTHER, STATES, artery_of, as_one_with_m1, bins_of, first_state, label_of, name_of};
use crate::circle_of_willis::{Artery, BodySide, FEEDERS};
use willis_core::support::geometry::{Point, distance, lerp};

/// Nodes of two arteries that meet are no further apart, mm.
const LIMIT: f64 = 12.0;

/// A place that has a name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPlace {
    /// `L-ICA/L-M1/L-A1` for a bifurcation, `L-ICA` for where an artery enters or leaves.
    pub label: String,
    /// Its position in mm, RAS.
    pub at: Point,
    /// How probable the names on which it rests are.
    pub probability: f64,
}

/// A bifurcation: two groups of labels that meet there, and the state of the atlas that lies there.
pub struct Meeting {
    /// Its name.
    pub label: String,
    /// The labels on the one side, and those on the other.
    pub between: [Vec<ArteryLabel>; 2],
    /// The label at whose reference end it lies.
    pub at: ArteryLabel,
}

/// Every bifurcation that has a name.
pub fn meetings() -> Vec<Meeting> {
    let mut all = Vec::new();
    for side in BodySide::BOTH {
        let mut add = |labels: &[ArteryLabel], one: &[ArteryLabel], other: &[ArteryLabel], at: ArteryLabel| {
            let label = labels.iter().map(|l| name_of(*l)).collect::<Vec<_>>().join("/");
            all.push(Meeting { label, between: [one.to_vec(), other.to_vec()], at });
        };
        let [ica, m1, m2, a1, a2, p1, p2, pcomm] =
            [Artery::Ica, Artery::M1, Artery::M2, Artery::A1, Artery::A2, Artery::P1, Artery::P2, Artery::PComm]
                .map(|artery| label_of(artery(side)));
        add(&[ica, m1, a1], &[ica], &[m1, a1], ica);
        add(&[a1, a2, label_of(Artery::AComm)], &[a1], &[a2], a2);
        add(&[m1, m2], &[m1], &[m2], m2);
        add(&[ica, pcomm], &[ica], &[pcomm], pcomm);
        add(&[p1, p2, pcomm], &[pcomm], &[p1, p2], p2);
        add(&[p1, p2], &[p1], &[p2], p2);
    }
    let p1 = BodySide::BOTH.map(|side| label_of(Artery::P1(side)));
    all.push(Meeting { label: format!("BA/{}/{}", name_of(p1[0]), name_of(p1[1])), between: [vec![BA], p1.to_vec()], at: BA });
    all
}

/// The middle of the closest pair of nodes of two groups of labels, with the smaller of their probabilities; `None` where they do not
/// meet. `best` is the label of each node.
pub fn meeting_place(
    nodes: &Nodes,
    labels: &[[f64; LABELS]],
    best: &[ArteryLabel],
    between: &[Vec<ArteryLabel>; 2],
) -> Option<(Point, f64)> {
    let of = |group: &[ArteryLabel]| -> Vec<usize> { (0..nodes.len()).filter(|n| group.contains(&best[*n])).collect() };
    let [one, other] = [of(&between[0]), of(&between[1])];
    let pairs = one.iter().flat_map(|a| other.iter().map(|b| (distance(nodes.at[*a], nodes.at[*b]), *a, *b)));
    let (d, a, b) = pairs.reduce(|closest, next| if next.0 < closest.0 { next } else { closest })?;
    let sure = |n: usize, group: &[ArteryLabel]| group.iter().map(|label| labels[n][*label]).sum::<f64>();
    (d <= LIMIT).then(|| (lerp(nodes.at[a], nodes.at[b], 0.5), sure(a, &between[0]).min(sure(b, &between[1]))))
}

/// How far (mm) the place that the atlas expects may be from a vessel that is there.
const EXPECTED_WITHIN: f64 = 12.0;
/// The probability of a place of which only one side is seen.
const ONE_SIDED: f64 = 0.25;

/// Where a bifurcation lies of which only one artery is seen: on that artery, nearest to where the atlas has it. `None` where neither is seen,
/// or where the posterior communicating artery that makes it is not.
pub fn expected_place(
    nodes: &Nodes,
    best: &[ArteryLabel],
    atlas: &Atlas,
    pose: &Pose,
    meeting: &Meeting,
) -> Option<(Point, f64)> {
    let has = |label: ArteryLabel| best.contains(&label);
    let labels = || meeting.between.iter().flatten().copied();
    if labels().find(|label| matches!(artery_of(*label), Some(Artery::PComm(_)))).is_some_and(|pcomm| !has(pcomm)) {
        return None;
    }
    let expected = pose.undo(atlas.data.pieces[first_state(meeting.at)].mean);
    let near = (0..nodes.len()).filter(|n| labels().any(|label| label == best[*n])).map(|n| (distance(nodes.at[n], expected), n));
    let (away, n) = near.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (away <= EXPECTED_WITHIN).then(|| (nodes.at[n], ONE_SIDED))
}

/// Where PComm ends at P1 and P2, that is where they meet too.
pub fn drop_doubles(places: &mut Vec<NamedPlace>) {
    for side in BodySide::BOTH {
        let short = format!("{}/{}", Artery::P1(side), Artery::P2(side));
        let long = format!("{short}/{}", Artery::PComm(side));
        if places.iter().any(|place| place.label == long) {
            places.retain(|place| place.label != short);
        }
    }
}

/// The ends of arteries that enter or leave the circle: of every label its free end that is farthest along it.
pub fn ends(nodes: &Nodes, labels: &[[f64; LABELS]], states: &[f64], atlas: &Atlas, best: &[ArteryLabel]) -> Vec<NamedPlace> {
    let mut found: BTreeMap<ArteryLabel, (f64, usize)> = BTreeMap::new();
    for n in (0..nodes.len()).filter(|n| nodes.degree(*n) <= 1 && best[*n] != OTHER) {
        let of_states = &states[n * atlas.tables.label.len()..(n + 1) * atlas.tables.label.len()];
        let label = best[n];
        let (mut along, mut sum) = (0.0, 1e-9);
        for (state, p) in of_states.iter().enumerate().filter(|(state, _)| atlas.tables.label[*state] == label) {
            along += p * atlas.tables.bin[state] as f64;
            sum += p;
        }
        let key = along / sum;
        if found.get(&label).is_none_or(|(known, _)| key > *known) {
            found.insert(label, (key, n));
        }
    }
    // An artery that goes on under another name ends there.
    let leaves = |of: ArteryLabel| match artery_of(of) {
        Some(Artery::Ba | Artery::Ica(_) | Artery::M2(_) | Artery::A2(_) | Artery::P2(_)) => true,
        Some(Artery::M1(side)) => !found.contains_key(&label_of(Artery::M2(side))),
        _ => false,
    };
    let kept = found.iter().filter(|(label, _)| leaves(**label));
    let mut places: Vec<NamedPlace> = kept
        .map(|(of, (_, n))| NamedPlace { label: name_of(as_one_with_m1(*of)), at: nodes.at[*n], probability: labels[*n][*of] })
        .collect();
    if let Some(vertebral) = vertebral_ends(nodes, labels, states, best) {
        places.retain(|place| place.label != name_of(BA));
        places.extend(vertebral);
    }
    places
}

/// The free end that is likeliest of an artery by which blood enters; `None` without a free end.
pub fn likeliest_inlet(nodes: &Nodes, labels: &[[f64; LABELS]]) -> Option<NamedPlace> {
    let ends = (0..nodes.len()).filter(|n| nodes.degree(*n) <= 1);
    let each = ends.flat_map(|n| {
        FEEDERS.map(|artery| NamedPlace { label: artery.to_string(), at: nodes.at[n], probability: labels[n][label_of(artery)] })
    });
    each.max_by(|a, b| a.probability.total_cmp(&b.probability))
}

/// Ends of the basilar artery further apart than this (mm) from left to right are those of the vertebral arteries, which the states of the
/// basilar artery hold.
const VERTEBRAL: f64 = 15.0;

/// Where the vertebral arteries enter: of the free ends that lie as far along the basilar artery as its states go, the lowest on the left
/// and on the right of their middle.
fn vertebral_ends(nodes: &Nodes, labels: &[[f64; LABELS]], states: &[f64], best: &[ArteryLabel]) -> Option<[NamedPlace; 2]> {
    let last = first_state(BA) + bins_of(BA) - 1;
    let is_end = |n: &usize| best[*n] == BA && nodes.degree(*n) <= 1 && states[n * STATES + last] > 0.5;
    let ends: Vec<usize> = (0..nodes.len()).filter(is_end).collect();
    let across = |n: usize| nodes.at[n][0];
    let (least, most) = ends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), n| (a.min(across(*n)), b.max(across(*n))));
    let lowest = |side: BodySide| {
        let own = ends.iter().filter(|n| (2.0 * across(**n) < least + most) == (side == BodySide::Left));
        own.min_by(|a, b| nodes.at[**a][2].total_cmp(&nodes.at[**b][2]))
    };
    let (left, right) = (lowest(BodySide::Left)?, lowest(BodySide::Right)?);
    let place = |label: &str, n: usize| NamedPlace { label: label.to_owned(), at: nodes.at[n], probability: labels[n][BA] };
    (most - least > VERTEBRAL).then(|| [place("L-VA", *left), place("R-VA", *right)])
}
