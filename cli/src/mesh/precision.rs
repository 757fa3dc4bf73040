//! How far a file's coordinates may be from what they stand for.
//!
//! A text is exact to half of its last digit, a float to half of its last bit. Most texts were floats once, so neither is
//! taken for finer than a float. Whole numbers alone say nothing of digits: they are a lattice's or a drawing's own values.

use glam::DVec3;

/// Half the distance between floats of the size of `largest`, the coordinate farthest from 0. 0 for what no float holds.
pub fn of_floats(largest: f64) -> f64 {
    let x = largest.abs() as f32;
    let ulp = f64::from(x.next_up()) - f64::from(x);
    if ulp.is_finite() { 0.5 * ulp } else { 0.0 }
}

/// How far floats are from `positions` at the most, over the largest side of their box; 0 of nothing.
pub fn rounding(positions: &[DVec3]) -> f64 {
    let (mut low, mut high, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0f64);
    for p in positions {
        (low, high) = (low.min(*p), high.max(*p));
        most = most.max((p.as_vec3().as_dvec3() - *p).abs().max_element());
    }
    let size = (high - low).max_element();
    if size > 0.0 && most.is_finite() { most / size } else { 0.0 }
}

/// [`of_floats`] for values that may be doubles: where all are floats, that is what they were.
pub fn of_doubles(values: impl Iterator<Item = f64>) -> f64 {
    let (mut largest, mut are_floats) = (0.0f64, true);
    for x in values {
        largest = largest.max(x.abs());
        are_floats &= f64::from(x as f32) == x;
    }
    let ulp = largest.next_up() - largest;
    match are_floats {
        true => of_floats(largest),
        false if ulp.is_finite() => 0.5 * ulp,
        false => 0.0,
    }
}

/// The most decimals that coordinates of a text have.
#[derive(Clone, Copy, Debug, Default)]
pub struct Decimals(i32);

impl Decimals {
    /// Looks at the word of one coordinate.
    #[inline]
    pub fn see(&mut self, word: &[u8]) {
        let Some(point) = word.iter().position(|b| matches!(b, b'.' | b'e' | b'E')) else { return };
        let digits = word[point + 1..].iter().take_while(|b| b.is_ascii_digit()).count();
        let digits = if word[point] == b'.' { digits.min(1000) as i32 } else { 0 };
        let exponent = word.iter().position(|b| matches!(b, b'e' | b'E')).map_or(0, |at| {
            let text = core::str::from_utf8(&word[at + 1..]).ok();
            text.and_then(|text| text.parse::<i32>().ok()).unwrap_or(0).clamp(-1000, 1000)
        });
        self.0 = self.0.max(digits - exponent);
    }

    /// Half the last digit, but no finer than a float of the size of `largest`.
    pub fn tolerance(self, largest: f64) -> f64 {
        let digit = if self.0 > 0 { 0.5 * 10f64.powi(-self.0) } else { 0.0 };
        digit.max(of_floats(largest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_text(words: &[&str]) -> f64 {
        let mut decimals = Decimals::default();
        words.iter().for_each(|word| decimals.see(word.as_bytes()));
        decimals.tolerance(1.0)
    }

    #[test]
    fn a_text_is_exact_to_half_its_last_digit() {
        assert_eq!(of_text(&["1", "-0.25", "3.5"]), 0.5e-2);
        assert_eq!(of_text(&["0.5000"]), 0.5e-4);
        assert_eq!(of_text(&["12.5e-2", "1e-3"]), 0.5e-3);
        assert_eq!(of_text(&["12.125E+1"]), 0.5e-2);
    }

    #[test]
    fn whole_numbers_and_long_texts_are_as_exact_as_floats() {
        let float = 0.5f64.powi(24);
        assert_eq!(of_floats(1.0), float);
        assert_eq!(of_text(&["7", "1e3", "1.5e9", ""]), float);
        assert_eq!(of_text(&["0.333333333333333"]), float);
        assert_eq!(of_floats(f64::MAX), 0.0);
    }

    #[test]
    fn rounding_grows_with_the_distance_from_the_origin() {
        let square = |at: f64| [DVec3::splat(at), DVec3::new(at + 1.0, at, at), DVec3::new(at, at + 0.3, at)];
        assert!(rounding(&square(0.0)) < 1e-7);
        assert!((0.1..0.5).contains(&rounding(&square(5e6))), "{}", rounding(&square(5e6)));
        assert_eq!((rounding(&[]), rounding(&[DVec3::ONE; 3])), (0.0, 0.0));
    }

    #[test]
    fn doubles_that_are_floats_are_as_exact_as_floats() {
        assert_eq!(of_doubles([1.0, 0.5].into_iter()), of_floats(1.0));
        assert_eq!(of_doubles([1.0, 0.1].into_iter()), 0.5f64.powi(53));
        assert_eq!(of_doubles([].into_iter()), of_floats(0.0));
    }
}
