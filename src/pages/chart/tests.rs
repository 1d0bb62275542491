use super::*;

fn chart(values: &[f64]) -> Chart {
    let day = 864e5;
    let dot = |(k, y): (usize, &f64)| DataPoint {
        x: k as f64 * day,
        y: *y,
        sd: Some(0.001),
        status: Some(if *y > 0.01 { Status::Confirmed } else { Status::InTolerance }),
        letters: if *y > 0.01 { "B".into() } else { String::new() },
        href: Some(format!("/records/{k}")),
        said: format!("record {k}"),
    };
    let x = widened((0.0, (values.len().max(2) - 1) as f64 * day), 0.02, 15.0 * day);
    let mut chart = Chart::new("A D_I".into(), html! { "D_I" }, XAxis::Time, x);
    chart.around = 0.01;
    chart.whole = Some(0.01);
    chart.signed = true;
    chart.clips = true;
    chart.levels = vec![Level { from: x.0, until: x.1, budget: Some(0.01), control: Some(0.004), ..Level::default() }];
    let dots = values.iter().enumerate().map(dot).collect();
    chart.tracks = vec![Track { class: "record".into(), dots, joined: true, ..Track::default() }];
    chart
}

fn numbers(drawn: &str, before: &str) -> Vec<f64> {
    drawn
        .split(before)
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap().trim_end_matches('%').parse().unwrap())
        .collect()
}

#[test]
fn every_point_has_its_shape_its_words_and_its_record_and_higher_values_stand_higher() {
    let drawn = chart(&[0.0, 0.005, 0.02]).markup().into_string();
    assert_eq!(drawn.matches("<circle class=\"in_tolerance\"").count(), 2, "{drawn}");
    assert_eq!((drawn.matches("<path class=\"confirmed\"").count(), drawn.matches(">B</text>").count()), (1, 1));
    for k in 0..3 {
        assert!(
            drawn.contains(&format!("href=\"/records/{k}\"")) && drawn.contains(&format!("<title>record {k}</title>"))
        );
    }
    let heights = numbers(&drawn, "cy=\"");
    assert!(heights[1] < heights[0], "{heights:?}");
    assert!(!drawn.contains("NaN"));
}

#[test]
fn the_axis_holds_the_budget_with_its_figures_however_little_was_measured() {
    let drawn = chart(&[0.0, 0.0004, -0.0003]).markup().into_string();
    for figure in [
        ">+0.010</text>",
        ">-0.010</text>",
        ">+100 %</text>",
        ">-100 %</text>",
        ">0 %</text>",
        ">UCL</text>",
        ">LCL</text>",
    ] {
        assert!(drawn.contains(figure), "{figure} is not in {drawn}");
    }
    assert_eq!(drawn.matches("class=\"budget\"").count(), 2);
    // 5 % of the budget are 5 % of half the height at the most.
    let heights = numbers(&drawn, "cy=\"");
    let spread = heights.iter().fold(f64::MIN, |a, b| a.max(*b)) - heights.iter().fold(f64::MAX, |a, b| a.min(*b));
    assert!(spread < 0.05 * 170.0, "{heights:?}");
}

#[test]
fn one_blunder_stands_at_the_edge_with_its_value_and_a_drift_is_drawn_to_its_end() {
    let mut values = vec![0.001; 30];
    values[12] = 5.19;
    let drawn = chart(&values).markup().into_string();
    assert!(drawn.contains("class=\"off confirmed\"") && drawn.contains(">+5.19</text>"), "{drawn}");
    assert!(drawn.contains(">+100 %</text>") && !drawn.contains(">+50000 %<"), "the others keep their scale");
    assert!(drawn.contains("href=\"/records/12\""), "and it still leads to its record");
    // So do two of one day, which are too many for that unless they leave nothing to be seen of the others.
    (values[28], values[29]) = (-1.49, -1.48);
    values[12] = 0.001;
    let drawn = chart(&values).markup().into_string();
    assert!(drawn.matches("class=\"off").count() == 2 && drawn.contains(">+100 %</text>"), "{drawn}");
    let mut stepped = [0.001; 30];
    stepped[28..].copy_from_slice(&[0.05, 0.051]);
    let drawn = chart(&stepped).markup().into_string();
    assert!(!drawn.contains("class=\"off"), "five budgets are to be seen: {drawn}");
    let drift: Vec<f64> = (0..30).map(|k| 0.001 * f64::from(k)).collect();
    let drawn = chart(&drift).markup().into_string();
    assert!(!drawn.contains("class=\"off"), "{drawn}");
    // The newest of few is no less to be seen.
    let drawn = chart(&[0.0, 0.001, 0.0, 7.5]).markup().into_string();
    assert!(drawn.contains(">+7.5</text>") && drawn.contains("href=\"/records/3\""), "{drawn}");
}

