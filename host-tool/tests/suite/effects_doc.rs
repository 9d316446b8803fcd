//! `docs/effects.md` says of each effect what the code says: id, name, cause, unit, number of coefficients.

use ironout::effect::{
    AmbientField, CrossAxis, Drift, Eddy, Effect, Gain, Lag, Nonlinearity, Offset, Past, Periodic, Power,
    Product, SoftIron, Step,
};

fn catalogue() -> Vec<Box<dyn Effect<f64>>> {
    let offset = |column, power, past| -> Box<dyn Effect<f64>> {
        Box::new(Offset { column, reference: 0.0, power, past })
    };
    vec![
        offset("temp_c", Power::Linear, Past::Now),
        offset("current_a", Power::Linear, Past::Now),
        offset("servo", Power::Linear, Past::Now),
        offset("current_a", Power::Squared, Past::Now),
        offset("current_a", Power::Linear, Past::Delayed(0.1)),
        offset("current_a", Power::Linear, Past::LowPass(2.0)),
        Box::new(SoftIron { column: "gripper", reference: 0.0 }),
        Box::new(Product { columns: "servo*current_a", reference: 0.0 }),
        Box::new(Gain { column: "temp_c", reference: 0.0 }),
        Box::new(AmbientField { column: "height_m", reference: 0.0 }),
        Box::new(Drift { reference_s: 0.0 }),
        Box::new(Step { at_s: 0.0 }),
        Box::new(Periodic { frequency_hz: 10.0, reference_s: 0.0 }),
        Box::new(Eddy),
        Box::new(Nonlinearity),
        Box::new(CrossAxis),
    ]
}

fn document() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/effects.md");
    std::fs::read_to_string(path).expect("the catalogue")
}

/// The section of an effect, its blanks single.
fn section(document: &str, title: &str) -> Option<String> {
    let from = document.find(&format!("\n## {title}\n"))?;
    let body = &document[from + 4..];
    let body = &body[..body.find("\n## ").unwrap_or(body.len())];
    Some(body.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[test]
fn every_effect_is_documented_as_it_is() {
    let document = document();
    for effect in catalogue() {
        let mut id = String::new();
        effect.id(&mut id).expect("an id");
        let name = effect.name();
        let section = section(&document, &format!("`{id}`: {name}"))
            .unwrap_or_else(|| panic!("no section `{id}`: {name}"));
        assert!(
            section.contains(effect.explanation()),
            "{id}: the cause has changed:\n{}",
            effect.explanation()
        );
        assert!(section.contains(&format!("Unit: {}", effect.unit())), "{id}: the unit is {}", effect.unit());
        let row = document
            .lines()
            .find(|line| line.starts_with(&format!("| `{id}` |")))
            .unwrap_or_else(|| panic!("no row for {id}"));
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        assert_eq!(cells[2], name);
        let count: String = cells[4].chars().take_while(char::is_ascii_digit).collect();
        assert_eq!(count.parse(), Ok(effect.coefficients()), "{id}");
        for column in effect.columns().iter().flatten() {
            let told = if column.name == "t_s" { "`t_s`" } else { "column" };
            assert!(
                cells[3].contains(told)
                    || cells[3].contains("a temperature")
                    || cells[3].contains("a current"),
                "{id} needs {}: {row}",
                column.name
            );
        }
        assert_eq!(effect.needs_gyro(), cells[3].contains("gyroscope"), "{row}");
    }
}

#[test]
fn the_pure_delay_is_told_beside_the_eddy_currents() {
    let section = section(&document(), "`lag`: lag and eddy currents").expect("a section");
    assert!(section.contains(Effect::<f64>::explanation(&Lag)));
    assert_eq!(Effect::<f64>::coefficients(&Lag), 1);
}

#[test]
fn every_section_is_of_an_effect_that_exists() {
    let ids: Vec<String> = catalogue()
        .iter()
        .map(|effect| {
            let mut id = String::new();
            effect.id(&mut id).expect("an id");
            id
        })
        .collect();
    let document = document();
    for line in document.lines().filter_map(|line| line.strip_prefix("## `")) {
        let id = line.split('`').next().unwrap_or("");
        assert!(ids.iter().any(|known| known == id), "{id} is documented but does not exist");
    }
}
