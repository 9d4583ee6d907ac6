//! Formats that are known but not read: the error names each, and what to export instead.

use std::path::Path;

use crate::peers::{converted, document};
use willis::internals::formats::convert::Target;
use willis::internals::network::units::pascals;
use willis::internals::network::{Condition, Network, Node, Origin, Vessel};

#[test]
fn each_is_named_with_what_to_export_instead() {
    let dicom = |class: &str| [vec![0; 128], b"DICM\x02\x00".to_vec(), class.as_bytes().to_vec()].concat();
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        (
            "a.dcm",
            dicom("1.2.840.10008.5.1.4.1.1.66.4"),
            "a segmentation in DICOM (DICOM SEG); expected a mask in NIfTI or NRRD: export it with 3D Slicer",
        ),
        ("no-ending", dicom("1.2.840.10008.5.1.4.1.1.4"), "a file of DICOM; expected a mask in NIfTI or NRRD"),
        ("one.mnc", b"CDF\x01\0\0\0\0".to_vec(), "a volume in MINC; expected NIfTI: convert it with mnc2nii"),
        ("two.mnc", b"\x89HDF\r\n\x1a\n minc-2.0".to_vec(), "a volume in MINC; expected NIfTI"),
        (
            "aorta.pth",
            b"<?xml version=\"1.0\" encoding=\"UTF-8\" ?>\n<format version=\"1.0\" />\n<path id=\"1\" method=\"0\">".to_vec(),
            "a path of SimVascular (.pth), which has no radii; expected centerlines: extract those of the model in SimVascular",
        ),
        (
            "aorta.ctgr",
            b"<?xml version=\"1.0\" encoding=\"UTF-8\" ?>\n<format version=\"1.0\" />\n<contourgroup path_name=\"aorta\">"
                .to_vec(),
            "contours of SimVascular (.ctgr); expected centerlines",
        ),
        ("a.mgz", b"\0\0\0\x01\0\0\0\x04".to_vec(), "a volume of FreeSurfer (.mgz); expected NIfTI: convert it with mri_convert"),
        ("a.gt", "⛾ gt\x01\x00".as_bytes().to_vec(), "a graph of graph-tool (.gt); expected GraphML: save it with graph.save("),
    ];
    for (name, bytes, wanted) in cases {
        let said = document(name, &bytes).map(|_| ()).expect_err(name);
        assert!(said.starts_with(&format!("{name}: {wanted}")), "{said}");
    }
}

#[test]
fn a_model_that_willis_wrote_for_a_solver_is_named() {
    let mut network = Network::new();
    for (id, condition) in [("a", pascals(93.0)), ("b", 0.0)] {
        network.add_node(Node { id: id.into(), condition: Some(Condition::Pressure(condition)), ..Node::default() });
    }
    network.add_vessel([0, 1], Vessel::new(0.01, 1e-3, Origin::Observed));
    for (name, word, called) in [("a.json", "svzerod", "svZeroDSolver JSON"), ("a.yaml", "openbf", "openBF YAML")] {
        let (path, bytes) = converted(&network, &Target::new(Path::new(name), Some(word)).expect("a target")).remove(0);
        let said = document(&path.display().to_string(), &bytes).map(|_| ()).expect_err("a model");
        assert!(said.starts_with(&format!("{name}: {called}, which is only written; expected SWC")), "{said}");
    }
}
