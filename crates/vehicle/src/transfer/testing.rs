//! Tests' own world: a link that loses, doubles, delays and cuts by a seed, in virtual time, and an imitation of an
//! ArduPlane's plan, file and parameter services. Nothing here sleeps or reads a clock.
//!
//! Any state machine can stand at either end: implement [`Endpoint`] for it, put both ends into a [`World`], and run.

mod old_plane;
mod px4;

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::time::Duration;

use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};
use vencejo_flight::plan::{MissionItem, PlanKind, ardupilot_stored};
use vencejo_proto::dialect::{
    MISSION_COUNT_DATA, MavMessage, MavMissionType, MavParamError, PARAM_ERROR_DATA, PARAM_VALUE_DATA,
};
use vencejo_proto::ftp::{FTP_MAX_DATA, FtpError, FtpOpcode, FtpPayload};
use vencejo_proto::param::{Param, ParamEncoding, ParamName, ParamValue, encode_packed_params};
use vencejo_proto::plan_file::{decode_plan_file, encode_plan_file};
use vencejo_proto::{
    Address, Frame, FrameDecoder, Header, MavVersion, Message, MissionAck, MissionItemInt, MissionSeq, MonoTime,
};

use super::{Transfer, TransferError, TransferOutput};

pub(crate) use old_plane::OldPlane;

pub(crate) const PLANE: Address = Address::new(1, 1);
pub(crate) const STATION: Address = Address::new(255, 190);
/// To whom an item in a file is addressed.
const NOBODY: Address = Address::new(0, 0);
pub(crate) const RIVAL: Address = Address::new(254, 190);

/// One end of a link.
pub(crate) trait Endpoint {
    /// A message came.
    fn receive(&mut self, from: Address, message: &Message, now: MonoTime);
    /// Time passed.
    fn tick(&mut self, now: MonoTime);
    /// When [`Endpoint::tick`] is wanted.
    fn wakes_at(&self) -> Option<MonoTime>;
    /// The next message to send, and to whom the other end shall answer.
    fn next_output(&mut self) -> Option<Message>;
}

/// How a link treats frames, each way.
#[derive(Debug, Clone)]
pub(crate) struct Faults {
    /// Share of frames lost.
    pub loss: f64,
    /// Share of frames that come more than once.
    pub duplicates: f64,
    /// How often those come.
    pub copies: u32,
    /// Share of frames that later ones overtake.
    pub reorder: f64,
    /// Time from one end to the other.
    pub delay: Duration,
    /// Most that is added to the delay, at random.
    pub jitter: Duration,
    /// Nothing of the station arrives.
    pub is_deaf: bool,
    /// Nothing passes in these times.
    pub blackouts: Vec<(MonoTime, MonoTime)>,
    /// Nothing passes any more after so many frames of the station.
    pub cut_after: Option<usize>,
    /// The time from one end to the other after so many frames of the station.
    pub slower_after: Option<(usize, Duration)>,
    /// Bytes per second, where the line is thin; what waits is queued.
    pub bytes_per_s: Option<f64>,
}

impl Default for Faults {
    fn default() -> Self {
        Self {
            loss: 0.0,
            duplicates: 0.0,
            copies: 2,
            reorder: 0.0,
            delay: Duration::from_micros(200),
            jitter: Duration::ZERO,
            is_deaf: false,
            blackouts: Vec::new(),
            cut_after: None,
            slower_after: None,
            bytes_per_s: None,
        }
    }
}

impl Faults {
    pub(crate) fn loss(share: f64) -> Self {
        Self { loss: share, ..Self::default() }
    }

    pub(crate) fn round_trip(round_trip: Duration) -> Self {
        Self { delay: round_trip / 2, ..Self::default() }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    Station,
    Plane,
}

/// A frame on its way: when it comes, in which order, to whom, from whom.
type InFlight = Reverse<(MonoTime, u64, Side, Vec<u8>)>;

/// Two ends and the link between them, in virtual time.
pub(crate) struct World<S, P> {
    pub now: MonoTime,
    pub station: S,
    pub plane: P,
    pub faults: Faults,
    /// In which version of the protocol both ends speak.
    pub version: MavVersion,
    rng: SmallRng,
    in_flight: BinaryHeap<InFlight>,
    order: u64,
    last: [MonoTime; 2],
    line_free_at: [MonoTime; 2],
    /// Frames that the station sent.
    pub station_frames: usize,
    /// How long one of them waited at most before a thin line was free.
    pub longest_wait: Duration,
    /// Every message that the station sent, when the test wants it.
    pub log: Option<Vec<(MonoTime, Message)>>,
}

impl<S: Endpoint, P: Endpoint> World<S, P> {
    pub(crate) fn new(station: S, plane: P, faults: Faults, seed: u64) -> Self {
        Self {
            now: MonoTime::ZERO,
            station,
            plane,
            faults,
            version: MavVersion::V2,
            rng: SmallRng::seed_from_u64(seed),
            in_flight: BinaryHeap::new(),
            order: 0,
            last: [MonoTime::ZERO; 2],
            line_free_at: [MonoTime::ZERO; 2],
            station_frames: 0,
            longest_wait: Duration::ZERO,
            log: None,
        }
    }

