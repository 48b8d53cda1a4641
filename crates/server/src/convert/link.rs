//! Links, and signing on them.

use vencejo_link::{self as link, LinkStats};
use vencejo_station::{FarNetwork, Station, VehicleHandle};

use crate::dto;

fn link_fault(kind: link::FaultKind) -> dto::LinkFault {
    match kind {
        link::FaultKind::AddressInUse => dto::LinkFault::AddressInUse,
        link::FaultKind::NotOurAddress => dto::LinkFault::NotOurAddress,
        link::FaultKind::NoPermission => dto::LinkFault::NoPermission,
        link::FaultKind::NoSerialPermission => dto::LinkFault::NoSerialPermission,
        link::FaultKind::NoSerialPort => dto::LinkFault::NoSerialPort,
        link::FaultKind::SerialPortInUse => dto::LinkFault::SerialPortInUse,
        link::FaultKind::NoBaudRate => dto::LinkFault::NoBaudRate,
        link::FaultKind::NoHost => dto::LinkFault::NoHost,
        link::FaultKind::Refused => dto::LinkFault::Refused,
        link::FaultKind::NoAnswer => dto::LinkFault::NoAnswer,
        link::FaultKind::ClosedByPeer => dto::LinkFault::ClosedByPeer,
        link::FaultKind::Other => dto::LinkFault::Other,
    }
}

fn link_info(station: &Station, info: &link::LinkInfo, stats: &LinkStats) -> dto::LinkInfo {
    let now = station.now();
    let (state, fault, detail) = match &info.state {
        link::LinkState::Connecting { last_error, .. } => {
            let fault = last_error.as_ref().map(|fault| link_fault(fault.kind));
            (dto::LinkState::Connecting, fault, last_error.as_ref().map(ToString::to_string))
        }
        link::LinkState::Up { .. } => (dto::LinkState::Up, None, None),
        link::LinkState::Down => (dto::LinkState::Down, None, None),
        link::LinkState::Ended { remark } => (dto::LinkState::Ended, None, remark.clone()),
    };
    dto::LinkInfo {
        id: info.id.0,
        name: info.name.clone(),
        address: info.address.to_string(),
        local_address: station.local_address(info.id).map(|local| local.to_string()),
        state,
        fault,
        detail,
        forward: info.forwards,
        frames_received: stats.received.frames,
        frames_sent: stats.sent.frames,
        bytes_received: stats.received.bytes,
        bytes_sent: stats.sent.bytes,
        bad_crc: stats.bad_crc,
        garbage_bytes: stats.garbage_bytes,
        frames_refused: stats.refused,
        accepts_unsigned: info.accepts_unsigned,
        frames_lost: stats.lost,
        loss_pct: stats.loss_ratio.map(|ratio| ratio * 100.0),
        round_trip_ms: stats.round_trip.map(|round_trip| round_trip.last.as_secs_f64() * 1e3),
        age_s: stats.last_seen.map(|seen| now.since(seen).as_secs_f64()),
        frames_per_s: stats.rates.frames_hz,
        namesake: station.namesake().filter(|(link, _)| *link == info.id).map(|(_, place)| place),
        recent_loss_pct: stats.rates.loss_ratio.map(|ratio| ratio * 100.0),
    }
}

pub(crate) fn signing(vehicle: &VehicleHandle) -> dto::SigningInfo {
    let info = vehicle.signing();
    dto::SigningInfo {
        must_sign: info.must_sign,
        key: info.key,
        key_missing: info.key_missing,
        unproven: info.unproven,
        link_accepts_unsigned: vehicle.link().is_some_and(|(link, _, _)| link.accepts_unsigned),
        verified: info.counts.verified,
        unsigned_accepted: info.counts.unsigned_accepted,
        refused_unsigned: info.counts.unsigned,
        refused_wrong_key: info.counts.wrong_key,
        refused_replayed: info.counts.replayed,
        refused_old: info.counts.old,
        refused_future: info.counts.future,
        verified_age_s: info.verified_age.map(|age| age.as_secs_f64()),
        refused_age_s: info.refused_age.map(|age| age.as_secs_f64()),
    }
}

/// The networks of the fleets that the station is in.
pub(crate) fn networks(station: &Station) -> Vec<dto::FleetNetwork> {
    let network = |FarNetwork { name, problem }| dto::FleetNetwork { name, problem };
    station.networks().borrow().iter().cloned().map(network).collect()
}

pub(crate) fn links(station: &Station) -> Vec<dto::LinkInfo> {
    station.links().iter().map(|(info, stats)| link_info(station, info, stats)).collect()
}

/// Serial ports, and which of the station's links is on each.
pub(crate) fn serial_ports(station: &Station, ports: Vec<link::SerialPort>) -> Vec<dto::SerialPort> {
    let links = station.links();
    ports.into_iter().map(|port| serial_port(&links, port)).collect()
}

fn serial_port(links: &[(link::LinkInfo, LinkStats)], port: link::SerialPort) -> dto::SerialPort {
    let is_on_it = |info: &link::LinkInfo| match &info.address {
        link::LinkAddress::Serial { path, .. } => port.is_at(path),
        _ => false,
    };
    dto::SerialPort {
        link: links.iter().find(|(info, _)| is_on_it(info)).map(|(info, _)| info.id.0),
        device: port.device,
        lasting_path: port.lasting_path,
        description: port.description,
        usual_baud: port.usual_baud,
        is_in_use: port.is_in_use,
        is_allowed: port.is_allowed,
    }
}

/// Link to a vehicle, with the counters of this vehicle alone.
pub(super) fn vehicle_link(vehicle: &VehicleHandle) -> Option<dto::LinkInfo> {
    let (info, stats, source) = vehicle.link()?;
    let now = vehicle.station().now();
    let mut link = link_info(vehicle.station(), &info, &stats);
    if let Some(source) = source {
        link.frames_received = source.received.frames;
        link.bytes_received = source.received.bytes;
        link.frames_lost = source.lost;
        link.loss_pct = source.rates.loss_ratio.map(|ratio| ratio * 100.0);
        link.recent_loss_pct = link.loss_pct;
        link.frames_per_s = source.rates.frames_hz;
        link.age_s = Some(now.since(source.last_seen).as_secs_f64());
    }
    Some(link)
}
