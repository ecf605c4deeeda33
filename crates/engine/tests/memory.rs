//! Training does not grow. Alone in its process, since it reads the memory of the whole of it.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use taxel_engine::Adam;

fn resident_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

#[test]
fn a_thousand_steps_take_no_more_memory_than_a_hundred() {
    let mut engine = common::engine(8, 2, &[]);
    let mut steps = |count: u64| {
        for step in 0..count {
            common::pass(&mut engine, if step % 5 == 4 { 3 } else { 8 }, step);
            engine.clip_gradients(1.0);
            engine.adam(&Adam::default());
        }
        resident_kib()
    };
    let (early, late) = (steps(100), steps(900));
    assert!(late <= early + 256, "{early} KiB after 100 steps, {late} KiB after 1000");
}
