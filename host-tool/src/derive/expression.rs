//! An expression over the columns of a log. Arithmetic and functions of one value are the library's (`exmex`); here are the
//! names of columns, missing cells, and functions that need several values or rows.

use crate::derive::rows;
use crate::derive::tokens::{Token, tokens};
use exmex::{Express, FlatEx};
use ironout_analysis::similar;

/// Functions of one value.
const UNARY: [&str; 24] = [
    "abs", "signum", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh",
    "atanh", "floor", "round", "ceil", "trunc", "exp", "sqrt", "cbrt", "ln", "log2", "log10",
];
/// Functions that are evaluated here.
const OTHERS: [&str; 8] = ["min", "max", "atan2", "prev", "next", "diff", "peak", "lowpass"];
/// Parentheses deeper than this are a slip of the pen.
const DEEPEST: usize = 40;

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
    let mut work = Work { columns, without_value: 0, read: false };
    let values = work.part(&list, 0)?;
    if !work.read {
        return Err("it reads no column of the log".into());
    }
    Ok(Computed { values, without_value: work.without_value })
}

struct Work<'a> {
    columns: &'a Columns<'a>,
    without_value: usize,
    /// Whether any column was read.
    read: bool,
}

impl Work<'_> {
    /// One value a row.
    fn part(&mut self, list: &[Token], depth: usize) -> Result<Vec<f64>, String> {
        if depth > DEEPEST {
            return Err(format!("it nests more than {DEEPEST} functions"));
        }
        if list.is_empty() {
            return Err("something is missing: an expression, or an argument of a function, is empty".into());
        }
        // What the library sees: {v000}, numbers, marks and functions of one value.
        let mut text = String::new();
        let mut variables: Vec<Vec<f64>> = Vec::new();
        // For each open parenthesis: whether it closes a function, and whether a power stands in the current product.
        let mut open: Vec<(bool, bool)> = vec![(false, false)];
        let mut before: Option<&Token> = None;
        let mut at = 0;
        while let Some(token) = list.get(at) {
            let called = list.get(at + 1) == Some(&Token::Mark('('));
            match token {
                Token::Number(number) => {
                    let value = number.parse().ok().filter(|value: &f64| value.is_finite());
                    let value = value.ok_or_else(|| format!("\"{number}\" is not a number"))?;
                    text.push_str(&format!("({value})"));
                }
                Token::Name(name) if called && UNARY.contains(&name.as_str()) => {
                    // In parentheses of its own, so that a power applies to the whole.
                    text.push_str(&format!("({name}("));
                    open.push((true, false));
                    at += 1;
                }
                Token::Name(name) if called => {
                    let (arguments, end) = arguments(list, at + 2)?;
                    let values = self.call(name, &arguments, depth)?;
                    text.push_str(&variable(&mut variables, values)?);
                    at = end;
                }
                Token::Name(name) => match self.column(name) {
                    Some(values) => {
                        self.read = true;
                        text.push_str(&variable(&mut variables, values)?);
                    }
                    None => match constant(name) {
                        Some(value) => text.push_str(&format!("({value})")),
                        None => return Err(self.unknown(name)),
                    },
                },
                Token::Mark('(') => {
                    text.push('(');
                    open.push((false, false));
                }
                Token::Mark(')') => {
                    let Some((function, _)) = (open.len() > 1).then(|| open.pop()).flatten() else {
                        return Err("a parenthesis ) has no opening".into());
                    };
                    text.push_str(if function { "))" } else { ")" });
                }
                Token::Mark(',') => return Err("a comma is outside a function".into()),
                Token::Mark(mark) => {
                    let inner = open.last_mut().ok_or("a parenthesis has no opening")?;
                    let begins = matches!(before, None | Some(Token::Mark('(')));
                    let after = match before {
                        Some(Token::Mark(mark)) if "+-*/^".contains(*mark) => Some(*mark),
                        _ => None,
                    };
                    match (*mark, begins, after) {
                        ('^', ..) if inner.1 => {
                            return Err("a^b^c is read in two ways: write a^(b^c) or (a^b)^c".into());
                        }
                        // A sign binds less than a power: −x² is −(x²).
                        ('-', true, _) => text.push_str("0-"),
                        ('+', true, _) => {}
                        ('-', _, Some('/')) => text.push_str("(0-1)/"),
                        ('-', _, Some('*' | '+' | '-')) => text.push_str("(0-1)*"),
                        ('-', _, Some(_)) => text.push('-'),
                        ('+', _, Some(_)) => {}
                        (_, true, _) | (_, _, Some(_)) => {
                            return Err(format!("there is no value before \"{mark}\""));
                        }
                        _ => text.push(*mark),
                    }
                    inner.1 = *mark == '^' || (inner.1 && after == Some('^'));
                }
            }
            before = list.get(at);
            at += 1;
        }
        if open.len() > 1 {
            return Err("a parenthesis ( is not closed".into());
        }
        self.rows(&text, &variables)
    }

    /// The library's part, row by row.
    fn rows(&mut self, text: &str, variables: &[Vec<f64>]) -> Result<Vec<f64>, String> {
        let cannot = |_: exmex::ExError| "it cannot be read: an operator or a value is missing".to_string();
        let expression = FlatEx::<f64>::parse(text).map_err(cannot)?;
        if expression.var_names().len() != variables.len() {
            return Err("it cannot be read: an operator or a value is missing".into());
        }
        let mut cells = vec![0.0; variables.len()];
        let mut values = Vec::with_capacity(self.columns.rows);
        for row in 0..self.columns.rows {
            let mut missing = false;
            for (cell, column) in cells.iter_mut().zip(variables) {
                *cell = column.get(row).copied().unwrap_or(f64::NAN);
                missing |= !cell.is_finite();
            }
            let value = if missing { f64::NAN } else { expression.eval(&cells).map_err(cannot)? };
            if !missing && !value.is_finite() {
                self.without_value += 1;
            }
            values.push(if value.is_finite() { value } else { f64::NAN });
        }
        Ok(values)
    }

    fn call(&mut self, name: &str, arguments: &[&[Token]], depth: usize) -> Result<Vec<f64>, String> {
        let expect = |count: usize, form: &str| {
            if arguments.len() == count {
                Ok(())
            } else {
                Err(format!("{name} has {} arguments here: write {form}", arguments.len()))
            }
        };
        match name {
            "min" | "max" | "atan2" => {
                if name == "atan2" || arguments.len() < 2 {
                    expect(2, &format!("{name}(a, b)"))?;
                }
                let apply: fn(f64, f64) -> f64 = match name {
                    "min" => f64::min,
                    "max" => f64::max,
                    _ => f64::atan2,
                };
                let mut columns = arguments.iter().map(|argument| self.part(argument, depth + 1));
                let mut total = columns.next().ok_or("a function has no arguments")??;
                for column in columns {
                    for (total, value) in total.iter_mut().zip(column?) {
                        // min and max of the library pass over what is missing.
                        let missing = total.is_nan() || value.is_nan();
                        *total = if missing { f64::NAN } else { apply(*total, value) };
                    }
                }
                Ok(total)
            }
            "prev" | "next" | "diff" | "peak" => {
                expect(1, &format!("{name}(x)"))?;
                let values = self.part(arguments.first().copied().unwrap_or_default(), depth + 1)?;
                Ok(match name {
                    "prev" => rows::prev(&values),
                    "next" => rows::next(&values),
                    "diff" => rows::diff(&values),
                    _ => rows::peak(&values),
                })
            }
            "lowpass" => {
                expect(2, "lowpass(x, seconds)")?;
                let constant_s = match arguments.get(1) {
                    Some([Token::Number(number)]) => {
                        number.parse().ok().filter(|s: &f64| *s > 0.0 && s.is_finite())
                    }
                    _ => None,
                };
                let constant_s = constant_s
                    .ok_or("the time of lowpass(x, seconds) is a number above 0, as in lowpass(x, 0.5)")?;
                let time =
                    self.columns.time_s.ok_or("lowpass needs the time, and the log has no time column")?;
                let values = self.part(arguments.first().copied().unwrap_or_default(), depth + 1)?;
                Ok(rows::lowpass(&values, time, constant_s))
            }
            _ => {
                let all: Vec<&str> = UNARY.iter().chain(&OTHERS).copied().collect();
                Err(format!("there is no function {name}; {}", similar::or_all(name, &all, "functions")))
            }
        }
    }

    fn column(&self, name: &str) -> Option<Vec<f64>> {
        if name == "t_s" {
            return self.columns.time_s.map(<[f64]>::to_vec);
        }
        let found = self.columns.named.iter().find(|(own, _)| *own == name);
        found.map(|(_, values)| values.to_vec())
    }

    fn unknown(&self, name: &str) -> String {
        if name == "t_s" {
            return "the log has no time column".into();
        }
        if UNARY.contains(&name) || OTHERS.contains(&name) {
            return format!("{name} is a function: write {name}(…)");
        }
        let mut names: Vec<&str> = self.columns.time_s.map(|_| "t_s").into_iter().collect();
        names.extend(self.columns.named.iter().map(|(name, _)| *name));
        format!("there is no column {name}; {}", similar::or_all(name, &names, "columns"))
    }
}

