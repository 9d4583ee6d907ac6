//! Names for the arteries of an input: labels, landmarks, and which segments of the ring are there.

use std::{path::Path, path::PathBuf, sync::Arc};

use serde_json::{Value, json};

use super::{ArterySource, Follow, InferOptions, Input, Prepared, classify::plausible, prepare, stage_target};
use crate::{Network, Result};
use willis_core::network::{Frame, units::metres};
use willis_core::support::geometry::Point;
use willis_io::formats::{
    Column, Format, LandmarkFormat, MarkedPoint, POSITION_COLUMNS, SURE, coordinate_columns, graph_columns, write_csv,
    write_graphml, write_landmarks,
};
use willis_io::{formats::convert::Target, output::StagedFiles, output::names::BESIDE_LABELLED};
use willis_models::circle_of_willis::RING;
use willis_models::naming::atlas::{LABELS, OTHER, name_of};
use willis_models::naming::{NamedPlace, Names, labelled_network, nothing_named};
use willis_report::{Provenance, by_artery};

/// An input whose arteries have names.
#[derive(Debug)]
pub struct Labelled {
    /// The over-connected graph that was named.
    pub prepared: Arc<Prepared>,
    /// The names.
    pub names: Arc<Names>,
    /// For each segment of [`RING`] the probability that it is there, as [`classify`](crate::classify) gives it.
    pub segments: [f64; 7],
    /// For each of them whether too little is seen, of it and of what lies at its ends, as [`classify`](crate::classify) has it.
    pub not_seen: [bool; 7],
    /// The landmarks, in mm and RAS.
    pub landmarks: Vec<NamedPlace>,
    /// The observed vessels and kept connections with their names, divided where the name changes.
    pub network: Network,
    /// The probability of each vessel's name; none for a vessel without one.
    pub probability: Vec<Option<f64>>,
}

/// Names the arteries of an input by their geometry, whatever else the options name them by: exactly what `willis label` does. Candidates pass
/// names over gaps.
///
/// # Errors
///
/// As [`infer`](crate::infer) before any sample; a network without positions.
pub fn label(input: Input, options: &InferOptions, progress: &mut dyn Follow) -> Result<Labelled> {
    let by_geometry = InferOptions { arteries: Some(ArterySource::Geometry), ..options.clone() };
    let models = by_geometry.phenotypes.models()?;
    let (path, own) = (input.provenance.input.clone(), input.undivided().nodes().cloned().collect::<Vec<_>>());
    let prepared = prepare(input, &by_geometry, progress)?;
    let found = prepared.arteries.as_ref();
    let (names, segments, not_seen) = if let Some((found, names)) = found.and_then(|found| Some((found, found.names.clone()?))) {
        let posterior = plausible(&prepared, found, progress)?.2;
        (names, posterior.segments, posterior.not_seen)
    } else {
        let names = models.name(&prepared.graph).ok_or_else(|| nothing_named(&prepared.graph).in_file(Path::new(&path)))?;
        // Where no circle was found, topologies say nothing of one.
        let circle = names.circle(models.of(&names));
        let segments = circle.presence(&[0.5; 7], &by_geometry.phenotypes.prior()?);
        (Arc::new(names), segments, circle.not_seen())
    };
    let landmarks = names.landmarks(models.of(&names));
    let (network, probability) = labelled_network(&prepared.graph, &own, &names, prepared.options.read.radius_rule);
    Ok(Labelled { prepared, names, segments, not_seen, landmarks, network, probability })
}

impl Labelled {
    /// Checks, before the work begins, that the files can be written.
    ///
    /// # Errors
    ///
    /// One that stands already, where `force` is off; a name that no file can have.
    pub fn check(target: &Target, force: bool) -> Result<()> {
        let beside = BESIDE_LABELLED.map(|ending| target.path.with_extension(ending));
        StagedFiles::check(&target.path, target.nodes.iter().chain(&beside), force)
    }

    /// Writes the labelled vessels in the format of a target, and beside them the names, the segments and the landmarks: all or none.
    ///
    /// # Errors
    ///
    /// As [`Labelled::check`]; a network that the format cannot hold, a file that cannot be written.
    pub fn write(&self, target: &Target, force: bool) -> Result<Vec<PathBuf>> {
        let mut staged = StagedFiles::new(&target.path, force)?;
        let [names, segments, table, markups] = BESIDE_LABELLED.map(|ending| target.path.with_extension(ending));
        self.stage_network(target, &mut staged)?;
        self.stage_names(&names, &mut staged)?;
        self.stage_segments(&segments, &mut staged)?;
        self.stage_landmarks(&table, LandmarkFormat::Csv, &mut staged)?;
        self.stage_landmarks(&markups, LandmarkFormat::Markups, &mut staged)?;
        staged.commit()
    }

