//! Whether a ground station has a router that answers it.

use std::sync::{Arc, MutexGuard, PoisonError};
use std::time::Duration;

use vencejo_proto::MonoTime;
use vencejo_station::FarNetwork;
use vencejo_vehicle::telemetry::STALE_AFTER;
use zenoh::Session;

use super::super::membership::try_address;
use super::super::network;
use super::{Fleet, GroundStatus, Standing};
use crate::budget::ECHO_LOST;
use crate::error::FleetError;
use crate::key::echo_key;

/// How long a router may be missed before it is reported: it renews its session for each new member.
const MISSED_FOR: Duration = Duration::from_secs(5);
/// What a router that admits us no more looks like.
const SILENT: &str =
    "it is reached and answers nothing: has this ground station been revoked? see: vencejo fleet doctor";

/// What is known of it.
#[derive(Debug, Default)]
pub(super) struct Reach {
    /// Since when no router answers, and why the last time; `None` while one does.
    missed: Option<(MonoTime, String)>,
    /// Whether it is being looked for.
    is_looking: bool,
    /// Whether the fleet was left.
    has_left: bool,
}

impl Reach {
    pub(super) fn status(&self, now: MonoTime) -> GroundStatus {
        let missed = self.missed.as_ref().filter(|(since, _)| now.since(*since) >= MISSED_FOR);
        GroundStatus { is_connected: missed.is_none(), problem: missed.map(|(_, why)| why.clone()) }
    }
}

impl Fleet {
    pub(super) fn reach(&self) -> MutexGuard<'_, Reach> {
        self.reach.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A router answers, or why none does. What has changed is reported to the station.
    pub(super) fn on_reached(&self, problem: Option<String>) {
        let now = self.station.now();
        let status = {
            let mut reach = self.reach();
            if reach.has_left {
                return;
            }
            let since = reach.missed.take().map_or(now, |(since, _)| since);
            reach.missed = problem.map(|why| (since, why));
            reach.status(now)
        };
        self.station.on_network(FarNetwork { name: self.org.to_string(), problem: status.problem });
    }

    /// The fleet is left: nothing is reported any more.
    pub(super) fn on_left(&self) {
        self.reach().has_left = true;
        self.station.on_network_left(self.org.as_str());
    }

    /// Looks in a task of its own whether a router is there and answers.
    pub(super) fn look_for_router(self: &Arc<Self>, session: &Session, is_router: bool) {
        if is_router {
            return self.on_reached(None);
        }
        if std::mem::replace(&mut self.reach().is_looking, true) {
            return;
        }
        let (fleet, session) = (self.clone(), session.clone());
        tokio::spawn(async move {
            let problem = fleet.problem_of_router(&session).await;
            fleet.on_reached(problem);
            fleet.reach().is_looking = false;
        });
    }

    async fn problem_of_router(&self, session: &Session) -> Option<String> {
        let problem = |problem: &str| {
            let address = self.endpoint.to_string();
            Some(FleetError::Network { address, problem: problem.to_owned() }.to_string())
        };
        if session.info().links().await.next().is_none() {
            let tried = match self.network.identity().await {
                Some(identity) => try_address(&self.endpoint, &identity).await,
                None => Err("nobody answers there".to_owned()),
            };
            return problem(&tried.err().unwrap_or_else(|| "the connection has gone, and is opened again".to_owned()));
        }
        // Other stations answer an echo; with the authority this may be the only one.
        let is_member = matches!(self.network.standing, Standing::Member(_));
        if !is_member || self.hears_some() || network::is_answered(session, &echo_key(&self.org), ECHO_LOST).await {
            return None;
        }
        problem(SILENT)
    }

    fn hears_some(&self) -> bool {
        let now = self.station.now();
        self.aircraft().values().any(|far| {
            let known = far.known();
            known.id.is_some() && known.listener.age(now) < STALE_AFTER
        })
    }
}
