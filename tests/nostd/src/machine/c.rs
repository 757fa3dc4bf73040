//! Start, output and end by the C library of a desktop. `unsafe` is here for its `main`, `write` and `exit`.

use core::panic::PanicInfo;

#[link(name = "c")]
unsafe extern "C" {
    fn exit(code: i32) -> !;
    fn write(file: i32, bytes: *const u8, count: usize) -> isize;
}

/// Prints `text`.
pub fn print(text: &[u8]) {
    // SAFETY: the bytes are there. What a closed output does not take is lost.
    unsafe { write(1, text.as_ptr(), text.len()) };
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    // SAFETY: ends the process; nothing runs after it.
    unsafe { exit(70) }
}

/// What the toolchain's ready-made core names for unwinding. With panic = "abort" nothing ever calls it.
// SAFETY: no other symbol of the program has this name.
#[unsafe(no_mangle)]
pub extern "C" fn rust_eh_personality() {}

/// See [`rust_eh_personality`].
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn _Unwind_Resume() {}

/// The process' start.
// SAFETY: `main` is C's name for it, and no other symbol has it.
#[unsafe(no_mangle)]
pub extern "C" fn main(_: i32, _: *const *const u8) -> i32 {
    crate::work()
}
