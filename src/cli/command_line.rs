//! The command line that repeats a run.

use std::path::{Path, PathBuf};

use super::at_work;

/// Options that change no result: those that a value follows, and the others.
const VALUED: [&str; 6] = ["-o", "--output", "--threads", "--checkpoint", "--n-cpus", "--n_cpus"];
const IMMATERIAL: [&str; 7] = ["-q", "--quiet", "-v", "--verbose", "--force", "--json", "--record-failure"];
const NO_VALIDATOR: [&str; 2] = ["--skip-bids-validator", "--skip_bids_validator"];

/// Options of `willis bids` that choose the masks.
const CHOICES: [&str; 5] = ["--participant-label", "--participant_label", "--session-label", "--session_label", "--filter"];

/// This process's command line without the options that change no result, quoted for a shell, with `-o` and an output that is called
/// `again`, where that is not empty: it repeats the run as it stands.
pub fn command_line(again: &str) -> String {
    line_of_words(at_work::words(), again)
}

/// The words `all` of a command line for one `input` alone of those that were `given`, with `options` of its own, by name and value,
/// in the place of those of all.
pub fn row_words(
    mut all: impl Iterator<Item = String>,
    input: &Path,
    given: &[PathBuf],
    options: &[(String, String)],
) -> Vec<String> {
    let own: Vec<(String, &str)> =
        options.iter().map(|(name, value)| (format!("--{}", name.replace('_', "-")), value.as_str())).collect();
    let (mut words, mut input) = (Vec::new(), Some(input.to_string_lossy().into_owned()));
    while let Some(word) = all.next() {
        if own.iter().any(|(name, _)| *name == word) {
            all.next();
        } else if given.iter().any(|path| path.to_string_lossy() == *word) {
            words.extend(input.take());
        } else if !own.iter().any(|(name, _)| is_joined(&word, name)) {
            words.push(word);
        }
    }
    words.extend(own.iter().map(|(name, value)| format!("{name}={value}")));
    words
}

/// The words of `willis infer` for one mask of those that `willis bids` was given; `places` are the words that say which dataset, where to
/// and which level.
pub fn infer_words(given: impl Iterator<Item = String>, input: &str, places: &[String]) -> Vec<String> {
    let (mut words, mut places) = (Vec::new(), places.to_vec());
    let (mut is_infer, mut is_chosen) = (false, false);
    for word in given {
        if word == "bids" && !is_infer {
            is_infer = true;
            words.extend(["infer".to_owned(), input.to_owned()]);
        } else if CHOICES.iter().any(|name| word == *name || is_joined(&word, name)) {
            is_chosen = !word.contains('=');
        } else if is_chosen && !word.starts_with('-') {
            // A value of the choice, which may have several.
        } else if let Some(at) = places.iter().position(|place| *place == word) {
            places.remove(at);
        } else {
            is_chosen = false;
            words.push(word);
        }
    }
    words
}

/// The command line of these words, of which those count that change a result.
pub fn line_of_words(mut rest: impl Iterator<Item = String>, again: &str) -> String {
    let mut words = vec!["willis".to_owned()];
    while let Some(word) = rest.next() {
        let has_value = VALUED.iter().any(|name| is_joined(&word, name));
        if VALUED.contains(&&*word) {
            rest.next();
        } else if !has_value && IMMATERIAL.iter().chain(&NO_VALIDATOR).all(|name| word != *name) {
            words.push(quoted(&word));
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

/// A word as a POSIX shell takes it.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:@%+".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}
