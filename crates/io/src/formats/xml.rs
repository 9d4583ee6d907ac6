//! Reads XML as a stream of elements and texts, or as a tree: no entities of its own, bounded depth; escapes text.

use std::borrow::Cow;
use std::io::BufRead;

use quick_xml::events::{Event, attributes::Attribute, attributes::Attributes};
use quick_xml::{Error, Reader, XmlVersion, escape::resolve_xml_entity};

use crate::formats::{Fault, ensure, find};

/// The deepest nesting of elements.
const MOST_DEPTH: usize = 256;
/// The most attributes of one element: each is compared with all before it.
const MOST_ATTRIBUTES: usize = 256;
const ACCEPTED: &str = "expected a complete XML file";
const NO_ENTITIES: &str = "expected no entities but those of XML itself";

/// What comes next in a file. An empty element has a start and an end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum XmlStep {
    /// An element begins: see `tag`.
    Start,
    /// The innermost element ends.
    End,
    /// A part of the text within the innermost element, see `part`; comments and references cut a text into parts.
    Text,
}

/// The start of an element.
#[derive(Debug, Clone, Default)]
pub(super) struct Tag {
    /// Its line, counted from 1.
    pub(super) line: usize,
    /// The text between the angle brackets.
    content: String,
    /// The length of the name with its prefix.
    name_length: usize,
}

/// Reads an XML file as a stream, element by element.
pub(super) struct Events<R> {
    reader: Reader<R>,
    /// The bytes of what was read last, with its angle brackets: all but a byte order mark, as long as the reader trims nothing.
    buffer: Vec<u8>,
    /// The line where what comes next begins, and that of the last byte that is no blank, counted from 1.
    line: usize,
    last_line: usize,
    /// The last element that began.
    pub(super) tag: Tag,
    /// The part of a text that was read last.
    part: String,
    /// How many elements are open now.
    pub(super) depth: usize,
    /// Whether the root element has been seen.
    rooted: bool,
}

impl<R: BufRead> Events<R> {
    /// At the start of a file in UTF-8.
    pub(super) fn new(input: R) -> Self {
        let mut reader = Reader::from_reader(input);
        reader.config_mut().expand_empty_elements = true;
        let (tag, part) = (Tag::default(), String::new());
        Self { reader, buffer: Vec::new(), line: 1, last_line: 1, tag, part, depth: 0, rooted: false }
    }

    /// Reads the next start, end or text; `None` at the end of a well-formed file.
    ///
    /// # Errors
    ///
    /// XML that is not well-formed, a document type with declarations, a reference to an entity other than the five
    /// of XML, elements nested too deeply or with too many attributes.
    pub(super) fn next(&mut self) -> Result<Option<XmlStep>, Fault> {
        loop {
            self.count_lines();
            self.buffer.clear();
            let line = self.line;
            let broken = |what: &dyn std::fmt::Display| Fault::line(line, format!("not well-formed XML: {what}"), ACCEPTED);
            let inside = self.depth > 0;
            let outside = || broken(&"text outside of the root element");
            match self.reader.read_event_into(&mut self.buffer) {
                Err(Error::Io(error)) => return Err(Fault::file(format!("cannot be read: {error}"), ACCEPTED)),
                Err(Error::Encoding(_)) => return Err(Fault::line(line, "text that is not UTF-8", "expected UTF-8 text")),
                Err(error) => return Err(broken(&error)),
                Ok(Event::Start(tag)) => {
                    self.tag.line = line;
                    self.tag.name_length = tag.name().into_inner().len();
                    self.tag.content.clear();
                    self.tag.content.push_str(&tag);
                    return self.start().map(|()| Some(XmlStep::Start));
                }
                Ok(Event::End(_)) => {
                    self.depth -= 1;
                    return Ok(Some(XmlStep::End));
                }
                Ok(Event::Text(text)) if inside => text.xml10_content().as_ref().clone_into(&mut self.part),
                Ok(Event::CData(text)) if inside => text.xml10_content().as_ref().clone_into(&mut self.part),
                Ok(Event::GeneralRef(name)) if inside => {
                    self.part.clear();
                    match name.resolve_char_ref().map_err(|error| broken(&error))? {
                        Some(c) => self.part.push(c),
                        None => self.part.push_str(
                            resolve_xml_entity(&name)
                                .ok_or_else(|| Fault::line(line, format!("the entity &{};", &*name), NO_ENTITIES))?,
                        ),
                    }
                }
                Ok(Event::Text(text)) if text.trim_ascii().is_empty() => continue,
                Ok(Event::Text(_) | Event::CData(_) | Event::GeneralRef(_)) => return Err(outside()),
                Ok(Event::DocType(text)) if text.contains('[') => {
                    return Err(Fault::line(line, "a document type with declarations of its own", NO_ENTITIES));
                }
                Ok(Event::Eof) if inside || !self.rooted => {
                    let what = if inside { "the file ends within an element" } else { "no element" };
                    return Err(Fault::line(self.last_line, format!("not well-formed XML: {what}"), ACCEPTED));
                }
                Ok(Event::Eof) => return Ok(None),
                Ok(Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::Empty(_) | Event::DocType(_)) => continue,
            }
            return match self.part.bytes().find(|b| is_forbidden(*b)) {
                None => Ok(Some(XmlStep::Text)),
                Some(byte) => Err(broken(&format!("character {byte} in a text"))),
            };
        }
    }

