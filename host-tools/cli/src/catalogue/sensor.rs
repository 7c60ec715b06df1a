//! Pictures of the sensor's effects: what is read of a wrench.

use super::excitation::{
    BOUNCE_S, Excitation, SLIDE_S, STEP_S, bounce, instants, slide, tilts, wall_push,
};
use super::picture::Picture;
use super::size::Size;
use anyhow::{Result, bail};
use nalgebra::{Rotation3, Vector3};
use softdock_analysis::statistics::RandomStream;
use softdock_control::effects::sensor::base_tilt::BaseTilt;
use softdock_control::effects::sensor::ft_bias::Bias;
use softdock_control::effects::sensor::ft_bias_drift::BiasDrift;
use softdock_control::effects::sensor::ft_crosstalk::{self, Crosstalk};
use softdock_control::effects::sensor::ft_dropout::Dropout;
use softdock_control::effects::sensor::ft_latency::Latency;
use softdock_control::effects::sensor::ft_low_pass::LowPass;
use softdock_control::effects::sensor::ft_mounting::Mounting;
use softdock_control::effects::sensor::ft_quantisation::WrenchQuantisation;
use softdock_control::effects::sensor::ft_saturation::ForceSaturation;
use softdock_control::effects::sensor::ft_scale::Scale;
use softdock_control::effects::sensor::tool_com_error::ToolComError;
use softdock_control::effects::sensor::tool_gravity::ToolGravity;
use softdock_control::effects::sensor::tool_inertia::{LoadMotion, ToolInertia};
use softdock_control::effects::sensor::tool_mass_error::ToolMassError;
use softdock_control::frames::Wrench;

/// The tool that hangs on the sensor: mass, kg, and centre of mass, m.
const TOOL_KG: f64 = 5.0;
const TOOL_COM_M: [f64; 3] = [0.0, 0.0, 0.1];
/// Gravity in the room, m/s².
const GRAVITY_M_S2: [f64; 3] = [0.0, 0.0, -9.81];
/// Components of a wrench.
const AXES: [&str; 6] = ["fx", "fy", "fz", "tx", "ty", "tz"];
/// Offsets of the components, as parameters.
const OFFSETS: [&str; 6] = ["fx_n", "fy_n", "fz_n", "tx_n_m", "ty_n_m", "tz_n_m"];
/// Steps between two readings of a slow bus: 8 ms.
const STEPS_PER_READING: u32 = 16;
/// Samples that the delay line of a picture can hold.
const SAMPLES: usize = 512;

/// From the wrench to what is read of it.
type Reading = Box<dyn FnMut(&Wrench<f64>) -> Wrench<f64>>;

pub(super) fn picture(id: &str, size: &Size) -> Result<Picture> {
    match id {
        "base_tilt" | "tool_mass_error" | "ft_mounting" | "ft_scale" => {
            let error = tilt_error(id, size)?;
            let force = |c_from_s: &Rotation3<f64>| error(c_from_s).force.x;
            Ok(tilt_sweep(size, "error of the force fx [N]", force))
        }
        "tool_com_error" => {
            let error = tilt_error(id, size)?;
            let torque = |c_from_s: &Rotation3<f64>| error(c_from_s).torque.y;
            Ok(tilt_sweep(size, "error of the torque ty [N m]", torque))
        }
        "tool_inertia" => inertia(size),
        "ft_bias" | "ft_bias_drift" => still_log(id, size),
        "ft_crosstalk" => crosstalk(size),
        _ => in_a_bounce(id, size),
    }
}

/// From the sensor's orientation to the error of the wrench.
type TiltError = Box<dyn Fn(&Rotation3<f64>) -> Wrench<f64>>;

fn tilt_error(id: &str, size: &Size) -> Result<TiltError> {
    let tool = ToolGravity::new(TOOL_KG, &TOOL_COM_M)?;
    let down = Vector3::from(GRAVITY_M_S2);
    Ok(match id {
        "base_tilt" => {
            let [rx, ry] = size.all(["rx_rad", "ry_rad"]);
            let change = BaseTilt::new(rx, ry)?.gravity(&down) - down;
            Box::new(move |c_from_s| tool.wrench(&(c_from_s.inverse() * change)))
        }
        "tool_mass_error" => {
            let error = ToolMassError::new(size.get("mass_error_kg"), &TOOL_COM_M)?;
            Box::new(move |c_from_s| error.wrench(&(c_from_s.inverse() * down)))
        }
        "tool_com_error" => {
            let error = size.all(["com_x_m", "com_y_m", "com_z_m"]);
            let error = ToolComError::new(&error, TOOL_KG)?;
            Box::new(move |c_from_s| error.wrench(&(c_from_s.inverse() * down)))
        }
        "ft_mounting" => {
            let sensor = Mounting::new(&size.all(["rx_rad", "ry_rad", "rz_rad"]))?;
            misread(tool, move |w| sensor.apply(w))
        }
        "ft_scale" => {
            let sensor = Scale::new(&size.all(AXES))?;
            misread(tool, move |w| sensor.apply(w))
        }
        other => bail!("the sensor's effect `{other}` has no picture"),
    })
}

/// Error of a sensor that misreads the tool's weight.
fn misread(
    tool: ToolGravity<f64>,
    read: impl Fn(&Wrench<f64>) -> Wrench<f64> + 'static,
) -> TiltError {
    Box::new(move |c_from_s| {
        let weight = tool.wrench(&(c_from_s.inverse() * Vector3::from(GRAVITY_M_S2)));
        read(&weight) - weight
    })
}

