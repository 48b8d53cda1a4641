//! Sessions: who is connected, and their roles. Control is the station's lease. Pure: time is passed in.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use vencejo_proto::MonoTime;
use vencejo_station::{Control, GRACE, NotTaken, Operator};

use crate::dto::{Role, SessionInfo};

/// Largest number of sessions; the one idle for longest makes room, viewers before operators, and never an operator for
/// a viewer.
pub const MAX_SESSIONS: usize = 256;
/// Largest number of viewer sessions.
const MAX_VIEWER_SESSIONS: usize = 192;
/// Idle time after which a session is dropped.
pub const IDLE: Duration = Duration::from_secs(12 * 3600);
/// Largest number of WebSockets, over all sessions.
pub const MAX_SOCKETS: usize = 128;
/// Largest number of WebSockets of viewers.
const MAX_VIEWER_SOCKETS: usize = 96;
/// Largest number of WebSockets of one session: tabs of one browser.
const MAX_SOCKETS_OF_ONE: u32 = 16;

/// The public id of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SessionId(u64);

impl std::fmt::Display for SessionId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "s{}", self.0)
    }
}

#[derive(Debug)]
struct Session {
    id: SessionId,
    name: String,
    role: Role,
    /// Number of open WebSockets.
    sockets: u32,
    /// Whether it belongs to this program itself.
    is_inside: bool,
    last_used: MonoTime,
    /// Time when its last WebSocket closed.
    left: Option<MonoTime>,
    /// Identity for the station, of an operator's session.
    operator: Option<Arc<Operator>>,
}

impl Session {
    fn is_alive(&self, now: MonoTime) -> bool {
        self.sockets > 0 || now.since(self.last_used) <= GRACE
    }

    /// Whether a user is present, or has just left and may come back. A request without a WebSocket does not make one
    /// present.
    fn is_there(&self, now: MonoTime) -> bool {
        self.sockets > 0 || self.left.is_some_and(|left| now.since(left) <= GRACE)
    }
}

/// However a session ends, its requests in progress (such as a body that trickles in) may do nothing more.
impl Drop for Session {
    fn drop(&mut self) {
        if let Some(operator) = &self.operator {
            operator.dismiss();
        }
    }
}

/// All sessions, by their secrets.
#[derive(Debug, Default)]
pub struct Sessions {
    by_secret: HashMap<String, Session>,
    opened: u64,
    control: Control,
}

/// Why control was not granted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NotGiven {
    /// The session has ended.
    NoSession,
    /// The role does not permit it.
    Viewer,
    /// Another session, with this name, holds it.
    Held(String),
}

impl Sessions {
    /// Sessions with this control lease.
    pub fn new(control: Control) -> Self {
        Self { control, ..Self::default() }
    }

    /// Opens a session. An operator receives control when it is free. `None` when all slots are taken by sessions in
    /// use.
    pub fn open(&mut self, secret: String, role: Role, name: Option<&str>, now: MonoTime) -> Option<SessionInfo> {
        self.expire(now);
        let viewers = self.by_secret.values().filter(|session| session.role == Role::Viewer).count();
        if self.by_secret.len() >= MAX_SESSIONS || (role == Role::Viewer && viewers >= MAX_VIEWER_SESSIONS) {
            let idle = self.by_secret.iter().filter(|(_, session)| session.role <= role && !session.is_alive(now));
            let oldest = idle.min_by_key(|(_, session)| (session.role, session.last_used));
            let oldest = oldest.map(|(secret, _)| secret.clone())?;
            self.by_secret.remove(&oldest);
        }
        self.opened += 1;
        let id = SessionId(self.opened);
        // A viewer is unknown to the station, but its name follows the same rules.
        let operator = self.control.enlist(name.unwrap_or_default(), now);
        let name = operator.name();
        let operator = (role == Role::Operator).then(|| Arc::new(operator));
        if let Some(operator) = &operator {
            // If another session holds it, it keeps it until a user requests it.
            let _ = operator.take(now);
        }
        self.by_secret.insert(
            secret,
            Session { id, name, role, sockets: 0, is_inside: false, last_used: now, left: None, operator },
        );
        self.info(id)
    }

    /// The session of a secret; counts as use.
    pub fn find(&mut self, secret: &str, now: MonoTime) -> Option<(SessionId, Role)> {
        let session = self.by_secret.get_mut(secret)?;
        if session.sockets == 0 && now.since(session.last_used) > IDLE {
            self.by_secret.remove(secret);
            return None;
        }
        session.last_used = now;
        if let Some(operator) = &session.operator {
            operator.touch(now);
        }
        Some((session.id, session.role))
    }

