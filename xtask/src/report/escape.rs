//! Text inside HTML and SVG.

use std::fmt::{self, Display, Formatter, Write};

/// Displays a text with everything escaped that means something in an element or in a quoted attribute.
#[derive(Debug, Clone, Copy)]
pub(super) struct Escaped<'a>(pub &'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|letter| match letter {
            '&' => f.write_str("&amp;"),
            '<' => f.write_str("&lt;"),
            '>' => f.write_str("&gt;"),
            '"' => f.write_str("&quot;"),
            '\'' => f.write_str("&#39;"),
            // XML, and so SVG, has no place for other control characters
            letter if letter.is_control() && !matches!(letter, '\n' | '\t') => f.write_char('\u{fffd}'),
            letter => f.write_char(letter),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_stays_that_could_open_a_tag_or_close_an_attribute() {
        let text = "<a href='x'>\"&\"</a>\u{0}";
        assert_eq!(
            Escaped(text).to_string(),
            "&lt;a href=&#39;x&#39;&gt;&quot;&amp;&quot;&lt;/a&gt;\u{fffd}"
        );
    }
}
