//! The one tokio runtime of the process, and waiting on it without the GIL.

use std::future::Future;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use tokio::runtime::{Builder, Handle, Runtime};

/// How long Python's signal handlers wait for their turn at most while something native is waited for.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(100);

/// The runtime: two threads are enough for links, drivers and timers; disks have their own.
pub fn handle() -> &'static Handle {
    static RUNTIME: OnceLock<Runtime> = OnceLock::new();
    RUNTIME
        .get_or_init(|| {
            Builder::new_multi_thread()
                .worker_threads(2)
                .thread_name("vencejo")
                .enable_all()
                .build()
                .expect("invariant: the system can start two threads")
        })
        .handle()
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
        if let Ok(value) = py.detach(|| handle().block_on(slice)) {
            return Ok(Some(value));
        }
        py.check_signals()?;
        if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            return Ok(None);
        }
    }
}

/// A duration from Python's seconds; negative ones and NaN count as zero.
pub fn seconds(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds.max(0.0)).unwrap_or(Duration::MAX)
}
