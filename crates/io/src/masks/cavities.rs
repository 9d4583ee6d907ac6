//! Cavities of a mask: background that nothing connects to the outside, such as a voxel that a segmenter left out within a vessel.

use std::{collections::BTreeMap, collections::VecDeque, ops::Range};

use petgraph::unionfind::UnionFind;
use serde::{Deserialize, Serialize};

use super::{Foreground, Mask, distances, indices_of};
use willis_core::support::numbered::marked;

/// What is done with the cavities of a mask, and with its specks. Thinning keeps a cavity as a closed surface, of which the skeleton makes
/// dozens of loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Cavities {
    /// Cavities become part of the vessel around them, specks are left out, and what can be no mask of vessels is refused.
    #[default]
    Fill,
    /// The lines have the topology of the mask.
    Keep,
}

/// The cavities that were filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Filled {
    /// How many.
    pub cavities: usize,
    /// Of how many voxels together.
    pub voxels: usize,
    /// How many are wider than half of the vessel around them, and than one or two voxels.
    pub wide: usize,
}

/// Voxels of the background side by side along the first axis.
struct Run {
    voxels: Range<usize>,
    is_outside: bool,
}

impl Mask {
    /// Fills the cavities: background that no faces of voxels connect to the border of the image. Each voxel takes the class of the wall
    /// that is the fewest faces away.
    pub fn fill_cavities(&mut self) -> Filled {
        let cavities = self.cavities();
        if cavities.is_empty() {
            return Filled::default();
        }
        let voxels = cavities.iter().map(Vec::len).sum();
        let layers: Vec<usize> = cavities.iter().map(|cavity| self.fill(cavity)).collect();
        if let Some(walls) = &mut self.walls {
            let mut filled: Vec<u32> = cavities.iter().flatten().map(|voxel| *voxel as u32).collect();
            filled.sort_unstable();
            walls.voxels.retain(|(voxel, _)| filled.binary_search(voxel).is_err());
        }
        let step = self.voxel_volume().cbrt();
        let wide = Foreground::of(self).map_or(0, |vessels| {
            let depths = distances(&vessels, self.spacing());
            let deepest = |cavity: &[usize]| {
                let places = cavity.iter().filter_map(|voxel| vessels.place_of(indices_of(self.shape, *voxel)));
                places.filter_map(|place| vessels.row(place)).map(|row| depths[row]).fold(0.0, f64::max)
            };
            // One layer is a pinhole in a vessel of any width.
            let is_wide = |cavity: &[usize], layers: usize| layers > 1 && 2.0 * layers as f64 * step > deepest(cavity);
            cavities.iter().zip(&layers).filter(|(cavity, layers)| is_wide(cavity, **layers)).count()
        });
        Filled { cavities: cavities.len(), voxels, wide }
    }

    /// The voxels of each cavity, rising; the cavities in no order that matters.
    fn cavities(&self) -> Vec<Vec<usize>> {
        let [x, y, z] = self.shape;
        let mut runs: Vec<Run> = Vec::new();
        let mut first_of_line = Vec::with_capacity(y * z + 1);
        for (line, classes) in self.classes.chunks_exact(x.max(1)).enumerate() {
            first_of_line.push(runs.len());
            let at_border = line % y == 0 || line % y == y - 1 || line / y == 0 || line / y == z - 1;
            let mut at = 0;
            for part in classes.chunk_by(|a, b| (*a == 0) == (*b == 0)) {
                let end = at + part.len();
                if part[0] == 0 {
                    let is_outside = at_border || at == 0 || end == x;
                    runs.push(Run { voxels: line * x + at..line * x + end, is_outside });
                }
                at = end;
            }
        }
        first_of_line.push(runs.len());
        let mut parts: UnionFind<usize> = UnionFind::new(runs.len());
        for line in 0..y * z {
            // The lines beside this one that came before.
            let beside = [(line % y > 0).then(|| line - 1), line.checked_sub(y)];
            for other in beside.into_iter().flatten() {
                let (mut a, mut b) = (first_of_line[line], first_of_line[other]);
                let apart = (line - other) * x;
                while a < first_of_line[line + 1] && b < first_of_line[other + 1] {
                    let (here, there) = (&runs[a].voxels, &runs[b].voxels);
                    if here.start < there.end + apart && there.start + apart < here.end {
                        parts.union(a, b);
                    }
                    if here.end <= there.end + apart { a += 1 } else { b += 1 }
                }
            }
        }
        let labels = parts.into_labeling();
        let outside = runs.iter().zip(&labels).filter(|(run, _)| run.is_outside);
        let is_outside = marked(runs.len(), outside.map(|(_, label)| *label));
        let mut cavities: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (run, label) in runs.iter().zip(&labels).filter(|(_, label)| !is_outside[**label]) {
            cavities.entry(*label).or_default().extend(run.voxels.clone());
        }
        cavities.into_values().collect()
    }

    /// Fills one cavity from its walls inward, and returns in how many layers.
    fn fill(&mut self, cavity: &[usize]) -> usize {
        let [x, y, _] = self.shape;
        // A cavity never touches the border of the image, so that each of its voxels has all neighbours.
        let beside = |voxel: usize| [voxel - x * y, voxel - x, voxel - 1, voxel + 1, voxel + x, voxel + x * y];
        let mut open: VecDeque<(usize, u8, usize)> = VecDeque::new();
        for voxel in cavity {
            let wall = beside(*voxel).map(|next| self.classes[next]).into_iter().find(|class| *class > 0);
            open.extend(wall.map(|class| (*voxel, class, 1)));
        }
        let mut layers = 0;
        while let Some((voxel, class, layer)) = open.pop_front() {
            if self.classes[voxel] == 0 {
                self.classes[voxel] = class;
                layers = layer;
                let inner = beside(voxel).into_iter().filter(|next| self.classes[*next] == 0);
                open.extend(inner.map(|next| (next, class, layer + 1)));
            }
        }
        layers
    }
}
