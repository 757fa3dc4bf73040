//! Measures OBJ files as `seamwright measure --json` does, with exposure from a file: the runner of judge_agreement.py.
//!
//! `measure_plain FILE.obj [RESOLUTION [EXPOSURE]]`, EXPOSURE being little-endian f32, one a vertex. Prints JSON; the time
//! of the measurement alone goes to the standard error.

use seamwright::figures::measure::measure;
use seamwright::figures::record::json;
use seamwright::figures::sampled::{SampledExposure, Weighting};
use seamwright_core::judge::measure::RESOLUTION;
use seamwright_tests::plain_obj::PlainObj;
use std::{env, fs, time::Instant};

fn main() {
    let args: Vec<String> = env::args().collect();
    let [path, rest @ ..] = &args[1..] else { panic!("measure_plain FILE.obj [RESOLUTION [EXPOSURE]]") };
    let resolution = rest.first().map_or(RESOLUTION, |r| r.parse().expect("a resolution"));
    let mesh = PlainObj::parse(&String::from_utf8_lossy(&fs::read(path).expect("the OBJ can be read")));
    let values: Option<Vec<f32>> = rest.get(1).map(|file| {
        let bytes = fs::read(file).expect("the exposure can be read");
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four bytes"))).collect()
    });
    let exposure = values.as_ref().map(|values| SampledExposure { values, weighting: Weighting::Uniform });
    let start = Instant::now();
    let record = measure(path, mesh.polygons(), exposure, resolution).expect("the mesh can be measured");
    eprintln!("{:.3} s", start.elapsed().as_secs_f64());
    println!("{}", json(&record));
}
