//! report.html in a browser: counts at every threshold against NetworkX, switches, sorting, picking, keys, no error, no fault by
//! axe-core where `WILLIS_AXE` names its script. Needs `WILLIS_CHROMIUM` (with chromedriver beside it or on the path) and `WILLIS_PYTHON`.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::command::{data, folder, stderr, willis};
use crate::grown::grown;

const LABELS: [&str; 5] = ["<script>alert(1)</script>", "\"&'", "</script>", "cerebri média 中", "<img src=x onerror=alert(2)>"];

fn run(here: &Path, arguments: &[&str]) {
    let output = willis(here, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
}

#[test]
fn pages_work_in_chromium() {
    let Some([python, chromium]) = tools() else {
        eprintln!("skipped: WILLIS_CHROMIUM names no Chromium, or WILLIS_PYTHON no Python with tests/requirements.txt");
        return;
    };
    let here = folder();
    for vessels in [500, 20_000] {
        let (nodes, edges) = grown(vessels, &LABELS);
        let graph = here.path().join(format!("graph{vessels}"));
        fs::create_dir(&graph).expect("made");
        fs::write(graph.join("nodes.csv"), nodes).expect("written");
        fs::write(graph.join("edges.csv"), edges).expect("written");
    }
    let small = "graph500/edges.csv";
    run(here.path(), &["phantom", "tree", "--break", "--seed", "3", "-o", "tree.swc", "-q"]);
    let scan = data("scan.nii.gz");
    run(here.path(), &["phantom", "cerebral", "--break", "--seed", "1", "-o", "one.swc", "-q"]);
    run(here.path(), &["phantom", "cerebral", "--break", "--seed", "2", "-o", "two.swc", "-q"]);
    run(here.path(), &["phantom", "tree", "--break", "--spacing", "0.7mm", "-o", "seen.nii.gz", "--image", "image.nii", "-q"]);
    let complete = data("circle-of-willis/complete.graphml");
    fs::write(here.path().join("line.swc"), "1 0 0 0 0 1 -1\n2 0 5 0 0 1 1\n3 0 10 0 0 1 2\n").expect("written");
    fs::write(
        here.path().join("groups.csv"),
        "input,subject,group\none.swc,a,</script>\ntwo.swc,b,</script>\ntree.swc,c,x\ncontrol.swc,d,x\n",
    )
    .expect("written");
    run(here.path(), &["phantom", "cerebral", "-o", "control.swc", "-q"]);
    let runs: [(&str, &[&str]); 17] = [
        ("median", &["infer", small, "-n", "300"]),
        ("otsu", &["infer", small, "-n", "300", "--keep", "otsu"]),
        ("frequency", &["infer", small, "-n", "300", "--keep", "frequency=0.4"]),
        ("all", &["infer", small, "-n", "300", "--uncertain", "all", "--keep", "value=1e6"]),
        ("probable", &["infer", "tree.swc", "-n", "64"]),
        ("probability", &["infer", "tree.swc", "-n", "64", "--keep", "probability=0.4"]),
        ("certain", &["infer", "line.swc", "-n", "64"]),
        ("contacts", &["infer", &scan, "-n", "64"]),
        ("image", &["infer", "seen.nii.gz", "--image", "image.nii", "-n", "64"]),
        ("many", &["infer", "graph20000/edges.csv", "-n", "64"]),
        ("circle", &["infer", "one.swc", "--landmarks", "one.landmarks.csv", "-n", "64"]),
        ("classified", &["classify", "circle"]),
        ("cohort", &["infer", "one.swc", "two.swc", "--landmarks", "{}.landmarks.csv", "-n", "64"]),
        ("compared", &["measure", "groups.csv", "--compare", "group"]),
        ("simulate", &["simulate", small, "--occlude", "</script>"]),
        ("modulate", &["modulate", &complete, "-n", "64"]),
        ("pulse", &["simulate", &complete, "--pulse", "--transport", "--occlude", "L-A1"]),
    ];
    for (out, arguments) in runs {
        run(here.path(), &[arguments, &["-o", out, "-q"]].concat());
    }
    // Four browsers at once: each waits for its frames most of the time.
    let (here, tools) = (here.path(), [python.as_str(), &chromium]);
    std::thread::scope(|scope| {
        for part in 0..4 {
            let folders: Vec<&str> = runs.iter().map(|(out, _)| *out).skip(part).step_by(4).collect();
            scope.spawn(move || drive("drive.py", tools, here, &folders));
        }
    });
    drive("drive_flat.py", tools, here, &["median"]);
}

/// Runs a script with Chromium on folders.
fn drive(script: &str, [python, chromium]: [&str; 2], here: &Path, folders: &[&str]) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/report").join(script);
    let mut driver = Command::new(python);
    driver.env("WILLIS_BINARY", env!("CARGO_BIN_EXE_willis"));
    let output = driver.arg(script).arg(chromium).args(folders).current_dir(here).output().expect("runs");
    let said = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}{}", said(&output.stdout), said(&output.stderr));
}

