//! Ctrl-C and its kin: the first asks to stop at the next place where nothing is lost; one more than a command wants ends it at once.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Mutex, Once, PoisonError};
use std::time::{Duration, Instant};

/// How often a signal has come.
static STOPS: AtomicU8 = AtomicU8::new(0);
/// How many signals the command acts on by itself.
static WANTED: AtomicU8 = AtomicU8::new(1);
static HANDLER: Once = Once::new();
/// Whether the command runs inside of another program.
static INSIDE: AtomicBool = AtomicBool::new(false);

/// The same signal again within this time is the same request: `timeout` sends its signal to the process and to its group, and so do
/// terminals and the programs that run in them.
const ECHO: Duration = Duration::from_millis(250);

/// From now on so many signals, at least one, only ask to stop. The next one ends the process as if nobody listened.
pub fn listen(wanted: u8) {
    if INSIDE.load(Ordering::Relaxed) {
        return;
    }
    WANTED.fetch_max(wanted, Ordering::Relaxed);
    HANDLER.call_once(|| {
        // Without a handler a signal ends the process at once, which leaves no output either.
        let _ = hear();
        crate::internals::output::give_up_when(|| stops() >= WANTED.load(Ordering::Relaxed));
    });
}

/// From now on a file that grows beyond the limit of the shell (`ulimit -f`) is an error of writing, not the end of the process.
pub fn outlive_limits() {
    #[cfg(unix)]
    {
        // Without it the process ends at once, and leaves no output either.
        let _ = signal_hook::flag::register(libc::SIGXFSZ, std::sync::Arc::default());
    }
}

/// From now on signals are the business of the program around this one; what an earlier command was asked is forgotten.
pub fn stay_inside() {
    INSIDE.store(true, Ordering::Relaxed);
    STOPS.store(0, Ordering::Relaxed);
}

/// Asks the command that is at work to stop, as Ctrl-C does.
pub fn ask_to_stop() {
    // The second time even a command that would rather finish stops.
    count_stop();
    count_stop();
}

/// Whether a signal has come.
pub fn is_stopped() -> bool {
    stops() > 0
}

/// How many signals have come.
pub fn stops() -> u8 {
    STOPS.load(Ordering::Relaxed)
}

/// Counts a signal; whether the command has been asked once more than it acts on.
fn count_stop() -> bool {
    let before = STOPS.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| Some(n.saturating_add(1))).unwrap_or(u8::MAX);
    before >= WANTED.load(Ordering::Relaxed)
}

/// Whether a signal that comes now is one of its own, and not an echo of the last.
fn is_new(signal: i32) -> bool {
    static LAST: Mutex<Option<(i32, Instant)>> = Mutex::new(None);
    let (mut last, now) = (LAST.lock().unwrap_or_else(PoisonError::into_inner), Instant::now());
    let echo = last.is_some_and(|(last, when)| last == signal && now.duration_since(when) < ECHO);
    if !echo {
        *last = Some((signal, now));
    }
    !echo
}

/// Listens to SIGINT, SIGTERM and SIGHUP, but to none that was ignored when the program began: `nohup`, and what a script runs in the
/// background, stay as they are.
#[cfg(unix)]
fn hear() -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = ignored();
    let heeded = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| (ignored >> (signal - 1)) & 1 == 0);
    let mut signals = signal_hook::iterator::Signals::new(heeded)?;
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        for signal in signals.forever() {
            if is_new(signal) && count_stop() {
                // The command may hang where it cannot be asked.
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            }
        }
    })?;
    Ok(())
}

/// The signals that are ignored, a bit each. Linux tells them; elsewhere none is known to be, and a run under `nohup` stops at SIGHUP.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

#[cfg(not(unix))]
fn hear() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || {
        if is_new(0) && count_stop() {
            // As a shell has it after Ctrl-C.
            std::process::exit(130);
        }
    })
}
