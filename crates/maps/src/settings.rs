//! Settings of a map source, as in its file and its form, and their validation.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;

use crate::address::{escape, url_fault};
use crate::error::MapError;
use crate::geo::{Bounds, Corner};

/// Makes the enumeration of the list.
macro_rules! source_kind {
    ($($(#[doc = $doc:literal])+ $kind:ident => $module:ident,)+) => {
        /// How a source is read.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        #[schema(as = MapSourceKind)]
        pub enum SourceKind {
            $($(#[doc = $doc])+ $kind,)+
        }

        impl SourceKind {
            /// All of them, in the order of the list.
            pub const ALL: &[Self] = &[$(Self::$kind,)+];

            /// Its name, in the file and in the API.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => stringify!($module),)+
                }
            }
        }
    };
}

every_kind!(source_kind);

/// Role of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MapRole)]
pub enum Role {
    /// One of these lies under everything.
    #[default]
    Base,
    /// Any number of these lie over it.
    Overlay,
    /// Heights of the ground, not drawn.
    Elevation,
}

/// How heights are written in pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = MapEncoding)]
pub enum Encoding {
    /// Mapzen's: red × 256 + green + blue / 256 − 32768 m.
    Terrarium,
    /// Mapbox's: −10000 + (red × 65536 + green × 256 + blue) × 0.1 m.
    TerrainRgb,
}

/// What may be kept of a service's tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MapCaching)]
pub enum Caching {
    /// All: what was seen once is shown when the network is gone.
    #[default]
    Keep,
    /// As long as the service's own headers allow, and no longer.
    Headers,
    /// Nothing.
    None,
}

/// Who is to be named with a map, as plain text.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = MapAttribution)]
pub struct Attribution {
    /// What to show.
    pub text: String,
    /// Where it leads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(required = false)]
    pub url: Option<String>,
}

/// The settings of one source. What is absent has its default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = MapSourceSettings)]
pub struct SourceSettings {
    /// 1 to 40 of `a`–`z`, `0`–`9`, `-`, `_`.
    pub id: String,
    /// Display name.
    pub name: String,
    /// How it is read.
    pub kind: SourceKind,
    /// Its role.
    #[serde(default, deserialize_with = "null_is_default")]
    #[schema(required = false)]
    pub role: Role,
    /// Whether it is shown at first.
    #[serde(default = "yes", deserialize_with = "null_is_yes")]
    #[schema(required = false, default = true)]
    pub visible: bool,
    /// 0 to 1.
    #[serde(default = "one", deserialize_with = "null_is_one")]
    #[schema(required = false, default = 1.0)]
    pub opacity: f64,
    /// Place among the others of its role, lowest first.
    #[serde(default, deserialize_with = "null_is_default")]
    #[schema(required = false)]
    pub order: i32,
    /// Zoom (of Web Mercator) from which it is shown; for tiles also the coarsest that are asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_zoom: Option<u8>,
    /// Zoom of the finest tiles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_zoom: Option<u8>,
    /// Where it has something.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounds: Option<Bounds>,
    /// Who is to be named.
    #[serde(default, deserialize_with = "null_is_default", skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub attribution: Vec<Attribution>,
    /// Address of the attribution for a view, with `{west} {south} {east} {north} {zoom} {key}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attribution_url: Option<String>,
    /// Where its terms are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terms_url: Option<String>,
    /// XYZ: address with `{z} {x} {y}`, or `{-y}`, `{q}`, `{s}`, `{switch:a,b}`, `{key}`. WMS, WMTS: the service's
    /// address. GeoTIFF: its address, where it is read over the network.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub url: Option<String>,
    /// For `{s}`.
    #[serde(default, deserialize_with = "null_is_default", skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub subdomains: Vec<String>,
    /// The user's key for the service. Written, never read: absent keeps it, empty removes it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(write_only)]
    pub key: Option<String>,
    /// Whether there is a key. Ignored in a request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub has_key: Option<bool>,
    /// Whether the service is in this network, or on this machine: without it no private address is asked. Those of the
    /// link itself (169.254.0.0/16, fe80::/10) are never asked.
    #[serde(default, deserialize_with = "null_is_default", skip_serializing_if = "std::ops::Not::not")]
    #[schema(required = false)]
    pub local_network: bool,
    /// Tiles: pixels of their side, 64 to 2048, default 256.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tile_px: Option<u32>,
    /// XYZ, folder: rows are counted from the bottom.
    #[serde(default, deserialize_with = "null_is_default", skip_serializing_if = "std::ops::Not::not")]
    #[schema(required = false)]
    pub tms: bool,
    /// WMS: layers, bottom first.
    #[serde(default, deserialize_with = "null_is_default", skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub layers: Vec<String>,
    /// WMS: a style for each layer, or empty for their defaults.
    #[serde(default, deserialize_with = "null_is_default", skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub styles: Vec<String>,
    /// WMS: `1.1.1` or `1.3.0`, the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// WMS: coordinate reference system, such as `EPSG:3857`, the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crs: Option<String>,
    /// WMS, WMTS: format of the pictures; WMS default `image/png`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub format: Option<String>,
    /// WMS: whether what is empty is to be transparent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transparent: Option<bool>,
    /// WMS: further parameters, such as `TIME`. WMTS: dimensions.
    #[serde(default, deserialize_with = "null_is_default", skip_serializing_if = "BTreeMap::is_empty")]
    #[schema(required = false)]
    pub parameters: BTreeMap<String, String>,
    /// WMTS: the layer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
    /// WMTS: the matrix set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix_set: Option<String>,
    /// WMTS: the style; the layer's default when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub style: Option<String>,
    /// Google: `satellite` (the default), `roadmap` or `terrain`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map_type: Option<String>,
    /// Google: language of the labels, such as `es-ES`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub language: Option<String>,
    /// Google: region whose borders are shown, such as `ES`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// Files: where, relative to the maps folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// Image: its corners: top left, top right, bottom right, bottom left of the picture.
    #[serde(default, deserialize_with = "null_is_default", skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub corners: Vec<Corner>,
    /// Elevation from tiles: how heights are written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoding: Option<Encoding>,
    /// Elevation: the geoid that its heights are above; `EGM96` when absent. Heights above an ellipsoid are refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub datum: Option<String>,
    /// Elevation from tiles and GeoTIFF: heights below sea level are land, as in the Netherlands or at the Dead Sea.
    /// Without it they are the sea's floor, and the ground is the water's surface, 0 m.
    #[serde(default, deserialize_with = "null_is_default", skip_serializing_if = "std::ops::Not::not")]
    #[schema(required = false)]
    pub below_sea_level: bool,
    /// What may be kept.
    #[serde(default, deserialize_with = "null_is_default")]
    #[schema(required = false)]
    pub cache: Caching,
    /// Days that a tile is taken for new at least, whatever the service says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cache_min_days: Option<u32>,
    /// Megabytes of its cache; the file's `cache_max_mb` when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_mb: Option<u32>,
    /// Whether offline areas of it are allowed.
    #[serde(default = "yes", deserialize_with = "null_is_yes")]
    #[schema(required = false, default = true)]
    pub offline: bool,
    /// Why not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offline_reason: Option<String>,
    /// Fetches at once, 1 to 16, default 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parallel: Option<u8>,
}

/// A form's empty field is an absent one.
fn null_is_default<'de, D: Deserializer<'de>, T: Deserialize<'de> + Default>(from: D) -> Result<T, D::Error> {
    Option::deserialize(from).map(Option::unwrap_or_default)
}

fn null_is_yes<'de, D: Deserializer<'de>>(from: D) -> Result<bool, D::Error> {
    Option::deserialize(from).map(|value| value.unwrap_or_else(yes))
}

fn null_is_one<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Option::deserialize(from).map(|value| value.unwrap_or_else(one))
}

