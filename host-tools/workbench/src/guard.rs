//! Access control: requests may come from the page of this workbench and from programs of this computer. Requests of other
//! web pages in the same browser are refused, also if they come through a name that resolves to this computer.
//!
//! The checks, in this order: the host name is one of this computer (against DNS rebinding; 421); the browser does not report
//! another site (`Sec-Fetch-Site`, `Origin`; 403); a request that changes something is JSON, which a form cannot send (415),
//! and has the token that only the page knows (403). Where other computers have access, any host name is allowed, and
//! [`super::access`] requires a token that no other site has.

use super::problem::Problem;
use super::state::Shared;
use axum::extract::{Request, State};
use axum::http::header::{CONTENT_TYPE, HOST, HeaderMap, HeaderName, HeaderValue, ORIGIN};
use axum::http::{Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// Header with the token of [`super::session`].
pub(super) const TOKEN: &str = "x-softdock";

/// Names of this computer.
const NAMES: [&str; 3] = ["127.0.0.1", "localhost", "[::1]"];

/// Headers of all answers: no content from elsewhere, no embedding in frames, no guessing of types, no use by other sites.
const HEADERS: [(&str, &str); 5] = [
    (
        "content-security-policy",
        "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cache-control", "no-cache"),
];

/// Passes a request on if it is allowed, or answers it with the reason.
pub(super) async fn guard(State(bench): State<Shared>, request: Request, next: Next) -> Response {
    let (method, headers) = (request.method(), request.headers());
    let any_name = bench.reach.token().is_some();
    let mut response = match allowed(method, headers, any_name, bench.port, &bench.token) {
        Ok(()) => next.run(request).await,
        Err(problem) => problem.into_response(),
    };
    for (name, value) in HEADERS {
        let name = HeaderName::from_static(name);
        response
            .headers_mut()
            .entry(name)
            .or_insert(HeaderValue::from_static(value));
    }
    response
}

/// Passes a request with the access token on, or answers what is lacking.
pub(super) async fn admit(State(bench): State<Shared>, request: Request, next: Next) -> Response {
    match bench.reach.token() {
        Some(token) if token.is_sent(request.headers(), bench.port) => next.run(request).await,
        Some(token) if token.is_introduced(request.uri()) => token.redirect_with_cookie(bench.port),
        Some(_) => Problem::new(
            StatusCode::UNAUTHORIZED,
            "expected the token of `softdock workbench --token`: open the address that it printed, or send the header \
             `authorization: Bearer TOKEN`",
        )
        .into_response(),
        None => next.run(request).await,
    }
}

fn allowed(
    method: &Method,
    headers: &HeaderMap,
    any_name: bool,
    port: u16,
    token: &str,
) -> Result<(), Problem> {
    let text = |name: &str| headers.get(name).and_then(|value| value.to_str().ok());
    let host = text(HOST.as_str()).unwrap_or_default();
    // Browsers omit the default port of HTTP.
    let (name, at) = match host.rsplit_once(':') {
        Some((name, at)) if !at.ends_with(']') => (name, at.parse().ok()),
        _ => (host, Some(80)),
    };
    let own = NAMES.contains(&name) && at == Some(port);
    if !any_name && !own {
        return Err(Problem::new(
            StatusCode::MISDIRECTED_REQUEST,
            format!("this is not `{host}`; open http://{}:{port}", NAMES[0]),
        ));
    }
    let foreign = || Problem::new(StatusCode::FORBIDDEN, "another site may not ask this one");
    let site = headers.get("sec-fetch-site");
    if site.is_some_and(|site| site != "same-origin" && site != "none") {
        return Err(foreign());
    }
    let origin = headers.get(ORIGIN);
    if origin.is_some_and(|origin| *origin != *format!("http://{host}")) {
        return Err(foreign());
    }
    if matches!(*method, Method::GET | Method::HEAD) {
        return Ok(());
    }
    let kind = text(CONTENT_TYPE.as_str()).unwrap_or_default();
    let kind = kind.split(';').next().unwrap_or_default().trim();
    if !kind.eq_ignore_ascii_case("application/json") {
        return Err(Problem::new(
            StatusCode::UNSUPPORTED_MEDIA_TYPE,
            "expected `content-type: application/json`",
        ));
    }
    if text(TOKEN) != Some(token) {
        return Err(Problem::new(
            StatusCode::FORBIDDEN,
            format!("expected the header `{TOKEN}` with the `csrf` of GET /api/session"),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Status of a request to port 81 that is checked with the token `t`.
    fn status(method: Method, headers: &[(&'static str, &str)]) -> u16 {
        status_of(method, headers, false, 81)
    }

    fn status_of(
        method: Method,
        headers: &[(&'static str, &str)],
        any_name: bool,
        port: u16,
    ) -> u16 {
        let pairs = headers.iter().map(|(name, value)| {
            (
                HeaderName::from_static(name),
                value.parse::<HeaderValue>().unwrap(),
            )
        });
        let headers: HeaderMap = pairs.collect();
        allowed(&method, &headers, any_name, port, "t")
            .map_or_else(|p| p.into_response().status().as_u16(), |()| 200)
    }

    const JSON: (&str, &str) = ("content-type", "application/json");

    #[test]
    fn only_own_names_are_answered() {
        for host in ["127.0.0.1:81", "localhost:81", "[::1]:81"] {
            assert_eq!(status(Method::GET, &[("host", host)]), 200, "{host}");
        }
        for host in [
            "evil.example",
            "127.0.0.1",
            "127.0.0.1:82",
            "localhost.evil:81",
            "",
        ] {
            assert_eq!(status(Method::GET, &[("host", host)]), 421, "{host}");
        }
        assert_eq!(status(Method::GET, &[]), 421);
        for (host, port, expected) in [
            ("127.0.0.1", 80, 200),
            ("[::1]", 80, 200),
            ("localhost:80", 80, 200),
            ("localhost", 443, 421),
            ("evil.example", 80, 421),
        ] {
            let asked = status_of(Method::GET, &[("host", host)], false, port);
            assert_eq!(asked, expected, "{host} {port}");
        }
    }

    #[test]
    fn a_workbench_of_the_network_has_any_name_and_other_sites_are_refused_all_the_same() {
        let host = ("host", "laboratory:81");
        for (origin, expected) in [("http://laboratory:81", 200), ("http://evil.example", 403)] {
            let asked = status_of(Method::GET, &[host, ("origin", origin)], true, 81);
            assert_eq!(asked, expected, "{origin}");
        }
        assert_eq!(status_of(Method::POST, &[host, JSON], true, 81), 403);
    }

    #[test]
    fn other_sites_are_refused() {
        let host = ("host", "localhost:81");
        for (site, expected) in [
            ("same-origin", 200),
            ("none", 200),
            ("same-site", 403),
            ("cross-site", 403),
        ] {
            let asked = status(Method::GET, &[host, ("sec-fetch-site", site)]);
            assert_eq!(asked, expected, "{site}");
        }
        for (origin, expected) in [
            ("http://localhost:81", 200),
            ("https://localhost:81", 403),
            ("http://127.0.0.1:81", 403),
            ("http://evil.example", 403),
            ("null", 403),
        ] {
            let asked = status(Method::GET, &[host, ("origin", origin)]);
            assert_eq!(asked, expected, "{origin}");
        }
    }

    #[test]
    fn a_change_is_json_with_the_token() {
        let host = ("host", "localhost:81");
        let token = (TOKEN, "t");
        for method in [Method::POST, Method::DELETE, Method::PUT, Method::OPTIONS] {
            assert_eq!(status(method.clone(), &[host, JSON, token]), 200);
            assert_eq!(status(method.clone(), &[host, JSON]), 403);
            assert_eq!(status(method.clone(), &[host, JSON, (TOKEN, "u")]), 403);
            assert_eq!(status(method.clone(), &[host, token]), 415);
            let form = ("content-type", "application/x-www-form-urlencoded");
            assert_eq!(status(method.clone(), &[host, form, token]), 415);
            let text = ("content-type", "text/plain; application/json");
            assert_eq!(status(method, &[host, text, token]), 415);
        }
        let utf8 = ("content-type", "application/json; charset=utf-8");
        assert_eq!(status(Method::POST, &[host, utf8, token]), 200);
    }
}
