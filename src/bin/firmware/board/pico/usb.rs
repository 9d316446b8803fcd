//! A serial port on USB (CDC ACM): one cable for power and console.
//!
//! embassy-usb's task runs on an executor in an interrupt of the lowest priority; the loop sees two buffers.

use super::time::now_us;
use crate::board::outgoing::Outgoing;
use crate::board::port::STALL_LIMIT_US;
use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_futures::join::join3;
use embassy_rp::peripherals::USB;
use embassy_rp::usb::{Driver, InterruptHandler};
use embassy_rp::{Peri, bind_interrupts, interrupt};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Timer;
use embassy_usb::class::cdc_acm::{CdcAcmClass, State};
use embassy_usb::{Builder, Config};
use heapless::spsc::{Consumer, Producer, Queue};
use ironout::device::MAX_REPLY_BYTES;
use static_cell::StaticCell;

/// A full-speed bulk packet.
const PACKET_BYTES: usize = 64;
const RX_BYTES: usize = 256;
const TX_BYTES: usize = MAX_REPLY_BYTES + 256;

/// Raspberry Pi's identifiers for a serial port made by the firmware of an RP2040, which every system has a driver for.
const VENDOR: u16 = 0x2E8A;
const PRODUCT: u16 = 0x000A;

bind_interrupts!(struct Irqs {
    USBCTRL_IRQ => InterruptHandler<USB>;
});

static EXECUTOR: InterruptExecutor = InterruptExecutor::new();
/// There is something to send, or room for what comes.
static TO_SEND: Signal<CriticalSectionRawMutex, ()> = Signal::new();

#[interrupt]
unsafe fn SWI_IRQ_0() {
    // SAFETY: called from this handler only, which is unmasked by `start`.
    unsafe { EXECUTOR.on_interrupt() }
}

/// The port.
pub struct Usb {
    received: Consumer<'static, u8>,
    outgoing: Outgoing,
}

impl Usb {
    /// Sets the port up. `None` if it already is.
    pub(super) fn new(usb: Peri<'static, USB>) -> Option<Self> {
        let rx_buffer = cortex_m::singleton!(: Queue<u8, RX_BYTES> = Queue::new())?;
        let tx_buffer = cortex_m::singleton!(: Queue<u8, TX_BYTES> = Queue::new())?;
        let (rx_in, rx_out) = rx_buffer.split();
        let (tx_in, tx_out) = tx_buffer.split();
        let spawner: SendSpawner = EXECUTOR.start(interrupt::SWI_IRQ_0);
        spawner.spawn(serve(Driver::new(usb, Irqs), rx_in, tx_out).ok()?);
        Some(Self { received: rx_out, outgoing: Outgoing::new(tx_in, STALL_LIMIT_US) })
    }

    /// The next byte received.
    pub fn read(&mut self) -> Option<u8> {
        self.received.dequeue()
    }

    /// Whether [`Self::read`] has something to give.
    pub fn has_input(&self) -> bool {
        self.received.ready()
    }

    /// Whether so many bytes may be put.
    pub fn takes(&self, bytes: usize) -> bool {
        self.outgoing.takes(bytes, now_us() as u32)
    }

    /// Queues text.
    pub fn put(&mut self, text: &str) {
        self.outgoing.put(text);
        TO_SEND.signal(());
    }
}

/// Everything behind the port.
#[embassy_executor::task]
async fn serve(
    driver: Driver<'static, USB>,
    mut received: Producer<'static, u8>,
    mut to_send: Consumer<'static, u8>,
) {
    static CONFIG: StaticCell<[u8; 128]> = StaticCell::new();
    static CONTROL: StaticCell<[u8; 64]> = StaticCell::new();
    static STATE: StaticCell<State<'static>> = StaticCell::new();
    let mut config = Config::new(VENDOR, PRODUCT);
    config.manufacturer = Some("ironout");
    config.product = Some("ironout magnetometer");
    config.max_power = 100;
    config.max_packet_size_0 = 64;
    let mut builder =
        Builder::new(driver, config, CONFIG.init([0; 128]), &mut [], &mut [], CONTROL.init([0; 64]));
    let class = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET_BYTES as u16);
    let mut device = builder.build();
    let (mut sender, mut receiver) = class.split();
    let receive = async {
        let mut packet = [0; PACKET_BYTES];
        loop {
            receiver.wait_connection().await;
            while let Ok(length) = receiver.read_packet(&mut packet).await {
                for &byte in packet.get(..length).unwrap_or_default() {
                    // A full buffer holds the host up: the next packet is asked for when this one has gone.
                    while received.enqueue(byte).is_err() {
                        Timer::after_millis(1).await;
                    }
                }
            }
        }
    };
    let send = async {
        loop {
            sender.wait_connection().await;
            loop {
                let mut packet = heapless::Vec::<u8, PACKET_BYTES>::new();
                while !packet.is_full()
                    && let Some(byte) = to_send.dequeue()
                {
                    let _ = packet.push(byte);
                }
                if packet.is_empty() {
                    TO_SEND.wait().await;
                    continue;
                }
                // A full packet says that more follows; where nothing does, an empty one says so.
                let ends_full = packet.is_full() && !to_send.ready();
                if sender.write_packet(&packet).await.is_err()
                    || (ends_full && sender.write_packet(&[]).await.is_err())
                {
                    break;
                }
            }
        }
    };
    join3(device.run(), receive, send).await;
}
