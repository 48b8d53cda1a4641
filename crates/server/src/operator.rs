//! An operator inside this program: holds control as a browser's session does, and releases it on request.

use std::fmt;
use std::sync::Arc;

use crate::dto::Role;
use crate::state::App;
use crate::tokens::random_secret;

/// A session of this program itself. It ends when closed or dropped.
pub struct Operator {
    app: App,
    secret: String,
    operator: Arc<vencejo_station::Operator>,
}

impl fmt::Debug for Operator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.operator, f)
    }
}

impl Operator {
    /// Opens a session; it receives control when that is free. `None` when all slots for sessions are taken.
    pub(crate) fn open(app: App, name: &str) -> Option<Self> {
        let secret = random_secret().ok()?;
        let now = app.now();
        let operator = app.change_sessions(|sessions| {
            sessions.open(secret.clone(), Role::Operator, Some(name), now)?;
            let (id, _) = sessions.find(&secret, now)?;
            // It stays present for its whole lifetime, as a page does while its WebSocket is open.
            sessions.socket_opened(id, now);
            sessions.keep(id);
            sessions.operator(id)
        })?;
        Some(Self { app, secret, operator })
    }

    /// Identity for the station, to act in its name.
    pub fn to_station(&self) -> Arc<vencejo_station::Operator> {
        self.operator.clone()
    }

    /// Ends the session and releases control. Idempotent.
    pub fn close(&self) {
        let now = self.app.now();
        self.app.change_sessions(|sessions| sessions.close(&self.secret, now));
    }
}

impl Drop for Operator {
    fn drop(&mut self) {
        self.close();
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use vencejo_proto::MonoTime;

    use crate::ServerConfig;
    use crate::tests::{serve, station};

    #[tokio::test]
    async fn it_holds_control_as_others_do_and_gives_it_to_who_asks() {
        let station = station(true);
        let server = serve(&station, ServerConfig::default()).await;
        let session = server.operator("demo").expect("a place");
        let demo = session.to_station();
        assert!(demo.has_control());
        let app = server.app();
        let late = MonoTime::from_micros((app.now().as_duration() + Duration::from_secs(3600)).as_micros() as u64);
        app.change_sessions(|sessions| sessions.expire(late));
        assert!(demo.has_control(), "it is there for as long as it is held");
        let ana = crate::tests::cookie(&server, "ana");
        let now = app.now();
        let secret = ana.split('=').next_back().expect("a secret").to_owned();
        let (id, _) = app.sessions().find(&secret, now).expect("open");
        app.change_sessions(|sessions| sessions.request(id, now)).expect("asked");
        assert_eq!(demo.control().requested_by().as_deref(), Some("ana"));
        demo.release(now);
        assert_eq!(demo.take(now), Err(vencejo_station::NotTaken::Held("ana".into())));
        app.change_sessions(|sessions| sessions.release(id, now));
        assert_eq!(demo.take(now), Ok(()));
        session.close();
        session.close();
        assert_eq!(app.sessions().holder_name(), None);
        server.close().await;
        station.close().await;
    }
}
