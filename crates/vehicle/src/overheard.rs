//! The plans on board as a recording has them: what an autopilot gave to any station, or took from it.
//!
//! Lists of items count both ways, plan files of MAVFTP as they are read: a station that verifies what it sent reads it
//! back. Nothing is asked for, and a transfer with a gap tells nothing. A list of which a part is replaced is unknown from
//! then on.

use std::collections::{BTreeMap, VecDeque};

use vencejo_flight::plan::{MAX_ITEMS, Mission, PlanKind};
use vencejo_proto::dialect::{MavMessage, MavMissionType};
use vencejo_proto::ftp::{FtpOpcode, FtpPayload};
use vencejo_proto::plan_file::PlanFileHeader;
use vencejo_proto::{Address, Message, MissionItemInt};

use crate::autopilot::AutopilotType;
use crate::heartbeat::is_autopilot;
use crate::plan_state::{PlanState, Unknown, read_plan};
use crate::transfer::{MAX_FILE, file_items};

/// Most autopilots that are listened to.
const MAX_AUTOPILOTS: usize = 16;

/// A plan that an autopilot had on board from then on.
#[derive(Debug, Clone, PartialEq)]
pub struct HeardPlan {
    /// The autopilot.
    pub autopilot: Address,
    /// Which plan.
    pub kind: PlanKind,
    /// Verified, empty, or unknown.
    pub state: PlanState,
    /// Its items; none of an empty or unknown one.
    pub list: Mission,
}

/// Listens to all messages of a recording.
#[derive(Debug, Default)]
pub struct Overheard {
    autopilots: Vec<Autopilot>,
    /// Plans that were not told yet: one message clears all kinds.
    untold: VecDeque<HeardPlan>,
}

#[derive(Debug)]
struct Autopilot {
    address: Address,
    is_ardupilot: bool,
    lists: [Option<List>; 3],
    file: File,
}

/// A list of items that is being transferred.
#[derive(Debug)]
struct List {
    items: Vec<Option<MissionItemInt>>,
    /// It counts once the autopilot has taken it.
    is_upload: bool,
}

/// A file that is being read.
#[derive(Debug, Default)]
struct File {
    /// Its beginning, without a gap.
    begin: Vec<u8>,
    /// Parts beyond, by their offsets.
    parts: BTreeMap<usize, Vec<u8>>,
    /// Their bytes.
    waiting: usize,
    /// It is no plan.
    is_other: bool,
}

impl Overheard {
    /// Whether messages with this id matter: the others need not be decoded.
    pub fn concerns(message_id: u32) -> bool {
        // HEARTBEAT, MISSION_WRITE_PARTIAL_LIST, MISSION_COUNT, MISSION_CLEAR_ALL, MISSION_ACK, MISSION_ITEM_INT,
        // FILE_TRANSFER_PROTOCOL
        matches!(message_id, 0 | 38 | 44 | 45 | 47 | 73 | 110)
    }

    /// The next message; the plan that is on board from then on, if it completes one. Of several, one is told with each
    /// message from here on.
    pub fn hear(&mut self, from: Address, message: &Message) -> Option<HeardPlan> {
        self.take(from, message);
        self.untold.pop_front()
    }

    fn take(&mut self, from: Address, message: &Message) {
        if let Message::Heartbeat(heartbeat) = message {
            let is_known = self.autopilots.iter().any(|one| one.address == from);
            if is_autopilot(heartbeat) && !is_known && self.autopilots.len() < MAX_AUTOPILOTS {
                let kind = AutopilotType { autopilot: heartbeat.autopilot, mav_type: heartbeat.mav_type };
                let is_ardupilot = kind.is_ardupilot();
                self.autopilots.push(Autopilot {
                    address: from,
                    is_ardupilot,
                    lists: [const { None }; 3],
                    file: File::default(),
                });
            }
            return;
        }
        let said = self.autopilots.iter().position(|one| one.address == from);
        let is_addressed = |one: &Autopilot| message.target().includes(one.address);
        if let Some(place) = said.or_else(|| self.autopilots.iter().position(is_addressed)) {
            for plan in self.autopilots[place].hear(said.is_some(), message) {
                // An older one that waits has been overtaken.
                self.untold.retain(|one| (one.autopilot, one.kind) != (plan.autopilot, plan.kind));
                self.untold.push_back(plan);
            }
        }
    }
}

/// The kinds of plans that a message is about.
fn kinds_of(mission_type: u8) -> impl Iterator<Item = PlanKind> {
    let is_all = mission_type == MavMissionType::MAV_MISSION_TYPE_ALL as u8;
    PlanKind::ALL.into_iter().filter(move |kind| is_all || kind.mission_type() == mission_type)
}

