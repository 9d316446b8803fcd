//! Repairs of broken numbers.

/// A repair of the magnetometer's numbers, as the file has them.
#[derive(Debug, Clone, PartialEq)]
pub enum Repair {
    /// Numbers from half of `modulus` up are negative: `modulus` is subtracted.
    Unsigned {
        /// Axes concerned.
        axes: [bool; 3],
        /// Two to the number of bits, times the step of the numbers.
        modulus: f64,
    },
    /// The two bytes of each 16-bit number are exchanged.
    SwappedBytes {
        /// Axes concerned.
        axes: [bool; 3],
        /// What one count is in the file's numbers.
        step: f64,
    },
    /// The low byte was added as a signed number: 256 is missing if it is 128 or more.
    SignedLowByte {
        /// Axes concerned.
        axes: [bool; 3],
        /// What one count is in the file's numbers.
        step: f64,
    },
    /// Numbers run over the end of their bits: they are moved by multiples of `modulus`.
    Unwrap {
        /// The axis.
        axis: usize,
        /// Two to the number of bits, times the step of the numbers.
        modulus: f64,
        /// Every number lies between this and this plus `modulus`. `None`: their range is larger, and each is the nearest to the
        /// number before.
        from: Option<f64>,
    },
    /// Rows with this value in each of these axes are failed readings: set aside.
    ErrorCode {
        /// Axes concerned.
        axes: [bool; 3],
        /// The value in each; unused for the other axes.
        code: [f64; 3],
    },
    /// Every n-th row is of something else: set aside.
    EveryRow {
        /// Each row whose index divided by this …
        every: usize,
        /// … leaves this.
        offset: usize,
    },
    /// An axis stands still while the others go on, and catches up with a jump: those rows are set aside.
    FrozenAxis {
        /// The axis.
        axis: usize,
        /// First row and the row after the last of each stretch.
        stretches: Vec<(usize, usize)>,
    },
    /// The range or scale of the sensor changed: from each row on, numbers are this many times too large.
    RangeChange {
        /// Row and factor, in order; the factor holds until the next.
        changes: Vec<(usize, f64)>,
    },
    /// An axis is this many rows late (early, where negative): it is moved.
    LateAxis {
        /// The axis.
        axis: usize,
        /// Rows.
        rows: isize,
    },
}

impl Repair {
    /// The axes concerned.
    pub fn axes(&self) -> [bool; 3] {
        match self {
            Repair::Unsigned { axes, .. }
            | Repair::SwappedBytes { axes, .. }
            | Repair::SignedLowByte { axes, .. }
            | Repair::ErrorCode { axes, .. } => *axes,
            Repair::Unwrap { axis, .. } | Repair::FrozenAxis { axis, .. } | Repair::LateAxis { axis, .. } => {
                [0, 1, 2].map(|a| a == *axis)
            }
            Repair::EveryRow { .. } | Repair::RangeChange { .. } => [true; 3],
        }
    }

    /// Whether it sets rows aside instead of changing numbers.
    pub fn sets_aside(&self) -> bool {
        matches!(self, Repair::ErrorCode { .. } | Repair::EveryRow { .. } | Repair::FrozenAxis { .. })
    }

    /// Changes the numbers. Does nothing to a log without rows.
    pub fn mend(&self, numbers: &mut [Vec<f64>; 3]) {
        match self {
            Repair::Unsigned { axes, modulus } => {
                each(numbers, axes, |v| if v >= 0.5 * modulus { v - modulus } else { v });
            }
            Repair::SwappedBytes { axes, step } => each(numbers, axes, |v| swapped(v / step) * step),
            Repair::SignedLowByte { axes, step } => each(numbers, axes, |v| unsigned_low(v / step) * step),
            Repair::Unwrap { axis, modulus, from: Some(from) } => {
                if let Some(values) = numbers.get_mut(*axis) {
                    values.iter_mut().for_each(|v| *v = window(*v, *from, *modulus));
                }
            }
            Repair::Unwrap { axis, modulus, from: None } => {
                if let Some(values) = numbers.get_mut(*axis) {
                    unwrap(values, *modulus);
                }
            }
            Repair::LateAxis { axis, rows } => {
                if let Some(values) = numbers.get_mut(*axis) {
                    earlier(values, *rows);
                }
            }
            Repair::RangeChange { changes } => scale(numbers, changes),
            Repair::ErrorCode { .. } | Repair::EveryRow { .. } | Repair::FrozenAxis { .. } => {}
        }
    }

