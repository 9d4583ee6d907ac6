//! Files of boundary conditions. The truth is the definition of the units: 1 mmHg = 133.322387415 Pa, 1 mL/min = 1e-6/60 m³/s.

use willis::error::Place;
use willis::internals::formats::tables::conditions::{Statement, read_csv, read_inlets, read_toml};
use willis::internals::network::quantity::Dimension::{Length, Pressure, Resistance, Viscosity};
use willis::internals::network::units::{metres, millimetres, mmhg, mmhg_s_per_ml, pascal_seconds_per_cubic_metre, pascals};
use willis::internals::network::{Condition, Role};

const MMHG: f64 = 133.322_387_415;

fn rows(text: &str) -> Vec<Statement> {
    read_csv(text.as_bytes()).unwrap_or_else(|fault| panic!("{text}: {fault:?}"))
}

/// The same conditions, however a spreadsheet parts and quotes them.
#[test]
fn a_table_is_read_as_other_tables_are() {
    let text = "# of one patient\nnode,kind,value,unit,venous_pressure_mmHg\n\n7,inlet,12,kPa,\n# a terminal\n\"a b\",resistance,2,mmHg·s/mL,5\n";
    let usual = rows(text);
    for other in [
        text.replace(',', ";"),
        text.replace(',', "\t"),
        format!("\u{feff}{}", text.replace('\n', "\r\n")),
        text.replace("kind", " Kind "),
    ] {
        assert_eq!(rows(&other), usual, "{other}");
    }
    assert_eq!(usual[0].condition, Condition::Pressure(12e3));
    assert_eq!((usual[0].place.clone(), usual[1].place.clone()), (Place::Line(4), Place::Line(6)));
    let Condition::Resistance { resistance, venous } = usual[1].condition else { panic!("{:?}", usual[1]) };
    assert!((resistance / (2e6 * MMHG) - 1.0).abs() < 1e-15 && (venous / (5.0 * MMHG) - 1.0).abs() < 1e-15);
    let toml = "[[condition]]\nnode = 7\nkind = \"inlet\"\nvalue = 12\nunit = \"kPa\"\n[[condition]]\nnode = \"a b\"\nkind = \"resistance\"\nvalue = 2\nunit = \"mmHg·s/mL\"\nvenous_pressure_mmHg = 5\n";
    let stated = |statements: Vec<Statement>| -> Vec<(String, Role, Condition)> {
        statements.into_iter().map(|s| (s.spec, s.role, s.condition)).collect()
    };
    assert_eq!(stated(read_toml(toml.as_bytes()).expect("TOML")), stated(usual));
    let flow = &rows("label,kind,value\nBA,flow,-60\n")[0];
    assert!(flow.role == Role::Outlet && flow.condition == Condition::Flow(-1e-6), "{flow:?}");
    let at = &rows("x_mm,y_mm,z_mm,kind\n1,-2.5,0.1,ground\n")[0];
    assert_eq!((at.spec.as_str(), at.condition), ("1,-2.5,0.1", Condition::Pressure(0.0)));
}

