#![no_main]
taxel_fuzz::target!("labels");
