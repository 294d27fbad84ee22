//! Abaqus INP: parts, instances and their assembly, as one mesh.

mod assembly;
mod data;
mod element;
mod keyword;
mod reader;
mod resolver;
mod scope;

pub(super) use reader::parse;
