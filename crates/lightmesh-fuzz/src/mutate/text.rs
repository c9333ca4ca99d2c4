//! Changes of texts made of lines of words.

use std::ops::Range;

use fastrand::Rng;

use super::numbers;

/// Changes one thing: a word, or a line. `words` are those of the format.
pub(super) fn change(text: &mut Vec<u8>, words: &[&str], rng: &mut Rng) {
    match rng.u8(0..16) {
        0 => {
            let line = pick(rng, &lines(text));
            text.drain(line);
        }
        1 | 2 => {
            // A line once more, or often.
            let all = lines(text);
            let (from, to) = (pick(rng, &all), pick(rng, &all).start);
            let line = text[from].to_vec();
            let times = if rng.u8(0..16) == 0 { rng.usize(1..100) } else { 1 };
            let times = times.min(1 + 4096 / line.len().max(1));
            text.splice(to..to, line.repeat(times));
        }
        3 => super::bytes::change(text, rng),
        4 => {
            let word = pick(rng, &words_of(text));
            text.drain(word);
        }
        5 => {
            let all = words_of(text);
            let (from, to) = (pick(rng, &all), pick(rng, &all));
            let word = text[from].to_vec();
            text.splice(to, word);
        }
        6 => {
            let word = pick(rng, &words_of(text));
            text.splice(word, words[rng.usize(0..words.len())].bytes());
        }
        7 => {
            // One more word.
            let at = pick(rng, &words_of(text)).start;
            let new = if rng.bool() { numbers::text(rng) } else { words[rng.usize(0..words.len())].to_owned() };
            text.splice(at..at, format!("{new} ").into_bytes());
        }
        _ => {
            let is_number = |word: &Range<usize>| text[word.clone()].iter().any(u8::is_ascii_digit);
            let all: Vec<Range<usize>> = words_of(text).into_iter().filter(is_number).collect();
            let word = pick(rng, &all);
            text.splice(word, numbers::text(rng).into_bytes());
        }
    }
}

/// One of the ranges; an empty one where there is none.
fn pick(rng: &mut Rng, ranges: &[Range<usize>]) -> Range<usize> {
    if ranges.is_empty() { 0..0 } else { ranges[rng.usize(0..ranges.len())].clone() }
}

/// Lines with their ends.
fn lines(text: &[u8]) -> Vec<Range<usize>> {
    let mut start = 0;
    let line = |line: &[u8]| {
        let range = start..start + line.len();
        start = range.end;
        range
    };
    text.split_inclusive(|&b| b == b'\n').map(line).collect()
}

/// Words: what is between white space and slashes.
fn words_of(text: &[u8]) -> Vec<Range<usize>> {
    let mut start = 0;
    let word = |word: &[u8]| {
        let range = start..start + word.len();
        start = range.end + 1;
        range
    };
    text.split(|&b| b.is_ascii_whitespace() || b == b'/').map(word).filter(|word| !word.is_empty()).collect()
}
