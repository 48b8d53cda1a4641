//! Time limit of parsers: no input may block them.

use rustix::time::{ClockId, clock_gettime};

/// Milliseconds of CPU time for one input of up to 64 KiB: row 53 of tests/faults. The counters and checks of a fuzz
/// program are included.
const MOST_MS: i64 = 100;

/// Runs `work`, and fails when it exceeds the limit three times in a row, since machines are sometimes slow.
pub fn quick<T>(work: impl Fn() -> T) -> T {
    let mut took = 0;
    for _ in 0..3 {
        let before = spent_ms();
        let done = work();
        took = spent_ms() - before;
        if took <= MOST_MS {
            return done;
        }
    }
    panic!("it takes {took} ms");
}

/// CPU time of this thread, which does not depend on the machine's load.
fn spent_ms() -> i64 {
    let spent = clock_gettime(ClockId::ThreadCPUTime);
    spent.tv_sec * 1000 + spent.tv_nsec / 1_000_000
}
