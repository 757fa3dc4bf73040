//! How many parts, as asked.

use seamwright_core::parts::settings::{Count, PartSettings};

/// How many parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartsArg {
    /// No parts.
    Off,
    /// As many as the shape has.
    Auto,
    /// This many.
    Count(u32),
    /// By the published method with its published numbers.
    Published,
}

impl PartsArg {
    /// As core takes it; `None` for off.
    pub fn to_core(self, seed: u64) -> Option<PartSettings> {
        let count = match self {
            PartsArg::Off => return None,
            PartsArg::Auto => Count::Auto,
            PartsArg::Count(count) => Count::Exactly(count),
            PartsArg::Published => Count::PUBLISHED,
        };
        Some(PartSettings { count, seed })
    }

    /// As on the command line.
    pub fn name(self) -> String {
        match self {
            PartsArg::Off => "off".into(),
            PartsArg::Auto => "auto".into(),
            PartsArg::Count(count) => count.to_string(),
            PartsArg::Published => "published".into(),
        }
    }
}

pub(super) fn parts(word: &str) -> Result<PartsArg, String> {
    match word {
        "auto" => Ok(PartsArg::Auto),
        "published" => Ok(PartsArg::Published),
        _ => match word.parse::<u32>() {
            Ok(count) if count > 0 => Ok(PartsArg::Count(count)),
            _ => Err("write auto, published or a number of parts, 1 or more".into()),
        },
    }
}

pub(super) fn parts_or_off(word: &str) -> Result<PartsArg, String> {
    if word == "off" { Ok(PartsArg::Off) } else { parts(word).map_err(|e| e.replace("write ", "write off, ")) }
}
