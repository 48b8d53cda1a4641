//! Periodic work: the vehicles' deadlines, our heartbeat, the recorder's state, keys and their times on disk.

use std::sync::Weak;
use std::sync::atomic::Ordering;
use std::time::Duration;

use tokio::sync::watch;
use vencejo_link::{LinkId, Recorder, RecorderStatus, Route};
use vencejo_proto::{Address, Heartbeat, MavVersion, Message, MonoTime, SystemId};
use vencejo_vehicle::Vehicle;

use super::shared::{Core, Shared};

/// Interval of our heartbeat, and longest sleep of the driver (mavlink.io, "Heartbeat protocol").
const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(1);

/// Number of heartbeats after which one is also sent in MAVLink 2 to vehicles that speak MAVLink 1. An old vehicle
/// skips its 21 bytes.
const INVITE_EVERY: u32 = 5;

/// How often changes of keys, here and on disk, are looked for.
const LOOK: Duration = Duration::from_secs(1);

/// How often the keys' times are written: half of the reserved time.
const WRITE_TIMES: Duration = Duration::from_secs(30);

impl Shared {
    /// Reports when the recording stops or resumes. Only its thread waits for the disk, so its state is polled from
    /// here.
    fn look_at_recorder(&self) {
        let Some(status) = self.owned().recorder.as_ref().map(Recorder::status) else { return };
        self.health.send_if_modified(|known| {
            let of = |status: &RecorderStatus| (std::mem::discriminant(&status.state), status.since);
            let is_other = known.as_ref().map(of) != Some(of(&status));
            if is_other {
                match status.state.problem() {
                    Some(problem) => tracing::error!(problem, "telemetry is not being recorded"),
                    None => tracing::info!("telemetry is being recorded"),
                }
                *known = Some(status);
            }
            is_other
        });
    }

    /// Sends our heartbeat over a link that has just opened, so that a short-lived program is heard too.
    pub(super) fn on_link_open(&self, link: LinkId) {
        if self.heartbeat.load(Ordering::Relaxed) {
            self.send_heartbeat(&self.core(), Route::Link(link), true);
        }
    }

    /// Sends our heartbeat in the oldest version that a vehicle speaks: every receiver reads MAVLink 1.
    ///
    /// With `invites` in MAVLink 2 besides: PX4 and ArduPilots of some years speak MAVLink 1 until they hear MAVLink 2,
    /// and begin so again when they restart.
    fn send_heartbeat(&self, core: &Core, route: Route, invites: bool) {
        let speaks_v1 = core.watchers.values().any(|watchers| watchers.version == MavVersion::V1);
        let version = if speaks_v1 { MavVersion::V1 } else { MavVersion::V2 };
        let send = |version| {
            let heartbeat = Message::Heartbeat(Heartbeat::default());
            // Links without a peer refuse it, which is no loss.
            let _ = self.hub.send_message(&heartbeat, self.heartbeat_source(core), version, route);
        };
        send(version);
        if speaks_v1 && invites {
            send(MavVersion::V2);
        }
    }

    /// The source of our heartbeat. On board it is not the vehicle's system id: ArduPilot's failsafe looks at the
    /// system id alone, and counts that of its ground stations. The component stays ours, so that no other station
    /// takes it for a second one with its own address.
    fn heartbeat_source(&self, core: &Core) -> Address {
        let ours = self.config.address;
        if !ours.component.is_onboard_computer() {
            return ours;
        }
        let counted = core.vehicles.get(ours.system).and_then(Vehicle::counted_station);
        Address { system: counted.unwrap_or(SystemId::GROUND_STATION), ..ours }
    }
}

/// Advances the vehicles' time and sends our heartbeat. Both are in one loop, so that the heartbeat stops when the work
/// does.
pub(super) async fn drive(shared: Weak<Shared>, mut closing: watch::Receiver<bool>) {
    let _guard = DriverGuard(shared.clone());
    let mut heartbeat_due = MonoTime::ZERO;
    let mut heartbeats = 0_u32;
    loop {
        let Some(strong) = shared.upgrade() else { return };
        let now = strong.clock.now();
        strong.look_at_recorder();
        strong.control.expire(now);
        let rest = {
            let mut core = strong.core();
            core.vehicles.on_time(now);
            strong.settle(&mut core, now);
            for (system, watchers) in &mut core.watchers {
                strong.tell_contest(watchers, *system, now);
            }
            if now >= heartbeat_due {
                if strong.heartbeat.load(Ordering::Relaxed) {
                    strong.send_heartbeat(&core, Route::All, heartbeats.is_multiple_of(INVITE_EVERY));
                    heartbeats = heartbeats.wrapping_add(1);
                }
                heartbeat_due = now + HEARTBEAT_INTERVAL;
            }
            let alarm = core.vehicles.deadline().map_or(heartbeat_due, |deadline| deadline.min(heartbeat_due));
            strong.driver_alarm_us.store(alarm.as_micros(), Ordering::Relaxed);
            alarm.since(now)
        };
        let woken = async {
            tokio::select! {
                () = tokio::time::sleep(rest) => {}
                () = strong.wake_driver.notified() => {}
            }
        };
        tokio::select! {
            () = woken => {}
            // An error means that the station is gone, which is an end as well.
            _ = closing.wait_for(|closing| *closing) => return,
        }
    }
}

/// Keeps keys and times in step with the disk, until the station ends.
pub(super) async fn keep_keys(shared: Weak<Shared>, mut closing: watch::Receiver<bool>) {
    let mut looked = 0;
    loop {
        tokio::select! {
            () = tokio::time::sleep(LOOK) => {}
            // An error means that the station is gone, which is an end as well.
            _ = closing.wait_for(|closing| *closing) => return,
        }
        looked += 1;
        let write_times = looked % (WRITE_TIMES.as_secs() / LOOK.as_secs()) == 0;
        let Some(strong) = shared.upgrade() else { return };
        let kept = strong.blocking(move |vault, hub| {
            if write_times {
                vault.write_times(hub, false);
            }
            vault.follow(hub)?;
            vault.look(hub)
        });
        if let Err(error) = kept.await {
            tracing::error!(%error, "signing keys are not on disk");
        }
    }
}

/// Closes the station when the driver ends for any reason: without it no time-out would ever pass.
struct DriverGuard(Weak<Shared>);

impl Drop for DriverGuard {
    fn drop(&mut self) {
        if let Some(shared) = self.0.upgrade() {
            if std::thread::panicking() {
                tracing::error!("the station's driver panicked; the station is closed");
            }
            shared.end_waits();
        }
    }
}
