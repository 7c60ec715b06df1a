//! Cost of mathematical functions on this processor, in ticks of the counter.

use core::hint::black_box;
use micromath::F32Ext;
use softdock_lockstep::{CALLS, Counter, FUNCTIONS, FunctionCosts, LIBRARIES};

/// Ticks for [`CALLS`] calls of each function in each library.
pub(super) fn costs(counter: &mut impl Counter) -> FunctionCosts {
    const { assert!(FUNCTIONS.len() == 4 && LIBRARIES.len() == 3) };
    [
        [
            single(counter, |x, _| F32Ext::sqrt(x)),
            single(counter, |x, _| libm::sqrtf(x)),
            double(counter, |x, _| libm::sqrt(x)),
        ],
        [
            single(counter, |x, _| F32Ext::sin(x)),
            single(counter, |x, _| libm::sinf(x)),
            double(counter, |x, _| libm::sin(x)),
        ],
        [
            single(counter, F32Ext::atan2),
            single(counter, libm::atan2f),
            double(counter, libm::atan2),
        ],
        [
            single(counter, |x, _| F32Ext::log10(x)),
            single(counter, |x, _| libm::log10f(x)),
            double(counter, |x, _| libm::log10(x)),
        ],
    ]
}

/// Ticks of calls in single precision, without those of the loop.
fn single(counter: &mut impl Counter, f: impl Fn(f32, f32) -> f32) -> u32 {
    ticks(counter, f).saturating_sub(ticks(counter, |x, _| x))
}

/// Ticks of calls in double precision, without those of the loop and of the conversions.
fn double(counter: &mut impl Counter, f: impl Fn(f64, f64) -> f64) -> u32 {
    let both = |x: f32, y: f32| (f64::from(x), f64::from(y));
    let empty = ticks(counter, |x, y| black_box(both(x, y)).0);
    let full = ticks(counter, |x, y| {
        let (x, y) = black_box(both(x, y));
        f(x, y)
    });
    full.saturating_sub(empty)
}

/// Ticks of the calls, with the loop around them.
fn ticks<T>(counter: &mut impl Counter, f: impl Fn(f32, f32) -> T) -> u32 {
    let begin = counter.count();
    for n in 0..CALLS {
        // From 0.1 to 3.1.
        let x = 0.1 + 0.003 * n as f32;
        black_box(f(black_box(x), black_box(1.0)));
    }
    counter.count().wrapping_sub(begin)
}
