//! Recordings of files as time steps.

use std::time::Instant;

use taxel_data::{Recording, SampleSpec};

use crate::error::{Error, Result};
use crate::pace::Pacer;
use crate::queue::{Closed, Feed, Skip};

/// A replay of recordings.
pub(crate) struct Replay<'s> {
    /// Name of the source in messages.
    pub label: String,
    /// The sample that the model reads.
    pub spec: SampleSpec,
    pub pacer: Pacer,
    /// Time steps per second.
    pub rate: Option<f64>,
    /// Hears what is odd, once of each kind.
    pub say: &'s dyn Fn(&str),
}

impl Replay<'_> {
    /// Hands on every recording, time step by time step.
    ///
    /// # Errors
    /// Recordings with other axes than the model reads; no rate to replay them at.
    pub fn feed(mut self, recordings: &[Recording], feed: &mut Feed) -> Result<()> {
        if self.pacer.needs_stamps() && self.rate.is_none() {
            return Err(self.broken("no rate is known, the model says none; say --rate HZ".into()));
        }
        let mut before = 0;
        let mut values = vec![];
        for recording in recordings {
            let (recorded, places) = self.places(recording)?;
            // Single images are the time steps of one stream.
            let is_stream = recorded.layout.time_axis().is_some();
            if is_stream && feed.begin(&recording.origin).is_err() {
                return Ok(());
            }
            let (_, ticks, after) = recorded.around_time();
            for tick in 0..ticks {
                values.clear();
                let at =
                    |place: &usize| recording.values[(place / after * ticks + tick) * after + place % after];
                values.extend(places.iter().map(at));
                // Replayed one after the other, and each has a time of its own.
                if let Some(rate) = self.rate {
                    self.pacer.wait((before + tick) as f64 / rate);
                }
                if values.iter().any(|value| !value.is_finite()) {
                    if feed.counters.skip(Skip::NotFinite) {
                        let (label, origin) = (&self.label, &recording.origin);
                        (self.say)(&format!(
                            "{label}: {origin}: reading {tick} is not finite; skipped. It is said once"
                        ));
                    }
                    continue;
                }
                let of_stream = if is_stream { tick } else { before };
                let stamp = self.rate.map(|rate| of_stream as f64 / rate);
                if let Err(Closed) = feed.reading(&values, stamp, Instant::now()) {
                    return Ok(());
                }
            }
            before += ticks;
        }
        Ok(())
    }

    /// Returns how a recording lies in memory, and where the values of a time step are among those of one instant.
    fn places(&self, recording: &Recording) -> Result<(SampleSpec, Vec<usize>)> {
        let recorded = SampleSpec { shape: recording.shape.clone(), ..self.spec.clone() };
        let refuse = || {
            let (shape, axes) = (&recording.shape, self.spec.layout.axes());
            let why = format!(
                "{}: it has the axes {shape:?}, the model reads {:?} ({axes}), time of any length",
                recording.origin, self.spec.shape
            );
            self.broken(why)
        };
        if recorded.shape.len() != self.spec.shape.len() {
            return Err(refuse());
        }
        let Some(time) = recorded.layout.time_axis() else {
            let fits = recorded.shape == self.spec.shape;
            return if fits {
                Ok((recorded.clone(), (0..recorded.around_time().2).collect()))
            } else {
                Err(refuse())
            };
        };
        let wrong: Vec<usize> = (0..recorded.shape.len())
            .filter(|axis| *axis != time && recorded.shape[*axis] != self.spec.shape[*axis])
            .collect();
        let all = recorded.around_time();
        match (&self.spec.channels, wrong.as_slice()) {
            (_, []) => Ok((recorded, (0..all.0 * all.2).collect())),
            // A whole recording of which the model reads some channels.
            (Some(channels), [0])
                if time > 0 && channels.iter().all(|channel| *channel < recorded.shape[0]) =>
            {
                let inner = all.0 * all.2 / recorded.shape[0];
                let places = channels.iter().flat_map(|channel| channel * inner..(channel + 1) * inner);
                Ok((recorded, places.collect()))
            }
            _ => Err(refuse()),
        }
    }

    fn broken(&self, why: String) -> Error {
        Error::Source { source_label: self.label.clone(), why }
    }
}
