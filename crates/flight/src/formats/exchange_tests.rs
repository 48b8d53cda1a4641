//! Tests of the formats of map programs: what others write is read with its heights named, what we write is read as it
//! was.

use super::*;
use crate::formats::waypoints::tests::missions;
use crate::geodesy::GeoPoint;
use crate::plan::{
    Command, Fence, FenceShape, FenceZone, Home, MAX_ITEMS, MavFrame, Mission, MissionItem, Rally, RallyPoint,
};
use proptest::prelude::*;

const WHOLE: [PlanFormat; 4] = [PlanFormat::Kml, PlanFormat::Kmz, PlanFormat::GeoJson, PlanFormat::Csv];

fn written(plan: &Plan, format: PlanFormat) -> WrittenPlan {
    write_plan(plan, &PlanSettings::default(), format).unwrap()
}

fn codes(notes: &[Note]) -> Vec<(&'static str, usize)> {
    notes.iter().map(|note| (note.code.as_str(), note.count)).collect()
}

/// Latitude, longitude, height and frame of each item.
fn places(plan: &Plan) -> Vec<(f64, f64, Option<f64>, MavFrame)> {
    let of = |item: &MissionItem| (item.lat_deg().unwrap(), item.lon_deg().unwrap(), item.alt_m(), item.frame);
    plan.mission.items.iter().map(of).collect()
}

fn points() -> impl Strategy<Value = GeoPoint> {
    (-90.0..=90.0_f64, -180.0..=180.0_f64).prop_map(|(lat, lon)| GeoPoint::new(lat, lon).unwrap())
}

fn plans() -> impl Strategy<Value = Plan> {
    let polygon = prop::collection::vec(points(), 3..8).prop_map(|vertices| FenceShape::Polygon { vertices });
    let circle = (points(), 1.0..5_000.0_f64).prop_map(|(center, radius_m)| FenceShape::Circle { center, radius_m });
    let zone =
        (any::<bool>(), prop_oneof![polygon, circle]).prop_map(|(inclusion, shape)| FenceZone { inclusion, shape });
    let frames = vec![MavFrame::Global, MavFrame::GlobalRelativeAlt, MavFrame::GlobalTerrainAlt];
    let rally = (points(), -100.0..3_000.0_f64, prop::sample::select(frames))
        .prop_map(|(point, alt_m, frame)| RallyPoint { point, alt_m, frame });
    (
        missions(),
        prop::collection::vec(zone, 0..3),
        prop::option::of((points(), 0.0..500.0_f64)),
        prop::collection::vec(rally, 0..3),
    )
        .prop_map(|(mission, zones, return_point, points)| Plan {
            mission,
            fence: Fence { zones, return_point },
            rally: Rally { points },
        })
}

