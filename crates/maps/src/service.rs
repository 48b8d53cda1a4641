//! The maps of a station: the sources of their file, their tiles through the caches, and changes to them.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use tokio::sync::{Semaphore, watch};
use vencejo_store::{Class, LowSpace, Space};

use crate::address::url_fault;
use crate::aside::Asides;
use crate::cache::Cache;
use crate::capabilities::Capabilities;
use crate::downloads::Running;
use crate::elevation::HeightTile;
use crate::error::{MapError, Result};
use crate::file::{DEFAULT_CACHE_MAX_MB, Sources, SourcesFile};
use crate::geo::Bounds;
use crate::grid::{TileGrid, TileId};
use crate::kinds::google::fetch_attribution;
use crate::listing::{MapConfiguration, MapSource, MapSources};
use crate::live::{Asking, Live};
use crate::net::{Fetcher, Patience, Request, refused};
use crate::settings::{Attribution, Role, SourceKind, SourceSettings};
use crate::source::Source;
use crate::stamp::Stamp;
use crate::task::blocking;
use crate::xml;

/// Stands for a service's capabilities among the tiles that failed.
pub(crate) const CAPABILITIES: TileId = TileId { level: u8::MAX, column: 0, row: 0 };

/// Age from which a temporary file counts as abandoned.
const LEFTOVER: Duration = Duration::from_secs(86_400);

/// How maps are started.
#[derive(Clone)]
pub struct MapsConfig {
    /// Where `sources.toml`, `files/` and `cache/` are; created if missing.
    pub folder: PathBuf,
    /// How long services are given.
    pub patience: Patience,
    /// Seconds since 1970.
    pub clock: Arc<dyn Fn() -> i64 + Send + Sync>,
    /// How much of the disk stays free.
    pub space: Space,
}

impl MapsConfig {
    /// With this machine's clock.
    pub fn new(folder: PathBuf) -> Self {
        let clock = || {
            let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
            i64::try_from(since.as_secs()).unwrap_or(i64::MAX)
        };
        Self { folder, patience: Patience::default(), clock: Arc::new(clock), space: Space::default() }
    }
}

impl std::fmt::Debug for MapsConfig {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MapsConfig").field("folder", &self.folder).finish_non_exhaustive()
    }
}

/// A problem with the folder of the maps. Maps are shown all the same.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FolderProblem {
    /// It is read-only, with the system's error. Cached tiles are shown, and nothing more is kept.
    Unwritable(String),
    /// The disk is too full for maps: nothing more is kept.
    LowSpace(LowSpace),
    /// The cache of a source was damaged, and a new one begun.
    SetAside {
        /// Of which source.
        source: String,
        /// New name of the damaged cache.
        aside: String,
    },
}

#[derive(Default)]
struct State {
    sources: Vec<Arc<Source>>,
    file_error: Option<String>,
    stamp: Option<FileStamp>,
    cache_max_mb: u32,
}

type HeightKey = (String, TileId);

pub(crate) struct Shared {
    pub(crate) config: MapsConfig,
    pub(crate) fetcher: Fetcher,
    pub(crate) file: SourcesFile,
    /// Why the folder was read-only at the start.
    unwritable: Option<String>,
    state: RwLock<State>,
    /// When the files of the sources were looked at last, seconds since 1970.
    looked_s: AtomicI64,
    /// Held while the file is read or changed.
    pub(crate) edits: tokio::sync::Mutex<()>,
    /// Unpacked, by source and tile, the newest last.
    pub(crate) heights: Mutex<Vec<(HeightKey, Arc<HeightTile>)>>,
    pub(crate) areas: Running,
    pub(crate) asides: Arc<Asides>,
    /// Files that are read at once.
    pub(crate) readers: Semaphore,
    pub(crate) closing: watch::Sender<bool>,
    /// Counts changes of sources and areas.
    pub(crate) news: watch::Sender<u64>,
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

/// Files that are read at once.
const READERS: usize = 4;
/// How often it is looked whether files of sources were replaced, seconds.
const LOOK_EVERY_S: u64 = 5;

impl Maps {
    /// Starts the maps of a folder, and resumes its offline areas. To be awaited on the runtime that they are to use.
    ///
    /// A read-only folder is not an error, nor is an invalid file of sources: see [`Self::problems`] and the list of
    /// sources. Cached tiles are shown, and nothing more is kept.
    ///
    /// # Errors
    /// [`MapError::Service`] when the network cannot be used at all, [`MapError::Closed`].
    pub async fn start(config: MapsConfig) -> Result<Self> {
        let fetcher = Fetcher::new(config.patience)?;
        let file = SourcesFile::new(config.folder.join("sources.toml"));
        let folder = config.folder.clone();
        let made = file.clone();
        let (made_ready, asides) = blocking(move || {
            let make_ready = || {
                vencejo_store::make_folder(&folder.join("files"))?;
                vencejo_store::try_folder(&folder)?;
                remove_leftovers(&folder.join("tmp"));
                if made.path().exists() { Ok(()) } else { made.create(&crate::presets::defaults()) }
            };
            Ok((make_ready(), Asides::open(&folder)))
        })
        .await?;
        let unwritable = made_ready.err().map(|error| error.to_string());
        if let Some(reason) = &unwritable {
            tracing::error!(reason, folder = %config.folder.display(), "nothing can be written in the folder of the maps");
        }
        let shared = Shared {
            config,
            fetcher,
            file,
            unwritable,
            state: RwLock::default(),
            looked_s: AtomicI64::new(i64::MIN),
            edits: tokio::sync::Mutex::default(),
            heights: Mutex::default(),
            areas: Running::default(),
            asides,
            readers: Semaphore::new(READERS),
            closing: watch::channel(false).0,
            news: watch::channel(0).0,
        };
        let maps = Self { shared: Arc::new(shared) };
        {
            let _edit = maps.shared.edits.lock().await;
            maps.reload_held().await?;
        }
        maps.resume_areas().await;
        Ok(maps)
    }

