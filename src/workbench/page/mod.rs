//! The page's own files; everything else of it is the report's.

/// Name, media type, content.
pub(super) const FILES: &[(&str, &str, &str)] = &[
    ("bench.html", "text/html; charset=utf-8", include_str!("bench.html")),
    ("bench.css", "text/css; charset=utf-8", include_str!("bench.css")),
    ("bench.js", "text/javascript; charset=utf-8", include_str!("bench.js")),
];
