//! `/log`: what a person should read, as `foxglove.Log`.

use super::proto::foxglove::{Level, Log, timestamp};

/// Topic.
pub const TOPIC: &str = "/log";
/// Schema.
pub const SCHEMA: &str = "foxglove.Log";

/// A line at a simulated time [s].
pub fn message(time: f64, level: Level, text: &str) -> Log {
    Log {
        timestamp: Some(timestamp(time)),
        level: level.into(),
        message: text.into(),
        name: "contuse".into(),
    }
}
