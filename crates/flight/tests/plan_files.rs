//! Plan files as other programs write them: read as they are meant, and the same again after writing.
//!
//! The samples are short and our own, one for each dialect that files of QGroundControl, Mission Planner, APM Planner,
//! MAVProxy and of companions' scripts were found to have. `VENCEJO_TEST_PLANS` names a folder of real files, each of
//! which must keep its meaning too.

use std::fmt::Write as _;
use std::path::Path;

use vencejo_flight::formats::{PlanSettings, read_plan, write_plan_json, write_waypoints};
use vencejo_flight::plan::{FenceShape, MavFrame, Plan};

/// What a plan says, in one line: home | items | fence | rally.
fn told(plan: &Plan) -> String {
    let mut text = String::new();
    if let Some(home) = plan.mission.home {
        let _ = write!(text, "home {} {} {}", home.lat_deg, home.lon_deg, home.alt_amsl_m);
    }
    text.push_str(" |");
    for item in &plan.mission.items {
        let _ = write!(text, " {}/{}", item.command.0, item.frame.number());
        for param in item.params {
            text.push(',');
            match param {
                Some(value) => _ = write!(text, "{value}"),
                None => text.push('-'),
            }
        }
        if !item.autocontinue {
            text.push_str(",stop");
        }
    }
    text.push_str(" |");
    // what order zones stand in does not matter, and `.plan` has one for each shape
    let mut zones: Vec<String> = Vec::new();
    for zone in &plan.fence.zones {
        let side = if zone.inclusion { "in" } else { "out of" };
        zones.push(match &zone.shape {
            FenceShape::Polygon { vertices } => {
                let corners = vertices.iter().map(|at| format!("{} {}", at.lat_deg(), at.lon_deg()));
                format!(" {side} [{}]", corners.collect::<Vec<_>>().join(", "))
            }
            FenceShape::Circle { center, radius_m } => {
                format!(" {side} {radius_m} m of {} {}", center.lat_deg(), center.lon_deg())
            }
        });
    }
    zones.sort();
    text.push_str(&zones.concat());
    if let Some((at, alt_m)) = plan.fence.return_point {
        let _ = write!(text, " return {} {} {alt_m}", at.lat_deg(), at.lon_deg());
    }
    text.push_str(" |");
    for rally in &plan.rally.points {
        let at = rally.point;
        let _ = write!(text, " {} {} {}/{}", at.lat_deg(), at.lon_deg(), rally.alt_m, rally.frame.number());
    }
    text
}

/// The same with unset parameters as they are sent, where no heading can be unset: as 0.
fn sent(plan: &Plan) -> String {
    let mut plan = plan.clone();
    for item in &mut plan.mission.items {
        for (place, param) in item.params.iter_mut().enumerate() {
            if param.is_none() && !item.command.param_may_be_unset(place) {
                *param = Some(0.0);
            }
        }
    }
    told(&plan)
}

/// Writes a plan in each format that can hold it, and reads it again. How many could.
fn keeps_its_meaning(name: &str, plan: &Plan, settings: &PlanSettings) -> usize {
    let mut formats = 0;
    if plan.rally.points.iter().all(|rally| rally.frame == MavFrame::GlobalRelativeAlt) {
        let text = write_plan_json(plan, settings).unwrap_or_else(|error| panic!("{name} as .plan: {error}"));
        let again = read_plan(text.as_bytes(), None).unwrap_or_else(|error| panic!("{name} as .plan: {error}"));
        assert_eq!(told(&again.plan), told(plan), "{name} as .plan");
        let (now, before) = (again.settings.planned_for, settings.planned_for);
        for (now, before) in [
            (now.cruise_speed_m_s, before.cruise_speed_m_s),
            (now.hover_speed_m_s, before.hover_speed_m_s),
            (now.vehicle_type.map(f64::from), before.vehicle_type.map(f64::from)),
            (now.firmware_type.map(f64::from), before.firmware_type.map(f64::from)),
        ] {
            assert!(before.is_none() || now == before, "{name} as .plan: {now:?}, {before:?}");
        }
        formats += 1;
    }
    // a .waypoints file holds one list: what it holds of this plan is what must be the same
    let Plan { mission, fence, rally } = plan.clone();
    let home =
        Plan { mission: vencejo_flight::plan::Mission { home: mission.home, items: Vec::new() }, ..Plan::default() };
    for part in [Plan::from_mission(mission), Plan { fence, ..home.clone() }, Plan { rally, ..home.clone() }] {
        if part == home && *plan != home {
            continue;
        }
        let text = write_waypoints(&part).unwrap_or_else(|error| panic!("{name} as .waypoints: {error}"));
        let again = read_plan(text.as_bytes(), None).unwrap_or_else(|error| panic!("{name} as .waypoints: {error}"));
        assert_eq!(sent(&again.plan), sent(&part), "{name} as .waypoints");
        formats += 1;
    }
    formats
}

