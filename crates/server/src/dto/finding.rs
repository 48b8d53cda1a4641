//! What a check of a plan found: a stable code with its figures, so that it can be said in any language and unit.

use serde::Serialize;
use utoipa::ToSchema;
use vencejo_flight::checks::{self, FindingKind as Core, Severity};
use vencejo_flight::plan::Wanted;

use super::cause::finite;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum FindingSeverity {
    /// Not to be sent.
    Error,
    /// For the pilot to judge.
    Warning,
}

/// Something wrong or doubtful in a plan. `message` and `remedy` say it in English; `code` and `figures` say the same to programs.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Finding {
    /// How bad it is.
    pub severity: FindingSeverity,
    /// The item, counted from 1; null when it is about the whole plan, home, the fence or rally points.
    #[schema(required = true)]
    pub item: Option<usize>,
    /// What is wrong.
    pub message: String,
    /// How to mend it.
    pub remedy: String,
    /// What it is.
    #[serde(flatten)]
    pub kind: FindingKind,
}

/// What a height counts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HeightDatum {
    /// Mean sea level.
    Amsl,
    /// Home.
    Home,
    /// The ground below.
    Terrain,
}

/// What a place lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MissingPart {
    /// Latitude or longitude.
    Place,
    /// The height.
    Height,
}

/// What a value must be to be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WantedValue {
    /// A number that fits the wire.
    Finite,
    /// −90 to 90 degrees.
    Latitude,
    /// −180 to 180 degrees.
    Longitude,
    /// Within 83,000 m.
    Height,
    /// A whole number of 32 bits.
    WholeNumber,
    /// A frame that has a meaning for a place.
    Frame,
}

/// What is wrong with a fence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FenceFault {
    /// A polygon with too few corners.
    TooFewCorners,
    /// A polygon with too many corners.
    TooManyCorners,
    /// A circle without a radius.
    Radius,
    /// A return point at a height that cannot be sent.
    ReturnHeight,
}

/// What is wrong with a rally point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RallyFault {
    /// A height that cannot be sent or stored.
    Height,
    /// Not above home.
    NotAboveHome,
    /// A frame that has no meaning for a place.
    Frame,
}

