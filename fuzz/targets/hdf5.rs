#![no_main]
taxel_fuzz::target!("hdf5");
