//! Which samples of a log count: neither repeated, nor faulty, nor of a resting board.

use crate::base::engine::Design;
use crate::base::prior::Prior;
use crate::base::rest;
use crate::base::start;
use crate::samples::data::Data;
use crate::samples::faults::{self, DataFault, FaultKind, Faults};
use crate::samples::samples::Samples;
use crate::table::Table;
use ironout::calibration::Calibration;
use ironout::study::{Model, Residual};
use serde::Serialize;

/// Rounds of fit and search for bursts: the fit becomes better as they go.
const ROUNDS: usize = 5;

/// Why samples were set aside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Why {
    /// The axis was at the end of its range.
    Clipping {
        /// 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// The magnitude was far from all others: a magnet passing, a corrupted reading.
    Burst,
    /// The reading stood still while the board turned.
    Stuck,
    /// The same readings are earlier in the log.
    Copy,
}

/// Samples set aside for one reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Aside {
    /// The reason.
    pub why: Why,
    /// How many.
    pub samples: usize,
}

/// The samples of a log, sorted out. `rows = repeated + at_rest + set aside + used`.
pub struct Counted<'a> {
    /// The log.
    pub table: &'a Table<'a>,
    /// Its samples.
    pub data: Data<'a>,
    /// Those that count.
    pub used: Vec<u32>,
    /// The same for a study, which thins them where they are many. Of a resting board: all that are not faulty.
    pub samples: Samples,
    /// Whether the board rests, so that the vector itself is to be studied.
    pub rests: bool,
    /// What was found, gaps and copied axes too.
    pub faults: Vec<DataFault>,
    /// Axes that carry data of their own.
    pub axes: [bool; 3],
    /// What was set aside, by reason.
    pub aside: Vec<Aside>,
    /// Rows that repeat the one before them.
    pub repeated: usize,
    /// Samples of a resting board.
    pub at_rest: usize,
    /// The samples of a study with those that stand out of the base model, where there are any: what stands out may be an
    /// effect that the base model does not know.
    pub with_bursts: Option<Samples>,
}

impl<'a> Counted<'a> {
    /// Sorts out a log whose values times `unit` are microtesla.
    pub fn of(table: &'a Table<'a>, unit: f64) -> Self {
        let Faults { mut list, mut set_aside, axes } = faults::find(table);
        let data = Data::new(table);
        let sound = |set_aside: &[bool], samples: &[u32]| -> Vec<u32> {
            samples.iter().copied().filter(|&sample| !set_aside[data.row(sample)]).collect()
        };
        let all: Vec<u32> = (0..data.rows.len() as u32).collect();
        let moving = data.moving(&sound(&set_aside, &all), unit);
        let mut samples = Samples::take(table, &set_aside, axes);
        let rests = rest::at_rest(&samples);
        let mut with_bursts = None;
        if !rests {
            let left_out = |set_aside: &[bool]| {
                let mut left_out = vec![true; table.rows()];
                for sample in sound(set_aside, &moving) {
                    left_out[data.row(sample)] = false;
                }
                left_out
            };
            samples = Samples::take(table, &left_out(&set_aside), axes);
            let whole = samples.clone();
            for (from, to) in bursts(&samples, table, &left_out(&set_aside), axes) {
                let rows = (samples.row[from], samples.row[to]);
                set_aside[rows.0..=rows.1].fill(true);
                list.push(faults::burst_fault(table, rows, (to - from + 1) * samples.stride));
                with_bursts = Some(whole.clone());
            }
            for _ in 0..ROUNDS {
                samples = Samples::take(table, &left_out(&set_aside), axes);
                let found = spikes(&data, &sound(&set_aside, &moving), &samples);
                let seen: Vec<(usize, usize)> = found.iter().filter_map(|one| one.among(&samples)).collect();
                if found.is_empty() || faults::have_company(&samples, &seen) {
                    break;
                }
                for Spike { rows, samples } in found {
                    set_aside[rows.0..=rows.1].fill(true);
                    list.push(faults::burst_fault(table, rows, samples));
                }
            }
            samples = Samples::take(table, &left_out(&set_aside), axes);
            faults::merge_bursts(&mut list);
        }
        let used = sound(&set_aside, &moving);
        let faulty = all.len() - sound(&set_aside, &all).len();
        let aside = aside(&list, faulty);
        let stuck: usize = aside.iter().filter(|one| one.why == Why::Stuck).map(|one| one.samples).sum();
        Counted {
            repeated: table.rows() - all.len() - stuck,
            at_rest: all.len() - faulty - used.len(),
            with_bursts,
            table,
            data,
            used,
            samples,
            rests,
            faults: list,
            axes,
            aside,
        }
    }

    /// Samples set aside in all.
    pub fn set_aside(&self) -> usize {
        self.aside.iter().map(|one| one.samples).sum()
    }

