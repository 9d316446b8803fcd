//! An expression over the columns of a log: arithmetic and functions, computed column by column, with missing cells.

use crate::derive::rows;
use crate::derive::tokens::{Token, tokens};
use ironout_analysis::similar;

/// Name and function of one value.
type Unary = (&'static str, fn(f64) -> f64);

/// Functions of one value.
const UNARY: [Unary; 24] = [
    ("abs", f64::abs),
    ("signum", f64::signum),
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("asinh", f64::asinh),
    ("acosh", f64::acosh),
    ("atanh", f64::atanh),
    ("floor", f64::floor),
    ("round", f64::round),
    ("ceil", f64::ceil),
    ("trunc", f64::trunc),
    ("exp", f64::exp),
    ("sqrt", f64::sqrt),
    ("cbrt", f64::cbrt),
    ("ln", f64::ln),
    ("log2", f64::log2),
    ("log10", f64::log10),
];
/// Functions of several values or rows.
const OTHERS: [&str; 8] = ["min", "max", "atan2", "prev", "next", "diff", "peak", "lowpass"];
/// Parentheses nested more deeply than this are a typing error.
const MAX_DEPTH: usize = 40;
/// Error of an expression or argument without a value.
const EMPTY: &str = "something is missing: an expression, or an argument of a function, is empty";

/// What an expression can read.
pub struct Columns<'a> {
    /// Rows of each column.
    pub rows: usize,
    /// Time, s, where the log has one.
    pub time_s: Option<&'a [f64]>,
    /// Name and values.
    pub named: Vec<(&'a str, &'a [f64])>,
}

/// A value a row, and how many rows have none although nothing in them is missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Computed {
    /// NaN where it is missing.
    pub values: Vec<f64>,
    /// Rows where the expression has no finite value (a root of a negative number).
    pub without_value: usize,
}

/// Computes an expression.
///
/// # Errors
/// What is wrong with it, and what to write instead.
pub fn compute(text: &str, columns: &Columns) -> Result<Computed, String> {
    let list = tokens(text)?;
    let mut parser = Parser {
        columns,
        list: &list,
        at: 0,
        depth: 0,
        has_column: false,
        without_value: vec![false; columns.rows],
    };
    if list.is_empty() {
        return Err(EMPTY.into());
    }
    let values = parser.sum()?;
    match parser.peek() {
        None => {}
        Some(Token::Mark(')')) => return Err("a parenthesis ) has no opening".into()),
        Some(Token::Mark(',')) => return Err("a comma is outside a function".into()),
        Some(_) => return Err("it cannot be read: an operator is missing between two values".into()),
    }
    if !parser.has_column {
        return Err("it reads no column of the log".into());
    }
    Ok(Computed { values, without_value: parser.without_value.iter().filter(|without| **without).count() })
}

/// Recursive descent: each method reads one level of precedence and computes one value per row.
struct Parser<'a> {
    columns: &'a Columns<'a>,
    list: &'a [Token],
    at: usize,
    depth: usize,
    /// Whether any column was read.
    has_column: bool,
    /// Rows where a function or an operator has no finite value although its arguments have.
    without_value: Vec<bool>,
}

