//! XML into events, in one pass and without allocation.
//!
//! Understands what RSI peers send: elements, attributes in either quote, text, comments and an XML declaration.
//! DOCTYPE and CDATA are refused. Entities are left as they are, since no number needs one. Elements must be closed
//! in order by their own name, so a telegram that was cut off is never mistaken for a whole one.

use heapless::Vec;

use super::RsiError;

/// Deepest nesting: `Rob`, `Dat`, an element, and room for elements that are skipped.
const MAX_DEPTH: usize = 8;

/// A piece of the telegram and where it starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Token<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
}

/// What the scanner comes across. The elements that are open are in [`Scanner::path`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Event<'a> {
    /// An element starts; it is the last of the path.
    Open { at: usize },
    /// An attribute of the last element of the path.
    Attribute { name: &'a [u8], value: Token<'a> },
    /// Text in the last element of the path, without the white space around it; never empty.
    Text(Token<'a>),
    /// The element that was last in the path has ended.
    Close,
}

/// Cursor over a telegram.
pub(super) struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    path: Vec<&'a [u8], MAX_DEPTH>,
    in_tag: bool,
    root_seen: bool,
}

impl<'a> Scanner<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            path: Vec::new(),
            in_tag: false,
            root_seen: false,
        }
    }

    /// Names of the open elements, the root first.
    pub(super) fn path(&self) -> &[&'a [u8]] {
        &self.path
    }

    /// The next event; `None` after the end of a complete telegram.
    pub(super) fn next(&mut self) -> Result<Option<Event<'a>>, RsiError> {
        if self.in_tag
            && let Some(event) = self.next_in_tag()?
        {
            return Ok(Some(event));
        }
        loop {
            if let Some(text) = self.text()? {
                return Ok(Some(Event::Text(text)));
            }
            let rest = self.rest();
            if rest.is_empty() {
                return if self.path.is_empty() && self.root_seen {
                    Ok(None)
                } else {
                    Err(self.truncated())
                };
            }
            if rest.starts_with(b"<?") {
                self.skip_past(b"?>")?;
            } else if rest.starts_with(b"<!--") {
                self.at += b"<!--".len();
                self.skip_past(b"-->")?;
            } else if rest.starts_with(b"</") {
                return self.end_tag().map(Some);
            } else {
                return self.start_tag().map(Some);
            }
        }
    }

    /// Attribute or end of an empty element; `None` once the tag is over and content follows.
    fn next_in_tag(&mut self) -> Result<Option<Event<'a>>, RsiError> {
        let separated = self.skip_white_space();
        match self.peek() {
            Some(b'>') => {
                self.at += 1;
                self.in_tag = false;
                Ok(None)
            }
            Some(b'/') => {
                self.at += 1;
                self.expect(b'>')?;
                self.in_tag = false;
                self.path.pop();
                Ok(Some(Event::Close))
            }
            Some(_) if separated => self.attribute().map(Some),
            Some(_) => Err(self.markup()),
            None => Err(self.truncated()),
        }
    }

    fn attribute(&mut self) -> Result<Event<'a>, RsiError> {
        let name = self.name()?;
        self.skip_white_space();
        self.expect(b'=')?;
        self.skip_white_space();
        let quote = match self.peek() {
            Some(quote @ (b'"' | b'\'')) => quote,
            Some(_) => return Err(self.markup()),
            None => return Err(self.truncated()),
        };
        self.at += 1;
        let value = self.take_until(|byte| byte == quote || byte == b'<');
        self.expect(quote)?;
        Ok(Event::Attribute { name, value })
    }

    fn start_tag(&mut self) -> Result<Event<'a>, RsiError> {
        let at = self.at;
        if self.path.is_empty() && self.root_seen {
            return Err(self.markup());
        }
        self.at += 1;
        let name = self.name()?;
        self.path
            .push(name)
            .map_err(|_| RsiError::TooDeep { at, max: MAX_DEPTH })?;
        self.root_seen = true;
        self.in_tag = true;
        Ok(Event::Open { at })
    }

    fn end_tag(&mut self) -> Result<Event<'a>, RsiError> {
        let at = self.at;
        self.at += b"</".len();
        let name = self.name()?;
        self.skip_white_space();
        self.expect(b'>')?;
        if self.path.pop() == Some(name) {
            Ok(Event::Close)
        } else {
            Err(RsiError::Markup { at })
        }
    }

    /// Text up to the next `<`, trimmed; `None` if it is only white space.
    fn text(&mut self) -> Result<Option<Token<'a>>, RsiError> {
        let raw = self.take_until(|byte| byte == b'<');
        // A sender that counts the terminator of a C string appends a NUL to the telegram.
        let after_root = self.root_seen && self.path.is_empty();
        let ignored = |byte: &u8| is_white_space(*byte) || (after_root && *byte == 0);
        let Some(lead) = raw.bytes.iter().position(|byte| !ignored(byte)) else {
            return Ok(None);
        };
        let at = raw.at + lead;
        if self.path.is_empty() {
            return Err(RsiError::Markup { at });
        }
        let bytes = raw.bytes.get(lead..).unwrap_or_default().trim_ascii_end();
        Ok(Some(Token { bytes, at }))
    }

    fn name(&mut self) -> Result<&'a [u8], RsiError> {
        let name = self.take_until(|byte| {
            is_white_space(byte) || matches!(byte, b'<' | b'>' | b'/' | b'=' | b'"' | b'\'')
        });
        match name.bytes.first() {
            None if self.rest().is_empty() => Err(self.truncated()),
            None | Some(b'!' | b'?') => Err(RsiError::Markup { at: name.at }),
            Some(_) => Ok(name.bytes),
        }
    }

    fn skip_past(&mut self, end: &[u8]) -> Result<(), RsiError> {
        let found = self
            .rest()
            .windows(end.len())
            .position(|window| window == end)
            .ok_or(self.truncated())?;
        self.at += found + end.len();
        Ok(())
    }

    /// Returns whether there was any.
    fn skip_white_space(&mut self) -> bool {
        !self
            .take_until(|byte| !is_white_space(byte))
            .bytes
            .is_empty()
    }

    fn take_until(&mut self, stop: impl Fn(u8) -> bool) -> Token<'a> {
        let (rest, at) = (self.rest(), self.at);
        let len = rest
            .iter()
            .position(|byte| stop(*byte))
            .unwrap_or(rest.len());
        self.at += len;
        Token {
            bytes: rest.get(..len).unwrap_or_default(),
            at,
        }
    }

    fn expect(&mut self, wanted: u8) -> Result<(), RsiError> {
        match self.peek() {
            Some(byte) if byte == wanted => {
                self.at += 1;
                Ok(())
            }
            Some(_) => Err(self.markup()),
            None => Err(self.truncated()),
        }
    }

    fn peek(&self) -> Option<u8> {
        self.rest().first().copied()
    }

    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    fn markup(&self) -> RsiError {
        RsiError::Markup { at: self.at }
    }

    fn truncated(&self) -> RsiError {
        RsiError::Truncated {
            len: self.bytes.len(),
        }
    }
}

