//! An XML text as a stream of elements and texts: no document in memory, no entities of its own, bounded depth.

use std::borrow::Cow;

use quick_xml::events::Event as Raw;
use quick_xml::escape::resolve_xml_entity;
use quick_xml::events::BytesRef;
use quick_xml::events::attributes::{Attribute, Attributes};
use quick_xml::{Reader, XmlVersion};

use crate::error::Fault;

/// Elements within elements at the most.
const MOST_DEPTH: usize = 256;
/// Attributes of one element at the most: each is compared with all before it.
const MOST_ATTRIBUTES: usize = 256;
/// What is said of every text that is not XML.
const ACCEPTED: &str = "expected a complete XML file";

/// The next thing in a file. An empty element has a start and an end.
#[derive(Debug)]
pub(in super::super) enum Event<'a> {
    /// An element begins.
    Start(Tag<'a>),
    /// The innermost element ends.
    End,
    /// A part of the text within the innermost element; comments and references cut a text into parts.
    Text(Cow<'a, str>),
}

/// The start of an element.
#[derive(Debug, Clone)]
pub(in super::super) struct Tag<'a> {
    /// Its name without prefix.
    pub(in super::super) name: &'a str,
    /// Its line, counted from 1.
    pub(in super::super) line: usize,
    /// What stands between the angles.
    content: &'a str,
    /// The length of the name with its prefix.
    whole_name: usize,
}

/// Walks through a text.
pub(in super::super) struct Events<'a> {
    reader: Reader<&'a [u8]>,
    text: &'a str,
    depth: usize,
    /// Whether the root element has been seen.
    rooted: bool,
    /// A place, and the line on which it is.
    counted: (usize, usize),
}

impl<'a> Events<'a> {
    /// At the start of a text without byte order mark.
    pub(in super::super) fn new(text: &'a str) -> Self {
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        Self { reader, text, depth: 0, rooted: false, counted: (0, 1) }
    }

    /// How many elements are open.
    pub(in super::super) fn depth(&self) -> usize {
        self.depth
    }

