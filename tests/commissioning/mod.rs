//! Parameters, calibration, identification, and the way from a box to the first docking test.

mod calibrate_live;
mod doctor_live;
mod doctor_recording;
mod from_box_to_docking;
mod identify_actuator;
mod jog_live;
mod params;
mod params_line;
