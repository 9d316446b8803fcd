//! The likeliest parameters of a log, and their covariance.

use crate::base::term::{COLUMNS, Matrix};
use crate::confined::channels::{Channel, Rows, Seen, Share, Sums};
use crate::confined::known::Before;
use crate::confined::log::Log;
use crate::confined::state::{HARMONICS, State, YAW_ERROR, effect_at};
use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen, Vector3};

/// How often the noise of each channel is worked out again.
const ROUNDS: usize = 5;
/// Steps with one noise at most.
const STEPS: usize = 12;
/// A step that promises less than this many units of `−2 ln L` is the last.
const SETTLED: f64 = 1e-3;
/// The errors of an attitude are alike over so many blocks of time (Newey and West, 1987).
const DRIFT_BLOCKS: usize = 5;
/// Rounds of an eigenvalue decomposition at most.
const EIGEN_ROUNDS: usize = 10_000;
/// A pull on the solution of this square, in units of its covariance, does no harm.
const PULL_IGNORED: f64 = 0.02;
/// Where the size of the yaw's errors begins, rad: what a compass in need of calibration makes of a yaw that follows it.
const YAW_ERROR_RAD: f64 = 0.15;
/// No yaw of an autopilot is nearer than this at all headings, rad.
const LEAST_YAW_ERROR_RAD: f64 = 0.003;
/// A step is halved until it is good, so often at most.
const HALVED: usize = 8;

/// What one channel has said.
#[derive(Debug, Clone, Copy)]
pub struct Heard {
    /// Which one.
    pub channel: Channel,
    /// Rows.
    pub rows: usize,
    /// Rms of its residual, µT.
    pub rms_ut: f64,
    /// Number of rows with the information of one independent row, from the blocks of time.
    pub memory: f64,
}

/// The solution.
#[derive(Debug, Clone)]
pub struct Solved {
    /// The parameters.
    pub state: State,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// What each channel has said.
    pub heard: Vec<Heard>,
    /// The part of the variance of the shown tilt that is the board's own.
    pub tilt_share: f64,
    /// Size of the errors of the logged yaw that depend on the heading, rad.
    pub yaw_error_rad: f64,
}

/// Noise of the channels.
#[derive(Clone)]
struct Noise {
    /// Standard deviation of a row, µT, and how many rows count as one.
    rows: [(f64, f64); Channel::ALL.len()],
    share: Share,
    /// The same of the tilt that the logged attitude shows.
    pose_share: Share,
    /// Size of the yaw's errors by heading, and by the effects' columns at their rms, rad.
    yaw_rad: [f64; 2],
}

impl Noise {
    fn start() -> Self {
        Noise {
            rows: [(1.0, 1.0); Channel::ALL.len()],
            share: Share::AS_SHOWN,
            pose_share: Share::AS_SHOWN,
            yaw_rad: [YAW_ERROR_RAD; 2],
        }
    }

    fn share(&self, channel: Channel) -> &Share {
        if channel == Channel::Tilt { &self.pose_share } else { &self.share }
    }

    /// The size of errors of which these are estimates with these variances, and which had this size before (one step of expectation
    /// and maximization: Dempster, Laird and Rubin, 1977).
    fn sized(estimates: impl Iterator<Item = (f64, f64)>, before: f64) -> f64 {
        let squares: Vec<f64> =
            estimates.map(|(estimate, variance)| estimate * estimate + variance).collect();
        match squares.len() {
            0 => before,
            n => (squares.iter().sum::<f64>() / n as f64).sqrt().max(LEAST_YAW_ERROR_RAD),
        }
    }

    /// Takes the size of the yaw's errors from a solution.
    fn learn_yaw(&mut self, log: &Log, state: &State, covariance: &DMatrix<f64>) {
        if !log.has_attitude() {
            return;
        }
        let own = (0..HARMONICS).map(|k| (state.yaw_error[k], covariance[(YAW_ERROR + k, YAW_ERROR + k)]));
        let by_effect =
            state.effects.iter().zip(&log.effects).enumerate().flat_map(|(at, ((_, yaw), square))| {
                (0..3).map(move |k| {
                    let place = effect_at(at) + 3 + k;
                    (square.sqrt() * yaw[k], square * covariance[(place, place)])
                })
            });
        self.yaw_rad = [Noise::sized(own, self.yaw_rad[0]), Noise::sized(by_effect, self.yaw_rad[1])];
    }
}

