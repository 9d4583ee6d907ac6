//! Minimises a smooth function by L-BFGS with the line search of Moré and Thuente (argmin): also that of a logistic regression.

use std::cell::RefCell;

use argmin::core::{CostFunction, Error, Executor, Gradient, State};
use argmin::solver::{linesearch::MoreThuenteLineSearch, quasinewton::LBFGS};
use ndarray::ArrayView1;

use willis_core::support::{calibration::Calibration, statistics::sigmoid};

/// Steps that are remembered as curvature.
const MEMORY: usize = 10;
/// Done when the gradient, or the gain of a step, is no more than this.
const LEAST_GRADIENT: f64 = 1e-7;
const LEAST_GAIN: f64 = 1e-10;

/// Value and gradient at a point.
type Evaluated = (f64, Vec<f64>);

/// The best point found.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// Where it is.
    pub point: Vec<f64>,
    /// The value there.
    pub value: f64,
    /// How often the function was evaluated.
    pub evaluations: usize,
}

struct Problem<'a> {
    function: &'a dyn Fn(&[f64]) -> Evaluated,
    /// L-BFGS asks for value and gradient at the same point one after the other.
    last: &'a RefCell<Option<(Vec<f64>, Evaluated)>>,
    best: &'a RefCell<Minimum>,
}

impl Problem<'_> {
    fn at<R>(&self, x: &[f64], take: impl Fn(&Evaluated) -> R) -> R {
        let mut last = self.last.borrow_mut();
        match &*last {
            Some((point, evaluated)) if point == x => take(evaluated),
            _ => {
                let evaluated = (self.function)(x);
                let mut best = self.best.borrow_mut();
                best.evaluations += 1;
                if evaluated.0 < best.value {
                    (best.point, best.value) = (x.to_vec(), evaluated.0);
                }
                let taken = take(&evaluated);
                *last = Some((x.to_vec(), evaluated));
                taken
            }
        }
    }
}

impl CostFunction for Problem<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, Error> {
        // Without this a line search would never end.
        let value = self.at(x, |e| e.0);
        if value.is_nan() { Err(Error::msg("no number")) } else { Ok(value) }
    }
}

impl Gradient for Problem<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, x: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Ok(self.at(x, |e| e.1.clone()))
    }
}

/// The lowest point met in so many iterations from `start`. `function` gives value and gradient.
pub fn minimise(start: Vec<f64>, iterations: usize, function: &dyn Fn(&[f64]) -> Evaluated) -> Minimum {
    let best = RefCell::new(Minimum { point: start.clone(), value: f64::INFINITY, evaluations: 0 });
    let last = RefCell::new(None);
    let run = || {
        let solver = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY);
        let solver = solver.with_tolerance_grad(LEAST_GRADIENT)?.with_tolerance_cost(LEAST_GAIN)?;
        let problem = Problem { function, last: &last, best: &best };
        let executor = Executor::new(problem, solver).configure(|s| s.param(start).max_iters(iterations as u64));
        executor.run().map(|result| result.state().get_iter())
    };
    // A line search that finds no descent any more ends the search; the best point is the answer.
    let _: Result<u64, Error> = run();
    best.into_inner()
}

const ITERATIONS: usize = 300;

/// A row of a regression: its columns, of which the first is constant, whether it is true, and how much it counts.
pub type RegressionRow = (Vec<f64>, bool, f64);

/// The coefficients that minimise Σ ω (ln(1 + e^z) - z true) / Σ ω + l2 Σ b'², b' the slopes times the standard deviation of
/// their column; the constant is free. Zeros without a row.
pub fn logistic(rows: &[RegressionRow], l2: f64) -> Vec<f64> {
    let columns = rows.first().map_or(0, |(x, ..)| x.len());
    let total: f64 = rows.iter().map(|(.., weight)| weight).sum();
    let design: Vec<ArrayView1<f64>> = rows.iter().map(|(x, ..)| ArrayView1::from(x)).collect();
    let scale: Vec<f64> = spread(columns, &design).into_iter().map(|spread| if spread > 0.0 { spread } else { 1.0 }).collect();
    let loss = |y: &[f64]| {
        let mut value = l2 * y.iter().skip(1).map(|y| y * y).sum::<f64>();
        let mut slope: Vec<f64> = y.iter().enumerate().map(|(k, y)| if k > 0 { 2.0 * l2 * y } else { 0.0 }).collect();
        for (x, is_true, weight) in rows {
            let z: f64 = y.iter().zip(x).zip(&scale).map(|((y, x), s)| y / s * x).sum();
            let truth = f64::from(u8::from(*is_true));
            value += weight / total * (z.max(0.0) + (-z.abs()).exp().ln_1p() - truth * z);
            let residual = weight / total * (sigmoid(z) - truth);
            slope.iter_mut().zip(x).zip(&scale).for_each(|((g, x), s)| *g += residual * x / s);
        }
        (value, slope)
    };
    let found = minimise(vec![0.0; columns], ITERATIONS, &loss).point;
    found.iter().zip(&scale).map(|(y, s)| y / s).collect()
}

/// The standard deviation of each column over some rows; 0 without a row.
pub(crate) fn spread(columns: usize, rows: &[ArrayView1<f64>]) -> Vec<f64> {
    let mean_of = |f: &dyn Fn(usize, f64) -> f64| {
        let mut sum = vec![0.0; columns];
        for row in rows {
            sum.iter_mut().zip(row).enumerate().for_each(|(column, (sum, x))| *sum += f(column, *x));
        }
        sum.into_iter().map(|s| s / rows.len().max(1) as f64).collect::<Vec<f64>>()
    };
    let mean = mean_of(&|_, x| x);
    mean_of(&|column, x| (x - mean[column]).powi(2)).into_iter().map(f64::sqrt).collect()
}

const L2: f64 = 1e-5;

/// a and b of P = σ(a + b l) of probabilities with whether they were right, l their log-odds; b is at least 0, so that the order stays.
/// `None` without a pair.
pub fn calibrate_in_order(pairs: &[(f64, bool)]) -> Option<[f64; 2]> {
    let rows = |columns: usize| -> Vec<RegressionRow> {
        pairs.iter().map(|(p, right)| (Calibration::design(*p)[..columns].to_vec(), *right, 1.0)).collect()
    };
    match logistic(&rows(2), L2)[..] {
        [a, b] if b >= 0.0 => Some([a, b]),
        [..] => logistic(&rows(1), L2).first().map(|a| [*a, 0.0]),
    }
}

/// The calibration of pairs of points with their probability by the model, further figures beside it, whether they are right, and how much
/// each counts; and the slopes of the further figures.
pub fn calibrate<const N: usize>(pairs: impl Iterator<Item = (f64, [f64; N], bool, f64)>) -> ([f64; 3], [f64; N]) {
    let rows: Vec<RegressionRow> =
        pairs.map(|(p, further, right, weight)| ([&Calibration::design(p)[..], &further].concat(), right, weight)).collect();
    let found = logistic(&rows, L2);
    let at = |k: usize| found.get(k).copied().unwrap_or(0.0);
    (std::array::from_fn(at), std::array::from_fn(|k| at(3 + k)))
}
