//! Commands with acknowledgement: COMMAND_LONG, COMMAND_INT and COMMAND_ACK.
//!
//! Protocol: mavlink.io, "Command Protocol". One command per MAV_CMD is in flight: COMMAND_ACK carries no other
//! identifier. A command without an answer is repeated with `confirmation` + 1 only when it is idempotent
//! ([`is_idempotent`]), or when its owner has read from the vehicle that it was not executed. Late answers to
//! repetitions would be taken for the next command's: that waits for them (`Owed`).

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use vencejo_flight::plan::Command;
use vencejo_proto::{Address, CommandAck, CommandInt, CommandLong, Message, MonoTime};

/// Most commands queued behind one with the same MAV_CMD; more are refused.
const MAX_WAITING: usize = 64;

/// How long the owner may take to read the vehicle's state: two heartbeats and a bit.
const ASK_WAIT: Duration = Duration::from_millis(2_500);

/// Assumed round trip of a link until it is measured, and the jitter between its answers.
const ROUND_TRIP_UNKNOWN: Duration = Duration::from_millis(500);
const SLACK: Duration = Duration::from_millis(50);

/// Numbers of ArduPilot's auxiliary functions (`RC_Channel::AUX_FUNC`) that arm, end a flight or change the mission.
pub(crate) mod aux {
    pub(crate) const FENCE: u32 = 11;
    pub(crate) const AUTO: u32 = 16;
    pub(crate) const PARACHUTE_RELEASE: u32 = 22;
    pub(crate) const PARACHUTE_3POS: u32 = 23;
    pub(crate) const MISSION_RESET: u32 = 24;
    pub(crate) const MOTOR_ESTOP: u32 = 31;
    /// Before ArduPilot 4.2.
    pub(crate) const ARMDISARM_OLD: u32 = 41;
    pub(crate) const CLEAR_WP: u32 = 58;
    pub(crate) const DISARM: u32 = 81;
    pub(crate) const ARMDISARM: u32 = 153;
    pub(crate) const ARMDISARM_AIRMODE: u32 = 154;
    pub(crate) const ARM_EMERGENCY_STOP: u32 = 165;
    pub(crate) const ICE_START_STOP: u32 = 179;
}

/// A whole number as vehicles read it from a float parameter.
pub(crate) fn whole(param: f32) -> u32 {
    param as u32
}

/// Name and number of a command as errors show it: `COMPONENT_ARM_DISARM (400)`; `command 31000` without a name.
pub fn numbered(command: Command) -> String {
    match command.name() {
        Some(_) => format!("{command} ({})", command.0),
        None => command.to_string(),
    }
}

/// A vehicle's answer to a command (`MAV_RESULT`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CommandResult(pub u8);

impl CommandResult {
    /// Done, or being done.
    pub const ACCEPTED: Self = Self(0);
    /// Not now.
    pub const TEMPORARILY_REJECTED: Self = Self(1);
    /// Wrong parameters, or not allowed.
    pub const DENIED: Self = Self(2);
    /// Unknown command.
    pub const UNSUPPORTED: Self = Self(3);
    /// Tried and failed.
    pub const FAILED: Self = Self(4);
    /// Under way; another answer follows.
    pub const IN_PROGRESS: Self = Self(5);
    /// Only as COMMAND_LONG.
    pub const COMMAND_LONG_ONLY: Self = Self(7);
    /// Only as COMMAND_INT.
    pub const COMMAND_INT_ONLY: Self = Self(8);

    /// Its name in MAVLink and what it means.
    const fn text(self) -> (&'static str, &'static str) {
        match self.0 {
            0 => ("MAV_RESULT_ACCEPTED", "accepted"),
            1 => ("MAV_RESULT_TEMPORARILY_REJECTED", "not possible now"),
            2 => ("MAV_RESULT_DENIED", "denied: wrong values, or not allowed"),
            3 => ("MAV_RESULT_UNSUPPORTED", "it does not know this command"),
            4 => ("MAV_RESULT_FAILED", "failed"),
            5 => ("MAV_RESULT_IN_PROGRESS", "in progress"),
            6 => ("MAV_RESULT_CANCELLED", "cancelled"),
            7 => ("MAV_RESULT_COMMAND_LONG_ONLY", "it takes it as COMMAND_LONG only"),
            8 => ("MAV_RESULT_COMMAND_INT_ONLY", "it takes it as COMMAND_INT only"),
            9 => ("MAV_RESULT_COMMAND_UNSUPPORTED_MAV_FRAME", "it does not take this frame"),
            10 => ("MAV_RESULT_NOT_IN_CONTROL", "another station is in control"),
            _ => ("unknown MAV_RESULT", "a result that is not listed"),
        }
    }

