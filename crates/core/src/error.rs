//! What can go wrong, worded for the person who has to mend it: file, place, value, accepted form.

use std::path::{Path, PathBuf};
use std::{fmt, io};

/// The result of everything in this crate that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Where in an input the fault lies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of a text file, counted from 1.
    Line(usize),
    /// A named item: a vessel, a node, an XML element, an array.
    Item(String),
}

impl Place {
    /// The place in words, such as "line 2".
    pub fn words(&self) -> String {
        match self {
            Self::File => "the file".to_owned(),
            Self::Line(line) => format!("line {line}"),
            Self::Item(item) => item.clone(),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Item(item) => write!(f, ": {item}"),
        }
    }
}

/// A fault in the content of an input, before the reader knows the file's name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Where it is.
    pub place: Place,
    /// What was found there.
    pub found: String,
    /// What is accepted instead.
    pub accepted: String,
}

impl Fault {
    /// A fault of the whole file.
    pub fn file(found: impl Into<String>, accepted: impl Into<String>) -> Self {
        Self::at(Place::File, found, accepted)
    }

    /// A fault on a line, counted from 1.
    pub fn line(line: usize, found: impl Into<String>, accepted: impl Into<String>) -> Self {
        Self::at(Place::Line(line), found, accepted)
    }

    /// A fault of a named item.
    pub fn item(item: impl Into<String>, found: impl Into<String>, accepted: impl Into<String>) -> Self {
        Self::at(Place::Item(item.into()), found, accepted)
    }

    /// A fault at a place.
    pub fn at(place: Place, found: impl Into<String>, accepted: impl Into<String>) -> Self {
        let place = if let Place::Item(item) = place { Place::Item(one_line(item)) } else { place };
        Self { place, found: one_line(found), accepted: one_line(accepted) }
    }

    /// The error for the file `path`.
    pub fn in_file(self, path: &Path) -> Error {
        Error::Input { path: path.to_owned(), place: self.place, found: self.found, accepted: self.accepted }
    }
}

/// More characters than anybody reads of what a file holds in the wrong place.
const MOST: usize = 400;

/// Text that may come from a file, as part of a message in one line: without control characters, cut where it is long.
fn one_line(text: impl Into<String>) -> String {
    let text = text.into();
    if text.len() <= MOST && !text.chars().any(char::is_control) {
        return text;
    }
    let cut = if text.chars().nth(MOST).is_some() { "\u{2026}" } else { "" };
    text.chars().take(MOST).map(|c| if c.is_control() { '\u{fffd}' } else { c }).chain(cut.chars()).collect()
}

/// Everything that can fail.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The content of an input file is wrong.
    #[error("{}{found}; {accepted}", before(path, place))]
    Input {
        /// The file; empty for a network that was handed over.
        path: PathBuf,
        /// Where in it.
        place: Place,
        /// What was found.
        found: String,
        /// What is accepted instead.
        accepted: String,
    },
    /// An argument or parameter is out of its range.
    #[error("{name}{}{value}: {accepted}", if value.is_empty() { "" } else { " " })]
    Parameter {
        /// The option or field.
        name: String,
        /// Its value as given.
        value: String,
        /// What is accepted instead.
        accepted: String,
    },
    /// A file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: io::Error,
    },
    /// The output is there already.
    #[error("{}: exists already; choose another `output` or give `force` to replace it", path.display())]
    Exists {
        /// The file or folder.
        path: PathBuf,
    },
    /// No pressures were found that meet Kirchhoff's law.
    #[error("the conductances lie too far apart for the solver; try another `solver`: lanes, gradients or reference")]
    Breakdown,
    /// Some subjects of a cohort failed; the rest stands.
    #[error("{failed} of {total} subject{} failed", if *total == 1 { "" } else { "s" })]
    Subjects {
        /// Subjects that failed.
        failed: usize,
        /// Subjects in all.
        total: usize,
    },
    /// A cohort was stopped from outside.
    #[error("stopped with {done} of {total} subjects done{}", kept_in(path.as_deref()))]
    StoppedCohort {
        /// The folder of the cohort; none where nothing is kept.
        path: Option<PathBuf>,
        /// Subjects that are done.
        done: usize,
        /// Subjects in all.
        total: usize,
    },
    /// The run was stopped from outside; what was finished is kept.
    #[error("stopped after {done} of {total} samples, which are kept in {}; the same command goes on from there", path.display())]
    StoppedAndKept {
        /// Samples finished.
        done: u64,
        /// Samples asked for.
        total: u64,
        /// The hidden folder that keeps them.
        path: PathBuf,
    },
    /// The run was stopped from outside.
    #[error("stopped after {done} of {total} samples; nothing was written")]
    Stopped {
        /// Samples finished.
        done: u64,
        /// Samples asked for.
        total: u64,
    },
}

/// What a message begins with: the file, where there is one, and the place.
fn before(path: &Path, place: &Place) -> String {
    let text = format!("{}{place}: ", path.display());
    if path.as_os_str().is_empty() { text.trim_start_matches([':', ' ']).to_owned() } else { text }
}

/// A number as it is, or by its power of ten where it would have dozens of digits.
pub fn in_few_digits(text: String) -> String {
    match text.parse::<f64>() {
        Ok(number) if text.len() > 24 && number.is_finite() => format!("{number:e}"),
        _ => text,
    }
}

/// Where the subjects that are done are kept, in words.
fn kept_in(path: Option<&Path>) -> String {
    let goes_on = |path: &Path| format!(" in {}; the same command goes on from there", path.display());
    path.map_or_else(|| "; nothing is written".to_owned(), goes_on)
}

impl Error {
    /// A parameter out of its range.
    pub fn parameter(name: impl Into<String>, value: impl fmt::Display, accepted: impl Into<String>) -> Self {
        Self::Parameter { name: name.into(), value: one_line(in_few_digits(value.to_string())), accepted: one_line(accepted) }
    }

    /// Whether the person who called can mend it by changing the input or an argument.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::Input { .. } | Self::Parameter { .. } | Self::Read { .. } | Self::Exists { .. })
    }
}

/// Refuses the value of a field, unless something holds.
///
/// # Errors
///
/// Names the field, its value and what is accepted.
pub fn require(holds: bool, name: &str, value: impl fmt::Display, accepted: impl Into<String>) -> Result<()> {
    if holds { Ok(()) } else { Err(Error::parameter(name, value, accepted)) }
}

/// Goes on where something is as it has to be.
///
/// # Errors
///
/// The fault, where it is not.
pub fn ensure<E>(is_right: bool, fault: impl FnOnce() -> E) -> Result<(), E> {
    if is_right { Ok(()) } else { Err(fault()) }
}
