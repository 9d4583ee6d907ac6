//! iCafe tracings with their tables of vessels: small ones typed by hand, and those of the INSIST patients.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use willis::internals::formats::{
    Content, Document, Format, ReadOptions, TracedVessel, name_stretches, read, read_swc, read_traced_vessels,
    write_centerlines_swc,
};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::units::{LengthUnit, Scale, metres};
use willis::internals::network::{RadiusRule, contract};
use willis::internals::support::geometry::distance;

const HEADER: &str = "Patientname,Vessel Id,StartPointPositionX,StartPointPositionY,StartPointPositionZ,EndPointPositionX,EndPointPositionY,EndPointPositionZ,VesselType,NumPts,Order,";

/// Two chains that meet at (2, 0, 0), the second from there through landmark 99, and one that goes back to the start another way.
const TRACING: &str = "\
1 2 0 0 0 1 -1
2 0 1 0 0 1 1
3 4 2 0 0 1 2
4 4 2 0 0 1 -1
5 99 2 1.23457 0 1 4
6 4 2 0 0 1 -1
7 0 1 5 0 1 6
8 0 0.5 5 0 1 7
9 2 0 0 0 1 8
";

fn lines(text: &str) -> Centerlines {
    read_swc(text.as_bytes(), &Scale::default()).unwrap().0
}

fn vessels(rows: &str) -> Result<Vec<TracedVessel>, String> {
    let text = format!("{HEADER}\r\n{rows}");
    read_traced_vessels(text.as_bytes(), &Scale::default()).map_err(|f| f.in_file(Path::new("v")).to_string())
}

fn labels(lines: &Centerlines) -> Vec<&str> {
    (0..lines.links.len()).map(|row| lines.labels.of(row)).collect()
}

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn open(folder: &tempfile::TempDir, name: &str, scale: Scale) -> Result<Document, String> {
    let hide = |text: String| text.replace(&format!("{}/", folder.path().display()), "");
    let mut document =
        read(&folder.path().join(name), &ReadOptions { scale, ..ReadOptions::default() }).map_err(|e| hide(e.to_string()))?;
    document.notes = document.notes.into_iter().map(hide).collect();
    Ok(document)
}

/// Row by row: the second and third vessel share both their ends with others, the number of points tells which is which; the ends
/// of a row may be written in the other sense.
const ROWS: &str = "XX,0,2,0,0,0,0,0,2,3,1,\r\nXX,1,2,0,0,2,1.234570001,0,11,2,1,\r\nXX,2,0,0,0,2,0,0,21,4,1,";

#[test]
fn vessels_name_the_stretches_between_their_ends() {
    let mut found = lines(TRACING);
    assert_eq!(labels(&found), [""; 6]);
    assert_eq!(name_stretches(&mut found, &vessels(ROWS).unwrap()), 3);
    assert_eq!(labels(&found), ["R-ICA", "R-ICA", "AComm", "L-PComm", "L-PComm", "L-PComm"]);
    // As one tree with a branching point and in another order of rows the stretches lie between inner points.
    let mut tree = lines("9 0 0 2 0 1 3\n3 0 0 1 0 1 2\n1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n4 0 2 0 0 1 2\n5 0 3 0 0 1 4\n");
    let rows = "XX,0,0,2,0,2,0,0,5,5,1\nXX,1,2,0,0,3,0,0,7,2,1\nXX,2,0,0,0,2,2,0,8,2,1\n";
    assert_eq!(name_stretches(&mut tree, &vessels(rows).unwrap()), 2);
    assert_eq!(labels(&tree), ["L-M2", "L-M2", "", "L-M2", "L-A1"]);
    // Two vessels with the same ends and the same number of points take a stretch each.
    let mut twins = lines("1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n3 0 2 0 0 1 2\n4 0 0 0 0 1 -1\n5 0 1 1 0 1 4\n6 0 2 0 0 1 5\n");
    let rows = "XX,0,0,0,0,2,0,0,3,3,1\nXX,1,0,0,0,2,0,0,99,3,1\nXX,1,0,0,0,2,0,0,0,3,1\n";
    assert_eq!(name_stretches(&mut twins, &vessels(rows).unwrap()[..2]), 2);
    assert_eq!(labels(&twins), ["L-M1", "L-M1", "99", "99"]);
    assert_eq!(vessels(rows).unwrap()[2].label, "");
    // A table of another image changes nothing.
    let mut other = lines("1 0 7 7 7 1 -1\n2 4 8 7 7 1 1\n3 6 9 7 7 1 2\n");
    assert_eq!(name_stretches(&mut other, &vessels(ROWS).unwrap()), 0);
    assert_eq!(labels(&other), ["4", "6"]);
}

