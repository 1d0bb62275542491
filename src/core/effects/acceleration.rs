//! Functions of specific force beyond model (6)'s.

use super::entry::{Effect, Entry, PLAIN, Parameter, Shape};

pub(super) const ENTRIES: &[&Entry] =
    &[&AXIAL_COMPLIANCE, &CROSS_COMPLIANCE, &CUBIC_G, &OUTPUT_AXIS_G, &MOUNT_CLOCKING];

/// Of a gyro whose axes are not the body's this leaves products of body axes.
pub const AXIAL_COMPLIANCE: Entry = Entry {
    effect: Effect::AxialCompliance,
    id: "axial_compliance",
    cause: "the suspension yields along the gyro's own axes, where model (6) has P along those of the body",
    equation: "D_II a_I^2 + D_SS a_S^2",
    unit: "deg/(h g0^2)",
    typical: [1e-3, 0.1], // D_II, D_SS of eq. (5)
    plausible: 1e3,
    confused_with: &[Effect::CrossCompliance, Effect::CubicG],
    names: &|_| vec!["D_II", "D_SS"],
    columns: &|s, j, _| {
        let gyro = &s.gyros[j];
        [&gyro.input, &gyro.spin].map(|axis| s.column(|k| s.force[k].dot(axis).powi(2))).to_vec()
    },
    ..PLAIN
};

pub const CROSS_COMPLIANCE: Entry = Entry {
    effect: Effect::CrossCompliance,
    id: "cross_compliance",
    cause: "the suspension yields across axes: products of specific force that model (6) leaves out",
    equation: "k_IS a_I a_S + k_IO a_I a_O + k_OS a_O a_S",
    unit: "deg/(h g0^2)",
    typical: [1e-3, 0.1], // D_IS, D_IO, D_OS of eq. (5); IEEE 517 compliance terms
    plausible: 1e3,
    confused_with: &[Effect::AxialCompliance, Effect::CubicG],
    names: &|shape| picked(shape).map(|i| PRODUCTS[i]).collect(),
    shapes: &|_| {
        vec![(Shape::Linear, 2.0), (Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0), (Shape::Only(&[2]), 1.0)]
    },
    columns: &|s, j, shape| {
        let gyro = &s.gyros[j];
        let pairs = [(&gyro.input, &gyro.spin), (&gyro.input, &gyro.output), (&gyro.output, &gyro.spin)];
        picked(shape).map(|i| s.column(|k| s.force[k].dot(pairs[i].0) * s.force[k].dot(pairs[i].1))).collect()
    },
    parameter: Parameter::Product,
    ..PLAIN
};

pub const CUBIC_G: Entry = Entry {
    effect: Effect::CubicG,
    id: "cubic_g",
    cause: "the suspension stiffens: drift with the cube of specific force along the input axis",
    equation: "k a_I^3",
    unit: "deg/(h g0^3)",
    typical: [1e-3, 0.1], // IEEE 517, higher-order acceleration terms
    plausible: 1e3,
    confused_with: &[Effect::CrossCompliance],
    columns: &|s, j, _| vec![s.column(|k| s.force[k].dot(&s.gyros[j].input).powi(3))],
    ..PLAIN
};

pub const OUTPUT_AXIS_G: Entry = Entry {
    effect: Effect::OutputAxisG,
    id: "output_axis_g",
    cause: "drift in proportion to specific force along the output axis",
    equation: "D_O a_O",
    unit: "deg/(h g0)",
    typical: [1e-3, 0.3], // closure of Tables 3-4: 0.02 to 0.23 deg/(h g0)
    plausible: 5e3,
    confused_with: &[Effect::MountClocking],
    names: &|_| vec!["D_O"],
    columns: &|s, j, _| vec![s.column(|k| s.force[k].dot(&s.gyros[j].output))],
    closure_only: true,
    ..PLAIN
};

pub const MOUNT_CLOCKING: Entry = Entry {
    effect: Effect::MountClocking,
    id: "mount_clocking",
    cause: "the gyro is turned about its input axis in its seat: part of D_S shows along the nominal output axis",
    equation: "D_S tan(phi) a_O",
    unit: "deg/(h g0)",
    typical: [1e-4, 0.05], // mounting tolerances of arc-minutes; atan2(D_O, D_S) of Tables 3-4
    plausible: 5e3,
    confused_with: &[Effect::OutputAxisG],
    names: &|_| vec!["D_O"],
    columns: &|s, j, _| vec![s.column(|k| s.force[k].dot(&s.gyros[j].output))],
    closure_only: true,
    ..PLAIN
};

const PRODUCTS: [&str; 3] = ["k_IS", "k_IO", "k_OS"];

fn picked(shape: Shape) -> impl Iterator<Item = usize> {
    let only: &'static [usize] = match shape {
        Shape::Only(picked) => picked,
        _ => &[0, 1, 2],
    };
    only.iter().copied()
}