    /// The table of names: a row for about every millimetre.
    fn stage_names(&self, path: &Path, staged: &mut StagedFiles) -> Result<()> {
        let names = &self.names;
        let nodes = &names.nodes;
        let best = names.best();
        let real = |name: &'static str, of: &dyn Fn(usize) -> f64| Column::real(name, (0..nodes.len()).map(of));
        let places = || nodes.at.iter().map(|at| self.in_its_frame(*at));
        let mut columns = coordinate_columns(POSITION_COLUMNS, places).to_vec();
        columns.extend([
            real("radius_mm", &|n| nodes.log_radius[n].exp()),
            Column::whole("edge", (0..nodes.len()).map(|n| nodes.place[n].vessel)),
            real("along_mm", &|n| nodes.place[n].along),
            real("length_mm", &|n| nodes.weight[n]),
            Column::text("label", best.iter().map(|label| if *label == OTHER { String::new() } else { name_of(*label) })),
            real("probability", &|n| names.labels[n][best[n]]),
        ]);
        let of_label = |label: usize| (0..nodes.len()).map(move |n| names.labels[n][label]);
        columns.extend((0..LABELS).map(|label| Column::real(format!("p_{}", name_of(label)), of_label(label))));
        staged.write(path, |out| write_csv(out, &columns))
    }

    /// The landmarks: a CSV table, or the point list of 3D Slicer.
    fn stage_landmarks(&self, path: &Path, format: LandmarkFormat, staged: &mut StagedFiles) -> Result<()> {
        let points = self.landmarks.iter().map(|mark| {
            let at = self.in_its_frame(mark.at).map(metres);
            MarkedPoint { probability: Some(mark.probability), ..MarkedPoint::new(mark.label.clone(), at) }
        });
        let points: Vec<MarkedPoint> = points.collect();
        staged.write(path, |out| write_landmarks(out, format, self.names.bearings.frame, &points))
    }

    /// The labelled vessels in the format of a target; GraphML has the probability of each label too.
    fn stage_network(&self, target: &Target, staged: &mut StagedFiles) -> Result<()> {
        if target.format != Format::GraphMl {
            return stage_target(&self.network, target, staged).map(drop);
        }
        let (nodes, mut vessels) = graph_columns(&self.network);
        vessels.push(Column::real("label_probability", self.probability.iter().map(|p| p.unwrap_or(f64::NAN))));
        staged.write_main(|out| write_graphml(out, &self.network, &nodes, &vessels))
    }

    /// How many landmarks a person should look at.
    pub fn doubtful(&self) -> usize {
        self.landmarks.iter().filter(|mark| mark.probability < SURE).count()
    }

    /// How many vessels have a name.
    pub fn named(&self) -> usize {
        self.network.vessels().filter(|(_, vessel)| !vessel.label.is_empty()).count()
    }

    /// What came out, in short.
    pub fn record(&self) -> Value {
        let Provenance { command, notes, .. } = &self.prepared.provenance;
        json!({
            "willis": env!("CARGO_PKG_VERSION"),
            "command": command,
            "input": self.prepared.provenance.of_input(),
            "frame": self.names.bearings.frame.name(),
            "frame_was_found": self.names.frame_was_found,
            "notes": notes.iter().chain(&self.notes()).collect::<Vec<_>>(),
            "counts": {
                "vessels": self.network.vessel_count(),
                "named": self.named(),
                "landmarks": self.landmarks.len(),
                "doubtful": self.doubtful(),
            },
            "segments": by_artery(&RING, self.segments),
        })
    }

    /// What a person should know: where the frame comes from.
    pub fn notes(&self) -> Vec<String> {
        self.names.frame_note().into_iter().collect()
    }

    /// Which segments of the ring are there.
    fn stage_segments(&self, path: &Path, staged: &mut StagedFiles) -> Result<()> {
        let names = &self.names;
        let columns = [
            Column::text("segment", RING.iter().map(ToString::to_string)),
            Column::real("probability", self.segments.iter().copied()),
            Column::real("length_mm", (0..7).map(|s| names.seen_length(s))),
            Column::whole("not_seen", self.not_seen.into_iter().map(usize::from)),
        ];
        staged.write(path, |out| write_csv(out, &columns))
    }

    /// A position in RAS in the frame of the file.
    fn in_its_frame(&self, at: Point) -> Point {
        Frame::Ras.turn(self.names.bearings.frame, at)
    }
}
