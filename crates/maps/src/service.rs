//! The maps of a station: the sources of their file, their tiles through the caches, and changes to them.

use std::collections::{BTreeMap, HashMap};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use bytes::Bytes;
use serde::Serialize;
use tokio::sync::watch;
use tokio::task::JoinSet;
use utoipa::ToSchema;

use crate::cache::{Cache, Kept};
use crate::elevation::{self, ElevationPoint, HeightTile, Profile, ProfileSample};
use crate::error::{MapError, Result};
use crate::file::{DEFAULT_CACHE_MAX_MB, Sources, SourcesFile};
use crate::google;
use crate::grid::{TileGrid, TileId};
use crate::net::{Answer, Fetcher, Patience, Request};
use crate::settings::{Attribution, Bounds, Caching, Corner, Role, SourceKind, SourceSettings, url_fault};
use crate::sniff::{self, Picture};
use crate::source::{Flight, Live, Source, SourceState, count, tile_url};
use crate::wms::{self, Capabilities};
use crate::{wmts, xml};

/// Stands for a service's capabilities among the tiles that failed.
const CAPABILITIES: TileId = TileId { level: u8::MAX, column: 0, row: 0 };
/// Bytes of a tile at most.
const MAX_TILE: usize = 8 * 1024 * 1024;
/// Fetches of one source that wait or run at most.
const MAX_FLIGHTS: usize = 512;
/// How long a tile is new where its service says nothing.
const USUAL_LIFETIME: Duration = Duration::from_secs(7 * 86_400);
/// How long "there is none" is believed.
const NONE_LIFETIME: Duration = Duration::from_secs(86_400);
/// How long browsers may show a tile without asking.
const BROWSER_S: i64 = 3600;
/// Tiles of heights that are kept unpacked.
const HEIGHT_TILES: usize = 64;
/// Tiles of heights that one question may need.
const MAX_HEIGHT_TILES: usize = 64;
/// Places of one question at most.
pub const MAX_POINTS: usize = 2000;

/// How maps are started.
#[derive(Clone)]
pub struct MapsConfig {
    /// Where `sources.toml`, `files/` and `cache/` are; made when it is not there.
    pub folder: PathBuf,
    /// How long services are given.
    pub patience: Patience,
    /// Seconds since 1970.
    pub clock: Arc<dyn Fn() -> i64 + Send + Sync>,
}

impl MapsConfig {
    /// With this machine's clock.
    #[must_use]
    pub fn new(folder: PathBuf) -> Self {
        let clock = || {
            let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
            i64::try_from(since.as_secs()).unwrap_or(i64::MAX)
        };
        Self { folder, patience: Patience::default(), clock: Arc::new(clock) }
    }
}

impl std::fmt::Debug for MapsConfig {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MapsConfig").field("folder", &self.folder).finish_non_exhaustive()
    }
}

/// Where a tile came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// From the cache, and new.
    Hit,
    /// From the service.
    Fetched,
    /// From the cache; the service says that it is the same.
    Revalidated,
    /// From the cache, old: the service failed.
    Stale,
    /// From a file of this machine.
    File,
}

impl Origin {
    /// In a word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hit => "hit",
            Self::Fetched => "fetched",
            Self::Revalidated => "revalidated",
            Self::Stale => "stale",
            Self::File => "file",
        }
    }
}

/// A tile to show.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// The picture.
    pub data: Bytes,
    /// What kind of picture.
    pub picture: Picture,
    /// Tells whether it is the same.
    pub hash: u64,
    /// Where it came from.
    pub origin: Origin,
    /// How long a browser may show it without asking again, seconds.
    pub max_age_s: i64,
}

/// Whether offline areas may be made of a source.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = MapOffline)]
pub struct Offline {
    /// Whether.
    pub allowed: bool,
    /// Why not.
    #[schema(required = true)]
    pub reason: Option<String>,
}

/// A source as it is shown.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapSource {
    /// Its id.
    pub id: String,
    /// What people call it.
    pub name: String,
    /// How it is read.
    pub kind: SourceKind,
    /// What it is for.
    pub role: Role,
    /// Whether it is shown at first.
    pub visible: bool,
    /// 0 to 1.
    pub opacity: f64,
    /// Place among the others of its role.
    pub order: i32,
    /// Zoom (of Web Mercator) from which it is shown.
    #[schema(required = true)]
    pub min_zoom: Option<u8>,
    /// Zoom of its finest tiles, as its settings say.
    #[schema(required = true)]
    pub max_zoom: Option<u8>,
    /// Where it has something.
    #[schema(required = true)]
    pub bounds: Option<Bounds>,
    /// Whom to name with it, always.
    pub attribution: Vec<Attribution>,
    /// Whether whom to name depends on the view.
    pub attribution_by_view: bool,
    /// Whose logo must be shown on the map: `google`.
    #[schema(required = true)]
    pub logo: Option<String>,
    /// The grid of its tiles; null while it is not known.
    #[schema(required = true)]
    pub grid: Option<TileGrid>,
    /// Address of its tiles, with `{z}`, `{x}`, `{y}` (from the top).
    pub tiles_url: String,
    /// Whether what was seen is kept for when the network is gone.
    pub may_cache: bool,
    /// Whether offline areas may be made of it.
    pub offline: Offline,
    /// Whether its service demands a key.
    pub needs_key: bool,
    /// Whether there is one.
    pub has_key: bool,
    /// Corners of a picture: top left, top right, bottom right, bottom left; null for other kinds.
    #[schema(required = true)]
    pub corners: Option<Vec<Corner>>,
    /// How it fares.
    pub state: SourceState,
}

/// All sources as they are shown.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapSources {
    /// Base maps, overlays from the bottom, heights; each in their order.
    pub sources: Vec<MapSource>,
    /// Where their file is, for operators; empty for viewers.
    pub file: String,
    /// What is wrong with the file; the last right one is in use.
    #[schema(required = true)]
    pub file_error: Option<String>,
}

