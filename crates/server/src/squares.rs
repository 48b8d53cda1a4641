//! Cache of terrain squares around plans; loading them is the caller's task.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{Semaphore, watch};
use tokio::time::Instant;
use vencejo_flight::ground::{GroundMap, Square, SquareId};

/// Largest number of squares, 8 kB each; the least recently used are evicted.
const MAX_SQUARES: usize = 2048;
/// Age at which a square is loaded again, and used meanwhile: its source may have changed.
const REFRESH_AFTER: Duration = Duration::from_secs(60);
/// The same for a missing or incomplete one: a network may be back.
const RETRY_AFTER: Duration = Duration::from_secs(10);
/// Number of squares loaded at once.
const MAX_LOADING: usize = 4;

/// The cache.
#[derive(Debug)]
pub struct Grounds {
    known: Mutex<Inner>,
    /// Permits for loading squares.
    pub turns: Arc<Semaphore>,
    /// Changes with every square that arrives.
    pub arrived: watch::Sender<u64>,
}

impl Default for Grounds {
    fn default() -> Self {
        let turns = Arc::new(Semaphore::new(MAX_LOADING));
        Self { known: Mutex::default(), turns, arrived: watch::channel(0).0 }
    }
}

#[derive(Debug, Default)]
struct Inner {
    squares: HashMap<SquareId, CachedSquare>,
    /// Squares being loaded.
    asked: HashSet<SquareId>,
}

#[derive(Debug)]
struct CachedSquare {
    square: Arc<Square>,
    from: Instant,
    used: Instant,
}

impl Grounds {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The cached ones of these squares, and those to load, which are then marked as being loaded.
    pub fn take(&self, ids: &[SquareId]) -> (GroundMap, Vec<SquareId>) {
        let now = Instant::now();
        let mut known = self.lock();
        let map = GroundMap::new(ids, |id| {
            let kept = known.squares.get_mut(&id)?;
            kept.used = now;
            Some(kept.square.clone())
        });
        let is_fresh =
            |kept: &CachedSquare| now - kept.from < if kept.square.is_whole() { REFRESH_AFTER } else { RETRY_AFTER };
        let open: Vec<_> = ids.iter().filter(|id| !known.squares.get(id).is_some_and(is_fresh)).copied().collect();
        (map, open.into_iter().filter(|id| known.asked.insert(*id)).collect())
    }

    /// Whether missing or incomplete squares are being loaded.
    pub fn is_pending(&self, ids: &[SquareId]) -> bool {
        let known = self.lock();
        let is_whole = |id| known.squares.get(id).is_some_and(|kept: &CachedSquare| kept.square.is_whole());
        ids.iter().any(|id| known.asked.contains(id) && !is_whole(id))
    }

    /// Stores the result for a requested square; `None` if it was not loaded.
    pub fn keep(&self, id: SquareId, square: Option<Square>) {
        let now = Instant::now();
        let mut known = self.lock();
        known.asked.remove(&id);
        if let Some(square) = square {
            known.squares.insert(id, CachedSquare { square: Arc::new(square), from: now, used: now });
        }
        if known.squares.len() > MAX_SQUARES {
            let mut used: Vec<_> = known.squares.iter().map(|(id, kept)| (kept.used, *id)).collect();
            used.sort_unstable();
            used.truncate(MAX_SQUARES / 8);
            for (_, id) in used {
                known.squares.remove(&id);
            }
        }
        drop(known);
        self.arrived.send_modify(|count| *count = count.wrapping_add(1));
    }
}
