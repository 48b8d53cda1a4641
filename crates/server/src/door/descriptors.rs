//! File descriptors: how many this process may have, and how many of them are for connections.

use super::DoorLimits;

/// Kept for what must never wait for a browser: links (64 and their clients), the recorder, databases, cameras.
const RESERVED: u64 = 128;
/// Asked for at most. More costs those dear that go through all numbers, and no connection needs it.
const WANTED: u64 = 4096;

/// How many descriptors there are, and how many were open when we looked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptors {
    /// How many there may be; `None` where the system has no limit, or tells none.
    pub limit: Option<u64>,
    /// How many are open.
    pub open: u64,
}

impl Descriptors {
    /// Raises the process's limit as far as it may go by itself, and looks at it.
    pub fn raise() -> Self {
        Self { limit: raise_limit(), open: open_now() }
    }

    /// The limits for connections that leave enough for all else.
    pub fn door(self) -> DoorLimits {
        let Some(limit) = self.limit else { return DoorLimits::of(usize::MAX) };
        let left = limit.saturating_sub(RESERVED.max(self.open + RESERVED / 2));
        // An answer may hold a file open beside its connection.
        let limits = DoorLimits::of(usize::try_from(left * 3 / 4).unwrap_or(usize::MAX));
        if left < RESERVED {
            tracing::warn!(
                descriptors = limit,
                connections = limits.places,
                "this process may open few files, so it takes few connections; `ulimit -n 1024` before the start gives it more"
            );
        }
        limits
    }
}

#[cfg(unix)]
fn raise_limit() -> Option<u64> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let wanted = maximum.unwrap_or(WANTED).min(WANTED);
    if current.is_some_and(|current| current < wanted) {
        let raised = Rlimit { current: Some(wanted), maximum };
        if let Err(error) = setrlimit(Resource::Nofile, raised) {
            tracing::debug!(%error, "the limit of open files stays as it is");
        }
    }
    getrlimit(Resource::Nofile).current
}

#[cfg(not(unix))]
fn raise_limit() -> Option<u64> {
    None
}

/// Descriptors that are open: what Linux lists. Elsewhere the reserve has to do.
fn open_now() -> u64 {
    std::fs::read_dir("/proc/self/fd").map_or(0, |entries| entries.count() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connections_leave_enough_for_links_and_recorder() {
        let places = |limit, open| Descriptors { limit, open }.door().places;
        assert_eq!(places(None, 20), 512);
        assert_eq!(places(Some(4096), 20), 512);
        assert_eq!(places(Some(1024), 20), 512, "the usual limit");
        assert_eq!(places(Some(256), 20), 96);
        assert_eq!(places(Some(256), 150), 31, "what is open already counts");
        assert_eq!(places(Some(100), 20), 16, "some always");
        for limit in [200, 256, 400, 700, 1024] {
            assert!(limit - places(Some(limit), 20) as u64 >= RESERVED, "{limit}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn the_limit_is_raised_to_what_may_be() {
        use rustix::process::{Resource, getrlimit};
        let limit = Descriptors::raise().limit.expect("Linux and macOS have one");
        let maximum = getrlimit(Resource::Nofile).maximum.unwrap_or(u64::MAX);
        assert!(limit >= maximum.min(WANTED), "{limit} of {maximum}");
    }
}
