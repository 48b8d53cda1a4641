//! State shared by all handlers.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use tokio::sync::{Semaphore, mpsc, watch};
use tokio::time::{MissedTickBehavior, interval};
use vencejo_maps::Maps;
use vencejo_proto::MonoTime;
use vencejo_station::{Pending, RequestResult, Station, VehicleHandle};
use vencejo_vehicle::VehicleId;
use vencejo_video::VideoHub;

use crate::access::Access;
use crate::convert;
use crate::drafts::Drafts;
use crate::dto::cause::{Cause, LimitKind};
use crate::dto::storage::{StorageFault, StorageProblem};
use crate::dto::{Operation, OperationKind};
use crate::operations::{MAX_RUNNING, Operations};
use crate::outbox::Outboxes;
use crate::problem::{self, Problem};
use crate::roster::Roster;
use crate::sessions::{SessionId, Sessions};
use crate::squares::Grounds;
use crate::tokens::{self, Throttle, TokenStore};

mod telling;

/// State shared by all handlers. Clones are handles to the same state.
#[derive(Clone)]
pub struct App {
    shared: Arc<Shared>,
}

/// Optional parts of a server.
#[derive(Default)]
pub struct AppParts {
    /// On board a vehicle: our heartbeat is sent only while an operator is connected.
    pub on_board: bool,
    /// The map service; `None` without a folder for maps.
    pub maps: Option<Maps>,
    /// The draft of the plan; in memory alone by default.
    pub drafts: Drafts,
    /// Folder with the recordings of cameras.
    pub video_folder: Option<PathBuf>,
    /// Folder with the history of remote aircraft.
    pub history_folder: Option<PathBuf>,
    /// Fault of the token file at start-up.
    pub token_fault: Option<StorageFault>,
}

struct Shared {
    station: Station,
    access: Access,
    parts: AppParts,
    sessions: Mutex<Sessions>,
    throttle: Throttle,
    operations: Operations,
    outboxes: Outboxes,
    roster: watch::Sender<Arc<Roster>>,
    video: VideoHub,
    grounds: Grounds,
    /// Serialises access to the draft: an unresponsive disk blocks at most one thread.
    draft_turn: Arc<Semaphore>,
    /// Present storage faults.
    storage: watch::Sender<Vec<StorageProblem>>,
    closing: watch::Sender<bool>,
    /// Cloned into every new task; `None` once the server is closed.
    alive: Mutex<Option<Alive>>,
}

impl std::fmt::Debug for App {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("App").field("access", &self.shared.access).finish_non_exhaustive()
    }
}

/// Held by every task of a server: its channel closes when all tasks have ended.
pub type Alive = mpsc::Sender<()>;

/// The time of day, microseconds since 1970.
pub fn now_unix_us() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_micros()).unwrap_or(u64::MAX)
}

/// Waits until the server is being closed.
pub async fn closed(closing: &mut watch::Receiver<bool>) {
    // An error means that the server was dropped: closed as well.
    let _ = closing.wait_for(|closing| *closing).await;
}

impl App {
    /// The state of a new server.
    pub fn new(station: Station, access: Access, parts: AppParts, alive: Alive) -> Self {
        let sessions = Mutex::new(Sessions::new(station.control().clone()));
        let shared = Shared {
            station,
            access,
            parts,
            sessions,
            throttle: Throttle::default(),
            operations: Operations::since(now_unix_us() / 1000),
            outboxes: Outboxes::default(),
            roster: watch::channel(Arc::default()).0,
            video: VideoHub::default(),
            grounds: Grounds::default(),
            draft_turn: Arc::new(Semaphore::new(1)),
            storage: watch::channel(Vec::new()).0,
            closing: watch::channel(false).0,
            alive: Mutex::new(Some(alive)),
        };
        Self { shared: Arc::new(shared) }
    }

    /// The station that is served.
    pub fn station(&self) -> &Station {
        &self.shared.station
    }

    /// The vehicle that a request names; `None` if it names none, or one that was not heard.
    pub fn vehicle(&self, id: Option<u16>) -> Option<VehicleHandle> {
        self.station().vehicle(VehicleId::new(id?))
    }

    /// Tokens, hosts and origins that are allowed.
    pub fn access(&self) -> &Access {
        &self.shared.access
    }

    /// Whether the heartbeat follows the operators' WebSockets.
    pub fn is_on_board(&self) -> bool {
        self.shared.parts.on_board
    }

    /// The present moment on the station's clock.
    pub fn now(&self) -> MonoTime {
        self.shared.station.now()
    }

    /// The sessions, under a short lock.
    pub fn sessions(&self) -> MutexGuard<'_, Sessions> {
        self.shared.sessions.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Rate limit for wrong tokens.
    pub fn throttle(&self) -> &Throttle {
        &self.shared.throttle
    }

    /// Changes sessions. Wakes the WebSockets of sessions that ended, and switches the heartbeat on board.
    /// [`Self::tell`] announces a change of control, whatever caused it.
    pub fn change_sessions<T>(&self, change: impl FnOnce(&mut Sessions) -> T) -> T {
        let now = self.now();
        let (result, has_ended, has_operator) = {
            let mut sessions = self.sessions();
            let before = sessions.ended();
            let result = change(&mut sessions);
            (result, before != sessions.ended(), sessions.has_operator(now))
        };
        if has_ended {
            self.shared.outboxes.put_control();
        }
        if self.is_on_board() {
            self.shared.station.set_heartbeat(has_operator);
        }
        result
    }

    /// Long-running operations.
    pub fn operations(&self) -> &Operations {
        &self.shared.operations
    }

    /// Outgoing queues of the WebSocket clients.
    pub fn outboxes(&self) -> &Outboxes {
        &self.shared.outboxes
    }

