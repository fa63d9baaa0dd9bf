//! The wavelengths at which a path knows its light.
//!
//! 136 of them: steps of 10 nm from 300 nm on, of 5 nm from 380 nm, of 20 nm from 780 nm, of 50 nm from 1200 to 2500 nm.
//!
//! How many, as measured by `cargo test -p bsdftree-generate spectra -- --nocapture`, on edges and bands and products of two and four of them, against sums
//! over all lines of the tables: X, Y, Z come out right within 2e-5 where flanks are 20 nm wide, within 4e-6 where they are 100 nm wide; sunlight
//! within 4e-3 and 1e-4, flanks beyond the visible range being three times as wide. Steps of 10 nm in the visible range would do ten times worse,
//! and what is published of glass is in steps of 5 nm.

/// How many wavelengths.
pub(crate) const N: usize = 136;

/// Neighbours that are one where whole spectra would be too much: each has the light of so many wavelengths.
pub(crate) const GROUP: usize = 8;

/// Such groups.
pub(crate) const N_GROUPS: usize = N / GROUP;

/// The range that CIE's observer sees \[nm\].
pub const VISIBLE_NM: [f64; 2] = [380.0, 780.0];

/// First wavelength of a piece \[nm\], and its step; the last one has but its first.
const PIECES: [(f64, f64); 5] = [(300.0, 10.0), (380.0, 5.0), (780.0, 20.0), (1200.0, 50.0), (2500.0, 1.0)];

/// The wavelengths \[nm\].
pub(crate) const fn wavelengths_nm() -> [f64; N] {
    let mut nm = [PIECES[4].0; N];
    let (mut k, mut piece) = (0, 0);
    let mut next = PIECES[0].0;
    while piece < 4 {
        while next < PIECES[piece + 1].0 {
            nm[k] = next;
            next += PIECES[piece].1;
            k += 1;
        }
        piece += 1;
    }
    assert!(k == N - 1);
    nm
}

const NM: [f64; N] = wavelengths_nm();

/// Between which wavelengths one lies, as the number of the lower one, and how far on the way to the upper one, in 0..=1. Beyond the ends,
/// at the end.
pub(super) fn place(nm: f64) -> (usize, f64) {
    let lower = NM.partition_point(|&wavelength| wavelength <= nm).clamp(1, N - 1) - 1;
    (lower, ((nm - NM[lower]) / (NM[lower + 1] - NM[lower])).clamp(0.0, 1.0))
}

/// Four wavelengths around one, as the number of the first, and the shares that a cubic through values there takes of each. All four are
/// in steps of one size: cubics over unequal steps swing.
pub(super) fn cubic(nm: f64) -> (usize, [f64; 4]) {
    let lower = place(nm).0;
    let number = |wavelength: f64| NM.partition_point(|&other| other < wavelength);
    let next = (1..PIECES.len() - 1).find(|&k| NM[lower] < PIECES[k].0).unwrap_or(PIECES.len() - 1);
    let (begin, end) = (number(PIECES[next - 1].0), number(PIECES[next].0));
    let first = lower.saturating_sub(1).clamp(begin, end - 3);
    let around = &NM[first..first + 4];
    let share = |k: usize| -> f64 {
        (0..4).filter(|&j| j != k).map(|j| (nm - around[j]) / (around[k] - around[j])).product()
    };
    (first, [0, 1, 2, 3].map(share))
}