    /// Ends what is under way; downloads go on at the next start.
    pub fn close(&self) {
        self.shared.closing.send_replace(true);
        self.shared.asides.close();
        for source in self.sources() {
            if let Some(cache) = &source.cache
                && let Err(error) = cache.flush()
            {
                tracing::warn!(%error, source = source.settings.id, "which tiles were used last could not be noted");
            }
        }
    }

    /// Problems with the folder: it was read-only when the maps were started, the disk is full, or a damaged cache
    /// was set aside.
    pub fn problems(&self) -> Vec<FolderProblem> {
        let unwritable = self.shared.unwritable.clone().map(FolderProblem::Unwritable);
        let low = || self.room().err().map(FolderProblem::LowSpace);
        let aside = |source: &Arc<Source>| {
            let aside = source.cache.as_ref()?.set_aside_as()?.display().to_string();
            Some(FolderProblem::SetAside { source: source.settings.id.clone(), aside })
        };
        unwritable.or_else(low).into_iter().chain(self.sources().iter().filter_map(aside)).collect()
    }

    /// Whether maps may be written to the disk.
    pub(crate) fn room(&self) -> std::result::Result<(), LowSpace> {
        self.shared.config.space.check(Class::Maps, &self.shared.config.folder)
    }

    /// Bumped whenever sources or areas change, or a download progresses; the value is meaningless.
    pub fn news(&self) -> watch::Receiver<u64> {
        self.shared.news.subscribe()
    }

    pub(crate) fn notify_changes(&self) {
        self.shared.news.send_modify(|count| *count = count.wrapping_add(1));
    }

    pub(crate) fn now_s(&self) -> i64 {
        (self.shared.config.clock)()
    }

    /// The maps folder.
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

    /// Reads the file again when it was edited by hand, and reopens sources whose files were replaced.
    ///
    /// # Errors
    /// [`MapError::Storage`], [`MapError::Closed`].
    pub async fn refresh(&self) -> Result<()> {
        if !self.is_current().await? || self.has_outdated().await? {
            let _edit = self.shared.edits.lock().await;
            self.reload_held().await?;
        }
        Ok(())
    }

    pub(crate) async fn reload(&self) -> Result<()> {
        let _edit = self.shared.edits.lock().await;
        self.reload_held().await
    }

    /// Lock for changing the sources, with the file read again: it may have been edited by hand or by another instance.
    pub(crate) async fn begin_edit(&self) -> Result<tokio::sync::MutexGuard<'_, ()>> {
        let edit = self.shared.edits.lock().await;
        if !self.is_current().await? {
            self.reload_held().await?;
        }
        Ok(edit)
    }

    async fn is_current(&self) -> Result<bool> {
        let file = self.shared.file.clone();
        let stamp = blocking(move || Ok(stamp(file.path()))).await?;
        Ok(self.shared.state.read().unwrap_or_else(PoisonError::into_inner).stamp == stamp)
    }

    /// Whether the files of a source are others than were opened. Looked at every few seconds: a folder may hold
    /// thousands.
    async fn has_outdated(&self) -> Result<bool> {
        let (now_s, looked_s) = (self.now_s(), &self.shared.looked_s);
        if looked_s.load(Ordering::Relaxed).abs_diff(now_s) < LOOK_EVERY_S {
            return Ok(false);
        }
        looked_s.store(now_s, Ordering::Relaxed);
        let sources = self.sources();
        blocking(move || Ok(sources.iter().any(|source| source.is_outdated()))).await
    }

