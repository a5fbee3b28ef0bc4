//! What PostgreSQL says in its own way: parts of statements as literals. Its clock is that of all processes.

/// The present time, RFC 3339 with milliseconds.
macro_rules! now {
    () => {
        "rfc3339(clock_timestamp())"
    };
}
/// The time `$1` days ago.
macro_rules! days_ago {
    () => {
        "rfc3339(clock_timestamp() - make_interval(days => $1::int))"
    };
}
/// Seconds since a job arrived.
macro_rules! age_s {
    () => {
        "EXTRACT(EPOCH FROM clock_timestamp() - created_at::timestamptz)::float8"
    };
}
/// Makes the process `$1` that which has a job, for `$2` seconds.
macro_rules! taken {
    () => {
        "worker = $1, lease_until = clock_timestamp() + make_interval(secs => $2)"
    };
}
/// Whether the process that had a job has lost it.
macro_rules! is_lost {
    () => {
        "lease_until <= clock_timestamp()"
    };
}
/// Keeps the selected row from other writers until the end of the transaction.
macro_rules! locked {
    () => {
        " FOR UPDATE"
    };
}
/// Keeps the selected row from other writers, while others may keep it, too.
macro_rules! shared {
    () => {
        " FOR SHARE"
    };
}
/// The same as `locked`, without waiting for rows that others keep.
macro_rules! locked_or_skipped {
    () => {
        " FOR UPDATE SKIP LOCKED"
    };
}
/// Whether the document of a job contains the text `$2`.
macro_rules! scene_contains {
    () => {
        "position(convert_to($2, 'UTF8') IN scene) > 0"
    };
}
/// Reads jobs by the index of those that wait, in the order of each owner: PostgreSQL chooses it by itself.
macro_rules! by_owner {
    () => {
        ""
    };
}
