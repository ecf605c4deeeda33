//! Prints digests of what every network of the zoo predicts, for `tests/bits.rs`.

use std::error::Error;

#[path = "../tests/common/bits.rs"]
mod bits;

fn main() -> Result<(), Box<dyn Error>> {
    println!("{}", serde_json::to_string_pretty(&bits::of_zoo(u64::MAX)?)?);
    Ok(())
}
