//! The page of an inference: vessels by likelihood, and a threshold that the reader can move.

use std::collections::HashSet;

use serde_json::{Value, json};

use super::content::{ColourScale, Colouring, Page, PagePicture, PageTable, conditions, facts, take, warnings};
use super::scene::{cut, cut_at, scene};
use crate::inference::Outcome;
use crate::inference::questions::{LOOP, PART, Question, TOUCH, WORTH};
use crate::inference::tables::{pairing_columns, suggested_cut_columns};
use crate::run_record::RunRecord;
use willis_core::decision::{DecidingFigure, UNDECIDED_BAND, UNDECIDED_Z, beside_accepted, has_evidence, knows_fragments};
use willis_core::network::units::millimetres;
use willis_io::formats::{Column, END_POSITION_COLUMNS};

/// The column of the page that is 1 where a vessel is uncertain.
const UNCERTAIN: &str = "uncertain";
const UNDECIDED: &str = "undecided";
/// The columns with the length of a part that nothing connects, of a loop, and of what hangs on a place where vessels may only touch, in the row that stands
/// for it, mm.
const STANDS_FOR: [(&str, &str); 3] = [("loose_mm", PART), ("loop_mm", LOOP), ("touch_mm", TOUCH)];
/// What a right answer to a question of the last kind is expected to put right, mm.
const TOUCH_GAIN: &str = "touch_gain_mm";
/// The column with the number of a vessel in review.csv, by which the list and the rings of pictures have it.
const RANK: &str = "rank";
/// The columns of the page with the probability that a vessel attaches its one end to its other, and the reverse.
const ATTACHED: [&str; 2] = ["attached_a", "attached_b"];
/// That with the score of the fragment of a node for being attached to nothing.
const ALONE: &str = "alone";
const EXACT: [&str; 7] = ["likelihood", "std_error", "frequency", "probability", ATTACHED[0], ATTACHED[1], ALONE];