/// All settings, for an editor.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapConfiguration {
    /// In the order of [`MapSources`], without keys.
    pub sources: Vec<SourceSettings>,
    /// Megabytes of the cache of a source that says nothing else.
    pub cache_max_mb: u32,
    /// The maps folder, on the server's machine.
    pub folder: String,
    /// The file of the sources.
    pub file: String,
    /// What is wrong with it.
    #[schema(required = true)]
    pub file_error: Option<String>,
}

#[derive(Default)]
struct State {
    sources: Vec<Arc<Source>>,
    file_error: Option<String>,
    /// When the file was changed, and its size, as it was read.
    stamp: Option<(SystemTime, u64)>,
    cache_max_mb: u32,
}

type HeightKey = (String, TileId);

pub(crate) struct Shared {
    pub(crate) config: MapsConfig,
    pub(crate) fetcher: Fetcher,
    file: SourcesFile,
    state: RwLock<State>,
    /// Held while the file is read or changed.
    edits: tokio::sync::Mutex<()>,
    /// Unpacked, by source and tile, the newest last.
    heights: Mutex<Vec<(HeightKey, Arc<HeightTile>)>>,
    pub(crate) areas: crate::areas::Running,
    pub(crate) closing: watch::Sender<bool>,
}

/// The maps of a station. Clones are handles to the same.
#[derive(Clone)]
pub struct Maps {
    pub(crate) shared: Arc<Shared>,
}

impl std::fmt::Debug for Maps {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Maps").field("config", &self.shared.config).finish_non_exhaustive()
    }
}

/// Runs what blocks off the runtime's threads.
pub(crate) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> Result<T> + Send + 'static) -> Result<T> {
    tokio::task::spawn_blocking(work).await.map_err(|_| MapError::Closed)?
}

impl Maps {
    /// Starts the maps of a folder, and goes on with its offline areas. To be awaited on the runtime they are to use.
    ///
    /// # Errors
    /// [`MapError::Storage`] when the folder cannot be used. A wrong file of sources is no error: it is told.
    pub async fn start(config: MapsConfig) -> Result<Self> {
        let fetcher = Fetcher::new(config.patience)?;
        let file = SourcesFile::new(config.folder.join("sources.toml"));
        let folder = config.folder.clone();
        let made = file.clone();
        blocking(move || {
            std::fs::create_dir_all(folder.join("files"))?;
            if !made.path().exists() {
                made.create(&crate::presets::defaults())?;
            }
            Ok(())
        })
        .await?;
        let shared = Shared {
            config,
            fetcher,
            file,
            state: RwLock::default(),
            edits: tokio::sync::Mutex::default(),
            heights: Mutex::default(),
            areas: crate::areas::Running::default(),
            closing: watch::channel(false).0,
        };
        let maps = Self { shared: Arc::new(shared) };
        maps.reload().await?;
        maps.resume_areas().await;
        Ok(maps)
    }

    /// Ends what is under way; downloads go on at the next start.
    pub fn close(&self) {
        self.shared.closing.send_replace(true);
    }

    pub(crate) fn now_s(&self) -> i64 {
        (self.shared.config.clock)()
    }

