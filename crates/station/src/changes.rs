//! Tells blocking and asynchronous readers that something new has arrived, without keeping it for them.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;

/// Counts changes; a reader waits for the count to move on.
#[derive(Debug, Default)]
pub struct Changes {
    count: Mutex<u64>,
    blocking: Condvar,
    waiting: Notify,
}

impl Changes {
    /// Something changed. Costs next to nothing while nobody waits.
    pub fn notify(&self) {
        *self.count.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.blocking.notify_all();
        self.waiting.notify_waiters();
    }

    /// The changes so far.
    pub fn count(&self) -> u64 {
        *self.count.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits on this thread until the count is no longer `seen`, and gives it back; `None` when it stays so.
    pub fn wait_blocking(&self, seen: u64, timeout: Duration) -> Option<u64> {
        let count = self.count.lock().unwrap_or_else(PoisonError::into_inner);
        let count = self
            .blocking
            .wait_timeout_while(count, timeout, |count| *count == seen)
            .unwrap_or_else(PoisonError::into_inner)
            .0;
        (*count != seen).then_some(*count)
    }

    /// Waits until the count is no longer `seen`, and gives it back.
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
