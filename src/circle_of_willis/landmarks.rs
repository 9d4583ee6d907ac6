//! Landmarks: points that a person set at inlets, outlets and bifurcations of arteries, and their nodes in a network.

use std::collections::BTreeMap;

use super::arteries::{Artery, Side};
use super::labels::{LabelScheme, artery_of_label};
use super::segments_by_landmarks::Points;
use crate::error::Fault;
use crate::io::ListedLandmark;
use crate::network::units::millimetres;
use crate::network::{Nearest, Network, Origin, REACH, nearest_node};
use crate::support::geometry::{Point, cross, distance, dot, lerp, norm_squared, sub, unit};
use crate::support::suggestions::did_you_mean;

/// A point on an artery.
#[derive(Debug, Clone, PartialEq)]
pub struct Landmark {
    /// Its line in the file, from 1.
    pub line: usize,
    /// Its label as given.
    pub label: String,
    /// The artery whose inlet or outlet it is, or the arteries that meet there, sorted.
    pub arteries: Vec<Artery>,
    /// Its position, m.
    pub position: Point,
}

/// The meaning of a landmark in a circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Site {
    /// Inlet of an internal carotid.
    Ica(Side),
    /// Outlet of M1.
    M1(Side),
    /// Outlet of A2.
    A2(Side),
    /// Outlet of P2.
    P2(Side),
    /// Inlet of a vertebral or of the basilar artery.
    Feeder,
    /// Outlet of a third A2.
    Third,
    /// Bifurcation of a carotid.
    Carotid(Side),
    /// End of the basilar artery.
    Tip,
    /// Where PComm meets the posterior cerebral artery.
    Posterior(Side),
    /// Where AComm meets the anterior cerebral artery.
    Anterior(Side),
}

const ACCEPTED: &str = "expected an inlet (L-ICA, R-ICA, L-VA, R-VA, BA), an outlet (L-M1, L-A2, L-P2, 3rd-A2, ...) or a bifurcation \
                        (L-ICA/L-M1/L-A1, L-ICA/L-PComm, L-A1/L-A2/AComm, L-P1/L-P2/L-PComm, BA/L-P1/R-P1, ...)";

/// The arteries of the landmarks in a table.
///
/// # Errors
///
/// A label that is not accepted, or is given twice.
pub fn identify_landmarks(listed: Vec<ListedLandmark>) -> Result<Vec<Landmark>, Fault> {
    let mut out: Vec<Landmark> = Vec::new();
    for ListedLandmark { line, label, position } in listed {
        let arteries =
            arteries_of(&label).map_err(|hint| Fault::line(line, format!("label \"{label}\""), format!("{hint}{ACCEPTED}")))?;
        if let Some(first) = out.iter().find(|other| other.arteries == arteries) {
            return Err(Fault::line(line, format!("label \"{label}\", as on line {}", first.line), "expected every label once"));
        }
        out.push(Landmark { line, label, arteries, position });
    }
    Ok(out)
}

/// The arteries of the label of a landmark, sorted; `None` for one that names no place of a circle.
pub fn sites_of_label(label: &str) -> Option<Vec<Artery>> {
    arteries_of(label).ok()
}

/// The arteries of a label, sorted. The error is a hint at the intended name.
fn arteries_of(label: &str) -> Result<Vec<Artery>, String> {
    let meant = |part: &str| {
        let names: Vec<String> = Artery::all().map(|artery| artery.to_string()).collect();
        did_you_mean(part, names.iter().map(String::as_str))
    };
    let named = label.split('/').map(|part| artery_of_label(part, LabelScheme::Names).ok_or_else(|| meant(part)));
    let mut arteries: Vec<Artery> = named.collect::<Result<_, _>>()?;
    arteries.sort_unstable();
    arteries.dedup();
    if sites(&arteries).is_empty() { Err(String::new()) } else { Ok(arteries) }
}

