//! `willis simulate` as a person runs it: its files, their columns, what it says, and what it refuses.

use std::fs;
use std::path::Path;

use crate::command::{data, folder, stderr, willis};
use crate::refused::{contents, refused};

/// A wide and a narrow way from a to d, of two vessels each; both vessels of the narrow one are called "thin".
const EDGES: &[u8] = b"node_a,node_b,label,length_mm,radius_mm
a,b,L-ICA I,20,2
b,d,wide,20,2
a,c,thin,20,1
c,d,thin,20,1
";
const ENDS: [&str; 4] = ["--inlet", "a", "--outlet", "d"];

/// A run on [`EDGES`] that ends with status 0; what it said.
fn run(here: &Path, extra: &[&str]) -> String {
    fs::write(here.join("a.csv"), EDGES).expect("written");
    let arguments = [&["simulate", "a.csv", "-o", "out", "--force"], &ENDS[..], extra].concat();
    let output = willis(here, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    stderr(&output)
}

/// The header of a table, and the values of a column.
fn table(here: &Path, name: &str) -> (String, impl Fn(&str) -> Vec<String>) {
    let text = fs::read_to_string(here.join("out").join(name)).expect("a table");
    let header = text.lines().next().expect("a header").to_owned();
    let columns: Vec<String> = header.split(',').map(str::to_owned).collect();
    let column = move |name: &str| {
        let at = columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("no column {name}"));
        text.lines().skip(1).map(|line| line.split(',').nth(at).expect("a field").to_owned()).collect()
    };
    (header, column)
}

fn record(here: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(here.join("out/run.json")).expect("a record")).expect("JSON")
}

const FLOW: &str =
    "resistance_mmHg_s_per_mL,drop_mmHg,flow_mL_per_min,velocity_mm_per_s,wall_shear_Pa,reynolds,resilience_W_per_m3,diffused";

#[test]
fn the_tables_have_the_documented_columns() {
    let here = folder();
    run(here.path(), &[]);
    let places = "edge,node_a,node_b,label,length_mm,radius_mm";
    assert_eq!(table(here.path(), "edges.csv").0, format!("{places},{FLOW}"));
    let nodes = "node,id,x_mm,y_mm,z_mm,label,role,pressure_mmHg";
    assert_eq!(table(here.path(), "nodes.csv").0, nodes);
    assert!(record(here.path()).get("rho_G_W_per_m3_perturbed").is_none());

    run(here.path(), &["--occlude", "wide"]);
    let perturbed = FLOW.split(',').map(|name| format!("{name}_perturbed")).collect::<Vec<_>>().join(",");
    assert_eq!(table(here.path(), "edges.csv").0, format!("{places},{FLOW},{perturbed},flow_change"));
    assert_eq!(table(here.path(), "nodes.csv").0, format!("{nodes},pressure_mmHg_perturbed"));
}

/// The wide way carries 2⁴ times the flow of the narrow one, and each vessel drops half of the pressure.
#[test]
fn an_occluded_vessel_keeps_its_row_without_flow() {
    let here = folder();
    let said = run(here.path(), &["--occlude", "wide"]);
    let (_, edges) = table(here.path(), "edges.csv");
    let number = |name: &str, row: usize| edges(name)[row].parse::<f64>().expect("a number");
    assert!((number("drop_mmHg", 1) - 50.0).abs() < 1e-9);
    assert!((number("flow_mL_per_min", 1) / number("flow_mL_per_min", 3) - 16.0).abs() < 1e-9);
    for (name, expected) in [("resistance_mmHg_s_per_mL", "inf"), ("drop_mmHg", "0"), ("flow_mL_per_min", "0")] {
        assert_eq!(edges(&format!("{name}_perturbed"))[1], expected);
    }
    assert_eq!(edges("diffused_perturbed"), ["0", "0", "1", "1"]);
    assert!((number("flow_change", 1) + number("flow_mL_per_min", 1)).abs() < 1e-9);
    // Four vessels before, three after; the thin ones are the same in both.
    let rho: f64 = (0..4).map(|row| number("resilience_W_per_m3", row)).sum();
    let of = record(here.path());
    let figure = |key: &str| of[key].as_f64().expect("a number");
    assert!((figure("rho_G_W_per_m3") / (rho / 4.0) - 1.0).abs() < 1e-9);
    let rho: f64 = (2..4).map(|row| number("resilience_W_per_m3", row)).sum();
    assert!((figure("rho_G_W_per_m3_perturbed") / (rho / 3.0) - 1.0).abs() < 1e-9);
    let inflow = figure("total_inflow_mL_per_min_perturbed");
    assert!((inflow / number("flow_mL_per_min", 3) - 1.0).abs() < 1e-9);
    assert!(said.contains("wide: occluded") && said.contains("Reynolds number above 2,000"), "{said}");
}

