//! Finds how a case lies in the atlas: many starts with wide Gaussians, then expectation-maximisation with the exact names. In a whole brain
//! it is looked for where thick vessels are dense, and what counts is how much of the atlas is seen.

use faer::{Mat, Side, linalg::solvers::Solve};

use super::algebra::{Symmetric, TableTimes, product, rotation, rotation_vector, symmetric_times, times, transposed};
use super::atlas::{Atlas, AtlasState, BIN, NOWHERE, STATES, all_states, arteries};
use super::emission::{ALL_PARTS, Pose, Search, Single, TEMPER};
use super::nodes::Nodes;
use willis_core::support::geometry::{Point, distance, dot, norm, sub, weighted_centroid};
use willis_core::support::{simd::InstructionSet, statistics::weighted_quantiles};

/// Nodes that serve the search.
const SEARCH_NODES: usize = 110;
/// The standard deviation of rotations, radians: heads lie within some 20 degrees of the frame.
const ROTATION: f64 = 20.0 / 180.0 * std::f64::consts::PI;
/// The standard deviation of the log scale, and the most that it can be: heads of adults.
const SCALE: f64 = 0.06;
const MOST_SCALE: f64 = 0.2;
/// The share of its length that a node counts for: neighbours lie on one vessel.
const GAIN: f64 = 0.25;
/// How much the radius counts while a pose is searched, against 1 in its refinement.
const SEARCH_RADIUS: f64 = 0.5;
/// Starts that are refined, and optima that are refined by names, the frames together: none that fits a node so much worse than the best.
const REFINED: usize = 16;
const NAMED: usize = 5;
const WORSE: f64 = 1.0;
/// Optima that are refined again when false pieces are known.
const AGAIN: usize = 2;
/// Widths (mm) at which a pose is refined by names.
const NAMED_WIDTHS: [f64; 4] = [2.0, 1.0, 0.0, 0.0];

/// How states pull a node that may be in them: per state its precision, the precision times its mean, and whether it is an artery.
pub struct Pulls {
    states: usize,
    /// Ten rows over the states.
    table: Vec<f64>,
    instructions: InstructionSet,
}

impl Pulls {
    /// Of some states at the precisions of the atlas, possibly widened.
    pub fn of(atlas: &Atlas, states: &[AtlasState], precisions: &[(Symmetric, f64)]) -> Self {
        let mut table = vec![0.0; 10 * states.len()];
        for (column, state) in states.iter().enumerate().filter(|(_, state)| **state != NOWHERE) {
            let precision = &precisions[*state].0;
            let mean = symmetric_times(precision, atlas.data.pieces[*state].mean);
            for (row, pull) in precision.iter().chain(&mean).chain(&[1.0]).enumerate() {
                table[row * states.len() + column] = *pull;
            }
        }
        Self { states: states.len(), table, instructions: InstructionSet::detect() }
    }
}

/// A pose and how well it fits.
#[derive(Debug, Clone, Copy)]
pub struct Scored {
    /// The pose.
    pub pose: Pose,
    /// Its score: the log ratio to no artery of the circle, summed over the length, with the prior; of a whole brain summed over what is seen
    /// of the atlas.
    pub score: f64,
}

