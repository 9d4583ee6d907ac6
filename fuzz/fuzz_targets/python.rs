//! What the module for Python hands to the library: arrays packed as NPZ or NPY, a graph as GraphML, words, rows of decisions. The first
//! byte says which.
#![no_main]

use std::io::Cursor;
use std::path::Path;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use willis::cli::words;
use willis::internals::formats::{NamedArray, graph_columns, write_arrays};
use willis::internals::phantom::{cerebral, circle_of_willis};
use willis::{ConnectionDecision, InferOptions, Inference, Input, Keep, ReadOptions, Silent, infer, read_bytes};

/// A small run with evidence, whose candidates may be decided on.
static RUN: LazyLock<Inference> = LazyLock::new(|| {
    let swc = "1 1 0 0 0 1 -1\n2 1 1 0 0 1 1\n3 2 2 .5 0 .8 2\n4 2 3 1 0 .8 3\n5 3 2 -.5 0 .7 2\n6 3 3 -1 .2 .7 5\n7 4 3.5 1.5 0 .6 -1\n8 4 4 2 .5 .6 7\n";
    let input = read_bytes(Path::new("small.swc"), swc.as_bytes(), &ReadOptions::default()).expect("read");
    let mut options = InferOptions::default();
    options.sampling.samples = 64;
    infer(&input, &options).expect("a run")
});

/// What Python reads of a network.
fn look(input: &Input) {
    let (nodes, vessels) = graph_columns(&input.network);
    let is_even = |columns: &[willis::internals::formats::Column]| {
        columns.windows(2).all(|pair| pair[0].values.rows() == pair[1].values.rows())
    };
    assert!(is_even(&nodes) && is_even(&vessels));
    let _ = words::said_of_input(input);
}

fn array(name: &str, shape: &[usize], values: Vec<f64>) -> NamedArray {
    NamedArray { name: name.to_owned(), shape: shape.to_vec(), values }
}

/// Numbers of one byte each: small whole numbers, halves, and what arithmetic does not like.
fn number(byte: u8) -> f64 {
    match byte {
        0xff => f64::NAN,
        0xfe => f64::INFINITY,
        0xfd => -0.0,
        0xfc => 1e308,
        0xfb => 5e-324,
        0xfa => -1e-3,
        _ => f64::from(byte) / 8.0,
    }
}

/// `willis.centerlines(points, edges, radii, lengths)`.
fn arrays(bytes: &[u8]) {
    let [n, m, how, rest @ ..] = bytes else { return };
    let (n, m) = (usize::from(n % 24), usize::from(m % 24));
    let mut next = rest.iter().copied().chain(std::iter::repeat(1));
    let mut take = |count: usize| -> Vec<f64> { next.by_ref().take(count).map(number).collect() };
    let coords = take(3 * n);
    let has_lengths = how & 1 == 1;
    let (radii, lengths) = (take(if has_lengths { m } else { n }), take(m));
    let rows: Vec<f64> = take(2 * m)
        .iter()
        .map(|x| (x * 8.0).round() % 256.0)
        .map(|x| if how & 2 == 2 { x % n.max(1) as f64 } else { x })
        .collect();
    let mut all = vec![array("coords", &[n, 3], coords), array("edges", &[m, 2], rows), array("radii", &[radii.len()], radii)];
    if has_lengths {
        all.push(array("lengths", &[m], lengths));
    }
    if how & 4 == 4 {
        all.remove(usize::from(how >> 4) % all.len());
    }
    if how & 8 == 8 {
        // An array of another shape than its name wants.
        let at = usize::from(how >> 4) % all.len();
        all[at].shape = vec![all[at].values.len(), 1];
    }
    let mut packed = Cursor::new(Vec::new());
    write_arrays(&mut packed, all.into_iter()).expect("packed");
    if let Ok(input) = read_bytes(Path::new("arrays.npz"), packed.get_ref(), &ReadOptions::default()) {
        look(&input);
    }
}

/// `willis.from_mask(array, spacing=...)`, and `np.save` with any header.
fn mask(bytes: &[u8]) {
    let options = words::reading(Path::new("mask.npy"), &["--spacing".to_owned(), "0.5".to_owned()]).expect("options");
    let options = ReadOptions { max_input: 1 << 22, ..options };
    if let Ok(input) = read_bytes(Path::new("mask.npy"), bytes, &options) {
        look(&input);
    }
}

/// `willis.from_networkx(graph)`.
fn graph(bytes: &[u8]) {
    if let Ok(input) = read_bytes(Path::new("graph.graphml"), bytes, &ReadOptions::default()) {
        look(&input);
    }
}

/// `run.decide(accept, reject)` and `run.decided_by(rule)`.
fn decide(bytes: &[u8]) {
    let (rows, rule) = bytes.split_at(bytes.len().min(4));
    let made: Vec<ConnectionDecision> = rows
        .iter()
        .map(|byte| ConnectionDecision {
            edge: usize::from(byte >> 1 & 15),
            accepted: Some(byte & 1 == 1),
            ..ConnectionDecision::default()
        })
        .collect();
    if let Ok(run) = RUN.with_decisions(&made, &[], &mut Silent) {
        assert!(run.graph().vessels().all(|(_, vessel)| (0.0..=1.0).contains(&vessel.prior)));
        run.tables().expect("tables");
    }
    if let Ok(rule) = String::from_utf8_lossy(rule).parse::<Keep>() {
        if let Ok(run) = RUN.decided_by(rule) {
            assert_eq!(run.kept().len(), run.graph().vessel_count());
        }
    }
}

/// Words that Python makes of keywords.
fn options(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let given: Vec<String> = text.split('\n').map(str::to_owned).collect();
    static CIRCLE: LazyLock<Input> = LazyLock::new(|| Input::from_network(cerebral(&circle_of_willis(1e-2))));
    let _ = words::infer(Path::new("network"), &given);
    let _ = words::modulate(Path::new("network"), &CIRCLE.network, &given);
}

fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else { return };
    match first % 5 {
        0 => arrays(rest),
        1 => mask(rest),
        2 => graph(rest),
        3 => decide(rest),
        _ => options(rest),
    }
});
