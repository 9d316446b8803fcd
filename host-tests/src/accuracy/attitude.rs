//! How people turn a board when they do not turn it enough: directions of the field in the board's axes over time.

use ironout_simulation::paper::Sampler;
use nalgebra::{Rotation3, Unit, Vector3};

/// A way to move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Round and round about one axis, tilting by at most `wobble_deg`.
    Planar {
        /// Largest tilt out of the plane.
        wobble_deg: f64,
    },
    /// About one axis that stands at an angle to the field: a circle of latitude.
    Cone {
        /// Angle between axis and field.
        half_angle_deg: f64,
        /// Largest tilt.
        wobble_deg: f64,
    },
    /// First about one axis, then about another.
    TwoRings {
        /// Angle between the axes.
        between_deg: f64,
        /// Largest tilt.
        wobble_deg: f64,
    },
    /// To and fro within a cap of the sphere.
    Cap {
        /// Part of the sphere.
        fraction: f64,
    },
    /// In the hand: all headings, pitch and roll within limits.
    Hand {
        /// Largest pitch and roll.
        tilt_deg: f64,
    },
    /// From rest to rest.
    Clusters {
        /// Directions at which the board rests.
        rests: usize,
        /// Whether they all lie in one half of the sphere.
        half: bool,
    },
    /// All over the sphere.
    Full,
}

impl Motion {
    /// The kind's word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Planar { .. } => "planar",
            Self::Cone { .. } => "cone",
            Self::TwoRings { .. } => "two rings",
            Self::Cap { .. } => "cap",
            Self::Hand { .. } => "hand",
            Self::Clusters { .. } => "rests",
            Self::Full => "full",
        }
    }

    /// Every kind of limited attitude, in turn.
    pub fn limited(index: usize, sampler: &mut Sampler) -> Self {
        match index % 6 {
            0 => Self::Planar { wobble_deg: sampler.uniform(0.0, 10.0) },
            1 => Self::Cone {
                half_angle_deg: sampler.uniform(20.0, 80.0),
                wobble_deg: sampler.uniform(0.0, 8.0),
            },
            2 => Self::TwoRings {
                between_deg: sampler.uniform(10.0, 90.0),
                wobble_deg: sampler.uniform(0.0, 5.0),
            },
            3 => Self::Cap { fraction: sampler.uniform(0.02, 0.5) },
            4 => Self::Hand { tilt_deg: sampler.uniform(5.0, 60.0) },
            _ => Self::Clusters {
                rests: sampler.uniform(3.0, 14.0) as usize,
                half: sampler.uniform(0.0, 1.0) < 0.5,
            },
        }
    }

    /// `n` directions, `rate_hz` a second.
    pub fn directions(self, sampler: &mut Sampler, n: usize, rate_hz: f64) -> Vec<Vector3<f64>> {
        let axis = sampler.direction(Vector3::z(), 1.0);
        let step = 1.0 / rate_hz;
        match self {
            Self::Planar { wobble_deg } => {
                Ring { axis, half_angle: 90f64.to_radians(), wobble: wobble_deg.to_radians() }
                    .turn(sampler, n, step)
            }
            Self::Cone { half_angle_deg, wobble_deg } => {
                Ring { axis, half_angle: half_angle_deg.to_radians(), wobble: wobble_deg.to_radians() }
                    .turn(sampler, n, step)
            }
            Self::TwoRings { between_deg, wobble_deg } => {
                let side = Unit::new_normalize(axis.cross(&sampler.direction(Vector3::z(), 1.0)));
                let other = Rotation3::from_axis_angle(&side, between_deg.to_radians()) * axis;
                let ring =
                    |axis| Ring { axis, half_angle: 90f64.to_radians(), wobble: wobble_deg.to_radians() };
                let mut all = ring(axis).turn(sampler, n / 2, step);
                let second = ring(other).turn(sampler, n, step);
                // Over from one to the other on a great circle, in half a second.
                if let (Some(from), Some(to)) = (all.last().copied(), second.first().copied()) {
                    all.extend((1..25).map(|i| from.slerp(&to, f64::from(i) / 25.0)));
                }
                all.extend(second);
                all.truncate(n);
                all
            }
            Self::Cap { fraction } => walk(sampler, n, step, |s| s.direction(axis, fraction)),
            Self::Full => walk(sampler, n, step, |s| s.direction(axis, 1.0)),
            Self::Hand { tilt_deg } => {
                // The field dips by 20 … 70° in the world.
                let dip = sampler.uniform(20.0, 70.0).to_radians();
                let field = Vector3::new(dip.cos(), 0.0, dip.sin());
                walk(sampler, n, step, |s| {
                    let mut tilt = || s.uniform(-tilt_deg, tilt_deg).to_radians();
                    let (roll, pitch) = (tilt(), tilt());
                    let yaw = s.uniform(0.0, std::f64::consts::TAU);
                    Rotation3::from_euler_angles(roll, pitch, yaw).inverse() * field
                })
            }
            Self::Clusters { rests, half } => {
                let places: Vec<_> = (0..rests.max(2))
                    .map(|_| sampler.direction(axis, if half { 0.5 } else { 1.0 }))
                    .collect();
                let dwell = (n / places.len()).max(1);
                // A tremor of a third of a degree at the rates of a hand, 6 … 12 Hz.
                let shakes: Vec<_> = (0..4)
                    .map(|_| {
                        (sampler.normal3() * 0.004, sampler.uniform(6.0, 12.0), sampler.uniform(0.0, 6.0))
                    })
                    .collect();
                (0..n)
                    .map(|i| {
                        let t = i as f64 * step;
                        let at = (i / dwell).min(places.len() - 1);
                        // Half a second from one to the next.
                        let along = ((i % dwell) as f64 * step / 0.5).min(1.0);
                        let eased = along * along * (3.0 - 2.0 * along);
                        let from = places[at.saturating_sub(1)];
                        let shake: Vector3<f64> = shakes
                            .iter()
                            .map(|(size, hz, phase)| size * (std::f64::consts::TAU * hz * t + phase).sin())
                            .sum();
                        (from * (1.0 - eased) + places[at] * eased + shake).normalize()
                    })
                    .collect()
            }
        }
    }
}

