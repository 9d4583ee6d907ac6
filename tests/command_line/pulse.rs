//! `willis simulate --pulse` as a person runs it: its files, what it says, and what it refuses.

use std::fs;
use std::path::Path;

use crate::command::{folder, stderr, willis};
use crate::refused::refused;

/// A carotid artery that forks into a wide and a narrow outlet.
const EDGES: &[u8] = b"node_a,node_b,label,length_mm,radius_mm
a,b,L-ICA I,100,2
b,c,wide,40,1.5
b,d,thin,40,1
";
const NODES: &[u8] = b"node,role,pressure_mmHg,resistance_mmHg_s_per_mL
a,inlet,90,
b,inner,,
c,outlet,,30
d,outlet,,60
";
/// 100 - 20 cos ωt mmHg, of a period of 0.8 s.
const WAVE: &[u8] = b"time_s,pressure_mmHg\n0.00,80.00\n0.04,80.98\n0.08,83.82\n0.12,88.24\n0.16,93.82\n0.20,100.00\n0.24,106.18\n0.28,111.76\n0.32,116.18\n0.36,119.02\n0.40,120.00\n0.44,119.02\n0.48,116.18\n0.52,111.76\n0.56,106.18\n0.60,100.00\n0.64,93.82\n0.68,88.24\n0.72,83.82\n0.76,80.98\n0.80,80.00\n";

fn files() -> [(&'static str, &'static [u8]); 3] {
    [("a.csv", EDGES), ("nodes.csv", NODES), ("wave.csv", WAVE)]
}

fn run(here: &Path, extra: &[&str]) -> String {
    for (name, bytes) in files() {
        fs::write(here.join(name), bytes).expect("written");
    }
    let arguments = [&["simulate", "a.csv", "-o", "out", "--force"], extra].concat();
    let output = willis(here, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    stderr(&output)
}

/// The values of a column of a table.
fn column(here: &Path, table: &str, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(here.join("out").join(table)).expect("a table");
    let mut lines = text.lines();
    let at = lines.next().expect("a header").split(',').position(|column| column == name);
    let at = at.unwrap_or_else(|| panic!("no column {name} in {table}"));
    lines.map(|line| line.split(',').nth(at).expect("a field").parse().unwrap_or(f64::NAN)).collect()
}

/// Files of openBF have a time that falls by a little: the row goes where it belongs.
#[test]
fn a_time_that_falls_by_less_than_a_step_is_put_in_order() {
    let here = folder();
    let text = std::str::from_utf8(WAVE).expect("text");
    let (row, next) = ("0.40,120.00\n", "0.3986,119.97\n");
    fs::write(here.path().join("ordered.csv"), text.replace(row, &format!("{next}{row}"))).expect("written");
    fs::write(here.path().join("fallen.csv"), text.replace(row, &format!("{row}{next}"))).expect("written");
    assert!(!run(here.path(), &["--pulse", "ordered.csv", "--times", "40"]).contains("put in order"));
    let wanted = column(here.path(), "waveforms.csv", "pressure_mmHg");
    let said = run(here.path(), &["--pulse", "fallen.csv", "--times", "40"]);
    assert!(said.contains("fallen.csv: line 13: times that fall, by 1.40e-3 s at most, are put in order"), "{said}");
    assert_eq!(column(here.path(), "waveforms.csv", "pressure_mmHg"), wanted);
    // An inlet file of openBF has no header: a time and a pressure in Pa, or a flow in m³/s.
    let rows = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())).filter_map(|line| line.split_once(','));
    let pascals = rows.map(|(t, p)| format!("{t} {}\n", p.trim().parse::<f64>().expect("a number") * 133.322_387_415));
    let pascals = pascals.collect::<Vec<_>>().concat();
    fs::write(here.path().join("inlet.dat"), pascals).expect("written");
    run(here.path(), &["--pulse", "wave.csv", "--times", "40"]);
    let wanted = column(here.path(), "waveforms.csv", "pressure_mmHg");
    run(here.path(), &["--pulse", "inlet.dat", "--times", "40"]);
    for (found, wanted) in column(here.path(), "waveforms.csv", "pressure_mmHg").iter().zip(wanted) {
        assert!((found - wanted).abs() < 1e-9 * wanted.abs(), "{found} {wanted}");
    }
    let published = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/openbf-models/circle_of_willis_inlet.dat");
    if published.exists() {
        let said = run(here.path(), &["--pulse", &published.to_string_lossy()]);
        assert!(said.contains("line 15: times that fall, by 1.38e-3 s at most, are put in order"), "{said}");
    }
}

