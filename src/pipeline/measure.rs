//! What is measured of an input, with the doubt about its topology where there is a run; and two groups of subjects compared in it.

use std::{borrow::Cow, collections::HashMap, collections::HashSet, path::Path, path::PathBuf};

use serde::{Deserialize, Serialize};

use super::arteries::{FoundArteries, draw_topologies};
use super::{ArterySource, BoundaryOptions, Follow, Input, PhenotypeOptions, require};
use crate::{Error, Network, ReadOptions, Result, SamplingOptions};
use willis_core::morphometry::{MeasureContext, Morphometry, Region, SMOOTHING, Smoothing, network_figures};
use willis_core::network::units::{metres, millimetres};
use willis_core::support::comparison::{GroupDifference, compare, drawn_by_weight, holm, quartiles};
use willis_core::support::geometry::{Point, bounds, cross, dot, norm_squared};
use willis_core::support::{distinct, in_order, list_of, suggestions::did_you_mean};
use willis_core::{error::Fault, error::ensure, flow::Boundary, network::Role};
use willis_io::{formats::Column, formats::read_image, masks::Picture, masks::Unseen};
use willis_report::{CircleFigures, MeasuredSubject, NamedFigures, cohort::Figures, named_figures};

/// So many topologies of a run are drawn.
const DRAWN: u64 = 200;

/// How vessels are measured.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeasureOptions {
    /// Where blood enters, from which orders and ways are counted.
    pub boundary: BoundaryOptions,
    /// The length over which courses are smoothed before bends are measured, m; six radii of each vessel without it.
    pub smoothing: Option<f64>,
    /// A mask of the brain, to which densities refer.
    pub brain: Option<PathBuf>,
    /// The diameter below which a segment of the circle is hypoplastic, m; 1 mm without it.
    pub hypoplastic: Option<f64>,
}

impl MeasureOptions {
    /// Checks the lengths.
    ///
    /// # Errors
    ///
    /// A length that is not positive.
    pub fn validate(&self) -> Result<()> {
        self.phenotypes().validate()?;
        let length = self.smoothing.unwrap_or(1.0);
        require(length.is_finite() && length > 0.0, "smoothing", millimetres(length), "expected a positive length, in mm")
    }

    fn smoothing(&self) -> Smoothing {
        self.smoothing.map_or(Smoothing::Radii(SMOOTHING), Smoothing::Length)
    }

    fn phenotypes(&self) -> PhenotypeOptions {
        PhenotypeOptions { hypoplastic: self.hypoplastic, ..PhenotypeOptions::default() }
    }
}