    /// Its name in MAVLink.
    pub const fn name(self) -> &'static str {
        self.text().0
    }
}

impl fmt::Display for CommandResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, meaning) = self.text();
        write!(f, "{meaning} ({name}, {})", self.0)
    }
}

/// Whether executing the command twice has the same effect as executing it once, so that it may be repeated blindly.
///
/// Not idempotent: arming, take-off, reboot, landing start, jumps, relative changes, releases, and unknown commands.
/// Nor is a change of mode: between two transmissions the pilot may have switched to another mode.
pub const fn is_idempotent(command: Command) -> bool {
    matches!(
        command,
        Command::DO_CHANGE_SPEED
            | Command::DO_SET_HOME
            | Command::DO_SET_RELAY
            | Command::DO_SET_SERVO
            | Command::DO_CHANGE_ALTITUDE
            | Command::DO_REPOSITION
            | Command::DO_ORBIT
            | Command::DO_SET_ROI_LOCATION
            | Command::DO_SET_ROI_NONE
            | Command::DO_SET_ROI
            | Command::DO_MOUNT_CONTROL
            | Command::DO_SET_CAM_TRIGG_DIST
            | Command::DO_FENCE_ENABLE
            | Command::GET_HOME_POSITION
            | Command::GET_MESSAGE_INTERVAL
            | Command::SET_MESSAGE_INTERVAL
            | Command::REQUEST_MESSAGE
            | Command::REQUEST_PROTOCOL_VERSION
            | Command::REQUEST_AUTOPILOT_CAPABILITIES
            | Command::GUIDED_CHANGE_SPEED
            | Command::GUIDED_CHANGE_ALTITUDE
            | Command::GUIDED_CHANGE_HEADING
    )
}

/// A command as it is sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CommandMessage {
    /// Seven floats.
    Long(CommandLong),
    /// A frame and an exact position.
    Int(CommandInt),
}

impl CommandMessage {
    /// A COMMAND_LONG.
    pub fn long(target: Address, command: Command, params: [f32; 7]) -> Self {
        Self::Long(CommandLong { target, command: command.0, confirmation: 0, params })
    }

    /// Which it is.
    pub fn command(&self) -> Command {
        Command(match self {
            Self::Long(long) => long.command,
            Self::Int(int) => int.command,
        })
    }

    /// Its first parameter.
    pub(crate) fn first_param(&self) -> f32 {
        match self {
            Self::Long(long) => long.params[0],
            Self::Int(int) => int.params[0],
        }
    }

    /// Its target.
    pub fn target(&self) -> Address {
        match self {
            Self::Long(long) => long.target,
            Self::Int(int) => int.target,
        }
    }

    /// The message of its first transmission.
    pub(crate) fn to_message(self) -> Message {
        self.message(0)
    }

    fn message(&self, confirmation: u8) -> Message {
        match *self {
            Self::Long(long) => Message::CommandLong(CommandLong { confirmation, ..long }),
            Self::Int(int) => Message::CommandInt(int),
        }
    }

    /// The same command in the other form, where the meaning is exactly the same: only without a position, for which
    /// COMMAND_LONG has neither a frame nor the precision.
    fn other_form(&self) -> Option<Self> {
        match *self {
            Self::Int(int) if (int.x, int.y, int.z) == (0, 0, 0.0) => {
                let [p1, p2, p3, p4] = int.params;
                Some(Self::long(int.target, Command(int.command), [p1, p2, p3, p4, 0.0, 0.0, 0.0]))
            }
            Self::Long(long) if long.params[4..] == [0.0; 3] => {
                let [p1, p2, p3, p4, ..] = long.params;
                Some(Self::Int(CommandInt {
                    target: long.target,
                    frame: 0,
                    command: long.command,
                    current: 0,
                    autocontinue: 0,
                    params: [p1, p2, p3, p4],
                    x: 0,
                    y: 0,
                    z: 0.0,
                }))
            }
            _ => None,
        }
    }
}

/// What to do when a command gets no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unanswered {
    /// Send it again.
    Repeat,
    /// Ask the owner ([`CommandOutput::Unanswered`]), which checks the vehicle's state first.
    Ask,
    /// Give up.
    GiveUp,
}

