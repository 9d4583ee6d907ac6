//! stub
use super::Column;
use crate::{centerline::Centerlines, error::Fault, network::Network, units::Scale};
use std::io::{self, Write};
pub fn read_vtp(_: &[u8], _: &Scale, _: Option<&str>) -> Result<(Centerlines, Vec<String>), Fault> {
    Err(Fault::file("x", "y"))
}
pub fn write_vtp(_: impl Write, _: &Network, _: &[Column]) -> io::Result<()> {
    Ok(())
}
