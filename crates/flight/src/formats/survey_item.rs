//! A survey of ours as the complex item by which QGroundControl knows surveys and corridors: it opens, shows, flies and
//! edits it.
//!
//! `SurveyComplexItem` version 5 and `CorridorScanComplexItem` version 2, with `TransectStyleComplexItem` and
//! `CameraCalc` version 2. The items are exactly ours; when the survey is edited there, QGroundControl lays it out
//! again by its own rules, from the same area, camera, overlap, height, angle and turn-around.
//!
//! Options without a QGroundControl key are kept in a member `vencejo`, which QGroundControl ignores and drops when the
//! survey is edited there: [`survey_of`] then uses QGroundControl's keys.

use serde_json::{Value, json};

use super::json::plain;
use super::plan_file::ComplexItem;
use super::plan_json::write_item;
use crate::geodesy::GeoPoint;
use crate::landing::Wind;
use crate::survey::{CAMERAS, Camera, Survey, SurveyOptions, SurveyShape};

/// QGroundControl's "AltitudeMode".
const ABOVE_HOME: u8 = 1;
const ABOVE_SEA: u8 = 2;
/// Above the ground, by heights that it worked out itself.
const ABOVE_TERRAIN_BY_HOME: u8 = 3;
const ABOVE_TERRAIN: u8 = 4;

/// A survey as a complex item of QGroundControl, for [`super::PlanSettings::complex_items`] of a plan that holds its
/// items.
pub fn survey_item(survey: &Survey) -> ComplexItem {
    let places = |points: &[GeoPoint]| -> Vec<Value> {
        points.iter().map(|point| json!([plain(point.lat_deg()), plain(point.lon_deg())])).collect()
    };
    let way: Vec<GeoPoint> = survey.items.iter().filter_map(crate::plan::MissionItem::point).collect();
    let items: Vec<Value> = survey.items.iter().enumerate().map(|(index, item)| write_item(index + 1, item)).collect();
    let transects = json!({
        "version": 2,
        "TurnAroundDistance": plain(survey.lead_in_m.round()),
        "CameraTriggerInTurnAround": false,
        "HoverAndCapture": false,
        "Refly90Degrees": false,
        "CameraShots": survey.photos,
        "CameraCalc": camera_calc(survey),
        "VisualTransectPoints": places(&way),
        "Items": items,
    });
    let (kind, value) = match &survey.shape {
        SurveyShape::Area(corners) => (
            "survey",
            json!({
                "type": "ComplexItem",
                "complexItemType": "survey",
                "version": 5,
                // North to south is 0, as the course of a line, but without its direction.
                "angle": plain(survey.course_deg.rem_euclid(180.0)),
                "entryLocation": 0,
                "flyAlternateTransects": 2.0 * survey.turn_radius_m > survey.spacing_m,
                "splitConcavePolygons": false,
                "polygon": places(corners),
                "TransectStyleComplexItem": transects,
                "vencejo": asked(&survey.options),
            }),
        ),
        SurveyShape::Corridor { line, width_m } => (
            "CorridorScan",
            json!({
                "type": "ComplexItem",
                "complexItemType": "CorridorScan",
                "version": 2,
                "CorridorWidth": plain(*width_m),
                "EntryPoint": 0,
                "polyline": places(line),
                "TransectStyleComplexItem": transects,
                "vencejo": asked(&survey.options),
            }),
        ),
    };
    ComplexItem { kind: kind.to_owned(), json: value.to_string() }
}

/// Options of a survey, without those of home and the vehicle.
fn asked(options: &SurveyOptions) -> Value {
    let wind = options.wind.map(|wind| json!({ "from_deg": wind.from_deg, "speed_m_s": wind.speed_m_s }));
    let camera = options.camera.map(|camera| {
        json!({
            "sensor_width_mm": camera.sensor_width_mm,
            "sensor_height_mm": camera.sensor_height_mm,
            "image_width_px": camera.image_width_px,
            "image_height_px": camera.image_height_px,
            "focal_length_mm": camera.focal_length_mm,
            "min_interval_s": camera.min_interval_s,
        })
    });
    json!({
        "camera": camera,
        "is_landscape": options.is_landscape,
        "gsd_m": options.gsd_m,
        "height_m": options.height_m,
        "front_overlap": options.front_overlap,
        "side_overlap": options.side_overlap,
        "spacing_m": options.spacing_m,
        "trigger_m": options.trigger_m,
        "course_deg": options.course_deg,
        "wind": wind,
        "margin_m": options.margin_m,
        "lead_in_m": options.lead_in_m,
        "is_above_terrain": options.is_above_terrain,
        "ground_rel_home_m": options.ground_rel_home_m,
        "airspeed_m_s": options.airspeed_m_s,
        "coming_from": options.coming_from.map(|from| [from.lat_deg(), from.lon_deg()]),
    })
}

