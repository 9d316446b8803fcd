//! Which chips there are, and where to look for them.

use super::{
    ak09916, bmm150, bmm350, hmc5883l, icm20948, ist8310, lis2mdl, lis3mdl, mmc5603, mmc5983ma, qmc5883l,
    qmc5883p, qmc6309, qmc6310, rm3100,
};

/// A chip with a magnetometer that this crate drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Kind {
    Lis2mdl,
    Iis2mdc,
    Lsm303agr,
    Lis3mdl,
    Lsm303dlhc,
    Hmc5883l,
    Qmc5883l,
    Qmc5883p,
    Qmc6309,
    Qmc6310,
    Mmc5603,
    Mmc5983ma,
    Bmm150,
    Bmm350,
    Ak09916,
    /// An AK09916 behind the bypass of an ICM-20948.
    Icm20948,
    Ist8310,
    Rm3100,
}

impl Kind {
    /// The chip's name.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Lis2mdl => "LIS2MDL",
            Kind::Iis2mdc => "IIS2MDC",
            Kind::Lsm303agr => "LSM303AGR",
            Kind::Lis3mdl => "LIS3MDL",
            Kind::Lsm303dlhc => "LSM303DLHC",
            Kind::Hmc5883l => "HMC5883L",
            Kind::Qmc5883l => "QMC5883L",
            Kind::Qmc5883p => "QMC5883P",
            Kind::Qmc6309 => "QMC6309",
            Kind::Qmc6310 => "QMC6310",
            Kind::Mmc5603 => "MMC5603",
            Kind::Mmc5983ma => "MMC5983MA",
            Kind::Bmm150 => "BMM150",
            Kind::Bmm350 => "BMM350",
            Kind::Ak09916 => "AK09916",
            Kind::Icm20948 => "ICM-20948",
            Kind::Ist8310 => "IST8310",
            Kind::Rm3100 => "RM3100",
        }
    }
}

/// A chip that was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Found {
    /// Its 7-bit address.
    pub address: u8,
    /// Which chip it is, the likeliest where it may be another.
    pub kind: Kind,
    /// What it may be instead: registers and identity tell no difference, or not enough of one.
    pub or: Option<Kind>,
}

impl Found {
    /// Whether it may be another chip than [`Found::kind`] with other scales: the caller has to know. The LIS2MDL family is not
    /// told apart with certainty either, but there it makes no difference to a measurement.
    pub fn is_ambiguous(&self) -> bool {
        self.or.is_some() && matches!(self.kind, Kind::Lsm303dlhc | Kind::Hmc5883l)
    }

    /// The same, decided by somebody who knows the board.
    #[must_use]
    pub fn as_kind(self, kind: Kind) -> Self {
        Self { kind, or: None, ..self }
    }
}

impl core::fmt::Display for Found {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} at {:#04x}", self.kind.name(), self.address)?;
        match self.or {
            Some(or) => write!(f, " (or {})", or.name()),
            None => Ok(()),
        }
    }
}

/// Where a chip may be, and how it is recognised.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// The chip.
    pub kind: Kind,
    /// Its address.
    pub address: u8,
    /// The first register of its identity.
    pub register: u8,
    /// What it reads.
    pub identity: &'static [u8],
}

const fn candidate(kind: Kind, address: u8, register: u8, identity: &'static [u8]) -> Candidate {
    Candidate { kind, address, register, identity }
}

