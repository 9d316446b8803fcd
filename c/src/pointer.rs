//! From the pointers of C to references and back: the only unsafe code of the library.
//!
//! The exported functions get their pointers from C, where no function is marked unsafe; Rust programs use the crate `ironout`.
//! A null or misaligned pointer is an error. That a pointer points to as many bytes as its type has, and that no other
//! thread uses them during the call, is what the header asks of the caller.

use crate::error::IronoutError;
use core::ffi::{CStr, c_char};
use core::slice;

fn is_usable<T>(pointer: *const T) -> bool {
    !pointer.is_null() && pointer.is_aligned()
}

/// What an input points to.
pub(crate) fn input<'a, T>(pointer: *const T) -> Result<&'a T, IronoutError> {
    if !is_usable(pointer) {
        return Err(IronoutError::IRONOUT_BAD_POINTER);
    }
    // SAFETY: not null and aligned; the caller promises that a `T` is there and that nobody changes it during the call.
    Ok(unsafe { &*pointer })
}

/// The three values that an input points to.
pub(crate) fn vector<T: Copy>(pointer: *const T) -> Result<[T; 3], IronoutError> {
    input(pointer.cast::<[T; 3]>()).copied()
}

/// The three values, or `None` for a null pointer.
pub(crate) fn optional_vector<T: Copy>(pointer: *const T) -> Result<Option<[T; 3]>, IronoutError> {
    if pointer.is_null() { Ok(None) } else { vector(pointer).map(Some) }
}

/// The bytes that an input points to.
pub(crate) fn bytes<'a>(pointer: *const u8, length: usize) -> Result<&'a [u8], IronoutError> {
    if pointer.is_null() || length > isize::MAX as usize {
        return Err(IronoutError::IRONOUT_BAD_POINTER);
    }
    // SAFETY: not null, and bytes are always aligned; the caller promises that `length` of them are there.
    Ok(unsafe { slice::from_raw_parts(pointer, length) })
}

/// A string that ends with a zero byte.
pub(crate) fn text<'a>(pointer: *const c_char) -> Result<&'a str, IronoutError> {
    if pointer.is_null() {
        return Err(IronoutError::IRONOUT_BAD_POINTER);
    }
    // SAFETY: not null; the caller promises a zero byte at the end.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| IronoutError::IRONOUT_BAD_ARGUMENT)
}

/// What an input or output points to, if it is initialised already.
pub(crate) fn change<'a, T>(pointer: *mut T) -> Result<&'a mut T, IronoutError> {
    if !is_usable(pointer) {
        return Err(IronoutError::IRONOUT_BAD_POINTER);
    }
    // SAFETY: not null and aligned; the caller promises that a `T` is there and that nobody else uses it during the call.
    Ok(unsafe { &mut *pointer })
}

/// Writes an output, whatever was there before.
pub(crate) fn write<T>(pointer: *mut T, value: T) -> Result<(), IronoutError> {
    if !is_usable(pointer) {
        return Err(IronoutError::IRONOUT_BAD_POINTER);
    }
    // SAFETY: not null and aligned; the caller promises room for a `T`. What was there needs no drop: no type of this
    // library has one.
    unsafe { pointer.write(value) };
    Ok(())
}

/// Writes three values.
pub(crate) fn write_vector<T>(pointer: *mut T, value: [T; 3]) -> Result<(), IronoutError> {
    write(pointer.cast::<[T; 3]>(), value)
}

/// Writes text with a zero byte at its end, cut where the room ends.
pub(crate) fn write_text(pointer: *mut c_char, room: usize, parts: &[&str]) -> Result<(), IronoutError> {
    if pointer.is_null() || room == 0 {
        return Err(IronoutError::IRONOUT_BAD_POINTER);
    }
    let mut at = 0;
    for byte in parts.iter().flat_map(|part| part.bytes()).take(room - 1) {
        // SAFETY: below `room`, and the caller promises that many bytes.
        unsafe { pointer.add(at).write(byte as c_char) };
        at += 1;
    }
    // SAFETY: at most `room - 1`.
    unsafe { pointer.add(at).write(0) };
    Ok(())
}

/// Copies bytes to an output.
pub(crate) fn write_bytes(pointer: *mut u8, room: usize, from: &[u8]) -> Result<(), IronoutError> {
    if pointer.is_null() {
        return Err(IronoutError::IRONOUT_BAD_POINTER);
    }
    if from.len() > room {
        return Err(IronoutError::IRONOUT_TOO_LITTLE_ROOM);
    }
    // SAFETY: not null, and the caller promises `room` bytes; `from` is ours, so the two do not overlap.
    unsafe { pointer.copy_from_nonoverlapping(from.as_ptr(), from.len()) };
    Ok(())
}
