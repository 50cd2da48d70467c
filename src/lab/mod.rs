//! Experiments with the library: how well it estimates, and how its kernels agree with traced light. The rest of the
//! library does not use them.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`compare`] | a kernel against traced light: statistics of their disagreement |
//! | [`paper`] | the paper's experiments as numbers |
//! | [`study`] | error bars, failures and speed against accuracy, on planes whose medium is known |
//! | [`table`] | makes the table of the kernel [`wide_angle`](crate::spread::wide_angle) by tracing |

pub mod compare;
pub mod paper;
pub mod study;
pub mod table;
