//! Memory for decoding untrusted files. A decoder asks before it allocates, so that the size a file announces is
//! refused or waits for its turn, whatever is decoded at the same time; unpacked pieces are cached on one shelf and
//! shown tiles on another, whose sizes do not grow with the files.
//!
//! An allocation that fails ends the process and nothing can catch it. Hence no decoder is given a size that was not
//! asked for here ([ADR 0013](../../../docs/adr/0013-limits-for-what-rust-decodes-a-child-for-what-it-does-not.md)).

use std::any::Any;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Bytes that all decoders together may hold while they work.
pub const MAX_READING: u64 = 256 * 1024 * 1024;
/// Bytes of unpacked pictures, pieces and heights that are kept.
const MAX_KEPT: usize = 192 * 1024 * 1024;
/// Bytes of tiles that are kept as they were shown.
const MAX_SHOWN: usize = 64 * 1024 * 1024;
/// How long a decoder waits for others to be done.
const WAIT: Duration = Duration::from_secs(20);

static READING: Budget = Budget::new(MAX_READING);
static UNPACKED: LazyLock<Shelf> = LazyLock::new(|| Shelf::new(MAX_KEPT));
static SHOWN: LazyLock<Shelf> = LazyLock::new(|| Shelf::new(MAX_SHOWN));

/// Bytes that may be held at once.
struct Budget {
    most: u64,
    used: Mutex<u64>,
    freed: Condvar,
}

impl Budget {
    const fn new(most: u64) -> Self {
        Self { most, used: Mutex::new(0), freed: Condvar::new() }
    }

    fn lease(&'static self, bytes: u64, patience: Duration) -> Result<Lease, String> {
        if bytes > self.most {
            let (needed, most) = (bytes.div_ceil(1_000_000), self.most / 1_000_000);
            return Err(format!("reading it takes {needed} MB of memory, and at most {most} MB are used for that"));
        }
        let used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        let is_full = |used: &mut u64| *used > self.most - bytes;
        let (mut used, waited) =
            self.freed.wait_timeout_while(used, patience, is_full).unwrap_or_else(PoisonError::into_inner);
        if waited.timed_out() {
            return Err("too much else is being read; try it again".to_owned());
        }
        *used += bytes;
        Ok(Lease { budget: self, bytes })
    }
}

/// Memory that a decoder may use until this is dropped.
#[must_use]
pub(crate) struct Lease {
    budget: &'static Budget,
    bytes: u64,
}

impl Lease {
    /// Releases what is beyond `bytes`.
    pub(crate) fn shrink(&mut self, bytes: u64) {
        let less = self.bytes.min(bytes);
        drop(Self { budget: self.budget, bytes: self.bytes - less });
        self.bytes = less;
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        let mut used = self.budget.used.lock().unwrap_or_else(PoisonError::into_inner);
        *used = used.saturating_sub(self.bytes);
        drop(used);
        self.budget.freed.notify_all();
    }
}

/// Leases memory for decoding; waits for its turn. `None`: a size that overflows. The holder of a lease must not
/// request another one.
///
/// # Errors
/// Why it is refused, as a sentence.
pub(crate) fn lease(bytes: Option<u64>) -> Result<Lease, String> {
    READING.lease(bytes.unwrap_or(u64::MAX), WAIT)
}

/// Key of a piece on the shelf: its owner, and two numbers of the owner's choice.
type Key = (u64, u64, u64);

#[derive(Default)]
struct Inner {
    pieces: HashMap<Key, (u64, Arc<dyn Any + Send + Sync>, usize)>,
    /// By when they were used last.
    ages: BTreeMap<u64, Key>,
    uses: u64,
    bytes: usize,
}

impl Inner {
    fn forget(&mut self, key: Key) {
        if let Some((used, _, bytes)) = self.pieces.remove(&key) {
            self.ages.remove(&used);
            self.bytes -= bytes;
        }
    }
}

/// Recently used pieces of all owners.
struct Shelf {
    most: usize,
    kept: Mutex<Inner>,
}

