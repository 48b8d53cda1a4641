//! Plans to and from the vehicle: by which protocol, and whether the vehicle has what was sent.
//!
//! An upload succeeds only when the list read back is the list that was sent, as the vehicle stores it (law 2 of the
//! design: until then the plan is unknown).

use vencejo_flight::plan::{Command, Keeping, MissionItem, PlanKind, Storage, plans_equal_as_stored};
use vencejo_proto::dialect::{MISSION_CLEAR_ALL_DATA, MavMessage};
use vencejo_proto::plan_file::{PLAN_FILE_ITEM_LEN, PlanFileHeader, decode_plan_file, encode_plan_file};
use vencejo_proto::{Address, Message, MissionItemInt, MonoTime};

use super::float::largest_error_m;
use super::ftp::{FileEnd, FileRead, FileWrite, abandon};
use super::items::{ItemDownload, ItemUpload, ItemsSent, Outbox, mav_mission_type};
use super::read_back::{Others, OthersUntil, ReadBack};
use super::timing::{DENIED_WAIT, MESSAGE_TIMEOUT, RESTARTS, RoundTrip, SILENCE_LIMIT};
use super::{ItemForm, MissionResult, Transfer, TransferConfig, TransferError, TransferOutput};

/// By which protocol a plan goes.
///
/// The policy:
///
/// 1. An ArduPilot that announces MAVFTP gets the whole plan as a file, which is many times faster and replaces the old plan
///    at once. Everything else, and an ArduPilot whose MAVFTP does not answer, refuses, is used by another station, or did
///    not take the file as it was, goes item by item; there the vehicle names the item that it refuses. An empty plan goes
///    item by item too. A vehicle that falls silent is not asked again by another route.
/// 2. Items go as MISSION_ITEM_INT. They go as MISSION_ITEM, with positions in 32-bit floats, when
///    [`TransferConfig::item_form`] says that the vehicle has only that ([`ItemForm::Float`]: its AUTOPILOT_VERSION lacks
///    `MAV_PROTOCOL_CAPABILITY_MISSION_INT`, or it is an ArduPilot on MAVLink 1 that has none). When it is not known
///    ([`ItemForm::Unknown`]), MISSION_ITEM_INT is tried, and given up for MISSION_ITEM when the vehicle answers everything
///    but that: an upload, when it asks for the first item by MISSION_REQUEST a third time; a download, when
///    MISSION_REQUEST_LIST is answered but for 2 s and two tries no MISSION_REQUEST_INT is. That a vehicle asks by MISSION_REQUEST is no
///    sign by itself: ArduPlane of today does, also for an upload of MISSION_ITEM_INT. Both ways back begin anew with
///    MISSION_COUNT or MISSION_REQUEST_LIST, before the first item has gone over.
/// 3. What went as floats is not what was meant to the last digit: it counts as the plan that was sent when every position
///    is within what the roundings can do ([`VerifiedPlan::position_error_m`] says how far off the worst is). Parameter 4 of
///    a position (whence the track after a loiter is counted) may be lost, because ArduPlane 3.x has no room for it; any
///    other parameter that it does not keep, such as the radius of a loiter without end, is [`TransferError::NotAsSent`].
/// 4. Fences and rally points go by the item protocol only where a message says which plan it is about
///    ([`TransferConfig::no_plan_kinds`]); else [`TransferError::OnlyMission`], and nothing is sent. By file they go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlanRoute {
    /// As a plan file over MAVFTP.
    Ftp,
    /// By the item protocol.
    Items,
    /// By the item protocol, positions in 32-bit floats.
    FloatItems,
}

impl PlanRoute {
    /// The route to try first.
    pub fn first(config: &TransferConfig) -> Self {
        if config.is_ardupilot && config.has_ftp { Self::Ftp } else { Self::items(config) }
    }

    /// The route item by item.
    fn items(config: &TransferConfig) -> Self {
        if config.item_form == ItemForm::Float { Self::FloatItems } else { Self::Items }
    }

    /// In which message it carries items.
    fn form(self, config: &TransferConfig) -> ItemForm {
        match (self, config.item_form) {
            (Self::FloatItems, _) => ItemForm::Float,
            (_, ItemForm::Unknown) => ItemForm::Unknown,
            _ => ItemForm::Integer,
        }
    }

