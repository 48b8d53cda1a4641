//! Surveys laid out, and flown in a rehearsal.

use super::*;
use crate::checks::{CheckContext, FindingCode, Severity, check_plan, check_survey};
use crate::geodesy::{GeoPoint, direct, inverse, leg_offset, point_in_polygon, wrap_180_deg};
use crate::landing::Wind;
use crate::plan::{Command, Home, MavFrame, Mission, Plan};
use crate::progress::Circled;
use crate::rehearsal::{Air, Aircraft, Conditions, Doing, Rehearsal, Start, rehearse};
use proptest::prelude::*;

const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 };

fn home() -> GeoPoint {
    HOME.point().unwrap()
}

fn place(north: f64, east: f64) -> GeoPoint {
    direct(direct(home(), 0.0, north), 90.0, east)
}

fn area(corners: &[(f64, f64)]) -> SurveyShape {
    SurveyShape::Area(corners.iter().map(|(north, east)| place(*north, *east)).collect())
}

fn options() -> SurveyOptions {
    SurveyOptions {
        camera: camera_named("Sony a6000 16mm").map(|known| known.camera),
        height_m: Some(120.0),
        ground_rel_home_m: Some(0.0),
        home_amsl_m: HOME.alt_amsl_m,
        ..SurveyOptions::default()
    }
}

fn wind(from_deg: f64, speed_m_s: f64) -> Option<Wind> {
    Some(Wind { from_deg, speed_m_s })
}

fn fly(survey: &Survey, plane: &Aircraft) -> (Rehearsal, Coverage) {
    let blows = survey.options.wind.unwrap_or(Wind { from_deg: 0.0, speed_m_s: 0.0 });
    let air = Air { exponent: 0.0, ..Air::from(blows) };
    rehearse_survey(survey, &Conditions { home: Some(HOME), ..Conditions::new(plane, air) }).unwrap()
}

/// Every line flown, near it, with as many pictures as said and no hole.
fn is_flown(survey: &Survey, plane: &Aircraft, within_m: f64) -> Coverage {
    let (flown, coverage) = fly(survey, plane);
    for (number, line) in coverage.lines.iter().enumerate() {
        assert!(
            !line.is_missed && line.off_m.unwrap() < within_m,
            "line {number} of {}: {line:?}",
            coverage.lines.len()
        );
    }
    assert_eq!(coverage.lines.len(), survey.lines.len());
    // The end of a line may lie a hair before or after a picture.
    assert!(
        coverage.photos.len().abs_diff(survey.photos) <= survey.lines.len(),
        "{} {}",
        coverage.photos.len(),
        survey.photos
    );
    let longest_s = 1.1 * survey.duration_s + 60.0;
    let last = flown.passages.last().unwrap();
    assert!(last.reached_s.unwrap() < longest_s && flown.duration_s > 0.85 * survey.duration_s, "{last:?}");
    coverage
}

