//! Long work without the interpreter's lock, that Ctrl-C stops.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use willis::cli::words::said_of_step;
use willis::internals::sampling::PartialRun;
use willis::{Error, Follow, Progress, Step};

use crate::errors::raised;

/// Between two looks at Python's signals.
const POLL: Duration = Duration::from_millis(50);

/// What another thread may know of some work, and by which it may stop it.
#[pyclass(frozen, module = "willis._willis")]
#[derive(Debug, Default)]
pub struct Watch {
    /// Whether the last part is kept for those who ask later.
    keeps_last: bool,
    state: Mutex<WatchState>,
    /// Told of each part that is kept.
    arrived: Condvar,
}

#[derive(Debug, Default)]
struct WatchState {
    is_stopped: bool,
    /// Samples that are done, and all that there are to be.
    samples: (u64, u64),
    said: Vec<(String, String)>,
    /// Whether somebody waits for what is finished.
    is_wanted: bool,
    /// What was finished when somebody last waited or the work ended, and how long it took, s.
    part: Option<(PartialRun, f64)>,
    /// Whether that is the last part, after which nothing comes.
    is_last: bool,
    /// When sampling began.
    begun: Option<Instant>,
}

#[pymethods]
impl Watch {
    #[new]
    #[pyo3(signature = (keep=false))]
    fn new(keep: bool) -> Self {
        Self { keeps_last: keep, ..Self::default() }
    }

    /// Asks the work to stop.
    fn stop(&self) {
        self.state().is_stopped = true;
    }

    /// Samples that are done, and all that there are to be; 0 before sampling.
    fn samples(&self) -> (u64, u64) {
        self.state().samples
    }
}

impl Watch {
    fn state(&self) -> MutexGuard<'_, WatchState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The part of the work that is finished and how long it took, s, waiting for its next step if need be; `None` where none came within `patience`.
    pub fn part(&self, patience: Duration) -> Option<(PartialRun, f64)> {
        let mut state = self.state();
        state.is_wanted = !state.is_last;
        let waited = self.arrived.wait_timeout_while(state, patience, |state| state.is_wanted);
        waited.unwrap_or_else(PoisonError::into_inner).0.part.clone()
    }

    fn keep(&self, part: &PartialRun, is_last: bool) {
        let part = part.clone();
        let mut state = self.state();
        let seconds = state.begun.map_or(0.0, |begun| begun.elapsed().as_secs_f64());
        (state.part, state.is_wanted) = (Some((part, seconds)), false);
        state.is_last |= is_last;
        self.arrived.notify_all();
    }
}

/// The progress of some work, for the thread that watches.
pub struct Follower<'a>(&'a Watch);

impl Follower<'_> {
    /// Says facts under headings.
    pub fn say(&self, said: Vec<(String, String)>) {
        self.0.state().said.extend(said);
    }
}

impl Progress for Follower<'_> {
    fn report(&mut self, done: u64, total: u64) -> bool {
        let mut state = self.0.state();
        state.samples = (done, total);
        !state.is_stopped
    }

    fn finished(&mut self, part: &PartialRun) {
        if self.0.state().is_wanted {
            self.0.keep(part, false);
        }
    }
}

impl Follow for Follower<'_> {
    fn step(&mut self, step: Step<'_>) {
        let said = said_of_step(&step);
        let mut state = self.0.state();
        if matches!(step, Step::Sampling { .. }) {
            state.begun = Some(Instant::now());
        }
        state.said.extend(said);
    }

    fn sampled(&mut self, part: &PartialRun, _is_complete: bool) {
        if self.0.keeps_last {
            self.0.keep(part, true);
        }
    }
}

/// Threads where a call does not say how many; zero for those of rayon.
static THREADS: AtomicUsize = AtomicUsize::new(0);
/// By process and number of threads.
static POOLS: Mutex<BTreeMap<(u32, usize), Arc<ThreadPool>>> = Mutex::new(BTreeMap::new());
/// The process that the module was loaded in. A fork of it has none of its threads: whoever waits for them waits for ever.
static HOME: OnceLock<u32> = OnceLock::new();

