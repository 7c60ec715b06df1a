//! Codes and words of the enumerations in a recording. The words stand in CSV files, the codes
//! in messages; both are part of the format and never change their meaning.

use softdock_control::delay::status::ConfidenceLevel;
use softdock_control::jog::Jog;
use softdock_control::modes::{Command, FaultCode, Mode, Refusal};

/// A value that is recorded as one of several words.
pub(super) trait Word: Sized {
    /// All words; the index of a word is its code.
    const WORDS: &'static [&'static str];

    fn code(self) -> u8;
    /// `None` if the code has no word.
    fn from_code(code: u8) -> Option<Self>;
}

/// Connects each value with its code and its word. A value that is missing here does not compile.
macro_rules! words {
    ($type:ty { $($code:literal $word:literal $value:path,)+ }) => {
        impl Word for $type {
            const WORDS: &'static [&'static str] = &[$($word),+];

            fn code(self) -> u8 {
                match self {
                    $($value => $code,)+
                }
            }
            fn from_code(code: u8) -> Option<Self> {
                match code {
                    $($code => Some($value),)+
                    _ => None,
                }
            }
        }
    };
    ($type:ty, none { $($code:literal $word:literal $value:path $([$of:path])?,)+ }) => {
        impl Word for Option<$type> {
            const WORDS: &'static [&'static str] = &["none", $($word),+];

            fn code(self) -> u8 {
                match self {
                    None => 0,
                    $(Some($value $(($of))?) => $code,)+
                }
            }
            fn from_code(code: u8) -> Option<Self> {
                match code {
                    0 => Some(None),
                    $($code => Some(Some($value $(($of))?)),)+
                    _ => None,
                }
            }
        }
    };
}

words! { Mode {
    0 "idle" Mode::Idle,
    1 "hold" Mode::Hold,
    2 "armed" Mode::Armed,
    3 "running" Mode::Running,
    4 "fault" Mode::Fault,
    5 "jogging" Mode::Jogging,
} }

words! { ConfidenceLevel {
    0 "no_ladder" ConfidenceLevel::NotAssessed,
    1 "watching" ConfidenceLevel::Unverified,
    2 "identifying" ConfidenceLevel::Verified,
    3 "leading" ConfidenceLevel::Fallback,
} }

words! { Command, none {
    1 "hold" Command::Hold,
    2 "arm" Command::Arm,
    3 "start" Command::Start,
    4 "stop" Command::Stop,
    5 "reset" Command::Reset,
    6 "zero" Command::Zero,
    7 "jog_x" Command::Jog[Jog::X],
    8 "jog_y" Command::Jog[Jog::Y],
    9 "jog_z" Command::Jog[Jog::Z],
    10 "jog_a" Command::Jog[Jog::A],
    11 "jog_b" Command::Jog[Jog::B],
    12 "jog_c" Command::Jog[Jog::C],
    13 "jog_minus_x" Command::Jog[Jog::MinusX],
    14 "jog_minus_y" Command::Jog[Jog::MinusY],
    15 "jog_minus_z" Command::Jog[Jog::MinusZ],
    16 "jog_minus_a" Command::Jog[Jog::MinusA],
    17 "jog_minus_b" Command::Jog[Jog::MinusB],
    18 "jog_minus_c" Command::Jog[Jog::MinusC],
} }

words! { Refusal, none {
    1 "wrong_mode" Refusal::WrongMode,
    2 "sensor_stale" Refusal::SensorStale,
    3 "sensor_unhealthy" Refusal::SensorUnhealthy,
    4 "no_pose" Refusal::NoPose,
    5 "force_too_large" Refusal::ForceTooLarge,
    6 "orientation_singular" Refusal::OrientationSingular,
    7 "still_moving" Refusal::StillMoving,
    8 "moved_since_armed" Refusal::MovedSinceArmed,
    9 "too_few_samples" Refusal::TooFewSamples,
    10 "no_room" Refusal::NoRoom,
} }

words! { FaultCode, none {
    1 "sensor_stale" FaultCode::SensorStale,
    2 "sensor_frozen" FaultCode::SensorFrozen,
    3 "sensor_status" FaultCode::SensorStatus,
    4 "sensor_saturated" FaultCode::SensorSaturated,
    5 "overload" FaultCode::Overload,
    6 "contact_at_start" FaultCode::ContactAtStart,
    7 "numeric" FaultCode::Numeric,
    8 "telegrams_lost" FaultCode::TelegramsLost,
    9 "robot_restarted" FaultCode::RobotRestarted,
    10 "late_answers" FaultCode::LateAnswers,
    11 "sustained_clamp" FaultCode::SustainedClamp,
    12 "pose_lost" FaultCode::PoseLost,
    13 "actuator_unlike" FaultCode::ActuatorUnlike,
} }

#[cfg(test)]
mod tests {
    use super::*;

    fn check<T: Word>() {
        let codes = 0..=u8::MAX;
        let known: Vec<u8> = codes.filter(|c| T::from_code(*c).is_some()).collect();
        assert_eq!(known.len(), T::WORDS.len());
        for (place, code) in known.into_iter().enumerate() {
            assert_eq!(usize::from(code), place);
            assert_eq!(T::from_code(code).map(T::code), Some(code));
        }
    }

    #[test]
    fn a_code_is_the_place_of_its_word() {
        check::<Mode>();
        check::<ConfidenceLevel>();
        check::<Option<Command>>();
        check::<Option<Refusal>>();
        check::<Option<FaultCode>>();
    }

    #[test]
    fn commands_are_recorded_with_the_words_that_an_operator_types() {
        for (word, command) in Command::WORDS {
            let code = usize::from(Some(command).code());
            // In a schema words are identifiers.
            let name = word.replace(' ', "_").replace('-', "minus_");
            assert_eq!(<Option<Command>>::WORDS[code], name);
        }
    }
}
