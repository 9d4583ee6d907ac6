//! Centerlines as read from a file: points with radii, linked into polylines, before anything is a vessel.

use std::collections::{BTreeMap, BTreeSet};

use super::Frame;
use crate::support::Point;

/// Points with radii and the links between consecutive ones. Lengths in m.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Centerlines {
    /// Which way the axes of the positions point.
    pub frame: Frame,
    /// Positions, m.
    pub points: Vec<Point>,
    /// Radii, m, as in the file: NaN, zero and negative values are missing radii.
    pub radii: Vec<f64>,
    /// The point's number in the file (SWC index, VTP row).
    pub ids: Vec<u64>,
    /// The tree (SWC, VTP lines that share points) or polyline to which a point belongs.
    pub strand: Vec<u32>,
    /// Pairs of linked points.
    pub links: Vec<[u32; 2]>,
    /// The anatomical labels of the links.
    pub labels: Labels,
    /// Points that were merged with another: their numbers in the file, and the row of the other.
    pub merged: Vec<(u64, u32)>,
    /// The numbers of the points where a vessel leaves the image.
    pub at_border: BTreeSet<u64>,
    /// The numbers of the points that the file states as its source: all its lines start there.
    pub sources: BTreeSet<u64>,
    /// The number of the point that is the root of the only tree of the file.
    pub root: Option<u64>,
}

impl Centerlines {
    /// Adds a point (m) of a strand and returns its row.
    pub fn add_point(&mut self, position: Point, radius: f64, id: u64, strand: u32) -> u32 {
        self.points.push(position);
        self.radii.push(radius);
        self.ids.push(id);
        self.strand.push(strand);
        self.points.len() as u32 - 1
    }

    /// Links two points, with an anatomical label unless it is empty.
    pub fn add_link(&mut self, ends: [u32; 2], label: &str) {
        self.links.push(ends);
        if !label.is_empty() {
            self.labels.set(self.links.len() - 1, label);
        }
    }
}

/// Whether a radius is usable: finite and positive.
pub fn is_radius(r: f64) -> bool {
    r.is_finite() && r > 0.0
}

/// The anatomical labels of links; most have none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Labels {
    names: Vec<String>,
    row_of: BTreeMap<String, u32>,
    /// Per link the row of its label plus one; 0, or beyond the end, for none.
    of_link: Vec<u32>,
}

impl Labels {
    /// Labels a link; an empty label removes it.
    pub fn set(&mut self, link: usize, name: &str) {
        if name.is_empty() {
            if let Some(slot) = self.of_link.get_mut(link) {
                *slot = 0;
            }
            return;
        }
        let row = *self.row_of.entry(name.to_owned()).or_insert_with(|| {
            self.names.push(name.to_owned());
            self.names.len() as u32 - 1
        });
        if self.of_link.len() <= link {
            self.of_link.resize(link + 1, 0);
        }
        self.of_link[link] = row + 1;
    }

    /// Puts another text in the place of each label; an empty one removes it.
    pub fn rename(&mut self, of: impl Fn(&str) -> String) {
        self.names.iter_mut().for_each(|name| *name = of(name));
        self.row_of = self.names.iter().cloned().zip(0..).collect();
    }

    /// The label of a link; empty if it has none.
    pub fn of(&self, link: usize) -> &str {
        match self.of_link.get(link) {
            None | Some(0) => "",
            Some(row) => &self.names[*row as usize - 1],
        }
    }
}
