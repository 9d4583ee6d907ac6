//! Converts between SI units, used inside, and millimetres, mmHg, mL/min and cP, used in files.
//!
//! Each pair multiplies in one direction and divides in the other, so that a number written and read again gives the same SI
//! value to the last bit.
//!
//! And which way the axes of coordinates point in the patient, as far as a file says so.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::support::Point;

/// Pascal in one millimetre of mercury, exactly as conventionally defined.
pub const PASCAL_PER_MMHG: f64 = 133.322_387_415;
const ML_PER_MIN_PER_SI: f64 = 6e7;
const SI_PER_MMHG_S_PER_ML: f64 = PASCAL_PER_MMHG * 1e6;

/// m from mm.
pub fn metres(mm: f64) -> f64 {
    mm / 1e3
}

/// mm from m.
pub fn millimetres(m: f64) -> f64 {
    m * 1e3
}

/// ms from s.
pub fn milliseconds(seconds: f64) -> f64 {
    seconds * 1e3
}

/// The largest coordinate that is accepted, m.
pub const MOST_METRES: f64 = 1e9;

/// The length (m) after it was written to a file in millimetres and read again.
pub fn as_stored(m: f64) -> f64 {
    metres(millimetres(m))
}

/// Pa from mmHg.
pub const fn pascals(mmhg: f64) -> f64 {
    mmhg * PASCAL_PER_MMHG
}

/// mmHg from Pa.
pub fn mmhg(pascals: f64) -> f64 {
    pascals / PASCAL_PER_MMHG
}

/// m³/s from mL/min.
pub const fn cubic_metres_per_second(ml_per_min: f64) -> f64 {
    ml_per_min / ML_PER_MIN_PER_SI
}

/// mL/min from m³/s.
pub fn ml_per_min(cubic_metres_per_second: f64) -> f64 {
    cubic_metres_per_second * ML_PER_MIN_PER_SI
}

/// Pa s/m³ from mmHg·s/mL.
pub fn pascal_seconds_per_cubic_metre(mmhg_s_per_ml: f64) -> f64 {
    mmhg_s_per_ml * SI_PER_MMHG_S_PER_ML
}

/// mmHg·s/mL from Pa s/m³.
pub fn mmhg_s_per_ml(pascal_seconds_per_cubic_metre: f64) -> f64 {
    pascal_seconds_per_cubic_metre / SI_PER_MMHG_S_PER_ML
}

/// m³/Pa from mL/mmHg.
pub fn cubic_metres_per_pascal(ml_per_mmhg: f64) -> f64 {
    ml_per_mmhg / SI_PER_MMHG_S_PER_ML
}

/// mL/mmHg from m³/Pa.
pub fn ml_per_mmhg(cubic_metres_per_pascal: f64) -> f64 {
    cubic_metres_per_pascal * SI_PER_MMHG_S_PER_ML
}

/// Pa from MPa.
pub fn megapascals(mpa: f64) -> f64 {
    mpa * 1e6
}

/// MPa from Pa.
pub fn in_megapascals(pascals: f64) -> f64 {
    pascals / 1e6
}

/// Pa/m² from mmHg/mm².
pub fn pascals_per_square_metre(mmhg_per_mm2: f64) -> f64 {
    mmhg_per_mm2 * (PASCAL_PER_MMHG * 1e6)
}

/// mmHg/mm² from Pa/m².
pub fn mmhg_per_mm2(pascals_per_square_metre: f64) -> f64 {
    pascals_per_square_metre / (PASCAL_PER_MMHG * 1e6)
}

/// Pa s from cP.
pub fn pascal_seconds(centipoise: f64) -> f64 {
    centipoise / 1e3
}

/// cP from Pa s.
pub fn centipoise(pascal_seconds: f64) -> f64 {
    pascal_seconds * 1e3
}

/// The unit of the coordinates and radii in an input file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum LengthUnit {
    /// Millimetres, the default for every format.
    #[default]
    #[serde(rename = "mm")]
    Millimetre,
    /// Micrometres.
    #[serde(rename = "um")]
    Micrometre,
    /// Centimetres.
    #[serde(rename = "cm")]
    Centimetre,
    /// Metres.
    #[serde(rename = "m")]
    Metre,
    /// Voxels, made millimetres by [`Scale::spacing`].
    #[serde(rename = "voxel")]
    Voxel,
}