/// Everything at one state: the weighted total, and each channel.
fn total(log: &Log, start: &State, state: &State, before: &Before, noise: &Noise) -> (Matrix, Vec<Sums>) {
    let down = if log.has_attitude() { &noise.pose_share } else { &noise.share };
    let mut total = before.matrix(start, state, log, noise.yaw_rad, down.error, noise.share.tilt);
    let mut list = Vec::new();
    let seen = Seen::of(log, state);
    for (channel, (sigma_ut, memory)) in Channel::ALL.into_iter().zip(&noise.rows) {
        let sums = Rows::of(channel, &seen, noise.share(channel)).sums(*sigma_ut, state.parameters());
        for block in &sums.blocks {
            weighted(&mut total, block, 1.0 / memory, state.parameters());
        }
        list.push(sums);
    }
    (total, list)
}

/// Adds a block with a weight.
fn weighted(total: &mut Matrix, block: &Matrix, weight: f64, parameters: usize) {
    for i in 0..parameters {
        total.pull(i, weight * block.right(i));
        (i..parameters).for_each(|j| total.inform(i, j, weight * block.entry(i, j)));
    }
    total.depart(weight * block.squares());
}

/// What a full step promises, `gᵀH⁻¹g`, and that step.
fn promise(at: &Matrix, parameters: usize) -> Option<(f64, [f64; COLUMNS])> {
    let step = at.step(&at.factor()?);
    Some(((0..parameters).map(|i| -step[i] * at.right(i)).sum(), step))
}

/// Steps to where `Jᵀr = 0` with this noise. With derivatives next to the readings that is not where the cost is least, so that a step is
/// good where it lowers the cost or where the next one promises less.
fn settle(log: &Log, start: &State, mut state: State, before: &Before, noise: &Noise) -> Option<State> {
    let parameters = state.parameters();
    let (mut at, _) = total(log, start, &state, before, noise);
    for _ in 0..STEPS {
        let (promised, step) = promise(&at, parameters)?;
        if promised < SETTLED {
            break;
        }
        let mut share = 1.0;
        let mut moved = None;
        for _ in 0..HALVED {
            let next = state.stepped(&step.map(|value| share * value));
            let (there, _) = total(log, start, &next, before, noise);
            let promises = promise(&there, parameters).map_or(f64::INFINITY, |(promised, _)| promised);
            if there.squares() < at.squares() || promises < promised {
                moved = Some((next, there));
                break;
            }
            share *= 0.5;
        }
        let Some((next, there)) = moved else { break };
        (state, at) = (next, there);
    }
    at.squares().is_finite().then_some(state)
}

/// The noise of each channel at a state; the memory is kept.
fn noise_at(log: &Log, state: &State, noise: &Noise) -> Noise {
    let mut now = noise.clone();
    let as_shown = State { tilt: noise.share.tilt * state.tilt, ..state.clone() };
    let seen = Seen::of(log, &as_shown);
    let magnitude_ut = Rows::of(Channel::Magnitude, &seen, &Share::AS_SHOWN).sigma_ut();
    let shown = Rows::of(Channel::Dip, &seen, &Share::AS_SHOWN);
    now.share = Share::of(log.tilt_square(), state, magnitude_ut, &shown);
    if log.has_attitude() {
        let shown = Rows::of(Channel::Tilt, &seen, &Share::AS_SHOWN);
        now.pose_share = Share::of(log.pose_tilt_square(), state, magnitude_ut, &shown);
    }
    let seen = Seen::of(log, state);
    let sigmas = Channel::ALL.map(|channel| Rows::of(channel, &seen, now.share(channel)).sigma_ut());
    now.rows.iter_mut().zip(sigmas).for_each(|(one, sigma_ut)| one.0 = sigma_ut);
    now
}

