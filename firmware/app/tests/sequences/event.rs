//! Events that may happen between two checks of the mode.

use crate::rig::Rig;
use crate::table::Column;
use softdock_control::jog::Jog;
use softdock_control::modes::Command;
use softdock_link::rsi::RobTelegram;

/// An event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Event {
    /// With valid data.
    Command(Command),
    /// With a gauge at the limit of its range.
    Blind(Command),
    /// With a reading that is too old to be integrated, but not so old that it is a fault.
    Stale(Command),
    Quiet,
    NewRun,
    Lost(u64),
    PoseGone,
    LateAnswers,
    Clamps,
    Twice,
    Unreadable,
    Garbage,
    Stranger,
    Status,
    Saturated,
    NotANumber,
    Overload,
    NoSample,
    Silent,
    Frozen,
    Contact,
}

/// Commands that need valid data.
const DEMANDING: [Command; 4] = [
    Command::Arm,
    Command::Start,
    Command::Reset,
    Command::Jog(Jog::X),
];

const COMMANDS: [Command; 7] = [
    Command::Hold,
    Command::Arm,
    Command::Start,
    Command::Stop,
    Command::Reset,
    Command::Zero,
    Command::Jog(Jog::X),
];

impl Event {
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let others = [
            Self::Quiet,
            Self::NewRun,
            Self::Lost(0),
            Self::Lost(3),
            Self::Lost(12),
            Self::PoseGone,
            Self::LateAnswers,
            Self::Clamps,
            Self::Twice,
            Self::Unreadable,
            Self::Garbage,
            Self::Stranger,
            Self::Status,
            Self::Saturated,
            Self::NotANumber,
            Self::Overload,
            Self::NoSample,
            Self::Silent,
            Self::Frozen,
            Self::Contact,
        ];
        let commands = COMMANDS.into_iter().map(Self::Command);
        commands
            .chain(DEMANDING.map(Self::Blind))
            .chain(DEMANDING.map(Self::Stale))
            .chain(others)
    }

    /// The column of the table for this event.
    pub(crate) fn column(self) -> Column {
        match self {
            Self::Command(command) => match command {
                Command::Hold => Column::Hold,
                Command::Arm => Column::Arm,
                Command::Start => Column::Start,
                Command::Stop => Column::Stop,
                Command::Reset => Column::Reset,
                Command::Zero => Column::Zero,
                Command::Jog(_) => Column::Jog,
            },
            Self::Quiet => Column::Quiet,
            Self::NewRun => Column::NewRun,
            Self::Lost(12) | Self::PoseGone | Self::LateAnswers => Column::Robot,
            Self::Blind(_)
            | Self::Status
            | Self::Saturated
            | Self::NotANumber
            | Self::Overload
            | Self::Silent
            | Self::Frozen => Column::Sensor,
            Self::Contact => Column::Contact,
            Self::Stale(_)
            | Self::Lost(_)
            | Self::Clamps
            | Self::Twice
            | Self::Unreadable
            | Self::Garbage
            | Self::Stranger
            | Self::NoSample => Column::Else,
        }
    }

    /// Applies the event to the rig.
    pub(crate) fn happen(self, rig: &mut Rig) {
        rig.moved = false;
        let as_ever = |_: &mut RobTelegram| {};
        match self {
            Self::Command(command) => {
                rig.sample(|_| {});
                rig.telegram(as_ever, Some(command));
            }
            Self::Blind(command) => {
                rig.sample(|sample| sample.saturated = true);
                rig.telegram(as_ever, Some(command));
            }
            Self::Stale(command) => {
                rig.cycle();
                (0..2).for_each(|_| rig.telegram(as_ever, None));
                rig.telegram(as_ever, Some(command));
                rig.cycle();
            }
            Self::Quiet => (0..64).for_each(|_| rig.cycle()),
            Self::NewRun => {
                rig.restart_robot();
                rig.cycle();
            }
            Self::Lost(count) => {
                rig.lose(count);
                rig.cycle();
            }
            Self::PoseGone => {
                rig.sample(|_| {});
                rig.telegram(|telegram| telegram.actual_pose = None, None);
            }
            Self::LateAnswers => {
                rig.late_answers += 26;
                rig.cycle();
            }
            Self::Clamps => {
                rig.sample(|_| {});
                rig.telegram(|telegram| telegram.poscorr_stat = Some(2), None);
            }
            Self::Twice => rig.repeat(),
            Self::Unreadable => rig.unreadable(),
            Self::Garbage => rig.garbage(),
            Self::Stranger => rig.stranger(),
            Self::NoSample => rig.telegram(as_ever, None),
            Self::Silent => (0..6).for_each(|_| rig.telegram(as_ever, None)),
            Self::Frozen => {
                for _ in 0..8 {
                    rig.sample(|sample| sample.counts = [7; 6]);
                    rig.telegram(as_ever, None);
                }
            }
            Self::Status => rig.spoiled(|sample| sample.status = 1),
            Self::Saturated => rig.spoiled(|sample| sample.saturated = true),
            Self::NotANumber => rig.spoiled(|sample| sample.wrench[1] = f64::NAN),
            Self::Overload => rig.spoiled(|sample| sample.wrench[2] = 3500.0),
            Self::Contact => rig.spoiled(|sample| sample.wrench[0] = -25.0),
        }
    }
}
