//! `willis classify` as a person runs it: its files, what it says, and what it refuses.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::command::{data, folder, stderr, willis};
use crate::refused::{contents, refused};

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).expect("a file")).expect("JSON")
}

/// The cells of a column of a table.
fn column(table: &str, name: &str) -> Vec<String> {
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let at = rows.headers().expect("a header").iter().position(|column| column == name).expect(name);
    rows.records().map(|row| row.expect("a row")[at].to_owned()).collect()
}

#[test]
fn the_folder_holds_the_phenotype_and_its_record() {
    let here = folder();
    let input = data("circle-of-willis/without-R-PComm-L-P1.graphml");
    let output = willis(here.path(), &["classify", &input, "-o", "out", "--json"]);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("complete anterior part, left fetal-type PCA, R-PComm absent"), "{said}");
    let phenotype = json(&here.path().join("out/phenotype.json"));
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&output.stdout).expect("JSON"), phenotype);
    // The keys of CoW_Centerline_Extraction, no more and no fewer.
    let expected = serde_json::json!({
        "anterior": { "L-A1": true, "Acom": true, "3rd-A2": false, "R-A1": true },
        "posterior": { "L-Pcom": true, "L-P1": false, "R-P1": true, "R-Pcom": false },
        "fetal": { "L-PCA": true, "R-PCA": false },
        "fenestration": { "L-A1": false, "Acom": false, "R-A1": false, "L-P1": false, "R-P1": false },
    });
    for (key, object) in expected.as_object().expect("an object") {
        assert_eq!(phenotype[key], *object, "{key}");
    }
    assert_eq!(phenotype["variant"], "without L-P1, R-PComm");
    assert_eq!(phenotype["segments"]["R-PComm"], false);
    let table = fs::read_to_string(here.path().join("out/phenotype.csv")).expect("a table");
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines[0].starts_with("subject,variant,completeness,L-A1,R-A1,AComm,L-P1,R-P1,L-PComm,R-PComm,"), "{table}");
    let start = "without-R-PComm-L-P1,\"without L-P1, R-PComm\",anterior complete,1,1,1,0,1,1,0,";
    assert!(lines.len() == 2 && lines[1].starts_with(start), "{table}");
    let record = json(&here.path().join("out/run.json"));
    assert_eq!(record["parameters"]["arteries"], "names");
    assert_eq!(record["input"]["sha256"].as_str().map(str::len), Some(64));

    // An earlier run is replaced with --force alone, by the same bytes.
    let before = contents(here.path());
    assert_eq!(willis(here.path(), &["classify", &input, "-o", "out"]).status.code(), Some(2));
    assert_eq!(willis(here.path(), &["classify", &input, "-o", "out", "--force"]).status.code(), Some(0));
    assert_eq!(contents(here.path()), before);
}

