//! What is written of an inference: tables, topologies, matrices, pictures, and its page with a threshold that the reader can move.

mod outcome;

use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value, json};

use super::figures::{
    CutLine, DrawnVessel, Figure, LikelihoodMatrix, MOST_RINGS, Projection, Ring, convergence, heat_map, node_blocks,
    summary as summary_picture,
};
use super::page::{ColourScale, Colouring, Page, PagePicture, PageTable, condition_table, cut, facts, scene, take};
use super::run_record::RunRecord;
use outcome::{LOOP, PART, Question, TOUCH, WORTH, merged_columns, pairing_columns, suggested_cut_columns};
use willis_core::decision::{
    BESIDE_ACCEPTED, DecidingFigure, Keep, UNDECIDED_BAND, UNDECIDED_Z, has_evidence, knows_fragments, threshold as threshold_of,
};
use willis_core::error::{Error, Result};
use willis_core::flow::{Boundary, Circuit, pressures};
use willis_core::network::{Evidence, Frame, Network, Origin, cycles, fragments, millimetres};
use willis_core::sampling::{Likelihood, Snapshot};
use willis_core::support::geometry::{Point, centroid, sub};
use willis_io::formats::{
    Checksummed, Column, END_POSITION_COLUMNS, condition_columns, graph_columns_with, node_columns, stated_columns,
    windkessel_columns, write_csv, write_graphml, write_npy, write_npz, write_swc, write_vtp,
};
use willis_io::output::names::{
    DENSE_LIKELIHOOD, EDGES, GRAPH, LIKELIHOOD, MEDIAN_TOPOLOGY, NODES, PAGE, PAIRINGS, REVIEW, SUGGESTED_CUTS, TOPOLOGY,
};
use willis_io::output::{write_file, write_record};

pub use outcome::{
    Outcome, SolverRecord, agreement, few_perfused, infer_record, picked, questions, review_columns, vessel_columns,
};

/// The largest matrix written densely, in nodes.
const DENSE_LIMIT: usize = 8192;
/// The largest network that gets a page: a browser takes seconds for so many vessels.
const PAGE_LIMIT: usize = 100_000;

/// What remains of the tables of an inference that are written: the columns of nodes.csv for a page, where there will be one, and notes.
pub type OutcomeTables = (Option<Vec<Column>>, Vec<String>);

impl Outcome<'_> {
    /// Writes the tables of an inference and its topologies into a folder: before its record is made, which is as long as it has free ends.
    ///
    /// # Errors
    ///
    /// A file that cannot be written, or pressures that cannot be solved for.
    pub fn write_tables(&self, folder: &Path) -> Result<OutcomeTables> {
        let mut notes = Vec::new();
        // Columns are made for each file again: those of a million vessels are not held while a circuit is solved, nor for a page that is not made.
        write_file(&folder.join(EDGES), |out| write_csv(out, &vessel_columns(self)))?;
        let nodes = topology(folder, TOPOLOGY, self, &self.answer.kept, &mut notes)?;
        write_file(&folder.join(NODES), |out| write_csv(out, &nodes))?;
        let nodes = (self.network.vessel_count() <= PAGE_LIMIT).then_some(nodes);
        if self.answer.kept == self.answer.above_median {
            // The topology above the median has the files of the kept one, which it is.
            for ending in ["graphml", "vtp"] {
                let [from, to] = [TOPOLOGY, MEDIAN_TOPOLOGY].map(|name| folder.join(format!("{name}.{ending}")));
                if from.exists() {
                    std::fs::copy(&from, &to).map_err(|source| Error::Write { path: to, source })?;
                }
            }
        } else {
            topology(folder, MEDIAN_TOPOLOGY, self, &self.answer.above_median, &mut notes)?;
        }
        Ok((nodes, notes))
    }

    /// Writes the other files of an inference and returns what a person should know about files left out.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path, tables: OutcomeTables, record: &mut RunRecord, dpi: u32) -> Result<Vec<String>> {
        let (for_page, mut notes) = tables;
        let asked = questions(self);
        let (cuts, pairings) = (suggested_cut_columns(self.suggested_cuts), pairing_columns(self));
        for (name, columns) in [(SUGGESTED_CUTS, cuts), (PAIRINGS, pairings), (REVIEW, review_columns(self, &asked))] {
            if let Some(columns) = columns {
                write_file(&folder.join(name), |out| write_csv(out, &columns))?;
            }
        }
        let nodes = self.network.node_count();
        let matrix = self.result.matrix(self.network);
        write_file(&folder.join(LIKELIHOOD), |out| write_npz(out, nodes, &matrix))?;
        if nodes <= DENSE_LIMIT {
            write_file(&folder.join(DENSE_LIKELIHOOD), |out| write_npy(out, nodes, &matrix))?;
        } else {
            notes.push(format!("{DENSE_LIKELIHOOD} is left out above {DENSE_LIMIT} nodes; {LIKELIHOOD} holds the matrix"));
        }
        drop(matrix);
        *record.field("graph") = json!({ "path": GRAPH, "sha256": graph(&folder.join(GRAPH), self)? });
        if let Some(picture) = overview(self, &asked, &record.name()) {
            picture.write(folder, dpi)?;
        }
        let figures = pictures(folder, self, dpi)?;
        write_record(folder, record)?;
        if let Some(nodes) = for_page {
            page(self, &asked, record, [vessel_columns(self), nodes], figures).write(folder)?;
        } else {
            notes.push(format!("{PAGE} is left out above {PAGE_LIMIT} vessels; {TOPOLOGY}.vtp opens in ParaView"));
        }
        Ok(notes)
    }
}

