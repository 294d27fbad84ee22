//! Holds a parsed target file against its schema: known keys, required keys, kinds of values.
//!
//! The schema is the one that is published, so that the two cannot drift apart, and the messages
//! name the field, its value and what it should be.

use serde_json::Value as Json;
use toml::de::{DeTable, DeValue};

use super::error::TargetFileError;
use super::lines::{FieldLines, join, plural};
use crate::io::nearest::nearest;

/// Checks `table`, which stands at `path`, against the object schema `schema`.
pub(in crate::io) fn check_table(
    table: &DeTable<'_>,
    schema: &Json,
    path: &str,
    lines: &FieldLines,
) -> Result<(), TargetFileError> {
    let any = schema.get("anyOf").and_then(Json::as_array).into_iter().flatten();
    let Some(schema) = std::iter::once(schema).chain(any).find(|s| s.get("properties").is_some()) else {
        return Ok(());
    };
    let Some(properties) = schema.get("properties").and_then(Json::as_object) else {
        return Ok(());
    };
    for (key, value) in table {
        let key = key.get_ref().as_ref();
        let field = join(path, plural(path, key));
        let Some(property) = properties.get(key) else {
            return Err(TargetFileError::UnknownField {
                at: Box::new(lines.location(&field)),
                nearest: nearest(key, properties.keys().map(String::as_str)).map(str::to_owned),
                accepted: properties.keys().cloned().collect(),
            });
        };
        check_value(value.get_ref(), property, &field, &describe(key, property), lines)?;
    }
    for required in schema.get("required").and_then(Json::as_array).into_iter().flatten() {
        let Some(key) = required.as_str() else { continue };
        if !table.keys().any(|k| k.get_ref() == key) {
            return Err(TargetFileError::MissingField {
                at: Box::new(lines.location(&join(path, key))),
                what: properties.get(key).map(|p| describe(key, p)).unwrap_or_default(),
            });
        }
    }
    Ok(())
}

/// `what` says what the innermost named field is.
fn check_value(
    value: &DeValue<'_>,
    schema: &Json,
    path: &str,
    what: &str,
    lines: &FieldLines,
) -> Result<(), TargetFileError> {
    if !has_kind(value, schema) {
        let (value, what) = (show(value), what.to_owned());
        return Err(TargetFileError::WrongKind { at: Box::new(lines.location(path)), value, what });
    }
    match value {
        DeValue::Table(table) => check_table(table, schema, path, lines),
        DeValue::Array(items) => {
            if let Some(expected) = schema.get("maxItems").and_then(Json::as_u64)
                && items.len() as u64 != expected
            {
                let (at, found, value) = (Box::new(lines.location(path)), items.len(), show(value));
                return Err(TargetFileError::WrongLength { at, found, expected, value });
            }
            let Some(item_schema) = items_of(schema) else { return Ok(()) };
            for (i, item) in items.iter().enumerate() {
                check_value(item.get_ref(), item_schema, &format!("{path}[{i}]"), what, lines)?;
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

fn items_of(schema: &Json) -> Option<&Json> {
    let any = schema.get("anyOf").and_then(Json::as_array);
    schema.get("items").or_else(|| any?.iter().find_map(|s| s.get("items")))
}

/// Whether a value is of one of the kinds that its schema allows.
fn has_kind(value: &DeValue<'_>, schema: &Json) -> bool {
    if let Some(any) = schema.get("anyOf").and_then(Json::as_array) {
        return any.iter().any(|s| has_kind(value, s));
    }
    let Some(kind) = schema.get("type").and_then(Json::as_str) else { return true };
    match (kind, value) {
        ("string", DeValue::String(text)) => match schema.get("enum").and_then(Json::as_array) {
            Some(names) => names.iter().any(|n| n.as_str() == Some(text)),
            None => true,
        },
        ("number", DeValue::Integer(_) | DeValue::Float(_))
        | ("array", DeValue::Array(_))
        | ("object", DeValue::Table(_)) => true,
        _ => false,
    }
}

fn describe(key: &str, schema: &Json) -> String {
    let text = schema.get("description").and_then(Json::as_str).unwrap_or_default();
    let text = text.replace('\n', " ");
    let is_list_of_tables = schema.pointer("/items/type").is_some_and(|t| t == "object");
    let form = if is_list_of_tables { format!("tables [[{key}]]: ") } else { String::new() };
    form + text.trim_end_matches('.')
}

/// The value as the file has it, shortened.
fn show(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("\"{text}\""),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(flag) => flag.to_string(),
        DeValue::Datetime(time) => time.to_string(),
        DeValue::Array(items) => {
            let items: Vec<String> = items.iter().take(8).map(|i| show(i.get_ref())).collect();
            format!("[{}]", items.join(", "))
        }
        DeValue::Table(_) => "a table".to_owned(),
    }
}
