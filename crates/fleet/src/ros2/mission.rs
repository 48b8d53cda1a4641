//! Missions as MAVROS has them: the list of the wire, in which item 0 is home on ArduPilot.

use vencejo_flight::plan::{Command, Home, MAX_ITEMS, Mission, MissionItem, move_jumps};
use vencejo_proto::MissionSeq;

use super::message::{Waypoint, WaypointList};

impl Waypoint {
    fn of(item: &MissionItem) -> Self {
        let number = |index: usize| item.params[index].unwrap_or(f64::NAN);
        #[expect(clippy::cast_possible_truncation, reason = "the message has 32 bits, as the wire")]
        let single = |index: usize| number(index) as f32;
        Self {
            frame: item.frame.number(),
            command: item.command.0,
            is_current: false,
            autocontinue: item.autocontinue,
            param1: single(0),
            param2: single(1),
            param3: single(2),
            param4: single(3),
            x_lat: number(4),
            y_long: number(5),
            z_alt: number(6),
        }
    }

    /// The item that it stands for. Parameters 1 to 4 may be unset, which is NaN on the wire; a place may not.
    fn item(&self) -> MissionItem {
        let set = |param: f32| (!param.is_nan()).then_some(f64::from(param));
        let [p1, p2, p3, p4] = [self.param1, self.param2, self.param3, self.param4].map(set);
        MissionItem {
            command: Command(self.command),
            frame: self.frame.into(),
            params: [p1, p2, p3, p4, Some(self.x_lat), Some(self.y_long), Some(self.z_alt)],
            autocontinue: self.autocontinue,
        }
    }
}

/// How many items a mission has on the wire.
pub fn count(items: usize, has_home: bool) -> u32 {
    u32::try_from(items + usize::from(has_home && items > 0)).unwrap_or(u32::MAX)
}

/// A mission on board, and the number of the item that is flown.
pub fn list(mission: &Mission, has_home: bool, current: Option<u16>) -> WaypointList {
    let nowhere = Home { lat_deg: 0.0, lon_deg: 0.0, alt_amsl_m: 0.0 };
    let home = (has_home && !mission.items.is_empty()).then(|| mission.home.unwrap_or(nowhere).to_item());
    let mut items = mission.items.clone();
    if !has_home {
        move_jumps(&mut items, -1.0);
    }
    let mut waypoints: Vec<Waypoint> = home.iter().chain(&items).map(Waypoint::of).collect();
    let current_seq = current.unwrap_or(0);
    if let Some(flown) = current.and_then(|current| waypoints.get_mut(usize::from(current))) {
        flown.is_current = true;
    }
    WaypointList { current_seq, waypoints }
}

/// Waypoints as items, the first of which has this number of the wire.
fn items(waypoints: &[Waypoint], start: usize, has_home: bool) -> Result<Vec<MissionItem>, String> {
    if waypoints.len() > MAX_ITEMS {
        return Err(format!("{} waypoints are too many: {MAX_ITEMS} at most", waypoints.len()));
    }
    let item = |(index, waypoint): (usize, &Waypoint)| {
        let (item, seq) = (waypoint.item(), u16::try_from(start + index).unwrap_or(u16::MAX));
        item.check_sendable(MissionSeq(seq)).map_err(|error| error.to_string())?;
        Ok(item)
    };
    let mut items = waypoints.iter().enumerate().map(item).collect::<Result<Vec<_>, String>>()?;
    if !has_home {
        move_jumps(&mut items, 1.0);
    }
    Ok(items)
}

