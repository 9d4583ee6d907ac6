//! The command line that repeats a run.

use std::path::{Path, PathBuf};

/// Options that change no result, with whether a value follows.
const IMMATERIAL: [(&str, bool); 12] = [
    ("-o", true),
    ("--output", true),
    ("--threads", true),
    // The shards of a run have its command, which merge records.
    ("--range", true),
    ("--checkpoint", true),
    ("-q", false),
    ("--quiet", false),
    ("-v", false),
    ("--verbose", false),
    ("--force", false),
    ("--json", false),
    ("--record-failure", false),
];

/// This process's command line without the options that change no result, quoted for a shell, with `-o` and an output that is called
/// `again`, where that is not empty: it repeats the run as it stands.
pub fn command_line(again: &str) -> String {
    written(|word| Some(word.to_owned()), again)
}

/// The same for one `input` alone of those that were given.
pub fn command_line_of(input: &Path, given: &[PathBuf]) -> String {
    let mut own = Some(input.to_string_lossy().into_owned());
    written(|word| if given.iter().any(|g| g.to_string_lossy() == *word) { own.take() } else { Some(word.to_owned()) }, "again")
}

/// The command line with every word that counts as `wording` has it.
fn written(mut wording: impl FnMut(&str) -> Option<String>, again: &str) -> String {
    let mut words = vec!["willis".to_owned()];
    let mut rest = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    while let Some(word) = rest.next() {
        match IMMATERIAL.iter().find(|(name, value)| word == *name || (*value && is_joined(&word, name))) {
            Some((name, true)) if word == *name => drop(rest.next()),
            Some(_) => {}
            None => words.extend(wording(&word).map(|word| quoted(&word))),
        }
    }
    if !again.is_empty() {
        words.extend(["-o".to_owned(), again.to_owned()]);
    }
    words.join(" ")
}

/// `--output=x` or `-ox`.
fn is_joined(word: &str, name: &str) -> bool {
    word.strip_prefix(name).is_some_and(|rest| rest.starts_with('=') || !name.starts_with("--"))
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:@%+".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A POSIX shell splits the line into the same words again.
    #[test]
    fn a_line_is_its_words() {
        let words = ["willis", "infer", "it's a scan.swc", "", "--bc", "{}.bc.csv", r"a\b", "''", "-n=64"];
        let line = words.map(quoted).join(" ");
        assert_eq!(line, r"willis infer 'it'\''s a scan.swc' '' --bc '{}.bc.csv' 'a\b' ''\'''\''' -n=64");
    }
}
