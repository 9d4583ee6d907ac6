//! What a BIDS dataset holds: its participants, and the mask of the vessels of each of their sessions.

use std::{collections::BTreeSet, fs, path::Path, path::PathBuf};

use crate::internals::formats::{Covariates, is_there, open_regular, read_participants, regular_bytes_of};
use crate::internals::support::distinct;
use crate::{Error, Result, cli::print::listed, error::Fault, internals::output::read_json, internals::pipeline::require_in};

/// The file that describes a dataset.
pub const DESCRIPTION: &str = "dataset_description.json";
/// What is known of each participant, and what its columns are.
pub const PARTICIPANTS: &str = "participants.tsv";
pub const PARTICIPANTS_COLUMNS: &str = "participants.json";
/// The suffixes of masks.
const SUFFIXES: [&str; 2] = ["mask", "dseg"];
/// The suffix of an angiogram.
const ANGIOGRAM: &str = "angio";
/// The entities that say what a mask is of.
const WHAT: [&str; 4] = ["desc", "label", "seg", "atlas"];
/// Parts of the words that mean vessels there, in small letters.
const VESSELS: [&str; 7] = ["vessel", "arter", "vasc", "lumen", "angio", "cow", "circleofwillis"];
/// The most names that an error lists.
pub const MOST: usize = 6;

/// `--filter KEY=VALUE`: what the name of a mask must have; without a value, what it must not have.
#[derive(Debug, Clone, PartialEq)]
pub struct Filter {
    /// The entity.
    pub key: String,
    /// Its value; empty where the entity must be missing.
    pub value: String,
}

/// The filter that a word means.
///
/// # Errors
///
/// What is accepted, where the word is none.
pub fn parse_filter(text: &str) -> Result<Filter, String> {
    let is_word = |word: &str| word.chars().all(|c| c.is_ascii_alphanumeric() || "+-_.".contains(c));
    match text.split_once('=') {
        Some((key, value)) if !key.is_empty() && is_word(key) && is_word(value) => {
            Ok(Filter { key: key.to_owned(), value: value.to_owned() })
        }
        _ => Err("expected an entity and its value, such as desc=vessels".into()),
    }
}

/// Which masks a person asks for.
#[derive(Debug, clap::Args)]
pub struct Choice {
    /// Only these participants, with or without sub-
    #[arg(long, alias = "participant_label", value_name = "LABEL", num_args = 1.., value_delimiter = ',', help_heading = "Dataset")]
    participant_label: Vec<String>,
    /// Only these sessions, with or without ses-
    #[arg(long, alias = "session_label", value_name = "LABEL", num_args = 1.., value_delimiter = ',', help_heading = "Dataset")]
    session_label: Vec<String>,
    /// Only masks with this in their names: an entity (desc=vessels, run=1; space= is none), suffix=dseg, or pipeline=NAME of a folder
    /// in derivatives; with desc, label, seg or atlas the mask need not say vessels
    #[arg(long, value_name = "KEY=VALUE", value_delimiter = ',', value_parser = parse_filter, help_heading = "Dataset")]
    filter: Vec<Filter>,
    /// Taken as other BIDS apps take it: no validator runs
    #[arg(long = "skip-bids-validator", alias = "skip_bids_validator", help_heading = "Dataset")]
    _skip_bids_validator: bool,
}

impl Choice {
    /// The labels of participants and of sessions as folders have them; all where there is none.
    pub fn labels(&self) -> (Vec<String>, Vec<String>) {
        let labels = |given: &[String], prefix: &str| {
            given.iter().map(|label| format!("{prefix}{}", label.strip_prefix(prefix).unwrap_or(label))).collect()
        };
        (labels(&self.participant_label, "sub-"), labels(&self.session_label, "ses-"))
    }
}

/// An image by its name.
#[derive(Debug, Clone, PartialEq)]
pub struct BidsName {
    /// The entities in order, each with its value.
    entities: Vec<(String, String)>,
    /// What it is: `mask`, `dseg`.
    pub suffix: String,
}

impl BidsName {
    /// The name of an image of NIfTI; `None` for another file.
    pub fn parse(name: &str) -> Option<Self> {
        let stem = name.strip_suffix(".nii.gz").or_else(|| name.strip_suffix(".nii"))?;
        let (entities, suffix) = stem.rsplit_once('_')?;
        let entity = |part: &str| part.split_once('-').map(|(key, value)| (key.to_owned(), value.to_owned()));
        let entities = entities.split('_').map(entity).collect::<Option<Vec<_>>>()?;
        Some(Self { entities, suffix: suffix.to_owned() })
    }

