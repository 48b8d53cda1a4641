//! What a PX4 tells by EVENT alone, and not as a text: which of its checks keep it from arming, and why it rejects a
//! mission.
//!
//! Protocol: mavlink.io, "Events Interface". Events are numbered; the vehicle tells the number of the newest every 3 s
//! (CURRENT_EVENT_SEQUENCE), and sends those that it still has again (REQUEST_EVENT): v1.17 keeps 20. It reports all checks
//! that fail at once, when one changes, when arming is refused, and when RUN_PREARM_CHECKS asks for it: the last report
//! before the connection is asked for too.

mod names;

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_proto::dialect::{
    CURRENT_EVENT_SEQUENCE_DATA, EVENT_DATA, MavEventCurrentSequenceFlags, MavMessage, REQUEST_EVENT_DATA,
    RESPONSE_EVENT_ERROR_DATA,
};
use vencejo_proto::{Address, Message, MonoTime};

use crate::modes::FlightMode;
use crate::telemetry::Severity;
#[cfg(test)]
pub(crate) use names::id;
use names::{ARMING_SUMMARY, CHECKS, HEALTH_SUMMARY, REJECTIONS, text_of};

/// How the texts of checks begin, as those that PX4 itself writes.
pub(crate) const CHECK: &str = "Preflight Fail: ";
/// The same of reasons to reject a mission.
pub(crate) const REJECTED: &str = "Mission rejected: ";
/// Newest events that are kept, and asked for.
const KEPT: u16 = 20;
/// Most requests for the events up to one number.
const TRIES: u32 = 3;
/// How often what keeps failing is told, as ArduPilot repeats its texts.
const TOLD_EVERY: Duration = Duration::from_secs(30);
/// How long a report waits for the texts that PX4 writes of the same checks.
const TOLD_AFTER: Duration = Duration::from_millis(500);
/// Most reasons of rejected missions that are kept.
const MAX_REJECTIONS: usize = 16;
/// `NavModes::All`.
const ALL_MODES: u32 = u32::MAX;
/// The worst level of checks that never keep it from arming.
const WARNING: u8 = 4;

/// A check that fails.
#[derive(Debug, Clone, PartialEq)]
struct Check {
    /// The modes in which it cannot be armed, one bit each.
    modes: u32,
    level: u8,
    text: String,
}

/// The last whole report of the checks.
#[derive(Debug)]
struct Report {
    sequence: u16,
    can_arm: u32,
    checks: Vec<Check>,
}

/// Events of one vehicle.
#[derive(Debug)]
pub(crate) struct Events {
    vehicle: Address,
    /// The newest ones, each once, in any order.
    heard: Vec<EVENT_DATA>,
    newest: Option<u16>,
    /// Those up to this one are from before it was heard.
    history: Option<u16>,
    /// The oldest one that it still has.
    oldest: Option<u16>,
    /// The newest number when events were last asked for, and how often.
    asked: Option<(u16, u32)>,
    report: Option<Report>,
    /// Reasons of rejected missions, and when they came.
    rejections: VecDeque<(MonoTime, String)>,
    /// Checks that were told, and when.
    told: Vec<(String, MonoTime)>,
    tell_at: Option<MonoTime>,
}

fn is_before(sequence: u16, other: u16) -> bool {
    (sequence.wrapping_sub(other) as i16) < 0
}

fn number(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | u32::from(*byte))
}

/// The bit of a mode among those of the checks: its number among PX4's `nav_state`.
fn bit_of(mode: FlightMode) -> Option<u32> {
    let nav_state = match ((mode.custom_mode >> 16) & 0xff, mode.custom_mode >> 24) {
        (1, _) => 0,
        (2, _) => 1,
        (3, 1) => 21,
        (3, 2) => 6,
        (3, _) => 2,
        (4, 2) => 17,
        (4, 3) => 4,
        (4, 4) => 3,
        (4, 5) => 5,
        (4, 6) => 18,
        (4, 8) => 19,
        (4, 9) => 20,
        (4, 10) => 22,
        (4, external @ 11..=18) => 12 + external,
        (5, _) => 10,
        (6, _) => 14,
        (7, _) => 15,
        _ => return None,
    };
    Some(1 << nav_state)
}

