//! NRRD and the segmentations of 3D Slicer: files written by hand from the format's definition, and by pynrrd and SimpleITK.

use crate::images::{ITK, SHEARLESS, bar, ends, gzip, lines, read, tips};
use crate::peers::{case, network_of, positions, python, read_first};
use willis::internals::formats::{Format, ReadOptions, read as read_file, read_image};
use willis::internals::network::{Frame, units::Scale};

/// The header of the bar in LPS, with other lines for some.
fn header(swaps: &[(&str, &str)]) -> String {
    let plain = "NRRD0005\n# by hand\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 12 5 6\n\
                 space directions: (0,0.5,0) (-0.5,0,0) (0,0,0.75)\nkinds: domain domain domain\nendian: little\nencoding: raw\n\
                 space origin: (10,-20,30)\nnote:=a: b\n";
    swaps.iter().fold(plain.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

fn nrrd(swaps: &[(&str, &str)], voxels: &[u8]) -> Vec<u8> {
    [header(swaps).as_bytes(), b"\n", voxels].concat()
}

const LPS: &str = "left-posterior-superior";

#[test]
fn every_space_encoding_and_place_of_the_voxels_gives_the_same_bar() {
    let las = [ITK[0], SHEARLESS[1], SHEARLESS[2]];
    // Spaces that know no patient leave the axes as they are.
    let spaces = [
        (LPS, ITK),
        ("LPS", ITK),
        ("right-anterior-superior", SHEARLESS),
        ("RAS", SHEARLESS),
        ("Left-Anterior-Superior", las),
        ("scanner-xyz", SHEARLESS),
        ("3D-right-handed", SHEARLESS),
    ];
    let text = bar().iter().map(u8::to_string).collect::<Vec<_>>();
    let text = text.chunks(12).map(|row| row.join(" ")).collect::<Vec<_>>().join("\n").into_bytes();
    for (space, affine) in spaces {
        for (encoding, voxels) in
            [("raw", bar()), ("gzip", gzip(&bar())), ("gz", gzip(&bar())), ("ascii", text.clone()), ("text", text.clone())]
        {
            let swaps = [(LPS, space), ("encoding: raw", &format!("encoding: {encoding}"))];
            let how = format!("{space} {encoding}");
            let found = read("a.nrrd", &nrrd(&swaps, &voxels)).expect("read");
            assert_eq!((found.format, ends(found)), (Format::Nrrd, tips(affine)), "{how}");
            assert_eq!(ends(read("a.nrrd.gz", &gzip(&nrrd(&swaps, &voxels))).expect("read")), tips(affine), "{how}");
            // With the line ends of Windows, and the voxels beside the header, which may end without an empty line.
            let head = header(&swaps) + "data file: ./a.raw\n";
            for head in [head.clone(), head.replace('\n', "\r\n"), head + "\n"] {
                let files = [("a.nhdr", head.as_bytes()), ("a.raw", voxels.as_slice())];
                assert_eq!(ends(read_first(&files, &ReadOptions::default()).expect("read")), tips(affine), "{how}");
            }
        }
    }
    let none = [("space: left-posterior-superior", "space dimension: 3")];
    let found = read("a.nrrd", &nrrd(&none, &bar())).expect("read");
    assert!(found.notes.iter().any(|note| note.contains("nobody states which way they point")), "{:?}", found.notes);
    assert_eq!(ends(found), tips(SHEARLESS));
    let um = [("(0,0.5,0) (-0.5,0,0) (0,0,0.75)", "(0, 500, 0) (-500,0,0) (0,0,750)"), ("(10,-20,30)", "(1e4,-2e4,3e4)")];
    let um = [&um[..], &[("note", "space units: \"um\" \"um\" \"um\"\nnote")]].concat();
    assert_eq!(ends(read("a.nrrd", &nrrd(&um, &bar())).expect("read")), tips(ITK));
}

#[test]
fn lines_and_bytes_before_the_voxels_are_skipped() {
    let after = |skip: &str, before: &[u8], voxels: &[u8], encoding: &str| {
        let swaps = [("note", &*format!("{skip}\ndatafile: a.raw\nnote")), ("encoding: raw", encoding)];
        let files = [("a.nhdr", header(&swaps).into_bytes()), ("a.raw", [before, voxels].concat())];
        let files = files.each_ref().map(|(name, bytes)| (*name, bytes.as_slice()));
        ends(read_first(&files, &ReadOptions::default()).expect("read"))
    };
    let raw = "encoding: raw";
    assert_eq!(after("byte skip: 4", b"four", &bar(), raw), tips(ITK));
    assert_eq!(after("byteskip: -1", b"any number", &bar(), raw), tips(ITK));
    assert_eq!(after("line skip: 2\nbyte skip: 1", b"one\ntwo\n3", &bar(), raw), tips(ITK));
    // Of packed voxels, lines are skipped before they are unpacked, bytes after.
    assert_eq!(
        after("line skip: 1\nbyte skip: 3", b"one\n", &gzip(&[b"two".as_slice(), &bar()].concat()), "encoding: gzip"),
        tips(ITK)
    );
}

#[test]
fn every_type_in_every_spelling_is_read() {
    let types = [
        ("uchar|unsigned char|uint8|uint8_t|signed char|int8|int8_t", 1),
        (
            "short|short int|signed short|signed short int|int16|int16_t|ushort|unsigned short|unsigned short int|uint16|uint16_t",
            2,
        ),
        ("int|signed int|int32|int32_t|uint|unsigned int|uint32|uint32_t", 4),
        ("longlong|long long|long long int|signed long long|signed long long int|int64|int64_t", 8),
        ("ulonglong|unsigned long long|unsigned long long int|uint64|uint64_t", 8),
        ("float", 4),
        ("double", 8),
    ];
    for (names, size) in types {
        for name in names.split('|') {
            for big in [false, true] {
                let one = match (name, size) {
                    ("float", _) => 1_f32.to_le_bytes().to_vec(),
                    ("double", _) => 1_f64.to_le_bytes().to_vec(),
                    _ => 1_u64.to_le_bytes()[..size].to_vec(),
                };
                let voxel = |class: &u8| {
                    let mut bytes = if *class > 0 { one.clone() } else { vec![0; size] };
                    if big {
                        bytes.reverse();
                    }
                    bytes
                };
                let voxels: Vec<u8> = bar().iter().flat_map(voxel).collect();
                let swaps = [("type: uchar", &*format!("type: {name}")), ("little", if big { "big" } else { "little" })];
                assert_eq!(ends(read("a.nrrd", &nrrd(&swaps, &voxels)).expect(name)), tips(ITK), "{name} {big}");
            }
        }
    }
}

#[test]
fn spacings_alone_and_a_fourth_axis_of_one_are_read() {
    let plain = [[0.5, 0.0, 0.0, 1.0], [0.0, 0.25, 0.0, 2.0], [0.0, 0.0, 0.75, 3.0]];
    let directions = "space directions: (0,0.5,0) (-0.5,0,0) (0,0,0.75)";
    let old = [
        (directions, "spacings: 0.5 0.25 0.75\naxis mins: 1 2 3\ncenters: node node node"),
        ("space: left-posterior-superior\n", ""),
        ("space origin: (10,-20,30)\n", ""),
    ];
    assert_eq!(ends(read("a.nrrd", &nrrd(&old, &bar())).expect("read")), tips(plain));
    // Samples that are no nodes lie half a voxel from the border, as SimpleITK has it; the borders tell the spacing too.
    let of_cells = [[0.5, 0.0, 0.0, 1.25], [0.0, 0.25, 0.0, 2.125], [0.0, 0.0, 0.75, 3.375]];
    for (lines, affine) in [
        ("spacings: 0.5 0.25 0.75\naxis mins: 1 2 3", of_cells),
        ("spacings: 0.5 0.25 0.75\naxis mins: 1 2 3\ncenterings: cell cell cell", of_cells),
        ("axis mins: 1 2 3\naxis maxs: 7 3.25 7.5", of_cells),
        ("axis mins: 1 2 3\naxis maxs: 6.5 3 6.75\ncenters: node node node", plain),
    ] {
        let swaps = [&[(directions, lines)], &old[1..]].concat();
        assert_eq!(ends(read("a.nrrd", &nrrd(&swaps, &bar())).expect("read")), tips(affine), "{lines}");
    }
    // One that is not stated, or missing, is that of `spacing`, and none beside one that is stated.
    let given = |swaps: &[(&str, &str)], spacing| {
        let scale = Scale { spacing: Some(spacing), ..Scale::default() };
        read_first(&[("a.nrrd", &nrrd(swaps, &bar()))], &ReadOptions { scale, ..ReadOptions::default() })
    };
    for (lines, affine) in [
        ("axis mins: 1 2 3\ncenters: node node node", plain),
        ("axis mins: 1 2 3\nspacings: NaN NaN NaN", of_cells),
        ("axis mins: 1 2 3\nunits: \"mm\" \"mm\" \"mm\"", of_cells),
    ] {
        let swaps = [&[(directions, lines)], &old[1..]].concat();
        assert_eq!(ends(given(&swaps, [0.5, 0.25, 0.75]).expect("read")), tips(affine), "{lines}");
        let said = read("a.nrrd", &nrrd(&swaps, &bar())).unwrap_err();
        assert!(said.contains("no spacing along axis 0; expected spacings, ") && said.contains("`spacing=SX,SY,SZ`"), "{said}");
    }
    let other = given(&old, [1.0; 3]).unwrap_err();
    assert!(other.contains("states voxels of 0.5 x 0.25 x 0.75 mm; expected no other `spacing`"), "{other}");
    let steps = "(0,0.5,0) (-0.5,0,0) (0,0,0.75)";
    for (sizes, steps_of, kinds) in [
        ("1 12 5 6", format!("none {steps}"), "list domain domain domain"),
        ("12 5 6 1", format!("{steps} none"), "domain domain domain list"),
    ] {
        let swaps = [("12 5 6", sizes), (steps, &steps_of), ("dimension: 3", "dimension: 4"), ("domain domain domain", kinds)];
        assert_eq!(ends(read("a.nrrd", &nrrd(&swaps, &bar())).expect("read")), tips(ITK), "{sizes}");
    }
    let (spaced, kind) = ("spacings: NaN 0.5 0.25 0.75", "??? domain domain domain");
    let list = [
        &old[1..],
        &[("12 5 6", "1 12 5 6"), (directions, spaced), ("dimension: 3", "dimension: 4"), ("domain domain domain", kind)],
    ]
    .concat();
    let at_zero = plain.map(|row| [row[0], row[1], row[2], 0.0]);
    assert_eq!(ends(read("a.nrrd", &nrrd(&list, &bar())).expect("read")), tips(at_zero));
}

#[test]
fn segments_of_3d_slicer_are_classes_with_names_in_several_layers() {
    // The bar's first voxels are of the first segment in layer 0, the last ones of one in layer 1; one voxel is in both, one of no segment.
    let voxels: Vec<u8> = (bar().iter().enumerate())
        .flat_map(|(row, class)| match (class, row % 12) {
            (0, _) => [0, 0],
            (_, 0..6) => [7, 0],
            (_, 6) => [7, 3],
            _ => [0, 3],
        })
        .collect();
    let swaps = [
        ("12 5 6", "2 12 5 6"),
        ("(0,0.5,0)", "none (0,0.5,0)"),
        ("dimension: 3", "dimension: 4"),
        ("kinds: domain", "kinds: list domain"),
        (
            "note:=a: b",
            "Segment0_ID:=Segment_1\nSegment0_LabelValue:=7\nSegment0_Layer:=0\nSegment0_Name:=Left ICA\n\
             Segment1_ID:=Segment_2\nSegment1_LabelValue:=3\nSegment1_Layer:=1\nSegment1_Name:=M1: left\n\
             Segment2_ID:=Segment_3\nSegment2_LabelValue:=9\nSegment2_Layer:=1\nSegment2_Name:=absent",
        ),
    ];
    let labels = |bytes: &[u8]| {
        let document = read("a.seg.nrrd", bytes).expect("read");
        let notes = document.notes.join("\n");
        let lines = lines(document);
        let mut labels: Vec<String> = (0..lines.links.len()).map(|link| lines.labels.of(link).to_owned()).collect();
        labels.sort();
        labels.dedup();
        (labels, notes)
    };
    let mut whole = nrrd(&swaps, &voxels);
    let (found, notes) = labels(&whole);
    assert_eq!(found, ["Left ICA", "M1: left"]);
    assert!(notes.contains("1 voxel in several segments: taken to the last of them"), "{notes}");
    assert_eq!(ends(read("a.seg.nrrd", &whole).expect("read")), tips(ITK));
    let last = whole.len() - 1;
    whole[last] = 8;
    let (found, notes) = labels(&whole);
    assert_eq!(found, ["Left ICA", "M1: left"]);
    assert!(notes.contains("1 voxel with a value of no segment: left out"), "{notes}");
    // Before Slicer 4.11 each segment was a layer of ones.
    let old = swaps.map(|(from, to)| {
        let kept =
            to.split('\n').filter(|line| !line.contains("LabelValue") && !line.contains("Layer") && !line.contains("Segment2"));
        (from, kept.collect::<Vec<_>>().join("\n"))
    });
    let old: Vec<(&str, &str)> = old.iter().map(|(from, to)| (*from, to.as_str())).collect();
    let ones: Vec<u8> = voxels.iter().map(|value| u8::from(*value > 0)).collect();
    assert_eq!(labels(&nrrd(&old, &ones)).0, ["Left ICA", "M1: left"]);
    // One layer.
    let single: Vec<u8> = (voxels.chunks(2)).map(|both| if both[1] > 0 { 3 } else { both[0] }).collect();
    let one = [("note:=a: b", &*swaps[4].1.replace("Layer:=1", "Layer:=0"))];
    assert_eq!(labels(&nrrd(&one, &single)).0, ["Left ICA", "M1: left"]);
    // An end of line after the last voxel is no voxel.
    let (found, notes) = labels(&[nrrd(&one, &single), b"\n".to_vec()].concat());
    assert!(found == ["Left ICA", "M1: left"] && !notes.contains("of no segment"), "{notes}");
    // Names are for segments; a level takes the values as they are.
    let level = ReadOptions { level: Some(3.0), ..ReadOptions::default() };
    assert_eq!(ends(read_first(&[("a.seg.nrrd", &nrrd(&one, &single))], &level).expect("read")), tips(ITK));
}

#[test]
fn what_is_no_usable_nrrd_is_refused_in_one_line() {
    let with = |swaps: &[(&str, &str)]| nrrd(swaps, &bar());
    let beside = |name: &str| header(&[("note", &*format!("data file: {name}\nnote"))]).into_bytes();
    let packed = gzip(&bar());
    let mut wrong_sum = packed.clone();
    // The checksum is in the last eight bytes.
    wrong_sum[packed.len() - 6] ^= 1;
    let unit = |words: &str| with(&[("note:=", &*format!("space units: {words}\nnote:="))]);
    let four = [("12 5 6", "2 12 5 3"), ("dimension: 3", "dimension: 4"), ("(0,0.5,0)", "none (0,0.5,0)")];
    let seg = |layer: &str| {
        let key = format!("Segment0_Layer:={layer}\nSegment0_Name");
        nrrd(&[&four[..], &[("note", &*key)]].concat(), &[1; 360])
    };
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("cut.nrrd", nrrd(&[], &bar()[..100]), "100 of 360 voxels; expected all of them; is the file cut off?"),
        ("cut-gzip.nrrd", nrrd(&[("encoding: raw", "encoding: gzip")], &packed[..packed.len() - 12]), "expected a whole file"),
        (
            "sum.nrrd",
            nrrd(&[("encoding: raw", "encoding: gzip")], &wrong_sum),
            "after 360 of 360 voxels: corrupt gzip stream does not have a matching checksum; expected a whole file",
        ),
        ("parsec.nrrd", unit("\"parsec\" \"parsec\" \"parsec\""), "expected one unit for all axes of space: mm, um, cm or m"),
        ("units.nrrd", unit("\"mm\" \"mm\" \"um\""), "units.nrrd:12: space units \"\"mm\" \"mm\" \"um\"\"; expected one unit"),
        ("empty.nrrd", nrrd(&[], &[0; 360]), "an empty mask"),
        ("huge.nrrd", with(&[("12 5 6", "16384 8192 8192")]), "16384 x 8192 x 8192 voxels of 1 bytes; expected at most"),
        ("overflow.nrrd", with(&[("12 5 6", "4294967296 4294967296 4294967296")]), "expected at most"),
        ("minus.nrrd", with(&[("12 5 6", "12 -5 6")]), "minus.nrrd:6: sizes \"12 -5 6\"; expected 3 whole numbers"),
        (
            "two.nrrd",
            with(&[("12 5 6", "12 30"), ("dimension: 3", "dimension: 2")]),
            "expected three dimensions; take one volume",
        ),
        ("four.nrrd", with(&four), "sizes \"2 12 5 3\"; expected three dimensions; take one volume"),
        ("type.nrrd", with(&[("uchar", "block")]), "type.nrrd:3: type \"block\"; expected uchar"),
        ("hex.nrrd", with(&[("encoding: raw", "encoding: hex")]), "encoding \"hex\"; expected raw, gzip or ascii"),
        ("endian.nrrd", with(&[("uchar", "short"), ("endian: little\n", "")]), "no field endian; expected little or big"),
        ("space.nrrd", with(&[(LPS, "left-up-sideways")]), "space.nrrd:5: space \"left-up-sideways\""),
        ("flat.nrrd", with(&[("(0,0,0.75)", "(0,0.5,0)")]), "axes that lie in a plane"),
        ("vector.nrrd", with(&[("(0,0,0.75)", "(0,0)")]), "expected 3 vectors of three numbers"),
        ("nan.nrrd", with(&[("(10,-20,30)", "(nan,-20,30)")]), "a finite origin"),
        ("field.nrrd", with(&[("note:=a: b", "note")]), "field.nrrd:12: \"note\"; expected a line `field: value`"),
        ("words.nrrd", nrrd(&[("encoding: raw", "encoding: text")], b"0 1 x"), "\"x\" is no number"),
        ("list.nhdr", beside("LIST"), "data file \"LIST\"; expected the name of one file in the same folder"),
        ("many.nhdr", beside("a%03d.raw 1 6 1"), "expected the name of one file in the same folder"),
        ("out.nhdr", beside("../a.raw"), "expected the name of one file in the same folder"),
        ("absent.nhdr", beside("absent.raw"), "cannot be read"),
        ("layer.seg.nrrd", seg("2"), "Segment0_Layer: \"2\"; expected one of 2 layers, from 0"),
        ("layers.seg.nrrd", with(&[("12 5 6", "999999 12 5 6"), four[1], four[2]]), "expected from 1 to 255 layers"),
    ];
    for (name, bytes, wanted) in cases {
        let said = read(name, &bytes).map(|_| ()).expect_err(name);
        assert!(said.contains(wanted) && !said.contains('\n'), "{said}");
    }
    // A header without an end.
    let long = ["NRRD0004\n".to_owned(), "# x\n".repeat(1 << 19)].concat();
    assert!(read("long.nrrd", long.as_bytes()).expect_err("no end").contains("no empty line"));
    // Every beginning of a file is read or refused.
    let whole = with(&[]);
    assert_eq!(crate::peers::truncated(&[("a.nrrd", &whole)], 1, &ReadOptions::default()), 0);
}

const WRITERS: &str = r#"
import sys, os, numpy as np, nrrd, SimpleITK as sitk
rng = np.random.default_rng(5)
for n in range(12):
    a = np.zeros((12, 5, 6), rng.choice([np.uint8, np.int16, np.uint32, np.float32, np.float64]))
    a[2:11, 2, 3] = 1
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    if n % 2 and np.linalg.det(q) < 0: q[:, 0] *= -1
    m = q * rng.uniform(.4, 1.2, 3); o = rng.normal(size=3) * 50
    lps = np.diag([-1., -1., 1.])
    path = os.path.join(sys.argv[1], f"{n}.nrrd")
    if n % 2:
        image = sitk.GetImageFromArray(a.transpose(2, 1, 0))
        spacing = np.linalg.norm(m, axis=0)
        image.SetSpacing(spacing.tolist()); image.SetOrigin((lps @ o).tolist())
        image.SetDirection((lps @ (m / spacing)).ravel().tolist())
        sitk.WriteImage(image, path, useCompression=n % 4 == 1)
    else:
        flip, space = [(np.eye(3), "right-anterior-superior"), (np.diag([-1., 1., 1.]), "LAS"), (lps, "left-posterior-superior")][n // 2 % 3]
        head = {"space": space, "space directions": (flip @ m).T, "space origin": flip @ o,
                "encoding": ["raw", "gzip", "ascii"][n // 2 % 3 - 1], "endian": ["little", "big"][n // 6]}
        if head["endian"] == "big": a = a.astype(a.dtype.newbyteorder(">"))
        if n == 8: path = path.replace("nrrd", "nhdr"); nrrd.write(path, a, head, detached_header=True)
        else: nrrd.write(path, a, head)
    print(path, *np.c_[m, o].ravel())
"#;

#[test]
fn pynrrd_and_simpleitk_write_what_is_read_to_the_same_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(out) = python(WRITERS, &[folder.path()]) else { return };
    for line in out.lines() {
        let (path, numbers) = line.split_once(' ').expect("a path");
        let numbers: Vec<f64> = numbers.split(' ').map(|word| word.parse().expect("a number")).collect();
        let affine = [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| numbers[4 * row + column]));
        let found = ends(read_file(path.as_ref(), &ReadOptions::default()).expect("read"));
        for (a, b) in found.iter().flatten().zip(tips(affine).iter().flatten()) {
            assert!((a - b).abs() < 2e-3, "{path}: {found:?} {:?}", tips(affine));
        }
        let (image, _) = read_image(path.as_ref(), &ReadOptions::default(), Frame::Unknown).expect("an image");
        assert_eq!((image.shape, image.values.iter().sum::<f32>()), ([12, 5, 6], 9.0), "{path}");
    }
    assert_eq!(out.lines().count(), 12);
}

#[test]
fn a_tube_is_the_same_in_nrrd_and_nifti() {
    let Some(nifti) = case("tube.nii.gz") else { return };
    let drawn = |path: &std::path::Path| network_of(read_file(path, &ReadOptions::default()).expect("read"));
    let expected = drawn(&nifti);
    assert_eq!(expected.vessel_count(), 1);
    for name in ["tube.nrrd", "tube.seg.nrrd"] {
        let Some(path) = case(name) else { return };
        let found = drawn(&path);
        assert_eq!((found.vessel_count(), positions(&found)), (1, positions(&expected)), "{name}");
        assert!((found.vessel(0).radius / expected.vessel(0).radius - 1.0).abs() < 1e-9, "{name}");
    }
}