#[test]
fn the_cycle_is_written_and_its_mean_is_the_steady_flow() {
    let here = folder();
    let said = run(here.path(), &["--pulse", "wave.csv", "--times", "40"]);
    assert!(said.contains("period 0.8 s, 40 harmonics; pulsatility L-ICA I"), "{said}");
    for name in ["waveforms.npz", "waveforms.csv", "harmonics.npz", "waveforms.png", "waveforms.svg", "report.html"] {
        assert!(here.path().join("out").join(name).is_file(), "{name}");
    }
    let (mean, steady) =
        (column(here.path(), "edges.csv", "flow_mean_mL_per_min"), column(here.path(), "edges.csv", "flow_mL_per_min"));
    assert_eq!(mean, steady);
    let inlet = column(here.path(), "nodes.csv", "pressure_mean_mmHg")[0];
    assert!((inlet - 100.0).abs() < 1e-9, "{inlet}");
    let (low, high) =
        (column(here.path(), "edges.csv", "flow_min_mL_per_min"), column(here.path(), "edges.csv", "flow_max_mL_per_min"));
    assert!(low.iter().zip(&mean).zip(&high).all(|((low, mean), high)| low < mean && mean < high));
    // Nothing arrives before it leaves.
    let arrival = column(here.path(), "nodes.csv", "pulse_arrival_ms");
    assert!(arrival[0] == 0.0 && arrival[1..].iter().all(|late| *late > 0.0), "{arrival:?}");
    assert_eq!(column(here.path(), "waveforms.csv", "time_s").len(), 3 * 40);
    let record = fs::read_to_string(here.path().join("out/run.json")).expect("a record");
    assert!(record.contains("\"period_s\": 0.8") && record.contains("wave.csv"), "{record}");
}

#[test]
fn a_mean_of_its_own_shapes_by_name_and_perturbations() {
    let here = folder();
    run(here.path(), &["--pulse", "wave.csv", "--pulse-mean", "93mmHg", "--harmonics", "5"]);
    assert!((column(here.path(), "nodes.csv", "pressure_mean_mmHg")[0] - 93.0).abs() < 1e-9);
    let said = run(here.path(), &["--pulse", "--stenosis", "wide=50%@start:10mm", "--transport"]);
    assert!(said.contains("pulsatility after the perturbation"), "{said}");
    // Of a shape the mean is the steady flow at 90 mmHg.
    let (mean, steady) =
        (column(here.path(), "edges.csv", "flow_mean_mL_per_min"), column(here.path(), "edges.csv", "flow_mL_per_min"));
    assert_eq!(mean, steady);
    assert!(column(here.path(), "edges.csv", "pulsatility_index_perturbed").iter().all(|index| *index > 0.0));
    run(here.path(), &["--pulse", "a=wave.csv", "--wall", "rigid", "--outlet", "c=rcr:5mmHg.s/mL,0.02mL/mmHg,25mmHg.s/mL"]);
    assert!(column(here.path(), "edges.csv", "wave_speed_m_per_s").iter().all(|speed| speed.is_infinite()));
}

/// Where the only way in is closed, no wave reaches anything: the mean of the inlet is what is stated there, and no more is known.
#[test]
fn what_no_wave_reaches_has_no_range_of_pressures() {
    let here = folder();
    let said = run(here.path(), &["--pulse", "--occlude", "L-ICA I"]);
    assert!(said.contains("harmonics; no blood flows after the perturbation\n"), "{said}");
    assert_eq!(column(here.path(), "nodes.csv", "pressure_mean_mmHg_perturbed")[0], 90.0);
    for name in ["pressure_max_mmHg_perturbed", "pressure_min_mmHg_perturbed", "delay_ms_perturbed"] {
        assert!(column(here.path(), "nodes.csv", name)[0].is_nan(), "{name}");
    }
}

const LUMPED: &[u8] =
    b"node,role,resistance_mmHg_s_per_mL,compliance_mL_per_mmHg\na,inlet,,\nb,inner,,\nc,outlet,30,0\nd,outlet,60,0.1\n";

