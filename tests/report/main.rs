//! The output folder: pictures, the page, and the programs that read it.

#[path = "../support/command.rs"]
mod command;
#[path = "../support/draw.rs"]
mod draw;

mod grown;
mod page;
mod page_browser;
mod plots;
mod plots_svg;
mod readers;
