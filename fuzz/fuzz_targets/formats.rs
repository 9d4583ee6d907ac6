//! Gives bytes to the reader of one format, which the variable WILLIS_FORMAT names: it reads or refuses them.
#![no_main]

use std::path::Path;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use willis::error::Fault;
use willis::internals::candidates::joins::model::JoinModel;
use willis::internals::candidates::model::Weights;
use willis::internals::circle_of_willis::{Circle, LabelScheme, VariantFrequencies, identify_landmarks};
use willis::internals::contacts::model::ContactModel;
use willis::internals::formats as io;
use willis::internals::formats::tables::conditions;
use willis::internals::formats::{Content, ReadOptions};
use willis::internals::masks::{Cavities, Mask, RadiusFrom, trace};
use willis::internals::naming::NamingModel;
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::Scale;
use willis::internals::network::{Network, RadiusRule, contract};
use willis::internals::phantom::{cerebral, circle_of_willis};
use willis::internals::simulation::pulse::fourier::{beyond, coefficients};

static FORMAT: LazyLock<String> = LazyLock::new(|| std::env::var("WILLIS_FORMAT").expect("WILLIS_FORMAT names a format"));
static CIRCLE: LazyLock<Network> = LazyLock::new(|| cerebral(&circle_of_willis(1e-2)));

/// What divides the two tables of a graph.
const BETWEEN: &[u8] = b"\n====\n";

fn two(bytes: &[u8]) -> (&[u8], &[u8]) {
    match bytes.windows(BETWEEN.len()).position(|w| w == BETWEEN) {
        Some(at) => (&bytes[..at], &bytes[at + BETWEEN.len()..]),
        None => (&[], bytes),
    }
}

/// Centerlines go on to become vessels.
fn lines(read: Result<(Centerlines, Vec<String>), Fault>) {
    if let Ok((mut lines, _)) = read {
        lines.weld(1e-6);
        let _ = contract(&lines, RadiusRule::Mean, Some(1e-3));
    }
}

/// How voxels are read.
fn of_voxels(level: Option<f64>) -> io::ReadOptions {
    let scale = Scale { spacing: Some([0.5, 0.5, 1.0]), ..Scale::default() };
    io::ReadOptions { scale, level, max_input: 1 << 24, ..io::ReadOptions::default() }
}

/// Small masks go on to become centerlines: thinning, which the target `masks` searches, is ten times as slow as reading.
fn mask<E>(read: Result<Mask, E>) {
    if let Ok(mask) = read.map(|mask| mask.in_scanner_order())
        && mask.classes.len() < 64
    {
        let _ = trace(&mask, RadiusFrom::Area, Cavities::Fill);
    }
}

/// Vessels without a radius take one.
fn graph(read: Result<(Network, Vec<String>), Fault>) {
    if let Ok((network, _)) = read {
        let _ = Content::Graph(network).into_network(RadiusRule::Mean, Some(1e-3));
    }
}

/// The vessels of a circle take the lines of a text as their labels.
fn labelled(text: &str) {
    let mut network = CIRCLE.clone();
    for (row, label) in (0..network.vessel_count()).zip(text.lines()) {
        network.vessel_mut(row).label = label.into();
    }
    let labels: Vec<String> = network.vessels().map(|(_, vessel)| vessel.label.to_string()).collect();
    let Ok(scheme) = LabelScheme::of(labels.iter().map(String::as_str)) else { return };
    if let Ok((circle, _)) = Circle::labelled(&network, scheme) {
        assert!(circle.fits(&network));
        let _ = circle.variant(&network, |row| row % 3 > 0);
    }
}

