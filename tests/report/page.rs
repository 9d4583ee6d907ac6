//! report.html as a file: its data are those of the tables, labels stay text, nothing is asked of the network, its size.

use std::fs;
use std::path::Path;

use crate::command::{data, folder, stderr, willis};
use crate::grown::grown;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use willis::internals::report::figures::CoursePoint;
use willis::internals::report::page::lead::{Part, modulation, simulation};
use willis::internals::report::page::scene::thinned;

const LABELS: [&str; 7] =
    ["<script>alert(1)</script>", "\"&'", "</script>", "a\u{2028}b\u{2029}c", "A. cerebri média 中 🧠", "{{scripts}}", "<!--"];

fn run(here: &Path, arguments: &[&str]) {
    let output = willis(here, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
}

fn page(here: &Path, out: &str) -> String {
    fs::read_to_string(here.join(out).join("report.html")).expect("a page")
}

/// The data of a page, cut out as a browser does: up to the first end of a script.
fn content(page: &str) -> Value {
    let (_, rest) = page.split_once("<script type=\"application/json\" id=\"data\">").expect("a block of data");
    let (json, _) = rest.split_once("</script").expect("its end");
    serde_json::from_str(json).expect("JSON")
}

fn column<'a>(table: &'a Value, name: &str) -> &'a Value {
    table["columns"].as_array().expect("columns").iter().find(|c| c["name"] == name).unwrap_or(&Value::Null)
}

/// A column of numbers by its kind.
fn numbers(column: &Value, rows: usize) -> Vec<f64> {
    let kind = column["kind"].as_str().expect("a kind");
    if kind == "row" {
        return (0..rows).map(|row| row as f64).collect();
    }
    let bytes = STANDARD.decode(column["data"].as_str().expect("data")).expect("base64");
    let width = kind[1..].parse::<usize>().expect("bits") / 8;
    let one = |b: &[u8]| match kind {
        "f64" => f64::from_le_bytes(b.try_into().expect("8")),
        "f32" => f64::from(f32::from_le_bytes(b.try_into().expect("4"))),
        _ => b.iter().rev().fold(0.0, |sum, byte| 256.0 * sum + f64::from(*byte)),
    };
    bytes.chunks_exact(width).map(one).collect()
}

fn words(column: &Value, rows: usize) -> Vec<String> {
    numbers(&column["rows"], rows).into_iter().map(|at| column["words"][at as usize].as_str().expect("text").to_owned()).collect()
}

/// The columns of a CSV file by name.
fn csv(path: &Path) -> impl Fn(&str) -> Vec<String> + use<> {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let names = reader.headers().expect("names").clone();
    let rows: Vec<_> = reader.records().map(|r| r.expect("a row")).collect();
    move |name: &str| {
        let at = names.iter().position(|n| n == name).expect("a column");
        rows.iter().map(|r| r[at].to_owned()).collect()
    }
}

fn reals(texts: &[String]) -> Vec<f64> {
    texts.iter().map(|t| t.parse().expect("a number")).collect()
}

/// A page holds two scripts of its own, and fetches nothing: every address in it is within it.
fn is_closed(page: &str) {
    assert_eq!((page.matches("<script").count(), page.matches("</script").count()), (2, 2));
    assert!(page.contains("default-src 'none'"));
    let without_names = page.replace("http://www.w3.org/2000/svg", "");
    for word in
        ["http://", "https://", "fetch(", "XMLHttpRequest", "WebSocket", "import(", "@import", "<link", "<iframe", "innerHTML"]
    {
        assert!(!without_names.contains(word), "{word}");
    }
    for opening in ["src=\"", "href=\"", "url("] {
        for (at, _) in page.match_indices(opening) {
            let address = &page[at + opening.len()..];
            assert!(address.starts_with('#') || address.starts_with("data:"), "{opening}{}", &address[..30.min(address.len())]);
        }
    }
}

