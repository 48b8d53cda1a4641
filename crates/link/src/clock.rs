//! Owns the clock of links, hub and recorder; injected, so that tests control time.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use vencejo_proto::MonoTime;

/// Monotonic time for everything that measures or waits, wall time only for names and time stamps of recordings.
pub trait Clock: Send + Sync + 'static {
    /// The moment on the monotonic clock.
    fn now(&self) -> MonoTime;

    /// Microseconds since the UNIX epoch, UTC. May jump.
    fn unix_us(&self) -> u64;
}

/// The time of a new [`SystemClock`]. A remote vehicle and a recording tell values from before it began, whose age must
/// be right.
const BEGINS_AT: Duration = Duration::from_secs(24 * 3600);

/// The machine's clocks. Monotonic time begins at one day and follows tokio's clock, paused or not.
#[derive(Debug, Clone, Copy)]
pub struct SystemClock {
    began: tokio::time::Instant,
}

impl SystemClock {
    /// A clock that begins now.
    pub fn new() -> Self {
        Self { began: tokio::time::Instant::now() }
    }
}

impl Default for SystemClock {
    fn default() -> Self {
        Self::new()
    }
}

impl Clock for SystemClock {
    fn now(&self) -> MonoTime {
        MonoTime::from_origin(BEGINS_AT + self.began.elapsed())
    }

    fn unix_us(&self) -> u64 {
        SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |since| u64::try_from(since.as_micros()).unwrap_or(u64::MAX))
    }
}

#[cfg(test)]
pub(crate) mod testing {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::{Clock, MonoTime};

    /// A clock that stands still until it is moved. Wall time starts on 2026-11-21 at 08:00:00 UTC.
    #[derive(Debug, Default)]
    pub(crate) struct ManualClock {
        us: AtomicU64,
    }

    pub(crate) const WALL_START_US: u64 = 1_795_248_000_000_000;

    impl ManualClock {
        pub(crate) fn advance_ms(&self, ms: u64) {
            self.us.fetch_add(ms * 1000, Ordering::SeqCst);
        }
    }

    impl Clock for ManualClock {
        fn now(&self) -> MonoTime {
            MonoTime::from_micros(self.us.load(Ordering::SeqCst))
        }

        fn unix_us(&self) -> u64 {
            WALL_START_US + self.us.load(Ordering::SeqCst)
        }
    }
}
