//! Owns the statistics of a link and of each component heard on it.
//!
//! Loss comes from the frame counter that each MAVLink sender puts into the frames of each of its channels (mavlink.io,
//! "Packet Loss Detection"), so it is tracked for each source and peer: a gap counts as lost until the missing frame
//! arrives late. It is a lower bound: a gap of 256 frames is not seen.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use smallvec::SmallVec;
use vencejo_proto::{Address, DecoderStats, Frame, MonoTime};

use crate::address_index::AddressIndex;
use crate::outlet::PeerId;

/// Sources counted individually on each link; frames of further ones are counted together.
pub const MAX_SOURCES_PER_LINK: usize = 256;

/// Peers of a link whose frame counters are followed for one source.
const MAX_CHANNELS: usize = 8;

/// Seconds over which rates are averaged.
const RATE_WINDOW_S: u64 = 4;

/// Frames and bytes in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Traffic {
    /// Whole frames.
    pub frames: u64,
    /// Bytes: of everything that came in, garbage included; of the frames that went out.
    pub bytes: u64,
}

/// Recent rates per second, averaged over the last full seconds (up to four).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rates {
    /// Frames received per second.
    pub frames_hz: f64,
    /// Bytes of received frames per second.
    pub bytes_hz: f64,
    /// Share of frames lost, 0 to 1. `None` when nothing was received or missed.
    pub loss_ratio: Option<f64>,
}

/// Round-trip time on this link, from TIMESYNC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RoundTrip {
    /// The latest.
    pub last: Duration,
    /// Smoothed: an eighth of each new value (RFC 6298's SRTT).
    pub smoothed: Duration,
    /// The shortest.
    pub shortest: Duration,
    /// When the latest was measured.
    pub at: MonoTime,
}

/// One component's frames as they came over one link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SourceStats {
    /// Who sent them.
    pub source: Address,
    /// Frames received and their bytes.
    pub received: Traffic,
    /// Frames that the counter says were sent and that never came.
    pub lost: u64,
    /// Frames that came again.
    pub duplicates: u64,
    /// Frames that came after a later one.
    pub reordered: u64,
    /// How often the counter began anew.
    pub restarts: u64,
    /// When the latest came.
    pub last_seen: MonoTime,
    /// The last seconds.
    pub rates: Rates,
}

/// One link, counted since it was opened, over all its connections.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LinkStats {
    /// What came in.
    pub received: Traffic,
    /// What was handed to the link to go out.
    pub sent: Traffic,
    /// Frames that could not be sent: queue full, socket full, not connected.
    pub dropped: u64,
    /// Candidates of a known message id with a wrong checksum.
    pub bad_crc: u64,
    /// Bytes that belonged to no frame.
    pub garbage_bytes: u64,
    /// Frames with a message id that the dialect does not have.
    pub unknown_ids: u64,
    /// Frames that had already come over this or another link (loops, redundant links) or that were our own.
    pub copies: u64,
    /// Lost frames of all sources.
    pub lost: u64,
    /// Share of all frames lost since the link was opened, 0 to 1.
    pub loss_ratio: Option<f64>,
    /// Frames from sources beyond [`MAX_SOURCES_PER_LINK`].
    pub overflow_frames: u64,
    /// Frames refused because their signature was missing, wrong or not new, and SETUP_SIGNING frames.
    pub refused: u64,
    /// When the last valid frame came.
    pub last_seen: Option<MonoTime>,
    /// Round trip, if it was measured.
    pub round_trip: Option<RoundTrip>,
    /// The last seconds.
    pub rates: Rates,
    /// Sources, in the order of their addresses.
    pub sources: Vec<SourceStats>,
}

