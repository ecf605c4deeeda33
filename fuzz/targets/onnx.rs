#![no_main]
taxel_fuzz::target!("onnx");
