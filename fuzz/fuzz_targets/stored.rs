//! What earlier runs left: the sums of a part of a run (a checkpoint), made of bytes as arrays of the right names.
#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use willis::internals::formats::{NamedArray, write_arrays};
use willis::internals::output::{read_part, write_part};

/// Which vessels of three are uncertain.
const UNCERTAIN: [bool; 3] = [true, false, true];

/// Numbers of one byte each: counts, powers of two, and what arithmetic does not like.
fn number(byte: u8) -> f64 {
    match byte {
        0xff => f64::NAN,
        0xfe => f64::INFINITY,
        0xfd => -1.0,
        0xfc => 1e300,
        0xfb => 0.5,
        0xc0..=0xfa => 2_f64.powi(i32::from(byte - 0xc0)),
        _ => f64::from(byte),
    }
}

/// The arrays of a part with the numbers and the lengths that the bytes say.
fn part(bytes: &[u8]) {
    let [samples, step, m, k, rest @ ..] = bytes else { return };
    let (m, k) = (usize::from(m % 5), usize::from(k % 9));
    let mut next = rest.iter().copied().chain(std::iter::repeat(0));
    let mut array = |name: &str, shape: &[usize]| NamedArray {
        name: name.to_owned(),
        shape: shape.to_vec(),
        values: next.by_ref().take(shape.iter().product()).map(number).collect(),
    };
    let run = NamedArray { name: "run".to_owned(), shape: vec![2], values: vec![number(*samples), number(*step)] };
    let all = [
        array("blocks", &[m, 2]),
        array("samples", &[m]),
        array("step", &[k]),
        array("trace", &[k, 2]),
        array("rho_G", &[m]),
        array("perfused", &[m]),
        array("residual", &[m]),
        array("likelihood", &[m, 3]),
        array("square", &[m, 3]),
        array("count", &[m, 3]),
    ];
    let mut packed = Cursor::new(Vec::new());
    write_arrays(&mut packed, std::iter::once(run).chain(all)).expect("packed");
    let Ok(read) = read_part(packed.get_ref(), UNCERTAIN.to_vec()) else { return };
    let mut again = Cursor::new(Vec::new());
    write_part(&mut again, &read).expect("written");
    let back = read_part(again.get_ref(), UNCERTAIN.to_vec()).expect("what was written is read");
    assert_eq!((back.samples(), back.done()), (read.samples(), read.done()));
    let _ = read.trace();
    let mut double = read;
    if double.samples() < 1 << 40 && double.samples() % 64 == 0 {
        double.double();
    }
}

fuzz_target!(|bytes: &[u8]| part(bytes));
