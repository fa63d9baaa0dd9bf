//! The library for C programs; what each function does is said in `include/bsdftree.h`.
//!
//! In: pointers that the header's contract makes valid. Out: numbers, or a status with a message. No globals, no logic of its own.
//! A panic, which would be an error in this library, ends loading with `BSDFTREE_ERROR_INTERNAL`; queries have none.

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::slice;

use bsdftree::file::{self, FileError};
use bsdftree::xml::Strictness;
use bsdftree::{Band, Bsdf, Direction, Lobes, Sample};

/// `BSDFTREE_REPAIR`.
const REPAIR: c_uint = 1;
/// `BSDFTREE_SMOOTH`.
const SMOOTH: c_uint = 2;

/// `bsdftree_status`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All is well.
    Ok = 0,
    /// The file cannot be read.
    File = 1,
    /// It is no BSDF, or damaged.
    Format = 2,
    /// A NULL pointer, or a path that is not UTF-8.
    Argument = 3,
    /// An error in this library.
    Internal = 4,
}

/// `bsdftree_direction_sample`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct DirectionSample {
    exitant: Direction,
    pdf: f64,
    weight: f64,
}

impl From<Sample> for DirectionSample {
    fn from(sample: Sample) -> DirectionSample {
        DirectionSample { exitant: sample.exitant, pdf: sample.pdf, weight: sample.weight }
    }
}

/// Numbers that C passes for `bsdftree_lobes`; unknown ones are all lobes.
fn lobes(lobes: c_int) -> Lobes {
    match lobes {
        1 => Lobes::Reflection,
        2 => Lobes::Transmission,
        _ => Lobes::All,
    }
}

