//! Messages of a client over the WebSocket.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_server::dto::ClientMessage;

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let _ = quick(|| serde_json::from_str::<ClientMessage>(text));
});
