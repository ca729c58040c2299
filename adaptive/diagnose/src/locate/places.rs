//! Places of a misfit.

/// A candidate place with its rank.
#[derive(Clone, Debug)]
pub(crate) struct RankedPlace {
    /// Coordinates in the object frame or in the world, depending on the list, m.
    pub at: [f64; 2],
    /// Standard deviations, m; infinite if unknown.
    pub sd: [f64; 2],
    /// Log likelihood, up to a constant per list.
    pub strength: f64,
    /// Remaining share of the squared moment about the place.
    pub residual_share: f64,
    /// Whether the place is not on the bounds of the search.
    pub is_inside: bool,
}

/// A region of the floor.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    /// Convex polygon, counter-clockwise, world, m.
    pub polygon: Vec<[f64; 2]>,
    /// χ² of a common viscous drag inside the region.
    pub chi_square: f64,
    /// Share of the visited cells.
    pub share: f64,
}
