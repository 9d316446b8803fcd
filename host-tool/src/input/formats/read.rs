//! One door for all formats: bytes in, a log out.

use crate::failure::Outcome;
use crate::input::formats::detected::Format;
use crate::input::formats::feed::Feed;
use crate::input::formats::join::join;
use crate::input::formats::{betaflight_json, blackbox, dataflash, mavlink, ros, ulog};
use crate::input::log::{Log, ReadOptions};
use crate::progress::Progress;
use std::io::Read;

/// Reads a log of `format` from its first byte; `size_bytes` (0: unknown) is for the progress bar.
///
/// # Errors
/// Not readable, no magnetometer in it (what is there is named), or an option that does not fit it.
pub fn read(format: Format, source: impl Read, size_bytes: u64, options: &ReadOptions) -> Outcome<Log> {
    let progress = Progress::new("reading", size_bytes, options.progress);
    let recording = match format {
        Format::Ulog => ulog::read(&mut Feed::new(source, progress), options.instance)?,
        Format::DataflashBinary => {
            dataflash::read_binary(&mut Feed::new(source, progress), options.instance)?
        }
        Format::DataflashText => dataflash::read_text(&mut Feed::new(source, progress), options.instance)?,
        Format::Blackbox => blackbox::read(source, options.instance)?,
        Format::BetaflightJson => betaflight_json::read(source)?,
        Format::Mavlink => mavlink::read(&mut Feed::new(source, progress), options.instance)?,
        Format::Mcap => ros::read(&mut Feed::new(source, progress), size_bytes, options.instance)?,
        Format::Rosbag => ros::read_bag(source, options.instance)?,
    };
    join(recording, options)
}
