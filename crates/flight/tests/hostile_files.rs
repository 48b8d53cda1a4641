//! Files that are made to harm whoever reads them, under an allocator that counts: each is refused within a second and
//! 64 MiB (its own bytes included), and the largest plan that is a plan is read within the same.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use vencejo_flight::formats::{MAX_FILE_BYTES, PlanSettings, read_params, read_plan, write_plan_json, write_waypoints};
use vencejo_flight::plan::{Home, MAX_ITEMS, Mission, MissionItem, Plan};

/// Counts what is held, and the most that ever was.
struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

#[allow(unsafe_code, reason = "an allocator is unsafe by its interface; this one hands everything on")]
// SAFETY: every call is the system allocator's own, with the same arguments.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(held, Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const BAR: usize = 64 * 1024 * 1024;

/// How long this process has computed: on a machine that is busy with other things, what the clock says is not what
/// work takes.
fn computed() -> Duration {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = text.rsplit(')').next().unwrap_or_default();
    // Hundredths of a second for the program, and for the system on its behalf (proc(5), fields 14 and 15).
    let ticks: u64 = after_name.split_whitespace().skip(11).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
    Duration::from_millis(ticks * 10)
}

/// What work gives, when it stays within the bar together with so many bytes that were there before.
fn within<T>(name: &str, before: usize, work: impl FnOnce() -> T) -> T {
    let held = HELD.load(Ordering::SeqCst);
    MOST.store(held, Ordering::SeqCst);
    let begun = computed();
    let given = work();
    let (most, took) = (MOST.load(Ordering::SeqCst) - held + before, computed() - begun);
    assert!(most <= BAR, "{name}: {} MB", most / 1_000_000);
    assert!(took <= Duration::from_secs(1), "{name}: {took:?}");
    given
}

/// A text again and again, as far as a file goes.
fn filled(start: &str, piece: &str, end: &str) -> Vec<u8> {
    let room = MAX_FILE_BYTES - start.len() - end.len();
    [start, &piece.repeat(room / piece.len()), end].concat().into_bytes()
}

// fault 49: 27 files: refused within 1 s of computing and 64 MiB
// One test: what is counted is counted for the whole process.
#[test]
fn hostile_files_cost_little_and_the_largest_plan_fits() {
    const PLAN: &str = "{\"fileType\": \"Plan\", \"version\": 1, \"mission\": {\"version\": 2, \"items\": [";
    let utf16: Vec<u8> = "QGC WPL 110".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let packed = |start: &[u8]| [start, &[0; 4096]].concat();
    let refused: Vec<(&str, Vec<u8>)> = vec![
        ("numbers", filled(PLAN, "1,", "1]}}")),
        ("empty lists", filled(PLAN, "[],", "[]]}}")),
        ("lists of one", filled(PLAN, "[1],", "[]]}}")),
        ("empty objects", filled(PLAN, "{},", "{}]}}")),
        ("objects of one", filled(PLAN, "{\"a\":1},", "{}]}}")),
        (
            "members",
            filled(PLAN, "{\"a\":1,\"b\":1,\"c\":1,\"d\":1,\"e\":1,\"f\":1,\"g\":1,\"h\":1,\"i\":1,\"j\":1},", "{}]}}"),
        ),
        (
            "items",
            filled(PLAN, "{\"type\":\"SimpleItem\",\"command\":16,\"frame\":3,\"params\":[0,0,0,0,1,1,1]},", "{}]}}"),
        ),
        ("one name", filled("{\"", "a", "\":1}")),
        ("one text", filled("{\"fileType\":\"", "a", "\"}")),
        ("escapes", filled("{\"fileType\":\"", "\\u0041", "\"}")),
        ("backslashes", filled("{\"fileType\":\"", "\\\\", "\"}")),
        ("deep lists", filled("{\"a\":", "[", "")),
        ("deep objects", filled("", "{\"a\":", "")),
        ("ten thousand deep", [b"{\"a\":".to_vec(), vec![b'['; 10_000], vec![b']'; 10_000], b"}".to_vec()].concat()),
        ("an open text", filled("{\"", "[", "")),
        ("entities", {
            let entities: String = (1..20).map(|i| format!("<!ENTITY l{i} '&l{0};&l{0};'>", i - 1)).collect();
            format!("<?xml version='1.0'?><!DOCTYPE k [<!ENTITY l0 'x'>{entities}]><kml>&l19;</kml>").into_bytes()
        }),
        (
            "a file of this machine",
            b"<?xml version='1.0'?><!DOCTYPE k [<!ENTITY x SYSTEM 'file:///etc/passwd'>]><kml>&x;</kml>".to_vec(),
        ),
        ("a zip, as KMZ is", packed(b"PK\x03\x04\x14\0")),
        ("gzip", packed(b"\x1f\x8b\x08\0")),
        ("xz", packed(b"\xfd7zXZ\0")),
        ("UTF-16", utf16),
        ("UTF-16 with a mark", b"\xff\xfe{\0}\0".to_vec()),
        ("decimals with a comma", b"QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t40,3332\t-3,7978\t600\t1\n".to_vec()),
        ("rows", filled("QGC WPL 110\n", "0 1 0 16 0 0 0 0 40 -3 600 1\n", "")),
        ("one row", filled("QGC WPL 110\n", "0 ", "")),
        ("too large", vec![b' '; MAX_FILE_BYTES + 1]),
        ("a gigabyte of which all that is read is one byte too much", vec![b'{'; MAX_FILE_BYTES + 1]),
    ];
    let mut seen = 0;
    for (name, bytes) in &refused {
        let plan = within(name, bytes.len(), || read_plan(bytes, Some("a.plan")).map(drop));
        let params = within(name, bytes.len(), || read_params(bytes).map(drop));
        let text = plan.expect_err(name).to_string();
        assert!(text.len() < 500 && !text.contains("root:"), "{name}: {text}");
        assert!(params.is_err(), "{name}");
        seen += 1;
    }
    assert_eq!(seen, 27);
    for (name, bytes) in [
        ("parameters", (0..700_000).map(|i| format!("P{i} 1\n")).collect::<String>().into_bytes()),
        ("parameters with commas", b"AIRSPEED_CRUISE,22,5\n".to_vec()),
    ] {
        let read = within(name, bytes.len(), || read_params(&bytes).map(drop));
        assert!(read.is_err(), "{name}");
    }

    let item = |i: usize| MissionItem::waypoint(40.0 + i as f64 * 1e-7, -3.123_456_7, 100.5);
    let home = Some(Home { lat_deg: 40.333_2, lon_deg: -3.797_8, alt_amsl_m: 600.0 });
    let plan = Plan::from_mission(Mission { home, items: (0..MAX_ITEMS).map(item).collect() });
    let json = write_plan_json(&plan, &PlanSettings::default()).expect("written").into_bytes();
    let read = within("the largest plan", json.len(), || read_plan(&json, None).expect("read").plan);
    assert_eq!(read.mission.items.len(), MAX_ITEMS);
    let text = write_waypoints(&plan).expect("written").into_bytes();
    let read = within("the largest mission", text.len(), || read_plan(&text, None).expect("read").plan);
    assert_eq!(read.mission.items.len(), MAX_ITEMS);
}