proptest! {
    #[test]
    fn a_plan_survives_every_format_that_holds_all(plan in plans()) {
        prop_assume!(plan != Plan::default());
        for format in WHOLE {
            let file = written(&plan, format);
            let again = read_plan(&file.bytes, None).unwrap();
            prop_assert_eq!(&again.plan, &plan, "{:?}", format);
            prop_assert_eq!((again.format, again.notes), (format, Vec::new()));
        }
    }

    #[test]
    fn a_route_of_gpx_keeps_places_and_says_what_not(plan in plans()) {
        let Ok(file) = write_plan(&plan, &PlanSettings::default(), PlanFormat::Gpx) else { return Ok(()) };
        let again = read_plan(&file.bytes, None).unwrap();
        let count = |code| file.notes.iter().find(|note| note.code == code).map_or(0, |note| note.count);
        let left_out = count(NoteCode::ItemsNotWritten);
        prop_assert_eq!(again.plan.mission.items.len() + left_out, plan.mission.items.len());
        prop_assert_eq!(count(NoteCode::RallyNotWritten), plan.rally.points.len());
        let missing = again.notes.iter().find(|note| note.code == NoteCode::HeightsMissing).map_or(0, |note| note.count);
        prop_assert_eq!(count(NoteCode::HeightsNotWritten), missing);
        // what was read says the same again
        let twice = read_plan(&written(&again.plan, PlanFormat::Gpx).bytes, None).unwrap();
        prop_assert_eq!(twice.plan, again.plan);
    }

    #[test]
    fn damaged_files_are_read_or_refused(
        plan in plans(), format in prop::sample::select(PlanFormat::WRITTEN.to_vec()),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4), end: prop::sample::Index,
    ) {
        let Ok(file) = write_plan(&plan, &PlanSettings::default(), format) else { return Ok(()) };
        let mut bytes = file.bytes;
        for (place, byte) in damage {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        let _ = read_plan(&bytes, None);
        bytes.truncate(end.index(bytes.len()));
        let _ = read_plan(&bytes, Some("x.csv"));
    }

    #[test]
    fn any_markup_is_read_or_refused(
        inner in "(<(Placemark|Point|LineString|Polygon|coordinates|outerBoundaryIs|LinearRing|trk|trkseg|rte|rtept lat='1' lon='-3'|wpt)>|</[a-zA-Z]{1,9}>|[0-9,. -]{1,12}){0,30}",
        root in "kml|gpx",
    ) {
        let _ = read_plan(format!("<{root}>{inner}</{root}>").as_bytes(), None);
    }

    #[test]
    fn any_table_is_read_or_refused(body in "([0-9.,;\"-]{0,8}[,;\n]){0,40}", separator in "[,;\t]") {
        let _ = read_plan(format!("lat{separator}lon{separator}alt\n{body}").as_bytes(), None);
    }
}

#[test]
fn a_path_and_an_area_of_google_earth_are_mission_and_fence() {
    let kml = b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<kml xmlns=\"http://www.opengis.net/kml/2.2\" xmlns:gx=\"http://www.google.com/kml/ext/2.2\"><Document><name>Club</name><Folder>
<Placemark><name>Path &amp; back</name><LineString><tessellate>1</tessellate><altitudeMode>absolute</altitudeMode>
<coordinates>-3.80,40.33,700 -3.81,40.34,710.5
 -3.82,40.33,700 </coordinates></LineString></Placemark>
<Placemark><name>House</name><Point><coordinates>-3.8,40.3,0</coordinates></Point></Placemark>
<Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>-3.9,40.3,0 -3.7,40.3,0 -3.7,40.4,0 -3.9,40.3,0</coordinates></LinearRing></outerBoundaryIs>
<innerBoundaryIs><LinearRing><coordinates>-3.8,40.32 -3.79,40.32 -3.79,40.33 -3.8,40.32</coordinates></LinearRing></innerBoundaryIs></Polygon></Placemark>
<GroundOverlay/></Folder></Document></kml>";
    let file = read_plan(kml, None).unwrap();
    let sea = MavFrame::Global;
    assert_eq!(
        places(&file.plan),
        [(40.33, -3.80, Some(700.0), sea), (40.34, -3.81, Some(710.5), sea), (40.33, -3.82, Some(700.0), sea)]
    );
    let zones: Vec<_> = file.plan.fence.zones.iter().map(|zone| zone.inclusion).collect();
    assert_eq!(zones, [true, false]);
    assert_eq!(
        codes(&file.notes),
        [
            ("heights-above-sea-level", 3),
            ("not-places", 1),
            ("points-left-out", 1),
            ("areas-taken-as-fence", 1),
            ("holes-taken-as-fence", 1),
            ("names-not-kept", 2),
        ]
    );
    // in a zip, the first .kml counts
    let zip = kml::kmz_of_kml(std::str::from_utf8(kml).unwrap());
    let zipped = read_plan(&zip, None).unwrap();
    assert_eq!((zipped.plan, zipped.format), (file.plan, PlanFormat::Kmz));
}