    /// The value of an entity.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.entities.iter().find(|(own, _)| own == key).map(|(_, value)| value.as_str())
    }

    /// Whether it says that it is of vessels.
    pub fn says_vessels(&self) -> bool {
        let is_word = |value: &str| VESSELS.iter().any(|word| value.to_lowercase().contains(word));
        WHAT.iter().filter_map(|key| self.value(key)).any(is_word)
    }
}

/// A mask of the vessels of one participant, in one session where there are sessions.
#[derive(Debug, Clone)]
pub struct DatasetMask {
    /// With `sub-`.
    pub participant: String,
    /// With `ses-`.
    pub session: Option<String>,
    pub path: PathBuf,
    named: BidsName,
    /// The name of the folder in `derivatives`, empty for the dataset itself.
    pipeline: String,
}

impl DatasetMask {
    /// The name of its run: `sub-01` or `sub-01_ses-a`.
    pub fn run(&self) -> String {
        let (participant, session) = (&self.participant, self.session.as_ref());
        session.map_or_else(|| participant.clone(), |session| format!("{participant}_{session}"))
    }

    /// The beginning of the names of files that are made of it: its entities without those that say what it is of.
    pub fn entities(&self) -> String {
        let kept = self.named.entities.iter().filter(|(key, _)| key != "desc");
        kept.map(|(key, value)| format!("{key}-{value}")).collect::<Vec<_>>().join("_")
    }

    fn value(&self, key: &str) -> &str {
        match key {
            "suffix" => &self.named.suffix,
            "pipeline" => &self.pipeline,
            key => self.named.value(key).unwrap_or_default(),
        }
    }
}

/// A dataset and those of its derivatives.
pub struct Dataset {
    root: PathBuf,
    /// The folder of each dataset to look into, with the name of its pipeline; the dataset itself first.
    folders: Vec<(PathBuf, String)>,
    /// With `sub-`.
    pub participants: BTreeSet<String>,
}

impl Dataset {
    /// The dataset in a folder, with what is in its `derivatives`; `output` and other datasets of willis are left out.
    ///
    /// # Errors
    ///
    /// A folder that holds no participant.
    pub fn open(root: &Path, output: &Path) -> Result<Self> {
        require_in(root, root.is_dir(), "no such folder", "expected a BIDS dataset")?;
        let below = root.join("derivatives");
        let mut folders = vec![(root.to_owned(), String::new())];
        folders.extend(children(&below, "").into_iter().map(|name| (below.join(&name), name)));
        let output = fs::canonicalize(output).ok();
        let is_other = |folder: &Path| output.is_none() || fs::canonicalize(folder).ok() != output;
        folders.retain(|(folder, _)| is_other(folder));
        for description in folders.iter().map(|(folder, _)| folder.join(DESCRIPTION)).filter(|path| is_there(path)) {
            // One that cannot be read may say that the dataset is of willis.
            open_regular(&description)?;
        }
        folders.retain(|(folder, _)| !is_of_willis(folder));
        let participants: BTreeSet<String> = folders.iter().flat_map(|(folder, _)| children(folder, "sub-")).collect();
        let accepted = "expected folders sub-LABEL in it or in its derivatives/*, as in a BIDS dataset";
        require_in(root, !participants.is_empty(), "no participant", accepted)?;
        Ok(Self { root: root.to_owned(), folders, participants })
    }

    /// What `participants.tsv` says of each participant; none without that file.
    ///
    /// # Errors
    ///
    /// A file that is there and cannot be read, or is none of participants.
    pub fn covariates(&self) -> Result<Vec<(String, Covariates)>> {
        let Some(bytes) = self.file(PARTICIPANTS)? else { return Ok(Vec::new()) };
        read_participants(&bytes).map_err(|fault| fault.in_file(&self.root.join(PARTICIPANTS)))
    }

    /// The bytes of a file at the top, where there is one.
    pub fn file(&self, name: &str) -> Result<Option<Vec<u8>>> {
        let path = self.root.join(name);
        is_there(&path).then(|| regular_bytes_of(&path)).transpose()
    }

