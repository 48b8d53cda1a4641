//! Forwards one link to others until it is stopped, as a router does. Used by the benchmarks.
//!
//! ```text
//! cargo run --release -p vencejo-link --example forward -- \
//!     udpin:127.0.0.1:14550 udpout:127.0.0.1:14601 udpout:127.0.0.1:14602
//! ```
//! Prints `ready` when all links are up, and one line of JSON per link when standard input ends.
#![allow(clippy::print_stdout, reason = "a measuring program")]

use std::error::Error;
use std::sync::Arc;

use tokio::io::AsyncReadExt;
use vencejo_link::{Hub, LinkAddress, LinkOptions, LinkState, SystemClock};
use vencejo_proto::Address;

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn Error>> {
    let addresses: Vec<LinkAddress> = std::env::args().skip(1).map(|text| text.parse()).collect::<Result<_, _>>()?;
    if addresses.len() < 2 {
        return Err("give the link to read first, then those to forward to, as link strings".into());
    }
    let hub = Hub::new(vec![Address::new(255, 190)], Arc::new(SystemClock::new()));
    let mut links = Vec::new();
    for (number, address) in addresses.into_iter().enumerate() {
        let options = if number == 0 { LinkOptions::default() } else { LinkOptions::tee() };
        let mut link = hub.open(address, options)?;
        link.wait_for(LinkState::is_up).await;
        links.push(link);
    }
    println!("ready");
    tokio::io::stdin().read_to_end(&mut Vec::new()).await?;
    for link in links {
        let stats = hub.stats(link.id())?;
        println!(
            "{{\"link\": \"{}\", \"received\": {}, \"lost\": {}, \"copies\": {}, \"sent\": {}, \"dropped\": {}}}",
            link.address(),
            stats.received.frames,
            stats.lost,
            stats.copies,
            stats.sent.frames,
            stats.dropped
        );
        link.close().await;
    }
    Ok(())
}
