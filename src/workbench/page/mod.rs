//! The page's own files; everything else of it is the report's.

/// Name, media type, content.
pub(super) const FILES: &[(&str, &str, &str)] = &[
    ("bench.html", "text/html; charset=utf-8", include_str!("bench.html")),
    ("bench.css", "text/css; charset=utf-8", include_str!("bench.css")),
    ("api.js", "text/javascript; charset=utf-8", include_str!("api.js")),
    ("bench.js", "text/javascript; charset=utf-8", include_str!("bench.js")),
    ("candidates.js", "text/javascript; charset=utf-8", include_str!("candidates.js")),
    ("columns.js", "text/javascript; charset=utf-8", include_str!("columns.js")),
    ("data.js", "text/javascript; charset=utf-8", include_str!("data.js")),
    ("editor.js", "text/javascript; charset=utf-8", include_str!("editor.js")),
    ("examples.js", "text/javascript; charset=utf-8", include_str!("examples.js")),
    ("files.js", "text/javascript; charset=utf-8", include_str!("files.js")),
    ("job.js", "text/javascript; charset=utf-8", include_str!("job.js")),
    ("joints.js", "text/javascript; charset=utf-8", include_str!("joints.js")),
    ("ladder.js", "text/javascript; charset=utf-8", include_str!("ladder.js")),
    ("mapping.js", "text/javascript; charset=utf-8", include_str!("mapping.js")),
    ("model.js", "text/javascript; charset=utf-8", include_str!("model.js")),
    ("parameters.js", "text/javascript; charset=utf-8", include_str!("parameters.js")),
    ("parts.js", "text/javascript; charset=utf-8", include_str!("parts.js")),
    ("scripts.js", "text/javascript; charset=utf-8", include_str!("scripts.js")),
    ("span.js", "text/javascript; charset=utf-8", include_str!("span.js")),
];
