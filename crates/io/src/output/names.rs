//! The names of the files in an output folder.

/// The record of a run, by which a folder of this program is known.
pub const RECORD: &str = "run.json";
/// The landmarks that a run was made with, with an ending for each format, in the order of `LandmarkFormat`.
pub const LANDMARKS: [&str; 3] = ["landmarks.csv", "landmarks.mrk.json", "landmarks.fcsv"];
/// The vessels.
pub const EDGES: &str = "edges.csv";
/// Cuts that are suggested and not made.
pub const SUGGESTED_CUTS: &str = "suggested-cuts.csv";
/// How the vessels at each contact may be paired.
pub const PAIRINGS: &str = "pairings.csv";
/// What a person is asked, in this order.
pub const REVIEW: &str = "review.csv";
/// What is measured of vessels.
pub const VESSELS: &str = "vessels.csv";
/// What is measured of bifurcations.
pub const BIFURCATIONS: &str = "bifurcations.csv";
/// What is measured of ends.
pub const ENDS: &str = "ends.csv";
/// How far the figures of whole networks may lie apart.
pub const INTERVALS: &str = "intervals.csv";
/// How two groups of subjects differ in what is measured.
pub const COMPARISON: &str = "comparison.csv";
/// How far two readers agree.
pub const READERS: &str = "readers.csv";
/// Where two readers differ.
pub const DIFFERENCES: &str = "differences.csv";
/// What is measured of whole networks, a row each.
pub const SUBJECTS: &str = "subjects.csv";
/// The nodes.
pub const NODES: &str = "nodes.csv";
/// The page to open in a browser.
pub const PAGE: &str = "report.html";
/// The likelihood matrix with its zeros.
pub const DENSE_LIKELIHOOD: &str = "likelihood.npy";
/// The likelihood matrix.
pub const LIKELIHOOD: &str = "likelihood.npz";
/// Who feeds what.
pub const TERRITORIES: &str = "territories.csv";
/// What each closed vessel does.
pub const OCCLUSIONS: &str = "occlusions.csv";
/// When blood arrives.
pub const TRANSIT: &str = "transit.csv";
/// Pressures and flows over a cycle, by time.
pub const WAVEFORMS: &str = "waveforms.npz";
/// The same in the middle of every vessel as a table.
pub const WAVEFORM_TABLE: &str = "waveforms.csv";
/// Pressures and flows over a cycle, by harmonic.
pub const HARMONICS: &str = "harmonics.npz";
/// The waveforms of arteries as a picture.
pub const WAVEFORM_PICTURE: &str = "waveforms";
/// The over-connected graph that was sampled.
pub const GRAPH: &str = "candidates.graphml";
/// What was kept, with an ending for each format.
pub const TOPOLOGY: &str = "topology";
/// The endings of topologies.
pub const TOPOLOGY_ENDINGS: [&str; 3] = ["graphml", "swc", "vtp"];
/// The vessels above the median, with an ending for each format.
pub const MEDIAN_TOPOLOGY: &str = "topology-median";
/// The flow as a picture.
pub const FLOW_PICTURE: &str = "flow";
/// Whose blood every outlet gets, as a picture.
pub const TERRITORY_PICTURE: &str = "territories";
/// The likelihood matrix as a picture.
pub const LIKELIHOOD_PICTURE: &str = "likelihood";
/// The likelihood against the samples as a picture.
pub const CONVERGENCE_PICTURE: &str = "convergence";
/// A run in one picture.
pub const SUMMARY_PICTURE: &str = "summary";
/// A resistance modulation as a picture.
pub const MODULATION_PICTURE: &str = "modulation";
/// How hypertension is distributed, as a picture.
pub const HYPERTENSION_PICTURE: &str = "hypertension";
/// The classes of a resistance modulation.
pub const CLASSES: &str = "classes.csv";
/// How hypertension is distributed.
pub const HYPERTENSION: &str = "hypertension.csv";
/// Every instance of a resistance modulation.
pub const INSTANCES: &str = "samples.npz";
/// The Circle of Willis.
pub const PHENOTYPE: &str = "phenotype.json";
/// The Circle of Willis as a row of a table.
pub const PHENOTYPE_TABLE: &str = "phenotype.csv";
/// The labelled vessels of a subject; the names of the files beside it begin with its own.
pub const LABELLED: &str = "labelled.graphml";
/// The endings of the files beside labelled vessels.
pub const BESIDE_LABELLED: [&str; 4] = ["names.csv", "segments.csv", LANDMARKS[0], LANDMARKS[1]];
/// How often a classification of a cohort is right.
pub const ACCURACY: &str = "accuracy.csv";
/// What takes over when a feeding artery is lost.
pub const COLLATERAL: &str = "collateral.csv";
/// How far runs with different occlusion probabilities agree.
pub const AGREEMENT: &str = "agreement.csv";
/// The record by which the folder of an input that gave no run is known.
pub const FAILURE: &str = "failed.json";
/// Who feeds each territory and outlet of a circle, and how late.
pub const SUPPLY: &str = "supply.csv";
/// With what a run of a dataset was made, so that the same command can resume it.
pub const LEDGER: &str = "ledger.json";
/// The record by which the folder of a cohort is known.
pub const COHORT: &str = "cohort.json";
/// The subjects of a cohort, a row each.
pub const COHORT_TABLE: &str = "cohort.csv";
/// The page of a cohort.
pub const COHORT_PAGE: &str = "cohort.html";
/// The files that a set has put in their places, in the hidden folder of the main file.
pub const SET: &str = "set.json";

/// The files that the folder of a run may hold besides pictures and topologies, in groups; --force replaces no folder with others.
pub const FILES: [&[&str]; 6] = [
    &[RECORD, LEDGER, PAGE, GRAPH, COMPARISON, INTERVALS, SUBJECTS, READERS, DIFFERENCES, LABELLED],
    &[EDGES, NODES, VESSELS, BIFURCATIONS, ENDS, SUGGESTED_CUTS, PAIRINGS, REVIEW, DENSE_LIKELIHOOD, LIKELIHOOD],
    &[OCCLUSIONS, TERRITORIES, TRANSIT, WAVEFORMS, WAVEFORM_TABLE, HARMONICS, SUPPLY],
    &[CLASSES, HYPERTENSION, INSTANCES],
    &[PHENOTYPE, PHENOTYPE_TABLE, COLLATERAL],
    &LANDMARKS,
];
/// The pictures of a run, each with an ending for each format.
pub const PICTURES: [&[&str]; 2] = [
    &[SUMMARY_PICTURE, LIKELIHOOD_PICTURE, CONVERGENCE_PICTURE, MODULATION_PICTURE, HYPERTENSION_PICTURE],
    &[FLOW_PICTURE, TERRITORY_PICTURE, WAVEFORM_PICTURE],
];
/// The files in the folder of a cohort besides the folders of its subjects.
pub const COHORT_FILES: &[&str] = &[COHORT, COHORT_TABLE, COHORT_PAGE, ACCURACY];
