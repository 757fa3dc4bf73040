//! Start, output and end of a Cortex-M with a debugger or an emulator at its side, by semihosting.
//!
//! The stack's use is measured: the free memory below it is painted first, and what is not paint afterwards was used.
//! `unsafe` is here for the debugger's instruction and for the painting.

use core::arch::asm;
use core::fmt::{self, Write};
use core::panic::PanicInfo;
use cortex_m_rt::entry;

/// Operations of semihosting: write text that ends with a zero; end with a code.
const WRITE0: usize = 0x04;
const EXIT: usize = 0x20;
/// Reason of an ordinary end.
const STOPPED: usize = 0x20026;
/// What unused stack holds.
const PAINT: u32 = 0x5eed_5eed;

unsafe extern "C" {
    /// End of static memory, begin of what the stack may grow into (from cortex-m-rt's linker script).
    static mut __sheap: u32;
}

fn call(operation: usize, argument: usize) {
    // SAFETY: the debugger reads what `argument` points to.
    unsafe { asm!("bkpt 0xab", inlateout("r0") operation => _, in("r1") argument, options(nostack)) };
}

/// The debugger's terminal.
struct Terminal;

impl Write for Terminal {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        print(text.as_bytes());
        Ok(())
    }
}

/// Prints `text`.
pub fn print(text: &[u8]) {
    for part in text.chunks(63) {
        let mut ended = [0u8; 64];
        ended.iter_mut().zip(part).for_each(|(to, byte)| *to = *byte);
        call(WRITE0, ended.as_ptr() as usize);
    }
}

fn exit(code: i32) -> ! {
    let reason = [STOPPED, code as usize];
    call(EXIT, reason.as_ptr() as usize);
    loop {}
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    exit(70)
}

#[entry]
fn start() -> ! {
    let bottom = &raw mut __sheap;
    let here = [0u32; 1];
    // 256 bytes below this frame are left to the call in progress.
    let words = (here.as_ptr() as usize - bottom as usize) / 4 - 64;
    // SAFETY: nothing lives between the static memory and the stack.
    (0..words).for_each(|i| unsafe { bottom.add(i).write_volatile(PAINT) });
    let code = crate::work();
    // SAFETY: as above.
    let free = (0..words).take_while(|i| unsafe { bottom.add(*i).read_volatile() } == PAINT).count();
    let noted = writeln!(Terminal, "# stack {} bytes", 4 * (words - free) + 256);
    exit(if noted.is_ok() { code } else { 2 })
}
