//! The pipe to the process of a run, which may stop reading it.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::ioctl_fionbio;
use std::io::{self, Write};
use std::process::ChildStdin;
use std::time::Duration;

/// The input of a process. A write fails as timed out if the process takes no byte for some time; nothing is written after that.
#[derive(Debug)]
pub(super) struct Pipe {
    /// Closed after a failure.
    input: Option<ChildStdin>,
    patience: Duration,
}

impl Pipe {
    /// A pipe to a process that may take nothing for so long.
    pub fn new(input: ChildStdin, patience: Duration) -> io::Result<Self> {
        ioctl_fionbio(&input, true)?;
        Ok(Self { input: Some(input), patience })
    }
}

impl Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let Some(input) = &mut self.input else { return Err(io::ErrorKind::BrokenPipe.into()) };
        let written = loop {
            match input.write(bytes) {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    if let Err(error) = wait(input, self.patience) {
                        break Err(error);
                    }
                }
                written => break written,
            }
        };
        written.inspect_err(|error| {
            if error.kind() != io::ErrorKind::Interrupted {
                self.input = None;
            }
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Waits until a process takes bytes, or has ended.
fn wait(input: &ChildStdin, patience: Duration) -> io::Result<()> {
    let patience = Timespec::try_from(patience).map_err(io::Error::other)?;
    match poll(&mut [PollFd::new(input, PollFlags::OUT)], Some(&patience))? {
        0 => Err(io::ErrorKind::TimedOut.into()),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Command, Stdio};
    use std::time::Instant;

    /// A process that does what a script says, and the pipe to it.
    fn process(script: &str, patience: Duration) -> (std::process::Child, Pipe) {
        let mut command = Command::new("sh");
        let mut process =
            command.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let pipe = Pipe::new(process.stdin.take().unwrap(), patience).unwrap();
        (process, pipe)
    }

    #[test]
    fn a_process_that_reads_slowly_has_everything() {
        let (process, mut pipe) = process("sleep 0.3; wc -c", Duration::from_secs(60));
        pipe.write_all(&vec![7; 1_000_000]).unwrap();
        drop(pipe);
        assert_eq!(process.wait_with_output().unwrap().stdout.trim_ascii(), b"1000000");
    }

    #[test]
    fn a_process_that_does_not_read_is_waited_for_once() {
        let (mut process, mut pipe) = process("exec sleep 600", Duration::from_millis(300));
        let begun = Instant::now();
        assert_eq!(pipe.write_all(&vec![7; 1_000_000]).unwrap_err().kind(), io::ErrorKind::TimedOut);
        assert_eq!(pipe.write_all(b"7").unwrap_err().kind(), io::ErrorKind::BrokenPipe);
        assert!(begun.elapsed() < Duration::from_secs(30), "{:?}", begun.elapsed());
        process.kill().unwrap();
        process.wait().unwrap();
    }
}
