//! The WebSocket: one task for each client, which sends its waiting messages and the newest values of subscribed
//! vehicles.
//!
//! A slow client delays only itself: its telemetry is composed when it can be sent, and only its [`Outbox`] is kept for
//! it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use axum::extract::WebSocketUpgrade;
use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, close_code};
use tokio::sync::watch;
use tokio::time::{Instant, Interval, MissedTickBehavior, interval, sleep_until, timeout};
use vencejo_station::{DropOldest, Received, Taken};
use vencejo_vehicle::telemetry::{Sent, TelemetryGroups};
use vencejo_vehicle::{VehicleId, misread};

use crate::assess::{assess, laid_out};
use crate::convert;
use crate::dto::cause::LimitKind;
use crate::dto::{self, ClientMessage, MissionProgress, ServerMessage};
use crate::outbox::{Outbox, Outgoing, json};
use crate::problem::Problem;
use crate::questions::Questions;
use crate::roster::{Roster, SentRows};
use crate::routes::message_id;
use crate::sessions::SessionId;
use crate::state::{App, closed};
use crate::turns::{in_turn, quickly};

/// Largest message of a client, bytes: a plan of a thousand items needs a quarter of that.
pub const MAX_MESSAGE_BYTES: usize = 512 * 1024;
/// Largest number of vehicles that one client subscribes to.
const MAX_SUBSCRIPTIONS: usize = 64;
/// Capacity and polling interval of the queue of a vehicle's raw messages: enough for 10,000 a second.
const MESSAGE_QUEUE: usize = 1024;
const LOOK_INTERVAL: Duration = Duration::from_millis(100);
/// Most (sender, message id) pairs kept per client; more only come from noise and are dropped.
const MAX_MESSAGE_KINDS: usize = 1024;
/// Largest number of raw messages that one client subscribes to by name.
const MAX_MESSAGE_NAMES: usize = 64;
/// Permitted rates, Hz.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=50.0;
/// Time limit for sending one message; after it, the connection counts as dead.
const SEND_TIMEOUT: Duration = Duration::from_secs(10);
/// Ping interval; a client must answer before the third ping.
const PING_INTERVAL: Duration = Duration::from_secs(2);
const MAX_UNANSWERED: u32 = 2;
/// Largest message to a client, bytes: an assessment with a long track and with findings for each of many items.
pub const MAX_SENT_BYTES: usize = 4 * 1024 * 1024;
/// Largest number of bytes waiting in the socket for one client: the answers to pings of one that does not read. More
/// closes its connection.
const MAX_WAITING_BYTES: usize = 1024 * 1024;
/// Largest number of messages from a client per second, pings and pongs included: a page requests a route in each frame
/// of a drag.
const MAX_MESSAGES_PER_S: u32 = 200;

/// Code of a close frame for a client that was too slow ("try again later").
const TOO_SLOW: u16 = close_code::AGAIN;

/// Why a connection ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// The client disconnected.
    Gone,
    /// The client did not read its events, or nothing at all.
    TooSlow,
    /// The client no longer answers.
    Silent,
    /// The client sends invalid or too many messages.
    Rude(&'static str),
    /// Its session has ended.
    NoSession,
    /// The server is being closed.
    Closing,
}

impl End {
    fn frame(self) -> Option<CloseFrame> {
        let (code, reason) = match self {
            Self::Gone => return None,
            Self::TooSlow => (TOO_SLOW, "too slow: texts and events were lost; connect again and read them"),
            Self::Silent => (close_code::AWAY, "no answer to pings"),
            Self::Rude(reason) => (close_code::POLICY, reason),
            Self::NoSession => (close_code::POLICY, "the session has ended"),
            Self::Closing => (close_code::AWAY, "the server is being closed"),
        };
        Some(CloseFrame { code, reason: Utf8Bytes::from_static(reason) })
    }
}

/// A client's subscription to a vehicle, and the values sent last.
struct Subscription {
    period: Duration,
    due: Instant,
    sent: Sent,
    progress: Option<MissionProgress>,
}

/// A client's subscription to raw messages of a vehicle, and the newest ones.
struct MessageSubscription {
    /// Message ids; all when absent.
    ids: Option<BTreeSet<u32>>,
    period: Duration,
    /// Time when the queue is emptied next.
    look: Instant,
    /// Time when the newest messages are sent next.
    due: Instant,
    /// Absent until the vehicle has been heard.
    queue: Option<Arc<DropOldest<Received>>>,
    /// By sender and id: the newest message, the number received, and whether it was sent.
    newest: BTreeMap<(u8, u32), (Received, u64, bool)>,
}

