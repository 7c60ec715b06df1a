//! Messages between host and board.
//!
//! The settings of a board are changed in steps, so that it has either the old or the new set, intact, whatever happens in
//! between:
//!
//! ```text
//! Begin        a draft, equal to the settings in use
//! Set, Stage   change the draft: by name, or as a whole image
//! Validate     ranges, and what has to fit together
//! Commit       into flash; the board starts over and tries the new set
//! Confirm      keep it; a board that is not told within the time goes back to the old set
//! Abort        give up the draft, or end the trial at once
//! ```
//!
//! A host begins with a hello, which drops the draft of the host before, and from which its request numbers count. The board's
//! answer gives the conversation a number that no other conversation of this boot has, and with high probability none of another
//! boot. The board accepts a request only with that number, and only if its request number is one of the next. So a repeated old
//! frame (from the line, or from someone who recorded it, alone or with its hello) changes nothing.
//!
//! Messages do not depend on the settings: a name is a path like `control.sensor.tool_mass_kg`, a value has one of a few forms.
//! So a host program can read and change the settings of a firmware that is older or newer than itself.

use super::{FlashSlot, Health, LoopBack, Machine, SelfTest};
use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

/// Version of the protocol: that of all messages but [`Hello`].
pub const PROTOCOL: u8 = 2;
/// Most numbers of an array.
pub const ARRAY_MAX: usize = 16;
/// Most words that a setting may choose from.
pub const WORDS_MAX: usize = 16;
/// Longest line of the log, bytes.
pub const LINE_BYTES: usize = 120;
/// Most lines of the log in an answer.
pub const LINES_MAX: usize = 6;

/// A name of a mode, a fault or a state.
pub type Word = String<40>;
/// A sentence for a person.
pub type Text = String<200>;

/// Identity of the board. Its form never changes, except that fields may be added at the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello<'a> {
    /// Version of the protocol that the board speaks.
    pub protocol: u8,
    /// Schema of its settings: which form a whole image has.
    pub schema: u32,
    /// A number that differs from boot to boot.
    pub boot: u32,
    /// Firmware, git hash and board.
    pub identity: &'a str,
}

