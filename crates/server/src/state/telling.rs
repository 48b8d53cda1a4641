//! Messages that clients receive without asking.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::watch;
use tokio::task::AbortHandle;
use tokio::time::{MissedTickBehavior, interval};
use vencejo_flight::plan::PlanKind;
use vencejo_maps::Maps;
use vencejo_station::{Observed, VehicleHandle};
use vencejo_vehicle::{VehicleEvent, VehicleId};

use super::{Alive, App, closed};
use crate::convert;
use crate::dto::storage::StorageProblem;
use crate::dto::{EventDetail, Operation, ServerMessage};
use crate::outbox::Topic;
use crate::roster::Roster;
use crate::terrain;

/// Interval at which leases and the list of vehicles are checked.
const TICK: Duration = Duration::from_millis(200);
/// Ticks between lists that are sent although nothing changed.
const TELL_EVERY: u32 = 5;
/// Minimum interval between notices that maps have changed.
const TELL_MAPS: Duration = Duration::from_secs(1);
/// Most queued events of one vehicle; the oldest are dropped.
const EVENT_QUEUE: usize = 1024;

impl App {
    /// Sends news to the clients until the server is closed.
    pub async fn tell(self, _alive: Alive) {
        let mut closing = self.closing();
        let mut followed: BTreeMap<VehicleId, AbortHandle> = BTreeMap::new();
        let mut ticks = interval(TICK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut count = 0_u32;
        let mut control = self.shared.station.control().news();
        let mut networks = self.shared.station.networks();
        loop {
            tokio::select! {
                () = closed(&mut closing) => break,
                Ok(()) = control.changed() => {
                    self.shared.outboxes.put_control();
                    continue;
                }
                Ok(()) = networks.changed() => {
                    let networks = convert::networks(&self.shared.station);
                    self.shared.outboxes.put_latest(Topic::Networks, &ServerMessage::Networks { networks });
                    continue;
                }
                _ = ticks.tick() => {}
            }
            let now = self.now();
            self.change_sessions(|sessions| sessions.expire(now));
            let vehicles = self.shared.station.shown_vehicles();
            let came_or_went = self.follow_vehicles(&vehicles, &mut followed);
            if came_or_went || count.is_multiple_of(TELL_EVERY) {
                let (app, is_due) = (self.clone(), count.is_multiple_of(TELL_EVERY));
                // A thousand vehicles take milliseconds, which must not delay anything else. A join error would be a
                // panic that was already reported.
                let _ = tokio::task::spawn_blocking(move || app.tell_vehicles(&vehicles, is_due)).await;
            }
            if count.is_multiple_of(TELL_EVERY) {
                let links = convert::links(&self.shared.station);
                self.shared.outboxes.put_latest(Topic::Links, &ServerMessage::Links { links });
            }
            count = count.wrapping_add(1);
        }
        for task in followed.into_values() {
            task.abort();
        }
        if self.is_on_board() {
            self.shared.station.set_heartbeat(false);
        }
    }

    /// Sends the vehicles to clients that show the list or the roster.
    fn tell_vehicles(&self, vehicles: &[VehicleHandle], is_due: bool) {
        if self.shared.outboxes.has_listed() {
            let vehicles = vehicles.iter().map(convert::vehicle_summary).collect();
            self.shared.outboxes.put_vehicles(&ServerMessage::Vehicles { vehicles });
        }
        if self.shared.roster.receiver_count() > 0 {
            let roster = if is_due {
                Roster::now(self.station())
            } else {
                self.shared.roster.borrow().with_newcomers(vehicles, self.now())
            };
            self.shared.roster.send_replace(Arc::new(roster));
        }
    }

    /// The roster, and its changes.
    pub fn roster(&self) -> watch::Receiver<Arc<Roster>> {
        let mut newest = self.shared.roster.subscribe();
        let (age_s, is_empty) = {
            let roster = newest.borrow();
            (convert::seconds(self.now()) - roster.time_s, roster.is_empty())
        };
        // If it has no recent reader it is outdated: it is rebuilt, once for all clients that come meanwhile.
        if is_empty || age_s > (TICK * TELL_EVERY).as_secs_f64() {
            self.shared.roster.send_replace(Arc::new(Roster::now(self.station())));
        } else {
            newest.mark_changed();
        }
        newest
    }

    /// Notifies clients of changed maps, until the server is closed.
    pub async fn tell_maps(self, maps: Maps, _alive: Alive) {
        let (mut news, mut closing) = (maps.news(), self.closing());
        let tell = async {
            while news.changed().await.is_ok() {
                self.shared.outboxes.put_latest(Topic::Maps, &ServerMessage::Maps);
                tokio::time::sleep(TELL_MAPS).await;
            }
        };
        tokio::select! {
            () = tell => {}
            () = closed(&mut closing) => {}
        }
    }

    /// Stores the storage faults and notifies clients when they change.
    pub fn tell_storage_problems(&self, problems: Vec<StorageProblem>) {
        let is_other = self.shared.storage.send_if_modified(|known| {
            let is_other = *known != problems;
            if is_other {
                known.clone_from(&problems);
            }
            is_other
        });
        if is_other {
            self.shared.outboxes.put_latest(Topic::Storage, &ServerMessage::Storage { problems });
        }
    }

    /// Subscribes to new vehicles and drops those that are gone. Returns whether there were any.
    fn follow_vehicles(&self, vehicles: &[VehicleHandle], followed: &mut BTreeMap<VehicleId, AbortHandle>) -> bool {
        let before = followed.len();
        let there: BTreeSet<_> = vehicles.iter().map(VehicleHandle::id).collect();
        followed.retain(|id, task| {
            let stays = there.contains(id) && !task.is_finished();
            if !stays {
                task.abort();
            }
            stays
        });
        let mut changed = followed.len() != before;
        for vehicle in vehicles {
            if followed.contains_key(&vehicle.id()) {
                continue;
            }
            changed = true;
            let (queue, asked) = (vehicle.subscribe_events(EVENT_QUEUE), terrain::listen(vehicle));
            let (app, vehicle) = (self.clone(), vehicle.clone());
            let id = vehicle.id();
            let task = tokio::spawn(async move {
                let tell = async {
                    while let Some(observed) = queue.take().await {
                        app.tell_event(&vehicle, &observed);
                    }
                };
                tokio::join!(tell, terrain::serve(app.maps().ok(), &vehicle, &asked));
            });
            followed.insert(id, task.abort_handle());
        }
        changed
    }

    fn tell_event(&self, vehicle: &VehicleHandle, observed: &Observed) {
        let (system, time_s) = (vehicle.id().number(), convert::seconds(observed.at));
        let outboxes = &self.shared.outboxes;
        let text = |text: String| EventDetail::Text(text);
        let item = |seq| vehicle.item_of_seq(seq).map(|item| ("item", EventDetail::Number(item.into())));
        let (kind, detail): (_, BTreeMap<_, _>) = match &observed.event {
            VehicleEvent::Text(words) => {
                let mut text = convert::text(vehicle, words.clone());
                if !vehicle.is_recorded() {
                    text.time_s = time_s;
                }
                outboxes.put_event(&ServerMessage::Text { vehicle: system, text });
                return;
            }
            VehicleEvent::PlanStateChanged { kind, state } => {
                self.tell_plan_state(system, *kind, convert::plan_state(Some(*state)));
                return;
            }
            VehicleEvent::ParamChanged(param) => {
                let message = ServerMessage::Param { vehicle: system, param: convert::param(param) };
                outboxes.put_latest(Topic::Param(system, param.name), &message);
                return;
            }
            VehicleEvent::Lost => ("lost", BTreeMap::new()),
            VehicleEvent::Regained => ("regained", BTreeMap::new()),
            VehicleEvent::Unreached => ("unreached", BTreeMap::new()),
            VehicleEvent::Reached => ("reached", BTreeMap::new()),
            VehicleEvent::Rebooted => ("rebooted", BTreeMap::new()),
            VehicleEvent::ModeChanged { from, to } => {
                let from = from.map(|from| ("from", text(from.to_string())));
                ("mode", from.into_iter().chain([("mode", text(to.to_string()))]).collect())
            }
            VehicleEvent::ArmedChanged { is_armed } => (if *is_armed { "armed" } else { "disarmed" }, BTreeMap::new()),
            VehicleEvent::LandedChanged { landed } => {
                ("landed", BTreeMap::from([("landed", text(landed.to_string()))]))
            }
            VehicleEvent::CurrentItemChanged { seq } => ("item", item(*seq).into_iter().collect()),
            VehicleEvent::ItemReached { seq } => ("item_reached", item(*seq).into_iter().collect()),
            VehicleEvent::MissionComplete => ("mission_complete", BTreeMap::new()),
            VehicleEvent::TargetElsewhere { seq, distance_m } => {
                let distance = ("distance_m", EventDetail::Number(distance_m.round() as u32));
                ("target_elsewhere", item(*seq).into_iter().chain([distance]).collect())
            }
            VehicleEvent::TargetAsPlanned { seq } => ("target_as_planned", item(*seq).into_iter().collect()),
            VehicleEvent::HomeChanged => ("home", BTreeMap::new()),
            VehicleEvent::StreamsFellBack => ("streams_fell_back", BTreeMap::new()),
            VehicleEvent::Contested => ("contested", BTreeMap::new()),
            VehicleEvent::Uncontested => ("uncontested", BTreeMap::new()),
            VehicleEvent::TerrainUnknown => ("terrain_unknown", BTreeMap::new()),
            VehicleEvent::TerrainKnown => ("terrain_known", BTreeMap::new()),
            _ => return,
        };
        outboxes.put_event(&ServerMessage::Event { vehicle: system, kind: kind.to_owned(), detail, time_s });
    }

    fn tell_plan_state(&self, vehicle: u16, kind: PlanKind, state: crate::dto::PlanState) {
        let kind = convert::plan_kind(kind);
        let message = ServerMessage::PlanState { vehicle, kind, state };
        self.shared.outboxes.put_latest(Topic::plan_state(vehicle, kind), &message);
    }

    pub(super) fn tell_operation(&self, operation: &Operation) {
        let topic = Topic::Operation(operation.id);
        self.shared.outboxes.put_latest(topic, &ServerMessage::Operation(operation.clone()));
    }
}
