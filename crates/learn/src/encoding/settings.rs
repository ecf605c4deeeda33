//! Settings of an encoding; nothing of it is fitted.

use serde::{Deserialize, Serialize};
use taxel_base::Layout;
use taxel_data::SampleSpec;
use taxel_encodings::{Colormap, Constant, Gaf, HardnessImage, Method, OneFrame, Order, Reduction};

use super::names::{IMAGE, ROCKET, TENSOR};
use super::range::Range;
use super::rocket::RocketSettings;
use super::scale::{Scale, Scaled, no_colours};
use super::signal::Signal;
use crate::problem::{Check, Problem, require, within};

/// How samples become the inputs of networks.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Encoding {
    /// Readings at the start of [N, C, T] whose mean is taken off each channel, for networks and baselines
    /// alike. Default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline: Option<usize>,
    /// Part of each raw sample that is kept before anything is made of it, for networks and baselines alike: as if a
    /// sensor had fewer channels or taxels, or read less often, for a shorter time or with fewer bits. Models take
    /// whole recordings and leave out the rest themselves. Default everything.
    #[serde(skip_serializing_if = "Reduction::is_whole")]
    pub reduce: Reduction,
    /// `signal` [N, C, T] or [N, rows, steps], for 1D networks and the flattened MLP.
    pub signal: Signal,
    /// `image` [N, C, H, W], for 2D networks; no image without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image: Option<Image>,
    /// `tensor` [N, 1, H, W, T], for 3D networks; no tensor without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tensor: Option<TensorSettings>,
    /// `rocket` [N, features], MiniRocket's features for networks that read them beside a signal; none without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rocket: Option<RocketSettings>,
    /// A guard before all inputs, networks and baselines alike: it is fitted on the training part of a fold, and
    /// replaces what broken channels and taxels read in all other samples, before anything is encoded. Default false.
    #[serde(skip_serializing_if = "crate::json_file::is_default")]
    pub guard: bool,
}

/// The `image` input, by what it is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Image {
    /// Gramian angular difference field of the raw readings, coloured: the choice of Kaewrakmuk and Srinonchat 2026.
    Gadf(GramianSettings),
    /// Gramian angular summation field of the raw readings, coloured.
    Gasf(GramianSettings),
    /// The samples are images: [N, H, W] becomes [N, 1, H, W], [N, C, H, W] stays.
    Raw(PictureSettings),
    /// One frame of each squeeze [N, T, H, W], for 2D networks (Gandarias et al. 2019b and Pastor et al. 2019).
    Frame(SqueezeFrame),
    /// Series [N, C, T] as one channel of C rows and T columns, each row scaled by itself.
    Rows(Scaled),
    /// Bits [N, fingers, 1 DC + 22 AC, ticks] in Pa from contact on, z-scores per feature (Zhang et al. 2022).
    Numatac(Bits),
    /// Frames of 7 × 3 electrodes [N, at least 700, 7, 3] as colour images [N, 3, 70, 70] (Rouhafzay et al. 2021,
    /// section 3.4).
    Electrodes(Electrodes),
}

/// A field is always made from raw readings, whatever the `signal` input says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct GramianSettings {
    /// Rows and columns. Default 50.
    pub size: usize,
    /// `"per-sample"` (default; amplitude is lost) or `{ low, high }` in the unit of the readings.
    pub range: Range,
    /// `jet` (default), `viridis` or `grey`.
    pub colormap: Colormap,
    /// Output for a constant recording under `per-sample`: `error` (default) or `zero`.
    pub constant: Constant,
}

impl Default for GramianSettings {
    fn default() -> Self {
        let (range, colormap) = (Range::default(), Colormap::default());
        GramianSettings { size: 50, range, colormap, constant: Constant::default() }
    }
}

/// Images as recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct PictureSettings {
    /// Scale of the pixels. Default `full-scale`.
    pub scale: Scale,
    /// `[height, width]` in pixels to resample to, bilinear. Default as recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resize: Option<[usize; 2]>,
    /// One grey channel becomes the red of three (Rouhafzay et al. 2021). Default false.
    pub red: bool,
}

