//! A bounded queue that drops its oldest entry when its reader is too slow: telemetry may be lost, flight may not wait.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::Notify;
use vencejo_link::Pace;

/// The result of a wait.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Taken<T> {
    /// The oldest entry.
    Item(T),
    /// Nothing came in time.
    TimedOut,
    /// The queue is closed and empty.
    Closed,
}

#[derive(Debug)]
struct State<T> {
    items: VecDeque<T>,
    dropped: u64,
    is_closed: bool,
    /// Blocked readers: waking costs a system call even when no thread sleeps.
    blocked: usize,
    /// One of them was woken and has not run yet: no further wake-up is needed.
    is_woken: bool,
}

impl<T> State<T> {
    /// Whether a blocked reader has to be woken for an entry in the queue.
    fn wakes(&mut self) -> bool {
        let wakes = self.blocked > 0 && !self.is_woken && !self.items.is_empty();
        self.is_woken |= wakes;
        wakes
    }
}

/// A queue of at most `capacity` entries between the link's task and one reader, blocking or asynchronous.
#[derive(Debug)]
pub struct DropOldest<T> {
    capacity: usize,
    state: Mutex<State<T>>,
    blocking: Condvar,
    waiting: Notify,
}

impl<T> DropOldest<T> {
    /// An empty queue. A capacity of 0 counts as 1.
    pub fn new(capacity: usize) -> Self {
        Self {
            capacity: capacity.max(1),
            state: Mutex::new(State {
                items: VecDeque::new(),
                dropped: 0,
                is_closed: false,
                blocked: 0,
                is_woken: false,
            }),
            blocking: Condvar::new(),
            waiting: Notify::new(),
        }
    }

    /// A queue that is closed and empty.
    pub(crate) fn ended() -> Arc<Self> {
        let queue = Self::new(1);
        queue.close();
        Arc::new(queue)
    }

    /// Adds an entry; never blocks. When full, the oldest entry is dropped and counted.
    pub fn push(&self, item: T) {
        let mut state = self.lock();
        if state.is_closed {
            return;
        }
        if state.items.len() == self.capacity {
            state.items.pop_front();
            state.dropped += 1;
        }
        state.items.push_back(item);
        let wakes = state.wakes();
        drop(state);
        if wakes {
            self.blocking.notify_one();
        }
        self.waiting.notify_one();
    }

    /// Takes the oldest entry if there is one; never waits.
    pub fn take_ready(&self) -> Taken<T> {
        Self::first(&mut self.lock())
    }

    /// Takes the oldest entry, waiting for one on this thread. `None` waits for ever.
    pub fn take_blocking(&self, timeout: Option<Duration>) -> Taken<T> {
        let mut state = self.lock();
        state.blocked += 1;
        let is_idle = |state: &mut State<T>| state.items.is_empty() && !state.is_closed;
        let mut state = match timeout {
            None => self.blocking.wait_while(state, is_idle).unwrap_or_else(PoisonError::into_inner),
            Some(timeout) => {
                self.blocking.wait_timeout_while(state, timeout, is_idle).unwrap_or_else(PoisonError::into_inner).0
            }
        };
        (state.blocked, state.is_woken) = (state.blocked - 1, false);
        let first = Self::first(&mut state);
        // An entry that came meanwhile is for another reader.
        let wakes = state.wakes();
        drop(state);
        if wakes {
            self.blocking.notify_one();
        }
        first
    }

    /// As [`Self::take_blocking`] without a time-out, by a reader that found nothing and may be a little late.
    pub fn take_paced(&self, pace: &mut Pace) -> Taken<T> {
        if let Some(pause) = pace.pause(Instant::now()) {
            std::thread::sleep(pause);
        }
        self.take_blocking(None)
    }

    fn first(state: &mut State<T>) -> Taken<T> {
        match state.items.pop_front() {
            Some(item) => Taken::Item(item),
            None if state.is_closed => Taken::Closed,
            None => Taken::TimedOut,
        }
    }

