//! Capabilities documents of map services.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_maps::kinds::wms;
use vencejo_maps::kinds::wmts::service as wmts;
use vencejo_maps::xml::Element;

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    let _ = Element::parse(data);
    let _ = wms::read_capabilities(data);
    let _ = wmts::read_capabilities(data);
}));
