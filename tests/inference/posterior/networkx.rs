//! Arborescences as NetworkX finds them. Needs `WILLIS_PYTHON`.

use std::process::Command;

use willis::internals::forest_posterior::{Edge, Forests, arborescence};

use crate::draw::Draw;

const SCRIPT: &str = r#"
import json, sys
import networkx as nx

cases = json.load(open(sys.argv[1]))
for case in cases:
    n, best, graph = len(case["roots"]), {}, nx.DiGraph()
    for row, (child, parent, score) in enumerate(case["bridges"]):
        key = parent, child
        if key not in best or score > case["bridges"][best[key]][2]:
            best[key] = row
    graph.add_weighted_edges_from((p, c, case["bridges"][row][2]) for (p, c), row in best.items())
    graph.add_weighted_edges_from((n, c, score) for c, score in enumerate(case["roots"]))
    tree = nx.maximum_spanning_arborescence(graph)
    value = sum(graph.edges[e]["weight"] for e in tree.edges)
    kept = [None] * n
    for p, c in tree.edges:
        if p != n:
            kept[c] = best[p, c]
    own = sum(case["roots"][c] if row is None else case["bridges"][row][2] for c, row in enumerate(case["kept"]))
    assert abs(own - value) <= 1e-9 * max(1, abs(value)), (own, value, case)
    assert case["ties"] or kept == case["kept"], (kept, case)
print(len(cases))
"#;

#[test]
fn the_arborescence_is_that_of_networkx() {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python with tests/requirements.txt");
        return;
    };
    let mut draw = Draw::new(9);
    let cases: Vec<serde_json::Value> = (0..300)
        .map(|round| {
            let (fragments, ties) = (2 + draw.below(if round < 280 { 12 } else { 60 }), round % 3 == 0);
            let score = |draw: &mut Draw| if ties { draw.below(5) as f64 } else { draw.within(-1.0, 1.0) };
            let roots: Vec<f64> = (0..fragments).map(|_| score(&mut draw)).collect();
            let mut bridges = Vec::new();
            for _ in 0..draw.below(6 * fragments) {
                let (child, parent) = (draw.below(fragments), draw.below(fragments));
                if child != parent {
                    bridges.push((child, parent, score(&mut draw)));
                }
            }
            let scores: Vec<f64> = bridges.iter().map(|b| b.2).collect();
            let plain = bridges.iter().map(|b| Edge { child: b.0, parent: b.1, log_weight: 0.0 }).collect();
            let kept = arborescence(&Forests::new(vec![0.0; fragments], plain).unwrap(), &scores, &roots);
            serde_json::json!({ "roots": roots, "bridges": bridges, "kept": kept, "ties": ties })
        })
        .collect();
    let here = tempfile::tempdir().expect("a temporary folder");
    let path = here.path().join("cases.json");
    std::fs::write(&path, serde_json::to_vec(&cases).unwrap()).unwrap();
    let output = Command::new(python).args(["-c", SCRIPT]).arg(&path).output().expect("runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "300");
}
