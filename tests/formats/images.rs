//! Readers of masks: NIfTI-1 and -2, MetaImage and NumPy, byte for byte by their specifications, and by nibabel.

use std::io::Write;

use crate::peers::{python, read_first};
use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use willis::internals::formats::{Content, Document, NamedArray, ReadOptions, write_arrays};
use willis::internals::network::centerlines::Centerlines;
use willis::{Frame, LengthUnit, Scale};

/// A bar of 9 voxels along the first axis, at 2 along the second and 3 along the third.
const SHAPE: [usize; 3] = [12, 5, 6];

pub fn bar() -> Vec<u8> {
    (0..12 * 5 * 6).map(|n| u8::from((2..11).contains(&(n % 12)) && n / 12 % 5 == 2 && n / 60 == 3)).collect()
}

pub fn read(name: &str, bytes: &[u8]) -> Result<Document, String> {
    read_first(&[(name, bytes)], &ReadOptions::default())
}

pub fn lines(document: Document) -> Centerlines {
    match document.content {
        Content::Centerlines(lines) => lines,
        other => panic!("{other:?}"),
    }
}

/// The ends of the one line, mm, in the order of their x, y and z, rounded.
pub fn ends(document: Document) -> [[f64; 3]; 2] {
    let lines = lines(document);
    let mut degrees = vec![0; lines.points.len()];
    lines.links.iter().flatten().for_each(|end| degrees[*end as usize] += 1);
    let ends = lines.points.iter().zip(degrees).filter(|(_, degree)| *degree == 1);
    let mut ends: Vec<[f64; 3]> = ends.map(|(p, _)| p.map(|x| (x * 1e6).round() / 1e3)).collect();
    ends.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    ends.try_into().expect("two ends")
}

/// The centres of the first and the last voxel of the bar, mm, for a frame.
pub fn tips(affine: [[f64; 4]; 3]) -> [[f64; 3]; 2] {
    let at = |x: f64| affine.map(|[a, b, c, d]| ((a * x + b * 2.0 + c * 3.0 + d) * 1e3).round() / 1e3);
    let mut tips = [at(2.0), at(10.0)];
    tips.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    tips
}

/// What a NIfTI header states.
#[derive(Clone)]
struct Header {
    two: bool,
    big: bool,
    dim: Vec<i64>,
    datatype: i64,
    pixdim: [f64; 4],
    slope: [f64; 2],
    units: i64,
    qform: Option<[f64; 6]>,
    sform: Option<[[f64; 4]; 3]>,
}

impl Default for Header {
    fn default() -> Self {
        let dim = SHAPE.iter().map(|n| *n as i64).collect();
        Self {
            two: false,
            big: false,
            dim,
            datatype: 2,
            pixdim: [1.0, 0.5, 0.5, 0.75],
            slope: [0.0; 2],
            units: 2,
            qform: None,
            sform: None,
        }
    }
}

