//! Access tokens: generated once, kept in a file that only their owner can read, and reloaded regularly, so that
//! replacing or removing the file revokes them. Also rate limiting of wrong tokens.

use std::collections::HashMap;
use std::io;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use vencejo_proto::MonoTime;
use vencejo_store::Access;

use crate::dto::Role;
use crate::dto::storage::StorageFault;

/// Random bytes of a token or session secret: 128 bits.
const SECRET_BYTES: usize = 16;

/// Interval at which the file is checked.
pub const LOOK_INTERVAL: Duration = Duration::from_secs(1);
/// Least number of hexadecimal digits of a token.
const LEAST_DIGITS: usize = 32;

/// A random secret in hexadecimal digits.
///
/// # Errors
/// When the system cannot provide random numbers.
pub fn random_secret() -> io::Result<String> {
    let mut bytes = [0_u8; SECRET_BYTES];
    getrandom::fill(&mut bytes).map_err(|error| io::Error::other(error.to_string()))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Whether two texts are equal, in constant time.
pub fn same(left: &str, right: &str) -> bool {
    let (left, right) = (left.as_bytes(), right.as_bytes());
    left.len() == right.len() && left.iter().zip(right).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}

/// Tokens of a server, one for each role.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tokens {
    /// Token of viewers.
    pub viewer: String,
    /// Token of operators.
    pub operator: String,
}

impl std::fmt::Debug for Tokens {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Tokens(…)")
    }
}

impl Tokens {
    /// New random tokens.
    ///
    /// # Errors
    /// When the system cannot provide random numbers.
    pub fn random() -> io::Result<Self> {
        Ok(Self { viewer: random_secret()?, operator: random_secret()? })
    }

    /// Tokens from a file; a missing file is created, readable by its owner only.
    ///
    /// # Errors
    /// When the file cannot be read or written, or has other content.
    pub fn load_or_create(path: &Path) -> io::Result<Self> {
        match Self::load(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let tokens = Self::random()?;
                // Another process may have created it meanwhile; then its tokens are used.
                let is_ours = vencejo_store::create(path, &tokens.bytes()?, Access::Owner)?;
                if is_ours { Ok(tokens) } else { Self::load(path) }
            }
            loaded => loaded,
        }
    }

    /// Tokens from a file, as [`Self::load_or_create`]. A damaged file is renamed and a new one created; where the file
    /// cannot be read or written, the tokens are for this run only. Returns the fault, if any.
    ///
    /// # Errors
    /// When the file contains invalid tokens, or the system cannot provide random numbers.
    pub fn load_or_make(path: &Path) -> io::Result<(Self, Option<StorageFault>)> {
        let unwritable = |error: &io::Error| StorageFault::Unwritable { reason: error.to_string() };
        let error = match Self::load_or_create(path) {
            Ok(tokens) => return Ok((tokens, None)),
            Err(error) => error,
        };
        match error.kind() {
            io::ErrorKind::InvalidData => match vencejo_store::set_aside(path) {
                Ok(aside) => {
                    let name = aside.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
                    Ok((Self::load_or_create(path)?, Some(StorageFault::SetAside { name })))
                }
                Err(error) => Ok((Self::random()?, Some(unwritable(&error)))),
            },
            // These errors concern the file's content, not the disk.
            io::ErrorKind::Other => Err(error),
            _ => Ok((Self::random()?, Some(unwritable(&error)))),
        }
    }

    /// Replaces the tokens of some roles. A server that uses the file reloads them within seconds, and ends the
    /// sessions opened with the old ones.
    ///
    /// # Errors
    /// As [`Self::load_or_create`].
    pub fn renew(path: &Path, viewer: bool, operator: bool) -> io::Result<Self> {
        let mut tokens = Self::load_or_create(path)?;
        if viewer {
            tokens.viewer = random_secret()?;
        }
        if operator {
            tokens.operator = random_secret()?;
        }
        vencejo_store::write(path, &tokens.bytes()?, Access::Owner)?;
        Ok(tokens)
    }

    fn load(path: &Path) -> io::Result<Self> {
        let bytes = vencejo_store::read_small(path)?;
        restrict(path)?;
        let broken = |error| io::Error::new(io::ErrorKind::InvalidData, error);
        let tokens: Self = serde_json::from_slice(&bytes).map_err(broken)?;
        let is_long = |token: &String| token.len() >= LEAST_DIGITS;
        if is_long(&tokens.viewer) && is_long(&tokens.operator) && tokens.viewer != tokens.operator {
            return Ok(tokens);
        }
        Err(io::Error::other("the tokens are too short or identical; remove the file, and new ones are created"))
    }

    fn bytes(&self) -> io::Result<Vec<u8>> {
        serde_json::to_vec_pretty(self).map_err(io::Error::other)
    }

    /// Role of a token.
    pub fn role(&self, token: &str) -> Option<Role> {
        // Both are always compared, so that the time reveals nothing.
        let (operator, viewer) = (same(token, &self.operator), same(token, &self.viewer));
        if operator { Some(Role::Operator) } else { viewer.then_some(Role::Viewer) }
    }
}

