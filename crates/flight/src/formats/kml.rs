//! KML 2.2 (OGC 07-147r2, <https://developers.google.com/kml/documentation/kmlreference>), also in a zip (`.kmz`).
//!
//! Heights count as `altitudeMode` says: `absolute` from the sea, `relativeToGround` from the terrain. `clampToGround`,
//! the default, means that the height is ignored, as do the modes for the sea floor.

use std::fmt::Write as _;
use std::io::{Read as _, Write as _};

use rawzip::{CompressionMethod, ZipArchive, ZipArchiveWriter};

use crate::error::{FlightError, Result};
use crate::formats::notes::{NoteCode, Notes};
use crate::formats::places::{
    Datum, Feature, Heights, Place, Shape, features_of, height_of, open_ring, plan_of, point_of,
};
use crate::formats::text::{MAX_FILE_BYTES, shown, too_many};
use crate::formats::xml::Element;
use crate::plan::Plan;

/// Colours as KML has them (alpha, blue, green, red), widths in pixels.
const STYLES: &str = "<Style id=\"line\"><LineStyle><color>ffd8781e</color><width>3</width></LineStyle><PolyStyle><fill>0</fill></PolyStyle></Style>\n\
    <Style id=\"inside\"><LineStyle><color>ff3c9a1e</color><width>2</width></LineStyle><PolyStyle><fill>0</fill></PolyStyle></Style>\n\
    <Style id=\"outside\"><LineStyle><color>ff2828c8</color><width>2</width></LineStyle><PolyStyle><color>402828c8</color></PolyStyle></Style>\n";

/// Reads a `.kml`.
///
/// # Errors
/// [`FlightError::BadFile`] with the placemark, what is wrong with it and what to do.
pub(super) fn read_kml(root: &Element, notes: &mut Notes) -> Result<Plan> {
    let mut reader = Reader { features: Vec::new(), placemarks: 0 };
    reader.container(root, notes)?;
    plan_of(&reader.features, notes)
}

struct Reader {
    features: Vec<Feature>,
    placemarks: usize,
}

impl Reader {
    fn container(&mut self, element: &Element, notes: &mut Notes) -> Result<()> {
        for child in &element.children {
            match child.name.as_str() {
                "Document" | "Folder" => self.container(child, notes)?,
                "Placemark" => self.placemark(child, notes)?,
                "NetworkLink" | "GroundOverlay" | "ScreenOverlay" | "PhotoOverlay" => notes.add(NoteCode::NotPlaces, 1),
                _ => {}
            }
        }
        Ok(())
    }

    fn placemark(&mut self, placemark: &Element, notes: &mut Notes) -> Result<()> {
        self.placemarks += 1;
        let title = placemark.text_of("name");
        let mut feature = Feature {
            shape: Shape::Nothing,
            heights: Heights::Sea,
            data: data_of(placemark),
            name: format!("placemark {}", self.placemarks),
            is_named: title.is_some() || placemark.text_of("description").is_some(),
        };
        if let Some(title) = title {
            let _ = write!(feature.name, " (\"{}\")", shown(title));
        }
        let mut shapes = Vec::new();
        for child in &placemark.children {
            geometry(child, &feature.name, &mut shapes, notes)?;
        }
        self.features.extend(feature.parts(shapes));
        Ok(())
    }
}

