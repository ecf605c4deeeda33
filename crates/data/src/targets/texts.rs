//! Decides whether targets that are texts are values or names of classes.

use crate::dataset::labels::as_values;
use crate::formats::table::number_form::NumberForm;
use crate::options::ReadOptions;
use crate::targets::options::TaskKind;

/// Columns of targets as texts: a row of `names.len()` texts for each sample. An empty text is no target.
pub(crate) struct TextTargets<'t> {
    pub names: &'t [String],
    pub texts: &'t [String],
}

impl TextTargets<'_> {
    fn column(&self, at: usize) -> impl Iterator<Item = &String> {
        self.texts.iter().skip(at).step_by(self.names.len())
    }

    /// Returns values row by row, where the options, a fraction in one of the columns or quantities that are named in a file
    /// beside (`is_named`) say that targets are values; otherwise none. `place` names a row in messages.
    pub fn values(
        &self,
        options: &ReadOptions,
        is_named: bool,
        place: impl Fn(usize) -> String,
    ) -> Result<Option<Vec<f32>>, String> {
        let given = |at: usize| self.column(at).filter(|text| !text.is_empty()).cloned().collect::<Vec<_>>();
        let measured = (0..self.names.len()).find(|at| as_values(&given(*at)).is_some());
        if options.task == Some(TaskKind::Classes) {
            return measured.map_or(Ok(None), |at| Err(self.refused_classes(at)));
        }
        if !(options.wants_values() || measured.is_some() || is_named) {
            return Ok(None);
        }
        let number = |(at, text): (usize, &String)| {
            match text.as_str() {
            "" => Ok(f32::NAN),
            text => text.parse::<f64>().map(|number| number as f32).map_err(|_| {
                let (name, place) = (&self.names[at % self.names.len()], place(at / self.names.len()));
                let why = match measured {
                    Some(other) if options.task.is_none() => {
                        format!("{:?} are values, which stand with values only", self.names[other])
                    }
                    _ => "task = \"values\" takes numbers".into(),
                };
                let form = NumberForm::of(text).map_or(String::new(), |form| format!(" (it {})", form.hint()));
                format!("{place}: {name:?} is {text:?}, which is no number, and {why}; correct it{form}, or name another with y")
            }),
        }
        };
        self.texts.iter().enumerate().map(number).collect::<Result<_, _>>().map(Some)
    }

    /// Refuses values as classes.
    fn refused_classes(&self, at: usize) -> String {
        let has_fraction = |text: &&String| text.parse::<f64>().is_ok_and(|number| number.fract() != 0.0);
        let first = self.column(at).find(has_fraction).map_or("", String::as_str);
        format!(
            "{:?} has numbers with fractions, such as {first}, and task = \"classes\" takes whole numbers and texts; \
             leave task out to learn values, or round them",
            self.names[at]
        )
    }

    /// Returns the first row that lacks a label, and its column.
    pub fn first_empty(&self) -> Option<(usize, &String)> {
        let at = self.texts.iter().position(String::is_empty)?;
        Some((at / self.names.len(), &self.names[at % self.names.len()]))
    }
}
