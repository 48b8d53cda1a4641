//! The archive on the ground: what is heard of each aircraft goes to the disk, and what was not heard is fetched.
//!
//! Beside the files of an aircraft stands `NAME.json`: which numbers they have, or had before they were deleted to make room, and which are
//! not to be had. It is written some seconds behind the files, so that it never has what they have not.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};
use std::time::Duration;

use prost::Message;
use serde::{Deserialize, Serialize};
use vencejo_link::{Clock, Recorder, RecorderHandle, SystemClock};
use vencejo_proto::MonoTime;
use vencejo_store::Access;
use zenoh::Session;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{ConsolidationMode, QueryTarget};

use super::shelf::Shelf;
use super::{HistoryConfig, Item, Journal, prefix};
use crate::history::fill::{ANSWER_WITHIN, Held};
use crate::history::pen::About;
use crate::history::record::{IndexWanted, MAX_ANSWER_BYTES};
use crate::history::{Fill, Index, Piece, Question, Ranges, Record, Stream};
use crate::key::{Kind, Name, key_of};
use crate::payload::{Event, State};

/// How often it is looked whether something is to be asked.
const TICK: Duration = Duration::from_millis(50);
/// How often it is written down what the files have. They are forced to the disk more often.
const NOTE_EVERY: Duration = Duration::from_secs(5);
/// Boots that are remembered of one aircraft; of more, those that it has itself.
const MAX_BOOTS: usize = 256;
/// Aircraft in an archive at most.
const MAX_AIRCRAFT: usize = vencejo_vehicle::registry::MAX_VEHICLES;
const ENDING: &str = ".json";
const FORMAT: u32 = 1;

type Numbers = BTreeMap<(u64, Stream), Held>;

/// `NAME.json`.
#[derive(Serialize, Deserialize)]
struct Noted {
    format: u32,
    streams: Vec<NotedStream>,
}

#[derive(Serialize, Deserialize)]
struct NotedStream {
    /// In hexadecimal: JavaScript has no such numbers.
    boot: String,
    stream: String,
    have: Vec<(u64, u64)>,
    lost: Vec<(u64, u64)>,
}

fn to_text(numbers: &Numbers) -> Vec<u8> {
    let stream = |(&(boot, stream), held): (&(u64, Stream), &Held)| NotedStream {
        boot: format!("{boot:016x}"),
        stream: stream.as_str().to_owned(),
        have: held.have.iter().collect(),
        lost: held.lost.iter().collect(),
    };
    let noted = Noted { format: FORMAT, streams: numbers.iter().map(stream).collect() };
    serde_json::to_vec(&noted).unwrap_or_default()
}

fn of_text(text: &[u8]) -> Option<Numbers> {
    let noted: Noted = serde_json::from_slice(text).ok().filter(|noted: &Noted| noted.format == FORMAT)?;
    let of = |ranges: Vec<(u64, u64)>| -> Ranges {
        ranges.into_iter().filter(|(first, last)| 0 < *first && first <= last && *last < u64::MAX).collect()
    };
    let streams = noted.streams.into_iter().filter_map(|noted| {
        let boot = u64::from_str_radix(&noted.boot, 16).ok()?;
        let stream = Stream::ALL.into_iter().find(|stream| stream.as_str() == noted.stream)?;
        Some(((boot, stream), Held::of(of(noted.have), of(noted.lost))))
    });
    Some(streams.collect())
}

/// One aircraft.
struct Kept {
    fill: Fill,
    /// Begins with the first that is heard.
    recorder: Option<(Recorder<Journal>, RecorderHandle<Journal>)>,
    /// UTC here less the clock on board, ms, of the boot that is heard; of the soonest sample.
    offset: Option<(u64, i64)>,
    last_state: u64,
    /// What the files had when it was noted last, and before: the earlier is on the disk for sure.
    noted: [Numbers; 2],
    /// Whether nothing was written lately.
    is_failing: bool,
}

