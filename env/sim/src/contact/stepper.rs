//! Steps of a body in contact with fixed obstacles.

use serde::{Deserialize, Serialize};
use trundle_model::{Body, Plant, Rigid, State};

use super::manifold::{MAX_POINTS, Manifold};
use super::shape::{Outline, Piece, Polygon};
use super::solver::{Constraint, Motion, Span, solve};
use super::vector::{Frame, add, scale, sub};
use crate::SimError;
use crate::colliders::{in_tracked_frame, object_colliders, obstacle_colliders};

/// Distance below which two shapes count as touching, m.
pub(crate) const CONTACT_DISTANCE_M: f64 = 0.02;

/// A body among fixed obstacles.
#[derive(Clone)]
pub(crate) struct ContactStepper {
    pieces: Vec<Piece>,
    obstacles: Vec<Piece>,
    state: ContactState,
    /// Outline of a piece in world axes, one for each piece: buffers of a step.
    outlines: Vec<Polygon>,
    /// Buffer of a step; as many entries as manifolds.
    constraints: Vec<Constraint>,
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
                fixed.push(Piece::of(&piece)?);
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

    /// Lower bound on the distance of the body from all obstacles, m; negative in penetration.
    pub fn clearance(&mut self, pose: [f64; 3]) -> f64 {
        let frame = Frame::new(pose);
        let mut least = f64::INFINITY;
        for (piece, outline) in self.pieces.iter().zip(&mut self.outlines) {
            let center = frame.to_world(piece.center);
            let mut is_placed = false;
            for obstacle in &self.obstacles {
                let Outline::Polygon(polygon) = &obstacle.outline else { continue };
                let around = polygon.outside(center).0 - piece.radius;
                if around >= least || matches!(piece.outline, Outline::Disc) {
                    least = least.min(around);
                    continue;
                }
                if !std::mem::replace(&mut is_placed, true) {
                    place(piece, &frame, outline);
                }
                let apart = outline.separation(polygon).0.max(polygon.separation(outline).0);
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
        let turned = Frame::new([0.0, 0.0, after.pose[2]]).rotate(rigid.com);
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
        let active = self.find_contacts(&object, &motion, span);
        let was_touching = std::mem::replace(&mut self.state.touching, active > 0);
        self.state.impulse = 0.0;
        if active == 0 && !was_touching {
            *state = after;
            return;
        }
        solve(&mut self.constraints[..active], &mut motion, dt);
        for constraint in &self.constraints[..active] {
            let manifold = &mut self.state.manifolds[constraint.manifold];
            constraint.store(manifold);
            self.state.impulse += manifold.points[..manifold.count].iter().map(|p| p.impulse).sum::<f64>();
        }
        let [vx, vy] = add(motion.velocity, scale(change, 1.0 - share));
        let spin = motion.spin + (1.0 - share) * change_of_spin;
        let arm = motion.frame.rotate(rigid.com);
        let [x, y] = sub(motion.frame.origin, arm);
        state.pose = [x, y, state.pose[2] + motion.turn];
        state.twist = [vx + spin * arm[1], vy - spin * arm[0], spin];
        state.inner = after.inner;
    }

    /// Update all manifolds and prepare their constraints. Returns the number of those with contacts.
    fn find_contacts(&mut self, object: &Frame, motion: &Motion, span: Span) -> usize {
        let mut active = 0;
        let count = self.obstacles.len();
        for (index, (piece, outline)) in self.pieces.iter().zip(&mut self.outlines).enumerate() {
            let center = object.to_world(piece.center);
            let mut is_placed = false;
            let manifolds = &mut self.state.manifolds[index * count..(index + 1) * count];
            for (k, (obstacle, manifold)) in self.obstacles.iter().zip(manifolds).enumerate() {
                let Outline::Polygon(polygon) = &obstacle.outline else { continue };
                if polygon.outside(center).0 - piece.radius >= span.limit {
                    manifold.count = 0;
                    continue;
                }
                if !std::mem::replace(&mut is_placed, true) {
                    place(piece, object, outline);
                }
                manifold.update(object, piece, outline, polygon, span.limit);
                let constraint = Constraint::new(manifold, index * count + k, object, motion, span);
                if let Some(constraint) = constraint {
                    self.constraints[active] = constraint;
                    active += 1;
                }
            }
        }
        active
    }
}

/// Write the outline of a piece in world axes.
fn place(piece: &Piece, frame: &Frame, outline: &mut Polygon) {
    let Outline::Polygon(polygon) = &piece.outline else { return };
    for (to, &point) in outline.points.iter_mut().zip(&polygon.points) {
        *to = frame.to_world(point);
    }
    for (to, &normal) in outline.normals.iter_mut().zip(&polygon.normals) {
        *to = frame.rotate(normal);
    }
}
