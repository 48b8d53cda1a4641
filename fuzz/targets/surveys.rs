//! Any area or line, with any camera and options: refused with the reason, or a mission that the vehicle can store.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_flight::formats::{survey_item, survey_of};
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::landing::Wind;
use vencejo_flight::rehearsal::{Air, Aircraft, Conditions};
use vencejo_flight::survey::{CAMERAS, Camera, SurveyOptions, SurveyShape, design_survey, rehearse_survey};

mod wild;
use wild::Wild;

fuzz_target!(|data: &[u8]| {
    let mut wild = Wild(data);
    let what = wild.byte();
    let camera = match what & 3 {
        0 => None,
        1 => Some(Camera {
            sensor_width_mm: wild.number(60.0),
            sensor_height_mm: wild.number(60.0),
            image_width_px: u32::from(wild.byte()) << (wild.byte() % 24),
            image_height_px: u32::from(wild.byte()) << (wild.byte() % 24),
            focal_length_mm: wild.number(100.0),
            min_interval_s: wild.number(3.0),
        }),
        _ => Some(wild.one_of(&CAMERAS).camera),
    };
    let usual = SurveyOptions::default();
    let wind = what & 4 == 4;
    let options = SurveyOptions {
        camera,
        is_landscape: what & 8 == 8,
        gsd_m: wild.maybe(0.5),
        height_m: wild.maybe(400.0),
        front_overlap: wild.maybe(1.0).unwrap_or(usual.front_overlap),
        side_overlap: wild.maybe(1.0).unwrap_or(usual.side_overlap),
        spacing_m: wild.maybe(400.0),
        trigger_m: wild.maybe(100.0),
        course_deg: wild.maybe(360.0),
        wind: if wind { Some(Wind { from_deg: wild.number(360.0), speed_m_s: wild.number(20.0) }) } else { None },
        margin_m: wild.maybe(200.0),
        lead_in_m: wild.maybe(500.0),
        is_above_terrain: what & 16 == 16,
        ground_rel_home_m: wild.maybe(500.0),
        airspeed_m_s: wild.maybe(40.0),
        home_amsl_m: wild.maybe(5_000.0).unwrap_or(0.0),
        ..usual
    };
    let width_m = if what & 32 == 32 { Some(wild.number(500.0)) } else { None };
    let scale = if what & 64 == 64 { 0.5 } else { 0.01 };
    let mut places = Vec::new();
    while !wild.0.is_empty() && places.len() < 64 {
        let (lat, lon) = (wild.number(scale), wild.number(scale));
        let of = |off: f64, home: f64| if off.abs() <= scale { home + off } else { off };
        places.extend(GeoPoint::new(of(lat, 40.0), of(lon, 179.999)));
    }
    let shape = match width_m {
        Some(width_m) => SurveyShape::Corridor { line: places, width_m },
        None => SurveyShape::Area(places),
    };
    let plane = Aircraft::default();
    let laid = match design_survey(&shape, &options, &plane) {
        Ok(laid) => laid,
        Err(error) => return drop(error.to_string()),
    };
    assert!(laid.items.len() <= options.max_items, "{} items", laid.items.len());
    let item = survey_item(&laid);
    let (same, again) = survey_of(&item).expect("what was written is read");
    assert_eq!((same, again), (laid.shape.clone(), SurveyOptions { home_amsl_m: again.home_amsl_m, ..options }));
    if what & 128 == 128 {
        let air = Air::from(options.wind.unwrap_or(Wind { from_deg: 0.0, speed_m_s: 0.0 }));
        let (_, coverage) = rehearse_survey(&laid, &Conditions::new(&plane, air)).expect("it has places");
        let parts = [coverage.covered, coverage.overlapped];
        assert!(parts.into_iter().flatten().all(|part| (0.0..=1.0).contains(&part)), "{parts:?}");
    }
});
