//! Signing keys: kept on disk, given to vehicles, changed without cutting anybody off, and their time over restarts.
//!
//! The folder holds `keys.json` (the keys and which vehicle has which) and `times.json` (for each key the time that nothing
//! was signed or accepted after). Both belong to their owner alone. Several programs may share the folder: each change is made
//! under a lock on what is there, and the others see it within seconds.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};
use thiserror::Error;
use tokio::sync::watch;
use vencejo_link::{Hub, KeyId, Route, SigningCounts, VehicleKeys};
use vencejo_proto::{MavVersion, MonoTime, SigningKey, SigningTime, SystemId};
use vencejo_store::{Access, Lock};
use vencejo_vehicle::Reply;
use vencejo_vehicle::signing::{KeyChange, KeyEnd, KeyGoal, KeyStep, Shown, setup_message};
use vencejo_vehicle::telemetry::STALE_AFTER;

use crate::error::StationError;
use crate::pending::Pending;
use crate::station::{RequestResult, Shared, Station};
use crate::vehicle::VehicleHandle;

/// How often it is looked whether keys changed, here or on disk.
const LOOK: Duration = Duration::from_secs(1);
/// How often the keys' times are written: half of what is reserved.
const WRITE_TIMES: Duration = Duration::from_secs(30);
/// How often a change that is under way looks at what the vehicle shows.
const WATCH: Duration = Duration::from_millis(50);
/// A vehicle that signed so lately has not stopped.
const STILL_SIGNS: Duration = Duration::from_secs(1);
/// Keys that may wait for a vehicle to show them.
const MAX_CANDIDATES: usize = 3;
/// Characters of a key's name.
const MAX_NAME: usize = 40;

/// Why a key could not be made, kept, given or taken away.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SigningError {
    /// The station was started without a folder for keys.
    #[error("this station keeps no signing keys: start it with a folder for them")]
    NoFolder,
    /// The folder or a file in it cannot be used.
    #[error(
        "the signing keys in {path} cannot be used: {problem}; restore the file from a copy, or move it away and set up signing again over USB"
    )]
    Storage {
        /// The file.
        path: String,
        /// What was wrong.
        problem: String,
    },
    /// A name that cannot be a key's.
    #[error("'{name}' cannot be a key's name: 1 to {MAX_NAME} letters, digits, '-', '_' and '.'")]
    BadName {
        /// The name.
        name: String,
    },
    /// The name is taken.
    #[error("there is a signing key '{name}' already; choose another name")]
    NameTaken {
        /// The name.
        name: String,
    },
    /// There is no such key.
    #[error("there is no signing key '{name}'; `vencejo signing keys` lists them")]
    NoSuchKey {
        /// The name.
        name: String,
    },
    /// A vehicle has the key.
    #[error("the signing key '{name}' is in use by a vehicle")]
    KeyInUse {
        /// The name.
        name: String,
    },
    /// It signs already, or does not yet.
    #[error("{}", if *signs { "the vehicle signs already: rotate its key instead" } else { "the vehicle does not sign: set up signing first" })]
    WrongState {
        /// Whether it signs.
        signs: bool,
    },
    /// The key is only changed on a vehicle that is known to be disarmed.
    #[error("signing is changed on a disarmed vehicle only, and this one {}", match armed { Some(true) => "is armed", _ => "is not heard, so that it is not known" })]
    NotDisarmed {
        /// Whether it is; `None` when it is not known.
        armed: Option<bool>,
    },
    /// Others could listen on every way to the vehicle.
    #[error(
        "the key goes over the link as it is, and {link} can be listened to: connect by USB or on this machine, or allow this link expressly"
    )]
    NotPrivate {
        /// The link.
        link: String,
    },
    /// A change is under way.
    #[error("the vehicle's signing is being changed already")]
    Busy,
    /// The vehicle said no.
    #[error("the vehicle refused: {text}")]
    Refused {
        /// In its own words.
        text: String,
    },
    /// The vehicle did not show it in time.
    #[error(
        "the vehicle did not show the change within 5 s; nothing was thrown away: it is talked to as before, and if it shows the change later, that is followed"
    )]
    Unproven,
}