/// What was found. `code` is stable; a figure's name ends in its unit.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(tag = "code", content = "figures", rename_all = "kebab-case", rename_all_fields = "snake_case")]
pub enum FindingKind {
    /// There is nothing to fly.
    EmptyMission {
        /// Whether the plan has a fence or rally points.
        has_areas: bool,
    },
    /// More items than the vehicle holds.
    TooManyItems {
        /// Items, home not counted.
        count: usize,
        /// How many it holds.
        max: usize,
    },
    /// A value that is not finite, off the globe, or in a frame without meaning.
    BadValue {
        /// Which: `param1` … `param4`, `x`, `y`, `z`, `frame`.
        field: String,
        /// The value; null when it is no number.
        #[schema(required = true)]
        value: Option<f64>,
        /// What it must be.
        wanted: WantedValue,
    },
    /// A command that ArduPlane refuses.
    UnsupportedCommand {},
    /// A command that the vehicle stores and skips.
    IgnoredCommand {
        /// Whether a plane that can hover would do it.
        needs_hover: bool,
    },
    /// A parameter outside its range.
    ParamOutOfRange {
        /// Which, 1 to 7.
        param: usize,
        /// What the parameter is called, in English.
        label: String,
        /// Its value.
        value: f64,
        /// Symbol of the unit; empty when there is none.
        unit: String,
        /// Least; null without one.
        #[schema(required = true)]
        min: Option<f64>,
        /// Most; null without one.
        #[schema(required = true)]
        max: Option<f64>,
    },
    /// A parameter that ArduPlane keeps as another value.
    ParamChanged {
        /// Which, 1 to 7.
        param: usize,
        /// What the parameter is called, in English.
        label: String,
        /// Its value.
        value: f64,
        /// What the vehicle keeps.
        kept: f64,
        /// Symbol of the unit; empty when there is none.
        unit: String,
        /// Whether the vehicle does not use the parameter at all.
        is_unused: bool,
    },
    /// A place without latitude, longitude or height.
    MissingPosition {
        /// What it lacks.
        missing: MissingPart,
    },
    /// Latitude and longitude both 0.
    ZeroCoordinates {
        /// Whether the vehicle does it where it is then.
        is_here: bool,
    },
    /// On the ground, and the mission does not begin with a take-off.
    NoTakeoff {},
    /// A take-off to a height that is not above home.
    TakeoffTooLow {
        /// Height that it climbs to.
        alt_m: f64,
        /// What that counts from.
        #[schema(required = true)]
        datum: Option<HeightDatum>,
    },
    /// Neither landing nor return at the end.
    NoLanding {},
    /// Items after a landing.
    ItemsAfterLanding {
        /// The first that is not flown, counted from 1.
        next_item: usize,
    },
    /// A start of a landing sequence without landing.
    LandStartWithoutLanding {
        /// Whether there is a landing, and it lacks its approach.
        has_landing: bool,
    },
    /// A jump to nowhere.
    JumpTarget {
        /// The item or tag that it names.
        target: f64,
        /// The last item there is.
        last: usize,
    },
    /// A jump that repeats for ever.
    EndlessJump {},
    /// A jump that runs in a circle without flying.
    IdleJump {},
    /// More jumps than the vehicle tracks.
    TooManyJumps {
        /// Jumps.
        count: usize,
        /// How many small boards track.
        max: usize,
    },
    /// Far from home.
    FarFromHome {
        /// How far.
        distance_m: f64,
        /// What is far.
        far_m: f64,
    },
    /// The first destination is far from the plane.
    FarFirst {
        /// How far.
        distance_m: f64,
    },
    /// At or below the height of home, or of the ground.
    BelowHome {
        /// Its height.
        alt_m: f64,
        /// What that counts from.
        #[schema(required = true)]
        datum: Option<HeightDatum>,
    },
    /// A leg shorter than the plane can turn.
    ShortLeg {
        /// Length of the leg.
        length_m: f64,
        /// Radius of a turn.
        turn_radius_m: f64,
    },
    /// A final approach that is steep.
    SteepApproach {
        /// Height lost.
        drop_m: f64,
        /// Length of the approach.
        length_m: f64,
        /// Length from which it would not be steep.
        wanted_length_m: f64,
    },
    /// A final approach that does not descend.
    FlatApproach {},
    /// Outside the fence.
    OutsideFence {
        /// The rally point, counted from 1; null when it is an item, or home.
        #[schema(required = true)]
        rally_point: Option<usize>,
        /// The zone that forbids it, counted from 1.
        zone: usize,
        /// Whether that is a zone to stay in.
        is_inclusion: bool,
    },
    /// A leg that crosses the fence.
    LegCrossesFence {
        /// The zone, counted from 1.
        zone: usize,
    },
    /// A fence that no vehicle takes.
    BadFence {
        /// What is wrong.
        fault: FenceFault,
        /// The zone, counted from 1; null for the return point.
        #[schema(required = true)]
        zone: Option<usize>,
        /// Corners of the polygon.
        #[schema(required = true)]
        corners: Option<usize>,
        /// Radius of the circle, or null.
        #[schema(required = true)]
        radius_m: Option<f64>,
        /// Height of the return point, above home.
        #[schema(required = true)]
        alt_rel_home_m: Option<f64>,
    },
    /// A rally point that no vehicle takes or that lies badly.
    BadRally {
        /// The rally point, counted from 1.
        rally_point: usize,
        /// What is wrong.
        fault: RallyFault,
        /// Its height in its frame; null when it is no number.
        #[schema(required = true)]
        alt_m: Option<f64>,
    },
}

impl From<checks::Finding> for Finding {
    fn from(finding: checks::Finding) -> Self {
        Self {
            severity: match finding.severity {
                Severity::Error => FindingSeverity::Error,
                Severity::Warning => FindingSeverity::Warning,
            },
            item: finding.item.map(|index| index + 1),
            message: finding.message,
            remedy: finding.remedy,
            kind: FindingKind::of(&finding.kind),
        }
    }
}

