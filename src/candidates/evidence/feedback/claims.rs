//! Which bridges compete with each: for the same free end, or the same place on a vessel.

use std::collections::BTreeMap;

use super::super::extraction::Extraction;
use super::super::search::FoundBridge;
use super::super::steady::steady;
use crate::candidates::knn::PointIndex;
use crate::geometry::distance;

/// Two branches leave a vessel at places that are further apart than so many radii and spacings.
const APART_RADII: f64 = 2.0;
const APART_SPACINGS: f64 = 2.0;

/// Per bridge the rows of others.
pub struct Claims {
    /// By which the parent would hang on a third fragment by the free end that is met.
    pub elsewhere: Vec<Vec<usize>>,
    /// By which a third fragment would hang on the child's end.
    pub on_child: Vec<Vec<usize>>,
    /// By which other fragments would hang near the same point, where that is on the way of a vessel.
    pub beside: Vec<Vec<usize>>,
}

impl Claims {
    /// The competitors of each bridge.
    pub fn new(e: &Extraction, bridges: &[FoundBridge]) -> Self {
        let child = |row: usize| e.ends[bridges[row].end].fragment;
        let parent = |row: usize| e.fragment[bridges[row].point];
        let mut from = vec![Vec::new(); e.ends.len()];
        let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (row, bridge) in bridges.iter().enumerate() {
            from[bridge.end].push(row);
            at.entry(bridge.point).or_default().push(row);
        }
        let beside = near_each(e, &at);
        let none = Vec::new();
        let of = |rows: &Vec<usize>, keep: &dyn Fn(usize) -> bool| rows.iter().copied().filter(|row| keep(*row)).collect();
        let each = |claims: &dyn Fn(usize, &FoundBridge) -> Vec<usize>| {
            bridges.iter().enumerate().map(|(row, bridge)| claims(row, bridge)).collect::<Vec<Vec<usize>>>()
        };
        Self {
            elsewhere: each(&|row, bridge| {
                of(e.end_at[bridge.point].map_or(&none, |end| &from[end]), &|other| parent(other) != child(row))
            }),
            on_child: each(&|row, bridge| {
                of(at.get(&e.ends[bridge.end].point).unwrap_or(&none), &|other| child(other) != parent(row))
            }),
            beside: each(&|row, bridge| of(beside.get(&bridge.point).unwrap_or(&none), &|other| child(other) != child(row))),
        }
    }
}

/// Per meeting point on the way of a vessel the bridges that meet its fragment there or near.
fn near_each(e: &Extraction, at: &BTreeMap<usize, Vec<usize>>) -> BTreeMap<usize, Vec<usize>> {
    let points: Vec<usize> = at.keys().copied().collect();
    let index = PointIndex::new(points.iter().map(|point| e.position[*point]).collect());
    let on_the_way = points.iter().copied().filter(|point| e.end_at[*point].is_none());
    let near = on_the_way.map(|point| {
        let apart = APART_RADII * e.smooth.radius[point] + APART_SPACINGS * e.spacing;
        let within = |other: &usize| {
            let off = distance(e.position[*other], e.position[point]);
            e.fragment[*other] == e.fragment[point] && steady(off / e.spacing) <= steady(apart / e.spacing)
        };
        let hits = index.within(e.position[point], apart * (1.0 + 1e-9)).into_iter().map(|(_, hit)| points[hit]);
        (point, hits.filter(within).flat_map(|other| at[&other].iter().copied()).collect())
    });
    near.collect()
}
