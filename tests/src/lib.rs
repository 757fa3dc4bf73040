//! Shared helpers of the test suites.

pub mod plain_obj;
