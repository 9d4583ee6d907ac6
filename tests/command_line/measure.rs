//! `willis measure`: its tables of files, runs and cohorts, held against NetworkX, and what it refuses.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::command::{data, folder, stderr, willis};

fn table(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn cell(path: &Path, row: usize, column: &str) -> String {
    let table = table(path);
    let at = table[0].iter().position(|name| name == column).unwrap_or_else(|| panic!("{column}: {:?}", table[0]));
    table[row + 1][at].clone()
}

fn done(here: &Path, words: &[&str]) {
    let output = willis(here, words);
    assert!(output.status.success(), "{words:?}: {}", stderr(&output));
}

/// Of a ready graph that NetworkX reads: lengths, parts, loops and ways are those that it finds.
const BY_NETWORKX: &str = "
import sys, networkx as nx, pandas as pd
out, file = sys.argv[1:]
graph = nx.MultiGraph(nx.read_graphml(file, force_multigraph=True))
graph.remove_nodes_from([n for n, d in list(graph.degree()) if d == 0])
subject = pd.read_csv(out + '/subjects.csv').iloc[0]
length = sum(d['length_mm'] for _, _, d in graph.edges(data=True))
parts = nx.number_connected_components(graph)
assert abs(subject.length_mm - length) < 1e-9 * length, (subject.length_mm, length)
assert subject.parts == parts, (subject.parts, parts)
assert subject.loops == graph.number_of_edges() - graph.number_of_nodes() + parts
assert subject.ends == sum(d == 1 for _, d in graph.degree())
assert subject.bifurcations == sum(d > 2 for _, d in graph.degree())
inlets = [n for n, d in graph.nodes(data=True) if d.get('role') == 'inlet']
ways = nx.multi_source_dijkstra_path_length(graph, inlets, weight='length_mm')
ends = pd.read_csv(out + '/ends.csv', dtype={'id': str})
name = {str(d.get('id', n)): n for n, d in graph.nodes(data=True)}
for end in ends.itertuples():
    way = ways.get(name[end.id])
    assert (way is None and end.from_inlet_mm != end.from_inlet_mm) or abs(way - end.from_inlet_mm) < 1e-9 * max(way, 1), end
assert len(inlets) > 0 and len(ends) > 3
";

#[test]
fn a_run_is_measured_as_networkx_measures_its_topology() {
    let here = folder();
    done(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "out", "-n", "10", "--dpi", "36"]);
    done(here.path(), &["measure", "out", "-o", "measured"]);
    let intervals = here.path().join("measured/intervals.csv");
    let rows = table(&intervals).len() - 1;
    assert_eq!(rows, 17, "a row for every figure of a whole network");
    let number = |row, column| cell(&intervals, row, column).parse::<f64>().unwrap_or(f64::NAN);
    for row in 0..rows {
        let [mean, low, high] = ["mean", "low", "high"].map(|column| number(row, column));
        assert!(low <= mean + 1e-9 * mean && mean <= high + 1e-9 * mean || mean.is_nan(), "{row}: {low} {mean} {high}");
    }
    // The pieces of a broken circle are joined in more ways than one.
    assert!((0..rows).any(|row| number(row, "low") < number(row, "high")));
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        println!("skipped: WILLIS_PYTHON names no Python with NetworkX");
        return;
    };
    let checked = Command::new(python)
        .current_dir(here.path())
        .args(["-c", BY_NETWORKX, "measured", "out/topology.graphml"])
        .output()
        .expect("runs");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
}

