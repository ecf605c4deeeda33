#![no_main]
taxel_fuzz::target!("tsv");
