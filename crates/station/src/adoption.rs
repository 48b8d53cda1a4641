//! Adopting remote vehicles: their messages come in one by one, requests to them go out whole.

use std::sync::Arc;

use tokio::sync::watch;
use vencejo_flight::plan::{Mission, PlanKind};
use vencejo_proto::{Address, Header, MavVersion, Message, MonoTime};
use vencejo_vehicle::{Param, PlanState, Vehicle, VehicleError, VehicleId};

use crate::error::StationError;
use crate::pending::Pending;
use crate::remote::{Adopted, Carried, FarNetwork, Remote, Telling};
use crate::station::{RequestResult, Shared, Station, VehicleHandle};

impl Station {
    /// Adopts a remote vehicle whose autopilot has this address on board. It gets an id from 256 up, derived from its
    /// name ([`VehicleId::of_name`]): many have the same system id, and a vehicle at a link must keep its own. A
    /// vehicle known by that name keeps its id. `None`: the limit of remote vehicles is reached, or the station is
    /// closed.
    pub fn adopt(&self, name: &str, autopilot: Address, remote: Arc<dyn Remote>) -> Option<VehicleId> {
        let now = self.now();
        let mut core = self.shared.core();
        if self.is_closed() {
            return None;
        }
        if let Some((id, adopted)) = core.adopted.iter_mut().find(|(_, adopted)| *adopted.name == *name) {
            adopted.remote = remote;
            return Some(*id);
        }
        let id = core.vehicles.host(autopilot, name, now)?;
        core.adopted.insert(id, Adopted { name: name.into(), remote, said_at: MonoTime::ZERO, shown: None });
        self.shared.settle(&mut core, now);
        Some(id)
    }

    /// Messages of a remote vehicle, with their times. `false`: it is no longer known; adopt it again.
    pub fn on_remote(&self, id: VehicleId, said: &[(Message, MonoTime)]) -> bool {
        let now = self.now();
        let mut core = self.shared.core();
        let Some(adopted) = core.adopted.get_mut(&id) else { return false };
        // A vehicle's time does not go back, whatever the network does.
        let (began, last) = (adopted.said_at, said.iter().map(|(_, at)| *at).max());
        adopted.said_at = began.max(last.unwrap_or(began));
        let Some(address) = core.vehicles.get(id).map(Vehicle::address) else { return false };
        for (message, at) in said {
            match message {
                // It may have been written long ago, and says nothing about the present.
                Message::StatusText(text) => {
                    if let Some(vehicle) = core.vehicles.get_mut(id) {
                        vehicle.on_text_told(text, (*at).min(now), now);
                    }
                }
                _ => {
                    core.vehicles.on_hosted(id, message, (*at).clamp(began, now.max(began)));
                }
            }
        }
        if let Some(watchers) = core.watchers.get(&id) {
            // Only its own subscribers: its address on board does not distinguish it from other vehicles.
            if watchers.subscriptions.has_readers() {
                let header = Header { sequence: 0, source: address, version: MavVersion::V2 };
                for (message, at) in said {
                    watchers.subscriptions.on_message(None, &message.encode(header), *at);
                }
            }
            watchers.changes.notify();
        }
        self.shared.greet(&mut core, id);
        self.shared.settle(&mut core, now);
        true
    }

    /// Another computer uses the name of a remote vehicle: its place in words, and until when it counts as present;
    /// `None`: no longer.
    pub fn on_remote_rival(&self, id: VehicleId, rival: Option<(String, MonoTime)>) {
        self.shared.on_far_rival(id, rival);
    }

    /// A station on board reports the state of a remote vehicle's plan, with its items where they are known and not
    /// empty.
    pub fn on_remote_plan(&self, id: VehicleId, kind: PlanKind, state: PlanState, list: Option<Mission>) {
        self.on_remote_told(id, |vehicle| vehicle.on_plan_told(kind, state, list));
    }

    /// Parameters of a remote vehicle that its station on board has read.
    pub fn on_remote_parameters(&self, id: VehicleId, params: &[Param]) {
        self.on_remote_told(id, |vehicle| vehicle.on_parameters_told(params));
    }

    /// Reports the state of a fleet's network, over which remote vehicles are heard. Networks stay in the order in which
    /// they were first reported.
    pub fn on_network(&self, network: FarNetwork) {
        self.shared.networks.send_if_modified(|networks| {
            match networks.iter_mut().find(|known| known.name == network.name) {
                Some(known) if *known == network => return false,
                Some(known) => *known = network,
                None => networks.push(network),
            }
            true
        });
    }

    /// The station is no longer in that fleet.
    pub fn on_network_left(&self, name: &str) {
        self.shared.networks.send_modify(|networks| networks.retain(|network| network.name != name));
    }