#[test]
fn heights_of_kml_count_from_what_the_file_says() {
    let read = |mode: &str| {
        let kml =
            format!("<kml><Placemark><Point>{mode}<coordinates>-3.8,40.3,80</coordinates></Point></Placemark></kml>");
        let file = read_plan(kml.as_bytes(), None).unwrap();
        (places(&file.plan)[0], codes(&file.notes))
    };
    let (lat, lon) = (40.3, -3.8);
    let mode = |mode| format!("<altitudeMode>{mode}</altitudeMode>");
    let terrain = (lat, lon, Some(80.0), MavFrame::GlobalTerrainAlt);
    assert_eq!(read(&mode("relativeToGround")), (terrain, vec![("heights-above-terrain", 1)]));
    assert_eq!(read(&mode("absolute")).0, (lat, lon, Some(80.0), MavFrame::Global));
    for says_nothing in
        [String::new(), mode("clampToGround"), "<gx:altitudeMode>relativeToSeaFloor</gx:altitudeMode>".into()]
    {
        let unknown = (lat, lon, None, MavFrame::GlobalRelativeAlt);
        assert_eq!(read(&says_nothing), (unknown, vec![("heights-missing", 1)]));
    }
    let track = "<kml><Placemark><gx:Track><altitudeMode>absolute</altitudeMode><when>x</when>\
                 <gx:coord>-3.8 40.3 80</gx:coord><gx:coord>-3.9 40.3 90</gx:coord></gx:Track></Placemark></kml>";
    let read = read_plan(track.as_bytes(), None).unwrap();
    assert_eq!(places(&read.plan)[1], (40.3, -3.9, Some(90.0), MavFrame::Global));
}

#[test]
fn routes_of_gpx_go_before_tracks_and_points() {
    let point = |tag: &str, lon: f64, ele: &str| format!("<{tag} lat=\"40.3\" lon=\"{lon}\">{ele}</{tag}>");
    let wpt = point("wpt", -3.0, "<ele>5</ele><name>Home</name>");
    let rte = format!("<rte>{}{}</rte>", point("rtept", -3.1, "<ele>700</ele>"), point("rtept", -3.2, ""));
    let trk = format!(
        "<trk><trkseg>{}</trkseg><trkseg>{}</trkseg></trk>",
        point("trkpt", -3.3, ""),
        point("trkpt", -3.4, "")
    );
    let read = |inner: &str| {
        let gpx = format!("<?xml version='1.0'?><gpx version='1.1' creator='x'>{inner}</gpx>");
        let file = read_plan(gpx.as_bytes(), None).unwrap();
        let lons: Vec<f64> = places(&file.plan).iter().map(|place| place.1).collect();
        (lons, codes(&file.notes))
    };
    assert_eq!(
        read(&format!("{wpt}{rte}{trk}")),
        (
            vec![-3.1, -3.2],
            vec![
                ("heights-above-sea-level", 1),
                ("heights-missing", 1),
                ("points-left-out", 1),
                ("tracks-left-out", 2)
            ]
        )
    );
    assert_eq!(
        read(&format!("{wpt}{trk}<rte/>")),
        (vec![-3.3, -3.4], vec![("heights-missing", 2), ("points-left-out", 1), ("lines-joined", 2)])
    );
    assert_eq!(read(&wpt), (vec![-3.0], vec![("heights-above-sea-level", 1), ("names-not-kept", 1)]));
}

