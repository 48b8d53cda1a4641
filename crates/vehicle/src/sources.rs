//! The sources of a vehicle's messages, and whether they are one vehicle.
//!
//! A vehicle may be heard over several links, and come back on another port; two vehicles may also use one system id.
//! They are distinguished by their time since boot, their unique ids, and their positions. The source heard first is
//! followed and commanded; messages of another are taken only once it has proved to be the same vehicle, or when the
//! first is silent. A recording never replaces a live vehicle, however silent that is, and is replaced by a live one at
//! once.

use std::collections::BTreeMap;
use std::time::Duration;

use vencejo_proto::dialect::MavMessage;
use vencejo_proto::{Message, MonoTime};

use crate::telemetry::{LOST_AFTER, boot_ms_of};
use crate::vehicle::is_answer;

/// Most sources tracked per vehicle; further ones are ignored unless followed.
const MAX_SOURCES: usize = 16;
/// Tolerance between two readings of one boot clock: the delay of links.
const CLOCK_SLACK: Duration = Duration::from_secs(3);
/// Silence of the followed source after which the vehicle is followed at another source of its own, or at an
/// unidentified one.
const SILENCE: Duration = Duration::from_millis(2500);
/// The same for another peer of the same link: the vehicle came back on another port.
const MOVED: Duration = Duration::from_secs(1);
/// After this silence of the followed source, messages of the same vehicle are taken from another one, provided their
/// boot time is not older and at most this much newer.
const HICCUP: Duration = Duration::from_millis(500);
/// Consecutive differing readings that prove another vehicle: a single old datagram does not.
const PROOFS: u32 = 3;
/// Positions taken within this …
const SAME_MOMENT: Duration = Duration::from_secs(2);
/// … and this far apart belong to two vehicles, metres.
const APART_M: f64 = 500.0;
/// After this time without a message of another vehicle there is only one again.
const OVER: Duration = Duration::from_secs(10);

/// Identifies a source of messages: a link and a peer on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SourceId {
    /// The link.
    pub link: u32,
    /// The peer at its other end.
    pub peer: u32,
    /// Whether the link plays a recording.
    pub is_recording: bool,
}

/// What a source has proved to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Standing {
    /// Nothing yet; the count of consecutive differing readings.
    Unknown { differed: u32 },
    /// The followed vehicle.
    Same,
    /// Another vehicle.
    Other,
}

/// The boot clock of one source: a reading, and its rate (a simulator may run faster than real time).
#[derive(Debug, Clone, Copy)]
struct Clock {
    boot_ms: u32,
    at: MonoTime,
    /// An earlier reading, from which the rate was taken.
    anchor: (u32, MonoTime),
    rate: f64,
    /// Whether the rate has been measured.
    is_measured: bool,
}

impl Clock {
    fn read(before: Option<Self>, boot_ms: u32, at: MonoTime) -> Self {
        let fresh = Self { boot_ms, at, anchor: (boot_ms, at), rate: 1.0, is_measured: false };
        let Some(before) = before else { return fresh };
        if boot_ms < before.boot_ms {
            // Reordered on the way, or a restart: the next readings decide.
            return if before.boot_ms - boot_ms < 2000 { before } else { fresh };
        }
        let (anchor_ms, anchor_at) = before.anchor;
        let passed = at.since(anchor_at).as_secs_f64();
        let is_measured = before.is_measured || passed >= 0.5;
        let rate = if passed >= 0.5 {
            (f64::from(boot_ms - anchor_ms) / 1000.0 / passed).clamp(0.1, 200.0)
        } else {
            before.rate
        };
        let anchor = if passed >= 4.0 { (before.boot_ms, before.at) } else { before.anchor };
        Self { boot_ms, at, anchor, rate, is_measured }
    }

    /// Its present reading, seconds.
    fn now_s(&self, now: MonoTime) -> f64 {
        f64::from(self.boot_ms) / 1000.0 + now.since(self.at).as_secs_f64() * self.rate
    }
}

