//! Web Map Services 1.1.1 (OGC 01-068r3) and 1.3.0 (OGC 06-042): the address of a picture, and what a service offers.

use std::sync::Arc;

use url::Url;

use crate::cache::CachedTile;
use crate::capabilities::{CapLayer, CapStyle, Capabilities};
use crate::crs::Crs;
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::grid::{TileGrid, TileId};
use crate::kind::{Kind, Offer, Opened, Opening};
use crate::live::{Asking, Live, Pending, Reply, Service};
use crate::settings::{Attribution, Role, SourceKind, SourceSettings};
use crate::sniff::one_line;
use crate::xml::Element;

/// Scale denominator of zoom 0 of Web Mercator with 256-pixel tiles and pixels of 0.28 mm.
const ZOOM_0_SCALE: f64 = 559_082_264.028_717_8;
/// Most layers listed.
const MAX_LAYERS: usize = 5000;

/// How sources of this kind are opened and read.
pub(crate) struct Driver;

impl Kind for Driver {
    fn fields(&self) -> &'static [&'static str] {
        &[
            "url",
            "key",
            "local_network",
            "layers",
            "styles",
            "version",
            "crs",
            "format",
            "transparent",
            "parameters",
            "tile_px",
            "cache",
        ]
    }

    fn roles(&self) -> &'static [Role] {
        &[Role::Base, Role::Overlay]
    }

    fn address_signs(&self) -> &'static [&'static str] {
        &["service=wms", "wms", "mapserv", "/ows"]
    }

    fn faults(&self, settings: &SourceSettings, faults: &mut Vec<String>) {
        settings.check_url(faults);
        if settings.layers.is_empty() {
            faults.push("layers: at least one is needed; POST /api/v1/maps/capabilities lists them".to_owned());
        }
        if !settings.styles.is_empty() && settings.styles.len() != settings.layers.len() {
            faults.push("styles: one for each layer, or none at all".to_owned());
        }
        if settings.version.as_deref().is_some_and(|version| version != "1.1.1" && version != "1.3.0") {
            faults.push("version: 1.1.1 or 1.3.0".to_owned());
        }
        if let Some(name) = &settings.crs
            && Crs::parse(name).is_none()
        {
            faults.push(format!(
                "crs: {name:?} is not known here; EPSG:3857, 4326, 4258, CRS:84, 326xx, 327xx and 25828 to 25838 are"
            ));
        }
    }

    fn open(&self, opening: &Opening<'_>) -> Opened {
        let name = opening.settings.crs.as_deref().unwrap_or("EPSG:3857");
        let crs = Crs::parse(name).ok_or("crs: is not known here")?;
        Ok(Live::Service(Box::new(Pictures { crs, grid: opening.standard_grid(crs) })))
    }

    fn offer(&self) -> Option<Offer> {
        Some(Offer { url: |address| capabilities_url(address, None), read: read_capabilities })
    }
}

/// A service that draws any rectangle.
struct Pictures {
    crs: Crs,
    grid: Arc<TileGrid>,
}

impl Service for Pictures {
    fn grid(&self) -> Option<Arc<TileGrid>> {
        Some(self.grid.clone())
    }

    fn tile<'a>(&'a self, asking: Asking<'a>, tile: TileId, kept: Option<&'a CachedTile>) -> Pending<'a, Reply> {
        Box::pin(async move {
            let extent = self.grid.tile_extent(tile).ok_or(MapError::NoTile)?;
            let tile_px = self.grid.levels[usize::from(tile.level)].tile_px;
            asking.tile(&map_url(asking.settings, self.crs, extent, tile_px)?, kept).await
        })
    }
}

