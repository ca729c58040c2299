//! What moves the object in a rollout.

use trundle_model::{Clock, Glide, Plant, State};

/// Something that says where a wrench brings the object: a model's laws, or what was learnt without any.
pub trait Dynamics: Sync {
    /// Move a state on by `dt`, s, under `applied`, `[N, N, N·m]`, object axes about the object origin, which is held
    /// and turns with the object.
    fn step(&self, state: &mut State<f64>, applied: &[f64; 3], clock: Clock, dt: f64);

    /// The same for steps of one length, solved beforehand; `None` where that cannot be.
    fn glide(&self, _dt: f64) -> Option<Glide> {
        None
    }
}

impl Dynamics for Plant<f64> {
    #[inline]
    fn step(&self, state: &mut State<f64>, applied: &[f64; 3], clock: Clock, dt: f64) {
        self.move_roughly(state, applied, clock, dt);
    }

    fn glide(&self, dt: f64) -> Option<Glide> {
        Plant::glide(self, dt)
    }
}

impl<D: Dynamics + ?Sized> Dynamics for &D {
    #[inline]
    fn step(&self, state: &mut State<f64>, applied: &[f64; 3], clock: Clock, dt: f64) {
        (**self).step(state, applied, clock, dt);
    }

    fn glide(&self, dt: f64) -> Option<Glide> {
        (**self).glide(dt)
    }
}