impl MessageSubscription {
    /// Takes the received messages, and keeps the newest of each.
    fn look(&mut self, app: &App, vehicle: u16) {
        if self.queue.as_ref().is_none_or(|queue| queue.is_closed()) {
            let Some(handle) = app.station().vehicle(VehicleId::new(vehicle)) else { return };
            self.queue = Some(handle.subscribe_messages(self.ids.clone(), MESSAGE_QUEUE));
        }
        let Some(queue) = &self.queue else { return };
        for _ in 0..MESSAGE_QUEUE {
            let Taken::Item(received) = queue.take_ready() else { break };
            let key = (received.frame.source().component.0, received.frame.message_id());
            let has_room = self.newest.len() < MAX_MESSAGE_KINDS;
            match self.newest.get_mut(&key) {
                Some((newest, count, is_sent)) => (*newest, *count, *is_sent) = (received, *count + 1, false),
                None if has_room => {
                    self.newest.insert(key, (received, 1, false));
                }
                None => {}
            }
        }
    }
}

/// One client.
struct Client {
    app: App,
    session: SessionId,
    outbox: Arc<Outbox>,
    subscriptions: BTreeMap<u16, Subscription>,
    messages: BTreeMap<u16, MessageSubscription>,
    questions: Questions,
    /// The roster, and the rows that the client has.
    roster: Option<(watch::Receiver<Arc<Roster>>, SentRows)>,
    unanswered: u32,
    messages_in_interval: u32,
}

/// Sets limits for received and waiting bytes, which bound the memory for a client that does not read.
pub fn bounded(upgrade: WebSocketUpgrade, message_bytes: usize, sent_bytes: usize) -> WebSocketUpgrade {
    let upgrade = upgrade.max_message_size(message_bytes).max_frame_size(message_bytes);
    upgrade.max_write_buffer_size(MAX_WAITING_BYTES + sent_bytes)
}

/// Serves one client until it disconnects, is too slow, its session has ended, or the server is closed.
pub async fn serve(guard: SocketGuard, mut socket: WebSocket) {
    let SocketGuard(app, session) = &guard;
    let (app, session) = (app.clone(), *session);
    let outbox = app.outboxes().open();
    let mut client = Client {
        app,
        session,
        outbox,
        subscriptions: BTreeMap::new(),
        messages: BTreeMap::new(),
        questions: Questions::default(),
        roster: None,
        unanswered: 0,
        messages_in_interval: 0,
    };
    let end = client.run(&mut socket).await.unwrap_or_else(|end| end);
    // The grace period of the lease begins now, not when the closing handshake has timed out.
    drop(guard);
    tracing::debug!(%session, ?end, "a WebSocket ended");
    if let Some(frame) = end.frame() {
        // A client that does not read misses the reason, too.
        let _ = timeout(Duration::from_secs(1), socket.send(Message::Close(Some(frame)))).await;
    }
}

/// Counts a WebSocket towards its session's for as long as this lives.
pub struct SocketGuard(App, SessionId);

impl SocketGuard {
    /// Registers one more; `None` when the session, or all sessions of its role, are at their limit.
    pub fn open(app: App, session: SessionId) -> Option<Self> {
        let now = app.now();
        app.change_sessions(|sessions| sessions.open_socket(session, now)).then_some(Self(app, session))
    }
}

impl Drop for SocketGuard {
    fn drop(&mut self) {
        let now = self.0.now();
        self.0.change_sessions(|sessions| sessions.socket_closed(self.1, now));
    }
}

