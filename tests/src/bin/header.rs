//! Writes core/ffi/include/seamwright.h again.

use seamwright_tests::header;
use std::{fs, io};

fn main() -> io::Result<()> {
    fs::write(header::path(), header::render())
}
