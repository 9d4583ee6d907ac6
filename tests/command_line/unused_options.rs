//! No option of `infer` is ignored in silence: each is used whatever the input is, or refused, or noted where it changes nothing. The truth is
//! the list of options that the parser itself prints.

use std::collections::BTreeSet;
use std::fs;

use crate::command::{data, folder, stderr, willis};

/// Options that are used on every input, or say themselves what they go with before an input is read.
const USED: [&str; 39] = [
    "output",
    "default-radius",
    "loops",
    "frame",
    "max-input",
    "box",
    "epsilon",
    "samples",
    "until",
    "exact",
    "preset",
    "seed",
    "record-failure",
    "checkpoint",
    "uncertain",
    "weight",
    "viscosity",
    "solver",
    "keep",
    "decisions",
    "dpi",
    "json",
    "prior",
    "inlet",
    "outlet",
    "flow",
    "bc",
    "outlets",
    "landmarks",
    "labels",
    "threads",
    "quiet",
    "verbose",
    "force",
    "help",
    "version",
    "probability",
    "vessels",
    "image",
];

/// What becomes of the others where the input has no use for them: the words, the status, and what is said. SWC is a tracing, GRAPH a ready
/// graph, SCAN a mask.
const UNUSED: [(&str, &str, i32, &str); 27] = [
    ("image-places", "SWC --image-places 3", 2, "--image-places 3: goes with --image or --probability"),
    ("unseen", "SWC --unseen .5", 2, "--unseen 0.5: goes with --landmarks or --labels"),
    ("variant-prior", "SWC --variant-prior /none", 2, "--variant-prior /none: goes with"),
    ("arteries", "SWC --arteries /none", 2, "--arteries /none: goes with"),
    ("hypoplastic", "SWC --hypoplastic 1mm", 2, "--hypoplastic 1 mm: goes with"),
    ("variant-prior", "SWC --landmarks auto --variant-prior /none", 2, "/none: cannot be read"),
    ("arteries", "SWC --landmarks auto --arteries /none", 2, "/none: cannot be read"),
    ("unseen", "LABELLED --labels names --unseen .5", 0, "--unseen changes nothing"),
    ("mask", "SWC --mask /none", 2, "/none: cannot be read"),
    ("mask", "SWC --mask SCAN", 0, "--mask changes nothing"),
    ("mask", "GRAPH --mask /none", 2, "--mask /none: goes with a mask or centerlines"),
    ("radius-array", "SWC --radius-array nope", 2, "--radius-array nope: goes with"),
    ("radius-array", "GRAPH --radius-array nope", 2, "--radius-array nope: goes with"),
    ("k", "GRAPH -k 3", 2, "-k 3: goes with a mask or centerlines"),
    ("max-gap", "GRAPH --max-gap 5", 2, "--max-gap 5 mm: goes with a mask or centerlines"),
    ("attach", "GRAPH --attach ends", 2, "--attach ends: goes with a mask or centerlines"),
    ("candidate-radius", "GRAPH --candidate-radius mean", 2, "--candidate-radius mean: goes with a mask or centerlines"),
    ("max-candidate-radius", "GRAPH --max-candidate-radius 1", 2, "--max-candidate-radius 1 mm: goes with"),
    ("cut", "GRAPH --cut always", 2, "--cut always: goes with a mask or centerlines"),
    ("units", "GRAPH --units cm", 0, "--units and --spacing change nothing in this graph"),
    ("units", "SCAN --units cm", 2, "--units cm: goes with coordinates"),
    ("spacing", "SCAN --spacing 1", 2, "--spacing"),
    ("radius", "GRAPH --radius effective", 2, "--radius effective: goes with centerlines"),
    ("level", "SWC --level .5", 2, "--level 0.5: goes with a mask"),
    ("radius-from", "SWC --radius-from distance", 2, "--radius-from distance: goes with a mask"),
    ("cavities", "SWC --cavities keep", 2, "--cavities keep: goes with a mask"),
    ("observed", "SWC --observed", 2, "goes with a candidate graph"),
];

#[test]
fn every_option_of_infer_is_used_refused_or_noted() {
    let here = folder();
    let help = String::from_utf8(willis(here.path(), &["infer", "--help"]).stdout).expect("UTF-8");
    // Explanations stand further to the right.
    let options = help.lines().filter(|line| line.len() - line.trim_start().len() <= 6).map(str::trim_start);
    let names = options.filter(|line| line.starts_with('-')).map(|line| {
        let name = line.find("--").map_or(&line[1..2], |at| &line[at + 2..]);
        name.split([' ', '=', '[', ',']).next().unwrap_or_default().trim_end_matches('.').to_owned()
    });
    let listed: BTreeSet<String> = names.collect();
    let placed: BTreeSet<String> = USED.into_iter().chain(UNUSED.into_iter().map(|(name, ..)| name)).map(str::to_owned).collect();
    assert_eq!(listed, placed, "each option needs a place in this test");

    let swc = data("broken-circle-of-willis.swc");
    assert!(willis(here.path(), &["candidates", &swc, "-o", "g.graphml"]).status.success());
    assert!(willis(here.path(), &["phantom", "circle-of-willis", "-o", "labelled.vtp"]).status.success());
    for (at, (_, words, status, said)) in UNUSED.into_iter().enumerate() {
        let word = |word: &str| match word {
            "SWC" => swc.clone(),
            "GRAPH" => "g.graphml".to_owned(),
            "LABELLED" => "labelled.vtp".to_owned(),
            "SCAN" => data("scan.nii.gz"),
            other => other.to_owned(),
        };
        let mut all = vec!["infer".to_owned()];
        all.extend(words.split(' ').map(word));
        all.extend(["-v", "-n", "64", "--dpi", "36", "-o"].map(str::to_owned));
        all.push(format!("out-{at}"));
        let output = willis(here.path(), &all.iter().map(String::as_str).collect::<Vec<_>>());
        let found = stderr(&output);
        assert_eq!(output.status.code(), Some(status), "{words}: {found}");
        assert!(found.contains(said), "{words}: \"{said}\" is missing in {found}");
        // What was noted stands in the record too.
        if status == 0 {
            let record = fs::read_to_string(here.path().join(format!("out-{at}/run.json"))).expect("a record");
            assert!(record.contains("nothing"), "{words}");
        }
    }
}