const fn yes() -> bool {
    true
}

const fn one() -> f64 {
    1.0
}

/// Highest zoom of a tile.
pub const MAX_ZOOM: u8 = 24;
/// Default highest zoom.
pub const DEFAULT_MAX_ZOOM: u8 = 19;

impl SourceSettings {
    /// Settings with defaults for everything else.
    pub(crate) fn unsaid(id: impl Into<String>, name: impl Into<String>, kind: SourceKind) -> Self {
        Self {
            id: id.into(),
            name: name.into(),
            kind,
            role: Role::default(),
            visible: true,
            opacity: 1.0,
            order: 0,
            min_zoom: None,
            max_zoom: None,
            bounds: None,
            attribution: Vec::new(),
            attribution_url: None,
            terms_url: None,
            url: None,
            subdomains: Vec::new(),
            key: None,
            has_key: None,
            local_network: false,
            tile_px: None,
            tms: false,
            layers: Vec::new(),
            styles: Vec::new(),
            version: None,
            crs: None,
            format: None,
            transparent: None,
            parameters: BTreeMap::new(),
            layer: None,
            matrix_set: None,
            style: None,
            map_type: None,
            language: None,
            region: None,
            path: None,
            corners: Vec::new(),
            encoding: None,
            datum: None,
            below_sea_level: false,
            cache: Caching::Keep,
            cache_min_days: None,
            max_mb: None,
            offline: true,
            offline_reason: None,
            parallel: None,
        }
    }

