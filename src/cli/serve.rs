//! `contuse serve`, `contuse openapi`, `contuse health`: the service and its tools.

use super::this_process::{give_memory_back, this_program};
use super::work_args::{WorkArgs, size};
use super::{CliError, Exit};
use crate::service::access::read_tokens;
use crate::service::config::ServiceConfig;
use crate::service::jobs::process::{Groups, ProcessEngine};
use crate::service::jobs::simulator::Simulator;
use crate::service::jobs::store::StoreAddress;
use crate::service::tokens::Tokens;
use crate::service::{Service, ServiceError, http};
use clap::Args;
use signal_hook::consts::{SIGALRM, SIGUSR1, SIGUSR2, SIGXFSZ};
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;

/// Largest age in days, a hundred years: databases have dates that far back.
const MOST_DAYS: i64 = 36_500;
/// Least size of the audit log [bytes]: that of some full files.
const LEAST_AUDIT: u64 = 1 << 30;

/// Flags of `contuse serve`.
#[derive(Args, Clone, Debug)]
pub struct ServeArgs {
    /// Address to listen on; port 0 selects a free one. The actual address is printed on standard output.
    #[arg(long, env = "CONTUSE_LISTEN", default_value = "127.0.0.1:8080", value_parser = address)]
    listen: SocketAddr,
    /// Where the service stores its data, and how it runs jobs.
    #[command(flatten)]
    pub(super) work: WorkArgs,
    /// Maximum number of waiting jobs.
    #[arg(long, env = "CONTUSE_MAX_QUEUED", default_value_t = 1000)]
    max_queued: u64,
    /// Maximum number of waiting jobs of each owner [default: with tokens a quarter of all]
    #[arg(long, env = "CONTUSE_MAX_QUEUED_PER_OWNER")]
    max_queued_per_owner: Option<u64>,
    /// Maximum number of jobs that each owner keeps, in whatever state [default: no limit]
    #[arg(long, env = "CONTUSE_MAX_JOBS_PER_OWNER")]
    max_jobs_per_owner: Option<u64>,
    /// Maximum size in bytes of what jobs and meshes of each owner keep; suffixes k, M, G are accepted [default: no limit]
    #[arg(long, env = "CONTUSE_MAX_BYTES_PER_OWNER", value_parser = size)]
    max_bytes_per_owner: Option<u64>,
    /// Maximum size of the audit log in bytes, at least 1G; beyond it the oldest of its full files, of 256 MB, is removed.
    #[arg(long, env = "CONTUSE_MAX_AUDIT", default_value = "10G", value_parser = size)]
    max_audit: u64,
    /// Maximum number of requests per second of each owner of a token; those of ten seconds may be saved up.
    #[arg(long, env = "CONTUSE_MAX_REQUESTS_PER_S", default_value_t = 100)]
    max_requests_per_s: u32,
    /// Maximum number of simultaneous connections.
    #[arg(long, env = "CONTUSE_MAX_CONNECTIONS", default_value_t = 512)]
    max_connections: usize,
    /// Maximum number of waiting validations of small scenes, and of large ones.
    #[arg(long, env = "CONTUSE_MAX_VALIDATIONS_WAITING", default_value_t = 64)]
    max_validations_waiting: usize,
    /// Days after which jobs that have ended, with their recordings, and meshes are deleted [default: never]
    #[arg(long, env = "CONTUSE_KEEP_DAYS", value_parser = clap::value_parser!(u32).range(..=MOST_DAYS))]
    keep_days: Option<u32>,
    /// File of bearer tokens, `name sha256:digest` on each line (`contuse token` makes them), reloaded when it changes; without it,
    /// everyone on this machine has access, and no one else.
    #[arg(long, env = "CONTUSE_TOKENS_FILE")]
    tokens_file: Option<PathBuf>,
    /// Additional host name of a service without tokens, besides localhost; may be given several times.
    #[arg(long = "host", env = "CONTUSE_HOSTS", value_delimiter = ',')]
    hosts: Vec<String>,
    /// Origin of other web pages that may use the service; may be given several times.
    #[arg(long = "cors-origin", env = "CONTUSE_CORS_ORIGINS", value_delimiter = ',')]
    cors_origins: Vec<String>,
}