/// Writes the graph that was sampled, so that a later command can take it up again, and returns its SHA-256.
fn graph(path: &Path, outcome: &Outcome<'_>) -> Result<String> {
    let graph = outcome.network;
    let (nodes, mut vessels) = graph_columns_with(graph, &outcome.boundary.stated());
    // What an earlier run kept is open again.
    vessels.retain(|column| column.name != "kept");
    for column in vessels.iter_mut().filter(|column| outcome.sampling.uniform_prior && column.name == "prior") {
        *column = Column::real("prior", graph.vessels().map(|_| 1.0));
    }
    let mut sum = String::new();
    write_file(path, |out| {
        let mut summed = Checksummed::new(out);
        write_graphml(&mut summed, graph, &nodes, &vessels).map(|()| sum = summed.finish())
    })?;
    Ok(sum)
}

/// The columns of nodes.csv, for the vessels that are kept, with pressures and conditions.
///
/// # Errors
///
/// Pressures that cannot be solved for.
pub fn topology_columns(outcome: &Outcome<'_>, kept: &[bool]) -> Result<Vec<Column>> {
    let boundary = outcome.boundary.held(outcome.network, |row| kept[row]);
    columns_of_nodes(&outcome.network.subgraph(|row| kept[row]).0, &boundary, outcome.sampling.viscosity)
}

fn columns_of_nodes(graph: &Network, boundary: &Boundary, viscosity: f64) -> Result<Vec<Column>> {
    let pressure = pressures::pressures(&Circuit::new(graph, boundary, viscosity)?, |_| true)?;
    let stated = boundary.stated();
    let mut nodes = node_columns(graph, &stated, pressure.into_iter(), &fragments(graph, |_, _| true).of_node);
    nodes.extend(condition_columns(&stated));
    Ok(nodes)
}