/// What was measured of an input.
#[derive(Debug)]
pub struct Measurement {
    name: String,
    /// The SHA-256 of the file that was read.
    pub sha256: String,
    network: Network,
    roles: Vec<Role>,
    /// Vessel by vessel, and the whole.
    pub measured: Morphometry,
    /// The figures of the whole.
    pub figures: NamedFigures,
    /// Those of each plausible topology of a run, with its weight.
    pub plausible: Vec<(NamedFigures, f64)>,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// Measures the vessels of an input, as subject `name`; of a run, as [`read_run`](crate::read_run) has it, the plausible topology, and
/// beside it those that are plausible too.
///
/// # Errors
///
/// An option out of its range, a condition at a node that is not there, a mask of the brain that cannot be read or holds none.
pub fn measure(name: &str, input: &Input, options: &MeasureOptions, progress: &mut dyn Follow) -> Result<Measurement> {
    options.validate()?;
    input.network.validate()?;
    let mut notes = Vec::new();
    let (network, kept): (Cow<'_, Network>, Vec<bool>) = if let Some(run) = &input.run {
        (Cow::Borrowed(&input.network), run.kept(input.network.vessel_count())?)
    } else {
        let network = if input.is_fragments { Cow::Owned(input.divided_by_labels()) } else { Cow::Borrowed(&input.network) };
        let (present, note) = willis_models::circle_of_willis::present_vessels(&network);
        notes.extend(note.map(str::to_owned));
        let network = network.subgraph(|row| present[row]).0;
        let all = vec![true; network.vessel_count()];
        (Cow::Owned(network), all)
    };
    let network = &*network;
    let outlets = options.boundary.found_outlets.unwrap_or_else(|| input.usual_outlets());
    let resolve = |given: Vec<_>| Boundary::resolve_knowing(network, &given, outlets, &input.inlets_by_labels());
    let boundary = match options.boundary.given(network, progress).and_then(resolve) {
        Ok(boundary) => Some(boundary),
        // A ring has no end to enter by: it has no orders, but a length.
        Err(why) if !options.boundary.states_an_inlet() => {
            notes.push(format!("no orders and no ways from inlets: {why}"));
            None
        }
        Err(why) => return Err(why),
    };
    let flat = (!network.has_positions()).then(|| "nodes without positions: no chords, bends, angles and boxes".to_owned());
    notes.extend(flat);
    let brain = options.brain.as_ref().map(|path| brain(path, &input.options, network, &mut notes)).transpose()?;
    let phenotypes = options.phenotypes();
    let found = arteries(input, network, &phenotypes, &mut notes);
    let by_territory = found.as_ref().map(|found| found.circle.arteries_in(network, |_| true).1.territories);
    let territory = by_territory.map_or_else(Vec::new, |rows| list_of(network.vessel_count(), &rows));
    let measuring = Measuring { network, boundary, region: brain.as_ref(), territory, found, phenotypes };
    let plausible = measuring.plausible(input, progress)?.into_iter();
    let plausible = plausible.map(|(kept, weight)| (measuring.figures(&kept), weight)).collect();
    let (part, rows) = network.subgraph(|row| kept[row]);
    let roles = measuring.roles(&kept);
    let territory = measuring.territory_of(&rows);
    let around = MeasureContext { territory: &territory, region: brain.as_ref() };
    let measured = Morphometry::of(&part, |node| roles[node], options.smoothing(), around);
    let figures = named_figures(&measured.network, measuring.circle(&kept).as_ref());
    let sha256 = input.provenance.sha256.clone();
    Ok(Measurement { name: name.to_owned(), sha256, network: part, roles, measured, figures, plausible, notes })
}

/// A network whose topologies are measured.
struct Measuring<'a> {
    network: &'a Network,
    /// Where blood enters and leaves, where any does.
    boundary: Option<Boundary>,
    region: Option<&'a Region>,
    /// By vessel; none at all without arteries.
    territory: Vec<Option<usize>>,
    found: Option<FoundArteries>,
    phenotypes: PhenotypeOptions,
}

impl Measuring<'_> {
    fn roles(&self, kept: &[bool]) -> Vec<Role> {
        let none = || vec![Role::Inner; self.network.node_count()];
        self.boundary.as_ref().map_or_else(none, |boundary| boundary.held(self.network, |row| kept[row]).roles)
    }

    fn territory_of(&self, rows: &[usize]) -> Vec<Option<usize>> {
        rows.iter().filter_map(|row| self.territory.get(*row)).copied().collect()
    }

    /// What is measured of the topology of the vessels `kept` as a whole.
    fn figures(&self, kept: &[bool]) -> NamedFigures {
        let (roles, (part, rows)) = (self.roles(kept), self.network.subgraph(|row| kept[row]));
        let territory = self.territory_of(&rows);
        let around = MeasureContext { territory: &territory, region: self.region };
        named_figures(&network_figures(&part, |node| roles[node], around), self.circle(kept).as_ref())
    }

    /// The circle in the topology of the vessels `kept`, where arteries are known.
    fn circle(&self, kept: &[bool]) -> Option<CircleFigures> {
        let found = self.found.as_ref()?;
        let variant = found.circle.variant(self.network, |row| kept[row]);
        Some(found.circle_figures(self.network, &variant, kept, &self.phenotypes))
    }

    /// The vessels of topologies that a run finds plausible, with their weights, by the probabilities of their connections.
    fn plausible(&self, input: &Input, progress: &mut dyn Follow) -> Result<Vec<(Vec<bool>, f64)>> {
        let (network, Some(run), Some(boundary)) = (self.network, &input.run, &self.boundary) else { return Ok(Vec::new()) };
        let options = SamplingOptions { samples: DRAWN, ..run.options.infer.sampling.clone() };
        let above = super::classify::above_median(network, boundary, &options, progress)?;
        let (found, above) = (self.found.as_ref(), above.as_deref());
        Ok(draw_topologies(found, network, boundary, &options, &run.given, above, false)?.0.weighted)
    }
}

/// Where the arteries are: as the run knew them, or by labels that name any.
fn arteries(input: &Input, network: &Network, phenotypes: &PhenotypeOptions, notes: &mut Vec<String>) -> Option<FoundArteries> {
    if let Some(named) = input.run.as_ref().and_then(|run| run.named.clone()) {
        return Some(named);
    }
    let of_run = input.run.as_ref().and_then(|run| run.options.infer.arteries.clone());
    let source = of_run.as_ref().unwrap_or(&ArterySource::Automatic).resolved(network, input.is_topcow);
    if source == ArterySource::Geometry {
        return None;
    }
    let scale = input.run.as_ref().map_or(&input.options.scale, |run| &run.options.read.scale);
    let found = source.find(Path::new(&input.provenance.input), network, scale, phenotypes);
    if let (Err(why), Some(_)) = (&found, &of_run) {
        notes.push(format!("nothing is told of a circle of Willis: {why}"));
    }
    found.ok()
}