    /// The route to try after this one failed, if there is one.
    pub fn after(self, error: &TransferError, config: &TransferConfig, kind: PlanKind) -> Option<Self> {
        let by_items = matches!(
            error,
            TransferError::Ftp { .. }
                | TransferError::FtpBusy { .. }
                | TransferError::BadFile { .. }
                | TransferError::TooMany { .. }
                | TransferError::NoProgress { .. }
                | TransferError::NotAsSent { .. }
                | TransferError::FtpAbsent { .. }
        );
        match self {
            Self::Ftp => (by_items && config.refuses_items(kind).is_none()).then(|| Self::items(config)),
            Self::Items => matches!(error, TransferError::IntegerItemsIgnored).then_some(Self::FloatItems),
            Self::FloatItems => None,
        }
    }
}

/// A plan that the vehicle has, read back from it.
#[derive(Debug, Clone, PartialEq)]
pub struct VerifiedPlan {
    /// Which.
    pub kind: PlanKind,
    /// The list as the vehicle holds it, seq 0 upwards, home included where it is item 0.
    pub items: Vec<MissionItemInt>,
    /// How it was sent.
    pub route: PlanRoute,
    /// How far the farthest position is from where it was sent to be, metres, home of an ArduPilot aside; `None` when all
    /// are exact. Only [`PlanRoute::FloatItems`] moves positions, by what 32-bit floats cannot hold: up to 0.8 m at latitude
    /// 40°, 3.6 m at longitude 180°.
    pub position_error_m: Option<f64>,
}

/// A plan read from the vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct DownloadedPlan {
    /// Which.
    pub kind: PlanKind,
    /// The list as the vehicle holds it, seq 0 upwards, home included where it is item 0.
    pub items: Vec<MissionItemInt>,
    /// How it was read.
    pub route: PlanRoute,
}

fn path(kind: PlanKind) -> &'static str {
    match kind {
        PlanKind::Mission => "@MISSION/mission.dat",
        PlanKind::Fence => "@MISSION/fence.dat",
        PlanKind::Rally => "@MISSION/rally.dat",
    }
}

/// Most bytes of a plan file.
const MAX_FILE: usize = 10 + vencejo_flight::plan::MAX_ITEMS * PLAN_FILE_ITEM_LEN;

/// A plan file's length from its first bytes; an error text when it is no plan file of this kind.
fn file_len(kind: PlanKind, front: &[u8]) -> Result<FileEnd, String> {
    let header = PlanFileHeader::decode(front).map_err(|error| error.to_string())?;
    if header.mission_type != u16::from(kind.mission_type()) || header.first != 0 {
        return Err(format!(
            "it is plan kind {} from item {}, not the whole {kind}",
            header.mission_type, header.first
        ));
    }
    Ok(FileEnd::At(header.file_len()))
}

/// Clears what an ArduPilot may leave unset in an item of a plan file: up to 4.6 the plan's kind, and the position of a
/// command without one, hold whatever was in memory (`AP_Mission::get_item`).
fn clean(item: &mut MissionItemInt, kind: PlanKind) {
    item.mission_type = kind.mission_type();
    let Some(info) = Command(item.command).info() else { return };
    let is_dropped = |index: usize| info.params[index].storage == Storage::Dropped;
    if is_dropped(4) {
        item.x = 0;
    }
    if is_dropped(5) {
        item.y = 0;
    }
    if is_dropped(6) {
        item.z = 0.0;
    }
}

/// Any of the two ways to read a plan.
#[derive(Debug)]
enum Read {
    Ftp(Box<FileRead>),
    Items(Box<ItemDownload>),
}

impl Read {
    fn begin(route: PlanRoute, config: &TransferConfig, kind: PlanKind, closing: Option<u8>, now: MonoTime) -> Self {
        match route {
            PlanRoute::Items | PlanRoute::FloatItems => {
                Self::Items(Box::new(ItemDownload::new(config, kind, route.form(config), now)))
            }
            PlanRoute::Ftp => {
                let end = Box::new(move |front: &[u8]| file_len(kind, front));
                Self::Ftp(Box::new(FileRead::new(config, path(kind), MAX_FILE, end, closing, now)))
            }
        }
    }