#[test]
fn a_field_is_covered_in_race_track_order() {
    let plane = Aircraft::default();
    let field = area(&[(200.0, 200.0), (200.0, 1_000.0), (900.0, 1_000.0), (900.0, 200.0)]);
    let options = SurveyOptions { wind: wind(0.0, 5.0), ..options() };
    let survey = design_survey(&field, &options, &plane).unwrap();
    assert_eq!((survey.course_from, survey.lines.len()), (LineCourse::AcrossWind, 14));
    assert!((survey.groundspeed_m_s.0 - survey.groundspeed_m_s.1).abs() < 1e-9, "the same both ways");
    assert!((survey.crab_deg - 12.7).abs() < 0.1 && (survey.gsd_m.unwrap() - 0.029_375).abs() < 1e-9);
    let print = survey.footprint.unwrap();
    assert!((print.across_m - 176.25).abs() < 1e-9 && (survey.trigger_m.unwrap() - 0.25 * print.along_m).abs() < 1e-9);
    assert!((survey.spacing_m - 0.35 * print.across_m).abs() < 1e-9);
    assert!((survey.area_m2 - 560_000.0).abs() < 1.0);
    assert_eq!(survey.cautions, []);
    // It begins downwind, and no two lines that follow each other are nearer than a half circle is wide.
    assert!(survey.lines[0].points[0].lat_deg() < place(550.0, 0.0).lat_deg());
    for pair in survey.lines.windows(2) {
        let apart_m = leg_offset(pair[0].points[0], pair[0].points[1], pair[1].points[0]).cross_m.abs();
        assert!(apart_m > 2.0 * survey.turn_radius_m - 1e-3, "{apart_m}");
    }
    let coverage = is_flown(&survey, &plane, 3.0);
    assert_eq!((coverage.covered, coverage.holes.len(), coverage.views_promised), (Some(1.0), 0, 6));
    assert!(coverage.overlapped.unwrap() > 0.999, "{:?}", coverage.overlapped);
    // In a valley below home it is flown as well.
    let low = SurveyOptions { ground_rel_home_m: Some(-150.0), ..options };
    let low = is_flown(&design_survey(&field, &low, &plane).unwrap(), &plane, 3.0);
    assert_eq!((low.covered, low.photos.len()), (Some(1.0), coverage.photos.len()));
    // The checks of a plan find no error in it.
    let mission = Mission { home: Some(HOME), items: survey.items.clone() };
    let context = CheckContext { far_from_home_m: f64::MAX, ..CheckContext::default() };
    let said = check_plan(&Plan::from_mission(mission), &context);
    assert!(said.iter().all(|finding| finding.severity != Severity::Error), "{said:?}");
}

#[test]
fn the_camera_is_on_from_the_first_picture_of_a_line_to_the_last() {
    let field = area(&[(0.0, 0.0), (0.0, 500.0), (400.0, 500.0), (400.0, 0.0)]);
    let asked = SurveyOptions { course_deg: Some(0.0), margin_m: Some(0.0), airspeed_m_s: Some(18.0), ..options() };
    let survey = design_survey(&field, &asked, &Aircraft::default()).unwrap();
    let trigger_m = survey.trigger_m;
    for line in &survey.lines {
        let [entry, on, exit, off] = [0, 1, 2, 3].map(|step| &survey.items[line.entry + step]);
        assert_eq!(line.exit, line.entry + 2);
        assert_eq!((entry.point(), exit.point()), (line.points.first().copied(), line.points.last().copied()));
        assert_eq!((on.command, on.param(1), on.param(3)), (Command::DO_SET_CAM_TRIGG_DIST, trigger_m, Some(1.0)));
        assert_eq!((off.command, off.param(1)), (Command::DO_SET_CAM_TRIGG_DIST, Some(0.0)));
        let way = inverse(line.points[0], line.points[1]);
        assert!((way.distance_m - 400.0).abs() < 0.1, "{way:?}");
    }
    let first = &survey.items[0];
    assert_eq!((first.command, first.param(2)), (Command::DO_CHANGE_SPEED, Some(18.0)));
    assert_eq!(survey.items.last().unwrap().param(2), Some(-2.0), "the plane's own speed again");
    assert!(survey.items.iter().filter_map(|item| item.alt_m()).all(|alt_m| alt_m == 120.0));
    assert!(
        survey.items.iter().filter(|item| item.has_position()).all(|item| item.frame == MavFrame::GlobalRelativeAlt)
    );
    // Without a margin as many lines as it takes to be no farther from one than half their distance.
    assert_eq!(survey.lines.len(), (500.0 / survey.spacing_m).ceil() as usize);
    let raised = SurveyOptions { ground_rel_home_m: Some(35.0), ..asked };
    let raised = design_survey(&field, &raised, &Aircraft::default()).unwrap();
    assert!(raised.items.iter().filter_map(|item| item.alt_m()).all(|alt_m| alt_m == 155.0));
    let terrain = SurveyOptions { is_above_terrain: true, ground_rel_home_m: None, ..asked };
    let terrain = design_survey(&field, &terrain, &Aircraft::default()).unwrap();
    assert!(
        terrain.items.iter().filter(|item| item.has_position()).all(|item| item.frame == MavFrame::GlobalTerrainAlt)
    );
    assert_eq!(terrain.cautions, []);
    // No camera: lines alone, as far apart as asked.
    let bare = SurveyOptions { camera: None, spacing_m: Some(80.0), ..asked };
    let bare = design_survey(&field, &bare, &Aircraft::default()).unwrap();
    assert_eq!((bare.gsd_m, bare.trigger_m, bare.photos, bare.lines.len()), (None, None, 0, 7));
    assert!(bare.items.iter().all(|item| item.command != Command::DO_SET_CAM_TRIGG_DIST));
    let (_, flown) = fly(&bare, &Aircraft::default());
    assert!(flown.covered.is_none() && flown.lines.iter().all(|line| !line.is_missed));
}

