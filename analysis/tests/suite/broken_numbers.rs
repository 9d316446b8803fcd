//! Broken numbers: each kind is recognised by the repair that undoes it, at any scale and rate, and a log that is right is left alone.

use ironout_analysis::plausible::breakage::{Repair, find};
use ironout_simulation::truths::{Kind, draw};
use ironout_simulation::{Log, Motion, World, WorldOptions};

type Numbers = [Vec<f64>; 3];

fn field(log: &Log) -> Numbers {
    ["mx_ut", "my_ut", "mz_ut"].map(|name| log.columns[log.position(name).expect(name)].clone())
}

/// Whole counts of this scale.
fn counts(field: &Numbers, ut_per_count: f64) -> Numbers {
    field.each_ref().map(|axis| axis.iter().map(|value| (value / ut_per_count).round()).collect())
}

fn broken(numbers: &Numbers, axes: [bool; 3], by: impl Fn(usize, f64) -> f64) -> Numbers {
    let mut out = numbers.clone();
    for (values, _) in out.iter_mut().zip(axes).filter(|(_, is)| *is) {
        values.iter_mut().enumerate().for_each(|(row, value)| *value = by(row, *value));
    }
    out
}

fn slices(numbers: &Numbers) -> [&[f64]; 3] {
    numbers.each_ref().map(Vec::as_slice)
}

/// Boards that turn in several ways, at several rates.
fn logs() -> Vec<(String, Numbers)> {
    let mut list = Vec::new();
    for (index, rate_hz) in [5.0, 10.0, 25.0, 50.0, 100.0, 200.0].into_iter().enumerate() {
        for motion in [Motion::Sphere, Motion::Hand, Motion::Tumbling, Motion::Waving] {
            let seed = 40 + index as u64;
            let options = WorldOptions {
                seed,
                rate_hz,
                seconds: if rate_hz < 20.0 { 120.0 } else { 40.0 },
                noise_ut: [0.05, 0.3][index % 2],
                field_ut: [28.0, 48.0, 62.0][index % 3],
                motion,
                ..WorldOptions::default()
            };
            list.push((format!("{motion:?} {rate_hz} Hz"), field(&World::new(options).run())));
        }
    }
    list
}

/// One breakage: what it does to counts, the scale they have, and whether a repair is the right one.
struct Case {
    what: &'static str,
    ut_per_count: f64,
    axes: [bool; 3],
    by: Box<dyn Fn(usize, f64) -> f64>,
    right: fn(&Repair) -> bool,
}

fn swap(value: f64) -> f64 {
    f64::from((value as i16).swap_bytes())
}

