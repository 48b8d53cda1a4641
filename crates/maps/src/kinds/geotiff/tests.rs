//! Tests of GeoTIFFs of this machine: what is read of them as heights and as pictures, and what is refused.

use super::*;
use crate::testing::Folder;
use tiff::encoder::{TiffEncoder, colortype};

fn keys(epsg: u16, is_geographic: bool, is_point: bool) -> Vec<u16> {
    let (kind, key) = if is_geographic { (2, 2048) } else { (1, 3072) };
    vec![1, 1, 0, 3, 1024, 0, 1, kind, 1025, 0, 1, 1 + u16::from(is_point), key, 0, 1, epsg]
}

fn heights(path: &Path, is_point: bool) {
    heights_of(path, is_point, [0.5, 0.5, 0.0]);
}

fn heights_of(path: &Path, is_point: bool, scale: [f64; 3]) {
    numbers(path, is_point, scale, Some("-9999"), [100.0, 200.0, -9999.0, 300.0, 400.0, 500.0], None);
}

/// Two rows of three numbers, with a void that is named and a mask that has been packed.
fn numbers(
    path: &Path,
    is_point: bool,
    scale: [f64; 3],
    void: Option<&str>,
    numbers: [f32; 6],
    mask: Option<(&[u8], u16)>,
) {
    let mut file = File::create(path).expect("a file");
    let mut encoder = TiffEncoder::new(&mut file).expect("a TIFF");
    let mut image = encoder.new_image::<colortype::Gray32Float>(3, 2).expect("an image");
    let tags = image.encoder();
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys(4326, true, is_point)[..]).expect("keys");
    tags.write_tag(Tag::Unknown(33_550), &scale[..]).expect("scale");
    tags.write_tag(Tag::Unknown(33_922), &[0.0_f64, 0.0, 0.0, -4.0, 41.0, 0.0][..]).expect("tie");
    if let Some(void) = void {
        tags.write_tag(Tag::GdalNodata, void).expect("void");
    }
    image.write_data(&numbers).expect("data");
    let Some((packed, packing)) = mask else { return };
    let mut mask = encoder.image_directory().expect("a mask");
    let at = mask.write_data(packed).expect("bits");
    for (tag, value) in [
        (Tag::NewSubfileType, 4_u32),
        (Tag::ImageWidth, 3),
        (Tag::ImageLength, 2),
        (Tag::BitsPerSample, 1),
        (Tag::Compression, packing.into()),
        (Tag::PhotometricInterpretation, 4),
        (Tag::StripOffsets, u32::try_from(at).expect("small")),
        (Tag::SamplesPerPixel, 1),
        (Tag::RowsPerStrip, 2),
        (Tag::StripByteCounts, u32::try_from(packed.len()).expect("small")),
    ] {
        mask.write_tag(tag, value).expect("a tag");
    }
    mask.finish().expect("a mask");
}

#[test]
fn voids_are_no_heights_whatever_names_them() {
    let folder = Folder::new();
    let path = folder.path().join("h.tif");
    let scale = [0.5, 0.5, 0.0];
    // The middle of the first pixel and of the second, and half-way between them.
    let read = |void: Option<&str>, second: f32, mask: Option<(&[u8], u16)>| {
        numbers(&path, false, scale, void, [1500.0, second, 1500.0, 1500.0, 1500.0, 1500.0], mask);
        let file = GeoTiff::open(&path).expect("a file");
        [-3.75, -3.25, -3.5].map(|lon| file.height_m(40.75, lon, true).expect("read"))
    };
    let void = [Some(1500.0), None, None];
    for second in [-9999.0, -32_767.0, -32_768.0, f32::MIN, f32::NAN, 12_345.0] {
        assert_eq!(read(None, second, None), void, "{second}");
    }
    assert_eq!(read(Some("-9.9"), -9.9, None), void, "named in more digits than it has");
    assert_eq!(read(None, -40.0, None), [Some(1500.0), Some(-40.0), Some(730.0)], "the shore of a salt lake");
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    io::Write::write_all(&mut packer, &[0b1010_0000, 0b1110_0000]).expect("packed");
    let packed = packer.finish().expect("packed");
    assert_eq!(read(None, 0.0, Some((&packed, 8))), void, "hidden by the mask");
    assert_eq!(GeoTiff::open(&path).expect("a file").height_fault(), None);
    numbers(&path, false, scale, None, [1500.0; 6], Some((&[0b1010_0000, 0b1110_0000], 1)));
    let fault = GeoTiff::open(&path).expect("a file").height_fault().expect("unread");
    assert!(fault.contains("mask"), "{fault}");
}

