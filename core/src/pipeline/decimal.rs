//! Numbers in words for people.

use core::fmt::{self, Display, Formatter};

/// A number with four decimals, written by integers: the standard library's own writing of floats holds paths that panic.
pub(super) struct Decimal(pub f32);

impl Display for Decimal {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        if !self.0.is_finite() {
            return f.write_str("not finite");
        }
        let parts = (f64::from(self.0.abs()) * 1e4 + 0.5) as u64;
        write!(f, "{}{}.{:04}", if self.0 < 0.0 { "-" } else { "" }, parts / 10_000, parts % 10_000)
    }
}

#[cfg(test)]
mod tests {
    use super::Decimal;
    use std::format;

    #[test]
    fn a_decimal_reads_as_the_standard_library_would_write_it() {
        for x in [0.0f32, 1.0, 0.25, 0.123_46, 12.000_04, 3.999_96, 1e6, 7e-9, -2.5] {
            assert_eq!(format!("{}", Decimal(x)), format!("{x:.4}"));
        }
        assert_eq!(format!("{}", Decimal(f32::NAN)), "not finite");
    }
}