fn cases() -> Vec<Case> {
    const ALL: [bool; 3] = [true; 3];
    const ONE: [bool; 3] = [false, true, false];
    let case = |what, ut_per_count, axes, by: Box<dyn Fn(usize, f64) -> f64>, right| Case {
        what,
        ut_per_count,
        axes,
        by,
        right,
    };
    let bits = |bits: i32| 2.0_f64.powi(bits);
    let unsigned: fn(&Repair) -> bool = |r| matches!(r, Repair::Unsigned { .. });
    let swapped: fn(&Repair) -> bool = |r| matches!(r, Repair::SwappedBytes { .. });
    let unwrap: fn(&Repair) -> bool = |r| matches!(r, Repair::Unwrap { .. });
    let code: fn(&Repair) -> bool = |r| matches!(r, Repair::ErrorCode { .. });
    let mut list = Vec::new();
    for scale in [0.01, 0.0333, 0.15, 0.6] {
        for axes in [ALL, ONE] {
            list.push(case(
                "unsigned 16",
                scale,
                axes,
                Box::new(move |_, v| if v < 0.0 { v + bits(16) } else { v }),
                unsigned,
            ));
            list.push(case("swapped", scale, axes, Box::new(|_, v| swap(v)), swapped));
            list.push(case(
                "swapped, unsigned",
                scale,
                axes,
                Box::new(|_, v| f64::from((v as i16).swap_bytes() as u16)),
                swapped,
            ));
        }
    }
    for (scale, width) in [(0.15, 12), (0.15, 13), (0.03, 14), (0.1, 12)] {
        list.push(case(
            "unsigned of fewer bits",
            scale,
            ONE,
            Box::new(move |_, v| v.rem_euclid(bits(width))),
            unsigned,
        ));
        // The offset of a magnet beside the sensor drives the axis over the end.
        let by = move |_, v: f64| {
            (v + 0.97 * bits(width - 1) + 0.5 * bits(width)).rem_euclid(bits(width)) - 0.5 * bits(width)
        };
        list.push(case("wrapped", scale, ONE, Box::new(move |row, v| by(row, v).round()), unwrap));
    }
    for value in [-32_768.0, -4096.0, 32_767.0, 0.0] {
        list.push(case(
            "code in every axis",
            0.1,
            ALL,
            Box::new(move |row, v| if row % 13 == 5 && row % 7 < 4 { value } else { v }),
            code,
        ));
        if value != 0.0 {
            list.push(case(
                "code in one axis",
                0.1,
                ONE,
                Box::new(move |row, v| if row * row % 19 == 4 { value } else { v }),
                code,
            ));
        }
    }
    for every in [5, 10, 64] {
        let wrong = |row: usize| f64::from((row as u32).wrapping_mul(2_654_435_761) >> 17) - 16_384.0;
        let by = move |row: usize, v: f64| if row % every == 3 { wrong(row) } else { v };
        let right: fn(&Repair) -> bool = |r| matches!(r, Repair::EveryRow { offset: 3, .. });
        list.push(case("every n-th row", 0.05, ALL, Box::new(by), right));
        list.push(case("every n-th row of one axis", 0.05, ONE, Box::new(by), right));
    }
    for factor in [2.0, 4.0, 0.25, 0.1, 1.667] {
        let by = move |row: usize, v: f64| if row >= 300 { v * factor } else { v };
        list.push(case("range", 0.01, ALL, Box::new(by), |r| matches!(r, Repair::RangeChange { .. })));
    }
    let low = |_: usize, v: f64| if v.rem_euclid(256.0) >= 128.0 { v - 256.0 } else { v };
    list.push(case("signed low byte", 0.02, ALL, Box::new(low), |r| {
        matches!(r, Repair::SignedLowByte { .. })
    }));
    list
}

/// A board that turns level, slowly: its readings lie in a plane, which no ellipsoid is fitted to.
fn level_turns() -> (String, Numbers) {
    let at = |row: usize| row as f64 * 0.02;
    let noise = |row: usize| 0.1 * (f64::from((row as u32).wrapping_mul(2_654_435_761) >> 22) / 512.0 - 1.0);
    let axis =
        |of: fn(f64) -> f64, phase: usize| (0..1500).map(|row| of(at(row)) + noise(row + phase)).collect();
    let field = [axis(|t| 12.0 + 22.0 * t.cos(), 0), axis(|t| 22.0 * t.sin() - 5.0, 7), axis(|_| -41.0, 19)];
    ("level turns 50 Hz".into(), field)
}

/// The rows between the right ones: of something else, of nothing, or of a code; in motions that hardly turn from row to row.
#[test]
fn every_second_row_that_is_wrong_is_set_aside_in_space_and_in_a_plane() {
    let slow = |what: &str| ["25", "50", "100", "200"].iter().any(|hz| what.ends_with(&format!(" {hz} Hz")));
    let mut logs: Vec<_> = logs().into_iter().filter(|(what, _)| slow(what)).collect();
    logs.push(level_turns());
    let random = |row: usize| f64::from((row as u32).wrapping_mul(2_654_435_761) >> 17) - 16_384.0;
    let kinds: [(&str, &dyn Fn(usize) -> f64); 3] =
        [("random", &random), ("code", &|_| -32_768.0), ("a still sensor", &|_| 117.0)];
    let mut missed = Vec::new();
    for (what, field) in &logs {
        let whole = counts(field, 0.05);
        for (kind, wrong) in &kinds {
            let numbers = broken(&whole, [true; 3], |row, v| if row % 2 == 1 { wrong(row) } else { v });
            let found = find(slices(&numbers));
            let set_aside = |repair: &Repair| {
                let mut marked = vec![false; numbers[0].len()];
                repair.set_aside(slices(&numbers), &mut marked);
                marked.iter().enumerate().all(|(row, is)| *is == (row % 2 == 1))
            };
            if !found.first().is_some_and(|first| set_aside(&first.repair)) {
                missed.push(format!("{what}, {kind}: {found:?}"));
            }
        }
    }
    assert!(missed.is_empty(), "{} of {}: {missed:#?}", missed.len(), kinds.len() * logs.len());
}

