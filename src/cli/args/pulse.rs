//! `--pulse` and its options, with their conversion to those of the library.

use super::{figure, for_option, whole};
use crate::{
    Error, Friction, PulseMean, PulseOptions, Result, Thickness, WallLaw, internals::network::INLET_PRESSURE,
    internals::network::quantity::Dimension, internals::network::units::mmhg, internals::pipeline::of_word,
};

const WALL: &str = "expected olufsen, olufsen=K1,K2,K3 (Pa, 1/m, Pa), Eh=120N/m, young=0.4MPa,0.3mm (or a share of the radius, 10%), \
                    pwv=8m/s, graph or rigid";

/// What a model for another solver has no place for.
const OF_SIMULATE: [&str; 3] = ["wall_viscosity", "friction", "times"];

#[derive(Debug, Default, clap::Args)]
#[command(next_help_heading = "Pulse")]
pub struct PulseArgs {
    /// Let the flow pulsate: one period at every inlet, or at one, as a table (time_s, and pressure_mmHg or flow_mL_per_min), or as a
    /// typical shape of the flow: carotid, vertebral, or typical, which is either by the name of the inlet [default: typical]
    #[arg(long, value_name = "[NODE=]FILE|SHAPE", num_args = 0..=1, default_missing_value = "typical")]
    pulse: Vec<String>,
    /// The period [default: what the tables mean; 1 s of a shape]
    #[arg(long, value_name = "TIME", value_parser = figure("period", Dimension::Time), hide_short_help = true)]
    period: Option<f64>,
    /// The mean of the waveforms: shifts a pressure (100mmHg), scales a flow (240mL/min) [default: their own]
    #[arg(long, value_name = "PRESSURE|FLOW", value_parser = for_option("pulse_mean", mean), hide_short_help = true)]
    pulse_mean: Option<PulseMean>,
    /// How many harmonics are solved [default: 40]
    #[arg(long, value_name = "N", value_parser = whole::<usize>, hide_short_help = true)]
    harmonics: Option<usize>,
    /// The walls: Olufsen's law, one modulus times thickness, Young's modulus and a thickness, one wave speed, what the edges of the
    /// graph state, or rigid [default: graph where it states them, else olufsen]
    #[arg(long, value_name = "olufsen|Eh=VALUE|young=E,H|pwv=SPEED|graph|rigid", value_parser = for_option("wall", wall),
        allow_hyphen_values = true, hide_short_help = true)]
    wall: Option<WallLaw>,
    /// The time constant of a wall that creeps (Kelvin-Voigt) [default: 0, an elastic wall]
    #[arg(long, value_name = "TIME", value_parser = figure("wall_viscosity", Dimension::Time), allow_hyphen_values = true,
        hide_short_help = true)]
    wall_viscosity: Option<f64>,
    /// Resistance times compliance of outlets that state no compliance; none leaves them resistances [default: rc=0.69s]
    #[arg(long, value_name = "rc=TIME|none", value_parser = for_option("windkessel", windkessel), hide_short_help = true)]
    windkessel: Option<TimeConstant>,
    /// The profile by which the flow meets friction [default: womersley]
    #[arg(long, value_name = "womersley|parabolic", value_parser = for_option("friction", friction), hide_short_help = true)]
    friction: Option<Friction>,
    /// Density of blood [default: 1060 kg/m3]
    #[arg(long, value_name = "DENSITY", value_parser = figure("density", Dimension::Density), allow_hyphen_values = true,
        hide_short_help = true)]
    density: Option<f64>,
    /// At how many times of the period waveforms are written [default: 100]
    #[arg(long, value_name = "N", value_parser = whole::<usize>, hide_short_help = true)]
    times: Option<usize>,
}

impl PulseArgs {
    /// The options of the library; `None` without `--pulse`.
    pub fn options(&self) -> Result<Option<PulseOptions>> {
        if self.pulse.is_empty() {
            return self.alone();
        }
        let usual = PulseOptions::default();
        let Self { period, pulse_mean: mean, wall, .. } = *self;
        let (waveforms, friction) = (self.pulse.clone(), self.friction.unwrap_or(usual.friction));
        let (harmonics, times) = (self.harmonics.unwrap_or(usual.harmonics), self.times.unwrap_or(usual.times));
        let (wall_viscosity, density) =
            (self.wall_viscosity.unwrap_or(usual.wall_viscosity), self.density.unwrap_or(usual.density));
        let time_constant = self.windkessel.unwrap_or(usual.time_constant);
        let options =
            PulseOptions { waveforms, period, mean, harmonics, wall, wall_viscosity, time_constant, friction, density, times };
        options.validate()?;
        Ok(Some(options))
    }

