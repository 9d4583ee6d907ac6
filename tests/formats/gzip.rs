//! Files that are packed by gzip (by flate2, as gzip(1) packs them): read as what they hold, bounded, with errors that name the file.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::command;
use willis::internals::formats::{UnpackLimit, byte_count};
use willis::internals::support::endings::{stem, without_ending};

fn pack(from: &Path, to: &Path) {
    fs::write(to, packed(&fs::read(from).expect("a file"))).expect("packed");
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut out = GzEncoder::new(Vec::new(), Compression::default());
    out.write_all(bytes).expect("packed");
    out.finish().expect("packed")
}

/// Each format converts to the same bytes packed and unpacked, whatever the name of the packed file.
#[test]
fn a_packed_file_of_any_format_is_read_as_what_it_holds() {
    let here = command::folder();
    let place = |name: &str| here.path().join(name);
    let run = |arguments: &[&str]| {
        let ran = command::willis(here.path(), arguments);
        assert!(ran.status.success(), "{arguments:?}: {}", command::stderr(&ran));
    };
    let scan = command::data("broken-circle-of-willis.swc");
    for (plain, name) in [
        ("a.swc", "a.swc.gz"),
        ("a.vtp", "a.vtp.gz"),
        ("a.vtk", "a.VTK.GZ"),
        ("a.graphml", "graph.gz"),
        ("a.json", "a.mrk.json.gz"),
        ("a.tre", "a.tre.gz"),
        ("a.npz", "a.npz.gz"),
    ] {
        run(&["convert", &scan, plain]);
        pack(&place(plain), &place(name));
        run(&["convert", plain, "one.graphml", "--force"]);
        run(&["convert", name, "two.graphml", "--force"]);
        assert_eq!(fs::read(place("one.graphml")).expect("one"), fs::read(place("two.graphml")).expect("two"), "{name}");
    }
    // A table of vessels finds that of the nodes, either of them packed.
    fs::create_dir(place("packed")).expect("a folder");
    for (edges, nodes) in [
        ("b-edges.csv.gz", "b-nodes.csv.gz"),
        ("b-edges.csv", "b-nodes.csv.gz"),
        ("b-edges.csv.gz", "b-nodes.csv"),
        ("b.csv.gz", "b.nodes.csv.gz"),
        ("b.csv", "b.nodes.csv.gz"),
        ("b.csv.gz", "b.nodes.csv"),
    ] {
        run(&["convert", &scan, edges.trim_end_matches(".gz"), "--force"]);
        run(&["convert", edges.trim_end_matches(".gz"), "one.graphml", "--force"]);
        for name in [edges, nodes] {
            let to = place("packed").join(name);
            match name.strip_suffix(".gz") {
                Some(plain) => pack(&place(plain), &to),
                None => drop(fs::copy(place(name), &to)),
            }
        }
        run(&["convert", &format!("packed/{edges}"), "two.graphml", "--force"]);
        assert_eq!(
            fs::read(place("one.graphml")).expect("one"),
            fs::read(place("two.graphml")).expect("two"),
            "{edges}, {nodes}"
        );
        fs::remove_dir_all(place("packed")).and_then(|()| fs::create_dir(place("packed"))).expect("an empty folder");
    }
}

/// Landmarks and conditions are read packed too: the answer is that of the plain files.
#[test]
fn the_files_beside_an_input_may_be_packed() {
    let here = command::folder();
    let marks = command::data("broken-circle-of-willis.landmarks.csv");
    pack(Path::new(&marks), &here.path().join("marks.csv.gz"));
    let scan = command::data("broken-circle-of-willis.swc");
    for (file, out) in [(&*marks, "one"), ("marks.csv.gz", "two")] {
        let ran = command::willis(here.path(), &["infer", &scan, "-n", "64", "--landmarks", file, "-o", out]);
        assert!(ran.status.success(), "{}", command::stderr(&ran));
    }
    let table = |out: &str| fs::read(here.path().join(out).join("phenotype.csv")).expect("a table");
    assert_eq!(table("one"), table("two"));
}

