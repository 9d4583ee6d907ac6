//! Test anatomy with a known answer.
