//! Bodies of what is asked for: one JSON object each.

use axum::body::Bytes;
use axum::extract::{FromRequest, Request};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;

use super::reply;
use crate::error::{Error, Result};

/// What a body says, or why it cannot be used.
pub(super) type Body<T> = Result<Object<T>, Unusable>;

/// A body that is a JSON object.
pub(super) struct Object<T>(pub T);

/// A body that is none.
pub(super) struct Unusable(Error);

impl IntoResponse for Unusable {
    fn into_response(self) -> Response {
        reply::failed(StatusCode::BAD_REQUEST, &self.0)
    }
}

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for Object<T> {
    type Rejection = Unusable;

    async fn from_request(request: Request, state: &S) -> Body<T> {
        let bytes =
            Bytes::from_request(request, state).await.map_err(|e| Unusable(Error::new(e.body_text())))?;
        read(&bytes).map(Self).map_err(Unusable)
    }
}

/// Reads an object. A list is none: serde would take its entries for the fields in order, and an empty one for an
/// object where every field may be left out.
fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<T> {
    let first = bytes.iter().find(|b| !b.is_ascii_whitespace());
    if first.is_some_and(|b| *b != b'{') {
        return Err(Error::new("the body is not a JSON object").help("send {\"field\": value}, in braces"));
    }
    serde_json::from_slice(bytes).map_err(|e| {
        let text = e.to_string();
        let what = text.rsplit_once(" at line ").map_or(text.as_str(), |(what, _)| what);
        Error::new(format!("the body cannot be used: {what}")).at(e.line(), e.column())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Asked {
        #[serde(default)]
        step: Option<usize>,
    }

    #[test]
    fn objects_are_read_and_nothing_else_is() -> Result<()> {
        assert_eq!(read::<Asked>(b" {}\n")?, Asked { step: None });
        assert_eq!(read::<Asked>(b"\t{\"step\": 3}")?, Asked { step: Some(3) });
        for other in ["[]", " [3]", "3", "null", "\"{}\"", "true"] {
            let error = read::<Asked>(other.as_bytes()).expect_err(other);
            assert!(error.message().contains("not a JSON object"), "{error}");
        }
        for broken in ["", "{", "{} {}", "{\"step\": -1}", "{\"more\": 1}"] {
            let error = read::<Asked>(broken.as_bytes()).expect_err(broken);
            let place = error.place().and_then(|p| p.line.zip(p.column));
            assert!(place.is_some() && !error.message().contains(" at line "), "{error}");
        }
        Ok(())
    }
}
