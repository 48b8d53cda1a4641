//! How much of the disk stays free: one floor for each class of what is written, in the order in which they have to
//! stop. Maps stop first, then video, and the flight recorder last.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use thiserror::Error;

/// Bytes of a megabyte.
const MB: u64 = 1_000_000;
/// The largest floor.
pub const MAX_FLOOR_MB: u64 = 10_000_000;

/// A class of what is written, by which it has to stop when the disk fills up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Class {
    /// Map tiles, offline areas, and files that are handed in.
    Maps,
    /// Recordings and pictures of cameras.
    Video,
    /// The flight recorder.
    Telemetry,
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Maps => "maps",
            Self::Video => "video",
            Self::Telemetry => "telemetry",
        })
    }
}

/// Free space of the disk below which each class is no longer written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Floors {
    maps_bytes: u64,
    video_bytes: u64,
    telemetry_bytes: u64,
}

/// Floors that cannot be.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BadFloors {
    /// One is larger than any disk of ours.
    #[error("the floor of {class} is {mb} MB, should be 0 to {MAX_FLOOR_MB}")]
    OutOfRange {
        /// Which.
        class: Class,
        /// As it was given.
        mb: u64,
    },
    /// The flight recorder would not be the last to stop.
    #[error(
        "floors of {maps} MB for maps, {video} MB for video and {telemetry} MB for telemetry: maps have to stop first and the \
         flight recorder last, so they must not grow in this order"
    )]
    WrongOrder {
        /// MB.
        maps: u64,
        /// MB.
        video: u64,
        /// MB.
        telemetry: u64,
    },
}

impl Default for Floors {
    /// 2 GB for maps, 1 GB for video, 500 MB for telemetry.
    fn default() -> Self {
        Self { maps_bytes: 2_000 * MB, video_bytes: 1_000 * MB, telemetry_bytes: 500 * MB }
    }
}

impl Floors {
    /// Floors in megabytes (of 1,000,000 bytes), 0 to 10,000,000 each.
    ///
    /// # Errors
    /// [`BadFloors`] for one out of range, or when the flight recorder were not the last to stop.
    pub fn from_mb(maps: u64, video: u64, telemetry: u64) -> Result<Self, BadFloors> {
        for (class, mb) in [(Class::Maps, maps), (Class::Video, video), (Class::Telemetry, telemetry)] {
            if mb > MAX_FLOOR_MB {
                return Err(BadFloors::OutOfRange { class, mb });
            }
        }
        if maps < video || video < telemetry {
            return Err(BadFloors::WrongOrder { maps, video, telemetry });
        }
        Ok(Self { maps_bytes: maps * MB, video_bytes: video * MB, telemetry_bytes: telemetry * MB })
    }

    /// The floor of a class, bytes.
    pub const fn bytes(&self, class: Class) -> u64 {
        match class {
            Class::Maps => self.maps_bytes,
            Class::Video => self.video_bytes,
            Class::Telemetry => self.telemetry_bytes,
        }
    }
}

/// The disk is too full for a class.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "only {} MB are free on the disk of {}, and {} MB stay free of {class}: delete something, or lower that floor",
    free_bytes / MB, path.display(), floor_bytes / MB
)]
pub struct LowSpace {
    /// What was to be written.
    pub class: Class,
    /// Where.
    pub path: PathBuf,
    /// Free bytes.
    pub free_bytes: u64,
    /// Free bytes that are needed.
    pub floor_bytes: u64,
}

impl From<LowSpace> for io::Error {
    fn from(error: LowSpace) -> Self {
        Self::new(io::ErrorKind::StorageFull, error)
    }
}

type Probe = Arc<dyn Fn(&Path) -> io::Result<u64> + Send + Sync>;

/// The disk's free space against the floors. Clones look at the same.
#[derive(Clone)]
pub struct Space {
    floors: Floors,
    probe: Probe,
}

impl fmt::Debug for Space {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Space").field("floors", &self.floors).finish_non_exhaustive()
    }
}

impl PartialEq for Space {
    fn eq(&self, other: &Self) -> bool {
        self.floors == other.floors && Arc::ptr_eq(&self.probe, &other.probe)
    }
}