impl Search<'_> {
    /// The best poses by each node by itself, the best first, each with its mean log likelihood of a node. What is no part of the circle is most
    /// of a whole brain: it would draw the scale to the least there is, and another order of the nodes would give other optima.
    fn starts(&self, is_brain: bool) -> Vec<Scored> {
        let order = if is_brain { by_place(&self.nodes.at) } else { (0..self.nodes.len()).collect() };
        let (subset, all) = (self.subset(order), all_states());
        // Pieces of 8 mm serve a search among Gaussians that are wide.
        let coarse: Vec<AtlasState> =
            all.iter().copied().filter(|s| *s == NOWHERE || self.atlas.tables.bin[*s].is_multiple_of(2)).collect();
        let weighted = (0..self.nodes.len()).map(|n| (self.nodes.at[n], self.length(n)));
        let centre = weighted_centroid(weighted).unwrap_or_default();
        let single = |states| Single::new(self, [&subset, states], SEARCH_RADIUS);
        let [first, second] = [single(&coarse), single(&all)];
        let widths = [(12.0, &first), (9.0, &first), (7.0, &second), (5.0, &second)].map(|(tau, single)| {
            let precisions = self.atlas.widened(tau);
            let states: &[AtlasState] = if tau > 8.0 { &coarse } else { &all };
            (single, single.places(&precisions), Pulls::of(self.atlas, states, &precisions))
        });
        let mut starts: Vec<(Scored, ())> = Vec::new();
        for turn in start_turns() {
            for (axis, length) in START_OFFSETS {
                let turn = rotation(turn.map(f64::to_radians));
                let to = times(&turn, centre);
                let shift = [0, 1, 2].map(|k| self.atlas.data.centroid[k] + along(axis, length)[k] - to[k]);
                let mut pose = Pose { turn, shift, log_scale: 0.0 };
                for (single, places, pulls) in &widths[..3] {
                    let (names, _) = single.probabilities(&pose, places);
                    pose = self.step(&subset, &pose, pulls, &names, false);
                }
                let (single, places, _) = &widths[3];
                let score = single.probabilities(&pose, places).1 / subset.len() as f64;
                starts.push((Scored { pose, score }, ()));
            }
        }
        let starts = distinct(starts, centre, 0.2, 4.0, REFINED);
        let single = Single::new(self, [&subset, &all], 1.0);
        let widths = [6.0, 5.0, 4.0, 3.0, 2.0, 1.0].map(|tau| {
            let precisions = self.atlas.widened(tau);
            (single.places(&precisions), Pulls::of(self.atlas, &all, &precisions))
        });
        let refined = |(start, ()): (Scored, ())| {
            let mut pose = start.pose;
            for (places, pulls) in &widths[..5] {
                let (names, _) = single.probabilities(&pose, places);
                pose = self.step(&subset, &pose, pulls, &names, !is_brain);
            }
            let fit = single.probabilities(&pose, &widths[5].0).1 / subset.len() as f64;
            (Scored { pose, score: fit + 3.0 * pose.log_scale }, ())
        };
        let refined = distinct(starts.into_iter().map(refined).collect(), centre, 0.15, 4.0, NAMED);
        refined.into_iter().map(|(scored, ())| scored).collect()
    }

    /// The best poses around the first few that are nearly right, the best first.
    pub fn around(&self, poses: &[Pose]) -> Vec<Scored> {
        self.refine(&poses[..poses.len().min(AGAIN)], &[3.0, 2.0, 1.0])
    }

    /// Refines poses by all nodes, first each by itself at some widths, then by the names of all together.
    fn refine(&self, poses: &[Pose], widths: &[f64]) -> Vec<Scored> {
        let (all, states) = ((0..self.nodes.len()).collect::<Vec<_>>(), all_states());
        let single = Single::new(self, [&all, &states], 1.0);
        let at_width = |tau: f64| {
            let precisions = self.atlas.widened(tau);
            (single.places(&precisions), Pulls::of(self.atlas, &states, &precisions), precisions)
        };
        let [alone, named] = [widths, &NAMED_WIDTHS].map(|widths| widths.iter().map(|tau| at_width(*tau)).collect::<Vec<_>>());
        let mut found: Vec<(Scored, Pose)> = Vec::new();
        for pose in poses {
            let mut pose = *pose;
            for (places, pulls, _) in &alone {
                let (names, _) = single.probabilities(&pose, places);
                pose = self.step(&all, &pose, pulls, &names, true);
            }
            let x = self.nodes.at.first().copied().unwrap_or_default();
            let is_near = |q: &Pose| angle_between(&pose, q) < 0.06 && distance(unscaled(&pose, x), unscaled(q, x)) < 1.5;
            if found.iter().any(|(_, q)| is_near(q)) {
                continue;
            }
            let first = pose;
            for (_, pulls, precisions) in &named {
                pose = self.named_step(&all, &pose, pulls, precisions);
            }
            found.push((Scored { pose, score: self.score(&pose) }, first));
        }
        let mut found: Vec<Scored> = found.into_iter().map(|(scored, _)| scored).collect();
        found.sort_by(|a, b| b.score.total_cmp(&a.score));
        found
    }

    /// The names at a pose, and the log likelihoods that they are of: nodes x states.
    fn names(&self, pose: &Pose) -> [Vec<f64>; 2] {
        let e = self.emission(&self.fit(pose, &self.atlas.position), ALL_PARTS);
        let tempered: Vec<f64> = e.iter().map(|x| TEMPER * x).collect();
        [self.settled(&tempered, 1).0.states, e]
    }

    /// The log ratio of all names to no artery of the circle, over the length (mm) of the atlas that is seen. Each state counts for its own
    /// length at most: any part of a brain that is full of vessels fits well by their sum.
    fn coverage(&self, pose: &Pose) -> f64 {
        let [names, e] = self.names(pose);
        let (mut length, mut fit) = ([0.0; STATES], [0.0; STATES]);
        for (n, (names, e)) in names.chunks(STATES).zip(e.chunks(STATES)).enumerate() {
            for state in arteries() {
                let seen = names[state] * self.length(n);
                length[state] += seen;
                fit[state] += seen * (e[state] - self.atlas.log_other);
            }
        }
        let scale = pose.log_scale.exp();
        arteries().map(|state| fit[state] * scale.min(BIN / length[state].max(f64::MIN_POSITIVE))).sum()
    }

    /// The log ratio of all names to no artery of the circle, with the prior of the pose. The Jacobian, 3 log scales a node, keeps small
    /// from being likely.
    fn score(&self, pose: &Pose) -> f64 {
        let [names, e] = self.names(pose);
        let mut score = 0.0;
        for (n, (names, e)) in names.chunks(STATES).zip(e.chunks(STATES)).enumerate() {
            let fit: f64 = names.iter().zip(e).map(|(g, e)| g * (e - self.atlas.log_other)).sum();
            score += self.length(n) * (fit + 3.0 * pose.log_scale * (1.0 - names[NOWHERE]));
        }
        let turn = norm(rotation_vector(&pose.turn));
        score - 0.5 * turn * turn / (ROTATION * ROTATION)
    }

    fn length(&self, node: usize) -> f64 {
        self.nodes.weight[node] * self.weight[node]
    }

    /// A step of `all` nodes by the names of all together.
    pub fn named_step(&self, all: &[usize], pose: &Pose, pulls: &Pulls, precisions: &[(Symmetric, f64)]) -> Pose {
        let names = self.forest.beliefs(self.atlas, &self.tempered(&self.fit(pose, precisions))).states;
        self.step(all, pose, pulls, &names, true)
    }

    /// One Gauss-Newton step of rotation, shift and scale, given the probabilities of the states of some nodes.
    pub fn step(&self, subset: &[usize], pose: &Pose, pulls: &Pulls, names: &[f64], scales: bool) -> Pose {
        let scale = pose.log_scale.exp();
        let placed: Vec<Point> = subset.iter().map(|n| times(&pose.turn, self.nodes.at[*n]).map(|x| scale * x)).collect();
        let length: Vec<f64> = subset.iter().map(|n| self.length(*n)).collect();
        let centre = weighted_centroid(placed.iter().copied().zip(length.iter().copied())).unwrap_or_default();
        let mut hessian = [[0.0; 7]; 7];
        let mut gradient = [0.0; 7];
        let mut counted = 0.0;
        for ((names, at), w) in names.chunks(pulls.states).zip(&placed).zip(&length) {
            let mut out = [0.0; 10];
            pulls.instructions.run(TableTimes { table: &pulls.table, by: names, out: &mut out });
            let [a, b, c, d, e, f, x, y, z, arteries] = out.map(|pull| pull * w * GAIN);
            let sum = [a, b, c, d, e, f];
            counted += arteries;
            let here = [at[0] + pose.shift[0], at[1] + pose.shift[1], at[2] + pose.shift[2]];
            let residual = sub(symmetric_times(&sum, here), [x, y, z]);
            let arm = sub(*at, centre);
            let jacobian: [Point; 7] = [
                [0.0, -arm[2], arm[1]],
                [arm[2], 0.0, -arm[0]],
                [-arm[1], arm[0], 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                arm,
            ];
            let pulled = jacobian.map(|column| symmetric_times(&sum, column));
            for i in 0..7 {
                gradient[i] += dot(jacobian[i], residual);
                for j in 0..7 {
                    hessian[i][j] += dot(jacobian[i], pulled[j]);
                }
            }
        }
        let turned = rotation_vector(&pose.turn);
        for k in 0..3 {
            hessian[k][k] += 1.0 / (ROTATION * ROTATION);
            gradient[k] += turned[k] / (ROTATION * ROTATION);
            hessian[3 + k][3 + k] += 1e-6;
        }
        hessian[6][6] += 1.0 / (SCALE * SCALE);
        gradient[6] += pose.log_scale / (SCALE * SCALE) - 3.0 * counted;
        if !scales {
            hessian[6] = [0.0; 7];
            for row in &mut hessian {
                row[6] = 0.0;
            }
            (hessian[6][6], gradient[6]) = (1.0, 0.0);
        }
        let Some(mut step) = solve(&hessian, &gradient) else { return *pose };
        let angle = norm([step[0], step[1], step[2]]);
        if angle > 0.3 {
            for d in &mut step {
                *d *= 0.3 / angle;
            }
        }
        let turn = rotation([step[0], step[1], step[2]]);
        let log_scale = (pose.log_scale + step[6]).clamp(-MOST_SCALE, MOST_SCALE);
        let about = times(&turn, centre).map(|x| x * (log_scale - pose.log_scale).exp());
        let shift = [0, 1, 2].map(|k| pose.shift[k] + step[3 + k] + centre[k] - about[k]);
        Pose { turn: product(&turn, &pose.turn), shift, log_scale }
    }

    /// Nodes at equal distances along all that counts, in some order.
    fn subset(&self, order: Vec<usize>) -> Vec<usize> {
        if order.len() <= SEARCH_NODES {
            return order;
        }
        let apart = order.iter().map(|node| self.length(*node)).sum::<f64>() / SEARCH_NODES as f64;
        let mut sum = 0.0;
        let is_next = |node: &usize| {
            let before = (sum / apart).round();
            sum += self.length(*node);
            (sum / apart).round() > before
        };
        order.into_iter().filter(is_next).collect()
    }
}