    /// Counts the lines of what was read last.
    fn count_lines(&mut self) {
        let ends = |part: &[u8]| part.iter().fold(0, |sum, byte| sum + usize::from(*byte == b'\n'));
        self.line += ends(&self.buffer);
        if let Some(last) = self.buffer.iter().rposition(|byte| !byte.is_ascii_whitespace()) {
            self.last_line = self.line - ends(&self.buffer[last..]);
        }
    }

    /// Checks the element that begins.
    fn start(&mut self) -> Result<(), Fault> {
        let fault = |what: String, accepted: &str| Fault::line(self.tag.line, what, accepted);
        let wrong = || fault("not well-formed XML: a second root element".to_owned(), ACCEPTED);
        ensure(self.depth > 0 || !self.rooted, wrong)?;
        (self.depth, self.rooted) = (self.depth + 1, true);
        let wrong = || fault(format!("more than {MOST_DEPTH} elements within one another"), "expected fewer");
        ensure(self.depth <= MOST_DEPTH, wrong)?;
        for (count, attribute) in Attributes::new(&self.tag.content, self.tag.name_length).enumerate() {
            let wrong = || fault(format!("an element with more than {MOST_ATTRIBUTES} attributes"), "expected fewer");
            ensure(count < MOST_ATTRIBUTES, wrong)?;
            attribute.map_err(|error| fault(format!("not well-formed XML: {error}"), ACCEPTED))?;
        }
        Ok(())
    }

    /// Goes on to the next element within the one at `depth`; false at the end of that one.
    pub(super) fn next_child(&mut self, depth: usize) -> Result<bool, Fault> {
        while self.depth >= depth {
            match self.next()? {
                Some(XmlStep::Start) => return Ok(true),
                Some(_) => {}
                None => break,
            }
        }
        Ok(false)
    }

    /// Skips the rest of the innermost element; `seen` is called for every element within it.
    pub(super) fn skip(&mut self, seen: impl FnMut(&Tag) -> Result<(), Fault>) -> Result<(), Fault> {
        self.text(seen, &mut String::new())
    }

    /// Reads the text directly within the innermost element into `out`, up to its end; `seen` is called for every
    /// element within it.
    pub(super) fn text(&mut self, mut seen: impl FnMut(&Tag) -> Result<(), Fault>, out: &mut String) -> Result<(), Fault> {
        out.clear();
        let depth = self.depth;
        while self.depth >= depth {
            match self.next()? {
                Some(XmlStep::Text) if self.depth == depth => out.push_str(&self.part),
                Some(XmlStep::Start) => seen(&self.tag)?,
                Some(_) => {}
                None => break,
            }
        }
        Ok(())
    }
}

impl Tag {
    /// Its name without prefix.
    pub(super) fn name(&self) -> &str {
        self.content[..self.name_length].rsplit(':').next().unwrap_or_default()
    }

    /// The value of an attribute, its references resolved.
    ///
    /// # Errors
    ///
    /// A reference to another entity than the five of XML, or to a character that XML forbids.
    pub(super) fn attribute(&self, name: &str) -> Result<Option<Cow<'_, str>>, Fault> {
        self.raw().find(|a| a.key.as_ref() == name).map(|a| self.value(&a)).transpose()
    }

    /// All attributes by name.
    ///
    /// # Errors
    ///
    /// Those of [`Tag::attribute`].
    pub(super) fn attributes(&self) -> Result<Vec<(String, String)>, Fault> {
        self.raw().map(|a| Ok((a.key.into_inner().to_owned(), self.value(&a)?.into_owned()))).collect()
    }

    /// The attributes, which were checked when the element began.
    fn raw(&self) -> impl Iterator<Item = Attribute<'_>> {
        let mut all = Attributes::new(&self.content, self.name_length);
        all.with_checks(false);
        all.flatten()
    }

    fn value<'a>(&self, attribute: &Attribute<'a>) -> Result<Cow<'a, str>, Fault> {
        let name = attribute.key.into_inner();
        let value = attribute.normalized_value(XmlVersion::Implicit1_0);
        let value = value.map_err(|error| Fault::line(self.line, format!("attribute {name}: {error}"), NO_ENTITIES))?;
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

