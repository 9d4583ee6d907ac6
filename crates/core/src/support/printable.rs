//! Text from files as it may be shown: nothing in it moves the cursor, colours, rings, begins a line or turns the reading direction.

use std::borrow::Cow;

/// The text with every character that a terminal acts on, or that hides or reorders others, as its escape: `\u{1b}`.
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c.escape_default().to_string())
}

/// JSON whose texts are [`printable()`] and mean the same.
pub fn printable_json(json: &str) -> Cow<'_, str> {
    escaped(json, |c| c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")).collect::<Vec<_>>().concat())
}

fn escaped(text: &str, escape: impl Fn(char) -> String) -> Cow<'_, str> {
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if acts(c) { shown += &escape(c) } else { shown.push(c) }
    }
    Cow::Owned(shown)
}

/// Controls, line and paragraph separators, marks of direction, characters without width, tags (Unicode's categories Cc, Zl, Zp and the
/// parts of Cf that text does not need; joiners, which some scripts need, stay).
fn acts(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}')
        || matches!(c, '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}
