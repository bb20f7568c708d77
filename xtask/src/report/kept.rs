//! Results that are kept: the tables of finished experiments, by adapter, with an index over all of them.
//!
//! `<folder>/<adapter>/<id>/{data.json,table.txt}`, `<folder>/index.json` and, for people, `<folder>/README.md`. Pictures
//! and plots are not kept: the command that is written down makes them again.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::Value;

use super::data::{Adapter, Experiment};
use super::headline;
use super::section::{Section, Tally};
use super::table::{Column, Table};
use crate::failure::{Failure, Outcome};
use crate::output_file::{self, Staged};

/// The folder for results that are kept.
#[derive(Debug)]
pub(crate) struct Kept {
    folder: PathBuf,
}

/// What the index says of an experiment.
#[derive(Debug, Serialize)]
struct Entry<'a> {
    id: &'a str,
    folder: String,
    adapter: &'a Adapter,
    source: &'a str,
    preset: &'a str,
    command: Option<&'a str>,
    git: &'a str,
    claims: usize,
    hold: usize,
}

impl Kept {
    /// Makes the folder.
    ///
    /// Fails if it cannot be made, and for results in it that cannot be read: neither is found out after hours.
    pub(crate) fn open(folder: &Path) -> Outcome<Self> {
        let made = fs::create_dir_all(folder);
        made.map_err(|e| Failure::input(format!("--keep {}: cannot be made: {e}", folder.display())))?;
        let kept = Self { folder: folder.to_owned() };
        output_file::check_writable(&folder.join("index.json"))?;
        kept.read().map(|_| kept)
    }

    /// Adds the tables of `sections`, in place of older ones of the same experiments on the same adapters.
    ///
    /// Everything is written beside its place before the first file takes its name.
    pub(crate) fn add(&self, sections: &[Section]) -> Outcome {
        let mut all = self.read()?;
        let mut staged: Vec<Staged> = Vec::new();
        for section in sections {
            // a link to a file that is not kept would lead nowhere
            let experiment =
                Experiment { pictures: Vec::new(), plots: Vec::new(), ..section.experiment.clone() };
            let folder = self.folder.join(place(&experiment));
            fs::create_dir_all(&folder)
                .map_err(|e| Failure::input(format!("--keep {}: cannot be made: {e}", folder.display())))?;
            staged.push(output_file::stage(&folder.join("data.json"), lines(&experiment)?.as_bytes())?);
            staged.push(output_file::stage(&folder.join("table.txt"), section.text().as_bytes())?);
            all.retain(|other| place(other) != place(&experiment));
            all.push(experiment);
        }
        all.sort_by_key(place);
        staged.push(output_file::stage(&self.folder.join("index.json"), index(&all)?.as_bytes())?);
        staged.push(output_file::stage(&self.folder.join("README.md"), readme(all).as_bytes())?);
        staged.into_iter().try_for_each(Staged::commit)
    }

    /// The experiments that are there.
    fn read(&self) -> Outcome<Vec<Experiment>> {
        let mut found = Vec::new();
        for adapter in folders(&self.folder)? {
            for experiment in folders(&adapter)? {
                let path = experiment.join("data.json");
                // a folder that a run left before it had anything to put there
                if path.is_file() {
                    let bytes = output_file::read_input(&path)?;
                    found.push(serde_json::from_slice(&bytes).map_err(|e| {
                        Failure::input(format!("--keep: {}: is no result: {e}", path.display()))
                    })?);
                }
            }
        }
        Ok(found)
    }
}

fn folders(of: &Path) -> Outcome<Vec<PathBuf>> {
    let unreadable = |e: std::io::Error| Failure::input(format!("--keep {}: {e}", of.display()));
    let mut found = Vec::new();
    for entry in fs::read_dir(of).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path.is_dir() {
            found.push(path);
        }
    }
    Ok(found)
}

/// An experiment's folder, from that of all.
fn place(experiment: &Experiment) -> String {
    format!("{}/{}", slug(&experiment.adapter.name), slug(&experiment.id))
}

/// A name as that of a folder.
fn slug(name: &str) -> String {
    let dashed: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let words: Vec<&str> = dashed.split('-').filter(|word| !word.is_empty()).collect();
    if words.is_empty() { "unknown".to_owned() } else { words.join("-").to_lowercase() }
}

/// The JSON of an experiment with a line for each row, so that two runs can be compared line by line.
fn lines(experiment: &Experiment) -> Outcome<String> {
    let failed = |e: serde_json::Error| Failure::program(format!("data.json of {}: {e}", experiment.id));
    let value = serde_json::to_value(experiment).map_err(failed)?;
    let Value::Object(fields) = value else { return Err(Failure::program("an experiment is an object")) };
    let field = |(name, value): (&String, &Value)| match value {
        Value::Array(items) if !items.is_empty() => {
            let items: Vec<String> = items.iter().map(Value::to_string).collect();
            format!("{}: [\n{}\n]", Value::from(name.as_str()), items.join(",\n"))
        }
        value => format!("{}: {value}", Value::from(name.as_str())),
    };
    Ok(format!("{{\n{}\n}}\n", fields.iter().map(field).collect::<Vec<_>>().join(",\n")))
}

fn index<'e>(all: &'e [Experiment]) -> Outcome<String> {
    let entry = |experiment: &'e Experiment| {
        let Experiment { id, source, preset, adapter, git, command, checks, .. } = experiment;
        let tally = Tally::of(checks);
        Entry {
            id,
            folder: place(experiment),
            adapter,
            source,
            preset,
            command: command.as_deref(),
            git,
            claims: tally.all(),
            hold: tally.hold,
        }
    };
    let entries: Vec<Entry<'e>> = all.iter().map(entry).collect();
    let json = serde_json::to_string_pretty(&entries);
    json.map(|json| json + "\n").map_err(|e| Failure::program(format!("index.json: {e}")))
}

