//! One field of a table: a finite number, or the reason why it is none.

/// Why a field or row is of no use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reason {
    FieldCount,
    Empty,
    NotANumber,
    NotFinite,
}

impl Reason {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::FieldCount => "wrong number of fields",
            Self::Empty => "empty field",
            Self::NotANumber => "not a number",
            Self::NotFinite => "NaN or infinite",
        }
    }
}

/// The finite number that a field holds, rounded as `str::parse` rounds.
pub(super) fn number(field: &[u8], decimal_comma: bool) -> Result<f64, Reason> {
    if let Some(value) = short_decimal(field) {
        return Ok(value);
    }
    let field = field.trim_ascii();
    if field.is_empty() {
        return Err(Reason::Empty);
    }
    let text = std::str::from_utf8(field).map_err(|_| Reason::NotANumber)?;
    let value = if decimal_comma && text.contains(',') {
        text.replacen(',', ".", 1).parse::<f64>()
    } else {
        text.parse::<f64>()
    };
    match value {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(Reason::NotFinite),
        Err(_) => Err(Reason::NotANumber),
    }
}

/// Powers of ten that a double holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Numbers such as `-12.0625` or `8.8e-05`, twice as fast as `str::parse`; `None` for anything else.
///
/// With at most 15 digits and a power of ten up to 22, digits and power are exact doubles, so the one
/// product or quotient is correctly rounded (Clinger, "How to read floating point numbers accurately", 1990).
fn short_decimal(field: &[u8]) -> Option<f64> {
    let (negative, unsigned) = match field {
        [b'-', rest @ ..] => (true, rest),
        rest => (false, rest),
    };
    let (mut digits, mut count, mut point) = (0_u64, 0, None);
    let mut exponent = 0;
    for (i, &byte) in unsigned.iter().enumerate() {
        match byte {
            b'0'..=b'9' => {
                digits = digits * 10 + u64::from(byte - b'0');
                count += 1;
                if count > 15 {
                    return None;
                }
            }
            b'.' if point.is_none() => point = Some(count),
            b'e' | b'E' => {
                exponent = short_exponent(&unsigned[i + 1..])?;
                break;
            }
            _ => return None,
        }
    }
    if count == 0 {
        return None;
    }
    let exponent = exponent - point.map_or(0, |before| count - before);
    let power = POWERS.get(usize::try_from(exponent.abs()).ok()?)?;
    let value = if exponent < 0 { digits as f64 / power } else { digits as f64 * power };
    Some(if negative { -value } else { value })
}

/// An exponent of one or two digits.
fn short_exponent(text: &[u8]) -> Option<i32> {
    let (sign, digits) = match text {
        [b'-', rest @ ..] => (-1, rest),
        [b'+', rest @ ..] => (1, rest),
        rest => (1, rest),
    };
    let digit = |byte: u8| byte.is_ascii_digit().then(|| i32::from(byte - b'0'));
    match *digits {
        [one] => Some(sign * digit(one)?),
        [ten, one] => Some(sign * (10 * digit(ten)? + digit(one)?)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bits(text: &str) -> Option<u64> {
        number(text.as_bytes(), false).ok().map(f64::to_bits)
    }

    fn std_bits(text: &str) -> Option<u64> {
        text.trim_ascii().parse::<f64>().ok().filter(|x| x.is_finite()).map(f64::to_bits)
    }

    #[test]
    fn the_fast_path_takes_what_logs_hold() {
        for text in ["0", "-0", "-0.9584", "8.83614e-05", "20.9991", "1e3", "5.", ".5", "123456789012345E-22"]
        {
            assert_eq!(short_decimal(text.as_bytes()).map(f64::to_bits), std_bits(text), "{text}");
        }
        for text in
            ["", "-", ".", "e5", "1e", "1e+", "1e123", "1234567890123456", "1e23", "+1", " 1", "1.2.3", "1x"]
        {
            assert_eq!(short_decimal(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn reasons_are_told_apart() {
        let reason = |text: &[u8]| number(text, false).err();
        assert_eq!(reason(b" \t"), Some(Reason::Empty));
        assert_eq!(reason(b"12a"), Some(Reason::NotANumber));
        assert_eq!(reason(b"\xFF"), Some(Reason::NotANumber));
        assert_eq!(reason(b"1,5"), Some(Reason::NotANumber));
        assert_eq!(reason(b"-nan"), Some(Reason::NotFinite));
        assert_eq!(reason(b"1e309"), Some(Reason::NotFinite));
        assert_eq!(number(b"-1,5", true).map(f64::to_bits), Ok((-1.5_f64).to_bits()));
        assert_eq!(number(b"1,5,5", true), Err(Reason::NotANumber));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn every_number_is_rounded_as_by_the_standard_library(text in "[-+]?[0-9]{0,9}\\.?[0-9]{0,9}([eE][-+]?[0-9]{1,3})?") {
            prop_assert_eq!(bits(&text), std_bits(&text));
        }

        #[test]
        fn every_double_survives(x: f64) {
            for text in [format!("{x}"), format!("{x:e}"), format!("{x:.6}"), format!("{x:.5e}")] {
                prop_assert_eq!(bits(&text), std_bits(&text));
            }
        }

        #[test]
        fn anything_else_is_judged_alike(text in "[-+.eE0-9xnaif_ ]{0,8}") {
            prop_assert_eq!(bits(&text), std_bits(&text));
        }
    }
}
