//! Whether two segments are closer than a number of texels, decided exactly.
//!
//! In f64 first, with a bound of its error; what that cannot decide, in whole numbers: every f64 is one times a power of two.

use glam::DVec2;
use num_bigint::BigInt;

/// A distance of `padding` texels, `size` of which are the side of the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texels {
    /// Texels a side.
    pub size: u32,
    /// The distance.
    pub padding: u32,
}

/// Whether some point of segment `a` is nearer to some point of `b` than `gap`. They do not cross, or overlap is found elsewhere.
pub(super) fn is_closer(a: [DVec2; 2], b: [DVec2; 2], gap: Texels) -> bool {
    [(a[0], b), (a[1], b), (b[0], a), (b[1], a)].into_iter().any(|(p, segment)| point_is_closer(p, segment, gap))
}

/// Distance of two segments that do not cross, as f64 rounds it.
pub(super) fn distance(a: [DVec2; 2], b: [DVec2; 2]) -> f64 {
    let of = |p: DVec2, [a, b]: [DVec2; 2]| {
        let along = b - a;
        let t = ((p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (a + along * t).distance(p)
    };
    of(a[0], b).min(of(a[1], b)).min(of(b[0], a)).min(of(b[1], a))
}

fn point_is_closer(p: DVec2, [a, b]: [DVec2; 2], gap: Texels) -> bool {
    let bound = f64::from(gap.padding) / f64::from(gap.size);
    // A squared distance in f64 is off by few units in the last place of the coordinates' products.
    let largest = [p, a, b].iter().fold(1.0, |m, q| f64::max(m, q.abs().max_element()));
    let slack = 1e-12 * largest;
    match distance([p, p], [a, b]) {
        d if d > bound + slack => false,
        d if d < bound - slack => true,
        _ => is_closer_by_whole_numbers(p, [a, b], gap),
    }
}

fn is_closer_by_whole_numbers(p: DVec2, [a, b]: [DVec2; 2], gap: Texels) -> bool {
    let all = [p.x, p.y, a.x, a.y, b.x, b.y].map(parts);
    let least = all.iter().filter(|(mantissa, _)| *mantissa != 0).map(|(_, e)| *e).min().unwrap_or(0);
    // With least below 0, as it is for all but huge numbers, 1 is 2^-least.
    let [px, py, ax, ay, bx, by] = all.map(|(m, e)| match m {
        0 => BigInt::ZERO,
        _ => BigInt::from(m) << (e - least),
    });
    let square = |x: &BigInt| x * x;
    let (dx, dy, ex, ey) = (&px - &ax, &py - &ay, &bx - &ax, &by - &ay);
    let (fx, fy) = (&px - &bx, &py - &by);
    let (length, along) = (square(&ex) + square(&ey), &dx * &ex + &dy * &ey);
    // (size * distance)^2 < padding^2, with both sides in the same unit.
    let unit = |x: BigInt| if least < 0 { x << (2 * -least) } else { x >> (2 * least) };
    let (size, padding) = (square(&BigInt::from(gap.size)), unit(square(&BigInt::from(gap.padding))));
    if along <= BigInt::ZERO {
        return (square(&dx) + square(&dy)) * size < padding;
    }
    if along >= length {
        return (square(&fx) + square(&fy)) * size < padding;
    }
    square(&(&dx * &ey - &dy * &ex)) * size < padding * length
}

/// A finite number as a whole number times a power of two.
fn parts(x: f64) -> (i64, i32) {
    let bits = x.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let (mantissa, exponent) = if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent - 1075) };
    // Small whole numbers, so that the common unit is no finer than it must be.
    let zeros = if mantissa == 0 { 0 } else { mantissa.trailing_zeros() as i32 };
    let mantissa = mantissa >> zeros;
    (if x < 0.0 { -mantissa } else { mantissa }, exponent + zeros)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_that_is_just_held_holds_and_a_last_bit_less_does_not() {
        let gap = Texels { size: 1024, padding: 2 };
        let wall = [DVec2::new(0.5, 0.0), DVec2::new(0.5, 1.0)];
        let at = |x: f64| [DVec2::new(x, 0.25), DVec2::new(x + 0.1, 0.75)];
        let x = 0.5 + 2.0 / 1024.0;
        assert!(!is_closer(at(x), wall, gap));
        assert!(is_closer(at(x.next_down()), wall, gap));
        // A slanted wall: 3, 4, 5.
        let wall = [DVec2::ZERO, DVec2::new(0.75, 1.0)];
        let gap = Texels { size: 8, padding: 1 };
        let at = |x: f64| [DVec2::new(x, 0.0), DVec2::new(1.0, 0.0)];
        assert_eq!(
            [0.15625, 0.15625f64.next_down(), 0.15625f64.next_up()].map(|x| is_closer(at(x), wall, gap)),
            [false, true, false]
        );
        assert!(is_closer([DVec2::ONE; 2], [DVec2::ONE; 2], gap));
        assert!(!is_closer([DVec2::ONE; 2], [DVec2::ONE; 2], Texels { padding: 0, ..gap }));
    }

    #[test]
    fn numbers_come_apart_exactly() {
        for x in [0.0, 1.0, -0.375, 0.1, f64::MIN_POSITIVE / 8.0, -1e300] {
            let (mantissa, exponent) = parts(x);
            assert_eq!(mantissa as f64 * 2f64.powi(exponent.max(-1000)) * 2f64.powi((exponent + 1000).min(0)), x);
        }
    }
}
