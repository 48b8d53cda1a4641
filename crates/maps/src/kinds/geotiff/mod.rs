//! GeoTIFFs: a file of this machine, or one of the network that is read in parts. Its metadata are kept
//! with the cache, so that cached tiles work without the network.

pub(crate) mod cog;
pub mod file;
mod georef;
mod image;
mod input;
mod lzw;
mod tags;

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use crate::cache::{Cache, CachedTile};
use crate::error::Result;
use crate::grid::{TileGrid, TileId};
use crate::kind::{Kind, Opened, Opening, bounded, check_path};
use crate::live::{About, Asking, Live, Pending, Reply, Service, TileFile};
use crate::settings::{Role, SourceKind, SourceSettings};
use crate::task::blocking;
use cog::{Known, Made, RemoteTiff};
use file::GeoTiff;

/// Note of the cache that holds where the tiles are.
const NOTE: &str = "geotiff";

/// How sources of this kind are opened and read.
pub(crate) struct Driver;

impl Kind for Driver {
    fn fields(&self) -> &'static [&'static str] {
        &["path", "url", "key", "local_network", "cache"]
    }

    fn roles(&self) -> &'static [Role] {
        &[Role::Base, Role::Overlay]
    }

    fn is_file(&self, settings: &SourceSettings) -> bool {
        settings.url.is_none()
    }

    fn faults(&self, settings: &SourceSettings, faults: &mut Vec<String>) {
        if self.is_file(settings) {
            check_path(settings, ", or the url of one", faults);
            return;
        }
        let url = settings.check_url(faults);
        if url.replace("{key}", "").contains('{') {
            faults.push("url: of a GeoTIFF has no place but {key}".to_owned());
        }
        if settings.path.is_some() {
            faults.push("path: a GeoTIFF has a path or a url, not both".to_owned());
        }
        if settings.role == Role::Elevation {
            faults.push("role: a GeoTIFF by its address is shown, not used as heights".to_owned());
        }
    }

    fn open(&self, opening: &Opening<'_>) -> Opened {
        if self.is_file(opening.settings) {
            return opening.levelled(GeoTiff::open(&opening.path()));
        }
        let noted = opening.cache.and_then(|cache| cache.note(NOTE).ok().flatten());
        let known: Option<Known> = noted.and_then(|text| serde_json::from_str(&text).ok());
        let known = known.and_then(|known| {
            let grid = Arc::new(bounded(opening.settings, known.grid()?));
            Some((known, grid))
        });
        let (remote, cache) = (RemoteTiff::new(opening.asides.clone()), opening.cache.cloned());
        Ok(Live::Service(Box::new(Remote { remote, known: Mutex::new(known), cache })))
    }

    fn file_ends(&self) -> &'static [&'static str] {
        &[".tif", ".tiff"]
    }

    fn look(&self, path: &Path) -> std::result::Result<(SourceKind, About), String> {
        let file = GeoTiff::open(path)?;
        // One of numbers is one of heights.
        let kind = if file.is_heights() { SourceKind::Dem } else { SourceKind::Geotiff };
        Ok((kind, file.about()))
    }
}

/// A GeoTIFF of the network.
struct Remote {
    remote: RemoteTiff,
    /// `None` until its first part was read.
    known: Mutex<Option<(Known, Arc<TileGrid>)>>,
    cache: Option<Arc<Cache>>,
}

impl Remote {
    fn known(&self) -> Option<(Known, Arc<TileGrid>)> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    async fn ask(&self, asking: Asking<'_>) -> Result<()> {
        let settings = asking.settings;
        let found = self.remote.known(asking.fetcher, settings, &settings.url_with_key(), asking.now_s()).await?;
        let grid = found.grid().ok_or_else(|| settings.unusable("its system is not known here"))?;
        if let (Some(cache), Ok(text)) = (self.cache.clone(), serde_json::to_string(&found)) {
            blocking(move || cache.set_note(NOTE, &text)).await?;
        }
        let grid = Arc::new(bounded(settings, grid));
        *self.known.lock().unwrap_or_else(PoisonError::into_inner) = Some((found, grid));
        Ok(())
    }

    async fn make(&self, asking: Asking<'_>, tile: TileId, kept: Option<&CachedTile>) -> Result<Reply> {
        let (settings, fetcher, url) = (asking.settings, asking.fetcher, asking.settings.url_with_key());
        let _turn = self.remote.turn().await?;
        asking.is_wanted()?;
        let known = kept.filter(|kept| kept.data.is_some()).zip(kept.and_then(|kept| kept.etag.as_deref()));
        if let Some((kept, mark)) = known
            && let Some(freshness) = self.remote.is_still(mark, fetcher, settings, &url, asking.now_s()).await?
        {
            return Ok(Reply::Same(kept.clone(), freshness));
        }
        let grid = self.grid();
        let made = self.remote.tile(fetcher, settings, &url, tile, asking.now_s()).await?;
        if !self.remote.lies_on(grid.as_deref()).await {
            return Err(settings.unusable(cog::MOVED));
        }
        let Made { data, mark, freshness, bytes } = made;
        asking.came(bytes);
        Ok(Reply::New { data, etag: Some(mark), last_modified: None, freshness })
    }
}

impl Service for Remote {
    fn grid(&self) -> Option<Arc<TileGrid>> {
        self.known().map(|(_, grid)| grid)
    }

    fn about(&self) -> About {
        self.known().map(|(known, _)| known.about()).unwrap_or_default()
    }

    fn load_capabilities<'a>(&'a self, asking: Asking<'a>) -> Pending<'a, ()> {
        Box::pin(self.ask(asking))
    }

    fn tile<'a>(&'a self, asking: Asking<'a>, tile: TileId, kept: Option<&'a CachedTile>) -> Pending<'a, Reply> {
        Box::pin(self.make(asking, tile, kept))
    }
}