impl ServeArgs {
    /// Configuration from the flags.
    ///
    /// # Errors
    /// If the tokens cannot be read, or a number is invalid.
    pub fn config(self) -> Result<ServiceConfig, CliError> {
        let tokens = self.tokens_file.as_deref().map_or(Ok(Tokens::default()), tokens_of)?;
        if self.work.workers == Some(0) && !self.work.store.is_shared() {
            return Err(CliError::Usage(
                "--workers 0 needs a --database, whose jobs `contuse worker` runs".into(),
            ));
        }
        if self.max_connections == 0 {
            return Err(CliError::Usage("--max-connections must be at least 1".into()));
        }
        if self.max_audit < LEAST_AUDIT {
            return Err(CliError::Usage("--max-audit must be at least 1G".into()));
        }
        Ok(ServiceConfig {
            listen: self.listen,
            max_queued: self.max_queued,
            max_queued_per_owner: self.max_queued_per_owner,
            max_jobs_per_owner: self.max_jobs_per_owner,
            max_bytes_per_owner: self.max_bytes_per_owner,
            max_audit_bytes: self.max_audit,
            max_requests_per_s: self.max_requests_per_s,
            max_connections: self.max_connections,
            max_validations_waiting: self.max_validations_waiting.max(1),
            keep_days: self.keep_days,
            tokens,
            tokens_file: self.tokens_file,
            cors_origins: self.cors_origins,
            hosts: self.hosts,
            ..self.work.config()?
        })
    }
}

/// Reads the tokens of a file.
fn tokens_of(file: &Path) -> Result<Tokens, CliError> {
    let tokens = read_tokens(file).map_err(|e| CliError::Usage(format!("{}: {e}", file.display())))?;
    if tokens.in_clear() > 0 {
        let count = tokens.in_clear();
        tracing::warn!(
            file = %file.display(), count,
            "tokens stand in the file themselves: replace them by digests, which `contuse token NAME` prints"
        );
    }
    Ok(tokens)
}

/// Serves until SIGTERM, SIGINT or SIGHUP; a second signal shortens the shutdown.
///
/// # Errors
/// If the service cannot start.
pub fn serve(args: ServeArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    give_memory_back();
    let config = args.config()?;
    let (engine, runtime) = prepare(&config)?;
    let served = runtime.block_on(async {
        let signals = count_signals()?;
        let service = Service::start(config, engine).await.map_err(not_started)?;
        // With port 0 this is the only way to learn the address.
        writeln!(out, "listening on http://{}", service.address())?;
        out.flush()?;
        service.run_until(signalled(signals.clone(), 1), signalled(signals, 2)).await;
        Ok(Exit::Success)
    });
    // Threads still running end with the process.
    runtime.shutdown_background();
    served
}

/// Prepares this process to run jobs: its engine, and the runtime of its tasks.
pub(super) fn prepare(
    config: &ServiceConfig,
) -> Result<(Arc<ProcessEngine>, tokio::runtime::Runtime), CliError> {
    keep_files_private();
    // A file that grows beyond a limit of the process is an error of its write, not the end of the process. The others mean nothing.
    for without_effect in [SIGXFSZ, SIGUSR1, SIGUSR2, SIGALRM] {
        signal_hook::flag::register(without_effect, Arc::default())?;
    }
    take_descriptors(config);
    let groups = config.cgroup.as_deref().map(|folder| {
        let unusable = |error| CliError::Usage(format!("--cgroup {}: {error}", folder.display()));
        Groups::open(folder).map_err(unusable)
    });
    let engine = Arc::new(ProcessEngine::new(&config.runs, &this_program()?, groups.transpose()?));
    Ok((engine, tokio::runtime::Builder::new_multi_thread().enable_all().build()?))
}

