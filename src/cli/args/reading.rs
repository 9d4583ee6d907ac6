//! How an input is read: its unit, its radii, the links beside it.

use std::path::{Path, PathBuf};

use super::{Spacing, file_of, length, spacing, words};
use crate::internals::formats::{Format, FormatTrait, StatedSpacing, byte_count, stated_spacing};
use crate::{
    Cavities, Error, InferOptions, Input, LengthUnit, RadiusFrom, RadiusRule, ReadOptions, Result, Scale,
    cli::print::TextTerminal, cli::print::say_read, error::Fault, internals::network::Frame, internals::network::units::metres,
    internals::pipeline::RunOptions, internals::pipeline::require, internals::support::geometry::Point, read, read_run,
};

/// The file that a command works on.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Input")]
pub struct InputArgs {
    #[arg(value_name = "INPUT", help = Format::inputs(), value_hint = clap::ValueHint::FilePath, help_heading = None::<&str>)]
    pub input: PathBuf,
    #[command(flatten)]
    pub reading: ReadingArgs,
}

/// The help of inputs of which several are a cohort.
pub fn inputs_of_a_cohort() -> String {
    let many =
        "several, a pattern in quotes ('scans/*.swc'), or a manifest (CSV with a column input, a row a subject) are a cohort";
    format!("{}; {many}: a folder each, and a table of all", Format::inputs())
}

/// The inputs of a command that takes runs and cohorts, and how they are read.
#[derive(Debug, clap::Args)]
pub struct RunsArgs {
    /// Vessels in any format that infer reads, or folders of willis infer; several, patterns in quotes, a manifest (CSV with a column
    /// input, a row a subject), or the folder of a cohort make a cohort
    #[arg(required = true, value_name = "INPUT", value_hint = clap::ValueHint::AnyPath, help_heading = None::<&str>)]
    pub inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub reading: ReadingArgs,
}

/// How an input is read.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Input")]
pub struct ReadingArgs {
    /// The unit of coordinates and radii in INPUT [default: mm]
    #[arg(long, value_parser = words::<LengthUnit>(&[("mm", ""), ("um", ""), ("cm", ""), ("m", ""), ("voxel", "")]))]
    pub units: Option<LengthUnit>,
    #[arg(long, help = format!("Voxel spacing in mm, of a {} mask or of coordinates in voxels: one number, or three; auto takes it from where it is \
        stated, iCafe's Image_info.txt beside INPUT or the mask itself", Format::listed(FormatTrait::GivenSpacing, "or")),
        value_name = "S|SX,SY,SZ|auto", value_delimiter = ',', value_parser = spacing, allow_hyphen_values = true,
        hide_short_help = true)]
    pub spacing: Option<Vec<Spacing>>,
    #[arg(long, value_name = "NAME", hide_short_help = true, help = format!("The array that holds the radius, when it has an unusual \
        name, in {}", Format::listed(FormatTrait::NamedRadii, "or")))]
    pub radius_array: Option<String>,
    /// Which radius stands for a vessel
    #[arg(long, default_value = "mean", hide_short_help = true, value_parser = words::<RadiusRule>(&[("mean", "The mean over arc length"),
        ("effective", "The one with the vessel's own Poiseuille resistance")]))]
    pub radius: RadiusRule,
    /// The radius of vessels that have none, in mm unless it says otherwise (0.5, 500um)
    #[arg(long, value_name = "LENGTH", value_parser = length("default_radius"), hide_short_help = true)]
    pub default_radius: Option<f64>,
    /// Links between points that SWC cannot hold: a CSV file of id_a,id_b; in its name {} is INPUT without its ending and {dir}
    /// the folder of INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath, hide_short_help = true)]
    pub loops: Option<PathBuf>,
    /// Take the vessels of a graph file as observed and build candidates around them
    #[arg(long, hide_short_help = true)]
    pub observed: bool,
    /// The least value of a vessel's voxel in an image of probabilities or intensities
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true, hide_short_help = true)]
    pub level: Option<f64>,
    /// What the radius of a mask's centerlines is
    #[arg(long, default_value = "area", hide_short_help = true, value_parser = words::<RadiusFrom>(&[
        ("area", "That of the circle with the area of the lumen's cross-section; with --level voxels at the wall count in part"),
        ("distance", "The distance to the nearest voxel outside"),
        ("inscribed", "That of the largest sphere inside")]))]
    pub radius_from: RadiusFrom,
    /// What is done with the cavities of a mask, background that nothing connects to the outside
    #[arg(long, default_value = "fill", hide_short_help = true, value_parser = words::<Cavities>(&[
        ("fill", "They become part of the vessel around them, specks are left out, and noise and solid bodies are refused"),
        ("keep", "All stays as it is; each cavity becomes a closed surface with dozens of loops")]))]
    pub cavities: Cavities,
    /// The box of the image, in mm: its least and its largest x,y,z; a vessel that ends at its faces goes on outside, so nothing is joined there
    #[arg(long = "box", value_name = "X,Y,Z,X,Y,Z", value_delimiter = ',', allow_hyphen_values = true, hide_short_help = true)]
    pub field_of_view: Option<Vec<f64>>,
    /// Which way the axes of INPUT point, if it does not state it: x to the right, y forward (RAS), or x to the left, y backward (LPS)
    #[arg(long, hide_short_help = true, value_parser = words::<Frame>(&[("RAS", ""), ("LPS", "")]))]
    pub frame: Option<Frame>,
    /// The largest file to read, on the disk and unpacked
    #[arg(long, value_name = "SIZE", default_value = "2GiB", value_parser = byte_count, hide_short_help = true)]
    pub max_input: u64,
}

