//! The English messages and remedies of the findings.

use vencejo_proto::Counted;

use super::finding::{Datum, FenceFault, Finding, FindingKind, Missing, RallyFault, Severity};
use crate::plan::{MAX_VERTICES, MissionItem, SHAPE_MIN_CORNERS};

impl Finding {
    /// Makes a finding with its English texts; `item` is the one that it is about, with its index.
    pub(super) fn new(severity: Severity, kind: FindingKind, item: Option<(usize, &MissionItem)>) -> Self {
        let name =
            item.map_or_else(|| "home".to_owned(), |(index, item)| format!("item {} ({})", index + 1, item.command));
        let (message, remedy) = sentences(&kind, &name, item.is_none());
        Self { severity, item: item.map(|(index, _)| index + 1), message, remedy, kind }
    }
}

/// A height with what it counts from.
fn height(alt_m: f64, datum: Option<Datum>) -> String {
    datum.map_or_else(|| format!("{alt_m} m"), |datum| format!("{alt_m} m {}", datum.words()))
}

/// Of a place out of reach.
fn far_off(name: &str, distance_m: f64, reach_m: f64, is_swapped: bool) -> (String, String) {
    let remedy = if is_swapped {
        "latitude and longitude are swapped?".to_owned()
    } else {
        format!("check its position; in reach is {:.0} km", reach_m / 1_000.0)
    };
    (format!("{name} lies {:.0} km from home and from the plane: out of reach", distance_m / 1_000.0), remedy)
}

