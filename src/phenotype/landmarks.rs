//! Landmarks: where a person saw the in- and outlets of the arteries, and the bifurcations where they meet.

use super::artery::{Artery, Side};
use super::by_points::Points;
use super::labels::{Scheme, artery};
use crate::error::Fault;
use crate::formats::ListedLandmark;
use crate::geometry::Point;
use crate::suggestion::did_you_mean;

/// A point on an artery.
#[derive(Debug, Clone, PartialEq)]
pub struct Landmark {
    /// The line of the file that states it, counted from 1.
    pub line: usize,
    /// Its label as given.
    pub label: String,
    /// The artery whose in- or outlet it is, or the arteries that meet there, sorted.
    pub arteries: Vec<Artery>,
    /// Where, m.
    pub position: Point,
}

/// What a landmark stands for in a circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Site {
    Ica(Side),
    M1(Side),
    A2(Side),
    P2(Side),
    Feeder,
    Third,
    Carotid(Side),
    Tip,
    Posterior(Side),
    Anterior(Side),
}

const ACCEPTED: &str = "expected an inlet (L-ICA, R-ICA, L-VA, R-VA, BA), an outlet (L-M1, L-A2, L-P2, 3rd-A2, ...) or a bifurcation \
                        (L-ICA/L-M1/L-A1, L-ICA/L-PComm, L-A1/L-A2/AComm, L-P1/L-P2/L-PComm, BA/L-P1/R-P1, ...)";

/// The landmarks of a table by the arteries that they are on.
///
/// # Errors
///
/// The line, its label and what is accepted; a label twice.
pub fn identify(listed: Vec<ListedLandmark>) -> Result<Vec<Landmark>, Fault> {
    let mut out: Vec<Landmark> = Vec::new();
    for ListedLandmark { line, label, position } in listed {
        let arteries =
            arteries(&label).map_err(|meant| Fault::line(line, format!("label \"{label}\""), format!("{meant}{ACCEPTED}")))?;
        if let Some(first) = out.iter().find(|other| other.arteries == arteries) {
            return Err(Fault::line(line, format!("label \"{label}\", as on line {}", first.line), "expected every label once"));
        }
        out.push(Landmark { line, label, arteries, position });
    }
    Ok(out)
}

/// The arteries of a label, sorted; where these are no place on a circle, the name that may have been meant.
fn arteries(label: &str) -> Result<Vec<Artery>, String> {
    let meant = |part: &str| {
        let names: Vec<String> = Artery::all().map(|artery| artery.to_string()).collect();
        did_you_mean(part, names.iter().map(String::as_str))
    };
    let named = label.split('/').map(|part| artery(part, Scheme::Names).ok_or_else(|| meant(part)));
    let mut arteries: Vec<Artery> = named.collect::<Result<_, _>>()?;
    arteries.sort_unstable();
    arteries.dedup();
    if sites(&arteries).is_empty() { Err(String::new()) } else { Ok(arteries) }
}

/// What a landmark of these arteries stands for; nothing where they are no in- or outlet and meet nowhere on a circle.
pub(super) fn sites(arteries: &[Artery]) -> Vec<Site> {
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
    /// Whether it is an in- or outlet, where vessels end, rather than a bifurcation.
    pub fn is_end(self) -> bool {
        matches!(self, Self::Ica(_) | Self::M1(_) | Self::A2(_) | Self::P2(_) | Self::Feeder | Self::Third)
    }

    /// Puts it at a node.
    pub fn put(self, points: &mut Points, node: usize) {
        match self {
            Self::Ica(s) => points.ica[s.row()] = Some(node),
            Self::M1(s) => points.m1[s.row()] = Some(node),
            Self::A2(s) => points.a2[s.row()] = Some(node),
            Self::P2(s) => points.p2[s.row()] = Some(node),
            Self::Feeder => points.feeders.push(node),
            Self::Third => points.third = Some(node),
            Self::Carotid(s) => points.carotid[s.row()].push(node),
            Self::Tip => points.tip = Some(node),
            Self::Posterior(s) => points.posterior[s.row()] = Some(node),
            Self::Anterior(s) => points.anterior[s.row()] = Some(node),
        }
    }
}
