//! Tests of the `.plan` format.

use proptest::prelude::*;

use super::*;
use crate::checks::{CheckContext, Finding, FindingKind, check_plan};
use crate::formats::waypoints::tests::missions;
use crate::formats::{Note, NoteCode, write_plan};

fn read(text: &str) -> Result<PlanFile> {
    read_plan_json(text.as_bytes())
}

fn plan_with(items: &str) -> String {
    format!(
        r#"{{"fileType":"Plan","version":1,"groundStation":"QGroundControl",
        "geoFence":{{"circles":[{{"circle":{{"center":[40.33,-3.79],"radius":500.5}},"inclusion":true,"version":1}}],
          "polygons":[{{"inclusion":false,"polygon":[[40,-3],[40.1,-3],[40.1,-3.1]],"version":1}}],
          "breachReturn":[40.3,-3.7,80],"version":2}},
        "mission":{{"cruiseSpeed":14,"hoverSpeed":5,"firmwareType":3,"vehicleType":1,"version":2,
          "globalPlanAltitudeMode":1,"plannedHomePosition":[40.3332,-3.7978,600],"items":[{items}]}},
        "rallyPoints":{{"points":[[40.31,-3.71,60]],"version":2}}}}"#
    )
}

fn simple(command: u16, id: u32, params: &str) -> String {
    format!(
        r#"{{"AMSLAltAboveTerrain":null,"Altitude":50,"AltitudeMode":1,"autoContinue":true,"command":{command},
        "doJumpId":{id},"frame":3,"params":[{params}],"type":"SimpleItem"}}"#
    )
}

const WAYPOINT: &str = "0,0,0,null,40.3332,-3.80,50";
const LANDING: &str = r#"{"altitudesAreRelative":true,"complexItemType":"fwLandingPattern",
    "landCoordinate":[40.3332,-3.7978,0],"landingApproachCoordinate":[40.34,-3.79,40],"loiterClockwise":false,
    "loiterRadius":75,"stopTakingPhotos":true,"stopVideoPhotos":true,"type":"ComplexItem","useLoiterToAlt":true,
    "valueSetIsDistance":false,"version":2}"#;

#[test]
fn everything_in_a_plan_is_read() {
    let file =
        read(&plan_with(&[simple(22, 1, "12,0,0,null,40.3332,-3.80,50"), simple(16, 2, WAYPOINT)].join(","))).unwrap();
    assert_eq!(
        file.settings,
        PlanSettings {
            planned_for: PlannedFor {
                cruise_speed_m_s: Some(14.0),
                hover_speed_m_s: Some(5.0),
                vehicle_type: Some(1),
                firmware_type: Some(3),
            },
            complex_items: Vec::new(),
        }
    );
    let Plan { mission, fence, rally } = file.plan;
    assert_eq!(mission.home, Some(Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 }));
    assert_eq!(mission.items.len(), 2);
    assert_eq!(mission.items[0].command, Command::NAV_TAKEOFF);
    assert_eq!(mission.items[1].params, [Some(0.0), Some(0.0), Some(0.0), None, Some(40.3332), Some(-3.8), Some(50.0)]);
    assert_eq!(fence.zones.len(), 2);
    assert!(!fence.zones[0].inclusion && fence.zones[1].inclusion);
    assert_eq!(fence.return_point.map(|(_, alt_m)| alt_m), Some(80.0));
    assert_eq!(rally.points[0].alt_m, 60.0);
}

