//! Serving tiles: from a source's file, its cache or its service, and caching them.

use std::sync::{Arc, PoisonError};
use std::time::Duration;

use tokio::sync::watch;

use crate::cache::CachedTile;
use crate::error::{MapError, Result};
use crate::grid::TileId;
use crate::live::{Live, Reply, TileFile};
use crate::net::Freshness;
use crate::service::Maps;
use crate::settings::{Caching, SourceSettings};
use crate::shown::Found;
use crate::sniff::{self, Picture};
use crate::source::{InFlight, Source, SourceState, count};
use crate::task::blocking;
use crate::tile::{Origin, Tile};

/// Fetches of one source that wait or run at most.
const MAX_IN_FLIGHT: usize = 512;
/// Default lifetime of a tile.
const USUAL_LIFETIME: Duration = Duration::from_secs(7 * 86_400);
/// Lifetime of a missing tile.
const NONE_LIFETIME: Duration = Duration::from_secs(86_400);
/// How long browsers may show a tile without asking.
const BROWSER_S: i64 = 3600;
/// How long a tile of a file is shown without reading it again, by us and by browsers together: a file may be replaced
/// at any time.
const FILE_S: i64 = 60;

impl Maps {
    /// A tile of a source, from its file, its cache or its service.
    ///
    /// # Errors
    /// [`MapError`] of nearly every kind; [`MapError::NoTile`] where there is nothing to draw.
    pub async fn tile(&self, id: &str, tile: TileId) -> Result<Tile> {
        let source = self.source(id)?;
        let served = self.serve(&source, tile).await;
        // A replaced file is reopened by the first request that fails, at most once every few seconds.
        if matches!(&source.live, Live::File(..)) && served.as_ref().is_err_and(|error| *error != MapError::NoTile) {
            self.refresh().await?;
            let anew = self.source(id)?;
            if !Arc::ptr_eq(&anew, &source) {
                return self.serve(&anew, tile).await;
            }
        }
        served
    }

    pub(crate) async fn serve(&self, source: &Arc<Source>, tile: TileId) -> Result<Tile> {
        let now_s = self.now_s();
        if let Some(shown) = shown_lately(source, tile, now_s) {
            return Ok(shown);
        }
        if let Live::File(file, grid) = &source.live {
            return if grid.contains(tile) { self.read_file(source, file, tile).await } else { Err(MapError::NoTile) };
        }
        let grid = self.known_grid(source).await?;
        if !grid.contains(tile) {
            return Err(MapError::NoTile);
        }
        let kept = self.kept(source, tile, now_s).await;
        if let Some(kept) = &kept
            && kept.expires_s > now_s
        {
            count(&source.counts.hits, 1);
            let shown = show(kept, Origin::Hit, now_s)?;
            source.shown.put(tile, &shown, kept.expires_s, now_s);
            return Ok(shown);
        }
        if source.settings.needs_key() && source.settings.key().is_none() {
            return Err(MapError::KeyMissing(source.settings.id.clone()));
        }
        let result = match source.refusal(tile, now_s) {
            Some(error) => Err(error),
            None => self.join_fetch(source, tile, Want::Tile).await,
        };
        match result {
            Err(error) if error != MapError::NoTile => {
                // A stale tile is better than none, where caching is allowed.
                let old = kept.filter(|_| source.settings.cache == Caching::Keep);
                let shown = old.and_then(|kept| show(&kept, Origin::Stale, now_s).ok());
                if shown.is_some() {
                    count(&source.counts.stale, 1);
                }
                shown.ok_or(error)
            }
            other => other,
        }
    }

    async fn read_file(&self, source: &Arc<Source>, file: &Arc<dyn TileFile>, tile: TileId) -> Result<Tile> {
        let (reader, of) = (file.clone(), source.clone());
        let _turn = self.shared.readers.acquire().await.map_err(|_| MapError::Closed)?;
        let read = blocking(move || {
            let _reading = of.reading();
            Ok(reader.tile(tile)?.map(|data| (sniff::hash(&data), data)))
        })
        .await;
        let shown = read.and_then(|found| {
            let (hash, data) = found.ok_or(MapError::NoTile)?;
            let picture = Picture::of(&data);
            let picture =
                picture.ok_or_else(|| source.unusable(format!("tile {tile} is {}", sniff::describe(&data))))?;
            Ok(Tile { data, picture, hash, origin: Origin::File, max_age_s: FILE_S })
        });
        match shown {
            Err(error) if error != MapError::NoTile => {
                let error = source.unusable(error.to_string());
                source.failed(None, &error, None, self.now_s());
                Err(error)
            }
            other => {
                let now_s = self.now_s();
                source.succeeded(None, now_s);
                count(&source.counts.hits, 1);
                if let Ok(shown) = &other {
                    source.shown.put(tile, shown, now_s + FILE_S, now_s);
                }
                other
            }
        }
    }