/// Restricts a file's permissions to its owner.
fn restrict(path: &Path) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // On a read-only disk they may be right already.
        if std::fs::metadata(path)?.permissions().mode() & 0o077 != 0 {
            std::fs::set_permissions(path, PermissionsExt::from_mode(0o600))?;
        }
    }
    #[cfg(not(unix))]
    let _ = path;
    Ok(())
}

/// The tokens in effect. Clones share the same state.
#[derive(Debug, Clone)]
pub struct TokenStore {
    now: Arc<RwLock<Tokens>>,
    file: Option<PathBuf>,
}

impl From<Tokens> for TokenStore {
    fn from(tokens: Tokens) -> Self {
        Self { now: Arc::new(RwLock::new(tokens)), file: None }
    }
}

impl TokenStore {
    /// Tokens from a file, as [`Tokens::load_or_make`], with the fault, if any. Tokens that could not be stored are for
    /// this run, and no file is checked.
    ///
    /// # Errors
    /// As for [`Tokens::load_or_make`].
    pub fn open(path: &Path) -> io::Result<(Self, Option<StorageFault>)> {
        let (tokens, fault) = Tokens::load_or_make(path)?;
        let is_kept = !matches!(fault, Some(StorageFault::Unwritable { .. }));
        Ok((Self { now: Arc::new(RwLock::new(tokens)), file: is_kept.then(|| path.to_owned()) }, fault))
    }

    /// The tokens in effect.
    pub fn now(&self) -> Tokens {
        self.now.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Reloads the file; returns the roles whose tokens have changed. Blocks on disk access.
    ///
    /// # Errors
    /// When the file cannot be used; the tokens stay in effect.
    pub fn look(&self) -> io::Result<Vec<Role>> {
        let Some(path) = &self.file else { return Ok(Vec::new()) };
        let read = Tokens::load_or_create(path)?;
        let before = std::mem::replace(&mut *self.now.write().unwrap_or_else(PoisonError::into_inner), read.clone());
        let changed =
            [(Role::Viewer, before.viewer != read.viewer), (Role::Operator, before.operator != read.operator)];
        Ok(changed.into_iter().filter_map(|(role, has_changed)| has_changed.then_some(role)).collect())
    }
}

/// Wrong tokens of one address without a delay.
const FREE_TRIES: u32 = 10;
/// First delay after those; it doubles with each further one …
const FIRST_WAIT: Duration = Duration::from_secs(1);
/// … up to this.
const LONGEST_WAIT: Duration = Duration::from_secs(60);
/// Time without a wrong token after which an address is forgiven.
const FORGIVEN_AFTER: Duration = Duration::from_secs(15 * 60);
/// Largest number of remembered addresses; the one whose last wrong token is oldest makes room.
const MAX_ADDRESSES: usize = 1024;

/// Rate limit for wrong tokens, by address. During a delay, no token of the address is checked, right or wrong;
/// otherwise it could go on guessing. Open sessions are not affected.
#[derive(Debug, Default)]
pub struct Throttle {
    wrong: Mutex<HashMap<IpAddr, (u32, MonoTime)>>,
}

impl Throttle {
    /// Delay until the next token of an address is checked; `None` without a delay.
    pub fn wait(&self, from: IpAddr, now: MonoTime) -> Option<Duration> {
        let wrong = self.wrong.lock().unwrap_or_else(PoisonError::into_inner);
        let (count, last) = wrong.get(&from)?;
        let further = count.checked_sub(FREE_TRIES)?;
        let wait = FIRST_WAIT.saturating_mul(1 << further.min(16)).min(LONGEST_WAIT);
        wait.checked_sub(now.since(*last)).filter(|wait| !wait.is_zero())
    }

