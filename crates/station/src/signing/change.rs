//! A station's use of its keys: listing and storing them, giving one to a vehicle, and taking it away.

use std::time::Duration;

use vencejo_link::{KeyId, Origin, Route};
use vencejo_proto::{MavVersion, MonoTime, SigningKey, SystemId};
use vencejo_vehicle::Reply;
use vencejo_vehicle::signing::{KeyChange, KeyEnd, KeyGoal, KeyStep, Shown, setup_message};
use vencejo_vehicle::telemetry::STALE_AFTER;

use crate::error::StationError;
use crate::pending::Pending;
use crate::station::{RequestResult, Station, VehicleHandle};

use super::{
    KeyInfo, MAX_CANDIDATES, SigningChange, SigningError, SigningInfo, StoredKey, StoredVehicle, Vault, random_key,
    to_hex,
};

/// How often a change under way checks what the vehicle shows.
const WATCH: Duration = Duration::from_millis(50);
/// A vehicle that signed within this time has not stopped signing.
const STILL_SIGNS: Duration = Duration::from_secs(1);
impl Station {
    fn vault(&self) -> Result<&Vault, SigningError> {
        self.shared.vault()
    }

    /// Why nothing is signed and nothing is checked, when the keys could not be read.
    pub fn signing_fault(&self) -> Option<String> {
        self.shared.vault_fault.as_ref().map(ToString::to_string)
    }

    /// Why the times of the signing keys are not on disk. The keys stay in use; after a restart, frames sent since
    /// could be replayed.
    pub fn signing_times_fault(&self) -> Option<String> {
        self.shared.vault.as_ref().and_then(Vault::times_fault)
    }

    /// The signing keys of this machine. Reads what is in memory.
    ///
    /// # Errors
    /// [`SigningError::NoFolder`].
    pub fn signing_keys(&self) -> Result<Vec<KeyInfo>, StationError> {
        let state = self.vault()?.state();
        let info = |key: &StoredKey| {
            let has =
                |(system, vehicle): (&u8, &StoredVehicle)| vehicle.keys.contains(&key.id).then_some(SystemId(*system));
            let vehicles = state.book.vehicles.iter().filter_map(has).collect();
            KeyInfo { name: key.name.clone(), made_unix_s: key.made_unix_s, vehicles }
        };
        Ok(state.book.keys.iter().map(info).collect())
    }

    /// Keeps a key under a name: this one, or a new random one. Blocks while it is written.
    ///
    /// # Errors
    /// [`StationError::Signing`].
    pub fn add_signing_key(&self, name: &str, key: Option<SigningKey>) -> Result<(), StationError> {
        let unix_us = self.shared.clock.unix_us();
        let key = key.map_or_else(random_key, Ok)?;
        self.vault()?.change(self.shared.hub(), |book| book.add(name, key, unix_us).map(drop))?;
        Ok(())
    }

    /// A key with its secret, to carry it to another ground station. Reads what is in memory.
    ///
    /// # Errors
    /// [`StationError::Signing`].
    pub fn export_signing_key(&self, name: &str) -> Result<String, StationError> {
        Ok(to_hex(&self.vault()?.state().book.named(name)?.key))
    }

    /// Deletes a key that no vehicle has. Blocks while it is written.
    ///
    /// # Errors
    /// [`StationError::Signing`].
    pub fn forget_signing_key(&self, name: &str) -> Result<(), StationError> {
        self.vault()?.change(self.shared.hub(), |book| {
            let id = book.named(name)?.id;
            if book.vehicles.values().any(|vehicle| vehicle.keys.contains(&id)) {
                return Err(SigningError::KeyInUse { name: name.to_owned() });
            }
            book.keys.retain(|key| key.id != id);
            Ok(())
        })?;
        Ok(())
    }

    /// Records that a vehicle has a key already, given by another ground station, or with `None` that it has no key:
    /// nothing is sent. Blocks while it is written.
    ///
    /// # Errors
    /// [`StationError::Signing`].
    pub fn use_signing_key(&self, system: SystemId, name: Option<&str>) -> Result<(), StationError> {
        self.vault()?.change(self.shared.hub(), |book| {
            match name {
                None => drop(book.vehicles.remove(&system.0)),
                Some(name) => {
                    let id = book.named(name)?.id;
                    *book.vehicle(system) = StoredVehicle { keys: vec![id], signs_with: Some(id), must_sign: true };
                }
            }
            Ok(())
        })?;
        Ok(())
    }

