//! Reads a plan back after it was written. The result counts only if no other station has written the plan meanwhile.

use vencejo_flight::plan::PlanKind;
use vencejo_proto::{Address, Message, MonoTime};

use super::download::{DownloadedPlan, PlanDownload};
use super::items::Outbox;
use super::route::PlanRoute;
use super::timing::{PROGRESS_LIMIT, RESTARTS, UPLOAD_REST};
use super::{Transfer, TransferConfig, TransferError, TransferOutput};

/// What another station does to a plan while we write it and read it back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Others {
    /// It is uploading: a list that is read meanwhile may be a mixture of two plans.
    Write,
    /// The vehicle has refused its upload, or the rest of it.
    Refused,
    /// It may have changed the plan in one step (cleared it, or closed a plan file).
    Changed,
    /// The vehicle has acknowledged its whole plan.
    Finished,
}

/// Until when another station counts as uploading, as far as it is heard.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct OthersUntil(Option<MonoTime>);

impl OthersUntil {
    pub fn note(&mut self, others: Others, now: MonoTime) {
        self.0 = (others == Others::Write).then(|| now + UPLOAD_REST);
    }

    fn ahead(self, now: MonoTime) -> Option<MonoTime> {
        self.0.filter(|until| now < *until)
    }
}

/// Reads a plan back; starts again, after the others, when they have written it meanwhile.
#[derive(Debug)]
pub(super) struct ReadBack {
    config: TransferConfig,
    kind: PlanKind,
    route: PlanRoute,
    state: State,
    others: OthersUntil,
    /// Whether the upload's MAVFTP session is closed: only then does its file become the plan.
    is_closed: bool,
    /// Whether others have written since this reading began.
    is_void: bool,
    /// How often reading was started again.
    restarts: u32,
    result: Option<Result<DownloadedPlan, TransferError>>,
    out: Outbox,
}

#[derive(Debug)]
enum State {
    Reading(Box<PlanDownload>),
    /// Waits for others to finish writing.
    Waiting {
        since: MonoTime,
    },
    Over,
}

impl ReadBack {
    /// Starts reading. `closing`: the upload's MAVFTP session, which is closed first.
    pub fn new(
        route: PlanRoute,
        config: &TransferConfig,
        kind: PlanKind,
        closing: Option<u8>,
        others: OthersUntil,
        now: MonoTime,
    ) -> Self {
        let mut read = Self {
            config: config.clone(),
            kind,
            route,
            state: State::Reading(Box::new(PlanDownload::by(route, config, kind, closing, now))),
            others,
            is_closed: closing.is_none(),
            is_void: others.ahead(now).is_some(),
            restarts: 0,
            result: None,
            out: Outbox::new(),
        };
        read.advance(now);
        read
    }

    /// Whether the upload's MAVFTP session is closed, so that its file is the plan.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Whether others have written the plan since the read-back began.
    pub fn is_beside_others(&self) -> bool {
        self.is_void || self.restarts > 0
    }

    pub fn on_others(&mut self, others: Others, now: MonoTime) {
        self.others.note(others, now);
        self.is_void |= others != Others::Refused;
        self.advance(now);
    }

    fn end(&mut self, result: Result<DownloadedPlan, TransferError>) {
        self.state = State::Over;
        self.result = Some(result);
    }

    fn give_up(&mut self) {
        let step = "reading a plan back while another station writes it";
        self.end(Err(TransferError::NoProgress { step, attempts: self.restarts + 1 }));
    }

    fn advance(&mut self, now: MonoTime) {
        if let State::Reading(read) = &mut self.state {
            while let Some(output) = read.poll_output() {
                self.out.push_back(output);
            }
            self.is_closed |= read.has_file();
            match read.result() {
                None => {}
                Some(result @ Err(TransferError::Cancelled | TransferError::Timeout { .. })) => self.end(result),
                Some(_) if self.is_void => self.state = State::Waiting { since: now },
                Some(result) => self.end(result),
            }
        }
        if matches!(self.state, State::Waiting { .. }) && self.others.ahead(now).is_none() {
            if self.restarts == RESTARTS {
                return self.give_up();
            }
            self.restarts += 1;
            self.is_void = false;
            self.state = State::Reading(Box::new(PlanDownload::by(self.route, &self.config, self.kind, None, now)));
            self.advance(now);
        }
    }
}

impl Transfer for ReadBack {
    type Value = DownloadedPlan;

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        if let State::Reading(read) = &mut self.state {
            read.on_message(from, message, now);
        }
        self.advance(now);
    }

    fn on_time(&mut self, now: MonoTime) {
        match &mut self.state {
            State::Reading(read) => read.on_time(now),
            State::Waiting { since } if now >= *since + PROGRESS_LIMIT => return self.give_up(),
            State::Waiting { .. } | State::Over => {}
        }
        self.advance(now);
    }

    fn deadline(&self) -> Option<MonoTime> {
        match &self.state {
            State::Reading(read) => read.deadline(),
            State::Waiting { since } => self.others.0.into_iter().chain([*since + PROGRESS_LIMIT]).min(),
            State::Over => None,
        }
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<DownloadedPlan, TransferError>> {
        self.result.take()
    }

    fn cancel(&mut self, now: MonoTime) {
        match &mut self.state {
            State::Reading(read) => read.cancel(now),
            State::Waiting { .. } => self.end(Err(TransferError::Cancelled)),
            State::Over => {}
        }
        self.advance(now);
    }
}
