//! The page as a file.

use super::sample::sample_page;
use super::{elements, of};

#[test]
fn a_page_is_well_formed_escaped_and_complete_in_itself() {
    let html = sample_page().to_html();
    let document = html.strip_prefix("<!DOCTYPE html>").unwrap();
    let counts = elements(document);
    assert_eq!(
        (
            of(&counts, "svg"),
            of(&counts, "figure"),
            of(&counts, "script")
        ),
        (8, 8, 0)
    );
    assert!(html.contains("&lt;chaser-b&gt;") && html.contains("&lt;unsafe&gt; &amp; more"));
    for outside in ["src=", "href=", "@import", "url("] {
        assert!(
            !html.contains(outside),
            "{outside} could load something from outside"
        );
    }
    let addresses = html.matches("http").count();
    let allowed = html.matches("xmlns=\"http://www.w3.org/2000/svg\"").count()
        + html.matches("http-equiv").count();
    assert_eq!(
        addresses, allowed,
        "an address other than the SVG namespace"
    );
}
