use trundle_control::*;
use trundle_model::*;
fn table(mu: f64) -> Plant<f64> {
    let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
    let wheel = [0.5, 0.3, 0.4, mu, mu].map(Some).to_vec();
    let effects = vec![Effect { kind: Kind::ViscousWheel, values: wheel }];
    let body = Body::from_footprint(&corners, 22.0).unwrap();
    Model { body, mass: Some(22.0), dof: [true; 3], effects }.resolved().unwrap()
}
fn main() {
    let a: Vec<f64> = std::env::args().skip(1).map(|s| s.parse().unwrap()).collect();
    let arg = |k: usize, d: f64| a.get(k).copied().filter(|v| *v >= 0.0).unwrap_or(d);
    let mut s = Settings::within([-100.0, -100.0, -40.0], [100.0, 100.0, 40.0]);
    s.spread = arg(0, s.spread);
    s.smoothness = arg(1, s.smoothness);
    s.temperature = arg(2, s.temperature);
    s.iterations = arg(3, s.iterations as f64) as usize;
    s.horizon = arg(4, s.horizon as f64) as usize;
    s.samples = arg(5, s.samples as f64) as usize;
    s.cost.momentum = arg(6, s.cost.momentum);
    s.cost.arrival = arg(7, s.cost.arrival);
    s.cost.effort = arg(8, s.cost.effort);
    let mut total = 0.0;
    let mut reached = 0.0;
    let mut n = 0.0;
    let mut ok = 0;
    let start = std::time::Instant::now();
    for (i, mu) in [60.0, 150.0, 300.0].into_iter().enumerate() {
        for (j, goal) in
            [[0.6, -0.5, 0.7], [-0.7, 0.2, -0.6], [0.0, 0.8, 0.3], [0.5, 0.0, 0.0]].into_iter().enumerate()
        {
            let plant = table(mu);
            let mut planner = Planner::new(s.clone(), (i * 4 + j) as u64).unwrap();
            let mut task = Task { state: State::at_rest([0.0; 3]), goal, grasp: [-0.6, 0.0] };
            let mut hit = 15.0;
            for k in 0..150 {
                let action = planner.plan(&plant, &task).unwrap()[0];
                let applied = transport(action, [-0.6, 0.0, 0.0]);
                for _ in 0..2 {
                    task.state = plant.step(&task.state, applied, Clock { since_contact: 0.0 }, 0.05);
                    let p = task.state.pose;
                    let d = (p[0] - goal[0]).hypot(p[1] - goal[1]);
                    let h = (p[2] - goal[2]).abs();
                    if hit == 15.0 {
                        total += 0.05 * (d + 0.3 * h);
                    }
                    let v = task.state.twist[0].hypot(task.state.twist[1]);
                    if d < 0.05 && h < 0.1 && v < 0.1 && hit == 15.0 {
                        hit = 0.1 * k as f64;
                        ok += 1;
                    }
                }
                planner.advance(0.1).unwrap();
                if hit < 15.0 {
                    break;
                }
            }
            reached += hit;
            n += 1.0;
        }
    }
    println!(
        "{a:?} cost {:.3} time {:.2} ok {ok}/{n} {:.1}s",
        total / n,
        reached / n,
        start.elapsed().as_secs_f64()
    );
}