    /// The cached tile. A cache read error is recorded and treated as a miss.
    async fn kept(&self, source: &Arc<Source>, tile: TileId, now_s: i64) -> Option<CachedTile> {
        let cache = source.cache.clone().filter(|_| source.is_kept())?;
        match blocking(move || cache.get(tile, now_s)).await {
            Ok(kept) => kept,
            Err(error) => {
                source.failed(None, &error, None, now_s);
                None
            }
        }
    }

    /// Joins the tile's fetch in flight, starting one if needed; it is cancelled when its last waiter goes.
    async fn join_fetch(&self, source: &Arc<Source>, tile: TileId, want: Want) -> Result<Tile> {
        let mut result = {
            let mut in_flight = source.in_flight.lock().unwrap_or_else(PoisonError::into_inner);
            match in_flight.get(&tile) {
                Some(fetch) => fetch.subscribe(),
                None if in_flight.len() >= MAX_IN_FLIGHT => return Err(MapError::Busy),
                None => {
                    let (fetch, result) = watch::channel(None);
                    let fetch = Arc::new(fetch);
                    in_flight.insert(tile, fetch.clone());
                    tokio::spawn(self.clone().run_fetch(source.clone(), tile, want, fetch));
                    result
                }
            }
        };
        let result = result.wait_for(Option::is_some).await.map_err(|_| MapError::Closed)?;
        result.clone().unwrap_or(Err(MapError::Closed))
    }

    async fn run_fetch(self, source: Arc<Source>, tile: TileId, want: Want, fetch: InFlight) {
        let mut closing = self.shared.closing.subscribe();
        // However it ends, its waiters are woken and the next fetch may start.
        let end = FinishOnDrop { source: source.clone(), tile, fetch: fetch.clone(), result: Err(MapError::Closed) };
        let result = tokio::select! {
            result = self.fetch(&source, tile, want) => result,
            () = abandoned(&source, tile, &fetch) => return,
            _ = closing.wait_for(|closing| *closing) => Err(MapError::Closed),
        };
        end.with(result);
    }

    /// Fetches a tile, and keeps it where it may be.
    async fn fetch(&self, source: &Arc<Source>, tile: TileId, want: Want) -> Result<Tile> {
        let mut now_s = self.now_s();
        let kept = match want {
            // It may have been cached meanwhile, by a fetch that ended before this one started.
            Want::Tile => self.kept(source, tile, now_s).await,
            Want::Answer => None,
        };
        if let Some(kept) = kept.as_ref().filter(|kept| kept.expires_s > now_s) {
            count(&source.counts.hits, 1);
            return show(kept, Origin::Hit, now_s);
        }
        let mut retry_after = None;
        let result = self.ask(source, tile, kept.as_ref(), &mut retry_after).await;
        now_s = self.now_s();
        match &result {
            Ok(_) | Err(MapError::NoTile) => source.succeeded(Some(tile), now_s),
            Err(error) => source.failed(Some(tile), error, retry_after, now_s),
        }
        result
    }

    async fn ask(
        &self,
        source: &Arc<Source>,
        tile: TileId,
        kept: Option<&CachedTile>,
        retry_after: &mut Option<Duration>,
    ) -> Result<Tile> {
        let Live::Service(service) = &source.live else { return Err(source.unusable("it is no service")) };
        let settings = &source.settings;
        let clock = || self.now_s();
        // While it waited for its turn the service may have fallen silent.
        let refusal = || source.refusal(tile, self.now_s());
        let asking = self.asking(source, &clock, &refusal);
        match service.tile(asking, tile, kept).await? {
            Reply::Same(mut renewed, freshness) => {
                let now_s = self.now_s();
                (renewed.fetched_s, renewed.expires_s) = (now_s, until(now_s, lifetime(settings, &freshness)));
                self.renew(source, tile, &renewed).await;
                count(&source.counts.revalidated, 1);
                show(&renewed, Origin::Revalidated, now_s)
            }
            Reply::None => self.none(source, tile, kept).await,
            Reply::New { data, etag, last_modified, freshness } => {
                let now_s = self.now_s();
                let mut new = CachedTile::new(data, now_s, lifetime(settings, &freshness));
                (new.etag, new.last_modified) = (etag, last_modified);
                count(&source.counts.fetched, 1);
                if may_keep(settings, &freshness) {
                    self.keep(source, tile, new.clone()).await;
                }
                show(&new, Origin::Fetched, now_s)
            }
            Reply::Refused(error, wait) => {
                *retry_after = wait;
                Err(error)
            }
        }
    }