    /// Makes the repair in the rows that are left: `kept` are their places in the log, `numbers` what they read.
    pub fn make(&self, numbers: &mut [Vec<f64>; 3], kept: &mut Vec<usize>) {
        self.mend(numbers);
        if !self.sets_aside() {
            return;
        }
        let mut marked = vec![false; kept.len()];
        self.set_aside([numbers[0].as_slice(), numbers[1].as_slice(), numbers[2].as_slice()], &mut marked);
        let mut is_left = |column: &mut Vec<f64>| {
            let mut marks = marked.iter();
            column.retain(|_| !marks.next().copied().unwrap_or(false));
        };
        numbers.iter_mut().for_each(&mut is_left);
        let mut marks = marked.iter();
        kept.retain(|_| !marks.next().copied().unwrap_or(false));
    }

    /// Marks the rows to set aside.
    pub fn set_aside(&self, numbers: [&[f64]; 3], marked: &mut [bool]) {
        match self {
            Repair::ErrorCode { axes, code } => {
                for (row, mark) in marked.iter_mut().enumerate() {
                    let is = |axis: usize| numbers[axis].get(row) == Some(&code[axis]);
                    *mark |= axes.contains(&true) && (0..3).all(|axis| !axes[axis] || is(axis));
                }
            }
            Repair::EveryRow { every, offset } if *every > 0 => {
                marked.iter_mut().skip(*offset).step_by(*every).for_each(|mark| *mark = true);
            }
            Repair::FrozenAxis { stretches, .. } => {
                for (from, to) in stretches {
                    marked.iter_mut().take(*to).skip(*from).for_each(|mark| *mark = true);
                }
            }
            _ => {}
        }
    }
}

fn each(numbers: &mut [Vec<f64>; 3], axes: &[bool; 3], repair: impl Fn(f64) -> f64) {
    for (values, _) in numbers.iter_mut().zip(axes).filter(|(_, concerned)| **concerned) {
        values.iter_mut().for_each(|value| *value = repair(*value));
    }
}

/// A number of 16 bits with its bytes exchanged, signed; one that has more bits is left as it is.
pub(super) fn swapped(count: f64) -> f64 {
    let whole = count.round();
    if !(-32_768.0..=65_535.0).contains(&whole) {
        return count;
    }
    f64::from((whole as i32 as u16).swap_bytes() as i16)
}

/// A number whose low byte had been added as a signed one.
pub(super) fn unsigned_low(count: f64) -> f64 {
    let whole = count.round();
    if whole.abs() > 8_388_608.0 {
        return count;
    }
    if whole.rem_euclid(256.0) >= 128.0 { count + 256.0 } else { count }
}

/// The number that differs from this one by a multiple of the modulus and lies between `from` and `from + modulus`.
pub(super) fn window(value: f64, from: f64, modulus: f64) -> f64 {
    value - modulus * ((value - from) / modulus).floor()
}

/// Each number the nearest to the one before; their middle lies within half of the modulus of zero.
pub(super) fn unwrap(values: &mut [f64], modulus: f64) {
    let mut last: Option<f64> = None;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.iter_mut() {
        if let Some(last) = last {
            *value += modulus * ((last - *value) / modulus).round();
        }
        last = Some(*value);
        (low, high) = (low.min(*value), high.max(*value));
    }
    let back = modulus * (0.5 * (low + high) / modulus).round();
    if back.is_finite() && back != 0.0 {
        values.iter_mut().for_each(|value| *value -= back);
    }
}

/// Divides the numbers from each row on by its factor.
fn scale(numbers: &mut [Vec<f64>; 3], changes: &[(usize, f64)]) {
    for (at, (from, factor)) in changes.iter().enumerate() {
        let to = changes.get(at + 1).map_or(usize::MAX, |(next, _)| *next);
        for axis in numbers.iter_mut() {
            axis.iter_mut().take(to).skip(*from).for_each(|value| *value /= factor);
        }
    }
}

/// Numbers of an axis that is `rows` late, at their own time. The last keep their value.
fn earlier(values: &mut [f64], rows: isize) {
    let own = values.to_vec();
    let last = own.len().saturating_sub(1);
    for (at, value) in values.iter_mut().enumerate() {
        let from = at.saturating_add_signed(rows).min(last);
        *value = own.get(from).copied().unwrap_or(*value);
    }
}