impl Header {
    /// The file, its fields at the offsets of nifti1.h and nifti2.h.
    fn file(&self, voxels: &[u8]) -> Vec<u8> {
        let mut out = vec![0; if self.two { 544 } else { 352 }];
        let mut put = |at: usize, mut bytes: Vec<u8>| {
            if self.big {
                bytes.reverse();
            }
            out[at..at + bytes.len()].copy_from_slice(&bytes);
        };
        let whole = |value: i64, size: usize| value.to_le_bytes()[..size].to_vec();
        let real = |value: f64| if self.two { value.to_le_bytes().to_vec() } else { (value as f32).to_le_bytes().to_vec() };
        let wide = if self.two { 8 } else { 4 };
        put(0, whole(if self.two { 540 } else { 348 }, 4));
        let (dim, size) = if self.two { (16, 8) } else { (40, 2) };
        put(dim, whole(self.dim.len() as i64, size));
        for (n, length) in self.dim.iter().enumerate() {
            put(dim + (n + 1) * size, whole(*length, size));
        }
        put(if self.two { 12 } else { 70 }, whole(self.datatype, 2));
        for (n, length) in self.pixdim.iter().enumerate() {
            put(if self.two { 104 } else { 76 } + n * wide, real(*length));
        }
        if self.two {
            put(168, whole(544, 8));
        } else {
            put(108, real(352.0));
        }
        for (n, x) in self.slope.iter().enumerate() {
            put(if self.two { 176 } else { 112 } + n * wide, real(*x));
        }
        put(if self.two { 500 } else { 123 }, whole(self.units, if self.two { 4 } else { 1 }));
        let code = if self.two { 4 } else { 2 };
        if let Some(numbers) = self.qform {
            put(if self.two { 344 } else { 252 }, whole(1, code));
            for (n, x) in numbers.iter().enumerate() {
                put(if self.two { 352 } else { 256 } + n * wide, real(*x));
            }
        }
        if let Some(rows) = self.sform {
            put(if self.two { 348 } else { 254 }, whole(1, code));
            for (n, x) in rows.iter().flatten().enumerate() {
                put(if self.two { 400 } else { 280 } + n * wide, real(*x));
            }
        }
        if self.two {
            out[4..12].copy_from_slice(b"n+2\0\r\n\x1a\n");
        } else {
            out[344..348].copy_from_slice(b"n+1\0");
        }
        out.extend_from_slice(voxels);
        out
    }
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    gzip_at(Compression::default(), bytes)
}

fn gzip_at(compression: Compression, bytes: &[u8]) -> Vec<u8> {
    let mut out = GzEncoder::new(Vec::new(), compression);
    out.write_all(bytes).expect("packed");
    out.finish().expect("packed")
}

pub const SHEARLESS: [[f64; 4]; 3] = [[0.0, -0.5, 0.0, 10.0], [0.5, 0.0, 0.0, -20.0], [0.0, 0.0, 0.75, 30.0]];

#[test]
fn a_frame_is_that_of_sform_then_of_qform_then_the_middle_of_the_image() {
    // A quarter turn about z: the quaternion cos 45 degrees, 0, 0, sin 45 degrees.
    let quarter = [0.0, 0.0, 0.5_f64.sqrt(), 10.0, -20.0, 30.0];
    let plain = [[-0.5, 0.0, 0.0, 5.5 * 0.5], [0.0, 0.5, 0.0, -2.0 * 0.5], [0.0, 0.0, 0.75, -2.5 * 0.75]];
    let mirrored = [SHEARLESS[0], SHEARLESS[1], [0.0, 0.0, -0.75, 30.0]];
    let qform = Header { qform: Some(quarter), ..Header::default() };
    let cases = [
        (Header { sform: Some(SHEARLESS), ..Header::default() }, SHEARLESS),
        (Header { sform: Some(SHEARLESS), qform: Some([0.0; 6]), ..Header::default() }, SHEARLESS),
        (qform.clone(), SHEARLESS),
        (Header { pixdim: [-1.0, 0.5, 0.5, 0.75], ..qform.clone() }, mirrored),
        (Header { pixdim: [0.0, 0.5, 0.5, 0.75], ..qform }, SHEARLESS),
        (Header::default(), plain),
        // Micrometres.
        (Header { pixdim: [1.0, 500.0, 500.0, 750.0], units: 3, ..Header::default() }, plain),
        (Header { units: 10, ..Header::default() }, plain),
    ];
    for (header, affine) in cases {
        for (two, big) in [(false, false), (false, true), (true, false), (true, true)] {
            let bytes = Header { two, big, ..header.clone() }.file(&bar());
            for (name, bytes) in [("a.nii", bytes.clone()), ("a.nii.gz", gzip(&bytes)), ("no-ending", bytes)] {
                assert_eq!(ends(read(name, &bytes).expect("read")), tips(affine), "{two} {big} {name}");
            }
        }
    }
}

