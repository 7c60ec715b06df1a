//! From logs to verdicts: import, compare, diagnose, and recorded data of real machines.

mod command;
mod compare_regimes;
mod docking_hypotheses;
mod docking_mechanism;
mod drive;
mod each_log;
mod free_simulation;
mod hidden_effects;
mod import_checks;
mod import_command;
mod import_docking_rig_log;
mod import_examples;
mod import_mapping;
mod import_mistakes;
mod import_time;
mod import_turns;
mod joint;
mod joint_friction;
mod load_cell;
mod messages;
mod one_place;
mod own_hypothesis;
mod parts_of_logs;
mod real_data;
mod tables;
mod valve;
