//! Work that takes a while, off the runtime's threads, few at once.

use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::{Semaphore, SemaphorePermit, oneshot};
use tokio::time::timeout;

use crate::dto::Role;
use crate::dto::cause::Crowd;
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

/// Bodies that are worked on as they come, at once; each may come slowly, and the work hold tens of megabytes meanwhile.
const MAX_BODIES: usize = 2;
/// How many of them viewers may send: whoever only looks keeps no place from whoever commands.
const MAX_VIEWER_BODIES: usize = 1;
/// How long a body that has begun to come waits for a place.
const BODY_WAIT: Duration = Duration::from_secs(10);
static BODIES: Bodies = Bodies::new();

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

/// The places of those bodies: they keep nobody else from a turn.
struct Bodies {
    all: Semaphore,
    viewers: Semaphore,
}

impl Bodies {
    const fn new() -> Self {
        Self { all: Semaphore::const_new(MAX_BODIES), viewers: Semaphore::const_new(MAX_VIEWER_BODIES) }
    }

    async fn place(&self, role: Role) -> Result<BodyPlace<'_>, Problem> {
        let place = async {
            let of_viewers = match role {
                Role::Viewer => Some(self.viewers.acquire().await?),
                Role::Operator => None,
            };
            Ok(BodyPlace { _of_all: self.all.acquire().await?, _of_viewers: of_viewers })
        };
        let limit = if role == Role::Viewer { MAX_VIEWER_BODIES } else { MAX_BODIES };
        match timeout(BODY_WAIT, place).await {
            Ok(place) => place.map_err(|_: tokio::sync::AcquireError| Problem::closed()),
            Err(_) => {
                let detail = format!("others send files that are read as they come, at most {limit} at once");
                Err(Problem::too_many(Crowd::Bodies, limit, detail).remedy("try again when one of them is there"))
            }
        }
    }
}

/// A place for work that goes on as a body comes.
pub struct BodyPlace<'a> {
    _of_all: SemaphorePermit<'a>,
    _of_viewers: Option<SemaphorePermit<'a>>,
}

impl BodyPlace<'static> {
    /// Waits for one, but not as long as others may keep theirs. To be asked for when something of the body has come: whoever
    /// sends nothing holds none.
    ///
    /// # Errors
    /// When there is none in time, and when the server is closed.
    pub async fn wait(role: Role) -> Result<Self, Problem> {
        BODIES.place(role).await
    }

    /// Does it there.
    ///
    /// # Errors
    /// Its own; and when the server is closed.
    pub async fn work<T: Send + 'static>(
        self,
        work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
    ) -> Result<T, Problem> {
        on_a_thread(self, work).await
    }
}

async fn in_turn_of<T: Send + 'static>(
    turns: &'static Semaphore,
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    on_a_thread(turns.acquire().await.map_err(|_| Problem::closed())?, work).await
}

async fn on_a_thread<T: Send + 'static>(
    turn: impl Send + 'static,
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dto::Cause;

    #[tokio::test(start_paused = true)]
    async fn viewers_keep_no_place_for_a_body_from_whoever_commands() {
        let bodies = Bodies::new();
        let viewer = bodies.place(Role::Viewer).await.expect("the first");
        let refused = bodies.place(Role::Viewer).await.err().expect("one viewer's body at once");
        assert_eq!((refused.0.status, refused.0.cause), (429, Cause::TooMany { what: Crowd::Bodies, limit: 1 }));
        let _pilot = bodies.place(Role::Operator).await.expect("one is left");
        let refused = bodies.place(Role::Operator).await.err().expect("two bodies at once");
        assert_eq!(refused.0.cause, Cause::TooMany { what: Crowd::Bodies, limit: 2 });
        let (placed, ()) = tokio::join!(bodies.place(Role::Operator), async { drop(viewer) });
        assert!(placed.is_ok(), "who waits has the place that becomes free");
    }
}
