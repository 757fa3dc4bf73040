//! What is asked, in the words of the command line.

pub mod line;
