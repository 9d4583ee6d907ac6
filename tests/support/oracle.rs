//! Finds the independent programs in Python that lie beside the project, for the tests.

use std::path::Path;
use std::process::Command;

/// The path of a script of `../shared/oracle` and the Python that runs it (`WILLIS_PYTHON`, else `python3`); `None`, said aloud, where one
/// of them is absent or NumPy is.
pub fn oracle(name: &str) -> Option<(String, String)> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/oracle").join(name);
    let python = std::env::var("WILLIS_PYTHON").unwrap_or_else(|_| "python3".into());
    if script.exists() && Command::new(&python).args(["-c", "import numpy"]).output().is_ok_and(|o| o.status.success()) {
        return Some((script.display().to_string(), python));
    }
    eprintln!("skipped: no {} or no {python} with NumPy", script.display());
    None
}
