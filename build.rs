//! Writes the memory map of the chosen board and the linker arguments of the firmware.
//!
//! `memory.x` at the root is the single line `INCLUDE board.x`: the linker looks for it in the working directory
//! first, so a full map there would shadow the one written here. Nothing happens for a host target, where the
//! firmware is not built.

use std::{env, fs, path::PathBuf};

/// What the linker has to know of a board.
struct Map {
    /// The feature that chooses the board.
    feature: &'static str,
    flash_origin: u32,
    flash_kib: u32,
    /// KiB at the end of the flash that keep the calibration, and nothing of the program.
    slots_kib: u32,
    /// Whether the flash begins with the 256 bytes that the RP2040's boot ROM runs first.
    second_stage: bool,
    ram_origin: u32,
    ram_kib: u32,
    /// The part of RAM given to the stack.
    stack_kib: u32,
    /// Origin and KiB of a memory of their own for the statics, where the chip has one; the stack then has all of RAM.
    statics: Option<(u32, u32)>,
    /// Whether the board module brings its own interrupt table and weak handlers, or a vendor's crate does.
    own_vectors: bool,
}

/// The boards, by feature. The sizes of `mps2` are those of a real board of its class, not the emulator's 4 MiB: a
/// firmware that fits here fits there.
const MAPS: &[Map] = &[
    Map {
        feature: "board-mps2",
        flash_origin: 0x0000_0000,
        flash_kib: 512,
        slots_kib: 0,
        second_stage: false,
        ram_origin: 0x2000_0000,
        ram_kib: 128,
        stack_kib: 96,
        statics: None,
        own_vectors: true,
    },
    // Two sectors of 4 KiB for the slots. Of the RAM the four striped banks: the boot ROM uses the two banks above them, and
    // would spoil the trace there.
    Map {
        feature: "board-pico",
        flash_origin: 0x1000_0000,
        flash_kib: 2048,
        slots_kib: 8,
        second_stage: true,
        ram_origin: 0x2000_0000,
        ram_kib: 256,
        stack_kib: 160,
        statics: None,
        own_vectors: false,
    },
    // Two pages of 4 KiB for the slots; the interface chip programs the flash from its beginning on, without a bootloader.
    Map {
        feature: "board-microbit-v2",
        flash_origin: 0x0000_0000,
        flash_kib: 512,
        slots_kib: 8,
        second_stage: false,
        ram_origin: 0x2000_0000,
        ram_kib: 128,
        stack_kib: 64,
        statics: None,
        own_vectors: false,
    },
    // Two pages of 2 KiB for the slots. The statics are in the core-coupled memory, which no DMA reaches and none is used.
    Map {
        feature: "board-stm32f3discovery",
        flash_origin: 0x0800_0000,
        flash_kib: 256,
        slots_kib: 4,
        second_stage: false,
        ram_origin: 0x2000_0000,
        ram_kib: 40,
        stack_kib: 40,
        statics: Some((0x1000_0000, 8)),
        own_vectors: false,
    },
];

/// Bytes of the RP2040's second stage.
const SECOND_STAGE_BYTES: u32 = 256;

/// Bytes at the top of RAM that no start-up code touches: the trace of the last fault.
const TRACE_BYTES: u32 = 256;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rustc-check-cfg=cfg(armv6m)");
    if env::var("TARGET").is_ok_and(|target| target.starts_with("thumbv6m")) {
        // No fault status registers, no compare and swap.
        println!("cargo:rustc-cfg=armv6m");
    }
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let chosen: Vec<&Map> = MAPS.iter().filter(|map| has_feature(map.feature)).collect();
    match chosen[..] {
        // Only the library is built: it needs no map.
        [] if !has_feature("firmware") => {}
        [map] => write(map),
        _ => {
            let known: Vec<&str> = MAPS.iter().map(|map| map.feature).collect();
            let given: Vec<&str> = chosen.iter().map(|map| map.feature).collect();
            println!(
                "cargo::error=the firmware is built for exactly one board: choose one of the features {}; given: {}",
                known.join(", "),
                if given.is_empty() { "none".to_owned() } else { given.join(", ") }
            );
        }
    }
}

fn has_feature(name: &str) -> bool {
    env::var_os(format!("CARGO_FEATURE_{}", name.to_uppercase().replace('-', "_"))).is_some()
}

fn write(map: &Map) {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    // The stack lies at the bottom of RAM, below the statics: an overflow runs into unmapped addresses and faults at
    // once, where the usual layout would let it overwrite the statics unnoticed.
    // The trace has a region of its own rather than an `.uninit` section: loaders, QEMU's among them, clear every
    // section of the ELF at reset, and the trace has to outlive one.
    let ram_end = map.ram_origin + map.ram_kib * 1024;
    let beside = map.ram_origin + map.stack_kib * 1024;
    let (stack_bytes, statics, statics_bytes) = match map.statics {
        Some((origin, kib)) => (map.ram_kib * 1024 - TRACE_BYTES, origin, kib * 1024),
        None => (map.stack_kib * 1024, beside, ram_end - TRACE_BYTES - beside),
    };
    let (second_stage, flash) = if map.second_stage {
        let region =
            format!("  BOOT2 (rx)  : ORIGIN = {:#010x}, LENGTH = {SECOND_STAGE_BYTES}\n", map.flash_origin);
        (region, map.flash_origin + SECOND_STAGE_BYTES)
    } else {
        (String::new(), map.flash_origin)
    };
    let slots = map.flash_origin + (map.flash_kib - map.slots_kib) * 1024;
    let text = format!(
        "/* {feature}: written by build.rs */
MEMORY
{{
{second_stage}  FLASH (rx)  : ORIGIN = {flash:#010x}, LENGTH = {flash_bytes}
  STACK (rw)  : ORIGIN = {stack:#010x}, LENGTH = {stack_bytes}
  RAM   (rw)  : ORIGIN = {ram:#010x}, LENGTH = {ram_bytes}
  TRACE (rw)  : ORIGIN = {trace:#010x}, LENGTH = {TRACE_BYTES}
}}
_stack_start = ORIGIN(STACK) + LENGTH(STACK);
_stack_end = ORIGIN(STACK);
_fault_trace = ORIGIN(TRACE);
_slots = {slots:#010x};
",
        feature = map.feature,
        flash_bytes = slots - flash,
        stack = map.ram_origin,
        ram = statics,
        ram_bytes = statics_bytes,
        trace = ram_end - TRACE_BYTES,
    );
    fs::write(out.join("board.x"), text).expect("OUT_DIR is writable");
    if map.own_vectors {
        // cortex-m-rt's `device` feature includes this file; the table itself is in the board module.
        fs::write(out.join("device.x"), "/* no weak handlers: the board names every one */\n")
            .expect("OUT_DIR is writable");
    }
    println!("cargo:rustc-link-search={}", out.display());
    let second_stage = if map.second_stage { &["-Tlink-rp.x"][..] } else { &[] };
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"].iter().chain(second_stage) {
        println!("cargo:rustc-link-arg-bin=firmware={argument}");
    }
}
