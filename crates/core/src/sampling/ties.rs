//! Ties between vessels in series. Where nothing branches off between two vessels they carry one flow, and with equal radii they have one
//! resilience. Rounding separates them, differently in every solver; here they are made equal to the last bit.

use crate::flow::Circuit;

/// Nodes at which two vessels may tie, in depth-first order. A vessel here is a row of the circuit, which may be a chain.
#[derive(Debug, Default)]
pub struct Ties {
    /// Per such node where its vessels begin; one more at the end.
    start: Vec<u32>,
    vessels: Vec<u32>,
}

/// Two vessels that tie in one sample of a group.
#[derive(Debug, Clone, Copy)]
struct Tie {
    vessels: [u32; 2],
    lane: u32,
}

/// The memory of one worker.
#[derive(Debug, Default)]
pub struct TiesWorkspace(Vec<Tie>);

impl Ties {
    /// The ties of a circuit; `factor` is ρ over the square of the flow of each vessel.
    pub fn new(circuit: &Circuit, factor: &[f64]) -> Self {
        let nodes = circuit.node_count();
        let mut around = vec![Vec::new(); nodes];
        // Where a terminal holds, no other vessel is open that could tie.
        for (vessel, ends) in circuit.ends.iter().enumerate().take(factor.len()).filter(|(_, [a, b])| a != b) {
            for end in ends {
                around[*end].push(vessel as u32);
            }
        }
        let may_tie = |vessels: &[u32]| {
            let mut factors: Vec<f64> = vessels.iter().map(|vessel| factor[*vessel as usize]).collect();
            factors.sort_unstable_by(f64::total_cmp);
            factors.windows(2).any(|pair| same(pair[0], pair[1]))
        };
        let mut ties = Self { start: vec![0], vessels: Vec::new() };
        let (mut seen, mut stack) = (vec![false; nodes], Vec::new());
        for root in 0..nodes {
            stack.push(root);
            while let Some(node) = stack.pop() {
                if std::mem::replace(&mut seen[node], true) {
                    continue;
                }
                let vessels = &around[node];
                if circuit.is_inner(node) && may_tie(vessels) {
                    ties.vessels.extend_from_slice(vessels);
                    ties.start.push(ties.vessels.len() as u32);
                }
                for vessel in vessels.iter().rev() {
                    let [a, b] = circuit.ends[*vessel as usize];
                    stack.extend(Some(if a == node { b } else { a }).filter(|other| !seen[*other]));
                }
            }
        }
        ties
    }

    /// Gives all vessels of a series that tie the largest resilience among them.
    pub fn equalise<const B: usize, G: AsRef<[f64]> + AsMut<[f64]>>(
        &self,
        factor: impl Fn(usize) -> f64,
        resilience: &mut [G],
        work: &mut TiesWorkspace,
    ) {
        let ties = &mut work.0;
        ties.clear();
        for at in self.start.windows(2) {
            let vessels = &self.vessels[at[0] as usize..at[1] as usize];
            let (mut count, mut two) = ([0_u32; B], [[0_u32; B]; 2]);
            for vessel in vessels {
                for (lane, rho) in resilience[*vessel as usize].as_ref().iter().enumerate() {
                    if *rho > 0.0 {
                        two[(count[lane] & 1) as usize][lane] = *vessel;
                        count[lane] += 1;
                    }
                }
            }
            for lane in (0..B).filter(|lane| count[*lane] == 2) {
                let vessels = [two[0][lane], two[1][lane]];
                if same(factor(vessels[0] as usize), factor(vessels[1] as usize)) {
                    ties.push(Tie { vessels, lane: lane as u32 });
                }
            }
        }
        let mut level = |tie: &Tie| {
            let [a, b] = tie.vessels.map(|vessel| resilience[vessel as usize].as_ref()[tie.lane as usize]);
            let most = a.max(b);
            tie.vessels.iter().for_each(|vessel| resilience[*vessel as usize].as_mut()[tie.lane as usize] = most);
        };
        // Along a branch of the depth-first order the largest is carried up to its top, and from there down again.
        for _ in 0..2 {
            ties.iter().rev().for_each(&mut level);
            ties.iter().for_each(&mut level);
        }
    }
}

/// Whether two factors are equal up to the rounding of radii, such as that of the mean of two equal ones.
pub fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * a.max(b)
}
