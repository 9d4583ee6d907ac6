//! A small XML file as a tree of elements, whose texts are borrowed from it.

use std::borrow::Cow;

use super::{Event, Events};
use crate::error::Fault;

/// Elements at the most: more than any file has that is read as a tree.
const MOST_ELEMENTS: usize = 1 << 18;

/// An element with all that is in it.
#[derive(Debug)]
pub(in super::super) struct Element<'a> {
    /// Its name without prefix.
    pub(in super::super) name: &'a str,
    /// The name of the element around it; empty for the root.
    pub(in super::super) within: &'a str,
    /// The text that stands directly within it.
    pub(in super::super) text: Cow<'a, str>,
    attributes: Vec<(&'a str, Cow<'a, str>)>,
    children: Vec<Element<'a>>,
}

impl<'a> Element<'a> {
    /// The root element of a text.
    ///
    /// # Errors
    ///
    /// Those of [`Events::next`], or more elements than any file has.
    pub(in super::super) fn root(text: &'a str) -> Result<Self, Fault> {
        let mut events = Events::new(text);
        let (mut open, mut count) = (Vec::<Self>::new(), 0);
        // The innermost open element is the last one; a closed one goes to the element around it.
        let mut root = None;
        while let Some(event) = events.next()? {
            match event {
                Event::Start(tag) => {
                    count += 1;
                    if count > MOST_ELEMENTS {
                        return Err(Fault::line(tag.line, format!("more than {MOST_ELEMENTS} elements"), "expected fewer"));
                    }
                    let (within, text) = (open.last().map_or("", |parent| parent.name), Cow::Borrowed(""));
                    let attributes = tag.attributes()?;
                    open.push(Self { name: tag.name, within, text, attributes, children: Vec::new() });
                }
                Event::End => match (open.pop(), open.last_mut()) {
                    (Some(closed), Some(parent)) => parent.children.push(closed),
                    (closed, _) => root = closed,
                },
                Event::Text(part) => match open.last_mut() {
                    Some(element) if element.text.is_empty() => element.text = part,
                    Some(element) => element.text.to_mut().push_str(&part),
                    None => {}
                },
            }
        }
        // A stream without a root element ends in a fault.
        root.ok_or_else(|| Fault::file("no element", "expected a complete XML file"))
    }

    /// The elements directly within it.
    pub(in super::super) fn children(&self) -> impl Iterator<Item = &Self> {
        self.children.iter()
    }

    /// Those of a name.
    pub(in super::super) fn named(&self, name: &str) -> impl Iterator<Item = &Self> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// An attribute; empty when there is none.
    pub(in super::super) fn attribute(&self, name: &str) -> &str {
        self.attributes.iter().find(|(key, _)| *key == name).map_or("", |(_, value)| value)
    }
}
