//! Valid names: names of parts, sets, bodies and scenes are used in tables, logs and files.

/// Largest number of characters in a name.
pub const LONGEST_NAME: usize = 200;

/// Largest number of parts and node sets of one mesh.
pub const MOST_NAMES: usize = 10_000;

/// The limit that a text violates as a name; `None` if it is valid.
pub fn fault(name: &str) -> Option<&'static str> {
    if name.chars().nth(LONGEST_NAME).is_some() {
        Some("at most 200 characters")
    } else if name.chars().any(is_unseen) {
        Some("no control characters, and none that change the writing direction")
    } else {
        None
    }
}

/// Control characters, and those that change the order in which text is displayed (Unicode Bidirectional Algorithm, §2).
fn is_unseen(c: char) -> bool {
    c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A name truncated for a message.
pub fn shortened(name: &str) -> String {
    let visible = |c: char| if is_unseen(c) { '\u{fffd}' } else { c };
    let mut short: String = name.chars().take(40).map(visible).collect();
    if name.chars().nth(40).is_some() {
        short.push('…');
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short_and_seen() {
        assert_eq!(fault(&"ä".repeat(LONGEST_NAME)), None);
        assert!(fault(&"ä".repeat(LONGEST_NAME + 1)).is_some());
        for name in ["a\u{1}", "\u{1b}[31m", "a\u{202e}b"] {
            assert!(fault(name).is_some(), "{name:?}");
            assert!(fault(&shortened(name)).is_none());
        }
        assert_eq!(shortened(&"x".repeat(50)).chars().count(), 41);
    }
}
