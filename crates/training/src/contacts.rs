//! Fits the contact model to skeletons whose true vessels are known: boosted trees over pairs of branch ends, then the weights of
//! partitions on scores of trees that never saw the subject.

use ndarray::Array2;

use super::boosting::boost;
use super::example::{Case, Example, Model, TreeExample, binned, dealt, grouped, image_name, name_of, shown};
use super::minimise::{calibrate_in_order, minimise};
use willis_core::error::{Result, require};
use willis_core::network::Origin;
use willis_core::support::{boosted_trees::Boosted, in_order, model_provenance::ModelProvenance};
use willis_io::formats::{ReadOptions, read_mask};
use willis_io::masks::{Field, Foreground};
use willis_models::candidates::resample::{CenterlineKind, Resampled};
use willis_models::contacts::branches::{Branches, MOST_ENDS};
use willis_models::contacts::features::pairs_among;
use willis_models::contacts::model::{ContactKind, ContactModel, ContactPart, ContactScores, Crowding, NOT_CALIBRATED};
use willis_models::contacts::partition::{
    PARTITION_FEATURES, PartitionWeights, SIZES, most_probable_blocks, numbered, pair_probabilities, partition_features,
    partitions, size_of,
};
use willis_models::contacts::{Basis, pair_features, scores_by_cluster, split::split};

/// Inner folds, by subject: partitions see only scores of trees that never saw their subject.
const INNER: usize = 3;
/// The penalty of the weights of partitions, and the evaluations of their fit.
const L2: f64 = 1e-3;
const ITERATIONS: usize = 200;

/// A skeleton with its contacts measured and what is true of them.
pub struct ContactExample<'a> {
    /// The case.
    pub case: &'a Case,
    /// Its branches and clusters.
    pub branches: Branches,
    /// Per pair whether its ends are one vessel; `None` where that is not known.
    pub joined: Vec<Option<bool>>,
    /// Per cluster the vessel of each end; see [`super::contact_truth::ContactTruth::classes`].
    pub classes: Vec<Vec<Option<usize>>>,
    /// What is seen of its pairs: by the skeleton alone, in its mask, in each image.
    seen: Vec<SeenPairs>,
}

impl<'a> TreeExample<'a> for ContactExample<'a> {
    const KIND: Model = Model::Contacts;

    fn new(case: &'a Case) -> Result<Self> {
        let mask = case.mask.as_ref().map(|path| read_mask(path, &ReadOptions::default(), case.network.frame)).transpose()?;
        let lumen = mask.and_then(|mask| Foreground::of(&mask.in_scanner_order()));
        let field = lumen.as_ref().map(Field::of);
        let branches = Branches::new(&case.network);
        let unknown = || branches.clusters.iter().map(|cluster| vec![None; cluster.ends.len()]).collect();
        let classes: Vec<Vec<Option<usize>>> = case.contacts.as_ref().map_or_else(unknown, |truth| truth.classes(&branches));
        let joined = classes.iter().flat_map(|of| pairs_among(of.len()).map(|[a, b]| Some(of[a]? == of[b]?))).collect();
        let extraction = Resampled::new(&case.network, CenterlineKind::Skeleton).extraction(&[])?;
        let mut seen = Vec::new();
        let mut see = |basis, image, features| seen.push(SeenPairs { basis, image, features });
        see(Basis::Skeleton, String::new(), pair_features(&branches, None, None));
        if let Some(field) = &field {
            see(Basis::Mask, String::new(), pair_features(&branches, Some(field), None));
            for path in &case.images {
                let scene = shown(path, case.network.frame, &extraction)?;
                see(Basis::Image, image_name(path), pair_features(&branches, Some(field), Some(&scene)));
            }
        }
        Ok(Self { case, branches, joined, classes, seen })
    }

    fn fit(examples: &[&Self], progress: &mut dyn FnMut(&str)) -> Result<ContactModel> {
        let skeleton = fit_part(examples, Basis::Skeleton)?;
        progress("without mask");
        let mask = fit_part(examples, Basis::Mask)?;
        progress("with mask");
        let has_images = examples.iter().any(|e| e.seen.iter().any(|seen| seen.basis == Basis::Image));
        let image = has_images.then(|| fit_part(examples, Basis::Image)).transpose()?;
        if has_images {
            progress("with images");
        }
        let (_, subjects) = dealt(examples.iter().map(|e| e.case.subject.as_str()), INNER);
        let provenance = ModelProvenance::of(examples.len(), subjects);
        Ok(ContactModel { kind: ContactKind::Contacts, skeleton, mask, image, provenance, figures: Vec::new() })
    }
}

