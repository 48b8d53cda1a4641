//! Web Map Tile Services 1.0.0 (OGC 07-057r7): what a service offers, the grid of a layer, and the addresses of its
//! tiles, by key and value or REST.

use serde::{Deserialize, Serialize};

use super::super::wms::{is_shown, useful, with_parameters};
use crate::address::escape;
use crate::capabilities::{CapLayer, CapMatrixSet, CapStyle, Capabilities};
use crate::crs::Crs;
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::grid::{Level, MAX_LEVELS, TileGrid, TileId};
use crate::settings::{Attribution, SourceKind, SourceSettings};
use crate::sniff::one_line;
use crate::xml::Element;

/// Size of a pixel in metres that scale denominators are counted by.
const PIXEL_M: f64 = 0.000_28;

/// The layer of a source as its service describes it. It is kept with the cache, so that the map works without the
/// network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// Code of the coordinate reference system.
    crs: String,
    levels: Vec<Level>,
    /// Identifiers of the matrices, one a level.
    matrices: Vec<String>,
    /// Columns and rows that have tiles, one a level: least and greatest column, least and greatest row.
    limits: Vec<Option<[u32; 4]>>,
    matrix_set: String,
    style: String,
    format: String,
    address: Address,
    bounds: Option<Bounds>,
    dimensions: Vec<(String, String)>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Address {
    /// A template with `{TileMatrix}`, `{TileRow}`, `{TileCol}`.
    Rest(String),
    /// A service that takes parameters.
    Kvp(String),
}

impl Layer {
    /// The grid of its tiles.
    pub fn grid(&self) -> Option<TileGrid> {
        let grid = TileGrid::new(Crs::parse(&self.crs)?, self.levels.clone());
        Some(grid.within(self.bounds.as_ref()))
    }

    /// Whether the service says that it has a tile.
    pub fn has(&self, tile: TileId) -> bool {
        match self.limits.get(usize::from(tile.level)) {
            Some(Some([min_column, max_column, min_row, max_row])) => {
                (*min_column..=*max_column).contains(&tile.column) && (*min_row..=*max_row).contains(&tile.row)
            }
            Some(None) => true,
            None => false,
        }
    }

    /// The address of a tile.
    ///
    /// # Errors
    /// [`MapError::Request`] for an invalid service address, [`MapError::NoTile`] off the grid.
    pub fn url(&self, settings: &SourceSettings, tile: TileId) -> Result<String> {
        let matrix = self.matrices.get(usize::from(tile.level)).ok_or(MapError::NoTile)?;
        let (row, column) = (tile.row.to_string(), tile.column.to_string());
        let dimensions = self.dimensions.iter().map(|(name, default)| {
            let own = settings.parameters.iter().find(|(own, _)| own.eq_ignore_ascii_case(name));
            (name.as_str(), own.map_or(default.as_str(), |(_, value)| value.as_str()))
        });
        let key = settings.key().unwrap_or_default();
        match &self.address {
            Address::Rest(template) => {
                let fixed = [
                    ("TileMatrixSet", self.matrix_set.as_str()),
                    ("TileMatrix", matrix),
                    ("TileRow", &row),
                    ("TileCol", &column),
                    ("Style", &self.style),
                    ("key", key),
                ];
                Ok(fixed
                    .into_iter()
                    .chain(dimensions)
                    .fold(template.clone(), |url, (name, value)| fill(&url, name, value)))
            }
            Address::Kvp(address) => {
                let mut parameters = vec![
                    ("SERVICE", "WMTS"),
                    ("REQUEST", "GetTile"),
                    ("VERSION", "1.0.0"),
                    ("LAYER", settings.layer.as_deref().unwrap_or_default()),
                    ("STYLE", &self.style),
                    ("FORMAT", &self.format),
                    ("TILEMATRIXSET", &self.matrix_set),
                    ("TILEMATRIX", matrix),
                    ("TILEROW", &row),
                    ("TILECOL", &column),
                ];
                parameters.extend(dimensions);
                with_parameters(&address.replace("{key}", &escape(key)), &parameters)
            }
        }
    }
}

/// Fills a place of a template, whatever the case of its name.
fn fill(template: &str, name: &str, value: &str) -> String {
    let place = format!("{{{}}}", name.to_ascii_lowercase());
    let mut out = String::new();
    let mut rest = template;
    while let Some(at) = rest.to_ascii_lowercase().find(&place) {
        out.push_str(&rest[..at]);
        out.push_str(&escape(value));
        rest = &rest[at + place.len()..];
    }
    out + rest
}

