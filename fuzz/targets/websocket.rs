//! What a client says over the WebSocket.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_server::dto::ClientMessage;
use vencejo_server::strict::Strict;

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    let _ = serde_json::from_slice::<Strict<ClientMessage>>(data);
}));
