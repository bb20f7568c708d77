//! Numbers as a reader wants them: three significant digits and the unit that fits.

/// Stands for a figure that was not measured or has no value.
pub(crate) const MISSING: &str = "–";

/// Three significant digits, such as `0.0123`, `4.56`, `789`, `1.2e-5`; `–` when absent.
pub(crate) fn figure(value: impl Into<Option<f64>>) -> String {
    match value.into() {
        Some(value) if value.is_finite() => significant(value),
        Some(value) if value.is_infinite() => if value > 0.0 { "∞" } else { "−∞" }.to_owned(),
        _ => MISSING.to_owned(),
    }
}

/// A time given in ms, in the unit that fits: `1.23 s`, `45.6 ms`, `7.89 µs`, `12 ns`.
pub(crate) fn time(ms: impl Into<Option<f64>>) -> String {
    let Some(ms) = ms.into().filter(|ms| ms.is_finite()) else { return MISSING.to_owned() };
    // the unit is chosen after rounding, so that 999.9 µs becomes 1.00 ms
    let units = [("s", 1e-3), ("ms", 1.0), ("µs", 1e3)];
    match units.iter().find(|(_, scale)| (ms * scale).abs() >= 0.9995) {
        Some((unit, scale)) => format!("{} {unit}", significant(ms * scale)),
        None if ms == 0.0 => "0 ms".to_owned(),
        None => format!("{} ns", significant(ms * 1e6)),
    }
}

/// A relative error: `12.3 %` down to a thousandth, `4.56e-5` below.
pub(crate) fn error(share: impl Into<Option<f64>>) -> String {
    match share.into() {
        Some(share) if share.is_finite() && share.abs() >= 9.995e-4 => {
            format!("{} %", significant(100.0 * share))
        }
        share => figure(share),
    }
}

/// A ratio: `2.41 ×`.
pub(crate) fn ratio(value: impl Into<Option<f64>>) -> String {
    match value.into() {
        Some(value) if value.is_finite() => format!("{} ×", significant(value)),
        value => figure(value),
    }
}

/// A count in groups of three digits: `1 234 567`.
pub(crate) fn count(value: impl Into<Option<u64>>) -> String {
    let Some(value) = value.into() else { return MISSING.to_owned() };
    let digits = value.to_string();
    let mut grouped = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place) % 3 == 0 {
            // narrow no-break space
            grouped.push('\u{202f}');
        }
        grouped.push(digit);
    }
    grouped
}

/// Memory in binary units: `512 B`, `1.50 MiB`.
pub(crate) fn bytes(value: impl Into<Option<u64>>) -> String {
    let Some(value) = value.into() else { return MISSING.to_owned() };
    let units = [("GiB", 30), ("MiB", 20), ("KiB", 10)];
    match units.iter().find(|(_, shift)| value >> shift > 0) {
        Some((unit, shift)) => format!("{} {unit}", significant(value as f64 / (1_u64 << shift) as f64)),
        None => format!("{value} B"),
    }
}

/// Three significant digits of a finite number; powers of ten outside 10⁻³ … 10⁶.
fn significant(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    // rounding first settles the exponent: 9.999 is 10.0
    let rounded = format!("{value:.2e}");
    let exponent: i32 = rounded.split('e').nth(1).and_then(|digits| digits.parse().ok()).unwrap_or_default();
    match exponent {
        -3..=2 => format!("{value:.*}", (2 - exponent).unsigned_abs() as usize),
        3..=5 => format!("{value:.0}"),
        _ => rounded,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_survive() {
        let shown = [0.0, 0.00123456, 0.5, 9.999, 12.345, 999.9, 1234.5, 1e6, 1.2345e-5, -2.0].map(figure);
        assert_eq!(
            shown,
            ["0", "0.00123", "0.500", "10.0", "12.3", "1000", "1234", "1.00e6", "1.23e-5", "-2.00"]
        );
        assert_eq!([figure(None), figure(f64::NAN), figure(f64::INFINITY)], ["–", "–", "∞"]);
    }

    #[test]
    fn times_choose_their_unit() {
        let shown = [2500.0, 999.9, 16.6667, 0.9999, 0.0123, 1e-4, 0.0].map(time);
        assert_eq!(shown, ["2.50 s", "1.00 s", "16.7 ms", "1.00 ms", "12.3 µs", "100 ns", "0 ms"]);
        assert_eq!(time(None), "–");
    }

    #[test]
    fn errors_are_percent_or_powers() {
        let shown = [1.5, 0.1234, 0.00123, 1e-4, 0.0, f64::INFINITY].map(error);
        assert_eq!(shown, ["150 %", "12.3 %", "0.123 %", "1.00e-4", "0", "∞"]);
    }

    #[test]
    fn counts_and_bytes() {
        let shown = [0, 999, 1000, 1234567].map(count);
        assert_eq!(shown, ["0", "999", "1\u{202f}000", "1\u{202f}234\u{202f}567"]);
        let shown = [0, 1023, 1024, 3 << 19, 5 << 30].map(bytes);
        assert_eq!(shown, ["0 B", "1023 B", "1.00 KiB", "1.50 MiB", "5.00 GiB"]);
        assert_eq!([count(None), bytes(None), ratio(None)], ["–", "–", "–"]);
        assert_eq!(ratio(2.414), "2.41 ×");
    }
}