/// The shapes of a geometry, and what their heights count from.
fn geometry(element: &Element, name: &str, shapes: &mut Vec<(Shape, Heights)>, notes: &mut Notes) -> Result<()> {
    let bad = |problem: String| FlightError::BadFile(format!("{name}: {problem}"));
    let heights = match element.text_of("altitudeMode") {
        Some("absolute") => Some(Heights::Sea),
        Some("relativeToGround") => Some(Heights::Terrain),
        _ => None,
    };
    let places = |text: Option<&str>| -> Result<Vec<Place>> {
        let mut places = Vec::new();
        for tuple in text.unwrap_or_default().split_whitespace() {
            let mut place = place(&mut tuple.split(','), tuple).map_err(bad)?;
            place.alt_m = place.alt_m.filter(|_| heights.is_some());
            places.push(place);
            if let Some(problem) = too_many(places.len()) {
                return Err(bad(problem));
            }
        }
        Ok(places)
    };
    let ring = |border: &Element| -> Result<Vec<Place>> {
        places(border.child("LinearRing").and_then(|ring| ring.text_of("coordinates"))).map(open_ring)
    };
    let shape = match element.name.as_str() {
        "Point" => match places(element.text_of("coordinates"))?.as_slice() {
            [place] => Shape::Point(*place),
            places => return Err(bad(format!("has {} coordinates; a point has one", places.len()))),
        },
        "LineString" | "LinearRing" => Shape::Line(places(element.text_of("coordinates"))?),
        "Polygon" => {
            let Some(border) = element.child("outerBoundaryIs") else {
                return Err(bad("is an area without a border; draw it again".into()));
            };
            let mut rings = vec![ring(border)?];
            for hole in element.all("innerBoundaryIs") {
                rings.push(ring(hole)?);
            }
            Shape::Area(rings)
        }
        // a recorded flight, gx:coord being longitude, latitude and height by spaces
        "Track" => {
            let coordinates = element.all("coord").map(|coord| {
                let mut place = place(&mut coord.text.split_whitespace(), &coord.text).map_err(bad)?;
                place.alt_m = place.alt_m.filter(|_| heights.is_some());
                Ok(place)
            });
            Shape::Line(coordinates.collect::<Result<_>>()?)
        }
        "MultiGeometry" | "MultiTrack" => {
            return element.children.iter().try_for_each(|part| geometry(part, name, shapes, notes));
        }
        "Model" => {
            notes.add(NoteCode::NotPlaces, 1);
            return Ok(());
        }
        _ => return Ok(()),
    };
    shapes.push((shape, heights.unwrap_or(Heights::Sea)));
    Ok(())
}

fn place<'a>(parts: &mut impl Iterator<Item = &'a str>, whole: &str) -> std::result::Result<Place, String> {
    let (Some(lon), Some(lat), alt, None) =
        (parts.next(), parts.next().filter(|lat| !lat.is_empty()), parts.next(), parts.next())
    else {
        return Err(format!(
            "has \"{}\" as a coordinate; longitude,latitude or longitude,latitude,height belongs there, without spaces",
            shown(whole)
        ));
    };
    Ok(Place { point: point_of(lat, lon)?, alt_m: height_of(alt.unwrap_or_default())? })
}

/// `ExtendedData`: by itself (`Data`), or of a schema, as other programs write what they have read (`SimpleData`).
fn data_of(placemark: &Element) -> Vec<(String, Datum)> {
    let of = |element: &Element| {
        let text = element.text_of("value").unwrap_or(&element.text);
        Some((element.attribute("name")?.to_owned(), Datum::Word(text.to_owned())))
    };
    let Some(extended) = placemark.child("ExtendedData") else { return Vec::new() };
    let of_schemas = extended.all("SchemaData").flat_map(|schema| schema.all("SimpleData"));
    extended.all("Data").chain(of_schemas).filter_map(of).collect()
}

/// Writes a `.kml`.
pub(super) fn write_kml(plan: &Plan, notes: &mut Notes) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>Plan</name>\n",
    );
    text.push_str(STYLES);
    for feature in features_of(plan, true, notes) {
        // Nothing of a plan is text: names are ours.
        let _ = writeln!(text, "<Placemark><name>{}</name>", feature.name);
        let inclusion = feature.data.iter().find(|(key, _)| key == "inclusion").map(|(_, datum)| datum);
        let style = match inclusion {
            None => "line",
            Some(Datum::Flag(false)) => "outside",
            Some(_) => "inside",
        };
        let _ = write!(text, "<styleUrl>#{style}</styleUrl><ExtendedData>");
        for (key, datum) in &feature.data {
            let _ = write!(text, "<Data name=\"{key}\"><value>");
            let _ = match datum {
                Datum::Number(value) => write!(text, "{value}"),
                Datum::Flag(value) => write!(text, "{value}"),
                Datum::Word(word) => write!(text, "{word}"),
            };
            text.push_str("</value></Data>");
        }
        text.push_str("</ExtendedData>");
        match &feature.shape {
            Shape::Nothing => {}
            Shape::Point(place) => {
                let _ = write!(text, "<Point>{}{}</Point>", mode(&feature, Some(place)), coordinates([place]));
            }
            Shape::Line(line) => {
                let mode = mode(&feature, line.first());
                let _ = write!(text, "<LineString><tessellate>1</tessellate>{mode}{}</LineString>", coordinates(line));
            }
            Shape::Area(rings) => {
                text.push_str("<Polygon><tessellate>1</tessellate>");
                for ring in rings {
                    let closed = coordinates(ring.iter().chain(ring.first()));
                    let _ = write!(text, "<outerBoundaryIs><LinearRing>{closed}</LinearRing></outerBoundaryIs>");
                }
                text.push_str("</Polygon>");
            }
        }
        text.push_str("</Placemark>\n");
    }
    text.push_str("</Document>\n</kml>\n");
    text
}