    /// The networks of the fleets that this station is in, and their changes.
    pub fn networks(&self) -> watch::Receiver<Vec<FarNetwork>> {
        self.shared.networks.subscribe()
    }

    fn on_remote_told(&self, id: VehicleId, tell: impl FnOnce(&mut Vehicle)) {
        let now = self.now();
        let mut core = self.shared.core();
        if !core.adopted.contains_key(&id) {
            return;
        }
        if let Some(vehicle) = core.vehicles.get_mut(id) {
            tell(vehicle);
        }
        if let Some(watchers) = core.watchers.get(&id) {
            watchers.changes.notify();
        }
        self.shared.settle(&mut core, now);
    }
}

impl VehicleHandle {
    /// Its name, if it is remote: reached by a station on board and by no link of this station.
    pub fn remote_name(&self) -> Option<String> {
        self.station.shared.core().adopted.get(&self.id).map(|adopted| adopted.name.to_string())
    }
}

impl Shared {
    /// What carries requests to a vehicle, if it is remote.
    pub(crate) fn remote(&self, id: VehicleId) -> Option<Arc<dyn Remote>> {
        self.core().adopted.get(&id).map(|adopted| adopted.remote.clone())
    }

    /// Starts a request to a remote vehicle.
    pub(crate) fn carry(self: &Arc<Self>, start: impl FnOnce(Telling) -> Carried) -> Pending<RequestResult> {
        let (tell, mut told) = watch::channel((0, 0));
        let mut carried = start(Arc::new(move |done, total| {
            // The receiver may be gone when it has ended.
            let _ = tell.send((done, total));
        }));
        let (cancel, mut cancelled) = watch::channel(false);
        let (finisher, pending) = Pending::new(move || {
            cancel.send_replace(true);
        });
        let mut closing = self.closing();
        self.runtime().spawn(async move {
            let end = loop {
                tokio::select! {
                    end = &mut carried => break end,
                    Ok(()) = told.changed() => {
                        let (done, total) = *told.borrow_and_update();
                        finisher.progress(done, total);
                    }
                    // An error means that it can no longer be cancelled, which does not end it.
                    Ok(_) = cancelled.wait_for(|cancelled| *cancelled) => break Err(VehicleError::Cancelled.into()),
                    _ = closing.wait_for(|closing| *closing) => break Err(StationError::Closed),
                }
            };
            drop(carried);
            finisher.finish(end);
        });
        pending
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Mutex, PoisonError};
    use std::time::Duration;

    use tokio::runtime::Handle;
    use vencejo_flight::plan::MissionItem;
    use vencejo_link::{Clock, LinkId, Origin, PeerId, SystemClock};
    use vencejo_proto::dialect::{MISSION_CURRENT_DATA, MavMessage};
    use vencejo_proto::{ComponentId, Heartbeat, StatusText, SystemId};
    use vencejo_vehicle::telemetry::Severity;
    use vencejo_vehicle::{Danger, ParamName, ParamValue, Reply, Request, VehicleEvent};

    use super::*;
    use crate::{FarHeld, FarWish, StationConfig, Taken};

    const OWN: Address = Address::new(1, 1);

    /// Carries everything but a landing, for which it waits for ever.
    #[derive(Default)]
    struct Far(Mutex<Vec<(Request, Option<Danger>, String)>>);

    impl Remote for Far {
        fn request(
            self: Arc<Self>,
            request: Request,
            confirmed: Option<Danger>,
            operator: String,
            telling: Telling,
        ) -> Carried {
            telling(1, 4);
            let is_endless = request == Request::Land;
            self.0.lock().unwrap_or_else(PoisonError::into_inner).push((request, confirmed, operator));
            Box::pin(async move { if is_endless { std::future::pending().await } else { Ok(Reply::Done) } })
        }

        fn control(self: Arc<Self>, _: FarWish, _: String) -> Carried {
            Box::pin(std::future::ready(Ok(Reply::Done)))
        }

        fn held(&self) -> FarHeld {
            FarHeld { holder: Some("Ana".into()), is_ours: true, ..FarHeld::default() }
        }
    }

    fn heartbeat(custom_mode: u32) -> Message {
        Message::Heartbeat(Heartbeat { mav_type: 1, autopilot: 3, custom_mode, ..Heartbeat::default() })
    }

    fn station() -> Station {
        let config = StationConfig { operator: "Ana".into(), ..StationConfig::default() };
        Station::start(config, Handle::current()).expect("a station starts")
    }

    fn hear(station: &Station, system: SystemId) {
        let header =
            Header { sequence: 0, source: Address { system, component: ComponentId(1) }, version: MavVersion::V2 };
        let origin = Origin { link: LinkId(0), peer: PeerId(0) };
        station.shared.on_frame(origin, &heartbeat(10).encode(header), station.now());
    }

