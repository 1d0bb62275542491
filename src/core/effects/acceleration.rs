//! Functions of specific force beyond model (6)'s.

use super::entry::{Coefficient, Effect, Entry, Scope, Shape, Typical, linear, nothing_missing};

pub const CROSS_COMPLIANCE: Entry = Entry {
    effect: Effect::CrossCompliance,
    id: "cross_compliance",
    cause: "the suspension yields across axes: products of specific force that model (6) leaves out",
    equation: "k_IS a_I a_S + k_IO a_I a_O + k_OS a_O a_S",
    typical: Typical { low: 1e-3, high: 0.1, source: "D_IS, D_IO, D_OS of eq. (5); IEEE 517 compliance terms" },
    plausible: 1e3,
    needs: "dwells with specific force off the body axes (edges at 45 deg, tilts of 30 and 60 deg)",
    confused_with: &[Effect::CubicG],
    scope: Scope::Gyro,
    coefficients: |shape| picked(shape).map(|i| Coefficient { name: PRODUCTS[i], unit: "deg/(h g0^2)" }).collect(),
    missing: nothing_missing,
    shapes: |_| {
        vec![(Shape::Linear, 2.0), (Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0), (Shape::Only(&[2]), 1.0)]
    },
    columns: |s, j, shape| {
        let gyro = &s.gyros[j];
        let pairs = [(&gyro.input, &gyro.spin), (&gyro.input, &gyro.output), (&gyro.output, &gyro.spin)];
        picked(shape).map(|i| s.column(|k| s.force[k].dot(pairs[i].0) * s.force[k].dot(pairs[i].1))).collect()
    },
};

pub const CUBIC_G: Entry = Entry {
    effect: Effect::CubicG,
    id: "cubic_g",
    cause: "the suspension stiffens: drift with the cube of specific force along the input axis",
    equation: "k a_I^3",
    typical: Typical { low: 1e-3, high: 0.1, source: "IEEE 517, higher-order acceleration terms" },
    plausible: 1e3,
    needs: "dwells with specific force off the body axes",
    confused_with: &[Effect::CrossCompliance],
    scope: Scope::Gyro,
    coefficients: |_| vec![Coefficient { name: "k", unit: "deg/(h g0^3)" }],
    missing: nothing_missing,
    shapes: linear,
    columns: |s, j, _| vec![s.column(|k| s.force[k].dot(&s.gyros[j].input).powi(3))],
};

pub const OUTPUT_AXIS_G: Entry = Entry {
    effect: Effect::OutputAxisG,
    id: "output_axis_g",
    cause: "drift in proportion to specific force along the output axis",
    equation: "D_O a_O",
    typical: Typical { low: 1e-3, high: 0.3, source: "closure of Tables 3-4: 0.02 to 0.23 deg/(h g0)" },
    plausible: 5e3,
    needs: "the closure of G over a history in which D_S changes; dwell residuals never show it",
    confused_with: &[Effect::MountClocking],
    scope: Scope::Gyro,
    coefficients: |_| vec![Coefficient { name: "D_O", unit: "deg/(h g0)" }],
    missing: nothing_missing,
    shapes: linear,
    columns: |s, j, _| vec![s.column(|k| s.force[k].dot(&s.gyros[j].output))],
};

pub const MOUNT_CLOCKING: Entry = Entry {
    effect: Effect::MountClocking,
    id: "mount_clocking",
    cause: "the gyro is turned about its input axis in its seat: part of D_S shows along the nominal output axis",
    equation: "D_S tan(phi) a_O",
    typical: Typical {
        low: 1e-4,
        high: 0.05,
        source: "mounting tolerances of arc-minutes; atan2(D_O, D_S) of Tables 3-4",
    },
    plausible: 5e3,
    needs: "the closure of G over a history in which D_S changes; dwell residuals never show it",
    confused_with: &[Effect::OutputAxisG],
    scope: Scope::Gyro,
    coefficients: |_| vec![Coefficient { name: "D_O", unit: "deg/(h g0)" }],
    missing: nothing_missing,
    shapes: linear,
    columns: |s, j, _| vec![s.column(|k| s.force[k].dot(&s.gyros[j].output))],
};

const PRODUCTS: [&str; 3] = ["k_IS", "k_IO", "k_OS"];

fn picked(shape: Shape) -> impl Iterator<Item = usize> {
    let only: &'static [usize] = match shape {
        Shape::Only(picked) => picked,
        _ => &[0, 1, 2],
    };
    only.iter().copied()
}
