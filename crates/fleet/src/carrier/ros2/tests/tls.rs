//! Routers of ROS 2 over TLS: who lets us in and is believed, and what is said of each other one.

use std::path::{Path, PathBuf};

use zenoh::Session;

use crate::carrier::endpoint::Endpoint;
use crate::carrier::network::{self, Papers, Part};
use crate::carrier::ros2::router::open;
use crate::carrier::ros2::{RosPapers, RosRouter};
use crate::carrier::unix_now;
use crate::error::FleetError;
use crate::papers::DAY_S;
use crate::papers::certificate::{Ca, Identity, new_key, request};

/// An authority with its files, in a folder that goes.
struct Authority(Ca, PathBuf);

impl Authority {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("vencejo-ros2-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let (certificate, key) = Ca::make(&name.parse().expect("a name"), unix_now()).expect("made");
        std::fs::write(folder.join("ca.crt"), &certificate).expect("written");
        Self(Ca::read(&certificate, &key).expect("read"), folder)
    }

    fn router(&self, host: &str, now: u64) -> Identity {
        let key = new_key().expect("a key");
        let certificate = self.0.for_station("robot", &[host.to_owned()], &key, now).expect("signed");
        Identity { ca: self.0.certificate.clone(), certificate, key }
    }

    /// A certificate to show, and its key.
    fn ours(&self, name: &str, now: u64) -> RosPapers {
        let key = new_key().expect("a key");
        let certificate = self.0.for_member(name, &request(&key).expect("made"), now).expect("signed");
        let file = |kind: &str, text: &str| {
            let file = self.1.join(format!("{name}.{kind}"));
            std::fs::write(&file, text).expect("written");
            Some(file)
        };
        RosPapers { certificate: file("crt", &certificate), key: file("key", &key), ..self.believed() }
    }

    fn believed(&self) -> RosPapers {
        RosPapers { ca: Some(self.1.join("ca.crt")), ..RosPapers::default() }
    }
}

impl Drop for Authority {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.1);
    }
}

/// A router that wants certificates, at a free port.
async fn router(listen: &str, identity: &Identity) -> (Session, Endpoint) {
    let at = listen.parse::<Endpoint>().and_then(Endpoint::with_port).expect("a port");
    let papers = Papers { ca: &identity.ca, own: Some(identity) };
    (network::join(Part::Router(&at, &[], None), Some(papers)).await.expect("a router"), at)
}

