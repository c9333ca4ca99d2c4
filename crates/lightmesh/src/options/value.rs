//! Values of options as a user gives them, and what each option may be.

use std::fmt;

/// A value of an option: as it was given, or as the option holds it.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number.
    Whole(u64),
    /// A real one.
    Real(f64),
    /// A word, a list, or what has a syntax of its own: `1/80`, `640x360`, `4GiB`.
    Text(String),
}

impl Value {
    /// A real number of single precision.
    pub fn single(x: f32) -> Self {
        Self::Real(f64::from(x))
    }

    /// A text.
    pub fn text(text: impl fmt::Display) -> Self {
        Self::Text(text.to_string())
    }

    /// Returns the whole number; 0 for any other value.
    pub fn whole(&self) -> u64 {
        if let Self::Whole(n) = self { *n } else { 0 }
    }

    /// Returns the real number in single precision; 0 for any other value.
    pub fn real(&self) -> f32 {
        if let Self::Real(x) = self { *x as f32 } else { 0.0 }
    }

    /// Returns the text; an empty one for any other value.
    pub fn as_text(&self) -> &str {
        if let Self::Text(text) = self { text } else { "" }
    }

    /// Returns it as messages show it: texts in quotes.
    fn quoted(&self) -> String {
        if let Self::Text(text) = self { format!("{text:?}") } else { self.to_string() }
    }
}

/// As a user spells it, numbers that came from single precision with its digits.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(n) => write!(f, "{n}"),
            Self::Real(x) if f64::from(*x as f32) == *x => write!(f, "{}", *x as f32),
            Self::Real(x) => write!(f, "{x}"),
            Self::Text(text) => f.write_str(text),
        }
    }
}

/// Says what a text should have been: `must be metres above 0, …`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("must be {0}")]
pub struct Expected(pub &'static str);

/// Which real numbers an option may be; all are finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Any.
    Any,
    /// Above 0.
    Positive,
    /// 0 or more.
    NotNegative,
    /// 0 or more, and below 1.
    Fraction,
}

impl Range {
    fn holds(self, x: f32) -> bool {
        x.is_finite()
            && match self {
                Self::Any => true,
                Self::Positive => x > 0.0,
                Self::NotNegative => x >= 0.0,
                Self::Fraction => (0.0..1.0).contains(&x),
            }
    }

    fn expected(self) -> &'static str {
        match self {
            Self::Any => "a number",
            Self::Positive => "above 0",
            Self::NotNegative => "0 or more",
            Self::Fraction => "at least 0 and below 1",
        }
    }
}

/// A word that an option may be, and one line about it.
pub type Word = (&'static str, &'static str);

/// The type and the range of an option.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A whole number from the first to the second.
    Whole(u64, u64),
    /// A finite real number, of single precision.
    Real(Range),
    /// One of these words, or an alias of one.
    Word {
        /// The words.
        words: &'static [Word],
        /// Other spellings, and the words that they stand for.
        aliases: &'static [Word],
    },
    /// Some of these words, separated by commas; none are an empty text.
    Words(&'static [Word]),
    /// Two whole numbers, as in 640x360.
    Size,
    /// A text with a syntax of its own.
    Syntax {
        /// Returns the text as the option itself spells its value; `None` if it is none.
        normal: fn(&str) -> Option<String>,
        /// What it must be, in words.
        expected: &'static str,
        /// Whether a number is a value, too.
        numbers: bool,
    },
}

impl Kind {
    /// Returns a value as the option holds it.
    ///
    /// # Errors
    /// One sentence without the option's name, if it is outside the range or of another type.
    pub fn read(&self, given: &Value) -> Result<Value, String> {
        match self {
            Self::Whole(min, max) => {
                let whole = match given {
                    Value::Whole(n) => Some(*n),
                    Value::Text(text) => text.parse().ok(),
                    Value::Real(_) => None,
                };
                whole.filter(|n| (min..=max).contains(&n)).map(Value::Whole)
            }
            Self::Real(range) => {
                let single = match given {
                    Value::Whole(n) => Some(*n as f32),
                    Value::Real(x) => Some(*x as f32),
                    Value::Text(text) => text.parse().ok(),
                };
                single.filter(|&x| range.holds(x)).map(Value::single)
            }
            Self::Word { words, aliases } => {
                let text = given.as_text();
                let own = aliases.iter().find(|(alias, _)| *alias == text).map_or(text, |(_, own)| own);
                words.iter().find(|(word, _)| *word == own).map(|(word, _)| Value::text(word))
            }
            Self::Words(words) => {
                let text = given.as_text().trim();
                let mut unknown = text.split(',').filter(|word| !text.is_empty() && !known(words, word.trim()));
                if let (Some(word), Value::Text(_)) = (unknown.next(), given) {
                    return Err(self.refusal(&Value::text(word.trim())));
                }
                let list: Vec<&str> = text.split(',').map(str::trim).filter(|word| !word.is_empty()).collect();
                Some(Value::Text(list.join(","))).filter(|_| matches!(given, Value::Text(_)))
            }
            Self::Size => {
                let size = super::PictureOptions::parse_size(given.as_text());
                size.map(|(width, height)| Value::Text(format!("{width}x{height}")))
            }
            Self::Syntax { normal, numbers, .. } => {
                let is_text = matches!(given, Value::Text(_));
                (is_text || *numbers).then(|| normal(&given.to_string())).flatten().map(Value::Text)
            }
        }
        .ok_or_else(|| self.refusal(given))
    }