/// Tracks the frame counter of one channel of a sender.
#[derive(Debug, Clone, Default)]
pub(crate) struct SequenceTracker {
    last: u8,
    /// Bit n: the frame n before `last` has come.
    window: u64,
    started: bool,
    /// Whether the counter has ever changed; some simple senders always write the same number.
    moves: bool,
    /// The last number behind `last`, and how many consecutive ones there were in a row.
    behind: u8,
    behind_run: u8,
    pub(crate) lost: u64,
    pub(crate) duplicates: u64,
    pub(crate) reordered: u64,
    pub(crate) restarts: u64,
}

impl SequenceTracker {
    /// This many consecutive numbers behind the last one mean that the sender restarted.
    const RESTART_RUN: u8 = 4;
    /// A sender that was silent for this long and comes back with a small number has restarted.
    const REBOOT_SILENCE: Duration = Duration::from_secs(2);
    const REBOOT_HIGHEST: u8 = 16;
    const WINDOW: u8 = 64;

    /// Processes a frame's number, `silence` after the one before. Returns the number of newly lost frames.
    pub(crate) fn on_frame(&mut self, sequence: u8, silence: Duration) -> u64 {
        if !self.started {
            self.start_at(sequence);
            return 0;
        }
        let ahead = sequence.wrapping_sub(self.last);
        self.moves |= ahead != 0;
        let silent = silence >= Self::REBOOT_SILENCE;
        if ahead == 0 {
            self.duplicates += u64::from(self.moves);
            return 0;
        }
        if ahead < 128 {
            self.behind_run = 0;
            let gap = u64::from(ahead - 1);
            if silent && sequence < Self::REBOOT_HIGHEST && gap >= u64::from(Self::REBOOT_HIGHEST) {
                self.restart_at(sequence);
                return 0;
            }
            self.window = if ahead < Self::WINDOW { (self.window << ahead) | 1 } else { 1 };
            self.last = sequence;
            self.lost += gap;
            return gap;
        }
        let back = ahead.wrapping_neg();
        if silent || back >= Self::WINDOW {
            self.restart_at(sequence);
            return 0;
        }
        let bit = 1u64 << back;
        if self.window & bit == 0 {
            self.window |= bit;
            self.reordered += 1;
            self.lost = self.lost.saturating_sub(1);
        } else {
            self.duplicates += 1;
        }
        self.behind_run = if sequence == self.behind.wrapping_add(1) { self.behind_run.saturating_add(1) } else { 1 };
        self.behind = sequence;
        if self.behind_run >= Self::RESTART_RUN {
            self.duplicates = self.duplicates.saturating_sub(u64::from(Self::RESTART_RUN));
            self.restart_at(sequence);
        }
        0
    }

    /// Processes the number of a frame whose checksum cannot be verified. It counts when it is the very next, so that
    /// messages unknown to the dialect are not taken for lost; a forged one hides at most one lost frame.
    fn on_unverified(&mut self, sequence: u8) {
        if self.started && sequence == self.last.wrapping_add(1) {
            self.window = (self.window << 1) | 1;
            self.last = sequence;
            self.moves = true;
        }
    }

    /// Forgets the last number, so that a reconnected link counts no loss.
    pub(crate) fn interrupt(&mut self) {
        self.started = false;
    }

    fn start_at(&mut self, sequence: u8) {
        self.last = sequence;
        self.window = u64::MAX;
        self.started = true;
        self.behind_run = 0;
    }

