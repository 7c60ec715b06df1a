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

#[test]
fn a_page_is_written_or_the_reason_is_told() {
    // Stays beside the test program, for a look with a browser.
    let folder = std::env::current_exe()
        .unwrap()
        .parent()
        .unwrap()
        .to_path_buf();
    let path = folder.join("report-sample.html");
    let page = sample_page();
    page.write(&path).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), page.to_html());
    let error = page
        .write(&folder.join("missing-folder").join("a.html"))
        .unwrap_err();
    assert!(format!("{error:#}").contains("check that the folder exists"));
}
