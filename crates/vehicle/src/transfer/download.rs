//! Reading a plan from the vehicle, by the best route.

use vencejo_flight::plan::{Command, PlanKind, Storage};
use vencejo_proto::plan_file::{PLAN_FILE_ITEM_LEN, PlanFileHeader, decode_plan_file};
use vencejo_proto::{Address, Message, MissionItemInt, MonoTime};

use super::ftp::{FileEnd, FileRead};
use super::items::{ItemDownload, Outbox};
use super::route::PlanRoute;
use super::{Transfer, TransferConfig, TransferError, TransferOutput};

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

/// Path of a plan file on an ArduPilot.
pub(super) fn path(kind: PlanKind) -> &'static str {
    match kind {
        PlanKind::Mission => "@MISSION/mission.dat",
        PlanKind::Fence => "@MISSION/fence.dat",
        PlanKind::Rally => "@MISSION/rally.dat",
    }
}

/// Most bytes of a plan file.
pub(crate) const MAX_FILE: usize = 10 + vencejo_flight::plan::MAX_ITEMS * PLAN_FILE_ITEM_LEN;

/// A plan file's length from its first bytes; an error text when it is not a plan file of this kind.
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

/// The items of a whole plan file, numbered from 0; an error text for another file.
pub(crate) fn file_items(kind: PlanKind, file: &[u8]) -> Result<Vec<MissionItemInt>, String> {
    let (_, mut items) = decode_plan_file(file).map_err(|error| error.to_string())?;
    if !items.iter().enumerate().all(|(index, item)| usize::from(item.seq) == index) {
        return Err("its items are not numbered from 0".to_owned());
    }
    items.iter_mut().for_each(|item| clean(item, kind));
    Ok(items)
}

/// Either of the two ways to read a plan.
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
                let bad = |problem| TransferError::BadFile { path: path(kind).to_owned(), problem };
                file_items(kind, &file).map_err(bad)
            })),
        }
    }
}

/// Calls a method of the running machine.
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

    /// Whether any part of a file was read, which follows the end of the previous session.
    pub(super) fn has_file(&self) -> bool {
        matches!(&self.read, Read::Ftp(read) if read.has_any())
    }

    /// Passes on the outputs of the machine below, and takes the other route when one failed.
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
