//! One source in use: its grid, the addresses of its tiles, its cache, its fetches under way and how it fares.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::Serialize;
use tokio::sync::watch;
use utoipa::ToSchema;

use crate::aside::{Asides, Reading};
use crate::cache::Cache;
use crate::error::{MapError, Result, SourceCause};
use crate::grid::{TileGrid, TileId};
use crate::kind::Opening;
use crate::live::Live;
use crate::settings::{Caching, SourceSettings};
use crate::shown::Shown;
use crate::stamp;
use crate::task::FAILED_INSIDE;
use crate::tile::Tile;

/// Tiles that failed lately and are not asked for again at once.
const MAX_FAILED: usize = 2000;
/// For how long.
const FAILED_S: i64 = 15;
/// Silences of a service after which it is left alone for a while.
const SILENCES: u32 = 3;

/// Status of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MapSourceStatus)]
pub enum Status {
    /// Not asked yet.
    Unused,
    /// The last thing it did was right.
    Ok,
    /// The last thing it did was wrong.
    Failing,
    /// It is not reached.
    Offline,
    /// It cannot be used as it is configured.
    Invalid,
    /// It needs the user's key.
    KeyMissing,
    /// The program ended while it was read: it is left alone until its file changes or it is tried again on request.
    SetAside,
}

/// How a source fares.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = MapSourceState)]
pub struct SourceState {
    /// In a word.
    pub status: Status,
    /// Why, in the service's words where it gave some.
    #[schema(required = true)]
    pub detail: Option<String>,
    /// Why, for a sentence in another language; null where all is well, and where it is set aside.
    #[schema(required = true)]
    pub cause: Option<SourceCause>,
    /// Seconds since 1970.
    #[schema(required = true)]
    pub last_success_at: Option<i64>,
    /// Seconds since 1970.
    #[schema(required = true)]
    pub last_error_at: Option<i64>,
    /// The newest error, though it may be over.
    #[schema(required = true)]
    pub last_error: Option<String>,
    /// Tiles that came from the service.
    pub fetched: u64,
    /// Tiles that the service said to be unchanged.
    pub revalidated: u64,
    /// Tiles from the cache.
    pub hits: u64,
    /// Old tiles that were shown since the service failed.
    pub stale: u64,
    /// Tiles that could not be had.
    pub failed: u64,
    /// Bytes that came from the service.
    pub bytes_fetched: u64,
    /// Its cache; null without one.
    #[schema(required = true)]
    pub cache: Option<CacheState>,
}

/// How full a source's cache is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = MapCacheState)]
pub struct CacheState {
    /// Tiles, absent ones included.
    pub tiles: u64,
    /// On disk.
    pub bytes: u64,
    /// Tiles of offline areas, which are never dropped.
    pub pinned_tiles: u64,
    /// Bytes at most, but for offline areas.
    pub max_bytes: u64,
}

/// A while by the time of day. When that is set back to before it began the while is over: it could last for as long as
/// the step.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Term {
    from_s: i64,
    until_s: i64,
}

impl Term {
    /// So many seconds from now on.
    pub(crate) const fn new(now_s: i64, seconds: i64) -> Self {
        Self { from_s: now_s, until_s: now_s.saturating_add(seconds) }
    }

    /// Seconds that are left of it; `None` when it is over.
    pub(crate) fn left_s(self, now_s: i64) -> Option<u64> {
        (self.from_s..self.until_s).contains(&now_s).then(|| self.until_s.abs_diff(now_s))
    }
}

#[derive(Debug, Default)]
struct Health {
    /// Whether the last request failed; the times in seconds cannot show which came last.
    is_failing: bool,
    last_success_s: Option<i64>,
    last_error_s: Option<i64>,
    last_error: Option<MapError>,
    /// Term for which it is left alone.
    rest: Term,
    /// Failures of the network in a row.
    silences: u32,
    failed: HashMap<TileId, (Term, MapError)>,
}

/// Counters of a source.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    pub fetched: AtomicU64,
    pub revalidated: AtomicU64,
    pub hits: AtomicU64,
    pub stale: AtomicU64,
    pub failed: AtomicU64,
    pub bytes: AtomicU64,
}

/// Adds to a count.
pub(crate) fn count(counter: &AtomicU64, by: u64) {
    counter.fetch_add(by, Ordering::Relaxed);
}

