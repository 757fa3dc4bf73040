//! How a machine computes products, and which of the ways it has.

/// How the f32 products are computed; all give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Array code with a fused multiply-add in software.
    Plain,
    /// AVX2 and FMA: tiles of 6 x 16.
    Avx2,
    /// AVX-512F: tiles of 6 x 64.
    Avx512,
    /// NEON of aarch64: tiles of 6 x 16.
    Neon,
}

impl Path {
    /// Every path, plain first.
    pub const ALL: [Path; 4] = [Path::Plain, Path::Avx2, Path::Avx512, Path::Neon];

    /// Whether this machine can run it.
    pub fn is_available(self) -> bool {
        match self {
            Path::Plain => true,
            #[cfg(target_arch = "x86_64")]
            Path::Avx2 | Path::Avx512 => has(self),
            Path::Neon => cfg!(all(target_arch = "aarch64", target_feature = "neon")),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The fastest path of this machine.
    pub fn best() -> Path {
        *Path::ALL.iter().rev().find(|path| path.is_available()).unwrap_or(&Path::Plain)
    }
}

/// Whether the machine and its system support the instructions of `path`.
#[cfg(target_arch = "x86_64")]
pub(super) fn has(path: Path) -> bool {
    cpufeatures::new!(avx2, "avx2", "fma");
    cpufeatures::new!(avx512, "avx512f");
    match path {
        Path::Plain => true,
        Path::Avx2 => avx2::get(),
        Path::Avx512 => avx512::get(),
        _ => false,
    }
}
