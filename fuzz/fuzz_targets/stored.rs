//! What earlier runs left: the sums of a part of a run (a checkpoint, shard.npz), made of bytes as arrays of the right names, and shards
//! that are merged. The first byte says which.
#![no_main]

use std::io::Cursor;
use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use serde_json::Value;
use willis::internals::io::{NamedArray, checksum, read_arrays, write_arrays};
use willis::internals::output::{read_part, write_part};
use willis::{InferOptions, Input, SaveOptions, Silent, merge, prepare, read_bytes};

/// Which vessels of three are uncertain.
const UNCERTAIN: [bool; 3] = [true, false, true];

/// A shard of a small run, as its two files.
static SHARD: LazyLock<(String, Vec<u8>)> = LazyLock::new(|| {
    let swc = "1 1 0 0 0 1 -1\n2 1 1 0 0 1 1\n3 2 2 .5 0 .8 2\n4 2 3 1 0 .8 3\n5 3 2 -.5 0 .7 2\n6 3 3 -1 .2 .7 5\n7 4 3.5 1.5 0 .6 -1\n8 4 4 2 .5 .6 7\n";
    let input: Input = read_bytes("small.swc".as_ref(), swc.as_bytes(), &Default::default()).expect("read");
    let mut options = InferOptions::default();
    options.sampling.samples = 128;
    let prepared = prepare(input, &options, &mut Silent).expect("prepared");
    let folder = FOLDER.join("first");
    std::fs::create_dir_all(&folder).expect("a folder");
    let shard = prepared.sample_range(&options.sampling, &(0..1), &mut Silent).expect("a shard");
    shard.write(&folder, &SaveOptions::default()).expect("written");
    let record = std::fs::read_to_string(folder.join("shard.json")).expect("shard.json");
    (record, std::fs::read(folder.join("shard.npz")).expect("shard.npz"))
});
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = PathBuf::from("/dev/shm");
    let root = if memory.is_dir() { memory } else { std::env::temp_dir() };
    root.join(format!("willis-fuzz-{}", std::process::id()))
});

/// Numbers of one byte each: counts, powers of two, and what arithmetic does not like.
fn number(byte: u8) -> f64 {
    match byte {
        0xff => f64::NAN,
        0xfe => f64::INFINITY,
        0xfd => -1.0,
        0xfc => 1e300,
        0xfb => 0.5,
        0xc0..=0xfa => 2_f64.powi(i32::from(byte - 0xc0)),
        _ => f64::from(byte),
    }
}

/// The arrays of a part with the numbers and the lengths that the bytes say.
fn part(bytes: &[u8]) {
    let [samples, step, m, k, rest @ ..] = bytes else { return };
    let (m, k) = (usize::from(m % 5), usize::from(k % 9));
    let mut next = rest.iter().copied().chain(std::iter::repeat(0));
    let mut array = |name: &str, shape: &[usize]| NamedArray {
        name: name.to_owned(),
        shape: shape.to_vec(),
        values: next.by_ref().take(shape.iter().product()).map(number).collect(),
    };
    let run = NamedArray { name: "run".to_owned(), shape: vec![2], values: vec![number(*samples), number(*step)] };
    let all = [
        array("blocks", &[m, 2]),
        array("samples", &[m]),
        array("step", &[k]),
        array("trace", &[k, 2]),
        array("rho_G", &[m]),
        array("residual", &[m]),
        array("likelihood", &[m, 3]),
        array("square", &[m, 3]),
        array("count", &[m, 3]),
    ];
    let mut packed = Cursor::new(Vec::new());
    write_arrays(&mut packed, std::iter::once(run).chain(all)).expect("packed");
    let Ok(read) = read_part(packed.get_ref(), UNCERTAIN.to_vec()) else { return };
    let mut again = Cursor::new(Vec::new());
    write_part(&mut again, &read).expect("written");
    let back = read_part(again.get_ref(), UNCERTAIN.to_vec()).expect("what was written is read");
    assert_eq!((back.samples(), back.done()), (read.samples(), read.done()));
    let _ = read.trace();
    let (mut twice, mut double) = (read.clone(), read.clone());
    assert!(read.done() == 0 || !twice.join(read));
    if double.samples() < 1 << 40 && double.samples() % 64 == 0 {
        double.double();
    }
}

/// Two shards of one run: the first with some number of its record or of its sums changed, its checksums redone.
fn shards(bytes: &[u8]) {
    let [at, value, which, rest @ ..] = bytes else { return };
    let (record, sums) = &*SHARD;
    let mut record: Value = serde_json::from_str(record).expect("JSON");
    let mut packed = sums.clone();
    if which & 1 == 1 {
        let mut arrays = read_arrays(sums).expect("arrays");
        let count = arrays.len();
        let array = &mut arrays[usize::from(*at) % count];
        if !array.values.is_empty() {
            let row = rest.first().map_or(0, |row| usize::from(*row)) % array.values.len();
            array.values[row] = number(*value);
        }
        let mut out = Cursor::new(Vec::new());
        write_arrays(&mut out, arrays.into_iter().map(|a| NamedArray { name: a.name, shape: a.shape, values: a.values }))
            .expect("packed");
        packed = out.into_inner();
    }
    record["sums"] = checksum(&packed).into();
    if which & 2 == 2 {
        // A leaf of the record, by its number.
        let mut leaves = Vec::new();
        collect(&mut record, &mut leaves);
        let index = (usize::from(*at) << 8 | rest.first().map_or(0, |b| usize::from(*b))) % leaves.len();
        let text = String::from_utf8_lossy(rest.get(1..).unwrap_or_default());
        *leaves[index] = serde_json::from_str(&text).unwrap_or_else(|_| Value::from(number(*value)));
    }
    let folder = FOLDER.join("shard");
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("shard.json"), record.to_string()).expect("written");
    std::fs::write(folder.join("shard.npz"), packed).expect("written");
    let folders = if which & 4 == 4 { vec![folder] } else { vec![folder, FOLDER.join("first")] };
    if let Ok((run, _)) = merge(&folders, |_, _, _| {}) {
        let likelihood = run.likelihood();
        assert!(likelihood.likelihood.iter().all(|l| l.is_finite() && *l >= 0.0));
    }
}

fn collect<'a>(value: &'a mut Value, leaves: &mut Vec<&'a mut Value>) {
    match value {
        Value::Object(map) => map.values_mut().for_each(|each| collect(each, leaves)),
        Value::Array(list) => list.iter_mut().for_each(|each| collect(each, leaves)),
        leaf => leaves.push(leaf),
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else { return };
    if first % 4 == 3 { shards(rest) } else { part(rest) }
});