#[test]
fn every_type_of_number_is_read_and_scaled() {
    let frame = || Header { sform: Some(SHEARLESS), ..Header::default() };
    let sizes = [(2, 1), (256, 1), (4, 2), (512, 2), (8, 4), (768, 4), (1024, 8), (1280, 8)];
    for (datatype, size) in sizes {
        for big in [false, true] {
            let voxel = |class: &u8| {
                let mut bytes = vec![0; size];
                bytes[if big { size - 1 } else { 0 }] = *class;
                bytes
            };
            let voxels: Vec<u8> = bar().iter().flat_map(voxel).collect();
            let found = read("a.nii", &Header { big, datatype, ..frame() }.file(&voxels)).expect("read");
            assert_eq!(ends(found), tips(SHEARLESS), "type {datatype}");
        }
    }
    let reals = |level: f32| bar().iter().flat_map(|class| (f32::from(*class) * level).to_le_bytes()).collect::<Vec<u8>>();
    let whole = Header { datatype: 16, ..frame() }.file(&reals(1.0));
    assert_eq!(ends(read("a.nii", &whole).expect("read")), tips(SHEARLESS));
    // Probabilities of .75 stored as 3, a quarter each.
    let scaled = Header { datatype: 16, slope: [0.25, 0.0], ..frame() }.file(&reals(3.0));
    let at = |level| read_first(&[("a.nii", &scaled)], &ReadOptions { level: Some(level), ..ReadOptions::default() });
    assert_eq!(ends(at(0.75).expect("read")), tips(SHEARLESS));
    assert!(at(0.76).expect_err("nothing").contains("an empty mask; expected a lower `level`"));
}

#[test]
fn classes_become_labels_where_there_are_several() {
    let mut voxels = bar();
    assert!((0..8).all(|link| lines(read("a.nii", &Header::default().file(&voxels)).expect("read")).labels.of(link).is_empty()));
    voxels.iter_mut().enumerate().filter(|(n, class)| n % 12 > 6 && **class > 0).for_each(|(_, class)| *class = 7);
    let lines = lines(read("a.nii", &Header { sform: Some(SHEARLESS), ..Header::default() }.file(&voxels)).expect("read"));
    let labels: Vec<&str> = (0..lines.links.len()).map(|link| lines.labels.of(link)).collect();
    assert!(labels.iter().filter(|label| **label == "7").count() == 4, "{labels:?}");
    assert!(labels.iter().all(|label| ["1", "7"].contains(label)), "{labels:?}");
}

/// The frame of ITK has x to the left and y backward.
pub const ITK: [[f64; 4]; 3] = [[0.0, 0.5, 0.0, -10.0], [-0.5, 0.0, 0.0, 20.0], [0.0, 0.0, 0.75, 30.0]];

fn metaimage(more: &str, file: &str) -> String {
    format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\n{more}TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 10 -20 30\n\
         ElementSpacing = 0.5 0.5 0.75\nDimSize = 12 5 6\nElementType = MET_UCHAR\nElementDataFile = {file}\n"
    )
}

#[test]
fn metaimage_is_read_from_one_file_and_from_two() {
    let bar = bar();
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
    packed.write_all(&bar).expect("packed");
    let packed = packed.finish().expect("packed");
    // ITK: first axis along +y, second along -x; the bar runs along y. In the scanner's frame both turn.
    for (more, voxels) in [("", &bar), ("CompressedData = True\n", &packed)] {
        let one = [metaimage(more, "LOCAL").as_bytes(), voxels].concat();
        assert_eq!(ends(read("a.mha", &one).expect("read")), tips(ITK), "{more}");
        let two = [("a.mhd", metaimage(more, "a.raw").into_bytes()), ("a.raw", voxels.clone())];
        let two: Vec<(&str, &[u8])> = two.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
        assert_eq!(ends(read_first(&two, &ReadOptions::default()).expect("read")), tips(ITK), "{more}");
    }
    // Without a spacing of its own it takes the one that is given.
    let bare = [metaimage("", "LOCAL").replace("ElementSpacing = 0.5 0.5 0.75\n", "").as_bytes(), &bar].concat();
    let said = read("a.mha", &bare).unwrap_err();
    assert!(said.contains("no ElementSpacing; expected it in the header, or give `spacing=SX,SY,SZ`, in mm"), "{said}");
    let scale = Scale { unit: LengthUnit::Millimetre, spacing: Some([0.5, 0.5, 0.75]) };
    let options = ReadOptions { scale, ..ReadOptions::default() };
    assert_eq!(ends(read_first(&[("a.mha", &bare)], &options).expect("read")), tips(ITK));
    let last = [b"four".as_slice(), &bar].concat();
    let head = metaimage("HeaderSize = -1\n", "a.raw");
    let found = read_first(&[("a.mhd", head.as_bytes()), ("a.raw", &last)], &ReadOptions::default()).expect("read");
    assert_eq!(ends(found), tips(ITK));
}

