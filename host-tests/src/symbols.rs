//! Where the flash of a program goes: its symbols, in groups by the room of the library or the crate that they come from.
//!
//! A byte belongs to one symbol only, and what lies between symbols (padding, literals without a name) is a group too: the groups sum to
//! the flash of the program. What the compiler inlines counts for the function that it is inlined into.

use std::collections::{BTreeMap, BTreeSet};

/// A function or a constant, and its bytes of flash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// Demangled, without its hash.
    pub name: String,
    /// Bytes that no symbol before it has.
    pub bytes: u64,
}

/// Symbols of one room or crate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The room, as `ironout::fit`, or the crate.
    pub name: String,
    /// Bytes over those of the empty program, where there is one: less than nothing if it has more of them.
    pub bytes: i64,
    /// Largest first; those of the empty program are left out.
    pub symbols: Vec<Symbol>,
}

/// Routines of the compiler for `f64` on a core whose floating-point unit has single precision only.
const DOUBLE: &str = "compiler: double precision";
/// Routines of the compiler that copy, clear and compare memory.
const MEMORY: &str = "compiler: memory";
/// Other routines of the compiler: division and conversion of long integers.
const OTHER_ROUTINES: &str = "compiler: other routines";
/// Strings and tables; their names do not say of which room.
const CONSTANTS: &str = "constants";
/// The programs, `main` and the start-up code.
const PROGRAM: &str = "program, with what is inlined into it";
const UNNAMED: &str = "between symbols";

/// The name as it is written in Rust, without the hash; a jump table's is that of its function.
fn demangled(name: &str) -> String {
    format!("{:#}", rustc_demangle::demangle(name.strip_prefix(SWITCH_TABLE).unwrap_or(name)))
}

/// Before the mangled name of the function whose `match` became a table.
const SWITCH_TABLE: &str = ".Lswitch.table.";

/// The group of a symbol by its demangled name.
fn group(name: &str) -> String {
    if name.starts_with(".Lanon.") || name.starts_with("anon.") || name.starts_with(".L__unnamed") {
        return CONSTANTS.to_owned();
    }
    let path =
        name.trim_start_matches(['<', '&', '[', '(']).trim_start_matches("mut ").trim_start_matches("dyn ");
    let end = path.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(path.len());
    let parts: Vec<&str> = path[..end].split("::").filter(|part| !part.is_empty()).collect();
    match parts.as_slice() {
        [function] => routine(function).to_owned(),
        ["compiler_builtins", .., function] => routine(function).to_owned(),
        // Rooms of the library, and parts of `core` such as `core::fmt`; a function of the crate's root has no room.
        [krate @ ("ironout" | "core"), room, _, ..] => format!("{krate}::{room}"),
        [krate, ..] if krate.starts_with("linked") || ["ironout_m4_bench", "cortex_m_rt"].contains(krate) => {
            PROGRAM.to_owned()
        }
        [krate, ..] => (*krate).to_owned(),
        [] => CONSTANTS.to_owned(),
    }
}

/// The group of a function without a path: a routine of the compiler, or of the start-up code.
fn routine(name: &str) -> &'static str {
    let base = name.trim_start_matches("__aeabi_").trim_start_matches('_');
    if base.starts_with("mem") || base == "bcmp" {
        return MEMORY;
    }
    if matches!(name, "fmax" | "fmin" | "fmaxf" | "fminf" | "sqrt" | "sqrtf") {
        return "libm";
    }
    if !name.starts_with("__") {
        return PROGRAM;
    }
    // `__aeabi_dadd`, `__aeabi_f2d`, `__adddf3`, `__floattidf`, `__fixdfsi`; but not `__aeabi_l2f`.
    let is_double = if name.starts_with("__aeabi_") {
        base.starts_with('d') || base.starts_with("cd") || base.ends_with("2d")
    } else {
        base.contains("df")
    };
    if is_double { DOUBLE } else { OTHER_ROUTINES }
}

/// A symbol as the image has it.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Mangled name.
    pub name: String,
    /// First byte.
    pub address: u64,
    /// Bytes.
    pub size: u64,
}

/// Symbols with the bytes that only they have: of two names of one function the first one counts.
fn own_bytes(mut placed: Vec<Placed>) -> Vec<Symbol> {
    placed.sort_by(|a, b| (a.address, b.size, &a.name).cmp(&(b.address, a.size, &b.name)));
    let mut end = 0;
    let mut symbols = Vec::new();
    for Placed { name, address, size } in placed {
        let bytes = (address + size).saturating_sub(end.max(address));
        end = end.max(address + size);
        if bytes > 0 {
            symbols.push(Symbol { name: demangled(&name), bytes });
        }
    }
    symbols
}