/// The rows of some positions (mm) along a curve that fills space, whatever their order in the file: cells of 1/4 mm by the bits of their
/// coordinates in turn.
fn by_place(at: &[Point]) -> Vec<usize> {
    let curve = |row: &usize| {
        let cell = at[*row].map(|x| (4.0 * x + 32768.0) as u16);
        (0..48).rev().fold(0_u64, |key, bit| key << 1 | u64::from(cell[bit % 3] >> (bit / 3) & 1))
    };
    let mut rows: Vec<usize> = (0..at.len()).collect();
    rows.sort_by_cached_key(curve);
    rows
}

/// The best of some poses, each with what else is known, that differ by an angle (radians) or by a distance (mm) where `centre` comes to lie.
fn distinct<T>(mut poses: Vec<(Scored, T)>, centre: Point, angle: f64, shift: f64, most: usize) -> Vec<(Scored, T)> {
    poses.sort_by(|(a, _), (b, _)| b.score.total_cmp(&a.score));
    let mut kept: Vec<(Scored, T)> = Vec::new();
    for (scored, known) in poses {
        let is_new = kept.iter().all(|(other, _)| {
            angle_between(&scored.pose, &other.pose) > angle
                || distance(unscaled(&scored.pose, centre), unscaled(&other.pose, centre)) > shift
        });
        if is_new && kept.len() < most {
            kept.push((scored, known));
        }
    }
    kept
}

