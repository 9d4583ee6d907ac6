//! The command as a person runs it: exit status, one-line errors that name the fault, untouched files, repeatable bytes.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{builder, data, folder, stderr, willis};
use crate::refused::{contents, refused};
#[cfg(unix)]
use crate::signals::with_signals;
use std::collections::BTreeSet;
use std::ffi::OsString;
use willis::cli::check;
use willis::cli::internals::{LinePart, infer_parts, parser, parts, quoted, row_parts, shared_parts, words_of};

const LINE: &[u8] = b"1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n3 0 2 0 0 1 2\n";

#[test]
fn bad_centerlines_are_refused_by_line_and_value() {
    let infer = ["infer", "a.swc", "-o", "out"];
    refused(&[("a.swc", b"")], &infer, &["a.swc", "empty"]);
    refused(&[("a.swc", b"1 0 0 0 0 1 -1\n2 0 1 0 1\n")], &infer, &["a.swc:2", "5 columns", "7"]);
    refused(&[("a.swc", b"1 0 0 0 0 1 -1\n2 0 1 0 0 1 9\n")], &infer, &["a.swc:2", "9", "exist"]);
    refused(&[("a.swc", b"1 0 0 0 0 1 -1\n2 0 1 0 0 wide 1\n")], &infer, &["a.swc:2", "radius", "wide"]);
    refused(&[("a.swc", b"1 0 0 0 0 0 -1\n2 0 1 0 0 0 1\n")], &infer, &["a.swc", "no valid radius", "--default-radius"]);
    refused(&[("a.swc", b"1 0 0 0 0 1 -1\n2 0 x 0 0 1 1\n")], &infer, &["a.swc:2", "x"]);
    refused(&[("a.swc", b"1 0 0 0 0 1 -1\n2 0 inf 0 0 1 1\n")], &infer, &["a.swc:2", "inf"]);
    refused(&[("a.swc", b"1 0 0 0 0 1 2\n2 0 1 0 0 1 1\n")], &infer, &["a.swc:1", "ancestor", "--loops"]);
    refused(&[], &infer, &["a.swc", "cannot be read"]);
}

#[test]
fn a_graph_without_an_end_to_enter_by_is_refused() {
    let ring = br#"<graphml xmlns="http://graphml.graphdrawing.org/xmlns"><key id="l" for="edge" attr.name="length_mm" attr.type="double"/>
<key id="r" for="edge" attr.name="radius_mm" attr.type="double"/><graph edgedefault="undirected"><node id="a"/><node id="b"/><node id="c"/>
<edge source="a" target="b"><data key="l">1</data><data key="r">1</data></edge><edge source="b" target="c"><data key="l">1</data>
<data key="r">1</data></edge><edge source="c" target="a"><data key="l">1</data><data key="r">1</data></edge></graph></graphml>"#;
    refused(&[("ring.graphml", ring)], &["infer", "ring.graphml", "-o", "out"], &["no inlet", "0 free ends", "--inlet"]);
    let given = ["infer", "ring.graphml", "-o", "out", "--inlet", "a", "--outlet", "zz"];
    refused(&[("ring.graphml", ring)], &given, &["--outlet", "zz", "expected an id"]);
}

