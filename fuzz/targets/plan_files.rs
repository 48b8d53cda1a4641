//! The plan files of every program: read or refused, and the same again after writing.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_flight::formats::{read_plan, read_plan_json, read_waypoints, write_plan_json, write_waypoints};

fuzz_target!(|data: &[u8]| {
    let _ = read_plan(data, None);
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
        assert_eq!((again.fence.zones.len(), again.rally.points.len()), (plan.fence.zones.len(), plan.rally.points.len()));
    }
});
