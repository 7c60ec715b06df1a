//! The list of all effects.

use softdock_physics::effects::{CATALOGUE, Effect, Group, Naming};
use softdock_report::{Cell, Column, Table};

/// Up to so many parameters are listed one by one; of more, only the first and the last are shown.
const LISTED: usize = 6;

/// A table of the effects of a group: title and parameters of each, and below them what the effect does.
pub fn overview(group: Group) -> Table {
    let mut table = Table::new(vec![
        Column::text("Effect"),
        Column::text("Title (parameters), and what it does"),
    ]);
    for effect in CATALOGUE.iter().filter(|effect| effect.group == group) {
        let caution = match effect.naming {
            Naming::Cause => "",
            Naming::Shape => ", reported only as \"looks like\"",
        };
        let named = format!("{} ({}){caution}", effect.title, parameters(effect));
        table.push(vec![Cell::text(effect.id), Cell::text(named)]);
        let indented = format!("  {}", effect.summary);
        table.push(vec![Cell::text(""), Cell::text(indented)]);
    }
    table
}

fn parameters(effect: &Effect) -> String {
    let sizes = effect.parameters.iter().filter(|p| !p.is_form());
    let names: Vec<&str> = sizes.map(|p| p.name).collect();
    match names.as_slice() {
        [first, .., last] if names.len() > LISTED => {
            format!("{} parameters, {first} to {last}", names.len())
        }
        _ => names.join(", "),
    }
}
