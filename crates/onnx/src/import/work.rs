//! Everything known of a file while its nodes are read, and the questions that they ask of it.

use std::collections::HashMap;

use taxel_graph::{Op, Tensor};

use super::attributes::Call;
use super::draft::Draft;
use super::stored::StoredTensors;
use super::values::{AxisRole, AxisView, Dim, Fragment, Id, ImportedValue};
use crate::error::Cause;

/// The reading of one file.
pub struct Importer<'a> {
    pub draft: Draft,
    pub stored: StoredTensors<'a>,
    /// Values by their names.
    pub values: HashMap<&'a str, ImportedValue>,
    /// How many nodes and outputs read a value.
    pub uses: HashMap<&'a str, usize>,
    /// The number of samples, where the file fixes one.
    pub batch: Option<i64>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl<'a> Importer<'a> {
    /// Returns the value of input `at`.
    pub fn value(&self, call: Call<'a>, at: usize) -> Result<&ImportedValue, Cause> {
        let Some(name) = call.input(at) else { return Err(call.refuse(format!("has no input {at}"))) };
        self.values.get(name).ok_or_else(|| {
            call.refuse(format!(
                "reads `{name}`, which no node before it gives; taxel reads the first output of most operations"
            ))
        })
    }

    /// Returns input `at`, which a node computes; zeros around it may not be counted yet.
    pub fn padded(&self, call: Call<'a>, at: usize) -> Result<AxisView, Cause> {
        let name = call.input(at).unwrap_or_default();
        match self.value(call, at)? {
            ImportedValue::Flow(view) => Ok(view.clone()),
            ImportedValue::Part(part, _) => Err(call.refuse(format!("reads {}", words(*part)))),
            ImportedValue::Stored { .. }
            | ImportedValue::Ints { .. }
            | ImportedValue::IntTable(_)
            | ImportedValue::Fill(_) => {
                Err(call.refuse(format!("reads the constant `{name}` where taxel reads what samples become")))
            }
        }
    }

    /// Returns input `at`, which a node computes.
    pub fn flow(&self, call: Call<'a>, at: usize) -> Result<AxisView, Cause> {
        let view = self.padded(call, at)?;
        call.refuse_if(
            !view.pad.is_empty(),
            "reads padded values; taxel knows padding of zeros before a convolution or an average pool alone",
        )?;
        Ok(view)
    }

    /// Returns input `at`, of which every value can be taken for itself.
    pub fn pointwise(&self, call: Call<'a>, at: usize) -> Result<AxisView, Cause> {
        let view = self.flow(call, at)?;
        self.refuse_steps(call, &view)?;
        Ok(view)
    }

    /// Checks whether input `at` is stored under a name of its own.
    pub fn is_named(&self, call: Call<'a>, at: usize) -> bool {
        let value = call.input(at).and_then(|name| self.values.get(name));
        matches!(value, Some(ImportedValue::Stored { index, .. }) if self.stored.name(*index).is_some())
    }

    /// Returns input `at` with samples, then the axes of its node in their order, then `units` axes of one value.
    pub fn ordered(&self, call: Call<'a>, at: usize, units: usize) -> Result<AxisView, Cause> {
        let view = self.flow(call, at)?;
        self.refuse_order(call, &view, units)?;
        Ok(view)
    }

    /// Refuses axes in another order than samples, then those of the node.
    pub fn refuse_order(&self, call: Call<'a>, view: &AxisView, units: usize) -> Result<(), Cause> {
        self.refuse_steps(call, view)?;
        if view.is_plain(self.shape(view.node).len(), units) {
            Ok(())
        } else {
            Err(call.refuse(
                "reads axes that are not samples, channels and space, in this order: taxel turns axes only before a \
                 recurrent layer and in a channel shuffle",
            ))
        }
    }

    fn refuse_steps(&self, call: Call<'a>, view: &AxisView) -> Result<(), Cause> {
        if view.axes.contains(&AxisRole::Step) {
            Err(call.refuse("reads every step of a recurrent layer; taxel's answer their last step alone"))
        } else {
            Ok(())
        }
    }

    /// Returns the shape of a node, batch axis left out.
    pub fn shape(&self, node: Id) -> &[usize] {
        &self.draft.node(node).shape
    }

    /// Returns the steps of a recurrent layer; 1 of any other node.
    pub fn steps(&self, node: Id) -> usize {
        match self.draft.node(node).op {
            Op::Lstm { steps, .. } | Op::Gru { steps, .. } => steps,
            _ => 1,
        }
    }

    /// Checks whether input `at` is a stored tensor.
    pub fn is_stored(&self, call: Call<'a>, at: usize) -> bool {
        call.input(at)
            .and_then(|name| self.values.get(name))
            .is_some_and(|value| matches!(value, ImportedValue::Stored { .. }))
    }

    /// Reads input `at`, a stored tensor.
    pub fn floats(&mut self, call: Call<'a>, at: usize) -> Result<Tensor, Cause> {
        match *self.value(call, at)? {
            ImportedValue::Stored { index, transposed } => {
                let tensor = self.stored.floats(index)?;
                Ok(if transposed { swapped(tensor) } else { tensor })
            }
            _ => {
                let name = call.input(at).unwrap_or_default();
                Err(call.refuse(format!("reads `{name}`, which is not stored in the file, as a weight")))
            }
        }
    }

    /// Reads input `at` if it is given, a stored tensor of one value.
    pub fn number(&mut self, call: Call<'a>, at: usize) -> Result<Option<f32>, Cause> {
        if call.input(at).is_none() {
            return Ok(None);
        }
        match self.floats(call, at)?.data[..] {
            [value] => Ok(Some(value)),
            _ => Err(call.refuse(format!("input {at} has to be one number"))),
        }
    }

    /// Reads input `at`, a stored truth value; none where it is something else.
    pub fn flag(&self, call: Call<'a>, at: usize) -> Result<Option<bool>, Cause> {
        Ok(match self.value(call, at)? {
            ImportedValue::Stored { index, .. } => self.stored.flag(*index),
            _ => None,
        })
    }

    /// Returns input `at` if it is given, a list that describes shapes.
    pub fn dims(&self, call: Call<'a>, at: usize) -> Result<Option<Vec<Dim>>, Cause> {
        if call.input(at).is_none() {
            return Ok(None);
        }
        match self.value(call, at)? {
            ImportedValue::Ints { values, .. } => Ok(Some(values.clone())),
            _ => Err(call.refuse(format!("input {at} has to be a list of at most 64 integers"))),
        }
    }

    /// Returns the same where the number of samples is not among them: as attribute `name` in older files.
    pub fn ints(&self, call: Call<'a>, name: &str, at: usize) -> Result<Option<Vec<i64>>, Cause> {
        if let Some(values) = call.ints(name) {
            return Ok(Some(values.to_vec()));
        }
        let Some(dims) = self.dims(call, at)? else { return Ok(None) };
        let known = |dim| match dim {
            Dim::Known(value) => Ok(value),
            Dim::Batch => Err(call.refuse(format!("`{name}` must not depend on the number of samples"))),
        };
        dims.into_iter().map(known).collect::<Result<_, _>>().map(Some)
    }

    /// Returns axes by the same way, counted from the start, of a value with `rank` axes.
    pub fn axes(&self, call: Call<'a>, at: usize, rank: usize) -> Result<Option<Vec<usize>>, Cause> {
        let Some(axes) = self.ints(call, "axes", at)? else { return Ok(None) };
        axes.into_iter().map(|axis| position(call, axis, rank)).collect::<Result<_, _>>().map(Some)
    }

    /// Checks whether one node alone reads input `at`.
    pub fn is_only_reader(&self, call: Call<'a>, at: usize) -> bool {
        call.input(at).and_then(|name| self.uses.get(name)) == Some(&1)
    }

    /// Adds a node without tensors that reads `view` value by value.
    pub fn map(&mut self, call: Call<'a>, op: Op, view: AxisView) -> Result<ImportedValue, Cause> {
        let node = self.draft.then(op, &[view.node]).map_err(|e| call.refuse(e))?;
        Ok(ImportedValue::Flow(AxisView { node, ..view }))
    }

    /// Takes a name for a node with tensors: that of its stored tensor `at` less one of `endings`, else its own in the
    /// file, else `kind`.
    pub fn name(&mut self, call: Call<'a>, at: usize, endings: &[&str], kind: &str) -> String {
        let stored = match call.input(at).and_then(|name| self.values.get(name)) {
            Some(ImportedValue::Stored { index, .. }) => self.stored.name(*index),
            _ => None,
        };
        let named = stored.and_then(|name| endings.iter().find_map(|ending| name.strip_suffix(ending)));
        let base = match named.filter(|name| !name.is_empty()) {
            Some(name) => name.to_string(),
            None => from_path(call, kind),
        };
        self.draft.name(&base)
    }
}