/// A whole mission that is pushed.
///
/// # Errors
/// What is wrong with it, in words.
pub fn whole(waypoints: &[Waypoint], has_home: bool) -> Result<Mission, String> {
    let mut items = items(waypoints, 0, has_home)?;
    let first = waypoints.first().filter(|_| has_home);
    let home = match first {
        None => None,
        Some(Waypoint { command, x_lat, y_long, .. }) if *command != Command::NAV_WAYPOINT.0 => {
            return Err(format!(
                "waypoint 0 is home on ArduPilot, and is not flown to: put one (command 16) before the command {command} \
                 at {x_lat}, {y_long}"
            ));
        }
        Some(_) => {
            let item = items.remove(0);
            let home = Home::from_item(&item);
            // Its height would be taken for one above the sea.
            if home.is_some() && !matches!(waypoints[0].frame, 0 | 5) {
                return Err(format!(
                    "waypoint 0 is home on ArduPilot, and is not flown to: give it a height above the sea (frame 0, it has {}), \
                     or 0 as latitude and longitude for the vehicle's own",
                    waypoints[0].frame
                ));
            }
            home
        }
    };
    if items.is_empty() {
        return Err("there is nothing to fly in it; mission/clear removes the mission on board".to_owned());
    }
    Ok(Mission { home, items })
}