/// How the coordinates and radii of an input file become millimetres.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Scale {
    /// The file's unit.
    pub unit: LengthUnit,
    /// Voxel spacing in mm along x, y and z; needed with [`LengthUnit::Voxel`].
    #[serde(rename = "spacing_mm")]
    pub spacing: Option<[f64; 3]>,
}

/// A spacing as it is typed.
fn words(spacing: [f64; 3]) -> String {
    let given = spacing.map(|x| x.to_string());
    if given.iter().all(|x| *x == given[0]) { given[0].clone() } else { given.join(",") }
}

impl LengthUnit {
    /// The unit that a file names, in any of the ways of its writers; the sign of micro has two characters, a third form where a file is
    /// not UTF-8, and its number in ImageJ.
    pub fn named(word: &str) -> Option<Self> {
        match word {
            "mm" | "millimeter" | "millimetre" => Some(Self::Millimetre),
            "um" | "µm" | "μm" | "\u{fffd}m" | "\\u00B5m" | "\\u00b5m" | "micron" | "microns" | "micrometer" | "micrometre" => {
                Some(Self::Micrometre)
            }
            "cm" => Some(Self::Centimetre),
            "m" => Some(Self::Metre),
            _ => None,
        }
    }

    /// The unit's usual abbreviation.
    pub fn symbol(self) -> &'static str {
        // In the order of the variants.
        ["mm", "um", "cm", "m", "voxel"][self as usize]
    }

    /// Its length, mm; of a voxel 1.
    pub fn mm(self) -> f64 {
        match self {
            Self::Millimetre | Self::Voxel => 1.0,
            Self::Micrometre => 1e-3,
            Self::Centimetre => 10.0,
            Self::Metre => 1e3,
        }
    }
}

impl Scale {
    /// Refuses a spacing that is missing, superfluous or not positive.
    ///
    /// # Errors
    ///
    /// Names the option, its value and what is accepted.
    pub fn validate(&self) -> Result<()> {
        match (self.unit, self.spacing) {
            (LengthUnit::Voxel, None) => {
                let accepted = "needs `spacing=S` or `spacing=SX,SY,SZ`, in mm; a mask is in mm, without a unit";
                Err(Error::parameter("units", "voxel", accepted))
            }
            (LengthUnit::Voxel | LengthUnit::Millimetre, Some(s)) if s.iter().any(|x| !x.is_finite() || *x <= 0.0) => {
                Err(Error::parameter("spacing", words(s), "expected one or three positive numbers, in mm"))
            }
            // In mm it may be that of a mask: whoever knows the format looks again.
            (LengthUnit::Voxel | LengthUnit::Millimetre, Some(_)) | (_, None) => Ok(()),
            (_, Some(_)) => self.check_coordinates(),
        }
    }

    /// The same in another unit, where there is one.
    #[must_use]
    pub fn in_unit(self, other: Option<LengthUnit>) -> Self {
        Self { unit: other.unwrap_or(self.unit), ..self }
    }

    /// Refuses a spacing of coordinates that are not in voxels.
    ///
    /// # Errors
    ///
    /// Names the option and what it goes with.
    pub fn check_coordinates(&self) -> Result<()> {
        let Some(spacing) = self.spacing.filter(|_| self.unit != LengthUnit::Voxel) else { return Ok(()) };
        Err(Error::parameter("spacing", words(spacing), format!("goes with `units=voxel`, not {}", self.unit.symbol())))
    }

    /// mm along each axis for one unit of the file.
    pub fn axes(&self) -> [f64; 3] {
        match self.unit {
            LengthUnit::Voxel => self.spacing.unwrap_or([1.0; 3]),
            other => [other.mm(); 3],
        }
    }

    /// A position of the file, in m.
    pub fn position(&self, p: [f64; 3]) -> [f64; 3] {
        let s = self.axes();
        [metres(p[0] * s[0]), metres(p[1] * s[1]), metres(p[2] * s[2])]
    }

    /// A radius or length of the file, in m; with unequal spacings the smallest one counts.
    pub fn length(&self, x: f64) -> f64 {
        let s = self.axes();
        metres(x * s[0].min(s[1]).min(s[2]))
    }

    /// A length along a course of the file, in m; NaN with unequal spacings, between which only the course tells.
    pub fn course(&self, x: f64) -> f64 {
        let [x_mm, y_mm, z_mm] = self.axes();
        if x_mm == y_mm && y_mm == z_mm { metres(x * x_mm) } else { f64::NAN }
    }
}

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
