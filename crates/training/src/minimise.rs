//! Minimises a smooth function by L-BFGS with the line search of Moré and Thuente (argmin).

use std::cell::RefCell;

use argmin::core::{CostFunction, Error, Executor, Gradient, State};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;

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