impl FindingKind {
    fn of(kind: &Core) -> Self {
        match *kind {
            Core::EmptyMission { has_areas } => Self::EmptyMission { has_areas },
            Core::TooManyItems { count, max } => Self::TooManyItems { count, max },
            Core::BadValue { field, value, wanted } => {
                Self::BadValue { field: field.to_owned(), value: finite(value), wanted: wanted.into() }
            }
            Core::UnsupportedCommand {} => Self::UnsupportedCommand {},
            Core::IgnoredCommand { needs_hover } => Self::IgnoredCommand { needs_hover },
            Core::ParamOutOfRange { param, label, value, unit, min, max } => Self::ParamOutOfRange {
                param,
                label: label.to_owned(),
                value,
                unit: unit.to_owned(),
                min: min.and_then(finite),
                max: max.and_then(finite),
            },
            Core::ParamChanged { param, label, value, kept, unit, is_unused } => {
                Self::ParamChanged { param, label: label.to_owned(), value, kept, unit: unit.to_owned(), is_unused }
            }
            Core::MissingPosition { missing } => Self::MissingPosition { missing: missing.into() },
            Core::ZeroCoordinates { is_here } => Self::ZeroCoordinates { is_here },
            Core::NoTakeoff {} => Self::NoTakeoff {},
            Core::TakeoffTooLow { alt_m, datum } => Self::TakeoffTooLow { alt_m, datum: datum.map(Into::into) },
            Core::NoLanding {} => Self::NoLanding {},
            Core::ItemsAfterLanding { next_item } => Self::ItemsAfterLanding { next_item },
            Core::LandStartWithoutLanding { has_landing } => Self::LandStartWithoutLanding { has_landing },
            Core::JumpTarget { target, last } => Self::JumpTarget { target, last },
            Core::EndlessJump {} => Self::EndlessJump {},
            Core::IdleJump {} => Self::IdleJump {},
            Core::TooManyJumps { count, max } => Self::TooManyJumps { count, max },
            Core::FarFromHome { distance_m, far_m } => Self::FarFromHome { distance_m, far_m },
            Core::FarFirst { distance_m } => Self::FarFirst { distance_m },
            Core::BelowHome { alt_m, datum } => Self::BelowHome { alt_m, datum: datum.map(Into::into) },
            Core::ShortLeg { length_m, turn_radius_m } => Self::ShortLeg { length_m, turn_radius_m },
            Core::SteepApproach { drop_m, length_m, wanted_length_m } => {
                Self::SteepApproach { drop_m, length_m, wanted_length_m }
            }
            Core::FlatApproach {} => Self::FlatApproach {},
            Core::OutsideFence { rally_point, zone, is_inclusion } => {
                Self::OutsideFence { rally_point, zone, is_inclusion }
            }
            Core::LegCrossesFence { zone } => Self::LegCrossesFence { zone },
            Core::BadFence { fault, zone, corners, radius_m, alt_rel_home_m } => Self::BadFence {
                fault: fault.into(),
                zone,
                corners,
                radius_m: radius_m.and_then(finite),
                alt_rel_home_m: alt_rel_home_m.and_then(finite),
            },
            Core::BadRally { rally_point, fault, alt_m } => {
                Self::BadRally { rally_point, fault: fault.into(), alt_m: finite(alt_m) }
            }
        }
    }
}

impl From<checks::Datum> for HeightDatum {
    fn from(word: checks::Datum) -> Self {
        match word {
            checks::Datum::Amsl => Self::Amsl,
            checks::Datum::Home => Self::Home,
            checks::Datum::Terrain => Self::Terrain,
        }
    }
}

impl From<checks::Missing> for MissingPart {
    fn from(word: checks::Missing) -> Self {
        match word {
            checks::Missing::Place => Self::Place,
            checks::Missing::Height => Self::Height,
        }
    }
}