/// Remembers the process.
pub fn remember_process() {
    HOME.get_or_init(std::process::id);
}

/// Threads of this process for some work; `None` where those of rayon are there and do.
fn own_pool(py: Python<'_>, threads: Option<usize>) -> PyResult<Option<Arc<ThreadPool>>> {
    let is_fork = HOME.get().is_some_and(|home| *home != std::process::id());
    let wanted = threads.or(Some(THREADS.load(Ordering::Relaxed)).filter(|threads| *threads > 0));
    let threads = wanted.or_else(|| is_fork.then(rayon::current_num_threads));
    threads.map(|threads| pool(py, threads)).transpose()
}

/// Does some work without the interpreter's lock, that is too short to be stopped.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    match own_pool(py, None) {
        Ok(Some(pool)) => py.detach(|| pool.install(work)),
        _ => py.detach(work),
    }
}

/// The same for work that may fail.
pub fn computed<T: Send>(py: Python<'_>, work: impl FnOnce() -> willis::Result<T> + Send) -> PyResult<T> {
    detached(py, work).map_err(|error| raised(py, &error))
}

/// So many threads from now on, where a call does not say otherwise.
#[pyfunction]
pub fn set_num_threads(py: Python<'_>, threads: usize) -> PyResult<()> {
    pool(py, threads)?;
    THREADS.store(threads, Ordering::Relaxed);
    Ok(())
}

fn pool(py: Python<'_>, threads: usize) -> PyResult<Arc<ThreadPool>> {
    if !(1..=4096).contains(&threads) {
        return Err(raised(py, &Error::parameter("threads", threads, "expected a number from 1 to 4096")));
    }
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let key = (std::process::id(), threads);
    if let Some(pool) = pools.get(&key) {
        return Ok(pool.clone());
    }
    let made = ThreadPoolBuilder::new().num_threads(threads).build();
    let made = Arc::new(made.map_err(|e| PyRuntimeError::new_err(format!("threads {threads}: {e}")))?);
    pools.insert(key, made.clone());
    Ok(made)
}

/// Does some work without the interpreter's lock. Meanwhile `progress` is called with the samples that are done and their total, and `say`
/// with what there is to say, a heading and a fact; an exception of either, or a signal, stops the work. The outer error is of those.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    watch: &Watch,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    say: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&mut Follower<'_>) -> willis::Result<T> + Send,
) -> PyResult<PyResult<T>> {
    let pool = own_pool(py, threads)?;
    // Nothing is sent: the channel closes when the work ends, also by a panic, so that nobody waits for ever.
    let (end, mut ended) = mpsc::channel::<()>();
    let (result, stopped_by) = std::thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let _end = end;
            let mut follower = Follower(watch);
            match &pool {
                Some(pool) => pool.install(|| work(&mut follower)),
                None => work(&mut follower),
            }
        });
        let mut stopped_by = None;
        loop {
            // A receiver cannot be shared between threads: it is lent to the wait.
            let ended = &mut ended;
            let is_finished = py.detach(move || ended.recv_timeout(POLL)) == Err(RecvTimeoutError::Disconnected);
            if stopped_by.is_none()
                && let Err(stop) = py.check_signals().and_then(|()| tell(watch, progress, say))
            {
                watch.stop();
                willis::cli::ask_to_stop();
                stopped_by = Some(stop);
            }
            if is_finished {
                break;
            }
        }
        (py.detach(|| worker.join()), stopped_by)
    });
    if let Some(stop) = stopped_by {
        return Err(stop);
    }
    let result = result.map_err(|_| PyRuntimeError::new_err("willis met a state that it does not know; please report it"))?;
    Ok(result.map_err(|error| raised(py, &error)))
}

fn tell(watch: &Watch, progress: Option<&Bound<'_, PyAny>>, say: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    let said = std::mem::take(&mut watch.state().said);
    for (heading, fact) in said {
        if let Some(say) = say {
            say.call1((heading, fact))?;
        }
    }
    match (progress, watch.samples()) {
        (Some(progress), samples @ (_, 1..)) => progress.call1(samples).map(drop),
        _ => Ok(()),
    }
}