    /// Whether a secret belongs to a session. Does not count as use.
    pub fn knows(&self, secret: &str) -> bool {
        self.by_secret.contains_key(secret)
    }

    /// Ends all sessions of a role whose token has been revoked.
    pub fn revoke(&mut self, role: Role, now: MonoTime) {
        self.control.expire(now);
        self.by_secret.retain(|_, session| session.role != role || session.is_inside);
    }

    /// Number of ended sessions.
    pub fn ended(&self) -> u64 {
        self.opened - self.by_secret.len() as u64
    }

    /// Marks a session as this program's own: it needs no token.
    pub fn keep(&mut self, id: SessionId) {
        if let Some(session) = self.get_mut(id) {
            session.is_inside = true;
        }
    }

    /// Ends a session; returns whether it existed.
    pub fn close(&mut self, secret: &str, now: MonoTime) -> bool {
        self.control.expire(now);
        self.by_secret.remove(secret).is_some()
    }

    /// Opens a WebSocket for a session; returns whether the limits allow it.
    pub fn open_socket(&mut self, id: SessionId, now: MonoTime) -> bool {
        let Some(session) = self.get(id) else { return false };
        let sockets = |role: Role| -> usize {
            self.by_secret.values().filter(|other| other.role == role).map(|other| other.sockets as usize).sum()
        };
        let viewers = sockets(Role::Viewer);
        let has_room = match session.role {
            Role::Viewer => viewers < MAX_VIEWER_SOCKETS && viewers + sockets(Role::Operator) < MAX_SOCKETS,
            Role::Operator => viewers + sockets(Role::Operator) < MAX_SOCKETS,
        };
        let may = has_room && session.sockets < MAX_SOCKETS_OF_ONE;
        if may {
            self.socket_opened(id, now);
        }
        may
    }

    /// Records an opened WebSocket of a session; an operator receives control when it is free.
    pub fn socket_opened(&mut self, id: SessionId, now: MonoTime) {
        self.expire(now);
        let Some(session) = self.get_mut(id) else { return };
        session.sockets += 1;
        session.last_used = now;
        if let Some(operator) = &session.operator {
            operator.attach(now);
            // If another session holds it, it keeps it until a user requests it.
            let _ = operator.take(now);
        }
    }

    /// Records a closed WebSocket of a session.
    pub fn socket_closed(&mut self, id: SessionId, now: MonoTime) {
        if let Some(session) = self.get_mut(id) {
            session.sockets = session.sockets.saturating_sub(1);
            (session.last_used, session.left) = (now, Some(now));
            if let Some(operator) = &session.operator {
                operator.detach(now);
            }
        }
    }

    /// Identity of a session for the station; `None` for viewers and ended sessions.
    pub fn operator(&self, id: SessionId) -> Option<Arc<Operator>> {
        self.get(id)?.operator.clone()
    }

    /// Takes control if it is free, or already held by this session.
    ///
    /// # Errors
    /// When another session holds it, for a viewer, and for an ended session.
    pub fn take(&mut self, id: SessionId, now: MonoTime) -> Result<(), NotGiven> {
        let session = self.get(id).ok_or(NotGiven::NoSession)?;
        let operator = session.operator.as_ref().ok_or(NotGiven::Viewer)?;
        operator.take(now).map_err(|reason| match reason {
            NotTaken::Held(holder) => NotGiven::Held(holder),
            NotTaken::Dismissed => NotGiven::NoSession,
        })
    }

    /// Requests control from the holder; takes it when it is free.
    ///
    /// # Errors
    /// For a viewer, and for an ended session.
    pub fn request(&mut self, id: SessionId, now: MonoTime) -> Result<(), NotGiven> {
        let session = self.get(id).ok_or(NotGiven::NoSession)?;
        session.operator.as_ref().ok_or(NotGiven::Viewer)?.request(now);
        Ok(())
    }

    /// Declines the request of the operator with this name, or the present one, if this session holds control.
    pub fn decline(&mut self, id: SessionId, requested_by: Option<&str>, now: MonoTime) {
        if let Some(operator) = self.operator(id) {
            operator.keep(requested_by, now);
        }
    }

    /// Releases control: to a session that requests it, if any. A session that only requests it withdraws its request.
    pub fn release(&mut self, id: SessionId, now: MonoTime) {
        if let Some(operator) = self.operator(id) {
            operator.release(now);
        }
    }