/// The most elements of a file that is read as a tree.
const MOST_ELEMENTS: usize = 1 << 18;

/// An element with all that is in it.
pub(super) struct Element {
    /// Its name without prefix.
    pub(super) name: String,
    /// The name of the element around it; empty for the root.
    pub(super) within: String,
    /// The text directly within it.
    pub(super) text: String,
    attributes: Vec<(String, String)>,
    /// Its child elements.
    pub(super) children: Vec<Element>,
}

impl Element {
    /// The root element of a file.
    ///
    /// # Errors
    ///
    /// Those of [`Events::next`], or more elements than any file has.
    pub(super) fn root(bytes: &[u8]) -> Result<Self, Fault> {
        let mut events = Events::new(bytes);
        // The innermost open element is the last one; a closed one goes to the element around it.
        let (mut open, mut count, mut root) = (Vec::<Self>::new(), 0, None);
        while let Some(step) = events.next()? {
            match step {
                XmlStep::Start => {
                    let tag = &events.tag;
                    count += 1;
                    let wrong = || Fault::line(tag.line, format!("more than {MOST_ELEMENTS} elements"), "expected fewer");
                    ensure(count <= MOST_ELEMENTS, wrong)?;
                    let within = open.last().map(|parent| parent.name.clone()).unwrap_or_default();
                    let (name, attributes) = (tag.name().to_owned(), tag.attributes()?);
                    open.push(Self { name, within, text: String::new(), attributes, children: Vec::new() });
                }
                XmlStep::End => match (open.pop(), open.last_mut()) {
                    (Some(closed), Some(parent)) => parent.children.push(closed),
                    (closed, _) => root = closed,
                },
                XmlStep::Text => {
                    if let Some(element) = open.last_mut() {
                        element.text.push_str(&events.part);
                    }
                }
            }
        }
        // A stream without a root element ends in a fault.
        root.ok_or_else(|| Fault::file("no element", "expected a complete XML file"))
    }

    /// Its child elements with a name.
    pub(super) fn named(&self, name: &str) -> impl Iterator<Item = &Self> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// An attribute; empty when there is none.
    pub(super) fn attribute(&self, name: &str) -> &str {
        self.attributes.iter().find(|(key, _)| key == name).map_or("", |(_, value)| value)
    }
}

/// The local name of the root element and the text of its start tag, if the bytes look like XML.
pub(crate) fn root(bytes: &[u8]) -> Option<(&str, &str)> {
    let mut rest = bytes.trim_ascii_start();
    loop {
        let end: &[u8] = match rest {
            [b'<', b'?', ..] => b"?>",
            [b'<', b'!', b'-', b'-', ..] => b"-->",
            // The declarations of a document type are in brackets.
            [b'<', b'!', ..] if find(rest, b"[") < find(rest, b">") && find(rest, b"[").is_some() => b"]>",
            [b'<', b'!', ..] => b">",
            [b'<', ..] => break,
            _ => return None,
        };
        rest = rest.get(find(rest, end)? + end.len()..)?.trim_ascii_start();
    }
    let tag = rest.get(1..find(rest, b">").unwrap_or(rest.len()))?;
    let name = tag.split(|b| b.is_ascii_whitespace() || *b == b'/').next()?;
    let name = name.rsplit(|b| *b == b':').next()?;
    Some((std::str::from_utf8(name).ok()?, std::str::from_utf8(tag).ok()?))
}

/// Escapes text for element content and attribute values; characters that XML forbids become U+FFFD.
pub fn escape(text: &str) -> Cow<'_, str> {
    let is_plain = |c: char| !matches!(c, '&' | '<' | '>' | '"' | '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}');
    if text.chars().all(is_plain) {
        return text.into();
    }
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' => out.push_str("&#9;"),
            '\n' => out.push_str("&#10;"),
            '\r' => out.push_str("&#13;"),
            '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out.into()
}