impl Events {
    pub fn new(vehicle: Address) -> Self {
        Self {
            vehicle,
            heard: Vec::new(),
            newest: None,
            history: None,
            oldest: None,
            asked: None,
            report: None,
            rejections: VecDeque::new(),
            told: Vec::new(),
            tell_at: None,
        }
    }

    /// The vehicle restarted, or is another one.
    pub fn reset(&mut self) {
        *self = Self::new(self.vehicle);
    }

    /// Reads an event. Returns the reason of a mission's rejection that it tells now, and a request for what was lost
    /// before it.
    pub fn on_event(&mut self, event: &EVENT_DATA, now: MonoTime) -> (Option<String>, Option<Message>) {
        if self.heard.iter().any(|heard| heard.sequence == event.sequence) {
            return (None, None);
        }
        let has_gap = self.newest.is_some_and(|newest| is_before(newest.wrapping_add(1), event.sequence));
        let newest = self.newest.filter(|newest| is_before(event.sequence, *newest)).unwrap_or(event.sequence);
        self.newest = Some(newest);
        let history = *self.history.get_or_insert(event.sequence.wrapping_sub(1));
        self.heard.push(event.clone());
        self.heard.retain(|event| newest.wrapping_sub(event.sequence) < KEPT);
        if self.read_report() {
            self.tell_at = Some(now + TOLD_AFTER);
        }
        let is_news = is_before(history, event.sequence);
        let rejection = text_of(REJECTIONS, event.id, &event.arguments).filter(|_| is_news);
        if let Some(reason) = &rejection {
            if self.rejections.len() == MAX_REJECTIONS {
                self.rejections.pop_front();
            }
            self.rejections.push_back((now, reason.clone()));
        }
        (rejection, if has_gap { self.ask() } else { None })
    }

    /// Reads the number of the newest event. Returns a request for what was lost.
    pub fn on_sequence(&mut self, told: &CURRENT_EVENT_SEQUENCE_DATA) -> Option<Message> {
        let newest = told.sequence;
        if told.flags.contains(MavEventCurrentSequenceFlags::MAV_EVENT_CURRENT_SEQUENCE_FLAGS_RESET) {
            (self.report, self.asked) = (None, None);
            self.heard.clear();
            (self.newest, self.history, self.oldest) = (Some(newest), Some(newest), Some(newest.wrapping_add(1)));
            return None;
        }
        self.history.get_or_insert(newest);
        if self.newest.is_none_or(|known| is_before(known, newest)) {
            self.newest = Some(newest);
        }
        self.ask()
    }

    /// An event that it no longer has.
    pub fn on_error(&mut self, error: &RESPONSE_EVENT_ERROR_DATA) {
        self.oldest = Some(error.sequence_oldest_available);
    }

    /// A request for the events that are missing among the newest ones.
    fn ask(&mut self) -> Option<Message> {
        let newest = self.newest?;
        let is_heard = |sequence: u16| self.heard.iter().any(|event| event.sequence == sequence);
        let has = |sequence: u16| self.oldest.is_none_or(|oldest| !is_before(sequence, oldest));
        let missing = (0..KEPT).rev().map(|back| newest.wrapping_sub(back)).filter(|at| has(*at) && !is_heard(*at));
        let missing: Vec<_> = missing.collect();
        let (first_sequence, last_sequence) = (*missing.first()?, *missing.last()?);
        let tries = self.asked.filter(|(before, _)| *before == newest).map_or(0, |(_, tries)| tries);
        if tries == TRIES {
            return None;
        }
        self.asked = Some((newest, tries + 1));
        Some(Message::Dialect(MavMessage::REQUEST_EVENT(REQUEST_EVENT_DATA {
            first_sequence,
            last_sequence,
            target_system: self.vehicle.system.0,
            target_component: self.vehicle.component.0,
        })))
    }