#[test]
fn values_at_the_edge_stand_apart_and_within_the_picture() {
    let mut values = vec![0.001; 200];
    values[99..102].copy_from_slice(&[5.17, 5.18, 5.19]);
    values[0] = -7.5;
    let mut chart = chart(&values);
    chart.x = (0.0, 199.0 * 864e5);
    let drawn = chart.markup().into_string();
    assert_eq!(drawn.matches("class=\"off").count(), 4);
    assert!(drawn.contains(">+5.19</text>") && !drawn.contains(">+5.18</text>"), "one of three that touch: {drawn}");
    assert!(drawn.contains("text-anchor=\"start\">-7.5</text>"), "{drawn}");
}

#[test]
fn the_newest_point_stands_within_the_picture() {
    let drawn = chart(&[0.0, 0.001, 0.002, 0.03]).markup().into_string();
    let across = numbers(&drawn, "cx=\"");
    assert!(across.iter().all(|x| (0.5..99.5).contains(x)), "{across:?}");
}

#[test]
fn too_many_points_are_an_envelope_about_their_median() {
    let mut all = chart(&[0.0]);
    all.tracks[0].envelope = (0..200).map(|k| [f64::from(k) * 4e5, -0.003, 0.0, 0.004]).collect();
    let drawn = all.markup().into_string();
    assert_eq!((drawn.matches("class=\"envelope\"").count(), drawn.matches("class=\"median\"").count()), (1, 1));
}

#[test]
fn nothing_to_draw_is_no_picture_and_one_point_is_one() {
    assert_eq!(chart(&[]).markup().into_string(), "");
    let one = chart(&[0.0]).markup().into_string();
    assert!(one.contains("<circle") && !one.contains("NaN") && !one.contains("inf"), "{one}");
}

#[test]
fn every_figure_of_an_axis_that_has_room_is_written_and_the_name_stands_below_them() {
    let of = |until: f64, name: &str| {
        let mut all = chart(&[0.0]);
        all.across = XAxis::Figure(name.into());
        all.x = (-0.05 * until, 1.05 * until);
        all.markup().into_string()
    };
    let drawn = of(100.0, "a regressor with a long name, deg/h");
    for k in 0..=5 {
        assert!(drawn.contains(&format!(">{}</text>", 20 * k)), "{} is not in {drawn}", 20 * k);
    }
    let line = |word: &str| {
        let text = &drawn[..drawn.find(word).unwrap()];
        text[text.rfind("y=\"").unwrap() + 3..].split('"').next().unwrap().parse::<f64>().unwrap()
    };
    assert!(line(">a regressor") >= line(">100</text>") + LINE, "{drawn}");
    // Where they would lie over one another, some are left out.
    let wide = of(1e-7, "x");
    assert!(wide.contains(">0.00000004</text>") && !wide.contains(">0.00000002</text>"), "{wide}");
}

