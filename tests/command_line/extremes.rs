//! Every option that takes a figure, at the ends of what a figure can be: it runs or is refused in one line; nothing panics, aborts or goes
//! on for ever. The truth is the exit status and the form of the message.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use crate::command::{builder, data, folder, stderr};

/// The ends: zero, the least and the largest of every kind of number, and what is none.
const ENDS: [&str; 22] = [
    "0",
    "-0",
    "-1",
    "1",
    "5e-324",
    "1e-310",
    "2.3e-308",
    "1e-300",
    "1e-30",
    "0.999999",
    "1.000001",
    "4294967296",
    "9007199254740993",
    "18446744073709551615",
    "18446744073709551616",
    "1e30",
    "1e300",
    "1e308",
    "1.8e308",
    "inf",
    "nan",
    "",
];

/// Commands with a figure to fill in, and what may follow the figure. Those that would rightly work for hours at a large figure are not here
/// with it: counts of samples are limited to one sample where another option is tried.
fn options() -> Vec<(&'static str, &'static [&'static str])> {
    vec![
        ("infer SWC -o out -n 64 --dpi 36 --epsilon={}", &[""]),
        ("infer SWC -o out -n 64 --dpi={}", &[""]),
        ("infer SWC -o out -n 64 --dpi 36 --seed={}", &[""]),
        ("infer SWC -o out -n 64 --dpi 36 --checkpoint={}", &[""]),
        ("infer SWC -o out -n 64 --dpi 36 --threads={}", &[""]),
        ("infer SWC -o out -n 64 --dpi 36 --inlet 1={}", &["", "mmHg", "Pa"]),
        ("infer SWC -o out -n 64 --dpi 36 --outlet 1={}", &["mmHg", "mmHg.s/mL"]),
        ("infer SWC -o out -n 64 --dpi 36 --outlets murray={}", &[""]),
        ("infer SWC -o out -n 64 --dpi 36 --viscosity={}", &["", "cP"]),
        ("infer SWC -o out -n 64 --dpi 36 --max-gap={}", &["", "mm"]),
        ("infer SWC -o out -n 64 --dpi 36 --max-candidate-radius={}", &["", "mm"]),
        ("infer SCAN -o out -n 64 --dpi 36 --probability SCAN --image-places={}", &[""]),
        ("infer SWC -o out -n 64 --dpi 36 -k={}", &[""]),
        ("infer SWC -o out -n 64 --dpi 36 --default-radius={}", &["", "mm"]),
        ("infer SWC -o out -n 64 --dpi 36 --spacing={} --units voxel", &["", "mm"]),
        ("infer SWC -o out -n 64 --dpi 36 --max-input={}", &["", "GiB"]),
        ("infer SWC -o out -n 64 --dpi 36 --box={},0,0,1,1,1", &[""]),
        ("infer SWC -o out -n 64 --dpi 36 --keep probability={}", &[""]),
        ("candidates SWC -o out.graphml --max-gap={}", &["mm"]),
        ("simulate GRAPH -o out --dpi={}", &[""]),
        ("simulate GRAPH -o out --dpi 36 --viscosity={}", &[""]),
        ("simulate GRAPH -o out --dpi 36 --stenosis edge:0={}", &["%", "%@mid:1mm"]),
        ("simulate GRAPH -o out --dpi 36 --tortuosity edge:0={}", &[""]),
        ("simulate GRAPH -o out --dpi 36 --flow 1={}", &["", "mL/min"]),
        ("simulate GRAPH -o out --dpi 36 --pulse --density={}", &[""]),
        ("simulate GRAPH -o out --dpi 36 --pulse --harmonics={}", &[""]),
        ("simulate GRAPH -o out --dpi 36 --pulse --period={}", &["", "s"]),
        ("simulate GRAPH -o out --dpi 36 --pulse --pulse-mean={}", &["mmHg", "mL/min"]),
        ("simulate GRAPH -o out --dpi 36 --pulse --times={}", &[""]),
        ("simulate GRAPH -o out --dpi 36 --pulse --wall pwv={}", &["m/s"]),
        ("simulate GRAPH -o out --dpi 36 --pulse --wall-viscosity={}", &["s"]),
        ("simulate GRAPH -o out --dpi 36 --pulse --windkessel rc={}", &["s"]),
        ("measure SWC -o out --smoothing={}", &["", "mm"]),
        ("classify GRAPH -o out --unseen={}", &[""]),
        ("classify GRAPH -o out --hypoplastic={}", &["mm"]),
        ("modulate GRAPH -o out -n 8 --dpi 36 --threshold={}", &[""]),
        ("modulate GRAPH -o out -n 8 --dpi 36 --classes=0:{}", &[""]),
        ("modulate GRAPH -o out -n 8 --dpi 36 --viscosity={}", &[""]),
        ("modulate GRAPH -o out -n 8 --dpi 36 --outlets murray={}", &[""]),
        ("modulate GRAPH -o out -n 8 --dpi 36 --seed={}", &[""]),
        ("convert SWC out.vtp --spacing={} --units voxel", &[""]),
        ("convert SWC out.vtp --default-radius={}", &["mm"]),
        ("skeleton SCAN -o out.swc --level={}", &[""]),
        ("phantom circle-of-willis -o out.swc --break --spacing={}", &["mm"]),
        ("phantom circle-of-willis -o out.swc --break --seed={}", &[""]),
        ("phantom arterial -o out.swc --edges={}", &[""]),
    ]
}

fn run(here: &Path, line: &str) -> Option<(Option<i32>, String)> {
    let words: Vec<String> = line
        .split(' ')
        .map(|word| match word {
            "SWC" => data("broken-circle-of-willis.swc"),
            "SCAN" => data("scan.nii.gz"),
            "GRAPH" => here.join("graph.graphml").display().to_string(),
            word => word.to_owned(),
        })
        .collect();
    let mut child = builder(here).args(words).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("runs");
    for _ in 0..30_000 {
        if child.try_wait().expect("a status").is_some() {
            let output = child.wait_with_output().expect("ended");
            return Some((output.status.code(), stderr(&output)));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let _ = child.kill();
    None
}

/// `WILLIS_EXTREMES=all` tries every figure at every option; otherwise each option gets a few, different ones from option to option.
#[test]
fn figures_at_the_ends_of_their_range_are_used_or_refused() {
    let all = std::env::var("WILLIS_EXTREMES").is_ok_and(|word| word == "all");
    let graph = folder();
    let made = builder(graph.path()).args(["phantom", "circle-of-willis", "-o", "graph.graphml"]).output().expect("runs");
    assert!(made.status.success(), "{}", stderr(&made));
    let mut wrong = Vec::new();
    for (at, (line, units)) in options().into_iter().enumerate() {
        for (number, end) in ENDS.iter().enumerate() {
            if !all && (number + at) % 11 > 0 {
                continue;
            }
            let here = folder();
            fs::copy(graph.path().join("graph.graphml"), here.path().join("graph.graphml")).expect("copied");
            let line = line.replace("{}", &format!("{end}{}", units[number % units.len()]));
            let Some((status, said)) = run(here.path(), &line) else {
                wrong.push(format!("{line}: goes on for ever"));
                continue;
            };
            let errors = said.lines().filter(|said| said.starts_with("willis: ")).count();
            let is_fine = match status {
                Some(0) => errors == 0,
                Some(1 | 2) => errors == 1,
                _ => false,
            };
            if !is_fine || said.contains("panicked") {
                wrong.push(format!("{line}: {status:?}: {said}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The broken circle with one radius everywhere: every vessel has the same force but for rounding.
#[test]
fn a_distribution_of_equal_forces_is_not_fitted() {
    let here = folder();
    let text = fs::read_to_string(data("broken-circle-of-willis.swc")).expect("read");
    let equal = |line: &str| {
        let mut fields: Vec<&str> = line.split_whitespace().collect();
        if fields.len() == 7 && !line.starts_with('#') {
            fields[5] = "1";
        }
        fields.join(" ")
    };
    fs::write(here.path().join("r1.swc"), text.lines().map(equal).collect::<Vec<_>>().join("\n")).expect("written");
    let (status, said) = run(here.path(), "modulate r1.swc -o o --outlets murray=0.1 --dpi 36").expect("ends");
    assert_eq!(status, Some(0), "{said}");
}
