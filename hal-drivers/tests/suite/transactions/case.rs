//! What every register chip has to do with its transactions.

use embassy_futures::block_on;
use embedded_hal::i2c::ErrorKind;
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use ironout_drivers::{AsyncMagnetometer, Chip, Driver, Error, Magnetometer, Reading, asynch};

/// The bytes read from a register on.
pub fn rd(address: u8, register: u8, bytes: &[u8]) -> Transaction {
    Transaction::write_read(address, vec![register], bytes.to_vec())
}

/// A byte to a register.
pub fn wr(address: u8, register: u8, byte: u8) -> Transaction {
    Transaction::write(address, vec![register, byte])
}

/// A chip's transactions as its datasheet has them.
pub struct Case<C> {
    /// The configuration.
    pub config: C,
    /// Of a configuration, the identity's first.
    pub init: Vec<Transaction>,
    /// The identity, and another one.
    pub identity: ([u8; 3], Transaction, [u8; 3]),
    /// What asks whether data are ready: yes, and no.
    pub ready: Vec<Transaction>,
    pub not_ready: Vec<Transaction>,
    /// Measurements and what they are.
    pub readings: Vec<(Vec<Transaction>, Reading)>,
    /// Temperatures.
    pub celsius: Vec<(Vec<Transaction>, Option<f32>)>,
}

/// A measurement in range.
pub fn counts(counts: [i16; 3]) -> Reading {
    Reading { counts, overflow: [false; 3] }
}

/// One operation, both ways, over the same transactions: the same answer, and every transaction was made.
fn both<C: Chip + Copy, T: PartialEq + std::fmt::Debug>(
    config: C,
    transactions: &[Transaction],
    blocking: impl Fn(&mut Driver<Mock, C>) -> T,
    awaited: impl AsyncFn(&mut asynch::Driver<Mock, C>) -> T,
) -> T {
    let mut driver = Driver::new(Mock::new(transactions), config);
    let answer = blocking(&mut driver);
    driver.destroy().done();
    let mut driver = asynch::Driver::new(Mock::new(transactions), config);
    assert_eq!(block_on(awaited(&mut driver)), answer, "awaited, it is another");
    driver.destroy().done();
    answer
}

/// An operation of which each transaction fails in turn, and which is done again: a bus error, then the answer.
fn each_fails<C: Chip + Copy, T: PartialEq + std::fmt::Debug>(
    config: C,
    transactions: &[Transaction],
    blocking: impl Fn(&mut Driver<Mock, C>) -> Result<T, Error<ErrorKind>>,
    awaited: impl AsyncFn(&mut asynch::Driver<Mock, C>) -> Result<T, Error<ErrorKind>>,
) {
    for place in 0..transactions.len() {
        let failing =
            [&transactions[..place], &[transactions[place].clone().with_error(ErrorKind::Other)]].concat();
        let failed = both(config, &failing, &blocking, &awaited);
        assert_eq!(failed, Err(Error::Bus(ErrorKind::Other)), "transaction {place}");
    }
    assert!(both(config, transactions, blocking, awaited).is_ok());
}

impl<C: Chip + Copy> Case<C> {
    /// Runs all of it.
    pub fn run(self) {
        let Case { config, init, identity, ready, not_ready, readings, celsius } = self;
        each_fails(config, &init, |driver| driver.init(), async |driver| driver.init().await);

        let (expected, answer, found) = identity;
        let refused = both(config, &[answer], |driver| driver.init(), async |driver| driver.init().await);
        assert_eq!(refused, Err(Error::NotFound { expected, found }), "nothing is written to another chip");

        // After an error of its configuration the next one is whole.
        let mut twice = vec![init[0].clone().with_error(ErrorKind::Bus)];
        twice.extend(init.iter().cloned());
        let healed = both(
            config,
            &twice,
            |driver| (driver.init(), driver.init()),
            async |driver| (driver.init().await, driver.init().await),
        );
        assert_eq!(healed, (Err(Error::Bus(ErrorKind::Bus)), Ok(())));

        for (transactions, answer) in [(ready, true), (not_ready, false)] {
            each_fails(
                config,
                &transactions,
                |driver| driver.data_ready(),
                async |driver| driver.data_ready().await,
            );
            let said = both(
                config,
                &transactions,
                |driver| driver.data_ready(),
                async |driver| driver.data_ready().await,
            );
            assert_eq!(said, Ok(answer));
        }
        for (transactions, reading) in readings {
            each_fails(config, &transactions, |driver| driver.read(), async |driver| driver.read().await);
            let read =
                both(config, &transactions, |driver| driver.read(), async |driver| driver.read().await);
            assert_eq!(read, Ok(reading));
        }
        for (transactions, celsius) in celsius {
            let read = both(
                config,
                &transactions,
                |driver| driver.temperature_c(),
                async |driver| driver.temperature_c().await,
            );
            assert_eq!(read, Ok(celsius));
            if !transactions.is_empty() {
                each_fails(
                    config,
                    &transactions,
                    |driver| driver.temperature_c(),
                    async |driver| driver.temperature_c().await,
                );
            }
        }
    }
}
