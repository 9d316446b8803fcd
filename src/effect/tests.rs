//! What holds for every effect: both ways to its disturbance, its parts, its family.

extern crate std;

use super::{
    AmbientField, BuiltIn, Coefficients, ColumnName, CrossAxis, Drift, Eddy, Effect, Form, Gain, Id, Lag,
    MAX_COEFFICIENTS, Made, Need, Nonlinearity, Offset, Parts, Past, Periodic, Power, Product, Quantities,
    Registry, SoftIron, Step, no_shape,
};
use std::string::{String, ToString};
use std::vec::Vec;

fn all() -> [BuiltIn<f64>; 14] {
    let column = ColumnName::new("temp_c").unwrap();
    [
        BuiltIn::Offset(Offset::linear(column, 24.5)),
        BuiltIn::Offset(Offset { column, reference: 9.0, power: Power::Squared, past: Past::Delayed(0.25) }),
        BuiltIn::Offset(Offset { column, reference: 9.0, power: Power::Linear, past: Past::LowPass(2.5) }),
        BuiltIn::Product(Product { columns: ColumnName::new("servo*current_a").unwrap(), reference: 0.5 }),
        BuiltIn::Gain(Gain { column, reference: 20.0 }),
        BuiltIn::Field(AmbientField { column, reference: 21.0 }),
        BuiltIn::SoftIron(SoftIron { column, reference: 21.0 }),
        BuiltIn::Drift(Drift { reference_s: 40.0 }),
        BuiltIn::Step(Step { at_s: 3.0 }),
        BuiltIn::Lag(Lag),
        BuiltIn::Eddy(Eddy),
        BuiltIn::Nonlinearity(Nonlinearity),
        BuiltIn::CrossAxis(CrossAxis),
        BuiltIn::Periodic(Periodic { frequency_hz: 7.0, reference_s: 1.0 }),
    ]
}

#[test]
fn the_cheap_way_is_the_shape_times_the_coefficients() {
    let at = Quantities {
        measured_ut: [20.0, -35.0, 12.5],
        centred_ut: [11.0, -30.0, 7.0],
        turning_ut_per_s: [-60.0, 14.0, 33.0],
        inputs: [31.0, 7.0],
    };
    let coefficients: Coefficients<f64> =
        core::array::from_fn(|i| if i < MAX_COEFFICIENTS { 0.3 - 0.1 * i as f64 } else { 0.0 });
    for effect in all() {
        let mut shape = no_shape();
        effect.shape(&at, &mut shape);
        let cheap = effect.disturbance(&at, &coefficients);
        if let Some(delay_s) = Effect::<f64>::delay_s(&effect, &coefficients) {
            // What turns the vector takes nothing off it; its shape is the way the vector goes.
            assert_eq!((cheap, delay_s), ([0.0; 3], coefficients[0]), "{effect:?}");
            assert_eq!(shape[0], at.turning_ut_per_s);
            continue;
        }
        let k = effect.coefficients();
        for axis in 0..3 {
            let whole: f64 = (0..k).map(|i| shape[i][axis] * coefficients[i]).sum();
            assert!((cheap[axis] - whole).abs() <= 1e-12 * whole.abs().max(1.0), "{effect:?} axis {axis}");
        }
        assert!(effect.parts().is_sound() && effect.cast::<f32>().parts().is_sound());
    }
}

#[test]
fn an_effect_that_reads_the_centre_says_so() {
    let near = Quantities { inputs: [31.0, 0.0], ..Quantities::of_vector([20.0, -35.0, 12.5]) };
    let far = Quantities { centred_ut: [1.0, 2.0, 3.0], turning_ut_per_s: [4.0, 5.0, 6.0], ..near };
    for effect in all() {
        let differ = effect.disturbance(&near, &[1.0; MAX_COEFFICIENTS])
            != effect.disturbance(&far, &[1.0; MAX_COEFFICIENTS]);
        assert_eq!(differ, effect.reads_centre(), "{effect:?}");
    }
}

#[test]
fn every_effect_comes_back_from_its_parts() {
    for effect in all() {
        let parts = effect.parts();
        assert_eq!(BuiltIn::<f64>::of(&parts), Some(effect));
        assert_eq!(BuiltIn::<f64>::form(parts.form.tag), Some(parts.form));
        let single = effect.cast::<f32>();
        assert_eq!(single.cast::<f64>(), effect, "the numbers here are exact in single precision");
    }
    let strange: &'static Form = &Form { tag: 200, ..Form::PLAIN };
    assert_eq!(BuiltIn::<f64>::of(&Parts::of(strange)), None);
}