/// Where a position comes to lie, the scale left out.
fn unscaled(pose: &Pose, x: Point) -> Point {
    Pose { log_scale: 0.0, ..*pose }.apply(x)
}

fn angle_between(a: &Pose, b: &Pose) -> f64 {
    norm(rotation_vector(&product(&a.turn, &transposed(&b.turn))))
}

/// Offsets of the middle along an axis, mm: a tracing may show one side alone.
const START_OFFSETS: [(usize, f64); 7] = [(0, 0.0), (2, 14.0), (2, -14.0), (0, 12.0), (0, -12.0), (0, 24.0), (0, -24.0)];

/// A vector along an axis.
fn along(axis: usize, length: f64) -> Point {
    [0, 1, 2].map(|k| if k == axis { length } else { 0.0 })
}

/// Rotation vectors in degrees: none, 25 and 42 about each axis, 18 about all three.
fn start_turns() -> Vec<Point> {
    let one = (0..3).flat_map(|axis| [25.0, -25.0, 42.0, -42.0].map(|degrees| along(axis, degrees)));
    let all = (0..8).map(|n| [n & 4, n & 2, n & 1].map(|bit| if bit == 0 { -18.0 } else { 18.0 }));
    std::iter::once([0.0; 3]).chain(one).chain(all).collect()
}