#[test]
fn a_landing_pattern_becomes_its_items() {
    let items = read(&plan_with(LANDING)).unwrap().plan.mission.items;
    let commands: Vec<_> = items.iter().map(|item| item.command).collect();
    assert_eq!(
        commands,
        [
            Command::DO_LAND_START,
            Command::DO_SET_CAM_TRIGG_DIST,
            Command::IMAGE_STOP_CAPTURE,
            Command::VIDEO_STOP_CAPTURE,
            Command::NAV_LOITER_TO_ALT,
            Command::NAV_LAND,
        ]
    );
    assert_eq!(items[4].params, [1.0, -75.0, 0.0, 1.0, 40.34, -3.79, 40.0].map(Some));
    assert_eq!(items[4].frame, MavFrame::GlobalRelativeAlt);
    assert_eq!(items[5], MissionItem::land(40.3332, -3.7978, 0.0));

    let straight = LANDING
        .replace(
            r#""useLoiterToAlt":true"#,
            r#""useLoiterToAlt":false,"useDoChangeSpeed":true,"finalApproachSpeed":12"#,
        )
        .replace(r#""altitudesAreRelative":true"#, r#""altitudesAreRelative":false"#);
    let items = read(&plan_with(&straight)).unwrap().plan.mission.items;
    assert_eq!(items[1].params[..3], [Some(0.0), Some(12.0), Some(-1.0)]);
    assert_eq!((items[5].command, items[5].frame, items[5].params[3]), (Command::NAV_WAYPOINT, MavFrame::Global, None));

    let old = LANDING
        .replace(r#""version":2"#, r#""version":1"#)
        .replace(r#""altitudesAreRelative":true"#, r#""loiterAltitudeRelative":true,"landAltitudeRelative":true"#)
        .replace("landingApproachCoordinate", "loiterCoordinate");
    assert_eq!(read(&plan_with(&old)).unwrap().plan.mission.items.len(), 6);
}

#[test]
fn a_survey_brings_its_items() {
    let survey = format!(
        r#"{{"type":"ComplexItem","complexItemType":"survey","version":5,"TransectStyleComplexItem":{{"Items":[{},{}]}}}}"#,
        simple(16, 2, WAYPOINT),
        simple(206, 3, "25,0,1,0,0,0,0"),
    );
    let items = [simple(22, 1, "12,0,0,0,40.3,-3.8,50"), survey, simple(177, 9, "2,3,0,0,0,0,0")].join(",");
    let items = read(&plan_with(&items)).unwrap().plan.mission.items;
    assert_eq!(items.len(), 4);
    assert_eq!(items[3].params[0], Some(2.0));
}

const STRUCTURE: &str = r#"{"type":"ComplexItem","complexItemType":"StructureScan","version":3,"Layers":4,"EntranceAltitude":60,
    "polygon":[[40.1,-3.1],[40.1,-3.2],[40.2,-3.2]]}"#;

#[test]
fn complex_items_are_written_as_they_were_read() {
    let survey = format!(
        r#"{{"type":"ComplexItem","complexItemType":"survey","version":5,"angle":33.5,"later":{{"keys":[1,null]}},
        "TransectStyleComplexItem":{{"Items":[{},{}],"VisualTransectPoints":[[40.1,-3.1]]}}}}"#,
        simple(16, 2, WAYPOINT),
        simple(206, 3, "25,0,1,0,0,0,0"),
    );
    let items = [
        simple(22, 1, "12,0,0,0,40.3,-3.8,50"),
        survey,
        STRUCTURE.to_owned(),
        simple(16, 9, WAYPOINT),
        LANDING.to_owned(),
    ];
    let file = read(&plan_with(&items.join(","))).unwrap();
    let kinds: Vec<_> = file.settings.complex_items.iter().map(|complex| complex.kind.as_str()).collect();
    assert_eq!(kinds, ["survey", "StructureScan", "fwLandingPattern"]);
    let text = write_plan_json(&file.plan, &file.settings).unwrap();
    let written: Value = serde_json::from_str(&text).unwrap();
    let list = written["mission"]["items"].as_array().unwrap();
    assert_eq!(list.len(), 5);
    let before: Value = serde_json::from_str(&plan_with(&items.join(","))).unwrap();
    for index in [1, 2, 4] {
        assert_eq!(list[index], before["mission"]["items"][index], "whole, whatever it holds");
    }
    assert_eq!(read(&text).unwrap(), file);
    // An item before it: its own items are renumbered.
    let mut moved = file.clone();
    moved.plan.mission.items.insert(0, MissionItem::change_airspeed(20.0));
    let text = write_plan_json(&moved.plan, &moved.settings).unwrap();
    let written: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(written["mission"]["items"][2].pointer("/TransectStyleComplexItem/Items/1/doJumpId"), Some(&json!(4)));
    assert_eq!(read(&text).unwrap().plan, moved.plan);
    // One of its items changed, or a jump that leads into a landing pattern, which has no numbers: written one by one,
    // with a note.
    let mut edited = file.clone();
    edited.plan.mission.items[1].params[6] = Some(61.0);
    edited.plan.mission.items.insert(4, MissionItem::jump(MissionSeq(9), 1));
    let told = edited_complex_items(&edited.plan, &edited.settings).unwrap();
    assert_eq!(told.iter().map(|complex| complex.kind.as_str()).collect::<Vec<_>>(), ["survey", "fwLandingPattern"]);
    let notes = write_plan(&edited.plan, &edited.settings, PlanFormat::QgcPlan).unwrap().notes;
    assert_eq!(notes, [Note { code: NoteCode::ComplexItemsEdited, count: told.len() }]);
    let again = read(&write_plan_json(&edited.plan, &edited.settings).unwrap()).unwrap();
    assert_eq!((again.plan, again.settings.complex_items.len()), (edited.plan, 1));
}

