//! Progress in the mission: current item, items reached, distance and time to go.

use vencejo_flight::circled::{CircleWatch, Heard};
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::guidance::NorthEast;
use vencejo_flight::guidance::l1::L1Params;
use vencejo_flight::plan::Mission;
use vencejo_flight::progress::{Circled, ProgressOptions, remaining};
use vencejo_proto::MissionSeq;

use crate::telemetry::{MissionCurrent, MissionState, Telemetry};

/// Most items reached that are kept; no vehicle holds as many.
const MAX_REACHED: usize = 10_000;

/// Progress in the mission.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MissionProgress {
    /// Item in execution.
    pub current: Option<MissionSeq>,
    /// Items reached since the mission was loaded or begun again, each once, ascending. Of the items that an ArduPlane
    /// reaches in one moment it reports the last alone; the waypoint before an action is added where the mission is
    /// known.
    pub reached: Vec<MissionSeq>,
    /// Items in the mission, home not counted.
    pub total: Option<u16>,
    /// State of the mission, where the vehicle reports it.
    pub state: Option<MissionState>,
    /// Distance over ground to the current item.
    pub distance_to_current_m: Option<f64>,
    /// Distance over ground to the end of the mission, circles and jumps included ([`remaining`]). Needs a mission that
    /// was uploaded or downloaded here and has an end.
    pub distance_to_go_m: Option<f64>,
    /// Time for that at the present ground speed.
    pub time_to_go_s: Option<f64>,
    /// Whether it was flown to its end: the vehicle reports so, or has disarmed at its last item.
    pub is_complete: bool,
    /// How much was flown of the circle at the current item.
    pub circled: Circled,
    /// An alarm: the vehicle's target is this far from the current item of the plan read from it, metres. `None` while
    /// it is not, and where that is unknown.
    pub target_off_m: Option<f64>,
}

/// Changes of the progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Changes {
    pub current: Option<MissionSeq>,
    /// An item that was reached without being reported.
    pub passed: Option<MissionSeq>,
    pub has_completed: bool,
}

/// Follows a mission by the vehicle's messages.
#[derive(Debug, Default)]
pub(crate) struct ProgressTracker {
    /// Fingerprint of the mission that is followed; none while it has not been read.
    mission: Option<u64>,
    current: Option<u16>,
    reached: Vec<u16>,
    /// The item that was flown to before the current one; `None` where a jump or a change of mode led to that.
    before: Option<u16>,
    /// The item flown to whose end was reported last, until it is the current one again.
    passed: Option<u16>,
    /// Whether nothing was heard of the current item since the mission was set to one, or the mode changed.
    has_jumped: bool,
    is_complete: bool,
    state: Option<MissionState>,
    was_armed: bool,
    circle: CircleWatch,
    follows_mission: Option<bool>,
}

impl ProgressTracker {
    /// Whether the mission was flown to its end.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// The mission was replaced, or the vehicle restarted.
    pub fn reset(&mut self) {
        *self = Self { was_armed: self.was_armed, follows_mission: self.follows_mission, ..Self::default() };
    }

    /// The mission on board is known now. Reading a mission that is being flown keeps its progress; a mission that
    /// replaces a known one, or that we have sent, starts anew.
    pub fn on_mission(&mut self, hash: u64, is_sent: bool) {
        if is_sent || self.mission.is_some_and(|mission| mission != hash) {
            self.reset();
        }
        self.mission = Some(hash);
    }

    pub fn on_current(&mut self, current: &MissionCurrent) -> Changes {
        let mut changes = Changes::default();
        // ArduPlane reports "not started" also for a mission interrupted by a change of mode: items stay reached unless
        // it is about to be flown from the beginning.
        let comes_back = self.current.is_some_and(|before| before > 1);
        let restarts = current.seq <= 1
            && match current.state {
                Some(MissionState::NotStarted) => self.state != current.state,
                _ => comes_back && (self.is_complete || self.state == Some(MissionState::NotStarted)),
            };
        if restarts {
            self.reached.clear();
            self.is_complete = false;
        }
        match current.state {
            Some(MissionState::Complete) if !self.is_complete => {
                self.is_complete = true;
                // Known complete from the first message: nothing happened now.
                changes.has_completed = self.state.is_some();
            }
            Some(MissionState::NoMission) => self.is_complete = false,
            Some(MissionState::Active) if self.state == Some(MissionState::Complete) => self.is_complete = false,
            _ => {}
        }
        self.state = current.state;
        let has_jumped = std::mem::take(&mut self.has_jumped);
        if self.current != Some(current.seq) {
            self.before = self.current.filter(|_| !has_jumped);
            self.passed = self.passed.filter(|passed| *passed != current.seq);
            self.circle.begins(self.current.is_some());
            self.current = Some(current.seq);
            changes.current = Some(MissionSeq(current.seq));
        }
        changes
    }