    /// The service says that it has no tile there. A picture that was seen before is not given up for that: services
    /// that are being repaired say so as well; they are asked again after a while.
    async fn none(&self, source: &Arc<Source>, tile: TileId, kept: Option<&CachedTile>) -> Result<Tile> {
        let now_s = self.now_s();
        if let Some(old) = kept.filter(|kept| kept.data.is_some() && source.settings.cache == Caching::Keep) {
            let mut old = old.clone();
            old.expires_s = until(now_s, NONE_LIFETIME);
            self.renew(source, tile, &old).await;
            count(&source.counts.stale, 1);
            return show(&old, Origin::Stale, now_s);
        }
        self.keep(source, tile, CachedTile::new(None, now_s, NONE_LIFETIME)).await;
        Err(MapError::NoTile)
    }

    /// Notes until when a kept tile is new.
    async fn renew(&self, source: &Arc<Source>, tile: TileId, kept: &CachedTile) {
        let Some(cache) = source.cache.clone().filter(|_| source.is_kept()) else { return };
        let (fetched_s, expires_s) = (kept.fetched_s, kept.expires_s);
        let noted = blocking(move || cache.renew(tile, fetched_s, expires_s)).await;
        source.shown.forget(tile);
        self.tell_storage(source, noted);
    }

    /// Caches a fetched tile, where allowed. A write error is recorded; the tile is shown all the same.
    async fn keep(&self, source: &Arc<Source>, tile: TileId, kept: CachedTile) {
        let Some(cache) = source.cache.clone().filter(|_| source.is_kept()) else { return };
        let by_headers = source.settings.cache == Caching::Headers;
        let maps = self.clone();
        let noted = blocking(move || {
            maps.room()?;
            if by_headers {
                // Nothing stays beyond its time, seen or not.
                cache.drop_expired(kept.fetched_s)?;
                if kept.expires_s <= kept.fetched_s {
                    return Ok(());
                }
            }
            cache.put(tile, &kept)
        })
        .await;
        source.shown.forget(tile);
        self.tell_storage(source, noted);
    }

    fn tell_storage(&self, source: &Source, noted: Result<()>) {
        if let Err(error) = noted {
            tracing::warn!(%error, source = source.settings.id, "a tile could not be kept");
            source.failed(None, &error, None, self.now_s());
        }
    }

    /// Asks a source for one tile now, past its cache.
    ///
    /// # Errors
    /// [`MapError::NoSource`]; what fails is in the state.
    pub async fn check(&self, id: &str) -> Result<SourceState> {
        self.shared.asides.forgive(id);
        let source = self.source(id)?;
        let is_outdated = blocking(move || Ok(source.is_outdated())).await?;
        if is_outdated {
            self.reload().await?;
        }
        let source = self.source(id)?;
        source.try_again();
        if let Ok(grid) = self.known_grid(&source).await {
            let level = f64::midpoint(f64::from(grid.min_level), f64::from(grid.max_level)) as u8;
            let is_locked = source.settings.needs_key() && source.settings.key().is_none();
            if let Some(tile) = grid.middle(level).filter(|_| !is_locked) {
                let checked = match &source.live {
                    Live::File(..) => self.serve(&source, tile).await,
                    _ => self.join_fetch(&source, tile, Want::Answer).await,
                };
                // Tiles that failed meanwhile may be requested again too.
                if checked.is_ok() {
                    source.try_again();
                }
            }
        }
        blocking(move || Ok(source.state())).await
    }

