//! Elimination of fragments in order of least degree, on a matrix of bits.

/// A fragment at the moment of its elimination.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Star {
    /// The fragment eliminated.
    pub center: usize,
    /// Its neighbours then, in order of number; all are eliminated later.
    pub neighbours: Vec<usize>,
}

/// Takes out the fragment with the fewest neighbours, the lower number on ties, and joins its neighbours, until none is left.
pub fn least_degree(nodes: usize, links: impl Iterator<Item = [usize; 2]>) -> Vec<Star> {
    let words = nodes.div_ceil(64);
    let mut bits = vec![0_u64; nodes * words];
    for [a, b] in links {
        bits[a * words + b / 64] |= 1 << (b % 64);
        bits[b * words + a / 64] |= 1 << (a % 64);
    }
    let count = |row: &[u64]| row.iter().map(|word| word.count_ones()).sum::<u32>();
    let mut degree: Vec<u32> = (0..nodes).map(|node| count(&bits[node * words..(node + 1) * words])).collect();
    let mut left: Vec<usize> = (0..nodes).collect();
    let mut stars = Vec::with_capacity(nodes);
    while let Some((at, center)) = left.iter().copied().enumerate().min_by_key(|(_, node)| (degree[*node], *node)) {
        left.swap_remove(at);
        let around = bits[center * words..(center + 1) * words].to_vec();
        let neighbours = ones(&around);
        for node in &neighbours {
            let row = &mut bits[node * words..(node + 1) * words];
            row.iter_mut().zip(&around).for_each(|(row, around)| *row |= around);
            row[node / 64] &= !(1 << (node % 64));
            row[center / 64] &= !(1 << (center % 64));
            degree[*node] = count(row);
        }
        stars.push(Star { center, neighbours });
    }
    stars
}

/// The numbers of the bits that are set.
fn ones(words: &[u64]) -> Vec<usize> {
    let mut out = Vec::new();
    for (at, word) in words.iter().enumerate() {
        let mut rest = *word;
        while rest != 0 {
            out.push(at * 64 + rest.trailing_zeros() as usize);
            rest &= rest - 1;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: a ring of four with a tail. The tail goes first, then the ring is closed by the edge 1-3.
    #[test]
    fn the_order_and_the_fill_of_a_ring_with_a_tail() {
        let stars = least_degree(5, [[0, 1], [1, 2], [2, 3], [3, 0], [2, 4], [4, 2]].into_iter());
        let star = |center, neighbours: &[usize]| Star { center, neighbours: neighbours.to_vec() };
        assert_eq!(stars, [star(4, &[2]), star(0, &[1, 3]), star(1, &[2, 3]), star(2, &[3]), star(3, &[])]);
    }
}
