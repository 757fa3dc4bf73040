//! Lines and words of an OBJ file, as spans of its bytes.
//!
//! A statement is one line, or several joined by a backslash at their end. Bytes stay bytes: names may be in any
//! encoding. Lines end in LF, CRLF or a lone CR; the last one may end in nothing.
//! Limits: a line that holds `#` is never joined to the next one, so that a path in a comment that ends in a backslash
//! does not swallow a vertex.

use memchr::{memchr, memchr2};

/// UTF-8 byte order mark. Files that were joined have them in the middle too, so no line begins with one.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// One statement of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Statement {
    /// Line of its first byte, from 1.
    pub line: usize,
    /// First byte.
    pub start: usize,
    /// End of its text, before the line end.
    pub end: usize,
    /// First byte of the next statement.
    pub next: usize,
}

/// Walks the statements of a file.
pub struct Statements<'a> {
    source: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Statements<'a> {
    /// Begins at the first byte.
    pub fn new(source: &'a [u8]) -> Self {
        Self { source, at: 0, line: 1 }
    }
}

impl Iterator for Statements<'_> {
    type Item = Statement;

    fn next(&mut self) -> Option<Statement> {
        while self.source[self.at..].starts_with(BYTE_ORDER_MARK) {
            self.at += BYTE_ORDER_MARK.len();
        }
        if self.at >= self.source.len() {
            return None;
        }
        let (start, line) = (self.at, self.line);
        loop {
            let (end, next) = line_end(self.source, self.at);
            let joined = continues(&self.source[self.at..end]);
            self.at = next;
            self.line += 1;
            if !joined || next >= self.source.len() {
                return Some(Statement { line, start, end, next });
            }
        }
    }
}

/// Where the line that holds byte `at` ends, and where the next one begins.
fn line_end(source: &[u8], at: usize) -> (usize, usize) {
    match memchr2(b'\n', b'\r', &source[at..]) {
        None => (source.len(), source.len()),
        Some(i) if source[at + i..].starts_with(b"\r\n") => (at + i, at + i + 2),
        Some(i) => (at + i, at + i + 1),
    }
}

/// Whether `line` ends in a backslash (blanks after it do not count) that joins it to the next.
fn continues(line: &[u8]) -> bool {
    line.trim_ascii_end().last() == Some(&b'\\') && memchr(b'#', line).is_none()
}

/// The line end that the file uses: that of its first line.
pub fn newline(source: &[u8]) -> &[u8] {
    let (end, next) = line_end(source, 0);
    if end == next { b"\n" } else { &source[end..next] }
}

/// Walks the words of a statement's text. A word that begins with `#` ends it; inside a word the sign is a byte like any
/// other, so that `1.#INF` is not read as 1.
pub struct Words<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Words<'a> {
    /// Begins at the first byte of `text`.
    pub fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0 }
    }

    /// What follows the words so far, as it stands there, comment and all.
    pub fn rest(&self) -> &'a [u8] {
        self.text[self.at..].trim_ascii()
    }

    /// The next word's first byte and end.
    pub fn next_span(&mut self) -> Option<(usize, usize)> {
        while self.at < self.text.len() && is_blank(self.text, self.at) {
            self.at += 1;
        }
        let start = self.at;
        if self.text.get(start) == Some(&b'#') {
            return None;
        }
        while self.at < self.text.len() && !is_blank(self.text, self.at) {
            self.at += 1;
        }
        (start < self.at).then_some((start, self.at))
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        self.next_span().map(|(start, end)| &self.text[start..end])
    }
}

/// White space, or a backslash that joins two lines.
#[inline]
fn is_blank(text: &[u8], at: usize) -> bool {
    match text[at] {
        b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c => true,
        b'\\' => text.get(at + 1).is_none_or(u8::is_ascii_whitespace),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(source: &[u8]) -> Vec<(usize, &[u8])> {
        Statements::new(source).map(|s| (s.line, &source[s.start..s.end])).collect()
    }

    #[test]
    fn every_kind_of_line_end_ends_a_line() {
        assert_eq!(texts(b"a\nb\r\nc\rd"), [(1, &b"a"[..]), (2, &b"b"[..]), (3, &b"c"[..]), (4, &b"d"[..])]);
        assert_eq!(texts(b""), []);
        assert_eq!(newline(b"a\r\nb\n"), b"\r\n");
        assert_eq!(newline(b"a"), b"\n");
    }

    #[test]
    fn a_backslash_joins_lines_but_not_in_a_comment() {
        assert_eq!(texts(b"f 1 \\\r\n 2 3\nv"), [(1, &b"f 1 \\\r\n 2 3"[..]), (3, &b"v"[..])]);
        assert_eq!(texts(b"# C:\\\nv").len(), 2);
        assert_eq!(texts(b"f 1 2\\"), [(1, &b"f 1 2\\"[..])]);
    }

    #[test]
    fn words_skip_blanks_joints_and_comments() {
        let words: Vec<_> = Words::new(b" f  1/2\t3 \\\n 4\\\n5 #6 7").collect();
        assert_eq!(words, [&b"f"[..], b"1/2", b"3", b"4", b"5"]);
    }

    #[test]
    fn a_byte_order_mark_belongs_to_no_statement() {
        assert_eq!(texts(b"\xEF\xBB\xBFv 1\n\xEF\xBB\xBFf"), [(1, &b"v 1"[..]), (2, &b"f"[..])]);
    }
}