    /// How a vehicle signs, heard or not.
    pub fn signing_of(&self, system: SystemId) -> SigningInfo {
        let Some(state) = self.shared.hub().signing(system) else { return SigningInfo::default() };
        let name_of = |id: KeyId| self.shared.vault.as_ref()?.state().book.name_of(id);
        let now = self.now();
        let key = state.keys.signs_with;
        SigningInfo {
            must_sign: state.keys.must_sign,
            key: key.and_then(name_of),
            key_missing: state.keys.must_sign && key.and_then(name_of).is_none(),
            unproven: state.keys.keys.iter().filter(|id| Some(**id) != key).filter_map(|id| name_of(*id)).collect(),
            counts: state.counts,
            verified_age: state.shown.map(|(_, at)| now.since(at)),
            refused_age: state.refused_at.map(|at| now.since(at)),
        }
    }

    /// The vehicles that have keys, heard or not.
    pub fn signing_vehicles(&self) -> Vec<SystemId> {
        let mut vehicles: Vec<_> = self.shared.hub().signing_vehicles().into_iter().map(|(system, _)| system).collect();
        vehicles.sort_unstable();
        vehicles
    }
}

impl VehicleHandle {
    /// How it signs.
    pub fn signing(&self) -> SigningInfo {
        self.system().map(|system| self.station().signing_of(system)).unwrap_or_default()
    }

    /// Gives the vehicle a key or another one, or takes its key away, and waits until it shows the change. Only while
    /// it is known to be disarmed, and only over a private link, unless `any_link` allows others. It ends within 5 s,
    /// and completes even when the caller stops waiting.
    pub fn change_signing(&self, change: SigningChange, any_link: bool) -> Pending<RequestResult> {
        let admitted = self.station().shared.core().admit(self.id());
        if let Err(error) = admitted.and_then(|()| self.take_control()) {
            return Pending::ended(Err(error));
        }
        // Not cancelled: it ends soon by itself, and a half-done change would be worse.
        let (finisher, pending) = Pending::new(|| {});
        let vehicle = self.clone();
        self.station().shared.runtime().spawn(async move {
            let result = change_key(&vehicle, change, any_link).await;
            finisher.finish(result.map(|()| Reply::Done));
        });
        pending
    }
}

/// Releases a vehicle for the next change, however this one ends.
struct Busy<'a>(&'a Vault, SystemId);

impl Drop for Busy<'_> {
    fn drop(&mut self) {
        self.0.state().busy.retain(|system| *system != self.1);
    }
}