/// The archive.
pub(in crate::carrier) struct Archive {
    config: HistoryConfig,
    org: Name,
    clock: Arc<SystemClock>,
    aircraft: Mutex<BTreeMap<Name, Kept>>,
    /// The first aircraft without a place is reported, once.
    is_full: Once,
}

impl Archive {
    /// Reads what there is. It blocks.
    pub(in crate::carrier) fn open(org: Name, config: HistoryConfig) -> Self {
        let archive =
            Self { config, org, clock: Arc::new(SystemClock::new()), aircraft: Mutex::default(), is_full: Once::new() };
        let entries = std::fs::read_dir(&archive.config.folder).into_iter().flatten().flatten();
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        let names: Vec<Name> = names.filter_map(|name| name.strip_suffix(ENDING)?.parse().ok()).collect();
        for name in names.into_iter().take(MAX_AIRCRAFT) {
            let numbers = archive.read(&name);
            archive.lock().insert(name, Kept::of(numbers));
        }
        archive
    }

    fn path(&self, name: &Name) -> PathBuf {
        self.config.folder.join(format!("{name}{ENDING}"))
    }

    /// What is noted of an aircraft, and what its newest file has beyond that.
    fn read(&self, name: &Name) -> Numbers {
        let path = self.path(name);
        let mut numbers = std::fs::read(&path).ok().and_then(|text| of_text(&text)).unwrap_or_default();
        let shelf = Shelf::new(self.config.folder.clone(), prefix(name.as_str()));
        let newest = shelf.names().unwrap_or_default().pop();
        let records = newest.and_then(|newest| Shelf::file(&self.config.folder.join(newest)).ok());
        for record in records.into_iter().flat_map(|(_, records, _)| records) {
            numbers.entry((record.boot, record.stream)).or_default().have.add(record.number, record.number);
        }
        numbers
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<Name, Kept>> {
        self.aircraft.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does something with an aircraft, which may be a new one.
    fn with(&self, name: &Name, act: impl FnOnce(&Self, &mut Kept)) {
        let mut all = self.lock();
        if let Some(kept) = all.get_mut(name) {
            return act(self, kept);
        }
        if all.len() < MAX_AIRCRAFT {
            act(self, all.entry(name.clone()).or_insert_with(|| Kept::of(Numbers::new())));
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

    /// Asks the aircraft that are there for what is missing, and notes what there is; for ever.
    pub(in crate::carrier) async fn fill(
        self: Arc<Self>,
        session: impl Fn() -> Session,
        is_present: impl Fn(&Name) -> bool,
        now: impl Fn() -> MonoTime + Clone + Send + 'static,
    ) {
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut note_due = now() + NOTE_EVERY;
        loop {
            tick.tick().await;
            for name in self.due(now()) {
                let Some(question) = is_present(&name).then(|| self.question(&name, now())).flatten() else { continue };
                let (archive, session, now) = (self.clone(), session(), now.clone());
                tokio::spawn(async move {
                    let answer = ask(&session, &archive.org, &name, &question).await;
                    archive.on_answer(&name, &question, answer, now());
                });
            }
            if now() >= note_due {
                note_due = now() + NOTE_EVERY;
                let archive = self.clone();
                // A join error would be its panic, which has been reported already.
                let _ = tokio::task::spawn_blocking(move || archive.note()).await;
            }
        }
    }

    /// Those of whom something may be to be asked.
    fn due(&self, now: MonoTime) -> Vec<Name> {
        let is_due = |(_, kept): &(&Name, &Kept)| !kept.is_failing && kept.fill.is_due(now);
        self.lock().iter().filter(is_due).map(|(name, _)| name.clone()).collect()
    }

    fn question(&self, name: &Name, now: MonoTime) -> Option<Question> {
        let mut all = self.lock();
        let kept = all.get_mut(name).filter(|kept| !kept.is_failing)?;
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
                            records.into_iter().for_each(|record| kept.put(archive, name, record));
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

    /// Writes down what the files had the last time that this was called. It blocks.
    fn note(&self) {
        let mut texts = Vec::new();
        for (name, kept) in self.lock().iter_mut() {
            let problem = kept.recorder.as_ref().and_then(|(recorder, _)| recorder.status().state.problem());
            if let Some(problem) = problem.as_ref().filter(|_| !kept.is_failing) {
                tracing::error!(aircraft = %name, problem, "its history is not kept; it is tried on, and fetched again");
            }
            kept.is_failing = problem.is_some();
            if kept.is_failing {
                // What was on its way did not arrive: it is fetched again.
                kept.fill.back_to(kept.noted[1].clone());
                continue;
            }
            if kept.noted[0] != kept.noted[1] {
                texts.push((self.path(name), to_text(&kept.noted[0])));
                kept.noted[1] = kept.noted[0].clone();
            }
            kept.noted[0] = kept.fill.remembered(MAX_BOOTS);
        }
        for (path, text) in texts {
            if let Err(error) = vencejo_store::write(&path, &text, Access::Usual) {
                tracing::warn!(path = %path.display(), %error, "it cannot be written down what the archive has");
            }
        }
    }

    /// Writes what waits, ends the files and notes what they have. It blocks.
    pub(in crate::carrier) fn close(&self) {
        let recorders: Vec<_> = self.lock().values_mut().filter_map(|kept| kept.recorder.take()).collect();
        for (recorder, _) in recorders {
            recorder.close();
        }
        // Once for what there is, and once to write it.
        self.note();
        self.note();
    }
}

impl Kept {
    fn of(numbers: Numbers) -> Self {
        let noted = [numbers.clone(), numbers.clone()];
        Self { fill: Fill::new(numbers), recorder: None, offset: None, last_state: 0, noted, is_failing: false }
    }

    /// Something was heard.
    fn keep(&mut self, archive: &Archive, name: &Name, stream: Stream, of: (u64, u64, u64), data: &[u8]) {
        let (boot, number, clock_ms) = of;
        // While the disk takes nothing it is tried with all that comes, and nothing counts as kept.
        if self.is_failing || self.fill.take(boot, stream, number) {
            let unix_ns = archive.clock.unix_us().saturating_mul(1000);
            self.put(archive, name, Record { stream, boot, number, clock_ms, unix_ns, data: data.to_vec() });
        }
    }

    /// Writes a record, with UTC as it is known here.
    fn put(&mut self, archive: &Archive, name: &Name, record: Record) {
        if self.recorder.is_none() {
            let about = About { org: archive.org.to_string(), aircraft: name.to_string(), side: "ground" };
            match Journal::recorder(about, &archive.config, archive.clock.clone()) {
                Ok(recorder) => {
                    let handle = recorder.handle();
                    self.recorder = Some((recorder, handle));
                }
                Err(error) => tracing::error!(aircraft = %name, %error, "its history is not kept"),
            }
        }
        let Some((_, handle)) = &self.recorder else { return };
        let Record { stream, boot, number, clock_ms, unix_ns, data } = record;
        let heard = self.offset.filter(|(heard, _)| *heard == boot);
        let here = heard.and_then(|(_, offset)| u64::try_from(offset.checked_add_unsigned(clock_ms)?).ok());
        let unix_ns = here.map_or(unix_ns, |ms| ms.saturating_mul(1_000_000));
        let at = archive.clock.now();
        handle.put(Item { at, unix_ns: Some(unix_ns), stream: Some(stream), boot, number, clock_ms, data });
    }
}

/// Asks an aircraft; `None`: silence, or nobody there.
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
mod tests {
    use super::*;

    #[test]
    fn what_is_noted_is_read_again() {
        let held = Held::of([(1, 5), (9, 9)].into_iter().collect(), [(6, 6)].into_iter().collect());
        let numbers: Numbers = [((u64::MAX, Stream::State), held.clone()), ((7, Stream::Audit), held)].into();
        assert_eq!(of_text(&to_text(&numbers)), Some(numbers));
        for bad in ["", "{}", r#"{"format": 2, "streams": []}"#] {
            assert_eq!(of_text(bad.as_bytes()), None, "{bad}");
        }
    }
}