/// Descriptors of a service beside those of its connections and runs: stores, logs, requests that are being answered.
const OWN_DESCRIPTORS: usize = 84;
/// Descriptors that a run takes.
const DESCRIPTORS_OF_RUN: usize = 3;

/// Takes as many descriptors as the system gives to this process, and says so if they are fewer than the connections and runs may need.
#[cfg(unix)]
fn take_descriptors(config: &ServiceConfig) {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let most = getrlimit(Resource::Nofile).maximum;
    let all = Rlimit { current: most, maximum: most };
    if let Err(error) = setrlimit(Resource::Nofile, all) {
        tracing::debug!(%error, "the limit of open files stays");
    }
    let needed = config.max_connections + DESCRIPTORS_OF_RUN * config.workers + OWN_DESCRIPTORS;
    if let Some(most) = most
        && most < needed as u64
    {
        tracing::warn!(
            most,
            needed,
            "fewer files may be open than all connections (--max-connections) and runs need: raise the limit (ulimit -n)"
        );
    }
}

#[cfg(not(unix))]
fn take_descriptors(_: &ServiceConfig) {}

/// Files and folders made from now on are for the user of this process alone.
pub(super) fn keep_files_private() {
    #[cfg(unix)]
    rustix::process::umask(rustix::fs::Mode::RWXG | rustix::fs::Mode::RWXO);
}

/// Flags of `contuse purge`.
#[derive(Args, Clone, Debug)]
pub struct PurgeArgs {
    /// Where the service, which is not running, stores its data.
    #[command(flatten)]
    store: StoreAddress,
    /// Minimum age in days of what is deleted: jobs since their end, meshes since their upload; 0 for all.
    #[arg(long, value_parser = clap::value_parser!(u32).range(..=MOST_DAYS))]
    older_than_days: u32,
}

/// Deletes old jobs, with all that they left, and old meshes.
///
/// # Errors
/// If the folder does not exist, is in use or cannot be used.
pub fn purge(args: &PurgeArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let store = &args.store;
    if !store.exists() {
        let message =
            format!("{} is not the data folder of a service: it has no {store}", store.data.display());
        return Err(CliError::Usage(message));
    }
    keep_files_private();
    let config = ServiceConfig { store: store.clone(), ..ServiceConfig::default() };
    let engine = Arc::new(Simulator::new(&config.runs));
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let purged = runtime.block_on(crate::service::purge(config, engine, args.older_than_days));
    let purged = purged.map_err(|error| {
        let text = CliError::Other(Box::new(error)).in_full();
        let remedy = if text.contains("in use") {
            "; the service that uses it deletes what is old by itself with --keep-days"
        } else {
            ""
        };
        CliError::Other(format!("{text}{remedy}").into())
    })?;
    writeln!(out, "deleted {} job(s) and {} mesh(es)", purged.jobs, purged.meshes)?;
    if purged.unreadable > 0 {
        writeln!(out, "{} more cannot be read: `contuse doctor` lists what is damaged", purged.unreadable)?;
    }
    Ok(Exit::Success)
}

/// Why the service did not start, with a remedy if the address is the cause.
fn not_started(error: ServiceError) -> CliError {
    let text = CliError::Other(Box::new(error)).in_full();
    let remedy = if text.contains("cannot listen") {
        "; choose another address with --listen, such as 127.0.0.1:8081, or port 0 for a free one"
    } else {
        ""
    };
    CliError::Other(format!("{text}{remedy}").into())
}

/// Whether SIGHUP was to be ignored when this process began, as under `nohup`.
fn ignores_hangup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 == 1)
}

/// Counts SIGTERM, SIGINT and SIGHUP from now on.
pub(super) fn count_signals() -> io::Result<watch::Receiver<u32>> {
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut hangup = if ignores_hangup() { None } else { Some(signal(SignalKind::hangup())?) };
    let (count, counted) = watch::channel(0);
    tokio::spawn(async move {
        loop {
            tokio::select! {
                _ = terminate.recv() => {}
                _ = interrupt.recv() => {}
                Some(()) = async { hangup.as_mut()?.recv().await } => {}
            }
            count.send_modify(|n| *n += 1);
        }
    });
    Ok(counted)
}

