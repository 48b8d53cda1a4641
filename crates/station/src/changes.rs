//! Notifies blocking and asynchronous readers of changes, without queueing them.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;

#[derive(Debug, Default)]
struct State {
    count: u64,
    /// Blocked readers: waking costs a system call even when no thread sleeps.
    blocked: usize,
}

/// Counts changes; a reader waits for the count to move on.
#[derive(Debug, Default)]
pub struct Changes {
    state: Mutex<State>,
    blocking: Condvar,
    waiting: Notify,
}

impl Changes {
    /// Counts a change. Almost free while no reader waits.
    pub fn notify(&self) {
        let is_awaited = {
            let mut state = self.lock();
            state.count += 1;
            state.blocked > 0
        };
        if is_awaited {
            self.blocking.notify_all();
        }
        self.waiting.notify_waiters();
    }

    /// The changes so far.
    pub fn count(&self) -> u64 {
        self.lock().count
    }

    /// Blocks this thread until the count is no longer `seen`, and returns it; `None` after the time-out.
    pub fn wait_blocking(&self, seen: u64, timeout: Duration) -> Option<u64> {
        let mut state = self.lock();
        state.blocked += 1;
        let mut state = self
            .blocking
            .wait_timeout_while(state, timeout, |state| state.count == seen)
            .unwrap_or_else(PoisonError::into_inner)
            .0;
        state.blocked -= 1;
        (state.count != seen).then_some(state.count)
    }

    /// Waits until the count is no longer `seen`, and returns it.
    pub async fn wait(&self, seen: u64) -> u64 {
        loop {
            let mut notified = std::pin::pin!(self.waiting.notified());
            notified.as_mut().enable();
            let count = self.count();
            if count != seen {
                return count;
            }
            notified.await;
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[tokio::test]
    async fn a_waiter_sees_the_next_change() {
        let changes = Arc::new(Changes::default());
        let waiter = tokio::spawn({
            let changes = changes.clone();
            async move { changes.wait(0).await }
        });
        tokio::task::yield_now().await;
        changes.notify();
        assert_eq!(waiter.await.expect("waiter"), 1);
        assert_eq!(changes.wait_blocking(1, Duration::ZERO), None);
        assert_eq!(changes.wait_blocking(0, Duration::ZERO), Some(1));
    }
}