/// The covariance at a state, and how many rows of each channel count as one: `Σ (gᵦᵀ M gᵦ + tr(M Hᵦ M Hᵦ)) / tr(M H)` over the blocks of
/// time, 1 where rows err independently. The second term is what the solution has taken of a block's score by following it: without it a
/// log that turns in a few blocks only has errors that are too small. An attitude's errors go on from block to block: pairs count too.
fn memory(
    total: &Matrix,
    sums: &[Sums],
    noise: &Noise,
    parameters: usize,
) -> Option<(DMatrix<f64>, Vec<f64>)> {
    let factor = total.factor()?;
    let columns: Vec<[f64; COLUMNS]> = (0..parameters).map(|column| factor.inverse_column(column)).collect();
    let covariance = DMatrix::from_fn(parameters, parameters, |i, j| 0.5 * (columns[i][j] + columns[j][i]));
    let entries = |block: &Matrix| DMatrix::from_fn(parameters, parameters, |i, j| block.entry(i, j));
    let right = |block: &Matrix| DVector::from_fn(parameters, |i, _| block.right(i));
    let root = covariance.clone().cholesky().map(|factor| factor.unpack());
    let of = |((channel, sums), (_, now)): ((Channel, &Sums), &(f64, f64))| {
        if sums.rows == 0 {
            return 1.0;
        }
        let followed: Vec<DMatrix<f64>> =
            sums.blocks.iter().map(|block| &covariance * entries(block)).collect();
        let scores: Vec<DVector<f64>> = sums.blocks.iter().map(right).collect();
        let pair = |one: usize, two: usize| {
            (&covariance * &scores[one]).dot(&scores[two])
                + followed[one].component_mul(&followed[two].transpose()).sum()
        };
        let lags = if channel.drifts() { DRIFT_BLOCKS } else { 0 };
        let weight = |lag: usize| 1.0 - lag as f64 / (lags + 1) as f64;
        let seen: f64 = (0..followed.len())
            .map(|at| {
                let later = (1..=lags).filter(|lag| at + lag < followed.len());
                pair(at, at) + later.map(|lag| 2.0 * weight(lag) * pair(at, at + lag)).sum::<f64>()
            })
            .sum();
        let expected: f64 = followed.iter().map(DMatrix::trace).sum();
        let by_blocks = if expected > 0.0 { (seen / expected).max(1.0) } else { 1.0 };
        let Some(root) = root.as_ref().filter(|_| channel.has_own_direction()) else { return by_blocks };
        let sum = |list: &[Matrix]| {
            list.iter().fold(DMatrix::zeros(parameters, parameters), |sum, one| sum + entries(one))
        };
        let pull = scores.iter().fold(DVector::zeros(parameters), |sum, one| sum + one);
        // The root, since the pulls themselves become smaller with the weight.
        by_blocks.max(now * contradiction(root, sum(&sums.blocks) / *now, pull / *now).sqrt())
    };
    let list = Channel::ALL.into_iter().zip(sums).zip(&noise.rows).map(of).collect();
    Some((covariance, list))
}

/// How far a channel contradicts all others: the mean square of its pulls on the solution over what they would be if its errors were as
/// independent as its weight says. In a direction of which it has the share `h` of the information that is `h (1 − h)`. Errors that are
/// the same in all blocks of time show in this alone: an accelerometer that flies leans the same way in every turn.
fn contradiction(root: &DMatrix<f64>, information: DMatrix<f64>, pull: DVector<f64>) -> f64 {
    let shares = SymmetricEigen::try_new(root.transpose() * information * root, f64::EPSILON, EIGEN_ROUNDS);
    let Some(shares) = shares else { return 1.0 };
    let pulls = shares.eigenvectors.transpose() * (root.transpose() * pull);
    let (mut seen, mut expected) = (0.0, 0.0);
    for (share, pull) in shares.eigenvalues.iter().zip(&pulls) {
        let variance = share.clamp(0.0, 1.0) * (1.0 - share.clamp(0.0, 1.0));
        seen += pull * pull / (variance + PULL_IGNORED);
        expected += variance / (variance + PULL_IGNORED);
    }
    if expected > 0.0 { seen / expected } else { 1.0 }
}

