//! Prints notes about many cases or subjects: each once, with the number of cases that it applies to.

use std::collections::BTreeMap;

use super::{TextTerminal, plural};

/// Up to this many notes of single cases are printed without `--verbose`.
const MOST: usize = 3;

/// Prints each note with the number of cases that it applies to (each a `noun`): those of several cases always, the others with `--verbose`.
pub fn say_notes(terminal: TextTerminal, notes: &BTreeMap<String, usize>, noun: &str) {
    let mut untold = 0;
    for (note, of) in notes {
        let line = format!("{note} ({})", plural(*of, noun));
        if *of > 1 || notes.len() <= MOST {
            terminal.say("note", line);
        } else {
            untold += 1;
            terminal.detail("note", line);
        }
    }
    if untold > 0 {
        terminal.say("note", format!("{} of one {noun} each; -v says them", plural(untold, "further note")));
    }
}

/// Notes counted; those that differ in their figures alone are one, with `…` for these.
pub fn counted<'a>(notes: impl IntoIterator<Item = &'a str>) -> BTreeMap<String, usize> {
    let mut alike: BTreeMap<String, (&str, bool, usize)> = BTreeMap::new();
    for note in notes {
        let (first, is_same, of) = alike.entry(without_figures(note)).or_insert((note, true, 0));
        *is_same &= *first == note;
        *of += 1;
    }
    alike.into_iter().map(|(form, (note, is_same, of))| (if is_same { note.to_owned() } else { form }, of)).collect()
}

/// A note with `…` for every figure, and one word for one thing and several.
fn without_figures(note: &str) -> String {
    let word = |word: &str| {
        let figure = word.trim_matches(['(', ')', ',', ';', ':']);
        let is_figure =
            figure.starts_with(|c: char| c.is_ascii_digit() || c == '-') && figure.ends_with(|c: char| c.is_ascii_digit());
        match (is_figure, word) {
            (true, _) => word.replace(figure, "…"),
            (_, "point" | "vessel" | "link" | "edge") => format!("{word}s"),
            _ => word.to_owned(),
        }
    };
    note.split(' ').map(word).collect::<Vec<_>>().join(" ")
}
