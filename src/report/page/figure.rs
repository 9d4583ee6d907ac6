//! A picture in a page. The only file of the page that knows in which format the pictures come.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::super::plots;
use crate::error::Result;

/// The largest drawing in lines that goes into a page; beyond it pixels are smaller. In bytes.
const DRAWING: usize = 200_000;

/// A picture and what it shows.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Its heading.
    pub title: &'static str,
    /// What it shows, for those who read it and those who cannot see it.
    pub says: &'static str,
    source: String,
}

impl Figure {
    /// The picture in lines, or in pixels where these make the page lighter.
    ///
    /// # Errors
    ///
    /// What drawing says.
    pub fn new(title: &'static str, says: &'static str, picture: &plots::Figure) -> Result<Self> {
        let drawing = picture.svg()?;
        let (kind, bytes) =
            if drawing.len() <= DRAWING { ("svg+xml", drawing.into_bytes()) } else { ("png", picture.png(plots::DEFAULT_DPI)?) };
        Ok(Self { title, says, source: format!("data:image/{kind};base64,{}", STANDARD.encode(bytes)) })
    }

    /// Where a page finds it: within itself.
    pub fn source(&self) -> &str {
        &self.source
    }
}
