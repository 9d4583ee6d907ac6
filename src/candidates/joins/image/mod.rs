//! What the image shows between the ends of a candidate, where there is one: a vessel that fell below the threshold is faintly there still.
//!
//! | step | file |
//! |---|---|
//! | the image around the vessels: background, noise and the contrast of every vessel, each measured near by | `scene.rs` |
//! | the cheapest path between two places | `path.rs` |
//! | what lies on the straight line and on that path | `features.rs` |

pub mod features;
pub mod path;
pub mod scene;
