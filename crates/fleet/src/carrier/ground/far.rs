//! The states and events of a remote aircraft, passed on to the station.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use vencejo_proto::{Address, ComponentId, SystemId};
use vencejo_vehicle::VehicleId;
use zenoh::qos::Priority;

use super::super::network::{self, Replies};
use super::known::Known;
use super::{CONTROL_PATIENCE, FarAircraft, Fleet, READ_WITHIN};
use crate::key::{Kind, Name, key_of};
use crate::payload::{Event, State};
use crate::state_source::StateUpdate;

/// The priority of missed events: behind orders and new events, before states.
const ASKED_AT: Priority = Priority::DataHigh;
/// The pause before what is still missing is requested again.
const ASK_AGAIN: Duration = Duration::from_secs(1);

impl FarAircraft {
    /// An aircraft of which nothing is known yet.
    pub(super) fn new(name: Name, fleet: &Arc<Fleet>) -> Self {
        Self {
            name,
            fleet: Arc::downgrade(fleet),
            known: Mutex::default(),
            asking: tokio::sync::Mutex::default(),
            shelf: Mutex::default(),
            fetching: tokio::sync::Mutex::default(),
        }
    }

    pub(super) fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Processes a state: a published sample, or the reply to our query, which is not a sample of the series.
    pub(super) fn on_state(self: &Arc<Self>, bytes: &[u8], is_told: bool) {
        let Some(fleet) = self.fleet.upgrade() else { return };
        let state = match State::read(bytes) {
            Ok(state) => state,
            Err(error) => return tracing::warn!(aircraft = %self.name, %error, "what it says cannot be read"),
        };
        let now = fleet.station.now();
        if let Some(archive) = fleet.archive.as_ref().filter(|_| is_told) {
            archive.on_state(&self.name, &state, bytes, now);
        }
        let (news, plans) = {
            let mut known = self.known();
            let listener = &mut known.listener;
            let news = if is_told { listener.on_state(&state, now) } else { listener.on_everything(&state, now) };
            if listener.stamp().is_none_or(|(boot, _)| boot != state.boot) {
                // Of an earlier run, or of another computer.
                drop(known);
                return self.tell_rival(&fleet);
            }
            let system = u8::try_from(state.system).map_or(SystemId::BROADCAST, SystemId);
            let component = u8::try_from(state.component).map_or(ComponentId::AUTOPILOT, ComponentId);
            known.autopilot = Some(Address { system, component });
            known.forget_leases(now);
            known.on_held(&fleet.own);
            known.follow(&state.under_way, now);
            (news, known.plans.on_state(state.boot, state.plans_version, &state.plans))
        };
        self.tell(&fleet, news);
        self.on_plans(&fleet, plans);
        self.tell_rival(&fleet);
        self.yield_control(&fleet);
    }

    /// Gives control to the station that asks for it, if the operator here who has control is a program that yields.
    fn yield_control(self: &Arc<Self>, fleet: &Fleet) {
        let is_asked = {
            let mut known = self.known();
            !known.listener.held().asking.is_empty() && known.is_ours(&fleet.own)
        };
        if is_asked && fleet.station.control().yields() {
            let far = self.clone();
            tokio::spawn(async move {
                // It is asked for until it is given.
                let _ = far.release(CONTROL_PATIENCE).await;
            });
        }
    }

    /// Has the station show whether another computer uses this aircraft's name.
    fn tell_rival(&self, fleet: &Fleet) {
        let (id, until) = {
            let mut known = self.known();
            let until = known.listener.contested_until(fleet.station.now());
            if until.is_none() && !known.is_contested {
                return;
            }
            known.is_contested = until.is_some();
            (known.id, until)
        };
        if let Some(id) = id {
            fleet.station.on_remote_rival(id, until.map(|until| (format!("the fleet {}", fleet.org), until)));
        }
    }

    /// Shows the state that an answer has, before whoever gave the order is told of its end.
    pub(super) fn on_effects(self: &Arc<Self>, state: &State) {
        let Some(fleet) = self.fleet.upgrade() else { return };
        let news = self.known().listener.on_effects(state, fleet.station.now());
        self.tell(&fleet, news);
    }

    pub(super) fn on_event(self: &Arc<Self>, bytes: &[u8]) {
        let Some(fleet) = self.fleet.upgrade() else { return };
        let Ok(event) = Event::read(bytes) else { return };
        if let Some(archive) = &fleet.archive {
            archive.on_event(&self.name, &event, bytes);
        }
        let news = self.known().listener.on_event(&event, fleet.station.now());
        self.tell(&fleet, news);
    }

    /// Passes the news on to the station, and fetches what was missed.
    fn tell(self: &Arc<Self>, fleet: &Arc<Fleet>, news: StateUpdate) {
        if let Some(id) = self.adopted(fleet)
            && !fleet.station.on_remote(id, &news.said)
        {
            // It had made room for another vehicle; its next state has it adopted again.
            self.known().id = None;
        }
        {
            let mut known = self.known();
            let lacks = news.missed_from.is_some() || known.listener.lacks_some(fleet.station.now());
            if !lacks || std::mem::replace(&mut known.is_catching_up, true) {
                return;
            }
        }
        let far = self.clone();
        tokio::spawn(async move {
            far.catch_up(news.missed_from).await;
            // What is still missing is requested with its next state.
            tokio::time::sleep(ASK_AGAIN).await;
            far.known().is_catching_up = false;
        });
    }

    /// Requests everything, if samples were lost; and the events from a number on, until none is missing or nothing
    /// comes.
    async fn catch_up(self: &Arc<Self>, mut missing: Option<u64>) {
        let Some(fleet) = self.fleet.upgrade() else { return };
        let lacks_some = self.known().listener.lacks_some(fleet.station.now());
        if lacks_some {
            self.ask_everything(&fleet).await;
        }
        while let Some(from) = missing {
            let key = format!("{}?from={from}", key_of(&fleet.org, &self.name, Kind::Event));
            let heard = network::ask_at(ASKED_AT, &fleet.session(), &key, Vec::new(), READ_WITHIN).await;
            let Replies::Answers(events) = heard else { return };
            let events = events.iter().filter_map(|bytes| Event::read(bytes).ok()).collect();
            let (id, said) = {
                let mut known = self.known();
                let said = known.listener.on_events(events, fleet.station.now());
                missing = known.listener.missing().filter(|next| *next != from);
                (known.id, said)
            };
            if let Some(id) = id {
                fleet.station.on_remote(id, &said);
            }
        }
    }

    /// Its id in our station, which adopts it with its first state.
    fn adopted(self: &Arc<Self>, fleet: &Fleet) -> Option<VehicleId> {
        let (id, autopilot) = {
            let known = self.known();
            (known.id, known.autopilot)
        };
        if id.is_some() {
            return id;
        }
        let id = fleet.station.adopt(self.name.as_str(), autopilot?, self.clone())?;
        self.known().id = Some(id);
        Some(id)
    }
}
