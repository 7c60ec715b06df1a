//! All cases. Adding one is adding an entry to a list here.

mod contact;
mod feedback;
mod headline;
mod robot;
mod space;

use super::case::Case;

/// All cases, the headline first.
pub fn all() -> Vec<Case> {
    let mut cases = headline::cases();
    cases.extend(robot::cases());
    cases.extend(contact::cases());
    cases.extend(feedback::cases());
    cases.extend(space::cases());
    cases
}

/// The quick benchmark: fewer cases, fewer touches.
pub fn quick() -> Vec<Case> {
    let mut cases: Vec<Case> = all().into_iter().filter(|case| case.quick).collect();
    for case in &mut cases {
        case.touches = case.touches.min(4);
        case.speeds_mm_s.retain(|v| [1.0, 5.0, 15.0].contains(v));
    }
    cases
}
