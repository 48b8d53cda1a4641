//! Work that takes a while, off the runtime's threads, few at once.

use tokio::runtime::Handle;
use tokio::sync::{Semaphore, oneshot};

use crate::problem::Problem;

/// How far work that takes a while stands behind: half as far as there is (nice(2)).
#[cfg(target_os = "linux")]
const BEHIND: i32 = 10;

/// Files that are read and plans that are looked through at once; a file may take some tens of megabytes.
static TURNS: Semaphore = Semaphore::const_new(2);

/// Work of a millisecond that somebody sees the outcome of while dragging: it waits for nothing longer.
static QUICK: Semaphore = Semaphore::const_new(2);

/// Work that takes all processors but one, for seconds.
static ALONE: Semaphore = Semaphore::const_new(1);

/// Work that goes on as a body comes, which may be slow: it keeps nobody else from his turn.
static BODIES: Semaphore = Semaphore::const_new(1);

/// Does it when it is its turn, and behind all else that wants the processor: telemetry, orders, and the line under a pointer.
///
/// # Errors
/// Its own; and when the server is closed.
pub async fn in_turn<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    behind_of(&TURNS, work).await
}

/// The same for work of a millisecond, which waits for none that takes longer.
///
/// # Errors
/// Likewise.
pub async fn quickly<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    in_turn_of(&QUICK, work).await
}

/// The same, and no other of its kind beside it.
///
/// # Errors
/// Likewise.
pub async fn alone<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    behind_of(&ALONE, work).await
}

/// The same for work that waits for a body.
///
/// # Errors
/// Likewise.
pub async fn with_body<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    in_turn_of(&BODIES, work).await
}

async fn in_turn_of<T: Send + 'static>(
    turns: &'static Semaphore,
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let turn = turns.acquire().await.map_err(|_| Problem::closed())?;
    let done = tokio::task::spawn_blocking(move || {
        let _turn = turn;
        work()
    });
    done.await.map_err(|_| Problem::closed())?
}

/// A thread of its own each time: whoever is not root cannot raise a priority again, and the runtime's threads are used for all.
async fn behind_of<T: Send + 'static>(
    turns: &'static Semaphore,
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let turn = turns.acquire().await.map_err(|_| Problem::closed())?;
    let (tell, told) = oneshot::channel();
    let runtime = Handle::current();
    let begun = std::thread::Builder::new().name("vencejo-behind".into()).spawn(move || {
        let _turn = turn;
        let _runtime = runtime.enter();
        // On Linux a thread's alone (setpriority(2)); elsewhere it would be the whole program's.
        #[cfg(target_os = "linux")]
        if let Err(error) = rustix::process::setpriority_process(None, BEHIND) {
            tracing::debug!(%error, "long work has no lower priority");
        }
        // Nobody waits any more: the work was for him.
        let _ = tell.send(work());
    });
    if let Err(error) = begun {
        tracing::error!(%error, "the system gives no thread for long work");
        return Err(Problem::closed());
    }
    told.await.map_err(|_| Problem::closed())?
}
