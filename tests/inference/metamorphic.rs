//! The same vessels described in another way give the same answer: units, the order of lines, rigid motions, formats, fragments far away,
//! points doubled, positions moved by a nanometre. The truth of each is the answer to the vessels as they were.
//!
//! `WILLIS_METAMORPHIC=table` runs every relation over every brain of `../shared` and prints the table of `experiments/metamorphic/`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::draw::Draw;
use willis::internals::network::{Origin, Role};
use willis::internals::support::geometry::distance;
use willis::{InferOptions, LengthUnit, ReadOptions, SamplingOptions, Scale};

/// The side of the voxels of the brains of `../shared`, about, mm.
const VOXEL: f64 = 0.36;

/// A line of an SWC file: number, type, position, radius (mm), parent.
#[derive(Debug, Clone, Copy)]
struct Line {
    number: i64,
    kind: i64,
    at: [f64; 3],
    radius: f64,
    parent: i64,
}

fn lines(text: &str, scale: f64) -> Vec<Line> {
    let line = |text: &str| {
        let fields: Vec<f64> = text.split_whitespace().map(|field| field.parse().expect("a number")).collect();
        Line {
            number: fields[0] as i64,
            kind: fields[1] as i64,
            at: [2, 3, 4].map(|i| scale * fields[i]),
            radius: scale * fields[5],
            parent: fields[6] as i64,
        }
    };
    text.lines().filter(|line| !line.trim_start().starts_with('#') && !line.trim().is_empty()).map(line).collect()
}

fn swc(lines: &[Line]) -> Vec<u8> {
    let mut text = String::new();
    for Line { number, kind, at: [x, y, z], radius, parent } in lines {
        writeln!(text, "{number} {kind} {x} {y} {z} {radius} {parent}").expect("written");
    }
    text.into_bytes()
}

/// What is said of a vessel or a node, by where it is: probability, L, whether it is kept; roles as 1 and 2.
type Answer = BTreeMap<[i64; 6], [f64; 3]>;

/// Positions in steps of a micrometre and a half, after what was done to them is undone.
fn place(at: [f64; 3], undo: &dyn Fn([f64; 3]) -> [f64; 3]) -> [i64; 3] {
    undo(at.map(|x| 1e3 * x)).map(|mm| (mm / 1.5e-3).round() as i64)
}

fn answer(name: &str, bytes: &[u8], unit: LengthUnit, undo: &dyn Fn([f64; 3]) -> [f64; 3]) -> (Answer, Answer) {
    let spacing = (unit == LengthUnit::Voxel).then_some([VOXEL; 3]);
    let options = ReadOptions { scale: Scale { unit, spacing }, ..ReadOptions::default() };
    answer_to(&willis::read_bytes(Path::new(name), bytes, &options).expect("is read"), undo)
}

fn answer_to(input: &willis::Input, undo: &dyn Fn([f64; 3]) -> [f64; 3]) -> (Answer, Answer) {
    let sampling = SamplingOptions { samples: 64, ..SamplingOptions::default() };
    let run = willis::infer(input, &InferOptions { sampling, ..InferOptions::default() }).expect("runs");
    let (graph, mut vessels, mut roles) = (run.graph(), Answer::new(), Answer::new());
    let at = |node: usize| place(graph.node(node).position.expect("a position"), undo);
    for (row, (ends, vessel)) in graph.vessels().enumerate().filter(|(_, (_, v))| v.origin == Origin::Candidate) {
        let [a, b] = ends.map(at);
        let [a, b] = [a.min(b), a.max(b)];
        let kept = if run.kept()[row] { 1.0 } else { 0.0 };
        let figures = [vessel.prior, run.likelihood().likelihood[row], kept];
        vessels.insert([a[0], a[1], a[2], b[0], b[1], b[2]], figures);
    }
    for (node, role) in run.boundary().roles.iter().enumerate().filter(|(_, role)| matches!(role, Role::Inlet | Role::Outlet)) {
        let [x, y, z] = at(node);
        roles.insert([x, y, z, 0, 0, 0], [if *role == Role::Inlet { 1.0 } else { 2.0 }, 0.0, 0.0]);
    }
    (vessels, roles)
}