    /// An item was reached. `last` is the last item of the mission, where it is known; a vehicle that says nothing of
    /// its mission's state has completed it then. `mission` is the plan on board, where it is known; `first` the seq of
    /// its first item.
    pub fn on_reached(&mut self, seq: u16, last: Option<u16>, mission: Option<&Mission>, first: u16) -> Changes {
        let passed = mission.and_then(|mission| self.passed_before(seq, mission, first));
        for seq in passed.into_iter().chain([seq]) {
            if let Err(place) = self.reached.binary_search(&seq)
                && self.reached.len() < MAX_REACHED
            {
                self.reached.insert(place, seq);
            }
            // Reported when the item is finished: one that a jump leads back to begins anew.
            if self.current == Some(seq) {
                self.circle.begins(true);
            }
        }
        let is_last = [passed, Some(seq)].contains(&last) && last.is_some();
        let has_completed = self.state.is_none() && is_last && !self.is_complete;
        self.is_complete |= has_completed;
        Changes { passed: passed.map(MissionSeq), has_completed, ..Changes::default() }
    }

    /// The item flown to that was reached just before the action `seq`, unless that was reported. ArduPilot keeps one
    /// MISSION_ITEM_REACHED to send, and overwrites that of a waypoint by that of the action behind it, which is done
    /// in the same moment (`GCS::send_mission_item_reached_message`).
    fn passed_before(&mut self, seq: u16, mission: &Mission, first: u16) -> Option<u16> {
        let is_nav = |seq: u16| {
            let item = seq.checked_sub(first).and_then(|index| mission.items.get(usize::from(index)));
            item.map(|item| item.command.is_nav())
        };
        if is_nav(seq)? {
            self.passed = Some(seq);
            return None;
        }
        let next = (seq..u16::MAX).find(|seq| is_nav(*seq) != Some(false)).filter(|seq| is_nav(*seq).is_some());
        // The new item may be told before the end of the old one, or after.
        let flown = if self.current == next { self.before } else { self.current };
        let flown = flown.filter(|flown| !self.has_jumped && is_nav(*flown) == Some(true))?;
        (self.passed.replace(flown) != Some(flown)).then_some(flown)
    }

    /// Armed or not, by the heartbeat. `last` is the last item to which the vehicle flies. ArduPlane never says that a
    /// mission which ends with a landing is complete: it lands, and disarms.
    pub fn on_armed(&mut self, is_armed: bool, last: Option<u16>) -> Changes {
        let has_disarmed = self.was_armed && !is_armed;
        self.was_armed = is_armed;
        let has_completed = has_disarmed && !self.is_complete && last.is_some() && self.current >= last;
        self.is_complete |= has_completed;
        Changes { has_completed, ..Changes::default() }
    }

    /// Whether its mode flies the mission, by the heartbeat. An ArduPlane that comes back to its mission begins the
    /// item anew.
    pub fn on_mode(&mut self, follows_mission: bool) {
        let before = self.follows_mission.replace(follows_mission);
        if before.is_some_and(|before| before != follows_mission) {
            self.on_set_current();
        }
    }

    /// It was set to an item. It begins that one, also where it is the one in execution.
    pub fn on_set_current(&mut self) {
        self.circle.begins(true);
        (self.before, self.passed, self.has_jumped) = (None, None, true);
    }

    /// A new position. `mission` is the plan on board, where it is known; `first` the seq of its first item.
    pub fn on_position(
        &mut self,
        telemetry: &Telemetry,
        mission: Option<&Mission>,
        first: u16,
        options: &ProgressOptions,
        law: &L1Params,
    ) {
        let Some(heard) = heard(telemetry) else { return };
        let index = self.current.and_then(|seq| seq.checked_sub(first)).map(usize::from);
        match mission.zip(index).and_then(|(mission, index)| mission.items.get(index)) {
            Some(item) if self.follows_mission == Some(true) => self.circle.on(&heard, item, options, law),
            _ => self.circle.elsewhere(heard.at_s),
        }
    }

