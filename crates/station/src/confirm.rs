//! Confirmations: a dangerous act is done when it is requested again with the confirmation that the first request
//! returned. A confirmation is valid for that operator, that vehicle and exactly that act, once, and for a short time.

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_proto::MonoTime;
use vencejo_vehicle::{Danger, VehicleId};

use crate::control::OperatorId;

/// How long a confirmation is valid.
pub const VALID_FOR: Duration = Duration::from_secs(15);
/// Most open confirmations of one operator; a further one drops the oldest.
const MAX_OF_ONE: usize = 8;
/// Most open confirmations in total.
const MAX: usize = 256;
/// Random bytes of a confirmation: 128 bits.
const ID_BYTES: usize = 16;

/// What is to be confirmed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Challenge {
    /// What to send with the act.
    pub id: String,
    /// What is dangerous about it.
    pub danger: Danger,
    /// The vehicle.
    pub vehicle: VehicleId,
    /// Its name, if it is remote.
    pub name: Option<String>,
    /// How long it is valid.
    pub valid_for: Duration,
}

impl Challenge {
    /// The vehicle as an error message names it.
    pub fn vehicle_name(&self) -> String {
        self.name.clone().unwrap_or_else(|| format!("vehicle {}", self.vehicle))
    }
}

#[derive(Debug)]
struct Issued {
    id: String,
    operator: OperatorId,
    vehicle: VehicleId,
    act: String,
    until: MonoTime,
}

/// The confirmations that are open.
#[derive(Debug, Default)]
pub(crate) struct Confirmations(VecDeque<Issued>);

impl Confirmations {
    /// A confirmation for an act, whose every parameter is in `act`. `None` when the system has no random numbers.
    pub(crate) fn issue(
        &mut self,
        operator: OperatorId,
        vehicle: VehicleId,
        danger: Danger,
        act: String,
        now: MonoTime,
    ) -> Option<Challenge> {
        let mut bytes = [0_u8; ID_BYTES];
        getrandom::fill(&mut bytes).ok()?;
        let id: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        self.0.retain(|issued| now <= issued.until);
        let of_one = self.0.iter().filter(|issued| issued.operator == operator).count();
        let oldest = match (of_one >= MAX_OF_ONE, self.0.len() >= MAX) {
            (true, _) => self.0.iter().position(|issued| issued.operator == operator),
            (false, true) => Some(0),
            (false, false) => None,
        };
        oldest.and_then(|oldest| self.0.remove(oldest));
        self.0.push_back(Issued { id: id.clone(), operator, vehicle, act, until: now + VALID_FOR });
        Some(Challenge { id, danger, vehicle, name: None, valid_for: VALID_FOR })
    }

    /// Whether a confirmation is valid for an act. It is used up in any case.
    pub(crate) fn take(
        &mut self,
        id: &str,
        operator: OperatorId,
        vehicle: VehicleId,
        act: &str,
        now: MonoTime,
    ) -> bool {
        let Some(place) = self.0.iter().position(|issued| issued.id == id) else { return false };
        self.0.remove(place).is_some_and(|issued| {
            issued.operator == operator && issued.vehicle == vehicle && issued.act == act && now <= issued.until
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Control;

    const ONE: VehicleId = VehicleId::new(1);

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    // fault 28: expired after 15 s, of another operator, vehicle or act, used: no confirmation
    #[test]
    fn good_once_for_the_same_act_of_the_same_operator_to_the_same_vehicle_in_time() {
        let control = Control::default();
        let (ana, luis) = (control.enlist("Ana", at(0)).id(), control.enlist("Luis", at(0)).id());
        let cases: [(&str, OperatorId, VehicleId, &str, u64, bool); 6] = [
            ("the same", ana, ONE, "arm", 15_000, true),
            ("another operator", luis, ONE, "arm", 1, false),
            ("another vehicle", ana, VehicleId::new(2), "arm", 1, false),
            ("another act", ana, ONE, "disarm", 1, false),
            ("too late", ana, ONE, "arm", 15_001, false),
            ("another id", ana, ONE, "arm", 1, false),
        ];
        for (name, operator, vehicle, act, ms, expected) in cases {
            let mut open = Confirmations::default();
            let issued = open.issue(ana, ONE, Danger::ForceArm, "arm".into(), at(0)).expect("random");
            let id = if name == "another id" { "0".repeat(32) } else { issued.id.clone() };
            assert_eq!(open.take(&id, operator, vehicle, act, at(ms)), expected, "{name}");
            if name != "another id" {
                assert!(!open.take(&issued.id, ana, ONE, "arm", at(ms.min(2))), "{name}: it was used");
            }
        }
    }

    #[test]
    fn only_so_many_are_open() {
        let control = Control::default();
        let mut open = Confirmations::default();
        let ids: Vec<_> = (0..64).map(|index| control.enlist(&format!("{index}"), at(0)).id()).collect();
        let first = open.issue(ids[0], ONE, Danger::Reboot, "a".into(), at(0)).expect("random").id;
        for operator in &ids {
            for _ in 0..MAX_OF_ONE {
                open.issue(*operator, ONE, Danger::Reboot, "a".into(), at(0)).expect("random");
            }
        }
        assert!(open.0.len() <= MAX && !open.take(&first, ids[0], ONE, "a", at(1)));
        open.issue(ids[0], ONE, Danger::Reboot, "a".into(), at(20_000)).expect("random");
        assert_eq!(open.0.len(), 1, "those that ran out are forgotten");
    }
}
