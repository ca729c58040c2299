//! A fingertip that pushes: it presses on the rim, rubs along it, and never pulls.

use trundle_model::{Body, Rigid, State, to_body, to_world};

/// A round tip on a compliant arm.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tip {
    /// Its middle, world, m.
    pub at: [f64; 2],
    /// Whether it is away from the object, and touches nothing.
    pub withdrawn: bool,
}

/// Radius of the tip, m.
pub const RADIUS: f64 = 0.02;
/// Of the arm against the object, N/m; as the gripper's.
const STIFFNESS: f64 = 1e4;
/// What the arm can press with at most, N: beyond that the tip would be driven in by more than its radius.
pub const STRONGEST: f64 = 150.0;
/// N·s/m.
const DAMPING: f64 = 400.0;
/// What slips along the rim slower than friction allows is braked with this, N·s/m.
const STICKING: f64 = 2e4;
/// Friction of rubber on the rim.
const FRICTION: f64 = 0.5;

impl Tip {
    /// A tip that just does not touch the rim at a point whose outward normal is `normal`, object frame.
    pub fn before(rim: [f64; 2], normal: [f64; 2], object: [f64; 3]) -> Self {
        let [x, y] = [0, 1].map(|k| rim[k] + normal[k] * RADIUS);
        let [dx, dy, _] = to_world([x, y, 0.0], object[2]);
        Self { at: [object[0] + dx, object[1] + dy], withdrawn: false }
    }

    /// The mean wrench on the object over the coming step, object axes about the object origin, while the tip moves
    /// at `velocity`, world, m/s. The arm yields where it would have to press with more than `most`, N.
    pub fn push(
        &mut self,
        velocity: [f64; 2],
        most: f64,
        body: &Body,
        rigid: &Rigid<f64>,
        state: &State<f64>,
        dt: f64,
    ) -> [f64; 3] {
        let Some(contact) = self.contact(body, state.pose) else {
            self.advance(velocity, dt);
            return [0.0; 3];
        };
        let [ux, uy, _] = to_body([velocity[0], velocity[1], 0.0], state.pose[2]);
        let [press, rub] = contact.force([ux, uy], rigid, state, dt);
        let most = most.min(STRONGEST);
        let press = press.min(most);
        let rub = rub.clamp(-FRICTION * press, FRICTION * press);
        self.advance(velocity, dt);
        self.yield_to(most, body, state.pose);
        contact.wrench(press, rub)
    }

    fn advance(&mut self, velocity: [f64; 2], dt: f64) {
        self.at = [0, 1].map(|k| self.at[k] + velocity[k] * dt);
    }

    /// Go no deeper than the arm can press.
    fn yield_to(&mut self, most: f64, body: &Body, object: [f64; 3]) {
        let Some(Contact { depth, inward, .. }) = self.contact(body, object) else { return };
        let over = depth - most / STIFFNESS;
        if over > 0.0 {
            let [dx, dy, _] = to_world([inward[0] * over, inward[1] * over, 0.0], object[2]);
            self.at = [self.at[0] - dx, self.at[1] - dy];
        }
    }

    fn contact(&self, body: &Body, object: [f64; 3]) -> Option<Contact> {
        if self.withdrawn {
            return None;
        }
        let [x, y, _] = to_body([self.at[0] - object[0], self.at[1] - object[1], 0.0], object[2]);
        let (distance, normal) = body.outside([x, y]);
        let depth = RADIUS - distance;
        let foot = [x - normal[0] * distance, y - normal[1] * distance];
        // Within the object there is no way out to be seen: the tip is never driven so deep.
        (depth > 0.0 && distance > 0.0).then_some(Contact { depth, foot, inward: normal.map(|n| -n) })
    }
}

/// Where the tip touches, object frame.
struct Contact {
    depth: f64,
    foot: [f64; 2],
    inward: [f64; 2],
}

impl Contact {
    /// What presses inwards, and what rubs to the left of that, N: spring and dampers at the end of the step
    /// (implicit, as the gripper's), cut to what contact and friction can hold. `tip`: its velocity, object axes.
    fn force(&self, tip: [f64; 2], rigid: &Rigid<f64>, state: &State<f64>, dt: f64) -> [f64; 2] {
        let [vx, vy, spin] = to_body(state.twist, state.pose[2]);
        let at_foot = [vx - spin * self.foot[1], vy + spin * self.foot[0]];
        let slip = [tip[0] - at_foot[0], tip[1] - at_foot[1]];
        let (n, t) = (self.inward, self.left());
        let (closing, sliding) = (dot(slip, n), dot(slip, t));
        let arm = [self.foot[0] - rigid.com[0], self.foot[1] - rigid.com[1]];
        let (ln, lt) = (cross(arm, n), cross(arm, t));
        let [m, i] = [rigid.mass.recip(), rigid.inertia.recip()];
        let (nn, nt, tt) = (m + ln * ln * i, ln * lt * i, m + lt * lt * i);
        let stiff = DAMPING + dt * STIFFNESS;
        let pressed = STIFFNESS * self.depth + stiff * closing;
        // (1 + dt B W) F = K e + B v, two by two.
        let (a, b) = (1.0 + dt * stiff * nn, dt * stiff * nt);
        let (c, d) = (dt * STICKING * nt, 1.0 + dt * STICKING * tt);
        let rubbed = STICKING * sliding;
        let determinant = a * d - b * c;
        let press = (d * pressed - b * rubbed) / determinant;
        let rub = (a * rubbed - c * pressed) / determinant;
        if rub.abs() <= FRICTION * press {
            return [press, rub];
        }
        // It slips: what rubs is a share of what presses.
        let share = FRICTION * rub.signum();
        let press = (pressed / (a + share * b)).max(0.0);
        [press, share * press]
    }