impl Unanswered {
    /// The default for a command.
    pub fn for_command(command: Command) -> Self {
        if is_idempotent(command) { Self::Repeat } else { Self::GiveUp }
    }
}

/// What to do while the same MAV_CMD is in flight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WhenBusy {
    /// Refuse.
    Refuse,
    /// Wait for it to end.
    Wait,
}

/// Timeouts and number of attempts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CommandConfig {
    /// Wait for an answer; never less than two round trips. Default 1 s.
    pub timeout: Duration,
    /// Most transmissions of a command. Default 5.
    pub attempts: u32,
    /// Wait for the next answer after IN_PROGRESS. Default 30 s.
    pub progress_timeout: Duration,
    /// Longest that a command may be in progress. Default 5 min.
    pub progress_limit: Duration,
}

impl Default for CommandConfig {
    fn default() -> Self {
        Self {
            timeout: Duration::from_secs(1),
            attempts: 5,
            progress_timeout: Duration::from_secs(30),
            progress_limit: Duration::from_secs(300),
        }
    }
}

/// Identifies a submitted command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CommandId(u64);

/// The same MAV_CMD is in flight, or too many wait.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Busy;

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandOutcome {
    /// The vehicle answered.
    Answered {
        /// `MAV_RESULT`; never IN_PROGRESS.
        result: CommandResult,
        /// `result_param2`.
        result_param2: i32,
    },
    /// It did not.
    TimedOut {
        /// How often it was sent.
        attempts: u32,
    },
}

/// Outputs of [`Commands`] for its owner.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "moved once, from the queue to the link")]
pub enum CommandOutput {
    /// Send this.
    Send(Message),
    /// The vehicle reports IN_PROGRESS.
    Progress {
        /// Which command.
        id: CommandId,
        /// 0 to 100; `None` when not reported.
        percent: Option<u8>,
    },
    /// There was no answer to a command with [`Unanswered::Ask`]: call [`Commands::repeat`] or [`Commands::forget`]
    /// now, or it waits once more and then times out.
    Unanswered {
        /// Which command.
        id: CommandId,
    },
    /// It ended. Comes once for each command, unless it was forgotten.
    Finished {
        /// Which command.
        id: CommandId,
        /// How.
        outcome: CommandOutcome,
    },
}

#[derive(Debug)]
struct InFlight {
    id: CommandId,
    message: CommandMessage,
    unanswered: Unanswered,
    attempts: u32,
    asked: bool,
    has_changed_form: bool,
    in_progress_since: Option<MonoTime>,
    first_sent: MonoTime,
    last_sent: MonoTime,
    deadline: MonoTime,
}

/// Answers that may still come to a command that was sent more than once and has been answered. Until they have come,
/// or can no longer be expected, the same MAV_CMD is not sent.
#[derive(Debug)]
struct Owed {
    target: Address,
    command: Command,
    answers: u32,
    until: MonoTime,
}

/// The commands of one station to one vehicle.
#[derive(Debug)]
pub struct Commands {
    our: Address,
    config: CommandConfig,
    round_trip: Option<Duration>,
    next_id: u64,
    in_flight: Vec<InFlight>,
    owed: Vec<Owed>,
    waiting: VecDeque<(CommandId, CommandMessage, Unanswered)>,
    /// Bounded by what is in flight: the owner drains it after every call.
    outputs: VecDeque<CommandOutput>,
}

impl Commands {
    /// Commands sent by `our`.
    pub fn new(our: Address, config: CommandConfig) -> Self {
        Self {
            our,
            config,
            round_trip: None,
            next_id: 0,
            in_flight: Vec::new(),
            owed: Vec::new(),
            waiting: VecDeque::new(),
            outputs: VecDeque::new(),
        }
    }

    /// Sets the round trip of the link, to which timeouts adapt.
    pub fn set_round_trip(&mut self, round_trip: Option<Duration>) {
        self.round_trip = round_trip;
    }

    fn timeout(&self) -> Duration {
        self.config.timeout.max(self.round_trip.map_or(Duration::ZERO, |round_trip| round_trip * 2))
    }