#[test]
fn the_arteries_have_their_usual_names() {
    let name = |code: usize| vessels(&format!("XX,0,0,0,0,1,1,1,{code},2,1")).unwrap()[0].label.clone();
    let names: Vec<String> = (0..24).map(name).collect();
    let expected = ",L-ICA,R-ICA,L-M1,R-M1,L-M2,R-M2,L-A1,R-A1,L-A2,R-A2,AComm,L-M3,R-M3,L-VA,R-VA,BA,L-P1,R-P1,L-P2,R-P2,L-PComm,R-PComm,23";
    assert_eq!(names.join(","), expected);
}

#[test]
fn either_file_of_the_pair_may_be_given() {
    let table = format!("{HEADER}\r\n{ROWS}");
    let info = "Voxel spacing: 0.47 0.47 1.5\r\nOrigin: 1,2,3";
    let pair = folder(&[("a.swc", TRACING), ("Feature_Vessel.csv", &table), ("Image_info.txt", info)]);
    let note = "Image_info.txt beside it states a voxel spacing of 0.47 mm; give `units=voxel` `spacing=0.47`";
    let found = "labels are those of Feature_Vessel.csv: 3 of its 3 vessels are in the tracing";
    let swc = open(&pair, "a.swc", Scale::default()).unwrap();
    assert_eq!((swc.format, swc.notes), (Format::ICafe, vec![found.to_owned(), note.to_owned()]));
    let csv = open(&pair, "Feature_Vessel.csv", Scale::default()).unwrap();
    assert_eq!(
        (csv.format, csv.notes),
        (Format::ICafe, ["the points are those of a.swc", found, note].map(str::to_owned).to_vec())
    );
    let [Content::Centerlines(swc), Content::Centerlines(csv)] = [swc.content, csv.content] else { panic!() };
    assert_eq!((&swc, labels(&swc)[0]), (&csv, "R-ICA"));
    let voxels = Scale { unit: LengthUnit::Voxel, spacing: Some([0.47; 3]) };
    let scaled = open(&pair, "a.swc", voxels).unwrap();
    assert_eq!(scaled.notes, [found]);
    let Content::Centerlines(scaled) = scaled.content else { panic!() };
    assert_eq!((scaled.points[2][0], labels(&scaled)), (metres(2.0 * 0.47), labels(&swc)));
}

#[test]
fn faults_of_the_pair_are_one_line() {
    let table = format!("{HEADER}\n{ROWS}");
    let alone = folder(&[("Feature_Vessel.csv", &table)]);
    assert_eq!(
        open(&alone, "Feature_Vessel.csv", Scale::default()).unwrap_err(),
        "Feature_Vessel.csv: an iCafe table of vessels without a tracing; expected the SWC file of the tracing beside it"
    );
    let many = folder(&[("Feature_Vessel.csv", &table), ("b.swc", TRACING), ("a.SWC", TRACING), ("other.txt", "")]);
    assert_eq!(
        open(&many, "Feature_Vessel.csv", Scale::default()).unwrap_err(),
        "Feature_Vessel.csv: 2 SWC files beside the table of vessels (a.SWC, b.swc); give the SWC file that it belongs to as INPUT"
    );
    assert_eq!(open(&many, "b.swc", Scale::default()).unwrap().format, Format::ICafe);
    let other = folder(&[("Feature_Vessel.csv", &table), ("a.swc", "1 0 7 7 7 1 -1\n2 0 8 7 7 1 1\n")]);
    assert_eq!(
        open(&other, "Feature_Vessel.csv", Scale::default()).unwrap_err(),
        "Feature_Vessel.csv: none of its vessels begins and ends at points of the tracing; expected a table and a tracing of the same image"
    );
    let beside = open(&other, "a.swc", Scale::default()).unwrap();
    assert_eq!((beside.format, beside.notes.len()), (Format::Swc, 0));
    let broken = folder(&[("Feature_Vessel.csv", &table), ("a.swc", "1 0 7 7\n")]);
    assert_eq!(
        open(&broken, "Feature_Vessel.csv", Scale::default()).unwrap_err(),
        "a.swc:1: 4 columns; expected 7 (id type x y z radius parent)"
    );
    for (rows, message) in [
        ("XX,0,a,0,0,0,0,0,2,3,1", "v:2: StartPointPositionX \"a\"; expected a number"),
        ("XX,0,0,0,0,0,0,inf,2,3,1", "v:2: EndPointPositionZ \"inf\"; expected a finite number"),
        ("XX,0,0,0,0,0,0", "v:2: EndPointPositionZ \"\"; expected a finite number"),
        ("XX,0,0,0,0,0,0,0,2.5,3,1", "v:2: VesselType 2.5; expected a whole number from 0 on"),
    ] {
        assert_eq!(vessels(rows).unwrap_err(), message);
    }
    let short = read_traced_vessels("VesselType,NumPts\n1,2\n".as_bytes(), &Scale::default()).unwrap_err();
    assert_eq!(
        short.in_file(Path::new("v")).to_string(),
        "v:1: no column StartPointPositionX; expected iCafe's Feature_Vessel.csv"
    );
    for cut in 0..table.len() {
        if let Err(fault) = read_traced_vessels(&table.as_bytes()[..cut], &Scale::default()) {
            assert_eq!(fault.in_file(Path::new("v")).to_string().lines().count(), 1);
        }
    }
}

