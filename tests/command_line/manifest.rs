//! Studies by a manifest, and spacings that differ between subjects: the truth is each subject by itself.

use std::fs;
use std::path::Path;

use crate::command::{data, folder, stderr, willis};
use crate::refused::contents;
use serde_json::Value;

fn done(here: &Path, arguments: &[&str]) -> String {
    let output = willis(here, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stderr(&output)
}

fn refused(here: &Path, arguments: &[&str], words: &[&str]) {
    let before = contents(here);
    let output = willis(here, arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(words.iter().all(|word| said.contains(word)), "{words:?} in {said}");
    assert_eq!(contents(here), before, "files were touched");
}

fn record(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("run.json")).expect("a record")).expect("JSON")
}

/// Two broken phantoms in a folder of their own, with landmarks under other names.
fn study(here: &Path) {
    for (seed, name) in [("1", "first"), ("2", "second")] {
        let file = format!("study/{name}.swc");
        done(here, &["phantom", "cerebral", "--break", "--seed", seed, "-o", &file, "-q"]);
        fs::rename(here.join(format!("study/{name}.landmarks.csv")), here.join(format!("study/{name}.csv"))).expect("renamed");
    }
}

/// What follows `--` is an input: the options of a row stand before it, so that its unit counts.
#[test]
fn a_row_keeps_its_unit_where_the_manifest_follows_two_dashes() {
    let here = folder();
    let here = here.path();
    fs::write(here.join("line.swc"), "1 0 0 0 0 1 -1\n2 0 10 0 0 1 1\n3 0 20 0 0 1 2\n").expect("written");
    fs::write(here.join("study.csv"), "input,units\nline.swc,cm\n").expect("written");
    done(here, &["infer", "-o", "cohort", "-n", "64", "-q", "--", "study.csv"]);
    let record = record(&here.join("cohort/line"));
    assert_eq!(record["options"]["read"]["scale"]["unit"], "cm");
    assert_eq!(record["command"], "willis infer -n 64 --units=cm --landmarks auto -o again -- line.swc");
}

/// Arteries are named where nobody says where they are, whether or not a row has other options of its own.
#[test]
fn a_row_with_options_of_its_own_is_named_as_the_others() {
    let here = folder();
    let here = here.path();
    study(here);
    fs::write(here.join("study/rows.csv"), "subject,input,default_radius\na,first.swc,\nb,first.swc,1mm\n").expect("written");
    done(here, &["infer", "study/rows.csv", "-o", "cohort", "-n", "64", "-q"]);
    let [a, b] = ["a", "b"].map(|subject| record(&here.join("cohort").join(subject)));
    assert!(a["phenotype"].is_object() && a["phenotype"] == b["phenotype"]);
    assert!(b["command"].as_str().is_some_and(|line| line.ends_with(" --default-radius=1mm --landmarks auto -o again")));
    // An option of the whole run is no option of a row, and is said to be none.
    fs::write(here.join("study/rows.csv"), "subject,input,max_gap,age\na,first.swc,9,61\n").expect("written");
    let said = done(here, &["infer", "study/rows.csv", "-o", "cohort", "-n", "64", "--force"]);
    let whole = "change nothing; options of the whole run are given on the command line: max_gap\n";
    assert!(said.contains(whole) && said.contains("that are no options go into cohort.csv: age\n"), "{said}");
}