    #[tokio::test]
    async fn what_is_said_is_seen_and_what_is_asked_is_carried() {
        let (station, far) = (station(), Arc::new(Far::default()));
        let early = station.wait_vehicle(None);
        let system = station.adopt("plane7", OWN, far.clone()).expect("there is room");
        let plane = station.vehicle(system).expect("adopted");
        assert_eq!(
            (system, plane.remote_name().as_deref()),
            (VehicleId::of_name("plane7").next().expect("one"), Some("plane7"))
        );
        let (later, other) = (station.wait_vehicle(Some(system)), station.wait_named("plane8"));
        let named = station.wait_named("plane7");
        assert!([&early, &later, &named].iter().all(|wait| wait.end().is_none()), "its heartbeat is not known yet");
        assert!(station.on_remote(system, &[(heartbeat(5), station.now())]));
        for waited in [early, later, named, station.wait_vehicle(None), station.wait_named("plane7")] {
            assert!(waited.end().is_some_and(|found| found.is_ok_and(|found| found.id() == system)));
        }
        other.cancel();
        let error = other.end().and_then(Result::err).expect("it is not there").to_string();
        assert!(error.starts_with("no vehicle called plane8") && error.ends_with("heard: plane7"), "{error}");
        assert_eq!(plane.telemetry().0.mode().map(|mode| mode.to_string()), Some("FBWA".into()));
        let heard = plane.subscribe_messages(None, 8);
        assert!(station.on_remote(system, &[(heartbeat(5), station.now())]));
        assert!(
            matches!(heard.take_ready(), Taken::Item(heard) if heard.link.is_none() && heard.frame.message_id() == 0)
        );
        assert_eq!(plane.request(Request::ReturnToLaunch).wait().await, Some(Ok(Reply::Done)));

        let forced = plane.request(Request::Disarm { force: true });
        let Some(Err(StationError::NeedsConfirmation { challenge })) = forced.end() else { panic!("{forced:?}") };
        let confirmed = plane.request_confirmed(Request::Disarm { force: true }, Some(&challenge.id));
        assert_eq!(confirmed.wait().await, Some(Ok(Reply::Done)));
        let carried = far.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let ana = || "Ana".to_owned();
        let forced = (Request::Disarm { force: true }, Some(Danger::ForceDisarm), ana());
        assert_eq!(carried, [(Request::ReturnToLaunch, None, ana()), forced]);
        let raw = plane.send(&heartbeat(0), false, None);
        assert!(matches!(raw, Err(StationError::RemoteRefused { .. })), "{raw:?}");
        assert_eq!(plane.is_reached(), None, "nothing of ours goes there, so nothing tells");
        station.close().await;
    }

    /// A clock that has run for a while.
    struct Late(SystemClock);

    impl Clock for Late {
        fn now(&self) -> MonoTime {
            self.0.now() + Duration::from_secs(1_000)
        }

        fn unix_us(&self) -> u64 {
            self.0.unix_us()
        }
    }

    #[tokio::test]
    async fn a_text_of_before_warns_of_nothing_now_and_takes_no_time_back() {
        let clock = Arc::new(Late(SystemClock::new()));
        let station = Station::with_clock(StationConfig::default(), Handle::current(), clock).expect("it starts");
        let id = station.adopt("plane7", OWN, Arc::new(Far::default())).expect("there is room");
        let plane = station.vehicle(id).expect("adopted");
        let now = station.now();
        station.on_remote(id, &[(heartbeat(5), now)]);
        let say = |text: &str, at| {
            let text = Message::StatusText(StatusText { severity: 2, text: text.into(), id: 0, chunk_seq: 0 });
            station.on_remote(id, &[(text, at)]);
            let newest = plane.newest_text(Severity::WARNING, Duration::from_secs(60));
            (plane.texts().last().map(|text| text.at), newest.map(|text| text.text))
        };
        let before = MonoTime::from_millis(700_000);
        assert_eq!(say("before", before), (Some(before), None));
        assert_eq!(station.shared.with_vehicle(id, Vehicle::heard_at), Some(now));
        assert_eq!(say("now", now), (Some(now), Some("now".into())));
        station.close().await;
        // A clock that began just now has no moments before: what was written before it began is not of now.
        let station = self::station();
        let id = station.adopt("plane7", OWN, Arc::new(Far::default())).expect("there is room");
        let text = StatusText { severity: 2, text: "before".into(), id: 0, chunk_seq: 0 };
        station.on_remote(id, &[(Message::StatusText(text), MonoTime::ZERO)]);
        let plane = station.vehicle(id).expect("adopted");
        assert_eq!(plane.newest_text(Severity::WARNING, Duration::from_secs(60)), None);
        station.close().await;
    }