    /// To be called while `edits` is held.
    pub(crate) async fn reload_held(&self) -> Result<()> {
        let file = self.shared.file.clone();
        let (stamp, read) = blocking(move || Ok((stamp(file.path()), file.read()))).await?;
        match read {
            Ok(read) => {
                // The file was removed, or could not be created: then the first sources are used.
                let is_unmade = self.shared.unwritable.is_some();
                let none = || Sources {
                    cache_max_mb: DEFAULT_CACHE_MAX_MB,
                    sources: if is_unmade { crate::presets::defaults() } else { Vec::new() },
                };
                self.apply(read.unwrap_or_else(none), stamp).await
            }
            Err(error) => {
                let mut state = self.shared.state.write().unwrap_or_else(PoisonError::into_inner);
                state.file_error = Some(error.to_string());
                state.stamp = stamp;
                Ok(())
            }
        }
    }

    async fn apply(&self, read: Sources, stamp: Option<FileStamp>) -> Result<()> {
        let before = self.sources();
        let (folder, news) = (self.shared.config.folder.clone(), self.shared.news.clone());
        let asides = self.shared.asides.clone();
        let Sources { cache_max_mb, sources } = read;
        let mut opened = blocking(move || {
            let same = |settings: &SourceSettings| {
                let is_same = |source: &&Arc<Source>| source.settings == *settings && !source.is_outdated();
                before.iter().find(is_same).cloned()
            };
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
                        let cache = (!settings.is_file()).then(|| {
                            caches.get(&path).cloned().map_or_else(|| Cache::open(&path, max_bytes).map(Arc::new), Ok)
                        });
                        match cache.transpose() {
                            Ok(cache) => Arc::new(Source::open(settings, &folder, cache, asides.clone(), news.clone())),
                            Err(error) => {
                                tracing::error!(%error, source = settings.id, "the cache of a map source cannot be used");
                                Arc::new(Source::open(settings, &folder, None, asides.clone(), news.clone()))
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
        self.notify_changes();
        Ok(())
    }

    // ---- sources

    /// All sources, with the path of their file for editors. Missing capabilities are requested in the background.
    ///
    /// # Errors
    /// [`MapError::Storage`], [`MapError::Closed`].
    pub async fn list(&self, for_editor: bool) -> Result<MapSources> {
        self.refresh().await?;
        self.load_capabilities();
        let sources = self.sources();
        let file_error = self.shared.state.read().unwrap_or_else(PoisonError::into_inner).file_error.clone();
        let file = if for_editor { self.shared.file.path().display().to_string() } else { String::new() };
        let sources =
            blocking(move || Ok(sources.iter().map(|source| crate::listing::describe(source)).collect())).await?;
        Ok(MapSources { sources, file, file_error })
    }

    /// One source.
    ///
    /// # Errors
    /// [`MapError::NoSource`].
    pub async fn describe(&self, id: &str) -> Result<MapSource> {
        let source = self.source(id)?;
        blocking(move || Ok(crate::listing::describe(&source))).await
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

    /// Loads the capabilities of services where needed, in the background.
    fn load_capabilities(&self) {
        for source in self.sources() {
            if matches!(source.live, Live::Service(_)) && source.grid().is_none() {
                let maps = self.clone();
                tokio::spawn(async move { maps.known_grid(&source).await.map(drop) });
            }
        }
    }

    /// The grid of a source, asked for where it is not known.
    pub(crate) async fn known_grid(&self, source: &Arc<Source>) -> Result<Arc<TileGrid>> {
        if let Some(grid) = source.grid() {
            return Ok(grid);
        }
        match &source.live {
            Live::Unusable(reason) => return Err(source.unusable(reason.clone())),
            Live::Service(_) => {}
            Live::File(..) | Live::Heights(_) => return Err(source.unusable("it has no tiles")),
        }
        // One loads it, the others wait.
        let _loading = source.loading.lock().await;
        if let Some(grid) = source.grid() {
            return Ok(grid);
        }
        if let Some(error) = source.refusal(CAPABILITIES, self.now_s()) {
            return Err(error);
        }
        let result = self.load_grid(source).await;
        let now_s = self.now_s();
        match result {
            Ok(()) => {
                source.succeeded(Some(CAPABILITIES), now_s);
                source.grid().ok_or_else(|| source.unusable("its grid is not known"))
            }
            Err(error) => {
                source.failed(Some(CAPABILITIES), &error, None, now_s);
                Err(error)
            }
        }
    }

    /// Context of a request to a source.
    pub(crate) fn asking<'a>(
        &'a self,
        source: &'a Source,
        clock: &'a (dyn Fn() -> i64 + Send + Sync),
        refusal: &'a (dyn Fn() -> Option<MapError> + Send + Sync),
    ) -> Asking<'a> {
        let (settings, bytes) = (&source.settings, &source.counts.bytes);
        Asking { settings, fetcher: &self.shared.fetcher, clock, refusal, bytes }
    }

    /// Asks a service for its grid.
    async fn load_grid(&self, source: &Source) -> Result<()> {
        let Live::Service(service) = &source.live else { return Ok(()) };
        service.load_capabilities(self.asking(source, &|| self.now_s(), &|| None)).await
    }

    /// Capabilities of a service that need not be a source yet; only what is read from them is returned.
    ///
    /// # Errors
    /// [`MapError::Request`] for an invalid address, else as a fetch.
    pub async fn capabilities(
        &self,
        kind: SourceKind,
        url: &str,
        key: Option<&str>,
        local_network: bool,
    ) -> Result<Capabilities> {
        if let Some(fault) = url_fault(url) {
            return Err(MapError::Request(format!("url: {fault}")));
        }
        let mut settings = SourceSettings::new("new", "new", kind);
        (settings.url, settings.key) = (Some(url.to_owned()), key.map(str::to_owned));
        settings.local_network = local_network;
        let Some(offer) = kind.driver().offer() else {
            let tell: Vec<&str> =
                SourceKind::ALL.iter().filter(|kind| kind.driver().offer().is_some()).map(|kind| kind.name()).collect();
            return Err(MapError::Request(format!("kind: only {} have capabilities", tell.join(" and "))));
        };
        let request = Request::new(&settings, &(offer.url)(&settings.url_with_key())?, xml::MAX_BYTES)?;
        let answer = self.shared.fetcher.fetch(&request).await?;
        if answer.status != 200 {
            return Err(refused(&request, &answer));
        }
        let failed = |reason| MapError::Service { host: crate::net::shown(&request.url), status: None, reason };
        (offer.read)(&answer.body).map_err(failed)
    }

    /// Attribution for a view of a source, and the highest zoom with pictures there.
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
        let (clock, rest) = (|| self.now_s(), || None);
        let asked = match &source.live {
            Live::Service(service) => service.named(self.asking(&source, &clock, &rest), view, zoom),
            _ => None,
        };
        let (mut named, max_zoom) = match (asked, &settings.attribution_url) {
            (Some(asked), _) => asked.await?,
            (None, Some(template)) => {
                let key = settings.key().map(crate::address::escape).unwrap_or_default();
                let places = [
                    ("{west}", view.west_deg.to_string()),
                    ("{south}", view.south_deg.to_string()),
                    ("{east}", view.east_deg.to_string()),
                    ("{north}", view.north_deg.to_string()),
                    ("{zoom}", zoom.to_string()),
                    ("{key}", key),
                ];
                let url = places.iter().fold(template.clone(), |url, (place, value)| url.replace(place, value));
                fetch_attribution(&self.shared.fetcher, settings, &url).await?
            }
            _ => (Vec::new(), settings.max_zoom),
        };
        let mut all = settings.attribution.clone();
        all.append(&mut named);
        Ok((all, max_zoom))
    }
}

/// Identity of the file of sources when it was read: its stamp, and its inode, which changes whenever it is replaced.
type FileStamp = (Stamp, u64);

fn stamp(path: &Path) -> Option<FileStamp> {
    let about = std::fs::metadata(path).ok()?;
    #[cfg(unix)]
    let number = std::os::unix::fs::MetadataExt::ino(&about);
    #[cfg(not(unix))]
    let number = 0;
    Some((Stamp::of(&about), number))
}

/// Removes what a process that ended in the middle left behind. Another one may be writing: only what is old goes.
fn remove_leftovers(folder: &Path) {
    let Ok(files) = std::fs::read_dir(folder) else { return };
    for file in files.flatten() {
        let age = file.metadata().and_then(|about| about.modified()).ok().and_then(|at| at.elapsed().ok());
        if age.is_some_and(|age| age > LEFTOVER) {
            let _ = std::fs::remove_file(file.path());
        }
    }
}

fn cache_path(folder: &Path, settings: &SourceSettings) -> PathBuf {
    folder.join("cache").join(format!("{}-{}.mbtiles", settings.id, settings.fingerprint()))
}

/// Whether a file of the cache folder is a source's, by its name.
pub(crate) fn is_cache_of(name: &str, id: &str) -> bool {
    let rest = name.strip_prefix(id).and_then(|rest| rest.strip_prefix('-')).unwrap_or_default();
    let (hash, end) = rest.split_at_checked(16).unwrap_or_default();
    hash.chars().all(|c| c.is_ascii_hexdigit()) && end.starts_with(".mbtiles") && !hash.is_empty()
}

/// Whether a path stays in the folder that it is relative to.
pub(crate) fn is_inside(path: &str) -> bool {
    let is_plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    !path.contains('\\') && !path.contains(':') && Path::new(path).components().all(is_plain)
}

fn without_key(settings: &SourceSettings) -> SourceSettings {
    SourceSettings { key: None, has_key: Some(settings.key().is_some()), ..settings.clone() }
}