const MISSION_OF_2016: &str = r#"{"MAV_AUTOPILOT":3,"complexItems":[],"groundStation":"QGroundControl","version":"1.0","items":[
    {"autoContinue":true,"command":22,"coordinate":[0,0,30],"frame":3,"id":1,"param1":20,"param2":0,"param3":0,"param4":0,"type":"missionItem"},
    {"autoContinue":true,"command":16,"coordinate":[40.1,-3.1,90],"frame":3,"id":2,"param1":0,"param2":5,"param3":0,"param4":0,"type":"missionItem"},
    {"autoContinue":false,"command":177,"coordinate":[0,0,0],"frame":2,"id":3,"param1":2,"param2":-1,"param3":0,"param4":0,"type":"missionItem"}],
    "plannedHomePosition":{"autoContinue":true,"command":16,"coordinate":[40,-3,600],"frame":0,"id":0,"param1":0,"param2":0,"param3":0,"param4":0,
    "type":"missionItem"}}"#;

const MISSION_OF_2017: &str = r#"{"firmwareType":3,"groundStation":"QGroundControl","version":2,"plannedHomePosition":[40,-3,600],"items":[
    {"autoContinue":true,"command":18,"coordinate":[40.1,-3.1,20],"doJumpId":1,"frame":0,"params":[3,0,-80,null],"type":"SimpleItem"}]}"#;

const PLAN_OF_2017: &str = r#"{"fileType":"Plan","version":1,"groundStation":"QGroundControl",
    "geoFence":{"polygon":[[40,-3],[40.1,-3],[40.1,-3.1]],"version":1},"rallyPoints":{"points":[[40.2,-3.2,60]],"version":1},
    "mission":{"version":2,"cruiseSpeed":15,"hoverSpeed":5,"firmwareType":12,"plannedHomePosition":[40,-3,600],"items":[
    {"autoContinue":true,"command":16,"coordinate":[40.1,-3.1,20],"doJumpId":1,"frame":3,"params":[0,0,0,null],"type":"SimpleItem"},
    {"autoContinue":true,"command":205,"coordinate":[0,0,2],"doJumpId":2,"frame":2,"params":[-45,0,90,0],"type":"SimpleItem"}]}}"#;

const WITHOUT_VERSIONS: &str = r#"{"fileType":"Plan","version":1,"groundStation":"a script","geoFence":{},"rallyPoints":{"points":[]},
    "mission":{"version":2,"plannedHomePosition":[null,null,null],"items":[
    {"command":16,"coordinate":[0,0,0],"frame":3,"params":[0,0,0,null,40.1,-3.1,20],"type":"SimpleItem"}]}}"#;

