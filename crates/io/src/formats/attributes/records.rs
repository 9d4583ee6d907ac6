//! Stores the attributes of many nodes or edges as text in one buffer: a graph has millions.

use std::collections::HashMap;

use crate::formats::tables::reader::is_missing;

/// The texts of all items under the names of their attributes.
#[derive(Debug, Clone, Default)]
pub(in crate::formats) struct Records {
    /// The names of the attributes by number; none for those that are not read.
    pub(in crate::formats) names: Vec<Option<String>>,
    /// The values of items that state none.
    pub(in crate::formats) defaults: HashMap<String, String>,
    text: String,
    fields: Vec<RecordField>,
    items: Vec<RecordStart>,
}

#[derive(Debug, Clone, Copy)]
struct RecordField {
    name: u32,
    length: u32,
    start: usize,
}

#[derive(Debug, Clone, Copy)]
struct RecordStart {
    line: usize,
    first: usize,
}

/// The attributes of one item.
#[derive(Debug, Clone, Copy)]
pub(in crate::formats) struct Record<'a> {
    all: &'a Records,
    fields: &'a [RecordField],
    /// Its line in the file.
    pub(in crate::formats) line: usize,
}

impl Records {
    /// Without items, of attributes with these names.
    pub(in crate::formats) fn named(names: &[impl AsRef<str>]) -> Self {
        Self { names: names.iter().map(|name| Some(name.as_ref().to_owned())).collect(), ..Self::default() }
    }

    /// Begins an item.
    pub(in crate::formats) fn begin(&mut self, line: usize) {
        self.items.push(RecordStart { line, first: self.fields.len() });
    }

    /// Sets an attribute of the last item; a later value replaces an earlier one.
    pub(in crate::formats) fn put(&mut self, name: usize, text: &str) {
        let text = text.trim();
        self.fields.push(RecordField { name: name as u32, length: text.len() as u32, start: self.text.len() });
        self.text.push_str(text);
    }

    /// Whether there is an attribute of this name.
    pub(in crate::formats) fn has(&self, name: &str) -> bool {
        self.names.iter().flatten().any(|known| known == name)
    }

    /// How many items there are.
    pub(in crate::formats) fn len(&self) -> usize {
        self.items.len()
    }

    /// An item.
    pub(in crate::formats) fn get(&self, row: usize) -> Record<'_> {
        let RecordStart { line, first } = self.items[row];
        let end = self.items.get(row + 1).map_or(self.fields.len(), |next| next.first);
        Record { all: self, fields: &self.fields[first..end], line }
    }

    /// All items.
    pub(in crate::formats) fn iter(&self) -> impl Iterator<Item = Record<'_>> {
        (0..self.len()).map(|row| self.get(row))
    }
}

impl<'a> Record<'a> {
    /// The text of an attribute, trimmed; none where it is missing.
    pub(in crate::formats) fn text(&self, name: &str) -> Option<&'a str> {
        self.word(name).filter(|text| !is_missing(text))
    }

    /// The text of an attribute that is a name, which may be any word; none where it is empty.
    pub(in crate::formats) fn word(&self, name: &str) -> Option<&'a str> {
        let named = |field: &&RecordField| self.all.names[field.name as usize].as_deref() == Some(name);
        let text = match self.fields.iter().rfind(named) {
            Some(field) => &self.all.text[field.start..field.start + field.length as usize],
            None => self.all.defaults.get(name)?.trim(),
        };
        Some(text).filter(|text| !text.is_empty())
    }

    /// The names of the attributes that are not empty.
    pub(in crate::formats) fn names(&self) -> Vec<&'a str> {
        let own = self.fields.iter().filter_map(|field| self.all.names[field.name as usize].as_deref());
        let mut names: Vec<&str> = own.chain(self.all.defaults.keys().map(String::as_str)).collect();
        names.sort_unstable();
        names.dedup();
        names.retain(|name| self.text(name).is_some());
        names
    }
}