    /// Returns what it may be, as the words after "must be".
    pub fn expected(&self) -> String {
        match self {
            Self::Whole(0, u64::MAX) => "0 or more".to_owned(),
            Self::Whole(0, max) => format!("at most {max}"),
            Self::Whole(min, max) => format!("between {min} and {max}"),
            Self::Real(range) => range.expected().to_owned(),
            Self::Word { words, .. } => format!("one of {}", either(words)),
            Self::Words(words) => format!("among {}", either(words)),
            Self::Size => super::PictureOptions::EXPECTED_SIZE.to_owned(),
            Self::Syntax { expected, .. } => (*expected).to_owned(),
        }
    }

    fn refusal(&self, given: &Value) -> String {
        let kind = match (self, given) {
            (Self::Whole(..), Value::Real(_) | Value::Text(_)) => "a whole number ",
            (Self::Real(Range::Positive | Range::NotNegative | Range::Fraction), Value::Text(_)) => "a number ",
            _ => "",
        };
        let suggestion = match (self, given) {
            (Self::Word { words, .. } | Self::Words(words), Value::Text(text)) => {
                closest(text, words.iter().map(|(word, _)| *word))
            }
            _ => None,
        };
        let suggestion = suggestion.map_or(String::new(), |word| format!("; did you mean {word:?}?"));
        format!("must be {kind}{}, not {}{suggestion}", self.expected(), given.quoted())
    }
}

fn known(words: &[Word], text: &str) -> bool {
    words.iter().any(|(word, _)| *word == text)
}

/// Lists words: `a, b or c`.
fn either(words: &[Word]) -> String {
    let names: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.join(""),
    }
}

/// Returns the word that a user most likely meant: the one with the fewest changes of a letter, if those are at most a
/// third of its letters.
pub fn closest<'a>(text: &str, words: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let distances = words.into_iter().map(|word| (changes(text, word), word));
    let (distance, word) = distances.min_by_key(|(distance, _)| *distance)?;
    (3 * distance <= word.chars().count()).then_some(word)
}

/// Returns how many letters must be put in, taken out or replaced to make one word the other (Levenshtein's distance).
fn changes(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_count_letters() {
        for (a, b, n) in
            [("", "", 0), ("spacing", "spacing", 0), ("spcing", "spacing", 1), ("kitten", "sitting", 3), ("", "ab", 2)]
        {
            assert_eq!(changes(a, b), n, "{a} {b}");
            assert_eq!(changes(b, a), n, "{b} {a}");
        }
        assert_eq!(closest("spaceing", ["size", "spacing", "spp"]), Some("spacing"));
        assert_eq!(closest("speed", ["size", "spacing", "seed"]), Some("seed"));
        assert_eq!(closest("colour", ["size", "spacing"]), None);
    }

    #[test]
    fn refusals_say_the_range_and_the_value() {
        let message = |kind: Kind, value| kind.read(&value).expect_err("outside");
        let whole = Kind::Whole(1, 65536);
        assert_eq!(message(whole, Value::Whole(0)), "must be between 1 and 65536, not 0");
        assert_eq!(message(whole, Value::Real(2.5)), "must be a whole number between 1 and 65536, not 2.5");
        assert_eq!(message(whole, Value::text("x")), "must be a whole number between 1 and 65536, not \"x\"");
        assert_eq!(message(Kind::Real(Range::Fraction), Value::Whole(1)), "must be at least 0 and below 1, not 1");
        let words = Kind::Word { words: &[("mesh", ""), ("path", "")], aliases: &[("truth", "path")] };
        assert_eq!(message(words, Value::text("mehs")), "must be one of mesh or path, not \"mehs\"");
        assert_eq!(
            message(words, Value::text("pat")),
            "must be one of mesh or path, not \"pat\"; did you mean \"path\"?"
        );
        assert_eq!(words.read(&Value::text("truth")), Ok(Value::text("path")));
        let list = Kind::Words(&[("depth", ""), ("normal", "")]);
        assert_eq!(list.read(&Value::text("")), Ok(Value::text("")));
        assert_eq!(list.read(&Value::text("normal, depth")), Ok(Value::text("normal,depth")));
        assert!(message(list, Value::text("depth,smell")).ends_with("not \"smell\""));
    }

    #[test]
    fn numbers_keep_the_digits_they_were_given_with() {
        for (value, text) in [(Value::single(0.001), "0.001"), (Value::Real(0.1), "0.1"), (Value::Whole(3), "3")] {
            assert_eq!(value.to_string(), text);
        }
    }
}
