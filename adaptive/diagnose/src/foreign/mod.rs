//! Anyone's simulator as the simulation under test.
//!
//! The simulator is a function ([`Simulator`]); its calls are dear, it gives no derivatives, and nothing is known of what
//! is in it. So it is called along the motion that was seen, where it is replaced by what it is to first order in the
//! state, the wrench and its parameters ([`linear`]). A Kalman filter over that ([`gains`]) judges what is left as for our own
//! simulation: by the force sensor's noise, the tare's error and the tracker's noise. Laws are added to the
//! wrench ([`law`]), also those with states of their own ([`own_states`]); trying one costs no call. Figures are made by the simulator itself ([`rollout`]). Search, decision
//! and answer are those of any diagnosis ([`crate::engine`]).

mod black_box;
mod derivatives;
mod engine;
mod experiment;
mod felt;
mod figures;
mod fitting;
mod gains;
mod law;
mod likelihood;
mod linear;
mod nominal;
mod own_states;
mod path;
mod rollout;
mod simulator;
mod view;
mod windows;

use crate::run::{Options, Outcome, diagnose_with};
use trundle_infer::{InferError, Watch};
use trundle_record::Dataset;

pub(crate) use black_box::Basis;
pub use simulator::{Foreign, Simulator};

/// Diagnose a recording that a foreign simulator is to reproduce.
///
/// # Errors
/// When there is not enough data, the simulator fails, or the user interrupts.
pub fn diagnose(
    data: &Dataset,
    foreign: &Foreign<'_>,
    seed: u64,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    let engine = black_box::BlackBox::new(data, foreign, seed, watch)?;
    diagnose_with(&engine, &Options { seed, ..Options::default() }, watch)
}

#[cfg(test)]
mod tests;
