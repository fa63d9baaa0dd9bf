//! Where the letters of a line begin.
//!
//! In: a line, a font, and the gap between letters, in units of which a letter's square has 255. Out: the place of each
//! letter's square, and the width of all. Source: the three ways of Radiance's reference manual ("Brighttext"), to the
//! unit as its library has them. A letter that the font does not have takes no room.

use super::font::Font;

/// Spaces after a letter, with it, from which words are aligned anew.
const INDENT: usize = 3;

/// A line of letters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Line {
    pub codes: Vec<u8>,
    /// Of each letter's square.
    pub starts: Vec<i64>,
    pub width: i64,
}

impl Line {
    /// Letters at equal distances for gap 0; above 0, spaced by what they are wide but aligned with those of other lines; below 0,
    /// by what they are wide alone.
    pub(super) fn new(codes: &[u8], font: &Font, gap: i64) -> Line {
        let advances = match gap {
            0 => even(codes, font),
            1.. => aligned(codes, font, gap),
            _ => squeezed(codes, font, -gap),
        };
        let mut at = 0;
        let mut starts: Vec<i64> = advances
            .iter()
            .map(|advance| {
                at += advance;
                at
            })
            .collect();
        let width = starts.pop().unwrap_or(0);
        Line { codes: codes.to_vec(), starts, width }
    }
}

/// From the beginning to the first letter, from letter to letter, and from the last one to the end; so it is in all.
fn even(codes: &[u8], font: &Font) -> Vec<i64> {
    let squares = codes.iter().map(|&code| if font.letter(code).is_some() { 255 } else { 0 });
    std::iter::once(0).chain(squares).collect()
}

fn squeezed(codes: &[u8], font: &Font, gap: i64) -> Vec<i64> {
    let half = gap / 2;
    let mut advances = Vec::with_capacity(codes.len() + 1);
    let (mut pending, mut begun) = (half, false);
    for &code in codes {
        let letter = font.letter(code);
        let (advance, then) = match letter {
            None if !begun => (0, pending),
            None => (pending, 0),
            Some(letter) if letter.is_space() => (pending, font.mean_width),
            Some(letter) => (pending + half - i64::from(letter.x[0]), i64::from(letter.x[1]) + half),
        };
        begun |= letter.is_some();
        advances.push(advance);
        pending = then;
    }
    advances.push(pending + half);
    advances
}

fn aligned(codes: &[u8], font: &Font, gap: i64) -> Vec<i64> {
    let mut advances = squeezed(codes, font, gap);
    let is_space = |k: usize| codes.get(k).and_then(|&code| font.letter(code)).is_some_and(|l| l.is_space());
    let mut first = 0;
    while first < codes.len() {
        // Up to a long gap, or the end.
        let (mut end, mut n_counted) = (first, 0);
        while end < codes.len() {
            let begin = end;
            end += 1;
            if font.letter(codes[begin]).is_some() {
                while is_space(end) {
                    end += 1;
                }
                n_counted += end - begin;
            }
            if end - begin > INDENT {
                break;
            }
        }
        let some = &mut advances[first + 1..=end];
        let mut missing = n_counted as i64 * (font.mean_width + gap) - some.iter().sum::<i64>();
        for k in 0..some.len() {
            let share = missing / (some.len() - k) as i64;
            some[k] += share;
            missing -= share;
        }
        first = end;
    }
    advances
}
