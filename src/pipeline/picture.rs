//! The image in which candidates are looked at.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::options::{InferOptions, SourceFile};
use super::prior::LoadedPrior;
use crate::candidates::joins::image::scene::{Appearance, Unseen, View};
use crate::error::{Error, Result};
use crate::io::{ReadOptions, read_image};

/// Where an image was read from.
pub(crate) struct Picture {
    source: SourceFile,
    appearance: Appearance,
}

impl Picture {
    /// Reads the image, and says where it is from, for a prior that looks at images; `input` says how the vessels were read, which the spacing of NumPy's arrays goes by.
    ///
    /// # Errors
    ///
    /// A prior that does not, a ready graph, an image that cannot be read.
    pub(crate) fn load(
        path: &Path,
        options: &InferOptions,
        prior: &LoadedPrior,
        input: &ReadOptions,
        is_fragments: bool,
    ) -> Result<(Self, View)> {
        if !is_fragments {
            let accepted =
                "goes with a mask or centerlines; a ready graph states the probability of its candidates (see `observed`)";
            return Err(Error::parameter("image", path.display(), accepted));
        }
        if !prior.looks_at_images() {
            let accepted =
                "goes with a model that knows images: `prior` weights:skeleton, which is the usual one of masks and skeletons";
            return Err(Error::parameter("image", path.display(), accepted));
        }
        let (image, sha256) = read_image(path, input)?;
        let source = SourceFile { path: path.to_owned(), sha256 };
        Ok((Self { source, appearance: options.vessels }, View { image, appearance: options.vessels }))
    }

    pub(crate) fn path(&self) -> &PathBuf {
        &self.source.path
    }

    /// The record in run.json: the file, and why it was not used.
    pub(crate) fn record(&self, unseen: Option<Unseen>) -> Value {
        let Self { source, appearance, .. } = self;
        json!({ "path": source.path, "sha256": source.sha256, "vessels": appearance, "unused": unseen.map(|why| why.to_string()) })
    }
}