#[test]
fn arguments_out_of_range_are_refused_by_name_and_value() {
    let cases: [(&[&str], &[&str]); 17] = [
        (&["--epsilon", "0.5,0.5"], &["--epsilon", "0.5", "twice"]),
        (&["--epsilon", "abc"], &["--epsilon", "abc"]),
        (&["--epsilon", "1e308"], &["--epsilon 1e308: expected"]),
        (&["--flow", "1=10", "--flow=3=-10"], &["flows only", "pressure"]),
        (&["--observed"], &["--observed", "graph"]),
        (&["--epsilon", "1.5"], &["--epsilon", "1.5", "0 <= epsilon < 1"]),
        (&["--epsilon", "-0.1"], &["--epsilon", "-0.1"]),
        (&["-n", "0"], &["--samples", "0"]),
        (&["--keep", "mode"], &["--keep", "mode", "median"]),
        (&["--keep", "quantile=2"], &["--keep", "2"]),
        (&["--viscosity", "3.5mm"], &["--viscosity", "3.5mm", "cP"]),
        (&["--max-gap", "-3"], &["--max-gap", "-3"]),
        (&["-k", "0"], &["-k", "0"]),
        (&["--dpi", "1"], &["--dpi", "1"]),
        (&["--units", "voxel"], &["--units", "--spacing"]),
        (&["--outlets", "sea"], &["--outlets", "sea", "murray"]),
        (&["--inlet", "1=3cP"], &["--inlet", "3cP", "mmHg"]),
    ];
    for (extra, words) in cases {
        let joined: Vec<String> = match extra {
            [name, value] if name.starts_with("--") && !value.starts_with("--") => vec![format!("{name}={value}")],
            other => other.iter().map(ToString::to_string).collect(),
        };
        let mut arguments = vec!["infer", "a.swc", "-o", "out"];
        arguments.extend(joined.iter().map(String::as_str));
        refused(&[("a.swc", LINE)], &arguments, words);
    }
}

#[test]
fn an_output_that_exists_is_left_alone() {
    let here = folder();
    fs::write(here.path().join("a.swc"), LINE).expect("written");
    fs::create_dir(here.path().join("out")).expect("made");
    fs::write(here.path().join("out/mine.txt"), "precious").expect("written");
    for arguments in [&["infer", "a.swc", "-o", "out"][..], &["infer", "a.swc", "-o", "out", "--force"]] {
        let output = willis(here.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains("out"), "{}", stderr(&output));
        assert_eq!(fs::read(here.path().join("out/mine.txt")).expect("still there"), b"precious");
    }
    assert!(willis(here.path(), &["infer", "a.swc", "-o", "ours", "-q"]).status.success());
    let again = willis(here.path(), &["infer", "a.swc", "-o", "ours", "-q", "--seed", "1"]);
    assert!(stderr(&again).contains("--force"), "{}", stderr(&again));
    assert!(willis(here.path(), &["infer", "a.swc", "-o", "ours", "-q", "--seed", "1", "--force"]).status.success());
    // A folder that holds a run and something else is not ours to replace, nor is a folder of runs with something else.
    fs::create_dir(here.path().join("study")).expect("made");
    fs::write(here.path().join("study/thesis.txt"), "precious").expect("written");
    assert!(willis(here.path(), &["infer", "a.swc", "-o", "study/run", "-q"]).status.success());
    fs::write(here.path().join("study/run/notes.txt"), "precious").expect("written");
    for target in ["study", "study/run"] {
        let output = willis(here.path(), &["infer", "a.swc", "-o", target, "--force"]);
        assert_eq!(output.status.code(), Some(2), "{target}: {}", stderr(&output));
        assert!(stderr(&output).contains(".txt"), "{}", stderr(&output));
    }
    assert!(here.path().join("study/thesis.txt").exists() && here.path().join("study/run/notes.txt").exists());
    fs::remove_dir_all(here.path().join("study")).expect("removed");
    let record = fs::read_to_string(here.path().join("ours/run.json")).expect("a record");
    assert!(record.contains("\"seed\": 1"));
    let left: Vec<_> = fs::read_dir(here.path()).expect("a folder").map(|e| e.expect("an entry").file_name()).collect();
    assert_eq!(left.len(), 3, "nothing temporary stays: {left:?}");
}