    #[tokio::test]
    async fn two_that_speak_by_one_name_far_away_are_shown_and_told_of() {
        let station = station();
        let id = station.adopt("plane7", OWN, Arc::new(Far::default())).expect("there is room");
        station.on_remote(id, &[(heartbeat(5), station.now())]);
        let plane = station.vehicle(id).expect("adopted");
        let events = plane.subscribe_events(8);
        let told = |until: Option<Duration>| {
            station.on_remote_rival(id, until.map(|until| ("the fleet acme".into(), station.now() + until)));
            let event = if let Taken::Item(observed) = events.take_ready() { Some(observed.event) } else { None };
            (plane.rival(), event)
        };
        let acme = || Some("the fleet acme".to_owned());
        assert_eq!(told(Some(Duration::from_secs(60))), (acme(), Some(VehicleEvent::Contested)));
        assert_eq!(told(Some(Duration::from_secs(90))), (acme(), None), "told once");
        assert_eq!(told(None), (None, Some(VehicleEvent::Uncontested)));
        assert_eq!(told(Some(Duration::ZERO)), (None, None), "it is over by itself");
        assert_eq!(plane.follow_rival(), Ok(false), "here nobody chooses");
        station.close().await;
    }

    #[tokio::test]
    async fn what_is_known_on_board_of_plans_and_parameters_is_known_here() {
        let (station, far) = (station(), Arc::new(Far::default()));
        let system = station.adopt("plane7", OWN, far).expect("there is room");
        station.on_remote(system, &[(heartbeat(10), station.now())]);
        let plane = station.vehicle(system).expect("adopted");
        let events = plane.subscribe_events(8);
        let list = Mission { home: None, items: vec![MissionItem::waypoint(40.1, -3.7, 80.0)] };
        let verified = PlanState::Verified { count: 1, hash: 7 };
        station.on_remote_plan(system, PlanKind::Mission, verified, Some(list.clone()));
        assert_eq!(plane.plan_on_board(PlanKind::Mission), Some((verified, Some(Arc::new(list)))));
        assert!(matches!(events.take_ready(), Taken::Item(observed)
            if observed.event == VehicleEvent::PlanStateChanged { kind: PlanKind::Mission, state: verified }));
        // Another number of items than what was read: on board they know, and say so.
        let current = MISSION_CURRENT_DATA { seq: 1, total: 9, ..Default::default() };
        station.on_remote(system, &[(Message::Dialect(MavMessage::MISSION_CURRENT(current)), station.now())]);
        assert_eq!(plane.plan_state(PlanKind::Mission), Some(verified));
        station.on_remote_plan(system, PlanKind::Mission, PlanState::Empty, None);
        assert_eq!(plane.plan_on_board(PlanKind::Mission), Some((PlanState::Empty, None)));
        let name = ParamName::new("WP_LOITER_RAD").expect("a name");
        station.on_remote_parameters(system, &[Param::new(name, ParamValue::F32(60.0))]);
        assert_eq!(plane.flight_parameters().loiter_radius_m, Some(60.0));
        station.close().await;
    }

    #[tokio::test]
    async fn a_vehicle_at_a_link_is_never_mixed_with_one_far_away() {
        let station = station();
        hear(&station, OWN.system);
        let far = Arc::new(Far::default());
        let id = station.adopt("plane7", OWN, far.clone()).expect("there is room");
        station.on_remote(id, &[(heartbeat(5), station.now())]);
        hear(&station, OWN.system);
        let mode = |handle: VehicleHandle| handle.telemetry().0.mode().map(|mode| mode.to_string());
        let far = station.vehicle(id).expect("adopted");
        assert_eq!((far.address(), far.system()), (Some(OWN), None), "its own system id is no name of it here");
        assert_eq!(mode(far).as_deref(), Some("FBWA"), "it is not that of the other");
        let near = station.vehicle(OWN.system).expect("heard");
        assert_eq!((near.remote_name(), mode(near).as_deref()), (None, Some("AUTO")));
        assert_eq!(station.vehicles().len(), 2);
        station.close().await;
    }

    #[tokio::test]
    async fn a_request_that_is_carried_ends_when_it_is_cancelled_or_the_station_closes() {
        let station = station();
        let system = station.adopt("plane7", OWN, Arc::new(Far::default())).expect("there is room");
        let plane = station.vehicle(system).expect("adopted");
        let given_up = plane.request(Request::Land);
        assert_eq!(given_up.next_progress(0).await.map(|told| (told.done, told.total)), Some((1, 4)));
        given_up.cancel();
        assert_eq!(given_up.wait().await, Some(Err(VehicleError::Cancelled.into())));
        let closed = plane.request(Request::Land);
        station.close().await;
        assert_eq!(closed.wait().await, Some(Err(StationError::Closed)));
        assert_eq!(station.adopt("plane8", OWN, Arc::new(Far::default())), None);
    }
}