/// One gap between two vessels of 20 mm, over which one connection leads: the figures of a run are those with and without it, by its probability.
#[test]
fn the_interval_of_a_gap_is_that_of_its_probability() {
    let here = folder();
    let points = |from: f64, y: f64| (0..=20).map(move |i| (from + f64::from(i), y)).collect::<Vec<_>>();
    let both = points(0.0, 0.0).into_iter().chain(points(29.0, 6.0)).enumerate();
    let line = |(at, (x, y)): (usize, (f64, f64))| {
        let parent = if at % 21 == 0 { -1 } else { at as i64 };
        format!("{} 0 {x} {y} 0 1 {parent}\n", at + 1)
    };
    fs::write(here.path().join("gap.swc"), both.map(line).collect::<Vec<String>>().concat()).expect("written");
    done(here.path(), &["infer", "gap.swc", "-o", "out", "-n", "10", "-k", "1", "--dpi", "36"]);
    done(here.path(), &["measure", "out", "-o", "measured"]);
    let edges = here.path().join("out/edges.csv");
    assert_eq!(table(&edges).len(), 4, "two vessels and a candidate");
    let of_gap = |column: &str| cell(&edges, 2, column).parse::<f64>().expect(column);
    let (p, gap) = (of_gap("probability"), of_gap("length_mm"));
    assert!(0.05 < p && p < 0.95 && (gap - 9.0_f64.hypot(6.0)).abs() < 1e-9, "{p} {gap}");
    let intervals = here.path().join("measured/intervals.csv");
    let row = table(&intervals)[1..].iter().position(|row| row[1] == "length_mm").expect("a row");
    let number = |column: &str| cell(&intervals, row, column).parse::<f64>().expect(column);
    // 200 topologies.
    assert!((number("mean") - (40.0 + p * gap)).abs() < 4.5 * gap * (p * (1.0 - p) / 200.0).sqrt(), "{p}: {}", number("mean"));
    assert!((number("low") - 40.0).abs() < 1e-9 && (number("high") - (40.0 + gap)).abs() < 1e-9);
}

/// What R makes of every column of a folder of tables, read without an option but for the names: whether it holds numbers, how many, and their sum.
const BY_R: &str = "
for (name in sort(list.files('measured', '[.]csv$'))) {
  table <- read.csv(file.path('measured', name), check.names = FALSE)
  for (column in names(table)) {
    x <- table[[column]]
    n <- if (is.numeric(x)) sum(!is.na(x)) else if (is.logical(x)) 0 else -1
    cat(name, column, nrow(table), n, format(if (n > 0) sum(x, na.rm = TRUE) else 0, digits = 15), sep = '\t', fill = FALSE)
    cat('\n')
  }
}";

/// The same by pandas, held against it.
const BY_PANDAS: &str = "
import math, sys, pandas as pd
rows = [line.rstrip('\\n').split('\\t') for line in sys.stdin]
assert len({row[0] for row in rows}) >= 6 and len(rows) > 100, len(rows)
tables = {row[0]: pd.read_csv('measured/' + row[0]) for row in rows}
assert [row[1] for row in rows] == [column for table in tables.values() for column in table]
for name, column, count, n, total in rows:
    x = tables[name][column]
    own = x.count() if pd.api.types.is_numeric_dtype(x) else -1
    assert (len(x), own) == (int(count), int(n)), (name, column, n, own)
    assert own <= 0 or math.isclose(x.sum(), float(total), rel_tol=1e-9, abs_tol=1e-9), (name, column, total, x.sum())
";

#[test]
fn pandas_and_r_read_the_same_tables() {
    let here = folder();
    let (Ok(python), true) = (std::env::var("WILLIS_PYTHON"), Command::new("Rscript").arg("--version").output().is_ok()) else {
        println!("skipped: no Rscript on the path, or WILLIS_PYTHON names no Python with pandas");
        return;
    };
    done(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "runs/sub-05", "-n", "10", "--dpi", "36"]);
    for at in 0..4 {
        let copy = here.path().join(format!("runs/sub-0{at}.graphml"));
        fs::copy(data(&format!("circle-of-willis/{}.graphml", ["complete", "without-L-P1"][at % 2])), copy).expect("copied");
    }
    let rows = "participant_id\tage\tgroup\nsub-00\t61\ta, the first\nsub-01\t64\tb\nsub-02\t58\ta, the first\nsub-03\t70\tb\nsub-05\t66\tb\n";
    fs::write(here.path().join("participants.tsv"), rows).expect("written");
    let words = ["measure", "runs/*", "-o", "measured", "--participants", "participants.tsv", "--compare", "group"];
    done(here.path(), &words);
    fs::write(here.path().join("by.R"), BY_R).expect("written");
    let by_r = Command::new("Rscript").current_dir(here.path()).arg("by.R").output().expect("runs");
    assert!(by_r.status.success(), "{}", stderr(&by_r));
    fs::write(here.path().join("r.txt"), &by_r.stdout).expect("written");
    let told = fs::File::open(here.path().join("r.txt")).expect("there");
    let checked = Command::new(python).current_dir(here.path()).args(["-c", BY_PANDAS]).stdin(told).output().expect("runs");
    assert!(checked.status.success(), "{}", stderr(&checked));
}