/// Rows with options of their own, in the words of BIDS and of willis; each row is the run with these options.
#[test]
fn every_row_is_a_run_with_its_own_options() {
    let here = folder();
    let here = here.path();
    study(here);
    let table = "participant_id\tinput\tlandmarks\tunits\tspacing\tage\nsub-01\tfirst.swc\tfirst.csv\tvoxel\t1\t61\n\
                 # a remark\nsub-02\tsecond.swc\tsecond.csv\tvoxel\t0.98,0.98,0.98\tn/a\n";
    fs::write(here.join("study/participants.tsv"), table).expect("written");
    let said = done(here, &["infer", "study/participants.tsv", "-o", "cohort", "-n", "64"]);
    assert!(said.contains("columns of the manifest that are no options go into cohort.csv: age"), "{said}");
    let rows = fs::read_to_string(here.join("cohort/cohort.csv")).expect("a table");
    let ages: Vec<&str> = rows.lines().filter_map(|line| line.split(',').nth(5)).collect();
    assert_eq!(ages, ["age", "61", ""], "{rows}");
    let own: [(&str, &str, &[&str]); 2] = [
        ("sub-01", "first", &["--units", "voxel", "--spacing", "1"]),
        ("sub-02", "second", &["--units", "voxel", "--spacing", "0.98,0.98,0.98"]),
    ];
    for (subject, name, options) in own {
        let (input, marks) = (format!("study/{name}.swc"), format!("study/{name}.csv"));
        done(here, &[&["infer", &input, "-o", name, "-n", "64", "--landmarks", &marks], options].concat());
        let (of_cohort, alone) = (record(&here.join("cohort").join(subject)), record(&here.join(name)));
        for key in ["options", "counts", "boundary_conditions", "parameters", "input"] {
            assert_eq!(of_cohort[key], alone[key], "{subject}: {key}");
        }
        let edges = |folder: &Path| fs::read(folder.join("edges.csv")).expect("a table");
        assert_eq!(edges(&here.join("cohort").join(subject)), edges(&here.join(name)));
        // The line that a run records makes it again.
        let line = of_cohort["command"].as_str().expect("a line");
        let words: Vec<&str> = line.split(' ').skip(1).map(|word| if word == "again" { subject } else { word }).collect();
        done(here, &words);
        assert_eq!(edges(&here.join(subject)), edges(&here.join(name)), "{line}");
    }
    // Only the row that has changed is done again.
    assert!(
        done(here, &["infer", "study/participants.tsv", "-o", "cohort", "-n", "64"]).contains("2 of 2 subjects done already")
    );
    fs::write(here.join("study/participants.tsv"), table.replace("0.98,0.98,0.98", "0.99")).expect("written");
    let said = done(here, &["infer", "study/participants.tsv", "-o", "cohort", "-n", "64"]);
    assert!(said.contains("1 of 2 subjects done already"), "{said}");
    assert_eq!(
        record(&here.join("cohort/sub-02"))["options"]["read"]["scale"]["spacing_mm"],
        serde_json::json!([0.99, 0.99, 0.99])
    );

    // The folder of a cohort means its subjects, to classify.
    done(here, &["classify", "cohort", "-o", "by-folder"]);
    done(here, &["classify", "cohort/*", "-o", "by-pattern"]);
    let table = |folder: &str| fs::read_to_string(here.join(folder).join("cohort.csv")).expect("a table");
    assert_eq!(table("by-folder"), table("by-pattern"));
    assert_eq!(table("by-folder").lines().count(), 3);

    // Runs whose spacings differ are one cohort; runs of other samples are not.
    done(here, &["merge", "first", "second", "-o", "merged"]);
    let ledger: Value = serde_json::from_slice(&fs::read(here.join("merged/cohort.json")).expect("a file")).expect("JSON");
    assert_eq!(ledger["parameters"]["spacing_mm"], "of each subject");

    // What a row gives replaces what was given for all; classify takes the same manifest.
    let rows = "input,subject,spacing\nfirst.swc,a,0.4\nsecond.swc,b,\n";
    fs::write(here.join("study/rows.csv"), rows).expect("written");
    let options = ["--units", "voxel", "--spacing", "0.5", "--landmarks", "{}.csv"];
    let landmarks = |name: &str| fs::read_to_string(here.join(format!("study/{name}.csv"))).expect("a table");
    for (name, scale) in [("first", 0.4), ("second", 0.5)] {
        let table = landmarks(name);
        let scaled = table.lines().enumerate().map(|(at, line)| {
            let cells = line.split(',').enumerate().map(|(column, cell)| match cell.parse::<f64>() {
                Ok(x) if at > 0 && column > 0 => (x * scale).to_string(),
                _ => cell.to_owned(),
            });
            cells.collect::<Vec<_>>().join(",") + "\n"
        });
        let scaled: String = scaled.collect();
        fs::write(here.join(format!("study/{name}.csv")), scaled).expect("written");
    }
    done(here, &[&["classify", "study/rows.csv", "-o", "variants"][..], &options].concat());
    for (subject, spacing) in [("a", 0.4), ("b", 0.5)] {
        let line = record(&here.join("variants").join(subject))["command"].as_str().expect("a line").to_owned();
        assert!(line.contains(&format!("--spacing={spacing}")) || line.contains(&format!("--spacing {spacing}")), "{line}");
    }
}

