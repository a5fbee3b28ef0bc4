//! The log, on standard error. That of a service is written by a thread of its own, from a queue: a reader that stops reading holds up no
//! one else. Lines for which the queue has no room are dropped and counted.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tracing_subscriber::fmt::MakeWriter;

/// Most that waits to be written [bytes].
const MOST_WAITING: usize = 4 << 20;
/// How long the end of the process waits for a reader.
const LAST_WAIT: Duration = Duration::from_secs(3);

/// Where lines of the log, and last words, are written.
#[derive(Clone, Debug)]
pub struct Log(Option<Arc<Queue>>);

#[derive(Debug, Default)]
struct Queue {
    lines: Mutex<Lines>,
    /// There is a line to write.
    arrived: Condvar,
    /// Everything has been written.
    written: Condvar,
}

#[derive(Debug, Default)]
struct Lines {
    waiting: VecDeque<Vec<u8>>,
    /// Size of those that wait [bytes].
    bytes: usize,
    is_writing: bool,
    /// Number of lines that were dropped so far.
    dropped: u64,
}

impl Log {
    /// A log whose writers wait for its reader.
    pub fn direct() -> Self {
        Self(None)
    }

    /// A log whose writers wait for no one. Panics become lines of it.
    ///
    /// # Errors
    /// If the system provides no thread.
    pub fn queued() -> io::Result<Self> {
        let log = Self::queued_for(io::stderr())?;
        std::panic::set_hook(Box::new(|panic| {
            let backtrace = std::backtrace::Backtrace::capture();
            let is_captured = backtrace.status() == std::backtrace::BacktraceStatus::Captured;
            let backtrace = is_captured.then(|| tracing::field::display(backtrace));
            tracing::error!(backtrace, "{panic}");
        }));
        Ok(log)
    }

    fn queued_for(reader: impl Write + Send + 'static) -> io::Result<Self> {
        let queue = Arc::new(Queue::default());
        let lines = Arc::clone(&queue);
        std::thread::Builder::new().name("log".into()).spawn(move || lines.write_to(reader))?;
        Ok(Self(Some(queue)))
    }

    /// Waits until everything is written, but not for a reader that does not read.
    pub fn finish(&self) {
        if let Some(queue) = &self.0 {
            let is_under_way = |lines: &mut Lines| lines.is_writing || !lines.waiting.is_empty();
            // What is not written by then is lost.
            let _ = queue.written.wait_timeout_while(queue.lock(), LAST_WAIT, is_under_way);
        }
    }
}

impl Write for Log {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        match &self.0 {
            Some(queue) => queue.push(line),
            None => io::stderr().write_all(line)?,
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl MakeWriter<'_> for Log {
    type Writer = Self;

    fn make_writer(&self) -> Self {
        self.clone()
    }
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, Lines> {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, line: &[u8]) {
        let mut lines = self.lock();
        if lines.bytes + line.len() > MOST_WAITING {
            lines.dropped += 1;
            return;
        }
        lines.bytes += line.len();
        lines.waiting.push_back(line.to_vec());
        self.arrived.notify_one();
    }

    /// Writes the lines as they come, for as long as the process lives.
    fn write_to(&self, mut reader: impl Write) {
        let mut reported = 0;
        loop {
            let (line, dropped) = self.next();
            // There is nowhere to report that no one can read the log.
            let _ = reader.write_all(&line);
            if dropped != reported {
                reported = dropped;
                tracing::warn!(dropped, "lines are missing in the log: it was not read fast enough");
            }
        }
    }

    /// The next line, and the number of those dropped so far.
    fn next(&self) -> (Vec<u8>, u64) {
        let mut lines = self.lock();
        loop {
            if let Some(line) = lines.waiting.pop_front() {
                lines.bytes -= line.len();
                lines.is_writing = true;
                return (line, lines.dropped);
            }
            lines.is_writing = false;
            self.written.notify_all();
            lines = self.arrived.wait(lines).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

    /// A reader that takes one write each time it is allowed to.
    struct Reader {
        allowed: Receiver<()>,
        taken: SyncSender<Vec<u8>>,
    }

    impl Write for Reader {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let _ = self.allowed.recv();
            let _ = self.taken.send(bytes.to_vec());
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_stops_holds_up_no_one_and_learns_what_is_missing() {
        let ((allow, allowed), (taken, read)) = (sync_channel(64), sync_channel(64));
        let log = Log::queued_for(Reader { allowed, taken }).unwrap();
        let line = vec![b'a'; MOST_WAITING / 8];
        for _ in 0..20 {
            log.make_writer().write_all(&line).unwrap();
        }
        log.finish();
        let queue = log.0.as_ref().unwrap();
        // Eight wait, and one is being written, if the thread took it in time.
        let kept = 20 - queue.lock().dropped;
        assert!((8..=9).contains(&kept), "{kept}");
        for _ in 0..kept {
            allow.send(()).unwrap();
            assert_eq!(read.recv().unwrap(), line);
        }
        let mut words = log.clone();
        writeln!(words, "the end").unwrap();
        allow.send(()).unwrap();
        allow.send(()).unwrap();
        assert_eq!(read.recv().unwrap(), b"the end\n");
        log.finish();
        assert!(!queue.lock().is_writing);
    }
}
