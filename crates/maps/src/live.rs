//! Opened sources, independent of their kind: tiles of a file, tiles of a service, heights.

use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bytes::Bytes;

use crate::cache::CachedTile;
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::grid::{TileGrid, TileId};
use crate::net::{Answer, Fetcher, Freshness, Request, refused};
use crate::settings::{Attribution, SourceSettings};
use crate::{sniff, xml};

/// Bytes of a service's tile at most.
const MAX_TILE: usize = 8 * 1024 * 1024;

/// An opened source.
pub(crate) enum Live {
    /// A file of this machine, or a folder of them, and the part of its grid that the settings leave.
    File(Arc<dyn TileFile>, Arc<TileGrid>),
    /// Asked over the network; what comes is kept in a cache.
    Service(Box<dyn Service>),
    /// Heights of this machine, which are not drawn.
    Heights(Arc<dyn HeightFile>),
    /// Cannot be used, and why.
    Unusable(String),
}

impl Live {
    /// The grid of its tiles, as far as it is known.
    pub(crate) fn grid(&self) -> Option<Arc<TileGrid>> {
        match self {
            Self::File(_, grid) => Some(grid.clone()),
            Self::Service(service) => service.grid(),
            Self::Heights(_) | Self::Unusable(_) => None,
        }
    }

    /// Its description.
    pub(crate) fn about(&self) -> About {
        match self {
            Self::File(file, _) => file.about(),
            Self::Service(service) => service.about(),
            Self::Heights(heights) => About { bounds: heights.bounds(), ..About::default() },
            Self::Unusable(_) => About::default(),
        }
    }
}

/// A file, or a folder of files, whose tiles are shown.
pub trait TileFile: Send + Sync {
    /// The grid of its tiles.
    fn grid(&self) -> &TileGrid;
    /// Its description.
    fn about(&self) -> About;
    /// A tile's picture; `None` without one there. Blocks.
    ///
    /// # Errors
    /// [`crate::MapError::Unusable`] when the file is broken.
    fn tile(&self, tile: TileId) -> Result<Option<Bytes>>;
}

/// Heights of a file or of a folder of files.
pub trait HeightFile: Send + Sync {
    /// Where it has heights.
    fn bounds(&self) -> Option<Bounds>;
    /// The height at a place; `None` outside of its data and beside voids. Blocks.
    ///
    /// # Errors
    /// [`MapError::MapFile`] when a file is broken.
    fn height(&self, lat_deg: f64, lon_deg: f64) -> Result<Option<Height>>;
}

/// A height with how far apart heights are there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Height {
    /// Above the source's datum.
    pub alt_m: f64,
    /// Between neighbouring heights.
    pub resolution_m: f64,
}

/// Description of a source.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct About {
    /// Its name.
    pub name: Option<String>,
    /// Where it has something.
    pub bounds: Option<Bounds>,
    /// Whom to name.
    pub attribution: Option<Attribution>,
    /// Whether it is made to lie over another map.
    pub is_overlay: bool,
    /// Finest zoom, for Web Mercator tiles.
    pub max_zoom: Option<u8>,
}

/// A pending answer of a service.
pub(crate) type Pending<'a, T> = Pin<Box<dyn Future<Output = Result<T>> + Send + 'a>>;

/// Attribution for a view, and the highest zoom with pictures in it.
pub(crate) type Named = (Vec<Attribution>, Option<u8>);

/// A service of the network.
pub(crate) trait Service: Send + Sync {
    /// The grid of its tiles, as far as it is known.
    fn grid(&self) -> Option<Arc<TileGrid>>;

    /// Its description.
    fn about(&self) -> About {
        About::default()
    }

    /// Loads what is needed before the first tile: its grid.
    fn load_capabilities<'a>(&'a self, _asking: Asking<'a>) -> Pending<'a, ()> {
        Box::pin(async { Ok(()) })
    }

    /// Requests a tile. `kept` is the cached one, which may still be valid.
    fn tile<'a>(&'a self, asking: Asking<'a>, tile: TileId, kept: Option<&'a CachedTile>) -> Pending<'a, Reply>;

    /// Requests the attribution for a view; `None` where the service has none.
    fn named<'a>(&'a self, _asking: Asking<'a>, _view: &'a Bounds, _zoom: u8) -> Option<Pending<'a, Named>> {
        None
    }
}

