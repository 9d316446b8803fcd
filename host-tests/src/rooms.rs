//! Where the bytes of a linked program are: by room of the library, and the largest functions. `cargo footprint rooms`.

use crate::m4::M4Error;
use object::{Object, ObjectSymbol, SymbolKind};
use std::collections::BTreeMap;
use std::path::Path;

/// What a symbol that is not of the library belongs to.
const OTHERS: [(&str, &str); 4] = [
    ("libm", "libm"),
    ("compiler_builtins", "floats in software, memory"),
    ("__aeabi", "floats in software, memory"),
    ("core", "core"),
];

/// A function or constant with its room.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// Readable path.
    pub path: String,
    /// Room of the library, or what else it is.
    pub room: String,
    /// Bytes of flash.
    pub bytes: u64,
}

/// The path of a mangled name (`_ZN` form), without its hash; the name itself where it is not mangled.
fn path_of(name: &str) -> String {
    let mut parts = Vec::new();
    let mut rest = name.strip_prefix("_ZN").unwrap_or("");
    while let Some(digits) = rest.find(|c: char| !c.is_ascii_digit()).filter(|&digits| digits > 0) {
        let Some((length, after)) = rest[..digits].parse::<usize>().ok().zip(rest.get(digits..)) else {
            break;
        };
        let Some(part) = after.get(..length) else { break };
        parts.push(part);
        rest = &after[length..];
    }
    parts.pop_if(|part| part.len() == 17 && part.starts_with('h'));
    if parts.is_empty() {
        return name.to_owned();
    }
    let readable = [("..", "::"), ("$LT$", "<"), ("$GT$", ">"), ("$u20$", " "), ("$C$", ","), ("$RF$", "&")];
    let path =
        parts.iter().map(|part| part.strip_prefix("_$").map_or((*part).to_owned(), |p| format!("${p}")));
    readable.iter().fold(path.collect::<Vec<_>>().join("::"), |path, (from, to)| path.replace(from, to))
}

/// The room of a path.
fn room_of(path: &str) -> String {
    if let Some((_, inside)) = path.split_once("ironout::") {
        let end = inside.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(inside.len());
        return inside[..end].to_owned();
    }
    if path.contains("ironout_m4_bench") {
        return "the program, with what is inlined".to_owned();
    }
    let other = OTHERS.iter().find(|(begin, _)| path.trim_start_matches(['<', '&']).starts_with(begin));
    other.map_or("else", |(_, room)| room).to_owned()
}

/// The symbols of an image, the largest first.
///
/// # Errors
/// The image cannot be read.
pub fn symbols(image: &Path) -> Result<Vec<Symbol>, M4Error> {
    let bytes = std::fs::read(image)?;
    let file = object::File::parse(&*bytes)
        .map_err(|error| M4Error::Failed(format!("{}: {error}", image.display())))?;
    let is_placed = |kind| matches!(kind, SymbolKind::Text | SymbolKind::Data);
    let placed = file.symbols().filter(|symbol| is_placed(symbol.kind()) && symbol.size() > 0);
    let mut symbols: Vec<Symbol> = placed
        .filter_map(|symbol| {
            let path = path_of(symbol.name().ok()?);
            let is_constant = symbol.kind() == SymbolKind::Data;
            let room = if is_constant { "constants".to_owned() } else { room_of(&path) };
            Some(Symbol { path, room, bytes: symbol.size() })
        })
        .collect();
    symbols.sort_by(|a, b| b.bytes.cmp(&a.bytes).then_with(|| a.path.cmp(&b.path)));
    Ok(symbols)
}

/// Bytes by room, and the largest functions, as a readable table.
pub fn table(key: &str, symbols: &[Symbol], largest: usize) -> String {
    let mut rooms = BTreeMap::<&str, u64>::new();
    for symbol in symbols {
        *rooms.entry(&symbol.room).or_default() += symbol.bytes;
    }
    let mut rooms: Vec<_> = rooms.into_iter().collect();
    rooms.sort_by_key(|&(room, bytes)| (std::cmp::Reverse(bytes), room));
    let mut text = format!("{key}: bytes by room\n");
    for (room, bytes) in rooms.iter().filter(|(_, bytes)| *bytes >= 100) {
        text += &format!("{bytes:>8}  {room}\n");
    }
    text += &format!("{key}: the largest functions\n");
    for Symbol { path, bytes, .. } in symbols.iter().filter(|symbol| symbol.room != "constants").take(largest)
    {
        let shown: String = path.chars().take(100).collect();
        text += &format!("{bytes:>8}  {shown}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mangled_name_is_a_path_and_has_a_room() {
        for (name, path, room) in [
            (
                "_ZN7ironout8coverage6sketch6Sketch4grow17h0123456789abcdefE",
                "ironout::coverage::sketch::Sketch::grow",
                "coverage",
            ),
            (
                "_ZN17compiler_builtins5float3div8__divdf317h0123456789abcdefE",
                "compiler_builtins::float::div::__divdf3",
                "floats in software, memory",
            ),
            ("__aeabi_memcpy", "__aeabi_memcpy", "floats in software, memory"),
            ("Reset", "Reset", "else"),
        ] {
            assert_eq!((path_of(name).as_str(), room_of(path).as_str()), (path, room));
        }
        let of_a_trait = "_ZN95_$LT$ironout..effect..registry..BuiltIn$LT$T$GT$$u20$as$u20$ironout..effect..Effect$GT$7columns17h0123456789abcdefE";
        let path = path_of(of_a_trait);
        assert!(path.contains("ironout::effect::registry::BuiltIn<T> as ironout"), "{path}");
        assert_eq!(room_of(&path), "effect");
    }

    #[test]
    fn the_table_adds_up_by_room_and_names_the_largest() {
        let symbol = |path: &str, room: &str, bytes| Symbol { path: path.into(), room: room.into(), bytes };
        let symbols = [
            symbol("a::x", "a", 900),
            symbol("b::y", "b", 700),
            symbol("b::z", "b", 600),
            symbol("c", "constants", 99),
        ];
        let text = table("session", &symbols, 2);
        assert_eq!(
            text,
            "session: bytes by room\n    1300  b\n     900  a\nsession: the largest functions\n     900  a::x\n     700  b::y\n"
        );
    }
}