/// -H⁻¹ g, by Cholesky's method; `None` where H is not positive definite.
fn solve(hessian: &[[f64; 7]; 7], gradient: &[f64; 7]) -> Option<[f64; 7]> {
    let h = Mat::from_fn(7, 7, |i, j| hessian[i][j]);
    let g = Mat::from_fn(7, 1, |i, _| -gradient[i]);
    let step = h.llt(Side::Lower).ok()?.solve(&g);
    let step: [f64; 7] = std::array::from_fn(|i| step[(i, 0)]);
    step.iter().all(|x| x.is_finite()).then_some(step)
}

/// Networks of more length (mm) than this are whole brains: a circle with all that its image shows has some 300 to 700.
const WHOLE_BRAIN: f64 = 1500.0;
/// Vessels in this share of the length are thick.
const THICK: f64 = 0.90;
/// The pose is searched around so many places where they are densest: most length within a distance, and so far apart (mm). So many places
/// are asked.
const PLACES: usize = 3;
const DENSE: f64 = 30.0;
const APART: f64 = 25.0;
const ASKED: usize = 500;
/// The circle lies within this distance (mm) of such a place.
const REACH: f64 = 45.0;
/// Of these, vessels above this share of the length serve the search of the pose.
const SEARCHED: f64 = 0.55;
/// Pieces of less length (mm) do not serve it.
const LEAST_SEARCHED: f64 = 8.0;
/// Poses that are refined on what lies on the atlas there.
const SETTLED: usize = 3;
/// Widths (mm) at which they are; the best one so often again, with what lies on the atlas taken anew.
const SETTLED_WIDTHS: [f64; 4] = [3.0, 2.0, 1.0, 0.0];
const SETTLED_AGAIN: usize = 2;
/// What lies within so many standard deviations of a state is named, in pieces of at least so much (mm).
const ON_ATLAS: f64 = 2.5;
const LEAST_NAMED: f64 = 6.0;

/// What is to be named: its nodes, and the median log radius where it is not that of these nodes.
pub type Core = (Nodes, Option<f64>);

