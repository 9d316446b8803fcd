//! What the alignment with the accelerometer finds: reported like effects, but the base model contains them.
//!
//! A dip cannot tell a field from its opposite, and so a mounting from the mirror image with every sign turned round. The
//! hemisphere (where the log was recorded) and a reference heading can. Where neither is known, it is said.

use crate::base::order::AxisOrder;
use serde::Serialize;

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
/// The magnetometer is mounted turned by right angles, or a driver mirrors its axes.
pub const AXIS_ORDER: Mounting = Mounting { id: "axis-order", name: "axis order" };

/// Both.
pub const ALL: [Mounting; 2] = [MISALIGNMENT, AXIS_ORDER];

/// What a log without an accelerometer is told.
pub const WITHOUT_DOWN: &str = "no accelerometer: log ax_mps2,ay_mps2,az_mps2";
/// What somebody is told who asks for one of them.
pub const NOT_TO_ADD: &str = "this effect cannot be added: if the log has an accelerometer (ax_mps2,ay_mps2,az_mps2), the \
     alignment is always part of the fit";

/// Whether an id is that of one of them.
pub fn is_one(id: &str) -> bool {
    ALL.iter().any(|one| one.id == id)
}

/// What tells a field from its opposite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DecidedBy {
    /// The log's `heading_deg`.
    Heading,
    /// The known dip of the place.
    Place,
}

/// Why what is known does not tell a field from its opposite.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Doubt {
    /// Neither heading nor place is known.
    NothingKnown,
    /// The field there is nearly level.
    LevelField {
        /// Dip of the place, degrees.
        expected_deg: f64,
    },
    /// The log's dip is neither that of the place nor its opposite.
    OtherDip {
        /// Dip of the place, degrees.
        expected_deg: f64,
    },
    /// The headings are wrong either way.
    OtherHeading {
        /// Rms of their error with the field as the mounting has it, degrees.
        own_deg: f64,
        /// The same with its opposite.
        opposite_deg: f64,
    },
    /// The heading says one and the place the other.
    Contradiction,
}

/// How the axes of the log's magnetometer stand to those of its accelerometer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OrderStatus {
    /// Which axis of the board each axis of the log stands for. Where nothing decides it: the mounting of the two that are
    /// possible, this and its [`opposite`](AxisOrder::opposite).
    pub order: AxisOrder,
    /// The dip of the corrected field with that order, degrees below the horizon.
    pub dip_deg: f64,
    /// What decided it.
    pub decided: Result<DecidedBy, Doubt>,
    /// Whether it is the gyro that tells the order: the accelerometer has measured more than gravity.
    pub by_gyro: bool,
}

impl OrderStatus {
    /// Whether the order is a mirror image, beyond doubt: the driver is at fault.
    pub fn is_mirrored(&self) -> bool {
        self.order.is_mirror()
    }

    /// Whether the axes are not in order, and nothing tells a mounting from a mirror image.
    pub fn is_open(&self) -> bool {
        self.decided.is_err() && !self.order.is_in_order()
    }

    /// The order, where the axes do not stand for themselves.
    pub fn swapped(&self) -> Option<AxisOrder> {
        Some(self.order).filter(|order| !order.is_in_order())
    }

    /// The readings of the log that are possible, each an option `--rotate` with what it means; empty where the axes are in
    /// order and nothing speaks against it.
    pub fn readings(&self) -> Vec<(String, String)> {
        let one = |order: AxisOrder, dip_deg: f64| {
            let cause = if order.is_mirror() {
                format!("the driver mirrors its axes, which correspond to {order}")
            } else {
                format!("it is mounted rotated {} (its axes correspond to {order})", order.turn_in_words())
            };
            (order.rotate(), format!("{cause}: the field then points {}", dip_in_words(dip_deg)))
        };
        match (self.is_open(), self.swapped()) {
            (true, _) => vec![one(self.order, self.dip_deg), one(self.order.opposite(), -self.dip_deg)],
            (false, Some(order)) => vec![one(order, self.dip_deg)],
            (false, None) => Vec::new(),
        }
    }

    /// What to know about the axes, and what to do, in sentences; empty where they are in order beyond doubt.
    pub fn words(&self) -> Vec<String> {
        let against = if self.by_gyro {
            "compared with the gyro, the magnetometer's axes correspond to"
        } else {
            "compared with the accelerometer, the magnetometer's axes correspond to"
        };
        let order = self.order;
        match self.decided {
            Err(doubt) if order.is_in_order() => vec![format!(
                "The field points {}. If this log is from the other side of the magnetic equator, all three axes are \
                 inverted (a fault of the driver). To check: {}",
                dip_in_words(self.dip_deg),
                doubt.words()
            )],
            Err(doubt) => {
                let mut list = vec![format!(
                    "{against} {order} or to {}. The dip cannot show which of the two, nor distinguish a heading from its \
                     opposite. To check: {}",
                    order.opposite(),
                    doubt.words()
                )];
                let candidates = self.readings().into_iter();
                list.extend(candidates.map(|(rotate, cause)| format!("--rotate {rotate} if {cause}")));
                list
            }
            Ok(by) if order.is_mirror() => vec![
                format!(
                    "{against} {order}. This is a left-handed system, so it cannot be a mounting ({})",
                    by.words(self.dip_deg)
                ),
                format!(
                    "The driver swaps axes or has a wrong sign. Fix: correct the driver, or read the log with --rotate {}",
                    order.rotate()
                ),
            ],
            Ok(_) if order.is_in_order() => Vec::new(),
            Ok(by) => vec![
                format!(
                    "{against} {order}. The sensor is mounted rotated {} ({})",
                    order.turn_in_words(),
                    by.words(self.dip_deg)
                ),
                format!("To get the log in the vehicle's axes, read it with --rotate {}", order.rotate()),
            ],
        }
    }
}

impl DecidedBy {
    /// Its word in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            DecidedBy::Heading => "heading",
            DecidedBy::Place => "place",
        }
    }

    fn words(self, dip_deg: f64) -> String {
        let by = match self {
            DecidedBy::Heading => "heading_deg tells",
            DecidedBy::Place => "known from the dip of the place",
        };
        format!("{by}; the field points {}", dip_in_words(dip_deg))
    }
}

impl Doubt {
    /// Why it is not known, and what would tell.
    fn words(self) -> String {
        match self {
            Doubt::NothingKnown => "use --at LAT,LON,DATE, or log heading_deg".into(),
            Doubt::LevelField { expected_deg } => {
                format!("at a dip of {expected_deg:.0}° the place is not sufficient, so log heading_deg")
            }
            Doubt::OtherDip { expected_deg } => format!(
                "the dip of the place, {expected_deg:.0}°, is neither this nor its opposite. Check --at, and look for iron \
                 nearby"
            ),
            Doubt::OtherHeading { own_deg, opposite_deg } => format!(
                "heading_deg differs by {own_deg:.0}° rms with these axes and by {opposite_deg:.0}° with inverted axes. \
                 Check its column and the accelerometer's axes"
            ),
            Doubt::Contradiction => {
                "heading_deg and --at contradict each other. Check the place and the sign of the accelerometer"
                    .into()
            }
        }
    }
}

/// Where the corrected field points.
pub fn dip_in_words(dip_deg: f64) -> String {
    format!("{:.0}° {} the horizon", dip_deg.abs(), if dip_deg < 0.0 { "above" } else { "below" })
}
