//! The module that the page runs in a worker. Three functions over a plain C interface: the page reserves room, writes a question
//! (JSON) and the bytes that go with it, asks, and reads the answer (JSON) from where it is told.

use ironout_cli::page::Answering;
use std::cell::RefCell;

thread_local! {
    static ANSWERING: RefCell<Answering> = RefCell::new(Answering::default());
    /// What the page has written: the question and the bytes.
    static WRITTEN: RefCell<[Vec<u8>; 2]> = const { RefCell::new([Vec::new(), Vec::new()]) };
    /// The last answer.
    static SAID: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Room for `bytes` bytes of the question (`slot` 0) or of what goes with it (1); where it begins.
#[unsafe(no_mangle)]
pub extern "C" fn reserve(slot: usize, bytes: usize) -> *mut u8 {
    WRITTEN.with_borrow_mut(|written| match written.get_mut(slot) {
        Some(own) => {
            own.clear();
            own.resize(bytes, 0);
            own.as_mut_ptr()
        }
        None => std::ptr::null_mut(),
    })
}

/// Answers what was written; how many bytes the answer has.
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> usize {
    let [question, bytes] = WRITTEN.with_borrow_mut(std::mem::take);
    let question = String::from_utf8_lossy(&question);
    let answer = ANSWERING.with_borrow_mut(|answering| answering.answer(&question, &bytes));
    SAID.with_borrow_mut(|said| {
        *said = answer;
        said.len()
    })
}

/// Where the last answer begins.
#[unsafe(no_mangle)]
pub extern "C" fn said() -> *const u8 {
    SAID.with_borrow(|said| said.as_ptr())
}