/// An address with parameters set; those of the same names, in any case, are replaced.
///
/// # Errors
/// [`MapError::Request`] for an invalid address.
pub fn with_parameters(address: &str, parameters: &[(&str, &str)]) -> Result<String> {
    let mut url = Url::parse(address).map_err(|error| MapError::Request(format!("invalid address: {error}")))?;
    url.set_fragment(None);
    let kept: Vec<(String, String)> = url
        .query_pairs()
        .filter(|(name, _)| !name.is_empty() && !parameters.iter().any(|(other, _)| name.eq_ignore_ascii_case(other)))
        .map(|(name, value)| (name.into_owned(), value.into_owned()))
        .collect();
    let kept = kept.iter().map(|(name, value)| (name.as_str(), value.as_str()));
    let query: Vec<String> = kept
        .chain(parameters.iter().copied())
        .map(|(name, value)| format!("{}={}", encode(name), encode(value)))
        .collect();
    url.set_query(Some(&query.join("&")));
    Ok(url.into())
}

/// As part of a query, with the commas, colons and slashes that WMS uses left readable.
fn encode(text: &str) -> String {
    crate::address::escape(text).replace("%2C", ",").replace("%3A", ":").replace("%2F", "/")
}

/// The address of a picture of a rectangle (least x and y, greatest x and y; easting or longitude first).
///
/// # Errors
/// [`MapError::Request`] for settings that [`SourceSettings::faults`] refuses.
pub fn map_url(settings: &SourceSettings, crs: Crs, extent: [f64; 4], size_px: [u32; 2]) -> Result<String> {
    let version = settings.version.as_deref().unwrap_or("1.3.0");
    let is_old = version == "1.1.1";
    let [left, bottom, right, top] = extent;
    let bbox = if crs.is_north_first() && !is_old { [bottom, left, top, right] } else { [left, bottom, right, top] };
    let bbox = bbox.map(|number| number.to_string()).join(",");
    // 1.1.1 has no CRS:84; its EPSG:4326 is longitude first.
    let code = if is_old && crs == Crs::Crs84 { "EPSG:4326".to_owned() } else { crs.code() };
    let [width, height] = size_px.map(|px| px.to_string());
    let format = settings.format.as_deref().unwrap_or("image/png");
    let is_transparent = settings.transparent.unwrap_or(format.contains("png") || format.contains("webp"));
    let (layers, styles) = (settings.layers.join(","), settings.styles.join(","));
    let mut parameters = vec![
        ("SERVICE", "WMS"),
        ("VERSION", version),
        ("REQUEST", "GetMap"),
        ("LAYERS", layers.as_str()),
        ("STYLES", styles.as_str()),
        (if is_old { "SRS" } else { "CRS" }, code.as_str()),
        ("BBOX", bbox.as_str()),
        ("WIDTH", width.as_str()),
        ("HEIGHT", height.as_str()),
        ("FORMAT", format),
        ("TRANSPARENT", if is_transparent { "TRUE" } else { "FALSE" }),
        ("EXCEPTIONS", if is_old { "application/vnd.ogc.se_xml" } else { "XML" }),
    ];
    let own: Vec<(&str, String)> = settings
        .parameters
        .iter()
        .map(|(name, value)| (name.as_str(), value.replace("{key}", settings.key().unwrap_or_default())))
        .collect();
    parameters.extend(own.iter().map(|(name, value)| (*name, value.as_str())));
    let address = settings.url.as_deref().unwrap_or_default();
    let address = address.replace("{key}", &settings.key().map(crate::address::escape).unwrap_or_default());
    with_parameters(&address, &parameters)
}

/// The address of a service's capabilities, whatever part of an address a person pasted.
///
/// # Errors
/// [`MapError::Request`] for an invalid address.
pub fn capabilities_url(address: &str, version: Option<&str>) -> Result<String> {
    let mut parameters =
        vec![("SERVICE", "WMS"), ("REQUEST", "GetCapabilities"), ("VERSION", version.unwrap_or("1.3.0"))];
    // Parameters of a picture do not belong here, and some services fail on them.
    let pasted = ["LAYERS", "STYLES", "CRS", "SRS", "BBOX", "WIDTH", "HEIGHT", "FORMAT", "TRANSPARENT"];
    let url = Url::parse(address).map_err(|error| MapError::Request(format!("invalid address: {error}")))?;
    let has_any = url.query_pairs().any(|(name, _)| pasted.iter().any(|other| name.eq_ignore_ascii_case(other)));
    if !has_any {
        return with_parameters(address, &parameters);
    }
    let kept: Vec<(String, String)> = url
        .query_pairs()
        .filter(|(name, _)| !pasted.iter().any(|other| name.eq_ignore_ascii_case(other)))
        .map(|(name, value)| (name.into_owned(), value.into_owned()))
        .collect();
    let names: Vec<&str> = parameters.iter().map(|(name, _)| *name).collect();
    let kept = kept.iter().filter(|(name, _)| !names.iter().any(|other| name.eq_ignore_ascii_case(other)));
    let mut all: Vec<(&str, &str)> = kept.map(|(name, value)| (name.as_str(), value.as_str())).collect();
    all.append(&mut parameters);
    let plain = address.split('?').next().unwrap_or(address);
    with_parameters(plain, &all)
}