/// Groups of a program that has `flash` bytes, largest first, over the program `base`.
pub fn groups((placed, flash): (Vec<Placed>, u64), (base, base_flash): (Vec<Placed>, u64)) -> Vec<Group> {
    let mut groups: BTreeMap<String, Group> = BTreeMap::new();
    let mut add = |name: &str, bytes: i64, symbol: Option<Symbol>| {
        let new = || Group { name: name.to_owned(), bytes: 0, symbols: Vec::new() };
        let group = groups.entry(name.to_owned()).or_insert_with(new);
        group.bytes += bytes;
        group.symbols.extend(symbol);
    };
    let base = own_bytes(base);
    let known: BTreeSet<_> = base.iter().map(|symbol| symbol.name.clone()).collect();
    let (mut between, mut base_between) = (flash as i64, base_flash as i64);
    for symbol in own_bytes(placed) {
        let bytes = symbol.bytes as i64;
        between -= bytes;
        let is_new = !known.contains(&symbol.name);
        add(&group(&symbol.name), bytes, is_new.then_some(symbol));
    }
    for symbol in &base {
        base_between -= symbol.bytes as i64;
        add(&group(&symbol.name), -(symbol.bytes as i64), None);
    }
    add(UNNAMED, between - base_between, None);
    let mut groups: Vec<_> = groups.into_values().filter(|group| group.bytes != 0).collect();
    groups.sort_by_key(|group| -group.bytes);
    for group in &mut groups {
        group.symbols.sort_by(|a, b| (b.bytes, &a.name).cmp(&(a.bytes, &b.name)));
    }
    groups
}

/// The readable list: each group with its symbols of at least so many bytes.
pub fn list(program: &str, groups: &[Group], least: u64) -> String {
    let total: i64 = groups.iter().map(|group| group.bytes).sum();
    let mut text = format!("{total:>7}  {program}\n");
    for Group { name, bytes, symbols } in groups {
        text += &format!("{bytes:>7}    {name}\n");
        for symbol in symbols.iter().filter(|symbol| symbol.bytes >= least) {
            text += &format!("{:>7}      {}\n", symbol.bytes, symbol.name);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(name: &str, address: u64, size: u64) -> Placed {
        Placed { name: name.to_owned(), address, size }
    }

    #[test]
    fn groups_sum_to_the_flash_over_the_empty_program() {
        let main = || placed("main", 0, 10);
        let base = (vec![main(), placed("__aeabi_memcpy", 12, 40)], 56);
        let program = vec![
            main(),
            // Two names of one function, one function in the other, and a gap.
            placed("_ZN7ironout3fit5solve6report17hd21b2fad8253db0bE", 12, 100),
            placed("_ZN7ironout3fit5solve5other17hd21b2fad8253db0bE", 12, 100),
            placed("__aeabi_dmul", 112, 60),
            placed("_RNvNtNtCs7NhdfSRABLd_17compiler_builtins5float3mul8___muldf3", 120, 80),
            placed(".Lswitch.table._ZN7ironout3fit5solve6report17hd21b2fad8253db0bE", 300, 12),
            placed(".Lanon.c3c377abcbab2acf8e4a434d1fef9faa.83", 312, 30),
        ];
        let groups = groups((program, 350), base);
        assert_eq!(groups.iter().map(|group| group.bytes).sum::<i64>(), 350 - 56);
        let bytes: Vec<_> = groups.iter().map(|group| (group.name.as_str(), group.bytes)).collect();
        let expected = [
            ("ironout::fit", 112),
            ("between symbols", 104),
            ("compiler: double precision", 88),
            ("constants", 30),
            ("compiler: memory", -40),
        ];
        assert_eq!(bytes, expected);
        assert_eq!(groups[0].symbols[0], Symbol { name: "ironout::fit::solve::other".into(), bytes: 100 });
    }

    #[test]
    fn a_name_tells_its_room() {
        let rooms = [
            (
                "<ironout::effect::registry::BuiltIn<T> as ironout::effect::Effect<T>>::parts",
                "ironout::effect",
            ),
            ("<&mut ironout::gate::RestGate as core::fmt::Debug>::fmt", "ironout::gate"),
            ("core::fmt::Formatter::pad", "core::fmt"),
            ("ironout::dense::root", "ironout::dense"),
            ("ironout_m4_bench::linked::trace", PROGRAM),
            ("linked_trace::__cortex_m_rt_main", PROGRAM),
            ("Reset", PROGRAM),
            ("libm::math::sqrt::sqrtf", "libm"),
            ("__aeabi_memcpy4", MEMORY),
            ("compiler_builtins::mem::memcpy", MEMORY),
            ("__floattidf", DOUBLE),
            ("__aeabi_ul2d", DOUBLE),
            ("__aeabi_dcmple", DOUBLE),
            ("__aeabi_d2f", DOUBLE),
            ("__aeabi_ul2f", OTHER_ROUTINES),
            ("__aeabi_uldivmod", OTHER_ROUTINES),
            ("embassy_usb::Builder<D>::build", "embassy_usb"),
        ];
        for (name, room) in rooms {
            assert_eq!(group(name), room, "{name}");
        }
    }
}
