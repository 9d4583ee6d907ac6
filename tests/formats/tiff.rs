//! TIFF stacks: files written by hand from TIFF 6.0, and by tifffile as ImageJ and OME have them.

use crate::images::{bar, ends, read, tips};
use crate::peers::{python, read_first};
use willis::internals::formats::{Format, ReadOptions, read as read_file, read_image};
use willis::internals::network::Frame;
use willis::{LengthUnit, Scale};

/// A little-endian TIFF of pages of 12 x 5 pixels of one byte, as they are, the first with a description and 2000 pixels to the unit.
fn tiff(description: &str, pages: &[&[u8]], swaps: &[(u16, u32)]) -> Vec<u8> {
    let mut out = b"II\x2a\0\0\0\0\0".to_vec();
    let mut link = 4;
    for (number, pixels) in pages.iter().enumerate() {
        let at = out.len() as u32;
        out.extend_from_slice(pixels);
        let text = out.len() as u32;
        out.extend_from_slice(description.as_bytes());
        out.push(0);
        let ratio = out.len() as u32;
        out.extend([2000_u32, 1].iter().flat_map(|x| x.to_le_bytes()));
        let mut fields = vec![
            (256_u16, 4_u16, 1_u32, 12_u32),
            (257, 4, 1, 5),
            (258, 3, 1, 8),
            (259, 3, 1, 1),
            (262, 3, 1, 1),
            (273, 4, 1, at),
            (277, 3, 1, 1),
            (278, 4, 1, 5),
            (279, 4, 1, pixels.len() as u32),
        ];
        if number == 0 && !description.is_empty() {
            fields.extend([(270, 2, description.len() as u32 + 1, text), (282, 5, 1, ratio), (283, 5, 1, ratio), (296, 3, 1, 1)]);
        }
        for (tag, value) in swaps {
            fields.iter_mut().filter(|field| field.0 == *tag).for_each(|field| field.3 = *value);
        }
        fields.sort_unstable();
        let start = out.len() as u32;
        out[link..link + 4].copy_from_slice(&start.to_le_bytes());
        out.extend((fields.len() as u16).to_le_bytes());
        for (tag, kind, count, value) in fields {
            out.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
            out.extend([count.to_le_bytes(), value.to_le_bytes()].concat());
        }
        link = out.len();
        out.extend([0; 4]);
    }
    out
}

fn stack(description: &str) -> Vec<u8> {
    let bar = bar();
    tiff(description, &bar.chunks(60).collect::<Vec<_>>(), &[])
}

fn frame(spacing: [f64; 3]) -> [[f64; 4]; 3] {
    std::array::from_fn(|row| std::array::from_fn(|column| if row == column { spacing[row] } else { 0.0 }))
}

const IMAGEJ: &str = "ImageJ=1.54f\nimages=6\nslices=6\nunit=mm\nspacing=0.75\nloop=false\n";
const OME: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\"><Image ID=\"Image:0\">\
    <Pixels ID=\"Pixels:0\" Type=\"uint8\" DimensionOrder=\"XYZCT\" SizeX=\"12\" SizeY=\"5\" SizeZ=\"6\" SizeC=\"1\" SizeT=\"1\" \
    PhysicalSizeX=\"500\" PhysicalSizeY=\"0.25\" PhysicalSizeYUnit=\"mm\" PhysicalSizeZ=\"750\"><TiffData/></Pixels></Image></OME>";

