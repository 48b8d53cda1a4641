//! Well-known sources, with the terms that each of them is used under.

use serde::Serialize;
use utoipa::ToSchema;

use crate::geo::Bounds;
use crate::settings::{Attribution, Caching, Encoding, Role, SourceKind, SourceSettings};

/// A source that can be added as it is.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = MapPreset)]
pub struct Preset {
    /// Of its settings.
    pub id: String,
    /// Display name.
    pub name: String,
    /// Its content, and the requirements of its terms.
    pub description: String,
    /// Where the terms are.
    #[schema(required = true)]
    pub terms_url: Option<String>,
    /// Whether the user needs a key.
    pub needs_key: bool,
    /// Where to get one.
    #[schema(required = true)]
    pub key_url: Option<String>,
    /// To be put as they are, with the key.
    pub settings: SourceSettings,
}

fn named(text: &str, url: &str) -> Attribution {
    Attribution { text: text.to_owned(), url: Some(url.to_owned()) }
}

/// Days that tiles of the Instituto Geográfico Nacional are new: Spain is flown once a year at most, and its services
/// send headers that would have them fetched again with each view.
const IGN_DAYS: u32 = 30;

/// Spain with its islands.
const SPAIN: Bounds = Bounds { west_deg: -18.6, south_deg: 27.2, east_deg: 4.8, north_deg: 44.2 };

fn xyz(id: &str, name: &str, url: &str, max_zoom: u8) -> SourceSettings {
    SourceSettings {
        url: Some(url.to_owned()),
        max_zoom: Some(max_zoom),
        ..SourceSettings::new(id, name, SourceKind::Xyz)
    }
}

/// All of them.
pub fn presets() -> Vec<Preset> {
    let preset = |settings: SourceSettings, key_url: Option<&str>, description: &str| Preset {
        id: settings.id.clone(),
        name: settings.name.clone(),
        description: description.to_owned(),
        terms_url: settings.terms_url.clone(),
        needs_key: settings.needs_key(),
        key_url: key_url.map(str::to_owned),
        settings,
    };
    vec![
        preset(
            pnoa(),
            None,
            "Orthophotos of Spain, 25 cm a pixel, by the Instituto Geográfico Nacional. Free under CC-BY 4.0 with attribution.",
        ),
        preset(
            ign_base(),
            None,
            "Map of Spain by the Instituto Geográfico Nacional. Free under CC-BY 4.0 with attribution.",
        ),
        preset(
            osm(),
            None,
            "The world by OpenStreetMap's volunteers, from its own servers. Their policy: say who asks, keep tiles for 7 days, \
             no downloading ahead.",
        ),
        preset(
            esri(),
            None,
            "Satellite and aerial pictures of the world by Esri. Attribution required; not to be kept for offline use.",
        ),
        preset(
            sentinel2(),
            None,
            "The world without clouds, 10 m a pixel, by EOX from Sentinel-2 pictures of 2020. CC BY-NC-SA 4.0: free where no \
             money is made; commercial use needs a licence of EOX.",
        ),
        preset(
            google("google-satellite", "Google satellite", "satellite"),
            Some("https://developers.google.com/maps/documentation/tile/get-api-key"),
            "Google's satellite pictures by its Map Tiles API, with your own key, which Google bills. Nothing may be fetched \
             ahead or kept longer than Google's answers say. In the European Economic Area Google restricts which are given out.",
        ),
        preset(
            google("google-roadmap", "Google map", "roadmap"),
            Some("https://developers.google.com/maps/documentation/tile/get-api-key"),
            "Google's street map by its Map Tiles API, with your own key, which Google bills. Nothing may be fetched ahead or \
             kept longer than Google's answers say.",
        ),
        preset(
            azure(),
            Some("https://learn.microsoft.com/azure/azure-maps/how-to-manage-account-keys"),
            "Satellite and aerial pictures by Microsoft (which ended Bing Maps in their favour), with your own key, which \
             Microsoft bills. Nothing may be kept longer than its answers say.",
        ),
        preset(
            terrain(),
            None,
            "Heights of the world, about 30 m a pixel (SRTM, EU-DEM and others, put together by Mapzen), from Amazon's open data.",
        ),
    ]
}