#[test]
fn a_wrong_manifest_is_refused_with_its_line() {
    let here = folder();
    let here = here.path();
    let try_one = |text: &str, words: &[&str]| {
        fs::write(here.join("m.csv"), text).expect("written");
        refused(here, &["infer", "m.csv", "-o", "out"], words);
    };
    try_one("subject,input,landmark\na,a.swc,b\n", &["m.csv:1", "column \"landmark\"", "did you mean \"landmarks\"?"]);
    try_one("subject,input\na,\n", &["m.csv:2", "no input"]);
    try_one("subject,input\na,a.swc\nA,b.swc\n", &["m.csv:3", "subject \"A\", as on line 2"]);
    try_one("subject,input\n", &["m.csv", "no subject", "a row for every subject"]);
    try_one("input,spacing\na.swc,x\n", &["m.csv:2", "spacing", "\"x\""]);
    try_one("input,units,spacing\na.swc,voxel,\n", &["m.csv:2", "units voxel", "needs --spacing"]);
    try_one("input,radius\na.swc,wide\n", &["m.csv:2", "radius", "\"wide\""]);
    // Without quotes these are three values, of which the first would be the spacing of all axes.
    try_one("input,spacing\na.npy,0.5,0.5,0.8\n", &["m.csv:2", "\"0.5\" in a further column", "need quotes"]);
    try_one("input,radius,--radius\na.swc,mean,mean\n", &["m.csv:1", "column \"--radius\": radius comes twice"]);
    // Of two columns of names the second is no mistake: the next line is looked at.
    try_one("subject,participant_id,input\na,b,\n", &["m.csv:2", "no input"]);
    fs::write(here.join("m.csv"), "input,bc\na.swc,b.csv\n").expect("written");
    refused(here, &["classify", "m.csv", "-o", "out"], &["m.csv:2", "bc"]);
    // A folder for all inputs has no place for the name of one.
    fs::write(here.join("m.csv"), "input\na.swc\n").expect("written");
    refused(here, &["infer", "m.csv", "-o", "{}.landmarks.csv"], &["--output {}.landmarks.csv", "stands for an input"]);
}

/// iCafe's Image_info.txt and the header of a mask state the spacing; nothing else does.
#[test]
fn spacing_auto_is_that_which_is_stated() {
    let here = folder();
    let here = here.path();
    for (patient, spacing) in [("p1", "0.5 0.5 0.3"), ("p2", "0.25 0.25 0.7")] {
        fs::create_dir(here.join(patient)).expect("a folder");
        let swc = "1 0 0 0 0 2 -1\n2 0 0 0 40 2 1\n3 0 0 0 80 2 2\n";
        fs::write(here.join(patient).join("t.swc"), swc).expect("written");
        fs::write(here.join(patient).join("Image_info.txt"), format!("Voxel spacing: {spacing}\nOrigin: 1,2,3\n"))
            .expect("written");
    }
    done(here, &["infer", "p1/t.swc", "p2/t.swc", "-o", "out", "-n", "64", "--spacing", "auto"]);
    let length = |subject: &str| {
        let text = fs::read_to_string(here.join("out").join(subject).join("edges.csv")).expect("a table");
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let at = reader.headers().expect("a header").iter().position(|name| name == "length_mm").expect("lengths");
        reader.records().next().expect("a row").expect("a row")[at].parse::<f64>().expect("a number")
    };
    assert!((length("p1") - 40.0).abs() < 1e-9 && (length("p2") - 20.0).abs() < 1e-9, "{} {}", length("p1"), length("p2"));
    done(here, &["infer", "p1/t.swc", "-o", "one", "-n", "64", "--spacing", "auto"]);
    done(here, &["infer", "p2/t.swc", "-o", "two", "-n", "64", "--spacing", "0.25", "--units", "voxel"]);
    let said = done(here, &["convert", "p1/t.swc", "line.vtp", "--spacing", "auto"]);
    assert!(said.contains("SWC, voxel: "), "{said}");
    done(here, &["merge", "one", "two", "-o", "merged"]);
    fs::remove_file(here.join("p2/Image_info.txt")).expect("removed");
    refused(
        here,
        &["infer", "p2/t.swc", "-o", "x", "--spacing", "auto"],
        &["p2/t.swc", "nothing states the spacing", "Image_info.txt"],
    );
    refused(here, &["infer", "p1/t.swc", "-o", "x", "--spacing", "auto", "--units", "mm"], &["--spacing auto", "--units voxel"]);
    done(here, &["phantom", "cerebral", "-o", "scan.nii", "--spacing", "0.8", "-q"]);
    done(here, &["infer", "scan.nii", "-o", "mask", "-n", "64", "--spacing", "auto"]);
}