/// The options of a plan's survey or corridor, for laying it out again with changes. One of QGroundControl's own gives
/// its area, camera, overlap, height and angle; its turn-around is left out, because a plane needs more than is usual
/// there. `None` for an item that is not a survey, or lacks data.
pub fn survey_of(complex: &ComplexItem) -> Option<(SurveyShape, SurveyOptions)> {
    let value: Value = serde_json::from_str(&complex.json).ok()?;
    let places = |key: &str| value.get(key)?.as_array()?.iter().map(place_of).collect::<Option<Vec<_>>>();
    let shape = match complex.kind.as_str() {
        "survey" => SurveyShape::Area(places("polygon")?),
        "CorridorScan" => {
            SurveyShape::Corridor { line: places("polyline")?, width_m: value.get("CorridorWidth")?.as_f64()? }
        }
        _ => return None,
    };
    let options = match value.get("vencejo") {
        Some(asked) => options_of(asked)?,
        None => options_of_qgroundcontrol(&value)?,
    };
    Some((shape, options))
}

fn place_of(value: &Value) -> Option<GeoPoint> {
    GeoPoint::new(value.get(0)?.as_f64()?, value.get(1)?.as_f64()?).ok()
}

fn camera_of(value: &Value, keys: [&str; 6]) -> Option<Camera> {
    let number = |key: &str| value.get(key)?.as_f64();
    let pixels = |key: &str| number(key).map(|count| count.round() as u32);
    let [sensor_width, sensor_height, image_width, image_height, focal_length, interval] = keys;
    Some(Camera {
        sensor_width_mm: number(sensor_width)?,
        sensor_height_mm: number(sensor_height)?,
        image_width_px: pixels(image_width)?,
        image_height_px: pixels(image_height)?,
        focal_length_mm: number(focal_length)?,
        min_interval_s: number(interval).unwrap_or(0.0),
    })
}

fn options_of(asked: &Value) -> Option<SurveyOptions> {
    const CAMERA: [&str; 6] = [
        "sensor_width_mm",
        "sensor_height_mm",
        "image_width_px",
        "image_height_px",
        "focal_length_mm",
        "min_interval_s",
    ];
    let number = |key: &str| asked.get(key)?.as_f64();
    let there = |key: &str| asked.get(key).filter(|value| !value.is_null());
    let wind = there("wind").map(|wind| {
        Some(Wind { from_deg: wind.get("from_deg")?.as_f64()?, speed_m_s: wind.get("speed_m_s")?.as_f64()? })
    });
    Some(SurveyOptions {
        camera: match there("camera") {
            Some(camera) => Some(camera_of(camera, CAMERA)?),
            None => None,
        },
        is_landscape: asked.get("is_landscape")?.as_bool()?,
        gsd_m: number("gsd_m"),
        height_m: number("height_m"),
        front_overlap: number("front_overlap")?,
        side_overlap: number("side_overlap")?,
        spacing_m: number("spacing_m"),
        trigger_m: number("trigger_m"),
        course_deg: number("course_deg"),
        wind: wind.flatten(),
        margin_m: number("margin_m"),
        lead_in_m: number("lead_in_m"),
        is_above_terrain: asked.get("is_above_terrain")?.as_bool()?,
        ground_rel_home_m: number("ground_rel_home_m"),
        airspeed_m_s: number("airspeed_m_s"),
        coming_from: there("coming_from").and_then(place_of),
        ..SurveyOptions::default()
    })
}

