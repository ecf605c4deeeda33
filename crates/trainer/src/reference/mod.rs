//! The reference of a config: its JSON schema, and the page of it.

mod page;
mod schema;
mod texts;

pub use page::page;
pub use schema::schema;
