//! Certificates at work: who is let in, who may say what, how an aircraft gets in, and what is told to whom it is not
//! so.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use tokio::sync::Notify;
use tokio::time::timeout;
use zenoh::qos::Priority;
use zenoh::sample::SampleKind;

use super::door::{self, Door};
use super::endpoint::Endpoint;
use super::membership::{Membership, join, refusal, renew, standing, try_address};
use super::network::{self, Part, Replies};
use super::organisation::Organisation;
use super::tls::{self, Known};
use super::unix_now;
use crate::authority::Role;
use crate::deed::Nothing;
use crate::error::FleetError;
use crate::key::{Kind, Name, echo_key, key_of, keys_of_all};
use crate::papers::DAY_S;
use crate::papers::certificate::{Ca, Identity, new_key, request};
use crate::papers::roll::Newcomer;
use crate::payload::Order;
use crate::signature::PublicKey;

/// How long a router is waited for here.
const WAIT: Duration = Duration::from_secs(10);

/// A folder that goes.
pub(super) struct Scratch(pub(super) PathBuf);

impl Scratch {
    pub(super) fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("vencejo-fleet-{}-{count}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        Self(folder)
    }

    pub(super) fn organisation(&self, org: &str) -> Organisation {
        let made = Organisation::below(&self.0, name(org));
        made.init(&["127.0.0.1".into()], None, unix_now()).expect("made");
        made
    }

