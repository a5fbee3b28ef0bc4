//! `contuse serve` as a process of its own.

use super::client::Client;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Arguments of a service, without its data folder.
pub const SERVE: [&str; 6] = ["serve", "--listen", "127.0.0.1:0", "--workers", "1", "--data"];

/// `contuse serve` as a process of its own, killed when it is dropped.
pub struct Program {
    pub child: Child,
    pub client: Client,
}

impl Program {
    pub fn start(data: &Path, flags: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_contuse"));
        command.args(SERVE).arg(data).args(flags);
        Self::spawn(command)
    }

    /// With a limit on the size of files, in blocks of 512 bytes: a write beyond it fails as on a full disk.
    pub fn limited(data: &Path, blocks: u32) -> Self {
        let mut command = Command::new("sh");
        let script = format!("ulimit -S -f {blocks}; exec \"$0\" \"$@\"");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_contuse")]).args(SERVE).arg(data);
        Self::spawn(command)
    }

    /// Most memory that it has had so far [bytes].
    pub fn peak_memory(&self) -> u64 {
        self.memory("VmHWM:")
    }

    /// Memory that it has now [bytes].
    pub fn resident_memory(&self) -> u64 {
        self.memory("VmRSS:")
    }

    fn memory(&self, name: &str) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap();
        line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() * 1024
    }

    /// Ids of the processes of its runs.
    pub fn runs(&self) -> Vec<u32> {
        let own = format!("PPid:\t{}\n", self.child.id());
        let is_run = |id: &u32| {
            let read = |file: &str| std::fs::read_to_string(format!("/proc/{id}/{file}")).unwrap_or_default();
            read("status").contains(&own) && read("cmdline").contains("job-process")
        };
        let entries = std::fs::read_dir("/proc").unwrap().flatten();
        entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).filter(is_run).collect()
    }

    pub fn spawn(mut command: Command) -> Self {
        if command.get_envs().all(|(name, _)| name != "RUST_LOG") {
            command.env("RUST_LOG", "error");
        }
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("listening on http://").unwrap_or_else(|| panic!("{line:?}"));
        let client = Client::new(address.parse().unwrap());
        Self { child, client }
    }

    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Sends it a signal, by its name.
    pub fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-s", name, &id]).status().unwrap().success());
    }

    pub fn terminate(self) -> ExitStatus {
        self.end_by("TERM")
    }

    /// Its exit status after a signal that ends it.
    pub fn end_by(mut self, name: &str) -> ExitStatus {
        self.signal(name);
        let limit = Instant::now() + Duration::from_secs(20);
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(Instant::now() < limit, "it does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
