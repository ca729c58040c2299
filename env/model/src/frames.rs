//! Transformations of vectors and wrenches between frames.

use crate::Real;
use crate::heading::Heading;

/// Rotate a vector `[x, y, about z]` from world axes to the axes of a frame at `angle`.
pub fn to_body<T: Real>(v: [T; 3], angle: T) -> [T; 3] {
    Heading::of(angle).to_body(v)
}

/// Rotate a vector `[x, y, about z]` from the axes of a frame at `angle` to world axes.
pub fn to_world<T: Real>(v: [T; 3], angle: T) -> [T; 3] {
    Heading::of(angle).to_world(v)
}

/// Transform a wrench from a frame at `frame = [x, y, angle]` on the object to object axes about the object origin
/// (planar form of eq. 11).
#[inline]
pub fn transport<T: Real>(wrench: [T; 3], frame: [f64; 3]) -> [T; 3] {
    let (sin, cos) = frame[2].sin_cos();
    let [wx, wy, torque] = wrench;
    let fx = T::chained(wx.re() * cos - wy.re() * sin, [(wx, cos), (wy, -sin)]);
    let fy = T::chained(wx.re() * sin + wy.re() * cos, [(wx, sin), (wy, cos)]);
    let [x, y, _] = frame;
    let about = T::chained(torque.re() + fy.re() * x - fx.re() * y, [(torque, 1.0), (fy, x), (fx, -y)]);
    [fx, fy, about]
}

/// The twist of a body at a point offset by `[x, y]` from the point where `twist` is given.
#[inline(always)]
pub(crate) fn twist_at<T: Real>([vx, vy, spin]: [T; 3], [x, y]: [T; 2]) -> [T; 3] {
    let (px, py, turn) = (x.re(), y.re(), spin.re());
    [
        T::chained(vx.re() - turn * py, [(vx, 1.0), (spin, -py), (y, -turn)]),
        T::chained(vy.re() + turn * px, [(vy, 1.0), (spin, px), (x, turn)]),
        spin,
    ]
}