#[test]
fn what_took_time_is_shaded_and_lanes_say_where_a_gyro_was() {
    let mut all = chart(&[0.0, 0.001, 0.002]);
    let flag = |number, until: Option<f64>, label: &str| Flag {
        x: 4e7,
        until,
        number,
        anchor: format!("event-{number}"),
        label: label.into(),
    };
    all.flags = vec![flag(1, None, "repair"), flag(2, Some(9e7), "vibration")];
    all.lanes = vec![vec![Segment { from: 0.0, until: 9e7, label: "IMU-02 G1".into(), kind: 7 }]];
    let end = (2.0 * 864e5, 0.01);
    all.ahead = Some(Extrapolation { line: [(0.0, 0.0), (864e5, 0.001), end], cone: Some([(1.5 * 864e5, 0.01), end]) });
    let drawn = all.markup().into_string();
    assert_eq!(drawn.matches("class=\"test\"").count(), 1);
    for there in [
        "<title>repair</title>",
        "href=\"#event-1\"",
        "class=\"lane1\"",
        "IMU-02 G1",
        "class=\"cone\"",
        "class=\"ahead\"",
    ] {
        assert!(drawn.contains(there), "{there} is not in {drawn}");
    }
}

#[test]
fn a_name_that_its_lane_has_no_room_for_is_left_out_and_stands_in_the_legend() {
    let mut all = chart(&[0.001; 100]);
    let day = 864e5;
    let part = |from: f64, until: f64, label: &str, kind| Segment {
        from: from * day,
        until: until * day,
        label: label.into(),
        kind,
    };
    // A day of a hundred has room for nothing, eight for a name on a desk, and ninety everywhere.
    let stations = vec![part(0.0, 90.0, "ST-1", 0), part(90.0, 98.0, "ST-2", 1), part(98.0, 99.0, "ST-3", 2)];
    all.lanes = vec![vec![part(0.0, 99.0, "IMU-02 G1", 0)], stations];
    let drawn = all.markup().into_string();
    let written =
        |label: &str, class: &str| drawn.contains(&format!("<text class=\"{class}\" x=\"3\" y=\"9.5\">{label}</text>"));
    assert!(written("IMU-02 G1", "") && written("ST-1", "") && written("ST-2", "roomy"), "{drawn}");
    assert!(!drawn.contains(">ST-3</text>") && drawn.contains("<title>ST-3</title>"), "{drawn}");
    let unnamed: Vec<&str> = all.unnamed().iter().map(|segment| &*segment.label).collect();
    assert_eq!(unnamed, ["ST-2", "ST-3"]);
}

#[test]
fn the_name_of_a_level_is_in_the_way_of_no_point_and_of_no_axis() {
    let place = |values: &[f64], from: f64| {
        let mut all = chart(values);
        let from = all.x.0 + from * (all.x.1 - all.x.0);
        all.levels[0] = Level { from, label: "level 1".into(), ..all.levels[0].clone() };
        let drawn = all.markup().into_string();
        let text = drawn.split("<text").find(|text| text.contains(">level 1<")).unwrap().to_owned();
        (numbers(&text, " y=\"")[0], text.contains("text-anchor=\"end\""))
    };
    let ((foot, is_at_end), (head, _)) = (place(&[0.0, 0.0, 0.0], 0.0), place(&[-0.009, -0.009, -0.009], 0.0));
    assert!(head < 60.0 && foot > 100.0 && !is_at_end, "{head} {foot}");
    // Beyond the budget there is room where points are at its foot and head; none where they are there as well.
    let both = place(&[-0.009, 0.009].repeat(20), 0.0).0;
    assert!(both < 16.0 || both > foot + 4.0, "{both}");
    let everywhere = place(&[-0.009, 0.009, -0.0112, 0.0112].repeat(10), 0.0).0;
    assert!(everywhere > 100.0 && everywhere < foot, "{everywhere}");
    // The budget is a line where much lies far off; its name stands beside it.
    let squeezed = place(&[[0.0; 20], [-1.5; 20]].concat(), 0.0).0;
    assert!(squeezed > 26.0 && squeezed < 60.0, "{squeezed}");
    assert!(place(&[0.0, 0.0, 0.0], 0.6).1, "a level that begins late ends at the end");
}
