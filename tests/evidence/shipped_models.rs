//! The models that ship: each file has the bytes that `willis train` writes of what is read from it.

use std::fs;
use std::io;
use std::path::Path;

use willis::internals::candidates::joins::model::JoinModel;
use willis::internals::candidates::model::Weights;
use willis::internals::contacts::model::ContactModel;
use willis::internals::naming::NamingModel;

/// Writes what is read of a text.
type Again = fn(&str, &mut Vec<u8>) -> io::Result<()>;

#[test]
fn every_shipped_model_is_as_it_is_written() {
    let files: [(&str, Again); 6] = [
        ("candidates/model/weights.toml", |text, out| Weights::read(text).expect("weights").write(out)),
        ("candidates/model/tubes.toml", |text, out| Weights::read(text).expect("weights").write(out)),
        ("candidates/joins/skeleton.toml", |text, out| JoinModel::read(text).expect("a model").write(out)),
        ("contacts/contacts.toml", |text, out| ContactModel::read(text).expect("a model").write(out)),
        ("naming/arteries.toml", |text, out| NamingModel::read(text).expect("a model").write(out)),
        ("naming/drawn.toml", |text, out| NamingModel::read(text).expect("a model").write(out)),
    ];
    for (name, again) in files {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/models/src").join(name);
        let (text, mut out) = (fs::read_to_string(path).expect("a file"), Vec::new());
        again(&text, &mut out).expect("memory");
        assert!(text.as_bytes() == out, "{name} is not as it is written");
    }
}

/// A model of names whose numbers are none is refused as such: all that it would say is no number either.
#[test]
fn a_model_of_names_without_numbers_is_refused() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/models/src/naming/arteries.toml");
    let text = fs::read_to_string(path).expect("a file");
    for (line, wrong) in [
        ("length", "length = -100.0"),
        ("length", "length = nan"),
        ("centroid", "centroid = [nan, 0.0, 0.0]"),
        ("other_radius", "other_radius = [0.1, inf]"),
        ("other_radius", "other_radius = [nan, 0.7]"),
    ] {
        let first = text.lines().find(|found| found.starts_with(&format!("{line} = "))).expect("a line");
        let fault = NamingModel::read(&text.replacen(first, wrong, 1)).expect_err(wrong);
        assert!(fault.in_file("a.toml".as_ref()).to_string().contains(line), "{wrong}");
    }
}
