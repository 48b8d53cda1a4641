//! Answers of a MAVFTP server, and plan files read through it.
#![no_main]

use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use vencejo_proto::ftp::FtpPayload;
use vencejo_proto::plan_file::{decode_plan_file, encode_plan_file};
use vencejo_proto::{Address, MonoTime};
use vencejo_vehicle::transfer::{FtpGet, Transfer, TransferConfig};

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    if let Ok((header, items)) = decode_plan_file(data) {
        // Encoding renumbers the items; the contents stay.
        let again = encode_plan_file(header.mission_type as u8, &items);
        assert_eq!(decode_plan_file(&again).expect("what was written is read").1.len(), items.len());
    }
    let (us, plane) = (Address::new(255, 190), Address::new(1, 1));
    let mut now = MonoTime::ZERO;
    let config = TransferConfig::new(plane, us);
    let mut get = FtpGet::new(&config, "@PARAM/param.pck", 1 << 20, now).expect("a path");
    for answer in data.chunks(64) {
        let mut bytes = [0; 251];
        bytes[..answer.len()].copy_from_slice(answer);
        while get.poll_output().is_some() {}
        if let Ok(payload) = FtpPayload::decode(&bytes) {
            assert_eq!(FtpPayload::decode(&payload.encode()).as_ref(), Ok(&payload));
            get.on_message(plane, &payload.to_message(us), now);
        }
        now += Duration::from_millis(u64::from(answer[0]));
        get.on_time(now);
    }
}));