    /// Sends a command, at once or when the same MAV_CMD in flight has ended.
    ///
    /// # Errors
    /// [`Busy`] when it must not wait, or when too many do.
    pub fn submit(
        &mut self,
        message: CommandMessage,
        unanswered: Unanswered,
        when_busy: WhenBusy,
        now: MonoTime,
    ) -> Result<CommandId, Busy> {
        let is_same = |other: &CommandMessage| key(other) == key(&message);
        let is_busy = self.in_flight.iter().any(|flight| is_same(&flight.message))
            || self.waiting.iter().any(|(_, waiting, _)| is_same(waiting));
        self.owed.retain(|owed| now < owed.until);
        let must_wait = is_busy || self.is_held(&message);
        if is_busy && when_busy == WhenBusy::Refuse || must_wait && self.waiting.len() >= MAX_WAITING {
            return Err(Busy);
        }
        let id = CommandId(self.next_id);
        self.next_id += 1;
        if must_wait {
            self.waiting.push_back((id, message, unanswered));
        } else {
            self.start(id, message, unanswered, now);
        }
        Ok(id)
    }

    /// Whether an answer would be ambiguous between two commands.
    fn is_held(&self, message: &CommandMessage) -> bool {
        self.in_flight.iter().any(|flight| key(&flight.message) == key(message))
            || self.owed.iter().any(|owed| (owed.target, owed.command) == key(message))
    }

    fn start(&mut self, id: CommandId, message: CommandMessage, unanswered: Unanswered, now: MonoTime) {
        self.outputs.push_back(CommandOutput::Send(message.message(0)));
        self.in_flight.push(InFlight {
            id,
            message,
            unanswered,
            attempts: 1,
            asked: false,
            has_changed_form: false,
            in_progress_since: None,
            first_sent: now,
            last_sent: now,
            deadline: now + self.timeout(),
        });
    }

    /// Starts commands that waited for one that ended.
    fn start_waiting(&mut self, now: MonoTime) {
        while let Some(index) = self.waiting.iter().position(|(_, message, _)| !self.is_held(message)) {
            let Some((id, message, unanswered)) = self.waiting.remove(index) else { return };
            self.start(id, message, unanswered, now);
        }
    }

    /// Reads an acknowledgement. One that is not for us, or not from the target, is ignored.
    pub fn on_ack(&mut self, from: Address, ack: &CommandAck, now: MonoTime) {
        if !is_for(ack.target, self.our) {
            return;
        }
        let timeout = self.timeout();
        let Some(index) = self
            .in_flight
            .iter()
            .position(|flight| flight.message.command().0 == ack.command && is_for(flight.message.target(), from))
        else {
            return self.on_owed(from, ack, now);
        };
        let result = CommandResult(ack.result);
        let flight = &mut self.in_flight[index];
        if result == CommandResult::IN_PROGRESS {
            let since = *flight.in_progress_since.get_or_insert(now);
            flight.deadline = (now + self.config.progress_timeout).min(since + self.config.progress_limit);
            let percent = (ack.progress <= 100).then_some(ack.progress);
            self.outputs.push_back(CommandOutput::Progress { id: flight.id, percent });
            return;
        }
        let wants_other_form = match flight.message {
            CommandMessage::Int(_) => {
                result == CommandResult::UNSUPPORTED || result == CommandResult::COMMAND_LONG_ONLY
            }
            CommandMessage::Long(_) => result == CommandResult::COMMAND_INT_ONLY,
        };
        if wants_other_form
            && !flight.has_changed_form
            && let Some(other) = flight.message.other_form()
        {
            flight.message = other;
            flight.has_changed_form = true;
            flight.attempts = 1;
            (flight.first_sent, flight.last_sent) = (now, now);
            flight.deadline = now + timeout;
            self.outputs.push_back(CommandOutput::Send(other.message(0)));
            return;
        }
        if flight.attempts > 1 && flight.unanswered == Unanswered::Repeat {
            let answers = flight.attempts - 1;
            self.owe(index, answers, now);
        }
        let outcome = CommandOutcome::Answered { result, result_param2: ack.result_param2 };
        self.finish(index, outcome, now);
    }

    /// The next equal command waits for these answers to one in flight, which ends: they would be taken for its own.
    fn owe(&mut self, index: usize, answers: u32, now: MonoTime) {
        let flight = &self.in_flight[index];
        let (target, command) = key(&flight.message);
        let until = now + rest_of_answers(flight, self.round_trip, now);
        self.owed.push(Owed { target, command, answers, until });
    }

    /// A further answer to a command that ended before.
    fn on_owed(&mut self, from: Address, ack: &CommandAck, now: MonoTime) {
        let is_it = |owed: &&mut Owed| owed.command.0 == ack.command && is_for(owed.target, from);
        if let Some(owed) = self.owed.iter_mut().find(is_it)
            && CommandResult(ack.result) != CommandResult::IN_PROGRESS
        {
            owed.answers -= 1;
            self.owed.retain(|owed| owed.answers > 0);
            self.start_waiting(now);
        }
    }

