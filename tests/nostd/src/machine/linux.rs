//! Start, output and end by Linux' system calls, without any library: aarch64, arm, x86, s390x.
//!
//! `unsafe` is here for the instructions that call the system and for the start, which has no stack frame yet.

use core::arch::{asm, global_asm};
use core::panic::PanicInfo;

// The stack is aligned as functions expect it on each machine; the frame pointer's end is left to the system's zeros.
#[cfg(target_arch = "aarch64")]
global_asm!(".globl _start", "_start: bl {begin}", begin = sym begin);
#[cfg(target_arch = "arm")]
global_asm!(".globl _start", "_start: bic sp, sp, #7", "bl {begin}", begin = sym begin);
#[cfg(target_arch = "x86")]
global_asm!(".globl _start", "_start: and esp, -16", "call {begin}", begin = sym begin);
// A caller leaves 160 bytes for what it calls.
#[cfg(target_arch = "s390x")]
global_asm!(".globl _start", "_start: aghi %r15, -160", "brasl %r14, {begin}", begin = sym begin);

/// write(1, address, count) or exit(code).
fn call(number: usize, a: usize, b: usize, c: usize) {
    // SAFETY: the two calls below read what they are given and nothing else.
    unsafe {
        #[cfg(target_arch = "aarch64")]
        asm!("svc 0", in("x8") number, inlateout("x0") a => _, in("x1") b, in("x2") c, options(nostack));
        #[cfg(target_arch = "arm")]
        asm!("svc 0", in("r7") number, inlateout("r0") a => _, in("r1") b, in("r2") c, options(nostack));
        #[cfg(target_arch = "x86")]
        asm!("int 0x80", inlateout("eax") number => _, in("ebx") a, in("ecx") b, in("edx") c, options(nostack));
        #[cfg(target_arch = "s390x")]
        asm!("svc 0", in("r1") number, inlateout("r2") a => _, in("r3") b, in("r4") c, options(nostack));
    }
}

/// Numbers of `write` and `exit`.
const CALLS: [usize; 2] = if cfg!(target_arch = "aarch64") { [64, 93] } else { [4, 1] };

/// Prints `text`.
pub fn print(text: &[u8]) {
    call(CALLS[0], 1, text.as_ptr() as usize, text.len());
}

fn exit(code: i32) -> ! {
    call(CALLS[1], code as usize, 0, 0);
    loop {}
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    exit(70)
}

extern "C" fn begin() -> ! {
    exit(crate::work())
}
