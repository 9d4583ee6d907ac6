//! What a person changes of a graph by places in mm: two places joined, vessels that meet parted, a vessel deleted.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::in_few_digits;

/// A place in mm, not m.
pub(super) type MmPoint = [f64; 3];

/// A change of a graph, by places in mm; as text `join 1 2 3 + 4 5 6`, `part 1 2 3 + 4 5 6 | 7 8 9 + 10 11 12`, `delete 1 2 3`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Edit {
    /// A vessel goes from the first place to the last, straight or by the places between.
    Join(Vec<MmPoint>),
    /// The vessels at the places of a group go together, and those of different groups do not meet within the ball around all places, but
    /// beyond them. What two groups share is doubled, what joins them and is of none is deleted, candidates too, and where no vessel leads
    /// from a place to the others of its group, a straight one does. Groups of one place cut a vessel off; those that have a place in
    /// common meet there.
    Part(Vec<Vec<MmPoint>>),
    /// The vessel at the place is none.
    Delete(MmPoint),
}

impl Edit {
    /// The words of the edits.
    pub const WORDS: [&'static str; 3] = ["join", "part", "delete"];

    /// An edit by its word and its places: `+` between places, `|` between groups.
    ///
    /// # Errors
    ///
    /// Another word, or other places than it takes: what is expected.
    pub fn parse(word: &str, places: &str) -> Result<Self, &'static str> {
        const POINT: &str = "expected places of three finite numbers of mm, with + between places and | between groups";
        // The sign of a power of ten separates nothing: 1.5e+01.
        let places = places.replace("e+", "e").replace("E+", "E");
        let group = |text: &str| text.split('+').map(place).collect::<Option<Vec<MmPoint>>>();
        let groups: Vec<Vec<MmPoint>> = places.split('|').map(group).collect::<Option<_>>().ok_or(POINT)?;
        match (word, &groups[..]) {
            ("join", [way]) if way.len() > 1 => Ok(Self::Join(way.clone())),
            ("join", _) => Err("expected two places to join, or those of the way between too"),
            ("delete", [one]) if one.len() == 1 => Ok(Self::Delete(one[0])),
            ("delete", _) => Err("expected one place on the vessel to delete"),
            ("part", [_, _, ..]) => Ok(Self::Part(groups)),
            ("part", _) => Err("expected two or more groups of places, with | between them"),
            _ => Err("expected join, part or delete"),
        }
    }

    /// Its word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Join(_) => "join",
            Self::Part(_) => "part",
            Self::Delete(_) => "delete",
        }
    }

    /// Its places as text.
    pub fn places(&self) -> String {
        match self {
            Self::Join(way) => text_of(way),
            Self::Part(groups) => groups.iter().map(|group| text_of(group)).collect::<Vec<String>>().join(" | "),
            Self::Delete(place) => text_of(&[*place]),
        }
    }
}

/// Three finite numbers.
fn place(text: &str) -> Option<MmPoint> {
    let numbers: Vec<f64> =
        text.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

pub(super) fn text_of(places: &[MmPoint]) -> String {
    places.iter().map(|place| place.map(|x| in_few_digits(x.to_string())).join(" ")).collect::<Vec<String>>().join(" + ")
}

impl fmt::Display for Edit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.word(), self.places())
    }
}

impl From<Edit> for String {
    fn from(edit: Edit) -> Self {
        edit.to_string()
    }
}

impl TryFrom<String> for Edit {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let (word, places) = text.split_once(' ').unwrap_or((&text, ""));
        Self::parse(word, places)
    }
}
