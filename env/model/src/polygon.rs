//! Moments of simple polygons.

/// Area, first moments and polar second moment about the origin of a simple polygon.
///
/// `vertices` in m, either orientation; a point or a segment has area zero.
pub(crate) fn moments(vertices: &[[f64; 2]]) -> (f64, [f64; 2], f64) {
    let (mut area, mut first, mut polar) = (0.0, [0.0; 2], 0.0);
    for (i, &[ax, ay]) in vertices.iter().enumerate() {
        let [bx, by] = vertices[(i + 1) % vertices.len()];
        let cross = ax * by - bx * ay;
        area += cross / 2.0;
        first[0] += cross * (ax + bx) / 6.0;
        first[1] += cross * (ay + by) / 6.0;
        polar += cross * (ax * ax + ax * bx + bx * bx + ay * ay + ay * by + by * by) / 12.0;
    }
    let sign = area.signum();
    (area * sign, first.map(|m| m * sign), polar * sign)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangle_in_both_orientations() {
        let mut corners = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
        for _ in 0..2 {
            let (area, first, polar) = moments(&corners);
            assert!((area - 2.0).abs() < 1e-15);
            assert!((first[0] - 2.0).abs() < 1e-15 && (first[1] - 1.0).abs() < 1e-15);
            // ∫(x² + y²) = 2³/3 + 2/3
            assert!((polar - 10.0 / 3.0).abs() < 1e-14);
            corners.reverse();
        }
    }
}