#[test]
fn labels_are_text_whatever_they_say() {
    let here = folder();
    let long = "x".repeat(3_000);
    let labels: Vec<&str> = LABELS.iter().copied().chain([long.as_str()]).collect();
    let (nodes, edges) = grown(30, &labels);
    fs::write(here.path().join("nodes.csv"), nodes).expect("written");
    fs::write(here.path().join("<b>&\"x.csv"), edges).expect("written");
    run(here.path(), &["infer", "<b>&\"x.csv", "-o", "infer", "-n", "64", "-q"]);
    run(here.path(), &["simulate", "<b>&\"x.csv", "-o", "simulate", "--occlude", "</script>", "-q"]);
    run(here.path(), &["modulate", "<b>&\"x.csv", "-o", "modulate", "-n", "8", "--vessels", "<script>alert(1)</script>", "-q"]);
    for command in ["infer", "simulate", "modulate"] {
        let html = page(here.path(), command);
        is_closed(&html);
        assert!(html.contains(&format!("<title>willis {command}: &lt;b&gt;&amp;&quot;x.csv</title>")), "{command}");
        let content = content(&html);
        let table = &content["tables"][0];
        let found = words(column(table, "label"), 30);
        assert_eq!(found[..labels.len()], labels, "{command}");
        assert!(found[labels.len()..].iter().all(String::is_empty));
    }
    let record = content(&page(here.path(), "simulate"))["record"].clone();
    assert_eq!(record["command"], "willis simulate '<b>&\"x.csv' --occlude '</script>' -o again");
}

/// Columns, threshold and record against the other files of the folder; coordinates against the input, to a step of their grid.
#[test]
fn the_data_are_those_of_the_folder() {
    let here = folder();
    let (nodes, edges) = grown(300, &[]);
    fs::write(here.path().join("nodes.csv"), nodes).expect("written");
    fs::write(here.path().join("edges.csv"), edges).expect("written");
    run(here.path(), &["infer", "edges.csv", "-o", "out", "-n", "200", "-q"]);
    let html = page(here.path(), "out");
    is_closed(&html);
    let content = content(&html);
    let (table, edges) = (&content["tables"][0], csv(&here.path().join("out/edges.csv")));
    for name in ["likelihood", "std_error", "frequency", "kept", "above_median", "node_a", "node_b", "edge"] {
        let found: Vec<u64> = numbers(column(table, name), 300).into_iter().map(f64::to_bits).collect();
        assert_eq!(found, reals(&edges(name)).into_iter().map(f64::to_bits).collect::<Vec<_>>(), "{name}");
    }
    for name in ["length_mm", "radius_mm"] {
        let pairs = numbers(column(table, name), 300).into_iter().zip(reals(&edges(name)));
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-7 * b), "{name}");
    }
    let candidate: Vec<f64> = edges("origin").iter().map(|o| f64::from(u8::from(o == "candidate"))).collect();
    assert_eq!(numbers(column(table, "uncertain"), 300), candidate);

    let mut record: Value = serde_json::from_slice(&fs::read(here.path().join("out/run.json")).expect("a record")).expect("JSON");
    assert_eq!(content["threshold"]["cut"], record["threshold"]["value"]);
    assert_eq!(content["threshold"]["median"], record["threshold"]["median"]);
    let fields = record.as_object_mut().expect("an object");
    let listed = fields.remove("boundary_conditions").expect("conditions");
    fields.remove("time");
    fields["convergence"].as_object_mut().expect("an object").remove("undecided_edges");
    let mut shown = content["record"].clone();
    assert_eq!(shown.as_object_mut().expect("an object").remove("boundary_conditions"), Some(Value::Null));
    assert_eq!(shown, record);
    let conditions = content["tables"].as_array().expect("tables").last().expect("one");
    assert_eq!(conditions["rows"].as_u64(), listed.as_array().map(|l| l.len() as u64));

    let scene = &content["scene"];
    let bytes = STANDARD.decode(scene["points"].as_str().expect("points")).expect("base64");
    let whole: Vec<f64> = bytes.chunks_exact(2).map(|b| f64::from(u16::from_le_bytes([b[0], b[1]]))).collect();
    let counts = numbers(&scene["counts"], 300);
    assert!(counts.iter().all(|n| *n == 2.0));
    let (step, radius_step) = (scene["steps"][0].as_f64().expect("mm"), scene["steps"][1].as_f64().expect("mm"));
    for (axis, names) in [["ax_mm", "bx_mm"], ["ay_mm", "by_mm"], ["az_mm", "bz_mm"]].into_iter().enumerate() {
        let corner = scene["corner"][axis].as_f64().expect("mm");
        for (end, name) in names.into_iter().enumerate() {
            for (row, truth) in reals(&edges(name)).into_iter().enumerate() {
                let found = corner + step * whole[8 * row + 4 * end + axis];
                assert!((found - truth).abs() <= 0.51 * step, "{name} of {row}: {found} for {truth}");
            }
        }
    }
    for (row, truth) in reals(&edges("radius_mm")).into_iter().enumerate() {
        assert!((radius_step * whole[8 * row + 3] - truth).abs() <= 0.51 * radius_step);
    }
}