    /// Takes the oldest entry, waiting for one; `None` once the queue is closed and empty.
    pub async fn take(&self) -> Option<T> {
        loop {
            let notified = self.waiting.notified();
            {
                let mut state = self.lock();
                if let Some(item) = state.items.pop_front() {
                    return Some(item);
                }
                if state.is_closed {
                    return None;
                }
            }
            notified.await;
        }
    }

    /// Entries dropped so far because the reader was too slow.
    pub fn dropped(&self) -> u64 {
        self.lock().dropped
    }

    /// Ends the queue: entries in it can still be taken, none are added.
    pub fn close(&self) {
        self.lock().is_closed = true;
        self.blocking.notify_all();
        // A waiter that comes later sees the flag; one that waits now is woken.
        self.waiting.notify_one();
        self.waiting.notify_waiters();
    }

    /// Whether [`Self::close`] was called.
    pub fn is_closed(&self) -> bool {
        self.lock().is_closed
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_goes_when_the_reader_is_slow() {
        let queue = DropOldest::new(3);
        for item in 0..5 {
            queue.push(item);
        }
        let taken: Vec<_> = (0..4).map(|_| queue.take_blocking(Some(Duration::ZERO))).collect();
        assert_eq!(taken, [Taken::Item(2), Taken::Item(3), Taken::Item(4), Taken::TimedOut]);
        assert_eq!(queue.dropped(), 2);
    }

    #[test]
    fn a_closed_queue_gives_what_it_has_and_ends() {
        let queue = DropOldest::new(2);
        queue.push('a');
        queue.close();
        queue.push('b');
        assert_eq!(queue.take_blocking(None), Taken::Item('a'));
        assert_eq!(queue.take_blocking(None), Taken::Closed);
    }

    #[test]
    fn a_blocked_reader_is_woken_by_an_entry_and_by_the_end() {
        let queue = Arc::new(DropOldest::new(2));
        let reader = std::thread::spawn({
            let queue = queue.clone();
            move || (queue.take_blocking(None), queue.take_blocking(None))
        });
        queue.push(1);
        queue.close();
        assert_eq!(reader.join().expect("reader"), (Taken::Item(1), Taken::Closed));
    }

    #[test]
    fn no_entry_is_lost_between_a_reader_that_falls_asleep_and_a_writer() {
        let queue = Arc::new(DropOldest::new(100_000));
        let readers: Vec<_> = (0..2)
            .map(|_| {
                let queue = queue.clone();
                std::thread::spawn(move || {
                    let mut taken = Vec::new();
                    while let Taken::Item(item) = queue.take_blocking(None) {
                        taken.push(item);
                    }
                    taken
                })
            })
            .collect();
        for item in 0..20_000 {
            queue.push(item);
        }
        queue.close();
        let taken: Vec<Vec<i32>> = readers.into_iter().map(|reader| reader.join().expect("reader")).collect();
        assert!(taken.iter().all(|of_one| of_one.is_sorted()));
        assert_eq!(taken.iter().map(Vec::len).sum::<usize>(), 20_000);
    }

    #[test]
    fn what_comes_in_a_pause_is_all_there_after_it() {
        let queue = DropOldest::new(8);
        let mut pace = Pace::new(Duration::from_millis(1));
        let start = Instant::now();
        // As though thousands had come.
        for n in 1..=40 {
            pace.on_taken();
            pace.pause(start + Duration::from_micros(n));
        }
        pace.on_taken();
        queue.push(1);
        queue.push(2);
        assert_eq!((queue.take_paced(&mut pace), queue.take_paced(&mut pace)), (Taken::Item(1), Taken::Item(2)));
        queue.close();
        assert_eq!(queue.take_paced(&mut pace), Taken::Closed);
    }

    #[tokio::test]
    async fn an_asynchronous_reader_sees_everything_and_the_end() {
        let queue = Arc::new(DropOldest::new(100));
        let reader = tokio::spawn({
            let queue = queue.clone();
            async move {
                let mut seen = Vec::new();
                while let Some(item) = queue.take().await {
                    seen.push(item);
                }
                seen
            }
        });
        for item in 0..50 {
            queue.push(item);
            tokio::task::yield_now().await;
        }
        queue.close();
        assert_eq!(reader.await.expect("reader"), (0..50).collect::<Vec<_>>());
    }
}
