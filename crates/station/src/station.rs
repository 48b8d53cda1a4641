//! The station itself: it owns the links, the vehicles' state machines, the clock that drives them, and their end.
//!
//! A frame is handled where it is read: the link's task decodes it, feeds the vehicle's state machine, and sends its
//! output, without a hop to another task. One more task, the driver, advances time and sends our heartbeat.
//!
//! | part | what it does |
//! |---|---|
//! | `shared` | what the handles share, and the lock |
//! | `starting` | how it begins |
//! | `hearing` | frames as they are received |
//! | `settling` | outputs of the state machines, and requests to them |
//! | `driving` | what happens by the clock |

mod driving;
mod hearing;
mod settling;
mod shared;
mod starting;

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use tokio::sync::watch;
use vencejo_link::{LinkAddress, LinkId, LinkInfo, LinkOptions, LinkStats, Recorder, RecorderStatus};
use vencejo_proto::MonoTime;
use vencejo_store::Space;
use vencejo_vehicle::{Vehicle, VehicleId};

pub(crate) use self::shared::Shared;
use self::shared::{Owned, Waiting, is_heard};
pub use self::shared::{RequestResult, Station, VehicleHandle};
use crate::control::{Control, Operator};
use crate::error::{StationError, Wanted};
use crate::pending::Pending;
use crate::queue::DropOldest;
use crate::records::Records;
use crate::subscriptions::Received;

impl Station {
    /// Opens a link. It connects, and reconnects, by itself.
    ///
    /// # Errors
    /// [`StationError::Address`] for a link string that cannot be read, [`StationError::Link`] when there are too many,
    /// [`StationError::Closed`].
    pub fn open_link(&self, address: &str, options: LinkOptions) -> Result<LinkId, StationError> {
        let address: LinkAddress = address.parse()?;
        let _guard = self.shared.runtime.enter();
        // Under the lock with which closing collects the links, so that none is left over.
        let mut owned = self.shared.owned();
        if self.is_closed() {
            return Err(StationError::Closed);
        }
        let handle = self.shared.hub.open(address, options)?;
        let id = handle.id();
        owned.links.push(handle);
        Ok(id)
    }

    /// Closes a link and waits for its tasks to end.
    ///
    /// # Errors
    /// [`StationError::Link`] when there is no such link.
    pub async fn close_link(&self, id: LinkId) -> Result<(), StationError> {
        let handle = {
            let mut owned = self.shared.owned();
            let place = owned.links.iter().position(|link| link.id() == id);
            place.map(|place| owned.links.swap_remove(place))
        };
        let handle = handle.ok_or(StationError::Link(vencejo_link::LinkError::UnknownLink(id)))?;
        handle.close().await;
        Ok(())
    }

    /// The open links, in the order they were opened, and what was counted on each.
    pub fn links(&self) -> Vec<(LinkInfo, LinkStats)> {
        let links = self.shared.hub.links();
        links.into_iter().filter_map(|link| Some((link.clone(), self.shared.hub.stats(link.id).ok()?))).collect()
    }

    /// The open links and their states, in words for an error message.
    pub fn describe_links(&self) -> String {
        self.shared.describe_links()
    }

    /// The address of a link's own socket while it is up: tells the port of a link that was opened with port 0.
    pub fn local_address(&self, id: LinkId) -> Option<SocketAddr> {
        self.shared.owned().links.iter().find(|link| link.id() == id)?.local_address()
    }

    /// The disk's free space, and how much of it stays free of what.
    pub fn space(&self) -> &Space {
        &self.shared.config.space
    }

    /// The recording's folder and state; `None` when nothing is recorded.
    pub fn recorder(&self) -> Option<(PathBuf, RecorderStatus)> {
        let dir = self.shared.config.record_dir.clone()?;
        Some((dir, self.shared.owned().recorder.as_ref().map(Recorder::status)?))
    }

    /// Changes each time that the recording stops, resumes, or stops for another reason; noticed within a second,
    /// whatever the disk does. `None` when nothing is recorded.
    pub fn recorder_changes(&self) -> watch::Receiver<Option<RecorderStatus>> {
        self.shared.health.subscribe()
    }

    /// Why the knowledge of the missions on board cannot be stored.
    pub fn missions_fault(&self) -> Option<String> {
        self.shared.records().as_ref().and_then(Records::fault)
    }

    /// Starts or stops our heartbeat.
    pub fn set_heartbeat(&self, enabled: bool) {
        self.shared.heartbeat.store(enabled, Ordering::Relaxed);
        self.shared.wake_driver.notify_one();
    }

    /// The link on which another station with our own MAVLink address is heard, and its place in words.
    pub fn namesake(&self) -> Option<(LinkId, String)> {
        let origin = self.shared.core().namesake.heard(self.shared.clock.now())?;
        Some((origin.link, self.shared.hub.describe(origin)))
    }

    /// The present moment on the station's clock.
    pub fn now(&self) -> MonoTime {
        self.shared.clock.now()
    }

    /// Who may act on its vehicles.
    pub fn control(&self) -> &Control {
        &self.shared.control
    }

    /// The operator of the program that started the station: the one that a plain vehicle handle acts for.
    pub fn operator(&self) -> &Arc<Operator> {
        &self.shared.operator
    }