impl SigningError {
    /// One of each kind.
    #[doc(hidden)]
    #[must_use]
    pub fn examples() -> Vec<Self> {
        let name = || "vehicle-1".to_owned();
        vec![
            Self::NoFolder,
            Self::Storage { path: "keys.json".into(), problem: "permission denied".into() },
            Self::BadName { name: "a b".into() },
            Self::NameTaken { name: name() },
            Self::NoSuchKey { name: name() },
            Self::KeyInUse { name: name() },
            Self::WrongState { signs: true },
            Self::NotDisarmed { armed: Some(true) },
            Self::NotPrivate { link: "udpin:0.0.0.0:14550".into() },
            Self::Busy,
            Self::Refused { text: "ERROR: Won't setup signing when armed".into() },
            Self::Unproven,
        ]
    }
}

/// A key, without what is secret of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyInfo {
    /// Its name.
    pub name: String,
    /// When it was made, in seconds since the UNIX epoch by this machine's clock.
    pub made_unix_s: u64,
    /// The vehicles that have it, or may.
    pub vehicles: Vec<SystemId>,
}

/// How a vehicle signs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SigningInfo {
    /// Whether what it does not sign is refused.
    pub must_sign: bool,
    /// The key that it is talked to with.
    pub key: Option<String>,
    /// Whether that key is gone from this machine: nothing of the vehicle is believed then.
    pub key_missing: bool,
    /// Keys that were sent to it and that it has not shown.
    pub unproven: Vec<String>,
    /// What was counted since the station began.
    pub counts: SigningCounts,
    /// Since its newest verified frame.
    pub verified_age: Option<Duration>,
    /// Since the newest frame in its name that was refused.
    pub refused_age: Option<Duration>,
}

/// What is to be done with a vehicle's key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SigningChange {
    /// Give a key to a vehicle that does not sign: this one, or a new one.
    SetUp {
        /// The name of a key that is kept already.
        key: Option<String>,
    },
    /// Give another key to a vehicle that signs.
    Rotate {
        /// The name of a key that is kept already.
        key: Option<String>,
    },
    /// Take its key away.
    Remove,
}

impl SigningChange {
    fn goal(&self) -> KeyGoal {
        if *self == Self::Remove { KeyGoal::NoKey } else { KeyGoal::NewKey }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize, PartialEq, Eq)]
struct StoredKey {
    id: u32,
    name: String,
    made_unix_s: u64,
    #[serde(with = "secret")]
    key: SigningKey,
}

#[derive(Debug, Clone, Serialize, Deserialize, PartialEq, Eq)]
struct StoredVehicle {
    keys: Vec<u32>,
    signs_with: Option<u32>,
    must_sign: bool,
}

impl StoredVehicle {
    fn keys(&self) -> VehicleKeys {
        VehicleKeys {
            keys: self.keys.iter().copied().map(KeyId).collect(),
            signs_with: self.signs_with.map(KeyId),
            must_sign: self.must_sign,
        }
    }
}

/// What `keys.json` holds.
#[derive(Debug, Clone, Default, Serialize, Deserialize, PartialEq, Eq)]
struct Book {
    next_id: u32,
    keys: Vec<StoredKey>,
    vehicles: BTreeMap<u8, StoredVehicle>,
}

impl Book {
    fn named(&self, name: &str) -> Result<&StoredKey, SigningError> {
        let found = self.keys.iter().find(|key| key.name == name);
        found.ok_or_else(|| SigningError::NoSuchKey { name: name.to_owned() })
    }

    fn name_of(&self, id: KeyId) -> Option<String> {
        self.keys.iter().find(|key| key.id == id.0).map(|key| key.name.clone())
    }

