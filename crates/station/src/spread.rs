//! Many rehearsals at once, on all processors.

use std::sync::atomic::{AtomicUsize, Ordering};

use vencejo_flight::plan::Plan;
use vencejo_flight::rehearsal::{Conditions, Doubts, IsWanted, NotRehearsed, Rehearsal, Run, Spread, fly_once, gather};

/// How many flights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Runs {
    /// Flights.
    pub count: usize,
    /// Seed of the winds and planes; the same seed gives the same result.
    pub seed: u64,
    /// Processors left for other work.
    pub spared: usize,
}

/// Flies a plan `runs` times besides the expected flight, in winds and with planes that vary around the expected ones.
///
/// # Errors
/// [`NotRehearsed`].
pub fn rehearse_many(
    plan: &Plan,
    conditions: &Conditions<'_>,
    doubts: &Doubts,
    expected: Rehearsal,
    runs: &Runs,
) -> Result<Spread, NotRehearsed> {
    let flown = on_processors(runs, conditions.is_wanted, |run| {
        fly_once(plan, conditions, doubts, &expected, runs.seed.wrapping_add(run as u64))
    });
    if flown.len() == runs.count { Ok(gather(expected, &flown)) } else { Err(NotRehearsed::NotWanted) }
}

/// Maps each number below the count, in parallel; results are in the order of the numbers.
fn on_processors(
    &Runs { count, spared, .. }: &Runs,
    is_wanted: IsWanted<'_>,
    one: impl Fn(usize) -> Option<Run> + Sync,
) -> Vec<Run> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count || !is_wanted() {
                return done;
            }
            done.extend(one(number).map(|run| (number, run)));
        }
    };
    let processors =
        std::thread::available_parallelism().map_or(1, std::num::NonZero::get).saturating_sub(spared).max(1);
    let mut done = std::thread::scope(|scope| {
        let others: Vec<_> = (1..processors.min(count)).map(|_| scope.spawn(work)).collect();
        let mut done = work();
        for other in others {
            done.extend(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        done
    });
    done.sort_by_key(|(number, _)| *number);
    done.into_iter().map(|(_, run)| run).collect()
}

#[cfg(test)]
mod tests {
    use vencejo_flight::plan::{Home, Mission, MissionItem};
    use vencejo_flight::rehearsal::{Air, Aircraft, rehearse};

    use super::*;

    #[test]
    fn a_question_that_is_taken_back_is_not_flown_to_its_end() {
        let home = Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 };
        let items = vec![MissionItem::takeoff(40.0, -3.0, 40.0, 12.0), MissionItem::waypoint(40.01, -3.0, 60.0)];
        let plan = Plan::from_mission(Mission { home: Some(home), items });
        let plane = Aircraft::default();
        let conditions = Conditions::new(&plane, Air::default());
        let expected = rehearse(&plan, &conditions).unwrap();
        let asked = AtomicUsize::new(0);
        let all = |most: usize| {
            asked.store(0, Ordering::Relaxed);
            let is_wanted = || asked.fetch_add(1, Ordering::Relaxed) < most;
            let conditions = Conditions { is_wanted: &is_wanted, ..conditions };
            let runs = Runs { count: 6, seed: 3, spared: 0 };
            rehearse_many(&plan, &conditions, &Doubts::default(), expected.clone(), &runs)
        };
        assert_eq!(all(3), Err(NotRehearsed::NotWanted));
        assert!(asked.load(Ordering::Relaxed) < 100, "a flight asks thousands of times");
        let spread = all(usize::MAX).unwrap();
        assert_eq!((spread.runs, Ok(spread)), (6, all(usize::MAX)));
    }
}