/// A name for the library; its variables are in the order of their names.
fn variable(variables: &mut Vec<Vec<f64>>, values: Vec<f64>) -> Result<String, String> {
    if variables.len() >= 1000 {
        return Err("it reads more than 1000 values".into());
    }
    variables.push(values);
    Ok(format!("{{v{:03}}}", variables.len() - 1))
}

fn constant(name: &str) -> Option<f64> {
    match name {
        "pi" | "PI" | "π" => Some(std::f64::consts::PI),
        "e" => Some(std::f64::consts::E),
        _ => None,
    }
}

/// The arguments of a function whose first token is at `from`, and where its parenthesis closes.
fn arguments(list: &[Token], from: usize) -> Result<(Vec<&[Token]>, usize), String> {
    let mut found = Vec::new();
    let (mut depth, mut begin) = (0_usize, from);
    for (at, token) in list.iter().enumerate().skip(from) {
        match token {
            Token::Mark('(') => depth += 1,
            Token::Mark(')') if depth == 0 => {
                found.push(list.get(begin..at).unwrap_or_default());
                return Ok((found, at));
            }
            Token::Mark(')') => depth -= 1,
            Token::Mark(',') if depth == 0 => {
                found.push(list.get(begin..at).unwrap_or_default());
                begin = at + 1;
            }
            _ => {}
        }
    }
    Err("a parenthesis ( is not closed".into())
}

#[cfg(test)]
mod tests;
