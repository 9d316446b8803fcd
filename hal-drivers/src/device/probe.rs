//! Which chips are on a bus.

use super::mode::{DelayNs, I2c, both};
use super::registers::{Registers, Wires};
use crate::chip::bmm150;
use crate::chip::description::Chip;
use crate::chip::kind::{
    CANDIDATES, Candidate, Findings, Found, Kind, LSM303_ACCELEROMETER, LSM303AGR_ACCELEROMETER,
};
use crate::chip::{bmm350, qmc5883l, qmc6310};
use embedded_hal::i2c::{Error as _, ErrorKind, ErrorType};

/// What an address said.
enum Answer<T, E> {
    /// This.
    Said(T),
    /// Nobody is there.
    Nobody,
    /// The bus failed.
    Failed(E),
}

/// Looks for the chips of this crate on a bus, at their addresses only, and says what it found.
///
/// It reads identities and writes nothing but the power bit of a BMM150 (register 0x4b at 0x10 to 0x13), without which that chip
/// has none; `delay` waits the 3 ms after it. It changes no configuration: whatever it finds wants
/// [`Magnetometer::init`](crate::Magnetometer::init).
///
/// What no register tells is said: an HMC5883L and the magnetic half of an LSM303DLHC have one address and one identity. With
/// somebody at 0x19, where the latter's accelerometer is, it is taken for an LSM303DLHC, *or* an HMC5883L beside another chip
/// there; without, it is an HMC5883L. See [`Found::or`].
#[both(AFIT)]
pub async fn probe<I2C: I2c, D: DelayNs>(i2c: &mut I2C, delay: &mut D) -> Findings<I2C::Error> {
    let mut findings = Findings::none();
    let mut skipped = None;
    let mut answered = None;
    for candidate in &CANDIDATES {
        let address = candidate.address;
        if skipped == Some(address) {
            continue;
        }
        if candidate.kind == Kind::Bmm150 {
            let written = i2c.write(address, &[bmm150::POWER, bmm150::POWER_ON]).await;
            if let Err(error) = written {
                trouble(&mut findings, error);
                continue;
            }
            delay.delay_ms(bmm150::START_UP_MS).await;
        }
        match ask(i2c, candidate).await {
            Answer::Said(true) => {
                skipped = Some(address);
                if answered == Some(address) {
                    findings.strangers = findings.strangers.saturating_sub(1);
                }
                let found = Found { address, kind: candidate.kind, or: None };
                let found = told_apart(i2c, found).await;
                findings.add(found);
            }
            Answer::Said(false) if answered != Some(address) => {
                answered = Some(address);
                findings.strangers = findings.strangers.saturating_add(1);
            }
            Answer::Said(false) => {}
            Answer::Nobody => skipped = Some(address),
            Answer::Failed(error) => findings.trouble = Some(error),
        }
    }
    findings
}

fn trouble<E: embedded_hal::i2c::Error>(findings: &mut Findings<E>, error: E) {
    if !matches!(error.kind(), ErrorKind::NoAcknowledge(_)) {
        findings.trouble = Some(error);
    }
}

/// Reads from an address.
#[both(AFIT)]
async fn read<I2C: I2c, const N: usize>(
    i2c: &mut I2C,
    address: u8,
    register: u8,
) -> Answer<[u8; N], <I2C as ErrorType>::Error> {
    read_after(i2c, address, register, 0).await
}

/// The same, from a chip that sends bytes without a meaning first.
#[both(AFIT)]
async fn read_after<I2C: I2c, const N: usize>(
    i2c: &mut I2C,
    address: u8,
    register: u8,
    dummies: u8,
) -> Answer<[u8; N], <I2C as ErrorType>::Error> {
    let mut registers = Registers { i2c, address, increment: 0, dummies };
    match registers.read(register).await {
        Ok(bytes) => Answer::Said(bytes),
        Err(error) if matches!(error.kind(), ErrorKind::NoAcknowledge(_)) => Answer::Nobody,
        Err(error) => Answer::Failed(error),
    }
}

/// Whether the chip at the candidate's address is the candidate.
#[both(AFIT)]
async fn ask<I2C: I2c>(i2c: &mut I2C, candidate: &Candidate) -> Answer<bool, <I2C as ErrorType>::Error> {
    let mut is = true;
    let dummies = match candidate.kind {
        Kind::Bmm350 => bmm350::Trimmed::DUMMIES,
        _ => 0,
    };
    for (offset, &byte) in (0_u8..).zip(candidate.identity) {
        let register = candidate.register.wrapping_add(offset);
        match read_after(i2c, candidate.address, register, dummies).await {
            Answer::Said([said]) => is &= said == byte,
            Answer::Nobody => return Answer::Nobody,
            Answer::Failed(error) => return Answer::Failed(error),
        }
    }
    let flags = match candidate.kind {
        // All ones is what an empty register of any chip may read.
        Kind::Qmc5883l => Some((qmc5883l::STATUS, 0xf8)),
        // A display at this address answers any reading with its own status.
        Kind::Qmc6310 => Some((qmc6310::STATUS, qmc6310::STATUS_EMPTY)),
        _ => None,
    };
    if let (Some((register, empty)), true) = (flags, is) {
        // The flags and their empty bits have to be there too.
        return match read(i2c, candidate.address, register).await {
            Answer::Said([status]) => Answer::Said(status & empty == 0),
            Answer::Nobody => Answer::Nobody,
            Answer::Failed(error) => Answer::Failed(error),
        };
    }
    Answer::Said(is)
}

/// What the chip is by what stands beside it.
#[both(AFIT)]
async fn told_apart<I2C: I2c>(i2c: &mut I2C, found: Found) -> Found {
    if !matches!(found.kind, Kind::Lis2mdl | Kind::Hmc5883l) {
        return found;
    }
    let (register, identity) = LSM303AGR_ACCELEROMETER;
    let beside = read(i2c, LSM303_ACCELEROMETER, register).await;
    match (found.kind, beside) {
        (Kind::Lis2mdl, Answer::Said([said])) if said == identity => {
            Found { kind: Kind::Lsm303agr, or: Some(Kind::Lis2mdl), ..found }
        }
        (Kind::Lis2mdl, _) => Found { or: Some(Kind::Iis2mdc), ..found },
        (_, Answer::Said(_)) => Found { kind: Kind::Lsm303dlhc, or: Some(Kind::Hmc5883l), ..found },
        (_, Answer::Nobody) => found,
        // Whether somebody is there could not be asked.
        (_, Answer::Failed(_)) => Found { or: Some(Kind::Lsm303dlhc), ..found },
    }
}
