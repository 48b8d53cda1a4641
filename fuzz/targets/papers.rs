//! Enrolment of aircraft: tokens copied by people, requests, answers, certificates, and the stored roll.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use prost::Message;
use vencejo_fleet::papers::certificate::{Ca, facts, facts_of_der};
use vencejo_fleet::papers::roll::{Newcomer, Roll};
use vencejo_fleet::papers::ticket::Ticket;
use vencejo_fleet::papers::wire::{Asked, Given};

mod quick;
use quick::quick;

/// A time in 2027.
const NOW: u64 = 1_800_000_000;

static CA: LazyLock<Ca> = LazyLock::new(|| {
    let (certificate, key) = Ca::make(&"acme".parse().expect("a name"), NOW).expect("an authority");
    Ca::read(&certificate, &key).expect("it can be read")
});

fuzz_target!(|data: &[u8]| {
    LazyLock::force(&CA);
    quick(|| read(data));
});

fn read(data: &[u8]) {
    let Some((&kind, bytes)) = data.split_first() else { return };
    match kind % 6 {
        0 => drop(std::str::from_utf8(bytes).map(str::parse::<Ticket>)),
        1 => {
            // With a valid checksum.
            if let Ok(ticket) = Ticket::decode(bytes)
                && let Ok(read) = ticket.text().parse::<Ticket>()
            {
                assert_eq!(read, ticket);
            }
        }
        2 => {
            if let Ok(asked) = Asked::decode(bytes) {
                signed(&asked.request);
            }
        }
        3 => {
            if let Ok(given) = Given::decode(bytes).map_err(drop).and_then(|given| given.checked().map_err(drop)) {
                drop((facts(&given.certificate), facts(&given.ca)));
            }
        }
        4 => {
            drop(facts_of_der(bytes));
            signed(bytes);
        }
        _ => {
            let Ok(mut roll) = Roll::read(bytes) else { return };
            assert_eq!(Roll::read(&roll.bytes()).as_ref(), Ok(&roll), "what is written is read");
            let plane = Newcomer::Aircraft("plane7".parse().expect("a name"));
            drop((roll.renew("plane7", &[1; 32]), roll.redeem(b"secret", &[1; 32], NOW)));
            drop((roll.promise(&plane, &Ticket::default(), 3_600, NOW), roll.revoke("plane7", NOW)));
            assert!(roll.admitted(false).all(|admitted| admitted != "plane7"), "whoever was put out is out");
        }
    }
}

/// A signed request has the given name, whatever the request contains.
fn signed(request: &[u8]) {
    if let Ok(certificate) = CA.for_member("plane7", request, NOW) {
        let facts = facts(&certificate).expect("it was made here");
        assert_eq!((facts.common_name.as_str(), facts.is_ca, facts.names.len()), ("plane7", false, 0));
    }
}
