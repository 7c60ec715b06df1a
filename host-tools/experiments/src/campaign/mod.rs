//! Campaigns: one scenario under thousands of conditions, on one machine or on many.
//!
//! ```text
//! campaign.toml   file          what varies, its distribution, and limits of the outcomes
//! plan.json       plan          the campaign and the scenario, complete; row(index) is a pure function of it
//!   design, distribution        from an index to numbers between 0 and 1, and from these to values
//!   setting                     puts values into the scenario, by dotted names
//! a row           row, outcome  one run without recording, or a row of a benchmark (bench); failures and panics are outcomes
//! a part          shard         every N-th row
//!   carry_out, journal          computes rows in parallel, with a journal to continue from; a part is complete or absent
//!   place                       the folder or the object store with the plan and the parts
//! the table       merge         all parts, row by row, or an error that says what is missing
//! the report      results       access to the rows
//!   summary, page               success, limits (limit_results), quantiles, worst rows, which factor matters
//! ```

pub mod bench;
pub mod carry_out;
mod checksum;
pub mod columns;
pub mod design;
pub mod distribution;
pub mod file;
pub mod journal;
pub mod limit_results;
pub mod merge;
pub mod outcome;
pub mod page;
pub mod place;
pub mod plan;
pub mod results;
pub mod row;
pub mod setting;
pub mod shard;
pub mod statistics;
pub mod status;
pub mod stored;
pub mod submit;
pub mod summary;
pub mod table;
