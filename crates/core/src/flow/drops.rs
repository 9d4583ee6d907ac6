//! Pressure drops that do not come from pressures, so that a wide vessel in series with a narrow one keeps all digits of its drop.
//!
//! A drop P_a - P_b has as many digits as the two pressures differ in: few or none where a vessel conducts 10¹² times what lies in series
//! with it. Here drops are carried through the star-mesh elimination instead. With w the weights of the star of node k, and j one of its
//! neighbours, P_k - P_j = Σ_i w_i (P_i - P_j) + s_k/S_k, where each difference is that of two later nodes, or of a later node and a
//! pressure that a condition holds. Such a sum loses digits only where larger drops cancel in it. How far rounding may have
//! moved it is summed up beside it, which tells a small flow from none.

use super::{Circuit, circuit::same_pressure, grounded, resilience::DROP_CUT};
use crate::support::elimination::{Elimination, NOWHERE};

/// Drops below this share of the larger pressure have three digits at the most.
pub const FEW_DIGITS: f64 = 10.0 * DROP_CUT;
/// Roundings of a term of a sum, for each node of the circuit.
const ROUNDINGS: f64 = 8.0;

/// A circuit compiled for drops, one sample at a time.
#[derive(Debug)]
pub struct Drops {
    circuit: Circuit,
    program: Elimination,
    /// The pressures that conditions hold, Pa above the circuit's level.
    levels: Vec<f64>,
    /// Per node the level of its own condition.
    level: Vec<Option<usize>>,
    /// Per row its ray; `NOWHERE` where it does not join two free nodes.
    ray: Vec<u32>,
}

/// The memory of one worker.
#[derive(Debug, Default)]
pub struct DropsWorkspace {
    /// Per node the level at which its pressure is held in this sample.
    held: Vec<Option<usize>>,
    /// By ray a conductance; once its star is eliminated, a weight.
    conductance: Vec<f64>,
    /// By place and level the same of what leads to a held pressure.
    ground: Vec<f64>,
    /// By place what is injected, m³/s; once its star is eliminated, over S, Pa.
    source: Vec<f64>,
    /// By place and level P_k - P, Pa.
    above: Vec<Bounded>,
    /// By ray P_k - P_j, Pa.
    drop: Vec<Bounded>,
}

/// A number, and how far rounding may have moved it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Bounded {
    /// As it was worked out.
    pub value: f64,
    /// The truth is no further away.
    pub error: f64,
}

impl Bounded {
    fn exactly(value: f64) -> Self {
        Self { value, error: 0.0 }
    }

    fn negated(self) -> Self {
        Self { value: -self.value, ..self }
    }

    /// Adds a weight times a number; `unit` is what rounding may take from such a term.
    fn add(&mut self, weight: f64, of: Self, unit: f64) {
        let term = weight * of.value;
        self.value += term;
        self.error += weight * of.error + unit * term.abs();
    }
}

impl Drops {
    /// Compiles a circuit; `None` when it would take more than `limit` joins a sample.
    pub fn compile(circuit: &Circuit, limit: usize) -> Option<Self> {
        let is_free = |node: usize| circuit.fixed[node].is_none();
        let order = |nodes: usize, links: &[[usize; 2]]| Elimination::compile(nodes, links, limit);
        let program = Elimination::among(circuit.node_count(), &circuit.ends, is_free, order)?;
        let ray = |[a, b]: &[usize; 2]| {
            let joins_free = a != b && is_free(*a) && is_free(*b);
            if joins_free { program.ray_between(program.place(*a), program.place(*b)) } else { NOWHERE }
        };
        let levels = circuit.levels();
        let level_of = |pressure: f64| levels.partition_point(|level| *level <= pressure || same_pressure(*level, pressure)) - 1;
        Some(Self {
            ray: circuit.ends.iter().map(ray).collect(),
            level: (0..circuit.node_count()).map(|node| circuit.ground(node).map(level_of)).collect(),
            circuit: circuit.clone(),
            program,
            levels,
        })
    }

