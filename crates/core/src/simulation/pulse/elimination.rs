//! Solves the complex symmetric equations of a network at one frequency along a compiled elimination.

use num_complex::Complex64;

use crate::support::elimination::Elimination;

/// The admittances of a network by place in the order of an elimination, and what is injected.
#[derive(Debug, Clone)]
pub struct Equations<'a> {
    elimination: &'a Elimination,
    /// To the ground, by place.
    ground: Vec<Complex64>,
    /// Between places, by ray.
    rays: Vec<Complex64>,
    /// To pressures that are prescribed: place, admittance and pressure.
    ties: Vec<(u32, Complex64, Complex64)>,
    /// By place.
    injected: Vec<Complex64>,
}

impl<'a> Equations<'a> {
    /// Without any admittance.
    pub fn new(elimination: &'a Elimination) -> Self {
        let none = |count: usize| vec![Complex64::ZERO; count];
        let (ground, injected) = (none(elimination.nodes()), none(elimination.nodes()));
        Self { elimination, ground, rays: none(elimination.rays()), ties: Vec::new(), injected }
    }

    /// Adds an admittance from a place to the ground.
    pub fn ground(&mut self, place: u32, admittance: Complex64) {
        self.ground[place as usize] += admittance;
    }

    /// Adds an admittance from a place to a prescribed pressure.
    pub fn tie(&mut self, place: u32, admittance: Complex64, pressure: Complex64) {
        self.ties.push((place, admittance, pressure));
    }

    /// Adds what is injected at a place.
    pub fn inject(&mut self, place: u32, flow: Complex64) {
        self.injected[place as usize] += flow;
    }

    /// Adds an admittance between two places.
    pub fn join(&mut self, a: u32, b: u32, admittance: Complex64) {
        if a != b {
            let ray = self.elimination.ray_between(a, b);
            self.rays[ray as usize] += admittance;
        }
    }

    /// The pressures by place, with one step of refinement: nothing is pivoted, since the real part of the equations is positive definite
    /// where every vessel is passive.
    pub fn solve(&self) -> Vec<Complex64> {
        let (inverse, rays) = self.factors();
        let mut solution = vec![Complex64::ZERO; self.ground.len()];
        for _ in 0..2 {
            let correction = self.substitute(&inverse, &rays, self.left(&solution));
            solution.iter_mut().zip(correction).for_each(|(x, dx)| *x += dx);
        }
        solution
    }

    /// What of Kirchhoff's law is left at some pressures: what is injected less what leaves, by drops, which keep their digits.
    fn left(&self, at: &[Complex64]) -> Vec<Complex64> {
        let mut left = self.injected.clone();
        for (k, ground) in self.ground.iter().enumerate() {
            left[k] -= ground * at[k];
            for ray in self.elimination.star(k) {
                let to = self.elimination.ray_to()[ray] as usize;
                let flow = self.rays[ray] * (at[k] - at[to]);
                left[k] -= flow;
                left[to] += flow;
            }
        }
        for (place, admittance, pressure) in &self.ties {
            left[*place as usize] -= admittance * (at[*place as usize] - pressure);
        }
        left
    }

    /// The factors of the equations: one over the pivots, and the rays.
    fn factors(&self) -> (Vec<Complex64>, Vec<Complex64>) {
        let elimination = self.elimination;
        let (mut diagonal, mut rays) = (self.ground.clone(), self.rays.clone());
        for (k, ray) in (0..diagonal.len()).flat_map(|k| elimination.star(k).map(move |ray| (k, ray))) {
            diagonal[k] += rays[ray];
            diagonal[elimination.ray_to()[ray] as usize] += rays[ray];
        }
        for (place, admittance, _) in &self.ties {
            diagonal[*place as usize] += admittance;
        }
        let mut inverse = vec![Complex64::ZERO; diagonal.len()];
        for k in 0..diagonal.len() {
            inverse[k] = diagonal[k].inv();
            let star = elimination.star(k);
            let mut mesh = elimination.mesh(k).iter();
            for i in star.clone() {
                let share = rays[i] * inverse[k];
                diagonal[elimination.ray_to()[i] as usize] -= share * rays[i];
                for (j, target) in (i + 1..star.end).zip(&mut mesh) {
                    let added = share * rays[j];
                    rays[*target as usize] += added;
                }
            }
        }
        (inverse, rays)
    }

    /// Forward and back substitution.
    fn substitute(&self, inverse: &[Complex64], rays: &[Complex64], mut right: Vec<Complex64>) -> Vec<Complex64> {
        for k in 0..right.len() {
            let passed = right[k] * inverse[k];
            for ray in self.elimination.star(k) {
                right[self.elimination.ray_to()[ray] as usize] += rays[ray] * passed;
            }
        }
        for k in (0..right.len()).rev() {
            let mut sum = right[k];
            for ray in self.elimination.star(k) {
                sum += rays[ray] * right[self.elimination.ray_to()[ray] as usize];
            }
            right[k] = sum * inverse[k];
        }
        right
    }
}
