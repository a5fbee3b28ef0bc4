//! What is closed unless the operator opens it: other machines, other names, pages of other origins, guesses.

use crate::support::client::{Answer, read_answer};
use crate::support::*;
use contuse::service::config::ServiceConfig;
use contuse::service::jobs::simulator::Simulator;
use contuse::service::tokens::{Scope, Tokens};
use contuse::service::{Service, ServiceError};
use std::io::BufReader;
use std::net::SocketAddr;
use std::process::Command;
use std::sync::Arc;

const ANNA: &str = "anna-0123456789abcdef";
const BERT: &str = "bert-0123456789abcdef";

fn start(listen: [u8; 4], tokens: Tokens) -> Result<(), ServiceError> {
    let data = tempfile::tempdir().unwrap();
    let config = ServiceConfig {
        listen: SocketAddr::from((listen, 0)),
        store: StoreAddress::in_folder(data.path()),
        tokens,
        ..ServiceConfig::default()
    };
    let engine = Arc::new(Simulator::new(&config.runs));
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let started = runtime.block_on(Service::start(config, engine)).map(drop);
    runtime.shutdown_background();
    started
}

#[test]
fn other_machines_need_tokens() {
    let refused = start([0, 0, 0, 0], Tokens::default()).unwrap_err().to_string();
    assert!(refused.contains("--tokens-file") && refused.contains("contuse token"), "{refused}");
}

/// The answer to a request with this head.
fn with_head(server: &Server, head: &str) -> Answer {
    let stream = server.client().raw(format!("{head}\r\nConnection: close\r\n\r\n").as_bytes());
    read_answer(&mut BufReader::new(stream), false)
}

#[test]
fn a_name_that_resolves_here_reads_nothing() {
    let server = Server::with(|c| c.hosts = vec!["impacts.example".into()]);
    let port = server.address.port();
    for host in
        ["evil.example".to_owned(), format!("evil.example:{port}"), format!("127.0.0.1.evil.example:{port}")]
    {
        for path in ["/v1/jobs", "/", "/metrics"] {
            let answer = with_head(&server, &format!("GET {path} HTTP/1.1\r\nHost: {host}"));
            assert!(problem(&answer, 421, "foreign-host")["remedy"].as_str().unwrap().contains("--host"));
        }
    }
    for host in ["localhost", "127.0.0.1", "[::1]:80", "impacts.example"] {
        assert_eq!(
            with_head(&server, &format!("GET /v1/jobs HTTP/1.1\r\nHost: {host}")).status,
            200,
            "{host}"
        );
    }
    // The name in the target replaces that of the header.
    let answer = with_head(&server, "GET http://evil.example/v1/jobs HTTP/1.1\r\nHost: localhost");
    problem(&answer, 421, "foreign-host");
    // With tokens, a name gives no access.
    let server = Server::with(|c| c.tokens = Tokens::parse(&format!("anna {ANNA}")).unwrap());
    let head = format!("GET /v1/jobs HTTP/1.1\r\nHost: impacts.example\r\nAuthorization: Bearer {ANNA}");
    assert_eq!(with_head(&server, &head).status, 200);
}

#[test]
fn pages_of_other_origins_read_nothing() {
    let server = Server::start();
    let foreign = [("Origin", "https://evil.example")];
    let answer = server.client().get_with("/v1/jobs", &foreign);
    problem(&answer, 403, "cross-origin");
    assert_eq!(answer.header("access-control-allow-origin"), None);
    let requested = [foreign[0], ("Access-Control-Request-Method", "GET")];
    let preflight = server.client().send("OPTIONS", "/v1/jobs", &requested, b"");
    assert_eq!(preflight.header("access-control-allow-origin"), None);
    let own = format!("http://{}", server.address);
    let answer = server.client().get_with("/v1/jobs", &[("Origin", &own)]);
    assert_eq!((answer.status, answer.header("cross-origin-resource-policy")), (200, Some("same-origin")));
}

