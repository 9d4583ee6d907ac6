//! Shuffles a list with the random numbers of the tests.

use crate::draw::Draw;

impl Draw {
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}