/// Of a helix and a fork as lines, and as masks. The truth is the closed form; skan, VMTK and maskel are asked too, where a Python has them.
#[test]
fn drawn_courses_are_measured_as_other_programs_measure_them() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/command_line/measured.py");
    let pythons = ["WILLIS_PEERS", "WILLIS_PYTHON"].map(|name| std::env::var(name).ok());
    let Some(python) = pythons.into_iter().flatten().next() else {
        println!("skipped: neither WILLIS_PEERS nor WILLIS_PYTHON names a Python");
        return;
    };
    let here = folder();
    let checked =
        Command::new(python).current_dir(here.path()).arg(script).arg(env!("CARGO_BIN_EXE_willis")).output().expect("runs");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    for line in String::from_utf8_lossy(&checked.stdout).lines().filter(|line| line.starts_with("skipped")) {
        println!("{line}");
    }
}

/// Diameters, mm, of the circle of Alastruey et al. 2007, table 1.
#[test]
fn a_circle_has_its_published_diameters_and_territories() {
    let here = folder();
    for (name, words) in [("usual", &[][..]), ("wide", &["--hypoplastic", "1.47mm"])] {
        done(here.path(), &[&["measure", &data("circle-of-willis/complete.graphml"), "-o", name], words].concat());
    }
    let [usual, wide] = ["usual", "wide"].map(|name| here.path().join(name).join("subjects.csv"));
    let number = |table: &Path, column: &str| cell(table, 0, column).parse::<f64>().expect(column);
    for (segment, diameter) in
        [("L-A1", 2.34), ("R-A1", 2.34), ("AComm", 1.48), ("L-P1", 2.14), ("R-P1", 2.14), ("L-PComm", 1.46)]
    {
        let found = number(&usual, &format!("circle_{segment}_diameter_mm"));
        assert!((found - diameter).abs() < 1e-9, "{segment}: {found}");
        assert_eq!(number(&usual, &format!("circle_{segment}_hypoplastic")), 0.0);
        let is_thin = f64::from(u8::from(diameter < 1.47));
        assert_eq!(number(&wide, &format!("circle_{segment}_hypoplastic")), is_thin, "{segment}");
    }
    // M1 is 119 mm long, and the way there leads along 177 mm and 5 mm of carotid.
    let of_territory = ["length_mm", "from_inlet_mean_mm"].map(|what| number(&usual, &format!("territory_L-M1_{what}")));
    assert!((of_territory[0] - 119.0).abs() < 1e-9 && (of_territory[1] - (182.0 + 59.5)).abs() < 1e-9, "{of_territory:?}");
    assert_eq!(number(&usual, "territory_M1_asymmetry"), 0.0);
}

/// The volume of the vessels is nearly that of their mask, so that they fill the mask as if it were their brain.
#[test]
fn a_run_has_its_circle_over_plausible_topologies_and_densities_in_a_mask() {
    let here = folder();
    let (mask, landmarks) = (data("scan.nii.gz"), data("scan.landmarks.csv"));
    done(here.path(), &["infer", &mask, "--landmarks", &landmarks, "-o", "out", "-n", "10", "--dpi", "36"]);
    done(here.path(), &["measure", "out", "-o", "measured", "--brain", &mask]);
    let table_of = |name: &str| here.path().join("measured").join(name);
    let density: f64 = cell(&table_of("subjects.csv"), 0, "volume_density_in_brain").parse().expect("a density");
    assert!((density - 1.0).abs() < 0.05, "{density}");
    let intervals = table_of("intervals.csv");
    let figures: Vec<String> = (0..table(&intervals).len() - 1).map(|row| cell(&intervals, row, "figure")).collect();
    for wanted in ["circle_L-P1_diameter_mm", "fetal_L-PCA", "territory_L-M1_length_mm", "volume_density_in_brain"] {
        assert!(figures.iter().any(|figure| figure == wanted), "{wanted}: {figures:?}");
    }
    let territories: Vec<String> =
        (0..table(&table_of("vessels.csv")).len() - 1).map(|row| cell(&table_of("vessels.csv"), row, "territory")).collect();
    for wanted in ["L-A2", "R-A2", "L-M1", "R-M1", "L-P2", "R-P2"] {
        assert!(territories.iter().any(|territory| territory == wanted), "{wanted}");
    }
}

