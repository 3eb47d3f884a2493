//! Who may come in: one browser of this machine, which showed the token of the address once. Everything else that
//! runs in that browser, or can make it send requests, stays outside.

use std::fmt::Write;
use std::sync::atomic::{AtomicBool, Ordering};

use axum::extract::{Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, COOKIE, HOST, HeaderName, LOCATION, ORIGIN,
    REFERRER_POLICY, SET_COOKIE, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use rand::rand_core::TryRng;
use rand::rngs::SysRng;

use super::Shared;
use super::listen::Guest;
use super::reply;
use crate::error::{Error, Result};

/// Nothing from elsewhere, no script or style in the markup, nobody's frame.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
                      connect-src 'self'; form-action 'none'; frame-ancestors 'none'; base-uri 'none'";
const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// The way in.
pub(in crate::workbench) struct Door {
    port: u16,
    /// Good for one exchange.
    token: String,
    used: AtomicBool,
    /// Value of the cookie.
    key: String,
}

impl Door {
    /// With a fresh token from the system's random numbers.
    ///
    /// # Errors
    /// When the system has none.
    pub(in crate::workbench) fn new(port: u16) -> Result<Self> {
        Ok(Self { port, token: secret()?, used: AtomicBool::new(false), key: secret()? })
    }

    /// The address with the token.
    pub(in crate::workbench) fn address(&self) -> String {
        format!("http://127.0.0.1:{}/?token={}", self.port, self.token)
    }

    /// Ports share their cookies, so the name holds the port.
    fn cookie_name(&self) -> String {
        format!("lacuna_{}", self.port)
    }

    fn hosts(&self) -> [String; 2] {
        ["127.0.0.1", "localhost"].map(|host| format!("{host}:{}", self.port))
    }

    /// Why a request is not from our own page, if so.
    fn foreign(&self, headers: &HeaderMap) -> Option<&'static str> {
        let text = |name: &HeaderName| headers.get(name).map(|v| v.to_str().unwrap_or("?"));
        let hosts = self.hosts();
        // A name that an attacker's DNS points here is another host (DNS rebinding).
        let host = text(&HOST);
        if !host.is_some_and(|h| hosts.iter().any(|own| h.eq_ignore_ascii_case(own)))
            || headers.get_all(HOST).iter().count() > 1
        {
            return Some("the request is for another host");
        }
        let origin = text(&ORIGIN);
        if origin.is_some_and(|o| !hosts.iter().any(|own| o.eq_ignore_ascii_case(&format!("http://{own}")))) {
            return Some("the request comes from another page");
        }
        match text(&FETCH_SITE) {
            None | Some("same-origin" | "none") => None,
            Some(_) => Some("the request comes from another site"),
        }
    }

    fn is_known(&self, headers: &HeaderMap) -> bool {
        let name = self.cookie_name();
        let cookies = headers.get_all(COOKIE).iter().filter_map(|v| v.to_str().ok());
        let values = cookies.flat_map(|all| all.split(';')).filter_map(|one| one.trim().split_once('='));
        values.filter(|(n, _)| *n == name).any(|(_, value)| same(value, &self.key))
    }

    /// Exchanges the token of the address for the cookie, once.
    fn exchange(&self, query: &str) -> Option<HeaderValue> {
        let token = query.split('&').find_map(|part| part.strip_prefix("token="))?;
        if !same(token, &self.token) || self.used.swap(true, Ordering::SeqCst) {
            return None;
        }
        let cookie = format!("{}={}; Path=/; HttpOnly; SameSite=Strict", self.cookie_name(), self.key);
        HeaderValue::from_str(&cookie).ok()
    }
}

/// 256 random bits as text.
fn secret() -> Result<String> {
    let mut bytes = [0_u8; 32];
    SysRng
        .try_fill_bytes(&mut bytes)
        .map_err(|e| Error::new(format!("the system gives no random numbers for a token: {e}")))?;
    Ok(bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    }))
}

/// Compares without telling by the time it takes where the first difference is.
fn same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |sum, (x, y)| sum | (x ^ y)) == 0
}