    /// The key, when there is one.
    pub fn key(&self) -> Option<&str> {
        self.key.as_deref().filter(|key| !key.is_empty())
    }

    /// The address of its service, with the user's key in it.
    pub(crate) fn url_with_key(&self) -> String {
        let key = self.key().map(escape).unwrap_or_default();
        self.url.as_deref().unwrap_or_default().replace("{key}", &key)
    }

    /// That it cannot be used.
    pub(crate) fn unusable(&self, reason: impl Into<String>) -> MapError {
        MapError::Unusable { source_id: self.id.clone(), reason: reason.into() }
    }

    /// Settings that determine the content of tiles: when they change, cached tiles are invalid.
    pub fn fingerprint(&self) -> String {
        let parts = format!(
            "{:?}",
            (
                (&self.kind, &self.url, self.tile_px, self.tms, &self.layers, &self.styles, &self.version, &self.crs),
                (&self.format, self.transparent, &self.parameters, &self.layer, &self.matrix_set, &self.style),
                (&self.map_type, &self.language, &self.region),
            )
        );
        format!("{:016x}", fnv1a(parts.as_bytes()))
    }

    /// Faults of the settings common to all kinds, each naming its field.
    pub(crate) fn general_faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let mut fault = |is_wrong: bool, text: &str| {
            if is_wrong {
                faults.push(text.to_owned());
            }
        };
        let is_id = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_';
        fault(
            !(1..=40).contains(&self.id.len()) || !self.id.chars().all(is_id),
            "id: takes 1 to 40 of a–z, 0–9, - and _",
        );
        fault(self.name.trim().is_empty() || self.name.chars().count() > 100, "name: takes 1 to 100 characters");
        fault(!(0.0..=1.0).contains(&self.opacity), "opacity: goes from 0 to 1");
        fault(self.min_zoom.is_some_and(|zoom| zoom > MAX_ZOOM), "min_zoom: goes from 0 to 24");
        fault(self.max_zoom.is_some_and(|zoom| zoom > MAX_ZOOM), "max_zoom: goes from 0 to 24");
        let zooms = self.min_zoom.zip(self.max_zoom);
        fault(zooms.is_some_and(|(min, max)| min > max), "min_zoom: must not be greater than max_zoom");
        fault(self.tile_px.is_some_and(|px| !(64..=2048).contains(&px)), "tile_px: goes from 64 to 2048");
        fault(self.parallel.is_some_and(|count| !(1..=16).contains(&count)), "parallel: goes from 1 to 16");
        fault(self.cache_min_days.is_some_and(|days| days > 3650), "cache_min_days: goes from 0 to 3650");
        fault(self.max_mb.is_some_and(|mb| !(1..=1_000_000).contains(&mb)), "max_mb: goes from 1 to 1000000");
        fault(self.attribution.iter().any(|named| named.text.trim().is_empty()), "attribution: a text is empty");
        let links = self.attribution.iter().filter_map(|named| named.url.as_deref()).chain(self.terms_url.as_deref());
        fault(
            links.clone().any(|url| !(url.starts_with("https://") || url.starts_with("http://"))),
            "attribution, terms_url: links begin with https:// or http://",
        );
        fault(self.key.as_ref().is_some_and(|key| key.len() > 500), "key: has more than 500 characters");
        if let Some(text) = self.bounds.as_ref().and_then(Bounds::fault) {
            faults.push(format!("bounds: {text}"));
        }
        faults
    }

    /// Why its heights cannot be used, when they cannot: they are above an ellipsoid. The geoid is up to 107 m below it
    /// and 85 m above, so heights would be off by that much.
    pub(crate) fn datum_fault(&self) -> Option<String> {
        let datum = self.datum.as_deref()?;
        let plain: String = datum.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect();
        let ellipsoids = ["ellips", "elips", "wgs84", "grs80", "etrs89", "4979", "4937"];
        let is_ellipsoid = ellipsoids.iter().any(|name| plain.contains(name));
        is_ellipsoid.then(|| {
            format!(
                "datum: heights above an ellipsoid ({datum}) are not heights above mean sea level and would be up to 100 m wrong; \
                 convert them first, as with gdalwarp -s_srs EPSG:4979 -t_srs EPSG:4326+5773, and leave datum out; where they \
                 are above a geoid, name that alone, such as EGM2008"
            )
        })
    }

    /// The address of its service, which must be there and be one.
    pub(crate) fn check_url(&self, faults: &mut Vec<String>) -> &str {
        let Some(url) = self.url.as_deref() else {
            faults.push("url: is needed".to_owned());
            return "";
        };
        if let Some(fault) = url_fault(url) {
            faults.push(format!("url: {fault}"));
        }
        url
    }
}