/// A mask of 61 x 21 x 21 voxels of 1 mm around `middle` (mm, in LPS as MetaImage has it). Those from -9 to 0 in x and up to -1 in y are 1.
fn brain(middle: [i32; 3]) -> Vec<u8> {
    let offset = [middle[0] - 30, middle[1] - 10, middle[2] - 10].map(|x| x.to_string()).join(" ");
    let head = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = {offset}\n\
         ElementSpacing = 1 1 1\nDimSize = 61 21 21\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
    );
    let voxel = |n: i32| u8::from((21..=30).contains(&(n % 61)) && n / 61 % 21 <= 9);
    [head.into_bytes(), (0..61 * 21 * 21).map(voxel).collect()].concat()
}

/// A line from 0 to 20 mm to the right, 2 mm in front of the origin: its first 9.5 mm lie in the mask, which has 10 x 10 x 21 mm. The same in each
/// frame that a file may state, and where the file states none in that of the mask.
#[test]
fn densities_in_a_brain_are_those_by_hand_in_either_frame() {
    let here = folder();
    let line = |space: &str, sign: i32| {
        let points =
            (0..=20).map(|n: i32| format!("{} 0 {} {} 0 1 {}\n", n + 1, sign * n, 2 * sign, if n == 0 { -1 } else { n }));
        fs::write(here.path().join(format!("{space}.swc")), format!("# SPACE={space}\n{}", points.collect::<String>()))
            .expect("written");
    };
    fs::write(here.path().join("brain.mha"), brain([0; 3])).expect("written");
    line("RAS", 1);
    line("LPS", -1);
    line("none", 1);
    for name in ["RAS.tre", "RAS.mrk.json", "LPS.vtp", "LPS.graphml"] {
        done(here.path(), &["convert", &format!("{}.swc", &name[..3]), name]);
    }
    let density = |input: &str, more: &[&str]| {
        done(here.path(), &[&["measure", input, "-o", "out", "--force", "--brain", "brain.mha"], more].concat());
        let figure = cell(&here.path().join("out/subjects.csv"), 0, "length_density_in_brain_per_mm2");
        figure.parse::<f64>().expect("a density")
    };
    let by_hand = 9.5 / (10.0 * 10.0 * 21.0);
    for input in ["RAS.swc", "LPS.swc", "none.swc", "RAS.tre", "RAS.mrk.json", "LPS.vtp", "LPS.graphml"] {
        let found = density(input, &[]);
        assert!((found / by_hand - 1.0).abs() < 0.06, "{input}: {found} {by_hand}");
    }
    fs::rename(here.path().join("none.swc"), here.path().join("a.swc")).expect("renamed");
    assert_eq!(density("a.swc", &["--frame", "RAS"]), density("RAS.swc", &[]));
}

#[test]
fn a_brain_that_does_not_hold_the_vessels_is_refused() {
    let here = folder();
    fs::write(here.path().join("a.swc"), "1 0 2 2 0 1 -1\n2 0 5 2 0 1 1\n3 0 8 2 0 1 2\n4 0 9 2 0 1 3\n5 0 29 2 0 1 4\n")
        .expect("written");
    let run = |middle: [i32; 3]| {
        fs::write(here.path().join("brain.mha"), brain(middle)).expect("written");
        let output = willis(here.path(), &["measure", "a.swc", "-o", "out", "--force", "--brain", "brain.mha"]);
        (output.status.code(), stderr(&output))
    };
    // In RAS its voxels run from 270 to 330 mm; the line ends at 29 mm.
    let (code, said) = run([-300, 0, 0]);
    assert!(code == Some(2) && said.contains("brain.mha: does not show the vessels: it lies 241.0 mm beside them"), "{said}");
    let (code, said) = run([0, 0, 8]);
    assert!(code == Some(0) && !said.contains("brain.mha holds"), "{said}");
    // They end at 4 mm: of five points and two ends the first point is in, which is an end.
    let (code, said) = run([5, 0, 0]);
    assert!(code == Some(0) && said.contains("brain.mha holds 28.6 % of the points of the vessels"), "{said}");
    // Those that are 1 end at 1 mm now, while the line begins within its box.
    let (code, said) = run([8, 0, 0]);
    assert!(code == Some(2) && said.contains("does not show the vessels: most of them lie outside of it"), "{said}");
}

