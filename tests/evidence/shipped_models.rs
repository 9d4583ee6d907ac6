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