impl Default for PictureSettings {
    fn default() -> Self {
        PictureSettings { scale: Scale::FullScale, resize: None, red: false }
    }
}

/// One frame of a squeeze.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SqueezeFrame {
    /// `"peak"` (default), or `{ at = 5 }`.
    pub frame: OneFrame,
    /// Scale of the taxels. Default `full-scale`.
    pub scale: Scale,
    /// `[height, width]` in taxels to resample to, bilinear. Default as recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resize: Option<[usize; 2]>,
    /// One grey channel becomes the red of three (Rouhafzay et al. 2021). Default false.
    pub red: bool,
}

impl Default for SqueezeFrame {
    fn default() -> Self {
        let PictureSettings { scale, resize, red } = PictureSettings::default();
        SqueezeFrame { frame: OneFrame::default(), scale, resize, red }
    }
}

/// NumaTac bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Bits {
    /// Ticks from contact on. Default 300.
    pub window: usize,
}

impl Default for Bits {
    fn default() -> Self {
        Bits { window: 300 }
    }
}

/// Frames of electrodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Electrodes {
    /// In which order values are read and written: `columns` (default), as in MATLAB, or `rows`.
    pub order: Order,
    /// Scale of the readings. Default `full-scale`.
    pub scale: Scale,
}

impl Default for Electrodes {
    fn default() -> Self {
        Electrodes { order: Order::default(), scale: PictureSettings::default().scale }
    }
}

/// Squeezes [N, T, H, W] as tactile tensors [N, 1, H, W, T] (Pastor et al. 2019).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct TensorSettings {
    /// Frames to resample to. Default as recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<usize>,
    /// Scale of the readings. Default `full-scale`.
    pub scale: Scale,
}

impl Default for TensorSettings {
    fn default() -> Self {
        TensorSettings { frames: None, scale: Scale::FullScale }
    }
}

impl Encoding {
    /// Returns the default encoding of such samples for networks that read `inputs`: z-scores of a signal, the
    /// difference field of series, the pixels of images, the peak frame or all frames of squeezes. Pixels and taxels
    /// are shares of the full scale where it is known, z-scores elsewhere.
    pub fn of(spec: &SampleSpec, inputs: &[&str]) -> Self {
        let scale = if spec.full_scale.is_some() { Scale::FullScale } else { Scale::ZScore };
        let image = match spec.layout {
            Layout::Series => Some(Image::Gadf(GramianSettings::default())),
            Layout::Image | Layout::Colour => {
                Some(Image::Raw(PictureSettings { scale, ..PictureSettings::default() }))
            }
            Layout::Sequence => Some(Image::Frame(SqueezeFrame { scale, ..SqueezeFrame::default() })),
            Layout::Fingers => Some(Image::Numatac(Bits::default())),
            Layout::Features => None,
        };
        let tensor =
            (spec.layout == Layout::Sequence).then(|| TensorSettings { scale, ..TensorSettings::default() });
        Encoding {
            image: image.filter(|_| inputs.contains(&IMAGE)),
            tensor: tensor.filter(|_| inputs.contains(&TENSOR)),
            rocket: inputs.contains(&ROCKET).then(RocketSettings::default),
            ..Encoding::default()
        }
    }

    /// Checks all settings.
    ///
    /// # Errors
    /// The first setting outside its range.
    pub fn check(&self) -> Check {
        if let Some(readings) = self.baseline {
            within("baseline", readings, 1, 1_000_000)?;
        }
        if let Err(error) = self.reduce.check() {
            return Err(reduction_problem(error));
        }
        let reason =
            "looks at channels and taxels that encoding.reduce does not read; leave one of the two out";
        require(!self.guard || self.reduce.is_whole(), "guard", "true", reason)?;
        self.signal.check().map_err(|problem| problem.below("signal"))?;
        if let Some(tensor) = self.tensor {
            within("tensor.frames", tensor.frames.unwrap_or(1), 1, 4096)?;
            no_colours("tensor.scale", tensor.scale)?;
        }
        if let Some(rocket) = self.rocket {
            rocket.check().map_err(|problem| problem.below("rocket"))?;
        }
        self.image.as_ref().map_or(Ok(()), |image| image.check().map_err(|problem| problem.below("image")))
    }

