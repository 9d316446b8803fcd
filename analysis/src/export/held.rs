//! What a target holds of a calibration: offset, matrix and effects in the sensor's own axes, in the shape that it has room
//! for, and what is left out.
//!
//! With the frame `measured = R·raw` a calibration is `corrected = M·R·(raw − Rᵀb − …)`. The polar decomposition
//! `M·R = U·S` splits it into a symmetric matrix, which alone makes the magnitude, and a rotation: the mounting, and next to
//! it a misalignment that a target without a full matrix cannot hold. Where the calibration was not aligned to an accelerometer
//! the rotation of its triangular matrix is a convention, and nothing is lost without it.

use crate::blocks::blocks;
use crate::effects::Calibrated;
use crate::export::error::CannotExport;
use crate::export::rotations::{Rotation, angle_deg};
use crate::frame::{Frame, Program};
use ironout::effect::{Id, Registry};
use nalgebra::{Matrix3, Vector3};

/// Angle up to which a target's mounting counts as the one that the calibration shows, degrees. The numbered mountings lie 45 apart.
const MAX_SAME_MOUNTING_DEG: f64 = 20.0;

/// The matrices that a target has room for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// None: an offset alone.
    Scalar,
    /// A factor for each axis.
    Diagonal,
    /// Six numbers.
    Symmetric,
    /// Nine numbers.
    Full,
}

/// Where a target has room for a mounting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turns {
    /// One of the numbered ones.
    Numbered,
    /// Any rotation.
    Any,
}

/// What a target has room for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Room {
    /// Its name, as people write it.
    pub name: &'static str,
    /// Its matrix.
    pub shape: Shape,
    /// Its mounting.
    pub turns: Turns,
    /// An offset in proportion to one current, or to the throttle.
    pub power: bool,
    /// An offset that follows one temperature, and its square.
    pub temperature: bool,
    /// The program that it is.
    pub program: Program,
}

/// What an effect that a target holds follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// A current, A.
    Current,
    /// The throttle, 0 to 1.
    Throttle,
    /// A temperature, °C.
    Temperature,
}

impl Cause {
    fn of(column: &str) -> Option<Self> {
        if column.contains("throttle") || column.contains("thrust") {
            Some(Cause::Throttle)
        } else if column.ends_with("_a") {
            Some(Cause::Current)
        } else if column.ends_with("_c") {
            Some(Cause::Temperature)
        } else {
            None
        }
    }

    fn is_power(self) -> bool {
        self != Cause::Temperature
    }
}

/// An offset that follows a column, held by a target: `coefficient · (xᵖ − reference)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Carried {
    /// Its id.
    pub id: String,
    /// Its place among the calibration's effects.
    pub place: usize,
    /// The column.
    pub column: String,
    /// What the column is.
    pub cause: Cause,
    /// Whether the square of the column acts.
    pub squared: bool,
    /// µT per unit, in the sensor's axes.
    pub coefficient_ut: Vector3<f64>,
    /// Where it vanishes: a value of the column, or of its square.
    pub reference: f64,
    /// The values of the column that it was fitted over.
    pub range: Option<[f64; 2]>,
}

impl Carried {
    /// What the coefficient is multiplied with.
    pub(crate) fn factor(&self, value: f64) -> f64 {
        (if self.squared { value * value } else { value }) - self.reference
    }

    /// How much it moves over its range, µT; its coefficient where no range is known.
    fn size_ut(&self) -> f64 {
        let span = self.range.map_or(1.0, |[least, most]| self.factor(most) - self.factor(least));
        self.coefficient_ut.norm() * span.abs()
    }
}

/// An effect that a target has no room for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dropped {
    /// Its id.
    pub id: String,
    /// Why.
    pub why: String,
}

