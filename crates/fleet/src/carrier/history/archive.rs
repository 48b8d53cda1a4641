//! The archive on the ground: what is heard of each aircraft is stored, and what was not heard is fetched.
//!
//! `NAME.json` beside the files of an aircraft has the record numbers that the files have, or had before they were
//! deleted to make room, and those that are not available. It is written after the files are synced, so it never claims
//! more than they have. One thread writes the files of all aircraft.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};
use std::time::Duration;

use prost::Message;
use tokio::sync::Semaphore;
use vencejo_link::{Clock, Line, RecorderState, Recorders, SystemClock};
use vencejo_proto::MonoTime;
use vencejo_store::Access;
use zenoh::Session;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{ConsolidationMode, QueryTarget};

use self::note::{ENDING, Numbers, Unread, of_text, to_text};
use super::shelf::{self, Shelf};
use super::{HistoryConfig, Item, Journal, prefix};
use crate::history::fill::ANSWER_WITHIN;
use crate::history::pen::About;
use crate::history::record::{IndexWanted, MAX_ANSWER_BYTES};
use crate::history::{Fill, Index, Piece, Question, Record, Stream};
use crate::key::{Kind, Name, key_of};
use crate::payload::{Event, State};

mod note;

/// How often it is checked whether to request records.
const TICK: Duration = Duration::from_millis(50);
/// How often the notes are written.
const NOTE_EVERY: Duration = Duration::from_secs(5);
/// Most notes written each time; further ones take turns.
const NOTES_AT_ONCE: usize = 64;
/// Most boots remembered of one aircraft, besides those that it has itself.
const MAX_BOOTS: usize = 256;
/// Most aircraft in an archive.
const MAX_AIRCRAFT: usize = vencejo_vehicle::registry::MAX_FAR;

/// What the files have as it is to be noted, when they have it.
struct Pending {
    numbers: Numbers,
    /// From where files may have more then.
    unread: Unread,
    /// So many records had been handed over for it.
    put: u64,
}

fn merge(into: &mut Numbers, found: &Numbers) {
    for (key, found) in found {
        into.entry(*key).or_default().add(found);
    }
}

/// Names in order, beginning behind the one that had its turn last.
fn from_behind(mut names: Vec<Name>, last: Option<&Name>) -> Vec<Name> {
    let behind = last.map_or(0, |last| names.partition_point(|name| name <= last));
    names.rotate_left(behind);
    names
}

/// One aircraft.
struct Inventory {
    fill: Fill,
    /// Begins with the first that is heard.
    line: Option<Line<Journal>>,
    /// Records that were handed over to be written.
    put: u64,
    /// Of what was handed over before, so much was not written, or not for sure: dropped records, and failures.
    missed: (u64, u64),
    /// UTC here less the clock on board, ms, of the boot that is heard; of the soonest sample.
    offset: Option<(u64, i64)>,
    last_state: u64,
    /// What the files have for sure: what the note on the disk says, and what was read in them.
    noted: Numbers,
    pending: Option<Pending>,
    /// What is still to be read.
    unread: Option<Unread>,
    /// The file that was written last.
    file: Option<String>,
    /// Why nothing was written lately.
    problem: Option<String>,
}

/// The archive.
pub(in crate::carrier) struct Archive {
    config: HistoryConfig,
    org: Name,
    clock: Arc<SystemClock>,
    /// `None`: it is closed.
    recorders: Mutex<Option<Recorders<Journal>>>,
    aircraft: Mutex<BTreeMap<Name, Inventory>>,
    /// The last aircraft whose note was written: others have their turn first.
    noted_last: Mutex<Option<Name>>,
    /// The first aircraft without a place is reported, once.
    is_full: Once,
}

impl Archive {
    /// Opens an archive from its notes. It blocks.
    ///
    /// # Errors
    /// When the thread cannot be started.
    pub(in crate::carrier) fn open(org: Name, config: HistoryConfig) -> io::Result<Self> {
        let clock = Arc::new(SystemClock::new());
        let recorders = Mutex::new(Some(Journal::recorders(&config, clock.clone())?));
        let (aircraft, noted_last, is_full) = (Mutex::default(), Mutex::default(), Once::new());
        let archive = Self { config, org, clock, recorders, aircraft, noted_last, is_full };
        let entries = std::fs::read_dir(&archive.config.folder).into_iter().flatten().flatten();
        let files = entries.filter_map(|entry| entry.file_name().into_string().ok());
        // Those of whom there are files alone as well: their program was killed before it noted anything.
        let of = |file: String| match file.strip_suffix(shelf::ENDING) {
            Some(stem) => stem.rsplit_once('_')?.0.parse().ok(),
            None => file.strip_suffix(ENDING)?.parse().ok(),
        };
        let names: BTreeSet<Name> = files.filter_map(of).collect();
        for name in names.into_iter().take(MAX_AIRCRAFT) {
            let text = std::fs::read(archive.path(&name)).ok();
            let (numbers, unread) = text.and_then(|text| of_text(&text)).unwrap_or_default();
            let kept = Inventory { unread: Some(unread), ..Inventory::of(numbers) };
            archive.lock().insert(name, kept);
        }
        Ok(archive)
    }