async fn change_key(vehicle: &VehicleHandle, change: SigningChange, any_link: bool) -> Result<(), StationError> {
    let (station, goal) = (vehicle.station(), change.goal());
    let shared = &station.shared;
    let Some(system) = vehicle.system() else {
        let name = vehicle.remote_name().unwrap_or_default();
        let why = "its signing is changed at a direct link".to_owned();
        return Err(StationError::RemoteRefused { name, why });
    };
    let vault = station.vault()?;
    {
        let mut state = vault.state();
        if state.busy.contains(&system) {
            return Err(SigningError::Busy.into());
        }
        state.busy.push(system);
    }
    let _busy = Busy(vault, system);
    let signs = shared.hub().signing(system).is_some_and(|state| state.keys.must_sign);
    if signs == matches!(change, SigningChange::SetUp { .. }) {
        return Err(SigningError::WrongState { signs }.into());
    }
    let (telemetry, now) = vehicle.telemetry();
    let fresh = telemetry.heartbeat.filter(|heartbeat| now.since(heartbeat.at) < STALE_AFTER);
    let armed = fresh.map(|heartbeat| heartbeat.value.is_armed);
    let (Some(false), Some(target)) = (armed, vehicle.address()) else {
        return Err(SigningError::NotDisarmed { armed }.into());
    };
    // Where the vehicle itself was heard, not where its system id was used: another one there would take the key.
    let links = shared.hub().links();
    let find = |origin: Origin| Some((origin, links.iter().find(|link| link.id == origin.link)?));
    let ways: Vec<_> = shared.core().origins_of(vehicle.id(), now).into_iter().filter_map(find).collect();
    let private = ways.iter().find(|(_, link)| link.accepts_unsigned);
    let Some((way, _)) = private.or(ways.first().filter(|_| any_link)) else {
        let link = ways.first().map_or_else(|| "no link".to_owned(), |(_, link)| link.address.to_string());
        return Err(SigningError::NotPrivate { link }.into());
    };

    // Stored before it is sent: a key that only the vehicle has would lock us out.
    let unix_us = shared.clock.unix_us();
    let named = match &change {
        SigningChange::SetUp { key } | SigningChange::Rotate { key } => key.clone(),
        SigningChange::Remove => None,
    };
    let new = match goal {
        KeyGoal::NoKey => None,
        KeyGoal::NewKey => Some(
            shared
                .blocking(move |vault, hub| {
                    vault.change(hub, |book| {
                        let id = match &named {
                            Some(name) => KeyId(book.named(name)?.id),
                            None => book.make_for(system, unix_us)?,
                        };
                        let vehicle = book.vehicle(system);
                        let present = vehicle.signs_with;
                        vehicle.keys.retain(|known| *known != id.0);
                        let surplus = (vehicle.keys.len() + 1).saturating_sub(MAX_CANDIDATES);
                        let old: Vec<u32> = vehicle
                            .keys
                            .iter()
                            .copied()
                            .filter(|known| Some(*known) != present)
                            .take(surplus)
                            .collect();
                        vehicle.keys.retain(|known| !old.contains(known));
                        vehicle.keys.push(id.0);
                        let key = book.keys.iter().find(|key| key.id == id.0).map(|key| key.key.clone());
                        Ok((id, key.expect("invariant: it was found or made above")))
                    })
                })
                .await?,
        ),
    };
    let began = station.now();
    let end = send_until_shown(vehicle, system, goal, new.as_ref(), *way, target, began).await;
    match end {
        KeyEnd::Proven => {}
        KeyEnd::Refused(text) => return Err(SigningError::Refused { text }.into()),
        KeyEnd::Unproven => return Err(SigningError::Unproven.into()),
    }
    tracing::info!(vehicle = %system, signs = new.is_some(), "the vehicle's signing was changed");
    let new = new.map(|(id, _)| id.0);
    let kept = shared.blocking(move |vault, hub| {
        vault.change(hub, |book| {
            match new {
                Some(id) => {
                    *book.vehicle(system) = StoredVehicle { keys: vec![id], signs_with: Some(id), must_sign: true };
                }
                None => drop(book.vehicles.remove(&system.0)),
            }
            Ok(())
        })?;
        vault.write_times(hub, false);
        Ok(())
    });
    kept.await
}

async fn send_until_shown(
    vehicle: &VehicleHandle,
    system: SystemId,
    goal: KeyGoal,
    new: Option<&(KeyId, SigningKey)>,
    way: Origin,
    target: vencejo_proto::Address,
    began: MonoTime,
) -> KeyEnd {
    let shared = &vehicle.station().shared;
    let mut change = KeyChange::new(goal, began);
    loop {
        let now = vehicle.station().now();
        if let Some(state) = shared.hub().signing(system) {
            let signs_still = state.shown.is_some_and(|(_, at)| now.since(at) < STILL_SIGNS);
            change.on_shown(Shown {
                new_key: new.is_some_and(|(id, _)| state.shown.is_some_and(|(key, at)| key == *id && at >= began)),
                unsigned_run: if signs_still { 0 } else { state.unsigned_run },
            });
        }
        for text in vehicle.texts().iter().filter(|text| text.at >= began) {
            change.on_text(&text.text);
        }
        match change.step(now) {
            KeyStep::Send => {
                let key = new.and_then(|(id, key)| Some((key, shared.hub().next_signing_time(*id)?)));
                if new.is_some() && key.is_none() {
                    return KeyEnd::Unproven;
                }
                let message = setup_message(target, key);
                let report =
                    shared.hub().send_message(&message, shared.our_address(), MavVersion::V2, Route::Peer(way));
                if !report.is_sent() {
                    tracing::warn!(vehicle = %system, "the signing key did not leave: the link is not open");
                }
            }
            KeyStep::Wait(until) => tokio::time::sleep(until.since(now).min(WATCH)).await,
            KeyStep::Ended(end) => return end,
        }
    }
}
