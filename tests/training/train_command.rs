//! `willis train` as a person runs it: what it reads, what it writes, what it refuses.

use std::fs;
use std::path::Path;

use crate::command::{data, folder, stderr, willis};
use crate::refused::{contents, refused};
use willis::internals::candidates::model::Weights;
use willis::internals::training::fold_of;

/// Six broken trees as case folders of three subjects, below two folders.
fn cases(here: &Path) {
    for seed in 0..6 {
        let case = here.join(format!("trees/{}/t{}", ["easy", "hard"][seed / 3], seed % 3));
        broken_tree(&case, seed);
        fs::write(case.join("inlets.csv"), "x_mm,y_mm,z_mm\n0,0,0\n").expect("a file");
    }
}

/// A broken tree as a case folder.
fn broken_tree(case: &Path, seed: usize) {
    fs::create_dir_all(case).expect("a folder");
    let made = willis(case, &["phantom", "tree", "--break", "--seed", &seed.to_string(), "-o", "fragments.swc"]);
    assert!(made.status.success(), "{}", stderr(&made));
    fs::rename(case.join("fragments.truth.json"), case.join("truth.json")).expect("a file");
}

fn weights(path: &Path) -> Weights {
    Weights::read(&fs::read_to_string(path).expect("a file")).expect("weights")
}