#[test]
fn heights_lie_between_the_middles_of_pixels() {
    let folder = Folder::new();
    let path = folder.path().join("h.tif");
    heights(&path, false);
    let file = GeoTiff::open(&path).expect("a file");
    assert!(file.has_numbers());
    for (lat, lon, height) in [
        (40.75, -3.75, Some(100.0)),
        (40.75, -3.25, Some(200.0)),
        (40.25, -3.25, Some(400.0)),
        (40.5, -3.5, Some(250.0)),
        (40.75, -3.0, None),
        (40.25, -2.75, Some(500.0)),
        (41.0, -4.0, Some(100.0)),
        (41.1, -4.0, None),
    ] {
        let found = file.height_m(lat, lon, false).expect("read");
        assert_eq!(found, height, "{lat} {lon}");
    }
    heights(&path, true);
    let file = GeoTiff::open(&path).expect("a file");
    assert_eq!(file.height_m(41.0, -4.0, false).expect("read"), Some(100.0), "pixels are points");
    assert!(file.tile(TileId { level: 0, column: 0, row: 0 }).is_err(), "heights are not drawn");
    // A file of another layout in its place is not read at the old offsets; places outside of it are not affected.
    std::fs::write(&path, [std::fs::read(&path).expect("read"), vec![0]].concat()).expect("written");
    assert!(file.height_m(41.0, -4.0, false).expect_err("another").to_string().contains("replaced"));
    assert_eq!(file.height_m(10.0, 10.0, false).expect("not looked at"), None);
}

/// A file of one height, with more geo keys (four numbers each) and a note of GDAL's.
fn one_height(path: &Path, more: &[u16], noted: Option<&str>, value: f32) -> GeoTiff {
    let mut keys = [keys(4326, true, false), more.to_vec()].concat();
    keys[3] += u16::try_from(more.len() / 4).expect("few");
    let mut file = File::create(path).expect("a file");
    let mut encoder = TiffEncoder::new(&mut file).expect("a TIFF");
    let mut image = encoder.new_image::<colortype::Gray32Float>(1, 1).expect("an image");
    image.encoder().write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).expect("keys");
    image.encoder().write_tag(Tag::Unknown(33_550), &[0.5_f64, 0.5, 0.0][..]).expect("scale");
    image.encoder().write_tag(Tag::Unknown(33_922), &[0.0_f64, 0.0, 0.0, -4.0, 41.0, 0.0][..]).expect("tie");
    if let Some(noted) = noted {
        let items = format!("<GDALMetadata>\n  {noted}\n</GDALMetadata>\n");
        image.encoder().write_tag(Tag::Unknown(42_112), &*items).expect("noted");
    }
    image.write_data(&[value]).expect("data");
    drop(file);
    GeoTiff::open(path).expect("a file")
}

