//! Edits of a graph by places: each on a graph drawn by hand, whose right answer can be counted.

use willis::internals::formats::{ReadOptions, graph_columns, read_graphml, write_graphml};
use willis::internals::network::{Edit, Evidence, GraphEditor, Network, Node, Origin, Vessel, fragments};

/// A network of straight vessels between nodes at these places (mm), with radii of 0.5 mm.
fn drawn(places: &[[f64; 3]], vessels: &[[usize; 2]]) -> Network {
    let mut graph = Network::new();
    for (id, place) in places.iter().enumerate() {
        graph.add_node(Node { id: id.to_string(), position: Some(place.map(|x| 1e-3 * x)), ..Node::default() });
    }
    for ends in vessels {
        let [a, b] = ends.map(|node| places[node]);
        let length = (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt();
        graph.add_vessel(*ends, Vessel::new(1e-3 * length, 5e-4, Origin::Observed));
    }
    graph
}

fn edited(graph: Network, text: &str) -> Result<Network, String> {
    let mut editor = GraphEditor::new(graph);
    editor.edit(&Edit::try_from(text.to_owned())?)?;
    Ok(editor.finish())
}

/// A file holds an edited graph to the last bit.
#[test]
fn an_edited_graph_is_the_same_once_it_was_written() {
    let graph = edited(crossing(), "part 2.3 0.54 0 + 9.7 0.46 0 | 2.6 -0.48 0 + 9.1 -0.58 0").expect("edited");
    let (nodes, vessels) = graph_columns(&graph);
    let mut bytes = Vec::new();
    write_graphml(&mut bytes, &graph, &nodes, &vessels).expect("written");
    let (again, _) = read_graphml(&bytes[..], &ReadOptions::default()).expect("read");
    let lengths = |graph: &Network| graph.vessels().map(|(_, vessel)| (vessel.length, vessel.radius)).collect::<Vec<_>>();
    let places = |graph: &Network| graph.nodes().map(|node| node.position).collect::<Vec<_>>();
    assert_eq!((lengths(&graph), places(&graph)), (lengths(&again), places(&again)));
}

fn is_there(vessel: &Vessel) -> bool {
    vessel.origin == Origin::Observed || vessel.certain
}

/// Which of some nodes are connected by what is there: per node the first node of its part.
fn parts(graph: &Network, nodes: &[usize]) -> Vec<usize> {
    let of = fragments(graph, |_, vessel| is_there(vessel)).of_node;
    nodes.iter().map(|node| *nodes.iter().find(|other| of[**other] == of[*node]).expect("itself")).collect()
}

/// The length of what is there, mm.
fn length(graph: &Network) -> f64 {
    1e3 * graph.vessels().filter(|(_, vessel)| is_there(vessel)).map(|(_, vessel)| vessel.length).sum::<f64>()
}

/// Two vessels, 0 to 2 and 1 to 3, that share the stretch of 2 mm from 4 to 5.
fn crossing() -> Network {
    let places = [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [12.0, 1.0, 0.0], [12.0, -1.0, 0.0], [5.0, 0.0, 0.0], [7.0, 0.0, 0.0]];
    drawn(&places, &[[0, 4], [1, 4], [4, 5], [5, 2], [5, 3]])
}

#[test]
fn a_stretch_of_two_vessels_is_doubled() {
    let before = length(&crossing());
    let straight = edited(crossing(), "part 2.5 0.5 0 + 9.5 0.5 0 | 2.5 -0.5 0 + 9.5 -0.5 0").expect("edited");
    assert_eq!(parts(&straight, &[0, 1, 2, 3]), [0, 1, 0, 1]);
    let crossed = edited(crossing(), "part 2.5 0.5 0 + 9.5 -0.5 0 | 2.5 -0.5 0 + 9.5 0.5 0").expect("edited");
    assert_eq!(parts(&crossed, &[0, 1, 2, 3]), [0, 1, 1, 0]);
    for graph in [straight, crossed] {
        // Four legs are divided, and one stretch comes twice.
        assert_eq!((graph.vessel_count(), graph.node_count()), (10, 6 + 4 + 2));
        assert!((length(&graph) - before - 2.0).abs() < 1e-9);
        for (row, node) in [(0, 0), (1, 1)] {
            assert_eq!(graph.ends(row)[0], node, "a row keeps its first node");
        }
    }
}

#[test]
fn a_group_of_three_keeps_its_junction_and_one_place_is_cut_off() {
    let fork = drawn(&[[0.0, 0.0, 0.0], [8.0, 3.0, 0.0], [8.0, -3.0, 0.0], [4.0, 0.0, 0.0]], &[[0, 3], [3, 1], [3, 2]]);
    let cut = edited(fork.clone(), "part 6 1.5 0 + 2 0 0 | 6 -1.5 0").expect("edited");
    assert_eq!(parts(&cut, &[0, 1, 2]), [0, 0, 2]);
    assert!((length(&fork) - length(&cut) - 2.5).abs() < 1e-9, "the way from the junction to the place is gone");
    let five = [[-4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [4.0, -4.0, 0.0], [0.0, 4.0, 0.0], [0.0, -4.0, 0.0], [0.0, 0.0, 0.0]];
    let star = drawn(&five, &[[0, 5], [1, 5], [2, 5], [3, 5], [4, 5]]);
    let parted = edited(star, "part -2 0 0 + 2 2 0 + 2 -2 0 | 0 2 0 + 0 -2 0").expect("edited");
    assert_eq!(parts(&parted, &[0, 1, 2, 3, 4]), [0, 0, 0, 3, 3]);
}

#[test]
fn rungs_between_two_rails_go() {
    let mut places: Vec<[f64; 3]> = Vec::new();
    for x in [0.0, 4.0, 5.0, 6.0, 10.0] {
        places.extend([[x, 0.5, 0.0], [x, -0.5, 0.0]]);
    }
    let rails = (0..8).map(|node| [node, node + 2]);
    let vessels: Vec<[usize; 2]> = rails.chain([[2, 3], [4, 5], [6, 7]]).collect();
    let parted = edited(drawn(&places, &vessels), "part 2 0.5 0 + 8 0.5 0 | 2 -0.5 0 + 8 -0.5 0").expect("edited");
    assert_eq!(parts(&parted, &[0, 8, 1, 9]), [0, 0, 1, 1]);
    assert!((length(&parted) - 20.0).abs() < 1e-9);
}

#[test]
fn groups_share_no_stretch_where_each_has_one_of_its_own() {
    // A vessel with a bow of 10 mm beside a straight one, and two rungs, so that the way over these is shorter.
    let bow = [[0.0, 1.0, 0.0], [4.0, 1.0, 0.0], [4.0, 4.0, 0.0], [8.0, 4.0, 0.0], [8.0, 1.0, 0.0], [12.0, 1.0, 0.0]];
    let straight = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [8.0, 0.0, 0.0], [12.0, 0.0, 0.0]];
    let places: Vec<[f64; 3]> = bow.into_iter().chain(straight).collect();
    let graph = drawn(&places, &[[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [6, 7], [7, 8], [8, 9], [1, 7], [4, 8]]);
    for text in ["part 1 1 0 + 11 1 0 | 1 0 0 + 11 0 0", "part 1 0 0 + 11 0 0 | 1 1 0 + 11 1 0"] {
        let parted = edited(graph.clone(), text).expect("edited");
        assert_eq!(parts(&parted, &[0, 5, 6, 9]), [0, 0, 6, 6]);
        assert_eq!([8, 9].map(|rung| is_there(parted.vessel(rung))), [false; 2]);
        assert!((length(&graph) - length(&parted) - 2.0).abs() < 1e-9, "nothing but the rungs goes, and nothing is doubled");
    }
}

#[test]
fn a_contact_on_the_way_is_one_vessel_for_each_group() {
    let places = [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [4.0, 0.0, 0.0], [4.5, 0.0, 0.0], [8.0, 1.0, 0.0], [8.0, -1.0, 0.0]];
    let mut graph = drawn(&places, &[[0, 2], [1, 2], [3, 4], [3, 5]]);
    let contact =
        Vessel { prior: 0.3, evidence: Some(Box::new(Evidence::undirected(0.3))), ..Vessel::new(5e-4, 5e-4, Origin::Contact) };
    graph.add_vessel([2, 3], contact);
    let parted = edited(graph.clone(), "part 2 0.5 0 + 6 0.5 0 | 2 -0.5 0 + 6 -0.5 0").expect("edited");
    assert_eq!(parts(&parted, &[0, 1, 4, 5]), [0, 1, 0, 1]);
    let contacts = parted.vessels().filter(|(_, v)| v.origin == Origin::Contact && v.certain && v.prior >= 1.0);
    assert_eq!(contacts.count(), 2);
    let apart = edited(graph, "part 2 0.5 0 + 2 -0.5 0 | 6 0.5 0 + 6 -0.5 0").expect("edited");
    let rejected = apart.vessel(4);
    assert_eq!((rejected.prior, rejected.certain, rejected.evidence().map(|e| e.probability)), (0.0, false, Some(0.0)));
}

#[test]
fn a_join_divides_what_it_ends_on_and_a_deleted_vessel_keeps_its_row() {
    let two = drawn(&[[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [5.0, 2.0, 0.0], [5.0, 8.0, 0.0]], &[[0, 1], [2, 3]]);
    let joined = edited(two.clone(), "join 5 0 0 + 5 2 0").expect("edited");
    assert_eq!((joined.vessel_count(), joined.node_count()), (4, 5));
    let join = joined.vessel(3);
    assert!((join.origin, joined.ends(3)[1]) == (Origin::Candidate, 2) && (join.length - 2e-3).abs() < 1e-12);
    assert!((joined.vessel(0).length - 5e-3).abs() < 1e-12 && (joined.vessel(2).length - 5e-3).abs() < 1e-12);
    let by = edited(two.clone(), "join 5 0 0 + 5 1 1 + 5 2 0").expect("edited");
    assert!((by.vessel(3).length - 2e-3 * f64::sqrt(2.0)).abs() < 1e-12 && by.vessel(3).path.len() == 3);
    let deleted = edited(two, "delete 5 5 0").expect("edited");
    assert_eq!((deleted.vessel(1).origin, deleted.vessel(1).prior, deleted.ends(1)), (Origin::Candidate, 0.0, [2, 3]));
    assert!((length(&deleted) - 10.0).abs() < 1e-9);
}

#[test]
fn a_group_that_nothing_joins_is_joined_by_a_straight_vessel() {
    let two = drawn(&[[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 5.0, 0.0], [10.0, 5.0, 0.0]], &[[0, 1], [2, 3]]);
    let parted = edited(two, "part 2 0 0 + 8 5 0 | 8 0 0").expect("edited");
    assert_eq!(parts(&parted, &[0, 1, 2, 3]), [0, 1, 0, 0]);
    let straight = parted.vessels().filter(|(_, v)| v.certain && v.origin == Origin::Candidate).map(|(_, v)| v.length);
    assert_eq!(straight.map(|length| (length * 1e6).round()).collect::<Vec<f64>>(), [f64::sqrt(61.0) * 1e3].map(f64::round));
}

/// The ends of a bend, 2 mm apart, and a vessel that leaves it half way: the ends go together along the bend, unless that is a detour.
#[test]
fn two_places_go_together_by_no_detour() {
    let length_of_join = |bend: f64| {
        let places = [[0.0; 3], [bend, 0.0, 0.0], [bend, 2.0, 0.0], [0.0, 2.0, 0.0], [bend + 5.0, 1.0, 0.0]];
        let graph = drawn(&places, &[[0, 1], [1, 2], [2, 3], [1, 4]]);
        let graph = edited(graph, &format!("part 0 0 0 + 0 2 0 | {} 1 0", bend + 5.0)).expect("edited");
        assert_eq!(parts(&graph, &[0, 3, 4]), [0, 0, 4], "{bend}");
        graph.vessels().find(|(_, vessel)| vessel.certain).map(|(_, vessel)| (1e3 * vessel.length).round())
    };
    assert_eq!([2.0, 3.5, 4.5, 10.0].map(length_of_join), [None, None, Some(2.0), Some(2.0)]);
}

#[test]
fn an_edit_sees_the_vessels_of_those_before_it() {
    let places = [[0.0, 1.0, 0.0], [4.0, 1.0, 0.0], [8.0, 1.0, 0.0], [12.0, 1.0, 0.0], [0.0, -1.0, 0.0], [12.0, -1.0, 0.0]];
    let gap = drawn(&places, &[[0, 1], [2, 3], [4, 5]]);
    let before = length(&gap);
    let mut editor = GraphEditor::new(gap);
    for edit in ["join 4 1 0 + 8 1 0", "part 2 1 0 + 10 1 0 | 2 -1 0 + 10 -1 0"] {
        editor.edit(&Edit::try_from(edit.to_owned()).expect("an edit")).expect("edited");
    }
    let graph = editor.finish();
    assert!((length(&graph) - before - 4.0).abs() < 1e-9, "the join alone is new");
    assert_eq!(parts(&graph, &[0, 3, 4, 5]), [0, 0, 4, 4]);
}

#[test]
fn a_later_edit_finds_each_of_two_vessels_that_lie_on_each_other() {
    let first = "part 2.5 0.5 0 + 9.5 0.5 0 | 2.5 -0.5 0 + 9.5 -0.5 0";
    for second in ["part 5.5 0 0 + 9 0.4 0 | 6 0 0 + 9 -0.4 0", "part 6 0 0 + 9 -0.4 0 | 9 0.4 0 + 5.5 0 0"] {
        let mut editor = GraphEditor::new(crossing());
        for edit in [first, second] {
            editor.edit(&Edit::try_from(edit.to_owned()).expect("an edit")).expect("edited");
        }
        let graph = editor.finish();
        assert_eq!(parts(&graph, &[0, 1, 2, 3]), [0, 1, 0, 1]);
        assert!((length(&graph) - length(&crossing()) - 2.0).abs() < 1e-9, "no way is new");
    }
}

#[test]
fn a_candidate_that_is_likely_is_a_way_and_one_between_two_groups_goes() {
    // A vessel from 0 that a rung of 2 mm joins to one that ends at 3, and goes on at 4 behind a gap.
    let places = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 2.0, 0.0], [6.0, 2.0, 0.0], [7.5, 2.0, 0.0], [12.0, 2.0, 0.0]];
    let mut graph = drawn(&places, &[[0, 1], [1, 2], [2, 3], [4, 5]]);
    let candidate = |p: f64| Vessel {
        prior: p,
        evidence: Some(Box::new(Evidence::undirected(p))),
        ..Vessel::new(1.5e-3, 5e-4, Origin::Candidate)
    };
    graph.add_vessel([3, 4], candidate(0.75));
    graph.add_vessel([1, 4], candidate(0.1));
    let parted = edited(graph.clone(), "part 0.5 0 0 | 7.6 2 0").expect("edited");
    assert_eq!(
        [1, 2].map(|row| is_there(parted.vessel(row))),
        [false, true],
        "the rung, which is nearest to the centre, is deleted"
    );
    assert_eq!([4, 5].map(|row| parted.vessel(row).prior), [0.75, 0.1]);
    let parted = edited(graph, "part 1 0 0 + 4 0 0 | 9 2 0 + 7.5 2 0").expect("edited");
    assert_eq!(parted.vessel(5).prior, 0.0, "it joins both groups");
}

#[test]
fn groups_meet_beyond_their_places_and_where_they_share_one() {
    // A ladder of two rungs: the first is between the places of both, the second beyond them.
    let places = [[0.0, 1.0, 0.0], [4.0, 1.0, 0.0], [8.0, 1.0, 0.0], [0.0, -1.0, 0.0], [4.0, -1.0, 0.0], [8.0, -1.0, 0.0]];
    let ladder = drawn(&places, &[[0, 1], [1, 2], [3, 4], [4, 5], [1, 4], [2, 5]]);
    let parted = edited(ladder, "part 2 1 0 + 7 1 0 | 2 -1 0 + 7 -1 0").expect("edited");
    assert_eq!([4, 5].map(|rung| is_there(parted.vessel(rung))), [false, true]);
    // Two vessels along one line from the fork at 4 on: they part at 5, and meet at the fork.
    let shared = edited(crossing(), "part 0 1 0 + 5 0 0 + 12 1 0 | 5 0 0 + 12 -1 0").expect("edited");
    assert_eq!(shared.vessels().filter(|(ends, v)| is_there(v) && ends.contains(&4)).count(), 4);
    assert!((length(&shared) - length(&crossing()) - 2.0).abs() < 1e-9);
    // A place of one group on the way of another is of both ways, and they stay apart.
    let line = drawn(&[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [8.0, 0.0, 0.0], [4.0, 3.0, 0.0]], &[[0, 1], [1, 2], [1, 3]]);
    let apart = edited(line, "part 1 0 0 + 7 0 0 | 4 0 0").expect("edited");
    assert_eq!(parts(&apart, &[0, 2]), [0, 0]);
    assert_eq!(parts(&apart, &[0, 3]), [0, 3]);
}

#[test]
fn what_cannot_be_made_says_why() {
    let two = || drawn(&[[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 5.0, 0.0], [10.0, 5.0, 0.0]], &[[0, 1], [2, 3]]);
    for (text, why) in [
        ("delete 5 20 0", "15.0 mm from the nearest vessel"),
        ("join 5 0 0 + 5 0 0", "both ends are one place"),
        ("part 1 0 0 + 1 0 0 | 2 0 0", "two places of a group are at one node"),
        ("part 1 0 0 + 9 0 0", "two or more groups"),
        ("join 1 0 0", "two places"),
        ("delete 1 0 x", "finite numbers"),
        ("delete 1 0 inf", "finite numbers"),
        ("move 1 0 0", "join, part or delete"),
    ] {
        let said = edited(two(), text).expect_err(text);
        assert!(said.contains(why), "{text}: {said}");
    }
    assert!(edited(Network::new(), "delete 0 0 0").expect_err("nothing").contains("no vessel"));
    let text = "part 1.5 -2 3 + 0.1 5 6 | 7 8 9";
    assert_eq!(Edit::try_from(text.to_owned()).expect("an edit").to_string(), text);
    let powers = "join 1.5e+00 -2E+0 3 + 1e-01 5 6e+17";
    assert!(edited(two(), "delete -1e300 0 1e-320").expect_err("far").len() < 120);
    assert_eq!(Edit::try_from(powers.to_owned()), Ok(Edit::Join(vec![[1.5, -2.0, 3.0], [0.1, 5.0, 6e17]])));
}