/// The address of a service's capabilities: a document as it is, else with parameters.
///
/// # Errors
/// [`MapError::Request`] for an invalid address.
pub fn capabilities_url(address: &str) -> Result<String> {
    let path = address.split(['?', '#']).next().unwrap_or_default();
    if path.to_ascii_lowercase().ends_with(".xml") {
        return Ok(address.to_owned());
    }
    let pasted = ["LAYER", "STYLE", "FORMAT", "TILEMATRIXSET", "TILEMATRIX", "TILEROW", "TILECOL"];
    let mut url = url::Url::parse(address).map_err(|error| MapError::Request(format!("invalid address: {error}")))?;
    let kept: Vec<(String, String)> = url
        .query_pairs()
        .filter(|(name, _)| !pasted.iter().any(|other| name.eq_ignore_ascii_case(other)))
        .map(|(name, value)| (name.into_owned(), value.into_owned()))
        .collect();
    url.set_query(None);
    let mut parameters: Vec<(&str, &str)> = kept
        .iter()
        .map(|(name, value)| (name.as_str(), value.as_str()))
        .filter(|(name, _)| !["service", "request", "version"].contains(&name.to_ascii_lowercase().as_str()))
        .collect();
    parameters.extend([("SERVICE", "WMTS"), ("REQUEST", "GetCapabilities"), ("VERSION", "1.0.0")]);
    with_parameters(url.as_str(), &parameters)
}

fn root(bytes: &[u8]) -> std::result::Result<Element, String> {
    let root = Element::parse(bytes)?;
    if let Some(said) = crate::xml::exception(&root) {
        return Err(said);
    }
    let is_tiles = root.name == "Capabilities" && root.child("Contents").is_some();
    is_tiles.then_some(()).ok_or_else(|| format!("no capabilities of a WMTS but <{}>", one_line(&root.name, 60)))?;
    Ok(root)
}

/// Reads capabilities.
///
/// # Errors
/// The fault, or the service's own error, as a sentence.
pub fn read_capabilities(bytes: &[u8]) -> std::result::Result<Capabilities, String> {
    let root = root(bytes)?;
    let about = root.child("ServiceIdentification").cloned().unwrap_or_default();
    let contents = root.child("Contents").cloned().unwrap_or_default();
    let sets: Vec<CapMatrixSet> = contents
        .all("TileMatrixSet")
        .filter_map(|set| {
            let crs = Crs::parse(set.text_of("SupportedCRS")?)?;
            let levels = u32::try_from(set.all("TileMatrix").count()).ok()?;
            Some(CapMatrixSet { id: set.text_of("Identifier")?.to_owned(), crs: crs.code(), levels })
        })
        .collect();
    let layers: Vec<CapLayer> = contents
        .all("Layer")
        .filter_map(|layer| {
            let name = layer.text_of("Identifier")?.to_owned();
            let links = layer.all("TileMatrixSetLink").filter_map(|link| link.text_of("TileMatrixSet"));
            let matrix_sets: Vec<_> = links.filter_map(|id| sets.iter().find(|set| set.id == id)).cloned().collect();
            let mut crs: Vec<String> = matrix_sets.iter().map(|set| set.crs.clone()).collect();
            crs.dedup();
            let total = layer.all("TileMatrixSetLink").count();
            let mut styles: Vec<_> = layer
                .all("Style")
                .filter_map(|style| {
                    let name = style.text_of("Identifier")?;
                    let title = one_line(style.text_of("Title").unwrap_or(name), 200);
                    Some((style.attribute("isDefault") != Some("true"), CapStyle { name: name.to_owned(), title }))
                })
                .collect();
            styles.sort_by_key(|(is_other, _)| *is_other);
            Some(CapLayer {
                title: one_line(layer.text_of("Title").unwrap_or(&name), 300),
                r#abstract: layer.text_of("Abstract").map(|text| one_line(text, 1000)),
                depth: 0,
                styles: styles.into_iter().map(|(_, style)| style).collect(),
                crs,
                other_crs: u32::try_from(total - matrix_sets.len()).unwrap_or(0),
                formats: formats_of(layer),
                matrix_sets,
                bounds: bounds_of(layer),
                attribution: None,
                opaque: false,
                min_zoom: None,
                max_zoom: None,
                name: Some(name),
            })
        })
        .collect();
    let provider = root.child("ServiceProvider").cloned().unwrap_or_default();
    let site = provider.child("ProviderSite").and_then(|site| site.attribute("href"));
    let attribution = provider.text_of("ProviderName").map(|name| Attribution {
        text: one_line(name, 300),
        url: site.filter(|url| url.starts_with("http://") || url.starts_with("https://")).map(str::to_owned),
    });
    let mut formats: Vec<String> = layers.iter().flat_map(|layer| layer.formats.clone()).collect();
    formats.sort();
    formats.dedup();
    Ok(Capabilities {
        kind: SourceKind::Wmts,
        version: root.attribute("version").unwrap_or("1.0.0").to_owned(),
        title: about.text_of("Title").map(|text| one_line(text, 300)),
        r#abstract: about.text_of("Abstract").map(|text| one_line(text, 2000)),
        fees: useful(about.text_of("Fees")),
        access_constraints: useful(about.text_of("AccessConstraints")),
        attribution,
        formats,
        layers,
    })
}