    fn wrench(&self, press: f64, rub: f64) -> [f64; 3] {
        let left = self.left();
        let force = [0, 1].map(|k| press * self.inward[k] + rub * left[k]);
        [force[0], force[1], cross(self.foot, force)]
    }

    fn left(&self) -> [f64; 2] {
        [-self.inward[1], self.inward[0]]
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_model::{Clock, Effect, Kind, Model, Plant};

    const DT: f64 = 2e-3;

    fn table() -> (Body, Plant<f64>) {
        let footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
        let body = Body::from_footprint(&footprint, 22.0).unwrap();
        let mut model = Model::nominal(body.clone(), Some(22.0), [true; 3]);
        model.effects =
            vec![Effect { kind: Kind::ViscousWheel, values: [0.0, 0.0, 0.0, 60.0, 60.0].map(Some).to_vec() }];
        (body, model.resolved().unwrap())
    }

    /// Pushed at a point of the left side for two seconds: where it ends, and the last wrench.
    fn push(y: f64, velocity: [f64; 2], most: f64) -> (State<f64>, Tip, [f64; 3]) {
        let (body, plant) = table();
        let mut state = State::at_rest([0.0; 3]);
        let mut tip = Tip::before([-0.6, y], [-1.0, 0.0], state.pose);
        let mut wrench = [0.0; 3];
        for tick in 0..1000 {
            let clock = Clock::since_contact(f64::from(tick) * DT);
            wrench = tip.push(velocity, most, &body, &plant.rigid(clock), &state, DT);
            plant.step_in_place(&mut state, &wrench, clock, DT);
        }
        (state, tip, wrench)
    }

    #[test]
    fn a_push_through_the_middle_carries_the_object_along() {
        let (state, _, wrench) = push(0.0, [0.2, 0.0], 1e3);
        assert!((state.twist[0] - 0.2).abs() < 1e-3, "{state:?}");
        assert!((wrench[0] - 60.0 * 0.2).abs() < 0.1 && wrench[2].abs() < 1e-6, "{wrench:?}");
    }

    #[test]
    fn it_never_pulls() {
        let (state, _, _) = push(0.0, [-0.2, 0.0], 1e3);
        assert_eq!(state.pose, [0.0; 3]);
    }

    #[test]
    fn beside_the_middle_it_turns_the_object_and_slips_off() {
        let (state, tip, _) = push(-0.35, [0.3, 0.0], 1e3);
        assert!(state.pose[2] > 0.5, "pushed on its right it turns left: {state:?}");
        assert!(tip.at[0] < 0.1, "{tip:?}");
    }

    #[test]
    fn rubbing_stays_within_the_cone_and_does_not_creep_within_it() {
        // At 20 degrees to the normal it sticks: the rim goes along. At 60 it slips.
        let along = |angle: f64| {
            let (body, plant) = table();
            let mut state = State::at_rest([0.0; 3]);
            let mut tip = Tip::before([-0.6, 0.0], [-1.0, 0.0], state.pose);
            let velocity = [0.2 * angle.cos(), 0.2 * angle.sin()];
            let mut worst = 0.0f64;
            for tick in 0..100 {
                let clock = Clock::since_contact(f64::from(tick) * DT);
                let wrench = tip.push(velocity, 1e3, &body, &plant.rigid(clock), &state, DT);
                worst = worst.max(wrench[1].abs() - FRICTION * wrench[0]);
                plant.step_in_place(&mut state, &wrench, clock, DT);
            }
            let [x, y, _] =
                to_body([tip.at[0] - state.pose[0], tip.at[1] - state.pose[1], 0.0], state.pose[2]);
            assert!(worst < 0.5, "outside the cone by {worst} N, {x}");
            y.abs()
        };
        assert!(along(0.35) < 2e-3 && along(1.05) > 5e-3, "{} {}", along(0.35), along(1.05));
    }

    #[test]
    fn it_is_not_driven_through_what_it_cannot_move() {
        let (body, mut plant) = table();
        plant = Model::nominal(body.clone(), Some(22.0), [true; 3])
            .with_values(&[22.0, 0.0, 0.0, 0.0, 1e5, 1e5])
            .and_then(|model| model.resolved())
            .unwrap_or(plant);
        let mut state = State::at_rest([0.0; 3]);
        let mut tip = Tip::before([-0.6, 0.0], [-1.0, 0.0], state.pose);
        for tick in 0..1000 {
            let clock = Clock::since_contact(f64::from(tick) * DT);
            let wrench = tip.push([0.3, 0.0], f64::INFINITY, &body, &plant.rigid(clock), &state, DT);
            assert!(tick < 100 || (wrench[0] - STRONGEST).abs() < 1e-9, "{wrench:?}");
            plant.step_in_place(&mut state, &wrench, clock, DT);
        }
        assert!(tip.at[0] < state.pose[0] - 0.6, "{tip:?}");
    }

    #[test]
    fn an_arm_that_is_not_strong_enough_stalls() {
        let (state, tip, wrench) = push(0.0, [0.3, 0.0], 5.0);
        assert!((wrench[0] - 5.0).abs() < 1e-9, "{wrench:?}");
        assert!((state.twist[0] - 5.0 / 60.0).abs() < 1e-3 && tip.at[0] < state.pose[0] - 0.6, "{state:?}");
    }
}