/// Those that a new installation begins with: all that need no key.
pub fn defaults() -> Vec<SourceSettings> {
    presets().into_iter().filter(|preset| !preset.needs_key).map(|preset| preset.settings).collect()
}

fn pnoa() -> SourceSettings {
    SourceSettings {
        url: Some("https://www.ign.es/wms-inspire/pnoa-ma".to_owned()),
        version: Some("1.3.0".to_owned()),
        layers: vec!["OI.OrthoimageCoverage".to_owned()],
        crs: Some("EPSG:4326".to_owned()),
        format: Some("image/jpeg".to_owned()),
        // 15 cm a pixel in degrees; the pictures have 25.
        max_zoom: Some(19),
        cache_min_days: Some(IGN_DAYS),
        bounds: Some(SPAIN),
        attribution: vec![named("PNOA CC-BY 4.0 scne.es, © Instituto Geográfico Nacional", "https://www.scne.es")],
        terms_url: Some("https://www.ign.es/web/ign/portal/politica-datos".to_owned()),
        order: 10,
        ..SourceSettings::new("pnoa", "PNOA orthophotos (Spain)", SourceKind::Wms)
    }
}

fn ign_base() -> SourceSettings {
    SourceSettings {
        cache_min_days: Some(IGN_DAYS),
        bounds: Some(SPAIN),
        attribution: vec![named("CC-BY 4.0 ign.es, © Instituto Geográfico Nacional", "https://www.ign.es")],
        terms_url: Some("https://www.ign.es/web/ign/portal/politica-datos".to_owned()),
        order: 20,
        ..xyz(
            "ign-base",
            "IGN base map (Spain)",
            "https://www.ign.es/wmts/ign-base?service=WMTS&request=GetTile&version=1.0.0&layer=IGNBaseTodo&style=default\
             &format=image/jpeg&tilematrixset=GoogleMapsCompatible&tilematrix={z}&tilerow={y}&tilecol={x}",
            20,
        )
    }
}

fn osm() -> SourceSettings {
    SourceSettings {
        attribution: vec![named("© OpenStreetMap contributors", "https://www.openstreetmap.org/copyright")],
        terms_url: Some("https://operations.osmfoundation.org/policies/tiles/".to_owned()),
        cache_min_days: Some(7),
        offline: false,
        offline_reason: Some(
            "OpenStreetMap's tile policy forbids to download its tiles ahead; what you have looked at is kept"
                .to_owned(),
        ),
        parallel: Some(2),
        order: 30,
        ..xyz("osm", "OpenStreetMap", "https://tile.openstreetmap.org/{z}/{x}/{y}.png", 19)
    }
}

fn esri() -> SourceSettings {
    SourceSettings {
        attribution: vec![
            named("Powered by Esri", "https://www.esri.com"),
            named(
                "Esri, Maxar, Earthstar Geographics, and the GIS User Community",
                "https://www.arcgis.com/home/item.html?id=10df2279f9684e4a9f6a7f08febac2a9",
            ),
        ],
        terms_url: Some("https://www.esri.com/en-us/legal/terms/full-master-agreement".to_owned()),
        cache: Caching::Headers,
        offline: false,
        offline_reason: Some(
            "Esri's terms forbid to download and keep its basemaps outside Esri's own software".to_owned(),
        ),
        order: 40,
        ..xyz(
            "esri-imagery",
            "Esri World Imagery",
            "https://services.arcgisonline.com/ArcGIS/rest/services/World_Imagery/MapServer/tile/{z}/{y}/{x}",
            19,
        )
    }
}

fn sentinel2() -> SourceSettings {
    SourceSettings {
        attribution: vec![
            named("Sentinel-2 cloudless by EOX IT Services GmbH", "https://cloudless.eox.at"),
            Attribution {
                text: "contains modified Copernicus Sentinel data 2020, CC BY-NC-SA 4.0".to_owned(),
                url: None,
            },
        ],
        terms_url: Some("https://cloudless.eox.at/documentation/license".to_owned()),
        // Of one year, and the same for ever.
        cache_min_days: Some(365),
        order: 50,
        ..xyz(
            "sentinel2",
            "Sentinel-2 cloudless 2020",
            "https://tiles.maps.eox.at/wmts/1.0.0/s2cloudless-2020_3857/default/g/{z}/{y}/{x}.jpg",
            14,
        )
    }
}