/// A fetch in flight; its result goes to all waiters.
pub(crate) type InFlight = Arc<watch::Sender<Option<Result<Tile>>>>;

/// One source in use.
pub struct Source {
    /// As configured, key included.
    pub(crate) settings: SourceSettings,
    pub(crate) live: Live,
    pub(crate) cache: Option<Arc<Cache>>,
    pub(crate) shown: Shown,
    pub(crate) counts: Counts,
    pub(crate) in_flight: Mutex<HashMap<TileId, InFlight>>,
    /// Held while its capabilities are read.
    pub(crate) loading: tokio::sync::Mutex<()>,
    health: Mutex<Health>,
    asides: Arc<Asides>,
    /// Whether it was set aside when it was to be opened.
    is_aside: bool,
    /// Its file or folder, and what it was when it was opened.
    files: Option<(PathBuf, Option<u64>)>,
    /// Told when it begins to fail or works again.
    news: watch::Sender<u64>,
}

impl std::fmt::Debug for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Source").field("id", &self.settings.id).finish_non_exhaustive()
    }
}

impl Source {
    /// Gets a source ready. Blocks: files are opened.
    pub(crate) fn open(
        settings: SourceSettings,
        folder: &Path,
        cache: Option<Arc<Cache>>,
        asides: Arc<Asides>,
        news: watch::Sender<u64>,
    ) -> Self {
        let is_aside = asides.has(&settings);
        // Before it is opened, so that a change meanwhile is noticed.
        let files = settings.path.as_ref().map(|path| folder.join(path)).map(|path| {
            let stamp = stamp::of_all(&path);
            (path, stamp)
        });
        let live = if is_aside {
            Live::Unusable(SET_ASIDE.to_owned())
        } else if let Some(fault) = settings.datum_fault() {
            Live::Unusable(fault)
        } else {
            let _reading = asides.reading(&settings);
            let opening = Opening { settings: &settings, folder, cache: cache.as_ref(), asides: &asides };
            // One file's fault is not that of the others.
            let ready = || settings.kind.driver().open(&opening);
            let ready = std::panic::catch_unwind(std::panic::AssertUnwindSafe(ready));
            ready.unwrap_or_else(|_| Err(FAILED_INSIDE.to_owned())).unwrap_or_else(Live::Unusable)
        };
        Self {
            settings,
            live,
            cache,
            shown: Shown::default(),
            counts: Counts::default(),
            in_flight: Mutex::default(),
            loading: tokio::sync::Mutex::default(),
            health: Mutex::default(),
            asides,
            is_aside,
            files,
            news,
        }
    }

    /// Notes that something that others wrote is read of it, until the value is dropped.
    pub(crate) fn reading(&self) -> Reading {
        self.asides.reading(&self.settings)
    }

    /// Whether it is to be reopened: its files have changed, or it was set aside or released. Blocks.
    pub(crate) fn is_outdated(&self) -> bool {
        let has_others = self.files.as_ref().is_some_and(|(path, opened)| stamp::of_all(path) != *opened);
        has_others || self.is_aside != self.asides.has(&self.settings)
    }

    /// The grid of its tiles, as far as it is known.
    pub(crate) fn grid(&self) -> Option<Arc<TileGrid>> {
        self.live.grid()
    }

    /// That it cannot be used.
    pub(crate) fn unusable(&self, reason: impl Into<String>) -> MapError {
        self.settings.unusable(reason)
    }

    /// Whether anything of it may be kept.
    pub(crate) fn is_kept(&self) -> bool {
        self.settings.cache != Caching::None
    }

    fn health(&self) -> MutexGuard<'_, Health> {
        self.health.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes that the service did what it was asked for.
    pub(crate) fn succeeded(&self, tile: Option<TileId>, now_s: i64) {
        let mut health = self.health();
        if std::mem::take(&mut health.is_failing) {
            self.news.send_modify(|count| *count = count.wrapping_add(1));
        }
        health.last_success_s = Some(now_s);
        (health.rest, health.silences) = (Term::default(), 0);
        if let Some(tile) = tile {
            health.failed.remove(&tile);
        }
    }

