//! Turns the values of a row of Parquet into cells: lists and structs of numbers are as many cells as they have values.

use parquet::record::Field;
use std::fmt::Write;

/// How the values of a column lie in a row.
pub(crate) enum CellShape {
    One,
    List(Vec<CellShape>),
    /// A struct of numbers.
    Fields(Vec<(String, CellShape)>),
}

impl CellShape {
    pub fn of(field: &Field) -> Self {
        match field {
            Field::ListInternal(list) => Self::List(list.elements().iter().map(Self::of).collect()),
            Field::Group(row) if is_number(field) => Self::Fields(
                row.get_column_iter().map(|(name, field)| (name.clone(), Self::of(field))).collect(),
            ),
            _ => Self::One,
        }
    }

    /// Returns the names of the values, after the column.
    pub fn name(&self, column: &str, out: &mut Vec<String>) {
        match self {
            Self::One => out.push(column.into()),
            Self::List(list) => {
                list.iter().enumerate().for_each(|(at, one)| one.name(&format!("{column}.{at}"), out));
            }
            Self::Fields(fields) => {
                fields.iter().for_each(|(name, one)| one.name(&format!("{column}.{name}"), out));
            }
        }
    }

    /// Checks whether a field holds as many values; what is missing altogether fits.
    pub fn fits(&self, field: &Field) -> bool {
        match (self, field) {
            (_, Field::Null) => true,
            (Self::List(wanted), Field::ListInternal(list)) => {
                let all = list.elements();
                wanted.len() == all.len() && wanted.iter().zip(all).all(|(wanted, field)| wanted.fits(field))
            }
            (Self::Fields(wanted), Field::Group(row)) => {
                let both = wanted.iter().zip(row.get_column_iter());
                let fits = |((name, wanted), (found, field)): (&(String, Self), (&String, &Field))| {
                    name == found && wanted.fits(field)
                };
                wanted.len() == row.len() && both.into_iter().all(fits)
            }
            (Self::One, field) => !matches!(field, Field::ListInternal(_)),
            (Self::List(_) | Self::Fields(_), _) => false,
        }
    }

    /// Adds the values of a field that fits to the cells of a row, empty ones where it is missing.
    pub fn write(&self, field: &Field, cell: &mut String, out: &mut csv::StringRecord) {
        match (self, field) {
            (Self::List(wanted), Field::ListInternal(list)) => {
                wanted.iter().zip(list.elements()).for_each(|(one, field)| one.write(field, cell, out));
            }
            (Self::Fields(wanted), Field::Group(row)) => {
                let both = wanted.iter().zip(row.get_column_iter());
                both.for_each(|((_, one), (_, field))| one.write(field, cell, out));
            }
            (Self::One, _) => {
                cell.clear();
                write_cell(field, cell);
                out.push_field(cell);
            }
            (Self::List(wanted), _) => wanted.iter().for_each(|one| one.write(&Field::Null, cell, out)),
            (Self::Fields(wanted), _) => {
                wanted.iter().for_each(|(_, one)| one.write(&Field::Null, cell, out))
            }
        }
    }

    /// Describes how many values there are: `2 × 3 values`.
    pub fn described(&self) -> String {
        match self {
            Self::One => "one value".into(),
            Self::Fields(fields) => format!("{} fields", fields.len()),
            Self::List(list) => match list.first() {
                Some(Self::List(_)) => {
                    let [first, ..] = list.as_slice() else { return "lists".into() };
                    format!("{} × {}", list.len(), first.described())
                }
                _ => format!("{} values", list.len()),
            },
        }
    }
}

/// Checks whether all values of a field are numbers.
fn is_number(field: &Field) -> bool {
    match field {
        Field::Group(row) => row.get_column_iter().all(|(_, field)| is_number(field)),
        Field::ListInternal(list) => list.elements().iter().all(is_number),
        Field::Null | Field::Str(_) | Field::Bytes(_) | Field::MapInternal(_) => false,
        _ => true,
    }
}

/// Says of each value of a field whether it has more than 32 bits, or 32 of a whole number: f32 does not hold them all.
pub(crate) fn wide(field: &Field, out: &mut Vec<bool>) {
    match field {
        Field::ListInternal(list) => list.elements().iter().for_each(|field| wide(field, out)),
        Field::Group(row) if is_number(field) => {
            row.get_column_iter().for_each(|(_, field)| wide(field, out))
        }
        Field::Bool(_) | Field::Byte(_) | Field::UByte(_) | Field::Short(_) | Field::UShort(_) => {
            out.push(false)
        }
        Field::Float16(_) | Field::Float(_) => out.push(false),
        _ => out.push(true),
    }
}

/// Writes a value as in CSV; a value that is neither text nor number is in brackets.
fn write_cell(field: &Field, out: &mut String) {
    // Writing to a text does not fail.
    let _ = match field {
        Field::Null => Ok(()),
        Field::Bool(value) => write!(out, "{}", u8::from(*value)),
        Field::Str(text) => out.write_str(text),
        Field::Float16(value) => write!(out, "{}", value.to_f32()),
        Field::Float(value) => write!(out, "{value}"),
        Field::Double(value) => write!(out, "{value}"),
        Field::TimestampMillis(value) | Field::TimestampMicros(value) | Field::TimeMicros(value) => {
            write!(out, "{value}")
        }
        Field::Date(value) | Field::TimeMillis(value) => write!(out, "{value}"),
        Field::Group(_) | Field::ListInternal(_) | Field::MapInternal(_) | Field::Bytes(_) => {
            write!(out, "[...]")
        }
        other => write!(out, "{other}"),
    };
}
