//! Data lines: what they mean under the keyword above them.

use super::super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::super::text;
use super::element::ElementKind;
use super::keyword::{fields, unquoted};
use super::reader::{Block, Reader, at, is_number};
use super::scope::{Element, Member, SetKind};
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

impl Reader {
    pub(super) fn data(&mut self, line: &str) -> Result<()> {
        let words = fields(line.trim_end_matches(','));
        // Taken out so that the block can be read while the scope is written.
        let block = std::mem::replace(&mut self.block, Block::Other);
        let done = match &block {
            Block::Other => Ok(()),
            Block::Instance => self.placing(&words),
            Block::Nodes { set } => self.node(&words, set.as_deref()),
            Block::Elements { kind, name, set } => {
                self.element_words(&words, *kind, name, set.as_deref(), line.ends_with(','))
            }
            Block::Set { kind, name, generate: true, instance } => {
                self.generate(&words, *kind, name, *instance)
            }
            Block::Set { kind, name, generate: false, instance } => {
                self.members(&words, *kind, name, *instance)
            }
            Block::Surface { name, of_nodes, instance } => self.surface(&words, name, *of_nodes, *instance),
        };
        self.block = block;
        done
    }

    fn id(&self, word: &str, what: &'static str) -> Result<u64> {
        let value = text::integer(word, || self.at(what))?;
        text::id(value, what, || self.at(what))
    }

    /// A line that places an instance: a shift, then a turn about the line through two points.
    fn placing(&mut self, words: &[&str]) -> Result<()> {
        let numbers = words
            .iter()
            .map(|word| if word.is_empty() { Ok(0.) } else { text::number(word, || self.at("INSTANCE")) })
            .collect::<Result<Vec<f64>>>()?;
        let expected = "a shift of 3 numbers, or 2 points and an angle of 7";
        let shown = words.join(", ");
        let Some(instance) = self.instances.last_mut() else { return Ok(()) };
        if instance.place(&numbers) { Ok(()) } else { self.syntax("INSTANCE", expected, &shown) }
    }

    fn node(&mut self, words: &[&str], set: Option<&str>) -> Result<()> {
        let id = self.id(words[0], "node")?;
        // Commas part the fields here, so decimal commas show as twice as many whole numbers.
        let digits =
            |w: &&str| !w.is_empty() && w.trim_start_matches('-').bytes().all(|b| b.is_ascii_digit());
        if words.len() > 4 && words[1..].iter().all(digits) {
            let (value, fixed) = (text::shown(&words[1..].join(",")), words[1..3].join("."));
            return self.fail("x", MeshFileErrorKind::DecimalComma { value, fixed });
        }
        if words.len() != 4 && words.len() != 7 {
            return self.syntax("node", "number, x, y, z", &words.join(", "));
        }
        let mut point = Vec3::zeros();
        for ((x, word), field) in point.iter_mut().zip(&words[1..]).zip(["x", "y", "z"]) {
            *x = text::number(word, || self.at(field))?;
        }
        let scope = &mut self.scopes[self.scope];
        if scope.node_of.insert(id, scope.points.len()).is_some() {
            return self.fail("node", MeshFileErrorKind::DuplicateId { what: "node", id });
        }
        scope.points.push(point);
        scope.node_ids.push(id);
        if let Some(name) = set {
            self.entry(SetKind::Nodes, name, Member::Id(id), None);
        }
        Ok(())
    }

