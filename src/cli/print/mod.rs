//! What a person sees while a command runs: one headed line a fact, progress with rate and time left.

pub mod flow;
pub mod inference;

use std::{cell::RefCell, collections::BTreeMap, io::IsTerminal, io::Write, time::Duration, time::Instant};

use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use super::{command_line::flags_in, signals::listen, signals::stops};
use crate::internals::network::units::{millimetres, ml_per_min, mmhg, mmhg_s_per_ml};
use crate::internals::network::{Condition, Origin, Role, fragments};
pub use crate::internals::report::page::lead::brief;
use crate::{
    Contents, Error, Input, Network, Step, internals::flow::Boundary, internals::flow::boundary_conditions::unfed_fragments,
    internals::report::figures::axis::with_commas, internals::support::printable::printable,
};

/// Prints facts on standard error, so that standard output stays free for data.
#[derive(Debug, Clone, Copy)]
pub struct TextTerminal {
    quiet: bool,
    /// Whether a person asked for more.
    pub verbose: bool,
    /// Whether this is the terminal of one subject among many.
    of_many: bool,
}

thread_local! {
    /// What this thread says, where that is not to be printed.
    static TAKEN: RefCell<Option<Vec<(String, String)>>> = const { RefCell::new(None) };
}

/// What is said in some work, as facts under headings; nothing of it is printed.
pub fn taken(work: impl FnOnce(TextTerminal)) -> Vec<(String, String)> {
    TAKEN.set(Some(Vec::new()));
    work(TextTerminal::new(false, false));
    TAKEN.take().unwrap_or_default()
}

/// Between two progress lines where there is no terminal.
const QUIET_TIME: Duration = Duration::from_secs(10);

impl TextTerminal {
    /// A terminal that tells less or more.
    pub fn new(quiet: bool, verbose: bool) -> Self {
        Self { quiet, verbose, of_many: false }
    }

    /// The terminal of one subject among many: it prints nothing, or everything with `--verbose`; its
    /// work goes on through the first Ctrl-C.
    pub fn of_many(self) -> Self {
        Self { quiet: !self.verbose, verbose: self.verbose, of_many: true }
    }

    /// Whether Ctrl-C or SIGTERM has come as often as the work stops for.
    pub fn is_stopped(self) -> bool {
        stops() >= self.stops()
    }

    /// What could not be written after a stop is what was stopped.
    pub fn stopped(self, error: Error, done: u64, total: u64) -> Error {
        if self.is_stopped() && matches!(error, Error::Write { .. }) { Error::Stopped { done, total } } else { error }
    }

    /// After how many signals the work stops.
    fn stops(self) -> u8 {
        if self.of_many { 2 } else { 1 }
    }

    /// Prints a fact under a heading.
    pub fn say(self, heading: &str, fact: impl AsRef<str>) {
        let taken = TAKEN.with_borrow_mut(|taken| {
            // What is said of one subject among many is in its own notes.
            let lines = taken.as_mut().filter(|_| !self.of_many)?;
            lines.push((heading.to_owned(), flags_in(fact.as_ref())));
            Some(())
        });
        if taken.is_none() && !self.quiet {
            let bold = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
            let (on, off) = if bold { ("\x1b[1m", "\x1b[0m") } else { ("", "") };
            let (heading, fact) = (printable(heading), flags_in(fact.as_ref()));
            put(format_args!("{on}{heading:>10}{off}  {}", printable(&fact)));
        }
    }

    /// Says what a person should know.
    pub fn notes(self, notes: &[String]) {
        for note in notes {
            self.say("note", note);
        }
    }

    /// Prints a fact with `--verbose` only.
    pub fn detail(self, heading: &str, fact: impl AsRef<str>) {
        if self.verbose {
            self.say(heading, fact);
        }
    }

