//! The robot's telegram, `<Rob>`: read by the board, written by a simulated robot.

use core::fmt::{self, Write};

use super::fields::{self, AXES, Content, SixAxes, set_once};
use super::scan::Token;
use super::writer::Writer;
use super::{Field, RobTelegram, RsiError, Tags};
use crate::decimal::Decimal;

/// Reads a telegram of the robot.
///
/// The order of elements and attributes, white space, quotes, and elements that are not asked for do not matter. A
/// telegram with only an `IPOC`, as RSI 2 may send first, is complete.
///
/// # Errors
/// Whatever is not a complete, unambiguous telegram with finite numbers. If [`salvage_ipoc`] finds a time stamp, the
/// telegram can still be answered.
pub fn parse_rob(bytes: &[u8], tags: &Tags) -> Result<RobTelegram, RsiError> {
    let mut rob = Rob {
        tags,
        ipoc: None,
        actual_pose: SixAxes::new(Field::ActualPose),
        setpoint_pose: SixAxes::new(Field::SetpointPose),
        late_answers: None,
        poscorr_stat: None,
    };
    fields::read(bytes, b"Rob", &mut rob)?;
    Ok(RobTelegram {
        ipoc: rob.ipoc.ok_or(RsiError::Missing { field: Field::Ipoc })?,
        actual_pose: rob.actual_pose.finish()?,
        setpoint_pose: rob.setpoint_pose.finish()?,
        late_answers: rob.late_answers,
        poscorr_stat: rob.poscorr_stat,
    })
}

/// What has been read so far.
struct Rob<'t> {
    tags: &'t Tags,
    ipoc: Option<u64>,
    actual_pose: SixAxes<f64>,
    setpoint_pose: SixAxes<f64>,
    late_answers: Option<u32>,
    poscorr_stat: Option<u32>,
}

impl Content for Rob<'_> {
    /// `Type` or `TYPE` says nothing that matters.
    fn root_attribute(&mut self, _name: &[u8], _value: Token<'_>) -> Result<(), RsiError> {
        Ok(())
    }

    fn open(&mut self, element: &[u8], at: usize) -> Result<(), RsiError> {
        match element {
            b"RIst" => self.actual_pose.open(at),
            b"RSol" => self.setpoint_pose.open(at),
            _ => Ok(()),
        }
    }

    fn attribute(&mut self, element: &[u8], name: &[u8], value: Token<'_>) -> Result<(), RsiError> {
        match (element, name) {
            (b"RIst", axis) => self.actual_pose.set(axis, value, fields::number),
            (b"RSol", axis) => self.setpoint_pose.set(axis, value, fields::number),
            (b"Delay", b"D") => {
                let field = Field::LateAnswers;
                let count = fields::count(value, field)?;
                set_once(&mut self.late_answers, count, field, value.at)
            }
            _ => Ok(()),
        }
    }

    fn text(&mut self, element: &[u8], text: Token<'_>) -> Result<(), RsiError> {
        if element == b"IPOC" {
            let ipoc = fields::ipoc(text)?;
            return set_once(&mut self.ipoc, ipoc, Field::Ipoc, text.at);
        }
        if self
            .tags
            .poscorr_stat
            .is_some_and(|name| name.as_bytes() == element)
        {
            let field = Field::PoscorrStat;
            let stat = fields::count(text, field)?;
            return set_once(&mut self.poscorr_stat, stat, field, text.at);
        }
        Ok(())
    }
}

/// The time stamp of a telegram that [`parse_rob`] refuses, if there is exactly one and it is whole.
///
/// With it a malformed telegram can still be answered with zero, so that the robot does not count a lost answer.
/// Whatever begins like the element counts as one, since a comment or a declaration may quote a whole time stamp
/// beside the telegram's own that is written with white space.
pub fn salvage_ipoc(bytes: &[u8]) -> Option<u64> {
    const NAME: &[u8] = b"<IPOC";
    const CLOSE: &[u8] = b"</IPOC>";
    let mut names = bytes
        .windows(NAME.len())
        .enumerate()
        .filter(|(_, window)| *window == NAME)
        .map(|(start, _)| start + NAME.len());
    let (Some(name_end), None) = (names.next(), names.next()) else {
        return None;
    };
    let rest = bytes.get(name_end..)?.strip_prefix(b">")?;
    let len = rest
        .windows(CLOSE.len())
        .position(|window| window == CLOSE)?;
    let token = Token {
        bytes: rest.get(..len)?,
        at: name_end + 1,
    };
    fields::ipoc(token).ok()
}

/// Writes a telegram as the robot does, with `decimals` digits behind the point (its `Precision`), and returns its
/// length.
///
/// Elements that are `None` are left out; so is POSCORR's `Stat` if `tags` has no name for it.
///
/// # Errors
/// [`RsiError::NotRepresentable`] for a pose that is not finite, [`RsiError::BufferTooSmall`].
pub fn write_rob(
    telegram: &RobTelegram,
    decimals: u8,
    tags: &Tags,
    out: &mut [u8],
) -> Result<usize, RsiError> {
    let actual_pose = decimal_pose(telegram.actual_pose, decimals, Field::ActualPose)?;
    let setpoint_pose = decimal_pose(telegram.setpoint_pose, decimals, Field::SetpointPose)?;
    let mut writer = Writer::new(out);
    let available = writer.capacity();
    let mut write = || -> fmt::Result {
        writer.write_str("<Rob Type=\"KUKA\">")?;
        if let Some(pose) = actual_pose {
            writer.write_axes(b"RIst", &pose)?;
        }
        if let Some(pose) = setpoint_pose {
            writer.write_axes(b"RSol", &pose)?;
        }
        if let Some(late) = telegram.late_answers {
            write!(writer, "<Delay D=\"{late}\"/>")?;
        }
        if let (Some(name), Some(stat)) = (tags.poscorr_stat, telegram.poscorr_stat) {
            write!(writer, "<{name}>{stat}</{name}>")?;
        }
        writer.write_ipoc(telegram.ipoc)?;
        writer.write_str("</Rob>")
    };
    write().map_err(|fmt::Error| RsiError::BufferTooSmall { available })?;
    Ok(writer.len())
}

fn decimal_pose(
    pose: Option<[f64; 6]>,
    decimals: u8,
    field: Field,
) -> Result<Option<[Decimal; 6]>, RsiError> {
    let Some(pose) = pose else {
        return Ok(None);
    };
    let mut text = [Decimal::zero(decimals); AXES.len()];
    for (decimal, value) in text.iter_mut().zip(pose) {
        *decimal =
            Decimal::from_f64(value, decimals).map_err(|_| RsiError::NotRepresentable { field })?;
    }
    Ok(Some(text))
}
