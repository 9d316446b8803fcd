//! Signed permutations of axes: 24 are turns, which a mounting can make, and 24 are mirror images, which only a driver can.

use nalgebra::Matrix3;
use std::fmt;

const NAMES: [&str; 3] = ["x", "y", "z"];

/// Which axis of the board each axis of the log stands for, with its sign: `y,-x,z` means that the log's first axis is the
/// board's y, and its second the board's x turned round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisOrder {
    axes: [usize; 3],
    minus: [bool; 3],
}

impl AxisOrder {
    /// Every axis stands for itself.
    pub const IN_ORDER: Self = AxisOrder { axes: [0, 1, 2], minus: [false; 3] };

    /// All 48.
    pub fn all() -> impl Iterator<Item = Self> {
        const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        ORDERS.into_iter().flat_map(|axes| {
            (0..8_u32).map(move |signs| AxisOrder { axes, minus: [0, 1, 2].map(|j| signs >> j & 1 == 1) })
        })
    }

    /// The 24 that a mounting can make.
    pub fn mountings() -> impl Iterator<Item = Self> {
        Self::all().filter(|order| !order.is_mirror())
    }

    /// The mounting that leaves the least rotation beside it, and the angle of that, degrees.
    pub fn nearest(rotation: &Matrix3<f64>) -> (Self, f64) {
        let left = |order: &Self| {
            let rest = rotation * order.to_board().transpose();
            ((rest.trace() - 1.0) / 2.0).clamp(-1.0, 1.0).acos().to_degrees()
        };
        let all = Self::mountings().map(|order| (order, left(&order)));
        all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((Self::IN_ORDER, left(&Self::IN_ORDER)))
    }

    /// Whether it turns right hands into left ones: then no rotation mends it.
    pub fn is_mirror(&self) -> bool {
        self.to_board().determinant() < 0.0
    }

    /// Whether every axis stands for itself.
    pub fn is_in_order(&self) -> bool {
        *self == Self::IN_ORDER
    }

    /// The same with every sign turned round: what a dip cannot tell from it.
    pub fn opposite(&self) -> Self {
        AxisOrder { axes: self.axes, minus: self.minus.map(|minus| !minus) }
    }

    /// `P` in `board = P · log`.
    pub fn to_board(&self) -> Matrix3<f64> {
        let sign = |j: usize| if self.minus[j] { -1.0 } else { 1.0 };
        Matrix3::from_fn(|i, j| if self.axes[j] == i { sign(j) } else { 0.0 })
    }

    /// What `--rotate` takes to put the magnetometer's axes in order: the log's axes that become the board's x, y, z.
    pub fn rotate(&self) -> String {
        let names = [0, 1, 2].map(|body| {
            let place = (0..3).find(|&j| self.axes[j] == body).unwrap_or_default();
            format!("{}{}", if self.minus[place] { "-" } else { "" }, NAMES[place])
        });
        format!("mag:{}", names.join(","))
    }

    /// How a mounting is turned, in words: `by 180° about x`.
    pub fn turn_in_words(&self) -> String {
        let p = self.to_board();
        let angle_deg = ((p.trace() - 1.0) / 2.0).clamp(-1.0, 1.0).acos().to_degrees();
        match (0..3).find(|&axis| p[(axis, axis)] > 0.5) {
            Some(axis) if angle_deg > 1.0 => {
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                let signed = if p[(last, next)] < -0.5 { -angle_deg } else { angle_deg };
                format!("by {signed:.0}° about {}", NAMES[axis])
            }
            _ => format!("by {angle_deg:.0}° about a diagonal"),
        }
    }
}

impl fmt::Display for AxisOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for j in 0..3 {
            let (comma, minus) = (if j > 0 { "," } else { "" }, if self.minus[j] { "-" } else { "" });
            write!(f, "{comma}{minus}{}", NAMES[self.axes[j]])?;
        }
        Ok(())
    }
}

impl serde::Serialize for AxisOrder {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(text: &str) -> AxisOrder {
        AxisOrder::all().find(|order| order.to_string() == text).expect(text)
    }

    #[test]
    fn half_of_all_orders_are_mountings_and_the_opposite_of_one_is_none() {
        assert_eq!((AxisOrder::all().count(), AxisOrder::mountings().count()), (48, 24));
        for order in AxisOrder::all() {
            assert_ne!(order.is_mirror(), order.opposite().is_mirror(), "{order}");
            assert_eq!(order.opposite().opposite(), order);
        }
        for (order, mirror) in
            [("x,y,z", false), ("y,x,z", true), ("y,x,-z", false), ("y,z,x", false), ("-x,-y,-z", true)]
        {
            assert_eq!(named(order).is_mirror(), mirror, "{order}");
        }
    }

    #[test]
    fn the_option_undoes_the_order() {
        for (order, option) in [("y,x,z", "mag:y,x,z"), ("y,z,x", "mag:z,x,y"), ("-y,x,z", "mag:y,-x,z")] {
            assert_eq!(named(order).rotate(), option);
        }
    }

    #[test]
    fn the_nearest_is_itself_and_all_half_turns_have_words() {
        for order in AxisOrder::mountings() {
            let (nearest, left_deg) = AxisOrder::nearest(&order.to_board());
            assert!(nearest == order && left_deg < 1e-5, "{order}: {nearest} and {left_deg}");
        }
        for (order, words) in [
            ("x,-y,-z", "by 180° about x"),
            ("-x,y,-z", "by 180° about y"),
            ("-x,-y,z", "by 180° about z"),
            ("y,-x,z", "by 90° about z"),
            ("-y,x,z", "by -90° about z"),
            ("y,z,x", "by 120° about a diagonal"),
        ] {
            assert_eq!(named(order).turn_in_words(), words);
        }
    }
}