/// Writes a topology, every vessel of it kept, in every format that can hold it, and returns its node columns, those of merged nodes too.
fn topology(folder: &Path, name: &str, outcome: &Outcome<'_>, kept: &[bool], notes: &mut Vec<String>) -> Result<Vec<Column>> {
    let boundary = outcome.boundary.held(outcome.network, |row| kept[row]);
    // A graph of which all is kept is not copied.
    let (graph, rows) = if kept.contains(&false) {
        let (graph, rows) = outcome.network.subgraph(|row| kept[row]);
        (Cow::Owned(graph), rows)
    } else {
        (Cow::Borrowed(outcome.network), (0..kept.len()).collect())
    };
    let mut all_nodes = columns_of_nodes(&graph, &boundary, outcome.sampling.viscosity)?;
    let merged = outcome.merged(&boundary, graph, &rows);
    let graph = &*merged.network;
    let mut vessels = merged_columns(outcome.network, &merged, vessel_columns(outcome));
    let (shown, known) = (vessels.len(), all_nodes.len());
    vessels.extend(stated_columns(graph));
    let file = |ending: &str| folder.join(format!("{name}.{ending}"));
    // A copy only of what differs.
    let mut some = (merged.nodes.len() < outcome.network.node_count())
        .then(|| all_nodes.iter().map(|column| picked(column, &merged.nodes)).collect::<Vec<_>>());
    let nodes = some.as_mut().unwrap_or(&mut all_nodes);
    nodes.extend(windkessel_columns(graph));
    write_file(&file("graphml"), |out| write_graphml(out, graph, nodes, &vessels))?;
    vessels.truncate(shown);
    all_nodes.truncate(known);
    if graph.has_positions() {
        write_file(&file("vtp"), |out| write_vtp(out, graph, &vessels))?;
        if name == TOPOLOGY {
            if cycles(graph) == 0 {
                write_file(&file("swc"), |out| write_swc(out, graph).map(drop))?;
            } else {
                notes.push("topology.swc is left out: the kept graph has cycles, which SWC cannot hold".into());
            }
        }
    } else if name == TOPOLOGY {
        notes.push("topology.vtp and topology.swc are left out: the nodes have no coordinates".into());
    }
    Ok(all_nodes)
}

/// The largest network that gets the picture of the whole run.
const OVERVIEW_LIMIT: usize = 5_000;

/// The run in one picture, where the vessels have places and are not too many to be seen.
pub fn overview(outcome: &Outcome<'_>, asked: &[Question], name: &str) -> Option<Figure> {
    let (network, answer) = (outcome.network, outcome.answer);
    let scene = scene(network, outcome.boundary).ok().filter(|_| network.vessel_count() <= OVERVIEW_LIMIT)?;
    let drawn = network.vessels().zip(scene.vessels).enumerate().map(|(row, ((_, vessel), course))| DrawnVessel {
        course,
        probability: vessel.evidence().map(|evidence| evidence.probability),
        certain: !outcome.result.uncertain[row],
        kept: answer.kept[row],
    });
    let ring = |number, place: Point| Ring { place: place.map(millimetres), number };
    let rings: Vec<Ring> = if asked.is_empty() {
        answer.undecided.iter().map(|row| ring(None, network.middle_of(network.ends(*row), network.vessel(*row)))).collect()
    } else {
        asked.iter().zip(1..).map(|(one, number)| ring(Some(number), one.at)).collect()
    };
    let of = |origin: Origin| network.vessels().zip(&answer.kept).filter(move |((_, v), _)| v.origin == origin);
    let kept = of(Origin::Candidate).filter(|(_, kept)| **kept).count();
    let mut words = format!("{kept} of {} possible connections kept", of(Origin::Candidate).count());
    if outcome.contacts() > 0 {
        let _ = write!(words, ", {} of {} contacts cut", outcome.cuts().count(), outcome.contacts());
    }
    if let Some(expected) = outcome.expected {
        let _ = write!(words, "; {:.1} expected wrong, {:.1} missed", expected.wrong, expected.missed);
    }
    let ringed = match rings.len() {
        0 => String::new(),
        n if n > MOST_RINGS => format!(" (rings around the first {MOST_RINGS})"),
        _ => " (rings)".to_owned(),
    };
    let open = answer.undecided.len();
    let persons = match asked.len() {
        0 => format!("{open} undecided{ringed}"),
        1 => format!("{open} undecided; 1 question for a person{ringed}"),
        n => format!("{open} undecided; {n} questions for a person, numbered as in the list{ringed}"),
    };
    Some(summary_picture(name, [&words, &persons], drawn.collect(), &rings, &views(outcome)))
}