#[test]
fn a_bay_is_flown_through_with_the_camera_off() {
    // A horseshoe, open to the north.
    let shoe = area(&[
        (0.0, 0.0),
        (0.0, 900.0),
        (700.0, 900.0),
        (700.0, 700.0),
        (250.0, 700.0),
        (250.0, 200.0),
        (700.0, 200.0),
        (700.0, 0.0),
    ]);
    let asked = SurveyOptions { course_deg: Some(90.0), ..options() };
    let plane = Aircraft::default();
    let survey = design_survey(&shoe, &asked, &plane).unwrap();
    let whole = area(&[(0.0, 0.0), (0.0, 900.0), (700.0, 900.0), (700.0, 0.0)]);
    let whole = design_survey(&whole, &asked, &plane).unwrap();
    assert!(survey.lines.len() > whole.lines.len() && survey.photos < whole.photos, "fewer pictures on more stretches");
    let coverage = is_flown(&survey, &plane, 4.0);
    assert!(coverage.covered.unwrap() > 0.9999 && coverage.overlapped.unwrap() > 0.99, "{coverage:?}");
    let bay = [place(320.0, 350.0), place(320.0, 550.0), place(600.0, 550.0), place(600.0, 350.0)];
    assert_eq!(coverage.photos.iter().filter(|photo| point_in_polygon(photo.point, &bay)).count(), 0);
}

#[test]
fn a_corridor_is_flown_in_passes_with_its_corners_flown_over() {
    let plane = Aircraft::default();
    let road = |width_m| SurveyShape::Corridor {
        line: vec![place(0.0, 0.0), place(900.0, 0.0), place(1_500.0, 120.0), place(1_500.0, 1_200.0)],
        width_m,
    };
    let asked = SurveyOptions { wind: wind(300.0, 6.0), ..options() };
    let narrow = design_survey(&road(60.0), &asked, &plane).unwrap();
    assert_eq!(narrow.lines.len(), 2, "one pass; the bend of 11 degrees is flown, that of 79 is flown over");
    assert_eq!(narrow.lines.iter().map(|line| line.points.len()).sum::<usize>(), 5);
    let coverage = is_flown(&narrow, &plane, 12.0);
    assert!(coverage.covered.unwrap() > 0.999, "{coverage:?}");
    let wide = design_survey(&road(300.0), &asked, &plane).unwrap();
    assert_eq!(wide.lines.len() % 2, 0);
    assert!(wide.lines.len() >= 10 && wide.course_from == LineCourse::Corridor);
    let coverage = is_flown(&wide, &plane, 12.0);
    assert!(
        coverage.covered.unwrap() > 0.999 && coverage.overlapped.unwrap() > 0.9,
        "{:?} {:?}",
        coverage.covered,
        coverage.overlapped
    );
    let line = design_survey(&road(0.0), &asked, &plane).unwrap();
    assert_eq!(line.items, narrow.items, "one pass along the line");
    for width_m in [0.0, 0.5] {
        let (_, coverage) = fly(&design_survey(&road(width_m), &asked, &plane).unwrap(), &plane);
        assert_eq!((coverage.covered, coverage.holes.len()), (Some(1.0), 0), "{width_m}");
    }
}