    /// One mask for each session of the participants that are chosen, and the participants without a mask.
    ///
    /// # Errors
    ///
    /// A label that none has, no mask at all, a chosen participant without a mask, several masks of one session.
    pub fn masks(&self, choice: &Choice) -> Result<(Vec<DatasetMask>, Vec<String>)> {
        let (asked, sessions) = choice.labels();
        check_labels("participant_label", &asked, &self.participants)?;
        let chosen: Vec<&String> = self.participants.iter().filter(|name| asked.is_empty() || asked.contains(name)).collect();
        let all: Vec<DatasetMask> = chosen.iter().flat_map(|participant| self.masks_of(participant, choice)).collect();
        let known: BTreeSet<String> = chosen.iter().flat_map(|participant| self.sessions(participant)).flatten().collect();
        check_labels("session_label", &sessions, &known)?;
        let is_asked = |of: &&DatasetMask| sessions.is_empty() || of.session.as_ref().is_some_and(|name| sessions.contains(name));
        let all: Vec<DatasetMask> = all.iter().filter(is_asked).cloned().collect();
        let (mut masks, mut without) = (Vec::new(), Vec::new());
        for participant in chosen {
            let of: Vec<&DatasetMask> = all.iter().filter(|mask| mask.participant == *participant).collect();
            let own: BTreeSet<Option<&String>> = of.iter().map(|mask| mask.session.as_ref()).collect();
            let before = masks.len();
            for session in own {
                let could_be = of.iter().copied().filter(|mask| mask.session.as_ref() == session).collect();
                masks.extend(self.one(could_be, choice)?);
            }
            without.extend((masks.len() == before).then(|| participant.clone()));
        }
        let is_missed = !asked.is_empty() && sessions.is_empty() && !without.is_empty();
        if is_missed || masks.is_empty() { Err(self.none(&without, &all)) } else { Ok((masks, without)) }
    }

    /// The one mask of vessels among those of a session; `None` where none is one.
    fn one(&self, of_session: Vec<&DatasetMask>, choice: &Choice) -> Result<Option<DatasetMask>> {
        let is_named = choice.filter.iter().any(|filter| WHAT.contains(&filter.key.as_str()));
        let mut meant = of_session.clone();
        if !is_named {
            meant.retain(|mask| mask.named.says_vessels());
            if meant.is_empty() {
                meant = of_session;
                let says_what = |name: &BidsName| WHAT.iter().any(|key| name.value(key).is_some());
                meant.retain(|mask| !says_what(&mask.named) && self.is_of_angiogram(mask));
            }
        }
        match meant[..] {
            [] => Ok(None),
            [one] => Ok(Some(one.clone())),
            [first, second, ..] => {
                let keys = first.named.entities.iter().chain(&second.named.entities).map(|(key, _)| key.as_str());
                let keys = keys.chain(["suffix", "pipeline"]);
                let way = keys.into_iter().find(|key| first.value(key) != second.value(key)).map_or_else(
                    || "keep one of them".to_owned(),
                    |key| format!("choose with --filter, such as --filter {key}={}", first.value(key)),
                );
                let names = listed(meant.iter().map(|mask| self.shown(&mask.path)), MOST);
                let found = format!("{} masks could be meant for {}: {names}", meant.len(), first.run());
                Err(Fault::file(found, way).in_file(&self.root))
            }
        }
    }

    /// The masks of a participant that fit the filters.
    fn masks_of(&self, participant: &str, choice: &Choice) -> Vec<DatasetMask> {
        let mut masks = Vec::new();
        let suffix = choice.filter.iter().find(|filter| filter.key == "suffix").map(|filter| filter.value.as_str());
        for (folder, pipeline) in &self.folders {
            for session in sessions_in(&folder.join(participant)) {
                for (path, named) in images(&anatomy(folder, participant, session.as_deref())) {
                    let fits = suffix.map_or_else(|| SUFFIXES.contains(&named.suffix.as_str()), |suffix| named.suffix == suffix);
                    let (participant, pipeline) = (participant.to_owned(), pipeline.clone());
                    let mask = DatasetMask { participant, session: session.clone(), path, named, pipeline };
                    if fits && choice.filter.iter().all(|filter| mask.value(&filter.key) == filter.value) {
                        masks.push(mask);
                    }
                }
            }
        }
        masks
    }

    /// Whether the dataset itself has an angiogram with the entities of a mask, and no other image with them.
    fn is_of_angiogram(&self, mask: &DatasetMask) -> bool {
        let folder = anatomy(&self.root, &mask.participant, mask.session.as_deref());
        let is_alike = |of: &BidsName| of.entities == mask.named.entities && !SUFFIXES.contains(&of.suffix.as_str());
        let mut alike = images(&folder).into_iter().map(|(_, named)| named).filter(is_alike);
        alike.next().is_some_and(|named| named.suffix == ANGIOGRAM) && alike.next().is_none()
    }

    /// The sessions of a participant; one without a name where a folder has none.
    fn sessions(&self, participant: &str) -> BTreeSet<Option<String>> {
        self.folders.iter().flat_map(|(folder, _)| sessions_in(&folder.join(participant))).collect()
    }

