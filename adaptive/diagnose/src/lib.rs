//! Where a simulation and a recording differ: locate it, name what was left out, or say that
//! nothing known explains it.
//!
//! [`diagnose`] fits the simulation under test, asks every effect of the catalogue what it would gain, fits those that
//! promise most, keeps what the evidence demands and what holds up block by block, and writes the answer in the form of
//! `trundle-diagnosis/1`.

mod adequacy;
mod answer;
pub mod black_box;
mod candidates;
mod confirm;
mod cross_validation;
pub mod design;
mod discrepancy;
mod engine;
mod enough;
mod ground;
mod lack_of_fit;
mod locate;
mod naming;
mod nominal;
mod outlook;
mod periods;
mod place;
mod platt;
mod predictions;
mod proposals;
mod rivals;
mod run;
mod screen;
mod search;
mod series;
mod stages;
mod subset;
mod thresholds;
mod touch;
mod units;
mod verdict;
mod warnings;
mod whole;
mod words;

#[cfg(test)]
#[path = "../../infer/tests/common/mod.rs"]
mod common;

pub use answer::Answer;
pub use lack_of_fit::{LackOfFit, lack_of_fit};
pub use nominal::for_recording;
pub use platt::platt;
pub use predictions::{Predictions, predict};
pub use run::{Options, Outcome, diagnose, diagnose_recording};
pub use series::Series;
pub use stages::STAGES;
