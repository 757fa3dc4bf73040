//! The words of OBJ statements: coordinates, UVs, corners.

use super::problem::Problem;
use super::statement::Words;
use crate::mesh::polygons::NO_UV;
use glam::{DVec2, Vec3};

/// A finite number.
pub(super) fn coordinate(word: &[u8]) -> Result<f64, Problem> {
    let value: f64 = core::str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse().ok())
        .ok_or_else(|| Problem::NotANumber { word: shown(word) })?;
    if value.is_finite() { Ok(value) } else { Err(Problem::NotFinite { word: shown(word) }) }
}

/// A missing second coordinate is 0; anything that is no number is no UV.
pub(super) fn texture(words: Words) -> DVec2 {
    let mut uv = [f64::NAN, 0.0];
    for (value, word) in uv.iter_mut().zip(words) {
        *value = coordinate(word).unwrap_or(f64::NAN);
    }
    if uv.iter().all(|x| x.is_finite()) { DVec2::from(uv) } else { NO_UV }
}

/// A normal; NaN where a word is no number, zero where words are missing.
pub(super) fn normal(words: Words) -> Vec3 {
    let mut xyz = [0.0; 3];
    for (value, word) in xyz.iter_mut().zip(words) {
        *value = coordinate(word).map_or(f32::NAN, |x| x as f32);
    }
    Vec3::from(xyz)
}

/// `v`, `v/vt`, `v//vn`, `v/vt/vn`, empty fields allowed after the first.
pub(super) fn corner(word: &[u8]) -> Option<[Option<i64>; 3]> {
    let mut fields = [None; 3];
    for (used, field) in word.split(|b| *b == b'/').enumerate() {
        *fields.get_mut(used)? = if field.is_empty() { None } else { Some(whole_number(field)?) };
    }
    fields[0].is_some().then_some(fields)
}

/// Whether `word` is a corner with a `vt` field, of a face, line or surface.
pub(super) fn names_texture(word: &[u8]) -> bool {
    corner(word).is_some_and(|fields| fields[1].is_some())
}

/// A decimal number with an optional sign; too large ones saturate, which no range admits.
fn whole_number(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let value = digits.iter().fold(0i64, |n, d| n.saturating_mul(10).saturating_add(i64::from(d - b'0')));
    Some(if negative { -value } else { value })
}

/// A word of the file for a message: readable, and not longer than a line can bear.
pub(super) fn shown(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(LONGEST)]);
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}