    /// The whole picture. `mission` is the plan on board, where it is known; `first` the seq of its first item.
    pub fn progress(
        &self,
        telemetry: &Telemetry,
        mission: Option<&Mission>,
        first: u16,
        options: &ProgressOptions,
    ) -> MissionProgress {
        let current = telemetry.mission.map(|mission| mission.value);
        let by_plan = mission.and_then(|mission| u16::try_from(mission.items.len()).ok());
        let here = telemetry
            .position
            .and_then(|position| GeoPoint::new(position.value.lat_deg?, position.value.lon_deg?).ok());
        let groundspeed_m_s = telemetry.hud.and_then(|hud| hud.value.groundspeed_m_s);
        let circled = self.circle.circled();
        let left = mission.zip(self.current).zip(here).map(|((mission, seq), here)| {
            let index = usize::from(seq.saturating_sub(first));
            remaining(mission, index, here, circled, groundspeed_m_s, options)
        });
        let left = left.unwrap_or_default();
        let by_vehicle = telemetry.nav.and_then(|nav| nav.value.wp_distance_m);
        MissionProgress {
            current: current.map(|current| MissionSeq(current.seq)),
            reached: self.reached.iter().copied().map(MissionSeq).collect(),
            total: current.and_then(|current| current.total).or(by_plan),
            state: current.and_then(|current| current.state),
            distance_to_current_m: left.leg_m.or(by_vehicle),
            distance_to_go_m: left.distance_m.filter(|_| !self.is_complete),
            time_to_go_s: left.time_s.filter(|_| !self.is_complete),
            is_complete: self.is_complete,
            circled,
            target_off_m: None,
        }
    }
}