impl<'a> Parser<'a> {
    fn peek(&self) -> Option<&'a Token> {
        self.list.get(self.at)
    }

    /// Reads one of these marks, if it is next.
    fn mark(&mut self, marks: &str) -> Option<char> {
        match self.peek() {
            Some(Token::Mark(mark)) if marks.contains(*mark) => {
                self.at += 1;
                Some(*mark)
            }
            _ => None,
        }
    }

    fn sum(&mut self) -> Result<Vec<f64>, String> {
        let mut total = self.product()?;
        while let Some(mark) = self.mark("+-") {
            let other = self.product()?;
            self.combine(&mut total, &other, |a, b| if mark == '+' { a + b } else { a - b });
        }
        Ok(total)
    }

    fn product(&mut self) -> Result<Vec<f64>, String> {
        let mut total = self.signed()?;
        while let Some(mark) = self.mark("*/") {
            let other = self.signed()?;
            self.combine(&mut total, &other, |a, b| if mark == '*' { a * b } else { a / b });
        }
        Ok(total)
    }

    /// A sign binds less than a power: −x² is −(x²).
    fn signed(&mut self) -> Result<Vec<f64>, String> {
        let is_negative = self.signs();
        let mut total = self.value()?;
        if self.mark("^").is_some() {
            let is_inverse = self.signs();
            let exponent = self.value()?;
            let sign = if is_inverse { -1.0 } else { 1.0 };
            self.combine(&mut total, &exponent, |a, b| a.powf(sign * b));
            if self.mark("^").is_some() {
                return Err("a^b^c is read in two ways: write a^(b^c) or (a^b)^c".into());
            }
        }
        if is_negative {
            total.iter_mut().for_each(|value| *value = -*value);
        }
        Ok(total)
    }

    /// Reads the signs before a value. True if their product is negative.
    fn signs(&mut self) -> bool {
        let mut is_negative = false;
        while let Some(mark) = self.mark("+-") {
            is_negative ^= mark == '-';
        }
        is_negative
    }

    fn value(&mut self) -> Result<Vec<f64>, String> {
        let token = self.peek();
        self.at += 1;
        match token {
            Some(Token::Number(number)) => {
                let value = number.parse().ok().filter(|value: &f64| value.is_finite());
                let value = value.ok_or_else(|| format!("\"{number}\" is not a number"))?;
                Ok(vec![value; self.columns.rows])
            }
            Some(Token::Name(name)) if self.mark("(").is_some() => self.call(name),
            Some(Token::Name(name)) => match (self.column(name), constant(name)) {
                (Some(values), _) => {
                    self.has_column = true;
                    Ok(values)
                }
                (None, Some(value)) => Ok(vec![value; self.columns.rows]),
                (None, None) => Err(self.unknown(name)),
            },
            Some(Token::Mark('(')) => self.inside(Self::sum),
            Some(Token::Mark(',' | ')')) | None => Err(match self.list.get(self.at.wrapping_sub(2)) {
                Some(Token::Mark(mark)) if "+-*/^".contains(*mark) => {
                    format!("it cannot be read: the value after \"{mark}\" is missing")
                }
                _ => EMPTY.into(),
            }),
            Some(Token::Mark(mark)) => Err(format!("there is no value before \"{mark}\"")),
        }
    }

    /// Reads the content of parentheses and the closing one; the opening one is already read.
    fn inside<T>(&mut self, read: impl FnOnce(&mut Self) -> Result<T, String>) -> Result<T, String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("it nests more than {MAX_DEPTH} parentheses"));
        }
        let found = read(self)?;
        self.depth -= 1;
        match self.peek() {
            Some(Token::Mark(')')) => {
                self.at += 1;
                Ok(found)
            }
            Some(Token::Mark(',')) => Err("a comma is outside a function".into()),
            Some(_) => Err("it cannot be read: an operator is missing between two values".into()),
            None => Err("a parenthesis ( is not closed".into()),
        }
    }

    /// Applies an operator row by row. What is missing stays missing.
    fn combine(&mut self, total: &mut [f64], other: &[f64], apply: impl Fn(f64, f64) -> f64) {
        for ((total, other), without) in total.iter_mut().zip(other).zip(&mut self.without_value) {
            let is_missing = total.is_nan() || other.is_nan();
            let value = if is_missing { f64::NAN } else { apply(*total, *other) };
            *without |= !is_missing && !value.is_finite();
            *total = if value.is_finite() { value } else { f64::NAN };
        }
    }

    /// Reads the arguments of a function and computes it; its name and opening parenthesis are already read.
    fn call(&mut self, name: &str) -> Result<Vec<f64>, String> {
        let unary = UNARY.iter().find(|(known, _)| *known == name).map(|(_, apply)| *apply);
        if unary.is_none() && !OTHERS.contains(&name) {
            let all: Vec<&str> = UNARY.iter().map(|(known, _)| *known).chain(OTHERS).collect();
            return Err(format!("there is no function {name}; {}", similar::or_all(name, &all, "functions")));
        }
        let begin = self.at;
        let mut arguments = self.inside(|parser| {
            let mut arguments = vec![parser.sum()?];
            while parser.mark(",").is_some() {
                arguments.push(parser.sum()?);
            }
            Ok(arguments)
        })?;
        let form = match name {
            "min" | "max" if arguments.len() > 1 => None,
            "min" | "max" | "atan2" => Some((2, "(a, b)")),
            "lowpass" => Some((2, "(x, seconds)")),
            _ => Some((1, "(x)")),
        };
        if let Some((_, form)) = form.filter(|(count, _)| *count != arguments.len()) {
            return Err(format!("{name} has {} arguments here: write {name}{form}", arguments.len()));
        }
        let others = arguments.split_off(1);
        let mut values = arguments.pop().unwrap_or_default();
        if let Some(apply) = unary {
            let unused = vec![0.0; values.len()];
            self.combine(&mut values, &unused, |value, _| apply(value));
            return Ok(values);
        }
        Ok(match name {
            "prev" => rows::prev(&values),
            "next" => rows::next(&values),
            "diff" => rows::diff(&values),
            "peak" => rows::peak(&values),
            "lowpass" => {
                // The second argument is one number: what stands between the comma and the parenthesis.
                let constant_s = match self.list.get(begin..self.at) {
                    Some([.., Token::Mark(','), Token::Number(number), Token::Mark(')')]) => {
                        number.parse().ok()
                    }
                    _ => None,
                };
                let constant_s = constant_s
                    .filter(|s: &f64| *s > 0.0)
                    .ok_or("the time of lowpass(x, seconds) is a number above 0, as in lowpass(x, 0.5)")?;
                let time =
                    self.columns.time_s.ok_or("lowpass needs the time, and the log has no time column")?;
                rows::lowpass(&values, time, constant_s)
            }
            _ => {
                let apply: fn(f64, f64) -> f64 = match name {
                    "min" => f64::min,
                    "max" => f64::max,
                    _ => f64::atan2,
                };
                for other in &others {
                    self.combine(&mut values, other, apply);
                }
                values
            }
        })
    }

    /// One value per row; NaN where the column has no finite value.
    fn column(&self, name: &str) -> Option<Vec<f64>> {
        let cells = match name {
            "t_s" => self.columns.time_s?,
            _ => self.columns.named.iter().find(|(own, _)| *own == name)?.1,
        };
        let mut values: Vec<f64> = cells.iter().map(|v| if v.is_finite() { *v } else { f64::NAN }).collect();
        values.resize(self.columns.rows, f64::NAN);
        Some(values)
    }

    fn unknown(&self, name: &str) -> String {
        if name == "t_s" {
            return "the log has no time column".into();
        }
        if UNARY.iter().any(|(known, _)| *known == name) || OTHERS.contains(&name) {
            return format!("{name} is a function: write {name}(…)");
        }
        let mut names: Vec<&str> = self.columns.time_s.map(|_| "t_s").into_iter().collect();
        names.extend(self.columns.named.iter().map(|(name, _)| *name));
        format!("there is no column {name}; {}", similar::or_all(name, &names, "columns"))
    }
}

fn constant(name: &str) -> Option<f64> {
    match name {
        "pi" | "PI" | "π" => Some(std::f64::consts::PI),
        "e" => Some(std::f64::consts::E),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
