//! Ties that are structural: links in series, with nothing else to carry flow between them, share one flow, and with equal radii one
//! resilience. Rounding tells them apart, and differently in every solver; here they are made equal to the last bit.

use crate::flow::Circuit;

/// Nodes at which two links may tie, in depth-first order.
#[derive(Debug, Default)]
pub struct Ties {
    /// Per such node where its links begin; one more at the end.
    start: Vec<u32>,
    links: Vec<u32>,
}

/// Two links that tie in one sample of a group.
#[derive(Debug, Clone, Copy)]
struct Tie {
    links: [u32; 2],
    lane: u32,
}

/// The memory of one worker.
#[derive(Debug, Default)]
pub struct Workspace(Vec<Tie>);

impl Ties {
    /// Those of a circuit whose links have such a ρ over the square of their flow.
    pub fn new(circuit: &Circuit, factor: &[f64]) -> Self {
        let nodes = circuit.node_count();
        let mut around = vec![Vec::new(); nodes];
        for (link, ends) in circuit.ends.iter().enumerate().filter(|(_, [a, b])| a != b) {
            for end in ends {
                around[*end].push(link as u32);
            }
        }
        let may_tie = |links: &[u32]| {
            let mut factors: Vec<f64> = links.iter().map(|link| factor[*link as usize]).collect();
            factors.sort_unstable_by(f64::total_cmp);
            factors.windows(2).any(|pair| same(pair[0], pair[1]))
        };
        let mut ties = Self { start: vec![0], links: Vec::new() };
        let (mut seen, mut stack) = (vec![false; nodes], Vec::new());
        for root in 0..nodes {
            stack.push(root);
            while let Some(node) = stack.pop() {
                if std::mem::replace(&mut seen[node], true) {
                    continue;
                }
                let links = &around[node];
                if circuit.is_inner(node) && may_tie(links) {
                    ties.links.extend_from_slice(links);
                    ties.start.push(ties.links.len() as u32);
                }
                for link in links.iter().rev() {
                    let [a, b] = circuit.ends[*link as usize];
                    stack.extend(Some(if a == node { b } else { a }).filter(|other| !seen[*other]));
                }
            }
        }
        ties
    }

    /// Makes the resiliences of links that tie equal: the largest of them for all in series.
    pub fn equalise<const B: usize, G: AsRef<[f64]> + AsMut<[f64]>>(
        &self,
        factor: impl Fn(usize) -> f64,
        resilience: &mut [G],
        work: &mut Workspace,
    ) {
        let ties = &mut work.0;
        ties.clear();
        for at in self.start.windows(2) {
            let links = &self.links[at[0] as usize..at[1] as usize];
            let (mut count, mut two) = ([0_u32; B], [[0_u32; B]; 2]);
            for link in links {
                for (lane, rho) in resilience[*link as usize].as_ref().iter().enumerate() {
                    if *rho > 0.0 {
                        two[(count[lane] & 1) as usize][lane] = *link;
                        count[lane] += 1;
                    }
                }
            }
            for lane in (0..B).filter(|lane| count[*lane] == 2) {
                let links = [two[0][lane], two[1][lane]];
                if same(factor(links[0] as usize), factor(links[1] as usize)) {
                    ties.push(Tie { links, lane: lane as u32 });
                }
            }
        }
        let mut level = |tie: &Tie| {
            let [a, b] = tie.links.map(|link| resilience[link as usize].as_ref()[tie.lane as usize]);
            let most = a.max(b);
            tie.links.iter().for_each(|link| resilience[*link as usize].as_mut()[tie.lane as usize] = most);
        };
        // Along a branch of the depth-first order the largest is carried up to its top, and from there down again.
        for _ in 0..2 {
            ties.iter().rev().for_each(&mut level);
            ties.iter().for_each(&mut level);
        }
    }
}

/// Whether two are one up to the rounding of radii, such as of the mean of two that are equal.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * a.max(b)
}
