//! How an action becomes a wrench on the object.

use serde::{Deserialize, Serialize};
use trundle_model::{Body, Rigid, State, transport};

use super::options::{Mode, Options};
use super::rules::*;
use super::things::Thing;
use crate::gripper::{compose, relative};
use crate::hand::Hand;
use crate::tip::{RADIUS, Tip};
use crate::{Coupling, Drive, Gripper};

/// The arm, with what it was last told.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Arm {
    /// Where it holds or touches the object: pose of the gripper in the object frame, m and rad.
    pub grasp: [f64; 3],
    /// None: it holds the object, and gives a wrench.
    hand: Option<Hand>,
    /// Command before, and now; a wrench is kept as it acts, object axes about the object origin.
    from: [f64; 3],
    to: [f64; 3],
    /// Simulation steps that it takes to hold elsewhere; none: it never lets go.
    travel: Option<u32>,
    /// Since it let go, until the first command after it has come to hold again.
    way: Option<Way>,
}

/// From one place on the object to another, object frame, m, straight and evenly.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Way {
    from: [f64; 2],
    to: [f64; 2],
    /// Simulation steps since, and in all.
    gone: u32,
    steps: u32,
}

impl Way {
    /// Where it is after one more simulation step.
    fn on(&mut self) -> [f64; 2] {
        self.gone += 1;
        let share = f64::from(self.gone) / f64::from(self.steps);
        // So that the end is exact.
        [0, 1].map(|k| (1.0 - share) * self.from[k] + share * self.to[k])
    }

    fn ended(&self) -> bool {
        self.gone >= self.steps
    }
}

impl Arm {
    /// At the grasp, with the object at a pose.
    pub fn new(options: &Options, [x, y]: [f64; 2], object: [f64; 3]) -> Self {
        let grasp = [x, y, 0.0];
        let travel = (options.action == Mode::Regrasp).then(|| options.travel());
        let hand = match options.action {
            Mode::Wrench | Mode::Regrasp => None,
            Mode::Velocity => {
                let gripper = Gripper::new(grasp, object, Drive::Velocity, Coupling::default());
                Some(Hand::Holds(gripper.at_most(FULL_WRENCH)))
            }
            Mode::Push => Some(Hand::withdrawn(grasp, object)),
        };
        Self { grasp, hand, from: [0.0; 3], to: [0.0; 3], travel, way: None }
    }

    /// Take a new command, of which each entry is in the unit of [`Mode::full`]. Whether the gripper goes on otherwise
    /// than it came, without having been accelerated.
    pub fn command(&mut self, target: [f64; WIDEST], thing: &Thing, object: [f64; 3]) -> bool {
        let [along, across, elsewhere] = [3, 4, 5].map(|k| target[k]);
        let arrived = self.way.take_if(|way| way.ended()).is_some();
        let leaves = self.travel.filter(|_| elsewhere > 0.0 && self.way.is_none());
        if let Some(steps) = leaves {
            let [x, y, _] = self.grasp;
            self.way = Some(Way { from: [x, y], to: thing.place([along, across]), gone: 0, steps });
        }
        (self.from, self.to) = (self.to, [0, 1, 2].map(|k| target[k]));
        if self.way.is_some() {
            (self.from, self.to) = ([0.0; 3], [0.0; 3]);
        } else if self.hand.is_none() {
            self.to = transport(self.to, self.grasp);
        }
        if let Some(Hand::Pushes { tip, heading }) = &mut self.hand {
            let [place, lean, _] = self.to;
            let rim = thing.rim(place);
            let (_, normal) = thing.body.outside(beyond(rim, thing.body.com));
            let angle = normal[1].atan2(normal[0]) + std::f64::consts::PI + lean;
            *tip = Tip::before(rim, normal, object);
            *heading = object[2] + angle;
            self.grasp = [rim[0], rim[1], angle];
            return true;
        }
        arrived || leaves.is_some()
    }

    /// The mean wrench on the object over the coming step, object axes about the object origin; `t`, s, of `whole`
    /// since the command.
    pub fn push(
        &mut self,
        [t, whole, dt]: [f64; 3],
        body: &Body,
        rigid: &Rigid<f64>,
        state: &State<f64>,
    ) -> [f64; 3] {
        if let Some(way) = &mut self.way {
            [self.grasp[0], self.grasp[1]] = way.on();
            return [0.0; 3];
        }
        let mut command = self.at(t + dt / 2.0, whole);
        let Some(hand) = &mut self.hand else { return command };
        if let Hand::Pushes { tip, heading } = hand {
            tip.withdrawn = t >= MOVING * whole;
            let speed = FULL_PUSH[2] + self.to[2];
            command = [speed * heading.cos(), speed * heading.sin(), 0.0];
        }
        hand.push(command, FULL_WRENCH[0], body, rigid, state, dt)
    }

    /// The wrench at a time since the command, object axes about the object origin, where it is what is commanded; not
    /// when it lets go, which is a jump.
    pub fn instant(&self, t: f64, whole: f64) -> Option<[f64; 3]> {
        (self.hand.is_none() && self.way.is_none()).then(|| self.at(t, whole))
    }

    /// Pose of the gripper in the world.
    pub fn pose(&self, object: [f64; 3]) -> [f64; 3] {
        self.hand.as_ref().map_or_else(|| compose(object, self.grasp), |hand| hand.pose(object))
    }

    /// Pose of the gripper in the object frame.
    pub fn frame(&self, object: [f64; 3]) -> [f64; 3] {
        self.hand.as_ref().map_or(self.grasp, |hand| relative(object, hand.pose(object)))
    }

    /// Whether it holds the object; it does not on the way elsewhere, nor if it can only push.
    pub fn holds(&self) -> bool {
        !matches!(self.hand, Some(Hand::Pushes { .. })) && self.way.as_ref().is_none_or(Way::ended)
    }

    /// A wrench rises fast and is held; a velocity changes all the time, or the arm would have to jerk the object.
    fn at(&self, t: f64, whole: f64) -> [f64; 3] {
        let rise = if self.hand.is_none() { RISE.min(whole) } else { whole };
        let share = (t / rise).min(1.0);
        [0, 1, 2].map(|k| self.from[k] + share * (self.to[k] - self.from[k]))
    }
}

/// A point as far out of the rim as the tip's radius, seen from the mass centre.
fn beyond(rim: [f64; 2], com: [f64; 2]) -> [f64; 2] {
    let (x, y) = (rim[0] - com[0], rim[1] - com[1]);
    let share = 1e-6f64.max(RADIUS * 1e-3) / x.hypot(y).max(1e-9);
    [rim[0] + x * share, rim[1] + y * share]
}
