//! Text in pages and drawings: escaping, and the width that it will roughly take.

/// Mean advance of a sans-serif character, in units of the font size. Browsers choose the font, so a drawing can
/// only estimate; 0.56 is a little more than Helvetica, Segoe and DejaVu need for running text.
const MEAN_ADVANCE_EM: f64 = 0.56;

/// `text` without control characters, which XML forbids and a terminal would obey.
pub(super) fn printable(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '\n' | '\r' | '\t' => ' ',
            // U+FFFE and U+FFFF are the two other characters that XML 1.0 excludes.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => {
                char::REPLACEMENT_CHARACTER
            }
            c => c,
        })
        .collect()
}

/// `text` made safe for HTML and XML content and attributes; line breaks survive.
pub(super) fn escape(text: &str) -> String {
    let escape = |line: &str| {
        printable(line)
            .replace('&', "&amp;")
            .replace('<', "&lt;")
            .replace('>', "&gt;")
            .replace('"', "&quot;")
            .replace('\'', "&#39;")
    };
    let lines: Vec<String> = text.lines().map(escape).collect();
    lines.join("\n")
}

/// Estimated width of `text` in pixels at a font size in pixels.
pub(super) fn width_px(text: &str, font_px: f64) -> f64 {
    text.chars().count() as f64 * MEAN_ADVANCE_EM * font_px
}

/// `text` cut to about `limit_px` with an ellipsis.
pub(super) fn shorten(text: &str, font_px: f64, limit_px: f64) -> String {
    if width_px(text, font_px) <= limit_px {
        return text.to_owned();
    }
    let keep = (limit_px / (MEAN_ADVANCE_EM * font_px)) as usize;
    let mut short: String = text.chars().take(keep.saturating_sub(1)).collect();
    short.truncate(short.trim_end().len());
    short.push('…');
    short
}

/// `text` broken between words into lines of about `limit_px`; a single longer word keeps its own line.
pub(super) fn wrap(text: &str, font_px: f64, limit_px: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line)
                if width_px(line, font_px) + width_px(word, font_px) + font_px * 0.5
                    <= limit_px =>
            {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_and_control_characters_are_disarmed() {
        assert_eq!(
            escape("<b a='1'>\"&\u{1b}[31m"),
            "&lt;b a=&#39;1&#39;&gt;&quot;&amp;\u{fffd}[31m"
        );
        assert_eq!(escape("a\nb"), "a\nb");
        assert_eq!(printable("a\nb\u{0}"), "a b\u{fffd}");
    }

    #[test]
    fn wrapping_keeps_every_word_and_shortening_says_so() {
        let text = "Executed velocity of the chaser along the docking axis";
        let lines = wrap(text, 14.0, 160.0);
        assert!(lines.len() > 1 && lines.iter().all(|line| width_px(line, 14.0) <= 160.0));
        assert_eq!(lines.join(" "), text);
        assert_eq!(shorten("short", 12.0, 100.0), "short");
        assert!(shorten(text, 12.0, 100.0).ends_with('…'));
    }
}
