//! The unit of a setting, from the end of its name.

/// Name suffixes with their units; a longer suffix precedes a shorter one in which it ends.
const ENDS: &[(&str, &str)] = &[
    ("_rad_s2", "rad/s²"),
    ("_mm_s2", "mm/s²"),
    ("_m_s2", "m/s²"),
    ("_rad_s", "rad/s"),
    ("_mm_s", "mm/s"),
    ("_m_s", "m/s"),
    ("_n_per_m", "N/m"),
    ("_n_s_per_m", "N·s/m"),
    ("_kg_m2", "kg·m²"),
    ("_n_m", "N·m"),
    ("_rad", "rad"),
    ("_kg", "kg"),
    ("_hz", "Hz"),
    ("_mm", "mm"),
    ("_m", "m"),
    ("_n", "N"),
    ("_s", "s"),
    ("_cycles", "cycles"),
    ("_counts", "counts"),
    ("_bits", "bits"),
    ("_decimals", "decimals"),
    // A wrench: three forces, three torques.
    ("bias", "N, N·m"),
];

/// The unit; empty if there is none.
pub(super) fn of(field: &str) -> &'static str {
    ENDS.iter()
        .find(|(end, _)| field.ends_with(end))
        .map_or("", |(_, unit)| unit)
}
