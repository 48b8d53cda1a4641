//! STATUSTEXT: the vehicle's texts, joined from their chunks.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use vencejo_proto::{ComponentId, MonoTime, StatusText, plain};

/// Texts that are kept; the oldest go first.
pub const MAX_TEXTS: usize = 256;
/// Long texts that may be on their way at once; the oldest is released as it is.
const MAX_PARTIAL: usize = 8;
/// Most chunks of one text: 255 would be 12 kB.
const MAX_CHUNKS: usize = 16;
/// How long to wait for a chunk before the text is released with a gap.
pub const CHUNK_TIMEOUT: Duration = Duration::from_secs(1);
/// The same of a text without a number (0), which may be whole. PX4 counts its texts from 0 (`MavlinkStatustextHandler`), and
/// sends the chunks of one without a pause.
const UNNUMBERED_TIMEOUT: Duration = Duration::from_millis(300);

/// `MAV_SEVERITY`: 0 emergency, 1 alert, 2 critical, 3 error, 4 warning, 5 notice, 6 info, 7 debug.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, serde::Deserialize))]
pub struct Severity(pub u8);

impl Severity {
    /// 2: immediate action is needed.
    pub const CRITICAL: Self = Self(2);
    /// 4: something may go wrong.
    pub const WARNING: Self = Self(4);
    /// 6: for information.
    pub const INFO: Self = Self(6);

    /// Its name in MAVLink.
    pub fn name(self) -> &'static str {
        match self.0 {
            0 => "emergency",
            1 => "alert",
            2 => "critical",
            3 => "error",
            4 => "warning",
            5 => "notice",
            6 => "info",
            _ => "debug",
        }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One text of the vehicle. Untrusted: to be escaped wherever it is shown. Control characters are gone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Text {
    /// When its first chunk arrived.
    pub at: MonoTime,
    /// Its severity; lower is worse.
    pub severity: Severity,
    /// The component that wrote it.
    pub component: ComponentId,
    /// The text; "…" stands for a chunk that was lost.
    pub text: String,
}

/// The newest texts of a vehicle, and those that are still being put together.
#[derive(Debug, Default)]
pub struct StatusLog {
    texts: VecDeque<Text>,
    total: u64,
    partial: VecDeque<Partial>,
}

#[derive(Debug)]
struct Partial {
    component: ComponentId,
    id: u16,
    severity: Severity,
    /// When it was written.
    at: MonoTime,
    /// When its first chunk came.
    since: MonoTime,
    chunks: [Option<String>; MAX_CHUNKS],
    /// Number of chunks, once the last has come.
    count: Option<usize>,
}

impl Partial {
    fn is_complete(&self) -> bool {
        self.count.is_some_and(|count| self.chunks[..count].iter().all(Option::is_some))
    }

    /// When it is released as it is.
    fn until(&self) -> MonoTime {
        self.since + if self.id == 0 { UNNUMBERED_TIMEOUT } else { CHUNK_TIMEOUT }
    }

    fn into_text(self) -> Text {
        let last = self.chunks.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
        let count = self.count.unwrap_or(last);
        let mut text = String::new();
        for chunk in &self.chunks[..count] {
            text.push_str(chunk.as_deref().unwrap_or("…"));
        }
        if self.count.is_none() && self.id != 0 {
            text.push('…');
        }
        Text { at: self.at, severity: self.severity, component: self.component, text }
    }
}

impl StatusLog {
    /// The texts, oldest first, at most [`MAX_TEXTS`].
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &Text> + ExactSizeIterator {
        self.texts.iter()
    }

    /// Texts so far, those included that were dropped.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// The texts that were kept after the first `total`, oldest first.
    pub fn after(&self, total: u64) -> impl Iterator<Item = &Text> {
        let newer = usize::try_from(self.total.saturating_sub(total)).unwrap_or(usize::MAX);
        self.texts.iter().skip(self.texts.len().saturating_sub(newer))
    }

    /// Reads a STATUSTEXT that was written at some moment and comes now. Returns the text when it is whole now; others that
    /// it cuts short are kept before it.
    pub fn push(&mut self, component: ComponentId, message: &StatusText, at: MonoTime, now: MonoTime) -> Option<&Text> {
        let severity = Severity(message.severity);
        let chunk = plain(&message.text, usize::MAX);
        let chunk_seq = usize::from(message.chunk_seq);
        if message.id == 0 {
            let begun = self.partial.iter().position(|it| it.component == component && it.id == 0);
            let begins = chunk_seq == 0 && message.text.len() == StatusText::TEXT_LEN;
            let goes_on = chunk_seq > 0 && begun.is_some();
            if let Some(other) = begun.filter(|_| !goes_on).and_then(|index| self.partial.remove(index)) {
                self.keep(other.into_text());
            }
            if !begins && !goes_on {
                return Some(self.keep(Text { at, severity, component, text: chunk }));
            }
        }
        if chunk_seq >= MAX_CHUNKS {
            return None;
        }
        let position =
            self.partial.iter().position(|partial| partial.component == component && partial.id == message.id);
        let index = position.unwrap_or_else(|| {
            if self.partial.len() == MAX_PARTIAL
                && let Some(oldest) = self.partial.pop_front()
            {
                self.keep(oldest.into_text());
            }
            self.partial.push_back(Partial {
                component,
                id: message.id,
                severity,
                at,
                since: now,
                chunks: Default::default(),
                count: None,
            });
            self.partial.len() - 1
        });
        let partial = &mut self.partial[index];
        partial.chunks[chunk_seq] = Some(chunk);
        if message.text.len() < StatusText::TEXT_LEN || chunk_seq + 1 == MAX_CHUNKS {
            partial.count = Some(chunk_seq + 1);
        }
        if !partial.is_complete() {
            return None;
        }
        let whole = self.partial.remove(index)?.into_text();
        Some(self.keep(whole))
    }