impl Client {
    async fn run(&mut self, socket: &mut WebSocket) -> Result<End, End> {
        let mut closing = self.app.closing();
        self.greet(socket).await?;
        let mut pings = pings();
        loop {
            self.send_waiting(socket).await?;
            let due = self.subscriptions.values().map(|subscription| subscription.due);
            let due = due.chain(self.messages.values().map(|subscription| subscription.look)).min();
            tokio::select! {
                () = closed(&mut closing) => return Ok(End::Closing),
                () = self.outbox.overflown() => return Ok(End::TooSlow),
                () = self.outbox.wait() => {}
                answer = self.questions.answered() => self.send(socket, Message::Text(answer)).await?,
                () = changed(self.roster.as_mut()) => self.send_roster(socket).await?,
                message = socket.recv() => match message {
                    Some(Ok(message)) => self.on_message(socket, message).await?,
                    Some(Err(_)) | None => return Ok(End::Gone),
                },
                _ = pings.tick() => {
                    if self.unanswered >= MAX_UNANSWERED {
                        return Ok(End::Silent);
                    }
                    self.unanswered += 1;
                    self.messages_in_interval = 0;
                    self.send(socket, Message::Ping(Vec::new().into())).await?;
                }
                () = sleep_until(due.unwrap_or_else(far)), if due.is_some() => {
                    self.send_telemetry(socket).await?;
                    self.send_messages(socket).await?;
                }
            }
        }
    }

    /// Sends what must not be lost: control, texts and events, lists and states.
    async fn send_waiting(&self, socket: &mut WebSocket) -> Result<(), End> {
        while let Some(outgoing) = self.outbox.take() {
            let text = match outgoing {
                Outgoing::Message(text) => text,
                Outgoing::Control => json(&self.control().ok_or(End::NoSession)?),
            };
            self.send(socket, Message::Text(text)).await?;
        }
        Ok(())
    }

    /// Sends telemetry, after everything that is waiting by then.
    async fn send_after_waiting(&self, socket: &mut WebSocket, texts: Vec<Utf8Bytes>) -> Result<(), End> {
        for text in texts {
            self.send_waiting(socket).await?;
            self.send(socket, Message::Text(text)).await?;
        }
        Ok(())
    }

    async fn greet(&self, socket: &mut WebSocket) -> Result<(), End> {
        let app = &self.app;
        let session = app.sessions().info(self.session).ok_or(End::NoSession)?;
        let hello =
            ServerMessage::Hello { version: crate::VERSION.to_owned(), time_s: convert::seconds(app.now()), session };
        let vehicles = ServerMessage::Vehicles { vehicles: convert::vehicle_summaries(app.station()) };
        let links = ServerMessage::Links { links: convert::links(app.station()) };
        let storage = ServerMessage::Storage { problems: app.storage_problems() };
        let networks = ServerMessage::Networks { networks: convert::networks(app.station()) };
        for message in [hello, vehicles, links, storage, networks] {
            self.send(socket, Message::Text(json(&message))).await?;
        }
        for operation in app.operations().list() {
            let message = ServerMessage::Operation(operation);
            self.send(socket, Message::Text(json(&message))).await?;
        }
        Ok(())
    }

    fn control(&self) -> Option<ServerMessage> {
        let info = self.app.sessions().info(self.session)?;
        let (has_control, holder, requested_by) = (info.has_control, info.holder, info.requested_by);
        Some(ServerMessage::Control { has_control, holder, requested_by })
    }

    /// Sends one message; fails when the client does not take it, or has become too slow for its events.
    async fn send(&self, socket: &mut WebSocket, message: Message) -> Result<(), End> {
        tokio::select! {
            sent = timeout(SEND_TIMEOUT, socket.send(message)) => match sent {
                Ok(Ok(())) => Ok(()),
                Ok(Err(_)) => Err(End::Gone),
                Err(_) => Err(End::TooSlow),
            },
            () = self.outbox.overflown() => Err(End::TooSlow),
        }
    }

    /// Counts messages of the client. A ping makes us answer, so it counts too.
    fn count_message(&mut self) -> Result<(), End> {
        self.messages_in_interval += 1;
        if self.messages_in_interval > MAX_MESSAGES_PER_S * PING_INTERVAL.as_secs() as u32 {
            return Err(End::Rude("too many messages"));
        }
        Ok(())
    }

