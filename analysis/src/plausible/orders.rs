//! The 48 ways in which three axes can stand for three others.

/// One of them: body axis `i` is the sensor's axis `axis[i]`, with its sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Order {
    /// Which axis of the sensor stands for x, y, z.
    pub axis: [usize; 3],
    /// Which of them are turned round.
    pub minus: [bool; 3],
}

impl Order {
    /// All of them; the first is `x,y,z`.
    pub fn all() -> impl Iterator<Item = Order> {
        const AXES: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        AXES.into_iter().flat_map(|axis| {
            (0..8_u8).map(move |signs| Order { axis, minus: [0, 1, 2].map(|i| signs >> i & 1 == 1) })
        })
    }

    /// Whether every axis stands for itself.
    pub fn is_own(&self) -> bool {
        self.axis == [0, 1, 2] && self.minus == [false; 3]
    }

    /// Whether it turns right hands into left ones: no mounting does, a driver's fault does.
    pub fn is_mirrored(&self) -> bool {
        let even = matches!(self.axis, [0, 1, 2] | [1, 2, 0] | [2, 0, 1]);
        even != (self.minus.iter().filter(|minus| **minus).count() % 2 == 0)
    }

    /// The same axes, all turned round.
    pub fn opposite(&self) -> Order {
        Order { axis: self.axis, minus: self.minus.map(|minus| !minus) }
    }

    /// The order that undoes it.
    pub fn back(&self) -> Order {
        let mut back = *self;
        for (i, (&axis, &minus)) in self.axis.iter().zip(&self.minus).enumerate() {
            if let (Some(to), Some(sign)) = (back.axis.get_mut(axis), back.minus.get_mut(axis)) {
                (*to, *sign) = (i, minus);
            }
        }
        back
    }

    /// As `--rotate` takes it: `y,-x,z`.
    pub fn name(&self) -> String {
        let word =
            |i: usize| format!("{}{}", if self.minus[i] { "-" } else { "" }, ["x", "y", "z"][self.axis[i]]);
        [word(0), word(1), word(2)].join(",")
    }

    /// The sign of body axis `i`.
    pub fn sign(&self, i: usize) -> f64 {
        if self.minus[i] { -1.0 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_all_orders_are_mirrored() {
        let all: Vec<Order> = Order::all().collect();
        assert_eq!(all.len(), 48);
        assert!(all[0].is_own() && !all[0].is_mirrored());
        assert_eq!(all.iter().filter(|order| order.is_mirrored()).count(), 24);
        assert!(all.iter().all(|order| order.back().back() == *order));
        let cyclic = all.iter().find(|order| order.name() == "y,z,-x").map(|order| order.back().name());
        assert_eq!(cyclic.as_deref(), Some("-z,x,y"));
        let names: std::collections::BTreeSet<String> = all.iter().map(Order::name).collect();
        assert_eq!(names.len(), 48);
        let mirror = |name: &str| all.iter().find(|order| order.name() == name).map(Order::is_mirrored);
        assert_eq!(
            (mirror("y,x,z"), mirror("y,x,-z"), mirror("-x,y,z"), mirror("y,-x,z")),
            (Some(true), Some(false), Some(true), Some(false))
        );
    }
}