/// The axis along which what names call left and right are farthest apart, if left is where the coordinate is less; `None` without names of both.
fn axis_to_right(outcome: &Outcome<'_>) -> Option<usize> {
    let network = outcome.network;
    let labels = network.vessels().enumerate().map(|(row, (_, vessel))| (row, &vessel.label));
    let names: Vec<(usize, &String)> = labels.chain(outcome.arteries.iter().map(|(row, name)| (*row, name))).collect();
    let mean = |side: &str| {
        let rows = names.iter().filter(|(_, name)| name.starts_with(side)).map(|(row, _)| *row);
        let places: Vec<Point> = rows.map(|row| network.middle_of(network.ends(row), network.vessel(row))).collect();
        (!places.is_empty()).then(|| centroid(places))
    };
    let apart = sub(mean("L-")?, mean("R-")?);
    let axis = (0..3).max_by(|a, b| apart[*a].abs().total_cmp(&apart[*b].abs()))?;
    (apart[axis] < 0.0).then_some(axis)
}

/// From the front and from the patient's left as radiologists see it, where it is known which way that is.
fn views(outcome: &Outcome<'_>) -> [Projection; 2] {
    let up = [0.0, 0.0, 1.0];
    let along_y = |name, x, edges| Projection { name, right: [x, 0.0, 0.0], up, edges };
    let along_x = |name, y, edges| Projection { name, right: [0.0, y, 0.0], up, edges };
    match outcome.network.frame {
        Frame::Ras => [along_y("front", -1.0, ["R", "L"]), along_x("left side", -1.0, ["A", "P"])],
        Frame::Lps => [along_y("front", 1.0, ["R", "L"]), along_x("left side", 1.0, ["A", "P"])],
        // The patient's left is on the right of the page, where names say which side it is.
        Frame::Unknown => {
            let turned = axis_to_right(outcome);
            let toward = |axis: usize| if turned == Some(axis) { -1.0 } else { 1.0 };
            let edges = |axis: usize, name| if turned == Some(axis) { [name, ""] } else { ["", name] };
            [along_y("along y", toward(0), edges(0, "x")), along_x("along x", toward(1), edges(1, "y"))]
        }
    }
}

