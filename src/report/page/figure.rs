//! A picture in a page. The only file of the page that knows in which format the pictures come.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::error::Result;

/// A resolution at which a picture in a page is sharp on a screen and small in the file, pixels per inch.
const DPI: u32 = 150;

/// A picture and what it shows.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Its heading.
    pub title: &'static str,
    /// What it shows, for those who read it and those who cannot see it.
    pub says: &'static str,
    png: Vec<u8>,
}

impl Figure {
    /// The picture as the run made it at `dpi`, or drawn anew where that would make the page heavy.
    ///
    /// # Errors
    ///
    /// What `draw` says.
    pub fn new(
        title: &'static str,
        says: &'static str,
        (made, dpi): (Vec<u8>, u32),
        draw: impl FnOnce(u32) -> Result<Vec<u8>>,
    ) -> Result<Self> {
        Ok(Self { title, says, png: if dpi <= DPI { made } else { draw(DPI)? } })
    }

    /// Where a page finds it: within itself.
    pub fn source(&self) -> String {
        format!("data:image/png;base64,{}", STANDARD.encode(&self.png))
    }
}