#[test]
fn numbers_of_records_are_never_given_again() {
    let mut tags: Vec<u8> =
        Registry::BUILT_IN.families().flat_map(|f| f.forms()).map(|form| form.tag).collect();
    tags.sort_unstable();
    let all: Vec<u8> = (1..=16).collect();
    assert_eq!(tags, all);
}

#[test]
fn the_family_makes_the_same_effect() {
    let at = Quantities {
        measured_ut: [20.0, -35.0, 12.5],
        centred_ut: [11.0, -30.0, 7.0],
        turning_ut_per_s: [-60.0, 14.0, 33.0],
        inputs: [31.0, 7.0],
    };
    let theta = [0.3; MAX_COEFFICIENTS];
    for effect in all() {
        let id = Id(&effect as &dyn Effect<f64>).to_string();
        let named = Registry::BUILT_IN.parse(&id).expect("an id of its own");
        let made = Made::new(named.family, effect.parts()).expect("a form of its family");
        assert_eq!(Id(&made).to_string(), id);
        assert_eq!(Effect::<f64>::columns(&effect), made.columns(), "{id}");
        assert_eq!(effect.disturbance(&at, &theta), made.disturbance(&at, &theta), "{id}");
        let words = |effect: &dyn Effect<f64>| {
            (effect.name(), effect.explanation(), effect.unit(), effect.coefficients(), effect.needs_gyro())
        };
        assert_eq!(words(&effect), words(&made), "{id}");
        assert_eq!(effect.reads_centre(), made.reads_centre(), "{id}");
        assert_eq!(effect.coefficients(), effect.parts().form.coefficients, "{id}");
        let gyro = named.family.need(effect.parts().form) == Some(Need::Gyro);
        assert_eq!(effect.needs_gyro(), gyro, "{id}");
    }
}

#[test]
fn ids_are_taken_apart() {
    let parts = |id: &'static str| {
        Registry::BUILT_IN
            .parse(id)
            .map(|n| (n.family.kind(), n.column, n.form.is_squared(), n.form.is_late()))
    };
    assert_eq!(parts("offset:temp_c"), Some(("offset", "temp_c", false, false)));
    assert_eq!(parts("offset:a@delay^2"), Some(("offset", "a", true, true)));
    assert_eq!(parts("lag"), Some(("lag", "", false, false)));
    let unknown = [
        "",
        "offset",
        "offset:",
        "gain:x^2",
        "field:x@delay",
        "Lag",
        "wobble:x",
        "misalignment",
        "drift^2",
        ":x",
    ];
    for id in unknown {
        assert_eq!(parts(id), None, "{id}");
    }
}

#[test]
fn a_log_is_offered_what_its_columns_allow() {
    let known = |has: fn(Need) -> bool| {
        let mut list: Vec<String> = Vec::new();
        Registry::BUILT_IN.known(["u"].into_iter(), has, |named| list.push(named.to_string()));
        list.join(" ")
    };
    assert_eq!(known(|_| false), "offset:u offset:u^2 gain:u field:u nonlinearity cross-axis");
    let all = "offset:u offset:u^2 offset:u@delay offset:u~tau gain:u field:u drift step periodic lag nonlinearity cross-axis";
    assert_eq!(known(|_| true), all);
}

#[test]
fn every_pair_has_advice_that_names_its_columns() {
    const IDS: [&str; 17] = [
        "offset:temp_c",
        "gain:temp_c",
        "offset:temp_c^2",
        "offset:current_a",
        "offset:current_a@delay",
        "offset:current_a~tau",
        "soft-iron:lid",
        "product:servo*current_a",
        "offset:throttle",
        "field:height_m",
        "offset:servo",
        "drift",
        "step",
        "lag",
        "nonlinearity",
        "cross-axis",
        "periodic",
    ];
    let named = |id: &'static str| Registry::BUILT_IN.parse(id).unwrap();
    for a in IDS {
        for b in IDS.into_iter().filter(|b| *b != a) {
            let (one, other) = (named(a), named(b));
            let text = one.apart(&other).unwrap_or_else(|| panic!("{a} {b}")).to_string();
            assert!(text.len() > 30 && text.ends_with('.') && !text.contains('{'), "{a} {b}: {text}");
            for column in [one.column, other.column] {
                assert!(text.contains(column) || [a, b].contains(&"lag"), "{a} {b}: {text}");
            }
        }
    }
}
