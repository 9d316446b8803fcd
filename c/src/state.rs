//! What an opaque state holds: a Rust value behind a word that says whether it was initialised.

use crate::error::IronoutError;
use crate::pointer;

/// A state as it lies in the caller's memory.
#[repr(C)]
pub(crate) struct State<T> {
    /// [`Kind::MARK`] once initialised. Static memory starts as zeros, which is no mark.
    mark: u32,
    value: T,
}

/// A kind of state.
pub(crate) trait Kind: Sized {
    /// The word of an initialised state of this kind.
    const MARK: u32;
    /// The opaque type in the header.
    type Opaque;

    /// A state fits its opaque type, on whatever target this is compiled for.
    const FITS: () = {
        assert!(size_of::<State<Self>>() <= size_of::<Self::Opaque>(), "the opaque type is too small");
        assert!(align_of::<State<Self>>() <= align_of::<Self::Opaque>(), "the opaque type is not aligned");
    };
}

/// Puts a value into the caller's memory.
pub(crate) fn init<K: Kind>(place: *mut K::Opaque, value: K) -> Result<(), IronoutError> {
    pointer::write(place.cast::<State<K>>(), State { mark: K::MARK, value })
}

/// The value in the caller's memory.
pub(crate) fn get<'a, K: Kind + 'a>(place: *const K::Opaque) -> Result<&'a K, IronoutError> {
    check::<K>(place)?;
    pointer::input(place.cast::<State<K>>()).map(|state| &state.value)
}

/// The value in the caller's memory, to be changed.
pub(crate) fn get_mut<'a, K: Kind + 'a>(place: *mut K::Opaque) -> Result<&'a mut K, IronoutError> {
    check::<K>(place)?;
    pointer::change(place.cast::<State<K>>()).map(|state| &mut state.value)
}

/// Looks at the mark alone: before it is seen, nothing else there may be taken for a value.
fn check<K: Kind>(place: *const K::Opaque) -> Result<(), IronoutError> {
    pointer::input(place.cast::<u64>())?;
    let mark = *pointer::input(place.cast::<u32>())?;
    if mark == K::MARK { Ok(()) } else { Err(IronoutError::IRONOUT_NOT_INITIALISED) }
}
