//! `--inlet`, `--outlet` and the other options of boundary conditions.

use std::path::{Path, PathBuf};

use crate::BoundaryOptions;
use crate::error::Result;
use crate::internals::pipeline::parse_found_outlets;
use clap::Args;

use super::file_of;

#[derive(Debug, Args)]
#[command(next_help_heading = "Boundary conditions (NODE is an id, a label, or x,y,z in mm)")]
pub struct BoundaryArgs {
    /// Where blood enters, at a pressure [default: 100 mmHg]; found at free ends when none is given
    #[arg(long, value_name = "NODE[=PRESSURE]", allow_hyphen_values = true)]
    inlet: Vec<String>,
    /// Where blood leaves: to ground (the default), to a pressure (5mmHg), or through a resistance (20mmHg.s/mL) to a venous
    /// pressure (20mmHg.s/mL@5mmHg); found at the other free ends when none is given
    #[arg(long, value_name = "NODE[=ground|PRESSURE|RESISTANCE[@PRESSURE]]", allow_hyphen_values = true)]
    outlet: Vec<String>,
    /// A fixed flow into the network (negative: out of it), in mL/min
    #[arg(long, value_name = "NODE=FLOW", allow_hyphen_values = true, hide_short_help = true)]
    flow: Vec<String>,
    /// A CSV or TOML file of conditions; in its name {} is INPUT without its ending and {dir} the folder of INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    bc: Option<PathBuf>,
    /// What outlets found by willis are: ground, or terminal resistances by Murray's law that come to a total flow (in
    /// mL/min) or a total resistance [default: murray=700 on centerlines and masks, ground on a ready graph]
    #[arg(long, value_name = "ground|murray[=FLOW|RESISTANCE]", hide_short_help = true)]
    outlets: Option<String>,
}

impl BoundaryArgs {
    /// The options of the library for every input.
    pub fn options(&self) -> Result<BoundaryOptions> {
        Ok(BoundaryOptions {
            inlet: self.inlet.clone(),
            outlet: self.outlet.clone(),
            flow: self.flow.clone(),
            conditions: self.bc.clone(),
            found_outlets: self.outlets.as_deref().map(parse_found_outlets).transpose()?,
        })
    }
}

/// The same with the file of conditions that goes with an input.
pub fn for_input(options: &BoundaryOptions, input: &Path) -> BoundaryOptions {
    BoundaryOptions { conditions: options.conditions.as_ref().map(|name| file_of(name, input)), ..options.clone() }
}
