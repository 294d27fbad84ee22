//! JSON schemas of the files that users script against.

use schemars::transform::{RecursiveTransform, Transform};
use schemars::{JsonSchema, Schema, generate::SchemaSettings};

/// The schema of `T`, draft 2020-12, without references.
///
/// TOML has no null and our readers accept none, so an optional field is one that may be absent.
pub(super) fn schema_of<T: JsonSchema>(settings: SchemaSettings) -> Schema {
    let mut schema =
        settings.with(|s| s.inline_subschemas = true).into_generator().into_root_schema_for::<T>();
    RecursiveTransform(drop_formats).transform(&mut schema);
    schema
}

/// The schema of `T` as TOML: null is dropped everywhere.
pub(super) fn toml_schema_of<T: JsonSchema>() -> Schema {
    let mut schema = schema_of::<T>(SchemaSettings::draft2020_12());
    RecursiveTransform(drop_null).transform(&mut schema);
    schema
}

fn drop_formats(schema: &mut Schema) {
    schema.remove("format");
}

fn drop_null(schema: &mut Schema) {
    if schema.get("default").is_some_and(serde_json::Value::is_null) {
        schema.remove("default");
    }
    let only = schema.get_mut("type").and_then(|t| t.as_array_mut()).and_then(|types| {
        types.retain(|t| t != "null");
        (types.len() == 1).then(|| types[0].clone())
    });
    if let Some(only) = only {
        schema.insert("type".to_owned(), only);
    }
    let lone = schema.get_mut("anyOf").and_then(|a| a.as_array_mut()).and_then(|any| {
        any.retain(|s| s.get("type").is_none_or(|t| t != "null"));
        (any.len() == 1).then(|| any[0].clone())
    });
    if let Some(serde_json::Value::Object(lone)) = lone {
        schema.remove("anyOf");
        for (key, value) in lone {
            if schema.get(&key).is_none() {
                schema.insert(key, value);
            }
        }
    }
    if let Some(values) = schema.get_mut("enum").and_then(|e| e.as_array_mut()) {
        values.retain(|v| !v.is_null());
    }
}

/// The text of a schema file: indented, with a final newline.
pub(super) fn pretty(schema: &Schema) -> String {
    format!("{:#}\n", schema.as_value())
}
