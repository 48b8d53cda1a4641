//! Google's Map Tiles API: sessions, addresses and whom to name for a view
//! (developers.google.com/maps/documentation/tile: "Use session tokens", "Viewport information").

use std::sync::Arc;

use serde::Deserialize;
use tokio::sync::Mutex;

use crate::address::escape;
use crate::cache::CachedTile;
use crate::crs::Crs;
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::grid::{TileGrid, TileId};
use crate::kind::{Kind, Opened, Opening};
use crate::live::{Asking, Live, Named, Pending, Reply, Service};
use crate::net::{Fetcher, Request, words};
use crate::settings::{Attribution, Role, SourceSettings};
use crate::sniff;

/// Where the service is, unless the settings say otherwise.
const SERVICE: &str = "https://tile.googleapis.com";
/// Bytes of an answer in JSON at most.
const MAX_JSON: usize = 256 * 1024;
/// Time before its end at which a session is renewed.
const MARGIN_S: i64 = 3600;

/// How sources of this kind are opened and read.
pub(crate) struct Driver;

impl Kind for Driver {
    fn fields(&self) -> &'static [&'static str] {
        &["key", "map_type", "language", "region"]
    }

    fn roles(&self) -> &'static [Role] {
        &[Role::Base, Role::Overlay]
    }

    fn faults(&self, settings: &SourceSettings, faults: &mut Vec<String>) {
        if settings.url.is_some() {
            settings.check_url(faults);
        }
        if settings.map_type.as_deref().is_some_and(|kind| !["satellite", "roadmap", "terrain"].contains(&kind)) {
            faults.push("map_type: satellite, roadmap or terrain".to_owned());
        }
    }

    fn open(&self, opening: &Opening<'_>) -> Opened {
        let grid = opening.standard_grid(Crs::WebMercator);
        Ok(Live::Service(Box::new(Sessions { session: Mutex::default(), grid })))
    }

    fn own_url(&self) -> Option<&'static str> {
        Some(SERVICE)
    }

    fn needs_key(&self) -> bool {
        true
    }

    fn no_offline(&self) -> Option<&'static str> {
        Some("Google's terms forbid to fetch tiles ahead and to keep them")
    }

    fn logo(&self) -> Option<&'static str> {
        Some("google")
    }

    fn is_named_by_view(&self) -> bool {
        true
    }
}

#[derive(Debug, Clone, PartialEq)]
struct Session {
    token: String,
    ends_s: i64,
}

/// The service of one source, and its session.
struct Sessions {
    session: Mutex<Option<Session>>,
    grid: Arc<TileGrid>,
}

#[derive(Deserialize)]
struct Begun {
    session: String,
    /// Seconds since 1970, as text.
    expiry: String,
}

impl Sessions {
    /// The address of a tile, in a session, which is opened if needed.
    async fn url(&self, fetcher: &Fetcher, settings: &SourceSettings, tile: TileId, now_s: i64) -> Result<String> {
        let token = self.token(fetcher, settings, now_s).await?;
        let TileId { level, column, row } = tile;
        let key = escape(settings.key().unwrap_or_default());
        Ok(format!("{}/v1/2dtiles/{level}/{column}/{row}?session={}&key={key}", service(settings), escape(&token)))
    }

    /// Drops the session after the service refused it.
    async fn forget(&self) {
        *self.session.lock().await = None;
    }

    async fn token(&self, fetcher: &Fetcher, settings: &SourceSettings, now_s: i64) -> Result<String> {
        // Held over the request, so that many tiles open one session.
        let mut session = self.session.lock().await;
        if let Some(session) = session.as_ref().filter(|session| session.ends_s - MARGIN_S > now_s) {
            return Ok(session.token.clone());
        }
        let key = settings.key().ok_or_else(|| MapError::KeyMissing(settings.id.clone()))?;
        let map_type = settings.map_type.as_deref().unwrap_or("satellite");
        let mut wanted = serde_json::json!({
            "mapType": map_type,
            "language": settings.language.as_deref().unwrap_or("en-US"),
            "region": settings.region.as_deref().unwrap_or("US"),
        });
        if map_type == "terrain" {
            // Its documentation: terrain needs this layer.
            wanted["layerTypes"] = serde_json::json!(["layerRoadmap"]);
        }
        let url = format!("{}/v1/createSession?key={}", service(settings), escape(key));
        let mut request = Request::new(settings, &url, MAX_JSON)?;
        request.json = Some(wanted.to_string());
        let answer = fetcher.fetch(&request).await?;
        let host = crate::net::shown(&request.url);
        let refused = |reason: String| MapError::Service {
            host: host.clone(),
            status: (answer.status != 200).then_some(answer.status),
            reason: format!("no session: {}", crate::net::hide(&reason, Some(key))),
        };
        if answer.status != 200 {
            return Err(refused(words(answer.status, &answer.body)));
        }
        let opened: Begun = serde_json::from_slice(&answer.body).map_err(|error| refused(error.to_string()))?;
        let ends_s = opened.expiry.parse().map_err(|_| refused("its end is not a number".to_owned()))?;
        *session = Some(Session { token: opened.session.clone(), ends_s });
        Ok(opened.session)
    }