    /// The maps folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.shared.config.folder
    }

    pub(crate) fn sources(&self) -> Vec<Arc<Source>> {
        self.shared.state.read().unwrap_or_else(PoisonError::into_inner).sources.clone()
    }

    pub(crate) fn source(&self, id: &str) -> Result<Arc<Source>> {
        let state = self.shared.state.read().unwrap_or_else(PoisonError::into_inner);
        let found = state.sources.iter().find(|source| source.settings.id == id);
        found.cloned().ok_or_else(|| MapError::NoSource(id.to_owned()))
    }

    /// Reads the file again when it was changed by hand.
    ///
    /// # Errors
    /// [`MapError::Storage`], [`MapError::Closed`].
    pub async fn refresh(&self) -> Result<()> {
        let stamp = stamp(self.shared.file.path());
        let is_same = self.shared.state.read().unwrap_or_else(PoisonError::into_inner).stamp == stamp;
        if is_same { Ok(()) } else { self.reload().await }
    }

    async fn reload(&self) -> Result<()> {
        let _edit = self.shared.edits.lock().await;
        self.reload_held().await
    }

    /// To be called while `edits` is held.
    async fn reload_held(&self) -> Result<()> {
        let file = self.shared.file.clone();
        let (stamp, read) = blocking(move || Ok((stamp(file.path()), file.read()))).await?;
        match read {
            Ok(read) => {
                let nothing = || Sources { cache_max_mb: DEFAULT_CACHE_MAX_MB, sources: Vec::new() };
                self.apply(read.unwrap_or_else(nothing), stamp).await
            }
            Err(error) => {
                let mut state = self.shared.state.write().unwrap_or_else(PoisonError::into_inner);
                state.file_error = Some(error.to_string());
                state.stamp = stamp;
                Ok(())
            }
        }
    }

    async fn apply(&self, read: Sources, stamp: Option<(SystemTime, u64)>) -> Result<()> {
        let before = self.sources();
        let folder = self.shared.config.folder.clone();
        let Sources { cache_max_mb, sources } = read;
        let mut opened = blocking(move || {
            let same = |settings: &SourceSettings| before.iter().find(|source| source.settings == *settings).cloned();
            // One file is opened once: its connections know of each other.
            let caches: HashMap<PathBuf, Arc<Cache>> = before
                .iter()
                .filter_map(|source| source.cache.as_ref())
                .map(|cache| (cache.path().to_owned(), cache.clone()))
                .collect();
            Ok(sources
                .into_iter()
                .map(|settings| {
                    let max_bytes = u64::from(settings.max_mb.unwrap_or(cache_max_mb)) * 1_000_000;
                    let source = same(&settings).unwrap_or_else(|| {
                        let path = cache_path(&folder, &settings);
                        let cache = (!settings.kind.is_file()).then(|| {
                            caches.get(&path).cloned().map_or_else(|| Cache::open(&path, max_bytes).map(Arc::new), Ok)
                        });
                        match cache.transpose() {
                            Ok(cache) => Arc::new(Source::open(settings, &folder, cache)),
                            Err(error) => {
                                tracing::error!(%error, source = settings.id, "the cache of a map source cannot be used");
                                Arc::new(Source::open(settings, &folder, None))
                            }
                        }
                    });
                    if let Some(cache) = &source.cache {
                        cache.set_max_bytes(max_bytes);
                    }
                    source
                })
                .collect::<Vec<_>>())
        })
        .await?;
        let role = |source: &Source| match source.settings.role {
            Role::Base => 0,
            Role::Overlay => 1,
            Role::Elevation => 2,
        };
        opened.sort_by_key(|source| (role(source), source.settings.order));
        {
            let mut state = self.shared.state.write().unwrap_or_else(PoisonError::into_inner);
            *state = State { sources: opened, file_error: None, stamp, cache_max_mb };
        }
        self.shared.heights.lock().unwrap_or_else(PoisonError::into_inner).clear();
        Ok(())
    }

    // ---- what there is

    /// All sources, for who looks; with the file's place for who may edit it. What is not known yet of services is asked for.
    ///
    /// # Errors
    /// [`MapError::Storage`], [`MapError::Closed`].
    pub async fn list(&self, for_editor: bool) -> Result<MapSources> {
        self.refresh().await?;
        self.learn();
        let sources = self.sources();
        let file_error = self.shared.state.read().unwrap_or_else(PoisonError::into_inner).file_error.clone();
        let file = if for_editor { self.shared.file.path().display().to_string() } else { String::new() };
        let sources = blocking(move || Ok(sources.iter().map(|source| describe(source)).collect())).await?;
        Ok(MapSources { sources, file, file_error })
    }

    /// One source.
    ///
    /// # Errors
    /// [`MapError::NoSource`].
    pub async fn describe(&self, id: &str) -> Result<MapSource> {
        let source = self.source(id)?;
        blocking(move || Ok(describe(&source))).await
    }

    /// All settings, without keys.
    ///
    /// # Errors
    /// [`MapError::Storage`], [`MapError::Closed`].
    pub async fn configuration(&self) -> Result<MapConfiguration> {
        self.refresh().await?;
        let sources = self.sources().iter().map(|source| without_key(&source.settings)).collect();
        let state = self.shared.state.read().unwrap_or_else(PoisonError::into_inner);
        Ok(MapConfiguration {
            sources,
            cache_max_mb: state.cache_max_mb,
            folder: self.folder().display().to_string(),
            file: self.shared.file.path().display().to_string(),
            file_error: state.file_error.clone(),
        })
    }

    /// Asks services for what is needed of their capabilities, in the background.
    fn learn(&self) {
        for source in self.sources() {
            if matches!(source.live, Live::Wmts(_)) && source.grid().is_none() {
                let maps = self.clone();
                tokio::spawn(async move { maps.known_grid(&source).await.map(drop) });
            }
        }
    }

    /// The grid of a source, asked for where it is not known.
    pub(crate) async fn known_grid(&self, source: &Arc<Source>) -> Result<TileGrid> {
        if let Some(grid) = source.grid() {
            return Ok(grid);
        }
        match &source.live {
            Live::Unusable(reason) => return Err(source.unusable(reason.clone())),
            Live::Wmts(_) => {}
            _ => return Err(source.unusable("it has no tiles")),
        }
        // One asks, the others wait for what it learns.
        let _learning = source.learning.lock().await;
        if let Some(grid) = source.grid() {
            return Ok(grid);
        }
        if let Some(error) = source.rest(CAPABILITIES, self.now_s()) {
            return Err(error);
        }
        let settings = &source.settings;
        let url = wmts::capabilities_url(&with_key(settings))?;
        let request = Request::new(settings, &url, xml::MAX_BYTES)?;
        let result = match self.shared.fetcher.fetch(&request).await {
            Ok(answer) if answer.status == 200 => {
                wmts::read_layer(&answer.body, settings).map_err(|reason| source.unusable(reason))
            }
            Ok(answer) => Err(refused(&request, &answer)),
            Err(error) => Err(error),
        };
        let now_s = self.now_s();
        match result {
            Ok(layer) => {
                let kept = source.clone();
                blocking(move || kept.set_layer(layer)).await?;
                source.succeeded(Some(CAPABILITIES), now_s);
                source.grid().ok_or_else(|| source.unusable("its grid is not known"))
            }
            Err(error) => {
                source.failed(Some(CAPABILITIES), &error, None, now_s);
                Err(error)
            }
        }
    }

    /// What a service offers. It is asked though it is no source yet; nothing but what is read of its capabilities comes back.
    ///
    /// # Errors
    /// [`MapError::Request`] for an address that is none, else as a fetch.
    pub async fn capabilities(&self, kind: SourceKind, url: &str, key: Option<&str>) -> Result<Capabilities> {
        if let Some(fault) = url_fault(url) {
            return Err(MapError::Request(format!("url: {fault}")));
        }
        let mut settings = SourceSettings::new("new", "new", kind);
        (settings.url, settings.key) = (Some(url.to_owned()), key.map(str::to_owned));
        let address = match kind {
            SourceKind::Wms => wms::capabilities_url(&with_key(&settings), None)?,
            SourceKind::Wmts => wmts::capabilities_url(&with_key(&settings))?,
            _ => return Err(MapError::Request("kind: only wms and wmts have capabilities".to_owned())),
        };
        let request = Request::new(&settings, &address, xml::MAX_BYTES)?;
        let answer = self.shared.fetcher.fetch(&request).await?;
        if answer.status != 200 {
            return Err(refused(&request, &answer));
        }
        let read = match kind {
            SourceKind::Wms => wms::read_capabilities(&answer.body),
            _ => wmts::read_capabilities(&answer.body),
        };
        read.map_err(|reason| MapError::Service { host: crate::net::shown(&request.url), reason })
    }

    // ---- tiles

    /// A tile of a source, from its file, its cache or its service.
    ///
    /// # Errors
    /// [`MapError`] of nearly every kind; [`MapError::NoTile`] where nothing is to be drawn.
    pub async fn tile(&self, id: &str, tile: TileId) -> Result<Tile> {
        let source = self.source(id)?;
        self.serve(&source, tile).await
    }

    pub(crate) async fn serve(&self, source: &Arc<Source>, tile: TileId) -> Result<Tile> {
        if let Live::File(file) = &source.live {
            let file = file.clone();
            if !source.grid().is_some_and(|grid| grid.contains(tile)) {
                return Err(MapError::NoTile);
            }
            let read = blocking(move || file.tile(tile)).await;
            let now_s = self.now_s();
            return match read.and_then(|data| data.ok_or(MapError::NoTile)).and_then(|data| {
                let kind = Picture::of(&data);
                let kind = kind.ok_or_else(|| source.unusable(format!("tile {tile} is {}", sniff::describe(&data))))?;
                Ok(file_tile(data, kind))
            }) {
                Err(error) if error != MapError::NoTile => {
                    let error = source.unusable(error.to_string());
                    source.failed(None, &error, None, now_s);
                    Err(error)
                }
                other => {
                    source.succeeded(None, now_s);
                    count(&source.counts.hits, 1);
                    other
                }
            };
        }
        let grid = self.known_grid(source).await?;
        if !grid.contains(tile) {
            return Err(MapError::NoTile);
        }
        let now_s = self.now_s();
        let kept = self.kept(source, tile, now_s).await?;
        if let Some(kept) = &kept
            && kept.expires_s > now_s
        {
            count(&source.counts.hits, 1);
            return show(kept, Origin::Hit, now_s);
        }
        if source.settings.needs_key() && source.settings.key().is_none() {
            return Err(MapError::KeyMissing(source.settings.id.clone()));
        }
        let result = match source.rest(tile, now_s) {
            Some(error) => Err(error),
            None => self.join_flight(source, tile, kept.clone()).await,
        };
        match result {
            Err(error) if error != MapError::NoTile => {
                // What was seen before is better than nothing, where it may be kept.
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

    async fn kept(&self, source: &Arc<Source>, tile: TileId, now_s: i64) -> Result<Option<Kept>> {
        match &source.cache {
            Some(cache) if source.is_kept() => {
                let cache = cache.clone();
                blocking(move || cache.get(tile, now_s)).await
            }
            _ => Ok(None),
        }
    }

    /// Waits for the fetch of a tile, which is begun when nobody else waits for it. It ends when nobody does any more.
    async fn join_flight(&self, source: &Arc<Source>, tile: TileId, kept: Option<Kept>) -> Result<Tile> {
        let mut landing = {
            let mut flights = source.flights.lock().unwrap_or_else(PoisonError::into_inner);
            match flights.get(&tile) {
                Some(flight) => flight.subscribe(),
                None if flights.len() >= MAX_FLIGHTS => return Err(MapError::Busy),
                None => {
                    let (flight, landing) = watch::channel(None);
                    let flight = Arc::new(flight);
                    flights.insert(tile, flight.clone());
                    tokio::spawn(self.clone().fly(source.clone(), tile, kept, flight));
                    landing
                }
            }
        };
        let result = landing.wait_for(Option::is_some).await.map_err(|_| MapError::Closed)?;
        result.clone().unwrap_or(Err(MapError::Closed))
    }

    async fn fly(self, source: Arc<Source>, tile: TileId, kept: Option<Kept>, flight: Flight) {
        let mut closing = self.shared.closing.subscribe();
        let result = tokio::select! {
            result = self.fetch(&source, tile, kept) => result,
            () = abandoned(&source, tile, &flight) => return,
            _ = closing.wait_for(|closing| *closing) => Err(MapError::Closed),
        };
        source.flights.lock().unwrap_or_else(PoisonError::into_inner).remove(&tile);
        flight.send_replace(Some(result));
    }

    /// Fetches a tile, and keeps it where it may be.
    async fn fetch(&self, source: &Arc<Source>, tile: TileId, kept: Option<Kept>) -> Result<Tile> {
        let mut retry_after = None;
        let result = self.ask(source, tile, kept.as_ref(), &mut retry_after).await;
        let now_s = self.now_s();
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
        kept: Option<&Kept>,
        retry_after: &mut Option<Duration>,
    ) -> Result<Tile> {
        let settings = &source.settings;
        let mut is_second = false;
        let (request, answer) = loop {
            let url = match &source.live {
                Live::Google(google, _) => google.url(&self.shared.fetcher, settings, tile, self.now_s()).await?,
                _ => tile_url(source, tile)?,
            };
            let mut request = Request::new(settings, &url, MAX_TILE)?;
            if let Some(kept) = kept.filter(|kept| kept.data.is_some()) {
                request.etag.clone_from(&kept.etag);
                request.last_modified.clone_from(&kept.last_modified);
            }
            let answer = self.shared.fetcher.fetch(&request).await?;
            // A session may be ended before its time.
            if let (Live::Google(google, _), 400 | 401 | 403, false) = (&source.live, answer.status, is_second) {
                google.forget().await;
                is_second = true;
                continue;
            }
            break (request, answer);
        };
        *retry_after = answer.retry_after.filter(|_| matches!(answer.status, 429 | 503));
        count(&source.counts.bytes, answer.body.len() as u64);
        let now_s = self.now_s();
        let failed = |reason: String| MapError::Service {
            host: crate::net::shown(&request.url),
            reason: crate::net::hide(&reason, request.secret.as_deref()),
        };
        match answer.status {
            304 => {
                let kept =
                    kept.ok_or_else(|| failed("says that nothing changed, though nothing was known".to_owned()))?;
                let mut renewed = kept.clone();
                let lifetime = lifetime(settings, &answer).as_secs();
                (renewed.fetched_s, renewed.expires_s) = (now_s, now_s + i64::try_from(lifetime).unwrap_or(0));
                if let Some(cache) = source.cache.clone() {
                    let (fetched_s, expires_s) = (renewed.fetched_s, renewed.expires_s);
                    blocking(move || cache.renew(tile, fetched_s, expires_s)).await?;
                }
                count(&source.counts.revalidated, 1);
                show(&renewed, Origin::Revalidated, now_s)
            }
            204 | 404 | 410 => {
                self.keep(source, tile, Kept::new(None, now_s, NONE_LIFETIME)).await?;
                Err(MapError::NoTile)
            }
            200 => {
                if let Err(reason) = sniff::check_picture(&answer.body) {
                    let root = answer.body.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'<');
                    let root = root.then(|| xml::Element::parse(&answer.body).ok()).flatten();
                    return Err(match root.as_ref().and_then(xml::exception) {
                        Some(said) => failed(said),
                        None => failed(format!("answers with {reason}")),
                    });
                }
                let mut new = Kept::new(Some(answer.body.clone()), now_s, lifetime(settings, &answer));
                (new.etag, new.last_modified) = (answer.etag.clone(), answer.last_modified.clone());
                count(&source.counts.fetched, 1);
                let may_keep = !answer.freshness.no_store || settings.cache_min_days.is_some_and(|days| days > 0);
                if may_keep {
                    self.keep(source, tile, new.clone()).await?;
                }
                show(&new, Origin::Fetched, now_s)
            }
            _ => {
                let root = xml::Element::parse(&answer.body).ok();
                match root.as_ref().and_then(xml::exception) {
                    // How tile services say that there is none.
                    Some(said) if said.contains("TileOutOfRange") => {
                        self.keep(source, tile, Kept::new(None, now_s, NONE_LIFETIME)).await?;
                        Err(MapError::NoTile)
                    }
                    Some(said) => Err(failed(said)),
                    None => Err(refused(&request, &answer)),
                }
            }
        }
    }

    async fn keep(&self, source: &Arc<Source>, tile: TileId, kept: Kept) -> Result<()> {
        let Some(cache) = source.cache.clone().filter(|_| source.is_kept()) else { return Ok(()) };
        let by_headers = source.settings.cache == Caching::Headers;
        blocking(move || {
            if by_headers {
                // Nothing stays beyond its time, seen or not.
                cache.drop_expired(kept.fetched_s)?;
                if kept.expires_s <= kept.fetched_s {
                    return Ok(());
                }
            }
            cache.put(tile, &kept)
        })
        .await
    }

    // ---- changes

    /// Puts a source in the place of that of its id, or adds it. A key that is absent stays as it was.
    ///
    /// # Errors
    /// [`MapError::Settings`] with all faults, [`MapError::SourcesFile`] when the file is wrong as it is.
    pub async fn put(&self, mut settings: SourceSettings) -> Result<MapSource> {
        let edit = self.shared.edits.lock().await;
        let before = self.source(&settings.id).ok();
        if settings.key.is_none() {
            settings.key = before.as_ref().and_then(|source| source.settings.key.clone());
        }
        settings.key = settings.key.filter(|key| !key.is_empty());
        settings.has_key = None;
        let mut faults = settings.faults();
        let is_same_path = before.as_ref().is_some_and(|source| source.settings.path == settings.path);
        if let Some(path) = &settings.path
            && !is_same_path
            && !is_inside(path)
        {
            faults.push(format!(
                "path: by this way only files of the maps folder are taken, such as files/NAME; put the file into {}, send it \
                 with POST /api/v1/maps/files, or write its path into sources.toml by hand",
                self.folder().join("files").display()
            ));
        }
        if !faults.is_empty() {
            return Err(MapError::Settings { source_id: settings.id, faults });
        }
        let (file, id) = (self.shared.file.clone(), settings.id.clone());
        blocking(move || file.put(&settings)).await?;
        self.reload_held().await?;
        drop(edit);
        let source = self.source(&id)?;
        // Its state says why when this fails; the settings are kept all the same: the network may be away.
        let _ = self.known_grid(&source).await;
        self.describe(&id).await
    }

    /// Sets the order of sources to that of a list; those that it does not name keep theirs.
    ///
    /// # Errors
    /// [`MapError::NoSource`], [`MapError::SourcesFile`].
    pub async fn set_order(&self, ids: &[String]) -> Result<()> {
        let _edit = self.shared.edits.lock().await;
        let mut orders = BTreeMap::new();
        for (index, id) in (1_i32..).zip(ids) {
            self.source(id)?;
            orders.insert(id.clone(), index * 10);
        }
        let file = self.shared.file.clone();
        blocking(move || file.set_orders(&orders)).await?;
        self.reload_held().await
    }

    /// Removes a source, and where it is wished all that is cached of it.
    ///
    /// # Errors
    /// [`MapError::NoSource`], [`MapError::SourcesFile`].
    pub async fn remove(&self, id: &str, forget_cache: bool) -> Result<()> {
        let _edit = self.shared.edits.lock().await;
        let source = self.source(id)?;
        self.stop_areas_of(id).await;
        let (file, name) = (self.shared.file.clone(), id.to_owned());
        blocking(move || file.remove(&name)).await?;
        self.reload_held().await?;
        drop(source);
        if forget_cache {
            let (folder, name) = (self.shared.config.folder.join("cache"), id.to_owned());
            blocking(move || {
                for entry in std::fs::read_dir(&folder)?.flatten() {
                    if is_cache_of(&entry.file_name().to_string_lossy(), &name) {
                        std::fs::remove_file(entry.path())?;
                    }
                }
                Ok(())
            })
            .await?;
        }
        Ok(())
    }

    /// Forgets what is cached of a source but for its offline areas.
    ///
    /// # Errors
    /// [`MapError::NoSource`], [`MapError::Storage`].
    pub async fn clear_cache(&self, id: &str) -> Result<()> {
        let source = self.source(id)?;
        self.shared.heights.lock().unwrap_or_else(PoisonError::into_inner).clear();
        match source.cache.clone() {
            Some(cache) => blocking(move || cache.clear()).await,
            None => Ok(()),
        }
    }

    /// Asks a source for one tile now, past its cache.
    ///
    /// # Errors
    /// [`MapError::NoSource`]; what fails is in the state.
    pub async fn check(&self, id: &str) -> Result<SourceState> {
        let source = self.source(id)?;
        source.try_again();
        if let Ok(grid) = self.known_grid(&source).await {
            let level = f64::midpoint(f64::from(grid.min_level), f64::from(grid.max_level)) as u8;
            let is_locked = source.settings.needs_key() && source.settings.key().is_none();
            if let Some(tile) = grid.middle(level).filter(|_| !is_locked) {
                let _ = match &source.live {
                    Live::File(_) => self.serve(&source, tile).await,
                    _ => self.join_flight(&source, tile, None).await,
                };
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
        if source.settings.kind != SourceKind::Image {
            return Err(source.unusable("it is no picture with corners"));
        }
        let path = self.folder().join(source.settings.path.as_deref().unwrap_or_default());
        let read = blocking(move || crate::files::overlay::read_file(&path).map_err(MapError::Storage)).await;
        let data = Bytes::from(read.map_err(|error| source.unusable(error.to_string()))?);
        let kind = Picture::of(&data).ok_or_else(|| source.unusable(format!("it is {}", sniff::describe(&data))))?;
        Ok(file_tile(data, kind))
    }

    /// Whom to name for a view of a source, and up to which zoom it has pictures there.
    ///
    /// # Errors
    /// As a fetch.
    pub async fn attribution(&self, id: &str, view: &Bounds, zoom: u8) -> Result<(Vec<Attribution>, Option<u8>)> {
        if let Some(fault) = view.fault() {
            return Err(MapError::Request(fault));
        }
        let source = self.source(id)?;
        let settings = &source.settings;
        if settings.needs_key() && settings.key().is_none() {
            return Err(MapError::KeyMissing(id.to_owned()));
        }
        let (mut named, max_zoom) = match (&source.live, &settings.attribution_url) {
            (Live::Google(google, _), _) => {
                google.attribution(&self.shared.fetcher, settings, view, zoom, self.now_s()).await?
            }
            (_, Some(template)) => {
                let key = settings.key().map(crate::xyz::escape).unwrap_or_default();
                let places = [
                    ("{west}", view.west_deg.to_string()),
                    ("{south}", view.south_deg.to_string()),
                    ("{east}", view.east_deg.to_string()),
                    ("{north}", view.north_deg.to_string()),
                    ("{zoom}", zoom.to_string()),
                    ("{key}", key),
                ];
                let url = places.iter().fold(template.clone(), |url, (place, value)| url.replace(place, value));
                google::fetch_attribution(&self.shared.fetcher, settings, &url).await?
            }
            _ => (Vec::new(), settings.max_zoom),
        };
        let mut all = settings.attribution.clone();
        all.append(&mut named);
        Ok((all, max_zoom))
    }

    // ---- heights

    /// The ground's height at places, and why a source failed, if one did. Unknown stays unknown.
    ///
    /// # Errors
    /// [`MapError::Request`] for too many places or places that are none.
    pub async fn heights(&self, points: &[Corner]) -> Result<(Vec<ElevationPoint>, Option<String>)> {
        if points.len() > MAX_POINTS {
            return Err(MapError::Request(format!("points: at most {MAX_POINTS} are taken")));
        }
        let is_place = |at: &Corner| vencejo_flight::geodesy::GeoPoint::new(at.lat_deg, at.lon_deg).is_ok();
        if !points.iter().all(is_place) {
            return Err(MapError::Request(
                "points: latitudes go from -90 to 90, longitudes from -180 to 180".to_owned(),
            ));
        }
        let mut found = vec![ElevationPoint::default(); points.len()];
        let mut fault = None;
        for source in self.sources().into_iter().filter(|source| source.settings.role == Role::Elevation) {
            let open: Vec<usize> = (0..points.len()).filter(|index| found[*index].alt_amsl_m.is_none()).collect();
            if open.is_empty() {
                break;
            }
            let asked: Vec<Corner> = open.iter().map(|index| points[*index]).collect();
            let heights = match self.heights_of(&source, asked, &mut fault).await {
                Ok(heights) => heights,
                Err(error) => {
                    fault = Some(error.to_string());
                    continue;
                }
            };
            for (index, height) in open.into_iter().zip(heights) {
                if let Some((alt_m, resolution_m)) = height {
                    found[index] = ElevationPoint {
                        alt_amsl_m: Some(alt_m),
                        source: Some(source.settings.id.clone()),
                        resolution_m: Some(resolution_m),
                        datum: Some(source.settings.datum.clone().unwrap_or_else(|| "EGM96".to_owned())),
                    };
                }
            }
        }
        Ok((found, fault))
    }

    async fn heights_of(
        &self,
        source: &Arc<Source>,
        points: Vec<Corner>,
        fault: &mut Option<String>,
    ) -> Result<Vec<Option<(f64, f64)>>> {
        if let Live::Dem(dem) = &source.live {
            let dem = dem.clone();
            let read = blocking(move || {
                let height = |at: &Corner| Ok(dem.height(at.lat_deg, at.lon_deg)?.map(|h| (h.alt_m, h.resolution_m)));
                points.iter().map(height).collect()
            });
            let result = read.await;
            match &result {
                Ok(_) => source.succeeded(None, self.now_s()),
                Err(error) => source.failed(None, error, None, self.now_s()),
            }
            return result;
        }
        let encoding = source.settings.encoding.ok_or_else(|| source.unusable("its encoding is not said"))?;
        let grid = self.known_grid(source).await?;
        // The finest level whose tiles are not too many.
        let mut wanted = None;
        for level in (grid.min_level..=grid.max_level).rev() {
            let places = neighbours(&grid, level, &points);
            let mut tiles: Vec<TileId> =
                places.iter().flatten().flat_map(|near| near.iter().map(|(_, tile, _)| *tile)).collect();
            tiles.sort();
            tiles.dedup();
            let is_enough = tiles.len() <= MAX_HEIGHT_TILES;
            wanted = Some((level, places, tiles));
            if is_enough {
                break;
            }
        }
        let Some((level, places, tiles)) = wanted else { return Ok(vec![None; points.len()]) };
        let mut fetches = JoinSet::new();
        for tile in tiles {
            let (maps, source) = (self.clone(), source.clone());
            fetches.spawn(async move { (tile, maps.height_tile(&source, tile, encoding).await) });
        }
        let mut heights = HashMap::new();
        while let Some(done) = fetches.join_next().await {
            match done {
                Ok((tile, Ok(height))) => {
                    heights.insert(tile, height);
                }
                Ok((_, Err(MapError::NoTile))) | Err(_) => {}
                Ok((_, Err(error))) => *fault = Some(error.to_string()),
            }
        }
        let resolution = grid.levels[usize::from(level)].resolution * grid.crs.metres_per_unit();
        let height = |(at, near): (&Corner, &Option<Neighbours>)| {
            let near = near.as_ref()?;
            let mut sum = 0.0;
            for (weight, tile, [column, row]) in near {
                if *weight > 0.0 {
                    sum += weight * heights.get(tile)?.at(*column, *row)?;
                }
            }
            // Web Mercator stretches by the latitude.
            Some((sum, resolution * at.lat_deg.to_radians().cos()))
        };
        Ok(points.iter().zip(&places).map(height).collect())
    }

    async fn height_tile(
        &self,
        source: &Arc<Source>,
        tile: TileId,
        encoding: crate::settings::Encoding,
    ) -> Result<Arc<HeightTile>> {
        let key = (source.settings.id.clone(), tile);
        {
            let mut kept = self.shared.heights.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(at) = kept.iter().position(|(known, _)| *known == key) {
                let found = kept.remove(at);
                kept.push(found.clone());
                return Ok(found.1);
            }
        }
        let picture = self.serve(source, tile).await?;
        let unusable = |reason: String| source.unusable(format!("tile {tile}: {reason}"));
        let read = blocking(move || HeightTile::read(&picture.data, encoding).map_err(MapError::Storage)).await;
        let height = read.map_err(|error| unusable(error.to_string()))?;
        let size = self.known_grid(source).await?.level(tile.level).map(|level| level.tile_px);
        if size.is_some_and(|size| size != height.size()) {
            return Err(unusable(format!("it has {:?} pixels; set tile_px", height.size())));
        }
        let height = Arc::new(height);
        let mut kept = self.shared.heights.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() >= HEIGHT_TILES {
            kept.remove(0);
        }
        kept.push((key, height.clone()));
        Ok(height)
    }

    /// The ground under a line of geodesics.
    ///
    /// # Errors
    /// [`MapError::Request`] for fewer than one or too many points.
    pub async fn profile(&self, points: &[Corner], spacing_m: Option<f64>) -> Result<Profile> {
        if points.is_empty() || points.len() > MAX_POINTS / 2 {
            return Err(MapError::Request(format!("points: takes 1 to {}", MAX_POINTS / 2)));
        }
        if spacing_m.is_some_and(|spacing| !(spacing.is_finite() && spacing > 0.0)) {
            return Err(MapError::Request("spacing_m: must be greater than 0".to_owned()));
        }
        let places = elevation::along(points, spacing_m.unwrap_or(30.0));
        let asked: Vec<Corner> = places.iter().map(|(_, at)| *at).collect();
        let (heights, error) = self.heights(&asked).await?;
        let mut sources: Vec<String> = heights.iter().filter_map(|height| height.source.clone()).collect();
        sources.sort();
        sources.dedup();
        let known = heights.iter().filter_map(|height| height.alt_amsl_m);
        Ok(Profile {
            length_m: places.last().map_or(0.0, |(distance_m, _)| *distance_m),
            max_alt_amsl_m: known.reduce(f64::max),
            unknown: u32::try_from(heights.iter().filter(|height| height.alt_amsl_m.is_none()).count())
                .unwrap_or(u32::MAX),
            datum: heights.iter().find_map(|height| height.datum.clone()),
            samples: places
                .into_iter()
                .zip(heights)
                .map(|((distance_m, at), height)| ProfileSample {
                    distance_m,
                    lat_deg: at.lat_deg,
                    lon_deg: at.lon_deg,
                    alt_amsl_m: height.alt_amsl_m,
                })
                .collect(),
            sources,
            error,
        })
    }
}

/// The pixels around a place with their weights.
type Neighbours = [(f64, TileId, [u32; 2]); 4];

/// For each place the four pixels around it, in whatever tiles they are; `None` off the grid.
fn neighbours(grid: &TileGrid, level: u8, points: &[Corner]) -> Vec<Option<Neighbours>> {
    let Some(of) = grid.level(level) else { return vec![None; points.len()] };
    let size = of.size.unwrap_or([u32::MAX / 4096; 2]);
    let pixels = [size[0] * of.tile_px[0], size[1] * of.tile_px[1]];
    let is_round = grid.crs.world_width().is_some();
    let around = |at: &Corner| {
        let position = grid.position(of, grid.crs.project(at.lat_deg, at.lon_deg));
        // Pixels stand for their middles.
        let column = (position[0] * f64::from(of.tile_px[0]) - 0.5).rem_euclid(f64::from(pixels[0]));
        let row = position[1] * f64::from(of.tile_px[1]) - 0.5;
        if !(-0.5..f64::from(pixels[1])).contains(&row) {
            return None;
        }
        let row = row.clamp(0.0, f64::from(pixels[1] - 1));
        Some(elevation::corners(column, row).map(|(weight, [column, row])| {
            let column = if is_round { column % pixels[0] } else { column.min(pixels[0] - 1) };
            let row = row.min(pixels[1] - 1);
            let tile = TileId { level, column: column / of.tile_px[0], row: row / of.tile_px[1] };
            (weight, tile, [column % of.tile_px[0], row % of.tile_px[1]])
        }))
    };
    points.iter().map(around).collect()
}

/// Waits until nobody waits for a fetch any more, and takes it off the list.
async fn abandoned(source: &Source, tile: TileId, flight: &Flight) {
    loop {
        flight.closed().await;
        let mut flights = source.flights.lock().unwrap_or_else(PoisonError::into_inner);
        // Under the lock nobody can join; somebody may have before it.
        if flight.receiver_count() == 0 {
            flights.remove(&tile);
            return;
        }
    }
}

fn stamp(path: &Path) -> Option<(SystemTime, u64)> {
    let about = std::fs::metadata(path).ok()?;
    Some((about.modified().ok()?, about.len()))
}

fn cache_path(folder: &Path, settings: &SourceSettings) -> PathBuf {
    folder.join("cache").join(format!("{}-{}.mbtiles", settings.id, settings.fingerprint()))
}

/// Whether a file of the cache folder is a source's, by its name.
fn is_cache_of(name: &str, id: &str) -> bool {
    let rest = name.strip_prefix(id).and_then(|rest| rest.strip_prefix('-')).unwrap_or_default();
    let (hash, end) = rest.split_at_checked(16).unwrap_or_default();
    hash.chars().all(|c| c.is_ascii_hexdigit()) && end.starts_with(".mbtiles") && !hash.is_empty()
}

/// Whether a path stays in the folder that it is relative to.
pub(crate) fn is_inside(path: &str) -> bool {
    let is_plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    !path.contains('\\') && !path.contains(':') && Path::new(path).components().all(is_plain)
}

fn with_key(settings: &SourceSettings) -> String {
    let key = settings.key().map(crate::xyz::escape).unwrap_or_default();
    settings.url.as_deref().unwrap_or_default().replace("{key}", &key)
}

fn without_key(settings: &SourceSettings) -> SourceSettings {
    SourceSettings { key: None, has_key: Some(settings.key().is_some()), ..settings.clone() }
}

/// What a status other than 200 means.
fn refused(request: &Request, answer: &Answer) -> MapError {
    let words = google::words(answer.status, &answer.body);
    let help = match answer.status {
        401 | 403 => "; check the key, and whether the service may be used from here",
        429 => "; it takes no more for now",
        _ => "",
    };
    MapError::Service {
        host: crate::net::shown(&request.url),
        reason: crate::net::hide(&format!("answers with {words}{help}"), request.secret.as_deref()),
    }
}

/// How long an answer is new here.
fn lifetime(settings: &SourceSettings, answer: &Answer) -> Duration {
    let said = answer.freshness.lifetime;
    match settings.cache {
        Caching::Keep => {
            let least = Duration::from_secs(u64::from(settings.cache_min_days.unwrap_or(0)) * 86_400);
            said.unwrap_or(USUAL_LIFETIME).max(least)
        }
        Caching::Headers | Caching::None => said.unwrap_or_default(),
    }
}

fn show(kept: &Kept, origin: Origin, now_s: i64) -> Result<Tile> {
    let data = kept.data.clone().ok_or(MapError::NoTile)?;
    let picture = Picture::of(&data).ok_or(MapError::NoTile)?;
    let max_age_s = if origin == Origin::Stale { 0 } else { (kept.expires_s - now_s).clamp(0, BROWSER_S) };
    Ok(Tile { data, picture, hash: kept.hash, origin, max_age_s })
}

fn file_tile(data: Bytes, picture: Picture) -> Tile {
    let hash = crate::settings::fnv1a(&data);
    // A file may be replaced at any time.
    Tile { data, picture, hash, origin: Origin::File, max_age_s: 60 }
}

fn describe(source: &Source) -> MapSource {
    let settings = &source.settings;
    let refusal = settings.offline_refusal();
    let attribution = if settings.attribution.is_empty() {
        source.about.attribution.clone().into_iter().collect()
    } else {
        settings.attribution.clone()
    };
    let is_google = settings.kind == SourceKind::Google;
    let version = format!("{}{:?}", settings.fingerprint(), (&settings.path, &settings.corners));
    let version = format!("{:08x}", crate::settings::fnv1a(version.as_bytes()) as u32);
    MapSource {
        id: settings.id.clone(),
        name: settings.name.clone(),
        kind: settings.kind,
        role: settings.role,
        visible: settings.visible,
        opacity: settings.opacity,
        order: settings.order,
        min_zoom: settings.min_zoom,
        max_zoom: settings.max_zoom.or(source.about.max_zoom),
        bounds: settings.bounds.or(source.about.bounds),
        attribution,
        attribution_by_view: is_google || settings.attribution_url.is_some(),
        logo: is_google.then(|| "google".to_owned()),
        grid: source.grid(),
        tiles_url: format!("/api/v1/tiles/{}/{{z}}/{{x}}/{{y}}?v={version}", settings.id),
        may_cache: settings.cache == Caching::Keep && !settings.kind.is_file(),
        offline: Offline { allowed: refusal.is_none(), reason: refusal },
        needs_key: settings.needs_key(),
        has_key: settings.key().is_some(),
        corners: (settings.kind == SourceKind::Image).then(|| settings.corners.clone()),
        state: source.state(),
    }
}
