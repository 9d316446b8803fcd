//! Thresholds of a diagnosis. Each is a probability or a physical bound, with the reason for its value. What only says how exactly or
//! how fast something is computed (steps, grids, sizes) stands where it is used.

/// Twice the log of the posterior odds against a false name: one log in a hundred with a wrongly added term is accepted.
pub const MIN_ODDS: f64 = 9.210_340_371_976_184;

/// Twice the log of 19: an alternative is unclear while its posterior probability is above 5 %.
pub const UNCLEAR_ODDS: f64 = 5.888_877_957_332_881;

/// Twice the log of the prior odds against a derived form (square, delay, low-pass): one effect in ten has one.
pub const DERIVED_ODDS: f64 = 4.605_170_185_988_092;

/// Twice the log of the prior odds against a low-pass of a column that does not act itself, or a product of two columns of which neither
/// does: one derived form in ten.
pub const ALONE_ODDS: f64 = 2.0 * DERIVED_ODDS;

/// A log with more columns has only products of columns that act: each pair costs a look at every sample.
pub const MAX_COLUMNS_PAIRED: usize = 12;

/// Share of the remaining squared residual that a term must explain: below 5 % a correction changes the rms by less than the
/// uncertainty of the noise model.
pub const MIN_SHARE: f64 = 0.05;

/// 1σ of the offset, in units of the field: datasheets allow a few fields of hard iron on a finished board.
pub const OFFSET_PRIOR_FIELDS: f64 = 3.0;

/// 1σ of an entry of the matrix: soft iron and gains of uncorrected boards stay within some 20 %.
pub const MATRIX_PRIOR: f64 = 0.2;

/// 1σ of the rms disturbance of one term, in units of the field: a disturbance as large as the field hides the field itself.
pub const TERM_PRIOR_FIELDS: f64 = 0.5;

/// Block means of a long log, at most: the wander of a sensor lasts for many samples, so that a block has one value of it.
pub const MAX_BLOCKS: usize = 4200;

/// Terms of one model, at most: a log with more causes is a log to record again.
pub const MAX_TERMS: usize = 5;

/// Order of the short autoregressive noise, at most: the longest filter of common chips averages 16 samples.
pub const MAX_AR_ORDER: usize = 16;

/// The longest delay of a cause against its column, s: slower paths are low-passes with a time constant, not delays.
pub const MAX_DELAY_S: f64 = 5.0;

/// The lowest frequency of a tone, Hz: two slower sinusoids imitate almost any column.
pub const MIN_TONE_HZ: f64 = 1.0;

/// 1σ of the wander per axis, in units of the field, at most: what moves the offset by more is a cause, not a noise.
pub const MAX_WANDER_FIELDS: f64 = 0.1;

/// Square of the residual over the field from which the two forms of a term are told apart, in units of the noise: the magnitude shows
/// about a fifth of a disturbance, and a tenth of the noise is seen in some hundred samples.
pub const FORMS_DIFFER: f64 = 0.004;

/// Rivals of a term that are fitted in full: the screen orders candidates right within a few places.
pub const RIVALS: usize = 3;

/// Share of the gain of a term that a rival has at least in a screen to be fitted: noise that is estimated anew changes a gain by less
/// than the other 40 %.
pub const RIVAL_SHARE: f64 = 0.6;

/// Leaders of each screen that are fitted in full: the screen orders candidates right within a few places.
pub const LEADERS: usize = 4;

/// Looks at a sample of one search, at most: some seconds of a core of 3 GHz. What is found by then stands.
pub const MOST_LOOKS: u64 = 40_000_000;

/// The longest lead of a cause against its column, s: telemetry of one value a second is late by up to two of them.
pub const MAX_LEAD_S: f64 = 2.0;

/// The longest time constant of a low-pass, s: boards and batteries warm within minutes.
pub const MAX_TIME_CONSTANT_S: f64 = 600.0;

/// Swaps of terms, at most: each lowers the score, so that more than one per term means a loop.
pub const MOST_SWAPS: usize = 4;

