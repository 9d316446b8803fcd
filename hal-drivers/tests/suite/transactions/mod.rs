//! Every chip, transaction by transaction, blocking and awaited: what is sent, what the answers mean, and that each of them may
//! fail. Bytes are the datasheets', written out.

mod bmm350;
mod case;
mod chips;
mod inertial;
mod own;
mod probing;
