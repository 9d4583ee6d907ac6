//! The arrays of a legacy file: attributes of points and cells, and fields.

use super::cursor::{Kind, unescape};
use super::read::{Group, Reader, TYPES};
use crate::error::Fault;
use crate::io::vtk::polydata::{Array, LIMIT, Values, is_wanted};

const SECTIONS: &str = "expected POINTS, VERTICES, LINES, POLYGONS, TRIANGLE_STRIPS, POINT_DATA, CELL_DATA or an array";

impl Reader<'_> {
    /// An array of the points or cells, or of the whole file.
    pub(crate) fn attribute(&mut self, keyword: &str) -> Result<(), Fault> {
        let known = [
            "FIELD",
            "SCALARS",
            "COLOR_SCALARS",
            "LOOKUP_TABLE",
            "VECTORS",
            "NORMALS",
            "TENSORS",
            "TENSORS6",
            "TEXTURE_COORDINATES",
            "GLOBAL_IDS",
            "PEDIGREE_IDS",
            "EDGE_FLAGS",
        ];
        if !known.contains(&keyword) {
            "keyword".clone_into(&mut self.cursor.section);
            return Err(self.cursor.fault(format!("\"{}\"", keyword.escape_debug()), SECTIONS));
        }
        let name = unescape(self.cursor.need("a name")?);
        let rows = self.group.map_or(0, |(_, count)| count);
        self.cursor.section = format!("{keyword} \"{name}\"");
        match keyword {
            "FIELD" => {
                let arrays = self.cursor.count("a number of arrays", LIMIT)?;
                for _ in 0..arrays {
                    while self.cursor.is_next("METADATA") {
                        self.cursor.word();
                        self.section("METADATA")?;
                    }
                    self.field()?;
                }
                Ok(())
            }
            "COLOR_SCALARS" => {
                let width = self.cursor.count("a number of components", LIMIT)?;
                self.cursor.numbers(Kind::BYTE, rows.saturating_mul(width)).map(drop)
            }
            "LOOKUP_TABLE" => {
                let size = self.cursor.count("a size", LIMIT)?;
                self.cursor.numbers(if self.cursor.binary { Kind::BYTE } else { Kind::REAL }, 4 * size).map(drop)
            }
            "SCALARS" => {
                let kind = self.cursor.need("a type")?;
                let width = self.cursor.line().unwrap_or_default();
                let width = match width.trim() {
                    "" => 1,
                    text => text.parse().map_err(|_| self.cursor.fault(format!("\"{text}\""), "expected 1 to 4 components"))?,
                };
                let table = self.cursor.need("LOOKUP_TABLE")?;
                if !table.eq_ignore_ascii_case("LOOKUP_TABLE") {
                    return Err(self.cursor.fault(format!("\"{}\"", table.escape_debug()), "expected LOOKUP_TABLE"));
                }
                self.cursor.need("a name")?;
                self.values(&name, kind, width, rows)
            }
            _ => {
                let width = match keyword {
                    "VECTORS" | "NORMALS" => 3,
                    "TENSORS" => 9,
                    "TENSORS6" => 6,
                    "TEXTURE_COORDINATES" => self.cursor.count("a dimension", 3)?,
                    _ => 1,
                };
                let kind = self.cursor.need("a type")?;
                self.values(&name, kind, width, rows)
            }
        }
    }

    /// One array of a field, which says its own size.
    fn field(&mut self) -> Result<(), Fault> {
        let name = unescape(self.cursor.need("the name of an array")?);
        if name == "NULL_ARRAY" {
            return Ok(());
        }
        self.cursor.section = format!("array \"{name}\"");
        let width = self.cursor.count("a number of components", LIMIT)?;
        let rows = self.cursor.count("a number of values", LIMIT)?;
        let kind = self.cursor.need("a type")?;
        if let Some((_, expected)) = self.group.filter(|(_, expected)| *expected != rows && is_wanted(name.trim(), self.choice)) {
            return Err(self.cursor.fault(format!("{rows} values"), format!("expected {expected}")));
        }
        self.values(&name, kind, width, rows)
    }

    fn values(&mut self, name: &str, kind: &str, width: usize, rows: usize) -> Result<(), Fault> {
        let count = rows.saturating_mul(width);
        let values = if ["string", "utf8_string"].iter().any(|text| kind.eq_ignore_ascii_case(text)) {
            Values::Texts(self.cursor.texts(count)?)
        } else {
            let kind = Kind::named(kind).ok_or_else(|| self.cursor.fault(format!("type \"{kind}\""), TYPES))?;
            Values::Numbers(self.cursor.numbers(kind, count)?)
        };
        let name = name.trim().to_owned();
        let values = if width == 1 && is_wanted(&name, self.choice) { values } else { Values::Unread };
        match self.group {
            Some((Group::Points, _)) => self.data.point_data.push(Array { name, values }),
            Some((Group::Cells, _)) => self.data.line_data.push(Array { name, values }),
            None => {}
        }
        Ok(())
    }
}