#[test]
fn several_inputs_are_one_below_the_other_and_one_that_fails_is_a_row() {
    let here = folder();
    for name in ["a", "b"] {
        fs::write(here.path().join(format!("{name}.swc")), "1 0 0 0 0 1 -1\n2 0 10 0 0 1 1\n3 0 20 0 0 1 2\n").expect("written");
    }
    fs::write(here.path().join("c.swc"), "1 0 0 0 zero 1 -1\n").expect("written");
    let done = willis(here.path(), &["measure", "*.swc", "-o", "out"]);
    assert_eq!(done.status.code(), Some(1), "{}", stderr(&done));
    let [vessels, subjects] = ["vessels.csv", "subjects.csv"].map(|name| here.path().join("out").join(name));
    assert_eq!(table(&vessels).len(), 3, "two vessels under one header");
    assert_eq!(cell(&vessels, 1, "subject"), "b");
    assert_eq!(cell(&vessels, 1, "length_mm"), "20");
    assert_eq!(["a", "b", "c"].map(str::to_owned), [0, 1, 2].map(|row| cell(&subjects, row, "subject")));
    assert_eq!(cell(&subjects, 2, "status"), "failed");
    assert!(table(&here.path().join("out/intervals.csv"))[1..].is_empty());
}

/// A run that is measured from within its folder is called as that.
#[test]
fn a_run_is_called_as_its_folder_from_within_too() {
    let here = folder();
    done(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "brain", "-n", "64", "-q"]);
    done(&here.path().join("brain"), &["measure", ".", "-o", "../out", "-q"]);
    assert_eq!(cell(&here.path().join("out/subjects.csv"), 0, "subject"), "brain");
}

/// Lines along y, one of these lengths (mm) each, in files `sub-00.swc`, `sub-01.swc` and so on.
fn lines(here: &Path, lengths: impl Iterator<Item = f64>) {
    for (at, length) in lengths.enumerate() {
        let text = format!("1 0 0 0 0 1 -1\n2 0 {length} 0 0 1 1\n");
        fs::write(here.join(format!("sub-{at:02}.swc")), text).expect("written");
    }
}

fn participants(here: &Path, groups: impl Iterator<Item = &'static str>) {
    let rows: Vec<String> = groups.enumerate().map(|(at, group)| format!("sub-{at:02}\t{}\t{group}\n", 40 + at)).collect();
    fs::write(here.join("participants.tsv"), format!("participant_id\tage\tgroup\n{}", rows.concat())).expect("written");
}

