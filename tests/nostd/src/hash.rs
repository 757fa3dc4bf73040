//! FNV-1a over values in little-endian order, whatever the machine's own order is.

/// A hash that grows.
pub struct Hash(u64);

impl Hash {
    /// Of nothing.
    pub fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.0 = (self.0 ^ u64::from(*b)).wrapping_mul(0x100_0000_01b3));
    }

    /// The bits of f32 values, in order.
    pub fn f32s(mut self, values: impl IntoIterator<Item = f32>) -> Self {
        values.into_iter().for_each(|x| self.bytes(&x.to_bits().to_le_bytes()));
        self
    }

    /// The bits of f64 values, in order.
    pub fn f64s(mut self, values: impl IntoIterator<Item = f64>) -> Self {
        values.into_iter().for_each(|x| self.bytes(&x.to_bits().to_le_bytes()));
        self
    }

    /// Integers, in order.
    pub fn u32s(mut self, values: impl IntoIterator<Item = u32>) -> Self {
        values.into_iter().for_each(|x| self.bytes(&x.to_le_bytes()));
        self
    }

    /// 64-bit integers, in order.
    pub fn u64s(mut self, values: impl IntoIterator<Item = u64>) -> Self {
        values.into_iter().for_each(|x| self.bytes(&x.to_le_bytes()));
        self
    }

    /// Counts, in order, as wide on every machine.
    pub fn sizes(self, values: impl IntoIterator<Item = usize>) -> Self {
        self.u64s(values.into_iter().map(|x| x as u64))
    }

    /// Numbers, in order, of which NaN is one, whatever its bits are on a machine.
    pub fn numbers(self, values: impl IntoIterator<Item = f64>) -> Self {
        self.f64s(values.into_iter().map(|x| if x.is_nan() { f64::NAN } else { x }))
    }

    /// The hash.
    pub fn end(self) -> u64 {
        self.0
    }
}

impl Default for Hash {
    fn default() -> Self {
        Self::new()
    }
}
