//! The image, or the probabilities of vessels, in which candidates are looked at.

use serde::{Deserialize, Serialize};

use super::{InferOptions, Input, SourceFile, models::LoadedPrior};
use crate::{Appearance, Error, Network, Result};
use willis_core::{error::Fault, network::Origin, support::geometry::Point, support::geometry::distance};
use willis_io::masks::{Scene, Unseen, View};
use willis_io::{formats::read_image, masks::cubes::ImageCube};
use willis_report::ImagePlace;

/// Vessels whose probability is at least so far from 0 and 1 are looked at, ...
const LEAST_DOUBT: f64 = 0.02;
/// ... at no more than this many places unless it is said otherwise, those of the most doubtful ones, ...
const MOST_PLACES: usize = 50;
/// ... which are so far apart, m.
const APART: f64 = 3e-3;

/// The image around doubtful vessels and contacts, the most doubtful first, at no more than `most` places.
pub(crate) fn image_places(scene: &Scene, graph: &Network, most: Option<usize>) -> Vec<ImagePlace> {
    let most = most.unwrap_or(MOST_PLACES);
    let open = graph.vessels().enumerate().filter(|(_, (_, vessel))| vessel.origin != Origin::Observed);
    let from_half = open.filter_map(|(row, (_, vessel))| Some(((vessel.evidence()?.probability - 0.5).abs(), row)));
    let mut doubtful: Vec<(f64, usize)> = from_half.filter(|(away, _)| *away <= 0.5 - LEAST_DOUBT).collect();
    doubtful.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut places: Vec<(Point, Vec<usize>)> = Vec::new();
    for (_, row) in doubtful {
        let at = graph.middle_of(graph.ends(row), graph.vessel(row));
        let is_full = places.len() == most;
        match places.iter_mut().find(|(place, _)| distance(*place, at) < APART) {
            Some((_, rows)) => rows.push(row),
            None if !is_full => places.push((at, vec![row])),
            None => {}
        }
    }
    places.into_iter().filter_map(|(at, rows)| Some(ImagePlace::of(rows, at, &ImageCube::new(scene, at)?))).collect()
}

/// In which image candidates were looked at, as run.json has it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct ImageRecord {
    #[serde(flatten)]
    pub(super) source: SourceFile,
    pub(super) vessels: Appearance,
    pub(super) probabilities: bool,
    /// Why it was not used.
    pub(super) unused: Option<String>,
}

impl ImageRecord {
    /// Reads the image, and says where it is from, for a prior that looks at images, in the frame of the vessels of an input; the spacing of
    /// NumPy's arrays goes by how those were read. `None` where none is given.
    ///
    /// # Errors
    ///
    /// Image and probabilities at once, a prior that does not look at images, a ready graph, a file that cannot be read, a value that is no
    /// probability.
    pub(crate) fn load(options: &InferOptions, prior: &LoadedPrior, input: &Input) -> Result<Option<(Self, View)>> {
        let (name, path) = match (&options.image, &options.probability) {
            (None, None) => return Ok(None),
            (Some(path), None) => ("image", path),
            (None, Some(path)) => ("probability", path),
            (Some(_), Some(path)) => {
                return Err(Error::parameter("probability", path.display(), "expected this or `image`, not both"));
            }
        };
        let refused = |accepted: &str| Err(Error::parameter(name, path.display(), accepted));
        let ready = "goes with a mask or centerlines; a ready graph states the probability of its candidates (see `observed`)";
        let why = "goes with a model that knows images: `prior=weights:skeleton`, which is the usual one of masks and skeletons";
        if !input.is_fragments {
            return refused(ready);
        }
        if prior.noise_of_images().is_none() {
            return refused(why);
        }
        let (image, sha256) = read_image(path, &input.options, input.network.frame)?;
        let probabilities = options.probability.is_some();
        let not_one = |x: f32| Fault::item("a voxel", x.to_string(), "expected probabilities from 0 to 1").in_file(path);
        let image = if probabilities { image.log_odds().map_err(not_one)? } else { image };
        let vessels = if probabilities { Appearance::Bright } else { options.vessels };
        let source = SourceFile { path: path.clone(), sha256 };
        Ok(Some((Self { source, vessels, probabilities, unused: None }, View { image, appearance: vessels })))
    }

    /// What a person should know of the image: that it does not show the vessels, or is noisier than the model knows.
    pub(crate) fn remarks(&self, unseen: Option<Unseen>, scene: Option<&Scene>, prior: &LoadedPrior) -> Vec<String> {
        let path = self.source.path.display();
        let why = unseen.map(|why| format!("{path} does not show the vessels: {why}; candidates are judged without it"));
        // One with less noise than those that the model was fitted to is only clearer.
        let noisy = |noise: f64| {
            let [least, most] = prior.noise_of_images().filter(|[_, most]| noise > *most)?;
            let contrast = format!("{noise:.2} of the contrast of vessels, which the model knows from {least:.2} to {most:.2}");
            Some(format!("{path}: the noise is {contrast}; its probabilities are less sure here"))
        };
        why.into_iter().chain(scene.and_then(|scene| noisy(scene.noise_share))).collect()
    }
}
