//! The learned map: matrix products, a reverse-mode tape, four networks, their losses and the training loop.
pub mod adamw;
pub mod backbone;
mod batch;
pub mod chart_net;
pub mod evaluate;
pub mod fit;
pub mod kernels;
pub mod losses;
pub mod near;
pub mod run;
pub mod tape;
pub mod train;
mod train_tests;
pub mod training;
