//! `willis classify`: the phenotype of a Circle of Willis whose topology is taken as it stands.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use willis::centerline::WELD_TOLERANCE;
use willis::error::{Fault, Result};
use willis::formats::{Content, ReadOptions, bytes_of, checksum, read};
use willis::network::Network;
use willis::phenotype::{Circle, Scheme, counted, divide, read_landmarks};
use willis::report::{Classified, StagedFolder, classification_record, phenotype_json, write_classified};

use super::input::{InputArgs, Loaded};
use super::shell::print_json;
use super::terminal::{Terminal, plural};

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Labels {
    /// Names of arteries, as L-A1, "A1 left", ACoA
    Names,
    /// The numbers of iCafe's VesselType
    Icafe,
    /// The numbers of the TopCoW challenge
    Topcow,
}

/// Name the anatomical variant of a Circle of Willis
///
/// The vessels of INPUT are taken as they are. Where each artery is, is said by their labels, or by the in- and outlets in a file of
/// landmarks. A segment is present when it connects what it should.
#[derive(Debug, Args)]
pub struct ClassifyArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The folder to write; it must not exist
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// Where arteries enter and leave, in the place of labels: a CSV file of label,x_mm,y_mm,z_mm in the unit of INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    landmarks: Option<PathBuf>,
    /// What the labels are [default: names; numbers where only one list has them]
    #[arg(long, value_enum, conflicts_with = "landmarks")]
    labels: Option<Labels>,
    /// Print phenotype.json on standard output too
    #[arg(long)]
    json: bool,
}

/// Where the arteries are, and how that is known.
struct Found {
    network: Network,
    circle: Circle,
    known_by: &'static str,
    /// Path and SHA-256.
    landmarks: Option<(String, String)>,
    notes: Vec<String>,
}

impl ClassifyArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        self.input.refuse_candidates("classify")?;
        StagedFolder::check(&self.output, force)?;
        let loaded = self.input.load(terminal)?;
        let provenance = loaded.provenance.clone();
        let (path, fragments) = (self.input.input.clone(), loaded.fragments);
        let mut found = match &self.landmarks {
            Some(file) => self.by_landmarks(file, loaded)?,
            None => self.by_labels(loaded)?,
        };
        let (kept, note) =
            if fragments { (vec![true; found.network.vessel_count()], None) } else { counted(&found.network, &bytes_of(&path)?) };
        found.notes.extend(note);
        for note in &found.notes {
            terminal.say("note", note);
        }
        let variant = found.circle.variant(&found.network, |row| kept[row]);
        let classified = Classified {
            network: &found.network,
            counted: kept.iter().filter(|kept| **kept).count(),
            variant: &variant,
            known_by: found.known_by,
            landmarks: found.landmarks.as_ref().map(|(path, sha256)| (path.as_str(), sha256.as_str())),
            notes: &found.notes,
        };
        terminal.say("counted", format!("{}, arteries by {}", plural(classified.counted, "vessel"), found.known_by));
        terminal.say("variant", format!("{} ({})", variant.name(), variant.completeness().name()));
        terminal.say("anatomy", variant.words());
        let subject = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let folder = StagedFolder::new(&self.output, force)?;
        write_classified(&folder.path(), &subject, &variant, &classification_record(&classified, &provenance))?;
        folder.commit()?;
        if self.json {
            print_json(&phenotype_json(&variant))?;
        }
        terminal.say("written", self.output.display().to_string());
        Ok(())
    }

    fn by_landmarks(&self, file: &Path, loaded: Loaded) -> Result<Found> {
        let bytes = bytes_of(file)?;
        let text = std::str::from_utf8(&bytes)
            .map_err(|_| Fault::file("the text is not UTF-8", "expected a CSV file of label,x_mm,y_mm,z_mm").in_file(file))?;
        let landmarks = read_landmarks(text, &self.input.scale()?).map_err(|fault| fault.in_file(file))?;
        let (circle, notes) = Circle::at(&loaded.network, &landmarks).map_err(|fault| fault.in_file(file))?;
        let landmarks = Some((file.display().to_string(), checksum(&bytes)));
        Ok(Found { network: loaded.network, circle, known_by: "landmarks", landmarks, notes })
    }

    fn by_labels(&self, loaded: Loaded) -> Result<Found> {
        let path = &self.input.input;
        let network = self.divided(loaded)?;
        let scheme = match self.labels {
            Some(Labels::Names) => Scheme::Names,
            Some(Labels::Icafe) => Scheme::ICafe,
            Some(Labels::Topcow) => Scheme::TopCow,
            None => {
                let labels = network.vessels().map(|(_, vessel)| vessel.label.as_str());
                Scheme::of(labels).map_err(|fault| fault.in_file(path))?
            }
        };
        let (circle, notes) = Circle::labelled(&network, scheme).map_err(|fault| fault.in_file(path))?;
        Ok(Found { network, circle, known_by: scheme.name(), landmarks: None, notes })
    }

    /// The network with its vessels divided where their labels change, for which centerlines are read once more.
    fn divided(&self, loaded: Loaded) -> Result<Network> {
        let options = ReadOptions { scale: self.input.scale()?, radius_optional: true, ..ReadOptions::default() };
        Ok(match read(&self.input.input, &options)?.content {
            Content::Centerlines(mut lines) => {
                lines.weld(WELD_TOLERANCE);
                divide(&loaded.network, &lines, loaded.radius_rule)
            }
            Content::Vessels(_) | Content::Graph(_) => loaded.network,
        })
    }
}