/// Draws the pictures of the likelihood into a folder and returns them for the page.
///
/// # Errors
///
/// A file that cannot be written.
pub fn pictures(folder: &Path, outcome: &Outcome<'_>, dpi: u32) -> Result<Vec<PagePicture>> {
    let (network, result) = (outcome.network, outcome.result);
    let open = network.vessels().zip(&result.likelihood).zip(&result.uncertain).filter(|((([a, b], _), _), _)| a != b);
    let (entries, uncertain): (Vec<_>, Vec<bool>) =
        open.map(|((([a, b], _), likelihood), uncertain)| ((a as u32, b as u32, *likelihood), *uncertain)).unzip();
    let blocks = node_blocks(network, outcome.boundary);
    let matrix = LikelihoodMatrix { nodes: network.node_count(), entries: &entries, uncertain: &uncertain, blocks: &blocks };
    let matrix = heat_map(&matrix, outcome.sampling.weight);
    let says = "The likelihood over all pairs of nodes on a logarithmic scale of colour; light grey is zero. The nodes are in order of the \
                inlet that feeds them along observed vessels, or of their fragment. A second matrix has the uncertain vessels alone.";
    let matrix = PagePicture::write("Likelihood matrix", says, &matrix, folder, dpi)?;

    let samples: Vec<u64> = result.trace.iter().map(|s| s.samples).collect();
    let uncertain: Vec<usize> = (0..result.uncertain.len()).filter(|row| result.uncertain[*row]).collect();
    let mean = |at: usize| result.trace.iter().map(|s| s.likelihood[at] / s.samples as f64).collect();
    let series: Vec<Vec<f64>> = (0..uncertain.len()).map(mean).collect();
    let of_likelihood = outcome.rule.figure() == DecidingFigure::Likelihood;
    let (cut, rule) = if of_likelihood { (CutLine::Threshold, outcome.rule) } else { (CutLine::Median, Keep::Median) };
    // The threshold on L/n that the samples so far would give; NaN where there is none.
    let running = |Snapshot { samples, likelihood, .. }: &Snapshot| {
        if let Keep::Value(x) = rule {
            return x / result.samples as f64;
        }
        let uncertain = vec![true; likelihood.len()];
        let so_far = Likelihood { likelihood: likelihood.clone(), uncertain, ..Likelihood::default() };
        threshold_of(rule, &so_far).map_or(f64::NAN, |cut| cut / *samples as f64)
    };
    let cuts: Vec<f64> = result.trace.iter().map(running).collect();
    let kept: Vec<bool> = uncertain.iter().map(|row| outcome.answer.kept[*row]).collect();
    let traces = convergence(&samples, &series, (cut, &cuts), &kept, outcome.sampling.weight);
    let cut = match cut {
        _ if cuts.iter().all(|cut| cut.is_nan()) => "",
        CutLine::Threshold => ", and the threshold",
        CutLine::Median => ", and their median, above which lies topology-median",
    };
    let says = if outcome.sampling.exact {
        "Every pattern of open and closed vessels was counted, so that nothing has to converge.".to_owned()
    } else {
        format!(
            "The mean contribution per sample of every uncertain vessel against the number of samples{cut}; \
             lines that are still moving at the right end call for more samples."
        )
    };
    Ok(vec![matrix, PagePicture::write("Convergence", &says, &traces, folder, dpi)?])
}

/// The column of the page that is 1 where a vessel is uncertain.
const UNCERTAIN: &str = "uncertain";
const UNDECIDED: &str = "undecided";
/// The columns with the length of a part that nothing connects, of a loop, and of what hangs on a place where vessels may only touch, in the row that stands
/// for it, mm.
const STANDS_FOR: [(&str, &str); 3] = [("loose_mm", PART), ("loop_mm", LOOP), ("touch_mm", TOUCH)];
/// The columns of the page with the probability that a vessel attaches its one end to its other, and the reverse.
const ATTACHED: [&str; 2] = ["attached_a", "attached_b"];
/// That with the score of the fragment of a node for being attached to nothing.
const ALONE: &str = "alone";
/// That with the probability before the decisions that the run was made with.
const STATED: &str = "stated";
const EXACT: [&str; 8] = ["likelihood", "std_error", "frequency", "probability", STATED, ATTACHED[0], ATTACHED[1], ALONE];

