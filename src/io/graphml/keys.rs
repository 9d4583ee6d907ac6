//! The attributes that a GraphML file declares.

use std::collections::{BTreeMap, HashMap};
use std::io::BufRead;

use crate::error::Fault;
use crate::io::attributes::is_wanted;
use crate::io::attributes::records::Records;
use crate::io::xml::events::{Events, Step};

/// All attributes by their ids, in the order in which they were met.
#[derive(Default)]
pub(crate) struct Keys {
    number_of: BTreeMap<String, usize>,
    keys: Vec<Key>,
}

/// An attribute: its name (none for what only an editor needs), its default for nodes and for edges.
struct Key {
    name: Option<String>,
    default: Option<String>,
    on: String,
    declared: bool,
    /// The line on which it was met.
    line: usize,
}

impl Keys {
    /// Reads a `<key>`, which has begun, up to its end.
    pub(crate) fn declare(&mut self, events: &mut Events<impl BufRead>) -> Result<(), Fault> {
        let (tag, line) = (events.tag(), events.tag().line);
        let id = tag.attribute("id")?.ok_or_else(|| Fault::line(line, "a <key> has no id", "expected an id"))?;
        let number = self.number(&id, line);
        if self.keys[number].declared {
            return Err(Fault::line(line, format!("key \"{id}\" is declared twice"), "expected every key once"));
        }
        let on = tag.attribute("for")?.map_or_else(|| "all".to_owned(), Into::into);
        let name = tag.attribute("attr.name")?.map(Into::into);
        let mut default = None;
        let depth = events.depth();
        while events.depth() >= depth {
            match events.next()? {
                Some(Step::Start) if events.tag().name() == "default" && default.is_none() => {
                    events.text(|_| Ok(()), default.insert(String::new()))?;
                }
                Some(Step::Start) => events.skip(|_| Ok(()))?,
                Some(_) => {}
                None => break,
            }
        }
        self.keys[number] = Key { name, default, on, declared: true, line };
        Ok(())
    }

    /// Whether what a key names is read; that is known once it is declared.
    pub(crate) fn is_wanted(&self, number: usize) -> bool {
        let key = &self.keys[number];
        !key.declared || key.name.as_deref().is_some_and(is_wanted)
    }

    /// The number of a key, which may be declared later.
    pub(crate) fn number(&mut self, id: &str, line: usize) -> usize {
        if let Some(number) = self.number_of.get(id) {
            return *number;
        }
        self.number_of.insert(id.to_owned(), self.keys.len());
        self.keys.push(Key { name: None, default: None, on: String::new(), declared: false, line });
        self.keys.len() - 1
    }

    /// Gives the records of all nodes (`on` "node") or edges ("edge") the names and defaults.
    pub(crate) fn name(&self, records: &mut Records, on: &str) -> Result<(), Fault> {
        let undeclared = |(_, number): &(&String, &usize)| !self.keys[**number].declared;
        if let Some((id, number)) = self.number_of.iter().filter(undeclared).min_by_key(|(_, number)| **number) {
            let found = format!("key \"{id}\" is not declared");
            return Err(Fault::line(self.keys[*number].line, found, "expected the id of a <key> element"));
        }
        let mut defaults = HashMap::new();
        for key in self.number_of.values().map(|number| &self.keys[*number]).filter(|key| key.on == "all" || key.on == on) {
            if let (Some(name), Some(default)) = (&key.name, &key.default) {
                defaults.insert(name.clone(), default.clone());
            }
        }
        records.name(self.keys.iter().map(|key| key.name.clone()).collect(), defaults);
        Ok(())
    }
}
