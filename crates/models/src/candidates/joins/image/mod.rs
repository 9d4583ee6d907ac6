//! What the image shows between the ends of a candidate, where there is one: a vessel that fell below the threshold is faintly there still.
//!
//! | step | file |
//! |---|---|
//! | the cheapest path between two places | `path.rs` |
//! | the vessels met first from each free end, which make more candidates | `ahead.rs` |
//! | what lies on the straight line and on that path | `features.rs` |

pub mod ahead;
pub mod features;
pub mod path;