/// What lies on the atlas at a pose, in pieces that are long enough.
fn on_the_atlas(nodes: &Nodes, atlas: &Atlas, pose: &Pose) -> Nodes {
    let lies_there = |n: usize| {
        let at = pose.apply(nodes.at[n]);
        arteries().any(|state| {
            let d = sub(at, atlas.data.pieces[state].mean);
            dot(d, symmetric_times(&atlas.position[state].0, d)) < ON_ATLAS * ON_ATLAS
        })
    };
    nodes.part(lies_there, LEAST_NAMED)
}

/// The core of a network whose pose is known.
pub fn core_at(nodes: Nodes, atlas: &Atlas, pose: &Pose) -> Option<Core> {
    if nodes.length() <= WHOLE_BRAIN {
        return Some((nodes, None));
    }
    let named = on_the_atlas(&nodes, atlas, pose);
    let median = named.median_log_radius(|_| 1.0);
    (!named.is_empty()).then_some((named, Some(median)))
}

/// The cores of the nodes of a network in some frames, and the poses of each, the best first. Of a whole brain there is one.
pub fn find_cores<F: Copy>(frames: Vec<(F, Nodes)>, atlas: &Atlas) -> Vec<(F, Core, Vec<Scored>)> {
    if frames.first().is_some_and(|(_, nodes)| nodes.length() > WHOLE_BRAIN) {
        return find_in_brain(&frames, atlas).into_iter().collect();
    }
    let median = |nodes: &Nodes| nodes.median_log_radius(|_| 1.0);
    let start =
        |(frame, nodes): (F, Nodes)| (with_search(&nodes, atlas, median(&nodes), |search| search.starts(false)), frame, nodes);
    let started: Vec<(Vec<Scored>, F, Nodes)> = frames.into_iter().map(start).collect();
    let best = started.iter().flat_map(|(starts, ..)| starts).map(|start| start.score).fold(f64::NEG_INFINITY, f64::max);
    let refined = started.into_iter().filter_map(|(starts, frame, nodes)| {
        let near: Vec<Pose> = starts.iter().filter(|start| start.score > best - WORSE).map(|start| start.pose).collect();
        if near.is_empty() {
            return None;
        }
        let poses = with_search(&nodes, atlas, median(&nodes), |search| search.refine(&near, &[2.0, 1.0]));
        Some((frame, (nodes, None), poses))
    });
    refined.collect()
}

/// The core of a whole brain and its pose, in the frame where most of the atlas is seen.
fn find_in_brain<F: Copy>(frames: &[(F, Nodes)], atlas: &Atlas) -> Option<(F, Core, Vec<Scored>)> {
    let of_frame = |(frame, (_, nodes)): (usize, &(F, Nodes))| {
        brain_starts(nodes, atlas).into_iter().map(move |(start, median)| (start, frame, median))
    };
    let mut started: Vec<(Scored, usize, f64)> = frames.iter().enumerate().flat_map(of_frame).collect();
    started.sort_by(|(a, ..), (b, ..)| b.score.total_cmp(&a.score));
    let settle = |(start, frame, median): (Scored, usize, f64)| {
        Some((settled(&frames[frame].1, atlas, start.pose, median, &SETTLED_WIDTHS)?, frame, median))
    };
    let first = started.into_iter().take(SETTLED).filter_map(settle);
    let (mut found, frame, median) = first.reduce(|best, next| if next.0.0.score > best.0.0.score { next } else { best })?;
    let (frame, nodes) = &frames[frame];
    for _ in 0..SETTLED_AGAIN {
        found = settled(nodes, atlas, found.0.pose, median, &[0.0; 4])?;
    }
    let (scored, named) = found;
    Some((*frame, (named, Some(median)), vec![scored]))
}