    /// Checks whether pixels or taxels lie side by side as on the sensor, so that they can be moved.
    pub fn is_warpable(&self) -> bool {
        self.tensor.is_some() || matches!(self.image, Some(Image::Raw(_) | Image::Frame(_)))
    }

    /// Returns the layout of the samples, where the `image` input allows one only.
    pub fn layout(&self, shape: &[usize]) -> Option<Layout> {
        match (self.image.as_ref()?, shape) {
            (Image::Numatac(_), [_, _, _]) => Some(Layout::Fingers),
            (Image::Electrodes(_), [_, _, _]) => Some(Layout::Sequence),
            (Image::Raw(_), [3, _, _]) => Some(Layout::Colour),
            (Image::Raw(_), [_, _]) => Some(Layout::Image),
            _ => None,
        }
    }
}

/// Returns the problem of a reduction that does not do, by its key.
pub(super) fn reduction_problem(error: taxel_encodings::Error) -> Problem {
    match error {
        taxel_encodings::Error::Reduction(reduction) => {
            Problem::new(format!("reduce.{}", reduction.key), reduction.value, reduction.reason)
        }
        other => Problem::new("reduce", "{ .. }", other.to_string()),
    }
}

impl Image {
    fn check(&self) -> Check {
        match self {
            Image::Gadf(field) | Image::Gasf(field) => field.check(),
            Image::Raw(PictureSettings { resize, .. }) | Image::Frame(SqueezeFrame { resize, .. }) => {
                resize.iter().flatten().try_for_each(|side| within("resize", *side, 1, 4096))
            }
            Image::Rows(rows) => no_colours("scale", rows.scale),
            Image::Numatac(bits) => within("window", bits.window, 1, 1_000_000),
            Image::Electrodes(_) => Ok(()),
        }
    }
}

impl GramianSettings {
    /// Returns the encoder of the images.
    ///
    /// # Errors
    /// The first setting outside its range.
    pub fn image(self, method: Method) -> Result<HardnessImage, Problem> {
        self.check()?;
        let GramianSettings { size, range, colormap, constant } = self;
        Ok(HardnessImage { gaf: Gaf { size, method, range: range.into(), constant }, colormap })
    }

    fn check(&self) -> Check {
        let least = if self.range == Range::PerSample { 2 } else { 1 };
        within("size", self.size, least, 4096)?;
        match self.range {
            Range::PerSample => Ok(()),
            Range::Fixed { low, high } => {
                let ordered = low.is_finite() && high.is_finite() && (low as f32) < (high as f32);
                let value = format!("{{ low = {low}, high = {high} }}");
                require(ordered, "range", value, "low must be below high, both finite")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_networks_are_given_where_nobody_says_it() {
        let of = |layout, full_scale| {
            let spec = SampleSpec { full_scale, ..SampleSpec::new(layout, &[4, 6]) };
            Encoding::of(&spec, &[IMAGE, TENSOR])
        };
        assert_eq!(of(Layout::Series, None).image, Some(Image::Gadf(GramianSettings::default())));
        assert_eq!(of(Layout::Image, Some(255.0)).image, Some(Image::Raw(PictureSettings::default())));
        let picture = PictureSettings { scale: Scale::ZScore, ..PictureSettings::default() };
        assert_eq!(of(Layout::Colour, None).image, Some(Image::Raw(picture)));
        let squeezes = of(Layout::Sequence, None);
        assert_eq!(
            squeezes.tensor,
            Some(TensorSettings { scale: Scale::ZScore, ..TensorSettings::default() })
        );
        assert!(matches!(squeezes.image, Some(Image::Frame(frame)) if frame.scale == Scale::ZScore));
        assert_eq!(of(Layout::Features, None), Encoding::default());
        assert_eq!(Encoding::of(&SampleSpec::new(Layout::Series, &[4, 6]), &["signal"]), Encoding::default());
        for layout in Layout::ALL {
            assert!(of(layout, None).check().is_ok(), "{layout}");
        }
    }
}
