//! A `.tlog` recording as a film.

use std::io;
use std::path::Path;
use std::time::Duration;

use vencejo_link::{PlayedFrame, TlogFile};
use vencejo_proto::{Address, Message};
use vencejo_vehicle::heartbeat::is_autopilot;
use vencejo_vehicle::modes::{FlightMode, ModeFamily};
use vencejo_vehicle::{HeardPlan, Overheard};

use super::film::{Film, FilmInfo, MAX_MARKS, MAX_PLANS, Mark, MarkKind, Moment};

/// Most autopilots of one recording that are shown.
const MAX_AUTOPILOTS: usize = 16;
/// Moments that are read at once.
const AT_ONCE: usize = 256;
/// Messages of which each one counts: MISSION_ITEM_REACHED, STATUSTEXT.
const EACH: [u32; 2] = [46, 253];
/// The end of the year 9999, microseconds since 1970.
const LATEST_US: u64 = 253_402_300_799_999_999;

pub(super) struct TlogFilm {
    file: TlogFile,
    info: FilmInfo,
}

/// What is known of an autopilot while a recording is opened.
struct Told {
    from: Address,
    is_armed: bool,
    mode: FlightMode,
}

impl TlogFilm {
    /// Opens a recording, which reads it once.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let mut told: Vec<Told> = Vec::new();
        let mut marks = Vec::new();
        let (mut overheard, mut plans) = (Overheard::default(), Vec::new());
        let look = |at: Duration, frame: &vencejo_proto::Frame| {
            if !Overheard::concerns(frame.message_id()) {
                return;
            }
            let Ok(message) = frame.decode() else { return };
            let from = frame.source();
            if let Some(plan) = overheard.hear(from, &message).filter(|plan| is_new(&plans, plan)) {
                plans.push((at, plan));
            }
            let Message::Heartbeat(heartbeat) = message else { return };
            if !is_autopilot(&heartbeat) {
                return;
            }
            let family = ModeFamily::of(heartbeat.autopilot, heartbeat.mav_type);
            let mode = FlightMode { family, custom_mode: heartbeat.custom_mode };
            let is_armed = heartbeat.is_armed();
            let mut mark = |kind| {
                if marks.len() < MAX_MARKS {
                    marks.push(Mark { at, from, kind });
                }
            };
            let Some(before) = told.iter_mut().find(|one| one.from == from) else {
                if told.len() < MAX_AUTOPILOTS {
                    told.push(Told { from, is_armed, mode });
                }
                return;
            };
            if is_armed != before.is_armed {
                mark(if is_armed { MarkKind::Armed } else { MarkKind::Disarmed });
            }
            if mode != before.mode {
                mark(MarkKind::Mode(mode.to_string()));
            }
            *before = Told { from, is_armed, mode };
        };
        let file = TlogFile::open(path, &EACH, look)?;
        let info = FilmInfo {
            autopilots: told.into_iter().map(|one| one.from).collect(),
            aircraft: None,
            start_unix_us: file.start_unix_us().filter(is_date),
            duration: file.duration(),
            marks,
            plans,
            skipped_bytes: file.skipped().total(),
        };
        Ok(Self { file, info })
    }
}

/// Whether a plan is another than the one of its kind before, which a station may read again and again.
fn is_new(plans: &[(Duration, HeardPlan)], plan: &HeardPlan) -> bool {
    let is_of_it = |known: &&HeardPlan| (known.autopilot, known.kind) == (plan.autopilot, plan.kind);
    let before = plans.iter().rev().map(|(_, known)| known).find(is_of_it);
    plans.len() < MAX_PLANS && before != Some(plan)
}

/// Whether a time is one of our calendar: the stamps of a file are whatever was written.
fn is_date(unix_us: &u64) -> bool {
    *unix_us <= LATEST_US
}

fn moment(PlayedFrame { at, unix_us, frame }: PlayedFrame) -> Option<Moment> {
    let message = frame.decode().ok()?;
    Some(Moment { at, unix_us: Some(unix_us).filter(is_date), from: frame.source(), message })
}

impl Film for TlogFilm {
    fn info(&self) -> &FilmInfo {
        &self.info
    }

    fn seek(&mut self, to: Duration) -> io::Result<Vec<Moment>> {
        Ok(self.file.seek(to)?.into_iter().filter_map(moment).collect())
    }

    fn read(&mut self) -> io::Result<Vec<Moment>> {
        let mut moments = Vec::new();
        while moments.len() < AT_ONCE {
            let Some(frame) = self.file.next_frame()? else { break };
            moments.extend(moment(frame));
        }
        Ok(moments)
    }
}