/// The meaning of a landmark of these arteries; empty where they are neither inlet nor outlet and do not meet in a circle.
pub(crate) fn sites(arteries: &[Artery]) -> Vec<Site> {
    if let [single] = arteries {
        return match *single {
            Artery::Ica(s) => vec![Site::Ica(s)],
            Artery::M1(s) | Artery::Mca(s) => vec![Site::M1(s)],
            Artery::A2(s) | Artery::Aca(s) => vec![Site::A2(s)],
            Artery::P2(s) | Artery::Pca(s) => vec![Site::P2(s)],
            Artery::Va(_) | Artery::Ba => vec![Site::Feeder],
            Artery::ThirdA2 => vec![Site::Third],
            Artery::A1(_) | Artery::P1(_) | Artery::PComm(_) | Artery::AComm => vec![],
        };
    }
    let has = |artery: Artery| arteries.contains(&artery);
    let feeds = |artery: &Artery| matches!(artery, Artery::Ba | Artery::Va(_));
    if arteries.iter().all(feeds) {
        return vec![Site::Feeder];
    }
    let mut sites = Vec::new();
    for s in Side::BOTH {
        let anterior = [Artery::A1(s), Artery::A2(s), Artery::Aca(s)].into_iter().filter(|a| has(*a)).count();
        let posterior = [Artery::P1(s), Artery::P2(s), Artery::Pca(s)].into_iter().filter(|a| has(*a)).count();
        let middle = has(Artery::M1(s)) || has(Artery::Mca(s));
        if has(Artery::Ica(s)) || (middle && anterior > 0) {
            sites.push(Site::Carotid(s));
        } else if anterior > 1 || (anterior == 1 && has(Artery::AComm)) {
            sites.push(Site::Anterior(s));
        } else if !has(Artery::Ba) && (posterior > 1 || (posterior == 1 && has(Artery::PComm(s)))) {
            sites.push(Site::Posterior(s));
        }
    }
    let p1 = |a: &Artery| matches!(a, Artery::P1(_) | Artery::Pca(_));
    if has(Artery::Ba) && arteries.iter().any(p1) || arteries.iter().filter(|a| p1(a)).count() == 2 && sites.is_empty() {
        sites.push(Site::Tip);
    }
    sites
}

impl Site {
    /// Whether it is an inlet or outlet rather than a bifurcation.
    pub fn is_end(self) -> bool {
        matches!(self, Self::Ica(_) | Self::M1(_) | Self::A2(_) | Self::P2(_) | Self::Feeder | Self::Third)
    }

    /// Sets its node.
    pub fn put(self, points: &mut Points, node: usize) {
        match self {
            Self::Ica(s) => points.ica[s.index()] = Some(node),
            Self::M1(s) => points.m1[s.index()] = Some(node),
            Self::A2(s) => points.a2[s.index()] = Some(node),
            Self::P2(s) => points.p2[s.index()] = Some(node),
            Self::Feeder => points.feeders.push(node),
            Self::Third => points.third = Some(node),
            Self::Carotid(s) => points.carotid[s.index()].push(node),
            Self::Tip => points.tip = Some(node),
            Self::Posterior(s) => points.posterior[s.index()] = Some(node),
            Self::Anterior(s) => points.anterior[s.index()] = Some(node),
        }
    }
}

/// A node within this distance, m, is taken even if it is not a free end.
const EXACT: f64 = 0.001;

/// The nearest free end within reach that is not `taken`. It is an end of the observed vessels, where there are any.
pub(crate) fn free_end(network: &Network, at: Point, taken: &dyn Fn(usize) -> bool) -> Option<Nearest> {
    let observed = observed_degrees(network);
    let degree = if observed.iter().any(|degree| *degree > 0) { observed } else { network.degrees(|_| true) };
    nearest_node(network, at, |row| degree[row] == 1 && !taken(row)).filter(|end| end.distance <= REACH)
}

fn observed_degrees(network: &Network) -> Vec<usize> {
    network.degrees(|vessel| vessel.origin == Origin::Observed)
}