#[test]
fn the_spacing_is_that_of_imagej_of_ome_or_of_the_user() {
    let cases = [
        (IMAGEJ.to_owned(), [0.0005, 0.0005, 0.75]),
        (IMAGEJ.replace("=mm", "=cm"), [0.005, 0.005, 7.5]),
        (IMAGEJ.replace("=mm", "=\\u00B5m"), [5e-7, 5e-7, 0.00075]),
        (IMAGEJ.replace("=mm", "=micron"), [5e-7, 5e-7, 0.00075]),
        (OME.to_owned(), [0.5, 0.25, 0.75]),
    ];
    for (description, spacing) in cases {
        let bytes = stack(&description);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.tif");
        std::fs::write(&path, &bytes).expect("written");
        let image = read_image(&path, &ReadOptions::default(), Frame::Unknown).expect("an image").0;
        for (axis, step) in spacing.iter().enumerate() {
            assert!((image.affine[axis][axis] / step - 1.0).abs() < 1e-9, "{description}: {:?}", image.affine);
        }
        assert_eq!((image.shape, image.values.iter().sum::<f32>()), ([12, 5, 6], 9.0));
    }
    let found = read("a.tif", &stack(OME)).expect("read");
    assert_eq!((found.format, ends(found)), (Format::Tiff, tips(frame([0.5, 0.25, 0.75]))));
    let scale = Scale { unit: LengthUnit::Millimetre, spacing: Some([0.5, 0.5, 0.75]) };
    let given = ReadOptions { scale, ..ReadOptions::default() };
    for description in ["", IMAGEJ, "some text"] {
        let found = read_first(&[("a.tif", &stack(description))], &given).expect("read");
        assert_eq!(ends(found), tips(frame([0.5, 0.5, 0.75])), "{description}");
    }
}

/// Where 0 is drawn white, the values are those of the file, as tifffile, scikit-image and SimpleITK read them.
#[test]
fn a_table_of_greys_that_is_turned_round_changes_no_value() {
    let bar = bar();
    let white_is_zero = tiff(OME, &bar.chunks(60).collect::<Vec<_>>(), &[(262, 0)]);
    assert_eq!(ends(read("a.tif", &white_is_zero).expect("read")), tips(frame([0.5, 0.25, 0.75])));
    let script = r#"
import sys, os, numpy as np, tifffile
a = np.zeros((6, 5, 12)); a[3, 2, 2:11] = 1
for kind in ["u1", "<u2", ">u2", "u4", "u8", "<f4", ">f4", "f8"]:
    path = os.path.join(sys.argv[1], f"{kind}.tif".replace("<", "l").replace(">", "b"))
    tifffile.imwrite(path, a.astype(kind), photometric="miniswhite", byteorder=">" if kind[0] == ">" else "<")
    assert (tifffile.imread(path) == a).all()
    print(path)
"#;
    let folder = tempfile::tempdir().expect("a folder");
    let Some(out) = python(script, &[folder.path()]) else { return };
    let scale = Scale { unit: LengthUnit::Millimetre, spacing: Some([0.5, 0.5, 0.75]) };
    for path in out.lines() {
        let image =
            read_image(path.as_ref(), &ReadOptions { scale, ..ReadOptions::default() }, Frame::Unknown).expect("an image").0;
        let expected: Vec<f32> = bar.iter().map(|value| f32::from(*value)).collect();
        assert_eq!(image.values, expected, "{path}");
    }
}