/// The mission on board with some of its waypoints replaced, from that number of the wire on.
///
/// # Errors
/// What is wrong with them, in words.
pub fn spliced(on_board: Mission, start: u16, waypoints: &[Waypoint], has_home: bool) -> Result<Mission, String> {
    let start = usize::from(start);
    let (end, total) = (start + waypoints.len(), on_board.items.len() + usize::from(has_home));
    if waypoints.is_empty() {
        return Err("no waypoint is in it".to_owned());
    }
    if on_board.items.is_empty() || end > total {
        let known = count(on_board.items.len(), has_home);
        return Err(format!(
            "waypoints {start} to {} are not all on board, where {known} are, counted from 0",
            end - 1
        ));
    }
    let new = items(waypoints, start, has_home)?;
    let Some(first) = start.checked_sub(usize::from(has_home)) else {
        return Err("home is not replaced alone: send the whole mission, with start_index 0".to_owned());
    };
    let mut mission = on_board;
    mission.items.splice(first..first + new.len(), new);
    Ok(mission)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(frame: u8, command: u16, x_lat: f64, y_long: f64, z_alt: f64) -> Waypoint {
        let (param1, param2, param3, param4) = (0.0, 0.0, 0.0, f32::NAN);
        let autocontinue = true;
        Waypoint {
            frame,
            command,
            is_current: false,
            autocontinue,
            param1,
            param2,
            param3,
            param4,
            x_lat,
            y_long,
            z_alt,
        }
    }

    fn plan() -> Vec<Waypoint> {
        vec![at(0, 16, 40.0, -3.0, 600.0), at(3, 22, 40.001, -3.0, 50.0), at(3, 16, 40.01, -3.0, 80.0)]
    }

    #[test]
    fn a_list_comes_back_as_it_was_with_home_where_the_wire_has_it() {
        let mission = whole(&plan(), true).expect("a mission");
        assert_eq!(mission.home, Some(Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 }));
        assert_eq!((mission.items.len(), mission.items[0].command), (2, Command::NAV_TAKEOFF));
        assert_eq!(mission.items[0].params[3], None, "a heading that is not set");
        let told = list(&mission, true, Some(2));
        assert_eq!((told.current_seq, told.waypoints.len(), count(2, true)), (2, 3, 3));
        let current: Vec<_> = told.waypoints.iter().map(|waypoint| waypoint.is_current).collect();
        assert_eq!(current, [false, false, true]);
        assert_eq!((told.waypoints[1].command, told.waypoints[1].z_alt), (22, 50.0));
        assert_eq!(whole(&told.waypoints, true), Ok(mission.clone()));
        // PX4 has no home in it.
        let px4 = whole(&plan(), false).expect("a mission");
        assert_eq!((px4.home, px4.items.len(), list(&px4, false, None).waypoints.len()), (None, 3, 3));
        // There a jump to the first waypoint is one to 0, here to 1.
        let mut jumping = plan();
        jumping.push(Waypoint { param1: 0.0, ..at(2, 177, 0.0, 0.0, 0.0) });
        let mission = whole(&jumping, false).expect("a mission");
        assert_eq!((mission.items[3].params[0], list(&mission, false, None).waypoints[3].param1), (Some(1.0), 0.0));
        let spliced = spliced(mission.clone(), 3, &jumping[3..], false);
        assert_eq!(spliced, Ok(mission));
        // The vehicle's own home.
        let mut own = plan();
        own[0] = at(3, 16, 0.0, 0.0, 0.0);
        assert_eq!(whole(&own, true).map(|mission| mission.home), Ok(None));
        let none = Mission { home: None, items: Vec::new() };
        assert_eq!((list(&none, true, None).waypoints.len(), count(0, true)), (0, 0));
    }

    #[test]
    fn what_cannot_be_flown_is_refused_in_words() {
        let with = |index: usize, waypoint: Waypoint| {
            let mut plan = plan();
            plan[index] = waypoint;
            plan
        };
        for (waypoints, says) in [
            (vec![], "mission/clear"),
            (plan()[..1].to_vec(), "mission/clear"),
            (plan()[1..].to_vec(), "waypoint 0 is home on ArduPilot"),
            (with(0, at(3, 16, 40.0, -3.0, 50.0)), "frame 0, it has 3"),
            (with(2, at(3, 16, f64::NAN, -3.0, 50.0)), "x is NaN"),
            (with(2, at(3, 16, 40.0, f64::INFINITY, 50.0)), "y is inf"),
            (with(2, at(3, 16, 40.0, -3.0, f64::NAN)), "z is NaN"),
            (with(2, at(3, 16, 91.0, -3.0, 50.0)), "latitude goes from -90 to 90"),
            (with(2, at(3, 16, 40.0, -200.0, 50.0)), "longitude goes from"),
            (with(2, at(1, 16, 40.0, -3.0, 50.0)), "needs frame 0"),
            (with(2, Waypoint { param1: f32::INFINITY, ..at(3, 16, 40.0, -3.0, 50.0) }), "param1 is inf"),
            (vec![at(3, 16, 40.0, -3.0, 50.0); MAX_ITEMS + 1], "too many"),
        ] {
            let refused = whole(&waypoints, true);
            assert!(refused.as_ref().is_err_and(|why| why.contains(says)), "{says}: {refused:?}");
        }
    }

    #[test]
    fn some_are_replaced_where_they_are_on_board() {
        let on_board = || whole(&plan(), true).expect("a mission");
        let new = [at(3, 16, 40.02, -3.0, 90.0)];
        let changed = spliced(on_board(), 2, &new, true).expect("a mission");
        assert_eq!(changed.home, on_board().home);
        let heights: Vec<_> = changed.items.iter().map(MissionItem::alt_m).collect();
        assert_eq!(heights, [Some(50.0), Some(90.0)]);
        // Without home the same number is the next.
        let changed = spliced(on_board(), 1, &new, false).expect("a mission");
        assert_eq!(changed.items[1].alt_m(), Some(90.0));
        assert!(spliced(on_board(), 2, &new, false).is_err_and(|why| why.contains("where 2 are")));
        for (start, waypoints, says) in [
            (3, &new[..], "waypoints 3 to 3 are not all on board, where 3 are"),
            (65_535, &new[..], "65535"),
            (0, &new[..], "start_index 0"),
            (1, &[][..], "no waypoint"),
            (1, &[at(3, 16, f64::NAN, 0.0, 0.0)][..], "item 1"),
        ] {
            let refused = spliced(on_board(), start, waypoints, true);
            assert!(refused.as_ref().is_err_and(|why| why.contains(says)), "{says}: {refused:?}");
        }
        assert!(spliced(Mission { home: None, items: Vec::new() }, 1, &new, true).is_err());
    }
}
