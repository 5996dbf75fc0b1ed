//! What an export is: its name and help, its options, what it refuses and what it writes.

use std::path::Path;

use clap::{ArgMatches, Args, Command};
use output_schema::DatasetHead;

use super::export_folder::ExportSummary;
use super::source::{ExportProgress, ExportSource};
use dataset::Fault;
use optical_bench::split::Split;

/// Entry of an export in the list of all.
#[derive(Debug)]
pub struct ExportFormat {
    /// Its word on the command line and in `export.json`.
    pub name: &'static str,
    /// What it is called in a list of all.
    pub title: &'static str,
    /// Arguments of an example, and what that writes.
    pub example: [&'static str; 2],
    /// Adds its help and its options to a command.
    pub add_options: fn(Command) -> Command,
    /// Reads its options.
    pub read: fn(&ArgMatches) -> Result<Box<dyn Export>, clap::Error>,
}

impl ExportFormat {
    /// Entry of an export.
    pub(super) const fn of<E: Export + Args + 'static>(
        name: &'static str,
        title: &'static str,
        example: [&'static str; 2],
    ) -> Self {
        Self {
            name,
            title,
            example,
            add_options: E::augment_args,
            read: |found| Ok(Box::new(E::from_arg_matches(found)?)),
        }
    }
}

/// A layout of other programs. Its fields are its options, and its documentation is its help.
pub trait Export: std::fmt::Debug + Sync {
    /// The splits that are exported where the user gives this one, or none; all where the list is empty.
    ///
    /// # Errors
    /// Where the layout has no place for it: what to give instead.
    fn splits(&self, given: Option<Split>) -> Result<Vec<Split>, String> {
        Ok(given.into_iter().collect())
    }

    /// Refuses options that have no effect beside others.
    ///
    /// # Errors
    /// Which option, why, and what to do.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    /// Refuses options that have no effect on this dataset.
    ///
    /// # Errors
    /// Which option, why, and what to do.
    fn check_for(&self, _head: &DatasetHead) -> Result<(), String> {
        Ok(())
    }

    /// Writes the export, sample by sample, through an `ExportFolder`.
    ///
    /// # Errors
    /// Where the dataset is damaged or lacks what the layout needs, or the folder cannot be written.
    fn write(&self, source: &ExportSource, out: &Path, progress: ExportProgress) -> Result<ExportSummary, Fault>;
}
