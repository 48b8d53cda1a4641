//! One plane in ROS 2: its node, its topics and its services, for as long as this lives.

use std::sync::Arc;

use tokio::sync::mpsc;
use vencejo_flight::plan::{Mission, PlanKind};
use vencejo_station::{DropOldest, Observed, Taken, VehicleHandle};
use vencejo_vehicle::PlanState;
use zenoh::Session;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::query::Queryable;

use super::acts::Acting;
use super::setpoints::Setpoints;
use crate::carrier::{network, utc_ns};
use crate::error::FleetError;
use crate::ros2::cdr::Cdr;
use crate::ros2::message::{GeoPoseStamped, Log, Message};
use crate::ros2::moment::{Moment, time};
use crate::ros2::name::{Names, Place};
use crate::ros2::news;
use crate::ros2::params;
use crate::ros2::services::offers;
use crate::ros2::setpoint;
use crate::ros2::token::{Attachment, Kind, Node, gid, key};
use crate::ros2::topics::{StateSource, topics};

/// Lines of the log that wait for a tick at most.
const LINES: usize = 16;
/// Events that wait for a tick at most; the oldest go first.
const EVENTS: usize = 64;
/// Where nodes write their log.
const ROSOUT: &str = "/rosout";

/// A plane.
pub(super) struct Plane {
    vehicle: VehicleHandle,
    place: Place,
    source: StateSource,
    voices: Vec<Voice>,
    events: Arc<DropOldest<Observed>>,
    news: Vec<Voice>,
    log: Voice,
    /// Where it listens to any.
    setpoints: Option<Setpoints>,
    lines: mpsc::Receiver<(bool, String)>,
    ids: u32,
    // What ends with it.
    _tokens: Vec<LivelinessToken>,
    _services: Vec<Queryable<()>>,
}

/// Who sends one topic.
struct Voice {
    publisher: Publisher<'static>,
    gid: [u8; 16],
    sequence: i64,
}

impl Voice {
    async fn declare(session: &Session, key: String, token: &str) -> Result<Self, FleetError> {
        let publisher = session.declare_publisher(key).congestion_control(CongestionControl::Drop).await;
        Ok(Self { publisher: publisher.map_err(network::failed)?, gid: gid(token), sequence: 0 })
    }

    async fn send(&mut self, bytes: Vec<u8>) {
        self.sequence += 1;
        let attachment = Attachment { sequence: self.sequence, sent_ns: utc_ns(), gid: self.gid };
        if let Err(error) = self.publisher.put(bytes).attachment(attachment.to_bytes()).await {
            // The next one tells the same.
            tracing::debug!(%error, key = %self.publisher.key_expr(), "not sent");
        }
    }
}

