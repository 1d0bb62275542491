//! Units as machines and as people read them: `deg/(h*g0^2)` and `deg/(h g0²)`.

/// As every format for machines has it; both spellings are read.
pub fn of_machines(unit: &str) -> String {
    let mut is_within = false;
    let spelled = unit.chars().map(|c| {
        is_within = (is_within || c == '(') && c != ')';
        if is_within && c == ' ' { '*' } else { c }
    });
    spelled.collect()
}

/// A machine's spelling of a unit as people read it: `deg/(h*g0^2)` becomes `deg/(h g0²)`.
pub fn of_people(unit: &str) -> String {
    unit.replace('*', " ").replace("^2", "²").replace("^3", "³")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_products_in_a_denominator_are_spelled_twice() {
        for (plain, machines, people) in [
            ("deg/(h g0)", "deg/(h*g0)", "deg/(h g0)"),
            ("deg/(h g0^2 K)", "deg/(h*g0^2*K)", "deg/(h g0² K)"),
            ("deg/h/(deg/h)^3", "deg/h/(deg/h)^3", "deg/h/(deg/h)³"),
            ("standard deviations", "standard deviations", "standard deviations"),
            ("deg/(h g0) per campaign", "deg/(h*g0) per campaign", "deg/(h g0) per campaign"),
        ] {
            assert_eq!((of_machines(plain).as_str(), of_people(machines).as_str()), (machines, people));
            assert_eq!(of_machines(machines), machines);
        }
    }
}