fn kind_numbered(mission_type: u8) -> Option<PlanKind> {
    PlanKind::ALL.into_iter().find(|kind| kind.mission_type() == mission_type)
}

impl Autopilot {
    fn hear(&mut self, is_own: bool, message: &Message) -> Vec<HeardPlan> {
        match message {
            Message::Dialect(MavMessage::MISSION_COUNT(count)) => {
                let Some(kind) = kind_numbered(count.mission_type as u8) else { return Vec::new() };
                self.lists[kind as usize] = Some(List::new(count.count.into(), !is_own));
                self.finished(kind, false).into_iter().collect()
            }
            Message::Dialect(MavMessage::MISSION_CLEAR_ALL(clear)) if !is_own => {
                kinds_of(clear.mission_type as u8)
                    .for_each(|kind| self.lists[kind as usize] = Some(List::new(0, true)));
                Vec::new()
            }
            Message::Dialect(MavMessage::MISSION_WRITE_PARTIAL_LIST(part)) if !is_own => {
                kind_numbered(part.mission_type as u8).map(|kind| self.forgotten(kind)).into_iter().collect()
            }
            Message::MissionItemInt(item) => self.on_item(is_own, item).into_iter().collect(),
            Message::MissionAck(ack) if is_own && ack.result == 0 => {
                kinds_of(ack.mission_type).filter_map(|kind| self.finished(kind, true)).collect()
            }
            _ => {
                let answer = FtpPayload::from_message(message).filter(|_| is_own);
                answer.and_then(|(_, answer)| self.on_file(answer)).into_iter().collect()
            }
        }
    }

    fn on_item(&mut self, is_own: bool, item: &MissionItemInt) -> Option<HeardPlan> {
        let kind = kind_numbered(item.mission_type)?;
        let list = self.lists[kind as usize].as_mut().filter(|list| list.is_upload != is_own)?;
        *list.items.get_mut(usize::from(item.seq))? = Some(*item);
        self.finished(kind, false)
    }

    fn forgotten(&mut self, kind: PlanKind) -> HeardPlan {
        self.lists[kind as usize] = None;
        let (state, list) = (PlanState::Unknown(Unknown::ChangedElsewhere), Mission { home: None, items: Vec::new() });
        HeardPlan { autopilot: self.address, kind, state, list }
    }

    /// Takes a list that is whole, once for each transfer.
    fn finished(&mut self, kind: PlanKind, is_taken: bool) -> Option<HeardPlan> {
        let list = self.lists[kind as usize].take_if(|list| list.is_upload == is_taken)?;
        let items: Option<Vec<_>> = list.items.iter().copied().collect();
        let Some(items) = items else {
            self.lists[kind as usize] = Some(list);
            return None;
        };
        self.plan(kind, &items)
    }

    fn on_file(&mut self, answer: FtpPayload) -> Option<HeardPlan> {
        match (answer.opcode, answer.req_opcode) {
            (FtpOpcode::ACK, FtpOpcode::OPEN_FILE_RO | FtpOpcode::CREATE_FILE | FtpOpcode::OPEN_FILE_WO) => {
                self.file = File::default();
                None
            }
            (FtpOpcode::ACK, FtpOpcode::READ_FILE | FtpOpcode::BURST_READ_FILE) if !self.file.is_other => {
                let (kind, items) = self.file.put(answer.offset, answer.data)?;
                self.file.is_other = true;
                self.plan(kind, &items)
            }
            _ => None,
        }
    }

    fn plan(&self, kind: PlanKind, wire: &[MissionItemInt]) -> Option<HeardPlan> {
        let (list, state) = read_plan(kind, wire, self.is_ardupilot).ok()?;
        Some(HeardPlan { autopilot: self.address, kind, state, list })
    }
}

impl List {
    fn new(count: usize, is_upload: bool) -> Self {
        Self { items: vec![None; count.min(MAX_ITEMS)], is_upload }
    }
}

impl File {
    /// Adds a part; the plan, once the file is whole.
    fn put(&mut self, offset: u32, data: Vec<u8>) -> Option<(PlanKind, Vec<MissionItemInt>)> {
        if data.is_empty() {
            return None;
        }
        self.waiting += data.len();
        if let Some(before) = self.parts.insert(usize::try_from(offset).ok()?, data) {
            self.waiting -= before.len();
        }
        while let Some(next) = self.parts.first_entry().filter(|next| *next.key() <= self.begin.len()) {
            let (offset, part) = next.remove_entry();
            self.waiting -= part.len();
            let known = self.begin.len() - offset;
            self.begin.extend(part.into_iter().skip(known));
        }
        // Files of other kinds can be long.
        self.is_other = self.begin.len() + self.waiting > 2 * MAX_FILE;
        if self.begin.is_empty() {
            return None;
        }
        let is_whole = |header: &PlanFileHeader| header.first == 0 && header.file_len() <= MAX_FILE;
        let header = PlanFileHeader::decode(&self.begin).ok().filter(is_whole);
        let kind = header.and_then(|header| kind_numbered(u8::try_from(header.mission_type).ok()?));
        let Some((header, kind)) = header.zip(kind) else {
            self.is_other = true;
            return None;
        };
        Some((kind, file_items(kind, self.begin.get(..header.file_len())?).ok()?))
    }
}