/// From the keys that QGroundControl has (`TransectStyleComplexItem::_save`, `CameraCalc::save`). `None` for a height
/// above the sea, which does not tell the distance to the ground.
fn options_of_qgroundcontrol(value: &Value) -> Option<SurveyOptions> {
    const CAMERA: [&str; 6] =
        ["SensorWidth", "SensorHeight", "ImageWidth", "ImageHeight", "FocalLength", "MinTriggerInterval"];
    let transects = value.get("TransectStyleComplexItem")?;
    let calc = transects.get("CameraCalc")?;
    // Before version 2 two flags said what "DistanceMode" says.
    let is_set = |flag: Option<&Value>, to: bool| flag.and_then(Value::as_bool) == Some(to);
    let mode = calc.get("DistanceMode").and_then(Value::as_u64);
    let is_mode = |known: u8| mode == Some(known.into());
    let is_above_terrain =
        is_set(transects.get("FollowTerrain"), true) || is_mode(ABOVE_TERRAIN_BY_HOME) || is_mode(ABOVE_TERRAIN);
    if !is_above_terrain && (is_mode(ABOVE_SEA) || is_set(calc.get("DistanceToSurfaceRelative"), false)) {
        return None;
    }
    let number = |key: &str| calc.get(key)?.as_f64();
    let camera = camera_of(calc, CAMERA);
    let is_gsd = camera.is_some() && calc.get("ValueSetIsDistance").and_then(Value::as_bool) == Some(false);
    let part = |key: &str, usual: f64| number(key).map_or(usual, |percent| percent / 100.0);
    let usual = SurveyOptions::default();
    let without_camera = |key: &str| if camera.is_some() { None } else { number(key).filter(|apart_m| *apart_m > 0.0) };
    Some(SurveyOptions {
        camera,
        is_landscape: calc.get("Landscape").and_then(Value::as_bool).unwrap_or(true),
        gsd_m: if is_gsd { Some(number("ImageDensity")? / 100.0) } else { None },
        height_m: if is_gsd { None } else { Some(number("DistanceToSurface")?) },
        front_overlap: part("FrontalOverlap", usual.front_overlap),
        side_overlap: part("SideOverlap", usual.side_overlap),
        spacing_m: without_camera("AdjustedFootprintSide"),
        trigger_m: without_camera("AdjustedFootprintFrontal"),
        course_deg: value.get("angle").and_then(Value::as_f64),
        is_above_terrain,
        ..usual
    })
}

