//! The task of a replay: it shows the film in its time.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Weak};
use std::time::Duration;

use tokio::sync::watch;
use vencejo_flight::plan::PlanKind;
use vencejo_proto::{Header, MavVersion, MonoTime};
use vencejo_vehicle::VehicleId;

use super::film::{Film, Moment};
use super::handle::{Replay, Shown};
use crate::station::Shared;

/// The recording's time is passed on at least this often, so that a silence is noticed.
const TICK: Duration = Duration::from_millis(500);
/// The pause between two rounds: a recording of one moment must not spin.
const REPEAT_PAUSE: Duration = Duration::from_millis(100);
/// Time on the clock of replayed vehicles before a recording begins: what was said before a place has a time, too.
const BEFORE: Duration = Duration::from_secs(24 * 3600);

/// A place on the clock of a replayed vehicle.
fn moment_at(place: Duration) -> MonoTime {
    MonoTime::from_origin(BEFORE + place)
}

/// The place of a moment of that clock.
pub(super) fn place_of(moment: MonoTime) -> Duration {
    moment.as_duration().saturating_sub(BEFORE)
}

/// Does something that may block with a film.
async fn with<T: Send + 'static>(
    mut film: Box<dyn Film>,
    work: impl FnOnce(&mut dyn Film) -> io::Result<T> + Send + 'static,
) -> Option<(Box<dyn Film>, io::Result<T>)> {
    let worked = tokio::task::spawn_blocking(move || {
        let done = work(&mut *film);
        (film, done)
    });
    worked.await.ok()
}

/// Shows a film until the station ends.
pub(super) async fn play(
    station: Weak<Shared>,
    replay: Replay,
    mut film: Box<dyn Film>,
    repeat: bool,
    mut woken: watch::Receiver<()>,
) {
    let (mut shown_seeks, mut shown_until) = (0, Duration::ZERO);
    let (mut queue, mut has_ended) = (VecDeque::<Moment>::new(), false);
    loop {
        // Changes from here on wake it.
        woken.borrow_and_update();
        let (seeks, place) = {
            let state = replay.state();
            (state.seeks, state.pace.place())
        };
        let done = if seeks != shown_seeks {
            let Some((same, past)) = with(film, move |film| film.seek(place)).await else { return };
            film = same;
            past.map(|past| {
                {
                    let mut state = replay.state();
                    if state.seeks != seeks {
                        return;
                    }
                    // What the seek took is not skipped. The limit may be one of the place that was left.
                    state.pace.seek(place);
                    state.limit = state.pace.place();
                    state.fault = None;
                    state.clock = None;
                    if let Some(unix_us) = replay.info().start_unix_us {
                        state.clock.get_or_insert_default().hear(Duration::ZERO, unix_us);
                    }
                    state.set_clock(&past);
                }
                (shown_seeks, shown_until) = (seeks, place);
                (queue, has_ended) = (VecDeque::new(), false);
                if let Some(station) = station.upgrade() {
                    station.begin_replay(&replay, &past, place);
                }
                replay.shared.done.send_replace(seeks);
            })
        } else if queue.is_empty() && !has_ended {
            let Some((same, more)) = with(film, |film| film.read()).await else { return };
            film = same;
            more.map(|more| {
                has_ended = more.is_empty();
                queue.extend(more);
            })
        } else {
            Ok(())
        };
        if let Err(error) = done {
            tracing::warn!(recording = %replay.path().display(), %error, "a replay cannot go on");
            replay.state().fault = Some(error.to_string());
            (shown_seeks, has_ended) = (seeks, true);
            queue.clear();
            replay.shared.done.send_replace(seeks);
        }
        let Some(next) = queue.front().map(|moment| moment.at) else {
            if has_ended {
                end(&station, &replay, seeks, repeat, &mut woken).await;
            }
            continue;
        };
        let target = next.min(shown_until + TICK);
        let due = {
            let mut state = replay.state();
            state.limit = next;
            state.pace.due(target)
        };
        match due {
            None => {
                // The sender is in the replay.
                let _ = woken.changed().await;
                continue;
            }
            Some(due) => tokio::select! {
                biased;
                Ok(()) = woken.changed() => continue,
                () = tokio::time::sleep_until(due) => {}
            },
        }
        // Without this a replay at a great speed would keep its thread to itself.
        tokio::task::consume_budget().await;
        let here = target.max(replay.state().pace.place());
        let count = queue.iter().take_while(|moment| moment.at <= here).count();
        let said: Vec<_> = queue.drain(..count).collect();
        // More may come before that place.
        shown_until = if queue.is_empty() { said.last().map_or(target, |moment| moment.at) } else { here };
        {
            let mut state = replay.state();
            if state.seeks != shown_seeks {
                continue;
            }
            state.set_clock(&said);
        }
        let Some(station) = station.upgrade() else { return };
        station.show_moments(&replay, &said, shown_until, false);
    }
}