    /// Records a wrong token of an address.
    pub fn wrong(&self, from: IpAddr, now: MonoTime) {
        let mut wrong = self.wrong.lock().unwrap_or_else(PoisonError::into_inner);
        wrong.retain(|_, (_, last)| now.since(*last) < FORGIVEN_AFTER);
        if wrong.len() >= MAX_ADDRESSES
            && !wrong.contains_key(&from)
            && let Some(oldest) = wrong.iter().min_by_key(|(_, (_, last))| *last).map(|(from, _)| *from)
        {
            wrong.remove(&oldest);
        }
        let (count, last) = wrong.entry(from).or_insert((0, now));
        (*count, *last) = (count.saturating_add(1), now);
    }

    /// Records a right token of an address.
    pub fn right(&self, from: IpAddr) {
        self.wrong.lock().unwrap_or_else(PoisonError::into_inner).remove(&from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> PathBuf {
        std::env::temp_dir().join(format!("vencejo-tokens-{}", random_secret().expect("random")))
    }

    #[test]
    fn tokens_are_kept_for_their_owner_alone() {
        let folder = folder();
        let path = folder.join("access.json");
        let made = Tokens::load_or_create(&path).expect("made");
        assert_eq!(Tokens::load_or_create(&path).expect("read"), made);
        assert_ne!(made.viewer, made.operator);
        assert_eq!(made.role(&made.viewer), Some(Role::Viewer));
        assert_eq!(made.role(&made.operator), Some(Role::Operator));
        assert_eq!(made.role(""), None);
        assert_eq!(made.role(&made.operator[1..]), None);
        assert!(!format!("{made:?}").contains(&made.operator));
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = |path: &Path| std::fs::metadata(path).expect("there").permissions().mode() & 0o777;
            assert_eq!(mode(&path), 0o600);
            std::fs::set_permissions(&path, PermissionsExt::from_mode(0o644)).expect("set");
            Tokens::load_or_create(&path).expect("read");
            assert_eq!(mode(&path), 0o600);
        }
        std::fs::write(&path, r#"{"viewer": "a", "operator": "b"}"#).expect("written");
        assert!(Tokens::load_or_create(&path).is_err(), "guessable ones are refused");
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn what_a_file_holds_no_more_is_revoked() {
        let folder = folder();
        let path = folder.join("access.json");
        let (store, fault) = TokenStore::open(&path).expect("made");
        assert_eq!(fault, None);
        let before = store.now();
        assert_eq!(store.look().expect("there"), [], "nothing changed");
        let renewed = Tokens::renew(&path, false, true).expect("renewed");
        assert_eq!((&renewed.viewer, store.look().expect("there")), (&before.viewer, vec![Role::Operator]));
        assert_eq!(store.now(), renewed);
        assert_eq!(store.now().role(&before.operator), None);
        std::fs::write(&path, "half a fi").expect("written");
        store.look().expect_err("said");
        assert_eq!(store.now(), renewed, "a file that cannot be read locks nobody out");
        std::fs::remove_file(&path).expect("removed");
        assert_eq!(store.look().expect("made"), [Role::Viewer, Role::Operator]);
        assert_eq!(Tokens::load_or_create(&path).expect("there"), store.now());
        let left: Vec<_> = std::fs::read_dir(&folder).expect("there").collect();
        assert_eq!(left.len(), 1, "{left:?}");
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn whoever_guesses_waits_and_nobody_else() {
        let throttle = Throttle::default();
        let (guesser, other) = (IpAddr::from([192, 0, 2, 1]), IpAddr::from([192, 0, 2, 2]));
        let mut now = MonoTime::ZERO;
        for _ in 0..FREE_TRIES {
            assert_eq!(throttle.wait(guesser, now), None);
            throttle.wrong(guesser, now);
        }
        let mut tried = 0;
        for _ in 0..3600 {
            now += Duration::from_secs(1);
            if throttle.wait(guesser, now).is_none() {
                throttle.wrong(guesser, now);
                tried += 1;
            }
            assert_eq!(throttle.wait(other, now), None);
        }
        assert!((55..=70).contains(&tried), "{tried} in an hour");
        assert_eq!(throttle.wait(guesser, now + FORGIVEN_AFTER), None);
        throttle.right(guesser);
        assert_eq!(throttle.wait(guesser, now), None);
        for number in 0..3000_u16 {
            let [high, low] = number.to_be_bytes();
            throttle.wrong(IpAddr::from([10, 0, high, low]), now);
        }
        assert_eq!(throttle.wrong.lock().expect("whole").len(), MAX_ADDRESSES);
    }
}