/// The voxels of a mask that are not zero, around a network; a note where they hold less than half of it.
fn brain(path: &Path, options: &ReadOptions, network: &Network, notes: &mut Vec<String>) -> Result<Region> {
    let (mut image, _) = read_image(path, options, network.frame)?;
    image.values.iter_mut().for_each(|x| *x = f32::from(u8::from(*x != 0.0 && x.is_finite())));
    let columns = [0, 1, 2].map(|axis| image.affine.map(|row| row[axis]));
    let voxel = dot(columns[0], cross(columns[1], columns[2])).abs();
    let count = image.values.iter().filter(|x| **x > 0.0).count();
    let step = 0.5 * columns.iter().map(|column| norm_squared(*column).sqrt()).fold(f64::INFINITY, f64::min);
    let refused = |found: &str| Fault::file(found, "expected a mask of the brain around the vessels").in_file(path);
    ensure(count > 0, || refused("no voxel above 0"))?;
    let places: Vec<Point> = network.places().collect();
    let (own, around) = (image.bounds(), bounds(places.iter().copied()));
    let unseen = || refused(&format!("does not show the vessels: {}", Unseen::by(own, around)));
    let picture = Picture::of(image, around, 0.0).ok_or_else(unseen)?;
    let holds = move |place: Point| picture.value(place).is_some_and(|x| x >= 0.5);
    let held = places.iter().filter(|place| holds(**place)).count();
    ensure(held > 0, unseen)?;
    if 2 * held < places.len() {
        let share = 100.0 * held as f64 / places.len() as f64;
        notes.push(format!("{} holds {share:.1} % of the points of the vessels", path.display()));
    }
    let volume = count as f64 * voxel * metres(1.0).powi(3);
    Ok(Region { volume, step: metres(step), holds: Box::new(holds) })
}

impl Measurement {
    fn subject(&self) -> MeasuredSubject<'_> {
        MeasuredSubject { name: &self.name, network: &self.network, measured: &self.measured }
    }

    /// The columns of vessels.csv, bifurcations.csv, ends.csv and intervals.csv; the last has no row without a run.
    pub fn tables(&self) -> [Vec<Column>; 4] {
        let subject = self.subject();
        let ends = subject.ends(|node| self.roles[node]);
        [subject.vessels(), subject.bifurcations(), ends, subject.intervals(&self.figures, &self.plausible)]
    }

    /// The figures of its row in subjects.csv.
    pub fn row(&self) -> Figures {
        self.figures.iter().map(|(name, x)| (name.clone(), serde_json::json!(Some(*x).filter(|x| x.is_finite())))).collect()
    }
}

/// So many times a plausible topology is drawn for each subject.
const IMPUTATIONS: usize = 20;

/// How groups are compared.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ComparisonOptions {
    /// The measures that are compared, by their columns in subjects.csv; all without any.
    pub measures: Vec<String>,
    /// The seed of topologies and permutations.
    pub seed: u64,
}

/// The two groups among the values that subjects have, in the order of their names, and of each subject whether it is in the first; none for one
/// without a value.
///
/// # Errors
///
/// More or fewer than two groups, or one of a single subject.
pub fn two_groups(column: &str, values: &[&str]) -> Result<([String; 2], Vec<Option<bool>>)> {
    let names = distinct(values.iter().copied().filter(|value| !value.is_empty()));
    let refused =
        |why: String| Err(Error::parameter("compare", column, format!("expected two groups of two subjects at least, {why}")));
    let [first, second] = *names else {
        let shown: Vec<&str> = names.iter().copied().take(4).collect();
        let more = if names.len() > shown.len() { ", ..." } else { "" };
        return refused(format!("found {}: {}{more}", names.len(), shown.join(", ")));
    };
    for name in [first, second] {
        if values.iter().filter(|value| **value == name).count() < 2 {
            return refused(format!("found one of {column} {name}"));
        }
    }
    let of = values.iter().map(|value| (!value.is_empty()).then(|| *value == first)).collect();
    Ok(([first.to_owned(), second.to_owned()], of))
}