#[test]
fn the_pilot_is_told_what_to_know() {
    let field = area(&[(0.0, 0.0), (0.0, 300.0), (1_200.0, 300.0), (1_200.0, 0.0)]);
    let plane = Aircraft::default();
    let codes = |asked: SurveyOptions| {
        let survey = design_survey(&field, &asked, &plane).unwrap();
        survey.cautions.iter().map(|caution| caution.as_str()).collect::<Vec<_>>()
    };
    let wide = SurveyOptions { height_m: Some(60.0), side_overlap: 0.7, ..options() };
    assert_eq!(codes(SurveyOptions { course_deg: Some(90.0), ..wide }), ["camera-too-slow"]);
    assert_eq!(
        codes(SurveyOptions { wind: wind(90.0, 6.0), ground_rel_home_m: None, ..options() })[..1],
        ["ground-not-known"]
    );
    assert_eq!(codes(SurveyOptions { wind: wind(90.0, 6.0), course_deg: Some(90.0), ..options() }), ["along-wind"]);
    // Long lines, along the area: few, and too near to each other.
    assert_eq!(codes(SurveyOptions { margin_m: Some(0.0), ..options() }), ["tight-turns"]);
    assert_eq!(codes(SurveyOptions { spacing_m: Some(250.0), course_deg: Some(90.0), ..options() }), ["gaps"]);
    let survey = design_survey(&field, &SurveyOptions { margin_m: Some(0.0), ..options() }, &plane).unwrap();
    assert_eq!((survey.course_from, survey.lines.len()), (LineCourse::AlongArea, 5));
    is_flown(&survey, &plane, 6.0);
    let slow = SurveyCaution::CameraTooSlow { interval_s: 0.72, least_s: 1.0 };
    assert_eq!(
        slow.to_string(),
        "a picture is due every 0.7 s, the camera needs 1.0 s: fly slower or higher, or overlap less"
    );
}

#[test]
fn lines_that_are_missed_are_found() {
    // Laid out for calm air and without a lead, flown in a gale from the side.
    let field = area(&[(0.0, 0.0), (0.0, 900.0), (700.0, 900.0), (700.0, 0.0)]);
    let plane = Aircraft::default();
    let narrow = camera_named("Sony a6000 35mm").map(|known| known.camera);
    let asked = SurveyOptions {
        camera: narrow,
        lead_in_m: Some(0.0),
        course_deg: Some(90.0),
        side_overlap: 0.1,
        margin_m: Some(0.0),
        ..options()
    };
    let calm = design_survey(&field, &asked, &plane).unwrap();
    let windy = Survey { options: SurveyOptions { wind: wind(0.0, 14.0), ..asked }, ..calm.clone() };
    let (_, coverage) = fly(&windy, &plane);
    let found = check_survey(&windy, &coverage, &windy.items, 0);
    let missed = coverage.lines.iter().filter(|line| line.is_missed).count();
    assert!(missed > 2 && coverage.covered.unwrap() < 0.999, "{missed} {:?}", coverage.covered);
    assert_eq!(found.iter().filter(|finding| finding.code() == FindingCode::SurveyLineMissed).count(), missed);
    let holes = found.last().unwrap();
    assert_eq!((holes.code(), holes.item), (FindingCode::SurveyHoles, None));
    assert!(holes.message.contains("are on no picture"), "{holes}");
    let (_, coverage) = fly(&calm, &plane);
    assert!(coverage.photos.iter().all(|photo| photo.time_s > 0.0));
    // Never flown: all of them.
    let (flown, _) = fly(&calm, &plane);
    let elsewhere = super::coverage(&calm, 5_000, &flown, &plane, None);
    assert!(elsewhere.lines.iter().all(|line| line.is_missed && line.off_m.is_none()));
}