/// Lets a request in, or not; sees that no answer can be framed, sniffed, stored or sent elsewhere.
pub(super) async fn guard(State(shared): State<Shared>, request: Request, next: Next) -> Response {
    let mut answer = admitted(&shared.door, request, next).await;
    let headers = answer.headers_mut();
    let fixed = [
        (CONTENT_SECURITY_POLICY, POLICY),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (REFERRER_POLICY, "no-referrer"),
        (HeaderName::from_static("x-frame-options"), "DENY"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ];
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    answer
}

async fn admitted(door: &Door, request: Request, next: Next) -> Response {
    let (headers, uri) = (request.headers(), request.uri());
    let is_api = uri.path().starts_with("/api/");
    if let Some(why) = door.foreign(headers) {
        return refuse(is_api, why, "open the address that `lacuna workbench` printed, in this browser");
    }
    let query = uri.query().unwrap_or_default();
    let shows_token = uri.path() == "/" && request.method() == Method::GET && query.contains("token=");
    let guest = request.extensions().get::<Guest>().cloned();
    if door.is_known(headers) {
        guest.iter().for_each(Guest::is_known);
        // The token is of no more use, and should not stay in the address.
        return if shows_token { home(None) } else { checked(request, next).await };
    }
    match shows_token.then(|| door.exchange(query)).flatten() {
        Some(cookie) => {
            guest.iter().for_each(Guest::is_known);
            home(Some(cookie))
        }
        None if shows_token => refuse(
            is_api,
            "this address was used already, or is not the one that was printed",
            "each address is good for one browser, once: start `lacuna workbench --resume DIR` again for a new one; nothing \
             that was finished is lost",
        ),
        None => refuse(
            is_api,
            "this browser is not known here",
            "open the address that `lacuna workbench` printed, with its token",
        ),
    }
}

/// Methods and media types that a page of ours would send.
async fn checked(request: Request, next: Next) -> Response {
    let kind = request.headers().get(CONTENT_TYPE).and_then(|v| v.to_str().ok()).unwrap_or_default();
    let kind = kind.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
    let wanted =
        if request.uri().path() == "/api/upload" { "application/octet-stream" } else { "application/json" };
    match *request.method() {
        Method::GET | Method::HEAD => next.run(request).await,
        Method::POST if kind == wanted => next.run(request).await,
        Method::POST => {
            let error = Error::new(format!("the body is `{kind}`, not `{wanted}`"));
            reply::failed(StatusCode::UNSUPPORTED_MEDIA_TYPE, &error)
        }
        _ => reply::failed(StatusCode::METHOD_NOT_ALLOWED, &Error::new("this method is not known here")),
    }
}

/// To the page itself, without a token in the address.
fn home(cookie: Option<HeaderValue>) -> Response {
    let mut answer = StatusCode::SEE_OTHER.into_response();
    answer.headers_mut().insert(LOCATION, HeaderValue::from_static("/"));
    if let Some(cookie) = cookie {
        answer.headers_mut().insert(SET_COOKIE, cookie);
    }
    answer
}

fn refuse(is_api: bool, why: &'static str, help: &'static str) -> Response {
    if is_api {
        return reply::failed(StatusCode::FORBIDDEN, &Error::new(why).help(help));
    }
    let page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\"><title>lacuna workbench</title></head>\n\
         <body><main><h1>Not let in</h1><p>Reason: {why}.</p><p>What to do: {help}.</p></main></body></html>\n"
    );
    (StatusCode::FORBIDDEN, [(CONTENT_TYPE, "text/html; charset=utf-8")], page).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(all: &[(&'static str, &str)]) -> HeaderMap {
        let pair = |(n, v): &(&'static str, &str)| {
            (HeaderName::from_static(n), HeaderValue::from_str(v).expect("a value"))
        };
        all.iter().map(pair).collect()
    }

    #[test]
    fn only_our_own_page_is_not_foreign() -> Result<()> {
        let door = Door::new(4321)?;
        let fine = [
            vec![("host", "127.0.0.1:4321")],
            vec![("host", "LocalHost:4321"), ("origin", "http://127.0.0.1:4321")],
            vec![
                ("host", "localhost:4321"),
                ("origin", "http://localhost:4321"),
                ("sec-fetch-site", "same-origin"),
            ],
            vec![("host", "localhost:4321"), ("sec-fetch-site", "none")],
        ];
        for case in fine {
            assert_eq!(door.foreign(&headers(&case)), None, "{case:?}");
        }
        let foreign = [
            vec![],
            vec![("host", "evil.example:4321")],
            vec![("host", "127.0.0.1")],
            vec![("host", "127.0.0.1:80")],
            vec![("host", "localhost.evil.example:4321")],
            vec![("host", "127.0.0.1:4321"), ("origin", "null")],
            vec![("host", "127.0.0.1:4321"), ("origin", "https://127.0.0.1:4321")],
            vec![("host", "127.0.0.1:4321"), ("origin", "http://127.0.0.1:4322")],
            vec![("host", "127.0.0.1:4321"), ("sec-fetch-site", "cross-site")],
            vec![("host", "127.0.0.1:4321"), ("sec-fetch-site", "same-site")],
        ];
        for case in foreign {
            assert!(door.foreign(&headers(&case)).is_some(), "{case:?}");
        }
        Ok(())
    }

    #[test]
    fn a_token_is_exchanged_once_and_gives_the_cookie_that_is_known() -> Result<()> {
        let door = Door::new(4321)?;
        assert!(door.exchange("token=").is_none());
        assert!(door.exchange(&format!("token={}", "0".repeat(64))).is_none());
        let cookie = door.exchange(&format!("x=1&token={}", door.token)).expect("the right token");
        assert!(door.exchange(&format!("token={}", door.token)).is_none(), "once only");
        let cookie = cookie.to_str().expect("text");
        assert!(
            cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict") && cookie.contains("Path=/")
        );
        let value = cookie.split(';').next().expect("a pair");
        assert!(door.is_known(&headers(&[("cookie", &format!("a=b; {value}"))])));
        assert!(!door.is_known(&headers(&[("cookie", &value[..value.len() - 1])])));
        assert!(!door.is_known(&headers(&[("cookie", &value.replace("4321", "4322"))])));
        assert_ne!(door.token, door.key);
        Ok(())
    }
}
