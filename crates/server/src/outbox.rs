//! Messages waiting for the WebSocket clients, in a bounded outbox for each: of lists and states only the newest; texts
//! and events all, or the connection is closed.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use axum::extract::ws::Utf8Bytes;
use tokio::sync::Notify;

use vencejo_vehicle::ParamName;

use crate::dto::{PlanKind, ServerMessage};

/// Largest number of texts and events waiting for one client, some of each of a thousand vehicles. One more closes its
/// connection; the client reads them again after reconnecting.
pub const MAX_EVENTS: usize = 4096;
/// Largest number of lists and states waiting for one client; one more closes its connection.
pub const MAX_TOPICS: usize = 8192;

/// A kind of message of which only the newest matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    /// The list of vehicles.
    Vehicles,
    /// State of a plan on board: vehicle and plan.
    PlanState(u16, u8),
    /// A parameter of a vehicle.
    Param(u16, ParamName),
    /// An operation by id.
    Operation(u64),
    /// The list of links.
    Links,
    /// The networks of fleets.
    Networks,
    /// Map sources and offline areas.
    Maps,
    /// Storage faults.
    Storage,
    /// The draft of the plan.
    Draft,
}

impl Topic {
    /// Topic of a plan on board.
    pub fn plan_state(vehicle: u16, kind: PlanKind) -> Self {
        Self::PlanState(vehicle, kind as u8)
    }
}

/// A message to send.
#[derive(Debug, Clone, PartialEq)]
pub enum Outgoing {
    /// Control state: differs between clients, so it is composed when sent.
    Control,
    /// A message.
    Message(Utf8Bytes),
}

#[derive(Debug, Default)]
struct State {
    control: bool,
    latest: BTreeMap<Topic, Utf8Bytes>,
    events: VecDeque<Utf8Bytes>,
    has_overflown: bool,
}

/// Messages waiting for one client.
#[derive(Debug, Default)]
pub struct Outbox {
    state: Mutex<State>,
    /// Whether its client is subscribed to the roster in place of the list of vehicles.
    has_roster: AtomicBool,
    news: Notify,
    overflow: Notify,
}

impl Outbox {
    /// Next message: control, then events in order, then the rest.
    pub fn take(&self) -> Option<Outgoing> {
        let mut state = self.lock();
        if std::mem::take(&mut state.control) {
            return Some(Outgoing::Control);
        }
        let event = state.events.pop_front();
        event.or_else(|| state.latest.pop_first().map(|(_, message)| message)).map(Outgoing::Message)
    }

    /// Switches between the roster and the list of vehicles.
    pub fn set_has_roster(&self, has_roster: bool) {
        self.has_roster.store(has_roster, Ordering::Relaxed);
        if has_roster {
            self.lock().latest.remove(&Topic::Vehicles);
        }
    }

    /// Waits until there may be a message to take.
    pub async fn wait(&self) {
        self.news.notified().await;
    }