    fn take_result(&mut self, kind: PlanKind) -> Option<Result<Vec<MissionItemInt>, TransferError>> {
        match self {
            Self::Items(read) => read.result(),
            Self::Ftp(read) => Some(read.result()?.and_then(|file| {
                let bad = |problem: String| TransferError::BadFile { path: path(kind).to_owned(), problem };
                let (_, mut items) = decode_plan_file(&file).map_err(|error| bad(error.to_string()))?;
                if !items.iter().enumerate().all(|(index, item)| usize::from(item.seq) == index) {
                    return Err(bad("its items are not numbered from 0".to_owned()));
                }
                items.iter_mut().for_each(|item| clean(item, kind));
                Ok(items)
            })),
        }
    }
}

/// Calls a method of whichever machine runs.
macro_rules! running {
    ($self:expr, $machine:ident => $call:expr) => {
        match $self {
            Read::Ftp($machine) => $call,
            Read::Items($machine) => $call,
        }
    };
}

/// Reads a plan by the best route. See [`PlanRoute`].
#[derive(Debug)]
pub struct PlanDownload {
    config: TransferConfig,
    kind: PlanKind,
    route: PlanRoute,
    read: Read,
    result: Option<Result<DownloadedPlan, TransferError>>,
    is_over: bool,
    out: Outbox,
}

impl PlanDownload {
    /// Begins to read.
    pub fn new(config: &TransferConfig, kind: PlanKind, now: MonoTime) -> Self {
        Self::by(PlanRoute::first(config), config, kind, None, now)
    }

    /// Begins to read; `closing` is the MAVFTP session of an upload that is to be ended first.
    pub(super) fn by(
        route: PlanRoute,
        config: &TransferConfig,
        kind: PlanKind,
        closing: Option<u8>,
        now: MonoTime,
    ) -> Self {
        let read = Read::begin(route, config, kind, closing, now);
        let mut download =
            Self { config: config.clone(), kind, route, read, result: None, is_over: false, out: Outbox::new() };
        download.advance(now);
        download
    }

    /// Whether anything of a file was read, which is done after the session before is closed.
    pub(super) fn has_file(&self) -> bool {
        matches!(&self.read, Read::Ftp(read) if read.has_any())
    }

    /// Moves on what the machine below has put out, and takes the other route when one failed.
    fn advance(&mut self, now: MonoTime) {
        if self.is_over {
            return;
        }
        while let Some(output) = running!(&mut self.read, read => read.poll_output()) {
            // The file's progress is in bytes.
            let output = match (output, self.route) {
                (TransferOutput::Progress { done, total }, PlanRoute::Ftp) => {
                    let items = |bytes: u32| bytes.saturating_sub(10) / PLAN_FILE_ITEM_LEN as u32;
                    TransferOutput::Progress { done: items(done), total: items(total) }
                }
                (output, _) => output,
            };
            self.out.push_back(output);
        }
        let route = self.route;
        match self.read.take_result(self.kind) {
            None => {}
            Some(result) => match result.as_ref().err().and_then(|e| route.after(e, &self.config, self.kind)) {
                Some(next) => {
                    tracing::debug!(kind = %self.kind, error = ?result.err(), ?next, "reading by another route");
                    self.route = next;
                    self.read = Read::begin(next, &self.config, self.kind, None, now);
                    self.advance(now);
                }
                None => {
                    self.is_over = true;
                    self.result = Some(result.map(|items| DownloadedPlan { kind: self.kind, items, route }));
                }
            },
        }
    }
}

impl Transfer for PlanDownload {
    type Value = DownloadedPlan;

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        running!(&mut self.read, read => read.on_message(from, message, now));
        self.advance(now);
    }

    fn on_time(&mut self, now: MonoTime) {
        running!(&mut self.read, read => read.on_time(now));
        self.advance(now);
    }

    fn deadline(&self) -> Option<MonoTime> {
        running!(&self.read, read => read.deadline())
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<DownloadedPlan, TransferError>> {
        self.result.take()
    }

    fn cancel(&mut self, now: MonoTime) {
        running!(&mut self.read, read => read.cancel(now));
        self.advance(now);
    }
}