/// What compares a cohort with the truth is of the manifest as it is: without the truth there is none.
#[test]
fn an_earlier_comparison_with_the_truth_does_not_stay() {
    let here = folder();
    let circle = data("circle-of-willis/complete.graphml");
    fs::write(here.path().join("study.csv"), format!("subject,input,truth\na,{circle},complete\n")).expect("written");
    let classify = ["classify", "study.csv", "-o", "out", "-q"];
    done(here.path(), &[&classify[..], &["--truth", "truth"]].concat());
    assert!(here.path().join("out/accuracy.csv").is_file());
    done(here.path(), &classify);
    assert!(here.path().join("out/cohort.csv").is_file() && !here.path().join("out/accuracy.csv").exists());
}

/// Three circles, one of which is said to be another: by hand, 2 of 3 are right; of the two that are said to be complete, one.
#[test]
fn a_classification_is_compared_with_the_truth() {
    let here = folder();
    let circle = |name: &str| data(&format!("circle-of-willis/{name}.graphml"));
    let rows = [("a", "complete", "complete"), ("b", "without-L-A1", "L-A1"), ("c", "without-L-PComm", "complete")];
    let table: String = rows.map(|(subject, name, truth)| format!("{subject},{},\"{truth}\"\n", circle(name))).concat();
    fs::write(here.path().join("study.csv"), format!("subject,input,truth\n{table}")).expect("written");
    let done = willis(here.path(), &["classify", "study.csv", "-o", "out", "--truth", "truth"]);
    let said = stderr(&done);
    assert_eq!(done.status.code(), Some(0), "{said}");
    assert!(said.contains("compared  2 of 3 variants exact"), "{said}");
    // The column is said to be none that changes nothing.
    assert!(!said.contains("columns of the manifest"), "{said}");
    let text = fs::read_to_string(here.path().join("out/accuracy.csv")).expect("a table");
    let row = |what: &str| text.lines().find(|line| line.starts_with(&format!("{what},"))).expect("a row").to_owned();
    assert_eq!(
        text.lines().next(),
        Some(
            "what,subjects,variants,there_found,there_missed,absent_found,absent_missed,sensitivity,specificity,accuracy,balanced_accuracy"
        )
    );
    assert_eq!(row("L-A1"), "L-A1,3,,2,0,0,1,1,1,1,1");
    assert!(row("L-PComm").starts_with("L-PComm,3,,2,1,0,0,0.666"), "{}", row("L-PComm"));
    assert_eq!(row("anterior"), "anterior,3,2,,,,,,,1,1");
    assert!(row("circle").starts_with("circle,3,2,,,,,,,0.666") && row("circle").ends_with(",0.75"), "{}", row("circle"));
    assert!(row("posterior").starts_with("posterior,3,1,"), "{}", row("posterior"));
    fs::write(here.path().join("bad.csv"), format!("subject,input,truth\na,{},L-A9\n", circle("complete"))).expect("written");
    for (words, wanted) in [
        (
            &["classify", "bad.csv", "-o", "new", "--truth", "truth"][..],
            "bad.csv:2: truth \"L-A9\"; expected complete, or segments of L-A1",
        ),
        (
            &["classify", "study.csv", "-o", "new", "--truth", "variant"],
            "--truth variant: goes with a manifest that has the column",
        ),
        (&["classify", &circle("complete"), "-o", "new", "--truth", "truth"], "--truth truth: goes with a manifest"),
    ] {
        let done = willis(here.path(), words);
        let said = stderr(&done);
        assert!(
            done.status.code() == Some(2) && said.lines().last().is_some_and(|last| last.contains(wanted)),
            "{words:?}: {said}"
        );
        assert!(!here.path().join("new").exists(), "{words:?}");
    }
}