impl ReadingArgs {
    /// Refuses what only commands that build candidates know.
    pub fn refuse_candidates(&self, command: &str) -> Result<()> {
        let why = format!("goes with infer and candidates; {command} uses every vessel as it is");
        require(!self.observed, "observed", "", why)
    }

    /// Reads an input, and says what it is; `command` is the line that repeats its run.
    pub fn read(&self, input: &Path, command: String, terminal: TextTerminal) -> Result<Input> {
        Ok(self.said(read(input, &self.options(input)?)?.with_command(command), terminal))
    }

    /// As [`Self::read`], but of the folder of a run the run itself.
    pub fn read_run(&self, input: &Path, command: String, terminal: TextTerminal) -> Result<Input> {
        Ok(self.said(read_run(input, &self.options(input)?)?.with_command(command), terminal))
    }

    /// Says what an input is that was read so, and hands it on.
    pub fn said(&self, read: Input, terminal: TextTerminal) -> Input {
        // Without a unit one is assumed, unless the spacing says it.
        say_read(terminal, &read, self.units.is_none() && !self.is_spacing_auto());
        read
    }

    /// The options of the library for an input.
    pub fn options(&self, input: &Path) -> Result<ReadOptions> {
        let shared = self.shared()?;
        let scale = if self.is_spacing_auto() && !input.is_dir() { self.stated_scale(input)? } else { shared.scale };
        let options = ReadOptions { loops: self.loops(input), scale, ..shared };
        options.validate()?;
        Ok(options)
    }

    /// Whether each input states its spacing.
    pub fn is_spacing_auto(&self) -> bool {
        matches!(self.spacing.as_deref(), Some([None]))
    }

    /// The options that many inputs share, for two runs to be compared: those of reading with those of `infer`.
    pub fn parameters(&self, infer: InferOptions) -> Result<serde_json::Value> {
        let mut options = RunOptions { read: self.shared()?, infer }.comparable(&serde_json::Value::Null);
        if self.is_spacing_auto() {
            options["spacing_mm"] = "auto".into();
        }
        Ok(options)
    }

    /// The unit of an input by the spacing that is stated for it.
    fn stated_scale(&self, input: &Path) -> Result<Scale> {
        match (stated_spacing(input)?, self.units) {
            (StatedSpacing::Within, _) => Ok(Scale { unit: self.units.unwrap_or_default(), spacing: None }),
            (StatedSpacing::Beside(mm), None | Some(LengthUnit::Voxel)) => {
                Ok(Scale { unit: LengthUnit::Voxel, spacing: Some([mm; 3]) })
            }
            (StatedSpacing::Beside(_), Some(_)) => Err(Error::parameter("spacing", "auto", "goes with `units=voxel`")),
            (StatedSpacing::Nowhere, _) => {
                let mask = format!("a mask in {}", Format::listed(FormatTrait::OwnSpacing, "or"));
                let accepted = format!("expected Image_info.txt of iCafe beside it or {mask}, else give the spacing in mm");
                Err(Fault::file("nothing states the spacing", accepted).in_file(input))
            }
        }
    }

    /// The same for every input.
    pub fn shared(&self) -> Result<ReadOptions> {
        let options = ReadOptions {
            scale: self.scale()?,
            radius_array: self.radius_array.clone(),
            radius_rule: self.radius,
            default_radius: self.default_radius,
            loops: self.loops.clone(),
            observed: self.observed,
            level: self.level,
            field_of_view: self.field_of_view()?,
            radius_from: self.radius_from,
            cavities: self.cavities,
            frame: self.frame,
            max_input: self.max_input,
        };
        options.validate()?;
        Ok(options)
    }

    /// The file of links that goes with an input.
    pub fn loops(&self, input: &Path) -> Option<PathBuf> {
        self.loops.as_ref().map(|name| file_of(name, input))
    }

    fn field_of_view(&self) -> Result<Option<[Point; 2]>> {
        let Some(given) = &self.field_of_view else { return Ok(None) };
        let Ok([a, b, c, d, e, f]) = <[f64; 6]>::try_from(given.as_slice()) else {
            let given: Vec<String> = given.iter().map(f64::to_string).collect();
            let accepted = "expected six numbers: the least x,y,z and the largest x,y,z, in mm";
            return Err(Error::parameter("box", given.join(","), accepted));
        };
        Ok(Some([[a, b, c].map(metres), [d, e, f].map(metres)]))
    }

    fn scale(&self) -> Result<Scale> {
        let spacing = match self.spacing.as_deref() {
            None => None,
            // Each input says what it is.
            Some([None]) => return Ok(Scale::default()),
            Some([Some(s)]) => Some([*s; 3]),
            Some([Some(x), Some(y), Some(z)]) => Some([*x, *y, *z]),
            Some(other) => {
                let given: Vec<String> = other.iter().map(|mm| mm.map_or("auto".into(), |mm| mm.to_string())).collect();
                return Err(Error::parameter("spacing", given.join(","), "expected one or three positive numbers, in mm"));
            }
        };
        Ok(Scale { unit: self.units.unwrap_or_default(), spacing })
    }
}
