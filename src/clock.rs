//! Time from a counter that wraps.

/// A counter of 32 bits (milliseconds, microseconds, cycles) extended to 64: it has to be looked at once between two wraps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Extended {
    last: u32,
    wraps: u32,
}

impl Extended {
    /// A counter that begins below 2³².
    pub const fn new() -> Self {
        Self { last: 0, wraps: 0 }
    }

    /// The counter stands at `count`; the same with its wraps counted.
    pub const fn at(&mut self, count: u32) -> u64 {
        if count < self.last {
            self.wraps = self.wraps.wrapping_add(1);
        }
        self.last = count;
        (self.wraps as u64) << 32 | count as u64
    }
}

/// A clock of milliseconds that goes back by more than this was begun again, or has wrapped; less is a stamp that waited, ms.
const LONGEST_WAIT_MS: u64 = 10_000;
/// Where a tick of 32 bits wraps, ms: after 49.7 days.
const WRAP_MS: u64 = 1 << 32;
/// The longest time between two looks at a clock, ms: what went back by less than a wrap and this has wrapped.
const LONGEST_PAUSE_MS: u64 = 600_000;

/// An owner's clock, ms, made one that never goes back for good: a tick of 32 bits that wraps goes on above 2³², and a clock that is
/// set back goes on from where it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct SteadyClock {
    last_ms: u64,
    /// What is added to the owner's time.
    ahead_ms: u64,
    /// The owner's time and what was added to it before it last went back, and where it went.
    before: (u64, u64),
    back_to_ms: u64,
}

impl SteadyClock {
    pub(crate) const fn new() -> Self {
        Self { last_ms: 0, ahead_ms: 0, before: (0, 0), back_to_ms: 0 }
    }

    /// The steady time of an owner's time.
    #[inline]
    pub(crate) fn at(&mut self, owner_ms: u64) -> u64 {
        if owner_ms.wrapping_sub(self.last_ms) < LONGEST_WAIT_MS {
            self.last_ms = owner_ms;
            return owner_ms.saturating_add(self.ahead_ms);
        }
        self.jumped(owner_ms)
    }

    /// The owner's time is before that of the last look, or long after it.
    #[inline(never)]
    fn jumped(&mut self, owner_ms: u64) -> u64 {
        let (before_ms, ahead_before_ms) = self.before;
        if owner_ms > self.last_ms {
            let is_stamp_from_before = owner_ms.abs_diff(before_ms) < LONGEST_WAIT_MS
                && self.last_ms.saturating_sub(self.back_to_ms) < LONGEST_WAIT_MS;
            if is_stamp_from_before {
                return owner_ms.saturating_add(ahead_before_ms);
            }
            self.last_ms = owner_ms;
        } else if self.last_ms - owner_ms > LONGEST_WAIT_MS {
            self.before = (self.last_ms, self.ahead_ms);
            let has_wrapped = (self.last_ms..self.last_ms + LONGEST_PAUSE_MS).contains(&(owner_ms + WRAP_MS));
            self.ahead_ms += if has_wrapped { WRAP_MS } else { self.last_ms - owner_ms };
            (self.last_ms, self.back_to_ms) = (owner_ms, owner_ms);
        }
        owner_ms.saturating_add(self.ahead_ms)
    }

    /// The owner's time of a steady time.
    pub(crate) const fn of_owner(&self, steady_ms: u64) -> u64 {
        steady_ms.saturating_sub(self.ahead_ms)
    }
}

#[cfg(test)]
mod tests {
    use super::{Extended, SteadyClock, WRAP_MS};

    #[test]
    fn a_counter_goes_on_across_its_wraps() {
        let mut extended = Extended::new();
        let (mut count, mut total) = (u32::MAX - 60_000_000, u64::from(u32::MAX - 60_000_000));
        for step in [1, 19_999, 30_000_000, 29_980_000, 3, 0, 4_000_000_000, 294_967_290, 4_294_967_295] {
            count = count.wrapping_add(step);
            total += u64::from(step);
            assert_eq!(extended.at(count), total);
        }
    }

    #[test]
    fn a_tick_that_wraps_goes_on_and_stamps_that_waited_stay_where_they_were() {
        let mut clock = SteadyClock::new();
        let tick = |t_ms: u64| u64::from(t_ms as u32);
        for wraps in 1..4 {
            let begin = wraps * WRAP_MS - 60_000;
            // The first look at a clock, however far it has gone.
            for t_ms in (begin..begin + 120_000).step_by(7) {
                assert_eq!(clock.at(tick(t_ms)), t_ms);
                assert_eq!(clock.of_owner(t_ms + 20), (t_ms + 20) - (t_ms >> 32 << 32));
                // A sample's stamp, older than what was looked at last.
                assert_eq!(clock.at(tick(t_ms - 35)), t_ms - 35);
            }
            // On to the next, as an owner does that looks now and then.
            for t_ms in (begin + 120_000..begin + WRAP_MS).step_by(300_000_000) {
                assert_eq!(clock.at(tick(t_ms)), t_ms);
            }
        }
    }

    #[test]
    fn a_clock_of_64_bits_is_taken_as_it_is_and_one_set_back_goes_on_from_where_it_was() {
        let mut clock = SteadyClock::new();
        for t_ms in [0, 20, 15, WRAP_MS - 5, WRAP_MS + 5, 3 * WRAP_MS, u64::MAX - 20_000] {
            assert_eq!(clock.at(t_ms), t_ms);
        }
        let mut clock = SteadyClock::new();
        // Microseconds of 32 bits over a thousand: they wrap after 71 minutes, and what passed is not known.
        assert_eq!(clock.at(4_294_960), 4_294_960);
        assert_eq!(clock.at(5), 4_294_960);
        assert_eq!(clock.at(4_294_964), 4_294_964, "a stamp of before");
        assert_eq!(clock.at(25), 4_294_980);
        assert_eq!(clock.of_owner(4_295_000), 45);
        assert_eq!(clock.at(60_025), 4_354_980);
        assert_eq!(clock.at(u64::MAX), u64::MAX);
    }
}
