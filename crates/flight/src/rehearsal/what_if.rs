//! What if: the flight from any moment of a plan on, after a failure or a commanded return.

use super::failsafe::{Reaction, Trigger};
use super::fly::{Conditions, Flight, NotRehearsed, laid_out};
use super::outcome::{Rehearsal, Sample};
use crate::plan::Plan;

/// One decision of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// When, s since the start of the plan.
    pub time_s: f64,
    /// Its reaction.
    pub reaction: Reaction,
}

/// What follows from something that happens at a moment of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct WhatIf {
    /// What happens.
    pub trigger: Trigger,
    /// Where the plane is then; its time is that of the plan.
    pub at: Sample,
    /// Decisions of the vehicle, in order of time; empty where its failsafes ignore the trigger. The last one is final.
    pub decisions: Vec<Decision>,
    /// The flight from that moment to its end. Times are those of the plan; distance and energy are those since its
    /// start. `None` where the mission goes on as rehearsed, or the flight ended before a decision.
    pub flown: Option<Rehearsal>,
}

impl WhatIf {
    /// The final reaction.
    pub fn reaction(&self) -> Reaction {
        self.decisions.last().map_or(Reaction::GoesOn, |decision| decision.reaction)
    }
}

/// Flies a plan once, and from each moment (s since the start, in order) that it is in the air at on once more for each
/// trigger that changes the flight.
///
/// # Errors
/// As [`rehearse`](super::rehearse).
pub fn what_ifs(
    plan: &Plan,
    conditions: &Conditions<'_>,
    triggers: &[Trigger],
    moments: &[f64],
) -> Result<Vec<WhatIf>, NotRehearsed> {
    let course = laid_out(plan, conditions)?;
    let mut flight = Flight::new(&course, conditions);
    let mut found = Vec::new();
    for time_s in moments {
        if !flight.until(*time_s) {
            break;
        }
        if flight.is_in_the_air() {
            found.extend(triggers.iter().map(|trigger| what_if(&flight, conditions, *trigger)));
        }
    }
    if (conditions.is_wanted)() { Ok(found) } else { Err(NotRehearsed::NotWanted) }
}

fn what_if(before: &Flight<'_>, conditions: &Conditions<'_>, trigger: Trigger) -> WhatIf {
    let (at, began_s) = (before.now(), before.time_s());
    let mut flight = before.clone();
    flight.diverts();
    if trigger == Trigger::EngineStopped {
        flight.loses_engine();
        flight.until(f64::INFINITY);
        return WhatIf { trigger, at, decisions: Vec::new(), flown: Some(flight.into_rehearsal()) };
    }
    let failsafes = &conditions.plane.failsafes;
    let after = failsafes.decides_after(trigger, flight.situation());
    let mut decisions: Vec<Decision> = Vec::new();
    for (index, after_s) in after.iter().enumerate() {
        if !flight.until(began_s + after_s) || !flight.is_in_the_air() {
            break;
        }
        let reaction = failsafes.decides(trigger, index + 1 == after.len(), flight.situation());
        flight.reacts(reaction);
        decisions.push(Decision { time_s: flight.time_s(), reaction });
    }
    let changes = decisions.iter().any(|decision| decision.reaction != Reaction::GoesOn);
    if changes {
        flight.until(f64::INFINITY);
    }
    WhatIf { trigger, at, decisions, flown: changes.then(|| flight.into_rehearsal()) }
}