/// Requests of the host.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request<'a> {
    /// The setting with this number, from 0; [`Answer::End`] behind the last one.
    List(u16),
    /// The value of a setting that is in use.
    Get(&'a str),
    /// A part of the image of the settings in use, from this byte.
    Image(u16),
    /// Makes a draft of the settings in use.
    Begin,
    /// Changes the draft.
    Set {
        /// Path of the setting.
        path: &'a str,
        /// Its value.
        value: Value<'a>,
    },
    /// A part of a whole image for the draft.
    Stage {
        /// Where it begins.
        offset: u16,
        /// The part.
        bytes: &'a [u8],
    },
    /// Checks the draft; a staged image becomes the draft.
    Validate,
    /// Writes the draft and starts over to try it.
    Commit {
        /// Time for [`Request::Confirm`] from the restart on, s.
        confirm_within_s: u16,
    },
    /// Keeps the settings that are tried.
    Confirm,
    /// Ends a trial, or gives up the draft.
    Abort,
    /// Makes a draft of the settings before the present ones.
    Previous,
    /// The present state.
    Status,
    /// Counters since boot.
    Counters,
    /// Lines of the log from this number on.
    Log(u32),
    /// A command of the operator: hold, arm, start, stop, reset, zero, or jog with an axis (`jog x`,
    /// `jog -x`).
    Mode(&'a str),
    /// How robot and sensor are at this instant. Boards of older firmware cannot read it.
    Health,
    /// Content of the two slots of the flash. Boards of older firmware cannot read it.
    Slots,
    /// State of the board itself. Boards of older firmware cannot read it.
    Machine,
    /// A part of the test at the first power-on. Boards of older firmware cannot read it.
    SelfTest(SelfTest),
}

/// Answers of the board.
#[allow(
    clippy::large_enum_variant,
    reason = "nothing is allocated; it is made, sent and forgotten"
)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Answer<'a> {
    /// It is done.
    Done,
    /// There is no setting with this number.
    End,
    /// A setting.
    #[serde(borrow)]
    Entry(Entry<'a>),
    /// A value.
    Value(Value<'a>),
    /// A part of an image.
    Image {
        /// Length of the whole image.
        length: u16,
        /// The part.
        bytes: &'a [u8],
    },
    /// The board starts over now.
    Restarting,
    /// The present state.
    Status(Status),
    /// Counters since boot.
    Counters(Counters),
    /// Lines of the log, the oldest first; none: there are no more.
    Log(Vec<LogLine, LINES_MAX>),
    /// It is not done.
    Refused(Refusal),
    /// How robot and sensor are.
    Health(Health),
    /// Content of the two slots of the flash.
    Slots([FlashSlot; 2]),
    /// State of the board itself.
    Machine(Machine),
    /// Result of [`SelfTest::Can`]; `None`: there is no CAN controller that can do it, or it is busy.
    LoopBack(Option<LoopBack>),
}

/// A value of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Value<'a> {
    /// Yes or no.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    /// A real number.
    Real(f64),
    /// One of the words that the setting knows, or a text.
    Text(&'a str),
    /// Numbers; a matrix row by row.
    Array(Vec<f64, ARRAY_MAX>),
}

/// Which values a setting takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Form {
    /// Yes or no.
    Flag,
    /// A whole number.
    Whole,
    /// A real number.
    Real,
    /// One of several words.
    Word,
    /// A text.
    Text,
    /// Numbers in rows; a vector is one row.
    Array {
        /// Rows.
        rows: u8,
        /// Numbers in a row.
        columns: u8,
    },
}

/// A setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry<'a> {
    /// Number of settings.
    pub of: u16,
    /// Its name.
    pub path: &'a str,
    /// Which values it takes.
    pub form: Form,
    /// The value in use.
    pub value: Value<'a>,
    /// The default value.
    pub default: Value<'a>,
    /// Smallest and largest value of a number, given the other settings in use.
    pub range: Option<(f64, f64)>,
    /// The words that it may be.
    #[serde(borrow)]
    pub words: Vec<&'a str, WORDS_MAX>,
    /// Unit; empty: none.
    pub unit: &'a str,
    /// What it means: the lines of its description.
    pub help: &'a str,
}

/// Where the settings in use come from.
#[allow(
    clippy::large_enum_variant,
    reason = "nothing is allocated; it is made, sent and forgotten"
)]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Origin {
    /// From flash, for good.
    Flash {
        /// Number of the set.
        sequence: u32,
    },
    /// On trial: they are given up if nobody confirms them.
    Trial {
        /// Number of the set.
        sequence: u32,
        /// Time that is left, s.
        left_s: u16,
    },
    /// The firmware's defaults, because there are no others that can be used.
    Defaults {
        /// Why.
        reason: Text,
    },
}

/// State of a board.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Time since boot, ms.
    pub uptime_ms: u64,
    /// Where the settings come from.
    pub origin: Origin,
    /// There is a draft.
    pub draft: bool,
    /// Mode of the controller.
    pub mode: Word,
    /// The robot moves or may begin to: settings cannot be committed.
    pub moves: bool,
    /// The robot sends telegrams.
    pub robot: bool,
    /// State of the sensor's driver; empty: not started.
    pub sensor: Word,
    /// The latched fault: name, expected, received.
    pub fault: Option<(Word, f64, f64)>,
    /// The last refused command and why, until one is accepted.
    pub refusal: Option<(Word, Word)>,
    /// Commands that were carried out or refused since boot.
    pub commands: u32,
}

