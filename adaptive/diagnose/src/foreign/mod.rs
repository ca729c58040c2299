//! Diagnosis of anyone's simulator: where it and a recording differ, and which law was left out of it.
//!
//! The simulator is a function ([`Simulator`]); its calls are dear, it gives no derivatives, and nothing is known of what
//! is in it. So it is called along the motion that was seen, where it is replaced by what it is to first order in the
//! state, the wrench and its parameters ([`linear`]). A Kalman filter over that ([`gains`]) judges what is left as for our own
//! simulation: by the force sensor's noise, the tare's error and the tracker's noise. Laws are added to the
//! wrench ([`law`]); trying one costs no call. Figures are made by the simulator itself ([`rollout`]).

mod answer;
mod gains;
mod hunt;
mod law;
mod likelihood;
mod linear;
mod nominal;
mod path;
mod rollout;
mod simulator;
mod told;

pub use answer::diagnose;
pub use simulator::{Foreign, Simulator};

#[cfg(test)]
mod tests;