    /// That participants have no mask of vessels; `others` are masks that do not say so.
    fn none(&self, of: &[String], others: &[DatasetMask]) -> Error {
        let some = (of.len() < self.participants.len()).then(|| format!(" of {}", listed(of.iter().cloned(), MOST)));
        let whose = some.unwrap_or_default();
        let others: Vec<&DatasetMask> = others.iter().filter(|mask| of.contains(&mask.participant)).collect();
        let found = format!("no mask of vessels{whose}");
        let accepted = match others.first() {
            None => "expected sub-*/[ses-*/]anat/*_mask.nii.gz or *_dseg.nii.gz in it or in its derivatives/*".to_owned(),
            Some(first) => {
                let names = listed(others.iter().map(|mask| self.shown(&mask.path)), MOST);
                let what = WHAT.iter().find(|key| first.named.value(key).is_some()).unwrap_or(&"desc");
                let key = format!("--filter {what}={}", first.value(what));
                format!("{names} does not say so in desc or label; if it is one, give {key}")
            }
        };
        Fault::file(found, accepted).in_file(&self.root)
    }

    /// A path seen from the dataset.
    pub fn shown(&self, path: &Path) -> String {
        path.strip_prefix(&self.root).unwrap_or(path).display().to_string().replace('\\', "/")
    }

    /// In which places masks are, for people: `derivatives/nnunet: desc-vessels_mask`.
    pub fn places(masks: &[DatasetMask]) -> String {
        let place = |mask: &DatasetMask| {
            let folder = if mask.pipeline.is_empty() { "BIDS_DIR".to_owned() } else { format!("derivatives/{}", mask.pipeline) };
            let what = WHAT.iter().filter_map(|key| mask.named.value(key).map(|value| format!("{key}-{value}_")));
            format!("{folder}: {}{}", what.collect::<String>(), mask.named.suffix)
        };
        listed(masks.iter().map(place).collect::<BTreeSet<_>>().into_iter(), MOST)
    }

    /// What the dataset calls itself.
    pub fn name(&self) -> Option<String> {
        let record: serde_json::Value = read_json(&self.root.join(DESCRIPTION), "").ok()?;
        record["Name"].as_str().map(str::to_owned)
    }

    /// Where one of its files lies: a path in it, or with its name alone where it lies elsewhere.
    pub fn place_of(&self, file: &Path) -> String {
        let inside = fs::canonicalize(file).ok().zip(fs::canonicalize(&self.root).ok());
        let inside = inside.and_then(|(file, root)| file.strip_prefix(root).ok().map(|path| path.display().to_string()));
        inside.unwrap_or_else(|| self.shown(file)).replace('\\', "/")
    }
}

/// Whether willis made the dataset in a folder.
pub fn is_of_willis(folder: &Path) -> bool {
    let record: Result<serde_json::Value> = read_json(&folder.join(DESCRIPTION), "");
    let makers = record.ok().and_then(|record| record["GeneratedBy"].as_array().cloned()).unwrap_or_default();
    makers.iter().any(|maker| maker["Name"] == "willis")
}

/// Refuses a label that none has.
pub fn check_labels(field: &str, asked: &[String], known: &BTreeSet<String>) -> Result<()> {
    let Some(unknown) = asked.iter().find(|label| !known.contains(*label)) else { return Ok(()) };
    let there = if known.is_empty() { "is none".to_owned() } else { format!("are {}", listed(known.iter().cloned(), MOST)) };
    Err(Error::parameter(field, unknown, format!("no such folder; there {there}")))
}

/// The folders in a folder that begin with some letters, by name; hidden ones are left out.
fn children(folder: &Path, prefix: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().filter(|entry| entry.path().is_dir());
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    distinct(names.filter(|name| !name.starts_with('.') && name.strip_prefix(prefix).is_some_and(|rest| !rest.is_empty())))
}

/// The sessions in the folder of a participant, and none for images outside any.
fn sessions_in(participant: &Path) -> Vec<Option<String>> {
    let sessions = children(participant, "ses-").into_iter().map(Some);
    let outside = participant.join("anat").is_dir().then_some(None);
    outside.into_iter().chain(sessions).collect()
}

/// The folder of a session's anatomical images.
pub fn anatomy(dataset: &Path, participant: &str, session: Option<&str>) -> PathBuf {
    let folder = dataset.join(participant);
    session.map_or_else(|| folder.clone(), |session| folder.join(session)).join("anat")
}

/// The images in a folder, by name.
fn images(folder: &Path) -> Vec<(PathBuf, BidsName)> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let named = |path: PathBuf| BidsName::parse(path.file_name()?.to_str()?).map(|named| (path, named));
    let mut images: Vec<_> = entries.filter_map(|entry| named(entry.path())).collect();
    images.sort_by(|a, b| a.0.cmp(&b.0));
    images
}
