//! What the XML formats share: the name of the root element, a stream of elements and texts, escaping.

pub(crate) mod events;
pub(crate) mod tree;

use std::borrow::Cow;

/// The local name of the root element and the text of its start tag, if the bytes look like XML.
pub(crate) fn root(bytes: &[u8]) -> Option<(&str, &str)> {
    let mut rest = bytes.trim_ascii_start();
    loop {
        let end: &[u8] = match rest {
            [b'<', b'?', ..] => b"?>",
            [b'<', b'!', b'-', b'-', ..] => b"-->",
            // What a document type declares stands in brackets.
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

/// Where `needle` starts first.
pub(crate) fn find(bytes: &[u8], needle: &[u8]) -> Option<usize> {
    bytes.windows(needle.len()).position(|w| w == needle)
}

/// Escapes text for element content and attribute values; characters that XML forbids become U+FFFD.
pub(crate) fn escape(text: &str) -> Cow<'_, str> {
    let stands = |c: char| !matches!(c, '&' | '<' | '>' | '"' | '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}');
    if text.chars().all(stands) {
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