impl ContactExample<'_> {
    /// Whether there is a mask.
    pub fn has_mask(&self) -> bool {
        self.seen.iter().any(|seen| seen.basis == Basis::Mask)
    }

    /// The contacts that are found by some scores of pairs: how probably the partitions join each, and whether it is one vessel, as far as
    /// that is known; and how crowded they make the vessels.
    fn found(&self, scores: &[f64], weights: &PartitionWeights) -> (Vec<(f64, bool)>, Crowding) {
        let (network, branches) = (&self.case.network, &self.branches);
        let blocks = most_probable_blocks(&scores_by_cluster(branches, scores), weights);
        let opened = split(network, branches, &blocks, |joined| joined);
        let crowding = Crowding::new(network, branches, opened.junctions.len());
        let known = self.case.contacts.as_ref().map(|truth| truth.contacts(&opened.graph)).unwrap_or_default();
        let contacts = opened.graph.vessels().filter(|(_, vessel)| vessel.origin == Origin::Contact);
        let judged = contacts.zip(known).filter_map(|((_, vessel), known)| Some((vessel.prior, known?)));
        (judged.collect(), crowding)
    }

    /// Per cluster that is summed exactly and known: the features of every partition, and the true one.
    fn designs(&self, scores: &[f64]) -> Vec<Design> {
        let tables = scores_by_cluster(&self.branches, scores);
        let each = tables.iter().zip(&self.classes).filter_map(|(table, classes)| {
            let classes = classes.iter().copied().collect::<Option<Vec<usize>>>()?;
            let ends = Some(classes.len()).filter(|ends| (2..=MOST_ENDS).contains(ends))?;
            let (all, blocks) = (partitions(ends), numbered(classes));
            let truth = all.iter().position(|z| *z == blocks)?;
            Some(Design { size: size_of(ends), rows: all.iter().map(|z| partition_features(z, table)).collect(), truth })
        });
        each.collect()
    }
}

struct Design {
    size: usize,
    rows: Vec<[f64; PARTITION_FEATURES]>,
    truth: usize,
}

/// What is seen of the pairs of a case.
struct SeenPairs {
    basis: Basis,
    /// The name of the image; empty without one.
    image: String,
    /// Shape (pairs, features).
    features: Array2<f32>,
}

/// A case with what is seen of it.
type SeenCase<'a> = (&'a ContactExample<'a>, &'a SeenPairs);

/// All that is seen of some cases on a basis.
fn views<'a>(examples: impl Iterator<Item = &'a ContactExample<'a>>, basis: Basis) -> Vec<SeenCase<'a>> {
    examples.flat_map(|e| e.seen.iter().filter(move |seen| seen.basis == basis).map(move |seen| (e, seen))).collect()
}

