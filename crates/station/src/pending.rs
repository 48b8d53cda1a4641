//! An operation under way: its progress, its end, and how to give it up.

use std::sync::Arc;

use tokio::sync::watch;

/// How far an operation has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Progress {
    /// Counts the reports, so that a reader knows whether it has seen this one.
    pub report: u64,
    /// Amount done, in units of `total`.
    pub done: u32,
    /// Total amount; 0 when not known yet.
    pub total: u32,
}

#[derive(Debug, Clone)]
struct State<T> {
    progress: Progress,
    end: Option<T>,
}

/// The end that an operation's owner holds.
#[derive(Debug)]
pub(crate) struct Finisher<T>(watch::Sender<State<T>>);

impl<T> Finisher<T> {
    /// Reports progress.
    pub(crate) fn progress(&self, done: u32, total: u32) {
        self.0.send_modify(|state| {
            state.progress = Progress { report: state.progress.report + 1, done, total };
        });
    }

    /// Ends the operation.
    pub(crate) fn finish(self, end: T) {
        self.0.send_modify(|state| state.end = Some(end));
    }

    /// Whether no caller waits for the operation any more.
    pub(crate) fn is_abandoned(&self) -> bool {
        self.0.receiver_count() == 0
    }
}

type Cancel = Arc<dyn Fn() + Send + Sync>;

/// An operation under way. It goes on when this handle is dropped; [`Pending::cancel`] ends it.
pub struct Pending<T> {
    receiver: watch::Receiver<State<T>>,
    cancel: Cancel,
}

impl<T> Clone for Pending<T> {
    fn clone(&self) -> Self {
        Self { receiver: self.receiver.clone(), cancel: self.cancel.clone() }
    }
}

impl<T> std::fmt::Debug for Pending<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pending").field("progress", &self.receiver.borrow().progress).finish_non_exhaustive()
    }
}

impl<T: Clone> Pending<T> {
    /// Both ends of an operation; `cancel` is called when its caller gives it up.
    pub(crate) fn new(cancel: impl Fn() + Send + Sync + 'static) -> (Finisher<T>, Self) {
        let (sender, receiver) = watch::channel(State { progress: Progress::default(), end: None });
        (Finisher(sender), Self { receiver, cancel: Arc::new(cancel) })
    }

    /// An operation that has ended already.
    pub(crate) fn ended(end: T) -> Self {
        let (finisher, pending) = Self::new(|| {});
        finisher.finish(end);
        pending
    }

    /// The newest report.
    pub fn progress(&self) -> Progress {
        self.receiver.borrow().progress
    }

    /// Its result; `None` while it runs.
    pub fn end(&self) -> Option<T> {
        self.receiver.borrow().end.clone()
    }

    /// Waits for the result; `None` when its owner is gone without one.
    pub async fn wait(&self) -> Option<T> {
        let mut receiver = self.receiver.clone();
        let state = receiver.wait_for(|state| state.end.is_some()).await.ok()?;
        state.end.clone()
    }

    /// Waits for a report other than `seen`; `None` once it has ended.
    pub async fn next_progress(&self, seen: u64) -> Option<Progress> {
        let mut receiver = self.receiver.clone();
        let state = receiver.wait_for(|state| state.end.is_some() || state.progress.report != seen).await.ok()?;
        state.end.is_none().then_some(state.progress)
    }

    /// Gives the operation up. It still ends, with an error that says so. One that has ended already is left alone:
    /// what its owner knew it by may belong to another one by now.
    pub fn cancel(&self) {
        if self.receiver.borrow().end.is_none() {
            (self.cancel)();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    #[tokio::test]
    async fn progress_then_the_end() {
        let (finisher, pending) = Pending::<u8>::new(|| {});
        finisher.progress(1, 4);
        assert_eq!(pending.next_progress(0).await, Some(Progress { report: 1, done: 1, total: 4 }));
        finisher.finish(7);
        assert_eq!(pending.next_progress(1).await, None);
        assert_eq!((pending.wait().await, pending.end()), (Some(7), Some(7)));
    }

    #[tokio::test]
    async fn an_owner_that_goes_away_ends_the_wait() {
        let (finisher, pending) = Pending::<u8>::new(|| {});
        drop(finisher);
        assert_eq!(pending.wait().await, None);
    }

    #[test]
    fn cancelling_reaches_the_owner() {
        let count = Arc::new(AtomicU32::new(0));
        let (finisher, pending) = Pending::<u8>::new({
            let count = count.clone();
            move || {
                count.fetch_add(1, Ordering::SeqCst);
            }
        });
        pending.cancel();
        assert_eq!(count.load(Ordering::SeqCst), 1);
        assert!(!finisher.is_abandoned());
        finisher.finish(1);
        pending.cancel();
        assert_eq!(count.load(Ordering::SeqCst), 1, "it has ended");
    }

    #[test]
    fn an_operation_that_nobody_waits_for_is_known() {
        let (finisher, pending) = Pending::<u8>::new(|| {});
        drop(pending.clone());
        assert!(!finisher.is_abandoned());
        drop(pending);
        assert!(finisher.is_abandoned());
    }
}