#[test]
fn what_is_no_pulse_is_refused_in_one_line() {
    let wave = |text: &'static str| [files()[0], files()[1], ("wave.csv", text.as_bytes())];
    let simulate = |more: &[&'static str]| [&["simulate", "a.csv", "-o", "out"], more].concat();
    let of_wave = ["--pulse", "wave.csv"];
    let waves: [(&str, &[&str]); 9] = [
        ("time_s,pressure_mmHg\n", &["wave.csv: no row", "two or more rows"]),
        ("time_s,pressure_mmHg\n0,80\n", &["wave.csv: one row", "two or more rows"]),
        ("time_s,pressure_mmHg\n0,80\n0.2,120\n0.1,90\n", &["wave.csv:4: time_s 0.1 after 0.2"]),
        (
            "time_s,pressure_mmHg\n0,80\n0.1,85\n0.2,90\n0.3,95\n0.4,100\n0.5,105\n",
            &["wave.csv: values that end", "expected one period"],
        ),
        ("time_s,pressure_mmHg,flow_mL_per_min\n0,80,1\n1,90,2\n", &["wave.csv:1: both pressure_mmHg and flow_mL_per_min"]),
        ("time_s,velocity\n0,80\n1,90\n", &["wave.csv:1:", "pressure_mmHg or flow_mL_per_min"]),
        ("pressure_mmHg\n80\n90\n", &["wave.csv:1:", "time_s"]),
        ("time_s,pressure_mmHg\n0,80\n0,90\n", &["2 rows at one time"]),
        ("time_s,pressure_mmHg\n0,80\n1,x\n", &["wave.csv:3: pressure_mmHg \"x\""]),
    ];
    for (text, words) in waves {
        refused(&wave(text), &simulate(&of_wave), words);
    }
    let options: [(&[&'static str], &[&str]); 14] = [
        (&["--pulse", "wave.csv", "--period", "2s"], &["wave.csv: times that end", "expected one period"]),
        (&["--pulse", "wave.csv", "--period", "0.5s"], &["longer than the period"]),
        (&["--pulse", "none.csv"], &["none.csv"]),
        (&["--pulse", "c=wave.csv"], &["--pulse \"c=wave.csv\": c is no inlet"]),
        (&["--pulse", "wave.csv", "--pulse", "carotid"], &["second waveform of inlet"]),
        (
            &["--pulse", "--wall", "olufsen=2e6,-2253,-9e5"],
            &["--wall law gives Eh (Pa m)", "\"L-ICA I\" of radius 2 mm", "positive"],
        ),
        (&["--pulse", "--wall", "pwv=-3m/s"], &["--wall law gives wave speed (m/s) -3"]),
        (&["--pulse", "--wall", "graph"], &["--wall graph: ", "\"L-ICA I\" states no wall"]),
        (&["--pulse", "--outlet", "c=rcr:5,0,25"], &["--outlet \"c=rcr:5,0,25\"", "is a resistance"]),
        (&["--pulse", "--harmonics", "0"], &["--harmonics 0: expected a number from 1 to 1000"]),
        (&["--pulse", "--windkessel", "rc=0s"], &["--windkessel \"rc=0s\": expected none, or rc=TIME"]),
        (&["--pulse", "wave.csv", "--pulse-mean", "240mL/min"], &["--pulse-mean", "expected a pressure"]),
        (&["--pulse", "--pulse-mean", "240mL/min"], &["--pulse-mean of a shape: goes with a table"]),
        (&["--wall", "rigid"], &["--wall without a pulse: goes with --pulse"]),
    ];
    for (more, words) in options {
        refused(&files(), &simulate(more), words);
    }
    // A model for another solver has no place for these.
    for (name, value) in [("--times", "50"), ("--friction", "parabolic"), ("--wall-viscosity", "0.1s")] {
        let convert = ["convert", "a.csv", "m.json", "--to", "svzerod", "--pulse", name, value];
        refused(&files(), &convert, &[name, "for another solver: goes with simulate"]);
    }
    refused(&[files()[0], ("nodes.csv", LUMPED)], &simulate(&["--pulse"]), &["node c: compliance_mL_per_mmHg 0", "resistance"]);
}
