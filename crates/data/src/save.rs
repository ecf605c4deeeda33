//! A data set as an `.npz` with its names beside it, to be read back equal.

use std::io;
use std::path::{Path, PathBuf};

use serde_json::json;

use crate::dataset::Dataset;
use crate::write::Npz;
use crate::write_whole;

impl Dataset {
    /// Writes the samples as the `.npz` at `path` (`x`, `y`, where there are any `group` and `official`), and class names,
    /// layout, unit, rate, full scale and source as `<name>.classes.json` beside it: [`load`](crate::load) reads samples
    /// of the same digest. Rest values and the table or topics that samples were cut from are not kept.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        let n = self.len();
        let mut npz = Npz::default();
        let x = self.x.as_standard_layout();
        npz.add("x", x.shape(), x.as_slice().unwrap_or_default())?;
        let columns = self.columns.as_ref().unwrap_or(&self.labels);
        let width = columns.attributes().len();
        let shape = if width == 1 { vec![n] } else { vec![n, width] };
        npz.add("y", &shape, columns.values())?;
        if let Some(groups) = &self.groups {
            npz.add("group", &[n], groups)?;
        }
        if let Some(official) = &self.official {
            npz.add("official", &[n], &official.iter().map(|own| u8::from(*own)).collect::<Vec<_>>())?;
        }
        let classes: Vec<_> = columns.attributes().iter().map(|own| own.classes.clone()).collect();
        let classes = if width == 1 { json!(self.classes) } else { json!(classes) };
        let reading = &self.reading;
        let names = json!({
            "classes": classes, "layout": reading.layout, "unit": reading.unit, "rate": reading.rate,
            "full_scale": reading.full_scale, "source": self.source.to_string(),
        });
        write_whole(path, &npz.finish()?)?;
        let beside: PathBuf = path.with_extension("classes.json");
        write_whole(&beside, format!("{names:#}\n").as_bytes())
    }
}