    /// Whether vessels that carry blood may have so small drops that pressures do not show them. The least drop, as a share of the
    /// pressures, is taken to be that of the widest vessel in series with what conducts least, in a loop of the next wide vessel with
    /// the next narrow one.
    pub fn may_hide(circuit: &Circuit) -> bool {
        let vessels = circuit.ends[..circuit.vessel_count()].iter().zip(&circuit.conductance);
        let mut vessels: Vec<f64> = vessels.filter(|([a, b], _)| a != b).map(|(_, conductance)| *conductance).collect();
        vessels.sort_unstable_by(f64::total_cmp);
        let (Some(narrowest), Some(widest)) = (vessels.first(), vessels.last()) else { return false };
        let next = |at: Option<usize>| at.and_then(|at| vessels.get(at).copied());
        let (narrow, wide) = (next(Some(1)).unwrap_or(*narrowest), next(vessels.len().checked_sub(2)).unwrap_or(*widest));
        let terminals = circuit.fixes.iter().zip(&circuit.conductance[circuit.vessel_count()..]);
        let terminals = terminals.filter(|(fixes, _)| !**fixes).map(|(_, conductance)| *conductance);
        let least = circuit.shunt.iter().copied().filter(|shunt| *shunt > 0.0).chain(terminals).fold(f64::INFINITY, f64::min);
        let levels = circuit.levels();
        let held = levels.iter().fold(0.0, |most, level| f64::max(most, (level + circuit.level).abs()));
        let range = if let [lowest, .., highest] = levels[..] { highest - lowest } else { f64::INFINITY };
        let injected: Vec<f64> = circuit.injected().map(|node| circuit.source[node].abs()).collect();
        let pressure = held + injected.iter().copied().fold(0.0, f64::max) / least.min(*narrowest);
        let injected = injected.into_iter().fold(f64::INFINITY, f64::min);
        let by_pressure = if least < *narrowest {
            range * (least / widest) * (narrowest / wide)
        } else {
            range * (narrowest / widest) * (narrow / wide).min(1.0)
        };
        let by_injection = injected / widest * (narrowest / wide);
        by_pressure.min(by_injection) < DROP_CUT * pressure
    }

    /// Whether the drop of a vessel between two pressures (Pa) has so few digits that it is to be asked here.
    pub fn has_few_digits(drop: f64, a: f64, b: f64) -> bool {
        drop.abs() <= FEW_DIGITS * a.abs().max(b.abs())
    }

    /// Finds the drops of the sample whose rows are `open`: vessels, and terminals that hold.
    pub fn solve(&self, open: impl Fn(usize) -> bool, work: &mut DropsWorkspace) {
        self.assemble(open, work);
        self.eliminate(work);
        self.substitute_back(work);
    }

    /// The drop along a row in the sample that was solved, in absolute value, Pa; `None` where nothing flows in it when it is open.
    pub fn drop(&self, row: usize, work: &DropsWorkspace) -> Option<f64> {
        let Bounded { value, error } = self.along(row, work);
        Some(value.abs()).filter(|drop| *drop > error)
    }

    /// The pressure at one end of a row less that at the other, Pa, whichever is which.
    pub fn along(&self, row: usize, work: &DropsWorkspace) -> Bounded {
        let [a, b] = self.circuit.ends[row];
        if a == b {
            return Bounded::default();
        }
        match [work.held[a], work.held[b]] {
            [None, None] => work.drop[self.ray[row] as usize],
            [None, Some(level)] => work.above[self.program.place(a) as usize * self.levels.len() + level],
            [Some(level), None] => work.above[self.program.place(b) as usize * self.levels.len() + level],
            [Some(a), Some(b)] => Bounded::exactly(self.levels[a] - self.levels[b]),
        }
    }

