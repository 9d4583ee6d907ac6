//! The search for candidates: where a free end may be joined to a branch or to another free end.

pub(crate) mod branches;
pub(crate) mod by_evidence;
pub(crate) mod directions;
pub(crate) mod free_ends;
pub(crate) mod limits;
pub(crate) mod meeting_points;
mod neighbourhood;
pub mod neighbours;

pub use by_evidence::{FoundBridge, Search, search};
pub use meeting_points::Meetings;
pub use neighbours::join_nearest;
