//! Faults on the wire: a wrapper around any bus that cuts transactions short, flips bits, or holds the bus.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// What happens to one byte on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hit {
    /// Nothing.
    Pass,
    /// It is not acknowledged (or, while reading, arbitration is lost), and the transaction ends there.
    Nack,
    /// These bits of it are flipped. Address bytes are spared: that would be another chip's transaction.
    Flip(u8),
}

/// Decides about byte `1` of transaction `0`, both counted from zero; address bytes count as bytes.
type Script = Box<dyn FnMut(u64, usize) -> Hit>;

struct Faults {
    transactions: u64,
    script: Script,
    stuck: bool,
}

/// The hand on the faults of a [`Faulty`] bus, kept by the test while a driver owns the bus.
#[derive(Clone)]
pub struct FaultControl(Rc<RefCell<Faults>>);

impl Default for FaultControl {
    fn default() -> Self {
        Self(Rc::new(RefCell::new(Faults {
            transactions: 0,
            script: Box::new(|_, _| Hit::Pass),
            stuck: false,
        })))
    }
}

impl FaultControl {
    /// No faults.
    pub fn new() -> Self {
        Self::default()
    }

    /// From now on `script` decides about every byte.
    pub fn set(&self, script: impl FnMut(u64, usize) -> Hit + 'static) {
        self.0.borrow_mut().script = Box::new(script);
    }

    /// From now on everything passes, and a stuck bus is free again.
    pub fn clear(&self) {
        self.set(|_, _| Hit::Pass);
        self.0.borrow_mut().stuck = false;
    }

    /// The `transaction`-th transaction from now on (0 is the next) fails at byte `byte`.
    pub fn nack_at(&self, transaction: u64, byte: usize) {
        let at = self.transactions() + transaction;
        self.set(move |t, b| if (t, b) == (at, byte) { Hit::Nack } else { Hit::Pass });
    }

    /// In the `transaction`-th transaction from now on (0 is the next) these bits of byte `byte` are flipped.
    pub fn flip_at(&self, transaction: u64, byte: usize, mask: u8) {
        let at = self.transactions() + transaction;
        self.set(move |t, b| if (t, b) == (at, byte) { Hit::Flip(mask) } else { Hit::Pass });
    }

    /// Every byte fails with this probability, the same bytes for the same seed.
    pub fn nack_randomly(&self, seed: u64, probability: f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        self.set(move |_, _| if rng.random_bool(probability) { Hit::Nack } else { Hit::Pass });
    }

    /// A line is held down: nothing works until [`Self::clear`].
    pub fn hold_bus(&self) {
        self.0.borrow_mut().stuck = true;
    }

    /// Transactions begun so far.
    pub fn transactions(&self) -> u64 {
        self.0.borrow().transactions
    }
}

/// A bus with faults. What was on the wire before a fault reaches the chip, as it does in reality.
#[derive(Clone)]
pub struct Faulty<B> {
    inner: B,
    control: FaultControl,
}

impl<B> Faulty<B> {
    /// Puts `control`'s faults in front of `inner`.
    pub fn new(inner: B, control: FaultControl) -> Self {
        Self { inner, control }
    }
}

/// What the script did to a transaction.
#[derive(Default)]
struct Plan {
    /// The operation and the number of its data bytes that still pass, and the error then.
    cut: Option<(usize, usize, ErrorKind)>,
    /// Operation, data byte, bits.
    flips: Vec<(usize, usize, u8)>,
}

fn plan(faults: &mut Faults, operations: &[Operation<'_>]) -> Plan {
    let transaction = faults.transactions;
    let mut plan = Plan::default();
    let (mut wire, mut last_is_read) = (0, None);
    let mut next = |wire: &mut usize| {
        let hit = (faults.script)(transaction, *wire);
        *wire += 1;
        hit
    };
    for (index, operation) in operations.iter().enumerate() {
        let (is_read, length) = match operation {
            Operation::Read(bytes) => (true, bytes.len()),
            Operation::Write(bytes) => (false, bytes.len()),
        };
        if last_is_read != Some(is_read) {
            last_is_read = Some(is_read);
            if next(&mut wire) == Hit::Nack {
                plan.cut = Some((index, 0, ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address)));
                return plan;
            }
        }
        for byte in 0..length {
            match next(&mut wire) {
                Hit::Pass => {}
                Hit::Flip(mask) => plan.flips.push((index, byte, mask)),
                Hit::Nack => {
                    // While reading it is the master that acknowledges: what can go wrong is arbitration.
                    let error = match is_read {
                        true => ErrorKind::ArbitrationLoss,
                        false => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data),
                    };
                    plan.cut = Some((index, byte, error));
                    return plan;
                }
            }
        }
    }
    plan
}

impl<B: I2c<Error = ErrorKind>> ErrorType for Faulty<B> {
    type Error = ErrorKind;
}

impl<B: I2c<Error = ErrorKind>> I2c for Faulty<B> {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        let plan = {
            let mut faults = self.control.0.borrow_mut();
            if faults.stuck {
                faults.transactions += 1;
                return Err(ErrorKind::Bus);
            }
            let plan = plan(&mut faults, operations);
            faults.transactions += 1;
            plan
        };
        let passing =
            plan.cut.map_or(operations.len(), |(operation, bytes, _)| operation + usize::from(bytes > 0));
        if passing == 0 {
            return plan.cut.map_or(Ok(()), |(_, _, error)| Err(error));
        }
        let length = |index: usize, full: usize| match plan.cut {
            Some((operation, bytes, _)) if operation == index => bytes,
            _ => full,
        };
        // Written bytes are flipped on their way to the chip, so they need a place of their own.
        let mut written: Vec<Vec<u8>> = operations
            .iter()
            .take(passing)
            .map(|operation| match operation {
                Operation::Write(bytes) => bytes.to_vec(),
                Operation::Read(_) => Vec::new(),
            })
            .collect();
        for &(operation, byte, mask) in &plan.flips {
            if let Some(byte) = written.get_mut(operation).and_then(|bytes| bytes.get_mut(byte)) {
                *byte ^= mask;
            }
        }
        let mut forwarded: Vec<Operation<'_>> = operations
            .iter_mut()
            .take(passing)
            .zip(&written)
            .enumerate()
            .map(|(index, (operation, written))| match operation {
                Operation::Write(bytes) => Operation::Write(&written[..length(index, bytes.len())]),
                Operation::Read(bytes) => {
                    let kept = length(index, bytes.len());
                    Operation::Read(&mut bytes[..kept])
                }
            })
            .collect();
        self.inner.transaction(address, &mut forwarded)?;
        drop(forwarded);
        for &(operation, byte, mask) in &plan.flips {
            if let Some(Operation::Read(bytes)) = operations.get_mut(operation) {
                bytes[byte] ^= mask;
            }
        }
        plan.cut.map_or(Ok(()), |(_, _, error)| Err(error))
    }
}
