//! A model to start from, for a log that came without one.

use super::model_text::commented;
use softdock_app::record::CycleRecord;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::signals::{Signals, VelocityMeaning};
use softdock_physics::model::{Axis, FilterModel, Model};
use softdock_statistics::{LowPassed, Noise, noise_floor};

/// What nobody but the user knows, ahead of the model. `turns`: the one axis that moves is a rotation.
fn to_fill_in(turns: bool) -> String {
    let moved = match turns {
        false => "mass_kg       what the sensor carries, or the moved mass of a driven axis",
        true => {
            "inertia_kg_m2   of what turns; mass_kg and com_m of a weight that hangs off the axis"
        }
    };
    format!(
        "\
# A model to start from. Axes and noise are those of the log; the rest is for you to fill in:
#   [tool] {moved}; then
#          dynamic_compensation = true
#   [sensor] gravity_m_s2   [0, 0, 0] on a horizontal axis; wrench = \"commanded\" for a motor's force,
#            \"unscaled\" where its scale to newtons is a guess
#   [actuator], [[contact.walls]]   what is known of the drive and of what is touched
#   [tolerance]          how well all of these are known
# examples/model.toml has every key.
#
"
    )
}

/// The text of a `model.toml`: the axes that move, the noise that the log shows, and the filter through
/// which the log went.
///
/// # Errors
///
/// A recording without cycles or a rising time.
pub fn starter(recording: &Recording, filter: Option<FilterModel>) -> anyhow::Result<String> {
    let signals = Signals::new(recording)?;
    let cycles = recording.cycles.as_slice();
    let of_poses = match signals.velocity {
        VelocityMeaning::CycleMean => Noise::Differenced,
        VelocityMeaning::Sampled => Noise::White,
    };
    let mut model = Model::default();
    let velocity = |c: &CycleRecord| c.trace.executed_velocity;
    let pose = |c: &CycleRecord| {
        let [x, y, z, _, qx, qy, qz] = c.trace.pose;
        // For a small angle the rotation vector is twice the vector part.
        [x, y, z, 2.0 * qx, 2.0 * qy, 2.0 * qz]
    };
    let sent = |c: &CycleRecord| c.trace.sent_velocity;
    let moves = |axis: &Axis| {
        let changes = |of: &dyn Fn(&CycleRecord) -> [f64; 6]| {
            let i = axis.index();
            cycles
                .windows(2)
                .any(|pair| (of(&pair[1])[i] - of(&pair[0])[i]).abs() > 0.0)
        };
        changes(&velocity) || changes(&sent)
    };
    model.rig.active_axes = Axis::ALL.into_iter().filter(moves).collect();
    model.sensor.filter = filter;
    let filter = filter.map(|filter| filter.on_samples(signals.cycle_s));
    let floors = |of: &dyn Fn(&CycleRecord) -> [f64; 6], noise| floors(cycles, of, noise, filter);
    let noise = &mut model.noise;
    let [force, torque] = floors(&|c| c.inputs.sensor.wrench, Noise::White);
    let [speed, rate] = floors(&velocity, of_poses);
    let [position, angle] = floors(&pose, Noise::White);
    for (of_model, of_log) in [
        (&mut noise.force_n, force),
        (&mut noise.torque_n_m, torque),
        (&mut noise.velocity_m_s, speed),
        (&mut noise.rate_rad_s, rate),
        (&mut noise.position_m, position),
        (&mut noise.angle_rad, angle),
    ] {
        // What the digits of the log hide is no noise of zero.
        *of_model = of_log.filter(|floor| *floor > 0.0).unwrap_or(*of_model);
    }
    let origin = recording
        .header
        .identity
        .trim_start_matches("imported from ");
    let text = commented(&model, origin);
    Ok(to_fill_in(model.bearing().is_some()) + &text)
}

/// Largest noise floor of the three translations and of the three rotations, two digits.
fn floors(
    cycles: &[CycleRecord],
    of: &dyn Fn(&CycleRecord) -> [f64; 6],
    noise: Noise,
    filter: Option<LowPassed>,
) -> [Option<f64>; 2] {
    /// Smaller parts of the largest value are round-off.
    const ROUND_OFF: f64 = 1e-12;
    let floor = |i: usize| {
        let values: Vec<f64> = cycles.iter().map(|c| of(c)[i]).collect();
        let largest = values
            .iter()
            .fold(0.0_f64, |largest, v| largest.max(v.abs()));
        noise_floor(&values, noise, filter).filter(|floor| *floor > ROUND_OFF * largest)
    };
    [0..3, 3..6].map(|axes| {
        let largest = axes.filter_map(floor).fold(0.0, f64::max);
        format!("{largest:.1e}").parse().ok()
    })
}
