//! Sources as clients see them: grid, attribution and health.

use serde::Serialize;
use utoipa::ToSchema;

use crate::geo::{Bounds, Corner};
use crate::grid::TileGrid;
use crate::settings::{Attribution, Caching, Role, SourceKind, SourceSettings};
use crate::source::{Source, SourceState};

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
    /// Display name.
    pub name: String,
    /// How it is read.
    pub kind: SourceKind,
    /// Its role.
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
    /// Whether offline areas of it are allowed.
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
    /// The fault of the file; the last valid one is in use.
    #[schema(required = true)]
    pub file_error: Option<String>,
}

/// All settings, for an editor.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapConfiguration {
    /// In the order of [`MapSources`], without keys.
    pub sources: Vec<SourceSettings>,
    /// Megabytes of the cache of a source without its own limit.
    pub cache_max_mb: u32,
    /// The maps folder, on the server's machine.
    pub folder: String,
    /// The file of the sources.
    pub file: String,
    /// The fault of the file.
    #[schema(required = true)]
    pub file_error: Option<String>,
}

pub(crate) fn describe(source: &Source) -> MapSource {
    let settings = &source.settings;
    let refusal = settings.offline_refusal();
    let about = source.live.about();
    let driver = settings.kind.driver();
    let attribution = if settings.attribution.is_empty() {
        about.attribution.clone().into_iter().collect()
    } else {
        settings.attribution.clone()
    };
    let version = format!("{}{:?}", settings.fingerprint(), (&settings.path, &settings.url, &settings.corners));
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
        max_zoom: settings.max_zoom.or(about.max_zoom),
        bounds: settings.bounds.or(about.bounds),
        attribution,
        attribution_by_view: driver.is_named_by_view() || settings.attribution_url.is_some(),
        logo: driver.logo().map(str::to_owned),
        grid: source.grid().map(|grid| (*grid).clone()),
        tiles_url: format!("/api/v1/tiles/{}/{{z}}/{{x}}/{{y}}?v={version}", settings.id),
        may_cache: settings.cache == Caching::Keep && !settings.is_file(),
        offline: Offline { allowed: refusal.is_none(), reason: refusal },
        needs_key: settings.needs_key(),
        has_key: settings.key().is_some(),
        corners: driver.fields().contains(&"corners").then(|| settings.corners.clone()),
        state: source.state(),
    }
}