/// Turning about an axis.
struct Ring {
    axis: Vector3<f64>,
    half_angle: f64,
    wobble: f64,
}

impl Ring {
    fn turn(&self, sampler: &mut Sampler, n: usize, step: f64) -> Vec<Vector3<f64>> {
        let side = Unit::new_normalize(self.axis.cross(&if self.axis.x.abs() < 0.8 {
            Vector3::x()
        } else {
            Vector3::y()
        }));
        let speed = sampler.uniform(0.5, 2.5);
        let (slow, phase) = (sampler.uniform(0.1, 0.9), sampler.uniform(0.0, 6.0));
        (0..n)
            .map(|i| {
                let t = i as f64 * step;
                let tilt = self.half_angle + self.wobble * (slow * t + phase).sin();
                let up = Rotation3::from_axis_angle(&side, tilt) * self.axis;
                Rotation3::from_axis_angle(&Unit::new_normalize(self.axis), speed * t) * up
            })
            .collect()
    }
}

/// From one direction to the next on great circles, at the speed of a hand.
fn walk(
    sampler: &mut Sampler,
    n: usize,
    step: f64,
    mut next: impl FnMut(&mut Sampler) -> Vector3<f64>,
) -> Vec<Vector3<f64>> {
    let mut out = Vec::with_capacity(n);
    let mut here = next(sampler);
    while out.len() < n {
        let there = next(sampler);
        let angle = here.dot(&there).clamp(-1.0, 1.0).acos();
        let steps = ((angle / (sampler.uniform(0.6, 2.0) * step)) as usize).max(1);
        let Some(axis) = Unit::try_new(here.cross(&there), 1e-9) else { continue };
        for i in 0..steps.min(n - out.len()) {
            let along = i as f64 / steps as f64;
            // Slow at both ends.
            let eased = along * along * (3.0 - 2.0 * along);
            out.push(Rotation3::from_axis_angle(&axis, angle * eased) * here);
        }
        here = there;
    }
    out
}