    fn restart_at(&mut self, sequence: u8) {
        self.start_at(sequence);
        self.restarts += 1;
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Bucket {
    second: u64,
    frames: u32,
    bytes: u32,
    lost: u32,
}

/// Counts of the last seconds.
#[derive(Debug, Clone, Default)]
struct RateMeter {
    buckets: [Bucket; RATE_WINDOW_S as usize + 1],
    since: Option<u64>,
}

impl RateMeter {
    fn on_frame(&mut self, bytes: usize, lost: u64, now: MonoTime) {
        let second = now.as_duration().as_secs();
        self.since.get_or_insert(second);
        let index = (second % self.buckets.len() as u64) as usize;
        let bucket = &mut self.buckets[index];
        if bucket.second != second {
            *bucket = Bucket { second, ..Bucket::default() };
        }
        bucket.frames = bucket.frames.saturating_add(1);
        bucket.bytes = bucket.bytes.saturating_add(bytes as u32);
        bucket.lost = bucket.lost.saturating_add(lost as u32);
    }

    fn rates(&self, now: MonoTime) -> Rates {
        let second = now.as_duration().as_secs();
        let Some(since) = self.since else { return Rates::default() };
        // The current second is incomplete: only the full ones before it count, once there is one.
        let full = (second - since.min(second)).min(RATE_WINDOW_S);
        let (from, until, seconds) = if full == 0 { (second, second + 1, 1) } else { (second - full, second, full) };
        let mut sum = Bucket::default();
        for bucket in self.buckets.iter().filter(|bucket| (from..until).contains(&bucket.second)) {
            sum.frames += bucket.frames;
            sum.bytes = sum.bytes.saturating_add(bucket.bytes);
            sum.lost += bucket.lost;
        }
        let per_second = |count: u32| f64::from(count) / seconds as f64;
        Rates {
            frames_hz: per_second(sum.frames),
            bytes_hz: per_second(sum.bytes),
            loss_ratio: ratio(u64::from(sum.lost), u64::from(sum.frames)),
        }
    }
}

fn ratio(lost: u64, received: u64) -> Option<f64> {
    let sent = lost + received;
    (sent > 0).then(|| lost as f64 / sent as f64)
}

/// The frame counter of a source as it comes from one peer: a sender counts on each of its channels by itself, and two
/// vehicles may use one address.
#[derive(Debug)]
struct Channel {
    peer: PeerId,
    sequence: SequenceTracker,
    last_seen: MonoTime,
}

#[derive(Debug)]
struct SourceMeter {
    source: Address,
    received: Traffic,
    /// At most [`MAX_CHANNELS`].
    channels: SmallVec<[Channel; 1]>,
    last_seen: MonoTime,
    rates: RateMeter,
}

impl SourceMeter {
    /// The channel of a peer; where there is no room, in place of the one that was heard longest ago.
    fn channel(&mut self, peer: PeerId, now: MonoTime) -> &mut Channel {
        let known = self.channels.iter().position(|channel| channel.peer == peer);
        let index = known.unwrap_or_else(|| {
            if self.channels.len() < MAX_CHANNELS {
                self.channels.push(Channel { peer, sequence: SequenceTracker::default(), last_seen: now });
                return self.channels.len() - 1;
            }
            let oldest = self.channels.iter().enumerate().min_by_key(|(_, channel)| channel.last_seen);
            let index = oldest.map_or(0, |(index, _)| index);
            self.channels[index].peer = peer;
            self.channels[index].sequence.interrupt();
            index
        });
        &mut self.channels[index]
    }

    fn sum(&self, count: impl Fn(&SequenceTracker) -> u64) -> u64 {
        self.channels.iter().map(|channel| count(&channel.sequence)).sum()
    }
}

/// The counters of one link that the hub keeps under its lock.
pub(crate) struct LinkMeter {
    frames: u64,
    copies: u64,
    lost: u64,
    overflow_frames: u64,
    refused: u64,
    last_seen: Option<MonoTime>,
    round_trip: Option<RoundTrip>,
    rates: RateMeter,
    sources: Vec<SourceMeter>,
    index: AddressIndex,
}

impl LinkMeter {
    pub(crate) fn new() -> Self {
        Self {
            frames: 0,
            copies: 0,
            lost: 0,
            overflow_frames: 0,
            refused: 0,
            last_seen: None,
            round_trip: None,
            rates: RateMeter::default(),
            sources: Vec::new(),
            index: AddressIndex::new(),
        }
    }

    /// Counts a refused frame. It does not count as hearing the other end.
    pub(crate) fn on_refused(&mut self) {
        self.refused += 1;
    }

    /// Counts a frame. Only frames whose checksum could be verified count for their source.
    pub(crate) fn on_frame(&mut self, peer: PeerId, frame: &Frame, known: bool, now: MonoTime) {
        self.frames += 1;
        let bytes = frame.bytes().len();
        let mut lost = 0;
        if known {
            self.last_seen = Some(now);
            let source = frame.source();
            let number = self.index.get(source).or_else(|| self.add_source(source, now));
            match number.map(|number| &mut self.sources[number]) {
                Some(meter) => {
                    let channel = meter.channel(peer, now);
                    let lost_before = channel.sequence.lost;
                    lost = channel.sequence.on_frame(frame.sequence(), now.since(channel.last_seen));
                    channel.last_seen = now;
                    self.lost = (self.lost + channel.sequence.lost).saturating_sub(lost_before);
                    meter.received.frames += 1;
                    meter.received.bytes += bytes as u64;
                    meter.last_seen = now;
                    meter.rates.on_frame(bytes, lost, now);
                }
                None => self.overflow_frames += 1,
            }
        } else if let Some(number) = self.index.get(frame.source()) {
            let mut channels = self.sources[number].channels.iter_mut();
            if let Some(channel) = channels.find(|channel| channel.peer == peer) {
                channel.sequence.on_unverified(frame.sequence());
            }
        }
        self.rates.on_frame(bytes, lost, now);
    }

    fn add_source(&mut self, source: Address, now: MonoTime) -> Option<usize> {
        let number = self.sources.len();
        if number == MAX_SOURCES_PER_LINK {
            return None;
        }
        self.sources.push(SourceMeter {
            source,
            received: Traffic::default(),
            channels: SmallVec::new(),
            last_seen: now,
            rates: RateMeter::default(),
        });
        self.index.set(source, number);
        Some(number)
    }

    pub(crate) fn on_copy(&mut self) {
        self.copies += 1;
    }

    pub(crate) fn on_round_trip(&mut self, round_trip: Duration, now: MonoTime) {
        self.round_trip = Some(match self.round_trip {
            None => RoundTrip { last: round_trip, smoothed: round_trip, shortest: round_trip, at: now },
            Some(before) => RoundTrip {
                last: round_trip,
                smoothed: (before.smoothed * 7 + round_trip) / 8,
                shortest: before.shortest.min(round_trip),
                at: now,
            },
        });
    }

    /// The link has reconnected: numbers may start anywhere.
    pub(crate) fn on_connected(&mut self) {
        for channel in self.sources.iter_mut().flat_map(|source| &mut source.channels) {
            channel.sequence.interrupt();
        }
    }

    pub(crate) fn snapshot(&self, counters: &PortCounters, now: MonoTime) -> LinkStats {
        let mut sources: Vec<SourceStats> = self
            .sources
            .iter()
            .map(|meter| SourceStats {
                source: meter.source,
                received: meter.received,
                lost: meter.sum(|sequence| sequence.lost),
                duplicates: meter.sum(|sequence| sequence.duplicates),
                reordered: meter.sum(|sequence| sequence.reordered),
                restarts: meter.sum(|sequence| sequence.restarts),
                last_seen: meter.last_seen,
                rates: meter.rates.rates(now),
            })
            .collect();
        sources.sort_by_key(|source| source.source);
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        LinkStats {
            received: Traffic { frames: self.frames, bytes: read(&counters.bytes_in) },
            sent: Traffic { frames: read(&counters.frames_out), bytes: read(&counters.bytes_out) },
            dropped: read(&counters.dropped),
            bad_crc: read(&counters.bad_crc),
            garbage_bytes: read(&counters.garbage_bytes),
            unknown_ids: read(&counters.unknown_ids),
            copies: self.copies,
            lost: self.lost,
            loss_ratio: ratio(self.lost, self.frames),
            overflow_frames: self.overflow_frames,
            refused: self.refused,
            last_seen: self.last_seen,
            round_trip: self.round_trip,
            rates: self.rates.rates(now),
            sources,
        }
    }
}

/// The counters of one link that its tasks keep without a lock.
#[derive(Debug, Default)]
pub(crate) struct PortCounters {
    bytes_in: AtomicU64,
    bad_crc: AtomicU64,
    garbage_bytes: AtomicU64,
    unknown_ids: AtomicU64,
    frames_out: AtomicU64,
    bytes_out: AtomicU64,
    dropped: AtomicU64,
}

impl PortCounters {
    /// Adds what a decoder has seen since `before`.
    pub(crate) fn add_decoded(&self, before: DecoderStats, after: DecoderStats) {
        let add = |counter: &AtomicU64, before: u64, after: u64| {
            if after != before {
                counter.fetch_add(after - before, Ordering::Relaxed);
            }
        };
        add(&self.bytes_in, before.bytes, after.bytes);
        add(&self.bad_crc, before.bad_crc, after.bad_crc);
        add(&self.garbage_bytes, before.garbage_bytes, after.garbage_bytes);
        add(&self.unknown_ids, before.unknown_id, after.unknown_id);
    }

    /// Adds bytes that were received and not decoded.
    pub(crate) fn add_ignored(&self, bytes: u64) {
        self.bytes_in.fetch_add(bytes, Ordering::Relaxed);
        self.garbage_bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    pub(crate) fn add_sent(&self, bytes: usize) {
        self.frames_out.fetch_add(1, Ordering::Relaxed);
        self.bytes_out.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    pub(crate) fn add_dropped(&self, frames: u64) {
        if frames > 0 {
            self.dropped.fetch_add(frames, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{heartbeat, unknown};

    const TICK: Duration = Duration::from_millis(20);

    fn run(sequences: impl IntoIterator<Item = u8>) -> SequenceTracker {
        let mut tracker = SequenceTracker::default();
        for sequence in sequences {
            tracker.on_frame(sequence, TICK);
        }
        tracker
    }

    /// (lost, duplicates, reordered, restarts)
    fn counts(tracker: &SequenceTracker) -> (u64, u64, u64, u64) {
        (tracker.lost, tracker.duplicates, tracker.reordered, tracker.restarts)
    }

    #[test]
    fn numbers_wrap_without_loss() {
        assert_eq!(counts(&run((0..1000u32).map(|n| n as u8))), (0, 0, 0, 0));
    }

    #[test]
    fn gaps_count_and_late_frames_take_it_back() {
        assert_eq!(counts(&run([250, 251, 254, 255, 0, 3])), (4, 0, 0, 0));
        assert_eq!(counts(&run([10, 12, 11, 13])), (0, 0, 1, 0), "one late frame is no loss");
        assert_eq!(counts(&run([254, 1, 255, 0, 2])), (0, 0, 2, 0), "late over the wrap");
    }

    #[test]
    fn duplicates_are_no_loss() {
        assert_eq!(counts(&run([1, 2, 2, 3, 1, 4])), (0, 2, 0, 0));
        assert_eq!(counts(&run([7, 7, 7, 7])), (0, 0, 0, 0), "a sender that never counts sends no duplicates");
    }

    #[test]
    fn a_restart_is_no_loss() {
        assert_eq!(counts(&run((0..=100).chain(0..=50))), (0, 0, 0, 1), "far back");
        assert_eq!(counts(&run((0..=30).chain(0..=50))), (0, 0, 0, 1), "a little back");
        let mut tracker = run(0..=130);
        tracker.on_frame(2, Duration::from_secs(4));
        assert_eq!(counts(&tracker), (0, 0, 0, 1), "ahead, after a silence, near zero");
        let mut tracker = run(0..=130);
        tracker.on_frame(140, Duration::from_secs(4));
        assert_eq!(counts(&tracker), (9, 0, 0, 0), "ahead after a silence elsewhere is loss");
    }

    #[test]
    fn a_new_connection_is_no_loss() {
        let mut tracker = run(0..=10);
        tracker.interrupt();
        tracker.on_frame(99, TICK);
        assert_eq!(counts(&tracker), (0, 0, 0, 0));
    }

    #[test]
    fn rates_cover_the_last_full_seconds() {
        let mut meter = LinkMeter::new();
        let counters = PortCounters::default();
        for n in 0..500u32 {
            let now = MonoTime::from_millis(u64::from(n) * 20);
            // Every fifth frame is missing.
            if n % 5 != 4 {
                meter.on_frame(PeerId::default(), &heartbeat(1, 1, n as u8), true, now);
            }
        }
        let stats = meter.snapshot(&counters, MonoTime::from_millis(10_000));
        assert_eq!(stats.received.frames, 400);
        assert_eq!(stats.lost, 99);
        assert!((stats.rates.frames_hz - 40.0).abs() < 0.5, "{}", stats.rates.frames_hz);
        let loss = stats.rates.loss_ratio.unwrap();
        assert!((loss - 0.2).abs() < 0.01, "{loss}");
        assert_eq!(stats.sources.len(), 1);
        assert_eq!(stats.sources[0].lost, 99);
        assert_eq!(meter.snapshot(&counters, MonoTime::from_millis(60_000)).rates.frames_hz, 0.0);
    }

    #[test]
    fn each_peer_has_its_own_counter() {
        let mut meter = LinkMeter::new();
        for n in 0..200u32 {
            let now = MonoTime::from_millis(u64::from(n) * 20);
            for (peer, first) in [(1, 10), (2, 100), (3 + n / 10, 200)] {
                meter.on_frame(PeerId(peer), &heartbeat(1, 1, (first + n) as u8), true, now);
            }
        }
        let stats = meter.snapshot(&PortCounters::default(), MonoTime::from_millis(4_000));
        assert_eq!((stats.received.frames, stats.lost, stats.sources.len()), (600, 0, 1));
        assert_eq!((stats.sources[0].received.frames, stats.sources[0].restarts), (600, 0));
    }

    #[test]
    fn messages_that_the_dialect_does_not_have_are_not_missed() {
        let mut meter = LinkMeter::new();
        let mut hears = |frame: &Frame| {
            meter.on_frame(PeerId::default(), frame, frame.is_known(), MonoTime::ZERO);
            meter.snapshot(&PortCounters::default(), MonoTime::ZERO).lost
        };
        for n in (0..=252).step_by(3) {
            let frames = [heartbeat(1, 1, n), unknown(1, 1, n + 1), unknown(1, 1, n + 2)];
            assert_eq!(frames.map(|frame| hears(&frame)), [0; 3]);
        }
        let frames = [heartbeat(1, 1, 255), unknown(1, 1, 99), heartbeat(1, 1, 1)];
        assert_eq!(frames.map(|frame| hears(&frame)), [0, 0, 1], "one that is not the next may be noise");
    }

    #[test]
    fn a_flood_of_sources_is_bounded() {
        let mut meter = LinkMeter::new();
        for system in 1..=255u8 {
            for component in 1..=255u8 {
                meter.on_frame(PeerId::default(), &heartbeat(system, component, 0), true, MonoTime::ZERO);
            }
        }
        let stats = meter.snapshot(&PortCounters::default(), MonoTime::ZERO);
        assert_eq!(stats.sources.len(), MAX_SOURCES_PER_LINK);
        assert_eq!(stats.overflow_frames, 255 * 255 - MAX_SOURCES_PER_LINK as u64);
    }

    #[test]
    fn round_trips_are_smoothed() {
        let mut meter = LinkMeter::new();
        for ms in [80, 160] {
            meter.on_round_trip(Duration::from_millis(ms), MonoTime::ZERO);
        }
        let round_trip = meter.snapshot(&PortCounters::default(), MonoTime::ZERO).round_trip.unwrap();
        assert_eq!(round_trip.last, Duration::from_millis(160));
        assert_eq!(round_trip.smoothed, Duration::from_millis(90));
        assert_eq!(round_trip.shortest, Duration::from_millis(80));
    }
}