/// The page of an inference from the columns of edges.csv and nodes.csv.
fn page(outcome: &Outcome<'_>, asked: &[Question], run: &RunRecord, tables: [Vec<Column>; 2], figures: Vec<PagePicture>) -> Page {
    let cut_at = |row: usize| {
        let (ends, vessel) = (outcome.network.ends(row), outcome.network.vessel(row));
        let probability = vessel.evidence().map_or(vessel.prior, |evidence| evidence.probability);
        cut("cut", outcome.network.middle_of(ends, vessel), vessel.radius, probability)
    };
    let scene = scene(outcome.network, &outcome.held()).map(|mut scene| {
        let suggested = outcome.suggested_cuts.iter().map(|one| cut("suggested", one.position, one.radius, one.probability));
        scene.markers.extend(outcome.cuts().map(cut_at).chain(suggested));
        scene
    });
    let mut page = Page::new("infer", run, scene, figures);
    page.image_places["of"] = json!(outcome.image_places);
    page.segmentation = json!(outcome.segmentation);
    let warning = few_perfused(outcome.network, outcome.boundary, outcome.sampling, outcome.result.perfused);
    page.warnings = warning.into_iter().chain(page.warnings).collect();
    page.phenotype = Some(take(&mut page.record, "phenotype")).filter(Value::is_object);
    // For a later command, not for a reader.
    take(&mut page.record, "named");
    let [mut columns, mut nodes] = tables;
    let unit = outcome.sampling.weight.unit();
    let evidence = has_evidence(outcome.network);
    // The page draws the positions.
    columns.retain(|column| !END_POSITION_COLUMNS.as_flattened().contains(&&*column.name));
    // What a person decided is certain to the run, and can be taken back on the page.
    let made = page.record["parameters"]["decisions"]["made"].as_array().into_iter().flatten();
    let by_person: std::collections::HashSet<usize> = made.filter_map(|d| Some(d["edge"].as_u64()? as usize)).collect();
    let open = outcome.result.uncertain.iter().enumerate().map(|(row, open)| usize::from(*open || by_person.contains(&row)));
    columns.push(Column::whole(UNCERTAIN, open));
    let mut names = vec![String::new(); outcome.network.vessel_count()];
    outcome.arteries.iter().for_each(|(row, name)| names[*row].clone_from(name));
    columns.push(Column::text("artery", names.into_iter()));
    let undecided = |row: usize| usize::from(outcome.answer.undecided.binary_search(&row).is_ok());
    columns.push(Column::whole(UNDECIDED, (0..outcome.network.vessel_count()).map(undecided)));
    let mut of_asked = |name: &'static str, stated: &mut dyn Iterator<Item = (usize, f64)>| {
        let mut figures = vec![f64::NAN; outcome.network.vessel_count()];
        for (row, figure) in stated {
            figures[row] = figure;
        }
        columns.push(Column::real(name, figures.into_iter()));
    };
    let of = |kind: &'static str| asked.iter().filter(move |one| one.kind == kind);
    for (name, kind) in STANDS_FOR {
        of_asked(name, &mut of(kind).map(|one| (one.row, millimetres(one.hangs))));
    }
    // What a right answer to a question of the last kind is expected to put right.
    of_asked("touch_gain_mm", &mut of(TOUCH).map(|one| (one.row, millimetres(one.gain))));
    // The number of a vessel in review.csv, by which the list and the rings of pictures have it.
    of_asked("rank", &mut asked.iter().zip(1..).map(|(one, rank)| (one.row, f64::from(rank))));
    if evidence {
        // What a decision changes, and the rule weighs, for the page to follow it; before decisions, so that each can be taken back.
        let before = outcome.without_decisions.as_deref().unwrap_or(outcome.network);
        let stated = |of: fn(Evidence) -> f64| before.vessels().map(move |(_, v)| v.evidence().map_or(f64::NAN, of));
        columns.extend(outcome.without_decisions.as_ref().map(|_| Column::real(STATED, stated(|e| e.probability))));
        columns.push(Column::real(ATTACHED[0], stated(|e| e.attached[0])));
        columns.push(Column::real(ATTACHED[1], stated(|e| e.attached[1])));
        nodes.push(Column::real(ALONE, outcome.network.nodes().map(|node| node.root_score.unwrap_or(f64::NAN))));
    }
    let table = |title: &str, columns, of_vessels| PageTable::with_exact(title, columns, &EXACT, of_vessels);
    let of_threshold = if outcome.rule.figure() == DecidingFigure::Likelihood { unit } else { "" };
    let mut names = vec![
        ("nodes", "/counts/nodes", ""),
        ("observed vessels", "/counts/observed", ""),
        ("candidates", "/counts/candidates", ""),
        ("uncertain vessels", "/counts/uncertain", ""),
        ("kept of these", "/counts/topology/kept", ""),
        ("undecided", "/convergence/undecided", ""),
        ("rule", "/threshold/rule", ""),
        ("threshold", "/threshold/value", of_threshold),
        ("samples", "/parameters/samples", ""),
        ("occlusion probability \u{3b5}", "/parameters/epsilon", ""),
        ("seed", "/seed", ""),
        ("mean \u{3c1}_G", "/rho_G_W_per_m3", "W/m\u{b3}"),
    ];
    if outcome.sampling.exact {
        names.retain(|(name, ..)| *name != "samples");
    }
    names.extend((!outcome.suggested_cuts.is_empty()).then_some(("suggested cuts", "/counts/suggested_cuts", "")));
    if outcome.contacts() > 0 {
        names.extend([("contacts of vessels", "/counts/contacts", ""), ("cut of these", "/counts/cut", "")]);
    }
    if evidence {
        names.push(("expected wrong connections", "/expected_errors/wrong", ""));
        names.push(("expected missed connections", "/expected_errors/missed", ""));
    }
    let suggested = suggested_cut_columns(outcome.suggested_cuts).map(|columns| table("Suggested cuts", columns, false));
    let pairings = pairing_columns(outcome).map(|columns| table("Vessels at contacts", columns, false));
    let (vessels, nodes) = (Some(table("Vessels", columns, true)), Some(table("Nodes", nodes, false)));
    page.tables = [vessels, suggested, pairings, nodes, condition_table(&run.conditions)].into_iter().flatten().collect();
    page.facts = facts(&page.record, &names);
    let colouring = |name, unit, scale, uncertain_only, column| Colouring {
        uncertain_only,
        ..Colouring::new(name, unit, scale, vec![(String::new(), 0, String::from(column))])
    };
    page.colourings.extend(evidence.then(|| colouring("probability P", "", ColourScale::Share, true, "probability")));
    page.colourings.extend([
        colouring("likelihood L", unit, ColourScale::Log, true, "likelihood"),
        colouring("frequency in the forest", "", ColourScale::Share, true, "frequency"),
        colouring("radius", "mm", ColourScale::Linear, false, "radius_mm"),
    ]);
    page.threshold = threshold(outcome, unit);
    page
}

