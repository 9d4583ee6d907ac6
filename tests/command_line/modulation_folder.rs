//! The folder of `willis modulate` as a person makes it: refusals, repeatable bytes, tables that say what the samples say.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

const FILES: [&str; 11] = [
    "classes.csv",
    "edges.csv",
    "hypertension.csv",
    "hypertension.png",
    "hypertension.svg",
    "modulation.png",
    "modulation.svg",
    "nodes.csv",
    "report.html",
    "run.json",
    "samples.npz",
];

fn willis(folder: &Path, threads: usize, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_willis"));
    command.current_dir(folder).env("WILLIS_THREADS", threads.to_string()).args(arguments).output().expect("the binary runs")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with the circle of Willis in it.
fn circle() -> TempDir {
    let here = tempfile::tempdir().expect("a temporary folder");
    let output = willis(here.path(), 1, &["phantom", "cerebral", "-o", "circle.graphml", "-q"]);
    assert!(output.status.success(), "{}", said(&output));
    here
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").file_name().into_string().expect("UTF-8")).collect();
    names.sort();
    names
}

/// The circle that ships with the project is its own mirror image: two vessels have the largest force, and both are above the default threshold,
/// a tenth of its 20 vessels. Narrower vessels have more: the share rises from class to class.
#[test]
fn the_default_threshold_of_hypertension_has_vessels_above_it() {
    let here = tempfile::tempdir().expect("a temporary folder");
    let circle = concat!(env!("CARGO_MANIFEST_DIR"), "/data/circle-of-willis/complete.graphml");
    for reading in ["increment", "geometry"] {
        let output =
            willis(here.path(), 1, &["modulate", circle, "-o", reading, "-n", "128", "--reading", reading, "--json", "-q"]);
        assert!(output.status.success(), "{}", said(&output));
        let record: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let share = |of: &serde_json::Value| of["share_above_threshold"].as_f64().expect("a share");
        assert!((share(&record["unperturbed"]) - 0.1).abs() < 1e-12, "{reading}: {}", record["unperturbed"]);
        let classes: Vec<f64> = record["classes"].as_array().expect("classes").iter().map(share).collect();
        assert!(classes.iter().all(|share| *share > 0.0 && *share < 1.0), "{reading}: {classes:?}");
        assert!(reading == "increment" || classes.is_sorted_by(|a, b| a < b), "{classes:?}");
    }
}

#[test]
fn bad_arguments_are_refused_in_one_line_and_nothing_is_written() {
    let here = circle();
    let cases: [(&[&str], &[&str]); 12] = [
        (&["--classes", "0.5:0.2"], &["--classes", "0.5:0.2", "ends before it begins"]),
        (&["--classes", ""], &["--classes", "LOW:HIGH"]),
        (&["--classes", "0:0.2,"], &["--classes", "\"\"", "LOW:HIGH"]),
        (&["--classes", "0.5:1.2"], &["--classes", "0.5:1.2", "high < 1"]),
        (&["--classes", "-0.1:0.2"], &["--classes", "-0.1:0.2", "0 <= low"]),
        (&["--classes", "0.2"], &["--classes", "\"0.2\"", "LOW:HIGH"]),
        (&["--classes", "0:0.2,0:0.2"], &["--classes", "0:0.2", "twice"]),
        (&["-n", "0"], &["--samples", "0"]),
        (&["--vessels", "L-M1,Aorta"], &["--vessels", "\"Aorta\"", "label"]),
        (&["--threshold", "-1"], &["--threshold", "-1", "mmHg/mm2"]),
        (&["--reading", "halved"], &["--reading", "halved", "increment"]),
        (&["--dpi", "1"], &["--dpi", "1"]),
    ];
    for (arguments, words) in cases {
        let output = willis(here.path(), 1, &[&["modulate", "circle.graphml", "-o", "out", "-q"], arguments].concat());
        let said = said(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(words.iter().all(|word| said.contains(word)), "{arguments:?}: {said}");
        assert_eq!(names(here.path()), ["circle.graphml"]);
    }
}

/// 1,000 instances are 16 blocks a class, the last one short.
#[test]
fn the_folder_is_the_same_at_any_number_of_threads() {
    let here = circle();
    let run = |threads: usize| {
        let arguments = ["modulate", "circle.graphml", "-o", "out", "--save-samples", "--force", "-q", "--reading", "geometry"];
        let output = willis(here.path(), threads, &arguments);
        assert!(output.status.success(), "{}", said(&output));
        let out = here.path().join("out");
        assert_eq!(names(&out), FILES);
        FILES.map(|name| {
            let bytes = fs::read(out.join(name)).expect("a file");
            if name != "run.json" {
                return bytes;
            }
            let mut record: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
            record["time"] = serde_json::Value::Null;
            record.to_string().into_bytes()
        })
    };
    let one = run(1);
    assert!(one == run(2) && one == run(8));
}

/// Centerlines go in without candidates, and outlets are ground unless said otherwise.
#[test]
fn centerlines_are_modulated_without_candidates() {
    let here = tempfile::tempdir().expect("a temporary folder");
    fs::write(here.path().join("a.swc"), "1 0 0 0 0 1 -1\n2 0 9 0 0 1 1\n3 0 18 9 0 0.5 2\n4 0 18 -9 0 0.4 2\n")
        .expect("written");
    let output = willis(here.path(), 2, &["modulate", "a.swc", "-o", "out", "-n", "10"]);
    assert!(output.status.success() && said(&output).contains("mmHg·s/mL"), "{}", said(&output));
    let record = fs::read(here.path().join("out/run.json")).expect("a record");
    let record: serde_json::Value = serde_json::from_slice(&record).expect("JSON");
    assert_eq!(record["counts"]["vessels"], 3);
    // Arteries go on where their tracing ends.
    assert_eq!(record["parameters"]["outlets_found"]["murray_mL_per_min"], 700.0);
    assert_eq!(names(&here.path().join("out")), FILES[..10]);
}

const SCRIPT: &str = r#"
import csv, math
import networkx as nx, numpy as np, scipy.stats as st

z = np.load("out/samples.npz")
rows = {name: list(csv.DictReader(open(f"out/{name}.csv"))) for name in ("classes", "nodes", "edges", "hypertension")}
names = ["0:0.2", "0.2:0.3", "0.3:0.5"]
assert (z["classes"] == [[float(x) for x in n.split(":")] for n in names]).all()
near = lambda a, b: math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12)

def same(row, values, rest):
    known = [values.mean(), values.std(ddof=1), *np.quantile(values, [0.05, 0.25, 0.5, 0.75, 0.95]), rest]
    found = [float(row[c]) for c in ("mean", "std", "q05", "q25", "median", "q75", "q95", "unperturbed")]
    assert all(near(a, b) for a, b in zip(found, known)), (row, known)

for at, name in enumerate(names, 1):
    of = lambda table, quantity: [r for r in rows[table] if r["class"] == name and r["quantity"] == quantity]
    for r in of("nodes", "pressure_mmHg"):
        same(r, z[f"class{at}_pressure_mmHg"][:, int(r["node"])], z["unperturbed_pressure_mmHg"][0, int(r["node"])])
    for quantity in ("flow_mL_per_min", "drop_mmHg", "resilience_W_per_m3"):
        found = of("edges", quantity)
        assert len(found) == 20
        for r in found:
            same(r, z[f"class{at}_{quantity}"][:, int(r["edge"])], z[f"unperturbed_{quantity}"][0, int(r["edge"])])
    for quantity in ("rho_G_W_per_m3", "total_inflow_mL_per_min"):
        (r,) = of("classes", quantity)
        rest = z[f"unperturbed_{quantity}"][0]
        same(r, z[f"class{at}_{quantity}"], rest)
        assert near(float(r["ratio"]), z[f"class{at}_{quantity}"].mean() / rest)
    # ρ = ΔP Q / V with the volume of the modulated vessel; ρ_G is the mean over the 20 vessels.
    assert np.allclose(z[f"class{at}_resilience_W_per_m3"].mean(axis=1), z[f"class{at}_rho_G_W_per_m3"], rtol=1e-12)
    f = z[f"class{at}_resistance_factor"]
    assert (f >= 1 + z["classes"][at - 1, 0]).all() and (f <= 1 + z["classes"][at - 1, 1]).all()

    # Hypertension from the pressures and the radii of the input.
    ends = {int(r["edge"]): (int(r["node_a"]), int(r["node_b"])) for r in rows["edges"]}
    graph = nx.read_graphml("circle.graphml", force_multigraph=True)
    radius = {int(d["edge"]): d["radius_mm"] for *_, d in graph.edges(data=True)}
    p = z[f"class{at}_pressure_mmHg"]
    force = np.stack([(p[:, a] + p[:, b]) / 2 / (math.pi * radius[e] ** 2) for e, (a, b) in sorted(ends.items())], axis=1).ravel()
    h = {(r["kind"], r["quantity"]): r for r in rows["hypertension"] if r["class"] == name and r["kind"] != "histogram"}
    k, _, scale = st.gamma.fit(force, floc=0)
    value = lambda *key: float(h[key]["value"])
    assert math.isclose(value("fit", "shape"), k, rel_tol=1e-6) and math.isclose(value("fit", "scale_mmHg_per_mm2"), scale, rel_tol=1e-6)
    assert math.isclose(value("fit", "ks_distance"), st.kstest(force, st.gamma(k, scale=scale).cdf).statistic, rel_tol=1e-6)
    threshold = float(h["risk", "share_empirical"]["from_mmHg_per_mm2"])
    assert threshold == 20.0
    assert near(value("risk", "share_empirical"), (force > threshold).mean()) and value("fit", "share_without_force") == 0
    assert math.isclose(value("risk", "share_by_fit"), st.gamma.sf(threshold, k, scale=scale), rel_tol=1e-6)
    bins = [r for r in rows["hypertension"] if r["class"] == name and r["kind"] == "histogram"]
    assert sum(float(r["value"]) for r in bins) == len(force)
    for r in bins:
        low, high = float(r["from_mmHg_per_mm2"]), float(r["to_mmHg_per_mm2"])
        inner = ((force > low * (1 + 1e-12)) & (force <= high * (1 - 1e-12))).sum()
        outer = ((force > low * (1 - 1e-12)) & (force <= high * (1 + 1e-12))).sum()
        assert inner <= float(r["value"]) <= outer
"#;

/// NumPy, SciPy and NetworkX work every table out again from `samples.npz` and the input. Needs `WILLIS_PYTHON`.
#[test]
fn the_tables_are_those_of_the_samples() {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python with tests/requirements.txt");
        return;
    };
    let here = circle();
    let arguments = ["modulate", "circle.graphml", "-o", "out", "--save-samples", "-q", "-n", "500", "--threshold", "20"];
    let output = willis(here.path(), 2, &arguments);
    assert!(output.status.success(), "{}", said(&output));
    let output = Command::new(python).args(["-c", SCRIPT]).current_dir(here.path()).output().expect("python runs");
    assert!(output.status.success(), "{}", said(&output));
}
