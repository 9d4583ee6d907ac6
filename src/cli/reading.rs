//! How an input is read: its unit, its radii, the links beside it.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;
use willis::error::{Error, Result};
use willis::internals::io::{ReadOptions, byte_count};
use willis::internals::network::RadiusRule;
use willis::internals::network::units::{LengthUnit, Scale};

use super::beside::beside;
use super::loaded::Loaded;
use super::provenance::command_line;
use super::terminal::Terminal;
use super::typed::{length, spacing};

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    Mm,
    Um,
    Cm,
    M,
    Voxel,
}

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Radius {
    /// The mean over arc length
    Mean,
    /// The one with the vessel's own Poiseuille resistance
    Effective,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Input")]
pub struct InputArgs {
    /// Centerlines (SWC, VTP, VTK, TRE, Slicer markups, iCafe, Voreen, VesselVio, NPZ, MAT, CSV of points) or a candidate graph
    /// (GraphML, CSV of edges)
    #[arg(value_name = "INPUT", value_hint = clap::ValueHint::FilePath, help_heading = None::<&str>)]
    pub input: PathBuf,
    #[command(flatten)]
    reading: ReadingArgs,
}

/// How an input is read.
#[derive(Debug, Args, Serialize)]
#[command(next_help_heading = "Input")]
pub struct ReadingArgs {
    /// The unit of coordinates and radii in INPUT [default: mm]
    #[arg(long, value_enum)]
    pub units: Option<Unit>,
    /// Voxel spacing in mm, with --units voxel: one number, or three
    #[arg(long, value_name = "S|SX,SY,SZ", value_delimiter = ',', value_parser = spacing, allow_hyphen_values = true)]
    pub spacing: Option<Vec<f64>>,
    /// The VTP point array that holds the radius, when it has an unusual name
    #[arg(long, value_name = "NAME")]
    pub radius_array: Option<String>,
    /// Which radius stands for a vessel
    #[arg(long, value_enum, default_value = "mean")]
    pub radius: Radius,
    /// The radius of vessels that have none, in mm unless it says otherwise (0.5, 500um)
    #[arg(long, value_name = "LENGTH")]
    pub default_radius: Option<String>,
    /// Links between points that SWC cannot hold: a CSV file of id_a,id_b; in its name {} is INPUT without its ending and {dir}
    /// the folder of INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    pub loops: Option<PathBuf>,
    /// Take the vessels of a graph file as observed and build candidates around them
    #[arg(long)]
    pub observed: bool,
    /// The largest file to read, on the disk and unpacked
    #[arg(long, value_name = "SIZE", default_value = "2GiB", value_parser = byte_count)]
    pub max_input: u64,
}

impl InputArgs {
    /// Refuses what only commands that build candidates know.
    pub fn refuse_candidates(&self, command: &str) -> Result<()> {
        self.reading.refuse_candidates(command)
    }

    /// Reads the input and says what was found in it.
    pub fn load(&self, terminal: Terminal) -> Result<Loaded> {
        Loaded::read(&self.input, &self.reading, command_line(), terminal)
    }
}

impl ReadingArgs {
    /// Refuses what only commands that build candidates know.
    pub fn refuse_candidates(&self, command: &str) -> Result<()> {
        if self.observed {
            let why = format!("goes with infer and candidates; {command} uses every vessel as it is");
            return Err(Error::parameter("--observed", "", why));
        }
        Ok(())
    }

    /// Refuses what is wrong whatever the input.
    pub fn check(&self) -> Result<()> {
        self.scale()?;
        self.default_radius().map(drop)
    }

    /// The radius of vessels that have none, m.
    pub fn default_radius(&self) -> Result<Option<f64>> {
        length("--default-radius", self.default_radius.as_ref())
    }

    /// Which radius stands for a vessel.
    pub fn radius_rule(&self) -> RadiusRule {
        match self.radius {
            Radius::Mean => RadiusRule::Mean,
            Radius::Effective => RadiusRule::Effective,
        }
    }

    /// How the library reads an input.
    pub fn options(&self, input: &Path) -> Result<ReadOptions> {
        Ok(ReadOptions {
            scale: self.scale()?,
            radius_array: self.radius_array.clone(),
            radius_optional: self.default_radius.is_some(),
            loops: self.loops(input),
            max_input: self.max_input,
        })
    }

    /// The file of links that goes with an input.
    pub fn loops(&self, input: &Path) -> Option<PathBuf> {
        self.loops.as_ref().map(|name| beside(name, input))
    }

    /// The unit of INPUT, which files of positions beside it share.
    pub fn scale(&self) -> Result<Scale> {
        let unit = match self.units.unwrap_or(Unit::Mm) {
            Unit::Mm => LengthUnit::Millimetre,
            Unit::Um => LengthUnit::Micrometre,
            Unit::Cm => LengthUnit::Centimetre,
            Unit::M => LengthUnit::Metre,
            Unit::Voxel => LengthUnit::Voxel,
        };
        let spacing = match self.spacing.as_deref() {
            None => None,
            Some([s]) => Some([*s; 3]),
            Some([x, y, z]) => Some([*x, *y, *z]),
            Some(other) => {
                return Err(Error::parameter(
                    "--spacing",
                    other.iter().map(f64::to_string).collect::<Vec<_>>().join(","),
                    "expected one or three positive numbers, in mm",
                ));
            }
        };
        let scale = Scale { unit, spacing };
        scale.validate()?;
        Ok(scale)
    }
}