fuzz_target!(|bytes: &[u8]| {
    let mm = Scale::default();
    let optional = ReadOptions { default_radius: Some(1e-3), ..ReadOptions::default() };
    let text = || String::from_utf8_lossy(bytes);
    let (first, second) = two(bytes);
    match FORMAT.as_str() {
        "graphml" => graph(io::read_graphml(bytes, &optional)),
        "csv" => {
            let nodes = io::read_csv_nodes(first, &mm).ok();
            graph(io::read_csv_edges(second, nodes, &optional));
        }
        "swc" => lines(io::read_swc(bytes, &mm)),
        "vtp" => lines(io::read_vtp(bytes, &optional)),
        "vtk" => lines(io::read_vtk(bytes, &optional)),
        "tre" => lines(io::read_tre(bytes, &optional)),
        "markups" => lines(io::read_markups(bytes, &optional)),
        "points" => lines(io::read_points(bytes, &optional)),
        "mat" => lines(io::read_vtrails(bytes, &optional)),
        "npz" => drop(io::read_skeleton_npz(bytes, &optional)),
        "voreen" => {
            if let Ok(nodes) = io::read_voreen_nodes(first, &mm) {
                let _ = io::read_voreen_edges(second, nodes, &optional);
            }
        }
        "vesselvio" => {
            if let Ok(vertices) = io::read_vesselvio_vertices(first, &mm) {
                let _ = io::read_vesselvio_edges(second, vertices, &optional);
            }
        }
        "nifti" => mask(io::Format::Nifti.read_mask(Path::new("a.nii"), bytes, &of_voxels(None))),
        "metaimage" => drop(io::Format::MetaImage.read_mask(Path::new("a.mha"), bytes, &of_voxels(Some(1.0)))),
        "nrrd" => mask(io::Format::Nrrd.read_mask(Path::new("a.nrrd"), bytes, &of_voxels(None))),
        "tiff" => mask(io::Format::Tiff.read_mask(Path::new("a.tif"), bytes, &of_voxels(None))),
        "amira" => lines(io::read_amira(bytes, &optional)),
        "npy-mask" => mask(io::Format::Npy.read_mask(Path::new("a.npy"), bytes, &of_voxels(None))),
        "icafe" => drop(io::read_traced_vessels(bytes, &mm)),
        "links" => drop(io::read_links(bytes)),
        "loops" => {
            if let Ok((mut lines, _)) = io::read_swc(first, &mm) {
                let _ = io::add_loops(second, &mut lines);
            }
        }
        "landmarks" => {
            if let Ok(landmarks) = io::read_landmarks(bytes, &mm).and_then(|list| identify_landmarks(list.landmarks)) {
                let _ = Circle::at(&CIRCLE, &landmarks);
            }
        }
        "labels" => labelled(&text()),
        "decisions" => drop(io::read_decisions(bytes)),
        "waveform" => {
            if let Ok((wave, _)) = io::read_waveform(bytes) {
                let period = wave.own_period();
                if wave.check(period).is_ok() {
                    let _ = beyond(&wave, period, &coefficients(&wave, period, 8));
                }
            }
        }
        "frequencies" => {
            if let Ok(shares) = VariantFrequencies::read(bytes) {
                assert!(shares.marginals().iter().all(|p| (0.0..=1.0 + 1e-9).contains(p)), "{:?}", shares.marginals());
            }
        }
        "names" => drop(NamingModel::read(&text())),
        "contacts" => drop(ContactModel::read(&text())),
        "joins" => drop(JoinModel::read(&text())),
        "manifest" => drop(io::read_manifest(bytes, std::path::Path::new(""))),
        "conditions-csv" => drop(conditions::read_csv(bytes)),
        "inlets" => drop(conditions::read_inlets(bytes)),
        "conditions-toml" => drop(conditions::read_toml(bytes)),
        "weights" => drop(Weights::read(&text())),
        "prior-csv" => drop(io::read_prior_csv(bytes, &mut CIRCLE.clone())),
        "prior-npy" => drop(io::read_prior_npy(bytes, &mut CIRCLE.clone())),
        other => panic!("WILLIS_FORMAT {other} is not known"),
    }
});
