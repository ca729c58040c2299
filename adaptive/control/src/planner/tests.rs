//! Plans of a table with a locked wheel.

use super::*;
use crate::{ArmResponse, AxisResponse, CommandedArm, Cost};
use trundle_model::{Body, Clock, Effect, Kind, Model, Plant, Precision, State, transport};

fn table(mu: f64) -> Plant<f64> {
    let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
    let wheel = [0.5, 0.3, 0.4, mu, mu].map(Some).to_vec();
    let effects = vec![Effect { kind: Kind::ViscousWheel, values: wheel }];
    let body = Body::from_footprint(&corners, 22.0).unwrap();
    Model { body, mass: Some(22.0), dof: [true; 3], effects, priors: Default::default(), discrepancy: None }
        .resolved()
        .unwrap()
}

fn settings() -> Settings {
    Settings::within([-100.0, -100.0, -40.0], [100.0, 100.0, 40.0])
}

fn task() -> PlanningTask {
    PlanningTask {
        state: State::at_rest([0.0; 3]),
        goal: [0.6, -0.5, 0.7],
        grasp: [-0.6, 0.0],
        arm: Default::default(),
    }
}

/// Control the plant for `seconds`, replanning every 50 ms for `models`.
fn driven(seconds: f64, models: &[Plant<f64>], settings: Settings) -> State<f64> {
    let plant = table(150.0);
    let mut planner = Planner::new(settings, 0).unwrap();
    let mut task = task();
    for _ in 0..(seconds / 0.05) as usize {
        let action = planner.plan(models, &task, &ObstacleMap::empty()).unwrap()[0];
        let applied = transport(action, [task.grasp[0], task.grasp[1], 0.0]);
        task.state = plant.step(&task.state, applied, Clock::since_contact(0.0), 0.05);
        planner.advance(0.05).unwrap();
    }
    task.state
}

#[test]
fn replanning_brings_a_table_to_rest_at_its_goal() {
    at_rest_at_goal(driven(5.0, &[table(150.0)], settings()));
}

#[test]
fn a_limit_on_rollouts_leaves_good_plans_for_several_models() {
    let models = [100.0, 150.0, 180.0].map(table);
    at_rest_at_goal(driven(5.0, &models, Settings { rollouts: Some(900), ..settings() }));
}

fn at_rest_at_goal(State { pose, twist, .. }: State<f64>) {
    let [x, y, theta] = task().goal;
    assert!((pose[0] - x).hypot(pose[1] - y) < 0.02, "{pose:?}");
    assert!((pose[2] - theta).abs() < 0.04, "{pose:?}");
    assert!(twist[0].hypot(twist[1]) < 0.05, "{twist:?}");
}

/// Distance to the goal after 5 s with an arm of this response, which `known` gives to the planner.
fn left_with_arm(known: bool) -> f64 {
    let lag = AxisResponse::Lag { time_constant: 0.15 };
    let response = ArmResponse { delay: 0.0, force: lag, torque: lag, turn: 0.0 };
    let (plant, step, mut states) = (table(150.0), response.discretised(0.05), [[0.0; 2]; 3]);
    let mut planner = Planner::new(settings(), 0).unwrap();
    let mut task = task();
    for _ in 0..100 {
        if known {
            task.arm = CommandedArm::moving(response, states);
        }
        let action = planner.plan(std::slice::from_ref(&plant), &task, &ObstacleMap::empty()).unwrap()[0];
        let exerted = step.advance(&mut states, action);
        let applied = transport(exerted, [task.grasp[0], task.grasp[1], 0.0]);
        task.state = plant.step(&task.state, applied, Clock::since_contact(0.0), 0.05);
        planner.advance(0.05).unwrap();
    }
    let ([x, y, _], [gx, gy, _]) = (task.state.pose, task.goal);
    (x - gx).hypot(y - gy)
}

#[test]
fn a_known_lag_is_compensated() {
    let (known, unknown) = (left_with_arm(true), left_with_arm(false));
    assert!(known < 0.02 && known < 0.5 * unknown, "{known} {unknown}");
}

/// Push a table to a goal behind a wall for `seconds`. Returns the final state and the smallest clearance.
fn around(seconds: f64, obstacle_map: &ObstacleMap) -> (State<f64>, f64) {
    let plants = [table(150.0)];
    let mut planner = Planner::new(settings(), 0).unwrap();
    let mut task = PlanningTask { goal: [2.2, 0.0, 0.0], ..task() };
    let mut min_clearance = f64::INFINITY;
    for _ in 0..(seconds / 0.1) as usize {
        let action = planner.plan(&plants, &task, obstacle_map).unwrap()[0];
        let applied = transport(action, [task.grasp[0], task.grasp[1], 0.0]);
        for _ in 0..2 {
            task.state = plants[0].step(&task.state, applied, Clock::since_contact(0.0), 0.05);
            min_clearance = min_clearance.min(obstacle_map.clearance(task.state.pose, 1.0));
        }
        planner.advance(0.1).unwrap();
    }
    (task.state, min_clearance)
}