#[test]
fn every_answer_has_a_content_security_policy() {
    let server = Server::start();
    let (job, _) = finished(&server.client(), &quick());
    for path in ["/", "/docs/", "/v1/jobs", &job, "/nothing", "/metrics", "/openapi.json", "/viewer/icon.svg"]
    {
        let answer = server.client().get(path);
        let policy = answer.header("content-security-policy").unwrap_or_else(|| panic!("{path}"));
        assert!(policy.starts_with("default-src 'none';") && !policy.contains("unsafe"), "{path}: {policy}");
    }
}

#[test]
fn wrong_tokens_have_to_wait_and_right_ones_do_not() {
    let line = Tokens::line("anna", ANNA, Scope::Submit, None);
    let server = Server::with(|c| c.tokens = Tokens::parse(&line).unwrap());
    let wrong = server.client().with_token("wrong-0123456789abcdef");
    for _ in 0..10 {
        problem(&wrong.get("/v1/jobs"), 401, "unauthorized");
    }
    let refused = wrong.get("/v1/jobs");
    problem(&refused, 429, "too-many-wrong-tokens");
    assert!((1..=60).contains(&refused.header("retry-after").unwrap().parse::<u64>().unwrap()));
    assert_eq!(server.client().with_token(ANNA).get("/v1/jobs").status, 200);
    problem(&server.client().get("/v1/jobs"), 401, "unauthorized");
}

#[test]
fn tokens_have_a_scope_and_a_last_day() {
    let lines = [
        Tokens::line("anna", ANNA, Scope::Submit, None),
        Tokens::line("anna", "anna-reads-456789abcdef", Scope::Read, None),
        Tokens::line("prometheus", "prometheus-0123456789", Scope::Metrics, None),
        Tokens::line("anna", "anna-before-0123456789", Scope::Submit, Some("2020-12-31")),
    ];
    let server = Server::with(|c| c.tokens = Tokens::parse(&lines.join("\n")).unwrap());
    let with = |token| server.client().with_token(token);
    let (job, _) = finished(&with(ANNA), &quick());
    let reader = with("anna-reads-456789abcdef");
    assert_eq!(reader.get(&job).status, 200);
    assert_eq!(reader.get("/metrics").status, 200);
    let refused = problem(&reader.post_json("/v1/jobs", &quick()), 403, "beyond-scope");
    assert!(refused["detail"].as_str().unwrap().contains("needs `submit`"), "{refused}");
    problem(&reader.delete(&job), 403, "beyond-scope");
    let scraper = with("prometheus-0123456789");
    assert_eq!(scraper.get("/metrics").status, 200);
    problem(&scraper.get("/v1/jobs"), 403, "beyond-scope");
    problem(&with("anna-before-0123456789").get("/v1/jobs"), 401, "expired-token");
}

#[test]
fn tokens_are_read_again_when_their_file_changes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tokens");
    let line = Tokens::line("anna", ANNA, Scope::Submit, None);
    std::fs::write(&file, &line).unwrap();
    let server = Server::with(|c| {
        c.tokens = Tokens::parse(&line).unwrap();
        c.tokens_file = Some(file.clone());
    });
    let status = |token| server.client().with_token(token).get("/v1/jobs").status;
    assert_eq!((status(ANNA), status(BERT)), (200, 401));
    std::fs::write(&file, format!("{}\n", Tokens::line("bert", BERT, Scope::Submit, None))).unwrap();
    eventually("the new token is known", || status(BERT) == 200);
    // Wrong tokens were tried meanwhile, perhaps too often.
    let is_refused = |token| [401, 429].contains(&status(token));
    assert!(is_refused(ANNA));
    // A file that is wrong, or gone, locks no one out and lets no one in.
    let wait = || std::thread::sleep(std::time::Duration::from_millis(1500));
    std::fs::write(&file, "bert").unwrap();
    wait();
    assert!(is_refused(ANNA) && status(BERT) == 200);
    // Nor does one whose end does not come: a pipe without a writer.
    std::fs::remove_file(&file).unwrap();
    assert!(Command::new("mkfifo").arg(&file).status().unwrap().success());
    wait();
    assert!(is_refused(ANNA) && status(BERT) == 200);
    std::fs::remove_file(&file).unwrap();
    std::fs::write(&file, &line).unwrap();
    eventually("a file is read again", || is_refused(BERT));
}