/// All places, by address: those of one address are neighbours.
pub const CANDIDATES: [Candidate; 28] = [
    candidate(Kind::Ak09916, ak09916::ADDRESS, ak09916::WIA1, &ak09916::IDENTITY),
    candidate(Kind::Ist8310, 0x0c, ist8310::WAI, &[ist8310::IDENTITY]),
    // In this order: where the one has its identity, the other has a measurement.
    candidate(Kind::Qmc5883l, qmc5883l::ADDRESS, qmc5883l::CHIP_ID, &[qmc5883l::IDENTITY]),
    candidate(Kind::Ist8310, 0x0d, ist8310::WAI, &[ist8310::IDENTITY]),
    candidate(Kind::Ist8310, 0x0e, ist8310::WAI, &[ist8310::IDENTITY]),
    candidate(Kind::Ist8310, 0x0f, ist8310::WAI, &[ist8310::IDENTITY]),
    candidate(Kind::Bmm150, 0x10, bmm150::CHIP_ID, &[bmm150::IDENTITY]),
    candidate(Kind::Bmm150, 0x11, bmm150::CHIP_ID, &[bmm150::IDENTITY]),
    candidate(Kind::Bmm150, 0x12, bmm150::CHIP_ID, &[bmm150::IDENTITY]),
    candidate(Kind::Bmm150, 0x13, bmm150::CHIP_ID, &[bmm150::IDENTITY]),
    candidate(Kind::Bmm350, 0x14, bmm350::CHIP_ID, &[bmm350::IDENTITY]),
    candidate(Kind::Bmm350, 0x15, bmm350::CHIP_ID, &[bmm350::IDENTITY]),
    candidate(Kind::Lis3mdl, 0x1c, lis3mdl::WHO_AM_I, &[lis3mdl::IDENTITY]),
    candidate(Kind::Qmc6310, 0x1c, qmc6310::CHIP_ID, &[qmc6310::IDENTITY]),
    candidate(Kind::Lis2mdl, lis2mdl::ADDRESS, lis2mdl::WHO_AM_I, &[lis2mdl::IDENTITY]),
    candidate(Kind::Hmc5883l, hmc5883l::ADDRESS, hmc5883l::IDENTIFICATION_A, &hmc5883l::IDENTITY),
    candidate(Kind::Lis3mdl, 0x1e, lis3mdl::WHO_AM_I, &[lis3mdl::IDENTITY]),
    candidate(Kind::Rm3100, 0x20, rm3100::REVID, &[rm3100::IDENTITY]),
    candidate(Kind::Rm3100, 0x21, rm3100::REVID, &[rm3100::IDENTITY]),
    candidate(Kind::Rm3100, 0x22, rm3100::REVID, &[rm3100::IDENTITY]),
    candidate(Kind::Rm3100, 0x23, rm3100::REVID, &[rm3100::IDENTITY]),
    candidate(Kind::Qmc5883p, qmc5883p::ADDRESS, qmc5883p::CHIP_ID, &[qmc5883p::IDENTITY]),
    candidate(Kind::Mmc5983ma, mmc5983ma::ADDRESS, mmc5983ma::PRODUCT_ID, &[mmc5983ma::IDENTITY]),
    candidate(Kind::Mmc5603, mmc5603::ADDRESS, mmc5603::PRODUCT_ID, &[mmc5603::IDENTITY]),
    candidate(Kind::Qmc6310, 0x3c, qmc6310::CHIP_ID, &[qmc6310::IDENTITY]),
    candidate(Kind::Icm20948, 0x68, icm20948::WHO_AM_I, &[icm20948::IDENTITY]),
    candidate(Kind::Icm20948, 0x69, icm20948::WHO_AM_I, &[icm20948::IDENTITY]),
    candidate(Kind::Qmc6309, qmc6309::ADDRESS, qmc6309::CHIP_ID, &[qmc6309::IDENTITY]),
];

/// Where an LSM303's accelerometer is: it has no other address.
pub const LSM303_ACCELEROMETER: u8 = 0x19;
/// Its identity, where it has one.
pub const LSM303AGR_ACCELEROMETER: (u8, u8) = (0x0f, 0x33);

/// The most chips that one probing lists.
pub const MOST_FOUND: usize = 8;

/// What a probing found. `E` is the error of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Findings<E> {
    found: [Option<Found>; MOST_FOUND],
    /// The last failure of the bus that was not simply an address without a chip: a line held down, arbitration lost. With one of
    /// these, a chip that is not listed may be there all the same.
    pub trouble: Option<E>,
    /// Addresses that answered without being a chip of this crate.
    pub strangers: u8,
}

impl<E> Findings<E> {
    /// Nothing yet.
    pub(crate) const fn none() -> Self {
        Self { found: [None; MOST_FOUND], trouble: None, strangers: 0 }
    }

    /// One more; those beyond [`MOST_FOUND`] are left out.
    pub(crate) fn add(&mut self, found: Found) {
        if found.kind == Kind::Icm20948 {
            // With its bypass open, as a restart without a loss of power leaves it, its magnetometer was found already: the same
            // board has to be the same chip each time.
            let own = |place: &&mut Option<Found>| place.is_some_and(|other| other.kind == Kind::Ak09916);
            if let Some(place) = self.found.iter_mut().find(own) {
                *place = Some(found);
                return;
            }
        }
        if let Some(place) = self.found.iter_mut().find(|place| place.is_none()) {
            *place = Some(found);
        }
    }

    /// The chips, by address. An AK09916 beside an ICM-20948 is taken for the one in it, and only the ICM-20948 is listed.
    pub fn iter(&self) -> impl Iterator<Item = Found> + '_ {
        self.found.iter().flatten().copied()
    }

    /// The chip to take: the first.
    pub fn first(&self) -> Option<Found> {
        self.iter().next()
    }
}
