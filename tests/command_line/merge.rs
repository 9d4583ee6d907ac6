//! `willis infer --range` and `willis merge`: the shards of a run make the bytes of the run, and others are refused by name.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{data, folder, stderr, willis};
use crate::refused::{contents, refused};
use serde_json::Value;
use willis::internals::io::{checksum, read_arrays, write_arrays};

fn done(here: &Path, arguments: &[&str]) {
    let output = willis(here, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
}

/// Shards of a run, cut at these samples.
fn shards(here: &Path, run: &[&str], name: &str, cuts: &[u64]) -> Vec<String> {
    let shard = |range: &[u64]| {
        let (out, range) = (format!("{name}{}", range[0]), format!("{}..{}", range[0], range[1]));
        done(here, &[run, &["-o", &out, "--range", &range, "-q"]].concat());
        out
    };
    cuts.windows(2).map(shard).collect()
}

fn merged(here: &Path, shards: &[String]) -> Vec<(PathBuf, Vec<u8>)> {
    let names: Vec<&str> = shards.iter().map(String::as_str).collect();
    done(here, &[&["merge"], &names[..], &["-o", "merged", "--force", "-q"]].concat());
    contents(&here.join("merged"))
}

/// 1,100 samples are 17 whole blocks and one cut short; the shards are handed in from the last to the first, the input is gone.
#[test]
fn one_three_and_seventeen_shards_give_the_bytes_of_the_run() {
    let here = folder();
    let here = here.path();
    fs::copy(data("broken-circle-of-willis.swc"), here.join("a.swc")).expect("copied");
    let run = ["infer", "a.swc", "-n", "1100", "--threads", "1"];
    done(here, &[&run[..], &["-o", "whole", "-q"]].concat());
    let whole = contents(&here.join("whole"));
    assert!(whole.len() > 12);
    let seventeen: Vec<u64> = (0..17).map(|at| at * 64).chain([1100]).collect();
    let of: Vec<Vec<String>> = [&[0, 1100][..], &[0, 448, 1024, 1100], &seventeen]
        .iter()
        .enumerate()
        .map(|(at, cuts)| shards(here, &run, &format!("shard{at}-"), cuts))
        .collect();
    fs::remove_file(here.join("a.swc")).expect("removed");
    for (mut shards, count) in of.into_iter().zip([1, 3, 17]) {
        assert_eq!(shards.len(), count);
        shards.reverse();
        assert_eq!(merged(here, &shards), whole, "{count} shards");
    }
}

/// Everything that goes into a folder comes back from shards: labels, landmarks and phenotype, a graph without evidence, all
/// vessels uncertain, stated conditions, the choices of the paper.
#[test]
fn shards_of_every_kind_of_run_give_its_bytes() {
    let here = folder();
    let here = here.path();
    done(here, &["phantom", "cerebral", "--break", "--seed", "3", "-o", "scan.swc", "-q"]);
    let graph = data("circle-of-willis/complete.graphml");
    fs::write(
        here.join("bare.csv"),
        "node_a,node_b,length_mm,radius_mm,prior\na,b,10,1,1\nb,c,11,1.3,0.1\na,c,12.7,0.9,0.7\nc,d,3,1,0.33\n",
    )
    .expect("written");
    let runs: [&[&str]; 6] = [
        &["infer", "scan.swc", "--landmarks", "scan.landmarks.csv", "-n", "256", "--dpi", "40"],
        &["infer", &graph, "--labels", "names", "--uncertain", "all", "--weight", "global", "-n", "192", "--dpi", "40"],
        &["infer", "scan.swc", "--preset", "paper", "-n", "256", "--keep", "otsu", "--dpi", "40"],
        &["infer", "scan.swc", "--outlets", "murray=500mL/min", "--max-gap", "20mm", "--solver", "reference", "-n", "200"],
        &[
            "infer",
            "bare.csv",
            "--inlet",
            "a=93.7",
            "--outlet",
            "d=20mmHg.s/mL@5mmHg",
            "-n",
            "321",
            "--seed",
            "18446744073709551615",
        ],
        &["infer", "bare.csv", "--inlet", "a", "--flow", "d=-3", "--epsilon", "0.1", "--keep", "frequency=0.4", "-n", "130"],
    ];
    for run in runs {
        done(here, &[run, &["-o", "whole", "--force", "-q"]].concat());
        let cut = shards(here, run, "part", &[0, 128, run_samples(run)]);
        assert_eq!(merged(here, &cut), contents(&here.join("whole")), "{run:?}");
        for name in cut {
            fs::remove_dir_all(here.join(name)).expect("removed");
        }
    }
}

fn run_samples(run: &[&str]) -> u64 {
    let at = run.iter().position(|word| *word == "-n").expect("samples");
    run[at + 1].parse().expect("a number")
}

/// The record of the merged run has the command of the whole run, which makes it again.
#[test]
fn the_merged_run_is_repeated_by_its_command() {
    let here = folder();
    let input = data("broken-circle-of-willis.swc");
    let run = ["infer", &input, "-n", "128", "--checkpoint=off"];
    let shards = shards(here.path(), &run, "s", &[0, 64, 128]);
    merged(here.path(), &shards);
    let record: Value = serde_json::from_slice(&fs::read(here.path().join("merged/run.json")).expect("a record")).expect("JSON");
    assert_eq!(record["command"], format!("willis infer {input} -n 128 -o again"));
    assert_eq!(record["time"]["shards"], 2);
    let json = willis(here.path(), &["merge", "s0", "s64", "-o", "again", "--json", "-q"]);
    let said: Value = serde_json::from_slice(&json.stdout).expect("JSON");
    assert_eq!(said["command"], record["command"]);
}

#[test]
fn shards_of_other_runs_are_refused_by_what_differs() {
    let here = folder();
    let here = here.path();
    let input = data("broken-circle-of-willis.swc");
    let changed = fs::read_to_string(&input).expect("data") + "# another\n";
    fs::write(here.join("other.swc"), changed).expect("written");
    let shard = |out: &str, input: &str, range: &str, more: &[&str]| {
        done(here, &[&["infer", input, "-n", "256", "-o", out, "--range", range, "-q"], more].concat());
    };
    shard("a", &input, "0..128", &[]);
    let refused = |names: &[&str], words: &[&str]| {
        let output = willis(here, &[&["merge"], names, &["-o", "out"]].concat());
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        let last = said.lines().last().expect("an error");
        assert!(words.iter().all(|word| last.contains(word)), "{words:?} in {said}");
        assert!(!here.join("out").exists());
    };
    let others: [(&str, &str, &[&str], &[&str]); 10] = [
        ("input", "other.swc", &[], &["another input"]),
        ("seed", &input, &["--seed", "1"], &["has seed 1", "a has 0"]),
        ("epsilon", &input, &["--epsilon", "0.3"], &["has epsilon 0.3", "a has 0.5"]),
        ("samples", &input, &["-n", "512"], &["samples 512", "a has 256"]),
        ("keep", &input, &["--keep", "median"], &["has keep \"median\"", "a has \"probable=1.5\""]),
        ("weight", &input, &["--weight", "count"], &["has weight \"count\""]),
        ("k", &input, &["-k", "4"], &["has k 4"]),
        ("uncertain", &input, &["--uncertain", "all"], &["has uncertain \"all\""]),
        ("inlet", &input, &["--inlet", "1=90"], &["has inlet"]),
        ("dpi", &input, &["--dpi", "50"], &["has dpi 50"]),
    ];
    for (name, input, more, words) in others {
        if name == "samples" {
            done(here, &["infer", input, "-n", "512", "-o", name, "--range", "128..512", "-q"]);
        } else {
            shard(name, input, "128..256", more);
        }
        refused(&["a", name], &[&[&format!("{name}: ")[..]], words].concat());
    }
    shard("b", &input, "64..256", &[]);
    shard("d", &input, "192..256", &[]);
    refused(&["b", "a"], &["b: samples 64..128 are in a too"]);
    refused(&["a", "a"], &["a: samples 0..128 are in a too"]);
    refused(&["a", "d"], &["d: samples 128..192 before it are in no shard"]);
    refused(&["a"], &["a: samples 128..256 after it are in no shard"]);
    refused(&["b"], &["b: samples 0..64 before it are in no shard"]);
    shard("c", &input, "128..256", &[]);
    done(here, &["merge", "c", "a", "-o", "fine", "-q"]);
    refused(&["a", "fine"], &["a: a shard, where fine is a run"]);
    refused(&["a", "absent"], &["absent: cannot be read"]);
    refused(&["a/shard.json", "b"], &["a/shard.json: no folder"]);
    let text = fs::read_to_string(here.join("c/shard.json")).expect("a record");
    fs::write(here.join("c/shard.json"), text.replace("\"willis\":\"", "\"willis\":\"9.")).expect("written");
    refused(&["a", "c"], &["c: was made by willis 9."]);
    fs::write(here.join("c/shard.json"), text.replacen("\"length\":0.0", "\"length\":0.1", 1)).expect("written");
    refused(&["a", "c"], &["c/shard.json: damaged", "graph"]);
    fs::write(here.join("c/shard.json"), text.replace("\"roles\":[", "\"roles\":[\"Inner\",")).expect("written");
    refused(&["c", "a"], &["c/shard.json: damaged"]);
    fs::write(here.join("c/shard.json"), &text[..text.len() / 2]).expect("written");
    refused(&["a", "c"], &["c/shard.json: ", "EOF"]);
    fs::write(here.join("c/shard.json"), text).expect("written");
    let mut sums = fs::read(here.join("c/shard.npz")).expect("sums");
    let middle = sums.len() / 2;
    sums[middle] ^= 1;
    fs::write(here.join("c/shard.npz"), sums).expect("written");
    refused(&["a", "c"], &["c/shard.npz: damaged"]);
    fs::remove_file(here.join("c/shard.npz")).expect("removed");
    refused(&["a", "c"], &["c/shard.npz: cannot be read"]);
}

/// An array of shard.npz, and what becomes of a figure in it.
type Case = (&'static str, fn(f64) -> f64);

/// Sums that no samples can have, with the checksum made again: each is refused by what it is. The truth is what sums of figures of zero or
/// more are.
#[test]
fn a_shard_with_sums_that_no_samples_have_is_refused() {
    let here = folder();
    let here = here.path();
    let run = ["infer", &data("broken-circle-of-willis.swc"), "-n", "192", "--threads", "1"];
    let names = shards(here, &run, "s", &[0, 128, 192]);
    merged(here, &names);
    let (sums, record) = (here.join("s0/shard.npz"), here.join("s0/shard.json"));
    let (whole, text) = (fs::read(&sums).expect("sums"), fs::read_to_string(&record).expect("a record"));
    let refuse = |what: &str| {
        let output = willis(here, &["merge", "s0", "s128", "-o", "out"]);
        assert_eq!(output.status.code(), Some(2), "{what}: {}", stderr(&output));
        assert!(stderr(&output).lines().last().is_some_and(|line| line.starts_with("willis: s0/shard.")), "{}", stderr(&output));
        assert!(!here.join("out").exists());
    };
    let place = |values: &[f64]| values.iter().position(|x| *x > 0.0).expect("a figure above zero");
    let cases: [Case; 24] = [
        ("count", |_| 1e9),
        ("count", |_| -1.0),
        ("count", |x| x - 0.5),
        ("count", |_| f64::NAN),
        ("count", |_| 0.0),
        ("likelihood", |x| -x),
        ("likelihood", |x| 1e3 * x),
        ("likelihood", |x| x / 1e3),
        ("likelihood", |_| f64::INFINITY),
        ("likelihood", |_| f64::NAN),
        ("square", |x| -x),
        ("square", |x| 1e6 * x),
        ("square", |x| x / 1e6),
        ("square", |_| f64::NAN),
        ("rho_G", |x| -x),
        ("rho_G", |_| f64::INFINITY),
        ("residual", |_| -1.0),
        ("residual", |_| f64::NAN),
        ("samples", |x| x + 1.0),
        ("samples", |_| -1.0),
        ("blocks", |_| 3.0),
        ("trace", |x| -x),
        ("trace", |x| 2.0 * x),
        ("run", |x| x + 1.0),
    ];
    for (name, change) in cases {
        let mut arrays = read_arrays(&whole).expect("arrays");
        let array = arrays.iter_mut().find(|array| array.name == name).expect("there");
        let at = if name == "residual" { 0 } else { place(&array.values) };
        array.values[at] = change(array.values[at]);
        let mut bytes = std::io::Cursor::new(Vec::new());
        write_arrays(&mut bytes, arrays).expect("written");
        fs::write(&sums, bytes.get_ref()).expect("written");
        let stated = text.replace(&checksum(&whole), &checksum(bytes.get_ref()));
        assert_ne!(stated, text);
        fs::write(&record, stated).expect("written");
        refuse(name);
    }
    fs::write(&sums, &whole).expect("written");
    // Fields of the record that say what cannot be.
    let value: Value = serde_json::from_str(&text).expect("JSON");
    for (field, wrong) in [
        ("sampling_s", serde_json::json!(-1.0)),
        ("range", serde_json::json!([0, 1_000_000])),
        ("range", serde_json::json!([128, 0])),
        ("solver", serde_json::json!({ "flow": "magic", "size": 1, "forest": "kruskal", "forest_joins": null })),
        ("sums", serde_json::json!("")),
        ("graph", serde_json::json!("0")),
    ] {
        let mut record_of = value.clone();
        record_of[field] = wrong;
        fs::write(&record, record_of.to_string()).expect("written");
        refuse(field);
    }
    fs::write(&record, text).expect("written");
    merged(here, &names);
}

#[test]
fn ranges_that_cannot_be_are_refused() {
    let circle = fs::read(data("broken-circle-of-willis.swc")).expect("data");
    let cases: [(&[&str], &[&str]); 10] = [
        (&["--range", "0-64"], &["--range 0-64", "A..B"]),
        (&["--range", "0..100"], &["100 is no border", "64 and 128"]),
        (&["--range", "64..64"], &["A < B"]),
        (&["--range", "0..2048"], &["at most the 1000"]),
        (&["--range", "-64..64"], &["--range"]),
        (&["--range", "0..64", "--until", "stable"], &["--range", "--until"]),
        (&["--range", "0..64", "--exact"], &["--range", "--exact"]),
        (&["--range", "0..64", "--epsilon", "0.2,0.5"], &["--range 0..64", "one --epsilon"]),
        (&["--range", "0..64", "b.swc"], &["--range 0..64", "one INPUT"]),
        (&["--checkpoint", "sometimes"], &["--checkpoint", "auto, off or a number of seconds"]),
    ];
    for (more, words) in cases {
        let files: [(&str, &[u8]); 2] = [("a.swc", &circle), ("b.swc", &circle)];
        refused(&files, &[&["infer", "a.swc", "-o", "out"], more].concat(), words);
    }
}

/// A shard is replaced as the folder of a run is, and nothing else with it.
#[test]
fn a_shard_is_replaced_by_force_only() {
    let here = folder();
    let input = data("broken-circle-of-willis.swc");
    let shard =
        |more: &[&str]| willis(here.path(), &[&["infer", &input, "-n", "128", "-o", "s", "--range", "0..64"], more].concat());
    assert!(shard(&[]).status.success());
    assert!(stderr(&shard(&[])).contains("exists already"));
    assert!(shard(&["--force"]).status.success());
    fs::write(here.path().join("s/thesis.txt"), "precious").expect("written");
    assert!(stderr(&shard(&["--force"])).contains("thesis.txt"));
}

const SCRIPT: &str = r#"
import json, sys
import numpy as np
whole, parts = sys.argv[1], sys.argv[2:]
z = [np.load(f"{p}/shard.npz") for p in parts]
n = [json.load(open(f"{p}/shard.json"))["range"] for p in parts]
assert [int(s["samples"].sum()) for s in z] == [b - a for a, b in n]
assert all((s["blocks"][:, 0] % s["blocks"][:, 1] == 0).all() for s in z)
L = sum(s["likelihood"].sum(axis=0) for s in z)
import csv
rows = list(csv.DictReader(open(f"{whole}/edges.csv")))
assert np.allclose(L, [float(r["likelihood"]) for r in rows], rtol=1e-12)
count = sum(s["count"].sum(axis=0) for s in z) / 200
assert np.allclose(count, [float(r["frequency"]) for r in rows], rtol=1e-12)
uncertain = [float(r["likelihood"]) for r in rows if r["origin"] == "candidate"]
# 200 samples: three whole steps of the record and one cut short, all in the sums.
assert sum(len(s["step"]) for s in z) == 4
assert np.allclose(sum(s["trace"].sum(axis=0) for s in z), uncertain, rtol=1e-12)
"#;

/// Needs `WILLIS_PYTHON`: the sums of shards, added up by NumPy, are the likelihoods of the run.
#[test]
fn numpy_reads_shards() {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python with numpy");
        return;
    };
    let here = folder();
    let input = data("broken-circle-of-willis.swc");
    let run = ["infer", &input, "-n", "200"];
    let shards = shards(here.path(), &run, "s", &[0, 64, 200]);
    merged(here.path(), &shards);
    let output =
        Command::new(python).current_dir(here.path()).args(["-c", SCRIPT, "merged"]).args(&shards).output().expect("runs");
    assert!(output.status.success(), "{}", stderr(&output));
}