    fn finish(&mut self, index: usize, outcome: CommandOutcome, now: MonoTime) {
        let flight = self.in_flight.remove(index);
        self.outputs.push_back(CommandOutput::Finished { id: flight.id, outcome });
        self.start_waiting(now);
    }

    /// Lets time pass.
    pub fn on_time(&mut self, now: MonoTime) {
        let timeout = self.timeout();
        self.owed.retain(|owed| now < owed.until);
        self.start_waiting(now);
        let mut index = 0;
        while index < self.in_flight.len() {
            let flight = &mut self.in_flight[index];
            if now < flight.deadline {
                index += 1;
                continue;
            }
            let may_repeat = flight.in_progress_since.is_none() && flight.attempts < self.config.attempts;
            match flight.unanswered {
                Unanswered::Repeat if may_repeat => {
                    flight.attempts += 1;
                    flight.last_sent = now;
                    flight.deadline = now + timeout;
                    let confirmation = confirmation(flight.attempts);
                    self.outputs.push_back(CommandOutput::Send(flight.message.message(confirmation)));
                    index += 1;
                }
                Unanswered::Ask if may_repeat && !flight.asked => {
                    flight.asked = true;
                    flight.deadline = now + ASK_WAIT;
                    self.outputs.push_back(CommandOutput::Unanswered { id: flight.id });
                    index += 1;
                }
                _ => {
                    let attempts = flight.attempts;
                    self.owe(index, attempts, now);
                    self.finish(index, CommandOutcome::TimedOut { attempts }, now);
                }
            }
        }
    }

    /// Sends a command again, when the owner has read that it was not executed.
    pub fn repeat(&mut self, id: CommandId, now: MonoTime) {
        let timeout = self.timeout();
        if let Some(flight) = self.in_flight.iter_mut().find(|flight| flight.id == id) {
            flight.attempts += 1;
            flight.asked = false;
            flight.deadline = now + timeout;
            self.outputs.push_back(CommandOutput::Send(flight.message.message(confirmation(flight.attempts))));
        }
    }

    /// Drops a command: no more outputs for it. The vehicle may still execute it.
    pub fn forget(&mut self, id: CommandId, now: MonoTime) {
        self.waiting.retain(|(waiting, ..)| *waiting != id);
        if let Some(index) = self.in_flight.iter().position(|flight| flight.id == id) {
            self.owe(index, self.in_flight[index].attempts, now);
            self.in_flight.remove(index);
            self.start_waiting(now);
        }
        self.outputs.retain(|output| {
            !matches!(output, CommandOutput::Finished { id: other, .. } | CommandOutput::Progress { id: other, .. } if *other == id)
        });
    }

    /// When [`Self::on_time`] is wanted.
    pub fn deadline(&self) -> Option<MonoTime> {
        let held = self.owed.iter().filter(|_| !self.waiting.is_empty()).map(|owed| owed.until);
        self.in_flight.iter().map(|flight| flight.deadline).chain(held).min()
    }

    /// The next thing to do.
    pub fn poll_output(&mut self) -> Option<CommandOutput> {
        self.outputs.pop_front()
    }
}

/// How long after an answer further ones to the same command may come. An answer that comes sooner after the last
/// transmission than the one-way delay belongs to an earlier transmission: those to later ones come as far apart as
/// these were sent. Otherwise it belongs to the last one, and further answers are those that the link held up.
fn rest_of_answers(flight: &InFlight, round_trip: Option<Duration>, now: MonoTime) -> Duration {
    let way = round_trip.unwrap_or(ROUND_TRIP_UNKNOWN);
    let is_to_an_earlier = now.since(flight.last_sent) < way / 2;
    let apart = flight.last_sent.since(flight.first_sent);
    way + SLACK + if is_to_an_earlier { apart } else { Duration::ZERO }
}

/// The identity of a command in acknowledgements.
fn key(message: &CommandMessage) -> (Address, Command) {
    (message.target(), message.command())
}

/// `confirmation` counts the repetitions.
fn confirmation(attempts: u32) -> u8 {
    u8::try_from(attempts - 1).unwrap_or(u8::MAX)
}

