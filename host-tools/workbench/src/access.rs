//! The address on which the workbench listens, and access from other computers, which needs a token. A browser sends the
//! token once in the address and keeps it as a cookie; a program sends it with each request.

use axum::http::header::{AUTHORIZATION, COOKIE, HeaderMap, LOCATION, SET_COOKIE};
use axum::http::{StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::str::FromStr;

/// Smallest length of a token, characters: too many combinations to try over a network.
const SHORTEST: usize = 16;

/// The computers that can reach the workbench.
#[derive(Clone, Debug)]
pub enum Reach {
    /// This computer only.
    ThisComputer,
    /// Other computers too, on this address, with the token.
    Network(IpAddr, AccessToken),
}

impl Reach {
    pub(super) fn token(&self) -> Option<&AccessToken> {
        match self {
            Self::ThisComputer => None,
            Self::Network(_, token) => Some(token),
        }
    }

    /// Host in the URL for a browser. The unspecified address (all interfaces) cannot be opened, so it is replaced by the
    /// loopback address.
    pub(super) fn host(&self) -> IpAddr {
        match self {
            Self::Network(address, _) if !address.is_unspecified() => *address,
            Self::Network(IpAddr::V6(_), _) => Ipv6Addr::LOCALHOST.into(),
            Self::Network(IpAddr::V4(_), _) | Self::ThisComputer => Ipv4Addr::LOCALHOST.into(),
        }
    }
}

/// Secret that requests from other computers have to contain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AccessToken(String);

impl FromStr for AccessToken {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-._~".contains(c);
        if text.len() >= SHORTEST && text.chars().all(plain) {
            return Ok(Self(text.to_owned()));
        }
        Err(format!(
            "expected at least {SHORTEST} letters, digits or any of - . _ ~; `openssl rand -hex 16` makes one"
        ))
    }
}

impl AccessToken {
    /// Query of the page's URL with the token.
    pub(super) fn query(&self) -> String {
        format!("?token={}", self.0)
    }

    /// Compares in constant time.
    fn is(&self, other: &str) -> bool {
        let pairs = self.0.bytes().zip(other.bytes());
        self.0.len() == other.len() && pairs.fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
    }

    pub(super) fn is_sent(&self, headers: &HeaderMap, port: u16) -> bool {
        let texts = |name| {
            let all = headers.get_all(name).iter();
            all.filter_map(|value| value.to_str().ok())
        };
        let cookie = format!("{}=", cookie_name(port));
        let mut cookies = texts(COOKIE).flat_map(|text| text.split(';'));
        let mut bearers = texts(AUTHORIZATION).filter_map(|text| text.strip_prefix("Bearer "));
        cookies.any(|one| one.trim().strip_prefix(&cookie).is_some_and(|t| self.is(t)))
            || bearers.any(|one| self.is(one.trim()))
    }

    /// Whether the page is requested with the token in its address.
    pub(super) fn is_introduced(&self, asked: &Uri) -> bool {
        let mut pairs = asked.query().unwrap_or_default().split('&');
        asked.path() == "/"
            && pairs.any(|one| one.strip_prefix("token=").is_some_and(|t| self.is(t)))
    }

    /// A redirect that sets the cookie and removes the token from the address.
    pub(super) fn redirect_with_cookie(&self, port: u16) -> Response {
        let name = cookie_name(port);
        let cookie = format!("{name}={}; Path=/; HttpOnly; SameSite=Strict", self.0);
        (
            StatusCode::SEE_OTHER,
            [(LOCATION, "/".to_owned()), (SET_COOKIE, cookie)],
        )
            .into_response()
    }
}

/// Name of the cookie. It contains the port, as browsers share cookies among the ports of a computer.
fn cookie_name(port: u16) -> String {
    format!("softdock_{port}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOKEN: &str = "0123456789abcdef";

    fn token() -> AccessToken {
        TOKEN.parse().unwrap()
    }

    #[test]
    fn a_token_is_long_and_plain() {
        for refused in [
            "",
            "0123456789abcde",
            "0123456789abcdef;",
            "0123456789 abcdef",
        ] {
            assert!(refused.parse::<AccessToken>().is_err(), "{refused}");
        }
    }

    #[test]
    fn every_address_is_opened_at_this_computer() {
        for (listens, opened) in [
            ("0.0.0.0", "127.0.0.1"),
            ("::", "::1"),
            ("192.168.1.5", "192.168.1.5"),
        ] {
            let reach = Reach::Network(listens.parse().unwrap(), token());
            assert_eq!(reach.host().to_string(), opened);
        }
    }

    #[test]
    fn it_is_sent_as_cookie_or_as_bearer() {
        let sent = |name, value: &str| {
            let headers = HeaderMap::from_iter([(name, value.parse().unwrap())]);
            token().is_sent(&headers, 80)
        };
        assert!(sent(COOKIE, &format!("a=b; softdock_80={TOKEN}")));
        assert!(sent(AUTHORIZATION, &format!("Bearer {TOKEN}")));
        for (name, value) in [
            (COOKIE, format!("softdock_81={TOKEN}")),
            (COOKIE, format!("softdock_80={TOKEN}0")),
            (COOKIE, "softdock_80=".to_owned()),
            (AUTHORIZATION, TOKEN.to_owned()),
            (AUTHORIZATION, "Bearer 0123456789abcdee".to_owned()),
        ] {
            assert!(!sent(name, &value), "{value}");
        }
        assert!(!token().is_sent(&HeaderMap::new(), 80));
    }

    #[test]
    fn only_the_page_takes_it_from_its_address() {
        let introduced = |uri: String| token().is_introduced(&uri.parse().unwrap());
        assert!(introduced(format!("/?token={TOKEN}")));
        assert!(!introduced(format!("/api/session?token={TOKEN}")));
        assert!(!introduced("/?token=0123456789abcdee".to_owned()));
        assert!(!introduced("/".to_owned()));
    }
}