/// The likeliest state from this start.
fn from_start(log: &Log, start: &State, before: &Before) -> Option<Solved> {
    let mut noise = Noise::start();
    noise = noise_at(log, start, &noise);
    let mut state = settle(log, start, start.clone(), before, &noise)?;
    for _ in 0..ROUNDS {
        noise = noise_at(log, &state, &noise);
        state = settle(log, start, state, before, &noise)?;
        let (at, sums) = total(log, start, &state, before, &noise);
        let (covariance, memories) = memory(&at, &sums, &noise, state.parameters())?;
        noise.learn_yaw(log, &state, &covariance);
        noise.rows.iter_mut().zip(memories).for_each(|(one, memory)| one.1 = memory);
    }
    let (at, sums) = total(log, start, &state, before, &noise);
    let (covariance, _) = memory(&at, &sums, &noise, state.parameters())?;
    let heard = (Channel::ALL.into_iter().zip(&sums).zip(noise.rows))
        .filter(|((_, sums), _)| sums.rows > 0)
        .map(|((channel, sums), (_, memory))| Heard { channel, rows: sums.rows, rms_ut: sums.rms_ut, memory })
        .collect();
    let tilt_share = if log.has_attitude() { 1.0 } else { noise.share.tilt };
    Some(Solved { state, covariance, heard, tilt_share, yaw_error_rad: noise.yaw_rad[0] })
}

/// The likeliest parameters of a log. `offsets_ut` are where to begin. A band of attitudes about one axis has a mirror image: the offset on
/// the other side of the plane of the readings, with the field's vertical part reversed; both are tried, the likelier one is taken.
pub fn solve(
    log: &Log,
    matrix: Matrix3<f64>,
    offsets_ut: &[Vector3<f64>],
    before: &Before,
) -> Option<Solved> {
    let n = log.rows.len().max(1) as f64;
    let middle = log.rows.iter().map(|row| row.measured_ut).sum::<Vector3<f64>>() / n;
    let axis = matrix.try_inverse()? * log.mean_down;
    let axis = axis.try_normalize(1e-9)?;
    let mirrored = |offset: &Vector3<f64>| offset + 2.0 * axis.dot(&(middle - offset)) * axis;
    let starts = offsets_ut.iter().flat_map(|offset| [*offset, mirrored(offset)]);
    let mut found: Option<Solved> = None;
    for offset_ut in starts {
        let mut state = State {
            offset_ut,
            matrix,
            field_ut: 1.0,
            effects: vec![Default::default(); log.effects.len()],
            ..State::default()
        };
        let (mut length, mut vertical) = (0.0, 0.0);
        for row in &log.rows {
            let v = state.corrected(row);
            length += v.norm() / n;
            vertical += row.down.map_or(0.0, |down| down.dot(&v)) / n;
        }
        (state.field_ut, state.vertical_ut) = (before.field_ut.unwrap_or(length), vertical);
        if log.has_attitude() {
            let posed = log.rows.iter().zip(&log.poses).filter_map(|(row, pose)| Some((row, pose.as_ref()?)));
            let world: Vector3<f64> =
                posed.map(|(row, pose)| pose.axes.transpose() * state.corrected(row)).sum();
            state.yaw = Some(world.y.atan2(world.x));
        }
        let Some(solved) = from_start(log, &state, before) else { continue };
        if found.as_ref().is_none_or(|other| worth(log, &state, &solved, other, before) > 0.0) {
            found = Some(solved);
        }
    }
    found
}

/// By how much `−2 ln L` of this solution is below that of the other, both at the noise of the other.
fn worth(log: &Log, start: &State, solved: &Solved, other: &Solved, before: &Before) -> f64 {
    let mut noise = Noise::start();
    for heard in &other.heard {
        noise.rows[heard.channel as usize].1 = heard.memory;
    }
    let noise = noise_at(log, &other.state, &noise);
    let of = |state: &State| total(log, start, state, before, &noise).0.squares();
    of(&other.state) - of(&solved.state)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_contradicts_where_it_pulls_more_than_its_weight_predicts() {
        // Of two directions it has a half and a hundredth of the information.
        let information = DMatrix::from_diagonal(&DVector::from_vec(vec![0.5, 0.01]));
        let of = |pulls: [f64; 2]| {
            contradiction(&DMatrix::identity(2, 2), information.clone(), DVector::from_row_slice(&pulls))
        };
        let predicted = of([0.5, 0.1]);
        assert!((0.9..1.2).contains(&predicted), "{predicted}");
        assert!(of([0.05, 0.01]) < 0.1 && of([0.5, 1.5]) > 20.0, "{} {}", of([0.05, 0.01]), of([0.5, 1.5]));
    }
}
