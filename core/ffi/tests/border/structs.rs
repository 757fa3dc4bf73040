//! Structs of another age: a program that knows less than the library, or more.

use crate::call::{Call, bits};
use core::mem::offset_of;
use core::ptr::{null, without_provenance};
use seamwright_ffi::*;

/// A struct of a newer header.
#[repr(C)]
struct Newer<T> {
    known: T,
    more: [usize; 2],
}

#[test]
fn a_program_older_than_the_library_gets_what_it_asks_for() {
    let mut call = Call::cube();
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    let whole = bits(&call);
    // What stands behind a short struct is not its own.
    let normals = without_provenance(1);
    let older = offset_of!(SeamwrightMesh, corner_normals);
    call.mesh = SeamwrightMesh { struct_size: older, corner_normals: normals, tolerance: 1e9, ..call.mesh };
    let older = offset_of!(SeamwrightOptions, hard_edges);
    call.options = SeamwrightOptions { hard_edges: 77, prefer: 77, ..call.options };
    assert_eq!(unsafe { seamwright_defaults(&mut call.options, older) }, SEAMWRIGHT_OK);
    assert_eq!((call.options.struct_size, call.options.hard_edges, call.options.prefer), (older, 77, 77));
    let mut bytes = 0;
    assert_eq!(unsafe { seamwright_unwrap_scratch(&mut bytes, &call.mesh, &call.options) }, SEAMWRIGHT_OK);
    assert_eq!((call.run(), bytes), (SEAMWRIGHT_OK, call.scratch.len()));
    assert_eq!(bits(&call), whole);
    let shorter = SeamwrightMesh { struct_size: call.mesh.struct_size - size_of::<usize>(), ..call.mesh };
    let code = unsafe { seamwright_unwrap_scratch(&mut bytes, &shorter, &call.options) };
    assert_eq!(code, SEAMWRIGHT_BAD_STRUCT);
}

#[test]
fn figures_end_where_the_programs_struct_does() {
    let mut call = Call::cube();
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    let mut measure = |struct_size: usize| {
        let mut figures = SeamwrightFigures { struct_size, noticed_seam_length: 77.0, ..SeamwrightFigures::INIT };
        let (uv, exposure) = (call.uv.as_ptr(), call.exposure.as_ptr());
        let (scratch, bytes) = (call.scratch.as_mut_ptr(), call.scratch.len());
        let code = unsafe { seamwright_measure(&mut figures, &call.mesh, uv, exposure, 64, scratch, bytes) };
        (code, figures)
    };
    let (code, all) = measure(size_of::<SeamwrightFigures>());
    assert_eq!(code, SEAMWRIGHT_OK);
    let size = offset_of!(SeamwrightFigures, closed_or_handled_charts);
    let (code, some) = measure(size);
    assert_eq!((code, some.struct_size, some.noticed_seam_length), (SEAMWRIGHT_OK, size, 77.0));
    assert_eq!((some.seam_length, some.overlap), (all.seam_length, all.overlap));
    assert!(all.noticed_seam_length < 77.0);
    assert_eq!(measure(0).0, SEAMWRIGHT_BAD_STRUCT);
}

#[test]
fn a_program_newer_than_the_library_may_say_nothing_new() {
    fn newer<T>(known: T, more: [usize; 2]) -> Newer<T> {
        Newer { known, more }
    }
    let mut call = Call::cube();
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    let whole = bits(&call);
    let mut run = |new: [usize; 4]| {
        let mut atlas = newer(call.atlas(), [new[0], 0]);
        atlas.known.struct_size = size_of_val(&atlas);
        let mut mesh = newer(call.mesh, [0, new[1]]);
        mesh.known.struct_size = size_of_val(&mesh);
        let mut options = newer(call.options, [9, 9]);
        let size = size_of_val(&options);
        // The defaults of what the library does not know are zeros.
        assert_eq!(unsafe { seamwright_defaults((&raw mut options).cast(), size) }, SEAMWRIGHT_OK);
        assert_eq!((options.known.struct_size, options.more), (size, [0, 0]));
        options.more[0] = new[2];
        let mut host = newer(call.host, [0, new[3]]);
        host.known.struct_size = size_of_val(&host);
        let mut report = newer(SeamwrightReport::INIT, [77, 77]);
        report.known.struct_size = size_of_val(&report);
        let (scratch, bytes) = (call.scratch.as_mut_ptr(), call.scratch.len());
        let code = unsafe {
            seamwright_unwrap(
                (&raw const atlas).cast(),
                (&raw mut report).cast(),
                (&raw const mesh).cast(),
                (&raw const options).cast(),
                (&raw const host).cast(),
                scratch,
                bytes,
            )
        };
        assert_eq!((report.known.struct_size, report.more), (size_of_val(&report), [77, 77]));
        (code, report.known.detail)
    };
    assert_eq!(run([0; 4]), (SEAMWRIGHT_OK, 0));
    assert_eq!(run([1, 0, 0, 0]), (SEAMWRIGHT_NEWER_STRUCT, size_of::<SeamwrightAtlas>()));
    assert_eq!(run([0, 1, 0, 0]), (SEAMWRIGHT_NEWER_STRUCT, size_of::<SeamwrightMesh>()));
    assert_eq!(run([0, 0, 1, 0]), (SEAMWRIGHT_NEWER_STRUCT, size_of::<SeamwrightOptions>()));
    assert_eq!(run([0, 0, 0, 1]), (SEAMWRIGHT_NEWER_STRUCT, size_of::<SeamwrightHost>()));
    assert_eq!(bits(&call), whole);
    let (report, none) = (&raw mut call.report, null());
    let code =
        unsafe { seamwright_unwrap(none, report, &call.mesh, &call.options, null(), call.scratch.as_mut_ptr(), 0) };
    assert_eq!(code, SEAMWRIGHT_NULL);
}
