//! Files on this machine's disk: whole or not at all, one writer at a time, and never to the last byte.
//!
//! Whatever Vencejo keeps goes through here, so that what a crash, a power cut, a full disk or a second instance can do
//! to a file is decided in one place ([ADR 0010](../../../docs/adr/0010-one-way-to-the-disk.md)).
//!
//! | module | owns |
//! |---|---|
//! | [`whole`] | writing a file as a whole: beside, forced to the disk, renamed, the folder forced too |
//! | [`small`] | reading a key, a certificate or the like up to a limit |
//! | [`lock`] | the right to read, change and write a file, among all processes |
//! | [`space`] | how much of the disk stays free, and who has to stop first |
//!
//! All calls block; whoever has a runtime makes them off its threads.

pub mod lock;
pub mod small;
pub mod space;
pub mod whole;

#[cfg(test)]
mod testing;

pub use lock::Lock;
pub use small::{read_small, read_small_text};
pub use space::{BadFloors, Class, Floors, LowSpace, Space, free_bytes};
pub use whole::{Access, create, install, make_folder, set_aside, sync_folder, try_folder, write};
