//! The layers of the code, and the documentation against the program.

mod docs;
mod experiments;
mod layers;
mod pages;