/// English message and remedy.
fn sentences(kind: &FindingKind, name: &str, is_whole: bool) -> (String, String) {
    use FindingKind::*;
    let (message, remedy): (String, &str) = match kind {
        EmptyMission { has_areas } => (
            "the mission is empty".to_owned(),
            if *has_areas {
                "send the fence and the rally points alone"
            } else {
                "add items; to empty the vehicle, clear its mission"
            },
        ),
        TooManyItems { count, max } => (
            format!("the mission has {count} items, the vehicle holds {max} beside home"),
            "split it, or widen the distance between survey lines",
        ),
        BadValue { field, value, wanted } => (format!("{name}: {field} is {value}"), wanted.problem()),
        UnsupportedCommand {} => (
            format!("{name} is not a mission command of ArduPlane, which refuses the whole mission"),
            "delete it or choose another command",
        ),
        IgnoredCommand { needs_hover: true } => {
            (format!("{name} needs a plane that can hover"), "delete it, or say that the plane is a quadplane")
        }
        IgnoredCommand { needs_hover: false } => {
            (format!("{name} is for other vehicles; ArduPlane skips it"), "delete it")
        }
        ParamOutOfRange { label, value, unit, min, max, .. } => {
            let bound = |value: &Option<f64>| value.map_or("…".to_owned(), |value| value.to_string());
            let remedy = format!("choose from {} to {}", bound(min), bound(max));
            return (format!("{name}: {label} is {value} {unit}").trim_end().to_owned(), remedy);
        }
        ParamChanged { label, value, unit, kept, is_unused, .. } => {
            let value = format!("{value} {unit}");
            (
                format!("{name}: {label} of {} is kept as {kept}", value.trim_end()),
                if *is_unused { "set it to 0: ArduPlane does not use it" } else { "choose a value that is kept" },
            )
        }
        SpeedNotTaken { speed_m_s, min_m_s, max_m_s } => {
            let bound = |value: &Option<f64>| value.map_or("…".to_owned(), |value| value.to_string());
            let remedy = format!("choose from {} to {} m/s", bound(min_m_s), bound(max_m_s));
            return (format!("{name}: an airspeed of {speed_m_s} m/s is not taken, the plane keeps its own"), remedy);
        }
        MissingPosition { missing: Missing::Place } => {
            (format!("{name} has no latitude or longitude"), "place it on the map")
        }
        MissingPosition { missing: Missing::Height } => (format!("{name} has no height"), "set one"),
        ZeroCoordinates { is_here: false } => (format!("{name} lies at 0/0, in the Atlantic"), "place it on the map"),
        ZeroCoordinates { is_here: true } => (
            format!("{name} lies at 0/0, so it is done where the plane is then"),
            "place it on the map, unless you mean that",
        ),
        NoTakeoff {} => (
            format!("the mission begins with {name}, not with a take-off"),
            "put a take-off first, or start it in the air",
        ),
        TakeoffTooLow { alt_m, datum } => (
            format!("{name} climbs to {}, which is not above home", height(*alt_m, *datum)),
            "give it a height to climb to, 30 m or more",
        ),
        NoLanding {} => (
            format!("the mission ends with {name}, neither landing nor return"),
            "end it with a landing or a return to launch",
        ),
        ItemsAfterLanding { next_item } => (
            format!("{name} lands before the mission ends; item {next_item} is not flown"),
            "move the landing to the end",
        ),
        EndlessLoiter { next_item } => (
            format!("{name} circles until it is told otherwise; item {next_item} is not flown by itself"),
            "move it to the end, or give a circle turns or a time",
        ),
        LandStartWithoutLanding { has_landing: false } => {
            (format!("{name} starts a landing sequence, but no landing follows"), "add a landing after it or delete it")
        }
        LandStartWithoutLanding { has_landing: true } => (
            format!("{name} is followed by the landing at once, without an approach"),
            "put a waypoint before the landing, in line with the runway",
        ),
        LandStartDisabled {} => (
            format!("{name}: with RTL_AUTOLAND 0 this vehicle refuses to arm with a landing sequence"),
            "set RTL_AUTOLAND to 2, so that a return flies it, or delete it",
        ),
        JumpTarget { target, last } => {
            return (
                format!("{name} jumps to {target}, which does not exist"),
                format!("choose an item from 1 to {last}"),
            );
        }
        EndlessJump {} => (
            format!("{name} repeats for ever; what follows it is never flown"),
            "give it a number of repeats, unless you mean it",
        ),
        IdleJump {} => {
            (format!("{name} jumps in a circle in which nothing is flown"), "choose an item before the last waypoint")
        }
        TooManyJumps { count, max } => {
            (format!("the mission has {count} jumps; small boards track {max}"), "repeat items instead of jumping")
        }
        FarFromHome { distance_m, far_m } => {
            return (
                format!("{name} lies {:.1} km from home", distance_m / 1_000.0),
                format!("check it; far is {:.0} km", far_m / 1_000.0),
            );
        }
        OutOfReach { distance_m, reach_m, is_swapped } => {
            return far_off(name, *distance_m, *reach_m, *is_swapped);
        }
        AreaOutOfReach { rally_point, fence_zone, distance_m, reach_m, is_swapped } => {
            let subject = match (rally_point, fence_zone) {
                (Some(number), _) => format!("rally point {number}"),
                (None, Some(number)) => format!("zone {number} of the fence"),
                (None, None) => "the fence's return point".to_owned(),
            };
            return far_off(&subject, *distance_m, *reach_m, *is_swapped);
        }
        FarFirst { distance_m } => (
            format!("{name}, the first destination, lies {:.1} km from the plane", distance_m / 1_000.0),
            "check that the mission is for this place",
        ),
        BelowHome { alt_m, datum } => {
            let level = if *datum == Some(Datum::Terrain) { "the ground" } else { "home" };
            (
                format!("{name} lies at {}, not above {level}", height(*alt_m, *datum)),
                "raise it, unless the terrain falls away there",
            )
        }
        LandingOffField { off_m, is_under } => (
            format!("{name} lies {off_m:.0} m {} the field that home is on", if *is_under { "under" } else { "above" }),
            "give it the height of the field, and look what its height counts from",
        ),
        ShortLeg { length_m, turn_radius_m } => (
            format!("the leg to {name} is {length_m:.0} m long, the plane turns within {turn_radius_m:.0} m"),
            "move the waypoints apart or fly slower",
        ),
        SteepApproach { drop_m, length_m, wanted_length_m } => {
            return (
                format!("the approach to {name} drops {drop_m:.0} m in {length_m:.0} m; the plane will land long"),
                format!("begin it {wanted_length_m:.0} m away or more, or lower"),
            );
        }
        FlatApproach {} => {
            (format!("the approach to {name} does not descend"), "raise the waypoint before the landing")
        }
        OutsideFence { rally_point, zone, is_inclusion } => {
            let (subject, remedy) = match rally_point {
                Some(number) => (format!("rally point {number}"), "move it or the fence"),
                None if is_whole => (name.to_owned(), "move the fence"),
                None => (name.to_owned(), "move it or the fence"),
            };
            let side = if *is_inclusion { "outside inclusion" } else { "inside exclusion" };
            (format!("{subject} lies {side} zone {zone} of the fence"), remedy)
        }
        ReturnPointOutsideFence { zone, is_inclusion } => {
            let side = if *is_inclusion { "outside inclusion" } else { "inside exclusion" };
            (format!("the fence's return point lies {side} zone {zone}"), "move it into the fence")
        }
        LegCrossesFence { zone } => {
            (format!("the leg to {name} crosses fence zone {zone}"), "lead it round, or change the fence")
        }
        NearGround { clearance_m, wanted_m, .. } => {
            return (
                format!("on the way to {name} the plane is {:.0} m above the ground", clearance_m.max(0.0)),
                format!("raise it by {:.0} m, or lead it round", (wanted_m - clearance_m).ceil()),
            );
        }
        GroundNotKnown { is_off: false, .. } => (
            format!(
                "the height of {name} counts from the ground, which is not known on the way: neither is the plane's height"
            ),
            "add elevation that covers it to the maps",
        ),
        GroundNotKnown { is_off: true, .. } => (
            format!(
                "the height of {name} counts from the ground, and with TERRAIN_ENABLE 0 the plane takes it from home"
            ),
            "set TERRAIN_ENABLE to 1, or count its height from home",
        ),
        HomeOffGround { difference_m, is_above } => {
            let side = if *is_above { "above" } else { "below" };
            (
                format!("home's height is {difference_m:.0} m {side} the ground that the maps have there"),
                "set home on the ground: heights above mean sea level are off by as much",
            )
        }
        FliesIntoGround { .. } => {
            (format!("on the way to {name} the plane flies into the ground"), "raise it and what lies around it")
        }
        HeldByWind { wind_m_s } => (
            format!("the plane comes no nearer to {name} in {wind_m_s:.0} m/s of wind"),
            "wait for less wind, or fly faster",
        ),
        WaypointMissed { distance_m } => (
            format!("the plane turns too wide for {name} and passes it {distance_m:.0} m away"),
            "move it away from the one before, fly slower, or widen WP_RADIUS",
        ),
        HeightNotReached { difference_m, is_low } => {
            let side = if *is_low { "too low" } else { "too high" };
            (
                format!("the plane is {difference_m:.0} m {side} at {name}"),
                "lengthen the leg, change the height, or climb and sink in a circle",
            )
        }
        LeavesFence { zone } => (
            format!("on the way to {name} the plane leaves the fence at zone {zone}"),
            "keep farther from it: turns are wider than the lines, and a return goes straight",
        ),
        ReturnHitsGround {} => (
            format!("a return that begins on the way to {name} flies into the ground"),
            "raise RTL_ALTITUDE, set RTL_CLIMB_MIN, or lead the way round the hill",
        ),
        ReturnHeldByWind { wind_m_s } => (
            format!("from the way to {name} the plane does not come back in {wind_m_s:.0} m/s of wind"),
            "wait for less wind, or fly faster",
        ),
        ReturnLeavesFence { zone } => (
            format!("a return that begins on the way to {name} leaves the fence at zone {zone}"),
            "set a rally point on this side of it, or fly round",
        ),
        GoAroundHitsGround {} => (
            format!("a go-around on the way to {name} flies into the ground"),
            "land the other way, or give the landing more room to climb out",
        ),
        LandsOff { distance_m, is_long: true } => (
            format!("the plane touches the ground {distance_m:.0} m beyond {name}"),
            "come in lower, slower or against the wind",
        ),
        LandsOff { distance_m, is_long: false } => (
            format!("the plane touches the ground {distance_m:.0} m before {name}"),
            "look at the approach: nothing may stand there",
        ),
        LandsDownwind { tailwind_m_s } => {
            (format!("at {name} {tailwind_m_s:.0} m/s of the wind come from behind"), "land the other way")
        }
        BatteryBelowReserve { left_pct, reserve_pct } => (
            format!("at the end of the flight {left_pct:.0} % of the battery is left, {reserve_pct:.0} % should be"),
            "shorten it, wait for less wind, or take a larger battery",
        ),
        BatteryEmpty { time_s, lacks_wh } => {
            let leg = if is_whole { String::new() } else { format!(", on the way to {name}") };
            (
                format!(
                    "the battery is empty {:.0} min after the start{leg}; the flight wants {lacks_wh:.0} Wh more",
                    time_s / 60.0
                ),
                "shorten it, wait for less wind, or take a larger battery",
            )
        }
        BadFence { fault, zone, corners, radius_m, alt_rel_home_m } => {
            let zone = zone.map_or_else(|| "the fence".to_owned(), |zone| format!("fence zone {zone}"));
            let corners = corners.unwrap_or(0);
            match fault {
                FenceFault::TooFewCorners => (
                    format!("{zone} has {}, a polygon needs {SHAPE_MIN_CORNERS}", Counted(corners, "corner")),
                    "add some or delete the zone",
                ),
                FenceFault::TooManyCorners => {
                    (format!("{zone} has {corners} corners, a vehicle takes {MAX_VERTICES}"), "simplify or split it")
                }
                FenceFault::Radius => {
                    let radius = radius_m.map_or_else(|| "no radius".to_owned(), |r| format!("a radius of {r} m"));
                    (format!("{zone} has {radius}, which makes no circle"), "give it one above 0 or delete the zone")
                }
                FenceFault::ReturnPlace => {
                    ("the fence's return point lies at 0/0, in the Atlantic".to_owned(), "place it on the map")
                }
                FenceFault::ReturnHeight => {
                    let height = alt_rel_home_m.map_or_else(|| "no number".to_owned(), |alt_m| format!("{alt_m} m"));
                    (
                        format!("the fence's return point has a height of {height}, which cannot be sent"),
                        "stay within 83,000 m",
                    )
                }
            }
        }
        BadRally { rally_point, fault, alt_m } => match fault {
            RallyFault::Height => {
                (format!("rally point {rally_point} lies at {alt_m} m"), "stay within 32,767 m, as ArduPilot stores it")
            }
            RallyFault::NotAboveHome => {
                (format!("rally point {rally_point} lies at {alt_m} m, not above home"), "raise it")
            }
            RallyFault::Frame => (
                format!("rally point {rally_point} has a frame without meaning for a place"),
                "count its height from sea level, home or the terrain",
            ),
        },
        SurveyLineMissed { line, distance_m } => (
            match distance_m {
                Some(off_m) => format!("at {name} the plane flies line {line} of the survey {off_m:.0} m aside"),
                None => format!("at {name} line {line} of the survey is not flown"),
            },
            "lengthen the lead-in, fly slower, or across the wind",
        ),
        SurveyHoles { holes, side_m } => (
            format!("{holes} places of the survey are on no picture, the largest some {side_m:.0} m across"),
            "overlap more, lengthen the lead-in, or wait for less wind",
        ),
    };
    (message, remedy.to_owned())
}