#[test]
fn what_only_qgroundcontrol_can_work_out_is_kept_and_not_sent() {
    let old = r#"{"type":"ComplexItem","complexItemType":"survey","version":3,"grid":{"angle":20}}"#.to_owned();
    let empty =
        r#"{"type":"ComplexItem","complexItemType":"survey","version":5,"TransectStyleComplexItem":{"Items":[]}}"#
            .to_owned();
    let items =
        [simple(22, 1, "12,0,0,0,40.3,-3.8,50"), STRUCTURE.to_owned(), old, simple(20, 2, "0,0,0,0,0,0,0"), empty];
    let file = read(&plan_with(&items.join(","))).unwrap();
    assert_eq!(file.plan.mission.items.len(), 5);
    assert_eq!(file.notes, [Note { code: NoteCode::ItemsElsewhere, count: 3 }]);
    let findings = check_plan(&file.plan, &CheckContext::default());
    let is_told = |number| {
        findings
            .iter()
            .any(|found| found.item == Some(number) && matches!(found.kind, FindingKind::UnsupportedCommand {}))
    };
    assert!(is_told(2) && is_told(3) && is_told(5), "{findings:?}");
    // Swapped, each keeps its identity.
    let mut swapped = file.clone();
    swapped.plan.mission.items.swap(1, 2);
    let text = write_plan_json(&swapped.plan, &swapped.settings).unwrap();
    let written: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(written["mission"]["items"][2]["complexItemType"], "StructureScan");
    assert_eq!(written["mission"]["items"][1]["version"], 3);
    assert_eq!(read(&text).unwrap().plan, swapped.plan);
}