#[test]
fn what_is_wrong_names_its_line() {
    let kinds = "expected inlet, ground, pressure, resistance or flow";
    for (text, message) in [
        ("node,value\n1,90\n", "b:1: no column kind in columns node,value; expected the columns node,label,"),
        ("node,kind\n1,inlet\n2,\n", &format!("b:3: no kind; {kinds}")),
        ("node,kind\n1,outlet\n", &format!("b:2: kind \"outlet\"; {kinds}")),
        ("node,kind\n1,inlt\n", &format!("b:2: kind \"inlt\"; did you mean \"inlet\"? {kinds}")),
        ("node,kind,pressure\n1,inlet,9\n", "b:1: column \"pressure\"; expected the columns node,"),
        ("node,kind\n1,ground,3\n", "b:2: 3 columns; expected 2, as in the header"),
        ("node,kind,value\n\n1,pressure,\n", "b:3: pressure without a value; expected a number with a unit"),
        ("node,kind,value\n1,pressure,nan\n", "b:2: pressure without a value; expected a number with a unit"),
        ("node,kind,value\n1,pressure,inf\n", "b:2: value \"inf\"; expected a finite number"),
        ("node,kind,value\n1;pressure;5,5\n", "b:2: "),
        ("node;kind;value\n1;pressure;5,5\n", "b:2: value \"5,5\"; expected a decimal point, not a comma"),
        ("node,kind,value\n1,pressure,1e308\n", "b:2: pressure value 1e308; expected a number with a unit"),
        ("node,kind,value,unit\n1,pressure,5,mmhg\n", "b:2: pressure value 5mmhg; did you mean \"mmHg\"? expected a number"),
        ("node,kind,value\n1,resistance,-5\n", "b:2: resistance -"),
        ("node,label,kind\n1,a,ground\n", "b:2: no single node; expected one of node, label, or a position in mm"),
        ("x_mm,y_mm,z_mm,kind\n1,2,,ground\n", "b:2: no single node; "),
        ("node,x_mm,y_mm,z_mm,kind\n7,1,2,,ground\n", "b:2: no single node; "),
        ("node,kind,value\n1,ground,0\n2,ground,10\n", "b:3: ground with a value; expected none, or the kind pressure"),
        ("node,kind,value,venous_pressure_mmHg\n1,inlet,90,0\n2,pressure,9,5\n", "b:3: pressure with a venous_pressure_mmHg; "),
        ("node,kind,value,venous_pressure_mmHg\n1,resistence,9,5\n", "b:2: kind \"resistence\"; did you mean \"resistance\"? "),
    ] {
        let said = read_csv(text.as_bytes()).expect_err(text).in_file("b".as_ref()).to_string();
        assert!(said.starts_with(message), "{said}, expected {message}");
    }
    let said = read_toml(b"[[condition]]\nnode = 1\n").expect_err("no kind").in_file("b".as_ref()).to_string();
    assert_eq!(said, format!("b: condition 1: no kind; {kinds}"));
}

/// A table of nothing but inlets needs no word for each.
#[test]
fn inlets_need_no_kind() {
    let inlets = |text: &str| read_inlets(text.as_bytes()).expect("inlets").into_iter().map(|s| s.spec).collect::<Vec<_>>();
    assert_eq!(inlets("x_mm;y_mm;z_mm\n1;2;3\n"), ["1,2,3"]);
    assert_eq!(inlets("node,kind\n1,inlet\n2,ground\n3,\n"), ["1", "3"]);
}

#[test]
fn figures_with_and_without_units() {
    assert_eq!(Length.parse("12"), Ok(0.012));
    assert_eq!(Length.parse("1.2e1 mm"), Ok(0.012));
    assert_eq!(Pressure.parse("13.3kPa"), Ok(13300.0));
    assert_eq!(Pressure.parse("1e3Pa"), Ok(1000.0));
    assert_eq!(Viscosity.parse("3.5cP"), Ok(0.0035));
    assert!(Resistance.has_unit_in("2.5mmHg.s/mL") && !Resistance.has_unit_in("2.5mmHg"));
}

#[test]
fn a_unit_mistyped_is_offered_rightly_typed() {
    assert!(Pressure.parse("90mmhg").is_err_and(|e| e.starts_with("did you mean \"mmHg\"? expected ")));
    assert_eq!(Resistance.near("20mmHg.s/ml"), "did you mean \"mmHg.s/mL\"? ");
    assert_eq!(Pressure.near("90 furlongs") + &Length.near("mm"), "");
}

#[test]
fn other_text_is_refused() {
    for text in ["", "mm", "12mmhg", "nan", "inf", "1,5", "12 furlongs"] {
        assert!(Length.parse(text).is_err(), "{text}");
    }
}

#[test]
fn a_figure_written_and_read_again_is_the_same_to_the_last_bit() {
    let mut x = 1e-9_f64;
    for _ in 0..20_000 {
        x *= 1.001_234_567;
        assert_eq!(metres(millimetres(metres(x))).to_bits(), metres(x).to_bits());
        assert_eq!(pascals(mmhg(pascals(x))).to_bits(), pascals(x).to_bits());
        let r = pascal_seconds_per_cubic_metre(x);
        assert_eq!(pascal_seconds_per_cubic_metre(mmhg_s_per_ml(r)).to_bits(), r.to_bits());
    }
}
