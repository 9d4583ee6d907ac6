//! Opens files that nobody named on the command line, which have to be regular ones; and tells what is there from what is absent.

use std::fs::{self, File};
use std::{io, path::Path};

use willis_core::error::{Error, Fault, Result};

/// Whether something is at a path, be it a folder or a link to nothing: what is there and cannot be read is an error, and not absent.
pub fn is_there(path: &Path) -> bool {
    use io::ErrorKind::{InvalidFilename, NotADirectory, NotFound};
    fs::symlink_metadata(path).map_or_else(|e| !matches!(e.kind(), NotFound | NotADirectory | InvalidFilename), |_| true)
}

/// Opens a file that nobody named on the command line: one beside an input, in a folder, or found by a pattern. It is not waited for, as a pipe
/// that nobody writes would be. (A file that is named may be a pipe: who named it fills it.)
///
/// # Errors
///
/// It cannot be opened, or is no regular file: what it is.
pub fn open_regular(path: &Path) -> Result<File> {
    const EXPECTED: &str = "expected a regular file";
    let mut options = File::options();
    options.read(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK | libc::O_NOCTTY);
    let opened = options.open(path);
    // Asked of the path, since a socket cannot be opened.
    let about = opened.as_ref().map_or_else(|_| fs::metadata(path), File::metadata);
    if let Some(what) = about.ok().filter(|about| !about.is_file()).map(|about| kind_of(&about)) {
        return Err(Fault::file(what, EXPECTED).in_file(path));
    }
    match opened {
        Err(e) if e.kind() == io::ErrorKind::NotFound && is_there(path) => {
            let to =
                fs::read_link(path).map_or_else(|_| "nothing".to_owned(), |to| format!("{}, which is not there", to.display()));
            Err(Fault::file(format!("a link to {to}"), EXPECTED).in_file(path))
        }
        opened => opened.map_err(|source| Error::Read { path: path.to_owned(), source }),
    }
}

/// What is no regular file, in words.
fn kind_of(about: &fs::Metadata) -> &'static str {
    if about.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if about.file_type().is_fifo() {
            return "a pipe";
        }
        if about.file_type().is_socket() {
            return "a socket";
        }
    }
    "a device"
}
