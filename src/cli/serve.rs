//! `contuse serve`, `contuse openapi`, `contuse health`: the service and what belongs to it.

use crate::service::config::{Budget, ServiceConfig, Tokens};
use crate::service::jobs::simulator::Simulator;
use crate::service::{Service, http};
use anyhow::{Context, bail};
use clap::Args;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio::signal::unix::{SignalKind, signal};

/// Flags of `contuse serve`.
#[derive(Args, Clone, Debug)]
pub struct ServeArgs {
    /// Address to listen on; port 0 takes a free one. The address taken is printed on standard output.
    #[arg(long, env = "CONTUSE_LISTEN", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
    /// Folder of jobs, meshes and recordings.
    #[arg(long, env = "CONTUSE_DATA", default_value = "data")]
    data: PathBuf,
    /// Jobs that run at the same time [default: the number of cores]
    #[arg(long, env = "CONTUSE_WORKERS")]
    workers: Option<usize>,
    /// Threads of each run.
    #[arg(long, env = "CONTUSE_THREADS_PER_JOB", default_value_t = 1)]
    threads_per_job: usize,
    /// Largest scene document in bytes; k, M, G are understood.
    #[arg(long, env = "CONTUSE_MAX_BODY", default_value = "4M", value_parser = size)]
    max_body: u64,
    /// Largest mesh in bytes.
    #[arg(long, env = "CONTUSE_MAX_MESH", default_value = "256M", value_parser = size)]
    max_mesh: u64,
    /// Most elements of a scene.
    #[arg(long, env = "CONTUSE_MAX_ELEMENTS", default_value_t = 1_000_000)]
    max_elements: u64,
    /// Most time steps of a scene.
    #[arg(long, env = "CONTUSE_MAX_STEPS", default_value_t = 20_000_000)]
    max_steps: u64,
    /// Most memory of a run in bytes.
    #[arg(long, env = "CONTUSE_MAX_MEMORY", default_value = "4G", value_parser = size)]
    max_memory: u64,
    /// Most jobs that wait.
    #[arg(long, env = "CONTUSE_MAX_QUEUED", default_value_t = 1000)]
    max_queued: u64,
    /// Most connections at the same time.
    #[arg(long, env = "CONTUSE_MAX_CONNECTIONS", default_value_t = 512)]
    max_connections: usize,
    /// Wall-clock time that a job may run, in seconds.
    #[arg(long, env = "CONTUSE_DEADLINE_S", default_value_t = 3600)]
    deadline_s: u64,
    /// How long running jobs and open answers may go on after SIGTERM, in seconds; then jobs go back to the queue.
    #[arg(long, env = "CONTUSE_GRACE_S", default_value_t = 20)]
    grace_s: u64,
    /// File of bearer tokens, `name token` on each line; without it everybody may use the service.
    #[arg(long, env = "CONTUSE_TOKENS_FILE")]
    tokens_file: Option<PathBuf>,
    /// Origin of web pages that may start and stop jobs; may be given several times.
    #[arg(long = "cors-origin", env = "CONTUSE_CORS_ORIGINS", value_delimiter = ',')]
    cors_origins: Vec<String>,
}

impl ServeArgs {
    /// The configuration that the flags ask for.
    ///
    /// # Errors
    /// When the tokens cannot be read, or a number makes no sense.
    pub fn config(self) -> anyhow::Result<ServiceConfig> {
        let tokens = match &self.tokens_file {
            None => Tokens::default(),
            Some(file) => {
                let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
                let tokens = Tokens::parse(&text).with_context(|| file.display().to_string())?;
                if tokens.is_open() {
                    bail!("{} holds no token: nobody could use the service", file.display());
                }
                tokens
            }
        };
        let defaults = ServiceConfig::default();
        let workers = self.workers.unwrap_or(defaults.workers);
        if workers == 0 || self.threads_per_job == 0 || self.max_connections == 0 {
            bail!("--workers, --threads-per-job and --max-connections must be at least 1");
        }
        Ok(ServiceConfig {
            listen: self.listen,
            data: self.data,
            workers,
            threads_per_job: self.threads_per_job,
            max_scene_bytes: usize::try_from(self.max_body)?,
            max_mesh_bytes: self.max_mesh,
            max_queued: self.max_queued,
            max_connections: self.max_connections,
            deadline: Duration::from_secs(self.deadline_s),
            grace: Duration::from_secs(self.grace_s),
            budget: Budget {
                max_elements: self.max_elements,
                max_steps: self.max_steps,
                max_memory_bytes: self.max_memory,
            },
            tokens,
            cors_origins: self.cors_origins,
            ..defaults
        })
    }
}