    /// Waits until the client has been too slow for its events.
    pub async fn overflown(&self) {
        loop {
            let notified = self.overflow.notified();
            if self.lock().has_overflown {
                return;
            }
            notified.await;
        }
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.lock();
        if state.has_overflown {
            return;
        }
        change(&mut state);
        if state.events.len() > MAX_EVENTS || state.latest.len() > MAX_TOPICS {
            *state = State { has_overflown: true, ..State::default() };
            self.overflow.notify_one();
        }
        drop(state);
        self.news.notify_one();
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Outboxes of all clients. Adding a message never blocks.
#[derive(Debug, Default)]
pub struct Outboxes {
    boxes: Mutex<Vec<Weak<Outbox>>>,
}

impl Outboxes {
    /// Opens an outbox for a new client; it is removed when the client drops it.
    pub fn open(&self) -> Arc<Outbox> {
        let outbox = Arc::new(Outbox::default());
        self.lock().push(Arc::downgrade(&outbox));
        outbox
    }

    /// Whether any client receives the list of vehicles.
    pub fn has_listed(&self) -> bool {
        self.open_boxes().iter().any(|outbox| !outbox.has_roster.load(Ordering::Relaxed))
    }

    /// Replaces the list of vehicles, for the clients that receive it.
    pub fn put_vehicles(&self, message: &ServerMessage) {
        let text = json(message);
        for outbox in self.open_boxes().iter().filter(|outbox| !outbox.has_roster.load(Ordering::Relaxed)) {
            outbox.change(|state| drop(state.latest.insert(Topic::Vehicles, text.clone())));
        }
    }

    /// Replaces the waiting message of a topic.
    pub fn put_latest(&self, topic: Topic, message: &ServerMessage) {
        self.each(message, |state, text| {
            state.latest.insert(topic, text);
        });
    }

    /// Adds a text or event.
    pub fn put_event(&self, message: &ServerMessage) {
        self.each(message, |state, text| state.events.push_back(text));
    }

    /// Sends the control state to all clients.
    pub fn put_control(&self) {
        for outbox in self.open_boxes() {
            outbox.change(|state| state.control = true);
        }
    }

    /// Number of clients.
    pub fn count(&self) -> usize {
        self.open_boxes().len()
    }

    fn each(&self, message: &ServerMessage, put: impl Fn(&mut State, Utf8Bytes)) {
        let open = self.open_boxes();
        if open.is_empty() {
            return;
        }
        let text = json(message);
        for outbox in open {
            outbox.change(|state| put(state, text.clone()));
        }
    }

    fn open_boxes(&self) -> Vec<Arc<Outbox>> {
        let mut boxes = self.lock();
        boxes.retain(|outbox| outbox.strong_count() > 0);
        boxes.iter().filter_map(Weak::upgrade).collect()
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Weak<Outbox>>> {
        self.boxes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Serializes a message. Its types contain nothing that JSON cannot represent.
pub fn json(message: &ServerMessage) -> Utf8Bytes {
    serde_json::to_string(message).expect("invariant: the API's types are JSON").into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dto::Text;

    fn text(number: u32) -> ServerMessage {
        let text = Text { time_s: 0.0, unix_s: None, severity: 6, text: number.to_string() };
        ServerMessage::Text { vehicle: 1, text }
    }

    fn links(_: u32) -> ServerMessage {
        ServerMessage::Links { links: Vec::new() }
    }

    fn taken(outbox: &Outbox) -> Vec<String> {
        std::iter::from_fn(|| outbox.take())
            .map(|outgoing| match outgoing {
                Outgoing::Control => "control".to_owned(),
                Outgoing::Message(text) => {
                    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
                    let text = value["text"].as_str().or(value["type"].as_str());
                    text.expect("a text or type").to_owned()
                }
            })
            .collect()
    }

    #[test]
    fn of_states_the_newest_and_of_events_all_in_order() {
        let boxes = Outboxes::default();
        let outbox = boxes.open();
        for number in 0..100 {
            boxes.put_latest(Topic::Links, &links(number));
        }
        boxes.put_event(&text(1));
        boxes.put_event(&text(2));
        boxes.put_control();
        assert_eq!(taken(&outbox), ["control", "1", "2", "links"]);
        assert_eq!(outbox.take(), None);
    }

    #[tokio::test]
    async fn a_client_that_is_too_slow_is_told_so_and_the_others_get_everything() {
        let boxes = Outboxes::default();
        let (slow, quick) = (boxes.open(), boxes.open());
        let mut heard = 0;
        for number in 0..=MAX_EVENTS as u32 {
            boxes.put_event(&text(number));
            heard += taken(&quick).len();
        }
        slow.overflown().await;
        assert_eq!(slow.take(), None, "nothing is kept for it");
        assert_eq!(heard, MAX_EVENTS + 1);
    }

    #[test]
    fn a_client_that_went_is_forgotten() {
        let boxes = Outboxes::default();
        let outbox = boxes.open();
        assert_eq!(boxes.count(), 1);
        drop(outbox);
        assert_eq!(boxes.count(), 0);
    }
}
