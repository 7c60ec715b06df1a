//! Settings with which delays on a busy computer do not count as faults of robot or sensor.

use softdock_app::settings::BoardSettings;
use softdock_experiments::scenario::Scenario;
use toml_edit::{DocumentMut, Table, de, ser};

/// Sets all limits in cycles or seconds to their largest values, with further settings of the links to the sensor, of RSI and
/// of the control.
macro_rules! patience {
    (link: $link:literal, rsi: $rsi:literal, control: $control:literal) => {
        concat!(
            "\n[can]\nanswer_timeout_s = 1.0\n",
            $link,
            "[ethercat]\nanswer_timeout_s = 1.0\n",
            $link,
            "[rsi]\nrobot_ip = \"any\"\nsilence_s = 60.0\n",
            $rsi,
            "[control.robot]\nlate_answers_fault = 1000000\nlost_telegrams_fault = 1000000\n",
            "[control.sensor]\nstale_after_cycles = 100\nfault_after_cycles = 1000\nfrozen_after_cycles = 0\n",
            $control,
        )
    };
}

/// For a board whose robot and sensor wait until it has answered: it polls its sensor as often as possible, and waits as long
/// as possible.
pub const PATIENCE: &str = patience!(link: "poll_period_s = 0.0005\n", rsi: "", control: "");

/// For a computer on which the sensor may be asked late, so that a reading repeats. Without a delay law, as the peers' robots
/// do not follow as the predictor expects.
pub const BUSY_COMPUTER: &str = patience!(
    link: "sample_wait_s = 0.002\n",
    rsi: "new_run_after_lost = 1000000\n",
    control: "[control.limits]\nclamp_fault_cycles = 10000\n[control.delay]\nlaw = \"none\"\n"
);

/// The given settings, with those of [`PATIENCE`].
///
/// # Panics
/// If the result is not valid.
pub fn patient(settings: &BoardSettings) -> BoardSettings {
    let read = |text: &str| text.parse::<DocumentMut>().expect("TOML");
    let mut all = read(&ser::to_string_pretty(settings).expect("settings are TOML"));
    replace(all.as_table_mut(), read(PATIENCE).as_table());
    de::from_document(all).expect("settings of a board")
}

/// A scenario with a noiseless sensor, and a board that accepts readings that repeat: the sensed force does not depend on how
/// often, or over which link, the sensor is asked.
pub fn without_noise(mut scenario: Scenario) -> Scenario {
    scenario.board.control.sensor.frozen_after_cycles = 0;
    let sensor = &mut scenario.rig.sensor;
    (sensor.noise_force_n, sensor.noise_torque_nm) = (0.0, 0.0);
    scenario
}

/// Replaces values by those with the same names.
fn replace(table: &mut Table, by: &Table) {
    for (key, item) in by {
        match (
            table.get_mut(key).and_then(|t| t.as_table_mut()),
            item.as_table(),
        ) {
            (Some(inner), Some(by)) => replace(inner, by),
            _ => table[key] = item.clone(),
        }
    }
}
