//! The one tokio runtime of the process, and waiting on it without the GIL.

use std::future::Future;
use std::io::{self, Read};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, mpsc};
use std::thread::ThreadId;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use tokio::runtime::{Builder, Handle, Runtime};

use vencejo_flight::rehearsal::IsWanted;

use crate::errors;

/// How long Python's signal handlers wait for their turn at most while something native is waited for.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(100);

/// The runtime: two threads are enough for links, drivers and timers; disks have their own.
///
/// A process that was forked off has none of its parent's threads and gets a runtime of its own; the parent's is left
/// as it is, for even dropping it would wait for them.
pub fn handle() -> &'static Handle {
    static RUNTIME: Mutex<Option<(u32, &'static Runtime)>> = Mutex::new(None);
    let process = process();
    let mut runtime = RUNTIME.lock().unwrap_or_else(PoisonError::into_inner);
    match *runtime {
        Some((owner, runtime)) if owner == process => runtime.handle(),
        _ => {
            let made = Builder::new_multi_thread()
                .worker_threads(2)
                .thread_name("vencejo")
                .enable_all()
                .build()
                .expect("invariant: the system can start two threads");
            let made: &'static Runtime = Box::leak(Box::new(made));
            *runtime = Some((process, made));
            made.handle()
        }
    }
}

/// How long the end of the interpreter waits for threads on their way back to Python.
const LONGEST_END: Duration = Duration::from_secs(2);

static IS_ENDING: AtomicBool = AtomicBool::new(false);
static ENDS_ON: OnceLock<ThreadId> = OnceLock::new();
/// Threads on their way back to Python: how many (low half), and of which process (high half). One that is forked off
/// has none of its parent's threads, whatever they were doing.
static RETURNING: AtomicU64 = AtomicU64::new(0);

/// How many threads of a process are on their way.
fn returning(process: u32) -> u32 {
    of_process(RETURNING.load(Ordering::SeqCst), process)
}

fn of_process(returning: u64, process: u32) -> u32 {
    if (returning >> 32) as u32 == process { returning as u32 } else { 0 }
}

fn count_returning(process: u32, change: impl Fn(u32) -> u32) {
    let counted = |before| Some(u64::from(process) << 32 | u64::from(change(of_process(before, process))));
    // It always has a next value.
    let _ = RETURNING.fetch_update(Ordering::SeqCst, Ordering::SeqCst, counted);
}

/// The interpreter is about to end: from now on only this thread comes back from native code. The others wait for the
/// process to end: once there is no interpreter, asking for it would end them in the middle of our frames, and with
/// them the process.
#[pyfunction]
pub fn end_waits(py: Python<'_>) {
    ENDS_ON.get_or_init(|| std::thread::current().id());
    IS_ENDING.store(true, Ordering::SeqCst);
    let process = process();
    py.detach(|| {
        let began = Instant::now();
        while returning(process) > 0 && began.elapsed() < LONGEST_END {
            std::thread::sleep(Duration::from_millis(1));
        }
    });
}

/// This process, as last asked: its number is a system call, which every return to Python would make.
static PROCESS: AtomicU32 = AtomicU32::new(0);

/// The id of this process.
fn process() -> u32 {
    match PROCESS.load(Ordering::Relaxed) {
        0 => {
            let process = std::process::id();
            PROCESS.store(process, Ordering::Relaxed);
            process
        }
        process => process,
    }
}

/// This process was forked off just now.
#[pyfunction]
pub fn forked() {
    PROCESS.store(std::process::id(), Ordering::Relaxed);
}

/// Keeps a native object for ever. In a process that was forked off the threads behind it are not there, so nothing of
/// it may run, not even its end.
#[pyfunction]
pub fn abandon(object: Py<PyAny>) {
    std::mem::forget(object);
}

/// While it lives, the interpreter of the process in which it began does not end.
struct Returning {
    process: u32,
}

impl Returning {
    /// Does not come back once the interpreter ends. To be called without the GIL.
    fn begin() -> Self {
        let process = process();
        loop {
            count_returning(process, |count| count + 1);
            let returning = Self { process };
            if !IS_ENDING.load(Ordering::SeqCst) || ENDS_ON.get() == Some(&std::thread::current().id()) {
                return returning;
            }
            drop(returning);
            std::thread::park();
        }
    }
}