const CORRIDOR_AND_VTOL: &str = r#"{"fileType":"Plan","version":1,"groundStation":"QGroundControl",
    "geoFence":{"circles":[],"polygons":[],"version":2},"rallyPoints":{"points":[],"version":2},
    "mission":{"version":2,"cruiseSpeed":15,"hoverSpeed":5,"firmwareType":12,"vehicleType":20,"globalPlanAltitudeMode":0,
    "plannedHomePosition":[40,-3,null],"items":[
    {"type":"ComplexItem","complexItemType":"CorridorScan","version":2,"CorridorWidth":50,"EntryPoint":0,"polyline":[[40,-3],[40.1,-3]],
     "TransectStyleComplexItem":{"version":2,"Items":[
     {"AltitudeMode":3,"Altitude":50,"AMSLAltAboveTerrain":650,"autoContinue":true,"command":16,"doJumpId":1,"frame":0,
      "params":[0,0,0,null,40,-3,650],"type":"SimpleItem"},
     {"autoContinue":true,"command":206,"doJumpId":2,"frame":2,"params":[25,0,1,0,0,0,0],"type":"SimpleItem"}]}},
    {"type":"ComplexItem","complexItemType":"vtolLandingPattern","version":1,"altitudesAreRelative":true,"landCoordinate":[40.1,-3.1,0],
     "landingApproachCoordinate":[40.2,-3.2,60],"loiterClockwise":true,"loiterRadius":75,"useLoiterToAlt":true,"stopTakingPhotos":false,
     "stopVideoPhotos":false}]}}"#;

const FENCE_ROWS: &str = "5001 3 0 0 0 40 -3 0 1\n2 0 3 5001 3 0 0 0 40.1 -3 1 1\n3 0 3 5001 3 0 0 0 40.1 -3.1 2 1\n";

