//! Whole drawings and pages: well-formed, self-contained, small, and readable whatever the data are.

mod charts;
mod pages;
mod plots;
mod sample;

use super::{Plot, Series};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::HashMap;

/// Number of elements of each name, after a check that the text is well-formed XML with closed tags.
fn elements(xml: &str) -> HashMap<String, usize> {
    let mut reader = Reader::from_str(xml);
    let mut counts = HashMap::new();
    let mut depth = 0;
    loop {
        let event = reader.read_event();
        match event.unwrap_or_else(|error| panic!("{error} at byte {}", reader.error_position())) {
            Event::Start(tag) => {
                depth += 1;
                count(&mut counts, &tag);
            }
            Event::Empty(tag) => count(&mut counts, &tag),
            Event::End(_) => depth -= 1,
            Event::Eof => break,
            _ => {}
        }
    }
    assert_eq!(depth, 0, "an element is not closed");
    counts
}

fn count(counts: &mut HashMap<String, usize>, tag: &BytesStart<'_>) {
    for attribute in tag.attributes() {
        attribute.expect("an attribute is malformed or repeated");
    }
    let name = tag.name().as_ref().to_owned();
    *counts.entry(name).or_insert(0) += 1;
}

fn force_plot(series: Vec<Series>) -> Plot {
    Plot {
        series,
        ..Plot::new("Contact force", "time [s]", "force [N]")
    }
}

fn of(counts: &HashMap<String, usize>, name: &str) -> usize {
    counts.get(name).copied().unwrap_or(0)
}

/// Noise between -0.5 and 0.5, the same in each run.
fn noise(index: u32) -> f64 {
    let mut bits = index.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x21f0_aaad);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x735a_2d97);
    f64::from(bits ^ (bits >> 15)) / f64::from(u32::MAX) - 0.5
}
