//! The sentence that a page of a simulation or a modulation begins with: what came of it, from its record.

use serde_json::Value;
use willis_io::formats::tables::reader::plural;
/// A part of the sentence, and whether it stands out.
pub type Part = (String, bool);

/// A number with three digits, in full below a million.
fn brief(x: f64) -> String {
    let size = x.abs();
    if size == 0.0 || !size.is_finite() {
        return x.to_string();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{x:.2e}");
    }
    let decimals = (2.0 - size.log10().floor()).max(0.0) as usize;
    format!("{x:.decimals$}").replace('-', "\u{2212}")
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
            (format!("{} mL/min flow in", brief(inflow)), true),
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
        (format!("inflow {} \u{2192} {} mL/min{}", brief(inflow), brief(after), change(inflow, after)), true),
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
        parts.push((format!("; {} gains most, {} mL/min", name(first), brief(gain)), false));
    }
    parts.push((".".to_owned(), false));
    parts
}

/// What a modulation is about: how the class of the strongest modulation changes inflow, resilience and hypertension.
pub fn modulation(record: &Value) -> Vec<Part> {
    let class = record["classes"].as_array().and_then(|classes| classes.last());
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
        (format!("inflow goes from {} to {} mL/min{}", brief(inflow), brief(modulated), change(inflow, modulated)), true),
    ];
    if let Some((before, after)) = of("rho_G_W_per_m3") {
        parts.push((", ".to_owned(), false));
        parts.push((format!("resilience from {} to {} W/m\u{b3}{}", brief(before), brief(after), change(before, after)), true));
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
