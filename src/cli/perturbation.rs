//! Stenoses, occlusions and tortuosity from the command line.

use clap::Args;
use willis::error::{Error, Result};
use willis::internals::network::quantity::Dimension;
use willis::internals::network::{Network, vessels_called};
use willis::internals::perturbation::Stenosis;
use willis::internals::simulation::{Change, Perturbation};

const SEVERITY: &str =
    "expected VESSEL=70% (of the diameter), VESSEL=area:70%, or either with @mid:10mm, @start:10mm or @end:10mm";

#[derive(Debug, Args)]
#[command(next_help_heading = "Perturbations (VESSEL is a label, or edge:ROW; several with commas)")]
pub struct PerturbationArgs {
    /// Narrow a vessel by a share of its diameter, or of its area; @ narrows a stretch of it only
    #[arg(long, value_name = "VESSEL=[area:]PERCENT%[@mid:LENGTH]", value_delimiter = ',', allow_hyphen_values = true)]
    stenosis: Vec<String>,
    /// Close a vessel
    #[arg(long, value_name = "VESSEL", value_delimiter = ',', allow_hyphen_values = true)]
    occlude: Vec<String>,
    /// Lengthen a vessel by a factor of at least 1
    #[arg(long, value_name = "VESSEL=FACTOR", value_delimiter = ',', allow_hyphen_values = true)]
    tortuosity: Vec<String>,
    /// The pressure loss of a stenosis; poiseuille is the only one there is
    #[arg(long, value_name = "poiseuille", default_value = "poiseuille")]
    stenosis_model: String,
}

impl PerturbationArgs {
    /// What is to be done to the vessels of a network.
    pub fn resolve(&self, network: &Network) -> Result<Vec<Perturbation>> {
        let mut perturbations = Vec::new();
        let mut add = |option: &str, text: &str, parse: fn(&str) -> Result<(&str, Change), String>| {
            let refused = |why: String| Error::parameter(option, format!("\"{text}\""), why);
            let (name, change) = parse(text).map_err(refused)?;
            let vessels = vessels_called(network, name).map_err(refused)?;
            perturbations.extend(vessels.into_iter().map(|vessel| Perturbation { vessel, change }));
            Ok(())
        };
        self.stenosis.iter().try_for_each(|text| add("--stenosis", text, stenosis))?;
        self.occlude.iter().try_for_each(|text| add("--occlude", text, |name| Ok((name, Change::Occlusion))))?;
        self.tortuosity.iter().try_for_each(|text| add("--tortuosity", text, tortuosity))?;
        Ok(perturbations)
    }

    /// Refuses what can be refused before INPUT is read.
    pub fn check(&self) -> Result<()> {
        for text in &self.stenosis {
            stenosis(text).map_err(|why| Error::parameter("--stenosis", format!("\"{text}\""), why))?;
        }
        for text in &self.tortuosity {
            tortuosity(text).map_err(|why| Error::parameter("--tortuosity", format!("\"{text}\""), why))?;
        }
        match self.stenosis_model.as_str() {
            "poiseuille" => Ok(()),
            "young-tsai" => Err(Error::parameter(
                "--stenosis-model",
                "young-tsai",
                "the loss that goes as the square of the flow is not modelled; expected poiseuille",
            )),
            other => Err(Error::parameter("--stenosis-model", format!("\"{other}\""), "expected poiseuille")),
        }
    }
}

/// `VESSEL=[area:]PERCENT%[@mid:LENGTH]`.
fn stenosis(text: &str) -> Result<(&str, Change), String> {
    let (name, value) = text.rsplit_once('=').ok_or(SEVERITY)?;
    let (severity, stretch) = match value.split_once('@') {
        None => (value, None),
        Some((severity, place)) => (severity, Some(stretch(place)?)),
    };
    let (of_area, percent) = severity.trim().strip_prefix("area:").map_or((false, severity.trim()), |rest| (true, rest));
    let percent: f64 = percent.strip_suffix('%').and_then(|digits| digits.trim().parse().ok()).ok_or(SEVERITY)?;
    if percent >= 100.0 {
        return Err("leaves nothing open; expected a reduction below 100%, or --occlude to close the vessel".into());
    }
    if percent.is_nan() || percent < 0.0 {
        return Err("expected a reduction from 0% to below 100%".into());
    }
    let reduction = percent / 100.0;
    let narrowed = if of_area { Stenosis::of_area(reduction) } else { Stenosis::of_diameter(reduction) };
    Ok((name, Change::Stenosis(stretch.map_or(narrowed, |length| narrowed.over(length)))))
}

/// The length (m) in `mid:10mm`, `start:10mm` or `end:10mm`: where the stretch lies makes no difference to a steady flow.
fn stretch(place: &str) -> Result<f64, String> {
    let length = ["mid:", "start:", "end:"].iter().find_map(|word| place.trim().strip_prefix(word)).ok_or(SEVERITY)?;
    let length = Dimension::Length.parse(length)?;
    if length > 0.0 { Ok(length) } else { Err("expected a positive length of the narrowed stretch, such as @mid:10mm".into()) }
}

/// `VESSEL=FACTOR`.
fn tortuosity(text: &str) -> Result<(&str, Change), String> {
    const ACCEPTED: &str = "expected VESSEL=FACTOR with a factor of length of at least 1, such as 1.3";
    let (name, factor) = text.rsplit_once('=').ok_or(ACCEPTED)?;
    let factor: f64 = factor.trim().parse().map_err(|_| ACCEPTED)?;
    if factor.is_finite() && factor >= 1.0 { Ok((name, Change::Tortuosity(factor))) } else { Err(ACCEPTED.into()) }
}