impl Shelf {
    fn new(most: usize) -> Self {
        Self { most, kept: Mutex::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn get(&self, key: Key) -> Option<Arc<dyn Any + Send + Sync>> {
        let mut kept = self.lock();
        kept.uses += 1;
        let now = kept.uses;
        let (used, piece, _) = kept.pieces.get_mut(&key)?;
        let (before, piece) = (std::mem::replace(used, now), piece.clone());
        kept.ages.remove(&before);
        kept.ages.insert(now, key);
        Some(piece)
    }

    /// Keeps a piece; whether there was room. Pieces in use are not evicted: their memory would not be freed.
    fn put(&self, key: Key, piece: Arc<dyn Any + Send + Sync>, bytes: usize) -> bool {
        let mut kept = self.lock();
        kept.forget(key);
        let mut over = kept.bytes.saturating_add(bytes).saturating_sub(self.most);
        let mut gone = Vec::new();
        for oldest in kept.ages.values() {
            if over == 0 {
                break;
            }
            if let Some((_, piece, bytes)) = kept.pieces.get(oldest)
                && Arc::strong_count(piece) == 1
            {
                over = over.saturating_sub(*bytes);
                gone.push(*oldest);
            }
        }
        if over > 0 {
            return false;
        }
        for key in gone {
            kept.forget(key);
        }
        kept.uses += 1;
        let now = kept.uses;
        kept.pieces.insert(key, (now, piece, bytes));
        kept.ages.insert(now, key);
        kept.bytes += bytes;
        true
    }

    fn forget(&self, owner: u64) {
        let mut kept = self.lock();
        let gone: Vec<Key> = kept.pieces.keys().filter(|(of, ..)| *of == owner).copied().collect();
        for key in gone {
            kept.forget(key);
        }
    }
}

/// One owner's part of a shelf; what it put there goes with it.
pub(crate) struct Shelved {
    shelf: &'static LazyLock<Shelf>,
    owner: u64,
}

impl std::fmt::Debug for Shelved {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shelved").field("owner", &self.owner).finish_non_exhaustive()
    }
}

impl Shelved {
    fn on(shelf: &'static LazyLock<Shelf>) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        Self { shelf, owner: COUNT.fetch_add(1, Ordering::Relaxed) }
    }

    /// Of what a file holds packed.
    pub(crate) fn unpacked() -> Self {
        Self::on(&UNPACKED)
    }

    /// Of tiles as they were shown.
    pub(crate) fn tiles() -> Self {
        Self::on(&SHOWN)
    }

    /// A piece that was put there lately.
    pub(crate) fn get<T: Send + Sync + 'static>(&self, a: u64, b: u64) -> Option<Arc<T>> {
        self.shelf.get((self.owner, a, b))?.downcast().ok()
    }

    /// Caches a piece of `bytes`, evicting the least recently used, unreferenced ones of all owners; returns whether it
    /// fitted.
    pub(crate) fn put<T: Send + Sync + 'static>(&self, a: u64, b: u64, piece: &Arc<T>, bytes: usize) -> bool {
        // The overhead beside the piece.
        self.shelf.put((self.owner, a, b), piece.clone(), bytes.saturating_add(128))
    }

    /// Forgets a piece.
    pub(crate) fn forget(&self, a: u64, b: u64) {
        self.shelf.lock().forget((self.owner, a, b));
    }

    /// Forgets all of its pieces.
    pub(crate) fn clear(&self) {
        self.shelf.forget(self.owner);
    }
}

impl Drop for Shelved {
    fn drop(&mut self) {
        self.clear();
    }
}

/// When work that a file demands has taken too long.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deadline(Instant);

impl Deadline {
    /// So long from now.
    pub(crate) fn after(patience: Duration) -> Self {
        Self(Instant::now() + patience)
    }

    /// Whether it is over.
    pub(crate) fn is_over(self) -> bool {
        Instant::now() >= self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_leased_together_stays_below_the_most() {
        static SMALL: Budget = Budget::new(100);
        let first = SMALL.lease(60, WAIT).expect("free");
        assert!(SMALL.lease(101, WAIT).err().expect("too much").contains("at most"));
        assert!(SMALL.lease(41, Duration::ZERO).err().expect("taken").contains("try it again"));
        let mut second = SMALL.lease(40, Duration::ZERO).expect("free");
        second.shrink(30);
        assert!(SMALL.lease(11, Duration::ZERO).is_err() && SMALL.lease(10, Duration::ZERO).is_ok());
        let waiting = std::thread::spawn(|| SMALL.lease(100, WAIT).is_ok());
        drop((first, second));
        assert!(waiting.join().expect("ended"), "who waits gets what is given back");
        assert!(lease(None).is_err());
    }

    #[test]
    fn the_shelf_forgets_what_was_used_least() {
        let shelf = Shelf::new(100);
        for number in 0..4 {
            shelf.put((1, number, 0), Arc::new(number), 30);
            shelf.get((1, 0, 0));
        }
        let is_there = |number| shelf.get((1, number, 0)).is_some();
        assert!(is_there(0) && is_there(3) && !is_there(1), "the first was used again and again");
        shelf.put((2, 0, 0), Arc::new(0), 101);
        shelf.put((2, 1, 0), Arc::new(0), 10);
        assert!(shelf.get((2, 0, 0)).is_none(), "larger than the shelf");
        let used = shelf.get((1, 3, 0)).expect("there");
        assert!(!shelf.put((2, 2, 0), Arc::new(0), 80), "what is in use stays");
        assert!(is_there(3));
        drop(used);
        shelf.forget(1);
        let kept = shelf.lock();
        assert_eq!((kept.bytes, kept.pieces.len(), kept.ages.len()), (10, 1, 1));
    }
}
