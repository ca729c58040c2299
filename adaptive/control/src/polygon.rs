//! Signed distances between polygons.

/// A simple polygon with a bounding circle and a bounding box.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    corners: Vec<[f64; 2]>,
    center: [f64; 2],
    radius: f64,
    bounding_box: BoundingBox,
}

/// Box with sides along the axes: least and greatest coordinates, m.
#[derive(Clone, Copy, Debug)]
struct BoundingBox {
    low: [f64; 2],
    high: [f64; 2],
}

impl BoundingBox {
    fn of(points: impl Iterator<Item = [f64; 2]>) -> Self {
        let empty = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        points.fold(empty, |Self { low, high }, p| Self {
            low: [low[0].min(p[0]), low[1].min(p[1])],
            high: [high[0].max(p[0]), high[1].max(p[1])],
        })
    }

    /// Greatest gap between two boxes along an axis, negative if they overlap. It is a lower bound of their distance.
    fn gap(&self, other: &Self) -> f64 {
        let along = |k: usize| (self.low[k] - other.high[k]).max(other.low[k] - self.high[k]);
        along(0).max(along(1))
    }
}

impl Outline {
    pub fn new(corners: Vec<[f64; 2]>) -> Self {
        let count = corners.len().max(1) as f64;
        let center = [0, 1].map(|k| corners.iter().map(|c| c[k]).sum::<f64>() / count);
        let radius = corners.iter().map(|c| point_distance(*c, center)).fold(0.0, f64::max);
        let bounding_box = BoundingBox::of(corners.iter().copied());
        Self { corners, center, radius, bounding_box }
    }

    /// Distance from a point, negative inside, m.
    pub fn distance(&self, point: [f64; 2]) -> f64 {
        let (mut min_distance, mut inside) = (f64::INFINITY, false);
        let [x, y] = point;
        let mut a = self.corners.last().copied().unwrap_or_default();
        for &b in &self.corners {
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let (px, py) = (x - a[0], y - a[1]);
            let along = ((px * dx + py * dy) / (dx * dx + dy * dy).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let (ox, oy) = (px - along * dx, py - along * dy);
            min_distance = min_distance.min(ox * ox + oy * oy);
            inside ^= (a[1] > y) != (b[1] > y) && x < dx * (y - a[1]) / dy + a[0];
            a = b;
        }
        if inside { -min_distance.sqrt() } else { min_distance.sqrt() }
    }

    /// Signed distance to another outline at a pose, negative for an overlap, m. If the bounding circles or boxes are farther
    /// apart than `enough`, their distance is returned as a lower bound. Without crossing edges the minimum is at a corner.
    /// `(sin, cos)` are those of the heading of the pose.
    pub fn distance_from(&self, other: &Self, [x, y]: [f64; 2], (sin, cos): (f64, f64), enough: f64) -> f64 {
        let to_world = |[a, b]: [f64; 2]| [x + cos * a - sin * b, y + sin * a + cos * b];
        let circle_distance =
            point_distance(to_world(other.center), self.center) - self.radius - other.radius;
        if circle_distance > enough {
            return circle_distance;
        }
        let to_object = |[a, b]: [f64; 2]| {
            let (dx, dy) = (a - x, b - y);
            [cos * dx + sin * dy, cos * dy - sin * dx]
        };
        let in_object = BoundingBox::of(self.corners.iter().map(|&corner| to_object(corner)));
        let in_world = || BoundingBox::of(other.corners.iter().map(|&corner| to_world(corner)));
        let mut gap = in_object.gap(&other.bounding_box);
        if gap <= enough {
            gap = gap.max(in_world().gap(&self.bounding_box));
        }
        if gap > enough {
            return gap;
        }
        let theirs = other.corners.iter().map(|&corner| self.distance(to_world(corner)));
        let ours = self.corners.iter().map(|&corner| other.distance(to_object(corner)));
        let min_distance = theirs.chain(ours).fold(f64::INFINITY, f64::min);
        // Outlines can cross without any corner inside the other, such as a wall through the middle of a table.
        if min_distance > 0.0 && self.crosses(other, to_world) {
            -self.penetration_depth(other, to_world)
        } else {
            min_distance
        }
    }

    fn crosses(&self, other: &Self, to_world: impl Fn([f64; 2]) -> [f64; 2]) -> bool {
        let side = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        other.edges().any(|(c, d)| {
            let (c, d) = (to_world(c), to_world(d));
            self.edges()
                .any(|(a, b)| side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0)
        })
    }

    /// Penetration depth along the edge normals of `self`, m.
    fn penetration_depth(&self, other: &Self, to_world: impl Fn([f64; 2]) -> [f64; 2]) -> f64 {
        let span = |corners: &mut dyn Iterator<Item = [f64; 2]>, n: [f64; 2]| {
            corners.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| {
                let along = c[0] * n[0] + c[1] * n[1];
                (low.min(along), high.max(along))
            })
        };
        let overlap = |(a, b): ([f64; 2], [f64; 2])| {
            let length = point_distance(a, b).max(f64::MIN_POSITIVE);
            let n = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
            let (low, high) = span(&mut self.corners.iter().copied(), n);
            let (from, to) = span(&mut other.corners.iter().map(|&c| to_world(c)), n);
            (high - from).min(to - low)
        };
        self.edges().map(overlap).fold(f64::INFINITY, f64::min).max(0.0)
    }

