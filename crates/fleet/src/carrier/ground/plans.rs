//! The plans and lists of one aircraft, on the ground: shown as published, fetched when they are not cached.

use std::sync::{Arc, PoisonError};
use std::time::Duration;

use tokio::task::JoinSet;
use vencejo_flight::plan::{Mission, PlanKind};
use vencejo_station::{StationError, Telling};
use vencejo_vehicle::{PlanState, Unknown};
use zenoh::qos::Priority;

use super::super::network::{self, Replies};
use super::{FarAircraft, Fleet, READ_WITHIN};
use crate::content::{Content, Digest, unpack_items};
use crate::delivery::AGAIN_AFTER;
use crate::key::{Kind, key_of};
use crate::payload::BadPayload;
use crate::plans::{self, PlanTold};
use crate::pull::Pull;

/// The timeout of a list without progress.
const NOTHING_FOR: Duration = Duration::from_secs(30);
/// The pause before a plan that could not be fetched is fetched again.
const FETCH_AGAIN: Duration = Duration::from_secs(5);

impl FarAircraft {
    /// Processes the plans of a state.
    pub(super) fn on_plans(self: &Arc<Self>, fleet: &Arc<Fleet>, heard: plans::Freshness) {
        match heard {
            plans::Freshness::Nothing => {}
            plans::Freshness::News => self.show_plans(fleet),
            plans::Freshness::Missed => {
                if std::mem::replace(&mut self.known().is_asking_plans, true) {
                    return;
                }
                let (far, fleet) = (self.clone(), fleet.clone());
                tokio::spawn(async move {
                    far.ask_everything(&fleet).await;
                    far.known().is_asking_plans = false;
                });
            }
        }
    }

    /// Requests a complete state.
    pub(super) async fn ask_everything(self: &Arc<Self>, fleet: &Fleet) {
        let key = key_of(&fleet.org, &self.name, Kind::State);
        if let Replies::Answers(states) = network::ask(&fleet.session(), &key, Vec::new(), READ_WITHIN).await {
            states.iter().for_each(|state| self.on_state(state, false));
        }
    }

    /// Shows the plan states of the station on board. A plan is known here as soon as its list is here.
    pub(super) fn show_plans(self: &Arc<Self>, fleet: &Arc<Fleet>) {
        if self.known().id.is_none() {
            return;
        }
        for kind in PlanKind::ALL {
            let told = {
                let mut known = self.known();
                let told = known.plans.told(kind).cloned();
                if told.is_none() || known.plans_shown[kind as usize] == told {
                    continue;
                }
                known.plans_shown[kind as usize].clone_from(&told);
                told
            };
            let Some(told) = told else { continue };
            let Ok((_, state)) = told.read() else { continue };
            match self.list_here(&told) {
                Ok(list) => self.show_plan(fleet, kind, state, list),
                Err(content) => {
                    let differs = matches!(state, PlanState::Differs { .. });
                    let why = if differs { Unknown::TransferFailed } else { Unknown::NeverRead };
                    self.show_plan(fleet, kind, PlanState::Unknown(why), None);
                    let (far, fleet, wanted) = (self.clone(), fleet.clone(), told);
                    tokio::spawn(async move { far.fetch_plan(&fleet, kind, &wanted, &content).await });
                }
            }
        }
    }

    /// The list of a published plan, `None` for an empty plan; the content to fetch if it is not cached.
    fn list_here(&self, told: &PlanTold) -> Result<Option<Mission>, Content> {
        let Some(content) = &told.list else { return Ok(None) };
        let here = content.name().ok().and_then(|(name, _)| self.on_shelf(&name));
        here.and_then(|packed| unpack_items(&packed).ok()).map(Some).ok_or_else(|| content.clone())
    }

    pub(super) fn on_shelf(&self, name: &Digest) -> Option<Arc<[u8]>> {
        self.shelf.lock().unwrap_or_else(PoisonError::into_inner).get(name)
    }

    fn show_plan(&self, fleet: &Fleet, kind: PlanKind, state: PlanState, list: Option<Mission>) {
        let id = self.known().id;
        if let Some(id) = id {
            fleet.station.on_remote_plan(id, kind, state, list);
        }
    }

    /// Fetches a plan while it is the current one.
    async fn fetch_plan(self: &Arc<Self>, fleet: &Arc<Fleet>, kind: PlanKind, wanted: &PlanTold, content: &Content) {
        loop {
            let fetched = self.fetch(content, None).await;
            let is_wanted = self.known().plans.told(kind) == Some(wanted);
            if !is_wanted || self.fleet.upgrade().is_none() {
                return;
            }
            match fetched {
                Ok(packed) => match (unpack_items(&packed), wanted.read()) {
                    (Ok(list), Ok((_, state))) => return self.show_plan(fleet, kind, state, Some(list)),
                    _ => return tracing::warn!(aircraft = %self.name, %kind, "the plan on board cannot be read here"),
                },
                Err(error) => {
                    tracing::debug!(aircraft = %self.name, %kind, %error, "the plan on board was not fetched")
                }
            }
            tokio::time::sleep(FETCH_AGAIN).await;
        }
    }

    /// A list, cached or fetched.
    pub(super) async fn fetch(&self, content: &Content, telling: Option<&Telling>) -> Result<Arc<[u8]>, StationError> {
        let (name, length) = content.name().map_err(|error| self.unreadable(&error))?;
        if !content.here.is_empty() {
            self.shelf.lock().unwrap_or_else(PoisonError::into_inner).put(&content.here);
            return Ok(content.here.as_slice().into());
        }
        let _one = self.fetching.lock().await;
        if let Some(packed) = self.on_shelf(&name) {
            return Ok(packed);
        }
        let fleet = self.fleet.upgrade().ok_or(StationError::Closed)?;
        let mut pull = Pull::new(name, length);
        let mut asked = JoinSet::new();
        let mut heard_at = fleet.station.now();
        loop {
            while let Some(offset) = pull.next_piece() {
                let key = format!("{}?list={name};from={offset}", key_of(&fleet.org, &self.name, Kind::List));
                let (session, station) = (fleet.session(), fleet.station.clone());
                asked.spawn(async move {
                    let began = station.now();
                    let heard = network::ask_at(Priority::DataLow, &session, &key, Vec::new(), READ_WITHIN).await;
                    (offset, heard, station.now().since(began))
                });
            }
            let Some(Ok((offset, heard, took))) = asked.join_next().await else { return Err(StationError::Closed) };
            let now = fleet.station.now();
            match heard {
                Replies::Answers(answers) if answers.iter().all(Vec::is_empty) => {
                    return Err(self.refused("the list is not on board any more; read it again"));
                }
                Replies::Answers(answers) => {
                    let mut answers = answers.iter();
                    if answers.any(|piece| pull.on_piece(offset, piece, took).is_ok()) {
                        heard_at = now;
                        let (done, total) = pull.progress();
                        if let Some(telling) = telling {
                            telling(done, total);
                        }
                    }
                }
                Replies::Nobody | Replies::Silence => {
                    pull.on_silence(offset);
                    tokio::time::sleep(AGAIN_AFTER).await;
                }
            }
            if let Some(whole) = pull.whole() {
                let whole = whole.map_err(|error| self.unreadable(&error))?;
                self.shelf.lock().unwrap_or_else(PoisonError::into_inner).put(whole);
                return Ok(whole.into());
            }
            if now.since(heard_at) >= NOTHING_FOR {
                return Err(self.unreached());
            }
        }
    }

    pub(super) fn unreadable(&self, error: &BadPayload) -> StationError {
        self.refused(&format!("what it answered cannot be used: {error}"))
    }
}