/// Every figure by SciPy and NumPy: U for delta, exact permutations, the variance of delta from the matrix of dominance, Holm in two lines.
const BY_SCIPY: &str = "
import sys, numpy as np, pandas as pd
from scipy import stats
out, exact = sys.argv[1], sys.argv[2] == 'exact'
subjects, found = pd.read_csv(out + '/subjects.csv'), pd.read_csv(out + '/comparison.csv').set_index('measure')
assert subjects.age.tolist() == list(range(40, 40 + len(subjects))), 'participants are joined'
assert not {'vessels', 'age', 'radius_mm', 'X_diameter_mm'} & set(found.index), 'what is the same in all, but for rounding, says nothing'
for name, row in found.iterrows():
    a, b = (subjects[name][subjects.group == g].dropna().to_numpy() for g in (row.group_a, row.group_b))
    assert len(a) == len(b) == 3 or not name.startswith('X'), 'three of each group have it'
    assert (row.n_a, row.n_b) == (len(a), len(b))
    for x, side in ((a, 'a'), (b, 'b')):
        own = [row[q + '_' + side] for q in ('quartile_1', 'median', 'quartile_3')]
        assert np.allclose(own, np.quantile(x, [.25, .5, .75])), name
    delta = lambda x, y: 2 * stats.mannwhitneyu(x, y).statistic / (len(x) * len(y)) - 1
    assert abs(row.cliffs_delta - delta(a, b)) < 1e-12, name
    if exact:
        how = dict(permutation_type='independent', n_resamples=np.inf, alternative='greater')
        p = stats.permutation_test((a, b), lambda x, y: abs(np.sign(np.subtract.outer(x, y)).mean()) + 1e-13, vectorized=False, **how).pvalue
        assert abs(row.p - p) < 1e-12, (name, row.p, p)
    else:
        p = stats.mannwhitneyu(a, b, method='exact').pvalue
        assert abs(row.p - p) < 4 * np.sqrt(p * (1 - p) / 9999), (name, row.p, p)
    d = np.sign(np.subtract.outer(a, b)); n, m, mean = len(a), len(b), d.mean()
    s2 = (m**2 * ((d.mean(1) - mean)**2).sum() + n**2 * ((d.mean(0) - mean)**2).sum() - ((d - mean)**2).sum()) / (n * m * (n - 1) * (m - 1))
    s2 = max(s2, (1 - mean**2) / (n * m - 1)); z = stats.norm.ppf(.975)
    half = z * np.sqrt(s2) * np.sqrt((1 - mean**2)**2 + z**2 * s2)
    ends = [(mean - mean**3 + sign * half) / (1 - mean**2 + z**2 * s2) for sign in (-1, 1)] if mean < 1 else [(min(n, m) - z**2) / (min(n, m) + z**2), 1]
    assert mean < 1 or name.startswith('X')
    assert np.allclose([row.delta_low, row.delta_high], ends), (name, ends)
    assert row.doubt_share == 0, 'files have no doubt'
order = found.p.sort_values(kind='stable')
holm = np.minimum(1, np.maximum.accumulate(order.to_numpy() * np.arange(len(order), 0, -1)))
assert np.allclose(found.p_holm[order.index], holm)
assert len(found) > 3
";

#[test]
fn groups_are_compared_as_scipy_compares_them() {
    for (how, size) in [("exact", 5), ("drawn", 12)] {
        let here = folder();
        // The groups overlap; in a part that some have they do not.
        for at in 0..2 * size {
            let length = 20.0 + f64::from(at * 7 % 17) + 3.0 * f64::from(at % 2) + 0.01 * f64::from(at);
            let (name, kind) = if [0, 1, 6, 7, 8, 9].contains(&at) { ("# label 16 X\n", 16) } else { ("", 0) };
            let third = length / 3.0;
            let text = format!("{name}1 {kind} 0 0 0 1 -1\n2 {kind} {third} 0 0 1 1\n3 {kind} {length} 0 0 1 2\n");
            fs::write(here.path().join(format!("sub-{at:02}.swc")), text).expect("written");
        }
        participants(here.path(), (0..2 * size).map(|at| ["patient", "control"][at as usize % 2]));
        done(here.path(), &["measure", "*.swc", "-o", "out", "--participants", "participants.tsv", "--compare", "group"]);
        let table_of = here.path().join("out/comparison.csv");
        assert_eq!(cell(&table_of, 0, "group_a"), "control", "in the order of their names");
        let Ok(python) = std::env::var("WILLIS_PYTHON") else {
            println!("skipped: WILLIS_PYTHON names no Python with SciPy");
            return;
        };
        let checked = Command::new(python).current_dir(here.path()).args(["-c", BY_SCIPY, "out", how]).output().expect("runs");
        assert!(checked.status.success(), "{how}: {}", String::from_utf8_lossy(&checked.stderr));
    }
}