async fn why(address: &str, papers: &RosPapers) -> (&'static str, String) {
    let router = RosRouter::new(address, papers).expect("files");
    match open(&router).await {
        Err(FleetError::RosUnreached { code, problem, .. }) => (code, problem),
        other => panic!("{address}: {:?}", other.map(drop)),
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_router_over_tls_lets_in_whom_it_knows_and_what_keeps_others_out_is_told() {
    let (robot, other, now) = (Authority::new("robot"), Authority::new("other"), unix_now());
    let good = robot.ours("ground", now);
    let (session, at) = router("tls/127.0.0.1:0", &robot.router("127.0.0.1", now)).await;
    let (old, ended) = router("tls/127.0.0.1:0", &robot.router("127.0.0.1", now - 100 * DAY_S)).await;
    let (named, elsewhere) = router("tls/127.0.0.1:0", &robot.router("robot.local", now)).await;
    let plain: Endpoint = "tcp/127.0.0.1:0".parse::<Endpoint>().and_then(Endpoint::with_port).expect("a port");
    let clear = network::join(Part::Router(&plain, &[], None), None).await.expect("a router");
    let (at, plain) = (at.to_string(), plain.to_string());

    let entered = open(&RosRouter::new(&at, &good).expect("files")).await.expect("let in");
    assert_eq!(entered.info().routers_zid().await.next(), Some(session.zid()));
    entered.close().await.expect("closed");

    let mixed = |ours: RosPapers| RosPapers { ca: good.ca.clone(), ..ours };
    let in_tls = plain.replace("tcp/", "tls/");
    let nothing = RosPapers::default();
    for (address, papers, code, says) in [
        (at.as_str(), &other.believed(), "other-authority", "--ros2-ca"),
        (&elsewhere.to_string(), &good, "other-name", "not for 127.0.0.1: dial it"),
        (&ended.to_string(), &good, "certificate-ended", "its certificate has ended"),
        (&at, &robot.believed(), "certificate-wanted", "--ros2-cert and --ros2-key"),
        (&at, &mixed(other.ours("stranger", now)), "certificate-refused", "give another with --ros2-cert"),
        (&at, &robot.ours("late", now - 100 * DAY_S), "own-certificate-ended", "the clock here says"),
        (&at.replace("tls/", "tcp/"), &nothing, "tls-spoken", "use tls/ in place of tcp/"),
        (&in_tls, &good, "tls-missing", "it speaks in the clear"),
        ("tls/127.0.0.1:1", &good, "no-router", "rmw_zenohd"),
        ("tls/nobody.invalid:7447", &good, "no-router", "no address is known here"),
    ] {
        let (found, problem) = why(address, papers).await;
        assert!(found == code && problem.contains(says), "{code}: {found}: {problem}");
    }
    for session in [session, old, named, clear] {
        session.close().await.expect("closed");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_router_over_quic_is_known_as_well() {
    let (robot, other, now) = (Authority::new("quic-robot"), Authority::new("quic-other"), unix_now());
    let (session, at) = router("quic/127.0.0.1:0", &robot.router("127.0.0.1", now)).await;
    let entered = open(&RosRouter::new(&at.to_string(), &robot.ours("ground", now)).expect("files")).await;
    entered.expect("let in").close().await.expect("closed");
    let stranger = RosPapers { ca: robot.believed().ca, ..other.ours("stranger", now) };
    for (papers, code, says) in [
        (other.believed(), "other-authority", "--ros2-ca"),
        (robot.believed(), "certificate-wanted", "--ros2-cert and --ros2-key"),
        (stranger, "certificate-refused", "give another with --ros2-cert"),
    ] {
        let (found, problem) = why(&at.to_string(), &papers).await;
        assert!(found == code && problem.contains(says), "{code}: {found}: {problem}");
    }
    session.close().await.expect("closed");
}

#[test]
fn certificates_that_cannot_be_used_are_told_before_anything_starts() {
    let (robot, now) = (Authority::new("files"), unix_now());
    let (one, two) = (robot.ours("one", now), robot.ours("two", now));
    let file = |name: &str| Some(robot.1.join(name));
    std::fs::write(robot.1.join("empty.crt"), "").expect("written");
    let with = |change: &dyn Fn(&mut RosPapers)| {
        let mut papers = one.clone();
        change(&mut papers);
        papers
    };
    let (at, nothing) = ("tls/robot.local:7447", RosPapers::default());
    for (address, papers, says) in [
        ("tls/127.0.0.1", &one, "not the address of a ROS 2 router"),
        ("tcp/0.0.0.0:7447", &nothing, "not the address of a ROS 2 router"),
        ("127.0.0.1:7447", &nothing, "not the address of a ROS 2 router"),
        ("tcp/a#b:1", &nothing, "not the address of a ROS 2 router"),
        ("tcp/a:0", &nothing, "not the address of a ROS 2 router"),
        ("udp/127.0.0.1:7447", &nothing, "not the address of a ROS 2 router"),
        ("tcp/robot.local:7447", &nothing, "or --ros2-plain"),
        ("tcp/192.168.1.2:7447", &nothing, "or --ros2-plain"),
        ("tcp/127.0.0.1:7447", &one, "certificates are for tls/ and quic/"),
        (at, &nothing, "give its file with --ros2-ca"),
        (at, &with(&|papers| papers.key = None), "give its file with --ros2-key"),
        (at, &with(&|papers| papers.certificate = None), "give its file with --ros2-cert"),
        (at, &with(&|papers| papers.ca = file("none.crt")), "none.crt: it cannot be read"),
        (at, &with(&|papers| papers.ca = file("empty.crt")), "empty.crt: there is no certificate in it"),
        (at, &with(&|papers| papers.ca = file("one.key")), "one.key: there is no certificate in it"),
        (at, &with(&|papers| papers.certificate = file("one.key")), "one.key: there is no certificate in it"),
        (at, &with(&|papers| papers.key = file("one.crt")), "one.crt: there is no private key in it"),
        (at, &with(&|papers| papers.key.clone_from(&two.key)), "two.key: it is not the key of"),
        (at, &with(&|papers| papers.key = Some(Path::new("/").into())), "/: it cannot be read"),
    ] {
        let error = RosRouter::new(address, papers).map(drop).expect_err(says).to_string();
        assert!(error.contains(says), "{says}: {error}");
    }
    for (address, papers) in [
        (at, &one),
        ("quic/[2001:db8::2]:7447", &robot.believed()),
        ("tcp/localhost:7447", &nothing),
        ("tcp/192.168.1.2:7447", &RosPapers { is_plain_meant: true, ..nothing.clone() }),
    ] {
        assert_eq!(RosRouter::new(address, papers).map(|router| router.to_string()), Ok(address.to_owned()));
    }
}
