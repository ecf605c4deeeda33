//! All knees together, loosened until inner folds say that they do.

use taxel_judge::{Combined, Curve};
use taxel_learn::FoldRecord;

use crate::curves::{Outer, Shared};
use crate::desk::Desk;
use crate::error::Result;
use crate::ladder::{Cut, Ladder};

/// Combinations that are tried at most.
const TRIES: usize = 6;

/// What is left of everything.
pub struct Together {
    /// What is taken away on each axis.
    pub cuts: Vec<Cut>,
    /// What is said of it.
    pub combined: Combined,
    /// Its answers to the test parts.
    pub records: Vec<FoldRecord>,
}

/// Trains the knees of all curves together; none where nothing may go. Where they lose too much on inner folds, the axis that
/// lost most by itself takes its next larger setting.
///
/// # Errors
/// What stops everything.
pub fn together(
    shared: &Shared,
    desk: &mut Desk,
    outers: &[Outer],
    tried: &[(Ladder, Curve)],
) -> Result<Option<Together>> {
    // Position of the setting on each axis that has one.
    let mut chosen: Vec<(usize, usize)> =
        tried.iter().enumerate().filter_map(|(axis, (_, curve))| Some((axis, curve.knee?))).collect();
    let mut loosened = vec![];
    for attempt in 1.. {
        if chosen.is_empty() {
            return Ok(None);
        }
        let steps: Vec<_> = chosen.iter().map(|&(axis, at)| &tried[axis].0.steps[at]).collect();
        let cuts: Vec<&Cut> = steps.iter().map(|step| &step.cut).collect();
        let parts: Vec<String> = steps.iter().map(|step| step.label.clone()).collect();
        let alone = chosen.len() == 1;
        desk.expect(outers.len() * (outers.first().map_or(0, |outer| outer.inner.len()) + 1));
        let inner = match shared.on_inner(desk, outers, "together", &cuts) {
            Ok(records) => shared.beside(outers, true, &[records])?.pop().flatten(),
            Err(error) if error.is_of_setting() => None,
            Err(error) => return Err(error),
        };
        let does = inner.is_some_and(|own| own.suffices(shared.margin));
        if does || alone || attempt == TRIES {
            let records = shared.on_outer(desk, outers, "together", &cuts)?;
            let outer = shared.beside(outers, false, std::slice::from_ref(&records))?.pop().flatten();
            let cuts = cuts.into_iter().cloned().collect();
            let combined = Combined { parts, loosened, inner, outer };
            return Ok(Some(Together { cuts, combined, records }));
        }
        let lost =
            inner.map_or("could not be trained".into(), |own| format!("lost {:.1} points", -own.difference));
        loosened.push(format!("Together, {} {lost} on inner folds.", parts.join("; ")));
        loosen(&mut chosen, tried);
    }
    Ok(None)
}

/// The axis whose setting lost most by itself takes the next larger one, or gives up its place.
fn loosen(chosen: &mut Vec<(usize, usize)>, tried: &[(Ladder, Curve)]) {
    let lost =
        |&(axis, at): &(usize, usize)| tried[axis].1.rungs[at].inner.map_or(0.0, |own| -own.difference);
    let most = chosen.iter().enumerate().max_by(|(_, a), (_, b)| lost(a).total_cmp(&lost(b)));
    let Some((place, _)) = most else { return };
    match chosen[place].1 {
        0 => {
            chosen.remove(place);
        }
        _ => chosen[place].1 -= 1,
    }
}
