//! The difference of two models, carried over to the text of a model file.
//!
//! Both models are written out as TOML and compared item by item. Where a number differs, the number at the same place of the
//! user's text is replaced, and its comment stays. What the text does not have yet is added at its end.

use crate::model::Model;
use anyhow::{Context, Result};
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// `text`, which describes `before`, changed so that it describes `after`.
pub(super) fn merge(text: &str, before: &Model, after: &Model) -> Result<String> {
    let mut document: DocumentMut = text.parse().context("the model file is not TOML")?;
    let written = |model: &Model| {
        toml_edit::ser::to_document(model).context("the model cannot be written as TOML")
    };
    let (before, after) = (written(before)?, written(after)?);
    for (key, new) in after.iter() {
        let old = before.get(key);
        if old.is_some_and(|old| same(old, new)) {
            continue;
        }
        match (document.get_mut(key), new.as_array(), old) {
            (Some(item), Some(new), old) if is_list_of_tables(new) => {
                let count = old.and_then(Item::as_array).map_or(0, Array::len);
                if let Some(old) = old {
                    merge_item(item, old, &Item::Value(Value::Array(new.clone())));
                }
                append(&mut document, key, new.iter().skip(count));
            }
            (Some(item), _, Some(old)) => merge_item(item, old, new),
            (None, Some(new), _) => append(&mut document, key, new.iter()),
            (None, None, old) => add_section(&mut document, key, old, new),
            (Some(_), _, None) => {}
        }
    }
    Ok(document.to_string())
}

/// `text` without the effects with an id; every other line stays, except comments directly above such an effect.
pub(super) fn without_effect(text: &str, id: &str) -> Result<String> {
    let mut document: DocumentMut = text.parse().context("the model file is not TOML")?;
    if let Some(Item::Value(Value::Array(effects))) = document.get_mut("effect") {
        effects.retain(|effect| {
            let table = effect.as_inline_table();
            table.and_then(|t| t.get("id")).and_then(Value::as_str) != Some(id)
        });
        if effects.is_empty() {
            document.remove("effect");
        }
        return Ok(document.to_string());
    }
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let mut kept: Vec<&str> = Vec::with_capacity(lines.len());
    let mut at = 0;
    while at < lines.len() {
        if lines[at].trim_start().starts_with("[[effect]]") {
            let end = end_of_effect(&lines, at);
            let body: DocumentMut = lines[at..end].concat().parse()?;
            let of_id = |table: &Table| table.get("id").and_then(Item::as_str) == Some(id);
            let effects = body.get("effect").and_then(Item::as_array_of_tables);
            if effects.is_some_and(|effects| effects.iter().any(of_id)) {
                while kept.last().is_some_and(|line| is_comment(line)) {
                    kept.pop();
                }
                at = end;
                continue;
            }
        }
        kept.push(lines[at]);
        at += 1;
    }
    Ok(kept.concat())
}

/// The line after the last one of the effect whose header is in line `at`.
fn end_of_effect(lines: &[&str], at: usize) -> usize {
    let is_header = |line: &&str| {
        let line = line.trim_start();
        let name = line.trim_start_matches('[');
        let named = name.starts_with(|c: char| c.is_ascii_alphabetic());
        line.starts_with('[') && named && !line.starts_with("[effect.")
    };
    let next = lines[at + 1..].iter().position(is_header);
    let mut end = next.map_or(lines.len(), |n| at + 1 + n);
    while end > at + 1 && (is_comment(lines[end - 1]) || lines[end - 1].trim().is_empty()) {
        end -= 1;
    }
    end
}

fn is_comment(line: &str) -> bool {
    line.trim_start().starts_with('#')
}

/// Whether two items have the same value.
fn same(a: &Item, b: &Item) -> bool {
    a.to_string().trim() == b.to_string().trim()
}

fn is_list_of_tables(array: &Array) -> bool {
    array.iter().next().is_some_and(Value::is_inline_table)
}

/// Changes an item of the user's where `old` and `new` differ.
fn merge_item(user: &mut Item, old: &Item, new: &Item) {
    if let (Some(old), Some(new)) = (old.as_table_like(), new.as_table_like()) {
        if let Some(user) = user.as_table_like_mut() {
            merge_table(user, old, new);
        }
        return;
    }
    match user {
        Item::ArrayOfTables(tables) => {
            let (Some(old), Some(new)) = (old.as_array(), new.as_array()) else {
                return;
            };
            for ((user, old), new) in tables.iter_mut().zip(old).zip(new) {
                if let (Some(old), Some(new)) = (old.as_inline_table(), new.as_inline_table()) {
                    merge_table(user, old, new);
                }
            }
        }
        Item::Value(user) => {
            if let (Some(old), Some(new)) = (old.as_value(), new.as_value()) {
                merge_value(user, old, new);
            }
        }
        Item::None | Item::Table(_) => {}
    }
}

