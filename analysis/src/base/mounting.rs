//! What the alignment with the accelerometer finds: reported like effects, but the base model contains them.

/// A finding of the alignment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mounting {
    /// Its id among the candidates.
    pub id: &'static str,
    /// Its name.
    pub name: &'static str,
}

/// The sensors' axes differ by a rotation.
pub const MISALIGNMENT: Mounting = Mounting { id: "misalignment", name: "misalignment" };
/// A driver has the axes in another order, or turned round.
pub const AXIS_ORDER: Mounting = Mounting { id: "axis-order", name: "axis order" };

/// Both.
pub const ALL: [Mounting; 2] = [MISALIGNMENT, AXIS_ORDER];

/// What a log without an accelerometer is told.
pub const WITHOUT_DOWN: &str = "no direction down: log ax_mps2,ay_mps2,az_mps2";
/// What somebody is told who asks for one of them.
pub const NOT_TO_ADD: &str = "this is no effect to add: with an accelerometer in the log (ax_mps2,ay_mps2,az_mps2) the \
                              alignment is always part of the fit";

/// Whether an id is that of one of them.
pub fn is_one(id: &str) -> bool {
    ALL.iter().any(|one| one.id == id)
}
