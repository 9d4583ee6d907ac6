//! Landmarks: points that a person set at inlets, outlets and bifurcations of arteries, and their nodes in a network.

use super::arteries::{Artery, BodySide};
use super::labels::{MeantArteries, meaning_of};
use super::segments_by_landmarks::Points;
use willis_core::error::{Fault, Place, ensure};
use willis_core::network::{Frame, NearestNode, Network, Origin, REACH, nearest_node, units::millimetres};
use willis_core::support::geometry::{Point, onto};
use willis_core::support::suggestions::did_you_mean;
use willis_io::formats::{LandmarkList, ListedLandmark};

/// A point on an artery.
#[derive(Debug, Clone, PartialEq)]
pub struct Landmark {
    /// Its line or control point in the file.
    pub place: Place,
    /// Its label as given.
    pub label: String,
    /// The artery whose inlet or outlet it is, or the arteries that meet there, sorted.
    pub arteries: Vec<Artery>,
    /// Whether it is where arteries meet, not where one enters or leaves. M1 and M2 meet, and count as one.
    pub meet: bool,
    /// Its position, m.
    pub position: Point,
}

impl Landmark {
    /// What it means in a circle.
    pub(crate) fn sites(&self) -> Vec<Site> {
        sites(&self.arteries, self.meet)
    }
}

/// The meaning of a landmark in a circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Site {
    /// Inlet of an internal carotid.
    Ica(BodySide),
    /// Outlet of M1.
    M1(BodySide),
    /// Outlet of A2.
    A2(BodySide),
    /// Outlet of P2.
    P2(BodySide),
    /// Inlet of a vertebral or of the basilar artery.
    Feeder,
    /// Outlet of a third A2.
    Third,
    /// Bifurcation of a carotid.
    Carotid(BodySide),
    /// End of the basilar artery.
    Tip,
    /// Where PComm meets the posterior cerebral artery.
    Posterior(BodySide),
    /// Where AComm meets the anterior cerebral artery.
    Anterior(BodySide),
    /// Where M1 divides.
    Middle(BodySide),
}

const ACCEPTED: &str = "expected an inlet (L-ICA, R-ICA, L-VA, R-VA, BA), an outlet (L-M1, L-A2, L-P2, 3rd-A2, ...) or a bifurcation \
                        (L-ICA/L-M1/L-A1, L-ICA/L-PComm, L-A1/L-A2/AComm, L-P1/L-P2/L-PComm, BA/L-P1/R-P1, ...)";

/// The arteries of the landmarks in a file.
///
/// # Errors
///
/// A label that is not accepted, or is given twice; but M2 has several branches, which may have one each.
pub fn identify_landmarks(listed: Vec<ListedLandmark>) -> Result<Vec<Landmark>, Fault> {
    let mut out: Vec<Landmark> = Vec::new();
    for ListedLandmark { place, label, position } in listed {
        let wrong = |hint| Fault::at(place.clone(), format!("label \"{label}\""), format!("{hint}{ACCEPTED}"));
        let (arteries, meet) = named(&label).map_err(wrong)?;
        let is_branch = matches!(sites(&arteries, meet)[..], [Site::M1(_)]);
        let same = |other: &Landmark| other.arteries == arteries && other.meet == meet;
        if let Some(first) = out.iter().find(|other| same(other) && (!is_branch || other.position == position)) {
            let on = if matches!(place, Place::Line(_)) { "on " } else { "" };
            let found = format!("label \"{label}\", as {on}{}", first.place.words());
            return Err(Fault::at(place, found, "expected every label once, but that of M2, once a branch"));
        }
        out.push(Landmark { place, label, arteries, meet, position });
    }
    Ok(out)
}

/// The meaning of a label. The error is a hint at the intended name.
fn named(label: &str) -> Result<MeantArteries, String> {
    let Some((arteries, meet)) = meaning_of(label) else {
        let names: Vec<String> = Artery::all().map(|artery| artery.to_string()).collect();
        let wrong = label.split('/').find(|part| meaning_of(part).is_none()).unwrap_or(label);
        return Err(did_you_mean(wrong, names.iter().map(String::as_str)));
    };
    if sites(&arteries, meet).is_empty() { Err(String::new()) } else { Ok((arteries, meet)) }
}

