//! Any failure at any time of any plan: each has an outcome, which does not depend on the other failures requested.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_flight::rehearsal::{Conditions, Ground, Trigger, WhatIf, glide_range, what_ifs};

mod plans;
mod sound;
mod wild;
use plans::Settings;
use sound::check;
use wild::Wild;

fuzz_target!(|data: &[u8]| {
    let mut wild = Wild(data);
    let what = wild.byte();
    // Soon after the start and one after the other, or once late.
    let mut moments: Vec<f64> = (0..=wild.byte() % 3).map(|_| f64::from(wild.byte())).collect();
    if what & 8 == 8 {
        moments = vec![moments[0] * 12.0];
    }
    moments.sort_by(f64::total_cmp);
    let settings = Settings::out_of(&mut wild);
    let plane = settings.plane(&mut wild);
    let air = settings.air(&mut wild);
    let start = plans::start(&mut wild);
    let plan = plans::plan(&mut wild);
    let ground = plans::ground(what & 7);
    let ground = ground.as_ref().map(|ground| ground as &Ground<'_>);
    let conditions = Conditions { start, ground, longest_s: plans::longest_s(what), ..Conditions::new(&plane, air) };
    let Ok(found) = what_ifs(&plan, &conditions, Trigger::ALL, &moments) else { return };
    for one in &found {
        one.flown.iter().for_each(check);
        let times = one.decisions.iter().map(|decision| decision.time_s);
        assert!(times.clone().all(|time_s| time_s >= one.at.time_s), "{:?}", one.decisions);
        assert!(times.is_sorted());
        let glides = glide_range(&plan, &conditions, &one.at).expect("home is known");
        assert!(glides.is_empty() || glides.len() == 72, "{}", glides.len());
    }
    // Each as if requested alone.
    let trigger = wild.one_of(Trigger::ALL);
    let is_of = |one: &&WhatIf| one.trigger == trigger;
    let alone = what_ifs(&plan, &conditions, &[trigger], &moments).expect("home is known");
    assert!(alone.iter().eq(found.iter().filter(is_of)), "{trigger:?} depends on what is asked for beside it");
});
