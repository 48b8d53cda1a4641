//! Tests of the folder of keys: what is in it, who may read it, and what damage does.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use vencejo_link::SystemClock;
use vencejo_proto::Address;

use super::*;
use crate::error::StationError;
use crate::station::Station;

/// A folder of its own, gone afterwards.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("vencejo-signing-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        Self(std::env::temp_dir().join(name).join("signing"))
    }

    fn open(&self) -> (Vault, Hub) {
        let hub = Hub::new(vec![Address::new(255, 190)], Arc::new(SystemClock::new()));
        (Vault::open(&self.0, &hub).expect("it can be opened"), hub)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(self.0.parent().expect("it has one"));
    }
}

const VEHICLE: SystemId = SystemId(1);

/// Keeps a new key and says that the vehicle has it.
fn give(vault: &Vault, hub: &Hub) -> KeyId {
    let given = vault.change(hub, |book| {
        let id = book.make_for(VEHICLE, 0)?;
        *book.vehicle(VEHICLE) = StoredVehicle { keys: vec![id.0], signs_with: Some(id.0), must_sign: true };
        Ok(id)
    });
    given.expect("it is written")
}

#[test]
fn nothing_is_made_until_there_is_a_key() {
    let folder = Scratch::new();
    let (vault, hub) = folder.open();
    vault.look(&hub).expect("nothing to read");
    vault.write_times(&hub, true);
    assert!(!folder.0.exists());
}

#[cfg(unix)]
#[test]
fn keys_are_their_owner_s_alone_and_are_there_again() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Scratch::new();
    let (vault, hub) = folder.open();
    let id = give(&vault, &hub);
    vault.write_times(&hub, false);
    let mode = |path: PathBuf| std::fs::metadata(path).expect("there").permissions().mode() & 0o777;
    assert_eq!((mode(folder.0.clone()), mode(vault.keys_path()), mode(vault.times_path())), (0o700, 0o600, 0o600));

    let (again, hub) = folder.open();
    assert_eq!(hub.signing(VEHICLE).expect("it has a key").keys.signs_with, Some(id));
    let key = |vault: &Vault| vault.state().book.named("vehicle-1").expect("there").key.clone();
    assert_eq!(key(&again), key(&vault));
    assert_eq!(format!("{:?}", again.state().book).matches(&to_hex(&key(&vault))[..8]).count(), 0);
}

#[test]
fn time_goes_on_after_a_restart_in_order_or_not() {
    let folder = Scratch::new();
    let (vault, hub) = folder.open();
    let id = give(&vault, &hub);
    for in_order in [false, true, false] {
        let (vault, hub) = folder.open();
        let used = hub.next_signing_time(id).expect("there is time");
        if in_order {
            vault.write_times(&hub, true);
        }
        let (_, hub) = folder.open();
        assert!(hub.next_signing_time(id).expect("there is time") > used, "in order: {in_order}");
    }
}

#[test]
fn another_program_s_change_is_taken_up() {
    let folder = Scratch::new();
    let ((ours, our_hub), (theirs, their_hub)) = (folder.open(), folder.open());
    give(&theirs, &their_hub);
    assert_eq!(our_hub.signing(VEHICLE), None);
    ours.look(&our_hub).expect("it can be read");
    assert!(our_hub.signing(VEHICLE).expect("it has a key").keys.must_sign);
    // And neither loses what the other did.
    ours.change(&our_hub, |book| book.add("mine", random_key()?, 0)).expect("written");
    theirs.change(&their_hub, |book| book.add("yours", random_key()?, 0)).expect("written");
    let names: Vec<_> = theirs.state().book.keys.iter().map(|key| key.name.clone()).collect();
    assert_eq!(names, ["vehicle-1", "mine", "yours"]);
}

#[test]
fn a_damaged_file_is_not_opened_and_stays_and_its_key_is_not_repeated() {
    let folder = Scratch::new();
    let (vault, hub) = folder.open();
    give(&vault, &hub);
    let path = vault.keys_path();
    let secret = to_hex(&vault.state().book.keys[0].key);
    let text = std::fs::read_to_string(&path).expect("there").replace(&secret, &format!("{secret}ff"));
    std::fs::write(&path, &text).expect("written");
    let error = Vault::open(&folder.0, &hub).err().expect("it cannot be read");
    assert!(error.to_string().contains("keys.json"), "{error}");
    assert!(!error.to_string().contains(&secret[..8]), "{error}");
    assert_eq!(std::fs::read_to_string(&path).expect("there"), text);
}

#[tokio::test]
async fn a_station_starts_without_keys_that_cannot_be_read_and_says_so() {
    let folder = Scratch::new();
    std::fs::create_dir_all(&folder.0).expect("a folder");
    let path = folder.0.join("keys.json");
    std::fs::write(&path, "{\"keys\": [").expect("a damaged file");
    let config = crate::StationConfig { signing_dir: Some(folder.0.clone()), ..crate::StationConfig::default() };
    let station = Station::start(config, tokio::runtime::Handle::current()).expect("it starts");
    let told = station.signing_fault().expect("it is said");
    assert!(told.contains("keys.json"), "{told}");
    assert!(matches!(station.add_signing_key("one", None), Err(StationError::Signing(SigningError::Storage { .. }))));
    assert_eq!(std::fs::read_to_string(&path).expect("it stays"), "{\"keys\": [");
    station.close().await;
}

#[test]
fn a_key_in_use_is_kept_though_its_time_is_damaged() {
    let folder = Scratch::new();
    let (vault, hub) = folder.open();
    let id = give(&vault, &hub);
    std::fs::write(vault.times_path(), "{").expect("written");
    let (vault, hub) = folder.open();
    assert!(hub.next_signing_time(id).is_some());
    vault.write_times(&hub, false);
    assert!(std::fs::read_to_string(vault.times_path()).expect("there").len() > 2);
}

#[test]
fn keys_are_used_though_their_times_cannot_be_written_and_it_is_said() {
    let folder = Scratch::new();
    let (vault, hub) = folder.open();
    let id = give(&vault, &hub);
    let path = vault.times_path();
    std::fs::create_dir_all(path.join("in the way")).expect("a folder");
    let (vault, hub) = folder.open();
    assert_eq!(hub.signing(VEHICLE).expect("it has a key").keys.signs_with, Some(id));
    assert!(hub.next_signing_time(id).is_some());
    assert_eq!(vault.state().book.keys.len(), 1, "and listed");
    let told = vault.times_fault().expect("it is said");
    assert!(told.contains("times.json") && !told.contains("move it away"), "{told}");
    std::fs::remove_dir_all(&path).expect("out of the way");
    vault.write_times(&hub, false);
    assert_eq!((vault.times_fault(), path.is_file()), (None, true));
}

#[test]
fn a_key_is_64_digits_and_not_zeros() {
    let key = random_key().expect("random");
    assert_eq!(from_hex(&to_hex(&key)), Some(key.clone()));
    let digits = to_hex(&key);
    for wrong in ["", &digits[1..], &format!("{digits}0"), &"0".repeat(64), &"g".repeat(64)] {
        assert_eq!(from_hex(wrong), None, "{wrong}");
    }
}
