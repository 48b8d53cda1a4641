//! Web Map Tile Services 1.0.0 (OGC 07-057r7). The grid of a layer is its service's own: it is asked once, and kept
//! with the cache, so that the map works without the network.

pub mod service;

use std::sync::{Arc, Mutex, PoisonError};

use crate::cache::{Cache, CachedTile};
use crate::error::{MapError, Result};
use crate::grid::{TileGrid, TileId};
use crate::kind::{Kind, Offer, Opened, Opening, bounded};
use crate::live::{Asking, Live, Pending, Reply, Service};
use crate::settings::SourceSettings;
use crate::task::blocking;
use service::{Layer, capabilities_url, read_capabilities, read_layer};

/// Note of the cache that holds the layer.
const NOTE: &str = "wmts_layer";

/// How sources of this kind are opened and read.
pub(crate) struct Driver;

impl Kind for Driver {
    fn fields(&self) -> &'static [&'static str] {
        &[
            "url",
            "key",
            "local_network",
            "layer",
            "matrix_set",
            "style",
            "format",
            "parameters",
            "encoding",
            "below_sea_level",
            "cache",
        ]
    }

    fn address_signs(&self) -> &'static [&'static str] {
        &["service=wmts", "wmts"]
    }

    fn faults(&self, settings: &SourceSettings, faults: &mut Vec<String>) {
        settings.check_url(faults);
        if settings.layer.is_none() {
            faults.push("layer: which is needed; POST /api/v1/maps/capabilities lists them".to_owned());
        }
    }

    fn open(&self, opening: &Opening<'_>) -> Opened {
        let noted = opening.cache.and_then(|cache| cache.note(NOTE).ok().flatten());
        let layer: Option<Layer> = noted.and_then(|text| serde_json::from_str(&text).ok());
        let known = layer.and_then(|layer| Known::of(layer, opening.settings));
        Ok(Live::Service(Box::new(Tiles { known: Mutex::new(known), cache: opening.cache.cloned() })))
    }

    fn offer(&self) -> Option<Offer> {
        Some(Offer { url: capabilities_url, read: read_capabilities })
    }
}

/// A layer, and the grid that the settings leave of it.
#[derive(Clone)]
struct Known {
    layer: Arc<Layer>,
    grid: Arc<TileGrid>,
}

impl Known {
    fn of(layer: Layer, settings: &SourceSettings) -> Option<Self> {
        let grid = Arc::new(bounded(settings, layer.grid()?));
        Some(Self { layer: Arc::new(layer), grid })
    }
}

/// A layer of a service.
struct Tiles {
    /// `None` until its capabilities were read.
    known: Mutex<Option<Known>>,
    cache: Option<Arc<Cache>>,
}

impl Tiles {
    fn known(&self) -> Option<Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    async fn ask(&self, asking: Asking<'_>) -> Result<()> {
        let settings = asking.settings;
        let document = asking.document(&capabilities_url(&settings.url_with_key())?).await?;
        let layer = read_layer(&document, settings).map_err(|reason| settings.unusable(reason))?;
        let note = serde_json::to_string(&layer).ok();
        let known = Known::of(layer, settings)
            .ok_or_else(|| settings.unusable("its matrix set is in a system that is not known here"))?;
        if let Some((cache, note)) = self.cache.clone().zip(note) {
            blocking(move || cache.set_note(NOTE, &note)).await?;
        }
        *self.known.lock().unwrap_or_else(PoisonError::into_inner) = Some(known);
        Ok(())
    }
}

impl Service for Tiles {
    fn grid(&self) -> Option<Arc<TileGrid>> {
        self.known().map(|known| known.grid)
    }

    fn load_capabilities<'a>(&'a self, asking: Asking<'a>) -> Pending<'a, ()> {
        Box::pin(self.ask(asking))
    }

    fn tile<'a>(&'a self, asking: Asking<'a>, tile: TileId, kept: Option<&'a CachedTile>) -> Pending<'a, Reply> {
        Box::pin(async move {
            let settings = asking.settings;
            let known = self.known().ok_or_else(|| settings.unusable("its capabilities have not been read"))?;
            if !known.layer.has(tile) {
                return Err(MapError::NoTile);
            }
            asking.tile(&known.layer.url(settings, tile)?, kept).await
        })
    }
}