/// The diameters of the circle of Alastruey et al. (J Biomech 40:1794-1805, 2007), table 1: AComm and PComm are 1.48 and 1.46 mm wide, so that
/// they are hypoplastic below 1.5 mm, and nothing is below 1 mm.
#[test]
fn hypoplastic_segments_are_told_in_every_table() {
    let here = folder();
    let inputs = ["complete", "without-AComm"].map(|name| data(&format!("circle-of-willis/{name}.graphml")));
    let run = |arguments: &[&str]| {
        let output = willis(here.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stderr(&output)
    };
    run(&["classify", &inputs[0], "-o", "usual"]);
    assert_eq!(json(&here.path().join("usual/phenotype.json"))["hypoplastic"], serde_json::json!([]));
    let said = run(&["classify", &inputs[0], "-o", "wide", "--hypoplastic", "1.5mm"]);
    assert!(said.contains("AComm, L-PComm, R-PComm (hypoplastic)"), "{said}");
    let phenotype = json(&here.path().join("wide/phenotype.json"));
    assert_eq!(phenotype["hypoplastic"], serde_json::json!(["AComm", "L-PComm", "R-PComm"]));
    assert_eq!(phenotype["variant"], "complete");
    let table = fs::read_to_string(here.path().join("wide/phenotype.csv")).expect("a table");
    assert!(table.lines().next().is_some_and(|header| header.ends_with(",hypoplastic")), "{table}");
    assert!(table.lines().nth(1).is_some_and(|row| row.ends_with(",AComm L-PComm R-PComm")), "{table}");
    run(&["classify", &inputs[0], &inputs[1], "-o", "cohort", "--hypoplastic", "1.5mm"]);
    let table = fs::read_to_string(here.path().join("cohort/cohort.csv")).expect("a table");
    assert_eq!(column(&table, "hypoplastic"), ["AComm L-PComm R-PComm", "L-PComm R-PComm"]);
    for (name, truth) in [
        ("circle_L-A1_diameter_mm", [2.34, 2.34]),
        ("circle_AComm_diameter_mm", [1.48, f64::NAN]),
        ("circle_L-PComm_diameter_mm", [1.46, 1.46]),
        ("circle_AComm_hypoplastic", [1.0, f64::NAN]),
        ("circle_L-A1_hypoplastic", [0.0, 0.0]),
        ("circle_A1_asymmetry", [0.0, 0.0]),
        ("fetal_L-PCA", [0.0, 0.0]),
    ] {
        for (cell, truth) in column(&table, name).iter().zip(truth) {
            assert!(cell.parse::<f64>().map_or(truth.is_nan(), |x| (x - truth).abs() < 1e-9), "{name}: {cell:?}");
        }
    }
    // The tables of subjects have the same cells.
    run(&["measure", &inputs[0], &inputs[1], "-o", "measured", "--hypoplastic", "1.5mm"]);
    let subjects = fs::read_to_string(here.path().join("measured/subjects.csv")).expect("a table");
    let header = subjects.lines().next().expect("a header").split(',');
    let shared: Vec<&str> = header.filter(|name| name.starts_with("circle_") || name.starts_with("fetal_")).collect();
    assert_eq!(shared.len(), 7 + 7 + 3 + 2);
    for name in shared {
        assert_eq!(column(&table, name), column(&subjects, name), "{name}");
    }
    for wrong in ["0mm", "-1mm", "thin"] {
        let output = willis(here.path(), &["classify", &inputs[0], "-o", "bad", &format!("--hypoplastic={wrong}")]);
        assert_eq!(output.status.code(), Some(2), "{wrong}");
        assert!(stderr(&output).contains("--hypoplastic"), "{}", stderr(&output));
    }
}

/// Centerlines without labels, by landmarks in the unit of the file, or in mm where they say so.
#[test]
fn landmarks_stand_in_for_labels() {
    let here = folder();
    for (unit, scale, columns, of_landmarks) in
        [("mm", 1.0, "x,y,z", 1.0), ("cm", 0.1, "x,y,z", 0.1), ("um", 1e3, "x_mm,y_mm,z_mm", 1.0)]
    {
        let mut swc = String::new();
        let mut add = |id: usize, [x, y, z]: [f64; 3], parent: i64| {
            writeln!(swc, "{id} 0 {} {} {} {} {parent}", x * scale, y * scale, z * scale, scale).expect("written");
        };
        // A left carotid with M1 and A1 to A2, and nothing else.
        add(1, [-20.0, 0.0, -60.0], -1);
        add(2, [-10.0, 6.0, 0.0], 1);
        add(3, [-60.0, 6.0, 10.0], 2);
        add(4, [-4.0, 40.0, 40.0], 2);
        fs::write(here.path().join("a.swc"), &swc).expect("written");
        let mut text = format!("label,{columns}\n");
        for (label, at) in [("L-ICA", [-20.0, 0.0, -61.0]), ("L-M1", [-61.0, 6.0, 10.0]), ("L-A2", [-4.0, 41.0, 40.0])] {
            let [x, y, z] = at.map(|x: f64| x * of_landmarks);
            writeln!(text, "{label},{x},{y},{z}").expect("written");
        }
        fs::write(here.path().join("l.csv"), &text).expect("written");
        let arguments = ["classify", "a.swc", "-o", unit, "--landmarks", "l.csv", "--units", unit];
        let output = willis(here.path(), &arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert!(stderr(&output).contains("L-M1 at node 3, 1.000 mm away"), "{}", stderr(&output));
        let phenotype = json(&here.path().join(unit).join("phenotype.json"));
        assert_eq!(phenotype["segments"]["L-A1"], true);
        assert_eq!(phenotype["segments"]["R-A1"], false);
        assert_eq!(phenotype["segments"]["R-ICA"], false);
        let record = json(&here.path().join(unit).join("run.json"));
        assert_eq!(record["landmarks"]["path"], "l.csv");
        assert_eq!(record["landmarks"]["sha256"].as_str().map(str::len), Some(64));
    }
}

/// A stretch of two labels between junctions: without A1, the carotid and M1 are one vessel of the contraction.
#[test]
fn labels_that_change_along_a_vessel_are_kept_apart() {
    let here = folder();
    let swc = b"# label 1 L-ICA\n# label 2 L-M1\n# label 3 BA\n# label 4 R-P1\n# label 5 R-P2\n\
1 1 -20 0 -60 2 -1\n2 1 -10 6 0 2 1\n3 2 -60 6 10 1 2\n4 3 0 -15 -40 1 -1\n5 3 0 -9 -1 1 4\n6 4 6 -7 0 1 5\n7 5 20 -60 5 1 6\n";
    fs::write(here.path().join("a.swc"), swc).expect("written");
    let output = willis(here.path(), &["classify", "a.swc", "-o", "out"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let segments = json(&here.path().join("out/phenotype.json"))["segments"].clone();
    assert_eq!((&segments["R-P1"], &segments["L-P1"], &segments["BA"]), (&true.into(), &false.into(), &true.into()));
}

/// Of a table of candidates, those that were kept count; without such a column, the observed vessels.
#[test]
fn only_kept_vessels_count() {
    let here = folder();
    let nodes = "node,x_mm,y_mm,z_mm\ni,0,0,-9\nt,0,0,0\nm,9,0,0\na,0,9,0\n";
    fs::write(here.path().join("nodes.csv"), nodes).expect("written");
    for (kept, there) in [(Some(1), true), (Some(0), false), (None, false)] {
        let column = |name: &str| kept.map_or(String::new(), |_| format!(",{name}"));
        let last = kept.map_or(String::new(), |kept| format!(",{kept}"));
        let one = column("1");
        let edges = format!(
            "node_a,node_b,label,origin,length_mm,radius_mm{}\ni,t,L-ICA,observed,9,1{one}\nt,m,L-M1,observed,9,1{one}\n\
             t,a,,candidate,9,1{last}\na,a,L-A2,observed,9,1{one}\n",
            column("kept")
        );
        fs::write(here.path().join("edges.csv"), edges).expect("written");
        let output = willis(here.path(), &["classify", "edges.csv", "-o", "out", "--force"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let segments = json(&here.path().join("out/phenotype.json"))["segments"].clone();
        assert_eq!(segments["L-A1"], there, "{kept:?}: {}", stderr(&output));
    }
}

#[test]
fn bad_input_ends_in_one_line_and_status_2() {
    let edges: &[u8] = b"node_a,node_b,label,length_mm,radius_mm\na,b,10,9,1\nb,c,4,9,1\n";
    let ambiguous = ["iCafe and TopCoW both have", "--labels icafe|topcow"];
    refused(&[("a.csv", edges)], &["classify", "a.csv", "-o", "out"], &ambiguous);
    let unnamed: &[u8] = b"node_a,node_b,length_mm,radius_mm\na,b,9,1\n";
    refused(
        &[("a.csv", unnamed)],
        &["classify", "a.csv", "-o", "out"],
        &["a.csv", "internal carotid, basilar", "--landmarks FILE"],
    );
    let swc: &[u8] = b"1 0 0 0 0 1 -1\n2 0 0 0 50 1 1\n";
    let twice: &[u8] = b"label,x_mm,y_mm,z_mm\nL-ICA,0,0,0\nL-M1,0,0,50\nleft ICA,0,0,1\n";
    let arguments = ["classify", "a.swc", "-o", "out", "--landmarks", "l.csv"];
    refused(&[("a.swc", swc), ("l.csv", twice)], &arguments, &["l.csv:4", "\"left ICA\", as on line 2"]);
    let far: &[u8] = b"label,x_mm,y_mm,z_mm\nL-ICA,0,0,0\nL-M1,30,0,50\n";
    refused(&[("a.swc", swc), ("l.csv", far)], &arguments, &["l.csv:3", "\"L-M1\" lies 30.0 mm"]);
    refused(&[("a.swc", swc)], &arguments, &["l.csv"]);
    let nowhere = ["classify", "a.csv", "-o", "out", "--landmarks", "l.csv"];
    refused(&[("a.csv", unnamed), ("l.csv", far)], &nowhere, &["l.csv", "the nodes have no coordinates"]);
    refused(&[("a.swc", swc)], &["classify", "a.swc", "-o", "out", "--observed"], &["--observed", "classify"]);
}

/// The command says it where left and right do not fit the axes.
#[test]
fn exchanged_sides_are_warned_of() {
    let here = folder();
    let edges = "node_a,node_b,label,length_mm,radius_mm\ni,t,L-ICA,60,2\nI,T,R-ICA,60,2\nt,m,L-M1,60,1\nT,M,R-M1,60,1\n\
                 t,a,L-A2,60,1\nT,A,R-A2,60,1\nv,b,BA,60,1\n";
    fs::write(here.path().join("edges.csv"), edges).expect("written");
    for (sign, warned) in [(-1.0, false), (1.0, true)] {
        let mut nodes = "node,x_mm,y_mm,z_mm\nv,0,-15,-40\nb,0,-9,0\n".to_owned();
        for (name, [x, y, z]) in [("i", [20, 0, -60]), ("t", [10, 6, 0]), ("m", [60, 6, 10]), ("a", [4, 40, 40])] {
            let x = sign * f64::from(x);
            writeln!(nodes, "{name},{x},{y},{z}\n{},{},{y},{z}", name.to_uppercase(), -x).expect("written");
        }
        fs::write(here.path().join("nodes.csv"), nodes).expect("written");
        let output = willis(here.path(), &["classify", "edges.csv", "-o", "out", "--force"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert_eq!(stderr(&output).contains("left and right look exchanged"), warned, "{}", stderr(&output));
    }
}

/// A phantom lies as a patient does in right-handed axes, so that the check stands up on it: silent on its landmarks, and not on
/// those of the two sides exchanged.
#[test]
fn the_sides_of_a_phantom_are_what_they_are_called() {
    let here = folder();
    let made = willis(here.path(), &["phantom", "cerebral", "--break", "--seed", "3", "-o", "a.swc"]);
    assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
    let landmarks = fs::read_to_string(here.path().join("a.landmarks.csv")).expect("landmarks");
    let exchanged: String = landmarks
        .split_inclusive('\n')
        .map(|line| match line.split_at(line.len().min(2)) {
            ("L-", rest) => format!("R-{rest}"),
            ("R-", rest) => format!("L-{rest}"),
            _ => line.to_owned(),
        })
        .collect();
    assert_ne!(landmarks, exchanged);
    for (text, warned) in [(landmarks, false), (exchanged, true)] {
        fs::write(here.path().join("l.csv"), text).expect("written");
        let output = willis(here.path(), &["classify", "a.swc", "--landmarks", "l.csv", "-o", "out", "--force"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert_eq!(stderr(&output).contains("left and right look exchanged"), warned, "{}", stderr(&output));
    }
}

/// So that classifying a topology's own file answers for that topology, whichever of the two it is.
#[test]
fn in_the_files_of_a_topology_every_vessel_is_kept() {
    let here = folder();
    let output = willis(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "out", "-q"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let table = fs::read_to_string(here.path().join("out/edges.csv")).unwrap();
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let rows: Vec<Vec<&str>> = lines.collect();
    for (file, column) in [("topology", "kept"), ("topology-median", "above_median")] {
        let at = head.iter().position(|name| *name == column).unwrap();
        let kept = || rows.iter().filter(|row| row[at] == "1");
        let length = head.iter().position(|name| *name == "length_mm").unwrap();
        let of_file: f64 = kept().map(|row| row[length].parse::<f64>().unwrap()).sum();
        let read =
            willis::internals::formats::read(&here.path().join(format!("out/{file}.graphml")), &Default::default()).unwrap();
        let willis::internals::formats::Content::Graph(network) = read.content else { panic!("no graph") };
        let read: f64 = network.vessels().map(|(_, vessel)| vessel.length * 1e3).sum();
        assert!((read / of_file - 1.0).abs() < 1e-9 && network.vessel_count() < kept().count(), "{file}");
        assert!(network.vessels().all(|(_, vessel)| vessel.kept == Some(true)), "{file}");
    }
}

/// Arteries that an edited record states are checked: they were looked up in the graph as they stood.
#[test]
fn arteries_of_another_graph_in_a_record_are_refused() {
    let here = folder();
    let run = willis(here.path(), &["infer", &data("scan.nii.gz"), "--landmarks", "auto", "-n", "64", "-o", "run", "-q"]);
    assert!(run.status.success(), "{}", stderr(&run));
    let path = here.path().join("run/run.json");
    let mut record = json(&path);
    let node = &mut record["named"]["circle"]["location"]["Nodes"]["a2"][0];
    assert!(node.is_u64(), "{node}");
    *node = 99_999.into();
    fs::write(&path, record.to_string()).expect("written");
    for command in ["classify", "measure"] {
        let refused = willis(here.path(), &[command, "run", "-o", "out"]);
        assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
        assert!(stderr(&refused).contains("run.json: arteries"), "{}", stderr(&refused));
        assert!(!here.path().join("out").exists());
    }
}
