//! Prints how long each scene takes: `cargo run --release -p taxel-scenes --example speed`.

use std::time::Instant;

fn main() -> taxel_scenes::Result<()> {
    for (name, samples) in [("fingertip", 1500), ("palpation", 1440), ("gripper", 1500)] {
        let start = Instant::now();
        let scene = taxel_scenes::simulate(name, samples, 0, &[])?;
        println!("{name}: {:?} in {:.2} s", scene.x.shape(), start.elapsed().as_secs_f64());
    }
    Ok(())
}