/// Who writes it so, the file, and what it says.
fn samples() -> Vec<(&'static str, String, &'static str)> {
    let triangle = " | | in [40 -3, 40.1 -3, 40.1 -3.1] |";
    let with_home = "home 40 -3 600 | | in [40 -3, 40.1 -3, 40.1 -3.1] |";
    let sample = |who, text: &str, said| (who, text.to_owned(), said);
    vec![
        sample(
            "Mission Planner",
            "\u{feff}QGC WPL 110\r\n0\t1\t0\t16\t0\t0\t0\t0\t40.0000000\t-3.0000000\t600.000000\t1\r\n\
             1\t0\t10\t22\t15.00000000\t0.00000000\t0.00000000\t0.00000000\t40.10000000\t-3.10000000\t50.000000\t1\r\n\
             2\t0\t3\t177\t1.00000000\t-1.00000000\t0.00000000\t0.00000000\t0.00000000\t0.00000000\t0.000000\t1\r\n",
            "home 40 -3 600 | 22/10,15,0,0,0,40.1,-3.1,50 177/3,1,-1,0,0,0,0,0 | |",
        ),
        sample(
            "Mission Planner, home never set",
            "QGC WPL 110\n0\t1\t0\t0\t0\t0\t0\t0\t0\t0\t0\t1\n1\t0\t3\t16\t0\t0\t0\t0\t40.1\t-3.1\t50\t1\n",
            " | 16/3,0,0,0,0,40.1,-3.1,50 | |",
        ),
        ("Mission Planner, fence", format!("QGC WPL 110\n0 1 0 16 0 0 0 0 40 -3 600 1\n1 0 3 {FENCE_ROWS}"), with_home),
        (
            "Mission Planner, fence with home twice",
            format!("QGC WPL 110\n0 1 0 16 0 0 0 0 40 -3 600 1\n1 0 0 16 0 0 0 0 40 -3 602.5 1\n1 0 3 {FENCE_ROWS}"),
            with_home,
        ),
        sample(
            "Mission Planner, rally",
            "QGC WPL 110\n0 1 0 16 0 0 0 0 40 -3 600 1\n1 0 3 5100 0 0 0 0 40.2 -3.2 100 1\n",
            "home 40 -3 600 | | | 40.2 -3.2 100/3",
        ),
        ("MAVProxy, fence", format!("QGC WPL 110\n0 0 0 {FENCE_ROWS}"), triangle),
        sample(
            "MAVProxy, fence with a point to return to, and circles",
            "QGC WPL 110\n0 0 3 5000 0 0 0 0 40 -3 80 0\n1 0 0 5003 500.5 0 0 0 40 -3 0 0\n2 0 0 5004 20 0 0 0 40.01 -3.01 0 0\n",
            " | | in 500.5 m of 40 -3 out of 20 m of 40.01 -3.01 return 40 -3 80 |",
        ),
        sample(
            "MAVProxy, rally above the sea",
            "QGC WPL 110\n0 0 0 5100 8 0 0 0 40.2 -3.2 700 0\n",
            " | | | 40.2 -3.2 700/0",
        ),
        sample(
            "MAVProxy, a heading that is unset",
            "QGC WPL 110\n0 0 0 16 0.0 0.0 0.0 0.0 40 -3 600.0 1\n1 0 3 16 0.0 0.0 0.0 nan 40.1 -3.1 50.0 1\n",
            "home 40 -3 600 | 16/3,0,0,0,-,40.1,-3.1,50 | |",
        ),
        sample(
            "a companion's script for PX4: item 0 is the take-off, and jumps count from it",
            "QGC WPL 110\n0\t1\t5\t22\t0\t0\t0\t0\t40\t-3\t15\t1\n1\t0\t6\t16\t0\t0\t0\t0\t40.1\t-3.1\t15\t1\n2\t0\t2\t177\t1\t2\t0\t0\t0\t0\t0\t1\n",
            " | 22/0,0,0,0,0,40,-3,15 16/3,0,0,0,0,40.1,-3.1,15 177/2,2,2,0,0,0,0,0 | |",
        ),
        sample(
            "a companion's script that saved without item 0",
            "QGC WPL 110\n1\t0\t3\t22\t0\t0\t0\t0\t0\t0\t10\t1\n2\t0\t3\t16\t0\t0\t0\t0\t40.1\t-3.1\t15\t1\n3\t0\t2\t177\t2\t2\t0\t0\t0\t0\t0\t1\n",
            " | 22/3,0,0,0,0,0,0,10 16/3,0,0,0,0,40.1,-3.1,15 177/2,2,2,0,0,0,0,0 | |",
        ),
        sample(
            "QGroundControl before 2016: never home",
            "QGC WPL 120\r\n0\t1\t3\t16\t0\t0\t0\t0\t40.1\t-3.1\t15\t1\r\n1\t0\t2\t177\t0\t2\t0\t0\t0\t0\t0\t1\r\n",
            " | 16/3,0,0,0,0,40.1,-3.1,15 177/2,1,2,0,0,0,0,0 | |",
        ),
        sample(
            "lines that somebody inserted and deleted",
            "QGC WPL 110\n0 0 0 16 0 0 0 0 40 -3 600 1\n1 0 3 16 0 0 0 0 40.1 -3 50 1\n1 0 3 16 0 0 0 0 40.2 -3 50 1\n7 0 3 20 0 0 0 0 0 0 0 1\n",
            "home 40 -3 600 | 16/3,0,0,0,0,40.1,-3,50 16/3,0,0,0,0,40.2,-3,50 20/3,0,0,0,0,0,0,0 | |",
        ),
        sample(
            "lines that somebody deleted: a jump goes to the item that it went to before",
            "QGC WPL 110\n0 0 0 16 0 0 0 0 40 -3 600 1\n2 0 3 16 0 0 0 0 40.1 -3 50 1\n5 0 3 16 0 0 0 0 40.2 -3 50 1\n6 0 3 177 5 2 0 0 0 0 0 1\n9 0 3 177 2 -1 0 0 0 0 0 1\n",
            "home 40 -3 600 | 16/3,0,0,0,0,40.1,-3,50 16/3,0,0,0,0,40.2,-3,50 177/3,2,2,0,0,0,0,0 177/3,1,-1,0,0,0,0,0 | |",
        ),
        (
            "a script, all three lists in one file; a jump counts the items of its list",
            format!(
                "QGC WPL 110\n0 1 0 16 0 0 0 0 40 -3 600 1\n1 0 3 {FENCE_ROWS}4 0 3 16 0 0 0 0 40.1 -3 50 1 # north\n\
                 5 0 3 5100 0 0 0 0 40.2 -3.2 100 1\n6 0 2 177 4 2 0 0 0 0 0 1\n"
            ),
            "home 40 -3 600 | 16/3,0,0,0,0,40.1,-3,50 177/2,1,2,0,0,0,0,0 | in [40 -3, 40.1 -3, 40.1 -3.1] | 40.2 -3.2 100/3",
        ),
        sample(
            "APM Planner, fence",
            "#saved by APM Planner 1.3\n40.05 -3.05\n40 -3\n40.1 -3\n40.1 -3.1\n40 -3\n",
            " | | in [40 -3, 40.1 -3, 40.1 -3.1] return 40.05 -3.05 0 |",
        ),
        sample(
            "MAVProxy, rally of 2013",
            "#saved\nRALLY 40.2\t-3.2\t60.000000\t40.000000\t0.000000\t0\nRALLY\t40.3\t-3.3\t700\t40\t0\t4\n",
            " | | | 40.2 -3.2 60/3 40.3 -3.3 700/0",
        ),
        sample(
            "QGroundControl, .mission of 2016",
            MISSION_OF_2016,
            "home 40 -3 600 | 22/3,20,0,0,0,0,0,30 16/3,0,5,0,0,40.1,-3.1,90 177/2,2,-1,0,0,0,0,0,stop | |",
        ),
        sample("QGroundControl, .mission of 2017", MISSION_OF_2017, "home 40 -3 600 | 18/0,3,0,-80,-,40.1,-3.1,20 | |"),
        sample(
            "QGroundControl, .plan of 2017",
            PLAN_OF_2017,
            "home 40 -3 600 | 16/3,0,0,0,-,40.1,-3.1,20 205/2,-45,0,90,0,0,0,2 | in [40 -3, 40.1 -3, 40.1 -3.1] | 40.2 -3.2 60/3",
        ),
        sample("a script, .plan without versions and home", WITHOUT_VERSIONS, " | 16/3,0,0,0,-,40.1,-3.1,20 | |"),
        sample(
            "QGroundControl, corridor over terrain and landing of a VTOL",
            CORRIDOR_AND_VTOL,
            " | 16/0,0,0,0,-,40,-3,650 206/2,25,0,1,0,0,0,0 189/2,0,0,0,0,0,0,0 31/3,1,75,0,1,40.2,-3.2,60 85/3,0,0,0,-,40.1,-3.1,0 | |",
        ),
    ]
}