#[test]
fn geojson_of_map_programs_is_read() {
    let read = |json: &str| {
        let file = read_plan(json.as_bytes(), None).unwrap();
        (places(&file.plan), file.plan.fence.zones.len(), codes(&file.notes))
    };
    let (found, zones, notes) = read(
        r#"{"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:OGC:1.3:CRS84"}},"features":[
        {"type":"Feature","properties":{"title":null},"geometry":{"type":"MultiLineString","coordinates":[[[-3.8,40.3,700],[-3.9,40.3]]]}},
        {"type":"Feature","properties":{"title":"field"},"geometry":{"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1],[0,0]]]}},
        {"type":"Feature","properties":null,"geometry":null}]}"#,
    );
    assert_eq!(found, [(40.3, -3.8, Some(700.0), MavFrame::Global), (40.3, -3.9, None, MavFrame::GlobalRelativeAlt)]);
    assert_eq!(zones, 1);
    assert_eq!(
        notes,
        [
            ("heights-taken-above-sea-level", 1),
            ("heights-missing", 1),
            ("not-places", 1),
            ("areas-taken-as-fence", 1),
            ("names-not-kept", 1)
        ]
    );
    assert_eq!(read(r#"{"type":"Point","coordinates":[-3.8,40.3]}"#).0.len(), 1);
}

#[test]
fn tables_say_what_their_heights_count_from_or_it_is_said() {
    let read = |table: &str| {
        let file = read_plan(table.as_bytes(), None).unwrap();
        (places(&file.plan), codes(&file.notes))
    };
    let home = MavFrame::GlobalRelativeAlt;
    let (found, notes) = read("\n\nName;Latitud;Longitud;Altura\nuno;40,33;-3,8;60\n\n;;;\ndos;40,34;-3,8;\n");
    assert_eq!(found, [(40.33, -3.8, Some(60.0), home), (40.34, -3.8, None, home)]);
    assert_eq!(notes, [("heights-taken-above-home", 1), ("heights-missing", 1), ("names-not-kept", 2)]);
    assert_eq!(
        read("lon,lat,alt_amsl_m\n-3.8,40.33,700\n"),
        (vec![(40.33, -3.8, Some(700.0), MavFrame::Global)], vec![])
    );
    let commands = "lat\tlon\talt_rel_home_m\tcommand\tp1\n40.3\t-3.8\t60\tNAV_TAKEOFF\t12\n40.3\t-3.9\t60\t16\t0\n";
    let plan = read_plan(commands.as_bytes(), None).unwrap().plan;
    assert_eq!(plan.mission.items[0].command, Command::NAV_TAKEOFF);
    assert_eq!(plan.mission.items[0].params[0], Some(12.0));
}

#[test]
fn moving_a_point_in_a_map_program_moves_the_item() {
    let plan = Plan::from_mission(Mission {
        home: None,
        items: vec![MissionItem::loiter_turns(40.25, -3.5, 80.0, 3.0, -60.0), MissionItem::change_airspeed(17.0)],
    });
    for format in [PlanFormat::Kml, PlanFormat::GeoJson] {
        let text = String::from_utf8(written(&plan, format).bytes).unwrap();
        // the tool adds an area of its own
        let (end, area) = if format == PlanFormat::Kml {
            (
                "</Document>",
                "<Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>0,0 1,0 1,1</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></Document>",
            )
        } else {
            ("\n]}", ",\n{\"type\":\"Polygon\",\"coordinates\":[[[0,0],[1,0],[1,1]]]}]}")
        };
        let area = if format == PlanFormat::Kml {
            area.to_owned()
        } else {
            area.replace(
                "{\"type\":\"Polygon\"",
                "{\"type\":\"Feature\",\"properties\":{},\"geometry\":{\"type\":\"Polygon\"",
            )
            .replace("]]]}", "]]]}}")
        };
        let moved = text.replace("40.25", "40.26").replace(end, &area);
        let file = read_plan(moved.as_bytes(), None).unwrap();
        let mut expected = plan.mission.items.clone();
        expected[0].params[4] = Some(40.26);
        assert_eq!(file.plan.mission.items, expected, "{moved}");
        assert_eq!(codes(&file.notes), [("areas-taken-as-fence", 1)]);
    }
}

#[test]
fn the_largest_plan_is_read_as_it_was_written() {
    let item = |index| MissionItem::loiter_turns(40.0 + f64::from(index) / 1e5, -3.123_456_7, 123.4, 3.0, -60.5);
    let home = Some(Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 });
    let plan = |count| Plan::from_mission(Mission { home, items: (0..count as u32).map(item).collect() });
    for (format, count) in [(PlanFormat::Kmz, MAX_ITEMS), (PlanFormat::Csv, MAX_ITEMS), (PlanFormat::GeoJson, 6_000)] {
        assert!(read_plan(&written(&plan(count), format).bytes, None).unwrap().plan == plan(count), "{format:?}");
    }
    assert!(write_plan(&plan(MAX_ITEMS), &PlanSettings::default(), PlanFormat::GeoJson).is_err());
}

#[test]
fn many_parts_do_not_copy_the_data_that_they_share() {
    // copied for each, these would be 12 GB
    let points = vec!["[1,1]"; 4_000].join(",");
    let data = "x".repeat(3_000_000);
    let json = format!(
        r#"{{"type":"Feature","properties":{{"d":"{data}"}},"geometry":{{"type":"MultiPoint","coordinates":[{points}]}}}}"#
    );
    let file = read_plan(json.as_bytes(), None).unwrap();
    assert_eq!(file.plan.mission.items.len(), 4_000);
    let points = "<Point><coordinates>1,1</coordinates></Point>".repeat(4_000);
    let kml = format!(
        "<kml><Placemark><ExtendedData><Data name='d'><value>{data}</value></Data></ExtendedData><MultiGeometry>{points}</MultiGeometry></Placemark></kml>"
    );
    assert_eq!(read_plan(kml.as_bytes(), None).unwrap().plan, file.plan);
    let long = format!(
        "<kml><Placemark><LineString><coordinates>{}</coordinates></LineString></Placemark></kml>",
        "1,1 ".repeat(10_001)
    );
    assert!(read_plan(long.as_bytes(), None).unwrap_err().to_string().contains("at most 10000"));
}

#[test]
fn jumps_follow_items_when_a_map_program_loses_some() {
    let items = vec![
        MissionItem::change_airspeed(17.0),
        MissionItem::waypoint(40.25, -3.5, 80.0),
        MissionItem::jump(MissionSeq(2), 3),
    ];
    let plan = Plan::from_mission(Mission { home: None, items });
    let text = String::from_utf8(written(&plan, PlanFormat::GeoJson).bytes).unwrap();
    let without = |lost: &str| {
        let kept: Vec<&str> = text.lines().filter(|line| !line.contains(lost)).collect();
        read_plan(kept.join("\n").as_bytes(), None)
    };
    let file = without("\"item\":1,").unwrap();
    assert_eq!(file.plan.mission.items[1], MissionItem::jump(MissionSeq(1), 3));
    assert_eq!(codes(&file.notes), [("items-missing", 1)]);
    let error = without("\"item\":2,").unwrap_err().to_string();
    assert!(error.starts_with("item 3 jumps to item 2, which is not in the file"), "{error}");
}

#[test]
fn what_is_not_kept_is_said() {
    let home = Some(Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 });
    let mut over_terrain = MissionItem::waypoint(40.2, -3.0, 50.0);
    over_terrain.frame = MavFrame::GlobalTerrainAlt;
    let items = vec![MissionItem::takeoff(40.1, -3.0, 60.0, 15.0), over_terrain, MissionItem::return_to_launch()];
    let point = GeoPoint::new(40.0, -3.0).unwrap();
    let plan = Plan {
        mission: Mission { home, items },
        fence: Fence { zones: Vec::new(), return_point: Some((point, 50.0)) },
        rally: Rally { points: vec![RallyPoint { point, alt_m: 50.0, frame: MavFrame::GlobalRelativeAlt }] },
    };
    let planned_for = PlannedFor { cruise_speed_m_s: Some(17.0), ..PlannedFor::default() };
    let settings = PlanSettings { planned_for, ..PlanSettings::default() };
    let notes = |format| codes(&write_plan(&plan, &settings, format).unwrap().notes);
    assert_eq!(notes(PlanFormat::QgcPlan), []);
    let (fence, rally, rest) = (("fence-not-written", 1), ("rally-not-written", 1), ("settings-not-written", 1));
    assert_eq!(notes(PlanFormat::Waypoints), [fence, rally, rest]);
    assert_eq!(notes(PlanFormat::Kml), [("heights-drawn-above-sea-level", 2), rest]);
    assert_eq!(notes(PlanFormat::GeoJson), [("heights-not-drawn", 3), rest]);
    assert_eq!(notes(PlanFormat::Csv), [rest]);
    assert_eq!(
        notes(PlanFormat::Gpx),
        [
            ("heights-written-above-sea-level", 1),
            ("heights-not-written", 1),
            ("commands-not-written", 1),
            ("items-not-written", 1),
            ("home-not-written", 1),
            fence,
            rally,
            rest
        ]
    );
    let gpx = String::from_utf8(written(&plan, PlanFormat::Gpx).bytes).unwrap();
    assert!(gpx.contains("<ele>660</ele>"), "{gpx}");
}