fn mode(feature: &Feature, place: Option<&Place>) -> &'static str {
    match (place.and_then(|place| place.alt_m), feature.heights) {
        (None, _) => "",
        (Some(_), Heights::Terrain) => "<altitudeMode>relativeToGround</altitudeMode>",
        (Some(_), Heights::Sea | Heights::Ellipsoid) => "<altitudeMode>absolute</altitudeMode>",
    }
}

fn coordinates<'a>(places: impl IntoIterator<Item = &'a Place>) -> String {
    let mut text = String::from("<coordinates>");
    for (index, Place { point, alt_m }) in places.into_iter().enumerate() {
        let gap = if index == 0 { "" } else { " " };
        let _ = write!(text, "{gap}{},{}", point.lon_deg(), point.lat_deg());
        if let Some(alt_m) = alt_m {
            let _ = write!(text, ",{alt_m}");
        }
    }
    text.push_str("</coordinates>");
    text
}

/// The first `.kml` in a zip, which is the one that counts, unpacked.
///
/// # Errors
/// [`FlightError::BadFile`] for a damaged archive, one without a `.kml`, and one that unpacks to more than may be read.
pub(super) fn kml_of_kmz(bytes: &[u8]) -> Result<Vec<u8>> {
    let damaged = |problem: &dyn std::fmt::Display| {
        FlightError::BadFile(format!("the zip is damaged ({problem}); save it again"))
    };
    let too_large = || {
        FlightError::BadFile(format!(
            "the .kml in the zip has more than {MAX_FILE_BYTES} bytes; save it without pictures and recorded tracks, or split it"
        ))
    };
    let archive = ZipArchive::from_slice(bytes).map_err(|error| damaged(&error))?;
    let mut entries = archive.entries();
    while let Some(entry) = entries.next_entry().map_err(|error| damaged(&error))? {
        if !entry.file_path().as_bytes().to_ascii_lowercase().ends_with(b".kml") {
            continue;
        }
        if entry.flags().is_encrypted() {
            return Err(FlightError::BadFile("the .kml in the zip is encrypted; save it without a password".into()));
        }
        if entry.uncompressed_size_hint() > MAX_FILE_BYTES as u64 {
            return Err(too_large());
        }
        let method = entry.compression_method();
        let found = archive.get_entry(entry.wayfinder()).map_err(|error| damaged(&error))?;
        // The size that the archive announces is not trusted.
        let mut unpacked = Vec::new();
        let limit = MAX_FILE_BYTES as u64 + 1;
        let read = match method {
            CompressionMethod::STORE => found.verifying_reader(found.data()).take(limit).read_to_end(&mut unpacked),
            CompressionMethod::DEFLATE => {
                let inflated = flate2::bufread::DeflateDecoder::new(found.data());
                found.verifying_reader(inflated).take(limit).read_to_end(&mut unpacked)
            }
            _ => {
                return Err(FlightError::BadFile(
                    "the .kml in the zip is packed in a way that KMZ does not have (neither stored nor deflated); save it again".into(),
                ));
            }
        };
        read.map_err(|error| damaged(&error))?;
        return if unpacked.len() > MAX_FILE_BYTES { Err(too_large()) } else { Ok(unpacked) };
    }
    Err(FlightError::BadFile("the zip holds no .kml, so it is no .kmz; unpack it and choose the plan in it".into()))
}

/// Packs a `.kml` as `.kmz`.
pub(super) fn kmz_of_kml(text: &str) -> Vec<u8> {
    let pack = || -> std::io::Result<Vec<u8>> {
        let other = std::io::Error::other::<rawzip::Error>;
        let mut archive = ZipArchiveWriter::new(Vec::new());
        let (mut entry, config) =
            archive.new_file("doc.kml").compression_method(CompressionMethod::DEFLATE).start().map_err(other)?;
        let encoder = flate2::write::DeflateEncoder::new(&mut entry, flate2::Compression::default());
        let mut writer = config.wrap(encoder);
        writer.write_all(text.as_bytes())?;
        let (encoder, descriptor) = writer.finish().map_err(other)?;
        encoder.finish()?;
        entry.finish(descriptor).map_err(other)?;
        archive.finish().map_err(other)
    };
    pack().expect("invariant: a zip of one file is written to memory without error")
}