    /// The next event; `None` at the end of a well-formed text.
    ///
    /// # Errors
    ///
    /// What is not well-formed; a document type with declarations of its own, a reference to another entity than the five
    /// of XML, elements deeper or with more attributes than any file has.
    pub(in super::super) fn next(&mut self) -> Result<Option<Event<'a>>, Fault> {
        loop {
            let start = self.reader.buffer_position() as usize;
            let raw = match self.reader.read_event() {
                Ok(raw) => raw,
                Err(error) => {
                    let at = self.reader.error_position() as usize;
                    return Err(self.broken(at, error));
                }
            };
            return Ok(Some(match raw {
                Raw::Start(_) => self.start(start).map(Event::Start)?,
                Raw::End(_) => {
                    self.depth -= 1;
                    Event::End
                }
                Raw::Text(text) if self.depth > 0 => Event::Text(self.plain(start, text.xml10_content())?),
                Raw::CData(text) if self.depth > 0 => Event::Text(self.plain(start, text.xml10_content())?),
                Raw::Text(text) if text.trim_ascii().is_empty() => continue,
                Raw::GeneralRef(name) if self.depth > 0 => Event::Text(self.reference(start, &name)?),
                Raw::Text(_) | Raw::CData(_) | Raw::GeneralRef(_) => {
                    return Err(self.broken(start, "text outside of the root element"));
                }
                Raw::DocType(text) => {
                    if text.contains('[') {
                        let found = "a document type with declarations of its own";
                        return Err(Fault::line(self.line(start), found, "expected XML without entities"));
                    }
                    continue;
                }
                Raw::Eof if self.depth > 0 => return Err(self.broken(self.text.trim_end().len(), "the file ends within an element")),
                Raw::Eof if !self.rooted => return Err(self.broken(0, "no element")),
                Raw::Eof => return Ok(None),
                Raw::Comment(_) | Raw::Decl(_) | Raw::PI(_) | Raw::Empty(_) => continue,
            }));
        }
    }

    /// Passes what is left of the innermost element; `seen` is shown the elements within it.
    pub(in super::super) fn skip(&mut self, mut seen: impl FnMut(&Tag<'a>) -> Result<(), Fault>) -> Result<(), Fault> {
        let depth = self.depth;
        while self.depth >= depth {
            match self.next()? {
                Some(Event::Start(tag)) => seen(&tag)?,
                Some(_) => {}
                None => break,
            }
        }
        Ok(())
    }

    /// The text that stands directly within the innermost element, up to its end; `seen` is shown the elements within it.
    pub(in super::super) fn text(&mut self, mut seen: impl FnMut(&Tag<'a>) -> Result<(), Fault>) -> Result<Cow<'a, str>, Fault> {
        let depth = self.depth;
        let mut all = Cow::Borrowed("");
        while self.depth >= depth {
            match self.next()? {
                Some(Event::Text(part)) if self.depth == depth => {
                    if all.is_empty() {
                        all = part;
                    } else {
                        all.to_mut().push_str(&part);
                    }
                }
                Some(Event::Start(tag)) => seen(&tag)?,
                Some(_) => {}
                None => break,
            }
        }
        Ok(all)
    }

    fn start(&mut self, start: usize) -> Result<Tag<'a>, Fault> {
        let line = self.line(start);
        if self.depth == 0 && self.rooted {
            return Err(self.broken(start, "a second root element"));
        }
        (self.depth, self.rooted) = (self.depth + 1, true);
        if self.depth > MOST_DEPTH {
            return Err(Fault::line(line, format!("more than {MOST_DEPTH} elements within one another"), "expected fewer"));
        }
        let raw = &self.text[start..self.reader.buffer_position() as usize];
        let raw = raw.strip_prefix('<').and_then(|raw| raw.strip_suffix('>')).unwrap_or_default();
        let content = raw.strip_suffix('/').unwrap_or(raw);
        let whole_name = content.find(|c: char| c.is_ascii_whitespace()).unwrap_or(content.len());
        let name = content[..whole_name].rsplit(':').next().unwrap_or_default();
        let tag = Tag { name, line, content, whole_name };
        for (count, attribute) in Attributes::new(content, whole_name).enumerate() {
            if count == MOST_ATTRIBUTES {
                return Err(Fault::line(line, format!("an element with more than {MOST_ATTRIBUTES} attributes"), "expected fewer"));
            }
            attribute.map_err(|error| self.broken(start, error))?;
        }
        Ok(tag)
    }

    /// One of the five entities of XML, or a character by its number.
    fn reference(&mut self, start: usize, name: &BytesRef<'a>) -> Result<Cow<'a, str>, Fault> {
        if let Some(c) = name.resolve_char_ref().map_err(|error| self.broken(start, error))? {
            return self.plain(start, Cow::Owned(c.to_string()));
        }
        match resolve_xml_entity(name) {
            Some(text) => Ok(Cow::Borrowed(text)),
            None => Err(self.entity(start, name)),
        }
    }

    fn entity(&mut self, at: usize, name: &str) -> Fault {
        Fault::line(self.line(at), format!("the entity &{name};"), "expected no entities but those of XML itself")
    }

    /// A text without the characters that XML forbids.
    fn plain(&mut self, start: usize, text: Cow<'a, str>) -> Result<Cow<'a, str>, Fault> {
        match text.bytes().find(|b| is_forbidden(*b)) {
            None => Ok(text),
            Some(byte) => Err(self.broken(start, format!("character {byte} in a text"))),
        }
    }

    fn broken(&mut self, at: usize, what: impl std::fmt::Display) -> Fault {
        Fault::line(self.line(at), format!("not well-formed XML: {what}"), ACCEPTED)
    }

    /// The line of a place, which is not before the last one asked for, but for errors.
    fn line(&mut self, at: usize) -> usize {
        let newlines = |part: &[u8]| part.iter().filter(|b| **b == b'\n').count();
        let (from, line) = self.counted;
        if at < from {
            return 1 + newlines(&self.text.as_bytes()[..at]);
        }
        let line = line + newlines(self.text.as_bytes().get(from..at).unwrap_or_default());
        self.counted = (at, line);
        line
    }
}

impl<'a> Tag<'a> {
    /// The value of an attribute, its references resolved.
    ///
    /// # Errors
    ///
    /// A reference to another entity than the five of XML, or to a character that XML forbids.
    pub(in super::super) fn attribute(&self, name: &str) -> Result<Option<Cow<'a, str>>, Fault> {
        self.raw().find(|a| a.key.as_ref() == name).map(|a| self.value(&a)).transpose()
    }

    /// All attributes by name.
    ///
    /// # Errors
    ///
    /// Those of [`Tag::attribute`].
    pub(in super::super) fn attributes(&self) -> Result<Vec<(&'a str, Cow<'a, str>)>, Fault> {
        self.raw().map(|a| Ok((a.key.into_inner(), self.value(&a)?))).collect()
    }

    /// The attributes, which were checked when the element began.
    fn raw(&self) -> impl Iterator<Item = Attribute<'a>> {
        let mut all = Attributes::new(self.content, self.whole_name);
        all.with_checks(false);
        all.flatten()
    }

    fn value(&self, attribute: &Attribute<'a>) -> Result<Cow<'a, str>, Fault> {
        let name = attribute.key.into_inner();
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|error| {
            Fault::line(self.line, format!("attribute {name}: {error}"), "expected no entities but those of XML itself")
        })?;
        match value.bytes().find(|b| is_forbidden(*b)) {
            None => Ok(value),
            Some(byte) => Err(Fault::line(self.line, format!("attribute {name}: character {byte}"), ACCEPTED)),
        }
    }
}

/// Whether XML forbids a character.
fn is_forbidden(byte: u8) -> bool {
    byte < b' ' && !b"\t\n\r".contains(&byte)
}
