//! Random values as a hash of (seed, stream, index): no state, the same on every thread and machine.
//!
//! The mixer is the finaliser of SplitMix64 (Steele, Lea, Flood 2014), applied once a key.

/// A well-mixed 64-bit value for the three keys.
pub fn hash(seed: u64, stream: u64, index: u64) -> u64 {
    mix(mix(mix(seed ^ 0x9E37_79B9_7F4A_7C15).wrapping_add(stream)).wrapping_add(index))
}

/// Uniform in [0, 1) with 24 bits.
pub fn unit_f32(seed: u64, stream: u64, index: u64) -> f32 {
    (hash(seed, stream, index) >> 40) as f32 * (1.0 / 16_777_216.0)
}

/// Uniform in [0, 1) with 53 bits.
pub fn unit_f64(seed: u64, stream: u64, index: u64) -> f64 {
    (hash(seed, stream, index) >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
}

fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_spread_evenly_over_the_unit_interval() {
        // 16 bins of 4096 draws: a bin's standard deviation is sqrt(4096 * 15/256) = 15.5; 5 sigma = 78.
        let mut bins = [0i32; 16];
        for i in 0..4096 {
            bins[(unit_f64(1, 2, i) * 16.0) as usize] += 1;
        }
        assert!(bins.iter().all(|b| (b - 256).abs() < 78), "{bins:?}");
    }

    #[test]
    fn each_key_changes_the_value() {
        let h = hash(1, 2, 3);
        assert!(h != hash(2, 2, 3) && h != hash(1, 3, 3) && h != hash(1, 2, 4) && h == hash(1, 2, 3));
    }
}