    /// Advances time; returns whether control changed hands.
    pub fn expire(&mut self, now: MonoTime) -> bool {
        let before = self.control.version();
        self.control.expire(now);
        self.by_secret.retain(|_, session| session.sockets > 0 || now.since(session.last_used) <= IDLE);
        before != self.control.version()
    }

    /// Whether an operator's session has a WebSocket, on which the heartbeat for the vehicle's ground-station failsafe
    /// depends. If a single request started the heartbeat, the vehicle would miss it some seconds later.
    pub fn has_operator(&self, now: MonoTime) -> bool {
        self.by_secret.values().any(|session| session.role == Role::Operator && session.is_there(now))
    }

    /// Information about a session for its owner; `None` when it has ended.
    pub fn info(&self, id: SessionId) -> Option<SessionInfo> {
        let session = self.get(id)?;
        Some(SessionInfo {
            session: id.to_string(),
            name: session.name.clone(),
            role: session.role,
            has_control: self.has_control(id),
            holder: self.holder_name(),
            requested_by: self.control.requested_by(),
        })
    }

    /// Whether a session holds control.
    pub fn has_control(&self, id: SessionId) -> bool {
        self.get(id).and_then(|session| session.operator.as_ref()).is_some_and(|operator| operator.has_control())
    }

    /// Name of the holder of control.
    pub fn holder_name(&self) -> Option<String> {
        self.control.holder()
    }

    fn get(&self, id: SessionId) -> Option<&Session> {
        self.by_secret.values().find(|session| session.id == id)
    }

