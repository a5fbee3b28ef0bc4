//! What this process takes and may use: processor time and memory.

/// Processor time of the process so far [s].
#[cfg(unix)]
#[allow(clippy::unnecessary_wraps)] // not every system provides it
pub fn process_cpu_s() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

/// Processor time of the process so far [s].
#[cfg(not(unix))]
pub fn process_cpu_s() -> Option<f64> {
    None
}

/// Memory of the machine, or of the group of processes (cgroup) where that has less [bytes]; `None` where the system does not say.
pub fn usable_memory_bytes() -> Option<u64> {
    let machine = read("/proc/meminfo").as_deref().and_then(of_machine);
    let group = read("/sys/fs/cgroup/memory.max").and_then(|text| text.trim().parse().ok());
    [machine, group].into_iter().flatten().min()
}

/// Resident memory of this process [bytes]; `None` where the system does not say.
pub fn resident_memory_bytes() -> Option<u64> {
    read("/proc/self/status").as_deref().and_then(|text| kilobytes(text, "VmRSS:"))
}

/// The most that it was so far [bytes]; `None` where the system does not say.
pub fn peak_memory_bytes() -> Option<u64> {
    read("/proc/self/status").as_deref().and_then(|text| kilobytes(text, "VmHWM:"))
}

fn read(path: &str) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// `MemTotal` of `/proc/meminfo` [bytes].
fn of_machine(text: &str) -> Option<u64> {
    kilobytes(text, "MemTotal:")
}

/// Number of kilobytes after a name, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_that_of_the_machine() {
        assert_eq!(of_machine("MemTotal:       16315436 kB\nMemFree: 1 kB\n"), Some(16_315_436 * 1024));
        assert_eq!(of_machine("MemFree: 1 kB\n"), None);
    }
}