pub fn npy(descr: &str, fortran: bool, shape: &str, voxels: &[u8]) -> Vec<u8> {
    let fortran = if fortran { "True" } else { "False" };
    let text = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}");
    [b"\x93NUMPY\x01\x00\x76\x00".as_slice(), format!("{text:117}\n").as_bytes(), voxels].concat()
}

#[test]
fn a_numpy_mask_has_x_first_and_the_spacing_that_is_stated() {
    let scale = Scale { unit: LengthUnit::Millimetre, spacing: Some([0.5, 0.5, 0.75]) };
    let options = ReadOptions { scale, ..ReadOptions::default() };
    let frame = [[0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.75, 0.0]];
    let fortran = npy("|b1", true, "(12, 5, 6)", &bar());
    assert_eq!(ends(read_first(&[("a.npy", &fortran)], &options).expect("read")), tips(frame));
    let last_fastest: Vec<u8> = (0..360).map(|n| bar()[n / 30 + 12 * (n / 6 % 5) + 60 * (n % 6)]).collect();
    let c = npy("|u1", false, "(12, 5, 6)", &last_fastest);
    assert_eq!(ends(read_first(&[("a.npy", &c)], &options).expect("read")), tips(frame));
    assert!(read("a.npy", &c).expect_err("no spacing").contains("expected `spacing=SX,SY,SZ`, in mm"));
    // An archive that states its spacing, and an option that says the same or another one.
    let array =
        |name: &str, shape: &[usize], values: Vec<f64>| NamedArray { name: name.to_owned(), shape: shape.to_vec(), values };
    let mut npz = std::io::Cursor::new(Vec::new());
    let voxels = last_fastest.iter().map(|voxel| f64::from(*voxel)).collect();
    let arrays = [array("mask", &SHAPE, voxels), array("spacing", &[3], vec![0.5, 0.5, 0.75])];
    write_arrays(&mut npz, arrays).expect("written");
    let npz = npz.into_inner();
    assert_eq!(ends(read("a.npz", &npz).expect("read")), tips(frame));
    assert_eq!(ends(read_first(&[("a.npz", &npz)], &options).expect("read")), tips(frame));
    let other = Scale { unit: LengthUnit::Millimetre, spacing: Some([0.5, 0.5, 0.8]) };
    let said =
        read_first(&[("a.npz", &npz)], &ReadOptions { scale: other, ..ReadOptions::default() }).map(|_| ()).expect_err("two");
    assert_eq!(said, "a.npz: states voxels of 0.5 x 0.5 x 0.75 mm; expected no other `spacing`");
}