    fn get_mut(&mut self, id: SessionId) -> Option<&mut Session> {
        self.by_secret.values_mut().find(|session| session.id == id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(s: u64) -> MonoTime {
        MonoTime::from_millis(s * 1000)
    }

    fn open(sessions: &mut Sessions, secret: &str, role: Role, now: MonoTime) -> SessionId {
        sessions.open(secret.to_owned(), role, Some(secret), now).expect("a place");
        sessions.find(secret, now).expect("open").0
    }

    #[test]
    fn the_first_operator_gets_control_and_the_second_asks_for_it() {
        let mut sessions = Sessions::default();
        let viewer = open(&mut sessions, "viewer", Role::Viewer, at(0));
        assert_eq!(sessions.holder_name(), None, "a viewer gets nothing");
        let first = open(&mut sessions, "first", Role::Operator, at(0));
        let second = open(&mut sessions, "second", Role::Operator, at(0));
        assert!(sessions.has_control(first) && !sessions.has_control(second));
        assert_eq!(sessions.take(viewer, at(1)), Err(NotGiven::Viewer));
        assert_eq!(sessions.take(second, at(1)), Err(NotGiven::Held("first".into())));
        assert_eq!(sessions.request(second, at(1)), Ok(()));
        assert_eq!(sessions.info(first).expect("open").requested_by.as_deref(), Some("second"));
        sessions.decline(second, None, at(1));
        assert!(sessions.info(first).expect("open").requested_by.is_some(), "only the holder declines");
        sessions.decline(first, None, at(1));
        assert_eq!(sessions.info(second).expect("open").requested_by, None);
        assert!(sessions.has_control(first), "the holder keeps it");
        assert_eq!(sessions.request(second, at(1)), Ok(()), "who was declined may ask again");
        sessions.release(first, at(1));
        assert!(sessions.has_control(second), "it goes to the one that asked");
        assert_eq!(sessions.info(first).expect("open").requested_by, None);
    }

    #[test]
    fn control_ends_with_the_websocket_after_a_grace() {
        let mut sessions = Sessions::default();
        let first = open(&mut sessions, "first", Role::Operator, at(0));
        assert!(!sessions.has_operator(at(0)), "who asks once does not stay");
        sessions.socket_opened(first, at(0));
        assert!(!sessions.expire(at(100)), "its WebSocket keeps it");
        assert!(sessions.has_operator(at(100)));
        sessions.socket_closed(first, at(100));
        assert!(!sessions.expire(at(105)), "five seconds to come back");
        assert!(sessions.has_operator(at(105)));
        assert!(sessions.expire(at(106)));
        assert_eq!(sessions.holder_name(), None);
        assert!(!sessions.has_operator(at(106)));
        sessions.socket_opened(first, at(107));
        assert!(sessions.has_control(first), "whoever comes back first has it again");
    }

    #[test]
    fn a_lease_that_ends_goes_to_the_one_that_asks_if_alive() {
        let mut sessions = Sessions::default();
        let first = open(&mut sessions, "first", Role::Operator, at(0));
        let second = open(&mut sessions, "second", Role::Operator, at(0));
        sessions.socket_opened(second, at(0));
        sessions.request(second, at(1)).expect("asked");
        assert!(sessions.expire(at(7)));
        assert!(sessions.has_control(second) && !sessions.has_control(first));
    }

    #[test]
    fn places_are_bounded_and_go_to_the_newest() {
        let mut sessions = Sessions::default();
        for index in 0..MAX_VIEWER_SESSIONS {
            let id = open(&mut sessions, &format!("{index}"), Role::Viewer, at(index as u64));
            if index < 2 {
                sessions.socket_opened(id, at(index as u64));
            }
        }
        assert!(sessions.open("new".into(), Role::Viewer, None, at(1000)).is_some());
        assert_eq!(sessions.by_secret.len(), MAX_VIEWER_SESSIONS);
        assert!(sessions.find("0", at(1000)).is_some(), "one with a WebSocket stays");
        assert!(sessions.find("2", at(1000)).is_none(), "the one idle for longest went");
        let mut full = Sessions::default();
        for index in 0..MAX_SESSIONS {
            open(&mut full, &format!("{index}"), Role::Operator, at(0));
        }
        assert!(full.open("new".into(), Role::Operator, None, at(1)).is_none(), "all are in use");
    }

    #[test]
    fn viewers_take_no_operators_place() {
        let mut sessions = Sessions::default();
        for index in 0..MAX_SESSIONS - MAX_VIEWER_SESSIONS {
            open(&mut sessions, &format!("operator {index}"), Role::Operator, at(0));
        }
        for index in 0..1000 {
            // They all come at once, and again: each is in use, or idle and newer than every operator.
            sessions.open(format!("viewer {index}"), Role::Viewer, None, at(index / 200 * 10));
        }
        assert_eq!(sessions.by_secret.len(), MAX_SESSIONS);
        let operators = sessions.by_secret.values().filter(|session| session.role == Role::Operator).count();
        assert_eq!(operators, MAX_SESSIONS - MAX_VIEWER_SESSIONS, "none had to go");
        let newcomer = open(&mut sessions, "one more", Role::Operator, at(3600));
        assert!(sessions.info(newcomer).is_some(), "an idle viewer makes room for an operator");
        let operators = sessions.by_secret.values().filter(|session| session.role == Role::Operator).count();
        assert_eq!(operators, MAX_SESSIONS - MAX_VIEWER_SESSIONS + 1);
    }

    #[test]
    fn viewers_take_no_operators_websocket() {
        let mut sessions = Sessions::default();
        let mut opened = 0;
        for index in 0..20 {
            let viewer = open(&mut sessions, &format!("viewer {index}"), Role::Viewer, at(0));
            opened += (0..100).filter(|_| sessions.open_socket(viewer, at(0))).count();
        }
        assert_eq!(opened, MAX_VIEWER_SOCKETS);
        let pilot = open(&mut sessions, "pilot", Role::Operator, at(0));
        assert_eq!((0..100).filter(|_| sessions.open_socket(pilot, at(0))).count(), MAX_SOCKETS_OF_ONE as usize);
        sessions.socket_closed(pilot, at(1));
        assert!(sessions.open_socket(pilot, at(1)), "one went, one comes");
    }

    #[test]
    fn a_role_without_its_token_has_no_sessions() {
        let mut sessions = Sessions::default();
        let viewer = open(&mut sessions, "viewer", Role::Viewer, at(0));
        let pilot = open(&mut sessions, "pilot", Role::Operator, at(0));
        let inside = open(&mut sessions, "inside", Role::Operator, at(0));
        sessions.keep(inside);
        let before = sessions.ended();
        sessions.revoke(Role::Operator, at(1));
        assert_eq!(sessions.ended(), before + 1);
        assert!(sessions.info(viewer).is_some() && sessions.info(inside).is_some());
        assert!(sessions.info(pilot).is_none());
        assert_eq!(sessions.holder_name(), None, "control went with the session");
    }

    #[test]
    fn a_forgotten_session_is_no_session() {
        let mut sessions = Sessions::default();
        open(&mut sessions, "old", Role::Viewer, at(0));
        assert!(sessions.find("old", at(13 * 3600)).is_none());
        assert!(!sessions.close("old", at(13 * 3600)));
    }
}