/// The node of a landmark: the nearest one, for an inlet or outlet the nearest free end where one is near.
pub(crate) fn nearest_node_of(network: &Network, landmark: &Landmark) -> Result<Nearest, Fault> {
    let at = landmark.position;
    let away = distance_to_lines(network, at);
    if away > REACH {
        return Err(Fault::line(
            landmark.line,
            format!("\"{}\" lies {:.1} mm from the nearest centerline", landmark.label, millimetres(away)),
            format!("expected a position within {} mm, in the axes of the network's file", millimetres(REACH)),
        ));
    }
    let all = network.degrees(|_| true);
    let observed = observed_degrees(network);
    // A node at which a candidate splits a vessel has no anatomical meaning.
    let splits_vessel = |row: usize| observed[row] == 2 && all[row] > 2;
    let any = nearest_node(network, at, |row| all[row] > 0 && !splits_vessel(row))
        .or_else(|| nearest_node(network, at, |row| all[row] > 0));
    let is_end = sites(&landmark.arteries).iter().any(|site| site.is_end());
    if is_end
        && any.is_some_and(|any| any.distance > EXACT)
        && let Some(end) = free_end(network, at, &|_| false)
    {
        return Ok(end);
    }
    any.ok_or_else(|| Fault::file("the nodes have no coordinates", "expected positions, or vessels with labels and no landmarks"))
}

/// The distance (m) to the nearest point of any vessel.
fn distance_to_lines(network: &Network, at: Point) -> f64 {
    let straight = |ends: [usize; 2]| ends.into_iter().filter_map(|node| network.node(node).position).collect::<Vec<_>>();
    let of = |(ends, vessel): ([usize; 2], &crate::network::Vessel)| {
        let points: Vec<Point> =
            if vessel.path.is_empty() { straight(ends) } else { vessel.path.iter().map(|p| p.position).collect() };
        points.windows(2).map(|pair| to_segment(pair[0], pair[1], at)).fold(f64::INFINITY, f64::min)
    };
    network.vessels().map(of).fold(f64::INFINITY, f64::min)
}

fn to_segment(a: Point, b: Point, at: Point) -> f64 {
    let (along, square) = (sub(b, a), norm_squared(sub(b, a)));
    let share = if square > 0.0 { (dot(sub(at, a), along) / square).clamp(0.0, 1.0) } else { 0.0 };
    distance(lerp(a, b, share), at)
}

/// Below this product of unit vectors the arteries are too nearly in one plane for a decision.
const TOO_FLAT: f64 = 0.05;

/// Whether left and right look exchanged in right-handed axes: rightward · (forward x upward) is negative.
///
/// Rightward is from the left artery of every pair to the right one, forward from P2 or the basilar artery to A2, upward from the
/// carotid to M1 and A1. `None` where too few arteries are known.
pub(crate) fn sides_look_exchanged(at: &BTreeMap<Artery, Point>) -> Option<bool> {
    let mean = |arteries: &[Artery]| -> Option<Point> {
        let points: Vec<Point> = arteries.iter().filter_map(|artery| at.get(artery).copied()).collect();
        let sum = points.iter().fold([0.0; 3], |sum, p| [sum[0] + p[0], sum[1] + p[1], sum[2] + p[2]]);
        (!points.is_empty()).then(|| sum.map(|x| x / points.len() as f64))
    };
    let both = |artery: fn(Side) -> Artery| Side::BOTH.map(artery);
    let mut rightward = [0.0; 3];
    for artery in Artery::PAIRED {
        if let [Some(left), Some(right)] = both(artery).map(|artery| at.get(&artery)) {
            let step = sub(*right, *left);
            rightward = [rightward[0] + step[0], rightward[1] + step[1], rightward[2] + step[2]];
        }
    }
    let front = [both(Artery::A2), both(Artery::Aca), both(Artery::A1)].into_iter().find_map(|pair| mean(&pair))?;
    let back = [both(Artery::P2), both(Artery::Pca), [Artery::Ba; 2]].into_iter().find_map(|pair| mean(&pair))?;
    let top = [both(Artery::M1), both(Artery::Mca), both(Artery::A1)].into_iter().find_map(|pair| mean(&pair))?;
    let bottom = mean(&both(Artery::Ica))?;
    let (ahead, up) = (unit(sub(front, back)), unit(sub(top, bottom)));
    let product = dot(unit(rightward), cross(ahead, up));
    (product.abs() > TOO_FLAT).then_some(product < 0.0)
}
