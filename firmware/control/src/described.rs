//! Descriptions of settings: the doc comments of their fields, kept for whoever asks a board.

/// The doc comments of a struct's fields.
#[derive(Clone, Copy, Debug)]
pub struct Description {
    /// Name of the struct.
    pub name: &'static str,
    /// Name and doc comment of each field; the comment's lines end with a line break.
    pub fields: &'static [(&'static str, &'static str)],
}

/// Put around a struct of settings, it keeps the doc comments of the fields as `DESCRIPTION`. The
/// struct itself stays as it is written.
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
/// ```
#[macro_export]
macro_rules! described {
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