#[test]
fn every_command_replaces_the_folder_that_it_wrote() {
    let here = folder();
    let [circle, again] = ["a.swc", "b.swc"].map(|name| here.path().join(name));
    fs::copy(data("broken-circle-of-willis.swc"), &circle).expect("copied");
    fs::copy(&circle, &again).expect("copied");
    for line in [
        "infer a.swc -n 16 -o run",
        "infer a.swc -n 16 --epsilon 0.3,0.5 -o several",
        "infer a.swc b.swc -n 16 -o runs",
        "merge runs/a runs/b -o merged",
        "classify run -o circle",
        "classify runs/a runs/b -o circles",
        "measure run -o measures",
        "measure runs/a runs/b -o all-measures",
        "label a.swc b.swc -o names",
        "simulate a.swc --pulse -o flow",
        "simulate a.swc --occlude-each -o losses",
        "modulate a.swc -n 4 -o modulated",
    ] {
        let mut words: Vec<&str> = line.split(' ').chain(["-q"]).collect();
        for _ in 0..2 {
            let output = willis(here.path(), &words);
            assert_eq!(output.status.code(), Some(0), "{words:?}: {}", stderr(&output));
            words.push("--force");
        }
    }
}

#[test]
fn the_shipped_example_gives_every_file_and_the_same_bytes_at_any_thread_count() {
    let here = folder();
    let input = data("broken-circle-of-willis.swc");
    let mut first = None;
    for threads in ["1", "2", "8"] {
        let out = format!("out{threads}");
        let output = willis(here.path(), &["infer", &input, "-o", &out, "--threads", threads, "--epsilon", "0.3"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let files = contents(&here.path().join(out));
        let names: Vec<String> = files.iter().map(|(name, _)| name.display().to_string()).collect();
        for name in [
            "convergence.png",
            "convergence.svg",
            "edges.csv",
            "likelihood.npy",
            "likelihood.npz",
            "likelihood.png",
            "likelihood.svg",
            "nodes.csv",
            "report.html",
            "run.json",
            "topology-median.graphml",
            "topology-median.vtp",
            "topology.graphml",
            "topology.vtp",
        ] {
            assert!(names.iter().any(|n| n == name), "{name} is missing among {names:?}");
        }
        assert_eq!(first.get_or_insert_with(|| files.clone()), &files, "{threads} threads");
    }
}

#[test]
fn the_candidate_graph_handed_back_gives_the_edges_of_the_direct_run() {
    let here = folder();
    let input = data("broken-circle-of-willis.swc");
    assert!(willis(here.path(), &["infer", &input, "-o", "direct", "-q"]).status.success());
    assert!(willis(here.path(), &["candidates", &input, "-o", "graph.graphml", "-q"]).status.success());
    let output = willis(here.path(), &["infer", "graph.graphml", "-o", "handed", "-q"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let edges = |folder: &str| fs::read_to_string(here.path().join(folder).join("edges.csv")).expect("edges");
    assert_eq!(edges("direct"), edges("handed"));
}

#[test]
fn the_shipped_example_is_what_its_script_makes() {
    let here = folder();
    let made = willis(here.path(), &["phantom", "cerebral", "--break", "--seed", "1", "--spacing", "1mm", "-o", "a.swc"]);
    assert!(made.status.success(), "{}", stderr(&made));
    let same =
        |made: &str, shipped: &str| fs::read(here.path().join(made)).expect("made") == fs::read(data(shipped)).expect("shipped");
    assert!(same("a.swc", "broken-circle-of-willis.swc"));
    assert!(same("a.truth.json", "broken-circle-of-willis.truth.json"));
    let made = willis(here.path(), &["phantom", "cerebral", "--break", "--seed", "2", "--spacing", "0.6mm", "-o", "scan.nii.gz"]);
    assert!(made.status.success(), "{}", stderr(&made));
    assert!(same("scan.truth.json", "scan.truth.json") && same("scan.landmarks.csv", "scan.landmarks.csv"));
    // Another processor may pack the same voxels in other bytes.
    let voxels = |path: &Path| {
        let mut unpacked = Vec::new();
        flate2::read::MultiGzDecoder::new(fs::File::open(path).expect("a mask")).read_to_end(&mut unpacked).expect("whole");
        unpacked
    };
    assert!(voxels(&here.path().join("scan.nii.gz")) == voxels(Path::new(&data("scan.nii.gz"))));
}

#[test]
fn several_occlusion_probabilities_make_a_folder_each_and_a_table() {
    let here = folder();
    let output = willis(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "out", "--epsilon", "0.2,0.5", "-q"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(here.path().join("out/epsilon-0.2/edges.csv").exists() && here.path().join("out/epsilon-0.5/edges.csv").exists());
    let table = fs::read_to_string(here.path().join("out/agreement.csv")).expect("a table");
    assert_eq!(table.lines().count(), 2, "{table}");
}

#[cfg(unix)]
#[test]
fn a_full_or_closed_standard_error_and_a_strange_file_name_are_no_reason_to_fail() {
    use std::os::unix::ffi::OsStrExt;
    let here = folder();
    let name = std::ffi::OsStr::from_bytes(b"\xff.swc");
    fs::write(here.path().join(name), LINE).expect("written");
    let mut command = builder(here.path());
    command.arg("infer").arg(name).args(["-o", "out"]);
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a full device");
    let status = command.stderr(full).status().expect("runs");
    assert_eq!(status.code(), Some(0));
    assert!(here.path().join("out/run.json").exists());
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_nothing_behind() {
    let here = folder();
    fs::write(here.path().join("a.swc"), LINE).expect("written");
    let arguments = ["infer", "a.swc", "-o", "out", "-n", "1000000000000", "--epsilon", "0.1,0.2", "--checkpoint=off"];
    let mut command = with_signals(here.path(), "--default-signal=INT");
    let child = command.args(arguments).stderr(std::process::Stdio::piped()).spawn().expect("runs");
    std::thread::sleep(std::time::Duration::from_millis(700));
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(kill.success());
    let output = child.wait_with_output().expect("ends");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).lines().any(|l| l.starts_with("willis: stopped after")), "{}", stderr(&output));
    let left: Vec<_> = fs::read_dir(here.path()).expect("a folder").map(|e| e.expect("an entry").file_name()).collect();
    assert_eq!(left, ["a.swc"]);
}

#[test]
fn an_output_is_an_input_with_the_same_conditions() {
    let here = folder();
    let input = data("broken-circle-of-willis.swc");
    assert!(willis(here.path(), &["infer", &input, "-o", "out", "-q"]).status.success());
    let mut conditions = Vec::new();
    for next in ["out/topology.graphml", "out/edges.csv"] {
        assert!(willis(here.path(), &["infer", next, "-o", "again", "-q", "--force"]).status.success());
        let record = fs::read_to_string(here.path().join("again/run.json")).expect("a record");
        let record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
        let of = |c: &serde_json::Value| (c["id"].clone(), c["pressure_mmHg"].clone(), c["resistance_mmHg_s_per_mL"].clone());
        let all = record["boundary_conditions"].as_array().expect("a list").iter().map(of).collect::<Vec<_>>();
        assert!(all.len() > 10);
        conditions.push(all);
    }
    assert_eq!(conditions[0], conditions[1]);
}

/// A terminal resistance to a venous pressure, stated on the command line, in CSV and in TOML: one condition, one answer.
#[test]
fn a_venous_pressure_can_be_stated_in_three_ways() {
    let here = folder();
    let graph = "<graphml><key id=\"length_mm\" for=\"edge\" attr.name=\"length_mm\" attr.type=\"double\"/>\
                 <key id=\"radius_mm\" for=\"edge\" attr.name=\"radius_mm\" attr.type=\"double\"/><graph><node id=\"a\"/><node id=\"b\"/><node id=\"c\"/>\
                 <edge source=\"a\" target=\"b\"><data key=\"length_mm\">10</data><data key=\"radius_mm\">1</data></edge>\
                 <edge source=\"b\" target=\"c\"><data key=\"length_mm\">20</data><data key=\"radius_mm\">1</data></edge>\
                 </graph></graphml>";
    fs::write(here.path().join("g.graphml"), graph).expect("written");
    let csv = "node,kind,value,unit,venous_pressure_mmHg\na,inlet,90,mmHg,\nc,resistance,20,mmHg.s/mL,5\n";
    fs::write(here.path().join("bc.csv"), csv).expect("written");
    let toml = "[[condition]]\nnode = \"a\"\nkind = \"inlet\"\nvalue = 90\n\n[[condition]]\nnode = \"c\"\nkind = \"resistance\"\nvalue = 20\nvenous_pressure_mmHg = 5\n";
    fs::write(here.path().join("bc.toml"), toml).expect("written");
    let ways = [&["--inlet", "a=90", "--outlet", "c=20mmHg.s/mL@5mmHg"][..], &["--bc", "bc.csv"], &["--bc", "bc.toml"]];
    for way in ways {
        let output = willis(here.path(), &[&["infer", "g.graphml", "-o", "out", "--force"], way].concat());
        assert!(output.status.success(), "{way:?}: {}", stderr(&output));
        let record = fs::read_to_string(here.path().join("out/run.json")).expect("a record");
        let record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
        let last = &record["boundary_conditions"][1];
        assert_eq!(last["id"], "c", "{way:?}");
        for (key, figure) in [("resistance_mmHg_s_per_mL", 20.0), ("venous_pressure_mmHg", 5.0)] {
            let got = last[key].as_f64().expect(key);
            assert!((got - figure).abs() < 1e-12, "{way:?}: {key} {got}");
        }
    }
}

/// `--outlets` is for outlets that are found; where all are stated it says so instead of passing over it in silence.
#[test]
fn an_option_for_found_outlets_says_when_there_are_none() {
    let here = folder();
    let circle = data("circle-of-willis/complete.graphml");
    for command in ["infer", "simulate", "modulate"] {
        let output = willis(here.path(), &[command, &circle, "-o", command, "--outlets", "ground"]);
        assert!(output.status.success() && stderr(&output).contains("--outlets changes nothing"), "{}", stderr(&output));
    }
}

/// At 1,024 samples and more a run goes on until every decision on L is clear, and says so; run.json has it, and only then.
#[test]
fn a_run_until_stable_says_that_it_is() {
    let here = folder();
    let scan = data("broken-circle-of-willis.swc");
    let record = |out: &str| -> serde_json::Value {
        serde_json::from_slice(&fs::read(here.path().join(out).join("run.json")).expect("a record")).expect("JSON")
    };
    let ran = willis(here.path(), &["infer", &scan, "--keep", "median", "--until", "stable", "-o", "stable"]);
    let said = stderr(&ran);
    assert!(
        said.contains("samples until stable") && said.contains("stable  every decision of the rule is two standard errors"),
        "{said}"
    );
    let stable = record("stable");
    assert_eq!((&stable["convergence"]["stable"], &stable["convergence"]["undecided"]), (&true.into(), &0.into()));
    willis(here.path(), &["infer", &scan, "-n", "64", "-o", "fixed"]);
    assert!(record("fixed")["convergence"]["stable"].is_null());
}

/// An argument that is typed without a name is called as in the help.
#[test]
fn an_argument_without_a_name_has_that_of_its_place() {
    let convert = ["convert", "a.swc", "b.swc"];
    refused(&[("a.swc", LINE), ("b.swc", b"x")], &convert, &["b.swc: exists already; choose another OUT or give --force"]);
    refused(&[("a.swc", LINE)], &["convert", "a.swc", "b.xyz"], &["willis: OUT b.xyz: expected an ending", "or --to FORMAT"]);
    // What has no --to speaks of none.
    let here = folder();
    fs::write(here.path().join("a.swc"), LINE).expect("written");
    let said = stderr(&willis(here.path(), &["label", "a.swc", "-o", "b.xyz"]));
    assert!(said.starts_with("willis: --output b.xyz: expected an ending .swc") && said.ends_with(".am or .yaml\n"), "{said}");
}

/// A perturbation of less than 0.05 % is no `+0.0 %`.
#[test]
fn a_change_that_is_too_small_to_show_is_said_in_words() {
    let here = folder();
    let graph = data("circle-of-willis/complete.graphml");
    let ran = willis(here.path(), &["simulate", &graph, "--stenosis", "edge:0=0.01%", "-o", "out"]);
    let said = stderr(&ran);
    assert!(ran.status.success() && said.contains("(by less than 0.05 %)") && !said.contains("0.0 %)"), "{said}");
}

/// A folder in which the inputs lie is not replaced by what is made of them, not even by force: they would be lost.
#[test]
fn force_does_not_take_the_inputs_away() {
    let here = folder();
    fs::copy(data("broken-circle-of-willis.swc"), here.path().join("scan1.swc")).expect("copied");
    assert!(willis(here.path(), &["infer", "scan*.swc", "-o", "out", "-n", "64", "-q"]).status.success());
    let before = contents(here.path());
    for words in [
        &["classify", "out/*", "-o", "out"][..],
        &["measure", "out", "-o", "out"],
        &["measure", "out/scan1", "-o", "out/scan1"],
        &["infer", "out/*/topology.graphml", "-o", "out"],
        &["infer", "out/scan1/candidates.graphml", "-o", "./out/scan1"],
        &["label", "out/*/topology.graphml", "-o", "out"],
        &["simulate", "out/scan1/topology.graphml", "-o", "out"],
        &["modulate", "out/scan1/topology.graphml", "-o", "out"],
        &["classify", "out/scan1", "-o", "out/scan1"],
        &["merge", "out/*", "-o", "out"],
    ] {
        let output = willis(here.path(), &[words, &["--force"]].concat());
        let said = stderr(&output);
        assert!(output.status.code() == Some(2) && said.contains("would be replaced"), "{words:?}: {said}");
        assert_eq!(contents(here.path()), before, "{words:?}: files were touched");
    }
}

#[test]
fn a_run_of_a_dataset_is_one_of_its_mask() {
    let words = |line: &str| words_of(infer_parts(typed(line), Path::new("m.nii.gz"))).join(" ");
    let line = words("-v bids in out participant --participant-label 01 out -n 64 --filter=desc=a --filter run=1 --seed 2");
    assert_eq!(line, "-v infer m.nii.gz -n 64 --seed 2");
    assert_eq!(words("bids -n 64 in out participant --session_label a b"), "infer m.nii.gz -n 64");
    assert_eq!(words("bids -n 64 --participant-label 01 02 -- in out participant"), "infer m.nii.gz -n 64");
}

/// The parts of a line whose words have no blanks.
fn typed(line: &str) -> Vec<LinePart> {
    parts(&parser(), &line.split(' ').map(str::to_owned).collect::<Vec<_>>())
}

/// What a row of a manifest states replaces what was given for all.
#[test]
fn a_row_has_the_words_of_all_but_its_own() {
    let all = typed("infer study.csv --spacing 0.5 -o out --landmarks={}.csv -n 64");
    let own = [("spacing", "0.4,0.4,0.6"), ("landmarks", "/a b.fcsv")].map(|(a, b)| (a.to_owned(), b.to_owned()));
    let words = words_of(row_parts(&shared_parts(all, &[PathBuf::from("study.csv")]), Path::new("x.swc"), &own));
    assert_eq!(words, ["infer", "x.swc", "-o", "out", "-n", "64", "--spacing=0.4,0.4,0.6", "--landmarks=/a b.fcsv"]);
    // What follows -- is no option, and the value of an option is no input.
    let words = |line: &str, given: &str| {
        words_of(row_parts(&shared_parts(typed(line), &[PathBuf::from(given)]), Path::new("-x.swc"), &own[..1])).join(" ")
    };
    assert_eq!(words("infer -n 64 -- a.csv", "a.csv"), "infer -n 64 --spacing=0.4,0.4,0.6 -- ./-x.swc");
    assert_eq!(words("infer 64 -n 64 -vo out", "64"), "infer ./-x.swc -n 64 -v -o out --spacing=0.4,0.4,0.6");
    assert_eq!(words("infer infer", "infer"), "infer ./-x.swc --spacing=0.4,0.4,0.6");
}

/// The line in run.json, given to a shell, makes the same vessels again, in whatever way the words were typed.
#[cfg(unix)]
#[test]
fn a_recorded_line_repeats_its_run() {
    let here = folder();
    fs::copy(data("broken-circle-of-willis.swc"), here.path().join("-lead.swc")).expect("copied");
    let bin = Path::new(env!("CARGO_BIN_EXE_willis")).parent().expect("a folder").display().to_string();
    let ways = ["infer -n 64 -o out1 -- -lead.swc", "infer ./-lead.swc -n 64 -qo out2", "infer ./-lead.swc -qn64 -oout3"];
    for (at, line) in ways.into_iter().enumerate() {
        let out = here.path().join(format!("out{}", at + 1));
        let made = willis(here.path(), &line.split(' ').collect::<Vec<_>>());
        assert!(made.status.success(), "{line}: {}", stderr(&made));
        let record: serde_json::Value = serde_json::from_slice(&fs::read(out.join("run.json")).expect("a record")).expect("JSON");
        let recorded = record["command"].as_str().expect("a line");
        let again = format!("PATH='{bin}':\"$PATH\"; {recorded}");
        let ran = Command::new("sh").args(["-c", &again]).current_dir(here.path()).output().expect("a shell");
        assert!(ran.status.success(), "{recorded}: {}", stderr(&ran));
        let edges = |folder: &Path| fs::read(folder.join("edges.csv")).expect("a table");
        assert_eq!(edges(&here.path().join("again")), edges(&out), "{recorded}");
        fs::remove_dir_all(here.path().join("again")).expect("removed");
    }
}

/// A POSIX shell splits the line into the same words again.
#[test]
fn a_line_is_its_words() {
    let words = ["willis", "infer", "it's a scan.swc", "", "--bc", "{}.bc.csv", r"a\b", "''", "-n=64"];
    let line = words.map(quoted).join(" ");
    assert_eq!(line, r"willis infer 'it'\''s a scan.swc' '' --bc '{}.bc.csv' 'a\b' ''\'''\''' -n=64");
}

/// Two arguments of one name are one to the parser: what is given to the second is refused as given twice, and programs with debug
/// assertions end. Every command with all that it shares.
#[test]
fn every_argument_has_a_name_of_its_own() {
    for command in parser().get_subcommands() {
        let (mut ids, mut options) = (BTreeSet::new(), BTreeSet::new());
        for argument in command.get_arguments() {
            let (name, id) = (command.get_name(), argument.get_id());
            assert!(ids.insert(id), "{name}: two arguments {id}");
            let short = argument.get_short().map(String::from);
            let long = argument.get_long_and_visible_aliases().into_iter().flatten().map(str::to_owned);
            for option in long.chain(argument.get_all_aliases().into_iter().flatten().map(str::to_owned)).chain(short) {
                assert!(options.insert(option.clone()), "{name}: two options {option}");
            }
        }
    }
}

/// `--level` of `willis bids` is that of masks; it was taken for a second level of analysis.
#[test]
fn a_command_line_is_checked_without_a_run() {
    let said = |line: &str| check(line.split(' ').map(OsString::from));
    assert_eq!(said("willis bids in out participant --level 0.5 --prior none"), None);
    assert_eq!(said("willis infer x.swc -o out"), None);
    assert!(said("willis infer x.swc -o out --epsilon much").is_some_and(|said| said.contains("see willis help infer")));
}