/// Fewer measures are corrected for less; runs bring the doubt about their topologies.
#[test]
fn measures_are_chosen_and_doubt_widens_the_interval() {
    let here = folder();
    done(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "first", "-n", "10", "--dpi", "36"]);
    for at in 0..6 {
        let copy = here.path().join(format!("runs/sub-{at}"));
        fs::create_dir_all(&copy).expect("made");
        for file in fs::read_dir(here.path().join("first")).expect("a folder").map(|entry| entry.expect("an entry").path()) {
            fs::copy(&file, copy.join(file.file_name().expect("a name"))).expect("copied");
        }
    }
    let rows: Vec<String> = (0..6).map(|at| format!("sub-{at},{}\n", ["a", "b"][at % 2])).collect();
    let rows = rows.concat();
    fs::write(here.path().join("groups.csv"), format!("subject,group\n{rows}")).expect("written");
    let compare = |output: &str, more: &[&str]| {
        done(
            here.path(),
            &[&["measure", "runs/*", "-o", output, "--participants", "groups.csv", "--compare", "group"], more].concat(),
        );
        here.path().join(output).join("comparison.csv")
    };
    // One network six times differs in nothing but what is plausible.
    let one = compare("one", &["--measures", "parts"]);
    assert_eq!(cell(&one, 0, "p"), cell(&one, 0, "p_holm"));
    assert_eq!(cell(&one, 0, "median_a"), cell(&one, 0, "median_b"));
    let number = |column: &str| cell(&one, 0, column).parse::<f64>().expect(column);
    assert!(number("doubt_share") > 0.0 && number("delta_low") < 0.0 && number("delta_high") > 0.0);
    assert!(number("p") > 0.05, "{}", number("p"));
    let again = compare("again", &["--measures", "parts", "--threads", "1"]);
    assert_eq!(fs::read(&one).expect("a table"), fs::read(&again).expect("a table"));
    let other = compare("other", &["--measures", "parts", "--seed", "1"]);
    assert_ne!(fs::read(&one).expect("a table"), fs::read(&other).expect("a table"));
}

#[test]
fn groups_that_cannot_be_compared_are_refused() {
    let here = folder();
    lines(here.path(), (0..4).map(|at| 20.0 + f64::from(at)));
    participants(here.path(), ["x", "y", "x", "y"].into_iter());
    let rows = "participant_id,group\nsub-00,x\nsub-01,y\nsub-02,x\nsub-03,y\n";
    for (name, text) in [
        ("three.csv", rows.replace("sub-03,y", "sub-03,z")),
        ("one.csv", rows.replace("sub-03,y", "sub-03,n/a")),
        ("short.csv", rows.replace("sub-03,y\n", "")),
        ("nameless.csv", rows.replace("participant_id", "who")),
        ("twice.csv", format!("{rows}02,y\n")),
    ] {
        fs::write(here.path().join(name), text).expect("written");
    }
    let base = ["measure", "*.swc", "-o", "out", "--compare"];
    for (words, wanted) in [
        (&["group"][..], "--compare group: goes with --participants"),
        (&["grup", "--participants", "participants.tsv"], "--compare grup: did you mean \"group\"?"),
        (&["age", "--participants", "participants.tsv"], "found 4: 40, 41, 42, 43"),
        (&["group", "--participants", "three.csv"], "found 3: x, y, z"),
        (&["group", "--participants", "one.csv"], "found one of group y"),
        (&["group", "--participants", "short.csv"], "short.csv: no row of subject \"sub-03\""),
        (&["group", "--participants", "nameless.csv"], "nameless.csv:1: "),
        (&["group", "--participants", "absent.csv"], "absent.csv"),
        (&["group", "--participants", "twice.csv"], "twice.csv:6: subject \"02\", as on line 4"),
        (
            &["group", "--participants", "participants.tsv", "--measures", "lenght_mm"],
            "--measures \"lenght_mm\": did you mean \"length_mm\"?",
        ),
    ] {
        let done = willis(here.path(), &[&base[..], words].concat());
        let said = stderr(&done);
        assert!(
            done.status.code() == Some(2) && said.lines().last().is_some_and(|last| last.contains(wanted)),
            "{words:?}: {said}"
        );
        assert!(!here.path().join("out").exists(), "{words:?}");
    }
    // One part each.
    let words = ["group", "--participants", "participants.tsv", "--measures", "length_mm,parts"];
    let told = stderr(&willis(here.path(), &[&base[..], &words].concat()));
    assert!(told.contains("note  parts is not compared") && !told.contains("length_mm is not"), "{told}");
}

