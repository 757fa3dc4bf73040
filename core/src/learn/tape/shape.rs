//! Operations that move values: concatenation of columns, sums, and blocks of rows and columns.

use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::Var;
use crate::base::scratch::ScratchTooSmall;
use crate::base::slices::Slices;
use crate::learn::kernels::float::Float;

/// Y = [A; B]: the columns of A, then those of B.
#[derive(Clone, Copy, Debug)]
pub struct Concat {
    a: Var,
    b: Var,
    y: Var,
}

/// Y = A + B.
#[derive(Clone, Copy, Debug)]
pub struct Add {
    a: Var,
    b: Var,
    y: Var,
}

/// Y = the block of X that begins at (row, column).
#[derive(Clone, Copy, Debug)]
pub struct Slice {
    x: Var,
    y: Var,
    row: usize,
    column: usize,
}

impl<O: Operation + Copy + From<Concat> + From<Add> + From<Slice>> Recording<O> {
    /// The columns of `a`, then those of `b`; rows must agree.
    pub fn concat(&mut self, a: Var, b: Var) -> Var {
        debug_assert_eq!(a.rows, b.rows, "rows to put side by side");
        let y = self.output(a.rows, a.columns + b.columns, &[a, b]);
        self.push(Concat { a, b, y })
    }

    /// a + b, of one shape.
    pub fn add(&mut self, a: Var, b: Var) -> Var {
        debug_assert_eq!((a.rows, a.columns), (b.rows, b.columns), "terms of one shape");
        let y = self.output(a.rows, a.columns, &[a, b]);
        self.push(Add { a, b, y })
    }

    /// The block of `rows` x `columns` of `x` that begins at (`row`, `column`).
    pub fn slice(&mut self, x: Var, (row, column): (usize, usize), (rows, columns): (usize, usize)) -> Var {
        debug_assert!(row + rows <= x.rows && column + columns <= x.columns, "a block inside the matrix");
        let y = self.output(rows, columns, &[x]);
        self.push(Slice { x, y, row, column })
    }
}

impl Operation for Concat {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.a), Some(self.b), None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let rows = self.a.of(before).rows(self.a.columns).zip(self.b.of(before).rows(self.b.columns));
        for (y, (a, b)) in y.rows_mut(self.y.columns).zip(rows) {
            y[..a.len()].copy_from(a);
            y[a.len()..].copy_from(b);
        }
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        for (x, column) in [(self.a, 0), (self.b, self.a.columns)] {
            if x.has_gradient {
                let rows = x.of_mut(before).rows_mut(x.columns).zip(d_y.rows(self.y.columns));
                rows.for_each(|(d_x, d_y)| d_x.iter_mut().zip(&d_y[column..]).for_each(|(x, y)| *x += *y));
            }
        }
        Ok(())
    }
}

impl Operation for Add {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.a), Some(self.b), None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let terms = self.a.of(before).iter().zip(self.b.of(before));
        y.iter_mut().zip(terms).for_each(|(y, (a, b))| *y = *a + *b);
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        for x in [self.a, self.b].into_iter().filter(|x| x.has_gradient) {
            x.of_mut(before).iter_mut().zip(&*d_y).for_each(|(x, y)| *x += *y);
        }
        Ok(())
    }
}

impl Operation for Slice {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.x), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let rows = self.x.of(before).rows(self.x.columns).skip(self.row);
        let width = self.y.columns;
        y.rows_mut(width).zip(rows).for_each(|(y, x)| y.copy_from(&x[self.column..][..width]));
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let rows = self.x.of_mut(before).rows_mut(self.x.columns).skip(self.row);
        for (d_x, d_y) in rows.zip(d_y.rows(self.y.columns)) {
            d_x[self.column..].iter_mut().zip(d_y).for_each(|(x, y)| *x += *y);
        }
        Ok(())
    }
}
