//! What an own router is measured beside: one of Zenoh with nothing else in its process, and with Zenoh's own settings
//! but for how many sessions it takes, which are 1,000 otherwise. With an ORG it subscribes to that organisation's
//! states and events too, and drops them: the least that a ground station can do which is the router.
//!
//! `bare_router tcp/127.0.0.1:PORT [ORG]`. Prints one line once it listens; ends with its standard input.

#![allow(clippy::print_stdout, reason = "a measuring program")]

use std::error::Error;
use std::io::Read;

use vencejo_fleet::key::{Kind, Name, keys_of_all};
use zenoh::Wait;

const MAX_SESSIONS: &str = "10000";

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<_> = std::env::args().skip(1).collect();
    let (listen, org): (_, Option<Name>) = match args.as_slice() {
        [listen] => (listen, None),
        [listen, org] => (listen, Some(org.parse()?)),
        _ => return Err("bare_router tcp/127.0.0.1:PORT [ORG]".into()),
    };
    let mut config = zenoh::Config::default();
    let endpoints = format!("[\"{listen}\"]");
    for (key, value) in [
        ("mode", "\"router\""),
        ("listen/endpoints", endpoints.as_str()),
        ("scouting/multicast/enabled", "false"),
        ("transport/unicast/max_sessions", MAX_SESSIONS),
        ("transport/unicast/accept_pending", MAX_SESSIONS),
    ] {
        config.insert_json5(key, value).map_err(|error| error.to_string())?;
    }
    let words = |error: zenoh::Error| error.to_string();
    let session = zenoh::open(config).wait().map_err(words)?;
    if let Some(org) = &org {
        for kind in [Kind::State, Kind::Event] {
            let all = session.declare_subscriber(keys_of_all(org, kind));
            all.callback(drop).background().wait().map_err(words)?;
        }
    }
    println!("{{\"endpoint\": \"{listen}\"}}");
    // Whatever ends it, it is the end.
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
    std::process::exit(0)
}
