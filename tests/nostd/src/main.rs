//! A program without std, heap and unwinding that runs the golden meshes through core, in static memory.
//!
//! That it links is the proof that core needs neither: an `extern crate alloc` anywhere below would ask for an allocator,
//! an `extern crate std` would bring a second panic handler. `.ci/run` looks at its symbols and at what of it can panic too,
//! and builds it once with the feature `faults` to see both checks fail; `.ci/cross` builds it for other machines.
//! It prints the hashes (see the library), then lines that begin with # and differ between machines. Exit code 0: the runs
//! came to their end; 70: a panic. `machine` says how a program starts, prints and ends: by the C library on x86-64, by
//! system calls on other Linux machines, by exports in wasm, by semihosting on a Cortex-M.
//! `unsafe` is here for the memory, in `machine` for the machines' own.
#![no_std]
#![no_main]

#[cfg(feature = "faults")]
mod faults;
#[cfg_attr(target_arch = "wasm32", path = "machine/wasm.rs")]
#[cfg_attr(target_os = "none", path = "machine/cortex_m.rs")]
#[cfg_attr(all(target_os = "linux", target_arch = "x86_64"), path = "machine/c.rs")]
#[cfg_attr(all(target_os = "linux", not(target_arch = "x86_64")), path = "machine/linux.rs")]
mod machine;

use core::cell::UnsafeCell;
use core::fmt::{self, Write};
use core::hint::black_box;
use seamwright_core::base::workers::Serial;
use seamwright_core::learn::kernels::path::Path;
use seamwright_nostd::{MEMORY, SEED, run};

/// Core's working memory: it costs nothing in the file.
struct Memory(UnsafeCell<[u64; MEMORY / 8]>);
// SAFETY: the program has one thread.
unsafe impl Sync for Memory {}
static WORK: Memory = Memory(UnsafeCell::new([0; MEMORY / 8]));

/// Text of a known largest length.
struct Text {
    bytes: [u8; 1024],
    len: usize,
}

impl Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let to = self.bytes.get_mut(self.len..self.len + text.len()).ok_or(fmt::Error)?;
        to.iter_mut().zip(text.bytes()).for_each(|(to, byte)| *to = byte);
        self.len += text.len();
        Ok(())
    }
}

/// The runs, called once by the machine's start; answers the exit code.
fn work() -> i32 {
    // SAFETY: the only reference to the memory, taken once, of as many bytes.
    let memory = unsafe { core::slice::from_raw_parts_mut(WORK.0.get().cast::<u8>(), MEMORY) };
    let mut text = Text { bytes: [0; 1024], len: 0 };
    let path = Path::best();
    let code = match run(&mut text, black_box(SEED), memory, path, &Serial) {
        Ok(()) => 0,
        Err(failure) => writeln!(text, "# {failure}").map_or(2, |()| 1),
    };
    let noted = writeln!(text, "# products by the path {path:?}");
    #[cfg(feature = "faults")]
    faults::commit();
    machine::print(&text.bytes[..text.len]);
    if noted.is_ok() { code } else { 2 }
}
