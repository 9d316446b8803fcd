//! Vectors, matrices and quaternions of plain arrays, and the projection that a linear fit makes.

/// Vector of three numbers.
pub type Vec3 = [f64; 3];
/// Matrix of three rows.
pub type Mat3 = [[f64; 3]; 3];
/// Unit quaternion w, x, y, z that turns a vector of the body frame into the NED frame.
pub type Quat = [f64; 4];

/// Unit matrix.
pub const IDENTITY: Mat3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Scalar product.
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Length.
pub fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// `a + k b`.
pub fn add_scaled(a: Vec3, k: f64, b: Vec3) -> Vec3 {
    [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]]
}

/// Difference `a - b`.
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    add_scaled(a, -1.0, b)
}

/// `k a`.
pub fn scale(k: f64, a: Vec3) -> Vec3 {
    [k * a[0], k * a[1], k * a[2]]
}

/// Vector of length 1 along `a`.
pub fn unit(a: Vec3) -> Vec3 {
    scale(1.0 / norm(a), a)
}

/// Product of a matrix and a vector.
pub fn mul_vec(m: &Mat3, v: Vec3) -> Vec3 {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}

/// Product of two matrices.
pub fn mul_mat(a: &Mat3, b: &Mat3) -> Mat3 {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Transposed matrix.
pub fn transpose(m: &Mat3) -> Mat3 {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

/// Inverse of a regular matrix.
pub fn inverse(m: &Mat3) -> Mat3 {
    let columns = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    let det = dot(m[0], columns[0]);
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i] / det))
}

/// Product of two quaternions: first `b`, then `a`.
pub fn quat_mul(a: Quat, b: Quat) -> Quat {
    let (av, bv) = ([a[1], a[2], a[3]], [b[1], b[2], b[3]]);
    let v = add_scaled(add_scaled(cross(av, bv), a[0], bv), b[0], av);
    [a[0] * b[0] - dot(av, bv), v[0], v[1], v[2]]
}

/// Inverse of a unit quaternion.
pub fn quat_inverse(q: Quat) -> Quat {
    [q[0], -q[1], -q[2], -q[3]]
}

/// Turn by the angle |v| in rad about the axis of `v`.
pub fn quat_from_vector(v: Vec3) -> Quat {
    let angle = norm(v);
    let k = if angle < 1e-12 { 0.5 } else { (angle / 2.0).sin() / angle };
    [(angle / 2.0).cos(), k * v[0], k * v[1], k * v[2]]
}

/// Rotation vector in rad, of length at most π.
pub fn quat_to_vector(q: Quat) -> Vec3 {
    let q = if q[0] < 0.0 { q.map(|c| -c) } else { q };
    let v = [q[1], q[2], q[3]];
    let sine = norm(v);
    let k = if sine < 1e-12 { 2.0 } else { 2.0 * sine.atan2(q[0]) / sine };
    scale(k, v)
}

/// Vector of the body frame, in NED.
pub fn to_ned(q: Quat, v: Vec3) -> Vec3 {
    let r = quat_mul(quat_mul(q, [0.0, v[0], v[1], v[2]]), quat_inverse(q));
    [r[1], r[2], r[3]]
}

/// Vector of NED, in the body frame.
pub fn to_body(q: Quat, v: Vec3) -> Vec3 {
    to_ned(quat_inverse(q), v)
}

/// Root of the mean square.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Root of the mean squared length of vectors, of all three axes together.
pub fn rms_of_vectors(vectors: &[Vec3]) -> f64 {
    (vectors.iter().map(|&v| dot(v, v)).sum::<f64>() / vectors.len() as f64).sqrt()
}

/// Subtracts the mean and divides by the standard deviation.
pub fn standardised(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let spread = rms(&centred).max(1e-12);
    centred.iter().map(|v| v / spread).collect()
}

/// Orthonormal columns: what a linear fit can explain.
pub struct Span(Vec<Vec<f64>>);

impl Span {
    /// Gram and Schmidt, twice for accuracy; columns that depend on earlier ones are left out.
    pub fn new(columns: &[Vec<f64>]) -> Self {
        let mut span = Span(Vec::new());
        for column in columns {
            let before = rms(column);
            let rest = span.project_out(&span.project_out(column));
            let after = rms(&rest);
            if after > 1e-9 * before {
                let k = 1.0 / (after * (rest.len() as f64).sqrt());
                span.0.push(rest.iter().map(|v| k * v).collect());
            }
        }
        span
    }

    /// The part of `values` that the columns cannot explain.
    pub fn project_out(&self, values: &[f64]) -> Vec<f64> {
        let mut rest = values.to_vec();
        for column in &self.0 {
            let share: f64 = column.iter().zip(&rest).map(|(c, r)| c * r).sum();
            for (r, c) in rest.iter_mut().zip(column) {
                *r -= share * c;
            }
        }
        rest
    }
}