impl From<Wanted> for WantedValue {
    fn from(word: Wanted) -> Self {
        match word {
            Wanted::Finite => Self::Finite,
            Wanted::Latitude => Self::Latitude,
            Wanted::Longitude => Self::Longitude,
            Wanted::Height => Self::Height,
            Wanted::WholeNumber => Self::WholeNumber,
            Wanted::Frame => Self::Frame,
        }
    }
}

impl From<checks::FenceFault> for FenceFault {
    fn from(word: checks::FenceFault) -> Self {
        match word {
            checks::FenceFault::TooFewCorners => Self::TooFewCorners,
            checks::FenceFault::TooManyCorners => Self::TooManyCorners,
            checks::FenceFault::Radius => Self::Radius,
            checks::FenceFault::ReturnHeight => Self::ReturnHeight,
        }
    }
}

impl From<checks::RallyFault> for RallyFault {
    fn from(word: checks::RallyFault) -> Self {
        match word {
            checks::RallyFault::Height => Self::Height,
            checks::RallyFault::NotAboveHome => Self::NotAboveHome,
            checks::RallyFault::Frame => Self::Frame,
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};
    use vencejo_flight::checks::{CheckContext, Figure, check_plan};
    use vencejo_flight::geodesy::GeoPoint;
    use vencejo_flight::plan::{Command, Home, MissionItem, Plan, RallyPoint};
    use vencejo_proto::MissionSeq;

    use super::*;

    /// A plan with many faults of many kinds.
    fn bad_plan() -> Plan {
        let mut plan = Plan::default();
        plan.mission.home = Some(Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 });
        let far = MissionItem::waypoint(41.0, -3.0, 100.0);
        plan.mission.items = vec![
            far.clone(),
            MissionItem::waypoint(41.000_01, -3.0, -5.0),
            MissionItem {
                params: {
                    let mut all = far.params;
                    all[0] = Some(f64::NAN);
                    all
                },
                ..far.clone()
            },
            MissionItem {
                params: {
                    let mut all = far.params;
                    all[1] = Some(300.0);
                    all
                },
                ..far.clone()
            },
            MissionItem {
                params: {
                    let mut all = far.params;
                    all[6] = None;
                    all
                },
                ..far.clone()
            },
            MissionItem { command: Command::NAV_ARC_WAYPOINT, ..far.clone() },
            MissionItem::action(Command(9_999), [0.0; 4]),
            MissionItem::jump(MissionSeq(99), 1),
            MissionItem::jump(MissionSeq(1), -1),
            MissionItem::land(41.0, -3.0, 0.0),
            far,
        ];
        let point = GeoPoint::new(40.0, -3.0).expect("on Earth");
        plan.rally.points = vec![RallyPoint { point, alt_m: 0.0, frame: 3.into() }];
        plan.fence.return_point = Some((point, f64::INFINITY));
        plan
    }

    #[test]
    fn a_finding_is_its_code_and_figures_under_the_names_of_the_core() {
        let found = check_plan(&bad_plan(), &CheckContext::default());
        let mut codes: Vec<&str> = found.iter().map(|one| one.code.as_str()).collect();
        codes.sort_unstable();
        codes.dedup();
        assert!(codes.len() >= 12, "{codes:?}");
        for core in found {
            let (code, figures) = (core.code, core.kind.figures());
            let told = serde_json::to_value(Finding::from(core)).expect("JSON");
            assert_eq!(told["code"], code.as_str());
            let told = told["figures"].as_object().expect("an object");
            assert_eq!(told.len(), figures.len(), "{code}");
            for (name, figure) in figures {
                let wanted = match figure {
                    Figure::Absent => Value::Null,
                    Figure::Flag(flag) => json!(flag),
                    Figure::Count(count) => json!(count),
                    Figure::Number(number) => json!(number),
                    Figure::Word(word) => json!(word),
                };
                assert_eq!(told[name], wanted, "{code}: {name}");
            }
        }
    }
}
