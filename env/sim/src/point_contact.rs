//! Point contact: a fingertip on a compliant arm that presses on the object's rim, with Coulomb friction and no adhesion.

use trundle_model::{Body, Rigid, State, to_body, to_world};

/// A round fingertip on a compliant arm.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PointContact {
    /// Centre of the fingertip, world, m.
    pub position: [f64; 2],
    /// Whether the fingertip is retracted and cannot touch the object.
    pub is_withdrawn: bool,
}

/// Radius of the fingertip, m.
pub const TIP_RADIUS_M: f64 = 0.02;
/// Stiffness of the arm, N/m; equal to that of the gripper.
const STIFFNESS_N_PER_M: f64 = 1e4;
/// Largest normal force, N. A larger force would compress the fingertip by more than its radius.
pub const MAX_FORCE_N: f64 = 150.0;
/// Damping of the arm, N·s/m.
const DAMPING_N_S_PER_M: f64 = 400.0;
/// Tangential damping while the contact sticks, N·s/m.
const STICTION_DAMPING_N_S_PER_M: f64 = 2e4;
/// Friction coefficient of rubber on the rim.
const FRICTION_COEFFICIENT: f64 = 0.5;

impl PointContact {
    /// A fingertip just outside the rim, at a point with outward normal `normal`, object frame.
    pub fn at_rim(rim: [f64; 2], normal: [f64; 2], object: [f64; 3]) -> Self {
        let [x, y] = [0, 1].map(|k| rim[k] + normal[k] * TIP_RADIUS_M);
        let [dx, dy, _] = to_world([x, y, 0.0], object[2]);
        Self { position: [object[0] + dx, object[1] + dy], is_withdrawn: false }
    }

    /// Advance the fingertip by one step at `velocity`, world, m/s. Returns the mean wrench on the object over the step,
    /// object axes about the object origin. The arm yields where the normal force would exceed `max_force`, N.
    pub fn step(
        &mut self,
        velocity: [f64; 2],
        max_force: f64,
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
        let [normal_force, tangential_force] = contact.force([ux, uy], rigid, state, dt);
        let max_force = max_force.min(MAX_FORCE_N);
        let normal_force = normal_force.min(max_force);
        let tangential_force =
            tangential_force.clamp(-FRICTION_COEFFICIENT * normal_force, FRICTION_COEFFICIENT * normal_force);
        self.advance(velocity, dt);
        self.limit_depth(max_force, body, state.pose);
        contact.wrench(normal_force, tangential_force)
    }

    fn advance(&mut self, velocity: [f64; 2], dt: f64) {
        self.position = [0, 1].map(|k| self.position[k] + velocity[k] * dt);
    }

    /// Limit the penetration to the depth at which the normal force is `max_force`.
    fn limit_depth(&mut self, max_force: f64, body: &Body, object: [f64; 3]) {
        let Some(RimContact { depth, inward, .. }) = self.contact(body, object) else { return };
        let over = depth - max_force / STIFFNESS_N_PER_M;
        if over > 0.0 {
            let [dx, dy, _] = to_world([inward[0] * over, inward[1] * over, 0.0], object[2]);
            self.position = [self.position[0] - dx, self.position[1] - dy];
        }
    }

    fn contact(&self, body: &Body, object: [f64; 3]) -> Option<RimContact> {
        if self.is_withdrawn {
            return None;
        }
        let [x, y, _] = to_body([self.position[0] - object[0], self.position[1] - object[1], 0.0], object[2]);
        let (distance, normal) = body.outside([x, y]);
        let depth = TIP_RADIUS_M - distance;
        let foot = [x - normal[0] * distance, y - normal[1] * distance];
        // Inside the object the outward normal is undefined. `limit_depth` prevents such depths.
        (depth > 0.0 && distance > 0.0).then_some(RimContact { depth, foot, inward: normal.map(|n| -n) })
    }
}

/// Geometry of a contact, object frame.
struct RimContact {
    depth: f64,
    foot: [f64; 2],
    inward: [f64; 2],
}