fn google(id: &str, name: &str, map_type: &str) -> SourceSettings {
    SourceSettings {
        map_type: Some(map_type.to_owned()),
        language: Some("es-ES".to_owned()),
        region: Some("ES".to_owned()),
        max_zoom: Some(22),
        terms_url: Some("https://developers.google.com/maps/documentation/tile/policies".to_owned()),
        attribution: vec![named("Google Maps", "https://maps.google.com")],
        cache: Caching::Headers,
        offline: false,
        offline_reason: Some("Google's terms forbid to fetch tiles ahead and to keep them".to_owned()),
        order: 60,
        ..SourceSettings::new(id, name, SourceKind::Google)
    }
}

fn azure() -> SourceSettings {
    SourceSettings {
        attribution: vec![named("© Microsoft", "https://azure.microsoft.com/products/azure-maps")],
        attribution_url: Some(
            "https://atlas.microsoft.com/map/attribution?api-version=2024-04-01&tilesetId=microsoft.imagery&zoom={zoom}\
             &bounds={west},{south},{east},{north}&subscription-key={key}"
                .to_owned(),
        ),
        terms_url: Some("https://azure.microsoft.com/support/legal/".to_owned()),
        cache: Caching::Headers,
        offline: false,
        offline_reason: Some("Microsoft's terms forbid to keep its tiles for offline use".to_owned()),
        order: 70,
        ..xyz(
            "azure-imagery",
            "Azure Maps imagery",
            "https://atlas.microsoft.com/map/tile?api-version=2024-04-01&tilesetId=microsoft.imagery&zoom={z}&x={x}&y={y}\
             &tileSize=256&subscription-key={key}",
            19,
        )
    }
}

fn terrain() -> SourceSettings {
    SourceSettings {
        role: Role::Elevation,
        encoding: Some(Encoding::Terrarium),
        datum: Some("EGM96".to_owned()),
        attribution: vec![named(
            "Terrain Tiles: Mapzen, SRTM, EU-DEM, GMTED, ETOPO1 and others",
            "https://github.com/tilezen/joerd/blob/master/docs/attribution.md",
        )],
        terms_url: Some("https://registry.opendata.aws/terrain-tiles/".to_owned()),
        // Put together in 2017.
        cache_min_days: Some(365),
        order: 10,
        ..xyz("terrain", "Terrain Tiles", "https://s3.amazonaws.com/elevation-tiles-prod/terrarium/{z}/{x}/{y}.png", 12)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_right_and_name_whom_they_owe() {
        let presets = presets();
        assert!(presets.len() >= 9);
        for preset in &presets {
            assert_eq!(preset.settings.faults(), Vec::<String>::new(), "{}", preset.id);
            assert!(!preset.settings.attribution.is_empty() && preset.terms_url.is_some(), "{}", preset.id);
            assert_eq!(preset.needs_key, preset.key_url.is_some(), "{}", preset.id);
        }
        let ids: std::collections::BTreeSet<_> = presets.iter().map(|preset| &preset.id).collect();
        assert_eq!(ids.len(), presets.len());
        assert!(defaults().iter().all(|settings| !settings.needs_key()));
    }

    #[test]
    fn terms_are_kept() {
        let find = |id: &str| presets().into_iter().find(|preset| preset.id == id).expect("a preset").settings;
        let osm = find("osm");
        assert!(osm.cache_min_days >= Some(7) && osm.offline_refusal().is_some() && osm.parallel <= Some(2));
        for id in ["google-satellite", "azure-imagery", "esri-imagery"] {
            assert!(find(id).offline_refusal().is_some() && find(id).cache == Caching::Headers, "{id}");
        }
        let pnoa = find("pnoa");
        assert_eq!((pnoa.version.as_deref(), pnoa.crs.as_deref()), (Some("1.3.0"), Some("EPSG:4326")));
        for (id, days) in [("pnoa", 30), ("ign-base", 30), ("sentinel2", 365), ("terrain", 365)] {
            assert_eq!(find(id).cache_min_days, Some(days), "{id}");
        }
        // Where the terms limit the time, only they count.
        assert!(presets().iter().all(|p| p.settings.cache == Caching::Keep || p.settings.cache_min_days.is_none()));
        assert!(pnoa.offline_refusal().is_none() && pnoa.attribution[0].text.contains("CC-BY 4.0"));
    }
}