/// The landmarks of a file in the axes of a network, with notes on the frame.
///
/// Where the file states its frame and the network does not, both readings are tried: the one is taken in which the landmarks lie nearer
/// to the vessels, at the median.
pub fn in_axes_of(network: &Network, list: LandmarkList) -> (Vec<ListedLandmark>, Vec<String>) {
    let LandmarkList { mut landmarks, frame, mut notes, .. } = list;
    let Some(name) = frame.name() else { return (landmarks, notes) };
    let is_known = network.frame.is_known();
    let other = if frame == Frame::Lps { Frame::Ras } else { Frame::Lps };
    let to = if is_known {
        network.frame
    } else {
        let away = [frame, other].map(|to| {
            let at = landmarks.iter().map(|landmark| distance_to_lines(network, frame.turn(to, landmark.position)));
            let mut away: Vec<f64> = at.collect();
            away.sort_by(f64::total_cmp);
            away.get(away.len() / 2).copied().unwrap_or_default()
        });
        let to = if away[1] < away[0] { other } else { frame };
        let [near, far] = [away[0].min(away[1]), away[0].max(away[1])].map(millimetres);
        let taken = to.name().unwrap_or_default();
        let unclear = if near > UNCLEAR * far { ", and hardly further the other way, so look at left and right" } else { "" };
        notes.push(format!(
            "landmarks are in {name}, and the input states no frame: it is taken as {taken}, in which they lie {near:.1} mm from the \
             vessels at the median, against {far:.1} mm{unclear}"
        ));
        to
    };
    if to != frame && is_known {
        notes.push(format!("landmarks are turned from {name} to {}, the frame of the input", to.name().unwrap_or_default()));
    }
    for landmark in &mut landmarks {
        landmark.position = frame.turn(to, landmark.position);
    }
    (landmarks, notes)
}

/// Of two readings of the frame, the better one is hardly better where its distance is more than this share of the other one's.
const UNCLEAR: f64 = 0.5;