    /// Puts a frame of anybody on its way, to come at a time.
    pub(crate) fn inject(&mut self, at: MonoTime, to_station: bool, from: Address, message: &Message) {
        let frame = message.encode(Header { sequence: 0, source: from, version: self.version });
        let to = if to_station { Side::Station } else { Side::Plane };
        self.order += 1;
        self.in_flight.push(Reverse((at, self.order, to, frame.bytes().to_vec())));
    }

    fn transmit(&mut self, to: Side, message: &Message) {
        let source = if to == Side::Plane { STATION } else { PLANE };
        let frame = message.encode(Header { sequence: self.order as u8, source, version: self.version });
        let (now, way) = (self.now, to as usize);
        let mut leaves = now;
        if let Some(rate) = self.faults.bytes_per_s {
            if to == Side::Plane {
                self.longest_wait = self.longest_wait.max(self.line_free_at[way].since(now));
            }
            leaves = self.line_free_at[way].max(now) + Duration::from_secs_f64(frame.bytes().len() as f64 / rate);
            self.line_free_at[way] = leaves;
        }
        if to == Side::Plane {
            self.station_frames += 1;
        }
        let cut = self.faults.cut_after.is_some_and(|frames| self.station_frames > frames);
        let dark = self.faults.blackouts.iter().any(|(from, until)| now >= *from && now < *until);
        if cut || dark || self.faults.is_deaf && to == Side::Plane || self.rng.random_bool(self.faults.loss) {
            return;
        }
        let slower = self.faults.slower_after.filter(|(frames, _)| self.station_frames > *frames);
        let delay = slower.map_or(self.faults.delay, |(_, delay)| delay);
        let copies = if self.rng.random_bool(self.faults.duplicates) { self.faults.copies } else { 1 };
        for _ in 0..copies {
            let jitter = self.faults.jitter.mul_f64(self.rng.random());
            let mut at = leaves + delay + jitter;
            if self.rng.random_bool(self.faults.reorder) {
                at += Duration::from_millis(self.rng.random_range(1..60));
            } else {
                at = at.max(self.last[way]);
                self.last[way] = at;
            }
            self.order += 1;
            self.in_flight.push(Reverse((at, self.order, to, frame.bytes().to_vec())));
        }
    }

    fn flush(&mut self) {
        while let Some(message) = self.station.next_output() {
            if let Some(log) = &mut self.log {
                log.push((self.now, message.clone()));
            }
            self.transmit(Side::Plane, &message);
        }
        while let Some(message) = self.plane.next_output() {
            self.transmit(Side::Station, &message);
        }
    }

    /// Runs until `done` says so (asked after every step) or time is up; whether it was `done`.
    pub(crate) fn run(&mut self, until: MonoTime, mut done: impl FnMut(&mut S, &mut P) -> bool) -> bool {
        let mut steps_without_time = 0;
        loop {
            self.flush();
            if done(&mut self.station, &mut self.plane) {
                self.flush();
                return true;
            }
            let comes = self.in_flight.peek().map(|Reverse((at, ..))| *at);
            let next = [comes, self.station.wakes_at(), self.plane.wakes_at()].into_iter().flatten().min();
            let Some(next) = next.filter(|at| *at <= until) else {
                self.now = self.now.max(until);
                return false;
            };
            steps_without_time = if next > self.now { 0 } else { steps_without_time + 1 };
            assert!(steps_without_time < 10_000, "somebody wants to be woken again and again at {}", self.now);
            self.now = self.now.max(next);
            let due = comes.is_some_and(|at| at <= self.now);
            if due && let Some(Reverse((_, _, to, bytes))) = self.in_flight.pop() {
                let frame = decode(&bytes);
                let (from, message) = (frame.source(), frame.decode().expect("our own frames decode"));
                match to {
                    Side::Station => self.station.receive(from, &message, self.now),
                    Side::Plane => self.plane.receive(from, &message, self.now),
                }
                continue;
            }
            if self.station.wakes_at().is_some_and(|at| at <= self.now) {
                self.station.tick(self.now);
            }
            if self.plane.wakes_at().is_some_and(|at| at <= self.now) {
                self.plane.tick(self.now);
            }
        }
    }
}

fn decode(bytes: &[u8]) -> Frame {
    let mut decoder = FrameDecoder::new();
    decoder.push(bytes);
    decoder.next_frame().expect("one whole frame")
}

/// Frames of a recorded `.tlog` with their time from the first, microseconds.
pub(crate) fn tlog(name: &str) -> Vec<(u64, Frame)> {
    let path = format!("{}/../../tests/fixtures/captures/{name}.tlog", env!("CARGO_MANIFEST_DIR"));
    let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let mut frames: Vec<(u64, Frame)> = Vec::new();
    let mut rest = &bytes[..];
    while let Some((stamp, frame)) = rest.split_first_chunk::<8>() {
        let len = match frame {
            [0xfd, payload, incompatible, ..] => {
                12 + usize::from(*payload) + if incompatible & 1 != 0 { 13 } else { 0 }
            }
            [0xfe, payload, ..] => 8 + usize::from(*payload),
            _ => panic!("{name}: no frame at byte {}", bytes.len() - frame.len()),
        };
        frames.push((u64::from_be_bytes(*stamp), decode(&frame[..len])));
        rest = &frame[len..];
    }
    let first = frames.first().expect("a recording").0;
    frames.iter_mut().for_each(|(at, _)| *at -= first);
    frames
}

/// The messages of a recording that `from` sent, of those that this dialect knows.
pub(crate) fn recorded(name: &str, from: Address) -> Vec<(MonoTime, Message)> {
    tlog(name)
        .into_iter()
        .filter(|(_, frame)| frame.source() == from)
        .filter_map(|(at, frame)| Some((MonoTime::from_micros(at), frame.decode().ok()?)))
        .collect()
}

/// A vehicle that says what it said when it was recorded, whatever it is told.
pub(crate) struct Recording {
    messages: VecDeque<(MonoTime, Message)>,
    now: MonoTime,
    pub heard: Vec<Message>,
}

impl Recording {
    pub(crate) fn new(names: &[&str]) -> Self {
        let mut messages = VecDeque::new();
        let mut offset = Duration::ZERO;
        for name in names {
            let all = recorded(name, PLANE);
            let last = all.last().map_or(Duration::ZERO, |(at, _)| at.as_duration());
            messages.extend(all.into_iter().map(|(at, message)| (at + offset, message)));
            offset += last + Duration::from_millis(1);
        }
        Self { messages, now: MonoTime::ZERO, heard: Vec::new() }
    }
}

impl Endpoint for Recording {
    fn receive(&mut self, _from: Address, message: &Message, _now: MonoTime) {
        self.heard.push(message.clone());
    }