    pub(super) fn board(&self, board: &str) -> PathBuf {
        self.0.join(board).join("aboard.json")
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub(super) fn name(text: &str) -> Name {
    text.parse().expect("a name")
}

pub(super) fn plane(text: &str) -> Newcomer {
    Newcomer::Aircraft(name(text))
}

pub(super) fn endpoint(text: &str) -> Endpoint {
    text.parse().expect("an address")
}

fn authority(organisation: &Organisation) -> Ca {
    Ca::read(&organisation.read("ca.crt").expect("read"), &organisation.read("ca.key").expect("read")).expect("a CA")
}

/// A certificate of an aircraft as of some moment.
fn aircraft(organisation: &Organisation, aircraft: &str, now: u64) -> Identity {
    let (ca, key) = (authority(organisation), new_key().expect("a key"));
    let certificate = ca.for_member(aircraft, &request(&key).expect("made"), now).expect("signed");
    Identity { ca: ca.certificate, certificate, key }
}

fn enter(organisation: &Organisation, who: &str) -> Identity {
    let identity = aircraft(organisation, who, unix_now());
    let entered = organisation.change(|roll| {
        roll.enter(who, &[0; 32], None, unix_now() + DAY_S, unix_now());
        Ok(())
    });
    entered.expect("entered");
    identity
}

async fn router(organisation: &Organisation, listen: &str) -> (zenoh::Session, Endpoint) {
    let at = endpoint(listen).with_port().expect("a port");
    let (identity, access) = (organisation.identity(unix_now()).expect("read"), organisation.access().expect("made"));
    (network::open(Part::Router(&at, &[], Some(&access)), Some(&identity)).await.expect("a router"), at)
}

async fn speaks_for_itself_alone(way: &str) {
    let scratch = Scratch::new();
    let organisation = scratch.organisation("acme");
    let (seven, _) = (enter(&organisation, "plane7"), enter(&organisation, "plane8"));
    let (org, own, other) = (name("acme"), name("plane7"), name("plane8"));
    let (router, at) = router(&organisation, &format!("{way}/127.0.0.1:0")).await;
    let station = organisation.identity(unix_now()).expect("read");
    let station =
        network::open(Part::Client(std::slice::from_ref(&at), WAIT), Some(&station)).await.expect("a station far away");
    let mut heard = Vec::new();
    for session in [&router, &station] {
        let samples = session.declare_subscriber("vencejo/1/acme/**").await.expect("declared");
        let tokens = session.liveliness().declare_subscriber(keys_of_all(&org, Kind::Alive)).history(true);
        heard.push((samples, tokens.await.expect("declared")));
    }
    let echoes = router.declare_queryable(echo_key(&org)).complete(true).await.expect("declared");

    let board = network::open(Part::Client(std::slice::from_ref(&at), WAIT), Some(&seven)).await.expect("an aircraft");
    assert!(network::is_with_station(&board).await);
    assert_eq!(try_address(&at, &seven).await, Ok(()));
    // What it may not say comes first: when what it may has arrived, the other was dropped.
    let spoofed = board.declare_queryable(key_of(&org, &other, Kind::Order)).complete(true).await.expect("declared");
    let spoofed_token = board.liveliness().declare_token(key_of(&org, &other, Kind::Alive)).await.expect("declared");
    let orders = board.declare_queryable(key_of(&org, &own, Kind::Order)).complete(true).await.expect("declared");
    let _token = board.liveliness().declare_token(key_of(&org, &own, Kind::Alive)).await.expect("declared");
    for who in [&other, &own] {
        network::tell(&board, &key_of(&org, who, Kind::State), &Nothing {}, Priority::Data).await;
    }
    for (samples, tokens) in &heard {
        let token = timeout(WAIT, tokens.recv_async()).await.expect("in time").expect("a token");
        assert_eq!((token.kind(), token.key_expr().as_str()), (SampleKind::Put, "vencejo/1/acme/plane7/alive"));
        let sample = timeout(WAIT, samples.recv_async()).await.expect("in time").expect("a sample");
        assert_eq!(sample.key_expr().as_str(), "vencejo/1/acme/plane7/state");
        assert!(tokens.try_recv().is_ok_and(|more| more.is_none()), "no other's");
    }
    let wait = Duration::from_secs(5);
    // That somebody hears all states, it is told.
    let _all = station.declare_subscriber(keys_of_all(&org, Kind::State)).await.expect("declared");
    let voice = board.declare_publisher(key_of(&org, &own, Kind::State)).await.expect("declared");
    let hearers = voice.matching_listener().await.expect("declared");
    if !voice.matching_status().await.expect("known").matching() {
        let status = timeout(wait, hearers.recv_async()).await.expect("told").expect("told");
        assert!(status.matching());
    }
    // Orders reach it by its own name, from the station far away too; nobody is there by the other's.
    let order = key_of(&org, &own, Kind::Order);
    for session in [&router, &station] {
        let (asked, answered) = tokio::join!(network::ask(session, &order, vec![1], wait), async {
            let query = timeout(WAIT, orders.recv_async()).await.expect("in time").expect("an order");
            network::reply(query, order.clone(), vec![vec![2]]);
        });
        let () = answered;
        assert!(matches!(&asked, Replies::Answers(answers) if *answers == [vec![2]]), "{asked:?}");
        let asked = network::ask(session, &key_of(&org, &other, Kind::Order), vec![1], wait).await;
        assert!(matches!(asked, Replies::Nobody), "{asked:?}");
    }
    assert!(spoofed.try_recv().is_ok_and(|query| query.is_none()));
    // Its way to the router it may measure.
    let echo_at = echo_key(&org);
    let (asked, ()) = tokio::join!(network::ask(&board, &echo_at, vec![], wait), async {
        let probe = timeout(WAIT, echoes.recv_async()).await.expect("in time").expect("a probe");
        network::reply(probe, echo_at.clone(), vec![vec![]]);
    });
    assert!(matches!(asked, Replies::Answers(_)), "{asked:?}");
    // Nor does it hear what others say, or where they are.
    drop((spoofed, spoofed_token));
    let listens = board.declare_subscriber("vencejo/1/acme/plane8/**").await.expect("declared");
    let looks = board.liveliness().get(keys_of_all(&org, Kind::Alive)).await.expect("asked");
    let seen: Vec<_> = std::iter::from_fn(|| looks.recv().ok()).filter_map(|reply| reply.into_result().ok()).collect();
    assert!(seen.iter().all(|sample| sample.key_expr().as_str().contains("/plane7/")), "{seen:?}");
    network::tell(&router, "vencejo/1/acme/plane8/state", &Order::default(), Priority::Data).await;
    let (asked, ()) = tokio::join!(network::ask(&router, &order, vec![1], wait), async {
        let query = timeout(WAIT, orders.recv_async()).await.expect("in time").expect("an order");
        network::reply(query, order.clone(), vec![vec![2]]);
    });
    assert!(matches!(asked, Replies::Answers(_)), "what was told before has passed");
    assert!(listens.try_recv().is_ok_and(|sample| sample.is_none()));
    for session in [board, station, router] {
        session.close().await.expect("closed");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_aircraft_speaks_for_itself_alone_over_tls() {
    speaks_for_itself_alone("tls").await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_aircraft_speaks_for_itself_alone_over_quic() {
    speaks_for_itself_alone("quic").await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_ipv6_address_is_dialled_where_this_machine_has_one() {
    if std::net::TcpListener::bind("[::1]:0").is_err() {
        return;
    }
    let scratch = Scratch::new();
    let organisation = Organisation::below(&scratch.0, name("acme"));
    organisation.init(&["::1".into()], None, unix_now()).expect("made");
    let seven = enter(&organisation, "plane7");
    for way in ["tls", "quic"] {
        let (session, at) = router(&organisation, &format!("{way}/[::1]:0")).await;
        assert_eq!(try_address(&at, &seven).await, Ok(()), "{at}");
        let board = network::dial(std::slice::from_ref(&at), Some(&seven)).await.expect("an aircraft");
        assert!(network::is_with_station(&board).await);
        for session in [board, session] {
            session.close().await.expect("closed");
        }
    }
    let (_door, at) = door_at(&organisation, "[::1]:0").await;
    let mut ticket = organisation.enrol(&plane("plane8"), 60, unix_now()).expect("a token");
    assert_eq!(ticket.doors[0], at);
    ticket.doors.truncate(1);
    join(&ticket.text(), &scratch.board("plane8"), None).await.expect("joined");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whoever_has_no_good_certificate_is_not_let_in_and_told_why() {
    let scratch = Scratch::new();
    let (ours, theirs) = (scratch.organisation("acme"), scratch.organisation("other"));
    let good = enter(&ours, "plane7");
    let foreign = Identity { ca: good.ca.clone(), ..aircraft(&theirs, "plane7", unix_now()) };
    let expired = aircraft(&ours, "plane7", unix_now() - 100 * DAY_S);
    let unborn = aircraft(&ours, "plane7", unix_now() + 10 * DAY_S);
    let of_other_fleet = aircraft(&theirs, "plane7", unix_now());
    let mut routers = Vec::new();
    for (way, nobody_there) in [("tls", "is `vencejo serve --fleet` running"), ("quic", "firewall let UDP through")] {
        let (session, at) = router(&ours, &format!("{way}/127.0.0.1:0")).await;
        assert_eq!(try_address(&at, &good).await, Ok(()), "{at}");
        for (router, identity, says) in [
            (&at, &foreign, "another authority: enrol again"),
            (&at, &expired, "our certificate has ended"),
            (&at, &unborn, "not good yet"),
            (&at, &of_other_fleet, "not a ground station of this fleet"),
            (&endpoint(&format!("{way}/127.0.0.1:1")), &good, nobody_there),
        ] {
            let why = refusal(router, Known::Ca(identity.ca.clone()), Some(identity), WAIT).await.expect_err("refused");
            assert!(why.contains(says), "{way}: {why}");
        }
        let why = refusal(&at, Known::Ca(good.ca.clone()), None, WAIT).await.expect_err("refused");
        assert!(why.contains("wants a certificate"), "{way}: {why}");
        routers.push((session, at));
    }
    let at = &routers[0].1;
    // What carries the orders does not let it in either.
    let opened = network::open(Part::Client(std::slice::from_ref(at), Duration::from_millis(300)), Some(&foreign))
        .await
        .map(drop);
    assert!(matches!(opened, Err(FleetError::Network { .. })), "{opened:?}");
    let without = network::open(Part::Client(std::slice::from_ref(at), WAIT), None).await.map(drop);
    assert!(matches!(without, Err(FleetError::NoCertificates(..))));
    let broken = Identity { key: "secret-ish".into(), ..good.clone() };
    let listen = endpoint("tls/127.0.0.1:0").with_port().expect("a port");
    let error =
        network::open(Part::Router(&listen, &[], None), Some(&broken)).await.map(drop).expect_err("no key").to_string();
    assert!(!error.contains("secret-ish") && !error.contains("c2VjcmV0"), "{error}");
    assert!(!error.contains(".rs"), "{error}");
    for (session, _) in routers {
        session.close().await.expect("closed");
    }

    // The name that was dialled is not in the certificate.
    let renamed = scratch.organisation("renamed");
    let key = renamed.read("station.key").expect("read");
    let certificate = authority(&renamed).for_station("_ground", &["ground.local".into()], &key, unix_now());
    let identity =
        Identity { ca: renamed.read("ca.crt").expect("read"), certificate: certificate.expect("signed"), key };
    let renamed = aircraft(&renamed, "plane7", unix_now());
    for way in ["tls", "quic"] {
        let at = endpoint(&format!("{way}/127.0.0.2:0")).with_port().expect("a port");
        let session = network::open(Part::Router(&at, &[], None), Some(&identity)).await.expect("a router");
        let why = try_address(&at, &renamed).await.expect_err("refused");
        assert!(why.contains("not for 127.0.0.2") && why.contains("--host 127.0.0.2"), "{why}");
        session.close().await.expect("closed");
    }

    // A certificate that is good but no station's: an aircraft is no router.
    let key = ours.read("station.key").expect("read");
    let certificate = authority(&ours).for_station("plane9", &["127.0.0.1".into()], &key, unix_now()).expect("signed");
    let impostor = Identity { ca: good.ca.clone(), certificate, key };
    let at = endpoint("tls/127.0.0.1:0").with_port().expect("a port");
    let session = network::open(Part::Router(&at, &[], None), Some(&impostor)).await.expect("a router");
    let error =
        network::open(Part::Client(std::slice::from_ref(&at), WAIT), Some(&good)).await.map(drop).expect_err("refused");
    assert!(error.to_string().contains("not that of a ground station or router"), "{error}");
    session.close().await.expect("closed");
}

/// As a ground station's router when somebody was enrolled or revoked: it ends its sessions, and is there again.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_router_that_hangs_up_because_it_starts_again_is_tried_again() {
    let scratch = Scratch::new();
    let organisation = scratch.organisation("acme");
    let seven = enter(&organisation, "plane7");
    let identity = organisation.identity(unix_now()).expect("read");
    let mut config = rustls::ServerConfig::clone(&tls::server(&identity).expect("usable"));
    config.alpn_protocols = vec![b"zenoh".to_vec()];
    let config = quinn::crypto::rustls::QuicServerConfig::try_from(config).expect("usable");
    let config = quinn::ServerConfig::with_crypto(Arc::new(config));
    let router = quinn::Endpoint::server(config, ([127, 0, 0, 1], 0).into()).expect("a port");
    let at = endpoint(&format!("quic/{}", router.local_addr().expect("bound")));
    let mut serving = tokio::spawn(async move {
        let incoming = || async { router.accept().await.expect("open") };
        // The first is given up in the handshake, the second after it.
        drop(incoming().await.accept().expect("whole"));
        drop(incoming().await.await.expect("a handshake"));
        incoming().await.await.expect("a handshake").closed().await
    });
    // A client that was not told in time that it was given up does not try again: another does.
    let served = async {
        loop {
            tokio::select! {
                ended = &mut serving => return ended.expect("it was tried three times"),
                tried = try_address(&at, &seven) => assert_eq!(tried, Ok(())),
            }
        }
    };
    timeout(3 * WAIT, served).await.expect("in time");
}

async fn door_of(organisation: &Organisation) -> (Door, String) {
    door_at(organisation, "127.0.0.1:0").await
}

async fn door_at(organisation: &Organisation, address: &str) -> (Door, String) {
    let (listener, at) = door::listen(address).await.expect("a port");
    let (doors, operator) = (vec![at.to_string()], Some("07".repeat(32)));
    let noted = organisation.change(|roll| {
        (roll.routers, roll.doors, roll.operator) = (vec!["tls/127.0.0.1:7447".into()], doors, operator);
        Ok(())
    });
    noted.expect("noted");
    (Door::open(listener, organisation.clone(), Arc::new(Notify::new())), at.to_string())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_token_brings_in_one_aircraft_which_keeps_its_certificate_new() {
    let scratch = Scratch::new();
    let organisation = scratch.organisation("acme");
    let (door, at) = door_of(&organisation).await;
    let token = |lasts_s| {
        let mut ticket = organisation.enrol(&plane("plane7"), lasts_s, unix_now()).expect("a token");
        ticket.doors = vec!["127.0.0.1:1".into(), at.clone()];
        ticket
    };
    let error = join(&token(0).text(), &scratch.board("late"), None).await.expect_err("refused").to_string();
    assert!(error.contains("expired") && error.contains("vencejo fleet enrol plane7"), "{error}");

    let ticket = token(60);
    let (member, is_new) = join(&ticket.text(), &scratch.board("plane"), None).await.expect("joined");
    assert!(is_new && member.org() == Ok(name("acme")) && member.name() == Ok(name("plane7")));
    assert_eq!(Membership::read(&scratch.board("plane")), Ok(Some(member.clone())));
    assert!(!scratch.board("plane").with_extension("joining").exists(), "the key is in the one file");
    assert_eq!(organisation.roll().expect("read").admitted(false).collect::<Vec<_>>(), ["plane7"]);
    #[cfg(unix)]
    for path in [scratch.board("plane"), organisation.path("ca.key"), organisation.path("roll.json")] {
        use std::os::unix::fs::PermissionsExt;
        assert_eq!(std::fs::metadata(&path).expect("a file").permissions().mode() & 0o777, 0o600, "{path:?}");
    }
    // The same command again changes nothing; another computer gets nothing.
    assert_eq!(join(&ticket.text(), &scratch.board("plane"), None).await, Ok((member.clone(), false)));
    let error = join(&ticket.text(), &scratch.board("thief"), None).await.expect_err("refused").to_string();
    assert!(error.contains("has been used") && error.contains("vencejo fleet revoke plane7"), "{error}");
    assert!(!scratch.board("thief").exists());

    assert_eq!(standing(&member).await, Ok(()));
    assert_eq!(Membership::read(&scratch.board("plane")), Ok(Some(member.clone())), "to ask changes nothing");
    let renewed = renew(&member, &scratch.board("plane")).await.expect("renewed");
    assert_ne!(renewed.identity().key, member.identity().key);
    assert_eq!(Membership::read(&scratch.board("plane")), Ok(Some(renewed.clone())));
    // It joined another fleet while a program runs on with what was before: that is not put back.
    let other = scratch.organisation("other");
    let (_other_door, other_at) = door_of(&other).await;
    let mut elsewhere = other.enrol(&plane("plane7"), 60, unix_now()).expect("a token");
    elsewhere.doors = vec![other_at];
    let (anew, _) = join(&elsewhere.text(), &scratch.board("anew"), None).await.expect("joined");
    let error = renew(&renewed, &scratch.board("anew")).await.expect_err("refused").to_string();
    assert!(error.contains("joined anew since"), "{error}");
    assert_eq!(Membership::read(&scratch.board("anew")), Ok(Some(anew)));
    // It was enrolled again, on another computer: this one gets nothing more.
    let (again, _) = join(&token(60).text(), &scratch.board("again"), None).await.expect("joined");
    let error = renew(&renewed, &scratch.board("plane")).await.expect_err("refused").to_string();
    assert!(error.contains("enrolled again since"), "{error}");
    let renewed = again;
    organisation.change(|roll| roll.revoke("plane7", unix_now())).expect("revoked");
    let error = renew(&renewed, &scratch.board("plane")).await.expect_err("refused").to_string();
    assert!(error.contains("was revoked"), "{error}");

    assert!(standing(&renewed).await.is_err_and(|why| why.contains("plane7 was revoked")));

    // Whoever guesses has to wait, at the latest now.
    let mut wrong = ticket;
    wrong.secret = vec![0; 16];
    let mut said = Vec::new();
    for _ in 0..11 {
        said.push(join(&wrong.text(), &scratch.board("eve"), None).await.expect_err("refused").to_string());
    }
    assert!(said[0].contains("does not know this token"), "{}", said[0]);
    assert!(said[10].contains("wait a minute"), "{}", said[10]);
    drop(door);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_ground_station_joins_and_the_newest_list_is_kept_whoever_brings_it() {
    let scratch = Scratch::new();
    let organisation = scratch.organisation("acme");
    let (_door, at) = door_of(&organisation).await;
    let token = |newcomer: &Newcomer| {
        let mut ticket = organisation.enrol(newcomer, 60, unix_now()).expect("a token");
        ticket.doors = vec![at.clone()];
        ticket.text()
    };
    let (mut seven, _) = join(&token(&plane("plane7")), &scratch.board("plane"), None).await.expect("joined");
    assert_eq!((seven.is_station(), seven.role()), (false, Ok(None)));
    let before = seven.signed_stations().expect("read");

    let key = PublicKey([1; 32]);
    let tower = token(&Newcomer::Station(name("tower"), Role::Chief, vec![]));
    let error = join(&tower, &scratch.board("tower"), None).await.expect_err("refused").to_string();
    assert!(error.contains("for a ground station: vencejo serve --join"), "{error}");
    let (member, is_new) = join(&tower, &scratch.board("tower"), Some(key)).await.expect("joined");
    assert!(is_new && member.is_station() && member.name() == Ok(name("tower")));
    assert_eq!(member.role(), Ok(Some(Role::Chief)));
    assert_eq!(standing(&member).await, Ok(()));
    assert_eq!(renew(&member, &scratch.board("tower")).await.expect("renewed").role(), Ok(Some(Role::Chief)));
    let access = organisation.access().expect("made");
    assert_eq!(access["subjects"][0]["cert_common_names"], serde_json::json!(["_ground", "_tower"]));
    let error = join(&token(&plane("plane8")), &scratch.board("plane8"), Some(key)).await.expect_err("refused");
    assert!(error.to_string().contains("for an aircraft"), "{error}");
    // One key is one ground station's.
    let second = token(&Newcomer::Station(name("second"), Role::Operator, vec![]));
    let error = join(&second, &scratch.board("second"), Some(key)).await.expect_err("refused").to_string();
    assert!(error.contains("another ground station's"), "{error}");

    // The list comes to an aircraft by anybody, and an older one does not take its place.
    let file = scratch.board("plane");
    let newer = organisation.stations().expect("signed");
    assert_eq!(seven.roles().expect("read").get(&key), None);
    assert_eq!((seven.take(&newer), seven.take(&newer), seven.take(&before)), (Ok(true), Ok(false), Ok(false)));
    assert_eq!(seven.roles().expect("read").get(&key), Some(&Role::Chief));
    Membership::keep_stations(&file, &newer).expect("kept");
    Membership::keep_stations(&file, &before).expect("not kept");
    assert_eq!(Membership::read(&file), Ok(Some(seven.clone())));
    organisation.change(|roll| roll.revoke("_tower", unix_now())).expect("revoked");
    assert_eq!(seven.take(&organisation.stations().expect("signed")), Ok(true));
    assert_eq!(seven.roles().expect("read").get(&key), None);
    assert!(standing(&member).await.is_err_and(|why| why.contains("tower was revoked")));
    // Nor does another fleet's, or a place that is not of this token.
    let other = scratch.organisation("other").stations().expect("signed");
    assert!(matches!(seven.take(&other), Err(FleetError::Refused(_))));
    assert!(matches!(Membership::keep_stations(&file, &other), Err(FleetError::Refused(_))));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn somebody_in_the_middle_is_told_nothing() {
    let scratch = Scratch::new();
    let (ours, theirs) = (scratch.organisation("acme"), scratch.organisation("other"));
    let (door, at) = door_of(&theirs).await;
    let mut ticket = ours.enrol(&plane("plane7"), 60, unix_now()).expect("a token");
    ticket.doors = vec![at];
    let error = join(&ticket.text(), &scratch.board("plane"), None).await.expect_err("refused").to_string();
    assert!(error.contains("somebody else answers") && error.contains("Nothing was told"), "{error}");
    assert_eq!(ours.roll().expect("read").open_tokens(unix_now()).count(), 1, "the token is good still");
    assert!(!scratch.board("plane").exists());
    drop(door);
}

#[test]
fn a_second_init_changes_nothing_but_what_it_is_asked_for() {
    let scratch = Scratch::new();
    let organisation = Organisation::below(&scratch.0, name("acme"));
    let hosts = ["192.168.1.2".to_owned()];
    let made = organisation.init(&hosts, None, unix_now()).expect("made");
    assert!(made.authority && made.hosts.contains(&"localhost".to_owned()));
    let files = || {
        ["ca.crt", "ca.key", "station.crt", "station.key", "roll.json"]
            .map(|file| organisation.read(file).expect("read"))
    };
    let before = files();
    let again = organisation.init(&hosts, None, unix_now()).expect("there");
    assert!(!again.authority && again.hosts.is_empty() && files() == before);
    let added = organisation.init(&["ground.local".to_owned()], None, unix_now()).expect("added");
    assert_eq!(added.hosts, ["ground.local"]);
    assert_eq!(organisation.facts().expect("read").1.names.last().map(String::as_str), Some("ground.local"));
    assert_eq!(files()[1], before[1], "the authority stays");
    // Another authority is not put in its place; a given one is taken where there is none.
    let given = Ca::make(&name("bank"), unix_now()).expect("made");
    let error = organisation.init(&[], Some(given.clone()), unix_now()).expect_err("there is one").to_string();
    assert!(error.contains("another authority"), "{error}");
    let other = Organisation::below(&scratch.0, name("bank"));
    other.init(&hosts, Some(given.clone()), unix_now()).expect("made");
    assert_eq!(other.read("ca.crt"), Ok(given.0));
    for bad in ["", "a b", "*", "ground.local:7447", "a;b"] {
        assert!(matches!(other.init(&[bad.to_owned()], None, unix_now()), Err(FleetError::Host(_))), "{bad}");
    }
    // The ground station's own certificate is renewed when it is due, by the one who has the authority.
    let old = other.identity(unix_now()).expect("read");
    assert_eq!(other.identity(unix_now() + 59 * DAY_S).expect("read"), old);
    let ahead = other.identity(unix_now() + 61 * DAY_S).expect("renewed").certificate;
    assert_ne!(ahead, old.certificate);
    // So it is when the clock was wrong then.
    assert_ne!(other.identity(unix_now()).expect("renewed").certificate, ahead);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_router_of_zenoh_reads_the_settings_that_are_printed() {
    let scratch = Scratch::new();
    let organisation = scratch.organisation("acme");
    let seven = enter(&organisation, "plane7");
    let at = endpoint("tls/127.0.0.1:0").with_port().expect("a port");
    let mut settings = organisation.router_config().expect("made");
    settings["listen"]["endpoints"][0] = at.to_string().into();
    let file = scratch.0.join("zenohd.json5");
    vencejo_store::write(&file, settings.to_string().as_bytes(), vencejo_store::Access::Usual).expect("written");
    let router = zenoh::open(zenoh::Config::from_file(&file).expect("read")).await.expect("a router");
    let heard = router.declare_subscriber("vencejo/1/acme/**").await.expect("declared");
    let board = network::open(Part::Client(std::slice::from_ref(&at), WAIT), Some(&seven)).await.expect("an aircraft");
    for who in ["plane8", "plane7"] {
        network::tell(&board, &key_of(&name("acme"), &name(who), Kind::State), &Nothing {}, Priority::Data).await;
    }
    let sample = timeout(WAIT, heard.recv_async()).await.expect("in time").expect("a sample");
    assert_eq!(sample.key_expr().as_str(), "vencejo/1/acme/plane7/state");
    for session in [board, router] {
        session.close().await.expect("closed");
    }
}
