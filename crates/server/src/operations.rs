//! Long-running operations (plans, all parameters): progress, and results for later retrieval.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use vencejo_station::{Pending, RequestResult};

use crate::dto::{Cause, Operation, OperationKind, OperationResult, OperationState, Problem};
use crate::sessions::SessionId;

/// Largest number of running operations; more are refused.
pub const MAX_RUNNING: usize = 32;
/// Number of ended operations that are kept; the oldest are dropped.
pub const MAX_ENDED: usize = 32;

/// Result of a successful operation.
#[derive(Debug, Default)]
pub struct Outcome {
    /// The plan or parameters read, or now on board.
    pub result: Option<OperationResult>,
    /// Distance between positions on board and those sent, for a vehicle that stores them imprecisely.
    pub position_error_m: Option<f64>,
}

struct Entry {
    operation: Operation,
    by: SessionId,
    pending: Pending<RequestResult>,
}

#[derive(Default)]
struct Entries {
    /// Last assigned id.
    last: u64,
    by_id: BTreeMap<u64, Entry>,
}

/// Operations of a server.
pub struct Operations {
    entries: Mutex<Entries>,
}

impl Operations {
    /// Operations of a run that starts at this time, in milliseconds since the UNIX epoch. Ids continue from there: a
    /// page that stayed open over a restart knows those of the previous run, and must not confuse new operations with
    /// them. Fewer than a thousand are started per second, and numbers of this size (below 2⁵³) are exact in
    /// JavaScript.
    pub fn since(unix_ms: u64) -> Self {
        Self { entries: Mutex::new(Entries { last: unix_ms, by_id: BTreeMap::new() }) }
    }

    /// Registers an operation; `None` when too many are running.
    pub fn add(
        &self,
        by: SessionId,
        vehicle: u16,
        kind: OperationKind,
        pending: Pending<RequestResult>,
    ) -> Option<Operation> {
        let mut entries = self.lock();
        let ended = |entry: &Entry| entry.operation.state != OperationState::Running;
        let running = entries.by_id.values().filter(|entry| !ended(entry)).count();
        if running >= MAX_RUNNING {
            return None;
        }
        let old: Vec<u64> = entries.by_id.iter().filter(|(_, entry)| ended(entry)).map(|(id, _)| *id).collect();
        for id in old.iter().take((old.len() + 1).saturating_sub(MAX_ENDED)) {
            entries.by_id.remove(id);
        }
        entries.last += 1;
        let progress = pending.progress();
        let operation = Operation {
            id: entries.last,
            vehicle,
            kind,
            state: OperationState::Running,
            done: progress.done,
            total: progress.total,
            error: None,
            position_error_m: None,
            result: None,
        };
        entries.by_id.insert(operation.id, Entry { operation: operation.clone(), by, pending });
        Some(operation)
    }

    /// An operation with its result.
    pub fn get(&self, id: u64) -> Option<Operation> {
        self.lock().by_id.get(&id).map(|entry| entry.operation.clone())
    }

    /// Session that started an operation.
    pub fn begun_by(&self, id: u64) -> Option<SessionId> {
        self.lock().by_id.get(&id).map(|entry| entry.by)
    }

    /// All operations without their results, oldest first.
    pub fn list(&self) -> Vec<Operation> {
        self.lock().by_id.values().map(|entry| copy(&entry.operation)).collect()
    }

    /// Cancels an operation; it ends soon, unless it has ended already.
    pub fn cancel(&self, id: u64) -> Option<Operation> {
        let pending = self.lock().by_id.get(&id).map(|entry| entry.pending.clone())?;
        // Outside of the lock, since it may end the operation at once.
        pending.cancel();
        self.get(id)
    }

    /// Records progress; returns the operation without its result, or `None` when it was dropped.
    pub fn progress(&self, id: u64, done: u32, total: u32) -> Option<Operation> {
        let mut entries = self.lock();
        let operation = &mut entries.by_id.get_mut(&id)?.operation;
        (operation.done, operation.total) = (done, total);
        Some(copy(operation))
    }

    /// Records the end; returns the operation without its result, or `None` when it was dropped.
    pub fn end(&self, id: u64, end: Result<Outcome, Problem>) -> Option<Operation> {
        let mut entries = self.lock();
        let operation = &mut entries.by_id.get_mut(&id)?.operation;
        match end {
            Ok(outcome) => {
                operation.state = OperationState::Done;
                operation.done = operation.total;
                operation.position_error_m = outcome.position_error_m;
                operation.result = outcome.result;
            }
            Err(problem) => {
                let was_cancelled = problem.cause == Cause::Cancelled;
                operation.state = if was_cancelled { OperationState::Cancelled } else { OperationState::Failed };
                operation.error = Some(problem);
            }
        }
        Some(copy(operation))
    }

    fn lock(&self) -> MutexGuard<'_, Entries> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The operation without its result, which may be large.
fn copy(operation: &Operation) -> Operation {
    Operation { result: None, error: operation.error.clone(), ..*operation }
}