/// The end of the film: it stays there until it is told to go elsewhere, or begins again.
async fn end(station: &Weak<Shared>, replay: &Replay, seeks: u64, repeat: bool, woken: &mut watch::Receiver<()>) {
    let place = {
        let mut state = replay.state();
        if state.seeks != seeks {
            return;
        }
        state.limit = replay.info().duration;
        state.pace.seek(replay.info().duration);
        state.is_over = !repeat || state.fault.is_some();
        state.limit
    };
    if let Some(station) = station.upgrade() {
        station.show_moments(replay, &[], place, false);
    }
    if repeat && replay.state().fault.is_none() {
        tokio::time::sleep(REPEAT_PAUSE).await;
        let mut state = replay.state();
        if state.seeks == seeks {
            state.seek(Duration::ZERO);
        }
        return;
    }
    while replay.state().seeks == seeks {
        // The sender is in the replay.
        let _ = woken.changed().await;
    }
}

impl Shared {
    /// Connects the vehicles of a replay with it, before anything is shown.
    pub(super) fn show_replay(&self, replay: &Replay) {
        let mut core = self.core();
        for id in replay.vehicles() {
            core.vehicles.begin_replay(id, moment_at(Duration::ZERO));
            if let Some(adopted) = core.adopted.get_mut(&id) {
                let now = moment_at(Duration::ZERO);
                adopted.shown = Some(Shown { replay: replay.clone(), now, is_past: true, plans: 0 });
            }
        }
    }

    /// Begins the vehicles of a replay anew at a place, with what was known there.
    fn begin_replay(self: &Arc<Self>, replay: &Replay, past: &[Moment], place: Duration) {
        {
            let mut core = self.core();
            for (address, id) in &replay.shared.vehicles {
                let first = past.iter().find(|moment| moment.from == *address).map_or(place, |moment| moment.at);
                core.vehicles.begin_replay(*id, moment_at(first));
                if let Some(shown) = core.adopted.get_mut(id).and_then(|adopted| adopted.shown.as_mut()) {
                    shown.plans = 0;
                }
            }
        }
        self.show_moments(replay, past, place, true);
    }

    /// Shows what was said until a place; `is_past` where that is what was known at the beginning of it.
    fn show_moments(self: &Arc<Self>, replay: &Replay, said: &[Moment], place: Duration, is_past: bool) {
        let now = self.clock.now();
        let mut core = self.core();
        for moment in said {
            let Some((address, id)) = replay.shared.vehicles.iter().find(|(address, _)| *address == moment.from) else {
                continue;
            };
            core.vehicles.on_hosted(*id, &moment.message, moment_at(moment.at));
            if let Some(watchers) = core.watchers.get(id)
                && watchers.subscriptions.has_readers()
            {
                let header = Header { sequence: 0, source: *address, version: MavVersion::V2 };
                watchers.subscriptions.on_message(None, &moment.message.encode(header), now);
            }
        }
        for (address, id) in &replay.shared.vehicles {
            let core = &mut *core;
            core.vehicles.on_replay_time(*id, moment_at(place));
            if let Some(shown) = core.adopted.get_mut(id).and_then(|adopted| adopted.shown.as_mut()) {
                (shown.now, shown.is_past) = (moment_at(place), is_past);
                let known = replay.info().plans.partition_point(|(at, _)| *at <= place);
                let new = replay.info().plans.get(shown.plans..known).unwrap_or_default();
                shown.plans = known;
                // A seek may pass many, of which the last ones are on board.
                for kind in PlanKind::ALL {
                    let newest = new.iter().rev().find(|(_, plan)| plan.autopilot == *address && plan.kind == kind);
                    if let (Some((_, plan)), Some(vehicle)) = (newest, core.vehicles.get_mut(*id)) {
                        vehicle.on_plan_told(kind, plan.state, Some(plan.list.clone()));
                    }
                }
            }
            if let Some(watchers) = core.watchers.get(id) {
                watchers.changes.notify();
            }
            self.greet(core, *id);
        }
        self.settle(&mut core, now);
    }

    /// Forgets vehicles of a replay.
    pub(super) fn dismiss(self: &Arc<Self>, ids: impl Iterator<Item = VehicleId>) {
        let now = self.clock.now();
        let mut core = self.core();
        ids.for_each(|id| core.vehicles.dismiss(id));
        self.settle(&mut core, now);
    }
}
