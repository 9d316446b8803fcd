use super::*;

const A: [f64; 3] = [1.0, 2.0, 3.0];
const B: [f64; 3] = [4.0, f64::NAN, -2.0];

fn of(text: &str) -> Result<Vec<f64>, String> {
    let time = [0.0, 0.5, 1.0];
    let named =
        vec![("a", &A[..]), ("b", &B[..]), ("max_a", &A[..]), ("throttle", &A[..]), ("motor[0]", &A[..])];
    compute(text, &Columns { rows: 3, time_s: Some(&time), named }).map(|computed| computed.values)
}

fn first(text: &str) -> f64 {
    of(text).unwrap_or_else(|why| panic!("{text}: {why}"))[0]
}

#[test]
fn arithmetic_is_that_of_a_person() {
    let (a, b) = (1.0_f64, 4.0_f64);
    for (text, expected) in [
        ("a+b*2", a + b * 2.0),
        ("(a+b)*2", (a + b) * 2.0),
        ("b-a-1", b - a - 1.0),
        ("b-a+1", b - a + 1.0),
        ("a+b-1+2", a + b - 1.0 + 2.0),
        ("b/2/2", b / 2.0 / 2.0),
        ("b/2*3", b / 2.0 * 3.0),
        ("3*b/2", 3.0 * b / 2.0),
        ("-b^2", -(b * b)),
        ("a-b^2", a - b * b),
        ("2*-b^2", -2.0 * b * b),
        ("2/-b^2", -2.0 / (b * b)),
        ("a--b", a + b),
        ("a+-b", a - b),
        ("+b", b),
        ("b^-1", 0.25),
        ("2^-b", 0.0625),
        ("b**0.5", 2.0),
        ("(-b)^2", 16.0),
        ("(2^3)^2+0*a", 64.0),
        ("2^(3^2)*a", 512.0),
        ("sin(b)^2+cos(b)^2", 1.0),
        ("-sin(b)^2", -(b.sin().powi(2))),
        ("sqrt(b)*exp(ln(a+1))", 4.0),
        ("abs(-b)", 4.0),
        ("min(a, b, 0.5)", 0.5),
        ("max(a, min(b, 2*(1+b)))", 4.0),
        ("max(a,b)^2", 16.0),
        ("2*atan2(b, a)", 2.0 * b.atan2(a)),
        ("1.5e-3*b", 0.006),
        ("pi*a+e*0", std::f64::consts::PI),
        ("max_a+{motor[0]}", 2.0),
        ("t_s+a", 1.0),
        ("throttle^1.5*b", 4.0),
        ("a ^ 2 * b ^ 2", 16.0),
        ("a^2-b^2", -15.0),
    ] {
        let value = first(text);
        assert!((value - expected).abs() < 1e-12, "{text}: {value} against {expected}");
    }
}

#[test]
fn what_is_missing_stays_missing() {
    for text in ["b*2", "min(a, b)", "max(b, a)", "a+0*b", "abs(b)", "prev(diff(t_s))*b"] {
        assert!(of(text).expect(text)[1].is_nan(), "{text}");
    }
    let text = format!("{:?} {:?}", of("diff(a)"), of("prev(a*2)+0"));
    assert_eq!(text, "Ok([NaN, 1.0, 1.0]) Ok([NaN, 2.0, 4.0])");
    let named = vec![("b", &B[..])];
    let computed = compute("sqrt(b)", &Columns { rows: 3, time_s: None, named }).expect("valid");
    assert_eq!((computed.without_value, computed.values[0]), (1, 2.0));
    assert!(computed.values[2].is_nan());
}

#[test]
fn what_cannot_be_read_is_said() {
    for (text, word) in [
        ("throtle^2", "Did you mean throttle?"),
        ("Throttle", "Did you mean throttle?"),
        ("zzzzzz", "the columns are t_s, a, b"),
        ("sinn(a)", "Did you mean sin"),
        ("sin", "is a function"),
        ("a^2^3", "two ways"),
        ("a b", "missing"),
        ("a 2", "missing"),
        ("a+", "missing"),
        ("*a", "no value before"),
        ("a+*b", "no value before"),
        ("(a", "not closed"),
        ("a)", "has no opening"),
        ("max(a", "not closed"),
        ("max(a)", "write max(a, b)"),
        ("diff(a,b)", "write diff(x)"),
        ("diff()", "empty"),
        ("lowpass(a, b)", "a number above 0"),
        ("lowpass(a, 0)", "a number above 0"),
        ("a,b", "comma"),
        ("1+2", "no column"),
        ("a;b", "no meaning"),
        ("1.2.3*a", "is not a number"),
        ("()", "missing"),
        ("sin()", "missing"),
        ("{}", "no column"),
    ] {
        let why = of(text).expect_err(text);
        assert!(why.contains(word), "{text}: {why}");
    }
    let named = vec![("a", &A[..])];
    let without = compute("lowpass(a, 1)", &Columns { rows: 3, time_s: None, named });
    assert!(without.expect_err("no time").contains("no time column"));
}

/// Anything typed is an answer or an error, and never a panic.
#[test]
fn any_words_in_any_order_are_survived() {
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};
    const WORDS: [&str; 24] = [
        "a", "b", "t_s", "2", ".5", "1e3", "+", "-", "*", "/", "^", "(", ")", ",", "sin(", "max(", "diff(",
        "lowpass(", "{", "}", "pi", "é", " ", "atan2",
    ];
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut read = 0;
    for _ in 0..20_000 {
        let text: String =
            (0..rng.random_range(1..12)).map(|_| WORDS[rng.random_range(0..WORDS.len())]).collect();
        if let Ok(values) = of(&text) {
            assert_eq!(values.len(), 3);
            read += 1;
        }
    }
    assert!(read > 100, "{read} of them can be read");
}