fn box_in_the_way() -> Vec<Vec<[f64; 2]>> {
    vec![vec![[1.0, -0.3], [1.2, -0.3], [1.2, 0.2], [1.0, 0.2]]]
}

fn body() -> Body {
    Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap()
}

#[test]
fn plans_lead_around_obstacles() {
    let obstacle_map =
        ObstacleMap::new(&body(), &box_in_the_way(), [[2.2, 0.0, 0.0], [0.0; 3]], 0.3).unwrap();
    let (state, min_clearance) = around(9.0, &obstacle_map);
    assert!((state.pose[0] - 2.2).hypot(state.pose[1]) < 0.05, "{state:?}");
    assert!(min_clearance > 0.0, "contact with an obstacle: {min_clearance}");
}

#[test]
fn the_cost_is_the_mean_over_models() {
    let (light, heavy) = (table(20.0), table(300.0));
    let (task, obstacle_map) = (task(), ObstacleMap::empty());
    let mut planner = Planner::new(settings(), 0).unwrap();
    let cost = |plants: &[Plant<f64>], planner: &Planner| planner.cost(plants, &task, &obstacle_map);
    for _ in 0..4 {
        planner.plan(&[light.clone(), heavy.clone()], &task, &obstacle_map).unwrap();
    }
    let both = cost(&[light.clone(), heavy.clone()], &planner);
    let each = [&light, &heavy].map(|plant| cost(std::slice::from_ref(plant), &planner));
    assert!((both - (each[0] + each[1]) / 2.0).abs() < 1e-12);
    let mut sure = Planner::new(settings(), 0).unwrap();
    for _ in 0..4 {
        sure.plan(std::slice::from_ref(&light), &task, &obstacle_map).unwrap();
    }
    let alone = cost(std::slice::from_ref(&light), &sure);
    assert!(alone < each[0], "a plan for one model must have a lower cost on it: {alone} {each:?}");
}

#[test]
fn a_speed_that_a_brake_reaches_in_time_is_charged_if_commands_are_late() {
    let only_excess = Cost { heading: 0.0, effort: 0.0, arrival: 0.0, anchor: 0.0, ..Cost::default() };
    let planner = Planner::new(Settings { cost: only_excess, horizon: 1, ..settings() }, 0).unwrap();
    let charged = |delay: f64| {
        let (force, torque) = (AxisResponse::Exact, AxisResponse::Exact);
        let response = ArmResponse { delay, force, torque, turn: 0.0 };
        let state = State::moving([0.0; 3], [1.4, 0.0, 0.0]);
        let arm = CommandedArm::moving(response, [[0.0; 2]; 3]);
        let task = PlanningTask { state, goal: [0.0; 3], arm, ..task() };
        planner.cost(&[table(0.0)], &task, &ObstacleMap::empty())
    };
    // The limit falls from 1.6 to 1.2 m/s, and the plan of 0.1 s is above it.
    let excess = 10.0 * 0.1 * (1.4_f64 / 1.2 - 1.0).powi(2);
    let more = charged(0.1) - charged(0.0);
    assert!((more - excess).abs() < 1e-9, "{more} {excess}");
}

#[test]
fn a_table_with_a_dry_friction_foot_reaches_its_heading() {
    // From this grasp the foot cannot be moved around the centre. It must be moved to its goal position first.
    let foot = [("x", 0.5), ("y", -0.3), ("force", 46.0)];
    let foot = foot.iter().fold(Effect::free(Kind::CoulombFriction), |e, (k, v)| e.with(k, Some(*v)));
    let wheel = Effect { kind: Kind::ViscousWheel, values: [0.5, -0.3, 0.8, 200.0, 60.0].map(Some).to_vec() };
    let mut model = Model::nominal(body(), Some(22.0), [true; 3]);
    model.effects = vec![wheel, foot];
    let plants = [model.resolved().unwrap()];
    let left = |anchor: f64| {
        let settings = Settings { cost: Cost { anchor, ..Cost::default() }, ..settings() };
        let mut planner = Planner::new(settings, 0).unwrap();
        let mut task = PlanningTask { goal: [0.0, 0.0, 0.6], ..task() };
        for _ in 0..60 {
            let action = planner.plan(&plants, &task, &ObstacleMap::empty()).unwrap()[0];
            let applied = transport(action, [task.grasp[0], task.grasp[1], 0.0]);
            task.state = plants[0].step(&task.state, applied, Clock::since_contact(0.0), 0.1);
            planner.advance(0.1).unwrap();
        }
        let [x, y, theta] = task.state.pose;
        (x.hypot(y), (theta - 0.6).abs())
    };
    let (distance, turn) = left(Cost::default().anchor);
    assert!(distance < 0.02 && turn < 0.05, "{distance} {turn}");
    assert!(left(0.0).1 > 0.4, "without the anchor cost the table must not reach the goal");
}