    fn add(&mut self, name: &str, key: SigningKey, unix_us: u64) -> Result<KeyId, SigningError> {
        let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
        if name.is_empty() || name.len() > MAX_NAME || !name.chars().all(fits) {
            return Err(SigningError::BadName { name: name.to_owned() });
        }
        if self.named(name).is_ok() {
            return Err(SigningError::NameTaken { name: name.to_owned() });
        }
        // Never used again: the time that was signed with is kept by it.
        self.next_id = self.next_id.max(self.keys.iter().map(|key| key.id).max().unwrap_or(0)) + 1;
        self.keys.push(StoredKey { id: self.next_id, name: name.to_owned(), made_unix_s: unix_us / 1_000_000, key });
        Ok(KeyId(self.next_id))
    }

    /// A new random key, named after its vehicle.
    fn make_for(&mut self, system: SystemId, unix_us: u64) -> Result<KeyId, SigningError> {
        let name = (1..).map(|number| match number {
            1 => format!("vehicle-{system}"),
            number => format!("vehicle-{system}-{number}"),
        });
        let name = name.into_iter().find(|name| self.named(name).is_err()).unwrap_or_default();
        self.add(&name, random_key()?, unix_us)
    }

    fn vehicle(&mut self, system: SystemId) -> &mut StoredVehicle {
        let unsigned = StoredVehicle { keys: Vec::new(), signs_with: None, must_sign: false };
        self.vehicles.entry(system.0).or_insert(unsigned)
    }
}

fn random_key() -> Result<SigningKey, SigningError> {
    let mut bytes = [0; SigningKey::LEN];
    let made = getrandom::fill(&mut bytes).ok().and_then(|()| SigningKey::new(bytes));
    made.ok_or_else(|| SigningError::Storage {
        path: "the system's random numbers".into(),
        problem: "there are none".into(),
    })
}

/// A key as hexadecimal digits.
mod secret {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};
    use vencejo_proto::SigningKey;

    pub(super) fn serialize<S: Serializer>(key: &SigningKey, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&super::to_hex(key))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<SigningKey, D::Error> {
        // What is wrong with it is not repeated: it might be the key.
        super::from_hex(&String::deserialize(from)?)
            .ok_or_else(|| D::Error::custom("a key is not 64 hexadecimal digits"))
    }
}

/// A key as 64 hexadecimal digits.
fn to_hex(key: &SigningKey) -> String {
    key.expose().iter().flat_map(|byte| [byte >> 4, byte & 15]).filter_map(|n| char::from_digit(n.into(), 16)).collect()
}

fn from_hex(text: &str) -> Option<SigningKey> {
    if text.len() != 2 * SigningKey::LEN {
        return None;
    }
    let digits: Option<Vec<u8>> = text.chars().map(|c| c.to_digit(16).map(|n| n as u8)).collect();
    let bytes: Vec<u8> = digits?.chunks(2).map(|pair| pair.iter().fold(0, |all, n| all << 4 | n)).collect();
    SigningKey::new(<[u8; SigningKey::LEN]>::try_from(bytes).ok()?)
}

/// The keys of a folder. Its calls block.
pub(crate) struct Vault {
    folder: PathBuf,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    book: Book,
    /// What `keys.json` looked like when it was read.
    seen: Option<(SystemTime, u64)>,
    /// The times as they were written last.
    times: BTreeMap<u32, u64>,
    /// The vehicles' own changes that are in the file.
    changes: BTreeMap<u8, u64>,
    /// Vehicles whose key is being changed.
    busy: Vec<SystemId>,
}

