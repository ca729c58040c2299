//! Steps of a body in contact with fixed obstacles.

use serde::{Deserialize, Serialize};
use trundle_model::{Body, Plant, Rigid, State};

use super::manifold::{MAX_POINTS, Manifold};
use super::shape::{Outline, Piece, Polygon};
use super::solver::{Activity, Constraint, Motion, Softness, Span, solve};
use super::vector::{Frame, add, scale, sub};
use crate::SimError;
use crate::colliders::{in_tracked_frame, object_colliders, obstacle_colliders};

/// Distance below which two shapes count as touching, m.
pub(crate) const CONTACT_DISTANCE_M: f64 = 0.02;

/// Distance of the bounding circle from an obstacle above which the distance of the shapes is not computed, m.
const FAR_M: f64 = 0.1;

/// A body among fixed obstacles.
#[derive(Clone)]
pub(crate) struct ContactStepper {
    pieces: Vec<Piece>,
    obstacles: Vec<Polygon>,
    state: ContactState,
    /// Outline of a piece in world axes, one for each piece: buffers of a step.
    outlines: Vec<Polygon>,
    /// Buffer of a step; as many entries as manifolds.
    constraints: Vec<Constraint>,
    /// Softness of contacts at the last step length.
    softness: Softness,
}

/// State of the contacts between steps.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct ContactState {
    /// One for each pair of a piece and an obstacle.
    manifolds: Vec<Manifold>,
    touching: bool,
    /// Sum of all normal impulses in the last step, N·s.
    impulse: f64,
}

impl ContactStepper {
    /// # Errors
    /// If a shape is not a simple polygon.
    pub fn new(body: &Body, plant: &Plant<f64>, obstacles: &[Vec<[f64; 2]>]) -> Result<Self, SimError> {
        let pieces =
            object_colliders(body)?.into_iter().map(|piece| Piece::of(&in_tracked_frame(piece, plant)));
        let pieces: Vec<Piece> = pieces.collect::<Result<_, _>>()?;
        let mut fixed = vec![];
        for (index, polygon) in obstacles.iter().enumerate() {
            for piece in obstacle_colliders(polygon, index)? {
                if let Outline::Polygon(polygon) = Piece::of(&piece)?.outline {
                    fixed.push(polygon);
                }
            }
        }
        let outlines = pieces.iter().map(|piece| match &piece.outline {
            Outline::Polygon(polygon) => polygon.clone(),
            Outline::Disc => Polygon::default(),
        });
        let pairs = pieces.len() * fixed.len();
        Ok(Self {
            outlines: outlines.collect(),
            state: ContactState {
                manifolds: vec![Manifold::default(); pairs],
                touching: false,
                impulse: 0.0,
            },
            constraints: vec![Constraint::default(); pairs],
            softness: Softness::new(0.0),
            pieces,
            obstacles: fixed,
        })
    }

    /// Whether the body touched an obstacle in the last step.
    pub fn is_touching(&self) -> bool {
        self.state.touching
    }

    /// Impulse of obstacles on the body in the last step: the sum of all normal impulses, N·s.
    pub fn contact_impulse(&self) -> f64 {
        self.state.impulse
    }

    /// Forget all contacts, because the body moved without them.
    pub fn clear(&mut self) {
        self.state.manifolds.iter_mut().for_each(|manifold| manifold.count = 0);
        (self.state.touching, self.state.impulse) = (false, 0.0);
    }

    /// The state of the contacts.
    pub fn save(&self) -> ContactState {
        self.state.clone()
    }

    /// Restore the state saved by a stepper with the same shapes.
    ///
    /// # Errors
    /// If the number of contacts differs.
    pub fn load(&mut self, state: ContactState) -> Result<(), SimError> {
        let counts = state.manifolds.iter().map(|manifold| manifold.count).max().unwrap_or(0);
        if state.manifolds.len() != self.state.manifolds.len() || counts > MAX_POINTS {
            return Err(SimError::State("the number of contacts differs".to_owned()));
        }
        self.state = state;
        Ok(())
    }

    /// Lower bound on the distance of the body from all obstacles, m; negative in penetration. Far away it is that of the
    /// bounding circles.
    pub fn clearance(&mut self, pose: [f64; 3]) -> f64 {
        let frame = Frame::new(pose);
        let mut least = f64::INFINITY;
        for (piece, outline) in self.pieces.iter().zip(&mut self.outlines) {
            let (center, mut is_placed) = (frame.to_world(piece.center), false);
            for obstacle in &self.obstacles {
                let around = obstacle.outside(center).0 - piece.radius;
                if around >= least {
                    continue;
                }
                if around > FAR_M || matches!(piece.outline, Outline::Disc) {
                    least = around;
                    continue;
                }
                if !std::mem::replace(&mut is_placed, true) {
                    piece.place(&frame, outline);
                }
                let apart = outline.separation(obstacle).0.max(obstacle.separation(outline).0);
                least = least.min(apart.max(around));
            }
        }
        least
    }