#[test]
fn weights_and_folds_are_written_and_the_threads_do_not_matter() {
    let here = folder();
    cases(here.path());
    let run = |threads: &str, output: &str| {
        let arguments = ["train", "trees", "-o", output, "--folds", "2", "--save-folds", "--passes", "2", "--threads", threads];
        let done = willis(here.path(), &arguments);
        assert!(done.status.success(), "{}", stderr(&done));
        stderr(&done)
    };
    let said = run("1", "one/w.toml");
    run("2", "two/w.toml");
    assert_eq!(contents(&here.path().join("one")), contents(&here.path().join("two")));
    for words in ["trees: 6 cases of 3 subjects", "fold 2  pass 2", "trees/easy: average precision ", "written  one/w.toml"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let whole = weights(&here.path().join("one/w.toml"));
    assert_eq!((whole.provenance.cases, whole.provenance.subjects, whole.passes.len()), (6, 3, 2));
    assert!(whole.provenance.made_by.ends_with("willis train trees --folds 2 --save-folds --passes 2 -o again.toml"));
    let of: Vec<&str> = whole.figures.iter().map(|f| f.of.as_str()).collect();
    assert_eq!(of, ["trees", "trees/easy", "trees/hard"]);
    let mut held_out = Vec::new();
    for fold in 1..=2 {
        let part = weights(&here.path().join(format!("one/w.fold-{fold}.toml")));
        let provenance = part.provenance;
        assert_eq!(provenance.held_out, whole.folds[fold - 1].held_out);
        assert_eq!(part.figures, whole.folds[fold - 1].figures);
        assert!(provenance.held_out.iter().all(|s| fold_of(s, 2) == fold - 1));
        assert_eq!((provenance.subjects, provenance.cases), (3 - provenance.held_out.len(), 6 - 2 * provenance.held_out.len()));
        held_out.extend(provenance.held_out);
    }
    held_out.sort();
    assert_eq!(held_out, ["t0", "t1", "t2"]);
    let again = willis(here.path(), &["train", "trees", "-o", "one/w.toml", "--folds", "0", "--passes", "1"]);
    assert!(!again.status.success() && stderr(&again).contains("exists already"), "{}", stderr(&again));
}

/// Further cases have a part in the calibration and in what is usual, and in nothing else; what is unlike all of them is told with its figure.
#[test]
fn further_cases_calibrate_and_say_what_is_usual() {
    let here = folder();
    cases(here.path());
    let mut fragments = Vec::new();
    for seed in 100..145 {
        let case = here.path().join(format!("others/t{seed}"));
        broken_tree(&case, seed);
        let swc = fs::read_to_string(case.join("fragments.swc")).expect("a file");
        fragments.push(swc.lines().filter(|line| !line.starts_with('#') && line.ends_with(" -1")).count() as f64);
    }
    let fitted = |output: &str, more: &[&str]| {
        let done = willis(here.path(), &[&["train", "trees", "-o", output, "--folds", "0", "--passes", "1"], more].concat());
        assert!(done.status.success(), "{}", stderr(&done));
        weights(&here.path().join(output))
    };
    let (alone, with) = (fitted("alone.toml", &[]), fitted("with.toml", &["--calibrate-with", "others"]));
    assert_eq!((&alone.passes, alone.of_input, alone.usual), (&with.passes, [0.0; 3], None));
    assert!(alone.calibration != with.calibration && with.of_input != [0.0; 3]);
    let [least, most] = with.usual.expect("51 cases").0[0];
    assert!(fragments.iter().all(|n| (least..=most).contains(n)), "{least} to {most}: {fragments:?}");

    let text = fs::read_to_string(here.path().join("with.toml")).expect("a file");
    let odd = text.replace(&format!("\nfragments = [{least:?}, {most:?}]"), "\nfragments = [1000.0, 2000.0]");
    fs::write(here.path().join("odd.toml"), odd).expect("a file");
    let note = |prior: &[&str]| {
        let circle = data("broken-circle-of-willis.swc");
        let ran = willis(here.path(), &[&["infer", &circle, "-o", "out", "-n", "1", "--dpi", "36", "--force"], prior].concat());
        assert!(ran.status.success(), "{}", stderr(&ran));
        stderr(&ran)
    };
    let told = note(&["--prior", "odd.toml"]);
    assert!(
        told.contains("unlike all that the probabilities were fitted to") && told.contains("fragments (there 1000 to 2000)"),
        "{told}"
    );
    assert!(!note(&[]).contains("unlike all that"));
}

/// A corrected edges.csv and a list of right bridges give the same answer as each other.
#[test]
fn right_bridges_may_come_from_a_table() {
    let here = folder();
    cases(here.path());
    let head = "ax_mm,ay_mm,az_mm,bx_mm,by_mm,bz_mm";
    let swc = fs::read_to_string(here.path().join("trees/easy/t0/fragments.swc")).expect("a file");
    let truth = fs::read(here.path().join("trees/easy/t0/truth.json")).expect("a file");
    let truth: serde_json::Value = serde_json::from_slice(&truth).expect("JSON");
    let point = |id: &serde_json::Value| {
        let row = swc.lines().find(|l| l.split(' ').next() == Some(&id.to_string())).expect("a point");
        row.split(' ').skip(2).take(3).collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = truth["breaks"]
        .as_array()
        .expect("breaks")
        .iter()
        .map(|gap| format!("{},{}", point(&gap["ids"][0]), point(&gap["ids"][1])))
        .collect();
    let plain = format!("{head}\n{}\n", rows.join("\n"));
    let kept: Vec<String> = rows.iter().map(|r| format!("{r},candidate,1\n{r},candidate,0\n{r},observed,1\n")).collect();
    for (name, text) in [("plain", plain), ("kept", format!("{head},origin,kept\n{}", kept.concat()))] {
        let case = here.path().join(name).join("t0");
        fs::create_dir_all(&case).expect("a folder");
        fs::write(case.join("links.csv"), text).expect("a file");
        for file in ["fragments.swc", "inlets.csv"] {
            fs::copy(here.path().join("trees/easy/t0").join(file), case.join(file)).expect("a file");
        }
    }
    let trained = ["plain", "kept"].map(|name| {
        let output = format!("{name}.toml");
        let done = willis(here.path(), &["train", name, "-o", &output, "--folds", "0", "--passes", "1"]);
        assert!(done.status.success(), "{}", stderr(&done));
        weights(&here.path().join(output))
    });
    assert_eq!(trained[0].passes, trained[1].passes);
    assert_eq!(trained[0].calibration, trained[1].calibration);
    // The phantom's landmarks are no fragments, whatever format these have.
    let case = here.path().join("plain/t0");
    let made = willis(&case, &["convert", "fragments.swc", "fragments.vtp"]);
    assert!(made.status.success(), "{}", stderr(&made));
    fs::remove_file(case.join("fragments.swc")).expect("a file");
    fs::write(case.join("fragments.landmarks.csv"), "label,x_mm,y_mm,z_mm\nT,0,0,0\n").expect("a file");
    let done = willis(here.path(), &["train", "plain", "-o", "vtp.toml", "--folds", "0", "--passes", "1"]);
    assert!(done.status.success(), "{}", stderr(&done));
}

#[test]
fn what_is_wrong_is_said_in_one_line() {
    refused(&[], &["train", "nowhere", "-o", "w.toml"], &["nowhere", "cannot be read"]);
    let here = folder();
    cases(here.path());
    let case = here.path().join("trees/easy/t0");
    let fails = |arguments: &[&str], words: &[&str]| {
        let done = willis(here.path(), &[&["train"], arguments].concat());
        let said = stderr(&done);
        assert_eq!(done.status.code(), Some(2), "{said}");
        let said = said.lines().last().expect("a line");
        assert!(words.iter().all(|w| said.contains(w)), "{words:?}: {said}");
        assert!(!here.path().join("w.toml").exists());
    };
    let rest = ["-o", "w.toml"];
    let one = |words: &[&str]| fails(&["trees", "-o", "w.toml", "--folds", "0", "--passes", "1"], words);
    fs::create_dir_all(here.path().join("empty")).expect("a folder");
    fails(&[&["empty"][..], &rest].concat(), &["empty: no case", "fragments.swc"]);
    fails(&[&["nowhere"][..], &rest].concat(), &["nowhere: cannot be read"]);
    fails(&["trees", "-o", "w.json"], &["--output w.json", ".toml"]);
    fails(&["trees", "-o", "w.toml", "--folds", "1"], &["--folds 1"]);
    fails(&["trees", "-o", "w.toml", "--folds", "9"], &["--folds 9", "2 to 3, the number of subjects"]);
    fails(&["trees", "trees/easy", "-o", "w.toml"], &["CASES trees/easy/t0 is trees/easy/t0 once more"]);
    fails(&["trees", "-o", "w.toml", "--folds", "0", "--save-folds"], &["--save-folds"]);
    fails(&["trees", "-o", "w.toml", "--l2=-1"], &["--l2 -1"]);
    fails(&["trees", "-o", "w.toml", "--l2", "nan"], &["--l2 NaN"]);
    fails(&["trees", "-o", "w.toml", "--images-onto", "nothere.toml"], &["--images-onto nothere.toml", "--model skeleton"]);
    fails(&["trees", "-o", "w.toml", "--model", "labels", "--passes", "1"], &["--passes 1", "--model tracing"]);
    fails(&["trees", "-o", "w.toml", "--passes", "0"], &["--passes 0"]);
    let labelled = here.path().join("labelled");
    fs::create_dir(&labelled).expect("a folder");
    for (name, text) in [
        ("fragments.swc", "1 0 0 0 0 1 -1\n2 0 0 0 5 1 1\n"),
        ("labels.csv", "id,label\n1,BA\n"),
        ("truth.json", r#"{"subject": "a", "whole": true, "frame": "SPL"}"#),
    ] {
        fs::write(labelled.join(name), text).expect("a file");
    }
    fails(&["labelled", "-o", "w.toml", "--model", "labels"], &["truth.json: frame: \"SPL\"", "RAS or LPS"]);
    let truth = |text: &str| fs::write(case.join("truth.json"), text).expect("a file");
    truth("{\"breaks\": [{\"ids\": [1, 999999]}]}");
    one(&["truth.json: break 0: point 999999"]);
    truth("{\"links\": [[{\"role\": \"child\", \"allowed\": [7]}]], \"nodes\": [[0, 0, 0, 1]]}");
    one(&["truth.json: link 0: node 7", "1 to 1"]);
    truth("{\"links\": [[{\"role\": \"child\", \"allowed\": [1]}]], \"nodes\": [[900, 0, 0, 1]]}");
    one(&["truth.json: link 0: no point", "these fragments"]);
    truth("{\"links\": [], \"nodes\": [[0, 0]]}");
    one(&["truth.json: node 1", "[x, y, z, r]"]);
    truth("{\"links\": [], \"voxel_mm\": -1}");
    one(&["truth.json: voxel_mm: -1"]);
    truth("{}");
    one(&["truth.json: neither links nor breaks"]);
    truth("{\n\"links\": 3}");
    one(&["truth.json:2:"]);
    fs::write(case.join("links.csv"), "ax_mm\n").expect("a file");
    one(&["links.csv lies beside it", "one answer"]);
    fs::remove_file(case.join("truth.json")).expect("a file");
    one(&["links.csv:1:", "ay_mm"]);
    let links = |text: &str| {
        fs::write(case.join("links.csv"), format!("ax_mm,ay_mm,az_mm,bx_mm,by_mm,bz_mm,kept\n{text}")).expect("a file");
    };
    links("0,0,0,1,1,1,0\n");
    one(&["links.csv: no correct candidate", "kept 1"]);
    links("0,0,0,9000,0,0,1\n");
    one(&["links.csv:2:", "9000,0,0", "from the nearest point"]);
    links("0,0,0,1,1,1,2\n");
    one(&["links.csv:2: kept \"2\""]);
    fs::remove_file(case.join("fragments.swc")).expect("a file");
    one(&["no file fragments.*"]);
}
