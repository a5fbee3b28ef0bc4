//! Names of the service, and pages that may use it.
//!
//! A page on another site can send requests from the browser of someone who may reach the service. If it may read the answers, it
//! is by a name of its own that resolves to the address of the service (DNS rebinding), or because the service allows its origin.
//! So a service without tokens answers to its own names only, and every service refuses pages of other origins.

use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, Uri, header};
use std::net::IpAddr;

/// Whether a service that requires no token answers to the name in the header `Host`, and to that in the target, which replaces it
/// where it has one (RFC 9112, 3.2.2): `localhost`, an address of this machine, or one of `names`. A request without the header comes
/// from no browser.
pub(super) fn is_own_host(target: &Uri, headers: &HeaderMap, names: &[String]) -> bool {
    let mut all = headers.get_all(header::HOST).iter();
    let host = all.next().map(HeaderValue::to_str);
    let of_target = target.authority().map(|authority| Ok(authority.as_str()));
    all.next().is_none() && host.into_iter().chain(of_target).all(|text| text.is_ok_and(|t| is_own(t, names)))
}

/// Whether a name, perhaps with a port, is one of the service.
fn is_own(text: &str, names: &[String]) -> bool {
    let name = without_port(text);
    let is_loopback = || name.trim_matches(['[', ']']).parse().is_ok_and(|ip: IpAddr| ip.is_loopback());
    let is_listed = || names.iter().any(|known| known.eq_ignore_ascii_case(name));
    name.eq_ignore_ascii_case("localhost") || is_loopback() || is_listed()
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
pub(super) fn is_own_page(target: &Uri, headers: &HeaderMap, origins: &[String]) -> bool {
    let host = || headers.get(header::HOST).and_then(|host| host.to_str().ok());
    let name = target.authority().map(Authority::as_str).or_else(host);
    headers.get_all(header::ORIGIN).iter().all(|origin| {
        let Ok(origin) = origin.to_str() else { return false };
        let is_same = origin.split_once("://").is_some_and(|(_, authority)| Some(authority) == name);
        is_same || origins.iter().any(|o| o == origin)
    })
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

    fn path() -> Uri {
        Uri::from_static("/v1/jobs")
    }

    #[test]
    fn pages_of_other_origins_are_no_own_pages() {
        let listed = ["https://viewer.example".to_owned()];
        let of = |origin| headers("127.0.0.1:8080", origin);
        assert!(is_own_page(&path(), &of(None), &[]));
        assert!(is_own_page(&path(), &of(Some("http://127.0.0.1:8080")), &[]));
        assert!(!is_own_page(&path(), &of(Some("http://127.0.0.1:8081")), &[]));
        assert!(!is_own_page(&path(), &of(Some("https://evil.example")), &listed));
        assert!(!is_own_page(&path(), &of(Some("null")), &[]));
        let mut several = of(Some("https://viewer.example"));
        assert!(is_own_page(&path(), &several, &listed));
        several.append(header::ORIGIN, "https://evil.example".parse().unwrap());
        assert!(!is_own_page(&path(), &several, &listed));
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
            assert!(is_own_host(&path(), &headers(own, None), &names), "{own}");
        }
        for other in [
            "evil.example",
            "evil.example:8080",
            "127.0.0.1.evil.example",
            "localhost.evil.example",
            "10.0.0.1",
            "",
        ] {
            assert!(!is_own_host(&path(), &headers(other, None), &names), "{other}");
        }
        assert!(is_own_host(&path(), &HeaderMap::new(), &[]));
        let [own, evil] = ["http://localhost/v1/jobs", "http://evil.example/v1/jobs"].map(Uri::from_static);
        assert!(is_own_host(&own, &headers("localhost", None), &[]));
        assert!(!is_own_host(&own, &headers("evil.example", None), &[]));
        assert!(
            !is_own_host(&evil, &headers("localhost", None), &[])
                && !is_own_host(&evil, &HeaderMap::new(), &[])
        );
        let mut twice = headers("localhost", None);
        twice.append(header::HOST, "evil.example".parse().unwrap());
        assert!(!is_own_host(&path(), &twice, &[]));
    }
}
