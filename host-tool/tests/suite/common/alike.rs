//! Outputs compared word by word: words must be the same, numbers must agree to a tenth and a rounding step,
//! probabilities below 1e-4 are all alike, bars and sparklines only have to be there.

const DRAWN: &str = "▁▂▃▄▅▆▇█▏▎▍▌▋▊▉";

/// Whether a word is part of a curve or a bar.
pub fn drawn(word: &str) -> bool {
    word.chars().all(|c| DRAWN.contains(c))
}

/// The number in a word such as `±0.25`, `(0.42°,` or `<1e-99`.
pub fn number(word: &str) -> Option<f64> {
    word.trim_matches(|c: char| "(),;:°±<%[]".contains(c)).trim_end_matches('.').parse().ok()
}

fn word(now: &str, then: &str) -> bool {
    match (number(now), number(then)) {
        _ if now == then => true,
        (Some(a), Some(b)) if a > 0.0 && b > 0.0 && a < 1e-4 && b < 1e-4 => true,
        (Some(a), Some(b)) => (a - b).abs() <= 0.1 * a.abs().max(b.abs()) + 0.02,
        _ => false,
    }
}

fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().filter(|word| !drawn(word)).collect()
}

/// Fails where the two texts differ by more than that.
pub fn assert_alike(name: &str, now: &str, then: &str) {
    let pairs = now.lines().zip(then.lines());
    for (now_line, then_line) in pairs {
        let (a, b) = (words(now_line), words(then_line));
        let same = a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| word(a, b));
        assert!(
            same,
            "{name}: now\n  {now_line}\nthen\n  {then_line}\nin\n{now}\n(IRONOUT_BLESS=1 writes it again)"
        );
    }
    assert_eq!(now.lines().count(), then.lines().count(), "{name}: another number of lines:\n{now}");
}
