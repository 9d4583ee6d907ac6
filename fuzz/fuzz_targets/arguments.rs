//! Words of a command line, one a line: the parser reads them, or refuses them in one line. What they mean is worked out too, as the module
//! for Python does it, but nothing is run.
#![no_main]

use std::ffi::OsString;
use std::path::Path;

use libfuzzer_sys::fuzz_target;
use willis::cli::{check, words};
use willis::internals::phantom::circle_of_willis;
use willis::internals::support::printable::printable;

fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    let given: Vec<String> = text.split('\n').map(str::to_owned).collect();
    let all = std::iter::once("willis".to_owned()).chain(given.clone()).map(OsString::from);
    if let Some(said) = check(all) {
        assert!(!printable(&said).contains('\n') && said.contains("see willis help"), "{said}");
    }
    let Some((command, rest)) = given.split_first() else { return };
    let input = Path::new("x.swc");
    match command.as_str() {
        "infer" => {
            if let Ok((options, _)) = words::infer(input, rest) {
                let _ = options.validate();
            }
        }
        "simulate" => {
            if let Ok((options, _)) = words::simulate(input, rest) {
                let _ = options.validate();
            }
        }
        "modulate" => drop(words::modulate(input, &circle_of_willis(1e-2), rest)),
        "classify" => drop(words::classify(input, rest)),
        "reading" => {
            if let Ok(options) = words::reading(input, rest) {
                let _ = options.validate();
            }
        }
        _ => {}
    }
});