/// Replaces a plan by the best route, reads it back and compares. See [`PlanRoute`].
#[derive(Debug)]
pub struct PlanUpload {
    config: TransferConfig,
    kind: PlanKind,
    items: Vec<MissionItemInt>,
    route: PlanRoute,
    /// The MAVFTP session that carried the file.
    session: Option<u8>,
    /// How often the list was sent again because the vehicle did not confirm it.
    resent: u32,
    /// What the vehicle calls the list since it has it.
    plan_id: Option<u32>,
    others: OthersUntil,
    step: Step,
    result: Option<Result<VerifiedPlan, TransferError>>,
    out: Outbox,
}

#[derive(Debug)]
enum Step {
    SendFile(FileWrite),
    SendItems(ItemUpload),
    /// The upload is kept when its final MISSION_ACK did not come: the vehicle may still ask for an item.
    ReadBack(Box<ReadBack>, Option<ItemUpload>),
    Over,
}

impl PlanUpload {
    /// Begins to send `items`: the list as on the wire, seq 0 upwards, home included where the vehicle has it as item 0
    /// (`Mission::to_wire`). Whom the items are addressed to is set here.
    pub fn new(config: &TransferConfig, kind: PlanKind, mut items: Vec<MissionItemInt>, now: MonoTime) -> Self {
        for item in &mut items {
            item.target = config.vehicle;
        }
        let route = if items.is_empty() { PlanRoute::items(config) } else { PlanRoute::first(config) };
        let mut upload = Self {
            config: config.clone(),
            kind,
            items,
            route,
            session: None,
            resent: 0,
            plan_id: None,
            others: OthersUntil::default(),
            step: Step::Over,
            result: None,
            out: Outbox::new(),
        };
        match upload.check() {
            Ok(()) => upload.send(route, now),
            Err(error) => upload.result = Some(Err(error)),
        }
        upload
    }

    /// Whether the list may be sent: numbered, of one kind, and every number in it finite and in range.
    fn check(&self) -> Result<(), TransferError> {
        let limit = u64::from(u16::MAX);
        if self.items.len() as u64 > limit {
            return Err(TransferError::TooMany { what: "items of a plan", count: self.items.len() as u64, limit });
        }
        for (index, item) in self.items.iter().enumerate() {
            if usize::from(item.seq) != index || item.mission_type != self.kind.mission_type() {
                return Err(TransferError::BadList { index, seq: item.seq, mission_type: item.mission_type });
            }
            MissionItem::from_wire(item)?.check_sendable(vencejo_proto::MissionSeq(item.seq))?;
        }
        Ok(())
    }

    /// Another station does something to the same plan.
    pub(crate) fn on_others(&mut self, others: Others, now: MonoTime) {
        self.others.note(others, now);
        if let Step::ReadBack(read, _) = &mut self.step {
            read.on_others(others, now);
            self.advance(now);
        }
    }

    /// Whether the vehicle has all of it, which is only read back yet.
    pub(crate) fn is_sent(&self) -> bool {
        matches!(&self.step, Step::ReadBack(read, None) if read.is_closed())
    }

    /// How many items it has.
    pub(crate) fn count(&self) -> usize {
        self.items.len()
    }

    /// What the vehicle calls the list since it has it, where it says so.
    pub(crate) fn plan_id(&self) -> Option<u32> {
        self.plan_id
    }

    fn send(&mut self, route: PlanRoute, now: MonoTime) {
        self.route = route;
        self.step = match route {
            PlanRoute::Items | PlanRoute::FloatItems => {
                let form = route.form(&self.config);
                Step::SendItems(ItemUpload::new(&self.config, self.kind, self.items.clone(), form, now))
            }
            PlanRoute::Ftp => {
                // Whole items in each write: what is lost leaves an item of zeros, and ArduPilot refuses the file.
                let file = encode_plan_file(self.kind.mission_type(), &self.items);
                Step::SendFile(FileWrite::new(&self.config, path(self.kind), file, PLAN_FILE_ITEM_LEN, 10, now))
            }
        };
        self.advance(now);
    }

