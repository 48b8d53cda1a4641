//! Text of others, as it may be shown: a message of a vehicle, the name of an operator.

/// Whether a character shows as itself. Control characters have no place in a log line or on a terminal; the others
/// turn the text behind them round, or are not seen (Unicode's bidirectional controls, separators and fillers).
/// Joiners are left, which some scripts need.
pub fn is_plain(c: char) -> bool {
    let is_hidden = matches!(
        c,
        '\u{ad}'
            | '\u{61c}'
            | '\u{200b}'
            | '\u{200e}'
            | '\u{200f}'
            | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}'
            | '\u{feff}'
            | '\u{fff9}'..='\u{fffb}'
            | '\u{e0000}'..='\u{e007f}'
    );
    !c.is_control() && !is_hidden
}

/// The beginning of a text, without characters that do not show as themselves.
pub fn plain(text: &str, max_chars: usize) -> String {
    text.chars().filter(|c| is_plain(*c)).take(max_chars).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_or_turns_a_line_round_is_left_out() {
        assert_eq!(plain("\u{202e}evil\u{1b}[31m\n\u{2066}", 99), "evil[31m");
        assert_eq!(plain("ñandú \u{200d} سلام", 99), "ñandú \u{200d} سلام");
        assert_eq!(plain("abcd", 2), "ab");
    }
}
