//! The variant of an uncertain circle, against products and enumerations by hand; and what a circle makes of a lost feeder.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::command::{data, folder, stderr, willis};
use crate::refused::refused;
use willis::internals::circle_of_willis::{
    Artery, BodySide, Circle, LabelScheme, Posterior, RING, Variant, VariantFrequencies, collaterals,
};
use willis::internals::decision::{KnownEnds, Topologies, TopologySource};
use willis::internals::flow::boundary_conditions::stated;
use willis::internals::flow::{Boundary, FoundOutlets};
use willis::internals::formats::{ReadOptions, read_graphml};
use willis::internals::network::{Evidence, Network, Origin, Vessel};
use willis::internals::sampling::SamplingOptions;

fn circle_of(file: &str) -> Network {
    read_graphml(&fs::read(data(&format!("circle-of-willis/{file}.graphml"))).unwrap()[..], &ReadOptions::default()).unwrap().0
}

fn vessel(network: &Network, label: &str) -> usize {
    (0..network.vessel_count()).find(|row| network.vessel(*row).label == label).unwrap()
}

/// The complete circle with some vessels broken off at one of their nodes: each now ends in a node of its own, from which a candidate
/// leads back with the odds given, and another leads to the node called `astray`.
fn broken(breaks: &[(&str, f64)], astray: Option<(&str, f64)>) -> Network {
    let whole = circle_of("complete");
    let mut network = Network::new();
    for node in whole.nodes() {
        network.add_node(node.clone());
    }
    let mut gaps = Vec::new();
    for (row, (ends, v)) in whole.vessels().enumerate() {
        let mut ends = ends;
        if let Some((_, odds)) = breaks.iter().find(|(label, _)| whole.vessel(row).label == *label) {
            let mut end = whole.node(ends[0]).clone();
            end.id = format!("end of {}", v.label);
            (end.role, end.condition) = (None, None);
            let loose = network.add_node(end);
            gaps.push((ends[0], loose, *odds));
            ends[0] = loose;
        }
        network.add_vessel(ends, Vessel { origin: Origin::Observed, ..v.clone() });
    }
    let candidate = |odds: f64| Vessel {
        origin: Origin::Candidate,
        prior: 0.5,
        evidence: Some(Box::new(Evidence { continuation_odds: [odds, 0.0], ..Evidence::undirected(0.5) })),
        ..Vessel::new(1e-3, 1e-3, Origin::Observed)
    };
    for (node, loose, odds) in gaps {
        network.add_vessel([loose, node], candidate(odds));
        if let Some((id, odds)) = astray {
            let to = (0..network.node_count()).find(|row| network.node(*row).id == id).unwrap();
            network.add_vessel([loose, to], candidate(odds));
        }
    }
    network
}

fn posterior(network: &Network, samples: u64) -> Posterior {
    let circle = Circle::labelled(network, LabelScheme::Names).unwrap().0;
    let mut known = vec![false; network.node_count()];
    circle.ends(network).into_iter().for_each(|node| known[node] = true);
    let boundary = Boundary::resolve(network, &stated(network), FoundOutlets::Ground).unwrap();
    let params = SamplingOptions { samples, seed: 4, ..SamplingOptions::default() };
    Posterior::of(
        &circle,
        network,
        &Topologies::draw(network, &boundary, &params, TopologySource::FreeEnds(KnownEnds { ends: &known, inlets: &[] }))
            .unwrap(),
    )
}