#[derive(Debug)]
struct Source {
    id: SourceId,
    heard_at: MonoTime,
    standing: Standing,
    clock: Option<Clock>,
    uid: Option<u64>,
    position: Option<(f64, f64, MonoTime)>,
}

impl Source {
    fn new(id: SourceId, now: MonoTime) -> Self {
        let standing = Standing::Unknown { differed: 0 };
        Self { id, heard_at: now, standing, clock: None, uid: None, position: None }
    }

    fn hear(&mut self, message: &Message, now: MonoTime) {
        self.heard_at = now;
        if let Some(boot_ms) = boot_ms_of(message) {
            self.clock = Some(Clock::read(self.clock, boot_ms, now));
        }
        match message {
            Message::Dialect(MavMessage::AUTOPILOT_VERSION(version)) if version.uid != 0 => {
                self.uid = Some(version.uid)
            }
            Message::Dialect(MavMessage::GLOBAL_POSITION_INT(position)) if (position.lat, position.lon) != (0, 0) => {
                self.position = Some((f64::from(position.lat) / 1e7, f64::from(position.lon) / 1e7, now));
            }
            _ => {}
        }
    }

    /// Whether both sources are one vehicle; `None` when that is not known.
    fn is_same_as(&self, other: &Self, now: MonoTime) -> Option<bool> {
        if let (Some(ours), Some(theirs)) = (self.uid, other.uid)
            && ours != theirs
        {
            return Some(false);
        }
        if let (Some((lat, lon, at)), Some((other_lat, other_lon, other_at))) = (self.position, other.position)
            && now.since(at) <= SAME_MOMENT
            && now.since(other_at) <= SAME_MOMENT
        {
            // A flat approximation is accurate enough at this distance.
            let (north_m, east_m) =
                ((lat - other_lat) * 111_320.0, (lon - other_lon) * 111_320.0 * lat.to_radians().cos());
            let rate = other.clock.map_or(1.0, |clock| clock.rate.max(1.0));
            if north_m.hypot(east_m) > APART_M * rate {
                return Some(false);
            }
        }
        let (ours, theirs) = (self.clock?, other.clock?);
        if now.since(ours.at) > LOST_AFTER || now.since(theirs.at) > LOST_AFTER {
            return None;
        }
        let slack = CLOCK_SLACK.as_secs_f64() * theirs.rate.max(1.0);
        let is_near = (ours.now_s(now) - theirs.now_s(now)).abs() <= slack;
        (is_near || theirs.is_measured).then_some(is_near)
    }

    /// Whether its present messages are not older than the last of the other: links may be seconds late.
    fn has_caught_up_with(&self, other: &Self) -> bool {
        self.clock.is_some_and(|ours| other.clock.is_none_or(|theirs| ours.boot_ms >= theirs.boot_ms))
    }

    /// Whether its messages are newer than those on their way from the other, which would go back in time when they
    /// arrive.
    fn is_ahead_of(&self, other: &Self, now: MonoTime) -> bool {
        let (Some(ours), Some(theirs)) = (self.clock, other.clock) else { return false };
        ours.now_s(now) - theirs.now_s(now) > HICCUP.as_secs_f64() * theirs.rate.max(1.0)
    }

    /// Whether it booted after that moment: then it is the same vehicle, restarted.
    fn began_after(&self, moment: MonoTime, now: MonoTime) -> bool {
        let age_s = self.clock.map(|clock| clock.now_s(now) / clock.rate.max(1.0));
        age_s.is_some_and(|age_s| age_s <= now.since(moment).as_secs_f64() + 1.0)
    }
}

/// How to handle a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Taken {
    /// From the followed source.
    Yes,
    /// From another source of the vehicle, and either an answer or a message not received from the followed source.
    Beside,
    /// From another source of the vehicle, and received from the followed source too: ignored, or it would overwrite
    /// newer values.
    Twice,
    /// From another vehicle, which is followed from now on because the one before is silent or a recording.
    Replaced,
    /// Not from the vehicle, or not known to be.
    No,
}

