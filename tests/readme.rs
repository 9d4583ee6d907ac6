//! The Python of the README, run as it stands there on the output of its first command. Needs `WILLIS_PYTHON`.

mod command;

use std::fs;
use std::path::Path;
use std::process::Command;

use command::{data, folder, stderr, willis};

#[test]
fn the_python_example_draws_the_kept_graph() {
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).expect("a README");
    let (_, rest) = readme.split_once("```python\n").expect("Python");
    let (example, rest) = rest.split_once("```").expect("an end");
    assert!(!rest.contains("```python"), "one example, which is run");
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python with tests/requirements.txt");
        return;
    };
    let here = folder();
    let made = willis(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "out", "-q"]);
    assert!(made.status.success(), "{}", stderr(&made));
    let mut drawing = Command::new(python);
    let drawn = drawing.current_dir(here.path()).env("MPLBACKEND", "Agg").args(["-c", example]).output().expect("runs");
    assert!(drawn.status.success(), "{}", stderr(&drawn));
    let file = fs::File::open(here.path().join("kept.png")).expect("a picture");
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG header");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut pixels).expect("an image");
    let coloured = pixels.chunks_exact(info.color_type.samples()).filter(|p| p[0].abs_diff(p[2]) > 60).count();
    assert!(coloured > 500, "{coloured} pixels of vessels");
}
