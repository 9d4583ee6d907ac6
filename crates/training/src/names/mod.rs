//! Fits the model that names arteries to labelled tracings, whole and broken.

mod atlas;
mod cases;
mod fit;
mod truth;

pub use cases::{LabelledCase, read_labelled_cases};
pub use fit::{FittedNames, fit_names};
pub use willis_models::naming::model::NamingModel;