/// Serves until SIGTERM or SIGINT; a second one hurries.
///
/// # Errors
/// When the service cannot start.
pub fn serve(args: ServeArgs) -> anyhow::Result<()> {
    let config = args.config()?;
    let engine = Arc::new(Simulator::new(config.budget));
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    runtime.block_on(async {
        let mut terminate = signal(SignalKind::terminate())?;
        let mut interrupt = signal(SignalKind::interrupt())?;
        let service = Service::start(config, engine).await?;
        announce(service.address())?;
        // Both futures wait for either signal: the first one stops, the second one hurries.
        let (stopped, mut hurried) = tokio::sync::watch::channel(0_u32);
        tokio::spawn(async move {
            loop {
                tokio::select! {
                    _ = terminate.recv() => {}
                    _ = interrupt.recv() => {}
                }
                stopped.send_modify(|count| *count += 1);
            }
        });
        let mut stop = hurried.clone();
        let stop = async move {
            let _ = stop.wait_for(|count| *count >= 1).await;
        };
        let hurry = async move {
            let _ = hurried.wait_for(|count| *count >= 2).await;
        };
        service.run_until(stop, hurry).await;
        anyhow::Ok(())
    })
}

/// Says on one line of standard output where the service listens: with port 0 nobody knows otherwise.
fn announce(address: SocketAddr) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "listening on http://{address}")?;
    out.flush()
}

/// Prints the OpenAPI document of the service.
///
/// # Errors
/// When standard output is closed.
pub fn print_openapi() -> anyhow::Result<()> {
    Ok(std::io::stdout().lock().write_all(http::openapi_text().as_bytes())?)
}

/// Flags of `contuse health`.
#[derive(Args, Clone, Debug)]
pub struct HealthArgs {
    /// Address of the service, host and port.
    #[arg(long, env = "CONTUSE_LISTEN", default_value = "127.0.0.1:8080")]
    address: String,
}

/// Asks a service whether it is ready. For containers that hold nothing but this binary.
///
/// # Errors
/// When it is not.
pub fn health(args: &HealthArgs) -> anyhow::Result<()> {
    let limit = Duration::from_secs(3);
    // A service that listens on every address is asked on its own.
    let address = args.address.replace("0.0.0.0:", "127.0.0.1:").replace("[::]:", "[::1]:");
    let socket = address.to_socket_addrs()?.next().context("the address names no host")?;
    let mut stream = TcpStream::connect_timeout(&socket, limit)?;
    stream.set_read_timeout(Some(limit))?;
    write!(stream, "GET /readyz HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n")?;
    let mut answer = String::new();
    stream.take(4096).read_to_string(&mut answer)?;
    let status = answer.lines().next().unwrap_or_default();
    if status.split(' ').nth(1) != Some("200") {
        bail!("not ready: {status}");
    }
    Ok(())
}

/// A number of bytes: `4096`, `64k`, `4M`, `2G` (powers of 1024).
fn size(text: &str) -> Result<u64, String> {
    let (digits, shift) = match text.as_bytes().last() {
        Some(b'k' | b'K') => (&text[..text.len() - 1], 10),
        Some(b'M') => (&text[..text.len() - 1], 20),
        Some(b'G') => (&text[..text.len() - 1], 30),
        _ => (text, 0),
    };
    let number: u64 = digits.parse().map_err(|_| format!("{text:?} is no number of bytes"))?;
    number.checked_mul(1 << shift).ok_or_else(|| format!("{text:?} is too large"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_suffixes() {
        assert_eq!(size("4096"), Ok(4096));
        assert_eq!(size("64k"), Ok(64 << 10));
        assert_eq!(size("4M"), Ok(4 << 20));
        assert_eq!(size("2G"), Ok(2 << 30));
        assert!(size("").is_err() && size("M").is_err() && size("1T").is_err() && size("99999999999G").is_err());
    }
}
