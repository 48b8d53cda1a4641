//! Bodies of HTTP requests: none is interpreted as something that it does not contain.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_server::dto;
use vencejo_server::strict;

mod quick;
use quick::quick;

macro_rules! read {
    ($data:expr; $($body:ty)*) => {
        $(match strict::read::<$body>($data) {
            Ok(_) => assert!($data.trim_ascii_start().starts_with('{'), concat!(stringify!($body), " of no object")),
            Err(reason) => assert!(!reason.is_empty()),
        })*
    };
}

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    quick(|| {
        read!(text; dto::Plan dto::NewSession dto::NewLink dto::ChangeSigning dto::RehearsalRequest dto::WhatIfRequest dto::SpreadRequest);
    });
});
