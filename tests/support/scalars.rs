//! One generic check, three tests: `f64`, `f32` and 64-bit fixed point, each with its tolerance.

pub use softdock_control::scalar::Fixed;

/// Writes three tests, one per scalar type, from each generic function `check::<S>(tolerance)`, or from `check::<S>()` if
/// nothing is rounded.
///
/// ```text
/// in_three_scalars! {
///     /// Why these tolerances.
///     name: check => f64 1e-12, f32 1e-4, fixed 1e-6
///     other_name: exact_check
/// }
/// ```
#[macro_export]
macro_rules! in_three_scalars {
    () => {};
    (
        $(#[$doc:meta])*
        $name:ident: $check:ident => f64 $f64:expr, f32 $f32:expr, fixed $fixed:expr
        $(, $($rest:tt)*)?
    ) => {
        $crate::in_three_scalars! { @one $(#[$doc])* $name $check ($f64) ($f32) ($fixed) }
        $crate::in_three_scalars! { $($($rest)*)? }
    };
    ($(#[$doc:meta])* $name:ident: $check:ident $(, $($rest:tt)*)?) => {
        $crate::in_three_scalars! { @one $(#[$doc])* $name $check () () () }
        $crate::in_three_scalars! { $($($rest)*)? }
    };
    (@one $(#[$doc:meta])* $name:ident $check:ident
        ($($f64:expr)?) ($($f32:expr)?) ($($fixed:expr)?)) => {
        $(#[$doc])*
        mod $name {
            #[test]
            fn f64() {
                super::$check::<f64>($($f64)?);
            }
            #[test]
            fn f32() {
                super::$check::<f32>($($f32)?);
            }
            #[test]
            fn fixed() {
                super::$check::<$crate::scalars::Fixed>($($fixed)?);
            }
        }
    };
}
