//! The plan files of every program: read or refused, and the same again after writing.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_flight::formats::{
    PlanFormat, PlanSettings, complex_parts, read_plan, read_plan_json, read_waypoints, survey_of, write_plan,
    write_plan_json, write_waypoints,
};
use vencejo_flight::plan::Plan;

fuzz_target!(|data: &[u8]| {
    if let Ok(file) = read_plan(data, None)
        && file.plan != Plan::default()
    {
        // what these hold whole
        for format in [PlanFormat::Kmz, PlanFormat::GeoJson, PlanFormat::Csv] {
            let written =
                write_plan(&file.plan, &PlanSettings::default(), format).expect("the format holds every plan");
            let again = read_plan(&written.bytes, None).expect("what was written is read");
            assert_eq!((again.plan, again.notes), (file.plan.clone(), Vec::new()));
        }
    }
    if let Ok(file) = read_plan_json(data) {
        let complex_items = &file.settings.complex_items;
        if let Ok(parts) = complex_parts(&file.plan, &file.settings) {
            assert_eq!(parts.len(), complex_items.len());
        }
        complex_items.iter().for_each(|complex| drop(survey_of(complex)));
    }
    if let Ok(file) = read_plan_json(data)
        && let Ok(text) = write_plan_json(&file.plan, &file.settings)
    {
        let again = read_plan_json(text.as_bytes()).expect("what was written is read");
        assert_eq!(again.plan.mission.items.len(), file.plan.mission.items.len());
    }
    if let Ok(plan) = read_waypoints(data) {
        let text = write_waypoints(&plan).expect("a file holds one list");
        let again = read_waypoints(text.as_bytes()).expect("what was written is read");
        assert_eq!(again.mission.items.len(), plan.mission.items.len());
        assert_eq!(
            (again.fence.zones.len(), again.rally.points.len()),
            (plan.fence.zones.len(), plan.rally.points.len())
        );
    }
});
