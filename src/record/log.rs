//! `/log`: messages for the user, as `foxglove.Log`.

use super::proto::foxglove::Log;
use super::proto::foxglove::log::Level;
use super::proto::timestamp;

/// Topic of the log.
pub const TOPIC: &str = "/log";
/// Schema of the log.
pub const SCHEMA: &str = "foxglove.Log";

/// A log line at a simulated time [s].
pub fn message(time: f64, level: Level, text: &str) -> Log {
    Log {
        timestamp: Some(timestamp(time)),
        level: level.into(),
        message: text.into(),
        name: "contuse".into(),
        ..Log::default()
    }
}
