//! Execution of long work off the async threads, with limited concurrency.

use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::{Semaphore, SemaphorePermit, oneshot};
use tokio::time::timeout;

use crate::dto::Role;
use crate::dto::cause::LimitKind;
use crate::problem::Problem;

/// Niceness of long work: half of the possible range (nice(2)).
#[cfg(target_os = "linux")]
const BEHIND: i32 = 10;

/// Files parsed and plans checked at once; a file may need some tens of megabytes.
static TURNS: Semaphore = Semaphore::const_new(2);

/// Work of about a millisecond, whose result a user sees while dragging: it never waits for longer work.
static QUICK: Semaphore = Semaphore::const_new(2);

/// Work that uses all processors but one, for seconds.
static ALONE: Semaphore = Semaphore::const_new(1);

/// Bodies processed at once while they arrive; each may arrive slowly, and hold tens of megabytes meanwhile.
const MAX_BODIES: usize = 2;
/// Those that viewers may send, so that viewers cannot lock out operators.
const MAX_VIEWER_BODIES: usize = 1;
/// Time that an arriving body waits for a permit.
const BODY_WAIT: Duration = Duration::from_secs(10);
static BODIES: Bodies = Bodies::new();

/// Runs work in its turn, at a lower priority than everything else: telemetry, commands, and interactive requests.
///
/// # Errors
/// Those of `work`; and when the server is closed.
pub async fn in_turn<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    behind_of(&TURNS, work).await
}

/// Runs work of about a millisecond, which never waits for longer work.
///
/// # Errors
/// As for [`in_turn`].
pub async fn quickly<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    in_turn_of(&QUICK, work).await
}

/// Runs heavy work, one at a time.
///
/// # Errors
/// As for [`in_turn`].
pub async fn alone<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    behind_of(&ALONE, work).await
}

/// Permits for bodies; separate, so that they never delay other work.
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
                let detail = format!("the limit of concurrent uploads is reached: {limit}");
                Err(Problem::too_many(LimitKind::Bodies, limit, detail).remedy("try again when one of them has ended"))
            }
        }
    }
}

/// Permit to process a body while it arrives.
pub struct BodyPlace<'a> {
    _of_all: SemaphorePermit<'a>,
    _of_viewers: Option<SemaphorePermit<'a>>,
}

impl BodyPlace<'static> {
    /// Waits for a permit, but less long than others may hold theirs. Call it once part of the body has arrived, so
    /// that clients that send nothing hold none.
    ///
    /// # Errors
    /// When none is free in time, and when the server is closed.
    pub async fn wait(role: Role) -> Result<Self, Problem> {
        BODIES.place(role).await
    }

    /// Runs work with this permit.
    ///
    /// # Errors
    /// Those of `work`; and when the server is closed.
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

/// Uses a new thread each time: only root can raise a priority again, and the runtime's threads are shared.
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
        // On Linux, setpriority(2) affects the thread only; elsewhere the whole process.
        #[cfg(target_os = "linux")]
        if let Err(error) = rustix::process::setpriority_process(None, BEHIND) {
            tracing::debug!(%error, "the priority of long work cannot be lowered");
        }
        // Fails if the caller is gone, which does not matter.
        let _ = tell.send(work());
    });
    if let Err(error) = begun {
        tracing::error!(%error, "a thread for long work cannot be created");
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
        assert_eq!((refused.0.status, refused.0.cause), (429, Cause::TooMany { what: LimitKind::Bodies, limit: 1 }));
        let _pilot = bodies.place(Role::Operator).await.expect("one is left");
        let refused = bodies.place(Role::Operator).await.err().expect("two bodies at once");
        assert_eq!(refused.0.cause, Cause::TooMany { what: LimitKind::Bodies, limit: 2 });
        let (placed, ()) = tokio::join!(bodies.place(Role::Operator), async { drop(viewer) });
        assert!(placed.is_ok(), "who waits has the place that becomes free");
    }
}
