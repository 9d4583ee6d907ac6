//! Leftist heaps of arcs that meld, and whose keys can all be lowered at once (Crane 1972; Tarjan 1977).

/// Heaps over numbered items; a heap is named by its top.
#[derive(Debug, Clone)]
pub struct Heaps {
    key: Vec<i128>,
    /// To be added to the keys of both subheaps.
    owed: Vec<i128>,
    children: Vec<[Option<usize>; 2]>,
    /// Length of the shortest way down.
    rank: Vec<u32>,
}

impl Heaps {
    /// Every item is a heap of its own.
    pub fn new(key: Vec<i128>) -> Self {
        let items = key.len();
        Self { key, owed: vec![0; items], children: vec![[None; 2]; items], rank: vec![1; items] }
    }

    /// One heap of two; the smaller key is on top, the lower item on ties.
    pub fn meld(&mut self, a: Option<usize>, b: Option<usize>) -> Option<usize> {
        let (Some(a), Some(b)) = (a, b) else { return a.or(b) };
        let (top, below) = if (self.key[a], a) <= (self.key[b], b) { (a, b) } else { (b, a) };
        self.settle(top);
        let right = self.meld(self.children[top][1], Some(below));
        let left = self.children[top][0];
        let rank = |child: Option<usize>| child.map_or(0, |child| self.rank[child]);
        let (low, high) = (rank(left).min(rank(right)), rank(left) >= rank(right));
        self.children[top] = if high { [left, right] } else { [right, left] };
        self.rank[top] = low + 1;
        Some(top)
    }

    /// Takes the top off a heap and lowers all other keys by its own.
    pub fn pop_and_lower(&mut self, top: usize) -> Option<usize> {
        self.owed[top] -= self.key[top];
        self.settle(top);
        let [left, right] = std::mem::take(&mut self.children[top]);
        self.rank[top] = 1;
        self.meld(left, right)
    }

    fn settle(&mut self, item: usize) {
        let owed = std::mem::take(&mut self.owed[item]);
        for child in self.children[item].into_iter().flatten() {
            self.key[child] += owed;
            self.owed[child] += owed;
        }
    }
}
