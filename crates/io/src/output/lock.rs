//! The lock of a hidden folder, and what may be trusted in a folder that others can write to: only what this user made, never a link.

use std::fs::{self, DirBuilder, File, Metadata, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::{path::Path, thread::sleep, time::Duration};

use willis_core::error::{Error, Result, ensure};

/// The name of the file that is locked.
pub const LOCK: &str = "lock";
/// How often a lock is tried, which another process may hold only for a moment, to clean up.
pub const TRIES: usize = 25;
const BETWEEN: Duration = Duration::from_millis(20);
/// The longest number of a process.
const DIGITS: u64 = 20;

/// The folder that a path is in.
pub fn parent(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The error for an output that a path is there which this user did not make: a link, a device, another user's file.
fn foreign(path: &Path, target: &Path) -> Error {
    let path = path.display();
    let accepted = format!("{path} is a link, a device or another user's; remove it, or choose another `output`");
    Error::parameter("output", target.display(), accepted)
}

/// Creates a folder that only this user may look into, and takes its lock, which ends with the process, however that ends.
///
/// # Errors
///
/// Those for the output `target`: another process holds the lock, a path is not this user's, or the system refuses.
pub fn lock(folder: &Path, target: &Path, tries: usize) -> Result<File> {
    let refused = |source| Error::Write { path: target.to_owned(), source };
    let path = folder.join(LOCK);
    let found = || fs::symlink_metadata(&path).ok();
    // Whether an open file is still the one at the path: its last holder may have removed it.
    let is_there = |file: &File| file.metadata().ok().zip(found()).is_some_and(|(a, b)| identity(&a) == identity(&b));
    let mut process = String::new();
    for at in 0..tries {
        make_own(folder, target)?;
        let mut file = match open(&path) {
            // The folder was removed in this moment.
            Err(e) if e.kind() == io::ErrorKind::NotFound && at + 1 < tries => continue,
            // A link, or a pipe that nobody reads.
            Err(_) if found().is_some_and(|about| !about.is_file()) => return Err(foreign(&path, target)),
            opened => opened.map_err(refused)?,
        };
        // With one name at most, and of the user of the folder.
        let is_of_one_user = |about: &Metadata| {
            cfg!(not(unix))
                || fs::symlink_metadata(folder).is_ok_and(|folder| FileFacts::of(&folder).user == FileFacts::of(about).user)
        };
        let is_own = |about: Metadata| about.is_file() && FileFacts::of(&about).names <= 1 && is_of_one_user(&about);
        ensure(file.metadata().is_ok_and(is_own), || foreign(&path, target))?;
        match file.try_lock() {
            Ok(()) if is_there(&file) => {
                // For users; the lock works without it.
                let _ = file.set_len(0).and_then(|()| write!(file, "{}", std::process::id()));
                return Ok(file);
            }
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                process.clear();
                let _ = file.rewind().and_then(|()| file.take(DIGITS).read_to_string(&mut process));
                sleep(BETWEEN);
            }
            // A file system without locks is no reason to stop.
            Err(TryLockError::Error(_)) => return Ok(file),
        }
    }
    let is_number = !process.is_empty() && process.bytes().all(|b| b.is_ascii_digit());
    let process = if is_number { format!(" (process {process})") } else { String::new() };
    let accepted = format!("another willis{process} is writing there; wait for it, or choose another `output`");
    Err(Error::parameter("output", target.display(), accepted))
}

/// Whether a path is a folder that was made by the user that this process makes files as, and not a link to one. That is asked of the file system itself,
/// by a file without a name in the same folder: on network drives and in containers it may not be the user that the process runs as.
pub fn is_own_folder(path: &Path) -> bool {
    let probe = || tempfile::tempfile_in(parent(path)).and_then(|probe| probe.metadata());
    let is_own =
        |about: &Metadata| cfg!(not(unix)) || probe().is_ok_and(|probe| FileFacts::of(&probe).user == FileFacts::of(about).user);
    fs::symlink_metadata(path).is_ok_and(|about| about.is_dir() && is_own(&about))
}

/// Creates a folder for this user alone, with the folders above it as they are usually made; one that is there must be this user's.
fn make_own(folder: &Path, target: &Path) -> Result<()> {
    let refused = |source| Error::Write { path: target.to_owned(), source };
    fs::create_dir_all(parent(folder)).map_err(refused)?;
    #[cfg_attr(not(unix), expect(unused_mut, reason = "other systems have no mode"))]
    let mut builder = DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    match builder.create(folder) {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => match fs::symlink_metadata(folder) {
            // It was removed in this moment, and is made by the next try.
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
            _ if is_own_folder(folder) => Ok(()),
            _ => Err(foreign(folder, target)),
        },
        // The parent was removed in this moment, by the run that had made it.
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
        made => made.map_err(refused),
    }
}

/// Opens or creates a lock, through no link and without waiting for a pipe's other end.
fn open(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.read(true).write(true).create(true).truncate(false);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NOFOLLOW | libc::O_NONBLOCK);
    options.open(path)
}

/// The device and the number of a file, which stay when it is renamed.
pub fn identity(about: &Metadata) -> [u64; 2] {
    FileFacts::of(about).identity
}

/// What a system says of a file.
struct FileFacts {
    /// Its device and its number; its size and its time, which stay too, where a system does not say.
    identity: [u64; 2],
    /// The user that it belongs to.
    user: u64,
    /// How many names it has: under a second one it may be another user's or another program's; one that was just removed has none.
    names: u64,
}

impl FileFacts {
    #[cfg(unix)]
    fn of(about: &Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self { identity: [about.dev(), about.ino()], user: about.uid().into(), names: about.nlink() }
    }

    #[cfg(not(unix))]
    fn of(about: &Metadata) -> Self {
        let time = about.modified().ok().and_then(|time| time.duration_since(std::time::UNIX_EPOCH).ok());
        Self { identity: [about.len(), time.map_or(0, |time| time.as_nanos() as u64)], user: 0, names: 1 }
    }
}
