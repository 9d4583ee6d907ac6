//! `infer --decisions`: what a person accepted is in every answer, what was rejected in none, and a list for another graph is refused.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::command::{data, folder, stderr, willis};
use willis::internals::decision::{RECONNECT, reconnected};
use willis::internals::formats::read_decisions;
use willis::internals::network::{Evidence, Network, Node, Origin, Vessel};
use willis::internals::pipeline::ConnectionDecision;
use willis::internals::pipeline::decisions::apply;
use willis::internals::support::kappa::cohen_kappa;

type Row = std::collections::HashMap<String, String>;

fn table(path: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

fn infer(here: &Path, out: &str, more: &[&str]) {
    let input = data("broken-circle-of-willis.swc");
    let output = willis(here, &[&["infer", &input, "-o", out, "-n", "128", "-q"], more].concat());
    assert!(output.status.success(), "{more:?}: {}", stderr(&output));
}

/// A list that accepts the least and rejects the most likely candidate of a run, with its rows.
fn list(here: &Path, run: &str, input: &str) -> [usize; 2] {
    let (edges, nodes) = (table(&here.join(run).join("edges.csv")), table(&here.join(run).join("nodes.csv")));
    let figure = |row: &usize| {
        let of = |name: &str| edges[*row][name].parse::<f64>();
        of("probability").or_else(|_| of("likelihood")).expect("a figure")
    };
    let mut candidates: Vec<usize> = (0..edges.len()).filter(|row| edges[*row]["origin"] == "candidate").collect();
    candidates.sort_by(|a, b| figure(a).total_cmp(&figure(b)));
    let rows = [candidates[0], candidates[candidates.len() - 1]];
    let id = |row: usize, end: &str| &nodes[edges[row][end].parse::<usize>().expect("a row")]["id"];
    let line = |row: usize, word: &str| {
        format!("{row},{},{},{word},,A. Reader,2026-01-02T03:04:05Z,{input}\n", id(row, "node_a"), id(row, "node_b"))
    };
    let head = "edge,id_a,id_b,decision,probability,who,when,input_sha256\n";
    let text = format!("{head}{}{}", line(rows[0], "accept"), line(rows[1], "reject"));
    fs::write(here.join("decisions.csv"), text).expect("written");
    rows
}

#[test]
fn accepted_connections_are_in_every_answer_and_rejected_ones_in_none() {
    let here = folder();
    let here = here.path();
    let by_rule = ["median", "value=-1", "frequency=0", "probability=0"].map(|rule| ["--keep", rule]);
    let others: [&[&str]; 3] = [&[], &["--preset", "paper"], &["--uncertain", "all"]];
    for (at, more) in others.into_iter().chain(by_rule.iter().map(|rule| &rule[..])).enumerate() {
        let [plain, out] = ["plain", "decided"].map(|name| format!("{name}{at}"));
        infer(here, &plain, more);
        let [accepted, rejected] = list(here, &plain, "");
        infer(here, &out, &[more, &["--decisions", "decisions.csv"]].concat());
        let edges = table(&here.join(&out).join("edges.csv"));
        assert_eq!(edges.len(), table(&here.join(&plain).join("edges.csv")).len(), "every row stays");
        let of = |row: usize| ["kept", "above_median"].map(|name| edges[row][name].as_str());
        assert_eq!((of(accepted), of(rejected)), (["1", "1"], ["0", "0"]), "{more:?}");
        assert_eq!((&*edges[rejected]["likelihood"], &*edges[accepted]["prior"]), ("0", "1"), "{more:?}");
        assert_eq!(edges[rejected]["std_error"], "0", "{more:?}: it is in no sample, for certain");
        let bytes = fs::read(here.join(&out).join("run.json")).expect("a record");
        let record: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
        let made = record["parameters"]["decisions"]["made"].as_array().expect("a list");
        assert!(made.iter().any(|d| d["edge"] == accepted && d["accepted"] == true && d["who"] == "A. Reader"));
        let undecided = record["convergence"]["undecided_edges"].as_array().expect("a list");
        assert!(!undecided.iter().any(|row| *row == rejected || *row == accepted), "{more:?}: both are decided");
        assert!(record["command"].as_str().is_some_and(|line| line.contains("--decisions decisions.csv")));
    }
}

#[test]
fn a_list_for_another_input_or_graph_is_refused_by_line_and_edge() {
    let here = folder();
    let here = here.path();
    infer(here, "plain", &[]);
    let input = data("broken-circle-of-willis.swc");
    let refused = |more: &[&str], word: &str| {
        let output = willis(here, &[&["infer", &input, "-o", "refused", "-q", "--decisions", "decisions.csv"], more].concat());
        assert_eq!(output.status.code(), Some(2), "{more:?}");
        let said = stderr(&output);
        assert!(said.contains("decisions.csv:") && said.contains(word) && !here.join("refused").exists(), "{said}");
    };
    list(here, "plain", "");
    refused(&["-k", "1"], "edge");
    let [accepted, _] = list(here, "plain", &"0".repeat(64));
    refused(&[], &format!("edge {accepted} was decided on for an input"));
    fs::write(here.join("decisions.csv"), "edge,id_a,id_b,decision\n0,1,2,accept\n").expect("written");
    refused(&[], "edge 0");
}

#[test]
fn a_list_is_read_and_what_is_wrong_is_named() {
    let list =
        b"edge,id_a,id_b,decision,probability,who,when\n7,1,2:3,accept,0.5,\"Doe, J\",2026-01-02T03:04:05Z\n9,4,5,reject,,NA,\n11,8,9,unsure,,,\n";
    let read = read_decisions(list).expect("a list").connections;
    assert_eq!(
        (read[0].made.edge, read[0].made.accepted, &*read[0].ids[1], &*read[0].made.who),
        (7, Some(true), "2:3", "Doe, J")
    );
    assert_eq!((read[1].made.edge, read[1].made.accepted, read[1].line), (9, Some(false), 3));
    assert_eq!((read[2].made.accepted, &*read[1].made.who, &*read[2].made.who), (None, "NA", ""), "NA is a person here");
    for (text, word) in [
        ("edge,id_a,id_b\n1,a,b\n", "decision"),
        ("edge,id_a,id_b,decision\n1,a,b,perhaps\n", "\"perhaps\""),
        ("edge,id_a,id_b,decision\n-1,a,b,accept\n", "edge \"-1\""),
        ("edge,id_a,id_b,decision\n1,a,b,accept\n1,a,b,reject\n", "comes again"),
        ("edge,id_a,id_b,decision,places\n,,,part,1 2 3\n", "two or more groups"),
        ("edge,id_a,id_b,decision,places\n,,,delete,\n", "finite numbers"),
        ("edge,id_a,id_b,decision,places\n1,a,b,accept,1 2 3\n", "two nodes"),
    ] {
        let fault = read_decisions(text.as_bytes()).expect_err(text);
        let said = fault.in_file("a.csv".as_ref()).to_string();
        assert!(said.contains(word), "{said}");
    }
}

/// By hand: an end with candidates of P = 0.5, 0.3 and 0.1, and another candidate elsewhere with P = 0.4. The law of forests says how
/// probably a fragment hangs on none.
fn graph(root_score: Option<f64>) -> Network {
    let mut graph = Network::new();
    let nodes: Vec<usize> =
        (0..7).map(|id| graph.add_node(Node { id: format!("n{id}"), root_score, ..Node::default() })).collect();
    for [a, b] in [[0, 1], [2, 3], [3, 4], [5, 6]] {
        graph.add_vessel([nodes[a], nodes[b]], Vessel::new(0.01, 0.001, Origin::Observed));
    }
    for (a, b, p) in [(1, 3, 0.5), (1, 2, 0.3), (1, 4, 0.1), (5, 3, 0.4)] {
        graph.add_vessel([nodes[a], nodes[b]], open(Origin::Candidate, p));
    }
    graph
}

fn open(origin: Origin, p: f64) -> Vessel {
    Vessel { prior: p, evidence: Some(Box::new(Evidence::undirected(p))), ..Vessel::new(0.01, 0.001, origin) }
}

/// P of the connections of [`graph`], and their priors, after a decision on the first.
fn decided(root_score: Option<f64>, accepted: bool) -> [Vec<f64>; 2] {
    let mut graph = graph(root_score);
    apply(&mut graph, &[decision(4, accepted)]).expect("applied");
    assert_eq!(graph.vessel(4).certain, accepted);
    apply(&mut graph.clone(), &[decision(0, true)]).expect_err("an observed vessel");
    let of = |figure: &dyn Fn(&Vessel) -> f64| (4..8).map(|row| figure(graph.vessel(row))).collect();
    [of(&|vessel| vessel.evidence().expect("evidence").probability), of(&|vessel| vessel.prior)]
}

fn decision(edge: usize, accepted: bool) -> ConnectionDecision {
    ConnectionDecision { edge, accepted: Some(accepted), ..ConnectionDecision::default() }
}

/// All three candidates of the end join the same two fragments.
#[test]
fn by_the_law_of_forests_two_fragments_are_joined_once() {
    assert_eq!(decided(Some(0.5), true), [[1.0, 0.0, 0.0, 0.4]; 2]);
    assert_eq!(decided(Some(0.5), false), [[0.0, 0.3, 0.1, 0.4]; 2]);
}

/// From the free end of one fragment a candidate leads to each of four others, with the P that the one hangs on the other, and that the other hangs on it;
/// the last candidate joins the first two of the others. What is left of P after decisions.
fn fork(hangs: [[f64; 2]; 5], decisions: &[ConnectionDecision]) -> Vec<f64> {
    let mut graph = Network::new();
    for id in 0..10 {
        graph.add_node(Node { id: format!("n{id}"), root_score: Some(0.1), ..Node::default() });
    }
    for a in [0, 2, 4, 6, 8] {
        graph.add_vessel([a, a + 1], Vessel::new(0.01, 0.001, Origin::Observed));
    }
    for ([a, b], attached) in [[1, 2], [1, 4], [1, 6], [1, 8], [3, 5]].into_iter().zip(hangs) {
        let evidence = Evidence { attached, ..Evidence::undirected(attached[0] + attached[1]) };
        graph.add_vessel([a, b], Vessel { evidence: Some(Box::new(evidence)), ..open(Origin::Candidate, evidence.probability) });
    }
    apply(&mut graph, decisions).expect("applied");
    let evidence = |row: usize| graph.vessel(row).evidence().expect("evidence");
    for e in (5..10).map(evidence) {
        assert!((e.probability - e.attached[0] - e.attached[1]).abs() < 1e-12, "{e:?}");
    }
    (5..10).map(|row| evidence(row).probability).collect()
}

/// By hand: any number of fragments hang on one, as the daughters of a bifurcation do, and it hangs on one at most. Where it hangs by the accepted candidate
/// with 0.2 of 0.8, it hangs on another with three quarters of what that says; where by two accepted ones with odds of 1/3 and 1, with 3/7.
#[test]
fn a_fragment_hangs_on_one_other_and_any_number_hang_on_it() {
    let close = |found: Vec<f64>, expected: [f64; 5]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} for {expected:?}");
    };
    let accept = |rows: &[usize]| rows.iter().map(|row| decision(*row, true)).collect::<Vec<ConnectionDecision>>();
    let daughters = [[0.0, 0.8], [0.0, 0.74], [0.1, 0.0], [0.2, 0.1], [0.2, 0.2]];
    close(fork(daughters, &accept(&[5])), [1.0, 0.74, 0.1, 0.3, 0.4]);
    // Both daughters: what would join them once more is gone.
    close(fork(daughters, &accept(&[5, 6])), [1.0, 1.0, 0.1, 0.3, 0.0]);
    close(fork([[0.8, 0.0], [0.7, 0.0], [0.1, 0.2], [0.0, 0.3], [0.2, 0.2]], &accept(&[5])), [1.0, 0.0, 0.2, 0.3, 0.4]);
    let either = [[0.2, 0.6], [0.3, 0.3], [0.2, 0.1], [0.0, 0.0], [0.1, 0.0]];
    close(fork(either, &accept(&[5])), [1.0, 0.525, 0.25, 0.0, 0.1]);
    close(fork(either, &accept(&[5, 6])), [1.0, 1.0, 0.6 / 7.0 + 0.1, 0.0, 0.0]);
    let all = fork(either, &[decision(5, false), decision(6, false)]);
    close(all, [0.0, 0.0, 0.3, 0.0, 0.1]);
}