    /// The map service.
    ///
    /// # Errors
    /// [`Cause::NoMaps`] if the server was started without a folder for maps.
    pub fn maps(&self) -> Result<&Maps, Problem> {
        self.shared.parts.maps.as_ref().ok_or_else(|| {
            Problem::new(Cause::NoMaps, "this server was started without a folder for maps")
                .remedy("start it with --maps FOLDER")
        })
    }

    /// Cached terrain around plans.
    pub fn grounds(&self) -> &Grounds {
        &self.shared.grounds
    }

    /// The draft of the plan; in memory only if the server was given no file for it.
    pub fn drafts(&self) -> &Drafts {
        &self.shared.parts.drafts
    }

    /// Runs `work` on the draft in a blocking thread, one at a time.
    ///
    /// # Errors
    /// [`Cause::Closed`].
    pub async fn with_drafts<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Drafts) -> T + Send + 'static,
    ) -> Result<T, Problem> {
        let turn = self.shared.draft_turn.clone().acquire_owned().await.map_err(|_| Problem::closed())?;
        let app = self.clone();
        let work = move || {
            let _turn = turn;
            work(app.drafts())
        };
        tokio::task::spawn_blocking(work).await.map_err(|_| Problem::closed())
    }

    /// Fault of the token file at start-up.
    pub fn token_fault(&self) -> Option<StorageFault> {
        self.shared.parts.token_fault.clone()
    }

    /// Storage faults, the flight recorder's first; empty if there are none.
    pub fn storage_problems(&self) -> Vec<StorageProblem> {
        self.shared.storage.borrow().clone()
    }

    /// Storage faults, as they change.
    #[cfg(test)]
    pub fn storage_changes(&self) -> watch::Receiver<Vec<StorageProblem>> {
        self.shared.storage.subscribe()
    }

    /// Folder with the history of remote aircraft, if configured.
    pub fn history_folder(&self) -> Option<&Path> {
        self.shared.parts.history_folder.as_deref()
    }

    /// Folder with the recordings of cameras, if configured.
    pub fn video_folder(&self) -> Option<&Path> {
        self.shared.parts.video_folder.as_deref()
    }

    /// The cameras.
    pub fn video(&self) -> &VideoHub {
        &self.shared.video
    }

    /// Becomes true when the server is being closed.
    pub fn closing(&self) -> watch::Receiver<bool> {
        self.shared.closing.subscribe()
    }

    /// To be held by a new task; `None` once the server is closed and none may start.
    pub fn alive(&self) -> Option<Alive> {
        self.shared.alive.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Ends all tasks and connections soon.
    pub fn close(&self) {
        self.shared.alive.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(maps) = &self.shared.parts.maps {
            maps.close();
        }
        self.shared.closing.send_replace(true);
    }

    /// Follows a transfer as an operation.
    ///
    /// # Errors
    /// What the vehicle refused at once, and [`Problem::too_many`].
    pub fn follow(
        &self,
        by: SessionId,
        vehicle: u16,
        kind: OperationKind,
        pending: Pending<RequestResult>,
    ) -> Result<Operation, Problem> {
        if let Some(Err(error)) = pending.end() {
            return Err(error.into());
        }
        let Some(alive) = self.alive() else { return Err(Problem::closed()) };
        let Some(operation) = self.shared.operations.add(by, vehicle, kind, pending.clone()) else {
            pending.cancel();
            let detail = format!("{MAX_RUNNING} operations are under way; wait for some of them");
            return Err(Problem::too_many(LimitKind::Operations, MAX_RUNNING, detail));
        };
        self.tell_operation(&operation);
        let (app, id) = (self.clone(), operation.id);
        let mut closing = self.closing();
        let follow = async move {
            let mut seen = 0;
            while let Some(progress) = pending.next_progress(seen).await {
                seen = progress.report;
                if let Some(operation) = app.shared.operations.progress(id, progress.done, progress.total) {
                    app.tell_operation(&operation);
                }
            }
            let end = match pending.wait().await {
                Some(Ok(reply)) => convert::outcome(reply).map_err(|error| *problem::from_flight(&error).0),
                Some(Err(error)) => Err(*problem::from_station(&error).0),
                None => Err(*Problem::closed().0),
            };
            if let Some(operation) = app.shared.operations.end(id, end) {
                app.tell_operation(&operation);
            }
        };
        // Its request goes on without it and ends within a bounded time or with the station.
        tokio::spawn(async move {
            tokio::select! {
                () = follow => {}
                () = closed(&mut closing) => {}
            }
            drop(alive);
        });
        Ok(operation)
    }

    /// Watches the token file and ends the sessions of revoked tokens, until the server is closed.
    pub async fn watch_tokens(self, tokens: TokenStore, _alive: Alive) {
        let mut closing = self.closing();
        let mut ticks = interval(tokens::LOOK_INTERVAL);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut was_readable = true;
        loop {
            tokio::select! {
                () = closed(&mut closing) => return,
                _ = ticks.tick() => {}
            }
            let looking = tokens.clone();
            let looked = tokio::task::spawn_blocking(move || looking.look()).await;
            let revoked = looked.unwrap_or_else(|error| Err(std::io::Error::other(error)));
            if let Err(error) = &revoked
                && was_readable
            {
                tracing::warn!(%error, "the file of the tokens cannot be read: those that were read before hold");
            }
            was_readable = revoked.is_ok();
            for role in revoked.unwrap_or_default() {
                tracing::info!(?role, "a new token holds; the sessions of the old one end");
                let now = self.now();
                self.change_sessions(|sessions| sessions.revoke(role, now));
            }
        }
    }
}
