//! Attributes and inputs of one ONNX node.

use std::fmt::Display;

use crate::error::Cause;
use crate::proto::{Attribute, Node, Tensor};

/// A node of the file.
#[derive(Clone, Copy)]
pub struct Call<'a> {
    pub node: &'a Node,
}

impl<'a> Call<'a> {
    /// Returns the name of the operation.
    pub fn op(&self) -> &'a str {
        self.node.op.as_deref().unwrap_or_default()
    }

    /// Returns the name for messages: that of its first output where it has none.
    pub fn name(&self) -> &'a str {
        let name = self.node.name.as_deref().filter(|name| !name.is_empty());
        name.or(self.node.outputs.first().map(String::as_str)).unwrap_or("without a name")
    }

    /// Returns the name of input `at`, if it is given.
    pub fn input(&self, at: usize) -> Option<&'a str> {
        self.node.inputs.get(at).map(String::as_str).filter(|name| !name.is_empty())
    }

    /// Says why it cannot be read.
    pub fn refuse(&self, reason: impl Display) -> Cause {
        let (node, operation) = (self.name().into(), self.op().into());
        Cause::Node { node, operation, reason: reason.to_string() }
    }

    /// Refuses the node for `reason` if `wrong`.
    pub fn refuse_if(&self, wrong: bool, reason: impl Display) -> Result<(), Cause> {
        if wrong { Err(self.refuse(reason)) } else { Ok(()) }
    }

    fn attribute(&self, name: &str) -> Option<&'a Attribute> {
        self.node.attributes.iter().find(|attribute| attribute.name.as_deref() == Some(name))
    }

    pub fn int(&self, name: &str, default: i64) -> i64 {
        self.attribute(name).map_or(default, |attribute| attribute.i.unwrap_or_default())
    }

    pub fn float(&self, name: &str, default: f32) -> f32 {
        self.attribute(name).map_or(default, |attribute| attribute.f.unwrap_or_default())
    }

    pub fn ints(&self, name: &str) -> Option<&'a [i64]> {
        self.attribute(name).map(|attribute| attribute.ints.as_slice())
    }

    pub fn floats(&self, name: &str) -> Option<&'a [f32]> {
        self.attribute(name).map(|attribute| attribute.floats.as_slice())
    }

    pub fn tensor(&self, name: &str) -> Option<&'a Tensor> {
        self.attribute(name).and_then(|attribute| attribute.t.as_deref())
    }

    pub fn text(&self, name: &str) -> Option<&'a str> {
        let bytes = self.attribute(name)?.s.as_ref()?;
        std::str::from_utf8(bytes).ok()
    }

    pub fn texts(&self, name: &str) -> Vec<&'a str> {
        let strings = self.attribute(name).map_or(&[][..], |attribute| &attribute.strings);
        strings.iter().map(|bytes| std::str::from_utf8(bytes).unwrap_or_default()).collect()
    }

    pub fn has(&self, name: &str) -> bool {
        self.attribute(name).is_some()
    }
}
