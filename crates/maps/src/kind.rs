//! The interface of a kind of map source: how its settings are checked, how it is opened, and the fields of its form.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Serialize;
use utoipa::ToSchema;

use crate::aside::Asides;
use crate::cache::Cache;
use crate::capabilities::Capabilities;
use crate::crs::Crs;
use crate::error::Result;
use crate::grid::TileGrid;
use crate::live::{About, Live, TileFile};
use crate::settings::{Role, SourceKind, SourceSettings};

/// Default highest zoom.
const DEFAULT_MAX_ZOOM: u8 = 19;

/// A kind of source. What only one kind needs has a default.
pub(crate) trait Kind: Sync {
    /// Names of the settings that it takes in addition to those of all kinds, for forms.
    fn fields(&self) -> &'static [&'static str];

    /// Roles that its sources can have; the first is the default.
    fn roles(&self) -> &'static [Role] {
        &[Role::Base, Role::Overlay, Role::Elevation]
    }

    /// Whether such a source is read from files of this machine: by default, whether it has a path.
    fn is_file(&self, _: &SourceSettings) -> bool {
        self.fields().contains(&"path")
    }

    /// Adds the faults of the fields of [`Self::fields`], each naming its field; by default those of the path.
    fn faults(&self, settings: &SourceSettings, faults: &mut Vec<String>) {
        check_path(settings, "", faults);
    }

    /// Opens a source. Blocks.
    ///
    /// # Errors
    /// The fault, as a sentence.
    fn open(&self, opening: &Opening<'_>) -> std::result::Result<Live, String>;

    /// Ends of the names of its files, in small letters, with their dots.
    fn file_ends(&self) -> &'static [&'static str] {
        &[]
    }

    /// Parts of addresses that show a service of the kind, in small letters.
    fn address_signs(&self) -> &'static [&'static str] {
        &[]
    }

    /// Examines an uploaded file, which may turn out to be of another kind. Blocks.
    ///
    /// # Errors
    /// The fault, as a sentence.
    fn look(&self, _path: &Path) -> std::result::Result<(SourceKind, About), String> {
        Err("is of no kind whose files are handed in".to_owned())
    }

    /// Folder in which uploaded files form one source; `None` where each is a source.
    fn shelf(&self) -> Option<Shelf> {
        None
    }

    /// Bytes of a folder's files, when the folder can be a source of this kind. Blocks.
    fn folder_bytes(&self, _folder: &Path) -> Option<u64> {
        None
    }

    /// How a service's capabilities are requested; `None` where it has none.
    fn offer(&self) -> Option<Offer> {
        None
    }

    /// Default address of the service.
    fn own_url(&self) -> Option<&'static str> {
        None
    }

    /// Whether its service always requires a key.
    fn needs_key(&self) -> bool {
        false
    }

    /// Why offline areas of it are forbidden, whatever the settings say.
    fn no_offline(&self) -> Option<&'static str> {
        None
    }

    /// Whose logo must be shown, by a word.
    fn logo(&self) -> Option<&'static str> {
        None
    }

    /// Whether the service gives the attribution for a view.
    fn is_named_by_view(&self) -> bool {
        false
    }

    /// The one picture that the source is made of, as it lies on the disk. Blocks.
    fn picture(&self, _path: &Path) -> Option<std::result::Result<Vec<u8>, String>> {
        None
    }
}

/// Where files that are one source together lie.
pub(crate) struct Shelf {
    /// Below `files/`.
    pub(crate) folder: &'static str,
    /// First name of the source.
    pub(crate) name: &'static str,
}

/// How a service is asked what it offers.
pub(crate) struct Offer {
    /// The address of its capabilities, from any address of it.
    pub(crate) url: fn(&str) -> Result<String>,
    /// Reads them.
    pub(crate) read: fn(&[u8]) -> std::result::Result<Capabilities, String>,
}

