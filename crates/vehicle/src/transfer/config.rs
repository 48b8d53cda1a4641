//! What a transfer needs to know about the vehicle and the link.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::param::ParamEncoding;
use vencejo_proto::{Address, Message};

use super::error::{NoPlanKinds, TransferError};

/// The message that carries plan items.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ItemForm {
    /// MISSION_ITEM_INT: the vehicle reports that it supports it.
    Integer,
    /// MISSION_ITEM: the vehicle reports no other, or is too old to report.
    Float,
    /// MISSION_ITEM_INT as long as it is understood.
    Unknown,
}

/// What a transfer needs to know about the vehicle and the link. Cheap to clone.
#[derive(Debug, Clone)]
pub struct TransferConfig {
    /// The vehicle's autopilot.
    pub vehicle: Address,
    /// Us.
    pub station: Address,
    /// Whether it is an ArduPilot: plan files over MAVFTP, item 0 of a mission is home, several requests at once.
    pub is_ardupilot: bool,
    /// Whether it reports MAVFTP (`MAV_PROTOCOL_CAPABILITY_FTP`).
    pub has_ftp: bool,
    /// The message that carries its plan items.
    pub item_form: ItemForm,
    /// Why the item protocol cannot carry fences and rally points; `None` when it can.
    pub no_plan_kinds: Option<NoPlanKinds>,
    /// Its encoding of integers in PARAM_VALUE; `None` when only its values can show it.
    pub param_encoding: Option<ParamEncoding>,
    /// Round trip to the vehicle, where it is known (TIMESYNC). Default `None`: measured by the transfer.
    pub round_trip: Option<Duration>,
    /// Items sent ahead of the vehicle's requests in an item-by-item upload to ArduPilot, 1 to 64. Default 1: an item
    /// is sent when it is asked for, as the protocol says.
    pub item_window: u16,
    /// Where MAVFTP sessions get their numbers: one for each vehicle, kept as long as the vehicle is.
    pub ftp_sessions: FtpSessions,
}

impl TransferConfig {
    /// For an unknown vehicle: item by item, one at a time.
    pub fn new(vehicle: Address, station: Address) -> Self {
        Self {
            vehicle,
            station,
            is_ardupilot: false,
            has_ftp: false,
            item_form: ItemForm::Unknown,
            no_plan_kinds: None,
            param_encoding: None,
            round_trip: None,
            item_window: 1,
            ftp_sessions: FtpSessions::new(0),
        }
    }

    /// An ArduPilot with MAVFTP.
    pub fn ardupilot(vehicle: Address, station: Address) -> Self {
        let item_form = ItemForm::Integer;
        let param_encoding = Some(ParamEncoding::CCast);
        Self { is_ardupilot: true, has_ftp: true, item_form, param_encoding, ..Self::new(vehicle, station) }
    }

    /// An ArduPilot from before MISSION_ITEM_INT and MAVFTP, such as ArduPlane 3.x on an APM 2.
    pub fn old_ardupilot(vehicle: Address, station: Address) -> Self {
        Self {
            is_ardupilot: true,
            item_form: ItemForm::Float,
            no_plan_kinds: Some(NoPlanKinds::OldFirmware),
            param_encoding: Some(ParamEncoding::CCast),
            ..Self::new(vehicle, station)
        }
    }

    /// Why the item protocol cannot carry this kind of plan, if it cannot: the vehicle would apply the messages to the
    /// mission.
    pub(crate) fn refuses_items(&self, kind: PlanKind) -> Option<TransferError> {
        let reason = self.no_plan_kinds.filter(|_| kind != PlanKind::Mission)?;
        Some(TransferError::OnlyMission { kind, reason })
    }

    /// Whether a message is from the vehicle and addressed to us or broadcast.
    pub(crate) fn concerns_us(&self, from: Address, message: &Message) -> bool {
        from == self.vehicle && message.target().includes(self.station)
    }
}

/// Numbers for MAVFTP sessions, so that ours do not repeat within 250 and none begins with the message number on which
/// the one before ended (ArduPilot would repeat its last answer).
#[derive(Debug, Clone)]
pub struct FtpSessions(Arc<AtomicU32>);

/// One MAVFTP session's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FtpLease {
    /// The session's id, 1 to 250; 0 is what most other stations use.
    pub session: u8,
    /// The id of our previous session: the one to end when the vehicle reports that another session is open.
    pub previous: u8,
    /// Number of the first message.
    pub sequence: u16,
}

impl FtpSessions {
    const IDS: u32 = 250;
    /// Odd, so that all 65,536 starts are used before one repeats.
    const SEQUENCE_STEP: u32 = 2039;

    /// Numbers from `seed` on. Use a different seed each time the program starts.
    pub fn new(seed: u32) -> Self {
        Self(Arc::new(AtomicU32::new(seed)))
    }

    pub(crate) fn lease(&self) -> FtpLease {
        let n = self.0.fetch_add(1, Ordering::Relaxed);
        let id = |n: u32| (1 + n % Self::IDS) as u8;
        FtpLease {
            session: id(n),
            previous: id(n.wrapping_add(Self::IDS - 1)),
            sequence: n.wrapping_mul(Self::SEQUENCE_STEP) as u16,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sessions_know_their_predecessor() {
        for seed in [0, 249, 250, 1_000_003] {
            let sessions = FtpSessions::new(seed);
            let mut last = sessions.lease();
            for _ in 0..600 {
                let lease = sessions.clone().lease();
                assert_eq!(lease.previous, last.session);
                assert!((1..=250).contains(&lease.session));
                assert_ne!(lease.sequence, last.sequence);
                last = lease;
            }
        }
    }
}