impl Vault {
    /// Reads the keys of a folder and hands them to the hub.
    pub(crate) fn open(folder: &Path, hub: &Hub) -> Result<Self, SigningError> {
        let vault = Self { folder: folder.to_owned(), state: Mutex::default() };
        vault.look(hub)?;
        vault.write_times(hub, false)?;
        Ok(vault)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn keys_path(&self) -> PathBuf {
        self.folder.join("keys.json")
    }

    fn times_path(&self) -> PathBuf {
        self.folder.join("times.json")
    }

    fn failed(path: &Path, problem: impl ToString) -> SigningError {
        SigningError::Storage { path: path.display().to_string(), problem: problem.to_string() }
    }

    /// Makes the folder, for its owner alone.
    fn make_folder(&self) -> Result<(), SigningError> {
        let made = vencejo_store::make_folder(&self.folder);
        #[cfg(unix)]
        let made = made.and_then(|()| {
            let owner_only = std::os::unix::fs::PermissionsExt::from_mode(0o700);
            std::fs::set_permissions(&self.folder, owner_only)
        });
        made.map_err(|error| Self::failed(&self.folder, error))
    }

    fn read_book(&self) -> Result<(Book, Option<(SystemTime, u64)>), SigningError> {
        let path = self.keys_path();
        let failed = |error: &dyn ToString| Self::failed(&path, error.to_string());
        let text = match std::fs::read(&path) {
            Ok(text) => text,
            // Nor are there any in a folder that is a file.
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                return Ok((Book::default(), None));
            }
            Err(error) => return Err(failed(&error)),
        };
        Ok((serde_json::from_slice(&text).map_err(|error| failed(&error))?, stamp(&path)))
    }

    /// Changes what is on disk, and the hub accordingly.
    fn change<T>(
        &self,
        hub: &Hub,
        change: impl FnOnce(&mut Book) -> Result<T, SigningError>,
    ) -> Result<T, SigningError> {
        let path = self.keys_path();
        let failed = |error: io::Error| Self::failed(&path, error);
        self.make_folder()?;
        let _lock = Lock::of(&path, vencejo_store::lock::PATIENCE).map_err(failed)?;
        let mut state = self.state();
        let (mut book, _) = self.read_book()?;
        let before = book.clone();
        let result = change(&mut book)?;
        if book != before {
            let text = serde_json::to_vec_pretty(&book).map_err(|error| Self::failed(&path, error))?;
            vencejo_store::write(&path, &text, Access::Owner).map_err(failed)?;
        }
        state.seen = stamp(&path);
        self.apply(hub, &mut state, book);
        Ok(result)
    }

    /// Takes up what other programs changed.
    fn look(&self, hub: &Hub) -> Result<(), SigningError> {
        let mut state = self.state();
        let seen = stamp(&self.keys_path());
        if seen.is_none() || seen == state.seen {
            return Ok(());
        }
        let (book, seen) = self.read_book()?;
        state.seen = seen;
        self.apply(hub, &mut state, book);
        Ok(())
    }

    fn apply(&self, hub: &Hub, state: &mut State, book: Book) {
        let stored = self.read_times(hub);
        for key in &book.keys {
            let resumed = stored.get(&key.id).copied().unwrap_or(0);
            hub.add_signing_key(KeyId(key.id), key.key.clone(), SigningTime::from_ticks(resumed));
        }
        for system in state.book.vehicles.keys().filter(|system| !book.vehicles.contains_key(system)) {
            hub.set_vehicle_keys(SystemId(*system), VehicleKeys::default());
        }
        for (system, vehicle) in &book.vehicles {
            let keys = vehicle.keys();
            if hub.signing(SystemId(*system)).is_none_or(|present| present.keys != keys) {
                hub.set_vehicle_keys(SystemId(*system), keys);
            }
        }
        state.book = book;
    }