/// The threshold on a column of the first table that the reader can move.
fn threshold(outcome: &Outcome<'_>, unit: &'static str) -> Value {
    let rule = outcome.rule;
    let ([column, name], followed) = (rule.figure().names(), rule.followed());
    let of_likelihood = rule.figure() == DecidingFigure::Likelihood;
    json!({
        // The column that is compared with the threshold, what the figure is called, and its unit, empty without one.
        "figure": column,
        "name": name,
        "unit": if of_likelihood { unit } else { "" },
        // The column of its standard error. Without one, the error is that of a share of `samples`, sqrt(f(1-f)/n).
        "error": of_likelihood.then_some("std_error"),
        "samples": outcome.result.samples,
        // Whether a figure equal to the threshold passes.
        "at_least": !of_likelihood,
        // Whether a decision changes midway between the two figures next to the threshold, or at the threshold itself.
        "midway": !rule.is_fixed(),
        // How many standard errors from there a decision counts as certain.
        "within": if rule.asks_evidence() { 1.0 } else { UNDECIDED_Z },
        "cut": outcome.answer.threshold,
        // The median of the positive figures of uncertain vessels, where the page can offer it.
        "median": outcome.answer.median.filter(|_| of_likelihood),
        // Where the rule of the run is not a threshold on the figure: the column that is 1 where it kept a vessel, and the figure near
        // which its decisions are uncertain.
        "kept": followed.map(|_| "kept"),
        "middle": followed.and(rule.turning_point()),
        // The rule of the run where it has no threshold, for the page to follow it after a decision.
        "rule": followed,
        // The distance from the threshold within which a figure without standard error is undecided.
        "band": rule.asks_evidence().then_some(UNDECIDED_BAND),
        // How much of its P a candidate keeps beside an accepted one at its free end; null where fragments form a forest.
        "beside_accepted": (!knows_fragments(outcome.network)).then_some(BESIDE_ACCEPTED),
        // The columns that are 1 where a vessel is uncertain, and where a decision of the run is undecided.
        "uncertain": UNCERTAIN,
        "undecided": UNDECIDED,
        // What is kept one by one and expected to be wrong about more than so many mm is asked about.
        "worth": millimetres(WORTH),
        "nodes": outcome.network.node_count(),
    })
}
