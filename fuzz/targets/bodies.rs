//! Bodies of HTTP requests: none is taken for something that it does not say.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_server::dto;
use vencejo_server::strict::Strict;

mod quick;
use quick::quick;

macro_rules! read {
    ($data:expr; $($body:ty)*) => {
        $(if serde_json::from_slice::<Strict<$body>>($data).is_ok() {
            assert_eq!($data.trim_ascii_start().first(), Some(&b'{'), concat!(stringify!($body), " of no object"));
        })*
    };
}

fuzz_target!(|data: &[u8]| quick(|| {
    read!(data; dto::Plan dto::Goto dto::MissionStart dto::SetMode dto::Takeoff dto::NewSession dto::NewLink dto::ChangeSigning);
}));