/// The sources of one vehicle.
#[derive(Debug, Default)]
pub struct Sources {
    /// The first is followed.
    list: Vec<Source>,
    /// When each kind of message last came from it, by message id.
    kinds: BTreeMap<u32, MonoTime>,
}

impl Sources {
    /// A message of the vehicle's autopilot from `id`.
    pub fn on_message(&mut self, id: SourceId, message: &Message, now: MonoTime) -> Taken {
        let Some(index) = self.find_or_add(id, now) else { return Taken::No };
        if index == 0 {
            self.list[0].hear(message, now);
            self.kinds.insert(message.id(), now);
            return Taken::Yes;
        }
        let (first, others) = self.list.split_at_mut(1);
        let (followed, source) = (&first[0], &mut others[index - 1]);
        source.hear(message, now);
        if source.id.is_recording != followed.id.is_recording {
            source.standing = Standing::Other;
            if source.id.is_recording {
                return Taken::No;
            }
            self.follow(index, false);
            return Taken::Replaced;
        }
        let silence = now.since(followed.heard_at);
        source.standing = match (source.is_same_as(followed, now), source.standing) {
            (Some(true), _) => Standing::Same,
            (None, standing) => standing,
            (Some(false), Standing::Other) => Standing::Other,
            // Without a message of the followed source meanwhile nothing is new.
            (Some(false), standing) if silence > SAME_MOMENT => standing,
            (Some(false), Standing::Unknown { differed }) if differed + 1 < PROOFS => {
                Standing::Unknown { differed: differed + 1 }
            }
            (Some(false), Standing::Unknown { .. }) => Standing::Other,
            (Some(false), Standing::Same) => Standing::Unknown { differed: 1 },
        };
        let has_caught_up = source.has_caught_up_with(followed);
        let is_ahead = source.is_ahead_of(followed, now);
        let takes_over = match source.standing {
            _ if silence > MOVED && source.began_after(followed.heard_at, now) => true,
            Standing::Same if has_caught_up => {
                silence > if source.id.link == followed.id.link { MOVED } else { SILENCE }
            }
            Standing::Same => silence > LOST_AFTER,
            Standing::Unknown { .. } => silence > SILENCE,
            Standing::Other => silence > LOST_AFTER,
        };
        let was = source.standing;
        let is_same = was == Standing::Same;
        let is_brought = self.kinds.get(&message.id()).is_some_and(|at| now.since(*at) <= LOST_AFTER);
        // A text may have been lost on its way, and is sent once.
        let is_wanted = is_answer(message) || matches!(message, Message::StatusText(_));
        let is_news = is_wanted || !is_brought || silence > HICCUP && has_caught_up && !is_ahead;
        if takes_over {
            self.follow(index, is_same);
            self.kinds.insert(message.id(), now);
        }
        match (takes_over, was) {
            (true, Standing::Other) => Taken::Replaced,
            (true, _) => Taken::Yes,
            (false, _) if is_same && is_news => Taken::Beside,
            (false, _) if is_same => Taken::Twice,
            (false, _) => Taken::No,
        }
    }

    /// Follows another source from now on.
    fn follow(&mut self, index: usize, is_same: bool) {
        self.list.swap(0, index);
        self.kinds.clear();
        if !is_same {
            // The proofs of the others were relative to the one before.
            for source in &mut self.list {
                source.standing = Standing::Unknown { differed: 0 };
            }
        }
        self.list[0].standing = Standing::Same;
    }

    fn find_or_add(&mut self, id: SourceId, now: MonoTime) -> Option<usize> {
        if let Some(index) = self.list.iter().position(|source| source.id == id) {
            return Some(index);
        }
        if self.list.len() >= MAX_SOURCES {
            let others = self.list.iter().enumerate().skip(1);
            let silent = others.filter(|(_, source)| now.since(source.heard_at) > LOST_AFTER);
            let index = silent.min_by_key(|(_, source)| source.heard_at).map(|(index, _)| index)?;
            self.list.remove(index);
        }
        self.list.push(Source::new(id, now));
        Some(self.list.len() - 1)
    }