fn formats_of(layer: &Element) -> Vec<String> {
    layer.all("Format").map(|format| format.text.clone()).filter(|format| is_shown(format)).collect()
}

fn bounds_of(layer: &Element) -> Option<Bounds> {
    let of = layer.child("WGS84BoundingBox")?;
    let pair = |name: &str| numbers(of.text_of(name)?);
    let ([west_deg, south_deg], [east_deg, north_deg]) = (pair("LowerCorner")?, pair("UpperCorner")?);
    let bounds = Bounds { west_deg, south_deg, east_deg, north_deg };
    bounds.fault().is_none().then_some(bounds)
}

fn numbers(text: &str) -> Option<[f64; 2]> {
    let mut numbers = text.split_whitespace().map(|number| number.parse::<f64>().ok().filter(|n| n.is_finite()));
    Some([numbers.next()??, numbers.next()??])
}

/// Finds the layer of a source in its service's capabilities.
///
/// # Errors
/// What is missing, as a sentence, with what is available.
pub fn read_layer(bytes: &[u8], settings: &SourceSettings) -> std::result::Result<Layer, String> {
    let root = root(bytes)?;
    let contents = root.child("Contents").cloned().unwrap_or_default();
    let wanted = settings.layer.as_deref().unwrap_or_default();
    let listed = |ids: Vec<&str>| one_line(&ids.join(", "), 300);
    let layer = contents.all("Layer").find(|layer| layer.text_of("Identifier") == Some(wanted)).ok_or_else(|| {
        format!(
            "layer: the service has no '{wanted}', but {}",
            listed(contents.all("Layer").filter_map(|l| l.text_of("Identifier")).collect())
        )
    })?;
    let links: Vec<&Element> = layer.all("TileMatrixSetLink").collect();
    let set_of = |id: &str| contents.all("TileMatrixSet").find(|set| set.text_of("Identifier") == Some(id));
    let known = |id: &str| set_of(id).and_then(|set| Crs::parse(set.text_of("SupportedCRS")?));
    let ids: Vec<&str> = links.iter().filter_map(|link| link.text_of("TileMatrixSet")).collect();
    let id = match settings.matrix_set.as_deref() {
        Some(id) if ids.contains(&id) => id,
        Some(id) => return Err(format!("matrix_set: the layer has no '{id}', but {}", listed(ids))),
        // Web Mercator needs no reprojection; else the first that is known.
        None => {
            let mercator = ids.iter().find(|id| known(id) == Some(Crs::WebMercator));
            let first = ids.iter().find(|id| known(id).is_some());
            mercator
                .or(first)
                .copied()
                .ok_or_else(|| format!("matrix_set: none of {} is in a system known here", listed(ids.clone())))?
        }
    };
    let set = set_of(id).ok_or_else(|| format!("matrix_set: the service does not describe '{id}'"))?;
    let system = set.text_of("SupportedCRS").unwrap_or_default();
    let crs =
        Crs::parse(system).ok_or_else(|| format!("matrix_set: '{id}' is in {system:?}, which is not known here"))?;
    let mut matrices: Vec<(Level, String, Option<[u32; 4]>)> = Vec::new();
    let limits = links
        .iter()
        .find(|link| link.text_of("TileMatrixSet") == Some(id))
        .and_then(|link| link.child("TileMatrixSetLimits"));
    for matrix in set.all("TileMatrix") {
        let name = matrix.text_of("Identifier").unwrap_or_default();
        let level = level_of(matrix, crs)
            .ok_or_else(|| format!("matrix_set: matrix '{name}' of '{id}' is not described right"))?;
        let limit = limits
            .and_then(|limits| limits.all("TileMatrixLimits").find(|limit| limit.text_of("TileMatrix") == Some(name)));
        let limit = limit.and_then(|limit| {
            let number = |name: &str| limit.text_of(name)?.parse().ok();
            Some([number("MinTileCol")?, number("MaxTileCol")?, number("MinTileRow")?, number("MaxTileRow")?])
        });
        matrices.push((level, name.to_owned(), limit));
    }
    matrices.sort_by(|a, b| b.0.resolution.total_cmp(&a.0.resolution));
    matrices.dedup_by(|a, b| a.0.resolution.to_bits() == b.0.resolution.to_bits());
    matrices.truncate(MAX_LEVELS);
    if matrices.is_empty() {
        return Err(format!("matrix_set: '{id}' has no matrices"));
    }
    let formats = formats_of(layer);
    let format = match settings.format.as_deref() {
        Some(format) if formats.iter().any(|known| known == format) => format.to_owned(),
        Some(format) => return Err(format!("format: the layer has no {format}, but {}", formats.join(", "))),
        None => formats.first().cloned().ok_or("the layer has no format that browsers show")?,
    };
    let styles: Vec<&Element> = layer.all("Style").collect();
    let names: Vec<&str> = styles.iter().filter_map(|style| style.text_of("Identifier")).collect();
    let style = match settings.style.as_deref() {
        Some(style) if names.contains(&style) => style,
        Some(style) => return Err(format!("style: the layer has no '{style}', but {}", listed(names))),
        None => {
            let default = styles.iter().find(|style| style.attribute("isDefault") == Some("true")).or(styles.first());
            default.and_then(|style| style.text_of("Identifier")).unwrap_or_default()
        }
    };
    let dimensions = layer.all("Dimension").filter_map(|dimension| {
        Some((dimension.text_of("Identifier")?.to_owned(), dimension.text_of("Default").unwrap_or_default().to_owned()))
    });
    let (levels, (names, limits)): (Vec<_>, (Vec<_>, Vec<_>)) =
        matrices.into_iter().map(|(level, name, limit)| (level, (name, limit))).unzip();
    Ok(Layer {
        crs: crs.code(),
        levels,
        matrices: names,
        limits,
        matrix_set: id.to_owned(),
        style: style.to_owned(),
        address: address_of(&root, layer, &format, settings)?,
        format,
        bounds: settings.bounds.or_else(|| bounds_of(layer)),
        dimensions: dimensions.collect(),
    })
}

