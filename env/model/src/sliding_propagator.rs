//! Rough steps of motion under viscous damping and dry friction, for planning.
//!
//! The linear part of a step is precomputed. Before it, each point with dry friction is slowed by half its friction, and after
//! it by the rest, or stopped (Strang 1968; projected Gauss-Seidel, Catto 2005). What a stopped point does not use before the
//! linear part is available after it.
//!
//! Only friction that is spread over the body is treated so: a single foot with a stiff wheel needs shorter steps.

use crate::{LinearPropagator, State};

/// Largest number of sweeps over the points. More than one are necessary only if a point stops.
const MAX_SWEEPS: usize = 6;
/// Largest number of points with dry friction.
const MAX_POINTS: usize = 8;

/// Precomputed rough step of a fixed length.
#[derive(Clone, Debug)]
pub struct SlidingPropagator {
    linear: LinearPropagator,
    points: Vec<SlidingPoint>,
}

/// A point with dry friction.
#[derive(Clone, Copy, Debug)]
struct SlidingPoint {
    /// Position relative to the mass centre, object axes, m.
    at: [f64; 2],
    /// Largest impulse of a step, N·s.
    impulse: f64,
    /// Effective mass at the point, `[xx, xy, yy]`, kg, and its smallest eigenvalue.
    mass: [f64; 3],
    smallest_mass: f64,
    inverse_mass: f64,
    inverse_inertia: f64,
}

impl SlidingPoint {
    fn new(at: [f64; 2], impulse: f64, mass: f64, inertia: f64) -> Self {
        let (inverse_mass, inverse_inertia) = (mass.recip(), inertia.recip());
        let [x, y] = at;
        let smallest_mass = 1.0 / (inverse_mass + (x * x + y * y) * inverse_inertia);
        // The inverse of `[[1/m + y²/I, −xy/I], [−xy/I, 1/m + x²/I]]`.
        let det = inverse_mass / smallest_mass;
        let [xx, xy, yy] = [
            inverse_mass + x * x * inverse_inertia,
            x * y * inverse_inertia,
            inverse_mass + y * y * inverse_inertia,
        ];
        let mass = [xx, xy, yy].map(|entry| entry / det);
        Self { at, impulse, mass, smallest_mass, inverse_mass, inverse_inertia }
    }

    /// The velocity of the mass centre with another impulse of friction: the present one and the velocity of the point,
    /// projected on the circle of friction.
    #[inline(always)]
    fn slow(&self, [vx, vy, spin]: [f64; 3], impulse: &mut [f64; 2], limit: f64) -> [f64; 3] {
        let [x, y] = self.at;
        let [ux, uy] = [vx - spin * y, vy + spin * x];
        let [xx, xy, yy] = self.mass;
        let mut next = [impulse[0] + xx * ux + xy * uy, impulse[1] + xy * ux + yy * uy];
        if next[0] * next[0] + next[1] * next[1] > limit * limit {
            // It slides: at the fixed point of this iteration friction is against the velocity.
            next = [impulse[0] + self.smallest_mass * ux, impulse[1] + self.smallest_mass * uy];
            let square = next[0] * next[0] + next[1] * next[1];
            let share = if square > limit * limit { limit / square.sqrt() } else { 1.0 };
            next = next.map(|p| share * p);
        }
        let [px, py] = [next[0] - impulse[0], next[1] - impulse[1]];
        *impulse = next;
        [
            vx - px * self.inverse_mass,
            vy - py * self.inverse_mass,
            spin - (x * py - y * px) * self.inverse_inertia,
        ]
    }
}

/// Impulse of each point in a step.
type Impulses = [[f64; 2]; MAX_POINTS];

impl SlidingPropagator {
    /// `points`: positions in the object frame, m, with their sliding friction, N. `None` for more than [`MAX_POINTS`].
    pub(crate) fn new(
        linear: LinearPropagator,
        points: impl IntoIterator<Item = ([f64; 2], f64)>,
        [mass, inertia]: [f64; 2],
        com: [f64; 2],
        dt: f64,
    ) -> Option<Self> {
        let point = |([x, y], force): ([f64; 2], f64)| {
            SlidingPoint::new([x - com[0], y - com[1]], force * dt, mass, inertia)
        };
        let points: Vec<_> = points.into_iter().map(point).collect();
        (points.len() <= MAX_POINTS).then_some(Self { linear, points })
    }

    /// Advance a state by one step under `applied`, object axes about the object origin.
    #[inline]
    pub fn step_in_place(&self, state: &mut State<f64>, applied: &[f64; 3]) {
        self.linear.step_with(state, applied, |velocity, map, force| {
            let mut limits = [0.0; MAX_POINTS];
            limits.iter_mut().zip(&self.points).for_each(|(limit, point)| *limit = 0.5 * point.impulse);
            let (before, used) = self.slow(velocity, &limits);
            for ((limit, point), [x, y]) in limits.iter_mut().zip(&self.points).zip(used) {
                *limit = point.impulse - (x * x + y * y).sqrt();
            }
            self.slow(map.apply(before, force), &limits).0
        });
    }

