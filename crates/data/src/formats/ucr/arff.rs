//! Reads the ARFF files of the UCR and UEA archives: flat ones of one channel, relational ones of several.
//!
//! No crate for ARFF reads relational attributes, and the rest is a line of numbers.

use crate::formats::ucr::case::{Case, CaseLine, CaseTargets};
use crate::{Error, Result};

/// Names of the attribute of classes.
const CLASS: [&str; 3] = ["class", "target", "label"];

/// Hands every case to `take`.
///
/// After `@data` a line is a case, a value for each attribute: `1.5,2.5,class`, or `'1,2\n3,4',class` with the
/// channels in quotes, parted by a backslash and an n. `?` at the end of a channel fills up a shorter series; it is
/// read as NaN.
///
/// The class is the attribute of names in braces, wherever it stands; of several, or where there is none, the one
/// that is called class, target or label. A file without attributes has its class last.
pub(crate) fn read(text: &str, file: &str, take: &mut dyn FnMut(Case) -> Result<()>) -> Result<CaseTargets> {
    let (mut head, mut class) = (vec![], None);
    let mut relation: Option<Attribute> = None;
    for line in CaseLine::of(text, file).filter(|line| !line.text.starts_with('%')) {
        if let Some(class) = &class {
            take(case(&line, &head, *class)?)?;
            continue;
        }
        let (key, rest) = line.text.split_once(char::is_whitespace).unwrap_or((line.text, ""));
        match key.to_lowercase().as_str() {
            "@data" => class = Some(class_of(&head, file)?),
            "@relation" => {}
            "@end" => head.extend(relation.take()),
            "@attribute" => {
                let attribute = Attribute::of(&line, rest)?;
                match &mut relation {
                    Some(Attribute { kind: Kind::Relation(width), .. }) => *width += 1,
                    _ if matches!(attribute.kind, Kind::Relation(_)) => relation = Some(attribute),
                    _ => head.push(attribute),
                }
            }
            _ if head.is_empty() && relation.is_none() => {}
            _ => {
                return Err(
                    line.refuse(format!("{key:?} is no key of a head; it has @attribute, @end and @data"))
                );
            }
        }
    }
    Ok(match class.flatten().map(|class| &head[class].kind) {
        Some(Kind::Names(names)) => CaseTargets::Classes(names.clone()),
        Some(Kind::Text | Kind::Date) => CaseTargets::Classes(vec![]),
        // Numbers may be classes.
        Some(Kind::Number | Kind::Relation(_)) | None => CaseTargets::Unsaid,
    })
}

/// An attribute that a head declares.
struct Attribute {
    name: String,
    kind: Kind,
}

/// The values of an attribute.
enum Kind {
    Number,
    /// One of these.
    Names(Vec<String>),
    Text,
    Date,
    /// Rows of that many numbers.
    Relation(usize),
}

impl Attribute {
    /// Reads what follows `@attribute`.
    fn of(line: &CaseLine, text: &str) -> Result<Self> {
        let unread =
            || line.refuse("is no attribute; write @attribute NAME numeric, or {a,b} of class names");
        let (name, kind) = field(text.trim_start(), char::is_whitespace).ok_or_else(unread)?;
        let kind = kind.trim();
        let word = kind.split_whitespace().next().unwrap_or_default().to_lowercase();
        let kind = match word.as_str() {
            "numeric" | "real" | "integer" => Kind::Number,
            "string" => Kind::Text,
            "date" => Kind::Date,
            "relational" => Kind::Relation(0),
            _ => {
                let inside = kind.strip_prefix('{').and_then(|kind| kind.trim_end().strip_suffix('}'));
                let names = fields(inside.ok_or_else(unread)?).ok_or_else(unread)?;
                Kind::Names(names.into_iter().map(|name| name.text).collect())
            }
        };
        Ok(Self { name: name.text, kind })
    }

    fn is_called_class(&self) -> bool {
        CLASS.iter().any(|name| name.eq_ignore_ascii_case(&self.name))
    }
}

