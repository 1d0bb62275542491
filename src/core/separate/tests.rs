use super::*;

/// Tables 3 and 4: E (pulse/arcsec) and G (pulse/(s g0)) of the paper's three gyros.
const TABLES_3_4: [([f64; 3], [f64; 3]); 3] = [
    ([0.8473, -0.6011, 1.0367], [2.4210, 4.0554, 6.5179]),
    ([0.8478, -0.6000, -1.0381], [0.8634, 4.6419, -3.4081]),
    ([0.8533, 1.2062, -0.0008], [0.9901, 1.4495, -9.9775]),
];

fn of_the_paper(slot: Slot) -> Separation {
    let (e, g) = TABLES_3_4[slot.index()];
    separate(&Geometry::Skewed, slot, &Vector3::from(e), &Vector3::from(g), None).expect("the paper's data separate")
}

fn assert_near(what: &str, got: f64, want: f64) {
    assert!((got - want).abs() <= 1e-6, "{what}: {got} instead of {want}");
}

#[test]
fn an_axis_across_its_nominal_one_is_no_axis_that_points_away() {
    let of = |e: Vector3<f64>| separate(&Geometry::Orthogonal, Slot::G1, &e, &Vector3::new(1.0, 2.0, 3.0), None);
    assert!(of(Vector3::new(0.0, 0.0, 1.0)).is_ok(), "at a right angle");
    assert!(matches!(of(Vector3::new(-1e-9, 0.0, 1.0)), Err(Unseparable::PointsAway(_))));
}

#[test]
fn the_closure_of_the_published_method_is_the_rms_of_what_it_leaves_over() {
    for slot in Slot::ALL {
        let (e, g) = TABLES_3_4[slot.index()];
        let (e, g) = (Vector3::from(e), Vector3::from(g));
        let published = of_the_paper(slot).published.unwrap();
        // The best that D_I along u and anything across it can do: |D_O| of both, by the plane that the method spans.
        let (u, y) = (e / e.norm(), g / e.norm());
        let across = y - u * y.dot(&u);
        assert!(published.closure_rms * 3.0_f64.sqrt() <= across.norm());
        let far = separate(&Geometry::Skewed, slot, &e, &(g * 1e3), None).unwrap().published.unwrap();
        assert!((far.closure_rms / (1e3 * published.closure_rms) - 1.0).abs() < 1e-9, "in proportion to G");
    }
}

