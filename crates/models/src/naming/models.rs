//! The models that ship, and which of them a case fits: patients' arteries, or the drawn circle.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use super::{Bearings, Names, NamingModel, name_again, name_arteries};
use willis_core::error::Result;
use willis_core::network::Network;

/// The models that ship: of patients, and of the drawn circle of `willis phantom`.
const SHIPPED: [(&str, &str); 2] = [("arteries.toml", include_str!("arteries.toml")), ("drawn.toml", include_str!("drawn.toml"))];
/// Where the first model names this share of the length, no other one is asked; nor of a whole brain.
const ENOUGH: f64 = 0.8;

/// Models that name arteries, the one that is asked first before the others.
#[derive(Debug, Clone)]
pub struct NamingModels(Vec<Arc<NamingModel>>);

impl NamingModels {
    /// The models that ship with willis.
    ///
    /// # Errors
    ///
    /// None in a released version: a test reads them.
    pub fn shipped() -> Result<Self> {
        // A cohort asks for every subject.
        static MODELS: OnceLock<NamingModels> = OnceLock::new();
        if let Some(models) = MODELS.get() {
            return Ok(models.clone());
        }
        let read =
            |(path, text): &(&str, &str)| NamingModel::read(text).map(Arc::new).map_err(|fault| fault.in_file(Path::new(path)));
        let models = Self(SHIPPED.iter().map(read).collect::<Result<_>>()?);
        Ok(MODELS.get_or_init(|| models).clone())
    }

    /// One model alone.
    pub fn one(model: NamingModel) -> Self {
        Self(vec![Arc::new(model)])
    }

    /// The names of a network by the model that it fits best: see [`name_arteries`].
    pub fn name(&self, network: &Network) -> Option<Names> {
        let mut best: Option<Names> = None;
        for (by, model) in self.0.iter().enumerate() {
            let Some(mut names) = name_arteries(network, model) else { continue };
            // Of a whole brain each atlas names another part, so that their fits do not compare; and drawn circles are no brains.
            if by == 0 && (names.share_named() >= ENOUGH || names.is_part) {
                return Some(names);
            }
            // A case of which a model knows next to nothing has no fit.
            let fit = |names: &Names| names.fit.max(f64::MIN);
            if best.as_ref().is_none_or(|known| fit(&names) > fit(known)) {
                names.bearings.by = by;
                best = Some(names);
            }
        }
        best
    }

    /// The names by the same model of a network that lies where `like` was found to lie: see [`name_again`].
    pub fn name_again(&self, network: &Network, like: &Bearings) -> Option<Names> {
        let mut names = name_again(network, self.0.get(like.by)?, like)?;
        names.bearings.by = like.by;
        Some(names)
    }

    /// The model that gave some names.
    pub fn of(&self, names: &Names) -> &NamingModel {
        &self.0[names.bearings.by]
    }
}