#[test]
fn a_camera_takes_its_pictures_as_ardupilot_orders_them() {
    let plane = Aircraft::default();
    let at = |north: f64| place(north, 0.0);
    let fly_to = |north: f64| crate::plan::MissionItem::waypoint(at(north).lat_deg(), at(north).lon_deg(), 100.0);
    let trigger = |every_m: f64, now: f64| {
        crate::plan::MissionItem::action(Command::DO_SET_CAM_TRIGG_DIST, [every_m, 0.0, now, 0.0])
    };
    let shoot = crate::plan::MissionItem {
        params: [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0].map(Some),
        ..crate::plan::MissionItem::action(Command::DO_DIGICAM_CONTROL, [0.0; 4])
    };
    let items = vec![
        fly_to(1_000.0),
        trigger(100.0, 1.0),
        fly_to(1_950.0),
        trigger(0.0, 0.0),
        fly_to(2_500.0),
        trigger(100.0, 0.0),
        fly_to(2_950.0),
        trigger(0.0, 0.0),
        shoot,
        fly_to(3_500.0),
    ];
    let plan = Plan::from_mission(Mission { home: Some(HOME), items });
    let start = Start::Air {
        point: at(0.0),
        height_m: 100.0,
        heading_deg: 0.0,
        airspeed_m_s: 22.0,
        index: 0,
        doing: Doing::Mission,
        circled: Circled::Nothing,
    };
    let calm = Air::from(Wind { from_deg: 0.0, speed_m_s: 0.0 });
    let flown = rehearse(&plan, &Conditions { start, ..Conditions::new(&plane, calm) }).unwrap();
    let north = |photo: &Photo| inverse(home(), photo.point).distance_m;
    let taken: Vec<f64> = photographs(&flown, 0.0, 0.0).iter().map(north).collect();
    // At once and every 100 m; then not at once; then one more.
    assert_eq!(taken.len(), 10 + 4 + 1, "{taken:?}");
    let expected = (0..10)
        .map(|n| 1_000.0 + 100.0 * f64::from(n))
        .chain((1..5).map(|n| 2_500.0 + 100.0 * f64::from(n)))
        .chain([2_950.0]);
    for (taken_m, expected_m) in taken.iter().zip(expected) {
        assert!((0.0..8.0).contains(&(taken_m - expected_m)), "{taken_m} {expected_m}");
    }
    // A camera that needs ten seconds is late, and takes the next 100 m later at the soonest.
    let slow = photographs(&flown, 10.0, 0.0);
    assert!(slow.windows(2).all(|pair| pair[1].time_s - pair[0].time_s > 9.999) && slow.len() >= 5, "{}", slow.len());
}

#[test]
fn what_cannot_be_is_refused_with_what_to_change() {
    let field = area(&[(0.0, 0.0), (0.0, 900.0), (900.0, 900.0), (900.0, 0.0)]);
    let fine = options();
    for (asked, says) in [
        (SurveyOptions { height_m: None, ..fine }, "give either the ground sample distance or the height"),
        (SurveyOptions { gsd_m: Some(0.03), ..fine }, "give either"),
        (SurveyOptions { camera: None, ..fine }, "without a camera give the distance between lines"),
        (SurveyOptions { camera: None, height_m: None, gsd_m: Some(0.03), ..fine }, "needs a camera"),
        (SurveyOptions { spacing_m: Some(0.0), ..fine }, "spacing_m is 0, should be 1 to 10000"),
        (SurveyOptions { side_overlap: 1.0, ..fine }, "side_overlap is 1"),
        (SurveyOptions { front_overlap: f64::NAN, ..fine }, "front_overlap is NaN"),
        (SurveyOptions { gsd_m: Some(0.000_5), height_m: None, ..fine }, "height_m is 2"),
        (SurveyOptions { wind: wind(0.0, 25.0), ..fine }, "does not get along lines of course 90"),
        (SurveyOptions { height_m: Some(15.0), ..fine }, "the vehicle holds 649: widen the spacing"),
        (SurveyOptions { spacing_m: Some(1.0), max_items: usize::MAX, height_m: Some(9.0), ..fine }, ""),
        (SurveyOptions { airspeed_m_s: Some(500.0), ..fine }, "airspeed_m_s is 500"),
    ] {
        match design_survey(&field, &asked, &Aircraft::default()) {
            Err(error) => assert!(error.to_string().contains(says) && !says.is_empty(), "{error}"),
            Ok(_) => assert!(says.is_empty(), "{says}"),
        }
    }
}

