//! Why something is asked of the store.

/// What a job at the store is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JobPurpose {
    /// To find the calibration, at the start, or again because a slot did not answer then.
    Boot,
    /// For `version`.
    Version,
    /// For `cal accept`.
    Accept,
    /// For the button.
    AcceptByButton,
    /// For `cal clear`.
    Clear,
    #[cfg(feature = "study")]
    /// For `effect add` and `effect remove`.
    Effect,
}
