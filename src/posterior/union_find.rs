//! Sets that are joined, and parted again in the reverse order.

/// Sets of numbered items, each with a representative.
#[derive(Debug, Clone)]
pub struct UnionFind {
    parent: Vec<usize>,
    size: Vec<usize>,
    /// The representatives that ceased to be ones, in order.
    joined: Vec<usize>,
}

impl UnionFind {
    /// Every item by itself.
    pub fn new(items: usize) -> Self {
        Self { parent: (0..items).collect(), size: vec![1; items], joined: Vec::new() }
    }

    /// The representative of an item's set.
    pub fn find(&self, mut item: usize) -> usize {
        while self.parent[item] != item {
            item = self.parent[item];
        }
        item
    }

    /// Joins two sets; `false` when they are one already.
    pub fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        if a == b {
            return false;
        }
        let (large, small) = if self.size[a] >= self.size[b] { (a, b) } else { (b, a) };
        self.parent[small] = large;
        self.size[large] += self.size[small];
        self.joined.push(small);
        true
    }

    /// How many joins there were and still are.
    pub fn joins(&self) -> usize {
        self.joined.len()
    }

    /// Undoes the last joins until so many are left.
    pub fn roll_back(&mut self, joins: usize) {
        for small in self.joined.drain(joins..).rev() {
            self.size[self.parent[small]] -= self.size[small];
            self.parent[small] = small;
        }
    }
}