    /// Writes down what the vehicles have shown by themselves.
    pub(crate) fn follow(&self, hub: &Hub) -> Result<(), SigningError> {
        let shown: Vec<_> = {
            let state = self.state();
            let is_new = |system: &SystemId, changes| state.changes.get(&system.0).copied().unwrap_or(0) != changes;
            let vehicles = hub.signing_vehicles().into_iter();
            vehicles.filter(|(system, shown)| is_new(system, shown.changes) && !state.busy.contains(system)).collect()
        };
        if shown.is_empty() {
            return Ok(());
        }
        self.change(hub, |book| {
            for (system, shown) in &shown {
                let Some(vehicle) = book.vehicles.get_mut(&system.0) else { continue };
                vehicle.must_sign |= shown.keys.must_sign;
                vehicle.signs_with = shown.keys.signs_with.map(|id| id.0);
                // The keys before the one that it shows have had their day; those after it may still be on their way.
                let present = vehicle.keys.iter().position(|id| Some(*id) == vehicle.signs_with);
                drop(vehicle.keys.drain(..present.unwrap_or(0)));
            }
            Ok(())
        })?;
        self.state().changes.extend(shown.iter().map(|(system, shown)| (system.0, shown.changes)));
        Ok(())
    }

    fn read_times(&self, hub: &Hub) -> BTreeMap<u32, u64> {
        let path = self.times_path();
        match std::fs::read(&path) {
            Ok(text) => serde_json::from_slice(&text).unwrap_or_else(|error| {
                tracing::error!(%error, path = %path.display(), "the times of the signing keys cannot be read; this machine's clock is trusted");
                let now = SigningTime::from_unix_us(hub.clock().unix_us()).ticks();
                self.state_ids().into_iter().map(|id| (id, now)).collect()
            }),
            Err(_) => BTreeMap::new(),
        }
    }

    /// Ids of the keys on disk; for when nothing else is known of them.
    fn state_ids(&self) -> Vec<u32> {
        self.read_book().map(|(book, _)| book.keys.iter().map(|key| key.id).collect()).unwrap_or_default()
    }

    /// Writes each key's time: one that is reserved, or at the `end` the one that was used.
    pub(crate) fn write_times(&self, hub: &Hub, end: bool) -> Result<(), SigningError> {
        let times = hub.signing_times();
        if times.is_empty() {
            return Ok(());
        }
        let path = self.times_path();
        let failed = |error: io::Error| Self::failed(&path, error);
        let _lock = Lock::of(&path, vencejo_store::lock::PATIENCE).map_err(failed)?;
        let mut stored = self.read_times(hub);
        let mut state = self.state();
        for (KeyId(id), latest, reserved) in times {
            let new = if end { latest } else { reserved }.ticks();
            let there = stored.get(&id).copied().unwrap_or(0);
            // What another program reserved stays.
            let ours = state.times.get(&id) == Some(&there);
            stored.insert(id, if ours { new } else { new.max(there) });
            state.times.insert(id, stored[&id]);
        }
        let text = serde_json::to_vec(&stored).map_err(|error| Self::failed(&path, error))?;
        vencejo_store::write(&path, &text, Access::Owner).map_err(failed)
    }
}

fn stamp(path: &Path) -> Option<(SystemTime, u64)> {
    let about = std::fs::metadata(path).ok()?;
    Some((about.modified().ok()?, about.len()))
}

/// Keeps keys and times in step with the disk, until the station ends.
pub(crate) async fn keep(shared: Weak<Shared>, mut closing: watch::Receiver<bool>) {
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
            vault.follow(hub)?;
            vault.look(hub)?;
            if write_times { vault.write_times(hub, false) } else { Ok(()) }
        });
        if let Err(error) = kept.await {
            tracing::error!(%error, "signing keys or their times are not on disk");
        }
    }
}

impl Shared {
    fn vault(&self) -> Result<&Vault, SigningError> {
        let fault = || self.vault_fault.clone().unwrap_or(SigningError::NoFolder);
        self.vault.as_ref().ok_or_else(fault)
    }