/// The columns of comparison.csv: how the subjects of two groups differ in each measure. `subjects` are those measured, each with whether it is in
/// the first group.
///
/// # Errors
///
/// A measure that no subject has.
pub fn compare_groups(groups: &[String; 2], subjects: &[(&Measurement, bool)], how: &ComparisonOptions) -> Result<Vec<Column>> {
    let names = measures(subjects, &how.measures)?;
    let first: Vec<bool> = subjects.iter().map(|(_, first)| *first).collect();
    let tables: Vec<Vec<HashMap<&str, f64>>> = subjects
        .iter()
        .enumerate()
        .map(|(at, (found, _))| imputed(found, how.seed, at).into_iter().map(by_name).collect())
        .collect();
    let kept: Vec<HashMap<&str, f64>> = subjects.iter().map(|(found, _)| by_name(&found.figures)).collect();
    let of = |table: &HashMap<&str, f64>, name: &str| table.get(name).copied().unwrap_or(f64::NAN);
    let differences = in_order(&names, |_, name| {
        let imputations: Vec<Vec<f64>> =
            (0..IMPUTATIONS).map(|draw| tables.iter().map(|subject| of(&subject[draw], name)).collect()).collect();
        compare(&imputations, &first, how.seed)
    });
    let found: Vec<_> = names.iter().zip(differences).filter_map(|(name, d)| Some((name, d?))).collect();
    let corrected = holm(&found.iter().map(|(_, d)| d.p).collect::<Vec<_>>());
    let spread = |name: &str, group: bool| {
        quartiles(kept.iter().zip(&first).filter(|(_, is)| **is == group).map(|(table, _)| of(table, name)))
    };
    let spreads: Vec<_> = found.iter().map(|(name, _)| [true, false].map(|group| spread(name, group))).collect();
    let mut columns = vec![Column::text("measure", found.iter().map(|(name, _)| name.to_string()))];
    for (side, (letter, name)) in ["a", "b"].into_iter().zip(groups).enumerate() {
        columns.push(Column::text(format!("group_{letter}"), found.iter().map(|_| name.clone())));
        columns.push(Column::whole(format!("n_{letter}"), spreads.iter().map(|of| of[side].0)));
        for (at, what) in ["quartile_1", "median", "quartile_3"].into_iter().enumerate() {
            columns.push(Column::real(format!("{what}_{letter}"), spreads.iter().map(|of| of[side].1[at])));
        }
    }
    let real = |name, of: fn(&GroupDifference) -> f64| Column::real(name, found.iter().map(move |(_, d)| of(d)));
    columns.extend([
        real("cliffs_delta", |d| d.delta),
        real("delta_low", |d| d.interval[0]),
        real("delta_high", |d| d.interval[1]),
        real("doubt_share", |d| d.doubt),
        real("p", |d| d.p),
        Column::real("p_holm", corrected.into_iter()),
    ]);
    Ok(columns)
}

fn by_name(figures: &NamedFigures) -> HashMap<&str, f64> {
    figures.iter().map(|(name, x)| (&**name, *x)).collect()
}

/// The measures that are wanted, of those that any subject has.
fn measures<'a>(subjects: &[(&'a Measurement, bool)], wanted: &[String]) -> Result<Vec<Cow<'a, str>>> {
    let mut known = HashSet::new();
    let all = subjects.iter().flat_map(|(found, _)| &found.figures).map(|(name, _)| Cow::Borrowed(&**name));
    let all: Vec<Cow<'a, str>> = all.filter(|name| known.insert(name.clone())).collect();
    if let Some(missing) = wanted.iter().find(|name| !all.iter().any(|known| *known == **name)) {
        let meant = did_you_mean(missing, all.iter().map(|name| &**name));
        let accepted = format!("{meant}expected columns of subjects.csv that are measured");
        return Err(Error::parameter("measures", format!("\"{missing}\""), accepted));
    }
    Ok(all.into_iter().filter(|name| wanted.is_empty() || wanted.iter().any(|wanted| **wanted == **name)).collect())
}

/// The figures of topologies that are drawn by their weights; without doubt those that are kept, every time. `number` is that of the subject.
fn imputed(found: &Measurement, seed: u64, number: usize) -> Vec<&NamedFigures> {
    let weights: Vec<f64> = found.plausible.iter().map(|(_, weight)| *weight).collect();
    let drawn = drawn_by_weight(&weights, IMPUTATIONS, seed, number as u64);
    if drawn.is_empty() {
        return vec![&found.figures; IMPUTATIONS];
    }
    drawn.into_iter().map(|at| &found.plausible[at].0).collect()
}
