//! The anatomical names of the links of centerlines.

use std::collections::BTreeMap;

/// The anatomical names of links; most have none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Labels {
    names: Vec<String>,
    row_of: BTreeMap<String, u32>,
    /// Per link the row of its name plus one; 0, or beyond the end, for none.
    of_link: Vec<u32>,
}

impl Labels {
    /// Names a link; an empty name is none.
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

    /// The name of a link; empty where it has none.
    pub fn of(&self, link: usize) -> &str {
        match self.of_link.get(link) {
            None | Some(0) => "",
            Some(row) => &self.names[*row as usize - 1],
        }
    }
}
