//! The columns that the learner is fed.

use crate::effect::ColumnName;

/// The most columns that are tested at once.
pub const MAX_TESTED: usize = 3;

/// A column: what it is now, and over what it went.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    pub(super) name: ColumnName,
    pub(super) now: f32,
    /// The value it is held against: its first, or the mean of what is not yet forgotten.
    pub(super) first: f32,
    /// Over the rows: the sum of its distances from the first, ...
    sum: f32,
    /// ... and its least and greatest, of late and before.
    late: [f32; 2],
    early: [f32; 2],
}

impl Column {
    /// Its mean over so many rows.
    pub(super) fn mean(&self, rows: u32) -> f64 {
        f64::from(self.first) + f64::from(self.sum) / f64::from(rows.max(1))
    }

    /// Its least and greatest over the rows.
    pub(super) fn range(&self) -> [f32; 2] {
        let ([least, most], [before, after]) = (self.early, self.late);
        [least.min(before), most.max(after)]
    }

    /// What went through it changed by nothing that counts.
    pub(super) fn is_constant(&self) -> bool {
        let [least, most] = self.range();
        !(most - least > 1e-6 * least.abs().max(most.abs()))
    }
}

/// The columns that are fed.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    places: [Option<Column>; MAX_TESTED],
}

impl Columns {
    pub(super) const fn new() -> Self {
        Self { places: [None; MAX_TESTED] }
    }

    pub(super) fn get(&self, place: usize) -> Option<&Column> {
        self.places.get(place).and_then(Option::as_ref)
    }

    pub(super) fn place(&self, name: &str) -> Option<usize> {
        self.places.iter().position(|one| one.as_ref().is_some_and(|one| one.name.as_str() == name))
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Column> {
        self.places.iter().flatten()
    }

    /// Places up to the last that is taken.
    pub(super) fn width(&self) -> usize {
        self.places.iter().rposition(Option::is_some).map_or(0, |last| last + 1)
    }

    /// Sets a column that is known; `None` where it is not.
    pub(super) fn set(&mut self, name: &str, value: f32) -> Option<()> {
        let place = self.place(name)?;
        let column = self.places.get_mut(place)?.as_mut()?;
        column.now = value;
        Some(())
    }

    /// Takes a new one, and says where; `None` where there is no room.
    pub(super) fn add(&mut self, name: ColumnName, value: f32) -> Option<usize> {
        let place = self.places.iter().position(Option::is_none)?;
        *self.places.get_mut(place)? =
            Some(Column { name, now: value, first: value, sum: 0.0, late: [value; 2], early: [value; 2] });
        Some(place)
    }

    /// Forgets one, and says where it was; `None` where it was not known.
    pub(super) fn remove(&mut self, name: &str) -> Option<usize> {
        let place = self.place(name)?;
        *self.places.get_mut(place)? = None;
        Some(place)
    }

    /// How far a column is from its first value; nothing of one that is not there.
    #[inline]
    pub(super) fn since_first(&self, place: usize) -> f32 {
        self.get(place).map_or(0.0, |column| column.now - column.first)
    }

    /// Begins anew with the values of now.
    pub(super) fn begin(&mut self) {
        for column in self.places.iter_mut().flatten() {
            let now = column.now;
            (column.first, column.sum, column.late, column.early) = (now, 0.0, [now; 2], [now; 2]);
        }
    }

    /// Holds a column against its mean over the rows that are left, `further` from where it was held against.
    pub(super) fn hold_against(&mut self, place: usize, further: f32) {
        if let Some(column) = self.places.get_mut(place).and_then(Option::as_mut) {
            (column.first, column.sum) = (column.first + further, 0.0);
        }
    }

    /// Forgets what the ranges were before, and lets what they are of late become it.
    pub(super) fn forget_ranges(&mut self) {
        for column in self.places.iter_mut().flatten() {
            (column.early, column.late) = (column.late, [column.now; 2]);
        }
    }

    /// Notes that a row was taken.
    #[inline]
    pub(super) fn take(&mut self) {
        for column in self.places.iter_mut().flatten() {
            column.sum += column.now - column.first;
            let [least, most] = column.late;
            column.late = [least.min(column.now), most.max(column.now)];
        }
    }
}
