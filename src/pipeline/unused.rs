//! Options that an input has no use for: they are refused, or a note says that they change nothing. A file that is named is opened in any case.

use std::fs::File;
use std::io::Read;

use super::arteries::FoundArteries;
use super::cuts::{Cut, Cuts};
use super::{InferOptions, Input, PhenotypeOptions, Preset};
use willis_core::error::{Error, Result};
use willis_core::network::units::millimetres;
use willis_io::masks::Appearance;

/// Refuses options of `infer` that nothing will look at; the notes on those that change nothing. `cuts` is what the input is cut by.
///
/// # Errors
///
/// Names the option, its value and what it goes with; a named file that cannot be read.
pub(super) fn refuse(input: &Input, options: &InferOptions, cuts: Option<&Cuts>) -> Result<Vec<String>> {
    if !input.is_fragments {
        refuse_on_ready_graph(options)?;
    }
    let is_cut = matches!(options.cut, Cut::Always | Cut::File(_));
    if is_cut && !input.network.has_positions() {
        return Err(Error::parameter("cut", options.cut.to_string(), "goes with vessels whose nodes have positions"));
    }
    if options.vessels != Appearance::default() && options.image.is_none() {
        return Err(Error::parameter("vessels", "", "goes with `image`"));
    }
    if let Some(most) = options.image_places.filter(|_| options.image.is_none() && options.probability.is_none()) {
        return Err(Error::parameter("image_places", most, "goes with `image` or `probability`"));
    }
    if options.arteries.is_none()
        && let Some((name, value)) = given(&options.phenotypes).into_iter().next()
    {
        let accepted = "goes with `landmarks` or `labels`, which say that there is a Circle of Willis";
        return Err(Error::parameter(name, value, accepted));
    }
    options.phenotypes.check_files()?;
    let mut notes = Vec::new();
    if let Some(mask) = options.mask.as_ref().filter(|_| cuts.is_none()) {
        let opened = File::open(mask).and_then(|file| file.take(1).read_to_end(&mut Vec::new()));
        opened.map_err(|source| Error::Read { path: mask.clone(), source })?;
        let by_itself = "only automatic skeletons are cut apart by themselves (`cut=always` does so here)";
        let why = if options.cut == Cut::Never { "`cut` never leaves all vessels together" } else { by_itself };
        notes.push(format!("`mask` changes nothing: {why}"));
    }
    Ok(notes)
}

/// Refuses what is about candidates that are built, where they stand already.
fn refuse_on_ready_graph(options: &InferOptions) -> Result<()> {
    let usual = if options.preset == Preset::Paper { InferOptions::paper() } else { InferOptions::default() };
    let (given, usual) = (&options.candidates, &usual.candidates);
    let mm = |length: Option<f64>| length.map(|m| format!("{} mm", millimetres(m)));
    let word = |value: serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let all = [
        ("k", given.k.map(|k| k.to_string())),
        ("max_gap", mm(given.max_gap)),
        ("attach", (given.attach != usual.attach).then(|| word(serde_json::json!(given.attach)))),
        ("candidate_radius", (given.radius != usual.radius).then(|| word(serde_json::json!(given.radius)))),
        ("max_candidate_radius", mm(given.max_radius)),
        ("cut", matches!(options.cut, Cut::Always | Cut::File(_)).then(|| options.cut.to_string())),
        ("mask", options.mask.as_ref().map(|path| path.display().to_string())),
    ];
    let accepted = "goes with a mask or centerlines; this is a ready graph, whose candidates stand (see `observed`)";
    let first = all.into_iter().find_map(|(name, value)| Some(Error::parameter(name, value?, accepted)));
    first.map_or(Ok(()), Err)
}

/// The options of a circle that were given, with their values.
fn given(phenotypes: &PhenotypeOptions) -> Vec<(&'static str, String)> {
    let PhenotypeOptions { frequencies, unseen, arteries, hypoplastic } = phenotypes;
    let all = [
        ("variant_prior", frequencies.as_ref().map(|path| path.display().to_string())),
        ("unseen", unseen.map(|share| share.to_string())),
        ("arteries", arteries.as_ref().map(|path| path.display().to_string())),
        ("hypoplastic", hypoplastic.map(|diameter| format!("{} mm", millimetres(diameter)))),
    ];
    all.into_iter().filter_map(|(name, value)| value.map(|value| (name, value))).collect()
}

/// The note that what is known of people's circles changes nothing, where the arteries have no names by geometry.
pub(super) fn note_on_names(phenotypes: &PhenotypeOptions, found: &FoundArteries) -> Option<String> {
    let given = given(phenotypes).into_iter().map(|(name, _)| name).filter(|name| *name != "hypoplastic");
    let names: Vec<String> = given.map(|name| format!("`{name}`")).collect();
    if names.is_empty() || found.named.is_some() {
        return None;
    }
    let (change, known_by) = (if names.len() == 1 { "changes" } else { "change" }, &found.known_by);
    let names = names.join(", ");
    Some(format!("{names} {change} nothing: the arteries are known by {known_by}, not named by their geometry"))
}