    /// The followed source, to which commands are sent.
    pub fn followed(&self) -> Option<SourceId> {
        self.list.first().map(|source| source.id)
    }

    /// The sources known to be the vehicle that is followed and heard lately, the followed one first.
    pub fn proven(&self, now: MonoTime) -> impl Iterator<Item = SourceId> {
        let is_heard = move |source: &&Source| now.since(source.heard_at) <= LOST_AFTER;
        let others = self.list.iter().skip(1).filter(|source| source.standing == Standing::Same).filter(is_heard);
        self.list.first().into_iter().chain(others).map(|source| source.id)
    }

    /// The source of another vehicle with the same id, if one was heard lately.
    pub fn rival(&self, now: MonoTime) -> Option<SourceId> {
        let is_rival = |source: &&Source| source.standing == Standing::Other && now.since(source.heard_at) <= OVER;
        self.list.iter().skip(1).filter(is_rival).max_by_key(|source| source.heard_at).map(|source| source.id)
    }

    /// Whether this source is known to be another vehicle, or a recording where a live one is followed.
    pub fn is_rival(&self, id: SourceId) -> bool {
        self.followed().is_some_and(|followed| followed.is_recording != id.is_recording)
            || self.list.iter().skip(1).any(|source| source.id == id && source.standing == Standing::Other)
    }

    /// Follows the other vehicle from now on, by a person's choice; whether there is one.
    pub fn follow_rival(&mut self, now: MonoTime) -> bool {
        let Some(id) = self.rival(now) else { return false };
        let Some(index) = self.list.iter().position(|source| source.id == id) else { return false };
        self.follow(index, false);
        true
    }
}

#[cfg(test)]
mod tests {
    use vencejo_proto::Heartbeat;
    use vencejo_proto::dialect::{ATTITUDE_DATA, AUTOPILOT_VERSION_DATA, GLOBAL_POSITION_INT_DATA};

    use super::*;

