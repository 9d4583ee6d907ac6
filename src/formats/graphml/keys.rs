//! The attributes that a GraphML file declares.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};

use super::super::attributes::Records;
use super::super::xml::{Event, Events, Tag};
use crate::error::Fault;

/// All attributes by their ids, in the order in which they were met.
#[derive(Default)]
pub(super) struct Keys<'a> {
    number_of: BTreeMap<Cow<'a, str>, usize>,
    keys: Vec<Key<'a>>,
}

/// An attribute: its name (none for what only an editor needs), its default for nodes and for edges.
struct Key<'a> {
    name: Option<Cow<'a, str>>,
    default: Option<Cow<'a, str>>,
    on: Cow<'a, str>,
    declared: bool,
    /// The line on which it was met.
    line: usize,
}

impl<'a> Keys<'a> {
    /// Reads a `<key>`, which has begun, up to its end.
    pub(super) fn declare(&mut self, tag: &Tag<'a>, events: &mut Events<'a>) -> Result<(), Fault> {
        let line = tag.line;
        let id = tag.attribute("id")?.ok_or_else(|| Fault::line(line, "a <key> has no id", "expected an id"))?;
        let number = self.number(id.clone(), line);
        if self.keys[number].declared {
            return Err(Fault::line(line, format!("key \"{id}\" is declared twice"), "expected every key once"));
        }
        let on = tag.attribute("for")?.unwrap_or(Cow::Borrowed("all"));
        self.keys[number] = Key { name: tag.attribute("attr.name")?, default: None, on, declared: true, line };
        let depth = events.depth();
        while events.depth() >= depth {
            match events.next()? {
                Some(Event::Start(tag)) if tag.name == "default" && self.keys[number].default.is_none() => {
                    self.keys[number].default = Some(events.text(|_| Ok(()))?);
                }
                Some(Event::Start(_)) => events.skip(|_| Ok(()))?,
                Some(_) => {}
                None => break,
            }
        }
        Ok(())
    }

    /// The number of a key, which may be declared later.
    pub(super) fn number(&mut self, id: Cow<'a, str>, line: usize) -> usize {
        *self.number_of.entry(id).or_insert_with(|| {
            self.keys.push(Key { name: None, default: None, on: Cow::Borrowed(""), declared: false, line });
            self.keys.len() - 1
        })
    }

    /// Gives the records of all nodes (`on` "node") or edges ("edge") the names and defaults.
    pub(super) fn name(&self, records: &mut Records, on: &str) -> Result<(), Fault> {
        let undeclared = |(_, number): &(&Cow<str>, &usize)| !self.keys[**number].declared;
        if let Some((id, number)) = self.number_of.iter().filter(undeclared).min_by_key(|(_, number)| **number) {
            let found = format!("key \"{id}\" is not declared");
            return Err(Fault::line(self.keys[*number].line, found, "expected the id of a <key> element"));
        }
        let text = |text: &Option<Cow<str>>| text.as_ref().map(|text| text.to_string());
        let mut defaults = HashMap::new();
        for key in self.number_of.values().map(|number| &self.keys[*number]).filter(|key| key.on == "all" || key.on == on) {
            if let (Some(name), Some(default)) = (text(&key.name), text(&key.default)) {
                defaults.insert(name, default);
            }
        }
        records.name(self.keys.iter().map(|key| text(&key.name)).collect(), defaults);
        Ok(())
    }
}
