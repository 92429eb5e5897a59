//! The page: one document with its style and script inside, and what a browser may do with it.

/// The document; `{{style}}`, `{{script}}` and `{{nonce}}` are put in.
const DOCUMENT: &str = include_str!("../page/view.html");
const STYLE: &str = include_str!("../page/view.css");
const SCRIPT: &str = concat!(
    include_str!("../page/camera.js"),
    include_str!("../page/frames.js"),
    include_str!("../page/lights.js"),
    include_str!("../page/input.js"),
    include_str!("../page/truth.js"),
    include_str!("../page/own.js")
);

/// The page for one visit; only elements with `nonce` may style or run.
pub fn document(nonce: &str) -> String {
    DOCUMENT
        .replace("{{nonce}}", nonce)
        .replace("{{style}}", STYLE)
        .replace("{{script}}", SCRIPT)
}

/// The policy sent with it: nothing from anywhere, connections to this server alone.
pub fn policy(nonce: &str, host: &str) -> String {
    format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; \
         img-src data: blob:; connect-src ws://{host}; base-uri 'none'; form-action 'none'; \
         frame-ancestors 'none'"
    )
}