    fn end(&mut self, result: Result<VerifiedPlan, TransferError>) {
        self.step = Step::Over;
        self.result = Some(result);
    }

    fn advance(&mut self, now: MonoTime) {
        let total = 2 * self.items.len() as u32;
        let mut put = |output, before: u32, per_item: u32| {
            self.out.push_back(match output {
                TransferOutput::Progress { done, .. } => {
                    TransferOutput::Progress { done: (before + done / per_item).min(total), total }
                }
                send => send,
            });
        };
        match &mut self.step {
            Step::SendItems(send) => {
                while let Some(output) = send.poll_output() {
                    put(output, 0, 1);
                }
                match send.result() {
                    None => {}
                    Some(Ok(ItemsSent { acknowledged: true, plan_id })) => {
                        self.plan_id = plan_id;
                        self.read_back(None, now);
                    }
                    Some(Ok(ItemsSent { acknowledged: false, .. })) => {
                        tracing::debug!(kind = %self.kind, "no final MISSION_ACK; the read-back decides");
                        let Step::SendItems(send) = std::mem::replace(&mut self.step, Step::Over) else { return };
                        self.read_back(None, now);
                        if let Step::ReadBack(_, unfinished) = &mut self.step {
                            *unfinished = Some(send);
                        }
                    }
                    Some(Err(error)) => self.fail_or_reroute(error, now),
                }
            }
            Step::SendFile(send) => {
                while let Some(output) = send.poll_output() {
                    put(output, 0, PLAN_FILE_ITEM_LEN as u32);
                }
                match send.result() {
                    None => {}
                    Some(Ok(session)) => self.read_back(Some(session), now),
                    Some(Err(error)) => self.fail_or_reroute(error, now),
                }
            }
            Step::ReadBack(read, unfinished) => {
                let (was_acknowledged, is_beside_others) = (unfinished.is_none(), read.is_beside_others());
                while let Some(output) = read.poll_output() {
                    put(output, total / 2, 1);
                }
                match read.result() {
                    None => {}
                    Some(Ok(plan)) => match compare(&self.config, self.kind, &self.items, &plan) {
                        Ok(position_error_m) => {
                            let (kind, route) = (self.kind, self.route);
                            self.end(Ok(VerifiedPlan { kind, items: plan.items, route, position_error_m }));
                        }
                        // Another station wrote it after us: to send it again would be a quarrel.
                        Err(error) if is_beside_others => self.end(Err(error)),
                        // It never said that it has it all: once more.
                        Err(TransferError::NotAsSent { .. }) if !was_acknowledged && self.resent < RESTARTS => {
                            self.resent += 1;
                            self.send(self.route, now);
                        }
                        Err(error) => self.fail_or_reroute(error, now),
                    },
                    Some(Err(TransferError::Cancelled)) => self.end(Err(TransferError::Cancelled)),
                    Some(Err(reason)) => {
                        let kind = self.kind;
                        self.end(Err(TransferError::Unverified { kind, reason: Box::new(reason) }));
                    }
                }
            }
            Step::Over => {}
        }
    }

    fn read_back(&mut self, closing: Option<u8>, now: MonoTime) {
        self.session = closing;
        let read = ReadBack::new(self.route, &self.config, self.kind, closing, self.others, now);
        self.step = Step::ReadBack(Box::new(read), None);
        self.advance(now);
    }

    fn fail_or_reroute(&mut self, error: TransferError, now: MonoTime) {
        match self.route.after(&error, &self.config, self.kind) {
            Some(next) => {
                tracing::debug!(kind = %self.kind, %error, ?next, "sending by another route");
                // Were the upload's session still open, whoever uses MAVFTP next would make its file the plan.
                if let Some(session) = self.session.take() {
                    self.out.extend(abandon(&self.config, session).map(TransferOutput::Send));
                }
                self.send(next, now);
            }
            None => self.end(Err(error)),
        }
    }
}