impl Plane {
    /// Makes a vehicle known.
    pub(super) async fn declare(
        session: &Session,
        vehicle: VehicleHandle,
        place: Place,
        names: Names,
        node: Node,
        acting: &Arc<Acting>,
    ) -> Result<Self, FleetError> {
        let mut tokens = vec![node.token()];
        let mut id = node.id;
        let mut owners = vec![node.clone()];
        if names == Names::Mavros {
            // As MAVROS has them, a node of their own: `ros2 param` looks for one.
            id += 1;
            let namespace = format!("{}/{}", node.namespace.trim_end_matches('/'), node.name);
            owners.push(Node { id, namespace, name: params::NODE.to_owned(), ..node.clone() });
            tokens.extend(owners.last().map(Node::token));
        }
        let mut next = |kind, name: &str, of: &str, hash: &str| {
            id += 1;
            let is_param = name.strip_prefix(&place.prefix).is_some_and(|name| name.starts_with(params::BELOW));
            let owner = if is_param { owners.last() } else { owners.first() }.unwrap_or(&node);
            let token = match kind {
                Kind::Subscription => owner.token_of_heard(id, name, of, hash),
                _ => owner.token_of(id, kind, name, of, hash),
            };
            tokens.push(token.clone());
            (key(node.domain, name, of, hash), token)
        };
        let source = StateSource::new(topics(names));
        let mut voices = Vec::new();
        for topic in source.topics() {
            let (key, token) = next(Kind::Publisher, &place.topic(topic.name), topic.kind, topic.hash);
            voices.push(Voice::declare(session, key, &token).await?);
        }
        let events = vehicle.subscribe_events(EVENTS);
        let mut news = Vec::new();
        for (name, kind, hash) in news::topics(names) {
            let (key, token) = next(Kind::Publisher, &place.topic(name), kind, hash);
            news.push(Voice::declare(session, key, &token).await?);
        }
        let (key, token) = next(Kind::Publisher, ROSOUT, Log::TYPE, Log::HASH);
        let log = Voice::declare(session, key, &token).await?;
        let (line, lines) = mpsc::channel(LINES);
        let mut setpoints = None;
        if names == Names::Mavros {
            let (name, hash) = (place.topic(setpoint::TOPIC), GeoPoseStamped::HASH);
            let (key, _) = next(Kind::Subscription, &name, GeoPoseStamped::TYPE, hash);
            setpoints = Some(Setpoints::declare(session, key, acting.clone(), line.clone()).await?);
        }
        let mut services = Vec::new();
        for offer in offers(names) {
            let (key, _) = next(Kind::Service, &place.topic(offer.name), offer.kind, offer.hash);
            let (acting, vehicle, line, reply_key) = (acting.clone(), vehicle.clone(), line.clone(), key.clone());
            let asked = move |query| acting.on_query(query, &reply_key, offer, &vehicle, &line);
            let declared = session.declare_queryable(key).complete(true).callback(asked).await;
            services.push(declared.map_err(network::failed)?);
        }
        // Last, so that whoever sees it finds it there.
        let mut declared = Vec::new();
        for token in &tokens {
            declared.push(session.liveliness().declare_token(token).await.map_err(network::failed)?);
        }
        let ids = id + 1 - node.id;
        Ok(Self {
            vehicle,
            place,
            source,
            voices,
            events,
            news,
            log,
            setpoints,
            lines,
            ids,
            _tokens: declared,
            _services: services,
        })
    }

    /// How many numbers of the session it has.
    pub(super) fn ids(&self) -> u32 {
        self.ids
    }

    /// Whether the station has dropped the vehicle that this was declared for.
    pub(super) fn is_gone(&self) -> bool {
        self.events.is_closed()
    }

    /// What its topics begin with.
    pub(super) fn prefix(&self) -> &str {
        self.place.prefix.trim_end_matches('/')
    }

    /// Whether another plane would have the same topics there.
    pub(super) fn is_at(&self, place: &Place) -> bool {
        self.place.prefix == place.prefix
    }

    /// Says what is new, and has it fly where it is wanted; how much was said.
    pub(super) async fn say(&mut self) -> u64 {
        // A replayed vehicle has a time of its own.
        let (telemetry, now) = self.vehicle.telemetry();
        if let Some(setpoints) = &self.setpoints {
            setpoints.go_on(&self.vehicle, &telemetry, now);
        }
        let plan = match self.vehicle.plan_on_board(PlanKind::Mission) {
            Some((PlanState::Empty, _)) => Some(Arc::new(Mission { home: None, items: Vec::new() })),
            known => known.and_then(|(_, mission)| mission),
        };
        let moment = Moment {
            telemetry: &telemetry,
            now,
            utc_ns: utc_ns(),
            place: &self.place,
            home: self.vehicle.home(),
            mission: plan.as_deref(),
        };
        let mut said = 0;
        for (index, bytes) in self.source.due(&moment) {
            self.voices[index].send(bytes).await;
            said += 1;
        }
        while let Taken::Item(observed) = self.events.take_ready() {
            if let Some((index, bytes)) = news::of(&observed, &moment)
                && let Some(voice) = self.news.get_mut(index)
            {
                voice.send(bytes).await;
                said += 1;
            }
        }
        while let Ok((is_done, msg)) = self.lines.try_recv() {
            let line = Log {
                stamp: time(utc_ns()),
                // INFO, WARN.
                level: if is_done { 20 } else { 30 },
                name: format!("{}.{}", self.place.namespace.trim_matches('/').replace('/', "."), self.place.node),
                msg,
                file: String::new(),
                function: String::new(),
                line: 0,
            };
            self.log.send(line.to_bytes()).await;
            said += 1;
        }
        said
    }
}