/// The meaning of a landmark of these arteries, which `meet` there or end there; empty where they are neither inlet nor outlet and do not
/// meet in a circle.
pub(crate) fn sites(arteries: &[Artery], meet: bool) -> Vec<Site> {
    if let ([Artery::M1(side)], true) = (arteries, meet) {
        return vec![Site::Middle(*side)];
    }
    if let [single] = arteries {
        return match *single {
            Artery::Ica(s) => vec![Site::Ica(s)],
            Artery::M1(s) | Artery::M2(s) | Artery::Mca(s) => vec![Site::M1(s)],
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
    for s in BodySide::BOTH {
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
        self.is_outlet() || matches!(self, Self::Ica(_) | Self::Feeder)
    }

    /// Whether blood leaves there.
    pub fn is_outlet(self) -> bool {
        matches!(self, Self::M1(_) | Self::A2(_) | Self::P2(_) | Self::Third)
    }

    /// Sets its node.
    pub fn put(self, points: &mut Points, node: usize) {
        match self {
            Self::Ica(s) => points.ica[s.index()] = Some(node),
            Self::M1(s) if points.m1[s.index()].is_some() => points.m2[s.index()].push(node),
            Self::M1(s) => points.m1[s.index()] = Some(node),
            Self::A2(s) => points.a2[s.index()] = Some(node),
            Self::P2(s) => points.p2[s.index()] = Some(node),
            Self::Feeder => points.feeders.push(node),
            Self::Third => points.third = Some(node),
            Self::Carotid(s) => points.carotid[s.index()].push(node),
            Self::Tip => points.tip = Some(node),
            Self::Posterior(s) => points.posterior[s.index()] = Some(node),
            Self::Anterior(s) => points.anterior[s.index()] = Some(node),
            Self::Middle(s) => points.middle[s.index()] = Some(node),
        }
    }
}

/// A node within this distance, m, is taken even if it is not a free end.
const EXACT: f64 = 0.001;
/// A landmark of an inlet or outlet is far from a free end beyond this distance, m.
const FAR: f64 = 0.005;
/// A landmark lies on a vessel up to this distance from it, m.
const ON_VESSEL: f64 = 0.002;

/// Whether an artery enters or leaves at the node of a landmark of an inlet or outlet, as far as is seen; not where its vessel is seen to run
/// on beyond the landmark, nor at an outlet that is no free end. With a note where no free end is near.
pub(crate) fn end_of(network: &Network, landmark: &Landmark, nearest: &NearestNode) -> (bool, Option<String>) {
    let is_outlet = landmark.sites().iter().any(|site| site.is_outlet());
    let (label, id, away) = (&landmark.label, &network.node(nearest.node).id, millimetres(nearest.distance));
    let what = if is_outlet { "outlet" } else { "inlet" };
    if degrees_of_ends(network)[nearest.node] != 1 {
        let taken = if is_outlet { "no outlet is stated there" } else { "blood is taken to come in there" };
        let note = format!("{label} names an {what}, but the vessel runs on at node {id}, which is no free end: {taken}");
        // A place where several feeders meet is no end, and is not meant as one.
        return (!is_outlet, (!landmark.meet).then_some(note));
    }
    if nearest.distance <= FAR {
        return (true, None);
    }
    let runs_on = distance_to_lines(network, landmark.position) <= ON_VESSEL;
    let far = format!("{label} names an {what}, but the nearest free end, node {id}, is {away:.1} mm away");
    let taken = match (runs_on, is_outlet) {
        (true, true) => "the vessel is taken to run on, and no outlet is stated there",
        (true, false) => "the vessel is taken to run on to it, and blood to come in there",
        (false, _) => "it is taken for that end, and what lies between is not seen",
    };
    (!(runs_on && is_outlet), Some(format!("{far}: {taken}")))
}

/// The degree of every node among the observed vessels, or among all where none is observed.
fn degrees_of_ends(network: &Network) -> Vec<usize> {
    let observed = observed_degrees(network);
    if observed.iter().any(|degree| *degree > 0) { observed } else { network.degrees(|_| true) }
}

/// The nearest free end within reach that is not `taken`. It is an end of the observed vessels, where there are any.
pub(crate) fn free_end(network: &Network, at: Point, taken: &dyn Fn(usize) -> bool) -> Option<NearestNode> {
    let degree = degrees_of_ends(network);
    nearest_node(network, at, |row| degree[row] == 1 && !taken(row)).filter(|end| end.distance <= REACH)
}

fn observed_degrees(network: &Network) -> Vec<usize> {
    network.degrees(|vessel| vessel.origin == Origin::Observed)
}

/// The node of a landmark: the nearest one, for an inlet or outlet the nearest free end where one is near.
pub(crate) fn nearest_node_of(network: &Network, landmark: &Landmark) -> Result<NearestNode, Fault> {
    let at = landmark.position;
    let unplaced = || Fault::file("the nodes have no coordinates", "expected positions, or vessels with labels and no landmarks");
    let away = distance_to_lines(network, at);
    ensure(!away.is_infinite(), unplaced)?;
    if away > REACH {
        return Err(Fault::at(
            landmark.place.clone(),
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
    let is_end = landmark.sites().iter().any(|site| site.is_end());
    if is_end
        && any.is_some_and(|any| any.distance > EXACT)
        && let Some(end) = free_end(network, at, &|_| false)
    {
        return Ok(end);
    }
    any.ok_or_else(unplaced)
}

/// The distance (m) to the nearest point of any vessel; infinite where none has positions.
pub(crate) fn distance_to_lines(network: &Network, at: Point) -> f64 {
    let straight = |ends: [usize; 2]| ends.into_iter().filter_map(|node| network.node(node).position).collect::<Vec<_>>();
    let of = |(ends, vessel): ([usize; 2], &willis_core::network::Vessel)| {
        let points: Vec<Point> =
            if vessel.path.is_empty() { straight(ends) } else { vessel.path.iter().map(|p| p.position).collect() };
        points.windows(2).map(|pair| onto(at, pair[0], pair[1]).1).fold(f64::INFINITY, f64::min)
    };
    network.vessels().map(of).fold(f64::INFINITY, f64::min)
}