/// Reads capabilities.
///
/// # Errors
/// The fault, or the service's own error, as a sentence.
pub fn read_capabilities(bytes: &[u8]) -> std::result::Result<Capabilities, String> {
    let root = Element::parse(bytes)?;
    if let Some(said) = crate::xml::exception(&root) {
        return Err(said);
    }
    if !matches!(root.name.as_str(), "WMS_Capabilities" | "WMT_MS_Capabilities") {
        return Err(format!("no capabilities of a WMS but <{}>", one_line(&root.name, 60)));
    }
    let service = root.child("Service").cloned().unwrap_or_default();
    let capability = root.child("Capability").ok_or("the capabilities have no <Capability>")?;
    let formats =
        capability.child("Request").and_then(|request| request.child("GetMap")).ok_or("it offers no GetMap")?;
    let formats = formats.all("Format").map(|format| format.text.clone()).filter(|format| is_shown(format)).collect();
    let mut layers = Vec::new();
    for layer in capability.all("Layer") {
        walk(layer, 0, &Inherited::default(), &mut layers);
    }
    let attribution = layers.iter().find_map(|layer: &CapLayer| layer.attribution.clone());
    Ok(Capabilities {
        kind: SourceKind::Wms,
        version: root.attribute("version").unwrap_or("1.3.0").to_owned(),
        title: service.text_of("Title").map(|text| one_line(text, 300)),
        r#abstract: service.text_of("Abstract").map(|text| one_line(text, 2000)),
        fees: useful(service.text_of("Fees")),
        access_constraints: useful(service.text_of("AccessConstraints")),
        attribution,
        formats,
        layers,
    })
}

/// `None` for "none" and empty texts.
pub(crate) fn useful(text: Option<&str>) -> Option<String> {
    text.filter(|text| !text.eq_ignore_ascii_case("none")).map(|text| one_line(text, 2000))
}

/// Whether browsers, and we, know a format.
pub(crate) fn is_shown(format: &str) -> bool {
    let format = format.to_ascii_lowercase();
    ["image/png", "image/jpeg", "image/jpg", "image/webp", "image/gif", "image/vnd.jpeg-png"]
        .iter()
        .any(|known| format.starts_with(known))
}

#[derive(Clone, Default)]
struct Inherited {
    crs: Vec<Crs>,
    others: u32,
    styles: Vec<CapStyle>,
    bounds: Option<Bounds>,
    attribution: Option<Attribution>,
    min_zoom: Option<u8>,
    max_zoom: Option<u8>,
}