/// With what a source is opened.
pub(crate) struct Opening<'a> {
    pub(crate) settings: &'a SourceSettings,
    pub(crate) folder: &'a Path,
    pub(crate) cache: Option<&'a Arc<Cache>>,
    pub(crate) asides: &'a Arc<Asides>,
}

impl Opening<'_> {
    /// Its file.
    pub(crate) fn path(&self) -> PathBuf {
        self.folder.join(self.settings.path.as_deref().unwrap_or_default())
    }

    /// Pixels of a tile's side.
    pub(crate) fn tile_px(&self) -> u32 {
        self.settings.tile_px.unwrap_or(256)
    }

    /// The usual grid of a system, within what the settings say.
    pub(crate) fn standard_grid(&self, crs: Crs) -> Arc<TileGrid> {
        let max_zoom = self.settings.max_zoom.unwrap_or(DEFAULT_MAX_ZOOM);
        let grid = TileGrid::standard(crs, self.tile_px(), self.settings.min_zoom.unwrap_or(0), max_zoom);
        Arc::new(grid.within(self.settings.bounds.as_ref()))
    }

    /// Tiles of a file whose levels are the zooms of Web Mercator: the settings say which of them are used.
    pub(crate) fn zoomed(&self, file: std::result::Result<impl TileFile + 'static, String>) -> Opened {
        let file = self.named(file)?;
        let mut grid = bounded(self.settings, file.grid().clone());
        grid.max_level = grid.max_level.min(self.settings.max_zoom.unwrap_or(u8::MAX));
        grid.min_level = grid.min_level.max(self.settings.min_zoom.unwrap_or(0)).min(grid.max_level);
        Ok(Live::File(Arc::new(file), Arc::new(grid)))
    }

    /// Tiles of a file whose levels are its own.
    pub(crate) fn levelled(&self, file: std::result::Result<impl TileFile + 'static, String>) -> Opened {
        let file = self.named(file)?;
        let grid = bounded(self.settings, file.grid().clone());
        Ok(Live::File(Arc::new(file), Arc::new(grid)))
    }

    /// What came of opening its file, whose name is said with what is wrong.
    pub(crate) fn named<T>(&self, file: std::result::Result<T, String>) -> std::result::Result<T, String> {
        file.map_err(|error| format!("{}: {error}", self.settings.path.as_deref().unwrap_or_default()))
    }
}

/// What came of opening a source.
pub(crate) type Opened = std::result::Result<Live, String>;

/// A grid within the bounds that the settings say.
pub(crate) fn bounded(settings: &SourceSettings, mut grid: TileGrid) -> TileGrid {
    if let Some(bounds) = &settings.bounds {
        grid.extent = Some(bounds.extent_in(grid.crs));
    }
    grid
}

/// Adds that the path is missing; `or` says what else would do.
pub(crate) fn check_path(settings: &SourceSettings, or: &str, faults: &mut Vec<String>) {
    if settings.path.as_deref().is_none_or(|path| path.trim().is_empty()) {
        faults.push(format!("path: which file is needed{or}"));
    }
}

/// A kind of source as forms and programs need to know it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = MapKind)]
pub struct KindInfo {
    /// Its name.
    pub kind: SourceKind,
    /// Settings that it takes in addition to those of all kinds.
    pub fields: Vec<&'static str>,
    /// Roles that its sources can have; the first is the default.
    pub roles: Vec<Role>,
    /// Ends of the names of files that can be handed in, in small letters, such as `.mbtiles`.
    pub file_ends: Vec<&'static str>,
    /// Parts of addresses that indicate a service of this kind, in lower case: placeholders such as `{x}` weigh most,
    /// then queries such as `service=wms`, then the ends of files, and words of the path least.
    pub address_signs: Vec<&'static str>,
    /// Whether a service of this kind has capabilities.
    pub has_capabilities: bool,
    /// Whether its service demands a key, whatever the address is.
    pub needs_key: bool,
}