/// Squares of a fit under coloured noise over the least ones, at most: generalised least squares that doubles them has left the region
/// where the linearisation holds.
pub const MOST_ABOVE_LEAST: f64 = 2.0;

/// Least slope of the reading by the field: with less, readings fold over, and two fields have one reading.
pub const LEAST_SLOPE: f64 = 0.05;

/// Largest p-value of a term by the spread of its coefficients over parts of the log: one in a thousand, as the score has paid for the
/// number of candidates already.
pub const MAX_P_HELD_OUT: f64 = 0.001;

/// Shortest time constant of a hidden cause, in blocks: what is shorter is white noise that differs between axes.
pub const SHORTEST_CAUSE_BLOCKS: f64 = 4.0;

/// Fast tones that are taken out of one log, at most: a motor and its harmonic.
pub const MOST_TONES: usize = 2;

/// The longest filter that a sensor or its driver has, samples: the longest of common chips averages 16.
pub const FILTER_SAMPLES: f64 = 16.0;

/// The same as time, s: a compass behind a slower filter would lag behind every turn of a vehicle.
pub const FILTER_S: f64 = 1.0;

/// What a sample adds to noise behind a longer filter than that, at most, as a share of the variance: one of first order that is forgotten
/// as late adds 0.18. More of it is white noise beside something slow: two causes.
pub const MOST_FRESH: f64 = 0.25;

/// What a filter of first order still knows after that: a fifth.
pub const FORGOTTEN: f64 = 0.2;

/// A filter's highest power gain over that at its ends, at most: one octave's worth of a resonance; a line has hundreds.
pub const LINE: f64 = 2.0;

/// Exponents of 1/f noise: electronics make 0.8 to 1.2.
pub const FLICKER_EXPONENTS: [f64; 3] = [0.8, 1.0, 1.2];

/// Samples in which the colour of a noise is looked at, at most: a noise that shows in none of them matters to no calibration.
pub const MAX_NOISE_SAMPLES: usize = 3000;

// What a held-out error says.

/// Held-out errors are as good as equal within this factor: a tenth is their own error where 50 rows are independent (1/√(2n)).
pub const AS_WELL: f64 = 1.1;

/// What raises an error by more than this factor is neither recommended nor named: half of what passes for equal.
pub const RAISES: f64 = 1.05;

/// Share of an error below which the better part of it is explained.
pub const BETTER_PART: f64 = 0.5;

/// Fewer samples are no study: three for each of the nine base parameters, and a few.
pub const FEWEST_SAMPLES: usize = 30;

/// Significance level of a contradiction. Every log with an earlier calibration is tested, and a false alarm costs the user that
/// calibration, so that one in a million is accepted.
pub const MAX_P_CONTRADICTED: f64 = 1e-6;

/// An earlier calibration is another by so much of the field, and of a gain, besides its noise: what another day and room make.
pub const OTHER_DAY: f64 = 0.003;

// A sensor that was calibrated before.

/// A log is taken as of a calibrated sensor if the raw magnitude spreads by at most this share of its mean: one that was not has an offset
/// of half a field and more.
pub const CALIBRATED_SPREAD: f64 = 0.2;

/// 1σ of its offset, in units of the field: what a calibration of another day leaves.
pub const CALIBRATED_OFFSET: f64 = 0.05;

/// The same where the data ask for an offset: another battery, another board beside it.
pub const MOVED_OFFSET: f64 = 0.3;

/// 1σ of its gains where the data ask for gains ...
pub const MOVED_GAIN: f64 = 0.05;

/// ... and of their mean, where the field is given: the sensitivity tolerance of datasheets.
pub const MOVED_SCALE: f64 = 0.03;

// Directions.

/// An effect that is certain ([`MAX_P_HELD_OUT`]) is named up to this error of the corrected vector, as a share of the field.
pub const MAX_ERROR_TO_NAME: f64 = 0.025;

/// A calibration whose predicted error is beyond this share of the field (3°) says nothing about directions.
pub const ALIGNABLE: f64 = 0.05;

