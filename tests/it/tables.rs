//! The tables of cases, by exhaustion.
