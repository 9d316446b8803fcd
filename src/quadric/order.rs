//! Which parameters the data carry.

/// Which of the quadric's nine columns carry a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// All nine: offset, gains, non-orthogonality.
    Ellipsoid,
    /// Six: offset and gains, axes orthogonal.
    AxisAligned,
    /// Four: offset and one scale.
    Sphere,
}

impl Order {
    /// Number of parameters of the quadric.
    pub const fn parameters(self) -> usize {
        match self {
            Self::Ellipsoid => 9,
            Self::AxisAligned => 6,
            Self::Sphere => 4,
        }
    }

    /// A word for reports: `ellipsoid`, `axis-aligned`, `sphere`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ellipsoid => "ellipsoid",
            Self::AxisAligned => "axis-aligned",
            Self::Sphere => "sphere",
        }
    }

    /// Whether a column of [`super::gram::gram`] carries a parameter.
    pub(crate) const fn uses(self, column: usize) -> bool {
        match self {
            Self::Ellipsoid => true,
            Self::AxisAligned => column < 2 || column > 4,
            Self::Sphere => column > 4,
        }
    }
}