    async fn on_message(&mut self, socket: &mut WebSocket, message: Message) -> Result<(), End> {
        self.unanswered = 0;
        self.count_message()?;
        let text = match message {
            Message::Text(text) => text,
            Message::Close(_) => return Err(End::Gone),
            Message::Binary(_) => return Err(End::Rude("messages are JSON texts")),
            Message::Ping(_) | Message::Pong(_) => return Ok(()),
        };
        let done = match serde_json::from_str(&text) {
            Ok(ClientMessage::Subscribe { vehicle, rate_hz }) => self.subscribe(vehicle, rate_hz),
            Ok(ClientMessage::Unsubscribe { vehicle }) => {
                self.subscriptions.remove(&vehicle);
                Ok(())
            }
            Ok(ClientMessage::SubscribeRoster) => {
                if self.roster.is_none() {
                    self.outbox.set_has_roster(true);
                    self.roster = Some((self.app.roster(), SentRows::default()));
                }
                Ok(())
            }
            Ok(ClientMessage::UnsubscribeRoster) => {
                self.outbox.set_has_roster(false);
                self.roster = None;
                Ok(())
            }
            Ok(ClientMessage::SubscribeMessages { vehicle, names, rate_hz }) => {
                self.subscribe_messages(vehicle, names.as_deref(), rate_hz)
            }
            Ok(ClientMessage::UnsubscribeMessages { vehicle }) => {
                self.messages.remove(&vehicle);
                Ok(())
            }
            Ok(ClientMessage::AssessPlan { seq, vehicle, plan, rehearse_in, clearance_m, profile }) => {
                let app = self.app.clone();
                self.questions.ask_assessment(async move {
                    let done = in_turn(move || assess(&app, vehicle, &plan, rehearse_in, clearance_m, &profile)).await;
                    answer(seq, done.map(|assessment| ServerMessage::Assessment { seq, assessment }))
                });
                Ok(())
            }
            Ok(ClientMessage::PlanWay { seq, vehicle, clearance_m, plan }) => {
                let app = self.app.clone();
                self.questions.ask_way(async move {
                    let done = quickly(move || laid_out(&app, vehicle, &plan, clearance_m)).await;
                    answer(seq, done.map(|way| ServerMessage::Way { seq, way }))
                });
                Ok(())
            }
            Err(error) => {
                let wrong = misread::in_words("", &error.to_string(), |name| misread::unit(name).map(str::to_owned));
                Err(Problem::invalid(format!("the message cannot be read: {wrong}")))
            }
        };
        match done {
            Ok(()) => Ok(()),
            Err(problem) => self.send(socket, Message::Text(json(&refusal(problem, None)))).await,
        }
    }

    /// Subscribes to a vehicle, or changes the rate.
    fn subscribe(&mut self, vehicle: u16, rate_hz: f64) -> Result<(), Problem> {
        let period = period_of(rate_hz)?;
        let is_new = !self.subscriptions.contains_key(&vehicle);
        if is_new && self.subscriptions.len() >= MAX_SUBSCRIPTIONS {
            let detail = format!("{MAX_SUBSCRIPTIONS} vehicles are subscribed to already; unsubscribe from one first");
            return Err(Problem::too_many(LimitKind::Subscriptions, MAX_SUBSCRIPTIONS, detail));
        }
        let due = Instant::now();
        let subscription = self.subscriptions.entry(vehicle).or_insert_with(|| Subscription {
            period,
            due,
            sent: Sent::default(),
            progress: None,
        });
        (subscription.period, subscription.due) = (period, due);
        Ok(())
    }

    /// Subscribes to raw messages of a vehicle, or changes the subscription.
    fn subscribe_messages(&mut self, vehicle: u16, names: Option<&[String]>, rate_hz: f64) -> Result<(), Problem> {
        let period = period_of(rate_hz)?;
        if !self.messages.contains_key(&vehicle) && self.messages.len() >= MAX_SUBSCRIPTIONS {
            let detail = format!("the messages of {MAX_SUBSCRIPTIONS} vehicles are subscribed to already");
            return Err(Problem::too_many(LimitKind::Subscriptions, MAX_SUBSCRIPTIONS, detail));
        }
        let id_of = |name: &String| message_id(name).map(|id| id.0);
        let ids = names.map(|names| names.iter().map(id_of).collect::<Result<BTreeSet<_>, _>>()).transpose()?;
        if ids.as_ref().is_some_and(|ids| ids.len() > MAX_MESSAGE_NAMES) {
            let detail =
                format!("at most {MAX_MESSAGE_NAMES} messages can be subscribed to by name; omit the names for all");
            return Err(Problem::too_many(LimitKind::Subscriptions, MAX_MESSAGE_NAMES, detail));
        }
        let now = Instant::now();
        let subscription =
            MessageSubscription { ids, period, look: now, due: now, queue: None, newest: BTreeMap::new() };
        self.messages.insert(vehicle, subscription);
        Ok(())
    }

