//! What a person is asked about an inference, what a right answer puts right most first.

use std::collections::BTreeSet;

use super::outcome::Outcome;
use super::tables::positions;
use willis_core::flow::floating_components::parts_that_carry;
use willis_core::network::units::millimetres;
use willis_core::network::{Origin, dependents, fragments, if_parted, weakest_of_loops};
use willis_core::support::geometry::Point;
use willis_io::formats::Column;

/// A part without flow is asked about from this length on, and what is kept of masks if it is expected to be wrong about more than this, m.
pub const WORTH: f64 = 0.01;

/// The kind of a question about a part that nothing connects.
pub const PART: &str = "part";
/// That of one about a loop.
pub const LOOP: &str = "loop";
/// That of one about a place where one line may show two vessels.
pub const TOUCH: &str = "touch";

/// One question.
pub struct Question {
    /// The row that it is about.
    pub row: usize,
    /// The origin of that, `part`, `loop` or `touch`.
    pub kind: &'static str,
    /// Where it is.
    pub at: Point,
    words: String,
    /// The probability of the row, or that it is one vessel there.
    probability: f64,
    /// The length that hangs on it, m.
    pub hangs: f64,
    /// What a right answer is expected to put right, m.
    pub gain: f64,
}

/// The columns of review.csv; `None` where nothing is asked.
pub fn review_columns(outcome: &Outcome<'_>, asked: &[Question]) -> Option<Vec<Column>> {
    let kept = &outcome.answer.kept;
    let mut columns = vec![
        Column::whole("rank", 1..=asked.len()),
        Column::whole("edge", asked.iter().map(|one| one.row)),
        Column::text("kind", asked.iter().map(|one| one.kind.to_owned())),
    ];
    columns.extend(positions(|| asked.iter().map(|one| one.at)));
    columns.extend([
        Column::text("question", asked.iter().map(|one| one.words.clone())),
        Column::real("probability", asked.iter().map(|one| one.probability)),
        Column::whole("kept", asked.iter().map(|one| usize::from(kept[one.row]))),
        Column::real("hangs_mm", asked.iter().map(|one| millimetres(one.hangs))),
        Column::real("gain_mm", asked.iter().map(|one| millimetres(one.gain))),
    ]);
    (!asked.is_empty()).then_some(columns)
}

/// What a person is asked: about the undecided vessels, the parts that nothing connects, and of masks what is kept and probably wrong about much. Nothing
/// where no probabilities say how doubtful they are.
///
/// The gain is what a right answer is expected to put right: the chance that the decision is wrong times the length that hangs on it and its own; of a
/// part without flow its length.
pub fn questions(outcome: &Outcome<'_>) -> Vec<Question> {
    if !outcome.rule.asks_evidence() {
        return Vec::new();
    }
    let (network, answer) = (outcome.network, outcome.answer);
    let hangs = dependents(network, &answer.kept);
    let wrong = |row: usize| {
        network.vessel(row).evidence().map_or(0.0, |e| if answer.kept[row] { 1.0 - e.probability } else { e.probability })
    };
    let one_by_one = outcome.rule.is_one_by_one();
    let costs =
        |row: &usize| one_by_one && answer.kept[*row] && outcome.result.uncertain[*row] && wrong(*row) * hangs[*row] > WORTH;
    let mut asked = loose_parts(outcome);
    if one_by_one {
        asked.extend(loops(outcome).filter(|one| one.gain > WORTH));
        let taken = asked.iter().map(|one| one.row).collect();
        asked.extend(touches(outcome, taken));
    }
    let mut rows: BTreeSet<usize> = answer.undecided.iter().copied().chain((0..network.vessel_count()).filter(costs)).collect();
    for one in &asked {
        rows.remove(&one.row);
    }
    asked.extend(rows.into_iter().map(|row| {
        let [a, b] = network.ends(row).map(|node| &*network.node(node).id);
        let vessel = network.vessel(row);
        let words = match vessel.origin {
            Origin::Candidate => format!("Does a vessel go on from {a} to {b}?"),
            _ => format!("Are {a} and {b} of one vessel, or do two only touch here?"),
        };
        let (kind, at) = (vessel.origin.name(), network.middle_of(network.ends(row), vessel));
        let (probability, hangs) = (probability(outcome, row), hangs[row]);
        Question { row, kind, at, words, probability, hangs, gain: wrong(row) * (hangs + vessel.length) }
    }));
    asked.sort_by(|a, b| b.gain.total_cmp(&a.gain).then(a.row.cmp(&b.row)));
    asked
}

