//! Reads `.ts` files of the UCR and UEA archives: a head that says how cases are written, then one case a line.

use crate::Result;
use crate::formats::ucr::case::{Case, CaseLine, CaseTargets};

/// The keys of a head, for messages.
const KEYS: &str = "@problemName, @timeStamps, @missing, @univariate, @dimensions, @equalLength, @seriesLength, \
                    @classLabel, @targetLabel and @data";

/// Hands every case to `take`: channels and at last the class or target, parted by `:`; values by `,`.
///
/// A case that is not as the head says is refused, and so is a head that says what is not read.
pub(crate) fn read(text: &str, file: &str, take: &mut dyn FnMut(Case) -> Result<()>) -> Result<CaseTargets> {
    let (mut head, mut targets) = (TsHead::default(), None);
    for line in CaseLine::of(text, file).filter(|line| !line.text.starts_with(['#', '%'])) {
        if let Some(said) = line.text.strip_prefix('@') {
            if targets.is_some() {
                return Err(
                    line.refuse("a line of the head (@) stands among the cases; move it before @data")
                );
            }
            let (key, value) = said.split_once(char::is_whitespace).unwrap_or((said, ""));
            if key.eq_ignore_ascii_case("data") {
                targets = Some(head.targets(&line)?);
            } else {
                head.set(&line, key, value.trim())?;
            }
            continue;
        }
        if targets.is_none() && head.is_there {
            return Err(line.refuse("a case stands before @data; write @data after the head"));
        }
        let targets = targets.get_or_insert(CaseTargets::Unsaid);
        take(head.case(&line, targets)?)?;
    }
    Ok(targets.unwrap_or(CaseTargets::Unsaid))
}

/// The head of a file; none where it does not say.
#[derive(Default)]
struct TsHead {
    is_there: bool,
    missing: Option<bool>,
    univariate: Option<bool>,
    dimensions: Option<usize>,
    equal_length: Option<bool>,
    series_length: Option<usize>,
    has_class: Option<bool>,
    has_target: Option<bool>,
    classes: Vec<String>,
}

impl TsHead {
    fn set(&mut self, line: &CaseLine, key: &str, value: &str) -> Result<()> {
        self.is_there = true;
        let (first, rest) = value.split_once(char::is_whitespace).unwrap_or((value, ""));
        let flag = || match first.to_lowercase().as_str() {
            "true" => Ok(Some(true)),
            "false" => Ok(Some(false)),
            _ => Err(line.refuse(format!("@{key} is {first:?}; write true or false"))),
        };
        let count = || match first.parse::<usize>() {
            Ok(count) if count > 0 => Ok(Some(count)),
            _ => Err(line.refuse(format!("@{key} is {first:?}; write a number from 1"))),
        };
        match key.to_lowercase().as_str() {
            "problemname" => {}
            "timestamps" if flag()? == Some(true) => {
                let why = "@timeStamps true: values with time stamps, (time,value), are not read; write the values alone";
                return Err(line.refuse(why));
            }
            "timestamps" => {}
            "missing" => self.missing = flag()?,
            "univariate" => self.univariate = flag()?,
            "dimensions" | "dimension" => self.dimensions = count()?,
            "equallength" => self.equal_length = flag()?,
            "serieslength" => self.series_length = count()?,
            "classlabel" => {
                self.has_class = flag()?;
                self.classes = rest.split_whitespace().map(String::from).collect();
            }
            "targetlabel" => self.has_target = flag()?,
            _ => return Err(line.refuse(format!("@{key} is no key of a head; it may have {KEYS}"))),
        }
        Ok(())
    }

    /// Returns the targets of the cases.
    fn targets(&self, line: &CaseLine) -> Result<CaseTargets> {
        match (self.has_class, self.has_target) {
            (Some(true), Some(true)) => {
                let why = "@classLabel and @targetLabel are both true; a case has a class or a target, so leave one out";
                Err(line.refuse(why))
            }
            (_, Some(true)) => Ok(CaseTargets::Values),
            (Some(true), _) => Ok(CaseTargets::Classes(self.classes.clone())),
            (None, None) => Ok(CaseTargets::Unsaid),
            _ => Ok(CaseTargets::Nothing),
        }
    }

    fn case(&self, line: &CaseLine, targets: &CaseTargets) -> Result<Case> {
        let mut parts: Vec<&str> = line.text.split(':').collect();
        let target = match targets {
            CaseTargets::Nothing => String::new(),
            _ => parts.pop().unwrap_or_default().trim().to_string(),
        };
        if parts.is_empty() || target.is_empty() && *targets != CaseTargets::Nothing {
            return Err(line.no_class());
        }
        if let CaseTargets::Classes(known) = targets
            && !known.is_empty()
            && !known.contains(&target)
        {
            let known = known.join(", ");
            return Err(
                line.refuse(format!("the class is {target:?}, and @classLabel lists {known}; correct one"))
            );
        }
        let mut column = 0;
        let mut value = |text: &str| {
            column += 1;
            if self.missing == Some(true) {
                line.number_or_gap(text, column)
            } else {
                line.number(text, column)
            }
        };
        let channel = |part: &&str| part.split(',').map(&mut value).collect::<Result<Vec<f32>>>();
        let channels: Vec<Vec<f32>> = parts.iter().map(channel).collect::<Result<_>>()?;
        self.refuse_other(line, &channels)?;
        Ok(Case { target, channels })
    }

    /// Refuses a case whose channels are not as the head says.
    fn refuse_other(&self, line: &CaseLine, channels: &[Vec<f32>]) -> Result<()> {
        let refuse = |held: String, said: String| {
            Err(line.refuse(format!("the case has {held}, and the head says {said}; correct one of them")))
        };
        let count = channels.len();
        if self.univariate == Some(true) && count > 1 {
            return refuse(format!("{count} channels"), "@univariate true".into());
        }
        if let Some(dimensions) = self.dimensions.filter(|dimensions| *dimensions != count) {
            return refuse(crate::error::plural(count, "channel"), format!("@dimensions {dimensions}"));
        }
        let length = self.series_length.filter(|_| self.equal_length != Some(false));
        let other = channels.iter().map(Vec::len).find(|held| length.is_some_and(|length| length != *held));
        match (other, length) {
            (Some(held), Some(length)) => {
                refuse(crate::error::plural(held, "value"), format!("@seriesLength {length}"))
            }
            _ => Ok(()),
        }
    }
}