/// What QGroundControl lays lines out with.
fn camera_calc(survey: &Survey) -> Value {
    let options = &survey.options;
    let (mode, above_m) = if options.is_above_terrain {
        (ABOVE_TERRAIN, survey.height_m)
    } else {
        (ABOVE_HOME, survey.height_m + options.ground_rel_home_m.unwrap_or(0.0))
    };
    let mut calc = json!({
        "version": 2,
        "AdjustedFootprintFrontal": plain(survey.trigger_m.unwrap_or(0.0)),
        "AdjustedFootprintSide": plain(survey.spacing_m),
        "DistanceToSurface": plain(above_m),
        "DistanceMode": mode,
        "CameraName": "Manual (no camera specs)",
    });
    if let Some(((camera, print), gsd_m)) = options.camera.zip(survey.footprint).zip(survey.gsd_m) {
        let known = CAMERAS.iter().find(|known| known.camera == camera && known.is_known_to_qgroundcontrol());
        let overlap = |apart_m: f64, size_m: f64| plain(100.0 * (1.0 - apart_m / size_m).max(0.0));
        calc["CameraName"] = json!(known.map_or("Custom Camera", |known| known.name));
        calc["SensorWidth"] = plain(camera.sensor_width_mm);
        calc["SensorHeight"] = plain(camera.sensor_height_mm);
        calc["ImageWidth"] = json!(camera.image_width_px);
        calc["ImageHeight"] = json!(camera.image_height_px);
        calc["FocalLength"] = plain(camera.focal_length_mm);
        calc["Landscape"] = json!(options.is_landscape);
        calc["FixedOrientation"] = json!(false);
        calc["MinTriggerInterval"] = plain(camera.min_interval_s);
        calc["ValueSetIsDistance"] = json!(options.gsd_m.is_none());
        calc["ImageDensity"] = plain(100.0 * gsd_m);
        calc["FrontalOverlap"] = overlap(survey.trigger_m.unwrap_or(print.along_m), print.along_m);
        calc["SideOverlap"] = overlap(survey.spacing_m, print.across_m);
    }
    calc
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{
        ComplexPart, PlanSettings, complex_parts, edited_complex_items, read_plan_json, write_plan_json,
    };
    use crate::geodesy::direct;
    use crate::plan::{MissionItem, Plan};
    use crate::rehearsal::Aircraft;
    use crate::survey::{SurveyOptions, camera_named, design_survey};
    use proptest::prelude::*;

    fn survey(corners: &[GeoPoint], width_m: Option<f64>, options: SurveyOptions) -> Option<Survey> {
        let shape = match width_m {
            Some(width_m) => SurveyShape::Corridor { line: corners.to_vec(), width_m },
            None => SurveyShape::Area(corners.to_vec()),
        };
        design_survey(&shape, &options, &Aircraft::default()).ok()
    }

    fn options() -> SurveyOptions {
        let camera = camera_named("Sony a6000 16mm").map(|known| known.camera);
        SurveyOptions { camera, height_m: Some(120.0), ..SurveyOptions::default() }
    }

    /// A plan that holds a survey between a take-off and a return, and what goes with it to its file.
    fn plan_with(survey: &Survey) -> (Plan, PlanSettings) {
        let mut plan = Plan::default();
        plan.mission.items.push(MissionItem::takeoff(40.0, -4.0, 50.0, 12.0));
        plan.mission.items.extend(survey.items.clone());
        plan.mission.items.push(MissionItem::return_to_launch());
        (plan, PlanSettings { complex_items: vec![survey_item(survey)], ..PlanSettings::default() })
    }

    #[test]
    fn it_has_the_keys_that_qgroundcontrol_asks_for() {
        let start = GeoPoint::new(40.0, -4.0).unwrap();
        let corners = [start, direct(start, 90.0, 900.0), direct(start, 45.0, 1_200.0)];
        let survey = survey(&corners, None, SurveyOptions { is_above_terrain: true, ..options() }).unwrap();
        let item: Value = serde_json::from_str(&survey_item(&survey).json).unwrap();
        let transects = &item["TransectStyleComplexItem"];
        let calc = &transects["CameraCalc"];
        assert_eq!((&calc["CameraName"], &calc["DistanceMode"]), (&json!("Sony a6000 16mm"), &json!(4)));
        assert_eq!((&calc["DistanceToSurface"], &calc["ImageDensity"]), (&json!(120), &json!(2.9375)));
        assert_eq!(item["polygon"].as_array().unwrap().len(), 3);
        // `JsonHelper::validateKeys` of its `load` functions.
        let numbers = [
            "AdjustedFootprintSide",
            "AdjustedFootprintFrontal",
            "SensorWidth",
            "SensorHeight",
            "ImageWidth",
            "ImageHeight",
            "FocalLength",
            "MinTriggerInterval",
            "FrontalOverlap",
            "SideOverlap",
        ];
        assert!(numbers.iter().all(|key| calc[key].is_number()), "{calc}");
        assert!(["Landscape", "FixedOrientation", "ValueSetIsDistance"].iter().all(|key| calc[key].is_boolean()));
        assert!(["TurnAroundDistance", "CameraShots"].iter().all(|key| transects[key].is_number()));
        let flags = ["CameraTriggerInTurnAround", "HoverAndCapture", "Refly90Degrees"];
        assert!(flags.iter().all(|key| transects[key].is_boolean()));
        assert!(transects["VisualTransectPoints"].is_array() && transects["Items"].is_array());
        assert!(item["angle"].as_f64().is_some_and(|angle| (0.0..180.0).contains(&angle)));
    }

    #[test]
    fn qgroundcontrols_own_are_opened_by_its_keys() {
        let start = GeoPoint::new(40.0, -4.0).unwrap();
        let line = [start, direct(start, 90.0, 900.0)];
        let own = survey(&line, Some(80.0), SurveyOptions { front_overlap: 0.8, ..options() }).unwrap();
        let mut item: Value = serde_json::from_str(&survey_item(&own).json).unwrap();
        item.as_object_mut().unwrap().remove("vencejo");
        let theirs = ComplexItem { kind: "CorridorScan".to_owned(), json: item.to_string() };
        let (shape, opened) = survey_of(&theirs).unwrap();
        assert_eq!(shape, own.shape);
        assert_eq!((opened.camera, opened.height_m, opened.gsd_m), (own.options.camera, Some(120.0), None));
        assert!((opened.front_overlap - 0.8).abs() < 1e-9 && opened.side_overlap > 0.6);
        // By its resolution, if that was set there.
        item["TransectStyleComplexItem"]["CameraCalc"]["ValueSetIsDistance"] = json!(false);
        let (_, opened) = survey_of(&ComplexItem { json: item.to_string(), ..theirs.clone() }).unwrap();
        assert_eq!((opened.height_m, opened.gsd_m), (None, Some(0.029_375)));
        // Without a camera by the distances; of another kind, or without what lines are laid out from, not at all.
        let calc = item["TransectStyleComplexItem"]["CameraCalc"].as_object_mut().unwrap();
        calc.remove("SensorWidth");
        let (_, opened) = survey_of(&ComplexItem { json: item.to_string(), ..theirs.clone() }).unwrap();
        assert_eq!((opened.camera, opened.spacing_m), (None, Some(own.spacing_m)));
        assert_eq!(survey_of(&ComplexItem { kind: "fwLandingPattern".to_owned(), ..theirs.clone() }), None);
        item.as_object_mut().unwrap().remove("polyline");
        assert_eq!(survey_of(&ComplexItem { json: item.to_string(), ..theirs }), None);
    }

    #[test]
    fn heights_of_qgroundcontrols_own_count_from_what_they_counted_from() {
        let start = GeoPoint::new(40.0, -4.0).unwrap();
        let own = survey(&[start, direct(start, 90.0, 900.0)], Some(80.0), options()).unwrap();
        let mut item: Value = serde_json::from_str(&survey_item(&own).json).unwrap();
        item.as_object_mut().unwrap().remove("vencejo");
        let mut opened = |follows: Option<bool>, mode: Option<u8>, is_relative: Option<bool>| {
            let transects = item["TransectStyleComplexItem"].as_object_mut().unwrap();
            transects.insert("FollowTerrain".to_owned(), json!(follows));
            let calc = transects["CameraCalc"].as_object_mut().unwrap();
            calc.insert("DistanceMode".to_owned(), json!(mode));
            calc.insert("DistanceToSurfaceRelative".to_owned(), json!(is_relative));
            let complex = ComplexItem { kind: "CorridorScan".to_owned(), json: item.to_string() };
            survey_of(&complex).map(|(_, options)| (options.is_above_terrain, options.height_m))
        };
        let (flat, following) = (Some((false, Some(120.0))), Some((true, Some(120.0))));
        // "AltitudeMode": 1 above home, 3 and 4 above the ground; 2, above the sea, is not a height above the ground
        // photographed.
        for (mode, expected) in [(1, flat), (2, None), (3, following), (4, following)] {
            assert_eq!(opened(None, Some(mode), None), expected, "{mode}");
        }
        // Before version 2 two flags.
        assert_eq!(opened(Some(false), None, Some(true)), flat);
        assert_eq!(opened(Some(true), None, Some(true)), following);
        assert_eq!(opened(Some(true), None, Some(false)), following);
        assert_eq!(opened(Some(false), None, Some(false)), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

        /// A survey goes into a file as one item and comes back as the items that it was, with itself beside them;
        /// changed, its items are written one by one.
        #[test]
        fn a_survey_survives_the_file_and_an_edit_is_told(
            far in prop::collection::vec((0.0..360.0, 200.0..900.0), 3..6), width_m in prop::option::of(0.0..400.0),
            course_deg in 0.0..360.0, is_above_terrain: bool, change in prop::option::of(1..40_usize),
        ) {
            let start = GeoPoint::new(-33.9, 151.2).unwrap();
            let corners: Vec<GeoPoint> = far.iter().map(|(bearing, far_m)| direct(start, *bearing, *far_m)).collect();
            let asked = SurveyOptions { course_deg: Some(course_deg), is_above_terrain, ..options() };
            let Some(survey) = survey(&corners, width_m, asked) else { return Ok(()) };
            let (mut plan, settings) = plan_with(&survey);
            if let Some(index) = change {
                let count = plan.mission.items.len();
                plan.mission.items[1 + index % (count - 2)].params[0] = Some(7.0);
            }
            let edited = edited_complex_items(&plan, &settings).unwrap();
            prop_assert_eq!(edited.len(), usize::from(change.is_some()));
            let first = change.is_none().then_some(1);
            let count = survey.items.len();
            prop_assert_eq!(complex_parts(&plan, &settings).unwrap(), [ComplexPart { first, count }]);
            prop_assert_eq!(survey_of(&survey_item(&survey)), Some((survey.shape.clone(), asked)));
            let text = write_plan_json(&plan, &settings).unwrap();
            let written: Value = serde_json::from_str(&text).unwrap();
            let list = written["mission"]["items"].as_array().unwrap();
            prop_assert_eq!(list.len() == 3, change.is_none());
            let read = read_plan_json(text.as_bytes()).unwrap();
            prop_assert_eq!(&read.plan.mission.items, &plan.mission.items);
            prop_assert_eq!(read.settings.complex_items.len(), usize::from(change.is_none()));
            // And once more, from what was read.
            prop_assert_eq!(write_plan_json(&read.plan, &read.settings).unwrap(), text);
        }
    }
}
