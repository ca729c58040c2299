//! Test for simple polygons.

type Point = [f64; 2];

/// Why `corners` (m) are not a simple polygon; `None` if they are, in either orientation.
pub(super) fn fault(corners: &[Point]) -> Option<String> {
    let n = corners.len();
    if n < 3 {
        return Some(format!("{n} corners do not form a polygon"));
    }
    if let Some(i) = corners.iter().position(|corner| !corner.iter().all(|x| x.is_finite())) {
        return Some(format!("corner {} is {:?}, which is not finite", i + 1, corners[i]));
    }
    let edge = |i: usize| [corners[i], corners[(i + 1) % n]];
    if let Some(i) = (0..n).find(|&i| edge(i)[0] == edge(i)[1]) {
        return Some(format!("corners {} and {} are both {:?}", i + 1, (i + 1) % n + 1, corners[i]));
    }
    (0..n).find_map(|i| {
        let crossed = |&j: &usize| match j == i + 1 || (i == 0 && j == n - 1) {
            true => overlaps(edge(i), edge(j)),
            false => intersects(edge(i), edge(j)),
        };
        let j = (i + 1..n).find(crossed)?;
        Some(format!("edge {} ({:?}) intersects edge {} ({:?})", i + 1, edge(i), j + 1, edge(j)))
    })
}

/// Twice the signed area of the triangle a, b, c.
fn cross(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether two edges that do not share a corner have a common point.
fn intersects([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let [of_c, of_d] = [cross(a, b, c), cross(a, b, d)];
    let [of_a, of_b] = [cross(c, d, a), cross(c, d, b)];
    if of_c * of_d < 0.0 && of_a * of_b < 0.0 {
        return true;
    }
    (of_c == 0.0 && between(a, b, c))
        || (of_d == 0.0 && between(a, b, d))
        || (of_a == 0.0 && between(c, d, a))
        || (of_b == 0.0 && between(c, d, b))
}

/// Whether `p`, a point on the line through a and b, lies between them.
fn between(a: Point, b: Point, p: Point) -> bool {
    (0..2).all(|k| a[k].min(b[k]) <= p[k] && p[k] <= a[k].max(b[k]))
}

/// Whether two edges that share a corner overlap.
fn overlaps([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let (shared, p, q) = if b == c { (b, a, d) } else { (a, b, c) };
    let dot = (p[0] - shared[0]) * (q[0] - shared[0]) + (p[1] - shared[1]) * (q[1] - shared[1]);
    cross(shared, p, q) == 0.0 && dot > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simple_polygons_in_both_orientations() {
        let mut shape = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        assert_eq!(fault(&shape), None);
        shape.reverse();
        assert_eq!(fault(&shape), None);
        assert_eq!(fault(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), None);
        // A corner on a straight side is allowed.
        assert_eq!(fault(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0]]), None);
    }

    #[test]
    fn other_lists_of_corners_are_refused() {
        let cases: [(&[Point], &str); 7] = [
            (&[[0.0, 0.0], [1.0, 1.0]], "2 corners"),
            (&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], "edge 1"),
            (&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "corners 1 and 2"),
            (&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], "intersects"),
            (&[[0.0, 0.0], [1.0, 0.0], [0.5, 0.0], [0.0, 1.0]], "intersects"),
            (&[[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], "intersects"),
            (&[[0.0, 0.0], [f64::NAN, 0.0], [0.0, 1.0]], "not finite"),
        ];
        for (corners, expected) in cases {
            let found = fault(corners).unwrap_or_default();
            assert!(found.contains(expected), "{corners:?}: {found:?}");
        }
    }
}
