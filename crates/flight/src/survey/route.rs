//! The way from line to line: the order of the passes, the turns between them, and their mission items.

use super::layout::{Leg, Pass, SurveyLine};
use super::options::SurveyOptions;
use super::order::race_track;
use super::region::Region;
use super::turn::{Pose, corners};
use crate::geodesy::GeoPoint;
use crate::guidance::NorthEast;
use crate::landing::{CALM_M_S, Wind};
use crate::plan::{Command, MavFrame, MissionItem};

/// Radius within which a waypoint counts that an item can say at most, m (ArduPilot keeps 8 bits).
const MOST_ACCEPTED_M: f64 = 255.0;

/// Passes in the order and the direction in which they are flown: every other one backwards, and from the end that lies
/// best.
pub(super) fn in_order(
    passes: Vec<Pass>,
    apart: usize,
    region: &Region,
    coming_from: Option<GeoPoint>,
    wind: Wind,
) -> Vec<Pass> {
    let order = race_track(passes.len(), apart);
    let flown = |is_from_right: bool, is_backwards: bool| {
        let last = passes.len().saturating_sub(1);
        let number = |index: &usize| if is_from_right { last - *index } else { *index };
        let turned = order.iter().map(number).enumerate().map(|(flown, index)| {
            let pass = passes[index].clone();
            if (flown % 2 == 1) == is_backwards { pass } else { pass.into_iter().rev().map(Leg::reversed).collect() }
        });
        turned.collect::<Vec<Pass>>()
    };
    let ways = [(false, true), (false, false), (true, true), (true, false)].map(|(right, back)| flown(right, back));
    let upwind = NorthEast::from_bearing(wind.from_deg.to_radians());
    let begins = |way: &Vec<Pass>| way.first().and_then(|pass| pass.first()).map(Leg::start).unwrap_or_default();
    let cost = |way: &Vec<Pass>| match coming_from {
        Some(from) => (region.plane.at(from) - begins(way)).length(),
        None if wind.speed_m_s >= CALM_M_S => begins(way).dot(upwind),
        None => 0.0,
    };
    let best = ways.iter().enumerate().min_by(|(_, one), (_, other)| cost(one).total_cmp(&cost(other)));
    best.map(|(index, _)| ways[index].clone()).unwrap_or_default()
}

/// A step of the mission.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step {
    /// Flies to a place; how far before it the turn begins, m, where there is one.
    To(NorthEast, Option<f64>),
    /// Switches the camera on or off.
    Camera(bool),
}

pub(super) struct Route {
    steps: Vec<Step>,
}

impl Route {
    pub(super) fn along(passes: &[Pass], radius_m: f64, lead_in_m: f64, lead_out_m: f64) -> Self {
        let mut steps = Vec::new();
        let mut left: Option<Pose> = None;
        for leg in passes.iter().flatten() {
            let (course, last_course) = (leg.course_rad(), leg.last_course_rad());
            let ahead = NorthEast::from_bearing(course);
            let begins = Pose { at: leg.start() - ahead * lead_in_m, course_rad: course };
            match left {
                // From wherever it comes, it turns onto the line there.
                None => steps.push(Step::To(begins.at - ahead * radius_m, None)),
                Some(left) => {
                    steps.extend(
                        corners(left, begins, radius_m)
                            .iter()
                            .map(|corner| Step::To(corner.at, Some(corner.tangent_m))),
                    );
                }
            }
            let mut events: Vec<(f64, Option<bool>)> =
                leg.shots.iter().flat_map(|(from, to)| [(*from, Some(true)), (*to, Some(false))]).collect();
            let mut along_m = 0.0;
            for pair in leg.points.windows(2).take(leg.points.len() - 2) {
                along_m += (pair[1] - pair[0]).length();
                events.push((along_m, None));
            }
            events.sort_by(|one, other| one.0.total_cmp(&other.0));
            for (along_m, camera) in events {
                steps.push(Step::To(leg.at(along_m), None));
                steps.extend(camera.map(Step::Camera));
            }
            let onward = NorthEast::from_bearing(last_course);
            left = Some(Pose { at: leg.end() + onward * lead_out_m, course_rad: last_course });
        }
        if let Some(left) = left {
            // Straight ahead, so that the last waypoint with pictures counts abeam.
            steps.push(Step::To(left.at + NorthEast::from_bearing(left.course_rad) * radius_m, None));
        }
        Self { steps }
    }

    pub(super) fn places(&self) -> impl Iterator<Item = NorthEast> + '_ {
        self.steps.iter().filter_map(|step| match step {
            Step::To(at, _) => Some(*at),
            Step::Camera(_) => None,
        })
    }

    /// The mission items, and what is photographed.
    pub(super) fn items(
        &self,
        region: &Region,
        options: &SurveyOptions,
        above_home_m: f64,
        height_m: f64,
        trigger_m: Option<f64>,
        rolls_in_m: f64,
    ) -> (Vec<MissionItem>, Vec<SurveyLine>) {
        let mut items = Vec::with_capacity(self.steps.len() + 2);
        let mut lines: Vec<SurveyLine> = Vec::new();
        let mut is_on = false;
        if let Some(airspeed_m_s) = options.airspeed_m_s {
            items.push(MissionItem::change_airspeed(airspeed_m_s));
        }
        let (frame, alt_m) = if options.is_above_terrain {
            (MavFrame::GlobalTerrainAlt, height_m)
        } else {
            (MavFrame::GlobalRelativeAlt, above_home_m)
        };
        for step in &self.steps {
            match step {
                Step::To(at, tangent_m) => {
                    let point = region.plane.point(*at);
                    let mut item =
                        MissionItem { frame, ..MissionItem::waypoint(point.lat_deg(), point.lon_deg(), alt_m) };
                    // The bank takes its time to come; ArduPilot keeps whole metres.
                    let accepts_m =
                        tangent_m.map_or(0.0, |tangent_m| (tangent_m + rolls_in_m).round().clamp(1.0, MOST_ACCEPTED_M));
                    item.params[1] = Some(accepts_m);
                    if let Some(line) = lines.last_mut().filter(|_| is_on) {
                        line.points.push(point);
                        line.exit = items.len();
                    }
                    items.push(item);
                }
                Step::Camera(on) => {
                    is_on = *on;
                    if *on && let Some(entry) = items.len().checked_sub(1) {
                        lines.push(SurveyLine {
                            points: items[entry].point().into_iter().collect(),
                            entry,
                            exit: entry,
                        });
                    }
                    if let Some(trigger_m) = trigger_m {
                        let (distance_m, at_once) = if *on { (trigger_m, 1.0) } else { (0.0, 0.0) };
                        items
                            .push(MissionItem::action(Command::DO_SET_CAM_TRIGG_DIST, [distance_m, 0.0, at_once, 0.0]));
                    }
                }
            }
        }
        if options.airspeed_m_s.is_some() {
            // Back to the plane's own (ArduPlane's `do_change_speed`).
            items.push(MissionItem::action(Command::DO_CHANGE_SPEED, [0.0, -2.0, -1.0, 0.0]));
        }
        (items, lines)
    }
}