    /// Samples at the end of the sensor's range.
    pub fn clipped(&self) -> usize {
        let clipped = self.aside.iter().filter(|one| matches!(one.why, Why::Clipping { .. }));
        clipped.map(|one| one.samples).sum()
    }

    /// Samples that the study is of.
    pub fn studied(&self) -> usize {
        if self.rests { self.used.len() + self.at_rest } else { self.used.len() }
    }
}

/// Single readings in a row that stand out of the residual.
struct Spike {
    /// The first and the last row.
    rows: (usize, usize),
    /// How many samples.
    samples: usize,
}

impl Spike {
    /// The first and the last place in `samples`, if they are there.
    fn among(&self, samples: &Samples) -> Option<(usize, usize)> {
        let from = samples.row.partition_point(|row| *row < self.rows.0);
        let to = samples.row.partition_point(|row| *row <= self.rows.1);
        (from < to).then(|| (from, to - 1))
    }
}

/// The base model of these samples, as a study without anything known besides begins with it.
fn base_model(samples: &Samples) -> Option<Model<f64>> {
    let design = Design::new(samples, Residual::Magnitude);
    let (model, _) = start::start(samples, None)?;
    // There is no effect here whose shape could fail.
    Some(design.fit(model, Vec::new(), &Prior::default()).ok()??.model)
}

/// Bursts show in the residual of the base model. They bend a fit that holds them, so it is made without what stands out
/// of it, until that is the same as before.
fn bursts(samples: &Samples, table: &Table, left_out: &[bool], axes: [bool; 3]) -> Vec<(usize, usize)> {
    let all = Design::new(samples, Residual::Magnitude);
    let mut kept = samples.clone();
    let mut outliers = vec![false; samples.len()];
    let mut found = Vec::new();
    let mut plain = None;
    for _ in 0..ROUNDS {
        let Some(model) = base_model(&kept) else { break };
        let Ok(residuals) = all.residuals(&model, &[]) else { break };
        found = faults::bursts(&residuals);
        // The peaks of an effect that the model does not know are outliers too, and without them the fit finds the rest of
        // the effect quiet. In the fit of all samples they stand out of nothing.
        let first = plain.get_or_insert_with(|| residuals.clone());
        found.retain(|&(from, to)| faults::stands_out(first, from, to));
        let now = faults::outliers(&residuals);
        let share = now.iter().filter(|out| **out).count();
        // So much is no outlier but structure; without any nothing can change.
        if now == outliers || share == 0 || share * 5 > samples.len() {
            break;
        }
        let mut without = left_out.to_vec();
        for (row, _) in samples.row.iter().zip(&now).filter(|(_, out)| **out) {
            without[*row] = true;
        }
        kept = Samples::take(table, &without, axes);
        outliers = now;
    }
    let share: usize = found.iter().map(|(from, to)| to - from + 1).sum();
    let much = share as f64 > faults::BURST_SHARE * samples.len() as f64;
    if much || faults::have_company(samples, &found) { Vec::new() } else { found }
}

/// Spikes in the residual of the base model, of all samples that are used.
fn spikes(data: &Data, used: &[u32], samples: &Samples) -> Vec<Spike> {
    let Some(model) = base_model(samples) else { return Vec::new() };
    let Model { offset_ut, matrix, field_ut, .. } = model;
    let calibration = Calibration { offset_ut, matrix, field_ut };
    let residuals = match data.in_one_field(offset_ut) {
        Some(data) => data.residual(used, &calibration),
        None => data.residual(used, &calibration),
    };
    faults::spikes(&residuals)
        .into_iter()
        .map(|(from, to)| Spike { rows: (data.row(used[from]), data.row(used[to])), samples: to - from + 1 })
        .collect()
}

/// What was set aside by reason; `faulty` of the samples were.
fn aside(list: &[DataFault], faulty: usize) -> Vec<Aside> {
    let mut counts: Vec<Aside> = Vec::new();
    let mut add = |why: Why, samples: usize| match counts.iter_mut().find(|one| one.why == why) {
        Some(one) => one.samples += samples,
        None if samples > 0 => counts.push(Aside { why, samples }),
        None => {}
    };
    // Of the faulty samples, those that are counted by another reason than that they stand out.
    let mut counted = 0;
    for fault in list {
        match fault.kind {
            FaultKind::Clipping => {
                let axis = faults::AXES.iter().position(|name| fault.columns.iter().any(|own| own == name));
                add(Why::Clipping { axis: axis.unwrap_or_default() }, fault.samples);
                counted += fault.samples;
            }
            // The first of the repeated readings is a sample as any other.
            FaultKind::Stuck => add(Why::Stuck, fault.samples.saturating_sub(1)),
            FaultKind::CopiedRows => {
                add(Why::Copy, fault.samples);
                counted += fault.samples;
            }
            FaultKind::Burst | FaultKind::Gap | FaultKind::CopiedAxis => {}
        }
    }
    add(Why::Burst, faulty.saturating_sub(counted));
    counts
}