/// A calibration as a target holds it.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// The target.
    pub room: Room,
    /// Hard iron and zero offset, µT in the sensor's axes.
    pub offset_ut: Vector3<f64>,
    /// In the sensor's axes, of the target's shape.
    pub matrix: Matrix3<f64>,
    /// From the axes of [`Held::offset_ut`] to those of the calibration.
    pub rotation: Matrix3<f64>,
    /// Program whose log the calibration is of.
    pub source: Program,
    /// The mounting to be set, among the numbered ones; `None` where the sensor's axes are mirrored, which only a full matrix
    /// holds, and where the target has the right one already.
    pub mounting: Option<Rotation>,
    /// From the sensor's axes to the body's after the matrix, as the target does it.
    pub turn: Matrix3<f64>,
    /// The rotation that the target cannot hold, degrees; `None` where the calibration knows none.
    pub lost_deg: Option<f64>,
    /// The effects that it holds.
    pub effects: Vec<Carried>,
    /// Those that it does not.
    pub dropped: Vec<Dropped>,
    /// Whether its matrix has less room than the calibration needs.
    pub narrowed: bool,
    /// The magnitude of corrected vectors, µT.
    pub field_ut: f64,
    /// Whether it was fitted again on a log.
    pub refitted: bool,
}

impl Held {
    /// Takes of a calibration what the target has room for.
    ///
    /// # Errors
    /// A matrix without an inverse, or axes that are mirrored.
    pub fn of(calibration: &Calibrated, frame: &Frame, room: Room) -> Result<Self, CannotExport> {
        let base = &calibration.base;
        let matrix = Matrix3::from_fn(|i, j| base.matrix[i][j]);
        let aligned = [(1, 0), (2, 0), (2, 1)].iter().any(|&(i, j)| base.matrix[i][j] != 0.0);
        let rotation = frame.rotation_for(room.program);
        // A triangular matrix has a rotation that nothing was asked about.
        let matrix = if aligned || room.shape == Shape::Full { matrix } else { polar(&matrix)?.1 };
        let whole = matrix * rotation;
        let (turned, symmetric) = polar(&whole)?;
        let mirrored = turned.determinant() < 0.0;
        if mirrored && room.shape != Shape::Full {
            return Err(CannotExport::Mirrored(room.name));
        }
        // What the target does to its sensor already is right unless the calibration shows another mounting.
        let there = frame.mounting_of(room.program);
        let there = there.filter(|there| angle_deg(&(turned * there.transpose())) < MAX_SAME_MOUNTING_DEG);
        let mounting = (!mirrored && there.is_none()).then(|| Rotation::nearest(&turned));
        let set = mounting.map(|mounting| mounting.matrix);
        let out = there.or(set).unwrap_or_else(Matrix3::identity);
        let (kept, turn) = match (room.shape, room.turns) {
            (Shape::Full, _) => (out.transpose() * whole, out),
            (_, Turns::Any) => (symmetric, turned),
            (_, Turns::Numbered) => (symmetric, out),
        };
        let shaped = of_shape(&kept, room.shape);
        let lost = turned * turn.transpose();
        let left_deg = if room.shape == Shape::Full { 0.0 } else { angle_deg(&lost) };
        let (effects, dropped) = effects(calibration, &rotation, room);
        Ok(Held {
            room,
            offset_ut: rotation.transpose() * Vector3::from(base.offset_ut),
            narrowed: (shaped - kept).norm() > 1e-9 * kept.norm(),
            matrix: shaped,
            rotation,
            source: frame.program,
            mounting,
            turn,
            lost_deg: aligned.then_some(left_deg),
            effects,
            dropped,
            field_ut: base.field_ut,
            refitted: false,
        })
    }

    /// Whether the target holds all that makes the magnitude.
    pub fn is_whole(&self) -> bool {
        self.dropped.is_empty() && !self.narrowed
    }

    /// The field that the target makes of a vector in the sensor's axes, µT in body axes; `values` are those of the columns
    /// of [`Held::effects`], in their order.
    pub fn apply(&self, sensor_ut: Vector3<f64>, values: &[f64]) -> Vector3<f64> {
        self.turn * self.matrix * self.centred(sensor_ut, values)
    }

    /// Whether the log is the target's own.
    pub fn is_own_log(&self) -> bool {
        self.source == self.room.program && self.source != Program::Other
    }

