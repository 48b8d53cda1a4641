//! The right to read a file, change what was read and write it again, among all processes that share a folder.

use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::whole::{folder_of, make_folder};

/// How long a change may wait for others, unless said otherwise: each takes milliseconds.
pub const PATIENCE: Duration = Duration::from_secs(10);
/// How often it is tried.
const INTERVAL: Duration = Duration::from_millis(5);

/// A lock of the system's, held until this is dropped or the process ends, however it ends.
///
/// It is that of a file beside, which stays: a file that is replaced cannot carry its own lock.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

impl Lock {
    /// Waits for the right to change the file of a path.
    ///
    /// # Errors
    /// [`io::ErrorKind::TimedOut`] when others hold it for longer than `patience`; whatever the disk says.
    pub fn of(path: &Path, patience: Duration) -> io::Result<Self> {
        let give_up_at = Instant::now() + patience;
        loop {
            if let Some(lock) = Self::try_of(path)? {
                return Ok(lock);
            }
            if Instant::now() >= give_up_at {
                let text = format!("another program has been changing {} for {patience:?}", path.display());
                return Err(io::Error::new(io::ErrorKind::TimedOut, text));
            }
            std::thread::sleep(INTERVAL);
        }
    }

    /// The right to change the file of a path; `None` while another holds it.
    ///
    /// # Errors
    /// Whatever the disk says.
    pub fn try_of(path: &Path) -> io::Result<Option<Self>> {
        let beside = path_of(path)?;
        make_folder(folder_of(&beside))?;
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(beside)?;
        Ok(if try_hold(&file)? { Some(Self { _file: file }) } else { None })
    }
}

/// Takes the lock of an open file itself, for one that is never replaced; `false` while another holds it. It ends with
/// the file.
///
/// # Errors
/// Whatever the disk says.
pub fn try_hold(file: &File) -> io::Result<bool> {
    match file.try_lock() {
        Ok(()) => Ok(true),
        Err(TryLockError::WouldBlock) => Ok(false),
        // A disk without locks, as some in a network are: one instance works, as it did before there were any.
        Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => Ok(true),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

fn path_of(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or_else(|| io::Error::other(format!("{} names no file", path.display())))?;
    Ok(folder_of(path).join(format!(".{}.lock", name.to_string_lossy())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Scratch;
    use crate::whole::{Access, write};

    #[test]
    fn many_writers_lose_nothing() {
        let folder = Scratch::new("lock");
        let path = folder.path().join("count");
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..25 {
                        let _lock = Lock::of(&path, Duration::from_secs(60)).expect("held");
                        let before = std::fs::read_to_string(&path).unwrap_or_else(|_| "0".to_owned());
                        let next = before.parse::<u32>().expect("a number") + 1;
                        write(&path, next.to_string().as_bytes(), Access::Owner).expect("written");
                    }
                });
            }
        });
        assert_eq!(std::fs::read_to_string(&path).expect("there"), "200");
    }

    #[test]
    fn who_holds_it_too_long_is_named() {
        let folder = Scratch::new("held");
        let path = folder.path().join("sources.toml");
        let held = Lock::of(&path, Duration::ZERO).expect("held");
        let error = Lock::of(&path, Duration::ZERO).expect_err("another has it");
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
        assert!(error.to_string().contains("sources.toml"), "{error}");
        drop(held);
        Lock::of(&path, Duration::ZERO).expect("free again");
    }
}