/// About each loop of kept vessels, by its least probable connection: is it there that two vessels only touch?
fn loops(outcome: &Outcome<'_>) -> impl Iterator<Item = Question> {
    let network = outcome.network;
    weakest_of_loops(network, &outcome.answer.kept).into_iter().map(|(row, round)| {
        let (ends, vessel) = (network.ends(row), network.vessel(row));
        let [a, b] = ends.map(|node| &*network.node(node).id);
        let words = format!("These vessels make a loop of {:.0} mm: do two only touch between {a} and {b}?", millimetres(round));
        let wrong = vessel.evidence().map_or(0.0, |e| 1.0 - e.probability);
        let (at, gain) = (network.middle_of(ends, vessel), wrong * (round + vessel.length));
        Question { row, kind: LOOP, at, words, probability: 1.0 - wrong, hangs: round, gain }
    })
}

fn probability(outcome: &Outcome<'_>, row: usize) -> f64 {
    outcome.network.vessel(row).evidence().map_or(f64::NAN, |evidence| evidence.probability)
}

/// About each place that was left as it is where one line may show two vessels, by a vessel there that is at no other and stands for nothing else.
fn touches(outcome: &Outcome<'_>, mut taken: BTreeSet<usize>) -> Vec<Question> {
    let (network, kept) = (outcome.network, &outcome.answer.kept);
    let mut found = Vec::new();
    let mut places = vec![0; network.vessel_count()];
    let left = || outcome.pairings.iter().filter(|pairings| pairings.contacts.is_empty());
    left().flat_map(|pairings| &pairings.vessels).for_each(|row| places[*row] += 1);
    for pairings in left() {
        let Some((chance, ends)) = pairings.doubt(network) else { continue };
        let hangs = if_parted(network, kept, &ends);
        let row = ends.iter().map(|(row, ..)| *row).find(|row| kept[*row] && places[*row] == 1 && !taken.contains(row));
        if let Some(row) = row.filter(|_| chance * hangs > WORTH) {
            taken.insert(row);
            let words = format!("{} vessels meet: do some only touch here?", ends.len());
            let (at, probability, gain) = (pairings.position, 1.0 - chance, chance * hangs);
            found.push(Question { row, kind: TOUCH, at, words, probability, hangs, gain });
        }
    }
    found
}

/// The parts of the kept graph that no blood flows through: where does each go on? The most probable candidate that leads out of a part stands for it,
/// or where there is none the observed vessel with its widest free end.
fn loose_parts(outcome: &Outcome<'_>) -> Vec<Question> {
    let (network, answer) = (outcome.network, outcome.answer);
    let parts = fragments(network, |row, _| answer.kept[row]);
    let carries = parts_that_carry(&parts, &outcome.held());
    let degree = network.degrees(|vessel| vessel.origin == Origin::Observed);
    let mut length = vec![0.0; parts.count];
    // By part the probability of the candidate, or less than nothing, its width, its row and the node.
    let mut best: Vec<Option<(f64, f64, usize, usize)>> = vec![None; parts.count];
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        let of = ends.map(|node| parts.of_node[node]);
        let chance = match (vessel.origin, vessel.evidence()) {
            (Origin::Observed, _) => -1.0,
            (_, Some(evidence)) if !answer.kept[row] && of[0] != of[1] && evidence.probability > 0.0 => evidence.probability,
            _ => continue,
        };
        if answer.kept[row] {
            length[of[0]] += vessel.length;
        }
        for (end, node) in ends.into_iter().enumerate().filter(|(_, node)| chance >= 0.0 || degree[*node] == 1) {
            let one = (chance, vessel.end_radius(end == 1), row, node);
            if best[of[end]].is_none_or(|most| (one.0, one.1) > (most.0, most.1)) {
                best[of[end]] = Some(one);
            }
        }
    }
    let question = |part: usize| {
        let (_, _, row, node) = best[part]?;
        let id = &network.node(node).id;
        let mm = millimetres(length[part]);
        let words = format!("Nothing connects {mm:.0} mm of vessels: where do they go on, from {id} or another end?");
        let at = network.node(node).position.unwrap_or_default();
        let probability = probability(outcome, row);
        Some(Question { row, kind: PART, at, words, probability, hangs: length[part], gain: length[part] })
    };
    (0..parts.count).filter(|part| !carries[*part] && length[*part] >= WORTH).filter_map(question).collect()
}