    /// Progress of `doing` over so many `things`, stopped by Ctrl-C or SIGTERM.
    pub fn progress(self, doing: &'static str, things: &'static str, total: u64) -> CountProgress {
        listen(self.stops());
        let (is_shown, is_terminal) = (!self.quiet && !self.of_many, std::io::stderr().is_terminal());
        let bar = if is_shown && is_terminal { ProgressBar::new(total) } else { ProgressBar::hidden() };
        let line = format!("{{prefix:>10}}  {{bar:16}} {{human_pos}}/{{human_len}} {things}  {{rate}}  {{eta}} left");
        if let Ok(style) = ProgressStyle::with_template(&line) {
            let rate = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                // A bar has no way to say that it cannot be drawn.
                let _ = write!(out, "{}/s", count(state.per_sec() as u64));
            };
            bar.set_style(style.with_key("rate", rate));
        }
        bar.set_prefix(doing);
        let (lines, now) = (is_shown && !is_terminal, Instant::now());
        CountProgress { bar, doing, things, lines, stops: self.stops(), last: now, start: now, before: None }
    }
}

/// A line on standard error, without anything in it that a terminal acts on: names come from files that others wrote.
pub fn line(text: std::fmt::Arguments<'_>) {
    put(format_args!("{}", printable(&text.to_string())));
}