    fn assemble(&self, open: impl Fn(usize) -> bool, work: &mut DropsWorkspace) {
        let Self { circuit, program, levels, .. } = self;
        let DropsWorkspace { held, conductance, ground, source, above, drop } = work;
        held.clear();
        held.extend(self.level.iter().zip(&circuit.fixed).map(|(level, fixed)| fixed.and(*level)));
        for (_, [node, outside]) in circuit.fixing().filter(|(row, _)| open(*row)) {
            held[node] = self.level[outside];
        }
        for list in [&mut *conductance, &mut *ground, &mut *source] {
            list.clear();
        }
        conductance.resize(program.rays(), 0.0);
        ground.resize(program.nodes() * levels.len(), 0.0);
        source.resize(program.nodes(), 0.0);
        above.clear();
        drop.clear();
        above.resize(program.nodes() * levels.len(), Bounded::default());
        drop.resize(program.rays(), Bounded::default());

        for (row, [a, b]) in circuit.ends.iter().enumerate().filter(|(row, [a, b])| a != b && open(*row)) {
            let own = circuit.conductance[row];
            match [held[*a], held[*b]] {
                [None, None] => conductance[self.ray[row] as usize] += own,
                [None, Some(level)] => ground[program.place(*a) as usize * levels.len() + level] += own,
                [Some(level), None] => ground[program.place(*b) as usize * levels.len() + level] += own,
                [Some(_), Some(_)] => {}
            }
        }
        let grounded = circuit.injected().next().map(|_| grounded(circuit, &open));
        for node in (0..circuit.node_count()).filter(|node| held[*node].is_none()) {
            let place = program.place(node) as usize;
            match self.level[node] {
                Some(level) => ground[place * levels.len() + level] += circuit.shunt[node],
                None if grounded.as_ref().is_some_and(|grounded| grounded[node]) => source[place] = circuit.source[node],
                None => {}
            }
        }
    }

    fn eliminate(&self, work: &mut DropsWorkspace) {
        let (program, levels) = (&self.program, self.levels.len());
        let DropsWorkspace { conductance, ground, source, .. } = work;
        for k in 0..program.nodes() {
            let star = program.star(k);
            let (done, later) = ground.split_at_mut((k + 1) * levels);
            let own = &mut done[k * levels..];
            let total = conductance[star.clone()].iter().sum::<f64>() + own.iter().sum::<f64>();
            let inverse = if total >= f64::MIN_POSITIVE { 1.0 / total } else { 0.0 };
            let mut mesh = program.mesh(k).iter();
            for ray in star.clone() {
                let (weight, to) = (conductance[ray] * inverse, program.ray_to()[ray] as usize);
                conductance[ray] = weight;
                source[to] += weight * source[k];
                let others = &mut later[(to - k - 1) * levels..][..levels];
                for (other, own) in others.iter_mut().zip(&*own) {
                    *other += weight * own;
                }
                for (other, target) in (ray + 1..star.end).zip(&mut mesh) {
                    conductance[*target as usize] += weight * conductance[other];
                }
            }
            for own in own {
                *own *= inverse;
            }
            source[k] *= inverse;
        }
    }

    fn substitute_back(&self, work: &mut DropsWorkspace) {
        let (program, levels) = (&self.program, &self.levels);
        let DropsWorkspace { conductance: weight, ground, source, above, drop, .. } = work;
        let unit = ROUNDINGS * f64::EPSILON * (program.nodes() + levels.len()) as f64;
        let to = |ray: usize| program.ray_to()[ray] as usize * levels.len();
        for k in (0..program.nodes()).rev() {
            let (star, own) = (program.star(k), &ground[k * levels.len()..][..levels.len()]);
            let injected = Bounded { value: source[k], error: unit * source[k].abs() };
            for (at, level) in levels.iter().enumerate() {
                let mut sum = injected;
                for ray in star.clone() {
                    sum.add(weight[ray], above[to(ray) + at], unit);
                }
                for (own, other) in own.iter().zip(levels) {
                    sum.add(*own, Bounded::exactly(other - level), unit);
                }
                above[k * levels.len() + at] = sum;
            }
            for ray in star.clone() {
                drop[ray] = injected;
                for (at, own) in own.iter().enumerate() {
                    drop[ray].add(*own, above[to(ray) + at].negated(), unit);
                }
            }
            let mut mesh = program.mesh(k).iter();
            for a in star.clone() {
                for (b, between) in (a + 1..star.end).zip(&mut mesh) {
                    let between = drop[*between as usize];
                    drop[a].add(weight[b], between.negated(), unit);
                    drop[b].add(weight[a], between, unit);
                }
            }
        }
    }
}