    /// Takes the newest whole report: its beginning, the checks, its end. Whether there is a new one.
    fn read_report(&mut self) -> bool {
        let at = |sequence: u16| self.heard.iter().find(|event| event.sequence == sequence);
        let begins = self.heard.iter().filter(|event| event.id == ARMING_SUMMARY);
        let is_newer = |sequence: u16| self.report.as_ref().is_none_or(|report| is_before(report.sequence, sequence));
        let mut found: Option<Report> = None;
        for begin in begins.filter(|begin| is_newer(begin.sequence)) {
            let mut checks = Vec::new();
            let mut next = begin.sequence.wrapping_add(1);
            let is_whole = loop {
                let Some(event) = at(next).filter(|event| event.id != ARMING_SUMMARY) else { break false };
                if event.id == HEALTH_SUMMARY {
                    break true;
                }
                let [modes, arguments] = [&event.arguments[..4], &event.arguments[5..]];
                let text = text_of(CHECKS, event.id, arguments)
                    .unwrap_or_else(|| format!("a check that is not known here (event {:#010x})", event.id));
                checks.push(Check { modes: number(modes), level: event.log_levels & 0xf, text });
                next = next.wrapping_add(1);
            };
            if is_whole && found.as_ref().is_none_or(|report| is_before(report.sequence, begin.sequence)) {
                let can_arm = number(&begin.arguments[9..13]);
                found = Some(Report { sequence: begin.sequence, can_arm, checks });
            }
        }
        let is_new = found.is_some();
        self.report = found.or(self.report.take());
        is_new
    }

    /// The checks that keep it from being armed in a mode, worst first; `None` while it has reported none. Optional checks,
    /// which concern all modes as well, are left out where another one explains it.
    pub fn failing(&self, mode: FlightMode) -> Option<Vec<(Severity, String)>> {
        let report = self.report.as_ref()?;
        let bit = bit_of(mode)?;
        if report.can_arm & bit != 0 {
            return Some(Vec::new());
        }
        let concern = report.checks.iter().filter(|check| check.modes & bit != 0);
        let mut failing: Vec<_> =
            concern.clone().filter(|check| check.level < WARNING || check.modes != ALL_MODES).collect();
        if failing.is_empty() {
            failing = concern.collect();
        }
        failing.sort_by_key(|check| check.level);
        // One that bars arming is no mere information.
        let text = |check: &Check| (Severity(check.level.min(Severity::WARNING.0)), format!("{CHECK}{}", check.text));
        Some(failing.into_iter().map(text).collect())
    }

    /// Why missions were rejected since.
    pub fn rejections(&self, since: MonoTime) -> Vec<String> {
        let mut reasons = Vec::new();
        for (_, reason) in self.rejections.iter().filter(|(at, _)| *at >= since) {
            if !reasons.contains(reason) {
                reasons.push(reason.clone());
            }
        }
        reasons
    }

    /// The mode or the arming has changed: another check may count.
    pub fn on_mode(&mut self, now: MonoTime) {
        if self.report.is_some() {
            self.tell_at = Some(self.tell_at.map_or(now, |at| at.min(now)));
        }
    }

    /// What is to be told now of the checks that keep it from being armed in this mode, the present one of a disarmed
    /// vehicle: what has begun to fail, and what fails still after a while.
    pub fn due_texts(&mut self, mode: Option<FlightMode>, now: MonoTime) -> Vec<(Severity, String)> {
        if self.tell_at.is_none_or(|at| now < at) {
            return Vec::new();
        }
        let failing = mode.and_then(|mode| self.failing(mode)).unwrap_or_default();
        self.told.retain(|(told, at)| now.since(*at) < TOLD_EVERY && failing.iter().any(|(_, text)| text == told));
        let is_told = |text: &String| self.told.iter().any(|(told, _)| told == text);
        let news: Vec<_> = failing.into_iter().filter(|(_, text)| !is_told(text)).collect();
        self.told.extend(news.iter().map(|(_, text)| (text.clone(), now)));
        self.tell_at = self.told.iter().map(|(_, at)| *at + TOLD_EVERY).min();
        news
    }

    /// When [`Self::due_texts`] is wanted.
    pub fn deadline(&self) -> Option<MonoTime> {
        self.tell_at
    }
}
