//! What goes wrong, in virtual time: robot, sensor, commands in the wrong mode, any input.

mod any_input;
mod contact;
mod jog;
mod modes;
mod robot;
mod sensor;
mod settings;
mod virtual_board;
