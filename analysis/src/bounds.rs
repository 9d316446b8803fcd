//! Every threshold of the evidence engine. Each is a probability or a physical bound, with the reason for its value.

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
