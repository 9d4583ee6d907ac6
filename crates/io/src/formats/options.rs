//! How a file is read: units, radii, the frame, and what a mask means.

use std::path::{Path, PathBuf};

use crate::masks::{Cavities, RadiusFrom};
use willis_core::error::{Error, Fault, Result, require};
use willis_core::network::{Frame, LengthUnit, RadiusRule, Scale, is_radius, millimetres};
use willis_core::support::geometry::Point;

/// How to read a file.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReadOptions {
    /// The unit of its coordinates, lengths and radii.
    pub scale: Scale,
    /// The array of a VTK file, or the measurement of markups, that holds the radius, if it has none of the usual names. An array
    /// with "area" in its name holds areas.
    pub radius_array: Option<String>,
    /// Which radius stands for a vessel.
    #[serde(rename = "radius")]
    pub radius_rule: RadiusRule,
    /// The radius of vessels that have none, m, positive; without it such a vessel is an error.
    #[serde(rename = "default_radius_m")]
    pub default_radius: Option<f64>,
    /// A CSV file of pairs of point ids to link, which SWC cannot.
    pub loops: Option<PathBuf>,
    /// Whether the vessels of a graph are taken as observed, so that candidates are built around them.
    pub observed: bool,
    /// The least value of a vessel's voxel in an image of probabilities or intensities, whose values then tell how much of the voxels at a
    /// wall is inside; without it the image holds classes.
    pub level: Option<f64>,
    /// What the radius of a mask's centerlines is.
    pub radius_from: RadiusFrom,
    /// What is done with the cavities of a mask.
    pub cavities: Cavities,
    /// The corners of the image's box with the least and the largest coordinates, m, in the frame of the file. A free end at its faces is
    /// where a vessel leaves the image. A mask states its own.
    #[serde(rename = "box_m")]
    pub field_of_view: Option<[Point; 2]>,
    /// Which way the axes of a file point that does not state it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<Frame>,
    /// The most bytes of each file, and of all that is compressed in it.
    pub max_input: u64,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            scale: Scale::default(),
            radius_array: None,
            radius_rule: RadiusRule::default(),
            default_radius: None,
            loops: None,
            observed: false,
            level: None,
            field_of_view: None,
            radius_from: RadiusFrom::default(),
            cavities: Cavities::default(),
            frame: None,
            max_input: crate::formats::input::MAX_INPUT,
        }
    }
}

impl ReadOptions {
    /// Checks every field.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        self.scale.validate()?;
        self.loops.as_deref().map_or(Ok(()), check_name)?;
        let level = self.level.unwrap_or_default();
        require(level.is_finite(), "level", level, "expected a finite number")?;
        if let Some([low, high]) = self.field_of_view.filter(|[low, high]| !(0..3).all(|k| low[k] < high[k])) {
            let given: Vec<String> = low.iter().chain(&high).map(|m| millimetres(*m).to_string()).collect();
            let accepted = "expected the least x,y,z and the largest x,y,z, in mm";
            return Err(Error::parameter("box", given.join(","), accepted));
        }
        let Some(m) = self.default_radius else { return Ok(()) };
        require(is_radius(m), "default_radius", millimetres(m), "expected a positive length")
    }

    /// Whether vessels may lack any radius.
    pub fn is_radius_optional(&self) -> bool {
        self.default_radius.is_some()
    }
}

/// The unit that a file states by a word, mm by an empty one; none where it states none, or where another than mm was given.
pub(crate) fn stated_unit(
    word: Option<&str>,
    given: &Scale,
    unknown: impl FnOnce() -> Fault,
) -> Result<Option<LengthUnit>, Fault> {
    match word.filter(|_| given.unit == LengthUnit::Millimetre) {
        None => Ok(None),
        Some("") => Ok(Some(LengthUnit::Millimetre)),
        Some(word) => LengthUnit::named(word).map(Some).ok_or_else(unknown),
    }
}

/// Checks the name of a file that belongs to a run: what is written down of the run holds it.
///
/// # Errors
///
/// It is no UTF-8.
pub fn check_name(file: &Path) -> Result<()> {
    let wrong = || Fault::file("its name is no UTF-8", "expected one that is, as run.json holds it").in_file(file);
    file.to_str().ok_or_else(wrong).map(drop)
}