fn missing(variant: &Variant) -> String {
    variant.missing().iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

/// Two breaks: L-A1 is joined again with 3/4, R-PComm with 1/3, independently.
#[test]
fn variants_have_the_probability_of_their_topologies() {
    let n = 40_000;
    let found = posterior(&broken(&[("L-A1", 3.0), ("R-PComm", 0.5)], None), n);
    let expected = BTreeMap::from([
        (String::new(), 0.75 / 3.0),
        ("L-A1".to_owned(), 0.25 / 3.0),
        ("R-PComm".to_owned(), 0.75 * 2.0 / 3.0),
        ("L-A1 R-PComm".to_owned(), 0.25 * 2.0 / 3.0),
    ]);
    let near = |found: f64, p: f64| (found - p).abs() < 4.5 * (p * (1.0 - p) / n as f64).sqrt();
    assert_eq!(found.variants.len(), 4);
    for (variant, p) in &found.variants {
        assert!(near(*p, expected[&missing(variant)]), "{}: {p}", missing(variant));
    }
    assert_eq!(missing(&found.best()), "R-PComm");
    assert!((found.margin() - (found.variants[0].1 - found.variants[1].1)).abs() < 1e-15);
    for (segment, p) in RING.iter().zip(found.segments) {
        let right = match segment.to_string().as_str() {
            "L-A1" => 0.75,
            "R-PComm" => 1.0 / 3.0,
            _ => 1.0,
        };
        assert!(near(p, right) || (p - right).abs() < 1e-12, "{segment}: {p}");
    }
    // Both candidates decide. The answer hangs on the missing one more: by 3/4 (1/3 · 2/3), the other by 2/3 (3/4 · 1/4).
    let shares: Vec<f64> = found.deciding.iter().map(|d| (d.covariance() * 1e3).round() / 1e3).collect();
    assert_eq!(found.deciding.len(), 2);
    assert!((shares[0] - 0.167).abs() < 0.01 && (shares[1] - 0.125).abs() < 0.01, "{shares:?}");
    assert!(found.deciding[0].with == 0.0 && (found.deciding[0].without - 0.75).abs() < 0.02);
}

/// Shares that add up to 1 on paper and to more than 1 in floating point: what all topologies have is certain, and nothing is more.
#[test]
fn no_probability_passes_one() {
    let network = broken(&[("L-A1", 3.0)], None);
    let circle = Circle::labelled(&network, LabelScheme::Names).unwrap().0;
    let shares = [0.56, 0.32, 0.06, 0.06];
    assert!(shares.iter().sum::<f64>() > 1.0);
    let holds = |lost: usize| (0..network.vessel_count()).map(|row| row != lost).collect();
    let weighted =
        shares.iter().zip([usize::MAX, vessel(&network, "L-PComm"), vessel(&network, "R-PComm"), vessel(&network, "R-P1")]);
    let weighted = weighted.map(|(share, lost)| (holds(lost), *share)).collect();
    let found = Posterior::of(&circle, &network, &Topologies { weighted, samples: 100 });
    assert_eq!(found.segments[0], 1.0);
    let decided = found.deciding.iter().flat_map(|d| [d.share_with, d.with, d.without]);
    let variants = found.variants.iter().map(|(_, p)| *p);
    assert!(found.segments.into_iter().chain(found.fetal).chain(variants).chain(decided).all(|p| (0.0..=1.0).contains(&p)));
    // A single variant in all of them.
    let shares = shares.map(|share| (holds(usize::MAX), share)).to_vec();
    assert_eq!(Posterior::of(&circle, &network, &Topologies { weighted: shares, samples: 100 }).probability(), 1.0);
}

/// The candidate of one end excludes the other: L-A1 joins its carotid (2/5) or its end goes astray to the end of L-PComm's posterior
/// artery (2/5), never both. A product of marginals would give both 4/25.
#[test]
fn what_excludes_one_another_is_counted_together() {
    let whole = circle_of("complete");
    let posterior_node = whole.node(whole.ends(vessel(&whole, "L-PComm"))[0]).id.clone();
    let network = broken(&[("L-A1", 2.0)], Some((&posterior_node, 2.0)));
    let found = posterior(&network, 20_000);
    let candidates: Vec<usize> =
        (0..network.vessel_count()).filter(|row| network.vessel(*row).origin == Origin::Candidate).collect();
    let share = |row: usize| found.deciding.iter().find(|d| d.vessel == row).map(|d| d.share_with);
    assert!(share(candidates[0]).is_some_and(|p| (p - 0.4).abs() < 0.02), "{:?}", found.deciding);
    let there: f64 = found.variants.iter().filter(|(v, _)| v.has(Artery::A1(BodySide::Left))).map(|(_, p)| p).sum();
    assert!((there - 0.4).abs() < 0.02, "{there}");
    assert!(candidates.iter().filter(|row| found.topology[**row]).count() < 2);
}

/// Without AComm and both PComm nothing leads around a closed carotid: its territories are left with nothing, the others with all.
/// With the whole circle something is left everywhere, and mirrored occlusions leave mirrored shares.
#[test]
fn a_lost_carotid_leaves_what_the_circle_brings() {
    let all = |network: &Network| {
        let circle = Circle::labelled(network, LabelScheme::Names).unwrap().0;
        let boundary = Boundary::resolve(network, &stated(network), FoundOutlets::Ground).unwrap();
        collaterals(&circle, network, |_| true, &boundary, 3.5e-3).unwrap()
    };
    let whole = circle_of("complete");
    let cut = willis::internals::phantom::without(&whole, &["AComm", "L-PComm", "R-PComm"]).unwrap();
    let apart = all(&cut);
    assert_eq!(apart.iter().map(|c| c.occluded.to_string()).collect::<Vec<_>>(), ["L-ICA", "R-ICA", "BA"]);
    let shares =
        |c: &willis::internals::circle_of_willis::Collateral| c.residual().map(|share| (share.unwrap() * 1e9).round() / 1e9);
    // L-A2, R-A2, L-M1, R-M1, L-P2, R-P2
    assert_eq!(shares(&apart[0]), [0.0, 1.0, 0.0, 1.0, 1.0, 1.0]);
    assert_eq!(shares(&apart[1]), [1.0, 0.0, 1.0, 0.0, 1.0, 1.0]);
    assert_eq!(shares(&apart[2]), [1.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
    assert!(apart.iter().all(|c| c.takes_over.is_none()));
    let together = all(&whole);
    let [left, right, basilar] = [0, 1, 2].map(|at| shares(&together[at]));
    let mirrored = |x: [f64; 6]| [x[1], x[0], x[3], x[2], x[5], x[4]];
    for (a, b) in left.iter().zip(mirrored(right)) {
        // The table's vertebrals differ from side to side in what leads to them, and in nothing else.
        assert!((a - b).abs() < 2e-3, "{left:?} {right:?}");
    }
    assert!(left.iter().chain(&basilar).all(|share| (0.05..=1.01).contains(share)), "{left:?} {basilar:?}");
    assert_eq!(together[0].takes_over, Some(Artery::AComm));
    assert!(matches!(together[2].takes_over, Some(Artery::PComm(_))));
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// The folder answers as the run did; one candidate more in its graph, and it is refused.
#[test]
fn a_folder_of_infer_is_asked_again() {
    let here = folder();
    let run = |arguments: &[&str]| {
        let output = willis(here.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stderr(&output)
    };
    run(&["phantom", "cerebral", "--without", "L-PComm", "--break", "--seed", "1", "-o", "a.swc"]);
    let landmarks = fs::read_to_string(here.path().join("a.landmarks.csv")).unwrap();
    assert!(landmarks.starts_with("label,x_mm,y_mm,z_mm\n") && landmarks.contains("L-ICA I,-44,16,112\n"), "{landmarks}");
    run(&["infer", "a.swc", "-o", "run", "--landmarks", "{}.landmarks.csv", "-n", "300", "--seed", "7"]);
    let said = run(&["classify", "run", "-o", "again", "--landmarks", "a.landmarks.csv"]);
    assert!(said.contains("300 plausible topologies, whose free ends continue by the evidence"), "{said}");
    let (first, again) = (json(&here.path().join("run/phenotype.json")), json(&here.path().join("again/phenotype.json")));
    assert_eq!(first, again);
    let segments = first["probabilities"]["segments"].as_object().unwrap();
    assert!(segments.len() == 7 && segments.values().all(|p| (0.0..=1.0).contains(&p.as_f64().unwrap())));
    let sum: f64 =
        first["probabilities"]["variants"].as_array().unwrap().iter().map(|v| v["probability"].as_f64().unwrap()).sum();
    assert!(sum <= 1.0 + 1e-9 && sum > 0.5, "{sum}");
    let (record, asked) = (json(&here.path().join("run/run.json")), json(&here.path().join("again/run.json")));
    assert_eq!(record["phenotype"], first);
    // Who feeds what is told by both, and all that arrives comes by some feeder.
    assert_eq!(record["supply"], asked["supply"]);
    let supplies = ["run", "again"].map(|folder| fs::read_to_string(here.path().join(folder).join("supply.csv")).unwrap());
    assert_eq!(supplies[0], supplies[1]);
    for (territory, supply) in record["supply"].as_object().unwrap() {
        let shares = supply["shares"].as_object().unwrap().values();
        let sum: f64 = shares.map(|share| share["mean"].as_f64().unwrap_or(0.0)).sum();
        assert!(supply["p_fed"] == 0.0 || (sum - 1.0).abs() < 1e-9, "{territory}: {supply}");
    }
    figures_agree(&here.path().join("run"), &first);
    let table = fs::read_to_string(here.path().join("again/collateral.csv")).unwrap();
    assert!(table.starts_with("occluded,kind,artery,flow_mL_per_min,") && table.contains("\nL-ICA,territory,L-M1,"), "{table}");

    // Without evidence the samples vote, and the folder repeats that too.
    run(&["infer", "a.swc", "-o", "flow", "--landmarks", "a.landmarks.csv", "-n", "200", "--prior", "none"]);
    let said = run(&["classify", "flow", "-o", "flow-again", "--landmarks", "a.landmarks.csv"]);
    assert!(said.contains("that samples vote for"), "{said}");
    assert_eq!(json(&here.path().join("flow/phenotype.json")), json(&here.path().join("flow-again/phenotype.json")));

    // The run's own rate of unseen segments holds, unless another one is stated.
    run(&["infer", "a.swc", "-o", "seen", "--landmarks", "auto", "-n", "200", "--unseen", "0.4"]);
    run(&["classify", "seen", "-o", "same"]);
    run(&["classify", "seen", "-o", "never", "--unseen", "0"]);
    let [seen, same, never] = ["seen", "same", "never"].map(|run| json(&here.path().join(run).join("phenotype.json")));
    // One way to a figure, one figure.
    assert_eq!(seen, same);
    let supplies = ["seen", "same"].map(|folder| fs::read_to_string(here.path().join(folder).join("supply.csv")).unwrap());
    assert_eq!(supplies[0], supplies[1]);
    figures_agree(&here.path().join("seen"), &seen);
    let there = |run: &serde_json::Value| run["probabilities"]["segments"]["L-PComm"].as_f64().unwrap();
    assert!(there(&seen) > there(&never) + 0.05, "{} {}", there(&seen), there(&never));

    let graph = here.path().join("run/candidates.graphml");
    let text = fs::read_to_string(&graph).unwrap();
    fs::write(&graph, text.replacen("candidate", "observed", 1)).unwrap();
    let output = willis(here.path(), &["classify", "run", "-o", "edited", "--landmarks", "a.landmarks.csv"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("not the graph that was sampled"), "{}", stderr(&output));
    assert!(!here.path().join("edited").exists());
}

/// What decides has the P of edges.csv, and figures over topologies lie within their intervals.
fn figures_agree(run: &Path, phenotype: &serde_json::Value) {
    let table = |name: &str| {
        let text = fs::read_to_string(run.join(name)).unwrap();
        let rows: Vec<Vec<String>> = text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
        let columns = rows[0].clone();
        (move |name: &str| columns.iter().position(|column| column == name).unwrap(), rows[1..].to_vec())
    };
    let (column, vessels) = table("edges.csv");
    let deciding = phenotype["probabilities"]["deciding"].as_array().unwrap();
    assert!(!deciding.is_empty());
    for one in deciding {
        let row = usize::try_from(one["edge"].as_u64().unwrap()).unwrap();
        let p: f64 = vessels[row][column("probability")].parse().unwrap();
        assert_eq!(one["probability"].as_f64().unwrap(), p, "edge {row}");
        assert!((0.0..=1.0).contains(&one["share"].as_f64().unwrap()), "{one}");
    }
    let (column, supplies) = table("supply.csv");
    for row in supplies {
        for names in [["supply", "supply_low", "supply_high"], ["arrival_ms", "arrival_low_ms", "arrival_high_ms"]] {
            let [at, low, high] = names.map(|name| row[column(name)].parse::<f64>().unwrap_or(f64::NAN));
            assert!(at.is_nan() || low <= at && at <= high, "{}: {} outside {low} to {high}", row.join(","), names[0]);
        }
    }
}

/// A cohort of folders: a row each with variant and probabilities; done again, the same bytes.
#[test]
fn a_cohort_is_classified() {
    let here = folder();
    let run = |arguments: &[&str], status: i32| {
        let output = willis(here.path(), arguments);
        assert_eq!(output.status.code(), Some(status), "{}", stderr(&output));
    };
    for (name, without) in [("a", "AComm"), ("b", "R-P1")] {
        let file = format!("{name}.swc");
        run(&["phantom", "cerebral", "--without", without, "--break", "--seed", "2", "-o", &file], 0);
    }
    run(&["infer", "a.swc", "b.swc", "-o", "runs", "--landmarks", "{}.landmarks.csv", "-n", "200"], 0);
    let table = fs::read_to_string(here.path().join("runs/cohort.csv")).unwrap();
    let header = table.lines().next().unwrap();
    for column in ["variant", "completeness", "p_variant", "margin", "p_AComm", "rho_G_W_per_m3", "sparsity", "wall_s"] {
        assert!(header.split(',').any(|name| name == column), "no {column} in {header}");
    }
    for name in ["a", "b"] {
        fs::copy(here.path().join(format!("{name}.landmarks.csv")), here.path().join(format!("runs/{name}.landmarks.csv")))
            .unwrap();
    }
    let classify = ["classify", "runs/a", "runs/b", "-o", "variants", "--landmarks", "{}.landmarks.csv"];
    run(&classify, 0);
    run(&["classify", "runs/a", "-o", "alone"], 0);
    assert_eq!(json(&here.path().join("alone/phenotype.json")), json(&here.path().join("variants/a/phenotype.json")));
    let first = fs::read(here.path().join("variants/cohort.csv")).unwrap();
    run(&classify, 0);
    assert_eq!(first, fs::read(here.path().join("variants/cohort.csv")).unwrap());
    let table = String::from_utf8(first).unwrap();
    assert!(table.lines().next().unwrap().contains("takes_over_L-ICA,L-A2_without_L-ICA"), "{table}");
    assert_eq!(table.lines().count(), 3);
}

#[test]
fn folders_that_are_no_run_are_refused() {
    let record = br#"{"willis":"1"}"#;
    let file: (&str, &[u8]) = ("run.json", record);
    refused(&[file], &["classify", ".", "-o", "out"], &["a run without a graph of candidates"]);
    refused(&[], &["classify", ".", "-o", "out"], &["a folder without run.json"]);
}

#[test]
fn the_shipped_table_is_one_of_people() {
    let table = VariantFrequencies::published().expect("reads");
    assert!((table.share.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert!(table.marginals().iter().all(|p| (0.2..0.99).contains(p)), "{:?}", table.marginals());
}

/// Two variants by hand: complete in 3 of 4, both PComm missing in 1 of 4 (the table names 98 % of everybody).
#[test]
fn what_is_not_seen_follows_from_what_is() {
    let table = VariantFrequencies::read(b"missing,share\ncomplete,75\n\"L-PComm, R-PComm\",25\n").expect("reads");
    let (left, right) = (5, 6);
    assert_eq!((RING[left].to_string(), RING[right].to_string()), ("L-PComm".into(), "R-PComm".into()));
    let mut decidable = [true; 7];
    decidable[right] = false;
    let mut presence = [0.999; 7];
    let with = table.given(&presence, &decidable)[right];
    presence[left] = 0.001;
    let without = table.given(&presence, &decidable)[right];
    assert!(with > 0.97 && without < 0.05, "{with} {without}");
    assert_eq!(table.given(&presence, &decidable)[left], 0.001);
    let usual = table.given(&presence, &[false; 7])[right];
    assert!((usual - table.marginals()[right]).abs() < 1e-12);
}

#[test]
fn bad_tables_are_refused() {
    for (text, at) in [
        ("missing,share\nM1,1\n", "M1"),
        ("missing,share\ncomplete,-1\n", "-1"),
        ("missing\nx\n", "share"),
        ("missing,share\ncomplete,0\n", "no variant"),
        ("missing,share\ncomplete,1e308\nL-A1,1e308\n", "more than 1e308"),
    ] {
        let fault = VariantFrequencies::read(text.as_bytes()).expect_err("refused").in_file(Path::new("a.csv"));
        assert!(fault.to_string().contains(at), "{fault}");
    }
}
