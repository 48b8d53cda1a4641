//! Offline areas: tiles fetched before a flight and kept. Their lists of tiles are in the caches, so that a crash loses
//! nothing: marked tiles are there, the others are looked for and fetched.

mod area;
mod store;

use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use rusqlite::params;
use tokio::sync::watch;
use tokio::task::JoinSet;

pub use area::{Area, AreaState, Estimate, LevelCount, NewArea};
pub(crate) use store::DONE;

use store::{FAILED, OPEN, add_area, areas_of, claimed, mark, open_tiles, set_running, set_state};

use crate::cache::Cache;

use crate::cover;

use crate::downloads::Rate;

use crate::error::{MapError, Result};

use crate::grid::TileId;

use crate::service::Maps;

use crate::source::Source;

use crate::task::blocking;

/// Tiles of an area at most.
pub const MAX_TILES: u64 = 500_000;
/// Bytes of a tile before any was measured: a JPEG of 256 pixels from above.
const USUAL_BYTES: u64 = 18_000;
/// How often at least it is written down how far an area is, while tiles come.
const NOTE_EVERY: Duration = Duration::from_secs(1);
/// Faults in a row after which an area gives up.
const MAX_FAULTS: u32 = 25;
/// How long an area waits for the network, at first and at most.
const WAIT: (Duration, Duration) = (Duration::from_secs(5), Duration::from_secs(60));

/// Outcome of a tile of an area.
enum Outcome {
    Here(u64),
    Fault(String),
    /// No network; the tile itself is not at fault.
    Silent(String),
}

impl Maps {
    /// Size of an area before it is fetched.
    ///
    /// # Errors
    /// [`MapError::NoSource`], [`MapError::Request`].
    pub async fn estimate_area(&self, wanted: &NewArea) -> Result<Estimate> {
        let source = self.source(&wanted.source)?;
        let refusal = source.settings.offline_refusal();
        let grid = self.known_grid(&source).await?;
        let (shape, levels) = (wanted.shape.clone(), wanted.min_level..=wanted.max_level);
        let cache = source.cache.clone();
        blocking(move || {
            let counts = cover::count(&grid, &shape, levels.clone(), MAX_TILES)?;
            let tiles: u64 = counts.iter().fold(0, |sum, (_, count)| sum.saturating_add(*count));
            let mut have = 0;
            if let Some(cache) = cache.as_ref().filter(|_| tiles <= MAX_TILES) {
                for tile in cover::tiles(&grid, &shape, levels.clone(), MAX_TILES)? {
                    have += u64::from(cache.has(tile)?);
                }
            }
            let measured = match &cache {
                Some(cache) => cache.mean_bytes(*levels.start(), *levels.end())?,
                None => None,
            };
            let tile_bytes = measured.unwrap_or(USUAL_BYTES);
            let refused = refusal
                .or_else(|| (tiles > MAX_TILES).then(|| MapError::AreaTooLarge { tiles, most: MAX_TILES }.to_string()))
                .or_else(|| (tiles == 0).then(|| "the source has nothing there".to_owned()));
            Ok(Estimate {
                tiles,
                have,
                bytes: (tiles - have.min(tiles)).saturating_mul(tile_bytes),
                tile_bytes,
                tile_bytes_measured: measured.is_some(),
                levels: counts.into_iter().map(|(level, tiles)| LevelCount { level, tiles }).collect(),
                max_tiles: MAX_TILES,
                refused,
            })
        })
        .await
    }

    pub(crate) fn cached_source(&self, id: &str) -> Result<(Arc<Source>, Arc<Cache>)> {
        let source = self.source(id)?;
        if let Some(reason) = source.settings.offline_refusal() {
            return Err(MapError::OfflineRefused { source_id: id.to_owned(), reason });
        }
        let cache = source.cache.clone().ok_or_else(|| source.unusable("its cache cannot be used"))?;
        Ok((source, cache))
    }

