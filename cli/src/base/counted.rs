//! Counts in words.

/// A count of things: "1 chart", "2 charts".
pub fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_one_and_all_others_are_several() {
        assert_eq!([0, 1, 2].map(|n| counted(n, "chart")), ["0 charts", "1 chart", "2 charts"]);
    }
}
