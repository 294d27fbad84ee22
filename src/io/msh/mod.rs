//! Gmsh MSH 2.2 and 4.1, ASCII and binary.

mod cursor;
mod element;
mod groups;
mod reader;

pub(super) use reader::parse;