    const A: SourceId = SourceId { link: 1, peer: 0, is_recording: false };
    const B: SourceId = SourceId { link: 2, peer: 0, is_recording: false };
    const A_MOVED: SourceId = SourceId { link: 1, peer: 7, is_recording: false };
    const RECORDING: SourceId = SourceId { link: 3, peer: 0, is_recording: true };

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(1_000_000 + ms)
    }

    fn attitude(boot_ms: u64) -> Message {
        let data = ATTITUDE_DATA { time_boot_ms: boot_ms as u32, ..ATTITUDE_DATA::default() };
        Message::Dialect(MavMessage::ATTITUDE(data))
    }

    fn heartbeat() -> Message {
        Message::Heartbeat(Heartbeat::default())
    }

    fn position(boot_ms: u64, lat: i32) -> Message {
        let data = GLOBAL_POSITION_INT_DATA {
            time_boot_ms: boot_ms as u32,
            lat,
            lon: -37_978_000,
            ..GLOBAL_POSITION_INT_DATA::default()
        };
        Message::Dialect(MavMessage::GLOBAL_POSITION_INT(data))
    }

    #[test]
    fn one_vehicle_over_two_links_is_one_and_the_second_takes_over() {
        for rate in [1, 20] {
            let mut sources = Sources::default();
            for ms in (0..10_000).step_by(100) {
                assert_eq!(sources.on_message(A, &attitude(50_000 + ms * rate), at(ms)), Taken::Yes);
                // The second is slower, and begins with what tells nothing.
                let late = 50_000 + ms.saturating_sub(700) * rate;
                let message = if ms == 0 { heartbeat() } else { attitude(late) };
                let taken = sources.on_message(B, &message, at(ms));
                // How fast its clock goes is known after half a second. What the first brings too is not taken twice.
                assert!(taken == Taken::Twice || ms <= 600, "{rate} {ms}");
                assert_eq!(sources.rival(at(ms)), None, "{rate} {ms}");
            }
            assert_eq!((sources.followed(), sources.rival(at(10_000))), (Some(A), None));
            assert_eq!(sources.proven(at(10_000)).collect::<Vec<_>>(), [A, B]);
            sources.on_message(A_MOVED, &heartbeat(), at(10_000));
            assert_eq!(sources.proven(at(10_000)).count(), 2, "one that has shown nothing is not known to be it");
            assert_eq!(sources.on_message(B, &heartbeat(), at(10_000)), Taken::Beside, "the first brings none");
            let mut over = None;
            for ms in (10_000..20_000).step_by(100) {
                sources.on_message(B, &attitude(50_000 + ms * rate), at(ms));
                over = over.or((sources.followed() == Some(B)).then_some(ms - 9_900));
            }
            assert!(over.is_some_and(|ms| ms <= 3_500), "{over:?}");
        }
    }

    // The late one was heard first: while it stalled the other was taken, and then what had been sent before that.
    #[test]
    fn when_the_late_link_stalls_and_goes_on_nothing_goes_back() {
        let (mut sources, mut queue, mut newest) = (Sources::default(), Vec::new(), 0);
        for ms in (0..20_000).step_by(100) {
            queue.push(48_000 + ms);
            let is_stalled = (8_000..9_200).contains(&ms) || (12_000..16_000).contains(&ms);
            let late = if is_stalled { Vec::new() } else { std::mem::take(&mut queue) };
            let late = late.into_iter().map(|boot_ms| (A, boot_ms));
            let early = (ms >= 4_000).then_some((B, 50_000 + ms));
            for (id, boot_ms) in late.chain(early) {
                let taken = sources.on_message(id, &attitude(boot_ms), at(ms));
                if matches!(taken, Taken::Yes | Taken::Beside) {
                    assert!(boot_ms >= newest, "{boot_ms} after {newest} at {ms}");
                    newest = boot_ms;
                }
            }
        }
        assert_eq!((sources.followed(), newest), (Some(B), 69_900), "after a long one the other is followed");
    }

    #[test]
    fn two_vehicles_of_one_id_are_told_and_the_first_is_followed() {
        let mut sources = Sources::default();
        let mut told = None;
        for ms in (0..30_000).step_by(200) {
            assert_eq!(sources.on_message(A, &attitude(600_000 + ms), at(ms)), Taken::Yes);
            if ms >= 5_000 {
                assert_eq!(sources.on_message(B, &attitude(90_000 + ms), at(ms + 50)), Taken::No);
                assert_eq!(sources.on_message(B, &heartbeat(), at(ms + 60)), Taken::No);
                told = told.or(sources.rival(at(ms + 60)).map(|id| (id, ms - 5_000)));
            }
        }
        assert!(told.is_some_and(|(id, ms)| id == B && ms <= 1_000), "{told:?}");
        assert_eq!(sources.followed(), Some(A));
        assert!(sources.is_rival(B) && !sources.is_rival(A));
        // When the first is silent, the other is all there is.
        let mut alone = Sources::default();
        for ms in (0..20_000).step_by(200) {
            if ms < 5_000 {
                alone.on_message(A, &attitude(600_000 + ms), at(ms));
            }
            let taken = alone.on_message(B, &attitude(90_000 + ms), at(ms));
            let has_replaced = taken == Taken::Replaced;
            assert_eq!(has_replaced, alone.followed() == Some(B) && ms == 10_000, "{ms}");
        }
        // A person chooses the other.
        assert!(sources.follow_rival(at(30_000)));
        assert_eq!(sources.followed(), Some(B));
        for ms in (30_000..32_000).step_by(200) {
            assert_eq!(sources.on_message(B, &attitude(90_000 + ms), at(ms)), Taken::Yes);
            assert_eq!(sources.on_message(A, &attitude(600_000 + ms), at(ms)), Taken::No);
        }
        assert_eq!(sources.rival(at(32_000)), Some(A));
        assert_eq!(sources.rival(at(50_000)), None, "it went");
    }

    #[test]
    fn vehicles_that_booted_together_differ_by_place_or_unique_id() {
        let mut sources = Sources::default();
        for ms in (0..3_000).step_by(200) {
            sources.on_message(A, &position(5_000 + ms, 403_332_000), at(ms));
            sources.on_message(B, &position(5_000 + ms, 403_932_000), at(ms));
        }
        assert_eq!(sources.rival(at(3_000)), Some(B));
        let uid =
            |uid| Message::Dialect(MavMessage::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA { uid, ..Default::default() }));
        let mut sources = Sources::default();
        sources.on_message(A, &uid(1), at(0));
        for ms in (0..1_000).step_by(200) {
            sources.on_message(A, &attitude(5_000 + ms), at(ms));
            sources.on_message(B, &uid(2), at(ms));
        }
        assert_eq!(sources.rival(at(1_000)), Some(B));
    }

    #[test]
    fn one_that_comes_back_on_another_port_is_followed_there() {
        let mut sources = Sources::default();
        for ms in (0..5_000).step_by(100) {
            sources.on_message(A, &attitude(50_000 + ms), at(ms));
        }
        let mut over = None;
        for ms in (5_000..8_000).step_by(100) {
            let taken = sources.on_message(A_MOVED, &attitude(50_000 + ms), at(ms));
            assert!(taken == Taken::Yes || ms < 6_100, "{ms}");
            assert!(taken != Taken::Twice || ms < 5_500, "seen there soon: {ms}");
            over = over.or((sources.followed() == Some(A_MOVED)).then_some(ms - 5_000));
        }
        assert!(over.is_some_and(|ms| ms <= 1_100), "{over:?}");
        // Restarted, and on another port again: its life began after it was heard last.
        let after = SourceId { peer: 8, ..A };
        assert_eq!(sources.on_message(after, &attitude(300), at(9_000)), Taken::Yes);
        assert_eq!(sources.followed(), Some(after));
    }

    #[test]
    fn a_recording_takes_no_live_vehicles_place_and_gives_its_own_up() {
        let mut sources = Sources::default();
        assert_eq!(sources.on_message(RECORDING, &attitude(600_000), at(0)), Taken::Yes);
        assert_eq!(sources.on_message(A, &heartbeat(), at(10)), Taken::Replaced);
        assert!(sources.is_rival(RECORDING) && !sources.is_rival(A));
        // It begins at boot, goes with the live one's clock, or is of another flight; the live one falls silent.
        for begin in [0, 50_000, 600_000] {
            for ms in (0..20_000).step_by(100) {
                let now = at(100_000 + ms);
                if ms < 5_000 {
                    assert_eq!(sources.on_message(A, &attitude(50_000 + ms), now), Taken::Yes);
                }
                assert_eq!(sources.on_message(RECORDING, &attitude(begin + ms), now), Taken::No);
            }
            assert_eq!((sources.followed(), sources.rival(at(120_000))), (Some(A), Some(RECORDING)));
        }
        // A person wants to see it: until the live one is heard again.
        assert!(sources.follow_rival(at(120_000)));
        assert_eq!(sources.on_message(RECORDING, &attitude(700_000), at(120_100)), Taken::Yes);
        assert_eq!(sources.on_message(A, &attitude(70_200), at(120_200)), Taken::Replaced);
        assert_eq!(sources.followed(), Some(A));
    }

    #[test]
    fn one_frame_from_each_of_many_displaces_nobody() {
        let mut sources = Sources::default();
        for ms in 0..5_000 {
            if ms % 100 == 0 {
                assert_eq!(sources.on_message(A, &attitude(50_000 + ms), at(ms)), Taken::Yes);
            }
            let stranger = SourceId { peer: 100 + ms as u32, ..A };
            assert_eq!(sources.on_message(stranger, &heartbeat(), at(ms)), Taken::No);
        }
        assert!(sources.list.len() <= MAX_SOURCES);
        assert_eq!(sources.followed(), Some(A));
    }
}
