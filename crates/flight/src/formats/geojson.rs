//! GeoJSON (RFC 7946): geometries with properties.
//!
//! Read by the tree of the `.plan` reader, which bounds the file and names the path of a fault.

use serde_json::{Map, Value, json};

use crate::error::Result;
use crate::formats::json::{Node, ROOT, plain};
use crate::formats::notes::Notes;
use crate::formats::places::{Datum, Feature, Heights, Place, Shape, features_of, open_ring, plan_of};
use crate::formats::text::shown;
use crate::geodesy::GeoPoint;
use crate::plan::Plan;

/// Whether a JSON object is GeoJSON.
pub(super) fn is_geojson(value: &Value) -> bool {
    const TYPES: [&str; 9] = [
        "FeatureCollection",
        "Feature",
        "GeometryCollection",
        "Point",
        "MultiPoint",
        "LineString",
        "MultiLineString",
        "Polygon",
        "MultiPolygon",
    ];
    value.get("type").and_then(Value::as_str).is_some_and(|kind| TYPES.contains(&kind))
}

/// Reads GeoJSON.
///
/// # Errors
/// [`crate::FlightError::BadJson`] with the path.
pub(super) fn read_geojson(value: &Value, notes: &mut Notes) -> Result<Plan> {
    let root = Node { value, path: ROOT.into() };
    // Of GeoJSON before 2016; today it is WGS-84 alone.
    if let Some(crs) = root.member("crs")? {
        let name = crs.member("properties")?.map_or(Ok(None), |properties| properties.member("name"))?;
        let name = name.map_or(Ok(""), |name| name.text())?;
        if !name.contains("CRS84") && !name.ends_with("EPSG::4326") && !name.ends_with("EPSG:4326") {
            return Err(crs.bad(format!(
                "has coordinates in \"{}\"; export it in WGS 84 (EPSG:4326), as GeoJSON is today",
                shown(name)
            )));
        }
    }
    let mut features = Vec::new();
    object(&root, &mut features)?;
    plan_of(&features, notes)
}

fn object(node: &Node<'_>, features: &mut Vec<Feature>) -> Result<()> {
    let kind = node.required("type")?.text()?;
    if kind == "FeatureCollection" {
        return node.required("features")?.list()?.try_for_each(|feature| object(&feature, features));
    }
    // A geometry may stand alone.
    let (properties, shape) = match kind {
        "Feature" => (node.member("properties")?, node.member("geometry")?),
        _ => (None, Some(node.clone())),
    };
    let properties = properties.map(|node| node.object()).transpose()?;
    let of = Feature {
        shape: Shape::Nothing,
        heights: Heights::Ellipsoid,
        data: properties.into_iter().flatten().filter_map(datum).collect(),
        name: node.path.clone(),
        is_named: properties.is_some_and(|all| all.values().any(|value| !value.is_null())),
    };
    let mut shapes = Vec::new();
    if let Some(shape) = shape {
        geometry(&shape, &mut shapes)?;
    }
    features.extend(of.parts(shapes.into_iter().map(|shape| (shape, Heights::Ellipsoid))));
    Ok(())
}

fn datum((key, value): (&String, &Value)) -> Option<(String, Datum)> {
    let datum = match value {
        Value::Bool(flag) => Datum::Flag(*flag),
        Value::Number(number) => Datum::Number(number.as_f64()?),
        Value::String(text) => Datum::Word(text.clone()),
        Value::Null | Value::Array(_) | Value::Object(_) => return None,
    };
    Some((key.clone(), datum))
}

fn geometry(node: &Node<'_>, shapes: &mut Vec<Shape>) -> Result<()> {
    let kind = node.required("type")?;
    if kind.text()? == "GeometryCollection" {
        return node.required("geometries")?.list()?.try_for_each(|part| geometry(&part, shapes));
    }
    let coordinates = node.required("coordinates")?;
    let line = |node: &Node<'_>| node.list()?.map(|position| place(&position)).collect::<Result<Vec<_>>>();
    let area = |node: &Node<'_>| {
        let rings = node.list()?.map(|ring| line(&ring).map(open_ring)).collect::<Result<Vec<_>>>()?;
        Ok(if rings.is_empty() { Shape::Nothing } else { Shape::Area(rings) })
    };
    let found = match kind.text()? {
        "Point" => vec![Shape::Point(place(&coordinates)?)],
        "MultiPoint" => line(&coordinates)?.into_iter().map(Shape::Point).collect(),
        "LineString" => vec![Shape::Line(line(&coordinates)?)],
        "MultiLineString" => coordinates.list()?.map(|part| line(&part).map(Shape::Line)).collect::<Result<_>>()?,
        "Polygon" => vec![area(&coordinates)?],
        "MultiPolygon" => coordinates.list()?.map(|part| area(&part)).collect::<Result<_>>()?,
        other => return Err(kind.bad(format!("is \"{}\", which GeoJSON does not have", shown(other)))),
    };
    shapes.extend(found);
    Ok(())
}

/// Longitude, latitude and perhaps a height; further numbers are ignored.
fn place(node: &Node<'_>) -> Result<Place> {
    let mut parts = node.list()?;
    let (Some(lon), Some(lat)) = (parts.next(), parts.next()) else {
        return Err(node.wrong_kind("[longitude, latitude] or [longitude, latitude, height]"));
    };
    let point = GeoPoint::new(lat.number()?, lon.number()?).map_err(|error| node.bad(error.to_string()))?;
    let alt_m = parts.next().filter(|alt| !alt.value.is_null()).map(|alt| alt.number()).transpose()?;
    Ok(Place { point, alt_m })
}

/// Writes GeoJSON, one feature a line. Coordinates have no height: the standard counts it from the ellipsoid, a plan
/// does not.
pub(super) fn write_geojson(plan: &Plan, notes: &mut Notes) -> String {
    let at = |place: &Place| json!([plain(place.point.lon_deg()), plain(place.point.lat_deg())]);
    let list = |places: &[Place]| places.iter().map(at).collect::<Vec<_>>();
    let features = features_of(plan, false, notes).into_iter().map(|feature| {
        let geometry = match &feature.shape {
            Shape::Nothing => Value::Null,
            Shape::Point(place) => json!({ "type": "Point", "coordinates": at(place) }),
            Shape::Line(line) => json!({ "type": "LineString", "coordinates": list(line) }),
            Shape::Area(rings) => {
                let closed = |ring: &Vec<Place>| {
                    let mut corners = list(ring);
                    corners.extend(ring.first().map(at));
                    corners
                };
                json!({ "type": "Polygon", "coordinates": rings.iter().map(closed).collect::<Vec<_>>() })
            }
        };
        let mut properties = Map::new();
        properties.insert("name".into(), json!(feature.name));
        for (key, datum) in feature.data {
            let value = match datum {
                Datum::Number(value) => plain(value),
                Datum::Flag(flag) => json!(flag),
                Datum::Word(word) => json!(word),
            };
            properties.insert(key, value);
        }
        json!({ "type": "Feature", "properties": properties, "geometry": geometry }).to_string()
    });
    let features: Vec<String> = features.collect();
    format!("{{\"type\":\"FeatureCollection\",\"features\":[\n{}\n]}}\n", features.join(",\n"))
}