/// Counters since boot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Cycles that were answered.
    pub cycles: u64,
    /// Telegrams that came twice.
    pub duplicates: u32,
    /// Telegrams missing in the sequence.
    pub lost: u32,
    /// Telegrams that could not be read.
    pub malformed: u32,
    /// Datagrams of other senders.
    pub foreign: u32,
    /// Telegrams overtaken by a newer one.
    pub overtaken: u32,
    /// RSI runs.
    pub runs: u32,
    /// Sensor: requests without answer.
    pub sensor_timeouts: u32,
    /// Sensor: requests that were repeated.
    pub sensor_retries: u32,
    /// Sensor: answers that came too late.
    pub sensor_late: u32,
    /// Sensor: frames without their partner.
    pub sensor_unpaired: u32,
    /// Sensor: frames that are not the sensor's.
    pub sensor_unknown: u32,
    /// Sensor: frames that could not be read.
    pub sensor_invalid: u32,
    /// Times that the CAN controller went bus-off.
    pub bus_offs: u32,
    /// Times that the CAN controller lost frames.
    pub can_losses: u32,
    /// Service: frames that were read.
    pub frames: u32,
    /// Service: frames that were damaged on the line.
    pub damaged_frames: u32,
}

/// A line of the board's log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogLine {
    /// Its number since boot.
    pub number: u32,
    /// Time since boot, ms.
    pub at_ms: u64,
    /// What happened.
    pub text: String<LINE_BYTES>,
}

/// Why something was not done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum Refusal {
    /// The request cannot be read.
    #[error("the board cannot read the request")]
    Unreadable,
    /// The request is of no conversation that the board is in.
    #[error(
        "the request is of no conversation that the board is in: it started over, another program talks to it, or the line repeats itself; begin anew"
    )]
    NoConversation,
    /// No setting has this name.
    #[error("the board has no setting of this name")]
    UnknownName,
    /// The setting takes another kind of value.
    #[error("the setting takes another kind of value")]
    WrongForm,
    /// The setting does not know this word, or the text is too long.
    #[error("the setting does not know this word, or the text is longer than 32 bytes")]
    UnknownWord,
    /// The whole number has no room in the setting.
    #[error(
        "the number is outside of what the setting can hold (`softdock params list` shows its range)"
    )]
    TooLarge,
    /// The settings do not pass their checks.
    #[error("{0}")]
    Settings(Text),
    /// The robot moves, or is armed.
    #[error(
        "the robot moves or is armed: settings cannot change now; `softdock params mode hold` first"
    )]
    Moves,
    /// There is no draft: begin first.
    #[error("there is no draft")]
    NoDraft,
    /// Settings are on trial: confirm or abort them first.
    #[error("other settings are on trial: confirm or roll them back first")]
    OnTrial,
    /// Nothing is on trial.
    #[error("nothing is on trial: the time to confirm was over, or the board started over")]
    NotOnTrial,
    /// There are no settings before the present ones.
    #[error("the board has no settings before the present ones")]
    NoPrevious,
    /// Flash cannot be written; the settings are as they were.
    #[error("the board's flash cannot be written: {0}; its settings are as they were")]
    Flash(Text),
    /// No command of the operator.
    #[error("no command of the operator")]
    UnknownCommand,
    /// The robot sends no telegrams; a command would be dropped with its next run.
    #[error("the robot sends no telegrams; start RSI first")]
    NoRobot,
    /// Too many commands wait already.
    #[error("too many commands wait already")]
    Busy,
    /// The board runs on defaults because it has no usable settings: it is not to be armed.
    #[error("the board has no usable settings and runs on defaults: upload settings first")]
    Unconfigured,
    /// It is not said who the robot is: whoever sends first would move.
    #[error(
        "`rsi.robot_ip` is empty, so whoever sends first would be the robot: set its address, or \"any\" if that is meant"
    )]
    AnyRobot,
    /// The request is none of the next of this conversation: an old frame that came again.
    #[error(
        "the request has the number of an earlier one: another program talks to the board, or the line repeats itself; begin anew"
    )]
    OldRequest,
}
