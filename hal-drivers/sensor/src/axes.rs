//! How a chip sits on its board.

/// One of the chip's axes, or the opposite of one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Axis {
    X,
    Y,
    Z,
    MinusX,
    MinusY,
    MinusZ,
}

impl Axis {
    const ALL: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::MinusX, Axis::MinusY, Axis::MinusZ];

    const fn index(self) -> usize {
        match self {
            Axis::X | Axis::MinusX => 0,
            Axis::Y | Axis::MinusY => 1,
            Axis::Z | Axis::MinusZ => 2,
        }
    }

    const fn is_reversed(self) -> bool {
        matches!(self, Axis::MinusX | Axis::MinusY | Axis::MinusZ)
    }

    const fn of<T: Copy>(self, [x, y, z]: [T; 3]) -> T {
        match self {
            Axis::X | Axis::MinusX => x,
            Axis::Y | Axis::MinusY => y,
            Axis::Z | Axis::MinusZ => z,
        }
    }
}

/// Which of the chip's axes points along each of the board's: x to the front, y to the right, z down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisMap([Axis; 3]);

impl Default for AxisMap {
    /// [`AxisMap::IDENTITY`].
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl AxisMap {
    /// The chip's axes are the board's.
    pub const IDENTITY: Self = Self([Axis::X, Axis::Y, Axis::Z]);

    /// The chip's axis along the board's x, y and z; `None` where one of the chip's axes is named twice.
    pub const fn new(chip_axes: [Axis; 3]) -> Option<Self> {
        let [x, y, z] = [chip_axes[0].index(), chip_axes[1].index(), chip_axes[2].index()];
        if x == y || y == z || x == z { None } else { Some(Self(chip_axes)) }
    }

    /// The chip's axes, in the order of the board's.
    pub const fn axes(self) -> [Axis; 3] {
        self.0
    }

    /// Counts in the board's axes. The one count without an opposite, −32 768, becomes the one next to it: both are the
    /// end of the range and no measurement.
    #[inline]
    pub fn counts(self, chip: [i16; 3]) -> [i16; 3] {
        self.0.map(|axis| {
            let count = axis.of(chip);
            if axis.is_reversed() { count.saturating_neg() } else { count }
        })
    }

    /// A vector in the board's axes.
    #[inline]
    pub fn vector(self, chip: [f32; 3]) -> [f32; 3] {
        self.0.map(|axis| if axis.is_reversed() { -axis.of(chip) } else { axis.of(chip) })
    }

    /// What has no sign (a scale, a flag) in the board's axes.
    #[inline]
    pub fn unsigned<T: Copy>(self, chip: [T; 3]) -> [T; 3] {
        self.0.map(|axis| axis.of(chip))
    }

    /// A number for each of the 48 maps, 1 to 48, for records that outlive the program.
    pub fn code(self) -> u8 {
        // The place in the list of all maps is the number: the list's order never changes.
        Self::all().position(|map| map == self).map_or(0, |place| place as u8 + 1)
    }

    /// The map of a [`Self::code`]; `None` for any other number.
    pub fn of_code(code: u8) -> Option<Self> {
        Self::all().nth(usize::from(code.checked_sub(1)?))
    }

    fn all() -> impl Iterator<Item = Self> {
        let axes = || Axis::ALL.into_iter();
        axes().flat_map(move |x| axes().flat_map(move |y| axes().filter_map(move |z| Self::new([x, y, z]))))
    }
}

#[cfg(test)]
mod tests {
    use super::{Axis, AxisMap};

    #[test]
    fn there_are_48_maps_and_each_has_a_code_of_its_own() {
        assert_eq!(AxisMap::all().count(), 48);
        for (place, map) in AxisMap::all().enumerate() {
            assert_eq!(usize::from(map.code()), place + 1);
            assert_eq!(AxisMap::of_code(map.code()), Some(map));
        }
        assert_eq!(AxisMap::IDENTITY.code(), 1);
        assert_eq!((AxisMap::of_code(0), AxisMap::of_code(49)), (None, None));
        assert_eq!(AxisMap::new([Axis::X, Axis::MinusX, Axis::Z]), None);
    }

    #[test]
    fn a_map_moves_and_turns_and_the_end_of_the_range_stays_one() {
        let map = AxisMap::new([Axis::MinusZ, Axis::X, Axis::MinusY]).unwrap();
        assert_eq!(map.counts([1, 2, 3]), [-3, 1, -2]);
        assert_eq!(map.counts([i16::MIN, i16::MIN, 0]), [0, i16::MIN, i16::MAX]);
        assert_eq!(map.unsigned([0.1, 0.2, 0.3]), [0.3, 0.1, 0.2]);
    }
}