#[test]
fn a_plan_with_rough_steps_is_accurate_with_exact_ones() {
    // Dry friction stops the table where the plan predicts.
    let values = [("x", 0.0), ("y", 0.0), ("force", 20.0)];
    let dry = values.iter().fold(Effect::free(Kind::CoulombFriction), |e, (k, v)| e.with(k, Some(*v)));
    let mut model = Model::nominal(body(), Some(22.0), [true; 3]);
    model.effects = vec![dry];
    let plant = model.resolved().unwrap();
    let settings = Settings { iterations: 12, ..settings() };
    let mut planner = Planner::new(settings, 0).unwrap();
    let task = PlanningTask { goal: [0.5, 0.1, 0.2], ..task() };
    let plan = planner.plan(std::slice::from_ref(&plant), &task, &ObstacleMap::empty()).unwrap().to_vec();
    let (mut rough, mut exact) = (task.state, task.state);
    for (k, action) in plan.iter().flat_map(|action| [action; 2]).enumerate() {
        let applied = transport(*action, [task.grasp[0], task.grasp[1], 0.0]);
        let clock = Clock::since_contact(0.05 * k as f64);
        plant.step_with_precision(Precision::Rough, &mut rough, &applied, clock, 0.05);
        plant.step_in_place(&mut exact, &applied, clock, 0.05);
    }
    let off = (rough.pose[0] - exact.pose[0]).hypot(rough.pose[1] - exact.pose[1]);
    assert!(off < 0.04 && (exact.pose[0] - 0.5).hypot(exact.pose[1] - 0.1) < 0.1, "{off} {exact:?}");
}

#[test]
fn a_better_grasp_costs_less() {
    // A turn about the locked wheel: a grasp near the wheel has little leverage.
    let mut weak = settings();
    (weak.lower, weak.upper) = ([-60.0, -60.0, -0.5], [60.0, 60.0, 0.5]);
    let planner = Planner::new(weak, 0).unwrap();
    let task = PlanningTask { goal: [0.424, -0.278, 0.9], ..task() };
    let grasps = [[0.5, 0.3], [-0.6, -0.3]];
    let costs = planner.compare(&[table(300.0)], &task, &ObstacleMap::empty(), &grasps).unwrap();
    assert!(costs[1] < 0.8 * costs[0], "{costs:?}");
    assert_eq!(costs, planner.compare(&[table(300.0)], &task, &ObstacleMap::empty(), &grasps).unwrap());
}

#[test]
fn plans_do_not_depend_on_the_number_of_threads() {
    let plans = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut planner = Planner::new(settings(), 7).unwrap();
        pool.install(|| planner.plan(&[table(100.0)], &task(), &ObstacleMap::empty()).unwrap().to_vec())
    });
    assert_eq!(plans[0], plans[1]);
}

#[test]
fn a_warm_start_costs_less_than_a_cold_one() {
    let (plant, task) = (table(100.0), task());
    let mut planner = Planner::new(settings(), 0).unwrap();
    let first = planner.plan(std::slice::from_ref(&plant), &task, &ObstacleMap::empty()).unwrap().to_vec();
    let second = planner.plan(std::slice::from_ref(&plant), &task, &ObstacleMap::empty()).unwrap().to_vec();
    let plants = [plant.clone()];
    let moving = rollout_models(&settings(), &plants, &task);
    let cost = |plan: &[[f64; 3]]| plan_cost(&settings(), &moving, &task, &ObstacleMap::empty(), plan);
    assert!(cost(&second) < cost(&first), "{} {}", cost(&second), cost(&first));
    planner.restart();
    assert_eq!(planner.plan(std::slice::from_ref(&plant), &task, &ObstacleMap::empty()).unwrap(), first);
}