/// A bar four voxels wide and high has no middle voxel: thinning takes the same side of the patient, whichever way axes run.
#[test]
fn an_array_whose_frame_is_stated_is_thinned_as_one_in_the_scanner_s_order() {
    let scale = Scale { unit: LengthUnit::Millimetre, spacing: Some([0.5; 3]) };
    let is_inside = |x: usize, y: usize, z: usize| (2..6).contains(&x) && (3..7).contains(&y) && (2..30).contains(&z);
    let at = |frame: Frame| {
        let turned = |x: usize, most: usize| if frame == Frame::Lps { most - x } else { x };
        let voxels: Vec<u8> =
            (0..9 * 10 * 32).map(|n| u8::from(is_inside(turned(n % 9, 8), turned(n / 9 % 10, 9), n / 90))).collect();
        let options = ReadOptions { scale, frame: Some(frame), ..ReadOptions::default() };
        ends(read_first(&[("a.npy", &npy("|u1", true, "(9, 10, 32)", &voxels))], &options).expect("read"))
    };
    let mut lps = at(Frame::Lps).map(|[x, y, z]| [4.0 - x, 4.5 - y, z]);
    lps.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    assert_eq!(lps, at(Frame::Ras));
}

#[test]
fn what_is_no_mask_is_refused_in_one_line() {
    let plain = Header::default();
    let good = plain.file(&bar());
    let with = |header: Header| header.file(&bar());
    let real = |value: f32| Header { datatype: 16, ..Header::default() }.file(&value.to_le_bytes().repeat(360));
    let cut = gzip_at(Compression::none(), &good);
    let huge = vec![1 << 13, 1 << 13, 1 << 14];
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("empty.nii", plain.file(&[0; 360]), "an empty mask; expected voxels of vessels, which are not 0"),
        (
            "4d.nii",
            with(Header { dim: vec![12, 5, 3, 2], ..plain.clone() }),
            "an image of 4 dimensions: 12 x 5 x 3 x 2; expected three",
        ),
        ("2d.nii", with(Header { dim: vec![12, 30], ..plain.clone() }), "an image of 2 dimensions: 12 x 30; expected three"),
        ("negative.nii", with(Header { dim: vec![12, -5, 6], ..plain.clone() }), "12 x -5 x 6"),
        ("nan.nii", real(f32::NAN), "voxel 0,0,0: not a number; expected a finite value"),
        ("image.nii", real(117.5), "voxel 0,0,0: 117.5: looks like an image, not a mask; give `level`"),
        ("minus.nii", real(-1.0), "voxel 0,0,0: -1: looks like an image"),
        ("power.nii", real(2_f32.powi(100)), "voxel 0,0,0: 1.2676506002282294e30: looks like an image"),
        (
            "zero.nii",
            with(Header { pixdim: [1.0, 0.5, 0.0, 0.5], ..plain.clone() }),
            "voxels of 0.5 x 0 x 0.5 mm; expected a positive spacing",
        ),
        (
            "flat.nii",
            with(Header { sform: Some([[0.0, -0.5, 0.0, 0.0], [0.5, 0.0, 0.75, 0.0], [0.0; 4]]), ..plain.clone() }),
            "axes that lie in a plane",
        ),
        ("quaternion.nii", with(Header { qform: Some([1.0, 1.0, 0.0, 0.0, 0.0, 0.0]), ..plain.clone() }), "quaternion 1 1 0"),
        ("rgb.nii", with(Header { datatype: 128, ..plain.clone() }), "voxels of type 128"),
        ("cut.nii", good[..500].to_vec(), "148 of 360 voxels; expected all of them; is the file cut off?"),
        ("cut.nii.gz", cut[..cut.len() - 20].to_vec(), "expected a whole file"),
        (
            "huge.nii.gz",
            gzip(&with(Header { two: true, dim: huge, ..plain.clone() })),
            "8192 x 8192 x 16384 voxels of 1 bytes; expected at most",
        ),
        ("overflow.nii", with(Header { two: true, dim: vec![i64::MAX; 3], ..plain }), "expected at most"),
        ("grey.npy", npy("|u1", true, "(16, 16, 1)", &(0..=255).collect::<Vec<u8>>()), "no spacing"),
        ("text.npy", npy("<U1", true, "(1, 1, 1)", &[65, 0, 0, 0]), "no spacing"),
        ("four.npy", npy("|u1", true, "(2, 1, 1, 2)", &[1; 4]), "4 dimensions; expected a mask of three"),
        ("a.mha", metaimage("", "LOCAL").replace("NDims = 3", "NDims = 2").into_bytes(), "a.mha:2: NDims \"2\""),
        ("b.mha", metaimage("", "LOCAL").replace("0.5 0.5", "0.5 0").into_bytes(), "ElementSpacing 0"),
        ("c.mha", metaimage("", "../a.raw").into_bytes(), "expected LOCAL, or the name of one file in the same folder"),
        ("d.mha", metaimage("", "LOCAL").into_bytes(), "0 of 360 voxels"),
    ];
    for (name, bytes, wanted) in cases {
        let said = read(name, &bytes).map(|_| ()).expect_err(name);
        assert!(said.contains(wanted) && said.starts_with(name) && !said.contains('\n'), "{said}");
    }
    let scale = Scale { unit: LengthUnit::Millimetre, spacing: Some([1.0; 3]) };
    let options = ReadOptions { scale, ..ReadOptions::default() };
    let grey = npy("|u1", true, "(16, 16, 1)", &(0..=255).collect::<Vec<u8>>());
    let said = read_first(&[("grey.npy", &grey)], &options).expect_err("an image");
    assert!(said.contains("looks like an image, not a mask: 255 values"), "{said}");
    let text = npy("<U1", true, "(1, 1, 1)", &[65, 0, 0, 0]);
    assert!(read_first(&[("text.npy", &text)], &options).expect_err("text").contains("text; expected numbers"));
}