fn merge_table(user: &mut dyn TableLike, old: &dyn TableLike, new: &dyn TableLike) {
    for (key, _) in old.iter() {
        if new.get(key).is_none() {
            user.remove(key);
        }
    }
    for (key, new) in new.iter() {
        let old = old.get(key);
        if old.is_some_and(|old| same(old, new)) {
            continue;
        }
        match (user.get_mut(key), old, new.as_value()) {
            (Some(item), Some(old), _) => merge_item(item, old, new),
            // The user's text does not have it, as it was the default.
            (_, _, Some(new)) => {
                user.insert(key, Item::Value(fresh(new)));
            }
            _ => {}
        }
    }
}

fn merge_value(user: &mut Value, old: &Value, new: &Value) {
    match (&mut *user, old, new) {
        (Value::InlineTable(user), Value::InlineTable(old), Value::InlineTable(new)) => {
            merge_table(user, old, new);
        }
        (Value::Array(user), Value::Array(old), Value::Array(new))
            if user.len() == old.len() && user.len() <= new.len() =>
        {
            for ((user, old), new) in user.iter_mut().zip(old).zip(new) {
                if old.to_string() != new.to_string() {
                    merge_value(user, old, new);
                }
            }
        }
        _ => {
            let decor = user.decor().clone();
            *user = fresh(new);
            *user.decor_mut() = decor;
        }
    }
}

/// A value in our own formatting.
fn fresh(value: &Value) -> Value {
    match value {
        // The debug format has an exponent where a row of zeros would be.
        Value::Float(number) => format!("{:?}", number.value())
            .parse()
            .unwrap_or_else(|_| value.clone()),
        Value::Array(array) => Value::Array(array.iter().map(fresh).collect()),
        Value::InlineTable(table) => {
            let pairs = table.iter().map(|(key, value)| (key, fresh(value)));
            Value::InlineTable(pairs.collect::<InlineTable>())
        }
        Value::String(text) => text.value().as_str().into(),
        Value::Integer(number) => (*number.value()).into(),
        Value::Boolean(flag) => (*flag.value()).into(),
        Value::Datetime(time) => (*time.value()).into(),
    }
}

/// Adds tables to a list of tables; a new list begins at the end of the document.
fn append<'a>(document: &mut DocumentMut, key: &str, new: impl Iterator<Item = &'a Value>) {
    let last = last_position(document.as_table());
    for value in new.filter_map(Value::as_inline_table) {
        if let Some(Item::Value(Value::Array(list))) = document.get_mut(key) {
            list.push(fresh(&Value::InlineTable(value.clone())));
            continue;
        }
        let mut table = Table::new();
        for (name, value) in value {
            table.insert(name, Item::Value(fresh(value)));
        }
        let list = document.get(key).and_then(Item::as_array_of_tables);
        let place = list
            .and_then(|list| list.iter().last())
            .map(Table::position);
        match place {
            None => place_at_end(document, &mut table, last),
            Some(before) if before.is_none_or(|at| at >= last) => {
                take_trailing(document, &mut table);
            }
            Some(_) => {}
        }
        let list = Item::ArrayOfTables(ArrayOfTables::new());
        let item = document.entry(key).or_insert(list);
        if let Some(list) = item.as_array_of_tables_mut() {
            list.push(table);
        }
    }
}

/// Adds a section with the values that differ from `old`.
fn add_section(document: &mut DocumentMut, key: &str, old: Option<&Item>, new: &Item) {
    let Some(new) = new.as_table_like() else {
        return;
    };
    let mut table = Table::new();
    let nothing = Table::new();
    let old = old.and_then(Item::as_table_like).unwrap_or(&nothing);
    for (name, value) in new.iter() {
        let differs = !old.get(name).is_some_and(|old| same(old, value));
        if let Some(value) = value.as_value().filter(|_| differs) {
            table.insert(name, Item::Value(fresh(value)));
        }
    }
    let last = last_position(document.as_table());
    place_at_end(document, &mut table, last);
    document.insert(key, Item::Table(table));
}

fn place_at_end(document: &mut DocumentMut, table: &mut Table, last: isize) {
    table.set_position(Some(last + 1));
    take_trailing(document, table);
}

/// Comments at the end of the text stay before what is added behind them.
fn take_trailing(document: &mut DocumentMut, table: &mut Table) {
    let trailing = document.trailing().as_str().unwrap_or_default().to_owned();
    let end = if trailing.is_empty() || trailing.ends_with('\n') {
        ""
    } else {
        "\n"
    };
    table.decor_mut().set_prefix(format!("{trailing}{end}\n"));
    document.set_trailing("");
}

/// Position of the last table of the text.
fn last_position(table: &dyn TableLike) -> isize {
    let inner = |item: &Item| match item {
        Item::Table(table) => table.position().unwrap_or(0).max(last_position(table)),
        Item::ArrayOfTables(tables) => tables
            .iter()
            .map(|table| table.position().unwrap_or(0).max(last_position(table)))
            .max()
            .unwrap_or(0),
        Item::None | Item::Value(_) => 0,
    };
    table.iter().map(|(_, item)| inner(item)).max().unwrap_or(0)
}