    /// A vector of the calibration's axes in those of the target's numbers, µT.
    pub(crate) fn to_sensor(&self, vector_ut: [f64; 3]) -> Vector3<f64> {
        self.rotation.transpose() * Vector3::from(vector_ut)
    }

    /// `sensor − offset − effects`, µT in the sensor's axes.
    pub(crate) fn centred(&self, sensor_ut: Vector3<f64>, values: &[f64]) -> Vector3<f64> {
        let effects = self.effects.iter().zip(values);
        effects.fold(sensor_ut - self.offset_ut, |left, (effect, value)| {
            left - effect.coefficient_ut * effect.factor(*value)
        })
    }

    /// The offset where each power that acts is zero, µT in the sensor's axes.
    pub(crate) fn offset_without_power_ut(&self) -> Vector3<f64> {
        let power = self.effects.iter().filter(|effect| effect.cause.is_power());
        power.fold(self.offset_ut, |offset, effect| offset - effect.coefficient_ut * effect.reference)
    }

    /// The effect of the current or the throttle, if it holds one.
    pub(crate) fn power(&self) -> Option<&Carried> {
        self.effects.iter().find(|effect| effect.cause.is_power())
    }
}

/// Rotation and symmetric matrix, `m = U·S`.
fn polar(m: &Matrix3<f64>) -> Result<(Matrix3<f64>, Matrix3<f64>), CannotExport> {
    let svd = m.try_svd(true, true, 1e-15, 500).ok_or(CannotExport::Singular)?;
    let (u, v_t) = svd.u.zip(svd.v_t).ok_or(CannotExport::Singular)?;
    let turned = u * v_t;
    let symmetric = v_t.transpose() * Matrix3::from_diagonal(&svd.singular_values) * v_t;
    let sound = svd.singular_values.min() > 0.0 && turned.iter().all(|value| value.is_finite());
    if sound { Ok((turned, (symmetric + symmetric.transpose()) * 0.5)) } else { Err(CannotExport::Singular) }
}

/// The nearest matrix of a shape to a symmetric one.
fn of_shape(matrix: &Matrix3<f64>, shape: Shape) -> Matrix3<f64> {
    match shape {
        Shape::Full | Shape::Symmetric => *matrix,
        Shape::Diagonal => Matrix3::from_diagonal(&matrix.diagonal()),
        Shape::Scalar => Matrix3::identity() * (matrix.trace() / 3.0),
    }
}