    fn tick(&mut self, now: MonoTime) {
        self.now = now;
    }

    fn wakes_at(&self) -> Option<MonoTime> {
        self.messages.front().map(|(at, _)| *at)
    }

    fn next_output(&mut self) -> Option<Message> {
        let is_due = self.messages.front().is_some_and(|(at, _)| *at <= self.now);
        if is_due { self.messages.pop_front().map(|(_, message)| message) } else { None }
    }
}

/// A transfer as one end of a link; keeps its result and its progress.
pub(crate) struct Running<T: Transfer> {
    pub transfer: T,
    pub result: Option<Result<T::Value, TransferError>>,
    pub progress: Vec<(u32, u32)>,
}

impl<T: Transfer> Running<T> {
    pub(crate) fn new(transfer: T) -> Self {
        Self { transfer, result: None, progress: Vec::new() }
    }

    fn collect(&mut self) {
        if let Some(result) = self.transfer.result() {
            assert!(self.result.is_none(), "a transfer ends once");
            self.result = Some(result);
        }
        assert!(self.result.is_none() || self.transfer.deadline().is_none(), "what is over wants no time");
    }

    pub(crate) fn cancel(&mut self, now: MonoTime) {
        self.transfer.cancel(now);
        self.collect();
    }
}

impl<T: Transfer> Endpoint for Running<T> {
    fn receive(&mut self, from: Address, message: &Message, now: MonoTime) {
        self.transfer.on_message(from, message, now);
        self.collect();
    }

    fn tick(&mut self, now: MonoTime) {
        self.transfer.on_time(now);
        self.collect();
    }

    fn wakes_at(&self) -> Option<MonoTime> {
        self.transfer.deadline()
    }