/// Returns the place of the class among the attributes; none in a file that declares no attributes. Refuses attributes
/// that are neither the class nor values.
fn class_of(head: &[Attribute], file: &str) -> Result<Option<usize>> {
    if head.is_empty() {
        return Ok(None);
    }
    let listed =
        |places: &[usize]| places.iter().map(|at| head[*at].name.as_str()).collect::<Vec<_>>().join(", ");
    let refuse = |why: String| Err(Error::file(file, why));
    let places =
        |is_it: fn(&Attribute) -> bool| (0..head.len()).filter(|at| is_it(&head[*at])).collect::<Vec<_>>();
    let nominal = places(|attribute| matches!(attribute.kind, Kind::Names(_)));
    let called = places(Attribute::is_called_class);
    let class = match (nominal.as_slice(), called.as_slice()) {
        ([one], []) => *one,
        (_, [one]) => *one,
        ([one], several) if several.contains(one) => *one,
        ([], []) => {
            let why = "no attribute is the class; write its names in braces, as @attribute class {a,b}";
            return refuse(why.into());
        }
        (several, []) | (_, several) => {
            let why = format!(
                "{} could each be the class; call one of them class, target or label",
                listed(several)
            );
            return refuse(why);
        }
    };
    let others = (0..head.len()).filter(|at| *at != class);
    let is_value = |at: &usize| matches!(head[*at].kind, Kind::Number | Kind::Relation(_));
    let (values, odd): (Vec<usize>, Vec<usize>) = others.partition(is_value);
    if !odd.is_empty() {
        let (odd, class) = (listed(&odd), &head[class].name);
        let why = format!(
            "the class is {class}, and {odd} hold no numbers; remove them, or call another one class"
        );
        return refuse(why);
    }
    let has_relation = values.iter().any(|at| matches!(head[*at].kind, Kind::Relation(_)));
    match values.as_slice() {
        [] => refuse("has no attribute beside the class; declare those of the values".into()),
        several @ [_, _, ..] if has_relation => {
            let why = format!(
                "has a relational attribute beside others ({}); one alone holds all channels",
                listed(several)
            );
            refuse(why)
        }
        _ => Ok(Some(class)),
    }
}

/// Reads a case: its class is at `class`, or last.
fn case(line: &CaseLine, head: &[Attribute], class: Option<usize>) -> Result<Case> {
    let mut values = fields(line.text).ok_or_else(|| line.no_class())?;
    if !head.is_empty() && values.len() != head.len() {
        let (held, want) = (crate::error::plural(values.len(), "value"), head.len());
        return Err(line.refuse(format!("has {held}, and there are {want} attributes; give one for each")));
    }
    let at = class.unwrap_or(values.len() - 1);
    let target = values.remove(at);
    if target.text.is_empty() || target.text == "?" && !target.is_quoted || values.is_empty() {
        return Err(line.no_class());
    }
    if let Some(Attribute { name, kind: Kind::Names(names) }) = head.get(at)
        && !names.contains(&target.text)
    {
        let (held, names) = (target.text, names.join(", "));
        return Err(line.refuse(format!("{name} is {held:?}, and its attribute lists {names}; correct one")));
    }
    let mut column = 0;
    let mut value = |text: &str| {
        column += 1;
        // The class may stand before.
        line.number_or_gap(text, if column > at { column + 1 } else { column })
    };
    let channels = match values.as_slice() {
        [one] if one.is_quoted => {
            let channel = |channel: &str| channel.split(',').map(&mut value).collect::<Result<Vec<f32>>>();
            one.text.split("\\n").map(channel).collect::<Result<Vec<_>>>()?
        }
        flat => vec![flat.iter().map(|field| value(&field.text)).collect::<Result<Vec<f32>>>()?],
    };
    let other = head.iter().find_map(|attribute| match attribute.kind {
        Kind::Relation(width) => {
            channels.iter().map(Vec::len).find(|held| *held != width).map(|held| (held, width))
        }
        _ => None,
    });
    match other {
        Some((held, width)) => {
            let held = crate::error::plural(held, "value");
            Err(line.refuse(format!(
                "a channel has {held}, and its relation has {width} attributes; give one for each"
            )))
        }
        None => Ok(Case { target: target.text, channels }),
    }
}

/// A value of a line, without its quotes.
struct Field {
    text: String,
    is_quoted: bool,
}

/// Cuts a line at its commas, but for those in quotes; none where a quote has no end.
fn fields(mut text: &str) -> Option<Vec<Field>> {
    let mut all = vec![];
    loop {
        let (one, rest) = field(text.trim_start(), |c| c == ',')?;
        all.push(one);
        match rest.trim_start().strip_prefix(',') {
            Some(rest) => text = rest,
            None if rest.trim().is_empty() => return Some(all),
            None => return None,
        }
    }
}

/// Returns the first value of a text, which ends before `is_end` or with its quote, and the text after it.
fn field(text: &str, is_end: fn(char) -> bool) -> Option<(Field, &str)> {
    let Some(quote) = text.chars().next().filter(|c| matches!(c, '\'' | '"')) else {
        let (value, rest) = text.split_at(text.find(is_end).unwrap_or(text.len()));
        return Some((Field { text: value.trim_end().into(), is_quoted: false }, rest));
    };
    let (mut value, mut is_escaped) = (String::new(), false);
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if is_escaped => {
                // `\n` parts channels and stays as it is.
                let keeps = !matches!(c, '\'' | '"' | '\\');
                value.extend(keeps.then_some('\\').into_iter().chain([c]));
                is_escaped = false;
            }
            '\\' => is_escaped = true,
            c if c == quote => return Some((Field { text: value, is_quoted: true }, &text[at + 1..])),
            c => value.push(c),
        }
    }
    None
}
