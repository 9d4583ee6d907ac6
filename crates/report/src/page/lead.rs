//! The sentence that a page of a simulation or a modulation begins with: what came of it, from its record.

use std::cmp::Ordering;

use serde_json::Value;

use crate::figures::axis::decimals;
use willis_io::formats::tables::reader::plural;

/// A part of the sentence, and whether it stands out.
pub type Part = (String, bool);

/// Three or so significant digits, on pages and in what is printed.
pub fn brief(x: f64) -> String {
    if x != 0.0 && !(1e-3..1e5).contains(&x.abs()) { format!("{x:.2e}") } else { format!("{x:.*}", decimals(x)) }
}

/// The same with the minus sign that pages have.
fn on_page(x: f64) -> String {
    brief(x).replace('-', "\u{2212}")
}

/// A change as a percentage, in brackets.
pub fn change(before: f64, after: f64) -> String {
    let percent = 100.0 * (after / before - 1.0);
    match percent.abs() {
        size if !size.is_finite() => String::new(),
        0.0..0.05 => " (by less than 0.05 %)".to_owned(),
        _ => format!(" ({}{:.1} %)", if percent < 0.0 { "\u{2212}" } else { "+" }, percent.abs()),
    }
}

/// So many vessels are called by their names.
const MOST_NAMED: usize = 4;

/// What was done to a vessel of this name, with how much of its diameter is open.
fn changed(one: &Value, name: &str) -> String {
    let kind = one["kind"].as_str().unwrap_or("change");
    match one["open_diameter_share"].as_f64().filter(|_| kind == "stenosis") {
        Some(open) => format!("{kind} of {name} to {:.0} % of its diameter", 100.0 * open),
        None => format!("{kind} of {name}"),
    }
}

/// What a simulation is about: its inflow, what the perturbations change, which flows turn round.
pub fn simulation(record: &Value) -> Vec<Part> {
    let number = |pointer: &str| record.pointer(pointer).and_then(Value::as_f64);
    let list = |name: &str| record[name].as_array().map_or(&[][..], Vec::as_slice);
    let name = |vessel: &Value| match vessel["label"].as_str() {
        Some(label) if !label.is_empty() => label.to_owned(),
        _ => format!("edge {}", vessel["edge"]),
    };
    let Some(inflow) = number("/total_inflow_mL_per_min") else { return Vec::new() };
    let Some(after) = number("/total_inflow_mL_per_min_perturbed") else {
        let [carrying, all] = ["/counts/diffused", "/counts/vessels"].map(|pointer| number(pointer).unwrap_or_default());
        return vec![
            (format!("{} mL/min flow in", on_page(inflow)), true),
            (format!("; blood flows in {carrying} of {}.", plural(all as usize, "vessel")), false),
        ];
    };
    let what = match list("perturbations") {
        [] => "Without a change".to_owned(),
        many => {
            let said: Vec<String> = many.iter().take(MOST_NAMED).map(|one| changed(one, &name(one))).collect();
            let more = if many.len() > MOST_NAMED { format!(" and {} more", many.len() - MOST_NAMED) } else { String::new() };
            let mut letters = said.join(", ");
            letters[..1].make_ascii_uppercase();
            letters + &more
        }
    };
    let mut parts = vec![
        (format!("{what}: "), false),
        (format!("inflow {} \u{2192} {} mL/min{}", on_page(inflow), on_page(after), change(inflow, after)), true),
        ("; ".to_owned(), false),
    ];
    let reversed = list("reversed");
    parts.push(match reversed {
        [] => ("no flow is reversed".to_owned(), true),
        [one] => (format!("the flow of {} is reversed", name(one)), true),
        few if few.len() <= MOST_NAMED => {
            (format!("the flows of {} are reversed", few.iter().map(name).collect::<Vec<_>>().join(", ")), true)
        }
        many => (format!("{} flows are reversed", many.len()), true),
    });
    if let Some(first) = list("collaterals").first() {
        let gain = first["gain_mL_per_min"].as_f64().unwrap_or_default();
        parts.push((format!("; {} gains most, {} mL/min", name(first), on_page(gain)), false));
    }
    parts.push((".".to_owned(), false));
    parts
}

/// What a modulation is about: how the class of the strongest modulation changes inflow, resilience and hypertension.
pub fn modulation(record: &Value) -> Vec<Part> {
    // By the upper border of u, then by the lower one; class texts are LOW:HIGH.
    let borders = |class: &Value| {
        let number = |text: &str| text.parse::<f64>().unwrap_or_default();
        let (low, high) = class["class"].as_str().and_then(|text| text.split_once(':')).unwrap_or_default();
        [number(high), number(low)]
    };
    let classes = record["classes"].as_array();
    let class = classes.and_then(|all| all.iter().max_by(|a, b| borders(a).partial_cmp(&borders(b)).unwrap_or(Ordering::Equal)));
    let (Some(class), rest) = (class, &record["unperturbed"]) else { return Vec::new() };
    let of = |name: &str| Some((rest[name].as_f64()?, class[name].as_f64()?));
    let Some((inflow, modulated)) = of("total_inflow_mL_per_min") else { return Vec::new() };
    let range = class["class"].as_str().unwrap_or_default().replace(':', "\u{2013}");
    let does = match record.pointer("/parameters/reading").and_then(Value::as_str) {
        Some("conductance") => "every resistance R becomes R / (1 - u)",
        Some("literal") => "every resistance R becomes R (1 - u)",
        Some("geometry") => "every radius r becomes r (1 - u), every length l (1 + u)",
        _ => "every resistance R becomes R (1 + u)",
    };
    let mut parts = vec![
        (format!("Of each vessel a number u is drawn: {does}. With u in {range} "), false),
        (format!("inflow goes from {} to {} mL/min{}", on_page(inflow), on_page(modulated), change(inflow, modulated)), true),
    ];
    if let Some((before, after)) = of("rho_G_W_per_m3") {
        parts.push((", ".to_owned(), false));
        parts.push((
            format!("resilience from {} to {} W/m\u{b3}{}", on_page(before), on_page(after), change(before, after)),
            true,
        ));
    }
    if let Some((before, after)) = of("share_above_threshold") {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let [before, after] = [before, after].map(percent);
        let risk = format!("; {after} of the vessels are above the threshold of hypertension, before {before}");
        parts.push((risk, false));
    }
    parts.push((".".to_owned(), false));
    parts
}
