//! File descriptors: the process's limit, and the share of it for connections.

use super::DoorLimits;

/// Reserved for what must never wait for a browser: links (64 and their clients), the recorder, databases, cameras.
const RESERVED: u64 = 128;
/// Largest limit requested. A higher one slows down programs that iterate over all descriptors, and connections do not
/// need it.
const WANTED: u64 = 4096;

/// The limit of open descriptors, and the number open at start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptors {
    /// Limit; `None` where the system has none or does not report it.
    pub limit: Option<u64>,
    /// Number of open descriptors.
    pub open: u64,
}

impl Descriptors {
    /// Raises the process's limit as far as is permitted, and returns it.
    pub fn raise() -> Self {
        Self { limit: raise_limit(), open: open_now() }
    }

    /// Connection limits that leave enough descriptors for everything else.
    pub fn door(self) -> DoorLimits {
        let Some(limit) = self.limit else { return DoorLimits::of(usize::MAX) };
        let left = limit.saturating_sub(RESERVED.max(self.open + RESERVED / 2));
        // An answer may hold a file open in addition to its connection.
        let limits = DoorLimits::of(usize::try_from(left * 3 / 4).unwrap_or(usize::MAX));
        if left < RESERVED {
            tracing::warn!(
                descriptors = limit,
                connections = limits.connections,
                "the limit of open files is low, so few connections are accepted; raise it with `ulimit -n 1024` before the start"
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
            tracing::debug!(%error, "the limit of open files cannot be raised");
        }
    }
    getrlimit(Resource::Nofile).current
}

#[cfg(not(unix))]
fn raise_limit() -> Option<u64> {
    None
}

/// Number of open descriptors, on Linux only. Elsewhere the reserve has to suffice.
fn open_now() -> u64 {
    std::fs::read_dir("/proc/self/fd").map_or(0, |entries| entries.count() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connections_leave_enough_for_links_and_recorder() {
        let connections = |limit, open| Descriptors { limit, open }.door().connections;
        assert_eq!(connections(None, 20), 512);
        assert_eq!(connections(Some(4096), 20), 512);
        assert_eq!(connections(Some(1024), 20), 512, "the usual limit");
        assert_eq!(connections(Some(256), 20), 96);
        assert_eq!(connections(Some(256), 150), 31, "what is open already counts");
        assert_eq!(connections(Some(100), 20), 16, "some always");
        for limit in [200, 256, 400, 700, 1024] {
            assert!(limit - connections(Some(limit), 20) as u64 >= RESERVED, "{limit}");
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