/// Axes that are of another time than the others.
#[test]
fn an_axis_that_stands_still_or_comes_late_is_recognised() {
    let (mut frozen, mut late, mut of) = (0, 0, 0);
    let mut missed = Vec::new();
    for (what, field) in logs()
        .into_iter()
        .filter(|(what, _)| ["25", "50", "100"].iter().any(|hz| what.ends_with(&format!(" {hz} Hz"))))
    {
        of += 1;
        let rows = field[0].len();
        let mut held = field.clone();
        for row in 1..rows {
            if row % 200 > 150 {
                held[2][row] = held[2][row - 1];
            }
        }
        let found = find(slices(&held));
        let is = found.iter().any(|one| matches!(one.repair, Repair::FrozenAxis { axis: 2, .. }));
        frozen += usize::from(is);
        let mut moved = field.clone();
        // 60 ms: in the slower of these motions an axis that is less late lies within the noise.
        let hz: f64 = what.rsplit(' ').nth(1).and_then(|hz| hz.parse().ok()).expect("a rate");
        let rows_late = (0.06 * hz).round() as isize;
        moved[1].rotate_right(rows_late as usize);
        let found = find(slices(&moved));
        let is_late = found.iter().any(|one| match one.repair {
            Repair::LateAxis { axis: 1, rows } => (rows - rows_late).abs() <= 1,
            _ => false,
        });
        late += usize::from(is_late);
        if !is || !is_late {
            missed.push(format!("{what} {is} {is_late} {found:?}"));
        }
    }
    println!("of {of}: frozen {frozen}, late {late}; {missed:#?}");
    assert!(frozen * 10 >= of * 7 && late * 10 >= of * 6, "{frozen} {late} of {of} {missed:#?}");
}

#[test]
fn each_kind_is_recognised_by_the_repair_that_undoes_it() {
    let (logs, cases) = (logs(), cases());
    let (mut right, mut of, mut wrong) = (0, 0, Vec::new());
    for case in &cases {
        let mut found_in = 0;
        let mut failed = Vec::new();
        for (what, field) in &logs {
            let whole = counts(field, case.ut_per_count);
            let numbers = broken(&whole, case.axes, &case.by);
            let found = find(slices(&numbers));
            of += 1;
            if numbers == whole || found.first().is_some_and(|first| (case.right)(&first.repair)) {
                (right, found_in) = (right + 1, found_in + 1);
            } else {
                failed.push(what.as_str());
            }
            wrong.extend(found.iter().filter(|one| !(case.right)(&one.repair)).map(|one| {
                format!("{} {} {what}: {one:?}", case.what, case.ut_per_count)
                    .chars()
                    .take(200)
                    .collect::<String>()
            }));
        }
        println!(
            "{:<28} {:>6} {:?} {found_in} of {}; not {failed:?}",
            case.what,
            case.ut_per_count,
            case.axes,
            logs.len()
        );
    }
    println!("{right} of {of}; {} times another kind: {wrong:#?}", wrong.len());
    assert!(right * 100 >= of * 92, "{right} of {of}");
    assert!(wrong.len() * 100 <= of * 2, "{wrong:#?}");
}

#[test]
fn repaired_numbers_are_those_that_the_sensor_gave() {
    for (what, field) in logs().into_iter().filter(|(what, _)| !what.contains("5 Hz")) {
        let whole = counts(&field, 0.05);
        let unsigned = broken(&whole, [true; 3], |_, v| if v < 0.0 { v + 65_536.0 } else { v });
        let swapped = broken(&whole, [true, false, true], |_, v| swap(v));
        for (kind, numbers) in [("unsigned", unsigned), ("swapped", swapped)] {
            let mut mended = numbers.clone();
            let mut kept: Vec<usize> = (0..numbers[0].len()).collect();
            find(slices(&numbers)).iter().for_each(|one| one.repair.make(&mut mended, &mut kept));
            assert!(mended == whole, "{what} {kind}: {:?}", find(slices(&numbers)));
        }
    }
}