impl Default for Space {
    fn default() -> Self {
        Self::new(Floors::default())
    }
}

impl Space {
    /// This machine's disks.
    pub fn new(floors: Floors) -> Self {
        Self::with_probe(floors, free_bytes)
    }

    /// Disks that something else tells about, as tests do.
    pub fn with_probe(floors: Floors, probe: impl Fn(&Path) -> io::Result<u64> + Send + Sync + 'static) -> Self {
        Self { floors, probe: Arc::new(probe) }
    }

    /// The floors.
    pub const fn floors(&self) -> Floors {
        self.floors
    }

    /// Free space for us on the disk of a path, which need not exist yet.
    ///
    /// # Errors
    /// Whatever the disk says.
    pub fn free_bytes(&self, path: &Path) -> io::Result<u64> {
        (self.probe)(path)
    }

    /// Whether something of a class may be written below a path, which need not exist yet.
    ///
    /// # Errors
    /// [`LowSpace`] when it is not to be. A disk that cannot say is tried: writing will tell.
    pub fn check(&self, class: Class, path: &Path) -> Result<(), LowSpace> {
        let floor_bytes = self.floors.bytes(class);
        match self.free_bytes(path) {
            Ok(free_bytes) if free_bytes < floor_bytes => {
                Err(LowSpace { class, path: path.to_owned(), free_bytes, floor_bytes })
            }
            _ => Ok(()),
        }
    }
}

/// Free space for us on the disk of a path, or of the nearest folder above it that exists.
///
/// # Errors
/// Whatever the disk says.
pub fn free_bytes(path: &Path) -> io::Result<u64> {
    #[cfg(unix)]
    {
        let existing = path.ancestors().find(|path| path.exists()).unwrap_or(Path::new("."));
        let facts = rustix::fs::statvfs(existing)?;
        Ok(facts.f_bavail.saturating_mul(facts.f_frsize))
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        Ok(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Class; 3] = [Class::Maps, Class::Video, Class::Telemetry];

    fn stopped(free_mb: u64) -> Vec<Class> {
        let space = Space::with_probe(Floors::default(), move |_| Ok(free_mb * MB));
        ALL.into_iter().filter(|class| space.check(*class, Path::new("/data")).is_err()).collect()
    }

    #[test]
    fn the_flight_recorder_is_the_last_to_stop() {
        assert_eq!(stopped(2_000), []);
        assert_eq!(stopped(1_999), [Class::Maps]);
        assert_eq!(stopped(999), [Class::Maps, Class::Video]);
        assert_eq!(stopped(499), ALL);
    }

    #[test]
    fn an_order_in_which_it_were_not_is_refused() {
        assert_eq!(Floors::from_mb(2_000, 1_000, 500), Ok(Floors::default()));
        Floors::from_mb(0, 0, 0).expect("none at all");
        assert!(matches!(Floors::from_mb(100, 200, 50), Err(BadFloors::WrongOrder { .. })));
        assert!(matches!(Floors::from_mb(300, 200, 250), Err(BadFloors::WrongOrder { .. })));
        let error = Floors::from_mb(MAX_FLOOR_MB + 1, 1, 1).expect_err("out of range");
        assert!(error.to_string().contains("maps"), "{error}");
    }

    #[test]
    fn a_disk_that_cannot_say_is_tried_and_ours_can_say() {
        let space = Space::with_probe(Floors::default(), |_| Err(io::ErrorKind::PermissionDenied.into()));
        space.check(Class::Telemetry, Path::new("/data")).expect("tried");
        assert!(free_bytes(&std::env::temp_dir().join("not/there/yet")).expect("told") > 0);
    }

    #[test]
    fn the_refusal_says_where_how_much_and_what_to_do() {
        let space = Space::with_probe(Floors::default(), |_| Ok(900 * MB));
        let error = space.check(Class::Maps, Path::new("/data/maps")).expect_err("too full");
        let text = error.to_string();
        assert!(text.contains("900 MB") && text.contains("/data/maps") && text.contains("2000 MB"), "{text}");
        assert_eq!(io::Error::from(error).kind(), io::ErrorKind::StorageFull);
    }
}