    fn next_output(&mut self) -> Option<Message> {
        self.collect();
        loop {
            match self.transfer.poll_output()? {
                TransferOutput::Send(message) => return Some(message),
                TransferOutput::Progress { done, total } => {
                    assert!(done <= total || total == 0, "progress {done} of {total}");
                    self.progress.push((done, total));
                }
            }
        }
    }
}

/// How many seeds a test tries: so many in the suite, another number in a soak.
pub(crate) fn seeds(usual: u64) -> u64 {
    std::env::var("VENCEJO_TEST_SEEDS").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// Runs a transfer against a plane until it is over; its result, and the time that it took.
pub(crate) fn run<T: Transfer, P: Endpoint>(
    world: &mut World<Running<T>, P>,
    limit: Duration,
) -> (Result<T::Value, TransferError>, Duration) {
    let began = world.now;
    let is_over = world.run(began + limit, |station, _| station.result.is_some());
    let took = world.now.since(began);
    assert!(is_over, "not over after {took:?}");
    (world.station.result.take().expect("it is over"), took)
}

/// Main loop of the imitation: ArduPlane reads its links and answers 50 times a second.
const TICK: Duration = Duration::from_millis(20);
/// MAVFTP requests that one turn queues; the rest is dropped.
const FTP_QUEUE: usize = 5;
/// A MAVFTP session that is idle for so long gives way to another.
const FTP_IDLE: Duration = Duration::from_secs(3);
/// One of several that is idle for so long is closed.
const FTP_KILL: Duration = Duration::from_secs(20);
/// PARAM_VALUEs that one turn streams.
const PARAMS_PER_TICK: usize = 40;

/// The plan, file and parameter services of an ArduPlane, as read in captures/*.tlog and in ArduPilot's
/// `MissionItemProtocol`, `GCS_FTP` (as up to 4.7, or as from 4.8 on), `AP_Filesystem_Mission` and
/// `AP_Filesystem_Param`.
pub(crate) struct MockPlane {
    inbox: Vec<(Address, Message)>,
    out: VecDeque<Message>,
    next_tick: MonoTime,
    /// Lists as stored: mission with home, fence, rally.
    pub plans: [Vec<MissionItemInt>; 3],
    pub params: Vec<Param>,
    /// How integers stand in PARAM_VALUE and PARAM_SET.
    pub param_encoding: ParamEncoding,
    pub has_ftp: bool,
    /// Does not know default values, and refuses to open the parameter file with a query for them.
    pub refuses_defaults: bool,
    /// Plan files have unset fields, as those of ArduPlane 4.6.
    pub leaves_garbage: bool,
    /// Keeps a home of its own as item 0, as ArduPilot does.
    pub keeps_home: bool,
    /// Stores items as a PX4.
    pub is_px4: bool,
    /// Ends an upload at an item out of order, as other autopilots do.
    pub strict_order: bool,
    upload: Option<ItemsIn>,
    ftp: Ftp,
    stream: Option<usize>,
    /// Times that a plan changed.
    pub changes: usize,
    /// Items that came when another was due.
    pub out_of_order: usize,
    /// MAVFTP requests that it had no room for.
    pub overflows: usize,
    /// PARAM_SETs taken.
    pub sets: usize,
    /// Parameters that keep their value.
    pub read_only: Vec<ParamName>,
    /// Files beside those of plans and parameters, by path.
    pub files: Vec<(&'static [u8], Vec<u8>)>,
}

struct ItemsIn {
    kind: usize,
    from: Address,
    next: u16,
    count: u16,
    received: MonoTime,
    asked: MonoTime,
}

struct Ftp {
    /// One for all up to ArduPlane 4.7; five from 4.8 on.
    sessions: Vec<FtpSession>,
    last: Option<(Address, FtpPayload)>,
}

#[derive(Default)]
struct FtpSession {
    /// Whose it is, where there are several.
    of: Option<Address>,
    id: Option<u8>,
    file: Option<OpenFile>,
    /// When it was last answered; `None` when it was ended.
    answered: Option<MonoTime>,
}

impl Ftp {
    fn with_sessions(count: usize) -> Self {
        Self { sessions: (0..count).map(|_| FtpSession::default()).collect(), last: None }
    }

    fn has_several(&self) -> bool {
        self.sessions.len() > 1
    }
}

struct OpenFile {
    kind: Option<usize>,
    content: Vec<u8>,
    is_write: bool,
    read_size: Option<usize>,
}

impl MockPlane {
    pub(crate) fn new() -> Self {
        let home = MissionItem::waypoint(40.3332, -3.7978, 600.09);
        Self {
            inbox: Vec::new(),
            out: VecDeque::new(),
            next_tick: MonoTime::from_millis(7),
            plans: [vec![home.to_wire(MissionSeq(0), NOBODY, PlanKind::Mission, false)], Vec::new(), Vec::new()],
            params: Vec::new(),
            param_encoding: ParamEncoding::CCast,
            has_ftp: true,
            refuses_defaults: false,
            leaves_garbage: true,
            keeps_home: true,
            is_px4: false,
            strict_order: false,
            upload: None,
            ftp: Ftp::with_sessions(1),
            stream: None,
            changes: 0,
            out_of_order: 0,
            overflows: 0,
            sets: 0,
            read_only: Vec::new(),
            files: Vec::new(),
        }
    }

    /// With several MAVFTP sessions, as ArduPlane from 4.8 on (`GCS_FTP.h`: `AP_MAVLINK_FTP_MAX_SESSIONS`).
    pub(crate) fn with_several_sessions() -> Self {
        Self { ftp: Ftp::with_sessions(5), ..Self::new() }
    }

    /// Puts a plan there, as if it had been uploaded.
    pub(crate) fn store(&mut self, kind: PlanKind, items: &[MissionItemInt]) {
        let stored = |item| Self::stored(self.is_px4, kind as usize, item).expect("an item that it takes");
        self.plans[kind as usize] = items.iter().map(stored).collect();
    }

    /// Begins anew, as after a loss of power: what is stored stays, what is under way is forgotten.
    pub(crate) fn reboot(&mut self) {
        self.inbox.clear();
        self.out.clear();
        self.upload = None;
        self.ftp = Ftp::with_sessions(self.ftp.sessions.len());
        self.stream = None;
    }

    fn ack(&mut self, to: Address, kind: usize, result: u8) {
        let mission_type = kind as u8;
        self.out.push_back(Message::MissionAck(MissionAck { target: to, result, mission_type, opaque_id: 0 }));
    }

    #[allow(deprecated, reason = "ArduPlane asks with MISSION_REQUEST")]
    fn ask(&mut self, now: MonoTime) {
        let Some(upload) = &mut self.upload else { return };
        upload.asked = now;
        self.out.push_back(Message::Dialect(MavMessage::MISSION_REQUEST(
            vencejo_proto::dialect::MISSION_REQUEST_DATA {
                seq: upload.next,
                target_system: upload.from.system.0,
                target_component: upload.from.component.0,
                mission_type: mission_type(upload.kind),
            },
        )));
    }

    /// What is stored of an item; the reason when it is refused.
    fn stored(is_px4: bool, kind: usize, item: &MissionItemInt) -> Result<MissionItemInt, u8> {
        if is_px4 {
            return px4::stored(item);
        }
        let read = MissionItem::from_wire(item).map_err(|_| 5)?;
        if !matches!(item.frame, 0 | 2 | 3 | 5 | 6 | 10 | 11) {
            return Err(2);
        }
        if read.command.info().is_none() || item.command == 4 {
            return Err(3);
        }
        let kind = [PlanKind::Mission, PlanKind::Fence, PlanKind::Rally][kind];
        Ok(ardupilot_stored(&read).to_wire(MissionSeq(item.seq), NOBODY, kind, false))
    }

    /// ArduPilot keeps its own home.
    fn keep(&mut self, kind: usize, mut item: MissionItemInt) {
        if kind == 0 && item.seq == 0 && self.keeps_home {
            (item.x, item.y, item.z) = (403_332_001, -37_977_996, 600.09);
        }
        self.changes += 1;
        let list = &mut self.plans[kind];
        match list.get_mut(usize::from(item.seq)) {
            Some(slot) => *slot = item,
            None => list.push(item),
        }
    }

    fn truncate(&mut self, kind: usize, count: usize) {
        self.changes += 1;
        self.plans[kind].truncate(count);
    }

    fn handle(&mut self, from: Address, message: &Message, now: MonoTime) {
        if !message.target().includes(PLANE) {
            return;
        }
        match message {
            Message::Dialect(MavMessage::MISSION_COUNT(count)) => {
                let kind = count.mission_type as usize;
                if self.upload.as_ref().is_some_and(|upload| upload.from != from) {
                    return self.ack(from, kind, 14);
                }
                self.upload = None;
                if count.count > 655 {
                    return self.ack(from, kind, 4);
                }
                self.truncate(kind, usize::from(count.count));
                if count.count == 0 {
                    return self.ack(from, kind, 0);
                }
                self.upload = Some(ItemsIn { kind, from, next: 0, count: count.count, received: now, asked: now });
                self.ask(now);
            }
            Message::MissionItemInt(item) => self.on_item(from, item, now),
            Message::Dialect(MavMessage::MISSION_REQUEST_LIST(request)) => {
                let kind = request.mission_type as usize;
                if self.upload.is_some() {
                    return self.ack(from, kind, 14);
                }
                self.out.push_back(Message::Dialect(MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
                    count: self.plans[kind].len() as u16,
                    target_system: from.system.0,
                    target_component: from.component.0,
                    mission_type: mission_type(kind),
                    ..Default::default()
                })));
            }
            Message::Dialect(MavMessage::MISSION_REQUEST_INT(request)) => {
                let kind = request.mission_type as usize;
                if self.upload.is_some() {
                    return self.ack(from, kind, 14);
                }
                match self.plans[kind].get(usize::from(request.seq)) {
                    Some(item) => {
                        let item = MissionItemInt { target: from, ..*item };
                        self.out.push_back(Message::MissionItemInt(item));
                    }
                    None => self.ack(from, kind, 13),
                }
            }
            Message::Dialect(MavMessage::MISSION_CLEAR_ALL(clear)) => {
                let kind = clear.mission_type as usize;
                if self.upload.as_ref().is_some_and(|upload| upload.from != from) {
                    return self.ack(from, kind, 14);
                }
                self.upload = None;
                self.truncate(kind, 0);
                self.ack(from, kind, 0);
            }
            Message::Dialect(MavMessage::PARAM_REQUEST_LIST(_)) => self.stream = Some(0),
            Message::Dialect(MavMessage::PARAM_REQUEST_READ(request)) => {
                let index = if request.param_index >= 0 {
                    (usize::from(request.param_index as u16) < self.params.len())
                        .then_some(request.param_index as usize)
                } else {
                    self.find(&request.param_id)
                };
                match index {
                    Some(index) => self.say_param(index, request.param_index as u16),
                    None => self.no_param(from, &request.param_id, request.param_index),
                }
            }
            Message::Dialect(MavMessage::PARAM_SET(set)) => match self.find(&set.param_id) {
                None => self.no_param(from, &set.param_id, -1),
                Some(index) => {
                    let encoding = self.param_encoding;
                    let param = &mut self.params[index];
                    if !self.read_only.contains(&param.name)
                        && let Some(value) = ParamValue::from_wire(set.param_value, param.value.param_type(), encoding)
                    {
                        param.value = value;
                        self.sets += 1;
                    }
                    self.say_param(index, u16::MAX);
                }
            },
            _ => {}
        }
    }

    fn find(&self, field: &[u8; 16]) -> Option<usize> {
        let name = ParamName::from_field(field)?;
        self.params.iter().position(|param| param.name == name)
    }

    fn say_param(&mut self, index: usize, as_index: u16) {
        let param = self.params[index];
        self.out.push_back(Message::Dialect(MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
            param_value: param.value.to_wire(self.param_encoding),
            param_count: self.params.len() as u16,
            param_index: as_index,
            param_id: param.name.to_field().into(),
            param_type: param.value.param_type().to_mav(),
        })));
    }

    fn no_param(&mut self, to: Address, field: &[u8; 16], index: i16) {
        self.out.push_back(Message::Dialect(MavMessage::PARAM_ERROR(PARAM_ERROR_DATA {
            param_index: index,
            target_system: to.system.0,
            target_component: to.component.0,
            param_id: (*field).into(),
            error: MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST,
        })));
    }

    fn on_item(&mut self, from: Address, item: &MissionItemInt, now: MonoTime) {
        let Some(upload) = &mut self.upload else {
            if !self.strict_order {
                self.ack(from, usize::from(item.mission_type), 1);
            }
            return;
        };
        let kind = upload.kind;
        if usize::from(item.mission_type) != kind {
            return;
        }
        if item.seq != upload.next {
            self.out_of_order += 1;
            if self.strict_order {
                self.upload = None;
            }
            return self.ack(from, kind, 13);
        }
        if from != upload.from {
            return self.ack(from, kind, 14);
        }
        match Self::stored(self.is_px4, kind, item) {
            Err(result) => {
                self.upload = None;
                self.ack(from, kind, result);
            }
            Ok(stored) => {
                upload.next += 1;
                upload.received = now;
                let is_whole = upload.next == upload.count;
                self.keep(kind, stored);
                if is_whole {
                    self.upload = None;
                    self.ack(from, kind, 0);
                } else {
                    self.ask(now);
                }
            }
        }
    }

    fn file_of(path: &[u8]) -> Option<Option<usize>> {
        match path {
            b"@MISSION/mission.dat" => Some(Some(0)),
            b"@MISSION/fence.dat" => Some(Some(1)),
            b"@MISSION/rally.dat" => Some(Some(2)),
            b"@PARAM/param.pck" | b"@PARAM/param.pck?withdefaults=1" => Some(None),
            _ => None,
        }
    }

    /// A plan as a file. ArduPlane 4.6 leaves what was in memory where an item has no position, and as its kind.
    fn file(&self, kind: usize) -> Vec<u8> {
        let mut items = self.plans[kind].clone();
        let mut last = (0, 0, 0.0);
        for item in items.iter_mut().filter(|_| kind == 0 && self.leaves_garbage) {
            if MissionItem::from_wire(item).is_ok_and(|item| item.has_position()) {
                last = (item.x, item.y, item.z);
            } else {
                (item.x, item.y, item.z) = last;
                item.mission_type = 127;
            }
        }
        encode_plan_file(kind as u8, &items)
    }

    /// Ends a session and makes an uploaded file the plan; whether it did not refuse the file.
    fn close(&mut self, at: usize) -> bool {
        let session = &mut self.ftp.sessions[at];
        (session.id, session.answered) = (None, None);
        let Some(OpenFile { kind: Some(kind), content, is_write: true, .. }) = session.file.take() else { return true };
        let Ok((header, items)) = decode_plan_file(&content) else { return false };
        let is_zero = |item: &MissionItemInt| item.to_packed().iter().all(|byte| *byte == 0);
        if header.mission_type as usize != kind || items.iter().any(is_zero) {
            return false;
        }
        self.truncate(kind, 0);
        for (seq, item) in items.iter().enumerate() {
            // What is refused ends it, and leaves what came before.
            let Ok(stored) = Self::stored(self.is_px4, kind, item) else { return false };
            self.keep(kind, MissionItemInt { seq: seq as u16, ..stored });
        }
        true
    }

    fn ftp_answer(&mut self, at: usize, to: Address, answer: FtpPayload, now: MonoTime) {
        let is_end = answer.req_opcode == FtpOpcode::TERMINATE_SESSION;
        self.ftp.sessions[at].answered = (!is_end).then_some(now);
        self.out.push_back(answer.to_message(to));
        self.ftp.last = Some((to, answer));
    }

    /// The session that a request is of; `None` when all are in use. Where there are several, one that is idle is
    /// taken.
    fn ftp_session(&mut self, from: Address, id: u8, now: MonoTime) -> Option<usize> {
        if !self.ftp.has_several() {
            return Some(0);
        }
        let sessions = &self.ftp.sessions;
        let known = sessions.iter().position(|session| session.of == Some(from) && session.id == Some(id));
        if known.is_some() {
            return known;
        }
        let oldest = (0..sessions.len()).min_by_key(|at| sessions[*at].answered)?;
        if sessions[oldest].answered.is_some_and(|at| now.since(at) < FTP_IDLE) {
            return None;
        }
        self.close(oldest);
        let session = &mut self.ftp.sessions[oldest];
        (session.of, session.id) = (Some(from), Some(id));
        Some(oldest)
    }

    fn on_ftp(&mut self, from: Address, request: &FtpPayload, now: MonoTime) {
        let mut answer = FtpPayload::request(FtpOpcode::ACK, request.session, request.sequence.wrapping_add(1), 0, &[]);
        answer.req_opcode = request.opcode;
        let nak = |answer: &mut FtpPayload, code| {
            answer.opcode = FtpOpcode::NAK;
            (answer.data, answer.size) = (vec![code], 1);
        };
        if self.ftp.has_several() && request.opcode == FtpOpcode::RESET_SESSIONS {
            for at in 0..self.ftp.sessions.len() {
                if self.ftp.sessions[at].of == Some(from) {
                    self.close(at);
                }
            }
            return self.out.push_back(answer.to_message(from));
        }
        let Some(at) = self.ftp_session(from, request.session, now) else {
            nak(&mut answer, FtpError::NO_SESSIONS_AVAILABLE);
            return self.out.push_back(answer.to_message(from));
        };
        if let Some((to, last)) = &self.ftp.last
            && *to == from
            && last.session == request.session
            && last.sequence == request.sequence.wrapping_add(1)
        {
            let again = last.to_message(from);
            self.ftp.sessions[at].answered = Some(now);
            return self.out.push_back(again);
        }
        let session = &self.ftp.sessions[at];
        let is_other = session.id != Some(request.session);
        if matches!(request.opcode, FtpOpcode::TERMINATE_SESSION | FtpOpcode::RESET_SESSIONS) {
            let is_refused = !is_other && !self.close(at) && self.ftp.has_several();
            if is_refused {
                answer.opcode = FtpOpcode::NAK;
                (answer.data, answer.size) = (vec![FtpError::FAIL_ERRNO, 22], 2);
            }
            return self.ftp_answer(at, from, answer, now);
        }
        if session.file.is_some() && is_other {
            if session.answered.is_some_and(|answered| now.since(answered) < FTP_IDLE) {
                nak(&mut answer, FtpError::INVALID_SESSION);
                return self.ftp_answer(at, from, answer, now);
            }
            self.close(at);
        }
        match request.opcode {
            FtpOpcode::OPEN_FILE_RO | FtpOpcode::CREATE_FILE => {
                let is_write = request.opcode == FtpOpcode::CREATE_FILE;
                let is_upload = |session: &FtpSession| session.file.as_ref().is_some_and(|file| file.is_write);
                if self.ftp.sessions[at].file.is_some() {
                    nak(&mut answer, FtpError::FAIL);
                } else if is_write && self.ftp.sessions.iter().any(is_upload) {
                    // One upload at a time (`AP_Filesystem_Mission::open`).
                    answer.opcode = FtpOpcode::NAK;
                    (answer.data, answer.size) = (vec![FtpError::FAIL_ERRNO, 0], 2);
                } else if let Some((_, content)) =
                    self.files.iter().find(|(path, _)| *path == request.data && !is_write)
                {
                    let file = OpenFile { kind: Some(3), content: content.clone(), is_write, read_size: None };
                    (answer.data, answer.size) = ((content.len() as u32).to_le_bytes().to_vec(), 4);
                    self.ftp.sessions[at].id = Some(request.session);
                    self.ftp.sessions[at].file = Some(file);
                } else if self.refuses_defaults && request.data.ends_with(b"?withdefaults=1") {
                    nak(&mut answer, FtpError::FAIL);
                } else if let Some(kind) = Self::file_of(&request.data) {
                    let content = match kind {
                        _ if is_write => Vec::new(),
                        Some(kind) => self.file(kind),
                        None => Vec::new(),
                    };
                    self.ftp.sessions[at].id = Some(request.session);
                    self.ftp.sessions[at].file = Some(OpenFile { kind, content, is_write, read_size: None });
                    if !is_write {
                        (answer.data, answer.size) = ((1u32 << 20).to_le_bytes().to_vec(), 4);
                    }
                } else {
                    nak(&mut answer, FtpError::FILE_NOT_FOUND);
                }
                self.ftp_answer(at, from, answer, now);
            }
            FtpOpcode::WRITE_FILE => {
                match &mut self.ftp.sessions[at].file {
                    Some(file) if file.is_write => {
                        let start = request.offset as usize;
                        let end = start + request.data.len();
                        if start == 0 && request.data.len() >= 10 {
                            let count = usize::from(u16::from_le_bytes([request.data[8], request.data[9]]));
                            let len = 10 + 38 * count;
                            file.content.resize(len.max(file.content.len()), 0);
                        }
                        file.content.resize(end.max(file.content.len()), 0);
                        file.content[start..end].copy_from_slice(&request.data);
                        answer.offset = request.offset;
                    }
                    Some(_) => nak(&mut answer, FtpError::FAIL),
                    None => nak(&mut answer, FtpError::FILE_NOT_FOUND),
                }
                self.ftp_answer(at, from, answer, now);
            }
            FtpOpcode::READ_FILE | FtpOpcode::BURST_READ_FILE => {
                let params = &self.params;
                let file = match &mut self.ftp.sessions[at].file {
                    Some(file) if !file.is_write => file,
                    Some(_) => {
                        nak(&mut answer, FtpError::FAIL);
                        return self.ftp_answer(at, from, answer, now);
                    }
                    None => {
                        nak(&mut answer, FtpError::FILE_NOT_FOUND);
                        return self.ftp_answer(at, from, answer, now);
                    }
                };
                let size = usize::from(request.size).clamp(1, FTP_MAX_DATA);
                if file.kind.is_none() && file.read_size.is_none() {
                    file.content = encode_packed_params(params, size);
                    file.read_size = Some(size);
                }
                let is_wrong_size = file.read_size.is_some_and(|fixed| fixed != size);
                let content = file.content.clone();
                if is_wrong_size {
                    answer.opcode = FtpOpcode::NAK;
                    (answer.data, answer.size) = (vec![FtpError::FAIL_ERRNO, 22], 2);
                    return self.ftp_answer(at, from, answer, now);
                }
                let is_burst = request.opcode == FtpOpcode::BURST_READ_FILE;
                let start = (request.offset as usize).min(content.len());
                for part in content[start..].chunks(size).take(if is_burst { 500 } else { 1 }) {
                    (answer.data, answer.size) = (part.to_vec(), part.len() as u8);
                    answer.offset =
                        request.offset + (answer.sequence.wrapping_sub(request.sequence) as u32 - 1) * size as u32;
                    self.ftp_answer(at, from, answer.clone(), now);
                    answer.sequence = answer.sequence.wrapping_add(1);
                }
                if is_burst || start == content.len() {
                    nak(&mut answer, FtpError::END_OF_FILE);
                    self.ftp_answer(at, from, answer, now);
                }
            }
            _ => {
                nak(&mut answer, FtpError::FAIL);
                self.ftp_answer(at, from, answer, now);
            }
        }
    }
}

