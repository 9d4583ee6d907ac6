//! The maximum spanning forest of resilience, equal to the minimum spanning forest of 1/ρ, by Kruskal's algorithm.

/// The memory of Kruskal's algorithm for one worker.
#[derive(Debug, Clone, Default)]
pub struct Kruskal {
    keys: Vec<u64>,
    parent: Vec<u32>,
}

impl Kruskal {
    /// Forgets the vessels of the last sample.
    pub fn clear(&mut self) {
        self.keys.clear();
    }

    /// Adds a diffused vessel by its key.
    pub fn add(&mut self, key: u64) {
        self.keys.push(key);
    }

    /// Calls `take` for each vessel of the maximum spanning forest, largest resilience first; `row` tells where a key's vessel is among `ends`.
    pub fn grow(&mut self, nodes: usize, ends: &[[usize; 2]], row: impl Fn(u64) -> usize, mut take: impl FnMut(usize)) {
        self.keys.sort_unstable_by(|a, b| b.cmp(a));
        self.parent.clear();
        self.parent.extend(0..nodes as u32);
        for key in &self.keys {
            let vessel = row(*key);
            let [a, b] = ends[vessel].map(|node| root(&mut self.parent, node as u32));
            if a != b {
                self.parent[a.max(b) as usize] = a.min(b);
                take(vessel);
            }
        }
    }
}

/// The root of a node's tree, halving the path on the way.
pub fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        parent[node as usize] = parent[parent[node as usize] as usize];
        node = parent[node as usize];
    }
    node
}