#[test]
fn thirty_connections_of_a_real_mask_are_decided_by_keys_and_replay() {
    let mask = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/kdxf-masks/KDXF_001.nii.gz");
    let (Some(tools), true) = (tools(), mask.is_file()) else {
        eprintln!("skipped: the mask, WILLIS_CHROMIUM or WILLIS_PYTHON is not there");
        return;
    };
    let here = folder();
    run(here.path(), &["infer", &mask.display().to_string(), "-n", "64", "-o", "real", "-q"]);
    drive("drive_session.py", tools.each_ref().map(String::as_str), here.path(), &["real"]);
}

/// Ids that a spreadsheet would take for formulas; a part that nothing can join; two parts that one candidate joins; nodes without places.
#[test]
fn lists_are_loaded_as_they_were_saved() {
    let Some(tools) = tools() else {
        eprintln!("skipped: WILLIS_CHROMIUM or WILLIS_PYTHON is not there");
        return;
    };
    let here = folder();
    let columns = "node_a,node_b,length_mm,radius_mm,origin,probability\n";
    let placed = "-1,=b,20,1,observed,\n@c,d,20,1,observed,\n=b,@c,5,1,candidate,0.6\n=b,d,25,1,candidate,0.3\n";
    fs::write(here.path().join("edges.csv"), format!("{columns}{placed}")).expect("written");
    fs::write(here.path().join("nodes.csv"), "id,x_mm,y_mm,z_mm\n-1,0,0,0\n=b,20,0,0\n@c,25,0,0\nd,45,0,0\n").expect("written");
    fs::create_dir(here.path().join("plain")).expect("made");
    let plain = "a,b,20,1,observed,\nb,c,5,1,candidate,0.5\nc,d,20,1,observed,\n";
    fs::write(here.path().join("plain/edges.csv"), format!("{columns}{plain}")).expect("written");
    let lone = "1 0 0 0 0 2 -1\n2 0 60 0 0 2 1\n3 0 250 0 0 1 -1\n4 0 220 0 0 1 3\n";
    fs::write(here.path().join("lone.swc"), lone).expect("written");
    let parts = "1 0 0 0 0 2 -1\n2 0 60 0 0 2 1\n3 0 150 0 0 1 -1\n4 0 120 0 0 1 3\n5 0 110 4 0 1 -1\n6 0 110 29 0 1 5\n";
    fs::write(here.path().join("parts.swc"), parts).expect("written");
    run(here.path(), &["infer", "edges.csv", "--inlet=-1", "-n", "64", "-o", "formulas", "-q"]);
    run(here.path(), &["infer", "plain/edges.csv", "--inlet=a", "-n", "64", "-o", "unplaced", "-q"]);
    run(here.path(), &["infer", "lone.swc", "--inlet=1", "-n", "64", "-o", "lone", "-q"]);
    run(here.path(), &["infer", "parts.swc", "--inlet=1", "-n", "64", "--keep", "probability=0.999", "-o", "apart", "-q"]);
    run(here.path(), &["infer", "parts.swc", "--inlet=1", "-n", "64", "--keep", "probability=0.001", "-o", "joined", "-q"]);
    // None of these inputs is there.
    fs::write(here.path().join("groups.csv"), "input,subject,group\nw.swc,a,x\nx.swc,b,x\ny.swc,c,y\nz.swc,d,y\n")
        .expect("written");
    willis(here.path(), &["measure", "groups.csv", "--compare", "group", "-o", "uncompared", "-q"]);
    run(here.path(), &["infer", &data("scan.nii.gz"), "-n", "64", "-o", "contacts", "-q"]);
    let folders = ["formulas", "unplaced", "lone", "apart", "joined", "contacts", "uncompared"];
    drive("drive_lists.py", tools.each_ref().map(String::as_str), here.path(), &folders);
}

/// The Python and the Chromium to test with.
fn tools() -> Option<[String; 2]> {
    Some([std::env::var("WILLIS_PYTHON").ok()?, std::env::var("WILLIS_CHROMIUM").ok()?])
}
