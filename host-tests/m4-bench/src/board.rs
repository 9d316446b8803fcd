//! The emulated board as far as a measurement needs it: TIMER0 as the clock, the painted stack, the debugger's console.

use core::fmt;
use core::ptr::{read_volatile, write_volatile};

const CONTROL: *mut u32 = 0x4000_0000 as *mut u32;
const VALUE: *mut u32 = 0x4000_0004 as *mut u32;
const RELOAD: *mut u32 = 0x4000_0008 as *mut u32;

/// Starts the clock: TIMER0 counts down from the top.
pub fn start_clock() {
    // SAFETY: the registers of CMSDK timer 0, which nothing else in these images uses; they touch no memory.
    unsafe {
        write_volatile(RELOAD, u32::MAX);
        write_volatile(VALUE, u32::MAX);
        write_volatile(CONTROL, 1);
    }
}

#[inline(always)]
fn ticks() -> u32 {
    // SAFETY: reading the timer's value has no side effect.
    unsafe { read_volatile(VALUE) }
}

/// Timer ticks spent in `work`, the call itself included.
#[inline(always)]
pub fn ticks_of(work: impl FnOnce()) -> u32 {
    let before = ticks();
    work();
    let after = ticks();
    before.wrapping_sub(after)
}

const PAINT: u32 = 0x5aa5_c33c;

unsafe extern "C" {
    static mut _stack_end: u32;
}

/// The most stack that `work` uses, bytes: everything below the caller is painted first and read back afterwards.
#[inline(never)]
pub fn stack_of(work: impl FnOnce()) -> u32 {
    let marker = 0u32;
    let top = (&raw const marker as usize - 64) & !3;
    let bottom = &raw mut _stack_end as usize;
    for address in (bottom..top).step_by(4) {
        // SAFETY: between the end of the stack and 64 bytes below this frame; this frame calls nothing meanwhile.
        unsafe { write_volatile(address as *mut u32, PAINT) };
    }
    work();
    let mut lowest = top;
    for address in (bottom..top).step_by(4) {
        // SAFETY: as above, only read.
        if unsafe { read_volatile(address as *const u32) } != PAINT {
            lowest = address;
            break;
        }
    }
    (top - lowest) as u32
}

fn semihosting(operation: u32, argument: u32) {
    // SAFETY: a semihosting call; the emulator reads the argument and changes r0 only.
    unsafe {
        core::arch::asm!("bkpt #0xab", inout("r0") operation => _, in("r1") argument, options(nostack));
    }
}

/// The debugger's console.
pub struct Console;

impl fmt::Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        const SYS_WRITEC: u32 = 0x03;
        for byte in text.bytes() {
            semihosting(SYS_WRITEC, &raw const byte as u32);
        }
        Ok(())
    }
}

/// Ends the emulation: 0 for success, 1 for failure.
pub fn exit(success: bool) -> ! {
    const SYS_EXIT: u32 = 0x18;
    const APPLICATION_EXIT: u32 = 0x2_0026;
    const RUN_TIME_ERROR: u32 = 0x2_0023;
    semihosting(SYS_EXIT, if success { APPLICATION_EXIT } else { RUN_TIME_ERROR });
    loop {}
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    // The message would pull all of formatting into the size images: the location is enough.
    if let Some(place) = info.location() {
        let _ = fmt::Write::write_str(&mut Console, place.file());
    }
    exit(false)
}

#[cortex_m_rt::exception]
unsafe fn HardFault(_frame: &cortex_m_rt::ExceptionFrame) -> ! {
    exit(false)
}
