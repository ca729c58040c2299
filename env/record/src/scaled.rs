//! Conversion of a recording to other units of length, force and time.

use trundle_model::Scales;

use crate::episode::Episode;
use crate::metadata::{Metadata, Precontact};
use crate::recording::Recording;

impl Recording {
    /// The same recording in other units: lengths, forces and times are divided by the sizes of the units in `scales`.
    #[must_use]
    pub fn in_units(&self, scales: &Scales) -> Self {
        let mut scaled = self.clone();
        metadata(&mut scaled.metadata, scales);
        scaled.episodes.iter_mut().for_each(|one| episode(one, scales));
        scaled
    }
}

fn metadata(meta: &mut Metadata, scales: &Scales) {
    let (length, time) = (scales.length, scales.time);
    let point = |p: &mut [f64; 2]| *p = p.map(|v| v / length);
    let object = &mut meta.object;
    object.footprint.iter_mut().for_each(point);
    object.support.iter_mut().for_each(point);
    object.mass = object.mass.map(|mass| mass / scales.mass());
    for fixture in &mut object.fixtures {
        fixture.polygon.iter_mut().flatten().for_each(point);
        fixture.disc = fixture.disc.map(|disc| disc.map(|v| v / length));
    }
    let wrench = &mut meta.wrench;
    wrench.gripper_mass = wrench.gripper_mass.map(|mass| mass / scales.mass());
    wrench.gripper_com = wrench.gripper_com.map(|com| com.map(|v| v / length));
    let interval = |times: &mut [f64; 2]| *times = times.map(|t| t / time);
    match &mut wrench.precontact {
        Some(Precontact::Everywhere(times)) => interval(times),
        Some(Precontact::ByEpisode(table)) => table.values_mut().for_each(interval),
        None => {}
    }
    if let Some(noise) = &mut meta.noise {
        let [x, y, angle] = noise.pose;
        noise.pose = [x / length, y / length, angle];
        noise.force /= scales.force;
        noise.torque = noise.torque.map(|torque| torque / scales.torque());
        noise.time /= time;
    }
    meta.scene.obstacles.iter_mut().flat_map(|o| &mut o.polygon).for_each(point);
}

fn episode(episode: &mut Episode, scales: &Scales) {
    episode.t.iter_mut().for_each(|t| *t /= scales.time);
    for (name, values) in &mut episode.columns {
        let size = match name.as_str() {
            "object_x" | "object_y" | "gripper_x" | "gripper_y" | "gripper_z" => scales.length,
            name if name.starts_with("force") => scales.force,
            name if name.starts_with("torque") => scales.torque(),
            _ => continue,
        };
        values.iter_mut().for_each(|v| *v /= size);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::prepare::{Options, prepare, prepare_with};
    use std::collections::BTreeMap;

    const META: &str = r#"
format = "trundle-recording/1"
name = "made"
[object]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 20.0
[wrench]
frame = "sensor"
sign = "on_object"
raw = true
precontact = [0.0, 0.9]
[noise]
pose = [5e-4, 5e-4, 2e-3]
force = 0.4
torque = 0.05
"#;

    fn recording() -> Recording {
        let t: Vec<f64> = (0..300).map(|k| 0.01 * f64::from(k)).collect();
        let push = |t: f64| if t < 1.0 { 0.0 } else { 12.0 };
        let moved = |t: f64| 0.3 * (t - 1.0).max(0.0).powi(2);
        let column = |of: &dyn Fn(f64) -> f64| t.iter().map(|&t| of(t)).collect::<Vec<f64>>();
        let columns: BTreeMap<String, Vec<f64>> = [
            ("object_x", column(&moved)),
            ("object_y", column(&|_| 0.2)),
            ("object_theta", column(&|t| 0.1 * moved(t))),
            ("gripper_x", column(&|t| moved(t) - 0.6)),
            ("gripper_y", column(&|_| 0.2)),
            ("gripper_theta", column(&|t| 0.1 * moved(t))),
            ("force_x", column(&|t| push(t) + 0.5)),
            ("force_y", column(&|t| 0.1 * push(t) - 0.2)),
            ("torque_z", column(&|t| 0.03 * push(t))),
        ]
        .into_iter()
        .map(|(name, values)| (name.to_owned(), values))
        .collect();
        let episode = Episode { name: "push".to_owned(), t, columns, notes: BTreeMap::new() };
        Recording::new(toml::from_str(META).unwrap(), vec![episode]).unwrap()
    }

    #[test]
    fn preparation_commutes_with_unit_conversion() {
        let scales = Scales { length: 2.0, force: 0.5, time: 4.0 };
        let (plain, scaled) = (prepare(&recording()).unwrap(), {
            let options = Options { gravity: 9.80665 / scales.acceleration(), ..Options::default() };
            prepare_with(&recording().in_units(&scales), options).unwrap()
        });
        assert_eq!(scaled.mass_given, Some(20.0 / scales.mass()));
        assert_eq!(scaled.body.gyration, plain.body.gyration / 2.0);
        let (a, b) = (&plain.training[0], &scaled.training[0]);
        for (a, b) in a.wrench.iter().zip(&b.wrench) {
            assert_eq!(a.t / scales.time, b.t);
            assert!((a.reading[0] / scales.force - b.reading[0]).abs() < 1e-9);
            assert!((a.reading[2] / scales.torque() - b.reading[2]).abs() < 1e-9);
        }
        assert!((a.contact / scales.time - b.contact).abs() < 1e-9);
    }
}