/// A vessel that forks after a gap of 2.5 mm.
#[test]
fn both_daughters_of_a_bifurcation_are_accepted() {
    let here = folder();
    let (here, mut swc) = (here.path(), String::new());
    let mut id = 0;
    for (start, [x, y], length, radius) in
        [(0.0, [1.0, 0.0], 20.0, 1.5), (2.5, [0.866, 0.5], 15.0, 1.2), (2.5, [0.866, -0.5], 15.0, 1.1)]
    {
        let from = if start > 0.0 { 20.0 } else { 0.0 };
        for step in 0..=(2.0 * length) as i32 {
            let at = start + 0.5 * f64::from(step);
            let parent = if step > 0 { id } else { -1 };
            id += 1;
            writeln!(swc, "{id} 2 {} {} 0 {radius} {parent}", from + at * x, at * y).expect("written");
        }
    }
    fs::write(here.join("fork.swc"), swc).expect("written");
    let run = |out: &str, more: &[&str]| {
        let output = willis(here, &[&["infer", "fork.swc", "--inlet", "1", "-n", "16", "-q", "-o", out], more].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let edges =
            table(&here.join(out).join("edges.csv")).into_iter().filter(|row| row["kept"] == "1" && row["origin"] == "candidate");
        edges.map(|row| (row["edge"].clone(), row["probability"].parse().expect("P"))).collect::<Vec<(String, f64)>>()
    };
    let plain = run("plain", &[]);
    assert!(plain.len() == 2 && plain.iter().all(|(_, p)| *p > 0.9), "{plain:?}");
    let ids = table(&here.join("plain/nodes.csv")).into_iter().map(|row| row["id"].clone()).collect::<Vec<String>>();
    let edge = &table(&here.join("plain/edges.csv"))[plain[0].0.parse::<usize>().expect("a row")];
    let [a, b] = ["node_a", "node_b"].map(|end| &ids[edge[end].parse::<usize>().expect("a row")]);
    fs::write(here.join("one.csv"), format!("edge,id_a,id_b,decision\n{},{a},{b},accept\n", plain[0].0)).expect("written");
    let decided = run("decided", &["--decisions", "one.csv"]);
    assert!(decided[0].1 == 1.0 && decided.len() == 2 && decided[1].1 > 0.9, "{decided:?}");
    // Both are in nearly all topologies.
    let output = willis(here, &["measure", "plain", "-o", "measured", "-q"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let parts = table(&here.join("measured/intervals.csv")).into_iter().find(|row| row["figure"] == "parts").expect("parts");
    assert_eq!(
        (&*parts["value"], &*parts["low"], parts["mean"].parse::<f64>().expect("a mean") < 1.1),
        ("1", "1", true),
        "{parts:?}"
    );
}

#[test]
fn what_is_judged_one_by_one_keeps_half_beside_what_is_accepted_and_all_beside_what_is_rejected() {
    assert_eq!(decided(None, true), [[1.0, 0.15, 0.05, 0.4]; 2]);
    assert_eq!(decided(None, false), [[0.0, 0.3, 0.1, 0.4]; 2]);
}

/// By hand: the third candidate of an end is halved once, whether both others are accepted together or one in a graph where the other is certain.
#[test]
fn one_after_the_other_leaves_what_both_leave_together() {
    for lists in [&[&[4, 5][..]][..], &[&[4], &[5]], &[&[5], &[4]]] {
        let mut graph = graph(None);
        for rows in lists {
            apply(&mut graph, &rows.iter().map(|row| decision(*row, true)).collect::<Vec<_>>()).expect("applied");
        }
        let left: Vec<f64> = (4..8).map(|row| graph.vessel(row).evidence().expect("evidence").probability).collect();
        assert_eq!(left, [1.0, 1.0, 0.05, 0.4], "{lists:?}");
    }
}

/// Three vessels: two go on from the free end of the first, as well as from an end that a person did not decide on. A contact is no free end's.
#[test]
fn an_accepted_connection_uses_its_free_end_which_may_still_join_what_is_apart() {
    let kept = |joined: bool, second: Origin| {
        let mut graph = Network::new();
        for id in 0..6 {
            graph.add_node(Node { id: format!("n{id}"), ..Node::default() });
        }
        for ends in [[0, 1], [2, 3], [4, 5]] {
            graph.add_vessel(ends, Vessel::new(0.01, 0.001, Origin::Observed));
        }
        graph.add_vessel([1, 2], open(Origin::Candidate, 0.2));
        graph.add_vessel([1, 4], open(second, 0.9));
        if joined {
            graph.add_vessel([3, 5], Vessel::new(0.01, 0.001, Origin::Observed));
        }
        apply(&mut graph, &[decision(3, true)]).expect("applied");
        (reconnected(&graph, RECONNECT)[4], graph.vessel(4).evidence().expect("evidence").probability)
    };
    assert_eq!(kept(false, Origin::Candidate), (true, 0.45));
    assert_eq!(kept(true, Origin::Candidate), (false, 0.45));
    assert_eq!(kept(false, Origin::Contact), (true, 0.9));
}

/// A contact that joins two parts is put back by the rule for masks, unless a person rejected it.
#[test]
fn what_was_rejected_joins_no_parts() {
    let mut graph = Network::new();
    for id in 0..4 {
        graph.add_node(Node { id: format!("n{id}"), ..Node::default() });
    }
    graph.add_vessel([0, 1], Vessel::new(0.01, 0.001, Origin::Observed));
    graph.add_vessel([2, 3], Vessel::new(0.01, 0.001, Origin::Observed));
    let contact = Vessel { evidence: Some(Box::new(Evidence::undirected(0.2))), ..Vessel::new(0.001, 0.001, Origin::Contact) };
    graph.add_vessel([1, 2], contact);
    assert_eq!(reconnected(&graph, RECONNECT), [true, true, true]);
    apply(&mut graph, &[decision(2, false)]).expect("applied");
    assert_eq!(reconnected(&graph, RECONNECT), [true, true, false]);
}

/// The files of a run that hold no times and no names of folders.
fn answer(folder: &Path) -> Vec<Vec<u8>> {
    ["edges.csv", "nodes.csv", "topology.graphml"].map(|name| fs::read(folder.join(name)).expect(name)).to_vec()
}

/// The contacts of a junction lie in one place, where their nodes tell them apart.
#[test]
fn a_contact_whose_row_moved_is_found_by_its_nodes_and_never_another_one() {
    let here = folder();
    let here = here.path();
    let nodes = "node,x_mm,y_mm,z_mm\na,0,0,0\nb,20,0,0\nc,10,10,0\nj,10,0,0\nk,10,0,0\nl,10,0,0\n";
    let observed = "a,j,observed,10,1\nk,b,observed,10,1\nl,c,observed,10,1\n";
    let contacts = "j,k,contact,1,1\nj,l,contact,1,1\nk,l,contact,1,1\n";
    fs::write(here.join("g.nodes.csv"), nodes).expect("written");
    fs::write(here.join("g.csv"), format!("node_a,node_b,origin,length_mm,radius_mm\n{observed}{contacts}")).expect("written");
    let with = |ids: &str| {
        let list = format!("edge,id_a,id_b,decision,places\n999,{ids},reject,10 0 0 + 10 0 0\n");
        fs::write(here.join("decisions.csv"), list).expect("written");
        willis(here, &["infer", "g.csv", "-o", "out", "-n", "128", "--keep", "median", "--force", "--decisions", "decisions.csv"])
    };
    for (row, ids) in [(3, "j,k"), (5, "k,l"), (4, "l,j")] {
        let done = with(ids);
        assert!(done.status.success(), "{ids}: {}", stderr(&done));
        let rejected = table(&here.join("out/edges.csv")).iter().map(|row| row["prior"] == "0").collect::<Vec<_>>();
        assert_eq!(rejected, (0..6).map(|other| other == row).collect::<Vec<_>>(), "{ids}");
    }
    let done = with("x,y");
    assert!(done.status.code() == Some(2) && stderr(&done).contains("edge 999 (x to y)"), "{}", stderr(&done));
}

#[test]
fn edits_are_made_kept_and_replayed_to_the_same_bytes() {
    let here = folder();
    let here = here.path();
    infer(here, "plain", &[]);
    let (edges, nodes) = (table(&here.join("plain/edges.csv")), table(&here.join("plain/nodes.csv")));
    let place = |node: &str| {
        let node = &nodes[node.parse::<usize>().expect("a row")];
        ["x_mm", "y_mm", "z_mm"].map(|axis| node[axis].clone()).join(" ")
    };
    let ends = |row: usize| ["node_a", "node_b"].map(|name| place(&edges[row][name])).join(" + ");
    let candidate = edges.iter().position(|row| row["origin"] == "candidate" && row["kept"] == "0").expect("one");
    let observed = edges.iter().position(|row| row["origin"] == "observed").expect("one");
    // The row of the candidate is another one in the list, and its places tell which.
    let text = format!(
        "edge,id_a,id_b,decision,who,when,places\n999,x,y,accept,A. Reader,now,{}\n,,,delete,A. Reader,now,{}\n",
        ends(candidate),
        ends(observed).split(" + ").next().expect("a place")
    );
    fs::write(here.join("decisions.csv"), &text).expect("written");
    infer(here, "edited", &["--decisions", "decisions.csv"]);
    infer(here, "again", &["--decisions", "decisions.csv"]);
    assert_eq!(answer(&here.join("edited")), answer(&here.join("again")));
    let after = table(&here.join("edited/edges.csv"));
    assert_eq!((&*after[candidate]["kept"], &*after[candidate]["probability"]), ("1", "1"));
    let gone = (0..edges.len()).filter(|row| edges[*row]["origin"] == "observed" && after[*row]["kept"] == "0");
    assert_eq!(gone.count(), 1);
    let record: serde_json::Value =
        serde_json::from_slice(&fs::read(here.join("edited/run.json")).expect("a record")).expect("JSON");
    let edit = &record["parameters"]["decisions"]["edits"][0];
    assert!(edit["edit"].as_str().is_some_and(|text| text.starts_with("delete ")) && edit["who"] == "A. Reader", "{edit}");

    // Taken back, nothing is left of it; what means nothing here is named by its line.
    fs::write(here.join("decisions.csv"), text.lines().next().expect("a head").to_owned() + "\n").expect("written");
    infer(here, "back", &["--decisions", "decisions.csv"]);
    assert_eq!(answer(&here.join("plain")), answer(&here.join("back")));
    fs::write(here.join("decisions.csv"), "edge,id_a,id_b,decision,places\n,,,delete,900 900 900\n").expect("written");
    let output = willis(here, &["infer", &data("broken-circle-of-willis.swc"), "-o", "no", "-q", "--decisions", "decisions.csv"]);
    let said = stderr(&output);
    assert_eq!((output.status.code(), said.lines().count(), here.join("no").exists()), (Some(2), 1, false), "{said}");
    assert!(said.contains("decisions.csv:2: delete 900 900 900"), "{said}");
}

/// A vessel that was joined and then deleted is none, and what two lists say one after the other one list says. The outlets of both are at the ends
/// that are left, and side by side let 700 mL/min pass at 100 mmHg.
#[test]
fn one_list_is_two_lists_one_after_the_other() {
    let here = folder();
    let here = here.path();
    infer(here, "plain", &[]);
    let (edges, nodes) = (table(&here.join("plain/edges.csv")), table(&here.join("plain/nodes.csv")));
    let figure = |row: &Row, name: &str| row[name].parse::<f64>().expect(name);
    let ends = |row: &Row| ["node_a", "node_b"].map(|name| row[name].parse::<usize>().expect("a row"));
    let place = |node: usize| ["x_mm", "y_mm", "z_mm"].map(|axis| figure(&nodes[node], axis));
    let text = |at: [f64; 3]| at.map(|x| x.to_string()).join(" ");
    let observed = || edges.iter().filter(|row| row["origin"] == "observed").map(ends);
    let degree = |node: usize| observed().flatten().filter(|end| *end == node).count();
    // The last vessel of an artery, before which no other branches off.
    let last = observed().flat_map(|[a, b]| [[a, b], [b, a]]).find(|ends| ends.map(degree) == [1, 2]);
    let [tip, before] = last.expect("one");
    let far = |row: &&Row| row["origin"] == "candidate" && figure(row, "length_mm") > 4.0 && !ends(row).contains(&tip);
    let [a, b] = ends(edges.iter().find(far).expect("one")).map(place);
    let middle = [0, 1, 2].map(|axis| f64::midpoint(a[axis], b[axis]));
    let edits =
        [format!("join,{} + {}", text(a), text(b)), format!("delete,{}", text(middle)), format!("delete,{}", text(place(tip)))];
    for (name, edits) in [("all.csv", &edits[..]), ("first.csv", &edits[..1]), ("others.csv", &edits[1..])] {
        let rows: Vec<String> = edits.iter().map(|edit| format!(",,,{edit}\n")).collect();
        fs::write(here.join(name), format!("edge,id_a,id_b,decision,places\n{}", rows.concat())).expect("written");
    }
    infer(here, "one", &["--decisions", "all.csv"]);
    infer(here, "begun", &["--decisions", "first.csv"]);
    let words = ["infer", "begun/candidates.graphml", "-o", "two", "-n", "128", "-q", "--decisions", "others.csv"];
    assert!(willis(here, &words).status.success());
    let [one, two] = ["one", "two"].map(|run| table(&here.join(run).join("edges.csv")));
    let joined = &one[edges.len()];
    assert_eq!((one.len(), &*joined["probability"], &*joined["kept"]), (edges.len() + 1, "0", "0"));
    let same = |a: &Row, b: &Row| {
        let close = (figure(a, "likelihood") - figure(b, "likelihood")).abs() <= 1e-6 * figure(a, "likelihood");
        close && ["prior", "probability", "kept", "frequency"].iter().all(|name| a[*name] == b[*name])
    };
    assert!(one.len() == two.len() && one.iter().zip(&two).all(|(a, b)| same(a, b)));
    for run in ["one", "two"] {
        let record = fs::read(here.join(run).join("run.json")).expect("a record");
        let record: serde_json::Value = serde_json::from_slice(&record).expect("JSON");
        let conditions = record["boundary_conditions"].as_array().expect("a list");
        let has = |node: usize| conditions.iter().any(|condition| condition["node"] == node);
        assert_eq!([tip, before].map(has), [false, true], "{run}");
        let resistance = |condition: &serde_json::Value| condition["resistance_mmHg_s_per_mL"].as_f64();
        let conducts: f64 = conditions.iter().filter_map(resistance).map(f64::recip).sum();
        assert!((conducts * 60.0 * 100.0 - 700.0).abs() < 1e-6, "{run}: {conducts}");
    }
}

/// Pairs of answers by a table of counts.
fn answers(table: &[&[usize]]) -> Vec<[usize; 2]> {
    let cells = table.iter().enumerate().flat_map(|(a, row)| row.iter().enumerate().map(move |(b, n)| (a, b, *n)));
    cells.flat_map(|(a, b, n)| std::iter::repeat_n([a, b], n)).collect()
}

/// Kappa by scikit-learn 1.7 (`cohen_kappa_score`), its interval by statsmodels 0.14 (`cohens_kappa`). The first by hand: p_o = 35/50,
/// p_e = .5·.6 + .5·.4 = .5, so κ = .2/.5; the third: p_o = 8/12, p_e = (6·5 + 4·5 + 2·2)/144 = 3/8, so κ = 7/15.
#[test]
fn kappa_is_that_of_scikit_learn() {
    let known: [(&[&[usize]], [f64; 3]); 4] = [
        (&[&[20, 5], &[10, 15]], [0.4, 0.151_092_290_476_661, 0.648_907_709_523_338_9]),
        (&[&[44, 5, 1], &[7, 20, 3], &[9, 5, 6]], [0.491_525_423_728_813_6, 0.350_158_201_217_486_86, 0.632_892_646_240_140_1]),
        (&[&[4, 1, 1], &[1, 3, 0], &[0, 1, 1]], [7.0 / 15.0, 0.052_267_845_466_458_96, 0.881_065_487_866_874_2]),
        (&[&[3, 0, 0], &[0, 2, 0], &[0, 0, 0]], [1.0, 1.0, 1.0]),
    ];
    for (table, truth) in known {
        let pairs = answers(table);
        let found = cohen_kappa(&pairs, table.len());
        let [low, high] = found.interval;
        for (x, truth) in [found.kappa, low, high].into_iter().zip(truth) {
            assert!((x - truth).abs() < 1e-12, "{table:?}: {found:?}");
        }
        assert_eq!((found.count, found.alike), (pairs.len(), (0..table.len()).map(|i| table[i][i]).sum()));
    }
    // Chance alone makes the same of one answer only.
    assert!(cohen_kappa(&answers(&[&[7, 0, 0], &[0, 0, 0], &[0, 0, 0]]), 3).kappa.is_nan());
    assert!(cohen_kappa(&[], 3).kappa.is_nan());
}

/// Two readers of one run who answer as in the third table above, and one question each that the other left out.
#[test]
fn two_readers_of_a_run_are_compared() {
    let here = folder();
    let here = here.path();
    infer(here, "run", &[]);
    let (edges, nodes) = (table(&here.join("run/edges.csv")), table(&here.join("run/nodes.csv")));
    let candidates: Vec<usize> = (0..edges.len()).filter(|row| edges[*row]["origin"] == "candidate").take(14).collect();
    let id = |row: usize, end: &str| &nodes[edges[row][end].parse::<usize>().expect("a row")]["id"];
    let words = ["accept", "reject", "unsure"];
    let pairs = answers(&[&[4, 1, 1], &[1, 3, 0], &[0, 1, 1]]);
    let made = |reader: usize| -> String {
        let line = |row: usize, word: &str| format!("{row},{},{},{word},R{reader},why\n", id(row, "node_a"), id(row, "node_b"));
        let both: String = pairs.iter().zip(&candidates).map(|(pair, row)| line(*row, words[pair[reader]])).collect();
        format!("edge,id_a,id_b,decision,who,comment\n{both}{}", line(candidates[12 + reader], "accept"))
    };
    for (reader, name) in ["run-a.csv", "run-b.csv"].into_iter().enumerate() {
        fs::write(here.join(name), made(reader)).expect("written");
    }
    let output = willis(here, &["measure", "run", "-o", "out", "--reader", "{}-a.csv", "--reader", "{}-b.csv"]);
    assert!(output.status.success() && stderr(&output).contains("8 of 12 decisions alike, kappa 0.47"), "{}", stderr(&output));
    let found = table(&here.join("out/readers.csv"));
    assert_eq!(found.iter().map(|row| &*row["kind"]).collect::<Vec<_>>(), ["candidate", "all"]);
    for row in &found {
        let of = |name: &str| row[name].parse::<f64>().expect("a number");
        assert!((of("kappa") - 7.0 / 15.0).abs() < 1e-12 && (of("kappa_low") - 0.052_267_845_466_458_96).abs() < 1e-12);
        let counts = ["decided", "alike", "accept_accept", "accept_unsure", "reject_accept", "unsure_accept", "only_a", "only_b"];
        assert_eq!(counts.map(of), [12.0, 8.0, 4.0, 1.0, 1.0, 0.0, 1.0, 1.0]);
    }
    let differ = table(&here.join("out/differences.csv"));
    let truth: Vec<(usize, &str, &str)> = pairs
        .iter()
        .zip(&candidates)
        .filter(|([a, b], _)| a != b)
        .map(|([a, b], row)| (*row, words[*a], words[*b]))
        .chain([(candidates[12], "accept", ""), (candidates[13], "", "accept")])
        .collect();
    let listed = |row: &Row| (row["edge"].parse::<usize>().expect("a row"), row["decision_a"].clone(), row["decision_b"].clone());
    let said: Vec<_> = differ.iter().map(listed).collect();
    assert_eq!(said, truth.iter().map(|(row, a, b)| (*row, (*a).to_owned(), (*b).to_owned())).collect::<Vec<_>>());
    assert!(differ.iter().all(|row| row["id_a"] == *id(row["edge"].parse().expect("a row"), "node_a")));
    assert_eq!((&*differ[0]["who_a"], &*differ[0]["who_b"], &*differ[0]["comment_b"]), ("R0", "R1", "why"));
    // The folder is one of its own, which the same command replaces.
    let again = willis(here, &["measure", "run", "-o", "out", "--reader", "{}-a.csv", "--reader", "{}-b.csv", "--force"]);
    assert!(again.status.success(), "{}", stderr(&again));
    fs::write(here.join("run-b.csv"), made(1).replacen(&candidates[0].to_string(), "99999", 1)).expect("written");
    for (words, why) in [
        (&["run", "--reader", "run-a.csv"][..], "--reader run-a.csv: expected two of them"),
        (&["run", "--reader", "run-a.csv", "--reader", "run-b.csv"], "run-b.csv:2: edge 99999"),
        (&["run/topology.graphml", "--reader", "run-a.csv", "--reader", "run-a.csv"], "no run, so nobody decided on it"),
    ] {
        let output = willis(here, &[&["measure", "-o", "bad"], words].concat());
        assert!(output.status.code() == Some(2) && stderr(&output).contains(why), "{}", stderr(&output));
        assert!(!here.join("bad").exists());
    }
}

/// What a contact hangs by is no share of its probability, and is read as it was written.
#[test]
fn an_unedited_graph_of_a_mask_gives_the_answer_of_the_mask() {
    let here = folder();
    let mask = data("scan.nii.gz");
    let keep = ["--keep", "reconnect=0.5", "-n", "64", "-q"];
    for arguments in [
        &["candidates", &mask, "-o", "graph.graphml", "-q"][..],
        &[&["infer", &mask, "-o", "mask"], &keep[..]].concat(),
        &[&["infer", "graph.graphml", "-o", "graph"], &keep[..]].concat(),
    ] {
        let output = willis(here.path(), arguments);
        assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    }
    let edges = |run: &str| fs::read_to_string(here.path().join(run).join("edges.csv")).expect("read");
    assert!(edges("mask").contains(",contact,"));
    assert_eq!(edges("graph"), edges("mask"));
}

/// The rows of candidates with P of one half and more, in a run of the broken circle.
fn probable(here: &Path, run: &str) -> Vec<usize> {
    let edges = table(&here.join(run).join("edges.csv"));
    let is_probable = |row: &Row| row["probability"].parse::<f64>().is_ok_and(|p| p >= 0.5);
    (0..edges.len()).filter(|row| is_probable(&edges[*row])).collect()
}

/// Writes the graph of a run anew with a text in these edges, and infers from it.
fn changed(here: &Path, rows: &[usize], out: &str, change: impl Fn(&str) -> String) -> Vec<Row> {
    let graph = fs::read_to_string(here.join("run/candidates.graphml")).expect("a graph");
    let mut parts: Vec<String> = graph.split("<edge ").map(str::to_owned).collect();
    let key = "<key id=\"certain\" for=\"edge\" attr.name=\"certain\" attr.type=\"boolean\"/><key ";
    parts[0] = parts[0].replacen("<key ", key, 1);
    for row in rows {
        parts[row + 1] = change(&parts[row + 1]);
    }
    fs::write(here.join("graph.graphml"), parts.join("<edge ")).expect("written");
    let output = willis(here, &["infer", "graph.graphml", "-o", out, "-n", "128", "-q"]);
    assert!(output.status.success(), "{}", stderr(&output));
    table(&here.join(out).join("edges.csv"))
}

/// Other places of the same connection are no loops that are open.
#[test]
fn what_is_marked_certain_in_a_graph_is_accepted() {
    let here = folder();
    let here = here.path();
    infer(here, "run", &[]);
    let rows = probable(here, "run");
    let marked = changed(here, &rows, "marked", |edge| edge.replacen('>', "><data key=\"certain\">true</data>", 1));
    let (edges, nodes) = (table(&here.join("run/edges.csv")), table(&here.join("run/nodes.csv")));
    let id = |row: usize, end: &str| &nodes[edges[row][end].parse::<usize>().expect("a row")]["id"];
    let lines = rows.iter().map(|row| format!("{row},{},{},accept\n", id(*row, "node_a"), id(*row, "node_b")));
    fs::write(here.join("accept.csv"), format!("edge,id_a,id_b,decision\n{}", lines.collect::<String>())).expect("written");
    infer(here, "accepted", &["--decisions", "accept.csv"]);
    let accepted = table(&here.join("accepted/edges.csv"));
    assert!(rows.len() > 3 && rows.iter().all(|row| marked[*row]["kept"] == "1"), "{rows:?}");
    for (row, (a, b)) in marked.iter().zip(&accepted).enumerate() {
        assert_eq!((&a["probability"], &a["prior"], &a["kept"]), (&b["probability"], &b["prior"], &b["kept"]), "{row}");
    }
}

/// A is the probability of a candidate, and what it hangs by are shares of it.
#[test]
fn samples_go_by_a_probability_that_is_changed_in_a_graph() {
    let here = folder();
    let here = here.path();
    infer(here, "run", &[]);
    let edges = table(&here.join("run/edges.csv"));
    let rows = probable(here, "run");
    let row = rows[0];
    let p = edges[row]["probability"].clone();
    let halved = (p.parse::<f64>().expect("P") / 2.0).to_string();
    let graph = fs::read_to_string(here.join("run/candidates.graphml")).expect("a graph");
    let key = |name: &str| {
        let at = graph.find(&format!("attr.name=\"{name}\" attr.type=\"double\"")).expect("a key");
        graph[..at].rsplit('"').nth(3).expect("an id").to_owned()
    };
    let key = key("probability");
    let field = |value: &str| format!("<data key=\"{key}\">{value}</data>");
    let found = changed(here, &[row], "halved", |edge| edge.replace(&field(&p), &field(&halved)));
    assert_eq!((&found[row]["probability"], &found[row]["prior"]), (&halved, &halved));
    let others = (0..edges.len()).filter(|other| *other != row);
    others.for_each(|other| assert_eq!(found[other]["prior"], edges[other]["prior"], "{other}"));
}