/// How far two answers are from each other.
#[derive(Debug, Clone, Copy, Default)]
struct Change {
    /// The largest change of a probability, that of a candidate that only one of them has included.
    probability: f64,
    /// The largest change of L as a share of the largest L; NaN where samples are others.
    likelihood: f64,
    /// Decisions that differ.
    flips: usize,
    /// Roles of nodes that differ.
    roles: usize,
}

impl Change {
    fn worst(self, other: Self) -> Self {
        Self {
            probability: self.probability.max(other.probability),
            likelihood: self.likelihood.max(other.likelihood),
            flips: self.flips + other.flips,
            roles: self.roles + other.roles,
        }
    }
}

/// Candidates less probable than this are left out of the graph, so that one at the border may be in one answer only.
const LEAST: f64 = 2e-3;

fn change([before, roles]: [&Answer; 2], [after, roles_after]: [&Answer; 2], same_samples: bool) -> Change {
    let mut out = Change::default();
    let largest = before.values().map(|figures| figures[1]).fold(0.0, f64::max);
    let absent = [0.0; 3];
    for place in before.keys().chain(after.keys().filter(|place| !before.contains_key(*place))) {
        let [a, b] = [before, after].map(|answer| near(answer, place).unwrap_or(absent));
        if a[0].max(b[0]) < LEAST {
            continue;
        }
        out.probability = out.probability.max((a[0] - b[0]).abs());
        out.flips += usize::from(a[2] != b[2]);
        if same_samples && largest > 0.0 {
            out.likelihood = out.likelihood.max((a[1] - b[1]).abs() / largest);
        }
    }
    out.roles = roles.iter().filter(|(place, role)| near(roles_after, place) != Some(**role)).count();
    out
}

/// The figures at a place, or at one that is rounded to the next step.
fn near(answer: &Answer, place: &[i64; 6]) -> Option<[f64; 3]> {
    let exact = answer.get(place).copied();
    let close = |(other, _): &(&[i64; 6], &[f64; 3])| other.iter().zip(place).all(|(a, b)| (a - b).abs() <= 1);
    let mut from = *place;
    from[0] -= 1;
    from[1..].fill(i64::MIN);
    let mut to = *place;
    to[0] += 1;
    to[1..].fill(i64::MAX);
    exact.or_else(|| answer.range(from..=to).find(close).map(|(_, figures)| *figures))
}

/// A relation: what is done to the vessels, and whether the samples are the same, so that L can be compared.
struct Relation {
    name: &'static str,
    same_samples: bool,
    /// The largest change of a probability that is promised, and of L.
    promised: [f64; 2],
    /// Whether every node keeps the role that was found for it.
    keeps_roles: bool,
    answer: fn(&[Line], u64) -> (Answer, Answer),
}

fn as_it_is(at: [f64; 3]) -> [f64; 3] {
    at
}

fn plain(lines: &[Line]) -> (Answer, Answer) {
    answer("a.swc", &swc(lines), LengthUnit::Millimetre, &as_it_is)
}

