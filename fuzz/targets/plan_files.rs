//! Plan files of all programs: read or refused, and the same after writing and reading again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_flight::formats::{
    NoteCode, PlanFile, PlanFormat, PlanSettings, complex_parts, read_plan, read_plan_json, read_waypoints, survey_of,
    write_plan, write_plan_json, write_waypoints,
};
use vencejo_flight::plan::Plan;

mod quick;
use quick::quick;

/// Plans up to this size can always be written.
const GEOJSON_ITEMS: usize = 5_000;

fuzz_target!(|data: &[u8]| {
    if let Ok(file) = quick(|| read_plan(data, None))
        && file.plan != Plan::default()
    {
        // Formats that preserve everything.
        for format in [PlanFormat::Kmz, PlanFormat::GeoJson, PlanFormat::Csv] {
            let Ok(written) = write_plan(&file.plan, &PlanSettings::default(), format) else {
                let is_large = file.plan.mission.items.len() > GEOJSON_ITEMS;
                assert!(format == PlanFormat::GeoJson && is_large, "the format holds every plan");
                continue;
            };
            let again = read_plan(&written.bytes, None).expect("what was written is read");
            assert_eq!(again.plan, file.plan);
            // The plan's missing altitudes and items are noted again.
            let is_again = |code| matches!(code, NoteCode::HeightsMissing | NoteCode::ItemsElsewhere);
            assert!(again.notes.iter().all(|note| is_again(note.code)), "{:?}", again.notes);
        }
    }
    if let Ok(file) = quick(|| read_plan_json(data)) {
        let complex_items = &file.settings.complex_items;
        if let Ok(parts) = complex_parts(&file.plan, &file.settings) {
            assert_eq!(parts.len(), complex_items.len());
        }
        complex_items.iter().for_each(|complex| drop(survey_of(complex)));
        if let Ok(text) = write_plan_json(&file.plan, &file.settings) {
            let again = read_plan_json(text.as_bytes()).expect("what was written is read");
            assert_eq!(again.plan.mission.items.len(), file.plan.mission.items.len());
        }
    }
    if let Ok(PlanFile { plan, .. }) = quick(|| read_waypoints(data)) {
        let (items, zones, points) = (plan.mission.items.len(), plan.fence.zones.len(), plan.rally.points.len());
        let Ok(text) = write_waypoints(&plan) else {
            assert!(items == 0 && !plan.fence.is_empty() && points > 0, "a plan of one list is written");
            return;
        };
        let again = read_waypoints(text.as_bytes()).expect("what was written is read").plan;
        // A read file may have several lists; a written one has one.
        let kept = if items > 0 { (items, 0, 0) } else { (0, zones, points) };
        assert_eq!((again.mission.items.len(), again.fence.zones.len(), again.rally.points.len()), kept);
    }
});
