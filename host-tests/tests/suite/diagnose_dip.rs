//! What only the dip sees: a delay of any size, misalignment, and every order of swapped axes.

use ironout_analysis::outcome::outcome::{Status, Verdict};
use ironout_analysis::{Diagnosis, Options, diagnose};
use ironout_host_tests::accuracy::dip_table;
use ironout_host_tests::accuracy::simulated::table_of;
use ironout_simulation::{EffectSpec, Log, World, WorldOptions};

fn log(seed: u64, effects: &[&str]) -> Log {
    let effects = effects.iter().map(|text| EffectSpec::parse(text).expect("a known effect")).collect();
    World::new(WorldOptions { seed, effects, seconds: 60.0, ..WorldOptions::default() }).run()
}

fn found(log: &Log, search: bool) -> Diagnosis {
    diagnose(&table_of(log), &Options { search, ..Options::default() }).expect("a diagnosis")
}

#[test]
fn a_delay_of_any_size_is_found_and_the_dip_is_as_constant_as_the_sensors_noise_allows() {
    for (seed, effect) in [(1, "lag=15ms"), (2, "lag=20ms"), (3, "lag=300ms"), (0, "lag=500ms")] {
        let log = log(seed, &[effect]);
        let diagnosis = found(&log, true);
        let steps: Vec<_> = diagnosis.steps.iter().filter_map(|step| step.added.as_deref()).collect();
        assert_eq!((diagnosis.verdict, steps), (Verdict::Missing, vec!["lag"]), "{effect}");
        let truth = log.truth.effects[0].coefficients()[0];
        let delay = diagnosis.effects[0].coefficients[0];
        assert!((delay / truth - 1.0).abs() < 0.1, "{effect}: {delay}");
        let dip = diagnosis.dip.expect("a dip").rms_deg_after;
        let floor = dip_table::floor_deg(&log, &WorldOptions::default());
        // Within a row the field turns too, which a delay of half a row leaves.
        assert!(dip < 1.2 * floor, "{effect}: {dip} against {floor}");
    }
}

#[test]
fn a_misalignment_leaves_nothing_but_the_sensors_noise() {
    let (turned, clean) = (dip_table::run("misalignment=6", 3), dip_table::run("", 3));
    for row in [&turned, &clean] {
        assert!(row.logs == 3 && row.worst_over_floor < 1.2, "{row:?}");
        assert!(row.heading_deg[1] < 0.6 * row.heading_deg[0], "{row:?}");
    }
    assert_eq!(clean.named, clean.logs, "{clean:?}");
    // Soft iron turns the field by some degrees itself, now with the misalignment and now against it.
    assert!(turned.named > 0, "{turned:?}");
}

#[test]
fn every_order_and_sign_of_the_axes_is_named() {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    for soft_iron in [None, Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])] {
        let world = World::new(WorldOptions { seed: 5, seconds: 40.0, soft_iron, ..WorldOptions::default() });
        let mut plain = world.run();
        // With soft iron the log knows the heading, and with it the hemisphere; without it does not.
        let knows_heading = soft_iron.is_none();
        if let (false, Some(index)) = (knows_heading, plain.position("heading_deg")) {
            plain.names.remove(index);
            plain.columns.remove(index);
        }
        for order in orders {
            for signs in 0..8_u32 {
                let sign = |axis: usize| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
                let mut log = plain.clone();
                for axis in 0..3 {
                    let body = &plain.columns[1 + order[axis]];
                    log.columns[1 + axis] = body.iter().map(|value| sign(axis) * value).collect();
                }
                // An order and its negative differ by the hemisphere alone: where that is open, the mounting of the two.
                let swaps = (0..3).flat_map(|i| (0..i).map(move |j| (i, j)));
                let odd = swaps.filter(|&(i, j)| order[i] < order[j]).count() + signs.count_ones() as usize;
                let negate = if odd % 2 == 1 && !knows_heading { -1.0 } else { 1.0 };
                let names: Vec<String> = (0..3)
                    .map(|axis| {
                        let minus = if sign(axis) * negate < 0.0 { "-" } else { "" };
                        format!("{minus}{}", ["x", "y", "z"][order[axis]])
                    })
                    .collect();
                let wanted = Some(names.join(",")).filter(|order| order != "x,y,z");
                let diagnosis = found(&log, false);
                let found = diagnosis.axis_order().map(|order| order.to_string());
                assert_eq!(found, wanted, "log's axes {order:?}, signs {signs:03b}");
                let row = diagnosis.candidates.iter().find(|row| row.id == "axis-order").expect("a row");
                assert_eq!(row.status == Status::Missing, wanted.is_some());
                let json = ironout_analysis::outcome::json::object(&diagnosis);
                let rows = json["candidates"].as_array().expect("rows");
                let stated = rows
                    .iter()
                    .find(|row| row["id"] == "axis-order")
                    .and_then(|row| row.get("order"))
                    .cloned();
                assert_eq!(stated, wanted.map(serde_json::Value::from));
            }
        }
    }
}
