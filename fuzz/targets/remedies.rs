//! Any plan, checked and fixed: each fix resolves its finding without a new error, and fixing terminates; also the
//! landings that end the plan.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_flight::approaches::{Runway, Site, landing_alternatives, options_of};
use vencejo_flight::checks::{CheckContext, FixKind, Inspection, Severity, fixes};
use vencejo_flight::plan::Plan;
use vencejo_flight::rehearsal::{Conditions, Ground};

mod plans;
mod wild;
use plans::Settings;
use wild::Wild;

/// Most fixes applied to a plan, one after the other: each of forty items needs a few at most. With rehearsals each
/// takes its time.
const MOST_ROUNDS: usize = 400;
const MOST_FLOWN_ROUNDS: usize = 2;

fuzz_target!(|data: &[u8]| {
    let mut wild = Wild(data);
    let what = wild.byte();
    let settings = Settings::out_of(&mut wild);
    let plane = settings.plane(&mut wild);
    let air = settings.air(&mut wild);
    let context = CheckContext {
        on_ground: [None, Some(true), Some(false)][usize::from(wild.byte() % 3)],
        finds_landing: [None, Some(true), Some(false)][usize::from(wild.byte() % 3)],
        airspeed_m_s: plane.airspeed_cruise_m_s,
        bank_deg: plane.bank_max_deg,
        ..CheckContext::default()
    };
    let plan = plans::plan(&mut wild);
    let ground = plans::ground(what & 7);
    let ground = ground.as_ref().map(|ground| ground as &Ground<'_>);
    let longest_s = plans::longest_s(what);
    let conditions = Conditions { ground, home: plan.mission.home, longest_s, ..Conditions::new(&plane, air) };
    let is_flown = what & 24 == 24;
    let inspection = Inspection { context, conditions: is_flown.then_some(conditions), clearance_m: 30.0 };
    if what & 32 == 32 {
        let points: Vec<_> = plan.mission.items.iter().filter_map(|item| item.point()).collect();
        let options = options_of(&plane, Some(air.wind));
        let site = match points[..] {
            [begin, end, ..] if what & 64 == 64 => Runway::new(begin, end).map(Site::Runway),
            [point, ..] => Ok(Site::Point(point)),
            [] => return,
        };
        if let Ok(found) = site.and_then(|site| landing_alternatives(site, &options, &conditions)) {
            for one in found {
                let numbers = [one.flown.touch_down_m, one.flown.rest_m, Some(one.flown.duration_s), one.crosswind_m_s];
                assert!(numbers.iter().flatten().all(|number| number.is_finite()), "{:?}", one.flown);
                assert!(one.landing.items.iter().all(|item| item.unsendable().is_none()), "{:?}", one.landing.items);
            }
        }
        return;
    }
    mend(plan, inspection);
});

fn mend(mut plan: Plan, mut inspection: Inspection<'_>) {
    for _ in 0..if inspection.conditions.is_some() { MOST_FLOWN_ROUNDS } else { MOST_ROUNDS } {
        let before = inspection.findings(&plan);
        before.iter().for_each(|finding| assert!(!finding.to_string().is_empty()));
        let found = fixes(&plan, &inspection);
        let Some((finding, fix)) = found.first() else { return };
        assert!(!fix.message().is_empty());
        let changed = fix.applied(&plan);
        if matches!(fix.kind, FixKind::SetParameter { .. }) {
            assert_eq!(changed, plan, "its items stay");
            inspection.context.finds_landing = Some(true);
        }
        let after = inspection.findings(&changed);
        let count =
            |found: &[vencejo_flight::checks::Finding]| found.iter().filter(|one| one.code() == finding.code()).count();
        assert!(count(&after) < count(&before), "{fix:?} leaves {finding:?}");
        let errors = |found: &[vencejo_flight::checks::Finding], code| {
            found.iter().filter(|one| one.severity == Severity::Error && one.code() == code).count()
        };
        for one in after.iter().filter(|one| one.severity == Severity::Error) {
            assert!(errors(&after, one.code()) <= errors(&before, one.code()), "{fix:?} brings {one:?}");
        }
        plan = changed;
    }
    assert!(inspection.conditions.is_some(), "there is no end to what is mended: {:?}", fixes(&plan, &inspection));
}