/// MetaImage with other voxels than the bar's.
fn meta(from: &[(&str, &str)], voxels: &[u8]) -> Vec<u8> {
    let head = from.iter().fold(metaimage("", "LOCAL"), |head, (from, to)| head.replace(from, to));
    [head.as_bytes(), voxels].concat()
}

#[test]
fn metaimage_and_numpy_refuse_what_nifti_refuses() {
    let float = |value: f32| meta(&[("MET_UCHAR", "MET_FLOAT")], &value.to_le_bytes().repeat(360));
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::none());
    packed.write_all(&bar()).expect("packed");
    let packed = packed.finish().expect("packed");
    let four = [
        ("NDims = 3", "NDims = 4"),
        ("0 1 0 -1 0 0 0 0 1", "0 1 0 0 -1 0 0 0 0 0 1 0 0 0 0 1"),
        ("10 -20 30", "10 -20 30 0"),
        ("0.5 0.5 0.75", "0.5 0.5 0.75 1"),
    ];
    let with = |size: &'static str| [&four[..], &[("12 5 6", size)]].concat();
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("empty.mha", meta(&[], &[0; 360]), "an empty mask; expected voxels of vessels, which are not 0"),
        ("4d.mha", meta(&with("12 5 3 2"), &bar()), "DimSize \"12 5 3 2\"; expected three dimensions; take one volume"),
        (
            "text.mha",
            meta(&[("BinaryData = True", "BinaryData = False")], b"1 0 1"),
            "voxels as text; expected BinaryData = True",
        ),
        ("nan.mha", float(f32::NAN), "voxel 0,0,0: not a number; expected a finite value"),
        ("image.mha", float(117.5), "117.5: looks like an image, not a mask; give `level`"),
        ("huge.mha", meta(&[("12 5 6", "16384 8192 8192")], &[]), "16384 x 8192 x 8192 voxels of 1 bytes; expected at most"),
        ("infinite.mha", meta(&[("10 -20 30", "inf -20 30")], &bar()), "a finite origin"),
        ("nan-axis.mha", meta(&[("0 1 0 -1", "0 nan 0 -1")], &bar()), "expected a positive spacing along every axis"),
        ("flat.mha", meta(&[("0 1 0 -1 0 0 0 0 1", "0 1 0 -1 0 0 1 0 0")], &bar()), "axes that lie in a plane"),
        ("cut.mha", meta(&[("BinaryData", "CompressedData = True\nBinaryData")], &packed[..200]), "expected a whole file"),
    ];
    for (name, bytes, wanted) in cases {
        let said = read(name, &bytes).map(|_| ()).expect_err(name);
        assert!(said.contains(wanted) && said.starts_with(name) && !said.contains('\n'), "{said}");
    }
    assert_eq!(ends(read("one.mha", &meta(&with("12 5 6 1"), &bar())).expect("one volume")), tips(ITK));
    let scale = Scale { unit: LengthUnit::Millimetre, spacing: Some([1.0; 3]) };
    let options = ReadOptions { scale, ..ReadOptions::default() };
    let real = |value: f32| npy("<f4", true, "(12, 5, 6)", &value.to_le_bytes().repeat(360));
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("empty.npy", npy("|u1", true, "(12, 5, 6)", &[0; 360]), "an empty mask"),
        ("4d.npy", npy("|u1", true, "(12, 5, 3, 2)", &bar()), "4 dimensions; expected a mask of three"),
        ("nan.npy", real(f32::NAN), "voxel 0,0,0: not a number"),
        ("image.npy", real(0.3), "looks like an image, not a mask; give `level`"),
        ("cut.npy", npy("|u1", true, "(12, 5, 6)", &bar()[..100]), "expected a whole file"),
        ("huge.npy", npy("|u1", true, "(16384, 8192, 8192)", &[1]), "expected"),
    ];
    for (name, bytes, wanted) in cases {
        let said = read_first(&[(name, &bytes)], &options).map(|_| ()).expect_err(name);
        assert!(said.contains(wanted) && said.starts_with(name) && !said.contains('\n'), "{said}");
    }
    let one = npy("|u1", true, "(12, 5, 6, 1)", &bar());
    let plain = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    assert_eq!(ends(read_first(&[("one.npy", &one)], &options).expect("one volume")), tips(plain));
    let one = Header { dim: vec![12, 5, 6, 1], sform: Some(SHEARLESS), ..Header::default() }.file(&bar());
    assert_eq!(ends(read("one.nii", &one).expect("one volume")), tips(SHEARLESS));
    for (rows, wanted) in [(f64::NAN, "voxels of"), (f64::INFINITY, "voxels of")] {
        let bad = Header { sform: Some([[0.0, rows, 0.0, 0.0], SHEARLESS[1], SHEARLESS[2]]), ..Header::default() };
        assert!(read("a.nii", &bad.file(&bar())).expect_err("no frame").contains(wanted));
    }
}