fn heard(telemetry: &Telemetry) -> Option<Heard> {
    let position = telemetry.position?.value;
    Some(Heard {
        at_s: f64::from(telemetry.position_boot_ms) / 1e3,
        point: GeoPoint::new(position.lat_deg?, position.lon_deg?).ok()?,
        velocity: NorthEast::new(position.velocity_north_m_s?, position.velocity_east_m_s?),
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::time::Duration;

    use vencejo_flight::geodesy::direct;
    use vencejo_flight::plan::{Command, MissionItem};

    use super::*;
    use crate::telemetry::{Hud, Position, Sampled};
    use vencejo_proto::MonoTime;

    fn current(seq: u16, state: Option<MissionState>) -> MissionCurrent {
        MissionCurrent {
            seq,
            total: Some(4),
            state,
            in_mission_mode: Some(true),
            mission_id: None,
            fence_id: None,
            rally_points_id: None,
        }
    }

    fn sampled<T>(value: T) -> Option<Sampled<T>> {
        Some(Sampled { value, at: MonoTime::ZERO + Duration::from_secs(1), invalid: false })
    }

    #[test]
    fn distance_follows_the_items_and_time_the_ground_speed() {
        let items = vec![
            MissionItem::waypoint(40.0, -3.0, 50.0),
            MissionItem::waypoint(40.0, -3.0, 50.0),
            MissionItem::waypoint(40.01, -3.0, 50.0),
            MissionItem::waypoint(40.02, -3.0, 50.0),
        ];
        let plan = Mission { home: None, items };
        let options = ProgressOptions::default();
        let mut tracker = ProgressTracker::default();
        let mission = current(3, Some(MissionState::Active));
        assert_eq!(tracker.on_current(&mission).current, Some(MissionSeq(3)));
        assert_eq!(tracker.on_current(&mission).current, None, "told once");
        let mut telemetry = Telemetry { mission: sampled(mission), ..Telemetry::default() };
        let progress = |telemetry: &Telemetry, plan| tracker.progress(telemetry, plan, 1, &options);
        assert_eq!(progress(&telemetry, Some(&plan)).distance_to_go_m, None, "no position yet");
        telemetry.position = sampled(Position { lat_deg: Some(40.0), lon_deg: Some(-3.0), ..Position::default() });
        telemetry.hud = sampled(Hud { groundspeed_m_s: Some(20.0), ..Hud::default() });
        let known = progress(&telemetry, Some(&plan));
        // 0.01° of latitude at 40° N is 1110.4 m on WGS-84.
        let to_current = known.distance_to_current_m.expect("known");
        let to_go = known.distance_to_go_m.expect("known");
        assert!((to_current - 1_110.4).abs() < 0.5, "{to_current}");
        assert!((to_go - 2_220.8).abs() < 1.0, "{to_go}");
        assert!((known.time_to_go_s.expect("known") - to_go / 20.0).abs() < 1e-9);
        assert_eq!(known.total, Some(4));
        // Without the plan the vehicle's own distance is all there is.
        assert_eq!(progress(&telemetry, None).distance_to_go_m, None);
        telemetry.hud = sampled(Hud { groundspeed_m_s: Some(0.2), ..Hud::default() });
        assert_eq!(progress(&telemetry, Some(&plan)).time_to_go_s, None);
    }

    /// Half a minute around the third item, at 20 m/s and a radius of 80 m.
    fn circles(tracker: &mut ProgressTracker, from_s: u32) -> Circled {
        let centre = GeoPoint::new(40.01, -3.0).unwrap();
        let items = vec![
            MissionItem::waypoint(40.0, -3.0, 50.0),
            MissionItem::waypoint(40.005, -3.0, 50.0),
            MissionItem::loiter_turns(40.01, -3.0, 50.0, 3.0, 80.0),
        ];
        let plan = Mission { home: None, items };
        for step in 0..=60 {
            let angle_rad = f64::from(step) * 0.5 * 20.0 / 80.0;
            let point = direct(centre, angle_rad.to_degrees(), 80.0);
            let velocity = NorthEast::from_bearing(angle_rad + PI / 2.0) * 20.0;
            let position = Position {
                lat_deg: Some(point.lat_deg()),
                lon_deg: Some(point.lon_deg()),
                velocity_north_m_s: Some(velocity.north),
                velocity_east_m_s: Some(velocity.east),
                ..Position::default()
            };
            let position_boot_ms = from_s * 1_000 + step * 500;
            let telemetry = Telemetry { position: sampled(position), position_boot_ms, ..Telemetry::default() };
            tracker.on_position(&telemetry, Some(&plan), 1, &ProgressOptions::default(), &L1Params::default());
        }
        tracker.circle.circled()
    }

    #[test]
    fn a_circle_counts_from_the_item_s_beginning_and_anew_after_another_mode() {
        let active = |seq| current(seq, Some(MissionState::Active));
        let is_half_a_minute = |circled| {
            let Circled::Flown { turns, time_s } = circled else { return false };
            (turns - 600.0 / (2.0 * PI * 80.0)).abs() < 0.05 && (time_s - 30.0).abs() < 0.6
        };
        let mut tracker = ProgressTracker::default();
        tracker.on_mode(true);
        tracker.on_current(&active(3));
        assert_eq!(circles(&mut tracker, 100), Circled::Unknown, "it circled before it was heard");
        tracker.on_current(&active(2));
        assert_eq!(circles(&mut tracker, 130), Circled::Nothing, "no circle is there");
        tracker.on_current(&active(3));
        assert!(is_half_a_minute(circles(&mut tracker, 160)));
        tracker.on_current(&active(3));
        assert_eq!(circles(&mut tracker, 190).flown().map(|(_, time_s)| time_s.round()), Some(60.0), "and goes on");
        tracker.on_mode(false);
        assert_eq!(circles(&mut tracker, 220), Circled::Nothing);
        tracker.on_mode(true);
        assert!(is_half_a_minute(circles(&mut tracker, 250)), "an ArduPlane begins the item anew");
        tracker.on_reached(3, None, None, 1);
        assert!(is_half_a_minute(circles(&mut tracker, 280)), "a jump led back to it");
        tracker.on_set_current();
        assert!(is_half_a_minute(circles(&mut tracker, 310)), "it was set to it once more");
        tracker.reset();
        tracker.on_current(&active(3));
        assert_eq!(circles(&mut tracker, 340), Circled::Unknown);
    }

    #[test]
    fn completion_is_told_once_and_undone_by_a_new_start() {
        let mut tracker = ProgressTracker::default();
        for seq in 1..=4 {
            tracker.on_current(&current(seq, Some(MissionState::Active)));
            tracker.on_reached(seq, Some(4), None, 1);
            tracker.on_reached(seq, Some(4), None, 1);
        }
        assert!(!tracker.is_complete, "the vehicle says active");
        let complete = current(4, Some(MissionState::Complete));
        assert!(tracker.on_current(&complete).has_completed);
        assert!(!tracker.on_current(&complete).has_completed);
        assert_eq!(tracker.progress(&Telemetry::default(), None, 1, &ProgressOptions::default()).reached.len(), 4);
        tracker.on_current(&current(1, Some(MissionState::Active)));
        assert!(!tracker.is_complete);
        assert!(tracker.reached.is_empty());
    }

    #[test]
    fn what_was_reached_stays_reached_when_the_mission_is_interrupted() {
        let mut tracker = ProgressTracker::default();
        tracker.on_current(&current(1, Some(MissionState::NotStarted)));
        for seq in 1..=3 {
            tracker.on_current(&current(seq, Some(MissionState::Active)));
            tracker.on_reached(seq, Some(4), None, 1);
        }
        // Another mode, then on from there; then another mode, and from the beginning (MIS_RESTART).
        tracker.on_current(&current(3, Some(MissionState::NotStarted)));
        assert_eq!(tracker.reached, [1, 2, 3]);
        tracker.on_current(&current(3, Some(MissionState::Active)));
        assert_eq!(tracker.reached, [1, 2, 3]);
        tracker.on_current(&current(3, Some(MissionState::NotStarted)));
        tracker.on_current(&current(1, Some(MissionState::Active)));
        assert!(tracker.reached.is_empty());
    }

    #[test]
    fn a_vehicle_that_says_no_state_completes_with_its_last_item() {
        let mut tracker = ProgressTracker::default();
        tracker.on_current(&current(4, None));
        assert!(!tracker.on_reached(3, Some(4), None, 1).has_completed);
        assert!(tracker.on_reached(4, Some(4), None, 1).has_completed);
        assert!(!tracker.on_reached(4, Some(4), None, 1).has_completed);
    }

    #[test]
    fn a_waypoint_that_an_action_overwrites_is_reached() {
        let waypoint = MissionItem::waypoint(40.0, -3.0, 50.0);
        let action = MissionItem::action(Command::DO_CHANGE_SPEED, [0.0, 15.0, 0.0, 0.0]);
        // 1 and 4 are flown to, 5 is the last.
        let items = vec![waypoint.clone(), action.clone(), action, waypoint.clone(), waypoint];
        let plan = Mission { home: None, items };
        let begun = || {
            let mut tracker = ProgressTracker::default();
            tracker.on_mode(true);
            tracker.on_current(&current(1, Some(MissionState::Active)));
            tracker
        };
        let reach = |tracker: &mut ProgressTracker, seq| tracker.on_reached(seq, None, Some(&plan), 1).passed;
        let flies_to =
            |tracker: &mut ProgressTracker, seq| tracker.on_current(&current(seq, Some(MissionState::Active)));
        // The action is told before the next item or after it, once or twice; also of a second round.
        for is_told_late in [false, true] {
            let mut tracker = begun();
            for _round in 0..2 {
                flies_to(&mut tracker, if is_told_late { 4 } else { 1 });
                assert_eq!(reach(&mut tracker, 2), Some(MissionSeq(1)), "late: {is_told_late}");
                flies_to(&mut tracker, 4);
                assert_eq!(reach(&mut tracker, 3), None);
                assert_eq!(tracker.reached, [1, 2, 3]);
                flies_to(&mut tracker, 1);
            }
        }
        // What is told itself is not told twice, and what a jump, a change of mode or the beginning leads past was not
        // reached.
        let mut tracker = begun();
        assert_eq!((reach(&mut tracker, 1), reach(&mut tracker, 2)), (None, None));
        let mut tracker = begun();
        tracker.on_set_current();
        assert_eq!(reach(&mut tracker, 2), None);
        flies_to(&mut tracker, 4);
        assert_eq!(reach(&mut tracker, 3), None);
        let mut tracker = begun();
        tracker.on_mode(false);
        tracker.on_mode(true);
        flies_to(&mut tracker, 4);
        assert_eq!(reach(&mut tracker, 3), None);
        assert_eq!(tracker.reached, [3]);
        assert_eq!(begun().on_reached(2, None, None, 1).passed, None, "a mission that is not known");
    }

    #[test]
    fn a_landing_is_complete_when_the_vehicle_disarms() {
        let mut tracker = ProgressTracker::default();
        tracker.on_current(&current(3, Some(MissionState::Active)));
        tracker.on_armed(true, Some(4));
        assert!(!tracker.on_armed(false, Some(4)).has_completed, "disarmed before the end");
        tracker.on_armed(true, Some(4));
        tracker.on_current(&current(4, Some(MissionState::Active)));
        assert!(tracker.on_armed(false, Some(4)).has_completed);
        assert!(!tracker.on_armed(false, Some(4)).has_completed);
        // It still says active.
        tracker.on_current(&current(4, Some(MissionState::Active)));
        assert!(tracker.is_complete);
        tracker.on_armed(true, Some(4));
        tracker.on_current(&current(1, Some(MissionState::Active)));
        assert!(!tracker.is_complete);
    }
}
