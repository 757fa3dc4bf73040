//! The checked-in C header is the one that the definitions give.

use seamwright_tests::header;

#[test]
fn the_header_is_what_the_definitions_give() {
    let text = std::fs::read_to_string(header::path()).expect("core/ffi/include/seamwright.h");
    assert!(text == header::render(), "write it again: cargo run -p seamwright-tests --bin header");
}