/// Makes `features.0` of `/features/features.0/Conv`: PyTorch names nodes by modules, those of a sequence twice.
fn from_path(call: Call, kind: &str) -> String {
    let name = call.node.name.as_deref().unwrap_or_default();
    let parts: Vec<&str> = name.split('/').filter(|part| !part.is_empty()).collect();
    match parts.as_slice() {
        [] => kind.into(),
        [one] if one.starts_with(call.op()) => kind.into(),
        [one] => one.to_string(),
        [modules @ .., _] => {
            let is_redundant = |at: usize| {
                let next = modules.get(at + 1).and_then(|next| next.strip_prefix(modules[at]));
                next.is_some_and(|rest| rest.starts_with('.'))
            };
            let kept: Vec<&str> =
                (0..modules.len()).filter(|&at| !is_redundant(at)).map(|at| modules[at]).collect();
            kept.join(".")
        }
    }
}

/// Returns an axis counted from the start.
pub fn position(call: Call, axis: i64, rank: usize) -> Result<usize, Cause> {
    let from_start = if axis < 0 { axis.checked_add(rank as i64) } else { Some(axis) };
    let position = from_start.and_then(|axis| usize::try_from(axis).ok()).filter(|axis| *axis < rank);
    position.ok_or_else(|| call.refuse(format!("axis {axis} of {rank} axes")))
}

/// Swaps two axes; leaves anything else as it is.
pub fn swapped(tensor: Tensor) -> Tensor {
    let [rows, columns] = tensor.shape[..] else { return tensor };
    let data = (0..rows * columns).map(|i| tensor.data[i % rows * columns + i / rows]).collect();
    Tensor { shape: vec![columns, rows], data }
}

fn words(part: Fragment) -> &'static str {
    match part {
        Fragment::Centred => "the difference from a mean",
        Fragment::Squared => "the square of a difference from a mean",
        Fragment::Variance { .. } => "a variance, of which taxel knows the root alone (with some ε in it)",
        Fragment::HardSigmoid => "a hard sigmoid, which taxel knows in a hard swish alone",
        Fragment::Probabilities => "probabilities; taxel knows a softmax at the end alone",
    }
}