/// A shape of some corners around a place: concave ones too, that never cross themselves.
fn shapes() -> impl Strategy<Value = SurveyShape> {
    let star = prop::collection::vec((0.35..1.0_f64, 0.6..1.4_f64), 3..10);
    (star, 150.0..900.0_f64, -2_000.0..2_000.0_f64, -2_000.0..2_000.0_f64).prop_map(|(star, size_m, north, east)| {
        let whole: f64 = star.iter().map(|(_, step)| step).sum();
        let middle = place(north, east);
        let mut turned = 0.0;
        let corner = |(reach, step): &(f64, f64)| {
            turned += step / whole * 360.0;
            direct(middle, turned, reach * size_m)
        };
        SurveyShape::Area(star.iter().map(corner).collect())
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    /// Whatever the field, the wind and the plane: it is flown as laid out, and its pictures show all of it.
    #[test]
    fn any_field_is_covered_by_a_plane_that_flies_it(
        field in shapes(), from_deg in 0.0..360.0, speed_m_s in 0.0..8.0_f64, cruise_m_s in 14.0..25.0_f64,
        course_deg in prop::option::of(0.0..360.0), height_m in 90.0..160.0_f64, is_landscape: bool,
    ) {
        let plane = Aircraft { airspeed_cruise_m_s: cruise_m_s, ..Aircraft::default() };
        let plane = Aircraft { airframe: crate::rehearsal::Airframe::of_parameters(cruise_m_s, &plane.tecs, 0.0), ..plane };
        let asked = SurveyOptions { wind: wind(from_deg, speed_m_s), course_deg, height_m: Some(height_m), is_landscape, ..options() };
        let survey = design_survey(&field, &asked, &plane).unwrap();
        let coverage = is_flown(&survey, &plane, 12.0);
        prop_assert!(coverage.covered.unwrap() > 0.999, "{:?}", coverage.covered);
        prop_assert!(coverage.overlapped.unwrap() > 0.95, "{:?}", coverage.overlapped);
        for line in &survey.lines {
            let course = inverse(line.points[0], line.points[1]).bearing_start_deg;
            let off_deg = wrap_180_deg(2.0 * (course - survey.course_deg)) / 2.0;
            prop_assert!(off_deg.abs() < 0.1, "{course} {}", survey.course_deg);
        }
    }

    /// Whatever is asked for: an answer with finite numbers within what the vehicle holds, or an error.
    #[test]
    fn anything_asked_is_laid_out_or_refused(
        points in prop::collection::vec((-90.0..=90.0_f64, -180.0..=180.0_f64, -3e-3..3e-3_f64, -3e-3..3e-3_f64), 1..7), is_near: bool,
        width_m in prop::option::of(-1.0..6_000.0_f64), gsd_m in 0.0..0.3_f64, overlap in -0.1..1.0_f64,
        speed_m_s in 0.0..30.0_f64, spacing_m in prop::option::of(-1.0..500.0_f64),
    ) {
        let around = points[0];
        let line: Vec<GeoPoint> = points.iter().filter_map(|(lat, lon, north, east)| {
            if is_near { GeoPoint::new(around.0 + north, around.1 + east).ok() } else { GeoPoint::new(*lat, *lon).ok() }
        }).collect();
        let shape = match width_m {
            Some(width_m) => SurveyShape::Corridor { line, width_m },
            None => SurveyShape::Area(line),
        };
        let asked = SurveyOptions {
            height_m: None, gsd_m: Some(gsd_m), side_overlap: overlap, wind: wind(77.0, speed_m_s), spacing_m, ..options()
        };
        if let Ok(survey) = design_survey(&shape, &asked, &Aircraft::default()) {
            prop_assert!(survey.items.len() < asked.max_items);
            prop_assert!(!survey.lines.is_empty());
            prop_assert!(survey.length_m.is_finite() && survey.duration_s.is_finite() && survey.line_m > 0.0);
            for item in &survey.items {
                prop_assert_eq!(item.check_sendable(vencejo_proto::MissionSeq(1)), Ok(()));
            }
            let way_m: f64 = survey.lines.iter().map(|line| crate::geodesy::polyline_length_m(&line.points)).sum();
            prop_assert!((way_m - survey.line_m).abs() < 1e-3 * way_m + 0.1, "{way_m} {}", survey.line_m);
        }
    }
}