fn fit_part(examples: &[&ContactExample], basis: Basis) -> Result<ContactPart> {
    let views = views(examples.iter().copied(), basis);
    let (fold, subjects) = dealt(views.iter().map(|(e, _)| e.case.subject.as_str()), INNER);
    let accepted = format!("expected {INNER} subjects at least, with mask.nii.gz beside their fragments");
    require(subjects >= INNER, "cases", format!("{} of {subjects} subjects", views.len()), accepted)?;
    let trees = fit_trees(&views)?;
    let (mut designs, mut unseen) = (Vec::new(), Vec::new());
    for held in 0..INNER {
        let (unknown, known): (Vec<_>, Vec<_>) = views.iter().zip(&fold).partition(|(_, fold)| **fold == held);
        let trees = fit_trees(&known.into_iter().map(|(view, _)| *view).collect::<Vec<_>>())?;
        for ((e, seen), _) in unknown {
            let scores = trees.scores(&seen.features);
            designs.extend(e.designs(&scores));
            unseen.push((*e, scores));
        }
    }
    let (features, weights) = (basis.feature_names(), fit_weights(&designs));
    let mut part = ContactPart { features, weights, calibration: NOT_CALIBRATED, crowding: None, trees };
    calibrate_part(&mut part, &unseen);
    Ok(part)
}

/// Calibrates a part on the contacts that it finds by scores of trees that never saw the subject; nothing changes without one.
fn calibrate_part(part: &mut ContactPart, unseen: &[(&ContactExample, Vec<f64>)]) {
    let found = in_order(unseen, |_, (e, scores)| e.found(scores, &part.weights));
    let pairs: Vec<(f64, bool)> = found.iter().flat_map(|(pairs, _)| pairs.iter().copied()).collect();
    if let Some(calibration) = calibrate_in_order(&pairs) {
        part.calibration = calibration;
        part.crowding = found.into_iter().map(|(_, crowding)| crowding).reduce(Crowding::most);
    }
}

/// Calibrates a model on cases of its subjects or others that it was not fitted to, and changes nothing else in it.
pub fn calibrate_contacts(model: &mut ContactModel, examples: &[ContactExample]) {
    for basis in Basis::ALL {
        let part = match basis {
            Basis::Skeleton => &mut model.skeleton,
            Basis::Mask => &mut model.mask,
            Basis::Image => match &mut model.image {
                Some(part) => part,
                None => continue,
            },
        };
        let unseen: Vec<(&ContactExample, Vec<f64>)> =
            views(examples.iter(), basis).into_iter().map(|(e, seen)| (e, part.trees.scores(&seen.features))).collect();
        calibrate_part(part, &unseen);
    }
}

/// Boosted trees over the pairs whose answer is known.
fn fit_trees(views: &[SeenCase]) -> Result<Boosted> {
    let mut rows = Vec::new();
    for (at, (e, _)) in views.iter().enumerate() {
        rows.extend(e.joined.iter().enumerate().filter_map(|(row, joined)| Some((at, row, (*joined)?))));
    }
    boost(&views.iter().map(|(_, seen)| &seen.features).collect::<Vec<_>>(), &rows)
}

/// The weights that make the true partitions the most probable: maximum conditional likelihood with a penalty.
fn fit_weights(designs: &[Design]) -> PartitionWeights {
    let at = |size: usize| size * PARTITION_FEATURES;
    let loss = |theta: &[f64]| {
        let mut value = L2 * theta.iter().map(|t| t * t).sum::<f64>();
        let mut slope: Vec<f64> = theta.iter().map(|t| 2.0 * L2 * t).collect();
        let n = designs.len().max(1) as f64;
        for design in designs {
            let own = &theta[at(design.size)..at(design.size + 1)];
            let log: Vec<f64> = design.rows.iter().map(|f| f.iter().zip(own).map(|(f, t)| f * t).sum()).collect();
            let most = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let weight: Vec<f64> = log.iter().map(|l| (l - most).exp()).collect();
            let total: f64 = weight.iter().sum();
            value -= (log[design.truth] - most - total.ln()) / n;
            for k in 0..PARTITION_FEATURES {
                let mean = design.rows.iter().zip(&weight).map(|(f, w)| f[k] * w).sum::<f64>() / total;
                slope[at(design.size) + k] += (mean - design.rows[design.truth][k]) / n;
            }
        }
        (value, slope)
    };
    let mut start = vec![0.0; SIZES * PARTITION_FEATURES];
    (0..SIZES).for_each(|size| start[at(size)] = 0.5);
    let found = minimise(start, ITERATIONS, &loss).point;
    std::array::from_fn(|size| std::array::from_fn(|k| found[at(size) + k]))
}