fn moved(lines: &[Line], by: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<Line> {
    lines.iter().map(|line| Line { at: by(line.at), ..*line }).collect()
}

fn sized(lines: &[Line], by: f64) -> Vec<Line> {
    lines.iter().map(|line| Line { at: line.at.map(|x| by * x), radius: by * line.radius, ..*line }).collect()
}

/// Turned about the third axis and shifted: heights differ by the shift alone, as found inlets of one width are told apart by height.
fn turned_upright([x, y, z]: [f64; 3]) -> [f64; 3] {
    [COS * x - SIN * y + 17.0, SIN * x + COS * y - 5.0, z + 3.0]
}

fn back_upright([x, y, z]: [f64; 3]) -> [f64; 3] {
    let [x, y] = [x - 17.0, y + 5.0];
    [COS * x + SIN * y, COS * y - SIN * x, z - 3.0]
}

const COS: f64 = 0.8;
const SIN: f64 = 0.6;

fn turned([x, y, z]: [f64; 3]) -> [f64; 3] {
    let [y, z] = [COS * y - SIN * z, SIN * y + COS * z];
    [COS * x - SIN * y + 17.0, SIN * x + COS * y - 5.0, z + 3.0]
}

fn back([x, y, z]: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = [x - 17.0, y + 5.0, z - 3.0];
    let [x, y] = [COS * x + SIN * y, COS * y - SIN * x];
    [x, COS * y + SIN * z, COS * z - SIN * y]
}

/// The lines in another order, with other numbers, a parent still before its children or not.
fn shuffled(lines: &[Line], seed: u64) -> Vec<Line> {
    let mut draw = Draw::new(seed);
    let mut order: Vec<usize> = (0..lines.len()).collect();
    for last in (1..order.len()).rev() {
        order.swap(last, draw.below(last + 1));
    }
    let new: BTreeMap<i64, i64> = order.iter().enumerate().map(|(at, row)| (lines[*row].number, at as i64 + 1)).collect();
    let parent = |line: &Line| if line.parent < 0 { -1 } else { new[&line.parent] };
    order.iter().map(|row| Line { number: new[&lines[*row].number], parent: parent(&lines[*row]), ..lines[*row] }).collect()
}

/// With an isolated fragment of three points a metre and five times as far away as anything, 5 mm thick, and another one as far as 1,000 km.
fn with_far_fragments(lines: &[Line]) -> Vec<Line> {
    let far = 1000.0 + 5.0 * lines.iter().flat_map(|line| line.at).fold(0.0, |most: f64, x| most.max(x.abs()));
    let first = lines.iter().map(|line| line.number).max().unwrap_or(0) + 1;
    let point = |i: i64| Line {
        number: first + i,
        kind: 0,
        at: [if i < 3 { far } else { 1e9 } + 4.0 * i as f64, 0.9 * far, 0.8 * far],
        radius: 5.0,
        parent: if i % 3 == 0 { -1 } else { first + i - 1 },
    };
    lines.iter().copied().chain((0..6).map(point)).collect()
}

/// Every point twice, one of the two without a child.
fn with_doubles(lines: &[Line]) -> Vec<Line> {
    let offset = lines.iter().map(|line| line.number).max().unwrap_or(0);
    let double = |line: &Line| Line { number: line.number + offset, parent: line.number, ..*line };
    lines.iter().copied().chain(lines.iter().map(double)).collect()
}

fn jittered(lines: &[Line], seed: u64) -> Vec<Line> {
    let mut draw = Draw::new(seed);
    lines.iter().map(|line| Line { at: line.at.map(|x| x + draw.within(-5e-10, 5e-10)), ..*line }).collect()
}

fn converted(lines: &[Line], name: &str) -> (Answer, Answer) {
    let folder = tempfile::tempdir().expect("a folder");
    let (from, to) = (folder.path().join("a.swc"), folder.path().join(name));
    std::fs::write(&from, swc(lines)).expect("written");
    let input = willis::read(&from, &ReadOptions::default()).expect("is read");
    willis::write(&input.network, &to, None, true).expect("is written");
    // SWC holds no loops: the links that close them are in a file beside it.
    let loops = Some(to.with_extension("loops.csv")).filter(|loops| loops.exists());
    answer_to(&willis::read(&to, &ReadOptions { loops, ..ReadOptions::default() }).expect("is read"), &as_it_is)
}

/// What is exact in numbers that binary fractions hold is promised to the last digits, what rounds to those that rounding reaches.
const RELATIONS: [Relation; 14] = [
    Relation {
        name: "units: cm",
        same_samples: true,
        promised: [1e-9, 1e-9],
        keeps_roles: true,
        answer: |lines, _| answer("a.swc", &swc(&sized(lines, 0.1)), LengthUnit::Centimetre, &as_it_is),
    },
    Relation {
        name: "units: um",
        same_samples: true,
        promised: [1e-9, 1e-9],
        keeps_roles: true,
        answer: |lines, _| answer("a.swc", &swc(&sized(lines, 1e3)), LengthUnit::Micrometre, &as_it_is),
    },
    Relation {
        name: "units: m",
        same_samples: true,
        promised: [1e-9, 1e-9],
        keeps_roles: true,
        answer: |lines, _| answer("a.swc", &swc(&sized(lines, 1e-3)), LengthUnit::Metre, &as_it_is),
    },
    Relation {
        name: "rotation about the third axis and shift",
        same_samples: true,
        promised: [1e-9, 1e-9],
        keeps_roles: true,
        answer: |lines, _| answer("a.swc", &swc(&moved(lines, turned_upright)), LengthUnit::Millimetre, &back_upright),
    },
    Relation {
        name: "rotation about all axes and shift",
        same_samples: false,
        promised: [1e-9, 0.0],
        keeps_roles: false,
        answer: |lines, _| answer("a.swc", &swc(&moved(lines, turned)), LengthUnit::Millimetre, &back),
    },
    Relation {
        name: "mirror",
        same_samples: true,
        promised: [1e-9, 1e-9],
        keeps_roles: true,
        answer: |lines, _| {
            answer("a.swc", &swc(&moved(lines, |[x, y, z]| [-x, y, z])), LengthUnit::Millimetre, &|[x, y, z]| [-x, y, z])
        },
    },
    Relation {
        name: "units: voxels of 0.36 mm",
        same_samples: true,
        promised: [1e-9, 1e-9],
        keeps_roles: true,
        answer: |lines, _| answer("a.swc", &swc(&sized(lines, 1.0 / VOXEL)), LengthUnit::Voxel, &as_it_is),
    },
    Relation {
        name: "order of lines",
        same_samples: false,
        promised: [1e-9, 0.0],
        keeps_roles: true,
        answer: |lines, seed| plain(&shuffled(lines, seed)),
    },
    Relation {
        name: "format: VTP",
        same_samples: false,
        promised: [1e-9, 0.0],
        keeps_roles: true,
        answer: |lines, _| converted(lines, "a.vtp"),
    },
    Relation {
        name: "format: VTK",
        same_samples: false,
        promised: [1e-9, 0.0],
        keeps_roles: true,
        answer: |lines, _| converted(lines, "a.vtk"),
    },
    Relation {
        name: "format: SWC again",
        same_samples: false,
        promised: [1e-9, 0.0],
        keeps_roles: true,
        answer: |lines, _| converted(lines, "b.swc"),
    },
    Relation {
        name: "far fragment",
        same_samples: false,
        promised: [0.0, 0.0],
        keeps_roles: false,
        answer: |lines, _| plain(&with_far_fragments(lines)),
    },
    Relation {
        name: "points doubled",
        same_samples: false,
        promised: [1e-9, 0.0],
        keeps_roles: true,
        answer: |lines, _| plain(&with_doubles(lines)),
    },
    Relation {
        name: "moved by 1e-9 mm",
        same_samples: true,
        promised: [1e-6, 1e-4],
        keeps_roles: true,
        answer: |lines, seed| plain(&jittered(lines, seed)),
    },
];

/// The shipped circle, and brains of `../shared` where they are there: so many.
fn inputs(most: usize) -> Vec<(String, Vec<Line>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = |path: &Path| std::fs::read_to_string(path).expect("read");
    let mut found = vec![("circle".to_owned(), lines(&text(&root.join("data/broken-circle-of-willis.swc")), 1.0))];
    let brains = root.join("../shared/data/insist-cow");
    let mut folders: Vec<PathBuf> = std::fs::read_dir(brains).into_iter().flatten().flatten().map(|e| e.path()).collect();
    folders.sort();
    if folders.is_empty() {
        eprintln!("skipped: no brains in ../shared");
    }
    for folder in folders.into_iter().filter(|folder| folder.is_dir()).take(most) {
        let files = std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|e| e.path());
        for file in files.filter(|file| file.extension().is_some_and(|e| e == "swc")) {
            let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if most == usize::MAX {
                // Whole numbers, so that equal distances are equal to the last bit.
                found.push((format!("{name} in voxels of 1 mm"), lines(&text(&file), 1.0)));
            }
            found.push((name, lines(&text(&file), VOXEL)));
        }
    }
    found
}

