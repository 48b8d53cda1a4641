//! Signing keys: stored on disk, given to vehicles, rotated without losing a vehicle, with timestamps that survive
//! restarts.
//!
//! The folder holds `keys.json` (the keys and which vehicle has which) and `times.json` (for each key the latest time
//! of any signed or accepted frame). Both are readable by their owner only. Several programs may share the folder: each
//! change is made under a lock on what is there, and the others see it within seconds.

mod change;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};
use thiserror::Error;
use vencejo_link::{Hub, KeyId, SigningCounts, VehicleKeys};
use vencejo_proto::{SigningKey, SigningTime, SystemId};
use vencejo_store::{Access, Lock};
use vencejo_vehicle::signing::KeyGoal;

/// Most keys that a vehicle was sent and has not used yet.
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
    /// An invalid key name.
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
    /// The vehicle signs already, or does not sign yet.
    #[error("{}", if *signs { "the vehicle signs already: rotate its key instead" } else { "the vehicle does not sign: set up signing first" })]
    WrongState {
        /// Whether it signs.
        signs: bool,
    },
    /// The key is only changed on a vehicle that is known to be disarmed.
    #[error("signing is changed on a disarmed vehicle only, and this one {}", match armed { Some(true) => "is armed", _ => "is not heard: its state is unknown" })]
    NotDisarmed {
        /// Whether it is; `None` when it is not known.
        armed: Option<bool>,
    },
    /// Others could listen on every link to the vehicle.
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
    /// The vehicle refused.
    #[error("the vehicle refused: {text}")]
    Refused {
        /// Its own text.
        text: String,
    },
    /// The vehicle did not show the change in time.
    #[error(
        "the vehicle did not show the change within 5 s; nothing was thrown away: it is talked to as before, and if it shows the change later, that is followed"
    )]
    Unproven,
}

impl SigningError {
    /// One of each kind.
    #[doc(hidden)]
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

/// A key, without its secret.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyInfo {
    /// Its name.
    pub name: String,
    /// When it was made, in seconds since the UNIX epoch by this machine's clock.
    pub made_unix_s: u64,
    /// The vehicles that have it, or may have it.
    pub vehicles: Vec<SystemId>,
}

/// How a vehicle signs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SigningInfo {
    /// Whether its unsigned frames are refused.
    pub must_sign: bool,
    /// The key that frames to it are signed with.
    pub key: Option<String>,
    /// Whether that key is missing on this machine: all frames of the vehicle are refused then.
    pub key_missing: bool,
    /// Keys that were sent to it and that it has not used yet.
    pub unproven: Vec<String>,
    /// Counts since the station started.
    pub counts: SigningCounts,
    /// Since its newest verified frame.
    pub verified_age: Option<Duration>,
    /// Since the newest frame in its name that was refused.
    pub refused_age: Option<Duration>,
}

/// A change of a vehicle's key.
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
        // Key ids are never reused: signing times are stored by them.
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
        // The error does not repeat the value: it might be the key.
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
    /// Why they could not be written last.
    times_fault: Option<String>,
    /// The vehicles' own changes that the file holds.
    changes: BTreeMap<u8, u64>,
    /// Vehicles whose key is being changed.
    busy: Vec<SystemId>,
}

impl Vault {
    /// Reads the keys of a folder and hands them to the hub.
    pub(crate) fn open(folder: &Path, hub: &Hub) -> Result<Self, SigningError> {
        let vault = Self { folder: folder.to_owned(), state: Mutex::default() };
        vault.look(hub)?;
        vault.write_times(hub, false);
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
        let text = match vencejo_store::read_small(&path) {
            Ok(text) => text,
            // A folder that is a file holds no keys either.
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
    pub(crate) fn look(&self, hub: &Hub) -> Result<(), SigningError> {
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

    /// Stores the keys that vehicles have shown by using them.
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
                // Keys before the one that it uses are obsolete; later ones may still be on their way.
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
        match vencejo_store::read_small(&path) {
            Ok(text) => serde_json::from_slice(&text).unwrap_or_else(|error| {
                tracing::error!(%error, path = %path.display(), "the times of the signing keys cannot be read; this machine's clock is trusted");
                let now = SigningTime::from_unix_us(hub.clock().unix_us()).ticks();
                self.state_ids().into_iter().map(|id| (id, now)).collect()
            }),
            Err(_) => BTreeMap::new(),
        }
    }

    /// Ids of the keys on disk.
    fn state_ids(&self) -> Vec<u32> {
        self.read_book().map(|(book, _)| book.keys.iter().map(|key| key.id).collect()).unwrap_or_default()
    }

    /// Why the keys' times are not on disk.
    pub(crate) fn times_fault(&self) -> Option<String> {
        self.state().times_fault.clone()
    }

    /// Writes each key's time: a reserved one, or at the `end` the last one used. A failure is reported and the keys
    /// stay in use.
    pub(crate) fn write_times(&self, hub: &Hub, end: bool) {
        let fault = self.store_times(hub, end).err().map(|error| format!("{}: {error}", self.times_path().display()));
        fault.iter().for_each(|fault| tracing::error!("the times of the signing keys are not on disk: {fault}"));
        self.state().times_fault = fault;
    }

    fn store_times(&self, hub: &Hub, end: bool) -> io::Result<()> {
        let times = hub.signing_times();
        if times.is_empty() {
            return Ok(());
        }
        let path = self.times_path();
        let _lock = Lock::of(&path, vencejo_store::lock::PATIENCE)?;
        let mut stored = self.read_times(hub);
        let mut state = self.state();
        for (KeyId(id), latest, reserved) in times {
            let new = if end { latest } else { reserved }.ticks();
            let there = stored.get(&id).copied().unwrap_or(0);
            // Times that another program reserved stay.
            let ours = state.times.get(&id) == Some(&there);
            stored.insert(id, if ours { new } else { new.max(there) });
            state.times.insert(id, stored[&id]);
        }
        vencejo_store::write(&path, &serde_json::to_vec(&stored)?, Access::Owner)
    }
}

fn stamp(path: &Path) -> Option<(SystemTime, u64)> {
    let about = std::fs::metadata(path).ok()?;
    Some((about.modified().ok()?, about.len()))
}

#[cfg(test)]
mod tests;