const NIBABEL: &str = r#"
import sys, os, numpy as np, nibabel as nib
rng = np.random.default_rng(11)
for n in range(12):
    a = np.zeros((12, 5, 6), rng.choice([np.uint8, np.int16, np.float32]))
    a[2:11, 2, 3] = 1
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    m = np.eye(4); m[:3, :3] = q * rng.uniform(.4, 1.2, 3); m[:3, 3] = rng.normal(size=3) * 50
    image = (nib.Nifti2Image if n % 2 else nib.Nifti1Image)(a, m)
    if n % 3 == 0: image.set_sform(None)
    else: image.set_sform(m, 2)
    path = os.path.join(sys.argv[1], f"{n}.nii.gz"); nib.save(image, path)
    b = nib.load(path).affine
    print(*b[:3].ravel())
"#;

#[test]
fn nibabel_says_the_same_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(out) = python(NIBABEL, &[folder.path()]) else { return };
    for (n, line) in out.lines().enumerate() {
        let numbers: Vec<f64> = line.split(' ').map(|word| word.parse().expect("a number")).collect();
        let affine = [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| numbers[4 * row + column]));
        let path = folder.path().join(format!("{n}.nii.gz"));
        let found = ends(willis::internals::formats::read(&path, &ReadOptions::default()).expect("read"));
        for (a, b) in found.iter().flatten().zip(tips(affine).iter().flatten()) {
            assert!((a - b).abs() < 2e-3, "{n}: {found:?} {:?}", tips(affine));
        }
    }
    assert_eq!(out.lines().count(), 12);
}
