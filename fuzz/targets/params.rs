//! ArduPilot's file of packed parameters, sent over MAVFTP, and parameter files of users.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_flight::formats::{ParamDialect, read_params, write_params};
use vencejo_proto::param::{decode_packed_params, encode_packed_params};

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    if let Ok(params) = decode_packed_params(data) {
        let again = decode_packed_params(&encode_packed_params(&params, 80)).expect("what was written is read");
        assert_eq!(params.len(), again.len());
    }
    if let Ok(entries) = read_params(data) {
        let again = read_params(write_params(&entries, ParamDialect::QGroundControl).as_bytes());
        assert_eq!(again.expect("what was written is read").len(), entries.len());
    }
}));