    fn edges(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(&a, &b)| (a, b))
    }
}

fn point_distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (x, y) = (a[0] - b[0], a[1] - b[1]);
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(outline: &Outline, other: &Outline, [x, y, theta]: [f64; 3], enough: f64) -> f64 {
        outline.distance_from(other, [x, y], theta.sin_cos(), enough)
    }

    fn square(half: f64) -> Outline {
        Outline::new(vec![[-half, -half], [half, -half], [half, half], [-half, half]])
    }

    #[test]
    fn distances_are_signed() {
        let l = Outline::new(vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]);
        for (point, expected) in
            [([1.5, 1.5], 0.5), ([0.5, 0.5], -0.5), ([3.0, 0.5], 1.0), ([3.0, -1.0], 2f64.sqrt())]
        {
            assert!((l.distance(point) - expected).abs() < 1e-12, "{point:?}");
        }
    }

    #[test]
    fn outline_distance_is_that_of_the_nearest_points() {
        let (wall, table) = (square(1.0), square(0.5));
        assert!((distance(&wall, &table, [2.0, 0.0, 0.0], 9.0) - 0.5).abs() < 1e-12);
        // Turned by 45 degrees, a corner is nearest.
        let turned = distance(&wall, &table, [2.0, 0.0, std::f64::consts::FRAC_PI_4], 9.0);
        assert!((turned - (1.0 - 0.5f64.sqrt())).abs() < 1e-12);
        assert!((distance(&wall, &table, [1.3, 0.0, 0.0], 9.0) + 0.2).abs() < 1e-12, "0.2 m deep");
        // A thin wall through the middle.
        let thin = Outline::new(vec![[-0.05, -3.0], [0.05, -3.0], [0.05, 3.0], [-0.05, 3.0]]);
        assert!((distance(&thin, &table, [0.2, 0.3, 0.0], 9.0) + 0.35).abs() < 1e-12);
        // The bounding circles, or else the boxes, give a lower bound.
        let far = distance(&wall, &table, [9.0, 0.0, 0.0], 1.0);
        assert!(far > 1.0 && far <= 7.5);
        let beside = distance(&thin, &table, [1.3, 2.0, 0.4], 0.1);
        assert!(beside > 0.1 && beside < distance(&thin, &table, [1.3, 2.0, 0.4], 9.0) + 1e-12);
    }

    #[test]
    fn a_lower_bound_replaces_only_distances_above_enough() {
        let l = Outline::new(vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]);
        let table = square(0.5);
        let (mut near, mut far) = (0, 0);
        for k in 0..4000 {
            let k = f64::from(k);
            let pose = [6.0 * (k * 0.618).fract() - 2.0, 6.0 * (k * 0.414).fract() - 2.0, k];
            let (exact, bounded) = (distance(&l, &table, pose, 99.0), distance(&l, &table, pose, 0.06));
            if exact > 0.06 {
                assert!(bounded > 0.06 && bounded < exact + 1e-12, "{pose:?} {exact} {bounded}");
                far += usize::from(bounded < exact);
            } else {
                assert!(bounded == exact, "{pose:?} {exact} {bounded}");
                near += 1;
            }
        }
        assert!(near > 500 && far > 500, "{near} {far}");
    }
}