    /// Advance `state` by one step to `after`, the motion without contact, changed by the contacts. `travel` is an upper
    /// bound on the distance that a point of the body travels in the step, m.
    pub fn step(
        &mut self,
        state: &mut State<f64>,
        after: State<f64>,
        rigid: &Rigid<f64>,
        travel: f64,
        dt: f64,
    ) {
        let span = Span { dt, limit: CONTACT_DISTANCE_M.max(travel) };
        let object = Frame::new(state.pose);
        let arm = object.rotate(rigid.com);
        let [vx, vy, spin] = state.twist;
        let velocity = [vx - spin * arm[1], vy + spin * arm[0]];
        let turned = object.turned(after.pose[2] - state.pose[2]).rotate(rigid.com);
        let [wx, wy, after_spin] = after.twist;
        let change = sub([wx - after_spin * turned[1], wy + after_spin * turned[0]], velocity);
        let change_of_spin = after_spin - spin;
        // Without contact in the last step, half of the change precedes the contact, as in `World`.
        let share = if self.state.touching { 1.0 } else { 0.5 };
        let mut motion = Motion {
            frame: Frame { origin: add(object.origin, arm), rotation: object.rotation },
            velocity: add(velocity, scale(change, share)),
            spin: spin + share * change_of_spin,
            turn: 0.0,
            inverse_mass: rigid.mass.recip(),
            inverse_inertia: rigid.inertia.recip(),
        };
        let (active, is_idle) = self.find_contacts(&object, &motion, span);
        let was_touching = std::mem::replace(&mut self.state.touching, active > 0);
        self.state.impulse = 0.0;
        if active == 0 && !was_touching {
            *state = after;
            return;
        }
        if is_idle {
            motion.integrate(dt);
        } else {
            self.solve_contacts(active, &object, &mut motion, span);
        }
        let [vx, vy] = add(motion.velocity, scale(change, 1.0 - share));
        let spin = motion.spin + (1.0 - share) * change_of_spin;
        let arm = motion.frame.rotate(rigid.com);
        let [x, y] = sub(motion.frame.origin, arm);
        state.pose = [x, y, state.pose[2] + motion.turn];
        state.twist = [vx + spin * arm[1], vy - spin * arm[0], spin];
        state.inner = after.inner;
    }

    /// Update all manifolds. Returns the number of those with contacts, whose indices are then in the first constraints,
    /// and whether no contact can cause an impulse in this step.
    fn find_contacts(&mut self, object: &Frame, motion: &Motion, span: Span) -> (usize, bool) {
        let (mut active, mut is_idle) = (0, true);
        let mut manifolds = self.state.manifolds.iter_mut().enumerate();
        for (piece, outline) in self.pieces.iter().zip(&mut self.outlines) {
            let (center, mut is_placed) = (object.to_world(piece.center), false);
            for (obstacle, (index, manifold)) in self.obstacles.iter().zip(&mut manifolds) {
                if obstacle.outside(center).0 - piece.radius >= span.limit {
                    manifold.count = 0;
                    continue;
                }
                manifold.update(object, piece, (&mut *outline, &mut is_placed), obstacle, span.limit);
                let activity = manifold.activity(object, motion, span);
                if activity != Activity::Apart {
                    self.constraints[active].manifold = index;
                    active += 1;
                }
                is_idle &= activity != Activity::Pressing;
            }
        }
        (active, is_idle)
    }

    /// Solve the impulses of the first `active` constraints, and integrate the pose.
    fn solve_contacts(&mut self, active: usize, object: &Frame, motion: &mut Motion, span: Span) {
        if self.softness.dt != span.dt {
            self.softness = Softness::new(span.dt);
        }
        for constraint in &mut self.constraints[..active] {
            constraint.set(&self.state.manifolds[constraint.manifold], object, motion, span);
        }
        solve(&mut self.constraints[..active], motion, &self.softness);
        for constraint in &self.constraints[..active] {
            let manifold = &mut self.state.manifolds[constraint.manifold];
            constraint.store(manifold);
            self.state.impulse += manifold.points[..manifold.count].iter().map(|p| p.impulse).sum::<f64>();
        }
    }
}