/// What may happen to a log that is right: spikes, a passing magnet, coarse steps, rows that repeat, a board at rest.
fn disturbed(numbers: &Numbers, number: u64) -> Numbers {
    let mut out = numbers.clone();
    let random = |salt: u64| {
        let mut x = number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ salt.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 30)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let rows = out[0].len();
    match number % 6 {
        // Spikes of any height in up to 2 % of the rows.
        1 => {
            for spike in 0..(0.02 * random(1) * rows as f64) as u64 {
                let row = (random(10 + spike) * rows as f64) as usize;
                let axis = (random(5000 + spike) * 3.0) as usize;
                out[axis][row] += (random(9000 + spike) - 0.5) * 600.0;
            }
        }
        // A magnet passes.
        2 => {
            let (at, width) = (random(1) * rows as f64, 5.0 + 60.0 * random(2));
            for (axis, values) in out.iter_mut().enumerate() {
                let size = (random(3 + axis as u64) - 0.5) * 400.0;
                values
                    .iter_mut()
                    .enumerate()
                    .for_each(|(row, v)| *v += size / (1.0 + ((row as f64 - at) / width).powi(2)));
            }
        }
        // Coarse steps.
        3 => {
            let step = [0.3, 1.0, 2.0][(random(1) * 3.0) as usize];
            out.iter_mut().flatten().for_each(|v| *v = (*v / step).round() * step);
        }
        // Few rows per turn.
        4 => {
            let every = 2 + (random(1) * 12.0) as usize;
            out = out.map(|axis| axis.into_iter().step_by(every).collect());
        }
        // Every row three times: the log is faster than the sensor.
        5 => out = out.map(|axis| axis.into_iter().flat_map(|v| [v; 3]).collect()),
        _ => {}
    }
    out
}

/// Logs of every kind that are right are left alone. `IRONOUT_BREAKAGE_LOGS=1000` looks at so many,
/// `IRONOUT_BREAKAGE_FAMILY=N` at others.
#[test]
fn logs_that_are_right_are_left_alone() {
    let asked = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let most = asked("IRONOUT_BREAKAGE_LOGS").unwrap_or(36);
    let family = asked("IRONOUT_BREAKAGE_FAMILY").unwrap_or(0xb4ea);
    let mut alarms = Vec::new();
    for number in 0..most {
        let kind = Kind::ALL[(number % Kind::ALL.len() as u64) as usize];
        let drawn = draw(kind, family, number);
        let right = disturbed(&field(&drawn.world.run()), number / 12);
        // In microtesla as they are, in rounded ones, and in counts.
        let rounded = broken(&right, [true; 3], |_, v| (v * 1000.0).round() / 1000.0);
        for numbers in [&right, &rounded, &counts(&right, 0.0333), &counts(&right, 0.15)] {
            let found = find(slices(numbers));
            alarms
                .extend(found.iter().map(|one| format!("{} {number} {}: {one:?}", kind.name(), drawn.words)));
        }
    }
    println!("{most} logs, four ways each: {} alarms", alarms.len());
    let short: Vec<String> = alarms.iter().map(|text| text.chars().take(330).collect()).collect();
    assert!(alarms.is_empty(), "{short:#?}");
}

/// A row that is far off, as a sensor's first one often is, makes a longer path than all others, and is in one half of the rows.
#[test]
fn single_rows_far_off_are_not_every_second_row() {
    for (what, right) in logs() {
        for places in [&[0_usize][..], &[1], &[0, 2], &[50, 150, 152]] {
            for far_ut in [300.0, 3000.0, -30_000.0] {
                let mut numbers = right.clone();
                for axis in &mut numbers {
                    places.iter().for_each(|row| axis[*row] += far_ut * (1.0 + 0.01 * *row as f64));
                }
                let found = find(slices(&numbers));
                let every = found.iter().find(|one| matches!(one.repair, Repair::EveryRow { .. }));
                assert!(every.is_none(), "{what} {places:?} {far_ut}: {every:?}");
            }
        }
    }
}

#[test]
fn what_is_too_little_or_no_number_breaks_nothing() {
    let none: [&[f64]; 3] = [&[], &[], &[]];
    assert_eq!(find(none), []);
    for value in [0.0, f64::NAN, f64::INFINITY, 1e300, -1e300] {
        let axis = vec![value; 200];
        assert_eq!(find([&axis, &axis, &axis]), []);
    }
    let uneven: [&[f64]; 3] = [&[1.0; 100], &[1.0; 99], &[1.0; 100]];
    assert_eq!(find(uneven), []);
    let huge: Vec<f64> = (0..300).map(|i| if i % 2 == 0 { 1e308 } else { -1e308 }).collect();
    find([&huge, &huge, &huge]);
}