    /// Sends the changes of the roster.
    async fn send_roster(&mut self, socket: &mut WebSocket) -> Result<(), End> {
        let Some((newest, sent)) = &mut self.roster else { return Ok(()) };
        let roster = newest.borrow_and_update().clone();
        let (rows, gone) = sent.changes(&roster);
        let station = self.app.station();
        let followed = self.subscriptions.keys().filter_map(|id| station.vehicle(VehicleId::new(*id)));
        let followed = followed.map(|vehicle| convert::vehicle_summary(&vehicle)).collect();
        let message = ServerMessage::Roster { time_s: roster.time_s, rows, gone, followed };
        self.send_after_waiting(socket, vec![json(&message)]).await
    }

    /// Takes the received raw messages, and sends the newest of those that are due.
    async fn send_messages(&mut self, socket: &mut WebSocket) -> Result<(), End> {
        let now = Instant::now();
        let mut texts = Vec::new();
        for (vehicle, subscription) in &mut self.messages {
            if subscription.look > now {
                continue;
            }
            subscription.look(&self.app, *vehicle);
            if subscription.due <= now {
                subscription.due = (subscription.due + subscription.period).max(now + subscription.period / 2);
                for (received, count, is_sent) in subscription.newest.values_mut().filter(|(_, _, is_sent)| !is_sent) {
                    *is_sent = true;
                    let message = convert::raw_message(&received.frame, received.at);
                    texts.push(json(&ServerMessage::Message { vehicle: *vehicle, count: *count, message }));
                }
            }
            subscription.look = subscription.due.min(now + LOOK_INTERVAL);
        }
        self.send_after_waiting(socket, texts).await
    }

    /// Sends the changes of every vehicle that is due.
    async fn send_telemetry(&mut self, socket: &mut WebSocket) -> Result<(), End> {
        let now = Instant::now();
        let mut texts = Vec::new();
        for (vehicle, subscription) in &mut self.subscriptions {
            if subscription.due > now {
                continue;
            }
            // Keeps the phase if possible; a client that was too slow misses a turn.
            subscription.due = (subscription.due + subscription.period).max(now + subscription.period / 2);
            let Some(handle) = self.app.station().vehicle(VehicleId::new(*vehicle)) else { continue };
            let (telemetry, taken_at) = handle.telemetry();
            let groups = TelemetryGroups::changes(&telemetry, taken_at, &mut subscription.sent);
            let progress = Some(convert::progress(&handle)).filter(|new| subscription.progress.as_ref() != Some(new));
            if groups.is_empty() && progress.is_none() {
                continue;
            }
            if progress.is_some() {
                subscription.progress.clone_from(&progress);
            }
            let time_s = convert::seconds(handle.station().now());
            texts.push(json(&ServerMessage::Telemetry { vehicle: *vehicle, time_s, groups, progress }));
        }
        self.send_after_waiting(socket, texts).await
    }
}

/// Answer to a request.
fn answer(seq: u64, done: Result<ServerMessage, Problem>) -> Utf8Bytes {
    let text = json(&done.unwrap_or_else(|problem| refusal(problem, Some(seq))));
    if text.len() <= MAX_SENT_BYTES {
        return text;
    }
    // Writing it would end the connection.
    json(&refusal(
        Problem::invalid(format!("the answer has {} bytes, too many: shorten the plan", text.len())),
        Some(seq),
    ))
}

fn refusal(problem: Problem, seq: Option<u64>) -> ServerMessage {
    let dto::Problem { detail, cause, .. } = *problem.0;
    ServerMessage::Error { detail, cause, seq }
}

/// Interval of a requested rate.
fn period_of(rate_hz: f64) -> Result<Duration, Problem> {
    if RATES_HZ.contains(&rate_hz) {
        return Ok(Duration::from_secs_f64(rate_hz.recip()));
    }
    Err(Problem::out_of_range("rate_hz", rate_hz, *RATES_HZ.start(), *RATES_HZ.end()))
}

/// Waits until the roster changes; pending without a subscription to it.
async fn changed(roster: Option<&mut (watch::Receiver<Arc<Roster>>, SentRows)>) {
    if let Some((newest, _)) = roster
        && newest.changed().await.is_ok()
    {
        return;
    }
    // An error means that the server is gone, which the main loop notices elsewhere.
    std::future::pending().await
}

/// A time that is never reached.
fn far() -> Instant {
    Instant::now() + Duration::from_secs(3600)
}

fn pings() -> Interval {
    let mut pings = interval(PING_INTERVAL);
    pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
    pings
}