#[test]
fn a_graph_without_coordinates_has_a_page_that_says_so() {
    let here = folder();
    let edges = "node_a,node_b,length_mm,radius_mm,origin\na,b,10,1,observed\nb,c,10,1,candidate\nb,d,10,0.5,candidate\n";
    fs::write(here.path().join("edges.csv"), edges).expect("written");
    run(here.path(), &["infer", "edges.csv", "-o", "out", "--inlet", "a", "--outlet", "c", "--outlet", "d", "-q"]);
    let content = content(&page(here.path(), "out"));
    assert!(content["scene"].is_null() && content["no_scene"].as_str().is_some_and(|why| why.contains("no coordinates")));
    assert_eq!(content["tables"][0]["rows"], 3);
}

#[test]
fn a_page_of_every_pattern_has_no_samples() {
    let here = folder();
    let edges = "node_a,node_b,length_mm,radius_mm,origin\na,b,10,1,observed\nb,c,10,1,candidate\nb,d,10,0.5,candidate\n";
    fs::write(here.path().join("edges.csv"), edges).expect("written");
    for (out, more) in [("sampled", None), ("counted", Some("--exact"))] {
        let run_with = ["infer", "edges.csv", "-o", out, "--inlet", "a", "--outlet", "c", "--outlet", "d", "-q"];
        run(here.path(), &run_with.into_iter().chain(more).collect::<Vec<_>>());
        let content = content(&page(here.path(), out));
        let facts = content["facts"].as_array().expect("facts");
        assert_eq!(facts.iter().any(|fact| fact[0] == "samples"), more.is_none(), "{facts:?}");
        let says = content["figures"][1]["caption"].as_str().expect("a caption");
        assert_eq!(says.contains("more samples"), more.is_none(), "{says}");
        let picture = fs::read_to_string(here.path().join(out).join("convergence.svg")).expect("a picture");
        assert_eq!(picture.contains("Every pattern was counted"), more.is_some());
    }
}

#[test]
fn several_occlusion_probabilities_have_a_page_each() {
    let here = folder();
    run(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "out", "--epsilon", "0.2,0.5", "-n", "64", "-q"]);
    for epsilon in [0.2, 0.5] {
        let content = content(&page(here.path(), &format!("out/epsilon-{epsilon}")));
        assert_eq!(content["record"]["parameters"]["epsilon"], epsilon);
    }
}

/// Each class of a modulation is a table of its vessels, with the figures of edges.csv.
#[test]
fn a_modulation_has_a_table_of_vessels_for_each_class() {
    let here = folder();
    let circle = data("circle-of-willis/complete.graphml");
    run(here.path(), &["modulate", &circle, "-o", "out", "-n", "20", "-q"]);
    let content = content(&page(here.path(), "out"));
    let edges = csv(&here.path().join("out/edges.csv"));
    let (classes, quantities, rows) = (edges("class"), edges("quantity"), edges("edge"));
    for (at, class) in ["0:0.2", "0.2:0.3", "0.3:0.5"].into_iter().enumerate() {
        let table = &content["tables"][at];
        assert!(table["title"].as_str().is_some_and(|title| title.ends_with(class)));
        let vessels = table["rows"].as_u64().expect("rows") as usize;
        for quantity in ["flow_mL_per_min", "drop_mmHg", "resilience_W_per_m3", "hypertension_mmHg_per_mm2"] {
            for figure in ["mean", "std", "unperturbed"] {
                let found = numbers(column(table, &format!("{quantity}_{figure}")), vessels);
                let of_file = reals(&edges(figure));
                let mut compared = 0;
                for row in (0..rows.len()).filter(|row| classes[*row] == class && quantities[*row] == quantity) {
                    let (here, there) = (found[rows[row].parse::<usize>().expect("a row")], of_file[row]);
                    assert!((here - there).abs() <= 1e-7 * there.abs(), "{class} {quantity} {figure} {}", rows[row]);
                    compared += 1;
                }
                assert_eq!(compared, vessels);
            }
        }
    }
    assert_eq!(content["figures"].as_array().map(Vec::len), Some(2));
}

