//! Work that takes a while, off the runtime's threads, few at once.

use tokio::sync::Semaphore;

use crate::problem::Problem;

/// Files that are read and plans that are looked through at once; a file may take some tens of megabytes.
static TURNS: Semaphore = Semaphore::const_new(2);

/// Does it when it is its turn.
///
/// # Errors
/// Its own; and when the server is closed.
pub async fn in_turn<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let turn = TURNS.acquire().await.map_err(|_| Problem::closed())?;
    let done = tokio::task::spawn_blocking(move || {
        let _turn = turn;
        work()
    });
    done.await.map_err(|_| Problem::closed())?
}