#[test]
fn heights_in_feet_or_scaled_are_metres() {
    let folder = Folder::new();
    let path = folder.path().join("h.tif");
    let height_m = |units: &[u16], noted: Option<&str>, value: f32| {
        let file = one_height(&path, units, noted, value);
        match file.height_fault() {
            Some(fault) => Err(fault),
            None => Ok(file.height_m(40.75, -3.75, true).expect("read").map(|alt_m| (alt_m * 1e3).round() / 1e3)),
        }
    };
    let survey_feet = [4096, 0, 1, 6360];
    for (units, noted, value, expected) in [
        (&[4099, 0, 1, 9001][..], None, 1_000.0, Some(1_000.0)),
        (&[4099, 0, 1, 9002], None, 1_000.0, Some(304.8)),
        (&[4099, 0, 1, 9003], None, 1_000.0, Some(304.801)),
        (&survey_feet, None, 14_000.0, Some(4_267.209)),
        (&[], Some(r#"<Item name="UNITTYPE" sample="0" role="unittype">ft</Item>"#), 1_000.0, Some(304.8)),
        (&[4099, 0, 1, 9002], Some(r#"<Item name="UNITTYPE" sample="0" role="unittype">m</Item>"#), 10.0, Some(10.0)),
        (
            &[],
            Some(
                r#"<Item name="OFFSET" sample="0" role="offset">-100</Item><Item name="SCALE" sample="0" role="scale">0.1</Item>"#,
            ),
            16_000.0,
            Some(1_500.0),
        ),
        (&[], Some(r#"<Item name="SCALE" sample="1" role="scale">0.1</Item>"#), 600.0, Some(600.0)),
        (&[], Some(r#"<Item name="SCALE" sample="0" role="scale">0.1</Item>"#), -9_999.0, None),
    ] {
        assert_eq!(height_m(units, noted, value), Ok(expected), "{units:?} {noted:?}");
    }
    let fault = height_m(&[4099, 0, 1, 9014], None, 100.0).expect_err("fathoms");
    assert!(fault.contains("EPSG:9014"), "{fault}");
    let fault = height_m(&[], Some(r#"<Item sample="0" role="unittype">cubits</Item>"#), 100.0).expect_err("cubits");
    assert!(fault.contains("cubits"), "{fault}");
}

#[test]
fn a_file_above_an_ellipsoid_is_no_source_of_heights() {
    let folder = Folder::new();
    for (vertical, is_refused) in [(5030, true), (5773, false)] {
        let path = folder.path().join(format!("{vertical}.tif"));
        let fault = one_height(&path, &[4096, 0, 1, vertical], None, 1_500.0).height_fault();
        assert_eq!(fault.is_some_and(|fault| fault.contains("ellipsoid")), is_refused, "{vertical}");
    }
}

#[test]
fn a_picture_is_drawn_where_it_lies() {
    let folder = Folder::new();
    let path = folder.path().join("p.tif");
    let (width, height) = (600_u32, 300_u32);
    let mut pixels = vec![50_u8; (width * height * 3) as usize];
    let at = ((10 * width + 580) * 3) as usize;
    pixels[at..at + 3].copy_from_slice(&[255, 0, 0]);
    let mut file = File::create(&path).expect("a file");
    let mut encoder = TiffEncoder::new(&mut file).expect("a TIFF");
    let mut image = encoder.new_image::<colortype::RGB8>(width, height).expect("an image");
    image.encoder().write_tag(Tag::GeoKeyDirectoryTag, &keys(25_830, false, false)[..]).expect("keys");
    image.encoder().write_tag(Tag::Unknown(33_550), &[2.0_f64, 2.0, 0.0][..]).expect("scale");
    image
        .encoder()
        .write_tag(Tag::Unknown(33_922), &[0.0_f64, 0.0, 0.0, 432_000.0, 4_465_000.0, 0.0][..])
        .expect("tie");
    image.write_data(&pixels).expect("data");
    let file = GeoTiff::open(&path).expect("a file");
    let grid = file.grid();
    assert_eq!((grid.crs.code().as_str(), grid.max_level), ("EPSG:25830", 2));
    let bounds = file.about().bounds.expect("known");
    assert!((bounds.west_deg + 3.8).abs() < 0.01 && (bounds.north_deg - 40.33).abs() < 0.01, "{bounds:?}");
    let tile = file.tile(TileId { level: 2, column: 2, row: 0 }).expect("read").expect("there");
    let tile = Raster::read(&tile, 1 << 20).expect("a picture");
    assert_eq!(tile.pixel(580 - 512, 10), [255, 0, 0, 255]);
    assert_eq!(tile.pixel(580 - 512, 11), [50, 50, 50, 255]);
    assert_eq!(tile.pixel(100, 10)[3], 0, "beyond the file");
    assert!(file.tile(TileId { level: 0, column: 0, row: 0 }).expect("read").is_some());
}

#[test]
fn what_lies_nowhere_says_what_helps() {
    let folder = Folder::new();
    let path = folder.path().join("p.tif");
    let mut file = File::create(&path).expect("a file");
    let mut encoder = TiffEncoder::new(&mut file).expect("a TIFF");
    encoder.write_image::<colortype::RGB8>(1, 1, &[1, 2, 3]).expect("written");
    assert!(GeoTiff::open(&path).expect_err("wrong").contains("corners"));
    heights_of(&path, false, [1e-300, 0.5, 0.0]);
    assert!(GeoTiff::open(&path).expect_err("wrong").contains("as high as wide"));
    std::fs::write(&path, b"text").expect("written");
    assert!(GeoTiff::open(&path).expect_err("wrong").contains("no TIFF"));
}
