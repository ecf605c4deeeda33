//! A node again, of another size.

use crate::error::Result;
use crate::fill::Fill;
use crate::graph::{Node, NodeId};
use crate::op::Op;

/// Rules whose numbers follow from the size of a weight; the number of any other stays as it is.
const BY_SIZE: [Fill; 4] =
    [Fill::Pytorch, Fill::KaimingNormalFanIn, Fill::KaimingNormalFanOut, Fill::KaimingUniformFanOut];

impl Node {
    /// Makes the node of this name that does `op` to `inputs` out of the `earlier` nodes. Its tensors start as this
    /// one's; those that are drawn for its size are drawn for the new one.
    pub(crate) fn resized(&self, op: Op, inputs: Vec<NodeId>, earlier: &[Node]) -> Result<Node> {
        let mut made = self.again(op, inputs, earlier)?;
        draw_by_size(self, &mut made)?;
        Ok(made)
    }
}

/// Has those tensors of `made` drawn for its size that are drawn for the size of `original`: as a rule says of the last
/// matrix, which in a recurrent layer is that of its hidden units.
fn draw_by_size(original: &Node, made: &mut Node) -> Result<()> {
    let matrix =
        |node: &Node| node.params.iter().map(|param| param.shape.clone()).rfind(|shape| shape.len() > 1);
    let (Some(old), Some(new)) = (matrix(original), matrix(made)) else { return Ok(()) };
    for param in &mut made.params {
        let says = |rule: &Fill| rule.resolve(&param.name, &old).is_ok_and(|init| init == param.init);
        if let Some(rule) = BY_SIZE.into_iter().find(says) {
            param.init = rule.resolve(&param.name, &new)?;
        }
    }
    Ok(())
}