    /// Releases one text whose missing chunk did not come in time; call until `None`.
    pub fn release(&mut self, now: MonoTime) -> Option<&Text> {
        let index = self.partial.iter().position(|partial| now >= partial.until())?;
        let text = self.partial.remove(index)?.into_text();
        Some(self.keep(text))
    }

    /// When [`Self::release`] is wanted.
    pub fn deadline(&self) -> Option<MonoTime> {
        self.partial.iter().map(Partial::until).min()
    }

    fn keep(&mut self, text: Text) -> &Text {
        if self.texts.len() == MAX_TEXTS {
            self.texts.pop_front();
        }
        self.total += 1;
        self.texts.push_back(text);
        self.texts.back().expect("invariant: a text was just pushed")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AUTOPILOT: ComponentId = ComponentId::AUTOPILOT;

    fn chunk(id: u16, chunk_seq: u8, text: &str) -> StatusText {
        StatusText { severity: 6, text: text.into(), id, chunk_seq }
    }

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    #[test]
    fn a_short_text_is_whole_at_once() {
        let mut log = StatusLog::default();
        let text = log.push(AUTOPILOT, &chunk(0, 0, "Throttle armed"), at(5), at(5)).expect("whole").clone();
        assert_eq!((text.text.as_str(), text.severity, text.at), ("Throttle armed", Severity::INFO, at(5)));
    }

    #[test]
    fn chunks_join_in_any_order_and_twice() {
        let first = "Requested rate for message ID 30 too fast. Increas";
        assert_eq!(first.len(), StatusText::TEXT_LEN);
        for order in [[0, 1], [1, 0]] {
            let mut log = StatusLog::default();
            let chunks = [chunk(1, 0, first), chunk(1, 1, "e SCHED_LOOP_RATE")];
            assert!(log.push(AUTOPILOT, &chunks[order[0]], at(0), at(0)).is_none());
            assert!(log.push(AUTOPILOT, &chunks[order[0]], at(1), at(1)).is_none());
            let text = log.push(AUTOPILOT, &chunks[order[1]], at(2), at(2)).expect("whole");
            assert_eq!(text.text, "Requested rate for message ID 30 too fast. Increase SCHED_LOOP_RATE");
            assert_eq!(log.deadline(), None);
        }
    }

    #[test]
    fn chunks_without_a_number_join_in_their_order() {
        let mut log = StatusLog::default();
        let first = "Arming denied: Resolve system health failures firs";
        assert!(log.push(AUTOPILOT, &chunk(0, 0, first), at(0), at(0)).is_none());
        assert!(log.push(ComponentId(154), &chunk(0, 0, "gimbal"), at(1), at(1)).is_some());
        let whole = log.push(AUTOPILOT, &chunk(0, 1, "t\t"), at(5), at(5)).expect("whole");
        assert_eq!(whole.text, format!("{first}t"));
        // It may be whole already; without its beginning a chunk stands alone.
        log.push(AUTOPILOT, &chunk(0, 0, first), at(10), at(10));
        assert_eq!(log.deadline(), Some(at(310)));
        assert_eq!(log.release(at(310)).expect("released").text, first);
        assert_eq!(log.push(AUTOPILOT, &chunk(0, 1, "t"), at(320), at(320)).expect("whole").text, "t");
        // Another one follows.
        log.push(AUTOPILOT, &chunk(0, 0, first), at(400), at(400));
        log.push(AUTOPILOT, &chunk(0, 0, "Disarmed"), at(410), at(410));
        let texts: Vec<_> = log.after(log.total() - 2).map(|text| text.text.as_str()).collect();
        assert_eq!(texts, [first, "Disarmed"]);
    }

    #[test]
    fn texts_of_two_components_do_not_mix() {
        let mut log = StatusLog::default();
        let long = "x".repeat(50);
        assert!(log.push(AUTOPILOT, &chunk(1, 0, &long), at(0), at(0)).is_none());
        let other = log.push(ComponentId(154), &chunk(1, 0, "gimbal"), at(0), at(0)).expect("whole");
        assert_eq!(other.text, "gimbal");
        assert!(log.deadline().is_some());
    }

    #[test]
    fn a_lost_chunk_is_shown_as_a_gap_after_its_time() {
        let mut log = StatusLog::default();
        let long = "x".repeat(50);
        log.push(AUTOPILOT, &chunk(7, 0, &long), at(0), at(0));
        log.push(AUTOPILOT, &chunk(7, 2, "end"), at(10), at(10));
        assert!(log.release(at(999)).is_none());
        assert_eq!(log.deadline(), Some(at(1_000)));
        assert_eq!(log.release(at(1_000)).expect("released").text, format!("{long}…end"));
        assert!(log.release(at(9_000)).is_none());
    }

    #[test]
    fn everything_is_bounded_and_clean() {
        let mut log = StatusLog::default();
        let long = "y".repeat(50);
        for id in 1..=1_000u16 {
            log.push(AUTOPILOT, &chunk(id, 0, &long), at(u64::from(id)), at(u64::from(id)));
            log.push(AUTOPILOT, &chunk(id, 200, "far"), at(u64::from(id)), at(u64::from(id)));
        }
        assert!(log.partial.len() <= MAX_PARTIAL);
        assert_eq!(log.iter().len(), MAX_TEXTS);
        assert_eq!(log.total(), 1_000 - MAX_PARTIAL as u64);
        let text = log.push(AUTOPILOT, &chunk(0, 0, "\u{1b}[31mred\u{7}\n"), at(0), at(0)).expect("whole");
        assert_eq!(text.text, "[31mred");
    }
}