    /// Attribution for a view, and the highest zoom with pictures there.
    async fn attribution(
        &self,
        fetcher: &Fetcher,
        settings: &SourceSettings,
        view: &Bounds,
        zoom: u8,
        now_s: i64,
    ) -> Result<Named> {
        let token = self.token(fetcher, settings, now_s).await?;
        let url = format!(
            "{}/tile/v1/viewport?session={}&key={}&zoom={zoom}&north={}&south={}&east={}&west={}",
            service(settings),
            escape(&token),
            escape(settings.key().unwrap_or_default()),
            view.north_deg,
            view.south_deg,
            view.east_deg,
            view.west_deg
        );
        fetch_attribution(fetcher, settings, &url).await
    }
}

impl Service for Sessions {
    fn grid(&self) -> Option<Arc<TileGrid>> {
        Some(self.grid.clone())
    }

    fn tile<'a>(&'a self, asking: Asking<'a>, tile: TileId, kept: Option<&'a CachedTile>) -> Pending<'a, Reply> {
        Box::pin(async move {
            let url = self.url(asking.fetcher, asking.settings, tile, asking.now_s()).await?;
            let mut answered = asking.picture(&url, kept).await?;
            // A session may be ended before its time.
            if matches!(answered.1.status, 400 | 401 | 403) {
                self.forget().await;
                let url = self.url(asking.fetcher, asking.settings, tile, asking.now_s()).await?;
                answered = asking.picture(&url, kept).await?;
            }
            asking.reply(answered, kept)
        })
    }

    fn named<'a>(&'a self, asking: Asking<'a>, view: &'a Bounds, zoom: u8) -> Option<Pending<'a, Named>> {
        Some(Box::pin(
            async move { self.attribution(asking.fetcher, asking.settings, view, zoom, asking.now_s()).await },
        ))
    }
}

fn service(settings: &SourceSettings) -> &str {
    settings.url.as_deref().unwrap_or(SERVICE).trim_end_matches('/')
}

/// Asks an address whom to name: Google's `copyright`, or Azure's `copyrights`.
pub(crate) async fn fetch_attribution(fetcher: &Fetcher, settings: &SourceSettings, url: &str) -> Result<Named> {
    #[derive(Deserialize)]
    #[serde(rename_all = "camelCase")]
    struct Said {
        copyright: Option<String>,
        #[serde(default)]
        copyrights: Vec<String>,
        #[serde(default)]
        max_zoom_rects: Vec<Rect>,
    }
    #[derive(Deserialize)]
    #[serde(rename_all = "camelCase")]
    struct Rect {
        max_zoom: u8,
    }
    let request = Request::new(settings, url, MAX_JSON)?;
    let answer = fetcher.fetch(&request).await?;
    let failed = |reason: String| MapError::Service {
        host: crate::net::shown(&request.url),
        status: (answer.status != 200).then_some(answer.status),
        reason: crate::net::hide(&reason, request.secret.as_deref()),
    };
    if answer.status != 200 {
        return Err(failed(words(answer.status, &answer.body)));
    }
    let said: Said = serde_json::from_slice(&answer.body).map_err(|error| failed(error.to_string()))?;
    let texts = said.copyright.into_iter().chain(said.copyrights);
    let texts = texts.map(|text| sniff::words(text.as_bytes())).filter(|text| !text.is_empty()).take(20);
    let named = texts.map(|text| Attribution { text, url: None }).collect();
    Ok((named, said.max_zoom_rects.iter().map(|rect| rect.max_zoom).max()))
}