/// White space as XML defines it.
fn is_white_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | b'\n')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(text: &str) -> Result<std::vec::Vec<String>, RsiError> {
        let mut scanner = Scanner::new(text.as_bytes());
        let mut seen = std::vec::Vec::new();
        let utf8 = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        while let Some(event) = scanner.next()? {
            seen.push(match event {
                Event::Open { .. } => format!("<{}", utf8(scanner.path().last().unwrap())),
                Event::Attribute { name, value } => {
                    format!("{}={}", utf8(name), utf8(value.bytes))
                }
                Event::Text(text) => utf8(text.bytes),
                Event::Close => ">".to_owned(),
            });
        }
        Ok(seen)
    }

    #[test]
    fn reports_elements_attributes_and_text() {
        let text = "<?xml version='1.0'?>\r\n<!-- <x> --><a\tp = '1>' q=\"2\"\r\n>\n t <!---->u<b/><c x='' /></a >\0";
        assert_eq!(
            scan(text).unwrap(),
            [
                "<a", "p=1>", "q=2", "t", "u", "<b", ">", "<c", "x=", ">", ">"
            ]
        );
    }

    #[test]
    fn refuses_what_is_not_well_formed() {
        use RsiError::{Markup, TooDeep, Truncated};
        for (text, error) in [
            ("", Truncated { len: 0 }),
            ("  ", Truncated { len: 2 }),
            ("<a>", Truncated { len: 3 }),
            ("<a", Truncated { len: 2 }),
            ("<", Truncated { len: 1 }),
            ("<a x", Truncated { len: 4 }),
            ("<a x='", Truncated { len: 6 }),
            ("<a/><!-- ->", Truncated { len: 11 }),
            ("<a></b>", Markup { at: 3 }),
            ("</a>", Markup { at: 0 }),
            ("x<a/>", Markup { at: 0 }),
            ("\0<a/>", Markup { at: 0 }),
            ("<a/>x", Markup { at: 4 }),
            ("<a/><a/>", Markup { at: 4 }),
            ("<a x='1'y='2'/>", Markup { at: 8 }),
            ("<a x=1/>", Markup { at: 5 }),
            ("<a>< b/></a>", Markup { at: 4 }),
            ("<a x/>", Markup { at: 4 }),
            ("<a x='<'/>", Markup { at: 6 }),
            ("<a / >", Markup { at: 4 }),
            ("<!DOCTYPE a><a/>", Markup { at: 1 }),
            ("<a><![CDATA[1]]></a>", Markup { at: 4 }),
        ] {
            assert_eq!(scan(text), Err(error), "{text}");
        }
        let deep = "<a>".repeat(MAX_DEPTH + 1);
        assert_eq!(
            scan(&deep),
            Err(TooDeep {
                at: 3 * MAX_DEPTH,
                max: MAX_DEPTH
            })
        );
    }
}