/// An error while the sensor turns about its y axis.
fn tilt_sweep(size: &Size, label: &'static str, error: impl Fn(&Rotation3<f64>) -> f64) -> Picture {
    let at = |tilt| error(&Rotation3::from_axis_angle(&Vector3::y_axis(), tilt));
    Picture::new(
        Excitation::TiltSweep,
        size,
        ["tilt about y [rad]", label],
        [
            tilts().map(|tilt| (tilt, 0.0)).collect(),
            tilts().map(|tilt| (tilt, at(tilt))).collect(),
        ],
    )
}

fn inertia(size: &Size) -> Result<Picture> {
    let tool = ToolInertia::new(size.get("mass_kg"), &TOOL_COM_M, &[[0.0; 3]; 3])?;
    let force = |t: f64| {
        let motion = LoadMotion {
            acceleration: Vector3::new(slide(t).acceleration, 0.0, 0.0),
            angular_velocity: Vector3::zeros(),
            angular_acceleration: Vector3::zeros(),
        };
        tool.wrench(&motion).force.x
    };
    Ok(Picture::new(
        Excitation::Slide,
        size,
        ["time [s]", "force fx [N]"],
        [
            instants(SLIDE_S).map(|t| (t, 0.0)).collect(),
            instants(SLIDE_S).map(|t| (t, force(t))).collect(),
        ],
    ))
}

fn still_log(id: &str, size: &Size) -> Result<Picture> {
    let offsets = size.all(OFFSETS);
    let force: Box<dyn Fn(f64) -> f64> = if id == "ft_bias" {
        let sensor = Bias::new(&offsets)?;
        Box::new(move |_| sensor.apply(&Wrench::zero()).force.x)
    } else {
        let sensor = BiasDrift::<f64>::new(&offsets, size.get("time_constant_s"))?;
        Box::new(move |t| sensor.at(t).force.x)
    };
    let seconds = || (0..=600).map(|k| f64::from(k) * 0.1);
    Ok(Picture::new(
        Excitation::StillLog,
        size,
        ["time [s]", "force fx [N]"],
        [
            seconds().map(|t| (t, 0.0)).collect(),
            seconds().map(|t| (t, force(t))).collect(),
        ],
    ))
}

/// The contact's force, and the copy of it on another axis.
fn crosstalk(size: &Size) -> Result<Picture> {
    let mut coupling = [[0.0; 6]; 6];
    for (i, parameter) in ft_crosstalk::EFFECT.parameters.iter().enumerate() {
        let (row, column) = ft_crosstalk::row_and_column(i);
        coupling[row][column] = size.get(parameter.name);
    }
    let sensor = Crosstalk::new(&coupling)?;
    let across = |t: f64| sensor.apply(&contact(t)).force.y;
    Ok(Picture::new(
        Excitation::Bounce,
        size,
        ["time [s]", "force fy across the contact [N]"],
        [
            instants(BOUNCE_S).map(|t| (t, 0.0)).collect(),
            instants(BOUNCE_S).map(|t| (t, across(t))).collect(),
        ],
    ))
}

/// The contact's wrench in a bounce.
fn contact(time_s: f64) -> Wrench<f64> {
    Wrench::of(&[wall_push(bounce(time_s).position), 0.0, 0.0, 0.0, 0.0, 0.0])
}

fn in_a_bounce(id: &str, size: &Size) -> Result<Picture> {
    let mut sensor = reading(id, size)?;
    let mut read = |t: f64| sensor(&contact(t)).force.x;
    let without = instants(BOUNCE_S).map(|t| (t, contact(t).force.x));
    Ok(Picture::new(
        Excitation::Bounce,
        size,
        ["time [s]", "force fx [N]"],
        [
            without.collect(),
            instants(BOUNCE_S).map(|t| (t, read(t))).collect(),
        ],
    ))
}

fn reading(id: &str, size: &Size) -> Result<Reading> {
    Ok(match id {
        "ft_low_pass" => {
            let mut sensor = LowPass::new(size.get("time_constant_s"), STEP_S)?;
            Box::new(move |w| sensor.advance(w))
        }
        "ft_saturation" => {
            let sensor = ForceSaturation::new(size.get("limit_n"))?;
            Box::new(move |w| sensor.apply(w))
        }
        "ft_quantisation" => {
            let [force, torque] = size.all(["lsb_force_n", "lsb_torque_n_m"]);
            let sensor = WrenchQuantisation::new(force, torque)?;
            Box::new(move |w| sensor.apply(w))
        }
        "ft_latency" => {
            let mut sensor = Latency::<f64, SAMPLES>::new(size.get("latency_s"), STEP_S)?;
            Box::new(move |w| sensor.advance(w))
        }
        "ft_dropout" => dropout(size.get("held_share"))?,
        other => bail!("the sensor's effect `{other}` has no picture"),
    })
}

/// Readings of a slow bus, some of them lost.
fn dropout(held_share: f64) -> Result<Reading> {
    let (mut sensor, mut noise) = (Dropout::new(held_share)?, RandomStream::new(1, 0));
    let (mut step, mut last) = (0, Wrench::zero());
    Ok(Box::new(move |w| {
        if step % STEPS_PER_READING == 0 {
            last = sensor.advance(w, noise.uniform());
        }
        step += 1;
        last
    }))
}