#[test]
fn the_same_vessels_described_in_another_way_give_the_same_answer() {
    let table = std::env::var("WILLIS_METAMORPHIC").is_ok_and(|word| word == "table");
    let inputs = inputs(if table { usize::MAX } else { 2 });
    let mut wrong = Vec::new();
    let mut rows = String::from(
        "| relation | cases | largest change of P | of L | decisions that flip | roles that differ |\n|---|---|---|---|---|---|\n",
    );
    let before: Vec<(Answer, Answer)> = inputs.iter().map(|(_, lines)| plain(lines)).collect();
    for relation in &RELATIONS {
        let mut worst = Change::default();
        for (seed, ((name, lines), before)) in inputs.iter().zip(&before).enumerate() {
            let after = (relation.answer)(lines, seed as u64 + 1);
            let mut found = change([&before.0, &before.1], [&after.0, &after.1], relation.same_samples);
            if relation.name == "far fragment" {
                // Its ends are conditions of their own.
                found.roles = before.1.iter().filter(|(place, role)| near(&after.1, place) != Some(**role)).count();
            }
            let [probability, likelihood] = relation.promised;
            if found.probability > probability || found.likelihood > likelihood || relation.keeps_roles && found.roles > 0 {
                wrong.push(format!("{} of {name}: {found:?}", relation.name));
            }
            if table && (found.probability > probability || relation.keeps_roles && found.roles > 0) {
                println!("{} of {name}: {found:?}", relation.name);
            }
            worst = worst.worst(found);
        }
        let of_l = if relation.same_samples { format!("{:.0e}", worst.likelihood) } else { "-".to_owned() };
        writeln!(
            rows,
            "| {} | {} | {:.0e} | {of_l} | {} | {} |",
            relation.name,
            inputs.len(),
            worst.probability,
            worst.flips,
            worst.roles
        )
        .expect("written");
    }
    if table {
        println!("{rows}");
    } else {
        assert!(wrong.is_empty(), "{}\n{rows}", wrong.join("\n"));
    }
}

