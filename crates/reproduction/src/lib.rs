//! The study of five papers on touch, beside the product: what they claim, and what of it holds on our runs.
//!
//! The papers' networks, scenes and recipes are part of taxel; what is here only reads finished run folders and the pages of
//! `docs/results`. Nothing depends on this crate. Its binary writes the pages:
//!
//! - [`claims()`] tests every claim on runs; [`claims_page()`] keeps the findings and writes `claims.md`,
//!   [`claims_report()`] writes a page of these runs alone.
//! - [`papers_page()`] writes `papers.md`: every table of the papers, published, simulated and real side by side.
//! - [`shrink_page()`] makes a result page from a folder of `taxel shrink`.
//! - [`pin()`] writes what tests hold a small experiment of each paper to.
//!
//! ```
//! use taxel_reproduction::{Claim, Contrast, Verdict, claims_report};
//!
//! let interval = Some([-8.86, 1.13]);
//! let contrast = Contrast {
//!     effect: "accuracy: vgg6-lite-1d less vgg6-lite-2d, points".into(),
//!     size: -3.87,
//!     interval,
//!     refuting: interval,
//!     error: Some(1.8),
//!     p: Some(0.1),
//!     margin: Some(0.4),
//! };
//! let claim = Claim {
//!     paper: "000".into(),
//!     place: "section 5.1, Table 2".into(),
//!     says: "1D beats 2D: Vgg6-Lite".into(),
//!     run: "hardness".into(),
//!     source: taxel::Source::simulated("fingertip"),
//!     fresh: false,
//!     least: 0.0,
//!     contrasts: vec![contrast],
//!     lacks: None,
//! };
//! assert_eq!(claim.outcome(), Verdict::TooFewData);
//! let folder = tempfile::tempdir()?;
//! let page = claims_report(&[claim], folder.path())?;
//! assert!(std::fs::read_to_string(page)?.contains("too few data"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod claims;
mod claims_page;
mod claims_report;
mod error;
mod kept;
mod markdown;
mod measure;
mod pages;
mod papers_page;
mod pins;
mod printed;
mod shrink_page;
mod stitched;

pub use claims::{Claim, Contrast, Verdict, claims};
pub use claims_page::claims_page;
pub use claims_report::claims_report;
pub use error::{Error, Result};
pub use pages::Pages;
pub use papers_page::papers_page;
pub use pins::pin;
pub use printed::Papers;
pub use shrink_page::shrink_page;
