//! The probability that a fragment's tree is rooted in one of some fragments.

use super::Forests;
use super::marginals::Scaled;
use crate::support::elimination::Star;
use crate::support::numbered::placed;

/// A fragment at its turn, by places in the order.
struct Turn {
    fragment: usize,
    /// The neighbours at its elimination, in order.
    to: Vec<usize>,
    /// Odds of stepping to each, and from each to here.
    out: Vec<f64>,
    into: Vec<f64>,
    /// Odds of dying here or in what was eliminated: with a mark, and without.
    death: [f64; 2],
}

/// Per fragment the probability that the root of its tree is `marked`, shape (fragments): Σ G_cr v_r over the marked r, the
/// probability that the walk from c dies in one of them.
///
/// Eliminated without a subtraction, as the marginals are, so each is right in its own digits.
///
/// # Panics
///
/// When there is not one mark per fragment.
pub fn rooted_in(forests: &Forests, marked: &[bool]) -> Vec<f64> {
    assert_eq!(marked.len(), forests.fragments(), "one mark per fragment");
    let scaled = Scaled::new(forests);
    let stars = scaled.stars(forests);
    let place = placed(stars.len(), stars.iter().map(|star| star.center));
    let turn = |star: &Star| {
        let mut to: Vec<usize> = star.neighbours.iter().map(|node| place[*node]).collect();
        to.sort_unstable();
        let (root, rays) = (scaled.root[star.center], to.len());
        let death = if marked[star.center] { [root, 0.0] } else { [0.0, root] };
        Turn { fragment: star.center, to, out: vec![0.0; rays], into: vec![0.0; rays], death }
    };
    let mut turns: Vec<Turn> = stars.iter().map(turn).collect();
    for (_, edge, odds) in scaled.possible(forests) {
        let [child, parent] = [edge.child, edge.parent].map(|fragment| place[fragment]);
        let turn = &mut turns[child.min(parent)];
        let ray = turn.to.partition_point(|to| *to < child.max(parent));
        *(if child < parent { &mut turn.out[ray] } else { &mut turn.into[ray] }) += odds;
    }
    for at in 0..turns.len() {
        eliminate(&mut turns, at);
    }
    let mut rooted = vec![0.0; turns.len()];
    for turn in turns.iter().rev() {
        let later = turn.to.iter().zip(&turn.out).map(|(to, odds)| odds * rooted[turns[*to].fragment]);
        rooted[turn.fragment] = (turn.death[0] + later.sum::<f64>()).min(1.0);
    }
    rooted
}

/// Makes the odds of a fragment probabilities, and of each step to it the steps that lead on.
fn eliminate(turns: &mut [Turn], at: usize) {
    let (done, later) = turns.split_at_mut(at + 1);
    let turn = &mut done[at];
    let sum = turn.death.iter().sum::<f64>() + turn.out.iter().sum::<f64>();
    turn.out.iter_mut().chain(&mut turn.death).for_each(|odds| *odds /= sum);
    for (i, to) in turn.to.iter().enumerate() {
        let target = &mut later[to - at - 1];
        for (death, here) in target.death.iter_mut().zip(turn.death) {
            *death += turn.into[i] * here;
        }
        // All later neighbours are neighbours of this one; both lists are in order.
        let mut ray = 0;
        for j in i + 1..turn.to.len() {
            while target.to[ray] < turn.to[j] {
                ray += 1;
            }
            target.out[ray] += turn.into[i] * turn.out[j];
            target.into[ray] += turn.into[j] * turn.out[i];
        }
    }
}