/// A real mask where its header says that it lies elsewhere, by lengths that its voxels do not divide: ties on the lattice are not decided by
/// rounding.
#[test]
fn a_mask_that_lies_elsewhere_has_the_same_answer() {
    let masks = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/kdxf-masks");
    if !masks.is_dir() {
        return eprintln!("skipped: no masks in ../shared");
    }
    for name in ["KDXF_001", "KDXF_003"] {
        let mut bytes = Vec::new();
        let packed = std::fs::File::open(masks.join(format!("{name}.nii.gz"))).expect("opened");
        std::io::Read::read_to_end(&mut flate2::read::MultiGzDecoder::new(packed), &mut bytes).expect("unpacked");
        let answer = |bytes: &[u8]| {
            let input = willis::read_bytes(Path::new("mask.nii"), bytes, &ReadOptions::default()).expect("is read");
            let sampling = SamplingOptions { samples: 1, ..SamplingOptions::default() };
            let run = willis::infer(&input, &InferOptions { sampling, ..InferOptions::default() }).expect("runs");
            // Whatever was cut apart, points run from node to node, so that the graph can be read again.
            for (ends, vessel) in run.graph().vessels().filter(|(_, vessel)| !vessel.path.is_empty()) {
                let ends = ends.map(|node| run.graph().node(node).position.expect("a place"));
                let [first, last] = [0, vessel.path.len() - 1].map(|point| vessel.path[point].position);
                let away = distance(ends[0], first).max(distance(ends[1], last));
                assert!(away < 1e-9, "{name}: {:?} is {away} m off its nodes", vessel.origin);
            }
            let of = |(ends, vessel): ([usize; 2], &willis::internals::network::Vessel)| (ends, vessel.origin, vessel.prior);
            (run.graph().vessels().map(of).collect::<Vec<_>>(), run.kept().to_vec())
        };
        let (before, kept) = answer(&bytes);
        // The fourth figure of each row of the affine, and that of the quaternion.
        for (axis, by) in [10.3_f32, -7.7, 3.1].into_iter().enumerate() {
            for at in [280 + 16 * axis + 12, 268 + 4 * axis] {
                let there = f32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
                bytes[at..at + 4].copy_from_slice(&(there + by).to_le_bytes());
            }
        }
        let (after, kept_after) = answer(&bytes);
        assert!(before.iter().any(|(_, origin, _)| *origin == Origin::Contact), "{name} has contacts");
        assert!(kept == kept_after, "{name}: other decisions");
        assert_eq!(before.len(), after.len());
        for ((ends, origin, p), (ends_after, origin_after, p_after)) in before.iter().zip(&after) {
            assert_eq!((ends, origin), (ends_after, origin_after));
            assert!((p - p_after).abs() < 1e-9, "{name}: {ends:?} {origin:?} {p} {p_after}");
        }
    }
}
