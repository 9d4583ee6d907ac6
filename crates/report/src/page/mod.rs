//! report.html: one self-contained page of a run, to open in any browser and to send to a colleague.

pub(crate) mod cohort;
mod comparison;
mod content;
mod encode;
mod image;
mod inference;
pub mod lead;
mod modulation;
pub(crate) mod phenotype;
pub mod scene;
mod simulation;
mod template;

pub use comparison::write_comparison_page;
pub use content::{Page, PagePicture};
pub use image::{ImagePlace, Segmentation};
pub use inference::page as infer_page;
pub use modulation::page as modulation_page;
pub use scene::scene;
pub use simulation::page as simulation_page;
pub use template::write_page;