/// The page of a classification is closed, and has the phenotype of phenotype.json; so has the page of a run with landmarks.
#[test]
fn a_circle_is_drawn_from_its_phenotype() {
    let here = folder();
    run(here.path(), &["phantom", "cerebral", "--break", "--seed", "1", "-o", "scan.swc", "-q"]);
    run(here.path(), &["infer", "scan.swc", "--landmarks", "scan.landmarks.csv", "-o", "run", "-n", "64", "-q"]);
    run(here.path(), &["classify", "run", "-o", "classified", "-q"]);
    run(here.path(), &["classify", &data("circle-of-willis/without-L-A1.graphml"), "-o", "as-it-stands", "-q"]);
    for out in ["run", "classified", "as-it-stands"] {
        let html = page(here.path(), out);
        is_closed(&html);
        let told: Value =
            serde_json::from_slice(&fs::read(here.path().join(out).join("phenotype.json")).expect("told")).expect("JSON");
        assert_eq!(content(&html)["phenotype"], told, "{out}");
        assert!(html.contains("<section id=\"circle\""), "{out}");
    }
    let content = content(&page(here.path(), "classified"));
    // How topologies were drawn is no warning.
    assert!(content["record"]["notes"].to_string().contains("plausible topologies"), "{}", content["record"]["notes"]);
    assert!(!content["warnings"].to_string().contains("plausible topologies"), "{}", content["warnings"]);
    let rows = csv(&here.path().join("classified/collateral.csv"))("artery").len();
    assert_eq!(content["collaterals"]["rows"], rows);
}

/// The largest picture a page is made for: 20,000 vessels stay sendable by mail.
#[test]
fn a_page_of_twenty_thousand_vessels_is_below_four_megabytes() {
    let here = folder();
    let (nodes, edges) = grown(20_000, &[]);
    fs::write(here.path().join("nodes.csv"), nodes).expect("written");
    fs::write(here.path().join("edges.csv"), edges).expect("written");
    run(here.path(), &["infer", "edges.csv", "-o", "out", "-n", "64", "-q"]);
    let html = page(here.path(), "out");
    assert!(html.len() < 4_000_000, "{} bytes", html.len());
    assert_eq!(content(&html)["tables"][0]["rows"], 20_000);
}

/// By hand: on a straight line of even taper nothing but the ends stays; a corner and a bulge do.
#[test]
fn what_is_left_out_lies_on_the_line() {
    let straight: Vec<CoursePoint> = (0..9).map(|i| [f64::from(i), 0.0, 0.0, 9.0 - f64::from(i)]).collect();
    assert_eq!(thinned(&straight, 0.01), [straight[0], straight[8]]);
    let corner = [[0.0; 4], [1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0], [2.0, 1.0, 0.0, 0.0]];
    assert_eq!(thinned(&corner, 0.01), [corner[0], corner[2], corner[3]]);
    let bulge = [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 3.0], [2.0, 0.0, 0.0, 1.0]];
    assert_eq!(thinned(&bulge, 0.01), bulge);
    assert_eq!(thinned(&bulge, 5.0).len(), 2);
}

fn read(parts: &[Part]) -> String {
    parts.iter().map(|(text, _)| text.as_str()).collect()
}