// fault 50 (22 dialects): short files as QGroundControl (2016 to now), Mission Planner, APM Planner, MAVProxy and
// scripts write them: as meant, and the same after writing
#[test]
fn each_dialect_is_read_as_it_is_meant_and_keeps_its_meaning() {
    let mut formats = 0;
    for (who, text, said) in samples() {
        let file = read_plan(text.as_bytes(), None).unwrap_or_else(|error| panic!("{who}: {error}"));
        assert_eq!(told(&file.plan), said, "{who}");
        formats += keeps_its_meaning(who, &file.plan, &file.settings);
    }
    // two for each but rally points above the sea, which .plan cannot say; those with three parts are four files
    assert_eq!(formats, 2 * 22 - 2 + 2 * 2);
}

#[test]
fn what_cannot_be_meant_is_refused_with_its_place() {
    let wpl = |rows: &str| format!("QGC WPL 110\n0 1 0 16 0 0 0 0 40 -3 600 1\n{rows}");
    let complex = |item: &str| {
        format!(
            r#"{{"fileType":"Plan","version":1,"mission":{{"version":2,"plannedHomePosition":[40,-3,0],"items":[{item}]}}}}"#
        )
    };
    for (text, expected) in [
        (
            wpl("2 0 3 16 0 0 0 0 40 -3 50 1\n1 0 3 177 2 2 0 0 0 0 0 1\n"),
            "line 4: (DO_JUMP) jumps to 2, but which item",
        ),
        (
            wpl("1 0 3 16 0 0 0 0 40 -3 50 1\n3 0 3 177 2 2 0 0 0 0 0 1\n"),
            "line 4: (DO_JUMP) jumps to 2, but no item of the mission has that index",
        ),
        (
            wpl("1 0 3 5100 0 0 0 0 40 -3 50 1\n2 0 3 177 1 2 0 0 0 0 0 1\n"),
            "line 4: (DO_JUMP) jumps to 1, but no item of the mission",
        ),
        (
            wpl("1 0 3 5001 4 0 0 0 40 -3 0 1\n2 0 3 5001 4 0 0 0 40 -3 0 1\n"),
            "line 3: starts a polygon of 4 corners but",
        ),
        (wpl("1 0 1 5100 0 0 0 0 40 -3 50 1\n"), "line 3: (NAV_RALLY_POINT) has 1 as its frame"),
        ("40 -3\n40.1 -3\n40.1 -3.1\n40 -3\n".into(), "line 4: is the first point again: that is the outline"),
        ("40 -3\n40.1 -3\n40.1 -3.1\n40.2 -3\n".into(), "line 4: ends the fence, but it is not the first corner"),
        ("40 -3\n40.1 -3\n40.1 -3\n".into(), "line 3: a polygon needs at least 3 corners, this has 1"),
        ("40,5 -3,2\n40,6 -3,2\n".into(), "line 1: has \"40,5\" as its latitude; write decimals with a point"),
        ("40 -3\n95 -3\n".into(), "line 2: latitude 95, longitude -3 is not a position"),
        ("40 -3\nhome\n".into(), "line 2: is \"home\" where latitude and longitude"),
        ("RALLY 40 -3 60 40 0 2\n".into(), "line 1: asks to land at the rally point"),
        ("RALLY 40 -3 60 40 0 20\n".into(), "line 1: counts its height from the origin"),
        ("RALLY 40 -3 60\n".into(), "line 1: is \"RALLY 40 -3 60\"; a rally point is RALLY"),
        (
            MISSION_OF_2016.replace("\"complexItems\":[]", "\"complexItems\":[{}]"),
            "complexItems: holds surveys; its items are not",
        ),
        (
            complex(r#"{"type":"SimpleItem","command":16,"frame":3,"params":[0,0,0,0],"coordinate":[40,-3]}"#),
            "mission.items[0].params: has 6 values",
        ),
        (
            PLAN_OF_2017.replace("-3.1]],\"version\":1", "-3.1]],\"version\":3"),
            "geoFence.version: is 3; versions 1 and 2",
        ),
    ] {
        let error = read_plan(text.as_bytes(), None).expect_err(expected).to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    let file = read_plan(PLAN_OF_2017.as_bytes(), None).unwrap();
    let plan = Plan { fence: file.plan.fence, rally: file.plan.rally, ..Plan::default() };
    assert!(write_waypoints(&plan).unwrap_err().to_string().contains("save it as .plan"));
}

/// A folder of files that other programs wrote: each that is read keeps its meaning. Those that are refused are told,
/// with why.
#[test]
fn real_files_keep_their_meaning() {
    let Ok(folder) = std::env::var("VENCEJO_TEST_PLANS") else { return };
    let mut paths: Vec<_> = std::fs::read_dir(Path::new(&folder))
        .unwrap_or_else(|error| panic!("VENCEJO_TEST_PLANS is {folder}: {error}; name a folder of plan files"))
        .map(|entry| entry.expect("listed").path())
        .filter(|path| path.is_file())
        .collect();
    paths.sort();
    let (mut read, mut formats) = (0, 0);
    for path in &paths {
        let name = path.display().to_string();
        match read_plan(&std::fs::read(path).unwrap_or_else(|error| panic!("{name}: {error}")), Some(&name)) {
            Ok(file) => {
                read += 1;
                formats += keeps_its_meaning(&name, &file.plan, &file.settings);
            }
            Err(error) => println!("refused {name}: {error}"),
        }
    }
    println!("{read} of {} files keep their meaning, written {formats} times", paths.len());
    assert!(read > 0, "{folder} holds no plan that can be read");
}
