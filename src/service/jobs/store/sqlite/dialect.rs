//! What SQLite says in its own way: parts of statements as literals.

/// The present time, RFC 3339 with milliseconds.
macro_rules! now {
    () => {
        "strftime('%Y-%m-%dT%H:%M:%fZ', 'now')"
    };
}
/// The time `$1` days ago.
macro_rules! days_ago {
    () => {
        "strftime('%Y-%m-%dT%H:%M:%fZ', 'now', '-' || $1 || ' days')"
    };
}
/// Seconds since a job arrived.
macro_rules! age_s {
    () => {
        "(julianday('now') - julianday(created_at)) * 86400.0"
    };
}
/// Makes the process `$1` that which has a job, for `$2` seconds.
macro_rules! taken {
    () => {
        "worker = $1"
    };
}
/// Whether the process that had a job has lost it: at the start of the only one.
macro_rules! is_lost {
    () => {
        "TRUE"
    };
}
/// Keeps the selected row from other writers until the end of the transaction: there are none.
macro_rules! locked {
    () => {
        ""
    };
}
/// Keeps the selected row from other writers, while others may keep it, too.
macro_rules! shared {
    () => {
        ""
    };
}
/// The same as `locked`, without waiting for rows that others keep.
macro_rules! locked_or_skipped {
    () => {
        ""
    };
}
/// Whether the document of a job contains the text `$2`.
macro_rules! scene_contains {
    () => {
        "instr(scene, CAST($2 AS BLOB)) > 0"
    };
}
/// Reads jobs by the index of those that wait, in the order of each owner.
macro_rules! by_owner {
    () => {
        " INDEXED BY jobs_waiting_of_owner"
    };
}