    fn element_words(
        &mut self,
        words: &[&str],
        kind: ElementKind,
        name: &str,
        set: Option<&str>,
        goes_on: bool,
    ) -> Result<()> {
        let (first, mut all) = self.unfinished.take().unwrap_or((self.spot, Vec::new()));
        all.extend(words.iter().map(|w| (*w).to_owned()));
        let wanted = match kind {
            ElementKind::Cell(_, n) => 1 + n,
            _ if goes_on => usize::MAX,
            _ => all.len(),
        };
        if all.len() < wanted && goes_on {
            self.unfinished = Some((first, all));
            return Ok(());
        }
        if all.len() != wanted {
            let expected = format!("a number and {} nodes of {name}", wanted - 1);
            return self.syntax("element", &expected, &format!("{} fields", all.len()));
        }
        let id = self.id(&all[0], "element")?;
        // What a spring or a connector joins may be nodes of other instances, the ground, or nothing.
        let nodes = match kind {
            ElementKind::Discrete => Vec::new(),
            _ => all[1..].iter().map(|w| self.id(w, "node")).collect::<Result<Vec<u64>>>()?,
        };
        let scope = &mut self.scopes[self.scope];
        if scope.element_of.insert(id, scope.elements.len()).is_some() {
            let at = at(&self.files, first).in_field("element");
            return Err(MeshFileError::new(at, MeshFileErrorKind::DuplicateId { what: "element", id }));
        }
        let (start, n) = (scope.connectivity.len(), nodes.len());
        scope.connectivity.extend(nodes);
        scope.elements.push(Element { id, kind, first: start, n, spot: first });
        if let Some(name) = set {
            self.entry(SetKind::Elements, name, Member::Id(id), None);
        }
        Ok(())
    }

    fn members(&mut self, words: &[&str], kind: SetKind, name: &str, instance: Option<u32>) -> Result<()> {
        let what = if kind == SetKind::Nodes { "node" } else { "element" };
        for word in words.iter().filter(|w| !w.is_empty()) {
            let member = match is_number(word) {
                true => Member::Id(self.id(word, what)?),
                false => Member::Named(unquoted(word).into()),
            };
            self.entry(kind, name, member, instance);
        }
        Ok(())
    }

    fn generate(&mut self, words: &[&str], kind: SetKind, name: &str, instance: Option<u32>) -> Result<()> {
        let what = if kind == SetKind::Nodes { "node" } else { "element" };
        let (first, last, step) = match *words {
            [only] => (only, only, "1"),
            [first, last] | [first, last, ""] => (first, last, "1"),
            [first, last, step] => (first, last, step),
            _ => return self.syntax(name, "first, last, step", &words.join(", ")),
        };
        let (first, last) = (self.id(first, what)?, self.id(last, what)?);
        let step = self.id(step, "step")?;
        if step == 0 || last < first {
            return self.syntax(name, "first <= last and a step of 1 or more", &words.join(", "));
        }
        self.entry(kind, name, Member::Range { first, last, step }, instance);
        Ok(())
    }

    fn surface(&mut self, words: &[&str], name: &str, of_nodes: bool, instance: Option<u32>) -> Result<()> {
        let of: Box<str> = unquoted(words[0]).into();
        let member = match words.get(1).map(|w| w.to_ascii_uppercase()) {
            _ if of_nodes => Member::NodeOrSet(of),
            None => Member::Faces { of, face: None },
            Some(side) => match side.strip_prefix('S').map(str::parse::<usize>) {
                Some(Ok(face @ 1..=6)) => Member::Faces { of, face: Some(face - 1) },
                // The sides of a shell have the same nodes.
                _ if matches!(side.as_str(), "" | "SPOS" | "SNEG") => Member::Faces { of, face: None },
                // Edges and ends of lines bound no volume.
                _ if side.starts_with('E') => return Ok(()),
                _ => return self.syntax(name, "a face from S1 to S6", words[1]),
            },
        };
        self.entry(SetKind::Surface, name, member, instance);
        Ok(())
    }

    pub(super) fn check_finished(&mut self) -> Result<()> {
        match self.unfinished.take() {
            None => Ok(()),
            Some((first, words)) => {
                let expected =
                    format!("the other nodes of element {} of line {}", text::shown(&words[0]), first.line);
                self.fail("element", MeshFileErrorKind::Truncated { expected })
            }
        }
    }
}
