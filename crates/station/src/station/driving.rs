//! What happens by the clock: time that passes for the vehicles, our heartbeat, the look at the recorder, keys and their times on disk.

use std::sync::Weak;
use std::sync::atomic::Ordering;
use std::time::Duration;

use tokio::sync::watch;
use vencejo_link::{LinkId, Recorder, RecorderStatus, Route};
use vencejo_proto::{Address, Heartbeat, MavVersion, Message, MonoTime, SystemId};
use vencejo_vehicle::Vehicle;

use super::shared::{Core, Shared};

/// How often our heartbeat goes out, and the driver looks round at the latest (mavlink.io, "Heartbeat protocol").
const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(1);

/// Every so many heartbeats a vehicle that speaks MAVLink 1 is shown that we speak MAVLink 2. An old one skips a frame of 21
/// bytes.
const INVITE_EVERY: u32 = 5;

/// How often it is looked whether keys changed, here or on disk.
const LOOK: Duration = Duration::from_secs(1);

/// How often the keys' times are written: half of what is reserved.
const WRITE_TIMES: Duration = Duration::from_secs(30);

impl Shared {
    /// Tells when the recording stops or goes on. Only its thread waits for the disk, so this is looked at from here.
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

    /// Sends our heartbeat over a link that has just opened: a program that ends before the next beat was heard too.
    pub(super) fn on_link_open(&self, link: LinkId) {
        if self.heartbeat.load(Ordering::Relaxed) {
            self.send_heartbeat(&self.core(), Route::Link(link), true);
        }
    }

    /// Sends our heartbeat, in the oldest version that a vehicle speaks: everybody reads MAVLink 1.
    ///
    /// With `invites` in MAVLink 2 besides: PX4 and ArduPilots of some years speak MAVLink 1 until they hear MAVLink 2, and
    /// begin so again when they restart.
    fn send_heartbeat(&self, core: &Core, route: Route, invites: bool) {
        let speaks_v1 = core.watchers.values().any(|watchers| watchers.version == MavVersion::V1);
        let version = if speaks_v1 { MavVersion::V1 } else { MavVersion::V2 };
        let send = |version| {
            let heartbeat = Message::Heartbeat(Heartbeat::default());
            // Links without a peer refuse it; there is nobody to miss it.
            let _ = self.hub.send_message(&heartbeat, self.heartbeat_source(core), version, route);
        };
        send(version);
        if speaks_v1 && invites {
            send(MavVersion::V2);
        }
    }

    /// Whose heartbeat ours is. On board it is not the vehicle's: ArduPilot's failsafe looks at the system id alone, and counts that of its
    /// ground stations. The component stays ours, so that no other station takes it for a second one with its own address.
    fn heartbeat_source(&self, core: &Core) -> Address {
        let ours = self.config.address;
        if !ours.component.is_onboard_computer() {
            return ours;
        }
        let counted = core.vehicles.get(ours.system).and_then(Vehicle::counted_station);
        Address { system: counted.unwrap_or(SystemId::GROUND_STATION), ..ours }
    }
}

/// Lets time pass for the vehicles and sends our heartbeat: from the loop that does the work, so that it stops with it.
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

/// Without the driver no time-out passes: when it ends for whatever reason, nobody waits for ever.
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