    /// Does something with the keys off the runtime's threads.
    pub(crate) async fn blocking<T: Send + 'static>(
        self: &Arc<Self>,
        work: impl FnOnce(&Vault, &Hub) -> Result<T, SigningError> + Send + 'static,
    ) -> Result<T, StationError> {
        let shared = self.clone();
        let done = self.runtime().spawn_blocking(move || {
            let vault = shared.vault()?;
            work(vault, shared.hub())
        });
        done.await.map_err(|_| StationError::Closed)?.map_err(StationError::from)
    }
}

impl Station {
    fn vault(&self) -> Result<&Vault, SigningError> {
        self.shared.vault()
    }

    /// Why nothing is signed and nothing is checked, when the keys could not be read.
    #[must_use]
    pub fn signing_fault(&self) -> Option<String> {
        self.shared.vault_fault.as_ref().map(ToString::to_string)
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

    /// Says that a vehicle has a key already, given by another ground station, or with `None` that it has none: nothing is
    /// sent. Blocks while it is written.
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
        self.station().signing_of(self.system())
    }

    /// Gives it a key, another one, or takes its key away, and waits until it shows that. Only while it is known to be
    /// disarmed, and only over a link that nobody else can reach, unless `any_link` allows another one. It ends within 5 s,
    /// and goes on to its end when nobody waits any more.
    pub fn change_signing(&self, change: SigningChange, any_link: bool) -> Pending<RequestResult> {
        if let Err(error) = self.take_control() {
            return Pending::ended(Err(error));
        }
        // It ends soon by itself, and half done it would be worse.
        let (finisher, pending) = Pending::new(|| {});
        let vehicle = self.clone();
        self.station().shared.runtime().spawn(async move {
            let result = change_key(&vehicle, change, any_link).await;
            finisher.finish(result.map(|()| Reply::Done));
        });
        pending
    }
}

/// Frees a vehicle for the next change, however this one ends.
struct Busy<'a>(&'a Vault, SystemId);

impl Drop for Busy<'_> {
    fn drop(&mut self) {
        self.0.state().busy.retain(|system| *system != self.1);
    }
}

async fn change_key(vehicle: &VehicleHandle, change: SigningChange, any_link: bool) -> Result<(), StationError> {
    let (station, system, goal) = (vehicle.station(), vehicle.system(), change.goal());
    let shared = &station.shared;
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
    let ways = shared.hub().links_of(system);
    let links = shared.hub().links();
    let ways: Vec<_> = ways.iter().filter_map(|(id, _)| links.iter().find(|link| link.id == *id)).collect();
    let private = ways.iter().find(|link| link.accepts_unsigned);
    let Some(link) = private.or(ways.first().filter(|_| any_link)) else {
        let link = ways.first().map_or_else(|| "no link".to_owned(), |link| link.address.to_string());
        return Err(SigningError::NotPrivate { link }.into());
    };

    // On disk before it is on its way: a key that only the vehicle has would cut us off.
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
    let end = send_until_shown(vehicle, goal, new.as_ref(), link.id, target, began).await;
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
        vault.write_times(hub, false)
    });
    kept.await
}

async fn send_until_shown(
    vehicle: &VehicleHandle,
    goal: KeyGoal,
    new: Option<&(KeyId, SigningKey)>,
    link: vencejo_link::LinkId,
    target: vencejo_proto::Address,
    began: MonoTime,
) -> KeyEnd {
    let shared = &vehicle.station().shared;
    let mut change = KeyChange::new(goal, began);
    loop {
        let now = vehicle.station().now();
        if let Some(state) = shared.hub().signing(vehicle.system()) {
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
                    shared.hub().send_message(&message, shared.our_address(), MavVersion::V2, Route::Link(link));
                if !report.is_sent() {
                    tracing::warn!(vehicle = %vehicle.system(), "the signing key did not leave: the link is not open");
                }
            }
            KeyStep::Wait(until) => tokio::time::sleep(until.since(now).min(WATCH)).await,
            KeyStep::Ended(end) => return end,
        }
    }
}

#[cfg(test)]
mod tests;
