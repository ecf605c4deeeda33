//! The live page of `taxel stream` and `taxel record`: readings, decisions and the state of the sensors in a browser.

mod http;
mod hub;
mod page;

pub use page::{LivePage, ServeOptions};