fn walk(layer: &Element, depth: u32, above: &Inherited, out: &mut Vec<CapLayer>) {
    if out.len() >= MAX_LAYERS {
        return;
    }
    let mut own = above.clone();
    // 1.1.1 let a single element list several.
    let names = layer.children.iter().filter(|child| matches!(child.name.as_str(), "CRS" | "SRS"));
    for name in names.flat_map(|child| child.text.split_whitespace()) {
        match Crs::parse(name) {
            Some(crs) if !own.crs.contains(&crs) => own.crs.push(crs),
            Some(_) => {}
            None => own.others += 1,
        }
    }
    for style in layer.all("Style") {
        let Some(name) = style.text_of("Name") else { continue };
        if !own.styles.iter().any(|known| known.name == name) {
            let title = one_line(style.text_of("Title").unwrap_or(name), 200);
            own.styles.push(CapStyle { name: name.to_owned(), title });
        }
    }
    own.bounds = bounds_of(layer).or(own.bounds);
    own.attribution = attribution_of(layer).or(own.attribution);
    let scale = |name: &str| layer.text_of(name).and_then(|text| text.parse::<f64>().ok()).filter(|scale| *scale > 0.0);
    let zoom = |scale: f64| (ZOOM_0_SCALE / scale).log2();
    let clamped = |zoom: f64| zoom.clamp(0.0, 24.0) as u8;
    own.min_zoom = scale("MaxScaleDenominator").map(|scale| clamped(zoom(scale).ceil())).or(own.min_zoom);
    own.max_zoom = scale("MinScaleDenominator").map(|scale| clamped(zoom(scale).floor())).or(own.max_zoom);
    let name = layer.text_of("Name").map(str::to_owned);
    let title = layer.text_of("Title").or(name.as_deref()).unwrap_or_default();
    out.push(CapLayer {
        title: one_line(title, 300),
        r#abstract: layer.text_of("Abstract").map(|text| one_line(text, 1000)),
        depth,
        styles: own.styles.clone(),
        crs: own.crs.iter().map(|crs| crs.code()).collect(),
        other_crs: own.others,
        formats: Vec::new(),
        matrix_sets: Vec::new(),
        bounds: own.bounds,
        attribution: own.attribution.clone(),
        opaque: layer.attribute("opaque") == Some("1"),
        min_zoom: own.min_zoom,
        max_zoom: own.max_zoom,
        name,
    });
    for child in layer.all("Layer") {
        walk(child, depth + 1, &own, out);
    }
}

fn bounds_of(layer: &Element) -> Option<Bounds> {
    let bounds = if let Some(bounds) = layer.child("EX_GeographicBoundingBox") {
        let number = |name: &str| bounds.text_of(name).and_then(|text| text.parse().ok());
        Bounds {
            west_deg: number("westBoundLongitude")?,
            south_deg: number("southBoundLatitude")?,
            east_deg: number("eastBoundLongitude")?,
            north_deg: number("northBoundLatitude")?,
        }
    } else {
        let bounds = layer.child("LatLonBoundingBox")?;
        Bounds {
            west_deg: bounds.number("minx")?,
            south_deg: bounds.number("miny")?,
            east_deg: bounds.number("maxx")?,
            north_deg: bounds.number("maxy")?,
        }
    };
    bounds.fault().is_none().then_some(bounds)
}