    /// The file of a source of kind image.
    ///
    /// # Errors
    /// [`MapError::Unusable`] for other kinds and files that cannot be read.
    pub async fn image(&self, id: &str) -> Result<Tile> {
        let source = self.source(id)?;
        let path = self.folder().join(source.settings.path.as_deref().unwrap_or_default());
        let driver = source.settings.kind.driver();
        let read = blocking(move || driver.picture(&path).transpose().map_err(MapError::Storage)).await;
        let read = read.map_err(|error| source.unusable(error.to_string()))?;
        let data = bytes::Bytes::from(read.ok_or_else(|| source.unusable("it is not a picture with corners"))?);
        let kind = Picture::of(&data).ok_or_else(|| source.unusable(format!("it is {}", sniff::describe(&data))))?;
        Ok(Tile { hash: sniff::hash(&data), data, picture: kind, origin: Origin::File, max_age_s: FILE_S })
    }
}

/// The end of a fetch, also of one whose task was torn off.
struct FinishOnDrop {
    source: Arc<Source>,
    tile: TileId,
    fetch: InFlight,
    result: Result<Tile>,
}

impl FinishOnDrop {
    fn with(mut self, result: Result<Tile>) {
        self.result = result;
    }
}

impl Drop for FinishOnDrop {
    fn drop(&mut self) {
        let mut in_flight = self.source.in_flight.lock().unwrap_or_else(PoisonError::into_inner);
        // An abandoned one is off the list, and another may have begun in its place.
        if in_flight.get(&self.tile).is_some_and(|fetch| Arc::ptr_eq(fetch, &self.fetch)) {
            in_flight.remove(&self.tile);
        }
        drop(in_flight);
        self.fetch.send_replace(Some(std::mem::replace(&mut self.result, Err(MapError::Closed))));
    }
}

/// Purpose of a fetch.
#[derive(Clone, Copy)]
enum Want {
    /// The tile, which the cache has perhaps by now.
    Tile,
    /// To hear whether the service answers.
    Answer,
}

/// Waits until a fetch has no waiters, and removes it from the list.
async fn abandoned(source: &Source, tile: TileId, fetch: &InFlight) {
    loop {
        fetch.closed().await;
        let mut in_flight = source.in_flight.lock().unwrap_or_else(PoisonError::into_inner);
        // Under the lock nobody can join, but a waiter may have joined before it was taken.
        if fetch.receiver_count() == 0 {
            in_flight.remove(&tile);
            return;
        }
    }
}

/// How long an answer is new here.
fn lifetime(settings: &SourceSettings, freshness: &Freshness) -> Duration {
    let said = freshness.lifetime;
    match settings.cache {
        Caching::Keep => {
            let least = Duration::from_secs(u64::from(settings.cache_min_days.unwrap_or(0)) * 86_400);
            said.unwrap_or(USUAL_LIFETIME).max(least)
        }
        Caching::Headers | Caching::None => said.unwrap_or_default(),
    }
}

/// Whether a service lets its answer be kept, or the settings say that it does.
fn may_keep(settings: &SourceSettings, freshness: &Freshness) -> bool {
    !freshness.no_store || settings.cache_min_days.is_some_and(|days| days > 0)
}

fn until(now_s: i64, lifetime: Duration) -> i64 {
    now_s.saturating_add(i64::try_from(lifetime.as_secs()).unwrap_or(i64::MAX / 4).min(i64::MAX / 4))
}

/// A tile from memory, while it is new.
fn shown_lately(source: &Source, id: TileId, now_s: i64) -> Option<Tile> {
    let Found { mut tile, left_s, is_to_be_noted } = source.shown.get(id, now_s)?;
    tile.max_age_s = left_s.min(BROWSER_S);
    count(&source.counts.hits, 1);
    match &source.cache {
        Some(cache) if is_to_be_noted => {
            cache.note_use(id, now_s);
        }
        Some(_) => {}
        None => source.succeeded(None, now_s),
    }
    Some(tile)
}

fn show(kept: &CachedTile, origin: Origin, now_s: i64) -> Result<Tile> {
    let data = kept.data.clone().ok_or(MapError::NoTile)?;
    let picture = Picture::of(&data).ok_or(MapError::NoTile)?;
    let max_age_s = if origin == Origin::Stale { 0 } else { (kept.expires_s - now_s).clamp(0, BROWSER_S) };
    Ok(Tile { data, picture, hash: kept.hash, origin, max_age_s })
}