impl Drop for Returning {
    fn drop(&mut self) {
        // A thread that forked in between is counted in its parent alone.
        if self.process == process() {
            count_returning(self.process, |count| count.saturating_sub(1));
        }
    }
}

/// Runs something native that may take long without the GIL.
pub fn detached<T: Send>(py: Python<'_>, run: impl FnOnce() -> T + Send) -> T {
    let (value, _returning) = py.detach(|| (run(), Returning::begin()));
    value
}

/// Runs something short in Python, from a thread of ours.
pub fn attached<T>(run: impl FnOnce(Python<'_>) -> T) -> T {
    let _returning = Returning::begin();
    Python::attach(run)
}

/// Runs something long on a thread of its own, and lets Ctrl-C in: its exception is raised at once. The thread then ends
/// when it next asks whether its value is wanted, or when it is done.
pub fn interruptible<T, F>(py: Python<'_>, run: F) -> PyResult<T>
where
    T: Send + 'static,
    F: FnOnce(IsWanted<'_>) -> T + Send + 'static,
{
    let is_wanted = Arc::new(AtomicBool::new(true));
    let (ended, mut end) = mpsc::channel();
    let still_wanted = is_wanted.clone();
    let running = std::thread::spawn(move || {
        // Nobody waits any more: the value is dropped here.
        let _ = ended.send(run(&|| still_wanted.load(Ordering::Relaxed)));
    });
    loop {
        let (waited, returned) = detached(py, || (end.recv_timeout(SIGNAL_INTERVAL), end));
        end = returned;
        match waited {
            Ok(value) => return Ok(value),
            Err(mpsc::RecvTimeoutError::Timeout) => py.check_signals().inspect_err(|_| {
                is_wanted.store(false, Ordering::Relaxed);
            })?,
            Err(mpsc::RecvTimeoutError::Disconnected) => {
                let Err(panic) = running.join() else { unreachable!("invariant: it sends before it ends") };
                std::panic::resume_unwind(panic);
            }
        }
    }
}

/// A source that cannot be read further once nobody waits for what is made of it.
pub struct WhileWanted<'a, R>(pub R, pub IsWanted<'a>);

impl<R: Read> Read for WhileWanted<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if (self.1)() { self.0.read(buffer) } else { Err(io::Error::other("no longer wanted")) }
    }
}

/// The process in which an object was made: in one that is forked off, the threads behind it are not there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Home(u32);

impl Home {
    /// This process.
    pub fn here() -> Self {
        Self(process())
    }

    /// # Errors
    /// `ClosedError` in another process.
    pub fn check(self, what: &str) -> PyResult<()> {
        if self == Self::here() {
            return Ok(());
        }
        let problem = format!("this {what} belongs to the process that was forked; make a new one in this one");
        Err(errors::raise("ClosedError", problem))
    }
}

/// Waits for something native without the GIL, and lets Ctrl-C in. `None` when `timeout` passes first.
pub fn wait<F, T>(py: Python<'_>, timeout: Option<Duration>, future: F) -> PyResult<Option<T>>
where
    F: Future<Output = T> + Send,
    T: Send,
{
    let deadline = timeout.and_then(|timeout| Instant::now().checked_add(timeout));
    let mut future = Box::pin(future);
    loop {
        let rest = deadline.map_or(SIGNAL_INTERVAL, |deadline| {
            deadline.saturating_duration_since(Instant::now()).min(SIGNAL_INTERVAL)
        });
        let slice = async { tokio::time::timeout(rest, future.as_mut()).await };
        if let Ok(value) = detached(py, || handle().block_on(slice)) {
            return Ok(Some(value));
        }
        py.check_signals()?;
        if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            return Ok(None);
        }
    }
}

/// A time limit from Python's seconds, of which infinitely many are allowed.
///
/// # Errors
/// `InvalidRequest` for NaN and negative ones.
pub fn timeout(timeout_s: f64) -> PyResult<Duration> {
    if timeout_s >= 0.0 {
        return Ok(Duration::try_from_secs_f64(timeout_s).unwrap_or(Duration::MAX));
    }
    Err(errors::raise("InvalidRequest", format!("timeout_s is {timeout_s}, should be 0 s or more")))
}