/// What a target has room for among the effects, and the rest with the reason.
fn effects(calibration: &Calibrated, rotation: &Matrix3<f64>, room: Room) -> (Vec<Carried>, Vec<Dropped>) {
    let (mut carried, mut dropped): (Vec<Carried>, Vec<Dropped>) = (Vec::new(), Vec::new());
    let nowhere = |id: &str| Dropped { id: id.into(), why: format!("{} has no parameter for it", room.name) };
    for (place, fitted) in calibration.effects.iter().enumerate() {
        let made = &fitted.effect;
        let id = Id(made).to_string();
        let parts = made.parts();
        let cause = Cause::of(parts.column.as_str());
        let squared = parts.form.is_squared();
        let follows = made.family().kind() == "offset" && !parts.form.is_late();
        let fits = match cause {
            Some(Cause::Temperature) => room.temperature,
            Some(_) => room.power && !squared,
            None => false,
        };
        match cause.filter(|_| follows && fits) {
            Some(cause) => carried.push(Carried {
                id,
                place,
                column: parts.column.to_string(),
                cause,
                squared,
                coefficient_ut: rotation.transpose()
                    * Vector3::from([0, 1, 2].map(|axis| fitted.coefficients[axis])),
                reference: parts.reference().unwrap_or(0.0),
                range: fitted.ranges[0],
            }),
            None => dropped.push(nowhere(&id)),
        }
    }
    // What a target multiplies with the current of the battery is no vector of one motor.
    let ids: Vec<String> =
        carried.iter().filter(|one| one.cause.is_power()).map(|one| one.id.clone()).collect();
    let ids: Vec<&str> = ids.iter().map(String::as_str).collect();
    for block in blocks(&ids, Registry::BUILT_IN) {
        let sum = block.columns.join("+");
        carried.retain(|one| !block.ids.contains(&one.id));
        dropped.extend(block.ids.into_iter().map(|id| Dropped {
            id,
            why: format!(
                "{} has one vector for the sum of all motors. For an average over the motors fit with --derive 'total_a={sum}' --add \
                 offset:total_a. --as c and --as rust store each motor",
                room.name
            ),
        }));
    }
    // One power and one temperature: the one that moves most stays.
    for is_power in [true, false] {
        let of_kind = |effect: &Carried| effect.cause.is_power() == is_power;
        let most = carried.iter().filter(|effect| of_kind(effect));
        let kept =
            most.max_by(|a, b| a.size_ut().total_cmp(&b.size_ut())).map(|effect| effect.column.clone());
        let (stay, go): (Vec<Carried>, Vec<Carried>) =
            carried.drain(..).partition(|effect| !of_kind(effect) || Some(&effect.column) == kept.as_ref());
        carried = stay;
        let what = if is_power { "current or throttle" } else { "temperature" };
        dropped.extend(go.into_iter().map(|effect| Dropped {
            id: effect.id,
            why: format!("{} supports one {what}, and another column has a larger effect", room.name),
        }));
    }
    (carried, dropped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ironout::calibration::Calibration;

    const ROOM: Room = Room {
        name: "a target",
        shape: Shape::Symmetric,
        turns: Turns::Numbered,
        power: true,
        temperature: true,
        program: Program::Other,
    };

    fn plain(matrix: [[f64; 3]; 3]) -> Calibrated {
        Calibrated::plain(Calibration { offset_ut: [1.0, -2.0, 3.0], matrix, field_ut: 50.0 })
    }

    #[test]
    fn a_symmetric_matrix_is_held_as_it_is_and_a_rotation_is_told() {
        let symmetric = [[1.1, 0.05, -0.02], [0.05, 0.9, 0.03], [-0.02, 0.03, 1.0]];
        let held = Held::of(&plain(symmetric), &Frame::default(), ROOM).expect("held");
        assert!(held.is_whole() && held.lost_deg.is_some_and(|lost| lost < 1e-9), "{held:?}");
        let (sin, cos) = 3_f64.to_radians().sin_cos();
        let turned = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
            * Matrix3::from_fn(|i, j| symmetric[i][j]);
        let rows: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| turned[(i, j)]));
        let held = Held::of(&plain(rows), &Frame::default(), ROOM).expect("held");
        assert!((held.lost_deg.expect("aligned") - 3.0).abs() < 1e-9, "{held:?}");
        assert!((held.matrix - Matrix3::from_fn(|i, j| symmetric[i][j])).norm() < 1e-12);
    }

    #[test]
    fn a_triangular_matrix_loses_only_a_convention() {
        let triangle = [[1.1, 0.1, -0.05], [0.0, 0.9, 0.2], [0.0, 0.0, 1.0]];
        let held = Held::of(&plain(triangle), &Frame::default(), ROOM).expect("held");
        assert!(held.lost_deg.is_none() && held.is_whole());
        let v = Vector3::new(20.0, -30.0, 10.0);
        let own = Matrix3::from_fn(|i, j| triangle[i][j]) * (v - held.offset_ut);
        assert!((held.apply(v, &[]).norm() - own.norm()).abs() < 1e-9);
    }

    #[test]
    fn a_mirror_fits_into_a_full_matrix_alone() {
        let from_source = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mirror = Frame { from_source, ..Frame::default() };
        let calibration = plain([[1.1, 0.05, -0.02], [0.05, 0.9, 0.03], [-0.02, 0.03, 1.0]]);
        assert_eq!(Held::of(&calibration, &mirror, ROOM), Err(CannotExport::Mirrored("a target")));
        let full = Room { shape: Shape::Full, ..ROOM };
        let held = Held::of(&calibration, &mirror, full).expect("held");
        let v = [20.0, -30.0, 10.0];
        let own = Vector3::from(calibration.base.apply([-v[0], v[1], v[2]]));
        assert!((held.apply(Vector3::from(v), &[]) - own).norm() < 1e-9);
    }
}