impl RimContact {
    /// Inward normal force and tangential force to the left of it, N. Springs and dampers are evaluated at the end of the
    /// step (implicit, as for the gripper), limited to the friction cone. `tip` is the fingertip's velocity, object axes.
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
        let stiff = DAMPING_N_S_PER_M + dt * STIFFNESS_N_PER_M;
        let driving_normal = STIFFNESS_N_PER_M * self.depth + stiff * closing;
        // (1 + dt B W) F = K e + B v, two by two.
        let (a, b) = (1.0 + dt * stiff * nn, dt * stiff * nt);
        let (c, d) = (dt * STICTION_DAMPING_N_S_PER_M * nt, 1.0 + dt * STICTION_DAMPING_N_S_PER_M * tt);
        let driving_tangential = STICTION_DAMPING_N_S_PER_M * sliding;
        let determinant = a * d - b * c;
        let normal_force = (d * driving_normal - b * driving_tangential) / determinant;
        let tangential_force = (a * driving_tangential - c * driving_normal) / determinant;
        if tangential_force.abs() <= FRICTION_COEFFICIENT * normal_force {
            return [normal_force, tangential_force];
        }
        // Slip: the tangential force is the friction coefficient times the normal force.
        let share = FRICTION_COEFFICIENT * tangential_force.signum();
        let normal_force = (driving_normal / (a + share * b)).max(0.0);
        [normal_force, share * normal_force]
    }

    fn wrench(&self, normal_force: f64, tangential_force: f64) -> [f64; 3] {
        let left = self.left();
        let force = [0, 1].map(|k| normal_force * self.inward[k] + tangential_force * left[k]);
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

    /// Push at a point of the left side for two seconds. Returns the final state, fingertip and wrench.
    fn push(y: f64, velocity: [f64; 2], max_force: f64) -> (State<f64>, PointContact, [f64; 3]) {
        let (body, plant) = table();
        let mut state = State::at_rest([0.0; 3]);
        let mut tip = PointContact::at_rim([-0.6, y], [-1.0, 0.0], state.pose);
        let mut wrench = [0.0; 3];
        for tick in 0..1000 {
            let clock = Clock::since_contact(f64::from(tick) * DT);
            wrench = tip.step(velocity, max_force, &body, &plant.rigid(clock), &state, DT);
            plant.step_in_place(&mut state, &wrench, clock, DT);
        }
        (state, tip, wrench)
    }

    #[test]
    fn a_push_through_the_centre_moves_the_object_at_the_same_speed() {
        let (state, _, wrench) = push(0.0, [0.2, 0.0], 1e3);
        assert!((state.twist[0] - 0.2).abs() < 1e-3, "{state:?}");
        assert!((wrench[0] - 60.0 * 0.2).abs() < 0.1 && wrench[2].abs() < 1e-6, "{wrench:?}");
    }

    #[test]
    fn a_receding_fingertip_does_not_pull() {
        let (state, _, _) = push(0.0, [-0.2, 0.0], 1e3);
        assert_eq!(state.pose, [0.0; 3]);
    }

    #[test]
    fn an_eccentric_push_turns_the_object_and_slips_off() {
        let (state, tip, _) = push(-0.35, [0.3, 0.0], 1e3);
        assert!(state.pose[2] > 0.5, "a push on the right turns the object left: {state:?}");
        assert!(tip.position[0] < 0.1, "{tip:?}");
    }

    #[test]
    fn friction_stays_within_the_cone_and_does_not_creep() {
        // At 20 degrees to the normal the contact sticks. At 60 degrees it slips.
        let along = |angle: f64| {
            let (body, plant) = table();
            let mut state = State::at_rest([0.0; 3]);
            let mut tip = PointContact::at_rim([-0.6, 0.0], [-1.0, 0.0], state.pose);
            let velocity = [0.2 * angle.cos(), 0.2 * angle.sin()];
            let mut worst = 0.0f64;
            for tick in 0..100 {
                let clock = Clock::since_contact(f64::from(tick) * DT);
                let wrench = tip.step(velocity, 1e3, &body, &plant.rigid(clock), &state, DT);
                worst = worst.max(wrench[1].abs() - FRICTION_COEFFICIENT * wrench[0]);
                plant.step_in_place(&mut state, &wrench, clock, DT);
            }
            let [x, y, _] = to_body(
                [tip.position[0] - state.pose[0], tip.position[1] - state.pose[1], 0.0],
                state.pose[2],
            );
            assert!(worst < 0.5, "outside the cone by {worst} N, {x}");
            y.abs()
        };
        assert!(along(0.35) < 2e-3 && along(1.05) > 5e-3, "{} {}", along(0.35), along(1.05));
    }

    #[test]
    fn the_fingertip_does_not_penetrate_an_immovable_object() {
        let (body, mut plant) = table();
        plant = Model::nominal(body.clone(), Some(22.0), [true; 3])
            .with_values(&[22.0, 0.0, 0.0, 0.0, 1e5, 1e5])
            .and_then(|model| model.resolved())
            .unwrap_or(plant);
        let mut state = State::at_rest([0.0; 3]);
        let mut tip = PointContact::at_rim([-0.6, 0.0], [-1.0, 0.0], state.pose);
        for tick in 0..1000 {
            let clock = Clock::since_contact(f64::from(tick) * DT);
            let wrench = tip.step([0.3, 0.0], f64::INFINITY, &body, &plant.rigid(clock), &state, DT);
            assert!(tick < 100 || (wrench[0] - MAX_FORCE_N).abs() < 1e-9, "{wrench:?}");
            plant.step_in_place(&mut state, &wrench, clock, DT);
        }
        assert!(tip.position[0] < state.pose[0] - 0.6, "{tip:?}");
    }

    #[test]
    fn an_arm_with_a_low_force_limit_stalls() {
        let (state, tip, wrench) = push(0.0, [0.3, 0.0], 5.0);
        assert!((wrench[0] - 5.0).abs() < 1e-9, "{wrench:?}");
        assert!(
            (state.twist[0] - 5.0 / 60.0).abs() < 1e-3 && tip.position[0] < state.pose[0] - 0.6,
            "{state:?}"
        );
    }
}