/// A file of nothing but zeros packs to a thousandth; one that is cut is damaged; one that is packed twice is no format.
#[test]
fn what_is_damaged_or_unpacks_to_too_much_is_refused_by_name() {
    let here = command::folder();
    let good = packed(&fs::read(command::data("broken-circle-of-willis.swc")).expect("the example"));
    let refused = |name: &str, bytes: &[u8], options: &[&str]| {
        fs::write(here.path().join(name), bytes).expect("a file");
        let ran = command::willis(here.path(), &[&["convert", name, "out.vtp"], options].concat());
        assert_eq!(ran.status.code(), Some(2), "{}", command::stderr(&ran));
        assert!(!here.path().join("out.vtp").exists());
        command::stderr(&ran)
    };
    let said = refused("bomb.swc.gz", &packed(&vec![b' '; 100 << 20]), &[]);
    assert!(said.contains("bomb.swc.gz") && said.contains("more than 64.0 MiB unpacked"), "{said}");
    let said = refused("cut.swc.gz", &good[..good.len() / 2], &[]);
    assert!(said.contains("cut.swc.gz") && said.contains("damaged gzip"), "{said}");
    let said = refused("twice.swc.gz", &packed(&good), &[]);
    assert!(said.contains("twice.swc.gz") && said.contains("packed by gzip twice"), "{said}");
    let said = refused("much.swc.gz", &good, &["--max-input", "60kB"]);
    assert!(said.contains("much.swc.gz") && said.contains("--max-input"), "{said}");
    // After all voxels come four bytes of the checksum and four of the length.
    let scan = fs::read(command::data("scan.nii.gz")).expect("the example");
    let mut wrong = scan.clone();
    wrong[scan.len() - 6] ^= 1;
    for bytes in [&wrong, &scan[..scan.len() - 8]] {
        fs::write(here.path().join("scan.nii.gz"), bytes).expect("a file");
        let ran = command::willis(here.path(), &["skeleton", "scan.nii.gz", "-o", "out.vtp"]);
        let said = command::stderr(&ran);
        assert_eq!(ran.status.code(), Some(2), "{said}");
        assert!(said.contains("scan.nii.gz: after") && said.contains("expected a whole file"), "{said}");
    }
    let fault = refused("fault.swc.gz", &packed(b"1 0 0 0 0 1 -1\n2 0 x 0 0 1 1\n"), &[]);
    assert!(fault.contains("fault.swc.gz") && fault.contains('2'), "{fault}");
}

#[test]
fn packed_files_have_one_ending() {
    for (path, bare, name) in [
        ("in/scan.nii.gz", "in/scan", "scan"),
        ("scan.v2.swc", "scan.v2", "scan.v2"),
        ("scan.SWC.GZ", "scan", "scan"),
        ("in.d/scan", "in.d/scan", "scan"),
        ("scan.gz", "scan", "scan"),
        (".gz", ".gz", ".gz"),
        ("", "", ""),
    ] {
        assert_eq!((without_ending(Path::new(path)), stem(Path::new(path))), (PathBuf::from(bare), name.to_owned()), "{path}");
    }
}

#[test]
fn sizes_are_read_with_and_without_units() {
    for (text, bytes) in [("100000", 100_000), ("500MB", 500_000_000), ("2GiB", 2_147_483_648), ("1.5 kib", 1536), ("7B", 7)] {
        assert_eq!(byte_count(text), Ok(bytes), "{text}");
    }
    for wrong in ["", "MB", "-1", "0", "1e9", "2TB", "nan", "9999999999GiB", "1.2.3"] {
        assert!(byte_count(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn room_is_shared_by_all_parts_of_a_file() {
    let room = UnpackLimit::of(1 << 30, 1000);
    assert!(room.take(600).is_ok() && room.left() == 400);
    let (found, accepted) = room.take(401).unwrap_err();
    assert_eq!((found.as_str(), accepted), ("more than 1000 bytes unpacked", "`max_input` allows more"));
    // A file of 10 bytes unpacks to 64 MiB at the most, whatever is allowed.
    assert_eq!(UnpackLimit::of(10, u64::MAX).left(), 64 << 20);
}
