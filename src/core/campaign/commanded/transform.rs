//! The mistakes that stations make, each with how it is undone.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{AffectedDwells, EARTH, MistakeKind, Vectors};
use crate::core::campaign::{Campaign, Dwell, Phase, with_earth_rate};
use crate::core::frames::{Body, Nav, Rotation};

/// Units of rate, in arcsec/s.
pub(super) const RATE_UNITS: [(&str, f64); 10] = [
    ("deg/s", 3600.0),
    ("rad/s", 206_264.806_247_096_36),
    ("arcmin/s", 60.0),
    ("rad/h", 57.295_779_513_082_32),
    ("mdeg/s", 3.6),
    ("mrad/s", 206.264_806_247_096_36),
    ("urad/s", 0.206_264_806_247_096_36),
    ("arcsec/min", 1.0 / 60.0),
    ("arcsec/h", 1.0 / 3600.0),
    ("mas/s", 1e-3),
];

/// A mistake, and how to undo it in one dwell.
pub(super) struct Mistake {
    pub cause: MistakeKind,
    undo: Undo,
}

enum Undo {
    /// Specific force and rate, each times a matrix.
    Vectors(Matrix3<f64>, Matrix3<f64>),
    /// Rates of some dwells times a factor.
    Rate(f64, AffectedDwells),
    /// The Earth's rate of static dwells back from North-East-Down; whether the table's rate is reversed too.
    EarthFromNed {
        turning_too: bool,
    },
    /// The attitude back from North-East-Down.
    AttitudeFromNed,
    AttitudeInverted,
    /// The site's latitude with the other sign.
    Latitude,
    /// Static dwells with the Earth's rate at their attitude.
    OfAttitude,
    /// The Earth's rate added, to static dwells or to all.
    AddEarth(AffectedDwells),
}

impl Mistake {
    /// The campaign without the mistake in the dwells that `concerned` picks; none where it cannot be undone.
    pub fn undone(&self, campaign: &Campaign, concerned: impl Fn(usize) -> bool) -> Option<Campaign> {
        let mut right = campaign.clone();
        match self.undo {
            Undo::Latitude => right.site.as_mut()?.latitude *= -1.0,
            Undo::OfAttitude => {
                let still = right.dwells.iter_mut().filter(|d| d.phase == Phase::Static);
                still.for_each(|d| d.rate_arcsec_s.fill(0.0));
                return with_earth_rate(&right, AffectedDwells::Static).ok();
            }
            Undo::AddEarth(part) => return with_earth_rate(campaign, part).ok(),
            _ => {
                let vertical = campaign.site.map(|site| site.earth_rate().0.z);
                for (_, dwell) in right.dwells.iter_mut().enumerate().filter(|(k, _)| concerned(*k)) {
                    self.undo.dwell(dwell, vertical);
                }
            }
        }
        Some(right)
    }

    /// Whether it can be in some dwells and not in others.
    pub fn of_single_dwells(&self) -> bool {
        !matches!(self.undo, Undo::Latitude | Undo::OfAttitude | Undo::AddEarth(_))
    }
}

impl Undo {
    fn dwell(&self, dwell: &mut Dwell, earth_up: Option<f64>) {
        let up = dwell.specific_force_g0.try_normalize(0.0).unwrap_or_default();
        let w = dwell.rate_arcsec_s;
        match self {
            Self::Vectors(force, rate) => {
                dwell.specific_force_g0 = force * dwell.specific_force_g0;
                dwell.rate_arcsec_s = rate * w;
            }
            Self::Rate(factor, part) => {
                let concerned = match part {
                    AffectedDwells::All => true,
                    AffectedDwells::Static => dwell.phase == Phase::Static,
                    AffectedDwells::Turning => dwell.phase == Phase::Rate,
                };
                if concerned {
                    dwell.rate_arcsec_s *= *factor;
                }
            }
            Self::EarthFromNed { turning_too } => {
                let vertical = w.dot(&up);
                dwell.rate_arcsec_s = match dwell.phase {
                    Phase::Static => up.cross(&(w - vertical * up)) - vertical * up,
                    Phase::Rate if *turning_too => -w,
                    Phase::Rate => w + 2.0 * earth_up.unwrap_or(-vertical.clamp(-EARTH, EARTH)) * up,
                };
            }
            Self::AttitudeFromNed => {
                // East-North-Up to North-East-Down, a half turn: its own inverse.
                let swap = Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
                dwell.attitude = dwell.attitude.map(|c| attitude(c.matrix() * swap));
            }
            Self::AttitudeInverted => dwell.attitude = dwell.attitude.map(|c| attitude(c.matrix().transpose())),
            Self::Latitude | Self::OfAttitude | Self::AddEarth(_) => {}
        }
    }
}

fn attitude(matrix: Matrix3<f64>) -> Rotation<Nav, Body> {
    Rotation::stated_as(Rotation3::from_matrix_unchecked(matrix))
}

/// What only the attitude tells: rates that are the Earth's at other headings.
pub(super) fn other_headings() -> Vec<Mistake> {
    vec![Mistake { cause: MistakeKind::OtherHeadings, undo: Undo::OfAttitude }]
}

/// All others: those of whole vectors before those of single axes.
pub(super) fn mistakes() -> [Vec<Mistake>; 2] {
    let one = Matrix3::identity();
    let of = |cause, undo| Mistake { cause, undo };
    let mut whole = vec![
        of(MistakeKind::ForceReversed, Undo::Vectors(-one, one)),
        of(MistakeKind::LatitudeReversed, Undo::Latitude),
        of(MistakeKind::NedForEnu, Undo::EarthFromNed { turning_too: false }),
        of(MistakeKind::NedForEnu, Undo::EarthFromNed { turning_too: true }),
        of(MistakeKind::NedForEnu, Undo::AttitudeFromNed),
        of(MistakeKind::RateReversed, Undo::Vectors(one, -one)),
        of(MistakeKind::AttitudeInverted, Undo::AttitudeInverted),
        of(MistakeKind::EarthRateLeftOut, Undo::AddEarth(AffectedDwells::All)),
        of(MistakeKind::EarthRateLeftOut, Undo::AddEarth(AffectedDwells::Static)),
    ];
    for (unit, factor) in RATE_UNITS {
        let part = |part| of(MistakeKind::RateUnit { unit, part }, Undo::Rate(factor, part));
        whole.extend([AffectedDwells::All, AffectedDwells::Static, AffectedDwells::Turning].map(part));
    }
    [whole, single_axes()]
}

pub(super) fn single_axes() -> Vec<Mistake> {
    let one = Matrix3::<f64>::identity();
    let mut found = Vec::new();
    for of in [Vectors::Force, Vectors::Rate, Vectors::Both] {
        let undo = |m: Matrix3<f64>| match of {
            Vectors::Force => Undo::Vectors(m, one),
            Vectors::Rate => Undo::Vectors(one, m),
            Vectors::Both => Undo::Vectors(m, m),
        };
        for axis in 0..3 {
            let mut signs = Vector3::repeat(1.0);
            signs[axis] = -1.0;
            let cause = MistakeKind::AxisReversed { axis, of };
            found.push(Mistake { cause, undo: undo(Matrix3::from_diagonal(&signs)) });
        }
        for axes in [(0, 1), (1, 2), (0, 2)] {
            let mut swap = one;
            swap.swap_rows(axes.0, axes.1);
            found.push(Mistake { cause: MistakeKind::AxesExchanged { axes, of }, undo: undo(swap) });
        }
    }
    found
}
