//! Keeping the store in sight: whether it answers, and when it is asked again.

/// The pause after a look at a store that did not answer, doubled each time up to the longest.
const FIRST_PAUSE_MS: u64 = 20;
const LONGEST_PAUSE_MS: u64 = 1000;

/// The watch over the store.
#[derive(Debug, Clone)]
pub(super) struct StoreWatch {
    /// Some slot was not read yet: the record that counts may stand in it.
    is_unread: bool,
    /// When a store that did not answer is asked again, and after which pause.
    again: Option<(u64, u64)>,
    /// It was looked at again for the line that waits.
    pub(super) looked_again: bool,
}

impl StoreWatch {
    /// A store that was not looked at yet.
    pub(super) const fn new() -> Self {
        Self { is_unread: true, again: None, looked_again: false }
    }

    /// A store that is never touched.
    pub(super) const fn rest(&mut self) {
        (self.is_unread, self.again) = (false, None);
    }

    /// Whether some slot was not read yet.
    pub(super) const fn is_unread(&self) -> bool {
        self.is_unread
    }

    /// Whether it did not answer when it was asked last.
    pub(super) const fn is_silent(&self) -> bool {
        self.again.is_some()
    }

    /// Whether it is to be asked again.
    pub(super) fn is_due(&self, now_ms: u64) -> bool {
        self.again.is_some_and(|(at_ms, _)| now_ms >= at_ms)
    }

    /// When it is to be asked again.
    pub(super) fn deadline_ms(&self) -> Option<u64> {
        self.again.map(|(at_ms, _)| at_ms)
    }

    /// All slots were read, or one was written and the other one is known.
    pub(super) const fn answered(&mut self) {
        (self.is_unread, self.again) = (false, None);
    }

    /// Something failed: it is asked again after a pause.
    pub(super) fn failed(&mut self, now_ms: u64) {
        let pause_ms =
            self.again.map_or(FIRST_PAUSE_MS, |(_, pause_ms)| (2 * pause_ms).min(LONGEST_PAUSE_MS));
        self.again = Some((now_ms.saturating_add(pause_ms), pause_ms));
    }
}

#[cfg(test)]
mod tests {
    use super::StoreWatch;

    #[test]
    fn a_store_that_does_not_answer_is_asked_again_with_growing_pauses_for_ever() {
        let mut watch = StoreWatch::new();
        assert!(!watch.is_due(u64::MAX), "the look at the start is under way");
        let mut now_ms = 0;
        let mut pauses = [0; 9];
        for pause_ms in &mut pauses {
            watch.failed(now_ms);
            let due_ms = watch.deadline_ms().unwrap();
            assert!(watch.is_due(due_ms) && !watch.is_due(due_ms - 1) && watch.is_silent());
            (*pause_ms, now_ms) = (due_ms - now_ms, due_ms);
        }
        assert_eq!(pauses, [20, 40, 80, 160, 320, 640, 1000, 1000, 1000]);
        watch.answered();
        assert!(!watch.is_silent() && !watch.is_unread() && watch.deadline_ms().is_none());
        watch.failed(now_ms);
        assert_eq!(watch.deadline_ms(), Some(now_ms + 20), "from the beginning");
    }
}
