//! Quotes words of shell commands that a person copies.

use std::fmt::Display;

/// Quotes a word for a POSIX shell: a path with a space stays one word, and nothing in it is expanded. A word that begins
/// with `-` is still an option to the command.
pub fn quoted(word: impl Display) -> String {
    let text = word.to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-%+=:,@".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        return text;
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn words_survive_the_shell() {
        for plain in ["runs/a-1.mcap", "s3://bucket/a,b", "größe.mcap"] {
            assert_eq!(quoted(plain), plain);
        }
        assert_eq!(quoted("it's $HOME"), r"'it'\''s $HOME'");
        assert_eq!(quoted(""), "''");
    }
}