/// Waits for the `n`th signal.
pub(super) async fn signalled(mut count: watch::Receiver<u32>, n: u32) {
    // The counter lives as long as the runtime.
    let _ = count.wait_for(|counted| *counted >= n).await;
}

/// Prints the OpenAPI document of the service.
///
/// # Errors
/// If it cannot be written.
pub fn print_openapi(out: &mut dyn Write) -> Result<Exit, CliError> {
    out.write_all(http::openapi_text().as_bytes())?;
    Ok(Exit::Success)
}

/// Flags of `contuse health`.
#[derive(Args, Clone, Debug)]
pub struct HealthArgs {
    /// Address of the service, host and port.
    #[arg(long, env = "CONTUSE_LISTEN", default_value = "127.0.0.1:8080")]
    address: String,
}

/// Queries whether a service is ready, for containers that contain only this binary.
///
/// # Errors
/// If it is not ready.
pub fn health(args: &HealthArgs) -> Result<Exit, CliError> {
    // A service that listens on all addresses is queried on the local one.
    let address = args.address.replace("0.0.0.0:", "127.0.0.1:").replace("[::]:", "[::1]:");
    let status =
        ask(&address).map_err(|e| CliError::Other(format!("{address} does not answer: {e}").into()))?;
    if status.split(' ').nth(1) == Some("200") {
        Ok(Exit::Success)
    } else {
        Err(CliError::Other(format!("{address} is not ready: {status}").into()))
    }
}

/// Requests the status line of `/readyz`.
fn ask(address: &str) -> io::Result<String> {
    let limit = Duration::from_secs(3);
    let socket = address.to_socket_addrs()?.next().ok_or(io::ErrorKind::NotFound)?;
    let mut stream = TcpStream::connect_timeout(&socket, limit)?;
    stream.set_read_timeout(Some(limit))?;
    write!(stream, "GET /readyz HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n")?;
    let mut answer = String::new();
    stream.take(4096).read_to_string(&mut answer)?;
    Ok(answer.lines().next().unwrap_or_default().to_owned())
}

/// Parses an address with its port; host names are resolved.
fn address(text: &str) -> Result<SocketAddr, String> {
    let found = text.to_socket_addrs().ok().and_then(|mut all| all.next());
    found.ok_or_else(|| "give host and port, such as 127.0.0.1:8080 or localhost:8080".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser as _;

    fn refusal(arguments: &[&str]) -> String {
        let arguments = ["contuse", "serve"].iter().chain(arguments);
        crate::cli::Cli::try_parse_from(arguments).unwrap_err().to_string()
    }

    #[test]
    fn ages_have_a_limit_that_is_named() {
        let error = refusal(&["--keep-days", "36501"]);
        assert!(error.contains("--keep-days") && error.contains("36500"), "{error}");
    }

    #[test]
    fn a_database_and_an_object_store_come_together() {
        let (database, blobs) = (["--database", "postgres://u:secret@h/n"], ["--blobs", "s3://b/p"]);
        for (alone, missing) in [(database, "--blobs"), (blobs, "--database")] {
            let error = refusal(&alone);
            assert!(error.contains(missing) && !error.contains("secret"), "{error}");
        }
        let error = refusal(&["--database", "mysql://u:secret@h/n", "--blobs", "s3://b/p"]);
        assert!(
            error.contains("`mysql`") && error.contains("postgres://") && !error.contains("secret"),
            "{error}"
        );
    }

    #[test]
    fn an_address_has_a_port() {
        assert_eq!(address("127.0.0.1:0").map(|a| a.port()), Ok(0));
        assert!(address("localhost").unwrap_err().contains("localhost:8080"));
    }
}
