//! Files that are named for every input of a cohort at once.

use std::path::{Path, PathBuf};

/// A file named for every input: `{}` in its name is the input without its ending, `{dir}` the folder of the input.
pub fn beside(name: &Path, input: &Path) -> PathBuf {
    let Some(text) = name.to_str().filter(|text| text.contains('{')) else { return name.to_owned() };
    let folder = input.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Split first, so that braces in the name of a folder stay as they are.
    let mut path = String::new();
    for (at, part) in text.split("{dir}").enumerate() {
        if at > 0 {
            path += &folder.to_string_lossy();
        }
        let whole = if input.is_dir() { input.to_owned() } else { input.with_extension("") };
        path += &part.replace("{}", &whole.to_string_lossy());
    }
    path.into()
}