    /// Creates an area and starts fetching it.
    ///
    /// # Errors
    /// [`MapError::NoSource`], [`MapError::OfflineRefused`], [`MapError::AreaTooLarge`], [`MapError::Request`].
    pub async fn add_area(&self, wanted: NewArea) -> Result<Area> {
        let name = wanted.name.trim();
        if name.is_empty() || name.chars().count() > 100 {
            return Err(MapError::Request("name: takes 1 to 100 characters".to_owned()));
        }
        self.room()?;
        let (source, cache) = self.cached_source(&wanted.source)?;
        let grid = self.known_grid(&source).await?;
        let now_s = self.now_s();
        let id = {
            let cache = cache.clone();
            blocking(move || {
                let tiles = cover::tiles(&grid, &wanted.shape, wanted.min_level..=wanted.max_level, MAX_TILES)?;
                if tiles.is_empty() {
                    return Err(MapError::Request("the source has nothing there".to_owned()));
                }
                let id = new_id(&cache)?;
                add_area(&cache, &id, &wanted, &tiles, now_s)?;
                Ok(id)
            })
            .await?
        };
        self.notify_changes();
        self.run(&source, &cache, &id);
        self.area(&id).await
    }

    /// All areas of the configured sources, oldest first.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub async fn areas(&self) -> Result<Vec<Area>> {
        let sources = self.sources();
        let mut areas = blocking(move || {
            let mut all = Vec::new();
            for source in &sources {
                if let Some(cache) = &source.cache {
                    all.append(&mut areas_of(cache, &source.settings.id)?);
                }
            }
            all.sort_by(|a: &Area, b: &Area| (a.created_at, &a.id).cmp(&(b.created_at, &b.id)));
            Ok(all)
        })
        .await?;
        let rates = self.shared.areas.rates.lock().unwrap_or_else(PoisonError::into_inner);
        for area in &mut areas {
            if area.state == AreaState::Running {
                area.rate_tiles_s = rates.get(&area.id).and_then(|rate| rate.tiles_s);
            }
        }
        Ok(areas)
    }

    /// One area.
    ///
    /// # Errors
    /// [`MapError::NoArea`].
    pub async fn area(&self, id: &str) -> Result<Area> {
        let found = self.areas().await?.into_iter().find(|area| area.id == id);
        found.ok_or_else(|| MapError::NoArea(id.to_owned()))
    }

    pub(crate) async fn find(&self, id: &str) -> Result<(Area, Arc<Source>, Arc<Cache>)> {
        let area = self.area(id).await?;
        let source = self.source(&area.source)?;
        let cache = source.cache.clone().ok_or_else(|| MapError::NoArea(id.to_owned()))?;
        Ok((area, source, cache))
    }

    /// Stops fetching an area until it is resumed.
    ///
    /// # Errors
    /// [`MapError::NoArea`].
    pub async fn pause_area(&self, id: &str) -> Result<Area> {
        let (area, _, cache) = self.find(id).await?;
        self.stop(id);
        if area.state == AreaState::Running {
            let id = id.to_owned();
            blocking(move || set_state(&cache, &id, AreaState::Paused, None)).await?;
        }
        self.notify_changes();
        self.area(id).await
    }

    /// Goes on with an area, and tries again what failed.
    ///
    /// # Errors
    /// [`MapError::NoArea`], [`MapError::OfflineRefused`] when the source forbids it by now.
    pub async fn resume_area(&self, id: &str) -> Result<Area> {
        let (area, source, cache) = self.find(id).await?;
        self.cached_source(&area.source)?;
        let is_whole = area.done == area.tiles;
        if is_whole && !matches!(area.state, AreaState::Running | AreaState::Done) {
            // It was paused while its last tiles came.
            let name = id.to_owned();
            blocking(move || set_state(&cache, &name, AreaState::Done, None)).await?;
            self.notify_changes();
        } else if area.state != AreaState::Running && !is_whole {
            self.room()?;
            let (again, name) = (cache.clone(), id.to_owned());
            blocking(move || {
                again
                    .writer()
                    .execute("UPDATE area_tiles SET state=? WHERE area=? AND state=?", params![OPEN, name, FAILED])?;
                set_state(&again, &name, AreaState::Running, None)
            })
            .await?;
            source.try_again();
            self.run(&source, &cache, id);
            self.notify_changes();
        }
        self.area(id).await
    }

    /// Forgets an area; its tiles stay until they are the least recently used.
    ///
    /// # Errors
    /// [`MapError::NoArea`].
    pub async fn remove_area(&self, id: &str) -> Result<()> {
        let (_, _, cache) = self.find(id).await?;
        self.stop(id);
        let id = id.to_owned();
        blocking(move || {
            {
                let mut writer = cache.writer();
                let transaction = writer.transaction()?;
                transaction.execute("DELETE FROM area_tiles WHERE area=?", [&id])?;
                transaction.execute("DELETE FROM areas WHERE id=?", [&id])?;
                transaction.commit()?;
            }
            cache.shrink()
        })
        .await?;
        self.notify_changes();
        Ok(())
    }

    fn stop(&self, id: &str) {
        let stop = self.shared.areas.stops.lock().unwrap_or_else(PoisonError::into_inner).remove(id);
        if let Some((_, stop)) = stop {
            stop.send_replace(true);
        }
    }

    /// Stops the downloads of a source that goes away.
    pub(crate) async fn stop_areas_of(&self, source: &str) {
        for area in self.areas().await.unwrap_or_default() {
            if area.source == source {
                self.stop(&area.id);
            }
        }
    }

    /// Goes on with what was under way when the process ended.
    pub(crate) async fn resume_areas(&self) {
        match self.areas().await {
            Ok(areas) => {
                for area in areas.into_iter().filter(|area| area.state == AreaState::Running) {
                    if let Ok((source, cache)) = self.cached_source(&area.source) {
                        self.run(&source, &cache, &area.id);
                    }
                }
            }
            Err(error) => tracing::error!(%error, "offline areas cannot be resumed"),
        }
    }

    /// Fetches an area in a task of its own.
    fn run(&self, source: &Arc<Source>, cache: &Arc<Cache>, id: &str) {
        let (stop, stopped) = watch::channel(false);
        let run = self.shared.areas.runs.fetch_add(1, Ordering::Relaxed);
        {
            let mut stops = self.shared.areas.stops.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, before)) = stops.insert(id.to_owned(), (run, stop)) {
                before.send_replace(true);
            }
        }
        let (maps, source, cache, id) = (self.clone(), source.clone(), cache.clone(), id.to_owned());
        tokio::spawn(async move {
            let mut closing = maps.shared.closing.subscribe();
            let mut halt = stopped.clone();
            let result = tokio::select! {
                result = maps.download(&source, &cache, &id) => result,
                _ = halt.wait_for(|stop| *stop) => return,
                _ = closing.wait_for(|closing| *closing) => return,
            };
            if let Err(error) = result {
                tracing::error!(%error, area = id, "an offline area cannot be fetched");
                let (text, name) = (error.to_string(), id.clone());
                let _ = blocking(move || set_state(&cache, &name, AreaState::Failed, Some(&text))).await;
            }
            let mut stops = maps.shared.areas.stops.lock().unwrap_or_else(PoisonError::into_inner);
            // It may have been resumed already.
            if stops.get(&id).is_some_and(|(current, _)| *current == run) {
                stops.remove(&id);
            }
            drop(stops);
            maps.shared.areas.rates.lock().unwrap_or_else(PoisonError::into_inner).remove(&id);
            maps.notify_changes();
        });
    }

    async fn download(&self, source: &Arc<Source>, cache: &Arc<Cache>, id: &str) -> Result<()> {
        let Some(_claim) = claimed(cache, id).await? else { return Ok(()) };
        let _permit = self.shared.areas.gate.acquire().await.map_err(|_| MapError::Closed)?;
        let parallel = usize::from(source.settings.parallel.unwrap_or(4)).max(1);
        let mut wait = WAIT.0;
        let mut faults_in_a_row = 0_u32;
        let mut last_fault: Option<String> = None;
        loop {
            let (looked, name) = (cache.clone(), id.to_owned());
            let batch = blocking(move || open_tiles(&looked, &name)).await?;
            if batch.is_empty() {
                let area = self.area(id).await?;
                let detail = (area.failed > 0).then(|| {
                    let why = last_fault.clone().or(area.detail).unwrap_or_default();
                    format!("{} tiles could not be fetched ({why}); going on tries them again", area.failed)
                });
                let (end, name) = (cache.clone(), id.to_owned());
                return blocking(move || set_running(&end, &name, AreaState::Done, detail.as_deref()).map(drop)).await;
            }
            if let Err(low) = self.room() {
                let (end, name) = (cache.clone(), id.to_owned());
                let text = low.to_string();
                return blocking(move || set_running(&end, &name, AreaState::Failed, Some(&text)).map(drop)).await;
            }
            let began = Instant::now();
            let mut marks = Vec::with_capacity(batch.len());
            let (mut bytes, mut silence, mut count, mut noted_at) = (0, None, 0, began);
            let mut tasks: JoinSet<(TileId, Outcome)> = JoinSet::new();
            let mut left = batch.iter().copied();
            loop {
                while tasks.len() < parallel && silence.is_none() && faults_in_a_row < MAX_FAULTS {
                    let Some(tile) = left.next() else { break };
                    let (maps, source, cache) = (self.clone(), source.clone(), cache.clone());
                    tasks.spawn(async move { (tile, maps.ensure(&source, &cache, tile).await) });
                }
                let Some(ended) = tasks.join_next().await else { break };
                let (tile, outcome) = ended.map_err(|_| MapError::Closed)?;
                match outcome {
                    Outcome::Here(got) => {
                        bytes += got;
                        faults_in_a_row = 0;
                        marks.push((tile, DONE));
                    }
                    Outcome::Fault(why) => {
                        faults_in_a_row += 1;
                        last_fault = Some(why);
                        marks.push((tile, FAILED));
                    }
                    Outcome::Silent(why) => silence = Some(why),
                }
                if noted_at.elapsed() >= NOTE_EVERY && !marks.is_empty() {
                    count += marks.len();
                    if !self.note(cache, id, &mut marks, &mut bytes).await? {
                        return Ok(());
                    }
                    noted_at = Instant::now();
                }
            }
            count += marks.len();
            self.note(cache, id, &mut marks, &mut bytes).await?;
            if faults_in_a_row >= MAX_FAULTS {
                let text =
                    format!("{MAX_FAULTS} tiles in a row could not be fetched: {}", last_fault.unwrap_or_default());
                let (end, name) = (cache.clone(), id.to_owned());
                return blocking(move || set_running(&end, &name, AreaState::Failed, Some(&text)).map(drop)).await;
            }
            let detail = silence.as_ref().map(|why| format!("waits for the network: {why}"));
            let (noted, name) = (cache.clone(), id.to_owned());
            if !blocking(move || set_running(&noted, &name, AreaState::Running, detail.as_deref())).await? {
                return Ok(());
            }
            self.notify_changes();
            let tiles_s = (count > 0).then(|| count as f64 / began.elapsed().as_secs_f64().max(1e-3));
            self.shared
                .areas
                .rates
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .insert(id.to_owned(), Rate { tiles_s });
            if silence.is_some() {
                tokio::time::sleep(wait).await;
                wait = (wait * 2).min(WAIT.1);
            } else {
                wait = WAIT.0;
            }
        }
    }

    /// Records the outcomes of tiles; `false` when the area is no longer to be fetched.
    async fn note(
        &self,
        cache: &Arc<Cache>,
        id: &str,
        marks: &mut Vec<(TileId, i64)>,
        bytes: &mut u64,
    ) -> Result<bool> {
        let (cache, id) = (cache.clone(), id.to_owned());
        let (marks, bytes) = (std::mem::take(marks), std::mem::take(bytes));
        let goes_on = blocking(move || {
            mark(&cache, &id, &marks, bytes)?;
            let sql = "SELECT 1 FROM areas WHERE id=? AND state='running'";
            cache.read(|reader| reader.prepare_cached(sql)?.exists([&id]))
        })
        .await?;
        self.notify_changes();
        Ok(goes_on)
    }

    /// Sees to it that a tile is in the cache.
    async fn ensure(&self, source: &Arc<Source>, cache: &Arc<Cache>, tile: TileId) -> Outcome {
        let looked = cache.clone();
        match blocking(move || looked.has(tile)).await {
            Ok(true) => return Outcome::Here(0),
            Ok(false) => {}
            Err(error) => return Outcome::Fault(error.to_string()),
        }
        match self.serve(source, tile).await {
            Ok(shown) => {
                // A tile shown is not yet kept: the service may forbid it, or the disk be full.
                let looked = cache.clone();
                match blocking(move || looked.has(tile)).await {
                    Ok(true) => Outcome::Here(shown.data.len() as u64),
                    Ok(false) => Outcome::Fault(
                        "it came, but could not be kept: the service forbids it, or the disk is full".to_owned(),
                    ),
                    Err(error) => Outcome::Fault(error.to_string()),
                }
            }
            Err(MapError::NoTile) => Outcome::Here(0),
            Err(error) if error.is_network() || matches!(error, MapError::Busy) => Outcome::Silent(error.to_string()),
            Err(error) => Outcome::Fault(error.to_string()),
        }
    }
}

pub(crate) fn new_id(cache: &Cache) -> Result<String> {
    cache.read(|reader| reader.query_row("SELECT lower(hex(randomblob(8)))", [], |row| row.get(0)))
}