#[test]
fn faults_are_named_with_their_place() {
    let placemark = |inner: &str| format!("<kml><Placemark><name>Field</name>{inner}</Placemark></kml>");
    let cases = [
        (
            placemark("<Point><coordinates>-3.8, 40.3</coordinates></Point>"),
            "placemark 1 (\"Field\"): has \"-3.8,\" as a coordinate",
        ),
        (
            placemark("<LineString><coordinates>-3.8,140.3 0,0</coordinates></LineString>"),
            "placemark 1 (\"Field\"): latitude 140.3",
        ),
        (
            placemark("<Point><coordinates>x,40</coordinates></Point>"),
            "placemark 1 (\"Field\"): has \"x\" as its longitude",
        ),
        (
            placemark(
                "<Polygon><outerBoundaryIs><LinearRing><coordinates>0,0 1,1 0,0</coordinates></LinearRing></outerBoundaryIs></Polygon>",
            ),
            "placemark 1 (\"Field\"): a polygon needs at least 3 corners",
        ),
        (
            placemark("<ExtendedData><Data name='vencejo'><value>item</value></Data></ExtendedData>"),
            "placemark 1 (\"Field\"): lacks its datum command",
        ),
        (placemark(""), "the file holds no point"),
        ("<kml><a></kml>".into(), "the file cannot be read: no XML"),
        ("<osm/>".into(), "the file cannot be read as a plan: it is XML of another kind (<osm>)"),
        ("<gpx><rte><rtept lat='40'/></rte></gpx>".into(), "route 1, point 1: has \"\" as its longitude"),
        ("<gpx><wpt lat='40' lon='1'><ele>high</ele></wpt></gpx>".into(), "point 1: has \"high\" as its height"),
        (r#"{"type":"Feature","geometry":{"type":"Circle","coordinates":[]}}"#.into(), "geometry.type: is \"Circle\""),
        (
            r#"{"type":"LineString","coordinates":[[-3.8,40.3],[-3.8]]}"#.into(),
            "coordinates[1]: is a list where [longitude",
        ),
        (r#"{"type":"Point","coordinates":[440000,4470000]}"#.into(), "coordinates: latitude 4470000"),
        (
            r#"{"type":"Point","coordinates":[0,0],"crs":{"properties":{"name":"EPSG:25830"}}}"#.into(),
            "crs: has coordinates in \"EPSG:25830\"",
        ),
        ("lat,lon\n40,x\n".into(), "line 2: has \"x\" as its longitude"),
        ("lat,lon,command\n\n40,-3,NAV_NOTHING\n".into(), "line 3: has \"NAV_NOTHING\" as its command"),
        ("lat,lon\n40,\n".into(), "line 2: has one of latitude and longitude"),
        ("lat,lon\n".into(), "the table has no rows"),
    ];
    for (text, expected) in cases {
        let error = read_plan(text.as_bytes(), None).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    let error = read_plan(b"40.3;-3.8;60\n", Some("route.csv")).unwrap_err().to_string();
    assert!(error.starts_with("line 1: does not name the columns"), "{error}");
}

#[test]
fn what_no_vehicle_takes_is_refused_where_it_stands() {
    let feature = |properties: &str| {
        format!(
            r#"{{"type":"Feature","geometry":{{"type":"Point","coordinates":[-3.2,40.2]}},"properties":{{{properties}}}}}"#
        )
    };
    let plan = |part: &str| format!(r#"{{"fileType":"Plan","version":1,"mission":{{"version":2,"items":[]}},{part}}}"#);
    let cases = [
        ("RALLY 40.2 -3.2 1e78 40 0 4\n".into(), "line 1: has 1e78 as its z"),
        (feature(r#""vencejo":"rally","alt_m":1e78,"frame":3"#), "plan: has 1e78 as its z"),
        (feature(r#""vencejo":"rally","alt_m":60,"frame":2"#), "plan: no position has no meaning for a place"),
        (feature(r#""vencejo":"fence-return","alt_rel_home_m":1e78"#), "plan: has 1e78 as its z"),
        (
            plan(r#""rallyPoints":{"points":[[40.2,-3.2,60],[40.2,-3.2,1e78]]}"#),
            "rallyPoints.points[1]: has 1e78 as its z",
        ),
        (plan(r#""geoFence":{"breachReturn":[40.2,-3.2,1e78]}"#), "geoFence.breachReturn: has 1e78 as its z"),
    ];
    for (text, expected) in cases {
        let error = read_plan(text.as_bytes(), None).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn how_to_land_at_a_rally_point_is_not_dropped_in_silence() {
    // Break altitude, direction, favourable wind, an unknown flag; the last two say where to return to alone.
    let text = "RALLY 40.2 -3.2 60 40 0 0\nRALLY 40.2 -3.2 60 0 180 0\nRALLY 40.2 -3.2 60 0 0 1\n\
                RALLY 40.2 -3.2 60 0 0 32\nRALLY 40.2 -3.2 700 0 0 4\nRALLY 40.2 -3.2 60 0.0 0.0 28\n";
    let file = read_plan(text.as_bytes(), None).unwrap();
    assert_eq!((file.plan.rally.points.len(), codes(&file.notes)), (6, vec![("rally-landings-not-kept", 4)]));
    for (text, expected) in [
        ("RALLY 40.2 -3.2 60 low 0 0\n", "line 1: has \"low\" as its break altitude"),
        ("RALLY 40.2 -3.2 60 40 south 0\n", "line 1: has \"south\" as its landing direction"),
    ] {
        let error = read_plan(text.as_bytes(), None).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn zips_do_not_unpack_to_more_than_is_read() {
    let refused = |zip: &[u8]| read_plan(zip, None).unwrap_err().to_string();
    let bomb = kml::kmz_of_kml(&" ".repeat(MAX_FILE_BYTES + 1));
    assert!(bomb.len() < 100_000);
    assert!(refused(&bomb).contains("more than 16777216 bytes"));
    // one that says it is small
    let mut lies = bomb.clone();
    let size = u32::try_from(MAX_FILE_BYTES + 1).unwrap().to_le_bytes();
    while let Some(at) = lies.windows(4).position(|window| window == size) {
        lies[at..at + 4].copy_from_slice(&10_u32.to_le_bytes());
    }
    assert_ne!(lies, bomb);
    let error = refused(&lies);
    assert!(error.contains("more than 16777216 bytes") || error.contains("damaged"), "{error}");
    assert!(refused(b"PK\x03\x04garbage").contains("the zip is damaged"));
    let other = kml::kmz_of_kml("<kml/>");
    let renamed: Vec<u8> = String::from_utf8_lossy(&other)
        .contains("doc.kml")
        .then(|| {
            let mut other = other.clone();
            while let Some(at) = other.windows(7).position(|window| window == b"doc.kml") {
                other[at..at + 7].copy_from_slice(b"doc.txt");
            }
            other
        })
        .unwrap();
    assert!(refused(&renamed).contains("holds no .kml"));
}

#[test]
fn every_format_has_an_ending_of_its_own() {
    for format in PlanFormat::WRITTEN {
        assert_eq!(PlanFormat::of_name(&format!("a.b.{}", format.ending().to_uppercase())), Some(format));
    }
    assert_eq!(PlanFormat::of_name("mission.txt"), Some(PlanFormat::Waypoints));
    assert_eq!((PlanFormat::of_name("plan"), PlanFormat::of_name("x.doc")), (None, None));
    for (index, code) in NoteCode::ALL.iter().enumerate() {
        assert!(code.sentence().is_ascii());
        assert!(NoteCode::ALL[..index].iter().all(|other| other.as_str() != code.as_str()));
    }
}