/// 600 -> 540 is a tenth less; 1000 -> 1000.1 is a hundredth of a percent.
#[test]
fn a_page_begins_with_what_came_of_the_run() {
    let plain = json!({ "total_inflow_mL_per_min": 641.638, "counts": { "diffused": 51, "vessels": 52 } });
    assert_eq!(read(&simulation(&plain)), "642 mL/min flow in; blood flows in 51 of 52 vessels.");
    let of = |reversed: Value| {
        json!({
            "total_inflow_mL_per_min": 600.0,
            "total_inflow_mL_per_min_perturbed": 540.0,
            "perturbations": [{ "edge": 4, "label": "BA", "kind": "stenosis" }],
            "collaterals": [{ "edge": 15, "label": "", "gain_mL_per_min": 28.53 }],
            "reversed": reversed,
        })
    };
    assert_eq!(
        read(&simulation(&of(json!([])))),
        "Stenosis of BA: inflow 600 \u{2192} 540 mL/min (\u{2212}10.0 %); no flow is reversed; edge 15 gains most, 28.5 mL/min."
    );
    assert!(read(&simulation(&of(json!([{ "edge": 7, "label": "" }])))).contains("the flow of edge 7 is reversed"));
    let class = |inflow: f64| json!({ "class": "0.3:0.5", "total_inflow_mL_per_min": inflow, "rho_G_W_per_m3": 2.0, "share_above_threshold": 0.041 });
    let record = json!({ "unperturbed": class(1000.0), "classes": [class(1.0), class(1000.1)] });
    assert_eq!(
        read(&modulation(&record)),
        "Of each vessel a number u is drawn: every resistance R becomes R (1 + u). With u in 0.3\u{2013}0.5 inflow goes from 1000 to 1000 mL/min (by less than 0.05 %), resilience from 2.00 to 2.00 W/m\u{b3} \
         (by less than 0.05 %); 4.1 % of the vessels are above the threshold of hypertension, before 4.1 %."
    );
    assert!(simulation(&json!({})).is_empty() && modulation(&json!({})).is_empty());
    // The strongest modulation, wherever it stands.
    let rest = json!({ "total_inflow_mL_per_min": 1000.0 });
    let strong = json!({ "class": "0.3:0.5", "total_inflow_mL_per_min": 700.0 });
    let weak = json!({ "class": "0:0.2", "total_inflow_mL_per_min": 900.0 });
    for classes in [[&weak, &strong], [&strong, &weak]] {
        let said = read(&modulation(&json!({ "unperturbed": rest, "classes": classes })));
        assert!(said.contains("With u in 0.3\u{2013}0.5 inflow goes from 1000 to 700 mL/min"), "{said}");
    }
    // Three digits once rounded, and as what is printed has them.
    for (inflow, said) in [(0.9999, "1.00"), (99.96, "100"), (123_456.0, "1.23e5"), (-0.5, "\u{2212}0.500"), (0.0, "0")] {
        let plain = json!({ "total_inflow_mL_per_min": inflow, "counts": { "diffused": 1, "vessels": 1 } });
        assert_eq!(read(&simulation(&plain)), format!("{said} mL/min flow in; blood flows in 1 of 1 vessel."));
    }
}

/// Two parts of 30 and 25 mm that no blood reaches, with one candidate between them, of 10 mm along and 4 mm across: each is asked about in a row of its own. Where it is kept they
/// are one part, as long as both and the gap.
#[test]
fn every_part_that_nothing_connects_is_asked_about_once() {
    let here = folder();
    let points = "1 0 0 0 0 2 -1\n2 0 60 0 0 2 1\n3 0 150 0 0 1 -1\n4 0 120 0 0 1 3\n5 0 110 4 0 1 -1\n6 0 110 29 0 1 5\n";
    fs::write(here.path().join("parts.swc"), points).expect("written");
    let whole = 55.0 + 116.0_f64.sqrt();
    for (out, keep, parts) in [("apart", "probability=0.999", vec![30.0, 25.0]), ("joined", "probability=0.001", vec![whole])] {
        run(here.path(), &["infer", "parts.swc", "-o", out, "--inlet", "1", "--keep", keep, "-q"]);
        let asked = csv(&here.path().join(out).join("review.csv"));
        let (rows, kinds) = (asked("edge"), asked("kind"));
        let of_parts: Vec<usize> = (0..rows.len()).filter(|at| kinds[*at] == "part").collect();
        assert_eq!(rows.iter().collect::<std::collections::BTreeSet<_>>().len(), rows.len(), "{rows:?}");
        let (long, content) = (reals(&asked("hangs_mm")), content(&page(here.path(), out)));
        let of_page = |name| numbers(column(&content["tables"][0], name), 4);
        let (loose, rank) = (of_page("loose_mm"), of_page("rank"));
        assert_eq!(of_parts.len(), parts.len(), "{kinds:?}");
        for (at, length) in of_parts.into_iter().zip(parts) {
            let row: usize = rows[at].parse().expect("a row");
            assert!((long[at] - length).abs() < 1e-9 && (loose[row] - length).abs() < 1e-5, "{} for {length}", long[at]);
            assert_eq!(rank[row] as usize, at + 1);
        }
    }
}