/// The index for people.
fn readme(all: Vec<Experiment>) -> String {
    let mut text = String::from(
        "# Results\n\nTables that `cargo xtask repro --keep` wrote: for each adapter and experiment `data.json` and \
         `table.txt`, with the command and the revision that made them. This page is written anew with each run.\n",
    );
    let mut adapters: Vec<Adapter> = all.iter().map(|experiment| experiment.adapter.clone()).collect();
    adapters.dedup();
    let sections: Vec<Section> =
        all.into_iter().map(|experiment| Section { experiment, ..Section::default() }).collect();
    for adapter in adapters {
        let here: Vec<Section> =
            sections.iter().filter(|section| section.experiment.adapter == adapter).cloned().collect();
        text += &format!("\n## {}\n", adapter.text());
        text.extend(headline::gains(&here).map(|table| format!("\n{}", table.markdown())));
        text += &format!("\n{}", ran(&here).markdown());
    }
    text
}

fn ran(sections: &[Section]) -> Table {
    let columns = ["experiment", "reproduces", "claims", "preset", "revision", "command"].map(Column::left);
    let mut table = Table::new("What ran", columns.into());
    for section in sections {
        let Experiment { id, source, preset, git, command, .. } = &section.experiment;
        let place = place(&section.experiment);
        table.push(vec![
            format!("[{id}]({place}/table.txt)"),
            source.clone(),
            section.verdict(),
            preset.clone(),
            git.clone(),
            command.as_ref().map_or_else(String::new, |command| format!("`{command}`")),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::data::{Attachment, Row};

    fn section(id: &str, adapter: &str, ms: f64) -> Section {
        let row = Row { ms_scatter: Some(ms), rel_rmse: Some(0.5), ..Row::new("sphere", "hybrid") };
        let experiment = Experiment {
            id: id.into(),
            adapter: Adapter { name: adapter.into(), ..Adapter::default() },
            command: Some(format!("cargo xtask repro {id}")),
            git: "0123abc".into(),
            rows: vec![row.clone(), row],
            pictures: vec![Attachment { file: "a.png".into(), caption: "A".into(), alt: "A".into() }],
            ..Experiment::default()
        };
        Section { experiment, ..Section::default() }
    }

    fn files(folder: &Path) -> Vec<String> {
        let mut all = Vec::new();
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            if path.is_dir() {
                all.extend(files(&path).into_iter().map(|file| format!("{name}/{file}")));
            } else {
                all.push(name);
            }
        }
        all.sort();
        all
    }

    #[test]
    fn results_of_several_runs_stand_beside_each_other() {
        let out = tempfile::tempdir().unwrap();
        let folder = out.path().join("docs/results");
        let kept = Kept::open(&folder).unwrap();
        kept.add(&[section("one", "Software (LLVM 15)", 1.0), section("two", "CPU", 2.0)]).unwrap();
        kept.add(&[section("one", "Software (LLVM 15)", 9.0), section("one", "CPU", 3.0)]).unwrap();
        let places = ["cpu/one", "cpu/two", "software-llvm-15/one"];
        let mut expected = vec!["README.md".to_owned(), "index.json".to_owned()];
        expected.extend(
            places.iter().flat_map(|place| ["data.json", "table.txt"].map(|file| format!("{place}/{file}"))),
        );
        expected.sort();
        assert_eq!(files(&folder), expected);

        let text = fs::read_to_string(folder.join("software-llvm-15/one/data.json")).unwrap();
        let data: Experiment = serde_json::from_str(&text).unwrap();
        assert_eq!(data.rows[0].ms_scatter, Some(9.0), "the newer run counts");
        assert!(data.pictures.is_empty(), "what is not kept is not listed");
        assert_eq!(text.lines().filter(|line| line.starts_with("{\"")).count(), 2, "a line for each row");

        let index: Value = serde_json::from_slice(&fs::read(folder.join("index.json")).unwrap()).unwrap();
        let listed: Vec<&str> =
            index.as_array().unwrap().iter().map(|e| e["folder"].as_str().unwrap()).collect();
        assert_eq!(listed, places);
        assert_eq!(
            (&index[0]["git"], &index[0]["command"]),
            (&"0123abc".into(), &"cargo xtask repro one".into())
        );
        let readme = fs::read_to_string(folder.join("README.md")).unwrap();
        assert!(
            readme.contains("[two](cpu/two/table.txt)") && readme.contains("## Software (LLVM 15)"),
            "{readme}"
        );
    }

    #[test]
    fn a_run_that_cannot_be_kept_changes_nothing() {
        let out = tempfile::tempdir().unwrap();
        let kept = Kept::open(out.path()).unwrap();
        kept.add(&[section("one", "CPU", 1.0)]).unwrap();
        let before = fs::read(out.path().join("cpu/one/data.json")).unwrap();
        // the second experiment's place is taken
        fs::write(out.path().join("cpu/two"), "").unwrap();
        assert_eq!(
            kept.add(&[section("one", "CPU", 2.0), section("two", "CPU", 2.0)]).unwrap_err().code(),
            2
        );
        assert_eq!(fs::read(out.path().join("cpu/one/data.json")).unwrap(), before);

        fs::write(out.path().join("cpu/one/data.json"), "{}").unwrap();
        let failure = Kept::open(out.path()).unwrap_err();
        assert!(failure.code() == 2 && failure.to_string().contains("data.json"), "{failure}");
    }
}