    /// Notes an error, and leaves the service alone where that helps.
    pub(crate) fn failed(&self, tile: Option<TileId>, error: &MapError, retry_after: Option<Duration>, now_s: i64) {
        count(&self.counts.failed, 1);
        let mut health = self.health();
        if !std::mem::replace(&mut health.is_failing, true) {
            self.news.send_modify(|count| *count = count.wrapping_add(1));
        }
        health.last_error_s = Some(now_s);
        health.last_error = Some(error.clone());
        if error.is_network() {
            health.silences = health.silences.saturating_add(1);
            let is_sure = matches!(error, MapError::Offline { .. }) || health.silences >= SILENCES;
            if is_sure {
                // 5, 10, 20, 40, 60 s.
                let wait_s = 5_i64 << health.silences.saturating_sub(1).min(4);
                health.rest = Term::new(now_s, wait_s.min(60));
            }
        } else {
            health.silences = 0;
        }
        if let Some(wait) = retry_after {
            health.rest = Term::new(now_s, i64::try_from(wait.as_secs()).unwrap_or(i64::MAX).clamp(1, 300));
        }
        if let Some(tile) = tile {
            if health.failed.len() >= MAX_FAILED {
                health.failed.retain(|_, (rest, _)| rest.left_s(now_s).is_some());
                if health.failed.len() >= MAX_FAILED {
                    health.failed.clear();
                }
            }
            health.failed.insert(tile, (Term::new(now_s, FAILED_S), error.clone()));
        }
    }

    /// Why a tile is not asked for now, when it is not.
    pub(crate) fn refusal(&self, tile: TileId, now_s: i64) -> Option<MapError> {
        let health = self.health();
        if let Some(retry) = health.rest.left_s(now_s) {
            return health.last_error.clone().map(|error| match error {
                MapError::Offline { host, why, reason, .. } => MapError::Offline { host, why, reason, retry_s: retry },
                other => other,
            });
        }
        health.failed.get(&tile).filter(|(rest, _)| rest.left_s(now_s).is_some()).map(|(_, error)| error.clone())
    }

    /// Forgets that it failed.
    pub(crate) fn try_again(&self) {
        let mut health = self.health();
        (health.rest, health.silences) = (Term::default(), 0);
        health.failed.clear();
    }

    /// How it fares. Blocks: the cache is asked.
    pub(crate) fn state(&self) -> SourceState {
        let cache = self.cache.as_ref().and_then(|cache| {
            let fill = cache.fill().ok()?;
            Some(CacheState {
                tiles: fill.tiles,
                bytes: fill.bytes,
                pinned_tiles: fill.pinned_tiles,
                max_bytes: cache.max_bytes(),
            })
        });
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let hits = read(&self.counts.hits);
        let health = self.health();
        let last_error = health.last_error.as_ref().map(ToString::to_string);
        let mut cause = None;
        let (status, detail) = match &self.live {
            Live::Unusable(reason) if self.is_aside => (Status::SetAside, Some(reason.clone())),
            Live::Unusable(reason) => {
                cause = SourceCause::of(&self.unusable(reason.clone()));
                (Status::Invalid, Some(reason.clone()))
            }
            _ if self.settings.needs_key() && self.settings.key().is_none() => {
                let error = MapError::KeyMissing(self.settings.id.clone());
                cause = SourceCause::of(&error);
                (Status::KeyMissing, Some(error.to_string()))
            }
            _ if health.is_failing => {
                let is_network = health.last_error.as_ref().is_some_and(MapError::is_network);
                let is_unusable = matches!(health.last_error, Some(MapError::Unusable { .. }));
                let status = match (is_network, is_unusable) {
                    (true, _) => Status::Offline,
                    (_, true) => Status::Invalid,
                    _ => Status::Failing,
                };
                cause = health.last_error.as_ref().and_then(SourceCause::of);
                (status, last_error.clone())
            }
            _ if health.last_success_s.is_some() || hits > 0 => (Status::Ok, None),
            _ => (Status::Unused, None),
        };
        SourceState {
            status,
            detail,
            cause,
            last_success_at: health.last_success_s,
            last_error_at: health.last_error_s,
            last_error,
            fetched: read(&self.counts.fetched),
            revalidated: read(&self.counts.revalidated),
            hits,
            stale: read(&self.counts.stale),
            failed: read(&self.counts.failed),
            bytes_fetched: read(&self.counts.bytes),
            cache,
        }
    }
}

/// Why a source that is set aside is not read.
const SET_ASIDE: &str = "the program ended while it read this, so it is not read any more: replace the file, or have it tried once \
                         more (POST …/check)";