/// A direction is known, and a dip constant, within this, degrees: the same error.
pub const KNOWN_DEG: f64 = 3.0;

/// A rotation between the sensors beyond this is worth a word, degrees: soft iron itself may turn the field by less.
pub const MISALIGNED_DEG: f64 = 4.0;

/// A rotation beyond this is no mounting error, degrees: it is nearer to another order of the axes.
pub const SWAPPED_DEG: f64 = 45.0;

/// A dip that spreads by more than this, at best, shows no gravity (or that of another board), degrees.
pub const MAX_DIP_SPREAD_DEG: f64 = 15.0;

/// A dip, or its spread, below this shows neither sign nor order of axes, degrees.
pub const MIN_DIP_DEG: f64 = 8.0;

/// Iron nearby turns the field by less than this, degrees.
pub const NEAR_DEG: f64 = 25.0;

/// Headings are forwards within this, rms degrees, and backwards where their opposites are.
pub const FORWARDS_DEG: f64 = 60.0;

/// A sensor later than this is not looked for, s.
pub const MAX_LAG_S: f64 = 2.0;

// Motion.

/// Below this tilt, degrees rms, a log carries no offset and matrix of its own: a fifth of the field along the vertical.
pub const LEVEL_DEG: f64 = 12.0;

/// A board falls where its specific force is less than this share of the usual ...
pub const FALLING: f64 = 0.5;

/// ... and flies freely if it falls for this share of a log.
pub const FLIES: f64 = 0.02;

/// A turning board turns faster than this for half of the time, rad/s: 3°/s, beyond the zero rate of common gyros.
pub const RESTING_RADPS: f64 = 0.05;

/// A board that turns now and then, as a car does, turns by more than this within ten seconds, rad rms over the log.
pub const RESTING_TURN_RAD: f64 = 0.15;

/// A resting board's direction down stays within this angle's sine.
pub const RESTING_TILT: f64 = 0.06;

/// Readings that spread across their widest direction by more than this share of it go round ...
pub const ROUND: f64 = 0.3;

/// ... where that is so many times what neighbours differ by.
pub const ROUND_NOISES: f64 = 5.0;

/// Without gyro and accelerometer: the share of the vector's variance that the columns of a resting board explain ...
pub const EXPLAINED_AT_REST: f64 = 0.6;

/// ... and what they leave is no more than this many times what neighbours differ by, or less than a sphere leaves.
pub const NOISE_AT_REST: f64 = 2.0;

/// What a gyro, a room and the times of a log make of a turn, rad, and how well a rotation to the gyro is known (3°).
pub const GYRO_RAD: f64 = 0.05;

/// A gyro in another unit, or of another board, gives no rotation at all: singular values within these.
pub const GYRO_GAINS: std::ops::RangeInclusive<f64> = 0.6..=1.5;

/// Noise and effects make about as large an error across the field as along it (0.8 to 1.4 times in 8 recordings with optical truth);
/// so much more is another field.
pub const ACROSS: f64 = 3.0;

/// Magnitudes for which the fit's constants in µT hold, µT: half of the weakest field on Earth to twice the strongest.
pub const IN_SCALE_UT: std::ops::RangeInclusive<f64> = 12.0..=120.0;

/// A magnitude in the middle of those that the field has on Earth, µT.
pub const TYPICAL_UT: f64 = 50.0;

// Magnets that pass, and pairs of sensors.

/// Steps there and back within so many seconds are a magnet that passed ...
pub const PASSES_S: f64 = 6.0;

/// ... if together they leave less than this share of the largest one; it is set aside with as large a share of the time on either side.
pub const PASSED: f64 = 0.35;

/// More than this share of a log is no passing magnet.
pub const MAX_PASSING: f64 = 0.1;

/// The part of one of two sensors is significant beyond so many standard errors ...
pub const PAIR_SIGMAS: f64 = 4.0;

/// ... matters beyond this share of the field, rms ...
pub const PAIR_SHARE: f64 = 0.002;

/// ... and is a disturbance of that sensor if it is so many times that of the other.
pub const PAIR_RATIO: f64 = 2.0;