/// See the header.
#[unsafe(no_mangle)]
pub extern "C" fn bsdftree_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => panic!("a version without a zero"),
        };
    VERSION.as_ptr()
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_load(
    path: *const c_char,
    flags: c_uint,
    out: *mut *mut Bsdf,
    message: *mut c_char,
    size: usize,
) -> Status {
    // SAFETY: passed on to the caller.
    unsafe {
        finish(out, message, size, || {
            if path.is_null() {
                return Err((Status::Argument, "the path is NULL".to_owned()));
            }
            let path = CStr::from_ptr(path).to_str();
            let path = path.map_err(|e| (Status::Argument, format!("the path is not UTF-8: {e}")))?;
            file::read(path, strictness(flags)).map(|(bsdf, _)| ramped(bsdf, flags)).map_err(refused)
        })
    }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_load_memory(
    bytes: *const c_void,
    n_bytes: usize,
    flags: c_uint,
    out: *mut *mut Bsdf,
    message: *mut c_char,
    size: usize,
) -> Status {
    // SAFETY: passed on to the caller.
    unsafe {
        finish(out, message, size, || {
            if bytes.is_null() {
                return Err((Status::Argument, "the bytes are NULL".to_owned()));
            }
            let bytes = slice::from_raw_parts(bytes.cast(), n_bytes);
            file::read_bytes(bytes, strictness(flags)).map(|(bsdf, _)| ramped(bsdf, flags)).map_err(refused)
        })
    }
}

fn strictness(flags: c_uint) -> Strictness {
    if flags & REPAIR != 0 { Strictness::Repair } else { Strictness::Strict }
}

/// With ramps in the leaves of its trees, if that is wanted.
fn ramped(bsdf: Bsdf, flags: c_uint) -> Bsdf {
    let smooth = if flags & SMOOTH != 0 { bsdf.smooth() } else { None };
    smooth.unwrap_or(bsdf)
}

fn refused(error: FileError) -> (Status, String) {
    let status = if error.io().is_some() { Status::File } else { Status::Format };
    (status, error.to_string())
}

/// Gives the caller what was read, or says why there is nothing.
///
/// # Safety
/// `out` is NULL or may be written; `message` is NULL or has room for `size` bytes.
unsafe fn finish(
    out: *mut *mut Bsdf,
    message: *mut c_char,
    size: usize,
    read: impl FnOnce() -> Result<Bsdf, (Status, String)>,
) -> Status {
    // SAFETY: the function's contract.
    unsafe {
        if out.is_null() {
            tell("the place for the BSDF is NULL", message, size);
            return Status::Argument;
        }
        *out = std::ptr::null_mut();
        let read = catch_unwind(AssertUnwindSafe(read));
        let problem = match read {
            Ok(Ok(bsdf)) => {
                *out = Box::into_raw(Box::new(bsdf));
                tell("", message, size);
                return Status::Ok;
            }
            Ok(Err(problem)) => problem,
            Err(_) => (Status::Internal, "an error in bsdftree, please report it with the file".to_owned()),
        };
        tell(&problem.1, message, size);
        problem.0
    }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_verify(bsdf: *const Bsdf, message: *mut c_char, size: usize) -> Status {
    // SAFETY: the header's contract.
    unsafe {
        match (*bsdf).verify() {
            Ok(()) => {
                tell("", message, size);
                Status::Ok
            }
            Err(damage) => {
                tell(&damage.to_string(), message, size);
                Status::Format
            }
        }
    }
}

/// Copies as much of a text as there is room for, whole characters, ended by 0.
///
/// # Safety
/// `message` is NULL or has room for `size` bytes.
unsafe fn tell(text: &str, message: *mut c_char, size: usize) {
    if message.is_null() || size == 0 {
        return;
    }
    let most = text.len().min(size - 1);
    let length = (0..=most).rev().find(|&end| text.is_char_boundary(end)).unwrap_or(0);
    // SAFETY: there is room for `length` bytes and the zero.
    unsafe {
        std::ptr::copy_nonoverlapping(text.as_ptr().cast(), message, length);
        *message.add(length) = 0;
    }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers; `bsdf` is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_free(bsdf: *mut Bsdf) {
    if !bsdf.is_null() {
        // SAFETY: it came from `bsdftree_load`, and nobody uses it any more.
        drop(unsafe { Box::from_raw(bsdf) });
    }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_find_band(bsdf: *const Bsdf, name: *const c_char) -> *const Band {
    // SAFETY: the header's contract.
    let (bsdf, name) = unsafe { (&*bsdf, if name.is_null() { c"Visible" } else { CStr::from_ptr(name) }) };
    let band = name.to_str().ok().and_then(|name| bsdf.band(name));
    band.map_or(std::ptr::null(), std::ptr::from_ref)
}

/// A direction behind a pointer.
///
/// # Safety
/// Three numbers stand there.
unsafe fn direction(pointer: *const f64) -> Direction {
    // SAFETY: the function's contract.
    unsafe { pointer.cast::<Direction>().read() }
}

/// `n` things behind a pointer, which may be NULL if there are none.
///
/// # Safety
/// They stand there for as long as they are used.
unsafe fn many<'a, T>(pointer: *const T, n: usize) -> &'a [T] {
    // SAFETY: the function's contract.
    if n == 0 { &[] } else { unsafe { slice::from_raw_parts(pointer, n) } }
}

/// The same, to be written.
///
/// # Safety
/// As [`many`], and nobody else uses them meanwhile.
unsafe fn many_mut<'a, T>(pointer: *mut T, n: usize) -> &'a mut [T] {
    // SAFETY: the function's contract.
    if n == 0 { &mut [] } else { unsafe { slice::from_raw_parts_mut(pointer, n) } }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_eval(band: *const Band, incident: *const f64, exitant: *const f64) -> f64 {
    // SAFETY: the header's contract.
    unsafe { (*band).eval(direction(incident), direction(exitant)) }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_eval_xyz(
    band: *const Band,
    incident: *const f64,
    exitant: *const f64,
    xyz: *mut f64,
) {
    // SAFETY: the header's contract.
    unsafe { xyz.cast::<[f64; 3]>().write((*band).eval_xyz(direction(incident), direction(exitant))) }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_sample(
    band: *const Band,
    incident: *const f64,
    u: f64,
    which: c_int,
) -> DirectionSample {
    // SAFETY: the header's contract.
    unsafe { (*band).sample(direction(incident), u, None, lobes(which)).into() }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_sample_2d(
    band: *const Band,
    incident: *const f64,
    uv: *const f64,
    which: c_int,
) -> DirectionSample {
    // SAFETY: the header's contract.
    unsafe { (*band).sample(direction(incident), *uv, Some(*uv.add(1)), lobes(which)).into() }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_pdf(
    band: *const Band,
    incident: *const f64,
    exitant: *const f64,
    which: c_int,
) -> f64 {
    // SAFETY: the header's contract.
    unsafe { (*band).pdf(direction(incident), direction(exitant), lobes(which)) }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_hemispherical(
    band: *const Band,
    incident: *const f64,
    which: c_int,
) -> f64 {
    // SAFETY: the header's contract.
    unsafe { (*band).hemispherical(direction(incident), lobes(which)) }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_projected_solid_angle(
    band: *const Band,
    incident: *const f64,
    exitant: *const f64,
) -> f64 {
    // SAFETY: the header's contract.
    unsafe { (*band).projected_solid_angle(direction(incident), direction(exitant)).unwrap_or(-1.0) }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_projected_solid_angle_range(
    band: *const Band,
    incident: *const f64,
    which: c_int,
    range: *mut f64,
) {
    // SAFETY: the header's contract.
    unsafe {
        let found = (*band).projected_solid_angle_range(direction(incident), lobes(which));
        range.cast::<[f64; 2]>().write(found.unwrap_or([-1.0; 2]));
    }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_eval_many(
    band: *const Band,
    n: usize,
    incident: *const Direction,
    exitant: *const Direction,
    values: *mut f64,
) {
    // SAFETY: the header's contract.
    unsafe { (*band).eval_many(many(incident, n), many(exitant, n), many_mut(values, n)) }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_pdf_many(
    band: *const Band,
    n: usize,
    incident: *const Direction,
    exitant: *const Direction,
    which: c_int,
    densities: *mut f64,
) {
    // SAFETY: the header's contract.
    unsafe { (*band).pdf_many(many(incident, n), many(exitant, n), lobes(which), many_mut(densities, n)) }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_hemispherical_many(
    band: *const Band,
    n: usize,
    incident: *const Direction,
    which: c_int,
    totals: *mut f64,
) {
    // SAFETY: the header's contract.
    unsafe { (*band).hemispherical_many(many(incident, n), lobes(which), many_mut(totals, n)) }
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_projected_solid_angle_many(
    band: *const Band,
    n: usize,
    incident: *const Direction,
    exitant: *const Direction,
    angles: *mut f64,
) {
    // SAFETY: the header's contract.
    let angles = unsafe {
        let angles = many_mut(angles, n);
        (*band).projected_solid_angle_many(many(incident, n), many(exitant, n), angles);
        angles
    };
    // As single calls have it.
    angles.iter_mut().filter(|angle| angle.is_nan()).for_each(|angle| *angle = -1.0);
}

/// See the header.
///
/// # Safety
/// As the header says of its pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bsdftree_sample_many(
    band: *const Band,
    n: usize,
    incident: *const Direction,
    u: *const f64,
    v: *const f64,
    which: c_int,
    samples: *mut DirectionSample,
) {
    /// At once, on the stack.
    const CHUNK: usize = 512;
    // SAFETY: the header's contract.
    let (band, incident, u, v, samples) = unsafe {
        let v = (!v.is_null()).then(|| many(v, n));
        (&*band, many(incident, n), many(u, n), v, many_mut(samples, n))
    };
    let mut some = [Sample { exitant: [0.0; 3], pdf: 0.0, weight: 0.0 }; CHUNK];
    for (index, samples) in samples.chunks_mut(CHUNK).enumerate() {
        let range = index * CHUNK..index * CHUNK + samples.len();
        let some = &mut some[..samples.len()];
        let v = v.map(|v| &v[range.clone()]);
        band.sample_many(&incident[range.clone()], &u[range], v, lobes(which), some);
        samples.iter_mut().zip(some).for_each(|(sample, found)| *sample = (*found).into());
    }
}
