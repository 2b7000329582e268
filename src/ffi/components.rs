//! The interface form in a host's own vectors: which slot is which component, and in what scale.

use super::arguments::write;
use crate::law::{InterfaceResponse, Law};
use crate::memory::Vector;
use libc::c_double;

/// The largest vector of a host, and the largest part of it that an interface has.
const LARGEST: usize = 6;
const INTERFACE: usize = 3;

/// Components of the interface: normal, then tangential; with one direction the last one is not used.
///
/// In slot k: force = weight x traction, and opening = length x weight x gradient.
pub(super) struct Components {
    /// Length of the host's vectors.
    pub size: usize,
    pub slots: [usize; INTERFACE],
    pub weights: [f64; INTERFACE],
    pub length: f64,
}

/// How a matrix lies in memory.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Order {
    RowMajor,
    ColumnMajor,
}

/// d traction_i / d opening_j.
pub(super) type Operator = [[f64; INTERFACE]; INTERFACE];

/// The consistent tangent.
pub(super) fn consistent<const N: usize>(response: &InterfaceResponse<N>) -> Operator {
    let mut operator = Operator::default();
    operator[0][0] = response.normal_stiffness;
    for i in 0..N {
        operator[1 + i][0] = response.dtraction_dopening[i];
        for j in 0..N {
            operator[1 + i][1 + j] = response.friction.dtraction_dslip[(i, j)];
        }
    }
    operator
}

/// The same tangential stiffness in every direction, and no coupling: symmetric.
pub(super) fn uncoupled(normal: f64, tangential: f64) -> Operator {
    [
        [normal, 0.0, 0.0],
        [0.0, tangential, 0.0],
        [0.0, 0.0, tangential],
    ]
}

/// The stiffness while nothing slips.
pub(super) fn sticking<const N: usize>(
    law: &Law<N>,
    gcr: f64,
    response: &InterfaceResponse<N>,
) -> Operator {
    uncoupled(
        response.normal_stiffness,
        law.sticking_stiffness(gcr, -response.normal_traction),
    )
}

impl Components {
    /// The opening that a gradient stands for.
    pub(super) fn opening<const N: usize>(&self, gradient: &[f64]) -> (f64, Vector<N>) {
        let component = |k: usize| self.length * self.weights[k] * gradient[self.slots[k]];
        (component(0), Vector::from_fn(|i, _| component(1 + i)))
    }

    /// The traction that forces stand for.
    pub(super) fn traction<const N: usize>(&self, forces: &[f64]) -> (f64, Vector<N>) {
        let component = |k: usize| forces[self.slots[k]] / self.weights[k];
        (component(0), Vector::from_fn(|i, _| component(1 + i)))
    }

    /// Writes the forces.
    ///
    /// # Safety
    /// `forces` is null or has room for `size` numbers.
    pub(super) unsafe fn write_forces<const N: usize>(
        &self,
        response: &InterfaceResponse<N>,
        forces: *mut c_double,
    ) {
        let mut values = [0.0; LARGEST];
        values[self.slots[0]] = self.weights[0] * response.normal_traction;
        for (i, traction) in response.friction.traction.iter().enumerate() {
            values[self.slots[1 + i]] = self.weights[1 + i] * traction;
        }
        // SAFETY: room by the caller's word.
        unsafe { write(forces, &values[..self.size]) }
    }

    /// Writes d force / d gradient.
    ///
    /// # Safety
    /// `matrix` is null or has room for `size` x `size` numbers.
    pub(super) unsafe fn write_operator<const N: usize>(
        &self,
        operator: &Operator,
        order: Order,
        matrix: *mut c_double,
    ) {
        let mut values = [0.0; LARGEST * LARGEST];
        for (i, row) in operator.iter().enumerate().take(1 + N) {
            for (j, stiffness) in row.iter().enumerate().take(1 + N) {
                let (row, column) = match order {
                    Order::RowMajor => (self.slots[i], self.slots[j]),
                    Order::ColumnMajor => (self.slots[j], self.slots[i]),
                };
                values[row * self.size + column] =
                    self.length * self.weights[i] * self.weights[j] * stiffness;
            }
        }
        // SAFETY: room by the caller's word.
        unsafe { write(matrix, &values[..self.size * self.size]) }
    }
}
