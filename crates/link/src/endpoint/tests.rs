//! Tests of the endpoints over real sockets and pseudo-terminals.

use super::*;
use crate::testing::{Listening, in_time};

// fault 13: tries again after at most 1.5 s, for ever
#[test]
fn the_wait_doubles_and_is_bounded() {
    let longest: Vec<_> = (1..=8).map(|attempt| backoff(attempt, 1.0).as_millis()).collect();
    assert_eq!(longest, [250, 500, 1000, 1500, 1500, 1500, 1500, 1500]);
    let shortest: Vec<_> = (1..=8).map(|attempt| backoff(attempt, 0.0).as_millis()).collect();
    assert_eq!(shortest, [250, 250, 500, 750, 750, 750, 750, 750]);
    assert_eq!(backoff(u32::MAX, 1.0), LONGEST_WAIT);
    let draws: Vec<f64> = (0..100).map(|_| chance()).collect();
    assert!(draws.iter().all(|draw| (0.0..=1.0).contains(draw)));
    assert!(draws.windows(2).any(|pair| pair[0] != pair[1]));
}

#[tokio::test]
async fn a_name_is_looked_up_to_all_its_addresses_ipv4_first() {
    let at = |host: &str, port| HostPort { host: host.to_owned(), port };
    let found = resolve(&at("localhost", 9)).await.expect("localhost is somewhere");
    assert!(found.is_sorted_by_key(std::net::SocketAddr::is_ipv6), "{found:?}");
    let at_number = resolve(&at("::1", 9)).await.expect("a number needs nobody");
    assert_eq!(at_number, ["[::1]:9".parse().unwrap()]);
}

#[tokio::test]
async fn closing_ends_a_link_that_never_came_up() {
    let listening = Listening::new();
    let mut link = listening.hub.open("tcp:127.0.0.1:1".parse().unwrap(), LinkOptions::default()).unwrap();
    let state =
        in_time(link.wait_for(|state| matches!(state, LinkState::Connecting { last_error: Some(_), .. }))).await;
    let LinkState::Connecting { attempt, last_error: Some(error) } = state else { panic!("{state:?}") };
    assert_eq!(attempt, 2);
    assert!(error.detail.contains("cannot connect to 127.0.0.1:1"), "{error}");
    let mut watch = link.watch();
    in_time(link.close()).await;
    assert_eq!(*watch.borrow_and_update(), LinkState::Down);
    assert!(listening.hub.links().is_empty());
}

#[tokio::test]
async fn dropping_the_handle_closes_the_link() {
    let listening = Listening::new();
    let link = listening.open("udpin:127.0.0.1:0").await;
    let mut watch = link.watch();
    drop(link);
    in_time(watch.wait_for(|state| *state == LinkState::Down)).await.unwrap();
    assert!(listening.hub.links().is_empty());
}

#[tokio::test]
async fn what_cannot_be_bound_says_what_to_do() {
    let listening = Listening::new();
    let first = listening.open("udpin:127.0.0.1:0").await;
    let taken = first.local_address().unwrap();
    for (text, kind, expected) in [
        (format!("udpin:{taken}"), FaultKind::AddressInUse, "another program listens there"),
        ("udp:192.0.2.1:14550".to_owned(), FaultKind::NotOurAddress, "to send there write `udpout:`"),
        ("tcpin:192.0.2.1:5760".to_owned(), FaultKind::NotOurAddress, "does not have that address"),
        ("tcp:nowhere.invalid:5760".to_owned(), FaultKind::NoHost, "cannot find nowhere.invalid"),
        ("/dev/vencejo-no-such-port".to_owned(), FaultKind::NoSerialPort, "is it plugged in?"),
    ] {
        let mut link = listening.hub.open(text.parse().unwrap(), LinkOptions::default()).unwrap();
        let state =
            in_time(link.wait_for(|state| matches!(state, LinkState::Connecting { last_error: Some(_), .. }))).await;
        let LinkState::Connecting { last_error: Some(error), .. } = state else { panic!("{state:?}") };
        assert_eq!(error.kind, kind, "{text}: {error}");
        assert!(error.detail.contains(expected), "{text}: {error}");
        link.close().await;
    }
}

#[tokio::test]
async fn links_are_listed_and_places_are_used_again() {
    let listening = Listening::new();
    let mut open = Vec::new();
    for _ in 0..crate::MAX_LINKS {
        open.push(listening.hub.open("udpin:127.0.0.1:0".parse().unwrap(), LinkOptions::default()).unwrap());
    }
    let refused = listening.hub.open("udpin:127.0.0.1:0".parse().unwrap(), LinkOptions::default());
    assert_eq!(refused.err(), Some(LinkError::TooManyLinks));
    let gone = open.remove(3);
    let id = gone.id();
    gone.close().await;
    let options = LinkOptions { name: Some("again".to_owned()), forwards: true, ..LinkOptions::default() };
    let again = listening.hub.open("udpin:127.0.0.1:0".parse().unwrap(), options).unwrap();
    assert_ne!(again.id(), id, "ids are not used again");
    let links = listening.hub.links();
    assert_eq!(links.len(), crate::MAX_LINKS);
    let last = links.last().unwrap();
    assert_eq!((last.id, last.name.as_str(), last.forwards), (again.id(), "again", true));
    assert_eq!(listening.hub.stats(id), Err(LinkError::UnknownLink(id)));
}