/// The poses of a whole brain that show most of the atlas, each with the median log radius of what it was found by.
fn brain_starts(nodes: &Nodes, atlas: &Atlas) -> Vec<(Scored, f64)> {
    let radius = branch_radii(nodes);
    let length_below = |counts: &dyn Fn(usize) -> bool, share: f64| {
        let those = (0..nodes.len()).filter(|n| counts(*n)).map(|n| (radius[n], nodes.weight[n]));
        weighted_quantiles(those, [share])[0].unwrap_or(f64::INFINITY)
    };
    let thick = length_below(&|_| true, THICK);
    let of_thick: Vec<usize> = (0..nodes.len()).filter(|n| radius[*n] >= thick).collect();
    let mut poses: Vec<(Scored, f64)> = Vec::new();
    for place in densest(nodes, &of_thick) {
        let near = |n: usize| distance(nodes.at[n], place) < REACH;
        let least = length_below(&near, SEARCHED);
        let searched = nodes.part(|n| near(n) && radius[n] >= least, LEAST_SEARCHED);
        if !searched.is_empty() {
            let median = searched.median_log_radius(|_| 1.0);
            let starts = with_search(&searched, atlas, median, |search| search.starts(true).into_iter());
            poses.extend(starts.filter_map(|start| Some((settled(nodes, atlas, start.pose, median, &[])?.0, median))));
        }
    }
    let Some((first, _)) = poses.iter().max_by(|(a, _), (b, _)| a.score.total_cmp(&b.score)) else { return poses };
    let centre = first.pose.undo(atlas.data.centroid);
    distinct(poses, centre, 0.15, 4.0, SETTLED)
}

/// A pose of a whole brain refined at some widths by the names of what lies on the atlas there, and what that is; `None` where nothing does.
fn settled(nodes: &Nodes, atlas: &Atlas, mut pose: Pose, median: f64, widths: &[f64]) -> Option<(Scored, Nodes)> {
    let named = on_the_atlas(nodes, atlas, &pose);
    if named.is_empty() {
        return None;
    }
    let score = with_search(&named, atlas, median, |search| {
        let all: Vec<usize> = (0..named.len()).collect();
        for tau in widths {
            let precisions = atlas.widened(*tau);
            pose = search.named_step(&all, &pose, &Pulls::of(atlas, &all_states(), &precisions), &precisions);
        }
        search.coverage(&pose)
    });
    Some((Scored { pose, score }, named))
}

/// Where most of some nodes lie together, the most first.
fn densest(nodes: &Nodes, of: &[usize]) -> Vec<Point> {
    let at: Vec<Point> = of.iter().map(|n| nodes.at[*n]).collect();
    let around = |x: Point| -> f64 { of.iter().filter(|n| distance(x, nodes.at[**n]) < DENSE).map(|n| nodes.weight[*n]).sum() };
    let asked = by_place(&at).into_iter().step_by(of.len().div_ceil(ASKED).max(1)).map(|row| at[row]);
    let mut asked: Vec<(f64, Point)> = asked.map(|x| (around(x), x)).collect();
    asked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut places: Vec<Point> = Vec::new();
    for (_, x) in asked {
        if places.len() < PLACES && places.iter().all(|place| distance(x, *place) > APART) {
            places.push(x);
        }
    }
    places
}

/// What `asks` finds in a search by all nodes with all bridges.
fn with_search<T>(nodes: &Nodes, atlas: &Atlas, median: f64, asks: impl FnOnce(&Search) -> T) -> T {
    let (weight, used) = (vec![1.0; nodes.len()], nodes.spanning_bridges(|_| true));
    asks(&Search::new(nodes, atlas, &weight, &used, median))
}

/// Per node the mean radius of its branch, mm.
fn branch_radii(nodes: &Nodes) -> Vec<f64> {
    let (mut sum, mut length) = (vec![0.0; nodes.branches], vec![1e-9; nodes.branches]);
    for n in 0..nodes.len() {
        sum[nodes.branch[n]] += nodes.log_radius[n].exp() * nodes.weight[n];
        length[nodes.branch[n]] += nodes.weight[n];
    }
    nodes.branch.iter().map(|b| sum[*b] / length[*b]).collect()
}
