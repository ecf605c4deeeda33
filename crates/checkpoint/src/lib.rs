//! Named tensors on disk: `.safetensors` both ways and, with the cargo feature `pth`, PyTorch's `.pth` inwards.
//!
//! ```
//! use taxel_graph::{Tensor, Weights};
//!
//! let mut weights = Weights::new();
//! weights.insert("head.bias", Tensor { shape: vec![2], data: vec![0.5, -1.0] });
//! let bytes = taxel_checkpoint::to_bytes(&weights, "two classes")?;
//! let (read, text) = taxel_checkpoint::from_bytes(&bytes)?;
//! assert_eq!((read, text.as_deref()), (weights, Some("two classes")));
//! # Ok::<(), taxel_checkpoint::Cause>(())
//! ```

mod eight_bits;
mod error;
mod halves;
mod network;
#[cfg(feature = "pth")]
mod pickle;
#[cfg(feature = "pth")]
mod pth;
mod safetensors;
mod stored;

use std::fs::File;
use std::path::Path;

use taxel_base::files::{read_bytes, remove_parts, write_whole};
use taxel_graph::Weights;

pub use eight_bits::rounded;
pub use error::{Cause, Error, Result};
pub use halves::halved;
pub use network::{network_from_bytes, network_to_bytes, read_network, write_network};
pub use safetensors::{from_bytes, to_bytes};

/// The format of a file, by its ending.
enum FileType {
    Safetensors,
    Pth,
}

impl FileType {
    fn of(path: &Path) -> std::result::Result<Self, Cause> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("safetensors") => Ok(FileType::Safetensors),
            Some("pth" | "pt") => Ok(FileType::Pth),
            _ => Err(Cause::Kind),
        }
    }
}

/// Reads `.safetensors` or `.pth`/`.pt`; the text is taxel's metadata, if the file has some. All values become
/// `f32`; PyTorch's `num_batches_tracked` is let pass.
///
/// # Errors
/// A file that is missing, broken or of another kind, and tensors that are not floating point. Of a file that taxel did not
/// write also values that are not finite, and variances below 0.
pub fn read(path: &Path) -> Result<(Weights, Option<String>)> {
    let weights = || match FileType::of(path)? {
        FileType::Safetensors => from_bytes(&read_bytes(path)?),
        FileType::Pth => Ok((read_pth(path)?, None)),
    };
    let sound = || -> std::result::Result<_, Cause> {
        let (weights, text) = weights()?;
        // What taxel wrote is read as it was, so that a diverged training can be looked at.
        if text.is_none() {
            weights.refuse_unsound().map_err(|error| Cause::Unsound(error.into()))?;
        }
        Ok((weights, text))
    };
    sound().map_err(|cause| Error::new(path, cause))
}

/// Reads the text that [`write()`] kept in a `.safetensors`, from the file's header alone; none in other files.
///
/// # Errors
/// A file that is missing, broken or of another kind. Values are not read, so damage there is not seen.
pub fn read_text(path: &Path) -> Result<Option<String>> {
    let text = || match FileType::of(path)? {
        FileType::Safetensors => {
            let mut file = File::open(path)?;
            let length = file.metadata()?.len();
            safetensors::read_text(&mut file, length)
        }
        FileType::Pth => Ok(None),
    };
    text().map_err(|cause| Error::new(path, cause))
}

/// Writes `.safetensors`, under a temporary name first: a reader never sees half a file. Equal weights and text
/// give equal bytes.
///
/// # Errors
/// A tensor whose values are not as many as its shape says, and a folder that is missing or cannot be written.
pub fn write(path: &Path, weights: &Weights, text: &str) -> Result<()> {
    write_bytes(path, to_bytes(weights, text))
}

/// Writes the bytes of a file, whole or not at all, and removes what a killed process has left of it; where there are
/// none, the error that says why gets its path.
///
/// # Errors
/// That of `bytes`, and a folder that is missing or cannot be written.
pub fn write_bytes(path: &Path, bytes: std::result::Result<Vec<u8>, Cause>) -> Result<()> {
    let write = |bytes: Vec<u8>| {
        // What cannot be removed is in nobody's way.
        let _ = remove_parts(path);
        write_whole(path, &bytes).map_err(Cause::Write)
    };
    bytes.and_then(write).map_err(|cause| Error::new(path, cause))
}

/// Returns [`to_bytes`], with the tensors of these names in eight bits ([`rounded`]) and their scales beside them.
///
/// # Errors
/// A tensor whose values are not as many as its shape says.
pub fn to_bytes_rounded(
    weights: &Weights,
    names: &[&str],
    text: &str,
) -> std::result::Result<Vec<u8>, Cause> {
    safetensors::to_bytes_of(&eight_bits::apart(weights, names), text)
}

/// Returns [`to_bytes`], with the tensors of these names in bf16 ([`halved`]).
///
/// # Errors
/// A tensor whose values are not as many as its shape says.
pub fn to_bytes_halved(weights: &Weights, names: &[&str], text: &str) -> std::result::Result<Vec<u8>, Cause> {
    safetensors::to_bytes_of(&halves::apart(weights, names), text)
}

#[cfg(feature = "pth")]
use pth::read as read_pth;

#[cfg(not(feature = "pth"))]
fn read_pth(_: &Path) -> std::result::Result<Weights, Cause> {
    Err(Cause::NoPthReader)
}