#[test]
fn the_papers_tables_give_the_golden_figures() {
    struct Golden {
        alpha: [f64; 3],
        published: (&'static str, f64, f64),
        as_printed: (f64, f64),
        rigid: [f64; 3],
    }
    let golden = [
        Golden {
            alpha: [54.737806, 114.177661, 45.059738],
            published: ("8", 2.958219, 4.618253),
            as_printed: (2.958219, 4.618253),
            rigid: [2.957643, 4.618005, 0.075874],
        },
        Golden {
            alpha: [54.736756, 114.116126, 134.985211],
            published: ("10", 0.688255, 3.898324),
            as_printed: (0.689624, 3.899350),
            rigid: [0.688549, 3.898225, 0.232169],
        },
        Golden {
            alpha: [54.723337, 35.276680, 90.031023],
            published: ("13", 1.187903, -6.752266),
            as_printed: (1.187903, -6.752266),
            rigid: [1.191559, -6.752265, -0.019514],
        },
    ];
    for (slot, want) in Slot::ALL.into_iter().zip(golden) {
        let got = of_the_paper(slot);
        for axis in 0..3 {
            assert_near("alpha", got.alpha[axis].to_degrees(), want.alpha[axis]);
        }
        let published = got.published.expect("skewed");
        assert_eq!(published.branch.name(), want.published.0);
        assert_near("published D_I", published.d_i, want.published.1);
        assert_near("published D_S", published.d_s, want.published.2);
        let printed = got.as_printed.expect("skewed");
        assert_near("as printed D_I", printed.d_i, want.as_printed.0);
        assert_near("as printed D_S", printed.d_s, want.as_printed.1);
        assert_near("rigid D_I", got.rigid.d_i, want.rigid[0]);
        assert_near("rigid D_S", got.rigid.d_s, want.rigid[1]);
        assert_near("rigid D_O", got.rigid.d_o, want.rigid[2]);
    }
}

/// A covariance of (E, G) with cross terms: B B^T for a fixed B.
fn correlated(scale: f64) -> CovarianceEg {
    let b = CovarianceEg::from_fn(|i, j| scale * (1.0 + ((i * 7 + j * 3 + i * j) % 5) as f64 - 2.2));
    b * b.transpose()
}

/// Central differences of some figures of a separation by (E, G), and the covariance that they carry over.
fn propagated<const N: usize>(
    slot: Slot,
    covariance: &CovarianceEg,
    of: impl Fn(&Separation) -> [f64; N],
) -> Vec<Vec<f64>> {
    let (e, g) = TABLES_3_4[slot.index()];
    let at = |place: usize, step: f64| {
        let (mut e, mut g) = (Vector3::from(e), Vector3::from(g));
        if place < 3 {
            e[place] += step
        } else {
            g[place - 3] += step
        }
        of(&separate(&Geometry::Skewed, slot, &e, &g, None).expect("near the paper's data"))
    };
    let step = 1e-6;
    let by = |place: usize| {
        let (up, down) = (at(place, step), at(place, -step));
        up.iter().zip(&down).map(|(up, down)| (up - down) / (2.0 * step)).collect::<Vec<f64>>()
    };
    let jacobian: Vec<Vec<f64>> = (0..6).map(by).collect();
    let entry = |a: usize, b: usize| {
        (0..6)
            .flat_map(|i| (0..6).map(move |j| (i, j)))
            .map(|(i, j)| jacobian[i][a] * covariance[(i, j)] * jacobian[j][b])
            .sum()
    };
    (0..N).map(|a| (0..N).map(|b| entry(a, b)).collect()).collect()
}

#[test]
fn stated_covariances_are_those_that_central_differences_carry_over() {
    let covariance = correlated(1e-4);
    for slot in Slot::ALL {
        let (e, g) = TABLES_3_4[slot.index()];
        let found = separate(&Geometry::Skewed, slot, &Vector3::from(e), &Vector3::from(g), Some(&covariance)).unwrap();
        let near = |what: &str, stated: f64, expected: f64, of: f64| {
            assert!((stated - expected).abs() < 1e-4 * of, "{slot:?} {what}: {stated} {expected}");
        };
        let rigid = propagated(slot, &covariance, |s| [s.rigid.d_i, s.rigid.d_s, s.rigid.d_o]);
        let stated = found.rigid.covariance.unwrap();
        for a in 0..3 {
            for b in 0..3 {
                near("rigid", stated[(a, b)], rigid[a][b], (rigid[a][a] * rigid[b][b]).sqrt());
            }
        }
        let printed = found.as_printed.as_ref().expect("skewed");
        assert_eq!(printed.covariance, None, "for comparison only");
        let published = propagated(slot, &covariance, |s| {
            let published = s.published.as_ref().expect("skewed");
            [published.d_i, published.d_s]
        });
        let stated = found.published.as_ref().unwrap().covariance.unwrap();
        for a in 0..2 {
            for b in 0..2 {
                near("published", stated[(a, b)], published[a][b], (published[a][a] * published[b][b]).sqrt());
            }
        }
        let clocking = propagated(slot, &covariance, |s| [s.rigid.clocking()])[0][0];
        near("clocking", found.rigid.clocking_sd().unwrap().powi(2), clocking, clocking);
        let scale = propagated(slot, &covariance, |s| [s.scale_factor])[0][0];
        near("|E|", found.scale_factor_sd.unwrap().powi(2), scale, scale);
    }
}