    fn path(&self, name: &Name) -> PathBuf {
        self.config.folder.join(format!("{name}{ENDING}"))
    }

    /// What the files of an aircraft have beyond its note. It blocks.
    fn read(&self, name: &Name, unread: &Unread) -> Numbers {
        let mut numbers = Numbers::new();
        let shelf = Shelf::new(self.config.folder.clone(), prefix(name.as_str()));
        let mut names = shelf.names().unwrap_or_default();
        match &unread.file {
            Some(file) if unread.is_ended => names.retain(|name| shelf::age(name) > shelf::age(file)),
            Some(file) => names.retain(|name| shelf::age(name) >= shelf::age(file)),
            None => drop(names.drain(..names.len().saturating_sub(1))),
        }
        for file in names {
            let records = Shelf::file(&self.config.folder.join(file)).ok();
            for record in records.into_iter().flat_map(|(_, records, _)| records) {
                numbers.entry((record.boot, record.stream)).or_default().have.add(record.number, record.number);
            }
        }
        numbers
    }

    /// Reads what the files have beyond the notes, one aircraft after the other: a program that was killed noted it no
    /// more.
    async fn read_all(self: &Arc<Self>) {
        loop {
            let next = self.lock().iter().find_map(|(name, kept)| Some((name.clone(), kept.unread.clone()?)));
            let Some((name, unread)) = next else { return };
            let (archive, of) = (self.clone(), name.clone());
            // A join error is a panic, which has been reported.
            let read = tokio::task::spawn_blocking(move || archive.read(&of, &unread)).await.unwrap_or_default();
            self.with(&name, |_, kept| {
                kept.unread = None;
                merge(&mut kept.noted, &read);
                kept.fill.add(&read);
            });
        }
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<Name, Inventory>> {
        self.aircraft.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does something with an aircraft, which may be a new one.
    fn with(&self, name: &Name, act: impl FnOnce(&Self, &mut Inventory)) {
        let mut all = self.lock();
        if let Some(kept) = all.get_mut(name) {
            return act(self, kept);
        }
        if all.len() < MAX_AIRCRAFT {
            act(self, all.entry(name.clone()).or_insert_with(|| Inventory::of(Numbers::new())));
        } else {
            self.is_full.call_once(|| {
                tracing::warn!("no history of {name} and those after it: it is kept of {MAX_AIRCRAFT} aircraft");
            });
        }
    }

    /// A state was heard; these are its bytes.
    pub(in crate::carrier) fn on_state(&self, name: &Name, state: &State, bytes: &[u8], now: MonoTime) {
        self.with(name, |archive, kept| {
            let utc_ms = i64::try_from(archive.clock.unix_us() / 1000).unwrap_or(i64::MAX);
            let offset = utc_ms.saturating_sub(i64::try_from(state.clock_ms).unwrap_or(i64::MAX));
            let known = kept.offset.filter(|(boot, _)| *boot == state.boot);
            if known.is_none() || state.sequence > kept.last_state + 1 {
                kept.fill.on_hole(now);
            }
            kept.last_state = state.sequence;
            kept.offset = Some((state.boot, known.map_or(offset, |(_, known)| known.min(offset))));
            kept.keep(archive, name, Stream::State, (state.boot, state.sequence, state.clock_ms), bytes);
        });
    }

    /// The same of an event.
    pub(in crate::carrier) fn on_event(&self, name: &Name, event: &Event, bytes: &[u8]) {
        self.with(name, |archive, kept| {
            kept.keep(archive, name, Stream::Event, (event.boot, event.number, event.clock_ms), bytes);
        });
    }

    /// An aircraft is there again.
    pub(in crate::carrier) fn on_present(&self, name: &Name, now: MonoTime) {
        self.with(name, |_, kept| kept.fill.on_present(now));
    }

    /// Requests missing records from the aircraft that are present, and writes notes; for ever. Of those that are
    /// commanded from here one at a time: they may share an uplink, and their answers come first.
    pub(in crate::carrier) async fn fill(
        self: Arc<Self>,
        session: impl Fn() -> Session,
        is_present: impl Fn(&Name) -> bool,
        is_ours: impl Fn(&Name) -> bool,
        now: impl Fn() -> MonoTime + Clone + Send + 'static,
    ) {
        // Nothing is asked of an aircraft before its files were read.
        let asking = self.ask_all(session, is_present, is_ours, now);
        tokio::join!(self.read_all(), asking);
    }

    async fn ask_all(
        self: &Arc<Self>,
        session: impl Fn() -> Session,
        is_present: impl Fn(&Name) -> bool,
        is_ours: impl Fn(&Name) -> bool,
        now: impl Fn() -> MonoTime + Clone + Send + 'static,
    ) {
        let (turn, mut last) = (Arc::new(Semaphore::new(1)), None);
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut note_due = now() + NOTE_EVERY;
        loop {
            tick.tick().await;
            for name in from_behind(self.due(now()), last.as_ref()) {
                let turn = if is_ours(&name) { Some(turn.clone().try_acquire_owned()) } else { None };
                let Ok(turn) = turn.transpose() else { continue };
                let Some(question) = is_present(&name).then(|| self.question(&name, now())).flatten() else { continue };
                if turn.is_some() {
                    last = Some(name.clone());
                }
                let (archive, session, now) = (self.clone(), session(), now.clone());
                tokio::spawn(async move {
                    let answer = ask(&session, &archive.org, &name, &question).await;
                    archive.on_answer(&name, &question, answer, now());
                    drop(turn);
                });
            }
            if now() >= note_due {
                note_due = now() + NOTE_EVERY;
                let archive = self.clone();
                // A join error is a panic, which has been reported.
                let _ = tokio::task::spawn_blocking(move || archive.note(NOTES_AT_ONCE)).await;
            }
        }
    }

    /// Those of whom something may be to be asked, in order.
    fn due(&self, now: MonoTime) -> Vec<Name> {
        let is_due = |(_, kept): &(&Name, &Inventory)| kept.may_ask() && kept.fill.is_due(now);
        self.lock().iter().filter(is_due).map(|(name, _)| name.clone()).collect()
    }

    fn question(&self, name: &Name, now: MonoTime) -> Option<Question> {
        let mut all = self.lock();
        let kept = all.get_mut(name).filter(|kept| kept.may_ask())?;
        kept.fill.ask(now)
    }

    fn on_answer(&self, name: &Name, question: &Question, answer: Option<Vec<u8>>, now: MonoTime) {
        self.with(name, |archive, kept| {
            let is_used = match (question, &answer) {
                (_, None) => false,
                (Question::Index(_), Some(bytes)) => {
                    Index::read(bytes).is_ok_and(|index| kept.fill.on_index(&index, now))
                }
                (Question::Piece(_), Some(bytes)) => {
                    match Piece::read(bytes).and_then(|piece| kept.fill.on_piece(&piece, now)) {
                        Ok(records) => {
                            for record in records {
                                let (boot, stream, number) = (record.boot, record.stream, record.number);
                                if !kept.put(archive, name, record) {
                                    kept.fill.drop_again(boot, stream, number);
                                }
                            }
                            true
                        }
                        Err(error) => {
                            tracing::warn!(aircraft = %name, %error, "a piece of its history is not used");
                            false
                        }
                    }
                }
            };
            if !is_used {
                kept.fill.on_silence(now);
            }
        });
    }

    /// Writes down what the files have, as far as that is on the disk; so many notes at most. It blocks.
    fn note(&self, most: usize) {
        let (mut texts, mut turn) = (Vec::new(), self.noted_last.lock().unwrap_or_else(PoisonError::into_inner));
        let mut all = self.lock();
        for name in from_behind(all.keys().cloned().collect(), turn.as_ref()) {
            let Some(kept) = all.get_mut(&name) else { continue };
            kept.look(&name);
            if texts.len() == most || !kept.may_ask() {
                continue;
            }
            if let Some(text) = kept.next_note() {
                texts.push((self.path(&name), text));
                *turn = Some(name);
            }
        }
        drop(all);
        for (path, text) in texts {
            if let Err(error) = vencejo_store::write(&path, &text, Access::Usual) {
                tracing::warn!(path = %path.display(), %error, "it cannot be written down what the archive has");
            }
        }
    }

    /// Writes what waits, ends the files and notes what they have. It blocks.
    pub(in crate::carrier) fn close(&self) {
        let recorders = self.recorders.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(recorders) = recorders {
            recorders.close();
        }
        // Once for what there is, and once to write it.
        self.note(usize::MAX);
        self.note(usize::MAX);
    }
}

impl Inventory {
    fn of(numbers: Numbers) -> Self {
        Self {
            noted: numbers.clone(),
            fill: Fill::new(numbers),
            line: None,
            put: 0,
            missed: (0, 0),
            offset: None,
            last_state: 0,
            pending: None,
            unread: None,
            file: None,
            problem: None,
        }
    }

    /// Whether it is known what there is, and can be added to.
    fn may_ask(&self) -> bool {
        self.problem.is_none() && self.unread.is_none()
    }

    /// Looks at how its files are doing, and tells it where that has changed.
    fn look(&mut self, name: &Name) {
        let Some(line) = &self.line else { return };
        let status = line.status();
        let problem = status.state.problem().filter(|_| status.state != RecorderState::Closed);
        if let RecorderState::Recording { file } = &status.state {
            self.file = Some(file.clone());
        }
        match (&self.problem, &problem) {
            (None, Some(problem)) => {
                tracing::error!(aircraft = %name, problem, "its history is not kept; it is tried on, and fetched again");
            }
            (Some(_), None) => tracing::info!(aircraft = %name, "its history is kept again"),
            _ => {}
        }
        let missed = (status.dropped, status.failures);
        if problem.is_some() || missed != self.missed {
            // What was on its way did not arrive, or perhaps not: it is fetched again.
            (self.missed, self.pending) = (missed, None);
            self.fill.back_to(self.noted.clone());
        }
        self.problem = problem;
    }

    /// What is to be noted now: what the files had at an earlier look, where that is on the disk by now.
    fn next_note(&mut self) -> Option<Vec<u8>> {
        let status = self.line.as_ref().map(Line::status);
        let safe = status.as_ref().map_or(0, |status| status.synced + status.dropped);
        let ready = self.pending.take_if(|pending| pending.put <= safe);
        if self.pending.is_none() {
            let numbers = self.fill.remembered(MAX_BOOTS);
            let is_ended = status.is_some_and(|status| status.state == RecorderState::Closed);
            let unread = Unread { file: self.file.clone(), is_ended: is_ended && self.file.is_some() };
            let has_news = is_ended || numbers != self.noted;
            self.pending = has_news.then_some(Pending { numbers, unread, put: self.put });
        }
        let Pending { numbers, unread, .. } = ready?;
        let text = to_text(&numbers, unread);
        self.noted = numbers;
        Some(text)
    }

    /// Something was heard.
    fn keep(&mut self, archive: &Archive, name: &Name, stream: Stream, of: (u64, u64, u64), data: &[u8]) {
        let (boot, number, clock_ms) = of;
        // While the disk takes nothing it is tried with all that comes, and nothing counts as kept.
        if self.problem.is_some() || self.fill.take(boot, stream, number) {
            let unix_ns = archive.clock.unix_us().saturating_mul(1000);
            let record = Record { stream, boot, number, clock_ms, unix_ns, data: data.to_vec() };
            if !self.put(archive, name, record) {
                self.fill.drop_again(boot, stream, number);
            }
        }
    }

    /// Has a record written, with UTC as it is known here; whether it was taken. Never waits.
    fn put(&mut self, archive: &Archive, name: &Name, record: Record) -> bool {
        if self.line.is_none() {
            let about = About { org: archive.org.to_string(), aircraft: name.to_string(), side: "ground" };
            let recorders = archive.recorders.lock().unwrap_or_else(PoisonError::into_inner);
            self.line = recorders.as_ref().map(|recorders| recorders.add(Journal::new(about)));
        }
        let Some(line) = &self.line else { return false };
        let Record { stream, boot, number, clock_ms, unix_ns, data } = record;
        let heard = self.offset.filter(|(heard, _)| *heard == boot);
        let here = heard.and_then(|(_, offset)| u64::try_from(offset.checked_add_unsigned(clock_ms)?).ok());
        let unix_ns = here.map_or(unix_ns, |ms| ms.saturating_mul(1_000_000));
        let at = archive.clock.now();
        let item = Item { at, unix_ns: Some(unix_ns), stream: Some(stream), boot, number, clock_ms, data };
        let is_taken = line.handle().offer(item);
        self.put += u64::from(is_taken);
        is_taken
    }
}

/// Queries an aircraft; `None` without an answer.
async fn ask(session: &Session, org: &Name, name: &Name, question: &Question) -> Option<Vec<u8>> {
    let (kind, payload) = match question {
        Question::Index(nonce) => (Kind::HistoryIndex, IndexWanted { nonce: *nonce }.encode_to_vec()),
        Question::Piece(wanted) => (Kind::HistoryChunk, wanted.encode_to_vec()),
    };
    let get = session
        .get(key_of(org, name, kind))
        .payload(payload)
        .target(QueryTarget::All)
        .consolidation(ConsolidationMode::None)
        .congestion_control(CongestionControl::Drop)
        .priority(Priority::Background)
        .timeout(ANSWER_WITHIN);
    let replies = get.await.ok()?;
    let sample = replies.recv_async().await.ok()?.into_result().ok()?;
    let payload = sample.payload();
    (payload.len() <= MAX_ANSWER_BYTES).then(|| payload.to_bytes().into_owned())
}

#[cfg(test)]
mod tests;