fn mission_type(kind: usize) -> MavMissionType {
    [
        MavMissionType::MAV_MISSION_TYPE_MISSION,
        MavMissionType::MAV_MISSION_TYPE_FENCE,
        MavMissionType::MAV_MISSION_TYPE_RALLY,
    ][kind]
}

impl Endpoint for MockPlane {
    fn receive(&mut self, from: Address, message: &Message, _now: MonoTime) {
        self.inbox.push((from, message.clone()));
    }

    fn tick(&mut self, now: MonoTime) {
        self.next_tick = now + TICK;
        let mut ftp_requests = VecDeque::new();
        for (from, message) in std::mem::take(&mut self.inbox) {
            match FtpPayload::from_message(&message) {
                Some((target, request)) if target.includes(PLANE) => {
                    if self.has_ftp && ftp_requests.len() < FTP_QUEUE {
                        ftp_requests.push_back((from, request));
                    } else {
                        self.overflows += 1;
                    }
                }
                _ => self.handle(from, &message, now),
            }
        }
        if self.ftp.has_several() {
            for at in 0..self.ftp.sessions.len() {
                if self.ftp.sessions[at].answered.is_some_and(|answered| now.since(answered) > FTP_KILL) {
                    self.close(at);
                }
            }
        }
        for (from, request) in ftp_requests {
            self.on_ftp(from, &request, now);
        }
        if let Some(next) = self.stream {
            let end = (next + PARAMS_PER_TICK).min(self.params.len());
            (next..end).for_each(|index| self.say_param(index, index as u16));
            self.stream = (end < self.params.len()).then_some(end);
        }
        if let Some(upload) = &self.upload {
            if now.since(upload.received) > Duration::from_secs(8) {
                let (to, kind) = (upload.from, upload.kind);
                self.upload = None;
                self.ack(to, kind, 15);
            } else if now.since(upload.asked) > Duration::from_secs(1) {
                self.ask(now);
            }
        }
    }

    fn wakes_at(&self) -> Option<MonoTime> {
        Some(self.next_tick)
    }

    fn next_output(&mut self) -> Option<Message> {
        self.out.pop_front()
    }
}
