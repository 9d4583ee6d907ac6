//! The layers of the code, and the documentation against the program.

mod docs;
mod layers;
mod pages;