/// The page of an inference from the columns of edges.csv and nodes.csv.
pub fn page(
    outcome: &Outcome<'_>,
    asked: &[Question],
    of_run: &RunRecord,
    mut columns: Vec<Column>,
    mut nodes: Vec<Column>,
    figures: Vec<PagePicture>,
) -> Page {
    let mut record = of_run.for_page();
    let mut warnings = warnings(&record, &of_run.conditions);
    if let Some(warning) = outcome.few_perfused() {
        warnings.insert(0, warning);
    }
    let phenotype = Some(take(&mut record, "phenotype")).filter(Value::is_object);
    // For a later command, not for a reader.
    take(&mut record, "named");
    let conditions = conditions(&of_run.conditions);
    let unit = outcome.sampling.weight.unit();
    let evidence = has_evidence(outcome.network);
    // The page draws the positions.
    columns.retain(|column| !END_POSITION_COLUMNS.as_flattened().contains(&&*column.name));
    // What a person decided is certain to the run, and can be taken back on the page.
    let made = record["parameters"]["decisions"]["made"].as_array().into_iter().flatten();
    let by_person: HashSet<usize> = made.filter_map(|d| Some(d["edge"].as_u64()? as usize)).collect();
    let open = outcome.result.uncertain.iter().enumerate().map(|(row, open)| usize::from(*open || by_person.contains(&row)));
    columns.push(Column::whole(UNCERTAIN, open));
    let mut names = vec![String::new(); outcome.network.vessel_count()];
    outcome.arteries.iter().for_each(|(row, name)| names[*row].clone_from(name));
    columns.push(Column::text("artery", names.into_iter()));
    let undecided = |row: usize| usize::from(outcome.answer.undecided.binary_search(&row).is_ok());
    columns.push(Column::whole(UNDECIDED, (0..outcome.network.vessel_count()).map(undecided)));
    for (name, kind) in STANDS_FOR {
        let mut length = vec![f64::NAN; outcome.network.vessel_count()];
        asked.iter().filter(|one| one.kind == kind).for_each(|one| length[one.row] = millimetres(one.hangs));
        columns.push(Column::real(name, length.into_iter()));
    }
    let mut gain = vec![f64::NAN; outcome.network.vessel_count()];
    asked.iter().filter(|one| one.kind == TOUCH).for_each(|one| gain[one.row] = millimetres(one.gain));
    columns.push(Column::real(TOUCH_GAIN, gain.into_iter()));
    let mut ranks = vec![f64::NAN; outcome.network.vessel_count()];
    asked.iter().zip(1..).for_each(|(one, rank)| ranks[one.row] = f64::from(rank));
    columns.push(Column::real(RANK, ranks.into_iter()));
    if evidence && outcome.rule.followed().is_some() {
        // What the rule weighs, for the page to follow it after a decision.
        let attached =
            |end: usize| outcome.network.vessels().map(move |(_, v)| v.evidence().map_or(f64::NAN, |e| e.attached[end]));
        columns.extend(ATTACHED.into_iter().zip(0..).map(|(name, end)| Column::real(name, attached(end))));
        nodes.push(Column::real(ALONE, outcome.network.nodes().map(|node| node.root_score.unwrap_or(f64::NAN))));
    }
    let table = |title: &str, columns, of_vessels| PageTable { title: title.to_owned(), columns, exact: &EXACT, of_vessels };
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
    let are_suggested = !outcome.suggested_cuts.is_empty();
    if are_suggested {
        names.push(("suggested cuts", "/counts/suggested_cuts", ""));
    }
    if outcome.contacts() > 0 {
        names.push(("contacts of vessels", "/counts/contacts", ""));
        names.push(("cut of these", "/counts/cut", ""));
    }
    if evidence {
        names.push(("expected wrong connections", "/expected_errors/wrong", ""));
        names.push(("expected missed connections", "/expected_errors/missed", ""));
    }
    let scene = scene(outcome.network, &outcome.held()).map(|mut scene| {
        let suggested = outcome.suggested_cuts.iter().map(|one| cut("suggested", one.position, one.radius, one.probability));
        scene.markers.extend(outcome.cuts().map(|row| cut_at(outcome.network, row)).chain(suggested));
        scene
    });
    let suggested = are_suggested.then(|| table("Suggested cuts", suggested_cut_columns(outcome.suggested_cuts), false));
    let pairings = (!outcome.pairings.is_empty()).then(|| table("Vessels at contacts", pairing_columns(outcome), false));
    let (vessels, nodes) = (Some(table("Vessels", columns, true)), Some(table("Nodes", nodes, false)));
    Page {
        warnings,
        facts: facts(&record, &names),
        phenotype,
        colourings: colourings(unit, evidence),
        segmentation: json!(outcome.segmentation),
        threshold: threshold(outcome, unit),
        tables: [vessels, suggested, pairings, nodes, conditions].into_iter().flatten().collect(),
        ..Page::new("infer", record, scene, outcome.image_places, figures)
    }
}

fn colourings(unit: &'static str, evidence: bool) -> Vec<Colouring> {
    let colouring = |name, unit, scale, uncertain_only, column| Colouring {
        uncertain_only,
        ..Colouring::new(name, unit, scale, vec![(String::new(), 0, String::from(column))])
    };
    let mut all = vec![
        colouring("likelihood L", unit, ColourScale::Log, true, "likelihood"),
        colouring("frequency in the forest", "", ColourScale::Share, true, "frequency"),
        colouring("radius", "mm", ColourScale::Linear, false, "radius_mm"),
    ];
    if evidence {
        all.insert(0, colouring("probability P", "", ColourScale::Share, true, "probability"));
    }
    all
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
        // Of the candidates at a free end: how much of its P one keeps beside an accepted one.
        "beside_accepted": beside_accepted(outcome.network),
        // Whether those beside a rejected one share its P.
        "at_most_one": knows_fragments(outcome.network),
        // The columns that are 1 where a vessel is uncertain, and where a decision of the run is undecided.
        "uncertain": UNCERTAIN,
        "undecided": UNDECIDED,
        // What is kept one by one and expected to be wrong about more than so many mm is asked about.
        "worth": millimetres(WORTH),
        "nodes": outcome.network.node_count(),
    })
}