#[test]
fn what_is_no_usable_stack_is_refused_in_one_line() {
    let bar = bar();
    let pages: Vec<&[u8]> = bar.chunks(60).collect();
    let with = |swaps: &[(u16, u32)]| tiff(OME, &pages, swaps);
    let ome = |from: &str, to: &str| stack(&OME.replace(from, to));
    let mut circle = stack(OME);
    let last = circle.len() - 4;
    let first = [circle[4], circle[5], circle[6], circle[7]];
    circle[last..].copy_from_slice(&first);
    let whole = stack(OME);
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("plain.tif", stack(""), "no spacing of the pixels; expected that of ImageJ or OME-XML, or give `spacing=SX,SY,SZ`"),
        ("pixel.tif", stack(&IMAGEJ.replace("=mm", "=pixel")), "no spacing of the pixels"),
        ("slices.tif", stack(&IMAGEJ.replace("spacing=0.75\n", "")), "no spacing of the slices"),
        ("zero.tif", ome("PhysicalSizeX=\"500\"", "PhysicalSizeX=\"0\""), "no spacing of the pixels"),
        ("channels.tif", ome("SizeC=\"1\"", "SizeC=\"3\""), "SizeC 3; expected three dimensions; take one channel and one time"),
        ("frames.tif", stack(&IMAGEJ.replace("slices=6", "frames=6")), "6 frames; expected three dimensions"),
        ("series.tif", ome("SizeZ=\"6\"", "SizeZ=\"60\""), "6 of 60 pages; expected every slice as a page of the same file"),
        ("one-page.tif", tiff(&IMAGEJ.replace("=6", "=60"), &pages[..1], &[]), "1 of 60 pages"),
        ("colours.tif", with(&[(262, 3)]), "pixels with a table of colours; expected grey values"),
        ("rgb.tif", with(&[(262, 2)]), "expected"),
        ("bits.tif", with(&[(258, 4)]), "pixels of type Gray(4); expected one grey value each"),
        ("jpeg.tif", with(&[(259, 7)]), "expected"),
        ("wide.tif", with(&[(256, 1 << 30), (257, 1 << 30), (278, 1 << 30)]), "expected"),
        ("claim.tif", with(&[(256, 1 << 14), (257, 1 << 13), (278, 1 << 13)]), "pages of 134217728 bytes in a file of"),
        ("circle.tif", circle, "expected a whole TIFF file"),
        ("void.tif", tiff(OME, &[[0; 60].as_slice(); 6], &[]), "an empty mask"),
        ("cut.tif", whole[..whole.len() - 40].to_vec(), "expected"),
        ("head.tif", whole[..8].to_vec(), "expected a whole TIFF file"),
    ];
    for (name, bytes, wanted) in cases {
        let said = read(name, &bytes).map(|_| ()).expect_err(name);
        assert!(said.contains(wanted) && said.starts_with(name) && !said.contains('\n'), "{said}");
    }
    let pages: Vec<&[u8]> = vec![&bar[..60], &bar[60..120]];
    let mut other = tiff(&OME.replace("SizeZ=\"6\"", "SizeZ=\"2\""), &pages, &[]);
    // The second page is said to have 6 rows less: its width is the last field 256.
    let width = other.windows(8).rposition(|field| field == [0, 1, 4, 0, 1, 0, 0, 0]).expect("a field");
    other[width + 8] = 6;
    let said = read("other.tif", &other).map(|_| ()).expect_err("other");
    assert!(said.contains("page 2: 6 x 5 pixels of 1 bytes; expected 12 x 5 of 1 bytes, as the first page"), "{said}");
    crate::peers::truncated(&[("a.tif", &whole)], 11, &ReadOptions::default());
}

const TIFFFILE: &str = r#"
import sys, os, numpy as np, tifffile
a = np.zeros((6, 5, 12)); a[3, 2, 2:11] = 1
n = 0
for kind in ["u1", "u2", "f4"]:
    path = os.path.join(sys.argv[1], f"imagej-{kind}.tif")
    tifffile.imwrite(path, a.astype(kind), imagej=True, resolution=(2, 2), metadata={"axes": "ZYX", "spacing": .75, "unit": "mm"})
    print(path, .5, .5, .75)
for kind in ["u1", "i1", "<u2", ">u2", "i2", "u4", "i4", "<f4", ">f4", "f8"]:
    for how in [None, "zlib", "packbits", "lzw"]:
        for tile in [None, (16, 16)]:
            for predictor in [False, True]:
                if predictor and how not in ("zlib", "lzw"): continue
                path = os.path.join(sys.argv[1], f"ome{n}.ome.tif"); n += 1
                try:
                    with tifffile.TiffWriter(path, ome=True, byteorder=">" if kind[0] == ">" else "<", bigtiff=n % 5 == 0) as out:
                        out.write(a.astype(kind), compression=how, tile=tile, predictor=predictor, photometric="minisblack",
                            metadata={"axes": "ZYX", "PhysicalSizeX": 400., "PhysicalSizeY": 500., "PhysicalSizeZ": 600.})
                except (ValueError, ImportError, KeyError) as error:
                    os.remove(path); continue
                print(path, .4, .5, .6)
"#;

#[test]
fn tifffile_writes_what_is_read_with_its_spacing() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(out) = python(TIFFFILE, &[folder.path()]) else { return };
    for line in out.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let spacing = [1, 2, 3].map(|at| words[at].parse::<f64>().expect("a number"));
        let found = read_file(words[0].as_ref(), &ReadOptions::default()).unwrap_or_else(|e| panic!("{line}: {e}"));
        assert_eq!(ends(found), tips(frame(spacing)), "{line}");
        let (image, _) = read_image(words[0].as_ref(), &ReadOptions::default(), Frame::Unknown).expect("an image");
        assert_eq!((image.shape, image.values.iter().sum::<f32>()), ([12, 5, 6], 9.0), "{line}");
    }
    println!("{} files", out.lines().count());
    assert!(out.lines().count() > 20, "{out}");
}
