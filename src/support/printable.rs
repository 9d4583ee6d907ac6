//! Text from files as it may be shown: nothing in it moves the cursor, colours, rings, begins a line or turns the reading direction.

use std::borrow::Cow;
use std::fmt::Write;

/// The text with every character that a terminal acts on, or that hides or reorders others, as its escape: `\u{1b}`.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| if acts(c) { c.escape_default().to_string() } else { c.to_string() };
    Cow::Owned(text.chars().map(shown).collect())
}

/// JSON whose texts are [`printable()`] and mean the same.
pub fn printable_json(json: &str) -> Cow<'_, str> {
    if !json.contains(acts) {
        return Cow::Borrowed(json);
    }
    let mut shown = String::with_capacity(json.len());
    let mut units = [0; 2];
    for c in json.chars() {
        if acts(c) {
            for unit in c.encode_utf16(&mut units) {
                // Writing to a string cannot fail.
                let _ = write!(shown, "\\u{unit:04x}");
            }
        } else {
            shown.push(c);
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_on_a_terminal_is_escaped_and_the_rest_stays() {
        assert_eq!(printable("A. cerebri média 中"), "A. cerebri média 中");
        assert_eq!(printable("a\u{1b}[2Jb\u{7}\u{9b}1m"), "a\\u{1b}[2Jb\\u{7}\\u{9b}1m");
        assert_eq!(printable("gnp\u{202e}exe.\n"), "gnp\\u{202e}exe.\\n");
        for c in (0..=0x10_ffff).filter_map(char::from_u32).filter(|c| c.is_control()) {
            assert!(!printable(&c.to_string()).contains(c), "{c:?}");
        }
    }

    #[test]
    fn json_means_the_same() {
        let value = serde_json::json!({ "id": "a\u{202e}\u{e0041}\u{7f}\u{9b}b" });
        let shown = printable_json(&value.to_string()).into_owned();
        assert!(!shown.contains(acts));
        assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).expect("JSON"), value);
    }
}
