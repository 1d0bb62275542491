//! Cholesky's factor of a positive semidefinite matrix to a low rank, which nalgebra does not have.

use nalgebra::DMatrix;

/// B with K = B B' up to a share `left_out` of its trace, of rank `most` at most: the largest pivot comes first.
pub(crate) fn pivoted_cholesky(kernel: &DMatrix<f64>, most: usize, left_out: f64) -> DMatrix<f64> {
    let n = kernel.nrows();
    let mut left: Vec<f64> = kernel.diagonal().iter().copied().collect();
    let trace: f64 = left.iter().sum();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    while columns.len() < most && left.iter().sum::<f64>() > left_out * trace {
        let Some(pivot) = (0..n).max_by(|&a, &b| left[a].total_cmp(&left[b])).filter(|&p| left[p] > 0.0) else { break };
        let root = left[pivot].sqrt();
        let column: Vec<f64> = (0..n)
            .map(|k| (kernel[(k, pivot)] - columns.iter().map(|c| c[k] * c[pivot]).sum::<f64>()) / root)
            .collect();
        left.iter_mut().zip(&column).for_each(|(left, x)| *left = (*left - x * x).max(0.0));
        columns.push(column);
    }
    DMatrix::from_fn(n, columns.len(), |k, c| columns[c][k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kernel_is_its_factor_times_itself() {
        let kernel = DMatrix::from_fn(30, 30, |a, b| (-0.5 * ((a as f64 - b as f64) / 6.0).powi(2)).exp());
        let factor = pivoted_cholesky(&kernel, 24, 1e-3);
        assert!(factor.ncols() < 15, "{}", factor.ncols());
        assert!((&factor * factor.transpose() - &kernel).abs().max() < 0.03);
    }
}