/// A service's answer about a tile.
pub(crate) enum Reply {
    /// The cached tile is still valid.
    Same(CachedTile, Freshness),
    /// There is no tile.
    None,
    /// A picture; no data where nothing is to be drawn.
    New { data: Option<Bytes>, etag: Option<String>, last_modified: Option<String>, freshness: Freshness },
    /// An error, and for how long the service asks not to be called.
    Refused(MapError, Option<Duration>),
}

/// Context of a request to a service.
#[derive(Clone, Copy)]
pub(crate) struct Asking<'a> {
    pub(crate) settings: &'a SourceSettings,
    pub(crate) fetcher: &'a Fetcher,
    pub(crate) clock: &'a (dyn Fn() -> i64 + Send + Sync),
    /// Why the request is not to be made after all: the source may have failed while it waited for its turn.
    pub(crate) refusal: &'a (dyn Fn() -> Option<MapError> + Send + Sync),
    /// Counts the bytes that came.
    pub(crate) bytes: &'a AtomicU64,
}

impl Asking<'_> {
    /// Seconds since 1970.
    pub(crate) fn now_s(&self) -> i64 {
        (self.clock)()
    }

    /// Counts bytes that came.
    pub(crate) fn came(&self, bytes: u64) {
        self.bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Whether the request is still to be made.
    pub(crate) fn is_wanted(&self) -> Result<()> {
        (self.refusal)().map_or(Ok(()), Err)
    }

    /// A document of the service, such as its capabilities.
    pub(crate) async fn document(&self, url: &str) -> Result<Bytes> {
        let request = Request::new(self.settings, url, xml::MAX_BYTES)?;
        let answer = self.fetcher.fetch(&request).await?;
        if answer.status == 200 { Ok(answer.body) } else { Err(refused(&request, &answer)) }
    }

    /// Asks an address for a tile.
    pub(crate) async fn picture(&self, url: &str, kept: Option<&CachedTile>) -> Result<(Request, Answer)> {
        let mut request = Request::new(self.settings, url, MAX_TILE)?;
        if let Some(kept) = kept.filter(|kept| kept.data.is_some()) {
            request.etag.clone_from(&kept.etag);
            request.last_modified.clone_from(&kept.last_modified);
        }
        let turn = self.fetcher.turn(&request).await?;
        self.is_wanted()?;
        let answer = self.fetcher.fetch_in_turn(&request, turn).await?;
        Ok((request, answer))
    }

    /// Interprets an answer about a tile.
    pub(crate) fn reply(&self, (request, answer): (Request, Answer), kept: Option<&CachedTile>) -> Result<Reply> {
        self.came(answer.body.len() as u64);
        let failed = |reason: String| MapError::Service {
            host: crate::net::shown(&request.url),
            status: None,
            reason: crate::net::hide(&reason, request.secret.as_deref()),
        };
        match answer.status {
            304 => {
                let kept =
                    kept.ok_or_else(|| failed("says that nothing changed, though nothing was known".to_owned()))?;
                Ok(Reply::Same(kept.clone(), answer.freshness))
            }
            204 | 404 | 410 => Ok(Reply::None),
            200 => {
                if let Err(reason) = sniff::check_picture(&answer.body) {
                    let root = answer.body.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'<');
                    let root = root.then(|| xml::Element::parse(&answer.body).ok()).flatten();
                    return Err(match root.as_ref().and_then(xml::exception) {
                        Some(said) => failed(said),
                        None => failed(format!("answers with {reason}")),
                    });
                }
                let Answer { body, etag, last_modified, freshness, .. } = answer;
                Ok(Reply::New { data: Some(body), etag, last_modified, freshness })
            }
            _ => {
                let root = xml::Element::parse(&answer.body).ok();
                let error = match root.as_ref().and_then(xml::exception) {
                    // How tile services report a missing tile.
                    Some(said) if said.contains("TileOutOfRange") => return Ok(Reply::None),
                    Some(said) => failed(said),
                    None => refused(&request, &answer),
                };
                Ok(Reply::Refused(error, answer.retry_after.filter(|_| matches!(answer.status, 429 | 503))))
            }
        }
    }

    /// Asks an address for a tile, and says what its answer says.
    pub(crate) async fn tile(&self, url: &str, kept: Option<&CachedTile>) -> Result<Reply> {
        let answered = self.picture(url, kept).await?;
        self.reply(answered, kept)
    }
}
