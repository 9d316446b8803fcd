//! Whole numbers of up to 1408 bits: enough for every number in double precision, times its power of ten.

use core::cmp::Ordering;

const LIMBS: usize = 44;

/// A whole number. What would not fit is lost: callers stay below.
#[derive(Clone)]
pub(super) struct Big {
    /// The lowest first; those from `used` on are zero.
    limbs: [u32; LIMBS],
    used: usize,
}

impl Big {
    pub(super) fn of(value: u64) -> Self {
        let mut limbs = [0; LIMBS];
        [limbs[0], limbs[1]] = [value as u32, (value >> 32) as u32];
        Self { limbs, used: 2 }
    }

    /// Times `factor`, plus `addend`.
    pub(super) fn times(&mut self, factor: u32, addend: u32) {
        let mut carry = u64::from(addend);
        for limb in self.limbs.iter_mut().take(self.used) {
            let product = u64::from(*limb) * u64::from(factor) + carry;
            *limb = product as u32;
            carry = product >> 32;
        }
        if carry > 0
            && let Some(limb) = self.limbs.get_mut(self.used)
        {
            *limb = carry as u32;
            self.used += 1;
        }
    }

    /// Times ten to the power of `exponent`.
    pub(super) fn times_ten_to(&mut self, exponent: u32) {
        const NINE: u32 = 1_000_000_000;
        for _ in 0..exponent / 9 {
            self.times(NINE, 0);
        }
        for _ in 0..exponent % 9 {
            self.times(10, 0);
        }
    }

    /// Times two to the power of `bits`.
    pub(super) fn shift(&mut self, bits: u32) {
        let limbs = (bits / 32) as usize;
        if limbs > 0 {
            for at in (0..LIMBS).rev() {
                let from = at.checked_sub(limbs).and_then(|from| self.limbs.get(from)).copied();
                if let Some(limb) = self.limbs.get_mut(at) {
                    *limb = from.unwrap_or(0);
                }
            }
            self.used = (self.used + limbs).min(LIMBS);
        }
        self.times(1 << (bits % 32), 0);
    }

    /// Plus `other`.
    pub(super) fn add(&mut self, other: &Self) {
        self.used = self.used.max(other.used);
        let mut carry = 0;
        for (limb, other) in self.limbs.iter_mut().zip(&other.limbs).take(self.used) {
            let sum = u64::from(*limb) + u64::from(*other) + carry;
            *limb = sum as u32;
            carry = sum >> 32;
        }
        if carry > 0
            && let Some(limb) = self.limbs.get_mut(self.used)
        {
            *limb = 1;
            self.used += 1;
        }
    }

    /// Minus `other`, which is not larger.
    pub(super) fn subtract(&mut self, other: &Self) {
        let mut borrow = false;
        for (limb, other) in self.limbs.iter_mut().zip(&other.limbs).take(self.used) {
            let (less, first) = limb.overflowing_sub(*other);
            let (less, second) = less.overflowing_sub(u32::from(borrow));
            (*limb, borrow) = (less, first || second);
        }
    }

    pub(super) fn compare(&self, other: &Self) -> Ordering {
        let used = self.used.max(other.used);
        let limbs = self.limbs.iter().zip(&other.limbs).take(used).rev();
        limbs.map(|(a, b)| a.cmp(b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
    }

    /// How many bits it has; 0 for zero.
    pub(super) fn bits(&self) -> u32 {
        let top = self.limbs.iter().rposition(|limb| *limb != 0);
        top.map_or(0, |at| 32 * at as u32 + 32 - self.limbs.get(at).map_or(0, |limb| limb.leading_zeros()))
    }
}