fn attribution_of(layer: &Element) -> Option<Attribution> {
    let attribution = layer.child("Attribution")?;
    let url = attribution.child("OnlineResource").and_then(|link| link.attribute("href"));
    let url = url.filter(|url| url.starts_with("http://") || url.starts_with("https://")).map(str::to_owned);
    Some(Attribution { text: one_line(attribution.text_of("Title")?, 300), url })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(version: &str) -> SourceSettings {
        SourceSettings {
            url: Some("https://maps.example/cgi?MAP=/a b.map&version=9&".to_owned()),
            layers: vec!["a".into(), "b:c".into()],
            version: Some(version.to_owned()),
            ..SourceSettings::new("w", "W", SourceKind::Wms)
        }
    }

    #[test]
    fn axis_order_is_each_version_s_own() {
        let geographic = Crs::Geographic { epsg: 4326 };
        let url = |version: &str, crs: Crs| {
            map_url(&settings(version), crs, [-4.0, 40.0, -3.5, 40.5], [256, 128]).expect("a URL")
        };
        let new = url("1.3.0", geographic);
        assert!(new.contains("CRS=EPSG:4326&BBOX=40,-4,40.5,-3.5&WIDTH=256&HEIGHT=128"), "{new}");
        assert!(new.starts_with("https://maps.example/cgi?MAP=/a%20b.map&SERVICE=WMS&VERSION=1.3.0&"), "{new}");
        assert!(new.contains("LAYERS=a,b:c&STYLES=&") && new.contains("TRANSPARENT=TRUE"), "{new}");
        let old = url("1.1.1", geographic);
        assert!(old.contains("SRS=EPSG:4326&BBOX=-4,40,-3.5,40.5&") && old.contains("vnd.ogc.se_xml"), "{old}");
        assert!(url("1.3.0", Crs::Crs84).contains("CRS=CRS:84&BBOX=-4,40,-3.5,40.5&"));
        assert!(url("1.1.1", Crs::Crs84).contains("SRS=EPSG:4326&BBOX=-4,40,-3.5,40.5&"));
        let utm = Crs::from_epsg(25_830).expect("known");
        assert!(url("1.3.0", utm).contains("CRS=EPSG:25830&BBOX=-4,40,-3.5,40.5&"), "eastings first");
    }

    #[test]
    fn any_pasted_address_leads_to_the_capabilities() {
        for pasted in [
            "https://a.es/wms",
            "https://a.es/wms?",
            "https://a.es/wms?request=GetCapabilities&service=WMS",
            "https://a.es/wms?REQUEST=GetMap&LAYERS=x&BBOX=1,2,3,4&WIDTH=5",
        ] {
            let url = capabilities_url(pasted, None).expect("a URL");
            assert_eq!(url, "https://a.es/wms?SERVICE=WMS&REQUEST=GetCapabilities&VERSION=1.3.0", "{pasted}");
        }
        assert!(capabilities_url("https://a.es/wms?map=x&SRS=1", None).expect("a URL").contains("?map=x&SERVICE=WMS"));
        assert!(capabilities_url("a.es", None).is_err());
    }

    #[test]
    fn layers_inherit() {
        let text = br#"<WMS_Capabilities version="1.3.0"><Service><Title>T</Title><Fees>none</Fees></Service><Capability>
            <Request><GetMap><Format>image/png</Format><Format>application/pdf</Format></GetMap></Request>
            <Exception><Format>XML</Format></Exception>
            <Layer><Title>All</Title><CRS>EPSG:4326</CRS><CRS>EPSG:2154</CRS>
            <EX_GeographicBoundingBox><westBoundLongitude>-9</westBoundLongitude><eastBoundLongitude>4</eastBoundLongitude>
            <southBoundLatitude>36</southBoundLatitude><northBoundLatitude>44</northBoundLatitude></EX_GeographicBoundingBox>
            <Attribution><Title>IGN</Title><OnlineResource xlink:href="javascript:alert(1)"/></Attribution>
            <Layer opaque="1"><Name>a</Name><Title>A</Title><CRS>EPSG:25830</CRS><MaxScaleDenominator>1100000</MaxScaleDenominator>
            <Style><Name>default</Name></Style></Layer></Layer></Capability></WMS_Capabilities>"#;
        let capabilities = read_capabilities(text).expect("capabilities");
        assert_eq!((capabilities.formats.len(), capabilities.fees), (1, None));
        let [all, a] = capabilities.layers.as_slice() else { panic!("{:?}", capabilities.layers) };
        assert_eq!((all.name.as_deref(), all.depth, all.other_crs), (None, 0, 1));
        assert_eq!(a.crs, ["EPSG:4326", "EPSG:25830"]);
        assert_eq!((a.depth, a.opaque, a.min_zoom, a.styles.len()), (1, true, Some(9), 1));
        assert_eq!(a.bounds.expect("inherited").west_deg, -9.0);
        assert_eq!(a.attribution, Some(Attribution { text: "IGN".into(), url: None }), "no script is a link");
    }

    #[test]
    fn what_is_no_capabilities_says_what_it_is() {
        for (text, said) in [
            ("<html><body>Sign in</body></html>", "<html>"),
            ("<ServiceExceptionReport><ServiceException>down</ServiceException></ServiceExceptionReport>", "down"),
            ("nothing", "XML"),
            ("<WMS_Capabilities/>", "Capability"),
        ] {
            assert!(read_capabilities(text.as_bytes()).unwrap_err().contains(said), "{text}");
        }
    }
}