#[test]
fn advancing_by_half_an_action_interpolates() {
    let mut planner = Planner::new(Settings { horizon: 3, ..settings() }, 0).unwrap();
    planner.mean = vec![[0.0; 3], [2.0; 3], [6.0; 3]];
    planner.advance(0.05).unwrap();
    assert_eq!(planner.mean, [[1.0; 3], [4.0; 3], [6.0; 3]]);
    planner.advance(1e300).unwrap();
    assert_eq!(planner.mean, [[6.0; 3]; 3]);
    assert!(planner.advance(f64::NAN).unwrap_err().to_string().starts_with("seconds = NaN"));
}

#[test]
fn invalid_settings_are_errors() {
    let refused = |settings| Planner::new(settings, 0).unwrap_err().to_string();
    assert!(refused(Settings { rollouts: Some(0), ..settings() }).starts_with("rollouts"));
    assert!(refused(Settings { horizon: 0, ..settings() }).starts_with("horizon = 0: must be at least 1"));
    assert!(refused(Settings { lower: [200.0; 3], ..settings() }).contains("below its upper bound"));
    assert!(refused(Settings { hold: f64::NAN, ..settings() }).starts_with("hold = NaN"));
    assert!(refused(Settings { hold: 1e9, ..settings() }).starts_with("hold = 1000000000.0"));
    assert!(refused(Settings { horizon: usize::MAX, ..settings() }).starts_with("horizon, samples = ("));
    assert!(refused(Settings { samples: 2_000_000, ..settings() }).contains("20 million"));
    assert!(refused(Settings { smoothness: 1.0, ..settings() }).starts_with("smoothness"));
    let cost = crate::Cost { heading: -1.0, ..Default::default() };
    assert!(refused(Settings { cost, ..settings() }).starts_with("cost.heading = -1.0"));
    let invalid = PlanningTask { goal: [f64::NAN, 0.0, 0.0], ..task() };
    let mut planner = Planner::new(settings(), 0).unwrap();
    assert!(
        planner
            .plan(&[table(1.0)], &invalid, &ObstacleMap::empty())
            .unwrap_err()
            .to_string()
            .starts_with("goal = [NaN")
    );
}

#[test]
fn divergence_is_an_error() {
    let far = PlanningTask { state: State::moving([0.0; 3], [1e308; 3]), ..task() };
    let mut planner = Planner::new(settings(), 0).unwrap();
    assert_eq!(
        planner.plan(&[table(1.0)], &far, &ObstacleMap::empty()),
        Err(ControlError::Diverged { samples: 256 })
    );
}

#[test]
fn rollouts_in_batches_give_the_plan_of_the_same_model() {
    let plant = table(150.0);
    let task = PlanningTask { state: State::moving([0.1, 0.0, 0.2], [0.3, 0.0, 0.1]), ..task() };
    let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap();
    let obstacles = [vec![[0.2, -1.6], [0.6, -1.6], [0.6, -0.9], [0.2, -0.9]]];
    let ends = [task.goal, task.state.pose];
    let map = ObstacleMap::new(&body, &obstacles, ends, 0.3).unwrap();
    let simulate = |plans: &[[f64; 3]]| -> Result<Vec<[f64; 6]>, ()> {
        let mut states = vec![];
        for plan in plans.chunks_exact(20) {
            let mut state = task.state;
            for action in plan {
                for _ in 0..settings().substeps() {
                    let applied = transport(*action, [task.grasp[0], task.grasp[1], 0.0]);
                    plant.fast_step(0.05).unwrap().step_in_place(&mut state, &applied);
                    let ([x, y, theta], [vx, vy, spin]) = (state.pose, state.twist);
                    states.push([x, y, theta, vx, vy, spin]);
                }
            }
        }
        Ok(states)
    };
    let plan = Planner::new(settings(), 3).unwrap().plan(&[&plant], &task, &map).unwrap().to_vec();
    let mut planner = Planner::new(settings(), 3).unwrap();
    assert_eq!(planner.plan_in_batches(&task, &map, simulate).unwrap(), plan);
    // Several equal predictions do not change the mean.
    let twice = |plans: &[[f64; 3]]| simulate(plans).map(|states| [&states[..], &states[..]].concat());
    let mut planner = Planner::new(settings(), 3).unwrap();
    assert_eq!(planner.plan_in_batches(&task, &map, twice).unwrap(), plan);
    let short = |_: &[[f64; 3]]| Ok::<_, ()>(vec![[0.0; 6]; 7]);
    let expected = BatchError::Planner(ControlError::States { given: 7, expected: 256 * 40 });
    assert_eq!(planner.plan_in_batches(&task, &map, short).unwrap_err(), expected);
    assert_eq!(
        planner.plan_in_batches(&task, &map, |_| Err("lost")).unwrap_err(),
        BatchError::Simulator("lost")
    );
}