    /// The options of the library for a model of another solver, which has friction of its own.
    pub fn of_a_model(&self) -> Result<Option<PulseOptions>> {
        let refused = self.given().into_iter().find(|(name, given)| *given && OF_SIMULATE.contains(name));
        refused
            .map_or_else(|| self.options(), |(name, _)| Err(Error::parameter(name, "for another solver", "goes with simulate")))
    }

    /// Refuses an option of the pulse without the pulse.
    fn alone(&self) -> Result<Option<PulseOptions>> {
        let refused = |(name, _)| Err(Error::parameter(name, "without a pulse", "goes with `pulse`"));
        self.given().into_iter().find(|(_, given)| *given).map_or(Ok(None), refused)
    }

    /// The options that go with a pulse, and whether each is given.
    fn given(&self) -> [(&'static str, bool); 9] {
        [
            ("period", self.period.is_some()),
            ("pulse_mean", self.pulse_mean.is_some()),
            ("harmonics", self.harmonics.is_some()),
            ("wall", self.wall.is_some()),
            ("wall_viscosity", self.wall_viscosity.is_some()),
            ("windkessel", self.windkessel.is_some()),
            ("friction", self.friction.is_some()),
            ("density", self.density.is_some()),
            ("times", self.times.is_some()),
        ]
    }
}

/// The time constant of outlets, s; none of resistances.
type TimeConstant = Option<f64>;

fn windkessel(text: &str) -> Result<TimeConstant, String> {
    if text == "none" {
        return Ok(None);
    }
    let time = text.strip_prefix("rc=").and_then(|time| Dimension::Time.parse(time).ok()).filter(|time| *time > 0.0);
    time.map(Some).ok_or_else(|| "expected none, or rc=TIME such as rc=0.69s".into())
}

fn friction(text: &str) -> Result<Friction, String> {
    of_word(text).ok_or_else(|| "expected womersley or parabolic".into())
}

fn mean(text: &str) -> Result<PulseMean, String> {
    if Dimension::Flow.has_unit_in(text) {
        return Dimension::Flow.parse(text).map(PulseMean::Flow);
    }
    let accepted = format!("expected a pressure ({} mmHg) or a flow (240mL/min) with its unit", mmhg(INLET_PRESSURE));
    let pressure = Dimension::Pressure.parse(text).ok().filter(|_| Dimension::Pressure.has_unit_in(text));
    pressure.map(PulseMean::Pressure).ok_or(accepted)
}

fn wall(text: &str) -> Result<WallLaw, String> {
    parsed_wall(text).ok_or_else(|| WALL.into())
}

fn parsed_wall(text: &str) -> Option<WallLaw> {
    let (word, value) = text.split_once('=').map_or((text, None), |(word, value)| (word, Some(value)));
    match (word, value) {
        ("olufsen", None) => Some(WallLaw::OLUFSEN),
        ("graph", None) => Some(WallLaw::Stated),
        ("rigid", None) => Some(WallLaw::Rigid),
        ("olufsen", Some(value)) => {
            let numbers: Option<Vec<f64>> = value.split(',').map(|number| number.trim().parse().ok()).collect();
            let [k1, k2, k3] = numbers?[..] else { return None };
            Some(WallLaw::Olufsen { k1, k2, k3 })
        }
        ("Eh" | "eh", Some(value)) => Dimension::Stiffness.parse(value).ok().map(WallLaw::Stiffness),
        ("pwv", Some(value)) => Dimension::Speed.parse(value).ok().map(WallLaw::Speed),
        ("young", Some(value)) => {
            let (young, thickness) = value.split_once(',')?;
            let share = thickness.trim().strip_suffix('%').map(|percent| percent.trim().parse::<f64>().ok());
            let thickness = match share {
                Some(percent) => Thickness::OfRadius(percent? / 100.0),
                None => Thickness::Length(Dimension::Length.parse(thickness).ok()?),
            };
            Some(WallLaw::Elastic { young: Dimension::Modulus.parse(young).ok()?, thickness })
        }
        _ => None,
    }
}
