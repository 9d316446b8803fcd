//! The EEPROM driver: pages, acknowledge polling, ranges.

use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use embedded_storage::{ReadStorage, Storage};
use ironout_drivers::at24c::{At24c, EepromError, Geometry};

const ROM: u8 = 0x50;
const BUSY: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

fn poll() -> Transaction {
    Transaction::write(ROM, vec![])
}

fn eeprom(transactions: &[Transaction]) -> At24c<Mock> {
    At24c::new(Mock::new(transactions), Geometry::AT24C32).unwrap()
}

#[test]
fn a_write_is_split_at_page_borders_and_each_page_is_waited_for() {
    let data: Vec<u8> = (0..40).collect();
    let frame = |address: [u8; 2], part: &[u8]| Transaction::write(ROM, [&address, part].concat());
    let mut rom = eeprom(&[
        poll(),
        frame([0x01, 0x1c], &data[..4]),
        poll().with_error(BUSY),
        poll().with_error(BUSY),
        poll(),
        frame([0x01, 0x20], &data[4..36]),
        poll(),
        frame([0x01, 0x40], &data[36..]),
        poll(),
    ]);
    rom.write(0x11c, &data).unwrap();
    rom.destroy().done();
}

#[test]
fn a_read_waits_for_a_write_under_way_and_is_one_transaction_across_pages() {
    let mut rom = eeprom(&[
        poll().with_error(BUSY),
        poll(),
        Transaction::write_read(ROM, vec![0x0f, 0xfc], vec![1, 2, 3, 4]),
    ]);
    let mut bytes = [0; 4];
    rom.read(4092, &mut bytes).unwrap();
    assert_eq!(bytes, [1, 2, 3, 4]);
    rom.destroy().done();
}

#[test]
fn nothing_is_sent_for_a_range_beyond_the_end() {
    let mut rom = eeprom(&[]);
    assert_eq!(rom.read(4093, &mut [0; 4]), Err(EepromError::OutOfRange { offset: 4093, bytes: 4 }));
    assert_eq!(rom.write(u32::MAX, &[0; 4]), Err(EepromError::OutOfRange { offset: u32::MAX, bytes: 4 }));
    assert_eq!(rom.capacity(), 4096);
    rom.destroy().done();
}

#[test]
fn a_chip_that_never_answers_again_is_a_timeout() {
    let mut transactions = vec![poll(), Transaction::write(ROM, vec![0, 0, 7])];
    transactions.extend((0..3).map(|_| poll().with_error(BUSY)));
    let mut rom = eeprom(&transactions).with_max_polls(3);
    assert_eq!(rom.write(0, &[7]), Err(EepromError::Timeout));
    rom.destroy().done();
}

#[test]
fn another_bus_error_ends_the_waiting_at_once() {
    let mut rom =
        eeprom(&[poll(), Transaction::write(ROM, vec![0, 0, 7]), poll().with_error(ErrorKind::Bus)]);
    assert_eq!(rom.write(0, &[7]), Err(EepromError::Bus(ErrorKind::Bus)));
    rom.destroy().done();
}

#[test]
fn a_geometry_outside_the_family_is_refused() {
    for (size_bytes, page_bytes) in [(4096, 0), (4096, 24), (0, 32), (65_537, 32)] {
        let mut bus = Mock::new(&[]);
        let refused = At24c::new(bus.clone(), Geometry { address: ROM, size_bytes, page_bytes });
        assert!(matches!(refused, Err(EepromError::InvalidConfig(_))), "{size_bytes} {page_bytes}");
        bus.done();
    }
}