/// A line on standard error as it is; one that is closed or full is no reason to stop.
fn put(text: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// A progress bar on a terminal, plain lines elsewhere.
pub struct CountProgress {
    bar: ProgressBar,
    doing: &'static str,
    things: &'static str,
    lines: bool,
    /// After how many signals the work stops.
    stops: u8,
    last: Instant,
    start: Instant,
    /// Things that were done when the work began.
    before: Option<u64>,
}

impl CountProgress {
    /// Shows so many of the total; false where a person asked to stop.
    pub fn report(&mut self, done: u64, total: u64) -> bool {
        let before = *self.before.get_or_insert_with(|| {
            self.bar.set_position(done);
            self.bar.reset_eta();
            done
        });
        self.bar.set_length(total);
        self.bar.set_position(done);
        if self.lines && self.last.elapsed() > QUIET_TIME {
            self.last = Instant::now();
            let rate = done.saturating_sub(before) as f64 / self.start.elapsed().as_secs_f64();
            let left = total.saturating_sub(done) as f64 / rate.max(1e-9);
            let (doing, things, rate) = (self.doing, self.things, count(rate as u64));
            line(format_args!("{doing:>10}  {} of {} {things}, {rate}/s, {left:.0} s left", count(done), count(total)));
        }
        stops() < self.stops
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// A count with commas between its thousands.
pub fn count(n: impl TryInto<u64>) -> String {
    with_commas(n.try_into().unwrap_or(u64::MAX))
}

/// `1 vessel`, `2 vessels`.
pub fn plural(n: usize, noun: &str) -> String {
    format!("{} {noun}{}", count(n as u64), if n == 1 { "" } else { "s" })
}

/// The first of some words, and how many more there are.
pub fn listed(words: impl Iterator<Item = String>, most: usize) -> String {
    let all: Vec<String> = words.collect();
    let more = all.len().saturating_sub(most);
    let rest = if more > 0 { format!(" and {} more", count(more as u64)) } else { String::new() };
    format!("{}{rest}", all[..all.len() - more].join(", "))
}

/// Says what was read; `assumed` where nobody said the unit.
pub fn say_read(terminal: TextTerminal, input: &Input, assumed: bool) {
    let (network, source) = (&input.network, &input.provenance);
    let assumed = if assumed && !input.states_unit() { " assumed" } else { "" };
    let (nodes, vessels) = (plural(network.node_count(), "node"), plural(network.vessel_count(), "vessel"));
    let size = match input.contents {
        Contents::Centerlines(points) => {
            let parts = plural(fragments(network, |_, _| true).count, "fragment");
            format!("{parts}, {vessels}, {}", plural(points, "point"))
        }
        Contents::Vessels => format!("{nodes}, {vessels}"),
        Contents::Graph => {
            let of = |origin: Origin| network.vessels().filter(|(_, v)| v.origin == origin).count();
            let [observed, candidates] = [Origin::Observed, Origin::Candidate].map(|origin| count(of(origin) as u64));
            let contacts = match of(Origin::Contact) {
                0 => String::new(),
                contacts => format!(", {}", plural(contacts, "contact")),
            };
            format!("{nodes}, {observed} observed and {candidates} candidate vessels{contacts}")
        }
    };
    let heading = format!("{}, {}{assumed}", source.format, source.units);
    terminal.say("read", format!("{}: {heading}: {size}{}", source.input, radii(network)));
    terminal.notes(&source.notes);
}

/// The range of the radii, after a comma.
fn radii(network: &Network) -> String {
    let radii = || network.vessels().map(|(_, v)| millimetres(v.radius));
    let [low, high] = [radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max)].map(brief);
    match network.vessel_count() {
        0 => String::new(),
        _ if low == high => format!(", radius {low} mm"),
        _ => format!(", radius {low} - {high} mm"),
    }
}

/// Says that a step of the method is done.
pub fn say_step(terminal: TextTerminal, step: &Step<'_>) {
    match step {
        Step::Located { name, node, found, is_in_file } => {
            let fact = format!("{name} is node {node}{}", found.note());
            if *is_in_file { terminal.detail("condition", fact) } else { terminal.say("condition", fact) }
        }
        Step::OutletsAllStated => {
            terminal.say("note", "`outlets` changes nothing: every outlet is stated; `outlet=NODE=ground` or `bc` replaces it");
        }
        Step::Built { graph, options, by_evidence } => {
            let candidates = graph.vessels().filter(|(_, v)| v.origin == Origin::Candidate).count();
            let (nodes, vessels) = (plural(graph.node_count(), "node"), plural(graph.vessel_count(), "vessel"));
            let how = options.k.filter(|_| !by_evidence).map_or_else(|| "by evidence".to_owned(), |k| format!("k = {k}"));
            terminal.say("built", format!("{} in a graph of {nodes}, {vessels} ({how})", plural(candidates, "candidate")));
        }
        Step::Cut { graph, with_mask, with_image } => {
            let contacts = graph.vessels().filter(|(_, v)| v.origin == Origin::Contact).count();
            let how = match (with_mask, with_image) {
                (_, true) => "the mask and the image",
                (true, false) => "the mask",
                (false, false) => "the lines alone",
            };
            terminal.say("cut", format!("{} between vessels that may only touch (by {how})", plural(contacts, "contact")));
        }
        Step::CutsSuggested { suggested: 0 } => {}
        Step::CutsSuggested { suggested } => {
            let cuts = plural(*suggested, "cut");
            terminal
                .say("suggested", format!("{cuts} where vessels may only touch (by the lines alone): `cut=always`, or `mask`"));
        }
        Step::Boundary { graph, boundary } => say_boundary(terminal, graph, boundary),
        Step::Note(note) => terminal.say("note", note),
        Step::Sampling { graph, options, until_stable } => {
            let samples =
                if *until_stable { "samples until stable".to_owned() } else { format!("{} samples", count(options.samples)) };
            let uncertain = options.uncertain.vessels(graph).iter().filter(|u| **u).count();
            let threads = plural(rayon::current_num_threads(), "thread");
            let how = format!("epsilon {}, {samples}, seed {}, {threads}", options.epsilon, options.seed);
            let vessels = plural(graph.vessel_count(), "vessel");
            terminal.say("sampling", format!("{how}: {} of {vessels} uncertain", count(uncertain as u64)));
        }
    }
}

/// Up to this many inlets, and outlets, are named without `--verbose`.
const MOST_CONDITIONS: usize = 6;

/// Says which conditions are used, and which of them were found.
fn say_boundary(terminal: TextTerminal, network: &Network, boundary: &Boundary) {
    for (role, heading, found) in
        [(Role::Inlet, "inlets", &boundary.found_inlets), (Role::Outlet, "outlets", &boundary.found_outlets)]
    {
        let rows: Vec<usize> = (0..network.node_count()).filter(|n| boundary.roles[*n] == role).collect();
        let word = |n: &usize| Some(format!("{} ({})", network.node(*n).id, words(boundary.condition(*n)?)));
        let words: Vec<String> = rows.iter().filter_map(word).collect();
        let how = match found.len() {
            0 => String::new(),
            n if n == rows.len() => match role {
                Role::Inlet if found.iter().all(|n| network.node(*n).is_source) => ", the source that the file states".to_owned(),
                Role::Inlet => ", found at free ends".to_owned(),
                _ => ", found: the other free ends".to_owned(),
            },
            n => format!(", {} of them found at free ends", count(n as u64)),
        };
        let shown = listed(words.iter().cloned(), MOST_CONDITIONS);
        terminal.say(heading, format!("{}{how}: {shown}", plural(rows.len(), "node")));
        words.iter().skip(MOST_CONDITIONS).for_each(|word| terminal.detail(heading, word));
    }
    let unfed = unfed_fragments(network, boundary);
    if unfed > 0 {
        let what = plural(unfed, "fragment");
        terminal.say("unfed", format!("{what} that nothing can join to an inlet: no blood flows there"));
    }
}

fn words(condition: Condition) -> String {
    match condition {
        Condition::Pressure(0.0) => "ground".into(),
        Condition::Pressure(p) => format!("{} mmHg", brief(mmhg(p))),
        Condition::Resistance { resistance, venous } => {
            let venous = if venous == 0.0 { String::new() } else { format!(" to {} mmHg", brief(mmhg(venous))) };
            format!("{} mmHg·s/mL{venous}", brief(mmhg_s_per_ml(resistance)))
        }
        Condition::Flow(flow) => format!("{} mL/min", brief(ml_per_min(flow))),
    }
}

/// Up to this many notes of single cases are printed without `--verbose`.
const MOST: usize = 3;

/// Prints each note with the number of cases that it applies to (each a `noun`): those of several cases always, the others with `--verbose`.
pub fn say_notes(terminal: TextTerminal, notes: &BTreeMap<String, usize>, noun: &str) {
    let mut untold = 0;
    for (note, of) in notes {
        let line = format!("{note} ({})", plural(*of, noun));
        if *of > 1 || notes.len() <= MOST {
            terminal.say("note", line);
        } else {
            untold += 1;
            terminal.detail("note", line);
        }
    }
    if untold > 0 {
        terminal.say("note", format!("{} of one {noun} each; -v says them", plural(untold, "further note")));
    }
}

/// Notes counted; those that differ in their figures alone are one, with `…` for these.
pub fn counted<'a>(notes: impl IntoIterator<Item = &'a str>) -> BTreeMap<String, usize> {
    let mut alike: BTreeMap<String, (&str, bool, usize)> = BTreeMap::new();
    for note in notes {
        let (first, is_same, of) = alike.entry(without_figures(note)).or_insert((note, true, 0));
        *is_same &= *first == note;
        *of += 1;
    }
    alike.into_iter().map(|(form, (note, is_same, of))| (if is_same { note.to_owned() } else { form }, of)).collect()
}

/// A note with `…` for every figure, and one word for one thing and several.
fn without_figures(note: &str) -> String {
    let mut counts = false;
    let mut word = |word: &str| {
        let figure = word.trim_matches(['(', ')', ',', ';', ':']);
        let is_figure =
            figure.starts_with(|c: char| c.is_ascii_digit() || c == '-') && figure.ends_with(|c: char| c.is_ascii_digit());
        match (std::mem::replace(&mut counts, is_figure), is_figure, word) {
            (_, true, _) => word.replace(figure, "…"),
            (true, _, "point" | "vessel" | "link" | "edge" | "speck" | "spur") => format!("{word}s"),
            _ => word.to_owned(),
        }
    };
    note.split(' ').map(&mut word).collect::<Vec<_>>().join(" ")
}