fn tracings() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/insist-cow");
    let folders = fs::read_dir(&root).into_iter().flatten().map(|e| e.unwrap().path()).filter(|p| p.is_dir());
    let files = folders.flat_map(|folder| fs::read_dir(folder).unwrap()).map(|e| e.unwrap().path());
    let mut found: Vec<PathBuf> = files.filter(|p| p.extension().is_some_and(|e| e == "swc")).collect();
    found.sort();
    if found.is_empty() {
        eprintln!("skipped: no {}", root.display());
    }
    found
}

/// The table of vessels lists every stretch of these tracings with its type and number of points. Truth: that table, and the
/// segments that the data's own script derived from it.
#[test]
fn every_insist_tracing_has_the_labels_of_its_table() {
    for path in tracings() {
        let document = read(&path, &ReadOptions::default()).unwrap();
        assert_eq!(document.format, Format::ICafe);
        let mut table = csv::Reader::from_path(path.with_file_name("Feature_Vessel.csv")).unwrap();
        let rows = table.records().map(Result::unwrap).count();
        let note = format!("{rows} of its {rows} vessels are in the tracing");
        assert!(document.notes[0].ends_with(&note), "{}", document.notes[0]);
        assert!(document.notes[1].starts_with("Image_info.txt beside it states a voxel spacing of 0."));
        let Content::Centerlines(mut lines) = document.content else { panic!() };
        let mut length = [0.0; 2];
        for (row, [a, b]) in lines.links.iter().enumerate() {
            length[usize::from(!lines.labels.of(row).is_empty())] +=
                distance(lines.points[*a as usize], lines.points[*b as usize]);
        }
        assert_eq!(length[0], 0.0, "{} mm without label in {}", length[0] * 1e3, path.display());
        let traced: BTreeSet<String> = labels(&lines).into_iter().map(str::to_owned).collect();
        let arteries: BTreeSet<String> = segments(&path);
        assert_eq!(traced, arteries, "{}", path.display());
        // What is written names the stretches by itself.
        let mut bytes = Vec::new();
        write_centerlines_swc(&mut bytes, &lines).unwrap();
        assert_eq!(labels(&read_swc(&bytes[..], &Scale::default()).unwrap().0), labels(&lines));
        lines.weld(1e-6);
        let network = contract(&lines, RadiusRule::Mean, None).unwrap().network;
        assert!(network.vessels().all(|(_, vessel)| !vessel.label.is_empty()));
    }
}

/// The segments of a patient in derived_vessels_mm.csv, `PComm L` as `L-PComm`.
fn segments(tracing: &Path) -> BTreeSet<String> {
    let folder = tracing.parent().unwrap();
    let patient = folder.file_name().unwrap().to_str().unwrap();
    let mut table = csv::Reader::from_path(folder.with_file_name("derived_vessels_mm.csv")).unwrap();
    let rows = table.records().map(Result::unwrap).filter(|row| &row[0] == patient);
    rows.map(|row| row[3].split_once(' ').map_or(row[3].to_owned(), |(artery, side)| format!("{side}-{artery}"))).collect()
}

/// Each of the points at the one end of a vessel was tried with each at its other end, along the way between them: minutes, for a tracing
/// that a program has stopped in one place.
#[test]
fn many_points_in_one_place_take_no_time() {
    let mut text = "1 0 5 5 5 1 -1\n".to_owned();
    for id in 2..4000 {
        writeln!(text, "{id} 0 1 1 1 1 {}", id - 1).unwrap();
    }
    let mut found = lines(&text);
    assert_eq!(name_stretches(&mut found, &vessels("XX,0,5,5,5,1,1,1,1,9,1\n").unwrap()), 1);
    // The one way of nine points.
    assert_eq!(labels(&found)[..9], ["L-ICA", "L-ICA", "L-ICA", "L-ICA", "L-ICA", "L-ICA", "L-ICA", "L-ICA", ""]);
    let started = std::time::Instant::now();
    assert_eq!(name_stretches(&mut found, &vessels("XX,1,1,1,1,1,1,1,2,9999,1\n").unwrap()), 1);
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
}
