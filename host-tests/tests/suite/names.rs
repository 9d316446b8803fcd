//! One name, one thing: whoever imports several rooms whole meets no name twice.

/// All rooms in one. That this compiles is the test: a name that two of them give to different things is an error here, also
/// where nothing uses it.
#[deny(ambiguous_glob_reexports)]
pub mod all_rooms {
    pub use ironout::calibration::*;
    pub use ironout::clock::*;
    pub use ironout::coverage::*;
    pub use ironout::device::*;
    pub use ironout::effect::*;
    pub use ironout::extended::*;
    pub use ironout::fit::*;
    pub use ironout::gate::*;
    pub use ironout::model::*;
    pub use ironout::moments::*;
    pub use ironout::protocol::*;
    pub use ironout::quality::*;
    pub use ironout::record::*;
    pub use ironout::scatter::*;
    pub use ironout::sensor::*;
    pub use ironout::session::*;
    pub use ironout::store::*;
    pub use ironout::study::*;
    pub use ironout::whiteness::*;
}

#[test]
fn effects_and_study_are_imported_whole_beside_each_other() {
    use ironout::effect::*;
    use ironout::study::*;

    // A gain is an effect, and what a candidate gains in the study has a name of its own.
    let column = ColumnName::new("temp_c").expect("a name");
    let gain = BuiltIn::<f64>::Gain(Gain { column, reference: 20.0 });
    assert_eq!(Effect::<f64>::coefficients(&gain), 3);
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let model = Model::new([0.0; 3], identity, 50.0, identity, 0.0).expect("regular");
    let mut study: Study<f64, 12, 1, 1> = Study::new(Residual::Magnitude, model, 3);
    let observation = Observation { measured_ut: [30.0, 40.0, 0.0], turn_radps: None, down: None };
    let term = Term {
        effect: &gain,
        coefficients: [0.0; MAX_COEFFICIENTS],
        inputs: [21.0, 0.0],
        bends: Bends::Reading,
    };
    study.push(0, &observation, &[term]).expect("all is finite");
    let improvement: Option<Improvement<f64>> = None;
    assert!(improvement.is_none() && Normal::total(study.blocks(), None).rows() == 1);
}