#[cfg(test)]
mod tests {
    use vencejo_flight::plan::{MissionItem, items_to_wire};
    use vencejo_proto::dialect::{MISSION_CLEAR_ALL_DATA, MISSION_COUNT_DATA, MISSION_WRITE_PARTIAL_LIST_DATA};
    use vencejo_proto::plan_file::encode_plan_file;
    use vencejo_proto::{Heartbeat, MissionAck};

    use super::*;

    const PLANE: Address = Address::new(1, 1);
    const STATION: Address = Address::new(255, 190);
    const ALL: MavMissionType = MavMissionType::MAV_MISSION_TYPE_ALL;

    fn wire() -> Vec<MissionItemInt> {
        let items = [0.0, 80.0, 90.0].map(|alt_m| MissionItem::waypoint(40.1, -3.7, alt_m));
        items_to_wire(&items, PLANE, PlanKind::Mission).expect("items")
    }

    fn count(to: Address, count: u16) -> Message {
        let (target_system, target_component) = (to.system.0, to.component.0);
        Message::Dialect(MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
            count,
            target_system,
            target_component,
            ..Default::default()
        }))
    }

    fn ack(result: u8) -> Message {
        Message::MissionAck(MissionAck { target: STATION, result, mission_type: 0, opaque_id: 0 })
    }

    fn part(offset: u32, data: &[u8], req_opcode: FtpOpcode) -> Message {
        let answer = FtpPayload::request(FtpOpcode::ACK, 0, 1, offset, data);
        FtpPayload { req_opcode, ..answer }.to_message(STATION)
    }

    fn overheard() -> Overheard {
        let mut overheard = Overheard::default();
        let plane = Heartbeat { mav_type: 1, autopilot: 3, mavlink_version: 3, ..Heartbeat::default() };
        assert_eq!(overheard.hear(PLANE, &Message::Heartbeat(plane)), None);
        overheard
    }

    /// What is heard of several messages.
    fn all(overheard: &mut Overheard, said: impl IntoIterator<Item = (Address, Message)>) -> Vec<HeardPlan> {
        said.into_iter().filter_map(|(from, message)| overheard.hear(from, &message)).collect()
    }

    fn heights(plan: &HeardPlan) -> Vec<Option<f64>> {
        plan.list.items.iter().map(|item| item.params[6]).collect()
    }

    #[test]
    fn a_list_that_is_read_or_taken_is_on_board_and_one_that_is_refused_or_has_a_gap_is_not() {
        let mut overheard = overheard();
        let items = |from| wire().into_iter().map(move |item| (from, Message::MissionItemInt(item)));
        let read = [(PLANE, count(STATION, 3))].into_iter().chain(items(PLANE));
        let [plan] = &all(&mut overheard, read)[..] else { panic!("one") };
        assert_eq!(
            (plan.autopilot, plan.kind, heights(plan)),
            (PLANE, PlanKind::Mission, vec![Some(80.0), Some(90.0)])
        );
        assert!(matches!(plan.state, PlanState::Verified { count: 2, .. }), "{plan:?}");

        let sent = || [(STATION, count(PLANE, 3))].into_iter().chain(items(STATION));
        assert_eq!(all(&mut overheard, sent()), [], "not taken yet");
        assert_eq!(all(&mut overheard, [(PLANE, ack(0))]).len(), 1);
        assert_eq!(all(&mut overheard, sent().chain([(PLANE, ack(4)), (PLANE, ack(5))])), [], "refused");
        assert_eq!(all(&mut overheard, sent().take(3).chain([(PLANE, ack(0))])), [], "a gap");
        let clear = MISSION_CLEAR_ALL_DATA { target_system: 1, target_component: 1, ..Default::default() };
        let clear = Message::Dialect(MavMessage::MISSION_CLEAR_ALL(clear));
        let [plan] = &all(&mut overheard, [(STATION, clear), (PLANE, ack(0))])[..] else { panic!("one") };
        assert_eq!((plan.state, plan.list.items.len()), (PlanState::Empty, 0));
        // All kinds at once, as a PX4 takes it; the others are told with what comes next.
        let clear = MISSION_CLEAR_ALL_DATA { target_system: 1, target_component: 1, mission_type: ALL };
        let clear = Message::Dialect(MavMessage::MISSION_CLEAR_ALL(clear));
        let taken = Message::MissionAck(MissionAck { target: STATION, result: 0, mission_type: 255, opaque_id: 0 });
        let rest = || [(PLANE, ack(5)), (PLANE, ack(5))];
        assert_eq!(all(&mut overheard, [(STATION, clear.clone()), (PLANE, ack(4))]), [], "refused");
        let told = all(&mut overheard, [(PLANE, taken.clone())].into_iter().chain(rest()));
        assert!(told.iter().all(|plan| plan.state == PlanState::Empty));
        assert_eq!(told.iter().map(|plan| plan.kind).collect::<Vec<_>>(), PlanKind::ALL);
        let again = std::iter::repeat_n([(STATION, clear), (PLANE, taken)], 50).flatten();
        all(&mut overheard, again);
        assert!(overheard.untold.len() < PlanKind::ALL.len(), "newer ones take the place of those that wait");
        all(&mut overheard, rest());
        // What a part of is replaced is not known any more, nor is what it was to be.
        let part = MISSION_WRITE_PARTIAL_LIST_DATA { target_system: 1, target_component: 1, ..Default::default() };
        let part = Message::Dialect(MavMessage::MISSION_WRITE_PARTIAL_LIST(part));
        let replaced = sent().chain([(STATION, part), (PLANE, ack(0))]);
        let [plan] = &all(&mut overheard, replaced)[..] else { panic!("one") };
        assert_eq!((plan.state, plan.list.items.len()), (PlanState::Unknown(Unknown::ChangedElsewhere), 0));
        // Of nobody that was heard.
        assert_eq!(all(&mut overheard, [(Address::new(9, 1), count(STATION, 0))]), []);
    }

    #[test]
    fn a_plan_file_is_on_board_once_it_was_read_in_any_order_and_other_files_are_not() {
        let (mut overheard, burst) = (overheard(), FtpOpcode::BURST_READ_FILE);
        let file = encode_plan_file(0, &wire());
        let opened = || (PLANE, part(0, &[0, 0, 16, 0], FtpOpcode::OPEN_FILE_RO));
        let parts = |order: [usize; 3]| {
            let file = &file;
            order.map(|nth| (PLANE, part(50 * nth as u32, &file[50 * nth..file.len().min(50 * nth + 50)], burst)))
        };
        assert_eq!(file.len(), 10 + 3 * 38);
        for order in [[0, 1, 2], [2, 0, 1]] {
            let [plan] = &all(&mut overheard, [opened()].into_iter().chain(parts(order)))[..] else { panic!("one") };
            assert_eq!(heights(plan), [Some(80.0), Some(90.0)]);
        }
        assert_eq!(all(&mut overheard, parts([0, 1, 2])), [], "repeated");
        let [_, rest @ ..] = parts([0, 1, 2]);
        assert_eq!(all(&mut overheard, [opened()].into_iter().chain(rest)), [], "a gap");
        let other = [opened(), (PLANE, part(0, &[0x1b; 60], burst))];
        assert_eq!(all(&mut overheard, other.into_iter().chain(parts([0, 1, 2]))), [], "parameters");
        let asked = FtpPayload::request(burst, 0, 1, 0, &file).to_message(PLANE);
        assert_eq!(all(&mut overheard, [opened(), (STATION, asked)]), []);
    }
    /// A file whose end does not come, and parts of it that are nowhere near: neither is kept without a bound.
    #[test]
    fn what_is_kept_of_a_file_is_bounded() {
        let file = encode_plan_file(0, &wire());
        let mut kept = File::default();
        assert_eq!(kept.put(0, file[..50].to_vec()), None);
        let mut count = 0;
        while !kept.is_other {
            count += 1;
            assert_eq!(kept.put(1_000 * count, vec![0; 239]), None);
        }
        assert!(kept.begin.len() + kept.waiting <= 2 * MAX_FILE + 239);
        // As much again, each part twice and the second half first, is put together once.
        let mut kept = File::default();
        let items: Vec<_> = (0..MAX_ITEMS as u16).map(|seq| MissionItemInt { seq, ..wire()[1] }).collect();
        let file = encode_plan_file(0, &items);
        let parts: Vec<_> = file.chunks(239).enumerate().map(|(nth, part)| (239 * nth as u32, part)).collect();
        let (first, second) = parts.split_at(parts.len() / 2);
        let told = second.iter().chain(second).chain(first).filter_map(|(at, part)| kept.put(*at, part.to_vec()));
        assert_eq!(told.map(|(_, items)| items.len()).collect::<Vec<_>>(), [MAX_ITEMS]);
    }
}
