//! What is known of the ground around plans, in squares; who looks them up is another's business.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{Semaphore, watch};
use tokio::time::Instant;
use vencejo_flight::ground::{GroundMap, Square, SquareId};

/// Squares that are kept, 8 kB each; those that were used longest ago go first.
const KEPT: usize = 2048;
/// After that a square is asked for again, and used meanwhile: a source may be another.
const OLD: Duration = Duration::from_secs(60);
/// The same for one that is not known, or not whole: a network may be back.
const DOUBTED: Duration = Duration::from_secs(10);
/// Squares that are looked up at once.
const AT_ONCE: usize = 4;

/// What is known of the ground.
#[derive(Debug)]
pub struct Grounds {
    known: Mutex<Known>,
    /// Turns for those that are looked up.
    pub turns: Arc<Semaphore>,
    /// Changes with every square that comes.
    pub arrived: watch::Sender<u64>,
}

impl Default for Grounds {
    fn default() -> Self {
        let turns = Arc::new(Semaphore::new(AT_ONCE));
        Self { known: Mutex::default(), turns, arrived: watch::channel(0).0 }
    }
}

#[derive(Debug, Default)]
struct Known {
    squares: HashMap<SquareId, Kept>,
    /// Those that are being looked up.
    asked: HashSet<SquareId>,
}

#[derive(Debug)]
struct Kept {
    square: Arc<Square>,
    from: Instant,
    used: Instant,
}

impl Grounds {
    fn lock(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is known of these squares, and those that are to be looked up, which then count as asked for.
    pub fn take(&self, ids: &[SquareId]) -> (GroundMap, Vec<SquareId>) {
        let now = Instant::now();
        let mut known = self.lock();
        let map = GroundMap::new(ids, |id| {
            let kept = known.squares.get_mut(&id)?;
            kept.used = now;
            Some(kept.square.clone())
        });
        let is_fresh = |kept: &Kept| now - kept.from < if kept.square.is_whole() { OLD } else { DOUBTED };
        let open: Vec<_> = ids.iter().filter(|id| !known.squares.get(id).is_some_and(is_fresh)).copied().collect();
        (map, open.into_iter().filter(|id| known.asked.insert(*id)).collect())
    }

    /// Whether squares that are not wholly known are being looked up.
    pub fn is_pending(&self, ids: &[SquareId]) -> bool {
        let known = self.lock();
        let is_whole = |id| known.squares.get(id).is_some_and(|kept: &Kept| kept.square.is_whole());
        ids.iter().any(|id| known.asked.contains(id) && !is_whole(id))
    }

    /// Keeps what was found of a square that was asked for; `None`: it was not looked up.
    pub fn keep(&self, id: SquareId, square: Option<Square>) {
        let now = Instant::now();
        let mut known = self.lock();
        known.asked.remove(&id);
        if let Some(square) = square {
            known.squares.insert(id, Kept { square: Arc::new(square), from: now, used: now });
        }
        if known.squares.len() > KEPT {
            let mut used: Vec<_> = known.squares.iter().map(|(id, kept)| (kept.used, *id)).collect();
            used.sort_unstable();
            used.truncate(KEPT / 8);
            for (_, id) in used {
                known.squares.remove(&id);
            }
        }
        drop(known);
        self.arrived.send_modify(|count| *count = count.wrapping_add(1));
    }
}