#[test]
fn what_an_occlusion_cuts_off_is_said() {
    let here = folder();
    fs::write(here.path().join("a.csv"), EDGES).expect("written");
    let arguments = ["simulate", "a.csv", "-o", "out", "--flow", "a=100", "--outlet", "d", "--occlude", "wide,thin"];
    let output = willis(here.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(said.contains("fixed flow at a has no way on") && said.contains("3 nodes, joined to no pressure"), "{said}");
    assert_eq!(table(here.path(), "nodes.csv").1("pressure_mmHg_perturbed"), ["", "", "0", ""]);
}

#[test]
fn a_vessel_is_named_by_label_or_row_and_a_label_means_all_that_carry_it() {
    let here = folder();
    for (extra, rows) in [
        (&["--occlude", "thin"][..], &[2, 3][..]),
        (&["--occlude", "edge:2,3"], &[2, 3]),
        (&["--stenosis", "L-ICA I=area:75%@mid:10mm,1=30%", "--tortuosity", "thin=1.3"], &[0, 1, 2, 3]),
    ] {
        run(here.path(), extra);
        let of = record(here.path());
        let changed: Vec<u64> =
            of["perturbations"].as_array().expect("a list").iter().map(|p| p["edge"].as_u64().expect("a row")).collect();
        assert_eq!(changed, rows);
    }
    let first = &record(here.path())["perturbations"][0];
    assert_eq!((first["kind"].as_str(), first["open_diameter_share"].as_f64()), (Some("stenosis"), Some(0.5)));
    assert_eq!(first["stretch_mm"].as_f64(), Some(10.0));
    let resistances = table(here.path(), "edges.csv").1;
    let ratio = |row: usize| {
        let of = |name: &str| resistances(name)[row].parse::<f64>().expect("a number");
        of("resistance_mmHg_s_per_mL_perturbed") / of("resistance_mmHg_s_per_mL")
    };
    for (row, expected) in [(0, 8.5), (1, 0.7_f64.powi(-4)), (2, 1.3)] {
        assert!((ratio(row) - expected).abs() < 1e-9, "{row}: {}", ratio(row));
    }
}

#[test]
fn the_same_command_gives_the_same_files_and_prints_run_json() {
    let here = folder();
    let circle = willis(here.path(), &["phantom", "cerebral", "-o", "circle.graphml", "-q"]);
    assert!(circle.status.success());
    let arguments = ["simulate", "circle.graphml", "--stenosis", "L-ICA I=70%", "--occlude", "L-PComm", "--json", "-q", "-o"];
    let mut first = None;
    for (out, threads) in [("one", "1"), ("two", "2")] {
        let output = willis(here.path(), &[&arguments[..], &[out, "--threads", threads]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let files = contents(&here.path().join(out));
        let names: Vec<String> = files.iter().map(|(name, _)| name.display().to_string()).collect();
        assert_eq!(names, ["edges.csv", "flow.png", "flow.svg", "nodes.csv", "report.html", "run.json", "topology.vtp"]);
        assert_eq!(first.get_or_insert_with(|| files.clone()), &files);
        let printed: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(printed["willis"], env!("CARGO_PKG_VERSION"));
        assert_eq!(printed["input"]["sha256"].as_str().map(str::len), Some(64));
        assert_eq!(printed["collaterals"].as_array().map(Vec::len), Some(5));
        assert_eq!(printed["collaterals"][0]["label"], "AComm");
        assert!(printed["reversed"].as_array().is_some_and(|r| r.iter().any(|v| v["label"] == "L-A1")));
        assert_eq!(printed["boundary_conditions"].as_array().map(Vec::len), Some(10));
    }
}

/// Centerlines and masks are simulated as they are, without candidates. Their outlets are terminal resistances that let 700 mL/min pass at the
/// inlet pressure, so that less comes in; at ground it is many times what a brain gets. A ready graph is at ground.
#[test]
fn centerlines_are_taken_without_candidates() {
    let here = folder();
    let inflow = |arguments: &[&str]| -> f64 {
        let output = willis(here.path(), &[arguments, &["-o", "out", "--force"]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let nodes = table(here.path(), "nodes.csv").1;
        let inlets: Vec<String> =
            nodes("node").into_iter().zip(nodes("role")).filter(|(_, role)| role == "inlet").map(|(node, _)| node).collect();
        let edges = table(here.path(), "edges.csv").1;
        let flows = edges("node_a").into_iter().zip(edges("node_b")).zip(edges("flow_mL_per_min"));
        flows
            .map(|((a, b), flow)| {
                let flow: f64 = flow.parse().unwrap_or(0.0);
                f64::from(u8::from(inlets.contains(&a))) * flow - f64::from(u8::from(inlets.contains(&b))) * flow
            })
            .sum()
    };
    for name in ["broken-circle-of-willis.swc", "scan.nii.gz"] {
        let flow = inflow(&["simulate", &data(name)]);
        assert!(flow > 100.0 && flow < 700.0, "{name}: {flow} mL/min");
        assert!(record(here.path())["parameters"]["outlets_found"].is_object(), "{name}");
        let ground = inflow(&["simulate", &data(name), "--outlets", "ground"]);
        assert!(ground > 2000.0, "{name}: {ground} mL/min");
        assert_eq!(record(here.path())["parameters"]["outlets_found"], "ground");
    }
    let vessels = table(here.path(), "edges.csv").1("edge").len();
    assert!(vessels > 10);
    fs::write(here.path().join("line.csv"), "node_a,node_b,length_mm,radius_mm\na,b,20,2\nb,c,20,1\n").expect("written");
    inflow(&["simulate", "line.csv", "--inlet", "a"]);
    assert_eq!(record(here.path())["parameters"]["outlets_found"], "ground");
}

/// A vessel that is named for a stenosis is narrowed over all of its length, and the run says how long that is.
#[test]
fn a_run_says_over_what_length_a_vessel_is_narrowed() {
    let here = folder();
    let said = run(here.path(), &["--stenosis", "wide=70%"]);
    assert!(said.contains("wide: diameter narrowed by 70.0 % over all of its 20.0 mm (@mid:10mm narrows a stretch)"), "{said}");
    let said = run(here.path(), &["--stenosis", "wide=70%", "--tortuosity", "wide=1.5"]);
    assert!(said.contains("over all of its 30.0 mm"), "{said}");
    let said = run(here.path(), &["--stenosis", "wide=70%@mid:10mm"]);
    assert!(said.contains("wide: diameter narrowed by 70.0 % over 10.0 mm") && !said.contains("all of its"), "{said}");
}

/// The tables handed back are the same network under the same conditions.
#[test]
fn an_output_is_an_input_with_the_same_flows() {
    let here = folder();
    assert!(willis(here.path(), &["phantom", "cerebral", "-o", "circle.graphml", "-q"]).status.success());
    assert!(willis(here.path(), &["simulate", "circle.graphml", "-o", "out", "-q"]).status.success());
    let flows = || table(here.path(), "edges.csv").1("flow_mL_per_min");
    let before = flows();
    fs::rename(here.path().join("out"), here.path().join("first")).expect("renamed");
    let again = willis(here.path(), &["simulate", "first/edges.csv", "-o", "out", "-q"]);
    assert!(again.status.success(), "{}", stderr(&again));
    for (a, b) in before.iter().zip(&flows()) {
        let [a, b] = [a, b].map(|x| x.parse::<f64>().expect("a number"));
        assert!((a - b).abs() < 1e-9, "{a} and {b}");
    }
}

#[test]
fn bad_perturbations_are_refused_by_option_value_and_accepted_form() {
    let cases: [(&[&str], &[&str]); 18] = [
        (&["--occlude", "L-ICA 1"], &["--occlude", "\"L-ICA 1\"", "\"L-ICA I\"", "edge:0 to edge:3"]),
        (&["--occlude", "THICK"], &["--occlude", "THICK", "\"thin\""]),
        (&["--occlude", "edge:4"], &["--occlude", "edge:4", "edge:0 to edge:3"]),
        (&["--stenosis", "tin=50%"], &["--stenosis", "tin", "\"thin\""]),
        (&["--stenosis", "wide=100%"], &["--stenosis", "wide=100%", "--occlude"]),
        (&["--stenosis", "wide=area:120%"], &["--stenosis", "area:120%", "--occlude"]),
        (&["--stenosis", "wide=-5%"], &["--stenosis", "-5%", "0%"]),
        (&["--stenosis", "wide=nan%"], &["--stenosis", "nan%", "0%"]),
        (&["--stenosis", "wide=0.5"], &["--stenosis", "wide=0.5", "VESSEL=70%"]),
        (&["--stenosis", "wide"], &["--stenosis", "wide", "VESSEL=70%"]),
        (&["--stenosis", "wide=50%@top:3mm"], &["--stenosis", "top:3mm", "@mid:10mm"]),
        (&["--stenosis", "wide=50%@mid:3mmHg"], &["--stenosis", "3mmHg", "mm"]),
        (&["--stenosis", "wide=50%@mid:0mm"], &["--stenosis", "0mm", "positive length"]),
        (&["--stenosis", "wide=50%@mid:21mm"], &["--stenosis", "21 mm", "wide", "20 mm"]),
        (&["--stenosis", "wide=50%,edge:1=40%"], &["--stenosis", "wide", "twice"]),
        (&["--occlude", "wide", "--occlude", "wide"], &["--occlude", "wide", "twice"]),
        (&["--tortuosity", "wide=0.8"], &["--tortuosity", "wide=0.8", "at least 1"]),
        (&["--tortuosity", "wide=inf"], &["--tortuosity", "wide=inf", "at least 1"]),
    ];
    for (extra, words) in cases {
        let arguments = [&["simulate", "a.csv", "-o", "out"], &ENDS[..], extra].concat();
        refused(&[("a.csv", EDGES)], &arguments, words);
    }
}

#[test]
fn conditions_that_drive_no_flow_are_refused() {
    let simulate = |extra: &[&'static str]| [&["simulate", "a.csv", "-o", "out"], extra].concat();
    let input = [("a.csv", EDGES)];
    let same = simulate(&["--inlet", "a=80mmHg", "--outlet", "d=80mmHg"]);
    refused(&input, &same, &["boundary conditions", "drive no flow", "inlet", "outlet"]);
    refused(
        &input,
        &simulate(&["--inlet", "a", "--outlet", "d", "--outlet", "d=5mmHg"]),
        &["--outlet", "d=5mmHg", "one condition"],
    );
    refused(&input, &simulate(&["--inlet", "a", "--outlet", "d", "--viscosity", "0"]), &["--viscosity", "0", "positive"]);
    for command in ["simulate", "modulate"] {
        refused(&input, &[command, "a.csv", "-o", "out", "--observed"], &["--observed", command]);
    }
    refused(&input, &simulate(&["--dpi", "7"]), &["--dpi", "7"]);
    // Two parts, the inlet in one and the outlet in the other.
    let apart = b"node_a,node_b,length_mm,radius_mm\na,b,20,2\nc,d,20,2\n";
    for command in ["simulate", "modulate"] {
        let arguments = [command, "a.csv", "-o", "out", "--inlet", "a", "--outlet", "d"];
        refused(&[("a.csv", apart)], &arguments, &["drive no flow", "one connected part"]);
    }
}

/// 90 mmHg over 30 and 60 mmHg·s/mL in series drive 1 mL/s, whatever Poiseuille's law would say of the sizes.
#[test]
fn a_stated_resistance_stands_in_the_place_of_poiseuilles_law() {
    let here = folder();
    let csv = "node_a,node_b,length_mm,radius_mm,resistance_mmHg_s_per_mL\na,b,10,1,30\nb,c,99,0.2,60\n";
    let graphml = "<graphml>\
        <key id=\"l\" for=\"edge\" attr.name=\"length_mm\" attr.type=\"double\"/>\
        <key id=\"r\" for=\"edge\" attr.name=\"radius_mm\" attr.type=\"double\"/>\
        <key id=\"z\" for=\"edge\" attr.name=\"resistance_mmHg_s_per_mL\" attr.type=\"double\"/>\
        <graph><node id=\"a\"/><node id=\"b\"/><node id=\"c\"/>\
        <edge source=\"a\" target=\"b\"><data key=\"l\">10</data><data key=\"r\">1</data><data key=\"z\">30</data></edge>\
        <edge source=\"b\" target=\"c\"><data key=\"l\">99</data><data key=\"r\">0.2</data><data key=\"z\">60</data></edge>\
        </graph></graphml>";
    for (name, content) in [("g.csv", csv), ("g.graphml", graphml)] {
        std::fs::write(here.path().join(name), content).expect("written");
        let arguments = ["simulate", name, "-o", "out", "--force", "-q", "--inlet", "a=90mmHg", "--outlet", "c=ground"];
        let output = willis(here.path(), &arguments);
        assert!(output.status.success(), "{name}: {}", stderr(&output));
        let mut edges = csv::Reader::from_path(here.path().join("out/edges.csv")).expect("edges.csv");
        let column = edges.headers().expect("a header").iter().position(|h| h == "flow_mL_per_min").expect("flows");
        let flows: Vec<f64> = edges.records().map(|r| r.expect("a row")[column].parse().expect("a flow")).collect();
        assert!(flows.len() == 2 && flows.iter().all(|q| (q - 60.0).abs() < 1e-9), "{name}: {flows:?}");
    }
    let broken = csv.replace(",30\n", ",-30\n");
    refused(
        &[("g.csv", broken.as_bytes())],
        &["simulate", "g.csv", "-o", "out"],
        &["g.csv:2", "resistance_mmHg_s_per_mL -30", "positive"],
    );
}

/// A part that no inlet feeds stays without flow, or goes: what flows in the rest is the same to the last digit.
#[test]
fn vessels_that_no_inlet_feeds_stay_or_go() {
    let here = folder();
    let run = |extra: &[&str]| {
        fs::write(
            here.path().join("a.csv"),
            [b"node_a,node_b,label,length_mm,radius_mm\nx,y,far,9,1\n".as_slice(), &EDGES[40..]].concat(),
        )
        .expect("written");
        let output = willis(here.path(), &[&["simulate", "a.csv", "-o", "out", "--force"], &ENDS[..], extra].concat());
        (output.status.code(), stderr(&output))
    };
    let flows = || table(here.path(), "edges.csv").1("flow_mL_per_min");
    assert_eq!(run(&["--occlude", "edge:1"]).0, Some(0));
    let (kept, diffused) = (flows(), table(here.path(), "edges.csv").1("diffused"));
    assert_eq!((kept.len(), diffused[0].as_str()), (5, "0"));
    let (status, said) = run(&["--occlude", "edge:1", "--unfed", "drop"]);
    assert!(status == Some(0) && said.contains("1 vessel that no inlet feeds, left out"), "{said}");
    assert_eq!(flows(), kept[1..]);
    assert_eq!(table(here.path(), "edges.csv").1("label")[0], "L-ICA I");
    let record = record(here.path());
    assert!(record["notes"].as_array().expect("notes").iter().any(|note| note.as_str().expect("a text").contains("left out")));
    let (status, said) = run(&["--occlude", "far", "--unfed", "drop"]);
    assert!(
        status == Some(2) && said.contains("--occlude \"far\": no blood comes there, and --unfed drop left it out"),
        "{said}"
    );
    fs::remove_dir_all(here.path().join("out")).expect("removed");
    let modulate = |extra: &[&str]| {
        let given = ["modulate", "a.csv", "-o", "out", "-n", "8", "--vessels", "edge:0,wide", "--save-samples", "--force", "-q"];
        let output = willis(here.path(), &[&given, &ENDS[..], extra].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        table(here.path(), "edges.csv").1("edge").len()
    };
    let all = modulate(&[]);
    assert_eq!(modulate(&["--unfed", "drop"]), all / 5 * 4);
}

/// The vessels of a topology that go on without a junction are one; of the table beside it each part is a row. Both flow alike.
#[test]
fn a_topology_flows_as_the_table_of_its_run_does() {
    let here = folder();
    let infer = willis(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "run", "-q"]);
    assert!(infer.status.success(), "{}", stderr(&infer));
    let mut found = Vec::new();
    for input in ["run", "run/edges.csv"] {
        let output = willis(here.path(), &["simulate", input, "-o", "out", "-q", "--force"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let (_, nodes) = table(here.path(), "nodes.csv");
        let numbers = nodes("pressure_mmHg").into_iter().map(|pressure| pressure.parse::<f64>().unwrap_or(f64::NAN));
        let by_id: std::collections::BTreeMap<String, f64> = nodes("id").into_iter().zip(numbers).collect();
        found.push((by_id, record(here.path())["total_inflow_mL_per_min"].as_f64().expect("a flow")));
    }
    let [(merged, inflow), (parts, of_parts)] = &found[..] else { panic!("two runs") };
    assert!((inflow / of_parts - 1.0).abs() < 1e-9, "{inflow} {of_parts}");
    assert!(merged.len() < parts.len());
    for (id, pressure) in merged {
        let expected = parts[id];
        let same = pressure.is_nan() && expected.is_nan() || (pressure - expected).abs() < 1e-9 * expected.abs();
        assert!(same, "{id}: {pressure} {expected}");
    }
}

/// By hand: the wide way has 16 times the conductance of the thin one, and the pressures at the ends are fixed.
#[test]
fn each_vessel_is_closed_in_turn() {
    let here = folder();
    let said = run(here.path(), &["--occlude-each"]);
    assert!(
        said.contains(
            "occluded  each vessel in turn; most is lost without vessel 0 (a - b) \"L-ICA I\": 94.1 % of the outlets' flow"
        ),
        "{said}"
    );
    let (_, column) = table(here.path(), "occlusions.csv");
    let number = |name: &str| column(name).iter().map(|x| x.parse().unwrap_or(f64::NAN)).collect::<Vec<f64>>();
    for (row, lost) in [16.0 / 17.0, 16.0 / 17.0, 1.0 / 17.0, 1.0 / 17.0].into_iter().enumerate() {
        assert!((number("lost_share")[row] - lost).abs() < 1e-9, "{row}");
        assert!((number("worst_outlet_share_left")[row] - (1.0 - lost)).abs() < 1e-9, "{row}");
    }
    assert_eq!(column("worst_outlet"), ["d"; 4]);
    assert_eq!((column("outlets_unfed"), column("reversed")), (vec!["0".to_owned(); 4], vec!["0".to_owned(); 4]));
    // No bifurcation has three ends here.
    assert_eq!(record(here.path())["murray"]["exponent_median"], serde_json::Value::Null);
}

/// Nothing flows in a branch that leads nowhere, and nothing is lost without it; a table says 0, not -0.
#[test]
fn closing_what_carries_nothing_loses_nothing() {
    let here = folder();
    let edges = "node_a,node_b,length_mm,radius_mm\na,b,10,1\nb,c,10,1\nb,d,10,1\n";
    std::fs::write(here.path().join("branch.csv"), edges).expect("written");
    let options = ["simulate", "branch.csv", "--inlet", "a", "--outlet", "c", "--occlude-each", "-o", "out"];
    let output = willis(here.path(), &options);
    assert!(output.status.success(), "{}", stderr(&output));
    let (_, column) = table(here.path(), "occlusions.csv");
    assert_eq!((&*column("lost_mL_per_min")[2], &*column("lost_share")[2]), ("0", "0"));
}

/// The phantom of a tree is made by Murray's law, with an exponent of 3 at each bifurcation, and that of the outlets found is 3 by definition.
#[test]
fn the_exponent_of_murray_is_told_beside_that_of_the_outlets() {
    let here = folder();
    assert!(willis(here.path(), &["phantom", "tree", "-o", "tree.swc", "-q"]).status.success());
    for (outlets, truth) in [("murray=700", serde_json::json!(3)), ("ground", serde_json::Value::Null)] {
        let output = willis(here.path(), &["simulate", "tree.swc", "-o", "out", "--outlets", outlets, "--dpi", "36", "--force"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let murray = &record(here.path())["murray"];
        let median = murray["exponent_median"].as_f64().expect("an exponent");
        assert!((median - 3.0).abs() < 0.05, "{murray}");
        assert_eq!(murray["exponent_of_outlets"], truth);
    }
}

/// Kirchhoff's law by NumPy for every vessel of a circle that is closed; its outlets are terminal resistances.
const BY_NUMPY: &str = "
import json, sys, numpy as np, pandas as pd
edges, nodes, found = (pd.read_csv(f'out/{name}.csv', dtype={'id': str}) for name in ('edges', 'nodes', 'occlusions'))
fixed, outlets = ((nodes.role == role).to_numpy() for role in ('inlet', 'outlet'))
level = np.where(fixed, nodes.pressure_mmHg, 0.0)
terminal = np.where(outlets, 60 / nodes.resistance_mmHg_s_per_mL, 0.0)
def state(open_):
    c = np.where(open_, 60 / edges.resistance_mmHg_s_per_mL, 0)
    L = np.diag(terminal)
    for a, b, x in zip(edges.node_a, edges.node_b, c):
        L[[a, b], [a, b]] += x; L[[a, b], [b, a]] -= x
    p = level.copy()
    free = ~fixed
    p[free] = np.linalg.lstsq(L[np.ix_(free, free)], -L[np.ix_(free, fixed)] @ level[fixed], rcond=None)[0]
    return c * (p[edges.node_a] - p[edges.node_b]), terminal * p
flow, out = state(np.ones(len(edges), bool))
for row in range(len(edges)):
    q, now = state(np.arange(len(edges)) != row)
    b, a = out[outlets], now[outlets]
    lost = np.maximum(b - a, 0).sum()
    one = found.iloc[row]
    assert abs(one.lost_mL_per_min - lost) < 1e-6 * b.sum(), (row, one, lost)
    assert abs(one.lost_share - lost / b.sum()) < 1e-6
    assert one.outlets_unfed == (a < 1e-6 * b).sum(), row
    if lost > 1e-6 * b.sum():
        assert abs(one.worst_outlet_share_left - (a / b).min()) < 1e-6, row
    gain = np.delete(np.abs(q) - np.abs(flow), row).max()
    assert abs(one.gain_mL_per_min - max(gain, 0)) < 1e-6 * b.sum(), (row, one.gain_mL_per_min, gain)
assert found.lost_share.max() > .2 and found.outlets_unfed.max() >= 1
assert json.load(open('out/run.json'))['murray']['bifurcations'] == 10
";

#[test]
fn closed_vessels_of_a_circle_are_as_numpy_solves_them() {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        println!("skipped: WILLIS_PYTHON names no Python with NumPy");
        return;
    };
    let here = folder();
    let done = willis(here.path(), &["simulate", &data("circle-of-willis/complete.graphml"), "-o", "out", "--occlude-each"]);
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    let checked = std::process::Command::new(python).current_dir(here.path()).args(["-c", BY_NUMPY]).output().expect("runs");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
}

/// 0.01 mL/min of 38,145 are less than a hundredth of a percent of what leaves at d.
#[test]
fn an_inlet_that_feeds_hardly_anything_is_said_to() {
    let here = folder();
    let said = run(here.path(), &["--flow", "c=0.01", "--transport"]);
    assert!(said.contains("feeds  c: less than 0.5 % of the blood of any outlet\n"), "{said}");
}

/// Counted by hand: three observed vessels, one candidate, one contact.
#[test]
fn what_is_read_is_counted_by_its_origin() {
    let here = folder();
    let edges = "node_a,node_b,length_mm,radius_mm,origin,probability\na,b,20,1,observed,\nb,c,20,1,observed,\nb,d,10,1,candidate,0.5\n\
                 c,e,20,1,contact,0.5\ne,d,10,1,observed,\n";
    fs::write(here.path().join("graph.csv"), edges).expect("written");
    let said = stderr(&willis(here.path(), &["infer", "graph.csv", "-o", "out", "--inlet", "a"]));
    assert!(said.contains("5 nodes, 3 observed and 1 candidate vessels, 1 contact, radius"), "{said}");
}

#[test]
fn counts_of_inlets_and_outlets_have_commas() {
    let here = folder();
    let ends = (0..1100).map(|end| format!("h,e{end},10,0.3\n")).collect::<Vec<_>>().concat();
    fs::write(here.path().join("star.csv"), format!("node_a,node_b,length_mm,radius_mm\na,h,20,3\n{ends}")).expect("written");
    let said = stderr(&willis(here.path(), &["simulate", "star.csv", "-o", "out", "--inlet", "a"]));
    assert!(
        said.contains("1,100 nodes, found: the other free ends: ") && said.contains("e5 (ground) and 1,094 more\n"),
        "{said}"
    );
}
