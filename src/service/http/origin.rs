//! Names of the service, and pages that may use it.
//!
//! A page on another site can send requests from the browser of someone who may reach the service. If it may read the answers, it
//! is by a name of its own that resolves to the address of the service (DNS rebinding), or because the service allows its origin.
//! So a service without tokens answers to its own names only, and every service refuses pages of other origins.

use axum::http::{HeaderMap, header};
use std::net::IpAddr;

/// Whether a service that requires no token answers to the name in the header `Host`: `localhost`, an address of this machine,
/// or one of `names`. A request without the header comes from no browser.
pub(super) fn is_own_host(headers: &HeaderMap, names: &[String]) -> bool {
    let mut all = headers.get_all(header::HOST).iter();
    let Some(value) = all.next() else { return true };
    let Ok(text) = value.to_str() else { return false };
    let name = without_port(text);
    let is_loopback = || name.trim_matches(['[', ']']).parse().is_ok_and(|ip: IpAddr| ip.is_loopback());
    let is_listed = || names.iter().any(|known| known.eq_ignore_ascii_case(name));
    all.next().is_none() && (name.eq_ignore_ascii_case("localhost") || is_loopback() || is_listed())
}

/// The name in `name:port` or `[address]:port`.
fn without_port(text: &str) -> &str {
    match text.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) && !name.ends_with(':') => {
            if name.contains(':') && !name.ends_with(']') { text } else { name }
        }
        _ => text,
    }
}

/// Whether a request comes from no page, from a page of this service, or from one of an allowed origin.
pub(super) fn is_own_page(headers: &HeaderMap, origins: &[String]) -> bool {
    let Some(origin) = headers.get(header::ORIGIN) else { return true };
    let Ok(origin) = origin.to_str() else { return false };
    let host = headers.get(header::HOST).and_then(|h| h.to_str().ok());
    let is_same = origin.split_once("://").is_some_and(|(_, authority)| Some(authority) == host);
    is_same || origins.iter().any(|o| o == origin)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, host.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, origin.parse().unwrap());
        }
        headers
    }

    #[test]
    fn pages_of_other_origins_are_no_own_pages() {
        let listed = ["https://viewer.example".to_owned()];
        let of = |origin| headers("127.0.0.1:8080", origin);
        assert!(is_own_page(&of(None), &[]));
        assert!(is_own_page(&of(Some("http://127.0.0.1:8080")), &[]));
        assert!(!is_own_page(&of(Some("http://127.0.0.1:8081")), &[]));
        assert!(!is_own_page(&of(Some("https://evil.example")), &listed));
        assert!(!is_own_page(&of(Some("null")), &[]));
        assert!(is_own_page(&of(Some("https://viewer.example")), &listed));
    }

    #[test]
    fn names_that_resolve_here_are_no_own_names() {
        let names = ["impacts.example".to_owned()];
        for own in [
            "localhost",
            "LOCALHOST:8080",
            "127.0.0.1:1",
            "127.8.8.8",
            "[::1]",
            "[::1]:80",
            "impacts.example:8080",
        ] {
            assert!(is_own_host(&headers(own, None), &names), "{own}");
        }
        for other in [
            "evil.example",
            "evil.example:8080",
            "127.0.0.1.evil.example",
            "localhost.evil.example",
            "10.0.0.1",
            "",
        ] {
            assert!(!is_own_host(&headers(other, None), &names), "{other}");
        }
        assert!(is_own_host(&HeaderMap::new(), &[]));
        let mut twice = headers("localhost", None);
        twice.append(header::HOST, "evil.example".parse().unwrap());
        assert!(!is_own_host(&twice, &[]));
    }
}