impl Transfer for PlanUpload {
    type Value = VerifiedPlan;

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        match &mut self.step {
            Step::SendFile(step) => step.on_message(from, message, now),
            Step::SendItems(step) => step.on_message(from, message, now),
            Step::ReadBack(_, unfinished)
                if unfinished.as_ref().is_some_and(|send| send.is_asked_by(from, message)) =>
            {
                if let Some(mut send) = unfinished.take() {
                    send.resume(now);
                    send.on_message(from, message, now);
                    self.step = Step::SendItems(send);
                }
            }
            Step::ReadBack(step, _) => step.on_message(from, message, now),
            Step::Over => {}
        }
        self.advance(now);
    }

    fn on_time(&mut self, now: MonoTime) {
        match &mut self.step {
            Step::SendFile(step) => step.on_time(now),
            Step::SendItems(step) => step.on_time(now),
            Step::ReadBack(step, _) => step.on_time(now),
            Step::Over => {}
        }
        self.advance(now);
    }

    fn deadline(&self) -> Option<MonoTime> {
        match &self.step {
            Step::SendFile(step) => step.deadline(),
            Step::SendItems(step) => step.deadline(),
            Step::ReadBack(step, _) => step.deadline(),
            Step::Over => None,
        }
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<VerifiedPlan, TransferError>> {
        self.result.take()
    }

    fn cancel(&mut self, now: MonoTime) {
        match &mut self.step {
            Step::SendFile(step) => step.cancel(now),
            Step::SendItems(step) => step.cancel(now),
            Step::ReadBack(step, _) => step.cancel(now),
            Step::Over => {}
        }
        self.advance(now);
    }
}

/// Whether the list read back is the list sent, as the vehicle stores it; how far positions are off where they were rounded.
fn compare(
    config: &TransferConfig,
    kind: PlanKind,
    sent: &[MissionItemInt],
    read_back: &DownloadedPlan,
) -> Result<Option<f64>, TransferError> {
    let parse = |items: &[MissionItemInt]| items.iter().map(MissionItem::from_wire).collect::<Result<Vec<_>, _>>();
    let unreadable = |error| TransferError::Unverified { kind, reason: Box::new(TransferError::Item(error)) };
    let (sent, kept) = (parse(sent)?, parse(&read_back.items).map_err(unreadable)?);
    let is_rounded = read_back.route == PlanRoute::FloatItems;
    let keeping = Keeping { is_ardupilot: config.is_ardupilot, in_floats: is_rounded };
    plans_equal_as_stored(&sent, &kept, kind, keeping)
        .map_err(|differences| TransferError::NotAsSent { kind, differences })?;
    let first = usize::from(config.is_ardupilot && kind == PlanKind::Mission);
    Ok(is_rounded.then(|| largest_error_m(&sent, &kept, first)))
}

/// Whether the mission that was read is the list that was sent, as the vehicle stores it.
pub(crate) fn is_as_sent(config: &TransferConfig, sent: &[MissionItemInt], read: &[MissionItemInt]) -> bool {
    let (kind, items) = (PlanKind::Mission, read.to_vec());
    compare(config, kind, sent, &DownloadedPlan { kind, items, route: PlanRoute::items(config) }).is_ok()
}

/// Removes a plan and checks that it is gone. See [`PlanRoute`].
#[derive(Debug)]
pub struct PlanClear {
    config: TransferConfig,
    kind: PlanKind,
    step: Clear,
    began: MonoTime,
    round_trip: RoundTrip,
    others: OthersUntil,
    out: Outbox,
}

#[derive(Debug)]
enum Clear {
    Asking { retry_at: MonoTime },
    Checking(Box<ReadBack>),
    Over(Option<Result<(), TransferError>>),
}

impl PlanClear {
    /// Begins to clear.
    pub fn new(config: &TransferConfig, kind: PlanKind, now: MonoTime) -> Self {
        let mut clear = Self {
            config: config.clone(),
            kind,
            step: Clear::Over(None),
            began: now,
            round_trip: RoundTrip::new(config.round_trip, MESSAGE_TIMEOUT),
            others: OthersUntil::default(),
            out: Outbox::new(),
        };
        match config.refuses_items(kind) {
            Some(error) => clear.step = Clear::Over(Some(Err(error))),
            None => clear.ask(now),
        }
        clear
    }