#[test]
fn complex_items_are_bounded() {
    let many = vec![STRUCTURE; MAX_COMPLEX_ITEMS + 1].join(",");
    assert!(read(&plan_with(&many)).unwrap_err().to_string().contains("more than 1000 complex items"));
    for (count, json, says) in
        [(MAX_COMPLEX_ITEMS + 1, STRUCTURE, "are 1001"), (1, "{", "is not JSON"), (1, "[]", "an object belongs")]
    {
        let complex = ComplexItem { kind: "survey".into(), json: json.into() };
        let settings = PlanSettings { complex_items: vec![complex; count], ..PlanSettings::default() };
        let error = write_plan_json(&Plan::default(), &settings).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn jumps_follow_their_item() {
    // the landing pattern has no ids of its own, so ids and seq part
    let items = [LANDING.to_owned(), simple(16, 7, WAYPOINT), simple(177, 8, "7,-1,0,0,0,0,0")].join(",");
    let items = read(&plan_with(&items)).unwrap().plan.mission.items;
    assert_eq!(items[7].params[0], Some(7.0));
    let gap = [simple(16, 40, WAYPOINT), simple(177, 41, "40,1,0,0,0,0,0")].join(",");
    assert_eq!(read(&plan_with(&gap)).unwrap().plan.mission.items[1].params[0], Some(1.0));
    for (items, expected) in [
        (
            [simple(16, 40, WAYPOINT), simple(177, 41, "2,1,0,0,0,0,0")],
            "mission.items[1].params: jumps to doJumpId 2, which no",
        ),
        (
            [simple(16, 2, WAYPOINT), simple(177, 2, "2,1,0,0,0,0,0")],
            "mission.items[1].params: jumps to doJumpId 2, which two",
        ),
    ] {
        let error = read(&plan_with(&items.join(","))).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn a_plan_whose_jump_leads_nowhere_is_saved_and_opened_and_the_check_tells_it() {
    for target in ["5", "0", "-5", "1.5", "1e9"] {
        let items = [simple(16, 1, WAYPOINT), simple(177, 2, &format!("{target},1,0,0,0,0,0"))];
        let plan = read(&plan_with(&items.join(","))).unwrap().plan;
        let again = read(&write_plan_json(&plan, &PlanSettings::default()).unwrap()).unwrap().plan;
        assert_eq!(plan, again, "{target}");
        assert_eq!(plan.mission.items[1].params[0], target.parse().ok());
        let findings = check_plan(&plan, &CheckContext::default());
        let is_told = |finding: &Finding| matches!(finding.kind, FindingKind::JumpTarget { .. });
        assert!(findings.iter().any(is_told), "{target}: {findings:?}");
    }
}

#[test]
fn each_fault_is_named_with_its_path() {
    let sound = plan_with(&[simple(16, 1, WAYPOINT), LANDING.to_owned()].join(","));
    assert!(read(&sound).is_ok());
    for (from, to, expected) in [
        (r#""Plan""#, r#""GeoFence""#, "fileType: is \"GeoFence\""),
        (r#""version":1,"groundStation""#, r#""version":3,"groundStation""#, "version: is 3; only version 1"),
        (r#""mission":"#, r#""mision":"#, "mission: is missing"),
        (r#""vehicleType":1"#, r#""vehicleType":1000"#, "mission.vehicleType: is 1000"),
        (r#""cruiseSpeed":14"#, r#""cruiseSpeed":-1"#, "mission.cruiseSpeed: is -1"),
        ("[40.3332,-3.7978,600]", "[940.3332,-3.7978,600]", "mission.plannedHomePosition: latitude 940.3332"),
        (WAYPOINT, "0,0,0,null,40.3332,-3.80", "mission.items[0].params: has 6 values"),
        (WAYPOINT, "0,0,0,null,\"40\",-3.80,50", "mission.items[0].params[4]: is \"40\" where a number belongs"),
        (WAYPOINT, "0,0,0,null,91,-3.80,50", "mission.items[0]: (NAV_WAYPOINT) has 91 as its x"),
        (WAYPOINT, "1e39,0,0,null,41,-3.80,50", "mission.items[0]: (NAV_WAYPOINT) has"),
        (r#""frame":3"#, r#""frame":8"#, "mission.items[0]: (NAV_WAYPOINT) has 8 as its frame"),
        (r#""command":16"#, r#""command":70000"#, "mission.items[0].command: is 70000"),
        (r#""SimpleItem""#, r#""Item""#, "mission.items[0].type: is \"Item\""),
        ("[40.3332,-3.7978,0]", "[40.3332,-3.7978]", "mission.items[1].landCoordinate: is a list where"),
        (r#""radius":500.5"#, r#""radius":-3"#, "geoFence.circles[0]: a radius of -3 m"),
        ("[[40,-3],[40.1,-3],[40.1,-3.1]]", "[[40,-3]]", "geoFence.polygons[0]: a polygon needs at least 3"),
        ("[[40.31,-3.71,60]]", "[[40.31,-3.71,null]]", "rallyPoints.points[0]: is a list where"),
    ] {
        assert!(sound.contains(from), "{from}");
        let error = read(&sound.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn hostile_files_end_in_errors() {
    let deep = format!("{{\"a\":{}", "[".repeat(1_000_000));
    let huge = plan_with(&simple(16, 1, "1e999,0,0,0,40,-3,50"));
    let nan = plan_with(&simple(16, 1, "NaN,0,0,0,40,-3,50"));
    let cut = plan_with("").split_at(200).0.to_owned();
    for (text, expected) in
        [(deep, "64 lists and objects deep"), (huge, "is not JSON"), (nan, "is not JSON"), (cut, "is not JSON")]
    {
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let many = vec![simple(16, 1, WAYPOINT); crate::plan::MAX_ITEMS + 1].join(",");
    assert!(read(&plan_with(&many)).unwrap_err().to_string().contains("at most 10000"));
}

#[test]
fn a_speed_that_would_not_be_read_is_not_written() {
    for speed_m_s in [-1.0, f64::NAN, 1000.0] {
        let planned_for = PlannedFor { hover_speed_m_s: Some(speed_m_s), ..PlannedFor::default() };
        let settings = PlanSettings { planned_for, ..PlanSettings::default() };
        let error = write_plan_json(&Plan::default(), &settings).unwrap_err().to_string();
        assert_eq!(error, format!("mission.hoverSpeed: is {speed_m_s} m/s; give a speed from 0 to 1000 m/s"));
    }
}

#[test]
fn a_height_that_the_format_cannot_say_is_refused() {
    let point = GeoPoint::new(40.0, -3.0).unwrap();
    let rally = Rally { points: vec![RallyPoint { point, alt_m: 700.0, frame: MavFrame::Global }] };
    let plan = Plan { rally, ..Plan::default() };
    let error = write_plan_json(&plan, &PlanSettings::default()).unwrap_err().to_string();
    assert!(error.starts_with("rally item 0: has a height"), "{error}");
}

#[test]
fn what_is_written_has_the_keys_that_qgroundcontrol_asks_for() {
    let mission = Mission { home: None, items: vec![MissionItem::waypoint(40.0, -3.5, 50.0)] };
    let text = write_plan_json(&Plan::from_mission(mission), &PlanSettings::default()).unwrap();
    let value: Value = serde_json::from_str(&text).unwrap();
    let item = &value["mission"]["items"][0];
    assert_eq!(item["params"], json!([0, 0, 0, 0, 40, -3.5, 50]));
    assert_eq!((&item["AltitudeMode"], &item["doJumpId"], &item["Altitude"]), (&json!(1), &json!(1), &json!(50)));
    for key in ["cruiseSpeed", "hoverSpeed", "firmwareType", "vehicleType", "plannedHomePosition", "items", "version"] {
        assert!(value["mission"].get(key).is_some(), "{key}");
    }
}

fn points() -> impl Strategy<Value = GeoPoint> {
    (-90.0..=90.0_f64, -180.0..=180.0_f64).prop_map(|(lat, lon)| GeoPoint::new(lat, lon).unwrap())
}

fn fences() -> impl Strategy<Value = Fence> {
    let polygon = (any::<bool>(), prop::collection::vec(points(), 3..9))
        .prop_map(|(inclusion, vertices)| FenceZone { inclusion, shape: FenceShape::Polygon { vertices } });
    let circle = (any::<bool>(), points(), 0.1..1e5_f64).prop_map(|(inclusion, center, radius_m)| FenceZone {
        inclusion,
        shape: FenceShape::Circle { center, radius_m },
    });
    (
        prop::collection::vec(polygon, 0..3),
        prop::collection::vec(circle, 0..3),
        prop::option::of((points(), -100.0..500.0_f64)),
    )
        .prop_map(|(polygons, circles, return_point)| Fence {
            zones: polygons.into_iter().chain(circles).collect(),
            return_point,
        })
}

proptest! {
    // fault 50 (256 cases): random plans written and read as .plan: equal
    #[test]
    fn a_plan_survives_the_file(
        mission in missions(),
        fence in fences(),
        rally in prop::collection::vec((points(), -100.0..3_000.0_f64), 0..5),
        speeds in (prop::option::of(1.0..100.0_f64), 1_u8..30),
    ) {
        let points = rally.into_iter()
            .map(|(point, alt_m)| RallyPoint { point, alt_m, frame: MavFrame::GlobalRelativeAlt })
            .collect();
        let plan = Plan { mission, fence, rally: Rally { points } };
        let planned_for = PlannedFor {
            cruise_speed_m_s: Some(speeds.0.unwrap_or(DEFAULT_CRUISE_M_S)),
            hover_speed_m_s: Some(DEFAULT_HOVER_M_S),
            vehicle_type: Some(speeds.1),
            firmware_type: Some(DEFAULT_FIRMWARE),
        };
        let settings = PlanSettings { planned_for, complex_items: Vec::new() };
        let text = write_plan_json(&plan, &settings).unwrap();
        let file = read(&text).unwrap();
        prop_assert_eq!(file.settings, settings);
        prop_assert_eq!(file.plan, plan);
    }

    #[test]
    fn any_change_of_one_character_is_read_or_refused(place in 0..2_000_usize, with in "[\\[\\]{}0-9,\"e.-]") {
        let mut text = plan_with(&[simple(16, 1, WAYPOINT), LANDING.to_owned()].join(","));
        let place = place % text.len();
        text.replace_range(place..=place, &with);
        let _ = read(&text);
    }
}