/// A hash that stays the same in all versions (Fowler, Noll, Vo; 64 bits, variant 1a).
pub fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn osm() -> SourceSettings {
        let mut settings = SourceSettings::new("osm", "OpenStreetMap", SourceKind::Xyz);
        settings.url = Some("https://tile.openstreetmap.org/{z}/{x}/{y}.png".to_owned());
        settings
    }

    #[test]
    fn faults_name_their_fields() {
        assert_eq!(osm().faults(), Vec::<String>::new());
        type Change = fn(&mut SourceSettings);
        let changes: [(&str, Change); 14] = [
            ("id:", |s| s.id = "Ñ".into()),
            ("name:", |s| s.name = " ".into()),
            ("opacity:", |s| s.opacity = f64::NAN),
            ("max_zoom:", |s| s.max_zoom = Some(25)),
            ("min_zoom:", |s| (s.min_zoom, s.max_zoom) = (Some(9), Some(8))),
            ("url:", |s| s.url = None),
            ("url:", |s| s.url = Some("ftp://a/{z}/{x}/{y}".into())),
            ("url:", |s| s.url = Some("https://a/{z}/{x}".into())),
            ("url:", |s| s.url = Some("https://u:p@a/{z}/{x}/{y}".into())),
            ("subdomains:", |s| s.url = Some("https://{s}.a/{z}/{x}/{y}".into())),
            ("bounds:", |s| s.bounds = Some(Bounds { west_deg: 0.0, south_deg: 5.0, east_deg: 1.0, north_deg: 5.0 })),
            ("layers:", |s| s.kind = SourceKind::Wms),
            ("corners:", |s| (s.kind, s.path) = (SourceKind::Image, Some("a.png".into()))),
            ("encoding:", |s| s.role = Role::Elevation),
        ];
        for (field, change) in changes {
            let mut settings = osm();
            change(&mut settings);
            let faults = settings.faults();
            assert!(faults.iter().any(|fault| fault.starts_with(field)), "{field} {faults:?}");
        }
    }

    #[test]
    fn heights_above_an_ellipsoid_are_refused() {
        let fault = |datum: &str| SourceSettings { datum: Some(datum.into()), ..osm() }.datum_fault();
        for datum in ["WGS84 ellipsoid", "wgs 84", "GRS-80", "Ellipsoidal", "elipsoide", "EPSG:4979", "ETRS89"] {
            let said = fault(datum).expect(datum);
            assert!(said.starts_with("datum:") && said.contains(datum) && said.contains("gdalwarp"), "{said}");
        }
        for datum in ["EGM96", "EGM2008", "EVRF2007", "NAVD88", "EPSG:5773", "Alicante"] {
            assert_eq!(fault(datum), None, "{datum}");
        }
    }

    #[test]
    fn a_form_s_empty_fields_are_absent_ones() {
        let text = r#"{"id": "a", "name": "A", "kind": "xyz", "tms": null, "corners": null, "visible": null, "opacity": null,
            "offline": null, "cache": null, "role": null, "url": null, "parameters": null}"#;
        let settings: SourceSettings = serde_json::from_str(text).expect("settings");
        assert_eq!(settings, SourceSettings::new("a", "A", SourceKind::Xyz));
        let text = serde_json::to_string(&osm()).expect("JSON");
        assert_eq!(serde_json::from_str::<SourceSettings>(&text).expect("settings"), osm());
        assert!(serde_json::from_str::<SourceSettings>(&text.replace("visible", "visable")).is_err());
    }

    #[test]
    fn the_fingerprint_follows_what_is_drawn_alone() {
        let before = osm().fingerprint();
        let mut settings = osm();
        (settings.name, settings.opacity, settings.key) = ("x".into(), 0.5, Some("k".into()));
        assert_eq!(settings.fingerprint(), before);
        settings.url = Some("https://b/{z}/{x}/{y}".into());
        assert_ne!(settings.fingerprint(), before);
    }

    #[test]
    fn offline_areas_are_refused_with_a_reason() {
        assert_eq!(osm().offline_refusal(), None);
        let mut settings = osm();
        (settings.offline, settings.offline_reason) = (false, Some("its policy".into()));
        assert_eq!(settings.offline_refusal().as_deref(), Some("its policy"));
        settings = osm();
        settings.cache = Caching::Headers;
        assert!(settings.offline_refusal().is_some());
        assert!(
            SourceSettings::new("g", "g", SourceKind::Google).offline_refusal().expect("refused").contains("Google")
        );
    }
}