    /// Another station does something to the same plan.
    pub(crate) fn on_others(&mut self, others: Others, now: MonoTime) {
        self.others.note(others, now);
        if let Clear::Checking(check) = &mut self.step {
            check.on_others(others, now);
            self.advance();
        }
    }

    /// Whether the vehicle said that it has removed it, which is only looked at yet.
    pub(crate) fn is_cleared(&self) -> bool {
        matches!(self.step, Clear::Checking(_))
    }

    fn ask(&mut self, now: MonoTime) {
        self.out.push_back(TransferOutput::Send(Message::Dialect(MavMessage::MISSION_CLEAR_ALL(
            MISSION_CLEAR_ALL_DATA {
                target_system: self.config.vehicle.system.0,
                target_component: self.config.vehicle.component.0,
                mission_type: mav_mission_type(self.kind),
            },
        ))));
        self.step = Clear::Asking { retry_at: now + self.round_trip.timeout() };
    }

    fn advance(&mut self) {
        let Clear::Checking(check) = &mut self.step else { return };
        while let Some(output) = check.poll_output() {
            if matches!(output, TransferOutput::Send(_)) {
                self.out.push_back(output);
            }
        }
        let Some(result) = check.result() else { return };
        let kind = self.kind;
        // ArduPilot keeps home as item 0 of a mission.
        let home = u16::from(self.config.is_ardupilot && kind == PlanKind::Mission);
        self.step = Clear::Over(Some(match result {
            Ok(plan) => match (plan.items.len() as u16).saturating_sub(home) {
                0 => Ok(()),
                count => Err(TransferError::NotCleared { kind, count }),
            },
            Err(TransferError::Cancelled) => Err(TransferError::Cancelled),
            Err(reason) => Err(TransferError::Unverified { kind, reason: Box::new(reason) }),
        }));
    }
}

impl Transfer for PlanClear {
    type Value = ();

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        match (&mut self.step, message) {
            (Clear::Asking { retry_at }, Message::MissionAck(ack))
                if self.config.concerns_us(from, message) && ack.mission_type == self.kind.mission_type() =>
            {
                match MissionResult(ack.result) {
                    MissionResult::ACCEPTED => {
                        let route = PlanRoute::items(&self.config);
                        let check = ReadBack::new(route, &self.config, self.kind, None, self.others, now);
                        self.step = Clear::Checking(Box::new(check));
                    }
                    // Left over from an upload before this.
                    MissionResult::INVALID_SEQUENCE | MissionResult::OPERATION_CANCELLED => {}
                    MissionResult::DENIED if now.since(self.began) < SILENCE_LIMIT => *retry_at = now + DENIED_WAIT,
                    result => {
                        self.step =
                            Clear::Over(Some(Err(TransferError::Refused { kind: self.kind, result, seq: None })));
                    }
                }
            }
            (Clear::Checking(check), _) => check.on_message(from, message, now),
            _ => {}
        }
        self.advance();
    }

    fn on_time(&mut self, now: MonoTime) {
        match &mut self.step {
            Clear::Asking { retry_at } if now >= *retry_at => {
                let waited = now.since(self.began);
                if waited >= SILENCE_LIMIT {
                    self.step = Clear::Over(Some(Err(TransferError::Timeout { step: "MISSION_CLEAR_ALL", waited })));
                } else {
                    self.round_trip.timed_out();
                    self.ask(now);
                }
            }
            Clear::Checking(check) => check.on_time(now),
            _ => {}
        }
        self.advance();
    }

    fn deadline(&self) -> Option<MonoTime> {
        match &self.step {
            Clear::Asking { retry_at } => Some(*retry_at),
            Clear::Checking(check) => check.deadline(),
            Clear::Over(_) => None,
        }
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<(), TransferError>> {
        if let Clear::Over(result) = &mut self.step { result.take() } else { None }
    }

    fn cancel(&mut self, now: MonoTime) {
        match &mut self.step {
            Clear::Asking { .. } => self.step = Clear::Over(Some(Err(TransferError::Cancelled))),
            Clear::Checking(check) => check.cancel(now),
            Clear::Over(_) => {}
        }
        self.advance();
    }
}
