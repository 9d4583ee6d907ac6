//! Which way the axes of coordinates point in the patient, as far as a file says so.

use serde::{Deserialize, Serialize};

use crate::support::Point;

/// The anatomical frame of coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Frame {
    /// The input states none.
    #[default]
    Unknown,
    /// x to the patient's right, y anterior, z superior: NIfTI, and masks in general.
    Ras,
    /// x to the patient's left, y posterior, z superior: DICOM, ITK, the files of 3D Slicer.
    Lps,
}

impl Frame {
    /// The word for it; `None` where it is unknown.
    pub fn name(self) -> Option<&'static str> {
        match self {
            Self::Unknown => None,
            Self::Ras => Some("RAS"),
            Self::Lps => Some("LPS"),
        }
    }

    /// The frame that a word of a file means; unknown for any other word.
    pub fn of_word(word: &str) -> Self {
        match word.trim() {
            "RAS" => Self::Ras,
            "LPS" => Self::Lps,
            _ => Self::Unknown,
        }
    }

    /// The frame that a header of text states as `SPACE=RAS` or `SPACE=LPS`, as 3D Slicer writes it.
    pub fn of_header(text: &str) -> Self {
        text.split_once("SPACE=").map_or(Self::Unknown, |(_, word)| Self::of_word(word.get(..3).unwrap_or_default()))
    }

    /// Whether it is known.
    pub fn is_known(self) -> bool {
        self != Self::Unknown
    }

    /// A position of this frame in another one; as it is where one of the two is not known.
    pub fn turn(self, to: Self, at: Point) -> Point {
        if self == to || !self.is_known() || !to.is_known() {
            return at;
        }
        // No negative zero.
        [0.0 - at[0], 0.0 - at[1], at[2]]
    }
}