/// Whether a target field reaches an address; 0 is everyone (and what MAVLink 1, which has no such field in an
/// acknowledgement, reads as).
fn is_for(target: Address, address: Address) -> bool {
    (target.system.0 == 0 || target.system == address.system)
        && (target.component.0 == 0 || target.component == address.component)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUR: Address = Address::new(255, 190);
    const PLANE: Address = Address::new(1, 1);

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    fn commands() -> Commands {
        Commands::new(OUR, CommandConfig::default())
    }

    fn interval() -> CommandMessage {
        CommandMessage::long(PLANE, Command::SET_MESSAGE_INTERVAL, [30.0, 100_000.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    fn arm() -> CommandMessage {
        CommandMessage::long(PLANE, Command::COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    fn ack(command: Command, result: CommandResult, progress: u8, target: Address) -> CommandAck {
        CommandAck { command: command.0, result: result.0, progress, result_param2: 0, target }
    }

    fn drain(commands: &mut Commands) -> Vec<CommandOutput> {
        std::iter::from_fn(|| commands.poll_output()).collect()
    }

    fn confirmations(outputs: &[CommandOutput]) -> Vec<u8> {
        outputs
            .iter()
            .filter_map(|output| match output {
                CommandOutput::Send(Message::CommandLong(long)) => Some(long.confirmation),
                _ => None,
            })
            .collect()
    }

    fn outcomes(outputs: &[CommandOutput]) -> Vec<CommandOutcome> {
        outputs
            .iter()
            .filter_map(|output| match output {
                CommandOutput::Finished { outcome, .. } => Some(*outcome),
                _ => None,
            })
            .collect()
    }

    #[test]
    fn an_idempotent_command_is_repeated_with_a_growing_confirmation_then_times_out() {
        let mut commands = commands();
        commands.submit(interval(), Unanswered::Repeat, WhenBusy::Refuse, at(0)).expect("free");
        let mut outputs = drain(&mut commands);
        let mut steps = 0;
        while let Some(deadline) = commands.deadline() {
            commands.on_time(deadline);
            outputs.extend(drain(&mut commands));
            steps += 1;
            assert!(steps < 20, "it ends");
        }
        assert_eq!(confirmations(&outputs), [0, 1, 2, 3, 4]);
        assert_eq!(outcomes(&outputs), [CommandOutcome::TimedOut { attempts: 5 }]);
    }

    #[test]
    fn arming_is_never_repeated_blindly() {
        assert!(!is_idempotent(Command::COMPONENT_ARM_DISARM));
        assert!(!is_idempotent(Command::NAV_TAKEOFF) && !is_idempotent(Command::PREFLIGHT_REBOOT_SHUTDOWN));
        let mut commands = commands();
        let id = commands.submit(arm(), Unanswered::Ask, WhenBusy::Refuse, at(0)).expect("free");
        commands.on_time(at(1_000));
        let outputs = drain(&mut commands);
        assert_eq!(confirmations(&outputs), [0]);
        assert_eq!(outputs.last(), Some(&CommandOutput::Unanswered { id }));
        commands.repeat(id, at(1_100));
        assert_eq!(confirmations(&drain(&mut commands)), [1]);
        // Asked again, not told what to do: one more wait, then it is over.
        commands.on_time(at(2_100));
        assert_eq!(drain(&mut commands), [CommandOutput::Unanswered { id }]);
        commands.on_time(at(4_600));
        assert_eq!(outcomes(&drain(&mut commands)), [CommandOutcome::TimedOut { attempts: 2 }]);
        assert_eq!(commands.deadline(), None);
    }

    // fault 21: foreign, late and doubled answers: one result
    #[test]
    fn foreign_and_late_acknowledgements_change_nothing() {
        let mut commands = commands();
        commands.submit(arm(), Unanswered::GiveUp, WhenBusy::Refuse, at(0)).expect("free");
        drain(&mut commands);
        let accepted = |target| ack(Command::COMPONENT_ARM_DISARM, CommandResult::ACCEPTED, 0, target);
        commands.on_ack(PLANE, &accepted(Address::new(254, 190)), at(1));
        commands.on_ack(PLANE, &accepted(Address::new(255, 191)), at(1));
        commands.on_ack(Address::new(2, 1), &accepted(OUR), at(1));
        commands.on_ack(Address::new(1, 154), &accepted(OUR), at(1));
        commands.on_ack(PLANE, &ack(Command::DO_SET_MODE, CommandResult::ACCEPTED, 0, OUR), at(1));
        assert_eq!(drain(&mut commands), []);
        // MAVLink 1 names nobody.
        commands.on_ack(PLANE, &accepted(Address::new(0, 0)), at(2));
        assert_eq!(outcomes(&drain(&mut commands)).len(), 1);
        commands.on_ack(PLANE, &accepted(OUR), at(3));
        assert_eq!(drain(&mut commands), [], "one result, whatever comes late or twice");
    }

    // fault 21: two answers, because it was sent twice: the second is not the next command's
    #[test]
    fn the_next_command_waits_for_what_the_repeated_one_is_still_answered() {
        let answer = |commands: &mut Commands, result, ms| {
            commands.on_ack(PLANE, &ack(Command::SET_MESSAGE_INTERVAL, result, 0, OUR), at(ms));
        };
        // Sent at 0 and at 1,000 ms; answered, and the next one wanted, some time after.
        let sent_twice = |answered_ms| {
            let mut commands = commands();
            commands.set_round_trip(Some(Duration::from_millis(200)));
            commands.submit(interval(), Unanswered::Repeat, WhenBusy::Refuse, at(0)).expect("free");
            commands.on_time(at(1_000));
            answer(&mut commands, CommandResult::ACCEPTED, answered_ms);
            assert_eq!(outcomes(&drain(&mut commands)).len(), 1);
            commands.submit(interval(), Unanswered::Repeat, WhenBusy::Refuse, at(answered_ms)).expect("none under way");
            assert_eq!(drain(&mut commands), [], "it waits");
            assert_eq!(commands.submit(interval(), Unanswered::Repeat, WhenBusy::Refuse, at(answered_ms)), Err(Busy));
            commands.submit(arm(), Unanswered::GiveUp, WhenBusy::Refuse, at(answered_ms)).expect("of another number");
            assert_eq!(confirmations(&drain(&mut commands)), [0]);
            commands
        };
        // The answer to the first sending came late, so will that to the second.
        let mut commands = sent_twice(1_050);
        answer(&mut commands, CommandResult::DENIED, 2_050);
        let outputs = drain(&mut commands);
        assert_eq!((confirmations(&outputs), outcomes(&outputs)), (vec![0], vec![]));
        answer(&mut commands, CommandResult::ACCEPTED, 2_200);
        assert_eq!(outcomes(&drain(&mut commands)).len(), 1);
        // The first sending, or its answer, was lost: only what the link held up can still come.
        let mut commands = sent_twice(1_200);
        commands.on_time(at(1_449));
        assert_eq!(drain(&mut commands), []);
        assert_eq!(commands.deadline(), Some(at(1_450)));
        commands.on_time(at(1_450));
        assert_eq!(confirmations(&drain(&mut commands)), [0]);
    }

    // fault 21: an answer after the end: the next command waits for it
    #[test]
    fn a_late_answer_to_what_was_given_up_is_not_the_next_command_s() {
        for times_out in [true, false] {
            let mut commands = commands();
            commands.set_round_trip(Some(Duration::from_millis(200)));
            let id = commands.submit(interval(), Unanswered::GiveUp, WhenBusy::Refuse, at(0)).expect("free");
            match times_out {
                true => commands.on_time(at(1_000)),
                false => commands.forget(id, at(1_000)),
            }
            drain(&mut commands);
            commands.submit(interval(), Unanswered::GiveUp, WhenBusy::Refuse, at(1_010)).expect("none under way");
            assert_eq!(drain(&mut commands), [], "it waits");
            commands.on_ack(PLANE, &ack(Command::SET_MESSAGE_INTERVAL, CommandResult::ACCEPTED, 0, OUR), at(1_100));
            let outputs = drain(&mut commands);
            assert_eq!((confirmations(&outputs), outcomes(&outputs)), (vec![0], vec![]));
        }
    }

    // fault 21: IN_PROGRESS for 5 minutes, then an end
    #[test]
    fn in_progress_lengthens_the_wait_up_to_a_limit() {
        let mut commands = commands();
        commands.submit(arm(), Unanswered::GiveUp, WhenBusy::Refuse, at(0)).expect("free");
        drain(&mut commands);
        let mut ms = 500;
        let mut reports = 0;
        let outputs = loop {
            commands.on_ack(PLANE, &ack(Command::COMPONENT_ARM_DISARM, CommandResult::IN_PROGRESS, 255, OUR), at(ms));
            ms += 20_000;
            commands.on_time(at(ms));
            let outputs = drain(&mut commands);
            assert!(matches!(outputs[0], CommandOutput::Progress { percent: None, .. }));
            reports += 1;
            if outputs.len() > 1 {
                break outputs;
            }
        };
        assert_eq!(outcomes(&outputs), [CommandOutcome::TimedOut { attempts: 1 }]);
        assert_eq!(reports, 15, "5 min at 20 s each");
    }

    #[test]
    fn one_of_a_number_at_a_time() {
        let mut commands = commands();
        commands.submit(arm(), Unanswered::GiveUp, WhenBusy::Refuse, at(0)).expect("free");
        for _ in 0..10 {
            assert_eq!(commands.submit(arm(), Unanswered::GiveUp, WhenBusy::Refuse, at(0)), Err(Busy));
        }
        assert_eq!(confirmations(&drain(&mut commands)), [0]);
        // Those that may wait follow one after the other, and not more than a few.
        for _ in 0..MAX_WAITING {
            commands.submit(arm(), Unanswered::GiveUp, WhenBusy::Wait, at(0)).expect("waits");
        }
        assert_eq!(commands.submit(arm(), Unanswered::GiveUp, WhenBusy::Wait, at(0)), Err(Busy));
        commands.on_ack(PLANE, &ack(Command::COMPONENT_ARM_DISARM, CommandResult::DENIED, 0, OUR), at(5));
        let outputs = drain(&mut commands);
        assert_eq!(outcomes(&outputs), [CommandOutcome::Answered { result: CommandResult::DENIED, result_param2: 0 }]);
        assert_eq!(confirmations(&outputs), [0], "the next one");
    }

    #[test]
    fn a_form_is_changed_only_where_it_means_the_same() {
        let int = |x| {
            CommandMessage::Int(CommandInt {
                target: PLANE,
                frame: 3,
                command: Command::DO_REPOSITION.0,
                current: 0,
                autocontinue: 0,
                params: [1.0, 2.0, 3.0, 4.0],
                x,
                y: 0,
                z: 0.0,
            })
        };
        let unsupported = ack(Command::DO_REPOSITION, CommandResult::UNSUPPORTED, 0, OUR);
        let mut commands = commands();
        commands.submit(int(403_332_000), Unanswered::Repeat, WhenBusy::Refuse, at(0)).expect("free");
        commands.on_ack(PLANE, &unsupported, at(10));
        assert_eq!(outcomes(&drain(&mut commands)).len(), 1, "a position does not fit");

        commands.submit(int(0), Unanswered::Repeat, WhenBusy::Refuse, at(20)).expect("free");
        commands.on_ack(PLANE, &unsupported, at(30));
        let outputs = drain(&mut commands);
        assert_eq!(outcomes(&outputs), []);
        let Some(CommandOutput::Send(Message::CommandLong(long))) = outputs.last() else { panic!("{outputs:?}") };
        assert_eq!(long.params, [1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0]);
        commands.on_ack(PLANE, &unsupported, at(40));
        assert_eq!(outcomes(&drain(&mut commands)).len(), 1, "and it ends there");
    }

    #[test]
    fn slow_links_are_waited_for() {
        let mut commands = commands();
        commands.set_round_trip(Some(Duration::from_secs(2)));
        commands.submit(interval(), Unanswered::Repeat, WhenBusy::Refuse, at(0)).expect("free");
        assert_eq!(commands.deadline(), Some(at(4_000)));
    }

    #[test]
    fn a_forgotten_command_says_nothing_more() {
        let mut commands = commands();
        let id = commands.submit(arm(), Unanswered::GiveUp, WhenBusy::Refuse, at(0)).expect("free");
        commands.submit(arm(), Unanswered::GiveUp, WhenBusy::Wait, at(0)).expect("waits");
        drain(&mut commands);
        commands.forget(id, at(1));
        assert_eq!(drain(&mut commands), []);
        let until = commands.deadline().expect("its answer may still come");
        assert!(until < at(1_000), "{until:?}");
        commands.on_time(until);
        assert_eq!(confirmations(&drain(&mut commands)), [0], "the next one starts");
    }

    #[test]
    fn names_are_shown() {
        assert_eq!(numbered(Command::COMPONENT_ARM_DISARM), "COMPONENT_ARM_DISARM (400)");
        assert_eq!(numbered(Command::DO_LAND_START), "DO_LAND_START (189)");
        assert_eq!(numbered(Command(60_000)), "command 60000");
        assert_eq!(CommandResult::FAILED.to_string(), "failed (MAV_RESULT_FAILED, 4)");
    }
}