/// A pair of ends at a cluster that is summed exactly: score, probability, whether it is one vessel.
type JudgedEnds = (f64, f64, bool);

/// The pairs of a case as it is seen: on which basis, and in which image.
pub struct JudgedContacts {
    basis: Basis,
    image: String,
    ends: Vec<JudgedEnds>,
}

impl<'a> Example<'a> for ContactExample<'a> {
    type Model = ContactModel;
    type Judged = JudgedContacts;
    type Scores = ContactScores;
    const FOLDS_KEEP_FIGURES: bool = false;

    fn case(&self) -> &'a Case {
        self.case
    }

    fn judge(&self, model: &ContactModel) -> Result<Vec<JudgedContacts>> {
        let judged = self.seen.iter().map(|seen| {
            let part = model.part(seen.basis);
            let scores = part.trees.scores(&seen.features);
            let mut probability = Vec::with_capacity(scores.len());
            for table in scores_by_cluster(&self.branches, &scores) {
                let ends = table.ends();
                if ends <= MOST_ENDS {
                    probability.extend(pair_probabilities(&table, &part.weights).into_iter().map(Some));
                } else {
                    probability.extend(std::iter::repeat_n(None, ends * (ends - 1) / 2));
                }
            }
            let known = |pair: usize| Some((scores[pair], probability[pair]?, self.joined[pair]?));
            JudgedContacts { basis: seen.basis, image: seen.image.clone(), ends: (0..scores.len()).filter_map(known).collect() }
        });
        Ok(judged.collect())
    }

    /// Figures by folder of each data set, and by what was seen.
    fn scores(judged: &[(&Self, &JudgedContacts)]) -> Vec<ContactScores> {
        let groups =
            grouped(judged, |e, judged| [([e.case.data_set.as_str(), &e.case.group], judged.basis, judged.image.as_str()); 2]);
        let scores = groups.into_iter().map(|((group, basis, image), of)| {
            scores_of(name_of(group), (basis, image), &of.iter().map(|(_, judged)| &judged.ends[..]).collect::<Vec<_>>())
        });
        scores.collect()
    }

    fn record(model: &mut ContactModel) -> (&mut ModelProvenance, &mut Vec<ContactScores>) {
        (&mut model.provenance, &mut model.figures)
    }
}

const LEAST_IN_BIN: f64 = 50.0;

fn scores_of(of: String, (basis, image): (Basis, &str), cases: &[&[JudgedEnds]]) -> ContactScores {
    let mut all: Vec<JudgedEnds> = cases.concat();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let pairs = all.len();
    let joined = all.iter().filter(|(.., joined)| *joined).count();
    let bins = binned(all.iter().map(|(_, p, joined)| (*p, *joined)));
    let errors = bins.iter().filter(|bin| bin[2] >= LEAST_IN_BIN).map(|[p, right, count]| ((p - right) / count).abs());
    // Of pairs in rising order of their scores: how many false ones come before each true one.
    let (mut apart, mut before, mut precision) = (0.0, 0.0, 0.0);
    for (row, (.., joined)) in all.iter().enumerate() {
        if *joined {
            before += apart;
        } else {
            apart += 1.0;
            precision += apart / (row + 1) as f64;
        }
    }
    ContactScores {
        of,
        with_mask: basis != Basis::Skeleton,
        image: image.to_owned(),
        cases: cases.len(),
        pairs,
        joined: joined as f64 / pairs.max(1) as f64,
        auc: before / (apart * joined as f64).max(1.0),
        average_precision: precision / apart.max(1.0),
        largest_bin_error: errors.fold(0.0, f64::max),
    }
}
