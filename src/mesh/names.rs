//! What a name may be: that of a part, a set, a body or a scene goes into tables, logs and files.

/// Characters of the longest name.
pub const LONGEST_NAME: usize = 200;

/// Names of parts and node sets of one mesh: more are no names any more.
pub const MOST_NAMES: usize = 10_000;

/// Why a text is no name, in the words of a limit; nothing when it may be one.
pub fn fault(name: &str) -> Option<&'static str> {
    if name.chars().nth(LONGEST_NAME).is_some() {
        Some("at most 200 characters")
    } else if name.chars().any(is_unseen) {
        Some("no control characters, and none that turn the direction of writing")
    } else {
        None
    }
}

/// Control characters, and those that make a text read otherwise than it is written (Unicode Bidirectional Algorithm, §2).
fn is_unseen(c: char) -> bool {
    c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A name of any length, short enough for a message.
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
