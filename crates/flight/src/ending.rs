//! How a mission ends: the landing or return that everything else goes before, and from where the plane comes to it.

use crate::approaches::designed_items;
use crate::geodesy::{GeoPoint, inverse, wrap_180_deg};
use crate::landing::{LandingOptions, Wind};
use crate::plan::{Command, Mission, MissionItem};
use crate::progress::rel_home_m;
use crate::way::Way;

/// Points of an approach lie in line within this angle, degrees.
const IN_LINE_DEG: f64 = 5.0;
/// Wind from which on a mission is ended against it, and not straight on from where the plane comes, m/s.
const BREEZE_M_S: f64 = 2.0;

/// The end of a mission.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct MissionEnd {
    /// The first item of the landing that ends it, its approach with it, or the return; counted from 1, the number of
    /// items plus one where it ends with neither. What is added "at the end" belongs before it.
    pub item: usize,
    /// The first item of that landing where it is as one is designed, so that parts of it can be moved; null where it
    /// is not.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub designed_item: Option<usize>,
}

/// How a mission ends. Its approach is the circle down before the landing with what begins the sequence, or all that
/// goes down to it in a line.
pub fn mission_end(mission: &Mission) -> MissionEnd {
    let items = &mission.items;
    let mut index = items.len();
    match items.last().map(|last| last.command) {
        Some(Command::NAV_RETURN_TO_LAUNCH) => index -= 1,
        Some(command) if command.is_landing() => {
            index -= 1;
            while index > 0 && is_approach(mission, index - 1) {
                index -= 1;
            }
        }
        _ => {}
    }
    MissionEnd { item: index + 1, designed_item: designed_items(items).map(|count| items.len() - count + 1) }
}

fn is_approach(mission: &Mission, index: usize) -> bool {
    let [item, after] = [index, index + 1].map(|index| &mission.items[index]);
    match item.command {
        Command::DO_LAND_START => return true,
        Command::NAV_LOITER_TO_ALT => return after.command.is_landing(),
        Command::NAV_WAYPOINT => {}
        _ => return false,
    }
    let home_m = mission.home.map(|home| home.alt_amsl_m);
    let (Some(high_m), Some(low_m)) = (rel_home_m(item, home_m), rel_home_m(after, home_m)) else { return false };
    let (Some(at), Some(next)) = (item.point(), after.point()) else { return false };
    if high_m <= low_m {
        return false;
    }
    let onward = mission.items.get(index + 2).and_then(MissionItem::point);
    let course_deg = |from, to| inverse(from, to).bearing_start_deg;
    onward.is_none_or(|onward| wrap_180_deg(course_deg(at, next) - course_deg(next, onward)).abs() < IN_LINE_DEG)
}

/// From where the plane comes to the landing that ends a mission, or is to end it: from the last place on its way
/// before, else from home.
pub fn comes_from(mission: &Mission, way: &Way) -> Option<GeoPoint> {
    let MissionEnd { item: end, .. } = mission_end(mission);
    let before = way.stops.iter().rev().filter(|stop| stop.item < end);
    let place = before.filter_map(|stop| mission.items.get(stop.item - 1)?.point()).next();
    place.or_else(|| mission.home.and_then(|home| home.point().ok()))
}

/// How a landing that is to end a mission is laid out: against the wind where that is worth it, else straight on from
/// where the plane comes.
pub fn towards_end(mission: &Mission, way: &Way, options: LandingOptions) -> LandingOptions {
    let is_breeze = options.wind.is_none_or(|Wind { speed_m_s, .. }| speed_m_s < BREEZE_M_S);
    LandingOptions { coming_from: comes_from(mission, way).filter(|_| is_breeze), ..options }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy::{direct, distance_m};
    use crate::landing::design_landing;
    use crate::plan::Home;
    use crate::progress::ProgressOptions;
    use crate::way::way;

    const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690.0 };

    fn at(bearing_deg: f64, away_m: f64) -> GeoPoint {
        direct(HOME.point().unwrap(), bearing_deg, away_m)
    }

    fn waypoint(point: GeoPoint, height_m: f64) -> MissionItem {
        MissionItem::waypoint(point.lat_deg(), point.lon_deg(), height_m)
    }

    /// Take-off and three waypoints, and what ends them.
    fn circuit(end: &[MissionItem]) -> Mission {
        let from = at(270.0, 250.0);
        let mut items = vec![MissionItem::takeoff(from.lat_deg(), from.lon_deg(), 80.0, 15.0)];
        items.extend([300.0, 0.0, 60.0].map(|bearing_deg| waypoint(at(bearing_deg, 600.0), 80.0)));
        items.extend_from_slice(end);
        Mission { home: Some(HOME), items }
    }

    fn designed(has_land_start: bool) -> Vec<MissionItem> {
        let options = LandingOptions { course_deg: Some(240.0), has_land_start, ..LandingOptions::default() };
        design_landing(HOME.point().unwrap(), &options).unwrap().items
    }

    fn check(end: &[MissionItem], expected: (usize, Option<usize>)) {
        let MissionEnd { item, designed_item } = mission_end(&circuit(end));
        assert_eq!((item, designed_item), expected, "{end:?}");
    }

    #[test]
    fn a_landing_ends_it_with_its_whole_approach() {
        check(&designed(false), (5, Some(5)));
        check(&designed(true), (5, Some(5)));
        let land = MissionItem::land(HOME.lat_deg, HOME.lon_deg, 0.0);
        check(std::slice::from_ref(&land), (4, None));
        // down in a line, as other stations lay it out; the level part before does not belong to it
        let line = [waypoint(at(60.0, 900.0), 40.0), waypoint(at(60.0, 400.0), 20.0), land];
        let entry = waypoint(at(150.0, 900.0), 40.0);
        check(&[&[entry], line.as_slice()].concat(), (6, None));
    }

    #[test]
    fn a_return_ends_it_and_what_ends_with_neither_goes_on() {
        check(&[MissionItem::return_to_launch()], (5, None));
        check(&[], (5, None));
        assert_eq!(mission_end(&Mission::default()), MissionEnd { item: 1, designed_item: None });
    }

    #[test]
    fn the_plane_comes_from_the_last_place_before_it() {
        let from = |mission: &Mission| comes_from(mission, &way(mission, 22.0, &ProgressOptions::default()));
        for end in [designed(true), Vec::new(), vec![MissionItem::return_to_launch()]] {
            let point = from(&circuit(&end)).unwrap();
            assert!(distance_m(point, at(60.0, 600.0)) < 0.02, "{end:?}");
        }
        assert_eq!(from(&Mission { home: Some(HOME), ..Mission::default() }), HOME.point().ok());
        assert_eq!(from(&Mission::default()), None);
    }

    #[test]
    fn it_is_landed_on_against_more_than_a_breeze() {
        let mission = circuit(&[]);
        let way = way(&mission, 22.0, &ProgressOptions::default());
        for (speed_m_s, is_from_there) in [(None, true), (Some(1.9), true), (Some(2.0), false)] {
            let wind = speed_m_s.map(|speed_m_s| Wind { from_deg: 90.0, speed_m_s });
            let options = towards_end(&mission, &way, LandingOptions { wind, ..LandingOptions::default() });
            assert_eq!(options.coming_from.is_some(), is_from_there, "{speed_m_s:?}");
        }
    }
}
