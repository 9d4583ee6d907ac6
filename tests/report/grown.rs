//! A made-up vascular tree in space, with candidates between nodes that are near: a ready graph of any size, as CSV.

use std::fmt::Write;

use crate::draw::Draw;

/// nodes.csv and edges.csv of a tree with so many vessels: two in three observed, one in three a candidate. The first labels
/// go to the first vessels.
pub fn grown(vessels: usize, labels: &[&str]) -> (String, String) {
    let mut draw = Draw::new(5);
    let observed = vessels * 2 / 3;
    let mut places = vec![[0.0_f64; 3]];
    let mut parents = vec![0];
    let (mut nodes, mut edges) = (String::from("node,id,x_mm,y_mm,z_mm\n0,0,0,0,0\n"), String::from(HEADER));
    for node in 1..=observed {
        // Two branches a node: parents in rising order make an even tree.
        let parent = (node - 1) / 2;
        let step = [(); 3].map(|()| draw.within(-4.0, 4.0));
        let place = [0, 1, 2].map(|axis| places[parent][axis] * 1.15 + step[axis]);
        places.push(place);
        parents.push(parent);
        writeln!(nodes, "{node},{node},{},{},{}", place[0], place[1], place[2]).unwrap();
        let radius = draw.within(0.8, 1.0) * 2.0 / (1.0 + node as f64).powf(0.2);
        writeln!(edges, "{parent},{node},{radius},observed,{}", quoted(labels.get(node - 1))).unwrap();
    }
    for _ in observed..vessels {
        let node = 3 + draw.below(observed - 2);
        let near = parents[parents[node - draw.below(2)]] + draw.below(2);
        let (near, radius) = (if near == node { 0 } else { near }, draw.within(0.1, 0.6));
        writeln!(edges, "{node},{near},{radius},candidate,").unwrap();
    }
    (nodes, edges)
}

const HEADER: &str = "node_a,node_b,radius_mm,origin,label\n";

fn quoted(label: Option<&&str>) -> String {
    label.map_or_else(String::new, |text| format!("\"{}\"", text.replace('"', "\"\"")))
}
