//! Experiments on the simulated rig.
//!
//! | module | |
//! |---|---|
//! | `scenario`, `run`, `spring_rod` | what is simulated |
//! | `one_contact`, `impacts`, `impact_table` | the contacts of a run, and their analytic counterparts |
//! | `demo`, `diagnosis`, `reproduce`, `rehearsal`, `jog_rehearsal`, `starter` | built-in runs |
//! | `check` | whether a loop with these settings is stable, and what its contacts would be |
//! | `campaign` | one scenario under thousands of conditions |
//! | `bench` | benchmarks of the delay laws and of the diagnosis, on independent plants and logs |

pub mod bench;
pub mod campaign;
pub mod check;
pub mod demo;
pub mod diagnosis;
pub mod impact_table;
pub mod impacts;
pub mod jog_rehearsal;
pub mod one_contact;
pub mod record_file;
pub mod rehearsal;
pub mod reproduce;
pub mod reproduce_page;
pub mod run;
pub mod scenario;
pub mod spring_rod;
pub mod starter;
