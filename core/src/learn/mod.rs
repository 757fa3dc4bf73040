//! The learned map: matrix products, a reverse-mode tape, four networks, their losses and the training loop.
pub mod kernels;
pub mod near;
pub mod tape;