/// Up is known, and blood comes in from below, though the upper end is wider.
#[test]
fn a_page_says_of_an_inlet_that_was_found_what_is_known() {
    let here = folder();
    let point =
        |at: i32| format!("{} 0 0 0.13 {} {} {}\n", at + 1, 2 * at, 1.2 + 0.03 * f64::from(at), if at == 0 { -1 } else { at });
    fs::write(here.path().join("up.swc"), (0..31).map(point).collect::<String>()).expect("written");
    run(here.path(), &["infer", "up.swc", "--frame", "RAS", "-o", "out", "-q"]);
    let nodes = csv(&here.path().join("out/nodes.csv"));
    let (roles, radii) = (nodes("role"), reals(&nodes("radius_mm")));
    let inlet = roles.iter().position(|role| role == "inlet").expect("one");
    assert!(radii.iter().any(|radius| *radius > radii[inlet]), "{radii:?}");
    let said = "Nobody stated where blood enters: one free end is assumed to be the inlet. The option inlet states it.";
    assert_eq!(content(&page(here.path(), "out"))["warnings"][0], said);
}

/// The letter of an axis stands where its coordinate rises; the patient's left is on the right, along whichever axis names say it is.
#[test]
fn the_picture_of_a_run_without_a_frame_has_the_sides_of_its_names() {
    let here = folder();
    for (out, left, right) in [("low", "-10", "10"), ("high", "10", "-10")] {
        let nodes = format!("id,x_mm,y_mm,z_mm\na,0,{left},0\nb,1,{left},40\nc,0.5,{right},0\nd,-1,{right},40\n");
        let edges = "node_a,node_b,label,length_mm,radius_mm,origin\na,b,L-ICA,40,2,observed\nc,d,R-ICA,40,2,observed\n";
        fs::write(here.path().join("nodes.csv"), nodes).expect("written");
        fs::write(here.path().join("edges.csv"), edges).expect("written");
        run(here.path(), &["infer", "edges.csv", "-o", out, "--inlet", "a", "--inlet", "c", "-n", "8", "-q"]);
        let picture = fs::read_to_string(here.path().join(out).join("summary.svg")).expect("a picture");
        let across = |letter: &str| {
            let text = picture.lines().find(|line| line.ends_with(&format!(">{letter}</text>"))).expect("a letter");
            text.split("x=\"")
                .nth(1)
                .and_then(|rest| rest.split('"').next())
                .and_then(|x| x.parse::<f64>().ok())
                .expect("its place")
        };
        // The second view reaches from 206 to 390 points; the first, along y, is as it always is.
        assert_eq!(across("y") < 29_800.0, out == "low", "{}", across("y"));
        assert!(across("x") > 10_600.0, "{}", across("x"));
    }
}

#[test]
fn a_cohort_of_one_is_of_one_subject() {
    let here = folder();
    fs::create_dir(here.path().join("in")).expect("made");
    fs::write(here.path().join("in/a.swc"), "1 0 0 0 0 1 -1\n2 0 5 0 0 1 1\n3 0 10 0 0 1 2\n").expect("written");
    run(here.path(), &["infer", "in/*.swc", "-o", "out", "-q"]);
    let html = fs::read_to_string(here.path().join("out/cohort.html")).expect("a page");
    assert!(html.contains("<title>willis infer: 1 subject</title>"));
}
