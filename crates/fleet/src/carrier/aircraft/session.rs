//! One session with a router: what an aircraft declares, publishes and answers, until it ends.

use std::sync::PoisonError;
use std::time::Duration;

use prost::Message;
use tokio::sync::mpsc;
use vencejo_proto::MonoTime;
use vencejo_station::{DropOldest, Received};
use zenoh::Session;
use zenoh::qos::Priority;

use super::place::Renewed;
use super::{AircraftStatus, Ended, Post, TICK};
use crate::authority::Authority;
use crate::budget::{Audience, Budget, ECHO_LOST};
use crate::carrier::endpoint::{Endpoint, Transport};
use crate::carrier::history::Board;
use crate::carrier::network;
use crate::error::FleetError;
use crate::key::{Kind, echo_key, key_of};
use crate::state_source::StateSource;

/// How often the router's and our own certificate are looked at.
const LOOK: Duration = Duration::from_secs(1);
/// Echoes lost in a row after which a session is reopened: one that looks alive may be dead.
const DEAD_AFTER: u32 = 30;
/// The same when there are other routers.
const DEAD_BESIDE_OTHERS: u32 = 8;
/// How long Zenoh may take to reconnect before another router is dialled.
const GONE_BESIDE_OTHERS: Duration = Duration::from_secs(1);
/// Echoes lost in a row after which it is reported: a router that does not know an aircraft does not answer.
const TELL_AFTER: u32 = 3;
/// What is reported then, of a router that is reached, and of one that is not.
const SILENT: &str = "it is reached and answers nothing: has this aircraft been revoked? see: vencejo fleet doctor";
const ENDED: &str = "the connection has ended and is dialled again: is `vencejo serve --fleet` running there?";