    /// Slow the body by friction up to the limit of each point. Returns the impulses too.
    #[inline(always)]
    fn slow(&self, mut velocity: [f64; 3], limits: &[f64; MAX_POINTS]) -> ([f64; 3], Impulses) {
        let mut impulses = [[0.0; 2]; MAX_POINTS];
        for _ in 0..MAX_SWEEPS {
            let mut is_sliding = true;
            for ((point, impulse), limit) in self.points.iter().zip(&mut impulses).zip(limits) {
                velocity = point.slow(velocity, impulse, *limit);
                let [x, y] = *impulse;
                is_sliding &= x * x + y * y >= 0.999 * limit * limit;
            }
            // One sweep is enough if no point stops.
            if is_sliding {
                break;
            }
        }
        (velocity, impulses)
    }
}

#[cfg(test)]
mod tests {
    use crate::{Body, Clock, Effect, Kind, Model, State};

    const DT: f64 = 0.05;

    /// A table on four feet with a locked wheel.
    fn table(friction: f64) -> Model {
        let body = Body::from_footprint(&[[-0.6, -0.4], [0.7, -0.4], [0.6, 0.4], [-0.6, 0.3]], 22.0).unwrap();
        let body = body.with_feet(&[[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]]);
        let mut model = Model::nominal(body, Some(22.0), [true; 3]);
        let wheel =
            Effect { kind: Kind::ViscousWheel, values: [-0.5, 0.3, 0.4, 60.0, 20.0].map(Some).to_vec() };
        let feet =
            Effect::free(Kind::SupportFriction).with("force", Some(friction)).with("spread", Some(1.0));
        model.effects = vec![wheel, feet];
        model
    }

    /// Distances between the poses of a rough and an exact motion after 2 s, m and rad, and the distance travelled, m, with
    /// steps of `dt`.
    fn errors(friction: f64, dt: f64) -> [f64; 3] {
        let plant = table(friction).resolved().unwrap();
        let propagator = plant.sliding_propagator(dt).unwrap();
        let mut rough = State::moving([0.1, -0.2, 3.0], [0.4, 0.1, 0.5]);
        let mut exact = rough;
        for tick in 0..(2.0 / dt).round() as u32 {
            let t = f64::from(tick) * dt;
            // It slides and turns, and from 1.2 s on it comes to rest.
            let push = f64::from(u8::from(t < 1.2 - 1e-9));
            let applied = [90.0 * push, 30.0 * (3.0 * t).cos() * push, 12.0 * (2.0 * t).sin() * push];
            plant.step_in_place(&mut exact, &applied, Clock::since_contact(t), dt);
            propagator.step_in_place(&mut rough, &applied);
        }
        let off = [0, 1, 2].map(|k| rough.pose[k] - exact.pose[k]);
        [off[0].hypot(off[1]), off[2].abs(), (exact.pose[0] - 0.1).hypot(exact.pose[1] + 0.2)]
    }

    #[test]
    fn a_rough_motion_converges_to_the_exact_one() {
        for friction in [10.0, 40.0, 70.0] {
            let [place, turn, travelled] = errors(friction, DT);
            assert!(travelled > 0.4 && place < 0.08 * travelled && turn < 0.06, "{friction}: {place} {turn}");
            let [place, turn, _] = errors(friction, 0.002);
            assert!(place < 2e-3 && turn < 2e-3, "{friction}: {place} {turn}");
        }
    }

    #[test]
    fn a_body_at_rest_withstands_less_than_its_friction() {
        let plant = table(40.0).resolved().unwrap();
        let propagator = plant.sliding_propagator(DT).unwrap();
        let mut state = State::at_rest([0.0; 3]);
        (0..40).for_each(|_| propagator.step_in_place(&mut state, &[30.0, 0.0, 0.0]));
        assert!(state.pose[0].abs() < 1e-3, "{state:?}");
        (0..40).for_each(|_| propagator.step_in_place(&mut state, &[60.0, 0.0, 0.0]));
        assert!(state.pose[0] > 0.1, "{state:?}");
    }

    #[test]
    fn other_forces_that_depend_on_the_state_have_no_sliding_propagator() {
        let rail = Model { dof: [true, false, true], ..table(40.0) };
        assert!(rail.resolved().unwrap().sliding_propagator(DT).is_none(), "a rail");
        let mut model = table(40.0);
        model.effects[1] = model.effects[1].clone().with("static_force", Some(60.0));
        assert!(model.resolved().unwrap().sliding_propagator(DT).is_none(), "breakaway friction");
        model.effects[1] = Effect {
            kind: Kind::QuadraticDrag,
            values: vec![Some(5.0); Kind::QuadraticDrag.spec().params.len()],
        };
        assert!(model.resolved().unwrap().sliding_propagator(DT).is_none());
    }
}
