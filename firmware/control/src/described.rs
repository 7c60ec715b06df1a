//! Descriptions of settings: the doc comments of their fields, kept for clients that ask a board for them.

/// The doc comments of a struct's fields.
#[derive(Clone, Copy, Debug)]
pub struct Description {
    /// Name of the struct.
    pub name: &'static str,
    /// Name and doc comment of each field; the comment's lines end with a line break.
    pub fields: &'static [(&'static str, &'static str)],
}

/// Wraps a struct of settings and keeps the doc comments of its fields as `DESCRIPTION`. The struct itself stays as it is
/// written.
///
/// Each field may also have its default. With the dotted name of the struct, it may have a range that does not depend on other
/// fields.
///
/// ```
/// softdock_control::described! {
/// /// A spring.
/// #[derive(Default)]
/// pub struct Spring {
///     /// Stiffness, N/m.
///     pub stiffness_n_per_m: f64,
/// }
/// }
/// let fields = Spring::DESCRIPTION.fields;
/// assert_eq!(fields, [("stiffness_n_per_m", " Stiffness, N/m.\n")]);
///
/// softdock_control::described! {
/// /// A damper.
/// pub struct Damper: "contact.damper" {
///     /// Damping, N·s/m.
///     pub damping_n_s_per_m: f64 = 20.0 => 0.0..=1e6,
///     /// It only pushes.
///     pub one_way: bool = true,
/// }
/// }
/// let mut damper = Damper::default();
/// assert!(damper.one_way && damper.check_ranges().is_ok());
/// damper.damping_n_s_per_m = -1.0;
/// let error = damper.check_ranges().unwrap_err();
/// assert_eq!(error.field, "contact.damper.damping_n_s_per_m");
/// ```
#[macro_export]
macro_rules! described {
    (
        $(#[$about:meta])*
        pub struct $name:ident: $place:literal {
            $($(#[doc = $line:literal])* pub $field:ident: $type:ty = $default:expr $(=> $range:expr)?,)*
        }
    ) => {
        $crate::described! {
            $(#[$about])*
            pub struct $name {
                $($(#[doc = $line])* pub $field: $type = $default,)*
            }
        }

        impl $name {
            /// Checks every field that has a range of its own; the first that does not fit is the error.
            pub fn check_ranges(&self) -> Result<(), $crate::range::SettingsError> {
                $($($crate::range::Ranged::check(
                    &self.$field, concat!($place, ".", stringify!($field)), $range,
                )?;)?)*
                Ok(())
            }
        }
    };
    (
        $(#[$about:meta])*
        pub struct $name:ident {
            $($(#[doc = $line:literal])* pub $field:ident: $type:ty = $default:expr,)*
        }
    ) => {
        $crate::described! {
            $(#[$about])*
            pub struct $name {
                $($(#[doc = $line])* pub $field: $type,)*
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }
    };
    (
        $(#[$about:meta])*
        pub struct $name:ident {
            $($(#[doc = $line:literal])* pub $field:ident: $type:ty,)*
        }
    ) => {
        $(#[$about])*
        pub struct $name {
            $($(#[doc = $line])* pub $field: $type,)*
        }

        impl $name {
            /// The doc comments of the fields.
            pub const DESCRIPTION: $crate::described::Description = $crate::described::Description {
                name: stringify!($name),
                fields: &[$((stringify!($field), concat!($($line, "\n"),*))),*],
            };
        }
    };
}
