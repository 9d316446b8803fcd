//! What a probing sends.

use embassy_futures::block_on;
use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use embedded_hal_mock::eh1::delay::NoopDelay;
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use ironout_drivers::{Findings, Kind, asynch, probe};

use crate::transactions::case::{rd, wr};

const NOBODY: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

fn nobody(transaction: Transaction) -> Transaction {
    transaction.with_error(NOBODY)
}

/// Both ways.
fn probed(transactions: &[Transaction]) -> Findings<ErrorKind> {
    let mut bus = Mock::new(transactions);
    let findings = probe(&mut bus, &mut NoopDelay::new());
    bus.done();
    let mut bus = Mock::new(transactions);
    assert_eq!(block_on(asynch::probe(&mut bus, &mut NoopDelay::new())), findings);
    bus.done();
    findings
}

/// Up to 0x1c, where nobody is.
fn before_0x1e() -> Vec<Transaction> {
    let mut transactions = vec![
        nobody(rd(0x0c, 0x00, &[0])),
        nobody(rd(0x0d, 0x0d, &[0])),
        nobody(rd(0x0e, 0x00, &[0])),
        nobody(rd(0x0f, 0x00, &[0])),
    ];
    transactions.extend((0x10..=0x13).map(|address| nobody(wr(address, 0x4b, 0x01))));
    // Two bytes without a meaning first.
    transactions.extend((0x14..=0x15).map(|address| nobody(rd(address, 0x00, &[0; 3]))));
    transactions.push(nobody(rd(0x1c, 0x0f, &[0])));
    transactions
}

/// Behind 0x1e, where nobody is.
fn behind_0x1e() -> Vec<Transaction> {
    let mut transactions: Vec<_> = (0x20..=0x23).map(|address| nobody(rd(address, 0x36, &[0]))).collect();
    transactions.extend([
        nobody(rd(0x2c, 0x00, &[0])),
        nobody(rd(0x30, 0x2f, &[0])),
        nobody(rd(0x3c, 0x00, &[0])),
        nobody(rd(0x68, 0x00, &[0])),
        nobody(rd(0x69, 0x00, &[0])),
        nobody(rd(0x7c, 0x00, &[0])),
    ]);
    transactions
}

#[test]
fn each_address_is_asked_once_and_only_at_0x10_to_0x13_something_is_written() {
    let transactions = [before_0x1e(), vec![nobody(rd(0x1e, 0x4f, &[0]))], behind_0x1e()].concat();
    let findings = probed(&transactions);
    assert_eq!((findings.first(), findings.trouble, findings.strangers), (None, None, 0));
}

#[test]
fn two_chips_of_one_identity_are_told_apart_by_what_is_beside_them() {
    let h43 = [rd(0x1e, 0x4f, &[0]), rd(0x1e, 0x0a, b"H"), rd(0x1e, 0x0b, b"4"), rd(0x1e, 0x0c, b"3")];
    for (beside, kind, or) in [
        (rd(0x19, 0x0f, &[0x33]), Kind::Lsm303dlhc, Some(Kind::Hmc5883l)),
        (nobody(rd(0x19, 0x0f, &[0])), Kind::Hmc5883l, None),
        (rd(0x19, 0x0f, &[0]).with_error(ErrorKind::Bus), Kind::Hmc5883l, Some(Kind::Lsm303dlhc)),
    ] {
        let transactions = [before_0x1e(), h43.to_vec(), vec![beside], behind_0x1e()].concat();
        let found = probed(&transactions).first().unwrap();
        assert_eq!((found.kind, found.or, found.address), (kind, or, 0x1e));
    }
    for (beside, kind) in
        [(rd(0x19, 0x0f, &[0x33]), Kind::Lsm303agr), (nobody(rd(0x19, 0x0f, &[0])), Kind::Lis2mdl)]
    {
        let transactions = [before_0x1e(), vec![rd(0x1e, 0x4f, &[0x40]), beside], behind_0x1e()].concat();
        let found = probed(&transactions).first().unwrap();
        assert_eq!((found.kind, found.is_ambiguous()), (kind, false));
    }
}