/// What is measured has its name, also one made of labels; what participants have of that name is `given_NAME`.
#[test]
fn columns_of_participants_replace_nothing_that_is_measured() {
    let here = folder();
    let graph = data("circle-of-willis/complete.graphml");
    done(here.path(), &["measure", &graph, "-o", "plain"]);
    let rows = "participant_id,length_mm,L-A1_diameter_mm,given_length_mm,age\ncomplete,long,wide,longer,61\n";
    fs::write(here.path().join("participants.csv"), rows).expect("written");
    done(here.path(), &["measure", &graph, "-o", "out", "--participants", "participants.csv"]);
    let [plain, out] = ["plain", "out"].map(|name| here.path().join(name).join("subjects.csv"));
    for name in ["length_mm", "L-A1_diameter_mm"] {
        assert_eq!(cell(&out, 0, name), cell(&plain, 0, name), "{name}");
    }
    let record: serde_json::Value =
        serde_json::from_slice(&fs::read(here.path().join("out/run.json")).expect("a record")).expect("JSON");
    assert!(record["subjects"][0]["length_mm"].is_number());
    for (name, given) in
        [("given_given_length_mm", "long"), ("given_L-A1_diameter_mm", "wide"), ("given_length_mm", "longer"), ("age", "61")]
    {
        assert_eq!(cell(&out, 0, name), given, "{name}");
        assert_eq!(record["subjects"][0][name], given, "{name}");
    }
}

/// Of two participants of whose names a subject has the beginning, it is of the longer one.
#[test]
fn a_subject_is_of_the_participant_with_the_longest_name() {
    let here = folder();
    lines(here.path(), [20.0, 21.0].into_iter());
    for (from, to) in [("sub-00.swc", "p_1.swc"), ("sub-01.swc", "p_1_left.swc")] {
        fs::rename(here.path().join(from), here.path().join(to)).expect("renamed");
    }
    fs::write(here.path().join("p.csv"), "subject,age\np,1\np_1,2\n").expect("written");
    done(here.path(), &["measure", "*.swc", "-o", "out", "--participants", "p.csv"]);
    let ages = [0, 1].map(|row| cell(&here.path().join("out/subjects.csv"), row, "age"));
    assert_eq!(ages, ["2", "2"]);
}

#[test]
fn the_threads_change_nothing() {
    let here = folder();
    for threads in ["1", "4"] {
        done(here.path(), &["measure", &data("circle-of-willis/*.graphml"), "-o", threads, "--threads", threads]);
    }
    for name in ["vessels.csv", "bifurcations.csv", "ends.csv", "subjects.csv", "intervals.csv"] {
        let [one, four] = ["1", "4"].map(|threads| fs::read(here.path().join(threads).join(name)).expect("a table"));
        assert_eq!(one, four, "{name}");
    }
    let subjects = table(&here.path().join("1/subjects.csv"));
    assert!(subjects[0].iter().any(|name| name == "L-A1_diameter_mm"), "{:?}", subjects[0]);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let here = folder();
    fs::write(here.path().join("a.swc"), "1 0 0 0 0 1 -1\n2 0 10 0 0 1 1\n").expect("written");
    for (words, wanted) in [
        (&["measure", "a.swc", "-o", "out", "--smoothing", "0"][..], "--smoothing \"0\": expected a positive length"),
        (&["measure", "a.swc", "-o", "out", "--inlet", "7"], "--inlet"),
        (&["measure", "a.swc", "-o", "out", "--hypoplastic", "0"], "--hypoplastic \"0\": expected a positive length"),
        (&["measure", "a.swc", "-o", "out", "--brain", "a.swc"], "a.swc: SWC, not an image"),
        (&["measure", "a.swc", "-o", "out", "--brain", "absent.nii"], "absent.nii"),
        (&["measure", "a.swc", "-o", "out", "--observed"], "--observed"),
        (&["measure", "absent.swc", "-o", "out"], "absent.swc"),
    ] {
        let done = willis(here.path(), words);
        let said = stderr(&done);
        assert!(
            done.status.code() == Some(2) && said.lines().last().is_some_and(|last| last.contains(wanted)),
            "{words:?}: {said}"
        );
        assert!(!here.path().join("out").exists(), "{words:?}");
    }
}
