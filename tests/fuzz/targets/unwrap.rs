//! Core's pipeline on any mesh with any settings: an error, or a valid atlas; arrays of wrong lengths are errors too.
#![no_main]

use libfuzzer_sys::fuzz_target;
use seamwright_core::base::progress::Silent;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Serial;
use seamwright_core::pipeline::{Output, UnwrapError, unwrap, unwrap_need};
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_fuzz::bytes::Bytes;
use seamwright_fuzz::case::{Case, settings};
use seamwright_fuzz::check::{Made, valid};

/// Bytes of scratch beyond which a run is given up.
const MOST: usize = 1 << 28;

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = Bytes(bytes);
    let flags = bytes.byte();
    let settings = settings(&mut bytes, flags & 7 == 7);
    let mut case = Case::read(&mut bytes, usize::from(flags & 0x18 == 0x18));
    let mut made = Made::room(&case);
    let is_misfit = flags & 0xe0 == 0xe0;
    if is_misfit {
        misfit(flags, &mut case, &mut made);
    }
    let is_sound = !is_misfit && flags & 7 != 7;
    let mut need = unwrap_need(&case.input(), &settings, &BinnedBuilder);
    while need < MOST {
        let mut memory = vec![0xa5; need];
        let output = Output {
            corner_uv: &mut made.corner_uv,
            polygon_chart: &mut made.polygon_chart,
            exposure: &mut made.exposure,
        };
        let scratch = Scratch::new(&mut memory);
        match unwrap(output, &case.input(), &settings, &BinnedBuilder, scratch, &Serial, &mut Silent) {
            Ok(report) if is_sound => valid(&case, &made, &report, settings.weld),
            Err(UnwrapError::Scratch(e)) if e.need < MOST => {
                need *= 2;
                continue;
            }
            Err(UnwrapError::BadTree) => panic!("our own hierarchy is refused"),
            Err(UnwrapError::Overlap { faces }) => panic!("{faces} faces still overlap"),
            _ => {}
        }
        break;
    }
});

/// Makes one array longer or shorter than the others say, or its entries fall.
fn misfit(flags: u8, case: &mut Case, made: &mut Made) {
    match flags & 0x1f {
        0 => drop(made.corner_uv.pop()),
        1 => drop(made.polygon_chart.pop()),
        2 => drop(made.exposure.pop()),
        3 => drop(case.kept_uv.get_or_insert_default().pop()),
        4 => drop(case.parts.get_or_insert_default().pop()),
        5 => drop(case.polygon_start.pop()),
        6 => case.polygon_start.push(u32::MAX),
        7 => case.polygon_start.reverse(),
        8 => drop(case.polygon_start.remove(0)),
        9 => case.polygon_start.clear(),
        10 => drop(case.corners.pop()),
        11 => case.corners.push(0),
        12 => drop(case.positions.pop()),
        13 => made.corner_uv.push(glam::DVec2::ZERO),
        14 => made.polygon_chart.push(0),
        15 => made.exposure.push(0.0),
        _ => case.polygon_start.iter_mut().for_each(|start| *start = start.wrapping_sub(u32::from(flags & 15))),
    }
}
