//! Files of a vehicle over MAVFTP.
//! (sketch: signatures only, bodies follow)
// FtpGet::new(config: &TransferConfig, path: &str, max_len: usize, now)   Value = Vec<u8>
