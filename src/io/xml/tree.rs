//! Counts the line ends of a text while it is read.

use std::io::{self, BufRead, Read};

use super::events::{Events, Step};
use crate::error::Fault;

/// A text, and how many of its line ends have passed.
pub(crate) struct Lines<R> {
    inner: R,
    /// Line ends that have passed.
    pub(crate) passed: usize,
    /// Those since the last byte that is no blank.
    pub(crate) trailing: usize,
}

impl<R> Lines<R> {
    /// At the start of a text.
    pub(crate) fn new(inner: R) -> Self {
        Self { inner, passed: 0, trailing: 0 }
    }
}

impl<R: BufRead> Read for Lines<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.inner.read(out)
    }
}

impl<R: BufRead> BufRead for Lines<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.inner.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        let passed = self.inner.fill_buf().unwrap_or_default();
        let passed = &passed[..amount.min(passed.len())];
        let ends = |part: &[u8]| part.iter().fold(0, |sum, b| sum + usize::from(*b == b'\n'));
        let all = ends(passed);
        self.passed += all;
        match passed.iter().rposition(|b| !b.is_ascii_whitespace()) {
            Some(last) => self.trailing = ends(&passed[last..]),
            None => self.trailing += all,
        }
        self.inner.consume(amount);
    }
}

/// Elements at the most: more than any file has that is read as a tree.
const MOST_ELEMENTS: usize = 1 << 18;

/// An element with all that is in it.
#[derive(Debug)]
pub(in crate::io) struct Element {
    /// Its name without prefix.
    pub(in crate::io) name: String,
    /// The name of the element around it; empty for the root.
    pub(in crate::io) within: String,
    /// The text that stands directly within it.
    pub(in crate::io) text: String,
    attributes: Vec<(String, String)>,
    children: Vec<Element>,
}

impl Element {
    /// The root element of a file.
    ///
    /// # Errors
    ///
    /// Those of [`Events::next`], or more elements than any file has.
    pub(in crate::io) fn root(bytes: &[u8]) -> Result<Self, Fault> {
        let mut events = Events::new(bytes);
        // The innermost open element is the last one; a closed one goes to the element around it.
        let (mut open, mut count, mut root) = (Vec::<Self>::new(), 0, None);
        while let Some(step) = events.next()? {
            match step {
                Step::Start => {
                    let tag = events.tag();
                    count += 1;
                    if count > MOST_ELEMENTS {
                        return Err(Fault::line(tag.line, format!("more than {MOST_ELEMENTS} elements"), "expected fewer"));
                    }
                    let within = open.last().map(|parent| parent.name.clone()).unwrap_or_default();
                    let (name, attributes) = (tag.name().to_owned(), tag.attributes()?);
                    open.push(Self { name, within, text: String::new(), attributes, children: Vec::new() });
                }
                Step::End => match (open.pop(), open.last_mut()) {
                    (Some(closed), Some(parent)) => parent.children.push(closed),
                    (closed, _) => root = closed,
                },
                Step::Text => {
                    if let Some(element) = open.last_mut() {
                        element.text.push_str(events.part());
                    }
                }
            }
        }
        // A stream without a root element ends in a fault.
        root.ok_or_else(|| Fault::file("no element", "expected a complete XML file"))
    }

    /// The elements directly within it.
    pub(in crate::io) fn children(&self) -> impl Iterator<Item = &Self> {
        self.children.iter()
    }

    /// Those of a name.
    pub(in crate::io) fn named(&self, name: &str) -> impl Iterator<Item = &Self> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// An attribute; empty when there is none.
    pub(in crate::io) fn attribute(&self, name: &str) -> &str {
        self.attributes.iter().find(|(key, _)| key == name).map_or("", |(_, value)| value)
    }
}