impl Post<'_> {
    /// Serves until the station is closed or the session is dead.
    pub(super) async fn serve(
        &mut self,
        session: &Session,
        source: &mut StateSource,
        authority: &mut Authority,
        heard: &DropOldest<Received>,
        has_others: bool,
    ) -> Result<Ended, FleetError> {
        let patience = if has_others { DEAD_BESIDE_OTHERS } else { DEAD_AFTER };
        let key = |kind| key_of(&self.config.org, &self.config.name, kind);
        let (state_key, event_key, list_key) = (key(Kind::State), key(Kind::Event), key(Kind::List));
        let declared = network::failed;
        let orders = session.declare_queryable(self.order_key.clone()).complete(true).await.map_err(declared)?;
        let states = session.declare_queryable(state_key.clone()).complete(true).await.map_err(declared)?;
        let events = session.declare_queryable(event_key.clone()).complete(true).await.map_err(declared)?;
        let lists = session.declare_queryable(list_key.clone()).complete(true).await.map_err(declared)?;
        let _answering = match self.history {
            Some(history) => Some(history.answer(session).await?),
            None => None,
        };
        let _token = session.liveliness().declare_token(key(Kind::Alive)).await.map_err(declared)?;
        // Reports whether there are subscribers. A router whose access control does not allow that is believed only
        // when no ground station answers echoes either.
        let voice = session.declare_publisher(state_key.clone()).await.map_err(declared)?;
        let hearers = voice.matching_listener().await.map_err(declared)?;
        let mut has_hearers = voice.matching_status().await.map_err(declared)?.matching();
        let mut is_with_since = self.station.now();
        let mut budget = Budget::new(self.config.uplink_bit_s, self.station.now());
        let (echoed, mut echoes) = mpsc::channel(4);
        let (mut sample_due, mut look_due, mut lost) = (MonoTime::ZERO, MonoTime::ZERO, 0);
        // Echoes lost in a row while the router was reached.
        let mut unanswered = 0;
        let mut asked_at = None;
        let (numbered, mut numbers) = mpsc::channel(4);
        let (renewed, mut renewals) = mpsc::channel(4);
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                _ = tick.tick() => {
                    let now = self.station.now();
                    for event in self.listen(source, heard) {
                        network::tell(session, &event_key, &event, Priority::InteractiveHigh).await;
                    }
                    if self.station.is_closed() {
                        return Ok(Ended::Closed);
                    }
                    self.holdings.look(self.vehicle);
                    authority.on_time(now);
                    self.keep_order(authority);
                    if session.info().links().await.next().is_some() {
                        is_with_since = now;
                    } else if has_others && now.since(is_with_since) >= GONE_BESIDE_OTHERS {
                        return Err(self.problem("it has gone"));
                    } else {
                        unanswered = 0;
                    }
                    let audience = match authority.lease() {
                        Some(_) => Audience::Holder,
                        None if has_hearers || lost < TELL_AFTER => Audience::List,
                        None => Audience::Nobody,
                    };
                    if now >= sample_due {
                        let state = self.sample(source, authority, audience);
                        budget.on_sample(state.encoded_len());
                        network::tell(session, &state_key, &state, Priority::Data).await;
                        sample_due = now + budget.interval(audience);
                    } else if lost >= TELL_AFTER || audience == Audience::Nobody {
                        self.unheard(source, authority);
                    }
                    if asked_at.is_none_or(|at| now.since(at) >= audience.echo_interval(lost > 0)) {
                        asked_at = Some(now);
                        self.ask_echo(session, echoed.clone(), numbered.clone());
                    }
                    if now >= look_due {
                        look_due = now + LOOK;
                        let is_encrypted = self.router.as_ref().is_some_and(|router| router.transport() != Transport::Tcp);
                        if is_encrypted && !network::is_with_station(session).await {
                            return Err(self.problem("who answers there now is not a router of this fleet"));
                        }
                        if let Some(place) = &mut self.place {
                            place.renew(&renewed, now);
                        }
                    }
                    let silent = match (lost, unanswered) {
                        (_, TELL_AFTER..) => Some(SILENT),
                        (TELL_AFTER.., _) => Some(ENDED),
                        _ => None,
                    };
                    self.show(authority, budget.rate_hz(audience), silent);
                }
                Some(renewed) = renewals.recv() => match (renewed, self.place.as_mut()) {
                    (Renewed::Certificate(member), Some(place)) => {
                        place.member = *member;
                        self.on_trust(authority);
                        return Ok(Ended::Renewed);
                    }
                    (Renewed::Stations(list), Some(place)) => {
                        if place.take(list) {
                            self.on_trust(authority);
                        }
                    }
                    (_, None) => {}
                },
                Some(number) = numbers.recv() => {
                    if let Some(place) = &mut self.place {
                        place.on_number(number, session, &self.config.org, &renewed, self.station.now());
                    }
                }
                Ok(status) = hearers.recv_async() => {
                    has_hearers = status.matching();
                    if has_hearers && lost >= TELL_AFTER {
                        // New subscribers get a state at once, and unanswered echoes say nothing about the uplink.
                        (sample_due, asked_at) = (MonoTime::ZERO, None);
                        budget = Budget::new(self.config.uplink_bit_s, self.station.now());
                    }
                }
                Ok(query) = orders.recv_async() => self.on_order(query, authority),
                Ok(query) = states.recv_async() => {
                    self.tell_silence(source);
                    let state = source.everything(authority.held(), self.station.now());
                    let state = self.holdings.dress(state, false);
                    network::reply(query, state_key.clone(), vec![state.encode_to_vec()]);
                }
                Ok(query) = events.recv_async() => {
                    let from = query.parameters().get("from").and_then(|from| from.parse().ok()).unwrap_or(1);
                    let kept = source.events_from(from).map(|event| event.encode_to_vec()).collect();
                    network::reply(query, event_key.clone(), kept);
                }
                Ok(query) = lists.recv_async() => self.holdings.on_asked(query, list_key.clone(), self.station),
                Some((claim, result)) = self.ends.recv() => {
                    // What the autopilot has said before is in the answer.
                    for event in self.listen(source, heard) {
                        network::tell(session, &event_key, &event, Priority::InteractiveHigh).await;
                    }
                    self.tell_silence(source);
                    let state = source.effects(authority.held(), self.station.now());
                    self.on_end(&claim, &result, &state, authority);
                }
                Some(took) = echoes.recv() => {
                    (lost, unanswered) = if took.is_some() { (0, 0) } else { (lost + 1, unanswered + 1) };
                    match took {
                        Some(took) => budget.on_echo(took, self.station.now()),
                        None => budget.on_echo_lost(),
                    }
                    if lost >= patience {
                        return Err(self.problem("it answers no more"));
                    }
                }
            }
        }
    }

    /// Measures the round trip to the router; ground stations reply with the number of their list of ground stations.
    fn ask_echo(&self, session: &Session, echoed: mpsc::Sender<Option<Duration>>, numbered: mpsc::Sender<u64>) {
        let (session, key, station) = (session.clone(), echo_key(&self.config.org), self.station.clone());
        tokio::spawn(async move {
            let began = station.now();
            // The channel is full only when the session has ended.
            let came = || {
                let _ = echoed.try_send(Some(station.now().since(began)));
            };
            let answers = network::echo(&session, &key, ECHO_LOST, came).await;
            if answers.is_empty() {
                let _ = echoed.try_send(None);
            }
            let number = |answer: Vec<u8>| Some(u64::from_be_bytes(answer.try_into().ok()?));
            if let Some(number) = answers.into_iter().filter_map(number).max() {
                let _ = numbered.try_send(number);
            }
        });
    }

    fn problem(&self, problem: &str) -> FleetError {
        let address = self.router.as_ref().map_or_else(String::new, Endpoint::to_string);
        FleetError::Network { address, problem: problem.to_owned() }
    }

    fn show(&self, authority: &Authority, rate_hz: f64, silent: Option<&str>) {
        let holder = Some(authority.held().holder).filter(|holder| !holder.is_empty());
        let certificate_ends = self.certificate_ends;
        let problem = silent.map(|silent| self.problem(silent).to_string());
        let problem = problem.or_else(|| self.history.and_then(Board::problem));
        let status = AircraftStatus { is_connected: true, problem, holder, rate_hz, certificate_ends, silence: None };
        *self.status.lock().unwrap_or_else(PoisonError::into_inner) = status;
    }
}