fn level_of(matrix: &Element, crs: Crs) -> Option<Level> {
    let number = |name: &str| matrix.text_of(name)?.parse::<u32>().ok().filter(|number| *number > 0);
    let scale: f64 =
        matrix.text_of("ScaleDenominator")?.parse().ok().filter(|scale: &f64| scale.is_finite() && *scale > 0.0)?;
    let [first, second] = numbers(matrix.text_of("TopLeftCorner")?)?;
    // The register's order for geographic systems is latitude first; some services do not keep to it, which shows where
    // a "latitude" is beyond 90.
    let is_swapped = crs.is_north_first() && first.abs() <= 90.0;
    let tile_px = [number("TileWidth")?, number("TileHeight")?];
    (tile_px[0] <= 4096 && tile_px[1] <= 4096).then(|| Level {
        resolution: scale * PIXEL_M / crs.metres_per_unit(),
        origin: if is_swapped { [second, first] } else { [first, second] },
        tile_px,
        size: number("MatrixWidth").zip(number("MatrixHeight")).map(|(width, height)| [width, height]),
    })
}

fn address_of(
    root: &Element,
    layer: &Element,
    format: &str,
    settings: &SourceSettings,
) -> std::result::Result<Address, String> {
    let is_http = |url: &&str| url.starts_with("http://") || url.starts_with("https://");
    let rest = layer.all("ResourceURL").find(|resource| {
        resource.attribute("resourceType") == Some("tile")
            && resource.attribute("format").is_none_or(|own| own == format)
    });
    if let Some(template) = rest.and_then(|resource| resource.attribute("template")).filter(is_http) {
        return Ok(Address::Rest(template.to_owned()));
    }
    let operation = root.child("OperationsMetadata").into_iter().flat_map(|all| all.all("Operation"));
    let get_tile = operation.into_iter().find(|operation| operation.attribute("name") == Some("GetTile"));
    let gets = get_tile.and_then(|operation| operation.find("HTTP")).into_iter().flat_map(|http| http.all("Get"));
    let takes_kvp = |get: &&Element| {
        let encoding = get.find("AllowedValues");
        encoding.is_none_or(|values| values.all("Value").any(|value| value.text == "KVP"))
    };
    let href = gets.filter(takes_kvp).find_map(|get| get.attribute("href").filter(is_http).map(str::to_owned));
    // By default a service takes parameters at the address of its capabilities.
    let own = settings.url.clone().filter(|url| !url.split('?').next().unwrap_or_default().ends_with(".xml"));
    href.or(own).map(Address::Kvp).ok_or_else(|| "the service says no address for tiles".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"<Capabilities version="1.0.0" xmlns:ows="o" xmlns:xlink="x">
      <ows:ServiceIdentification><ows:Title>Tiles</ows:Title></ows:ServiceIdentification>
      <ows:OperationsMetadata><ows:Operation name="GetTile"><ows:DCP><ows:HTTP><ows:Get xlink:href="https://a.es/wmts?">
        <ows:Constraint name="GetEncoding"><ows:AllowedValues><ows:Value>KVP</ows:Value></ows:AllowedValues></ows:Constraint>
      </ows:Get></ows:HTTP></ows:DCP></ows:Operation></ows:OperationsMetadata>
      <Contents><Layer><ows:Title>Ortho</ows:Title><ows:Identifier>ortho</ows:Identifier>
        <ows:WGS84BoundingBox><ows:LowerCorner>-9 36</ows:LowerCorner><ows:UpperCorner>4 44</ows:UpperCorner></ows:WGS84BoundingBox>
        <Style><ows:Identifier>s</ows:Identifier></Style><Style isDefault="true"><ows:Identifier>default</ows:Identifier></Style>
        <Format>image/jpeg</Format><Format>image/png</Format><Format>text/plain</Format>
        <Dimension><ows:Identifier>Time</ows:Identifier><Default>2020</Default></Dimension>
        <TileMatrixSetLink><TileMatrixSet>geo</TileMatrixSet><TileMatrixSetLimits><TileMatrixLimits><TileMatrix>geo:1</TileMatrix>
          <MinTileRow>0</MinTileRow><MaxTileRow>0</MaxTileRow><MinTileCol>1</MinTileCol><MaxTileCol>2</MaxTileCol>
        </TileMatrixLimits></TileMatrixSetLimits></TileMatrixSetLink>
        <TileMatrixSetLink><TileMatrixSet>utm</TileMatrixSet></TileMatrixSetLink>
        <TileMatrixSetLink><TileMatrixSet>lambert</TileMatrixSet></TileMatrixSetLink>REST
      </Layer>
      <TileMatrixSet><ows:Identifier>geo</ows:Identifier><ows:SupportedCRS>urn:ogc:def:crs:EPSG::4326</ows:SupportedCRS>
        <TileMatrix><ows:Identifier>geo:1</ows:Identifier><ScaleDenominator>139770566.0071794</ScaleDenominator>
          <TopLeftCorner>90 -180</TopLeftCorner><TileWidth>256</TileWidth><TileHeight>256</TileHeight><MatrixWidth>4</MatrixWidth><MatrixHeight>2</MatrixHeight></TileMatrix>
        <TileMatrix><ows:Identifier>geo:0</ows:Identifier><ScaleDenominator>279541132.0143589</ScaleDenominator>
          <TopLeftCorner>90 -180</TopLeftCorner><TileWidth>256</TileWidth><TileHeight>256</TileHeight><MatrixWidth>2</MatrixWidth><MatrixHeight>1</MatrixHeight></TileMatrix>
      </TileMatrixSet>
      <TileMatrixSet><ows:Identifier>utm</ows:Identifier><ows:SupportedCRS>EPSG:25830</ows:SupportedCRS>
        <TileMatrix><ows:Identifier>7</ows:Identifier><ScaleDenominator>3571.428571428571</ScaleDenominator>
          <TopLeftCorner>-100000 4900000</TopLeftCorner><TileWidth>512</TileWidth><TileHeight>256</TileHeight></TileMatrix>
      </TileMatrixSet>
      <TileMatrixSet><ows:Identifier>lambert</ows:Identifier><ows:SupportedCRS>EPSG:2154</ows:SupportedCRS></TileMatrixSet>
      </Contents></Capabilities>"#;
    const REST: &str = r#"<ResourceURL format="image/jpeg" resourceType="tile"
        template="https://a.es/{Style}/{TileMatrixSet}/{Time}/{TileMatrix}/{TileRow}/{tilecol}.jpg"/>"#;

    fn settings() -> SourceSettings {
        SourceSettings {
            url: Some("https://a.es/wmts".into()),
            layer: Some("ortho".into()),
            ..SourceSettings::new("w", "W", SourceKind::Wmts)
        }
    }

    fn text(rest: &str) -> String {
        TEXT.replace("REST", rest)
    }

    #[test]
    fn levels_of_degrees_come_coarse_first_with_longitude_first() {
        let layer = read_layer(text("").as_bytes(), &settings()).expect("a layer");
        let grid = layer.grid().expect("known");
        assert_eq!(grid.crs, Crs::Geographic { epsg: 4326 });
        assert!((grid.levels[0].resolution - 0.703_125).abs() < 1e-9, "{}", grid.levels[0].resolution);
        assert_eq!((grid.levels[1].origin, grid.levels[1].size), ([-180.0, 90.0], Some([4, 2])));
        let tile = TileId { level: 1, column: 2, row: 0 };
        assert_eq!(
            layer.url(&settings(), tile).expect("a URL"),
            "https://a.es/wmts?SERVICE=WMTS&REQUEST=GetTile&VERSION=1.0.0&LAYER=ortho&STYLE=default&FORMAT=image/jpeg\
             &TILEMATRIXSET=geo&TILEMATRIX=geo:1&TILEROW=0&TILECOL=2&Time=2020"
        );
        assert!(layer.has(tile) && !layer.has(TileId { column: 3, ..tile }) && layer.has(TileId { level: 0, ..tile }));
        let kept: Layer = serde_json::from_str(&serde_json::to_string(&layer).expect("JSON")).expect("a layer");
        assert_eq!(kept, layer);
    }

    #[test]
    fn rest_and_utm() {
        let mut settings = settings();
        settings.parameters.insert("TIME".into(), "2023".into());
        let layer = read_layer(text(REST).as_bytes(), &settings).expect("a layer");
        let url = layer.url(&settings, TileId { level: 0, column: 1, row: 0 }).expect("a URL");
        assert_eq!(url, "https://a.es/default/geo/2023/geo%3A0/0/1.jpg");
        settings.matrix_set = Some("utm".into());
        let grid = read_layer(text("").as_bytes(), &settings).expect("a layer").grid().expect("known");
        assert!((grid.levels[0].resolution - 1.0).abs() < 1e-12);
        assert_eq!((grid.levels[0].tile_px, grid.levels[0].origin), ([512, 256], [-100_000.0, 4_900_000.0]));
    }

    #[test]
    fn what_there_is_is_told() {
        let capabilities = read_capabilities(text("").as_bytes()).expect("capabilities");
        let layer = &capabilities.layers[0];
        assert_eq!(layer.matrix_sets.iter().map(|set| set.id.as_str()).collect::<Vec<_>>(), ["geo", "utm"]);
        assert_eq!((layer.other_crs, layer.styles[0].name.as_str(), layer.formats.len()), (1, "default", 2));
        assert_eq!(layer.bounds.expect("bounds").north_deg, 44.0);
        type Change = fn(&mut SourceSettings);
        let changes: [(&str, Change); 5] = [
            ("no 'x', but ortho", |s| s.layer = Some("x".into())),
            ("no 'x', but geo, utm", |s| s.matrix_set = Some("x".into())),
            ("EPSG:2154", |s| s.matrix_set = Some("lambert".into())),
            ("no image/webp, but image/jpeg, image/png", |s| s.format = Some("image/webp".into())),
            ("no 'x', but s, default", |s| s.style = Some("x".into())),
        ];
        for (said, change) in changes {
            let mut settings = settings();
            change(&mut settings);
            let error = read_layer(text("").as_bytes(), &settings).expect_err("wrong");
            assert!(error.contains(said), "{said}: {error}");
        }
    }

    #[test]
    fn addresses_of_capabilities() {
        for (pasted, url) in [
            ("https://a.es/wmts", "https://a.es/wmts?SERVICE=WMTS&REQUEST=GetCapabilities&VERSION=1.0.0"),
            ("https://a.es/1.0.0/WMTSCapabilities.xml", "https://a.es/1.0.0/WMTSCapabilities.xml"),
            (
                "https://a.es/w?k=1&layer=x&TileRow=3&request=GetTile",
                "https://a.es/w?k=1&SERVICE=WMTS&REQUEST=GetCapabilities&VERSION=1.0.0",
            ),
        ] {
            assert_eq!(capabilities_url(pasted).expect("a URL"), url);
        }
    }
}