    /// Another operator; it is present while it acts or is attached.
    pub fn enlist(&self, name: &str) -> Operator {
        self.shared.control.enlist(name, self.now())
    }

    /// The vehicles heard so far, without those of recordings that are only looked at
    /// ([`ReplayOptions::stands_in`](crate::ReplayOptions::stands_in)).
    pub fn vehicles(&self) -> Vec<VehicleHandle> {
        let core = self.shared.core();
        core.vehicles.iter().filter(|(id, _)| !core.is_aside(*id)).map(|(id, _)| self.handle(id)).collect()
    }

    /// All vehicles, also those of recordings that are only looked at.
    pub fn shown_vehicles(&self) -> Vec<VehicleHandle> {
        self.shared.core().vehicles.iter().map(|(id, _)| self.handle(id)).collect()
    }

    /// A vehicle by its id, if it was heard.
    pub fn vehicle(&self, id: impl Into<VehicleId>) -> Option<VehicleHandle> {
        let id = id.into();
        self.shared.core().vehicles.get(id).is_some().then(|| self.handle(id))
    }

    /// The messages of all vehicles from now on, also of those that are not heard yet, in the order in which they come:
    /// all or some ids, at most `capacity` waiting. One such queue costs a fraction of a queue for each of many
    /// vehicles.
    pub fn subscribe_messages(&self, ids: Option<BTreeSet<u32>>, capacity: usize) -> Arc<DropOldest<Received>> {
        // Under the lock: closing ends what it finds there.
        let core = self.shared.core();
        if self.is_closed() { DropOldest::ended() } else { core.subscriptions.subscribe(ids, capacity) }
    }

    /// Waits for a vehicle, the first of [`Self::vehicles`] that is heard when none is named. Cancelling it ends it with
    /// [`StationError::NoVehicle`].
    pub fn wait_vehicle(&self, wanted: Option<VehicleId>) -> Pending<Result<VehicleHandle, StationError>> {
        self.wait_for(wanted.map_or(Wanted::First, Wanted::Id))
    }

    /// The same for the first vehicle of this name: one far away.
    pub fn wait_named(&self, name: &str) -> Pending<Result<VehicleHandle, StationError>> {
        self.wait_for(Wanted::Named(name.to_owned()))
    }

    fn wait_for(&self, wanted: Wanted) -> Pending<Result<VehicleHandle, StationError>> {
        let mut core = self.shared.core();
        let is_it = |(id, vehicle): &(VehicleId, &Vehicle)| {
            is_heard(vehicle) && wanted.is(*id, core.is_aside(*id), core.name_of(*id))
        };
        if let Some((system, _)) = core.vehicles.iter().find(is_it) {
            return Pending::ended(Ok(self.handle(system)));
        }
        if self.is_closed() {
            return Pending::ended(Err(StationError::Closed));
        }
        core.waiting.retain(|waiting| !waiting.finisher.is_abandoned());
        let key = core.next_waiting;
        core.next_waiting += 1;
        let shared = Arc::downgrade(&self.shared);
        let (finisher, pending) = Pending::new(move || {
            let Some(shared) = shared.upgrade() else { return };
            let waiting = {
                let mut core = shared.core();
                let place = core.waiting.iter().position(|waiting| waiting.key == key);
                place.map(|place| core.waiting.swap_remove(place))
            };
            if let Some(waiting) = waiting {
                let error = shared.no_vehicle(&waiting);
                waiting.finisher.finish(Err(error));
            }
        });
        core.waiting.push(Waiting { key, wanted, since: self.shared.clock.now(), finisher });
        pending
    }

    /// Shuts down: pending requests end with [`StationError::Closed`], links and recording are closed and joined.
    /// May be called again.
    pub async fn close(&self) {
        self.shared.end_waits();
        let Owned { links, recorder, driver, keeper } = std::mem::take(&mut *self.shared.owned());
        if let Some(driver) = driver {
            // The driver ends by itself; a join error would be its panic, which has been reported already.
            let _ = driver.await;
        }
        self.end_replays().await;
        for link in links {
            link.close().await;
        }
        if let Some(keeper) = keeper {
            // As with the driver.
            let _ = keeper.await;
            let kept = self.shared.blocking(|vault, hub| {
                vault.write_times(hub, true);
                vault.follow(hub)
            });
            if let Err(error) = kept.await {
                tracing::error!(%error, "signing keys are not on disk");
            }
        }
        self.shared.hub.set_recorder(None);
        let records = self.shared.records().take();
        if let Some(records) = records {
            // It writes what waits, and waits for the disk.
            let closed = self.shared.runtime.spawn_blocking(move || records.close()).await;
            if let Err(error) = closed {
                tracing::error!(%error, "what is known of missions was not written to the end");
            }
        }
        if let Some(recorder) = recorder {
            // It waits for the disk, which the runtime's threads must not.
            let closed = self.shared.runtime.spawn_blocking(move || recorder.close()).await;
            match closed {
                Ok(status) => drop(self.shared.health.send_replace(Some(status))),
                Err(error) => tracing::error!(%error, "the recorder did not end in order"),
            }
        }
    }

    /// Whether [`Self::close`] was called.
    pub fn is_closed(&self) -> bool {
        *self.shared.closing.borrow()
    }
}

#[cfg(test)]
mod tests;
