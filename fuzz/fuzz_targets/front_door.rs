//! A file of any name and content: which format it is, is found out, and it is read as what it is, or refused. The first line is the name,
//! the second one the options, the rest is the file.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use willis::cli::words;
use willis::internals::formats::graph_columns;
use willis::read_bytes;

fuzz_target!(|bytes: &[u8]| {
    let mut parts = bytes.splitn(3, |byte| *byte == b'\n');
    let (Some(name), Some(options), Some(content)) = (parts.next(), parts.next(), parts.next()) else { return };
    // A name without folders: nothing beside it is read.
    let name = String::from_utf8_lossy(name).replace(['/', '\0'], "_");
    let name = Path::new("/nowhere").join(name);
    let options = String::from_utf8_lossy(options);
    let options: Vec<String> = options.split_ascii_whitespace().map(str::to_owned).collect();
    let Ok(mut options) = words::reading(&name, &options) else { return };
    options.loops = None;
    options.max_input = options.max_input.min(1 << 24);
    let Ok(input) = read_bytes(&name, content, &options) else { return };
    assert!(input.network.vessel_count() > 0);
    assert!(
        input.network.vessels().all(|(_, vessel)| vessel.length > 0.0 && vessel.radius > 0.0),
        "a vessel without length or radius"
    );
    let _ = graph_columns(&input.network);
    let _ = words::said_of_input(&input);
});
